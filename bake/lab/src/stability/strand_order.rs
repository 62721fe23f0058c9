//! Order of strands: if strands are blended in the order in which they are stored, hidden strands are painted over
//! those in front of them.

use super::knot;
use super::row::{Finding, Row};
use glam::{Vec2, Vec3, vec2};
use pelage_bake::strands::{Curves, PosedMesh};
use pelage_import::BakeError;

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "order of strands",
    cliff: "a knot whose parts occlude each other, in strands thinner than pixels",
    naive: "strands at least a pixel wide, opacity scaled by width, blended in file order",
    safe: "opaque ribbons of true width with a depth test, four samples per pixel",
    drive,
};

/// Width and height of the picture, pixels.
const SIZE: u32 = 144;
/// Samples per pixel of the truth along each axis.
const TRUE_SAMPLES: u32 = 8;
/// Positions of the samples within a pixel in pelage's form: one in each row and each column of a 4 × 4 grid.
const SAMPLES: [Vec2; 4] = [vec2(0.375, 0.125), vec2(0.875, 0.375), vec2(0.125, 0.625), vec2(0.625, 0.875)];
/// Side of the squares whose means are compared, pixels.
const SQUARE: u32 = 4;
/// Brightness at the roots of the hair and on the mesh surface; at the tips it is 1.
const AT_ROOT: f32 = 0.15;

/// Point in the picture: position in pixels, and depth in metres, smaller if nearer.
#[derive(Clone, Copy)]
struct PicturePoint {
    px: Vec2,
    depth: f32,
}

/// Piece of a strand in the picture.
struct PicturePiece {
    ends: [PicturePoint; 2],
    half_px: f32,
    light: [f32; 2],
}

struct Scene {
    pieces: Vec<PicturePiece>,
    skin: Vec<[PicturePoint; 3]>,
}

impl Scene {
    fn new(curves: &Curves, skin: &PosedMesh) -> Self {
        let forward = -knot::TOWARDS_EYE;
        let right = forward.cross(Vec3::Y).normalize_or(Vec3::X);
        let up = right.cross(forward);
        let px_per_m = SIZE as f32 / knot::HEIGHT_M;
        let place = |p: Vec3| PicturePoint {
            px: 0.5 * SIZE as f32 + px_per_m * vec2(p.dot(right), -p.dot(up)),
            depth: p.dot(forward),
        };
        let mut pieces = Vec::new();
        for strand in 0..curves.len() {
            for ends in curves.strand(strand).windows(2) {
                pieces.push(PicturePiece {
                    ends: [place(ends[0].position_ws), place(ends[1].position_ws)],
                    half_px: 0.5 * (ends[0].radius_m + ends[1].radius_m) * px_per_m,
                    light: [ends[0].height, ends[1].height].map(|height| AT_ROOT + (1.0 - AT_ROOT) * height),
                });
            }
        }
        let corner = |v: u32| place(skin.vertices[v as usize].position_ws.as_vec3());
        Self { pieces, skin: skin.triangles.iter().map(|t| t.map(corner)).collect() }
    }

    /// Returns depth and brightness of the nearest surface at each sample of every pixel. The background has infinite
    /// depth and brightness 0.
    fn opaque(&self, at: &[Vec2], hair: bool) -> Vec<(f32, f32)> {
        let mut out = vec![(f32::INFINITY, 0.0); (SIZE * SIZE) as usize * at.len()];
        let mut put = |index: usize, depth: f32, light: f32| {
            if depth < out[index].0 {
                out[index] = (depth, light);
            }
        };
        for triangle in &self.skin {
            let ends = triangle.map(|p| p.px);
            for_samples(&ends, 0.0, at, |index, p| {
                if let Some(depth) = depth_in(triangle, p) {
                    put(index, depth, AT_ROOT);
                }
            });
        }
        for piece in self.pieces.iter().filter(|_| hair) {
            for_samples(&piece.ends.map(|p| p.px), piece.half_px, at, |index, p| {
                if let Some((depth, light)) = piece.at(p, piece.half_px) {
                    put(index, depth, light);
                }
            });
        }
        out
    }

    /// Returns the brightness of each pixel, averaged over its samples.
    fn resolved(&self, at: &[Vec2]) -> Vec<f32> {
        let samples = self.opaque(at, true);
        samples
            .chunks_exact(at.len())
            .map(|s| s.iter().map(|(_, light)| light).sum::<f32>() / at.len() as f32)
            .collect()
    }

