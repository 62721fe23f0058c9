//! Simplified index lists: fewer triangles over the same vertices, for models that are small on screen.
//!
//! A layer of hair is a copy of the mesh surface, displaced along the normals by up to the fur's height, and shows the
//! tile. So the collapse of an edge must preserve more than the position of the surface. It must also preserve the
//! position of the outermost layer, the texels of the tile there, the colour of the surface, and its motion with
//! joints. All of these are measured in metres.

use super::cells::closest_barycentric;
use super::triangle_tree::TriangleTree;
use crate::progress::StageProgress;
use glam::{Mat4, Vec3};
use meshopt::{SimplifyOptions, VertexDataAdapter, simplify_scale, simplify_with_attributes_and_locks};
use obvhs::triangle::Triangle;
use pelage_formats::{Animation, MeshData, Part, SimplifiedLevel};
use rayon::prelude::*;
use std::borrow::Cow;

/// Number of values per vertex, besides its position, that a collapse should preserve.
const ATTRIBUTES: usize = 17;
/// Weight of a shift of the tile along the mesh surface, relative to a displacement of the surface. It is low because a
/// small shift of the strands is hardly visible.
const TILE_SHARE: f32 = 0.3;
/// Weight of a change from black to white or from full fur to none. It is the equivalent displacement, as a share of
/// the model's size. [`NORMAL_SHARE`] is the weight of a normal turned by one radian.
const COLOR_SHARE: f32 = 0.03;
const NORMAL_SHARE: f32 = 0.01;
/// Minimum number of triangles in the smallest list. Rendering fewer saves next to nothing.
const FEWEST: usize = 64;
/// Number of triangles above which only the first two lists are made from the whole mesh, and each further pair from
/// the list before it. The lists of such a mesh then take as long as three of them, instead of a dozen.
const LARGE: usize = 80_000;
/// Maximum number of triangles in a list, as a share of the previous list's.
const SHARE: f32 = 0.7;

/// Returns lists of half, a quarter, an eighth … of the triangles, as far as patches, borders and materials permit.
/// There are none if parts share vertices, because the triangles of a list could then not be assigned to parts.
///
/// * `progress`: counter of the lists
pub fn levels(
    mesh: &MeshData,
    parts: &[Part],
    animation: Option<&Animation>,
    tile_size_m: f32,
    progress: &StageProgress,
) -> Vec<SimplifiedLevel> {
    let Some(part_of) = part_of_vertices(mesh, parts) else { return Vec::new() };
    let Ok(vertices) = VertexDataAdapter::new(bytemuck::cast_slice(&mesh.geometry), 48, 0) else { return Vec::new() };
    let size_m = simplify_scale(&vertices);
    if !(size_m > 0.0 && size_m.is_finite()) {
        return Vec::new();
    }
    let attributes = attributes(mesh, animation, tile_size_m, size_m);
    let unlocked = vec![false; mesh.geometry.len()];
    let simpler = |from: &[u32], triangles: usize| {
        simplify_with_attributes_and_locks(
            from,
            &vertices,
            &attributes,
            &[1.0; ATTRIBUTES],
            4 * ATTRIBUTES,
            &unlocked,
            3 * triangles,
            f32::MAX,
            if from.len() < mesh.indices.len() { SimplifyOptions::Sparse } else { SimplifyOptions::None },
            // The error output covers positions only, not the attributes.
            None,
        )
    };
    let halves: Vec<usize> =
        std::iter::successors(Some(mesh.indices.len() / 6), |n| Some(n / 2)).take_while(|n| *n >= FEWEST).collect();
    let (mut found, mut before, mut deviation_m) = (Vec::new(), mesh.indices.len(), 0.0f32);
    // Lists of ordinary meshes are made from the whole mesh, so several lists can be made in parallel. Some may then
    // turn out not to be needed.
    let large = mesh.indices.len() > 3 * LARGE;
    let mut from = Cow::from(&mesh.indices);
    for some in halves.chunks(if large { 2 } else { rayon::current_num_threads() }) {
        progress.add("textures", some.len() as u64);
        let some: Vec<(Vec<u32>, f32)> = some
            .par_iter()
            .map(|triangles| simpler(&from, *triangles))
            .map(|list| {
                let measured = if list.is_empty() { 0.0 } else { deviation(mesh, &attributes, &list, size_m) };
                progress.step("textures");
                (list, measured)
            })
            .collect();
        for (list, measured) in some {
            if list.len() as f32 > SHARE * before as f32 || list.is_empty() {
                return found;
            }
            before = list.len();
            // The deviation of a flat sheet is 0, but each list must have a larger deviation than the previous one.
            deviation_m = (size_m * measured).max(deviation_m * 1.01).max(1e-6 * size_m);
            let mut lists = vec![Vec::new(); parts.len()];
            for triangle in list.chunks_exact(3) {
                lists[part_of[triangle[0] as usize] as usize].extend_from_slice(triangle);
            }
            let part_counts = lists.iter().map(|list| list.len() as u32).collect();
            found.push(SimplifiedLevel { deviation_m, part_counts, indices: lists.concat() });
            if large {
                from = list.into();
            }
        }
    }
    found
}

