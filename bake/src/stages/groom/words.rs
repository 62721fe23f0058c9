//! Names of hairless body parts and of worn things, in the languages in which models are named.
//!
//! The languages are English, German, French, Spanish, Italian, Portuguese, Japanese and Chinese. Letters have no
//! accents, except `ñ` (`una` is not a nail). Words are singular if their plural adds an `s`. Words that mean something
//! furred in another language or trade are omitted on purpose: `muzzle`, `coat`, `canine`, `gum` (the colour), `rein`
//! (German: pure), `robe` (French: a horse's coat), `hana`.

/// Words for one kind of thing, and the largest share of the mesh surface that it may cover.
pub(super) struct BareWords {
    /// Largest share of the mesh's area, 0..=1. A larger part is more likely the whole animal.
    pub most: f32,
    /// Words, folded as by [`super::names::words`].
    pub words: &'static [&'static str],
}

/// Limit for body parts. A cartoon's eyes, a stag's antlers and a calf's hooves are large.
const PART: f32 = 0.3;
/// Limit for noses. A nose that covers more is the furred snout around it.
pub(super) const NOSE: f32 = 0.1;
/// Limit for clothes, which may cover most of a body, but hardly all of it.
const WORN: f32 = 0.7;

/// Eyes and their parts.
#[rustfmt::skip]
pub(super) const EYES: &[&str] = &[
    "eye", "eyeball", "eyel", "eyer", "iris", "irises", "pupil", "cornea", "sclera", "retina", "tearline",
    "auge", "augen", "augapfel", "pupille", "pupillen", "hornhaut",
    "oeil", "yeux", "cornee", "sclere",
    "ojo", "pupila", "esclera", "occhio", "occhi", "iride", "pupilla", "olho",
    "hitomi", "medama", "shirome", "kurome", "yanqiu", "yanzhu", "tongkong",
    "目", "眼", "瞳", "目玉", "眼球", "瞳孔", "虹彩", "角膜", "強膜", "白目", "黒目", "眼睛", "眼珠", "眼白", "虹膜", "巩膜", "鞏膜", "ひとみ", "アイ",
];

/// Bare parts and things.
#[rustfmt::skip]
pub(super) const BARE: &[BareWords] = &[
    BareWords { most: PART, words: EYES },
    // Teeth, tongue and inside of the mouth.
    BareWords { most: PART, words: &[
        "tooth", "teeth", "fang", "tusk", "molar", "incisor", "tongue", "gums", "palate", "innermouth", "mouthbag",
        "mouthcavity",
        "zahn", "zahne", "zaehne", "reisszahn", "reisszahne", "zunge", "zahnfleisch", "gaumen", "mundhohle",
        "mundhoehle",
        "dent", "croc", "langue", "gencive", "diente", "colmillo", "lengua", "encia",
        "dente", "denti", "zanna", "zanne", "lingua", "gengiva", "gengive", "presa",
        "kiba", "haguki", "yachi", "shetou",
        "歯", "牙", "舌", "歯茎", "歯ぐき", "奥歯", "前歯", "口内", "口腔", "口の中", "牙齿", "牙齒", "齿", "舌头", "舌頭", "牙龈", "牙齦", "べろ", "ベロ",
    ] },
    // Claws, hooves, horns and beaks.
    BareWords { most: PART, words: &[
        "claw", "talon", "nail", "toenail", "fingernail", "hoof", "hooves", "horn", "antler", "beak", "pad", "pawpad",
        "toebean",
        "kralle", "krallen", "klaue", "klauen", "nagel", "naegel", "huf", "hufe", "horner", "hoerner", "geweih",
        "schnabel",
        "griffe", "ongle", "sabot", "corne", "ramure", "bec",
        "garra", "uña", "pezuña", "cuerno", "cornamenta", "pico",
        "artiglio", "artigli", "unghia", "unghie", "zoccolo", "zoccoli", "corno", "corna", "becco",
        "unha", "casco", "chifre", "bico",
        "tsume", "hizume", "tsuno", "kuchibashi", "zhijia", "niaozui",
        "爪", "蹄", "角", "嘴", "喙", "鉤爪", "かぎ爪", "ひづめ", "つの", "ツノ", "枝角", "くちばし", "クチバシ", "指甲", "趾甲", "利爪", "蹄子", "马蹄",
        "馬蹄", "犄角", "牛角", "羊角", "鹿角", "鸟嘴", "鳥嘴",
    ] },
    // Noses.
    BareWords { most: NOSE, words: &[
        "nose", "nostril", "nase", "nuster", "nustern", "nuester", "nuestern", "nez", "truffe", "narine", "nariz",
        "fosa", "naso", "narice", "narici", "narina", "bizi", "bikong", "鼻", "鼻子", "鼻孔", "鼻头", "鼻頭", "鼻先", "はな",
    ] },
    // Worn things and their materials.
    BareWords { most: WORN, words: &[
        "cloth", "clothes", "clothing", "garment", "shirt", "tshirt", "pants", "trousers", "jeans", "shorts", "skirt",
        "dress", "jacket", "vest", "scarf", "hat", "helmet", "glove", "sock", "shoe", "boot", "horseshoe", "collar",
        "dogtag", "belt", "buckle", "strap", "saddle", "bridle", "reins", "halter", "harness", "stirrup", "leash",
        "armor", "armour", "ribbon", "bowtie", "leather", "metal", "glass", "glasses", "goggles", "sunglasses", "lens",
        "lenses",
        "kleid", "kleidung", "hemd", "hose", "rock", "jacke", "schal", "hut", "helm", "mutze", "muetze", "schuh",
        "schuhe", "stiefel", "hufeisen", "halsband", "gurtel", "guertel", "sattel", "zaumzeug", "zugel", "zuegel",
        "trense", "halfter", "geschirr", "rustung", "ruestung", "metall", "glas", "brille", "linse",
        "vetement", "chemise", "pantalon", "jupe", "veste", "echarpe", "chapeau", "casque", "gant", "chaussure",
        "botte", "collier", "ceinture", "selle", "bride", "renes", "harnais", "verre", "lunettes", "lentille",
        "ropa", "camisa", "falda", "chaqueta", "bufanda", "sombrero", "guante", "zapato", "bota", "cinturon", "montura",
        "brida", "riendas", "arnes", "vidrio", "gafas", "lente",
        "vestito", "vestiti", "camicia", "pantaloni", "gonna", "giacca", "sciarpa", "cappello", "guanto", "guanti",
        "scarpa", "scarpe", "stivale", "stivali", "collare", "cintura", "sella", "briglia", "briglie", "metallo",
        "vetro", "occhiali",
        "roupa", "calca", "saia", "jaqueta", "cachecol", "chapeu", "luva", "sapato", "coleira", "cinto", "sela",
        "redea", "vidro", "oculos",
        "kutsu", "kubiwa", "megane", "kinzoku", "yifu", "xiezi", "xiangquan", "jinshu", "boli",
        "服", "衣服", "衣装", "靴", "帽子", "首輪", "手綱", "鞍", "馬具", "金属", "眼鏡", "シャツ", "ズボン", "スカート", "ベルト", "リボン", "マフラー",
        "メガネ", "めがね", "ガラス", "レンズ", "メタル", "鞋", "鞋子", "靴子", "衬衫", "襯衫", "裤子", "褲子", "裙子", "项圈", "項圈", "腰带", "腰帶", "围巾",
        "圍巾", "马鞍", "馬鞍", "缰绳", "韁繩", "马具", "金屬", "玻璃", "眼镜", "铃铛", "鈴鐺", "鈴",
    ] },
];

