//! Measures times and fragment counts of the passes.

use crate::gpu::device_error;
use crate::{Gpu, Stage, StageError};
use pelage_runtime::{Frame, PassId, PassStage, SelfShadow, Style, StyleKind, wgpu};
use web_time::Instant;

/// Source of the times.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Clock {
    /// Timestamps that the device writes between passes.
    TimestampQuery,
    /// Wall clock around the submission of a single pass until it is finished. Includes the overhead of both.
    SubmitAndWait,
}

impl Clock {
    /// Returns the name of this clock in tables and JSON.
    pub fn word(self) -> &'static str {
        match self {
            Self::TimestampQuery => "timestamp-query",
            Self::SubmitAndWait => "submit-and-wait",
        }
    }
}

/// Timed sections of a frame, in milliseconds.
#[derive(Clone, Debug, Default)]
pub struct FrameTimes {
    /// Whole frame in one render pass, as in an application. The light does not move, so the shadow maps of the
    /// previous frame are reused.
    pub frame: f64,
    /// Whole frame without self-shadow and soft shadow. Equal to `frame` if neither is enabled.
    pub unshadowed: f64,
    /// Each pass timed separately; the shadow maps are redrawn.
    pub passes: Vec<(PassId, f64)>,
    /// Baseline: shells with one texture read and no lighting.
    pub yardstick: f64,
}

impl FrameTimes {
    /// Returns the milliseconds of a pass.
    pub fn of(&self, pass: PassId) -> f64 {
        of_pass(&self.passes, pass)
    }
}

/// Returns the milliseconds of a pass in `times`; 0 if it was not measured.
fn of_pass(times: &[(PassId, f64)], pass: PassId) -> f64 {
    times.iter().find(|(id, _)| *id == pass).map_or(0.0, |(_, ms)| *ms)
}

/// Returns the passes that draw the picture, in order.
fn in_picture() -> impl Iterator<Item = PassId> {
    PassId::all().filter(|id| id.stage() == PassStage::Picture)
}

/// Returns whether a pass belongs to a style. Bare frames are measured as fur frames without fur.
pub fn belongs(pass: PassId, style: StyleKind) -> bool {
    let furry = pass.styles().iter().any(|of| *of != StyleKind::Ink);
    if style == StyleKind::Ink { pass.styles().contains(&style) } else { furry }
}

/// Measures a stage frame by frame.
#[derive(Debug)]
pub struct Meter {
    clock: Clock,
    queries: Option<wgpu::QuerySet>,
    resolve: wgpu::Buffer,
    readback: wgpu::Buffer,
}

/// Maximum number of timed sections; larger than the number of passes of a frame.
const MARKS: u32 = 64;

/// Number of timed frames; the fastest is used, because other load only adds time.
const FRAMES: usize = 9;
/// Number of frames before the timed ones, in which pipelines are compiled and shadow maps drawn.
const WARM_UP: usize = 2;

/// Returns the milliseconds of the fastest of several whole frames.
pub fn fastest(meter: &Meter, stage: &mut Stage) -> Result<f64, StageError> {
    let mut fastest = f64::INFINITY;
    for frame in 0..WARM_UP + FRAMES {
        let ms = meter.frame(stage)?;
        if frame >= WARM_UP {
            fastest = fastest.min(ms);
        }
    }
    Ok(fastest)
}

impl Meter {
    /// Creates a meter that uses timestamps if the device has them.
    pub fn new(gpu: &Gpu) -> Self {
        let needed = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        let queries = gpu.device.features().contains(needed).then(|| query_set(gpu, wgpu::QueryType::Timestamp, MARKS));
        let clock = if queries.is_some() { Clock::TimestampQuery } else { Clock::SubmitAndWait };
        let (resolve, readback) = query_buffers(gpu, MARKS);
        Self { clock, queries, resolve, readback }
    }

    /// Returns the source of the meter's times.
    pub fn clock(&self) -> Clock {
        self.clock
    }

    /// Time step of the stage's clock between frames, seconds.
    pub const FRAME_S: f64 = 1.0 / 60.0;

