//! Encoding of texels as .ktx2 files with the `ctt` crate (Intel's block encoder; KTX2 writer).
//!
//! Layers are encoded one at a time as they arrive, so that only the blocks of a large tile stay in memory.

use crate::recipe::{BaseColorFormat, BcQuality, PackParams};
pub use ctt::AlphaMode;
use ctt::Quality;
use ctt::encoders::Encoder;
use ctt::{
    ColorSpace, Container, ConvertSettings, FormatDesc, ImageRef, PipelineOutput, Surface, SurfaceRef, TargetFormat,
    TextureKind,
};
use ktx2::Format;
use pelage_formats::TextureFormat;
use pelage_import::BakeError;
use pelage_import::mesh::Image;

/// Mip level of a layer.
#[derive(Clone, Copy, Debug)]
pub struct RawLevel<'a> {
    /// Width, texels.
    pub width: u32,
    /// Height, texels.
    pub height: u32,
    /// Texels, `width * height`, row-major: RGBA bytes, RG bytes for two-component formats, or half floats for
    /// half-float formats.
    pub texels: &'a [u8],
}

impl<'a> RawLevel<'a> {
    fn surface(&self, texel_bytes: u32) -> SurfaceRef<'a> {
        let (width, height, data) = (self.width, self.height, self.texels);
        SurfaceRef { data, width, height, depth: 1, stride: width * texel_bytes, slice_stride: 0 }
    }
}

/// Collects the layers of one texture and writes it as a complete .ktx2 file.
#[derive(Debug)]
pub struct TextureEncoder {
    format: TextureFormat,
    alpha: AlphaMode,
    /// Whether texels of alpha 0 keep their colour. Otherwise it is black, except in opaque and premultiplied textures.
    keeps_clear_colors: bool,
    quality: Quality,
    /// Encoded levels; one list per layer.
    layers: Vec<Vec<Surface>>,
}

impl From<BcQuality> for Quality {
    fn from(quality: BcQuality) -> Self {
        match quality {
            // Faster by one step than the name in `ctt`: its `Basic` takes 2 µs per texel, 47 s for a 512×512×64 tile
            // on two cores.
            BcQuality::Fast => Self::VeryFast,
            BcQuality::Basic => Self::Fast,
            BcQuality::Slow => Self::Basic,
        }
    }
}

impl TextureEncoder {
    /// Creates a texture of `format` without layers. Premultiplied colour is recorded in the data format descriptor of
    /// the file. For opaque textures, the block encoder tries fewer modes.
    pub fn new(format: TextureFormat, alpha: AlphaMode, quality: BcQuality) -> Self {
        Self { format, alpha, keeps_clear_colors: false, quality: quality.into(), layers: Vec::new() }
    }

    fn color_space(&self) -> ColorSpace {
        match self.format {
            TextureFormat::Rgba8Srgb | TextureFormat::Bc7Srgb => ColorSpace::Srgb,
            _ => ColorSpace::Linear,
        }
    }

    /// Returns the format of the input texels and their size in bytes.
    fn raw_format(&self) -> (Format, u32) {
        match (self.format, self.format.components(), self.color_space()) {
            (TextureFormat::Rgba16Float, ..) => (Format::R16G16B16A16_SFLOAT, 8),
            (_, 2, _) => (Format::R8G8_UNORM, 2),
            (_, _, ColorSpace::Srgb) => (Format::R8G8B8A8_SRGB, 4),
            (_, _, ColorSpace::Linear) => (Format::R8G8B8A8_UNORM, 4),
        }
    }

    fn describe(&self, format: Format) -> FormatDesc {
        FormatDesc { format, color_space: self.color_space(), alpha: self.alpha }
    }

