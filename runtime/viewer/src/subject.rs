//! Subject of a window: the model of a package, or a scene with several models.

use pelage_formats::meaning::fur_motion::SHORTEST_M;
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

/// Features of a subject's packages, on which the effect of knobs depends. Each is true if any package has the feature.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Features {
    fur: bool,
    guided_hair: bool,
    strands: bool,
    fins: bool,
    fibres: bool,
    moving_hair: bool,
}

impl Features {
    /// Returns whether a condition of the look's knobs ([`pelage_stage::CONDITIONS`]) holds.
    ///
    /// * `drawn`: whether the last picture shows layers, and whether it shows single strands
    pub fn holds(&self, condition: &str, drawn: [bool; 2]) -> bool {
        match condition {
            "fur" => self.fur,
            "strands" => self.strands,
            "fins" => self.fins,
            "fibres" => self.fibres,
            "moving hair" => self.moving_hair,
            "drawn layers" => drawn[0],
            "drawn strands" => drawn[1] || self.guided_hair,
            _ => true,
        }
    }
}

impl Subject {
    /// Returns the features of the packages. A damaged section counts as missing.
    pub fn features(&self) -> Features {
        let mut features = Features::default();
        for package in self.packages().iter().filter_map(|file| file.open().ok()) {
            let (fur, hangs) = (&package.manifest().fur, package.hair_groups().is_ok_and(|groups| !groups.is_empty()));
            features.fur |= fur.layers > 1 || hangs;
            features.guided_hair |= hangs;
            features.strands |= package.strands().is_ok_and(|strands| strands.is_some());
            features.fins |= package.fins().is_ok_and(|fins| fins.is_some());
            features.fibres |= package.fibres().is_ok_and(|fibres| fibres.is_some());
            let moves = package.hair_motion().is_ok_and(|motion| motion.is_some());
            features.moving_hair |= moves || fur.height_m > SHORTEST_M;
        }
        features
    }

    /// Returns the positions and poses of all instances. The camera is `camera`, or else the subject's own, or one that
    /// frames everything.
    ///
    /// Fails like [`Cast::crowd`] and [`LoadedScene::cast`].
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

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_stage::CONDITIONS;

    #[test]
    fn every_condition_of_the_looks_knobs_is_known() {
        for (condition, _) in CONDITIONS {
            assert!(!Features::default().holds(condition, [false; 2]), "{condition}");
        }
    }

    #[test]
    fn conditions_follow_the_package_and_the_last_picture() {
        let features = Features { fur: true, strands: true, ..Features::default() };
        let found = [[true, false], [false, true]].map(|drawn| {
            let names = CONDITIONS.map(|(name, _)| name).into_iter();
            names.filter(|name| features.holds(name, drawn)).collect::<Vec<_>>()
        });
        assert_eq!(found, [["fur", "strands", "drawn layers"], ["fur", "strands", "drawn strands"]]);
    }
}
