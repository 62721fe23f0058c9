use super::*;

fn boxes(sizes: &[[f32; 2]]) -> Vec<(Vec2, Vec2)> {
    sizes.iter().map(|s| (Vec2::splat(-3.0), Vec2::splat(-3.0) + Vec2::from(*s))).collect()
}

#[test]
fn packed_boxes_are_disjoint_inside_and_dense() {
    let many: Vec<_> =
        (0..150).map(|i| [0.2 + (i * 37 % 100) as f32 / 60.0, 0.1 + (i * 61 % 100) as f32 / 90.0]).collect();
    for (sizes, side) in [(&many[..], 1024), (&many[..7], 256), (&[[5.0, 0.01]], 64), (&[[0.0, 0.0]; 30], 128)] {
        let boxes = boxes(sizes);
        let (scale, gutter, places) = pack(&boxes, side, GutterKind::Room).unwrap();
        let rectangle = |i: usize| {
            let size = sizes[i].map(|x| (x * scale).ceil() as u32 + 1 + 2 * gutter);
            let (width, height) = if places[i].turned { (size[1], size[0]) } else { (size[0], size[1]) };
            let (x, y) = places[i].at;
            (x, y, x + width, y + height)
        };
        let mut used = 0;
        for i in 0..sizes.len() {
            let (x0, y0, x1, y1) = rectangle(i);
            assert!(x1 <= side && y1 <= side, "{i} of {side}: {:?}", rectangle(i));
            used += (x1 - x0) * (y1 - y0);
            for j in 0..i {
                let (u0, v0, u1, v1) = rectangle(j);
                assert!(x1 <= u0 || u1 <= x0 || y1 <= v0 || v1 <= y0, "{i} lies on {j}");
            }
        }
        assert!(sizes.len() < 100 || f64::from(used) > 0.6 * f64::from(side * side), "{used} texels of {side}²");
    }
}

#[test]
fn gutters_shrink_before_a_texture_is_too_small() {
    let boxes = boxes(&[[1.0, 1.0]; 100]);
    let gutter = |side| pack(&boxes, side, GutterKind::Room).map(|(_, gutter, _)| gutter);
    assert_eq!([gutter(1024), gutter(128), gutter(44), gutter(16)], [Some(8), Some(4), Some(1), None]);
}

#[test]
fn charts_with_room_for_roots_are_not_rotated() {
    let sizes = [[0.5, 2.0], [2.0, 0.5], [1.0, 1.0]];
    let around = GutterKind::Reach { tiles: 0.25, most_texels: 48.0 };
    for (side, enough) in [(512, true), (64, false)] {
        let (scale, gutter, places) = pack(&boxes(&sizes), side, around).unwrap();
        assert_eq!(scale == 48.0, enough, "{side}: {scale}");
        assert!(gutter as f32 >= 0.25 * scale + 4.0 && places.iter().all(|place| !place.turned), "{side}: {gutter}");
        for (size, place) in sizes.iter().zip(&places) {
            let end = |at: u32, size: f32| at as f32 + size * scale + 2.0 * gutter as f32;
            assert!(end(place.at.0, size[0]).max(end(place.at.1, size[1])) <= side as f32, "{side}: {place:?}");
        }
    }
    // So many charts have no room for their gutters at any scale.
    assert!(pack(&boxes(&[[1.0, 1.0]; 100]), 16, around).is_none());
}
