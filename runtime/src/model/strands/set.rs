//! Strands in GPU memory: fur strands and hair groups.

use crate::gpu::WORKGROUP;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use pelage_formats::GroupMotion;
use std::ops::Range;

/// Maximum number of fur strands drawn into the deep opacity map.
const MOST_SHADOWING: f32 = 100_000.0;

/// Strands of a model that all have the same number of points: its fur strands, or a hair group.
#[derive(Debug)]
pub(crate) struct StrandSet {
    /// Buffer of [`Strand`], one per strand.
    pub(crate) strands: wgpu::Buffer,
    /// Data from which the points are posed.
    pub(crate) growth: StrandSource,
    /// Points of the tile's strands as stored in the package: the dry ones, then the wet ones. For a hair group: radius
    /// and colour of its hairs in the same format.
    pub(crate) tile: wgpu::Buffer,
    /// Number of points per strand.
    pub(crate) points: u32,
    /// Number of strands.
    pub(crate) count: u32,
    /// Strand range of each part of the manifest, aligned to workgroups.
    pub(crate) of_parts: Vec<Range<u32>>,
    /// Number of points of all dry strands of the tile.
    pub(super) dry_points: u32,
    /// Radius that the largest stored value represents, metres.
    pub(super) radius: f32,
    /// Mean width of the tile's dry strands over all their points, metres.
    pub(crate) mean_width_m: f32,
    /// Deviation of the mean dry strand from its simplified shape, metres, for each of [`Self::steps`].
    pub(crate) deviation_m: Vec<f32>,
    /// Smallest selection number in each workgroup; empty if the strands are not sorted by it.
    pub(super) least_chances: Vec<f32>,
}

/// Kinds of strands: the data from which their points are posed.
#[derive(Debug)]
pub(crate) enum StrandSource {
    /// Fur: the surface position of each point, [`SurfacePoint`].
    Fur {
        /// Surface points of all dry strands, followed by those of all wet strands.
        stands: wgpu::Buffer,
    },
    /// Hair group that follows guides.
    Guided(Guided),
}

#[derive(Debug)]
pub(crate) struct Guided {
    /// Vertex indices of the root triangle of each guide, and the barycentric weights of the root's second and third
    /// corner, unorm.
    pub(crate) triangles: wgpu::Buffer,
    /// Guide points at rest, relative to their roots, in the frames of their triangles.
    pub(crate) guides: wgpu::Buffer,
    /// Accelerations that keep the guides in their rest shape against gravity, in the frames of their triangles.
    pub(crate) ballast: wgpu::Buffer,
    /// Motion parameters; `None` if the guides do not move.
    pub(crate) motion: Option<GroupMotion>,
    pub(crate) guide_count: u32,
    /// Buffer of [`HairRoot`], one per hair.
    pub(crate) hairs: wgpu::Buffer,
    /// Greatest distance from the surface, metres.
    pub(crate) reach_m: f32,
    /// Index of the package's fibre.
    pub(crate) fibre: u32,
}

/// Root of a hair in a group, and the guides that it follows.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct HairRoot {
    /// Vertex indices of the root triangle.
    pub(crate) vertices: [u32; 3],
    /// Barycentric weights of the second and third corner, unorm.
    pub(crate) weights: [u16; 2],
    /// Indices of the guides.
    pub(crate) guides: [u16; 4],
    /// Weights of the guides, unorm.
    pub(crate) shares: [u8; 4],
    /// Length relative to that of the guides.
    pub(crate) length: f32,
    /// Offset of the tip from the interpolated guides, in the frame of the root triangle, metres.
    pub(crate) aside: [f32; 3],
    pub(crate) reserved: u32,
}

impl StrandSet {
    pub(crate) fn guided(&self) -> Option<&Guided> {
        match &self.growth {
            StrandSource::Fur { .. } => None,
            StrandSource::Guided(guided) => Some(guided),
        }
    }

    /// Returns the shader constants for the strands of a part. A share `share` of them is drawn, with every `step`th
    /// point and `widened` times their natural width.
    pub(crate) fn constants(&self, part: &Range<u32>, [share, widened]: [f32; 2], step: u32) -> StrandConstants {
        StrandConstants {
            points: self.points,
            count: self.count,
            dry_points: self.dry_points,
            radius: self.radius * widened,
            first: part.start,
            end: part.end,
            share,
            step,
        }
    }

    /// Returns the share of strands that are drawn into the deep opacity map, each correspondingly wider. The share
    /// covers all guided hairs, and as many fur strands as a map can resolve.
    pub(crate) fn shadow_share(&self) -> f32 {
        match self.growth {
            StrandSource::Fur { .. } => (MOST_SHADOWING / self.count.max(1) as f32).min(1.0),
            StrandSource::Guided(_) => 1.0,
        }
    }

