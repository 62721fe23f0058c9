//! Ray-traced picture of a package: its strands and mesh surface.

use super::camera::{RayCaster, TrueCamera};
use super::denoise::{Guide, denoise};
use super::lighting::{Sample, TileShading, TrueLighting, root_directions};
use super::tracer::Tracer;
use glam::{DVec2, DVec3};
use pelage_bake::noise::{hash, r2_point, uniform};
use pelage_bake::stages::simulate::TileHair;
use pelage_bake::strands::Curves;
use pelage_bake::strands::PosedMesh;
use pelage_formats::Shading;
use pelage_import::BakeError;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ops::{ControlFlow, Range};

/// Side of the squares in which a picture is traced, pixels.
const SQUARE: u32 = 16;
/// Number of squares between two calls of the progress callback.
const BATCH: usize = 32;

/// A ray-traced picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TracedPicture {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Premultiplied linear RGB, and alpha: the fraction of samples that hit anything. Row-major from the top. Colours
    /// may exceed 1.
    pub pixels: Vec<[f32; 4]>,
    /// Number of rays traced.
    pub rays: Rays,
}

/// Numbers of rays of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rays {
    /// Rays from the eye.
    pub primary: u64,
    /// Shadow rays; with light paths also the rays that continue a path.
    pub shadow: u64,
}

/// Strands and mesh surface, prepared for ray tracing.
pub struct TrueScene {
    pub(super) tracer: Tracer,
    material: TileShading,
}

impl TracedPicture {
    /// Returns the number of covered pixels.
    pub fn covered(&self) -> usize {
        self.pixels.iter().filter(|p| p[3] > 0.0).count()
    }

    /// Blends with another picture of the same size, made of other samples. `[own, new]`: fractions of all samples that
    /// this picture and the other one contribute.
    pub fn mix(&mut self, other: &Self, [own, new]: [f32; 2]) {
        for (pixel, more) in self.pixels.iter_mut().zip(&other.pixels) {
            *pixel = std::array::from_fn(|i| own * pixel[i] + new * more[i]);
        }
        self.rays.primary += other.rays.primary;
        self.rays.shadow += other.rays.shadow;
    }
}

impl TrueScene {
    /// Builds the acceleration structures.
    ///
    /// * `hair`: the tile that the strands are copies of; provides the undercoat. `None` leaves furred surfaces bare
    /// * `shading`: shading parameters of `hair.strands`
    ///
    /// Fails with [`BakeError::Internal`] for positions that are not finite.
    pub fn new(curves: Curves, skin: PosedMesh, hair: Option<&TileHair>, shading: Shading) -> Result<Self, BakeError> {
        let wet = hair.and_then(|h| h.wet.as_ref());
        let directions =
            |strands: Option<&pelage_bake::stages::simulate::Strands>| strands.map_or_else(Vec::new, root_directions);
        let color = |strands: Option<&pelage_bake::stages::simulate::Strands>| {
            strands.map_or(DVec3::ONE, |s| s.root_color.as_dvec3())
        };
        let dry = hair.map(|h| &h.strands);
        let material = TileShading {
            dry: shading,
            wet: shading.wet(),
            roots: [directions(dry), directions(wet)],
            root_colors: [color(dry), color(wet)],
        };
        Ok(Self { tracer: Tracer::new(curves, skin)?, material })
    }

    /// Returns the strands.
    pub fn curves(&self) -> &Curves {
        &self.tracer.curves
    }

    /// Returns the mesh surface.
    pub fn skin(&self) -> &PosedMesh {
        &self.tracer.skin
    }

    /// Returns the memory per strand, bytes: its points, its segments and their tree nodes.
    pub fn bytes_per_strand(&self) -> f64 {
        self.tracer.bytes_per_strand()
    }

    /// Traces a picture of `width` × `height` pixels with `spp` samples each, spread over the square of the pixel (box
    /// filter).
    ///
    /// `progress` receives the number of finished pixels and the number of all pixels. The picture is the same for any
    /// number of threads.
    pub fn picture(
        &self,
        camera: &TrueCamera,
        lighting: &TrueLighting,
        (width, height): (u32, u32),
        spp: u32,
        progress: &mut dyn FnMut(u64, u64),
    ) -> TracedPicture {
        let mut going_on = |done, total| {
            progress(done, total);
            ControlFlow::Continue(())
        };
        let whole = self.portion(camera, lighting, (width, height), &Portion::of_samples(0..spp), &mut going_on);
        // This call never cancels.
        whole.unwrap_or_default()
    }

