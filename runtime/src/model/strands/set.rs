//! Strands on the GPU, of fur and of hair groups.

use crate::gpu::WORKGROUP;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use pelage_formats::GroupMotion;
use std::ops::Range;

/// Maximum number of fur strands drawn into the deep opacity map.
const MOST_SHADOWING: f32 = 100_000.0;

/// Strands of a model with the same number of points each: its fur strands, or a hair group.
#[derive(Debug)]
pub(crate) struct StrandSet {
    /// Buffer of [`Strand`], one per strand.
    pub(crate) strands: wgpu::Buffer,
    /// Source data from which points are posed.
    pub(crate) growth: StrandSource,
    /// Points of the tile's strands as stored in the package, dry, then wet. For a hair group: radius and colour of its
    /// hairs in the same format.
    pub(crate) tile: wgpu::Buffer,
    /// Points per strand.
    pub(crate) points: u32,
    /// Number of strands.
    pub(crate) count: u32,
    /// Strand range of each part of the manifest, in whole workgroups.
    pub(crate) of_parts: Vec<Range<u32>>,
    /// Number of points of all dry strands of the tile, and the largest radius in metres.
    pub(super) dry_points: u32,
    pub(super) radius: f32,
    /// Mean width of the tile's dry strands over all their points, metres.
    pub(crate) mean_width_m: f32,
    /// Deviation of the mean dry strand from its simplified form, metres, for each of [`Self::steps`].
    pub(crate) deviation_m: Vec<f32>,
    /// Smallest chance in each workgroup; empty if the strands are not sorted by chance.
    pub(super) least_chances: Vec<f32>,
}

/// Kinds of strands: the data from which their points are posed.
#[derive(Debug)]
pub(crate) enum StrandSource {
    /// Fur: the surface position of each point, [`SurfacePoint`].
    Fur {
        /// Points of all dry strands, followed by those of wet hair.
        stands: wgpu::Buffer,
    },
    /// Hair group that follows guides.
    Guided(Guided),
}

/// Guided hair.
#[derive(Debug)]
pub(crate) struct Guided {
    /// Triangle corners of each guide, and the weights of the second and third corner at its root, unorm.
    pub(crate) triangles: wgpu::Buffer,
    /// Guide points at rest, relative to their roots, in the frames of their triangles.
    pub(crate) guides: wgpu::Buffer,
    /// Accelerations that hold the guides in shape against gravity at rest, in the frames of their triangles.
    pub(crate) ballast: wgpu::Buffer,
    /// Motion parameters; `None` if the guides do not move.
    pub(crate) motion: Option<GroupMotion>,
    /// Number of guides.
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
    /// Triangle corners.
    pub(crate) vertices: [u32; 3],
    /// Weights of the second and third corner, unorm.
    pub(crate) weights: [u16; 2],
    /// Indices of the guides.
    pub(crate) guides: [u16; 4],
    /// Weights of the guides, unorm.
    pub(crate) shares: [u8; 4],
    /// Length relative to the guides.
    pub(crate) length: f32,
    /// Offset of the tip from the interpolated guides, in the frame of the root triangle, metres.
    pub(crate) aside: [f32; 3],
    pub(crate) reserved: u32,
}

impl StrandSet {
    /// Returns the guided hair, if the strands follow guides.
    pub(crate) fn guided(&self) -> Option<&Guided> {
        match &self.growth {
            StrandSource::Fur { .. } => None,
            StrandSource::Guided(guided) => Some(guided),
        }
    }

    /// Returns the constants shared by the strands of a part: `share` of them is used, every `step`th point, at
    /// `widened` times their natural width.
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

    /// Returns the share of strands drawn into the deep opacity map, each correspondingly wider: all guided hairs, and
    /// as many fur strands as a map can resolve.
    pub(crate) fn shadow_share(&self) -> f32 {
        match self.growth {
            StrandSource::Fur { .. } => (MOST_SHADOWING / self.count.max(1) as f32).min(1.0),
            StrandSource::Guided(_) => 1.0,
        }
    }

