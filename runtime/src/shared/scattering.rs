use glam::{Vec2, Vec3, Vec4};
use std::f32::consts::PI;

/// The shader source; needs nothing else.
pub const WGSL: &str = include_str!("scattering.wgsl");

/// Two directions about a fibre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FibreAngles {
    /// Place in the table of what happens along the fibre, 0..=1 (`FORMAT.md`, "FIBR", layer 0).
    pub along: Vec2,
    /// Place in the tables of what happens around it, 0..=1 (layers 1 and 2).
    pub around: Vec2,
    /// Cosine of the light's angle from the plane across the fibre, 0..=1.
    pub cos_i: f32,
}

const DRAWN_OUT: f32 = 0.3;
const LEAST_COS_D: f32 = 0.1;

/// Row of a table for a cosine of the difference angle, 0..=1.
pub fn fibre_row(cos_d: f32) -> f32 {
    ((cos_d - LEAST_COS_D) / (1.0 - LEAST_COS_D)).clamp(0.0, 1.0)
}

/// Of unit vectors: the fibre towards its tip, towards the light, towards the eye. A direction along the fibre has no azimuth: any is taken. Finite for all.
pub fn fibre_angles(tip: Vec3, light: Vec3, eye: Vec3) -> FibreAngles {
    let sin_i = tip.dot(light).clamp(-1.0, 1.0);
    let sin_o = tip.dot(eye).clamp(-1.0, 1.0);
    let cos_i = (1.0 - sin_i * sin_i).sqrt();
    let cos_o = (1.0 - sin_o * sin_o).sqrt();
    let cos_d = (0.5 * (1.0 + cos_i * cos_o + sin_i * sin_o)).clamp(0.0, 1.0).sqrt();
    let sin_h = (0.5 * (sin_i + sin_o) / cos_d.max(1e-4)).clamp(-1.0, 1.0);
    let half_d = (1.0 - cos_d * cos_d).max(0.0).sqrt() / (1.0 + cos_d);
    let tilted = if sin_o >= sin_i { half_d } else { -half_d };
    let drawn_out = sin_h / (DRAWN_OUT + (1.0 - DRAWN_OUT) * sin_h.abs());
    let cos_phi = ((light.dot(eye) - sin_i * sin_o) / (cos_i * cos_o).max(1e-6)).clamp(-1.0, 1.0);
    FibreAngles {
        along: Vec2::new(0.5 + 0.5 * drawn_out, 0.5 + 0.5 * tilted),
        around: Vec2::new(cos_phi.acos() / PI, fibre_row(cos_d)),
        cos_i,
    }
}

/// What fibres absorb a radius of which a deep coat has that colour, each channel by itself (Chiang 2016, section 4.2); `per_depth` is 1 / d of
/// `FORMAT.md`, "FIBR".
pub fn fibre_absorption(color: Vec3, per_depth: f32) -> Vec3 {
    let root = color.clamp(Vec3::splat(1e-3), Vec3::ONE).map(f32::ln) * per_depth;
    root * root
}

/// What the tables' texels along and around a fibre come to, times the cosine of the light's angle: light a steradian, over its irradiance.
pub fn fibre_scatters(along: Vec4, around: Vec4, lengths: Vec4, absorbed: Vec3) -> Vec3 {
    let ways = along * around;
    let left = |length: f32| (-absorbed * length).map(f32::exp);
    Vec3::splat(ways.x) + ways.y * left(lengths.x) + ways.z * left(lengths.y) + ways.w * left(lengths.z)
}

/// Light in a coat of fibres, over what falls on it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Diffused {
    /// What other fibres have sent on, and never back: it goes nearly as the light does.
    pub sent_on: Vec3,
    /// What comes from the light's side besides.
    pub from_light: Vec3,
    /// What comes back from below.
    pub from_below: Vec3,
}

/// Where the share `direct` of the light, 0..=1, comes past all fibres of a deep coat, of which each sends the shares `on` and `back` to either side
/// (Kubelka and Munk 1931). Nothing is negative or infinite, also of fibres that absorb nothing.
pub fn diffused(on: Vec3, back: Vec3, direct: f32) -> Diffused {
    let lost = (Vec3::ONE - on - back).max(Vec3::splat(1e-4));
    let less = (lost * (lost + 2.0 * back)).map(f32::sqrt);
    let given_back = back / (lost + back + less);
    let depth = -direct.clamp(1e-6, 1.0).ln();
    let arrives = (-less * depth).map(f32::exp);
    let sent_on = (-(Vec3::ONE - on) * depth).map(f32::exp);
    Diffused {
        sent_on: (sent_on - direct).max(Vec3::ZERO),
        from_light: (arrives - sent_on).max(Vec3::ZERO),
        from_below: given_back * arrives,
    }
}
