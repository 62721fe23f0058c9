//! Lean of fur in wind and motion. Each vertex has a particle at the tip of its hair, which a spring pulls to its
//! groomed position.
//!
//! The runtime does the same on the GPU (`runtime/src/passes/fur_motion`). Vectors are in world space, lengths in
//! metres, times in seconds.
//!
//! Within a frame, the surface is assumed to accelerate uniformly, and the air to move as at the end of the frame.
//! Relative to the surface, the particle is then a damped oscillator about a fixed point, whose motion has a closed
//! form. The result is therefore exact for frames of any length and springs of any stiffness.
//!
//! The motion depends only on the position of the vertex and the length of its hair. So vertices at the same position
//! lean alike, and fur does not part along seams.
//!
//! The oscillator has ω² = s / L, where s is the [`stiffness`] and L the length of the hair. If springs were linear
//! that far, an acceleration of s would bend the hair by one radian. Short hair is stiff, long hair sways.

use super::hair_motion::Wind;
use glam::Vec3;

/// [`stiffness`] of long hair, m/s².
pub const STIFFNESS: f32 = 60.0;
/// Length at which hair is twice as stiff as long hair, metres.
pub const SHORT_M: f32 = 0.01;
/// Drag rate: how fast hair takes on the velocity of the air, 1/s.
pub const DRAG_PER_S: f32 = 4.0;
/// Damping, as a share of critical damping.
pub const DAMPING: f32 = 0.35;
/// Upper bound of the lean angle, radians; approached but never reached. It keeps fur within its height and pointing
/// away from the surface.
pub const MOST_LEAN_RAD: f32 = 0.7;
/// Maximum distance of a tip from its groomed position, hair lengths.
const MAX_OFFSET: f32 = 2.0;
/// Length below which hair does not move, metres.
pub const SHORTEST_M: f32 = 1e-5;

/// State of the hair tip on a vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tip {
    /// Offset from the groomed position, metres.
    pub offset: Vec3,
    /// Velocity relative to the root, m/s.
    pub velocity: Vec3,
    /// Velocity of the surface, m/s; `None` while unknown.
    pub surface_velocity: Option<Vec3>,
}

/// Time interval of a frame, with its wind.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// Duration, seconds; with 0, nothing moves.
    pub seconds: f32,
    /// Duration of the previous frame, seconds.
    pub before_s: f32,
    /// Wind.
    pub wind: &'a Wind,
    /// Time at the end of the frame, seconds.
    pub time_s: f32,
}

/// Returns the tip in equilibrium with the wind, for a surface whose motion is unknown.
///
/// * `length_m`: length of the hair, [`SHORTEST_M`] or more
/// * `root`: position of the surface
pub fn initial_tip(length_m: f32, root: Vec3, wind: &Wind, time_s: f32) -> Tip {
    let held = wind.at(root, time_s) * (DRAG_PER_S * length_m / stiffness(length_m));
    Tip { offset: within(held, MAX_OFFSET * length_m), ..Tip::default() }
}

/// Moves a tip by one frame.
///
/// * `length_m`: length of the hair, [`SHORTEST_M`] or more
/// * `root`: position of the surface at the end of the frame
/// * `went`: displacement of the surface during the frame
pub fn advance(tip: Tip, length_m: f32, root: Vec3, went: Vec3, frame: &Frame<'_>) -> Tip {
    let h = frame.seconds;
    if h <= 0.0 {
        return tip;
    }
    let square = stiffness(length_m) / length_m;
    let of_skin = went / h;
    // Acceleration of the surface between the middle of the previous frame and the middle of this one.
    let faster = (of_skin - tip.surface_velocity.unwrap_or(of_skin)) / (0.5 * (h + frame.before_s));
    let pulled = (frame.wind.at(root, frame.time_s) - of_skin) * DRAG_PER_S - faster;
    let goal = within(pulled / square, MAX_OFFSET * length_m);
    let off = tip.offset - goal;
    let turns = square.sqrt();
    let damped = turns * (1.0 - DAMPING * DAMPING).sqrt();
    let kept = libm::expf(-DAMPING * turns * h);
    let (sine, cosine) = (libm::sinf(damped * h) / damped, libm::cosf(damped * h));
    let aside = goal + (off * (cosine + DAMPING * turns * sine) + tip.velocity * sine) * kept;
    let beside = (tip.velocity * (cosine - DAMPING * turns * sine) - off * (square * sine)) * kept;
    Tip { offset: within(aside, MAX_OFFSET * length_m), velocity: beside, surface_velocity: Some(of_skin) }
}

