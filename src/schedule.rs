//! How long are the windows, and when are samples taken?
//!
//! The choice depends on the scene alone, not on the model: both engines see the same drag splitting and are sampled at
//! the same times.

use crate::experiment::{Amount, Experiment};

/// Windows per drag response time: the splitting error of a window is (h/τ)²/24 of a velocity change, below 1e-6 here.
const WINDOWS_PER_RESPONSE: f64 = 400.0;

/// In one window a particle of twice the rms speed travels this fraction of the mean spacing: it then has few
/// candidates to meet.
const SPACINGS_PER_WINDOW: f64 = 0.5;

/// Windows in a run that neither drag nor crowding divides, and samples in one that drag does not.
const PIECES: f64 = 200.0;

/// Windows between samples where drag sets the window: a twentieth of the response time, well below what velocities need to change.
const WINDOWS_PER_SAMPLE: f64 = 20.0;

/// Equal windows, grouped between samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule {
    /// [s] window h.
    pub window: f64,
    /// Windows between two samples.
    pub windows_per_sample: u64,
    /// Samples after the one at the start.
    pub samples: u64,
}

impl Schedule {
    /// The schedule of an experiment: no window is longer than the one it gives or, without one, than the scene allows;
    /// all are equal and a whole number of them makes the duration.
    pub fn new(experiment: &Experiment) -> Self {
        let duration = experiment.run.duration;
        if duration <= 0.0 {
            return Self { window: 0.0, windows_per_sample: 0, samples: 0 };
        }
        let longest = experiment.run.window.unwrap_or_else(|| automatic_window(experiment)).min(duration);
        let interval = experiment.statistics.sample_interval.unwrap_or_else(|| {
            if experiment.scene.fluid.is_some() { longest * WINDOWS_PER_SAMPLE } else { duration / PIECES }
        });
        let interval = interval.clamp(longest, duration);
        // rounding of the quotients must not add a window
        let samples = (duration / interval - 1e-9).ceil().max(1.0);
        let windows_per_sample = (duration / samples / longest - 1e-9).ceil().max(1.0);
        Self {
            window: duration / (samples * windows_per_sample),
            windows_per_sample: windows_per_sample as u64,
            samples: samples as u64,
        }
    }
}

/// [s] the longest window that keeps the drag splitting error and the number of candidates low.
fn automatic_window(experiment: &Experiment) -> f64 {
    let scene = &experiment.scene;
    let mut window = experiment.run.duration / PIECES;
    let mut count = 0.0;
    let mut speed: f64 = 0.0;
    for population in &experiment.start {
        count += match &population.amount {
            Amount::Count(count) => *count as f64,
            Amount::Placed(list) => list.len() as f64,
        };
        speed = speed.max(population.velocity_fluctuation);
        if let Some(fluid) = &scene.fluid
            && let Some(drag) = &fluid.drag
        {
            let species = &scene.species[population.species as usize];
            let slip = (fluid.profile.velocity(0.5 * scene.domain.size.y) - population.velocity_mean.z).abs();
            let response = drag.law().response_time(&fluid.sphere(species), slip);
            window = window.min(response / WINDOWS_PER_RESPONSE);
        }
    }
    if speed > 0.0 && count > 1.0 {
        let spacing = (scene.domain.volume() / count).cbrt();
        window = window.min(SPACINGS_PER_WINDOW * spacing / (2.0 * speed));
    }
    window
}
