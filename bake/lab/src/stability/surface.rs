//! Meshes on which parameterizations fail: closed meshes of any genus, edges with three triangles, and triangles
//! without area. The naive form keeps half-edges in a map, in which the third triangle of an edge overwrites another.
//! It divides gradients by the area, and uses one chart for the whole mesh.

use super::row::{Finding, Row};
use glam::{Quat, Vec2, Vec3, vec3};
use pelage_bake::recipe::{Coat, Recipe};
use pelage_bake::stages::surface::{Surface, SurfaceParams, parameterize};
use pelage_import::BakeError;
use pelage_import::mesh::{Material, Mesh, MeshPart, Model};
use std::collections::HashMap;

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "surface",
    cliff: "closed meshes of any genus, edges with three triangles, triangles without area",
    naive: "one chart, half-edges in a map, gradients divided by the area",
    safe: "repair and count defects, grow patches that are topological discs",
    drive,
};

/// Returns a furred model of the given triangles, with smooth normals and without texture coordinates.
pub fn model(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Model {
    let n = positions.len();
    let mut normals = vec![Vec3::ZERO; n];
    for t in &triangles {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        t.iter().for_each(|v| normals[*v as usize] += (b - a).cross(c - a));
    }
    let mesh = Mesh {
        normals: normals.into_iter().map(|n| n.normalize_or(Vec3::Y)).collect(),
        positions,
        uvs: vec![Vec2::ZERO; n],
        colors: vec![[255; 4]; n],
        parts: vec![MeshPart {
            source: "mesh 0".into(),
            names: Vec::new(),
            material: 0,
            first_triangle: 0,
            triangle_count: triangles.len(),
            has_uvs: false,
        }],
        triangles,
        ..Mesh::default()
    };
    let material = Material { name: "Coat".into(), ..Material::default() };
    Model { mesh, materials: vec![material], ..Model::default() }
}

/// Runs the `surface` stage with its defaults and tiles `tile_size_m` metres wide.
///
/// # Errors
///
/// Same as [`parameterize`].
pub fn parameterize_default(model: &Model, tile_size_m: f32) -> Result<Surface, BakeError> {
    // Limits patches to two tiles, so that there are many borders between them.
    let natural = Recipe::of_coat(Coat::Natural)?;
    let params = SurfaceParams::from_recipe(&natural.surface, tile_size_m, vec![true]);
    parameterize("stability", model, &params)
}

/// Returns a closed grid of `across` by `around` quads, wound outward. `place` maps grid coordinates to positions.
pub fn grid(across: u32, around: u32, place: impl Fn(f32, f32) -> Vec3) -> Model {
    let at = |i: u32, j: u32| (i % across) * around + j % around;
    let turn = |k: u32, n: u32| std::f32::consts::TAU * k as f32 / n as f32;
    let positions = (0..across).flat_map(|i| (0..around).map(move |j| (i, j)));
    let positions = positions.map(|(i, j)| place(turn(i, across), turn(j, around))).collect();
    let quad = |i: u32, j: u32| {
        let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        [[a, b, c], [a, c, d]]
    };
    let triangles = (0..across).flat_map(|i| (0..around).flat_map(move |j| quad(i, j))).collect();
    model(positions, triangles)
}

/// Returns a torus of 2304 triangles.
pub fn torus() -> Model {
    grid(48, 24, |a, b| Quat::from_rotation_y(a) * vec3(1.0 + 0.4 * b.cos(), 0.4 * b.sin(), 0.0))
}

/// Returns a closed sphere without degenerate triangles; each pole is a single vertex.
pub fn sphere(rings: u32, sectors: u32) -> Model {
    let mut positions = vec![Vec3::Y, -Vec3::Y];
    let at = |ring: u32, k: u32| 2 + (ring - 1) * sectors + k % sectors;
    for ring in 1..rings {
        for k in 0..sectors {
            let (a, b) =
                (std::f32::consts::PI * ring as f32 / rings as f32, std::f32::consts::TAU * k as f32 / sectors as f32);
            positions.push(vec3(a.sin() * b.sin(), a.cos(), a.sin() * b.cos()));
        }
    }
    let mut triangles = Vec::new();
    for k in 0..sectors {
        triangles.extend([[0, at(1, k), at(1, k + 1)], [1, at(rings - 1, k + 1), at(rings - 1, k)]]);
        for ring in 1..rings - 1 {
            let (a, b, c, d) = (at(ring, k), at(ring + 1, k), at(ring + 1, k + 1), at(ring, k + 1));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    model(positions, triangles)
}

/// Counts the triangles that a projection along −z flips. Any single chart of a closed surface has some.
pub fn flips_of_one_chart(model: &Model) -> usize {
    let flat = |v: u32| model.mesh.positions[v as usize].truncate();
    let det = |t: &[u32; 3]| (flat(t[1]) - flat(t[0])).perp_dot(flat(t[2]) - flat(t[0]));
    model.mesh.triangles.iter().filter(|t| det(t) < 0.0).count()
}

/// Counts the half-edges that are lost in a map from vertex pairs to faces, because a later one overwrites an earlier
/// one.
pub fn lost_half_edges(model: &Model) -> usize {
    let mut map = HashMap::new();
    for (f, t) in model.mesh.triangles.iter().enumerate() {
        for k in 0..3 {
            map.insert((t[k], t[(k + 1) % 3]), f);
        }
    }
    3 * model.mesh.triangles.len() - map.len()
}

/// Counts the triangles whose gradient of the first barycentric coordinate is not finite.
pub fn broken_gradients(model: &Model) -> usize {
    let gradient = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| model.mesh.positions[v as usize]);
        let n = (b - a).cross(c - a);
        (n / n.length()).cross(c - b) / n.length()
    };
    model.mesh.triangles.iter().filter(|t| !gradient(t).is_finite()).count()
}

/// Counts the triangles that are flipped or have no area in the tile.
pub fn not_positive(surface: &Surface) -> usize {
    let det = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| surface.tile_uvs[v as usize].as_dvec2());
        (b - a).perp_dot(c - a)
    };
    // NaN does not count as a positive area.
    surface.mesh.triangles.iter().filter(|t| det(t).is_nan() || det(t) <= 0.0).count()
}

