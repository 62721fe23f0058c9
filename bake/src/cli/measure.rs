//! Times and fragment counts of the passes: the measuring half of `bench`.

use super::exit::Failure;
use super::gpu::{Gpu, read_buffer};
use super::scene::Scene;
use pelage_runtime::{Frame, PassId, wgpu};
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

/// Timed sections of a frame, in milliseconds.
#[derive(Clone, Copy, Debug, Default)]
pub struct FrameTimes {
    /// Everything in one render pass, as an application draws it.
    pub frame: f64,
    /// Each of [`PASSES`] in a pass of its own.
    pub passes: [f64; 4],
    /// The shells with one texture read and no lighting.
    pub yardstick: f64,
}

/// The measured passes, in the order of [`FrameTimes::passes`].
pub const PASSES: [PassId; 4] = [PassId::Pose, PassId::Skin, PassId::Fins, PassId::Shells];

/// Measures a scene frame by frame.
#[derive(Debug)]
pub struct Meter {
    clock: Clock,
    queries: Option<wgpu::QuerySet>,
    resolve: wgpu::Buffer,
    readback: wgpu::Buffer,
}

const MARKS: u32 = 8;

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

    /// Draws the scene three times (as a whole, pass by pass, and as the yardstick) and times each.
    ///
    /// All three in one go, so that what else the machine does falls on all of them alike.
    pub fn measure(&self, scene: &mut Scene) -> Result<FrameTimes, Failure> {
        let mut times = FrameTimes::default();
        let [frame] = self.sections(scene, |scene, encoder, _| {
            let frame = scene.prepare(encoder)?;
            frame.draw(&mut scene.pass(encoder, "frame", true));
            Ok(())
        })?;
        times.frame = frame;

        // Posing was done for the frame above; the same motion is not posed twice, so ask for it again.
        scene.instance.invalidate();
        times.passes = self.passes(scene)?;
        scene.params.yardstick = true;
        let yardstick = self.passes(scene);
        scene.params.yardstick = false;
        times.yardstick = yardstick?[PASSES.len() - 1];
        Ok(times)
    }

    fn passes(&self, scene: &mut Scene) -> Result<[f64; PASSES.len()], Failure> {
        let mut frame: Option<Frame> = None;
        self.sections(scene, |scene, encoder, section| {
            if section == 0 {
                frame = Some(scene.prepare(encoder)?);
            } else if let Some(frame) = &frame {
                let mut pass = scene.pass(encoder, PASSES[section].name(), section == 1);
                frame.draw_pass(PASSES[section], &mut pass);
            }
            Ok(())
        })
    }

    /// Records `N` sections, fewer than [`MARKS`], and returns the milliseconds that each took.
    fn sections<const N: usize>(
        &self,
        scene: &mut Scene,
        mut record: impl FnMut(&mut Scene, &mut wgpu::CommandEncoder, usize) -> Result<(), Failure>,
    ) -> Result<[f64; N], Failure> {
        let mut times = [0.0; N];
        let Some(queries) = &self.queries else {
            for (section, time) in times.iter_mut().enumerate() {
                let mut encoder = scene.encoder();
                record(scene, &mut encoder, section)?;
                let start = Instant::now();
                scene.gpu.queue.submit([encoder.finish()]);
                scene.gpu.wait()?;
                *time = start.elapsed().as_secs_f64() * 1e3;
            }
            return Ok(times);
        };
        let mut encoder = scene.encoder();
        encoder.write_timestamp(queries, 0);
        for section in 0..times.len() {
            record(scene, &mut encoder, section)?;
            encoder.write_timestamp(queries, section as u32 + 1);
        }
        encoder.resolve_query_set(queries, 0..times.len() as u32 + 1, &self.resolve, 0);
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

/// Fragment shader runs of each of [`PASSES`] in one frame, 0 of those without any; `None` where the device does not count them.
pub fn count_fragments(scene: &mut Scene) -> Result<Option<[u64; PASSES.len()]>, Failure> {
    if !scene.gpu.device.features().contains(wgpu::Features::PIPELINE_STATISTICS_QUERY) {
        return Ok(None);
    }
    let kind = wgpu::QueryType::PipelineStatistics(wgpu::PipelineStatisticsTypes::FRAGMENT_SHADER_INVOCATIONS);
    let count = PASSES.len() as u32 - 1;
    let queries = query_set(&scene.gpu, kind, count);
    let (resolve, readback) = query_buffers(&scene.gpu, count);
    let mut encoder = scene.encoder();
    let frame = scene.prepare(&mut encoder)?;
    for (index, id) in PASSES.into_iter().skip(1).enumerate() {
        let mut pass = scene.pass(&mut encoder, id.name(), index == 0);
        pass.begin_pipeline_statistics_query(&queries, index as u32);
        frame.draw_pass(id, &mut pass);
        pass.end_pipeline_statistics_query();
    }
    encoder.resolve_query_set(&queries, 0..count, &resolve, 0);
    encoder.copy_buffer_to_buffer(&resolve, 0, &readback, 0, readback.size());
    scene.gpu.queue.submit([encoder.finish()]);
    let mut counts = [0; PASSES.len()];
    // The first pass is compute.
    counts[1..].iter_mut().zip(read_u64(&scene.gpu, &readback)?).for_each(|(count, found)| *count = found);
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
