//! Cases of images: PNG and JPEG files that models and recipes name, and KTX2 files in unpacked folders.

use super::bases::{Bases, MAPS};
use super::case::{Case, Entry, OutputCheck, Step};
use super::change;
use super::models::bake;
use super::random::Random;

/// Makes a case.
pub fn case(bases: &Bases, turn: u64, random: &mut Random) -> Case {
    match random.below(4) {
        0 => ktx2(bases, random),
        1 => {
            let (document, files) = bases.gltf();
            let (how, entry) = image(bases, random);
            let base = [files, vec![Entry::file("m.gltf", document.to_string())]].concat();
            Case::new(format!("model: {how}"), &base, vec![entry], bake("m.gltf", &[], turn))
        }
        _ => {
            let (how, entry) = image(bases, random);
            let base = [bases.images(), vec![bases.glb(), Entry::file("r.toml", MAPS)]].concat();
            let args = ["bake", "m.glb", "-o", "out.pelage", "--threads", "1", "--recipe", "r.toml"];
            let steps = vec![Step::makes(&args, "out.pelage", OutputCheck::Validates)];
            Case::new(format!("recipe: {how}"), &base, vec![entry], steps)
        }
    }
}

/// Returns one of the images with changed bytes. The checksums of PNG files are mostly updated.
fn image(bases: &Bases, random: &mut Random) -> (String, Entry) {
    let (name, mut bytes) = match random.below(3) {
        0 => ("b.jpg", bases.jpg.clone()),
        _ => ("a.png", bases.png.clone()),
    };
    let mut how = if name == "a.png" && random.below(3) == 0 {
        size(&mut bytes, random)
    } else {
        change::bytes(&mut bytes, random)
    };
    if name == "a.png" && random.below(4) > 0 {
        seal_png(&mut bytes);
        how += ", checksums right";
    }
    (format!("{name}: {how}"), Entry::File(name.into(), bytes))
}

/// Changes the width, height, bit depth or colour type in the header of a PNG.
fn size(png: &mut [u8], random: &mut Random) -> String {
    let at = *random.pick(&[16, 20]);
    let size = *random.pick(&[0, 1, 9, 255, 16_384, 65_536, 0x7fff_ffff, u32::MAX]);
    png[at..at + 4].copy_from_slice(&size.to_be_bytes());
    let mut how = format!("{size} texels");
    if random.below(2) == 0 {
        let (depth, kind) = (*random.pick(&[0, 1, 2, 4, 8, 16, 255]), *random.pick(&[0, 2, 3, 4, 6, 7]));
        png[24] = depth;
        png[25] = kind;
        how += &format!(" of {depth} bits, kind {kind}");
    }
    how
}

/// Updates the checksums of a PNG's chunks, up to the first invalid length.
fn seal_png(bytes: &mut [u8]) {
    let mut at = 8;
    while let Some(length) =
        bytes.get(at..).and_then(|rest| rest.first_chunk()).map(|l| u32::from_be_bytes(*l) as usize)
    {
        let Some(end) = at.checked_add(8).and_then(|n| n.checked_add(length)).filter(|end| end + 4 <= bytes.len())
        else {
            return;
        };
        let checksum = crc32fast::hash(&bytes[at + 4..end]).to_be_bytes();
        bytes[end..end + 4].copy_from_slice(&checksum);
        at = end + 4;
    }
}

/// Changes a texture of an unpacked folder.
fn ktx2(bases: &Bases, random: &mut Random) -> Case {
    let (name, base) = random.pick(&bases.folders);
    let textures: Vec<&Entry> = base.iter().filter(|entry| entry.name().ends_with(".ktx2")).collect();
    let Entry::File(file, bytes) = *random.pick(&textures) else { unreachable!("folders contain KTX2 files") };
    let mut bytes = bytes.clone();
    let how = change::bytes(&mut bytes, random);
    let entry = Entry::File(file.clone(), bytes);
    let steps = vec![Step::makes(&["pack", "in", "out.pelage"], "out.pelage", OutputCheck::Validates)];
    Case::new(format!("{name}: {file}: {how}"), base, vec![entry], steps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sealed_png_is_read_with_its_stated_size() {
        let mut out = std::io::Cursor::new(Vec::new());
        image::RgbaImage::new(2, 2).write_to(&mut out, image::ImageFormat::Png).unwrap_or_else(|e| panic!("{e}"));
        let good = out.into_inner();
        let mut sealed = good.clone();
        seal_png(&mut sealed);
        assert!(sealed == good, "valid checksums must not change");
        sealed[20..24].copy_from_slice(&1_u32.to_be_bytes());
        assert!(image::load_from_memory(&sealed).is_err());
        seal_png(&mut sealed);
        assert!(image::load_from_memory(&sealed).is_ok_and(|image| image.height() == 1));
    }
}
