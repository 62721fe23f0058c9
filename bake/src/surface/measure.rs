//! How good a parameterization is: the measures of accuracy.md, on the furred triangles in the posed rest state.

use super::frames::{area2, uv_det};
use crate::mesh::{Mesh, RestPose};
use glam::Vec2;
use serde::Serialize;
use std::collections::HashMap;

/// Measures of the map from the skin to its tile coordinates, after one global scale that makes the total areas equal; means are
/// weighted by area on the skin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Measures {
    /// Connected regions of the furred skin in which tile coordinates are continuous.
    pub patches: u32,
    /// Triangles that the map turns over, as seen from outside.
    pub flipped_triangles: u32,
    /// Mean of (σ1/σ2 + σ2/σ1)/2 − 1; 0 for a conformal map.
    pub angle_distortion: f64,
    /// Mean of (σ1σ2 + 1/(σ1σ2))/2 − 1; 0 for an area-preserving map.
    pub area_distortion: f64,
    /// Sander's L² stretch, sqrt(mean of (σ1² + σ2²)/2); 1 for an isometry.
    pub stretch_l2: f64,
    /// Length of the edges whose two sides disagree in tile coordinates by more than whole tiles, over sqrt(skin area).
    pub seam_length_ratio: f64,
    /// Share of the furred skin left out of the means because a triangle has no area on the skin or in the tile, 0..=1.
    pub collapsed_area: f64,
}

/// Singular values σ1 ≥ σ2 of the linear map from the triangle's plane to tile coordinates; `None` where the triangle has no area.
fn singular_values(p: [glam::Vec3; 3], uv: [Vec2; 3]) -> Option<(f64, f64)> {
    let (e1, e2) = ((p[1] - p[0]).as_dvec3(), (p[2] - p[0]).as_dvec3());
    let length = e1.length();
    let x = e1 / length;
    let y = (e2 - x * e2.dot(x)).try_normalize()?;
    let (d1, d2) = ((uv[1] - uv[0]).as_dvec2(), (uv[2] - uv[0]).as_dvec2());
    let along_x = d1 / length;
    let along_y = (d2 - along_x * e2.dot(x)) / e2.dot(y);
    let (a, b, c) = (along_x.length_squared(), along_x.dot(along_y), along_y.length_squared());
    let (mean, spread) = ((a + c) / 2.0, (((a - c) / 2.0).powi(2) + b * b).sqrt());
    let (s1, s2) = ((mean + spread).sqrt(), (mean - spread).max(0.0).sqrt());
    (s1.is_finite() && s2 > 1e-9 * s1).then_some((s1, s2))
}

pub(super) fn measure(mesh: &Mesh, rest: &RestPose, tile_uvs: &[Vec2], furred: &[bool]) -> Measures {
    let triangles: Vec<&[u32; 3]> = mesh.triangles.iter().zip(furred).filter(|(_, f)| **f).map(|(t, _)| t).collect();
    let mut out = Measures::default();
    let mut rows = Vec::new();
    let (mut skin, mut tile, mut collapsed) = (0f64, 0f64, 0f64);
    for t in &triangles {
        let area = f64::from(area2(&rest.positions, t)) / 2.0;
        let det = uv_det(tile_uvs, t);
        out.flipped_triangles += u32::from(det < 0.0);
        match singular_values(t.map(|i| rest.positions[i as usize]), t.map(|i| tile_uvs[i as usize])) {
            Some((s1, s2)) => {
                rows.push((area, s1, s2));
                skin += area;
                tile += area * s1 * s2;
            }
            None => collapsed += area,
        }
    }
    if skin > 0.0 && tile > 0.0 {
        // After this factor the total areas are equal.
        let k = (skin / tile).sqrt();
        let mut l2 = 0.0;
        for (area, s1, s2) in rows {
            let (s1, s2) = (s1 * k, s2 * k);
            out.angle_distortion += area * ((s1 / s2 + s2 / s1) / 2.0 - 1.0) / skin;
            out.area_distortion += area * ((s1 * s2 + 1.0 / (s1 * s2)) / 2.0 - 1.0) / skin;
            l2 += area * (s1 * s1 + s2 * s2) / 2.0 / skin;
        }
        out.stretch_l2 = l2.sqrt();
        out.collapsed_area = collapsed / (skin + collapsed);
    }
    let (seams, patches) = seams_and_patches(rest, tile_uvs, &triangles);
    out.patches = patches;
    if skin + collapsed > 0.0 {
        out.seam_length_ratio = seams / (skin + collapsed).sqrt();
    }
    out
}

