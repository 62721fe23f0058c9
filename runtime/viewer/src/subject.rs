//! What a window shows: the model of a package, or a scene of several.

use pelage_formats::{Manifest, Package, Shading, Tag};
use pelage_stage::{Cast, Framing, LoadedScene, NamedPackage, StageError, Viewpoint};
use std::sync::Arc;

/// What is drawn.
#[derive(Clone, Debug)]
pub enum Subject {
    /// One model.
    Package(Arc<NamedPackage<'static>>),
    /// Several, who move and are seen as a file says.
    Scene(Arc<LoadedScene>),
}

/// A clip of a package.
#[derive(Clone, Debug, PartialEq)]
pub struct ClipInfo {
    /// As the package calls it.
    pub name: String,
    /// Seconds.
    pub duration_s: f32,
}

impl Subject {
    /// Who stands where; `camera` goes before the subject's own, or one that frames all of it.
    ///
    /// # Errors
    ///
    /// As [`Cast::crowd`] and [`LoadedScene::cast`].
    pub fn cast(&self, clip: Option<&str>, camera: Option<Viewpoint>, aspect: f32) -> Result<Cast<'_>, StageError> {
        let framing = Framing::default();
        match self {
            Self::Package(file) => Cast::crowd(file, file.open()?, clip, 1, camera, (&framing, aspect)),
            Self::Scene(scene) => scene.cast(camera, aspect, &framing),
        }
    }

    /// Its packages.
    pub fn packages(&self) -> &[NamedPackage<'static>] {
        match self {
            Self::Package(file) => std::slice::from_ref(file),
            Self::Scene(scene) => &scene.packages,
        }
    }

    /// The clips that can be played; of a scene none, because it says what plays.
    pub fn clips(&self) -> Vec<ClipInfo> {
        let Self::Package(file) = self else { return Vec::new() };
        let animation = file.open().ok().and_then(|package| package.animation().ok().flatten());
        let clips = animation.map(|animation| animation.clips.clone()).unwrap_or_default();
        clips.into_iter().map(|clip| ClipInfo { name: clip.name, duration_s: clip.duration_s }).collect()
    }

    /// The file that it was named by.
    pub fn name(&self) -> &str {
        self.packages().first().map_or("", |file| &file.name)
    }

    /// The constants of the lighting equation of `other`, where it is this package again and nothing else that is drawn changed.
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
        let is_same =
            self.name() == other.name() && unshaded(&before) == unshaded(&after) && drawn(&before)?.eq(&drawn(&after)?);
        is_same.then_some(after.manifest().shading)
    }

    /// Bytes of all its packages.
    pub fn bytes(&self) -> u64 {
        self.packages().iter().map(|file| file.bytes.len() as u64).sum()
    }
}

/// All sections of a package but its manifest; `None` for a damaged one.
fn drawn<'a>(package: &Package<'a>) -> Option<Vec<(Tag, &'a [u8])>> {
    let others = (0..).zip(package.sections()).filter(|(_, section)| section.tag != Tag::MANIFEST);
    others.map(|(i, section)| Some((section.tag, package.section_bytes(i).ok()?))).collect()
}
