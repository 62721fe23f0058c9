//! Tests of stability in the runtime. Each shows that the naive form fails, then checks the safe form against its
//! bound. Covers the rows "Kajiya–Kay", "opacity and layer count", "animation" and "shells" of the stability table.

#![allow(clippy::unwrap_used, reason = "tests")]

use super::silhouettes::texels;
use pelage_bake::io;
use pelage_bake::recipe::{Coat, Recipe};
use pelage_import::ImportOptions;
use pelage_lab::stability::Drawing;
use pelage_lab::stability::animation::joints;
use pelage_lab::stability::silhouette::{SilhouetteMeasures, bake, measure, profile_error};
use pelage_runtime::formats::{Limits, Package, PackageWriter};
use pelage_runtime::glam::{Mat3, Mat4, Vec3, Vec4};
use pelage_runtime::shared::{kajiya_kay, skinning, tile_frame};
use pelage_runtime::{Camera, FrameParams, Instance, PassId, Projection, Renderer, RendererOptions, wgpu};
use pelage_tests::binary::workspace;
use pelage_tests::compute::evaluate;
use pelage_tests::gpu::gpu;
use pelage_tests::pictures::draw_passes;
use pelage_tests::plane::plane;
use pelage_tests::silhouette::{SilhouetteModel, half_to_f32, silhouette_models};
use pelage_tests::support::sphere::{self, Random, SphereParams};

/// Returns unit vectors: a grid over the sphere that includes the axes, and 100 000 random ones.
fn unit_vectors() -> Vec<Vec3> {
    let mut all = Vec::new();
    for i in 0..=64 {
        for j in 0..128 {
            let (theta, phi) = (i as f32 * std::f32::consts::PI / 64.0, j as f32 * std::f32::consts::PI / 64.0);
            all.push(Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()).normalize());
        }
    }
    let mut random = Random(11);
    while all.len() < 108_320 {
        let v = Vec3::new(random.next_f32(), random.next_f32(), random.next_f32()) * 2.0 - 1.0;
        if v.length_squared() > 0.01 {
            all.push(v.normalize());
        }
    }
    all
}

const EXPONENTS: [f32; 9] = [0.0, 0.5, 1.0, 2.0, 3.0, 30.0, 101.0, 1000.0, 10_000.0];

#[test]
fn kajiya_kay_is_stable_with_hair_parallel_to_the_light() {
    let mut cases = Vec::new();
    for (i, t) in unit_vectors().into_iter().enumerate() {
        // The cases are L = T, L = −T, and L different from T by a rounding error.
        let l = [t, -t, (t * 1.000_000_1).normalize()][i % 3];
        cases.push([t.extend(EXPONENTS[i % EXPONENTS.len()]).to_array(), l.extend(0.0).to_array()]);
    }

    let naive = |t: Vec3, l: Vec3, p: f32| (1.0 - t.dot(l) * t.dot(l)).powf(p / 2.0);
    let mut failures = 0;
    for [t, l] in &cases {
        let (t3, l3, p) = (Vec4::from_array(*t).truncate(), Vec4::from_array(*l).truncate(), t[3]);
        failures += usize::from(naive(t3, l3, p).is_nan());
        let safe = kajiya_kay::sin_power(kajiya_kay::sin_squared(t3, l3), 0.5 * p);
        assert!((0.0..=1.0).contains(&safe), "T {t3}, L {l3}, exponent {p}: {safe}");
        assert!(p != 0.0 || safe == 1.0, "exponent 0 lights all directions alike, not {safe}");
    }
    assert!(failures > 1000, "the naive form failed only {failures} times: this test no longer triggers the failure");
    println!("Kajiya–Kay: naive NaN in {failures} of {} cases, safe in none", cases.len());

    if let Some(gpu) = gpu("kajiya_kay_is_stable_with_hair_parallel_to_the_light") {
        let safe = "vec4(sin_power(sin_squared(in_0.xyz, in_1.xyz), 0.5 * in_0.w), 0.0, 0.0, 0.0)";
        for (case, result) in cases.iter().zip(evaluate(gpu, kajiya_kay::WGSL, safe, &cases)) {
            assert!((0.0..=1.0).contains(&result[0]), "{case:?} on the GPU: {result:?}");
        }
    }
}

