//! Detection of eyes by shape: small round connected components in pairs, high on the body.

use glam::{DVec3, Vec3};
use pelage_import::mesh::{Mesh, MeshPart};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Minimum roundness 36π V² / A³ of a connected component (volume V, area A). It is 1 for a sphere, and 0.76 for a
/// sphere compressed to half its height. It is 0.52 for a cube, and 0 for a sheet.
pub(super) const ROUND: f64 = 0.6;
/// Maximum relative difference in area between the two connected components of a pair.
const ALIKE: f64 = 0.05;
/// Maximum number of connected components of a material. Two eyes of a few layers each have no more than this.
const MOST_PIECES: usize = 12;

/// Connected component of triangles.
#[derive(Clone, Copy, Debug)]
struct ComponentShape {
    center: DVec3,
    area: f64,
    roundness: f64,
}

/// Returns the indices of the triangles of a part.
pub(super) fn triangle_range(part: &MeshPart) -> std::ops::Range<usize> {
    part.first_triangle..part.first_triangle + part.triangle_count
}

/// Numbers the distinct positions, so that vertices at the same position have the same number.
pub(super) fn weld(positions: &[Vec3]) -> Vec<u32> {
    let mut seen: HashMap<[u32; 3], u32> = HashMap::new();
    let number = |p: &Vec3| {
        let next = seen.len() as u32;
        // Adding zero turns -0 into +0.
        *seen.entry((*p + Vec3::ZERO).to_array().map(f32::to_bits)).or_insert(next)
    };
    positions.iter().map(number).collect()
}

/// Triangles of a mesh by material, as numbers of welded positions, without degenerate ones.
pub(super) struct WeldedFaces {
    of_material: Vec<Vec<[u32; 3]>>,
    /// Edges in faces of several materials.
    between_materials: HashSet<[u32; 2]>,
    /// Position of each number, at rest, y up.
    positions: Vec<DVec3>,
    /// Height halfway up the model.
    middle: f64,
}

impl WeldedFaces {
    /// Groups the triangles of a mesh with `materials` materials.
    ///
    /// * `positions`: at rest, y up
    /// * `places`: numbers from [`weld`]
    pub(super) fn new(mesh: &Mesh, positions: &[Vec3], places: &[u32], materials: usize) -> Self {
        let mut of_material = vec![Vec::new(); materials];
        let mut first_material: HashMap<[u32; 2], usize> = HashMap::new();
        let mut between_materials = HashSet::new();
        for part in &mesh.parts {
            let triangles = mesh.triangles.iter().skip(part.first_triangle).take(part.triangle_count);
            let faces = triangles.map(|t| t.map(|v| places.get(v as usize).copied().unwrap_or_default()));
            for face in faces.filter(|[a, b, c]| a != b && b != c && c != a) {
                let is_between =
                    |edge: &[u32; 2]| *first_material.entry(*edge).or_insert(part.material) != part.material;
                between_materials.extend(edges(&face).into_iter().filter(is_between));
                if let Some(faces) = of_material.get_mut(part.material) {
                    faces.push(face);
                }
            }
        }
        // Numbers are given in the order in which the positions appear.
        let mut distinct: Vec<DVec3> = Vec::new();
        for (place, position) in places.iter().zip(positions) {
            if *place as usize == distinct.len() {
                distinct.push(position.as_dvec3());
            }
        }
        let heights = positions.iter().map(|p| f64::from(p.y));
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), y| (a.min(y), b.max(y)));
        Self { of_material, between_materials, positions: distinct, middle: low / 2.0 + high / 2.0 }
    }

    /// Whether `material` covers only pairs of eye-like connected components. Each component must be small, round, in
    /// the upper half of the model, and have a partner of its size beside it. A component may be open, such as an eye
    /// without its back, but must not continue in another material.
    pub(super) fn are_round_pairs(&self, material: usize) -> bool {
        let Some(own) = self.of_material.get(material) else { return false };
        let borders = borders(own);
        let goes_on = borders.keys().any(|edge| self.between_materials.contains(edge));
        let at = |place: &u32| self.positions.get(*place as usize).copied().unwrap_or_default();
        let faces_of = |piece: &Vec<usize>| piece.iter().filter_map(|face| own.get(*face).copied()).collect::<Vec<_>>();
        let pieces: Vec<ComponentShape> =
            components(own).iter().map(|piece| measure(&faces_of(piece), &borders, &at)).collect();
        let is_eye = |piece: &ComponentShape| piece.roundness >= ROUND && piece.center.y > self.middle;
        let some = (2..=MOST_PIECES).contains(&pieces.len());
        some && !goes_on && pieces.iter().all(is_eye) && all_are_paired(&pieces)
    }
}

