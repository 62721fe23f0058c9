//! Lapped patches over any surface: the variant without overlap of Lengyel et al. 2001.
//!
//! Patches grow ([`super::grow`]), each is solved ([`super::solve`]), and small ones are merged with neighbours if the
//! union is still good. Then the patches are shifted relative to each other, so that the tile continues across as much
//! of the borders as possible.

use super::field::transported;
use super::grow::{Reach, grow, members, split};
use super::solve::{FaceFrame, PatchSystem, singular_values};
use super::topology::{NONE, Topology};
use crate::progress::StageProgress;
use glam::{DMat2, DVec2};
use rayon::prelude::*;
use std::collections::HashSet;

/// Maximum number of merge passes. Each pass at most halves the number of patches; few models need all passes.
const MERGE_PASSES: usize = 8;
/// Rounds of rotating faces towards minimal distortion. The first rounds bring nearly all of the gain.
const ROUNDS: usize = 4;
/// Share of a patch's area that may exceed the bounds, so that a few odd triangles do not split a good patch.
const ODD_SHARE: f64 = 0.01;
/// Smallest permitted singular value of the map of any face.
const LEAST_SQUEEZE: f64 = 0.4;

/// Parameters of lapped patches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LappedParams {
    /// Limits of growth.
    pub(super) reach: Reach,
    /// Bounds on a patch's distortion; a patch that exceeds them is split.
    pub(super) bounds: Bounds,
    /// Weight of the comb field: 1 follows the field, 0 is as rigid as possible.
    pub(super) comb_weight: f64,
}

/// Bounds on the map of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    /// Cosine of the largest angle between the tile's v direction and the comb field.
    pub(super) least_cosine: f64,
    /// Maximum stretch in any direction, and inverse of the minimum; above 1.
    pub(super) stretch: f64,
}

impl Bounds {
    fn allow(&self, map: DMat2) -> bool {
        let (largest, least) = singular_values(map);
        largest <= self.stretch
            && least * self.stretch >= 1.0
            && map.y_axis.y >= self.least_cosine * map.y_axis.length()
    }
}

/// Result of the parameterization: patches, and tile coordinates per corner.
#[derive(Clone, Debug, Default)]
pub(super) struct Lapped {
    /// Index of the patch of each face.
    pub(super) patch_of: Vec<u32>,
    /// Tile coordinates of each face's corners.
    pub(super) corners: Vec<[DVec2; 3]>,
    pub(super) patches: usize,
    /// Number of patches that were split because their equations had no reliable solution.
    pub(super) unsolved: usize,
}

/// Patch with its tile coordinates.
#[derive(Clone, Debug)]
struct Solved {
    faces: Vec<u32>,
    /// Points of the patch in ascending order, with tile coordinates.
    points: Vec<(u32, DVec2)>,
}

pub(super) fn lapped_patches(
    topology: &Topology,
    frames: &[FaceFrame],
    params: &LappedParams,
    progress: &StageProgress,
) -> Lapped {
    let maker = PatchBuilder { topology, frames, params };
    let grown = members(&grow(topology, frames, &params.reach));
    progress.add("surface", grown.len() as u64);
    let solve = |faces| {
        let solved = maker.solve_or_split(faces);
        progress.step("surface");
        solved
    };
    let (solved, unsolved): (Vec<_>, Vec<_>) = grown.into_par_iter().map(solve).unzip();
    let mut patches: Vec<Solved> = solved.into_iter().flatten().collect();
    maker.merge(&mut patches, progress);
    let mut out = Lapped {
        patch_of: patch_of(topology, &patches),
        patches: patches.len(),
        unsolved: unsolved.iter().sum(),
        ..Lapped::default()
    };
    align(topology, &out.patch_of, &mut patches);
    out.corners = vec![[DVec2::ZERO; 3]; topology.faces.len()];
    for patch in &patches {
        for f in &patch.faces {
            out.corners[*f as usize] = topology.faces[*f as usize].map(|p| patch.uv(p));
        }
    }
    out
}

