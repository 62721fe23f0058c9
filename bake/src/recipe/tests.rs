#![allow(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;
use pelage_params::{Field, Item, Raw, Tables as _};
use pelage_stage::Viewpoint;
use proptest::prelude::*;

fn error(text: &str) -> String {
    Recipe::parse("r.toml", text).unwrap_err().to_string()
}

#[test]
fn an_empty_recipe_is_the_default() {
    assert_eq!(Recipe::parse("r.toml", "").unwrap(), Recipe::default());
    Recipe::default().validate().unwrap();
}

/// Checks that `guides`, the former name of comb marks, still works in recipes and in packages.
#[test]
fn deprecated_guides_key_reads_as_comb_marks() {
    let marks = "[{ name = \"nose\", at = [0, 1, 0.5], direction = [0, 0, -1] }]";
    let [old, new] = [("guides", "guides"), ("marks", "comb_marks")].map(|(word, key)| {
        Recipe::parse("r.toml", &format!("[surface]\ncomb = \"{word}\"\n{key} = {marks}\n")).unwrap()
    });
    assert_eq!((new.surface.comb, new.surface.comb_marks.len()), (CombSource::Marks, 1));
    assert_eq!(old, new);
    let text = old.to_toml();
    assert!(text.contains("comb_marks") && text.contains("\"marks\"") && !text.contains("guides"), "{text}");
    let mut set = Recipe::default();
    set.set("surface.comb=guides").unwrap();
    set.set(&format!("surface.guides={marks}")).unwrap();
    assert_eq!(set, new);
}

/// Returns the conditions of a set's knobs that name no knob, no possible value of it, and no condition in `known`.
fn faulty_needs<S: pelage_params::Tables>(known: &[&str]) -> Vec<&'static str> {
    let is_faulty = |need: &&'static str| {
        let Some((name, word)) = need.split_once("!=").or_else(|| need.split_once('=')) else {
            return !known.contains(need);
        };
        let Some(knob) = pelage_params::knobs::<S>().find(|knob| knob.name == name) else { return true };
        let unset = word == "none" && knob.value(&S::default()).is_none_or(|value| value == "\"none\"");
        !unset && pelage_params::set(&mut S::default(), &format!("{name}={word}")).is_err()
    };
    let all = |table: &'static pelage_params::TableInfo| {
        table.needs.iter().chain(table.knobs.iter().flat_map(|knob| knob.needs)).copied()
    };
    S::TABLES.iter().flat_map(all).filter(is_faulty).collect()
}

#[test]
fn conditions_of_knobs_name_knobs_and_their_values() {
    assert_eq!(faulty_needs::<Recipe>(&[]), [""; 0]);
    assert_eq!(faulty_needs::<pelage_stage::Look>(&pelage_stage::CONDITIONS.map(|(name, _)| name)), [""; 0]);
}

#[test]
fn switch_of_a_table_has_an_effect_while_it_is_off() {
    let off = |name: &str| Some((if name.ends_with(".enabled") { "false" } else { "1" }).to_owned());
    for name in ["ink", "detail", "visibility", "fins"] {
        let table = Recipe::TABLES.iter().find(|table| table.name == name).unwrap();
        let (switch, others): (Vec<_>, Vec<_>) =
            table.knobs.iter().partition(|knob| knob.name == format!("{name}.enabled"));
        assert_eq!(table.unmet(switch[0], off, |_| true), None, "{name}");
        let need = Some(format!("{name}.enabled=true"));
        assert!(!others.is_empty());
        others.iter().for_each(|knob| assert_eq!(table.unmet(knob, off, |_| true).map(str::to_owned), need));
    }
}

#[test]
fn every_key_is_documented() {
    for key in keys() {
        assert!(key.doc.len() > 10 && !(key.expected)().is_empty(), "{} is not documented", key.name);
    }
}

#[test]
fn defaults_of_named_tables_are_valid() {
    let tables = [("group", HairGroupParams::KEYS), ("tuft", TuftParams::KEYS)];
    for (table, key) in tables.iter().flat_map(|(table, keys)| keys.iter().map(move |key| (table, key))) {
        if let Some(default) = (key.default)() {
            Recipe::parse("r.toml", &format!("[[strands.{table}]]\nname = \"x\"\n{} = {default}", key.name)).unwrap();
        }
    }
}

