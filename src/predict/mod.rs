//! Predictions before a run.
//!
//! They are closed forms and quadratures of a scene's numbers: nothing runs, nothing is written. Each prediction
//! names its source and what it leaves out. A [`RunPrediction`] combines them with the measurements of a short
//! calibration, and a [`Recommendation`] is derived from it.

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
pub mod transient;

pub use obstacles::Obstacles;
pub use recommendation::{EngineChoice, Recommendation, recommend};
pub use transient::Transient;

use serde::Serialize;

/// Strength of the random motion of the particles.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Agitation {
    /// [m²/s²] granular temperature: mean variance of a velocity component over all particles.
    pub variance: f64,
    /// Source of the variance.
    pub source: String,
}

/// A short run of the case's own physics in a smaller periodic box, with its results.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Calibration {
    /// Number of particles in the short run.
    pub particles: usize,
    /// [s] simulated time.
    pub simulated: f64,
    /// True if the averaged part was steady.
    pub steady: bool,
    /// [1/s] collisions of a particle per time, and standard error; each `None` if unknown.
    pub collision_rate: [Option<f64>; 2],
    /// [1/s] wall impacts of a particle per time, and standard error; each `None` if unknown.
    pub wall_rate: [Option<f64>; 2],
    /// [-] relative standard error of the granular temperature of a slice (median over slices).
    pub temperature_error: Option<f64>,
    /// [s] length of the averaged part.
    pub averaged: f64,
    /// [m] edges of the smaller box.
    pub size: [f64; 3],
    /// Reason why the engine stopped, if it did.
    pub failure: Option<String>,
}

/// Cost of a model on this machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PredictedCost {
    /// The model.
    pub model: EngineChoice,
    /// [s] wall time of the whole run; none if it fails.
    pub wall_seconds: Option<f64>,
    /// Number of windows that were timed.
    pub windows_timed: u64,
    /// [byte] largest memory of the process; none where the system does not report it.
    pub memory: Option<f64>,
    /// Reason why the model cannot run, if it cannot.
    pub failure: Option<String>,
}

/// Size and length of a run that reach the wanted error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Averaging {
    /// [m] smallest edges along periodic axes; the other edges are those of the case.
    pub size: [f64; 3],
    /// Number of particles in that box.
    pub particles: usize,
    /// [s] averaging time in that box.
    pub duration: f64,
    /// [s] averaging time in the box of the case.
    pub duration_as_given: f64,
}

/// All predictions before the run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunPrediction {
    /// [-] relative error wanted.
    pub target_error: f64,
    /// Number of particles.
    pub particles: usize,
    /// [s] simulated time.
    pub duration: f64,
    /// [s] window h.
    pub window: f64,
    /// Strength of the random motion.
    pub agitation: Agitation,
    /// The contact law that contacts are predicted for, in words.
    pub contact_law: String,
    /// Method of the soft time steps that contacts are predicted for.
    pub integrator: String,
    /// Contacts under the case's contact law, or the one recommended if it has none.
    pub contacts: Vec<contact::ContactPrediction>,
    /// Limits on the soft time step, the binding one first.
    pub step_limits: Vec<contact::StepLimit>,
    /// Kinetic theory; none for a few bodies.
    pub gas: Option<gas::Gas>,
    /// [-] fraction of the time that a particle is in contact.
    pub time_in_contact: Option<f64>,
    /// Particles of the largest island expected in a window; none if islands join without bound or the theory does not
    /// apply.
    pub largest_island: Option<usize>,
    /// [-] apparent decrease of the diameter of soft spheres, over the diameter.
    pub softness: Option<f64>,
    /// The floor on which particles gather under gravity.
    pub rest: Option<rest::Rest>,
    /// [-] overlap of the lowest contact under the weight above it, over the diameter.
    pub static_overlap: Option<f64>,
    /// True if particles overlap at the start.
    pub starts_overlapping: bool,
    /// True if the start has rows of touching particles.
    pub in_a_row: bool,
    /// Number of particles that lie on something at the start.
    pub lying: usize,
    /// The gas around the particles, by species.
    pub flow: Vec<flow::Flow>,
    /// Effects, and which of them can be left out.
    pub effects: Vec<effects::Effect>,
    /// The short calibration run.
    pub calibration: Option<Calibration>,
    /// Cost of each model.
    pub costs: Vec<PredictedCost>,
    /// Size and length of a run for the wanted error; none where nothing is steady.
    pub averaging: Option<Averaging>,
    /// Predictions instead of averages where nothing is steady.
    pub transient: Option<Transient>,
}

impl RunPrediction {
    /// Obstacles from the start, as `check` finds them too.
    pub fn obstacles(&self) -> Obstacles {
        Obstacles {
            rest: self.rest.clone(),
            overlapping: self.starts_overlapping,
            in_a_row: self.in_a_row,
            lying: self.lying,
        }
    }

    /// [-] share of the run in which particles lie on a floor.
    pub fn share_at_rest(&self) -> f64 {
        self.rest.as_ref().map_or(0.0, |rest| (1.0 - rest.time / self.duration).max(0.0))
    }
}

/// Shortest side that is trusted to hold independent particles [m]: 10 diameters, and two mean free paths or the
/// width between the walls, whichever is less. This is a rule of this program: within two free paths most of a
/// particle's velocity is forgotten.
pub fn shortest_side(diameter: f64, mean_free_path: f64, height: f64) -> f64 {
    let path = if mean_free_path.is_finite() { 2.0 * mean_free_path } else { height };
    (10.0 * diameter).max(path.min(height))
}
