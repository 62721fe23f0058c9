//! Compares three implementations of the ink formulas: f64 reference, Rust twin and GPU (Fang 2006).
#![allow(clippy::unwrap_used, reason = "tests")]

use glam::{DVec3, Vec2, Vec3, Vec4};
use pelage_runtime::shared::{ink, srgb};
use pelage_tests::compute::evaluate;
use pelage_tests::gpu::gpu;

/// Returns unit vectors that cover the hemisphere facing the camera, including rim and pole.
fn normals() -> Vec<Vec3> {
    let mut all = vec![Vec3::Z, Vec3::X, Vec3::NEG_Y, Vec3::new(0.6, 0.8, 0.0)];
    for i in 0..400 {
        let z = (i as f32 + 0.5) / 400.0;
        let angle = 2.4 * i as f32;
        let r = (1.0 - z * z).sqrt();
        all.push(Vec3::new(r * angle.cos(), r * angle.sin(), z));
    }
    all
}

fn homogeneous(v: Vec3, w: f32) -> [f32; 4] {
    v.extend(w).to_array()
}

#[test]
fn sphere_map_rim_is_the_outline_on_cpu_and_gpu() {
    let cases: Vec<[[f32; 4]; 1]> = normals().iter().map(|n| [homogeneous(*n, 1.0)]).collect();
    for n in normals() {
        let uv = ink::ink_sphere_uv(n, 1.0);
        // Reference: (u, v) = N_xy / 2 + 1/2 with v downwards; the radius is sqrt(1 − (N·E)²) / 2.
        let truth = Vec2::new(0.5 + 0.5 * n.x, 0.5 - 0.5 * n.y);
        assert!(uv.distance(truth) < 1e-6, "{n}: {uv}, expected {truth}");
        let radius = 0.5 * (1.0 - f64::from(n.z).powi(2)).max(0.0).sqrt();
        assert!((f64::from((uv - 0.5).length()) - radius).abs() < 1e-4, "{n}");
        // If the rim is swollen by a factor of 2, it reaches twice as far inwards, while the outline does not move. The
        // centre is skipped, because it has no direction to move in.
        if n == Vec3::Z {
            continue;
        }
        let swollen = (ink::ink_sphere_uv(n, 2.0) - 0.5).length();
        assert!((swollen - (0.5 - 0.5 * (0.5 - f64::from((uv - 0.5).length())) as f32)).abs() < 1e-5, "{n}");
    }
    let Some(gpu) = gpu("sphere_map") else { return };
    let library = ink::WGSL;
    let found = evaluate(gpu, library, "vec4(ink_sphere_uv(in_0.xyz, 1.0), ink_sphere_uv(in_0.xyz, 2.5))", &cases);
    for (case, found) in cases.iter().zip(found) {
        let n = Vec4::from(case[0]).truncate();
        let (plain, swollen) = (ink::ink_sphere_uv(n, 1.0), ink::ink_sphere_uv(n, 2.5));
        let found = Vec4::from(found);
        assert!(found.distance(Vec4::new(plain.x, plain.y, swollen.x, swollen.y)) < 1e-5, "{n}: {found}");
    }
}

/// Checks both forms of the sphere map. The published equation maps all normals to one point. The reflection form is
/// correct only on the axis. Off the axis, the outline moves inside the rim, to cos(a/2)/2, where a is the angle to the
/// axis.
#[test]
fn published_sphere_map_collapses_and_reflected_one_shrinks_off_axis() {
    let eye = DVec3::new(0.3, 0.2, 1.0).normalize().as_vec3();
    let places: Vec<Vec2> =
        normals().iter().map(|n| ink::ink_sphere_uv_printed(*n, eye)).filter(|p| p.is_finite()).collect();
    // Off the axis, all normals map to a line through the centre, in the direction of the eye.
    let first = (places[10] - 0.5).normalize();
    assert!(places.iter().all(|p| (*p - 0.5).normalize_or_zero().dot(first).abs() > 0.999), "{places:?}");
    let axis = Vec3::Z;
    assert!(normals().iter().all(|n| {
        let p = ink::ink_sphere_uv_printed(*n, axis);
        p == Vec2::splat(0.5) || !p.is_finite()
    }));
    for n in normals() {
        let straight = ink::ink_sphere_uv_reflected(n, axis);
        // The outline itself is excluded, because R is (0, 0, −1) there.
        if n.z > 1e-2 {
            assert!(straight.distance(ink::ink_sphere_uv(n, 1.0)) < 1e-4, "{n}: {straight}");
        }
    }
    let off = 40f32.to_radians();
    let eye = Vec3::new(off.sin(), 0.0, off.cos());
    let outline = Vec3::new(0.0, 1.0, 0.0);
    let radius = (ink::ink_sphere_uv_reflected(outline, eye) - 0.5).length();
    assert!((radius - 0.5 * (0.5 * off).cos()).abs() < 1e-4 && radius < 0.48, "{radius}");

    let Some(gpu) = gpu("reflected_sphere_map") else { return };
    let cases: Vec<[[f32; 4]; 2]> =
        normals().iter().filter(|n| n.z > 0.02).map(|n| [homogeneous(*n, 0.0), homogeneous(eye, 0.0)]).collect();
    let expression = "vec4(ink_sphere_uv_reflected(in_0.xyz, in_1.xyz), ink_sphere_uv_printed(in_0.xyz, in_1.xyz))";
    for (case, found) in cases.iter().zip(evaluate(gpu, ink::WGSL, expression, &cases)) {
        let n = Vec4::from(case[0]).truncate();
        let (reflected, printed) = (ink::ink_sphere_uv_reflected(n, eye), ink::ink_sphere_uv_printed(n, eye));
        let twin = Vec4::new(reflected.x, reflected.y, printed.x, printed.y);
        assert!((Vec4::from(found) - twin).abs().max_element() < 1e-4, "{n}: {found:?}, twin {twin}");
    }
}

