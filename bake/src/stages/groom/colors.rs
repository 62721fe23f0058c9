//! Where the colour of hair and skin comes from.

use super::maps::Maps;
use crate::BakeError;
use crate::mesh::{Image, Mesh, Model};
use crate::recipe::ColorMap;
use pelage_formats::meaning::srgb_value_to_linear;

/// Colours of a model as the package stores them: factor, texture and vertex colour multiply each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Colors {
    /// Images that a material uses.
    pub images: Vec<Image>,
    /// One per material.
    pub materials: Vec<MaterialColor>,
    /// One per vertex, linear RGBA.
    pub vertices: Vec<[u8; 4]>,
}

/// Colour of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialColor {
    /// Linear RGBA.
    pub factor: [f32; 4],
    /// Index into [`Colors::images`], sRGB.
    pub image: Option<usize>,
}

/// Takes each material's colour from the model or from `groom.color`.
///
/// * `mesh`: the model's mesh as the package will have it
/// * `furred`: one per material
/// * `base_color`: whether the model's own colours show on furred materials where `groom.color` says nothing
///
/// # Errors
/// [`BakeError::Internal`] where an image was not read.
pub fn colors(
    model: &Model,
    mesh: &Mesh,
    maps: &Maps<'_>,
    furred: &[bool],
    base_color: bool,
) -> Result<Colors, BakeError> {
    let mut colors = Colors { vertices: vec![[255; 4]; mesh.positions.len()], ..Colors::default() };
    let mut known: Vec<&Image> = Vec::new();
    let mut keeps_vertex_colors = Vec::new();
    for (i, material) in model.materials.iter().enumerate() {
        let own = base_color || !furred.get(i).copied().unwrap_or(false);
        let [.., alpha] = material.base_color;
        let (factor, image, vertex) = match maps.color(i) {
            Some(ColorMap::Constant(color)) => {
                let [r, g, b] = color.0.map(srgb_value_to_linear);
                ([r, g, b, alpha], None, false)
            }
            Some(ColorMap::Vertex) => ([1.0, 1.0, 1.0, alpha], None, true),
            Some(ColorMap::Image(path)) => ([1.0, 1.0, 1.0, alpha], Some(maps.image(path)?), false),
            None if own => {
                let image = material.base_color_image.and_then(|image| model.images.get(image));
                (material.base_color, image, true)
            }
            None => ([1.0; 4], None, false),
        };
        let image = image.map(|image| {
            let at = known.iter().position(|k| std::ptr::eq(*k, image)).unwrap_or(known.len());
            if at == known.len() {
                known.push(image);
            }
            at
        });
        colors.materials.push(MaterialColor { factor, image });
        keeps_vertex_colors.push(vertex);
    }
    colors.images = known.into_iter().cloned().collect();
    for part in mesh.parts.iter().filter(|p| keeps_vertex_colors.get(p.material).copied().unwrap_or(false)) {
        for v in mesh.triangles[part.first_triangle..part.first_triangle + part.triangle_count].iter().flatten() {
            colors.vertices[*v as usize] = mesh.colors[*v as usize];
        }
    }
    Ok(colors)
}
