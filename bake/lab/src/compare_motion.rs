//! Flicker: change of a picture from one frame to the next, beyond the motion of its contents.
//!
//! If the ray of a frame's pixel meets the mesh surface, that point (triangle and weights) is looked up on the surface
//! of the next frame. It is then projected into that frame's picture. If the point is visible there as well, both greys
//! should be the same except for changes of light and view. Their mean absolute difference is the flicker. It is 0 for
//! a texture fixed to the surface, and large for one fixed to the screen. The motion is taken from the mesh and not
//! estimated from the pictures, so that a texture that slides over the surface does not count as motion.
//!
//! Contours move over the surface even without flicker, because they depend on the view. Pixels that are lines in both
//! frames or in neither are therefore separated from those where a line appears or vanishes. Figures are meant to
//! compare drawing methods on the same motion; even a perfect method does not reach 0.

use crate::mask::Mask;
use glam::DVec2;
use pelage_import::BakeError;
use pelage_truth::{SurfaceVisibility, TrueCamera};
use rayon::prelude::*;

/// Frame: a picture, and the surface that it shows.
#[derive(Clone, Copy)]
pub struct FlickerFrame<'a> {
    /// Posed mesh surface.
    pub sight: &'a SurfaceVisibility,
    /// Camera of the picture.
    pub camera: &'a TrueCamera,
    /// Displayed grey of each of `width * height` pixels, sRGB-encoded, 0 black to 1 white, row-major from the top.
    pub grey: &'a [f32],
    /// Pixels that are lines, of the picture's size.
    pub lines: &'a Mask,
}

/// Mean absolute differences of grey between consecutive frames, each 0..=1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Flicker {
    /// Mean over all pixels whose surface point is visible in both frames.
    pub surface: MeanOf,
    /// Mean over the pixels of `surface` that are lines in neither frame, and whose lookup in the next frame touches no
    /// line.
    pub wash: MeanOf,
    /// Mean over the pixels of `surface` that are lines in both frames.
    pub lines: MeanOf,
    /// Mean over pixels that show no mesh surface in either frame. Each pixel is compared with itself, which is valid
    /// for a fixed camera.
    pub background: MeanOf,
}

/// Mean that can be combined with others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanOf {
    /// Sum of the values.
    pub sum: f64,
    /// Number of values.
    pub count: u64,
}

impl MeanOf {
    /// Returns the mean; `None` without values.
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
    /// Combines two means, as if measured over one longer sequence.
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

/// Tolerance of the test whether a surface point is occluded, relative to the distance between the eye and the point.
const SLACK: f64 = 1e-4;

/// Measures the flicker between two consecutive frames of one model.
///
/// `size`: width and height of both pictures, pixels.
///
/// # Errors
///
/// [`BakeError::Params`] if a picture or mask has another size, or the frames have different meshes.
pub fn flicker(now: &FlickerFrame<'_>, next: &FlickerFrame<'_>, size: (u32, u32)) -> Result<Flicker, BakeError> {
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
    let faces = |moment: &FlickerFrame<'_>| moment.sight.skin().triangles.len();
    if faces(now) != faces(next) {
        return wrong("frames", format!("{} triangles", faces(next)), format!("{} as in the first", faces(now)));
    }
    let (look, next_look) = (now.sight.view(now.camera, size), next.sight.view(next.camera, size));
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
            let place = next.sight.position_ws(seen.triangle, seen.weights);
            let Some(at) = next_look.project_px(place).filter(|at| next_look.contains(*at)) else { continue };
            if !next_look.is_visible(place, SLACK * place.distance(next.camera.eye_ws.as_dvec3())) {
                continue;
            }
            let apart = (f64::from(now.grey[i]) - bilinear(next.grey, size, at)).abs();
            out.surface.add(apart);
            // The lookup interpolates between the four pixels from this corner on.
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
    // Rows run in parallel and are combined in order, so that the sums do not depend on the number of threads.
    let rows: Vec<Flicker> = (0..height).into_par_iter().map(row).collect();
    Ok(rows.into_iter().fold(Flicker::default(), Flicker::joined))
}

/// Returns the grey at a point of a picture, clamped to the outermost pixel centres. The point is in pixels from the
/// upper left corner.
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
