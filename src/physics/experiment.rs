//! An experiment: all data on which a simulation depends, checked and in SI units. A case (an input file) describes
//! one or more experiments, its variants, which differ in the collision model or in other settings.

mod defaults;
mod expected;
mod observe_settings;

pub use observe_settings::{
    ClustersSettings, DiffusionSettings, FieldsSettings, FreeSurfaceSettings, ObserveSettings,
    PairDistributionSettings, StructureFactorSettings, VelocityDistributionSettings, ViscositySettings,
};

use crate::contact_law::ContactLaw;
use crate::particles::Particles;
use crate::scene::{Scene, StartRegion, Surface};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// The name of a collision model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Model {
    /// Soft spheres: contacts of springs and dashpots, integrated in time steps.
    Soft,
    /// Hard spheres: instantaneous collisions.
    Hard,
    /// Hybrid spheres. Two bodies collide in an instant if no third body is near; otherwise they have a contact of
    /// springs and dashpots.
    Hybrid,
    /// Instantaneous collisions of pairs that are chosen at random in cells (direct simulation Monte Carlo).
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

    /// True if contacts of the model last for some time, so that a run needs a contact law and a time step.
    pub fn has_contacts(self) -> bool {
        match self {
            Self::Soft | Self::Hybrid => true,
            Self::Hard | Self::Dsmc => false,
        }
    }
}

/// A collision model with the data it requires.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Spheres {
    /// Soft spheres, with this contact law between pairs and at walls.
    Soft(ContactLaw),
    /// Hard spheres, which collide in an instant.
    Hard,
    /// Hybrid spheres: hard spheres where two bodies touch and no third body is near, otherwise soft spheres with this
    /// contact law.
    Hybrid(ContactLaw),
    /// Spheres whose collision pairs are chosen at random (direct simulation Monte Carlo).
    Dsmc,
}

/// Reference with which the results of a variant (one of the experiments in a case) are compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Reference {
    /// Another variant (experiment of the same case), by its name.
    Variant(String),
    /// A table of values, such as measurements.
    Table(ReferenceTable),
}

/// Table of values, such as measurements, with which averages of a variant (one of the experiments in a case) are
/// compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReferenceTable {
    /// Name of the table, as used in sentences of reports.
    pub name: String,
    /// Values of the table, in the order of its rows.
    pub points: Vec<ReferencePoint>,
}

/// One value of a table in SI units, such as a velocity [m/s] with its error.
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

/// All data on which a simulation depends, in SI units.
#[derive(Clone, Debug, Serialize)]
pub struct Experiment {
    /// Name of this experiment, which is one of the variants in a case; by default the name of its collision model.
    pub name: String,
    /// Reference with which the results of this experiment are compared; `None` if the case names none.
    pub against: Option<Reference>,
    /// Box, walls, gravity, gas and species, which every engine reads.
    pub scene: Scene,
    /// Initial state. Each population is a group of particles of one species, with given positions or at random
    /// positions.
    pub start: Vec<Population>,
    /// Settings of the soft engine.
    pub soft: SoftSettings,
    /// Settings of the hard engine.
    pub hard: HardSettings,
    /// Settings of the hybrid engine in addition to `soft`, whose settings this engine also uses.
    pub hybrid: HybridSettings,
    /// Settings of direct simulation Monte Carlo, in which collision pairs are chosen at random.
    pub dsmc: DsmcSettings,
    /// Duration, window (time between two exchanges with the gas), seed and collision model of the run.
    pub run: RunSettings,
    /// Settings of averages: the number of slices and the time between samples (instants of measurement).
    pub statistics: StatisticsSettings,
    /// Measurements that the case asks for in addition to the standard ones.
    #[serde(skip_serializing_if = "ObserveSettings::is_empty")]
    pub observe: ObserveSettings,
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

    /// Contact law of the run; `None` for models without lasting contacts (hard spheres, direct simulation Monte
    /// Carlo).
    pub fn law(&self) -> Option<ContactLaw> {
        match self.run.spheres {
            Spheres::Soft(law) | Spheres::Hybrid(law) => Some(law),
            Spheres::Hard | Spheres::Dsmc => None,
        }
    }

    /// Number of particles for predictions of contacts, such as the shortest contact time. It is at least `now`, the
    /// number of particles in the scene. With inlets it is at least 2, so that contacts between two particles are
    /// predicted even while the scene is empty. With outlets it is at least the number at the start, although
    /// particles may have left.
    pub fn most_that_touch(&self, now: usize) -> usize {
        let scene = &self.scene;
        let coming = if scene.inlets.is_empty() { 0 } else { 2 };
        let at_start = if scene.outlets.is_empty() { 0 } else { self.count() };
        now.max(coming).max(at_start)
    }

