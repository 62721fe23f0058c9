//! Soft shadows from a shadow-width map (Yang 2006, §5: 1 − C_scale · sw / sd). Here, sw is the shadow width, and sd
//! the depth behind the first surface. With a nearby occluder, sd is only the rounding error of the depth map, and the
//! quotient is arbitrary. At the hard edge the blurred map is one half, which makes a step.

use super::row::{Finding, Row};
use glam::Vec4;
use pelage_import::BakeError;
use pelage_runtime::shared::layer_shadow::slanted_path;
use pelage_runtime::shared::soft_shadow::{SoftShadow, soft_shadow};

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "soft shadow",
    cliff: "sd -> 0 at contacts and on lit skin; light at the horizon; the edge of the blurred map",
    naive: "1 - C_scale sw / sd, sw from the blurred map as it is",
    safe: "depth bias of one texel, penumbra width clamped, sw counted from the middle of the blur",
    drive,
};

/// Returns Attenu_Shadow in the published form. `sd` and `sw` have the same unit.
pub fn printed_attenuation(sd: f32, sw: f32, c_scale: f32) -> f32 {
    if sd == 0.0 { 1.0 } else { (1.0 - c_scale * sw / sd).clamp(0.0, 1.0) }
}

/// Maps of 512 texels over two metres, as in the runtime's defaults.
const SOFT: SoftShadow =
    SoftShadow { range_m: 2.0, penumbra: 0.15, blur: 16.0 / 3.0 * 2.0 / 512.0, texel: 2.0 / 512.0 };

/// Returns a texel of the map: occlusion, depth of the occluder, depth of the first surface.
fn texel(occlusion: f32, thrower: f32, first: f32) -> Vec4 {
    Vec4::new(occlusion, occlusion * thrower, first, 1.0)
}

/// Evaluates the published form for the same values.
fn printed(texel: Vec4, z: f32) -> f32 {
    printed_attenuation((z - texel.z) * SOFT.range_m, texel.x * SOFT.blur, 1.0 / SOFT.penumbra)
}

/// Returns the errors of the published form and of the runtime's form. The runtime has two variants, of which the worse
/// counts.
fn both(texel: Vec4, z: f32, n_dot_l: f32, truth: f32) -> (f64, f64) {
    let error = |value: f32| f64::from((value - truth).abs());
    let safe = [true, false].map(|centred| error(soft_shadow(texel, z, 1.0, slanted_path(n_dot_l), &SOFT, centred)));
    (error(printed(texel, z)), worst(safe))
}

/// Returns the greatest value; NaN counts as the greatest.
fn worst(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |worst: f64, x| if x.is_nan() || x > worst { x } else { worst })
}

/// Tests a lit surface beside the edge of a shadow that falls elsewhere. The surface has the map's depth up to
/// rounding, but the blurred map has some occlusion there.
fn lit_surface() -> (f64, f64) {
    let cases = (0..1000).map(|i| {
        let occlusion = 0.45 * (i as f32 / 1000.0);
        // The f32 depth map has steps of 6e-8 near 0.5; filtering between texels adds to that.
        let rounding = ((i * 7919) % 1000) as f32 * 1e-9;
        both(texel(occlusion, 0.5, 0.5), 0.5 + rounding, 0.8, 1.0)
    });
    let (naive, safe): (Vec<f64>, Vec<f64>) = cases.unzip();
    (worst(naive), worst(safe))
}

/// Tests a lit surface that the light grazes. The surface is slanted, so its depth varies within a texel of the map. A
/// convex body casts no shadow on itself, but another shadow may fall beyond its edge as seen from the light. The
/// blurred map therefore has some occlusion at the point.
fn at_the_horizon() -> (f64, f64) {
    let cases = (0..1000).map(|i| {
        let n_dot_l = 0.26 + 0.2 * (i % 10) as f32 / 10.0;
        let slope = (1.0 - n_dot_l * n_dot_l).sqrt() / n_dot_l;
        let within = (i / 10) as f32 / 100.0 - 0.5;
        let depth = within * SOFT.texel * slope / SOFT.range_m;
        both(texel(0.3, 0.5, 0.5), 0.5 + depth, n_dot_l, 1.0)
    });
    let (naive, safe): (Vec<f64>, Vec<f64>) = cases.unzip();
    (worst(naive), worst(safe))
}

