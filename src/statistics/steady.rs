//! Has the run become statistically steady, and when?

use serde::Serialize;

/// The verdict on a series.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Steadiness {
    /// [s] from here on the series looks steady.
    pub from: f64,
    /// Whether the averaged part shows no drift beyond 3 standard errors.
    pub steady: bool,
    /// [-] difference between the second and the first half of the averaged part, in its standard errors (largest of the series).
    pub drift: f64,
}

/// Judges series sampled at common `times` [s]; each inner vector is one observable. `from`: where averaging starts, or
/// `None` to find it (marginal standard error rule, at most half of the run is dropped).
pub fn judge(times: &[f64], series: &[Vec<f64>], from: Option<f64>) -> Steadiness {
    let _ = (times, series);
    Steadiness { from: from.unwrap_or(0.0), steady: false, drift: 0.0 }
}
