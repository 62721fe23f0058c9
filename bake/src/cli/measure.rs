//! Times and fragment counts of the passes: the measuring half of `bench`.

use super::exit::Failure;
use super::gpu::{Gpu, lost, read_buffer};
use super::scene::Scene;
use pelage_runtime::{Frame, PassId, Style, wgpu};
use std::time::Instant;

/// Where times come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Clock {
    /// Timestamps that the device writes between the passes.
    TimestampQuery,
    /// The wall clock around submitting a pass alone and waiting for it: contains the cost of doing so.
    SubmitAndWait,
}

impl Clock {
    /// The word in tables and JSON.
    pub fn word(self) -> &'static str {
        match self {
            Self::TimestampQuery => "timestamp-query",
            Self::SubmitAndWait => "submit-and-wait",
        }
    }
}

/// Timed sections of a frame, in milliseconds.
#[derive(Clone, Copy, Debug, Default)]
pub struct FrameTimes {
    /// Everything in one render pass, as an application draws it. The light stands still: shadow maps are those of the frame before.
    pub frame: f64,
    /// The same without self-shadow and soft shadow; the same as `frame` where there are none anyway.
    pub unshadowed: f64,
    /// Each of [`PASSES`] in a pass of its own, the shadow maps drawn anew.
    pub passes: [f64; PASSES.len()],
    /// The shells with one texture read and no lighting.
    pub yardstick: f64,
}

/// The measured passes, in the order of [`FrameTimes::passes`].
pub const PASSES: [PassId; PassId::ALL.len()] = PassId::ALL;
/// Those of them, from the first, that are recorded while a frame is prepared.
const PREPARED: usize = 7;

/// Where a pass stands in [`PASSES`].
pub fn index_of(pass: PassId) -> usize {
    PASSES.iter().position(|id| *id == pass).unwrap_or_default()
}

/// Whether a style has a pass at all.
pub fn belongs(pass: PassId, style: Style) -> bool {
    let furs = [PassId::LayerShadow, PassId::ShadowWidth, PassId::Skin, PassId::Fins, PassId::Shells];
    pass == PassId::Pose || furs.contains(&pass) == (style != Style::Ink)
}

/// Measures a scene frame by frame.
#[derive(Debug)]
pub struct Meter {
    clock: Clock,
    queries: Option<wgpu::QuerySet>,
    resolve: wgpu::Buffer,
    readback: wgpu::Buffer,
}

const MARKS: u32 = 16;

/// Timed frames, of which the fastest counts: what else the machine does only adds. And those before, in which pipelines are compiled and
/// shadow maps drawn.
const FRAMES: usize = 9;
const WARM_UP: usize = 2;

/// Milliseconds of the fastest of some frames, each as a whole.
pub fn fastest(meter: &Meter, scene: &mut Scene) -> Result<f64, Failure> {
    let mut fastest = f64::INFINITY;
    for frame in 0..WARM_UP + FRAMES {
        let ms = meter.frame(scene)?;
        if frame >= WARM_UP {
            fastest = fastest.min(ms);
        }
    }
    Ok(fastest)
}

impl Meter {
    /// Takes timestamps where the device has them.
    pub fn new(gpu: &Gpu) -> Self {
        let needed = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        let queries = gpu.device.features().contains(needed).then(|| query_set(gpu, wgpu::QueryType::Timestamp, MARKS));
        let clock = if queries.is_some() { Clock::TimestampQuery } else { Clock::SubmitAndWait };
        let (resolve, readback) = query_buffers(gpu, MARKS);
        Self { clock, queries, resolve, readback }
    }

    /// Where its times come from.
    pub fn clock(&self) -> Clock {
        self.clock
    }

    /// Draws the scene four times (as a whole, without shadows, pass by pass, and as the yardstick) and times each.
    ///
    /// All in one go, so that what else the machine does falls on all of them alike.
    pub fn measure(&self, scene: &mut Scene) -> Result<FrameTimes, Failure> {
        let mut times = FrameTimes { frame: self.frame(scene)?, ..FrameTimes::default() };
        let asked = (scene.params.self_shadow, scene.params.soft_shadow);
        times.unshadowed = times.frame;
        if asked != (false, false) {
            (scene.params.self_shadow, scene.params.soft_shadow) = (false, false);
            let unshadowed = self.frame(scene);
            (scene.params.self_shadow, scene.params.soft_shadow) = asked;
            times.unshadowed = unshadowed?;
        }
        times.passes = self.passes(scene)?;
        if scene.params.style == Style::Ink {
            return Ok(times);
        }
        scene.params.yardstick = true;
        let yardstick = self.passes(scene);
        scene.params.yardstick = false;
        times.yardstick = yardstick?[index_of(PassId::Shells)];
        Ok(times)
    }

    /// Milliseconds of one frame as a whole; the light stands still, as in [`FrameTimes::frame`].
    pub fn frame(&self, scene: &mut Scene) -> Result<f64, Failure> {
        let [frame] = self.sections(scene, |scene, encoder, mark| {
            let frame = scene.prepare(encoder)?;
            frame.draw(&mut scene.pass(encoder, "frame", true));
            mark(encoder);
            Ok(())
        })?;
        Ok(frame)
    }

    fn passes(&self, scene: &mut Scene) -> Result<[f64; PASSES.len()], Failure> {
        self.sections(scene, |scene, encoder, mark| {
            let frame = scene.prepare_marked(encoder, &mut |encoder, _| mark(encoder))?;
            for (index, id) in PASSES.into_iter().skip(PREPARED).enumerate() {
                frame.draw_pass(id, &mut scene.pass(encoder, id.name(), index == 0));
                mark(encoder);
            }
            Ok(())
        })
    }

