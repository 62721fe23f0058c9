use super::*;
use crate::{Lens, TrueLight};
use glam::{Vec3, Vec4};
use pelage_bake::strands::{CurvePoint, PosedMaterial, PosedVertex};

/// Adds a straight strand of constant radius whose surface normal faces the eye.
fn strand(curves: &mut Curves, from: Vec3, to: Vec3, radius_m: f32) {
    let point = |position_ws, height| CurvePoint {
        position_ws,
        radius_m,
        height,
        color: Vec3::new(0.5, 0.25, 0.125),
        normal_ws: Vec3::Z,
    };
    curves.push(&[point(from, 0.5), point(to, 0.5)], false, glam::Vec2::ZERO);
}

fn scene(curves: Curves) -> TrueScene {
    TrueScene::new(curves, PosedMesh::default(), None, Shading::default()).unwrap()
}

/// Returns a strand that rises to the right.
fn rising_strand() -> TrueScene {
    let mut curves = Curves::default();
    strand(&mut curves, Vec3::new(-0.6, -0.3, 0.0), Vec3::new(0.5, 0.4, 0.0), 0.05);
    scene(curves)
}

/// Returns a camera that views two metres of the plane z = 0 from the front.
fn camera() -> TrueCamera {
    TrueCamera {
        eye_ws: Vec3::new(0.0, 0.0, 5.0),
        target_ws: Vec3::ZERO,
        up_ws: Vec3::Y,
        lens: Lens::Orthographic { height_m: 2.0 },
    }
}

fn lighting() -> TrueLighting {
    TrueLighting::of(TrueLight::Directional { towards_light_ws: Vec3::Z, color: Vec3::ONE })
}

fn trace(scene: &TrueScene, lighting: &TrueLighting, size: u32, spp: u32) -> TracedPicture {
    scene.picture(&camera(), lighting, (size, size), spp, &mut |_, _| ())
}

/// Returns the covered area of a picture of 2 m by 2 m, square metres.
fn covered(picture: &TracedPicture) -> f64 {
    let mean = picture.pixels.iter().map(|p| f64::from(p[3])).sum::<f64>() / picture.pixels.len() as f64;
    4.0 * mean
}

#[test]
fn strand_coverage_equals_its_projected_area() {
    for (from, to, radius) in [
        (Vec3::new(-0.6, -0.3, 0.0), Vec3::new(0.5, 0.4, 0.0), 0.01f32),
        (Vec3::new(-0.6, -0.3, 0.5), Vec3::new(0.5, 0.4, -0.5), 0.003),
        // A strand that points at the eye, seen as a disc.
        (Vec3::new(0.1, 0.2, -0.5), Vec3::new(0.1, 0.2, 0.5), 0.1),
    ] {
        let mut curves = Curves::default();
        strand(&mut curves, from, to, radius);
        let picture = trace(&scene(curves), &lighting(), 128, 64);
        let (r, length) = (f64::from(radius), f64::from((to - from).truncate().length()));
        let truth = 2.0 * r * length + std::f64::consts::PI * r * r;
        let found = covered(&picture);
        assert!((found / truth - 1.0).abs() < 0.01, "{from} to {to}: {found} m², expected {truth}");
        assert_eq!(picture.rays.primary, 128 * 128 * 64);
    }
}

/// Checks that random opaque strands transmit exp(−τ). τ is the sum of the strands' projected areas divided by the
/// whole area.
#[test]
fn random_strands_transmit_exponentially() {
    for tau in [0.3, 1.0, 2.0] {
        let (radius, length) = (0.004f32, 0.2f32);
        let mut curves = Curves::default();
        let mut covered_by_each = 0.0;
        // Strands begin at random points of a box larger than the view, so that its middle is filled uniformly.
        let (side, mut seed) = (2.6f64, 0u64);
        while covered_by_each < tau * side * side {
            let mut draw = || {
                seed += 1;
                2.0 * uniform(7, seed) - 1.0
            };
            let middle = Vec3::new(1.3 * draw(), 1.3 * draw(), draw());
            let way = Vec3::new(draw(), draw(), draw()).normalize() * (0.5 * length);
            strand(&mut curves, middle - way, middle + way, radius);
            let (r, flat) = (f64::from(radius), 2.0 * f64::from(way.truncate().length()));
            covered_by_each += 2.0 * r * flat + std::f64::consts::PI * r * r;
        }
        let found = 1.0 - covered(&trace(&scene(curves), &lighting(), 128, 16)) / 4.0;
        let truth = f64::exp(-tau);
        assert!((found - truth).abs() < 0.012, "τ {tau}: transmittance {found}, expected {truth}");
    }
}

