//! Share of the sky that models hide from the ground below them.

use glam::{Mat4, UVec2, Vec2, Vec3};
use pelage_formats::meaning::skin_matrix;
use pelage_formats::{Animation, ClipLayer, FormatError, Package, Pose, SkinVertex};
use std::sync::Arc;

/// Number of cells of the map in each direction.
pub(super) const CELLS: u32 = 64;
/// Maximum number of models whose contact is computed; the others hide nothing.
const MOST_MODELS: usize = 64;

/// Triangles of a model, for its shadow on the ground.
#[derive(Debug, Default)]
pub(super) struct GroundCaster {
    positions: Vec<Vec3>,
    skin: Vec<SkinVertex>,
    triangles: Vec<[u32; 3]>,
    animation: Option<Arc<Animation>>,
}

impl GroundCaster {
    pub(super) fn of(package: &Package<'_>) -> Result<Self, FormatError> {
        let Some(mesh) = package.mesh()? else { return Ok(Self::default()) };
        let indices: Vec<u32> = mesh.indices().collect();
        Ok(Self {
            positions: mesh.geometry().map(|vertex| vertex.position.into()).collect(),
            skin: mesh.skin().collect(),
            triangles: indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
            animation: package.animation()?,
        })
    }

    /// Returns the vertices in world space, in the pose of `layers`.
    fn posed(&self, transform: Mat4, layers: &[ClipLayer]) -> Vec<Vec3> {
        let mut pose = Pose::default();
        if let Some(animation) = &self.animation {
            pose.blend(animation, layers);
        }
        let place = |(i, position): (usize, &Vec3)| match self.skin.get(i) {
            Some(joints) => transform.transform_point3(skin_matrix(&pose, joints).transform_point3(*position)),
            None => transform.transform_point3(*position),
        };
        self.positions.iter().enumerate().map(place).collect()
    }
}

/// Map of the share of the sky's light that models hide from a level ground, seen from above.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ContactMap {
    /// Height of the ground: that of the lowest vertex, metres.
    pub height_m: f32,
    /// Height of the models above the ground, metres.
    pub models_m: f32,
    /// Corner of the map with the least x and z, metres.
    pub corner: Vec2,
    /// Width of the map, metres.
    pub width_m: f32,
    /// Hidden share of each cell, 0..=255; rows of equal z.
    pub hidden: Vec<u8>,
}

impl ContactMap {
    /// Computes the map of models, each with its transform and the layers of its pose. `None` without any vertex.
    pub(super) fn new<'a>(models: impl Iterator<Item = (&'a GroundCaster, Mat4, &'a [ClipLayer])>) -> Option<Self> {
        let models = models.take(MOST_MODELS);
        let posed: Vec<_> = models.map(|(model, at, layers)| (model, model.posed(at, layers))).collect();
        let mut points = posed.iter().flat_map(|(_, points)| points).copied().filter(|point| point.is_finite());
        let first = points.next()?;
        let (least, most) = points.fold((first, first), |(least, most), p| (least.min(p), most.max(p)));
        let (size, middle) = (most - least, 0.5 * (least + most));
        // Around the models, the map has a margin of their height. Beyond it, they hide less than a tenth.
        let width_m = (size.x.max(size.z) + 2.0 * size.y).max(1e-6);
        let corner = Vec2::new(middle.x, middle.z) - 0.5 * width_m;
        let mut above = Ceiling { cell_m: width_m / CELLS as f32, corner, height_m: vec![f32::INFINITY; AREA] };
        for (model, points) in &posed {
            for triangle in &model.triangles {
                above.add(triangle.map(|v| points[v as usize] - Vec3::new(0.0, least.y, 0.0)));
            }
        }
        let hidden = above.hidden().into_iter().map(|share| (255.0 * share + 0.5) as u8).collect();
        Some(Self { height_m: least.y, models_m: size.y, corner, width_m, hidden })
    }
}

const AREA: usize = (CELLS * CELLS) as usize;

