//! Surface that morph targets hide at rest, and that a clip shows.

use super::normals::{NormalInput, complete_normals};
use super::notes::Notes;
use super::union_find::root;
use crate::mesh::{Mesh, MorphRows, RowDelta};
use glam::Vec3;
use pelage_formats::Animation;
use pelage_formats::meaning::{HIDDEN_SIZE, largest_shifts};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Maximum area of hidden surface, as a share of its area where a clip shows it.
const HIDDEN_AREA: f32 = HIDDEN_SIZE * HIDDEN_SIZE;
/// Minimum area of surface that a target shows, as a share of the largest area in the clips.
const SHOWN_AREA: f32 = 0.25;

/// Identity of a vertex: bits of its position, morph row, joints and bits of their weights.
type VertexKey = ([u32; 3], u32, [u16; 4], [u32; 4]);

/// Connected hidden surface.
#[derive(Default)]
struct Region {
    /// Position of one of its vertices at rest, in mesh space.
    anchor: Vec3,
    /// Double area by target.
    areas: BTreeMap<u32, f32>,
}

/// Moves the vertices of hidden surface to where a clip shows them by a morph target, and marks their deltas.
///
/// Surface is hidden at rest if its triangles have no area, or one below [`HIDDEN_AREA`]. At rest all vertices of
/// connected hidden surface get the same position. Vertices of visible triangles are unchanged.
pub(super) fn unfold(mesh: &mut Mesh, rows: &mut MorphRows, animation: &Animation) {
    let shifts = largest_shifts(animation);
    if shifts.iter().all(|shift| *shift == 0.0) {
        return;
    }
    let row_of = |v: u32| rows.0[mesh.morph_rows[v as usize] as usize].as_slice();
    let area = |triangle: [u32; 3], target: u32, shift: f32| {
        let [a, b, c] = triangle.map(|v| {
            let delta = row_of(v).iter().find(|delta| delta.target == target);
            mesh.positions[v as usize] + delta.map_or(Vec3::ZERO, |delta| delta.position * shift)
        });
        (b - a).cross(c - a).length()
    };
    let mut hidden: Vec<([u32; 3], BTreeMap<u32, f32>)> = Vec::new();
    let mut visible = Vec::new();
    for triangle in &mesh.triangles {
        let of_corners = triangle.iter().flat_map(|v| row_of(*v)).map(|delta| delta.target);
        let at_rest = area(*triangle, 0, 0.0);
        let areas = of_corners.map(|target| (target, shifts[target as usize])).filter(|(_, shift)| *shift != 0.0);
        let mut areas: BTreeMap<u32, f32> = areas.map(|(t, shift)| (t, area(*triangle, t, shift))).collect();
        areas.retain(|_, area| *area > 0.0 && at_rest <= HIDDEN_AREA * *area);
        if !areas.is_empty() {
            hidden.push((*triangle, areas));
        } else if at_rest > 0.0 {
            visible.push(*triangle);
        }
    }
    if hidden.is_empty() {
        return;
    }

    let key = |v: u32| -> VertexKey {
        let (v, bits) = (v as usize, |x: f32| (x + 0.0).to_bits());
        let skin = mesh.skin[v];
        (mesh.positions[v].to_array().map(bits), mesh.morph_rows[v], skin.joints, skin.weights.map(bits))
    };
    let visible: HashSet<VertexKey> = visible.iter().flatten().map(|v| key(*v)).collect();
    let mut points: HashMap<VertexKey, u32> = HashMap::new();
    let mut parents: Vec<u32> = Vec::new();
    let mut point_of: BTreeMap<u32, u32> = BTreeMap::new();
    for (triangle, _) in &hidden {
        let mut joined = None;
        for v in triangle.iter().filter(|v| !visible.contains(&key(**v))) {
            let point = *points.entry(key(*v)).or_insert_with(|| {
                parents.push(parents.len() as u32);
                parents.len() as u32 - 1
            });
            point_of.insert(*v, point);
            let root = root(&mut parents, point);
            parents[root as usize] = *joined.get_or_insert(root);
        }
    }
    let mut regions: BTreeMap<u32, Region> = BTreeMap::new();
    for (triangle, areas) in &hidden {
        let Some(v) = triangle.iter().find(|v| point_of.contains_key(v)) else { continue };
        let anchor = mesh.positions[*v as usize];
        let region = regions.entry(root(&mut parents, point_of[v]));
        let region = region.or_insert_with(|| Region { anchor, ..Region::default() });
        areas.iter().for_each(|(target, area)| *region.areas.entry(*target).or_default() += area);
    }
    for region in regions.values_mut() {
        let largest = region.areas.values().copied().fold(0.0, f32::max);
        region.areas.retain(|_, area| *area >= SHOWN_AREA * largest);
    }

    let mut row_of_point: HashMap<u32, u32> = HashMap::new();
    let mut unlit = Vec::new();
    for (v, point) in &point_of {
        let region = &regions[&root(&mut parents, *point)];
        let (v, position) = (*v as usize, mesh.positions[*v as usize]);
        let row = rows.0[mesh.morph_rows[v] as usize].clone();
        let Some((target, shift)) = region.areas.keys().next().map(|target| (*target, shifts[*target as usize])) else {
            continue;
        };
        let delta = row.iter().find(|delta| delta.target == target);
        mesh.positions[v] += delta.map_or(Vec3::ZERO, |delta| delta.position * shift);
        match delta.and_then(|delta| delta.normal) {
            Some(normal) => mesh.normals[v] = (mesh.normals[v] + normal * shift).normalize_or_zero(),
            None => mesh.normals[v] = Vec3::ZERO,
        }
        if mesh.normals[v] == Vec3::ZERO {
            unlit.push(v);
        }
        mesh.morph_rows[v] = *row_of_point.entry(*point).or_insert_with(|| {
            let shows = |target: &u32| {
                let delta = row.iter().find(|delta| delta.target == *target).map_or(Vec3::ZERO, |delta| delta.position);
                let position = delta + (position - region.anchor) / shifts[*target as usize];
                RowDelta { target: *target, position, normal: None, hidden_at: Some(region.anchor) }
            };
            let others = row.iter().copied().filter(|delta| !region.areas.contains_key(&delta.target));
            let mut row: Vec<RowDelta> = others.chain(region.areas.keys().map(shows)).collect();
            row.sort_by_key(|delta| delta.target);
            rows.0.push(row);
            rows.0.len() as u32 - 1
        });
    }
    if !unlit.is_empty() {
        let triangles: Vec<[u32; 3]> = hidden.iter().map(|(triangle, _)| *triangle).collect();
        let (label, positions, mut normals) = ("", &mesh.positions[..], mesh.normals.clone());
        let hidden = NormalInput { label, positions, triangles: &triangles, normals: &mut normals };
        complete_normals(&mut Notes::default(), &mut [hidden]);
        unlit.into_iter().for_each(|v| mesh.normals[v] = normals[v]);
    }
}
