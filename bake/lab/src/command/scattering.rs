//! `pelage chart scattering`: scattering of a fibre as frames evaluate it, compared with its equations.

use super::driver::{Plan, PlannedRow, Topic, get_or_make};
use crate::chart::Cell;
use crate::chart::scattering::{
    COLUMNS, FIBRES, PAIRS, PANELS, ScatteringConfiguration, ScatteringForm, ScatteringTruth, cells, configurations,
    measure,
};
use pelage_runtime::shared::scattering;
use pelage_runtime::wgpu;
use pelage_stage::{Gpu, StageError};
use pelage_tool::exit::Failure;
use pelage_tool::machine::measured_on;
use std::time::Instant;
use wgpu::util::DeviceExt as _;

/// Number of threads per dispatch.
const THREADS: u32 = 1 << 16;
/// Number of evaluations per thread.
const EACH: u32 = 64;
/// Number of timed runs, of which the fastest counts.
const TURNS: usize = 7;
/// Number of dispatches per run, large enough that the cost of submission is negligible.
const AT_ONCE: u32 = 4;

/// Topic `scattering`.
pub struct ScatteringTopic {
    configurations: Vec<ScatteringConfiguration>,
    gpu: Gpu,
    truths: Option<Vec<ScatteringTruth>>,
    /// Nanoseconds of the loop without the code to be timed.
    empty: Option<f64>,
}

impl ScatteringTopic {
    /// Lists the configurations and opens the adapter.
    pub fn new() -> Result<Self, Failure> {
        Ok(Self { configurations: configurations(), gpu: Gpu::open()?, truths: None, empty: None })
    }
}

impl Topic for ScatteringTopic {
    fn plan(&self) -> Plan {
        let row = |c: &ScatteringConfiguration| PlannedRow {
            series: c.series.into(),
            label: c.form.size().map_or_else(String::new, |size| format!("{size}x{size}")),
            default: c.form.is_default(),
            command: None,
        };
        Plan {
            topic: "scattering",
            title: format!("Scattering by five fibres, {PAIRS} pairs of directions each, against the exact equations"),
            adapter: measured_on(&self.gpu.info.name),
            columns: COLUMNS.to_vec(),
            panels: PANELS.to_vec(),
            rows: self.configurations.iter().map(row).collect(),
        }
    }

    fn measure(&mut self, index: usize, doing: &mut dyn FnMut(&str)) -> Result<Vec<Cell>, Failure> {
        let form = self.configurations[index].form;
        let truths = get_or_make(&mut self.truths, || {
            doing("equations");
            Ok::<_, Failure>(FIBRES.iter().map(|optics| ScatteringTruth::new(optics, PAIRS)).collect())
        })?;
        doing("comparing");
        let off = measure(form, truths);
        doing("timing");
        let gpu = &self.gpu;
        let empty = *get_or_make(&mut self.empty, || nanoseconds(gpu, EMPTY, 2))?;
        let timed = expression(form).map(|body| nanoseconds(gpu, body, form.size().unwrap_or(2))).transpose()?;
        Ok(cells(form, &off, timed.map(|ns| (ns - empty).max(0.0))))
    }
}

/// Returns the code that a thread runs per pair of directions; `None` for a method that is not used for drawing.
fn expression(form: ScatteringForm) -> Option<&'static str> {
    match form {
        ScatteringForm::Tables(_) => Some(TABLES),
        ScatteringForm::Cubic(_) => Some(CUBIC),
        ScatteringForm::Fit => Some(FIT),
        ScatteringForm::CosPhi(_)
        | ScatteringForm::EvenLengths(_)
        | ScatteringForm::AllLengths(_)
        | ScatteringForm::Printed(_) => None,
    }
}

const EMPTY: &str = "sum += light * eye;";

