//! One variant of a case, checked and converted to SI units: all data that determine a simulation.

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
    /// Instantaneous collisions where two particles meet alone, spring-dashpot contacts elsewhere.
    Hybrid,
    /// Instantaneous collisions of pairs that are drawn at random in cells (direct simulation Monte Carlo).
    Dsmc,
}

impl Model {
    /// Name of the model in a case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Soft => "soft",
            Self::Hard => "hard",
            Self::Hybrid => "hybrid",
            Self::Dsmc => "dsmc",
        }
    }

    /// True if contacts of the model take time, so that it needs a contact law and a time step.
    pub fn has_contacts(self) -> bool {
        match self {
            Self::Soft | Self::Hybrid => true,
            Self::Hard | Self::Dsmc => false,
        }
    }
}

/// A collision model with its contact law, if it needs one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Spheres {
    /// Soft spheres, with this contact law between pairs and at walls.
    Soft(ContactLaw),
    /// Hard spheres.
    Hard,
    /// Hard spheres where two bodies touch with no third body near, and soft spheres with this contact law elsewhere.
    Hybrid(ContactLaw),
    /// Spheres that collide at random (direct simulation Monte Carlo).
    Dsmc,
}

/// Reference with which a variant is compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Reference {
    /// Another variant, by its name.
    Variant(String),
    /// A table of values, such as measurements.
    Table(ReferenceTable),
}

/// Table of values with which averages of a variant are compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReferenceTable {
    /// Name of the table in sentences.
    pub name: String,
    /// Values, in the order of the table.
    pub points: Vec<ReferencePoint>,
}

/// One value of a table in SI units, such as a velocity [m/s], with its error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReferencePoint {
    /// Name of the quantity: a column of `profiles.csv`, or an average over the whole scene.
    pub quantity: String,
    /// [m] distance y from the lower side of the domain; `None` for an average over the whole scene.
    pub y: Option<f64>,
    /// Value in the SI unit of the quantity.
    pub value: f64,
    /// Standard error in the SI unit of the quantity; `None` if the table states none.
    pub standard_error: Option<f64>,
}

/// All data that determine a simulation, in SI units.
#[derive(Clone, Debug, Serialize)]
pub struct Experiment {
    /// Name of the variant.
    pub name: String,
    /// Reference with which this variant is compared, if the case names one.
    pub against: Option<Reference>,
    /// Scene, which all engines read.
    pub scene: Scene,
    /// Initial state of the particles.
    pub start: Vec<Population>,
    /// Settings of the soft engine.
    pub soft: SoftSettings,
    /// Settings of the hard engine.
    pub hard: HardSettings,
    /// Additional settings of the hybrid engine, which also uses those of the soft engine.
    pub hybrid: HybridSettings,
    /// Settings of the engine in which pairs collide at random (DSMC).
    pub dsmc: DsmcSettings,
    /// Length, window, seed and collision model of the run.
    pub run: RunSettings,
    /// Settings of the averages.
    pub statistics: StatisticsSettings,
}

impl Experiment {
    /// Collision model of the run.
    pub fn model(&self) -> Model {
        match self.run.spheres {
            Spheres::Soft(_) => Model::Soft,
            Spheres::Hard => Model::Hard,
            Spheres::Hybrid(_) => Model::Hybrid,
            Spheres::Dsmc => Model::Dsmc,
        }
    }

    /// Contact law of the run; `None` for hard spheres and DSMC.
    pub fn law(&self) -> Option<ContactLaw> {
        match self.run.spheres {
            Spheres::Soft(law) | Spheres::Hybrid(law) => Some(law),
            Spheres::Hard | Spheres::Dsmc => None,
        }
    }

    /// Number of particles at the start.
    pub fn count(&self) -> usize {
        self.start.iter().map(|population| population.amount.count()).sum()
    }

