//! One variant of a case, checked and resolved to SI: all that a simulation needs.

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
    /// Its name in a case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Soft => "soft",
            Self::Hard => "hard",
            Self::Hybrid => "hybrid",
        }
    }

    /// Whether it has contacts that last, and so needs a contact law and a time step.
    pub fn has_contacts(self) -> bool {
        match self {
            Self::Soft | Self::Hybrid => true,
            Self::Hard => false,
        }
    }
}

/// A collision model with what it cannot do without.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Spheres {
    /// Soft ones, with this contact law between pairs and at walls.
    Soft(ContactLaw),
    /// Hard ones.
    Hard,
    /// Hard ones where two meet alone, soft ones with this contact law elsewhere.
    Hybrid(ContactLaw),
}

/// Everything a simulation needs, in SI units.
#[derive(Clone, Debug, Serialize)]
pub struct Experiment {
    /// Name of the variant.
    pub name: String,
    /// Name of the variant it is compared with, if the case says so.
    pub against: Option<String>,
    /// What both engines read.
    pub scene: Scene,
    /// Where the particles start.
    pub start: Vec<Population>,
    /// Settings of the soft engine.
    pub soft: SoftSettings,
    /// Settings of the hard engine.
    pub hard: HardSettings,
    /// Settings of the hybrid engine, besides those of the soft one.
    pub hybrid: HybridSettings,
    /// Length, window, seed, model.
    pub run: RunSettings,
    /// What is averaged.
    pub statistics: StatisticsSettings,
}

impl Experiment {
    /// Which collision model runs.
    pub fn model(&self) -> Model {
        match self.run.spheres {
            Spheres::Soft(_) => Model::Soft,
            Spheres::Hard => Model::Hard,
            Spheres::Hybrid(_) => Model::Hybrid,
        }
    }

    /// The contact law that runs; hard spheres have none.
    pub fn law(&self) -> Option<ContactLaw> {
        match self.run.spheres {
            Spheres::Soft(law) | Spheres::Hybrid(law) => Some(law),
            Spheres::Hard => None,
        }
    }

    /// How many particles start.
    pub fn count(&self) -> usize {
        self.start.iter().map(|population| population.amount.count()).sum()
    }

    /// How many particles of each species start.
    pub fn counts(&self) -> Vec<usize> {
        let mut counts = vec![0; self.scene.species.len()];
        for population in &self.start {
            counts[usize::from(population.species)] += population.amount.count();
        }
        counts
    }
}

/// How many particles of one kind, and how they start.
#[derive(Clone, Debug, Serialize)]
pub struct Population {
    /// Index into [`Scene::species`].
    pub species: u16,
    /// How many, or where.
    pub amount: Amount,
    /// The part of the domain that a random start fills; `None`: all of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub region: Option<StartRegion>,
    /// [m/s] mean velocity of a random start, met exactly by two spheres and more.
    pub velocity_mean: Vector3<f64>,
    /// [m/s] standard deviation of each velocity component of a random start, met exactly by two spheres and more; one alone
    /// draws from a normal law of this width about the mean.
    pub velocity_fluctuation: Vector3<f64>,
}

impl Population {
    /// [m/s] root mean square over the components of the fluctuation that a random start is given.
    pub fn mean_fluctuation(&self) -> f64 {
        let v = self.velocity_fluctuation;
        // equal components give themselves, without the rounding of a root
        if v.x == v.y && v.y == v.z { v.x } else { (v.norm_squared() / 3.0).sqrt() }
    }
}

/// How many particles.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Amount {
    /// That many, at random places without overlap.
    Count(usize),
    /// These, as read from a file.
    Placed(Particles),
}

impl Amount {
    /// How many particles that is.
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
    /// The contact law that the case names, for pairs and walls; a case that is only run with hard spheres may name none.
    pub law: Option<ContactLaw>,
    /// How long a time step is.
    pub time_step: TimeStep,
    /// Which particles are stepped.
    pub stepping: SoftStepping,
    /// The time integrator.
    pub integrator: Integrator,
    /// Whether a step beyond the scheme's stability may run, and energy may grow without end.
    pub allow_unstable: bool,
}

/// How the soft time step is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TimeStep {
    /// [-] N_c: Δt = shortest contact time / N_c.
    PerContact(f64),
    /// [s] Δt itself.
    Fixed(f64),
}

/// Which particles a soft step moves.
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
    /// Heun's second-order Runge-Kutta. The paper has a scheme of this order for its fluid step and names none for contacts.
    Rk2,
}

/// Hard-sphere settings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HardSettings {
    /// How collisions are found.
    pub stepping: HardStepping,
    /// [s] t_c of the TC model: a collision sooner than this after another of either particle is elastic; `None`: none is.
    pub contact_time: Option<f64>,
}

/// Hybrid settings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HybridSettings {
    /// [-] θ: a touch is an instant if nobody else can come within so many contact times.
    pub clearance: f64,
}

/// How the hard engine finds collisions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum HardStepping {
    /// At the exact instants of touch, from an event calendar.
    Events,
    /// As overlaps at the ends of steps Δt < θ d/u_r (the paper's section 3.4).
    Steps {
        /// [-] θ.
        theta: f64,
    },
}

/// Length, window and seed of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunSettings {
    /// [s] between two instants at which windows end besides, so that all particles can be written there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instants: Option<f64>,
    /// Which spheres collide.
    pub spheres: Spheres,
    /// [s] simulated time.
    pub duration: f64,
    /// Where averaging starts.
    pub average_from: AverageFrom,
    /// [s] window h; `None`: chosen from the scene.
    pub window: Option<f64>,
    /// Seed of the initial state.
    pub seed: u64,
}

/// The particles written out over time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Trajectories {
    /// [s] between two instants, counted from the start.
    pub every: f64,
    /// For which programs.
    pub format: TrajectoryFormat,
}

/// For which programs trajectories are written.
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
    /// Whether VTK files are asked for.
    pub fn is_vtp(self) -> bool {
        matches!(self, Self::Vtp | Self::Both)
    }

    /// Whether extended XYZ files are asked for.
    pub fn is_xyz(self) -> bool {
        matches!(self, Self::Xyz | Self::Both)
    }
}

/// Where averaging starts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AverageFrom {
    /// [s] at that simulated time.
    Time(f64),
    /// Where the run itself finds that it has become steady.
    Steady,
}

/// What is averaged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StatisticsSettings {
    /// Number of slices normal to y.
    pub slices: usize,
    /// [s] time between samples; `None`: chosen from the scene.
    pub sample_interval: Option<f64>,
}
