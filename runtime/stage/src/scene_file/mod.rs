//! Scene files: several models, their paths and clips, a camera and a light, as TOML. `assets/scenes` has an example
//! with comments.
//!
//! Lengths are in metres, times in seconds, angles in degrees; +y is up. An unknown key is an error.
//!
//! Keys, with defaults in parentheses:
//!
//! * `[look]` or `look` (the default look): look of the picture. Tables of a [`crate::Look`] such as `[look.shadow]`,
//!   or the path of a look file relative to the scene file's folder
//! * `[view]`: look as command-line flags, with `_` instead of `-`: `ink_mist = "5,60"`, `size = "834x424"`, `style =
//!   "ink"`. `look` overrides it
//! * `camera.eye`, `.target`, `.fov_deg`: position, target, and vertical field of view (default 30). By default the
//!   camera frames all models along their paths and over their clips
//! * `camera.path`: replaces `.eye`, `.target` and `.fov_deg`; a list of `{ time_s, eye, target, fov_deg }`, see
//!   [`crate::Track`]
//! * `light.direction` or `.position` (the default light): direction towards a distant light, or position of a nearby
//!   one
//! * `sequence.frames`, `.fps` (none, 24): number of pictures of a numbered sequence or a video, and pictures per
//!   second
//! * `[[model]]`: one table for each model, at most 10 000
//!
//! Keys of a model:
//!
//! * `name` (the package's, without `.pelage`): name of the model in results
//! * `package` (required): path of the package relative to the scene file's folder. Models may share a package, which
//!   is loaded once
//! * `position`, `heading_deg` (the origin, 0): position and heading; 0 faces +z, 90 faces +x
//! * `path`: replaces `position` and `heading_deg`; a list of `{ time_s, position, heading_deg }`. Without any heading
//!   the model faces its direction of movement
//! * `scale` (1): scale relative to the baked size
//! * `clip` (at rest): name of the clip to play
//! * `speed`, `start_s` (1, 0): playback speed, and time within the clip at time 0
//! * `loop` (true): whether the clip restarts at its end; otherwise it holds its last pose
//! * `root_motion` (false): whether the model continues from where its clip has carried it when the clip restarts.
//!   Without a camera the first cycle is framed
//! * `morphs`: weights of morph targets, which override those of the clip: `morphs = { smile = 0.7 }`
//!
//! [`SceneFile::parse`] reads a scene file, [`SceneFile::load`] its packages. The scene can be changed in between.

mod look;
mod text;

use crate::cast::{
    Actor, Cast, MAX_COPIES, Placement, Playback, clip_named, frame_actors, morph_named, root_displacement,
};
use crate::framing::{FOV_DEG, Framing};
use crate::toml_text::TomlText;
use crate::track::Track;
use crate::{CameraTrack, NamedPackage, StageError, Viewpoint};
use glam::Vec3;
use pelage_formats::Animation;
use std::path::{Path, PathBuf};
use std::sync::Arc;
pub use text::{
    CameraKey, FieldOfView, Number, PlaceKey, Point, Scale, Scene, SceneCamera, SceneLight, SceneLook, SceneModel,
    SceneSequence, Whole,
};

/// Minimum displacement per cycle of a clip with root motion, metres.
const MIN_DISPLACEMENT_M: f32 = 1e-4;

/// Scene file: its contents, and the position of each item in the text for messages.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// File name as given by the user.
    pub name: String,
    /// Text of the file.
    pub text: String,
    /// Contents of the file. They may be changed before loading; messages about added items give only the key.
    pub scene: Scene,
}

/// Source of a scene's packages, such as a folder, an archive or a server. Implemented for functions from the path in
/// the file to the package.
pub trait PackageSource {
    /// Returns the package at `path`, or an error message.
    ///
    /// The source defines the errors.
    fn read(&self, path: &str) -> Result<NamedPackage<'static>, String>;

    /// Returns an identity of the package at `path`. Paths with equal identities refer to one package, which is read
    /// once.
    fn identity(&self, path: &str) -> PathBuf {
        path.into()
    }
}

impl<F: Fn(&str) -> Result<NamedPackage<'static>, String>> PackageSource for F {
    fn read(&self, path: &str) -> Result<NamedPackage<'static>, String> {
        self(path)
    }
}

