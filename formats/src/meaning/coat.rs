//! How much of the key light reaches the hair that is seen in the far coat.

use crate::sections::manifest::detail::CoatInfo;

/// Share of the key light that reaches the hair seen in the far coat, where the way through a layer is `path` times its thickness.
pub fn coat_light(path: f32, base: f32, slope: f32) -> f32 {
    1.0 / (base + slope * path)
}

/// The numbers `base` and `slope` for [`coat_light`], which meets the coat's two at a path of 1 and of 4.
///
/// That form is exact for a coat that hides everything behind it: where hair is seen as deep as light comes into it, t is the mean of
/// T^(ρp) over the transmittance T, 1 / (1 + ρp).
pub fn coat_light_numbers(coat: &CoatInfo) -> [f32; 2] {
    // Light that is gone has no reciprocal.
    let [straight, slanted] = [coat.light_straight, coat.light_slanted].map(|t| t.max(1e-3).recip());
    let slope = (slanted - straight) / 3.0;
    [straight - slope, slope]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stored_lights_are_met_where_they_were_measured() {
        let coat = CoatInfo { light_straight: 0.4, light_slanted: 0.15, ..CoatInfo::default() };
        let [base, slope] = coat_light_numbers(&coat);
        for (path, expected) in [(1.0, 0.4), (4.0, 0.15)] {
            let found = coat_light(path, base, slope);
            assert!((found - expected).abs() < 1e-6, "{path}: {found}");
        }
        let [base, slope] = coat_light_numbers(&CoatInfo::default());
        assert!(coat_light(1.0, base, slope).is_finite());
    }
}
