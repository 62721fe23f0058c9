//! Square texture into which triangles are painted. They are extended past their borders.

use super::charts::{barycentric, bounds};
use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;

/// Triangle in the plane of a canvas.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CanvasTriangle {
    /// Index of the triangle in the mesh. Several canvas triangles may show the same one.
    pub(crate) triangle: u32,
    /// Corners, texels.
    pub(crate) corners: [Vec2; 3],
}

/// Point of a triangle that a texel shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfacePoint {
    /// Index of the triangle in the mesh.
    pub(crate) triangle: usize,
    /// Barycentric coordinates. In gutters, at least one of them is below 0.
    pub(crate) weights: Vec3,
}

impl SurfacePoint {
    /// Returns the point clamped to the triangle, because the plane of a sliver soon leads far away from the surface.
    pub(crate) fn clamped(self) -> Self {
        let weights = self.weights.max(Vec3::ZERO);
        Self { weights: weights / weights.element_sum().max(f32::MIN_POSITIVE), ..self }
    }
}

/// Square texture in which each texel records the triangle that it shows.
#[derive(Clone, Debug)]
pub(crate) struct Canvas {
    /// Width and height, texels.
    side: u32,
    pieces: Vec<CanvasTriangle>,
    /// Index of the canvas triangle that each texel shows, `u32::MAX` for none.
    owner: Vec<u32>,
}

impl Canvas {
    /// Creates a canvas with `side` texels in width and height, and assigns its texels to the triangles `pieces`. If
    /// several triangles cover a texel, the first wins. Each triangle is extended past its border, over up to `gutter`
    /// free texels.
    pub(crate) fn new(side: u32, pieces: Vec<CanvasTriangle>, gutter: u32) -> Self {
        let owner = vec![u32::MAX; side as usize * side as usize];
        let mut canvas = Self { side, pieces, owner };
        (0..canvas.pieces.len()).for_each(|piece| canvas.draw(piece));
        (0..gutter).for_each(|_| canvas.dilate());
        canvas
    }

    /// Assigns the texels whose centres a triangle covers.
    fn draw(&mut self, piece: usize) {
        let corners = self.pieces[piece].corners;
        let (min, max) = bounds(&corners);
        let last = i64::from(self.side) - 1;
        let range = |a: f32, b: f32| (a.floor() as i64).clamp(0, last)..=(b.ceil() as i64).clamp(0, last);
        for (y, x) in range(min.y, max.y).flat_map(|y| range(min.x, max.x).map(move |x| (y, x))) {
            let inside = barycentric(&corners, Vec2::new(x as f32 + 0.5, y as f32 + 0.5))
                .is_some_and(|w| w.min_element() >= -1e-4);
            let owner = &mut self.owner[(y * (last + 1) + x) as usize];
            if inside && *owner == u32::MAX {
                *owner = piece as u32;
            }
        }
    }

    /// Extends triangles to free neighbouring texels.
    fn dilate(&mut self) {
        let n = self.side as usize;
        let before = self.owner.clone();
        self.owner.par_chunks_mut(n).enumerate().for_each(|(y, row)| {
            for (x, owner) in row.iter_mut().enumerate().filter(|(_, o)| **o == u32::MAX) {
                // Direct neighbours come first, because they are nearer than diagonal ones.
                let steps = [(0, -1), (-1, 0), (1, 0), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)];
                let at = |(dx, dy): (isize, isize)| {
                    let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
                    (x < n && y < n).then(|| before[y * n + x]).filter(|t| *t != u32::MAX)
                };
                if let Some(found) = steps.into_iter().find_map(at) {
                    *owner = found;
                }
            }
        });
    }

    /// Paints the texture. `color` returns the value at a point. Its second argument is the size of the texel there:
    /// the change of the barycentric coordinates over one texel to the right and one texel down.
    ///
    /// Texels without a triangle get the mean of all others, so that the coarsest mips keep the colour.
    pub(crate) fn paint(&self, color: impl Fn(SurfacePoint, [Vec3; 2]) -> Vec4 + Sync) -> Vec<Vec4> {
        let n = self.side as usize;
        let texel = |(i, owner): (usize, &u32)| {
            let CanvasTriangle { triangle, corners } = self.pieces.get(*owner as usize)?;
            let center = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5);
            let weights = barycentric(corners, center)?;
            let step = |d: Vec2| barycentric(corners, center + d).map_or(Vec3::ZERO, |w| w - weights);
            Some(color(SurfacePoint { triangle: *triangle as usize, weights }, [step(Vec2::X), step(Vec2::Y)]))
        };
        let painted: Vec<Option<Vec4>> = self.owner.par_iter().enumerate().map(texel).collect();
        let (sum, count) = painted.iter().flatten().fold((Vec4::ZERO, 0.0), |(sum, n), c| (sum + *c, n + 1.0f32));
        let mean = sum / count.max(1.0);
        painted.into_iter().map(|c| c.unwrap_or(mean)).collect()
    }
}
