//! Images laid through space: where a place on the skin lies on them.
//!
//! That is a function of place and normal alone, so that a model needs no texture coordinates for it.

use crate::recipe::PatternProjection;
use crate::sample::Wrap;
use glam::{Vec2, Vec3};
use pelage_formats::Bounds;
use pelage_import::mesh::Image;
use std::ops::{Add, Div, Mul};

/// By how much one of the three images of `box` counts, of a component of the normal: its eighth power. A higher one is a sharper border, a lower
/// one a wider blend.
fn box_weight(component: f32) -> f32 {
    let square = component * component;
    let fourth = square * square;
    fourth * fourth
}

/// An image laid through space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Projection {
    along: PatternProjection,
    /// Where the image's centre lies, metres.
    center: Vec3,
    /// Width and height of the image, metres.
    size_m: Vec2,
    /// What lies beyond its border.
    pub(super) wrap: Wrap,
}

/// A place on an image laid through space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OnImage {
    /// Right and down, 0..1 within the image.
    pub(super) uv: Vec2,
    /// Unit directions at rest that point right and up on it.
    pub(super) axes: [Vec3; 2],
}

/// Width of an image that spans a model once as the projection shows it, metres.
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

/// An axis that an image is projected along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Axis {
    X,
    Y,
    Z,
}

impl Axis {
    /// The two components that lie on the image, right and down: as a viewer on the positive side of the axis sees them, with y up, from
    /// above with z down.
    fn on_image(self, v: Vec3) -> Vec2 {
        match self {
            Self::X => Vec2::new(-v.z, -v.y),
            Self::Y => Vec2::new(v.x, v.z),
            Self::Z => Vec2::new(v.x, -v.y),
        }
    }

    /// What points right and up on the image.
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
    /// An image laid through a model of that extent; its middle is the model's.
    ///
    /// * `width_m`: its width, metres; without, it spans the model once
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

    /// Width of the image on the model, metres.
    pub(super) fn width_m(&self) -> f32 {
        self.size_m.x
    }

    /// What `read` finds where a place, metres at rest, lies on the image: of several axes the mean by the unit normal of the skin there.
    pub(super) fn read<T>(&self, position: Vec3, normal: Vec3, read: impl Fn(OnImage) -> T) -> T
    where
        T: Default + Add<Output = T> + Mul<f32, Output = T> + Div<f32, Output = T>,
    {
        let along = |axis: Axis| {
            let uv = axis.on_image(position - self.center) / self.size_m + 0.5;
            read(OnImage { uv, axes: axis.right_and_up() })
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
