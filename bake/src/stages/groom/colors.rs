//! Sources of the colours of hair and mesh surface.

use super::bleed::bleed;
use super::image_coordinates::Vertices;
use super::maps::Maps;
use crate::recipe::{ColorMap, ColorParams};
use crate::sample::{Encoding, Wrap, bilinear};
use glam::Vec3;
use pelage_formats::meaning::srgb_value_to_linear;
use pelage_import::BakeError;
use pelage_import::mesh::{Image, Material, Mesh, MeshPart, Model};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Colours of a model in the form stored in the package: the product of factor, texture and vertex colour.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Colors {
    /// Images used by materials.
    pub images: Vec<Arc<Image>>,
    /// Colour of each material.
    pub materials: Vec<MaterialColor>,
    /// Colour of each vertex, linear RGBA.
    pub vertices: Vec<[u8; 4]>,
    /// Colour of the hair on each material if it differs from that of the skin, linear RGB; may exceed 1.
    pub hair: Vec<Option<[f32; 3]>>,
}

impl Colors {
    /// Returns the linear colour at a point of a triangle with the given barycentric weights, without that of the hair.
    pub(crate) fn at(&self, mesh: &Mesh, material: usize, triangle: &[u32; 3], weights: Vec3) -> Vec3 {
        let color = self.materials.get(material);
        let factor = color.map_or(Vec3::ONE, |c| Vec3::from_slice(&c.factor[..3]));
        let own = |v: u32| {
            let bytes = self.vertices.get(v as usize);
            bytes.map_or(Vec3::ONE, |[r, g, b, _]| Vec3::from([*r, *g, *b].map(f32::from)) / 255.0)
        };
        let [a, b, c] = triangle.map(own);
        let [u, v, w] = triangle.map(|v| mesh.uvs[v as usize]);
        let uv = u * weights.x + v * weights.y + w * weights.z;
        let image = color.and_then(|c| c.image).and_then(|i| self.images.get(i));
        let texel = image.map_or(Vec3::ONE, |image| bilinear(image, uv, Wrap::Repeat, Encoding::Srgb).truncate());
        factor * (a * weights.x + b * weights.y + c * weights.z) * texel
    }

    /// Multiplies the colours of the hair on furred materials by `gain`. The result may exceed 1. The gain compensates
    /// for hairs shadowing each other.
    ///
    /// * `furred`: whether each material is furred
    pub fn lighten(&mut self, furred: &[bool], gain: f32) {
        for (i, material) in self.materials.iter_mut().enumerate().filter(|(i, _)| furred.get(*i) == Some(&true)) {
            let color = match self.hair.get_mut(i) {
                Some(Some(hair)) => hair,
                _ => &mut material.factor[..3],
            };
            color.iter_mut().for_each(|c| *c *= gain);
        }
    }
}

/// Colour of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialColor {
    /// Linear RGBA; may exceed 1 for hair.
    pub factor: [f32; 4],
    /// Index into [`Colors::images`], sRGB.
    pub image: Option<usize>,
}

/// Use of the alpha of a material's image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AlphaUse {
    /// None: the image is opaque.
    Ignored,
    /// The image is opaque, and clear texels take the colour of visible ones.
    Blends,
    /// The surface is cut away at clear texels. These take the colour of visible ones, so that filters mix nothing else
    /// into the texels beside them.
    Cuts,
}

impl AlphaUse {
    /// Returns the image as the package stores it; `share` returns it unchanged.
    fn apply(self, image: &Image, share: impl Fn() -> Arc<Image>) -> Arc<Image> {
        if image.rgba.as_chunks::<4>().0.iter().all(|texel| texel[3] == 255) {
            return share();
        }
        let mut image = image.clone();
        if self != Self::Ignored {
            bleed(&mut image);
        }
        if self != Self::Cuts {
            image.rgba.as_chunks_mut::<4>().0.iter_mut().for_each(|texel| texel[3] = 255);
        }
        Arc::new(image)
    }
}