/// Maximum number of vertices whose deviation is measured. It is enough to determine the share of [`DEVIATING`]
/// vertices within 0.01.
const MEASURED: usize = 20_000;
/// Share of the removed vertices that may deviate by more than the value stated for a list.
const DEVIATING: f32 = 0.05;

/// Returns the deviation of a list from the mesh, as a share of the mesh's size. Each removed vertex is compared with
/// the most similar point on the list's triangles. All but a share of [`DEVIATING`] are within the returned deviation.
fn deviation(mesh: &MeshData, attributes: &[f32], list: &[u32], size_m: f32) -> f32 {
    let place = |v: u32| Vec3::from(mesh.geometry[v as usize].position) / size_m;
    let kept: Vec<bool> = list.iter().fold(vec![false; mesh.geometry.len()], |mut kept, v| {
        kept[*v as usize] = true;
        kept
    });
    let mut gone: Vec<u32> = mesh.indices.iter().copied().filter(|v| !kept[*v as usize]).collect();
    gone.sort_unstable();
    gone.dedup();
    if gone.is_empty() {
        return 0.0;
    }
    let triangles: Vec<[u32; 3]> = list.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    let facet = |t: &[u32; 3]| Triangle { v0: place(t[0]).into(), v1: place(t[1]).into(), v2: place(t[2]).into() };
    let tree = TriangleTree::new(&triangles.iter().map(facet).collect::<Vec<_>>());
    let step = gone.len().div_ceil(MEASURED);
    let of = |v: &u32| {
        let numbers = |v: u32| &attributes[ATTRIBUTES * v as usize..][..ATTRIBUTES];
        // Squared distance between the vertex and the nearest point of a triangle, attributes included; `best` if the
        // squared distance of the positions alone is at least that.
        let square_to = |t: u32, best: f32| {
            let t = &triangles[t as usize];
            let [a, b, c] = t.map(place);
            let weights = closest_barycentric(place(*v), [a, b, c]);
            let moved = (place(*v) - (weights.x * a + weights.y * b + weights.z * c)).length_squared();
            if moved >= best {
                return best;
            }
            let square = |wanted: f32, found: [f32; 3]| {
                let apart = Vec3::from(found).dot(weights) - wanted;
                apart * apart
            };
            let corners = t.map(numbers);
            let rest = (0..ATTRIBUTES).map(|i| square(numbers(*v)[i], corners.map(|of| of[i]))).sum::<f32>();
            moved + rest
        };
        tree.minimum(place(*v), square_to).sqrt()
    };
    let mut found: Vec<f32> = gone.par_iter().step_by(step).map(of).filter(|d| d.is_finite()).collect();
    found.sort_by(f32::total_cmp);
    found.get((found.len() as f32 * (1.0 - DEVIATING)) as usize).or(found.last()).copied().unwrap_or_default()
}

/// Returns the part that uses each vertex; `None` if two parts share one.
fn part_of_vertices(mesh: &MeshData, parts: &[Part]) -> Option<Vec<u32>> {
    let mut found = vec![u32::MAX; mesh.geometry.len()];
    for (number, part) in (0..).zip(parts) {
        for index in &mesh.indices[part.first_index as usize..][..part.index_count as usize] {
            let slot = &mut found[*index as usize];
            if *slot != u32::MAX && *slot != number {
                return None;
            }
            *slot = number;
        }
    }
    Some(found)
}

