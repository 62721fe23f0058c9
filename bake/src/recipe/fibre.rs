//! Fibres of the hair: `[fibre]`, `[[fibre.material]]` and `[[fibre.group]]`.

use super::named_table::named_table;
use super::params::HairColors;
use pelage_formats::FibreOptics;
use pelage_formats::meaning::linear_to_srgb;
use pelage_formats::meaning::scattering::colour;
use pelage_formats::meaning::scattering::optics::Medulla;
use pelage_params::{PowerOfTwo, Range, SrgbColor, params, words};

/// Range of indices of refraction.
const ETA: Range<f32> = 1.2..=2.0;
/// Range of longitudinal roughnesses, degrees.
const ALONG: Range<f32> = 1.0..=45.0;
/// Range of scale tilts, degrees.
const TILT: Range<f32> = -15.0..=15.0;
/// Range of the azimuthal roughness.
const SHARE: Range<f32> = 0.0..=1.0;

words! {
    /// Species, whose medulla a fibre has.
    FibreKind {
        /// Human hair, whose medulla is thin, broken or absent: none.
        #[default]
        Human = "human",
        /// Sloth bear: 0.18.
        Bear = "bear",
        /// Horse: 0.3.
        Horse = "horse",
        /// Wolf: 0.42.
        Wolf = "wolf",
        /// Red fox: 0.7.
        Fox = "fox",
        /// Golden jackal: 0.72.
        Jackal = "jackal",
        /// Goat: 0.75.
        Goat = "goat",
        /// Sheep: 0.75.
        Sheep = "sheep",
        /// Hare: 0.8.
        Hare = "hare",
        /// Deer, whose medulla fills nearly the whole hair: 0.95.
        Deer = "deer",
    }
}

impl FibreKind {
    /// Returns the ratio of the radii of medulla and fibre. Sources are listed in `bake/docs/fibres.md`.
    pub fn medulla(self) -> f32 {
        match self {
            Self::Human => 0.0,
            Self::Bear => 0.18,
            Self::Horse => 0.3,
            Self::Wolf => 0.42,
            Self::Fox => 0.7,
            Self::Jackal => 0.72,
            Self::Goat | Self::Sheep => 0.75,
            Self::Hare => 0.8,
            Self::Deer => 0.95,
        }
    }
}

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
        /// Species of the animal: sets `fibre.medulla`, if that is left out.
        kind: Option<FibreKind> = None;
        /// Radius of the medulla, the fibre's core that scatters light, divided by that of the fibre. A medulla makes
        /// hair duller, and weakens its rim against the light. If left out, that of `fibre.kind`, or 0.
        medulla: Option<f32> = None, in Medulla::RATIO;
        /// How strongly the medulla scatters light: coefficient per radius of the fibre, if light is scattered evenly
        /// in all directions. If left out, 1.
        medulla_scatter: Option<f32> = None, in Medulla::SCATTERING;
        /// Concentration of eumelanin, which makes hair brown and black: 0 white, 0.3 blond, 1.3 brown, 8 black. If
        /// this or `fibre.pheomelanin` is given, the pigments replace the defaults of `color.root` and `color.tip`. Set
        /// `color.base_color = false` to ignore the model's colours as well.
        eumelanin: Option<f32> = None, in 0.0..=100.0;
        /// Concentration of pheomelanin, which makes hair yellow and red: 1 for a fox.
        pheomelanin: Option<f32> = None, in 0.0..=100.0;
        /// Width and height of the scattering lookup tables, texels.
        table_texels: u32 = 64, in 16..=256, as PowerOfTwo;
        /// Fibres of the fur on single materials: `[[fibre.material]]` with the material's `name`, and any of `eta`,
        /// `along_deg`, `tilt_deg`, `around`, `kind`, `medulla`, `medulla_scatter`. In the name, `*` matches any
        /// characters and `?` one. Later tables take precedence.
        material: Vec<OtherFibre> = Vec::new();
        /// Fibres of guided hair, if they differ from those of the fur: `[[fibre.group]]` with the `name` of a
        /// group or tuft of `[strands]`, and any of `eta`, `along_deg`, `tilt_deg`, `around`, `kind`, `medulla`,
        /// `medulla_scatter`. In the name, `*` matches any characters and `?` one. Later tables take precedence.
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
        /// Overrides `fibre.kind`, and with it `fibre.medulla`.
        kind: FibreKind, in ();
        /// Overrides `fibre.medulla`.
        medulla: f32, in Medulla::RATIO;
        /// Overrides `fibre.medulla_scatter`.
        medulla_scatter: f32, in Medulla::SCATTERING;
    }
}