/// Height of the lowest surface above each cell of the ground.
struct Ceiling {
    cell_m: f32,
    corner: Vec2,
    height_m: Vec<f32>,
}

impl Ceiling {
    /// Adds a triangle, sampled twice per cell.
    fn add(&mut self, [a, b, c]: [Vec3; 3]) {
        let longest = a.distance(b).max(a.distance(c)).max(b.distance(c));
        let steps = (2.0 * longest / self.cell_m).ceil().clamp(1.0, 4.0 * CELLS as f32) as u32;
        for i in 0..=steps {
            for j in 0..=steps - i {
                let [u, v] = [i, j].map(|k| k as f32 / steps as f32);
                let point = a + u * (b - a) + v * (c - a);
                let at = (Vec2::new(point.x, point.z) - self.corner) / self.cell_m;
                if at.is_finite() && at.cmpge(Vec2::ZERO).all() {
                    let UVec2 { x, y } = at.as_uvec2().min(UVec2::splat(CELLS - 1));
                    let height = &mut self.height_m[(y * CELLS + x) as usize];
                    *height = height.min(point.y);
                }
            }
        }
    }

    /// Returns the share of the light of a uniform sky that the ceiling hides from each cell: the sum of the form
    /// factors h² A / (π (d² + h²)²) of its level pieces, where A is the area of a cell, h the height and d the
    /// horizontal distance.
    fn hidden(&self) -> Vec<f32> {
        // In cells, with a minimum height that keeps the form factor of the nearest piece near 1.
        let height = |i: usize| (self.height_m[i] / self.cell_m).max(0.5);
        let pieces: Vec<_> =
            (0..AREA).filter(|i| self.height_m[*i].is_finite()).map(|i| (place(i), height(i).powi(2))).collect();
        let share = |i: usize| {
            let at = place(i);
            let factor = |(piece, h2): &(Vec2, f32)| h2 / (at.distance_squared(*piece) + h2).powi(2);
            pieces.iter().map(factor).sum::<f32>() / std::f32::consts::PI
        };
        (0..AREA).map(|i| share(i).min(1.0)).collect()
    }
}

/// Returns the column and row of a cell.
fn place(cell: usize) -> Vec2 {
    UVec2::new(cell as u32 % CELLS, cell as u32 / CELLS).as_vec2()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plate(half_m: f32, height_m: f32) -> GroundCaster {
        let corner = |x: f32, z: f32| Vec3::new(x * half_m, height_m, z * half_m);
        GroundCaster {
            positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0), Vec3::ZERO],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..GroundCaster::default()
        }
    }

    /// Checks the hidden share below the middle of a square plate against its form factor, and that a plate that moves
    /// with its transform moves its shadow.
    #[test]
    fn a_plate_hides_its_form_factor() {
        for (half_m, height_m) in [(1.0_f32, 1.0_f32), (2.0, 1.0), (1.0, 3.0)] {
            let model = plate(half_m, height_m);
            let at = Mat4::from_translation(Vec3::new(5.0, 2.0, -3.0));
            let map = ContactMap::new([(&model, at, &[][..])].into_iter()).expect("a plate has vertices");
            assert_eq!((map.height_m, map.models_m), (2.0, height_m));
            // Form factor from a point below the centre of a square: four times that of a quarter at its corner.
            let x = half_m / height_m;
            let slant = (1.0 + x * x).sqrt();
            let expected = 4.0 / std::f32::consts::PI * (x / slant) * (x / slant).atan();
            let cell = ((Vec2::new(5.0, -3.0) - map.corner) / map.width_m * CELLS as f32).as_uvec2();
            let found = f32::from(map.hidden[(cell.y * CELLS + cell.x) as usize]) / 255.0;
            assert!((found - expected).abs() < 0.06, "{half_m} {height_m}: {found}, expected {expected}");
            assert!(map.hidden[0] < 40, "{}", map.hidden[0]);
        }
        let none = GroundCaster::default();
        assert_eq!(ContactMap::new([(&none, Mat4::IDENTITY, &[][..])].into_iter()), None);
    }
}
