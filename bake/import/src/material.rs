//! Materials: base-colour factor, texture and texture coordinates, alpha cutoff, roughness and metalness.

use super::extensions::conversion;
use super::json::{JsonNode, shorten};
use super::source::Source;
use crate::BakeError;
use crate::angle::rotation;
use crate::image_file::ImageList;
use crate::mesh::Material;
use glam::{Affine2, Mat2, Vec2};
use std::collections::BTreeMap;

/// Texture coordinates of a material: set and transform.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct TextureCoords {
    /// Index `n` of the set `TEXCOORD_<n>`. `None` for a material without texture, for which any set will do.
    pub set: Option<u32>,
    /// KHR_texture_transform of the coordinates.
    pub transform: Affine2,
}

/// Materials and images that the parts use, in the order of first use.
///
/// No fault in a material or image is an error, because the shape can be drawn without them.
#[derive(Debug, Default)]
pub(super) struct Materials {
    pub materials: Vec<Material>,
    pub images: ImageList,
    /// Materials read so far, by document index (`None`: the default material). For each, its index in `materials` and
    /// its texture coordinates.
    known: BTreeMap<Option<usize>, (usize, TextureCoords)>,
    /// Index in `images` by document index; `None` for an image that cannot be read.
    known_images: BTreeMap<usize, Option<usize>>,
}

/// Maximum linear value of a black colour; 10 of 255 when sRGB-encoded.
const BLACK: f32 = 0.003;
const BLACK_BYTE: u8 = 10;

impl Materials {
    /// Returns the index and texture coordinates of the material that a primitive names.
    pub fn read<'a>(
        &mut self,
        source: &mut Source<'a, '_>,
        reference: Option<&JsonNode<'a>>,
    ) -> (usize, TextureCoords) {
        let found = reference.and_then(|reference| {
            let found = source.root.follow("materials", reference);
            source.or_warn(found, "the default material is used")
        });
        let key = found.as_ref().map(|(index, _)| *index);
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let mut material = Material::default();
        let mut coords = TextureCoords::default();
        if let Some((_, at)) = &found {
            self.fill(source, at, &mut material, &mut coords);
        }
        let entry = (self.materials.len(), coords);
        self.materials.push(material);
        self.known.insert(key, entry);
        entry
    }

    fn fill<'a>(
        &mut self,
        source: &mut Source<'a, '_>,
        at: &JsonNode<'a>,
        material: &mut Material,
        coords: &mut TextureCoords,
    ) {
        material.name = at.name().to_owned();
        material.double_sided = source.or_warn(at.flag("doubleSided"), "drawn one-sided").unwrap_or_default();
        (material.alpha_cutoff, material.blends) = source.or_warn(alpha_mode(at), "drawn opaque").unwrap_or_default();
        // The diffuse colour of the older specular-glossiness model has the same meaning under other names. A
        // metallic-roughness colour beside it is a fallback for readers without the extension.
        let specular = at.extension("KHR_materials_pbrSpecularGlossiness");
        let (base, factor, texture) = match (specular, at.get("pbrMetallicRoughness")) {
            (Some(specular), _) => (specular, "diffuseFactor", "diffuseTexture"),
            (None, Some(base)) => {
                (material.roughness, material.metallic) = source.or_warn(gloss(&base), "left out").unwrap_or_default();
                (base, "baseColorFactor", "baseColorTexture")
            }
            (None, None) => return self.use_emission_of_black(source, at, material, coords),
        };
        if let Some(factor) = base.get(factor) {
            material.base_color = source.or_warn(factor.numbers(), "white is used").unwrap_or([1.0; 4]);
        }
        if let Some(info) = base.get(texture) {
            (material.base_color_image, *coords) = self.texture(source, &info);
        }
        self.use_emission_of_black(source, at, material, coords);
    }

    /// Uses the emission of a black material as its base colour. Authors put colours there that no light should change.
    fn use_emission_of_black<'a>(
        &mut self,
        source: &mut Source<'a, '_>,
        at: &JsonNode<'a>,
        material: &mut Material,
        coords: &mut TextureCoords,
    ) {
        let Some(factor) = at.get("emissiveFactor") else { return };
        let [r, g, b, alpha] = material.base_color;
        let image = material.base_color_image.and_then(|image| self.images.images.get(image));
        let dark = |texel: &[u8; 4]| texel[..3].iter().all(|x| *x <= BLACK_BYTE);
        let black =
            [r, g, b].iter().all(|x| *x <= BLACK) || image.is_some_and(|i| i.rgba.as_chunks().0.iter().all(dark));
        let Some(emission) = source.or_warn(factor.numbers::<3>(), "the emission is left out").filter(|_| black) else {
            return;
        };
        if emission.iter().all(|x| *x <= BLACK) {
            return;
        }
        source.warn(emission_as_base_color(&material.name));
        let [r, g, b] = emission.map(|x| x.clamp(0.0, 1.0));
        (material.base_color, material.base_color_image) = ([r, g, b, alpha], None);
        if let Some(info) = at.get("emissiveTexture") {
            (material.base_color_image, *coords) = self.texture(source, &info);
        }
    }

    /// Reads a texture of a material. Returns the index of its image, if that can be read, and its coordinates.
    fn texture<'a>(&mut self, source: &mut Source<'a, '_>, info: &JsonNode<'a>) -> (Option<usize>, TextureCoords) {
        let image = self.image(source, info);
        let image = source.or_warn(image, "the colour factor alone is used");
        let coords = texture_coords(info);
        let coords = source.or_warn(coords, "TEXCOORD_0 is used without a transform");
        (image, coords.unwrap_or(TextureCoords { set: Some(0), ..TextureCoords::default() }))
    }

    /// Returns the index of the decoded image of a texture: of its `source`, or else of the WebP that it names.
    fn image<'a>(&mut self, source: &mut Source<'a, '_>, info: &JsonNode<'a>) -> Result<usize, BakeError> {
        let (_, texture) = source.root.follow("textures", &info.require("index")?)?;
        let webp = texture.extension("EXT_texture_webp").and_then(|webp| webp.get("source"));
        let mut fault = None;
        for reference in [texture.get("source"), webp].into_iter().flatten() {
            match self.decoded(source, &reference) {
                Ok(image) => return Ok(image),
                Err(error) => drop(fault.get_or_insert(error)),
            }
        }
        Err(fault.unwrap_or_else(|| {
            let name = texture.get("extensions").and_then(|e| e.keys().next());
            texture.fault(name.map_or("has no `source`, expected the index of an image".to_owned(), |name| {
                let name = shorten(name);
                format!("has an image only through {name}, which cannot be read; {}", conversion(&name))
            }))
        }))
    }

    /// Returns the index of the decoded image that `reference` names.
    fn decoded<'a>(&mut self, source: &mut Source<'a, '_>, reference: &JsonNode<'a>) -> Result<usize, BakeError> {
        let (index, at) = source.root.follow("images", reference)?;
        if let Some(known) = self.known_images.get(&index) {
            return known.ok_or_else(|| reference.fault(format!("is {index}, an image that cannot be read")));
        }
        self.known_images.insert(index, None);
        let fault = |at: &JsonNode<'_>, name: &str, reason| at.fault(format!("image {index} \"{name}\" {reason}"));
        let name = shorten(at.name());
        self.images.check_limits().map_err(|reason| fault(&at, &name, reason))?;
        let (bytes, origin) = match (at.get("bufferView"), at.get("uri")) {
            (Some(view), _) => {
                let bytes = source.view(&view)?.bytes.to_vec();
                source.record("image", "", &bytes);
                (bytes, view)
            }
            (None, Some(uri)) => (source.uri(&uri, "image", None)?, uri),
            (None, None) => return Err(at.fault("has neither `bufferView` nor `uri`")),
        };
        let image = self.images.add(&bytes, &format!("image {index} \"{name}\""), &mut |text| source.warn(text));
        let image = image.map_err(|reason| fault(&origin, &name, reason))?;
        self.known_images.insert(index, Some(image));
        Ok(image)
    }
}

