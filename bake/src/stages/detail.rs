//! Levels of detail: selects the levels of a package and their sizes on screen. The far fur layer is the only texture
//! that is used only by levels of detail.

use crate::recipe::{DetailParams, Recipe};
use crate::stages::slice::FarFurStats;
use pelage_formats::DetailLevel;
use pelage_formats::meaning::represented_layers;

/// Minimum number of layers of a level, not counting the layer on the mesh surface. Drawn with four such layers, a
/// hundred distant hares take two thirds of the time that they take with six or more.
const FEWEST: u32 = 4;

/// Maximum number of array layers that WebGPU guarantees.
const MOST_TEXTURE_LAYERS: u32 = 256;

/// Whether a package has the far fur layer. This needs an additional array layer, and devices are only guaranteed to
/// support 256.
pub fn has_far_layer(recipe: &Recipe) -> bool {
    recipe.detail.enabled && recipe.slice.layers < MOST_TEXTURE_LAYERS
}

/// Returns the chain of levels for `layers` layers, including the one on the mesh surface. If `coat` is given and
/// `coat_px` is above 0, the chain ends with the far fur layer. The chain is empty if levels of detail are disabled.
///
/// A level of step s draws every s-th layer. It is drawn in full down to the size at which these layers are
/// [`DetailParams::gap_px`] apart on screen. At [`DetailParams::fade`] times that size, it has disappeared. With a fade
/// of 0.5, the next level is then drawn in full.
pub fn levels(params: &DetailParams, layers: u32, coat: Option<&FarFurStats>) -> Vec<DetailLevel> {
    if !params.enabled || layers < 2 {
        return Vec::new();
    }
    let gaps = layers - 1;
    let steps = std::iter::successors(Some(1u32), |step| step.checked_mul(2));
    let mut chain: Vec<DetailLevel> = steps
        .take_while(|step| *step == 1 || (gaps - 1) / step + 1 >= FEWEST)
        .map(|step| {
            let full_px = params.gap_px * gaps as f32 / step as f32;
            let density = coat.map_or(1.0, |coat| density(&coat.opacities, step));
            DetailLevel { step, full_px, gone_px: params.fade * full_px, fins: share_of_fins(params, full_px), density }
        })
        .take_while(|level| coat.is_none() || level.step == 1 || level.full_px > params.coat_px)
        .collect();
    if let Some(last) = chain.last_mut() {
        if coat.is_some() && params.coat_px > 0.0 {
            last.full_px = params.coat_px.min(last.full_px);
            last.gone_px = params.fade * last.full_px;
            chain.push(DetailLevel { density: 1.0, ..DetailLevel::default() });
        } else {
            (last.full_px, last.gone_px) = (0.0, 0.0);
        }
    }
    // Levels must not overlap, so each is complete before the next begins to fade in.
    for i in 1..chain.len() {
        chain[i].full_px = chain[i].full_px.min(chain[i - 1].gone_px);
        chain[i].gone_px = chain[i].gone_px.min(chain[i].full_px);
    }
    chain
}

fn share_of_fins(params: &DetailParams, full_px: f32) -> f32 {
    if full_px > params.fins_px { 1.0 } else { 0.0 }
}

