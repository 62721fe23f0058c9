//! Projection of images through space: finds the image point for a surface point.
//!
//! The result depends only on position and normal, so that a model needs no texture coordinates.

use crate::recipe::PatternProjection;
use crate::sample::Wrap;
use glam::{Vec2, Vec3};
use pelage_formats::Bounds;
use pelage_import::mesh::Image;
use std::ops::{Add, Div, Mul};

/// Returns the weight of one of the three images of the projection `box`: the eighth power of the given component of
/// the normal. A higher power would give a sharper border, a lower one a wider blend.
fn box_weight(component: f32) -> f32 {
    let square = component * component;
    let fourth = square * square;
    fourth * fourth
}

/// Projection of an image through space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Projection {
    along: PatternProjection,
    /// Centre of the image, metres.
    center: Vec3,
    /// Width and height of the image, metres.
    size_m: Vec2,
    /// Continuation beyond the border of the image.
    pub(super) wrap: Wrap,
}

/// Point on a projected image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ImagePoint {
    /// Coordinates right and down, 0..1 within the image.
    pub(super) uv: Vec2,
    /// Unit directions in the rest pose that point right and up on the image.
    pub(super) axes: [Vec3; 2],
}

/// Returns the width, metres, at which an image spans a model exactly once in this projection.
fn spanning_m(image: &Image, projection: PatternProjection, bounds: &Bounds) -> f32 {
    let extent = Vec3::from(bounds.max) - Vec3::from(bounds.min);
    let aspect = image.width as f32 / image.height.max(1) as f32;
    let spans = |axis: Axis| {
        let on_image = axis.on_image(extent).abs();
        on_image.x.max(on_image.y * aspect)
    };
    let width = axes(projection).iter().map(|axis| spans(*axis)).fold(0.0, f32::max);
    if width > 0.0 && width.is_finite() { width } else { 1.0 }
}

/// Axis along which an image is projected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Axis {
    X,
    Y,
    Z,
}

impl Axis {
    /// Returns the two components of a vector in the image, right and down, as seen from the positive side of the axis.
    /// For the axes x and z, up on the image is +y. For the axis y, the view is from above, and down on the image is
    /// +z.
    fn on_image(self, v: Vec3) -> Vec2 {
        match self {
            Self::X => Vec2::new(-v.z, -v.y),
            Self::Y => Vec2::new(v.x, v.z),
            Self::Z => Vec2::new(v.x, -v.y),
        }
    }

    /// Returns the directions that point right and up on the image.
    fn right_and_up(self) -> [Vec3; 2] {
        match self {
            Self::X => [Vec3::NEG_Z, Vec3::Y],
            Self::Y => [Vec3::X, Vec3::NEG_Z],
            Self::Z => [Vec3::X, Vec3::Y],
        }
    }

    fn of(self, v: Vec3) -> f32 {
        match self {
            Self::X => v.x,
            Self::Y => v.y,
            Self::Z => v.z,
        }
    }
}

fn axes(projection: PatternProjection) -> &'static [Axis] {
    match projection {
        PatternProjection::X => &[Axis::X],
        PatternProjection::Y => &[Axis::Y],
        PatternProjection::Z => &[Axis::Z],
        PatternProjection::Box => &[Axis::X, Axis::Y, Axis::Z],
    }
}

impl Projection {
    /// Projects an image through a model with these bounds, centred on it.
    ///
    /// * `width_m`: width of the image, metres; by default it spans the model once
    pub(super) fn new(
        along: PatternProjection,
        wrap: Wrap,
        image: &Image,
        bounds: &Bounds,
        width_m: Option<f32>,
    ) -> Self {
        let width = width_m.unwrap_or_else(|| spanning_m(image, along, bounds));
        let height = width * image.height as f32 / image.width.max(1) as f32;
        Self {
            along,
            center: (Vec3::from(bounds.min) + Vec3::from(bounds.max)) / 2.0,
            size_m: Vec2::new(width, height),
            wrap,
        }
    }

    /// Returns the width of the image on the model, metres.
    pub(super) fn width_m(&self) -> f32 {
        self.size_m.x
    }

    /// Returns the value of `read` at the image point for a position at rest, metres. If the image is projected along
    /// several axes, the result is a mean. Its weights depend on the unit normal at the position.
    pub(super) fn read<T>(&self, position: Vec3, normal: Vec3, read: impl Fn(ImagePoint) -> T) -> T
    where
        T: Default + Add<Output = T> + Mul<f32, Output = T> + Div<f32, Output = T>,
    {
        let along = |axis: Axis| {
            let uv = axis.on_image(position - self.center) / self.size_m + 0.5;
            read(ImagePoint { uv, axes: axis.right_and_up() })
        };
        match axes(self.along) {
            [axis] => along(*axis),
            several => {
                let weighed = several.iter().map(|axis| (box_weight(axis.of(normal)), along(*axis)));
                let (sum, weight) = weighed.fold((T::default(), 0.0), |(sum, n), (w, value)| (sum + value * w, n + w));
                if weight > 0.0 { sum / weight } else { along(Axis::Y) }
            }
        }
    }
}

#[cfg(test)]
#[path = "projection_tests.rs"]
mod tests;