    /// Returns the prefix of the range `part`, in whole workgroups, that contains all strands whose selection number is
    /// below `share`.
    pub(crate) fn prefix_below(&self, part: &Range<u32>, share: f32) -> Range<u32> {
        let groups = (part.start / WORKGROUP) as usize..part.end.div_ceil(WORKGROUP) as usize;
        let Some(chances) = self.least_chances.get(groups) else { return part.clone() };
        // Where non-adjacent parts were joined, the strands are sorted only within each of them.
        let count = chances.iter().rposition(|least| *least < share).map_or(0, |last| last as u32 + 1);
        part.start..(part.start + count * WORKGROUP).min(part.end)
    }

    /// Returns the size of the particle buffer of movable guides, bytes: two vectors per point, and four per guide for
    /// its frames. `None` if the guides cannot move.
    pub(crate) fn particle_bytes(&self) -> Option<u64> {
        let guided = self.guided().filter(|guided| guided.motion.is_some())?;
        Some(u64::from(guided.guide_count) * u64::from(2 * self.points + 4) * 16)
    }

    /// Returns the size of the posed points in bytes: per strand, two vectors of the surface frame, then its points.
    pub(crate) fn posed_bytes(&self) -> u64 {
        u64::from(self.count) * u64::from(self.points + 2) * 16
    }

    /// Returns the number of corners of a ribbon that uses every `step`th point: two per point.
    fn corners(&self, step: u32) -> u32 {
        2 * (self.segments(step) + 1)
    }

    /// Returns the number of segments of a ribbon that uses every `step`th point; each has two triangles.
    pub(crate) fn segments(&self, step: u32) -> u32 {
        (self.points - 1) / step
    }

    /// Returns the possible strides between drawn points: divisors of a strand's number of segments.
    pub(crate) fn steps(&self) -> impl DoubleEndedIterator<Item = u32> {
        steps(self.points)
    }

    pub(crate) fn ribbon_bytes(&self, step: u32) -> u64 {
        u64::from(self.count) * u64::from(self.corners(step)) * CORNER_BYTES
    }

    pub(crate) fn gpu_bytes(&self) -> u64 {
        let growth = match &self.growth {
            StrandSource::Fur { stands } => stands.size(),
            StrandSource::Guided(guided) => {
                guided.triangles.size() + guided.guides.size() + guided.ballast.size() + guided.hairs.size()
            }
        };
        self.strands.size() + growth + self.tile.size()
    }
}

/// Bytes per corner of a ribbon, which stores position and light.
pub(crate) const CORNER_BYTES: u64 = 16;

/// Data of a strand that do not depend on the pose.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Strand {
    pub(crate) base_uv: [f32; 2],
    /// Vertex colour, unorm.
    pub(crate) color: u32,
    /// Bareness and wetness, unorm. The rest is the packed openness of the body at the strand.
    pub(crate) groom: u32,
    /// Index of the strand in the tile.
    pub(crate) of_tile: u32,
    /// Random number in 0..1. The strand is drawn if this number is below the share of strands that are drawn.
    pub(crate) selection: f32,
    pub(crate) lean: f32,
    pub(crate) fur_height: f32,
}

/// Surface position of a strand point: on a triangle of the mesh, or beside it in its plane.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct SurfacePoint {
    /// Vertex indices of the triangle.
    pub(crate) vertices: [u32; 3],
    /// Barycentric weights of the second and third corner; a quarter of each weight is stored, as snorm.
    pub(crate) weights: [i16; 2],
}

/// Constants shared by the strands of a part.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct StrandConstants {
    pub(crate) points: u32,
    /// Number of strands of the model.
    pub(crate) count: u32,
    /// Number of points of all dry strands of the tile.
    pub(crate) dry_points: u32,
    /// Radius that the largest stored value represents, metres.
    pub(crate) radius: f32,
    /// First strand of the part.
    pub(crate) first: u32,
    /// End of the part's strand range.
    pub(crate) end: u32,
    /// Share of the strands that are drawn.
    pub(crate) share: f32,
    /// Stride between the points that are used.
    pub(crate) step: u32,
}

pub(super) fn steps(points: u32) -> impl DoubleEndedIterator<Item = u32> {
    let pieces = points - 1;
    (1..=pieces).filter(move |step| pieces.is_multiple_of(*step))
}

/// Returns the mean, over the strands, of the greatest distance of a strand from the straight segments that connect
/// every `step`th of its points.
pub(super) fn mean_deviation<'a>(strands: impl Iterator<Item = &'a [Vec3]>, step: usize) -> f32 {
    let off_piece = |piece: &[Vec3]| {
        let (from, along) = (piece[0], piece[piece.len() - 1] - piece[0]);
        let off = |p: &Vec3| {
            let share = ((*p - from).dot(along) / along.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
            (*p - from).distance(share * along)
        };
        piece.iter().map(off).fold(0.0, f32::max)
    };
    let farthest = |strand: &[Vec3]| {
        let starts = (0..strand.len() - 1).step_by(step);
        starts.map(|k| off_piece(&strand[k..=k + step])).fold(0.0, f32::max)
    };
    let (sum, count) = strands.fold((0.0, 0u32), |(sum, n), strand| (sum + f64::from(farthest(strand)), n + 1));
    (sum / f64::from(count.max(1))) as f32
}
