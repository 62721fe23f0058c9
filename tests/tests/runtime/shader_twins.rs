//! Compares three implementations of the shared shader functions: f64 reference, Rust twin, and GPU.
//!
//! The twin performs the same f32 operations as the shader, so both have the same tolerance. The only exception is
//! `normalize_or`, which omits a scaling that it does not need. WGSL allows larger errors of exp2, log2 and inverseSqrt
//! than Rust, by a few units in the last place, and powers multiply them by the exponent.

#![allow(clippy::unwrap_used, reason = "tests")]

use pelage_runtime::formats::meaning::openness::Openness;
use pelage_runtime::formats::meaning::scattering::broad;
use pelage_runtime::formats::meaning::scattering::longitudinal::i0e;
use pelage_runtime::glam::{DMat3, DVec2, DVec3, Mat3, Mat4, Vec2, Vec3, Vec4};
use pelage_runtime::shared::{
    deep_opacity, environment, fins, frame, kajiya_kay, layer_shadow, opacity, receiver, scattering, skinning,
    soft_shadow, tile_frame, tone, visibility,
};
use pelage_tests::compute::evaluate;
use pelage_tests::gpu::gpu;
use pelage_tests::support::sphere::Random;

pub(super) type Case<const N: usize> = [[f32; 4]; N];

/// Checks twin and GPU against the f64 reference for every case. `tolerance` returns the absolute tolerance per
/// component, as a function of the reference value.
pub(super) fn assert_truth_twin_and_shader_agree<const N: usize>(
    name: &str,
    library: &str,
    expression: &str,
    cases: &[Case<N>],
    truth: impl Fn(&Case<N>) -> [f64; 4],
    twin: impl Fn(&Case<N>) -> [f32; 4],
    tolerance: impl Fn(&Case<N>, f64) -> f64,
) {
    let on_gpu = gpu(name).map(|gpu| evaluate(gpu, library, expression, cases));
    let mut worst = [0.0f64; 2];
    for (index, case) in cases.iter().enumerate() {
        let expected = truth(case);
        let ways = [Some(twin(case)), on_gpu.as_ref().map(|results| results[index])];
        for (way, found) in ways.into_iter().enumerate().filter_map(|(i, f)| Some((i, f?))) {
            for (k, (found, expected)) in found.into_iter().zip(expected).enumerate() {
                let (error, allowed) = ((f64::from(found) - expected).abs(), tolerance(case, expected));
                assert!(
                    error <= allowed,
                    "{name}, {}: case {index} {case:?}, component {k}: {found}, expected {expected} within {allowed}",
                    ["twin", "GPU"][way]
                );
                worst[way] = worst[way].max(error / allowed);
            }
        }
    }
    println!("{name}: {} cases, worst share of the tolerance: twin {:.3}, GPU {:.3}", cases.len(), worst[0], worst[1]);
}

fn unit(random: &mut Random) -> Vec3 {
    loop {
        let v = Vec3::new(random.next_f32(), random.next_f32(), random.next_f32()) * 2.0 - 1.0;
        if (0.01..1.0).contains(&v.length_squared()) {
            return v.normalize();
        }
    }
}

fn d(v: &[f32; 4]) -> DVec3 {
    DVec3::new(v[0].into(), v[1].into(), v[2].into())
}

fn v(v: &[f32; 4]) -> Vec3 {
    Vec3::new(v[0], v[1], v[2])
}

fn x(value: f64) -> [f64; 4] {
    [value, 0.0, 0.0, 0.0]
}

fn xf(value: f32) -> [f32; 4] {
    [value, 0.0, 0.0, 0.0]
}

#[test]
fn sin_squared_matches_the_shader() {
    let mut random = Random(1);
    let mut cases: Vec<Case<2>> = Vec::new();
    for i in 0..4000 {
        let a = unit(&mut random);
        // The vectors range from perpendicular to parallel within 1e-6.
        let b = (a + unit(&mut random) * 10f32.powf(-6.0 * (i % 100) as f32 / 99.0)).normalize();
        let scale = 0.1 + 1.9 * random.next_f32();
        cases.push([(a * scale).extend(0.0).to_array(), b.extend(0.0).to_array()]);
    }
    cases.push([[0.0; 4], [1.0, 0.0, 0.0, 0.0]]);
    assert_truth_twin_and_shader_agree(
        "sin_squared",
        kajiya_kay::WGSL,
        "vec4(sin_squared(in_0.xyz, in_1.xyz), 0.0, 0.0, 0.0)",
        &cases,
        |[a, b]| x((1.0 - d(a).dot(d(b)).powi(2)).max(0.0)),
        |[a, b]| xf(kajiya_kay::sin_squared(v(a), v(b))),
        // The tolerance is a few ulps of 1, or of the square of the dot product, which long vectors make larger.
        |[a, b], _| 4e-7 * d(a).dot(d(b)).powi(2).max(1.0),
    );
}

#[test]
fn sin_power_matches_the_shader() {
    let mut cases: Vec<Case<1>> = Vec::new();
    for s in [0.0, 1e-30, 1e-12, 1e-4, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 0.999, 0.99999, 1.0] {
        for h in [0.0, 0.5, 1.0, 2.5, 15.0, 50.0, 400.0, 5000.0] {
            cases.push([[s, h, 0.0, 0.0]]);
        }
    }
    assert_truth_twin_and_shader_agree(
        "sin_power",
        kajiya_kay::WGSL,
        "vec4(sin_power(in_0.x, in_0.y), 0.0, 0.0, 0.0)",
        &cases,
        |[c]| x(f64::from(c[0]).max(1e-30).powf(c[1].into())),
        |[c]| xf(kajiya_kay::sin_power(c[0], c[1])),
        // In WGSL, log2 has an error of about 2^-21 near 1, which is multiplied by the exponent and the result; exp2
        // adds its own.
        |[c], p| {
            p * (1e-6 * f64::from(c[1]) + 1e-6 * (f64::from(c[1]) * f64::from(c[0].max(1e-30)).log2()).abs() + 1e-6)
                + 1e-12
        },
    );
}

#[test]
fn tone_mapping_matches_the_shader() {
    let levels = [0.0, 0.3, 0.7, 0.700_01, 0.8, 1.0, 3.0, 40.0, 1e4];
    let mut cases: Vec<Case<1>> = Vec::new();
    for (r, g, b) in levels.iter().flat_map(|r| levels.iter().flat_map(move |g| levels.map(|b| (*r, *g, b)))) {
        cases.push([[r, g, b, 0.0]]);
    }
    let mapped = |c: &[f32; 4]| {
        let color = d(c);
        let peak = color.max_element();
        if peak <= f64::from(0.7_f32) {
            return color;
        }
        let shown = 1.0 - 0.09 / (peak - 0.4);
        let white = 1.0 - 1.0 / (0.15 * (peak - shown) + 1.0);
        (color * (shown / peak)).lerp(DVec3::splat(shown), white)
    };
    assert_truth_twin_and_shader_agree(
        "tone_mapping",
        tone::WGSL,
        "vec4(tone_mapped(in_0.xyz), 0.0)",
        &cases,
        |[c]| mapped(c).extend(0.0).to_array(),
        |[c]| tone::tone_mapped(v(c)).extend(0.0).to_array(),
        |_, _| 1e-6,
    );
}