/// Scene with its packages loaded.
#[derive(Debug)]
pub struct LoadedScene {
    /// Packages, each listed once, in the order in which models name them.
    pub packages: Vec<NamedPackage<'static>>,
    /// Copies of the packages' models.
    pub actors: Vec<Actor>,
    /// Names of [`Self::actors`], in the same order.
    pub names: Vec<String>,
    /// Camera; with `None` all models are framed.
    pub camera: Option<CameraTrack>,
}

impl SceneFile {
    /// Parses the bytes of a scene file. `name` is its name for messages.
    ///
    /// Fails with [`StageError::Input`] with line and key of the fault.
    pub fn parse(name: &str, bytes: Vec<u8>) -> Result<Self, StageError> {
        let text = String::from_utf8(bytes).map_err(|error| StageError::Input {
            file: name.to_owned(),
            place: format!("byte {}", error.utf8_error().valid_up_to()),
            reason: "is not UTF-8, expected a scene file in TOML".into(),
        })?;
        // Some editors start text files with a byte order mark.
        let text = text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text);
        let source = TomlText { name, text: &text };
        let scene: Scene = source.parse()?;
        if scene.models.is_empty() {
            return Err(source.fault("model", "found none, expected at least one [[model]] with a package"));
        }
        Ok(Self { name: name.to_owned(), text, scene })
    }

    /// Returns an error at a key such as `view.size`.
    pub(crate) fn fault(&self, key: &str, reason: impl Into<String>) -> StageError {
        self.source().fault(key, reason)
    }

    fn source(&self) -> TomlText<'_> {
        TomlText { name: &self.name, text: &self.text }
    }

    /// Returns the number of pictures, if the scene specifies it.
    pub fn frames(&self) -> Option<u32> {
        Some(self.scene.sequence?.frames?.0)
    }

    /// Returns the pictures per second, if the scene specifies it.
    pub fn fps(&self) -> Option<u32> {
        Some(self.scene.sequence?.fps?.0)
    }

    /// Checks the scene and reads the packages that it names.
    ///
    /// Fails with [`StageError::Input`] with line and key of the fault, also for a package that cannot be read or that
    /// lacks a clip. [`StageError::Package`] for a damaged package.
    pub fn load(&self, packages: &dyn PackageSource) -> Result<LoadedScene, StageError> {
        let (source, scene) = (self.source(), &self.scene);
        if scene.models.is_empty() {
            return Err(source.fault("model", "found none, expected at least one [[model]] with a package"));
        }
        if scene.models.len() > MAX_COPIES as usize {
            let reason = format!("found {} models, expected at most {MAX_COPIES}", scene.models.len());
            return Err(source.fault("model", reason));
        }
        check_light(&source, scene.light.as_ref())?;
        let camera = scene.camera.as_ref().map(|camera| shot(&source, camera)).transpose()?;
        let names = names(&source, &scene.models)?;
        scene.models.iter().enumerate().try_for_each(|(i, model)| check_clip(&source, i, model))?;
        let places = scene.models.iter().enumerate().map(|(i, model)| place(&source, i, model));
        let places = places.collect::<Result<Vec<_>, StageError>>()?;
        let (packages, whose) = read_packages(&source, packages, &scene.models)?;
        let mut animations = Vec::new();
        for file in &packages {
            animations.push(file.open()?.animation().map_err(|error| file.fault(error))?.unwrap_or_default());
        }
        let mut actors = Vec::new();
        for (i, ((model, place), package)) in scene.models.iter().zip(places).zip(whose).enumerate() {
            let clip = playing(&source, i, model, &packages[package].name, &animations[package])?;
            let morphs = weights(&source, i, model, &packages[package].name, &animations[package])?;
            let carried = cycle_displacement(&source, i, model, clip, &animations[package])?;
            actors.push(Actor { package, place, clip, fade_to: None, cycle_displacement: carried, morphs });
        }
        Ok(LoadedScene { packages, actors, names, camera })
    }
}

