//! Groom maps as images to paint on, filled with the values that the bake currently computes over a model. They use the
//! model's own texture coordinates or the generated atlas.
//!
//! Values are encoded as `[groom]` reads them. A bake samples these images only at vertices, which fall between texels.
//! So each image is painted such that sampling it returns the vertices' values.

mod fit;

use crate::pipeline::{self, BakeInput, Groomed, Layout, Output, Outputs};
use crate::recipe::{CombSource, GroomCoordinates};
use crate::sample::{Encoding, Wrap, bilinear};
use crate::stages::groom::canvas::{Canvas, CanvasTriangle, SurfacePoint};
use crate::stages::groom::{ModelAtlas, linear_image};
use crate::stages::surface::Surface;
use fit::SampledImage;
use glam::{Vec2, Vec3, Vec4};
use pelage_formats::meaning::linear_to_srgb;
use pelage_import::BakeError;
use pelage_import::mesh::{Image, Mesh, MeshPart, Model, RestPose};

/// Gutter around the charts of a model's own texture coordinates, divided by the image's width.
const GUTTER: f32 = 1.0 / 128.0;
/// Maximum number of copies of a triangle along each axis: one for each repeat of the image that it spans.
const MOST_REPEATS: f32 = 16.0;

/// Groom quantity to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// `groom.length`.
    Length,
    /// `groom.density`.
    Density,
    /// `groom.lean`.
    Lean,
    /// `groom.wetness`.
    Wetness,
    /// `groom.bare`.
    Bare,
    /// `groom.comb`.
    Comb,
    /// `groom.color`.
    Color,
}

impl Quantity {
    /// All quantities.
    pub const ALL: [Self; 7] =
        [Self::Length, Self::Density, Self::Lean, Self::Wetness, Self::Bare, Self::Comb, Self::Color];

    /// Returns the key in `[groom]`.
    pub fn key(self) -> &'static str {
        match self {
            Self::Length => "length",
            Self::Density => "density",
            Self::Lean => "lean",
            Self::Wetness => "wetness",
            Self::Bare => "bare",
            Self::Comb => "comb",
            Self::Color => "color",
        }
    }

    /// Returns the quantity with that key.
    pub fn of_key(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|quantity| quantity.key() == key)
    }
}

/// Image to paint on, with the mesh that it maps to.
#[derive(Clone, Debug)]
pub struct GroomMap {
    /// Opaque image. Scalars are stored as grey, colours in sRGB.
    pub image: Image,
    /// Texture coordinates that the image uses.
    pub coordinates: GroomCoordinates,
    /// Valid triangles of the model, with these texture coordinates.
    pub mesh: Mesh,
    /// Rest pose of the mesh, metres.
    pub rest: RestPose,
    /// Largest difference, 0..=1, between a vertex value and the image sampled there, before rounding to bytes. It is 0
    /// for values evaluated per texel.
    pub misses_by: f32,
    /// Warnings.
    pub warnings: Vec<String>,
}

