//! Strands on the GPU, wherever they grow.

use crate::gpu::WORKGROUP;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use pelage_formats::GroupMotion;
use std::ops::Range;

/// Most strands of a coat that are drawn into the shadow map of strands.
const MOST_SHADOWING: f32 = 100_000.0;

/// Strands of a model that have as many points each: those of its coat, or a group of hair.
#[derive(Debug)]
pub(crate) struct Strands {
    /// What each is, [`Strand`].
    pub(crate) strands: wgpu::Buffer,
    /// How they grow.
    pub(crate) growth: Growth,
    /// Points of the tile's strands as the package stores them, dry, and wet behind those; of a group, radius and colour of its hairs in the same form.
    pub(crate) tile: wgpu::Buffer,
    /// Of how many points each is.
    pub(crate) points: u32,
    /// How many there are.
    pub(crate) count: u32,
    /// Which of them each part of the manifest has: whole workgroups.
    pub(crate) of_parts: Vec<Range<u32>>,
    /// Of the tile's strands: points of all that are dry, and the largest radius in metres.
    pub(super) dry_points: u32,
    pub(super) radius: f32,
    /// Width of the tile's dry strands over all their points, metres.
    pub(crate) mean_width_m: f32,
    /// How far the mean dry strand of the tile bends away from what is left of it when every so many points is drawn, metres, for each of
    /// [`Self::steps`].
    pub(crate) bent_m: Vec<f32>,
    /// The least chance in each workgroup of them; none where they stand in no order of chances.
    pub(super) least_chances: Vec<f32>,
}

/// How strands grow: what their points are posed from.
#[derive(Debug)]
pub(crate) enum Growth {
    /// A coat: where each point of each stands on the skin, [`Stand`].
    Coat {
        /// All of them, dry; behind those of wet hair.
        stands: wgpu::Buffer,
    },
    /// A group of hair that follows guides.
    Guided(Guided),
}

/// Hair on guides.
#[derive(Debug)]
pub(crate) struct Guided {
    /// Of each guide the corners of its triangle, and the weights of the second and the third of its root, unorm.
    pub(crate) triangles: wgpu::Buffer,
    /// Points of the guides at rest, relative to their roots in the frames of those triangles.
    pub(crate) guides: wgpu::Buffer,
    /// What holds them up at rest, in those frames.
    pub(crate) ballast: wgpu::Buffer,
    /// How they move; `None` where they do not.
    pub(crate) motion: Option<GroupMotion>,
    /// How many guides there are.
    pub(crate) guide_count: u32,
    /// What each hair follows, [`HairRoot`].
    pub(crate) hairs: wgpu::Buffer,
    /// How far it reaches from the skin, metres.
    pub(crate) reach_m: f32,
    /// Which of the package's fibres it is.
    pub(crate) fibre: u32,
}

/// Where a hair of a group roots, and what it follows.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct HairRoot {
    /// Corners.
    pub(crate) vertices: [u32; 3],
    /// Weights of the second and the third, unorm.
    pub(crate) weights: [u16; 2],
    /// Guides.
    pub(crate) guides: [u16; 4],
    /// Weights of those, unorm.
    pub(crate) shares: [u8; 4],
    /// Of the guides' length.
    pub(crate) length: f32,
    /// How far its tip is aside of what it follows, in the frame of its triangle, metres.
    pub(crate) aside: [f32; 3],
    pub(crate) reserved: u32,
}

impl Strands {
    /// Where it follows guides, those.
    pub(crate) fn guided(&self) -> Option<&Guided> {
        match &self.growth {
            Growth::Coat { .. } => None,
            Growth::Guided(guided) => Some(guided),
        }
    }

    /// What the strands of a part have in common: that `share` of them is looked at, every `step`th point, so much wider than they grow.
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

    /// Share of them that throws shadows on each other, each as much wider: all that guides lead, and of a coat as many as a map can tell apart.
    pub(crate) fn shadow_share(&self) -> f32 {
        match self.growth {
            Growth::Coat { .. } => (MOST_SHADOWING / self.count.max(1) as f32).min(1.0),
            Growth::Guided(_) => 1.0,
        }
    }

