use super::*;
use crate::recipe::{ColorParams, HairParams, natural};
use crate::stages::simulate::{VolumeParams, simulate};

const FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;

fn slice(tile_texels: u32) -> SliceParams {
    SliceParams { tile_texels, ..SliceParams::default() }
}

fn coat() -> Strands {
    simulate(&natural().hair, &ColorParams::default(), &VolumeParams::default()).unwrap()
}

/// Makes one hair of radius 0.02 from `root` to `tip`.
fn hair(root: Vec3, tip: Vec3) -> Strands {
    let middle = 0.5 * (root + tip);
    Strands {
        points: vec![root, middle, tip],
        radii: vec![0.02; 3],
        colors: vec![Vec3::splat(0.5); 3],
        offsets: vec![0, 3],
        height: 0.5,
        root_color: Vec3::ZERO,
    }
}

/// Draws the slab with the given index and depth. Returns the mip levels of its colour and of its direction: width,
/// height and RGBA of each level.
fn slab(strands: &Strands, index: usize, depth: f32) -> (Levels, Levels) {
    let params = slice(32);
    let size = size(strands, &params);
    levels(draw(strands, FIN_SLICES[index], depth, size, params.filter_width), size, FORMAT)
}

fn alpha(level: &(u32, u32, Vec<u8>)) -> Vec<f32> {
    level.2.chunks_exact(4).map(|t| f32::from(t[3]) / 255.0).collect()
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / values.len() as f32
}

/// Returns the column of a level with the highest opacity, as a fraction of the level's width.
fn column(level: &(u32, u32, Vec<u8>)) -> f32 {
    let (width, alpha) = (level.0 as usize, alpha(level));
    let sum = |x: usize| alpha.iter().skip(x).step_by(width).sum::<f32>();
    let best = (0..width).max_by(|a, b| sum(*a).total_cmp(&sum(*b))).unwrap();
    (best as f32 + 0.5) / width as f32
}

#[test]
fn edges_select_the_most_parallel_fin_slice() {
    for (direction, expected) in [
        (Vec2::new(1.0, 0.1), (0, false)),
        (Vec2::new(-3.0, 0.1), (0, true)),
        (Vec2::new(0.2, 0.2), (1, false)),
        (Vec2::new(-2.0, -1.9), (1, true)),
        (Vec2::new(0.1, 5.0), (2, false)),
        (Vec2::new(0.1, -5.0), (2, true)),
        (Vec2::new(-1.0, 1.0), (3, false)),
        (Vec2::new(1.0, -1.0), (3, true)),
        (Vec2::ZERO, (0, false)),
    ] {
        assert_eq!(fin_slice_along(direction), expected, "{direction}");
    }
    for slab in FIN_SLICES {
        let ([p, q], [m, n]) = (slab.step.map(i32::from), slab.neighbour.map(i32::from));
        assert_eq!(p * n - q * m, 1, "{slab:?}: its neighbour is not one period away");
    }
}

#[test]
fn hair_in_a_slab_is_drawn_at_its_root() {
    // An upright hair at u = 0.3, v = 0.1.
    let strands = hair(Vec3::new(0.3, 0.1, 0.0), Vec3::new(0.3, 0.1, 0.5));
    // Along (1, 1), the hair's position across the slab is 0.1 − 0.3, which is negative. So its copy in the tile above
    // is drawn, at (0.3 + 1.1) / 2. Along (−1, 1), the position across is −0.1 − 0.3, so the copy in the tile below is
    // drawn. Its position, (−0.3 − 0.9) / 2, wraps to 0.4.
    for (index, expected) in [(0, 0.3), (1, 0.7), (2, 0.1), (3, 0.4)] {
        let found = column(&slab(&strands, index, 1.0).0[0]);
        assert!((found - expected).abs() < 0.02, "slab {index}: {found}, expected {expected}");
    }
}

#[test]
fn slabs_wrap_at_tile_borders() {
    let strands = coat();
    let mut moved = strands.clone();
    // The strands are shifted by whole tiles, so the hair is the same.
    moved.points.iter_mut().for_each(|p| *p += Vec3::new(3.0, -2.0, 0.0));
    for index in 0..FIN_SLICES.len() {
        let (a, b) = (slab(&strands, index, 0.3), slab(&moved, index, 0.3));
        let differing = |a: &[u8], b: &[u8]| a.iter().zip(b).filter(|(a, b)| a.abs_diff(**b) > 2).count();
        // Rounding can move a root across the face of the slab, so that the whole hair appears or disappears.
        let share = differing(&a.0[0].2, &b.0[0].2) as f32 / a.0[0].2.len() as f32;
        assert!(share < 0.02, "slab {index}: {share} of the texels differ");
    }
}

