//! Multiply scattered light deep in fur, where none of the baked rays reaches the light. A depth computed from that
//! share of 0 is infinite, so that the point would receive no scattered light: a black speck between bright hairs.

use super::measures::{grow, mean};
use super::row::{Finding, Row};
use glam::{Vec3, Vec4};
use pelage_bake::recipe::{Coat, HairParams, Recipe, VisibilityParams};
use pelage_bake::stages::visibility::{encode_visibility, visibility};
use pelage_formats::meaning::visibility_towards;
use pelage_import::BakeError;
use pelage_runtime::shared::scattering::{LEAST_BAKED, diffused_light};

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "light deep in fur",
    cliff: "points of dense fur that none of the baked rays connects to the light",
    naive: "depth computed from the share of rays, 0",
    safe: "depth computed from at least the least share that so many rays can tell from 0",
    drive,
};

/// Number of rays per point from which the truth is fitted.
const TRUE_DIRECTIONS: u32 = 768;
/// Shares of light that a pale fibre scatters forward and backward.
const SCATTERED: [f32; 2] = [0.55, 0.4];

/// Returns the multiply scattered light at a point that the share `direct` of the light reaches.
fn scattered(direct: f32, least: f32) -> f64 {
    let [on, back] = SCATTERED.map(Vec3::splat);
    let light = diffused_light(on, back, direct, least);
    f64::from((light.sent_on + light.from_light + light.from_below).x)
}

fn drive() -> Result<Vec<Finding>, BakeError> {
    let coat = Recipe::of_coat(Coat::Natural)?;
    let strands = grow(&HairParams { density: 900, ..coat.hair }, 0.2)?;
    let baked = visibility(&strands, &coat.visibility, None)?;
    let many = VisibilityParams { directions: TRUE_DIRECTIONS, ..coat.visibility };
    let truth = visibility(&strands, &many, Some(baked.horizon))?;
    let texel = |of: &Vec4| Vec4::from(encode_visibility(*of).map(|byte| f32::from(byte) / 255.0));
    let mut out = Vec::new();
    for (light, sine) in
        [("key light at 60 degrees", 0.87_f32), ("fill at 30 degrees", 0.5), ("sky at 12 degrees", 0.2)]
    {
        let towards = Vec3::new(0.0, (1.0 - sine * sine).sqrt(), sine);
        let share = |of: &Vec4| visibility_towards(texel(of), towards, baked.horizon);
        for (places, baked, truth) in
            [("strands", &baked.points, &truth.points), ("mesh surface", &baked.skin, &truth.skin)]
        {
            let unlit = || baked.iter().zip(truth).filter(|(of, _)| share(of) <= 0.0);
            let mean_light =
                |shares: Vec<f32>, least| mean(&shares.into_iter().map(|s| scattered(s, least)).collect::<Vec<_>>());
            let light_of = |least| mean_light(unlit().map(|(of, _)| share(of)).collect(), least);
            let true_light = mean_light(unlit().map(|(_, of)| share(of)).collect(), 1.0 / TRUE_DIRECTIONS as f32);
            out.push(Finding {
                case: format!("{places}, {light}, {} of {} points", unlit().count(), baked.len()),
                measure: "relative error of the mean light scattered by several fibres",
                naive: (light_of(1e-30) / true_light - 1.0).abs(),
                safe: (light_of(LEAST_BAKED) / true_light - 1.0).abs(),
                bound: 0.25,
                fails_above: 0.9,
            });
        }
    }
    Ok(out)
}
