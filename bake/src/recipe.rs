//! Recipes: everything that steers a bake, as TOML.
//!
//! A recipe has one table per stage and one key per parameter; [`KEYS`] lists them all with unit, range and default, and the
//! same table drives reading, writing, `--set key=value` and the checks, so that none of these can disagree. What a recipe
//! leaves out keeps its default. A key or table that does not exist is an error that names the nearest one that does: a
//! mistyped key must never pass for a setting that has no effect.
//!
//! ```
//! use pelage_bake::recipe::{Recipe, Style};
//! let mut recipe = Recipe::parse("fox.toml", "[hair]\nstyle = \"curly\"\nlength_m = 0.03\n")?;
//! recipe.set("hair.density=900")?;
//! assert_eq!((recipe.hair.style, recipe.hair.density), (Style::Curly, 900));
//! let error = Recipe::parse("fox.toml", "[hair]\ndensty = 900\n").unwrap_err().to_string();
//! assert!(error.contains("line 2") && error.contains("hair.density"), "{error}");
//! # Ok::<(), pelage_bake::BakeError>(())
//! ```

mod field;
mod guides;
mod ink;
mod maps;
mod material_groom;
mod material_table;
mod params;
mod views;

pub use field::SrgbColor;
pub use guides::GuideParams;
pub use ink::{InkFill, InkParams, MaterialInk};
pub use maps::{Channel, ColorMap, ImagePath, ScalarMap, VectorMap};
pub use material_groom::MaterialGroom;
pub use material_table::MaterialTable;
pub use params::{
    BaseColorFormat, BcQuality, ColorParams, CombSource, DetailParams, DirectionFormat, FinParams, GroomParams,
    HairParams, JudgeParams, ModelParams, PackParams, PatternProjection, PatternWrap, ShadingParams, ShellFormat,
    SliceParams, Style, SurfaceParams, SurfaceSource,
};
pub use views::{CameraView, parse_vec3};

use crate::BakeError;
use field::{Raw, describe_raw};
use serde::{Deserialize, Serialize};
use toml::de::{DeTable, DeValue};

/// What steers a bake: one section per stage. `Recipe::default()` is a natural short fur.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Recipe {
    /// How the model is read.
    pub model: ModelParams,
    /// How the tile of hair lies on the model.
    pub surface: SurfaceParams,
    /// The strands.
    pub hair: HairParams,
    /// What varies over the model.
    pub groom: GroomParams,
    /// The strands' colour.
    pub color: ColorParams,
    /// Constants of the lighting equation.
    pub shading: ShadingParams,
    /// The shell textures.
    pub slice: SliceParams,
    /// The fins.
    pub fins: FinParams,
    /// The levels of detail.
    pub detail: DetailParams,
    /// The model as an ink-wash painting.
    pub ink: InkParams,
    /// Texture formats of the package.
    pub pack: PackParams,
    /// The pictures that a bake with limits is judged by.
    pub judge: JudgeParams,
}

/// One recipe key, for help texts and documentation.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// `section.key`.
    pub name: &'static str,
    /// What it means, with unit and what the ends of the range do.
    pub doc: &'static str,
    /// Type and range, such as `a number 0..=1`.
    pub expected: fn() -> String,
    read: fn(&mut Recipe, &Raw) -> Result<(), String>,
    write: fn(&Recipe) -> Option<String>,
}

impl Key {
    /// Value in `recipe` as TOML, or `None` where it is left to be chosen from the model.
    pub fn value(&self, recipe: &Recipe) -> Option<String> {
        (self.write)(recipe)
    }

    fn section_and_leaf(&self) -> (&'static str, &'static str) {
        self.name.split_once('.').unwrap_or(("", self.name))
    }
}

/// Every key of a recipe, section by section.
pub const KEYS: &[&[Key]] = &[
    ModelParams::KEYS,
    SurfaceParams::KEYS,
    HairParams::KEYS,
    GroomParams::KEYS,
    ColorParams::KEYS,
    ShadingParams::KEYS,
    SliceParams::KEYS,
    FinParams::KEYS,
    DetailParams::KEYS,
    InkParams::KEYS,
    PackParams::KEYS,
    JudgeParams::KEYS,
];

/// Every key of a recipe in order, without the sections.
pub fn keys() -> impl Iterator<Item = &'static Key> {
    KEYS.iter().flat_map(|section| section.iter())
}