/// Images that materials use, each once for each use of its alpha.
#[derive(Default)]
struct UsedImages<'a> {
    images: Vec<Arc<Image>>,
    /// Source, use of alpha, and index in `images`.
    known: Vec<(&'a Image, AlphaUse, usize)>,
}

impl<'a> UsedImages<'a> {
    /// Returns the index of the image; adds it at its first use.
    fn index(&mut self, image: &'a Image, alpha: AlphaUse, share: impl Fn() -> Arc<Image>) -> usize {
        let same = |known: &&(&Image, AlphaUse, usize)| std::ptr::eq(known.0, image) && known.1 == alpha;
        if let Some((.., index)) = self.known.iter().find(same) {
            return *index;
        }
        let used = alpha.apply(image, share);
        let index = self.images.iter().position(|image| Arc::ptr_eq(image, &used)).unwrap_or(self.images.len());
        if index == self.images.len() {
            self.images.push(used);
        }
        self.known.push((image, alpha, index));
        index
    }
}

/// Takes the colour of each material from the model or from `groom.color`.
///
/// * `at`: vertices of the package
/// * `furred`: whether each material is furred
/// * `base_color`: whether furred materials show the model's own colours if neither `groom.color` nor
///   `groom.hair_color` is set
///
/// Alpha is 1 on all materials that are not cut away where it is low (glTF `MASK`).
///
/// Fails with [`BakeError::Internal`] if an image was not read.
pub fn colors(
    model: &Model,
    at: &Vertices<'_>,
    maps: &Maps<'_>,
    furred: &[bool],
    base_color: bool,
) -> Result<Colors, BakeError> {
    let mesh = at.mesh;
    let mut colors = Colors { vertices: vec![[255; 4]; mesh.positions.len()], ..Colors::default() };
    let mut used = UsedImages::default();
    // The vertex colours that a material keeps: `None` for none, otherwise whether with their alpha.
    let mut kept_vertex_colors = Vec::new();
    let mut painted = Vec::new();
    for (i, material) in model.materials.iter().enumerate() {
        let hair = maps.hair_color(i).map(|color| color.0.map(srgb_value_to_linear));
        let own = base_color || hair.is_some() || !furred.get(i).copied().unwrap_or(false);
        let cuts = material.alpha_cutoff.is_some();
        let [r, g, b, alpha] = material.base_color;
        let alpha = if cuts { alpha } else { 1.0 };
        let plain = if cuts { AlphaUse::Cuts } else { AlphaUse::Blends };
        let mut recipe_image = |path| {
            let image = maps.image(path)?;
            Ok::<_, BakeError>(used.index(image, plain, || Arc::new(image.clone())))
        };
        let (factor, image, vertex) = match maps.color(i) {
            Some(ColorMap::Constant(color)) => {
                let [r, g, b] = color.0.map(srgb_value_to_linear);
                ([r, g, b, alpha], None, false)
            }
            Some(ColorMap::Vertex) => ([1.0, 1.0, 1.0, alpha], None, true),
            Some(ColorMap::Image(path)) if maps.at_vertices() => {
                painted.push((i, maps.image(path)?));
                ([1.0, 1.0, 1.0, alpha], None, false)
            }
            Some(ColorMap::Image(path)) => ([1.0, 1.0, 1.0, alpha], Some(recipe_image(path)?), false),
            None if own => {
                let image = material.base_color_image.and_then(|image| model.images.get(image));
                let meaning = if cuts || material.blends { plain } else { AlphaUse::Ignored };
                let image = image.map(|image| used.index(image, meaning, || image.clone()));
                ([r, g, b, alpha], image, true)
            }
            None => ([1.0; 4], None, false),
        };
        colors.materials.push(MaterialColor { factor, image });
        colors.hair.push(hair);
        kept_vertex_colors.push(vertex.then_some(cuts));
    }
    colors.images = used.images;
    for part in &mesh.parts {
        let Some(cuts) = kept_vertex_colors.get(part.material).copied().flatten() else { continue };
        for v in mesh.triangles[part.first_triangle..part.first_triangle + part.triangle_count].iter().flatten() {
            let [r, g, b, alpha] = mesh.colors[*v as usize];
            colors.vertices[*v as usize] = [r, g, b, if cuts { alpha } else { 255 }];
        }
    }
    for part in &mesh.parts {
        let Some((_, image)) = painted.iter().find(|(material, _)| *material == part.material) else { continue };
        for v in mesh.triangles[part.first_triangle..part.first_triangle + part.triangle_count].iter().flatten() {
            if let Some(color) = maps.color_at(image, at, part, *v as usize) {
                let [r, g, b] = color.to_array().map(|share| (255.0 * share).round() as u8);
                colors.vertices[*v as usize] = [r, g, b, 255];
            }
        }
    }
    paint_marks(&mut colors, at, maps, furred);
    Ok(colors)
}

