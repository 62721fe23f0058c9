//! Benchmark `cargo bench -p pelage-formats --bench hair_motion`: measures the cost of one frame (1/60 s) on one core,
//! for 1 000 guides at a gallop among 8 colliders. The cost is measured for several numbers of points per guide. Prints
//! the minimum, median and maximum time over two seconds of motion.
#![allow(clippy::disallowed_methods, reason = "a benchmark makes no package")]

use glam::{Mat3, Vec3};
use pelage_formats::meaning::hair_motion::{
    Capsule, Frame, GRAVITY, GroomedGuide, Particle, RootFrame, Springs, Wind, advance_frame, gravity_compensation,
    steps,
};
use std::time::Instant;

const GUIDES: usize = 1000;
const FPS: f32 = 60.0;
const SPRINGS: Springs = Springs { drag_per_s: 2.0, shape_hz: 0.5, bend_hz: 1.2, friction: 0.2 };

fn rooted(guide: usize, time_s: f32) -> RootFrame {
    let turns = std::f32::consts::TAU * 2.2 * time_s;
    let root = Vec3::new(0.0004 * guide as f32, 0.15 * turns.sin(), 9.0 * time_s);
    RootFrame { root, frame: Mat3::from_rotation_x(0.3 * turns.sin()) }
}

fn colliders(time_s: f32) -> Vec<Capsule> {
    let ball = |k: u8| {
        let place = Vec3::new(0.05 * f32::from(k), -0.2, 9.0 * time_s - 0.1);
        Capsule { from: place, to: place + Vec3::Y * 0.1, radius_m: 0.06 }
    };
    (0..8).map(ball).collect()
}

fn main() {
    for points in [7usize, 16, 36, 64] {
        let groomed: Vec<Vec3> =
            (0..points).map(|k| Vec3::new(0.0, -0.3, 0.1) * (k as f32 / (points - 1) as f32)).collect();
        let gravity = gravity_compensation(&groomed, Mat3::IDENTITY);
        let free: Vec<f32> = (0..points).map(|k| (4.0 * k as f32 / points as f32).min(1.0)).collect();
        let guide = GroomedGuide { points: &groomed, ballast: &gravity, free: &free };
        let mut all: Vec<Vec<Particle>> = (0..GUIDES).map(|g| rooted(g, 0.0).groomed(&groomed)).collect();
        let mut took: Vec<f64> = (1..=120u16)
            .map(|number| {
                let [from, to] = [number - 1, number].map(|n| f32::from(n) / FPS);
                let moving: Vec<_> = colliders(from).into_iter().zip(colliders(to)).map(|(a, b)| [a, b]).collect();
                let frame = Frame {
                    seconds: to - from,
                    before_s: steps(1.0 / FPS).1,
                    gravity: Vec3::NEG_Y * GRAVITY,
                    wind: Wind::default(),
                    time_s: to,
                    colliders: &moving,
                };
                let began = Instant::now();
                for (number, pearls) in all.iter_mut().enumerate() {
                    advance_frame(pearls, &guide, &SPRINGS, &frame, rooted(number, from), rooted(number, to));
                }
                began.elapsed().as_secs_f64() * 1e3
            })
            .collect();
        took.sort_by(f64::total_cmp);
        let [least, median, greatest] = [took[0], took[took.len() / 2], took[took.len() - 1]];
        println!("{points} points: least {least:.2}, median {median:.2}, greatest {greatest:.2} ms a frame");
    }
}
