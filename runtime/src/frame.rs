//! One frame, in the order in which its passes run:
//!
//! | pass | recorded by | draws | when |
//! |---|---|---|---|
//! | `pose` | [`crate::Renderer::prepare`] | compute: posed vertices | an instance's pose changed |
//! | `skin` | [`Frame::draw`] | opaque base mesh, depth written | always |
//! | `fins` | [`Frame::draw`] | quads of hair along the outline | fur visible, package has fins |
//! | `shells` | [`Frame::draw`] | layers of hair, inside to outside | fur visible |

use crate::passes::fins::{self, FinDraws};
use crate::passes::surface::Look;
use crate::passes::{PassId, pose, shells, skin};
use crate::renderer::Pipelines;
use crate::shared::{frame as blocks, kajiya_kay, skinning};
use crate::{FrameParams, Instance, Model, RuntimeError, Style};
use glam::{Mat3, Mat4, Vec3};
use pelage_formats::Shading;
use wgpu::util::DeviceExt;

/// A prepared frame: everything that [`Frame::draw`] needs, held until it is dropped.
#[derive(Debug)]
pub struct Frame {
    bind_group: wgpu::BindGroup,
    instances: Vec<Drawn>,
    report: FrameReport,
}

/// What one instance draws.
#[derive(Debug)]
pub(crate) struct Drawn {
    pub(crate) model: Model,
    geometry: wgpu::Buffer,
    uniform_offset: u32,
    /// One pipeline for each of the model's parts.
    pub(crate) skin: Vec<wgpu::RenderPipeline>,
    /// Numbers and pipelines of the furred parts.
    pub(crate) shells: Vec<(usize, wgpu::RenderPipeline)>,
    /// What it draws of its fins.
    fins: Option<FinDraws>,
    /// Layers, skin counted.
    pub(crate) layers: u32,
}

/// Which passes ran, and why the others did not.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FrameReport {
    /// One entry per pass, in order.
    pub passes: Vec<PassReport>,
}

/// What became of one pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PassReport {
    /// Name of the pass: [`PassId::name`].
    pub name: &'static str,
    /// Whether it does anything in this frame.
    pub ran: bool,
    /// What it does, or why nothing.
    pub reason: String,
}

impl PassReport {
    pub(crate) fn ran(name: &'static str, reason: impl Into<String>) -> Self {
        Self { name, ran: true, reason: reason.into() }
    }

    pub(crate) fn skipped(name: &'static str, reason: impl Into<String>) -> Self {
        Self { name, ran: false, reason: reason.into() }
    }
}

pub(crate) fn prepare(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    pipelines: &mut Pipelines,
    params: &FrameParams,
    instances: &mut [&mut Instance],
) -> Result<Frame, RuntimeError> {
    params.check()?;
    instances.iter().try_for_each(|instance| instance.check())?;
    let (blocks, stride) = uniform_blocks(device, pipelines, params, instances)?;
    let posed = pose::record(device, encoder, pipelines, instances)?;

    let mut drawn = Vec::new();
    for (index, instance) in instances.iter().enumerate() {
        let layers = drawn_layers(instance.model(), params);
        let look = look(instance.model(), params, instance.transform);
        drawn.push(Drawn {
            model: instance.model().clone(),
            geometry: instance.geometry().clone(),
            uniform_offset: (index as u32 + 1) * stride,
            skin: skin::plan(device, pipelines, instance.model(), &look),
            shells: if layers > 1 { shells::plan(device, pipelines, instance.model(), &look) } else { Vec::new() },
            fins: if look.fins { fins::draws(device, pipelines, instance, &look) } else { None },
            layers,
        });
    }
    let report = FrameReport {
        passes: vec![posed, report_skin(&drawn), report_fins(&drawn, params), report_shells(&drawn, params)],
    };

    let buffer = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("pelage frame"),
        contents: &blocks,
        usage: wgpu::BufferUsages::UNIFORM,
    });
    let block = |binding, size| wgpu::BindGroupEntry {
        binding,
        resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &buffer,
            offset: 0,
            size: std::num::NonZeroU64::new(size as u64),
        }),
    };
    let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("pelage frame"),
        layout: &pipelines.layouts.frame,
        entries: &[block(0, size_of::<blocks::Frame>()), block(1, size_of::<blocks::Instance>())],
    });
    Ok(Frame { bind_group, instances: drawn, report })
}