#[test]
fn normals_and_tangents_are_valid_under_degenerate_joints() {
    let normals: Vec<Vec3> = unit_vectors().into_iter().step_by(101).collect();
    let mut cases = Vec::new();
    let (mut not_unit, mut inward) = (0, 0);
    for (name, m) in joints() {
        for n in &normals {
            let safe = skinning::transform_normal(m, *n);
            assert!((safe.length() - 1.0).abs() < 1e-5, "{name}: {n} became {safe}");
            let tangent = tile_frame::orthonormal_tangent(m * tile_frame::any_perpendicular(*n), safe);
            assert!((tangent.length() - 1.0).abs() < 1e-5, "{name}: tangent {tangent}");
            assert!(tangent.dot(safe).abs() < 1e-4, "{name}: tangent {tangent} is not perpendicular to {safe}");
            // Normals must stay outward: the new normal must point away from the image of the tangent plane.
            if m.determinant().abs() > 1e-3 {
                assert!(safe.dot(m * *n) > 0.0, "{name}: {n} points inward as {safe}");
            }
            // The naive forms are the matrix itself and its inverse transpose.
            let naive = (m * *n).normalize();
            let inverse = (m.inverse().transpose() * *n).normalize();
            not_unit += usize::from(!naive.is_finite() || !inverse.is_finite());
            let cofactor_without_sign =
                Mat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis)) * *n;
            inward += usize::from(m.determinant() < -1e-3 && cofactor_without_sign.dot(m * *n) < 0.0);
            cases.push([m.x_axis, m.y_axis, m.z_axis, *n].map(|c| c.extend(0.0).to_array()));
        }
    }
    assert!(not_unit > normals.len(), "naive normals failed only {not_unit} times");
    assert!(inward > normals.len(), "unsigned cofactors pointed inward only {inward} times");

    if let Some(gpu) = gpu("normals_and_tangents_are_valid_under_degenerate_joints") {
        let normal = "transform_normal(mat3x3(in_0.xyz, in_1.xyz, in_2.xyz), in_3.xyz)";
        let tangent = format!(
            "orthonormal_tangent(mat3x3(in_0.xyz, in_1.xyz, in_2.xyz) * any_perpendicular(in_3.xyz), {normal})"
        );
        let library = format!("{}{}", skinning::WGSL, tile_frame::WGSL);
        let expression = format!("vec4(length({normal}), length({tangent}), dot({normal}, {tangent}), 0.0)");
        for (case, [n, t, dot, _]) in cases.iter().zip(evaluate(gpu, &library, &expression, &cases)) {
            let right = (n - 1.0).abs() < 1e-5 && (t - 1.0).abs() < 1e-5 && dot.abs() < 1e-4;
            assert!(right, "{case:?} on the GPU: lengths {n} and {t}, dot {dot}");
        }
    }
}

#[test]
fn joints_of_weight_zero_have_no_effect() {
    // An unused joint may contain anything, such as a broken inverse bind matrix; its weight is zero.
    let broken = Mat4::from_cols_array(&[f32::NAN; 16]);
    let moved = Mat4::from_translation(Vec3::X);
    let weights = Vec4::new(1.0, 0.0, 0.0, 0.0);
    let naive = moved * weights.x + broken * weights.y;
    assert!(naive.is_nan(), "the naive sum survives: this test no longer triggers the failure");
    assert_eq!(skinning::blend(moved, broken, broken, broken, weights), moved);
    // A vertex without weights must keep its stored position and not collapse to the origin.
    assert_eq!(moved * 0.0, Mat4::ZERO);
    assert_eq!(skinning::blend(moved, moved, moved, moved, Vec4::ZERO), Mat4::IDENTITY);

    if let Some(gpu) = gpu("joints_of_weight_zero_have_no_effect") {
        let m = |column: &str| format!("mat4x4(in_1, in_1, in_1, {column})");
        let expression = format!("blend({}, {}, {}, {}, in_0)[3]", m("in_2"), m("in_3"), m("in_3"), m("in_3"));
        let broken = [f32::NAN; 4];
        let column = [1.0, 2.0, 3.0, 1.0];
        let cases = [[weights.to_array(), [0.0; 4], column, broken], [[0.0; 4], [0.0; 4], column, column]];
        let results = evaluate(gpu, skinning::WGSL, &expression, &cases);
        assert_eq!(results, [column, [0.0, 0.0, 0.0, 1.0]]);
    }
}

#[test]
fn unnormalised_joint_weights_are_refused() {
    // Packages with joint weights that do not sum to 1 are rejected on opening, so the pose pass does not need to
    // handle them.
    let bytes = sphere::package(&SphereParams { quads: 2, texels: 8, skeleton: true, ..SphereParams::default() });
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    let (mesh, animation) = (package.mesh().unwrap().unwrap().to_data(), package.animation().unwrap().unwrap());
    for weights in [[0.0; 4], [0.5, 0.0, 0.0, 0.0], [0.7, 0.7, 0.0, 0.0], [2.0, -1.0, 0.0, 0.0]] {
        let mut mesh = mesh.clone();
        mesh.skin[3].weights = weights;
        let mut writer = PackageWriter::new(package.manifest().clone()).mesh(&mesh).animation(&animation);
        for index in 0..2 {
            writer = writer.texture(package.texture(index).unwrap().ktx2);
        }
        let error = writer.finish().expect_err("weights that do not sum to 1").to_string();
        assert!(error.contains("weights of vertex 3"), "{weights:?}: {error}");
    }
}

