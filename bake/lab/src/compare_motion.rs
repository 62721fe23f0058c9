//! Flicker: how much a picture changes from one frame to the next where the things in it only move.
//!
//! For each pixel of a frame whose ray meets the skin, the point it meets (triangle and weights) is looked up on the
//! skin of the next frame and projected into that frame's picture. Where the point is seen there as well, both greys
//! should be the same but for light and view; their mean absolute difference is the flicker. It is 0 for a texture that
//! is tied to the surface and large for one that is tied to the screen. The motion is that of the mesh itself and not
//! estimated from the pictures, so that what swims cannot pass for motion.
//!
//! Contours move over the surface even when nothing flickers, because they depend on the view. So what is a line in
//! both frames, and what is none in either, is told apart from where a line comes or goes; and what is compared is one
//! way to draw against another on the same motion, not a figure against 0.

use glam::DVec2;
use pelage_bake::mask::Mask;
use pelage_import::BakeError;
use pelage_truth::{Sight, TrueCamera};
use rayon::prelude::*;

/// A frame: a picture and what it shows.
#[derive(Clone, Copy)]
pub struct Moment<'a> {
    /// The posed skin.
    pub sight: &'a Sight,
    /// From where it is seen.
    pub camera: &'a TrueCamera,
    /// Greys of `width * height` pixels as they are shown, sRGB-encoded, 0 black to 1 white, row-major from the top.
    pub grey: &'a [f32],
    /// Its pixels that are lines, of the picture's size.
    pub lines: &'a Mask,
}

/// Mean absolute differences of grey between neighbouring frames, each 0..=1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Flicker {
    /// Over all pixels whose point of the skin is seen in both frames.
    pub surface: MeanOf,
    /// Over those of them that are lines in neither frame, nor touch one.
    pub wash: MeanOf,
    /// Over those that are lines in both.
    pub lines: MeanOf,
    /// Over pixels that show no skin in either frame, each with itself: right for a camera that stands still.
    pub background: MeanOf,
}

/// A mean that can be joined with others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanOf {
    /// Sum of the values.
    pub sum: f64,
    /// Their number.
    pub count: u64,
}

impl MeanOf {
    /// The mean; `None` of nothing.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }

    fn add(&mut self, value: f64) {
        *self = self.joined(Self { sum: value, count: 1 });
    }

    fn joined(self, other: Self) -> Self {
        Self { sum: self.sum + other.sum, count: self.count + other.count }
    }
}

impl Flicker {
    /// Of both, as over one longer sequence.
    #[must_use]
    pub fn joined(self, other: Self) -> Self {
        Self {
            surface: self.surface.joined(other.surface),
            wash: self.wash.joined(other.wash),
            lines: self.lines.joined(other.lines),
            background: self.background.joined(other.background),
        }
    }
}

/// How far before a point of the skin something may lie without hiding it, as a share of the distance between the eye
/// and the point.
const SLACK: f64 = 1e-4;

/// Flicker between two neighbouring frames of one model.
///
/// `size`: width and height of both pictures, pixels.
///
/// # Errors
///
/// [`BakeError::Params`] where a picture or the mask is of another size, or the frames are of different meshes.
pub fn flicker(now: &Moment<'_>, next: &Moment<'_>, size: (u32, u32)) -> Result<Flicker, BakeError> {
    let (width, height) = size;
    let pixels = width as usize * height as usize;
    let wrong = |what, found: String, expected: String| {
        Err(BakeError::Params { what, reason: format!("{found}, expected {expected}") })
    };
    for moment in [now, next] {
        if moment.grey.len() != pixels {
            return wrong("picture", format!("{} greys", moment.grey.len()), format!("{width}x{height}"));
        }
        let lines = moment.lines;
        if (lines.width, lines.height) != size {
            return wrong("lines", format!("{}x{}", lines.width, lines.height), format!("{width}x{height}"));
        }
    }
    let faces = |moment: &Moment<'_>| moment.sight.skin().triangles.len();
    if faces(now) != faces(next) {
        return wrong("frames", format!("{} triangles", faces(next)), format!("{} as in the first", faces(now)));
    }
    let (look, next_look) = (now.sight.from(now.camera, size), next.sight.from(next.camera, size));
    let row = |y: u32| {
        let mut out = Flicker::default();
        for x in 0..width {
            let middle = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let i = y as usize * width as usize + x as usize;
            let Some(seen) = look.at(middle) else {
                if next_look.at(middle).is_none() {
                    out.background.add(f64::from((now.grey[i] - next.grey[i]).abs()));
                }
                continue;
            };
            let place = next.sight.place_ws(seen.triangle, seen.weights);
            let Some(at) = next_look.place_px(place).filter(|at| next_look.holds(*at)) else { continue };
            if !next_look.sees(place, SLACK * place.distance(next.camera.eye_ws.as_dvec3())) {
                continue;
            }
            let apart = (f64::from(now.grey[i]) - bilinear(next.grey, size, at)).abs();
            out.surface.add(apart);
            // The four pixels that the lookup mixes.
            let corner = (at - 0.5).floor();
            let around = [(0, 0), (1, 0), (0, 1), (1, 1)]
                .map(|(dx, dy)| next.lines.contains(corner.x as i64 + dx, corner.y as i64 + dy));
            if now.lines.pixels[i] {
                if !around.contains(&false) {
                    out.lines.add(apart);
                }
            } else if !around.contains(&true) {
                out.wash.add(apart);
            }
        }
        out
    };
    // Rows in parallel, joined in their order, so that the sums do not depend on the number of threads.
    let rows: Vec<Flicker> = (0..height).into_par_iter().map(row).collect();
    Ok(rows.into_iter().fold(Flicker::default(), Flicker::joined))
}

/// The grey at a point of a picture, pixels from its upper left corner; beyond the outermost middles theirs goes on.
fn bilinear(grey: &[f32], (width, height): (u32, u32), at: DVec2) -> f64 {
    let last = DVec2::new(f64::from(width - 1), f64::from(height - 1));
    let at = (at - 0.5).clamp(DVec2::ZERO, last);
    let (corner, share) = (at.floor(), at - at.floor());
    let texel = |dx: u32, dy: u32| {
        let (x, y) = ((corner.x as u32 + dx).min(width - 1), (corner.y as u32 + dy).min(height - 1));
        f64::from(grey[y as usize * width as usize + x as usize])
    };
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    mix(mix(texel(0, 0), texel(1, 0), share.x), mix(texel(0, 1), texel(1, 1), share.x), share.y)
}

#[cfg(test)]
#[path = "compare_motion_tests.rs"]
mod tests;
