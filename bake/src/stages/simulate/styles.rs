//! Hair styles: one row of forces for each.

use crate::recipe::Style;
use glam::Vec3;

/// Style of the hair where `groom.wetness` is 1.
pub const WET: Style = Style::Wet;

/// Forces that shape the strands of a style, and other properties of the style.
#[derive(Clone, Copy, Debug)]
pub struct StyleForces {
    /// Minimum number of segments of a strand.
    pub segments: f32,
    /// Mapping of `hair.lean` to the lean of strands: `lean[0] + lean[1] * lean`.
    pub lean: [f32; 2],
    /// Angle of the root from upright, degrees: coefficients of 1, lean and lean².
    pub root_deg: [f32; 3],
    /// Angle of the tip from upright, degrees: coefficients of 1 and lean.
    pub tip_deg: [f32; 2],
    /// Strength of the random part of a strand's heading.
    pub disorder: f32,
    /// Share of `hair.frizz` that remains. Water and combing smooth it out.
    pub frizz: f32,
    /// Whether strands are helices.
    pub helix: bool,
    /// Noise fields that displace strands; each has a number of cells per tile and a strength.
    pub fields: &'static [(i64, f32)],
    /// Factor on the noise fields along each axis.
    pub field_scale: Vec3,
    /// Factor on the noise fields at the root, and its increase towards the tip.
    pub field_growth: [f32; 2],
    /// Downward pull at the tip.
    pub droop: f32,
    /// Whether hair is wet. Wet strands gather in locks from the root by `hair.clump`, and the highlight is stronger
    /// and narrower. Dry strands gather towards their tips by `hair.dry_clump`.
    pub wet: bool,
    /// Share of a strand's brightness that comes from its lock: a constant, and the increase per `hair.dry_clump`.
    pub lock_brightness: [f32; 2],
    /// Random tilt of locks.
    pub lock_disorder: f32,
    /// Share of the linear colour that remains, 0..=1. A film of water removes the diffuse surface reflection and lets
    /// more light into the hair, which absorbs it.
    pub color: f32,
    /// Forces on guides of `[[strands.group]]`.
    pub guides: GuideForces,
}

/// Forces that shape guides.
#[derive(Clone, Copy, Debug)]
pub struct GuideForces {
    /// Number of points if `guide_points` is not set.
    pub points: u32,
    /// Factor on `stiffness`.
    pub stiffness: f32,
    /// Factor on `lift`.
    pub lift: f32,
    /// Whether guides follow the mesh surface where they are near it.
    pub follows_skin: bool,
    /// Strength of the waves.
    pub waves: f32,
    /// Radius of the helix, as a share of the guide's length; 0: none.
    pub curl: f32,
}

/// Forces of the style `straight`; the other styles are variations of it.
const STRAIGHT: StyleForces = StyleForces {
    segments: 14.0,
    lean: [0.0, 1.0],
    root_deg: [0.0, 0.0, 65.0],
    tip_deg: [0.0, 88.0],
    disorder: 0.12,
    frizz: 1.0,
    helix: false,
    fields: &[],
    field_scale: Vec3::ZERO,
    field_growth: [1.0, 0.0],
    droop: 0.0,
    wet: false,
    lock_brightness: [0.0, 0.5],
    // Combing makes locks of dry hair more alike.
    lock_disorder: 0.6,
    color: 1.0,
    guides: GuideForces { points: 8, stiffness: 1.0, lift: 1.0, follows_skin: false, waves: 0.0, curl: 0.0 },
};

impl StyleForces {
    /// Returns the forces of a style.
    pub const fn of(style: Style) -> Self {
        let guides = STRAIGHT.guides;
        match style {
            Style::Straight => STRAIGHT,
            Style::Curly => Self { helix: true, guides: GuideForces { points: 29, curl: 0.035, ..guides }, ..STRAIGHT },
            Style::Messy => Self {
                segments: 28.0,
                disorder: 0.4,
                fields: &[(4, 1.5), (9, 1.0)],
                // Noise is stronger sideways than up and down, because hair that points into the surface looks broken.
                // Long hair droops.
                field_scale: Vec3::new(1.0, 1.0, 0.4),
                field_growth: [0.35, 0.65],
                droop: 0.3,
                guides: GuideForces { waves: 0.9, ..guides },
                ..STRAIGHT
            },
            Style::Wet => Self {
                segments: 28.0,
                lean: [0.6, 0.4],
                frizz: 0.35,
                wet: true,
                lock_brightness: [0.7, 0.0],
                lock_disorder: 1.0,
                color: 0.45,
                guides: GuideForces { stiffness: 0.3, lift: 0.4, ..guides },
                ..STRAIGHT
            },
            Style::Lying => Self {
                root_deg: [60.0, 20.0, 0.0],
                tip_deg: [80.0, 8.0],
                disorder: 0.06,
                frizz: 0.35,
                // A slowly varying sideways flow, so that combed fur does not look like a printed pattern.
                fields: &[(3, 1.0)],
                field_scale: Vec3::new(0.5, 0.5, 0.0),
                guides: GuideForces { stiffness: 0.3, lift: 0.4, follows_skin: true, ..guides },
                ..STRAIGHT
            },
        }
    }
}