impl LoadedScene {
    /// Returns the cast of the scene. Its camera is `camera` if given, else the one from `framing` if that is set, else
    /// the scene's own. Without any, the camera frames all models ([`frame_actors`]).
    ///
    /// * `aspect`: width of the picture divided by its height
    ///
    /// Fails with [`StageError::Package`] for a damaged package, [`StageError::Request`] if nothing matches the name to
    /// look at.
    pub fn cast(&self, camera: Option<Viewpoint>, aspect: f32, framing: &Framing) -> Result<Cast<'_>, StageError> {
        let open = |file| Ok((file, Arc::new(NamedPackage::open(file)?)));
        let packages = self.packages.iter().map(open).collect::<Result<Vec<_>, StageError>>()?;
        let asked = framing.orbit.is_some() || framing.look_at.is_some();
        let camera = match (camera, self.camera.as_ref().filter(|_| !asked)) {
            (Some(camera), _) => CameraTrack::fixed(camera),
            (None, Some(shot)) => shot.clone(),
            (None, None) => CameraTrack::fixed(frame_actors(&packages, &self.actors, aspect, framing)?),
        };
        Ok(Cast { packages, actors: self.actors.clone(), camera })
    }
}

fn check_light(source: &TomlText<'_>, light: Option<&SceneLight>) -> Result<(), StageError> {
    match light {
        Some(SceneLight { direction: Some(towards), position: None }) if towards.0.try_normalize().is_none() => {
            Err(source.fault("light.direction", "found a direction that is zero, expected one such as [1, 2, 1]"))
        }
        Some(SceneLight { direction: Some(_), position: Some(_) }) => {
            Err(source.fault("light", "found direction and position, expected one of them"))
        }
        Some(SceneLight { direction: None, position: None }) => {
            Err(source.fault("light", "found neither, expected direction or position"))
        }
        _ => Ok(()),
    }
}

fn shot(source: &TomlText<'_>, camera: &SceneCamera) -> Result<CameraTrack, StageError> {
    let fov = |fov: Option<FieldOfView>| fov.map_or(FOV_DEG, |fov| fov.0);
    let keys: Vec<(String, f32, Vec3, Vec3, f32)> = match (camera.eye, camera.target, &camera.path) {
        (Some(eye), Some(target), None) => vec![("camera.target".into(), 0.0, eye.0, target.0, fov(camera.fov_deg))],
        (None, None, Some(path)) if camera.fov_deg.is_none() => {
            let key = |(i, k): (usize, &CameraKey)| {
                (format!("camera.path[{i}].target"), k.time_s.0, k.eye.0, k.target.0, fov(k.fov_deg))
            };
            path.iter().enumerate().map(key).collect()
        }
        (_, _, Some(_)) => {
            let reason = "found a path together with eye, target or fov_deg, expected these in the keys of the path";
            return Err(source.fault("camera", reason));
        }
        _ => return Err(source.fault("camera", "expected eye and target, or a path")),
    };
    if let Some((place, ..)) = keys.iter().find(|(_, _, eye, target, _)| eye == target) {
        return Err(source.fault(place, "found the same point as the eye, expected different points"));
    }
    Ok(CameraTrack {
        eye: source.track("camera.path", keys.iter().map(|k| (k.1, k.2)).collect())?,
        target: source.track("camera.path", keys.iter().map(|k| (k.1, k.3)).collect())?,
        fov_deg: source.track("camera.path", keys.iter().map(|k| (k.1, k.4)).collect())?,
    })
}

fn names(source: &TomlText<'_>, models: &[SceneModel]) -> Result<Vec<String>, StageError> {
    for (i, model) in models.iter().enumerate() {
        let same = |other: &SceneModel| other.name.is_some() && other.name == model.name;
        if let Some(first) = models[..i].iter().position(same) {
            let reason = format!("found the name of model[{first}] again, expected a different name or none");
            return Err(source.fault(&format!("model[{i}].name"), reason));
        }
    }
    let stem = |package: &str| Path::new(package).file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let name = |model: &SceneModel| model.name.clone().or_else(|| stem(&model.package)).unwrap_or_default();
    Ok(models.iter().map(name).collect())
}

/// Rejects playback settings of a model without a clip.
fn check_clip(source: &TomlText<'_>, i: usize, model: &SceneModel) -> Result<(), StageError> {
    let given = [
        ("speed", model.speed.is_some()),
        ("start_s", model.start_s.is_some()),
        ("loop", model.looped.is_some()),
        ("root_motion", model.root_motion),
    ];
    match given.iter().find(|(_, given)| model.clip.is_none() && *given) {
        Some((name, _)) => {
            let key = format!("model[{i}].{name}");
            Err(source.fault(&key, "found without a clip, expected a clip in the same [[model]]"))
        }
        None => Ok(()),
    }
}