    /// Returns the range of a part that contains all strands whose chance is below `share`, in whole workgroups.
    pub(crate) fn prefix_below(&self, part: &Range<u32>, share: f32) -> Range<u32> {
        let groups = (part.start / WORKGROUP) as usize..part.end.div_ceil(WORKGROUP) as usize;
        let Some(chances) = self.least_chances.get(groups) else { return part.clone() };
        // Where non-adjacent parts were joined, the order holds only within each piece.
        let count = chances.iter().rposition(|least| *least < share).map_or(0, |last| last as u32 + 1);
        part.start..(part.start + count * WORKGROUP).min(part.end)
    }

    /// Returns the size in bytes of the particles of movable guides: two vectors per point, and four for their frames.
    pub(crate) fn particle_bytes(&self) -> Option<u64> {
        let guided = self.guided().filter(|guided| guided.motion.is_some())?;
        Some(u64::from(guided.guide_count) * u64::from(2 * self.points + 4) * 16)
    }

    /// Returns the size in bytes of the posed points: two vectors of the surface frame per strand, then its points.
    pub(crate) fn posed_bytes(&self) -> u64 {
        u64::from(self.count) * u64::from(self.points + 2) * 16
    }

    /// Returns the corners of a ribbon that uses every `step`th point: two per point.
    fn corners(&self, step: u32) -> u32 {
        2 * (self.segments(step) + 1)
    }

    /// Returns the segments of such a ribbon, each of two triangles.
    pub(crate) fn segments(&self, step: u32) -> u32 {
        (self.points - 1) / step
    }

    /// Returns the possible strides between drawn points: divisors of a strand's number of segments.
    pub(crate) fn steps(&self) -> impl DoubleEndedIterator<Item = u32> {
        steps(self.points)
    }

    /// Returns the size in bytes of all ribbons.
    pub(crate) fn ribbon_bytes(&self, step: u32) -> u64 {
        u64::from(self.count) * u64::from(self.corners(step)) * CORNER_BYTES
    }

    /// Returns the size on the GPU in bytes.
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

/// Bytes per corner of a ribbon: its position and its light.
pub(crate) const CORNER_BYTES: u64 = 16;

/// Pose-independent data of a strand.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Strand {
    pub(crate) base_uv: [f32; 2],
    /// Vertex colour, unorm.
    pub(crate) color: u32,
    /// Bareness and wetness, unorm; openness of the body at the strand, packed.
    pub(crate) groom: u32,
    /// Index of the tile's strand.
    pub(crate) of_tile: u32,
    /// Random number in 0..1 that selects a share of all strands.
    pub(crate) selection: f32,
    pub(crate) lean: f32,
    pub(crate) fur_height: f32,
}

/// Surface position of a strand point: on a triangle of the mesh, or beside it in its plane.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct SurfacePoint {
    /// Triangle corners.
    pub(crate) vertices: [u32; 3],
    /// Weights of the second and third corner, as snorm of a quarter of the value.
    pub(crate) weights: [i16; 2],
}

/// Constants shared by the strands of a part.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct StrandConstants {
    pub(crate) points: u32,
    /// Number of strands of the model.
    pub(crate) count: u32,
    /// Points of the tile's dry strands.
    pub(crate) dry_points: u32,
    /// Radius in metres of the largest stored number.
    pub(crate) radius: f32,
    /// Range of strands of the part.
    pub(crate) first: u32,
    pub(crate) end: u32,
    /// Share of the strands that is drawn.
    pub(crate) share: f32,
    /// Stride between the points that are used.
    pub(crate) step: u32,
}

pub(super) fn steps(points: u32) -> impl DoubleEndedIterator<Item = u32> {
    let pieces = points - 1;
    (1..=pieces).filter(move |step| pieces.is_multiple_of(*step))
}

/// Returns the greatest mean distance of some strands from the straight segments between every `step`th of their
/// points.
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