    /// Returns the brightness of each pixel if strands are at least a pixel wide, with their opacity reduced in
    /// proportion to the widening. They are blended over the mesh surface in the order of the file.
    fn blended(&self) -> Vec<f32> {
        let middle = [Vec2::splat(0.5)];
        let mut out = self.opaque(&middle, false);
        for piece in &self.pieces {
            let half = piece.half_px.max(0.5);
            for_samples(&piece.ends.map(|p| p.px), half, &middle, |index, p| {
                if let Some((depth, light)) = piece.at(p, half)
                    && depth < out[index].0
                {
                    let below = out[index].1;
                    out[index].1 = below + (light - below) * (piece.half_px / half);
                }
            });
        }
        out.into_iter().map(|(_, light)| light).collect()
    }
}

impl PicturePiece {
    /// Returns depth and brightness at a position, or `None` if the piece with half width `half_px` does not cover it.
    fn at(&self, p: Vec2, half_px: f32) -> Option<(f32, f32)> {
        let [a, b] = self.ends;
        let along = b.px - a.px;
        let share = (p - a.px).dot(along) / along.length_squared().max(1e-12);
        let aside = (p - a.px - share * along).length();
        let mix = |from: f32, to: f32| from + (to - from) * share;
        ((0.0..1.0).contains(&share) && aside <= half_px)
            .then(|| (mix(a.depth, b.depth), mix(self.light[0], self.light[1])))
    }
}

/// Returns the depth of a triangle at a position within it.
fn depth_in([a, b, c]: &[PicturePoint; 3], p: Vec2) -> Option<f32> {
    let area = (b.px - a.px).perp_dot(c.px - a.px);
    let [wa, wb] = [(b.px - p).perp_dot(c.px - p) / area, (c.px - p).perp_dot(a.px - p) / area];
    let wc = 1.0 - wa - wb;
    (wa.min(wb).min(wc) >= 0.0).then_some(wa * a.depth + wb * b.depth + wc * c.depth)
}

/// Calls `visit` with index and position of every sample in the bounding box of `about`, extended by `margin`.
fn for_samples(about: &[Vec2], margin: f32, at: &[Vec2], mut visit: impl FnMut(usize, Vec2)) {
    let low = about.iter().copied().reduce(Vec2::min).unwrap_or_default() - margin;
    let high = about.iter().copied().reduce(Vec2::max).unwrap_or_default() + margin;
    let pixels = |low: f32, high: f32| low.floor().max(0.0) as u32..(high.floor() + 1.0).clamp(0.0, SIZE as f32) as u32;
    for y in pixels(low.y, high.y) {
        for x in pixels(low.x, high.x) {
            for (k, inside) in at.iter().enumerate() {
                visit((y * SIZE + x) as usize * at.len() + k, vec2(x as f32, y as f32) + inside);
            }
        }
    }
}

fn drive() -> Result<Vec<Finding>, BakeError> {
    let (curves, skin) = knot::grown(700)?;
    let scene = Scene::new(&curves, &skin);
    let grid: Vec<Vec2> = (0..TRUE_SAMPLES * TRUE_SAMPLES)
        .map(|i| (vec2((i % TRUE_SAMPLES) as f32, (i / TRUE_SAMPLES) as f32) + 0.5) / TRUE_SAMPLES as f32)
        .collect();
    let truth = scene.resolved(&grid);
    // Measures over the pixels that the knot covers, between means of squares, so that it does not matter which samples
    // a hair hits.
    let seen = truth.iter().filter(|light| **light > 0.0).count().max(1) as f64;
    let error = |found: Vec<f32>| {
        let mut squares = vec![0.0f64; (SIZE / SQUARE * (SIZE / SQUARE)) as usize];
        for (i, (a, b)) in (0..SIZE * SIZE).zip(found.iter().zip(&truth)) {
            squares[(i / SIZE / SQUARE * (SIZE / SQUARE) + i % SIZE / SQUARE) as usize] += f64::from(a - b);
        }
        squares.iter().map(|difference| difference.abs()).sum::<f64>() / seen
    };
    let widths: f32 = scene.pieces.iter().map(|piece| 2.0 * piece.half_px).sum();
    Ok(vec![Finding {
        case: format!(
            "a knot of {} strands, {:.2} pixels wide on average",
            curves.len(),
            widths / scene.pieces.len().max(1) as f32
        ),
        measure: "mean error of light in blocks of 4x4 pixels; the tips have light 1",
        naive: error(scene.blended()),
        safe: error(scene.resolved(&SAMPLES)),
        bound: 0.025,
        fails_above: 0.03,
    }])
}