impl Frame {
    /// Records every pass into the application's render pass, whose targets must be as [`crate::RendererOptions`] said. Leaves
    /// pipeline, bind groups 0..=3, vertex buffers 0 and 1 and the index buffer changed.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        self.draw_pass(PassId::Skin, pass);
        self.draw_pass(PassId::Fins, pass);
        self.draw_pass(PassId::Shells, pass);
    }

    /// Records one pass alone, for measuring, or for drawing between skin and shells. [`PassId::Pose`] was recorded by
    /// [`crate::Renderer::prepare`] and does nothing here.
    pub fn draw_pass(&self, id: PassId, pass: &mut wgpu::RenderPass<'_>) {
        for instance in &self.instances {
            let empty = match id {
                PassId::Pose => true,
                PassId::Skin => instance.skin.is_empty(),
                PassId::Fins => instance.fins.is_none(),
                PassId::Shells => instance.shells.is_empty(),
            };
            if empty {
                continue;
            }
            pass.set_bind_group(0, &self.bind_group, &[instance.uniform_offset]);
            pass.set_bind_group(2, instance.model.fur(), &[]);
            pass.set_vertex_buffer(0, instance.geometry.slice(..));
            pass.set_vertex_buffer(1, instance.model.attributes().slice(..));
            pass.set_index_buffer(instance.model.indices().slice(..), wgpu::IndexFormat::Uint32);
            match id {
                PassId::Pose => {}
                PassId::Skin => skin::record(pass, instance),
                PassId::Fins => instance.fins.iter().for_each(|fins| fins::record(pass, &instance.model, fins)),
                PassId::Shells => shells::record(pass, instance),
            }
        }
    }

    /// Which passes run in this frame, and why the others do not.
    pub fn report(&self) -> &FrameReport {
        &self.report
    }
}

/// Compiles what a frame with these parameters needs.
pub(crate) fn compile(device: &wgpu::Device, pipelines: &mut Pipelines, model: &Model, params: &FrameParams) {
    let look = look(model, params, Mat4::IDENTITY);
    skin::plan(device, pipelines, model, &look);
    if drawn_layers(model, params) > 1 {
        shells::plan(device, pipelines, model, &look);
    }
    if look.fins {
        fins::plan(device, pipelines, model, &look);
    }
    if model.skeleton().is_some() {
        pipelines.pose(device);
    }
}

fn look(model: &Model, params: &FrameParams, transform: Mat4) -> Look {
    let manifest = model.manifest();
    Look {
        style: params.style,
        yardstick: params.yardstick,
        mirrored: skinning::handedness_of(Mat3::from_mat4(transform)) < 0.0,
        resampled: drawn_layers(model, params) != manifest.fur.layers,
        fins: params.fins && model.fins().is_some() && drawn_layers(model, params) > 1,
        shading: params.shading.unwrap_or(manifest.shading),
    }
}

/// Layers to draw of a model, skin counted; 1 where no fur shows.
fn drawn_layers(model: &Model, params: &FrameParams) -> u32 {
    let baked = model.manifest().fur.layers;
    if baked < 2 || params.style == Style::Bare {
        return 1;
    }
    params.layers.unwrap_or(baked)
}

fn report_skin(drawn: &[Drawn]) -> PassReport {
    let draws: usize = drawn.iter().map(|d| d.skin.len()).sum();
    if draws == 0 {
        return PassReport::skipped("skin", "no instances");
    }
    PassReport::ran("skin", format!("{} instances, {draws} parts", drawn.len()))
}

fn report_fins(drawn: &[Drawn], params: &FrameParams) -> PassReport {
    let with_fins = drawn.iter().filter(|d| d.fins.is_some());
    let fins: u32 = with_fins.clone().flat_map(|d| d.model.parts()).map(|part| part.fins.len() as u32).sum();
    if fins > 0 {
        return PassReport::ran("fins", format!("{} instances, {fins} edges", with_fins.count()));
    }
    PassReport::skipped(
        "fins",
        match (drawn.is_empty(), params.style, params.layers) {
            (true, ..) => "no instances",
            (_, Style::Bare, _) => "style is bare",
            (_, _, Some(1)) => "one layer is the skin alone",
            _ if !params.fins => "switched off",
            _ if drawn.iter().any(|d| d.model.manifest().fur.fins.is_some()) => {
                "no edges, or no storage buffers in vertex shaders"
            }
            _ => "no package has fins",
        },
    )
}

