//! `simulate`: style → strands.
//!
//! The hair of one tile is grown by a particle system (Reeves 1983; Lengyel et al. 2001). Particles leave the mesh
//! surface from stratified roots, and the trail of each particle is a strand. Space is periodic in u and v, so that the
//! tile can be repeated; trails are stored unwrapped. The length unit is the tile width, with u and v along the tile
//! and h above the surface, so that tangents are metric directions.
//!
//! A particle has unit speed and only its heading is integrated, so a trail keeps its given length under any forces.
//! The heading relaxes towards its target by the exact solution of the linear relaxation, which is stable at any step.
//! The explicit form stretches the trail and then diverges (`tests/tests/stability/rows.rs`, "hair simulation").
//!
//! All random values are hashes of seed, strand and purpose. Functions beyond IEEE arithmetic and square roots come
//! from the `libm` crate. Unlike those of `std`, its results do not depend on the platform.

mod forces;
mod lateral_offset;
mod locks;
mod shades;
mod styles;
mod tile;

pub use lateral_offset::LateralOffsets;
pub use shades::linear;
pub use styles::{GuideForces, StyleForces};
pub use tile::{TileHair, simulate_recipe};

use crate::recipe::{ColorParams, HairParams, UnderfurParams};
use forces::Grower;
use glam::Vec3;
use locks::Locks;
use pelage_import::BakeError;
use rayon::prelude::*;
use shades::Shades;

/// Volume in which the strands grow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeParams {
    /// Height, tile widths, 0.001..=1000 (default 0.4). It is also the length of the longest strand: `length_m /
    /// tile_size_m`.
    pub height: f32,
}

impl Default for VolumeParams {
    fn default() -> Self {
        Self { height: 0.4 }
    }
}

impl VolumeParams {
    /// Checks that the height is within its range.
    ///
    /// Fails with [`BakeError::Params`] naming the recipe key.
    pub fn validate(&self) -> Result<(), BakeError> {
        if (1e-3..=1e3).contains(&self.height) {
            return Ok(());
        }
        Err(BakeError::Params {
            what: "hair.length_m",
            reason: format!(
                "the hair is {} times as long as its tile is wide, expected 0.001..=1000; change hair.length_m or \
                 surface.tile_size_m",
                self.height
            ),
        })
    }
}

/// Hair of one tile, as polylines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strands {
    /// Points of all strands, each from the root: u, v (not wrapped into the tile) and h, in tile widths.
    pub points: Vec<Vec3>,
    /// Radius at each point, in tile widths.
    pub radii: Vec<f32>,
    /// Colour at each point, linear RGB.
    pub colors: Vec<Vec3>,
    /// Ranges of points: strand `i` is `offsets[i]..offsets[i + 1]`. There is one more entry than there are strands;
    /// without strands, the list may be empty.
    pub offsets: Vec<u32>,
    /// Height of the tallest strand and of the outermost layer, tile widths, above zero.
    pub height: f32,
    /// Linear RGB of the mesh surface under the hair.
    pub root_color: Vec3,
}

impl Strands {
    /// Returns the number of strands.
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Returns whether there are no strands.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the points of a strand, as indices into `points`, `radii` and `colors`; empty if the strand does not
    /// exist.
    pub fn range(&self, strand: usize) -> std::ops::Range<usize> {
        match self.offsets.get(strand..).unwrap_or(&[]) {
            [start, end, ..] => *start as usize..*end as usize,
            _ => 0..0,
        }
    }

    /// Appends the strands of `more`.
    fn extend(&mut self, more: Self) {
        let first = self.points.len() as u32;
        self.points.extend(more.points);
        self.radii.extend(more.radii);
        self.colors.extend(more.colors);
        self.offsets.extend(more.offsets.iter().skip(1).map(|offset| first + offset));
    }

    /// Checks that the lists have matching lengths and that all values are finite, as `slice` requires.
    ///
    /// Fails with [`BakeError::Internal`] naming the list or value at fault.
    pub fn validate(&self) -> Result<(), BakeError> {
        let fail = |reason: String| Err(BakeError::Internal(format!("strands: {reason}")));
        let n = self.points.len();
        if self.radii.len() != n || self.colors.len() != n {
            return fail(format!(
                "there are {n} points, {} radii and {} colours, expected equal \
                 numbers",
                self.radii.len(),
                self.colors.len()
            ));
        }
        let ordered = self.offsets.windows(2).all(|w| w[0] <= w[1]);
        let ends = (self.offsets.first().copied().unwrap_or(0), self.offsets.last().copied().unwrap_or(0) as usize);
        if !ordered || ends != (0, n) {
            return fail(format!("offsets do not rise from 0 to {n}"));
        }
        if !(self.height.is_finite() && self.height > 0.0) {
            return fail(format!("height is {}, expected above 0", self.height));
        }
        let finite = self.points.iter().chain(&self.colors).all(|p| p.is_finite());
        if !finite || !self.radii.iter().all(|r| r.is_finite() && *r >= 0.0) {
            return fail("a point, colour or radius is not finite".into());
        }
        Ok(())
    }
}

