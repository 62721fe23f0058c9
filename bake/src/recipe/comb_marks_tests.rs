use super::*;
use crate::recipe::Recipe;

fn marks(list: &str) -> Result<Vec<CombMarkParams>, String> {
    let text = format!("[surface]\ncomb_marks = [{list}]\n");
    Recipe::parse("r.toml", &text).map(|recipe| recipe.surface.comb_marks).map_err(|error| error.to_string())
}

#[test]
fn comb_marks_survive_a_round_trip() {
    let list = "{ name = \"ruff\", at = [0, 1, 0.5], length = 1, density = 2, lean = 0.25, \
                color = \"#ffeedd\", reach_m = 0.2, mirrored = true }, \
                { name = \"nose\", at = [0, 1, 0.5], direction = [0, 0, -1] }";
    let read = marks(list).unwrap();
    assert_eq!((read[0].length, read[0].direction, read[1].length), (Some(1.0), None, None));
    let written = Recipe {
        surface: crate::recipe::SurfaceParams { comb_marks: read.clone(), ..Default::default() },
        ..Recipe::default()
    };
    assert_eq!(Recipe::parse("w.toml", &written.to_toml()).unwrap().surface.comb_marks, read);
}

#[test]
fn comb_mark_errors_name_key_and_reason() {
    for (mark, words) in [
        ("{ name = \"a\", direction = [0, 0, 1] }", "found no `at`"),
        ("{ name = \"a\", at = [0, 0, 1] }", "found none of direction, length"),
        ("{ name = \"a\", at = [0, 0, 1], mirrored = true, reach_m = 1 }", "found none of"),
        ("{ name = \"a\", at = [0, 0, 1], direction = [0, 0, 0] }", "direction: found [0, 0, 0]"),
        ("{ at = [0, 0, 1], length = 0.5 }", "found no name"),
        ("{ name = \"a\", at = [0, 0, 1], length = 1.5 }", "length: "),
        ("{ name = \"a\", at = [0, 0, 1], density = 0.1 }", "density: "),
        ("{ name = \"a\", at = [0, 0, 1], color = \"white\" }", "color: "),
        ("{ name = \"a\", at = [0, 0, 1], lean = 1, reach_m = 0 }", "reach_m: "),
        ("{ name = \"a\", at = [0, 0], lean = 1 }", "at: "),
        ("{ name = \"a\", at = [0, 0, 1], lenght = 1 }", "length"),
    ] {
        let error = marks(mark).unwrap_err();
        assert!(error.contains("comb_marks") && error.contains(words) && error.contains("line 2"), "{mark}: {error}");
    }
}

#[test]
fn mirrored_mark_is_reflected_in_x() {
    let mark = &marks("{ name = \"ear\", at = [0.1, 1, 0.5], direction = [1, 2, 3], length = 0.5, mirrored = true }")
        .unwrap()[0];
    let both: Vec<_> = mark.with_mirror_image().collect();
    assert_eq!((both.len(), &both[0]), (2, mark));
    assert_eq!(
        (both[1].at, both[1].direction, both[1].length),
        (Some([-0.1, 1.0, 0.5]), Some([-1.0, 2.0, 3.0]), Some(0.5))
    );
}
