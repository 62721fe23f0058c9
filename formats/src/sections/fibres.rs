//! The `FIBR` section: light scattering of the hair's fibres. Layout in `FORMAT.md`, "FIBR".

use super::kind::{Count, Kind, Row, faults};
use super::textures::{TextureFormat, TextureView};
use crate::encoding::{decode_section, encode_section};
use crate::error::FormatError;
use crate::meaning::scattering::means::FibreMeans;
use crate::meaning::scattering::optics::Medulla;
use crate::meaning::scattering::{AzimuthalScattering, Fibre, LobeShape};
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

impl Tag {
    /// Light scattering of fibres, since version 3. At most one.
    pub const FIBRES: Self = Self(*b"FIBR");
}

pub(crate) const KIND: Kind = Kind {
    tag: Tag::FIBRES,
    since: 3,
    count: Count::AtMostOne,
    check: |package, _| package.fibres().map(drop),
    check_use: |package| faults([package.fibre_tables().err()]),
    row: Row { what: "[how fibres scatter light](#fibr-fibres)", how_many: "at most one", place: "any" },
};

/// Number of array layers of each fibre in the texture: the table along the fibre, and the table around it.
pub const FIBRE_LAYERS: u32 = 2;

/// Light scattering of a package's fibres.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FibreInfo {
    /// Index into the manifest's `textures`: half floats, square, [`FIBRE_LAYERS`] array layers for each fibre, laid
    /// out as in [`crate::meaning::scattering::tables`].
    pub texture: u32,
    /// Fibres; the fibre of the fur first. At most [`FibreInfo::MOST`].
    pub fibres: Vec<FibreOptics>,
    /// Properties of each fibre that need no table.
    pub means: Vec<FibreMeans>,
    /// For each group of the section `HAIR`, the index of its fibre.
    pub of_groups: Vec<u8>,
    /// For each of the manifest's materials, the index of the fibre of its fur.
    pub of_materials: Vec<u8>,
}

/// Optical properties of a fibre.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FibreOptics {
    /// Index of refraction, 1.01..=3.
    pub eta: f32,
    /// Standard deviation of the reflected lobe along the fibre, radians of the half angle, 0.01..=1.
    pub along: f32,
    /// Tilt of that lobe due to the cuticle scales, towards the root, radians of the half angle, −0.5..=0.5.
    pub tilt: f32,
    /// Scale of the azimuthal logistic distribution, radians, 0.01..=5; practically uniform from 4 upwards.
    pub around: f32,
    /// Medulla, from the section `MEDU`.
    #[serde(skip)]
    pub medulla: Medulla,
}

impl FibreOptics {
    /// Returns the energy-conserving fibre with these properties.
    pub fn fibre(&self) -> Fibre {
        Fibre {
            eta: self.eta.into(),
            along: self.along.into(),
            tilt: self.tilt.into(),
            around: AzimuthalScattering::Rough(self.around.into()),
            keeps: LobeShape::Energy,
            medulla: self.medulla,
        }
    }

    /// Returns an error message if a number is out of its range.
    pub fn fault(&self) -> Option<String> {
        let ranges = [
            ("eta", self.eta, 1.01, 3.0),
            ("along", self.along, 0.01, 1.0),
            ("tilt", self.tilt, -0.5, 0.5),
            ("around", self.around, 0.01, 5.0),
        ];
        let outside = ranges.into_iter().find(|(_, found, least, most)| !(*least..=*most).contains(found));
        outside.map(|(name, found, least, most)| format!("{name} is {found}, expected {least} to {most}"))
    }
}

impl FibreInfo {
    /// Maximum number of fibres in a package.
    pub const MOST: usize = 64;

