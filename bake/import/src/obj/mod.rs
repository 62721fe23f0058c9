//! Wavefront OBJ ("Object Files (.obj)", Advanced Visualizer manual, appendix B1) and its material files.
//!
//! * `statements`: splits the text into logical lines
//! * `faces`: gathers and checks the statements that define the shape
//! * `polygon`: triangulates polygons
//! * `materials`: reads the .mtl files and the images that they name
//!
//! All triangles with the same object, group and material become one part, whatever the order of the file, because
//! exporters switch materials back and forth. Smoothing groups are ignored, because fur has no creases. Points, lines
//! and free-form surfaces are ignored with a warning. The texture coordinate v increases upwards in an OBJ, but
//! downwards in the imported model.

mod faces;
mod fault;
mod materials;
mod polygon;
mod statements;

use super::normals::{self, NormalInput};
use super::notes::Notes;
use super::options::ImportOptions;
use super::orient;
use super::source::Resolve;
use crate::BakeError;
use crate::mesh::{Mesh, MeshPart, Model, RestPose};
use faces::{Corner, Faces};
use fault::fault;
use glam::{Vec2, Vec3};
use materials::Library;
use pelage_formats::Limits;
use std::collections::HashMap;

pub(super) use statements::begins_like_obj;

/// Reads an OBJ model. The arguments are those of [`super::import`].
pub(super) fn read(
    file: &str,
    bytes: &[u8],
    resolve: &mut Resolve<'_>,
    options: &ImportOptions,
    mut notes: Notes,
) -> Result<Model, BakeError> {
    let text = statements::decode(file, bytes)?;
    let faces = Faces::read(file, &text, options.unit_m, &mut notes)?;
    let mut library = Library::read(&faces.libraries, resolve, &mut notes);
    let mut pieces: Vec<PartMesh> = Vec::new();
    // Parts are stored in the order of their first face in the file.
    let mut piece_of_part: Vec<Option<usize>> = vec![None; faces.parts.len()];
    let (mut vertices, mut corners) = (0, 0);
    for face in &faces.list {
        let piece = *piece_of_part[face.part].get_or_insert_with(|| {
            let part = &faces.parts[face.part];
            let material = library.material(&part.material, resolve, &mut notes);
            pieces.push(PartMesh::new(part.label(), part.names(), material));
            pieces.len() - 1
        });
        let outline = &faces.corners[face.first..face.first + face.count];
        let before = pieces[piece].positions.len();
        pieces[piece].add(&faces, outline, face.line, &mut notes);
        vertices += pieces[piece].positions.len() - before;
        corners += 3 * (face.count - 2);
        let limits = Limits::default();
        if vertices > limits.vertices as usize || corners > limits.indices as usize {
            let (v, i) = (limits.vertices, limits.indices);
            let reason =
                format!("takes the model to {vertices} vertices and {corners} indices, expected at most {v} and {i}");
            return Err(fault(file, face.line, reason));
        }
    }
    let mut shapes: Vec<NormalInput<'_>> = pieces
        .iter_mut()
        .map(|p| {
            // An empty list means that the file has no normals. This needs no warning.
            if !p.has_normals {
                p.normals.clear();
            }
            NormalInput { label: &p.label, positions: &p.positions, triangles: &p.triangles, normals: &mut p.normals }
        })
        .collect();
    normals::complete_normals(&mut notes, &mut shapes);
    let mut mesh = Mesh::default();
    let mut authored = Vec::new();
    for piece in pieces {
        authored.push(piece.has_normals);
        piece.append_to(&mut mesh, &mut notes);
    }
    let rest = RestPose::of(&mesh, None);
    orient::face_outward(&mut notes, &mut mesh, None, &rest, &authored);
    let (warnings, inputs) = notes.finish();
    let (materials, images) = (library.used, library.images.images);
    Ok(Model { mesh, materials, images, inputs, warnings, ..Model::default() })
}

/// Triangles of one part, which share no vertices with other parts.
struct PartMesh {
    label: String,
    names: Vec<String>,
    material: usize,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    colors: Vec<[u8; 4]>,
    triangles: Vec<[u32; 3]>,
    has_normals: bool,
    corners_with_uv: usize,
    corners_without_uv: usize,
    known: HashMap<Corner, u32>,
}

impl PartMesh {
    fn new(label: String, names: Vec<String>, material: usize) -> Self {
        Self {
            label,
            names,
            material,
            positions: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            colors: Vec::new(),
            triangles: Vec::new(),
            has_normals: false,
            corners_with_uv: 0,
            corners_without_uv: 0,
            known: HashMap::new(),
        }
    }

    fn add(&mut self, faces: &Faces, outline: &[Corner], line: usize, notes: &mut Notes) {
        let vertices: Vec<u32> = outline.iter().map(|corner| self.vertex(faces, corner)).collect();
        let points: Vec<Vec3> = vertices.iter().map(|v| self.positions[*v as usize]).collect();
        let cut = polygon::triangulate(&points);
        if !cut.clean {
            let n = outline.len();
            notes.warn(format!(
                "line {line}: the polygon of {n} corners crosses itself or is too large; its triangles may overlap"
            ));
        }
        self.triangles.extend(cut.triangles.iter().map(|t| t.map(|corner| vertices[corner])));
    }

    fn vertex(&mut self, faces: &Faces, corner: &Corner) -> u32 {
        if corner.uv.is_some() {
            self.corners_with_uv += 1;
        } else {
            self.corners_without_uv += 1;
        }
        *self.known.entry(*corner).or_insert_with(|| {
            self.positions.push(faces.positions[corner.position as usize]);
            self.colors.push(faces.colors.get(corner.position as usize).copied().unwrap_or([255; 4]));
            self.uvs.push(corner.uv.map_or(Vec2::ZERO, |i| faces.uvs[i as usize]));
            self.normals.push(corner.normal.map_or(Vec3::ZERO, |i| faces.normals[i as usize]));
            self.has_normals |= corner.normal.is_some();
            self.positions.len() as u32 - 1
        })
    }

    fn append_to(self, mesh: &mut Mesh, notes: &mut Notes) {
        if self.corners_with_uv > 0 && self.corners_without_uv > 0 {
            let (n, all) = (self.corners_without_uv, self.corners_with_uv + self.corners_without_uv);
            let label = &self.label;
            notes.warn(format!(
                "{label}: {n} of {all} corners have no texture coordinates; the part is read without any"
            ));
        }
        let (first, first_triangle) = (mesh.positions.len() as u32, mesh.triangles.len());
        mesh.positions.extend(self.positions);
        mesh.normals.extend(self.normals);
        mesh.uvs.extend(self.uvs);
        mesh.colors.extend(self.colors);
        mesh.triangles.extend(self.triangles.iter().map(|t| t.map(|i| first + i)));
        mesh.parts.push(MeshPart {
            source: self.label,
            names: self.names,
            material: self.material,
            first_triangle,
            triangle_count: self.triangles.len(),
            has_uvs: self.corners_without_uv == 0,
        });
    }
}
