//! Transmittance through the strands themselves: rays are blocked or not by round, opaque hairs.
//!
//! This truth reads the same [`Strands`] as slicing does, but nothing that slicing computes from them. It therefore
//! shows the error of the layers compared with the hair, whereas [`super::SampledVolume`] shows only the error of the
//! maps compared with the layers. The two differ for three reasons:
//!
//! * Slicing preserves a strand's coverage but not its sharpness: a hair is widened to the filter of the texels, and
//!   its opacity is reduced in proportion. A hair many texels wide lets a little light through its middle, where a real
//!   one lets none through ([`pelage_bake::stages::textures::extinction`]).
//! * Along the hair, the tails of the Gaussians with which it is rasterised add up. Light from straight above therefore
//!   meets hairs that are too wide.
//! * A ray that starts within a hair is blocked; in the volume, it has half a layer in front of it.
//!
//! The remaining difference is an error of coherence: layers affect each other only through the light that passes from
//! map to map.
//!
//! A grid over the tile would be as fast as a bounding volume hierarchy as long as hair stands up evenly. If hair is
//! combed flat or gathered in locks, most segments are in one cell of a grid, whereas the tree stays fast.

use glam::{DVec2, DVec3};
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use obvhs::ray::Ray;
use obvhs::{Boundable, BvhBuildParams};
use pelage_bake::stages::simulate::Strands;
use pelage_import::BakeError;
use pelage_truth::{seed_of, stratified};
use std::time::Duration;

/// Number of tiles that a ray may cross before it is assumed never to leave the fur.
const MAX_TILES: u32 = 1 << 12;

/// Piece of a strand: all points within a radius of a line segment. The radius varies linearly from one end to the
/// other.
#[derive(Clone, Copy, Debug)]
struct Segment {
    from: DVec3,
    along: DVec3,
    radii: [f64; 2],
    strand: u32,
    /// Tile from which the segment was taken, as an offset in tiles.
    home: DVec2,
}

impl Boundable for Segment {
    fn aabb(&self) -> Aabb {
        let (a, b) = (self.from, self.from + self.along);
        // The margin compensates for rounding to f32, which must not shrink the box.
        let reach = self.radii[0].max(self.radii[1]) + 1e-6 * (1.0 + a.abs().max(b.abs()).max_element());
        Aabb::new((a.min(b) - reach).as_vec3a(), (a.max(b) + reach).as_vec3a())
    }
}

impl Segment {
    /// Returns whether the ray `origin` + t `way`, with t in 0..=`length`, enters the hair; `way` has unit length.
    ///
    /// The radius is that at the point of the axis where ray and axis are closest. This is exact for cylinders with
    /// round ends. For tapering hair, the error is of second order in the taper.
    fn blocks(&self, origin: DVec3, way: DVec3, length: f64) -> bool {
        // Closest points of a line and a segment, after Ericson, Real-Time Collision Detection (2005), 5.1.9.
        let r = origin - self.from;
        let (c, e) = (way.dot(r), self.along.length_squared());
        let (s, w) = if e > 0.0 {
            let (b, f) = (way.dot(self.along), self.along.dot(r));
            let across = e - b * b;
            let s = if across > 1e-12 * e { ((b * f - c * e) / across).clamp(0.0, length) } else { 0.0 };
            let w = (b * s + f) / e;
            if (0.0..=1.0).contains(&w) {
                (s, w)
            } else {
                let w = w.clamp(0.0, 1.0);
                ((b * w - c).clamp(0.0, length), w)
            }
        } else {
            ((-c).clamp(0.0, length), 0.0)
        };
        let radius = self.radii[0] + (self.radii[1] - self.radii[0]) * w;
        (r + way * s - self.along * w).length_squared() < radius * radius
    }
}

/// Strands of one tile as solid hairs, periodic along u and v, in widths of the tile.
pub struct StrandField {
    /// Segments in the order of the tree's leaves. The middle of each is within 0..1 along u and v.
    segments: Vec<Segment>,
    /// Acceleration tree; `None` without hair.
    tree: Option<Bvh2>,
    min: DVec3,
    max: DVec3,
}

impl StrandField {
    /// Builds the field.
    ///
    /// # Errors
    ///
    /// Same as [`Strands::validate`].
    pub fn new(strands: &Strands) -> Result<Self, BakeError> {
        strands.validate()?;
        let mut segments = Vec::new();
        for strand in 0..strands.len() {
            let range = strands.range(strand);
            for i in range.start..range.end.saturating_sub(1) {
                let (a, b) = (strands.points[i].as_dvec3(), strands.points[i + 1].as_dvec3());
                let middle = 0.5 * (a + b);
                let home = middle.truncate().floor();
                let radii = [strands.radii[i], strands.radii[i + 1]].map(f64::from);
                if radii != [0.0; 2] {
                    let from = a - home.extend(0.0);
                    segments.push(Segment { from, along: b - a, radii, strand: strand as u32, home });
                }
            }
        }
        if segments.is_empty() {
            return Ok(Self { segments, tree: None, min: DVec3::ZERO, max: DVec3::ZERO });
        }
        let tree = build_bvh2(&segments, BvhBuildParams::medium_build(), &mut Duration::default());
        let bounds = segments.iter().map(Boundable::aabb).reduce(|a, b| a.union(&b)).unwrap_or_else(Aabb::empty);
        let segments = tree.primitive_indices.iter().map(|i| segments[*i as usize]).collect();
        Ok(Self { segments, tree: Some(tree), min: bounds.min.as_dvec3(), max: bounds.max.as_dvec3() })
    }

