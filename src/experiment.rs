//! One variant of a case, checked and converted to SI units: all data that a simulation needs.

use crate::contact_law::ContactLaw;
use crate::particles::Particles;
use crate::scene::{Scene, StartRegion};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// The name of a collision model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "case", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Model {
    /// Time-stepped spring-dashpot contacts.
    Soft,
    /// Instantaneous collisions.
    Hard,
    /// Instantaneous collisions where two meet alone, spring-dashpot contacts elsewhere.
    Hybrid,
}

impl Model {
    /// Name of the model in a case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Soft => "soft",
            Self::Hard => "hard",
            Self::Hybrid => "hybrid",
        }
    }

    /// True if contacts of the model last, so that it needs a contact law and a time step.
    pub fn has_contacts(self) -> bool {
        match self {
            Self::Soft | Self::Hybrid => true,
            Self::Hard => false,
        }
    }
}

/// A collision model with the data it requires.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Spheres {
    /// Soft spheres, with this contact law between pairs and at walls.
    Soft(ContactLaw),
    /// Hard spheres.
    Hard,
    /// Hard spheres where two meet alone, soft spheres with this contact law elsewhere.
    Hybrid(ContactLaw),
}

/// All data that a simulation needs, in SI units.
#[derive(Clone, Debug, Serialize)]
pub struct Experiment {
    /// Name of the variant.
    pub name: String,
    /// Name of the variant it is compared with, if the case says so.
    pub against: Option<String>,
    /// The scene, which both engines read.
    pub scene: Scene,
    /// Initial state of the particles.
    pub start: Vec<Population>,
    /// Settings of the soft engine.
    pub soft: SoftSettings,
    /// Settings of the hard engine.
    pub hard: HardSettings,
    /// Settings of the hybrid engine, besides those of the soft one.
    pub hybrid: HybridSettings,
    /// Length, window, seed, model.
    pub run: RunSettings,
    /// Settings of the averages.
    pub statistics: StatisticsSettings,
}

impl Experiment {
    /// The collision model that runs.
    pub fn model(&self) -> Model {
        match self.run.spheres {
            Spheres::Soft(_) => Model::Soft,
            Spheres::Hard => Model::Hard,
            Spheres::Hybrid(_) => Model::Hybrid,
        }
    }

    /// The contact law that runs; `None` for hard spheres.
    pub fn law(&self) -> Option<ContactLaw> {
        match self.run.spheres {
            Spheres::Soft(law) | Spheres::Hybrid(law) => Some(law),
            Spheres::Hard => None,
        }
    }

    /// Number of particles at the start.
    pub fn count(&self) -> usize {
        self.start.iter().map(|population| population.amount.count()).sum()
    }

    /// Number of particles of each species at the start.
    pub fn counts(&self) -> Vec<usize> {
        let mut counts = vec![0; self.scene.species.len()];
        for population in &self.start {
            counts[usize::from(population.species)] += population.amount.count();
        }
        counts
    }
}

/// Particles of one species and their initial state.
#[derive(Clone, Debug, Serialize)]
pub struct Population {
    /// Index into [`Scene::species`].
    pub species: u16,
    /// Number of particles, or their positions.
    pub amount: Amount,
    /// The part of the domain that a random start fills; `None`: all of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub region: Option<StartRegion>,
    /// [m/s] mean velocity of a random start, met exactly by two spheres and more.
    pub velocity_mean: Vector3<f64>,
    /// [m/s] standard deviation of each velocity component of a random start, met exactly by two spheres and more. A
    /// single sphere draws from a normal law of this width about the mean.
    pub velocity_fluctuation: Vector3<f64>,
    /// [rad/s] mean spin of a random start.
    #[serde(skip_serializing_if = "is_zero")]
    pub spin_mean: Vector3<f64>,
    /// [rad/s] standard deviation of each spin component of a random start.
    #[serde(skip_serializing_if = "is_none")]
    pub spin_fluctuation: f64,
}

/// True for the spin of spheres that do not rotate at the start, which a stored experiment does not need.
fn is_zero(spin: &Vector3<f64>) -> bool {
    *spin == Vector3::zeros()
}

/// True for a deviation of 0, as in [`is_zero`].
fn is_none(deviation: &f64) -> bool {
    *deviation == 0.0
}

