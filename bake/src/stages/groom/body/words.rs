//! Words for body parts in names of joints: English, German, French, Spanish, Italian, Portuguese, Japanese, Chinese,
//! and terms of common rigs.

use super::parts::Region;

/// Words of each part, in lower case without accents. The first part that has a word of the name wins, so specific
/// parts precede general ones: a "back leg" is a leg, "LeftHandIndex" is a hand.
#[rustfmt::skip]
const WORDS: &[(Region, &[&str])] = &[
    (Region::Muzzle, &[
        "muzzle", "snout", "nose", "nostril", "jaw", "mouth", "lip", "lips", "chin", "tongue", "teeth",
        "tooth", "beak", "mandible", "maxilla", "schnauze", "kiefer", "unterkiefer", "oberkiefer", "maul",
        "mund", "nase", "lippe", "kinn", "zunge", "museau", "machoire", "nez", "bouche", "levre", "menton",
        "langue", "hocico", "mandibula", "nariz", "boca", "labio", "lengua", "muso", "mascella", "naso",
        "bocca", "labbro", "mento", "lingua", "focinho", "maxilar", "queixo", "kuchi", "ago", "bizi", "zui",
        "zuiba", "xiaba",
    ]),
    (Region::Face, &[
        "eye", "eyes", "eyelid", "lid", "eyebrow", "brow", "cheek", "auge", "augen", "lidschlag", "braue",
        "wange", "oeil", "yeux", "paupiere", "sourcil", "joue", "ojo", "ojos", "parpado", "ceja", "mejilla",
        "occhio", "palpebra", "guancia", "olho", "sobrancelha", "hitomi", "mabuta", "mayu", "yanjing",
        "meimao",
    ]),
    (Region::Ear, &[
        "ear", "ears", "ohr", "ohren", "oreille", "oreilles", "oreja", "orejas", "orecchio", "orecchia",
        "orelha", "mimi", "erduo",
    ]),
    (Region::Mane, &[
        "mane", "ruff", "ponytail", "hair", "maehne", "mahne", "criniere", "crin", "crines", "criniera",
        "crina", "tategami",
    ]),
    (Region::Tail, &[
        "tail", "schwanz", "schweif", "rute", "queue", "cola", "rabo", "coda", "cauda", "shippo", "weiba",
    ]),
    (Region::Wing, &[
        "wing", "fluegel", "flugel", "aile", "ala", "asa", "tsubasa", "chibang",
    ]),
    (Region::Foot, &[
        "foot", "feet", "paw", "toe", "toes", "hoof", "fetlock", "pastern", "ankle", "hand", "wrist",
        "finger", "fingers", "thumb", "palm", "ball", "claw", "toebase", "fuss", "pfote", "vorderpfote",
        "hinterpfote", "tatze", "huf", "zeh", "zehe", "zehen", "knoechel", "daumen", "pied", "sabot",
        "orteil", "doigt", "cheville", "poignet", "griffe", "pie", "pezuna", "dedo", "mano", "tobillo",
        "muneca", "garra", "piede", "zoccolo", "dito", "caviglia", "polso", "pe", "casco", "mao", "tornozelo",
        "punho", "tekubi", "ashikubi", "yubi", "tsumasaki", "hizume", "jiao", "jiaozhi", "zhua", "shou",
        "shouwan",
    ]),
    (Region::LowerLeg, &[
        "calf", "shin", "forearm", "lowerarm", "lowarm", "lowerleg", "lowleg", "shank", "knee", "elbow",
        "hock", "cannon", "tibia", "fibula", "radius", "ulna", "gaskin", "horselink", "unterschenkel",
        "unterarm", "unterbein", "wade", "knie", "ellenbogen", "ellbogen", "mollet", "tibias", "genou",
        "coude", "jarret", "antebrazo", "pantorrilla", "rodilla", "codo", "avambraccio", "polpaccio",
        "stinco", "ginocchio", "gomito", "antebraco", "panturrilha", "canela", "joelho", "cotovelo", "hiji",
        "hiza", "sune", "xiaotui", "qianbi", "xigai",
    ]),
    (Region::UpperLeg, &[
        "thigh", "upleg", "upperleg", "uparm", "upperarm", "femur", "humerus", "stifle", "oberschenkel",
        "oberarm", "schenkel", "cuisse", "muslo", "coscia", "coxa", "momo", "datui", "shangbi",
    ]),
    (Region::Limb, &[
        "leg", "arm", "limb", "foreleg", "hindleg", "frontleg", "backleg", "bein", "vorderbein", "hinterbein",
        "jambe", "bras", "patte", "pierna", "brazo", "pata", "gamba", "braccio", "zampa", "perna", "braco",
        "ashi", "ude", "tui", "shoubi",
    ]),
    (Region::Shoulder, &[
        "shoulder", "clavicle", "scapula", "collarbone", "collar", "schulter", "schulterblatt",
        "schluesselbein", "epaule", "hombro", "spalla", "ombro", "kata", "jian",
    ]),
    (Region::Neck, &[
        "neck", "cervical", "throat", "hals", "nacken", "kehle", "cou", "gorge", "cuello", "collo", "pescoco",
        "kubi", "bozi",
    ]),
    (Region::Head, &[
        "head", "forehead", "skull", "cranium", "face", "kopf", "schaedel", "schadel", "gesicht", "tete",
        "crane", "cabeza", "testa", "cabeca", "atama", "tou", "toubu",
    ]),
    (Region::Chest, &[
        "chest", "ribcage", "rib", "ribs", "breast", "thorax", "sternum", "brust", "brustkorb", "poitrine",
        "pecho", "petto", "torace", "peito", "mune", "xiong",
    ]),
    (Region::Belly, &[
        "belly", "stomach", "abdomen", "tummy", "bauch", "ventre", "vientre", "barriga", "pancia", "onaka",
        "hara", "duzi",
    ]),
    (Region::Torso, &[
        "spine", "back", "torso", "trunk", "body", "pelvis", "hip", "hips", "waist", "withers", "croup",
        "rump", "root", "wirbelsaeule", "wirbelsaule", "ruecken", "rucken", "becken", "huefte", "hufte",
        "rumpf", "dos", "bassin", "hanche", "colonne", "espalda", "cadera", "columna", "schiena", "bacino",
        "anca", "costas", "quadril", "coluna", "senaka", "koshi", "yao", "kuan", "jizhui",
    ]),
];

