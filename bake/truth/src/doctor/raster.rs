//! Software rasteriser that counts the pixels covered by triangles, and the layers on each pixel; needs no GPU.

use glam::{Vec2, Vec4};

/// Side of the blocks that software rasterisers shade as a whole, pixels.
pub const BLOCK: u32 = 4;

/// Coverage of a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PixelCounts {
    /// Covered pixel centres, counted once per triangle.
    pub pixels: u64,
    /// Pixels in touched blocks of [`BLOCK`]² pixels, counted once per triangle, whether hidden or visible. Blocks are
    /// shaded before the depth test wherever shaders may discard.
    pub in_blocks: u64,
}

/// A depth buffer with a layer count per pixel.
#[derive(Clone, Debug)]
pub struct Raster {
    width: u32,
    height: u32,
    /// Depth of the nearest opaque surface, as 1 / w: a larger number is nearer, 0 means no surface.
    nearest: Vec<f32>,
    layers: Vec<u16>,
}

/// Drawing mode of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrawMode {
    /// Opaque: hides surfaces behind it.
    Opaque,
    /// Translucent: tested against opaque surfaces, occludes nothing, counts as a layer.
    Layer,
    /// Same as [`Self::Layer`], but two-sided and not counted as a layer.
    Quad,
}

impl Raster {
    /// Returns an empty buffer.
    pub fn new(width: u32, height: u32) -> Self {
        let count = width as usize * height as usize;
        Self { width, height, nearest: vec![0.0; count], layers: vec![0; count] }
    }