/// Applies the colours of marks. On a material without a texture, the material's factor is multiplied into the vertex
/// colours, so that a mark can replace the colour. On a material with a texture, the marks' colours multiply the
/// texture.
fn paint_marks(colors: &mut Colors, at: &Vertices<'_>, maps: &Maps<'_>, furred: &[bool]) {
    let said = |v: usize| maps.marks().color.get(at.input(v)).copied().filter(|(share, _)| *share > 0.0);
    for material in (0..colors.materials.len()).filter(|m| furred.get(*m) == Some(&true)) {
        let parts = at.mesh.parts.iter().filter(|part| part.material == material);
        let triangles = |part: &MeshPart| part.first_triangle..part.first_triangle + part.triangle_count;
        let corners = parts.flat_map(|part| &at.mesh.triangles[triangles(part)]).flatten();
        let vertices: BTreeSet<usize> = corners.map(|v| *v as usize).collect();
        if vertices.iter().all(|v| said(*v).is_none()) {
            continue;
        }
        let MaterialColor { factor, image } = &mut colors.materials[material];
        let own = Vec3::from_slice(factor);
        let painted = |v: usize| {
            let [r, g, b, _] = colors.vertices[v].map(|byte| f32::from(byte) / 255.0);
            let color = Vec3::new(r, g, b) * own;
            match (said(v), &image) {
                (None, _) => color,
                (Some((share, mark)), None) => color.lerp(mark, share),
                (Some((share, mark)), Some(_)) => color * Vec3::ONE.lerp(mark, share),
            }
        };
        let painted: Vec<(usize, Vec3)> = vertices.into_iter().map(|v| (v, painted(v))).collect();
        // Divide the painted colours by the maximum of each channel, so that the stored bytes use their full range.
        let most = painted.iter().fold(Vec3::ZERO, |most, (_, color)| most.max(*color));
        factor[..3].copy_from_slice(&most.to_array());
        for (v, color) in painted {
            let share = color / most.max(Vec3::splat(f32::MIN_POSITIVE));
            let [r, g, b] = share.to_array().map(|share| (255.0 * share).round() as u8);
            let [.., alpha] = colors.vertices[v];
            colors.vertices[v] = [r, g, b, alpha];
        }
    }
}

