use crate::*;
use proptest::prelude::*;

words! {
    /// Drawing method.
    Drawn {
        /// Draws everything.
        #[default]
        Full = "full",
        /// With
        /// little.
        Sparse = "sparse" was "thin",
    }
}

params! {
    /// `[picture]`: the picture.
    Picture in picture {
        /// Drawing method.
        drawn: Drawn = Drawn::Full;
        /// Width of the picture, texels.
        width: u32 = 64, in 16..=2048, as PowerOfTwo;
        /// Layers to draw: many are smooth.
        layers: Option<u32> = None, in 2..=256, or "all", needs "picture.drawn!=sparse", needs "fur";
        /// Whether the picture is visible.
        enabled: bool = true, was "visible";
    }
}

params! {
    /// `[light]`: the light.
    /// There is one.
    Light in light, needs "picture.enabled=true" {
        /// Direction towards the light.
        direction: [f32; 3] = [0.0, 1.0, 0.0], in -1e6..=1e6, clears position_m;
        /// Position of the light, metres.
        position_m: Option<[f32; 3]> = None, in -1e6..=1e6;
        /// Strength of the light.
        strength: f32 = 1.0, in 0.001..=10.0, was "picture.exposure", needs "light.position_m!=none";
        /// Colour of the light.
        color: SrgbColor = SrgbColor::hex(0xff_00_00);
        /// Names of objects that receive the light.
        seen_by: Vec<String> = Vec::new();
        /// Names of objects that do not receive the light.
        hidden_from: Option<Vec<String>> = None;
        /// Random seed.
        seed: u64 = 1, in 0..=i64::MAX as u64;
    }
}

tables! {
    /// All settings.
    pub struct Look, such as "light.strength=2" {
        /// The picture.
        picture: Picture,
        /// The light.
        light: Light,
    }
}

fn after(words: &[&str]) -> Look {
    let mut look = Look::default();
    words.iter().for_each(|word| set(&mut look, word).unwrap());
    look
}

#[test]
fn knobs_without_effect_name_the_unmet_condition() {
    let unmet = |words: &[&str], name: &str, holds: bool| {
        let look = after(words);
        let all = || Look::TABLES.iter().flat_map(|table| table.knobs.iter().map(move |knob| (table, knob)));
        let value = |other: &str| all().find(|(_, knob)| knob.name == other)?.1.value(&look);
        let (table, knob) = all().find(|(_, knob)| knob.name == name).unwrap();
        table.unmet(knob, value, |condition| holds && condition == "fur")
    };
    assert_eq!(unmet(&[], "picture.width", false), None);
    assert_eq!(unmet(&[], "picture.layers", false), Some("fur"));
    assert_eq!(unmet(&[], "picture.layers", true), None);
    assert_eq!(unmet(&["picture.drawn=sparse"], "picture.layers", true), Some("picture.drawn!=sparse"));
    assert_eq!(unmet(&[], "light.direction", false), None);
    assert_eq!(unmet(&["picture.enabled=false"], "light.strength", false), Some("picture.enabled=true"));
    assert_eq!(unmet(&[], "light.strength", false), Some("light.position_m!=none"));
    assert_eq!(unmet(&["light.position_m=[0, 1, 0]"], "light.strength", false), None);
}

#[test]
fn every_key_of_every_table_is_checked() {
    for knob in knobs::<Look>() {
        let mut look = Look::default();
        validate(&look).unwrap();
        match knob.name {
            "picture.width" => look.picture.width = 65,
            "picture.layers" => look.picture.layers = Some(1),
            "light.direction" => look.light.direction[2] = f32::NAN,
            "light.position_m" => look.light.position_m = Some([2e6, 0.0, 0.0]),
            "light.strength" => look.light.strength = 0.0,
            "light.color" => look.light.color.0[1] = 1.5,
            "light.seed" => look.light.seed = u64::MAX,
            // Every value of these types is in range.
            "picture.drawn" | "picture.enabled" | "light.seen_by" | "light.hidden_from" => continue,
            other => panic!("{other} has no wrong value here"),
        }
        assert_eq!(validate(&look).unwrap_err().name, knob.name);
        assert!(look.picture.validate().is_err() != look.light.validate().is_err(), "{} alone is wrong", knob.name);
    }
}

#[test]
fn later_of_two_exclusive_keys_wins() {
    let lamp = after(&["light.direction=0,0,1", "light.position_m=1,2,3"]);
    assert_eq!(lamp.light.position_m, Some([1.0, 2.0, 3.0]));
    let sun = after(&["light.position_m=1,2,3", "light.direction=[0, 0, 1]"]);
    assert_eq!((sun.light.position_m, sun.light.direction), (None, [0.0, 0.0, 1.0]));
    let text = to_toml(&lamp);
    let mut again = sun;
    read(&mut again, &text).unwrap();
    assert_eq!(again, lamp, "{text}");
}

