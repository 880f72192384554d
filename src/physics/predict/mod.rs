//! Predictions that are made before a run.
//!
//! Predictions are closed forms and quadratures that use only the numbers of a scene. They need no run and write no
//! file. The documentation of each prediction names its source and the effects that it neglects. A [`RunPrediction`]
//! combines predictions with the measurements of a short calibration run, and a [`Recommendation`] is derived from it.

pub mod closed_form;
pub mod collision_integral;
pub mod contact;
pub mod effects;
pub mod energy;
pub mod flow;
pub mod gas;
pub mod integrator;
pub mod obstacles;
pub mod overlaps;
pub mod recommendation;
pub mod rest;
pub mod springs;
pub mod transient;

pub use obstacles::Obstacles;
pub use recommendation::{EngineChoice, Recommendation, recommend};
pub use transient::Transient;

use serde::Serialize;

/// Strength of the random motion of the particles, and the source of this number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Agitation {
    /// [m²/s²] granular temperature: variance of a velocity component, averaged over all particles.
    pub variance: f64,
    /// Source of the variance, in words: an estimate or a measurement.
    pub source: String,
}

/// Short run of the case, with all its physics, in a smaller periodic box, and the results of this run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Calibration {
    /// Number of particles in the short run of the case.
    pub particles: usize,
    /// [s] simulated time of the short run.
    pub simulated: f64,
    /// True if the state of the short run was steady during the averaging time.
    pub steady: bool,
    /// [1/s] number of collisions of a particle with other particles per time, and its standard error; each is `None`
    /// if unknown.
    pub collision_rate: [Option<f64>; 2],
    /// [1/s] number of wall impacts of a particle per time, and its standard error; each is `None` if unknown.
    pub wall_rate: [Option<f64>; 2],
    /// [-] relative standard error of the granular temperature of a slice (median over slices).
    pub temperature_error: Option<f64>,
    /// [s] time over which the results were averaged.
    pub averaged: f64,
    /// [m] edges of the smaller box.
    pub size: [f64; 3],
    /// Reason why the engine stopped the short run early; `None` if it did not stop early.
    pub failure: Option<String>,
}

/// Computing time and memory of a model on this machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PredictedCost {
    /// The model: kind of engine and stepping.
    pub model: EngineChoice,
    /// [s] wall-clock time of the whole run; `None` if the model fails.
    pub wall_seconds: Option<f64>,
    /// Number of windows (times between two exchanges with the gas) that were timed.
    pub windows_timed: u64,
    /// [byte] largest memory of the process; `None` if the system does not report it.
    pub memory: Option<f64>,
    /// Reason why the model cannot run; `None` if it can.
    pub failure: Option<String>,
}

/// Size and length of a run in which averages reach the desired error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Averaging {
    /// [m] smallest edges along periodic axes; the other edges are those of the case.
    pub size: [f64; 3],
    /// Number of particles in the box of this size.
    pub particles: usize,
    /// [s] averaging time in the box of this size.
    pub duration: f64,
    /// [s] averaging time with which the box of the case gives an equal error.
    pub duration_as_given: f64,
}

/// All predictions for a run, made before the run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunPrediction {
    /// [-] relative error desired for averages.
    pub target_error: f64,
    /// Number of particles in the run.
    pub particles: usize,
    /// [s] simulated time of the whole run.
    pub duration: f64,
    /// [s] window h: time between two exchanges of momentum with the gas.
    pub window: f64,
    /// Strength of the random motion of the particles.
    pub agitation: Agitation,
    /// Contact law, in words, for which contacts are predicted.
    pub contact_law: String,
    /// Integrator of the soft time steps for which contacts are predicted.
    pub integrator: String,
    /// Predicted contacts under the contact law of the case. If the case has no contact law, they are under the
    /// recommended law.
    pub contacts: Vec<contact::ContactPrediction>,
    /// Limits on the soft time step, the shortest first; the first one determines the step.
    pub step_limits: Vec<contact::StepLimit>,
    /// Predictions of kinetic theory; `None` for a few bodies.
    pub gas: Option<gas::Gas>,
    /// [-] mean fraction of the time in which a particle is in contact.
    pub time_in_contact: Option<f64>,
    /// Number of particles expected in the largest island of a window: a group of particles that may meet between two
    /// exchanges with the gas. `None` if islands unite without bound, or if the theory is not valid.
    pub largest_island: Option<usize>,
    /// [-] apparent decrease of the diameter of soft spheres, divided by the diameter.
    pub softness: Option<f64>,
    /// Floor on which particles gather under gravity; `None` if there is none.
    pub rest: Option<rest::Rest>,
    /// [-] overlap of the lowest contact due to the weight of the particles above it, divided by the diameter.
    pub static_overlap: Option<f64>,
    /// True if particles overlap at the start.
    pub starts_overlapping: bool,
    /// True if the start has rows of touching particles.
    pub in_a_row: bool,
    /// Number of particles that lie on a wall or on other particles at the start.
    pub lying: usize,
    /// Response of each species to the gas.
    pub flow: Vec<flow::Flow>,
    /// Physical effects in the scene, with their sizes.
    pub effects: Vec<effects::Effect>,
    /// Results of the short calibration run; `None` if there was none.
    pub calibration: Option<Calibration>,
    /// Computing cost of each model.
    pub costs: Vec<PredictedCost>,
    /// Size and length of a run for the desired error; `None` if the scene has no steady state.
    pub averaging: Option<Averaging>,
    /// Predictions that replace averages if the scene has no steady state.
    pub transient: Option<Transient>,
}

impl RunPrediction {
    /// Obstacles to each model that are visible at the start. The command `check` also reports them.
    pub fn obstacles(&self) -> Obstacles {
        Obstacles {
            rest: self.rest.clone(),
            overlapping: self.starts_overlapping,
            in_a_row: self.in_a_row,
            lying: self.lying,
        }
    }

    /// [-] fraction of the run in which particles lie at rest on a floor.
    pub fn share_at_rest(&self) -> f64 {
        self.rest.as_ref().map_or(0.0, |rest| (1.0 - rest.time / self.duration).max(0.0))
    }
}

/// [m] shortest edge of a box whose particles count as independent of their own periodic images. It is at least 10
/// diameters. It is also at least the smaller of two lengths: two mean free paths, and the width between the walls.
/// This rule is our choice: within two free paths a particle loses most of the memory of its velocity.
pub fn shortest_side(diameter: f64, mean_free_path: f64, height: f64) -> f64 {
    let path = if mean_free_path.is_finite() { 2.0 * mean_free_path } else { height };
    (10.0 * diameter).max(path.min(height))
}
