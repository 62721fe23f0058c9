//! Tips of a body's extremities, such as feet and the end of a snout, by topological persistence (Edelsbrunner,
//! Letscher and Zomorodian 2002).

use super::welded_mesh::WeldedMesh;
use crate::stages::groom::geodesic::geodesic_distances;
use pelage_import::union_find::root;

/// Minimum length of an extremity, in body radii.
const SHORTEST: f32 = 0.08;
/// Share of the surface, the thickest, from which the distances to the tips are measured.
const CORE: f64 = 0.2;

/// Returns the vertices at the tips of a body: local maxima of the distance from its thickest parts along the surface.
///
/// * `thickness`: thickness at each welded vertex
pub(super) fn tips(skin: &WeldedMesh, thickness: &[Option<f32>]) -> Vec<u32> {
    let Some(thick) = skin.quantile(thickness, 1.0 - CORE) else { return Vec::new() };
    let is_core = |place: &u32| thickness[*place as usize].is_some_and(|t| t >= thick);
    let core: Vec<(u32, f32)> = (0..skin.len() as u32).filter(is_core).map(|place| (place, 0.0)).collect();
    let away = geodesic_distances(skin, &core, f32::INFINITY);
    let farthest_first = |a: &u32, b: &u32| away[*b as usize].total_cmp(&away[*a as usize]).then(a.cmp(b));
    let mut order: Vec<u32> = (0..skin.len() as u32).filter(|place| away[*place as usize].is_finite()).collect();
    order.sort_unstable_by(farthest_first);
    let mut found: Vec<u32> = order.first().copied().into_iter().collect();
    // Farthest vertex of the connected part of each vertex, among the vertices that are at least as far away.
    let mut tip_of = vec![u32::MAX; skin.len()];
    for place in order {
        let mut joined: Vec<u32> = skin.neighbors_of(place).filter(|next| tip_of[*next as usize] != u32::MAX).collect();
        joined.iter_mut().for_each(|next| *next = root(&mut tip_of, *next));
        joined.sort_unstable_by(farthest_first);
        joined.dedup();
        let top = joined.first().copied().unwrap_or(place);
        tip_of[place as usize] = top;
        for lower in joined.into_iter().skip(1) {
            tip_of[lower as usize] = top;
            if away[lower as usize] - away[place as usize] >= SHORTEST {
                found.push(lower);
            }
        }
    }
    found
}
