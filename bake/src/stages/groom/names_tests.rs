use super::super::words::{FURRED_WITHIN, INSIDE};
use super::*;

fn said(name: &str) -> NameMeaning {
    meaning_of_words(&words(name))
}

#[test]
fn material_names_are_split_into_words() {
    for name in ["LeftEye.001", "left_eye", "LEFT-EYE2", "left eye", "Left.Eye", "ＬｅｆｔＥｙｅ"] {
        assert_eq!(words(name), ["left", "eye"], "{name}");
    }
    assert_eq!(words("LODEyeM"), ["lod", "eye", "m"]);
    assert_eq!(words("犬の目マテリアル_L"), ["犬の目", "マテリアル", "l"]);
    // Accents are written as one character or as combining characters, depending on the system.
    assert_eq!(words("Zähne Œil uña"), ["zahne", "oeil", "uña"]);
    assert_eq!(words("Za\u{308}hne un\u{303}a"), ["zahne", "uña"]);
    assert!(words("123_.-").is_empty() && words("").is_empty());
}

#[test]
fn bare_part_names_are_known_in_eight_languages() {
    for name in [
        "Eyes_Black",
        "M_Fox_Eye",
        "eyeL",
        "lefteye",
        "EyeballMat",
        "Iris",
        "Teeth.001",
        "tongue",
        "Claws",
        "toenails",
        "Hooves",
        "Horns",
        "Antlers",
        "Beak",
        "Nose",
        "Nostrils",
        "Lens",
        "Glasses",
        "Shirt",
        "Boots_01",
        "Collar",
        "Saddle",
        "Metal",
        "inner_mouth",
        "MouthInside",
        "PawPads",
        "Auge",
        "Zähne",
        "Zaehne",
        "Zunge",
        "Krallen",
        "Hufe",
        "Hörner",
        "Geweih",
        "Schnabel",
        "Nase",
        "Halsband",
        "Sattel",
        "Gürtel",
        "Œil",
        "yeux",
        "Dents",
        "Langue",
        "Griffes",
        "Sabots",
        "Cornes",
        "Truffe",
        "Collier",
        "Selle",
        "Vêtements",
        "Ojos",
        "Dientes",
        "Lengua",
        "Uñas",
        "Pezuñas",
        "Cuernos",
        "Pico",
        "Nariz",
        "Camisa",
        "Cinturón",
        "Occhi",
        "denti",
        "lingua",
        "Artigli",
        "Zoccoli",
        "Corna",
        "Becco",
        "Naso",
        "Sella",
        "Olhos",
        "dentes",
        "língua",
        "Unhas",
        "Chifres",
        "Bico",
        "Coleira",
        "目",
        "右目",
        "犬の目",
        "白目",
        "ひとみ",
        "歯",
        "舌",
        "爪_L",
        "ひづめ",
        "つの",
        "くちばし",
        "鼻",
        "首輪",
        "メガネ",
        "hitomi",
        "kuchibashi",
        "眼睛",
        "狗的眼睛",
        "牙齿",
        "舌头",
        "指甲",
        "蹄",
        "鹿角",
        "鼻子",
        "项圈",
        "马鞍",
        "yachi",
        "yǎnqiú",
    ] {
        assert!(matches!(said(name), NameMeaning::Bare { .. }), "{name}: {:?}", said(name));
    }
    for name in [
        "Main",
        "Material.001",
        "Black",
        "Muzzle",
        "Mouth",
        "Snout",
        "Hornet",
        "Snail",
        "Glassy",
        "Rasta",
        "Clawdia",
        "una",
        "Corner2D",
        "犬",
        "",
    ] {
        assert!(!matches!(said(name), NameMeaning::Bare { .. }), "{name}");
    }
}

#[test]
fn names_of_fur_and_surroundings_of_bare_parts_are_furred() {
    for name in [
        "Eye_Brow",
        "Eyebrows",
        "eyelashes",
        "EyeLids",
        "NoseBridge",
        "eye_socket",
        "BodyHorns",
        "NoseFur",
        "Skin_Claws",
        "coat",
        "Fell_Nase",
        "眉毛",
        "まつげ",
        "眼皮",
        "角色身体",
        "鼻の毛",
    ] {
        assert_eq!(said(name), NameMeaning::Furred, "{name}");
    }
}

#[test]
fn largest_share_of_a_nose_is_below_that_of_clothing() {
    let most = |name| match said(name) {
        NameMeaning::Bare { most } => most,
        other => panic!("{name}: {other:?}"),
    };
    assert!(most("Nose") < most("Horns") && most("Horns") < most("Shirt"));
    // If a name has two meanings, the one with the smaller maximum area wins.
    assert_eq!(most("ShirtNose"), most("Nose"));
}

#[test]
fn word_tables_are_folded_and_free_of_duplicates() {
    let bare = BARE.iter().flat_map(|kind| kind.words).copied();
    let all: Vec<&str> = bare.chain(MOUTH.words.iter().chain(FURRED).copied()).collect();
    for (i, word) in all.iter().enumerate() {
        assert!(!all[..i].contains(word), "{word} stands there twice");
        // A word that is not in the form returned by `words` would never match.
        let folded = words(word);
        assert!(folded == [*word] || folded.len() > 1 && !word.is_ascii(), "{word} is folded to {folded:?}");
    }
    assert!(
        INSIDE.iter().all(|word| words(word) == [*word]) && FURRED_WITHIN.iter().all(|word| words(word) == [*word])
    );
}
