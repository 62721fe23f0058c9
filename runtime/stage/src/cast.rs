//! Models of a picture, with the position of each model and of the camera over time. Independent of a device.

use crate::extent::{no_match_error, outline};
use crate::framing::{Framing, outermost};
use crate::track::Track;
use crate::{CameraTrack, NamedPackage, StageError, Viewpoint};
use glam::{Mat3, Mat4, Quat, Vec3};
use pelage_formats::{Animation, ClipLayer, Manifest, Package, Pose};
use std::sync::Arc;

/// Maximum number of models in a picture. Each has its own pose, and takes memory even if it shares its package.
pub const MAX_COPIES: u32 = 10_000;

/// Number of samples between two keys of a path; its curve may overshoot the keys.
const MOMENTS_PER_KEY: usize = 8;

/// Contents of a picture over time.
#[derive(Clone, Debug)]
pub struct Cast<'a> {
    /// Packages, each listed and opened once, so that all users share the parsed sections.
    pub packages: Vec<(&'a NamedPackage<'a>, Arc<Package<'a>>)>,
    /// Copies of the packages' models; at least one.
    pub actors: Vec<Actor>,
    /// Camera over time.
    pub camera: CameraTrack,
}

impl Cast<'_> {
    /// Returns whether all packages have fibre data, so that hair scatters light as fibres do.
    ///
    /// Fails with [`StageError::Package`] for a damaged package.
    pub fn has_fibres(&self) -> Result<bool, StageError> {
        for (file, package) in &self.packages {
            if package.fibres().map_err(|error| file.fault(error))?.is_none() {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

/// A copy of a package's model.
#[derive(Clone, Debug, PartialEq)]
pub struct Actor {
    /// Index into [`Cast::packages`].
    pub package: usize,
    /// Position and heading over time.
    pub place: Placement,
    /// Clip that is played; `None` at rest.
    pub clip: Option<Playback>,
    /// Clip to which the current one fades, and progress of the fade, 0..=1.
    pub fade_to: Option<(Playback, f32)>,
    /// Displacement per cycle of the clip, in model space, as returned by [`root_displacement`]. When the clip
    /// restarts, the model continues from the displaced position. With zero it stays at the same position.
    pub cycle_displacement: Vec3,
    /// Morph targets with weights that override those of the clips: index and weight.
    pub morphs: Vec<(usize, f32)>,
}

impl Actor {
    /// Returns whether position or pose change over time.
    pub fn moves(&self) -> bool {
        let Placement { position, heading_deg, scale: _ } = &self.place;
        self.clip.is_some()
            || self.fade_to.is_some()
            || position.is_animated()
            || heading_deg.as_ref().is_some_and(Track::is_animated)
    }
}

/// Position, heading and size over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Position in metres.
    pub position: Track<Vec3>,
    /// Heading about the vertical axis, degrees from +z towards +x. With `None` the model faces along the path, as
    /// given by [`Track::direction`].
    pub heading_deg: Option<Track<f32>>,
    /// Scale factor; 1 is the size as baked.
    pub scale: f32,
}

/// Playback of a clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playback {
    /// Index of the clip in its package.
    pub clip: usize,
    /// Length of the clip, seconds.
    pub duration_s: f32,
    /// Time within the clip at time 0 of the scene, seconds.
    pub start_s: f32,
    /// Playback speed, seconds of the clip per second of the scene.
    pub speed: f32,
    /// Whether the clip restarts at its end; otherwise it holds its last pose.
    pub looped: bool,
}

impl Placement {
    /// Returns a fixed position; the model faces +z.
    pub fn fixed(position: Vec3) -> Self {
        Self { position: Track::fixed(position), heading_deg: Some(Track::fixed(0.0)), scale: 1.0 }
    }

    /// Returns the transform from model to world space at `time_s`.
    pub fn transform(&self, time_s: f32) -> Mat4 {
        let heading_rad = match &self.heading_deg {
            Some(track) => track.at(time_s).to_radians(),
            None => self.position.direction(time_s).map_or(0.0, |way| way.x.atan2(way.z)),
        };
        let turn = Quat::from_rotation_y(heading_rad);
        Mat4::from_scale_rotation_translation(Vec3::splat(self.scale), turn, self.position.at(time_s))
    }
}

impl Actor {
    /// Returns the transform from model to world space at `time_s`. Includes the displacement of completed cycles of
    /// the clip.
    pub fn transform(&self, time_s: f32) -> Mat4 {
        let rounds = self.clip.map_or(0.0, |playing| playing.cycles(time_s));
        self.place.transform(time_s) * Mat4::from_translation(rounds * self.cycle_displacement)
    }

    /// Returns the clip layers of the actor's pose at `time_s`; empty at rest.
    pub fn layers(&self, time_s: f32) -> Vec<ClipLayer> {
        let wholly = self.clip.map(|playing| playing.layer(time_s, 1.0));
        wholly.into_iter().chain(self.fade_to.map(|(playing, share)| playing.layer(time_s, share))).collect()
    }
}

impl Playback {
    /// Returns looped playback of the named clip, from its beginning and at speed 1. `None` without a name.
    ///
    /// * `package`: the opened `file`
    ///
    /// Fails with the errors of [`find_clip`].
    pub fn named(
        file: &NamedPackage<'_>,
        package: &Package<'_>,
        name: Option<&str>,
    ) -> Result<Option<Self>, StageError> {
        let found = find_clip(file, package, name)?;
        Ok(found.map(|(clip, duration_s)| Self { clip, duration_s, start_s: 0.0, speed: 1.0, looped: true }))
    }

    /// Returns the clip as a layer of a pose, with the weight `share`.
    pub fn layer(&self, time_s: f32, share: f32) -> ClipLayer {
        ClipLayer { clip: Some(self.clip), time_s: self.moment(time_s), share }
    }

    /// Returns the time within the clip, seconds; `time_s` is the time of the scene.
    pub fn moment(&self, time_s: f32) -> f32 {
        let time_s = self.start_s + self.speed * time_s;
        if self.looped { wrap_time(time_s, self.duration_s) } else { time_s.min(self.duration_s).max(0.0) }
    }

    /// Returns how often the clip has restarted at scene time `time_s`. Negative before the clip's beginning, 0 if it
    /// does not loop.
    pub fn cycles(&self, time_s: f32) -> f32 {
        if !self.looped || self.duration_s <= 0.0 {
            return 0.0;
        }
        ((self.start_s + self.speed * time_s - self.moment(time_s)) / self.duration_s).round()
    }
}

impl<'a> Cast<'a> {
    /// Creates copies of one package's model, side by side on a grid. All are at the same time of the named clip
    /// (`None`: at rest). Without `camera`, [`frame_actors`] makes one that shows all of them.
    ///
    /// * `package`: the opened `file`
    /// * `aspect`: width of the picture divided by its height
    ///
    /// Fails with [`StageError::Request`] if the clip, or the named part to look at, does not exist.
    /// [`StageError::Package`] for a damaged package.
    pub fn crowd(
        file: &'a NamedPackage<'a>,
        package: Package<'a>,
        clip: Option<&str>,
        copies: u32,
        camera: Option<Viewpoint>,
        (framing, aspect): (&Framing, f32),
    ) -> Result<Self, StageError> {
        let clip = Playback::named(file, &package, clip)?;
        let actor = |place| Actor {
            package: 0,
            place: Placement::fixed(place),
            clip,
            fade_to: None,
            cycle_displacement: Vec3::ZERO,
            morphs: Vec::new(),
        };
        let actors: Vec<Actor> = crowd_positions(package.manifest(), copies).into_iter().map(actor).collect();
        let packages = vec![(file, Arc::new(package))];
        let camera = match camera {
            Some(camera) => camera,
            None => frame_actors(&packages, &actors, aspect, framing)?,
        };
        Ok(Self { packages, actors, camera: CameraTrack::fixed(camera) })
    }

    /// Returns the cast with every actor fading from its clip to the named one.
    ///
    /// * `share`: progress of the fade, 0..=1
    ///
    /// Fails with [`StageError::Request`] if a package has no such clip, [`StageError::Package`] for a damaged one.
    pub fn fading_to(mut self, name: &str, share: f32) -> Result<Self, StageError> {
        for actor in &mut self.actors {
            let Some((file, package)) = self.packages.get(actor.package) else { continue };
            actor.fade_to = Playback::named(file, package, Some(name))?.map(|playing| (playing, share));
        }
        Ok(self)
    }

    /// Returns the cast with the named morph target of every actor at `weight`.
    ///
    /// Fails with the errors of [`find_morph`].
    pub fn morphing(mut self, name: &str, weight: f32) -> Result<Self, StageError> {
        for actor in &mut self.actors {
            let Some((file, package)) = self.packages.get(actor.package) else { continue };
            actor.morphs.push((find_morph(file, package, name)?, weight));
        }
        Ok(self)
    }
}

/// Wraps a time into the duration of a looped clip.
pub fn wrap_time(time_s: f32, duration_s: f32) -> f32 {
    let inside = (0.0..=duration_s).contains(&time_s) || duration_s <= 0.0;
    if inside { time_s } else { time_s.rem_euclid(duration_s) }
}

/// Returns the displacement of the skeleton's root from a clip's start to its end, in model space. Zero for a clip in
/// place. Ignores the root's rotation at the end.
pub fn root_displacement(animation: &Animation, clip: usize) -> Vec3 {
    let Some(duration_s) = animation.clips.get(clip).map(|clip| clip.duration_s) else { return Vec3::ZERO };
    // Parents precede their children, so the joint with the lowest node index is the root.
    let Some(root) = (0..animation.joints.len()).min_by_key(|joint| animation.joints[*joint].node) else {
        return Vec3::ZERO;
    };
    let bind = Mat4::from_cols_array(&animation.joints[root].inverse_bind).inverse();
    let mut pose = Pose::default();
    let [begin, end] = [0.0, duration_s].map(|time_s| {
        pose.sample(animation, Some(clip), time_s);
        (pose.joints[root] * bind).w_axis.truncate()
    });
    Some(end - begin).filter(|way| way.is_finite()).unwrap_or_default()
}

/// Returns index and length of the named clip.
pub fn find_clip(
    file: &NamedPackage<'_>,
    package: &Package<'_>,
    name: Option<&str>,
) -> Result<Option<(usize, f32)>, StageError> {
    let Some(name) = name else { return Ok(None) };
    let animation = package.animation().map_err(|e| file.fault(e))?.unwrap_or_default();
    clip_named(&animation, name).map(Some).map_err(|has| StageError::Request {
        what: format!("clip {name}"),
        reason: format!("no such clip; {} {has}", file.name),
    })
}

/// Returns the index of the first morph target with that name.
///
/// Fails with [`StageError::Request`] if the package has none of that name, [`StageError::Package`] for a damaged one.
pub fn find_morph(file: &NamedPackage<'_>, package: &Package<'_>, name: &str) -> Result<usize, StageError> {
    let animation = package.animation().map_err(|e| file.fault(e))?.unwrap_or_default();
    morph_named(&animation, name).map_err(|has| {
        let (what, reason) = (format!("morph target {name}"), format!("no such target; {} {has}", file.name));
        StageError::Request { what, reason }
    })
}

/// Returns the index of the first morph target with that name. If there is none, returns a text that lists the targets.
pub(crate) fn morph_named(animation: &Animation, name: &str) -> Result<usize, String> {
    let targets = &animation.morphs.targets;
    targets.iter().position(|target| target.name == name).ok_or_else(|| {
        let names: Vec<_> = targets.iter().map(|target| target.name.as_str()).collect();
        if names.is_empty() { "has none".into() } else { format!("has {}", names.join(", ")) }
    })
}

/// Returns index and length in seconds of the named clip, or a text that lists the clips. Exporters prefix the
/// skeleton's name, as in `AnimalArmature|Walk`. `Walk` finds this clip unless another clip has the same ending.
pub fn clip_named(animation: &Animation, name: &str) -> Result<(usize, f32), String> {
    let clips = &animation.clips;
    let last = |clip: &str| clip.rsplit(['|', ':']).next().unwrap_or_default().to_owned();
    let ways: [&dyn Fn(&str) -> bool; 3] =
        [&|clip| clip == name, &|clip| last(clip) == name, &|clip| last(clip).eq_ignore_ascii_case(name)];
    for is_meant in ways {
        let mut found = (0..clips.len()).filter(|i| is_meant(&clips[*i].name));
        match (found.next(), found.next()) {
            (Some(index), None) => return Ok((index, clips[index].duration_s)),
            // If several have exactly this name, use the first.
            (Some(index), Some(_)) if clips[index].name == name => return Ok((index, clips[index].duration_s)),
            (Some(_), Some(_)) => break,
            (None, _) => {}
        }
    }
    let names: Vec<_> = clips.iter().map(|c| c.name.as_str()).collect();
    Err(if names.is_empty() { "has no animation".into() } else { format!("has the clips {}", names.join(", ")) })
}

/// Returns the positions of a crowd's copies, metres. The first is at the origin; the others are in rows beside and
/// behind it.
fn crowd_positions(manifest: &Manifest, crowd: u32) -> Vec<Vec3> {
    let b = &manifest.bounds;
    let fur_m = 2.0 * manifest.fur.height_m;
    let [width, _, depth] = std::array::from_fn(|axis| 1.1 * (b.max[axis] - b.min[axis] + fur_m));
    let columns = f64::from(crowd).sqrt().ceil() as u32;
    let place = |i: u32| Vec3::new((i % columns) as f32 * width, 0.0, -((i / columns) as f32) * depth);
    (0..crowd).map(place).collect()
}

/// Returns a camera that shows all actors with their fur, along their whole paths. Frames the [`outline`] of each, at
/// rest or over its clip.
///
/// * `packages`: packages of the actors' models, with their files
/// * `aspect`: width of the picture divided by its height
///
/// Fails with [`StageError::Request`] if nothing matches the name to look at; lists the existing names.
/// [`StageError::Package`] for a damaged package.
pub fn frame_actors(
    packages: &[(&NamedPackage<'_>, Arc<Package<'_>>)],
    actors: &[Actor],
    aspect: f32,
    framing: &Framing,
) -> Result<Viewpoint, StageError> {
    let (mut points, mut margin_m) = (Vec::new(), 0.0_f32);
    let mut known: Vec<(usize, Option<usize>, Vec<Vec3>)> = Vec::new();
    // Caches the outermost points of a model with this orientation and scale, because copies of a crowd differ only in
    // position.
    let mut edge: Option<(usize, Mat3, Vec<Vec3>)> = None;
    for actor in actors {
        let Some((file, package)) = packages.get(actor.package) else { continue };
        let clip = actor.clip.map(|playing| playing.clip);
        let of = match known.iter().position(|(whose, playing, _)| (*whose, *playing) == (actor.package, clip)) {
            Some(of) => of,
            None => {
                let playing = actor.clip.map(|playing| (playing.clip, playing.duration_s));
                known.push((actor.package, clip, outline(file, package, playing, framing.look_at.as_deref())?));
                known.len() - 1
            }
        };
        let model = &known[of].2;
        if model.is_empty() {
            continue;
        }
        margin_m = margin_m.max(package.manifest().fur.height_m * actor.place.scale);
        for transform in transforms(&actor.place) {
            if actors.len() == 1 && edge.is_none() && transform == Mat4::IDENTITY {
                points.extend(model);
                continue;
            }
            let turn = Mat3::from_mat4(transform);
            if edge.as_ref().is_none_or(|(whose, how, _)| (*whose, *how) != (of, turn)) {
                let turned: Vec<Vec3> = model.iter().map(|point| turn * *point).collect();
                let kept = outermost(&turned, framing.edges(aspect).into_iter());
                edge = Some((of, turn, kept.into_iter().map(|i| turned[i]).collect()));
            }
            let place = transform.w_axis.truncate();
            points.extend(edge.iter().flat_map(|(.., points)| points).map(|point| *point + place));
        }
    }
    if let (true, Some(part)) = (points.is_empty(), &framing.look_at) {
        return Err(no_match_error(packages.iter().map(|(file, package)| (*file, &**package)), part));
    }
    Ok(framing.view(&points, margin_m, aspect))
}

/// Returns the transforms of a model along its path.
fn transforms(place: &Placement) -> Vec<Mat4> {
    let mut times: Vec<f32> = place.position.times().collect();
    times.extend(place.heading_deg.iter().flat_map(Track::times));
    times.sort_by(f32::total_cmp);
    times.dedup();
    let between = |pair: &[f32]| {
        let (from, to) = (pair[0], pair[1]);
        (1..MOMENTS_PER_KEY).map(move |k| from + (to - from) * k as f32 / MOMENTS_PER_KEY as f32)
    };
    let within: Vec<f32> = times.windows(2).flat_map(between).collect();
    times.into_iter().chain(within).map(|time_s| place.transform(time_s)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clips_are_found_by_the_end_of_their_names() {
        let clip = |name: &str| pelage_formats::Clip { name: name.into(), duration_s: 1.0, channels: Vec::new() };
        let names = ["A|Walk", "A|Run", "B|Run", "Walk_Slow", "Jump", "C|Jump"];
        let animation = Animation { clips: names.map(clip).to_vec(), ..Animation::default() };
        let found = |name: &str| clip_named(&animation, name).map(|(index, _)| index).map_err(|has| has.len());
        assert_eq!((found("Walk"), found("walk"), found("B|Run"), found("Jump")), (Ok(0), Ok(0), Ok(2), Ok(4)));
        for name in ["Run", "Slow", ""] {
            assert!(found(name).is_err(), "{name}");
        }
    }

    #[test]
    fn clips_restart_or_hold_their_last_pose() {
        let playing = Playback { clip: 2, duration_s: 2.0, start_s: 0.5, speed: 2.0, looped: true };
        let at = |playing: Playback, time_s| playing.moment(time_s);
        assert_eq!([0.0, 0.5, 1.0, -0.5].map(|t| at(playing, t)), [0.5, 1.5, 0.5, 1.5]);
        let once = Playback { looped: false, ..playing };
        assert_eq!([0.0, 0.5, 1.0, -0.5].map(|t| at(once, t)), [0.5, 1.5, 2.0, 0.0]);
        // A clip with a single pose has no duration.
        assert_eq!(at(Playback { duration_s: 0.0, ..once }, 5.0), 0.0);
    }

    #[test]
    fn models_face_their_heading_or_their_path() {
        let nose = |place: &Placement, t| place.transform(t).transform_vector3(Vec3::Z);
        let near = |a: Vec3, b: Vec3| assert!(a.distance(b) < 1e-5, "found {a}, expected {b}");
        assert_eq!(Placement::fixed(Vec3::ZERO).transform(3.0), Mat4::IDENTITY);
        let turned = Placement { heading_deg: Some(Track::fixed(90.0)), scale: 2.0, ..Placement::fixed(Vec3::Y) };
        near(nose(&turned, 0.0), 2.0 * Vec3::X);
        near(turned.transform(0.0).transform_point3(Vec3::Z), Vec3::new(2.0, 1.0, 0.0));
        for way in [Vec3::X, Vec3::NEG_Z, Vec3::new(0.6, 0.0, -0.8)] {
            let position = Track::new(vec![(0.0, Vec3::ONE), (2.0, Vec3::ONE + 3.0 * way)]);
            let walker =
                Placement { position: position.unwrap_or(Track::fixed(Vec3::ZERO)), heading_deg: None, scale: 1.0 };
            near(nose(&walker, 0.5), way);
            near(nose(&walker, 9.0), way);
        }
    }
}
