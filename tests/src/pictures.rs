//! Draws test pictures and compares them with stored pictures.

use crate::silhouette::half_to_f32;
use pelage_runtime::formats::meaning::{linear_to_srgb, srgb_to_linear};
use pelage_runtime::{FrameParams, Instance, PassId, Renderer, wgpu};
use pelage_stage::{Canvas, Gpu};
use std::path::{Path, PathBuf};

/// Picture of RGBA8 texels, row-major from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width and height, pixels.
    pub size: (u32, u32),
    /// `width * height` texels.
    pub rgba: Vec<[u8; 4]>,
}

impl Picture {
    /// Returns the number of texels with alpha above 0.
    pub fn covered(&self) -> usize {
        self.rgba.iter().filter(|p| p[3] > 0).count()
    }

    /// Returns the mean of one channel, 0..=255.
    pub fn mean(&self, channel: usize) -> f64 {
        self.rgba.iter().map(|p| f64::from(p[channel])).sum::<f64>() / self.rgba.len() as f64
    }

    /// Returns the picture reduced by averaging blocks of `by`×`by` texels in linear light. `by` must divide both
    /// sides.
    pub fn shrunk(&self, by: u32) -> Self {
        let (width, height) = (self.size.0 / by, self.size.1 / by);
        let share = 1.0 / (by * by) as f32;
        let texel = |x: u32, y: u32| {
            let block = (0..by * by).map(|i| ((y * by + i / by) * self.size.0 + x * by + i % by) as usize);
            let of_block: Vec<[u8; 4]> = block.map(|i| self.rgba[i]).collect();
            let mean = |value: &dyn Fn(&[u8; 4]) -> f32| share * of_block.iter().map(value).sum::<f32>();
            let [r, g, b] = [0, 1, 2].map(|c| linear_to_srgb(mean(&|p| srgb_to_linear(p[c]))));
            [r, g, b, mean(&|p| f32::from(p[3])).round() as u8]
        };
        let rgba = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect();
        Self { size: (width, height), rgba }
    }

    /// Writes a PNG, and creates its folder.
    pub fn save(&self, path: &Path) {
        std::fs::create_dir_all(path.parent().expect("a file has a folder")).expect("the folder can be made");
        let (width, height) = self.size;
        image::save_buffer(path, self.rgba.as_flattened(), width, height, image::ColorType::Rgba8)
            .unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    }
}

/// Draws instances with all passes over transparent black. The picture has the size of the frame's viewport.
pub fn draw(gpu: &Gpu, renderer: &mut Renderer, params: &FrameParams, instances: &[&Instance]) -> Picture {
    let passes: Vec<PassId> = PassId::all().collect();
    let bytes = draw_passes(gpu, renderer, params, instances, &passes);
    Picture { size: params.viewport.into(), rgba: bytes.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect() }
}

/// Draws the given passes over transparent black. The texels have the renderer's colour format.
pub fn draw_passes(
    gpu: &Gpu,
    renderer: &mut Renderer,
    params: &FrameParams,
    instances: &[&Instance],
    passes: &[PassId],
) -> Vec<u8> {
    let targets = Canvas::new(gpu, params.viewport.into(), &renderer.options().into());
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let frame =
        renderer.prepare(&mut encoder, params, instances.iter().copied()).unwrap_or_else(|e| panic!("prepare: {e}"));
    let mut pass = targets.pass(&mut encoder, "application", Some(wgpu::Color::TRANSPARENT));
    passes.iter().for_each(|id| frame.draw_pass(*id, &mut pass));
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    targets.texels(gpu).expect("the device answers")
}

/// Pipeline statistics of a render pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PipelineStatistics {
    /// Number of vertex shader invocations.
    pub vertices: u64,
    /// Number of fragment shader invocations.
    pub fragments: u64,
}

/// Begins the application's render pass, draws in it, submits everything, and returns the statistics of the pass. The
/// device must have `PIPELINE_STATISTICS_QUERY`.
pub fn draw_with_statistics(
    gpu: &Gpu,
    targets: &Canvas,
    mut encoder: wgpu::CommandEncoder,
    draw: impl FnOnce(&mut wgpu::RenderPass<'_>),
) -> PipelineStatistics {
    let types = wgpu::PipelineStatisticsTypes::VERTEX_SHADER_INVOCATIONS
        | wgpu::PipelineStatisticsTypes::FRAGMENT_SHADER_INVOCATIONS;
    let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
        label: None,
        ty: wgpu::QueryType::PipelineStatistics(types),
        count: 1,
    });
    let buffer = |usage| {
        let descriptor = wgpu::BufferDescriptor { label: None, size: 16, usage, mapped_at_creation: false };
        gpu.device.create_buffer(&descriptor)
    };
    let resolved = buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC);
    let read = buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ);
    let mut pass = targets.pass(&mut encoder, "application", Some(wgpu::Color::TRANSPARENT));
    pass.begin_pipeline_statistics_query(&queries, 0);
    draw(&mut pass);
    pass.end_pipeline_statistics_query();
    drop(pass);
    encoder.resolve_query_set(&queries, 0..1, &resolved, 0);
    encoder.copy_buffer_to_buffer(&resolved, 0, &read, 0, 16);
    gpu.queue.submit([encoder.finish()]);
    let counts: Vec<u64> =
        gpu.read_buffer(&read).expect("the device answers").chunks_exact(8).map(bytemuck::pod_read_unaligned).collect();
    PipelineStatistics { vertices: counts[0], fragments: counts[1] }
}

