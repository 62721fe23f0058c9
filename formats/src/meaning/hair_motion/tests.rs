use super::*;
use std::f32::consts::{PI, TAU};

const CALM: Wind = Wind { velocity: Vec3::ZERO, gust: 0.0, gust_s: 3.0, turbulence: 0.0, eddy_m: 0.5 };
const SPRINGS: Springs = Springs { drag_per_s: 2.0, shape_hz: 0.6, bend_hz: 1.5, friction: 0.2 };

const FRAME: Frame<'_> = Frame {
    seconds: 1.0 / 60.0,
    before_s: 1.0 / 120.0,
    gravity: Vec3::new(0.0, -GRAVITY, 0.0),
    wind: CALM,
    time_s: 0.0,
    colliders: &[],
};

/// Guide with its simulation parameters.
struct Guide {
    points: Vec<Vec3>,
    ballast: Vec<Vec3>,
    free: Vec<f32>,
    springs: Springs,
}

impl Guide {
    fn new(points: Vec<Vec3>) -> Self {
        let free = (0..points.len()).map(|k| if k == 0 { 0.0 } else { 1.0 }).collect();
        Self { ballast: gravity_compensation(&points, Mat3::IDENTITY), points, free, springs: SPRINGS }
    }

    /// Returns a hanging string of `points` points, 0.3 m long.
    fn hanging(points: usize) -> Self {
        Self::new((0..points).map(|k| Vec3::NEG_Y * (0.3 * k as f32 / (points - 1) as f32)).collect())
    }

    /// Returns a guide that stands out and curls.
    fn curled() -> Self {
        let point = |k: usize| {
            let t = k as f32 / 15.0;
            Vec3::new(0.2 * t, 0.1 * (3.0 * t).sin(), 0.05 * (5.0 * t).cos() - 0.05)
        };
        Self::new((0..16).map(point).collect())
    }

    fn length(&self) -> f32 {
        self.points.windows(2).map(|ends| ends[0].distance(ends[1])).sum()
    }

    /// Simulates the guide for `seconds`. After each frame, calls `at_end` with the particles and the root.
    fn run(
        &self,
        fps: f32,
        seconds: f32,
        rooted: impl Fn(f32) -> RootFrame,
        collider: impl Fn(f32) -> Vec<Capsule>,
        mut at_end: impl FnMut(&[Particle], RootFrame),
    ) -> Vec<Particle> {
        let groomed = GroomedGuide { points: &self.points, ballast: &self.ballast, free: &self.free };
        let mut pearls = rooted(0.0).groomed(&self.points);
        let mut before_s = steps(1.0 / fps).1;
        for number in 1..=(seconds * fps).round() as u32 {
            let [from, to] = [number - 1, number].map(|n| n as f32 / fps);
            let colliders: Vec<[Capsule; 2]> =
                collider(from).into_iter().zip(collider(to)).map(|(a, b)| [a, b]).collect();
            let frame = Frame { seconds: to - from, before_s, time_s: to, colliders: &colliders, ..FRAME };
            before_s = advance_frame(&mut pearls, &groomed, &self.springs, &frame, rooted(from), rooted(to));
            at_end(&pearls, rooted(to));
        }
        pearls
    }

    /// Returns the maximum relative length error of the segments.
    fn stretch(&self, pearls: &[Particle]) -> f32 {
        let of = |k: usize| {
            let length = self.points[k].distance(self.points[k - 1]);
            let found = pearls[k].place.distance(pearls[k - 1].place);
            if length > 0.0 { (found / length - 1.0).abs() } else { found }
        };
        (1..pearls.len()).map(of).fold(0.0, f32::max)
    }
}

fn still(_: f32) -> RootFrame {
    RootFrame { root: Vec3::new(1.0, 2.0, 3.0), frame: Mat3::IDENTITY }
}

/// Root on a galloping head, which moves up and down and back and forth, and nods.
fn gallop(time_s: f32) -> RootFrame {
    let turns = TAU * 2.2 * time_s;
    let root = Vec3::new(0.08 * turns.cos(), 0.15 * turns.sin(), 9.0 * time_s);
    RootFrame { root, frame: Mat3::from_rotation_x(0.3 * (turns + 0.5).sin()) }
}

fn nothing(_: f32) -> Vec<Capsule> {
    Vec::new()
}

#[test]
fn hair_at_rest_keeps_its_groomed_shape() {
    for guide in [Guide::hanging(7), Guide::hanging(64), Guide::curled()] {
        let groomed = still(0.0).groomed(&guide.points);
        let found = guide.run(60.0, 10.0, still, nothing, |_, _| ());
        let off = found.iter().zip(&groomed).map(|(a, b)| a.place.distance(b.place)).fold(0.0, f32::max);
        assert!(off < 1e-4 * guide.length(), "{} points: {off}", guide.points.len());
        // Without gravity compensation, hair that stands out falls.
        if guide.points[1].y > -0.001 {
            let slack = Guide { ballast: vec![Vec3::ZERO; 16], ..guide };
            let found = slack.run(60.0, 10.0, still, nothing, |_, _| ());
            assert!(found[15].place.distance(groomed[15].place) > 0.2 * slack.length());
        }
    }
}

