use super::*;
use crate::recipe::{ColorParams, HairParams, SliceParams, natural};
use crate::stages::fixtures::on_threads;
use crate::stages::simulate::{VolumeParams, simulate};
use crate::stages::slice::slice_for_package;
use pelage_formats::TextureFormat;
use pelage_formats::meaning::visibility_towards;

fn grown(density: u32) -> Strands {
    let hair = HairParams { density, ..natural().hair };
    simulate(&hair, &ColorParams::default(), &VolumeParams { height: 0.3 }).unwrap()
}

/// Compares the visibility texture with single rays from points of the strands, in directions other than those it was
/// made from. Returns the mean and the root mean square of the difference. Only lights with an elevation from `least_z`
/// (inclusive) to `most_z` (exclusive) count.
fn against_rays(strands: &Strands, found: &Visibility, [least_z, most_z]: [f32; 2]) -> [f64; 2] {
    let params = SliceParams { layers: 12, tile_texels: 64, ..SliceParams::default() };
    let mut layers = vec![Vec::new(); 12];
    slice_for_package(strands, Some(found), &params, TextureFormat::Rgba8Unorm, false, |layer| {
        layers[layer.index as usize] = layer.visibility[0].clone();
        Ok(())
    })
    .unwrap();
    let rays = StrandTree::new(strands);
    let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
    for strand in 0..strands.len() {
        for i in strands.range(strand) {
            let p = strands.points[i];
            let draw = |what: u64| uniform(hash(0x7261_7973, what), i as u64);
            let (z, turn) = (least_z + (most_z - least_z) * draw(0), std::f32::consts::TAU * draw(1));
            let side = (1.0 - z * z).sqrt();
            let way = Vec3::new(side * libm::cosf(turn), side * libm::sinf(turn), z);
            let layer = ((p.z / strands.height * 11.0).round() as usize).clamp(1, 11);
            let at = |x: f32| (x.rem_euclid(1.0) * 64.0) as usize % 64;
            let bytes = &layers[layer][4 * (64 * at(p.y) + at(p.x))..][..4];
            let texel = Vec4::from_array(std::array::from_fn(|k| f32::from(bytes[k]) / 255.0));
            let seen = f64::from(u8::from(rays.is_lit(p, way, Some(strand as u32))));
            let error = f64::from(visibility_towards(texel, way, found.horizon)) - seen;
            (sum, squares, count) = (sum + error, squares + error * error, count + 1.0);
        }
    }
    [sum / count, (squares / count).sqrt()]
}

#[test]
fn visibility_texture_agrees_with_single_rays() {
    for density in [150, 400, 700, 1000] {
        let strands = grown(density);
        let found = visibility(&strands, &VisibilityParams::default(), None).unwrap();
        let all = against_rays(&strands, &found, [0.04, 1.0]);
        println!("{density} strands: horizon {}, bias {:.4}, rms {:.3}", found.horizon, all[0], all[1]);
        // A ray gives 0 or 1, and a texel gives the visible share. So the root mean square of their difference is that
        // of random noise. With few strands, the mean differs more: nearly all light passes, and fitted values above 1
        // are clamped.
        let most = if density < 500 { 0.05 } else { 0.01 };
        assert!(all[0].abs() < most && all[1] < 0.45, "{density} strands: {all:?}");
        for band in [[0.04, 0.25], [0.25, 0.6], [0.6, 1.0]] {
            let found = against_rays(&strands, &found, band);
            println!("  light at z {band:?}: bias {:.4}", found[0]);
            assert!(found[0].abs() < 0.05, "{density} strands, {band:?}: {found:?}");
        }
    }
}

#[test]
fn tips_are_lit_and_roots_are_shadowed() {
    let strands = grown(700);
    let found = visibility(&strands, &VisibilityParams::default(), None).unwrap();
    let mean = |low: f32, high: f32| {
        let of = |(p, c): (&Vec3, &Vec4)| {
            let share = p.z / strands.height;
            (low..high).contains(&share).then(|| c.x + c.w)
        };
        let seen: Vec<f32> = strands.points.iter().zip(&found.points).filter_map(of).collect();
        seen.iter().sum::<f32>() / seen.len() as f32
    };
    let (roots, tips) = (mean(0.0, 0.2), mean(0.8, 1.1));
    assert!(roots < 0.7 && tips > 0.85 && tips > roots + 0.25, "{roots} at the roots, {tips} at the tips");
    let skin = found.skin.iter().map(|c| c.x + c.w).sum::<f32>() / found.skin.len() as f32;
    assert!((skin - roots).abs() < 0.25, "{skin} on the skin, {roots} at the roots");
}

#[test]
fn tile_without_strands_is_lit_on_any_number_of_threads() {
    let make = || visibility(&grown(60), &VisibilityParams::default(), None).unwrap();
    assert_eq!(on_threads(1, make), on_threads(3, make));
    let bare = Strands { height: 0.1, offsets: vec![0], ..Strands::default() };
    let found = visibility(&bare, &VisibilityParams::default(), None).unwrap();
    assert!(found.skin.iter().all(|c| (c.x - 1.0).abs() < 1e-2 && c.truncate().length() < 1.1), "{:?}", found.skin[0]);
    let levels = found.skin_levels(16);
    assert_eq!(levels.iter().map(Vec::len).collect::<Vec<_>>(), [1024, 256, 64, 16, 4]);
    assert_eq!(found.skin_levels(128)[0].len(), 4 * 128 * 128);
}