/// Returns the values of each vertex that a collapse should preserve, as lengths divided by the model's size.
fn attributes(mesh: &MeshData, animation: Option<&Animation>, tile_size_m: f32, size_m: f32) -> Vec<f32> {
    let origin = |inverse_bind| Mat4::from_cols_array(inverse_bind).inverse().w_axis.truncate();
    let origins: Vec<Vec3> =
        animation.iter().flat_map(|a| &a.joints).map(|joint| origin(&joint.inverse_bind)).collect();
    let unit = |byte: u8, share: f32| f32::from(byte) / 255.0 * share;
    let of = |i: usize| -> [f32; ATTRIBUTES] {
        let (at, skin) = (&mesh.geometry[i], &mesh.attributes[i]);
        let normal = Vec3::from(at.normal);
        let outermost = normal * at.fur_height / size_m;
        // Weighted mean of the positions of a vertex's joints. Vertices that move differently depend on different
        // joints, so their means differ.
        let held = mesh.skin.get(i).map_or(Vec3::ZERO, |v| {
            let joints = v.joints.iter().zip(v.weights);
            joints.map(|(joint, weight)| weight * origins.get(usize::from(*joint)).copied().unwrap_or_default()).sum()
        }) / size_m;
        let held = if held.is_finite() { held } else { Vec3::ZERO };
        let [u, v] = skin.tile_uv.map(|t| t * tile_size_m * TILE_SHARE / size_m);
        let turned = normal * NORMAL_SHARE;
        let [red, green, blue, _] = skin.color.map(|c| unit(c, COLOR_SHARE));
        let [bare, wet, ..] = skin.groom.map(|g| unit(g, COLOR_SHARE));
        let lean = at.lean * at.fur_height / size_m;
        [
            outermost.x,
            outermost.y,
            outermost.z,
            held.x,
            held.y,
            held.z,
            u,
            v,
            turned.x,
            turned.y,
            turned.z,
            red,
            green,
            blue,
            bare,
            wet,
            lean,
        ]
    };
    (0..mesh.geometry.len()).flat_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_formats::{AttributeVertex, GeometryVertex};

    /// Makes a grid of n × n squares over a unit square, in two parts side by side. The grid bulges by `bulge`, and
    /// `color` returns its red channel.
    fn grid(n: usize, bulge: f32, color: impl Fn(f32, f32) -> u8) -> (MeshData, Vec<Part>) {
        let mut mesh = MeshData::default();
        let mut parts = Vec::new();
        for half in 0..2 {
            let first = mesh.geometry.len();
            let first_index = mesh.indices.len() as u32;
            for y in 0..=n {
                for x in 0..=n / 2 {
                    let (u, v) = ((x + half * n / 2) as f32 / n as f32, y as f32 / n as f32);
                    let z = bulge * (1.0 - (2.0 * u - 1.0).powi(2)) * (1.0 - (2.0 * v - 1.0).powi(2));
                    mesh.geometry.push(GeometryVertex {
                        position: [u, v, z],
                        fur_height: 0.05,
                        normal: [0.0, 0.0, 1.0],
                        tangent: [1.0, 0.0, 0.0, 1.0],
                        lean: 0.0,
                    });
                    mesh.attributes.push(AttributeVertex {
                        tile_uv: [4.0 * u, 4.0 * v],
                        color: [color(u, v), 0, 0, 255],
                        ..AttributeVertex::default()
                    });
                }
            }
            let at = |x: usize, y: usize| (first + y * (n / 2 + 1) + x) as u32;
            for y in 0..n {
                for x in 0..n / 2 {
                    let (a, b, c, d) = (at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1));
                    mesh.indices.extend([a, b, c, a, c, d]);
                }
            }
            let index_count = mesh.indices.len() as u32 - first_index;
            parts.push(Part { material: half as u32, first_index, index_count });
        }
        (mesh, parts)
    }

    #[test]
    fn simplified_levels_halve_triangles_with_growing_deviation() {
        let (mesh, parts) = grid(32, 0.2, |_, _| 128);
        let levels = levels(&mesh, &parts, None, 0.25, StageProgress::ignored());
        assert!(levels.len() >= 3, "{} lists", levels.len());
        let mut before = SimplifiedLevel { indices: mesh.indices.clone(), ..SimplifiedLevel::default() };
        for level in levels {
            assert!(level.deviation_m > before.deviation_m && level.deviation_m < 0.1, "{}", level.deviation_m);
            assert!(level.indices.len() as f32 <= SHARE * before.indices.len() as f32);
            assert_eq!(level.part_counts.iter().sum::<u32>() as usize, level.indices.len());
            // The triangles of each part use only its own vertices.
            let (first, second) = level.indices.split_at(level.part_counts[0] as usize);
            let vertices = mesh.geometry.len() as u32 / 2;
            assert!(first.iter().all(|i| *i < vertices) && second.iter().all(|i| *i >= vertices));
            // No hole opens: seen from above, the list still covers the whole square.
            let corner = |i: u32| Vec3::from(mesh.geometry[i as usize].position).with_z(0.0);
            let area = |t: &[u32]| 0.5 * (corner(t[1]) - corner(t[0])).cross(corner(t[2]) - corner(t[0])).z;
            let covered: f32 = level.indices.chunks_exact(3).map(area).sum();
            assert!((covered - 1.0).abs() < 1e-3, "{covered} of the square is covered");
            before = level;
        }
    }

    #[test]
    fn colour_differences_count_as_deviation() {
        let (plain, parts) = grid(32, 0.0, |_, _| 128);
        let (speckled, _) = grid(32, 0.0, |u, v| if (437.0 * u + 911.0 * v).sin() < 0.0 { 255 } else { 0 });
        let first = |mesh| {
            levels(mesh, &parts, None, 0.25, StageProgress::ignored()).first().map(|level| level.deviation_m).unwrap()
        };
        assert!(first(&speckled) > 0.3 * COLOR_SHARE, "{}", first(&speckled));
        assert!(first(&plain) < 1e-3 * COLOR_SHARE, "{}", first(&plain));
    }

    #[test]
    fn parts_that_share_vertices_stay_as_they_are() {
        let (mut mesh, parts) = grid(16, 0.1, |_, _| 128);
        assert!(!levels(&mesh, &parts, None, 0.25, StageProgress::ignored()).is_empty());
        let shared = mesh.indices[0];
        *mesh.indices.last_mut().unwrap() = shared;
        assert!(levels(&mesh, &parts, None, 0.25, StageProgress::ignored()).is_empty());
        assert!(levels(&MeshData::default(), &[], None, 0.25, StageProgress::ignored()).is_empty());
    }
}