#[test]
fn slab_shares_match_the_shader() {
    let mut cases: Vec<Case<1>> = Vec::new();
    for i in -8..=80 {
        for (slab, slabs) in [(0, 1), (0, 4), (1, 4), (3, 4), (15, 16), (63, 64)] {
            cases.push([[i as f32 / 16.0 * slabs as f32 / 4.0, slab as f32, slabs as f32, 0.0]]);
        }
    }
    assert_truth_twin_and_shader_agree(
        "slabs",
        deep_opacity::WGSL,
        "vec4(slab_share(in_0.x, u32(in_0.y)), f32(slab_of(in_0.x, u32(in_0.z))), 0.0, 0.0)",
        &cases,
        |[c]| {
            let [behind, slab, slabs] = [c[0], c[1], c[2]].map(f64::from);
            let of = (0..slabs as u32).rev().map(f64::from).find(|k| behind >= *k).unwrap_or(0.0);
            [(behind.min(slab + 1.0) - slab).max(0.0), of, 0.0, 0.0]
        },
        |[c]| {
            let slab = deep_opacity::slab_of(c[0], c[2] as u32);
            [deep_opacity::slab_share(c[0], c[1] as u32), slab as f32, 0.0, 0.0]
        },
        |_, _| 1e-6,
    );
}

#[test]
fn attenuations_match_the_shader() {
    let mut cases: Vec<Case<1>> = Vec::new();
    for i in 0..=40 {
        for range in [0.0, 0.1, 0.3, 1.0, kajiya_kay::BACK_ATTENUATION_OFF] {
            cases.push([[i as f32 / 20.0 - 1.0, range, i as f32 / 40.0, range.min(1.0)]]);
        }
    }
    assert_truth_twin_and_shader_agree(
        "attenuations",
        kajiya_kay::WGSL,
        "vec4(back_attenuation(in_0.x, in_0.y), ambient_attenuation(in_0.z, in_0.w), back_slope(in_0.x, 0.3), 0.0)",
        &cases,
        |[c]| {
            let (n_dot_l, r) = (f64::from(c[0]), f64::from(c[1]).max(1e-4));
            let back = if n_dot_l >= 0.0 { 1.0 } else { (n_dot_l + r).clamp(0.0, r) / r };
            let (height, floor) = (f64::from(c[2]), f64::from(c[3]));
            [back, floor + (1.0 - floor) * height, n_dot_l / f64::from(0.3f32) + 1.0, 0.0]
        },
        |[c]| {
            let back = kajiya_kay::back_attenuation(c[0], c[1]);
            [back, kajiya_kay::ambient_attenuation(c[2], c[3]), kajiya_kay::back_slope(c[0], 0.3), 0.0]
        },
        |_, _| 2e-6,
    );
}

#[test]
fn resampled_opacity_matches_the_shader() {
    let mut cases: Vec<Case<1>> = Vec::new();
    for i in 0..=600 {
        for exponent in [1.0 / 64.0, 0.125, 0.3, 1.0, 2.0, 5.0, 63.0] {
            // The opacities range from 1e-8 to 1, uniformly in their logarithm.
            cases.push([[10f32.powf(-8.0 + i as f32 / 75.0), exponent, 0.0, 0.0]]);
        }
    }
    assert_truth_twin_and_shader_agree(
        "resampled_opacity",
        opacity::WGSL,
        "vec4(resampled_opacity(in_0.x, in_0.y), 0.0, 0.0, 0.0)",
        &cases,
        |[c]| x(-(f64::from(c[1]) * (-f64::from(c[0]).min(1.0 - 1.0 / 2048.0)).ln_1p()).exp_m1()),
        |[c]| xf(opacity::resampled_opacity(c[0], c[1])),
        // The tolerance is relative, because the safe form must keep the digits of small opacities.
        |_, a| 1e-5 * a,
    );
}

#[test]
fn baked_layer_shares_are_even() {
    let mut cases: Vec<Case<1>> = Vec::new();
    for baked in [2u32, 3, 8, 16, 64, 256] {
        for drawn in [2u32, 5, 8, 9, 16, 31, 64, 127, 256] {
            cases.extend((0..drawn).map(|layer| [[layer as f32, baked as f32, drawn as f32, 0.0]]));
        }
    }
    assert_truth_twin_and_shader_agree(
        "baked_layer",
        opacity::WGSL,
        "vec4(f32(baked_layer(u32(in_0.x), u32(in_0.y), u32(in_0.z))), 0.0, 0.0, 0.0)",
        &cases,
        |[c]| {
            let [layer, baked, drawn] = [c[0], c[1], c[2]].map(f64::from);
            // Each value is half an integer below 2^17, which f64 represents exactly.
            x(if layer == 0.0 {
                0.0
            } else {
                1.0 + ((2.0 * layer - 1.0) * (baked - 1.0) / (2.0 * (drawn - 1.0))).floor()
            })
        },
        |[c]| xf(opacity::baked_layer(c[0] as u32, c[1] as u32, c[2] as u32) as f32),
        |_, _| 1e-9,
    );
    for (baked, drawn) in [(16, 31), (8, 64), (64, 8), (16, 16)] {
        let mut uses = vec![0u32; baked as usize];
        (1..drawn).for_each(|k| uses[opacity::baked_layer(k, baked, drawn) as usize] += 1);
        let (least, most) = (uses[1..].iter().min().unwrap(), uses[1..].iter().max().unwrap());
        assert!(uses[0] == 0 && most - least <= 1, "{baked} baked, {drawn} drawn: {uses:?}");
    }
}

#[test]
fn directions_to_eye_and_light_match_the_shader() {
    let mut random = Random(3);
    let mut cases: Vec<Case<2>> = Vec::new();
    for i in 0..1000 {
        let target = (unit(&mut random) * 3.0).extend((i % 2) as f32);
        cases.push([target.to_array(), unit(&mut random).extend(0.0).to_array()]);
    }
    assert_truth_twin_and_shader_agree(
        "direction_to and half_vector",
        frame::WGSL,
        "vec4(half_vector(direction_to(in_0, in_1.xyz), in_1.xyz), direction_to(in_0, in_1.xyz).x)",
        &cases,
        |[t, p]| {
            let to = (d(t) - d(p) * f64::from(t[3])).normalize();
            (to + d(p)).normalize().extend(to.x).to_array()
        },
        |[t, p]| {
            let to = frame::direction_to(Vec4::from_array(*t), v(p));
            frame::half_vector(to, v(p)).extend(to.x).to_array()
        },
        // The sum of two nearly opposite unit vectors amplifies an ulp by the inverse of its length.
        |[t, p], _| {
            let to = (d(t) - d(p) * f64::from(t[3])).normalize();
            1e-6 / (to + d(p)).length().max(1e-3)
        },
    );
}

#[test]
fn tile_frames_match_the_shader() {
    let mut random = Random(4);
    let mut cases: Vec<Case<3>> = Vec::new();
    for i in 0..1000 {
        let (n, t) = (unit(&mut random), unit(&mut random));
        let handedness = if i % 3 == 0 { -1.0 } else { 1.0 };
        cases.push([
            n.extend(handedness).to_array(),
            t.extend(0.0).to_array(),
            unit(&mut random).extend(0.0).to_array(),
        ]);
    }
    assert_truth_twin_and_shader_agree(
        "tile_frame and to_tile",
        tile_frame::WGSL,
        "vec4(to_tile(tile_frame(in_0.xyz, in_1.xyz, in_0.w), in_2.xyz), 0.0)",
        &cases,
        |[n, t, w]| {
            let (n64, h) = (d(n), f64::from(n[3]));
            let t64 = (d(t) - n64 * n64.dot(d(t))).normalize();
            DVec3::new(t64.dot(d(w)), (h * n64.cross(t64)).dot(d(w)), n64.dot(d(w))).extend(0.0).to_array()
        },
        |[n, t, w]| tile_frame::to_tile(tile_frame::tile_frame(v(n), v(t), n[3]), v(w)).extend(0.0).to_array(),
        // Gram–Schmidt amplifies an ulp by the inverse of the remaining tangent's length.
        |[n, t, _], _| 2e-6 / d(n).cross(d(t)).length().max(1e-3),
    );
}

