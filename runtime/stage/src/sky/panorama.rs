//! Equirectangular picture of radiance.

use crate::StageError;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Radiance from all directions. Rows go from straight up to straight down, columns once around. The centre of the
/// picture is +x; a quarter of the width to the right of it is +z, as in most programs.
#[derive(Clone, Debug, PartialEq)]
pub struct Panorama {
    width: u32,
    height: u32,
    /// Pixels in linear RGB, finite, 0 or more; row-major.
    pixels: Vec<[f32; 3]>,
    mended: u32,
}

impl Default for Panorama {
    /// Returns a panorama of one black pixel.
    fn default() -> Self {
        Self { width: 1, height: 1, pixels: vec![[0.0; 3]], mended: 0 }
    }
}

impl Panorama {
    /// Maximum number of pixels: 16k × 8k.
    pub const MOST_PIXELS: u64 = 1 << 27;

    /// Creates a panorama of the given pixels, linear RGB. Repairs invalid values: negative values and NaN become 0;
    /// infinite values become the brightest finite one, at least 1.
    ///
    /// # Errors
    ///
    /// [`StageError::Request`] if there are no pixels, too many, or a number that does not match width and height.
    pub fn new(width: u32, height: u32, mut pixels: Vec<[f32; 3]>) -> Result<Self, StageError> {
        let count = u64::from(width) * u64::from(height);
        if count == 0 || count > Self::MOST_PIXELS || count != pixels.len() as u64 {
            let reason = format!(
                "found {width} x {height} pixels and {} values, expected 1 to {} pixels and one value per pixel",
                pixels.len(),
                Self::MOST_PIXELS
            );
            return Err(StageError::Request { what: "panorama".into(), reason });
        }
        let finite = pixels.iter().flatten().copied().filter(|x| x.is_finite());
        let brightest = finite.fold(1.0, f32::max);
        let mut mended = 0;
        for pixel in &mut pixels {
            let before = *pixel;
            for x in pixel.iter_mut() {
                *x = if x.is_nan() { 0.0 } else { x.clamp(0.0, brightest) };
            }
            mended += u32::from(*pixel != before);
        }
        Ok(Self { width, height, pixels, mended })
    }

    /// Creates a panorama of the given size; `radiance` returns the radiance at the centre of each pixel.
    ///
    /// # Errors
    ///
    /// The errors of [`Panorama::new`].
    pub fn from_fn((width, height): (u32, u32), radiance: impl Fn(DVec3) -> DVec3) -> Result<Self, StageError> {
        let blank = Self { width, height, pixels: Vec::new(), mended: 0 };
        let count = u64::from(width) * u64::from(height);
        // A picture that is too large must be rejected before it is painted.
        let rows = if count <= Self::MOST_PIXELS { height } else { 0 };
        let places = (0..rows).flat_map(|y| (0..width).map(move |x| (x, y)));
        let pixels = places.map(|(x, y)| radiance(blank.towards(x, y)).as_vec3().into()).collect();
        Self::new(width, height, pixels)
    }

    /// Returns width and height in pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Returns the number of repaired pixels.
    pub fn mended(&self) -> u32 {
        self.mended
    }

    /// Returns the pixels, rows from the top, linear RGB.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// Returns the radiance of a pixel.
    pub fn at(&self, column: u32, row: u32) -> DVec3 {
        let index = row as usize * self.width as usize + column as usize;
        DVec3::from(self.pixels[index].map(f64::from))
    }

    /// Returns the unit vector towards the centre of a pixel.
    pub fn towards(&self, column: u32, row: u32) -> DVec3 {
        let up = libm::cos(PI * (f64::from(row) + 0.5) / f64::from(self.height));
        self.around(f64::from(column) + 0.5, up)
    }

    /// Returns the unit vector towards a point within a pixel, given by coordinates 0..=1. Equal areas in these
    /// coordinates are equal solid angles.
    pub fn towards_within(&self, column: u32, row: u32, [across, down]: [f64; 2]) -> DVec3 {
        let [above, below] = [row, row + 1].map(|row| libm::cos(PI * f64::from(row) / f64::from(self.height)));
        self.around(f64::from(column) + across, above + (below - above) * down)
    }

    fn around(&self, column: f64, up: f64) -> DVec3 {
        let (sin, cos) = libm::sincos(TAU * (column / f64::from(self.width) - 0.5));
        let out = (1.0 - up * up).max(0.0).sqrt();
        DVec3::new(out * cos, up, out * sin)
    }

