//! Tests of parameterizations that fail in naive form but not in ours: the rows "surface" and "solver" of the stability
//! table.
//!
//! The inputs of both forms are in `pelage_lab::stability`. `rows.rs` checks that our form stays within its bound and
//! that the naive form fails. This module tests additional requirements.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::{DVec3, Mat4, Quat, Vec2, Vec3, vec3};
use pelage_bake::recipe::{Coat, Recipe};
use pelage_bake::stages::surface::{Comb, CombMark, PatchParams, Source, Surface, SurfaceParams, parameterize};
use pelage_import::mesh::Model;
use pelage_lab::stability::surface::{
    broken_gradients, flips_of_one_chart, grid, lost_half_edges, model, parameterize_default, sphere, torus,
};

fn params(tile_size_m: f32) -> SurfaceParams {
    SurfaceParams::from_recipe(&Recipe::of_coat(Coat::Natural).unwrap().surface, tile_size_m, vec![true])
}

fn surface(model: &Model, tile_size_m: f32) -> Surface {
    parameterize_default(model, tile_size_m).unwrap()
}

fn merged(models: &[Model]) -> Model {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for m in models {
        let first = positions.len() as u32;
        positions.extend(&m.mesh.positions);
        triangles.extend(m.mesh.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    model(positions, triangles)
}

fn moved(mut model: Model, by: Vec3) -> Model {
    model.mesh.positions.iter_mut().for_each(|p| *p += by);
    model
}

/// Asserts that every triangle has positive area in the tile, and that `triangles` triangles remain.
fn assert_valid(surface: &Surface, triangles: usize, what: &str) {
    let m = &surface.measures;
    assert_eq!(
        (m.flipped_triangles, surface.mesh.triangles.len()),
        (0, triangles),
        "{what}: {m:?} {:?}",
        surface.warnings
    );
    for t in &surface.mesh.triangles {
        let [a, b, c] = t.map(|v| surface.tile_uvs[v as usize].as_dvec2());
        assert!((b - a).perp_dot(c - a) > 0.0, "{what}: {t:?} is {a} {b} {c}");
    }
    assert_eq!(m.collapsed_area, 0.0, "{what}");
}

mod soundness {
    //! Tests of meshes that are closed, broken, or both.

    use super::*;

    fn assert_warns(surface: &Surface, words: &str) {
        assert!(surface.warnings.iter().any(|w| w.contains(words)), "{words:?} in {:?}", surface.warnings);
    }

    #[test]
    fn closed_surfaces_of_any_genus_are_covered_without_flips() {
        for (what, m, euler) in [("sphere", sphere(24, 48), 2), ("torus", torus(), 0)] {
            let s = surface(&m, 0.3);
            assert_valid(&s, m.mesh.triangles.len(), what);
            assert!(s.warnings.is_empty(), "{what}: {:?}", s.warnings);
            // By the Poincaré–Hopf theorem, the indices of the singularities sum to the Euler characteristic.
            assert_eq!(
                s.singularities.iter().map(|(_, index)| index).sum::<i32>(),
                euler,
                "{what}: {:?}",
                s.singularities
            );
            assert!(flips_of_one_chart(&m) > m.mesh.triangles.len() / 4, "{what}");
        }
    }

    #[test]
    fn degenerate_and_duplicate_triangles_are_dropped_and_counted() {
        let mut m = torus();
        let whole = m.mesh.triangles.len();
        m.mesh.triangles.extend([[0, 0, 1], [5, 6, 5]]);
        let twice = m.mesh.triangles[10];
        m.mesh.triangles.extend([twice, [twice[1], twice[2], twice[0]]]);
        // The triangle is degenerate: its corners are collinear.
        let middle = (m.mesh.positions[0] + m.mesh.positions[1]) / 2.0;
        m.mesh.positions.push(middle);
        m.mesh.normals.push(Vec3::Y);
        m.mesh.uvs.push(Vec2::ZERO);
        m.mesh.colors.push([255; 4]);
        m.mesh.triangles.push([0, 1, m.mesh.positions.len() as u32 - 1]);
        m.mesh.parts[0].triangle_count = m.mesh.triangles.len();
        let s = surface(&m, 0.3);
        assert_valid(&s, whole, "torus");
        assert_warns(&s, "3 triangles without area dropped, 2 duplicate triangles dropped");
        assert_warns(&s, "component 1 of 1 (mesh 0");
        assert_eq!(s.mesh.parts[0].triangle_count, whole);
        assert!(broken_gradients(&m) >= 2 && lost_half_edges(&m) >= 2);
    }

    #[test]
    fn an_edge_of_three_triangles_is_split() {
        // Two squares form a sheet, and a third is attached to their common edge.
        let positions = vec![
            vec3(0., 0., 0.),
            vec3(0., 0., 1.),
            vec3(1., 0., 0.),
            vec3(1., 0., 1.),
            vec3(-1., 0., 0.),
            vec3(-1., 0., 1.),
            vec3(0., 1., 0.),
            vec3(0., 1., 1.),
        ];
        let quad = |a, b, c, d| [[a, b, c], [a, c, d]];
        let triangles = [quad(0, 1, 3, 2), quad(4, 5, 1, 0), quad(6, 7, 1, 0)].concat();
        let m = model(positions, triangles);
        let s = surface(&m, 0.3);
        assert_valid(&s, 6, "book");
        assert_warns(&s, "1 edges with more than two triangles split");
        // The two coplanar squares must be in the same patch.
        let patch = |t: usize| s.patch_of_triangle[t];
        assert_eq!(patch(0), patch(2), "{:?}", s.patch_of_triangle);
        assert_ne!(patch(0), patch(4));
        assert!(lost_half_edges(&m) > 0);
    }

    #[test]
    fn inconsistent_windings_and_normals_are_corrected() {
        let mut m = sphere(12, 24);
        for t in m.mesh.triangles.iter_mut().step_by(7) {
            t.swap(1, 2);
        }
        let turned = m.mesh.triangles.len().div_ceil(7);
        let s = surface(&m, 0.3);
        assert_valid(&s, m.mesh.triangles.len(), "sphere");
        assert_warns(&s, &format!("{turned} inconsistently wound triangles flipped"));
        for t in &s.mesh.triangles {
            let [a, b, c] = t.map(|v| s.mesh.positions[v as usize]);
            let n = (b - a).cross(c - a);
            assert!(n.dot(a) > 0.0);
            assert!(t.iter().all(|v| s.mesh.normals[*v as usize].dot(n) > 0.0));
        }
        assert!(lost_half_edges(&m) >= turned);
    }

    #[test]
    fn moebius_strip_is_cut() {
        let n = 40;
        let mut positions = Vec::new();
        for k in 0..n {
            let a = std::f32::consts::TAU * k as f32 / n as f32;
            let across = Quat::from_rotation_y(a) * Quat::from_rotation_z(a / 2.0) * vec3(0.0, 0.2, 0.0);
            let middle = Quat::from_rotation_y(a) * Vec3::X;
            positions.extend([middle - across, middle + across]);
        }
        let at = |k: u32, side: u32| if k < n { 2 * k + side } else { 2 * (k - n) + 1 - side };
        let quad = |k| [[at(k, 0), at(k + 1, 0), at(k + 1, 1)], [at(k, 0), at(k + 1, 1), at(k, 1)]];
        let m = model(positions, (0..n).flat_map(quad).collect());
        let s = surface(&m, 0.3);
        assert_valid(&s, 2 * n as usize, "Möbius strip");
        assert_warns(&s, "cut because no winding suits both sides");
    }

    #[test]
    fn single_triangles_components_and_holes_are_handled() {
        let one = model(vec![Vec3::ZERO, Vec3::X, Vec3::Z], vec![[0, 2, 1]]);
        assert_valid(&surface(&one, 0.3), 1, "triangle");
        let mut holes = torus();
        holes.mesh.triangles.retain(|t| !t[0].is_multiple_of(5));
        let left = holes.mesh.triangles.len();
        let mut many = merged(&[holes, moved(sphere(12, 24), vec3(3.0, 0.0, 0.0)), moved(one, vec3(-3.0, 0.0, 0.0))]);
        // No triangle uses this vertex.
        many.mesh.positions.push(Vec3::splat(f32::MAX));
        many.mesh.normals.push(Vec3::Y);
        many.mesh.uvs.push(Vec2::ZERO);
        many.mesh.colors.push([255; 4]);
        let s = surface(&many, 0.3);
        assert_valid(&s, left + 24 * 2 * 11 + 1, "several");
        assert_warns(&s, "1 vertices belong to no triangle and were removed");
    }

    #[test]
    fn repairs_are_reported_per_component_up_to_a_limit() {
        let piece = |k: usize| {
            let mut m = moved(sphere(6, 8), vec3(3.0 * k as f32, 0.0, 0.0));
            m.mesh.triangles.push(m.mesh.triangles[0]);
            m
        };
        let s = surface(&merged(&(0..12).map(piece).collect::<Vec<_>>()), 0.5);
        assert_warns(&s, "component 3 of 12 (mesh 0");
        assert_warns(&s, "4 more components");
        assert_eq!(s.warnings.len(), 9, "{:?}", s.warnings);
    }
}

mod solver {
    //! Tests of slivers, which make the equations nearly singular.

    use super::*;
    use pelage_lab::stability::solver::{LEAST, slivers};

    #[test]
    fn slivers_neither_flip_nor_distort_their_neighbours() {
        for least in LEAST {
            let m = slivers(least);
            let s = surface(&m, 0.5);
            let left = s.mesh.triangles.len();
            assert!(left > 900, "{least}: {left}");
            assert_valid(&s, left, &format!("slivers down to {least}"));
            assert!(
                s.measures.angle_distortion < 0.01 && s.measures.area_distortion < 0.01,
                "{least}: {:?}",
                s.measures
            );
        }
    }
}

mod modes {
    //! Tests of the guarantees for the stage's parameters, on surfaces with a known result.

    use super::*;

    #[test]
    fn developable_surfaces_are_laid_flat_without_distortion() {
        let cylinder = {
            let mut m = grid(32, 200, |b, a| vec3(0.5 * a.cos(), 0.0, 0.5 * a.sin()) + Vec3::Y * (b * 0.5));
            // The grid is closed in both directions, so an open cylinder is cut out of it.
            m.mesh.triangles.retain(|t| t.iter().all(|v| *v >= 200) || t.iter().all(|v| *v < 31 * 200));
            m.mesh.parts[0].triangle_count = m.mesh.triangles.len();
            m
        };
        let p = SurfaceParams { comb: Comb::Gravity, ..params(0.3) };
        let s = parameterize("test", &cylinder, &p).unwrap();
        let m = s.measures;
        // The polygon of 200 sides turns by 1.8° per side, which does not affect a comb along the axis.
        assert!(m.angle_distortion < 1e-9 && m.area_distortion < 1e-9, "{m:?}");
        assert!(m.comb_misalignment_deg.unwrap() < 1e-4 && m.flipped_triangles == 0, "{m:?}");
    }

    #[test]
    fn hair_follows_the_comb() {
        let m = torus();
        let s = surface(&m, 0.3);
        let comb = vec3(0.0, -0.35, -1.0);
        for (tangent, normal) in s.tangents.iter().zip(&s.mesh.normals) {
            let wish = comb.reject_from_normalized(*normal);
            let along_v = normal.cross(tangent.truncate()) * tangent.w;
            // Where the requested comb direction is strong, only smoothing changes it.
            if wish.length() > 0.9 * comb.length() {
                assert!(along_v.angle_between(wish) < 0.2, "{along_v} {wish}");
            }
        }
    }

    #[test]
    fn comb_marks_set_the_hair_direction_near_their_positions() {
        let mark = |name: &str, at: Vec3, direction: Vec3| CombMark {
            name: name.into(),
            places: vec![(at, direction)],
            reach_m: None,
        };
        let marks = vec![mark("front", vec3(0.0, 0.0, 1.0), Vec3::X), mark("back", vec3(0.0, 0.0, -1.0), Vec3::Y)];
        let p = SurfaceParams { comb: Comb::Marks { marks, elsewhere: Vec3::NEG_Z }, ..params(0.3) };
        let s = parameterize("test", &sphere(24, 48), &p).unwrap();
        assert_valid(&s, 48 * 2 * 23, "sphere");
        for (v, position) in s.mesh.positions.iter().enumerate() {
            let along_v = s.mesh.normals[v].cross(s.tangents[v].truncate());
            if position.z > 0.97 {
                assert!(along_v.dot(Vec3::X) > 0.9, "{position}: {along_v}");
            }
            if position.z < -0.97 {
                assert!(along_v.dot(Vec3::Y) > 0.9, "{position}: {along_v}");
            }
        }
    }

    #[test]
    fn without_a_comb_patches_distort_less() {
        let m = sphere(24, 48);
        let with = surface(&m, 0.3).measures;
        let without = parameterize("test", &m, &SurfaceParams { comb: Comb::None, ..params(0.3) }).unwrap();
        assert_valid(&without, m.mesh.triangles.len(), "sphere");
        assert_eq!((without.measures.comb_misalignment_deg, without.measures.singularities), (None, 0));
        assert!(without.measures.angle_distortion < with.angle_distortion, "{with:?} {:?}", without.measures);
    }

    #[test]
    fn larger_patches_have_fewer_seams() {
        let m = torus();
        let seams = |size: f32, stretch: f32| {
            let patches = PatchParams { size, stretch, ..PatchParams::default() };
            let p = SurfaceParams { source: Source::Patches(patches), ..params(0.3) };
            parameterize("test", &m, &p).unwrap().measures
        };
        let (small, large) = (seams(0.2, 1.02), seams(4.0, 2.0));
        assert!(large.seam_length_ratio < 0.5 * small.seam_length_ratio, "{small:?} {large:?}");
        assert!(
            large.patches < small.patches && large.angle_distortion > small.angle_distortion,
            "{small:?} {large:?}"
        );
    }

    #[test]
    fn denser_hair_has_smaller_tiles() {
        let m = sphere(24, 48);
        let n = m.mesh.positions.len();
        let area = |density: f32| -> f64 {
            let p = SurfaceParams { density: Some(vec![density; n]), ..params(0.3) };
            let s = parameterize("test", &m, &p).unwrap();
            let det = |t: &[u32; 3]| {
                let [a, b, c] = t.map(|v| s.tile_uvs[v as usize].as_dvec2());
                (b - a).perp_dot(c - a) / 2.0
            };
            s.mesh.triangles.iter().map(det).sum()
        };
        // Four times as many hairs require four times as many tiles.
        assert!((area(4.0) / area(1.0) - 4.0).abs() < 0.05, "{} {}", area(4.0), area(1.0));
        let tiles = 4.0 * std::f64::consts::PI / 0.09;
        assert!((area(1.0) / tiles - 1.0).abs() < 0.03, "{} for {tiles}", area(1.0));
    }

    #[test]
    fn vertices_are_split_only_where_sides_disagree() {
        let s = surface(&torus(), 0.3);
        let mut seen = std::collections::HashMap::new();
        for (t, patch) in s.mesh.triangles.iter().zip(&s.patch_of_triangle) {
            for v in t {
                assert_eq!(seen.entry(*v).or_insert(*patch), patch, "vertex {v} serves two patches");
            }
        }
        // There must be only one vertex per position and patch.
        let mut places = std::collections::HashSet::new();
        for (v, patch) in &seen {
            assert!(places.insert((s.input_vertex[*v as usize], *patch)), "vertex {v} duplicates another");
        }
    }

    #[test]
    fn surface_does_not_depend_on_thread_count() {
        let m = torus();
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| surface(&m, 0.1))
        };
        let (one, three) = (on(1), on(3));
        assert_eq!(one.tile_uvs, three.tile_uvs);
        assert_eq!((one.tangents, one.mesh), (three.tangents, three.mesh));
    }

    #[test]
    fn rotated_model_and_comb_give_the_same_parameterisation() {
        let m = torus();
        let turn = Mat4::from_quat(Quat::from_rotation_x(0.7) * Quat::from_rotation_z(-0.4));
        let mut turned = m.clone();
        turned.mesh.positions.iter_mut().for_each(|p| *p = turn.transform_point3(*p));
        turned.mesh.normals.iter_mut().for_each(|n| *n = turn.transform_vector3(*n));
        let comb = vec3(0.0, -0.35, -1.0);
        let p = SurfaceParams { comb: Comb::Direction(turn.transform_vector3(comb)), ..params(0.3) };
        let (a, b) = (surface(&m, 0.3).measures, parameterize("test", &turned, &p).unwrap().measures);
        assert!((a.angle_distortion - b.angle_distortion).abs() < 0.2 * a.angle_distortion, "{a:?} {b:?}");
        assert_eq!(a.singularities, b.singularities);
    }

    #[test]
    fn tile_has_its_size_on_the_torus() {
        // The mean scale, from the areas of tile and mesh surface, must be that of the recipe.
        let s = surface(&torus(), 0.3);
        let area = |p: [DVec3; 3]| (p[1] - p[0]).cross(p[2] - p[0]).length();
        let skin: f64 = s.mesh.triangles.iter().map(|t| area(t.map(|v| s.rest.positions[v as usize].as_dvec3()))).sum();
        let tile: f64 =
            s.mesh.triangles.iter().map(|t| area(t.map(|v| s.tile_uvs[v as usize].as_dvec2().extend(0.0)))).sum();
        assert!((tile * 0.09 / skin - 1.0).abs() < 0.03, "{tile} tiles on {skin}");
    }
}
