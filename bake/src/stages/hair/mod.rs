//! `simulate`: style → strands.
//!
//! The hair of one tile is grown by a particle system (Reeves 1983; Lengyel et al. 2001): particles leave the skin from
//! stratified roots and the trail of each is a strand. The box they move in is periodic in u and v, so that the tile can be
//! repeated; trails are stored unwrapped. Length units are widths of the tile, u and v along it and h above the skin, so that
//! tangents are metric directions.
//!
//! A particle has unit speed and only its heading is integrated, so that a trail has the length it was given whatever the
//! forces are. The heading relaxes towards its target by the exact solution of the linear relaxation, which is stable at any
//! step; the explicit form stretches and then blows up (`tests/tests/stability/rows.rs`, "hair simulation").
//!
//! Everything random is a hash of seed, strand and purpose, and all functions beyond IEEE arithmetic and square roots come from
//! the `libm` crate, whose results do not depend on the platform as those of `std` may.

mod asides;
mod forces;
mod locks;
mod shades;
mod styles;
mod tile;

pub use asides::Asides;
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

/// The box that the strands grow in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeParams {
    /// Height in widths of the tile, which is also the length of the longest strand: `length_m / tile_size_m`.
    /// 0.001..=1000 (default 0.4).
    pub height: f32,
}

impl Default for VolumeParams {
    fn default() -> Self {
        Self { height: 0.4 }
    }
}

impl VolumeParams {
    /// Checks the range.
    ///
    /// # Errors
    /// [`BakeError::Params`] naming the recipe key.
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

/// The hair of one tile, as polylines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strands {
    /// Points of all strands, each root first: u, v (not wrapped into the tile) and h, in widths of the tile.
    pub points: Vec<Vec3>,
    /// Radius at each point, widths of the tile.
    pub radii: Vec<f32>,
    /// Linear RGB at each point.
    pub colors: Vec<Vec3>,
    /// Strand `i` is `offsets[i]..offsets[i + 1]`; one entry more than strands, or none.
    pub offsets: Vec<u32>,
    /// Height that the tallest strand reaches: where the outermost layer lies. Widths of the tile, above zero.
    pub height: f32,
    /// Linear RGB of the skin under the hair.
    pub root_color: Vec3,
}

impl Strands {
    /// Number of strands.
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Whether there is no strand.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Points of a strand, as indices into `points`, `radii` and `colors`; empty for a strand that does not exist.
    pub fn range(&self, strand: usize) -> std::ops::Range<usize> {
        match self.offsets.get(strand..).unwrap_or(&[]) {
            [start, end, ..] => *start as usize..*end as usize,
            _ => 0..0,
        }
    }

    /// Adds those of `more` behind its own.
    fn extend(&mut self, more: Self) {
        let first = self.points.len() as u32;
        self.points.extend(more.points);
        self.radii.extend(more.radii);
        self.colors.extend(more.colors);
        self.offsets.extend(more.offsets.iter().skip(1).map(|offset| first + offset));
    }

    /// Checks that the lists fit together and every value is finite; what `slice` relies on.
    ///
    /// # Errors
    /// [`BakeError::Internal`] naming what does not fit.
    pub fn validate(&self) -> Result<(), BakeError> {
        let fail = |reason: String| Err(BakeError::Internal(format!("strands: {reason}")));
        let n = self.points.len();
        if self.radii.len() != n || self.colors.len() != n {
            return fail(format!("{n} points, {} radii and {} colours", self.radii.len(), self.colors.len()));
        }
        let ordered = self.offsets.windows(2).all(|w| w[0] <= w[1]);
        let ends = (self.offsets.first().copied().unwrap_or(0), self.offsets.last().copied().unwrap_or(0) as usize);
        if !ordered || ends != (0, n) {
            return fail(format!("offsets do not lead from 0 to {n} in order"));
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

/// Points that all strands together may have: bounds memory to about 1 GiB at a million strands.
const MAX_POINTS: u32 = 32 << 20;

/// Grows the strands of one tile, guard hair alone.
///
/// * `params`: number, lengths, radii and style of the strands
/// * `color`: their colour from root to tip
/// * `volume`: length of the longest strand in widths of the tile
///
/// Every strand's arc length is its drawn length, no point lies under the skin or above [`Strands::height`], and all values are
/// finite. The result depends on the arguments only, not on the number of threads.
///
/// # Errors
/// [`BakeError::Params`] for a value outside its range.
pub fn simulate(params: &HairParams, color: &ColorParams, volume: &VolumeParams) -> Result<Strands, BakeError> {
    simulate_coats(params, &UnderfurParams { density: 0, ..UnderfurParams::default() }, color, volume)
}

/// Grows all the strands of one tile: guard hair, then underfur. The arguments, and what holds for the result, are as in [`simulate`].
///
/// * `underfur`: the second coat; of no strands by default
///
/// # Errors
/// As [`simulate`].
pub fn simulate_coats(
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
    let locks = Locks::of_coat(params, volume.height);
    let guard = Grower::new(params, volume.height, most_segments, locks.as_ref());
    let mut strands = grown(&guard, &shades, color.variation);
    if underfur.density > 0 {
        let own = under(params, underfur);
        let own_shades = shades.under(underfur.root, underfur.tip, water);
        let grower = guard.under(&own, volume.height * underfur.length, most_segments);
        strands.extend(grown(&grower, &own_shades, color.variation));
        strands.root_color = own_shades.root;
    }
    let tallest = strands.points.par_iter().map(|p| p.z).reduce(|| 0.0, f32::max);
    // Hair pressed flat still needs a volume to be sliced.
    strands.height = tallest.max(volume.height * 1e-3);
    Ok(strands)
}

/// What describes underfur beside guard hair.
fn under(guard: &HairParams, fur: &UnderfurParams) -> HairParams {
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

/// The strands of one kind, of which nobody has asked yet how tall they are.
fn grown(grower: &Grower<'_>, shades: &Shades, variation: f32) -> Strands {
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
        let stray = grower.stray(i as u32);
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