    /// Draws a triangle given in clip space, counter-clockwise as seen from its front. Skips the triangle if a corner
    /// is behind the eye.
    pub fn draw(&mut self, corners: [Vec4; 3], both_sides: bool, how: DrawMode) -> PixelCounts {
        let mut covered = PixelCounts::default();
        if corners.iter().any(|c| c.w <= 0.0 || !c.is_finite()) {
            return covered;
        }
        let size = Vec2::new(self.width as f32, self.height as f32);
        // Rows are counted from the top.
        let pixel = |c: Vec4| Vec2::new(0.5 + 0.5 * c.x / c.w, 0.5 - 0.5 * c.y / c.w) * size;
        let [mut a, b, mut c] = corners.map(pixel);
        let mut depth = corners.map(|c| 1.0 / c.w);
        // With rows from the top, front faces are clockwise and have negative area.
        let mut area = (b - a).perp_dot(c - a);
        if area > 0.0 && (both_sides || how == DrawMode::Quad) {
            std::mem::swap(&mut a, &mut c);
            depth.swap(0, 2);
            area = -area;
        }
        if area.is_nan() || area >= 0.0 {
            return covered;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let first = low.max(Vec2::ZERO).floor().as_uvec2() / BLOCK * BLOCK;
        let last = high.min(size).ceil().max(Vec2::ZERO).as_uvec2();
        let edges = [(b, c), (c, a), (a, b)];
        for by in (first.y..last.y).step_by(BLOCK as usize) {
            for bx in (first.x..last.x).step_by(BLOCK as usize) {
                let mut touched = false;
                for (x, y) in (0..BLOCK * BLOCK).map(|i| (bx + i % BLOCK, by + i / BLOCK)) {
                    if x >= self.width || y >= self.height {
                        continue;
                    }
                    let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                    let weights = edges.map(|(from, to)| (to - from).perp_dot(p - from) / area);
                    let inside = weights
                        .iter()
                        .zip(edges)
                        .all(|(w, (from, to))| *w > 0.0 || (*w == 0.0 && is_top_left(from, to)));
                    if !inside {
                        continue;
                    }
                    touched = true;
                    let at = (y * self.width + x) as usize;
                    let z = weights.iter().zip(depth).map(|(w, d)| w * d).sum::<f32>();
                    if z < self.nearest[at] {
                        continue;
                    }
                    covered.pixels += 1;
                    match how {
                        DrawMode::Opaque => self.nearest[at] = z,
                        DrawMode::Layer => self.layers[at] = self.layers[at].saturating_add(1),
                        DrawMode::Quad => {}
                    }
                }
                if touched {
                    covered.in_blocks += u64::from(BLOCK * BLOCK);
                }
            }
        }
        covered
    }

    /// Returns the number of pixels covered by opaque surfaces.
    pub fn opaque_pixels(&self) -> u64 {
        self.nearest.iter().filter(|z| **z > 0.0).count() as u64
    }

    /// Returns the number of pixels with at least one layer, and the mean and largest number of layers on those.
    pub fn layers(&self) -> (u64, f64, u16) {
        let furry = || self.layers.iter().filter(|n| **n > 0);
        let count = furry().count() as u64;
        let sum: u64 = furry().map(|n| u64::from(*n)).sum();
        (count, sum as f64 / count.max(1) as f64, furry().copied().max().unwrap_or(0))
    }
}

/// Returns whether points on this edge belong to the triangle, so that pixels on shared edges are drawn once.
fn is_top_left(from: Vec2, to: Vec2) -> bool {
    let way = to - from;
    way.y > 0.0 || (way.y == 0.0 && way.x < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(x: f32, y: f32, w: f32) -> Vec4 {
        Vec4::new(x * w, y * w, 0.0, w)
    }

    /// Draws a rectangle with half sides x and y, as two triangles that face the eye.
    fn square(raster: &mut Raster, x: f32, y: f32, w: f32, how: DrawMode) -> PixelCounts {
        let [a, b, c, d] = [(-x, -y), (x, -y), (x, y), (-x, y)].map(|(x, y)| corner(x, y, w));
        let (one, two) = (raster.draw([a, b, c], false, how), raster.draw([a, c, d], false, how));
        PixelCounts { pixels: one.pixels + two.pixels, in_blocks: one.in_blocks + two.in_blocks }
    }

    #[test]
    fn pixels_on_shared_edges_are_counted_once() {
        let mut raster = Raster::new(64, 32);
        assert_eq!(
            square(&mut raster, 1.0, 1.0, 1.0, DrawMode::Opaque).pixels,
            64 * 32,
            "shared edges must be drawn once"
        );
        assert_eq!(raster.opaque_pixels(), 64 * 32);
        // The rectangle covers half of each side of the picture and is aligned to whole pixels.
        let mut raster = Raster::new(64, 32);
        let half = square(&mut raster, 0.5, 0.5, 3.0, DrawMode::Layer);
        assert_eq!((half.pixels, raster.layers()), (32 * 16, (32 * 16, 1.0, 1)));
        // Blocks along the diagonal are counted for both triangles.
        assert!(half.in_blocks > half.pixels && half.in_blocks < 2 * half.pixels, "{half:?}");
    }

    #[test]
    fn hidden_and_back_facing_triangles_are_not_counted() {
        let mut raster = Raster::new(32, 32);
        square(&mut raster, 0.5, 1.0, 1.0, DrawMode::Opaque);
        assert_eq!(
            square(&mut raster, 1.0, 1.0, 2.0, DrawMode::Layer).pixels,
            16 * 32,
            "half of it is behind the opaque surface"
        );
        assert_eq!(
            square(&mut raster, 1.0, 1.0, 0.5, DrawMode::Layer).pixels,
            32 * 32,
            "all of it is in front of the opaque surface"
        );
        let (pixels, mean, most) = raster.layers();
        assert_eq!((pixels, most), (32 * 32, 2));
        assert!((mean - 1.5).abs() < 1e-9);
        let back = [corner(-1.0, -1.0, 0.4), corner(1.0, 1.0, 0.4), corner(1.0, -1.0, 0.4)];
        assert_eq!(raster.draw(back, false, DrawMode::Layer).pixels, 0);
        assert!(
            raster.draw(back, true, DrawMode::Layer).pixels > 400
                && raster.draw(back, false, DrawMode::Quad).pixels > 400
        );
        assert_eq!(raster.draw([Vec4::ONE, Vec4::X, Vec4::Y], true, DrawMode::Layer).pixels, 0, "behind the eye");
        assert_eq!(raster.draw([Vec4::NAN; 3], true, DrawMode::Layer).pixels, 0);
    }
}
