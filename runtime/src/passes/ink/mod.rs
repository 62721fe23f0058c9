//! What the ink passes share: how their sources are joined, what an instance draws, and the order they are recorded in.

mod blocks;
mod pipelines;
mod targets;

pub(crate) use blocks::{InkFrame, InkModel};
pub(crate) use pipelines::InkPipelines;
#[cfg(test)]
pub(crate) use pipelines::{INK_ATTRIBUTES, REST_ATTRIBUTES};
pub(crate) use targets::bytes_of;

use super::fins::{self, FinDraws};
use super::surface::SurfaceLayouts;
use super::{PassId, ink_normals};
use crate::frame::Drawn;
use crate::ink::{Anchoring, FeatureRule, InkBackground, InkParams, InkShow, SphereMapForm};
use crate::model::{Model, Part};
use crate::model_ink::ModelInk;
use crate::shared::skinning;
use crate::{FrameParams, Instance, RendererOptions};
use glam::{Mat3, Mat4};
use pipelines::{InkKey, InkShader, Screen, screen_group};
use std::sync::Arc;
use targets::InkTargets;
use wgpu::util::DeviceExt;

/// Source of what the passes over a model's surface share, joined before each.
macro_rules! ink_surface_wgsl {
    ($($file:literal),+) => {
        concat!(
            include_str!("../../shared/fins.wgsl"),
            include_str!("../../shared/frame.wgsl"),
            include_str!("../../shared/ink.wgsl"),
            include_str!("../../shared/skinning.wgsl"),
            include_str!("../../shared/tile_frame.wgsl"),
            include_str!("../place.wgsl"),
            include_str!("../ink_model.wgsl"),
            $(include_str!($file),)+
        )
    };
}
pub(crate) use ink_surface_wgsl;

/// Source of what the passes over the picture share, joined before each.
macro_rules! ink_screen_wgsl {
    ($file:literal) => {
        concat!(
            include_str!("../../shared/ink.wgsl"),
            include_str!("../../shared/srgb.wgsl"),
            include_str!("../ink_screen.wgsl"),
            include_str!($file)
        )
    };
}
pub(crate) use ink_screen_wgsl;

/// What an instance draws in ink.
#[derive(Debug)]
pub(crate) struct InkDraws {
    group: wgpu::BindGroup,
    normals: Vec<(usize, wgpu::RenderPipeline)>,
    shells: Vec<(usize, wgpu::RenderPipeline)>,
    fins: Option<FinDraws>,
}

/// What a frame needs to paint the sheet.
#[derive(Debug)]
pub(crate) struct Sheet {
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    /// Another frame must not draw to them while this one lives.
    _targets: Arc<InkTargets>,
}

/// What pipelines and bind groups are made with.
#[derive(Clone, Copy)]
pub(crate) struct Making<'a> {
    pub(crate) device: &'a wgpu::Device,
    pub(crate) layouts: &'a SurfaceLayouts,
    pub(crate) options: &'a RendererOptions,
    pub(crate) clip_from_view: Mat4,
}

/// What an instance draws in this frame. `ink`: of its model.
pub(crate) fn plan(
    making: Making<'_>,
    pipelines: &mut InkPipelines,
    params: &FrameParams,
    ink_params: &InkParams,
    instance: &Instance,
    ink: &ModelInk,
) -> InkDraws {
    let Making { device, layouts, options, .. } = making;
    let model = instance.model();
    let constants = InkModel::new(ink, ink_params, params.camera.view_from_world, making.clip_from_view);
    let has_strokes = ink.fur.is_some() && constants.fur > 0.0;
    let mirrored = skinning::handedness_of(Mat3::from_mat4(instance.transform)) < 0.0;
    let mut pipeline = |shader, part: &Part| {
        let fins = shader == InkShader::Fins;
        let key = InkKey {
            shader,
            base_color_texture: part.has_texture,
            cutout: part.cutout,
            lean: shader != InkShader::Normals && model.varies().lean,
            double_sided: part.double_sided || fins,
            mirrored: mirrored && !fins,
            fur: shader == InkShader::Normals && has_strokes && part.furred,
            sphere_map: if shader == InkShader::Normals { ink_params.sphere_map } else { SphereMapForm::default() },
            on_screen: shader == InkShader::Normals && ink_params.anchoring == Anchoring::Screen,
        };
        pipelines.surface(device, layouts, options, key)
    };
    let mut of = |shader, wanted: &dyn Fn(&Part) -> bool| -> Vec<_> {
        let parts = model.parts().iter().enumerate().filter(|(_, part)| wanted(part));
        parts.map(|(index, part)| (index, pipeline(shader, part))).collect()
    };
    let normals = of(InkShader::Normals, &|_| true);
    // Strokes are of the painting alone.
    let painted = has_strokes && ink_params.show == InkShow::Painting;
    let shells = if painted { of(InkShader::Shells, &|part| part.furred) } else { Vec::new() };
    let fins = (painted && params.fins && model.fins().is_some() && layouts.fins.is_some())
        .then(|| of(InkShader::Fins, &|part| !part.fins.is_empty()));
    let fins = fins.and_then(|parts| fins::bind(device, layouts, instance, parts));
    InkDraws { group: pipelines.model_group(device, layouts, ink, &constants), normals, shells, fins }
}