impl Recipe {
    /// Reads a recipe; `file` is its name for messages.
    ///
    /// # Errors
    /// [`BakeError::Input`] with the line and the key for broken TOML, an unknown table or key, a wrong type or a value outside
    /// its range.
    pub fn parse(file: &str, text: &str) -> Result<Self, BakeError> {
        let line = |offset: usize| text.bytes().take(offset).filter(|b| *b == b'\n').count() + 1;
        let fail = |offset: usize, key: &str, reason: String| BakeError::Input {
            file: file.to_owned(),
            place: if key.is_empty() {
                format!("line {}", line(offset))
            } else {
                format!("line {}, {key}", line(offset))
            },
            reason,
        };
        // Some editors begin a text file with a byte order mark.
        let body = text.strip_prefix('\u{feff}').unwrap_or(text);
        let skipped = text.len() - body.len();
        let document = DeTable::parse(body)
            .map_err(|e| fail(skipped + e.span().map_or(0, |s| s.start), "", e.message().trim().to_owned()))?;
        let mut recipe = Self::default();
        for (section, value) in document.get_ref() {
            let (name, at) = (section.get_ref().as_ref(), skipped + section.span().start);
            if !keys().any(|k| k.section_and_leaf().0 == name) {
                return Err(fail(at, name, unknown_section(name)));
            }
            let DeValue::Table(table) = value.get_ref() else {
                let found = describe_raw(&Raw::from_de(value.get_ref()));
                return Err(fail(at, name, format!("found {found}, expected a table")));
            };
            for (leaf, value) in table {
                let name = format!("{name}.{}", leaf.get_ref());
                let at = skipped + leaf.span().start;
                let key = keys().find(|k| k.name == name).ok_or_else(|| fail(at, &name, unknown_key(&name)))?;
                (key.read)(&mut recipe, &Raw::from_de(value.get_ref())).map_err(|reason| fail(at, &name, reason))?;
            }
        }
        Ok(recipe)
    }

    /// Sets one value, as in `--set hair.length_m=0.02`. Strings need no quotes: `hair.style=curly`.
    ///
    /// # Errors
    /// As [`Recipe::parse`], with `--set` for the file.
    pub fn set(&mut self, assignment: &str) -> Result<(), BakeError> {
        let fail =
            |place: &str, reason: String| BakeError::Input { file: "--set".into(), place: place.to_owned(), reason };
        let Some((name, value)) = assignment.split_once('=') else {
            return Err(fail(assignment, "found no '=', expected key=value, such as hair.length_m=0.02".into()));
        };
        let (name, value) = (name.trim(), value.trim());
        let key = keys().find(|k| k.name == name).ok_or_else(|| fail(name, unknown_key(name)))?;
        // What is no TOML value on its own (curly, #aabbcc, Eye*) is the string it looks like.
        let raw = match DeValue::parse(value) {
            Ok(parsed) => Raw::from_de(parsed.get_ref()),
            Err(_) => Raw::String(value.to_owned()),
        };
        (key.read)(self, &raw).map_err(|reason| fail(name, reason))
    }

    /// The recipe as TOML with every key that has a value, in the order of [`KEYS`]. Parsing it gives an equal recipe.
    pub fn to_toml(&self) -> String {
        self.write(|_, _| String::new())
    }

    /// As [`Recipe::to_toml`], with each key's meaning, type and range as comments, and keys without a value commented out.
    pub fn to_documented_toml(&self) -> String {
        self.write(|key, value| {
            let mut lines = String::new();
            for line in key.doc.lines().map(str::trim) {
                lines += &format!("# {line}\n");
            }
            lines += &format!("# Expects {}.\n", (key.expected)());
            if value.is_none() {
                lines += &format!("# {} =\n", key.section_and_leaf().1);
            }
            lines
        })
    }

    fn write(&self, comment: impl Fn(&Key, Option<&str>) -> String) -> String {
        let mut text = String::new();
        for section in KEYS {
            if let Some(key) = section.first() {
                let gap = if text.is_empty() { "" } else { "\n" };
                text += &format!("{gap}[{}]\n", key.section_and_leaf().0);
            }
            for key in *section {
                let value = key.value(self);
                text += &comment(key, value.as_deref());
                if let Some(value) = value {
                    text += &format!("{} = {value}\n", key.section_and_leaf().1);
                }
            }
        }
        text
    }

