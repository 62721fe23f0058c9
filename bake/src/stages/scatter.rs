//! `scatter` stage: tables of light scattering in hair fibres (Marschner 2003; after Nguyen and Donnelly 2005), in the
//! form that a package stores.

use crate::recipe::{BcQuality, FibreParams};
use crate::stages::groom::report_unmatched;
use crate::stages::slice::{AlphaMode, RawLevel, TextureEncoder};
use half::f16;
use pelage_formats::meaning::scattering::means::FibreMeans;
use pelage_formats::meaning::scattering::tables::ScatteringTables;
use pelage_formats::{FibreInfo, FibreOptics, TextureFormat};
use pelage_import::BakeError;
use rayon::prelude::*;

/// Fibres of a package, with their tables.
#[derive(Clone, Debug, PartialEq)]
pub struct FibreTables {
    /// Distinct kinds of fibres, beginning with that of the fur.
    pub fibres: Vec<FibreOptics>,
    /// Mean values of each kind of fibre, which need no table.
    pub means: Vec<FibreMeans>,
    /// Index of the fibre kind for each hair group.
    pub of_groups: Vec<u8>,
    /// Index of the fibre kind of the fur on each material.
    pub of_materials: Vec<u8>,
    /// Tables of all kinds: a .ktx2 file.
    pub file: Vec<u8>,
    /// Warnings about names in the recipe that match nothing.
    pub warnings: Vec<String>,
}

impl FibreTables {
    /// Returns the description that a package stores. `texture`: index of the tables' texture.
    pub fn info(&self, texture: u32) -> FibreInfo {
        let Self { fibres, means, of_groups, of_materials, .. } = self.clone();
        FibreInfo { texture, fibres, means, of_groups, of_materials }
    }
}

/// Makes the fibre tables.
///
/// * `materials`: names of the materials in order
/// * `groups`: names of the hair groups in order
///
/// Fails with [`BakeError::Params`] if there are more kinds of fibres than a package can hold.
pub fn tables<'a>(
    params: &FibreParams,
    materials: impl Iterator<Item = &'a str> + Clone,
    groups: impl Iterator<Item = &'a str> + Clone,
) -> Result<FibreTables, BakeError> {
    let mut warnings = Vec::new();
    report_unmatched("fibre.material", &params.material, "material", materials.clone(), &mut warnings);
    report_unmatched("fibre.group", &params.group, "group of hair", groups.clone(), &mut warnings);
    let mut fibres = vec![params.fur_optics()];
    let mut number = |what, fibre: FibreOptics| {
        let number = fibres.iter().position(|known| *known == fibre).unwrap_or(fibres.len());
        if number >= FibreInfo::MOST {
            let reason = format!("more than {} kinds of fibres, expected fewer", FibreInfo::MOST);
            return Err(BakeError::Params { what, reason });
        }
        if number == fibres.len() {
            fibres.push(fibre);
        }
        Ok(number as u8)
    };
    let of_materials: Vec<u8> =
        materials.map(|name| number("fibre.material", params.material_optics(name))).collect::<Result<_, _>>()?;
    let of_groups: Vec<u8> =
        groups.map(|name| number("fibre.group", params.group_optics(name))).collect::<Result<_, _>>()?;
    let size = params.table_texels;
    let made: Vec<ScatteringTables> =
        fibres.par_iter().map(|of| ScatteringTables::new(&of.fibre(), size as usize)).collect();
    let mut encoder = TextureEncoder::new(TextureFormat::Rgba16Float, AlphaMode::Opaque, BcQuality::Basic);
    for layer in made.iter().flat_map(ScatteringTables::layers) {
        let halves = |x: &f32| f16::from_f32(*x).to_le_bytes();
        let texels: Vec<u8> = layer.as_flattened().iter().flat_map(halves).collect();
        encoder.push_layer(&[RawLevel { width: size, height: size, texels: &texels }])?;
    }
    let means = made.iter().map(|of| of.means).collect();
    Ok(FibreTables { fibres, means, of_groups, of_materials, file: encoder.finish()?, warnings })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recipe::OtherFibre;
    use pelage_formats::meaning::scattering::Angles;
    use pelage_formats::{Limits, TextureView};

    #[test]
    fn every_valid_fibre_recipe_gives_valid_tables() {
        for eta in [1.2, 2.0] {
            for (along_deg, tilt_deg) in [(1.0, -15.0), (45.0, 15.0)] {
                for around in [0.0, 0.5, 1.0] {
                    let params =
                        FibreParams { eta, along_deg, tilt_deg, around, table_texels: 16, ..FibreParams::default() };
                    let made = tables(&params, std::iter::empty(), std::iter::empty()).unwrap();
                    let faults = [made.fibres[0].fault(), made.means[0].fault()];
                    assert_eq!(faults, [None, None], "{params:?} {:?}", made.means);
                    let view = TextureView::parse(&made.file, 0, &Limits::default()).unwrap();
                    let finite = |layer: u32| view.floats(layer).unwrap().as_flattened().iter().all(|x| x.is_finite());
                    assert!(finite(0) && finite(1), "{params:?}");
                }
            }
        }
    }

    #[test]
    fn half_float_tables_keep_their_accuracy() {
        let other = |name: &str| vec![OtherFibre { name: name.into(), along_deg: Some(15.0), ..OtherFibre::default() }];
        let params = FibreParams { group: other("tail"), material: other("belly"), ..FibreParams::default() };
        let made = tables(&params, ["back", "belly"].into_iter(), ["mane", "tail", "tail tuft"].into_iter()).unwrap();
        assert_eq!((made.fibres.len(), &made.of_groups[..], &made.of_materials[..]), (2, &[0, 1, 0][..], &[0, 1][..]));
        assert_eq!(made.warnings, [] as [&str; 0]);
        let without = tables(&params, std::iter::once("hide"), std::iter::once("mane")).unwrap().warnings;
        assert_eq!(without[0], "fibre.material: \"belly\" matches no material; the model has [\"hide\"]");
        assert_eq!(without[1], "fibre.group: \"tail\" matches no group of hair; the model has [\"mane\"]");
        let view = TextureView::parse(&made.file, 0, &Limits::default()).unwrap();
        assert_eq!((view.format, view.width, view.layers), (TextureFormat::Rgba16Float, 64, 4));
        for (number, fibre) in made.fibres.iter().enumerate() {
            let layers = [0, 1].map(|layer| view.floats(2 * number as u32 + layer).unwrap());
            let exact = fibre.fibre();
            let read = ScatteringTables::of_layers(exact.eta, made.means[number], layers).unwrap();
            let (sin, cos) = (libm::sin(0.3), libm::cos(0.3));
            for phi in [0.2, 1.6, 3.0] {
                let angles = Angles { from: (sin, cos), to: (-0.2, 0.96_f64.sqrt()), phi };
                let sigma = [0.1, 0.5, 2.0];
                for (found, expected) in read.scatter(sigma, &angles).into_iter().zip(exact.scatter(sigma, &angles)) {
                    assert!((found / expected - 1.0).abs() < 0.02, "fibre {number}, φ {phi}: {found}, {expected}");
                }
            }
        }
    }
}
