use super::*;

const GRAVITY: DVec3 = DVec3::new(0.0, -9.81, 0.0);
const CALM: &(dyn Fn(f64, DVec3) -> DVec3 + Sync) = &|_, _| DVec3::ZERO;

/// Returns a string with no forces but gravity and the tensions.
fn bare<'a>(points: &'a [DVec3], ballast: &'a [DVec3]) -> TrueGuide<'a> {
    TrueGuide { points, ballast, drag_per_s: 0.0, shape_hz: 0.0, bend_hz: 0.0, gravity: GRAVITY, air: CALM }
}

fn hanging(points: usize, length: f64) -> Vec<DVec3> {
    (0..points).map(|k| DVec3::NEG_Y * (length * k as f64 / (points - 1) as f64)).collect()
}

fn still() -> RootMotion {
    RootMotion::smooth(|_| (DVec3::ZERO, DMat3::IDENTITY), 0.0)
}

/// Simulates from rest at the given positions. Returns the state at each of `times`, seconds.
fn simulate(guide: &TrueGuide<'_>, from: Vec<DVec3>, times: &[f64], steps_per_s: f64) -> Vec<GuideState> {
    let mut swing = GuideState { velocities: vec![DVec3::ZERO; from.len()], places: from };
    let mut now = 0.0;
    times
        .iter()
        .map(|time| {
            let steps = ((time - now) * steps_per_s).ceil() as u32;
            guide.advance(&mut swing, |_| still(), now, time - now, steps);
            now = *time;
            swing.clone()
        })
        .collect()
}

const TIMES: [f64; 4] = [0.3, 0.9, 2.0, 3.3];

/// Checks a point that is released at an angle so small that its sine equals the angle. The expected motion is x = A
/// e^(−ct/2) (cos wt + c/2w sin wt).
#[test]
fn one_point_swings_as_a_damped_pendulum() {
    let (points, ballast) = (hanging(2, 0.3), [DVec3::ZERO; 2]);
    let aside = 1e-5;
    let from = vec![DVec3::ZERO, DVec3::new(aside, -(0.09 - aside * aside).sqrt(), 0.0)];
    let check = |guide: TrueGuide<'_>, rate: f64, square: f64| {
        let w = (square - rate * rate / 4.0).sqrt();
        for (time, found) in TIMES.iter().zip(simulate(&guide, from.clone(), &TIMES, 2000.0)) {
            let expected =
                aside * (-rate * time / 2.0).exp() * ((w * time).cos() + rate / (2.0 * w) * (w * time).sin());
            let off = (found.places[1].x - expected).abs() / aside;
            assert!(off < 1e-7, "after {time} s off by {off}");
        }
    };
    let bare = bare(&points, &ballast);
    let of_gravity = 9.81 / 0.3;
    check(bare, 0.0, of_gravity);
    check(TrueGuide { drag_per_s: 2.0, ..bare }, 2.0, of_gravity);
    let shape = TAU * 0.7;
    check(TrueGuide { shape_hz: 0.7, ..bare }, 0.6 * shape, of_gravity + shape * shape);
    // A single piece bends about its root like a spring of frequency `bend_hz`.
    check(TrueGuide { bend_hz: 1.3, ..bare }, 0.0, of_gravity + (TAU * 1.3) * (TAU * 1.3));
    check(TrueGuide { gravity: DVec3::ZERO, bend_hz: 1.3, ..bare }, 0.0, (TAU * 1.3) * (TAU * 1.3));
}

/// Checks two points that hang below each other. In the normal modes, their deflections have the ratio 1 : 1 ± √2, and
/// the squared frequencies are (2 ∓ √2) g/l.
#[test]
fn double_pendulum_swings_in_its_normal_modes() {
    let (points, ballast) = (hanging(3, 0.4), [DVec3::ZERO; 3]);
    let (guide, root_of_2) = (bare(&points, &ballast), 2.0f64.sqrt());
    for (ratio, square) in [(1.0 + root_of_2, 2.0 - root_of_2), (1.0 - root_of_2, 2.0 + root_of_2)] {
        let aside = [1e-5, 1e-5 * ratio];
        let down = |x: f64| -(0.04 - x * x).sqrt();
        let first = down(aside[0]);
        let from = vec![
            DVec3::ZERO,
            DVec3::new(aside[0], first, 0.0),
            DVec3::new(aside[1], first + down(aside[1] - aside[0]), 0.0),
        ];
        let w = (square * 9.81 / 0.2).sqrt();
        for (time, found) in TIMES.iter().zip(simulate(&guide, from, &TIMES, 2000.0)) {
            for k in 0..2 {
                let off = (found.places[k + 1].x - aside[k] * (w * time).cos()).abs() / aside[1].abs();
                assert!(off < 1e-6, "point {k} after {time} s off by {off}");
            }
        }
    }
}

