//! `ink`: what a model needs to be drawn as an ink-wash painting (Fang 2006).
//!
//! Four textures, painted by the same rules at any size and seed ([`stroke`], [`wash`], [`paper`], [`fur`]), or taken from scans, and for each
//! vertex its place in the wash. Greys are as in the paper, 0 black and 1 white.
//!
//! Everything random is a hash of seed, place and purpose; functions beyond IEEE arithmetic and square roots come from `libm`, so that the same
//! recipe paints the same textures on every machine.

mod diffusion;
mod fur;
mod noise;
mod paper;
mod plane;
mod stroke;
mod wash;

pub use fur::fur;
pub use paper::paper;
pub use plane::Plane;
pub use stroke::stroke;
pub use wash::wash;

use crate::BakeError;
use crate::hair::Strands;
use crate::recipe::{InkParams, PackParams, ShellFormat};
use crate::textures::{AlphaMode, TextureEncoder};
use pelage_formats::TextureFormat;
use plane::{Channel, levels};

/// The textures of the ink style: complete .ktx2 files.
#[derive(Clone, Debug, PartialEq)]
pub struct InkTextures {
    /// The stroke of the sphere map.
    pub stroke: Vec<u8>,
    /// The wash.
    pub wash: Vec<u8>,
    /// The paper.
    pub paper: Vec<u8>,
    /// Strokes of fur, for a model that has some.
    pub fur: Option<Vec<u8>>,
}

/// Paints and encodes the textures. Where there are strands, their fur is painted, too.
///
/// # Errors
/// [`BakeError::Params`] for a value outside its range, [`BakeError::Internal`] if the encoder fails.
pub fn textures(params: &InkParams, pack: &PackParams, strands: Option<&Strands>) -> Result<InkTextures, BakeError> {
    use Channel::{Threshold, Value};
    params.validate()?;
    pack.validate()?;
    let dry = [Value, Value, Value, Threshold];
    let encode = |layers: Vec<[Plane; 4]>, channels, alpha| {
        let format = match pack.shell_format {
            ShellFormat::Bc7 => TextureFormat::Bc7Unorm,
            ShellFormat::Rgba8 => TextureFormat::Rgba8Unorm,
        };
        let mut encoder = TextureEncoder::new(format, alpha, pack.bc_quality);
        for planes in layers {
            let side = planes[0].side as u32;
            encoder.push_square_layer(side, &levels(planes, channels))?;
        }
        encoder.finish()
    };
    let ((stroke, wash), (paper, fur)) = rayon::join(
        || {
            let stroke = encode(vec![stroke(params)], [Value; 4], AlphaMode::Opaque);
            (stroke, encode(vec![wash(params, None)], dry, AlphaMode::Straight))
        },
        || {
            let paper = encode(vec![paper(params)], dry, AlphaMode::Straight);
            let fur = strands.filter(|strands| !strands.is_empty()).map(|strands| {
                encode(fur(strands, params.fur_texels, params.seed).to_vec(), [Value; 4], AlphaMode::Straight)
            });
            (paper, fur)
        },
    );
    Ok(InkTextures { stroke: stroke?, wash: wash?, paper: paper?, fur: fur.transpose()? })
}

#[cfg(test)]
mod tests;
