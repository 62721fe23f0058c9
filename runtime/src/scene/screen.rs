//! Building blocks of the ink passes: a model's textures, and full-screen passes.

use super::recording::Recording;
use crate::gpu::{
    BindingResource, CLEARED, Constants, Draw, DrawBindGroup, RenderSpec, SamplerSettings, Shader, Target,
    begin_target, depth_texture, record, sampler, texture, uniform,
};
use crate::ink::{InkFrame, InkModel};

/// Joins the WGSL shared by the ink screen passes with the given files.
macro_rules! ink_screen_wgsl {
    ($($file:expr),+ $(,)?) => {
        &[
            include_str!("../../shared/ink.wgsl"),
            include_str!("../../shared/srgb.wgsl"),
            include_str!("../../ink/screen.wgsl"),
            $crate::study::form_wgsl!("ink/line_forms.wgsl"),
            $($file,)+
        ]
    };
}
pub(crate) use ink_screen_wgsl;

/// Full-screen pass: override constants, and inputs with their binding numbers.
#[derive(Default)]
pub(crate) struct ScreenPass<'a> {
    pub(crate) constants: Constants,
    pub(crate) reads: &'a [(u32, Target)],
    /// Depth texture that the pass reads, with its binding.
    pub(crate) depth: Option<(u32, Target)>,
    /// Bindings of the paper tile and its sampler.
    pub(crate) paper: Option<[u32; 2]>,
    /// Binding of a clamping sampler.
    pub(crate) clamped: Option<u32>,
}

fn sampling(mode: wgpu::AddressMode) -> SamplerSettings {
    SamplerSettings::new("pelage ink", mode)
}

impl Recording<'_> {
    /// Returns bind group 2 and its layout for the ink passes over an instance's surface; `None` for a model without
    /// ink data. `behind`: additional target to read, at binding 7.
    pub(crate) fn ink_model_group(
        &mut self,
        index: usize,
        behind: Option<Target>,
    ) -> Option<(wgpu::BindGroupLayout, DrawBindGroup)> {
        use wgpu::TextureViewDimension::{D2, D2Array};
        let places = self.ink.as_ref()?.models.clone();
        let seen = self.instances.clone();
        let ink = seen[index].model.ink()?;
        let name = if behind.is_some() { "pelage ink model over surfaces" } else { "pelage ink model" };
        let layout = self.cache.layouts.get(self.gpu, name, || {
            let own = [
                uniform::<InkModel>(0, true),
                texture(1, D2),
                texture(2, D2),
                texture(3, D2Array),
                texture(4, D2),
                sampler(5),
                sampler(6),
            ];
            own.into_iter().chain(behind.map(|_| texture(7, D2))).collect()
        });
        let [tile, clamp] = [wgpu::AddressMode::Repeat, wgpu::AddressMode::ClampToEdge]
            .map(|mode| BindingResource::Sampler(self.cache.layouts.sampler(self.gpu, sampling(mode))));
        let view = |view: &wgpu::TextureView| BindingResource::View(view.clone());
        let mut entries = vec![
            (0, BindingResource::block::<InkModel>(&places.buffer, 0)),
            (1, view(&ink.stroke)),
            (2, view(&ink.wash)),
            (3, view(ink.fur.as_ref().unwrap_or(&self.surfaces.white_array))),
            (4, view(&ink.paper)),
            (5, tile),
            (6, clamp),
        ];
        if let Some(target) = behind {
            entries.push((7, view(self.targets.view(&target)?)));
        }
        let group = self.cache.bind_groups.get(self.gpu, name, &layout, entries);
        Some((layout, DrawBindGroup::at(&group, places.offset + index as u64 * places.stride)?))
    }

    /// Returns the paper texture of the first instance with ink data.
    pub(crate) fn paper(&self) -> wgpu::TextureView {
        let ink = self.instances.iter().find_map(|seen| seen.model.ink());
        ink.map_or(&self.surfaces.white, |ink| &ink.paper).clone()
    }

    /// Returns the greatest distance of a line from its feature, whole pixels.
    pub(crate) fn ink_reach_px(&self) -> u32 {
        self.params.style.ink().map_or(0, |ink| ink.reach_px(self.params.viewport[1]))
    }

    /// Returns the pipeline specification and the bind group of a full-screen pass to a target of `format`.
    pub(crate) fn screen_spec(
        &mut self,
        shader: Shader,
        fragment: &'static str,
        screen: &ScreenPass<'_>,
        format: wgpu::TextureFormat,
    ) -> Option<(RenderSpec, wgpu::BindGroup)> {
        use wgpu::AddressMode::{ClampToEdge, Repeat};
        let constants = self.ink.as_ref()?.frame.clone();
        let mut entries = vec![(0, BindingResource::block::<InkFrame>(&constants.buffer, constants.offset))];
        let mut layout = vec![uniform::<InkFrame>(0, false)];
        let textures = screen.reads.iter().map(|read| (*read, texture as fn(_, _) -> _));
        for ((number, target), entry) in textures.chain(screen.depth.map(|read| (read, depth_texture as _))) {
            layout.push(entry(number, wgpu::TextureViewDimension::D2));
            entries.push((number, BindingResource::View(self.targets.view(&target)?.clone())));
        }
        if let Some([number, _]) = screen.paper {
            layout.push(texture(number, wgpu::TextureViewDimension::D2));
            entries.push((number, BindingResource::View(self.paper())));
        }
        let samplers = [(screen.paper.map(|[_, number]| number), Repeat), (screen.clamped, ClampToEdge)];
        for (number, mode) in samplers.into_iter().filter_map(|(number, mode)| Some((number?, mode))) {
            layout.push(sampler(number));
            entries.push((number, BindingResource::Sampler(self.cache.layouts.sampler(self.gpu, sampling(mode)))));
        }
        let layout = self.cache.layouts.get(self.gpu, shader.name, || layout);
        let group = self.cache.bind_groups.get(self.gpu, shader.name, &layout, entries);
        let mut spec = RenderSpec::screen(shader, ["vs_screen", fragment], layout, format);
        spec.constants.clone_from(&screen.constants);
        Some((spec, group))
    }

    /// Runs a full-screen pass over the painted part of a target.
    pub(crate) fn run_screen_pass(
        &mut self,
        shader: Shader,
        fragment: &'static str,
        screen: &ScreenPass<'_>,
        target: &Target,
    ) {
        let made = self.screen_spec(shader, fragment, screen, target.format);
        let targets = self.targets.clone();
        let (Some(view), Some((spec, group))) = (targets.view(target), made) else { return };
        let draw = Draw::screen(self.pipeline(spec), &group);
        let mut pass = begin_target(self.encoder, shader.name, view, CLEARED);
        let [left, top, width, height] = self.ink.as_ref().map_or([0; 4], |ink| ink.painted);
        if width > 0 && height > 0 {
            pass.set_scissor_rect(left, top, width, height);
            record(&mut pass, [&draw]);
        }
    }
}
