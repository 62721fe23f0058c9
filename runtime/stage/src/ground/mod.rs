//! Ground below the models of a stage: their soft shadow, and the background of a studio.
//!
//! The key light's shadow is read from the shadow-width map of the runtime, with a penumbra as wide as a lamp makes it.
//! The shadow of the rest of the light is a map of the sky that the models hide (`contact.rs`). Single hairs cast no
//! shadow of their own.

mod contact;

use crate::animator::layers;
use crate::cast::Cast;
use crate::{CanvasOptions, Gpu, StageError};
use bytemuck::{Pod, Zeroable};
use contact::{CELLS, ContactMap, GroundCaster};
use glam::{Mat4, Vec2, Vec3, Vec4};
use pelage_formats::meaning::luminance;
use pelage_runtime::{ClipLayer, Frame, FrameParams, Instance, Light, wgpu};
use wgpu::util::DeviceExt as _;

/// Ground of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GroundKind {
    /// No ground.
    #[default]
    None,
    /// Shadow on an invisible ground.
    Shadow,
    /// Shadow on the floor of a studio, in front of its wall.
    Studio,
}

/// Mean ambient light of packages, relative to a perpendicular key light of colour 1.
const AMBIENT: f32 = 0.3;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct GroundBlock {
    direction_from_clip: Mat4,
    map_from_world: Mat4,
    eye: Vec3,
    height_m: f32,
    corner: Vec2,
    width_m: f32,
    models_m: f32,
    towards: Vec3,
    key_share: f32,
    range_m: f32,
    texel_m: f32,
    extent_m: f32,
    studio: f32,
    middle: Vec2,
    reserved: Vec2,
}

type ModelPose = (usize, Mat4, Vec<ClipLayer>);

type UploadedMap = (ContactMap, wgpu::TextureView);

/// Ground of a stage, ready to draw.
#[derive(Debug, Default)]
pub(crate) struct Ground {
    pub(crate) kind: GroundKind,
    casters: Vec<GroundCaster>,
    pipeline: Option<(wgpu::RenderPipeline, wgpu::Sampler)>,
    /// Contact map on the device, and the poses for which it was computed.
    map: Option<(Vec<ModelPose>, Option<UploadedMap>)>,
    /// Bind group of the most recently prepared frame.
    bound: Option<wgpu::BindGroup>,
}

impl Ground {
    /// Returns the ground of a cast, with the kind and the pipeline of this one.
    ///
    /// Fails with [`StageError::Package`] for a damaged package.
    pub(crate) fn below(&self, cast: &Cast<'_>) -> Result<Self, StageError> {
        let read = cast.packages.iter().map(|(file, package)| GroundCaster::of(package).map_err(|e| file.fault(e)));
        let casters = read.collect::<Result<_, _>>()?;
        Ok(Self { kind: self.kind, casters, pipeline: self.pipeline.clone(), ..Self::default() })
    }