    /// Those of a part among which all are whose chance is below `share`: whole workgroups.
    pub(crate) fn in_front(&self, part: &Range<u32>, share: f32) -> Range<u32> {
        let groups = (part.start / WORKGROUP) as usize..part.end.div_ceil(WORKGROUP) as usize;
        let Some(chances) = self.least_chances.get(groups) else { return part.clone() };
        // Where parts were joined that do not follow each other they are in order piece by piece.
        let count = chances.iter().rposition(|least| *least < share).map_or(0, |last| last as u32 + 1);
        part.start..(part.start + count * WORKGROUP).min(part.end)
    }

    /// Bytes of the pearls of guides that may move: two vectors for each of their points, and four for their frames.
    pub(crate) fn pearl_bytes(&self) -> Option<u64> {
        let guided = self.guided().filter(|guided| guided.motion.is_some())?;
        Some(u64::from(guided.guide_count) * u64::from(2 * self.points + 4) * 16)
    }

    /// Bytes of their posed points: two vectors of the skin's frame, then the points.
    pub(crate) fn posed_bytes(&self) -> u64 {
        u64::from(self.count) * u64::from(self.points + 2) * 16
    }

    /// Corners of the ribbon of a strand of which every `step`th point is drawn: two a point.
    fn corners(&self, step: u32) -> u32 {
        2 * (self.pieces(step) + 1)
    }

    /// Pieces of such a ribbon, each of two triangles.
    pub(crate) fn pieces(&self, step: u32) -> u32 {
        (self.points - 1) / step
    }

    /// Every how many points may be drawn: what a strand's pieces can be divided by.
    pub(crate) fn steps(&self) -> impl DoubleEndedIterator<Item = u32> {
        steps(self.points)
    }

    /// Bytes of the ribbons of all.
    pub(crate) fn ribbon_bytes(&self, step: u32) -> u64 {
        u64::from(self.count) * u64::from(self.corners(step)) * CORNER_BYTES
    }

    /// Bytes on the GPU.
    pub(crate) fn gpu_bytes(&self) -> u64 {
        let growth = match &self.growth {
            Growth::Coat { stands } => stands.size(),
            Growth::Guided(guided) => {
                guided.triangles.size() + guided.guides.size() + guided.ballast.size() + guided.hairs.size()
            }
        };
        self.strands.size() + growth + self.tile.size()
    }
}

/// Bytes of a corner of a ribbon: where it is, and its light.
pub(crate) const CORNER_BYTES: u64 = 16;

/// What a strand is, whatever the pose.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Strand {
    pub(crate) base_uv: [f32; 2],
    /// Of the vertices, unorm.
    pub(crate) color: u32,
    /// Bareness, wetness, unorm; what the body leaves open to it, packed.
    pub(crate) groom: u32,
    /// Which of the tile's it is.
    pub(crate) of_tile: u32,
    /// 0..1, for what is true of a share of all strands.
    pub(crate) chance: f32,
    pub(crate) lean: f32,
    pub(crate) fur_height: f32,
}

/// Where a point of a strand stands: on a triangle of the mesh, or beside it on its plane.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Stand {
    /// Corners.
    pub(crate) vertices: [u32; 3],
    /// Weights of the second and the third, snorm of a quarter.
    pub(crate) weights: [i16; 2],
}

/// What the strands of a part have in common.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct StrandConstants {
    pub(crate) points: u32,
    /// Of the model.
    pub(crate) count: u32,
    /// Points of the tile's dry strands.
    pub(crate) dry_points: u32,
    /// Metres.
    pub(crate) radius: f32,
    /// Of the part.
    pub(crate) first: u32,
    pub(crate) end: u32,
    /// Of them that is drawn.
    pub(crate) share: f32,
    /// Every how many points is looked at.
    pub(crate) step: u32,
}

pub(super) fn steps(points: u32) -> impl DoubleEndedIterator<Item = u32> {
    let pieces = points - 1;
    (1..=pieces).filter(move |step| pieces.is_multiple_of(*step))
}

/// How far the mean of some strands is, at most, from the straight pieces between every `step`th of its points.
pub(super) fn mean_bent<'a>(strands: impl Iterator<Item = &'a [Vec3]>, step: usize) -> f32 {
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
