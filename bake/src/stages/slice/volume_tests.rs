use super::*;
use crate::recipe::{ColorParams, HairParams, natural};
use crate::stages::simulate::{VolumeParams, simulate};
use glam::Vec3;
use pelage_formats::meaning::linear_to_srgb;

fn strands(hair: &HairParams) -> Strands {
    simulate(hair, &ColorParams::default(), &VolumeParams::default()).unwrap()
}

fn one(a: Vec3, b: Vec3, radius: f32, height: f32) -> Strands {
    Strands {
        points: vec![a, b],
        radii: vec![radius; 2],
        colors: vec![Vec3::new(0.5, 0.25, 0.125); 2],
        offsets: vec![0, 2],
        height,
        root_color: Vec3::splat(0.1),
    }
}

fn layers(strands: &Strands, params: &SliceParams) -> Result<ShellSet, BakeError> {
    collect_layers(strands, params, TextureFormat::Rgba8Unorm)
}

fn params(layers: u32, tile_texels: u32) -> SliceParams {
    SliceParams { layers, tile_texels, ..SliceParams::default() }
}

#[test]
fn layers_have_all_mip_levels_and_an_opaque_skin_layer() {
    let set = layers(&strands(&HairParams { density: 60, ..natural().hair }), &params(5, 32)).unwrap();
    assert_eq!(set.layers.len(), 5);
    for (k, layer) in set.layers.iter().enumerate() {
        assert_eq!(layer.index, k as u32);
        let sizes: Vec<_> = [32usize, 16, 8, 4, 2, 1].iter().map(|n| 4 * n * n).collect();
        assert_eq!(layer.color.iter().map(Vec::len).collect::<Vec<_>>(), sizes);
        assert_eq!(layer.direction.iter().map(Vec::len).collect::<Vec<_>>(), sizes);
    }
    let root = crate::stages::simulate::linear(crate::recipe::HairColors::BROWN.root).to_array().map(linear_to_srgb);
    for level in &set.layers[0].color {
        assert!(level.chunks_exact(4).all(|t| t == [root[0], root[1], root[2], 255]));
    }
    assert!(set.layers[1].color[0].chunks_exact(4).any(|t| t[3] == 0), "hair must leave gaps");
}

#[test]
fn hair_wraps_at_the_borders() {
    // A strand on the corner of the tile shows equally in all four corners. Strands shifted by a whole tile look the
    // same.
    let corner = layers(&one(Vec3::ZERO, Vec3::Z * 0.4, 0.03, 0.4), &params(4, 32)).unwrap();
    let level = &corner.layers[2].color[0];
    let alpha = |x: usize, y: usize| level[4 * (32 * y + x) + 3];
    assert!(alpha(0, 0) > 100, "{}", alpha(0, 0));
    assert_eq!([alpha(31, 0), alpha(0, 31), alpha(31, 31)], [alpha(0, 0); 3]);
    let far = Vec3::new(-3.0, 7.0, 0.0);
    assert_eq!(corner, layers(&one(far, far + Vec3::Z * 0.4, 0.03, 0.4), &params(4, 32)).unwrap());
}

#[test]
fn slanted_hair_is_drawn_without_gaps() {
    // A strand that crosses half the tile within one slab of 4 layers is a streak without gaps.
    let set = layers(&one(Vec3::new(0.1, 0.5, 0.2), Vec3::new(0.7, 0.5, 0.25), 0.01, 0.6), &params(4, 64)).unwrap();
    let level = &set.layers[1].color[0];
    let alphas: Vec<_> = (9..44).map(|x| (31..33).map(|y| level[4 * (64 * y + x) + 3]).max().unwrap()).collect();
    let (least, most) = (alphas.iter().min().unwrap(), alphas.iter().max().unwrap());
    assert!(*least > 40 && most - least < 24, "{alphas:?}");
    assert!(set.layers[3].color[0].iter().all(|b| *b == 0));
}

