//! Subject of a window: the model of a package, or a scene with several models.

use pelage_formats::{Manifest, Package, Shading, Tag};
use pelage_stage::{Cast, Framing, LoadedScene, NamedPackage, StageError, Viewpoint};
use std::sync::Arc;

/// Subject to draw.
#[derive(Clone, Debug)]
pub enum Subject {
    /// Single model.
    Package(Arc<NamedPackage<'static>>),
    /// Several models, with motion and cameras from a scene file.
    Scene(Arc<LoadedScene>),
}

/// Clip of a package.
#[derive(Clone, Debug, PartialEq)]
pub struct ClipInfo {
    /// Name in the package.
    pub name: String,
    /// Duration, seconds.
    pub duration_s: f32,
}

impl Subject {
    /// Returns the positions and poses of all instances. The camera is `camera`, or else the subject's own, or one that
    /// frames everything.
    ///
    /// # Errors
    ///
    /// Same as [`Cast::crowd`] and [`LoadedScene::cast`].
    pub fn cast(&self, clip: Option<&str>, camera: Option<Viewpoint>, aspect: f32) -> Result<Cast<'_>, StageError> {
        let framing = Framing::default();
        match self {
            Self::Package(file) => Cast::crowd(file, file.open()?, clip, 1, camera, (&framing, aspect)),
            Self::Scene(scene) => scene.cast(camera, aspect, &framing),
        }
    }

    /// Returns the packages of the subject.
    pub fn packages(&self) -> &[NamedPackage<'static>] {
        match self {
            Self::Package(file) => std::slice::from_ref(file),
            Self::Scene(scene) => &scene.packages,
        }
    }

    /// Returns the clips that can be played. Empty for a scene, which defines its own playback.
    pub fn clips(&self) -> Vec<ClipInfo> {
        let Self::Package(file) = self else { return Vec::new() };
        let animation = file.open().ok().and_then(|package| package.animation().ok().flatten());
        let clips = animation.map(|animation| animation.clips.clone()).unwrap_or_default();
        clips.into_iter().map(|clip| ClipInfo { name: clip.name, duration_s: clip.duration_s }).collect()
    }

    /// Returns the file name of the first package.
    pub fn name(&self) -> &str {
        self.packages().first().map_or("", |file| &file.name)
    }

    /// Returns the shading constants of `other`, another bake of the same package, if no other drawn data differs.
    pub fn other_shading(&self, other: &Self) -> Option<Shading> {
        let (Self::Package(before), Self::Package(after)) = (self, other) else { return None };
        let (before, after) = (before.open().ok()?, after.open().ok()?);
        let unshaded = |package: &Package<'_>| Manifest {
            shading: Shading::default(),
            recipe: String::new(),
            inputs: Vec::new(),
            warnings: Vec::new(),
            ..package.manifest().clone()
        };
        let is_same = self.name() == other.name()
            && unshaded(&before) == unshaded(&after)
            && drawn_sections(&before)?.eq(&drawn_sections(&after)?);
        is_same.then_some(after.manifest().shading)
    }

    /// Returns the total size of the subject's packages, bytes.
    pub fn bytes(&self) -> u64 {
        self.packages().iter().map(|file| file.bytes.len() as u64).sum()
    }
}

/// Returns all sections of a package except its manifest; `None` for a damaged one.
fn drawn_sections<'a>(package: &Package<'a>) -> Option<Vec<(Tag, &'a [u8])>> {
    let others = (0..).zip(package.sections()).filter(|(_, section)| section.tag != Tag::MANIFEST);
    others.map(|(i, section)| Some((section.tag, package.section_bytes(i).ok()?))).collect()
}
