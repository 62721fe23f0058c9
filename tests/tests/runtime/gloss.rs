//! Gloss of bare surface: its formulas in three implementations, a sphere against the path tracer, and packages without
//! gloss.

#![allow(clippy::unwrap_used, reason = "tests")]

use super::shader_twins::{Case, assert_truth_twin_and_shader_agree};
use pelage_bake::strands::{Curves, PosedMesh};
use pelage_runtime::formats::meaning::environment::{Environment, LightLobe};
use pelage_runtime::formats::meaning::srgb_to_linear;
use pelage_runtime::formats::{Gloss, Limits, Manifest, Package};
use pelage_runtime::glam::{DVec3, Vec3};
use pelage_runtime::shared::gloss;
use pelage_runtime::{Camera, FrameParams, Instance, Light, Projection, Renderer, RendererOptions, Style};
use pelage_tests::gpu::gpu;
use pelage_tests::packages::{with_gloss, with_manifest};
use pelage_tests::pictures::{Picture, draw};
use pelage_tests::support::sphere::{Random, SphereParams, package};
use pelage_truth::{Lens, TrueCamera, TrueLight, TrueLighting, TrueScattering, TrueScene, TrueSky};

const SIZE: u32 = 96;
const HEIGHT_M: f32 = 0.24;

#[test]
fn gloss_matches_the_shader() {
    let mut random = Random(47);
    let mut cases: Vec<Case<2>> = Vec::new();
    for i in 0..3000 {
        let mut next = || random.next_f32();
        let alpha_squared = [0.0025 + 0.01 * next(), next().powi(2).max(0.005), 1.0][i % 3];
        let cosine = 1.0 - next().powi(1 + (i % 4) as i32);
        cases.push([[alpha_squared, cosine, next(), 0.001 + 0.999 * next()], [next(), 0.3 + 200.0 * next(), 0.0, 0.0]]);
    }
    assert_truth_twin_and_shader_agree(
        "gloss_lobe",
        gloss::WGSL,
        "vec4(gloss_lobe(in_0.x, in_0.y, in_0.z, in_0.w), gloss_fresnel(vec3(in_1.x), in_0.y).y, 0.0, 0.0)",
        &cases,
        |[of, [f0, ..]]| {
            let [a, h, l, e] = of.map(f64::from);
            let f0 = f64::from(*f0);
            let masked = |cosine: f64| (a + (1.0 - a) * cosine * cosine).sqrt();
            let distribution = a / (1.0 - h * h * (1.0 - a)).powi(2);
            let lobe = 0.5 * distribution * l / (l * masked(e) + e * masked(l));
            [lobe, f0 + (1.0 - f0) * (1.0 - h).powi(5), 0.0, 0.0]
        },
        |[[a, h, l, e], [f0, ..]]| {
            [gloss::gloss_lobe(*a, *h, *l, *e), gloss::gloss_fresnel(Vec3::splat(*f0), *h).y, 0.0, 0.0]
        },
        // 1 - h² cancels near the peak, where it is compared with α².
        |[[a, ..], _], value| value * (2e-6 + 4e-7 / f64::from(*a)) + 1e-6,
    );
    assert_truth_twin_and_shader_agree(
        "gloss_around",
        gloss::WGSL,
        "vec4(gloss_albedo(vec3(in_1.x), in_0.z, in_0.w).y, gloss_of_gaussian(in_0.x, in_0.w, in_1.y, in_0.y), \
         0.0, 0.0)",
        &cases,
        |[of, [f0, sharpness, ..]]| {
            let [a, cosine, roughness, e] = of.map(f64::from);
            let (own, other) = (0.25 / (a * e.max(0.1)), f64::from(*sharpness));
            let both = (own * own + other * other + 2.0 * own * other * cosine).sqrt();
            let peak = (both - own - other).exp() - (-both - own - other).exp();
            let kept =
                1.0 - roughness.powi(2) * (0.72 + 0.05 * e - 0.587 * e * e) - roughness.powi(3) * (1.14 * e - 0.605);
            let risen = (1.0 - e).powi(5) / (1.0 + 37.0 * (roughness * (1.0 - e)).powi(3));
            let albedo = f64::from(*f0) * (kept - risen) + risen;
            [albedo, own * peak / (both * (1.0 - (-2.0 * own).exp())), 0.0, 0.0]
        },
        |[[a, cosine, roughness, e], [f0, sharpness, ..]]| {
            let albedo = gloss::gloss_albedo(Vec3::splat(*f0), *roughness, *e).y;
            [albedo, gloss::gloss_of_gaussian(*a, *e, *sharpness, *cosine), 0.0, 0.0]
        },
        |_, value| 2e-5 * value + 2e-5,
    );
}

