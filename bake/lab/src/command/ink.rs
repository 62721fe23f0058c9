//! `pelage chart ink`: drawn lines, compared with those of the mesh.

use super::driver::{Plan, PlannedRow, Topic, get_or_make};
use super::greys::greys;
use super::subject::Subject;
use crate::chart::{Cell, ink};
use crate::compare_lines::measure_lines;
use crate::compare_motion::{Flicker, FlickerFrame, flicker};
use crate::mask::Mask;
use crate::measure_painting::{body, drawn_lines, measure_painting};
use crate::truth::{LineParams, TrueLines};
use glam::Vec3;
use pelage_bake::strands::PosedMesh;
use pelage_runtime::{InkDebugView, InkLines, InkParams, PictureStroke, Style};
use pelage_stage::{Gpu, LookStyle, Meter, NamedPackage, Stage, fastest, framing, outline};
use pelage_tool::exit::Failure;
use pelage_tool::machine::measured_on;
use pelage_tool::stages::{pixels, stage_of};
use pelage_tool::truth::true_camera;
use pelage_tool::view::PictureView;

/// Number of frames of the slow turn for flicker, and degrees between frames.
const TURN: (u32, f32) = (4, 1.0);
/// Byte value below which a pixel is ink: half of the light, sRGB-encoded.
const INK: u8 = 188;
/// Byte value below which a pixel is at least faint ink.
const FAINT: u8 = 253;

/// Topic `ink`.
pub struct InkTopic<'a> {
    subject: &'a Subject,
    configurations: Vec<ink::InkConfiguration>,
    gpu: Gpu,
    shared: Option<Shared>,
}

/// Data that all rows need.
struct Shared {
    file: NamedPackage<'static>,
    rest_points: Vec<Vec3>,
    lines: TrueLines,
    meter: Meter,
    /// Scene of the previous row, which rows of the same size share.
    scene: Option<(PictureView, Stage)>,
}

impl<'a> InkTopic<'a> {
    /// Lists the configurations and opens the adapter.
    pub fn new(subject: &'a Subject) -> Result<Self, Failure> {
        Ok(Self { subject, configurations: ink::configurations(), gpu: Gpu::open()?, shared: None })
    }
}

impl Topic for InkTopic<'_> {
    fn plan(&self) -> Plan {
        let row = |configuration: &ink::InkConfiguration| PlannedRow {
            series: configuration.series.into(),
            label: configuration.label.clone(),
            default: configuration.default,
            command: None,
        };
        Plan {
            topic: "ink",
            title: format!("{}: ink lines against the contours and creases of the mesh", self.subject.name),
            adapter: measured_on(&self.gpu.info.name),
            columns: ink::COLUMNS.to_vec(),
            panels: ink::PANELS.to_vec(),
            rows: self.configurations.iter().map(row).collect(),
        }
    }

    fn measure(&mut self, index: usize, doing: &mut dyn FnMut(&str)) -> Result<Vec<Cell>, Failure> {
        let (subject, gpu) = (self.subject, &self.gpu);
        let shared = get_or_make(&mut self.shared, || {
            doing("baking");
            Shared::new(subject, gpu)
        })?;
        doing("drawing");
        let look = &self.configurations[index].look;
        Ok(ink::cells(look, &shared.measure(look, gpu)?))
    }
}

impl Shared {
    fn new(subject: &Subject, gpu: &Gpu) -> Result<Self, Failure> {
        let file = match &subject.package {
            Some(package) => NamedPackage { name: package.name.clone(), bytes: package.bytes.clone() },
            None => subject.bake(&subject.recipe)?,
        };
        let opened = file.open()?;
        let rest_points = outline(&file, &opened, None, None)?;
        let lines = TrueLines::new(PosedMesh::posed(&file.name, &opened, &[])?)?;
        drop(opened);
        Ok(Self { rest_points, lines, meter: Meter::new(gpu), scene: None, file })
    }

