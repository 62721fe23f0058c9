//! Comb field: a unit tangent per face, along which the hair is combed.
//!
//! Wanted directions are projected to the faces and smoothed. Where a wanted direction is weak (nearly along the
//! normal), or where wanted directions disagree, the neighbouring faces determine the result. The smoothing is a
//! hierarchical Gauss–Seidel iteration on unit vectors, as in Instant Meshes (Jakob et al. 2015). The time is linear in
//! the number of faces. By the Poincaré–Hopf theorem, a field on a closed surface of genus g has singularities whose
//! indices sum to 2 − 2g. Singularities remain where the wanted directions vanish, such as at nose and tail.

use super::topology::{NONE, Topology, prev};
use glam::DVec3;
use pelage_import::angle::between;

/// Gauss–Seidel sweeps per level. This number suffices for each level to converge, because the coarser level provides
/// the low frequencies.
const SWEEPS: usize = 6;
/// Number of nodes below which coarsening stops.
const COARSEST: usize = 8;

/// Level of the hierarchy: a graph of clusters of faces.
#[derive(Default)]
struct Level {
    normals: Vec<DVec3>,
    areas: Vec<f64>,
    /// Wanted direction of each node, times its area.
    wishes: Vec<DVec3>,
    /// Ranges in `links`: the neighbours of node i, with their weights, are `links[starts[i]..starts[i + 1]]`.
    starts: Vec<u32>,
    links: Vec<(u32, f64)>,
}

/// Smooths wanted directions into a field.
///
/// * `wishes`: wanted direction of each face; only the component in the face's plane counts, with its length (at least
///   0) as weight
/// * `smoothing_m`: distance over which neighbouring faces influence a face whose wanted direction has length 1,
///   metres, above 0
///
/// Returns one unit vector in the plane of each face.
pub(super) fn comb_field(topology: &Topology, wishes: &[DVec3], smoothing_m: f64) -> Vec<DVec3> {
    let mut levels = vec![finest(topology, wishes)];
    let mut parents: Vec<Vec<u32>> = Vec::new();
    while let Some(last) = levels.last().filter(|l| l.areas.len() > COARSEST) {
        let (coarse, parent) = coarsen(last);
        // Unconnected islands cannot be coarsened further.
        if coarse.areas.len() * 20 > last.areas.len() * 19 {
            break;
        }
        levels.push(coarse);
        parents.push(parent);
    }
    let data_weight = 1.0 / (smoothing_m * smoothing_m);
    let mut field: Vec<DVec3> = Vec::new();
    for (depth, level) in levels.iter().enumerate().rev() {
        field = match parents.get(depth) {
            Some(parent) => parent.iter().map(|p| field[*p as usize]).collect(),
            None => level.wishes.clone(),
        };
        for (x, n) in field.iter_mut().zip(&level.normals) {
            *x = x.reject_from_normalized(*n).try_normalize().unwrap_or_else(|| n.any_orthonormal_vector());
        }
        for _ in 0..SWEEPS {
            sweep(level, &mut field, data_weight);
        }
    }
    field
}

fn sweep(level: &Level, field: &mut [DVec3], data_weight: f64) {
    for i in 0..field.len() {
        let n = level.normals[i];
        let mut sum = level.wishes[i] * data_weight;
        for (j, weight) in &level.links[level.starts[i] as usize..level.starts[i + 1] as usize] {
            let j = *j as usize;
            sum += transported(field[j], level.normals[j], n) * *weight;
        }
        if let Some(x) = sum.reject_from_normalized(n).try_normalize() {
            field[i] = x;
        }
    }
}

/// Rotates `x` by the smallest rotation from `from` to `to`.
pub(super) fn transported(x: DVec3, from: DVec3, to: DVec3) -> DVec3 {
    // Rodrigues' formula, with sine and cosine derived from the normals. No smallest rotation exists for antiparallel
    // normals.
    let (axis, cosine) = (from.cross(to), from.dot(to));
    if cosine < -0.999 { x } else { x * cosine + axis.cross(x) + axis * (axis.dot(x) / (1.0 + cosine)) }
}