/// The accelerations c u of the air and g of gravity act on each point, so the string hangs straight along their sum.
#[test]
fn steady_wind_tilts_a_string_by_the_expected_angle() {
    let (points, ballast) = (hanging(9, 0.3), [DVec3::ZERO; 9]);
    let wind: &(dyn Fn(f64, DVec3) -> DVec3 + Sync) = &|_, _| DVec3::new(3.0, 0.0, 1.0);
    let guide = TrueGuide { drag_per_s: 4.0, air: wind, ..bare(&points, &ballast) };
    let found = simulate(&guide, points.clone(), &[12.0], 1000.0).remove(0);
    let lean = (DVec3::new(12.0, 0.0, 4.0) + GRAVITY).normalize();
    for (k, place) in found.places.iter().enumerate() {
        assert!(place.distance(lean * (0.3 * k as f64 / 8.0)) < 1e-7, "point {k}: {place}");
    }
}

/// Checks a string that is released sideways without losses. It whips, and must conserve its energy.
#[test]
fn energy_and_lengths_are_conserved() {
    let (points, ballast) = (hanging(6, 0.3), [DVec3::ZERO; 6]);
    let guide = bare(&points, &ballast);
    let from: Vec<DVec3> = (0..6).map(|k| DVec3::new(0.06 * f64::from(k), 0.0, 0.0)).collect();
    let energy = |s: &GuideState| -> f64 {
        s.places.iter().zip(&s.velocities).skip(1).map(|(x, v)| 9.81 * x.y + v.length_squared() / 2.0).sum()
    };
    for found in simulate(&guide, from, &TIMES, 8000.0) {
        let drift = energy(&found).abs() / (5.0 * 9.81 * 0.3);
        let stretch = found.places.windows(2).map(|e| (e[0].distance(e[1]) / 0.06 - 1.0).abs()).fold(0.0, f64::max);
        assert!(drift < 1e-6 && stretch < 1e-11, "energy drifts by {drift}, lengths by {stretch}");
    }
}

/// Returns a motion of the root that combines all kinds of surface motion.
fn sway(time_s: f64) -> (DVec3, DMat3) {
    let turns = TAU * 0.7 * time_s;
    let (slow, swell) = (1.0 - turns.cos(), turns.sin());
    (DVec3::new(0.1 * slow, 0.05 * swell * swell, 0.0), DMat3::from_rotation_z(0.4 * slow))
}

#[test]
fn halving_the_step_reduces_the_error_sixteenfold() {
    let points: Vec<DVec3> = (0..7).map(|k| DVec3::new(0.03 * f64::from(k), -0.04 * f64::from(k), 0.0)).collect();
    let ballast = [DVec3::new(0.0, 3.0, 0.0); 7];
    let guide = TrueGuide { drag_per_s: 2.0, shape_hz: 0.5, bend_hz: 1.2, ..bare(&points, &ballast) };
    for straight in [false, true] {
        let tips = [4, 8, 16].map(|steps| guide.frames(&sway, straight, (90, 1.0 / 60.0), steps)[89][6]);
        let order = tips[0].distance(tips[1]) / tips[1].distance(tips[2]);
        assert!((10.0..24.0).contains(&order), "halving the step reduced the error {order} times");
    }
    let followed = guide.converged(&sway, false, (90, 1.0 / 60.0), 1e-6);
    assert!(followed.change <= 1e-6 && followed.places.len() == 90, "{}", followed.change);
    // With many frames, the motion for a root that moves straight between frames converges to that for the smooth root.
    let off = |frames: u32| {
        let at = |straight| guide.frames(&sway, straight, (frames, 1.5 / f64::from(frames)), 1920 / frames);
        at(true)[frames as usize - 1][6].distance(at(false)[frames as usize - 1][6])
    };
    let (few, many) = (off(60), off(240));
    assert!(many < 0.1 * few && few < 0.01, "{few} m, {many} m");
}

/// Checks motion without gravity, in which only the mesh surface acts on the hair. Hair with a stiff spring must move
/// rigidly with the surface.
#[test]
fn stiff_hair_moves_rigidly_with_its_root() {
    let points = hanging(5, 0.2);
    let ballast = [DVec3::ZERO; 5];
    let guide = TrueGuide { shape_hz: 40.0, gravity: DVec3::ZERO, ..bare(&points, &ballast) };
    let found = guide.frames(&sway, false, (90, 1.0 / 60.0), 64);
    let (root, frame) = sway(1.5);
    let off = found[89].iter().zip(&points).map(|(x, p)| x.distance(root + frame * *p)).fold(0.0, f64::max);
    assert!(off < 1e-3, "{off} m");
}
