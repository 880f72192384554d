//! Predictions that are made before a run.
//!
//! Predictions are formulae and numerical integrals that use only the data of a scene. They need no run and write no
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
mod pull;
pub mod recommendation;
pub mod rest;
pub mod shear;
pub mod springs;
mod touching;
pub mod transient;

pub use obstacles::Obstacles;
pub use recommendation::{EngineChoice, Recommendation, recommend};
pub use transient::Transient;

use serde::Serialize;

/// Granular temperature of the particles, and its source.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Agitation {
    /// [m²/s²] granular temperature: variance of a velocity component, averaged over components and particles.
    pub variance: f64,
    /// Source of the variance, in words: an estimate or a measurement.
    pub source: String,
}

/// Calibration run: short run of the case, with all its physics, in a smaller periodic box. This type holds its
/// settings and results.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Calibration {
    /// Number of particles in the short run of the case.
    pub particles: usize,
    /// [s] simulated time of the short run.
    pub simulated: f64,
    /// True if the short run was in a steady state during the averaging time.
    pub steady: bool,
    /// [1/s] number of collisions per particle and time with other particles, and its standard error; each is `None` if
    /// unknown.
    pub collision_rate: [Option<f64>; 2],
    /// [1/s] number of impacts on walls per particle and time, and its standard error; each is `None` if unknown.
    pub wall_rate: [Option<f64>; 2],
    /// [-] relative standard error of the granular temperature of a slice along y (median over slices); `None` if
    /// unknown.
    pub temperature_error: Option<f64>,
    /// [s] simulated time over which the results of the short run were averaged.
    pub averaged: f64,
    /// [m] edges of the box of the short run, along x, y and z.
    pub size: [f64; 3],
    /// Reason why the engine stopped the short run early; `None` if the run ended regularly.
    pub failure: Option<String>,
}

/// Computing time and memory that a run of one model takes on this machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PredictedCost {
    /// Model: kind of engine, and its way of time stepping.
    pub model: EngineChoice,
    /// [s] predicted wall-clock time of the whole run; `None` if the model fails.
    pub wall_seconds: Option<f64>,
    /// Number of windows (times between two exchanges with the gas) whose computing time was measured.
    pub windows_timed: u64,
    /// [byte] predicted memory of the run: memory of this process after the timed windows, without the copy of the
    /// initial particles, plus memory of the report. `None` if the operating system does not tell how much memory is
    /// in use.
    pub memory: Option<f64>,
    /// Reason why no run of the model is possible; `None` if a run is possible.
    pub failure: Option<String>,
}

/// Box and duration of a run in which averages reach the desired error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Averaging {
    /// [m] edges of the smallest box in which averages can reach the desired error. Only edges along periodic axes may
    /// differ from those of the case.
    pub size: [f64; 3],
    /// Number of particles in the box of the size `size`.
    pub particles: usize,
    /// [s] averaging time with which averages in the box of the size `size` reach the desired error.
    pub duration: f64,
    /// [s] averaging time with which averages in the box of the case reach the desired error.
    pub duration_as_given: f64,
}

/// All predictions for a run, made before the run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunPrediction {
    /// [-] relative error that is desired for averages over the run.
    pub target_error: f64,
    /// Number of particles at the start of the run.
    pub particles: usize,
    /// Number of particles, at least 1, that inlets are expected to bring into the scene; `None` without inlets.
    pub coming: Option<usize>,
    /// [s] simulated time of the whole run.
    pub duration: f64,
    /// [s] window h: time between two exchanges of momentum with the gas.
    pub window: f64,
    /// Granular temperature of the particles, and its source.
    pub agitation: Agitation,
    /// Contact law, in words, under which contacts are predicted.
    pub contact_law: String,
    /// Integrator of the soft time steps for which contacts are predicted.
    pub integrator: String,
    /// Predictions for each kind of contact under the contact law of the case. If the case has no contact law, the
    /// recommended law is used.
    pub contacts: Vec<contact::ContactPrediction>,
    /// Limits on the time step of soft spheres, the shortest first. The first one determines the step.
    pub step_limits: Vec<contact::StepLimit>,
    /// Predictions of kinetic theory; `None` for scenes with few bodies.
    pub gas: Option<gas::Gas>,
    /// [-] mean fraction of the time in which a particle is in contact with other bodies. It is at least the fraction
    /// in which particles rest on a floor. `None` if neither kinetic theory nor such a rest predicts the fraction.
    pub time_in_contact: Option<f64>,
    /// Number of particles in the largest island (group of particles that may meet within a window, the time between
    /// two exchanges with the gas). `None` if islands would grow without bound, or if the theory is not valid.
    pub largest_island: Option<usize>,
    /// [-] apparent decrease of the diameter of soft spheres in collisions, divided by the diameter; `None` if the
    /// decrease is 0 or kinetic theory is not valid.
    pub softness: Option<f64>,
    /// Ratios of time scales in a sheared box, and the effect of softness on its stress; `None` without shear.
    pub shear: Option<shear::ShearPrediction>,
    /// Floor on which particles gather under gravity; `None` if there is no such floor.
    pub rest: Option<rest::Rest>,
    /// [-] overlap of a contact at the floor due to the weight of all particles above it, divided by the diameter.
    /// `None` if the particles do not come to rest.
    pub static_overlap: Option<f64>,
    /// True if particles overlap each other or a wall at the start.
    pub starts_overlapping: bool,
    /// True if particles lie in rows at the start, with gaps of less than twice the overlap of an impact.
    pub in_a_row: bool,
    /// Number of particles that lie on a wall or on other particles at the start.
    pub lying: usize,
    /// Response of each species to the gas; empty without gas or drag.
    pub flow: Vec<flow::Flow>,
    /// Physical effects in the scene, with their sizes.
    pub effects: Vec<effects::Effect>,
    /// Results of the short calibration run; `None` if there was none.
    pub calibration: Option<Calibration>,
    /// Predicted computing time and memory of each model that can run the case.
    pub costs: Vec<PredictedCost>,
    /// Box and duration with which averages reach the desired error; `None` if the scene has no steady state.
    pub averaging: Option<Averaging>,
    /// Predictions for a scene without a steady state, in place of averages; otherwise `None`.
    pub transient: Option<Transient>,
}

impl RunPrediction {
    /// Obstacles to each model that the scene and the initial state show. The command `check` also reports them.
    pub fn obstacles(&self) -> Obstacles {
        Obstacles {
            rest: self.rest.clone(),
            overlapping: self.starts_overlapping,
            in_a_row: self.in_a_row,
            lying: self.lying,
        }
    }

    /// [-] fraction of the duration of the run in which particles lie at rest on a floor.
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