#[test]
fn strings_keep_their_length_under_strong_motion() {
    for points in [7, 16, 36, 64] {
        let guide = Guide { springs: Springs { shape_hz: 0.0, bend_hz: 0.3, ..SPRINGS }, ..Guide::hanging(points) };
        let mut worst = 0.0f32;
        let mut swung = 0.0f32;
        guide.run(60.0, 5.0, gallop, nothing, |pearls, now| {
            worst = worst.max(guide.stretch(pearls));
            let tip = pearls[points - 1].place;
            assert!(tip.is_finite());
            swung = swung.max((tip - now.frame * guide.points[points - 1]).length());
        });
        println!("{points} points: stretch {worst:.1e}, swung {:.2} of the length", swung / guide.length());
        assert!(worst < 1e-3, "{points} points: {worst}");
        assert!(swung > 0.3 * guide.length(), "{points} points: only {swung}");
    }
}

/// Measures the alternative to solving for tensions: iterations that correct one segment at a time. They leave long
/// strings stretched.
#[test]
fn correcting_segments_one_by_one_leaves_long_strings_stretched() {
    let (points, length, h) = (64, 0.3f32, 1.0 / 60.0);
    let piece = length / (points - 1) as f32;
    let mut now: Vec<f32> = (0..points).map(|k| piece * k as f32).collect();
    let mut old = now.clone();
    for _ in 0..600 {
        for k in 1..points {
            let next = now[k] + 0.98 * (now[k] - old[k]) + GRAVITY * h * h;
            (old[k], now[k]) = (now[k], next);
        }
        for _ in 0..4 {
            for k in 1..points {
                let off = now[k] - now[k - 1] - piece;
                let share = if k == 1 { 0.0 } else { 0.5 };
                now[k - 1] += off * share;
                now[k] -= off * (1.0 - share);
            }
        }
    }
    assert!(now[points - 1] > 1.5 * length, "four sweeps: {} of {length} m", now[points - 1]);
}

#[test]
fn pendulum_has_the_expected_period() {
    let mut guide = Guide::hanging(2);
    guide.springs = Springs { drag_per_s: 0.0, shape_hz: 0.0, bend_hz: 0.0, friction: 0.0 };
    // The root is displaced in the first frame.
    let root = |time_s: f32| RootFrame { root: Vec3::X * if time_s > 0.0 { 0.01 } else { 0.0 }, frame: Mat3::IDENTITY };
    let mut crossed = Vec::new();
    let (mut time_s, mut last) = (0.0, -1.0);
    guide.run(240.0, 5.0, root, nothing, |pearls, _| {
        time_s += 1.0 / 240.0;
        let side = pearls[1].place.x;
        if last < 0.0 && side >= 0.0 {
            crossed.push(time_s);
        }
        last = side;
    });
    let period = (crossed[crossed.len() - 1] - crossed[0]) / (crossed.len() - 1) as f32;
    let expected = TAU * (0.3 / GRAVITY).sqrt();
    assert!((period / expected - 1.0).abs() < 0.02, "{period} s, expected {expected}");
}

/// Frame rates of 30, 60 and 144 fps give the same result after five seconds.
#[test]
fn hair_motion_does_not_depend_on_frame_rate() {
    for guide in [Guide::hanging(16), Guide::curled()] {
        let sway = |time_s: f32| {
            let turns = TAU * 0.7 * time_s;
            RootFrame { root: Vec3::new(0.3 * turns.sin(), 0.0, 0.0), frame: Mat3::from_rotation_z(0.5 * turns.sin()) }
        };
        let tips = [30.0, 60.0, 144.0].map(|fps| guide.run(fps, 5.0, sway, nothing, |_, _| ()));
        for other in &tips[1..] {
            let off = tips[0].iter().zip(other).map(|(a, b)| a.place.distance(b.place)).fold(0.0, f32::max);
            println!("off by {:.4} of the length", off / guide.length());
            assert!(off < 0.03 * guide.length(), "{} of the length", off / guide.length());
        }
    }
}

