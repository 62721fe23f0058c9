//! Shadow maps as the runtime renders them, read back, with the time to render them.

use crate::chart::light_maps::LightMaps;
use glam::Vec3;
use half::f16;
use pelage_runtime::{Light, PassId, SelfShadow, ShadowMaps, ShadowParams, Study};
use pelage_stage::{Gpu, LookDetail, Meter, NamedPackage, Stage, StageError};
use pelage_tool::exit::Failure;
use pelage_tool::stages::stage_of;
use pelage_tool::view::PictureView;

/// Number of times that the maps are rendered per light, of which the fastest counts. The result is the median over all
/// lights.
const DRAWINGS: usize = 3;

/// Package loaded into the runtime, to render its shadow maps.
pub struct LightBench {
    scene: Stage,
    meter: Meter,
}

impl LightBench {
    /// Loads a package under the given name.
    pub fn new(name: &str, package: &[u8], gpu: &Gpu) -> Result<Self, Failure> {
        let file = NamedPackage { name: name.into(), bytes: package.into() };
        // The picture is small because it is not used; the whole model casts its shadow nevertheless.
        let view = PictureView::sized((16, 16)).with(|look| look.fur.detail = LookDetail::Full);
        let scene = stage_of(&file, &view, || Ok(gpu.clone()))?;
        let meter = Meter::new(&scene.gpu);
        Ok(Self { scene, meter })
    }

    /// Returns the source of the milliseconds, as named by `pelage bench`.
    pub fn clock_word(&self) -> &'static str {
        self.meter.clock().word()
    }

    /// Renders the maps of `pass` and reads them back. The milliseconds are those of the fastest run, because other
    /// load only adds time. The first run, which compiles pipelines, does not count.
    pub fn draw(
        &mut self,
        towards_light: Vec3,
        (shadows, study): (ShadowParams, Study),
        pass: PassId,
    ) -> Result<(LightMaps, f64), Failure> {
        let params = &mut self.scene.params;
        params.light = Light::Directional { towards_light, color: Vec3::ONE };
        params.shadows = shadows;
        params.study = study;
        params.soft_shadow = pass == PassId::SHADOW_WIDTH;
        if let Some(fur) = params.fur_mut() {
            fur.self_shadow = if pass == PassId::LAYER_SHADOW { SelfShadow::Maps } else { SelfShadow::Off };
        }
        let (frame, _) = self.meter.prepared(&mut self.scene, pass)?;
        let maps = frame.shadows().ok_or_else(|| StageError::Device("no shadow map was drawn".into()))?;
        let maps = read_maps(&self.scene.gpu, maps)?;
        // Maps that a frame still holds would be recreated instead of redrawn.
        drop(frame);
        let mut milliseconds = f64::INFINITY;
        for _ in 0..DRAWINGS {
            milliseconds = milliseconds.min(self.meter.prepared(&mut self.scene, pass)?.1);
        }
        Ok((maps, milliseconds))
    }
}

/// Copies the maps of a submitted frame into memory.
fn read_maps(gpu: &Gpu, maps: &ShadowMaps) -> Result<LightMaps, Failure> {
    let half = |bytes: &[u8]| f16::from_le_bytes([bytes[0], bytes[1]]).to_f32();
    let single = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    let mut layers = Vec::new();
    let mut size = 0;
    if let Some(texture) = maps.layers() {
        size = texture.width();
        let count = texture.depth_or_array_layers();
        for layer in 0..count {
            let texels = gpu.read_texture(texture, layer)?;
            layers.push(texels.chunks_exact(2).map(half).collect());
        }
    }
    let mut width = Vec::new();
    if let Some(texture) = maps.width() {
        size = texture.width();
        let texels = gpu.read_texture(texture, 0)?;
        let texel = |t: &[u8]| [half(&t[..2]), half(&t[2..4]), half(&t[4..6]), half(&t[6..])];
        width = texels.chunks_exact(8).map(texel).collect();
    }
    let mut depths = [Vec::new(), Vec::new()];
    for (depths, texture) in depths.iter_mut().zip(maps.depths().into_iter().flatten()) {
        let texels = gpu.read_texture(texture, 0)?;
        *depths = texels.chunks_exact(4).map(single).collect();
    }
    Ok(LightMaps { view: *maps.view(), soft: maps.soft_shadow(), size, layers, width, depths })
}