#[test]
fn direction_decoding_matches_the_specification() {
    let mut cases: Vec<Case<1>> = Vec::new();
    for i in 0..=17 {
        for j in 0..=17 {
            for (z, planar) in [(0.0, 1.0), (0.6, 0.0), (128.0 / 255.0, 0.0)] {
                cases.push([[(15 * i) as f32 / 255.0, (15 * j) as f32 / 255.0, z, planar]]);
            }
        }
    }
    cases.push([[128.0 / 255.0, 128.0 / 255.0, 128.0 / 255.0, 0.0]]);
    assert_truth_twin_and_shader_agree(
        "decode_direction",
        tile_frame::WGSL,
        "vec4(decode_direction(in_0, in_0.w > 0.5), 0.0)",
        &cases,
        |[c]| {
            let value = (d(c) * 255.0 - 128.0) / 127.0;
            let planar = value.x * value.x + value.y * value.y;
            let decoded = if c[3] > 0.5 { DVec3::new(value.x, value.y, (1.0 - planar).max(0.0).sqrt()) } else { value };
            decoded.extend(0.0).to_array()
        },
        |[c]| tile_frame::decode_direction(Vec4::from_array(*c), c[3] > 0.5).extend(0.0).to_array(),
        // z is the square root of a difference, which has an error of one ulp of 1.
        |_, component| 1e-6 + 3e-7 / component.abs().max(5e-4),
    );
}

/// Checks the shader's decoding of directions against the formats crate. The shader omits clamps, so inputs that would
/// be clamped are excluded.
#[test]
fn direction_decoding_matches_the_formats_crate() {
    use pelage_runtime::formats::{TextureFormat, decode_direction, encode_direction};
    let mut random = Random(8);
    for _ in 0..10_000 {
        let direction = unit(&mut random) * 0.99;
        for format in [TextureFormat::Rg8Unorm, TextureFormat::Rgba8Unorm] {
            let texel = encode_direction(direction, format).map(|byte| f32::from(byte) / 255.0);
            let planar = format.components() == 2;
            let ours = tile_frame::decode_direction(Vec4::from_array(texel), planar);
            let theirs = decode_direction(texel, format);
            assert!(ours.distance(theirs) < 1e-3, "{format:?}: {ours}, expected {theirs}");
        }
    }
}

#[test]
fn root_offsets_match_the_shader() {
    let mut random = Random(9);
    let mut vector = || unit(&mut random).extend(0.0).to_array();
    let cases: Vec<Case<2>> = (0..200).map(|_| [vector(), vector()]).collect();
    assert_truth_twin_and_shader_agree(
        "root_aside",
        tile_frame::WGSL,
        "vec4(root_aside(in_0.xyz, in_1.xyz), 0.0, 0.0)",
        &cases,
        |[aside, along]| {
            let (aside, along) = (d(aside), d(along));
            [aside.x + aside.z * along.x, aside.y + aside.z * along.y, 0.0, 0.0]
        },
        |[aside, along]| tile_frame::root_offset(v(aside), v(along)).extend(0.0).extend(0.0).to_array(),
        // The function has a product and a sum of numbers up to 1.
        |_, _| 3e-7,
    );
}

#[test]
fn leaned_hair_matches_the_shader() {
    let mut random = Random(8);
    let mut cases: Vec<Case<2>> = Vec::new();
    for i in 0..2000 {
        let length = [1.0, 0.6, 1e-3, 0.0][i % 4];
        let direction = unit(&mut random) * length;
        let share = [1.0, 0.5, 0.05, 1.5][i / 4 % 4];
        cases.push([direction.extend(0.0).to_array(), [random.next_f32(), random.next_f32(), share, 0.0]]);
    }
    assert_truth_twin_and_shader_agree(
        "lean_offset, lean_slope and hair_direction",
        tile_frame::WGSL,
        "vec4(hair_direction(in_0.xyz, in_1.z, lean_slope(in_1.x, in_1.y)), lean_offset(in_1.x, in_1.y))",
        &cases,
        |[direction, c]| {
            // The reference is a short piece of hair whose height is scaled by the relative hair length. The lean moves
            // each of its two ends sideways, by the offset at the height of that end.
            let (lean, height, share) = (f64::from(c[0]), f64::from(c[1]), f64::from(c[2]));
            let piece = 1e-6 * d(direction);
            let aside = |h: f64| lean * h * h;
            let moved = DVec3::new(piece.x, piece.y, share * piece.z)
                + DVec3::Y * (share * (aside(height + piece.z / 2.0) - aside(height - piece.z / 2.0)));
            let kept = moved.normalize_or_zero() * d(direction).length();
            kept.extend(aside(height)).to_array()
        },
        |[direction, c]| {
            let slope = tile_frame::lean_slope(c[0], c[1]);
            tile_frame::hair_direction(v(direction), c[2], slope).extend(tile_frame::lean_offset(c[0], c[1])).to_array()
        },
        |_, _| 2e-6,
    );
}

#[test]
fn transformed_normals_match_the_shader() {
    let mut random = Random(5);
    let mut cases: Vec<Case<4>> = Vec::new();
    while cases.len() < 1000 {
        let m = Mat3::from_cols(unit(&mut random), unit(&mut random), unit(&mut random));
        if m.determinant().abs() > 0.05 {
            let columns = [m.x_axis, m.y_axis, m.z_axis, unit(&mut random)];
            cases.push(columns.map(|c| c.extend(0.0).to_array()));
        }
    }
    assert_truth_twin_and_shader_agree(
        "transform_normal and handedness_of",
        skinning::WGSL,
        "vec4(transform_normal(mat3x3(in_0.xyz, in_1.xyz, in_2.xyz), in_3.xyz),
              handedness_of(mat3x3(in_0.xyz, in_1.xyz, in_2.xyz)))",
        &cases,
        |[a, b, c, n]| {
            // The reference is the inverse transpose, which the shader replaces by the cofactor form.
            let m = DMat3::from_cols(d(a), d(b), d(c));
            (m.inverse().transpose() * d(n)).normalize().extend(m.determinant().signum()).to_array()
        },
        |[a, b, c, n]| {
            let m = Mat3::from_cols(v(a), v(b), v(c));
            skinning::transform_normal(m, v(n)).extend(skinning::handedness_of(m)).to_array()
        },
        // Cancellation in the cofactors grows as the determinant shrinks. The determinants here are above 0.05.
        |_, _| 2e-5,
    );
}

#[test]
fn blended_positions_match_the_shader() {
    let mut random = Random(6);
    let mut cases: Vec<Case<4>> = Vec::new();
    for i in 0..1000 {
        let w = random.next_f32();
        let weights = if i % 7 == 0 { [0.0, 1.0, 0.0, 0.0] } else { [w, 1.0 - w, 0.0, 0.0] };
        let row = |r: &mut Random| unit(r).extend(0.0).to_array();
        cases.push([row(&mut random), row(&mut random), row(&mut random), weights]);
    }
    // The two matrices share two columns, so that three inputs suffice.
    let matrices = |[a, b, c, _]: &Case<4>| {
        let m = |x: Vec3, y: Vec3, z: Vec3| Mat4::from_mat3(Mat3::from_cols(x, y, z));
        (m(v(a), v(b), v(c)), m(v(b), v(c), v(a)))
    };
    assert_truth_twin_and_shader_agree(
        "blend",
        skinning::WGSL,
        "blend(
            mat4x4(in_0, in_1, in_2, vec4(0.0, 0.0, 0.0, 1.0)), mat4x4(in_1, in_2, in_0, vec4(0.0, 0.0, 0.0, 1.0)),
            mat4x4<f32>(), mat4x4<f32>(), in_3) * vec4(1.0, 2.0, 3.0, 1.0)",
        &cases,
        |case| {
            let (m0, m1) = matrices(case);
            let p = DVec3::new(1.0, 2.0, 3.0);
            let w = case[3].map(f64::from);
            let sum = m0.as_dmat4().transform_point3(p) * w[0] + m1.as_dmat4().transform_point3(p) * w[1];
            sum.extend(w[0] + w[1]).to_array()
        },
        |case| {
            let (m0, m1) = matrices(case);
            let m = skinning::blend(m0, m1, Mat4::ZERO, Mat4::ZERO, Vec4::from_array(case[3]));
            (m * Vec4::new(1.0, 2.0, 3.0, 1.0)).to_array()
        },
        |_, _| 3e-6,
    );
}