    /// Prepares the ground for a frame. `models`: index of the package of each instance, and the instance.
    pub(crate) fn prepare<'i>(
        &mut self,
        (gpu, options): (&Gpu, &CanvasOptions),
        (params, frame): (&FrameParams, &Frame),
        models: impl Iterator<Item = (usize, &'i Instance)>,
    ) {
        self.bound = None;
        if self.kind == GroundKind::None {
            return;
        }
        let poses: Vec<_> = models.map(|(package, shown)| (package, shown.transform, layers(&shown.motion))).collect();
        if self.map.as_ref().is_none_or(|(before, _)| *before != poses) {
            let models =
                poses.iter().filter_map(|(package, at, layers)| Some((self.casters.get(*package)?, *at, layers)));
            let map = ContactMap::new(models.map(|(caster, at, layers)| (caster, at, &layers[..])));
            self.map = Some((poses, map.map(|map| upload(gpu, map))));
        }
        let Some((_, Some((map, contact)))) = &self.map else { return };
        let block = self.block(map, params, frame);
        let (pipeline, sampler) = self.pipeline.get_or_insert_with(|| (pipeline(gpu, options), sampler(gpu)));
        let uniform = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("ground"),
            contents: bytemuck::bytes_of(&block),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let resources = [
            uniform.as_entire_binding(),
            wgpu::BindingResource::TextureView(contact),
            wgpu::BindingResource::Sampler(sampler),
            wgpu::BindingResource::TextureView(frame.shadow_map()),
        ];
        let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
        let entries: Vec<_> = (0..).zip(resources).map(entry).collect();
        self.bound = Some(gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("ground"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        }));
    }

    /// Records the ground of the most recently prepared frame.
    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        if let (Some((pipeline, _)), Some(bound)) = (&self.pipeline, &self.bound) {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, bound, &[]);
            pass.draw(0..3, 0..1);
        }
    }

    fn block(&self, map: &ContactMap, params: &FrameParams, frame: &Frame) -> GroundBlock {
        let middle = map.corner + 0.5 * map.width_m;
        let center = Vec3::new(middle.x, map.height_m, middle.y);
        let towards = match params.light {
            Light::Directional { towards_light, .. } => towards_light,
            Light::Point { position, .. } => position - center,
        };
        let towards = towards.normalize_or(Vec3::Y);
        let key = luminance(params.light.color().as_dvec3()) as f32 * towards.y.max(0.0);
        let around = params.environment.as_ref().map_or(AMBIENT * params.ambient, |sky| {
            let sky = pelage_formats::meaning::environment::Environment { sun: None, ..sky.clone() };
            sky.ground_irradiance().as_vec3()
        });
        let around = (luminance(around.as_dvec3()) as f32).max(1e-6);
        let receiver = frame.shadow_receiver();
        let shadows = frame.shadows().map(pelage_runtime::ShadowMaps::view);
        let (world, clip) = (params.camera.view_from_world.inverse(), params.camera.projection.clip_from_view(true));
        let [right, up, back, eye] = [world.x_axis, world.y_axis, world.z_axis, world.w_axis];
        GroundBlock {
            direction_from_clip: Mat4::from_cols(right / clip.x_axis.x, up / clip.y_axis.y, -back, Vec4::ZERO),
            map_from_world: receiver.map_from_world,
            eye: eye.truncate(),
            height_m: map.height_m,
            corner: map.corner,
            width_m: map.width_m,
            models_m: map.models_m,
            towards,
            key_share: key / (key + around),
            range_m: receiver.soft_shadow.range_m,
            texel_m: receiver.soft_shadow.texel,
            extent_m: shadows.map_or(1.0, |view| view.extent * view.near_m.map_or(1.0, |near| near + view.range_m)),
            studio: f32::from(u8::from(self.kind == GroundKind::Studio)),
            middle,
            reserved: Vec2::ZERO,
        }
    }
}

fn upload(gpu: &Gpu, map: ContactMap) -> UploadedMap {
    let texture = gpu.device.create_texture_with_data(
        &gpu.queue,
        &wgpu::TextureDescriptor {
            label: Some("ground contact"),
            size: wgpu::Extent3d { width: CELLS, height: CELLS, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::R8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        wgpu::util::TextureDataOrder::LayerMajor,
        &map.hidden,
    );
    (map, texture.create_view(&wgpu::TextureViewDescriptor::default()))
}

/// Creates the sampler of the contact map.
fn sampler(gpu: &Gpu) -> wgpu::Sampler {
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    })
}

fn pipeline(gpu: &Gpu, options: &CanvasOptions) -> wgpu::RenderPipeline {
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("ground"),
        source: wgpu::ShaderSource::Wgsl(include_str!("ground.wgsl").into()),
    });
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("ground"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vs_ground"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: options.depth_format,
            depth_write_enabled: Some(false),
            depth_compare: Some(wgpu::CompareFunction::Always),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState { count: options.sample_count, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fs_ground"),
            compilation_options: Default::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: options.color_format,
                blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}
