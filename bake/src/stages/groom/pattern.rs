//! Patterns of the fur: an image projected through space and painted onto the furred mesh.
//!
//! The colour is a function of position and normal alone. So it continues across the borders of charts without a seam,
//! and a model needs no texture coordinates. If the model has base-colour textures, they are painted into the same
//! texture as the pattern.

use super::atlas::{Atlas, linear_image, srgb_image};
use super::canvas::SurfacePoint;
use super::colors::Colors;
use super::maps::{GroomTextures, MapImages};
use super::projection::Projection;
use crate::recipe::{ColorParams, PatternWrap};
use crate::sample::{Encoding, Wrap, bilinear};
use crate::stages::surface::Surface;
use glam::{Vec3, Vec4};
use pelage_formats::Bounds;
use pelage_import::BakeError;
use pelage_import::mesh::Image;
use std::sync::Arc;

/// Image projected through space.
#[derive(Clone, Copy, Debug)]
pub struct Pattern<'a> {
    image: &'a Image,
    projection: Projection,
}

impl<'a> Pattern<'a> {
    /// Returns the pattern of a recipe on a model with these bounds; `None` if the recipe has no pattern.
    ///
    /// Fails with [`BakeError::Internal`] if the image was not read.
    pub fn new(color: &ColorParams, images: &'a MapImages, bounds: &Bounds) -> Result<Option<Self>, BakeError> {
        let Some(path) = &color.pattern else { return Ok(None) };
        let image = images.get(&path.0)?;
        let wrap = match color.pattern_wrap {
            PatternWrap::Repeat => Wrap::Repeat,
            PatternWrap::Clamp => Wrap::Clamp,
        };
        let projection = Projection::new(color.pattern_projection, wrap, image, bounds, color.pattern_size_m);
        Ok(Some(Self { image, projection }))
    }

    /// Returns the width of the image on the model, metres.
    pub fn width_m(&self) -> f32 {
        self.projection.width_m()
    }

    /// Returns linear RGB at a position, metres at rest, with that unit normal. Transparent texels count as white, so
    /// that they change nothing.
    pub fn color(&self, position: Vec3, normal: Vec3) -> Vec3 {
        self.projection.read(position, normal, |at| {
            let texel = bilinear(self.image, at.uv, self.projection.wrap, Encoding::Srgb);
            Vec3::ONE.lerp(texel.truncate(), texel.w)
        })
    }
}

impl Pattern<'_> {
    /// Paints the product of pattern and existing colour textures into one texture for all furred materials, and sets
    /// their texture coordinates to it. Groom textures are converted too.
    ///
    /// * `furred`: one per material
    ///
    /// Call this after everything that reads the model's own texture coordinates.
    pub fn paint(
        &self,
        atlas: &Atlas,
        furred: &[bool],
        surface: &mut Surface,
        colors: &mut Colors,
        grooms: &mut GroomTextures,
    ) {
        let material_of = material_of_triangles(surface);
        let material = |spot: SurfacePoint| material_of[spot.triangle];
        let texels = atlas.paint(|spot, extent| {
            let own = colors.materials.get(material(spot)).and_then(|m| m.image).map(|image| &colors.images[image]);
            // Average four samples per texel, for smooth borders in the image.
            let samples = [(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)].map(|(dx, dy)| {
                let at = SurfacePoint { weights: spot.weights + extent[0] * dx + extent[1] * dy, ..spot };
                let normal = at.interpolate(surface, &surface.rest.normals).normalize_or(Vec3::Y);
                let pattern = self.color(at.interpolate(surface, &surface.rest.positions), normal).extend(1.0);
                pattern * own.map_or(Vec4::ONE, |image| sample_model_uvs(surface, at, image, Encoding::Srgb))
            });
            samples.into_iter().sum::<Vec4>() / 4.0
        });
        let color = srgb_image(atlas.side, &texels);
        let groom = grooms.of_material.iter().any(Option::is_some).then(|| {
            let texels = atlas.paint(|spot, _| {
                let own = grooms.of_material.get(material(spot)).copied().flatten().map(|image| &grooms.images[image]);
                own.map_or(Vec4::new(1.0, 0.0, 0.0, 1.0), |image| {
                    sample_model_uvs(surface, spot, image, Encoding::Linear)
                })
            });
            linear_image(atlas.side, &texels)
        });

        assign_textures(atlas, furred, (color, groom), surface, colors, grooms);
    }
}

/// Assigns the painted colour and groom textures to the selected materials, and replaces the texture coordinates of
/// these materials.
///
/// * `of_material`: whether each material gets the textures
pub(super) fn assign_textures(
    atlas: &Atlas,
    of_material: &[bool],
    (color, groom): (Image, Option<Image>),
    surface: &mut Surface,
    colors: &mut Colors,
    grooms: &mut GroomTextures,
) {
    let chosen: Vec<usize> = (0..colors.materials.len()).filter(|m| of_material.get(*m) == Some(&true)).collect();
    let mut images: Vec<_> = colors.materials.iter().map(|m| m.image).collect();
    replace(&mut colors.images, &mut images, &chosen, Arc::new(color));
    colors.materials.iter_mut().zip(images).for_each(|(m, image)| m.image = image);
    if let Some(groom) = groom {
        replace(&mut grooms.images, &mut grooms.of_material, &chosen, groom);
    }
    for (uv, own) in surface.mesh.uvs.iter_mut().zip(&atlas.uvs) {
        *uv = own.unwrap_or(*uv);
    }
}

impl SurfacePoint {
    /// Interpolates a value between the triangle's vertices.
    pub(super) fn interpolate(self, surface: &Surface, values: &[Vec3]) -> Vec3 {
        let [a, b, c] = surface.mesh.triangles[self.triangle].map(|v| values[v as usize]);
        a * self.weights.x + b * self.weights.y + c * self.weights.z
    }
}

/// Samples an image in the model's own texture coordinates.
pub(super) fn sample_model_uvs(surface: &Surface, spot: SurfacePoint, image: &Image, encoding: Encoding) -> Vec4 {
    let [a, b, c] = surface.mesh.triangles[spot.triangle].map(|v| surface.mesh.uvs[v as usize]);
    bilinear(image, a * spot.weights.x + b * spot.weights.y + c * spot.weights.z, Wrap::Repeat, encoding)
}

pub(super) fn material_of_triangles(surface: &Surface) -> Vec<usize> {
    let mut materials = vec![usize::MAX; surface.mesh.triangles.len()];
    for part in &surface.mesh.parts {
        materials[part.first_triangle..part.first_triangle + part.triangle_count].fill(part.material);
    }
    materials
}

/// Assigns the image `new` to `materials`, and removes images that are no longer used.
fn replace<T>(images: &mut Vec<T>, of_material: &mut [Option<usize>], materials: &[usize], new: T) {
    materials.iter().for_each(|m| of_material[*m] = None);
    let mut kept = Vec::new();
    for (i, image) in std::mem::take(images).into_iter().enumerate() {
        let users = of_material.iter_mut().filter(|m| **m == Some(i));
        let mut used = false;
        for user in users {
            *user = Some(kept.len());
            used = true;
        }
        if used {
            kept.push(image);
        }
    }
    materials.iter().for_each(|m| of_material[*m] = Some(kept.len()));
    kept.push(new);
    *images = kept;
}

#[cfg(test)]
#[path = "pattern_tests.rs"]
mod tests;
