//! Scene files: several models, their paths and clips, a camera and a light, as TOML. `assets/scenes` has one with comments.
//!
//! Lengths are metres, times seconds, angles degrees; +y is up. A key that does not exist is an error.
//!
//! | key | default | meaning |
//! |---|---|---|
//! | `[view]` | | options of `pelage render` about the picture, with `_` for `-`: `size = "834x424"`, `style = "ink"`, `ink_mist = "5,60"`, `self_shadow = "off"` |
//! | `camera.eye`, `.target`, `.fov_deg` | frames all models as they stand at time 0; 30 | from where, to where, and the height of the view |
//! | `camera.path` | | instead of them: a list of `{ time_s, eye, target, fov_deg }`, see [`super::track`] |
//! | `light.direction` or `.position` | the default light | towards a distant light, or the place of a near one |
//! | `sequence.frames`, `.fps` | , 24 | how many pictures where they are numbered or a video, and how many a second |
//! | `[[model]]` | | once for every model: |
//! | `name` | the package's, without `.pelage` | its name in results |
//! | `package` | must be said | path of its package from the scene file's folder; models may share one, which is loaded once |
//! | `position`, `heading_deg` | the origin, 0 | where it stands, and where to it looks: 0 along +z, 90 along +x |
//! | `path` | | instead of them: a list of `{ time_s, position, heading_deg }`; without any heading the model looks where it goes |
//! | `scale` | 1 | its size beside the baked one |
//! | `clip` | at rest | what it plays, by name |
//! | `speed`, `start_s` | 1, 0 | seconds of the clip in a second, and its moment at time 0 |
//! | `loop` | true | whether the clip begins anew at its end, or holds there |
//!
//! Arguments of the command line go before what the file says.

mod text;

use super::cast::{Actor, Cast, Place, Playing, Shot, camera_of, clip_named, rest_points};
use super::exit::Failure;
use super::framing::FOV_DEG;
use super::package_file::PackageFile;
use super::render_option;
use super::track::Track;
use super::view::View;
use super::view_args::{Direction, Position, ViewArgs};
use glam::Vec3;
use pelage_bake::BakeError;
use pelage_formats::Animation;
use std::path::{Path, PathBuf};
use text::{CameraText, LightText, ModelText, PlaceKey, SceneText, Source};

/// A scene with its packages.
pub struct SceneFile {
    /// As the user named it.
    pub name: String,
    /// All of it.
    pub text: String,
    /// The packages, each once, in the order in which models name them.
    pub packages: Vec<PackageFile>,
    /// Of [`Self::actors`].
    pub names: Vec<String>,
    /// Pictures, where the file says how many.
    pub frames: Option<u32>,
    /// Pictures a second, where the file says it.
    pub fps: Option<u32>,
    /// What the file says in words of the command line: `--size=834x424`.
    pub options: Vec<String>,
    light: Option<LightText>,
    actors: Vec<Actor>,
    camera: Option<Shot>,
}

impl SceneFile {
    /// Takes the bytes of the scene file at `path`, and reads the packages that it names.
    ///
    /// # Errors
    ///
    /// Line and key of what is wrong, also for a package that cannot be read and a clip that is not in it.
    pub fn new(path: &Path, bytes: Vec<u8>) -> Result<Self, Failure> {
        let name = path.display().to_string();
        let fail = |place: String, reason: &str| BakeError::Input { file: name.clone(), place, reason: reason.into() };
        let text = String::from_utf8(bytes).map_err(|error| {
            fail(format!("byte {}", error.utf8_error().valid_up_to()), "is no UTF-8, expected a scene file in TOML")
        })?;
        // Some editors begin a text file with a byte order mark.
        let text = text.strip_prefix('\u{feff}').map_or(text.clone(), str::to_owned);
        let source = Source { name: &name, text: &text };
        let words = source.parse()?;
        if words.models.is_empty() {
            return Err(source.fault("model", "found none, expected at least one [[model]] with a package").into());
        }
        let options = options(&source, &words)?;
        check_light(&source, words.light.as_ref())?;
        let camera = words.camera.as_ref().map(|camera| shot(&source, camera)).transpose()?;
        let names = names(&source, &words.models)?;
        words.models.iter().enumerate().try_for_each(|(i, model)| check_clip(&source, i, model))?;
        let places = words.models.iter().enumerate().map(|(i, model)| place(&source, i, model));
        let places = places.collect::<Result<Vec<_>, BakeError>>()?;
        let (packages, whose) = packages(&source, path.parent().unwrap_or(Path::new("")), &words.models)?;
        let mut animations = Vec::new();
        for file in &packages {
            animations.push(file.open()?.animation().map_err(|error| file.fault(error))?.unwrap_or_default());
        }
        let mut actors = Vec::new();
        for (i, ((model, place), package)) in words.models.iter().zip(places).zip(whose).enumerate() {
            let clip = playing(&source, i, model, &packages[package].name, &animations[package])?;
            actors.push(Actor { package, place, clip });
        }
        let sequence = words.sequence;
        let frames = sequence.and_then(|s| s.frames).map(|frames| frames.0);
        let fps = sequence.and_then(|s| s.fps).map(|fps| fps.0);
        Ok(Self { name, text, packages, names, frames, fps, options, light: words.light, actors, camera })
    }