const TABLES: &str = "
    let angles = fibre_angles(tip, light, eye);
    let absorbed = fibre_absorption(color, 0.17);
    let left = fibre_transmittance(angles.cos_d, vec4(0.42, 0.0, 0.45, 0.0), absorbed);
    sum += fibre_scatters(texel(angles.along, 0u), texel(angles.around, 1u), absorbed, left);
";

const CUBIC: &str = "
    let angles = fibre_angles(tip, light, eye);
    let absorbed = fibre_absorption(color, 0.17);
    let left = fibre_transmittance(angles.cos_d, vec4(0.42, 0.0, 0.45, 0.0), absorbed);
    sum += fibre_scatters(cubic(angles.along, 0u), cubic(angles.around, 1u), absorbed, left);
";

const FIT: &str = "
    let absorbed = fibre_absorption(color, 0.17);
    sum += fit(tip, light, eye, absorbed);
";

/// WGSL of the methods: tables, cubic interpolation of their texels by five bilinear samples, and the fit of `fit` in
/// the chart.
const FORMS: &str = "
@group(0) @binding(0) var<storage, read_write> sums: array<vec4<f32>>;
@group(0) @binding(1) var tables: texture_2d_array<f32>;
@group(0) @binding(2) var linear: sampler;

fn texel(place: vec2<f32>, layer: u32) -> vec4<f32> {
    let size = f32(textureDimensions(tables).x);
    return textureSampleLevel(tables, linear, (place * (size - 1.0) + 0.5) / size, layer, 0.0);
}

fn cubic(place: vec2<f32>, layer: u32) -> vec4<f32> {
    let size = f32(textureDimensions(tables).x);
    let at = place * (size - 1.0);
    let below = floor(at);
    let t = at - below;
    let w0 = t * (-0.5 + t * (1.0 - 0.5 * t));
    let w1 = 1.0 + t * t * (-2.5 + 1.5 * t);
    let w2 = t * (0.5 + t * (2.0 - 1.5 * t));
    let w3 = t * t * (-0.5 + 0.5 * t);
    let near = w1 + w2;
    let middle = (below + 0.5 + w2 / near) / size;
    let low = (below - 0.5) / size;
    let high = (below + 2.5) / size;
    return near.x * near.y * textureSampleLevel(tables, linear, middle, layer, 0.0)
        + w0.x * near.y * textureSampleLevel(tables, linear, vec2(low.x, middle.y), layer, 0.0)
        + w3.x * near.y * textureSampleLevel(tables, linear, vec2(high.x, middle.y), layer, 0.0)
        + w0.y * near.x * textureSampleLevel(tables, linear, vec2(middle.x, low.y), layer, 0.0)
        + w3.y * near.x * textureSampleLevel(tables, linear, vec2(middle.x, high.y), layer, 0.0);
}

fn schlick(cosine: f32) -> f32 {
    let c = 1.0 - clamp(cosine, 0.0, 1.0);
    return 0.0465 + 0.9535 * c * c * c * c * c;
}

fn lobe(width: f32, off: f32) -> f32 {
    return exp(-0.5 * off * off / (width * width)) / (2.5066283 * width);
}

