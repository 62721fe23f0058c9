//! Export of the posed mesh as Wavefront OBJ, with its materials in a separate file.

use crate::strands::PosedMesh;
use glam::{DVec3, Vec4};
use std::io::{self, Write};

/// Writes the mesh: positions, texture coordinates, normals, and triangles grouped by material. `materials` is the name
/// of the .mtl file written by [`write_mtl`].
///
/// Fails with errors of `out`.
pub fn write_obj(skin: &PosedMesh, materials: &str, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "# {} vertices, {} triangles, metres, y up", skin.vertices.len(), skin.triangles.len())?;
    writeln!(out, "mtllib {materials}")?;
    for v in &skin.vertices {
        let p = v.position_ws.as_vec3();
        writeln!(out, "v {} {} {}", p.x, p.y, p.z)?;
    }
    for v in &skin.vertices {
        // OBJ counts image rows from the bottom.
        writeln!(out, "vt {} {}", v.base_uv.x, 1.0 - v.base_uv.y)?;
    }
    for v in &skin.vertices {
        let n = v.normal_ws.as_vec3();
        writeln!(out, "vn {} {} {}", n.x, n.y, n.z)?;
    }
    let mut last = None;
    for (triangle, material) in skin.triangles.iter().zip(&skin.material_of) {
        if last != Some(*material) {
            writeln!(out, "usemtl {}", name(skin, *material as usize))?;
            last = Some(*material);
        }
        let [a, b, c] = triangle.map(|v| v + 1);
        writeln!(out, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}")?;
    }
    Ok(())
}

/// Writes the mesh's materials. `Kd` is the mean base colour of a material over the mesh surface, weighted by area.
///
/// Fails with errors of `out`.
pub fn write_mtl(skin: &PosedMesh, out: &mut dyn Write) -> io::Result<()> {
    let mut sums = vec![(Vec4::ZERO, 0.0f32); skin.materials.len()];
    for (triangle, material) in skin.material_of.iter().enumerate() {
        let [a, b, c] = skin.corners(triangle).map(|c| c.position_ws);
        let area = (b - a).cross(c - a).length() as f32;
        let (sum, total) = &mut sums[*material as usize];
        *sum += skin.base_color(triangle, DVec3::splat(1.0 / 3.0)) * area;
        *total += area;
    }
    for (i, (sum, area)) in sums.iter().enumerate() {
        let color = if *area > 0.0 { *sum / *area } else { skin.materials[i].base_color };
        writeln!(out, "newmtl {}\nKd {} {} {}", name(skin, i), color.x, color.y, color.z)?;
    }
    Ok(())
}

/// Returns a unique name without spaces for a material.
fn name(skin: &PosedMesh, material: usize) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    let name: String = skin.materials[material].name.chars().map(plain).collect();
    format!("{material}_{name}")
}
