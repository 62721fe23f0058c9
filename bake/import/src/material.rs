//! Materials: base-colour factor, texture and texture coordinates, alpha cutoff, roughness and metalness.

use super::extensions::conversion;
use super::json::JsonNode;
use super::source::Source;
use crate::BakeError;
use crate::angle::rotation;
use crate::image_file::{Channels, MAX_TEXELS, decode_image, fit_images};
use crate::mesh::{Image, Material};
use glam::{Affine2, Mat2, Vec2};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Texture coordinates of a material: set and transform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TextureCoords {
    /// Index `n` of the set `TEXCOORD_<n>`. `None` for a material without texture, for which any set will do.
    pub set: Option<u32>,
    /// KHR_texture_transform of the coordinates.
    pub transform: Affine2,
}

/// Materials and images that the parts use, in the order of first use.
#[derive(Debug, Default)]
pub(super) struct Materials {
    pub materials: Vec<Material>,
    pub images: Vec<Arc<Image>>,
    texels: u64,
    /// Materials read so far, by document index (`None`: the default material). For each, its index in `materials` and
    /// its texture coordinates.
    known: BTreeMap<Option<usize>, (usize, TextureCoords)>,
    known_images: BTreeMap<usize, usize>,
}

impl Materials {
    /// Returns the index and texture coordinates of the material that a primitive names.
    pub fn read<'a>(
        &mut self,
        source: &mut Source<'a, '_>,
        reference: Option<&JsonNode<'a>>,
    ) -> Result<(usize, TextureCoords), BakeError> {
        let found = reference.map(|r| source.root.follow("materials", r)).transpose()?;
        let key = found.as_ref().map(|(index, _)| *index);
        if let Some(known) = self.known.get(&key) {
            return Ok(*known);
        }
        let mut material = Material::default();
        let mut coords = TextureCoords { set: None, transform: Affine2::IDENTITY };
        if let Some((_, at)) = &found {
            coords = self.fill(source, at, &mut material)?;
        }
        let entry = (self.materials.len(), coords);
        self.materials.push(material);
        self.known.insert(key, entry);
        Ok(entry)
    }

    fn fill<'a>(
        &mut self,
        source: &mut Source<'a, '_>,
        at: &JsonNode<'a>,
        material: &mut Material,
    ) -> Result<TextureCoords, BakeError> {
        material.name = at.name().to_owned();
        material.double_sided = at.flag("doubleSided")?;
        if let Some(mode) = at.get("alphaMode") {
            match mode.string()? {
                "MASK" => material.alpha_cutoff = Some(at.get("alphaCutoff").map_or(Ok(0.5), |v| v.number())?),
                "BLEND" => material.blends = true,
                "OPAQUE" => {}
                _ => return Err(mode.unexpected("OPAQUE, MASK or BLEND")),
            }
        }
        // The diffuse colour of the older specular-glossiness model has the same meaning under other names.
        let specular = at.get("extensions").and_then(|e| e.get("KHR_materials_pbrSpecularGlossiness"));
        let (base, factor, texture) = match (at.get("pbrMetallicRoughness"), specular) {
            (None, Some(specular)) => (Some(specular), "diffuseFactor", "diffuseTexture"),
            (base, _) => (base, "baseColorFactor", "baseColorTexture"),
        };
        let mut coords = TextureCoords { set: None, transform: Affine2::IDENTITY };
        gloss(at, material)?;
        let Some(base) = base else { return Ok(coords) };
        if let Some(factor) = base.get(factor) {
            material.base_color = factor.numbers()?;
        }
        let Some(info) = base.get(texture) else { return Ok(coords) };
        let mut set = info.unsigned_or("texCoord", 0)?;
        if let Some(extension) = info.get("extensions").and_then(|e| e.get("KHR_texture_transform")) {
            coords.transform = texture_transform(&extension)?;
            set = extension.unsigned_or("texCoord", set)?;
        }
        coords.set = Some(u32::try_from(set).map_err(|_| info.fault("has a texCoord beyond 32 bits"))?);
        material.base_color_image = Some(self.image(source, &info.require("index")?)?);
        Ok(coords)
    }

    /// Returns the index of the decoded image of the texture that `reference` names.
    fn image<'a>(&mut self, source: &mut Source<'a, '_>, reference: &JsonNode<'a>) -> Result<usize, BakeError> {
        let (_, texture) = source.root.follow("textures", reference)?;
        let Some(reference) = texture.get("source") else {
            let name = texture.get("extensions").and_then(|e| e.keys().next());
            let reason = name.map_or("has no `source`, expected the index of an image".to_owned(), |name| {
                let name = super::json::shorten(name);
                format!("has an image only through {name}, which cannot be read; {}", conversion(&name))
            });
            return Err(texture.fault(reason));
        };
        let (index, at) = source.root.follow("images", &reference)?;
        if let Some(known) = self.known_images.get(&index) {
            return Ok(*known);
        }
        let (bytes, origin) = match (at.get("bufferView"), at.get("uri")) {
            (Some(view), _) => {
                let bytes = source.view(&view)?.bytes.to_vec();
                source.record("image", "", &bytes);
                (bytes, view)
            }
            (None, Some(uri)) => (source.uri(&uri, "image", None)?, uri),
            (None, None) => return Err(at.fault("has neither `bufferView` nor `uri`")),
        };
        let named = |text: String| format!("image {index} \"{}\" {text}", super::json::shorten(at.name()));
        let mut left = MAX_TEXELS - self.texels;
        let decoded = decode_image(&bytes, &mut left, Channels::Color);
        self.texels = MAX_TEXELS - left;
        let (image, note) = decoded.map_err(|reason| origin.fault(named(reason)))?;
        note.into_iter().for_each(|note| source.warn(named(note)));
        self.known_images.insert(index, self.images.len());
        self.images.push(Arc::new(image));
        let mut images: Vec<&mut Image> = self.images.iter_mut().map(Arc::make_mut).collect();
        fit_images(&mut images, Channels::Color).into_iter().for_each(|warning| source.warn(warning));
        Ok(self.images.len() - 1)
    }
}

/// Reads roughness and metalness. Both stay unknown if a texture provides them, because the factors are then only upper
/// bounds.
///
/// Both also stay unknown for a material without `pbrMetallicRoughness`. By the specification it would be metal, which
/// no author intends.
fn gloss(at: &JsonNode<'_>, material: &mut Material) -> Result<(), BakeError> {
    let Some(base) = at.get("pbrMetallicRoughness") else { return Ok(()) };
    if base.get("metallicRoughnessTexture").is_none() {
        let factor = |key| base.get(key).map_or(Ok(1.0), |factor| factor.number());
        material.roughness = Some(factor("roughnessFactor")?);
        material.metallic = Some(factor("metallicFactor")?);
    }
    Ok(())
}

/// Reads KHR_texture_transform: scale, then rotation, then offset. The extension rotates coordinates counter-clockwise
/// as seen on the image, whose v axis points down.
fn texture_transform(at: &JsonNode<'_>) -> Result<Affine2, BakeError> {
    let offset: Vec2 = at.get("offset").map_or(Ok([0.0; 2]), |v| v.numbers())?.into();
    let scale: Vec2 = at.get("scale").map_or(Ok([1.0; 2]), |v| v.numbers())?.into();
    let angle = at.get("rotation").map_or(Ok(0.0), |v| v.number())?;
    Ok(Affine2::from_mat2_translation(rotation(-angle) * Mat2::from_diagonal(scale), offset))
}