    /// Traces a portion of [`Self::picture`]; all other pixels are empty.
    ///
    /// Portions can be combined. The mean of pictures of disjoint samples, weighted by sample counts, equals the
    /// picture of all samples. The pixels of a part are bit-identical to those of the picture. Returns `None` if
    /// `progress` cancels.
    pub fn portion(
        &self,
        camera: &TrueCamera,
        lighting: &TrueLighting,
        (width, height): (u32, u32),
        Portion { samples, part }: &Portion,
        progress: &mut dyn FnMut(u64, u64) -> ControlFlow<()>,
    ) -> Option<TracedPicture> {
        let mut sums = PictureSums { first: samples.start, ..PictureSums::new((width, height), *part) };
        let count = samples.end.saturating_sub(samples.start);
        self.add_samples(camera, lighting, &mut sums, count, progress).is_continue().then(|| sums.picture())
    }

    /// Traces `count` more samples of each pixel and adds them to `sums`. The picture of `n` samples is the same for
    /// any number of calls. Breaks if `progress` cancels; `sums` then has some of the samples only.
    pub fn add_samples(
        &self,
        camera: &TrueCamera,
        lighting: &TrueLighting,
        sums: &mut PictureSums,
        count: u32,
        progress: &mut dyn FnMut(u64, u64) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let width = sums.size.0 as usize;
        let squares = sums.squares.clone();
        let total = squares.iter().map(Square::pixels).sum();
        let first = sums.first + sums.samples;
        let samples = first..first.saturating_add(count);
        let mut done = 0;
        let rays = RayCaster::new(camera, sums.size);
        for batch in squares.chunks(BATCH) {
            let before = &*sums;
            let traced: Vec<_> = batch
                .par_iter()
                .map(|Square { columns, rows }| {
                    let mut pixels = Vec::new();
                    let mut count = Rays::default();
                    for (y, x) in rows.clone().flat_map(|y| columns.clone().map(move |x| (y, x))) {
                        let mut sum = before.pixels[y as usize * width + x as usize];
                        self.pixel(&rays, lighting, (x, y), (samples.clone(), before.guided), &mut sum, &mut count);
                        pixels.push(sum);
                    }
                    (columns, rows.start, pixels, count)
                })
                .collect();
            for (columns, y0, pixels, count) in traced {
                for (row, colors) in pixels.chunks(columns.len()).enumerate() {
                    let first = (y0 as usize + row) * width + columns.start as usize;
                    sums.pixels[first..first + columns.len()].copy_from_slice(colors);
                }
                done += pixels.len() as u64;
                sums.rays.primary += count.primary;
                sums.rays.shadow += count.shadow;
            }
            progress(done, total)?;
        }
        sums.samples += count;
        ControlFlow::Continue(())
    }

    fn pixel(
        &self,
        rays: &RayCaster,
        lighting: &TrueLighting,
        (x, y): (u32, u32),
        (samples, guided): (Range<u32>, bool),
        sum: &mut PixelSum,
        count: &mut Rays,
    ) {
        let seed = hash(u64::from(x) << 32 | u64::from(y), 0x0123);
        let shift = DVec2::new(f64::from(uniform(seed, 0)), f64::from(uniform(seed, 1)));
        for i in samples {
            let inside = r2_point(i, shift);
            let (origin, way) = rays.ray(DVec2::new(f64::from(x), f64::from(y)) + inside);
            count.primary += 1;
            if let Some((hit, distance)) = self.tracer.first_hit(origin, way) {
                let of_pixel = (seed, i);
                let seed = hash(seed, u64::from(i) + 2);
                let sample = Sample { tracer: &self.tracer, material: &self.material, lighting, seed, of_pixel };
                sum.met += 1;
                let light = sample.light(&hit, origin + way * distance, -way, &mut count.shadow);
                sum.color += light;
                if guided {
                    sum.guide.add(&self.tracer, &hit, distance, light);
                }
            }
        }
    }
}

/// Sums of the samples of a picture, to which further samples can be added.
#[derive(Clone, Debug)]
pub struct PictureSums {
    /// Width and height, pixels.
    size: (u32, u32),
    /// Squares whose pixels have samples.
    squares: Vec<Square>,
    /// Number of the first sample.
    first: u32,
    /// Samples of each pixel of the part.
    samples: u32,
    /// Sums of all pixels, row by row from the top.
    pixels: Vec<PixelSum>,
    rays: Rays,
    /// Whether the samples are summed for the filter, too.
    guided: bool,
}