impl FibreParams {
    /// Returns the fibre of the fur.
    pub fn fur_optics(&self) -> FibreOptics {
        optics(self.numbers())
    }

    /// Returns the numbers of the fur's fibre, in the order of [`OtherFibre::numbers`].
    fn numbers(&self) -> [f32; 6] {
        let medulla = self.medulla.or(self.kind.map(FibreKind::medulla)).unwrap_or(0.0);
        [self.eta, self.along_deg, self.tilt_deg, self.around, medulla, self.medulla_scatter.unwrap_or(1.0)]
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
        let mut found = self.numbers();
        for table in tables.iter().filter(|table| pelage_params::glob(&table.name, name)) {
            for (value, said) in found.iter_mut().zip(table.numbers()) {
                *value = said.unwrap_or(*value);
            }
        }
        optics(found)
    }

    /// Returns the hair colours of the pigments; `None` if the recipe gives neither pigment.
    pub fn pigmented(&self) -> Option<HairColors> {
        if self.eumelanin.is_none() && self.pheomelanin.is_none() {
            return None;
        }
        let amount = |pigment: Option<f32>| f64::from(pigment.unwrap_or(0.0));
        let sigma = colour::of_pigments(amount(self.eumelanin), amount(self.pheomelanin));
        let FibreOptics { around, medulla, .. } = self.fur_optics();
        let darker = colour::medulla_absorption(&medulla, around.into());
        let color = colour::color(sigma.map(|sigma| sigma / darker), around.into());
        let color = SrgbColor(color.map(|c| f32::from(linear_to_srgb(c as f32)) / 255.0));
        Some(HairColors { gain: 1.0, root: color, tip: color })
    }
}

impl OtherFibre {
    fn numbers(&self) -> [Option<f32>; 6] {
        let medulla = self.medulla.or(self.kind.map(FibreKind::medulla));
        [self.eta, self.along_deg, self.tilt_deg, self.around, medulla, self.medulla_scatter]
    }
}

fn optics([eta, along_deg, tilt_deg, around, ratio, scattering]: [f32; 6]) -> FibreOptics {
    let medulla = if ratio > 0.0 { Medulla { ratio, scattering } } else { Medulla::NONE };
    let around = colour::scale_of(f64::from(around)).max(0.01) as f32;
    FibreOptics { eta, along: along_deg.to_radians(), tilt: tilt_deg.to_radians(), around, medulla }
}

#[cfg(test)]
mod tests {
    use super::*;
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
    fn kinds_set_the_medulla_that_is_left_out() {
        let text = "[fibre]\nkind = \"fox\"\nmedulla_scatter = 2\n\
                    [[fibre.group]]\nname = \"mane\"\nkind = \"human\"\n\
                    [[fibre.group]]\nname = \"tail\"\nmedulla = 0.5\n";
        let recipe = Recipe::parse("fox.toml", text).unwrap();
        let of = |optics: FibreOptics| (optics.medulla.ratio, optics.medulla.scattering);
        let found = ["body", "mane", "tail"].map(|name| of(recipe.fibre.group_optics(name)));
        assert_eq!(found, [(0.7, 2.0), (0.0, 0.0), (0.5, 2.0)]);
        assert_eq!(Recipe::parse("again.toml", &recipe.to_toml()).unwrap(), recipe);
        assert!(FibreKind::ALL.iter().all(|kind| Medulla::RATIO.contains(&kind.medulla())));
        for (assignment, expected) in [
            ("fibre.kind=dragon", "one of \"human\", \"bear\", \"horse\", \"wolf\", \"fox\""),
            ("fibre.medulla=1", "0..=0.95"),
            ("fibre.medulla_scatter=-1", "0..=10"),
        ] {
            let message = Recipe::default().set(assignment).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
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
