//! Seal named by a look, read from its image.

use super::exit::Failure;
use pelage_bake::io::read_file;
use pelage_formats::meaning::seal::SealImage;
use pelage_import::BakeError;
use pelage_import::image_file::{Channels, decode_image};
use pelage_stage::Look;
use std::path::Path;
use std::sync::Arc;

/// Reads the image of a look's seal, if it has one.
///
/// Fails for a file that cannot be read, or is not an image, with what was found and expected.
pub fn read_of(look: &mut Look) -> Result<(), Failure> {
    let mut failure = None;
    let read = look.read_seal(&mut |path| {
        read(path).map_err(|error| {
            let text = error.to_string();
            failure = Some(error);
            text
        })
    });
    read.map_err(|reason| failure.map_or(Failure::Usage(reason), Failure::from))
}

/// Reads the image of a seal for the window.
///
/// Fails like [`read_of`], with the message as text.
#[cfg(feature = "view")]
pub fn read_text(path: &Path) -> Result<Arc<SealImage>, String> {
    read(path).map_err(|error| error.to_string())
}

fn read(path: &Path) -> Result<Arc<SealImage>, BakeError> {
    let bytes = read_file(path)?;
    let side = u64::from(SealImage::MAX_SIDE);
    let mut texels_left = side * side;
    let decoded = decode_image(&bytes, &mut texels_left, Channels::Color);
    let sealed = decoded.and_then(|(image, _)| SealImage::new([image.width, image.height], image.rgba));
    let place = "whole file".to_owned();
    let fail = |reason| BakeError::Input { file: path.display().to_string(), place, reason };
    sealed.map(Arc::new).map_err(fail)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seals_are_read_or_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("seal.png");
        let look = || {
            let mut look = Look::default();
            look.set(&format!("ink.seal={}", path.display())).unwrap();
            look
        };
        let refused = |said: &str| {
            let text = read_of(&mut look()).unwrap_err().to_string();
            assert!(text.contains("seal.png") && text.contains(said), "{text}");
        };
        refused("cannot");
        std::fs::write(&path, b"no image").unwrap();
        refused("expected PNG, JPEG or WebP");
        image::RgbaImage::from_pixel(3, 2, image::Rgba([200, 30, 20, 255])).save(&path).unwrap();
        let mut look = look();
        read_of(&mut look).unwrap();
        let image = look.ink.seal.unwrap().image.unwrap();
        assert_eq!((image.size(), &image.rgba()[..4]), ([3, 2], &[200, 30, 20, 255][..]));
    }
}