    /// The arguments, which [`Self::options`] are among, and where they are silent the file's light.
    ///
    /// # Errors
    ///
    /// [`Failure::Usage`] for arguments that make no sense with a scene.
    pub fn complete(&self, args: &ViewArgs) -> Result<ViewArgs, Failure> {
        for (name, given) in [("--clip", args.clip.is_some()), ("--crowd", args.crowd != 1)] {
            if given {
                let text = format!("{name}: {} says what stands in the picture, expected it to be left out", self.name);
                return Err(Failure::Usage(text));
            }
        }
        let mut args = args.clone();
        if let (Some(light), None, None) = (&self.light, args.light, args.point_light) {
            args.light = light.direction.map(|towards| Direction(towards.0.normalize()));
            args.point_light = light.position.map(|position| Position(position.0));
        }
        Ok(args)
    }

    /// Who plays, seen from the camera of `view`, else the file's, else one that frames all of them.
    pub fn cast(&self, view: &View) -> Result<Cast<'_>, Failure> {
        let camera = match (view.camera, &self.camera) {
            (Some(camera), _) => Shot::fixed(camera),
            (None, Some(shot)) => shot.clone(),
            (None, None) => self.framing(view)?,
        };
        Ok(Cast { packages: self.packages.iter().collect(), actors: self.actors.clone(), camera })
    }

    /// A camera that sees all models at rest where they stand at time 0.
    fn framing(&self, view: &View) -> Result<Shot, Failure> {
        let mut points = Vec::new();
        let mut margin_m = 0.0_f32;
        for (index, file) in self.packages.iter().enumerate() {
            let package = file.open()?;
            let skeleton = package.animation().map_err(|error| file.fault(error))?;
            let rest = rest_points(file, &package, skeleton.as_deref())?;
            for actor in self.actors.iter().filter(|actor| actor.package == index) {
                let transform = actor.place.transform(0.0);
                points.extend(rest.iter().map(|point| transform.transform_point3(*point)));
                margin_m = margin_m.max(package.manifest().fur.height_m * actor.place.scale);
            }
        }
        Ok(Shot::fixed(camera_of(view, &points, margin_m)))
    }
}

/// Options that have another place in a scene, or none.
const ELSEWHERE: [(&str, &str); 9] = [
    ("camera", "in [camera]"),
    ("light", "in [light]"),
    ("point_light", "as position in [light]"),
    ("frames", "in [sequence]"),
    ("fps", "in [sequence]"),
    ("clip", "in a [[model]]"),
    ("crowd", "as several [[model]]"),
    ("time", "on the command line"),
    ("output", "on the command line"),
];

/// `[view]` as words of the command line.
fn options(source: &Source<'_>, words: &SceneText) -> Result<Vec<String>, BakeError> {
    let mut options = Vec::new();
    for (name, value) in &words.view {
        let fail = |reason: String| source.fault(&format!("view.{name}"), reason);
        if let Some((_, place)) = ELSEWHERE.iter().find(|(key, _)| key == name) {
            return Err(fail(format!("expected it {place}")));
        }
        let values = value.as_array().map_or(std::slice::from_ref(value), Vec::as_slice);
        for value in values {
            let value = match value {
                toml::Value::String(text) => text.clone(),
                toml::Value::Boolean(on) => if *on { "on" } else { "off" }.to_owned(),
                toml::Value::Integer(_) | toml::Value::Float(_) => value.to_string(),
                other => return Err(fail(format!("found {}, expected a word or a number", other.type_str()))),
            };
            let option = format!("--{}={value}", name.replace('_', "-"));
            render_option(&option).map_err(fail)?;
            options.push(option);
        }
    }
    Ok(options)
}

fn check_light(source: &Source<'_>, light: Option<&LightText>) -> Result<(), BakeError> {
    match light {
        Some(LightText { direction: Some(towards), position: None }) if towards.0.try_normalize().is_none() => {
            Err(source.fault("light.direction", "found a direction of no length, expected one such as [1, 2, 1]"))
        }
        Some(LightText { direction: Some(_), position: Some(_) }) => {
            Err(source.fault("light", "found direction and position, expected one of them"))
        }
        Some(LightText { direction: None, position: None }) => {
            Err(source.fault("light", "found neither, expected direction or position"))
        }
        _ => Ok(()),
    }
}