#[test]
fn errors_name_line_key_found_and_expected() {
    for (text, parts) in [
        ("[hair]\ndensty = 3", &["r.toml: line 2, hair.densty:", "hair.density"][..]),
        ("\n[hiar]\ndensity = 3", &["line 2, hiar", "[hair]"]),
        ("[slice]\ndensity = 3", &["line 2, slice.density", "hair.density"]),
        ("density = 3", &["line 1, density", "unknown table"]),
        ("hair = 3", &["line 1, hair", "found 3", "a table"]),
        ("hair.length = 3", &["line 1, hair.length:", "hair.length_m"]),
        ("[slice]\nlayers = 0", &["line 2, slice.layers", "found 0", "4..=256"]),
        ("[slice]\nlayers = 16.0", &["found 16", "an integer 4..=256"]),
        ("[slice]\ntile_texels = 65", &["found 65", "a power of two 16..=2048"]),
        ("[slice]\ntile_texels = \"64\"", &["found the string \"64\"", "power of two"]),
        ("[hair]\nstyle = \"curley\"", &["\"curley\"", "\"straight\", \"curly\", \"messy\""]),
        ("[hair]\nlength_m = nan", &["found NaN", "a number"]),
        ("[hair]\nlength_m = 2021-01-01", &["found a date"]),
        ("[hair]\nseed = -1", &["found -1", "0..=9223372036854775807"]),
        ("[hair]\nlean = 1e400", &["found inf"]),
        ("[color]\nroot = \"#12345\"", &["\"#12345\"", "#rrggbb"]),
        ("[color]\nroot = [1, 2]", &["found [1, 2]"]),
        ("[color]\nroot = [0, 0, 2]", &["0..=1"]),
        ("[color]\nbase_color = 1", &["found 1", "true or false"]),
        ("[model]\nbare = [1]", &["found [1]", "a list of strings"]),
        ("[hair]\nlean = ", &["line 2"]),
        ("[hair]\nlean = 1\nlean = 0.5", &["line 3", "duplicate"]),
        ("[hair\n", &["line 1"]),
    ] {
        let message = error(text);
        for part in parts {
            assert!(message.contains(part), "{text:?} gives {message:?}, expected {part:?} in it");
        }
    }
}

#[test]
fn set_accepts_unquoted_strings_and_reports_the_key() {
    let mut recipe = Recipe::default();
    for assignment in
        ["hair.style=messy", "color.tip = #ff8000", "model.bare=Eye*", "hair.length_m=2e-2", "hair.lean=1"]
    {
        recipe.set(assignment).unwrap();
    }
    assert_eq!(recipe.hair.style, Style::Messy);
    assert_eq!(recipe.color.tip, Some(SrgbColor([1.0, 128.0 / 255.0, 0.0])));
    assert_eq!(recipe.model.bare, Some(vec!["Eye*".to_owned()]));
    assert_eq!((recipe.hair.length_m, recipe.hair.lean), (Some(0.02), 1.0));
    recipe.set("model.bare=[\"a\", \"b\"]").unwrap();
    assert_eq!(recipe.model.bare, Some(vec!["a".to_owned(), "b".to_owned()]));
    recipe.set("model.bare=[]").unwrap();
    assert_eq!(recipe.model.bare, Some(Vec::new()), "an empty list differs from an unset key");
    assert_eq!(Recipe::parse("r", &recipe.to_toml()).unwrap(), recipe);
    assert_eq!(Recipe::parse("r", "").unwrap().model.bare, None);
    let before = recipe.clone();
    for (assignment, part) in [
        ("hair.style", "key=value"),
        ("hair.stile=messy", "hair.style"),
        ("lean=1", "hair.lean"),
        ("slice.layers=0", "found 0"),
        ("slice.layers=", "found the string \"\""),
        ("", "key=value"),
    ] {
        let message = recipe.set(assignment).unwrap_err().to_string();
        assert!(message.starts_with("--set: ") && message.contains(part), "{assignment:?} gives {message:?}");
    }
    assert_eq!(recipe, before, "a refused value must change nothing");
}

