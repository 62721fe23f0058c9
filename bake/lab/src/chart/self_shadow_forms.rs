//! Methods of the topic `self-shadow` for light that passes through hair, and their settings.

use super::Cell;
use pelage_bake::recipe::{BcQuality, Recipe, ShellFormat};
use pelage_runtime::{ShadowParams, SlantForm};

/// Method of determining the light that passes through hair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SelfShadowForm {
    /// Visibility computed by rays in the bake and read from a texture.
    Baked {
        /// Effort of the BC7 encoder; `None` for uncompressed texels.
        blocks: Option<BcQuality>,
        /// `visibility.directions` of the recipe.
        directions: u32,
    },
    /// Layer-wise maps, rendered from the light.
    Maps {
        /// Shadow settings of the runtime.
        shadows: ShadowParams,
        /// Form in which the fraction of slanted light that a layer absorbs is computed: corrected or published.
        slant: SlantForm,
    },
}

/// Method with its settings.
#[derive(Clone, Debug, PartialEq)]
pub struct SelfShadowConfiguration {
    /// Name of the varied setting.
    pub series: &'static str,
    /// Short value of the varied setting.
    pub label: String,
    /// Method to measure.
    pub form: SelfShadowForm,
}

/// Numbers of directions to measure besides the recipe's.
const DIRECTIONS: [u32; 6] = [8, 12, 24, 48, 96, 192];

impl SelfShadowForm {
    /// Returns the name and settings, which are the first columns of the chart. `layers` counts the hair's layers,
    /// layer 0 included.
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

    /// Returns the factor by which this form scales the layers' optical depth: the maps' `density`, or 1 for baked
    /// visibility.
    pub fn density(&self) -> f32 {
        match self {
            Self::Baked { .. } => 1.0,
            Self::Maps { shadows, .. } => shadows.density,
        }
    }
}

/// Lists what to measure for the hair of a recipe. The first configuration is the recipe's own: baked visibility, or
/// maps if the recipe bakes none.
pub fn configurations(recipe: &Recipe) -> Vec<SelfShadowConfiguration> {
    let layers = recipe.slice.layers;
    let base = ShadowParams::default();
    let maps = |shadows| SelfShadowForm::Maps { shadows, slant: SlantForm::Corrected };
    let blocks = (recipe.pack.shell_format == ShellFormat::Bc7).then_some(recipe.pack.bc_quality);
    let own = SelfShadowForm::Baked { blocks, directions: recipe.visibility.directions };
    let mut out = Vec::new();
    let mut add = |series, label: String, form| {
        if !out.iter().any(|c: &SelfShadowConfiguration| c.form == form) {
            out.push(SelfShadowConfiguration { series, label, form });
        }
    };
    add("as the runtime does", String::new(), if recipe.visibility.enabled { own } else { maps(base) });
    let texels = |blocks| SelfShadowForm::Baked { blocks, directions: recipe.visibility.directions };
    add("baked, texels", ShellFormat::Rgba8.word().into(), texels(None));
    for effort in BcQuality::ALL {
        let label = format!("{}, {}", ShellFormat::Bc7.word(), effort.word());
        add("baked, texels", label, texels(Some(*effort)));
    }
    for directions in DIRECTIONS {
        add("baked, directions", directions.to_string(), SelfShadowForm::Baked { blocks, directions });
    }
    for map_size in [64, 128, 256, 512, 1024] {
        add("map size", format!("{map_size}²"), maps(base.with(|s| s.map_size = map_size)));
    }
    for map_size in [64, 128, 256, 512, 1024] {
        // In the published form, maps use the layers' full optical depth.
        let shadows = base.with(|s| (s.map_size, s.density) = (map_size, 1.0));
        add(
            "map size, as published",
            format!("{map_size}²"),
            SelfShadowForm::Maps { shadows, slant: SlantForm::Printed },
        );
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
