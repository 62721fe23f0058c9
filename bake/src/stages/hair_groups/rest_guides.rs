//! Guides of a package in the rest pose, for editing in other programs: decodes them to points and writes edited guides
//! back.

use super::body::SurfaceIndex;
use glam::{DVec3, Vec3};
use pelage_formats::meaning::hair_groups::triangle_frame;
use pelage_formats::meaning::measured_vertices;
use pelage_formats::{FormatError, HairGroup, Package, TrianglePoint};

/// Largest distance of a root from the scalp, as a share of the model's size. A root farther away was not meant for
/// this scalp.
const MAX_ROOT_DISTANCE: f32 = 0.1;
/// Tolerance for unmoved roots, as a share of the largest coordinate: other programs convert coordinates to another
/// unit and back, which rounds them.
const UNMOVED_TOLERANCE: f32 = 4e-6;
/// Largest stored component of an offset; represents the reach of the group.
const MAX_STORED: f64 = 32767.0;

/// Mesh of a package in the rest pose; surface that is hidden at rest as clips show it.
#[derive(Clone, Debug, Default)]
pub struct RestMesh {
    triangles: Vec<[u32; 3]>,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
}

impl RestMesh {
    /// Reads the mesh of a package in the rest pose.
    ///
    /// Fails with [`FormatError`] for a damaged section.
    pub fn of(package: &Package<'_>) -> Result<Self, FormatError> {
        let Some(mesh) = package.mesh()? else { return Ok(Self::default()) };
        let vertices = measured_vertices(package, &mesh)?;
        let (positions, normals) = vertices.iter().map(|v| (Vec3::from(v.position), Vec3::from(v.normal))).unzip();
        let indices: Vec<u32> = mesh.indices().collect();
        Ok(Self { triangles: indices.as_chunks::<3>().0.to_vec(), positions, normals })
    }

    /// Returns the number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }
}

/// Quantised offsets of a guide as stored in a package, if known.
pub type StoredOffsets<'a> = Option<&'a [[i16; 3]]>;

/// Converts a quantised offset to metres.
fn decoded(offset: &[i16; 3], reach_m: f32) -> DVec3 {
    DVec3::from(offset.map(|x| f64::from(x.max(-32767)) / MAX_STORED)) * f64::from(reach_m)
}

/// Guides on a mesh in the rest pose. All triangles referenced by groups must exist.
#[derive(Clone, Copy, Debug)]
pub struct GuidesAtRest<'a>(pub &'a RestMesh);