/// Total length of the seams, and the number of regions they leave.
fn seams_and_patches(rest: &RestPose, tile_uvs: &[Vec2], triangles: &[&[u32; 3]]) -> (f64, u32) {
    type Side = (usize, [Vec2; 2]);
    let point = |i: u32| rest.positions[i as usize].to_array().map(|v| (v + 0.0).to_bits());
    let mut edges: HashMap<_, Side> = HashMap::new();
    let mut parent: Vec<usize> = (0..triangles.len()).collect();
    fn root(parent: &mut [usize], mut i: usize) -> usize {
        while parent[i] != i {
            parent[i] = parent[parent[i]];
            i = parent[i];
        }
        i
    }
    let mut seams = 0f64;
    for (index, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (mut a, mut b) = (t[k], t[(k + 1) % 3]);
            if point(a) > point(b) {
                (a, b) = (b, a);
            }
            let side = [tile_uvs[a as usize], tile_uvs[b as usize]];
            let Some((other, theirs)) = edges.insert((point(a), point(b)), (index, side)) else { continue };
            // The tile repeats: an offset by whole tiles, the same at both ends, shows no seam.
            let offset = side[0] - theirs[0];
            let continuous = (offset - offset.round()).abs().max_element() < 1e-3
                && (side[1] - theirs[1] - offset).abs().max_element() < 1e-3;
            if continuous {
                let (x, y) = (root(&mut parent, index), root(&mut parent, other));
                parent[x] = y;
            } else {
                seams += f64::from(rest.positions[a as usize].distance(rest.positions[b as usize]));
            }
        }
    }
    let patches = (0..triangles.len()).filter(|i| root(&mut parent, *i) == *i).count();
    (seams, patches as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec3, vec2, vec3};

    const SQUARE: [Vec3; 4] = [vec3(0., 0., 0.), vec3(1., 0., 0.), vec3(1., 1., 0.), vec3(0., 1., 0.)];

    fn measured(uvs: [Vec2; 4]) -> Measures {
        let mesh = Mesh { triangles: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() };
        let rest = RestPose { positions: SQUARE.to_vec(), normals: vec![Vec3::Z; 4] };
        measure(&mesh, &rest, &uvs, &[true, true])
    }

    #[test]
    fn an_isometry_is_perfect_at_any_scale() {
        let m = measured([vec2(0., 0.), vec2(3., 0.), vec2(3., 3.), vec2(0., 3.)]);
        assert!(m.angle_distortion.abs() < 1e-9 && m.area_distortion.abs() < 1e-9, "{m:?}");
        assert!((m.stretch_l2 - 1.0).abs() < 1e-9 && m.patches == 1 && m.flipped_triangles == 0, "{m:?}");
        assert_eq!(m.seam_length_ratio, 0.0);
    }

    #[test]
    fn a_two_to_one_stretch_measures_as_such() {
        // σ = (√2, 1/√2) after equalising areas: (2 + 1/2)/2 − 1 = 0.25, (2 + 0.5)/2 = 1.25.
        let m = measured([vec2(0., 0.), vec2(2., 0.), vec2(2., 1.), vec2(0., 1.)]);
        assert!((m.angle_distortion - 0.25).abs() < 1e-6, "{m:?}");
        assert!(m.area_distortion.abs() < 1e-6 && (m.stretch_l2 - 1.25f64.sqrt()).abs() < 1e-6, "{m:?}");
    }

    #[test]
    fn flips_and_collapses_are_counted() {
        let m = measured([vec2(0., 0.), vec2(1., 0.), vec2(1., 1.), vec2(2., 0.5)]);
        assert_eq!(m.flipped_triangles, 1, "{m:?}");
        let m = measured([vec2(0., 0.), vec2(1., 0.), vec2(1., 1.), vec2(0.5, 0.5)]);
        assert!((m.collapsed_area - 0.5).abs() < 1e-6, "{m:?}");
    }

    #[test]
    fn a_cut_is_a_seam_unless_it_is_a_whole_tile() {
        let uvs = |shift: f32| {
            let s = vec2(shift, 0.0);
            vec![vec2(0., 0.), vec2(1., 0.), vec2(1., 1.), s, vec2(1., 1.) + s, vec2(0., 1.) + s]
        };
        let mesh = Mesh { triangles: vec![[0, 1, 2], [3, 4, 5]], ..Mesh::default() };
        let [a, b, c, d] = SQUARE;
        let rest = RestPose { positions: vec![a, b, c, a, c, d], normals: vec![Vec3::Z; 6] };
        let whole = measure(&mesh, &rest, &uvs(2.0), &[true, true]);
        assert_eq!((whole.patches, whole.seam_length_ratio), (1, 0.0));
        let half = measure(&mesh, &rest, &uvs(0.5), &[true, true]);
        assert_eq!(half.patches, 2);
        assert!((half.seam_length_ratio - 2f64.sqrt()).abs() < 1e-6);
    }
}