/// Returns the three edges of a face, each with the lower vertex index first.
pub(super) fn edges([a, b, c]: &[u32; 3]) -> [[u32; 2]; 3] {
    [[*a, *b], [*b, *c], [*c, *a]].map(|[p, q]| [p.min(q), p.max(q)])
}

/// Returns the edges that belong to a single face.
fn borders(faces: &[[u32; 3]]) -> BTreeMap<[u32; 2], u32> {
    let mut count = BTreeMap::new();
    faces.iter().flat_map(edges).for_each(|edge| *count.entry(edge).or_insert(0) += 1);
    count.retain(|_, faces| *faces == 1);
    count
}

/// Returns the indices of the faces of each connected component, in the order of their first faces.
pub(super) fn components(faces: &[[u32; 3]]) -> Vec<Vec<usize>> {
    let mut parent: BTreeMap<u32, u32> = BTreeMap::new();
    let root = |parent: &mut BTreeMap<u32, u32>, mut place: u32| {
        while let Some(up) = parent.get(&place).copied().filter(|up| *up != place) {
            // Path halving keeps the paths to the roots short.
            let above = parent.get(&up).copied().unwrap_or(up);
            parent.insert(place, above);
            place = above;
        }
        parent.insert(place, place);
        place
    };
    for [a, b, c] in faces {
        for other in [b, c] {
            let ends = [*a, *other].map(|place| root(&mut parent, place));
            parent.insert(ends[0].max(ends[1]), ends[0].min(ends[1]));
        }
    }
    let (mut number, mut out): (BTreeMap<u32, usize>, Vec<Vec<usize>>) = Default::default();
    for (index, face) in faces.iter().enumerate() {
        let next = out.len();
        let piece = *number.entry(root(&mut parent, face[0])).or_insert(next);
        if piece == next {
            out.push(Vec::new());
        }
        if let Some(faces) = out.get_mut(piece) {
            faces.push(index);
        }
    }
    out
}

/// Measures a connected component. A hole is closed by a fan around its centre, which does not count in the area.
fn measure(faces: &[[u32; 3]], borders: &BTreeMap<[u32; 2], u32>, at: &dyn Fn(&u32) -> DVec3) -> ComponentShape {
    let mean = |places: &[u32]| places.iter().map(at).sum::<DVec3>() / places.len().max(1) as f64;
    let all: Vec<u32> = faces.iter().flatten().copied().collect();
    let rim: Vec<u32> = faces.iter().flat_map(edges).filter(|edge| borders.contains_key(edge)).flatten().collect();
    let hub = mean(if rim.is_empty() { &all } else { &rim });
    let (mut volume, mut area) = (0.0, 0.0);
    for face in faces {
        let [a, b, c] = face.map(|place| at(&place) - hub);
        volume += a.dot(b.cross(c)) / 6.0;
        area += (b - a).cross(c - a).length() / 2.0;
    }
    let roundness = if area > 0.0 { 36.0 * std::f64::consts::PI * volume * volume / (area * area * area) } else { 0.0 };
    ComponentShape { center: mean(&all), area, roundness }
}

/// Whether every connected component has a partner of its size. Their centres must be more than a diameter apart, so
/// that the two are not concentric.
fn all_are_paired(pieces: &[ComponentShape]) -> bool {
    let mut paired = vec![false; pieces.len()];
    for (i, piece) in pieces.iter().enumerate() {
        if paired[i] {
            continue;
        }
        let is_partner = |j: &usize| {
            let other = &pieces[*j];
            let apart = piece.center.distance_squared(other.center) > piece.area / std::f64::consts::PI;
            !paired[*j] && apart && (piece.area - other.area).abs() <= ALIKE * piece.area.max(other.area)
        };
        let Some(partner) = (i + 1..pieces.len()).find(is_partner) else { return false };
        (paired[i], paired[partner]) = (true, true);
    }
    true
}