impl GuidesAtRest<'_> {
    /// Returns the points of a guide with the given root and quantised offsets, root first: world space, metres.
    pub fn points(&self, root: &TrianglePoint, offsets: &[[i16; 3]], reach_m: f32) -> Vec<Vec3> {
        let (start, frame) = (self.place(root), self.frame(root));
        let point = |offset: &[i16; 3]| (start + frame * decoded(offset, reach_m)).as_vec3();
        std::iter::once(start.as_vec3()).chain(offsets.iter().map(point)).collect()
    }

    /// Writes edited guides into a group. Each guide must have as many points as the guides of the group. A moved root
    /// is placed at the nearest point of the scalp; the other points keep their positions. The group's reach grows if
    /// necessary.
    ///
    /// * `guides`: points of each guide in world space, metres, all finite
    /// * `exact`: quantised offsets of each guide, reused if the guide's points are still equal to the decoded ones
    ///
    /// Fails with the index of the guide, and the reason.
    pub fn set(
        &self,
        group: &mut HairGroup,
        guides: &[Vec<Vec3>],
        exact: &[StoredOffsets<'_>],
    ) -> Result<(), (usize, String)> {
        let old_reach_m = group.reach_m;
        let exact: Vec<StoredOffsets<'_>> = group
            .roots()
            .zip(guides)
            .zip(exact)
            .map(|((root, points), kept)| kept.filter(|offsets| self.points(&root, offsets, old_reach_m) == *points))
            .collect();
        self.move_roots(group, guides)?;
        // Barycentric weights of roots are quantised, so offsets are relative to the quantised root.
        let local: Vec<Vec<DVec3>> = group
            .roots()
            .zip(guides.iter().zip(&exact))
            .map(|(root, (points, exact))| match exact {
                Some(offsets) => offsets.iter().map(|offset| decoded(offset, old_reach_m)).collect(),
                None => {
                    let (start, back) = (self.place(&root), self.frame(&root).transpose());
                    points[1..].iter().map(|p| back * (p.as_dvec3() - start)).collect()
                }
            })
            .collect();
        let reach = |points: &Vec<DVec3>| points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        let most = f64::from(HairGroup::MOST_REACH_M);
        if let Some((guide, far)) = local.iter().map(reach).enumerate().find(|(_, far)| *far > most) {
            return Err((guide, format!("it reaches {far} m from its root, expected at most {most}")));
        }
        let farthest = local.iter().map(reach).fold(0.0, f64::max);
        // A point may exceed the reach by half a quantisation step, because rounding brings it back.
        if farthest > f64::from(group.reach_m) * (1.0 + 0.5 / MAX_STORED) {
            group.reach_m = farthest as f32;
        }
        let whole = |x: f64| (x / f64::from(group.reach_m) * MAX_STORED).round() as i16;
        let stored = |(local, exact): (&Vec<DVec3>, &StoredOffsets<'_>)| match exact {
            Some(offsets) if group.reach_m == old_reach_m => offsets.to_vec(),
            _ => local.iter().map(|p| p.to_array().map(whole)).collect::<Vec<_>>(),
        };
        let offsets = local.iter().zip(&exact).flat_map(stored).collect();
        group.guide_offsets = offsets;
        Ok(())
    }

    fn move_roots(&self, group: &mut HairGroup, guides: &[Vec<Vec3>]) -> Result<(), (usize, String)> {
        let moved: Vec<(usize, Vec3, Vec3)> = group
            .roots()
            .zip(guides)
            .enumerate()
            .map(|(number, (root, points))| (number, self.place(&root).as_vec3(), points[0]))
            .filter(|(_, stood, stands)| stands.distance(*stood) > UNMOVED_TOLERANCE * stood.abs().max_element())
            .collect();
        if moved.is_empty() {
            return Ok(());
        }
        let RestMesh { triangles, positions, normals } = self.0;
        let body = SurfaceIndex::new(triangles, positions, normals);
        let places = || positions.iter().copied();
        let (low, high) = (places().fold(Vec3::INFINITY, Vec3::min), places().fold(Vec3::NEG_INFINITY, Vec3::max));
        let loose_m = 0.5 * MAX_ROOT_DISTANCE * low.distance(high);
        let mut on_scalp = vec![group.scalp.is_empty(); triangles.len()];
        group.scalp.iter().for_each(|(triangle, _)| on_scalp[*triangle as usize] = true);
        for (number, stood, stands) in moved {
            let near = body.nearest(stands, loose_m, |triangle| on_scalp[triangle as usize]).ok_or_else(|| {
                let reason = format!(
                    "its root was moved from {stood} to {stands}, expected a position within {loose_m} m of the scalp"
                );
                (number, reason)
            })?;
            group.guide_roots[number] = (near.at.triangle, near.at.stored_weights());
        }
        Ok(())
    }

    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.0.triangles[triangle as usize].map(|v| self.0.positions[v as usize])
    }

    fn place(&self, root: &TrianglePoint) -> DVec3 {
        let [a, b, c] = self.corners(root.triangle).map(Vec3::as_dvec3);
        let [u, v, w] = root.weights.map(f64::from);
        a * u + b * v + c * w
    }

    fn frame(&self, root: &TrianglePoint) -> glam::DMat3 {
        triangle_frame(self.corners(root.triangle)).as_dmat3()
    }
}