    /// Draws the stage four times (as a whole, without shadows, pass by pass, and as the baseline) and times each.
    ///
    /// The four run consecutively, so that other load on the machine affects all alike. The clock advances by
    /// [`Self::FRAME_S`] between them, so that hair moves in each.
    pub fn measure(&self, stage: &mut Stage) -> Result<FrameTimes, StageError> {
        let mut times = FrameTimes { frame: self.frame(stage)?, ..FrameTimes::default() };
        stage.params.time_s += Self::FRAME_S;
        times.unshadowed = times.frame;
        if is_shadowed(stage) {
            let unshadowed =
                stage.params.clone().with(|p| p.soft_shadow = false).with_fur(|f| f.self_shadow = SelfShadow::Off);
            let asked = std::mem::replace(&mut stage.params, unshadowed);
            let unshadowed = self.frame(stage);
            stage.params = asked;
            times.unshadowed = unshadowed?;
            stage.params.time_s += Self::FRAME_S;
        }
        times.passes = self.passes(stage)?;
        if stage.params.style.kind() == StyleKind::Ink {
            return Ok(times);
        }
        stage.params.debug.yardstick = true;
        stage.params.time_s += Self::FRAME_S;
        let yardstick = self.passes(stage);
        stage.params.debug.yardstick = false;
        times.yardstick = of_pass(&yardstick?, PassId::SHELLS);
        Ok(times)
    }

    /// Returns the milliseconds of one whole frame. The light does not move, as in [`FrameTimes::frame`].
    pub fn frame(&self, stage: &mut Stage) -> Result<f64, StageError> {
        let times = self.sections(stage, |stage, encoder, mark| {
            let frame = stage.prepare(encoder)?;
            frame.draw(&mut stage.pass(encoder, "frame", true));
            mark(encoder);
            Ok(())
        })?;
        Ok(times.into_iter().sum())
    }

    /// Returns the milliseconds of one frame with recomputed pose and shadow maps: the sum of its passes.
    pub fn uncached_frame(&self, stage: &mut Stage) -> Result<f64, StageError> {
        Ok(self.passes(stage)?.iter().map(|(_, ms)| ms).sum())
    }

    /// Returns the milliseconds of each pass, in order.
    fn passes(&self, stage: &mut Stage) -> Result<Vec<(PassId, f64)>, StageError> {
        let mut marked = Vec::new();
        let times = self.sections(stage, |stage, encoder, mark| {
            let frame = stage.prepare_marked(encoder, &mut |encoder, id| {
                mark(encoder);
                marked.push(id);
            })?;
            for (index, id) in in_picture().enumerate() {
                frame.draw_pass(id, &mut stage.pass(encoder, id.name(), index == 0));
                mark(encoder);
                marked.push(id);
            }
            Ok(())
        })?;
        Ok(marked.into_iter().zip(times).collect())
    }

    /// Prepares a frame with redrawn shadow maps and waits for the device. Also returns the milliseconds of `pass`,
    /// which must precede the picture's passes.
    pub fn prepared(&self, stage: &mut Stage, pass: PassId) -> Result<(Frame, f64), StageError> {
        let (mut prepared, mut marked) = (None, Vec::new());
        let times = self.sections(stage, |stage, encoder, mark| {
            prepared = Some(stage.prepare_marked(encoder, &mut |encoder, id| {
                mark(encoder);
                marked.push(id);
            })?);
            Ok(())
        })?;
        let times: Vec<_> = marked.into_iter().zip(times).collect();
        Ok((prepared.ok_or_else(|| device_error("no frame was prepared"))?, of_pass(&times, pass)))
    }

    /// Records sections, fewer than [`MARKS`], and returns the milliseconds of each. A call of `mark` ends a section.
    fn sections(
        &self,
        stage: &mut Stage,
        record: impl FnOnce(
            &mut Stage,
            &mut wgpu::CommandEncoder,
            &mut dyn FnMut(&mut wgpu::CommandEncoder),
        ) -> Result<(), StageError>,
    ) -> Result<Vec<f64>, StageError> {
        let mut times = Vec::new();
        let gpu = stage.gpu.clone();
        let mut encoder = stage.encoder();
        let Some(queries) = &self.queries else {
            let mut failed = None;
            record(stage, &mut encoder, &mut |encoder| {
                let next = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let full = std::mem::replace(encoder, next);
                let start = Instant::now();
                gpu.queue.submit([full.finish()]);
                failed = gpu.wait().err().or(failed.take());
                times.push(start.elapsed().as_secs_f64() * 1e3);
            })?;
            return failed.map_or(Ok(times), Err);
        };
        encoder.write_timestamp(queries, 0);
        let mut section = 0;
        record(stage, &mut encoder, &mut |encoder| {
            section += 1;
            encoder.write_timestamp(queries, section);
        })?;
        encoder.resolve_query_set(queries, 0..section + 1, &self.resolve, 0);
        encoder.copy_buffer_to_buffer(&self.resolve, 0, &self.readback, 0, self.readback.size());
        stage.gpu.queue.submit([encoder.finish()]);
        let ticks = read_u64(&stage.gpu, &self.readback)?;
        let ms_per_tick = f64::from(stage.gpu.queue.get_timestamp_period()) * 1e-6;
        let pairs = ticks.windows(2).take(section as usize);
        // Timestamps of a queue ascend, but a driver may reset its clock. The difference is then 0 instead of a huge
        // number.
        Ok(pairs.map(|pair| pair[1].saturating_sub(pair[0]) as f64 * ms_per_tick).collect())
    }
}