/// Writes a groom map of a model.
///
/// * `coordinates`: texture coordinates to use, the model's own or the atlas. The default is the recipe's choice, or
///   the atlas if a furred part has no texture coordinates, or most have no area as in a palette. A recipe with a
///   projection uses the model's own: a projected image shows both sides of a body at once and cannot be painted.
/// * `texels`: width and height of the image
///
/// Fails with the errors of [`crate::pipeline::bake`] up to the `groom` stage. [`BakeError::Input`] if the map is to
/// use the model's own texture coordinates, but the model has none.
pub fn groom_map(
    input: &BakeInput<'_>,
    model: &Model,
    quantity: Quantity,
    coordinates: Option<GroomCoordinates>,
    texels: u32,
) -> Result<GroomMap, BakeError> {
    // Switch off root colours: the map shows the colours of the mesh surface, not those at the roots of the hair over
    // it.
    let mut recipe = input.recipe.clone();
    recipe.color.at_root = false;
    let input = &BakeInput { recipe: &recipe, ..*input };
    let mut outputs = Outputs::of_model(model);
    pipeline::make(input, &mut outputs, Output::Groomed, &mut |_| ())?;
    let missing = || BakeError::Internal("the model has no surface or no groom, expected both".into());
    let (laid, groomed) = (outputs.laid.get().ok_or_else(missing)?, outputs.groomed.get().ok_or_else(missing)?);
    let model = laid.model(model);
    let over = coordinates.unwrap_or_else(|| usual_coordinates(input, laid));
    let ground = match over {
        GroomCoordinates::Atlas => MapLayout::of_atlas(ModelAtlas::new(input.file, model)?, texels),
        _ => MapLayout::of_model(input.file, laid, texels)?,
    };
    if ground.mesh.triangles.len() != groomed.surface.mesh.triangles.len() {
        return Err(BakeError::Internal("atlas and surface have different triangles, expected the same ones".into()));
    }
    let canvas = Canvas::new(texels, ground.pieces, ground.gutter);
    let groomed_model = GroomedModel { input, model, laid, groomed };
    let (painted, misses_by) = match groomed_model.values(quantity)? {
        Values::PerVertex(values) => {
            let corner = |t: usize| groomed.surface.mesh.triangles[t].map(|v| values[v as usize]);
            let corners: Vec<[Vec4; 3]> = (0..groomed.surface.mesh.triangles.len()).map(corner).collect();
            let reading = SampledImage { canvas: &canvas, side: texels, places: &ground.places, uvs: &ground.uvs };
            reading.fitted(&corners)
        }
        Values::PerTexel(value) => (canvas.paint(|spot, _| value(spot.clamped())), 0.0),
    };
    // Round to a fine grid first, so that rounding errors do not decide how values halfway between two bytes are
    // rounded.
    let painted: Vec<Vec4> = painted.into_iter().map(|texel| (texel * 65536.0).round() / 65536.0).collect();
    let mut warnings = laid.warnings.clone();
    let own = input.recipe.groom.coordinates;
    if own.projection().is_some() {
        warnings.push(format!(
            "groom.coordinates = {:?}, but this map uses {:?}; a recipe that uses this map must set the latter for \
             all images of [groom]",
            own.word(),
            over.word()
        ));
    }
    warnings.extend(groomed.warnings.iter().cloned());
    Ok(GroomMap {
        image: linear_image(texels, &painted),
        coordinates: over,
        mesh: ground.mesh,
        rest: ground.rest,
        misses_by,
        warnings,
    })
}

/// Area of texture coordinates at and below which nothing can be painted on a triangle.
const LEAST_UV_AREA: f32 = 1e-9;

fn usual_coordinates(input: &BakeInput<'_>, laid: &Layout<'_>) -> GroomCoordinates {
    let mesh = &laid.surface.mesh;
    let mut furred = mesh.parts.iter().filter(|part| is_furred(laid, part.material));
    let range = |part: &MeshPart| part.first_triangle..part.first_triangle + part.triangle_count;
    let triangles: Vec<usize> = furred.clone().flat_map(range).collect();
    let has_area = |t: &&usize| {
        let [a, b, c] = mesh.triangles[**t].map(|v| mesh.uvs[v as usize]);
        (b - a).perp_dot(c - a).abs() > LEAST_UV_AREA
    };
    match input.recipe.groom.coordinates {
        _ if furred.any(|part| !part.has_uvs) => GroomCoordinates::Atlas,
        _ if 2 * triangles.iter().filter(has_area).count() < triangles.len() => GroomCoordinates::Atlas,
        GroomCoordinates::Atlas => GroomCoordinates::Atlas,
        // A projected image shows both sides of a body at once and cannot be painted.
        _ => GroomCoordinates::Model,
    }
}

