//! Packages as Bevy assets.

use bevy_asset::io::Reader;
use bevy_asset::{Asset, AssetLoader, LoadContext};
use bevy_camera::primitives::Aabb;
use bevy_math::Vec3;
use bevy_reflect::TypePath;
use pelage_formats::{Animation, FormatError, Limits, Package};
use pelage_stage::{NamedPackage, StageError, clip_named};
use std::sync::Arc;

/// An animal written by `pelage bake`; the asset type of `.pelage` files. Loading checks the whole file, so that every
/// loaded model can be drawn.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct PelageModel {
    /// Package, with its path for messages. When the file changes on disk, a new `Arc` signals this to the render
    /// world.
    pub(crate) package: Arc<NamedPackage<'static>>,
    animation: Option<Arc<Animation>>,
    bounds: Aabb,
    fur_height_m: f32,
}

impl PelageModel {
    /// Creates a model from the bytes of a package, which may come from any source. `name` is used in messages.
    ///
    /// Fails with [`PelageLoadError::Package`] with the name, the position in the package, the value found and the
    /// value expected.
    pub fn from_bytes(name: impl Into<String>, bytes: Vec<u8>) -> Result<Self, PelageLoadError> {
        let package = NamedPackage::new(name, bytes);
        let fault = |source: FormatError| PelageLoadError::Package(package.fault(source));
        if let Some(first) = Package::validate(&package.bytes, &Limits::default()).into_iter().next() {
            return Err(fault(first));
        }
        let opened = Package::open(&package.bytes, &Limits::default()).map_err(fault)?;
        let animation = opened.animation().map_err(fault)?;
        let (bounds, fur) = (opened.manifest().bounds, opened.manifest().fur.height_m);
        let bounds = Aabb::from_min_max(Vec3::from(bounds.min) - fur, Vec3::from(bounds.max) + fur);
        drop(opened);
        Ok(Self { package: Arc::new(package), animation, bounds, fur_height_m: fur })
    }

    /// Returns the name for messages: the path of the file.
    pub fn name(&self) -> &str {
        &self.package.name
    }

    /// Returns names and lengths in seconds of the clips, in the order of the package.
    pub fn clips(&self) -> impl ExactSizeIterator<Item = (&str, f32)> {
        let clips = self.animation.as_ref().map_or(&[][..], |animation| &animation.clips);
        clips.iter().map(|clip| (clip.name.as_str(), clip.duration_s))
    }

    /// Returns the bounding box of body and fur at rest, in model space, metres. An animated model may extend beyond
    /// it.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Returns the maximum height of the fur, metres.
    pub fn fur_height_m(&self) -> f32 {
        self.fur_height_m
    }

    /// Returns the index and length in seconds of a clip. `name` is its full name, or the part after the skeleton's
    /// name (`Walk` finds `AnimalArmature|Walk`).
    ///
    /// Fails with a sentence that lists the existing clips.
    pub fn clip(&self, name: &str) -> Result<(usize, f32), String> {
        let none = Animation::default();
        clip_named(self.animation.as_deref().unwrap_or(&none), name)
    }
}

/// Asset loader for `.pelage` files.
#[derive(Debug, Default, TypePath)]
pub struct PelageModelLoader;

/// Error while loading a [`PelageModel`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PelageLoadError {
    /// The file could not be read.
    #[error("{file}: {source}")]
    Read {
        /// Path of the file.
        file: String,
        /// Error of the asset source.
        source: std::io::Error,
    },
    /// The package is damaged, too new, or not a package.
    #[error(transparent)]
    Package(StageError),
}

impl AssetLoader for PelageModelLoader {
    type Asset = PelageModel;
    type Settings = ();
    type Error = PelageLoadError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        load_context: &mut LoadContext<'_>,
    ) -> Result<PelageModel, PelageLoadError> {
        let file = load_context.path().to_string();
        let mut bytes = Vec::new();
        match reader.read_to_end(&mut bytes).await {
            Ok(_) => PelageModel::from_bytes(file, bytes),
            Err(source) => Err(PelageLoadError::Read { file, source }),
        }
    }

    fn extensions(&self) -> &[&str] {
        &["pelage"]
    }
}
