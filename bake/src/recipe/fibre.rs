//! Fibres of the hair: `[fibre]`, `[[fibre.material]]` and `[[fibre.group]]`.

use super::named_table::named_table;
use super::params::HairColors;
use pelage_formats::FibreOptics;
use pelage_formats::meaning::linear_to_srgb;
use pelage_formats::meaning::scattering::colour;
use pelage_formats::meaning::scattering::optics::Medulla;
use pelage_params::{PowerOfTwo, Range, SrgbColor, params};

/// Range of indices of refraction.
const ETA: Range<f32> = 1.2..=2.0;
/// Range of longitudinal roughnesses, degrees.
const ALONG: Range<f32> = 1.0..=45.0;
/// Range of scale tilts, degrees.
const TILT: Range<f32> = -15.0..=15.0;
/// Range of the azimuthal roughness.
const SHARE: Range<f32> = 0.0..=1.0;

params! {
    /// `[fibre]`: fibres of the hair and how they scatter light, for `shading.model = "marschner"`.
    FibreParams in fibre {
        /// Index of refraction: 1.55 for hair; lower is less glossy.
        eta: f32 = 1.55, in ETA;
        /// Longitudinal roughness: how far light reflected at the fibre's surface spreads along the fibre, degrees of
        /// the half angle. 5 is glossy, 10 soft, 20 dull. Transmitted light spreads half as far, and internally
        /// reflected light twice as far.
        along_deg: f32 = 7.5, in ALONG;
        /// Tilt of the surface reflection towards the root, caused by the fibre's scales, degrees of the half angle.
        /// The second highlight, which has the hair's colour, moves the other way. So higher values separate the two
        /// highlights more.
        tilt_deg: f32 = 3.0, in TILT;
        /// Azimuthal roughness of the fibre: 0 is clear as glass, with glints; 1 is matt.
        around: f32 = 0.3, in SHARE;
        /// Concentration of eumelanin, which makes hair brown and black: 0 white, 0.3 blond, 1.3 brown, 8 black. If
        /// this or `fibre.pheomelanin` is given, the pigments replace the defaults of `color.root` and `color.tip`. Set
        /// `color.base_color = false` to ignore the model's colours as well.
        eumelanin: Option<f32> = None, in 0.0..=100.0;
        /// Concentration of pheomelanin, which makes hair yellow and red: 1 for a fox.
        pheomelanin: Option<f32> = None, in 0.0..=100.0;
        /// Width and height of the scattering lookup tables, texels.
        table_texels: u32 = 64, in 16..=256, as PowerOfTwo;
        /// Fibres of the fur on single materials: `[[fibre.material]]` with the material's `name`, and any of `eta`,
        /// `along_deg`, `tilt_deg`, `around`. In the name, `*` matches any characters and `?` one. Later tables take
        /// precedence.
        material: Vec<OtherFibre> = Vec::new();
        /// Fibres of guided hair, if they differ from those of the fur: `[[fibre.group]]` with the `name` of a
        /// group or tuft of `[strands]`, and any of `eta`, `along_deg`, `tilt_deg`, `around`. In the name, `*` matches
        /// any characters and `?` one. Later tables take precedence.
        group: Vec<OtherFibre> = Vec::new();
    }
}

named_table! {
    /// Fibres of the groups of hair, or of the fur on the materials, that `name` matches. Keys left out have the values
    /// of `[fibre]`.
    OtherFibre of "a material or a group of hair" {
        /// Overrides `fibre.eta`.
        eta: f32, in ETA;
        /// Overrides `fibre.along_deg`.
        along_deg: f32, in ALONG;
        /// Overrides `fibre.tilt_deg`.
        tilt_deg: f32, in TILT;
        /// Overrides `fibre.around`.
        around: f32, in SHARE;
    }
}

impl FibreParams {
    /// Returns the fibre of the fur.
    pub fn fur_optics(&self) -> FibreOptics {
        optics(self.eta, self.along_deg, self.tilt_deg, self.around)
    }