    /// Draws with one configuration from both sides, times it, and measures flicker while the camera slowly turns.
    fn measure(&mut self, wanted: &ink::InkSettings, gpu: &Gpu) -> Result<ink::InkMeasures, Failure> {
        let ink::InkSettings { size, ink, study } = wanted;
        let (size, (width, height)) = (*size, *size);
        let camera = |towards| framing::frame(&self.rest_points, 0.0, width as f32 / height as f32, towards);
        let cameras = [framing::TOWARDS_CAMERA, framing::BEHIND].map(camera);
        if self.scene.as_ref().is_none_or(|(view, _)| view.size() != size) {
            let view = PictureView { camera: Some(cameras[0]), ..PictureView::sized(size) };
            let view = view.with(|look| look.picture.style = LookStyle::Ink);
            self.scene = Some((view.clone(), stage_of(&self.file, &view, || Ok(gpu.clone()))?));
        }
        let Some((_, scene)) = &mut self.scene else {
            return Err(pelage_import::BakeError::Internal("no scene to draw".into()).into());
        };
        let is_painted = ink.lines == InkLines::Strokes;
        let look = |scene: &mut Stage, camera, show, ink: InkParams| -> Result<_, Failure> {
            scene.look_from(camera);
            scene.params.style = Style::Ink(ink);
            (scene.params.study, scene.params.debug.ink) = (*study, show);
            let frame = scene.draw()?;
            let strokes: Vec<PictureStroke> = if is_painted { scene.strokes(&frame)? } else { Vec::new() };
            Ok((pixels(scene)?, strokes))
        };
        let blank = ink::on_blank_paper(ink);
        // Lines in black on white, and their middles.
        let lines_of = |scene: &mut Stage, camera| -> Result<[Mask; 2], Failure> {
            if is_painted {
                let (picture, strokes) = look(scene, camera, InkDebugView::Painting, ink::lines_alone(&blank))?;
                return Ok([Mask::darker(&picture, INK), drawn_lines(&strokes, size, 0.5)]);
            }
            let views = [InkDebugView::Lines, InkDebugView::Features];
            let [lines, features] = views.map(|show| look(scene, camera, show, blank.clone()));
            Ok([Mask::darker(&lines?.0, INK), Mask::darker(&features?.0, INK)])
        };
        let mut measured = ink::InkMeasures::default();
        for camera in cameras {
            let eye = true_camera(camera);
            let truth = self.lines.visible_from(&eye, size, &LineParams::default())?;
            let [lines, middles] = lines_of(scene, camera)?;
            measured.views.push(measure_lines(&middles, &lines, &truth)?);
            let (picture, strokes) = look(scene, camera, InkDebugView::Painting, ink.clone())?;
            measured.paintings.push(measure_painting(&strokes, &picture, &body(self.lines.sight(), &eye, size))?);
            measured.frame_ms = measured.frame_ms.max(fastest(&self.meter, scene)?);
        }
        let mut sum = Flicker::default();
        let mut before: Option<(_, Vec<f32>, Mask)> = None;
        for frame in 0..TURN.0 {
            let camera = cameras[0].turned((TURN.1 * frame as f32).to_radians());
            let show = if is_painted { InkDebugView::Painting } else { InkDebugView::Lines };
            let shown = if is_painted { ink::lines_alone(&blank) } else { blank.clone() };
            let lines = Mask::darker(&look(scene, camera, show, shown)?.0, if is_painted { INK } else { FAINT });
            let grey = greys(&look(scene, camera, InkDebugView::Painting, blank.clone())?.0);
            let camera = true_camera(camera);
            if let Some((camera_before, grey_before, lines_before)) = &before {
                let sight = self.lines.sight();
                let now = FlickerFrame { sight, camera: camera_before, grey: grey_before, lines: lines_before };
                let next = FlickerFrame { sight, camera: &camera, grey: &grey, lines: &lines };
                sum = sum.joined(flicker(&now, &next, size)?);
            }
            before = Some((camera, grey, lines));
        }
        measured.flicker = [sum.surface.mean(), sum.wash.mean(), sum.lines.mean()];
        Ok(measured)
    }
}
