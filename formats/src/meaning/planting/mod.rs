//! Planting: roots of the tile's strands on a mesh, and positions of their points.
//!
//! A strand of the tile has a root wherever a copy of its root is inside a furred triangle ([`Roots`]). A walk over the
//! mesh gives the positions of its points ([`SurfaceWalk`]). Both use the mesh's tile coordinates. A point is stored as
//! a triangle and weights ([`WalkPosition`]), which give its position in any pose.

mod roots;
mod walk;

pub use roots::Roots;
pub use walk::{SurfaceWalk, WalkEvents, WalkPosition};

use crate::meaning::shown_vertices;
use crate::{AttributeVertex, FormatError, MeshView, Package, SkinVertex};
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::collections::HashMap;
use std::hash::Hash;

/// Mesh data for planting. All lists over vertices have the same length, and all lists over triangles.
#[derive(Clone, Debug, Default)]
pub struct PlantingMesh {
    /// Corners of each triangle, valid vertex indices.
    pub triangles: Vec<[u32; 3]>,
    /// Whether hair grows on each triangle.
    pub furred: Vec<bool>,
    /// Position of each vertex in any pose, metres.
    pub positions: Vec<DVec3>,
    /// Coordinates of each vertex in the hair tile; 1 is one tile.
    pub tile_uv: Vec<DVec2>,
    /// For each vertex, the index of the first vertex with the same position and motion. Several vertices share a
    /// position where patches, parts or seams meet.
    pub same_place: Vec<u32>,
}

/// Joints that move a vertex, and their weights; `None` for a mesh without a skeleton.
pub type MovedBy<J> = Option<(J, [f32; 4])>;

/// Returns, for each vertex, the index of the first vertex with bitwise the same position, joints and weights.
pub fn same_places<J: Eq + Hash>(vertices: impl Iterator<Item = ([f32; 3], MovedBy<J>)>) -> Vec<u32> {
    let mut first_at = HashMap::new();
    let keys = vertices.map(|(position, moved_by)| {
        (position.map(f32::to_bits), moved_by.map(|(joints, weights)| (joints, weights.map(f32::to_bits))))
    });
    keys.zip(0u32..).map(|(key, i)| *first_at.entry(key).or_insert(i)).collect()
}

impl PlantingMesh {
    /// Creates the planting data from a package's stored mesh.
    ///
    /// Fails with [`FormatError`] for a damaged section.
    pub fn of_package(package: &Package<'_>, mesh: &MeshView<'_>) -> Result<Self, FormatError> {
        let (manifest, geometry) = (package.manifest(), shown_vertices(package, mesh)?);
        let indices: Vec<u32> = mesh.indices().collect();
        let skin: Vec<SkinVertex> = mesh.skin().collect();
        let moved_by = |i: usize| skin.get(i).map(|v| (v.joints, v.weights));
        let furred = manifest.parts.iter().flat_map(|part| {
            let furred = manifest.materials[part.material as usize].furred;
            std::iter::repeat_n(furred, part.index_count as usize / 3)
        });
        Ok(Self {
            triangles: indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
            furred: furred.collect(),
            positions: geometry.iter().map(|v| Vec3::from(v.position).as_dvec3()).collect(),
            tile_uv: mesh.attributes().map(|v: AttributeVertex| Vec2::from(v.tile_uv).as_dvec2()).collect(),
            same_place: same_places(geometry.iter().enumerate().map(|(i, v)| (v.position, moved_by(i)))),
        })
    }

    /// Returns the values at a triangle's corners, from a list over vertices.
    pub fn corners<T: Copy>(&self, triangle: usize, of: &[T]) -> [T; 3] {
        self.triangles[triangle].map(|v| of[v as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Square of one metre and one tile, made of two triangles. The second triangle is in another patch, whose
    /// coordinates are `apart` tiles away.
    fn square(apart: f64) -> PlantingMesh {
        let at = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        PlantingMesh {
            triangles: vec![[0, 1, 2], [3, 4, 5]],
            furred: vec![true; 2],
            positions: at.iter().map(|(x, y)| DVec3::new(*x, *y, 0.0)).collect(),
            tile_uv: at.iter().enumerate().map(|(i, (x, y))| DVec2::new(x + apart * f64::from(i > 2), *y)).collect(),
            same_place: vec![0, 1, 2, 1, 4, 2],
        }
    }

    fn place(ground: &PlantingMesh, walk: &SurfaceWalk<'_>, at: &WalkPosition) -> DVec3 {
        let (weights, corners) = (walk.place_weights(at), ground.corners(at.triangle, &ground.positions));
        corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z
    }

    #[test]
    fn surface_walk_stays_straight_across_borders_and_past_the_mesh() {
        for apart in [0.0, 5.0] {
            let ground = square(apart);
            let walk = SurfaceWalk::new(&ground);
            let mut at = WalkPosition { triangle: 0, weights: DVec3::new(0.6, 0.2, 0.2), beyond: None };
            let mut crossed = WalkEvents::default();
            walk.step(&mut at, DVec2::new(0.5, 0.4), &mut crossed);
            assert_eq!((at.triangle, crossed.patch_border, crossed.mesh_border), (1, apart != 0.0, false));
            assert!(place(&ground, &walk, &at).distance(DVec3::new(0.7, 0.6, 0.0)) < 1e-12, "{at:?}");
            // Past the end, the walk continues in the last triangle's plane.
            walk.step(&mut at, DVec2::new(1.0, 0.0), &mut crossed);
            assert!(crossed.mesh_border && !crossed.lost && at.beyond.is_some());
            assert!(place(&ground, &walk, &at).distance(DVec3::new(1.7, 0.6, 0.0)) < 1e-12, "{at:?}");
        }
    }

    #[test]
    fn root_lies_in_one_triangle_per_tile() {
        // Roots on the edge between both triangles, and inside one of them. They are identified by index; whole tiles
        // in the coordinates do not matter.
        let roots = Roots::new([(DVec2::new(0.5, 0.5), 7), (DVec2::new(3.25, -0.75), 9)]);
        for ground in [square(0.0), square(2.0)] {
            let mut found = Vec::new();
            for triangle in 0..2 {
                let corners = ground.corners(triangle, &ground.tile_uv);
                roots.for_each_in(corners, |strand, weights| {
                    let place = corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z;
                    let shift = place - if strand == 7 { DVec2::splat(0.5) } else { DVec2::splat(0.25) };
                    assert!((shift - shift.round()).length() < 1e-12, "{strand} at {place}");
                    found.push(strand);
                });
            }
            found.sort_unstable();
            assert_eq!(found, [7, 9]);
        }
        let large = [DVec2::ZERO, DVec2::new(4.0, 0.0), DVec2::new(0.0, 4.0)];
        let mut count = [0; 10];
        roots.for_each_in(large, |strand, _| count[strand] += 1);
        // Expect strand 9 in six whole tiles below the diagonal and in the four tiles that the diagonal cuts. The root
        // of strand 7 is on the diagonal in cut tiles, where it belongs to one side only.
        assert!(count[9] == 10 && (6..=10).contains(&count[7]), "{count:?}");
    }
}
