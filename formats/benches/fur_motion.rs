//! Benchmark `cargo bench -p pelage-formats --bench fur_motion`: measures the cost of one frame (1/60 s) on one core,
//! for a million fur tips in gusts. Prints the minimum, median and maximum time over thirty frames.
#![allow(clippy::disallowed_methods, reason = "a benchmark makes no package")]

use glam::Vec3;
use pelage_formats::meaning::fur_motion::{Frame, Tip, advance, initial_tip, lean, tip_offset};
use pelage_formats::meaning::hair_motion::Wind;
use std::time::Instant;

const TIPS: usize = 1_000_000;
const LENGTH_M: f32 = 0.03;
const SECONDS: f32 = 1.0 / 60.0;

fn main() {
    let wind = Wind { velocity: Vec3::new(4.0, 0.0, 1.0), gust: 0.5, turbulence: 0.4, ..Wind::default() };
    let root = |tip: usize| Vec3::new(0.001 * (tip % 1000) as f32, 0.001 * (tip / 1000) as f32, 0.0);
    let mut tips: Vec<Tip> = (0..TIPS).map(|tip| initial_tip(LENGTH_M, root(tip), &wind, 0.0)).collect();
    let mut leant = 0.0f64;
    let mut took: Vec<f64> = (1..=30u8)
        .map(|number| {
            let frame = Frame { seconds: SECONDS, before_s: SECONDS, wind: &wind, time_s: f32::from(number) * SECONDS };
            let began = Instant::now();
            for (number, tip) in tips.iter_mut().enumerate() {
                *tip = advance(*tip, LENGTH_M, root(number), Vec3::X * 0.01, &frame);
                leant += lean(tip_offset(tip, LENGTH_M, SECONDS), Vec3::Y, LENGTH_M, 1.0)
                    .map_or(0.0, |(angle, _)| f64::from(angle));
            }
            began.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    took.sort_by(f64::total_cmp);
    let [least, median, greatest] = [took[0], took[took.len() / 2], took[took.len() - 1]];
    let mean = leant / (30 * TIPS) as f64;
    println!(
        "1 000 000 tips that lean by {mean:.2} rad: \
         least {least:.1}, median {median:.1}, greatest {greatest:.1} ms a frame"
    );
}
