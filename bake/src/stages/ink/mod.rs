//! `ink`: textures and vertex data for drawing a model as an ink-wash painting (Fang 2006).
//!
//! There are four textures, painted by the same rules at any size and seed ([`stroke`], [`wash`], [`paper`], [`fur`])
//! or made from scans. Each vertex stores its wash product. Greys are as in the paper: 0 is black, 1 is white.
//!
//! All random values are hashes of seed, position and purpose. Functions beyond IEEE arithmetic and square roots come
//! from `libm`, so that the same recipe paints the same textures on every machine.

mod center;
mod diffusion;
mod fur;
mod noise;
mod paper;
mod plane;
mod product;
mod scan;
mod stroke;
mod vertices;
mod wash;

pub use fur::fur;
pub use paper::paper;
pub use plane::Plane;
pub use scan::{stroke_band, wash_tile};
pub use stroke::stroke;
pub use vertices::{InkTarget, InkVertices, vertices};
pub use wash::wash;

use crate::memo::Memo;
use crate::progress::StageProgress;
use crate::recipe::{ColorParams, FilePath, GroomParams, HairParams, InkParams, PackParams, Recipe, ShellFormat};
use crate::stages::assemble::NamedTexture;
use crate::stages::groom::MapImages;
use crate::stages::simulate::Strands;
use crate::stages::slice::{AlphaMode, TextureEncoder};
use pelage_formats::{InkShading, InkVertex, TextureFormat};
use pelage_import::BakeError;
use pelage_import::mesh::{Image, Model};
use plane::{Channel, levels};

/// Per-vertex data and settings of the ink style, without the textures.
#[derive(Clone, Debug)]
pub struct VertexInk {
    /// Period of the wash texture on the mesh surface, metres.
    pub grain_size_m: f32,
    /// Shading constants.
    pub shading: InkShading,
    /// Ink data per vertex of the mesh.
    pub vertices: Vec<InkVertex>,
    /// Centre of the wash, metres, if chosen automatically; `None` if the recipe gives one.
    pub center: Option<[f32; 3]>,
    /// Warnings.
    pub warnings: Vec<String>,
}

/// Textures of the ink style: names, and complete .ktx2 files.
#[derive(Clone, Debug, PartialEq)]
pub struct InkFiles<'a> {
    /// Stroke for outlines, a sphere map.
    pub stroke: NamedTexture<'a>,
    /// Texture of the wash.
    pub wash: NamedTexture<'a>,
    /// Texture of the paper.
    pub paper: NamedTexture<'a>,
    /// Strokes of fur; `None` if the model has no fur.
    pub fur: Option<NamedTexture<'a>>,
}

/// Default period of the wash texture on the mesh surface, as a share of the bounding sphere's radius. It makes
/// blotches a few times smaller than the body.
const GRAIN_PER_RADIUS: f32 = 0.8;

/// Returns the strength of the fur strokes, 0..=1: the recipe's value, if given. Otherwise it is the default strength
/// if anything shows that the model has fur, else 0. A static mesh with default fur could be a stone, and unwanted hair
/// would be the worse guess.
///
/// `furred` has one entry per material. A model with a material detected as bare, such as eyes, counts as furred.
pub fn fur_strength(recipe: &Recipe, model: &Model, furred: &[bool]) -> f32 {
    let speaks_of_fur = model.animation.is_some()
        || recipe.hair != HairParams::default()
        || recipe.groom != GroomParams::default()
        || recipe.color != ColorParams::default()
        || recipe.fins.depth.is_some()
        || recipe.model.bare.as_ref().is_some_and(|bare| !bare.is_empty())
        || furred.contains(&false);
    recipe.ink.fur.unwrap_or(if speaks_of_fur { InkShading::default().fur } else { 0.0 })
}

/// Returns the shading constants. `fur`: strength of the fur strokes, from [`fur_strength`].
fn shading(p: &InkParams, fur: f32) -> InkShading {
    InkShading {
        wash_speed: p.speed,
        wash_range: p.range,
        normalised: p.normalised,
        grain: p.grain,
        tone: p.tone,
        fur,
        line: p.line,
    }
}

/// Computes the per-vertex part of the ink style, with warnings. `fur`: strength of the fur strokes, from
/// [`fur_strength`].
///
/// Fails with [`BakeError::Params`] for a value outside its range, [`BakeError::Internal`] if an image was not read.
pub fn vertex_ink(params: &InkParams, fur: f32, canvas: &InkTarget<'_>) -> Result<VertexInk, BakeError> {
    params.validate()?;
    let shading = shading(params, fur);
    let mut warnings = Vec::new();
    let InkVertices { vertices, center } = vertices(params, &shading, canvas, &mut warnings)?;
    // A model that is a single point has no radius.
    let radius = if canvas.radius > 0.0 { canvas.radius } else { 1.0 };
    let grain_size_m = params.grain_size_m.unwrap_or(GRAIN_PER_RADIUS * radius);
    Ok(VertexInk { grain_size_m, shading, vertices, center: Some(center.into()), warnings })
}