fn shot(source: &Source<'_>, camera: &CameraText) -> Result<Shot, BakeError> {
    let fov = |fov: Option<text::FieldOfView>| fov.map_or(FOV_DEG, |fov| fov.0);
    let keys: Vec<(String, f32, Vec3, Vec3, f32)> = match (camera.eye, camera.target, &camera.path) {
        (Some(eye), Some(target), None) => vec![("camera.target".into(), 0.0, eye.0, target.0, fov(camera.fov_deg))],
        (None, None, Some(path)) if camera.fov_deg.is_none() => {
            let key = |(i, k): (usize, &text::CameraKey)| {
                (format!("camera.path[{i}].target"), k.time_s.0, k.eye.0, k.target.0, fov(k.fov_deg))
            };
            path.iter().enumerate().map(key).collect()
        }
        (_, _, Some(_)) => {
            let reason = "found a path and eye, target or fov_deg beside it, expected them in the keys of the path";
            return Err(source.fault("camera", reason));
        }
        _ => return Err(source.fault("camera", "expected eye and target, or a path")),
    };
    if let Some((place, ..)) = keys.iter().find(|(_, _, eye, target, _)| eye == target) {
        return Err(source.fault(place, "found the same point as the eye, expected them apart"));
    }
    Ok(Shot {
        eye: source.track("camera.path", keys.iter().map(|k| (k.1, k.2)).collect())?,
        target: source.track("camera.path", keys.iter().map(|k| (k.1, k.3)).collect())?,
        fov_deg: source.track("camera.path", keys.iter().map(|k| (k.1, k.4)).collect())?,
    })
}

/// What the models are called in results.
fn names(source: &Source<'_>, models: &[ModelText]) -> Result<Vec<String>, BakeError> {
    for (i, model) in models.iter().enumerate() {
        let same = |other: &ModelText| other.name.is_some() && other.name == model.name;
        if let Some(first) = models[..i].iter().position(same) {
            let reason = format!("found the name of model[{first}] again, expected another or none");
            return Err(source.fault(&format!("model[{i}].name"), reason));
        }
    }
    let stem = |package: &str| Path::new(package).file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let name = |model: &ModelText| model.name.clone().or_else(|| stem(&model.package)).unwrap_or_default();
    Ok(models.iter().map(name).collect())
}

/// How a clip plays means nothing where none does.
fn check_clip(source: &Source<'_>, i: usize, model: &ModelText) -> Result<(), BakeError> {
    let given =
        [("speed", model.speed.is_some()), ("start_s", model.start_s.is_some()), ("loop", model.looped.is_some())];
    match given.iter().find(|(_, given)| model.clip.is_none() && *given) {
        Some((name, _)) => {
            let key = format!("model[{i}].{name}");
            Err(source.fault(&key, "found without a clip, expected clip beside it"))
        }
        None => Ok(()),
    }
}

fn place(source: &Source<'_>, i: usize, model: &ModelText) -> Result<Place, BakeError> {
    let scale = model.scale.map_or(1.0, |scale| scale.0);
    let key = |name: &str| format!("model[{i}].{name}");
    let Some(path) = &model.path else {
        let heading_deg = Track::fixed(model.heading_deg.map_or(0.0, |heading| heading.0));
        let position = Track::fixed(model.position.map_or(Vec3::ZERO, |position| position.0));
        return Ok(Place { position, heading_deg: Some(heading_deg), scale });
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
    Ok(Place { position, heading_deg, scale })
}

/// Reads every package that the models name, once; with it which one each model has.
fn packages(
    source: &Source<'_>,
    folder: &Path,
    models: &[ModelText],
) -> Result<(Vec<PackageFile>, Vec<usize>), Failure> {
    let (mut files, mut paths, mut whose) = (Vec::new(), Vec::<PathBuf>::new(), Vec::new());
    for (i, model) in models.iter().enumerate() {
        let path = folder.join(&model.package);
        // Two ways to one file are one; what cannot be found is said below.
        let real = std::fs::canonicalize(&path).unwrap_or_else(|_| path.clone());
        let known = paths.iter().position(|known| *known == real);
        whose.push(known.unwrap_or(files.len()));
        if known.is_none() {
            let read = PackageFile::read(&path);
            files.push(read.map_err(|error| source.fault(&format!("model[{i}].package"), error.to_string()))?);
            paths.push(real);
        }
    }
    Ok((files, whose))
}

fn playing(
    source: &Source<'_>,
    i: usize,
    model: &ModelText,
    package: &str,
    animation: &Animation,
) -> Result<Option<Playing>, BakeError> {
    let Some(name) = &model.clip else { return Ok(None) };
    let (clip, duration_s) = clip_named(animation, name).map_err(|has| {
        let reason = format!("found {name:?}, expected a clip of {package}, which {has}");
        source.fault(&format!("model[{i}].clip"), reason)
    })?;
    Ok(Some(Playing {
        clip,
        duration_s,
        start_s: model.start_s.map_or(0.0, |start| start.0),
        speed: model.speed.map_or(1.0, |speed| speed.0),
        looped: model.looped.unwrap_or(true),
    }))
}

#[cfg(test)]
mod tests;