pub(super) fn emission_as_base_color(material: &str) -> String {
    format!("material \"{}\" is black and emits light; its emission is used as base colour", shorten(material))
}

/// Returns the alpha below which a material is cut away, `None` if its `alphaMode` is not MASK; and whether the mode is
/// BLEND.
fn alpha_mode(at: &JsonNode<'_>) -> Result<(Option<f32>, bool), BakeError> {
    let Some(mode) = at.get("alphaMode") else { return Ok((None, false)) };
    match mode.string()? {
        "MASK" => Ok((Some(at.get("alphaCutoff").map_or(Ok(0.5), |v| v.number())?), false)),
        "BLEND" => Ok((None, true)),
        "OPAQUE" => Ok((None, false)),
        _ => Err(mode.unexpected("OPAQUE, MASK or BLEND")),
    }
}

/// Reads roughness and metalness. Both are unknown if a texture provides them, because the factors are then only upper
/// bounds.
///
/// Both are also unknown for a material without `pbrMetallicRoughness`. By the specification it would be metal, which
/// no author intends.
fn gloss(base: &JsonNode<'_>) -> Result<(Option<f32>, Option<f32>), BakeError> {
    if base.get("metallicRoughnessTexture").is_some() {
        return Ok((None, None));
    }
    let factor = |key| base.get(key).map_or(Ok(1.0), |factor| factor.number()).map(Some);
    Ok((factor("roughnessFactor")?, factor("metallicFactor")?))
}

/// Reads the set and the transform of texture coordinates.
fn texture_coords(info: &JsonNode<'_>) -> Result<TextureCoords, BakeError> {
    let mut transform = Affine2::IDENTITY;
    let mut set = info.unsigned_or("texCoord", 0)?;
    if let Some(extension) = info.extension("KHR_texture_transform") {
        transform = texture_transform(&extension)?;
        set = extension.unsigned_or("texCoord", set)?;
    }
    let set = Some(u32::try_from(set).map_err(|_| info.fault("has a texCoord beyond 32 bits"))?);
    Ok(TextureCoords { set, transform })
}

/// Reads KHR_texture_transform: scale, then rotation, then offset. The extension rotates coordinates counter-clockwise
/// as seen on the image, whose v axis points down.
fn texture_transform(at: &JsonNode<'_>) -> Result<Affine2, BakeError> {
    let offset: Vec2 = at.get("offset").map_or(Ok([0.0; 2]), |v| v.numbers())?.into();
    let scale: Vec2 = at.get("scale").map_or(Ok([1.0; 2]), |v| v.numbers())?.into();
    let angle = at.get("rotation").map_or(Ok(0.0), |v| v.number())?;
    Ok(Affine2::from_mat2_translation(rotation(-angle) * Mat2::from_diagonal(scale), offset))
}
