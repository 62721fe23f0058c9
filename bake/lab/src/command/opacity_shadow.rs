//! `pelage chart opacity-shadow`: deep and opacity shadow maps between strands, rendered by the adapter, compared with
//! traced light and a traced picture.

use super::driver::{Plan, PlannedRow, Topic, get_or_make};
use super::subject::Subject;
use crate::chart::opacity_shadow;
use crate::chart::opacity_shadow::{
    Ball, COLUMNS, DeepMap, OpacityShadowConfiguration, OpacityShadowMeasures, PANELS, SAMPLES, STEP_PX, cells,
    configurations,
};
use crate::chart::{Cell, Errors};
use glam::Vec3;
use pelage_bake::picture::Picture;
use pelage_bake::recipe::Recipe;
use pelage_import::BakeError;
use pelage_runtime::{Frame, Light, PassId, wgpu};
use pelage_stage::{Gpu, KeyLight, LookHair, LookStudio, Meter, Samples, Spread, Stage, StageError};
use pelage_tool::exit::Failure;
use pelage_tool::machine::measured_on;
use pelage_tool::stages::{pixels, stage_of};
use pelage_tool::truth::ReferenceTracer;
use pelage_tool::view::PictureView;
use pelage_truth::TrueLight;
use pelage_truth::compare::{CompareParams, compare_pictures};

/// Number of times that the map is rendered per light, of which the fastest counts. The result is the median over all
/// lights.
const DRAWINGS: usize = 5;

/// Directions towards the lights besides the default view's: one from above, one from behind and the side.
const OTHER_LIGHTS: [Vec3; 2] = [Vec3::new(0.1, 1.0, 0.15), Vec3::new(-0.8, 0.35, -0.5)];

/// Topic `opacity-shadow`.
pub struct OpacityShadowTopic<'a> {
    subject: &'a Subject,
    recipe: Recipe,
    configurations: Vec<OpacityShadowConfiguration>,
    gpu: Gpu,
    shared: Option<Shared>,
}

/// Data that all rows need.
struct Shared {
    scene: Stage,
    meter: Meter,
    /// Reference image.
    picture: Picture,
    /// Direction towards each light, and its truth.
    truths: Vec<(Vec3, opacity_shadow::StrandLightTruth)>,
    /// Mean width over the strands' points, metres.
    width_m: f32,
}

impl<'a> OpacityShadowTopic<'a> {
    /// Lists the configurations and opens the adapter. Strands are always baked, even if the recipe disables them.
    pub fn new(subject: &'a Subject) -> Result<Self, Failure> {
        let mut recipe = subject.recipe.clone();
        recipe.strands.enabled = true;
        Ok(Self { subject, recipe, configurations: configurations(), gpu: Gpu::open()?, shared: None })
    }
}

impl Topic for OpacityShadowTopic<'_> {
    fn plan(&self) -> Plan {
        let row = |configuration: &OpacityShadowConfiguration| PlannedRow {
            series: configuration.series.into(),
            label: configuration.label.clone(),
            default: configuration.default,
            command: None,
        };
        let (width, height) = (self.recipe.judge.width, self.recipe.judge.height);
        Plan {
            topic: "opacity-shadow",
            title: format!("{} as single strands, {width}x{height} pixels: shadows between strands", self.subject.name),
            adapter: measured_on(&self.gpu.info.name),
            columns: COLUMNS.to_vec(),
            panels: PANELS.to_vec(),
            rows: self.configurations.iter().map(row).collect(),
        }
    }

    fn measure(&mut self, index: usize, doing: &mut dyn FnMut(&str)) -> Result<Vec<Cell>, Failure> {
        let (subject, recipe, gpu) = (self.subject, &self.recipe, &self.gpu);
        let shared = get_or_make(&mut self.shared, || Shared::new(subject, recipe, gpu, doing))?;
        let configuration = &self.configurations[index];
        doing("drawing");
        let measured = shared.measure(configuration, recipe.judge.samples)?;
        Ok(cells(configuration, &measured, shared.meter.clock().word()))
    }
}

