//! Morph targets on the vertices of a package: changes of positions, normals and the tile's axes.

use glam::{DMat3, DVec3, Vec3};
use pelage_formats::meaning::{largest_shifts, shown};
use pelage_formats::{Animation, MeshData, MorphDelta, Morphs};
use pelage_import::mesh::{Model, RowDelta};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// Smallest change of a normal or a direction that is stored. Smaller changes are invisible.
const LEAST: f32 = 1e-6;

/// Effect of one morph target on all vertices at one position.
#[derive(Clone, Copy, Debug)]
struct VertexMorph {
    /// Change of the normals of adjacent triangles, each with a length of twice the triangle's area.
    normals: DVec3,
    /// Matrix that maps a direction on the mesh surface to its change. It is summed over adjacent triangles, weighted
    /// by twice the triangle's area.
    gradient: DMat3,
    /// Sum of the normal changes given by the file; `authored_count` is their number.
    authored: DVec3,
    authored_count: u32,
}

impl VertexMorph {
    /// No change. (A derived default is not possible: the default of a matrix is the identity.)
    const NOTHING: Self =
        Self { normals: DVec3::ZERO, gradient: DMat3::ZERO, authored: DVec3::ZERO, authored_count: 0 };
}

/// Returns the morph targets of a model for the vertices of its package; `None` for a model without any. `rows`: row of
/// each vertex in [`Model::morph_rows`].
///
/// Vertices with the same position and normal share the change of the normal, so that fur stays closed over patch
/// seams. The change is read from the file, if given, and otherwise derived from the triangles. The tile's axes follow
/// the mesh surface. Vertices that are hidden at rest have deltas from there ([`hidden`]); the tangents of these deltas
/// are zero unless the target shows the vertex.
pub fn mesh_morphs(mesh: &MeshData, rows: &[u32], model: &Model) -> Option<Morphs> {
    let motion =
        model.animation.as_ref().map(|animation| &animation.morphs).filter(|motion| !motion.targets.is_empty())?;
    let row_of = |v: usize| {
        let row = rows.get(v).and_then(|row| model.morph_rows.0.get(*row as usize));
        row.map_or(&[][..], Vec::as_slice)
    };
    let mut groups: HashMap<[u32; 6], u32> = HashMap::new();
    let group_of: Vec<u32> = mesh
        .geometry
        .iter()
        .map(|vertex| {
            let [[a, b, c], [d, e, f]] = [vertex.position, vertex.normal].map(|v| v.map(|x| (x + 0.0).to_bits()));
            let next = groups.len() as u32;
            *groups.entry([a, b, c, d, e, f]).or_insert(next)
        })
        .collect();
    let mut around: BTreeMap<(u32, u32), VertexMorph> = BTreeMap::new();
    let mut still = vec![(DVec3::ZERO, 0.0); groups.len()];
    for triangle in mesh.indices.chunks_exact(3) {
        let corners = [triangle[0] as usize, triangle[1] as usize, triangle[2] as usize];
        let [p, q, r] = corners.map(|v| Vec3::from(mesh.geometry[v].position).as_dvec3());
        let (e1, e2) = (q - p, r - p);
        let cross = e1.cross(e2);
        let (Some(normal), double) = (cross.try_normalize(), cross.length()) else { continue };
        for v in corners {
            let (sum, area) = &mut still[group_of[v] as usize];
            *sum += cross;
            *area += double;
        }
        let mut targets: Vec<u32> = corners.iter().flat_map(|v| row_of(*v)).map(|delta| delta.target).collect();
        targets.sort_unstable();
        targets.dedup();
        for target in targets {
            let moved =
                |v: usize| row_of(v).iter().find(|d| d.target == target).map_or(DVec3::ZERO, |d| d.position.as_dvec3());
            let [a, b, c] = corners.map(moved);
            let (d1, d2) = (b - a, c - a);
            let change = (e1 + d1).cross(e2 + d2) - cross;
            let (along_1, along_2) = (e2.cross(normal), normal.cross(e1));
            let outer = |u: DVec3, v: DVec3| DMat3::from_cols(u * v.x, u * v.y, u * v.z);
            let gradient = outer(d1, along_1) + outer(d2, along_2);
            for v in corners {
                let entry = around.entry((group_of[v], target)).or_insert(VertexMorph::NOTHING);
                entry.normals += change;
                entry.gradient += gradient;
            }
        }
    }
    for (v, group) in group_of.iter().enumerate() {
        for delta in row_of(v) {
            let entry = around.entry((*group, delta.target)).or_insert(VertexMorph::NOTHING);
            if let Some(normal) = delta.normal {
                entry.authored += normal.as_dvec3();
                entry.authored_count += 1;
            }
        }
    }
    let shifts = model.animation.as_ref().map(largest_shifts).unwrap_or_default();
    let mut morphs = Morphs { motion: motion.clone(), first: vec![0], deltas: Vec::new() };
    for (v, (vertex, group)) in mesh.geometry.iter().zip(&group_of).enumerate() {
        let (sum, area) = still[*group as usize];
        let [x, y, z, _] = vertex.tangent;
        let mut hidden_at = hidden_at(row_of(v));
        let is_hidden = hidden_at.is_some();
        for ((_, target), entry) in around.range((*group, 0)..=(*group, u32::MAX)) {
            let own = row_of(v).iter().find(|d| d.target == *target);
            if let Some(shown) = own.filter(|delta| delta.hidden_at.is_some()) {
                let shift = shifts[*target as usize];
                let unfolded = hidden_at.take().map(|anchor| (Vec3::from(vertex.position) - anchor) / shift);
                morphs.deltas.push(MorphDelta {
                    target: *target,
                    position: unfolded.unwrap_or(shown.position).into(),
                    normal: [0.0; 3],
                    tangent: (Vec3::new(x, y, z) / shift).into(),
                });
                continue;
            }
            let position = own.map_or(Vec3::ZERO, |d| d.position);
            let normal = if entry.authored_count > 0 {
                (entry.authored / f64::from(entry.authored_count)).as_vec3()
            } else {
                // A mirroring joint reverses the winding in the mesh's own space.
                let outward = if sum.dot(Vec3::from(vertex.normal).as_dvec3()) < 0.0 { -1.0 } else { 1.0 };
                let turned = (sum + entry.normals).normalize_or_zero() - sum.normalize_or_zero();
                (turned * outward).as_vec3()
            };
            let tangent = entry.gradient * Vec3::new(x, y, z).as_dvec3() / f64::max(area, f64::MIN_POSITIVE);
            let tangent = if area > 0.0 && !is_hidden { tangent.as_vec3() } else { Vec3::ZERO };
            if position != Vec3::ZERO || normal.length() > LEAST || tangent.length() > LEAST {
                morphs.deltas.push(MorphDelta {
                    target: *target,
                    position: position.into(),
                    normal: normal.into(),
                    tangent: tangent.into(),
                });
            }
        }
        morphs.first.push(morphs.deltas.len() as u32);
    }
    Some(morphs)
}