#[test]
fn fin_opacity_and_layer_paths_match_the_shader() {
    let cases: Vec<Case<1>> = (-200..=200).map(|i| [[i as f32 / 200.0, 0.0, 0.0, 0.0]]).collect();
    assert_truth_twin_and_shader_agree(
        "fin_opacity",
        fins::WGSL,
        "vec4(fin_opacity(in_0.x), 0.0, 0.0, 0.0)",
        &cases,
        |[c]| [(2.0 * f64::from(c[0]).abs() - 1.0).max(0.0), 0.0, 0.0, 0.0],
        |[c]| [fins::fin_opacity(c[0]), 0.0, 0.0, 0.0],
        // The function rounds twice, near 1.
        |_, _| 2e-7,
    );
    assert_truth_twin_and_shader_agree(
        "view_path",
        opacity::WGSL,
        "vec4(view_path(in_0.x), 0.0, 0.0, 0.0)",
        &cases,
        |[c]| [1.0 / f64::from(c[0]).abs().max(0.1), 0.0, 0.0, 0.0],
        |[c]| [opacity::view_path(c[0]), 0.0, 0.0, 0.0],
        // In WGSL, a division may have an error of 2.5 units in the last place.
        |_, path| 4e-7 * path,
    );
    let mut random = Random(9);
    let mut looks: Vec<Case<2>> = Vec::new();
    for i in 0..1000 {
        let eye = unit(&mut random);
        let tangent = unit(&mut random) * [1.0, 0.7, 0.1][i % 3];
        looks.push([tangent.extend(0.0).to_array(), eye.extend(0.0).to_array()]);
    }
    assert_truth_twin_and_shader_agree(
        "view_depth_factor",
        opacity::WGSL,
        "vec4(view_depth_factor(in_0.xyz, length(in_0.xyz), in_1.xyz, in_1.z), 0.0, 0.0, 0.0)",
        &looks,
        |[tangent, eye]| {
            let (t, e) = (d(tangent), d(eye));
            // For uniformly distributed hair, two thirds of the squared length are perpendicular to any view direction.
            let rest = 2.0 / 3.0 * (1.0 - t.length_squared()).max(0.0);
            let path = (e.cross(t).length_squared() + rest).sqrt().max(0.1) / e.z.abs().max(0.1);
            [path / (0.5 + 0.5 * (t.truncate().length_squared() + rest).sqrt()), 0.0, 0.0, 0.0]
        },
        |[tangent, eye]| [opacity::view_depth_factor(v(tangent), v(tangent).length(), v(eye), eye[2]), 0.0, 0.0, 0.0],
        |_, path| 5e-6 * (1.0 + path),
    );
    let ways: Vec<Case<1>> = cases
        .iter()
        .flat_map(|[c]| [0.0, 0.1, 0.5, 1.0, 1.5].map(|s| [[opacity::view_path(c[0]), s, 0.0, 0.0]]))
        .collect();
    assert_truth_twin_and_shader_agree(
        "shortened_path",
        opacity::WGSL,
        "vec4(shortened_path(in_0.x, in_0.y), 0.0, 0.0, 0.0)",
        &ways,
        |[c]| {
            let (path, share) = (f64::from(c[0]), f64::from(c[1]));
            [(1.0 + share * share * (path * path - 1.0)).sqrt(), 0.0, 0.0, 0.0]
        },
        |[c]| [opacity::shortened_path(c[0], c[1]), 0.0, 0.0, 0.0],
        // A path length near 1 is rounded, and so is its square.
        |_, path| 8e-7 * path,
    );
}

/// Checks the transmittance of a layer, and the length of the slanted path through it.
#[test]
fn layer_transmittances_match_the_shader() {
    let mut random = Random(41);
    let mut cases: Vec<Case<1>> = Vec::new();
    for alpha in [0.0, 1e-7, 1e-4, 0.5, 0.999, 0.9999, 1.0] {
        for n_dot_l in [1.0, -1.0, 0.5, 0.26, 0.25, 0.1, 0.0, -0.0] {
            cases.push([[alpha, n_dot_l, 0.0, 0.0]]);
        }
    }
    cases.extend((0..2000).map(|_| [[random.next_f32(), 2.0 * random.next_f32() - 1.0, 0.0, 0.0]]));
    assert_truth_twin_and_shader_agree(
        "layer_transmittances",
        layer_shadow::WGSL,
        "vec4(layer_transmittance(in_0.x, slanted_path(in_0.y)), slanted_path(in_0.y), 0.0, 0.0)",
        &cases,
        |[c]| {
            let path = 1.0 / f64::from(c[1]).abs().max(0.25);
            [(1.0 - f64::from(c[0])).max(1e-4).powf(path), path, 0.0, 0.0]
        },
        |[c]| {
            let path = layer_shadow::slanted_path(c[1]);
            [layer_shadow::layer_transmittance(c[0], path), path, 0.0, 0.0]
        },
        |_, expected| 3e-5 * expected.max(0.02),
    );
}

/// Returns Attenu_Shadow for a depth range of 0.5 m, a penumbra of 0.2, a blur of 4 mm and texels of 1 mm.
fn soft_shadow_truth(texel: [f64; 4], z: f64, distance: f64, path: f64, centred: bool) -> f64 {
    let [w, wz, first, _] = texel;
    let (range, penumbra, blur, texel) =
        (0.5, f64::from(0.2f32), f64::from(0.004f32) * distance, f64::from(0.001f32) * distance);
    let bias = texel * (0.5 + path);
    let behind = (z - first) * range - bias;
    let edge = (2.0 * w - 1.0) * blur;
    if !centred {
        let width = (behind * penumbra).clamp(1e-6, blur);
        return if behind <= 0.0 { 1.0 } else { (1.0 - edge.max(0.0) / width).clamp(0.0, 1.0) };
    }
    let sd = ((z - wz / w.max(1e-3)) * range).max(behind);
    let slack = bias + blur * path;
    let share = if behind > 0.0 { 1.0 } else { (sd / slack - 1.0).clamp(0.0, 1.0) };
    let width = (sd * penumbra).clamp(1e-6, 2.0 * blur);
    let lit = if sd <= 0.0 { 1.0 } else { (0.5 - edge / width).clamp(0.0, 1.0) };
    1.0 + (lit - 1.0) * share
}

/// Returns whether the result is discontinuous at this point, where rounding may select either side.
fn is_discontinuous(texel: [f32; 4], z: f32, distance: f32, path: f32) -> bool {
    let [w, wz, first, _] = texel;
    let bias = 0.001 * distance * (0.5 + path);
    let behind = (z - first) * 0.5 - bias;
    let sd = ((z - wz / w.max(1e-3)) * 0.5).max(behind);
    behind.abs() < 1e-4 || sd.abs() < 1e-4
}