/// Integrates the reflection of a white mirror over all lights by brute force.
#[test]
fn mirrored_light_is_conserved() {
    for (roughness, e) in [(0.3f32, 0.9f32), (0.5, 0.6), (0.15, 0.7)] {
        let (eye, alpha_squared) = (Vec3::new((1.0 - e * e).sqrt(), 0.0, e), roughness.powi(4));
        let lobe = |way: Vec3| {
            let half = (way + eye).normalize();
            f64::from(gloss::gloss_lobe(alpha_squared, half.z, way.z, e))
        };
        let mean = |light: &dyn Fn(Vec3) -> f64| {
            let count = 400_000;
            let sum = (0..count).map(|i| {
                let (z, turn) = ((f64::from(i) + 0.5) / f64::from(count), 2.399_963_229_728_653 * f64::from(i));
                let way = DVec3::new((1.0 - z * z).sqrt() * turn.cos(), (1.0 - z * z).sqrt() * turn.sin(), z);
                lobe(way.as_vec3()) * light(way.as_vec3())
            });
            // A light of colour 1 has an irradiance of π, and the hemisphere 2 π steradians.
            sum.sum::<f64>() / f64::from(count) * 2.0
        };
        let whole = mean(&|_| 1.0);
        let fit = f64::from(gloss::gloss_albedo(Vec3::ONE, roughness, e).x);
        assert!(whole < 1.001 && (whole - fit).abs() < 0.06, "roughness {roughness}: {whole}, fit {fit}");
        // A wide lobe in the mirrored direction.
        let axis = Vec3::new(-eye.x, 0.0, eye.z);
        let lit = mean(&|way| f64::from((8.0 * (way.dot(axis) - 1.0)).exp())) / whole;
        let fit = f64::from(gloss::gloss_of_gaussian(alpha_squared, e, 8.0, 1.0));
        assert!((lit - fit).abs() < 0.2 * lit, "roughness {roughness}: {lit} under a lobe, fit {fit}");
    }
}

fn camera() -> Camera {
    let projection = Projection::Orthographic { height_m: HEIGHT_M, aspect: 1.0, near_m: 0.0, far_m: 10.0 };
    Camera::look_at(Vec3::new(0.0, 0.0, 1.0), Vec3::ZERO, projection)
}

fn sphere(gloss: Option<Gloss>, base: [f32; 4]) -> Vec<u8> {
    let bytes = with_manifest(&package(&SphereParams::default()), |manifest| {
        manifest.materials[0].furred = false;
        manifest.materials[0].base_color = base;
    });
    with_gloss(&bytes, &[gloss, None])
}

fn drawn(gpu: &pelage_stage::Gpu, package: &[u8], params: &FrameParams) -> Picture {
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let instance = Instance::new(0, &renderer.load_bytes(package).unwrap());
    draw(gpu, &mut renderer, params, &[&instance])
}

