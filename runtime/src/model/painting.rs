//! Strokes with which a model is painted, in GPU memory.

use super::strands::SurfacePoint;
use super::upload::Uploader;
use crate::error::RuntimeError;
use bytemuck::{Pod, Zeroable};
use pelage_formats::meaning::linear_to_srgb;
use pelage_formats::{Package, PaintStroke, StrokeAnchor, StrokeKind, StrokePoint};

/// Strokes of a model's surface.
#[derive(Debug)]
pub(crate) struct ModelPainting {
    /// Buffer of [`PoolStroke`]s, sorted by kind.
    pub(crate) strokes: wgpu::Buffer,
    /// Buffer of [`PoolPoint`]s, [`PaintStroke::POINTS`] for each stroke.
    pub(crate) points: wgpu::Buffer,
    /// Kind of each stroke.
    pub(crate) kinds: Vec<u32>,
    /// Number of strokes.
    pub(crate) count: u32,
    /// Whether any stroke has a pigment.
    pub(crate) has_pigments: bool,
    /// Number of washes, which come first.
    pub(crate) washes: u32,
    /// Number of strokes of kind [`StrokeKind::Dark`], and of tufts.
    pub(crate) darks: u32,
    pub(crate) tufts: u32,
    /// Diagonal of the model's bounding box at rest, metres.
    pub(crate) size_m: f32,
    /// Half the length of the wash on the ground, metres.
    pub(crate) reach_m: f32,
}

/// Stroke as declared in `painting/strokes.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct PoolStroke {
    pub(crate) kind: u32,
    pub(crate) rank: f32,
    pub(crate) seed: u32,
    /// Pigment, sRGB, eight bits each; then 255 if there is one.
    pub(crate) pigment: u32,
}

/// Point of a stroke as declared in `painting/strokes.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct PoolPoint {
    pub(crate) sides: [SurfacePoint; 2],
    /// Half width, metres; darkness of the surface; 1 for points along an axis or in hair; 1 in hair, where the second
    /// side holds the bits of an offset.
    pub(crate) brush: [f32; 4],
}

/// Kind of the strokes on the ground, which come first. They have no points on the surface.
const GROUND: u32 = 8;
/// Number of strokes on the ground.
const GROUND_STROKES: u32 = 2;

fn is_wash(stroke: &PaintStroke) -> bool {
    matches!(stroke.kind, StrokeKind::Pale | StrokeKind::Middle)
}

fn pool_point(point: &StrokePoint) -> PoolPoint {
    // The bits of unsigned weights.
    let side = |at: StrokeAnchor| SurfacePoint { vertices: at.vertices, weights: at.weights.map(|w| w as i16) };
    let mut sides = point.sides.map(side);
    if let Some(offset) = point.offset_m {
        sides[1] = SurfacePoint { vertices: offset.map(f32::to_bits), weights: [0; 2] };
    }
    let flag = |is_set: bool| f32::from(u8::from(is_set));
    let in_hair = point.offset_m.is_some();
    let on_axis = in_hair || point.sides[0] != point.sides[1];
    PoolPoint { sides, brush: [point.half_width_m, point.darkness, flag(on_axis), flag(in_hair)] }
}

/// Uploads the strokes. Returns them with their size in bytes; `None` for a package without any.
pub(super) fn load(
    uploader: &Uploader<'_>,
    package: &Package<'_>,
) -> Result<Option<(ModelPainting, u64)>, RuntimeError> {
    let Some(pool) = package.stroke_pool()?.filter(|pool| !pool.strokes.is_empty()) else { return Ok(None) };
    let mut sorted: Vec<&PaintStroke> = pool.strokes.iter().collect();
    sorted.sort_by_key(|stroke| stroke.kind as u32);
    let count = |wanted: &dyn Fn(&PaintStroke) -> bool| sorted.iter().filter(|stroke| wanted(stroke)).count() as u32;
    let byte = linear_to_srgb;
    let on_ground = |k: u32| PoolStroke { kind: GROUND, rank: 0.0, seed: 77 + k, pigment: 0 };
    let of_surface = sorted.iter().map(|stroke| PoolStroke {
        kind: stroke.kind as u32,
        rank: stroke.rank,
        seed: stroke.seed,
        pigment: stroke.pigment.map_or(0, |[r, g, b]| u32::from_le_bytes([byte(r), byte(g), byte(b), 255])),
    });
    let strokes: Vec<PoolStroke> = (0..GROUND_STROKES).map(on_ground).chain(of_surface).collect();
    let on_ground = std::iter::repeat_n(PoolPoint::zeroed(), GROUND_STROKES as usize * PaintStroke::POINTS);
    let of_surface = sorted.iter().flat_map(|stroke| &stroke.points).map(pool_point);
    let points: Vec<PoolPoint> = on_ground.chain(of_surface).collect();
    let bounds = &package.manifest().bounds;
    let [length, width] = [0, 2].map(|k| bounds.max[k] - bounds.min[k]);
    use wgpu::BufferUsages as Usage;
    let painting = ModelPainting {
        strokes: uploader.buffer("strokes", bytemuck::cast_slice(&strokes), Usage::STORAGE)?,
        points: uploader.buffer("points of strokes", bytemuck::cast_slice(&points), Usage::STORAGE)?,
        kinds: strokes.iter().map(|stroke| stroke.kind).collect(),
        count: strokes.len() as u32,
        has_pigments: strokes.iter().any(|stroke| stroke.pigment != 0),
        washes: GROUND_STROKES + count(&is_wash),
        darks: count(&|stroke| stroke.kind == StrokeKind::Dark),
        tufts: count(&|stroke| stroke.kind == StrokeKind::Tuft),
        size_m: pool.size_m,
        reach_m: 0.5 * length.max(width),
    };
    let bytes = painting.strokes.size() + painting.points.size();
    Ok(Some((painting, bytes)))
}