/// Returns the acceleration that would bend hair by one radian if springs were linear that far, m/s².
pub fn stiffness(length_m: f32) -> f32 {
    STIFFNESS * (1.0 + SHORT_M / length_m)
}

/// Returns the offset of a tip from its groomed position at the end of a frame.
///
/// The acceleration of the surface is known between the middles of two frames, so [`advance`] lags by half a frame.
/// This function compensates for it.
///
/// * `seconds`: duration of the frame
pub fn tip_offset(tip: &Tip, length_m: f32, seconds: f32) -> Vec3 {
    within(tip.offset + tip.velocity * (0.5 * seconds), MAX_OFFSET * length_m)
}

fn within(v: Vec3, most: f32) -> Vec3 {
    v * (most / v.length().max(1e-20)).min(1.0)
}

/// Returns the factor on the motion of a vertex's fur, 0..=1. Hair moves less if it already leans, or if it sticks
/// together because it is wet.
///
/// * `lean`, `wetness`: values at the vertex, 0..=1
pub fn freedom(lean: f32, wetness: f32) -> f32 {
    (1.0 - 0.5 * lean.clamp(0.0, 1.0)) * (1.0 - 0.6 * wetness.clamp(0.0, 1.0))
}

/// Returns the lean of the hair on a vertex: its angle, radians, 0 to [`MOST_LEAN_RAD`], and its direction, a unit
/// vector along the surface. `None` if the hair is as groomed.
///
/// * `aside`: offset of the tip from its groomed position, metres
/// * `normal`: surface normal, unit length
/// * `length_m`: length of the hair
/// * `strength`: product of [`freedom`] and the application's own factor
pub fn lean(aside: Vec3, normal: Vec3, length_m: f32, strength: f32) -> Option<(f32, Vec3)> {
    let along = aside - normal * normal.dot(aside);
    let far = along.length();
    let angle = strength * far / length_m;
    // Treat an invisible lean as none, so that fur at rest is exactly as groomed.
    (angle > 1e-4).then(|| (angle / (1.0 + (angle / MOST_LEAN_RAD) * (angle / MOST_LEAN_RAD)).sqrt(), along / far))
}

/// Returns the growth direction of hair that leans by `angle_rad` in the direction `along`, unit length. Tangents
/// follow as on a bent surface: their component along the returned direction is removed.
pub fn leaning_direction(normal: Vec3, angle_rad: f32, along: Vec3) -> Vec3 {
    normal * libm::cosf(angle_rad) + along * libm::sinf(angle_rad)
}