/// Checks equation (3) against calculation by hand in simple cases.
#[test]
fn strand_lighting_matches_the_shading_equation() {
    let mut curves = Curves::default();
    strand(&mut curves, Vec3::new(-3.0, 0.0, 0.0), Vec3::new(3.0, 0.0, 0.0), 2.0);
    let k = Shading::default();
    let at_center = |curves: &Curves, lighting: &TrueLighting| {
        // The view is so small that the light direction is the same everywhere in it.
        let camera = TrueCamera { lens: Lens::Orthographic { height_m: 1e-4 }, ..camera() };
        let picture = scene(curves.clone()).picture(&camera, lighting, (1, 1), 4, &mut |_, _| ());
        Vec3::from_slice(&picture.pixels[0][..3])
    };
    let color = Vec3::new(0.5, 0.25, 0.125);
    let gamma = k.ambient_floor + (1.0 - k.ambient_floor) * 0.5;
    let (ambient, full) = (0.35 * gamma * color, 1.2 * color + 0.18);
    let near = |found: Vec3, expected: Vec3| assert!(found.distance(expected) < 1e-5, "{found}, expected {expected}");
    // The light is behind the eye: T is perpendicular to L and to H.
    near(at_center(&curves, &lighting()), ambient + full);
    // The light shines along the hair, so sin(T, L) is 0; H is at 45 degrees to the hair.
    let from = |x: f32, y: f32, z: f32| TrueLighting {
        key: TrueLight::Directional { towards_light_ws: Vec3::new(x, y, z), color: Vec3::ONE },
        ..lighting()
    };
    near(at_center(&curves, &from(1.0, 0.0, 0.0)), ambient + 0.18 * 0.5f32.powf(15.0));
    // Light from behind at 60 degrees to the hair; Attenu_Back is one half.
    let back = TrueLighting { hair_shadows: false, ..from(0.5, (1.0f32 - 0.25 - 0.0225).sqrt(), -0.15) };
    let half = (Vec3::new(0.5, (1.0f32 - 0.25 - 0.0225).sqrt(), -0.15) + Vec3::Z).normalize();
    let lit = 1.2 * color * 0.75 + 0.18 * (1.0 - half.x * half.x).powf(15.0);
    near(at_center(&curves, &back), ambient + 0.5 * lit);
    // Each term can be disabled.
    near(at_center(&curves, &TrueLighting { ambient_attenuation: false, ..lighting() }), 0.35 * color + full);
    near(at_center(&curves, &TrueLighting { back_attenuation: false, ..back.clone() }), ambient + lit);
    // A point light, and a fill light that casts no shadow.
    let lamp = TrueLight::Point { position_ws: Vec3::new(0.0, 0.0, 4.0), color: Vec3::new(1.0, 0.0, 2.0) };
    near(at_center(&curves, &TrueLighting { key: lamp, ..lighting() }), (ambient + full) * Vec3::new(1.0, 0.0, 2.0));
    near(at_center(&curves, &TrueLighting { fill: vec![lighting().key], ..lighting() }), ambient + 2.0 * full);

    // A strand between the point and the light blocks all of it, unless hair shadows are disabled. A strand behind a
    // point light blocks nothing.
    strand(&mut curves, Vec3::new(-9.0, 0.0, 8.0), Vec3::new(9.0, 0.0, 8.0), 2.0);
    near(at_center(&curves, &lighting()), ambient);
    near(at_center(&curves, &TrueLighting { hair_shadows: false, ..lighting() }), ambient + full);
    near(at_center(&curves, &TrueLighting { key: lamp, ..lighting() }), (ambient + full) * Vec3::new(1.0, 0.0, 2.0));
    // A disc light half hidden by the edge of a hair gives half the light.
    let mut edge = Curves::default();
    strand(&mut edge, Vec3::new(-3.0, 0.0, 0.0), Vec3::new(3.0, 0.0, 0.0), 0.001);
    strand(&mut edge, Vec3::new(-90.0, -50.0, 60.0), Vec3::new(90.0, -50.0, 60.0), 50.0);
    let picture = scene(edge).picture(
        &TrueCamera { lens: Lens::Orthographic { height_m: 1e-4 }, ..camera() },
        &TrueLighting { penumbra: 0.5, ..lighting() },
        (8, 8),
        400,
        &mut |_, _| (),
    );
    let mean = picture.pixels.iter().map(|p| p[0]).sum::<f32>() / 64.0;
    assert!((mean - (ambient + 0.5 * full).x).abs() < 0.02, "{mean}");
}

