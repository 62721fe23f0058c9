//! Materials on a closed mesh: triangles are cut along the level sets of functions, so that materials meet in smooth
//! lines.

use std::collections::BTreeMap;

use glam::DVec3;

use super::{body::mirror, sdf::project, trimesh::TriMesh};

/// Mesh with a material per triangle, initially 0.
#[derive(Clone, Debug)]
pub struct Regions {
    /// The mesh; cutting adds vertices and keeps it closed.
    pub mesh: TriMesh,
    /// Material of each triangle.
    pub materials: Vec<usize>,
}

impl Regions {
    /// Assigns material 0 to the whole mesh.
    pub fn new(mesh: TriMesh) -> Self {
        let materials = vec![0; mesh.triangles.len()];
        Self { mesh, materials }
    }

    /// Assigns `material` to the surface where `level` is negative. New vertices are projected onto the zero set of
    /// `surface`. Regions painted by separate calls must not touch.
    pub fn paint(&mut self, material: usize, level: &dyn Fn(DVec3) -> f64, surface: &dyn Fn(DVec3) -> f64) {
        let mut values: Vec<f64> = self.mesh.positions.iter().map(|&p| level(p)).collect();
        self.snap(&mut values, surface);
        let mut crossings: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        for t in 0..self.mesh.triangles.len() {
            let mut corners = self.mesh.triangles[t];
            let sign = |v: u32| values[v as usize].partial_cmp(&0.0).map_or(0, |order| order as i32);
            let signs = corners.map(sign);
            if !(signs.contains(&1) && signs.contains(&-1)) {
                if signs.contains(&-1) {
                    self.materials[t] = material;
                }
                continue;
            }
            // Rotates the corners so that the first one is alone on its side of the border. If a corner is on the
            // border, the corner before it becomes the first.
            let first = if signs.contains(&0) {
                (signs.iter().position(|s| *s == 0).unwrap_or(0) + 2) % 3
            } else {
                (0..3).find(|&k| signs[(k + 1) % 3] == signs[(k + 2) % 3]).unwrap_or(0)
            };
            corners.rotate_left(first);
            let [a, b, c] = corners;
            let alone = sign(a) < 0;
            let old = self.materials[t];
            let (own, others) = if alone { (material, old) } else { (old, material) };
            let mut crossing = |mesh: &mut TriMesh, from: u32, to: u32| {
                *crossings.entry((from.min(to), from.max(to))).or_insert_with(|| {
                    let (f, g) = (values[from as usize], values[to as usize]);
                    let (p, q) = (mesh.positions[from as usize], mesh.positions[to as usize]);
                    mesh.positions.push(project(surface, p + (q - p) * (f / (f - g)), 8));
                    mesh.positions.len() as u32 - 1
                })
            };
            let far = crossing(&mut self.mesh, a, c);
            if sign(b) == 0 {
                self.replace(t, [a, b, far], own, &[([far, b, c], others)]);
            } else {
                let near = crossing(&mut self.mesh, a, b);
                self.replace(t, [a, near, far], own, &[([far, near, b], others), ([far, b, c], others)]);
            }
        }
    }

    fn replace(&mut self, t: usize, corners: [u32; 3], material: usize, more: &[([u32; 3], usize)]) {
        self.mesh.triangles[t] = corners;
        self.materials[t] = material;
        for &(corners, material) in more {
            self.mesh.triangles.push(corners);
            self.materials.push(material);
        }
    }

    /// Moves vertices near the border onto it, so that cutting leaves no slivers.
    fn snap(&mut self, values: &mut [f64], surface: &dyn Fn(DVec3) -> f64) {
        // Nearest border crossing on the edges of each vertex: fraction of the edge, and position.
        let mut nearest: BTreeMap<u32, (f64, DVec3)> = BTreeMap::new();
        for t in &self.mesh.triangles {
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                let (f, g) = (values[a as usize], values[b as usize]);
                if f * g >= 0.0 {
                    continue;
                }
                let share = f / (f - g);
                let (p, q) = (self.mesh.positions[a as usize], self.mesh.positions[b as usize]);
                let at = p + (q - p) * share;
                for (v, share) in [(a, share), (b, 1.0 - share)] {
                    if share < 0.3 && nearest.get(&v).is_none_or(|n| share < n.0) {
                        nearest.insert(v, (share, at));
                    }
                }
            }
        }
        for (v, (_, at)) in nearest {
            self.mesh.positions[v as usize] = project(surface, at, 8);
            values[v as usize] = 0.0;
        }
    }
}

/// Joins the half x >= 0 of a painted closed mesh with its mirror image, materials included. The result is closed and
/// exactly symmetric.
pub fn mirror_half(mut halves: Regions, surface: &dyn Fn(DVec3) -> f64) -> Regions {
    const LOST: usize = usize::MAX;
    halves.paint(LOST, &|p| p.x, surface);
    let Regions { mesh, materials } = halves;
    let count = mesh.positions.len();
    let (mut kept, mut lost) = (vec![false; count], vec![false; count]);
    for (t, &material) in mesh.triangles.iter().zip(&materials) {
        for &v in t {
            let side = if material == LOST { &mut lost } else { &mut kept };
            side[v as usize] = true;
        }
    }
    let mut whole = Regions::new(TriMesh { positions: mesh.positions, triangles: Vec::new() });
    let mut twin = Vec::with_capacity(count);
    for v in 0..count {
        if kept[v] && lost[v] {
            whole.mesh.positions[v].x = 0.0;
            twin.push(v as u32);
        } else {
            twin.push(whole.mesh.positions.len() as u32);
            whole.mesh.positions.push(mirror(whole.mesh.positions[v]));
        }
    }
    for (&[a, b, c], &material) in mesh.triangles.iter().zip(&materials).filter(|(_, m)| **m != LOST) {
        whole.mesh.triangles.extend([[a, b, c], [a, c, b].map(|v| twin[v as usize])]);
        whole.materials.extend([material; 2]);
    }
    whole.mesh.drop_unused_vertices();
    whole
}