/// Difference of two pictures.
#[derive(Clone, Copy, Debug)]
pub struct PictureDifference {
    /// Mean absolute difference over all channels, 0..=255.
    pub mean: f64,
    /// Share of texels in which a channel differs by more than 16.
    pub share: f64,
}

/// Compares two pictures of the same size.
pub fn difference(a: &Picture, b: &Picture) -> PictureDifference {
    assert_eq!(a.size, b.size, "pictures of different sizes");
    let mut sum = 0.0;
    let mut off = 0;
    for (p, q) in a.rgba.iter().zip(&b.rgba) {
        let d: Vec<u8> = p.iter().zip(q).map(|(x, y)| x.abs_diff(*y)).collect();
        sum += d.iter().map(|v| f64::from(*v)).sum::<f64>();
        off += usize::from(d.iter().any(|v| *v > 16));
    }
    PictureDifference { mean: sum / (4 * a.rgba.len()) as f64, share: off as f64 / a.rgba.len() as f64 }
}

/// Returns the path of the stored picture with the given name.
pub fn golden_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("golden").join(format!("{name}.png"))
}

/// Compares a picture with the stored picture `golden/NAME.png`, which has at most 64 KiB. `Err` describes the
/// difference; the actual picture, the expected picture and the difference are then in `target/golden/`.
///
/// A stored picture is written only with `PELAGE_WRITE_GOLDEN=1`. Otherwise it is an error if it is missing,
/// unreadable, or of another size.
///
/// The mean difference may be at most 0.5 of 255, and at most 0.5 % of the texels may differ by more than 16. This
/// allows for different rounding in another version of the rasteriser, but not for fur that moved by a pixel.
pub fn compare_golden(name: &str, actual: &Picture) -> Result<(), String> {
    let path = golden_path(name);
    if std::env::var("PELAGE_WRITE_GOLDEN").is_ok_and(|v| v == "1") {
        actual.save(&path);
    }
    let file = std::fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    if file.len() > 64 << 10 {
        return Err(format!("{}: {} bytes, expected at most 65536", path.display(), file.len()));
    }
    let decoded = image::load_from_memory(&file).map_err(|e| format!("{}: {e}", path.display()))?.into_rgba8();
    let expected = Picture { size: decoded.dimensions(), rgba: decoded.pixels().map(|p| p.0).collect() };
    if expected.size != actual.size {
        return Err(format!("{}: {:?} pixels, expected {:?}", path.display(), expected.size, actual.size));
    }
    let found = difference(actual, &expected);
    if found.mean <= 0.5 && found.share <= 0.005 {
        return Ok(());
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/golden");
    let apart = |(p, q): (&[u8; 4], &[u8; 4])| {
        let d: Vec<u8> = p.iter().zip(q).map(|(x, y)| x.abs_diff(*y).saturating_mul(4)).collect();
        [d[0].max(d[3]), d[1].max(d[3]), d[2].max(d[3]), 255]
    };
    let map = Picture { size: actual.size, rgba: actual.rgba.iter().zip(&expected.rgba).map(apart).collect() };
    for (suffix, picture) in [("actual", actual), ("expected", &expected), ("difference", &map)] {
        picture.save(&folder.join(format!("{name}.{suffix}.png")));
    }
    Err(format!("{name} differs from its golden: {found:?}; see {}", folder.display()))
}

/// Reads one array layer of a shadow map, row-major from the top. Channels that its format lacks are 0.
///
/// Panics on formats that no shadow map has.
pub fn read_map(gpu: &Gpu, texture: &wgpu::Texture, layer: u32) -> Vec<[f32; 4]> {
    let half = |bytes: &[u8]| half_to_f32([bytes[0], bytes[1]]);
    let texels = gpu.read_texture(texture, layer).expect("the device answers");
    match texture.format() {
        wgpu::TextureFormat::R16Float => texels.chunks_exact(2).map(|t| [half(t), 0.0, 0.0, 0.0]).collect(),
        wgpu::TextureFormat::Rgba16Float => {
            texels.chunks_exact(8).map(|t| [half(t), half(&t[2..]), half(&t[4..]), half(&t[6..])]).collect()
        }
        wgpu::TextureFormat::Depth32Float => {
            texels.chunks_exact(4).map(|t| [bytemuck::pod_read_unaligned(t), 0.0, 0.0, 0.0]).collect()
        }
        other => panic!("found {other:?}, expected the format of a shadow map"),
    }
}