fn fit(tip: vec3<f32>, light: vec3<f32>, eye: vec3<f32>, absorbed: vec3<f32>) -> vec3<f32> {
    let sin_i = dot(tip, light);
    let sin_o = dot(tip, eye);
    let cos_i = sqrt(max(1.0 - sin_i * sin_i, 0.0));
    let cos_o = sqrt(max(1.0 - sin_o * sin_o, 0.0));
    let cos_d = max(sqrt(max(0.5 * (1.0 + cos_i * cos_o + sin_i * sin_o), 0.0)), 0.1);
    let cos_phi = clamp((dot(light, eye) - sin_i * sin_o) / max(cos_i * cos_o, 1e-6), -1.0, 1.0);
    let half_phi = sqrt(0.5 + 0.5 * cos_phi);
    let across = 1.19 / cos_d + 0.36 * cos_d;
    let off = sin_i + sin_o;
    let r = lobe(0.26 * 1.41421356 * max(half_phi, 0.05), off + 0.1) * 0.25 * half_phi \
        * schlick(sqrt(0.5 + 0.5 * dot(light, eye)));
    let offset = half_phi * (1.0 + (0.6 - 0.8 * cos_phi) / across);
    let f = 1.0 - schlick(cos_d * sqrt(max(1.0 - offset * offset, 0.0)));
    let tt = lobe(0.13, off - 0.05) * f * f * exp(-3.65 * cos_phi - 3.98);
    let ratio = offset / across;
    let chord = sqrt(max(1.0 - ratio * ratio, 0.0)) * 2.0 / cos_d;
    let g = schlick(0.5 * cos_d);
    let trt = lobe(0.52, off - 0.15) * (1.0 - g) * (1.0 - g) * g * exp(17.0 * cos_phi - 16.78);
    return (r + tt * exp(-absorbed * chord) + trt * exp(-absorbed * (3.2 / cos_d))) * (cos_i / cos_d);
}

fn direction(seed: u32) -> vec3<f32> {
    let mixed = (seed ^ (seed >> 15u)) * 0x2c1b3c6du;
    let again = (mixed ^ (mixed >> 12u)) * 0x297a2d39u;
    let z = f32(again & 0xffffu) / 32767.5 - 1.0;
    let turn = f32(again >> 16u) * 9.5873799e-5;
    let wide = sqrt(max(1.0 - z * z, 0.0));
    return vec3(wide * cos(turn), wide * sin(turn), z);
}
";

/// Returns the mean nanoseconds of one evaluation on the adapter.
fn nanoseconds(gpu: &Gpu, body: &str, size: usize) -> Result<f64, Failure> {
    let source = format!(
        "{}{FORMS}
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
    let tip = direction(id.x);
    let color = 0.5 + 0.4 * tip;
    var sum = vec3(0.0);
    for (var i = 0u; i < {EACH}u; i++) {{
        let light = direction(id.x * 977u + i);
        let eye = direction(id.x * 1259u + 7919u * i);
{body}
    }}
    sums[id.x] = vec4(sum, 1.0);
}}
",
        scattering::WGSL
    );
    let device = &gpu.device;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("chart scattering"),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let entry =
        |binding, ty| wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::COMPUTE, ty, count: None };
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[
            entry(
                0,
                wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only: false },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
            ),
            entry(
                1,
                wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: true },
                    view_dimension: wgpu::TextureViewDimension::D2Array,
                    multisampled: false,
                },
            ),
            entry(2, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
        ],
    });
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        bind_group_layouts: &[Some(&layout)],
        ..Default::default()
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: Some(&pipeline_layout),
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });
    let sums = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 16 * u64::from(THREADS),
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    });
    let side = size as u32;
    let texture = device.create_texture_with_data(
        &gpu.queue,
        &wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 2 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba16Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        wgpu::util::TextureDataOrder::LayerMajor,
        // Each component is the half float 0.5.
        &[0x00, 0x38].repeat(8 * size * size),
    );
    let view = texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    });
    let linear = device.create_sampler(&wgpu::SamplerDescriptor {
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &layout,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: sums.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&view) },
            wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::Sampler(&linear) },
        ],
    });
    let mut fastest = f64::INFINITY;
    for _ in 0..TURNS {
        let mut encoder = device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            for _ in 0..AT_ONCE {
                pass.dispatch_workgroups(THREADS / 64, 1, 1);
            }
        }
        let begun = Instant::now();
        gpu.queue.submit([encoder.finish()]);
        let lost = |error| StageError::Device(format!("{error}"));
        device.poll(wgpu::PollType::wait_indefinitely()).map_err(lost)?;
        fastest = fastest.min(begun.elapsed().as_secs_f64());
    }
    Ok(fastest * 1e9 / (f64::from(THREADS) * f64::from(EACH) * f64::from(AT_ONCE)))
}
