//! Tests of the texture reader with every .ktx2 file of the test data, well-formed and malformed.

use crate::common;
use pelage_formats::*;
use pelage_needs::data;

/// Malformed files that are accepted because pelage does not read the faulty part; the part is given for each. All
/// other files in `invalid/` must be rejected, except for `warning_` files, which are legal.
const ACCEPTED: [(&str, &str); 19] = [
    ("error_InvalidColorPrimaries_0xFF", PRIMARIES),
    ("error_NotEnoughDataForAnEntry", KEY_VALUES),
    ("error_KeyAndValueByteLengthTooSmall", KEY_VALUES),
    ("error_KeyForbiddenBOM", KEY_VALUES),
    ("error_SizesDontAddUp", KEY_VALUES),
    ("error_UnknownReservedKey_ktxLowerCase", KEY_VALUES),
    ("error_PaddingNotZero", KEY_VALUES),
    ("error_DuplicateKey", KEY_VALUES),
    ("error_KTXcubemapIncompleteInvalidBitSet_01000001", KEY_VALUES),
    ("error_KTXcubemapIncompleteAllBitsSet_00111111", KEY_VALUES),
    ("error_KTXcubemapIncompleteNoBitSet_00000000", KEY_VALUES),
    ("error_KTXcubemapIncompleteIncompatibleLayerCount_L1C2", KEY_VALUES),
    ("error_KTXcubemapIncompleteInvalidSize_0byte", KEY_VALUES),
    ("error_KTXglFormatInvalidValueForCompressed_BC5_UNORM_BLOCK_023", KEY_VALUES),
    ("error_KTXswizzle", KEY_VALUES),
    ("error_KTXwriterMissingNull", KEY_VALUES),
    ("error_KTXwriterInvalidUTF8", KEY_VALUES),
    ("error_KTXwriterScParamsInvalidUTF8", KEY_VALUES),
    ("error_KTXanimData", KEY_VALUES),
];
const KEY_VALUES: &str = "key/value data is not read: nothing in it changes what is uploaded";
const PRIMARIES: &str = "colour primaries are not read: packages hold sRGB primaries only";

/// Well-formed files that must open: all files with a supported format in a 2D texture that is ready to upload.
const OPENED: [&str; 11] = [
    "cts_valid_R16G16B16A16_SFLOAT_2D.ktx2",
    "cts_valid_R8G8B8A8_SRGB_2D.ktx2",
    "cts_valid_R8G8B8A8_SRGB_2D_ARRAY_MIP.ktx2",
    "cts_valid_R8G8B8A8_SRGB_2D_MIP.ktx2",
    "gltftransform_2d_bc7.ktx2",
    "gltftransform_2d_rgba16_linear.ktx2",
    "gltftransform_2d_rgba8.ktx2",
    "ktxparse_arraytex_7_mipmap_reference_u.ktx2",
    "ktxparse_luminance_alpha_reference_u.ktx2",
    "ktxparse_rgba-reference-u.ktx2",
    "magnum_bgra.ktx2",
];

/// Returns name and contents of every file below `ktx2/<folder>` of the test data. If there are no data, reports this
/// for the test `test` and returns `None`.
fn files(folder: &str, test: &str) -> Option<Vec<(String, Vec<u8>)>> {
    let root = data(test)?.join("ktx2").join(folder);
    let (mut files, mut folders) = (Vec::new(), vec![root]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "ktx2") {
                files.push((path.file_name().unwrap().to_str().unwrap().to_owned(), std::fs::read(path).unwrap()));
            }
        }
    }
    files.sort();
    assert!(files.len() >= 40, "only {} files: is this the right folder?", files.len());
    Some(files)
}

/// Opens a file inside a package, where errors must carry the offset in the package.
fn open_in_package(ktx2: &[u8]) -> Result<(), FormatError> {
    let textures = vec![TextureEntry { name: "t".into() }];
    let bytes = PackageWriter::new(Manifest { textures, ..Manifest::default() }).texture(ktx2).finish()?;
    let package = Package::open(&bytes, &Limits::default())?;
    let view = package.texture(0)?;
    let levels: u64 = (0..view.levels).map(|k| view.level(k).len() as u64).sum();
    assert_eq!(levels, view.gpu_bytes());
    Ok(())
}

#[test]
fn malformed_files_are_refused() {
    let Some(files) = files("invalid", "malformed_files_are_refused") else { return };
    let mut used = [false; ACCEPTED.len()];
    for (name, bytes) in &files {
        let known = ACCEPTED.iter().position(|(prefix, _)| name.starts_with(prefix));
        match open_in_package(bytes) {
            Ok(()) if name.starts_with("warning_") => {}
            Ok(()) => used[known.unwrap_or_else(|| panic!("{name} was accepted, expected an error"))] = true,
            Err(error) => {
                assert_eq!(error.section(), Some(Tag::TEXTURE), "{name}: {error}");
                assert!(error.offset().is_some_and(|at| at >= 96), "{name}: {error}");
            }
        }
    }
    for ((prefix, reason), used) in ACCEPTED.iter().zip(used) {
        assert!(used, "{prefix} is listed as accepted ({reason}), but no file of that name was");
    }
}

#[test]
fn only_supported_ktx2_files_open() {
    let Some(files) = files("valid", "only_supported_ktx2_files_open") else { return };
    let opened: Vec<_> = files.iter().filter(|(_, b)| open_in_package(b).is_ok()).map(|(name, _)| name).collect();
    assert_eq!(opened, OPENED);
}

/// No file of the data set covers arbitrary bytes, on which the `ktx2` crate's own reader panics.
#[test]
fn arbitrary_bytes_in_a_ktx2_file_do_not_panic() {
    for format in TextureFormat::ALL {
        let good = common::ktx2_file(format, 8, 4, 2, 3, 0);
        let mut accepted = 0;
        for at in 0..good.len() {
            for value in [0, 1, 0x7f, 0x80, 0xff] {
                let mut bytes = good.clone();
                bytes[at] = value;
                if let Ok(view) = TextureView::parse(&bytes, 0, &Limits::default()) {
                    accepted += 1;
                    assert!((0..view.levels).all(|k| view.level(k).len() as u64 == view.level_bytes(k)));
                }
            }
        }
        assert!(accepted > 0);
        for length in 0..good.len() {
            let error = TextureView::parse(&good[..length], 0, &Limits::default()).unwrap_err();
            assert_eq!(error.section(), Some(Tag::TEXTURE), "{length} bytes: {error}");
        }
    }
}

/// A view is a plain struct that anyone can fill, so its methods must not trust its fields.
#[test]
fn inconsistent_texture_view_does_not_panic() {
    let mut index = vec![0xff; 80 + 24 * 4];
    index[80..88].copy_from_slice(&8u64.to_le_bytes());
    let view = TextureView {
        format: TextureFormat::Rgba8Srgb,
        width: u32::MAX,
        height: u32::MAX,
        layers: u32::MAX,
        levels: u32::MAX,
        ktx2: &index,
    };
    for level in [0, 1, 31, 32, 33, u32::MAX - 1, u32::MAX] {
        assert!(view.level(level).is_empty());
        assert!(view.level_size(level).0 >= 1);
    }
    assert_eq!(view.gpu_bytes(), u64::MAX);
}