/// Returns the mean opacity of the shells without the base surface. They are drawn into a float target.
fn mean_opacity(gpu: &pelage_stage::Gpu, layers: u32, baked: u32, opacity: u8) -> f64 {
    // An 8-bit target stops accumulating (formula sheet, 3.2), while 16-bit floats keep the product within 0.6 %.
    let options = RendererOptions { color_format: wgpu::TextureFormat::Rgba16Float, ..RendererOptions::default() };
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options).unwrap();
    let bytes = plane(baked, opacity);
    let model = renderer.load_bytes(&bytes).unwrap();
    let projection = Projection::Orthographic { height_m: 0.1, aspect: 1.0, near_m: 0.0, far_m: 2.0 };
    let params = FrameParams::new(Camera::look_at(Vec3::Z, Vec3::ZERO, projection), [16, 16])
        .with_fur(|f| f.layers = Some(layers))
        // The hair of the plane is upright and viewed along its strands.
        .with(|p| p.study.view_slant = pelage_runtime::SlantForm::Printed);
    let texels = draw_passes(gpu, &mut renderer, &params, &[&Instance::new(0, &model)], &[PassId::SHELLS]);
    texels.chunks_exact(8).map(|t| f64::from(half_to_f32([t[6], t[7]]))).sum::<f64>() / 256.0
}

#[test]
fn density_does_not_depend_on_the_number_of_layers() {
    let Some(gpu) = gpu("density_does_not_depend_on_the_number_of_layers") else { return };
    for (baked, opacity) in [(64, 8), (64, 40), (16, 20), (16, 60), (8, 60)] {
        let alpha = f64::from(opacity) / 255.0;
        let truth = 1.0 - (1.0 - alpha).powi(baked as i32 - 1);
        for drawn in [8, 9, 16, 31, 64] {
            let found = mean_opacity(gpu, drawn, baked, opacity);
            // The tolerance is the bound of 2 % in the stability table.
            assert!(
                (found - truth).abs() <= 0.02 * truth,
                "{baked} layers of opacity {alpha:.4} drawn as {drawn}: {found:.4}, expected {truth:.4}"
            );
        }
        // The naive form keeps the opacities of the layers, whatever their number.
        let naive = [8, 64].map(|drawn| 1.0 - (1.0 - alpha).powi(drawn - 1));
        assert!(naive[1] - naive[0] > 0.02 * truth, "{baked}, {opacity}: naive {naive:?}");
    }
}

/// Measures the silhouette of a model from its front left.
fn silhouette(gpu: &pelage_stage::Gpu, case: &SilhouetteModel) -> SilhouetteMeasures {
    let mut recipe = Recipe::of_coat(Coat::Natural).unwrap();
    if let Some(path) = case.recipe {
        let text = std::fs::read_to_string(workspace().join(path)).unwrap();
        recipe = Recipe::parse(path, &text).unwrap();
    }
    let model =
        io::read_model(&case.model, &ImportOptions { unit_m: recipe.model.unit_m }, io::Reach::OwnFolder).unwrap();
    let package = bake(&case.model.display().to_string(), &model, &recipe).unwrap();
    let mut draw = |drawing: &Drawing<'_>| Ok(texels(gpu, drawing));
    measure(&package, case.size, &mut draw).unwrap()
}

/// Checks the coverage at the outline. Seen along the surface, layer sheets cover less than the hair that they
/// represent. Vertical hair slices and fins cover as much as the strands.
#[test]
fn outline_coverage_matches_the_strands() {
    let Some(gpu) = gpu("outline_coverage_matches_the_strands") else { return };
    for case in silhouette_models("outline_coverage_matches_the_strands") {
        let found = silhouette(gpu, &case);
        println!("{}: {}", case.name, found.table());
        assert!(
            found.ours <= 0.5 * found.sheets,
            "{}: coverage error {:.4}, with layers as sheets {:.4}",
            case.name,
            found.ours,
            found.sheets
        );
        let off = |profile: &[f64]| profile_error(profile, &found.profiles[0]);
        let [_, sheets, _, ours, fins] = &found.profiles;
        assert!(off(sheets) > off(ours), "{}: {sheets:?}", case.name);
        assert!(off(fins) > off(ours), "{}: {fins:?}", case.name);
    }
}