/// Returns the linear light of blocks of 4 x 4 pixels, each channel limited to 1; `None` where a block is not covered.
fn blocks(light: impl Fn(usize) -> [f32; 4]) -> Vec<Option<DVec3>> {
    let side = SIZE as usize / 4;
    let block = |i: usize| {
        let pixels = (0..16).map(|k| ((i / side * 4 + k / 4) * SIZE as usize) + i % side * 4 + k % 4);
        let pixels: Vec<[f32; 4]> = pixels.map(&light).collect();
        let sum = |c: usize| pixels.iter().map(|p| f64::from(p[c].min(1.0))).sum::<f64>() / 16.0;
        pixels.iter().all(|p| p[3] > 0.999).then(|| DVec3::new(sum(0), sum(1), sum(2)))
    };
    (0..side * side).map(block).collect()
}

/// Traces a glossy sphere and draws it, under key and fill lights, and under an environment with a window.
#[test]
fn glossy_sphere_matches_the_path_tracer() {
    let Some(gpu) = gpu("glossy_sphere_matches_the_path_tracer") else { return };
    let window = LightLobe { towards: [-0.3, 0.5, 0.8], width_deg: 15.0, radiance: [6.0, 5.0, 4.0] };
    let room = Environment { even: [0.3, 0.35, 0.4], lobes: vec![window], ..Environment::default() };
    let cornea = Gloss { roughness: 0.06, reflectance: 0.025, metalness: 0.0, wet: true };
    let nose = Gloss { roughness: 0.4, reflectance: 0.035, metalness: 0.0, wet: false };
    let brass = Gloss { roughness: 0.45, reflectance: 0.04, metalness: 1.0, wet: false };
    let (key, fill) = (Vec3::new(0.4, 0.5, 0.75), Vec3::new(-0.6, 0.1, 0.7));
    for (name, of, base) in [
        ("cornea", cornea, [0.02, 0.015, 0.01, 1.0]),
        ("nose", nose, [0.03, 0.02, 0.02, 1.0]),
        ("brass", brass, [0.7, 0.5, 0.2, 1.0]),
    ] {
        let bytes = sphere(Some(of), base);
        let opened = Package::open(&bytes, &Limits::default()).unwrap();
        for under_sky in [false, true] {
            let mut params = FrameParams::new(camera(), [SIZE; 2]);
            let color = Vec3::splat(if under_sky { 0.0 } else { 0.7 });
            params.light = Light::Directional { towards_light: key, color };
            params.ambient = color;
            params.soft_shadow = false;
            let mut lighting = TrueLighting {
                skin_shadows: false,
                ..TrueLighting::of(TrueLight::Directional { towards_light_ws: key, color })
            };
            if under_sky {
                params.environment = Some(room.clone());
                lighting.sky = Some(TrueSky::of_environment(room.clone()));
            } else {
                let color = Vec3::new(0.2, 0.3, 0.4);
                params.fill_lights = vec![Light::Directional { towards_light: fill, color }];
                lighting.fill = vec![TrueLight::Directional { towards_light_ws: fill, color }];
            }
            let picture = drawn(gpu, &bytes, &params);
            let skin = PosedMesh::posed("sphere", &opened, &[]).unwrap();
            let scene = TrueScene::new(Curves::default(), skin, None, opened.manifest().shading).unwrap();
            let lens = Lens::Orthographic { height_m: HEIGHT_M };
            let eye = TrueCamera { eye_ws: Vec3::Z, target_ws: Vec3::ZERO, up_ws: Vec3::Y, lens };
            let traced = scene.picture(&eye, &lighting, (SIZE, SIZE), 64, &mut |_, _| ());
            // The alpha of texels is linear.
            let here = blocks(|i| {
                let [r, g, b, alpha] = picture.rgba[i];
                [srgb_to_linear(r), srgb_to_linear(g), srgb_to_linear(b), f32::from(alpha) / 255.0]
            });
            let pairs = here.into_iter().zip(blocks(|i| traced.pixels[i])).filter_map(|(a, b)| a.zip(b));
            let (here, there): (Vec<DVec3>, Vec<DVec3>) = pairs.unzip();
            assert!(here.len() > 200, "{} blocks", here.len());
            let sum = |of: &[DVec3]| of.iter().copied().sum::<DVec3>();
            let off = here.iter().zip(&there).map(|(a, b)| (*a - *b).length_squared()).sum::<f64>();
            let whole = there.iter().map(|b| b.length_squared()).sum::<f64>();
            let (ratio, error) = (sum(&here) / sum(&there), (off / whole).sqrt());
            println!("{name}, sky {under_sky}: mean {ratio:.3}, blocks {:.1} %", 100.0 * error);
            assert!((ratio - 1.0).abs().max_element() < 0.1 && error < 0.2, "{name}, {under_sky}: {ratio} {error}");
            let brightest = |of: &[DVec3]| of.iter().map(|b| b.y).fold(0.0, f64::max);
            let peak = brightest(&here) / brightest(&there);
            assert!((0.75..1.3).contains(&peak), "{name}, {under_sky}: highlight {peak}");
        }
    }
}

