//! `pelage chart detail`: layers, triangles and texels at four sizes, compared with the true strands.

use super::driver::{Plan, PlannedRow, Topic, get_or_make};
use super::subject::Subject;
use crate::chart::{Cell, detail};
use pelage_bake::recipe::Recipe;
use pelage_runtime::wgpu::Features;
use pelage_stage::{Gpu, LookDetail, LookHair, NamedPackage, Viewpoint};
use pelage_tool::exit::Failure;
use pelage_tool::machine::measured_on;
use pelage_tool::shell_judge::{ShellJudge, cameras};
use pelage_tool::stages::stage_of;
use pelage_tool::truth::ReferenceTracer;
use pelage_tool::view::PictureView;

/// Topic `detail`.
pub struct DetailTopic<'a> {
    subject: &'a Subject,
    configurations: Vec<detail::DetailConfiguration>,
    gpu: Gpu,
    /// Strands and their viewpoint, which are the same for all sizes and recipes.
    truth: Option<(ReferenceTracer, Viewpoint)>,
    /// Reference image of each size, and the values shared by its rows.
    sizes: [Option<(ShellJudge<'a>, detail::DetailSizeFacts)>; detail::Size::ALL.len()],
    /// Baked packages by recipe; all sizes draw the same ones.
    packages: Vec<(Recipe, NamedPackage<'static>)>,
}

impl<'a> DetailTopic<'a> {
    /// Lists the configurations and opens the adapter.
    pub fn new(subject: &'a Subject) -> Result<Self, Failure> {
        let configurations = detail::configurations(&subject.recipe)?;
        let (gpu, sizes) = (Gpu::open()?, [const { None }; detail::Size::ALL.len()]);
        Ok(Self { subject, configurations, gpu, truth: None, sizes, packages: Vec::new() })
    }
}

impl Topic for DetailTopic<'_> {
    fn plan(&self) -> Plan {
        let row = |configuration: &detail::DetailConfiguration| PlannedRow {
            series: configuration.series.into(),
            label: configuration.label.clone(),
            default: configuration.default,
            command: None,
        };
        let words = detail::Size::ALL.map(|size| {
            let (width, height) = size.pixels(&self.subject.recipe);
            format!("{width}x{height}")
        });
        Plan {
            topic: "detail",
            title: format!(
                "{}, {} pixels: levels of detail against the true strands",
                self.subject.name,
                words.join(", ")
            ),
            adapter: measured_on(&self.gpu.info.name),
            columns: detail::COLUMNS.to_vec(),
            panels: detail::panels(self.gpu.device.features().contains(Features::PIPELINE_STATISTICS_QUERY)),
            rows: self.configurations.iter().map(row).collect(),
        }
    }

    fn measure(&mut self, index: usize, doing: &mut dyn FnMut(&str)) -> Result<Vec<Cell>, Failure> {
        let (subject, base) = (self.subject, &self.subject.recipe);
        let configuration = &self.configurations[index];
        let size = detail::Size::ALL[configuration.size];
        let (gpu, truth, packages) = (&self.gpu, &mut self.truth, &mut self.packages);
        let (judge, seen) = get_or_make(&mut self.sizes[configuration.size], || {
            let file = baked(packages, subject, base, doing)?;
            let (truth, camera) = get_or_make(truth, || {
                let truth = ReferenceTracer::new(file, &PictureView::default())?;
                let camera = cameras(base, &truth)[0];
                Ok((truth, camera))
            })?;
            let (pixels, samples) = (size.pixels(base), base.judge.samples);
            let baker = Box::new(move |recipe: &Recipe| subject.bake(recipe));
            let judge = ShellJudge::of_views(baker, truth, pixels, &[*camera], samples, gpu, doing);
            let fur_px = fur_px(file, pixels, *camera, gpu)?;
            Ok((judge, detail::DetailSizeFacts { pixels, fur_px, samples }))
        })?;
        let file = baked(packages, subject, &configuration.recipe, doing)?;
        doing("drawing");
        let (measured, _) = judge.measure_drawn(file, configuration.detail)?;
        Ok(detail::cells(configuration, seen, &measured, judge.timing()))
    }
}

/// Returns the fur height on screen at the nearest point of the model, pixels, in a picture of the given size. It is
/// computed as in the runtime. `None` if the package has no levels of detail, or the eye is within the model's bounds.
fn fur_px(file: &NamedPackage<'_>, size: (u32, u32), camera: Viewpoint, gpu: &Gpu) -> Result<Option<f32>, Failure> {
    let view = PictureView { camera: Some(camera), ..PictureView::sized(size) };
    let view = view.with(|look| (look.fur.detail, look.fur.hair) = (LookDetail::Auto, LookHair::Shells));
    let frame = stage_of(file, &view, || Ok(gpu.clone()))?.draw()?;
    Ok(frame.report().instances.first().and_then(|drawn| drawn.fur_px).filter(|px| px.is_finite()))
}

/// Returns the package of a recipe, baking it if it is not cached yet.
fn baked<'p>(
    packages: &'p mut Vec<(Recipe, NamedPackage<'static>)>,
    subject: &Subject,
    recipe: &Recipe,
    doing: &mut dyn FnMut(&str),
) -> Result<&'p NamedPackage<'static>, Failure> {
    let index = match packages.iter().position(|(of, _)| of == recipe) {
        Some(index) => index,
        None => {
            doing("baking");
            packages.push((recipe.clone(), subject.bake(recipe)?));
            packages.len() - 1
        }
    };
    Ok(&packages[index].1)
}