    fn fault(&self, groups: usize, materials: usize) -> Option<String> {
        let count = self.fibres.len();
        if !(1..=Self::MOST).contains(&count) {
            return Some(format!("{count} fibres, expected 1 to {}", Self::MOST));
        }
        if self.means.len() != count {
            return Some(format!("means has {} entries, expected one for each of {count} fibres", self.means.len()));
        }
        let lists = [
            ("of_groups", &self.of_groups, groups, "groups of hair"),
            ("of_materials", &self.of_materials, materials, "materials"),
        ];
        for (name, list, expected, of) in lists {
            if list.len() != expected {
                let found = list.len();
                return Some(format!("{name} has {found} entries, expected one for each of {expected} {of}"));
            }
            if let Some((i, found)) = list.iter().enumerate().find(|(_, of)| usize::from(**of) >= count) {
                return Some(format!("{name}[{i}] is {found}, expected less than the {count} fibres"));
            }
        }
        let of_optics = self.fibres.iter().enumerate().map(|(i, fibre)| ("fibres", i, fibre.fault()));
        let of_means = self.means.iter().enumerate().map(|(i, means)| ("means", i, means.fault()));
        of_optics.chain(of_means).find_map(|(list, i, fault)| Some(format!("{list}[{i}]: {}", fault?)))
    }
}

impl<'a> Package<'a> {
    /// Returns the light scattering of the fibres; `None` if the package has no such section.
    ///
    /// Fails if the section or that of the medullae is damaged, or is inconsistent with hair groups or materials.
    pub fn fibres(&self) -> Result<Option<Arc<FibreInfo>>, FormatError> {
        let Some((index, section)) = self.find(Tag::FIBRES, 0) else { return Ok(None) };
        let info = self.cached(index, || {
            let mut info: FibreInfo = decode_section(Tag::FIBRES, section.offset, self.section_bytes(index)?)?;
            let fail = |reason| FormatError::Content { tag: Tag::FIBRES, offset: section.offset, reason };
            let fault = info.fault(self.hair_groups()?.len(), self.manifest().materials.len());
            if let Some(reason) = fault {
                return Err(fail(reason));
            }
            let medullae = self.medullae(info.fibres.len())?;
            info.fibres.iter_mut().zip(medullae).for_each(|(fibre, medulla)| fibre.medulla = medulla);
            Ok(Arc::new(info))
        })?;
        Ok(Some(info))
    }

    /// Returns the scattering tables of the fibres; `None` if the package has none.
    ///
    /// Fails if the texture is damaged, or is inconsistent with [`FibreInfo`].
    pub fn fibre_tables(&self) -> Result<Option<TextureView<'a>>, FormatError> {
        let Some(info) = self.fibres()? else { return Ok(None) };
        let view = self.texture(info.texture)?;
        let layers = FIBRE_LAYERS * info.fibres.len() as u32;
        let size = view.width;
        if view.format != TextureFormat::Rgba16Float || size < 2 || (size, layers) != (view.height, view.layers) {
            let reason = format!(
                "is {}x{} texels of {} in {} layers, expected a square of {} in {layers} layers for tables of fibres",
                size,
                view.height,
                view.format.name(),
                view.layers,
                TextureFormat::Rgba16Float.name()
            );
            return Err(self.texture_fault(info.texture, &reason));
        }
        let numbers = (0..view.levels).flat_map(|level| view.level(level).chunks_exact(2));
        // If all bits of the exponent are set, the number is infinity or NaN.
        if numbers.into_iter().any(|half| half[1] & 0x7c == 0x7c) {
            return Err(self.texture_fault(
                info.texture,
                "has a number that is not finite, expected finite numbers in \
                 tables of fibres",
            ));
        }
        Ok(Some(view))
    }
}

impl PackageWriter<'_> {
    /// Adds the light scattering of fibres, and their medullae if any scatters light.
    pub fn fibres(self, info: &FibreInfo) -> Self {
        let with_fibres = self.encoded(Tag::FIBRES, encode_section(Tag::FIBRES, info));
        let medullae: Vec<Medulla> = info.fibres.iter().map(|fibre| fibre.medulla).collect();
        if medullae.iter().any(Medulla::scatters) { with_fibres.medullae(&medullae) } else { with_fibres }
    }
}
