//! Surface to be painted: welded mesh with its thickness, combing direction and darkness.

use super::head_frame::HeadFrame;
use super::model::PaintedModel;
use crate::stages::cells::closest_barycentric;
use crate::stages::groom::{WeldedMesh, thickness};
use crate::stages::surface::Surface;
use crate::stages::triangle_tree::TriangleTree;
use glam::{Vec3, Vec3A};
use obvhs::triangle::Triangle;
use pelage_formats::meaning::{linear_to_srgb, luminance};
use pelage_formats::{InkVertex, StrokeAnchor};

/// Display brightness of the surface from which it counts as white, and up to which it counts as black.
const WHITE: f32 = 0.82;
const BLACK: f32 = 0.20;
/// Excess of red over the other components, linear, from which a colour is painted as a mineral pigment.
const VIVID: f32 = 0.25;
/// Number of smoothing steps of the combing direction.
const COMB_ROUNDS: usize = 4;

/// Surface to be painted. Lengths are in units of [`Canvas::size`].
pub(super) struct Canvas {
    /// Diagonal of the bounding box at rest, metres.
    pub(super) size: f32,
    /// Welded mesh; its lengths are in body radii. [`Canvas::unit`] converts them.
    pub(super) skin: WeldedMesh,
    /// Body radius in units of `size`.
    pub(super) unit: f32,
    /// Position of each welded vertex, in units of `size`, around the centre of the bounds.
    pub(super) positions: Vec<Vec3>,
    /// Mesh vertex that represents each welded vertex.
    pub(super) vertex_of: Vec<u32>,
    /// Thickness of the body at each welded vertex.
    pub(super) thickness: Vec<f32>,
    /// Unit combing direction at each welded vertex, tangential.
    pub(super) comb: Vec<Vec3>,
    /// Darkness at each welded vertex, 0 for white to 1 for black: of the colour, by the recipe's washes and full ink.
    pub(super) darkness: Vec<f32>,
    /// Mineral colour at each welded vertex, linear RGB, where the colour is vivid.
    pub(super) pigment: Vec<Option<[f32; 3]>>,
    /// Whether hair grows at each welded vertex.
    pub(super) furred: Vec<bool>,
    /// Whether each welded vertex belongs to an eye by the name of its material.
    pub(super) eye: Vec<bool>,
    /// Share of the head, ears included, at each welded vertex, 0..=1.
    pub(super) head: Vec<f32>,
    /// Frame of the head; `None` if no head is known.
    pub(super) face: Option<HeadFrame>,
    tree: TriangleTree,
}

/// Point on the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) face: usize,
    pub(super) weights: Vec3,
    pub(super) position: Vec3,
}

