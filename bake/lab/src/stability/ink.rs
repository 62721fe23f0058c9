//! Width of ink lines (Fang 2006, §2, Fig. 3). With the sphere map alone, everything seen at a grazing angle is
//! outline, so flat parts seen edge on turn entirely black. The template limits lines to their width around the
//! features.

use super::row::{DrawCallback, Drawing, DrawnRowTest, Finding, Row};
use super::{silhouette, surface};
use crate::chart::ink::{on_blank_paper, template_px};
use crate::mask::Mask;
use glam::{Mat4, Vec3, vec3};
use pelage_bake::recipe::Recipe;
use pelage_formats::{Limits, Package};
use pelage_import::BakeError;
use pelage_import::mesh::Model;
use pelage_runtime::{Camera, FrameParams, InkDebugView, InkLines, InkParams, PassId};

/// Row of the stability table.
pub const ROW: Row<DrawnRowTest> = Row {
    method: "ink",
    cliff: "large flat faces seen edge on: black patches",
    naive: "the sphere map alone",
    safe: "no ink farther than half a line width from a feature",
    drive,
};

/// Size of the pictures, pixels.
const SIZE: (u32, u32) = (300, 300);
/// Number of evenly spaced directions around the model from which it is viewed.
const VIEWS: u32 = 24;

/// Returns a box whose faces share no vertices, so that each face keeps its own normal.
fn cube() -> Model {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        for normal in [axis, -axis] {
            let (u, v) = normal.any_orthonormal_pair();
            let base = positions.len() as u32;
            positions.extend([-u - v, u - v, u + v, v - u].map(|corner| 0.5 * (normal + corner)));
            triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
        }
    }
    surface::model(positions, triangles)
}

/// Returns a flat and thin shape, like a hare's ear.
fn ear() -> Model {
    let ball = surface::sphere(48, 64).mesh;
    let flat = |p: &Vec3| *p * vec3(0.4, 1.0, 0.1);
    surface::model(ball.positions.iter().map(flat).collect(), ball.triangles)
}

/// Returns the widest stroke of a package over all views, first without the template, then with it. Widths are divided
/// by the width of the template.
fn widest(package: &[u8], draw: &mut DrawCallback<'_>) -> Result<[f64; 2], BakeError> {
    let opened = Package::open(package, &Limits::default());
    let bounds =
        opened.map_err(|e| BakeError::Internal(format!("cannot read back the baked package: {e}")))?.manifest().bounds;
    let ink = on_blank_paper(&InkParams::default().with(|ink| ink.lines = InkLines::Pixels));
    let template_px = template_px(&ink, SIZE.1);
    let mut most = [0.0f64; 2];
    for view in 0..VIEWS {
        let (s, c) = (std::f32::consts::TAU * view as f32 / VIEWS as f32).sin_cos();
        let towards = vec3(s, 0.2, c);
        let camera = Camera::framing(Vec3::from(bounds.center), bounds.radius, towards, 0.5, 1.0);
        for (most, template) in most.iter_mut().zip([false, true]) {
            let params = FrameParams::new(camera, [SIZE.0, SIZE.1]).with_ink(ink.clone());
            let params = params.with(|p| (p.study.template, p.debug.ink) = (template, InkDebugView::Lines));
            let texels = draw(&Drawing {
                package,
                params: &params,
                size: SIZE,
                passes: &[PassId::INK_COMPOSITE],
                at: Mat4::IDENTITY,
            })?;
            let pixels = texels.iter().map(|texel| texel[0] < 0.5).collect();
            let strokes = Mask { width: SIZE.0, height: SIZE.1, pixels };
            *most = most.max(strokes.widest_stroke().width_px / template_px);
        }
    }
    Ok(most)
}

fn drive(draw: &mut DrawCallback<'_>) -> Result<Vec<Finding>, BakeError> {
    let mut out = Vec::new();
    for (case, model) in [("a cube", cube()), ("a flat ear", ear())] {
        let mut recipe = Recipe::default();
        // Where hair grows, the bake smooths the normals; a bare surface keeps the normals of its faces.
        recipe.set("model.bare=[\"*\"]")?;
        let package = silhouette::bake(case, &model, &recipe)?;
        let [naive, safe] = widest(&package, draw)?;
        out.push(Finding {
            case: format!("{case} from {VIEWS} sides"),
            measure: "widest stroke, in template widths",
            naive,
            safe,
            bound: 1.0,
            fails_above: 3.0,
        });
    }
    Ok(out)
}
