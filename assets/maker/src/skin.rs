//! From a painted mesh to the primitives of a model: normals of the surface, hair-tile coordinates, colours and weights.

use glam::{DVec3, DVec4};

use super::{
    charts::{self, Atlas, ChartParams},
    glb::{Primitive, Weights},
    regions::Regions,
    sdf::normal,
    trimesh::TriMesh,
};

/// What the skin takes from the body under it.
pub struct Skin<'a> {
    /// Signed distance of the body.
    pub field: &'a dyn Fn(DVec3) -> f64,
    /// Where hair is combed to.
    pub comb: &'a dyn Fn(DVec3) -> DVec3,
    /// Linear colour, and length of the hair as a share of the longest, of a material at a point with this normal.
    pub color: &'a dyn Fn(usize, DVec3, DVec3) -> DVec4,
    /// Metres of skin in one unit of texture coordinates.
    pub metres_per_uv: f64,
}

impl Skin<'_> {
    /// One primitive for each of `names`, whose place is the material's number, with the triangles painted with it. `weights` belong to
    /// the mesh's vertices.
    pub fn primitives(&self, regions: &Regions, names: &[&str], weights: &[Weights]) -> anyhow::Result<Vec<Primitive>> {
        let params = ChartParams { metres_per_uv: self.metres_per_uv, ..ChartParams::default() };
        let atlas = charts::make(&regions.mesh, self.comb, &params)?;
        Ok(self.charted(regions, &atlas, names, weights))
    }

    /// The same with given coordinates.
    pub fn charted(&self, regions: &Regions, atlas: &Atlas, names: &[&str], weights: &[Weights]) -> Vec<Primitive> {
        let mesh = &regions.mesh;
        let normals = self.normals(mesh);
        let mut primitives = Vec::new();
        for (material, name) in names.iter().enumerate() {
            let mut primitive = Primitive::new(name, material);
            let painted = atlas.triangles.iter().zip(&regions.materials).filter(|(_, m)| **m == material);
            let triangles: Vec<[u32; 3]> = painted.map(|(t, _)| *t).collect();
            let mut renamed = vec![u32::MAX; atlas.vertices.len()];
            for &v in triangles.iter().flatten() {
                renamed[v as usize] = 0;
            }
            for (vertex, name) in atlas.vertices.iter().zip(&mut renamed) {
                if *name == 0 {
                    *name = primitive.len() as u32;
                    let source = vertex.position as usize;
                    let (p, n) = (mesh.positions[source], normals[source]);
                    primitive.push_vertex(p, n, vertex.uv, (self.color)(material, p, n), weights[source]);
                }
            }
            primitive.triangles = triangles.iter().map(|t| t.map(|v| renamed[v as usize])).collect();
            primitives.push(primitive);
        }
        primitives
    }

    /// The surface's normals. In a crease narrower than the triangles, where the surface's own points away from one of them, it is bent until
    /// it points away from none.
    pub fn normals(&self, mesh: &TriMesh) -> Vec<DVec3> {
        let mut fans = vec![Vec::new(); mesh.positions.len()];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let face = mesh.area_normal(t).normalize_or_zero();
            for &v in corners {
                fans[v as usize].push(face);
            }
        }
        let bent = |(&p, fan): (&DVec3, &Vec<DVec3>)| {
            let mut n = normal(self.field, p);
            // As a perceptron learns: towards the face that it fits worst.
            for _ in 0..64 {
                let worst = fan.iter().copied().min_by(|a, b| a.dot(n).total_cmp(&b.dot(n)));
                match worst.filter(|face| face.dot(n) < 0.15) {
                    Some(face) => n = (n + face * 0.2).normalize_or(face),
                    None => break,
                }
            }
            n
        };
        mesh.positions.iter().zip(&fans).map(bent).collect()
    }
}