/// Returns the optical depth of all layers, divided by the optical depth that the layers of a level represent. It is 1
/// for hair without optical depth, and limited to 0.25..=4.
///
/// * `opacities`: opacity of each layer, from layer 1 outwards
/// * `step`: the level draws every `step`-th layer
fn density(opacities: &[f32], step: u32) -> f32 {
    let layers = opacities.len() as u32 + 1;
    let depth = |opacity: f32| -f64::from(libm::log1pf(-opacity.min(0.999)));
    let (mut all, mut drawn) = (0.0, 0.0);
    for (k, opacity) in (1..layers).zip(opacities) {
        all += depth(*opacity);
        drawn += f64::from(represented_layers(k, layers, step)) * depth(*opacity);
    }
    // A level whose layers contain almost no hair cannot be corrected.
    if step == 1 || drawn <= 0.0 { 1.0 } else { (all / drawn).clamp(0.25, 4.0) as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_formats::{FarLayerInfo, FurInfo, Manifest, PackageWriter, TextureEntry};

    /// Returns statistics with opacities that increase towards the mesh surface, as is typical of hair of many lengths.
    fn coat() -> FarFurStats {
        FarFurStats { opacities: (1..16).map(|k| 0.3 - 0.02 * k as f32).collect(), ..FarFurStats::default() }
    }

    #[test]
    fn levels_keep_the_optical_depth() {
        let opacities = coat().opacities;
        for step in [1, 2, 4] {
            let total = |exponent: &dyn Fn(u32) -> f32| -> f32 {
                (1..16u32).zip(&opacities).map(|(k, a)| exponent(k) * (1.0 - a).ln()).sum()
            };
            let stood_for = |k: u32| if (15 - k).is_multiple_of(step) { step.min(k) as f32 } else { 0.0 };
            let all = total(&|_| 1.0);
            let kept = total(&|k| density(&opacities, step) * stood_for(k));
            assert!((kept / all - 1.0).abs() < 1e-4, "step {step}: {kept} of {all}");
            // Without the factor `density`, more than 3 % of the optical depth is lost, because the outermost layers
            // are the most transparent.
            assert!(step == 1 || total(&stood_for) / all < 0.97, "step {step}");
        }
        assert_eq!(density(&[0.0; 15], 4), 1.0);
    }

    #[test]
    fn level_chain_halves_its_layers_and_ends_with_the_far_level() {
        let chain = levels(&DetailParams::default(), 16, Some(&coat()));
        let steps: Vec<_> = chain.iter().map(|l| l.step).collect();
        assert_eq!(steps, [1, 2, 4, 0], "{chain:?}");
        assert_eq!((chain[0].full_px, chain[0].gone_px), (17.25, 8.625));
        assert_eq!((chain[1].full_px, chain[1].gone_px), (8.625, 4.3125));
        assert!((chain[2].full_px - 1.2).abs() < 1e-6 && (chain[2].gone_px - 0.6).abs() < 1e-6, "{chain:?}");
        assert!(chain.windows(2).all(|w| w[0].gone_px >= w[1].full_px && w[0].fins >= w[1].fins), "{chain:?}");
        assert_eq!(chain.iter().map(|l| l.fins).collect::<Vec<_>>(), [1.0, 1.0, 1.0, 0.0]);
        let params = DetailParams { fins_px: 9.0, ..DetailParams::default() };
        assert_eq!(levels(&params, 16, Some(&coat())).iter().map(|l| l.fins).collect::<Vec<_>>(), [1.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn every_setting_gives_a_valid_level_chain() {
        for layers in [0, 1, 2, 4, 5, 16, 64, 256] {
            for coat in [None, Some(coat())] {
                for (gap_px, fade, coat_px) in [(1.0, 0.75, 1.5), (0.05, 1.0, 1e4), (64.0, 0.1, 0.0), (0.05, 0.1, 1.5)]
                {
                    let params = DetailParams { gap_px, fade, coat_px, ..DetailParams::default() };
                    let chain = levels(&params, layers, coat.as_ref());
                    if layers > 0 {
                        // The manifest's chain is validated before the textures, which are missing here.
                        let texture = |name: &str| TextureEntry { name: name.into() };
                        let manifest = Manifest {
                            fur: FurInfo {
                                layers,
                                tile_texels: 1,
                                tile_size_m: 1.0,
                                direction_texture: 1,
                                ..FurInfo::default()
                            },
                            textures: vec![texture("color"), texture("direction")],
                            detail: chain.clone(),
                            coat: coat.as_ref().map(|_| FarLayerInfo::default()),
                            ..Manifest::default()
                        };
                        let fault = PackageWriter::new(manifest).finish().map_err(|e| e.to_string());
                        assert!(fault.as_ref().is_err_and(|f| f.contains("names 2 textures")), "{fault:?}: {chain:?}");
                    }
                    assert_eq!(chain.is_empty(), layers < 2);
                    assert_eq!(
                        chain.last().is_some_and(|l| l.step == 0),
                        coat.is_some() && coat_px > 0.0 && layers > 1
                    );
                }
            }
        }
        assert!(levels(&DetailParams { enabled: false, ..DetailParams::default() }, 16, Some(&coat())).is_empty());
    }
}