/// Checks that light paths and the equation trace the same gloss, which they sample in different ways.
#[test]
fn light_paths_see_the_same_gloss() {
    let of = Gloss { roughness: 0.4, reflectance: 0.2, metalness: 0.0, wet: false };
    let bytes = sphere(Some(of), [0.05, 0.05, 0.05, 1.0]);
    let opened = Package::open(&bytes, &Limits::default()).unwrap();
    let window = LightLobe { towards: [-0.3, 0.5, 0.8], width_deg: 25.0, radiance: [3.0; 3] };
    let room = Environment { even: [0.3; 3], lobes: vec![window], ..Environment::default() };
    let key = TrueLight::Directional { towards_light_ws: Vec3::new(0.4, 0.5, 0.75), color: Vec3::splat(0.5) };
    let fibre = pelage_bake::recipe::FibreParams::default().fur_optics().fibre();
    let [paths, equation] = [true, false].map(|paths| {
        let shading = Manifest::default().shading;
        let skin = PosedMesh::posed("sphere", &opened, &[]).unwrap();
        let shading = pelage_runtime::formats::Shading { diffuse: [1.0; 3], ..shading };
        let scene = TrueScene::new(Curves::default(), skin, None, shading).unwrap();
        let scattering = paths.then(|| TrueScattering::new(fibre, 4).unwrap());
        let sky = Some(TrueSky::of_environment(room.clone()));
        let lighting = TrueLighting { scattering, sky, skin_shadows: false, ..TrueLighting::of(key) };
        let lens = Lens::Orthographic { height_m: HEIGHT_M };
        let eye = TrueCamera { eye_ws: Vec3::Z, target_ws: Vec3::ZERO, up_ws: Vec3::Y, lens };
        let traced = scene.picture(&eye, &lighting, (48, 48), 64, &mut |_, _| ());
        traced.pixels.iter().map(|p| f64::from(p[1])).sum::<f64>() / traced.covered() as f64
    });
    assert!((paths / equation - 1.0).abs() < 0.02, "{paths} along paths, {equation} by the equation");
}

/// Checks that highlights appear only on glossy surface, in fur style and in bare style, and never exceed white.
#[test]
fn matt_surface_has_no_highlight() {
    let Some(gpu) = gpu("matt_surface_has_no_highlight") else { return };
    let base = [0.02, 0.02, 0.02, 1.0];
    let cornea = Gloss { roughness: 0.06, reflectance: 0.025, metalness: 0.0, wet: true };
    for style in [Style::default(), Style::Bare] {
        let params = FrameParams::new(camera(), [SIZE; 2]).with(|p| p.style = style);
        let absent = with_manifest(&package(&SphereParams::default()), |manifest| {
            (manifest.materials[0].furred, manifest.materials[0].base_color) = (false, base);
        });
        let [absent, matt, glossy] =
            [absent, sphere(None, base), sphere(Some(cornea), base)].map(|bytes| drawn(gpu, &bytes, &params));
        assert_eq!(absent, matt);
        let brightest = |of: &Picture| of.rgba.iter().map(|p| p[0]).max().unwrap();
        assert!(brightest(&matt) < 60 && brightest(&glossy) > 150, "{} {}", brightest(&matt), brightest(&glossy));
    }
}