impl Canvas {
    pub(super) fn new(model: &PaintedModel<'_>, is_eye: impl Fn(&str) -> bool) -> Self {
        let PaintedModel { surface, colors, bounds, materials, furred, head, ink, .. } = *model;
        let Surface { mesh, rest, input_vertex, .. } = surface;
        let center = Vec3::from(bounds.center);
        let diagonal = Vec3::from(bounds.min).distance(Vec3::from(bounds.max));
        let size = if diagonal > 0.0 && diagonal.is_finite() { diagonal } else { 1.0 };
        let radius = if bounds.radius > 0.0 { bounds.radius } else { 1.0 };
        let skin = WeldedMesh::new(mesh, rest, center, radius);
        let unit = radius / size;
        let positions: Vec<Vec3> = skin.positions.iter().map(|p| *p * unit).collect();
        let count = positions.len();
        let mut vertex_of = vec![u32::MAX; count];
        for (v, place) in skin.place_of.iter().enumerate() {
            let of = &mut vertex_of[*place as usize];
            *of = (*of).min(v as u32);
        }
        let thickness = thickness(&skin).into_iter().map(|t| t.map_or(0.0, |t| t * unit)).collect();

        let mut sums = vec![(Vec3::ZERO, 0.0_f32); count];
        let mut hair = vec![false; count];
        let mut eye = vec![false; count];
        for part in &mesh.parts {
            let named_eye = materials.get(part.material).is_some_and(|m| is_eye(&m.name));
            for triangle in &mesh.triangles[part.first_triangle..part.first_triangle + part.triangle_count] {
                for (v, corner) in triangle.iter().zip(Vec3::AXES) {
                    let place = skin.place_of[*v as usize] as usize;
                    sums[place].0 += colors.at(mesh, part.material, triangle, corner);
                    sums[place].1 += 1.0;
                    hair[place] |= furred.get(part.material).copied().unwrap_or(false);
                    eye[place] |= named_eye;
                }
            }
        }
        let colors: Vec<Vec3> = sums.iter().map(|(sum, n)| (*sum / n.max(1.0)).clamp(Vec3::ZERO, Vec3::ONE)).collect();
        let mut shares = vec![0.0_f32; count];
        for (place, v) in skin.place_of.iter().zip(input_vertex) {
            let own = head.and_then(|head| head.share.get(*v as usize)).copied().unwrap_or(0.0);
            shares[*place as usize] = shares[*place as usize].max(own);
        }
        let at = |p: Vec3| (p - center) / size;
        let face = head.and_then(|head| HeadFrame::new(at(head.nose_m), at(head.middle_m), head.forward));
        let vivid = |color: &Vec3| (color.x - color.y.max(color.z) > VIVID).then(|| color.to_array());
        let corners = |f: &[u32; 3]| f.map(|p| Vec3A::from(positions[p as usize]));
        let triangles: Vec<Triangle> =
            skin.faces.iter().map(corners).map(|[v0, v1, v2]| Triangle { v0, v1, v2 }).collect();
        let mut darkness: Vec<f32> = colors.iter().copied().map(darkness_of).collect();
        for (darkness, [wash, solid]) in darkness.iter_mut().zip(ink_of(&skin, ink)) {
            let washed = *darkness * wash;
            *darkness = washed + (1.0 - washed) * solid;
        }
        let mut canvas = Self {
            size,
            unit,
            vertex_of,
            thickness,
            comb: Vec::new(),
            darkness,
            pigment: colors.iter().map(vivid).collect(),
            furred: hair,
            eye,
            head: shares,
            face,
            tree: TriangleTree::new(&triangles),
            positions,
            skin,
        };
        canvas.comb = canvas.combed(surface);
        canvas
    }

    /// Returns the combing direction at each welded vertex: that of the hair tile, smoothed.
    fn combed(&self, surface: &Surface) -> Vec<Vec3> {
        let Surface { mesh, rest, tangents, .. } = surface;
        let mut comb = vec![Vec3::ZERO; self.positions.len()];
        for (triangle, face) in mesh.triangles.iter().zip(&self.skin.faces) {
            // Tangents are in the space of the mesh, so they are carried to the rest pose by the edges of the triangle.
            let [p, q, r] = triangle.map(|v| mesh.positions[v as usize]);
            let (e1, e2) = (q - p, r - p);
            let (a, b, c) = (e1.dot(e1), e1.dot(e2), e2.dot(e2));
            let det = a * c - b * b;
            if det.is_nan() || det <= 0.0 {
                continue;
            }
            let [p, q, r] = triangle.map(|v| rest.positions[v as usize]);
            for (v, place) in triangle.iter().zip(face) {
                let tangent = tangents[*v as usize];
                let along = mesh.normals[*v as usize].cross(tangent.truncate()) * tangent.w;
                let (x, y) = (along.dot(e1), along.dot(e2));
                comb[*place as usize] += (q - p) * ((x * c - y * b) / det) + (r - p) * ((y * a - x * b) / det);
            }
        }
        for _ in 0..COMB_ROUNDS {
            let before = comb.clone();
            for (place, along) in comb.iter_mut().enumerate() {
                let around: Vec3 = self.skin.neighbors_of(place as u32).map(|n| before[n as usize]).sum();
                let mean = before[place].normalize_or_zero() + 1.5 * around.normalize_or_zero();
                let normal = self.skin.normals[place];
                *along = (mean - normal * normal.dot(mean)).normalize_or_zero();
            }
        }
        comb
    }