fn patch_of(topology: &Topology, patches: &[Solved]) -> Vec<u32> {
    let mut out = vec![NONE; topology.faces.len()];
    for (id, patch) in patches.iter().enumerate() {
        patch.faces.iter().for_each(|f| out[*f as usize] = id as u32);
    }
    out
}

struct PatchBuilder<'a> {
    topology: &'a Topology,
    frames: &'a [FaceFrame],
    params: &'a LappedParams,
}

/// Reason why faces cannot be one patch.
enum PatchError {
    /// Faces that are not a disc, or of which too many exceed the bounds.
    Shape,
    /// Equations without a reliable solution.
    Equations,
}

impl PatchBuilder<'_> {
    fn solve(&self, faces: &[u32]) -> Result<Vec<(u32, DVec2)>, PatchError> {
        if let [face] = faces {
            return Ok(self.lay_flat(*face as usize));
        }
        let system = PatchSystem::new(self.topology, faces, self.frames_of(faces));
        if system.euler_characteristic() != 1 {
            return Err(PatchError::Shape);
        }
        let rounds = if self.params.comb_weight < 1.0 { ROUNDS } else { 0 };
        let uvs = system.solve(self.params.comb_weight, rounds).ok_or(PatchError::Equations)?;
        let maps: Vec<(f64, DMat2)> =
            (0..faces.len()).map(|k| (self.topology.areas[faces[k] as usize], system.jacobian(k, &uvs))).collect();
        let area: f64 = maps.iter().map(|(area, _)| area).sum();
        // Gradients average out where the field turns, and least squares shrinks the patch. Without this scale, hair
        // would be coarser on curved surfaces.
        let scale = (area / maps.iter().map(|(area, map)| area * map.determinant()).sum::<f64>()).sqrt();
        let mut odd = 0.0;
        for (face_area, map) in maps {
            let (largest, least) = singular_values(map * scale);
            // The comparison is written so that NaN is rejected.
            if !(least >= LEAST_SQUEEZE && largest * LEAST_SQUEEZE <= 1.0) {
                return Err(PatchError::Shape);
            }
            odd += if self.params.bounds.allow(map * scale) { 0.0 } else { face_area };
        }
        if odd > ODD_SHARE * area {
            Err(PatchError::Shape)
        } else {
            Ok(system.points().iter().copied().zip(uvs.into_iter().map(|uv| uv * scale)).collect())
        }
    }

    /// Returns the frames of the faces. Without a comb, the frame of the first face is transported over the patch.
    fn frames_of(&self, faces: &[u32]) -> Vec<FaceFrame> {
        let frame = |f: u32| self.frames[f as usize];
        if self.params.reach.combed {
            return faces.iter().map(|f| frame(*f)).collect();
        }
        let mut sorted: Vec<(u32, Option<FaceFrame>)> = faces.iter().map(|f| (*f, None)).collect();
        sorted.sort_unstable_by_key(|(f, _)| *f);
        let slot =
            |f: usize, list: &[(u32, Option<FaceFrame>)]| list.binary_search_by_key(&(f as u32), |(f, _)| *f).ok();
        let mut queue = std::collections::VecDeque::from([0]);
        sorted[0].1 = Some(frame(sorted[0].0));
        while let Some(i) = queue.pop_front() {
            let (f, Some(from)) = sorted[i] else { continue };
            for (_, g) in self.topology.neighbors(f as usize) {
                let Some(j) = slot(g, &sorted).filter(|j| sorted[*j].1.is_none()) else { continue };
                let (n, m) = (self.topology.normals[f as usize], self.topology.normals[g]);
                let t =
                    transported(from.t, n, m).reject_from_normalized(m).try_normalize().unwrap_or(frame(g as u32).t);
                sorted[j].1 = Some(FaceFrame { s: t.cross(m), t, tile_m: frame(g as u32).tile_m });
                queue.push_back(j);
            }
        }
        faces.iter().map(|f| slot(*f as usize, &sorted).and_then(|i| sorted[i].1).unwrap_or(frame(*f))).collect()
    }

    /// Lays a single face flat in its own frame, undistorted.
    fn lay_flat(&self, face: usize) -> Vec<(u32, DVec2)> {
        let (frame, corners) = (&self.frames[face], self.topology.corners(face));
        let flat =
            corners.map(|p| DVec2::new((p - corners[0]).dot(frame.s), (p - corners[0]).dot(frame.t)) / frame.tile_m);
        let mut points: Vec<_> = self.topology.faces[face].into_iter().zip(flat).collect();
        points.sort_unstable_by_key(|(p, _)| *p);
        points
    }

    /// Solves the faces as one patch if possible; otherwise splits them in two, recursively. Also returns the number of
    /// systems that could not be solved.
    fn solve_or_split(&self, faces: Vec<u32>) -> (Vec<Solved>, usize) {
        let (mut out, mut unsolved) = (Vec::new(), 0);
        let mut todo = vec![faces];
        while let Some(faces) = todo.pop() {
            match self.solve(&faces) {
                Ok(points) => out.push(Solved { faces, points }),
                Err(refusal) => {
                    unsolved += usize::from(matches!(refusal, PatchError::Equations));
                    let second = split(self.topology, self.frames, &self.params.reach, &faces);
                    for side in [false, true] {
                        let part: Vec<u32> =
                            faces.iter().zip(&second).filter(|(_, s)| **s == side).map(|(f, _)| *f).collect();
                        todo.extend(self.connected(&part));
                    }
                }
            }
        }
        (out, unsolved)
    }

    /// Returns the connected components of `faces`.
    fn connected(&self, faces: &[u32]) -> Vec<Vec<u32>> {
        let mut sorted = faces.to_vec();
        sorted.sort_unstable();
        let mut seen = vec![false; sorted.len()];
        let mut out = Vec::new();
        for first in 0..sorted.len() {
            if seen[first] {
                continue;
            }
            seen[first] = true;
            let mut part = vec![sorted[first]];
            let mut at = 0;
            while let Some(f) = part.get(at).copied() {
                at += 1;
                for (_, g) in self.topology.neighbors(f as usize) {
                    if let Ok(i) = sorted.binary_search(&(g as u32))
                        && !seen[i]
                    {
                        seen[i] = true;
                        part.push(g as u32);
                    }
                }
            }
            out.push(part);
        }
        out
    }

    /// Merges neighbours whose union is a valid patch. Pairs with the longest border for their size come first. Each
    /// patch is in at most one pair per pass, so that a pass runs on all cores. Rejected pairs are not tried again.
    fn merge(&self, patches: &mut Vec<Solved>, progress: &StageProgress) {
        // Identifiers are stable; a merged patch gets a new one.
        let mut names: Vec<u32> = (0..patches.len() as u32).collect();
        let mut next_name = patches.len() as u32;
        let mut refused: HashSet<[u32; 2]> = HashSet::new();
        for _ in 0..MERGE_PASSES {
            let pairs = self.pairs_to_merge(patches, |a, b| refused.contains(&[names[a as usize], names[b as usize]]));
            if pairs.is_empty() {
                break;
            }
            progress.add("surface", pairs.len() as u64);
            let union = |[a, b]: &[u32; 2]| {
                let faces: Vec<u32> = [a, b].into_iter().flat_map(|i| &patches[*i as usize].faces).copied().collect();
                let union = self.solve(&faces).ok().map(|points| Solved { faces, points });
                progress.step("surface");
                union
            };
            let unions: Vec<Option<Solved>> = pairs.par_iter().map(union).collect();
            for ([a, b], union) in pairs.into_iter().zip(unions) {
                let (a, b) = (a as usize, b as usize);
                match union {
                    Some(union) => {
                        patches[a] = union;
                        patches[b].faces.clear();
                        names[a] = next_name;
                        next_name += 1;
                    }
                    None => _ = refused.insert([names[a], names[b]]),
                }
            }
            let mut kept = patches.iter().map(|p| !p.faces.is_empty());
            names.retain(|_| kept.next().unwrap_or(true));
            patches.retain(|p| !p.faces.is_empty());
        }
    }

    /// Returns pairs of neighbouring patches. Each patch occurs at most once, and `refused` pairs are excluded.
    fn pairs_to_merge(&self, patches: &[Solved], refused: impl Fn(u32, u32) -> bool) -> Vec<[u32; 2]> {
        let owner = patch_of(self.topology, patches);
        let mut borders: Vec<([u32; 2], f64)> = Vec::new();
        for h in 0..self.topology.twins.len() as u32 {
            let twin = self.topology.twins[h as usize];
            if twin != NONE && h < twin {
                let (a, b) = (owner[h as usize / 3], owner[twin as usize / 3]);
                if a != b {
                    borders.push(([a.min(b), a.max(b)], self.topology.edge_length(h)));
                }
            }
        }
        borders.sort_by_key(|(pair, _)| *pair);
        let area = |i: u32| -> f64 { patches[i as usize].faces.iter().map(|f| self.topology.areas[*f as usize]).sum() };
        let areas: Vec<f64> = (0..patches.len() as u32).map(area).collect();
        let smaller = |[a, b]: [u32; 2]| areas[a as usize].min(areas[b as usize]);
        let groups = borders.chunk_by(|x, y| x.0 == y.0).filter(|c| !refused(c[0].0[0], c[0].0[1]));
        let mut pairs: Vec<([u32; 2], f64)> =
            groups.map(|c| (c[0].0, c.iter().map(|x| x.1).sum::<f64>() / smaller(c[0].0).sqrt())).collect();
        pairs.sort_by(|x, y| y.1.total_cmp(&x.1).then(x.0.cmp(&y.0)));
        let mut taken = vec![false; patches.len()];
        let mut out = Vec::new();
        for (pair, _) in pairs {
            if pair.iter().all(|i| !taken[*i as usize]) {
                pair.iter().for_each(|i| taken[*i as usize] = true);
                out.push(pair);
            }
        }
        out
    }
}

