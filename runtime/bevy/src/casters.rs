//! Draws Bevy meshes into the shadow maps of fur.
//!
//! When the runtime draws a shadow map, it requests the depth of other casters. Bevy keeps the vertices of all meshes
//! in a few buffers. They are drawn from these, with pipelines that read only positions.

use crate::bounds::{enclosing_sphere, extent_towards_light};
use crate::extract::{Caster, Scene};
use crate::renderers::{LogOnce, PassRenderer};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_math::{Mat4, Vec3};
use bevy_mesh::{Mesh, VertexFormat};
use bevy_render::mesh::allocator::{MeshAllocator, MeshBufferSlice};
use bevy_render::mesh::{RenderMesh, RenderMeshBufferInfo};
use bevy_render::render_asset::RenderAssets;
use bevy_render::renderer::RenderDevice;
use pelage_runtime::{
    CasterPass, Casters, Frame, FrameParams, Hooks, Instance, Light, LightView, RuntimeError, ShadowMaps, Sphere, wgpu,
};
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::mem::size_of;
use std::ops::Range;

/// Vertex shader; transforms positions by one matrix per instance.
const SHADER: &str = "
@vertex
fn vs_caster(
    @location(0) position: vec3<f32>,
    @location(1) x: vec4<f32>,
    @location(2) y: vec4<f32>,
    @location(3) z: vec4<f32>,
    @location(4) w: vec4<f32>,
) -> @builtin(position) vec4<f32> {
    return mat4x4(x, y, z, w) * vec4(position, 1.0);
}
";

/// Vertex attributes: the four columns of `clip_from_model`, stored consecutively.
const MATRIX_ATTRIBUTES: [wgpu::VertexAttribute; 4] =
    wgpu::vertex_attr_array![1 => Float32x4, 2 => Float32x4, 3 => Float32x4, 4 => Float32x4];

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct PipelineKey {
    stride: u64,
    position_offset: u64,
    topology: wgpu::PrimitiveTopology,
    /// Index format; `None` if the primitives are not strips.
    strip_indices: Option<wgpu::IndexFormat>,
    pass: CasterPass,
}

#[derive(Resource, Debug, Default)]
pub(crate) struct CasterPipelines(HashMap<PipelineKey, wgpu::RenderPipeline>);

/// A mesh in Bevy's buffers.
struct CasterMesh<'a> {
    vertices: MeshBufferSlice<'a>,
    indices: Option<(MeshBufferSlice<'a>, wgpu::IndexFormat)>,
    topology: wgpu::PrimitiveTopology,
    stride: u64,
    position_offset: u64,
    transform: Mat4,
}

/// System parameter that prepares frames with Bevy's meshes as casters.
#[derive(SystemParam)]
pub(crate) struct CasterDraws<'w> {
    meshes: Res<'w, RenderAssets<RenderMesh>>,
    allocator: Res<'w, MeshAllocator>,
    pipelines: ResMut<'w, CasterPipelines>,
}

impl CasterDraws<'_> {
    /// Prepares a frame of `instances`, whose bounding spheres are `spheres`. Its shadow maps contain the casters that
    /// can shade the instances.
    pub(crate) fn prepare(
        &mut self,
        pass_renderer: &mut PassRenderer,
        scene: &Scene,
        device: &RenderDevice,
        encoder: &mut wgpu::CommandEncoder,
        params: &FrameParams,
        instances: &[Instance],
        spheres: &[Sphere],
    ) -> Result<Frame, RuntimeError> {
        let Self { meshes, allocator, pipelines } = self;
        let (casters, bounds) = select_casters(&scene.casters, spheres, params);
        // Skip meshes that are not on the GPU yet; they are drawn in a later frame. `revision` changes when the set of
        // drawn meshes does.
        let caster_meshes: Vec<CasterMesh> =
            casters.iter().filter_map(|caster| find_mesh(caster, meshes, allocator, pass_renderer.log)).collect();
        if caster_meshes.is_empty() {
            return pass_renderer.renderer.prepare(encoder, params, instances);
        }
        let device = device.wgpu_device();
        let mut draw = |pass: &mut wgpu::RenderPass<'_>, view: &LightView, which: CasterPass| {
            let matrices: Vec<u8> = caster_meshes
                .iter()
                .flat_map(|mesh| (view.clip_from_world * mesh.transform).to_cols_array())
                .flat_map(f32::to_le_bytes)
                .collect();
            let matrices = wgpu::util::DeviceExt::create_buffer_init(
                device,
                &wgpu::util::BufferInitDescriptor {
                    label: Some("pelage casters"),
                    contents: &matrices,
                    usage: wgpu::BufferUsages::VERTEX,
                },
            );
            pass.set_vertex_buffer(1, matrices.slice(..));
            for (number, mesh) in (0u32..).zip(&caster_meshes) {
                let pipeline =
                    pipelines.0.entry(mesh.pipeline_key(which)).or_insert_with_key(|key| create_pipeline(device, key));
                pass.set_pipeline(pipeline);
                mesh.draw(pass, number..number + 1);
            }
        };
        let revision = revision(&casters, &caster_meshes, scene.meshes_changed);
        let casters = Casters { bounds, revision, draw: &mut draw };
        pass_renderer.renderer.prepare_with(encoder, params, instances, Hooks::default().casters(casters))
    }
}