/// Words in scripts without word separators. The longest word in the name wins.
#[rustfmt::skip]
const CHARACTERS: &[(Region, &[&str])] = &[
    (Region::Muzzle, &[
        "鼻", "口", "嘴", "顎", "颚", "あご", "下巴", "舌", "歯", "牙齿", "はな", "くち", "吻",
    ]),
    (Region::Face, &[
        "目", "眼", "瞼", "眉", "頬", "まぶた", "まゆ",
    ]),
    (Region::Ear, &[
        "耳", "みみ",
    ]),
    (Region::Mane, &[
        "髪", "头发", "たてがみ", "鬃",
    ]),
    (Region::Tail, &[
        "尾", "しっぽ", "尻尾", "尾巴",
    ]),
    (Region::Wing, &[
        "翼", "翅", "つばさ",
    ]),
    (Region::Foot, &[
        "手首", "手腕", "足首", "足先", "つま先", "爪", "指", "蹄", "脚掌", "脚踝", "手", "脚", "腳", "ひづめ", "趾", "親指",
    ]),
    (Region::LowerLeg, &[
        "ひざ", "膝", "ひじ", "肘", "すね", "脛", "小腿", "前臂", "前腕",
    ]),
    (Region::UpperLeg, &[
        "太もも", "大腿", "上腕", "上臂", "もも",
    ]),
    (Region::Limb, &[
        "足", "腿", "腕", "手臂", "胳膊", "前足", "後足", "前脚", "後脚", "前腿", "后腿",
    ]),
    (Region::Shoulder, &[
        "肩", "肩甲", "锁骨", "鎖骨",
    ]),
    (Region::Neck, &[
        "首", "頸", "颈", "脖", "くび",
    ]),
    (Region::Head, &[
        "頭", "头", "あたま", "顔", "脸",
    ]),
    (Region::Chest, &[
        "胸", "むね",
    ]),
    (Region::Belly, &[
        "腹", "肚", "おなか",
    ]),
    (Region::Torso, &[
        "背", "腰", "脊", "骨盆", "骨盤", "髋", "臀", "上半身", "下半身", "体", "センター", "身体",
    ]),
];

