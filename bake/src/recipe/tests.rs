use super::*;
use pelage_params::{Item, Tables as _};
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
fn validate_checks_every_table() {
    // Each entry sets an invalid value in a table. All tables are covered, because `detail` was once forgotten.
    type Spoil = fn(&mut Recipe);
    let wrong: [(&str, Spoil); 18] = [
        ("model.unit_m", |r| r.model.unit_m = 0.0),
        ("surface.patch_size", |r| r.surface.patch_size = 1e9),
        ("hair.density", |r| r.hair.density = 0),
        ("hair.lean", |r| r.hair.lean = f32::NAN),
        ("underfur.length", |r| r.underfur.length = 0.0),
        ("groom.length", |r| r.groom.length = ScalarMap::Constant(2.0)),
        ("color.variation", |r| r.color.variation = -1.0),
        ("shading.ambient_floor", |r| r.shading.ambient_floor = 2.0),
        ("fibre.eta", |r| r.fibre.eta = 1.0),
        ("slice.layers", |r| r.slice.layers = 1),
        ("slice.tile_texels", |r| r.slice.tile_texels = 96),
        ("visibility.directions", |r| r.visibility.directions = 1),
        ("strands.points", |r| r.strands.points = 1),
        ("fins.depth", |r| r.fins.depth = Some(0.0)),
        ("detail.gap_px", |r| r.detail.gap_px = 0.0),
        ("ink.speed", |r| r.ink.speed = f32::INFINITY),
        ("pack.base_color_max", |r| r.pack.base_color_max = 0),
        ("judge.samples", |r| r.judge.samples = 0),
    ];
    let mut tables: Vec<_> = wrong.iter().filter_map(|(name, _)| name.split('.').next()).collect();
    tables.dedup();
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

/// Source of random words for keys, which follows the descriptions of the values that keys expect.
struct Words {
    seed: u64,
    /// Number of values drawn so far.
    drawn: u64,
    texts: Vec<String>,
    names: Vec<String>,
    paths: Vec<String>,
}

fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

impl Words {
    fn below(&mut self, count: u64) -> u64 {
        self.drawn += 1;
        crate::noise::hash(self.seed, self.drawn) % count
    }

    fn one<T: Clone>(&mut self, all: &[T]) -> T {
        all[self.below(all.len() as u64) as usize].clone()
    }

    fn number(&mut self, [least, most]: [f32; 2]) -> f32 {
        let share = self.below(1 << 24) as f32 / (1 << 24) as f32;
        (least + share * (most - least)).clamp(least, most)
    }

    fn vector(&mut self, range: [f32; 2]) -> String {
        format!("{:?}", [0; 3].map(|_| self.number(range)))
    }

    /// Draws a word that satisfies the description `expected`.
    fn word(&mut self, expected: &str) -> String {
        let range = expected.split([' ', ',']).find_map(|word| word.split_once("..=")).unwrap_or(("-1", "1"));
        let numbers = || [range.0, range.1].map(|number| number.parse().unwrap());
        let whole = || [range.0, range.1].map(|number| number.parse::<u64>().unwrap());
        let first = expected.split(' ').take(2).collect::<Vec<_>>().join(" ");
        let path = self.one(&self.paths.clone());
        if expected.contains("\"vertex\"") {
            let suffixes: &[_] = if expected.contains("#a)") { &["", "#r", "#g", "#b", "#a"] } else { &[""] };
            let of_image = if expected.contains("#uv") { &["", "#uv"] } else { suffixes };
            match self.below(3) {
                0 => return quoted(&format!("vertex{}", self.one(suffixes))),
                1 => return quoted(&(path + self.one(of_image))),
                _ => {}
            }
        }
        match first.as_str() {
            "a number" => format!("{:?}", self.number(numbers())),
            "an integer" => (whole()[0] + self.below(whole()[1] - whole()[0] + 1)).to_string(),
            "a power" => {
                let [least, most] = whole().map(u64::ilog2);
                (1 << (least + self.below(u64::from(most - least) + 1) as u32)).to_string()
            }
            "true or" => (self.below(2) == 1).to_string(),
            "three numbers" | "[x, y," => self.vector(numbers()),
            "the relative" => quoted(&path),
            "a string" => quoted(&self.one(&self.names.clone())),
            _ if expected.contains("#rrggbb") => self.vector([0.0, 1.0]),
            "a list" => toml::Value::from(self.texts.clone()).to_string(),
            _ => {
                let choices: Vec<&str> = expected.split('"').skip(1).step_by(2).collect();
                assert!(!choices.is_empty(), "no word for {expected}");
                quoted(self.one(&choices))
            }
        }
    }

    /// Draws a table with a name. Keys without which some tables are invalid are always set.
    fn table(&mut self, keys: &[pelage_params::TableKey]) -> String {
        let mut table = format!("{{ name = {}", quoted(&self.one(&self.names.clone())));
        for key in keys {
            if ["at", "direction", "from", "radius_m"].contains(&key.name) || self.below(2) == 0 {
                table += &format!(", {} = {}", key.name, self.word(&(key.expected)()));
            }
        }
        table + " }"
    }

    fn view(&mut self) -> String {
        let [eye, target] = [[-1e3, -1.0], [0.0, 1e3]].map(|range| self.vector(range).replace(['[', ']', ' '], ""));
        quoted(&format!("{eye}/{target}/{}", self.number([1.0, 170.0])))
    }
}

/// Returns recipes in which any keys are set.
fn recipes() -> impl Strategy<Value = Recipe> {
    let texts = |pattern| prop::collection::vec(pattern, 3);
    let names = (texts("\\PC{1,9}"), texts("[a-zäß][a-z ]{0,5}/[a-z\"'.]{1,9}[a-z]"));
    (any::<u64>(), prop::collection::vec(any::<String>(), 0..3), names).prop_map(|(seed, texts, (names, paths))| {
        let mut words = Words { seed, drawn: 0, texts, names, paths };
        let mut recipe = Recipe::default();
        for key in keys() {
            let list = |entry: &mut dyn FnMut() -> String, count| {
                format!("[{}]", (0..count).map(|_| entry()).collect::<Vec<_>>().join(", "))
            };
            let count = words.below(3);
            let word = match (key.control)() {
                _ if words.below(4) == 0 => continue,
                pelage_params::Control::Tables(keys) => list(&mut || words.table(keys), count),
                _ if key.name == "judge.views" => list(&mut || words.view(), count),
                _ => words.word(&(key.expected)()),
            };
            recipe.set(&format!("{}={word}", key.name)).unwrap();
        }
        recipe
    })
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
