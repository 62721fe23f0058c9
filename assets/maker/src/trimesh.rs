//! Closed triangle mesh with the adjacency needed for remeshing and charting.

use std::collections::BTreeMap;

use fast_surface_nets::{SurfaceNetsBuffer, ndshape::RuntimeShape, surface_nets};
use glam::DVec3;

/// Vertices and counter-clockwise triangles.
#[derive(Clone, Debug, Default)]
pub struct TriMesh {
    /// Positions, metres.
    pub positions: Vec<DVec3>,
    /// Corner indices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl TriMesh {
    /// Meshes the zero set of `field` inside the box from `low` to `high` by naive surface nets (Gibson 1998) on cubes
    /// of `cell` metres.
    pub fn from_field(field: &dyn Fn(DVec3) -> f64, low: DVec3, high: DVec3, cell: f64) -> Self {
        let count = ((high - low) / cell).ceil();
        let size = [count.x as u32 + 1, count.y as u32 + 1, count.z as u32 + 1];
        let shape = RuntimeShape::<u32, 3>::new(size);
        let at = |x: f64, y: f64, z: f64| low + DVec3::new(x, y, z) * cell;
        let mut samples = Vec::with_capacity((size[0] * size[1] * size[2]) as usize);
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    samples.push(field(at(x.into(), y.into(), z.into())) as f32);
                }
            }
        }
        remove_alternating_signs(&mut samples, size.map(|n| n as usize));
        let mut buffer = SurfaceNetsBuffer::default();
        surface_nets(&samples, &shape, [0; 3], size.map(|n| n - 1), &mut buffer);
        let positions = buffer.positions.iter().map(|p| at(p[0].into(), p[1].into(), p[2].into())).collect();
        let triangles = buffer.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        Self { positions, triangles }
    }

    /// Returns the corner positions of triangle `t`.
    pub fn corners(&self, t: usize) -> [DVec3; 3] {
        self.triangles[t].map(|v| self.positions[v as usize])
    }

    /// Returns twice the area of triangle `t` times its outward unit normal.
    pub fn area_normal(&self, t: usize) -> DVec3 {
        let [a, b, c] = self.corners(t);
        (b - a).cross(c - a)
    }

    /// Returns, for each triangle, the triangles across the edges (0,1), (1,2), (2,0).
    ///
    /// Fails with the first undirected edge that is not shared by exactly two oppositely directed triangles.
    pub fn neighbours(&self) -> Result<Vec<[u32; 3]>, (u32, u32)> {
        let mut by_edge = BTreeMap::new();
        for (t, corners) in self.triangles.iter().enumerate() {
            for k in 0..3 {
                let edge = (corners[k], corners[(k + 1) % 3]);
                if by_edge.insert(edge, t as u32).is_some() {
                    return Err(edge);
                }
            }
        }
        self.triangles
            .iter()
            .map(|corners| {
                let mut across = [0; 3];
                for k in 0..3 {
                    let edge = (corners[(k + 1) % 3], corners[k]);
                    across[k] = *by_edge.get(&edge).ok_or(edge)?;
                }
                Ok(across)
            })
            .collect()
    }

    /// Keeps only the connected component with the most triangles; returns how many components there were.
    pub fn keep_largest_component(&mut self) -> usize {
        let mut root: Vec<u32> = (0..self.positions.len() as u32).collect();
        for t in &self.triangles {
            for k in 1..3 {
                let (a, b) = (find(&mut root, t[0]), find(&mut root, t[k]));
                root[a.max(b) as usize] = a.min(b);
            }
        }
        let mut sizes = BTreeMap::new();
        for t in &self.triangles {
            *sizes.entry(find(&mut root, t[0])).or_insert(0_usize) += 1;
        }
        let largest = sizes.iter().max_by_key(|&(_, n)| *n).map(|(&r, _)| r);
        self.triangles.retain(|t| Some(find(&mut root, t[0])) == largest);
        self.drop_unused_vertices();
        sizes.len()
    }

    /// Removes vertices that no triangle uses, keeping the order of the others.
    pub fn drop_unused_vertices(&mut self) {
        let mut renamed = vec![u32::MAX; self.positions.len()];
        for &v in self.triangles.iter().flatten() {
            renamed[v as usize] = 0;
        }
        let mut kept = Vec::new();
        for (v, name) in renamed.iter_mut().enumerate() {
            if *name == 0 {
                *name = kept.len() as u32;
                kept.push(self.positions[v]);
            }
        }
        self.positions = kept;
        for v in self.triangles.iter_mut().flatten() {
            *v = renamed[*v as usize];
        }
    }
}

/// Removes alternating signs around a face of a cell by changing the sign of one of the four samples, the one nearest
/// to zero. Alternating signs make surface nets pinch, for example where a slanting limb just touches the face. `size`
/// is the number of samples along x, y and z.
fn remove_alternating_signs(samples: &mut [f32], size: [usize; 3]) {
    let steps = [1, size[0], size[0] * size[1]];
    // A changed sample may cause alternating signs on a neighbouring face; a few rounds are enough.
    for _ in 0..8 {
        let mut changed = false;
        for at in 0..samples.len() {
            let place = [at % size[0], at / steps[1] % size[1], at / steps[2]];
            for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                if place[i] + 1 == size[i] || place[j] + 1 == size[j] {
                    continue;
                }
                let face = [at, at + steps[i], at + steps[j], at + steps[i] + steps[j]];
                let inside = face.map(|k| samples[k] < 0.0);
                if inside[0] == inside[3] && inside[1] == inside[2] && inside[0] != inside[1] {
                    let least = face.into_iter().min_by(|a, b| samples[*a].abs().total_cmp(&samples[*b].abs()));
                    if let Some(k) = least {
                        samples[k] = if samples[k] < 0.0 { 1e-6 } else { -1e-6 };
                        changed = true;
                    }
                }
            }
        }
        if !changed {
            break;
        }
    }
}

/// Returns the representative of `v` in a union-find forest, with path halving.
pub fn find(root: &mut [u32], mut v: u32) -> u32 {
    while root[v as usize] != v {
        root[v as usize] = root[root[v as usize] as usize];
        v = root[v as usize];
    }
    v
}