/// Maximum number of points of all strands together. It limits memory to about 1 GiB for a million strands.
const MAX_POINTS: u32 = 32 << 20;

/// Grows the strands of one tile, guard hair only.
///
/// * `params`: number, lengths, radii and style of the strands
/// * `color`: colours of the strands from root to tip
/// * `volume`: length of the longest strand, tile widths
///
/// Each strand has its random arc length. No point is below the mesh surface or above [`Strands::height`], and all
/// values are finite. The result depends only on the arguments, not on the number of threads.
///
/// Fails with [`BakeError::Params`] for a value outside its range.
pub fn simulate(params: &HairParams, color: &ColorParams, volume: &VolumeParams) -> Result<Strands, BakeError> {
    simulate_with_underfur(params, &UnderfurParams { density: 0, ..UnderfurParams::default() }, color, volume)
}

/// Grows all strands of one tile: guard hair, then underfur. Arguments and guarantees are those of [`simulate`].
///
/// * `underfur`: parameters of the underfur, which has no strands by default
///
/// Fails like [`simulate`].
pub fn simulate_with_underfur(
    params: &HairParams,
    underfur: &UnderfurParams,
    color: &ColorParams,
    volume: &VolumeParams,
) -> Result<Strands, BakeError> {
    params.validate()?;
    underfur.validate()?;
    color.validate()?;
    volume.validate()?;
    let water = StyleForces::of(params.style).color;
    let shades = Shades::new(color, water);
    let most_segments = MAX_POINTS / (params.density + underfur.density);
    let locks = Locks::for_guard_hair(params, volume.height);
    let guard = Grower::new(params, volume.height, most_segments, locks.as_ref());
    let mut strands = grow_kind(&guard, &shades, color.variation);
    if underfur.density > 0 {
        let own = underfur_params(params, underfur);
        let own_shades = shades.with_underfur_colors(underfur.root, underfur.tip, water);
        let grower = guard.underfur(&own, volume.height * underfur.length, most_segments);
        strands.extend(grow_kind(&grower, &own_shades, color.variation));
        strands.root_color = own_shades.root;
    }
    let tallest = strands.points.par_iter().map(|p| p.z).reduce(|| 0.0, f32::max);
    // Slicing needs a volume even if all hair is flat.
    strands.height = tallest.max(volume.height * 1e-3);
    Ok(strands)
}

fn underfur_params(guard: &HairParams, fur: &UnderfurParams) -> HairParams {
    let is_wet = |style| StyleForces::of(style).wet;
    HairParams {
        density: fur.density,
        length_variation: fur.length_variation,
        root_radius: fur.root_radius,
        tip_radius: fur.tip_radius,
        style: fur.style.filter(|style| !is_wet(guard.style) && !is_wet(*style)).unwrap_or(guard.style),
        lean: fur.lean.unwrap_or(guard.lean),
        frizz: fur.frizz,
        dry_clump: fur.dry_clump.unwrap_or(guard.dry_clump),
        ..guard.clone()
    }
}

/// Grows the strands of one kind. The caller must set their height, which is 0.
fn grow_kind(grower: &Grower<'_>, shades: &Shades, variation: f32) -> Strands {
    let params = grower.params();
    let per_strand = grower.segments() + 1;
    let count = params.density as usize * per_strand;
    let mut strands = Strands {
        points: vec![Vec3::ZERO; count],
        radii: vec![0.0; count],
        colors: vec![Vec3::ZERO; count],
        offsets: (0..=params.density).map(|i| i * per_strand as u32).collect(),
        height: 0.0,
        root_color: shades.root,
    };
    let lists = (
        strands.points.par_chunks_mut(per_strand),
        strands.radii.par_chunks_mut(per_strand),
        strands.colors.par_chunks_mut(per_strand),
    );
    lists.into_par_iter().enumerate().for_each(|(i, (points, radii, colors))| {
        grower.grow(i as u32, points);
        let brightness = 1.0 + variation * grower.brightness(i as u32);
        let stray = grower.band_offset(i as u32);
        for (j, (radius, color)) in radii.iter_mut().zip(colors).enumerate() {
            let t = j as f32 / (per_strand - 1) as f32;
            *radius = params.root_radius + (params.tip_radius - params.root_radius) * t;
            *color = shades.at(t, stray) * brightness;
        }
    });
    strands
}

#[cfg(test)]
mod tests;