#[test]
fn unset_list_differs_from_an_empty_one() {
    let open = after(&[]);
    assert_eq!(open.light.hidden_from, None);
    assert!(!to_toml(&open).contains("hidden_from") && to_documented_toml(&open).contains("# hidden_from =\n"));
    let nobody = after(&["light.hidden_from=[]"]);
    assert_eq!(nobody.light.hidden_from, Some(Vec::new()));
    let some = after(&["light.hidden_from=Cat"]);
    assert_eq!(some.light.hidden_from, Some(vec!["Cat".to_owned()]));
    for look in [open, nobody, some] {
        let mut again = Look::default();
        read(&mut again, &to_toml(&look)).unwrap();
        assert_eq!(again, look);
    }
    let error = set(&mut Look::default(), "light.hidden_from=[1]").unwrap_err().to_string();
    assert_eq!(error, "light.hidden_from: found [1], expected a list of strings");
}

#[test]
fn optional_keys_have_a_word_for_unset() {
    let mut look = after(&["picture.layers=8"]);
    assert_eq!(look.picture.layers, Some(8));
    assert!(to_toml(&look).contains("layers = 8\n"));
    set(&mut look, "picture.layers=all").unwrap();
    assert_eq!(look.picture.layers, None);
    assert!(to_toml(&look).contains("layers = \"all\"\n"));
    let error = set(&mut look, "picture.layers=1").unwrap_err().to_string();
    assert_eq!(error, "picture.layers: found 1, expected \"all\" or an integer 2..=256");
}

#[test]
fn command_line_values_are_parsed_leniently() {
    let look = after(&[
        "light.strength=.5",
        "light.seed=007",
        "picture.enabled=off",
        "light.color=#00ff00",
        "light.seen_by=a",
        "picture.drawn=sparse",
        "picture.width=32",
    ]);
    assert_eq!((look.light.strength, look.light.seed, look.picture.enabled), (0.5, 7, false));
    assert_eq!((look.light.color.0, look.light.seen_by.as_slice()), ([0.0, 1.0, 0.0], &["a".to_owned()][..]));
    assert_eq!((look.picture.drawn, look.picture.width), (Drawn::Sparse, 32));
    assert!(!after(&["picture.enabled=false"]).picture.enabled);
    for (word, message) in [
        ("light.strength=1,2", "found the string \"1,2\", expected a number 0.001..=10"),
        ("light.strength=nan", "found NaN"),
        ("light.direction=1,2", "found [1, 2], expected three numbers"),
        ("light.direction=1,b,2", "found the string \"1,b,2\""),
        ("light.seed=-1", "found -1"),
        ("light.strength", "found no '=', expected key=value, such as light.strength=2"),
        ("light.position=1,2,3", "did you mean light.position_m?"),
        ("picture.strength=1", "did you mean light.strength?"),
        ("lihgt.strenght=1", "did you mean light.strength?"),
        ("light.xyz=1", "light.xyz: unknown key; light has direction, position_m, strength, color, "),
        ("xyz.xyz=1", "unknown key, expected one such as light.strength"),
    ] {
        let error = set(&mut Look::default(), word).unwrap_err().to_string();
        assert!(error.contains(message), "{word}: {error}");
    }
}

#[test]
fn deprecated_names_are_read_and_written_as_current_ones() {
    let mut look = Look::default();
    read(&mut look, "[picture]\nvisible = false\ndrawn = \"thin\"\n").unwrap();
    assert_eq!((look.picture.enabled, look.picture.drawn), (false, Drawn::Sparse));
    let text = to_toml(&look);
    assert!(text.contains("enabled = false\n") && text.contains("drawn = \"sparse\"\n"), "{text}");
    assert_eq!(after(&["picture.visible=off", "picture.drawn=thin"]), look);
    // `exposure` has moved to another table.
    assert_eq!(after(&["picture.exposure=2"]), after(&["light.strength=2"]));
    let error = set(&mut look, "picture.visible=2").unwrap_err().to_string();
    assert_eq!(error, "picture.visible: found 2, expected true or false");
}

