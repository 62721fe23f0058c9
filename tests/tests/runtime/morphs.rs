//! Tests of morph targets on the GPU: a morphed model must look like a model that is stored in that shape.

#![allow(clippy::unwrap_used, reason = "tests")]

use pelage_runtime::formats::meaning::morphed;
use pelage_runtime::formats::{
    Interpolation, Limits, MorphChannel, MorphDelta, MorphMotion, MorphTarget, Morphs, Package, PackageWriter,
};
use pelage_runtime::glam::Vec3;
use pelage_runtime::{
    Camera, FrameParams, Instance, Motion, PassId, Renderer, RendererOptions, RuntimeError, SelfShadow,
};
use pelage_tests::gpu::gpu;
use pelage_tests::pictures::{difference, draw};
use pelage_tests::support::sphere::{SphereParams, package};

/// Returns a sphere with two morph targets: "long" moves the upper part upwards, "nose" pushes a bump to the right.
fn sphere() -> (Vec<u8>, Morphs) {
    let bytes = package(&SphereParams {
        quads: 12,
        texels: 32,
        strands: 90,
        tiles: 4,
        skeleton: true,
        ..SphereParams::default()
    });
    let opened = Package::open(&bytes, &Limits::default()).unwrap();
    let target = |name: &str| MorphTarget { name: name.into(), node: 0, weight: 0.0 };
    let channel = MorphChannel {
        clip: 0,
        target: 0,
        count: 2,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0],
        values: vec![0.0, 0.0, 1.0, 0.5],
    };
    let targets = vec![target("long"), target("nose")];
    let mut morphs =
        Morphs { motion: MorphMotion { targets, channels: vec![channel] }, first: vec![0], deltas: Vec::new() };
    for vertex in opened.mesh().unwrap().unwrap().geometry() {
        let [x, y, _] = vertex.position;
        let [tx, ty, _, _] = vertex.tangent;
        if y > 0.0 {
            let delta = MorphDelta {
                target: 0,
                position: [0.0, 0.8 * y, 0.0],
                normal: [0.0, -0.2, 0.0],
                tangent: [0.0, 0.8 * ty, 0.0],
            };
            morphs.deltas.push(delta);
        }
        if x > 0.04 {
            let push = 2.0 * (x - 0.04);
            let delta = MorphDelta {
                target: 1,
                position: [push, 0.0, 0.0],
                normal: [-0.1, 0.0, 0.0],
                tangent: [2.0 * tx, 0.0, 0.0],
            };
            morphs.deltas.push(delta);
        }
        morphs.first.push(morphs.deltas.len() as u32);
    }
    (bytes, morphs)
}

/// Returns the package with morph targets. If `shifts` is given, no targets are added. Instead, the vertices are moved
/// as the targets would move them with these weights.
fn with_morphs(bytes: &[u8], morphs: &Morphs, shifts: Option<&[f32]>) -> Vec<u8> {
    let package = Package::open(bytes, &Limits::default()).unwrap();
    let mut mesh = package.mesh().unwrap().unwrap().to_data();
    if let Some(shifts) = shifts {
        for (v, vertex) in mesh.geometry.iter_mut().enumerate() {
            *vertex = morphed(vertex, morphs.of_vertex(v), shifts);
            let [x, y, z, w] = vertex.tangent;
            vertex.tangent = Vec3::new(x, y, z).normalize().extend(w).into();
        }
    }
    let writer =
        PackageWriter::new(package.manifest().clone()).mesh(&mesh).animation(&package.animation().unwrap().unwrap());
    let writer = if shifts.is_none() { writer.morphs(morphs) } else { writer };
    let textures = 0..package.manifest().textures.len() as u32;
    textures.fold(writer, |writer, i| writer.texture(package.texture(i).unwrap().ktx2)).finish().unwrap()
}

/// Returns a view without shadows. Shadow maps are fitted to the model's bounds, and bounds of joints and targets are
/// looser than those of vertices.
fn front() -> FrameParams {
    let params = FrameParams::new(Camera::framing(Vec3::ZERO, 0.2, Vec3::new(-0.3, 0.35, 1.0), 0.6, 1.0), [128, 128]);
    params.with(|p| p.soft_shadow = false).with_fur(|fur| fur.self_shadow = SelfShadow::Off)
}

#[test]
fn morphed_model_equals_a_model_of_that_shape() {
    let Some(gpu) = gpu("morphed_model_equals_a_model_of_that_shape") else { return };
    let (bytes, morphs) = sphere();
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let model = renderer.load_bytes(&with_morphs(&bytes, &morphs, None)).unwrap();
    assert_eq!((model.morph_index("nose"), model.morph_index("tail")), (Some(1), None));
    let mut picture = |instance: &Instance| draw(gpu, &mut renderer, &front(), &[instance]);
    let rest = picture(&Instance::new(1, &model));
    let cases = [
        (Instance::new(1, &model).morphing(vec![(0, 1.0), (1, 0.5)]), [1.0, 0.5]),
        (Instance::new(1, &model).moving(Motion::Clip { clip: 0, time_s: 1.0 }), [1.0, 0.5]),
        // The application's weights must override those of the clip.
        (
            Instance::new(1, &model).moving(Motion::Clip { clip: 0, time_s: 1.0 }).morphing(vec![(0, 0.0), (0, 0.25)]),
            [0.25, 0.5],
        ),
    ];
    for (number, (instance, shifts)) in cases.into_iter().enumerate() {
        let found = picture(&instance);
        let stored = with_morphs(&bytes, &morphs, Some(&shifts));
        let mut other = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
        let mut still = Instance::new(2, &other.load_bytes(&stored).unwrap());
        still.motion = instance.motion.clone();
        let expected = draw(gpu, &mut other, &front(), &[&still]);
        let (off, moved) = (difference(&found, &expected), difference(&found, &rest));
        assert!(
            off.mean < 0.02 && moved.mean > 20.0 * off.mean.max(0.02),
            "case {number}: {off:?}, against rest {moved:?}"
        );
    }
    // At rest, the picture must be the same as before the instance was morphed. A frame identical to the last must pose
    // nothing.
    assert_eq!(difference(&picture(&Instance::new(1, &model)), &rest).mean, 0.0);
    let mut posed = |instance: &Instance| {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let frame = renderer.prepare(&mut encoder, &front(), [instance]).unwrap();
        gpu.queue.submit([encoder.finish()]);
        frame.report().passes.iter().find(|p| p.name == PassId::POSE.name()).unwrap().ran
    };
    assert!(!posed(&Instance::new(1, &model)));
    assert!(posed(&Instance::new(1, &model).morphing(vec![(1, 0.5)])));
    assert!(!posed(&Instance::new(1, &model).morphing(vec![(1, 0.5)])));
}

#[test]
fn invalid_morph_weights_are_refused() {
    let Some(gpu) = gpu("invalid_morph_weights_are_refused") else { return };
    let (bytes, morphs) = sphere();
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let model = renderer.load_bytes(&with_morphs(&bytes, &morphs, None)).unwrap();
    for morph in [(2, 0.5), (0, f32::NAN)] {
        let instance = Instance::new(1, &model).morphing(vec![morph]);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let refused = renderer.prepare(&mut encoder, &front(), [&instance]).err();
        assert!(matches!(refused, Some(RuntimeError::Params { field: "Instance::morphs", .. })), "{refused:?}");
    }
}