fn is_furred(laid: &Layout<'_>, material: usize) -> bool {
    laid.furred.get(material).copied().unwrap_or(false)
}

/// Layout of the image that a map is painted into.
struct MapLayout {
    mesh: Mesh,
    rest: RestPose,
    pieces: Vec<CanvasTriangle>,
    /// Width of the gutter around the painted triangles, texels.
    gutter: u32,
    /// Index of the sample at each corner of each triangle.
    places: Vec<[u32; 3]>,
    /// Texture coordinates of each sample.
    uvs: Vec<Vec<Vec2>>,
}

impl MapLayout {
    fn of_atlas(atlas: ModelAtlas, texels: u32) -> Self {
        let (places, uvs) = atlas.corner_coordinates();
        let corners = |t: &[u32; 3]| t.map(|v| atlas.mesh.uvs[v as usize] * texels as f32);
        let triangles = atlas.mesh.triangles.iter().zip(0..);
        let pieces = triangles.map(|(t, triangle)| CanvasTriangle { triangle, corners: corners(t) }).collect();
        let gutter = (atlas.gutter * texels).div_ceil(atlas.side).max(1);
        Self { mesh: atlas.mesh, rest: atlas.rest, pieces, gutter, places, uvs }
    }

    /// Lays out the furred parts that have their own texture coordinates.
    fn of_model(file: &str, laid: &Layout<'_>, texels: u32) -> Result<Self, BakeError> {
        let Surface { mesh, rest, .. } = &laid.surface;
        let parts = || mesh.parts.iter().filter(|part| is_furred(laid, part.material));
        if !parts().any(|part| part.has_uvs) {
            let reason = "has no texture coordinates (TEXCOORD_0) where hair grows, expected them for a map over the \
                 model's own coordinates; write the map over the atlas instead";
            let place = parts().next().map_or("whole model".to_owned(), |part| part.source.clone());
            return Err(BakeError::Input { file: file.to_owned(), place, reason: reason.to_owned() });
        }
        let mut pieces = Vec::new();
        for part in parts().filter(|part| part.has_uvs) {
            for t in part.first_triangle..part.first_triangle + part.triangle_count {
                let uvs = mesh.triangles[t].map(|v| mesh.uvs[v as usize]);
                repeated(uvs, |uvs| {
                    pieces.push(CanvasTriangle { triangle: t as u32, corners: uvs.map(|uv| uv * texels as f32) });
                });
            }
        }
        Ok(Self {
            gutter: ((texels as f32 * GUTTER).ceil() as u32).max(1),
            places: mesh.triangles.clone(),
            uvs: mesh.uvs.iter().map(|uv| vec![*uv]).collect(),
            mesh: mesh.clone(),
            rest: rest.clone(),
            pieces,
        })
    }
}

/// Calls `each` for every copy of a triangle that may overlap the image, which repeats outside 0..1.
fn repeated(uvs: [Vec2; 3], mut each: impl FnMut([Vec2; 3])) {
    if !uvs.iter().all(|uv| uv.is_finite()) {
        return;
    }
    let low = uvs[0].min(uvs[1]).min(uvs[2]).floor();
    let high = uvs[0].max(uvs[1]).max(uvs[2]).ceil().max(low + 1.0).min(low + MOST_REPEATS);
    let tiles = |low: f32, high: f32| 0..(high - low) as u32;
    for (y, x) in tiles(low.y, high.y).flat_map(|y| tiles(low.x, high.x).map(move |x| (y, x))) {
        let tile = low + Vec2::new(x as f32, y as f32);
        each(uvs.map(|uv| uv - tile));
    }
}

/// Model after the `groom` stage.
struct GroomedModel<'a> {
    input: &'a BakeInput<'a>,
    model: &'a Model,
    laid: &'a Layout<'a>,
    groomed: &'a Groomed,
}

