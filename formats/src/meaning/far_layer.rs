//! Key light on the hair that is visible in the far layer, the single layer that replaces all others at a distance.

use crate::sections::manifest::detail::FarLayerInfo;

/// Returns the share of the key light that reaches the hair visible in the far layer.
///
/// * `path`: path length of the light through a layer, divided by the layer's thickness
/// * `base`, `slope`: results of `far_layer_light_coefficients`
pub fn far_layer_light(path: f32, base: f32, slope: f32) -> f32 {
    1.0 / (base + slope * path)
}

/// Returns the coefficients `base` and `slope` for which [`far_layer_light`] matches `coat.light_straight` at path 1
/// and `coat.light_slanted` at path 4.
///
/// The form 1 / (base + slope · path) is exact for fur that hides everything behind it. Hair is then visible as deep as
/// light enters. The mean of T^(ρ · path) over the transmittance T, 0..1, is 1 / (1 + ρ · path).
pub fn far_layer_light_coefficients(coat: &FarLayerInfo) -> [f32; 2] {
    // Clamp to 0.001, because zero light has no reciprocal.
    let [straight, slanted] = [coat.light_straight, coat.light_slanted].map(|t| t.max(1e-3).recip());
    let slope = (slanted - straight) / 3.0;
    [straight - slope, slope]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_layer_light_interpolates_the_stored_values() {
        let coat = FarLayerInfo { light_straight: 0.4, light_slanted: 0.15, ..FarLayerInfo::default() };
        let [base, slope] = far_layer_light_coefficients(&coat);
        for (path, expected) in [(1.0, 0.4), (4.0, 0.15)] {
            let found = far_layer_light(path, base, slope);
            assert!((found - expected).abs() < 1e-6, "{path}: {found}");
        }
        // Black hair must give only finite numbers.
        let [base, slope] = far_layer_light_coefficients(&FarLayerInfo::default());
        assert!(base.is_finite() && slope.is_finite() && far_layer_light(2.0, base, slope) <= 1e-3);
    }
}
