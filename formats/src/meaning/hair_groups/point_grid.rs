//! Nearest-neighbour search among points.

use glam::{IVec3, Vec3};
use std::collections::HashMap;

/// Points sorted into the cells of a grid.
#[derive(Clone, Debug, Default)]
pub struct PointGrid {
    points: Vec<Vec3>,
    low: Vec3,
    cell_m: f32,
    /// Number of cells along each axis.
    size: IVec3,
    cells: HashMap<IVec3, Vec<u32>>,
}

impl PointGrid {
    /// Sorts points into a grid. The points must be finite.
    pub fn new(points: Vec<Vec3>) -> Self {
        let (low, high) = points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
        let extent = (high - low).max_element().max(f32::MIN_POSITIVE);
        // Hair points lie on a surface. The cell size is chosen so that each cell on the surface holds about two of
        // them.
        let cell_m = extent / (points.len() as f32 / 2.0).sqrt().clamp(1.0, 512.0);
        let mut out = Self { points, low, cell_m, ..Self::default() };
        for (index, point) in out.points.iter().enumerate() {
            out.cells.entry(out.cell(*point)).or_default().push(index as u32);
        }
        out.size = out.cells.keys().fold(IVec3::ZERO, |size, cell| size.max(*cell + 1));
        out
    }

    fn cell(&self, at: Vec3) -> IVec3 {
        ((at - self.low) / self.cell_m).floor().as_ivec3()
    }

    /// Returns the `N` nearest points with their squared distances, nearest first. Points at equal distance are ordered
    /// by index. If there are fewer points, the remaining distances are infinite.
    pub fn nearest<const N: usize>(&self, at: Vec3) -> [(f32, u32); N] {
        let mut near = [(f32::INFINITY, 0u32); N];
        // If `at` is outside the grid, the search begins at the border.
        let middle = self.cell(at).clamp(IVec3::ZERO, (self.size - 1).max(IVec3::ZERO));
        let outside = at.distance(at.clamp(self.low, self.low + self.cell_m * self.size.as_vec3()));
        for ring in 0..=self.size.max_element() {
            // Lower bound of the distance from `at` to the points in the ring.
            let least = self.cell_m * (ring - 1) as f32 - outside;
            if least > 0.0 && least * least > near[N - 1].0 {
                break;
            }
            for cell in ring_of(middle, ring) {
                for index in self.cells.get(&cell).into_iter().flatten() {
                    let found = (self.points[*index as usize].distance_squared(at), *index);
                    if found < near[N - 1] {
                        let place = near.partition_point(|other| *other <= found);
                        near[place..].rotate_right(1);
                        near[place] = found;
                    }
                }
            }
        }
        near
    }
}

/// Returns the cells whose Chebyshev distance to `middle` is `ring`.
fn ring_of(middle: IVec3, ring: i32) -> impl Iterator<Item = IVec3> {
    let side = -ring..=ring;
    side.clone().flat_map(move |x| side.clone().map(move |y| (x, y))).flat_map(move |(x, y)| {
        // In a column along z that is inside the ring's outline in x and y, only the two end cells belong to the ring.
        let step = if x.abs() == ring || y.abs() == ring || ring == 0 { 1 } else { 2 * ring };
        (-ring..=ring).step_by(step as usize).map(move |z| middle + IVec3::new(x, y, z))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_points_agree_with_an_exhaustive_search() {
        // A wavy sheet of points, with queries on it, beside it and far from it.
        let points: Vec<Vec3> = (0..900)
            .map(|i| {
                let (x, z) = ((i % 30) as f32, (i / 30) as f32);
                Vec3::new(x + 0.3 * (z * 1.7).sin(), 2.0 * (x * 0.3).sin(), z + 0.3 * (x * 2.3).sin())
            })
            .collect();
        let near = PointGrid::new(points.clone());
        for at in [Vec3::new(14.2, 0.5, 3.3), Vec3::new(-3.0, 4.0, 31.0), Vec3::splat(200.0), points[77]] {
            let mut all: Vec<(f32, u32)> = points.iter().zip(0..).map(|(p, i)| (p.distance_squared(at), i)).collect();
            all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            assert_eq!(near.nearest::<6>(at).as_slice(), &all[..6], "{at}");
        }
    }

    #[test]
    fn missing_neighbours_are_infinitely_far() {
        assert_eq!(PointGrid::new(Vec::new()).nearest::<2>(Vec3::ONE), [(f32::INFINITY, 0); 2]);
        let one = PointGrid::new(vec![Vec3::X; 2]).nearest::<3>(Vec3::ZERO);
        assert_eq!((one[0], one[1], one[2].0), ((1.0, 0), (1.0, 1), f32::INFINITY));
    }
}
