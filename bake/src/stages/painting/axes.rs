//! Axes of limbs: curves through the centres of rings around legs, tails, ears and antlers.
//!
//! Rings are level sets of the distance from the trunk along the surface, and each ring continues the ring of the next
//! lower level on the same piece of surface (a Reeb graph, Reeb 1946). At a fork, the longest branch continues the
//! axis, and the others begin at it.

use super::canvas::{Canvas, anchor};
use glam::Vec3;
use pelage_formats::StrokeAnchor;
use pelage_import::union_find::root;

/// Thickness below which a part is a limb, in units of the model's size.
const LIMB: f32 = 0.06;
/// Distance between rings, in units of the model's size.
const STEP: f32 = 0.004;
/// Maximum number of rings along a limb.
const MOST_LEVELS: usize = 1000;
/// Minimum number of rings of an axis.
const LEAST_RINGS: usize = 8;

/// Point of an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisPoint {
    pub(super) sides: [StrokeAnchor; 2],
    pub(super) center: Vec3,
    /// Mean distance of the ring from its centre.
    pub(super) radius: f32,
    pub(super) darkness: f32,
}

/// Ring around a limb.
struct Ring {
    point: AxisPoint,
    /// Welded vertex above the ring.
    above: u32,
    parent: Option<usize>,
    level: usize,
}

/// Joins the sets of two elements. The smaller root wins, so that the result does not depend on the order.
fn join(parents: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parents, a), root(parents, b));
    parents[a.max(b) as usize] = a.min(b);
}

/// Axes of all limbs, and the distance of each welded vertex from the trunk.
pub(super) struct Axes {
    /// Axes from the trunk to the tip, the longest first.
    pub(super) axes: Vec<Vec<AxisPoint>>,
    /// Distance of each welded vertex from the trunk along the surface; 0 on the trunk, infinite on separate pieces.
    pub(super) distance: Vec<f32>,
}

pub(super) fn axes(canvas: &Canvas) -> Axes {
    let skin = &canvas.skin;
    let count = canvas.positions.len();
    // Smoothing removes the thin rims of thick parts.
    let thickness = skin.spread(&canvas.thickness, 0.05 / canvas.unit * 0.5);
    let mut trunk: Vec<u32> = (0..count as u32).filter(|p| thickness[*p as usize] >= LIMB).collect();
    if trunk.is_empty() {
        let thickest = (0..count as u32).max_by(|a, b| thickness[*a as usize].total_cmp(&thickness[*b as usize]));
        trunk.extend(thickest);
    }
    let distance: Vec<f32> = skin
        .distances(trunk.into_iter().map(|p| (p, 0.0)), f32::INFINITY)
        .into_iter()
        .map(|d| d * canvas.unit)
        .collect();
    let farthest = distance.iter().copied().filter(|d| d.is_finite()).fold(0.0, f32::max);
    let levels = ((farthest / STEP) as usize).min(MOST_LEVELS);
    let mut order: Vec<u32> = (0..count as u32).filter(|p| distance[*p as usize].is_finite()).collect();
    order.sort_by(|a, b| distance[*b as usize].total_cmp(&distance[*a as usize]).then(a.cmp(b)));
    let mut parents: Vec<u32> = (0..count as u32).collect();
    let mut rings: Vec<Ring> = Vec::new();
    let (mut added, mut upper) = (0, 0..0);
    for level in (0..=levels).rev() {
        let height = (level as f32 + 0.5) * STEP;
        while added < order.len() && distance[order[added] as usize] > height {
            let place = order[added];
            for next in skin.neighbors_of(place) {
                if distance[next as usize] > height {
                    join(&mut parents, place, next);
                }
            }
            added += 1;
        }
        let first = rings.len();
        rings.extend(rings_at(canvas, &distance, height).into_iter().map(|(point, above)| Ring {
            point,
            above,
            parent: None,
            level,
        }));
        for k in upper {
            let of = root(&mut parents, rings[k].above);
            rings[k].parent = (first..rings.len()).find(|j| root(&mut parents, rings[*j].above) == of);
        }
        upper = first..rings.len();
    }
    // Deepest first: the number of rings above each.
    let mut reach = vec![1_usize; rings.len()];
    for k in 0..rings.len() {
        if let Some(parent) = rings[k].parent {
            reach[parent] = reach[parent].max(reach[k] + 1);
        }
    }
    let mut is_parent = vec![false; rings.len()];
    rings.iter().filter_map(|ring| ring.parent).for_each(|parent| is_parent[parent] = true);
    let mut tips: Vec<usize> = (0..rings.len()).filter(|k| !is_parent[*k]).collect();
    tips.sort_by_key(|k| (std::cmp::Reverse(rings[*k].level), *k));
    let mut used = vec![false; rings.len()];
    let mut axes = Vec::new();
    for tip in tips {
        let mut axis = Vec::new();
        let mut at = Some(tip);
        while let Some(k) = at {
            axis.push(rings[k].point);
            if used[k] {
                break;
            }
            used[k] = true;
            at = rings[k].parent;
        }
        if axis.len() >= LEAST_RINGS {
            axis.reverse();
            axes.push(axis);
        }
    }
    Axes { axes, distance }
}