#[test]
fn ink_formulas_on_the_gpu_match_the_cpu() {
    // The ramp ends at the two thresholds of the paper.
    assert_eq!([0.81, 0.8, 0.65, -1.0].map(|v| ink::ink_feature_strength(v, 0.8, 0.65)), [0.0, 0.0, 1.0, 1.0]);
    assert!((ink::ink_feature_strength(0.725, 0.8, 0.65) - 0.5).abs() < 1e-5);
    assert_eq!(ink::ink_feature_strength(0.8, 0.8, 0.8), 0.0, "equal thresholds must not divide by zero");
    // A line is darkest at the outline, with grey k/2; weak lines are lighter.
    assert_eq!(ink::ink_line_grey(0.0, 0.6, 0.3, 1.0), 0.3);
    assert_eq!(ink::ink_line_grey(1.0, 0.6, 0.3, 1.0), 0.6);
    assert!((ink::ink_line_grey(0.0, 0.6, 0.3, 0.0) - (0.3 + 0.7 * 0.3)).abs() < 1e-6);
    assert_eq!([-9.0, 0.0, 1.0, 9.0].map(|p| ink::ink_wash_grey(p, 0.5, 0.25)), [0.0, 0.25, 0.75, 1.0]);
    assert_eq!([0.0, 0.7, 2.0, -0.5].map(ink::ink_wash_product), [0.0, 0.7, 2.0, -0.25]);
    assert!(ink::ink_wash_product(-1e6) > -0.5001);
    let nested = Vec4::new(0.1, 0.3, 0.6, 1.0);
    assert_eq!([0.0, 0.25, 0.5, 0.75, 1.0, 2.0].map(|d| ink::ink_nested(nested, d)), [0.0, 0.1, 0.3, 0.6, 1.0, 1.0]);
    for c in [0.0f32, 0.01, 0.04045, 0.2, 0.5, 1.0] {
        let there = srgb::linear_of(Vec3::splat(c));
        assert!((srgb::encoded(there) - c).abs().max_element() < 1e-5, "{c}");
    }
    assert!((srgb::linear_of(Vec3::splat(0.5)).x - 0.214_041).abs() < 1e-5);

    let Some(gpu) = gpu("ink_formulas") else { return };
    let cases: Vec<[[f32; 4]; 2]> = (0..300)
        .map(|i| {
            let x = |k: f32| (i as f32 * k).fract();
            [[2.0 * x(0.317) - 1.0, x(0.173), x(0.291), 3.0 * x(0.411) - 1.0], [x(0.13), 0.3 + x(0.2) * 0.2, 0.6, 0.9]]
        })
        .collect();
    let expression = "vec4(ink_feature_strength(in_0.x, 0.8, 0.65), ink_line_grey(in_0.x, in_0.y, in_0.z, in_1.x), \
                      ink_wash_grey(ink_wash_product(in_0.w), in_0.y, in_0.z), ink_nested(in_1, in_0.y))";
    for (case, found) in cases.iter().zip(evaluate(gpu, ink::WGSL, expression, &cases)) {
        let [a, b] = case;
        let twin = [
            ink::ink_feature_strength(a[0], 0.8, 0.65),
            ink::ink_line_grey(a[0], a[1], a[2], b[0]),
            ink::ink_wash_grey(ink::ink_wash_product(a[3]), a[1], a[2]),
            ink::ink_nested(Vec4::from(*b), a[1]),
        ];
        assert!(found.iter().zip(twin).all(|(f, t)| (f - t).abs() < 1e-5), "{case:?}: {found:?}, twin {twin:?}");
    }
    let cases: Vec<[[f32; 4]; 1]> = (0..=100).map(|i| [[i as f32 / 100.0; 4]]).collect();
    for (case, found) in cases.iter().zip(evaluate(gpu, srgb::WGSL, "vec4(linear_of(in_0.xyz), 1.0)", &cases)) {
        assert!((found[0] - srgb::linear_of(Vec3::splat(case[0][0])).x).abs() < 1e-5, "{case:?}: {found:?}");
    }
}