/// Moves the vertices that morph targets hide to their positions at rest, and makes their tangents zero, by which
/// readers recognise them. Arguments as for [`mesh_morphs`], whose result is for the moved vertices.
pub fn hidden(mesh: &mut Arc<MeshData>, rows: &[u32], model: &Model) {
    let at = |row: &u32| hidden_at(model.morph_rows.0.get(*row as usize)?);
    for (v, position) in rows.iter().map(at).enumerate().filter_map(|(v, at)| Some((v, at?))) {
        let vertex = &mut Arc::make_mut(mesh).geometry[v];
        (vertex.position, vertex.tangent) = (position.into(), [0.0, 0.0, 0.0, vertex.tangent[3]]);
    }
}

/// Returns the position where a vertex is hidden at rest; `None` for a visible vertex.
fn hidden_at(row: &[RowDelta]) -> Option<Vec3> {
    row.iter().find_map(|delta| delta.hidden_at)
}

/// Returns a mesh with the vertices that are hidden at rest as clips show them.
pub fn shown_mesh(mesh: &MeshData, morphs: &Morphs, animation: &Animation) -> MeshData {
    let (mut mesh, shifts) = (mesh.clone(), largest_shifts(animation));
    let vertices = mesh.geometry.iter_mut().enumerate();
    vertices.for_each(|(v, vertex)| *vertex = shown(vertex, morphs.of_vertex(v), &shifts));
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_formats::{Animation, AttributeVertex, GeometryVertex, MorphMotion, MorphTarget, SkinVertex};
    use pelage_import::mesh::{MorphRows, RowDelta};

    /// Makes a square of 4 × 4 cells in the plane z = 0, split along the middle column, and returns the morph deltas of
    /// one target.
    fn square(row: impl Fn(Vec3) -> Option<RowDelta>) -> Morphs {
        let mut mesh = MeshData::default();
        let halves = [0..3u8, 2..5];
        for xs in halves {
            let (first, width) = (mesh.geometry.len() as u32, xs.len() as u32);
            for y in 0..5u8 {
                for x in xs.clone() {
                    mesh.geometry.push(GeometryVertex {
                        position: [f32::from(x), f32::from(y), 0.0],
                        normal: [0.0, 0.0, 1.0],
                        tangent: if first == 0 { [1.0, 0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0, 1.0] },
                        fur_height: 0.1,
                        lean: 0.0,
                    });
                }
            }
            for cell in 0..4 * (width - 1) {
                let a = first + cell / (width - 1) * width + cell % (width - 1);
                mesh.indices.extend([a, a + 1, a + width, a + 1, a + width + 1, a + width]);
            }
        }
        mesh.attributes = vec![AttributeVertex::default(); mesh.geometry.len()];
        mesh.skin = vec![SkinVertex::default(); mesh.geometry.len()];
        let rows = mesh.geometry.iter().map(|v| row(v.position.into()).into_iter().collect()).collect();
        let target = MorphTarget { name: "tilt".into(), node: 0, weight: 0.0 };
        let morphs = MorphMotion { targets: vec![target], channels: Vec::new() };
        let model = Model {
            animation: Some(Animation { morphs, ..Animation::default() }),
            morph_rows: MorphRows(rows),
            ..Model::default()
        };
        let rows: Vec<u32> = (0..mesh.geometry.len() as u32).collect();
        mesh_morphs(&mesh, &rows, &model).unwrap()
    }

    fn near(found: [f32; 3], expected: Vec3) {
        assert!(Vec3::from(found).distance(expected) < 1e-5, "{found:?}, expected {expected}");
    }

    #[test]
    fn normals_and_tangents_rotate_with_the_morphed_surface() {
        let lift = |p: Vec3| Some(RowDelta { target: 0, position: Vec3::Z * p.x, normal: None, hidden_at: None });
        let morphs = square(lift);
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let found: Vec<_> = (0..30).map(|v| morphs.of_vertex(v)[0]).collect();
        for (v, delta) in found.iter().enumerate() {
            // The plane z = 0 becomes z = x, on both sides of the split.
            near(delta.normal, Vec3::new(-half, 0.0, half - 1.0));
            near(delta.tangent, if v < 15 { Vec3::Z } else { Vec3::ZERO });
        }
    }

    #[test]
    fn seam_vertices_share_a_normal_delta_and_distant_ones_have_none() {
        // Only the vertices at one position on the split are lifted.
        let lifted = Vec3::new(2.0, 2.0, 0.0);
        let position = |p: Vec3| if p == lifted { Vec3::Z } else { Vec3::ZERO };
        let plain = square(|p| Some(RowDelta { target: 0, position: position(p), normal: None, hidden_at: None }));
        let at = |morphs: &Morphs, p: [f32; 2]| {
            // Vertices are numbered in rows of three: first those of the left half, then those of the right half, which
            // begins at column 2.
            let (x, y) = (p[0] as usize, p[1] as usize);
            let side = [(x <= 2).then_some(3 * y + x), (x >= 2).then(|| 15 + 3 * y + x - 2)];
            side.into_iter().flatten().map(|v| morphs.of_vertex(v).first().copied()).collect::<Vec<_>>()
        };
        let copies = at(&plain, [2.0, 2.0]);
        assert_eq!(copies[0].unwrap().normal, copies[1].unwrap().normal, "both sides see all triangles");
        assert!(at(&plain, [1.0, 2.0])[0].unwrap().normal[0] < -0.1, "its neighbours turn away from it");
        assert_eq!(at(&plain, [0.0, 0.0]), [None], "what is far does not turn");
        let authored = square(|p| {
            Some(RowDelta {
                target: 0,
                position: position(p),
                normal: (p == lifted).then_some(Vec3::X),
                hidden_at: None,
            })
        });
        assert!(at(&authored, [2.0, 2.0]).iter().all(|delta| delta.unwrap().normal == [1.0, 0.0, 0.0]));
    }

    #[test]
    fn model_without_targets_has_no_morphs() {
        assert_eq!(mesh_morphs(&MeshData::default(), &[], &Model::default()), None);
    }
}