    /// Returns the value at a place of numbers per welded vertex.
    pub(super) fn at(&self, values: &[f32], place: &Place) -> f32 {
        let [a, b, c] = self.skin.faces[place.face].map(|p| values[p as usize]);
        Vec3::new(a, b, c).dot(place.weights)
    }

    /// Returns the unit vector at a place of vectors per welded vertex; zero if they cancel out.
    pub(super) fn vector_at(&self, values: &[Vec3], place: &Place) -> Vec3 {
        let [a, b, c] = self.skin.faces[place.face].map(|p| values[p as usize]);
        (a * place.weights.x + b * place.weights.y + c * place.weights.z).normalize_or_zero()
    }

    /// Returns the corners of a face.
    pub(super) fn corners(&self, face: usize) -> [Vec3; 3] {
        self.skin.faces[face].map(|p| self.positions[p as usize])
    }

    pub(super) fn place(&self, face: usize, weights: Vec3) -> Place {
        let [a, b, c] = self.corners(face);
        Place { face, weights, position: a * weights.x + b * weights.y + c * weights.z }
    }

    /// Returns the nearest point of the surface that faces about as `normal`; `None` if none does.
    pub(super) fn nearest(&self, p: Vec3, normal: Vec3) -> Option<Place> {
        self.nearest_on(p, normal, &|_| true)
    }

    /// Returns the nearest point of the faces chosen by `on` that face about as `normal`; `None` if none does.
    pub(super) fn nearest_on(&self, p: Vec3, normal: Vec3, on: &dyn Fn([u32; 3]) -> bool) -> Option<Place> {
        let mut found = None;
        self.tree.minimum(p, |face, best| {
            let corners = self.corners(face as usize);
            let across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            if across.dot(normal) < 0.0 || !on(self.skin.faces[face as usize]) {
                return f32::INFINITY;
            }
            let weights = closest_barycentric(p, corners);
            let place = self.place(face as usize, weights);
            let square = place.position.distance_squared(p);
            if square < best {
                found = Some(place);
            }
            square
        });
        found
    }

    pub(super) fn anchor(&self, place: &Place) -> StrokeAnchor {
        let vertices = self.skin.faces[place.face].map(|p| self.vertex_of[p as usize]);
        anchor(vertices, place.weights.y, place.weights.z)
    }
}

/// Returns the amount of wash and of full ink at each welded vertex, 0..=1, the mean over the vertices there.
fn ink_of(skin: &WeldedMesh, ink: &[InkVertex]) -> Vec<[f32; 2]> {
    let mut sums = vec![([0.0_f32; 2], 0.0_f32); skin.positions.len()];
    for (place, own) in skin.place_of.iter().zip(ink) {
        let (sum, count) = &mut sums[*place as usize];
        let own = [own.amount, own.solid].map(|share| f32::from(share) / 255.0);
        (*sum, *count) = ([sum[0] + own[0], sum[1] + own[1]], *count + 1.0);
    }
    sums.iter().map(|(sum, count)| if *count > 0.0 { sum.map(|x| x / count) } else { [1.0, 0.0] }).collect()
}

/// Returns the darkness of a linear colour, 0 for white to 1 for black.
pub(super) fn darkness_of(color: Vec3) -> f32 {
    let shown = f32::from(linear_to_srgb(luminance(color.as_dvec3()) as f32)) / 255.0;
    ((WHITE - shown) / (WHITE - BLACK)).clamp(0.0, 1.0)
}

/// Returns the anchor with the weights `b` and `c` of the second and third vertex.
pub(super) fn anchor(vertices: [u32; 3], b: f32, c: f32) -> StrokeAnchor {
    let [b, c] = [b, c].map(|w| (w.clamp(0.0, 1.0) * 65535.0).round() as u16);
    StrokeAnchor { vertices, weights: [b, c.min(65535 - b)] }
}