/// Returns a quad at height z, seen from the front.
fn skin(z: f64, material: PosedMaterial) -> PosedMesh {
    let vertex = |x: f64, y: f64| PosedVertex {
        position_ws: DVec3::new(x, y, z),
        normal_ws: DVec3::Z,
        tangent_ws: DVec3::X,
        bitangent_ws: DVec3::Y,
        color: Vec4::ONE,
        groom: glam::Vec2::X,
        fur_height_m: 0.1,
        ..PosedVertex::default()
    };
    PosedMesh {
        measured_ws: Vec::new(),
        vertices: vec![vertex(-1.0, -1.0), vertex(1.0, -1.0), vertex(1.0, 1.0), vertex(-1.0, 1.0)],
        same_place: vec![0, 1, 2, 3],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material_of: vec![0, 0],
        materials: vec![material],
    }
}

#[test]
fn bare_skin_is_lambertian_and_furred_skin_is_shaded_as_undercoat() {
    let bare = PosedMaterial { base_color: Vec4::new(0.5, 0.5, 0.5, 0.6), ..PosedMaterial::default() };
    let furred = PosedMaterial { furred: true, ..bare.clone() };
    let upright = pelage_bake::stages::simulate::Strands {
        points: vec![Vec3::ZERO, Vec3::Z],
        radii: vec![0.1; 2],
        colors: vec![Vec3::ONE; 2],
        offsets: vec![0, 2],
        height: 1.0,
        root_color: Vec3::splat(0.4),
    };
    let hair = TileHair { strands: upright, ..TileHair::default() };
    let slanted = TrueLighting {
        key: TrueLight::Directional { towards_light_ws: Vec3::new(0.0, 0.8, 0.6), color: Vec3::ONE },
        ..lighting()
    };
    let shade = |material: PosedMaterial, groom: f32| {
        let mut skin = skin(0.0, material);
        skin.vertices.iter_mut().for_each(|v| v.groom.x = groom);
        let scene = TrueScene::new(Curves::default(), skin, Some(&hair), Shading::default()).unwrap();
        trace(&scene, &slanted, 3, 4).pixels[4]
    };
    let lambert = 0.5 * (0.35 + 1.2 * 0.6);
    // Upright roots: sin²(T, L) is 0.64, and T and H are 26.6 degrees apart.
    let undercoat = 0.2 * (0.35 * 0.3 + 1.2 * 0.64) + 0.18 * 0.2f32.powf(15.0);
    for (found, expected) in [
        (shade(bare.clone(), 1.0), lambert),
        (shade(furred.clone(), 1.0), undercoat),
        (shade(furred, 0.25), 0.25 * undercoat + 0.75 * lambert),
    ] {
        assert!((found[0] - expected).abs() < 1e-5 && found[3] == 1.0, "{found:?}, expected {expected}");
    }
    // A surface whose alpha is below the cutoff is invisible.
    let cut = PosedMaterial { alpha_cutoff: Some(0.7), ..bare.clone() };
    assert_eq!(shade(cut, 1.0), [0.0; 4]);
    // From behind, a single-sided surface is invisible. A double-sided one is lit by light on its back.
    let behind = |double_sided: bool| {
        let mut skin = skin(0.0, PosedMaterial { double_sided, ..bare.clone() });
        skin.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let scene = TrueScene::new(Curves::default(), skin, None, Shading::default()).unwrap();
        trace(&scene, &slanted, 3, 4).pixels[4]
    };
    assert_eq!(behind(false), [0.0; 4]);
    assert!((behind(true)[0] - 0.5 * 0.35).abs() < 1e-5, "{:?}", behind(true));
}