impl Solved {
    fn uv(&self, point: u32) -> DVec2 {
        self.points.binary_search_by_key(&point, |(p, _)| *p).map_or(DVec2::ZERO, |i| self.points[i].1)
    }
}

/// Shifts patches so that the mean difference of tile coordinates across borders vanishes, along a spanning tree of the
/// longest borders (Kruskal). If the field crosses such a border without a turn, the seam is hardly visible.
fn align(topology: &Topology, patch_of: &[u32], patches: &mut [Solved]) {
    // For each pair of patches: length of the border, and integral of the difference in tile coordinates along it.
    let mut borders: Vec<([u32; 2], f64, DVec2)> = Vec::new();
    for h in 0..topology.twins.len() as u32 {
        let twin = topology.twins[h as usize];
        if twin == NONE || twin < h {
            continue;
        }
        let (a, b) = (patch_of[h as usize / 3], patch_of[twin as usize / 3]);
        if a != b {
            let (a, b) = (a.min(b), a.max(b));
            let length = topology.edge_length(h);
            let [p, q] = topology.ends(h);
            let middle = |i: u32| (patches[i as usize].uv(p) + patches[i as usize].uv(q)) / 2.0;
            borders.push(([a, b], length, (middle(a) - middle(b)) * length));
        }
    }
    borders.sort_by_key(|(pair, ..)| *pair);
    let mut pairs: Vec<([u32; 2], f64, DVec2)> = borders
        .chunk_by(|x, y| x.0 == y.0)
        .map(|c| (c[0].0, c.iter().map(|x| x.1).sum(), c.iter().map(|x| x.2).sum::<DVec2>()))
        .collect();
    pairs.sort_by(|x, y| y.1.total_cmp(&x.1).then(x.0.cmp(&y.0)));
    let mut shifts = vec![DVec2::ZERO; patches.len()];
    let mut group: Vec<u32> = (0..patches.len() as u32).collect();
    let mut members: Vec<Vec<u32>> = (0..patches.len() as u32).map(|i| vec![i]).collect();
    for ([a, b], length, difference) in pairs {
        let [ga, gb] = [a, b].map(|i| group[i as usize] as usize);
        if ga == gb {
            continue;
        }
        let gap = difference / length + shifts[a as usize] - shifts[b as usize];
        // The mean is undefined for a border of length 0.
        let gap = if length > 0.0 { gap } else { DVec2::ZERO };
        // The smaller group is shifted, which takes O(n log n) in total.
        let (stays, moves, by) = if members[ga].len() >= members[gb].len() { (ga, gb, gap) } else { (gb, ga, -gap) };
        for i in std::mem::take(&mut members[moves]) {
            shifts[i as usize] += by;
            group[i as usize] = stays as u32;
            members[stays].push(i);
        }
    }
    for (patch, shift) in patches.iter_mut().zip(shifts) {
        // Shifts by whole tiles are invisible. Removing them keeps the coordinates small and precise.
        let middle = patch.points.iter().map(|(_, uv)| *uv).sum::<DVec2>() / patch.points.len().max(1) as f64 + shift;
        let shift = shift - middle.round();
        patch.points.iter_mut().for_each(|(_, uv)| *uv += shift);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec3, dvec3};

    /// Makes a strip of four triangles whose inner edge has length `least`. The mesh repair would remove much thinner
    /// triangles.
    fn strip(least: f64) -> Topology {
        let places = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, least), (2.0, 0.0), (2.0, 1.0)];
        let points = places.map(|(x, z)| dvec3(x, 0.0, z)).to_vec();
        let faces = vec![[0, 1, 3], [0, 3, 2], [2, 3, 4], [3, 5, 4]];
        let mut twins = vec![NONE; 12];
        for (h, g) in [(2, 3), (4, 6), (7, 11)] {
            (twins[h], twins[g]) = (g as u32, h as u32);
        }
        Topology::new(points, faces, twins)
    }

    fn laid(topology: &Topology) -> Lapped {
        let frame = |n: &DVec3| FaceFrame { s: DVec3::NEG_Z.cross(*n), t: DVec3::NEG_Z, tile_m: 0.5 };
        let frames: Vec<FaceFrame> = topology.normals.iter().map(frame).collect();
        let params = LappedParams {
            reach: Reach { tiles: 100.0, turn_rad: 2.0, combed: true },
            bounds: Bounds { least_cosine: 0.9, stretch: 1.5 },
            comb_weight: 1.0,
        };
        lapped_patches(topology, &frames, &params, StageProgress::ignored())
    }

    #[test]
    fn ill_conditioned_systems_split_the_patch_and_are_counted() {
        let sound = laid(&strip(0.5));
        assert_eq!((sound.patches, sound.unsolved), (1, 0));
        // Gradients for an edge of length 1e-170 overflow when squared. The factorisation fails or gives NaN, which
        // must not reach a vertex.
        let broken = laid(&strip(1e-170));
        assert!(broken.unsolved > 0 && broken.patches > 1, "{broken:?}");
        assert!(broken.corners.iter().flatten().all(|uv| uv.is_finite()), "{broken:?}");
        // The other faces are still laid out without distortion.
        for f in [0, 3] {
            let [a, b, c] = broken.corners[f];
            assert!(((b - a).perp_dot(c - a) / 2.0 - 2.0).abs() < 1e-9, "{broken:?}");
        }
    }
}
