//! `pelage chart cost`: the time of a frame by pixels, layers, triangles, strands and copies.

use super::driver::{Plan, PlannedRow, Topic, get_or_make};
use super::subject::Subject;
use crate::chart::Cell;
use crate::chart::cost::{COLUMNS, CostConfiguration, CostMeasures, Quantity, cells, configurations, panels, sphere};
use pelage_bake::pipeline::{self, BakeInput};
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::groom::MapImages;
use pelage_bake::stages::import::{ImportOptions, import};
use pelage_stage::{Gpu, LookDetail, LookHair, LookStrandEdges, Meter, NamedPackage, Spread, Stage, count_fragments};
use pelage_tool::exit::Failure;
use pelage_tool::machine::measured_on;
use pelage_tool::stages::{pixels, stage_of};
use pelage_tool::view::PictureView;

/// Number of turns, each of which times a frame of the row and one of the first row of its series.
const TURNS: usize = 7;
/// Number of frames before the timed ones.
const WARM_UP: usize = 2;

/// Topic `cost`.
pub struct CostTopic<'a> {
    subject: &'a Subject,
    configurations: Vec<CostConfiguration>,
    gpu: Gpu,
    meter: Meter,
    /// First row of the series measured last.
    first: Option<(Quantity, Scene)>,
    /// Package of the unchanged recipe.
    package: Option<NamedPackage<'static>>,
}

/// Row that is ready to be drawn.
struct Scene {
    stage: Stage,
    measured: CostMeasures,
}

impl<'a> CostTopic<'a> {
    /// Lists the configurations and opens the adapter.
    pub fn new(subject: &'a Subject) -> Result<Self, Failure> {
        let gpu = Gpu::open()?;
        let meter = Meter::new(&gpu);
        Ok(Self { subject, configurations: configurations(), gpu, meter, first: None, package: None })
    }

    /// Returns the size of the picture, pixels.
    fn size(&self, configuration: &CostConfiguration) -> (u32, u32) {
        let judge = &self.subject.recipe.judge;
        let factor = match configuration.quantity {
            Quantity::LayerPixels | Quantity::StrandPixels => configuration.setting,
            _ => 1.0,
        };
        let of = |pixels: u32| (pixels as f32 * factor).round().max(1.0) as u32;
        (of(judge.width), of(judge.height))
    }

    /// Bakes the package, and opens a stage with it.
    fn scene(&mut self, configuration: &CostConfiguration, doing: &mut dyn FnMut(&str)) -> Result<Scene, Failure> {
        let CostConfiguration { quantity, setting } = *configuration;
        let (subject, size, gpu) = (self.subject, self.size(configuration), self.gpu.clone());
        doing("baking");
        let own = match quantity {
            Quantity::Triangles => Some(bake_sphere(setting)?),
            Quantity::Strands => {
                let mut recipe = subject.recipe.clone();
                recipe.hair.density = (recipe.hair.density as f32 * setting) as u32;
                Some(subject.bake(&recipe)?)
            }
            _ => None,
        };
        let file = match &own {
            Some(file) => file,
            None => get_or_make(&mut self.package, || subject.bake(&subject.recipe))?,
        };
        let hair = match quantity {
            Quantity::StrandPixels | Quantity::Strands => LookHair::Strands,
            _ => LookHair::Shells,
        };
        let edges = LookStrandEdges::Samples;
        let mut view = PictureView::sized(size).with(|look| (look.fur.hair, look.fur.strand_edges) = (hair, edges));
        match quantity {
            Quantity::Layers => {
                (view.look.fur.detail, view.look.fur.layers) = (LookDetail::Full, Some(1 + setting as u32));
            }
            Quantity::Triangles => view.look.fur.detail = LookDetail::Full,
            Quantity::Copies => view.crowd = setting as u32,
            _ => {}
        }
        doing("drawing");
        let mut stage = stage_of(file, &view, || Ok(gpu))?;
        let fragments = count_fragments(&mut stage)?;
        let frame = stage.draw()?;
        let manifest = stage.model().manifest();
        let covered_px = pixels(&stage)?.pixels().filter(|pixel| pixel.0[3] > 0).count() as u64;
        let amount = match quantity {
            Quantity::LayerPixels | Quantity::StrandPixels => covered_px as f64,
            Quantity::Layers => frame.report().instances.iter().map(|drawn| f64::from(drawn.layers)).sum(),
            Quantity::Triangles => frame.report().instances.iter().map(|drawn| f64::from(drawn.triangles)).sum(),
            Quantity::Strands => manifest.fur.strands.into(),
            Quantity::Copies => stage.instances.len() as f64,
        };
        let fragments = fragments.map(|passes| passes.iter().map(|(_, count)| count).sum());
        drop(frame);
        Ok(Scene { stage, measured: CostMeasures { amount, covered_px, fragments, milliseconds: 0.0 } })
    }
}

/// Bakes a sphere with the default recipe, without ink.
fn bake_sphere(triangles: f32) -> Result<NamedPackage<'static>, Failure> {
    let mut recipe = Recipe::default();
    recipe.ink.enabled = false;
    let mut no_files = |_: &str, _: u64| Ok(Vec::new());
    let model = import("sphere.obj", sphere(triangles).as_bytes(), &mut no_files, &ImportOptions::default())?;
    let images = MapImages::default();
    let input = BakeInput::new("sphere.obj", "sphere", &recipe, &images);
    let bytes = pipeline::bake(&input, &model, &mut |_| ())?.package;
    Ok(NamedPackage { name: "sphere".into(), bytes: bytes.into() })
}

impl Topic for CostTopic<'_> {
    fn plan(&self) -> Plan {
        let row = |configuration: &CostConfiguration| PlannedRow {
            series: configuration.quantity.word().into(),
            label: configuration.setting.to_string(),
            default: false,
            command: None,
        };
        Plan {
            topic: "cost",
            title: format!("{}: time of a frame by what it draws", self.subject.name),
            adapter: measured_on(&self.gpu.info.name),
            columns: COLUMNS.to_vec(),
            panels: panels(),
            rows: self.configurations.iter().map(row).collect(),
        }
    }

    fn measure(&mut self, index: usize, doing: &mut dyn FnMut(&str)) -> Result<Vec<Cell>, Failure> {
        let configuration = self.configurations[index];
        let quantity = configuration.quantity;
        let smallest = CostConfiguration { quantity, setting: quantity.settings()[0] };
        let mut first = match self.first.take().filter(|(of, _)| *of == quantity) {
            Some((_, scene)) => scene,
            None => self.scene(&smallest, doing)?,
        };
        let mut here = if configuration == smallest { None } else { Some(self.scene(&configuration, doing)?) };
        let (mut times, mut ratios) = (Vec::new(), Vec::new());
        for turn in 0..WARM_UP + TURNS {
            doing("timing");
            let base = self.meter.uncached_frame(&mut first.stage)?;
            let ms = here.as_mut().map_or(Ok(base), |here| self.meter.uncached_frame(&mut here.stage))?;
            if turn >= WARM_UP {
                times.push(ms);
                ratios.push(ms / base);
            }
        }
        let mut measured = here.map_or(first.measured, |here| here.measured);
        measured.milliseconds = Spread::of(times).median;
        let over_first = Spread::of(ratios).median;
        let row = cells(&configuration, self.size(&configuration), (&first.measured, &measured), over_first);
        self.first = Some((quantity, first));
        Ok(row)
    }
}