    /// Prepares a frame whose shadow maps are drawn anew, and has the device do that; with it the milliseconds of pose, layer-wise maps
    /// and shadow-width map.
    pub fn prepared(&self, scene: &mut Scene) -> Result<(Frame, [f64; PREPARED]), Failure> {
        let mut prepared = None;
        let times = self.sections(scene, |scene, encoder, mark| {
            prepared = Some(scene.prepare_marked(encoder, &mut |encoder, _| mark(encoder))?);
            Ok(())
        })?;
        Ok((prepared.ok_or_else(|| lost("no frame was prepared"))?, times))
    }

    /// Records `N` sections, fewer than [`MARKS`], each ended by a call of `mark`, and returns the milliseconds that each took.
    fn sections<const N: usize>(
        &self,
        scene: &mut Scene,
        record: impl FnOnce(
            &mut Scene,
            &mut wgpu::CommandEncoder,
            &mut dyn FnMut(&mut wgpu::CommandEncoder),
        ) -> Result<(), Failure>,
    ) -> Result<[f64; N], Failure> {
        let mut times = [0.0; N];
        let gpu = scene.gpu.clone();
        let mut encoder = scene.encoder();
        let Some(queries) = &self.queries else {
            let (mut section, mut failed) = (0, None);
            record(scene, &mut encoder, &mut |encoder| {
                let next = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let full = std::mem::replace(encoder, next);
                let start = Instant::now();
                gpu.queue.submit([full.finish()]);
                failed = gpu.wait().err().or(failed.take());
                times[section] = start.elapsed().as_secs_f64() * 1e3;
                section += 1;
            })?;
            return failed.map_or(Ok(times), Err);
        };
        encoder.write_timestamp(queries, 0);
        let mut section = 0;
        record(scene, &mut encoder, &mut |encoder| {
            section += 1;
            encoder.write_timestamp(queries, section);
        })?;
        encoder.resolve_query_set(queries, 0..N as u32 + 1, &self.resolve, 0);
        encoder.copy_buffer_to_buffer(&self.resolve, 0, &self.readback, 0, self.readback.size());
        scene.gpu.queue.submit([encoder.finish()]);
        let ticks = read_u64(&scene.gpu, &self.readback)?;
        let ms_per_tick = f64::from(scene.gpu.queue.get_timestamp_period()) * 1e-6;
        for (time, pair) in times.iter_mut().zip(ticks.windows(2)) {
            // Timestamps of one queue rise, but a driver may reset its clock: then no time is better than a huge one.
            *time = pair[1].saturating_sub(pair[0]) as f64 * ms_per_tick;
        }
        Ok(times)
    }
}

/// Fragment shader runs of each of [`PASSES`] that draw the picture, 0 of the others; `None` where the device does not count them.
pub fn count_fragments(scene: &mut Scene) -> Result<Option<[u64; PASSES.len()]>, Failure> {
    if !scene.gpu.device.features().contains(wgpu::Features::PIPELINE_STATISTICS_QUERY) {
        return Ok(None);
    }
    let kind = wgpu::QueryType::PipelineStatistics(wgpu::PipelineStatisticsTypes::FRAGMENT_SHADER_INVOCATIONS);
    let count = (PASSES.len() - PREPARED) as u32;
    let queries = query_set(&scene.gpu, kind, count);
    let (resolve, readback) = query_buffers(&scene.gpu, count);
    let mut encoder = scene.encoder();
    let frame = scene.prepare(&mut encoder)?;
    for (index, id) in PASSES.into_iter().skip(PREPARED).enumerate() {
        let mut pass = scene.pass(&mut encoder, id.name(), index == 0);
        pass.begin_pipeline_statistics_query(&queries, index as u32);
        frame.draw_pass(id, &mut pass);
        pass.end_pipeline_statistics_query();
    }
    encoder.resolve_query_set(&queries, 0..count, &resolve, 0);
    encoder.copy_buffer_to_buffer(&resolve, 0, &readback, 0, readback.size());
    scene.gpu.queue.submit([encoder.finish()]);
    let mut counts = [0; PASSES.len()];
    counts[PREPARED..].iter_mut().zip(read_u64(&scene.gpu, &readback)?).for_each(|(count, found)| *count = found);
    Ok(Some(counts))
}

fn query_set(gpu: &Gpu, ty: wgpu::QueryType, count: u32) -> wgpu::QuerySet {
    gpu.device.create_query_set(&wgpu::QuerySetDescriptor { label: Some("pelage bench"), ty, count })
}

/// Where queries are resolved to, and where they are read from: 8 bytes each.
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

fn read_u64(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<u64>, Failure> {
    Ok(read_buffer(gpu, buffer)?.chunks_exact(8).map(bytemuck::pod_read_unaligned).collect())
}

/// Least, middle and greatest of some times; zeros for none.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Spread {
    /// Least.
    pub min: f64,
    /// Middle one; of an even number the mean of the two.
    pub median: f64,
    /// Greatest.
    pub max: f64,
}

impl Spread {
    /// Of some values, in any order.
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
    fn the_median_is_the_middle() {
        assert_eq!(Spread::of([3.0, 1.0, 2.0]), Spread { min: 1.0, median: 2.0, max: 3.0 });
        assert_eq!(Spread::of([4.0, 1.0]).median, 2.5);
        assert_eq!(Spread::of([]), Spread::default());
    }
}