#[test]
fn hair_motion_stays_finite() {
    let swallowing =
        |_: f32| vec![Capsule { from: Vec3::new(1.0, 2.0, 3.0), to: Vec3::new(1.0, 2.0, 3.0), radius_m: 0.5 }];
    let jump =
        |time_s: f32| RootFrame { root: Vec3::X * if time_s > 0.5 { 100.0 } else { 0.0 }, frame: Mat3::IDENTITY };
    let spin = |time_s: f32| RootFrame { root: Vec3::ZERO, frame: Mat3::from_rotation_y(4.0 * PI * time_s) };
    let mut loose = Guide::hanging(16);
    loose.springs = Springs { drag_per_s: 0.0, shape_hz: 0.0, bend_hz: 0.0, friction: 0.0 };
    let mut stiff = Guide::curled();
    stiff.springs = Springs { drag_per_s: 50.0, shape_hz: 60.0, bend_hz: 60.0, friction: 1.0 };
    let mut half = Guide::hanging(16);
    half.free = (0..16).map(|k| (k as f32 / 10.0 - 0.3).clamp(0.0, 1.0)).collect();
    let mut fast = Guide::hanging(16);
    fast.free = vec![0.0; 16];
    let mut together = Guide::hanging(16);
    together.points[5] = together.points[4];
    together.points[15] = together.points[14];
    for guide in [Guide::hanging(2), Guide::hanging(64), Guide::curled(), loose, stiff, half, fast, together] {
        for fps in [2.0, 60.0, 1e6] {
            let seconds = if fps > 1e3 { 1e-3 } else { 5.0 };
            let mut check = |pearls: &[Particle], _: RootFrame| {
                let far = pearls.iter().map(|p| p.place.length()).fold(0.0, f32::max);
                assert!(far.is_finite() && far < 1.01 * guide.length() + 1e-3, "{far} m of {} m", guide.length());
                assert!(pearls.iter().all(|p| p.velocity.is_finite()));
                if guide.free[1] == 1.0 {
                    assert!(guide.stretch(pearls) < 2e-3, "{}", guide.stretch(pearls));
                }
            };
            guide.run(fps, seconds, still, swallowing, &mut check);
            guide.run(fps, seconds, jump, nothing, &mut check);
            // The surface makes a full turn in a frame of half a second.
            guide.run(fps, seconds, spin, nothing, &mut check);
        }
        // Simulate a frame of zero duration.
        let groomed = GroomedGuide { points: &guide.points, ballast: &guide.ballast, free: &guide.free };
        let mut pearls = still(0.0).groomed(&guide.points);
        let frame = Frame { seconds: 0.0, before_s: 1.0 / 60.0, ..FRAME };
        let moved = RootFrame { root: still(0.0).root + Vec3::X, frame: Mat3::IDENTITY };
        advance_frame(&mut pearls, &groomed, &guide.springs, &frame, still(0.0), moved);
        assert!(pearls.iter().all(|p| p.place.is_finite() && p.velocity == Vec3::ZERO));
    }
}

#[test]
fn hair_stays_outside_colliders() {
    let guide = Guide::hanging(16);
    // A sphere and a capsule that pass through the hanging hair.
    let colliders = |time_s: f32| {
        let x = -0.4 + 0.4 * time_s;
        let rod = [Vec3::new(-x, -0.3, -0.5), Vec3::new(-x, -0.27, 0.5)];
        vec![
            Capsule { from: Vec3::new(x, -0.15, 0.01), to: Vec3::new(x, -0.15, 0.01), radius_m: 0.08 },
            Capsule { from: rod[0], to: rod[1], radius_m: 0.03 },
        ]
    };
    let root = |_: f32| RootFrame { root: Vec3::ZERO, frame: Mat3::IDENTITY };
    let (mut time_s, mut deepest, mut pushed) = (0.0f32, 0.0f32, 0.0f32);
    guide.run(60.0, 2.0, root, colliders, |pearls, _| {
        time_s += 1.0 / 60.0;
        for capsule in colliders(time_s) {
            for pearl in pearls {
                let inside = 1.0 - pearl.place.distance(capsule.nearest(pearl.place)) / capsule.radius_m;
                deepest = deepest.max(inside);
            }
        }
        pushed = pushed.max(pearls[15].place.x.abs());
        assert!(guide.stretch(pearls) < 1e-3);
    });
    println!("deepest {deepest:.3} of the radius, pushed {pushed} m");
    assert!(deepest < 0.02 && pushed > 0.05, "{deepest} of the radius, pushed {pushed} m");
}

#[test]
fn wind_moves_hair_and_its_effect_decays() {
    let guide = Guide::hanging(16);
    let groomed = GroomedGuide { points: &guide.points, ballast: &guide.ballast, free: &guide.free };
    let mut pearls = still(0.0).groomed(&guide.points);
    let mut blow = |velocity: Vec3, seconds: f32| {
        for _ in 0..(seconds * 60.0) as u32 {
            let frame = Frame { wind: Wind { velocity, ..CALM }, ..FRAME };
            advance_frame(&mut pearls, &groomed, &guide.springs, &frame, still(0.0), still(0.0));
        }
        pearls[15].place
    };
    let blown = blow(Vec3::X * 5.0, 8.0);
    assert!(blown.x > 0.1 && blown.z.abs() < 1e-3, "{blown}");
    let calm = blow(Vec3::ZERO, 10.0);
    assert!(calm.distance(Vec3::NEG_Y * 0.3) < 0.002, "{calm}");
    let gusty = Wind { velocity: Vec3::X * 3.0, gust: 0.5, turbulence: 0.4, ..CALM };
    assert!((0..1000).all(|k| gusty.at(Vec3::splat(0.37 * k as f32), 1.7).distance(Vec3::X * 3.0) < 4.0));
    assert!(gusty.at(Vec3::ZERO, 1.7) != gusty.at(Vec3::X, 1.7) && gusty.changes());
    assert!(!Wind::default().changes() && !Wind { velocity: Vec3::X, ..CALM }.changes());
}
