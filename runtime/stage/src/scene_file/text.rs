//! What a scene file may say, and where in it something is wrong.

use crate::StageError;
use crate::track::{LEAST_STEP_S, Track, Value};
use glam::Vec3;
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::de::{DeTable, DeValue};

/// Largest coordinate, metres, and largest time, seconds.
const FARTHEST: f64 = 1e6;

/// A scene as its file says it, word for word: plain data to look at and to change before it is loaded.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// How the picture looks.
    pub look: Option<SceneLook>,
    /// How the picture looks in words of the command line, with `_` for `-`: `self_shadow = "off"`. What `look` says goes before it.
    #[serde(default)]
    pub view: toml::Table,
    /// From where it is seen; left out, all models are framed, along their paths and over their clips.
    pub camera: Option<SceneCamera>,
    /// The key light; left out, the default one.
    pub light: Option<SceneLight>,
    /// Pictures over time.
    pub sequence: Option<SceneSequence>,
    /// What stands in it; at least one.
    #[serde(default, rename = "model")]
    pub models: Vec<SceneModel>,
}

/// `[look]`, or the file that it stands in.
#[derive(Clone, Debug, Deserialize)]
#[serde(try_from = "toml::Value")]
pub enum SceneLook {
    /// Path of a look file from the scene file's folder.
    File(String),
    /// Tables of a [`crate::Look`].
    Tables(toml::Table),
}

impl TryFrom<toml::Value> for SceneLook {
    type Error = String;

    fn try_from(value: toml::Value) -> Result<Self, String> {
        match value {
            toml::Value::String(path) => Ok(Self::File(path)),
            toml::Value::Table(tables) => Ok(Self::Tables(tables)),
            other => {
                let found = other.type_str();
                Err(format!("found {found}, expected the path of a look file or tables such as [look.shadow]"))
            }
        }
    }
}

/// `[camera]`: eye and target, or a path of them.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneCamera {
    /// Metres; with `target`, or neither.
    pub eye: Option<Point>,
    /// Metres; apart from `eye`.
    pub target: Option<Point>,
    /// Height of the view, degrees.
    pub fov_deg: Option<FieldOfView>,
    /// Instead of all of them: keys over time.
    pub path: Option<Vec<CameraKey>>,
}

/// A moment of a camera's path.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraKey {
    /// Seconds.
    pub time_s: Number,
    /// Metres.
    pub eye: Point,
    /// Metres; apart from `eye`.
    pub target: Point,
    /// Height of the view, degrees.
    pub fov_deg: Option<FieldOfView>,
}

/// `[light]`: one of the two.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneLight {
    /// Towards a distant light, any length but 0.
    pub direction: Option<Point>,
    /// Place of a near light, metres.
    pub position: Option<Point>,
}

/// `[sequence]`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneSequence {
    /// Pictures.
    pub frames: Option<Whole<100_000>>,
    /// Pictures a second.
    pub fps: Option<Whole<1000>>,
}

/// `[[model]]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneModel {
    /// Its name in results; left out, the package's.
    pub name: Option<String>,
    /// Its package's path from the scene file's folder.
    pub package: String,
    /// Where it stands, metres.
    pub position: Option<Point>,
    /// Where to it looks: 0 along +z, 90 along +x.
    pub heading_deg: Option<Number>,
    /// Its size beside the baked one.
    pub scale: Option<Scale>,
    /// Instead of `position` and `heading_deg`: keys over time.
    pub path: Option<Vec<PlaceKey>>,
    /// What it plays, by name; left out, it stands at rest.
    pub clip: Option<String>,
    /// Seconds of the clip in a second.
    pub speed: Option<Number>,
    /// The clip's moment at time 0, seconds.
    pub start_s: Option<Number>,
    /// Whether the clip begins anew at its end, or holds there.
    #[serde(rename = "loop")]
    pub looped: Option<bool>,
    /// Whether the model goes on from where the clip has carried it when that begins anew; else it begins where it stands.
    #[serde(default)]
    pub root_motion: bool,
    /// Morph targets by name, at weights of their own whatever the clip does.
    #[serde(default)]
    pub morphs: BTreeMap<String, Number>,
}

/// A moment of a model's path.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaceKey {
    /// Seconds.
    pub time_s: Number,
    /// Metres.
    pub position: Point,
    /// Degrees; in all keys of a path or in none.
    pub heading_deg: Option<Number>,
}

/// A number that is neither infinite nor absurd.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "f64")]
pub struct Number(pub f32);

impl TryFrom<f64> for Number {
    type Error = String;

    fn try_from(x: f64) -> Result<Self, String> {
        within(x, -FARTHEST, FARTHEST).map(Self)
    }
}

/// Three of them.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "[f64; 3]")]
pub struct Point(pub Vec3);

