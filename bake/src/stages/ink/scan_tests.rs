use super::*;
use crate::stages::ink::noise::Octaves;
use glam::UVec2;

/// Makes a painting on silk that is darker to the right, with brush marks of several sizes.
fn painting(width: u32, height: u32) -> Image {
    let noise = Octaves::new(5, UVec2::splat(9), 4, 0.7);
    let texel = |i: u32| {
        let (x, y) = (i % width, i / width);
        let uv = Vec2::new(x as f32, y as f32) / width.max(height) as f32;
        let ink = (0.5 + 0.8 * noise.at(uv)).clamp(0.0, 1.0);
        let silk = 0.75 - 0.35 * x as f32 / width as f32;
        let grey = (255.0 * silk * (1.0 - 0.7 * ink)).round() as u8;
        [grey, grey, (0.85 * f32::from(grey)) as u8, 255]
    };
    Image { width, height, rgba: (0..width * height).flat_map(texel).collect() }
}

fn seam(plane: &Plane, columns: bool) -> f32 {
    let n = plane.side as i64;
    let at = |along: i64, across: i64| if columns { plane.at(across, along) } else { plane.at(along, across) };
    let step = |across: i64| (0..n).map(|i| (at(i, across + 1) - at(i, across)).abs()).sum::<f32>();
    step(n - 1) / ((0..n - 1).map(step).sum::<f32>() / (n - 1) as f32)
}

#[test]
fn scanned_painting_becomes_an_even_seamless_tile() {
    let plane = wash_tile("p.png", &painting(180, 140)).unwrap();
    assert_eq!(plane.side, 140);
    assert!(seam(&plane, true) < 1.35 && seam(&plane, false) < 1.35, "{} {}", seam(&plane, true), seam(&plane, false));
    assert!((plane.mean() - 0.5).abs() < 0.01 && plane.deviation() > 0.1);
    // The silk is twice as dark on the right as on the left before the background is removed.
    let part = |from: usize| {
        let columns = (0..140).flat_map(|y| (from..from + 35).map(move |x| (x, y)));
        columns.map(|(x, y)| plane.values[y * 140 + x]).sum::<f32>() / (35.0 * 140.0)
    };
    let parts = [part(0), part(35), part(70), part(105)];
    let [low, high] = [f32::min, f32::max].map(|pick| parts.iter().copied().reduce(pick).unwrap());
    assert!(high - low < 0.12, "{parts:?}");
}

#[test]
fn tiling_permutes_grey_values() {
    let grey = grey(&painting(90, 90), 90, 90);
    let plane = square(&grey);
    let tiled = tile(&plane, [true, true]);
    let sorted = |plane: &Plane| {
        let mut values = plane.values.clone();
        values.sort_unstable_by(f32::total_cmp);
        values
    };
    assert_eq!(sorted(&plane), sorted(&tiled));
    assert_ne!(plane, tiled);
}

#[test]
fn scanned_stroke_wraps_and_keeps_its_edges() {
    // The stroke is dark in the middle rows and pale at its lower edge, with paper above and below.
    let texel = |i: u32| {
        let (x, y) = (i % 120, i / 120);
        let grey = match y {
            20..=49 => 20 + (x % 7) as u8,
            50..=59 => 150,
            _ => 240,
        };
        [grey, grey, grey, 255]
    };
    let image = Image { width: 120, height: 90, rgba: (0..120 * 90).flat_map(texel).collect() };
    let band = stroke_band("s.png", &image).unwrap();
    let row = |v: f32| (0..120).map(|x| band.sample(Vec2::new((x as f32 + 0.5) / 120.0, v))).sum::<f32>() / 120.0;
    assert!(row(0.1) < 0.1 && row(0.6) < 0.1, "{} {}", row(0.1), row(0.6));
    assert!((row(0.9) - 0.6).abs() < 0.1, "{}", row(0.9));
    let wet =
        crate::stages::ink::stroke(&crate::recipe::InkParams { stroke_texels: 64, ..Default::default() }, Some(&band));
    assert!(wet[0].at(0, 32) < 0.2 && wet[0].at(32, 32) > 0.95, "{} {}", wet[0].at(0, 32), wet[0].at(32, 32));
}

#[test]
fn large_scans_are_reduced_to_the_largest_texture_size() {
    // A JPEG of a few kilobytes can declare such a width.
    let wide = painting(16_384, 48);
    let band = stroke_band("s.png", &wide).unwrap();
    assert_eq!(band.side, MOST_SIDE);
    assert_eq!(wash_tile("p.png", &wide).unwrap().side, 48);
    let large = wash_tile("p.png", &painting(2200, 2100)).unwrap();
    assert_eq!(large.side, MOST_SIDE);
    assert!((large.mean() - 0.5).abs() < 0.01 && large.deviation() > 0.1, "{} {}", large.mean(), large.deviation());
}

#[test]
fn background_of_large_and_small_scans_agrees() {
    // The large image is the small one with every texel enlarged to 3 × 3. The small image is used at its own size; the
    // large one is downsampled.
    let small = painting(200, 200);
    let texel = |i: usize| small.rgba[4 * ((i / 1800) * 200 + i % 600 / 3)..][..4].to_vec();
    let large = Image { width: 600, height: 600, rgba: (0..600 * 600).flat_map(texel).collect() };
    let level = |image: &Image, side: usize| remove_background(&square(&grey(image, side, side)));
    let (small, large) = (level(&small, 200), level(&large, 600));
    let error = |i: usize| (large.values[i] - small.values[(i / 1800) * 200 + i % 600 / 3]).abs();
    let (worst, sum) = (0..600 * 600).map(error).fold((0.0_f32, 0.0_f64), |(w, s), e| (w.max(e), s + f64::from(e)));
    assert!(worst < 0.05 && sum / 360_000.0 < 0.01, "{worst}, on average {}", sum / 360_000.0);
}

#[test]
fn mean_texels_at_full_size_are_the_texels() {
    let value = |x: usize, y: usize| (x + 10 * y) as f32;
    assert_eq!(mean_texels((3, 2), (3, 2), value), [0.0, 1.0, 2.0, 10.0, 11.0, 12.0]);
    assert_eq!(mean_texels((4, 2), (2, 1), value), [5.5, 7.5]);
    assert_eq!(mean_texels((3, 1), (2, 1), value), [0.0, 1.5]);
}

#[test]
fn scan_errors_name_the_image_and_its_size() {
    let small = painting(120, 30);
    let text = wash_tile("maps/p.png", &small).unwrap_err().to_string();
    assert!(["maps/p.png", "ink.wash_image", "120 x 30", "48 x 48"].iter().all(|part| text.contains(part)), "{text}");
    let flat = Image { width: 64, height: 64, rgba: [90, 90, 90, 255].repeat(64 * 64) };
    let text = stroke_band("s.png", &flat).unwrap_err().to_string();
    assert!(
        ["s.png", "ink.stroke_image", "0.353 to 0.353", "more contrast"].iter().all(|p| text.contains(p)),
        "{text}"
    );
    // A transparent image has no contrast either.
    let clear = Image { width: 64, height: 64, rgba: [0, 0, 0, 0].repeat(64 * 64) };
    assert!(wash_tile("c.png", &clear).is_err());
}

#[test]
fn normal_quantile_has_known_values() {
    for (rank, value) in [(0.5, 0.0), (0.841_345, 1.0), (0.158_655, -1.0), (0.977_25, 2.0), (0.001_35, -3.0)] {
        assert!((normal_quantile(rank) - value).abs() < 2e-3, "{rank}: {}", normal_quantile(rank));
    }
}