    /// [-] volume of all particles at the start over the volume of the box; 0 if the drag law does not depend on it.
    pub fn fraction_for_drag(&self) -> f64 {
        let drag = self.scene.fluid.as_ref().and_then(|fluid| fluid.drag.as_ref());
        if drag.is_none_or(|drag| drag.law().cells().is_none()) {
            return 0.0;
        }
        let volumes = self.counts().into_iter().zip(&self.scene.species);
        volumes.map(|(count, species)| count as f64 * species.volume()).sum::<f64>() / self.scene.domain.volume()
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
    /// Index of the species in [`Scene::species`].
    pub species: u16,
    /// Number of particles, or particles with given positions.
    pub amount: Amount,
    /// Part of the domain that a random start fills; `None` for the whole domain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub region: Option<StartRegion>,
    /// [m/s] mean velocity of a random start. If there are two or more spheres, their mean is exact.
    pub velocity_mean: Vector3<f64>,
    /// [m/s] standard deviation of each velocity component of a random start. If there are two or more spheres, their
    /// deviation is exact. The velocity of a single sphere is drawn from a normal distribution with this deviation.
    pub velocity_fluctuation: Vector3<f64>,
    /// [rad/s] mean spin of a random start.
    #[serde(skip_serializing_if = "is_zero")]
    pub spin_mean: Vector3<f64>,
    /// [rad/s] standard deviation of each spin component of a random start.
    #[serde(skip_serializing_if = "is_none")]
    pub spin_fluctuation: f64,
}

/// True if the spin is zero, which is left out of a stored experiment.
fn is_zero(spin: &Vector3<f64>) -> bool {
    *spin == Vector3::zeros()
}

/// True if the deviation is zero, which is left out of a stored experiment.
fn is_none(deviation: &f64) -> bool {
    *deviation == 0.0
}

impl Population {
    /// [m/s] root mean square of the three velocity fluctuations of a random start.
    pub fn mean_fluctuation(&self) -> f64 {
        let v = self.velocity_fluctuation;
        // equal components are returned without the rounding error of a root
        if v.x == v.y && v.y == v.z { v.x } else { (v.norm_squared() / 3.0).sqrt() }
    }
}

/// Number of particles, or the particles themselves.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
#[allow(clippy::large_enum_variant, reason = "an experiment has few of these values")]
pub enum Amount {
    /// This number of particles, at random positions without overlap.
    Count(usize),
    /// The particles themselves, read from a file.
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

/// Settings of the soft engine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SoftSettings {
    /// Contact law of the case, for pairs and walls. A case that runs only with hard spheres may have none.
    pub law: Option<ContactLaw>,
    /// Choice of the time step.
    pub time_step: TimeStep,
    /// Particles that move in a time step.
    pub stepping: SoftStepping,
    /// The time integrator.
    pub integrator: Integrator,
    /// True if an unstable time step is allowed, with which energy may grow without limit.
    pub allow_unstable: bool,
}

/// Choice of the soft time step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TimeStep {
    /// [-] number of steps per contact N_c; the time step is Δt = (shortest contact time)/N_c.
    PerContact(f64),
    /// [s] time step Δt.
    Fixed(f64),
}

/// Particles that a time step of the soft engine moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "case", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum SoftStepping {
    /// Every particle at every time step.
    Uniform,
    /// Particles in contact only; all others fly straight.
    Local,
    /// Uniform or local stepping, whichever costs less.
    Auto,
}

/// Time integrator of the soft engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "case", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Integrator {
    /// Velocity Verlet, kick-drift-kick; the dashpot force depends on the velocity at half a step.
    VelocityVerlet,
    /// Heun's second-order Runge-Kutta method. The paper uses a scheme of this order for its fluid step, and names none
    /// for contacts.
    Rk2,
}

/// Settings of the hard engine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HardSettings {
    /// Method of finding collisions.
    pub stepping: HardStepping,
    /// [s] time t_c of the TC model: a collision is elastic if either particle has collided less than t_c before.
    /// `None`: no collision is made elastic.
    pub contact_time: Option<f64>,
}

/// Settings of the hybrid engine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HybridSettings {
    /// [-] clearance θ: a touch is an instantaneous collision if no other particle can come near within θ contact
    /// times.
    pub clearance: f64,
}

/// Settings of the engine in which pairs collide at random (DSMC).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DsmcSettings {
    /// True if the collision rate contains the Enskog factor, which is the contact value at the local volume fraction.
    pub enskog: bool,
    /// Numbers of cells along x, y and z; `None`: chosen from the mean free path and the number of particles.
    pub cells: Option<[usize; 3]>,
    /// [-] longest time step over the mean free time.
    pub step: f64,
}

impl Default for DsmcSettings {
    /// Returns settings with the Enskog factor, chosen cells, and steps of a fifth of the mean free time
    /// (docs/design/dsmc.md).
    fn default() -> Self {
        Self { enskog: true, cells: None, step: 0.2 }
    }
}

/// Method by which the hard engine finds collisions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum HardStepping {
    /// At the exact instants of touch, with an event queue.
    Events,
    /// At the ends of time steps Δt < θ d/u_r, from overlaps of particles (the paper's section 3.4).
    Steps {
        /// [-] step criterion θ: factor of d/u_r (diameter over mean speed of impact) in the limit of the time step.
        theta: f64,
    },
}

/// Length, window and seed of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunSettings {
    /// [s] time between instants at which all particles are written. Windows must also end at these instants.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instants: Option<f64>,
    /// Collision model of the run.
    pub spheres: Spheres,
    /// [s] simulated time.
    pub duration: f64,
    /// Beginning of the averaging period.
    pub average_from: AverageFrom,
    /// [s] window h; `None`: chosen from the scene.
    pub window: Option<f64>,
    /// Seed of the initial state.
    pub seed: u64,
}

/// Settings of the trajectory files, which contain all particles at regular instants.
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
    /// True if VTK files are to be written.
    pub fn is_vtp(self) -> bool {
        matches!(self, Self::Vtp | Self::Both)
    }

    /// True if extended XYZ files are to be written.
    pub fn is_xyz(self) -> bool {
        matches!(self, Self::Xyz | Self::Both)
    }
}

/// Beginning of the averaging period.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AverageFrom {
    /// [s] averaging begins at this simulated time.
    Time(f64),
    /// Averaging begins when the state is steady, as a test after the run finds.
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