fn finest(topology: &Topology, wishes: &[DVec3]) -> Level {
    let mut level = Level { normals: topology.normals.clone(), areas: topology.areas.clone(), ..Level::default() };
    for (f, wish) in wishes.iter().enumerate() {
        level.wishes.push(wish.reject_from_normalized(topology.normals[f]) * topology.areas[f]);
    }
    level.starts.push(0);
    for f in 0..topology.faces.len() {
        for (h, g) in topology.neighbors(f) {
            // Weight of a dual edge in a finite-volume Laplacian. It is clamped, so that slivers neither couple faces
            // too strongly nor decouple them.
            let across = topology.centroid(f).distance(topology.centroid(g));
            let weight = (topology.edge_length(h) / across.max(f64::MIN_POSITIVE)).clamp(0.01, 100.0);
            level.links.push((g as u32, weight));
        }
        level.starts.push(level.links.len() as u32);
    }
    level
}

/// Joins each node with its most strongly linked neighbour that is not joined yet. Returns the coarser level and the
/// parent of each node.
fn coarsen(fine: &Level) -> (Level, Vec<u32>) {
    let n = fine.areas.len();
    let mut parent = vec![NONE; n];
    let mut count = 0u32;
    for i in 0..n {
        if parent[i] != NONE {
            continue;
        }
        let links = &fine.links[fine.starts[i] as usize..fine.starts[i + 1] as usize];
        let free = links.iter().filter(|(j, _)| parent[*j as usize] == NONE && *j as usize != i);
        // Prefers parallel and small neighbours, so that clusters stay round and flat.
        let score = |(j, w): &(u32, f64)| {
            w * (1.0 + fine.normals[i].dot(fine.normals[*j as usize])) / fine.areas[*j as usize].sqrt()
        };
        let best = free.max_by(|a, b| score(a).total_cmp(&score(b)).then(b.0.cmp(&a.0)));
        parent[i] = count;
        if let Some((j, _)) = best {
            parent[*j as usize] = count;
        }
        count += 1;
    }
    let m = count as usize;
    let mut coarse =
        Level { normals: vec![DVec3::ZERO; m], areas: vec![0.0; m], wishes: vec![DVec3::ZERO; m], ..Level::default() };
    let mut children: Vec<[u32; 2]> = vec![[NONE; 2]; m];
    for (i, p) in parent.iter().map(|p| *p as usize).enumerate() {
        coarse.normals[p] += fine.normals[i] * fine.areas[i];
        coarse.areas[p] += fine.areas[i];
        coarse.wishes[p] += fine.wishes[i];
        let slot = usize::from(children[p][0] != NONE);
        children[p][slot] = i as u32;
    }
    for (normal, pair) in coarse.normals.iter_mut().zip(&children) {
        *normal = normal.try_normalize().unwrap_or(fine.normals[pair[0] as usize]);
    }
    coarse.starts.push(0);
    for (p, pair) in children.iter().enumerate() {
        let begin = coarse.links.len();
        for i in pair.iter().filter(|i| **i != NONE).map(|i| *i as usize) {
            for (j, weight) in &fine.links[fine.starts[i] as usize..fine.starts[i + 1] as usize] {
                let q = parent[*j as usize];
                if q as usize == p {
                    continue;
                }
                match coarse.links[begin..].iter_mut().find(|(other, _)| *other == q) {
                    Some((_, sum)) => *sum += weight,
                    None => coarse.links.push((q, *weight)),
                }
            }
        }
        coarse.starts.push(coarse.links.len() as u32);
    }
    (coarse, parent)
}

