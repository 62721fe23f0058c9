//! Strokes of a painted frame, read back from the device.

use super::buffers::BrushPoint;
use crate::contours::LineNode;
use bytemuck::pod_collect_to_vec;

/// Layer of a painting that a stroke belongs to, in the order in which they are painted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum StrokeLayer {
    /// Wash on the ground.
    Ground,
    /// Wash.
    Wash,
    /// Dark stroke over the washes.
    Dark,
    /// Thin part, painted with one stroke along its axis.
    Bone,
    /// Dark spot, such as a nose or a hoof.
    Spot,
    /// Eye.
    Eye,
    /// Contour line.
    Line,
    /// Tuft of fur, which a split brush leaves.
    Tuft,
    /// Lock of guided hair, which a split brush leaves.
    Lock,
}

/// Stroke of a painted frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureStroke {
    /// Number of the instance in the frame.
    pub instance: usize,
    /// Layer of the painting.
    pub layer: StrokeLayer,
    /// Number by which the stroke is the same in other frames. Lines have new numbers in each frame.
    pub number: u32,
    /// Points from the beginning to the end. The first and last may be invisible, because strokes fade towards them.
    pub marks: Vec<StrokeMark>,
}

/// Point of a stroke in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrokeMark {
    /// Position, pixels from the upper left corner.
    pub position: [f32; 2],
    /// Half width, pixels, at least 0.
    pub half_width: f32,
    /// Optical density of the ink, at least 0.
    pub density: f32,
    /// Dryness of the brush, 0 for wet to 1.
    pub dryness: f32,
}

/// Half width up to which a stroke is not visible, pixels, and the same for density.
const FAINT: [f32; 2] = [0.12, 0.02];

/// Layer by the kind of a stroke in `painting/strokes.wgsl`.
fn layer(kind: u32) -> StrokeLayer {
    match kind {
        0 | 1 => StrokeLayer::Wash,
        2 => StrokeLayer::Dark,
        3 => StrokeLayer::Bone,
        4 => StrokeLayer::Spot,
        5 => StrokeLayer::Eye,
        6 => StrokeLayer::Tuft,
        7 => StrokeLayer::Lock,
        _ => StrokeLayer::Ground,
    }
}

fn is_visible(mark: &StrokeMark) -> bool {
    mark.half_width > FAINT[0] && mark.density > FAINT[1]
}

/// Returns the visible strokes of the surface. `kinds`: of all strokes; `bytes`: their [`BrushPoint`]s.
pub(crate) fn surface_strokes(instance: usize, kinds: &[u32], bytes: &[u8]) -> Vec<PictureStroke> {
    let points: Vec<BrushPoint> = pod_collect_to_vec(bytes);
    let each = points.len() / kinds.len().max(1);
    let mark = |p: &BrushPoint| StrokeMark {
        position: [p.place[0], p.place[1]],
        half_width: p.place[3],
        density: p.brush[0],
        dryness: p.brush[1].clamp(0.0, 1.0),
    };
    let stroke = |(number, (kind, points)): (usize, (&u32, &[BrushPoint]))| {
        let marks: Vec<StrokeMark> = points.iter().map(mark).collect();
        let first = marks.iter().position(is_visible)?;
        let last = marks.iter().rposition(is_visible)?;
        let marks = marks[first.saturating_sub(1)..(last + 2).min(marks.len())].to_vec();
        Some(PictureStroke { instance, layer: layer(*kind), number: number as u32, marks })
    };
    kinds.iter().zip(points.chunks_exact(each.max(1))).enumerate().filter_map(stroke).collect()
}

/// Returns the visible contour lines. `bytes`: [`LineNode`]s; `count`: number of those that the frame wrote.
pub(crate) fn lines(instance: usize, count: usize, bytes: &[u8]) -> Vec<PictureStroke> {
    let nodes: Vec<LineNode> = pod_collect_to_vec(bytes);
    let nodes = &nodes[..count.min(nodes.len())];
    let mark = |node: &LineNode| StrokeMark {
        position: node.px,
        half_width: node.ends[3],
        density: node.brush[1],
        dryness: node.brush[2],
    };
    let is_drawn = |node: &LineNode| node.ends[0].min(node.ends[1]) > 0.0 && is_visible(&mark(node));
    let mut previous = vec![usize::MAX; nodes.len()];
    for (i, node) in nodes.iter().enumerate() {
        if let Some(previous) = previous.get_mut(node.next as usize) {
            *previous = i;
        }
    }
    let begins = |i: usize| nodes.get(previous[i]).is_none_or(|before| !is_drawn(before));
    // A closed line that is visible all around has no beginning, so that any node will do.
    let firsts = (0..nodes.len()).filter(|i| is_drawn(&nodes[*i]) && begins(*i));
    let all = firsts.chain(0..nodes.len());
    let mut is_taken = vec![false; nodes.len()];
    let mut strokes = Vec::new();
    for first in all {
        let (mut marks, mut at) = (Vec::new(), first);
        marks.extend(nodes.get(previous[first]).filter(|before| !is_drawn(before)).map(mark));
        while let Some(node) = nodes.get(at).filter(|node| is_drawn(node)) {
            if std::mem::replace(&mut is_taken[at], true) {
                break;
            }
            marks.push(mark(node));
            at = node.next as usize;
        }
        marks.extend(nodes.get(at).filter(|after| !is_drawn(after)).map(mark));
        if marks.iter().filter(|mark| is_visible(mark)).count() > 1 {
            strokes.push(PictureStroke { instance, layer: StrokeLayer::Line, number: first as u32, marks });
        }
    }
    strokes
}