/// Words for control handles. The handle of a limb is at its end.
const HANDLES: &[&str] = &["ik", "pole", "target"];

/// Returns the part that a name denotes; `None` if it contains no known word.
pub(super) fn region(name: &str) -> Option<Region> {
    let words = words(name);
    let pairs = words.windows(2).map(<[String]>::concat);
    let all: Vec<String> = words.iter().cloned().chain(pairs).collect();
    let has = |known: &&str| all.iter().any(|word| word == *known);
    let found = WORDS.iter().find(|(_, known)| known.iter().any(has)).map(|(region, _)| *region);
    let spelt = || {
        let within = |(region, known): &(Region, &'static [&'static str])| {
            known
                .iter()
                .filter(|word| name.contains(**word))
                .map(|word| (word.chars().count(), *region))
                .max_by_key(|found| found.0)
        };
        // If words have the same length, the earlier part wins.
        CHARACTERS.iter().filter_map(within).rev().max_by_key(|found| found.0).map(|found| found.1)
    };
    let is_handle = HANDLES.iter().any(has);
    found.or_else(spelt).map(|region| if is_handle && region == Region::Limb { Region::Foot } else { region })
}

/// Returns the last number in a name: 6 in `DEF-spine.006`.
pub(super) fn number(name: &str) -> Option<u32> {
    name.split(|c: char| !c.is_ascii_digit()).rfind(|digits| !digits.is_empty())?.parse().ok()
}

/// Splits a name into words in lower case without accents, at non-letters and where an upper-case letter follows a
/// lower-case one.
pub(super) fn words(name: &str) -> Vec<String> {
    let folded: Vec<char> = name.chars().flat_map(fold).collect();
    let mut words: Vec<String> = Vec::new();
    let mut within = false;
    for (i, c) in folded.iter().enumerate() {
        if !c.is_alphabetic() {
            within = false;
            continue;
        }
        let before = i.checked_sub(1).and_then(|b| folded.get(b));
        let after = folded.get(i + 1);
        // "LeftArm" is split between t and A, "IKFront" between K and F.
        let begins = c.is_uppercase()
            && (before.is_some_and(|b| b.is_lowercase())
                || (before.is_some_and(|b| b.is_uppercase()) && after.is_some_and(|a| a.is_lowercase())));
        if begins || !within {
            words.push(String::new());
        }
        within = true;
        if let Some(word) = words.last_mut() {
            word.extend(c.to_lowercase());
        }
    }
    words
}

/// Returns a letter without its accent. Full-width letters become half-width.
fn fold(c: char) -> impl Iterator<Item = char> {
    let plain = match c {
        '\u{ff01}'..='\u{ff5e}' => char::from_u32(c as u32 - 0xfee0).unwrap_or(c),
        'à' | 'á' | 'â' | 'ã' | 'ä' => 'a',
        'À' | 'Á' | 'Â' | 'Ã' | 'Ä' => 'A',
        'è' | 'é' | 'ê' | 'ë' => 'e',
        'È' | 'É' | 'Ê' | 'Ë' => 'E',
        'ì' | 'í' | 'î' | 'ï' => 'i',
        'ò' | 'ó' | 'ô' | 'õ' | 'ö' => 'o',
        'Ò' | 'Ó' | 'Ô' | 'Õ' | 'Ö' => 'O',
        'ù' | 'ú' | 'û' | 'ü' => 'u',
        'Ù' | 'Ú' | 'Û' | 'Ü' => 'U',
        'ç' => 'c',
        'Ç' => 'C',
        'ñ' => 'n',
        'Ñ' => 'N',
        'œ' => 'o',
        'ß' => 's',
        other => other,
    };
    let second = match c {
        'ß' => Some('s'),
        'œ' => Some('e'),
        _ => None,
    };
    std::iter::once(plain).chain(second)
}
