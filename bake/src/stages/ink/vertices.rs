//! Per-vertex data of the ink style: the wash product (Fang 2006, §3) and the amounts of wash, ink and line.

use super::center::{SurfaceSample, pick};
use super::product::wash_product;
use crate::recipe::{InkFill, InkParams, ScalarMap};
use crate::stages::groom::{MapImages, average, last, names_of, report_unmatched, scalar_at};
use glam::{Vec2, Vec3};
use pelage_formats::{InkShading, InkVertex};
use pelage_import::BakeError;
use pelage_import::mesh::{Material, Mesh, MeshPart, RestPose};

/// Ink data of all vertices, and the centre of the wash.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InkVertices {
    /// Ink data per vertex.
    pub vertices: Vec<InkVertex>,
    /// Centre of the wash for materials whose tables set no centre, metres.
    pub center: Vec3,
}

/// Model to be painted.
#[derive(Clone, Copy, Debug)]
pub struct InkTarget<'a> {
    /// Mesh as stored in the package.
    pub mesh: &'a Mesh,
    /// Rest pose of `mesh`.
    pub rest: &'a RestPose,
    /// Radius of the bounding sphere, metres.
    pub radius: f32,
    /// Materials of the model.
    pub materials: &'a [Material],
    /// Images that the recipe names.
    pub images: &'a MapImages,
}

/// Ink settings of one material.
struct MaterialPaint<'a> {
    /// Map of the amount of wash, and a factor: 1 uses the map, 0 disables it. `solid` is the same for full ink.
    wash: (&'a ScalarMap, f32),
    solid: (&'a ScalarMap, f32),
    line: &'a ScalarMap,
    center: Option<Vec3>,
}

impl<'a> MaterialPaint<'a> {
    fn of(params: &'a InkParams, name: &str) -> Self {
        let tables = &params.material;
        let amount = last(tables, name, |t| t.amount.as_ref());
        let (wash, solid) = match last(tables, name, |t| t.fill.as_ref()) {
            Some(InkFill::Blank) => ((&params.wash, 0.0), (&params.solid, 0.0)),
            Some(InkFill::Wash) => ((amount.unwrap_or(&params.wash), 1.0), (&params.solid, 0.0)),
            Some(InkFill::Solid) => ((&params.wash, 1.0), (amount.unwrap_or(&FULL), 1.0)),
            None => ((amount.unwrap_or(&params.wash), 1.0), (&params.solid, 1.0)),
        };
        let line = last(tables, name, |t| t.line.as_ref()).unwrap_or(&params.lines);
        Self { wash, solid, line, center: last(tables, name, |t| t.center.as_ref()).map(|c| Vec3::from(*c)) }
    }
}

/// Amount of [`InkFill::Solid`] if the recipe gives none.
static FULL: ScalarMap = ScalarMap::Constant(1.0);

/// Evaluates the recipe at every vertex. A vertex where several materials meet gets the mean of their values.
///
/// Names that match no material are reported in `warnings`.
///
/// Fails with [`BakeError::Internal`] if an image was not read.
pub fn vertices(
    params: &InkParams,
    shading: &InkShading,
    canvas: &InkTarget<'_>,
    warnings: &mut Vec<String>,
) -> Result<InkVertices, BakeError> {
    let InkTarget { mesh, rest, radius, materials, images } = *canvas;
    report_unmatched("ink.material", &params.material, "material", names_of(materials), warnings);
    let paints: Vec<_> = materials.iter().map(|m| MaterialPaint::of(params, &m.name)).collect();
    let parts = || mesh.parts.iter().filter_map(|part| paints.get(part.material).map(|paint| (part, paint)));
    let share = |map: &ScalarMap, part: &MeshPart, v: usize, without_uvs: f32| -> Result<_, BakeError> {
        Ok(scalar_at(images, mesh, part, map, v)?.unwrap_or(without_uvs))
    };
    let amounts = average(mesh, parts(), Vec3::ZERO, |part, paint, v| {
        let wash = paint.wash.1 * share(paint.wash.0, part, v, 1.0)?;
        let solid = paint.solid.1 * share(paint.solid.0, part, v, 0.0)?;
        Ok(Vec3::new(wash, solid, share(paint.line, part, v, 1.0)?))
    })?;

    let center = match params.center {
        Some(center) => Vec3::from(center),
        None => {
            let mut spots: Vec<_> = rest
                .positions
                .iter()
                .zip(&rest.normals)
                .map(|(place, normal)| SurfaceSample { place: *place, normal: *normal, weight: 0.0 })
                .collect();
            for (part, _) in parts().filter(|(_, paint)| paint.center.is_none()) {
                for triangle in &mesh.triangles[part.first_triangle..part.first_triangle + part.triangle_count] {
                    let [a, b, c] = triangle.map(|v| rest.positions[v as usize]);
                    let third = f64::from((b - a).cross(c - a).length()) / 6.0;
                    for v in triangle.map(|v| v as usize) {
                        spots[v].weight += third * f64::from(amounts[v].x * (1.0 - amounts[v].y));
                    }
                }
            }
            pick(&spots, radius, shading).unwrap_or_default()
        }
    };
    let products = average(mesh, parts(), Vec2::ZERO, |_, paint, v| {
        let center = paint.center.unwrap_or(center);
        Ok(Vec2::from(wash_product(rest.positions[v], rest.normals[v], center, radius)))
    })?;
    let byte = |share: f32| (255.0 * share.clamp(0.0, 1.0)).round() as u8;
    let signed = |share: f32| (32767.0 * share.clamp(-1.0, 1.0)).round() as i16;
    let vertex = |(product, amount): (&Vec2, &Vec3)| InkVertex {
        wash: [signed(0.5 * product.x), signed(product.y)],
        amount: byte(amount.x),
        solid: byte(amount.y),
        line: byte(amount.z),
        reserved: 0,
    };
    Ok(InkVertices { vertices: products.iter().zip(&amounts).map(vertex).collect(), center })
}

#[cfg(test)]
#[path = "vertices_tests.rs"]
mod tests;
