use super::*;
use crate::recipe::{ColorParams, HairParams};
use crate::stages::simulate::{VolumeParams, simulate};
use crate::stages::slice::collect_layers;
use pelage_formats::{Limits, Manifest, Package, PackageWriter, TextureEntry};

const SLICE: SliceParams = SliceParams { layers: 4, tile_texels: 32, filter_width: 0.5 };

fn strands() -> Strands {
    let hair = HairParams { density: 200, ..HairParams::default() };
    simulate(&hair, &ColorParams::default(), &VolumeParams::default()).unwrap()
}

fn pack(shell_format: ShellFormat, direction_format: DirectionFormat) -> PackParams {
    PackParams { shell_format, direction_format, ..PackParams::default() }
}

/// Decodes one level of one layer to RGBA8.
fn decode(format: TextureFormat, data: &[u8], width: u32, height: u32) -> Vec<u8> {
    format.to_rgba8(data, width, height).unwrap()
}

fn in_package(files: &[&[u8]], check: impl Fn(&Package<'_>)) {
    let textures = (0..files.len()).map(|i| TextureEntry { name: format!("t{i}") }).collect();
    let mut writer = PackageWriter::new(Manifest { textures, ..Manifest::default() });
    for file in files {
        writer = writer.texture(file.to_vec());
    }
    let bytes = writer.finish().unwrap();
    check(&Package::open(&bytes, &Limits::default()).unwrap());
}

#[test]
fn every_format_reads_back_layer_by_layer() {
    let strands = strands();
    for (shell, direction, color_format, direction_format, tolerance) in [
        (ShellFormat::Rgba8, DirectionFormat::Rgba8, TextureFormat::Rgba8Srgb, TextureFormat::Rgba8Unorm, 0.0),
        (ShellFormat::Bc7, DirectionFormat::Rg8, TextureFormat::Bc7Srgb, TextureFormat::Rg8Unorm, 12.0),
        (ShellFormat::Rgba8, DirectionFormat::Bc5, TextureFormat::Rgba8Srgb, TextureFormat::Bc5Unorm, 12.0),
    ] {
        let set = collect_layers(&strands, &SLICE, direction_format).unwrap();
        let files = shell_textures(&strands, None, &SLICE, &pack(shell, direction), false, &mut || ()).unwrap();
        in_package(&[&files.color, &files.direction], |package| {
            let bytes: u64 = (0..2).map(|i| package.texture(i).unwrap().gpu_bytes()).sum();
            assert_eq!(bytes, shell_bytes(&SLICE, &pack(shell, direction), false, false));
            for (i, format) in [color_format, direction_format].into_iter().enumerate() {
                let view = package.texture(i as u32).unwrap();
                assert_eq!((view.format, view.width, view.height), (format, 32, 32));
                assert_eq!((view.layers, view.levels), (4, 6));
                for level in 0..view.levels {
                    let (w, h) = view.level_size(level);
                    let bytes = format.layer_bytes(w, h) as usize;
                    for (k, data) in view.level(level).chunks_exact(bytes).enumerate() {
                        let back = decode(format, data, w, h);
                        let used = format.components() as usize;
                        let rms_to = |k: usize| {
                            let truth = if i == 0 { &set.layers[k].color } else { &set.layers[k].direction };
                            let texels = truth[level as usize].chunks(used).zip(back.chunks(4));
                            let squares = texels
                                .flat_map(|(a, b)| a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)));
                            (squares.sum::<f64>() / f64::from(w * h) / used as f64).sqrt()
                        };
                        assert!(rms_to(k) <= tolerance, "{format:?} layer {k} level {level}: rms {}", rms_to(k));
                        // No other layer may match as well as this one.
                        assert!(i == 1 || level > 0 || rms_to((k + 1) % 4) > 2.0 * tolerance, "{format:?} layer {k}");
                    }
                }
            }
        });
    }
}