/// Returns the casters that can shade anything in `spheres`, and a sphere of radius 0 that the maps must also cover.
/// The sphere marks how far the casters extend towards the light. The maps are as wide as the animals; parts of a
/// caster beyond that width are ignored. Casters that reach past a point light are skipped, such as its own lantern.
fn select_casters<'a>(
    casters: &'a [Caster],
    spheres: &[Sphere],
    params: &FrameParams,
) -> (Vec<&'a Caster>, Option<Sphere>) {
    let lit = spheres.iter().copied().reduce(enclosing_sphere).filter(|_| params.soft_shadow);
    let Some(lit) = lit else { return (Vec::new(), None) };
    let (towards_light, reach_m) = match params.light {
        Light::Directional { towards_light, .. } => (towards_light, f32::INFINITY),
        Light::Point { position, .. } => (position - lit.center, position.distance(lit.center)),
    };
    let towards_light = towards_light.normalize_or(Vec3::Y);
    let height = |caster: &Caster| {
        let shades = spheres.iter().any(|sphere| extent_towards_light(*sphere, towards_light, caster.bounds).is_some());
        let extent = shades.then(|| extent_towards_light(lit, towards_light, caster.bounds)).flatten();
        extent.filter(|extent_m| *extent_m < reach_m)
    };
    let (shading, heights): (Vec<_>, Vec<_>) =
        casters.iter().filter_map(|caster| Some((caster, height(caster)?))).unzip();
    let highest_m = heights.into_iter().reduce(f32::max);
    (shading, highest_m.map(|m| Sphere { center: lit.center + m * towards_light, radius: 0.0 }))
}

impl CasterMesh<'_> {
    fn pipeline_key(&self, pass: CasterPass) -> PipelineKey {
        let strip = self.topology == wgpu::PrimitiveTopology::TriangleStrip;
        let strip_indices = self.indices.as_ref().map(|(_, format)| *format).filter(|_| strip);
        PipelineKey {
            stride: self.stride,
            position_offset: self.position_offset,
            topology: self.topology,
            strip_indices,
            pass,
        }
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, instance: Range<u32>) {
        pass.set_vertex_buffer(0, wgpu::Buffer::slice(self.vertices.buffer, ..));
        match &self.indices {
            Some((indices, format)) => {
                pass.set_index_buffer(wgpu::Buffer::slice(indices.buffer, ..), *format);
                pass.draw_indexed(indices.range.clone(), self.vertices.range.start as i32, instance);
            }
            None => pass.draw(self.vertices.range.clone(), instance),
        }
    }
}

/// Finds a mesh in Bevy's buffers. `None` if it is not on the GPU yet, or if it cannot be drawn (a warning is logged).
fn find_mesh<'a>(
    caster: &Caster,
    meshes: &RenderAssets<RenderMesh>,
    allocator: &'a MeshAllocator,
    log: &mut LogOnce,
) -> Option<CasterMesh<'a>> {
    let mesh = meshes.get(caster.mesh)?;
    let vertices = allocator.mesh_vertex_slice(&caster.mesh)?;
    let indices = match mesh.buffer_info {
        RenderMeshBufferInfo::Indexed { index_format, .. } => {
            Some((allocator.mesh_index_slice(&caster.mesh)?, index_format))
        }
        RenderMeshBufferInfo::NonIndexed => None,
    };
    let topology = mesh.primitive_topology();
    let layout = &mesh.layout.0;
    let position = layout.attribute_ids().iter().position(|id| *id == Mesh::ATTRIBUTE_POSITION.id);
    let position = position.and_then(|index| layout.layout().attributes.get(index));
    let flat = matches!(topology, wgpu::PrimitiveTopology::TriangleList | wgpu::PrimitiveTopology::TriangleStrip);
    let Some(position) = position.filter(|position| position.format == VertexFormat::Float32x3 && flat) else {
        let found = position.map(|position| position.format);
        log.warn(format!(
            "a mesh with PelageShadowCaster casts no shadow on fur: its topology is {topology:?} and its positions are \
             {found:?}, expected triangles with Float32x3 positions"
        ));
        return None;
    };
    let (stride, position_offset) = (layout.layout().array_stride, position.offset);
    Some(CasterMesh { vertices, indices, topology, stride, position_offset, transform: caster.transform })
}

/// Returns a revision that changes whenever the casters change.
fn revision(casters: &[&Caster], caster_meshes: &[CasterMesh], meshes_changed: u64) -> u64 {
    let mut hasher = DefaultHasher::new();
    meshes_changed.hash(&mut hasher);
    casters.iter().for_each(|caster| caster.mesh.hash(&mut hasher));
    for mesh in caster_meshes {
        mesh.transform.to_cols_array().map(f32::to_bits).hash(&mut hasher);
        mesh.vertices.range.hash(&mut hasher);
    }
    hasher.finish()
}

fn create_pipeline(device: &wgpu::Device, key: &PipelineKey) -> wgpu::RenderPipeline {
    let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("pelage caster"),
        source: wgpu::ShaderSource::Wgsl(SHADER.into()),
    });
    let position = [wgpu::VertexAttribute {
        format: wgpu::VertexFormat::Float32x3,
        offset: key.position_offset,
        shader_location: 0,
    }];
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("pelage caster"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &shader,
            entry_point: Some("vs_caster"),
            compilation_options: Default::default(),
            buffers: &[
                Some(wgpu::VertexBufferLayout {
                    array_stride: key.stride,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &position,
                }),
                Some(wgpu::VertexBufferLayout {
                    array_stride: size_of::<[f32; 16]>() as u64,
                    step_mode: wgpu::VertexStepMode::Instance,
                    attributes: &MATRIX_ATTRIBUTES,
                }),
            ],
        },
        primitive: wgpu::PrimitiveState {
            topology: key.topology,
            strip_index_format: key.strip_indices,
            cull_mode: key.pass.cull_mode(),
            ..Default::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: ShadowMaps::DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(key.pass.compare()),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: None,
        multiview_mask: None,
        cache: None,
    })
}