/// The mouth: bare only beside a word of [`INSIDE`], because alone it can also mean the furred lips.
pub(super) const MOUTH: BareWords =
    BareWords { most: PART, words: &["mouth", "jaw", "mund", "maul", "bouche", "gueule", "boca", "bocca", "kuchi"] };

/// Words that mark the inside of a mouth.
#[rustfmt::skip]
pub(super) const INSIDE: &[&str] = &[
    "inside", "inner", "interior", "in", "cavity", "bag", "innen", "innere", "interieur", "dentro", "interno",
    "interna", "uchi",
];

/// Snouts. Such a name means the furred snout as often as the bare nose on it. A part with such a name is never
/// classified as bare by its shape.
pub(super) const SNOUT: &[&str] =
    &["muzzle", "snout", "schnauze", "museau", "mufle", "hocico", "morro", "muso", "focinho", "hanazura", "kuchimoto"];

/// Words for eyelashes. In the name of a joint they mean the lashes alone, which are bare; in other names they keep the
/// lids around them furred ([`FURRED`]).
#[rustfmt::skip]
pub(super) const LASHES: &[&str] = &[
    "lash", "lashes", "eyelash", "eyelashes", "wimper", "wimpern", "cils", "pestaña", "pestañas", "ciglia", "cilios",
    "matsuge", "まつげ", "睫毛",
];

/// Words that keep a part furred, whatever else its name contains: words for hair, skin and the surroundings of bare
/// parts.
#[rustfmt::skip]
pub(super) const FURRED: &[&str] = &[
    "fur", "furry", "body", "skin", "coat", "hair", "hairs", "hide", "pelt", "wool", "fleece", "mane", "tail", "fluff",
    "plush", "feather", "plumage", "brow", "brows", "lash", "lashes", "lid", "eyelid", "eyebrow", "eyelash", "socket",
    "area", "around", "bridge", "ring", "patch", "spot", "corner",
    "fell", "haut", "korper", "koerper", "haar", "haare", "pelz", "mahne", "maehne", "wolle", "schweif", "lider",
    "wimper", "wimpern", "braue", "brauen",
    "fourrure", "corps", "peau", "poil", "pelage", "robe", "laine", "criniere", "plume", "cil", "sourcil", "paupiere",
    "piel", "cuerpo", "pelo", "pelaje", "manto", "lana", "crin", "crines", "pestaña", "ceja", "parpado",
    "pelle", "corpo", "pelliccia", "criniera", "ciglia", "palpebra",
    "pele", "pelagem", "crina", "juba", "cilio", "sobrancelha",
    "kegawa", "karada", "hada", "maofa", "pimao", "shenti", "pifu",
];

/// Words for furred parts in languages that do not separate words by spaces. They match anywhere within a run of
/// characters.
#[rustfmt::skip]
pub(super) const FURRED_WITHIN: &[&str] = &[
    "毛", "体", "體", "皮", "肌", "髪", "发", "髮", "羽", "眉", "睫", "瞼", "睑", "まつげ", "まゆ", "まぶた", "からだ", "はだ",
];

/// Position words that are joined to other words, as in `lefteye`.
pub(super) const POSITION_WORDS: &[&str] =
    &["left", "right", "upper", "lower", "inner", "outer", "front", "back", "material", "mat"];

/// Characters for position and number before or after other words: left, right, both, up, down.
pub(super) const POSITION_CHARACTERS: &[char] = &['左', '右', '両', '两', '兩', '双', '上', '下'];