/// Returns the rings of a level set, each with a vertex above it.
fn rings_at(canvas: &Canvas, distance: &[f32], height: f32) -> Vec<(AxisPoint, u32)> {
    struct Crossing {
        ends: [u32; 2],
        share: f32,
        position: Vec3,
    }
    let mut crossings: Vec<Crossing> = Vec::new();
    let mut index_of = std::collections::BTreeMap::new();
    let mut links = Vec::new();
    for face in &canvas.skin.faces {
        let high = face.map(|p| distance[p as usize] > height);
        if high == [high[0]; 3] || face.iter().any(|p| !distance[*p as usize].is_finite()) {
            continue;
        }
        let mut met = Vec::with_capacity(2);
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            if high[i] == high[j] {
                continue;
            }
            let [low, up] = if high[i] { [face[j], face[i]] } else { [face[i], face[j]] };
            let index = *index_of.entry((low, up)).or_insert_with(|| {
                let (from, to) = (distance[low as usize], distance[up as usize]);
                let share = ((height - from) / (to - from)).clamp(0.0, 1.0);
                let position = canvas.positions[low as usize].lerp(canvas.positions[up as usize], share);
                crossings.push(Crossing { ends: [low, up], share, position });
                crossings.len() as u32 - 1
            });
            met.push(index);
        }
        if let [a, b] = met[..] {
            links.push((a, b));
        }
    }
    let mut parents: Vec<u32> = (0..crossings.len() as u32).collect();
    links.iter().for_each(|(a, b)| join(&mut parents, *a, *b));
    let mut rings: std::collections::BTreeMap<u32, Vec<usize>> = std::collections::BTreeMap::new();
    (0..crossings.len()).for_each(|k| rings.entry(root(&mut parents, k as u32)).or_default().push(k));
    let mut lengths = vec![0.0_f32; crossings.len()];
    for (a, b) in &links {
        let half = crossings[*a as usize].position.distance(crossings[*b as usize].position) / 2.0;
        lengths[*a as usize] += half;
        lengths[*b as usize] += half;
    }
    let ring = |of: Vec<usize>| {
        let weight: f32 = of.iter().map(|k| lengths[*k]).sum::<f32>().max(1e-12);
        let mean =
            |value: &dyn Fn(&Crossing) -> f32| of.iter().map(|k| lengths[*k] * value(&crossings[*k])).sum::<f32>();
        let center = of.iter().map(|k| crossings[*k].position * lengths[*k]).sum::<Vec3>() / weight;
        let radius = mean(&|c| c.position.distance(center)) / weight;
        let shade = |p: u32| canvas.darkness[p as usize];
        let darkness = mean(&|c| shade(c.ends[0]) + (shade(c.ends[1]) - shade(c.ends[0])) * c.share) / weight;
        // The two points of the ring whose middle is nearest to its centre.
        let mut best = (f32::INFINITY, of[0], of[0]);
        for (n, i) in of.iter().enumerate() {
            for j in &of[n..] {
                let middle = (crossings[*i].position + crossings[*j].position) / 2.0;
                let off = middle.distance_squared(center);
                if off < best.0 {
                    best = (off, *i, *j);
                }
            }
        }
        let sides = [best.1, best.2].map(|k| {
            let Crossing { ends, share, .. } = crossings[k];
            let [low, up] = ends.map(|p| canvas.vertex_of[p as usize]);
            anchor([low, up, up], share, 0.0)
        });
        (AxisPoint { sides, center, radius, darkness: darkness.clamp(0.0, 1.0) }, crossings[of[0]].ends[1])
    };
    rings.into_values().map(ring).collect()
}