/// Sums of a pixel's samples.
#[derive(Clone, Copy, Debug, Default)]
struct PixelSum {
    /// Premultiplied linear colour.
    color: DVec3,
    /// Number of samples that hit anything.
    met: u32,
    /// Zero unless the sums are guided.
    guide: Guide,
}

impl PictureSums {
    /// Creates the sums of a part of a picture, without samples.
    pub fn new((width, height): (u32, u32), part: Part) -> Self {
        let pixels = vec![PixelSum::default(); width as usize * height as usize];
        let squares = part.squares((width, height));
        Self { size: (width, height), squares, first: 0, samples: 0, pixels, rays: Rays::default(), guided: false }
    }

    /// Prepares the sums for [`Self::denoised`].
    #[must_use]
    pub fn guided(self) -> Self {
        Self { guided: true, ..self }
    }

    /// Keeps at least one square, and others until they have `pixels`. They are spread over the part.
    #[must_use]
    pub fn thinned(mut self, pixels: u64) -> Self {
        let step = usize::try_from(self.pixels() / pixels.max(1)).unwrap_or(usize::MAX).max(1);
        // A step of the golden ratio takes squares from all rows and columns.
        let count = self.squares.len();
        let place = |i: usize| ((i as f64 * 0.618_033_988_749_894_8).fract() * count as f64) as usize;
        let places: BTreeSet<usize> = (0..count.div_ceil(step)).map(place).collect();
        self.squares = places.into_iter().filter_map(|i| self.squares.get(i).cloned()).collect();
        self
    }

    /// Returns the number of samples of each pixel of the part.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Returns the number of pixels of the part.
    pub fn pixels(&self) -> u64 {
        self.squares.iter().map(Square::pixels).sum()
    }

    /// Returns the mean of the samples.
    pub fn picture(&self) -> TracedPicture {
        let count = f64::from(self.samples.max(1));
        let mean = |PixelSum { color, met, .. }: &PixelSum| {
            let color = (color / count).as_vec3();
            [color.x, color.y, color.z, (f64::from(*met) / count) as f32]
        };
        let (width, height) = self.size;
        TracedPicture { width, height, pixels: self.pixels.iter().map(mean).collect(), rays: self.rays }
    }

    /// Returns the mean of the samples, with most of the noise removed; coverage stays. Needs [`Self::guided`] sums.
    pub fn denoised(&self) -> TracedPicture {
        let mut picture = self.picture();
        let sums = self.pixels.iter().map(|pixel| (pixel.color, pixel.met, pixel.guide));
        for (shown, light) in picture.pixels.iter_mut().zip(denoise(self.size, sums)) {
            let light = light * shown[3];
            shown[..3].copy_from_slice(&light.to_array());
        }
        picture
    }
}

/// Portion of a picture to trace.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Portion {
    /// Range of samples of each pixel.
    pub samples: Range<u32>,
    /// Part of the picture's pixels.
    pub part: Part,
}

impl Portion {
    /// Returns the portion that has these samples of all pixels.
    pub fn of_samples(samples: Range<u32>) -> Self {
        Self { samples, part: Part::default() }
    }
}

/// Part of a picture: small squares distributed over all of it, so that all parts take about the same time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Index of the part, from 0.
    pub number: u32,
    /// Number of parts, at least 1.
    pub of: u32,
}

impl Default for Part {
    /// Returns the whole picture as one part.
    fn default() -> Self {
        Self { number: 0, of: 1 }
    }
}

/// A small square of a picture, clipped to its edges.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Square {
    /// Range of columns.
    pub columns: Range<u32>,
    /// Range of rows.
    pub rows: Range<u32>,
}

impl Square {
    /// Returns the number of pixels.
    pub fn pixels(&self) -> u64 {
        self.columns.len() as u64 * self.rows.len() as u64
    }
}

impl Part {
    /// Returns the squares of this part of a picture of `width` × `height` pixels. Every pixel is in exactly one
    /// square, which is in exactly one part.
    pub fn squares(&self, (width, height): (u32, u32)) -> Vec<Square> {
        let along = |count: u32, i: u32| SQUARE * i..(SQUARE * (i + 1)).min(count);
        let rows = 0..height.div_ceil(SQUARE);
        rows.flat_map(|y| (0..width.div_ceil(SQUARE)).map(move |x| (x, y)))
            // Squares are assigned to parts along diagonals, so that no part consists of whole columns.
            .filter(|(x, y)| (x + y) % self.of == self.number)
            .map(|(x, y)| Square { columns: along(width, x), rows: along(height, y) })
            .collect()
    }
}

#[cfg(test)]
#[path = "picture_tests.rs"]
mod tests;