    /// Encodes one layer with its mip levels, largest first. The sizes must be the same for all layers.
    pub fn push_layer(&mut self, levels: &[RawLevel<'_>]) -> Result<(), BakeError> {
        let (raw, bytes) = self.raw_format();
        let mut desc = self.describe(raw);
        if self.keeps_clear_colors && desc.alpha == AlphaMode::Straight {
            // `ctt` multiplies straight colours by alpha and divides them again. It leaves others as they are.
            desc.alpha = AlphaMode::Premultiplied;
        }
        let image = ImageRef {
            surfaces: vec![levels.iter().map(|level| level.surface(bytes)).collect()],
            kind: TextureKind::Texture2D,
            desc,
        };
        let target = match self.format.block_size() {
            1 => TargetFormat::Uncompressed(self.format.ktx2()),
            _ => TargetFormat::Compressed {
                format: self.format.ktx2(),
                encoder: Encoder::Intel(ctt::encoders::ispc::IspcSettings::default()),
            },
        };
        let settings = ConvertSettings {
            format: Some(target),
            container: Container::Raw,
            quality: self.quality,
            ..Default::default()
        };
        match ctt::convert(image, settings) {
            Ok(PipelineOutput::Raw(image)) => {
                self.layers.extend(image.surfaces);
                Ok(())
            }
            Ok(PipelineOutput::Encoded(_)) => Err(internal("found an encoded image, expected texels")),
            Err(error) => Err(internal(error)),
        }
    }

    /// Encodes one layer of square levels, from `texels * texels` down to one texel, like
    /// [`TextureEncoder::push_layer`].
    pub fn push_square_layer(&mut self, texels: u32, levels: &[Vec<u8>]) -> Result<(), BakeError> {
        let sizes = (0..).map(|level| texels >> level);
        let raw = sizes.zip(levels).map(|(size, texels)| RawLevel { width: size, height: size, texels });
        self.push_layer(&raw.collect::<Vec<_>>())
    }

    /// Does the same as [`TextureEncoder::finish`] for layers pushed in reverse order.
    pub fn finish_reversed(mut self) -> Result<Vec<u8>, BakeError> {
        self.layers.reverse();
        self.finish()
    }

    /// Does the same as [`TextureEncoder::finish_reversed`], except that the layer pushed last is also the last layer
    /// of the file.
    pub fn finish_reversed_but_last(mut self) -> Result<Vec<u8>, BakeError> {
        self.layers.reverse();
        self.layers.rotate_left(1);
        self.finish()
    }

    /// Writes the .ktx2 file: a 2D array if there are several layers, otherwise a plain 2D texture.
    pub fn finish(self) -> Result<Vec<u8>, BakeError> {
        let desc = self.describe(self.format.ktx2());
        let image = ctt::Image { surfaces: self.layers, kind: TextureKind::Texture2D, desc };
        let settings = ConvertSettings { container: Container::ktx2(), ..Default::default() };
        match ctt::convert(image.to_ref(), settings) {
            Ok(PipelineOutput::Encoded(bytes)) => Ok(bytes),
            Ok(PipelineOutput::Raw(_)) => Err(internal("found texels, expected a file")),
            Err(error) => Err(internal(error)),
        }
    }
}

fn internal(error: impl std::fmt::Display) -> BakeError {
    BakeError::Internal(format!("texture encoder: {error}"))
}

/// Encodes a base-colour image with mips filtered in linear light.
///
/// Block formats need sides that are multiples of four (WebGPU, "texture creation"). Other images are resampled to the
/// next larger multiple.
pub fn encode_base_color(image: &Image, params: &PackParams) -> Result<Vec<u8>, BakeError> {
    let format = match params.base_color_format {
        BaseColorFormat::Bc7 => TextureFormat::Bc7Srgb,
        BaseColorFormat::Rgba8 => TextureFormat::Rgba8Srgb,
    };
    let opaque = image.rgba.chunks_exact(4).all(|texel| texel[3] == 255);
    let alpha = if opaque { AlphaMode::Opaque } else { AlphaMode::Straight };
    encode_image(image, format, alpha, params)
}

/// Encodes the red and green channels of a groom texture in the format of the direction textures.
pub fn encode_groom(image: &Image, params: &PackParams) -> Result<Vec<u8>, BakeError> {
    encode_image(image, params.direction_format.into(), AlphaMode::Opaque, params)
}

fn encode_image(
    image: &Image,
    format: TextureFormat,
    alpha: AlphaMode,
    params: &PackParams,
) -> Result<Vec<u8>, BakeError> {
    let mut encoder =
        TextureEncoder { keeps_clear_colors: true, ..TextureEncoder::new(format, alpha, params.bc_quality) };
    let space = encoder.color_space();
    let mut levels = mip_chain(image.width, image.height, &image.rgba, space)?;
    levels.retain(|level| level.width.max(level.height) <= params.base_color_max);
    let block = format.block_size();
    if let Some(top) = levels.first().filter(|top| top.width % block != 0 || top.height % block != 0) {
        let (width, height) = (top.width.next_multiple_of(block), top.height.next_multiple_of(block));
        let texels = image::RgbaImage::from_raw(top.width, top.height, top.data.clone())
            .ok_or_else(|| internal("a mip level of the wrong size"))?;
        let texels = image::imageops::resize(&texels, width, height, image::imageops::FilterType::Triangle);
        levels = mip_chain(width, height, texels.as_raw(), space)?;
    }
    if format.components() == 2 {
        levels.iter_mut().for_each(|level| {
            level.data = level.data.chunks_exact(4).flat_map(|texel| [texel[0], texel[1]]).collect();
        });
    }
    let levels: Vec<_> =
        levels.iter().map(|s| RawLevel { width: s.width, height: s.height, texels: &s.data }).collect();
    encoder.push_layer(&levels)?;
    encoder.finish()
}

/// Makes the full mip chain of an RGBA8 image with straight alpha. Colours are weighted by alpha, except where it is 0.
fn mip_chain(width: u32, height: u32, rgba: &[u8], color_space: ColorSpace) -> Result<Vec<Surface>, BakeError> {
    let chain = |alpha| {
        let surface = RawLevel { width, height, texels: rgba }.surface(4);
        let format = if color_space == ColorSpace::Srgb { Format::R8G8B8A8_SRGB } else { Format::R8G8B8A8_UNORM };
        let desc = FormatDesc { format, color_space, alpha };
        let image = ImageRef { surfaces: vec![vec![surface]], kind: TextureKind::Texture2D, desc };
        let settings = ConvertSettings { container: Container::Raw, mipmap: true, ..Default::default() };
        match ctt::convert(image, settings) {
            Ok(PipelineOutput::Raw(image)) => image.surfaces.into_iter().next().ok_or_else(|| internal("no layer")),
            Ok(PipelineOutput::Encoded(_)) => Err(internal("found an encoded image, expected texels")),
            Err(error) => Err(internal(error)),
        }
    };
    let mut levels = chain(AlphaMode::Straight)?;
    if rgba.chunks_exact(4).any(|texel| texel[3] == 0) {
        let unweighted = chain(AlphaMode::Opaque)?;
        for (level, unweighted) in levels.iter_mut().zip(&unweighted) {
            let texels = level.data.chunks_exact_mut(4).zip(unweighted.data.chunks_exact(4));
            texels
                .filter(|(texel, _)| texel[3] == 0)
                .for_each(|(texel, color)| texel[..3].copy_from_slice(&color[..3]));
        }
    }
    Ok(levels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recipe::DirectionFormat;
    use pelage_formats::{Limits, Manifest, Package, PackageWriter, TextureEntry};

    fn reread<T>(ktx2: Vec<u8>, look: impl FnOnce(pelage_formats::TextureView<'_>) -> T) -> T {
        let manifest = Manifest { textures: vec![TextureEntry { name: "t".into() }], ..Manifest::default() };
        let bytes = PackageWriter::new(manifest).texture(ktx2).finish().unwrap();
        look(Package::open(&bytes, &Limits::default()).unwrap().texture(0).unwrap())
    }

    #[test]
    fn layers_and_levels_keep_their_order_in_every_format() {
        for format in TextureFormat::ALL {
            let n = if format == TextureFormat::Rgba16Float { 8 } else { format.components() as usize };
            let texels = |size: u32, value: u8| vec![value; (size * size) as usize * n];
            let mut encoder = TextureEncoder::new(format, AlphaMode::Premultiplied, BcQuality::Basic);
            for layer in 0..3u8 {
                let levels: Vec<_> = (0..4u8).map(|l| (8 >> l, texels(8 >> l, 10 + 60 * layer + 10 * l))).collect();
                let raw: Vec<_> = levels.iter().map(|(s, t)| RawLevel { width: *s, height: *s, texels: t }).collect();
                encoder.push_layer(&raw).unwrap();
            }
            reread(encoder.finish().unwrap(), |view| {
                assert_eq!((view.format, view.width, view.layers, view.levels), (format, 8, 3, 4));
                let reader = ktx2::Reader::new(view.ktx2).unwrap();
                assert_eq!(reader.is_alpha_premultiplied(), Some(true), "{format:?}");
                if format.block_size() == 1 {
                    for (level, layer) in (0..4u32).flat_map(|level| (0..3u32).map(move |layer| (level, layer))) {
                        let size = format.layer_bytes(8 >> level, 8 >> level) as usize;
                        let bytes = &view.level(level)[layer as usize * size..][..size];
                        let expected = (10 + 60 * layer + 10 * level) as u8;
                        assert!(bytes.iter().all(|b| *b == expected), "{format:?} level {level} layer {layer}");
                    }
                }
            });
        }
    }

    #[test]
    fn clear_texels_keep_their_colour_in_every_level() {
        let texels = |x: u32| if x < 20 { [230, 140, 60, 0] } else { [230, 140, 60, 255] };
        // The second size is resampled, because blocks need sides that are multiples of four.
        for (width, height) in [(32, 32), (30, 21)] {
            let rgba = (0..height).flat_map(|_| (0..width).flat_map(texels)).collect();
            let image = Image { width, height, rgba };
            for base_color_format in [BaseColorFormat::Bc7, BaseColorFormat::Rgba8] {
                let params = PackParams { base_color_format, ..PackParams::default() };
                reread(encode_base_color(&image, &params).unwrap(), |view| {
                    for level in 0..view.levels {
                        let found = crate::stages::slice::decode_texture(&view, level, 0).unwrap();
                        for texel in found.chunks(4) {
                            let apart = texel.iter().zip([230u8, 140, 60]).map(|(a, b)| a.abs_diff(b)).max();
                            assert!(
                                apart <= Some(3),
                                "{width} x {height}, {base_color_format:?}, level {level}: {texel:?}"
                            );
                        }
                        if level == 0 {
                            assert_eq!((found[3], found[4 * width as usize - 9]), (0, 255));
                        }
                    }
                });
            }
        }
    }

    #[test]
    fn groom_textures_keep_red_and_green_in_every_format() {
        let image = Image { width: 6, height: 4, rgba: [200, 60, 0, 255].repeat(24) };
        for direction_format in DirectionFormat::ALL.iter().copied() {
            let params = PackParams { direction_format, ..PackParams::default() };
            reread(encode_groom(&image, &params).unwrap(), |view| {
                let block = view.format.block_size();
                assert_eq!(
                    (view.format, view.width, view.height),
                    (direction_format.into(), 6u32.next_multiple_of(block), 4)
                );
                if block == 1 {
                    let n = view.format.components() as usize;
                    assert!(
                        view.level(0).chunks_exact(n).chain(view.level(2).chunks_exact(n)).all(|t| t[..2] == [200, 60])
                    );
                }
            });
        }
    }

    #[test]
    fn base_colour_is_downscaled_and_padded_to_blocks() {
        let image = Image { width: 30, height: 22, rgba: [200, 100, 50, 255].repeat(30 * 22) };
        let params = PackParams { base_color_max: 16, ..PackParams::default() };
        reread(encode_base_color(&image, &params).unwrap(), |view| {
            assert_eq!((view.format, view.width, view.height), (TextureFormat::Bc7Srgb, 16, 12));
            assert_eq!(view.levels, 5);
        });
        let params = PackParams { base_color_format: BaseColorFormat::Rgba8, ..PackParams::default() };
        reread(encode_base_color(&image, &params).unwrap(), |view| {
            assert_eq!((view.width, view.height, view.levels), (30, 22, 5));
            assert_eq!(view.level(4), &[200, 100, 50, 255], "a flat image stays flat down to one texel");
        });
    }
}