/// Returns the time, in seconds, after which the swing of unmoved fur of length `length_m` has decayed to a thousandth.
pub fn rest_s(length_m: f32) -> f32 {
    const LN_1000: f32 = 6.907_755;
    let length_m = length_m.max(SHORTEST_M);
    LN_1000 / (DAMPING * (stiffness(length_m) / length_m).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    const CALM: Wind = Wind { velocity: Vec3::ZERO, gust: 0.0, gust_s: 3.0, turbulence: 0.0, eddy_m: 0.5 };

    /// Simulates a hair on a surface whose position at each time is given by `place`. Returns the tip in each frame.
    fn run(length_m: f32, fps: f32, seconds: f32, place: impl Fn(f32) -> Vec3, wind: &Wind) -> Vec<Vec3> {
        let mut tip = initial_tip(length_m, place(0.0), wind, 0.0);
        let frames = (seconds * fps).round() as u32;
        let moved = (1..=frames).map(|number| {
            let [from, to] = [number - 1, number].map(|n| n as f32 / fps);
            let frame = Frame { seconds: to - from, before_s: 1.0 / fps, wind, time_s: to };
            tip = advance(tip, length_m, place(to), place(to) - place(from), &frame);
            assert!(tip.offset.is_finite() && tip.velocity.is_finite());
            assert!(tip.offset.length() <= 1.001 * MAX_OFFSET * length_m);
            tip_offset(&tip, length_m, to - from)
        });
        moved.collect()
    }

    /// Surface that moves forward and bobs up and down, as in a stride.
    fn stride(time_s: f32) -> Vec3 {
        Vec3::new(3.0 * time_s, 0.05 * (14.0 * time_s).sin(), 0.0)
    }

    #[test]
    fn pushed_fur_follows_a_damped_oscillator() {
        let (length, push) = (0.04f32, 1.0f32);
        let turns = (stiffness(length) / length).sqrt();
        let damped = turns * (1.0 - DAMPING * DAMPING).sqrt();
        for fps in [20.0f32, 60.0, 1000.0] {
            let mut tip = Tip { velocity: Vec3::X * push, surface_velocity: Some(Vec3::ZERO), ..Tip::default() };
            for number in 1..=(0.2 * fps) as u32 {
                let frame = Frame { seconds: 1.0 / fps, before_s: 1.0 / fps, wind: &CALM, time_s: 0.0 };
                tip = advance(tip, length, Vec3::ZERO, Vec3::ZERO, &frame);
                let t = number as f32 / fps;
                let exact = push / damped * (-DAMPING * turns * t).exp() * (damped * t).sin();
                assert!((tip.offset.x - exact).abs() < 2e-5 * push, "{fps} a second, {t} s: {} {exact}", tip.offset.x);
            }
        }
    }

    #[test]
    fn wind_bends_fur_and_calm_lets_it_return() {
        let wind = Wind { velocity: Vec3::X * 5.0, ..CALM };
        let blown = *run(0.03, 60.0, 3.0, |_| Vec3::ZERO, &wind).last().unwrap();
        let expected = 5.0 * DRAG_PER_S / stiffness(0.03) * 0.03;
        assert!((blown.x - expected).abs() < 1e-4 * expected && blown.y == 0.0, "{blown}");
        // A moving surface feels headwind, even in still air.
        let ran = *run(0.03, 60.0, 3.0, |t| Vec3::X * 5.0 * t, &CALM).last().unwrap();
        assert!((ran.x + expected).abs() < 1e-2 * expected, "{ran}");
        let still = run(0.03, 60.0, 3.0, |t| Vec3::X * t.min(1.0), &CALM);
        let rested = (60.0 * (1.0 + rest_s(0.03))) as usize;
        let swing = still.iter().map(|tip| tip.length()).fold(0.0, f32::max);
        assert!(swing > 0.001 && still[rested].length() < 2e-3 * swing, "{swing} {}", still[rested]);
    }

    #[test]
    fn fur_motion_does_not_depend_on_frame_rate() {
        // The shortest hair swings too fast for 30 frames a second to resolve: the error is a quarter of a millimetre.
        for (length, bound) in [(0.005, 0.05), (0.01, 0.03), (0.02, 0.01), (0.1, 0.01)] {
            let ends = [30.0, 60.0, 144.0, 960.0].map(|fps| *run(length, fps, 5.0, stride, &CALM).last().unwrap());
            let off = ends.iter().map(|end| end.distance(ends[3]) / length).fold(0.0, f32::max);
            println!("{length} m: {off:.3} of the length");
            assert!(off < bound, "{length} m: {off} of the length");
        }
    }

    #[test]
    fn fur_motion_stays_finite() {
        for fps in [2.0, 7.0, 1e6] {
            let jump = |t: f32| if t > 0.5 { Vec3::X * 100.0 } else { Vec3::ZERO };
            run(SHORTEST_M, fps, 1e3f32.min(1000.0 / fps), jump, &CALM);
            run(0.3, fps, 1e3f32.min(1000.0 / fps), jump, &Wind { velocity: Vec3::splat(100.0), gust: 3.0, ..CALM });
        }
        let tip = Tip { offset: Vec3::X, velocity: Vec3::Y, surface_velocity: None };
        let frame = Frame { seconds: 0.0, before_s: 0.0, wind: &CALM, time_s: 0.0 };
        assert_eq!(advance(tip, 1.0, Vec3::ZERO, Vec3::X, &frame), tip);
    }

    #[test]
    fn leaning_hair_stays_within_its_height() {
        let normal = Vec3::new(0.2, 0.9, -0.3).normalize();
        assert!(lean(normal * 0.01, normal, 0.02, 1.0).is_none(), "no lean along the normal");
        let (small, towards) = lean(Vec3::X * 0.001, normal, 0.02, 1.0).unwrap();
        assert!((small - 0.05).abs() < 0.002 && towards.dot(normal).abs() < 1e-6 && towards.x > 0.9);
        let (most, towards) = lean(Vec3::X * 1e3, normal, 0.02, 1.0).unwrap();
        assert!(most <= MOST_LEAN_RAD && most > 0.99 * MOST_LEAN_RAD);
        let axis = leaning_direction(normal, most, towards);
        assert!((axis.length() - 1.0).abs() < 1e-6 && (axis.dot(normal) - most.cos()).abs() < 1e-6);
        assert!(freedom(0.0, 0.0) == 1.0 && freedom(1.0, 1.0) > 0.1);
    }
}