#[test]
fn skin_casts_shadows_on_hair() {
    let mut curves = Curves::default();
    strand(&mut curves, Vec3::new(-0.5, 0.0, -1.0), Vec3::new(0.5, 0.0, -1.0), 0.5);
    // The surface hides the strand from the light; the camera is below.
    let camera = TrueCamera { eye_ws: Vec3::new(0.0, 0.0, -5.0), ..camera() };
    let scene = TrueScene::new(curves, skin(0.0, PosedMaterial::default()), None, Shading::default()).unwrap();
    let center = |lighting: TrueLighting| scene.picture(&camera, &lighting, (3, 3), 4, &mut |_, _| ()).pixels[4][0];
    let (dark, lit) = (center(lighting()), center(TrueLighting { skin_shadows: false, ..lighting() }));
    let ambient = 0.5 * 0.35 * 0.65;
    assert!((dark - ambient).abs() < 1e-5 && lit > dark + 0.1, "{dark} {lit}");
}

/// Checks that the error of a picture falls with the number of samples n: as 1/√n for random samples, slightly faster
/// for evenly spread ones.
#[test]
fn noise_falls_with_the_square_root_of_the_samples() {
    let mut curves = Curves::default();
    for i in 0..600u64 {
        let draw = |n: u64| 2.0 * uniform(3, 8 * i + n) - 1.0;
        let middle = Vec3::new(draw(0), draw(1), draw(2));
        let way = Vec3::new(draw(3), draw(4), draw(5)).normalize() * 0.2;
        strand(&mut curves, middle - way, middle + way, 0.01);
    }
    let scene = scene(curves);
    let light = TrueLighting {
        key: TrueLight::Directional { towards_light_ws: Vec3::new(0.3, 0.8, 0.5), color: Vec3::ONE },
        penumbra: 0.3,
        ..lighting()
    };
    let truth = trace(&scene, &light, 48, 4096);
    let errors: Vec<(f64, f64)> = [4u32, 16, 64, 256]
        .iter()
        .map(|spp| {
            let picture = trace(&scene, &light, 48, *spp);
            let squares = picture.pixels.iter().zip(&truth.pixels).map(|(a, b)| f64::from(a[0] - b[0]).powi(2));
            (f64::from(*spp).ln(), 0.5 * (squares.sum::<f64>() / (48.0 * 48.0)).ln())
        })
        .collect();
    let mean = |f: fn(&(f64, f64)) -> f64| errors.iter().map(f).sum::<f64>() / errors.len() as f64;
    let (x, y) = (mean(|e| e.0), mean(|e| e.1));
    let slope = errors.iter().map(|e| (e.0 - x) * (e.1 - y)).sum::<f64>()
        / errors.iter().map(|e| (e.0 - x).powi(2)).sum::<f64>();
    assert!((-0.8..-0.45).contains(&slope), "slope {slope}, {errors:?}");
}

#[test]
fn traced_picture_does_not_depend_on_scale_and_position() {
    let picture = |scale: f32, shift: Vec3| {
        let mut curves = Curves::default();
        strand(
            &mut curves,
            Vec3::new(-0.6, -0.3, 0.0) * scale + shift,
            Vec3::new(0.5, 0.4, 0.0) * scale + shift,
            0.05 * scale,
        );
        let camera = TrueCamera {
            eye_ws: Vec3::new(0.0, 0.0, 5.0) * scale + shift,
            target_ws: shift,
            lens: Lens::Perspective { fov_y_rad: 0.4 },
            ..camera()
        };
        scene(curves).picture(&camera, &lighting(), (32, 32), 16, &mut |_, _| ())
    };
    let truth = picture(1.0, Vec3::ZERO);
    assert!(covered(&truth) > 0.1);
    for (scale, shift) in [(1e-3, Vec3::ZERO), (100.0, Vec3::ZERO), (1.0, Vec3::new(8.0, -16.0, 4.0))] {
        let other = picture(scale, shift);
        let off = truth.pixels.iter().zip(&other.pixels).filter(|(a, b)| (a[3] - b[3]).abs() > 0.07).count();
        assert!(off <= 4, "scale {scale}, shift {shift}: {off} pixels differ");
    }
}