#[test]
fn soft_shadows_match_the_shader() {
    let mut random = Random(43);
    let s = soft_shadow::SoftShadow { range_m: 0.5, penumbra: 0.2, blur: 0.004, texel: 0.001 };
    let mut cases: Vec<Case<2>> = Vec::new();
    for i in 0..3000 {
        let w = random.next_f32();
        let (first, z) = (random.next_f32(), random.next_f32());
        // The last thousand cases have the distances and slants of a point light. In every seventh case, nothing near
        // is in shadow.
        let w = if i % 7 == 0 { 0.0 } else { w };
        let (distance, path) =
            if i < 2000 { (1.0, 1.0) } else { (0.1 + 3.0 * random.next_f32(), 1.0 + 3.0 * random.next_f32()) };
        cases.push([[w, w * random.next_f32(), first, 1.0], [z, distance, path, f32::from(u8::from(i % 2 == 0))]]);
    }
    let truth = |c: &Case<2>| {
        let [z, distance, path, centred] = c[1].map(f64::from);
        x(soft_shadow_truth(c[0].map(f64::from), z, distance, path, centred > 0.5))
    };
    let steep = |c: &Case<2>| is_discontinuous(c[0], c[1][0], c[1][1], c[1][2]);
    cases.retain(|c| !steep(c));
    assert!(cases.len() > 2500, "{}", cases.len());
    assert_truth_twin_and_shader_agree(
        "soft_shadows",
        soft_shadow::WGSL,
        "vec4(soft_shadow(in_0, in_1.x, in_1.y, in_1.z, \
         SoftShadow(0.5, 0.2, 0.004, 0.001), in_1.w > 0.5), 0.0, 0.0, 0.0)",
        &cases,
        truth,
        |c| xf(soft_shadow::soft_shadow(Vec4::from(c[0]), c[1][0], c[1][1], c[1][2], &s, c[1][3] > 0.5)),
        |_, _| 2e-3,
    );
}

#[test]
fn received_light_matches_the_shader() {
    let mut random = Random(47);
    let soft = soft_shadow::SoftShadow { range_m: 0.5, penumbra: 0.2, blur: 0.004, texel: 0.001 };
    let receiver = |centred: f32| receiver::ShadowReceiver {
        soft_shadow: soft,
        centred: u32::from(centred > 0.5),
        ..receiver::ShadowReceiver::default()
    };
    let path = |n_dot_l: f32| 1.0 / f64::from(n_dot_l).abs().max(0.25);
    // Inputs: texel; position in the maps, often beside or beyond them, sometimes behind a point light; cosine of the
    // angle between normal and light; 1 for the centred penumbra, 0 for the inner one.
    let mut cases: Vec<Case<3>> = Vec::new();
    for i in 0..4000 {
        let w = if i % 7 == 0 { 0.0 } else { random.next_f32() };
        let texel = [w, w * random.next_f32(), random.next_f32(), random.next_f32()];
        let distance = if i < 2000 { 1.0 } else { 0.1 + 3.0 * random.next_f32() };
        let distance = if i % 11 == 0 { -distance } else { distance };
        let mut along = || (1.25 * random.next_f32() - 0.125) * distance;
        let place = [along(), along(), 1.1 * random.next_f32() - 0.05, distance];
        cases.push([texel, place, [2.0 * random.next_f32() - 1.0, f32::from(u8::from(i % 2 == 0)), 0.0, 0.0]]);
    }
    cases.retain(|c| !is_discontinuous(c[0], c[1][2], c[1][3], path(c[2][0]) as f32));
    let inside = |c: &Case<3>| {
        let [u, v, z, w] = c[1];
        w > 0.0 && u >= 0.0 && v >= 0.0 && u <= w && v <= w && (0.0..=1.0).contains(&z)
    };
    let share = cases.iter().filter(|c| inside(c)).count() as f64 / cases.len() as f64;
    assert!(
        cases.len() > 3300 && (0.4..0.8).contains(&share),
        "{} cases, {share} of them inside the maps",
        cases.len()
    );
    let truth = |c: &Case<3>| {
        if !inside(c) {
            return x(1.0);
        }
        let [_, _, z, distance] = c[1].map(f64::from);
        let past = soft_shadow_truth(c[0].map(f64::from), z, distance, path(c[2][0]), c[2][1] > 0.5);
        x(past * f64::from(c[0][3]))
    };
    assert_truth_twin_and_shader_agree(
        "light_received",
        receiver::WGSL,
        "vec4(light_at_place(in_0, in_1, in_2.x, \
         ShadowReceiver(mat4x4<f32>(), SoftShadow(0.5, 0.2, 0.004, 0.001), \
         u32(in_2.y), 0u, 0u, 0u)), 0.0, 0.0, 0.0)",
        &cases,
        truth,
        |c| xf(receiver::light_at_place(Vec4::from(c[0]), Vec4::from(c[1]), c[2][0], &receiver(c[2][1]))),
        // The tolerance is that of `soft_shadow`.
        |_, _| 2e-3,
    );
}

#[test]
fn wrong_shader_results_are_detected() {
    let Some(gpu) = gpu("wrong_shader_results_are_detected") else { return };
    let wrong = std::panic::catch_unwind(|| {
        assert_truth_twin_and_shader_agree(
            "wrong on purpose",
            kajiya_kay::WGSL,
            "vec4(sin_squared(in_0.xyz, in_1.xyz) + 1e-4, 0.0, 0.0, 0.0)",
            &[[[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]]],
            |_| x(1.0),
            |_| xf(1.0),
            |_, _| 1e-6,
        );
    });
    assert!(wrong.is_err(), "an error of 1e-4 passed a tolerance of 1e-6");
    let idle = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        // The expression writes the sentinel, as if the shader had not run.
        evaluate(gpu, "", &format!("vec4({:?}) + 0.0 * in_0", pelage_tests::compute::SENTINEL), &[[[0.0; 4]]])
    }));
    assert!(idle.is_err(), "an unwritten output passed");
}

#[test]
fn tile_visibility_matches_the_shader() {
    let mut random = Random(10);
    let mut cases: Vec<Case<3>> = Vec::new();
    for i in 0..2000 {
        let texel = [random.next_f32(), random.next_f32(), random.next_f32(), random.next_f32()];
        let (share, lean) = ([1.0, 0.3, 0.0][i % 3], random.next_f32());
        let horizon = [4.0, 8.0, 1000.0][i / 3 % 3];
        cases.push([texel, unit(&mut random).extend(0.0).to_array(), [share, lean, horizon, 0.0]]);
    }
    assert_truth_twin_and_shader_agree(
        "visibility_towards and light_in_tile",
        visibility::WGSL,
        "vec4(light_in_tile(in_1.xyz, in_2.x, in_2.y), \
         visibility_towards(in_0, light_in_tile(in_1.xyz, in_2.x, in_2.y), in_2.z))",
        &cases,
        |[texel, light, c]| {
            let (l, share, slope) = (d(light), f64::from(c[0]), f64::from(c[1]));
            let upright = DVec3::new(share * l.x, share * (l.y - slope * l.z), l.z);
            let w = upright / upright.length().max(1e-15);
            let slope_of = |i: usize| (f64::from(texel[i]) * 255.0 - 128.0) / 64.0;
            let slopes = DVec3::new(slope_of(0), slope_of(1), slope_of(2));
            let t = (f64::from(texel[3]) + slopes.dot(w - DVec3::Z * 0.585)).clamp(0.0, 1.0);
            w.extend(t * (1.0 - (-f64::from(c[2]) * w.z.max(0.0)).exp())).to_array()
        },
        |[texel, light, c]| {
            let towards = visibility::light_in_tile(v(light), c[0], c[1]);
            let t = visibility::visibility_towards(Vec4::from(*texel), towards, c[2]);
            towards.extend(t).to_array()
        },
        |[_, _, c], _| 2e-5 + 3e-7 * f64::from(c[2]),
    );
}