impl TryFrom<[f64; 3]> for Point {
    type Error = String;

    fn try_from(xyz: [f64; 3]) -> Result<Self, String> {
        let [x, y, z] = xyz.map(|x| within(x, -FARTHEST, FARTHEST));
        Ok(Self(Vec3::new(x?, y?, z?)))
    }
}

/// Height of a view, degrees.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "f64")]
pub struct FieldOfView(pub f32);

impl TryFrom<f64> for FieldOfView {
    type Error = String;

    fn try_from(x: f64) -> Result<Self, String> {
        within(x, 1.0, 170.0).map(Self)
    }
}

/// A size beside the one that was baked.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "f64")]
pub struct Scale(pub f32);

impl TryFrom<f64> for Scale {
    type Error = String;

    fn try_from(x: f64) -> Result<Self, String> {
        within(x, 1e-4, 1e4).map(Self)
    }
}

/// A whole number from 1 to `MOST`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "i64")]
pub struct Whole<const MOST: u32>(pub u32);

impl<const MOST: u32> TryFrom<i64> for Whole<MOST> {
    type Error = String;

    fn try_from(n: i64) -> Result<Self, String> {
        let whole = u32::try_from(n).ok().filter(|n| (1..=MOST).contains(n));
        whole.map(Self).ok_or_else(|| format!("found {n}, expected a whole number from 1 to {MOST}"))
    }
}

fn within(x: f64, least: f64, most: f64) -> Result<f32, String> {
    // NaN is in no range.
    let inside = (least..=most).contains(&x);
    if inside { Ok(x as f32) } else { Err(format!("found {x}, expected a number from {least} to {most}")) }
}

/// A scene file's text, for messages that name the line.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// As the user named it.
    pub name: &'a str,
    /// All of it.
    pub text: &'a str,
}

impl Source<'_> {
    /// Reads the words.
    ///
    /// # Errors
    ///
    /// [`StageError::Input`] with line and key for broken TOML, a key that there is none of, and a value that is not what it should be.
    pub fn parse(&self) -> Result<Scene, StageError> {
        let broken = |e: toml::de::Error| self.fault_at(e.span().map(|s| s.start), "", e.message().trim().to_owned());
        let document = toml::Deserializer::parse(self.text).map_err(broken)?;
        serde_path_to_error::deserialize(document).map_err(|e| {
            let key = e.path().to_string();
            let key = if key == "." { "" } else { &key };
            let inner = e.inner();
            let at = inner.span().map(|s| s.start).or_else(|| self.find(key));
            self.fault_at(at, key, inner.message().trim().to_owned())
        })
    }

    /// An error at a key such as `model[1].path[0].time_s`.
    pub fn fault(&self, key: &str, reason: impl Into<String>) -> StageError {
        self.fault_at(self.find(key), key, reason.into())
    }

    fn fault_at(&self, byte: Option<usize>, key: &str, reason: String) -> StageError {
        let line = byte.map(|byte| self.text.bytes().take(byte).filter(|b| *b == b'\n').count() + 1);
        let place = match (line, key) {
            (Some(line), "") => format!("line {line}"),
            (Some(line), key) => format!("line {line}, {key}"),
            (None, "") => "whole file".to_owned(),
            (None, key) => key.to_owned(),
        };
        StageError::Input { file: self.name.to_owned(), place, reason }
    }

    /// The byte where a key's value stands, or that of the nearest thing around it that is there.
    fn find(&self, key: &str) -> Option<usize> {
        let document = DeTable::parse(self.text).ok()?;
        let mut steps = key.split(['.', '[']).map(|step| step.trim_end_matches(']'));
        let mut here = document.get_ref().get(steps.next()?)?;
        for step in steps {
            let inner = match here.get_ref() {
                DeValue::Table(table) => table.get(step),
                DeValue::Array(array) => step.parse().ok().and_then(|i: usize| array.get(i)),
                _ => None,
            };
            let Some(inner) = inner else { break };
            here = inner;
        }
        Some(here.span().start)
    }

    /// A path of keys at `key`, times and values, which must rise.
    pub fn track<T>(&self, key: &str, keys: Vec<(f32, T)>) -> Result<Track<T>, StageError>
    where
        T: Value,
    {
        let times: Vec<f32> = keys.iter().map(|key| key.0).collect();
        Track::new(keys).map_err(|i| match (i.checked_sub(1).and_then(|before| times.get(before)), times.get(i)) {
            (Some(before), Some(time)) => self.fault(
                &format!("{key}[{i}].time_s"),
                format!("found {time} after {before}, expected at least {LEAST_STEP_S} s later than the key before"),
            ),
            _ => self.fault(key, "found no keys, expected at least one"),
        })
    }
}
