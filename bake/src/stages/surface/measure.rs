//! Quality measures of a parameterization, for the furred triangles in the posed rest state. The stretch is that of
//! Sander et al. 2001.

use super::solve::{FaceFrame, gradients, jacobian, singular_values};
use super::topology::{NONE, Topology};
use glam::{DMat2, DVec2};
use serde::Serialize;

/// Measures of the map from the mesh surface to its tile coordinates. Before measuring, one global scale makes the
/// total areas on the surface and in the tile equal. Means are weighted by area on the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Measures {
    /// Number of connected regions of the furred surface in which tile coordinates are continuous.
    pub patches: u32,
    /// Number of triangles that the map flips, as seen from outside.
    pub flipped_triangles: u32,
    /// Mean of (σ1/σ2 + σ2/σ1)/2 − 1; 0 for a conformal map.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub angle_distortion: f64,
    /// Mean of (σ1σ2 + 1/(σ1σ2))/2 − 1; 0 for an area-preserving map.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub area_distortion: f64,
    /// Sander's L² stretch, sqrt(mean of (σ1² + σ2²)/2); 1 for an isometry.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub stretch_l2: f64,
    /// Length of edges on whose two sides tile coordinates differ by anything but whole tiles, divided by sqrt(surface
    /// area).
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub seam_length_ratio: f64,
    /// Mean angle between the comb field and the tile's v direction, degrees; `None` without a comb.
    pub comb_misalignment_deg: Option<f64>,
    /// Number of points around which the comb field turns: sources, sinks, whorls and saddles.
    pub singularities: u32,
    /// Share of the furred surface that the means exclude, because its triangles have no area on the surface or in the
    /// tile, 0..=1.
    #[serde(skip)]
    pub collapsed_area: f64,
}

/// Ratio of singular values below which a triangle counts as collapsed.
const COLLAPSED: f64 = 1e-9;

/// Returns the measures of the whole surface, and for each face the number of the region that contains it. Tile
/// coordinates are continuous within a region.
///
/// * `frames`: comb frame of each face
/// * `corners`: tile coordinates of each face's corners
/// * `combed`: whether the frames follow a comb
pub(super) fn measure(
    topology: &Topology,
    frames: &[FaceFrame],
    corners: &[[DVec2; 3]],
    combed: bool,
    singularities: usize,
) -> (Measures, Vec<u32>) {
    let mut out = Measures { singularities: singularities as u32, ..Measures::default() };
    let mut maps: Vec<(f64, DMat2)> = Vec::new();
    let (mut skin, mut tile, mut collapsed) = (0f64, 0f64, 0f64);
    for (f, frame) in frames.iter().enumerate() {
        let area = topology.areas[f];
        let map = jacobian(&gradients(topology, f, frame), corners[f], frame.tile_m);
        out.flipped_triangles += u32::from(map.determinant() < 0.0);
        let (s1, s2) = singular_values(map);
        if s1.is_finite() && s2.abs() > COLLAPSED * s1 {
            maps.push((area, map));
            skin += area;
            tile += area * s1 * s2.abs();
        } else {
            collapsed += area;
        }
    }
    if skin > 0.0 && tile > 0.0 {
        // Scale that makes the total areas on the surface and in the tile equal.
        let k = (skin / tile).sqrt();
        let (mut l2, mut misaligned) = (0.0, 0.0);
        for (area, map) in maps {
            let (s1, s2) = singular_values(map);
            let (s1, s2) = (s1 * k, s2.abs() * k);
            out.angle_distortion += area * ((s1 / s2 + s2 / s1) / 2.0 - 1.0) / skin;
            out.area_distortion += area * ((s1 * s2 + 1.0 / (s1 * s2)) / 2.0 - 1.0) / skin;
            l2 += area * (s1 * s1 + s2 * s2) / 2.0 / skin;
            // Direction of the tile's v on the mesh surface, in the frame of the comb, whose own direction is (0, 1).
            let along_v = map.inverse().y_axis;
            misaligned += area * libm::atan2(along_v.x.abs(), along_v.y).to_degrees() / skin;
        }
        out.stretch_l2 = l2.sqrt();
        out.collapsed_area = collapsed / (skin + collapsed);
        out.comb_misalignment_deg = combed.then_some(misaligned);
    }
    let (seams, regions) = seams_and_regions(topology, corners);
    out.patches = regions.iter().max().map_or(0, |last| last + 1);
    if skin + collapsed > 0.0 {
        out.seam_length_ratio = seams / (skin + collapsed).sqrt();
    }
    (out, regions)
}

