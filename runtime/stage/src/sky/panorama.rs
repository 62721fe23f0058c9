//! An equirectangular picture of all that shines.

use crate::StageError;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Radiance from all directions: rows from straight above to straight below, columns once around. The middle of the picture is +x, a quarter of its width to the right is +z,
/// as most programs have it.
#[derive(Clone, Debug, PartialEq)]
pub struct Panorama {
    width: u32,
    height: u32,
    /// Linear RGB, finite, 0 or more; row-major.
    pixels: Vec<[f32; 3]>,
    mended: u32,
}

impl Default for Panorama {
    /// One black pixel.
    fn default() -> Self {
        Self { width: 1, height: 1, pixels: vec![[0.0; 3]], mended: 0 }
    }
}

impl Panorama {
    /// Most pixels: those of 16k × 8k.
    pub const MOST_PIXELS: u64 = 1 << 27;

    /// Of that many pixels, linear RGB. What is no light is mended: what is negative or not a number becomes 0, and what is infinite as bright as the brightest pixel that is not,
    /// at least 1.
    ///
    /// # Errors
    ///
    /// [`StageError::Asked`] for a picture without pixels, with too many, or of another size than it says.
    pub fn new(width: u32, height: u32, mut pixels: Vec<[f32; 3]>) -> Result<Self, StageError> {
        let count = u64::from(width) * u64::from(height);
        if count == 0 || count > Self::MOST_PIXELS || count != pixels.len() as u64 {
            let reason = format!(
                "{width} x {height} pixels, and {} in it; expected 1 to {} and as many",
                pixels.len(),
                Self::MOST_PIXELS
            );
            return Err(StageError::Asked { what: "panorama".into(), reason });
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

    /// Of that many pixels, each of the radiance that `radiance` says for its middle.
    ///
    /// # Errors
    ///
    /// As [`Panorama::new`].
    pub fn painted((width, height): (u32, u32), radiance: impl Fn(DVec3) -> DVec3) -> Result<Self, StageError> {
        let blank = Self { width, height, pixels: Vec::new(), mended: 0 };
        let count = u64::from(width) * u64::from(height);
        // What is too large is refused before it is painted.
        let rows = if count <= Self::MOST_PIXELS { height } else { 0 };
        let places = (0..rows).flat_map(|y| (0..width).map(move |x| (x, y)));
        let pixels = places.map(|(x, y)| radiance(blank.towards(x, y)).as_vec3().into()).collect();
        Self::new(width, height, pixels)
    }

    /// Pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// How many pixels were no light.
    pub fn mended(&self) -> u32 {
        self.mended
    }

    /// Rows from above, linear RGB.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// Radiance of a pixel.
    pub fn at(&self, column: u32, row: u32) -> DVec3 {
        let index = row as usize * self.width as usize + column as usize;
        DVec3::from(self.pixels[index].map(f64::from))
    }

    /// Unit vector towards the middle of a pixel.
    pub fn towards(&self, column: u32, row: u32) -> DVec3 {
        let up = libm::cos(PI * (f64::from(row) + 0.5) / f64::from(self.height));
        self.around(f64::from(column) + 0.5, up)
    }

    /// Unit vector towards a place in a pixel, each share 0..=1: equal areas of shares are equal solid angles.
    pub fn towards_within(&self, column: u32, row: u32, [across, down]: [f64; 2]) -> DVec3 {
        let [above, below] = [row, row + 1].map(|row| libm::cos(PI * f64::from(row) / f64::from(self.height)));
        self.around(f64::from(column) + across, above + (below - above) * down)
    }

    fn around(&self, column: f64, up: f64) -> DVec3 {
        let (sin, cos) = libm::sincos(TAU * (column / f64::from(self.width) - 0.5));
        let out = (1.0 - up * up).max(0.0).sqrt();
        DVec3::new(out * cos, up, out * sin)
    }

    /// Radiance from a direction of length 1, between the four pixels around it.
    pub fn seen(&self, towards: DVec3) -> DVec3 {
        let (across, down) = self.place(towards);
        let (x, y) = (across - 0.5, (down - 0.5).clamp(0.0, f64::from(self.height - 1)));
        let column = |x: f64| (x as i64).rem_euclid(i64::from(self.width)) as u32;
        let (left, right) = (column(x.floor()), column(x.floor() + 1.0));
        let (above, below) = (y as u32, (y as u32 + 1).min(self.height - 1));
        let row = |y: u32| self.at(left, y).lerp(self.at(right, y), x - x.floor());
        row(above).lerp(row(below), y.fract())
    }

    /// The same over a level ground of that albedo, linear RGB, in place of all that lies below the horizon. `more`: what comes down on it beside the picture, irradiance over π.
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

    /// The pixel in which a direction of length 1 lies.
    pub fn pixel(&self, towards: DVec3) -> (u32, u32) {
        let (across, down) = self.place(towards);
        ((across as u32).min(self.width - 1), (down as u32).min(self.height - 1))
    }

    /// Where a direction of length 1 lies, pixels from the upper left corner.
    fn place(&self, towards: DVec3) -> (f64, f64) {
        let around = 0.5 + libm::atan2(towards.z, towards.x) / TAU;
        let down = libm::acos(towards.y.clamp(-1.0, 1.0)) / PI;
        (around * f64::from(self.width), down * f64::from(self.height))
    }

    /// Solid angle of each pixel of a row, steradians.
    pub fn solid_angle(&self, row: u32) -> f64 {
        let edge = |row: u32| libm::cos(PI * f64::from(row) / f64::from(self.height));
        TAU / f64::from(self.width) * (edge(row) - edge(row + 1))
    }

    /// ∫ of it over all directions.
    pub fn whole(&self) -> DVec3 {
        let row = |row: u32| (0..self.width).map(|x| self.at(x, row)).sum::<DVec3>() * self.solid_angle(row);
        (0..self.height).map(row).sum()
    }

    /// Its means over the cells of a picture of at most that size; each is the mean over its solid angle.
    pub fn reduced(&self, most: (u32, u32)) -> Self {
        let (width, height) = (most.0.clamp(1, self.width), most.1.clamp(1, self.height));
        let mut sums = vec![DVec3::ZERO; width as usize * height as usize];
        let mut angles = vec![0.0; sums.len()];
        // Pixels go to the cells that they lie in by parts.
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

    /// The same with other pixels.
    pub(super) fn with_pixels(&self, pixels: Vec<[f32; 3]>) -> Self {
        Self { pixels, ..*self }
    }
}

/// Which of `from` parts of a line overlap which of `to`, and by which share of the former.
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