/// Returns `model` with three defects: a duplicate triangle, a triangle without area, and a third triangle on an edge.
fn broken(mut model: Model) -> Model {
    let [a, b, c] = model.mesh.triangles[10];
    let outside = (model.mesh.positions[a as usize] + model.mesh.positions[b as usize]) * 0.75;
    model.mesh.positions.push(outside);
    model.mesh.normals.push(Vec3::Y);
    model.mesh.uvs.push(Vec2::ZERO);
    model.mesh.colors.push([255; 4]);
    let last = model.mesh.positions.len() as u32 - 1;
    model.mesh.triangles.extend([[b, c, a], [a, a, b], [a, b, last]]);
    model.mesh.parts[0].triangle_count = model.mesh.triangles.len();
    model
}

fn drive() -> Result<Vec<Finding>, BakeError> {
    let mut out = Vec::new();
    for (case, model) in [("a sphere", sphere(24, 48)), ("a torus", torus())] {
        out.push(Finding {
            case: case.into(),
            measure: "triangles flipped or without area in the tile",
            naive: flips_of_one_chart(&model) as f64,
            safe: not_positive(&parameterize_default(&model, 0.3)?) as f64,
            bound: 0.0,
            fails_above: model.mesh.triangles.len() as f64 / 4.0,
        });
        let model = broken(model);
        out.push(Finding {
            case: format!("{case} with a duplicate triangle, a triangle without area and an edge with three triangles"),
            measure: "lost half-edges plus non-finite gradients; ours: triangles flipped or without area",
            naive: (lost_half_edges(&model) + broken_gradients(&model)) as f64,
            safe: not_positive(&parameterize_default(&model, 0.3)?) as f64,
            bound: 0.0,
            fails_above: 3.0,
        });
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns six times the volume that the triangles enclose; negative if they are wound inward.
    fn volume(model: &Model) -> f32 {
        let m = &model.mesh;
        let of = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| m.positions[v as usize]);
            a.cross(b).dot(c)
        };
        m.triangles.iter().map(of).sum()
    }

    #[test]
    fn closed_meshes_are_wound_outward() {
        // Volumes of the smooth surfaces are 4 pi / 3 and 2 pi^2 R r^2.
        for (model, true_volume) in [(sphere(24, 48), 4.18879), (torus(), 3.15827)] {
            let found = volume(&model) / 6.0;
            assert!((0.95..1.0).contains(&(found / true_volume)), "{found} of {true_volume}");
        }
    }
}
