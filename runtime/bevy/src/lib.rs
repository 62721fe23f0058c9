#![doc = include_str!("../README.md")]

mod bounds;
#[cfg(feature = "pbr")]
mod cascades;
mod casters;
mod components;
mod draw;
mod extract;
mod lights;
mod model;
mod motion;
mod renderers;
mod view;

pub use components::{
    Pelage, PelageClip, PelageEnvironment, PelageHair, PelageJoints, PelageMorphs, PelageShadowCaster, PelageShadows,
};
pub use model::{PelageLoadError, PelageModel, PelageModelLoader};
pub use pelage_runtime as runtime;
pub use pelage_stage::sky::environment_from_toml;
pub use renderers::PelageRenderers;

use bevy_app::{App, Plugin, PostUpdate};
use bevy_asset::{AssetApp as _, AssetServer};
use bevy_core_pipeline::core_3d::{main_opaque_pass_3d, main_transparent_pass_3d};
use bevy_core_pipeline::{Core3d, Core3dSystems};
use bevy_ecs::prelude::*;
use bevy_render::{ExtractSchedule, GpuResourceAppExt as _, Render, RenderApp, RenderSystems};
use pelage_runtime::RendererOptions;

/// Plugin that loads packages and draws the entities that have a [`Pelage`].
#[derive(Clone, Debug)]
pub struct PelagePlugin {
    /// Anisotropy of the base-colour sampler, 1..=16 (default 1).
    pub anisotropy: u16,
    /// Maximum number of single strands of a model's fur (default 300 000); see [`RendererOptions::max_strands`].
    pub max_strands: u32,
}

impl Default for PelagePlugin {
    fn default() -> Self {
        let RendererOptions { anisotropy, max_strands, .. } = RendererOptions::default();
        Self { anisotropy, max_strands }
    }
}

impl Plugin for PelagePlugin {
    /// # Panics
    ///
    /// If Bevy's `AssetPlugin`, which is part of `DefaultPlugins`, has not been added before.
    fn build(&self, app: &mut App) {
        assert!(
            app.world().contains_resource::<AssetServer>(),
            "PelagePlugin found no AssetServer; add DefaultPlugins (or AssetPlugin) before it: \
             app.add_plugins((DefaultPlugins, PelagePlugin::default()))"
        );
        app.init_asset::<PelageModel>()
            .register_asset_loader(PelageModelLoader)
            .init_resource::<PelageShadows>()
            .init_resource::<PelageHair>()
            .init_resource::<PelageEnvironment>()
            .add_systems(PostUpdate, (motion::insert_bounding_boxes, (motion::find_clips, motion::play_clips).chain()));
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else { return };
        let options = RendererOptions {
            anisotropy: self.anisotropy,
            max_strands: self.max_strands,
            ..RendererOptions::default()
        };
        render_app
            .insert_resource(renderers::Options(options))
            .init_resource::<extract::Scene>()
            .init_gpu_resource::<PelageRenderers>()
            .init_gpu_resource::<renderers::Frames>()
            .init_gpu_resource::<casters::CasterPipelines>()
            .add_systems(
                ExtractSchedule,
                (extract::animals, extract::lights, extract::hair, extract::environment, extract::casters),
            )
            .add_systems(
                Render,
                (
                    renderers::drop_unused.in_set(RenderSystems::PrepareResources),
                    renderers::drop_frames.in_set(RenderSystems::Cleanup),
                ),
            )
            .add_systems(
                Core3d,
                (
                    draw::prepare.before(main_opaque_pass_3d),
                    draw::draw.after(draw::prepare).after(main_opaque_pass_3d).before(main_transparent_pass_3d),
                )
                    .in_set(Core3dSystems::MainPass),
            );
        #[cfg(feature = "pbr")]
        cascades::build(render_app);
    }
}
