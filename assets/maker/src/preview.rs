//! Preview pictures of a model from three sides, once with its vertex colours and once with a checker pattern in its
//! texture coordinates.

use glam::{DMat3, DVec3};
use image::{Rgb, RgbImage};

use super::{
    glb::{Clip, Model},
    pose::posed,
};

const PANEL: u32 = 480;
const PAPER: Rgb<u8> = Rgb([205, 208, 214]);

/// Draws three views of the model. Below them, the same views have checkered texture coordinates. The picture is 1440 x
/// 960 pixels.
///
/// Checker squares are a quarter of a unit of texture coordinates wide. Within each unit, red grows with u and green
/// with v.
pub fn draw(model: &Model) -> RgbImage {
    let mut picture = RgbImage::from_pixel(3 * PANEL, 2 * PANEL, PAPER);
    // Directions from the model to the eye: front left, side, back.
    let eyes = [DVec3::new(0.55, 0.18, 0.8), DVec3::new(1.0, 0.1, 0.05), DVec3::new(-0.55, 0.35, -0.8)];
    for (column, eye) in eyes.into_iter().enumerate() {
        for checker in [false, true] {
            let (left, top) = (column as u32 * PANEL, u32::from(checker) * PANEL);
            Panel { left, top, side: PANEL, frame: bounds(model) }.draw(model, eye.normalize(), checker, &mut picture);
        }
    }
    picture
}

/// Returns the lowest and highest corner of the bounding box.
fn bounds(model: &Model) -> (DVec3, DVec3) {
    let points = || model.primitives.iter().flat_map(|p| &p.positions);
    (points().fold(DVec3::MAX, |m, &p| m.min(p)), points().fold(DVec3::MIN, |m, &p| m.max(p)))
}

/// Square area of the picture.
struct Panel {
    left: u32,
    top: u32,
    side: u32,
    /// Bounding box that fills the panel.
    frame: (DVec3, DVec3),
}

impl Panel {
    fn draw(&self, model: &Model, eye: DVec3, checker: bool, picture: &mut RgbImage) {
        let (low, high) = self.frame;
        let (left, top, side) = (self.left, self.top, self.side);
        let right = DVec3::Y.cross(eye).normalize();
        let view = DMat3::from_cols(right, eye.cross(right), eye).transpose();
        let scale = 0.92 * f64::from(side) / (high - low).max_element();
        let light = DVec3::new(0.35, 0.8, 0.5).normalize();
        let mut depth = vec![f64::MIN; (side * side) as usize];
        for primitive in &model.primitives {
            for t in &primitive.triangles {
                let t = t.map(|v| v as usize);
                let p = t.map(|v| {
                    let q = view * (primitive.positions[v] - (low + high) * 0.5) * scale;
                    let half = 0.5 * f64::from(side);
                    DVec3::new(half + q.x, half - q.y, q.z)
                });
                let area = (p[1] - p[0]).cross(p[2] - p[0]).z;
                // The picture's y axis points down, so front faces have negative area and others are skipped.
                if area >= 0.0 {
                    continue;
                }
                let (from, to) = (p[0].min(p[1]).min(p[2]), p[0].max(p[1]).max(p[2]));
                let last = f64::from(side - 1);
                for y in from.y.max(0.0).floor() as u32..=to.y.clamp(0.0, last) as u32 {
                    for x in from.x.max(0.0).floor() as u32..=to.x.clamp(0.0, last) as u32 {
                        let q = DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 0.0);
                        let edge = |a: DVec3, b: DVec3| (b - a).cross(q - a).z / area;
                        let w = [edge(p[1], p[2]), edge(p[2], p[0]), edge(p[0], p[1])];
                        let z: f64 = (0..3).map(|k| w[k] * p[k].z).sum();
                        let at = (y * side + x) as usize;
                        if w.iter().any(|&w| w < 0.0) || z <= depth[at] {
                            continue;
                        }
                        depth[at] = z;
                        let mix = |values: [DVec3; 3]| values[0] * w[0] + values[1] * w[1] + values[2] * w[2];
                        let n = mix(t.map(|v| primitive.normals[v])).normalize_or_zero();
                        let color = if checker && primitive.material == 0 {
                            let uv = mix(t.map(|v| DVec3::new(primitive.uvs[v][0], primitive.uvs[v][1], 0.0)));
                            let odd = ((uv * 4.0).floor().x + (uv * 4.0).floor().y).rem_euclid(2.0);
                            let inside = uv - uv.floor();
                            DVec3::new(0.15 + 0.7 * inside.x, 0.15 + 0.7 * inside.y, 0.4) * (0.35 + 0.65 * odd)
                        } else {
                            mix(t.map(|v| primitive.colors[v].truncate()))
                                * DVec3::from(model.materials[primitive.material].color)
                        };
                        let lit = color * (0.35 + 0.75 * n.dot(light).max(0.0));
                        let srgb = lit.to_array().map(|c| (c.clamp(0.0, 1.0).sqrt() * 255.0) as u8);
                        picture.put_pixel(left + x, top + y, Rgb(srgb));
                    }
                }
            }
        }
    }
}

const FRAME: u32 = 320;

/// Draws a clip at eight evenly spaced times. The upper row shows the side view, the lower row the view from the front
/// left. The picture is 2560 x 640 pixels.
pub fn draw_clip(model: &Model, clip: &Clip) -> RgbImage {
    let mut picture = RgbImage::from_pixel(8 * FRAME, 2 * FRAME, PAPER);
    let seconds = clip.channels.iter().filter_map(|c| c.times.last().copied()).fold(0.0, f64::max);
    let frame = bounds(model);
    for k in 0..8 {
        let moment = posed(model, clip, seconds * f64::from(k) / 8.0);
        for (row, eye) in [DVec3::new(1.0, 0.04, 0.0), DVec3::new(0.6, 0.2, 0.8)].into_iter().enumerate() {
            let panel = Panel { left: k * FRAME, top: row as u32 * FRAME, side: FRAME, frame };
            panel.draw(&moment, eye.normalize(), false, &mut picture);
        }
    }
    picture
}