    /// Returns the fraction of rays from a small square at height `z`, parallel to the mesh surface, that reach a
    /// distant light past all hairs; 0..=1. This is the light in the space between hairs; inside a hair it is 0.
    /// [`Self::lights_strand`] gives the light on a hair itself.
    ///
    /// * `u`, `v`: middle of the square, tile widths; any value, because the tile repeats
    /// * `z`: height above the mesh surface, tile widths
    /// * `footprint`: width of the square along u and v, tile widths; 0 sends all rays from one point
    /// * `light_ts`: direction towards the light, of any length, in the frame of the tile: u, v, and away from the mesh
    ///   surface
    /// * `samples`: number of rays, rounded up to a square number; one from each cell of a grid in the square
    ///
    /// The result is deterministic. It is 0 if the light is not above the mesh surface, which is opaque.
    pub fn transmittance(&self, u: f64, v: f64, z: f64, footprint: f64, light_ts: DVec3, samples: u32) -> f64 {
        let Some(light) = light_ts.try_normalize().filter(|l| l.z > 0.0) else { return 0.0 };
        let rays = stratified(seed_of(&[u, v, z]), samples);
        let count = rays.len();
        let free = rays.filter(|cell| {
            let place = DVec2::new(u, v) + (*cell - 0.5) * footprint;
            self.is_free(place.extend(z), light, None)
        });
        free.count() as f64 / count as f64
    }

    /// Returns whether a distant light is visible from a point on a strand past all other hairs. Copies of the strand
    /// in other tiles block light, as in the traced picture, where each copy is a separate strand.
    ///
    /// * `place`: point on the strand's axis, tile widths, as in [`Strands::points`], not wrapped into the tile
    /// * `strand`: index of the strand
    /// * `light_ts`: as in [`Self::transmittance`]
    ///
    /// The result is false if the light is not above the mesh surface.
    pub fn lights_strand(&self, place: DVec3, strand: u32, light_ts: DVec3) -> bool {
        let light = light_ts.try_normalize().filter(|l| l.z > 0.0);
        light.is_some_and(|light| self.is_free(place, light, Some(strand)))
    }

    /// Returns whether a ray leaves the fur past all strands but `own`. The ray is divided into pieces one tile wide.
    /// This keeps the coordinates of a piece small enough for the tree, which uses f32. A piece meets hairs of
    /// neighbouring tiles only if those hairs lean over.
    fn is_free(&self, start: DVec3, light: DVec3, own: Option<u32>) -> bool {
        let Some(tree) = &self.tree else { return true };
        let enter = ((self.min.z - start.z) / light.z).max(0.0);
        let leave = (self.max.z - start.z) / light.z;
        let piece = 1.0 / light.x.abs().max(light.y.abs()).max(1e-3);
        for i in 0..MAX_TILES {
            let from = enter + f64::from(i) * piece;
            if from >= leave {
                return true;
            }
            let origin = start + light * from;
            let tile = origin.truncate().floor();
            let hides = |segment: &Segment, copy: DVec2| own != Some(segment.strand) || tile + copy != segment.home;
            if self.piece_is_blocked(tree, origin - tile.extend(0.0), light, piece.min(leave - from), hides) {
                return false;
            }
        }
        false
    }

    /// Returns whether a piece of the ray meets a hair for which `hides` returns true. `hides` receives a segment, and
    /// the tile of its copy.
    fn piece_is_blocked(
        &self,
        tree: &Bvh2,
        origin: DVec3,
        way: DVec3,
        length: f64,
        hides: impl Fn(&Segment, DVec2) -> bool,
    ) -> bool {
        let end = origin + way * length;
        let (low, high) = (origin.min(end), origin.max(end));
        // Copies of the tile that this piece of the ray may touch.
        let copies =
            |axis: usize| (low[axis] - self.max[axis]).ceil() as i64..=(high[axis] - self.min[axis]).floor() as i64;
        copies(0).any(|i| {
            copies(1).any(|j| {
                let copy = DVec2::new(i as f64, j as f64);
                let origin = origin - copy.extend(0.0);
                let ray = Ray::new(origin.as_vec3a(), way.as_vec3a(), 0.0, length as f32);
                !tree.ray_traverse_miss(ray, |_, id| {
                    let segment = &self.segments[id];
                    if hides(segment, copy) && segment.blocks(origin, way, length) { 0.0 } else { f32::INFINITY }
                })
            })
        })
    }
}

#[cfg(test)]
#[path = "strands_tests.rs"]
mod tests;