fn place(source: &TomlText<'_>, i: usize, model: &SceneModel) -> Result<Placement, StageError> {
    let scale = model.scale.map_or(1.0, |scale| scale.0);
    let key = |name: &str| format!("model[{i}].{name}");
    let Some(path) = &model.path else {
        let heading_deg = Track::fixed(model.heading_deg.map_or(0.0, |heading| heading.0));
        let position = Track::fixed(model.position.map_or(Vec3::ZERO, |position| position.0));
        return Ok(Placement { position, heading_deg: Some(heading_deg), scale });
    };
    for (name, given) in [("position", model.position.is_some()), ("heading_deg", model.heading_deg.is_some())] {
        if given {
            return Err(source.fault(&key(name), "found beside a path, expected it in the keys of the path"));
        }
    }
    let position = source.track(&key("path"), path.iter().map(|k| (k.time_s.0, k.position.0)).collect())?;
    let turned = |k: &PlaceKey| Some((k.time_s.0, k.heading_deg?.0));
    let headings: Vec<_> = path.iter().map(turned).collect();
    let heading_deg = if headings.iter().all(Option::is_none) {
        None
    } else if let Some(without) = headings.iter().position(Option::is_none) {
        let reason = "found no heading_deg here and one in another key, expected it in all keys of the path or in none";
        return Err(source.fault(&key(&format!("path[{without}]")), reason));
    } else {
        Some(source.track(&key("path"), headings.into_iter().flatten().collect())?)
    };
    Ok(Placement { position, heading_deg, scale })
}

/// Reads every package that the models name once. Also returns the package index of each model.
fn read_packages(
    source: &TomlText<'_>,
    packages: &dyn PackageSource,
    models: &[SceneModel],
) -> Result<(Vec<NamedPackage<'static>>, Vec<usize>), StageError> {
    let (mut files, mut paths, mut whose) = (Vec::new(), Vec::<PathBuf>::new(), Vec::new());
    for (i, model) in models.iter().enumerate() {
        let identity = packages.identity(&model.package);
        let known = paths.iter().position(|known| *known == identity);
        whose.push(known.unwrap_or(files.len()));
        if known.is_none() {
            let read = packages.read(&model.package);
            files.push(read.map_err(|reason| source.fault(&format!("model[{i}].package"), reason))?);
            paths.push(identity);
        }
    }
    Ok((files, whose))
}

fn playing(
    source: &TomlText<'_>,
    i: usize,
    model: &SceneModel,
    package: &str,
    animation: &Animation,
) -> Result<Option<Playback>, StageError> {
    let Some(name) = &model.clip else { return Ok(None) };
    let (clip, duration_s) = clip_named(animation, name).map_err(|has| {
        let reason = format!("found {name:?}, expected a clip of {package}, which {has}");
        source.fault(&format!("model[{i}].clip"), reason)
    })?;
    Ok(Some(Playback {
        clip,
        duration_s,
        start_s: model.start_s.map_or(0.0, |start| start.0),
        speed: model.speed.map_or(1.0, |speed| speed.0),
        looped: model.looped.unwrap_or(true),
    }))
}

/// Returns the displacement of a model per cycle of its clip; zero without root motion.
fn cycle_displacement(
    source: &TomlText<'_>,
    i: usize,
    model: &SceneModel,
    clip: Option<Playback>,
    animation: &Animation,
) -> Result<Vec3, StageError> {
    let Some(playing) = clip.filter(|_| model.root_motion) else { return Ok(Vec3::ZERO) };
    let way = root_displacement(animation, playing.clip);
    if way.length() < MIN_DISPLACEMENT_M {
        let name = &animation.clips[playing.clip].name;
        let reason = format!(
            "found true, but the clip {name:?} ends where it began, expected one that moves its root, or a path"
        );
        return Err(source.fault(&format!("model[{i}].root_motion"), reason));
    }
    Ok(way)
}

/// Returns index and weight of each morph target that a model sets.
fn weights(
    source: &TomlText<'_>,
    i: usize,
    model: &SceneModel,
    package: &str,
    animation: &Animation,
) -> Result<Vec<(usize, f32)>, StageError> {
    let found = |(name, weight): (&String, &Number)| match morph_named(animation, name) {
        Ok(target) => Ok((target, weight.0)),
        Err(has) => {
            let reason = format!("found {name:?}, expected a morph target of {package}, which {has}");
            Err(source.fault(&format!("model[{i}].morphs.{name}"), reason))
        }
    };
    model.morphs.iter().map(found).collect()
}

#[cfg(test)]
mod tests;
