//! Measures the cost of each pass on this machine. The baseline draws the same layers with one texture read and no
//! lighting.
//!
//! ```text
//! cargo run --release --example cost_of_passes -- [PACKAGE.pelage] [FRAMES]
//! ```
//!
//! Without a package (or with `-`) it uses a furry sphere of about 5 000 triangles and 16 layers. Times are medians
//! from submission until the GPU is finished. The variants alternate, so that a slow moment of the machine affects all
//! alike.
//!
//! Afterwards the example counts the fragments of each layer that another order of the layers could skip. These are
//! fragments without opacity, and fragments hidden by layers above that transmit at most 1/512 of their light. To skip
//! the latter, layers would be drawn from the outermost inwards with a mask of opaque pixels.

#![allow(clippy::unwrap_used, reason = "an example stops at the first surprise")]

#[path = "support/mod.rs"]
mod support;

use pelage_runtime::glam::Vec3;
use pelage_runtime::{Camera, FrameParams, Instance, PassId, Renderer, RendererOptions, wgpu};
use pelage_stage::{Canvas, Gpu};
use std::time::Instant;

const SIZE: (u32, u32) = (834, 424);

fn main() {
    let mut arguments = std::env::args().skip(1);
    let bytes = support::package_or_sphere(arguments.next().filter(|path| path != "-"));
    let frames = arguments.next().map_or(15, |n| n.parse().expect("FRAMES is a whole number"));

    let gpu = Gpu::with(wgpu::Features::TEXTURE_COMPRESSION_BC, Some(wgpu::Limits::default())).unwrap();
    let options = RendererOptions::default();
    let targets = Canvas::new(&gpu, SIZE, &(&options).into());
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options).unwrap();
    let started = Instant::now();
    let model = renderer.load_bytes(&bytes).unwrap();
    gpu.queue.submit([]);
    gpu.wait().unwrap();
    println!("{}: load {:.1} ms, {} bytes", gpu.info.name, started.elapsed().as_secs_f64() * 1e3, model.gpu_bytes());

    let manifest = model.manifest();
    let (center, radius) = (manifest.bounds.center.into(), manifest.bounds.radius + manifest.fur.height_m);
    let aspect = SIZE.0 as f32 / SIZE.1 as f32;
    // The camera is so close that the outer layer fills about two thirds of the frame.
    let camera = Camera::framing(center, radius * 0.72, Vec3::new(-0.4, 0.3, 1.0), 0.6, aspect);
    let instance = Instance::new(0, &model);
    let mut params = FrameParams::new(camera, SIZE.into());

    let variants = [("skin", false, false), ("shells", true, false), ("yardstick", true, true)];
    let mut times = [const { Vec::new() }; 3];
    for frame_number in 0..=frames {
        for ((_, with_shells, yardstick), times) in variants.iter().zip(&mut times) {
            params.debug.yardstick = *yardstick;
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            let frame = renderer.prepare(&mut encoder, &params, [&instance]).unwrap();
            let mut pass = targets.pass(&mut encoder, "application", Some(wgpu::Color::TRANSPARENT));
            frame.draw_pass(PassId::SKIN, &mut pass);
            if *with_shells {
                frame.draw_pass(PassId::SHELLS, &mut pass);
            }
            drop(pass);
            let commands = encoder.finish();
            let started = Instant::now();
            gpu.queue.submit([commands]);
            gpu.wait().unwrap();
            // The first round is discarded: it compiles pipelines and warms up.
            if frame_number > 0 {
                times.push(started.elapsed().as_secs_f64() * 1e3);
            }
        }
    }
    let covered = targets.texels(&gpu).unwrap().chunks_exact(4).filter(|p| p[3] > 0).count();
    let share = 100.0 * covered as f64 / f64::from(SIZE.0 * SIZE.1);
    let medians = times.map(|mut t| {
        t.sort_by(f64::total_cmp);
        t[t.len() / 2]
    });
    println!("{} triangles, {} layers, {share:.0} % of the frame", triangles(manifest), manifest.fur.layers);
    for ((name, ..), median) in variants.iter().zip(medians) {
        let what = if *name == "skin" { "skin".into() } else { format!("skin and {name}") };
        println!("{what}: {median:.2} ms");
    }
    let [skin, shells, yardstick] = medians;
    println!("shells / yardstick: {:.2}", (shells - skin) / (yardstick - skin));

    let counts = count(&gpu, &targets, &mut renderer, &instance, &mut params);
    let share = |n: u64| 100.0 * n as f64 / counts.fragments as f64;
    println!(
        "{} fragments, of which {:.1} % have no opacity and {:.2} % are hidden by the layers above",
        counts.fragments,
        share(counts.empty),
        share(counts.hidden)
    );
}

/// Counts of shell fragments that passed the depth test.
#[derive(Default)]
struct Counts {
    fragments: u64,
    empty: u64,
    hidden: u64,
}

fn count(
    gpu: &Gpu,
    targets: &Canvas,
    renderer: &mut Renderer,
    instance: &Instance,
    params: &mut FrameParams,
) -> Counts {
    let set = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
        label: None,
        ty: wgpu::QueryType::Occlusion,
        count: 1,
    });
    let buffer = |usage| {
        let descriptor = wgpu::BufferDescriptor { label: None, size: 8, usage, mapped_at_creation: false };
        gpu.device.create_buffer(&descriptor)
    };
    let resolved = buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC);
    let layers = instance.model.manifest().fur.layers;
    let mut counts = Counts::default();
    let mut through = vec![1.0f64; SIZE.0 as usize * SIZE.1 as usize];
    // The yardstick shader writes the texels of a layer unchanged.
    params.debug.yardstick = true;
    for layer in (1..layers).rev() {
        params.debug.only_layer = Some(layer);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let frame = renderer.prepare(&mut encoder, params, [instance]).unwrap();
        frame.draw_pass(PassId::SKIN, &mut targets.pass(&mut encoder, "application", Some(wgpu::Color::TRANSPARENT)));
        let mut pass = targets.count_behind(&mut encoder, &set);
        pass.begin_occlusion_query(0);
        frame.draw_pass(PassId::SHELLS, &mut pass);
        pass.end_occlusion_query();
        drop(pass);
        let staging = buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ);
        encoder.resolve_query_set(&set, 0..1, &resolved, 0);
        encoder.copy_buffer_to_buffer(&resolved, 0, &staging, 0, 8);
        gpu.queue.submit([encoder.finish()]);
        let fragments = u64::from_le_bytes(gpu.read_buffer(&staging).unwrap().try_into().unwrap());
        let mut seen = 0;
        for (through, texel) in through.iter_mut().zip(targets.texels(gpu).unwrap().chunks_exact(4)) {
            // Opacities below half an 8-bit step are stored as 0, and the shells skip them.
            if texel[3] > 0 {
                seen += 1;
                counts.hidden += u64::from(*through <= 1.0 / 512.0);
                *through *= 1.0 - f64::from(texel[3]) / 255.0;
            }
        }
        counts.fragments += fragments;
        counts.empty += fragments.saturating_sub(seen);
    }
    counts
}

fn triangles(manifest: &pelage_runtime::formats::Manifest) -> u32 {
    manifest.parts.iter().map(|p| p.index_count / 3).sum()
}