impl Population {
    /// [m/s] root mean square over the components of the fluctuation of a random start.
    pub fn mean_fluctuation(&self) -> f64 {
        let v = self.velocity_fluctuation;
        // equal components are returned without the rounding of a root
        if v.x == v.y && v.y == v.z { v.x } else { (v.norm_squared() / 3.0).sqrt() }
    }
}

/// Number of particles, or the particles themselves.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Amount {
    /// This number, at random positions without overlap.
    Count(usize),
    /// These particles, as read from a file.
    Placed(Particles),
}

impl Amount {
    /// Number of particles.
    pub fn count(&self) -> usize {
        match self {
            Self::Count(count) => *count,
            Self::Placed(particles) => particles.len(),
        }
    }
}

/// Soft-sphere settings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SoftSettings {
    /// The contact law that the case names, for pairs and walls; a case that runs only with hard spheres may name
    /// none.
    pub law: Option<ContactLaw>,
    /// Choice of the time step.
    pub time_step: TimeStep,
    /// Particles that are stepped.
    pub stepping: SoftStepping,
    /// The time integrator.
    pub integrator: Integrator,
    /// True if a step beyond the scheme's stability may run, where energy may grow without limit.
    pub allow_unstable: bool,
}

/// Choice of the soft time step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TimeStep {
    /// [-] N_c: Δt = shortest contact time / N_c.
    PerContact(f64),
    /// [s] Δt itself.
    Fixed(f64),
}

/// Particles that a soft step moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "case", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum SoftStepping {
    /// Every particle at every step.
    Uniform,
    /// Only particles that touch; the rest fly.
    Local,
    /// Whichever costs less.
    Auto,
}

/// Time integrator of the soft engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "case", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Integrator {
    /// Kick-drift-kick; the dashpot sees the half-step velocity.
    VelocityVerlet,
    /// Heun's second-order Runge-Kutta. The paper has a scheme of this order for its fluid step and names none for
    /// contacts.
    Rk2,
}

/// Hard-sphere settings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HardSettings {
    /// Method of finding collisions.
    pub stepping: HardStepping,
    /// [s] t_c of the TC model: a collision sooner than this after another of either particle is elastic; `None`: no
    /// collision is.
    pub contact_time: Option<f64>,
}

/// Hybrid settings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HybridSettings {
    /// [-] θ: a touch is treated as an instant if no other particle can come within θ contact times.
    pub clearance: f64,
}

/// Method by which the hard engine finds collisions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum HardStepping {
    /// At the exact instants of touch, from an event queue.
    Events,
    /// At the ends of steps Δt < θ d/u_r, as overlaps (the paper's section 3.4).
    Steps {
        /// [-] θ.
        theta: f64,
    },
}

/// Length, window and seed of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunSettings {
    /// [s] interval of instants at which windows must also end, so that all particles can be written there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instants: Option<f64>,
    /// Collision model of the run.
    pub spheres: Spheres,
    /// [s] simulated time.
    pub duration: f64,
    /// Start of averaging.
    pub average_from: AverageFrom,
    /// [s] window h; `None`: chosen from the scene.
    pub window: Option<f64>,
    /// Seed of the initial state.
    pub seed: u64,
}

/// The particles written out over time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Trajectories {
    /// [s] time between two instants, counted from the start.
    pub every: f64,
    /// File format.
    pub format: TrajectoryFormat,
}

/// File format of trajectories.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "case", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum TrajectoryFormat {
    /// VTK PolyData, for ParaView.
    Vtp,
    /// Extended XYZ, for OVITO and ASE.
    Xyz,
    /// One VTK file and one XYZ frame of each instant.
    Both,
}

impl TrajectoryFormat {
    /// True if VTK files are asked for.
    pub fn is_vtp(self) -> bool {
        matches!(self, Self::Vtp | Self::Both)
    }

    /// True if extended XYZ files are asked for.
    pub fn is_xyz(self) -> bool {
        matches!(self, Self::Xyz | Self::Both)
    }
}

/// Start of averaging.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AverageFrom {
    /// [s] at this simulated time.
    Time(f64),
    /// At the time from which the run itself finds its state steady.
    Steady,
}

/// Settings of the averages.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StatisticsSettings {
    /// Number of slices normal to y.
    pub slices: usize,
    /// [s] time between samples; `None`: chosen from the scene.
    pub sample_interval: Option<f64>,
}