/// Whether hair has a colour source besides its root and tip colour: a pattern, `groom.color`, `groom.hair_color`, or
/// the model's factors, textures and vertex colours. White does not count. Marks do not count either, because they are
/// local.
pub fn is_colored(model: &Model, maps: &Maps<'_>, furred: &[bool], params: &ColorParams) -> bool {
    let is_furred = |material: usize| furred.get(material).copied().unwrap_or(false);
    let by_material = |(i, material): (usize, &Material)| {
        let own = || material.base_color_image.is_some() || material.base_color[..3].iter().any(|c| *c < 1.0);
        let of_recipe = maps.color(i).is_some() || maps.hair_color(i).is_some();
        is_furred(i) && (of_recipe || params.base_color && own())
    };
    let by_vertices = |part: &MeshPart| {
        let triangles = &model.mesh.triangles[part.first_triangle..part.first_triangle + part.triangle_count];
        is_furred(part.material) && triangles.iter().flatten().any(|v| model.mesh.colors[*v as usize][..3] != [255; 3])
    };
    params.pattern.is_some()
        || model.materials.iter().enumerate().any(by_material)
        || params.base_color && model.mesh.parts.iter().any(by_vertices)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recipe::Recipe;
    use crate::stages::groom::MapImages;
    use pelage_import::mesh::{Mesh, RestPose};

    /// Returns whether the hair of a triangle is coloured, for a modified model and a recipe.
    fn colored(change: impl FnOnce(&mut Model), recipe: &str) -> bool {
        let mesh = Mesh {
            positions: vec![glam::Vec3::X, glam::Vec3::Y, glam::Vec3::Z],
            normals: vec![glam::Vec3::Z; 3],
            uvs: vec![glam::Vec2::ZERO; 3],
            colors: vec![[255; 4]; 3],
            triangles: vec![[0, 1, 2]],
            parts: vec![MeshPart { source: "t".into(), ..crate::stages::fixtures::part(0, 0, 1) }],
            ..Mesh::default()
        };
        let mut model = Model { mesh, materials: vec![Material::default(); 2], ..Model::default() };
        change(&mut model);
        let recipe = Recipe::parse("r", recipe).expect("the recipes of these tests read");
        let (furred, images) = ([true, false], MapImages::default());
        let maps = Maps::new(&model.mesh, &model.materials, &furred, &recipe.groom, &images, &mut Vec::new());
        is_colored(&model, &maps, &furred, &recipe.color)
    }

    #[test]
    fn only_hair_is_lightened() {
        let color = |c| MaterialColor { factor: [c, c, c, 0.5], image: None };
        let mut colors = Colors { materials: vec![color(0.8), color(0.8)], ..Colors::default() };
        colors.lighten(&[true, false], 1.5);
        assert_eq!(colors.materials, [color(0.8 * 1.5), color(0.8)]);
    }

    #[test]
    fn skin_keeps_the_models_colour_below_hair_of_another() {
        let mesh = Mesh { colors: vec![[255; 4]], ..Mesh::default() };
        let brown = Material { base_color: [0.4, 0.2, 0.1, 1.0], ..Material::default() };
        let materials =
            ["Coat", "Mane", "Hoof"].map(|name| Material { name: name.to_owned(), ..brown.clone() }).to_vec();
        let model = Model { mesh, materials, ..Model::default() };
        let text = "[groom]\nhair_color = \"#ff0000\"\n\n[[groom.material]]\nname = \"Mane\"\nhair_color = [1, 1, 1]\n";
        let recipe = Recipe::parse("r", text).expect("the recipe reads");
        let (furred, images) = ([true, true, false], MapImages::default());
        let maps = Maps::new(&model.mesh, &model.materials, &furred, &recipe.groom, &images, &mut Vec::new());
        let rest = RestPose::default();
        let at = Vertices { mesh: &model.mesh, rest: &rest, input_vertex: None };
        let mut colors = colors(&model, &at, &maps, &furred, false).expect("no image is missing");
        colors.lighten(&furred, 1.5);
        assert_eq!(colors.materials, [MaterialColor { factor: brown.base_color, image: None }; 3]);
        assert_eq!(colors.hair, [Some([1.5, 0.0, 0.0]), Some([1.5; 3]), None]);
    }

    #[test]
    fn hair_counts_as_coloured_by_factor_image_marks_or_pattern() {
        assert!(!colored(|_| {}, ""));
        assert!(colored(|m| m.materials[0].base_color[1] = 0.5, ""));
        assert!(!colored(|m| m.materials[1].base_color[1] = 0.5, ""), "it is bare");
        assert!(colored(|m| m.materials[0].base_color_image = Some(0), ""));
        assert!(colored(|m| m.mesh.colors[2] = [255, 9, 255, 255], ""));
        let own = "[color]\nbase_color = false\n";
        assert!(!colored(|m| m.mesh.colors[2] = [0, 0, 0, 255], own));
        assert!(!colored(|m| m.materials[0].base_color[1] = 0.5, own));
        assert!(colored(|_| {}, "[groom]\ncolor = \"#804020\"\n"));
        assert!(colored(|_| {}, "[color]\npattern = \"spots.png\"\n"));
    }
}