/// Values of a map as RGBA, 0..=1, encoded as in the image.
enum Values<'a> {
    /// Values per vertex of the groomed surface.
    PerVertex(Vec<Vec4>),
    /// Function of a point on the groomed surface.
    PerTexel(Box<dyn Fn(SurfacePoint) -> Vec4 + Sync + 'a>),
}

fn grey(share: f32) -> Vec4 {
    Vec3::splat(share).extend(1.0)
}

impl<'a> GroomedModel<'a> {
    fn values(&self, quantity: Quantity) -> Result<Values<'a>, BakeError> {
        let coat = &self.groomed.coat;
        Ok(match quantity {
            Quantity::Length => Values::PerVertex(coat.length.iter().copied().map(grey).collect()),
            Quantity::Lean => Values::PerVertex(coat.lean.iter().copied().map(grey).collect()),
            Quantity::Density => {
                Values::PerVertex(self.pack_input_vertices(self.laid.lay.density.as_deref(), 1.0, |hairs| {
                    grey((libm::log2f(hairs.max(f32::MIN_POSITIVE)) + 2.0) / 4.0)
                }))
            }
            Quantity::Comb => Values::PerVertex(self.comb()),
            Quantity::Wetness => self.per_texel_or_vertex(&coat.wetness, |texel| texel.y),
            Quantity::Bare => self.per_texel_or_vertex(&coat.bareness, |texel| 1.0 - texel.x),
            Quantity::Color => self.colors(),
        })
    }

    /// Returns values at the vertices of the groomed surface, given values at the vertices of the imported mesh. Each
    /// is encoded by `write`. Vertices without a value get `without`.
    fn pack_input_vertices<T: Copy>(&self, values: Option<&[T]>, without: T, write: impl Fn(T) -> Vec4) -> Vec<Vec4> {
        let value = |v: &u32| values.and_then(|all| all.get(*v as usize)).copied().unwrap_or(without);
        self.groomed.surface.input_vertex.iter().map(|v| write(value(v))).collect()
    }

    /// Returns the directions of the comb map. Without a map, returns the directions along which the hair was laid out.
    /// Both are zero where hair has no direction.
    fn comb(&self) -> Vec<Vec4> {
        let write = |direction: Vec3| (direction.clamp_length_max(1.0) * 0.5 + 0.5).extend(1.0);
        match &self.laid.lay.comb {
            Some(wishes) => self.pack_input_vertices(Some(wishes), Vec3::ZERO, write),
            None if self.input.recipe.surface.comb == CombSource::None => {
                vec![write(Vec3::ZERO); self.groomed.surface.mesh.positions.len()]
            }
            None => comb_directions(&self.groomed.surface).into_iter().map(write).collect(),
        }
    }

    /// Returns the values per texel if there are groom textures, otherwise per vertex. A texel's value is the
    /// interpolated vertex value plus that of the texture.
    fn per_texel_or_vertex(&self, of_vertices: &'a [f32], of_texel: fn(Vec4) -> f32) -> Values<'a> {
        let Groomed { surface, grooms, .. } = self.groomed;
        if grooms.images.is_empty() {
            return Values::PerVertex(of_vertices.iter().copied().map(grey).collect());
        }
        let material_of = material_of_triangles(&surface.mesh);
        Values::PerTexel(Box::new(move |spot| {
            let corners = surface.mesh.triangles[spot.triangle].map(|v| v as usize);
            let own: f32 = corners.iter().zip(spot.weights.to_array()).map(|(v, w)| of_vertices[*v] * w).sum();
            let material = material_of[spot.triangle];
            let image = grooms.of_material.get(material).copied().flatten().and_then(|image| grooms.images.get(image));
            grey(own + image.map_or(0.0, |image| of_texel(read(&surface.mesh, spot, image, Encoding::Linear))))
        }))
    }

    /// Returns the base colours: product of factor, texture, vertex colour and pattern.
    fn colors(&self) -> Values<'a> {
        let Groomed { surface, colors, .. } = self.groomed;
        // Divide by the gain of the hair's colour, because a bake that reads the map multiplies by it again.
        let laid = self.laid;
        let is_lightened = |m: usize| is_furred(laid, m) && colors.hair.get(m).copied().flatten().is_none();
        let gain = move |material| if is_lightened(material) { laid.hair_colors.gain } else { 1.0 };
        let factors: Vec<Vec4> = self.model.materials.iter().map(|m| Vec4::from(m.base_color)).collect();
        let material_of = material_of_triangles(&surface.mesh);
        Values::PerTexel(Box::new(move |spot| {
            let material = material_of[spot.triangle];
            let own = colors.materials.get(material);
            let factor = own.map(|m| Vec4::from(m.factor)).or(factors.get(material).copied()).unwrap_or(Vec4::ONE);
            let image = own.and_then(|m| m.image).and_then(|image| colors.images.get(image));
            let texel = image.map_or(Vec4::ONE, |image| read(&surface.mesh, spot, image, Encoding::Srgb));
            let corners = surface.mesh.triangles[spot.triangle].map(|v| colors.vertices[v as usize]);
            let shares = corners.map(|rgba| Vec4::from(rgba.map(|byte| f32::from(byte) / 255.0)));
            let painted: Vec4 = shares.iter().zip(spot.weights.to_array()).map(|(color, w)| *color * w).sum();
            let [r, g, b, _] =
                (factor * texel * painted / gain(material)).to_array().map(|x| f32::from(linear_to_srgb(x)) / 255.0);
            Vec4::new(r, g, b, 1.0)
        }))
    }
}

