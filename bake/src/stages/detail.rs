//! Levels of detail: selects the levels of a package and their sizes on screen. The far fur layer is the only texture
//! that is used only by levels of detail.

use crate::decision::metres_in_words;
use crate::recipe::{DetailParams, Recipe};
use crate::stages::slice::FarFurStats;
use glam::Vec3;
use pelage_formats::meaning::represented_layers;
use pelage_formats::{Bounds, DetailLevel};
use pelage_stage::{Framing, Look};

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

/// First words of the warning that [`gap_warning`] returns.
pub const GAP_WARNING: &str = "the layers of fur are far apart";

/// Returns a warning if layers show as slices in a picture of the default size that shows the whole model. There, they
/// are more than twice [`DetailParams::gap_px`] apart, which levels of detail never allow. As for levels of detail, the
/// size on screen is that at the nearest point of the model.
///
/// * `height_m`: height of the outermost layer, metres
/// * `bounds`: the model at rest
pub fn gap_warning(recipe: &Recipe, height_m: f32, bounds: &Bounds) -> Option<String> {
    let (gap_px, layers) = (recipe.detail.gap_px, recipe.slice.layers);
    let look = Look::default();
    let [min, max] = [bounds.min, bounds.max].map(Vec3::from);
    let corners = std::array::from_fn::<_, 8, _>(|i| {
        Vec3::from_array(std::array::from_fn(|axis| if i >> axis & 1 == 0 { min[axis] } else { max[axis] }))
    });
    let view = Framing::default().view(&corners, height_m, look.aspect());
    let distance_m = view.eye.distance(view.eye.max(min).min(max));
    let size = look.picture.size;
    let fur_px = height_m * size.height as f32 / (2.0 * libm::tanf(0.5 * view.fov_deg.to_radians()) * distance_m);
    let apart_px = fur_px / layers.saturating_sub(1).max(1) as f32;
    if !(fur_px.is_finite() && apart_px > 2.0 * gap_px) {
        return None;
    }
    let wanted = (fur_px / gap_px).ceil() as u32 + 1;
    let remedy = if wanted <= MOST_TEXTURE_LAYERS {
        format!("set slice.layers={wanted} or shorten the hair (hair.length_m)")
    } else {
        "shorten the hair (hair.length_m)".to_owned()
    };
    Some(format!(
        "{GAP_WARNING}: they reach {} from the skin, up to {fur_px:.0} pixels in a picture of {} x {} that shows the \
         whole model. There, {layers} layers are {apart_px:.1} pixels apart, expected at most {:.1}, and show as \
         slices where no single strands are drawn; {remedy}",
        metres_in_words(height_m),
        size.width,
        size.height,
        2.0 * gap_px,
    ))
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
    use crate::recipe::Coat;
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
    fn layers_that_show_as_slices_are_reported_with_a_number_that_suffices() {
        // A fox of 8 m.
        let bounds =
            Bounds { min: [-0.63, 0.0, -4.4], max: [0.63, 3.95, 3.34], center: [0.0, 1.975, -0.53], radius: 4.39 };
        let mut recipe = Recipe::of_coat(Coat::Plush).expect("the coat reads");
        let warning = gap_warning(&recipe, 0.6, &bounds).expect("16 layers on 0.6 m");
        assert!(warning.starts_with(GAP_WARNING) && warning.contains("they reach 600 mm from the skin"), "{warning}");
        let wanted = warning.split("slice.layers=").nth(1).and_then(|rest| rest.split(' ').next()).expect("a remedy");
        recipe.slice.layers = wanted.parse().expect("a number");
        assert!((40..=50).contains(&recipe.slice.layers), "{warning}");
        assert_eq!(gap_warning(&recipe, 0.6, &bounds), None);
        recipe.detail.gap_px = 0.1;
        let dense = gap_warning(&recipe, 0.6, &bounds).expect("hundreds of layers");
        assert!(dense.ends_with("drawn; shorten the hair (hair.length_m)"), "{dense}");
        // No coat has this fault, even if all of its hair stood upright.
        for coat in Coat::ALL {
            let recipe = Recipe::of_coat(*coat).expect("the coat reads");
            assert_eq!(gap_warning(&recipe, recipe.hair.length_per_radius * bounds.radius, &bounds), None, "{coat:?}");
        }
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
