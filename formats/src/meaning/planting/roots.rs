//! Roots of the tile's strands, and lookup of those inside a triangle.

use glam::{DVec2, DVec3};

/// Roots of a tile, sorted into cells of a grid.
#[derive(Clone, Debug)]
pub struct Roots {
    side: usize,
    /// Position of each root within the tile, 0..1, and strand index; cell after cell.
    roots: Vec<(DVec2, u32)>,
    starts: Vec<usize>,
}

impl Roots {
    /// Sorts roots into the grid. Each is given as the tile coordinates of a strand's root and the strand's index.
    pub fn new(roots: impl IntoIterator<Item = (DVec2, u32)>) -> Self {
        let mut roots: Vec<(DVec2, u32)> = roots.into_iter().map(|(at, strand)| (at - at.floor(), strand)).collect();
        let side = ((roots.len() as f64 / 2.0).sqrt() as usize).clamp(1, 512);
        let cell = |(root, _): &(DVec2, u32)| {
            let along = |x: f64| ((x * side as f64) as usize).min(side - 1);
            along(root.y) * side + along(root.x)
        };
        roots.sort_by_key(cell);
        let starts = (0..=side * side).map(|k| roots.partition_point(|root| cell(root) < k)).collect();
        Self { side, roots, starts }
    }

    /// Calls `visit` for every strand, in every copy of the tile, whose root is inside a triangle of tile coordinates.
    /// Passes the strand index and the weights of the corners at the root. A root on the edge of adjacent triangles
    /// belongs to exactly one.
    pub fn for_each_in(&self, corners: [DVec2; 3], mut visit: impl FnMut(usize, DVec3)) {
        let (low, high) = corners.iter().fold((corners[0], corners[0]), |(l, h), c| (l.min(*c), h.max(*c)));
        let side = self.side as f64;
        let cells = |from: f64, to: f64| (from * side).floor() as i64 - 1..=(to * side).floor() as i64 + 1;
        for y in cells(low.y, high.y) {
            for x in cells(low.x, high.x) {
                let tile = DVec2::new(x.div_euclid(self.side as i64) as f64, y.div_euclid(self.side as i64) as f64);
                let cell =
                    y.rem_euclid(self.side as i64) as usize * self.side + x.rem_euclid(self.side as i64) as usize;
                for (root, strand) in &self.roots[self.starts[cell]..self.starts[cell + 1]] {
                    if let Some(weights) = weights_inside(corners, *root + tile) {
                        visit(*strand as usize, weights);
                    }
                }
            }
        }
    }
}

/// Returns the weights of the corners at point `p`, if it is inside the triangle or on one of the edges that belong to
/// it.
fn weights_inside(corners: [DVec2; 3], p: DVec2) -> Option<DVec3> {
    let [a, b, c] = corners;
    let turn = if (b - a).perp_dot(c - a) < 0.0 { -1.0 } else { 1.0 };
    let mut weights = DVec3::ZERO;
    for k in 0..3 {
        let (from, to) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
        let side = turn * side_of_edge(from, to, p);
        // An edge belongs to the triangle above it, or to the right of it if the edge is vertical.
        let way = (to - from) * turn;
        let own = way.x > 0.0 || (way.x == 0.0 && way.y < 0.0);
        if side < 0.0 || (side == 0.0 && !own) {
            return None;
        }
        weights[k] = side;
    }
    let sum = weights.element_sum();
    (sum > 0.0).then(|| weights / sum)
}

/// Returns twice the signed area of the triangle formed by an edge and a point. The order of operations is the same for
/// both directions of the edge, so that the triangles on both sides see the same rounding.
fn side_of_edge(from: DVec2, to: DVec2, p: DVec2) -> f64 {
    let forward = (from.x, from.y) <= (to.x, to.y);
    let (a, b) = if forward { (from, to) } else { (to, from) };
    let area = (b - a).perp_dot(p - a);
    if forward { area } else { -area }
}
