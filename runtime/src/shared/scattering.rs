use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3, Vec4};
use pelage_formats::FibreOptics;
use pelage_formats::meaning::scattering::colour;
use pelage_formats::meaning::scattering::means::Means;
use std::f32::consts::PI;

/// The shader source; needs nothing else.
pub const WGSL: &str = include_str!("scattering.wgsl");

/// Two directions about a fibre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FibreAngles {
    /// Place in the table of what happens along the fibre, 0..=1 (`FORMAT.md`, "FIBR", layer 0).
    pub along: Vec2,
    /// Place in the table of what happens around it, 0..=1 (layer 1).
    pub around: Vec2,
    /// Cosine of the light's angle from the plane across the fibre, 0..=1.
    pub cos_i: f32,
    /// Cosine of the difference angle, 0..=1.
    pub cos_d: f32,
}

/// What of a fibre needs no table, as shaders have it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Fibre {
    /// 1 / η²; 1 / d of `FORMAT.md`, "FIBR"; `Means::aside` of the package; variance of the reflected lobe along the fibre, of whole angles.
    pub optics: [f32; 4],
    /// `Means::on` of the package.
    pub on: [[f32; 4]; 3],
    /// `Means::back`.
    pub back: [[f32; 4]; 3],
}

impl Fibre {
    /// A package's.
    pub fn new(optics: &FibreOptics, means: &Means) -> Self {
        let per_depth = colour::depth(optics.around.into()).recip() as f32;
        Self {
            optics: [
                (optics.eta * optics.eta).recip(),
                per_depth,
                means.aside,
                optics.fibre().spread(0).variance() as f32,
            ],
            on: means.on,
            back: means.back,
        }
    }
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
        cos_d,
    }
}

/// What fibres absorb a radius of which a deep coat has that colour, each channel by itself (Chiang 2016, section 4.2); `per_depth` is 1 / d of
/// `FORMAT.md`, "FIBR".
pub fn fibre_absorption(color: Vec3, per_depth: f32) -> Vec3 {
    let root = color.clamp(Vec3::splat(1e-3), Vec3::ONE).map(f32::ln) * per_depth;
    root * root
}

/// What a fibre that absorbs so much a radius leaves of light that crosses it once, at a difference angle of that cosine. `optics` as [`Fibre`] has it.
pub fn fibre_left(cos_d: f32, optics: Vec4, absorbed: Vec3) -> Vec3 {
    let c = cos_d.max(LEAST_COS_D);
    // Squares of 1 / cos θt, and of the sine of the angle in the section that light is bent to, where it falls in so far aside.
    let slant = 1.0 / (1.0 - (1.0 - c * c) * optics.x);
    let bent = optics.z * c * c * optics.x * slant;
    (-2.0 * (slant * (1.0 - bent)).sqrt() * absorbed).map(f32::exp)
}

/// What the tables' texels along and around a fibre come to, times the cosine of the light's angle: light a steradian, over its irradiance. `left` as
/// [`fibre_left`] has it: TRT crosses the fibre twice, and all other light three times.
pub fn fibre_scatters(along: Vec4, around: Vec4, absorbed: Vec3, left: Vec3) -> Vec3 {
    let ways = along * around;
    let through = (-absorbed * around.w).map(f32::exp);
    Vec3::splat(ways.x) + ways.y * through + left * left * (Vec3::splat(ways.z) + along.w * left)
}

/// Of light at an angle of that cosine to the plane across a fibre that absorbs nothing: the share that goes on, to its far side, and the share that comes back,
/// by R, TT, TRT and the rest.
pub fn fibre_shares(fibre: &Fibre, cos_theta: f32) -> [Vec4; 2] {
    let u = 1.0 - cos_theta.max(LEAST_COS_D);
    let square = u * u;
    [&fibre.on, &fibre.back].map(|of| {
        let [first, second, third] = of.map(Vec4::from);
        first + square * (second + square * third)
    })
}

/// The same of a fibre that absorbs: the share that goes on, and the share that comes back.
pub fn fibre_sides(fibre: &Fibre, cos_theta: f32, left: Vec3) -> [Vec3; 2] {
    fibre_shares(fibre, cos_theta).map(|share| {
        let share = share.to_array().map(Vec3::splat);
        share[0] + left * (share[1] + left * (share[2] + left * share[3]))
    })
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
    /// Root of what a fibre absorbs of the light that it gets.
    pub root_lost: Vec3,
}

