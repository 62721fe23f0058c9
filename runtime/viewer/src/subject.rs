//! What a window shows: the model of a package, or a scene of several.

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

    /// Bytes of all its packages.
    pub fn bytes(&self) -> u64 {
        self.packages().iter().map(|file| file.bytes.len() as u64).sum()
    }
}