#[test]
fn traced_picture_does_not_depend_on_thread_count() {
    let mut curves = Curves::default();
    for i in 0..50 {
        let x = i as f32 / 25.0 - 1.0;
        strand(&mut curves, Vec3::new(x, -0.8, 0.0), Vec3::new(-x, 0.8, 0.3), 0.01);
    }
    let scene = scene(curves);
    let light = TrueLighting { penumbra: 0.2, ..lighting() };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut calls = Vec::new();
        let picture = pool
            .install(|| scene.picture(&camera(), &light, (150, 70), 5, &mut |done, total| calls.push((done, total))));
        assert_eq!(calls.last(), Some(&(150 * 70, 150 * 70)));
        picture
    };
    let one = on(1);
    assert!(one == on(4) && one == on(3) && one.rays.shadow > 0);
}

#[test]
fn empty_scene_gives_an_empty_picture() {
    let picture = trace(&scene(Curves::default()), &lighting(), 4, 4);
    assert!(picture.pixels.iter().all(|p| *p == [0.0; 4]) && picture.rays.shadow == 0);
}

#[test]
fn sample_portions_add_up_and_a_trace_can_be_cancelled() {
    let scene = rising_strand();
    let part = |samples| {
        scene.portion(&camera(), &lighting(), (40, 40), &Portion::of_samples(samples), &mut |_, _| {
            ControlFlow::Continue(())
        })
    };
    let whole = trace(&scene, &lighting(), 40, 8);
    let mut mixed = part(0..2).unwrap();
    mixed.mix(&part(2..8).unwrap(), [0.25, 0.75]);
    assert_eq!(mixed.rays, whole.rays);
    for (a, b) in mixed.pixels.iter().flatten().zip(whole.pixels.iter().flatten()) {
        assert!((a - b).abs() < 1e-5, "found {a}, expected {b}");
    }
    assert!(part(0..2).unwrap() != part(2..4).unwrap(), "parts must have different samples");
    let broken =
        scene.portion(&camera(), &lighting(), (40, 40), &Portion::of_samples(0..8), &mut |_, _| ControlFlow::Break(()));
    assert_eq!(broken, None);
}

#[test]
fn samples_added_one_by_one_give_the_picture_of_all() {
    let scene = rising_strand();
    let mut sums = PictureSums::new((40, 40), Part::default());
    for count in [1, 1, 3, 2] {
        let added = scene.add_samples(&camera(), &lighting(), &mut sums, count, &mut |_, _| ControlFlow::Continue(()));
        assert!(added.is_continue());
    }
    assert_eq!((sums.samples(), sums.pixels()), (7, 1600));
    let traced = trace(&scene, &lighting(), 40, 7);
    assert_eq!(sums.picture(), traced, "bit for bit");
    // The sums that guide the filter do not change the picture.
    let mut guided = PictureSums::new((40, 40), Part::default()).guided();
    let added = scene.add_samples(&camera(), &lighting(), &mut guided, 7, &mut |_, _| ControlFlow::Continue(()));
    assert!(added.is_continue() && guided.picture() == traced && guided.denoised() != traced);
    assert!(guided.denoised().pixels.iter().zip(&traced.pixels).all(|(a, b)| a[3] == b[3]), "coverage stays");
}

#[test]
fn row_portions_have_the_pixels_of_the_whole() {
    let scene = rising_strand();
    let size = (70, 45);
    let whole = scene.picture(&camera(), &lighting(), size, 2, &mut |_, _| {});
    let mut pixels = vec![[f32::NAN; 4]; whole.pixels.len()];
    let mut rays = Rays::default();
    for number in 0..5 {
        let part = Part { number, of: 5 };
        let portion = Portion { samples: 0..2, part };
        let mut told = (0, 0);
        let traced = scene.portion(&camera(), &lighting(), size, &portion, &mut |done, all| {
            told = (done, all);
            ControlFlow::Continue(())
        });
        let traced = traced.expect("nothing cancels the trace");
        let squares = part.squares(size);
        let count: u64 = squares.iter().map(Square::pixels).sum();
        assert_eq!(told, (count, count));
        assert!(count.abs_diff(70 * 45 / 5) < 300, "{count} pixels in part {number}");
        for Square { columns, rows } in squares {
            for at in rows.flat_map(|y| columns.clone().map(move |x| (y * 70 + x) as usize)) {
                assert!(pixels[at][0].is_nan(), "pixel {at} is in two parts");
                pixels[at] = traced.pixels[at];
            }
        }
        (rays.primary, rays.shadow) = (rays.primary + traced.rays.primary, rays.shadow + traced.rays.shadow);
    }
    assert_eq!((pixels, rays), (whole.pixels, whole.rays));
}