/// Returns whether a frame of the stage has shadow maps.
pub fn is_shadowed(stage: &Stage) -> bool {
    let params = &stage.params;
    match &params.style {
        Style::Fur(fur) => fur.self_shadow != SelfShadow::Off || params.soft_shadow,
        style => style.kind() != StyleKind::Ink && params.soft_shadow,
    }
}

/// Counts the fragment shader invocations of the passes that draw the picture. `None` if the device cannot count them.
pub fn count_fragments(stage: &mut Stage) -> Result<Option<Vec<(PassId, u64)>>, StageError> {
    if !stage.gpu.device.features().contains(wgpu::Features::PIPELINE_STATISTICS_QUERY) {
        return Ok(None);
    }
    let kind = wgpu::QueryType::PipelineStatistics(wgpu::PipelineStatisticsTypes::FRAGMENT_SHADER_INVOCATIONS);
    let count = in_picture().count() as u32;
    let queries = query_set(&stage.gpu, kind, count);
    let (resolve, readback) = query_buffers(&stage.gpu, count);
    let mut encoder = stage.encoder();
    let frame = stage.prepare(&mut encoder)?;
    for (index, id) in in_picture().enumerate() {
        let mut pass = stage.pass(&mut encoder, id.name(), index == 0);
        pass.begin_pipeline_statistics_query(&queries, index as u32);
        frame.draw_pass(id, &mut pass);
        pass.end_pipeline_statistics_query();
    }
    encoder.resolve_query_set(&queries, 0..count, &resolve, 0);
    encoder.copy_buffer_to_buffer(&resolve, 0, &readback, 0, readback.size());
    stage.gpu.queue.submit([encoder.finish()]);
    Ok(Some(in_picture().zip(read_u64(&stage.gpu, &readback)?).collect()))
}

fn query_set(gpu: &Gpu, ty: wgpu::QueryType, count: u32) -> wgpu::QuerySet {
    gpu.device.create_query_set(&wgpu::QuerySetDescriptor { label: Some("pelage bench"), ty, count })
}

/// Creates two buffers of 8 bytes per query: one into which queries are resolved, one for reading back.
fn query_buffers(gpu: &Gpu, count: u32) -> (wgpu::Buffer, wgpu::Buffer) {
    let buffer = |usage| {
        gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("pelage bench"),
            size: u64::from(count) * 8,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    };
    let resolve = buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC);
    (resolve, buffer(wgpu::BufferUsages::MAP_READ))
}

fn read_u64(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<u64>, StageError> {
    Ok(gpu.read_buffer(buffer)?.chunks_exact(8).map(bytemuck::pod_read_unaligned).collect())
}

/// Minimum, median and maximum of several times; zeros if there are none.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Spread {
    /// Minimum.
    pub min: f64,
    /// Median; the mean of the middle two for an even count.
    pub median: f64,
    /// Maximum.
    pub max: f64,
}

impl Spread {
    /// Computes the spread of some values, which may be in any order.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let (Some(min), Some(max)) = (values.first(), values.last()) else { return Self::default() };
        let n = values.len();
        Self { min: *min, median: (values[(n - 1) / 2] + values[n / 2]) / 2.0, max: *max }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_of_an_even_count_is_the_mean_of_the_middle() {
        assert_eq!(Spread::of([3.0, 1.0, 2.0]), Spread { min: 1.0, median: 2.0, max: 3.0 });
        assert_eq!(Spread::of([4.0, 1.0]).median, 2.5);
        assert_eq!(Spread::of([]), Spread::default());
    }
}