/// Checks unit vectors of all kinds, including vectors along the fibre, and opposite and equal pairs.
#[test]
fn fibre_angles_match_the_shader() {
    let mut random = Random(11);
    let mut cases: Vec<Case<3>> = Vec::new();
    for i in 0..4000 {
        let tip = unit(&mut random);
        let mut near = |to: Vec3| (to + unit(&mut random) * 10f32.powf(-6.0 * (i % 50) as f32 / 49.0)).normalize();
        let (light, eye) = (near(tip), near(-tip));
        let mut any = || unit(&mut random);
        let [light, eye] = match i % 4 {
            0 => [any(), any()],
            1 => [light, any()],
            2 => [light, eye],
            _ => [light, light],
        };
        cases.push([tip, light, eye].map(|way| way.extend(0.0).to_array()));
    }
    for tip in [Vec3::X, Vec3::Z] {
        for [light, eye] in [[tip, tip], [tip, -tip], [-tip, -tip], [Vec3::Y, Vec3::Y], [Vec3::Y, Vec3::NEG_Y]] {
            cases.push([tip, light, eye].map(|way| way.extend(0.0).to_array()));
        }
    }
    let truth = |[tip, light, eye]: &Case<3>| {
        let (tip, light, eye) = (d(tip), d(light), d(eye));
        let [sin_i, sin_o] = [light, eye].map(|way| tip.dot(way).clamp(-1.0, 1.0));
        let [cos_i, cos_o] = [sin_i, sin_o].map(|sin| (1.0 - sin * sin).sqrt());
        let cos_d = (0.5 * (1.0 + cos_i * cos_o + sin_i * sin_o)).clamp(0.0, 1.0).sqrt();
        let sin_h = (0.5 * (sin_i + sin_o) / cos_d.max(1e-4)).clamp(-1.0, 1.0);
        let half_d = (1.0 - cos_d * cos_d).max(0.0).sqrt().copysign(sin_o - sin_i) / (1.0 + cos_d);
        let drawn_out = sin_h / (0.3 + 0.7 * sin_h.abs());
        [0.5 + 0.5 * drawn_out, 0.5 + 0.5 * half_d, ((cos_d - 0.1) / 0.9).clamp(0.0, 1.0), cos_i]
    };
    assert_truth_twin_and_shader_agree(
        "fibre_angles",
        scattering::WGSL,
        "vec4(fibre_angles(in_0.xyz, in_1.xyz, in_2.xyz).along, fibre_angles(in_0.xyz, in_1.xyz, in_2.xyz).around.y, \
         fibre_angles(in_0.xyz, in_1.xyz, in_2.xyz).cos_i)",
        &cases,
        truth,
        |[tip, light, eye]| {
            let found = scattering::fibre_angles(v(tip), v(light), v(eye));
            [found.along.x, found.along.y, found.around.y, found.cos_i]
        },
        // The square root of a difference loses half of the digits if an angle is 90° or 0°.
        |[tip, light, eye], _| {
            let cos = |way: &[f32; 4]| (1.0 - d(tip).dot(d(way)).powi(2)).max(1e-7).sqrt();
            let wide = d(light).dot(d(eye)) > 0.9;
            2e-6 / cos(light).min(cos(eye))
                + if wide { 1e-3 } else { 3e-6 }
                + 2e-3 * f64::from(u8::from(cos(light).min(cos(eye)) < 1e-2))
        },
    );
    // The azimuth is undefined for directions along the fibre. Elsewhere its cosine is compared.
    let across: Vec<Case<3>> = cases
        .iter()
        .filter(|[tip, light, eye]| [light, eye].iter().all(|way| d(tip).dot(d(way)).abs() < 0.99))
        .copied()
        .collect();
    assert_truth_twin_and_shader_agree(
        "azimuth of fibre_angles",
        scattering::WGSL,
        "vec4(cos(3.14159265 * fibre_angles(in_0.xyz, in_1.xyz, in_2.xyz).around.x), 0.0, 0.0, 0.0)",
        &across,
        |[tip, light, eye]| {
            let [l, e] = [light, eye].map(|way| (d(way) - d(tip) * d(tip).dot(d(way))).normalize());
            x(l.dot(e))
        },
        |[tip, light, eye]| {
            xf((std::f32::consts::PI * scattering::fibre_angles(v(tip), v(light), v(eye)).around.x).cos())
        },
        // Lavapipe's acos is accurate to about 1e-4.
        |_, _| 3e-4,
    );
}

#[test]
fn broad_light_matches_the_shader() {
    let mut random = Random(31);
    let mut cases: Vec<Case<2>> = Vec::new();
    for i in 0..3000 {
        let way = unit(&mut random) * [1.0, 0.01, 3.0][i % 3];
        let mean = [random.next_f32(), 0.0, 0.999, 0.5][i % 4];
        cases.push([way.extend(0.0).to_array(), [mean, 2.0 * random.next_f32() - 1.0, 0.0, 0.0]]);
    }
    assert_truth_twin_and_shader_agree(
        "octahedral",
        environment::WGSL,
        "vec4(octahedral(in_0.xyz), 0.0, 0.0)",
        &cases,
        |[way, _]| {
            let way = d(way);
            let flat = DVec2::new(way.x, way.z) / way.abs().element_sum();
            let folded = (1.0 - DVec2::new(flat.y.abs(), flat.x.abs())) * flat.signum();
            let place = if way.y >= 0.0 { flat } else { folded };
            [place.x, place.y, 0.0, 0.0]
        },
        |[way, _]| environment::octahedral(v(way)).extend(0.0).extend(0.0).to_array(),
        |_, _| 1e-6,
    );
    for [way, _] in &cases {
        let back = environment::from_octahedral(environment::octahedral(v(way)));
        assert!(back.distance(v(way).normalize()) < 1e-5, "{way:?}: {back}");
    }
    assert_truth_twin_and_shader_agree(
        "broad_light",
        environment::WGSL,
        "vec4(mean_square(in_1.x, in_1.y), broad_coordinate(in_1.x), broad_variance(in_1.x), \
         mean_cosine_around(9.0 * in_1.x))",
        &cases,
        |[_, [mean, cosine, ..]]| {
            let (mean, cosine) = (f64::from(*mean), f64::from(*cosine));
            let clamped = mean.clamp(broad::LEAST_MEAN, 1.0);
            let variance = (1.0 - clamped) / clamped;
            let around = 9.0 * mean / (0.5 + (81.0 * mean * mean + 2.25).sqrt());
            [broad::mean_square(mean, cosine), broad::mean_cosine_coordinate(mean), variance, around]
        },
        |[_, [mean, cosine, ..]]| {
            [
                environment::mean_square(*mean, *cosine),
                environment::broad_coordinate(*mean),
                environment::broad_variance(*mean),
                environment::mean_cosine_around(9.0 * mean),
            ]
        },
        |_, expected| 2e-6 * (1.0 + expected.abs()),
    );
}

