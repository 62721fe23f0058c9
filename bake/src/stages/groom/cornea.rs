//! Normals of corneas. The eyes of coarse models are flat patches, in which no light has a highlight: they are lit like
//! the cap of a sphere.

use super::pairs::{components, triangle_range, weld};
use glam::Vec3;
use pelage_formats::Gloss;
use pelage_import::mesh::Mesh;

/// Minimum length of the mean normal of a flat patch; a hemisphere has 0.5, a plane 1.
const FLAT: f32 = 0.8;
/// Sine of the angle between the middle and the rim of the cap.
const RIM_SINE: f32 = 0.7;

/// Patch of wet surface.
struct WetPatch {
    triangles: Vec<[u32; 3]>,
    /// Sum of the triangles' areas, of their vector areas, and of their middles times their areas; twice each.
    area: f32,
    normal: Vec3,
    middle: Vec3,
    /// Largest distance of a corner from the middle.
    radius: f32,
}

impl WetPatch {
    fn new(mesh: &Mesh, triangles: Vec<[u32; 3]>) -> Self {
        let mut patch = Self { triangles, area: 0.0, normal: Vec3::ZERO, middle: Vec3::ZERO, radius: 0.0 };
        for triangle in &patch.triangles {
            let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
            let across = (b - a).cross(c - a);
            patch.area += across.length();
            patch.normal += across;
            patch.middle += (a + b + c) / 3.0 * across.length();
        }
        let center = patch.center();
        let corners = patch.triangles.iter().flatten();
        patch.radius = corners.map(|v| mesh.positions[*v as usize].distance(center)).fold(0.0, f32::max);
        patch
    }

    fn center(&self) -> Vec3 {
        self.middle / self.area.max(f32::MIN_POSITIVE)
    }

    /// Returns whether both patches belong to one eye, such as a pupil in front of an iris.
    fn is_one_eye(&self, other: &Self) -> bool {
        self.center().distance(other.center()) < self.radius.max(other.radius) && self.normal.dot(other.normal) > 0.0
    }
}

/// Returns the normals by which bare surface is lit, with those of corneas on flat eyes; `None` if no eye is flat.
/// Materials whose gloss is wet are eyes.
pub fn cornea_normals(mesh: &Mesh, gloss: &[Option<Gloss>]) -> Option<Vec<Vec3>> {
    let is_wet = |material: usize| gloss.get(material).copied().flatten().is_some_and(|of| of.wet);
    let parts = mesh.parts.iter().filter(|part| is_wet(part.material)).flat_map(triangle_range);
    let triangles: Vec<[u32; 3]> = parts.filter_map(|triangle| mesh.triangles.get(triangle).copied()).collect();
    let places = weld(&mesh.positions);
    let faces: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|v| places[v as usize])).collect();
    let mut eyes: Vec<WetPatch> = Vec::new();
    for component in components(&faces) {
        let mut patch = WetPatch::new(mesh, component.into_iter().map(|face| triangles[face]).collect());
        while let Some(i) = eyes.iter().position(|eye| eye.is_one_eye(&patch)) {
            let joined = [eyes.swap_remove(i).triangles, patch.triangles].concat();
            patch = WetPatch::new(mesh, joined);
        }
        eyes.push(patch);
    }
    eyes.retain(|eye| eye.radius > 0.0 && eye.normal.length() > FLAT * eye.area);
    let own = if mesh.bare_normals.is_empty() { &mesh.normals } else { &mesh.bare_normals };
    let mut normals = (!eyes.is_empty()).then(|| own.clone())?;
    for eye in &eyes {
        let (center, axis) = (eye.center(), eye.normal.normalize_or(Vec3::Z));
        for v in eye.triangles.iter().flatten().map(|v| *v as usize) {
            let aside = (mesh.positions[v] - center).reject_from_normalized(axis) * (RIM_SINE / eye.radius);
            normals[v] = aside + axis * (1.0 - aside.length_squared()).max(0.0).sqrt();
        }
    }
    Some(normals)
}
