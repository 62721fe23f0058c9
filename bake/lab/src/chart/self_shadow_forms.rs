//! What the topic `self-shadow` measures: the ways to know what light the hair lets through, and their settings.

use super::Cell;
use pelage_bake::recipe::{BcQuality, Recipe, ShellFormat};
use pelage_runtime::{ShadowParams, SlantForm};

/// A way to know what light the hair lets through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// Found by rays in the bake, and read from a texture.
    Baked {
        /// Effort of the encoder of BC7; `None` stores plain texels.
        blocks: Option<BcQuality>,
        /// `visibility.directions` of the recipe.
        directions: u32,
    },
    /// Layer-wise maps, drawn from the light.
    Maps {
        /// Settings of the runtime.
        shadows: ShadowParams,
        /// How much of the light a layer takes.
        slant: SlantForm,
    },
}

/// A way with its settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Configuration {
    /// What is varied.
    pub series: &'static str,
    /// Its value, short.
    pub label: String,
    /// The way.
    pub form: Form,
}

/// Directions that are tried, beside the recipe's.
const DIRECTIONS: [u32; 6] = [8, 12, 24, 48, 96, 192];

impl Form {
    /// Its name and settings, the first columns of the chart; `layers` of the hair, skin counted.
    pub(super) fn cells(&self, layers: u32) -> [Cell; 7] {
        let word = |word: &str| Cell::Text(word.into());
        match self {
            Self::Baked { blocks, directions } => {
                let format = if blocks.is_some() { ShellFormat::Bc7 } else { ShellFormat::Rgba8 };
                let quality = blocks.map_or(Cell::Empty, |quality| word(quality.word()));
                let directions = Cell::Number((*directions).into());
                [word("baked"), word(format.word()), quality, directions, Cell::Empty, Cell::Empty, Cell::Empty]
            }
            Self::Maps { shadows, slant } => {
                let form = if *slant == SlantForm::Printed { "printed" } else { "corrected" };
                let map_layers = shadows.map_layers.unwrap_or(layers);
                let [density, size] = [shadows.density.into(), shadows.map_size.into()].map(Cell::Number);
                [word(form), Cell::Empty, Cell::Empty, Cell::Empty, density, size, Cell::Number(map_layers.into())]
            }
        }
    }

    /// Share of the layers' optical depth that light meets in it.
    pub fn density(&self) -> f32 {
        match self {
            Self::Baked { .. } => 1.0,
            Self::Maps { shadows, .. } => shadows.density,
        }
    }
}

/// What to measure for the hair of a recipe, first what a user of it gets: baked visibility, or maps where the recipe
/// wants none baked.
pub fn configurations(recipe: &Recipe) -> Vec<Configuration> {
    let layers = recipe.slice.layers;
    let base = ShadowParams::default();
    let maps = |shadows| Form::Maps { shadows, slant: SlantForm::Corrected };
    let blocks = (recipe.pack.shell_format == ShellFormat::Bc7).then_some(recipe.pack.bc_quality);
    let own = Form::Baked { blocks, directions: recipe.visibility.directions };
    let mut out = Vec::new();
    let mut add = |series, label: String, form| {
        if !out.iter().any(|c: &Configuration| c.form == form) {
            out.push(Configuration { series, label, form });
        }
    };
    add("as the runtime does", String::new(), if recipe.visibility.enabled { own } else { maps(base) });
    let texels = |blocks| Form::Baked { blocks, directions: recipe.visibility.directions };
    add("baked, texels", ShellFormat::Rgba8.word().into(), texels(None));
    for effort in BcQuality::ALL {
        let label = format!("{}, {}", ShellFormat::Bc7.word(), effort.word());
        add("baked, texels", label, texels(Some(*effort)));
    }
    for directions in DIRECTIONS {
        add("baked, directions", directions.to_string(), Form::Baked { blocks, directions });
    }
    for map_size in [64, 128, 256, 512, 1024] {
        add("map size", format!("{map_size}²"), maps(base.with(|s| s.map_size = map_size)));
    }
    for map_size in [64, 128, 256, 512, 1024] {
        // The paper's maps have what the layers have.
        let shadows = base.with(|s| (s.map_size, s.density) = (map_size, 1.0));
        add("map size, as printed", format!("{map_size}²"), Form::Maps { shadows, slant: SlantForm::Printed });
    }
    for density in [0.4, 0.7, 1.4, 2.0] {
        add("density", density.to_string(), maps(base.with(|s| s.density = density)));
    }
    for part in [0.125, 0.25, 0.5, 0.75] {
        let map_layers = Some(((layers - 1) as f32 * part).round() as u32 + 1).filter(|n| (2..layers).contains(n));
        if let Some(n) = map_layers {
            add("fewer map layers", n.to_string(), maps(base.with(|s| s.map_layers = map_layers)));
            let small = base.with(|s| (s.map_layers, s.map_size) = (map_layers, 256));
            add("smaller maps, fewer layers", format!("256² × {n}"), maps(small));
        }
    }
    out
}
