//! What can be said before anything is run?
//!
//! Closed forms and quadratures of a scene's numbers: no running, no output. Each prediction names its source and what it
//! leaves out. A [`RunPrediction`] holds them together with what a short calibration has measured, and a [`Recommendation`] is
//! drawn from it.

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

/// How much the particles move about each other.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Agitation {
    /// [m²/s²] granular temperature: mean variance of a velocity component over all particles.
    pub variance: f64,
    /// Where that is from.
    pub source: String,
}

/// A short run of the case's own physics in a smaller periodic box, and what it showed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Calibration {
    /// Particles in it.
    pub particles: usize,
    /// [s] simulated.
    pub simulated: f64,
    /// Whether its averaged part was steady.
    pub steady: bool,
    /// [1/s] collisions that a particle suffered per time, and standard error; each `None` if it is not known.
    pub collision_rate: [Option<f64>; 2],
    /// [1/s] wall impacts of a particle per time, and standard error; each `None` if it is not known.
    pub wall_rate: [Option<f64>; 2],
    /// [-] relative standard error of the granular temperature of a slice (median over slices).
    pub temperature_error: Option<f64>,
    /// [s] length of the averaged part.
    pub averaged: f64,
    /// [m] edges of its box.
    pub size: [f64; 3],
    /// Why the engine stopped, if it did.
    pub failure: Option<String>,
}

/// What a model costs on this machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PredictedCost {
    /// Which model.
    pub model: EngineChoice,
    /// [s] wall time of the whole run; none if it fails.
    pub wall_seconds: Option<f64>,
    /// Windows that were timed.
    pub windows_timed: u64,
    /// [byte] largest memory of the process; none where the system does not tell.
    pub memory: Option<f64>,
    /// Why it cannot run, if it cannot.
    pub failure: Option<String>,
}

/// How large and how long a run must be for the error wanted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Averaging {
    /// [m] smallest periodic edges; the others as they are.
    pub size: [f64; 3],
    /// Particles in that box.
    pub particles: usize,
    /// [s] averaging time there.
    pub duration: f64,
    /// [s] averaging time in the box of the case.
    pub duration_as_given: f64,
}

/// Everything that is known before the run.
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
    /// How much they move.
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
    /// Particles of the largest island expected in a window; none if islands join without bound or the theory does not apply.
    pub largest_island: Option<usize>,
    /// [-] by how much soft spheres act smaller.
    pub softness: Option<f64>,
    /// Where particles gather under gravity.
    pub rest: Option<rest::Rest>,
    /// [-] overlap of the lowest contact under the weight above it, over the diameter.
    pub static_overlap: Option<f64>,
    /// Whether particles overlap at the start.
    pub starts_overlapping: bool,
    /// Whether the start has rows of touching particles.
    pub in_a_row: bool,
    /// Particles that lie on something at the start.
    pub lying: usize,
    /// The gas around the particles, by species.
    pub flow: Vec<flow::Flow>,
    /// What can be left out.
    pub effects: Vec<effects::Effect>,
    /// The short run.
    pub calibration: Option<Calibration>,
    /// What each model costs.
    pub costs: Vec<PredictedCost>,
    /// Size and length for the error wanted; none where nothing is steady.
    pub averaging: Option<Averaging>,
    /// What is asked instead where nothing is steady.
    pub transient: Option<Transient>,
}

impl RunPrediction {
    /// What the start shows of itself, as `check` sees it too.
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

/// The shortest side that is trusted to hold independent particles [m]: 10 diameters, and two mean free paths or the width
/// between the walls, whichever is less. A rule of this program: within two free paths most of a particle's velocity is forgotten.
pub fn shortest_side(diameter: f64, mean_free_path: f64, height: f64) -> f64 {
    let path = if mean_free_path.is_finite() { 2.0 * mean_free_path } else { height };
    (10.0 * diameter).max(path.min(height))
}