/// Where the share `direct` of the light, 0..=1, comes past all fibres of a deep coat, of which each sends the shares `on` and `back` to either side
/// (Kubelka and Munk 1931). Nothing is negative or infinite, also of fibres that absorb nothing.
pub fn diffused(on: Vec3, back: Vec3, direct: f32) -> Diffused {
    let lost = (Vec3::ONE - on - back).max(Vec3::splat(1e-4));
    let root_lost = lost.map(f32::sqrt);
    let less = root_lost * (lost + 2.0 * back).map(f32::sqrt);
    let given_back = back / (lost + back + less);
    let depth = direct.clamp(1e-30, 1.0).log2();
    let arrives = (less * depth).map(f32::exp2);
    let sent_on = ((Vec3::ONE - on) * depth).map(f32::exp2);
    Diffused {
        sent_on: (sent_on - direct).max(Vec3::ZERO),
        from_light: (arrives - sent_on).max(Vec3::ZERO),
        from_below: given_back * arrives,
        root_lost,
    }
}

/// How much of the light that goes on from fibre to fibre there is under a light at the height of that sine, 0..=1, over that under one straight above
/// (after Hapke 1981, whose H function's share beyond 1 it is).
pub fn falls_in(root_lost: Vec3, sine: f32) -> Vec3 {
    let root = 2.0 * root_lost;
    sine * (1.0 + root) / (1.0 + sine * root)
}

/// What of the light that a fibre sends on, or back, turns back in a sheet of hair that hangs free.
const TURNED_ON: f32 = 0.15;
const TURNED_BACK: f32 = 0.8;
/// What leaves such a sheet at its edges, of light that a fibre has scattered.
const LEAKS: f32 = 0.12;

/// What goes on, and what comes back, in a sheet of fibres of which each sends `sides` on and back: for [`diffused`]. A fibre's sides are not those of the
/// sheet: light that is turned aside by many goes back in the end, and some of it leaves the sheet at its edges.
pub fn hanging_sides(sides: [Vec3; 2]) -> [Vec3; 2] {
    let back = TURNED_ON * sides[0] + TURNED_BACK * sides[1];
    [(1.0 - LEAKS) * (sides[0] + sides[1]) - back, back]
}

/// How much more light goes from one angle to another, of those sines to the plane across the fibre, than if it went to all heights alike: of a lobe of that
/// `variance` (d'Eon 2011), of which I0 is taken to 2 %.
pub fn along_cone(sin_i: f32, sin_o: f32, variance: f32) -> f32 {
    let k = variance.clamp(1e-3, 1e3).recip();
    let a = k * ((1.0 - sin_i * sin_i) * (1.0 - sin_o * sin_o)).max(0.0).sqrt();
    let i0e = (1.0 + 2.0 * a + 4.2832 * a * a / (a + 0.9183) - 0.6664 * a / (1.0 + 0.3884 * a * a)).sqrt().recip();
    2.0 * k * i0e * (a - k * (1.0 + sin_i * sin_o)).exp() / (1.0 - (-2.0 * k).exp())
}

/// [`along_cone`] of light in hair that hangs side by side: of what was sent on and never back, and of other light. Fibres side by side keep light near the cone
/// on which it came, and each that scatters it makes the cone wider (after Zinke 2008). `left`: as [`fibre_left`] has it, of grey; `direct`: share of the light that comes past all fibres.
pub fn hanging_cones(fibre: &Fibre, cos_i: f32, left: f32, direct: f32, sin_i: f32, sin_o: f32) -> [f32; 2] {
    let [shares_on, shares_back] = fibre_shares(fibre, cos_i);
    let light = Vec4::new(1.0, left, left * left, left * left * left);
    // TT's lobe is half as wide, and TRT's twice.
    let wide = fibre.optics[3] * Vec4::new(1.0, 0.25, 4.0, 4.0);
    // Fits of fibres that let nothing through may be nothing, or less.
    let on = shares_on.dot(light).max(1e-4);
    let all = on + shares_back.dot(light).max(0.0);
    let width = (shares_on + shares_back).dot(light * wide) / all;
    let depth = -direct.clamp(1e-30, 1.0).ln();
    // Of what was sent on at all.
    let sent = (on * depth).max(1e-3);
    let sent_on = shares_on.dot(light * wide) / on * sent / (1.0 - (-sent).exp());
    // How often light has been scattered that comes back from such a sheet: by how much less there is, the more each fibre absorbs.
    let back = TURNED_ON * on + TURNED_BACK * (all - on);
    let lost = (1.0 - (1.0 - LEAKS) * all).max(1e-4);
    let met = back / (lost * (lost + 2.0 * back)).sqrt();
    let times = 1.0 + depth * all + all / back * met * (1.0 + met / 1.5) / (1.0 + met);
    [sent_on + width, (times + 1.0) * width].map(|variance| along_cone(sin_i, sin_o, variance))
}