/// Returns the largest difference in light between adjacent points on a line across the straight edge of a shadow. The
/// occluder is `gap_m` metres above the line, and there are a hundred points per width of the true penumbra.
fn across_the_edge(gap_m: f32) -> (f64, f64) {
    let width = gap_m * SOFT.penumbra;
    let (thrower, z) = (0.25, 0.25 + gap_m / SOFT.range_m);
    let light = |centred: Option<bool>| {
        let steps = -200i16..=200;
        let value = steps.map(|i| {
            let inside = width * f32::from(i) / 100.0;
            let occlusion = (0.5 + 0.5 * inside / SOFT.blur).clamp(0.0, 1.0);
            // The first surface is the occluder within the shadow, and the receiver itself outside.
            let first = if inside > 0.0 { thrower } else { z };
            let texel = texel(occlusion, thrower, first);
            match centred {
                Some(centred) => soft_shadow(texel, z, 1.0, 1.0, &SOFT, centred),
                None => printed(texel, z),
            }
        });
        value.map(f64::from).collect::<Vec<_>>()
    };
    let step = |values: Vec<f64>| worst(values.windows(2).map(|w| (w[1] - w[0]).abs()));
    (step(light(None)), worst([true, false].map(|centred| step(light(Some(centred))))))
}

/// Counts values that are NaN or outside 0..=1, over all possible contents of maps and lights. The published quotient
/// has such values where there is neither occluder nor receiver: at an empty texel of both maps.
fn count_invalid() -> (f64, f64) {
    let (mut naive, mut safe) = (0u32, 0u32);
    let sound = |x: f32| (0.0..=1.0).contains(&x);
    for occlusion in [0.0, 1e-8, 0.2, 0.5, 0.7, 1.0] {
        for first in [0.0, 0.3, 0.3 + 1e-7, 1.0] {
            for z in [-0.1, 0.0, 0.3, 0.3 + 1e-6, 0.9, 1.0, 1.1] {
                for penumbra in [0.0, 1e-6, 0.15, 2.0] {
                    let texel = texel(occlusion, first, first);
                    let s = SoftShadow { penumbra, ..SOFT };
                    let sd = (z - first) * s.range_m;
                    let quotient = 1.0 - (1.0 / penumbra) * (texel.x * s.blur) / sd;
                    naive += u32::from(!sound(quotient.clamp(0.0, 1.0)));
                    for n_dot_l in [-1.0, -0.1, 0.0, 1e-9, 0.5, 1.0] {
                        for distance in [1e-6, 1.0, 1e4] {
                            for centred in [true, false] {
                                let path = slanted_path(n_dot_l);
                                safe += u32::from(!sound(soft_shadow(texel, z, distance, path, &s, centred)));
                            }
                        }
                    }
                }
            }
        }
    }
    (f64::from(naive), f64::from(safe))
}

fn drive() -> Result<Vec<Finding>, BakeError> {
    let finding = |case: &str, measure, (naive, safe), bound, fails_above| Finding {
        case: case.into(),
        measure,
        naive,
        safe,
        bound,
        fails_above,
    };
    let share = "largest error of the visible fraction of the light";
    Ok(vec![
        finding("lit skin beside a shadow's edge, depths equal except for rounding", share, lit_surface(), 0.002, 0.9),
        finding("lit skin, light 15 to 27 degrees above its horizon", share, at_the_horizon(), 0.02, 0.5),
        finding(
            "a path across the edge of a shadow cast from 0.1 m, 100 steps per penumbra width",
            "largest step of the visible fraction of the light",
            across_the_edge(0.1),
            0.05,
            0.5,
        ),
        finding(
            "maps and lights of all kinds, penumbra 0 to 2",
            "values outside 0..=1 or not a number",
            count_invalid(),
            0.0,
            3.0,
        ),
    ])
}