impl Shared {
    fn new(subject: &Subject, recipe: &Recipe, gpu: &Gpu, doing: &mut dyn FnMut(&str)) -> Result<Self, Failure> {
        doing("baking");
        let baked = subject.bake(recipe)?;
        let size = (recipe.judge.width, recipe.judge.height);
        let view = PictureView { camera: recipe.judge.views.first().copied(), ..PictureView::sized(size) };
        let view = view.with(|look| {
            look.fur.hair = LookHair::Strands;
            look.picture.samples = Samples(SAMPLES);
            // The chart measures the shadows of the key light.
            look.light.studio = LookStudio::Old;
        });
        let truth = ReferenceTracer::new(&baked, &view)?;
        let points = &truth.scene.curves().points;
        if points.is_empty() {
            let reason = "found no strands, expected a model with hair".into();
            return Err(BakeError::Input { file: subject.file.clone(), place: "hair".into(), reason }.into());
        }
        let width_m = 2.0 * points.iter().map(|p| f64::from(p.radius_m)).sum::<f64>() / points.len() as f64;
        let traced = truth.picture(&view, recipe.judge.samples, &mut |done, all| {
            doing(&format!("reference image, {} %", 100 * done / all.max(1)));
        });
        doing("true light");
        let places = truth.scene.visible_strands(&truth.camera(&view), size, STEP_PX);
        // The default view has a distant light.
        let KeyLight::Distant(key) = view.look.key_light() else {
            return Err(BakeError::Internal("the default look has a point light, expected a distant one".into()).into());
        };
        let lights = std::iter::once(key).chain(OTHER_LIGHTS);
        let truths = lights.map(|towards| {
            let light = TrueLight::Directional { towards_light_ws: towards, color: Vec3::ONE };
            (towards, opacity_shadow::StrandLightTruth::new(&truth.scene, &places, &light))
        });
        let truths = truths.collect();
        let picture = Picture::from(&truth.encode(&traced, &view));
        let scene = stage_of(&baked, &view, || Ok(gpu.clone()))?;
        Ok(Self { meter: Meter::new(gpu), scene, picture, truths, width_m: width_m as f32 })
    }

    fn measure(
        &mut self,
        configuration: &OpacityShadowConfiguration,
        samples: u32,
    ) -> Result<OpacityShadowMeasures, Failure> {
        let params = &mut self.scene.params;
        (params.shadows, params.study) = (configuration.shadows, configuration.study);
        let (mut errors, mut milliseconds, mut measured) =
            (Errors::default(), Vec::new(), OpacityShadowMeasures::default());
        for (i, (towards_light, truth)) in self.truths.iter().enumerate() {
            self.scene.params.light = Light::Directional { towards_light: *towards_light, color: Vec3::ONE };
            let (frame, _) = self.meter.prepared(&mut self.scene, PassId::STRAND_SHADOW)?;
            let map = read_map(&self.scene.gpu, &frame, configuration)?;
            drop(frame);
            let mut fastest = f64::INFINITY;
            for _ in 0..DRAWINGS {
                fastest = fastest.min(self.meter.prepared(&mut self.scene, PassId::STRAND_SHADOW)?.1);
            }
            milliseconds.push(fastest);
            errors = errors.and(truth.errors(&map, configuration.study.light_on_axis));
            measured.places += truth.point_count();
            if i == 0 {
                self.scene.draw()?;
                let drawn = Picture::from(&pixels(&self.scene)?);
                let (difference, _) = compare_pictures(&drawn, &self.picture, &CompareParams::default())?;
                (measured.flip, measured.flip_covered) = (difference.flip.mean, difference.flip.covered);
                measured.image_rmse = difference.rmse;
                measured.bytes = 4 * map.texels.len() as u64;
                measured.texel_widths = map.texel_widths(self.width_m);
                let fur_m = self.scene.model().manifest().fur.height_m;
                let ball = Ball { depth_m: map.view.range_m, fur_m };
                measured.ball = ball.measure(configuration.study.opacity, &configuration.shadows);
            }
        }
        Ok(OpacityShadowMeasures { errors, samples, milliseconds: Spread::of(milliseconds).median, ..measured })
    }
}

/// Copies the map of a submitted frame into memory.
fn read_map(gpu: &Gpu, frame: &Frame, configuration: &OpacityShadowConfiguration) -> Result<DeepMap, Failure> {
    let maps = frame.shadows();
    let lost = || {
        StageError::Device("single strands are not drawn: they need compute shaders with seven storage buffers".into())
    };
    let (maps, buffer) = maps.and_then(|maps| Some((maps, maps.deep()?))).ok_or_else(lost)?;
    let copy = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("deep opacity readback"),
        size: buffer.size(),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
    gpu.queue.submit([encoder.finish()]);
    let bytes = gpu.read_buffer(&copy)?;
    let texels = bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    Ok(DeepMap { view: *maps.view(), opacity: maps.deep_opacity(), form: configuration.study.opacity, texels })
}
