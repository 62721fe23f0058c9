use super::*;
#[cfg(feature = "draw")]
use glam::Vec3;
use pelage_params::{Control, knobs};

fn set(words: &[&str]) -> Look {
    let mut look = Look::default();
    for word in words {
        look.set(word).unwrap_or_else(|error| panic!("{word}: {error}"));
    }
    look
}

fn short(flag: &str) -> &'static ShortForm {
    SHORT_FORMS.iter().chain([&SAMPLES]).find(|short| short.flag == flag).unwrap()
}

#[test]
fn every_short_form_sets_a_different_knob() {
    let all: Vec<_> = SHORT_FORMS.iter().chain([&SAMPLES]).collect();
    for (i, short) in all.iter().enumerate() {
        let elsewhere = cfg!(not(feature = "study")) && short.key.starts_with("study.");
        assert!(short.knob().is_some() != elsewhere, "--{} sets {}, which is no key", short.flag, short.key);
        assert!(all[..i].iter().all(|other| other.flag != short.flag && other.key != short.key), "{short:?}");
    }
    // Users of flags would overlook a knob without a short form. False colours are exempt: they are for debugging and
    // are set by their key.
    for knob in knobs::<Look>().filter(|knob| knob.name != "fur.show") {
        assert!(all.iter().any(|short| short.key == knob.name), "{} has no short form", knob.name);
    }
}

#[test]
fn flags_still_accept_their_values() {
    let mut look = Look::default();
    for (flag, word) in [
        ("size", "64X32"),
        ("style", "bare"),
        ("samples", "4"),
        ("point-light", "-1,0,2"),
        ("fill-light", "-2,0,0/0.25"),
        ("fill-light", "0,1,0"),
        ("layers", "8"),
        ("detail", "1.5"),
        ("self-shadow", "off"),
        ("penumbra", ".5"),
        ("shadow-map", "256"),
        ("shadow-layers", "4"),
        ("shadow-shrink", "16"),
        ("background", "10,20,255"),
        ("ink-width", "0.02m"),
        ("ink-mist", "5,60"),
        ("ink-color", "0,0,255"),
    ] {
        short(flag).apply(&mut look, word).unwrap_or_else(|error| panic!("--{flag} {word}: {error}"));
    }
    assert_eq!((look.picture.size, look.picture.samples), (Size { width: 64, height: 32 }, Samples(4)));
    assert_eq!((look.picture.style, look.background()), (LookStyle::Bare, Some([10, 20, 255])));
    assert_eq!(look.light.position_m, Some([-1.0, 0.0, 2.0]));
    let fills: Vec<_> = look.light.fill.iter().map(|f| (f.direction, f.strength)).collect();
    assert_eq!(fills, [([-2.0, 0.0, 0.0], 0.25), ([0.0, 1.0, 0.0], 1.0)]);
    assert_eq!((look.fur.layers, look.fur.detail), (Some(8), LookDetail::Level(1.5)));
    assert_eq!((look.shadow.self_shadow, look.shadow.penumbra), (LookSelfShadow::Off, 0.5));
    assert_eq!((look.shadow.map_texels, look.shadow.map_layers, look.shadow.shrink), (256, Some(4), 16));
    assert_eq!((look.ink.width, look.ink.mist_m), (LookWidth::Metres(0.02), Some(Interval([5.0, 60.0]))));
    assert_eq!(look.ink.color, Some(Rgb([0, 0, 255])));
    // A distant light replaces the lamp.
    short("light").apply(&mut look, "0,3,4").unwrap();
    assert_eq!((look.light.position_m, look.light.direction), (None, [0.0, 3.0, 4.0]));
    for (flag, word, message) in [
        ("size", "0x0", "each from 1 to 8192"),
        ("size", "834", "WIDTHxHEIGHT"),
        ("size", "9000x10", "each from 1 to 8192"),
        ("light", "0,0,0", "a direction that is not zero"),
        ("light", "NaN,0,1", "found [NaN, 0, 1]"),
        ("layers", "0", "found 0, expected \"all\" or an integer 1..=1024"),
        ("shadow-density", "5", "found 5, expected a number 0..=4"),
        ("penumbra", "-1", "a number 0..=2"),
        ("penumbra", "NaN", "a number 0..=2"),
        ("shadow-map", "8", "16..=8192"),
        ("fill-light", "0,0,0", "direction: found [0, 0, 0]"),
        ("fill-light", "0,1,0/-1", "strength: found -1, expected a number 0..=1000"),
        ("background", "1,2,300", "0..=255"),
        ("background", "red", "\"transparent\""),
        ("style", "fluffy", "\"fur\", \"ink\", \"bare\""),
        ("fins", "maybe", "true or false"),
        ("detail", "coarse", "\"full\", \"auto\" or a level 0..=32"),
        ("samples", "2", "1 or 4"),
        ("ink-width", "7", "found 7, expected \"auto\", pixels"),
        ("ink-width", "40px", "at most 32"),
        ("ink-threshold", "0.1", "0.15..=1"),
        ("ink-mist", "5,2", "the second greater"),
        ("ink-tone", "nan", "found NaN"),
    ] {
        let before = look.clone();
        let error = short(flag).apply(&mut look, word).unwrap_err().to_string();
        assert!(error.contains(message), "--{flag} {word}: {error}");
        assert_eq!(look, before, "a rejected value must change nothing");
    }
}