fn material_of_triangles(mesh: &Mesh) -> Vec<usize> {
    let mut materials = vec![usize::MAX; mesh.triangles.len()];
    for part in &mesh.parts {
        materials[part.first_triangle..part.first_triangle + part.triangle_count].fill(part.material);
    }
    materials
}

/// Samples an image at the mesh's texture coordinates.
fn read(mesh: &Mesh, spot: SurfacePoint, image: &Image, encoding: Encoding) -> Vec4 {
    let [a, b, c] = mesh.triangles[spot.triangle].map(|v| mesh.uvs[v as usize]);
    bilinear(image, a * spot.weights.x + b * spot.weights.y + c * spot.weights.z, Wrap::Repeat, encoding)
}

/// Returns the comb direction at each vertex: the unit direction, at rest, in which the tile coordinate v increases. It
/// is zero on bare parts.
fn comb_directions(surface: &Surface) -> Vec<Vec3> {
    let Surface { mesh, rest, .. } = surface;
    let mut sums = vec![Vec3::ZERO; mesh.positions.len()];
    let furred = mesh.triangles.iter().zip(&surface.patch_of_triangle).filter(|(_, patch)| **patch != u32::MAX);
    for (triangle, _) in furred {
        let [a, b, c] = triangle.map(|v| v as usize);
        let edges = |points: &[Vec3]| [points[b] - points[a], points[c] - points[a]];
        let ([own1, own2], [rest1, rest2]) = (edges(&mesh.positions), edges(&rest.positions));
        let across = own1.cross(own2);
        for v in [a, b, c] {
            // Tangents refer to the mesh before posing. So express each by the triangle's edges before posing, and
            // combine the edges at rest in the same way.
            let tangent = surface.tangents[v].truncate();
            let share = |x: Vec3, y: Vec3| x.cross(y).dot(across) / across.length_squared();
            let along_u = rest1 * share(tangent, own2) + rest2 * share(own1, tangent);
            let direction = rest1.cross(rest2).cross(along_u).normalize_or_zero() * surface.tangents[v].w;
            sums[v] += if direction.is_finite() { direction } else { Vec3::ZERO };
        }
    }
    sums.into_iter().map(Vec3::normalize_or_zero).collect()
}

#[cfg(test)]
mod tests;
