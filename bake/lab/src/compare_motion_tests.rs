#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
use super::*;
use glam::{DVec3, Vec3, Vec4};
use pelage_bake::strands::{PosedMaterial, PosedMesh, PosedVertex};
use pelage_truth::Lens;

const SIZE: (u32, u32) = (60, 40);

/// Returns squares two metres wide, one at each position.
fn squares(places: &[DVec3]) -> SurfaceVisibility {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let mut skin = PosedMesh {
        materials: vec![PosedMaterial { base_color: Vec4::ONE, ..PosedMaterial::default() }],
        ..PosedMesh::default()
    };
    for place in places {
        let base = skin.vertices.len() as u32;
        skin.vertices.extend(corners.map(|(x, y)| PosedVertex {
            position_ws: *place + DVec3::new(x, y, 0.0),
            normal_ws: DVec3::Z,
            color: Vec4::ONE,
            ..PosedVertex::default()
        }));
        skin.triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
    }
    skin.same_place = (0..skin.vertices.len() as u32).collect();
    skin.material_of = vec![0; skin.triangles.len()];
    SurfaceVisibility::new(skin).unwrap()
}

/// Returns a camera whose picture is four metres high; a pixel is a tenth of a metre.
fn camera() -> TrueCamera {
    let lens = Lens::Orthographic { height_m: 4.0 };
    TrueCamera { eye_ws: Vec3::new(0.0, 0.0, 5.0), target_ws: Vec3::ZERO, up_ws: Vec3::Y, lens }
}

/// Returns a wave of grey at a position in the picture, metres. Wavelengths are 3.5 m horizontally and 4.5 m
/// vertically.
fn wave(x: f64, y: f64) -> f64 {
    0.5 + 0.25 * (1.8 * x).sin() + 0.25 * (1.4 * y + 0.5).cos()
}

/// Returns a picture of the square at `place` on a background of grey 0.2. The square is textured with the wave, which
/// is shifted by `slip`.
fn picture(place: DVec3, slip: DVec3) -> Vec<f32> {
    let pixel = |i: u32| {
        let (x, y) = (f64::from(i % SIZE.0) + 0.5, f64::from(i / SIZE.0) + 0.5);
        let (x, y) = ((x - 30.0) / 10.0 - place.x, (20.0 - y) / 10.0 - place.y);
        let inside = x.abs() < 1.0 && y.abs() < 1.0;
        if inside { wave(x + slip.x, y + slip.y) as f32 } else { 0.2 }
    };
    (0..SIZE.0 * SIZE.1).map(pixel).collect()
}

fn measure(now: (&SurfaceVisibility, &[f32]), next: (&SurfaceVisibility, &[f32]), lines: &Mask) -> Flicker {
    let camera = camera();
    let moment = |(sight, grey)| FlickerFrame { sight, camera: &camera, grey, lines };
    flicker(&moment(now), &moment(next), SIZE).unwrap()
}

#[test]
fn static_scene_does_not_flicker() {
    let sight = squares(&[DVec3::ZERO]);
    let grey = picture(DVec3::ZERO, DVec3::ZERO);
    let found = measure((&sight, &grey), (&sight, &grey), &Mask::from_fn(60, 40, |x, _| x < 30));
    assert!(found.surface.mean().unwrap() < 1e-6 && found.lines.mean().unwrap() < 1e-6, "{found:?}");
    assert_eq!(found.background.mean(), Some(0.0));
    assert_eq!((found.surface.count, found.background.count), (400, 2000));
    // Lookups beside the border of the mask touch both lines and wash, so these pixels count as neither.
    assert!((180..=200).contains(&found.lines.count) && (180..=200).contains(&found.wash.count), "{found:?}");
    assert_eq!(found.wash.mean().map(|mean| mean < 1e-6), Some(true));
    assert_eq!(Flicker::default().surface.mean(), None);
    let twice = found.joined(found);
    assert_eq!((twice.surface.count, twice.surface.mean()), (800, found.surface.mean()));
}

#[test]
fn surface_textures_do_not_flicker_and_screen_textures_do() {
    let (here, there) = (DVec3::ZERO, DVec3::new(0.33, 0.27, -0.5));
    let (now, next) = (squares(&[here]), squares(&[there]));
    let lines = Mask::from_fn(60, 40, |x, y| (22..38).contains(&x) && (12..28).contains(&y));
    let grey = picture(here, DVec3::ZERO);
    let glued = measure((&now, &grey), (&next, &picture(there, DVec3::ZERO)), &lines);
    // Here, the wave is fixed to the screen, so it slides over the square as the square moves.
    let screen = measure((&now, &grey), (&next, &picture(there, there)), &lines);
    for (glued, screen, share) in [(glued.surface, screen.surface, 0.3), (glued.lines, screen.lines, 0.03)] {
        let (glued, screen) = (glued.mean().unwrap(), screen.mean().unwrap());
        assert!(screen > 0.05 && glued < share * screen, "flicker {glued} on the surface, {screen} on the screen");
    }
    // Pixels at the square's border mix with the background; elsewhere, only the error of bilinear interpolation
    // remains.
    assert!(glued.lines.mean().unwrap() < 0.002, "{glued:?}");
    assert_eq!(glued.surface.count, 400);
    // The mask of lines is the same in both frames, while the square moves by three pixels. Only pixels that are lines
    // in both frames count.
    assert!((150..256).contains(&glued.lines.count), "{glued:?}");
}

#[test]
fn only_surfaces_visible_in_both_frames_count() {
    // A second square moves in front of the left half of the first.
    let (now, next) = (squares(&[DVec3::ZERO, DVec3::Z * 9.0]), squares(&[DVec3::ZERO, DVec3::new(-1.0, 0.0, 1.0)]));
    let grey = picture(DVec3::ZERO, DVec3::ZERO);
    let mut changed = grey.clone();
    for (i, grey) in changed.iter_mut().enumerate() {
        if i % 60 < 30 {
            *grey = 1.0 - *grey;
        }
    }
    let found = measure((&now, &grey), (&next, &changed), &Mask::empty(60, 40));
    assert_eq!(found.surface.count, 200, "{found:?}");
    // Only one column of the visible half, the one beside the occluding square, can mix with it.
    assert!(found.surface.mean().unwrap() < 0.05, "{found:?}");
    assert_eq!(found.lines.mean(), None);
    // A square that leaves the picture is not measured.
    let gone = measure((&now, &grey), (&squares(&[DVec3::X * 9.0, DVec3::X * 9.0]), &grey), &Mask::empty(60, 40));
    assert_eq!(gone.surface.count, 0);
}

#[test]
fn mismatched_frames_are_refused() {
    let (one, two) = (squares(&[DVec3::ZERO]), squares(&[DVec3::ZERO, DVec3::X]));
    let (camera, grey) = (camera(), picture(DVec3::ZERO, DVec3::ZERO));
    let (lines, turned) = (Mask::empty(60, 40), Mask::empty(40, 60));
    let moment = |sight, grey, lines| FlickerFrame { sight, camera: &camera, grey, lines };
    let refused = |next: &FlickerFrame<'_>, words: &str| {
        let error = flicker(&moment(&one, &grey[..], &lines), next, SIZE).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    refused(&moment(&two, &grey[..], &lines), "4 triangles, expected 2");
    refused(&moment(&one, &grey[..7], &lines), "7 greys, expected 60x40");
    refused(&moment(&one, &grey[..], &turned), "40x60, expected 60x40");
}