    /// Returns the radiance from a unit direction, interpolated between the four nearest pixels.
    pub fn sample(&self, towards: DVec3) -> DVec3 {
        let (across, down) = self.place(towards);
        let (x, y) = (across - 0.5, (down - 0.5).clamp(0.0, f64::from(self.height - 1)));
        let column = |x: f64| (x as i64).rem_euclid(i64::from(self.width)) as u32;
        let (left, right) = (column(x.floor()), column(x.floor() + 1.0));
        let (above, below) = (y as u32, (y as u32 + 1).min(self.height - 1));
        let row = |y: u32| self.at(left, y).lerp(self.at(right, y), x - x.floor());
        row(above).lerp(row(below), y.fract())
    }

    /// Returns the panorama with a level ground in place of everything below the horizon.
    ///
    /// * `albedo`: of the ground, linear RGB
    /// * `more`: light that reaches the ground in addition to the picture's, irradiance divided by π
    #[must_use]
    pub fn over_ground(&self, albedo: [f32; 3], more: DVec3) -> Self {
        let up = |y: u32| self.towards(0, y).y;
        let of_row = |y: u32| {
            let light: DVec3 = (0..self.width).map(|x| self.at(x, y)).sum();
            light * (self.solid_angle(y) * up(y).max(0.0) / PI)
        };
        let comes = more + (0..self.height).map(of_row).sum::<DVec3>();
        let sent: [f32; 3] = (DVec3::from(albedo.map(f64::from)) * comes).as_vec3().into();
        let mut pixels = self.pixels.clone();
        for (y, row) in (0..self.height).zip(pixels.chunks_exact_mut(self.width as usize)) {
            if up(y) < 0.0 {
                row.fill(sent);
            }
        }
        self.with_pixels(pixels)
    }

    /// Returns the pixel that contains a unit direction, as column and row.
    pub fn pixel(&self, towards: DVec3) -> (u32, u32) {
        let (across, down) = self.place(towards);
        ((across as u32).min(self.width - 1), (down as u32).min(self.height - 1))
    }

    /// Returns the position of a unit direction, in pixels from the upper left corner.
    fn place(&self, towards: DVec3) -> (f64, f64) {
        let around = 0.5 + libm::atan2(towards.z, towards.x) / TAU;
        let down = libm::acos(towards.y.clamp(-1.0, 1.0)) / PI;
        (around * f64::from(self.width), down * f64::from(self.height))
    }

    /// Returns the solid angle of each pixel of a row, steradians.
    pub fn solid_angle(&self, row: u32) -> f64 {
        let edge = |row: u32| libm::cos(PI * f64::from(row) / f64::from(self.height));
        TAU / f64::from(self.width) * (edge(row) - edge(row + 1))
    }

    /// Returns the integral of the radiance over all directions.
    pub fn total(&self) -> DVec3 {
        let row = |row: u32| (0..self.width).map(|x| self.at(x, row)).sum::<DVec3>() * self.solid_angle(row);
        (0..self.height).map(row).sum()
    }

    /// Returns the picture reduced to at most the size `most`. Each cell is the mean over its solid angle.
    pub fn reduced(&self, most: (u32, u32)) -> Self {
        let (width, height) = (most.0.clamp(1, self.width), most.1.clamp(1, self.height));
        let mut sums = vec![DVec3::ZERO; width as usize * height as usize];
        let mut angles = vec![0.0; sums.len()];
        // A pixel is split between the cells that it overlaps.
        for (row, row_share) in overlaps(self.height, height) {
            let angle = self.solid_angle(row.0) * row_share;
            for (column, share) in overlaps(self.width, width) {
                let cell = row.1 as usize * width as usize + column.1 as usize;
                sums[cell] += self.at(column.0, row.0) * (angle * share);
                angles[cell] += angle * share;
            }
        }
        let mean = |(sum, angle): (&DVec3, &f64)| (*sum / angle.max(1e-300)).as_vec3().into();
        let pixels = sums.iter().zip(&angles).map(mean).collect();
        Self { width, height, pixels, mended: self.mended }
    }

    /// Returns a panorama of the same size with other pixels.
    pub(super) fn with_pixels(&self, pixels: Vec<[f32; 3]>) -> Self {
        Self { pixels, ..*self }
    }
}

/// Divides a line into `from` and into `to` equal parts. Returns which parts overlap, and the overlapping fraction of
/// the former.
fn overlaps(from: u32, to: u32) -> impl Iterator<Item = ((u32, u32), f64)> {
    let scale = f64::from(to) / f64::from(from);
    (0..from).flat_map(move |i| {
        let (begin, end) = (f64::from(i) * scale, f64::from(i + 1) * scale);
        let last = (end.ceil() as u32).min(to);
        (begin as u32..last.max(begin as u32 + 1).min(to)).map(move |j| {
            let share = (end.min(f64::from(j + 1)) - begin.max(f64::from(j))) / scale;
            ((i, j), share.max(0.0))
        })
    })
}