#[test]
fn lean_is_visible_in_the_parallel_slab() {
    // The hair leans towards +v.
    let strands = hair(Vec3::new(0.5, 0.2, 0.0), Vec3::new(0.5, 0.5, 0.5));
    let rows = |index: usize| {
        let level = &slab(&strands, index, 1.0).0[0];
        let (width, alpha) = (level.0 as usize, alpha(level));
        let center = |row: &[f32]| {
            let sum: f32 = row.iter().sum();
            row.iter().enumerate().map(|(x, a)| (x as f32 + 0.5) * a).sum::<f32>() / sum / width as f32
        };
        let rows: Vec<_> = alpha.chunks_exact(width).map(center).collect();
        rows[rows.len() * 3 / 4] - rows[rows.len() / 4]
    };
    assert!(rows(0).abs() < 0.01, "across its lean the hair stands upright, not {}", rows(0));
    assert!((rows(2) - 0.15).abs() < 0.02, "half of its lean of 0.3 between the quarters, not {}", rows(2));
    assert!(rows(1) > 0.05 && rows(1) < rows(2), "at 45 degrees less of it, not {}", rows(1));
    // Directions are in the tile frame for all slabs.
    for index in 0..FIN_SLICES.len() {
        let (color, direction) = slab(&strands, index, 1.0);
        let (at, _) = alpha(&color[0]).iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).unwrap();
        let texel: [u8; 4] = direction[0].2[4 * at..4 * at + 4].try_into().unwrap();
        let found = pelage_formats::decode_direction(texel.map(|b| f32::from(b) / 255.0), FORMAT);
        let expected = Vec3::new(0.0, 0.3, 0.5).normalize();
        assert!(found.dot(expected) > 0.99, "slab {index}: {found}");
    }
}

#[test]
fn mips_keep_the_covered_share() {
    let strands = coat();
    for index in 0..FIN_SLICES.len() {
        let (color, direction) = slab(&strands, index, 0.05);
        let shares: Vec<_> = color.iter().map(|level| mean(&alpha(level))).collect();
        assert!(shares[0] > 0.02, "there is hair: {shares:?}");
        // Tolerance for the covered shares: 2 %, plus the rounding of a byte.
        assert!(shares.iter().all(|s| (s - shares[0]).abs() < 0.02 * shares[0] + 0.5 / 255.0), "{shares:?}");
        let sizes: Vec<_> = color.iter().map(|l| (l.0, l.1)).collect();
        assert_eq!(sizes.last(), Some(&(1, 1)));
        assert_eq!(direction.iter().map(|l| (l.0, l.1)).collect::<Vec<_>>(), sizes);
        for (width, height, texels) in color.iter().chain(&direction) {
            assert_eq!(texels.len(), (width * height * 4) as usize);
        }
    }
}

/// Checks that the covered share does not depend on the resolution. The opacity of a mean density would depend on it.
#[test]
fn coverage_does_not_depend_on_resolution() {
    let strands = coat();
    let share = |texels: u32| {
        let params = slice(texels);
        let size = size(&strands, &params);
        let sums = draw(&strands, FIN_SLICES[0], 0.05, size, params.filter_width);
        sums.iter().map(|s| s[0]).sum::<f32>() / sums.len() as f32
    };
    let [coarse, fine] = [16, 128].map(share);
    assert!((coarse / fine - 1.0).abs() < 0.2, "{coarse} at 16 texels, {fine} at 128");
}

#[test]
fn a_deeper_slab_has_more_hair() {
    let strands = coat();
    let share = |depth: f32| mean(&alpha(&slab(&strands, 0, depth).0[0]));
    let shares = [0.01, 0.02, 0.1, 1.0, 3.0].map(share);
    assert!(shares.windows(2).all(|w| w[0] < w[1]), "{shares:?}");
    // In thin slabs, the covered share is proportional to the depth, because hairs do not overlap yet.
    assert!((shares[1] / shares[0] - 2.0).abs() < 0.5, "{shares:?}");
}

#[test]
fn slab_opacity_falls_to_zero_at_the_tips() {
    // All hair is as high as the volume.
    let strands = simulate(
        &HairParams { length_variation: 0.0, lean: 0.0, frizz: 0.0, ..natural().hair },
        &ColorParams::default(),
        &VolumeParams::default(),
    )
    .unwrap();
    let level = &slab(&strands, 0, 0.05).0[0];
    let rows: Vec<_> = alpha(level).chunks_exact(level.0 as usize).map(mean).collect();
    assert!(rows[1] > 0.1 && rows[rows.len() - 1] < 0.1 * rows[1], "{rows:?}");
    // The first row lacks the part of a hair's blur that extends below the surface.
    assert!(rows[1..].windows(2).all(|w| w[1] <= w[0] + 0.02), "{rows:?}");
}

#[test]
fn fin_textures_follow_the_height_and_check_the_depth() {
    let fins = fin_textures(&coat(), 0.05, &slice(64), &PackParams::default()).unwrap();
    assert_eq!((fins.width, fins.height), (128, 64), "a volume 0.4 tiles high");
    let error = fin_textures(&coat(), 0.0, &slice(64), &PackParams::default()).unwrap_err().to_string();
    assert!(error.contains("fins.depth") && error.contains("0.001..=8"), "{error}");
}