/// Textures of the ink style that do not depend on strands, as complete .ktx2 files.
#[derive(Clone, Debug, PartialEq)]
pub struct PaintedTextures {
    stroke: Vec<u8>,
    wash: Vec<u8>,
    paper: Vec<u8>,
}

/// Paints and encodes the textures. `strands` are those of the tile of a furred model; the fur texture is painted only
/// if they are given. `progress` counts each texture twice: when painted and when encoded.
///
/// Fails with [`BakeError::Params`] for a value outside its range, [`BakeError::Input`] for a scan that cannot be used,
/// [`BakeError::Internal`] if the encoder fails or an image was not read.
pub fn textures(
    params: &InkParams,
    pack: &PackParams,
    images: &MapImages,
    strands: Option<&Strands>,
    progress: &StageProgress,
) -> Result<InkFiles<'static>, BakeError> {
    textures_with_memo(params, pack, images, strands, progress, &Memo::default())
}

/// Does the same as [`textures`], but reuses the results in `painting` if tables and images are unchanged.
///
/// Fails like [`textures`].
pub fn textures_with_memo(
    params: &InkParams,
    pack: &PackParams,
    images: &MapImages,
    strands: Option<&Strands>,
    progress: &StageProgress,
    painting: &Memo<(InkParams, PackParams), PaintedTextures>,
) -> Result<InkFiles<'static>, BakeError> {
    params.validate()?;
    pack.validate()?;
    let strands = strands.filter(|strands| !strands.is_empty());
    let packed = texture_format(pack);
    let (painting, fur) = rayon::join(
        || painting.make((params.clone(), pack.clone()), |(params, pack)| paint(params, pack, images, progress)),
        || {
            let paint = |strands| fur(strands, params.fur_texels, params.seed).to_vec();
            progress.add("ink", 2 * u64::from(strands.is_some()));
            let strands = strands.map(|strands| {
                encode(paint(strands), [Channel::Value; 4], (AlphaMode::Straight, packed), pack, progress)
            });
            strands.transpose()
        },
    );
    let PaintedTextures { stroke, wash, paper } = painting?;
    let named = |name: &'static str, file: Vec<u8>| (name.into(), file.into());
    Ok(InkFiles {
        stroke: named("ink_stroke", stroke),
        wash: named("ink_wash", wash),
        paper: named("ink_paper", paper),
        fur: fur?.map(|fur| named("ink_fur", fur)),
    })
}

fn texture_format(pack: &PackParams) -> TextureFormat {
    match pack.shell_format {
        ShellFormat::Bc7 => TextureFormat::Bc7Unorm,
        ShellFormat::Rgba8 => TextureFormat::Rgba8Unorm,
    }
}

fn encode(
    layers: Vec<[Plane; 4]>,
    channels: [Channel; 4],
    (alpha, format): (AlphaMode, TextureFormat),
    pack: &PackParams,
    progress: &StageProgress,
) -> Result<Vec<u8>, BakeError> {
    progress.step("ink");
    let mut encoder = TextureEncoder::new(format, alpha, pack.bc_quality);
    for planes in layers {
        let side = planes[0].side as u32;
        encoder.push_square_layer(side, &levels(planes, channels))?;
    }
    let file = encoder.finish();
    progress.step("ink");
    file
}

fn paint(
    params: &InkParams,
    pack: &PackParams,
    images: &MapImages,
    progress: &StageProgress,
) -> Result<PaintedTextures, BakeError> {
    use Channel::{Threshold, Value};
    progress.add("ink", 2 * 3);
    let dry = [Value, Value, Value, Threshold];
    let packed = texture_format(pack);
    let encode = |planes, channels, alpha, format| encode(vec![planes], channels, (alpha, format), pack, progress);
    let scan = |path: &Option<FilePath>, read: fn(&str, &Image) -> Result<Plane, BakeError>| {
        path.as_ref().map(|path| read(&path.0, images.get(&path.0)?)).transpose()
    };
    let (band, tile) = (scan(&params.stroke_image, stroke_band)?, scan(&params.wash_image, wash_tile)?);
    let (stroke, (wash, paper)) = rayon::join(
        || encode(stroke(params, band.as_ref()), [Value; 4], AlphaMode::Opaque, packed),
        || {
            rayon::join(
                || encode(wash(params, tile.as_ref()), dry, AlphaMode::Straight, packed),
                // Uncompressed: block compression handles four unrelated channels badly, and on blank paper its errors
                // show as dashes.
                || encode(paper(params), dry, AlphaMode::Straight, TextureFormat::Rgba8Unorm),
            )
        },
    );
    Ok(PaintedTextures { stroke: stroke?, wash: wash?, paper: paper? })
}

#[cfg(test)]
mod tests;