    /// Number of particles at the start.
    pub fn count(&self) -> usize {
        self.start.iter().map(|population| population.amount.count()).sum()
    }

    /// [-] volume fraction for the drag law: volume of all particles that are [expected](Self::expected_counts) in the
    /// box, over the volume of the box. It is 0 if the drag law does not depend on the volume fraction.
    pub fn fraction_for_drag(&self) -> f64 {
        let drag = self.scene.fluid.as_ref().and_then(|fluid| fluid.drag.as_ref());
        if drag.is_none_or(|drag| drag.law().cells().is_none()) {
            return 0.0;
        }
        let volumes = self.expected_counts().into_iter().zip(&self.scene.species);
        volumes.map(|(count, species)| count * species.volume()).sum::<f64>() / self.scene.domain.volume()
    }

    /// True if the particles form a gas in equilibrium: only collisions change their velocities, without loss and
    /// without friction, in a box that is periodic along all axes.
    pub fn is_in_equilibrium(&self) -> bool {
        let scene = &self.scene;
        let is_lossless =
            |surface: &Surface| surface.restitution == 1.0 && surface.friction == 0.0 && surface.by_speed.is_none();
        scene.is_homogeneous()
            && scene.gravity == Vector3::zeros()
            && !scene.is_heated()
            && !scene.has_openings()
            && scene.rotation.is_none()
            && scene.surfaces(2).iter().all(is_lossless)
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
    /// Index of the species of the particles in [`Scene::species`].
    pub species: u16,
    /// Number of particles that start at random positions, or particles with given positions.
    pub amount: Amount,
    /// Part of the domain in which a random start places the particles; `None` for the whole domain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub region: Option<StartRegion>,
    /// [m/s] mean velocity of the particles at a random start. The velocities of two or more particles have exactly
    /// this mean.
    pub velocity_mean: Vector3<f64>,
    /// [m/s] standard deviation of each velocity component of the particles at a random start. The velocities of two or
    /// more particles have exactly this deviation. The velocity of a single particle is random, with a normal
    /// distribution of this width about the mean.
    pub velocity_fluctuation: Vector3<f64>,
    /// [rad/s] mean spin of the particles at a random start.
    #[serde(skip_serializing_if = "is_zero")]
    pub spin_mean: Vector3<f64>,
    /// [rad/s] standard deviation of each spin component of the particles at a random start.
    #[serde(skip_serializing_if = "is_none")]
    pub spin_fluctuation: f64,
}

/// True if the mean spin [rad/s] is zero, so that a stored experiment need not contain it.
fn is_zero(spin: &Vector3<f64>) -> bool {
    *spin == Vector3::zeros()
}

/// True if the standard deviation of the spins [rad/s] is zero, so that a stored experiment need not contain it.
fn is_none(deviation: &f64) -> bool {
    *deviation == 0.0
}

impl Population {
    /// [m/s] root mean square, over the three components, of the velocity fluctuation of the particles at a random
    /// start.
    pub fn mean_fluctuation(&self) -> f64 {
        let v = self.velocity_fluctuation;
        // equal components are returned without the rounding of a root
        if v.x == v.y && v.y == v.z { v.x } else { (v.norm_squared() / 3.0).sqrt() }
    }
}

/// Number of particles that are placed at random, or particles with given positions.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
#[allow(clippy::large_enum_variant, reason = "an experiment has few of these values")]
pub enum Amount {
    /// This number of particles, at random positions without overlap.
    Count(usize),
    /// These particles, with positions given by a case, a file or a calling program.
    Placed(Particles),
}

impl Amount {
    /// Number of particles, at random or given positions.
    pub fn count(&self) -> usize {
        match self {
            Self::Count(count) => *count,
            Self::Placed(particles) => particles.len(),
        }
    }
}

/// Settings of the soft engine: contact law, time step and integrator.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SoftSettings {
    /// Contact law between particles and at walls, as given in the case. It may be `None` in a case without soft and
    /// hybrid spheres.
    pub law: Option<ContactLaw>,
    /// Choice of the time step Δt: by a number of steps per contact, or a given time.
    pub time_step: TimeStep,
    /// Choice of the particles that a time step moves: all of them, or only those in contact.
    pub stepping: SoftStepping,
    /// Time integrator of the soft engine: velocity Verlet or second-order Runge-Kutta.
    pub integrator: Integrator,
    /// True if a run with an unstable time step is allowed; energy may then grow without limit.
    pub allow_unstable: bool,
}

