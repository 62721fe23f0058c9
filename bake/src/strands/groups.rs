//! Growth of individual hairs on a posed mesh from guides.

use super::curves::{CurvePoint, Curves, simplified};
use super::plant::SIMPLIFICATION;
use super::skin::{PosedMesh, mix};
use glam::{DVec3, Vec2, Vec3};
use pelage_formats::HairGroup;
use pelage_formats::meaning::hair_groups::{GrownGroup, Hair, hair_color, hair_radius};
use rayon::prelude::*;

/// Grows the hairs of hair groups.
///
/// * `posed`: mesh in the pose to grow the hair in
pub fn grow_groups(groups: &[HairGroup], posed: &PosedMesh) -> Curves {
    let mut curves = Curves::default();
    for group in groups {
        let planted = GrownGroup::new(group, &posed.measured_ws, &posed.triangles, u32::MAX);
        let corners = |triangle: u32| posed.corners(triangle as usize).map(|c| c.position_ws.as_vec3());
        let guides = planted.posed_guides(corners);
        curves.begin_group(&group.name);
        let curve = |hair: &Hair| {
            let triangle = hair.root.triangle;
            let weights = DVec3::from(hair.root.weights.map(f64::from));
            let normals = posed.corners(triangle as usize).map(|c| c.normal_ws.as_vec3());
            let normal_ws = mix(weights, normals).normalize_or(Vec3::Y);
            let points = hair.points(corners(triangle), &guides);
            let last = (points.len().max(2) - 1) as f32;
            let points: Vec<CurvePoint> = points
                .enumerate()
                .map(|(k, position_ws)| {
                    let share = k as f32 / last;
                    let color = hair_color(group, hair.color, share);
                    CurvePoint { position_ws, radius_m: hair_radius(group, share), color, height: share, normal_ws }
                })
                .collect();
            let root_uv = mix(weights, posed.corners(triangle as usize).map(|c| c.base_uv));
            (simplified(&points, SIMPLIFICATION), root_uv)
        };
        let grown: Vec<(Vec<CurvePoint>, Vec2)> = planted.hairs.par_iter().map(curve).collect();
        grown.iter().for_each(|(points, root_uv)| curves.push(points, false, *root_uv));
    }
    curves
}