#[test]
fn validate_names_the_key() {
    let mut recipe = Recipe::default();
    recipe.hair.lean = f32::NAN;
    let message = recipe.validate().unwrap_err().to_string();
    assert!(message.contains("hair.lean") && message.contains("0..=1"), "{message}");
    recipe = Recipe::default();
    recipe.slice.tile_texels = 96;
    assert!(recipe.validate().unwrap_err().to_string().contains("slice.tile_texels"));
}

#[test]
fn validate_checks_every_table() {
    // Each entry sets a value far out of range in a table. All tables are covered, because `detail` was once forgotten.
    type Spoil = fn(&mut Recipe);
    let wrong: [(&str, Spoil); 16] = [
        ("model.unit_m", |r| r.model.unit_m = 0.0),
        ("surface.patch_size", |r| r.surface.patch_size = 1e9),
        ("hair.density", |r| r.hair.density = 0),
        ("underfur.length", |r| r.underfur.length = 0.0),
        ("groom.length", |r| r.groom.length = ScalarMap::Constant(2.0)),
        ("color.variation", |r| r.color.variation = -1.0),
        ("shading.ambient_floor", |r| r.shading.ambient_floor = 2.0),
        ("fibre.eta", |r| r.fibre.eta = 1.0),
        ("slice.layers", |r| r.slice.layers = 1),
        ("visibility.directions", |r| r.visibility.directions = 1),
        ("strands.points", |r| r.strands.points = 1),
        ("fins.depth", |r| r.fins.depth = Some(0.0)),
        ("detail.gap_px", |r| r.detail.gap_px = 0.0),
        ("ink.speed", |r| r.ink.speed = f32::INFINITY),
        ("pack.base_color_max", |r| r.pack.base_color_max = 0),
        ("judge.samples", |r| r.judge.samples = 0),
    ];
    let tables: Vec<_> = wrong.iter().filter_map(|(name, _)| name.split('.').next()).collect();
    let all: Vec<_> = <Recipe as pelage_params::Tables>::TABLES.iter().map(|table| table.name).collect();
    assert_eq!(tables, all);
    for (name, spoil) in wrong {
        let mut recipe = Recipe::default();
        spoil(&mut recipe);
        let message = recipe.validate().unwrap_err().to_string();
        assert!(message.starts_with(&format!("{name}: found ")), "{message}");
    }
}

#[test]
fn maps_are_numbers_vertex_colours_or_images() {
    let text = "[groom]\nlength = \"vertex#a\"\nbare = \"maps/coat.png#g\"\n\
                comb = \"flow.png#uv\"\ncolor = \"#ff0000\"\n\
                [[groom.material]]\nname = \"belly*\"\nlength = 0.5\n\
                [[groom.material]]\nname = \"tail\"\nwetness = \"vertex\"\n";
    let groom = Recipe::parse("r.toml", text).unwrap().groom;
    assert_eq!(groom.length, ScalarMap::Vertex(Channel::Alpha));
    assert_eq!(groom.bare, ScalarMap::Image { path: "maps/coat.png".into(), channel: Channel::Green });
    assert_eq!(groom.comb, Some(VectorMap::Image { path: "flow.png".into(), flow: true }));
    assert_eq!(groom.color, Some(ColorMap::Constant(SrgbColor([1.0, 0.0, 0.0]))));
    let [belly, tail] = &groom.material[..] else { panic!("{:?}", groom.material) };
    assert_eq!((belly.name.as_str(), &belly.length), ("belly*", &Some(ScalarMap::Constant(0.5))));
    assert_eq!(tail.wetness, Some(ScalarMap::Vertex(Channel::Red)));

    let mut recipe = Recipe::default();
    let tables = "groom.material=[{ name = \"a\", bare = \"a.png\" }, \
                  { name = \"b\", bare = \"a.png\", color = \"c.png\" }]";
    recipe.set(tables).unwrap();
    recipe.set("color.pattern=zebra.png").unwrap();
    let images = recipe.images();
    let named: Vec<_> = images.iter().map(|(key, path)| (key.as_str(), *path)).collect();
    let expected = [
        ("groom.material, table 0, bare", "a.png"),
        ("groom.material, table 1, color", "c.png"),
        ("color.pattern", "zebra.png"),
    ];
    assert_eq!(named, expected);

    for (set, part) in [
        ("groom.length=1.5", "0..=1"),
        ("groom.length=vertex#x", "#r, #g, #b or #a"),
        ("groom.bare=/tmp/a.png", "relative path"),
        ("groom.bare=c:/a.png", "relative path"),
        ("groom.comb=[0, 0, 0]", "[x, y, z]"),
        ("groom.color=#12", "#rrggbb"),
        ("groom.density=9", "0.25..=4"),
        ("groom.material=[{ name = \"a\", lenth = 1 }]", "table 0: lenth: unknown key; did you mean length?"),
        ("groom.material=[{ length = 1 }]", "found no name"),
        ("groom.material=[{ name = \"a\", length = 7 }]", "table 0: length: found 7"),
        ("groom.material=3", "found 3, expected a list of tables"),
        ("groom.joint=[{ length = 1 }]", "found no name, expected the name of a joint"),
        ("groom.joint=[{ name = \"head\", length = \"vertex\" }]", "table 0: length: found"),
        ("groom.joint=[{ name = \"head\", density = 5 }]", "0.25..=4"),
        ("groom.by_body=2", "0..=1"),
    ] {
        let error = Recipe::default().set(set).unwrap_err().to_string();
        assert!(error.contains(part), "{set}: {error}");
    }
}