#[test]
fn parsed_tables_are_read_like_text() {
    let read_before = |text: &str| {
        let mut look = Look::default();
        read_table(&mut look, &text.parse::<toml::Table>().unwrap()).map(|()| look)
    };
    let look = read_before("[light]\nstrength = 2\nseen_by = [\"a\"]\n[picture]\nvisible = false").unwrap();
    assert_eq!(look, after(&["light.strength=2", "light.seen_by=a", "picture.enabled=off"]));
    for (text, message) in [
        ("[light]\nstrength = 20", "light.strength: found 20, expected a number 0.001..=10"),
        ("[lihgt]", "lihgt: unknown table; did you mean [light]? Tables: picture, light"),
        ("light = 3", "light: found 3, expected a table"),
        ("light = { strenght = 3 }", "light.strenght: unknown key; did you mean light.strength?"),
        ("light = { seed = 2021-01-01 }", "light.seed: found a date, expected an integer 0..=9223372036854775807"),
    ] {
        assert_eq!(read_before(text).unwrap_err().to_string(), message);
        // From a text, the message is the same and includes the line.
        assert!(read(&mut Look::default(), text).unwrap_err().to_string().ends_with(message), "{text}");
    }
}

#[test]
fn controls_follow_from_type_and_range() {
    let control = |name: &str| (knobs::<Look>().find(|k| k.name == name).unwrap().control)();
    assert_eq!(control("picture.enabled"), Control::Toggle);
    assert_eq!(control("picture.width"), Control::PowerOfTwo { least: 16, most: 2048 });
    let layers = Control::Number { least: 2.0, most: 256.0, whole: true, logarithmic: false };
    assert_eq!(control("picture.layers"), layers);
    assert!(matches!(control("light.strength"), Control::Number { logarithmic: true, whole: false, .. }));
    assert_eq!(control("light.color"), Control::Color);
    assert_eq!(control("light.seen_by"), Control::Text);
    assert_eq!(control("light.position_m"), Control::Vector { len: 3, least: -1e6, most: 1e6 });
    let Control::Choice([full, sparse]) = control("picture.drawn") else { panic!("two words") };
    assert_eq!((full.word, sparse.word, sparse.doc.trim()), ("full", "sparse", "With\n little."));
}

#[test]
fn reference_page_is_complete_and_fits_120_columns() {
    let page = reference_page::<Look>("Looks", &["What a look says."], |key| {
        (key == "light.position_m").then(|| "![drawn](drawn.png)".to_owned())
    });
    assert!(page.starts_with("# Looks\n\nWhat a look says.\n\n## `[picture]`\n\nThe picture.\n"), "{page}");
    for part in [
        "- **`layers`**: \"all\" or an integer 2..=256; default `\"all\"`.\n  Layers to draw: many are smooth.\n",
        "  - `sparse`: With little.\n",
        "- **`position_m`**: three numbers -1000000..=1000000 in brackets; default left out.\n",
        "## `[light]`\n\nThe light. There is one.\n",
        "\n\n  ![drawn](drawn.png)\n\n- **`",
    ] {
        assert!(page.contains(part), "{part}\n{page}");
    }
    for knob in knobs::<Look>() {
        assert!(page.contains(&format!("- **`{}`**: ", knob.key())), "{}", knob.name);
    }
    assert_eq!(page.matches("![drawn]").count(), 1, "{page}");
    assert!(page.lines().all(|line| line.chars().count() <= 120), "{page}");
}

#[test]
fn notes_are_written_directly_above_their_key() {
    let look = Look::default();
    let note = |knob: &Knob| {
        if knob.key() == "enabled" { vec!["one\ntwo".to_owned(), "three".to_owned()] } else { Vec::new() }
    };
    let text = to_noted_toml(&look, note);
    let line = format!("# one\n# two\n# three\nenabled = {}\n", look.picture.enabled);
    assert!(text.contains(&line), "{text}");
    assert_eq!(text.replace("# one\n# two\n# three\n", ""), to_documented_toml(&look));
}

proptest! {
    #[test]
    fn parameters_survive_a_toml_round_trip(
        layers in prop::option::of(2u32..=256),
        strength in 0.001f32..=10.0,
        enabled: bool,
        names: Vec<String>,
    ) {
        let mut look = Look::default();
        look.picture.layers = layers;
        look.picture.enabled = enabled;
        look.light.strength = strength;
        look.light.seen_by = names;
        for text in [to_toml(&look), to_documented_toml(&look), format!("\u{feff}{}", to_toml(&look))] {
            let mut again = Look::default();
            read(&mut again, &text).unwrap();
            prop_assert_eq!(&again, &look, "{}", text);
        }
    }

    #[test]
    fn parameter_parser_never_panics(text in "\\PC{0,40}", key in "[a-z_.]{0,12}", value in "\\PC{0,12}") {
        let _ = read(&mut Look::default(), &text);
        let _ = read(&mut Look::default(), &format!("[light]\n{key} = {value}"));
        let _ = set(&mut Look::default(), &text);
        let _ = set(&mut Look::default(), &format!("light.{key}={value}"));
    }
}