    /// Returns the fibre of a group of hair.
    pub fn group_optics(&self, name: &str) -> FibreOptics {
        self.other(&self.group, name)
    }

    /// Returns the fibre of the fur on a material.
    pub fn material_optics(&self, name: &str) -> FibreOptics {
        self.other(&self.material, name)
    }

    fn other(&self, tables: &[OtherFibre], name: &str) -> FibreOptics {
        let mut found = [self.eta, self.along_deg, self.tilt_deg, self.around];
        for table in tables.iter().filter(|table| pelage_params::glob(&table.name, name)) {
            for (value, said) in found.iter_mut().zip([table.eta, table.along_deg, table.tilt_deg, table.around]) {
                *value = said.unwrap_or(*value);
            }
        }
        let [eta, along_deg, tilt_deg, around] = found;
        optics(eta, along_deg, tilt_deg, around)
    }

    /// Returns the hair colours of the pigments; `None` if the recipe gives neither pigment.
    pub fn pigmented(&self) -> Option<HairColors> {
        if self.eumelanin.is_none() && self.pheomelanin.is_none() {
            return None;
        }
        let amount = |pigment: Option<f32>| f64::from(pigment.unwrap_or(0.0));
        let sigma = colour::of_pigments(amount(self.eumelanin), amount(self.pheomelanin));
        let color = colour::color(sigma, f64::from(self.fur_optics().around));
        let color = SrgbColor(color.map(|c| f32::from(linear_to_srgb(c as f32)) / 255.0));
        Some(HairColors { gain: 1.0, root: color, tip: color })
    }
}

fn optics(eta: f32, along_deg: f32, tilt_deg: f32, around: f32) -> FibreOptics {
    let around = colour::scale_of(f64::from(around)).max(0.01) as f32;
    FibreOptics { eta, along: along_deg.to_radians(), tilt: tilt_deg.to_radians(), around, medulla: Medulla::NONE }
}

#[cfg(test)]
mod tests {
    use crate::recipe::Recipe;

    #[test]
    fn groups_and_materials_can_override_the_fibre() {
        let text = "[fibre]\ntilt_deg = 4.0\n\
                    [[fibre.group]]\nname = \"ta*\"\nalong_deg = 12.0\n\
                    [[fibre.material]]\nname = \"M*\"\neta = 1.4\n";
        let recipe = Recipe::parse("pony.toml", text).unwrap();
        let (coat, tail) = (recipe.fibre.fur_optics(), recipe.fibre.group_optics("tail"));
        assert_eq!(recipe.fibre.group_optics("mane"), coat);
        assert_eq!((tail.tilt, tail.eta), (coat.tilt, coat.eta));
        let [mane, hoof] = ["Mane", "tail"].map(|name| recipe.fibre.material_optics(name));
        assert_eq!((mane.eta, mane.along, hoof), (1.4, coat.along, coat));
        assert!((tail.along - 12f32.to_radians()).abs() < 1e-6);
        assert_eq!(Recipe::parse("again.toml", &recipe.to_toml()).unwrap(), recipe);
    }

    #[test]
    fn pigments_make_colours() {
        let colors = |set: &[&str]| {
            let mut recipe = Recipe::default();
            set.iter().for_each(|assignment| recipe.set(assignment).unwrap());
            recipe.fibre.pigmented().map(|colors| colors.root.0)
        };
        assert_eq!(colors(&[]), None);
        assert_eq!(colors(&["fibre.eumelanin=0"]), Some([1.0; 3]));
        let blond = colors(&["fibre.eumelanin=0.3"]).unwrap();
        let brown = colors(&["fibre.eumelanin=1.3"]).unwrap();
        let red = colors(&["fibre.pheomelanin=1"]).unwrap();
        assert!(blond.iter().zip(brown).all(|(blond, brown)| *blond > brown), "{blond:?} {brown:?}");
        assert!(red[0] > 1.5 * red[1] && red[1] > red[2], "{red:?}");
    }
}