#[test]
fn openness_decoding_matches_the_shader() {
    let mut random = Random(31);
    let mut cases: Vec<Case<2>> = vec![[[0.0; 4], [0.5, 0.5, 0.5, 0.0]]];
    for i in 0..2000 {
        let (share, turn, out) =
            (random.next_f32(), std::f32::consts::TAU * random.next_f32(), [random.next_f32(), 1.0][i % 2]);
        let of = Openness { share, tangential: [out * turn.cos(), out * turn.sin()] };
        let [x, y] = environment::pack_openness(of).map(|byte| f32::from(byte) / 255.0);
        let found = environment::unpack_openness(Vec2::new(x, y)) * environment::USUALLY_OPEN;
        // The tolerance is half a quantisation step of each component.
        assert!((found.length() - share).abs() < 0.004, "{of:?}: {found}");
        let expected = of.vector() / of.share;
        assert!(found.normalize().truncate().distance(expected.truncate()) < 0.11, "{of:?}: {found}");
        let color = [random.next_f32(), [0.0, 1.0][i % 2], 0.5];
        cases.push([[x, y, 0.0, 0.0], [color[0], color[1], color[2], random.next_f32()]]);
    }
    assert_truth_twin_and_shader_agree(
        "openness",
        environment::WGSL,
        "vec4(unpack_openness(in_0.xy), environment_share(in_1.rgb, in_1.a).g)",
        &cases,
        |[packed, [_, green, _, hidden]]| {
            let left = (1.0 - f64::from(*hidden)) / (1.0 - f64::from(*green).clamp(0.0, 0.98) * f64::from(*hidden));
            if packed[0] <= 0.0 {
                return [0.0, 0.0, 1.0, left];
            }
            let byte = (f64::from(packed[1]) * 255.0).round();
            let aside = [(byte / 16.0).floor(), byte.rem_euclid(16.0)].map(|x| (x - 7.0) / 7.0);
            let flat = aside[0] * aside[0] + aside[1] * aside[1];
            let middle = DVec3::new(aside[0], aside[1], (1.0 - flat).max(0.0).sqrt()).normalize();
            (middle * (f64::from(packed[0]) / 0.725)).extend(left).to_array()
        },
        |[packed, color]| {
            let open = environment::unpack_openness(Vec2::new(packed[0], packed[1]));
            open.extend(environment::environment_share(v(color), color[3]).y).to_array()
        },
        |_, _| 2e-6,
    );
}

#[test]
fn multiple_scattering_in_fur_matches_the_shader() {
    let mut random = Random(12);
    let mut cases: Vec<Case<3>> = Vec::new();
    for i in 0..3000 {
        let on = Vec3::new(random.next_f32(), random.next_f32(), random.next_f32());
        let back = (Vec3::ONE - on) * [1.0, random.next_f32(), 0.0][i % 3];
        let direct = [random.next_f32(), 0.0, 1.0, 1e-5][i / 3 % 4];
        let color = [random.next_f32(), [0.0, 1.0, 0.5, 2.0][i % 4], random.next_f32(), 0.17];
        let least = [1e-30, 1.0 / 26.0][i / 12 % 2];
        cases.push([on.extend(direct).to_array(), back.extend(least).to_array(), color]);
    }
    let parts = |[on, back, _]: &Case<3>| {
        [0, 1, 2].map(|i| {
            let lost = (1.0 - f64::from(on[i]) - f64::from(back[i])).max(1e-4);
            let less = (lost * (lost + 2.0 * f64::from(back[i]))).sqrt();
            let direct = f64::from(on[3]).clamp(f64::from(back[3]), 1.0);
            let (arrives, sent_on) = (direct.powf(less), direct.powf(1.0 - f64::from(on[i])));
            let given_back = f64::from(back[i]) / (lost + f64::from(back[i]) + less);
            [(sent_on - f64::from(on[3])).max(0.0), (arrives - sent_on).max(0.0), given_back * arrives]
        })
    };
    assert_truth_twin_and_shader_agree(
        "diffused_light",
        scattering::WGSL,
        "vec4(diffused_light(deep_fur(in_0.xyz, in_1.xyz), in_0.w, in_1.w).sent_on.x, \
         diffused_light(deep_fur(in_0.xyz, in_1.xyz), in_0.w, in_1.w).from_light.y, \
         diffused_light(deep_fur(in_0.xyz, in_1.xyz), in_0.w, in_1.w).from_below.yz)",
        &cases,
        |case| {
            let [x, y, z] = parts(case);
            [x[0], y[1], y[2], z[2]]
        },
        |[on, back, _]| {
            let found = scattering::diffused_light(v(on), v(back), on[3], back[3]);
            [found.sent_on.x, found.from_light.y, found.from_below.y, found.from_below.z]
        },
        |_, _| 2e-4,
    );
    assert_truth_twin_and_shader_agree(
        "multiple_scattering_by_height",
        scattering::WGSL,
        "vec4(multiple_scattering_by_height(in_0.xyz, in_0.w), 0.0)",
        &cases,
        |[root, ..]| {
            let [x, y, z] = [0, 1, 2].map(|i| {
                let (root, sine) = (2.0 * f64::from(root[i]), f64::from(root[3]));
                sine * (1.0 + root) / (1.0 + sine * root)
            });
            [x, y, z, 0.0]
        },
        |[root, ..]| scattering::multiple_scattering_by_height(v(root), root[3]).extend(0.0).to_array(),
        |_, _| 1e-6,
    );
    assert_truth_twin_and_shader_agree(
        "fibre_scatters",
        scattering::WGSL,
        &format!("vec4(fibre_scatters(in_0, in_1, {ABSORBED}, {LEFT}), 0.0)"),
        &cases,
        |[along, around, color]| {
            let ways = [0, 1, 2].map(|p| f64::from(along[p]) * f64::from(around[p]));
            let [x, y, z] = [0, 1, 2].map(|i| {
                let sigma = sigma(color, i);
                let left = remaining_light(color, i);
                ways[0]
                    + ways[1] * (-sigma * f64::from(around[3])).exp()
                    + ways[2] * left.powi(2)
                    + f64::from(along[3]) * left.powi(3)
            });
            [x, y, z, 0.0]
        },
        |[along, around, color]| {
            let absorbed = scattering::fibre_absorption(v(color), color[3]);
            let left = scattering::fibre_transmittance(color[2], Vec4::from(OPTICS), absorbed);
            let found = scattering::fibre_scatters(Vec4::from(*along), Vec4::from(*around), absorbed, left);
            found.extend(0.0).to_array()
        },
        |_, _| 3e-6,
    );
    let fibre = scattering::Fibre { optics: OPTICS, on: FITTED, back: FITTED.map(|of| of.map(|x| 0.25 * x)) };
    let sides = format!("absorbing_fibre_shares({}, in_2.z, {LEFT})", wgsl_literal(&fibre));
    assert_truth_twin_and_shader_agree(
        "absorbing_fibre_shares",
        scattering::WGSL,
        &format!("vec4({sides}[0].xy, {sides}[1].yz)"),
        &cases,
        |[_, _, color]| {
            let square = (1.0 - f64::from(color[2]).max(0.1)).powi(2);
            let share = |of: &[[f32; 4]; 3], i: usize| {
                let of = |p: usize| {
                    let [first, second, third] = of.map(|of| f64::from(of[p]));
                    first + square * second + square * square * third
                };
                (0..4).map(|p| of(p) * remaining_light(color, i).powi(p as i32)).sum::<f64>()
            };
            [share(&fibre.on, 0), share(&fibre.on, 1), share(&fibre.back, 1), share(&fibre.back, 2)]
        },
        |[_, _, color]| {
            let absorbed = scattering::fibre_absorption(v(color), color[3]);
            let left = scattering::fibre_transmittance(color[2], Vec4::from(OPTICS), absorbed);
            let [on, back] = scattering::absorbing_fibre_shares(&fibre, color[2], left);
            [on.x, on.y, back.y, back.z]
        },
        |_, _| 3e-6,
    );
}