#[test]
fn looks_survive_a_round_trip() {
    let looks = [
        Look::default(),
        set(&["light.direction=1,2,3", "picture.background=transparent", "ink.width=7px", "fur.detail=auto"]),
        set(&["light.position_m=1,2,3", "light.fill=[{ direction = [0, 1, 0], strength = 0.5 }, \"1,0,0\"]"]),
        set(&[
            "picture.background=#0a14ff",
            "ink.mist_m=[5, 60]",
            "fur.detail=2.5",
            "picture.samples=4",
            "ink.width=.01m",
        ]),
    ];
    for look in looks {
        look.validate().unwrap();
        let text = look.to_toml();
        // The written file must be complete: it is read over a different look.
        let mut again = set(&["light.position_m=9,9,9", "fur.layers=3", "ink.color=1,2,3", "light.fill=1,0,0"]);
        again.read(&text).unwrap();
        assert_eq!(again, look, "{text}");
    }
}

#[test]
fn look_errors_name_line_key_found_and_expected() {
    for (text, message) in [
        ("[shadow]\npenumbr = 1", "line 2, shadow.penumbr: unknown key; did you mean shadow.penumbra?"),
        (
            "[light]\ndirection = [0, 0, 0]",
            "line 2, light.direction: found [0, 0, 0], expected a direction that is not zero",
        ),
        ("[light]\nfill = [{ direktion = [0, 1, 0] }]", "line 2, light.fill: entry 0: unknown key \"direktion\""),
        ("[ink]\npenumbra = 1", "did you mean shadow.penumbra?"),
        ("[pictur]\n", "did you mean [picture]?"),
        ("[ink]\nmist_m = [5]", "two distances in metres"),
    ] {
        let error = Look::default().read(text).unwrap_err().to_string();
        assert!(error.contains(message), "{text}: {error}");
    }
    let mut wrong = Look::default();
    wrong.ink.width = LookWidth::Pixels(40.0);
    assert_eq!(wrong.validate().unwrap_err().name, "ink.width");
    wrong = Look::default();
    wrong.light.direction = [0.0; 3];
    assert_eq!(wrong.validate().unwrap_err().name, "light.direction");
}

/// Checks that the knobs of published forms can be set by their flags, by their keys, and by the keys of older files.
/// Builds without these knobs must name the build that has them.
#[test]
fn published_forms_require_the_lab_build() {
    let mut look = Look::default();
    let results = [
        short("slant").apply(&mut look, "printed"),
        look.set("study.penumbra_form=inner"),
        look.set("fur.lighting=vertex"),
        look.read("[ink]\nrule = \"all\""),
        look.read("[study]\nink_anchoring = \"screen\""),
    ];
    #[cfg(feature = "study")]
    {
        assert_eq!(results, [const { Ok(()) }; 5]);
        let study = LookStudy {
            slant: LookSlant::Printed,
            penumbra_form: LookPenumbra::Inner,
            lighting: LookLighting::Vertex,
            ink_rule: LookRule::AllBelow,
            ink_anchoring: LookAnchoring::Screen,
            ..LookStudy::default()
        };
        assert_eq!(look, Look { study, ..Look::default() });
    }
    #[cfg(not(feature = "study"))]
    {
        assert_eq!(look, Look::default());
        for (result, place) in
            results.into_iter().zip(["study.slant", "study.pen", "fur.l", "line 2, ink.r", "line 1, study"])
        {
            let error = result.unwrap_err().to_string();
            assert!(error.starts_with(place) && error.contains("laboratory's build"), "{error}");
        }
    }
    // A misspelt key must still be an error.
    assert!(look.set("fur.lightning=vertex").unwrap_err().to_string().contains("unknown key"));
}

#[test]
fn many_knobs_are_numbers_with_a_range() {
    let sliders = knobs::<Look>().filter(|knob| matches!((knob.control)(), Control::Number { .. })).count();
    assert!(sliders >= 15, "{sliders}");
}

#[cfg(feature = "draw")]
#[test]
fn default_look_equals_the_runtime_defaults() {
    use pelage_runtime::{DebugView, FurParams, InkParams, LineWidth, ShadowParams};
    let look = Look::default();
    assert_eq!(look.ink_params(), InkParams::default());
    assert_eq!(look.shadow_params(), ShadowParams::default());
    // Pictures blend the edges of strands; an application chooses by the samples of its target.
    assert_eq!(set(&["fur.strand_edges=samples"]).fur_params(), FurParams::default());
    assert_eq!(look.debug_view(), DebugView::default());
    #[cfg(feature = "study")]
    assert_eq!(look.study.params(), pelage_runtime::Study::default());
    let ink = set(&["ink.width=0.02m", "picture.background=255,255,255", "fur.fins=off"]).ink_params();
    assert_eq!((ink.width, ink.paper, ink.fins), (LineWidth::Metres(0.02), Vec3::ONE, false));
}
