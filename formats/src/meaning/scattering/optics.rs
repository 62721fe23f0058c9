//! Light that meets a smooth dielectric cylinder: how it is refracted, reflected and absorbed (Marschner 2003, section 4).

/// The least cosine of the difference angle: nearer to along the fibre, light is taken to come as at this. The lobes divide by its square.
pub const LEAST_COS_D: f64 = 0.1;

/// The cross-section of a fibre for light at one difference angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Index of refraction, above 1.
    pub eta: f64,
    /// Cosine of the difference angle θd, [`LEAST_COS_D`]..=1.
    pub cos_d: f64,
    /// Index of refraction as it looks in the plane across the fibre: η′ = √(η² − sin²θd) / cos θd.
    pub across: f64,
    /// Cosine of the angle within the fibre, from the plane across it.
    pub cos_t: f64,
}

impl Section {
    /// That of a fibre of index `eta`, above 1, for light at the difference angle of that cosine; what is less than [`LEAST_COS_D`] is that.
    pub fn new(eta: f64, cos_d: f64) -> Self {
        let cos_d = cos_d.clamp(LEAST_COS_D, 1.0);
        let under = (eta * eta - (1.0 - cos_d * cos_d)).max(0.0).sqrt();
        Self { eta, cos_d, across: under / cos_d, cos_t: under / eta }
    }

    /// Reflectance for unpolarised light that meets the fibre so far from its middle that its angle in the plane across has that cosine, 0..=1. Light from
    /// within is reflected by the same.
    pub fn fresnel(&self, cos_gamma: f64) -> f64 {
        // The angle in space. With that in the plane the part polarised along it would need another angle of refraction for its other index.
        let c = self.cos_d * cos_gamma;
        let t = (1.0 - (1.0 - c * c) / (self.eta * self.eta)).max(0.0).sqrt();
        let of = |a: f64, b: f64| if a + b > 0.0 { (a - b) / (a + b) } else { 1.0 };
        let (s, p) = (of(c, self.eta * t), of(self.eta * c, t));
        0.5 * (s * s + p * p)
    }

    /// Sine and cosine of the angle after refraction, for that sine in the plane across.
    pub fn refracted(&self, sin_gamma: f64) -> (f64, f64) {
        let sin = (sin_gamma / self.across).clamp(-1.0, 1.0);
        (sin, (1.0 - sin * sin).max(0.0).sqrt())
    }

    /// How far light goes through the fibre from wall to wall, over its radius.
    pub fn chord(&self, sin_gamma: f64) -> f64 {
        2.0 * self.refracted(sin_gamma).1 / self.cos_t
    }

    /// Share of the light that leaves after it was reflected within twice and more, where so much is reflected and a way through leaves so much of it.
    pub fn rest(&self, reflected: f64, through: f64) -> f64 {
        let within = (1.0 - reflected) * (1.0 - reflected);
        let again = reflected * through;
        // Along the surface nothing gets within.
        if again >= 1.0 { 0.0 } else { within * reflected * reflected * through * through * through / (1.0 - again) }
    }

    /// Share of the light that leaves on path `p` (0: reflected, 1: through, 2: reflected once within) without what it loses on its way, which is
    /// exp(−σ p chord).
    pub fn share(&self, p: u32, cos_gamma: f64) -> f64 {
        let f = self.fresnel(cos_gamma);
        match p {
            0 => f,
            1 => (1.0 - f) * (1.0 - f),
            _ => (1.0 - f) * (1.0 - f) * f,
        }
    }
}