/// Returns the total length of the seams, and the region of each face. Regions are separated by seams and numbered in
/// the order of their first faces.
fn seams_and_regions(topology: &Topology, corners: &[[DVec2; 3]]) -> (f64, Vec<u32>) {
    let end_uvs = |h: u32| {
        let (uvs, k) = (&corners[h as usize / 3], h as usize % 3);
        [uvs[k], uvs[(k + 1) % 3]]
    };
    let continuous = |h: u32, twin: u32| {
        let ([a, b], [c, d]) = (end_uvs(h), end_uvs(twin));
        // The tile repeats, so a difference of whole tiles is invisible if it is the same at both ends of the edge.
        let offset = a - d;
        (offset - offset.round()).abs().max_element() < 1e-3 && (b - c - offset).abs().max_element() < 1e-3
    };
    let mut seams = 0.0;
    let mut joined = vec![false; topology.twins.len()];
    for (h, twin) in topology.twins.iter().enumerate().filter(|(_, twin)| **twin != NONE) {
        joined[h] = continuous(h as u32, *twin);
        if !joined[h] {
            seams += topology.edge_length(h as u32) / 2.0;
        }
    }
    (seams, topology.regions(|h| joined[h as usize]))
}

#[cfg(test)]
mod tests {
    use super::super::repair::repair;
    use super::*;
    use glam::{DVec3, dvec2, dvec3};

    const SQUARE: [DVec3; 4] = [dvec3(0., 0., 0.), dvec3(1., 0., 0.), dvec3(1., 1., 0.), dvec3(0., 1., 0.)];

    /// Measures a square. `corners`: tile coordinates of its two triangles.
    fn measured(corners: [[DVec2; 3]; 2]) -> Measures {
        let topology = repair(&SQUARE, &[[0, 1, 2], [0, 2, 3]]).topology;
        let frame = FaceFrame { s: DVec3::X, t: DVec3::Y, tile_m: 1.0 };
        measure(&topology, &[frame; 2], &corners, true, 0).0
    }

    fn joined(uvs: [DVec2; 4]) -> Measures {
        measured([[uvs[0], uvs[1], uvs[2]], [uvs[0], uvs[2], uvs[3]]])
    }

    #[test]
    fn isometry_has_no_distortion_at_any_scale() {
        let m = joined([dvec2(0., 0.), dvec2(3., 0.), dvec2(3., 3.), dvec2(0., 3.)]);
        assert!(m.angle_distortion.abs() < 1e-9 && m.area_distortion.abs() < 1e-9, "{m:?}");
        assert!((m.stretch_l2 - 1.0).abs() < 1e-9 && m.patches == 1 && m.flipped_triangles == 0, "{m:?}");
        assert_eq!((m.seam_length_ratio, m.comb_misalignment_deg), (0.0, Some(0.0)));
    }

    #[test]
    fn two_to_one_stretch_has_the_expected_measures() {
        // After equalising areas, σ = (√2, 1/√2): the angle distortion is (2 + 1/2)/2 − 1 = 0.25, and the mean of the
        // squares is (2 + 0.5)/2 = 1.25.
        let m = joined([dvec2(0., 0.), dvec2(2., 0.), dvec2(2., 1.), dvec2(0., 1.)]);
        assert!((m.angle_distortion - 0.25).abs() < 1e-6, "{m:?}");
        assert!(m.area_distortion.abs() < 1e-6 && (m.stretch_l2 - 1.25f64.sqrt()).abs() < 1e-6, "{m:?}");
    }

    #[test]
    fn a_turned_tile_is_misaligned_by_its_angle() {
        let turn = DMat2::from_angle(0.5);
        let m = joined([dvec2(0., 0.), dvec2(1., 0.), dvec2(1., 1.), dvec2(0., 1.)].map(|uv| turn * uv));
        assert!((m.comb_misalignment_deg.unwrap_or(0.0) - 0.5f64.to_degrees()).abs() < 1e-9, "{m:?}");
        assert!(m.angle_distortion.abs() < 1e-9, "{m:?}");
    }

    #[test]
    fn flips_and_collapses_are_counted() {
        let m = joined([dvec2(0., 0.), dvec2(1., 0.), dvec2(1., 1.), dvec2(2., 0.5)]);
        assert_eq!(m.flipped_triangles, 1, "{m:?}");
        let m = joined([dvec2(0., 0.), dvec2(1., 0.), dvec2(1., 1.), dvec2(0.5, 0.5)]);
        assert!((m.collapsed_area - 0.5).abs() < 1e-6, "{m:?}");
    }

    #[test]
    fn a_cut_is_a_seam_unless_it_is_a_whole_tile() {
        let cut = |shift: f64| {
            let s = dvec2(shift, 0.0);
            measured([[dvec2(0., 0.), dvec2(1., 0.), dvec2(1., 1.)], [s, dvec2(1., 1.) + s, dvec2(0., 1.) + s]])
        };
        let whole = cut(2.0);
        assert_eq!((whole.patches, whole.seam_length_ratio), (1, 0.0));
        let half = cut(0.5);
        assert_eq!(half.patches, 2);
        assert!((half.seam_length_ratio - 2f64.sqrt()).abs() < 1e-6);
    }
}