    /// The images that it names, each path once with the key that names it first.
    pub fn images(&self) -> Vec<(String, &str)> {
        let g = &self.groom;
        let scalars = [
            ("length", &g.length),
            ("density", &g.density),
            ("lean", &g.lean),
            ("wetness", &g.wetness),
            ("bare", &g.bare),
        ];
        let mut named: Vec<(String, Option<&str>)> =
            scalars.iter().map(|(key, map)| (format!("groom.{key}"), map.image())).collect();
        named.push(("groom.comb".into(), g.comb.as_ref().and_then(VectorMap::image)));
        named.push(("groom.color".into(), g.color.as_ref().and_then(ColorMap::image)));
        for (i, m) in g.material.iter().enumerate() {
            let scalars = [
                ("length", &m.length),
                ("density", &m.density),
                ("lean", &m.lean),
                ("wetness", &m.wetness),
                ("bare", &m.bare),
            ];
            let key = |key: &str| format!("groom.material, table {i}, {key}");
            named.extend(scalars.iter().map(|(k, map)| (key(k), map.as_ref().and_then(ScalarMap::image))));
            named.push((key("comb"), m.comb.as_ref().and_then(VectorMap::image)));
            named.push((key("color"), m.color.as_ref().and_then(ColorMap::image)));
        }
        named.push(("color.pattern".into(), self.color.pattern.as_ref().map(|path| path.0.as_str())));
        let ink = &self.ink;
        for (key, map) in [("wash", &ink.wash), ("solid", &ink.solid), ("lines", &ink.lines)] {
            named.push((format!("ink.{key}"), map.image()));
        }
        for (i, m) in ink.material.iter().enumerate() {
            for (key, map) in [("amount", &m.amount), ("line", &m.line)] {
                named.push((format!("ink.material, table {i}, {key}"), map.as_ref().and_then(ScalarMap::image)));
            }
        }
        for (key, path) in [("stroke_image", &ink.stroke_image), ("wash_image", &ink.wash_image)] {
            named.push((format!("ink.{key}"), path.as_ref().map(|path| path.0.as_str())));
        }
        let mut images: Vec<(String, &str)> = Vec::new();
        for (key, path) in named {
            if let Some(path) = path.filter(|path| images.iter().all(|(_, known)| known != path)) {
                images.push((key, path));
            }
        }
        images
    }

    /// Checks every value against its range.
    ///
    /// # Errors
    /// [`BakeError::Params`] naming the key, what was found and what was expected.
    pub fn validate(&self) -> Result<(), BakeError> {
        self.model.validate()?;
        self.surface.validate()?;
        self.hair.validate()?;
        self.groom.validate()?;
        self.color.validate()?;
        self.shading.validate()?;
        self.slice.validate()?;
        self.fins.validate()?;
        self.ink.validate()?;
        self.pack.validate()?;
        self.judge.validate()
    }
}

fn unknown_section(name: &str) -> String {
    let sections = || KEYS.iter().filter_map(|s| s.first()).map(|k| k.section_and_leaf().0);
    let all: Vec<_> = sections().collect();
    match nearest(name, sections()) {
        Some(near) => format!("unknown table; did you mean [{near}]? Tables: {}", all.join(", ")),
        None => format!("unknown table, expected one of {}", all.join(", ")),
    }
}

fn unknown_key(name: &str) -> String {
    let (section, leaf) = name.split_once('.').unwrap_or(("", name));
    // A key without its unit is looked for first, then one under the wrong table.
    let whole = keys().find(|k| k.name.strip_prefix(name).is_some_and(|rest| rest.starts_with('_')));
    let moved = keys().find(|k| k.section_and_leaf().1 == leaf);
    let known = keys().any(|k| k.section_and_leaf().0 == section);
    let near = whole.or(moved).map(|k| k.name).or_else(|| {
        if known {
            nearest(leaf, keys().filter(|k| k.section_and_leaf().0 == section).map(|k| k.section_and_leaf().1))
                .and_then(|leaf| keys().find(|k| k.section_and_leaf() == (section, leaf)))
                .map(|k| k.name)
        } else {
            nearest(name, keys().map(|k| k.name))
        }
    });
    match near {
        Some(near) => format!("unknown key; did you mean {near}?"),
        None => "unknown key".into(),
    }
}

/// The candidate most like `name`; the first of several equals.
fn nearest<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let mut best: Option<(f64, &str)> = None;
    for candidate in candidates {
        let score = strsim::jaro_winkler(name, candidate).max(strsim::normalized_damerau_levenshtein(name, candidate));
        if best.is_none_or(|(top, _)| score > top) {
            best = Some((score, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests;