/// Returns the interior points around which the field turns, with their index (1 source, sink or whorl, −1 saddle).
pub(super) fn singularities(topology: &Topology, field: &[DVec3]) -> Vec<(u32, i32)> {
    let mut out = Vec::new();
    let mut done = vec![false; topology.points.len()];
    // Half-edges whose walk reached a border. A later walk that reaches one of them also ends at the border. So a fan
    // of many triangles is walked once, not once per triangle.
    let mut open = vec![false; 3 * topology.faces.len()];
    for start in 0..3 * topology.faces.len() as u32 {
        let point = topology.ends(start)[0];
        if done[point as usize] {
            continue;
        }
        let (mut h, mut turned, mut angles) = (start, 0.0, 0.0);
        // Walks counter-clockwise around the point: out along h, back along the half-edge before it, and over to its
        // twin.
        let closed = loop {
            if std::mem::replace(&mut open[h as usize], true) {
                break false;
            }
            let back = prev(h);
            let over = topology.twins[back as usize];
            if over == NONE {
                break false;
            }
            angles += corner_angle(topology, h);
            turned += turn_across(topology, field, back, over);
            h = over;
            if h == start {
                break true;
            }
        };
        if closed {
            done[point as usize] = true;
            let index = ((turned + std::f64::consts::TAU - angles) / std::f64::consts::TAU).round() as i32;
            if index != 0 {
                out.push((point, index));
            }
        }
    }
    out
}

/// Returns the angle of the face at the start of `h`.
fn corner_angle(topology: &Topology, h: u32) -> f64 {
    let [a, b] = topology.ends(h).map(|p| topology.points[p as usize]);
    let c = topology.points[topology.ends(prev(h))[0] as usize];
    between(b - a, c - a)
}

/// Returns the rotation of the field, −π..=π, from the face of `h` to the face of its twin `over`, relative to parallel
/// transport across the edge.
fn turn_across(topology: &Topology, field: &[DVec3], h: u32, over: u32) -> f64 {
    let [a, b] = topology.ends(h).map(|p| topology.points[p as usize]);
    let e = (b - a).normalize_or_zero();
    let angle = |f: usize| libm::atan2(field[f].dot(topology.normals[f].cross(e)), field[f].dot(e));
    let turn = angle(over as usize / 3) - angle(h as usize / 3);
    turn - std::f64::consts::TAU * (turn / std::f64::consts::TAU).round()
}

#[cfg(test)]
mod tests {
    use super::super::repair::repair;
    use super::*;

    #[test]
    fn border_vertex_of_many_triangles_takes_linear_time() {
        // A polygon is cut as a fan, so all triangles meet in one point on the border. With one walk per triangle, this
        // test would take minutes.
        let count = 200_000;
        let mut points = vec![DVec3::ZERO];
        points.extend((0..=count).map(|i| {
            let angle = f64::from(i) / f64::from(count);
            DVec3::new(libm::cos(angle), libm::sin(angle), 0.0)
        }));
        let triangles: Vec<[u32; 3]> = (1..=count as u32).map(|i| [0, i, i + 1]).collect();
        let repaired = repair(&points, &triangles);
        let field = vec![DVec3::X; repaired.topology.faces.len()];
        assert_eq!(repaired.topology.faces.len(), count as usize);
        assert_eq!(singularities(&repaired.topology, &field), []);
    }

    #[test]
    fn a_source_in_the_middle_of_a_fan_is_found() {
        let count = 12;
        let mut points = vec![DVec3::ZERO];
        points.extend((0..count).map(|i| {
            let angle = std::f64::consts::TAU * f64::from(i) / f64::from(count);
            DVec3::new(libm::cos(angle), libm::sin(angle), 0.0)
        }));
        let triangles: Vec<[u32; 3]> = (0..count as u32).map(|i| [0, 1 + i, 1 + (i + 1) % count as u32]).collect();
        let topology = repair(&points, &triangles).topology;
        let outwards: Vec<DVec3> = (0..topology.faces.len()).map(|f| topology.centroid(f).normalize()).collect();
        let found = singularities(&topology, &outwards);
        assert!(found.len() == 1 && found[0].1 == 1, "{found:?}");
    }
}
