//! Light at a strand's points: the eye sees the side that faces it. If light is looked up on the axis, the strand's own
//! hair slightly nearer to the light darkens it. Thinner slabs of the map make this error larger.

use super::row::{DrawCallback, Drawing, DrawnRowTest, Finding, Row};
use super::strand_width::{SIZE, above, bake, strands_of, true_camera};
use glam::{Mat4, Vec3, vec3};
use pelage_bake::recipe::{Recipe, ShadingModel, SrgbColor};
use pelage_import::BakeError;
use pelage_runtime::{FrameParams, Light, PassId, SelfShadow};
use pelage_truth::{TrueLight, VisibleStrand};
use rayon::prelude::*;

/// Row of the stability table.
pub const ROW: Row<DrawnRowTest> = Row {
    method: "light of strands",
    cliff: "a few wide strands at a slant to the light; slabs about as thick as a strand",
    naive: "shadow looked up on the axis of a strand",
    safe: "shadow looked up one radius towards the eye",
    drive,
};

/// Number of rays of the truth per point.
const RAYS: u32 = 16;
/// Spacing of the points, pixels.
const STEP_PX: u32 = 4;
/// Direction towards the light.
const LIGHT: Vec3 = vec3(-0.3, 0.4, 0.8);

/// Makes hair white, so that it is as bright as its light.
fn make_white(recipe: &mut Recipe) {
    let white = SrgbColor::hex(0xff_ff_ff);
    (recipe.color.root, recipe.color.tip, recipe.color.variation) = (Some(white), Some(white), 0.0);
    let shading = &mut recipe.shading;
    shading.model = ShadingModel::KajiyaKay;
    (shading.ambient, shading.diffuse, shading.specular) = ([0.0; 3], [1.0; 3], [0.0; 3]);
    shading.diffuse_exponent = 0.0;
}

fn drive(draw: &mut DrawCallback<'_>) -> Result<Vec<Finding>, BakeError> {
    let (width_px, density, slabs) = (4.0, 8, 16);
    let package = bake(width_px, density, make_white)?;
    let unshaded = above().with(|p| {
        p.light = Light::Directional { towards_light: LIGHT, color: Vec3::ONE };
        p.shadows.slabs = slabs;
    });
    let shaded = unshaded.clone().with_fur(|fur| fur.self_shadow = SelfShadow::Auto);
    let on_axis = shaded.clone().with(|p| p.study.light_on_axis = true);
    let mut light = |params: &FrameParams| {
        let drawing =
            Drawing { package: &package, params, size: (SIZE, SIZE), passes: &[PassId::STRANDS], at: Mat4::IDENTITY };
        Ok::<_, BakeError>(draw(&drawing)?.iter().map(|t| f64::from(t[0])).sum::<f64>())
    };
    let [all, ours, naive] = [light(&unshaded)?, light(&shaded)?, light(&on_axis)?];
    let scene = strands_of(&package)?;
    let places = scene.visible_strands(&true_camera(&unshaded), (SIZE, SIZE), STEP_PX);
    let towards = TrueLight::Directional { towards_light_ws: LIGHT, color: Vec3::ONE };
    let lit = |at: &VisibleStrand| scene.light_on_strand(at, &towards, RAYS);
    let lit: Vec<f64> = places.par_iter().filter_map(lit).collect();
    let truth = lit.iter().sum::<f64>() / lit.len().max(1) as f64;
    let error = |light: f64| (light / all / truth - 1.0).abs();
    Ok(vec![Finding {
        case: format!("strands {width_px} pixels wide, {slabs} slabs, {truth:.3} of the light reaches them"),
        measure: "relative error of the mean light, against the traced strands",
        naive: error(naive),
        safe: error(ours),
        bound: 0.06,
        fails_above: 0.08,
    }])
}
