//! Coarse model: predicts cost and error of a setting from the measured settings.
//!
//! Each figure is a weighted sum of four terms that depend on the setting. The initial weights are those of the
//! built-in hare (`assets/charts/hare/shells.csv`). Measurements of the current animal correct them by ridge regression
//! about this prior, in relative units.

use super::{Setting, SettingFigures};
use glam::{DMat4, DVec4};

/// Predictor of one figure.
#[derive(Clone, Debug)]
pub(super) struct Model {
    terms: fn(&Setting) -> DVec4,
    /// Weights before any measurement. Their common scale is fitted to the measurements.
    prior: DVec4,
    weights: DVec4,
    /// Root mean square of the fit's relative residuals.
    residual: f64,
}

/// Strength of the prior, in equivalent measurements. It is weak, because animals differ in the amount of visible fur.
const PRIOR_STRENGTH: f64 = 0.02;
/// Minimum relative residual that is assumed for a model.
const LEAST_RESIDUAL: f64 = 0.02;
/// Minimum relative residual while there are no more measurements than terms.
const UNSURE_RESIDUAL: f64 = 0.08;

/// Minimum relative residual for a combination of tile size and fins that was not measured with any number of layers.
const UNSEEN_RESIDUAL: f64 = 0.05;

/// Returns the terms of the error: a constant, a term that halves with twice the layers, one that halves with twice the
/// texels, and fins.
fn error_terms(s: &Setting) -> DVec4 {
    DVec4::new(1.0, 4.0 / f64::from(s.layers.max(2) - 1), 32.0 / f64::from(s.tile_texels), f64::from(u8::from(s.fins)))
}

/// Returns the terms of the frame time. Each layer costs the same; it costs slightly more if its texels are too fine
/// for the cache.
fn frame_terms(s: &Setting) -> DVec4 {
    let shells = f64::from(s.layers.max(2) - 1) / 16.0;
    let fineness = libm::log2(f64::from(s.tile_texels) / 32.0) / 4.0;
    DVec4::new(1.0, shells, shells * fineness, f64::from(u8::from(s.fins)))
}

/// Returns the terms of the size: texels of the shells, and of the fin textures, which have the same resolution.
fn byte_terms(s: &Setting) -> DVec4 {
    let side = f64::from(s.tile_texels) / 64.0;
    let fins = f64::from(u8::from(s.fins));
    DVec4::new(1.0, f64::from(s.layers) / 16.0 * side * side, fins, fins * side * side)
}

/// Returns the models of all figures, in the order of [`super::Figure::ALL`].
pub(super) fn models() -> [Model; 3] {
    let model = |terms, prior: [f64; 4]| {
        let prior = DVec4::from(prior);
        Model { terms, prior, weights: prior, residual: UNSURE_RESIDUAL }
    };
    [
        model(error_terms, [0.70, 0.25, 0.15, -0.05]),
        model(frame_terms, [0.25, 0.55, 0.10, 0.15]),
        model(byte_terms, [0.5, 0.3, 0.1, 0.1]),
    ]
}

impl Model {
    /// Predicts the figure of a setting.
    pub(super) fn predict(&self, setting: &Setting) -> f64 {
        self.weights.dot((self.terms)(setting))
    }

    /// Returns an optimistic prediction. `beside` says whether a setting was measured that differs only in layers. If
    /// not, the residual is at least `UNSEEN_RESIDUAL`.
    pub(super) fn optimistic(&self, setting: &Setting, beside: bool) -> f64 {
        let residual = if beside { self.residual } else { self.residual.max(UNSEEN_RESIDUAL) };
        let predicted = self.predict(setting);
        predicted - 2.0 * residual * predicted.abs()
    }

    /// Fits the weights to the measurements.
    pub(super) fn fit(&mut self, trials: &[(Setting, SettingFigures)], figure: fn(&SettingFigures) -> f64) {
        let points = || trials.iter().map(|(s, m)| ((self.terms)(s), figure(m)));
        // The prior is scaled to the magnitude of the measurements.
        let (found, expected) = points().fold((0.0, 0.0), |(f, e), (x, y)| (f + y, e + self.prior.dot(x)));
        let size = if expected > 0.0 { found / expected } else { 1.0 };
        // Residuals are relative, so that an error of 10 % has the same weight for cheap and for expensive settings.
        let (mut normal, mut right) = (DMat4::from_diagonal(DVec4::splat(PRIOR_STRENGTH)), PRIOR_STRENGTH * self.prior);
        for (x, y) in points() {
            let x = x / y.abs().max(1e-12) * size;
            normal += DMat4::from_cols(x * x.x, x * x.y, x * x.z, x * x.w);
            right += x;
        }
        self.weights = normal.inverse() * right * size;
        let count = trials.len().max(1) as f64;
        let square = |(x, y): (DVec4, f64)| {
            let off = (self.weights.dot(x) - y) / y.abs().max(1e-12);
            off * off
        };
        let residual = (points().map(square).sum::<f64>() / count).sqrt();
        let least = if trials.len() > 4 { LEAST_RESIDUAL } else { UNSURE_RESIDUAL };
        self.residual = residual.max(least);
    }
}
