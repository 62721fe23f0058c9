//! Marks of vertices: amount of lines, emphasis of the head, darkness of the surface.

use super::target::ContourTarget;
use super::weld::Weld;
use crate::noise::smooth_step;
use glam::Vec3;
use pelage_formats::{ContourEdge, ContourMark, PaintStroke, StrokeKind, StrokePoint};

/// Luminance weights of linear sRGB (ITU-R BT.709).
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);
/// Exponent from luminance to display brightness.
const DISPLAY_EXPONENT: f32 = 1.0 / 2.2;
/// Number of times that marks are averaged with those of neighbours, because textures vary between vertices.
const SMOOTHINGS: usize = 2;
/// Distance from the axis of a bone stroke over which lines return, in half widths of the stroke. Rims of ears, which
/// are flat, are beyond it.
const BESIDE_BONE: [f32; 2] = [1.15, 1.45];
/// The same for an eye, whose stroke is in front of its ball.
const BESIDE_EYE: [f32; 2] = [2.0, 2.4];
/// Share of a bone stroke, from its root, over which lines end.
const ROOT: [f32; 2] = [0.04, 0.25];

/// Returns the marks of all vertices of the mesh.
///
/// * `heads`: whether each joint moves the head
pub(super) fn marks(
    target: &ContourTarget<'_>,
    weld: &Weld,
    edges: &[ContourEdge],
    heads: &[bool],
) -> Vec<ContourMark> {
    let count = weld.representatives.len();
    let mut sums = vec![(Vec3::ZERO, 0.0f32); count];
    let lines = line_amounts(target);
    let own = target.mesh.skin.iter().map(|skin| {
        let is_head = |joint: &u16| heads.get(usize::from(*joint)) == Some(&true);
        skin.joints.iter().zip(skin.weights).filter(|(joint, _)| is_head(joint)).map(|(_, weight)| weight).sum()
    });
    let emphasis: Vec<f32> = own.chain(std::iter::repeat(0.0)).take(count).collect();
    let values = lines.into_iter().zip(emphasis).zip(darkness(target));
    for (representative, ((line, emphasis), darkness)) in weld.representatives.iter().zip(values) {
        let (sum, weight) = &mut sums[*representative as usize];
        *sum += Vec3::new(line, emphasis, darkness);
        *weight += 1.0;
    }
    let mut values: Vec<Vec3> = sums.iter().map(|(sum, weight)| *sum / weight.max(1.0)).collect();
    for _ in 0..SMOOTHINGS {
        let mut around: Vec<(Vec3, f32)> = values.iter().map(|value| (*value, 1.0)).collect();
        for [a, b] in edges.iter().map(|edge| edge.map(|v| v as usize)) {
            around[a] = (around[a].0 + values[b], around[a].1 + 1.0);
            around[b] = (around[b].0 + values[a], around[b].1 + 1.0);
        }
        values = around.into_iter().map(|(sum, weight)| sum / weight).collect();
    }
    let byte = |share: f32| (255.0 * share.clamp(0.0, 1.0)).round() as u8;
    let mark = |v: &u32| {
        let [line, emphasis, darkness] = values[*v as usize].to_array().map(byte);
        ContourMark { line, emphasis, darkness, reserved: 0 }
    };
    weld.representatives.iter().map(mark).collect()
}

/// Returns the amount of lines at each vertex, 0..=1: that of the recipe; none on eyes and on parts that are painted
/// with a single stroke along their axis; those would be painted twice.
fn line_amounts(target: &ContourTarget<'_>) -> Vec<f32> {
    let positions = &target.rest.positions;
    let center = |point: &StrokePoint| {
        let middle = |side: &pelage_formats::StrokeAnchor| {
            let [a, b, c] = side.vertices.map(|v| positions[v as usize]);
            let [v, w] = side.weights.map(|w| f32::from(w) / 65535.0);
            a * (1.0 - v - w) + b * v + c * w
        };
        (middle(&point.sides[0]) + middle(&point.sides[1])) / 2.0
    };
    let of_recipe = target.ink.iter().map(|ink| f32::from(ink.line) / 255.0);
    let mut amounts: Vec<f32> = of_recipe.chain(std::iter::repeat(1.0)).take(positions.len()).collect();
    let strokes = target.painting.map_or(&[][..], |pool| &pool.strokes);
    for stroke in strokes.iter().filter(|stroke| matches!(stroke.kind, StrokeKind::Bone | StrokeKind::Eye)) {
        let is_eye = stroke.kind == StrokeKind::Eye;
        let beside = if is_eye { BESIDE_EYE } else { BESIDE_BONE };
        let axis: Vec<(Vec3, f32)> = stroke.points.iter().map(|p| (center(p), p.half_width_m.max(1e-9))).collect();
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for (p, half) in &axis {
            (low, high) = (low.min(*p - beside[1] * half), high.max(*p + beside[1] * half));
        }
        for (p, amount) in positions.iter().zip(&mut amounts) {
            if p.cmplt(low).any() || p.cmpgt(high).any() {
                continue;
            }
            for (k, pair) in axis.windows(2).enumerate() {
                let [(from, first), (to, second)] = [pair[0], pair[1]];
                let along = ((*p - from).dot(to - from) / from.distance_squared(to).max(1e-20)).clamp(0.0, 1.0);
                let off = p.distance(from.lerp(to, along)) / (first + (second - first) * along);
                let u = (k as f32 + along) / (PaintStroke::POINTS - 1) as f32;
                let begun = if is_eye { 1.0 } else { smooth_step(ROOT[0], ROOT[1], u) };
                let covered = begun * (1.0 - smooth_step(beside[0], beside[1], off));
                *amount = amount.min(1.0 - covered);
            }
        }
    }
    amounts
}

/// Returns the darkness of the surface at each vertex in display brightness: 0 for white, 1 for black.
fn darkness(target: &ContourTarget<'_>) -> Vec<f32> {
    let (mesh, colors) = (target.mesh, target.colors);
    let mut darkness = vec![0.0; mesh.positions.len()];
    for part in &mesh.parts {
        if part.material >= colors.materials.len() {
            continue;
        }
        let hair = colors.hair.get(part.material).copied().flatten();
        for triangle in &mesh.triangles[part.first_triangle..part.first_triangle + part.triangle_count] {
            for (v, corner) in triangle.iter().zip([Vec3::X, Vec3::Y, Vec3::Z]) {
                let color = hair.map_or_else(|| colors.at(mesh, part.material, triangle, corner), Vec3::from);
                let luminance = color.dot(LUMINANCE).clamp(0.0, 1.0);
                darkness[*v as usize] = 1.0 - libm::powf(luminance, DISPLAY_EXPONENT);
            }
        }
    }
    darkness
}