/// Compiles what a model needs in ink.
pub(crate) fn compile(
    making: Making<'_>,
    pipelines: &mut InkPipelines,
    params: &FrameParams,
    ink_params: &InkParams,
    model: &Model,
) {
    if let Some(ink) = model.ink() {
        plan(making, pipelines, params, ink_params, &Instance::new(model), ink);
    }
    for screen in screens(ink_params) {
        pipelines.screen(making.device, making.options, screen);
    }
}

/// The passes over the picture, in their order.
fn screens(params: &InkParams) -> [Screen; 4] {
    let printed = params.printed_lines;
    [
        Screen::Features { all_below: params.features == FeatureRule::AllBelow },
        Screen::Dilate { squares: printed },
        Screen::Stroke { printed, template: params.template },
        Screen::Composite { show: params.show, picture: params.background == InkBackground::Picture, soft: !printed },
    ]
}

/// What is needed to record the passes before the application's.
pub(crate) struct Recording<'a> {
    pub(crate) making: Making<'a>,
    pub(crate) params: &'a InkParams,
    /// Left, top, width and height of the part of the picture that there is something in.
    pub(crate) rect: [u32; 4],
    /// Group 0 of the passes over surfaces.
    pub(crate) frame: &'a wgpu::BindGroup,
    pub(crate) instances: &'a [Drawn],
}

/// Records all passes but those in the application's own, and returns what paints the sheet there.
pub(crate) fn record(
    pipelines: &mut InkPipelines,
    encoder: &mut wgpu::CommandEncoder,
    recording: &Recording<'_>,
    mark: &mut dyn FnMut(&mut wgpu::CommandEncoder, PassId),
) -> Sheet {
    let Recording { making: Making { device, options, layouts, clip_from_view }, params, .. } = *recording;
    let targets = pipelines.targets(device, params.target_px);
    ink_normals::record(encoder, &targets.as_targets(), recording, options.reversed_depth);
    mark(encoder, PassId::InkNormals);

    let constants = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("pelage ink frame"),
        contents: bytemuck::bytes_of(&InkFrame::new(params, clip_from_view, options.reversed_depth)),
        usage: wgpu::BufferUsages::UNIFORM,
    });
    // One sheet for all: that of the first who is on it.
    let paper = recording.instances.iter().find_map(|i| i.model.ink()).map_or(&layouts.white, |ink| &ink.paper);
    let [features, dilate, stroke, composite] = screens(params).map(|s| pipelines.screen(device, options, s));
    let t = &*targets;
    let tile = &pipelines.tile_sampler;
    let group = |pipeline: &wgpu::RenderPipeline, views: &[_], samplers: &[_]| {
        screen_group(device, pipeline, &constants, views, samplers)
    };
    let seen = group(&features, &[(1, &t.normals), (2, &t.surfaces)], &[]);
    fill(encoder, recording, "pelage ink features", &t.features, &features, &seen);
    mark(encoder, PassId::InkFeatures);
    let seen = group(&dilate, &[(1, &t.features)], &[]);
    fill(encoder, recording, "pelage ink dilate", &t.rows, &dilate, &seen);
    mark(encoder, PassId::InkDilate);
    let views = [(1, &t.normals), (2, &t.surfaces), (3, &t.features), (4, &t.rows), (5, paper)];
    let seen = group(&stroke, &views, &[(6, tile)]);
    fill(encoder, recording, "pelage ink stroke", &t.strokes, &stroke, &seen);
    mark(encoder, PassId::InkStroke);
    let shown = if params.show == InkShow::Features { &t.features } else { &t.strokes };
    let views = [(1, &t.normals), (2, &t.surfaces), (3, shown), (4, &t.depth), (5, paper)];
    let seen = group(&composite, &views, &[(6, tile), (7, &pipelines.clamp_sampler)]);
    Sheet { pipeline: composite, group: seen, _targets: targets }
}

/// Records a pass that fills the painted part of a texture.
fn fill(
    encoder: &mut wgpu::CommandEncoder,
    recording: &Recording<'_>,
    label: &str,
    view: &wgpu::TextureView,
    pipeline: &wgpu::RenderPipeline,
    group: &wgpu::BindGroup,
) {
    let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store };
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops,
        })],
        ..Default::default()
    });
    let [left, top, width, height] = recording.rect;
    if width > 0 && height > 0 {
        pass.set_scissor_rect(left, top, width, height);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.draw(0..3, 0..1);
    }
}

impl Sheet {
    /// Paints it into the application's pass.
    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.draw(0..3, 0..1);
    }
}

impl InkDraws {
    /// Whether it has no strokes of fur.
    pub(crate) fn is_bald(&self) -> bool {
        self.shells.is_empty() && self.fins.is_none()
    }

    /// Parts and pipelines of `ink_normals`.
    pub(crate) fn normals(&self) -> &[(usize, wgpu::RenderPipeline)] {
        &self.normals
    }

    /// Group 2 of the passes over surfaces.
    pub(crate) fn group(&self) -> &wgpu::BindGroup {
        &self.group
    }

    /// Parts and pipelines of the strokes on shells.
    pub(crate) fn shells(&self) -> &[(usize, wgpu::RenderPipeline)] {
        &self.shells
    }

    /// What is drawn of the fins.
    pub(crate) fn fins(&self) -> Option<&FinDraws> {
        self.fins.as_ref()
    }
}
