//! Conversion of a painted mesh to the primitives of a model: surface normals, hair-tile coordinates, colours and
//! weights.

use glam::{DVec3, DVec4};

use super::{
    charts::{self, Atlas, ChartParams},
    glb::{Primitive, Weights},
    regions::Regions,
    sdf::normal,
    trimesh::TriMesh,
};

/// Functions of the body that determine its mesh surface.
pub struct SurfaceFunctions<'a> {
    /// Signed distance of the body.
    pub field: &'a dyn Fn(DVec3) -> f64,
    /// Comb direction at a point.
    pub comb: &'a dyn Fn(DVec3) -> DVec3,
    /// Linear colour and hair length (share of the longest) of a material, at a point with a normal.
    pub color: &'a dyn Fn(usize, DVec3, DVec3) -> DVec4,
    /// World length of one unit of texture coordinates, metres.
    pub metres_per_uv: f64,
}

impl SurfaceFunctions<'_> {
    /// Builds one primitive per name. A name's index in `names` is its material, and the primitive has the triangles
    /// painted with that material. `weights` belong to the mesh's vertices.
    pub fn primitives(&self, regions: &Regions, names: &[&str], weights: &[Weights]) -> anyhow::Result<Vec<Primitive>> {
        let params = ChartParams { metres_per_uv: self.metres_per_uv, ..ChartParams::default() };
        let atlas = charts::make(&regions.mesh, self.comb, &params)?;
        Ok(self.charted(regions, &atlas, names, weights))
    }

    /// Builds the primitives as [`Self::primitives`] does, with the texture coordinates of `atlas`.
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

    /// Returns the surface normals. In a crease narrower than the triangles, a normal may point away from one of its
    /// faces; it is then adjusted until it agrees with all of them.
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
            // Perceptron learning: each step moves the normal towards the face with the worst fit.
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