#[test]
fn scattering_in_hanging_hair_matches_the_shader() {
    let mut random = Random(31);
    // Inputs: sines of the inclinations of light and view, variance, share of direct light; light scattered forward,
    // and cosine of the light's inclination; light scattered back, and light that remains after a fibre.
    let mut cases: Vec<Case<3>> = Vec::new();
    for i in 0..3000 {
        let sine = |random: &mut Random, which| match which {
            0 => -1.0,
            1 => 1.0,
            _ => 2.0 * random.next_f32() - 1.0,
        };
        let [sin_i, sin_o] = [i % 17, i % 23].map(|which| sine(&mut random, which));
        let variance = [random.next_f32(), 0.0, 4.0 * random.next_f32(), 0.02, 50.0][i % 5];
        let direct = [random.next_f32(), 0.0, 1.0, 1e-5][i / 3 % 4];
        let on = Vec3::new(random.next_f32(), random.next_f32(), random.next_f32());
        let back = (Vec3::ONE - on) * random.next_f32();
        cases.push([
            [sin_i, sin_o, variance, direct],
            on.extend(random.next_f32()).to_array(),
            back.extend(random.next_f32()).to_array(),
        ]);
    }
    assert_truth_twin_and_shader_agree(
        "hanging_sheet_shares",
        scattering::WGSL,
        "vec4(hanging_sheet_shares(array(in_1.xyz, in_2.xyz))[0].xy, \
         hanging_sheet_shares(array(in_1.xyz, in_2.xyz))[1].yz)",
        &cases,
        |[_, on, back]| {
            let of = |i: usize| {
                let (on, back) = (f64::from(on[i]), f64::from(back[i]));
                let turned = 0.15 * on + 0.8 * back;
                [0.88 * (on + back) - turned, turned]
            };
            [of(0)[0], of(1)[0], of(1)[1], of(2)[1]]
        },
        |[_, on, back]| {
            let [on, back] = scattering::hanging_sheet_shares([v(on), v(back)]);
            [on.x, on.y, back.y, back.z]
        },
        |_, _| 1e-6,
    );
    let of_i0 = |_: &Case<3>, exact: f64| 0.025 * exact.abs() + 2e-3;
    assert_truth_twin_and_shader_agree(
        "along_cone",
        scattering::WGSL,
        "vec4(along_cone(in_0.x, in_0.y, in_0.z), 0.0, 0.0, 0.0)",
        &cases,
        |[angles, ..]| x(along_cone(angles[0].into(), angles[1].into(), angles[2].into())),
        |[angles, ..]| xf(scattering::along_cone(angles[0], angles[1], angles[2])),
        of_i0,
    );
    let fibre = scattering::Fibre {
        optics: [0.41623, 0.17, 0.45, 0.07],
        on: FITTED,
        back: FITTED.map(|of| of.map(|x| 0.25 * x)),
    };
    assert_truth_twin_and_shader_agree(
        "hanging_cones",
        scattering::WGSL,
        &format!("vec4(hanging_cones({}, in_1.w, in_2.w, in_0.w, in_0.x, in_0.y), 0.0, 0.0)", wgsl_literal(&fibre)),
        &cases,
        |[angles, on, back]| {
            let (square, left) = ((1.0 - f64::from(on[3]).max(0.1)).powi(2), f64::from(back[3]));
            let light = |of: &[[f32; 4]; 3], p: usize| {
                let [first, second, third] = of.map(|of| f64::from(of[p]));
                (first + square * second + square * square * third) * left.powi(p as i32)
            };
            let wide = [0.07, 0.0175, 0.28, 0.28];
            let sum = |of: &[[f32; 4]; 3]| (0..4).map(|p| light(of, p)).sum::<f64>();
            let widths = |of: &[[f32; 4]; 3]| (0..4).map(|p| light(of, p) * wide[p]).sum::<f64>();
            let on = sum(&fibre.on).max(1e-4);
            let all = on + sum(&fibre.back).max(0.0);
            let width = (widths(&fibre.on) + widths(&fibre.back)) / all;
            let depth = -f64::from(angles[3]).clamp(1e-30, 1.0).ln();
            let sent = (on * depth).max(1e-3);
            let turned = 0.15 * on + 0.8 * (all - on);
            let lost = (1.0 - 0.88 * all).max(1e-4);
            let met = turned / (lost * (lost + 2.0 * turned)).sqrt();
            let times = 1.0 + depth * all + all / turned * met * (1.0 + met / 1.5) / (1.0 + met);
            let variances = [widths(&fibre.on) / on * sent / (1.0 - (-sent).exp()) + width, (times + 1.0) * width];
            let [a, b] = variances.map(|variance| along_cone(angles[0].into(), angles[1].into(), variance));
            [a, b, 0.0, 0.0]
        },
        |[angles, on, back]| {
            let [a, b] = scattering::hanging_cones(&fibre, on[3], back[3], angles[3], angles[0], angles[1]);
            [a, b, 0.0, 0.0]
        },
        of_i0,
    );
}

/// Checks that fibres with extreme values, which packages may contain, give finite results.
#[test]
fn scattering_in_hanging_hair_is_finite_for_extreme_fibres() {
    for (on, back) in [(0.0, 0.0), (1e-30, 0.0), (0.0, 1.0), (1.0, 1.0), (-10.0, 10.0), (10.0, 10.0), (-10.0, -10.0)] {
        let of = |x: f32| [[x, 0.0, 0.0, 0.0], [0.0; 4], [0.0; 4]];
        for width in [0.0, 1e-8, 0.07, 4.0] {
            let fibre = scattering::Fibre { optics: [0.4, 0.2, 0.4, width], on: of(on), back: of(back) };
            for (direct, sine) in [(0.0, 1.0), (1.0, -1.0), (0.3, 0.0)] {
                let found = scattering::hanging_cones(&fibre, 0.5, 1.0, direct, sine, 0.4);
                assert!(found.iter().all(|x| x.is_finite() && *x >= 0.0), "{on} {back} {width} {direct}: {found:?}");
            }
        }
    }
}

fn along_cone(sin_i: f64, sin_o: f64, variance: f64) -> f64 {
    let k = variance.clamp(1e-3, 1e3).recip();
    let a = k * ((1.0 - sin_i * sin_i) * (1.0 - sin_o * sin_o)).max(0.0).sqrt();
    2.0 * k * i0e(a) * (a - k * (1.0 + sin_i * sin_o)).exp() / (1.0 - (-2.0 * k).exp())
}

/// Formats a fibre as WGSL.
fn wgsl_literal(fibre: &scattering::Fibre) -> String {
    let vec4 = |[x, y, z, w]: [f32; 4]| format!("vec4({x:?}, {y:?}, {z:?}, {w:?})");
    let [on, back] = [fibre.on, fibre.back].map(|of| of.map(vec4).join(", "));
    format!("Fibre({}, array({on}), array({back}))", vec4(fibre.optics))
}

/// Optical constants of a hair fibre.
const OPTICS: [f32; 4] = [0.41623, 0.17, 0.45, 0.0];
const FITTED: [[f32; 4]; 3] = [[0.04, 0.85, 0.1, 0.01], [0.1, -0.5, 0.3, 0.1], [0.2, -0.3, 0.1, 0.0]];
/// WGSL expression for the absorption of the fibre, from the third input of a case, `in_2`.
const ABSORBED: &str = "fibre_absorption(in_2.xyz, in_2.w)";
/// WGSL expression for the light that remains after a path through the fibre, from the third input of a case, `in_2`.
const LEFT: &str = "fibre_transmittance(in_2.z, vec4(0.41623, 0.17, 0.45, 0.0), fibre_absorption(in_2.xyz, in_2.w))";

/// Returns the absorption coefficient of a fibre per radius, for one colour channel.
fn sigma(color: &[f32; 4], channel: usize) -> f64 {
    (f64::from(color[channel]).clamp(1e-3, 1.0).ln() * f64::from(color[3])).powi(2)
}

/// Returns the transmittance of a single path through the fibre. The blue channel of `color` is the cosine of the
/// difference angle.
fn remaining_light(color: &[f32; 4], channel: usize) -> f64 {
    let cos = f64::from(color[2]).max(0.1);
    let [per_eta2, _, aside, _] = OPTICS.map(f64::from);
    let cos_t2 = 1.0 - (1.0 - cos * cos) * per_eta2;
    let sin_section2 = aside * cos * cos * per_eta2 / cos_t2;
    (-sigma(color, channel) * 2.0 * (1.0 - sin_section2).sqrt() / cos_t2.sqrt()).exp()
}