#[test]
fn views_survive_a_round_trip() {
    let text = "[judge]\nviews = [\"0,1,-3/0.5,0.25,1e-3/40\", \"1,2,3/0,0,0/30.5\"]\n";
    let recipe = Recipe::parse("a.toml", text).expect("a recipe");
    assert_eq!(recipe.judge.views.len(), 2);
    assert_eq!(recipe.judge.views[0].target, glam::Vec3::new(0.5, 0.25, 1e-3));
    assert_eq!(Recipe::parse("a.toml", &recipe.to_toml()).expect("its own words"), recipe);
    let mut one = Recipe::default();
    one.set("judge.views=0,1,3/0,0,0/40").expect("a word without quotes");
    assert_eq!(one.judge.views.len(), 1);
}

#[test]
fn view_errors_name_line_and_entry() {
    for (word, message) in [("0,1,3/0,0,0", "fov_deg"), ("0,1/0,0,0/40", "eye"), ("0,0,0/0,0,0/40", "same point")] {
        let text = format!("[judge]\nviews = [\"0,1,3/0,0,0/40\", \"{word}\"]\n");
        let error = Recipe::parse("a.toml", &text).unwrap_err().to_string();
        assert!(error.contains("line 2, judge.views") && error.contains("entry 1"), "{error}");
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn documented_toml_parses_to_the_same_recipe() {
    let mut recipe = Recipe::default();
    let text = recipe.to_documented_toml();
    assert_eq!(Recipe::parse("r.toml", &text).unwrap(), recipe, "{text}");
    assert!(text.contains("# length_m =\n"));
    recipe.hair.length_m = Some(0.03);
    assert!(recipe.to_documented_toml().contains("\nlength_m = 0.03\n"));
    assert_eq!(Recipe::parse("r.toml", &format!("\u{feff}{}", recipe.to_toml())).unwrap(), recipe);
}

fn grooms() -> impl Strategy<Value = GroomParams> {
    let path = || "[a-zäß][a-z ]{0,5}/[a-z\"'.]{1,9}[a-z]";
    let channel = || prop::sample::select(&[Channel::Red, Channel::Green, Channel::Blue, Channel::Alpha][..]);
    let scalar = move |range: std::ops::RangeInclusive<f32>| {
        prop_oneof![
            range.prop_map(ScalarMap::Constant),
            channel().prop_map(ScalarMap::Vertex),
            (path(), channel()).prop_map(|(path, channel)| ScalarMap::Image { path, channel }),
        ]
    };
    let share = move || scalar(0.0..=1.0);
    let vector = move || {
        prop_oneof![
            [0.1f32..=1.0, -1.0..=1.0, -1.0..=1.0].prop_map(VectorMap::Constant),
            Just(VectorMap::Vertex),
            (path(), any::<bool>()).prop_map(|(path, flow)| VectorMap::Image { path, flow }),
        ]
    };
    let color = move || {
        prop_oneof![
            [0f32..=1.0, 0.0..=1.0, 0.0..=1.0].prop_map(|c| ColorMap::Constant(SrgbColor(c))),
            Just(ColorMap::Vertex),
            path().prop_map(ColorMap::Image),
        ]
    };
    use prop::option::of;
    let material = ("\\PC{1,9}", of(share()), of(scalar(0.25..=4.0)), of(vector()), of(share()), of(color())).prop_map(
        |(name, length, density, comb, bare, color)| MaterialGroom {
            name,
            length,
            density,
            comb,
            bare,
            color,
            ..MaterialGroom::default()
        },
    );
    let number = || of(0f32..=1.0);
    let joint = ("\\PC{1,9}", number(), of(0.25f32..=4.0), number(), number(), number()).prop_map(
        |(name, length, density, lean, wetness, bare)| JointGroom { name, length, density, lean, wetness, bare },
    );
    let bare = (share(), of(0f32..=1e3));
    let hair_color = of([0f32..=1.0, 0.0..=1.0, 0.0..=1.0].prop_map(SrgbColor));
    let whole =
        (share(), scalar(0.25..=4.0), share(), of(vector()), share(), bare, of(color()), 0f32..=1.0, hair_color);
    let tables = (prop::collection::vec(material, 0..3), prop::collection::vec(joint, 0..3));
    let coordinates = prop::sample::select(GroomCoordinates::ALL);
    (coordinates, whole, tables).prop_map(|(coordinates, w, (material, joint))| GroomParams {
        coordinates,
        length: w.0,
        density: w.1,
        lean: w.2,
        comb: w.3,
        wetness: w.4,
        bare: w.5.0,
        bare_margin_m: w.5.1,
        color: w.6,
        hair_color: w.8,
        material,
        joint,
        by_body: w.7,
    })
}

fn inks() -> impl Strategy<Value = InkParams> {
    use prop::option::of;
    let share = || {
        prop_oneof![(0f32..=1.0).prop_map(ScalarMap::Constant), Just(ScalarMap::Vertex(crate::recipe::Channel::Blue))]
    };
    let place = || [-1e3f32..=1e3, -1e3..=1e3, -1e3..=1e3];
    let path = || of("[a-z /.]{1,9}".prop_filter_map("a path", |p| FilePath::from_raw(&Raw::String(p))));
    let fill = of(prop::sample::select(InkFill::ALL));
    let material = ("\\PC{1,9}", fill, of(place()), of(share()), of(share()))
        .prop_map(|(name, fill, center, amount, line)| MaterialInk { name, fill, center, amount, line });
    let numbers = (any::<bool>(), of(place()), 0f32..=100.0, -4f32..=4.0, of(1e-6f32..=1e3), 0f32..=4.0);
    (numbers, (share(), share(), share()), prop::collection::vec(material, 0..3), (path(), path()), 5u32..=11).prop_map(
        |(n, (wash, solid, lines), material, (stroke_image, wash_image), texels)| InkParams {
            enabled: n.0,
            center: n.1,
            speed: n.2,
            range: n.3,
            grain_size_m: n.4,
            line: n.5,
            wash,
            solid,
            lines,
            material,
            stroke_image,
            wash_image,
            wash_texels: 1 << texels,
            ..InkParams::default()
        },
    )
}

/// Returns a group in which every key is set if `share` is above 0.5.
fn some_group(count: u32, share: f32) -> HairGroupParams {
    let given = share > 0.5;
    HairGroupParams {
        name: format!("hair {count}"),
        material: given.then(|| "M\"ane*".to_owned()),
        mask: Some(ScalarMap::Constant(share)),
        file: given.then(|| FilePath("hair/guides.tfx".into())),
        turn_deg: given.then_some([share, -90.0, 0.0]),
        hairs: Some(count),
        style: given.then_some(Style::Curly),
        root_color: given.then_some(SrgbColor([share; 3])),
        parting_m: Some(share - 0.5),
        ..HairGroupParams::default()
    }
}

fn some_collider(count: u32, share: f32) -> HairColliderParams {
    HairColliderParams {
        name: format!("skull {count}"),
        joint: count.is_multiple_of(2).then(|| "Head".into()),
        from: Some([share, 1.5, -0.25]),
        to: count.is_multiple_of(3).then_some([share, 1.25, -0.5]),
        radius_m: Some(0.125 + share),
    }
}

fn some_tuft(count: u32, share: f32) -> TuftParams {
    TuftParams {
        name: "brow".into(),
        at: Some([share, 0.0, -1.0]),
        mirrored: Some(share > 0.5),
        hairs: Some(count),
        ..TuftParams::default()
    }
}

fn recipes() -> impl Strategy<Value = Recipe> {
    let unit = || 0.0f32..=1.0;
    let color = || [unit(), unit(), unit()].prop_map(SrgbColor);
    let hair = (
        (prop::sample::select(Style::ALL), 0..=i64::MAX as u64, 1u32..=1_000_000, prop::option::of(1e-6f32..=1e3)),
        (unit(), 1e-5f32..=0.25, 0f32..=0.25, unit(), -360f32..=360.0, unit(), 1e-3f32..=100.0, unit()),
        (unit(), unit(), prop::option::of(1u32..=1_000_000), prop::sample::select(Coat::ALL), 1e-4f32..=10.0),
        (prop::option::of(1e-6f32..=1e4), prop::option::of(1e-7f32..=0.1), prop::option::of(0f32..=0.1)),
    )
        .prop_map(|(a, b, c, metric)| HairParams {
            style: a.0,
            seed: a.1,
            density: a.2,
            length_m: a.3,
            length_variation: b.0,
            root_radius: b.1,
            tip_radius: b.2,
            lean: b.3,
            lean_direction_deg: b.4,
            curl_radius: b.5,
            curl_pitch: b.6,
            frizz: b.7,
            clump: c.0,
            dry_clump: c.1,
            clump_count: c.2,
            coat: c.3,
            length_per_radius: c.4,
            density_mm2: metric.0,
            root_radius_m: metric.1,
            tip_radius_m: metric.2,
        });
    let pack = (
        prop::sample::select(ShellFormat::ALL),
        prop::sample::select(DirectionFormat::ALL),
        prop::sample::select(BaseColorFormat::ALL),
        4u32..=16_384,
        prop::sample::select(BcQuality::ALL),
    )
        .prop_map(|p| PackParams {
            shell_format: p.0,
            direction_format: p.1,
            base_color_format: p.2,
            base_color_max: p.3,
            bc_quality: p.4,
        });
    let view = ([-1e3f32..=1e3, -1e3..=1e3, -1e3..=1e3], 1f32..=170.0).prop_map(|(eye, fov_deg)| Viewpoint {
        eye: eye.into(),
        target: glam::Vec3::from(eye) + 1.0,
        fov_deg,
    });
    let judge = (prop::collection::vec(view, 0..3), 16u32..=4096, 1u32..=65_536);
    let coat = (
        (prop::option::of("[a-z /.]{1,9}".prop_filter_map("a path", |p| FilePath::from_raw(&Raw::String(p)))),),
        (prop::sample::select(PatternProjection::ALL), prop::sample::select(PatternWrap::ALL), 6u32..=13),
    );
    let underfur = ((0u32..=1_000_000, 0.01f32..=1.0), prop::option::of(color()), prop::option::of(unit())).prop_map(
        |((density, length), tip, lean)| UnderfurParams {
            density,
            length,
            tip,
            lean,
            style: lean.map(|_| Style::Curly),
            ..UnderfurParams::default()
        },
    );
    let rest = (
        (
            1e-6f32..=1e6,
            prop::option::of(prop::collection::vec(any::<String>(), 0..3)),
            prop::option::of(1e-6f32..=1e3),
        ),
        (color(), color(), unit(), any::<bool>(), prop::option::of((color(), unit()))),
        ([0f32..=100.0, 0.0..=100.0, 0.0..=100.0], 0f32..=10_000.0, 0f32..=0.999, 0.001f32..=0.999),
        (4u32..=256, 4u32..=11, 0.25f32..=4.0),
        (any::<bool>(), prop::option::of(1e-3f32..=8.0)),
        (any::<bool>(), 0.05f32..=64.0, 0.1f32..=1.0, 0f32..=1e4, 0f32..=1e4),
    );
    ((hair, underfur), pack, rest, (coat, grooms(), judge, inks())).prop_map(
        |((hair, underfur), pack, (model, color, shading, slice, fins, detail), (coat, groom, judge, ink))| Recipe {
            model: ModelParams { unit_m: model.0, bare: model.1 },
            surface: SurfaceParams { source: SurfaceSource::Model, tile_size_m: model.2, ..SurfaceParams::default() },
            hair,
            underfur,
            groom,
            color: ColorParams {
                gain: color.4.map(|band| 0.1 + band.1),
                root: Some(color.0),
                tip: color.4.map(|_| color.1),
                band: color.4.map(|band| band.0),
                band_at: color.4.map_or(0.5, |band| band.1),
                band_width: 0.25,
                variation: color.2,
                base_color: color.3,
                at_root: coat.0.0.is_some(),
                pattern: coat.0.0,
                pattern_projection: coat.1.0,
                pattern_size_m: model.2,
                pattern_wrap: coat.1.1,
                pattern_texels: 1 << coat.1.2,
            },
            shading: ShadingParams {
                ambient: shading.0,
                specular_exponent: shading.1,
                ambient_floor: shading.2,
                back_light_range: shading.3,
                model: if color.3 { ShadingModel::Marschner } else { ShadingModel::KajiyaKay },
                ..ShadingParams::default()
            },
            fibre: FibreParams {
                eta: 1.2 + 0.8 * color.2,
                eumelanin: model.2.map(|x| x.min(100.0)),
                group: vec![OtherFibre { name: "x".into(), around: Some(color.2), ..OtherFibre::default() }],
                material: vec![
                    OtherFibre { name: "y".into(), eta: Some(1.3), ..OtherFibre::default() };
                    slice.1 as usize % 3
                ],
                ..FibreParams::default()
            },
            slice: SliceParams { layers: slice.0, tile_texels: 1 << slice.1, filter_width: slice.2 },
            visibility: VisibilityParams { enabled: color.3, directions: 2 * slice.0 },
            strands: StrandParams {
                enabled: !color.3,
                points: slice.0.clamp(2, 33),
                group: vec![some_group(slice.0, shading.2); slice.1 as usize % 3],
                tuft: vec![some_tuft(slice.0, shading.2); slice.1 as usize % 2],
                colliders: color.3,
                collider: vec![some_collider(slice.0, shading.2); slice.1 as usize % 3],
            },
            fins: FinParams { enabled: fins.0, depth: fins.1 },
            detail: DetailParams {
                enabled: detail.0,
                simplified: !detail.0,
                gap_px: detail.1,
                fade: detail.2,
                fins_px: detail.3,
                coat_px: detail.4,
            },
            ink,
            pack,
            judge: JudgeParams { views: judge.0, width: judge.1, height: judge.1, samples: judge.2 },
        },
    )
}

proptest! {
    #[test]
    fn recipe_survives_a_toml_round_trip(recipe in recipes()) {
        recipe.validate().unwrap();
        let text = recipe.to_toml();
        prop_assert_eq!(&Recipe::parse("r.toml", &text).unwrap(), &recipe, "{}", text);
        prop_assert_eq!(&Recipe::parse("r.toml", &text).unwrap().to_toml(), &text);
    }

    #[test]
    fn recipe_parser_never_panics(text in "\\PC{0,40}", key in "[a-z_.]{0,12}", value in "\\PC{0,12}") {
        let _ = Recipe::parse("r.toml", &text);
        let _ = Recipe::parse("r.toml", &format!("[hair]\n{key} = {value}"));
        let _ = Recipe::default().set(&text);
        let _ = Recipe::default().set(&format!("hair.{key}={value}"));
    }
}
