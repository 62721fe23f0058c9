//! Ink style of a package, in GPU memory.

use super::upload::Uploader;
use crate::error::RuntimeError;
use pelage_formats::{InkInfo, InkTextures, MeshView, Package};

/// Textures and vertices of a model's ink style.
#[derive(Debug)]
pub(crate) struct ModelInk {
    pub(crate) info: InkInfo,
    /// Buffer with one [`pelage_formats::InkVertex`] per vertex.
    pub(crate) vertices: wgpu::Buffer,
    pub(crate) stroke: wgpu::TextureView,
    pub(crate) wash: wgpu::TextureView,
    pub(crate) paper: wgpu::TextureView,
    /// Fur stroke texture with two array layers: from above and from the side.
    pub(crate) fur: Option<wgpu::TextureView>,
    /// Number of wash tile periods per unit of the stored mesh. With a skeleton, that unit need not be the metre.
    pub(crate) periods: f32,
}

/// Uploads the ink style. Returns it with its size in bytes; `None` for a package without one.
pub(super) fn load(
    uploader: &Uploader<'_>,
    package: &Package<'_>,
    mesh: &MeshView<'_>,
) -> Result<Option<(ModelInk, u64)>, RuntimeError> {
    let (Some(ink), Some(textures)) = (package.ink()?, package.ink_textures()?) else { return Ok(None) };
    let InkTextures { stroke, wash, paper, fur } = textures;
    let vertices = uploader.buffer("ink vertices", ink.vertices, wgpu::BufferUsages::VERTEX)?;
    let mut bytes = vertices.size();
    let mut view = |index, texture: &pelage_formats::TextureView<'_>, dimension| {
        bytes += uploader.device_bytes(texture);
        let array = wgpu::TextureViewDescriptor { dimension: Some(dimension), ..Default::default() };
        Ok::<_, RuntimeError>(uploader.texture(index, texture)?.create_view(&array))
    };
    use wgpu::TextureViewDimension::{D2, D2Array};
    let info = &ink.info;
    let stroke = view(info.stroke_texture, &stroke, D2)?;
    let wash = view(info.wash_texture, &wash, D2)?;
    let paper = view(info.paper_texture, &paper, D2)?;
    let fur = match (info.fur_texture, fur) {
        (Some(index), Some(fur)) => Some(view(index, &fur, D2Array)?),
        _ => None,
    };
    let periods = metres_per_unit(package, mesh) / info.grain_size_m;
    Ok(Some((ModelInk { info: info.clone(), vertices, stroke, wash, paper, fur, periods }, bytes)))
}

/// Returns the diagonal of the bounding box of the stored mesh, in its own unit.
pub(super) fn stored_diagonal(mesh: &MeshView<'_>) -> f32 {
    use glam::Vec3;
    let mut least = Vec3::INFINITY;
    let mut most = Vec3::NEG_INFINITY;
    for vertex in mesh.geometry() {
        least = least.min(Vec3::from(vertex.position));
        most = most.max(Vec3::from(vertex.position));
    }
    most.distance(least)
}

/// Returns the metres per unit of the stored mesh: the ratio of its extent at rest to its stored extent.
fn metres_per_unit(package: &Package<'_>, mesh: &MeshView<'_>) -> f32 {
    use glam::Vec3;
    let bounds = &package.manifest().bounds;
    let at_rest = Vec3::from(bounds.max).distance(Vec3::from(bounds.min));
    let ratio = at_rest / stored_diagonal(mesh);
    // The ratio is undefined for a mesh of a single point.
    if ratio.is_finite() && ratio > 0.0 { ratio } else { 1.0 }
}
