//! Layer-wise shadow maps (Yang 2006, §3). The published product uses 1 − α of a layer, whatever the length of the
//! light's path through it. That path, 1 / |N·L|, is infinite at the horizon. Light from behind crosses the layers from
//! the wrong side.

use super::measures::{grow, mean, natural_hair, opacity, slice};
use super::row::{Finding, Row};
use crate::truth::SampledVolume;
use glam::DVec3;
use pelage_bake::recipe::HairParams;
use pelage_bake::stages::slice::ShellSet;
use pelage_formats::Shading;
use pelage_import::BakeError;
use pelage_runtime::shared::kajiya_kay::back_attenuation;
use pelage_runtime::shared::layer_shadow::{layer_transmittance, slanted_path};

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "layer shadows",
    cliff: "light at a slant, at the horizon, and behind",
    naive: "product of (1 - alpha), with or without the power 1 / |N.L|; light from behind not attenuated",
    safe: "(1 - alpha)^(1 / |N.L|) with the path length clamped to 4; half of the receiving layer counted; \
           light from behind attenuated by Attenu_Back",
    drive,
};

/// Returns the transmittance of the layers above each texel of each layer, computed without maps. This is the content
/// of maps with unlimited resolution.
///
/// * `light_ts`: direction towards the light in the tile's frame, above the surface
/// * `height`: height of the outermost layer, in tile widths
/// * `layer`: function from a layer's opacity to its transmittance
/// * `own`: function from the opacity of the texel's own layer to its transmittance
///
/// The result has the layers in order, from layer 0 outwards, with `texels * texels` values each.
pub fn products(
    set: &ShellSet,
    height: f64,
    light_ts: DVec3,
    layer: impl Fn(f64) -> f64,
    own: impl Fn(f64) -> f64,
) -> Vec<Vec<f64>> {
    let (n, count) = (set.texels as usize, set.layers.len());
    let spacing = height / (count - 1) as f64;
    // Bilinear filter that repeats at the tile's borders.
    let alpha = |k: usize, u: f64, v: f64| {
        let (x, y) = (u * n as f64 - 0.5, v * n as f64 - 0.5);
        let at = |dx: f64, dy: f64| {
            let cell = |x: f64| (x.floor() as i64).rem_euclid(n as i64) as usize;
            opacity(set, k, 0, cell(y + dy) * n + cell(x + dx))
        };
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let row = |dy: f64| at(0.0, dy) + (at(1.0, dy) - at(0.0, dy)) * fx;
        row(0.0) + (row(1.0) - row(0.0)) * fy
    };
    let texel = |k: usize, i: usize| {
        let (u, v) = (((i % n) as f64 + 0.5) / n as f64, ((i / n) as f64 + 0.5) / n as f64);
        let above = (k + 1..count).map(|j| {
            let way = (j - k) as f64 * spacing / light_ts.z;
            layer(alpha(j, u + light_ts.x * way, v + light_ts.y * way))
        });
        above.product::<f64>() * if k > 0 { own(opacity(set, k, 0, i)) } else { 1.0 }
    };
    (0..count).map(|k| (0..n * n).map(|i| texel(k, i)).collect()).collect()
}

/// Evaluates the runtime's form with the runtime's own functions.
fn corrected(set: &ShellSet, height: f64, light_ts: DVec3) -> Vec<Vec<f64>> {
    let path = slanted_path(light_ts.z as f32);
    let left = |alpha: f64, path: f32| f64::from(layer_transmittance(alpha as f32, path));
    products(set, height, light_ts, |alpha| left(alpha, path), |alpha| left(alpha, 0.5 * path))
}

fn rmse(fast: &[Vec<f64>], volume: &SampledVolume, light_ts: DVec3) -> f64 {
    let squares = fast.iter().enumerate().flat_map(|(k, fast)| {
        let truth = volume.layer_transmittances(k, light_ts);
        fast.iter().zip(truth).map(|(fast, truth)| (fast - truth).powi(2)).collect::<Vec<_>>()
    });
    mean(&squares.collect::<Vec<_>>()).sqrt()
}

fn towards(angle_deg: f64) -> DVec3 {
    let (angle, azimuth) = (angle_deg.to_radians(), 0.35f64);
    DVec3::new(angle.sin() * azimuth.cos(), angle.sin() * azimuth.sin(), angle.cos())
}

fn drive() -> Result<Vec<Finding>, BakeError> {
    let height = 0.2;
    let strands = grow(&HairParams { density: 300, ..natural_hair()? }, height)?;
    let set = slice(&strands, 16, 64)?;
    let height = f64::from(strands.height);
    let volume = SampledVolume::new(&set, height)?;
    let mut out = Vec::new();
    for (angle, bound, fails_above) in [(60.0, 0.06, 0.12), (75.0, 0.15, 0.25)] {
        let light = towards(angle);
        out.push(Finding {
            case: format!("16 layers of combed hair, light {angle} degrees off the normal"),
            measure: "RMSE of t against the sampled volume",
            naive: rmse(&products(&set, height, light, |alpha| 1.0 - alpha, |_| 1.0), &volume, light),
            safe: rmse(&corrected(&set, height, light), &volume, light),
            bound,
            fails_above,
        });
    }
    // For horizontal light, the path is infinite. In the form that shaders use, a texel without hair then has
    // transmittance 1 to an infinite power, which is NaN.
    let level = |path: f32| {
        (0..=255u8).filter(move |a| {
            let alpha = f32::from(*a) / 255.0;
            let t =
                if path.is_finite() { layer_transmittance(alpha, path) } else { (path * (1.0 - alpha).log2()).exp2() };
            !(0.0..=1.0).contains(&t)
        })
    };
    out.push(Finding {
        case: "light parallel to the skin, opacities 0 to 1".into(),
        measure: "values of t outside 0..=1 or not a number",
        naive: level(1.0 / 0.0f32).count() as f64,
        safe: level(slanted_path(0.0)).count() as f64,
        bound: 0.0,
        fails_above: 0.5,
    });
    // Light from below the surface is blocked by the body, so none of it may arrive. Seen from the light, the outermost
    // layer is the last one. The map of this layer shows no shadow, because it contains only the layers above.
    let angles = [110.0, 130.0, 155.0, 180.0];
    let range = Shading::default().back_light_range;
    let arriving = |back: &dyn Fn(f32) -> f32| {
        let shares = angles.map(|angle: f64| {
            let n_dot_l = angle.to_radians().cos();
            // For light from below, the product of the layers is the same as along the ray mirrored at the surface.
            let mirrored = DVec3::new(towards(180.0 - angle).x, towards(180.0 - angle).y, -n_dot_l);
            let t = products(&set, height, mirrored, |alpha| 1.0 - alpha, |_| 1.0);
            mean(&t[set.layers.len() - 1]) * f64::from(back(n_dot_l as f32))
        });
        shares.into_iter().fold(0.0, f64::max)
    };
    out.push(Finding {
        case: "light from behind the skin, 110 to 180 degrees off the normal".into(),
        measure: "largest mean fraction of the light that reaches the outermost layer",
        naive: arriving(&|_| 1.0),
        safe: arriving(&|n_dot_l| back_attenuation(n_dot_l, range)),
        bound: 0.0,
        fails_above: 0.5,
    });
    Ok(out)
}