fn report_shells(drawn: &[Drawn], params: &FrameParams) -> PassReport {
    let furry = drawn.iter().filter(|d| !d.shells.is_empty());
    let layers: u32 = furry.clone().map(|d| d.layers - 1).sum();
    if layers > 0 {
        let how = if params.yardstick { ", yardstick: one read, no lighting" } else { "" };
        return PassReport::ran("shells", format!("{} instances, {layers} layers{how}", furry.count()));
    }
    PassReport::skipped(
        "shells",
        match (drawn.is_empty(), params.style, params.layers) {
            (true, ..) => "no instances",
            (_, Style::Bare, _) => "style is bare",
            (_, _, Some(1)) => "one layer is the skin alone",
            _ => "no package has fur",
        },
    )
}

/// The frame's block, then each instance's, `stride` bytes apart.
fn uniform_blocks(
    device: &wgpu::Device,
    pipelines: &Pipelines,
    params: &FrameParams,
    instances: &[&mut Instance],
) -> Result<(Vec<u8>, u32), RuntimeError> {
    let clip_from_view = params.camera.check(pipelines.reversed_depth())?;
    let frame = blocks::Frame {
        clip_from_world: (clip_from_view * params.camera.view_from_world).to_cols_array_2d(),
        eye_ws: params.camera.eye_ws(clip_from_view).to_array(),
        light_ws: params.light.homogeneous()?.to_array(),
    };
    let largest = size_of::<blocks::Frame>().max(size_of::<blocks::Instance>()) as u32;
    let stride = largest.next_multiple_of(device.limits().min_uniform_buffer_offset_alignment);
    let mut bytes = bytemuck::bytes_of(&frame).to_vec();
    for (index, instance) in instances.iter().enumerate() {
        bytes.resize((index + 1) * stride as usize, 0);
        bytes.extend_from_slice(bytemuck::bytes_of(&instance_block(instance, params)));
    }
    // A bind group without instances still covers one instance block.
    bytes.resize(bytes.len().max(2 * stride as usize), 0);
    Ok((bytes, stride))
}

fn instance_block(instance: &Instance, params: &FrameParams) -> blocks::Instance {
    let manifest = instance.model().manifest();
    let shading = params.shading.unwrap_or(manifest.shading);
    let linear = Mat3::from_mat4(instance.transform);
    let handedness = skinning::handedness_of(linear);
    let cofactor = |a: Vec3, b: Vec3| -> [f32; 4] { (a.cross(b) * handedness).extend(0.0).to_array() };
    let constant = |k: [f32; 3], light: Vec3| (Vec3::from(k) * light).to_array();
    let unit = Shading { specular: [1.0; 3], ..shading };
    let (baked, drawn) = (manifest.fur.layers, drawn_layers(instance.model(), params));
    blocks::Instance {
        world_from_model: instance.transform.to_cols_array_2d(),
        normal_x: cofactor(linear.y_axis, linear.z_axis),
        normal_y: cofactor(linear.z_axis, linear.x_axis),
        normal_z: cofactor(linear.x_axis, linear.y_axis),
        ambient: constant(shading.ambient, params.ambient),
        diffuse_half_exponent: 0.5 * shading.diffuse_exponent,
        diffuse: constant(shading.diffuse, params.light.color()),
        specular_half_exponent: 0.5 * shading.specular_exponent,
        specular: constant(shading.specular, params.light.color()),
        back_light_range: if params.back_attenuation {
            shading.back_light_range
        } else {
            kajiya_kay::BACK_ATTENUATION_OFF
        },
        ambient_floor: if params.ambient_attenuation { shading.ambient_floor } else { 1.0 },
        scale: linear.determinant().abs().cbrt(),
        handedness,
        opacity_exponent: if drawn > 1 && baked > 1 { (baked - 1) as f32 / (drawn - 1) as f32 } else { 1.0 },
        baked_layers: baked,
        // The shaders divide by one less.
        drawn_layers: drawn.max(2),
        wet_specular: unit.wet().specular[0],
        wet_specular_half_exponent: 0.5 * shading.wet().specular_exponent,
    }
}