/// Choice of the time step Δt of soft spheres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TimeStep {
    /// [-] number N_c of time steps per contact: Δt is the shortest contact time over N_c.
    PerContact(f64),
    /// [s] time step Δt that the case gives.
    Fixed(f64),
}

/// Particles that a time step of the soft engine moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum SoftStepping {
    /// Every particle at every time step.
    Uniform,
    /// Particles in contact only; all other particles fly straight.
    Local,
    /// Uniform or local stepping, whichever takes less computing time.
    Auto,
}

/// Time integrator of the soft engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Integrator {
    /// Velocity Verlet: velocities change during half a step, then positions during a step, then velocities during
    /// half a step. The dashpot force depends on the velocity at half a step.
    VelocityVerlet,
    /// Heun's second-order Runge-Kutta method. The paper of `docs/paper.md` uses a scheme of this order for the gas,
    /// and names none for contacts.
    Rk2,
}

/// Settings of the hard engine: method by which it finds collisions, and contact time of the TC model (in which a
/// collision that soon follows another one is elastic).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HardSettings {
    /// Method by which the engine finds collisions: an event queue or time steps.
    pub stepping: HardStepping,
    /// [s] t_c of the TC model: a collision less than t_c after another collision of either particle is elastic. `None`
    /// if no collision is made elastic.
    pub contact_time: Option<f64>,
}

/// Settings of the hybrid engine, which uses instantaneous collisions where two bodies touch and no other body is near.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HybridSettings {
    /// [-] clearance θ. A touch of two bodies is an instantaneous collision if no other body can come near within θ
    /// contact times; otherwise it is a soft contact.
    pub clearance: f64,
}

/// Settings of direct simulation Monte Carlo, in which collision pairs are chosen at random in cells.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DsmcSettings {
    /// True if the collision rate is multiplied by the Enskog factor: the value of the pair distribution at contact,
    /// for the local volume fraction.
    pub enskog: bool,
    /// Numbers of cells along x, y and z; `None` if the program chooses them from the mean free path and the number of
    /// particles.
    pub cells: Option<[usize; 3]>,
    /// [-] ratio of the longest time step to the mean free time, the mean time between two collisions of a particle.
    pub step: f64,
}

/// Method by which the hard engine finds collisions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum HardStepping {
    /// Collisions happen at the exact instants of touch, which are stored in an event queue.
    Events,
    /// Search for collisions as overlaps at the ends of time steps Δt < θ d/u_r (section 3.4 of the paper, see
    /// `docs/paper.md`). d is the smallest diameter, and u_r the mean magnitude of the normal component of the relative
    /// velocity of two particles.
    Steps {
        /// [-] number θ in the bound Δt < θ d/u_r. Here d is the smallest diameter, and u_r the mean magnitude of the
        /// normal component of the relative velocity. With a smaller θ fewer collisions are missed.
        theta: f64,
    },
}

/// Duration, window (time between two exchanges with the gas), seed and collision model of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunSettings {
    /// [s] interval between instants at which all particles can be written to a file. A window (time between two
    /// exchanges with the gas) that contains such an instant is divided there. `None` if there are no such instants.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instants: Option<f64>,
    /// Collision model of the run.
    pub spheres: Spheres,
    /// [s] simulated time of the whole run.
    pub duration: f64,
    /// Beginning of the averaging period: a given time, or the steady state.
    pub average_from: AverageFrom,
    /// [s] length h of a window, the time between two exchanges with the gas; `None` if it is to be chosen from the
    /// scene.
    pub window: Option<f64>,
    /// Seed of the random numbers of the initial state and of the run.
    pub seed: u64,
}

/// Settings of trajectory files, which contain all particles at several instants.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Trajectories {
    /// [s] time between two instants at which the particles are written. The first interval begins at the start of the
    /// run.
    pub every: f64,
    /// File format of the trajectory files.
    pub format: TrajectoryFormat,
}

/// File format of trajectories.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum TrajectoryFormat {
    /// VTK PolyData, for ParaView.
    Vtp,
    /// Extended XYZ, for OVITO and ASE.
    Xyz,
    /// Both formats: one VTK file and one XYZ frame per instant.
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

/// Beginning of the averaging period: a given time, or the steady state.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AverageFrom {
    /// [s] averaging begins at this simulated time.
    Time(f64),
    /// Averaging begins where the steady part of the run begins; this instant is determined after the run.
    Steady,
}

/// Settings of averages over slices and time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StatisticsSettings {
    /// Number of slices, normal to y, in each of which averages are computed.
    pub slices: usize,
    /// [s] time between samples (instants of measurement); `None` if it is to be chosen from the scene.
    pub sample_interval: Option<f64>,
}
