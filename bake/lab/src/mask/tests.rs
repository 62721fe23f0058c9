use super::*;

/// Builds the set of the `#` characters.
fn mask_of(rows: &[&str]) -> Mask {
    let cells: Vec<Vec<char>> = rows.iter().map(|row| row.chars().collect()).collect();
    Mask::from_fn(cells[0].len() as u32, cells.len() as u32, |x, y| cells[y as usize][x as usize] == '#')
}

fn disc(size: u32, x0: f64, y0: f64, radius: f64) -> Mask {
    Mask::from_fn(size, size, |x, y| (f64::from(x) + 0.5 - x0).hypot(f64::from(y) + 0.5 - y0) < radius)
}

#[test]
fn widest_stroke_has_the_drawn_width() {
    for n in 1..=9u32 {
        let upright = Mask::from_fn(40, 30, |x, _| (7..7 + n).contains(&x)).widest_stroke();
        let lying = Mask::from_fn(30, 40, |_, y| (7..7 + n).contains(&y)).widest_stroke();
        assert_eq!((upright.width_px, lying.width_px), (f64::from(n), f64::from(n)));
        assert_eq!((upright.at_px[0], lying.at_px[1]), (7.0 + f64::from(n) / 2.0, 7.0 + f64::from(n) / 2.0));
    }
    // A slanted line, 6 pixels wide. The steps of its edges add less than a pixel to the measured width.
    let slanted = Mask::from_fn(80, 80, |x, y| ((f64::from(x) - f64::from(y)) / 2f64.sqrt()).abs() <= 3.0);
    assert!((slanted.widest_stroke().width_px - 6.0).abs() < 1.0, "{:?}", slanted.widest_stroke());
    // The set is a thin line with a blot on it.
    let mut blot = disc(64, 40.0, 20.0, 7.0);
    (0..64).for_each(|i| blot.insert(i, 20));
    let found = blot.widest_stroke();
    // A pixel belongs to the disc if its centre does. So the radius of the largest disc that fits is smaller by up to
    // half the diagonal of a pixel.
    assert!((12.0..=14.0).contains(&found.width_px), "{found:?}");
    assert!((found.at_px[0] - 40.0).abs() <= 1.0 && (found.at_px[1] - 20.0).abs() <= 1.0, "{found:?}");
}

#[test]
fn pixels_outside_the_picture_count_as_unset() {
    assert_eq!(Mask::empty(5, 4).widest_stroke(), Stroke::default());
    assert_eq!(Mask::empty(0, 0).widest_stroke(), Stroke::default());
    assert_eq!(Mask::from_fn(8, 6, |_, _| true).widest_stroke().width_px, 6.0);
    assert_eq!(Mask::from_fn(8, 8, |x, _| x < 2).widest_stroke().width_px, 2.0);
}

#[test]
fn core_of_a_line_runs_along_its_middle() {
    for n in [1u32, 3, 5, 7] {
        let core = Mask::from_fn(60, 31, |x, y| (4..56).contains(&x) && y.abs_diff(15) <= n / 2).core();
        for x in 12..48 {
            let rows: Vec<u32> = (0..31).filter(|y| core.contains(x, i64::from(*y))).collect();
            assert_eq!(rows, [15], "a line {n} wide at {x}");
        }
    }
    // A ring stays closed, so that its inside stays separate from its outside.
    let ring = Mask::from_fn(64, 64, |x, y| {
        let r = (f64::from(x) - 31.5).hypot(f64::from(y) - 31.5);
        (20.0..25.0).contains(&r)
    });
    let core = ring.core();
    let off: Vec<f64> = (0..core.pixels.len())
        .filter(|i| core.pixels[*i])
        .map(|i| ((i % 64) as f64 - 31.5).hypot((i / 64) as f64 - 31.5) - 22.0)
        .collect();
    let worst = off.iter().fold(0.0f64, |most, d| most.max(d.abs()));
    let mean = off.iter().map(|d| d.abs()).sum::<f64>() / off.len() as f64;
    assert!(worst < 2.0 && mean < 0.7, "{mean} pixels beside the middle, {worst} at most");
    // A circle of radius 22 has at least 124 pixels (connected by edges or corners) and at most 184 (by edges only).
    assert!((124..=184).contains(&off.len()), "{} pixels", off.len());
    let mut reached = vec![(31i64, 31i64)];
    let mut seen = Mask::empty(64, 64);
    while let Some((x, y)) = reached.pop() {
        assert!((1..63).contains(&x) && (1..63).contains(&y), "the ring is open");
        if !seen.contains(x, y) && !core.contains(x, y) {
            seen.insert(x, y);
            reached.extend([(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)]);
        }
    }
}

#[test]
fn core_keeps_thin_lines_and_dots() {
    let thin = mask_of(&["........", ".#....#.", "..#.....", "...#....", "....###.", "........"]);
    assert_eq!(thin.core(), thin);
    for size in 1..=6u32 {
        let block = Mask::from_fn(10, 10, |x, y| (2..2 + size).contains(&x) && (2..2 + size).contains(&y));
        let core = block.core();
        assert!((1..=size as usize).contains(&core.count()), "a block of {size}: {core:?}");
        assert!((0..100).all(|i| !core.pixels[i] || block.pixels[i]));
    }
}

#[test]
fn masks_of_different_sizes_cannot_be_united() {
    let (a, b) = (Mask::empty(3, 4), Mask::empty(4, 3));
    let error = a.union(&b).unwrap_err().to_string();
    assert!(error.contains("3x4 and 4x3"), "{error}");
    let both = mask_of(&["#..", "..."]).union(&mask_of(&["..#", "#.."])).unwrap();
    assert_eq!(both, mask_of(&["#.#", "#.."]));
}

#[test]
fn dark_pixels_have_all_components_dark() {
    let mut picture = image::RgbaImage::from_pixel(3, 2, image::Rgba([255; 4]));
    picture.put_pixel(1, 0, image::Rgba([20, 20, 20, 255]));
    picture.put_pixel(2, 1, image::Rgba([0, 0, 200, 255]));
    picture.put_pixel(0, 1, image::Rgba([127, 127, 127, 0]));
    assert_eq!(Mask::darker(&picture, 128), mask_of(&[".#.", "#.."]));
    assert_eq!(Mask::darker(&picture, 0).count(), 0);
}