#[test]
fn blocked_light_equals_strand_width_at_any_resolution() {
    // The strand is within one layer, straight across the tile; its radius is from far below a fine texel to much
    // wider.
    for radius in [0.001, 0.004, 0.02] {
        for texels in [16, 32, 64, 128, 512] {
            for v in [0.5, 0.5 + 0.3 / 64.0, 0.9993] {
                let strand = one(Vec3::new(0.0, v, 0.2), Vec3::new(1.0, v, 0.2), radius, 0.6);
                let set = layers(&strand, &params(4, texels)).unwrap();
                let alphas = set.layers[1].color[0].chunks_exact(4).map(|t| f64::from(t[3]) / 255.0);
                let blocked = alphas.sum::<f64>() / f64::from(texels * texels);
                let width = 2.0 * f64::from(radius);
                // A thin strand's opacity in a coarse texel is only a few steps of a byte.
                let tolerance = 0.04 * width + 0.5 / 255.0 * width.max(3.0 / f64::from(texels));
                assert!((blocked - width).abs() < tolerance, "{radius} in {texels} texels at {v}: {blocked}");
            }
        }
    }
}

#[test]
fn extinction_makes_a_strand_as_opaque_as_it_is_wide() {
    for i in 1..=40 {
        let sharpness = std::f64::consts::SQRT_2 * f64::from(i) / 40.0;
        // Lengths are in standard deviations. `middle` is the optical depth in the middle, `width` the total light
        // blocked.
        let density = f64::from(crate::stages::slice::extinction(sharpness as f32));
        let middle = density * std::f64::consts::PI * sharpness / (2.0 * std::f64::consts::PI).sqrt();
        let step = 1e-3;
        let blocked = |n: i32| 1.0 - libm::exp(-middle * libm::exp(-0.5 * (f64::from(n) * step).powi(2)));
        let width: f64 = (-8000..=8000).map(blocked).sum::<f64>() * step;
        assert!((width / (2.0 * sharpness) - 1.0).abs() < 0.02, "{sharpness}: {width}");
    }
}

#[test]
fn directions_follow_the_strand() {
    let tangent = Vec3::new(0.3, -0.4, 0.5).normalize();
    let set = layers(&one(Vec3::new(0.2, 0.9, 0.0), Vec3::new(0.2, 0.9, 0.0) + tangent, 0.02, 0.8), &params(4, 32));
    for layer in set.unwrap().layers {
        for level in &layer.direction {
            for texel in level.chunks_exact(4) {
                let values = [texel[0], texel[1], texel[2], texel[3]].map(|b| f32::from(b) / 255.0);
                let back = pelage_formats::decode_direction(values, TextureFormat::Rgba8Unorm);
                // Texels in gaps between hairs get the direction of the hairs around them.
                assert!(back.distance(tangent) < 0.02, "{texel:?}");
            }
        }
    }
}

#[test]
fn layers_without_hair_are_isotropic_and_transparent() {
    let bare = Strands { offsets: vec![0], height: 0.1, ..Strands::default() };
    for layer in layers(&bare, &params(4, 16)).unwrap().layers {
        assert!(layer.direction.iter().all(|l| l.chunks_exact(4).all(|t| t == [128, 128, 128, 255])));
        assert!(layer.index == 0 || layer.color.iter().flatten().all(|b| *b == 0));
    }
}

#[test]
fn broken_strands_are_errors() {
    let good = one(Vec3::ZERO, Vec3::Z, 0.01, 1.0);
    let broken: [fn(&mut Strands); 6] = [
        |s| s.points[1].x = f32::NAN,
        |s| s.radii[0] = -1.0,
        |s| s.height = 0.0,
        |s| s.offsets = vec![0, 3],
        |s| s.offsets = vec![2, 0, 2],
        |s| s.colors.clear(),
    ];
    for (i, change) in broken.iter().enumerate() {
        let mut strands = good.clone();
        change(&mut strands);
        assert!(layers(&strands, &params(4, 16)).is_err(), "case {i}");
    }
    assert!(layers(&good, &params(3, 16)).is_err());
}

#[test]
fn wide_hair_on_a_small_tile_covers_it() {
    // The Gaussian is wider than the tile, so all its periodic copies add up.
    let set = layers(&one(Vec3::splat(0.0), Vec3::Z * 0.4, 0.25, 0.4), &params(4, 16)).unwrap();
    let column = |texel: usize| set.layers[1..].iter().map(|layer| u32::from(layer.color[0][4 * texel + 3])).sum();
    let alphas: Vec<u32> = (0..256).map(column).collect();
    assert!(alphas.iter().all(|a| *a > 0), "{alphas:?}");
}
