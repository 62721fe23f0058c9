//! Marks of vertices: amount of lines, emphasis of the head, darkness of the surface.

use super::target::ContourTarget;
use super::weld::Weld;
use crate::sample::{Encoding, Wrap, bilinear};
use glam::{Vec2, Vec3};
use pelage_formats::{ContourEdge, ContourMark};

/// Luminance weights of linear sRGB (ITU-R BT.709).
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);
/// Exponent from luminance to display brightness.
const DISPLAY_EXPONENT: f32 = 1.0 / 2.2;
/// Number of times that marks are averaged with those of neighbours, because textures vary between vertices.
const SMOOTHINGS: usize = 2;

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
    let mut sums = vec![(Vec2::ZERO, 0.0f32); count];
    let own = target.mesh.skin.iter().map(|skin| {
        let is_head = |joint: &u16| heads.get(usize::from(*joint)) == Some(&true);
        skin.joints.iter().zip(skin.weights).filter(|(joint, _)| is_head(joint)).map(|(_, weight)| weight).sum()
    });
    let emphasis: Vec<f32> = own.chain(std::iter::repeat(0.0)).take(count).collect();
    for ((representative, darkness), emphasis) in weld.representatives.iter().zip(darkness(target)).zip(emphasis) {
        let (sum, weight) = &mut sums[*representative as usize];
        *sum += Vec2::new(emphasis, darkness);
        *weight += 1.0;
    }
    let mut values: Vec<Vec2> = sums.iter().map(|(sum, weight)| *sum / weight.max(1.0)).collect();
    for _ in 0..SMOOTHINGS {
        let mut around: Vec<(Vec2, f32)> = values.iter().map(|value| (*value, 1.0)).collect();
        for [a, b] in edges.iter().map(|edge| edge.map(|v| v as usize)) {
            around[a] = (around[a].0 + values[b], around[a].1 + 1.0);
            around[b] = (around[b].0 + values[a], around[b].1 + 1.0);
        }
        values = around.into_iter().map(|(sum, weight)| sum / weight).collect();
    }
    let byte = |share: f32| (255.0 * share.clamp(0.0, 1.0)).round() as u8;
    let mark = |v: &u32| {
        let [emphasis, darkness] = values[*v as usize].to_array().map(byte);
        ContourMark { line: 255, emphasis, darkness, reserved: 0 }
    };
    weld.representatives.iter().map(mark).collect()
}

/// Returns the darkness of the surface at each vertex in display brightness: 0 for white, 1 for black.
fn darkness(target: &ContourTarget<'_>) -> Vec<f32> {
    let (mesh, colors) = (target.mesh, target.colors);
    let mut darkness = vec![0.0; mesh.positions.len()];
    for part in &mesh.parts {
        let Some(material) = colors.materials.get(part.material) else { continue };
        let image = material.image.and_then(|image| colors.images.get(image));
        let hair = colors.hair.get(part.material).copied().flatten();
        for v in mesh.triangles[part.first_triangle..part.first_triangle + part.triangle_count].iter().flatten() {
            let v = *v as usize;
            let mut color = Vec3::from_slice(&material.factor);
            if let Some([r, g, b, _]) = colors.vertices.get(v) {
                color *= Vec3::from([*r, *g, *b].map(|byte| f32::from(byte) / 255.0));
            }
            if let Some(image) = image {
                color *= bilinear(image, mesh.uvs[v], Wrap::Repeat, Encoding::Srgb).truncate();
            }
            let luminance = hair.map_or(color, Vec3::from).dot(LUMINANCE).clamp(0.0, 1.0);
            darkness[v] = 1.0 - libm::powf(luminance, DISPLAY_EXPONENT);
        }
    }
    darkness
}
