//! Engines: each is one way to move spheres and to compute their collisions. An island is a group of particles that may
//! meet within a window, and that an engine solves separately.
//!
//! An [`Engine`] moves every particle through one window under gravity and impacts. A window is the time between two
//! exchanges of momentum with the gas. Drag is applied by the simulation before and after the window. Engines take no
//! samples. The engines for soft and hard spheres do not depend on other engines. The hybrid engine uses code of both.
//! The engine for collisions by chance (DSMC) uses the impacts of hard spheres. If several processes can share a run
//! with an engine, the engine also implements [`Distributed`](distributed::Distributed).

pub mod distributed;
pub mod driver;
pub mod dsmc;
pub mod hard;
pub mod hybrid;
mod islands;
mod motion;
mod population;
pub mod soft;

pub use crate::encounter::Partner;

use crate::clock::Clock;
use crate::contact_law::BrokenContract;
use crate::encounter::Couple;
use crate::neighbours::NeighbourList;
use crate::particles::Particles;
use crate::record::Record;
use crate::scene::Scene;
use crate::stored::{StoreError, Stored};
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// Window: interval of simulated time between two exchanges of momentum with the gas. An engine moves the particles
/// through one window at a time.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// [s] simulated time at the start of the window.
    pub start: f64,
    /// [s] length h of the window.
    pub duration: f64,
}

/// A way to move spheres and to compute their collisions.
///
/// ```
/// # extern crate diptych_physics as diptych;
/// use diptych::engine::{Engine, Window};
/// # use diptych::{Domain, Hard, Particles, Record, Scene, Species, Surface, Vector3};
/// # let domain = Domain::new(Vector3::repeat(10.0), [true; 3]);
/// # let scene = Scene {
/// #     gravity: Vector3::new(0.0, -9.81, 0.0),
/// #     ..Scene::new(domain, Surface::new(1.0, 0.0), vec![Species::new("sphere", 1.0, 1.0)])
/// # };
/// # let mut particles = Particles::default();
/// # particles.push(Vector3::repeat(5.0), Vector3::zeros(), 0.5, 1.0, 0);
/// let (mut engine, mut record) = (Hard::new(), Record::default());
/// engine.advance(&mut particles, &scene, Window { start: 0.0, duration: 0.1 }, &mut record)?;
/// assert!((particles.velocity[0].y + 0.981).abs() < 1e-12); // m/s: it fell for 0.1 s and met nothing
/// # Ok::<(), diptych::Failure>(())
/// ```
pub trait Engine: Send {
    /// Moves every particle through the window, the time between two exchanges of momentum with the gas. Only gravity
    /// and impacts act. Impacts, energies and impulses are added to `record`.
    ///
    /// # Errors
    /// A [`Failure`], with the numbers that describe it. `particles` then contains the state at the time of the
    /// failure, [`Failure::time`].
    fn advance(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        window: Window,
        record: &mut Record,
    ) -> Result<(), Failure>;

    /// Frees memory at the end of a run. A further window (time between two exchanges with the gas) would begin without
    /// the stored contacts or collisions. Counts of work and computing times are kept.
    fn forget(&mut self) {}

    /// Returns the work done so far: counts, which are the same on every machine, and wall-clock times. Only the tasks
    /// that engines have in common are timed. The rest of the computing time is spent on contacts and collisions.
    fn work_done(&self) -> (Counters, EngineTimes);

    /// Energy [J] that is now stored in the springs of soft contacts; contacts that attract may make it negative. The
    /// default is 0, for engines whose contacts are instantaneous.
    fn elastic_energy(&self) -> f64 {
        0.0
    }

    /// Energies [J] in the tangential, rolling and twisting springs of soft contacts, in this order. They are included
    /// in [`elastic_energy`](Self::elastic_energy). The default is 0.
    fn spring_energies(&self) -> [f64; 3] {
        [0.0; 3]
    }

    /// Calls `visit` with each pair of bodies (two particles, or a particle and a wall) in contact, given by indices.
    /// For soft spheres, these are the contacts that were in progress when the engine last tested the gaps. If contacts
    /// are instantaneous, `visit` is not called, which is the default.
    fn for_each_touching(&self, _visit: &mut dyn FnMut(Couple)) {}

    /// Indices of the particles that were members of islands (groups solved separately) at the end of the last time
    /// window. `None`, the default, if all particles were moved at once then.
    fn in_islands(&self) -> Option<&[u32]> {
        None
    }

    /// Sets the clock of the engine. The engine measures computing times with the clock, and reports to the clock the
    /// simulated time that it has reached within a long time window. Without a clock, no computing time is measured.
    fn use_clock(&mut self, clock: Clock);

    /// State of the engine between windows (times between two exchanges with the gas). An engine with the same settings
    /// continues from this state with bitwise equal results. The function may be called only between windows.
    ///
    /// # Errors
    /// The state cannot be stored.
    fn stored(&self) -> Result<Stored, StoreError>;

    /// Continues from the stored state of an engine with the same settings.
    ///
    /// # Errors
    /// The bytes are not the state of an engine of this type; this engine then remains unchanged.
    fn restore(&mut self, stored: &Stored) -> Result<(), StoreError>;

    /// Adapts the engine to a change of the population between two windows: particles have left or come in. `index_of`
    /// contains, for each index in the particle store before the change, the index after the change, or `None` for a
    /// particle that has left. Particles that have come in are at the end of the store. The engine keeps the contacts
    /// and collision histories of the particles that stay. Returns the energy [J] that was stored in contacts of the
    /// particles that have left.
    fn repopulate(&mut self, index_of: &[Option<u32>]) -> f64;
}

/// Overlap of two touching bodies, and the diameter to which it is compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// [m] depth δ of the overlap.
    pub depth: f64,
    /// [m] smaller of the diameters of the two bodies; at a wall the diameter of the particle.
    pub diameter: f64,
}

/// Wall-clock time spent on tasks that engines have in common.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct EngineTimes {
    /// Wall-clock time spent on the search for pairs that may touch.
    pub neighbours: Duration,
    /// Wall-clock time spent on the straight flight of all particles, if flight is a separate task.
    pub flight: Duration,
}

impl EngineTimes {
    /// Returns these times plus the time that was spent on building the neighbour list `list`.
    fn with_list(self, list: &NeighbourList) -> Self {
        Self { neighbours: self.neighbours + list.building(), ..self }
    }
}

/// Amounts of work done, as counts that do not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Counters {
    /// Number of time steps. A step of all particles counts as one (soft uniform steps, stepped hard spheres,
    /// collisions by chance). A step of a single island (group of particles that may meet) while its particles touch
    /// also counts as one (soft and hybrid spheres).
    pub steps: u64,
    /// Number of steps in which all particles were moved (soft spheres), included in `steps`. For hybrid spheres, the
    /// steps of crowds (large islands) are included too. An island is a group of particles that may meet. Depending on
    /// the settings and on the number of touching particles, soft spheres are moved instead by local steps of single
    /// islands.
    pub uniform_steps: u64,
    /// Number of candidates (two particles, or a particle and a wall) whose gap or time of touch was computed. For soft
    /// uniform steps, all candidates in the neighbour list are counted, also those that are skipped as too far apart.
    /// For collisions by chance, the randomly chosen pairs are counted.
    pub pair_checks: u64,
    /// Number of contact forces computed (soft and hybrid spheres).
    pub force_evaluations: u64,
    /// Number of impulses applied (hard and hybrid spheres, and collisions by chance).
    pub events: u64,
    /// Number of collisions that received no impulse (hard spheres in time steps), because the two spheres met and
    /// began to separate within the same step.
    pub missed_collisions: u64,
    /// Number of neighbour lists and cell grids built.
    pub neighbour_builds: u64,
    /// Number of islands (groups of particles that may meet) that were solved.
    pub islands: u64,
    /// Number of particles in all solved islands together (groups of particles that may meet).
    pub island_members: u64,
    /// Number of particles in the largest island (group of particles that may meet) of the run.
    pub largest_island: u64,
    /// Number of islands (groups of particles that may meet) that were solved again. Reasons are that a particle met an
    /// unexpected particle or exceeded the speed assumed for it, or that the island took too much computing time.
    pub islands_redone: u64,
}

/// Reason why an engine could not continue. Times are simulated times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum Failure {
    /// The overlap of a soft contact exceeds the limit: the stiffness is too low for this speed of impact.
    #[error(
        "at t = {time} s {}: raise soft stiffness",
        match (way, partner) {
            (Some(way), _) => format!(
                "the centre of particle {particle} passed through {partner} within one step, {way:.3} of its diameter long"
            ),
            (None, Partner::Particle(_)) => format!(
                "the overlap of particle {particle} with {partner} is {ratio:.3} of the smaller diameter of the two (limit {limit})"
            ),
            (None, Partner::Wall(_)) => {
                format!("the overlap of particle {particle} with {partner} is {ratio:.3} of its diameter (limit {limit})")
            }
        },
        time = nine(time)
    )]
    OverlapTooLarge {
        /// Time [s] of the failure.
        time: f64,
        /// Id of the particle whose overlap is too deep.
        particle: u32,
        /// The particle or wall that this particle overlaps.
        partner: Partner,
        /// [-] depth of the overlap, divided by the diameter (the smaller diameter of a pair).
        ratio: f64,
        /// [-] limit of the ratio of overlap to diameter.
        limit: f64,
        /// [-] path of the centre within the step, divided by the diameter, if the centre has passed through the
        /// surface of a wall in this step; otherwise `None`.
        way: Option<f64>,
    },
    /// The soft time step exceeds the stability limit of the integrator: the oscillation of a long contact would grow.
    #[error(
        "at t = {time} s the time step {step:.4e} s is too long for the contact {}: ω_0 Δt = {reduced:.3}, {}",
        wall.map_or("of two particles".to_string(), |wall| format!("with wall {wall}")),
        match limit {
            Some(limit) => format!("stable up to {limit:.3}; lower the step to {:.4e} s", step * limit / reduced),
            None => "and this integrator is stable at no step without damping".to_string(),
        },
        time = nine(time)
    )]
    StepTooLong {
        /// Time [s] of the failure.
        time: f64,
        /// Number of the wall of the contact; `None` for a contact of two particles.
        wall: Option<u32>,
        /// Time step Δt [s] that is too long.
        step: f64,
        /// [-] ω_0 Δt, the time step times the undamped angular frequency of the contact.
        reduced: f64,
        /// [-] largest stable ω_0 Δt for the restitution of that contact; `None` if no step is stable.
        limit: Option<f64>,
    },
    /// A contact law of the calling program violates a contract, a requirement on which engines rely.
    #[error("at t = 0 s the contact law cannot be used ({law}): {broken}")]
    BrokenContract {
        /// Name of the contact law that cannot be used.
        law: String,
        /// The contract that the law violates.
        broken: BrokenContract,
    },
    /// The sum of kinetic, rotational and elastic energy grew by more than the particles got from outside, plus the
    /// largest possible error of the time integrator. Sources outside are drag, gravity, walls, shear, a thermostat and
    /// particles that came in.
    #[error(
        "at t = {time} s the energy has grown by {grown:.3e} J beyond what the particles got from outside (drag, gravity, walls); the time integrator explains {explained:.3e} J: lower the time step ({remedy})",
        time = nine(time)
    )]
    EnergyGrew {
        /// Time [s] of the failure.
        time: f64,
        /// Growth [J] of the energy beyond what the particles got from outside.
        grown: f64,
        /// Part of this growth [J] that can be due to the error of the time integrator.
        explained: f64,
        /// Settings that shorten the time step of this case.
        remedy: String,
    },
    /// Inelastic collapse. Impacts accumulate, for instance when a sphere comes to rest, and the intervals between them
    /// become too short to resolve.
    #[error(
        "inelastic collapse at t = {time} s: particle {particle} collided {impacts} times within one window, the last time with {partner} after {interval:.1e} s, at ({x:.6e}, {y:.6e}, {z:.6e}) m; {}: {}, or use the hybrid or the soft model",
        sliding.map_or(
            "hard spheres cannot rest".to_string(),
            |speed| format!("it slides along the curved wall at {speed:.3} m/s, which for hard spheres that lose energy takes infinitely many impacts"),
        ),
        contact_time.map_or(
            "make collisions elastic that come sooner than a contact lasts, hard.contact_time = \"1e-6 s\" or more".to_string(),
            |time| format!("hard.contact_time = {time:e} s is too short here, make it longer"),
        ),
        time = nine(time)
    )]
    InelasticCollapse {
        /// Time [s] of the failure.
        time: f64,
        /// Id of the particle that collides too often.
        particle: u32,
        /// The particle or wall with which `particle` collides repeatedly.
        partner: Partner,
        /// Number of impacts of that particle since the start of the time window. If islands (groups solved separately)
        /// moved the particle first, impacts are counted from the instant at which the islands were given up.
        impacts: u64,
        /// Time [s] between the last two impacts of that particle.
        interval: f64,
        /// Contact time t_c [s] of the TC model, in which a collision is elastic if the particle collided less than t_c
        /// before; `None` if this model is not used.
        contact_time: Option<f64>,
        /// Speed [m/s] at which the particle slides along a curved wall, if this is the reason for its many impacts;
        /// otherwise `None`.
        sliding: Option<f64>,
        /// Coordinate x [m] of the particle.
        x: f64,
        /// Coordinate y [m] of the particle.
        y: f64,
        /// Coordinate z [m] of the particle.
        z: f64,
    },
    /// A particle has infinitely many impacts on a wall in a model in which particles cannot rest (collisions by
    /// chance).
    #[error(
        "at t = {time} s particle {particle} comes to rest on {partner}, or slides along it, at ({x:.6e}, {y:.6e}, {z:.6e}) m: {impacts} impacts in one step, the last after {interval:.1e} s; a gas that collides by chance knows no rest, use the hybrid or the soft model",
        time = nine(time)
    )]
    RestOnWall {
        /// Time [s] of the failure: the end of the step in which the particle came to rest.
        time: f64,
        /// Id of the particle.
        particle: u32,
        /// The wall on which the particle rests.
        partner: Partner,
        /// Number of impacts of the particle within the step.
        impacts: u32,
        /// Time [s] between the last two impacts of the particle.
        interval: f64,
        /// Coordinate x [m] of the particle.
        x: f64,
        /// Coordinate y [m] of the particle.
        y: f64,
        /// Coordinate z [m] of the particle.
        z: f64,
    },
    /// A particle left the domain through a side that is not periodic.
    #[error("at t = {time} s particle {particle} is outside the domain, at ({x:.6e}, {y:.6e}, {z:.6e}) m", time = nine(time))]
    Escaped {
        /// Time [s] of the failure.
        time: f64,
        /// Id of the particle that left the domain.
        particle: u32,
        /// Coordinate x [m] of the particle.
        x: f64,
        /// Coordinate y [m] of the particle.
        y: f64,
        /// Coordinate z [m] of the particle.
        z: f64,
    },
    /// The flow of a gas that the particles change (two-way coupling) has no finite solution.
    #[error("at t = {time} s the flow of the gas broke down ({why}): use a shorter `run.window`, or a larger pressure gradient", time = nine(time))]
    Gas {
        /// Time [s] of the failure.
        time: f64,
        /// Reason, in words, why the flow has no finite solution.
        why: String,
    },
    /// A signal from outside stopped the run; no error occurred.
    #[error("at t = {time} s it was stopped from outside (Ctrl-C or a signal to end); this is a part of the run", time = nine(time))]
    Stopped {
        /// Time [s] at which the run stopped.
        time: f64,
    },
    /// Output of the run could not be written.
    #[error("at t = {time} s the run was stopped: {why}", time = nine(time))]
    Unwritten {
        /// Time [s] of the failure.
        time: f64,
        /// The output that failed, its location, and the message of the operating system.
        why: String,
    },
    /// A position or velocity, or the square of a speed, is no longer a finite number.
    #[error(
        "at t = {time} s the position or velocity of particle {particle} is not a number, or too large to compute with",
        time = nine(time)
    )]
    NotANumber {
        /// Time [s] of the failure.
        time: f64,
        /// Id of the particle whose position or velocity is not a number.
        particle: u32,
    },
}

/// Time [s] for messages, rounded to nine significant digits. Further digits contain rounding errors, because the time
/// is a sum of many time windows.
fn nine(time: &f64) -> f64 {
    format!("{time:.8e}").parse().unwrap_or(*time)
}

impl Failure {
    /// Type of the failure as one word, used in tables and JSON.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::OverlapTooLarge { .. } => "overlap_too_large",
            Self::StepTooLong { .. } => "step_too_long",
            Self::BrokenContract { .. } => "broken_contract",
            Self::EnergyGrew { .. } => "energy_grew",
            Self::InelasticCollapse { .. } => "inelastic_collapse",
            Self::RestOnWall { .. } => "rest_on_wall",
            Self::Escaped { .. } => "escaped",
            Self::Gas { .. } => "gas",
            Self::NotANumber { .. } => "not_a_number",
            Self::Stopped { .. } => "stopped",
            Self::Unwritten { .. } => "unwritten",
        }
    }

    /// Simulated time [s] of the failure.
    pub fn time(&self) -> f64 {
        match self {
            // a broken contract is found when the simulation is set up
            Self::BrokenContract { .. } => 0.0,
            Self::OverlapTooLarge { time, .. }
            | Self::StepTooLong { time, .. }
            | Self::EnergyGrew { time, .. }
            | Self::InelasticCollapse { time, .. }
            | Self::RestOnWall { time, .. }
            | Self::Escaped { time, .. }
            | Self::Gas { time, .. }
            | Self::Stopped { time }
            | Self::Unwritten { time, .. }
            | Self::NotANumber { time, .. } => *time,
        }
    }
}

/// Largest absolute component [m/s] of the velocity of the particle at `index`; 0 if there is no such particle.
/// This value may be finite although the square of the speed is not.
fn speed(particles: &Particles, index: usize) -> f64 {
    particles.velocity.get(index).map_or(0.0, |velocity| velocity.amax())
}

/// Makes the failure that names the first particle, in the order of the particle store, whose position or velocity is
/// not a finite number. If all positions and velocities are finite, it names the fastest particle. `time` [s] is the
/// simulated time.
fn not_a_number(particles: &Particles, time: f64) -> Failure {
    let bad = particles
        .position
        .iter()
        .zip(&particles.velocity)
        .position(|(x, v)| !(x.iter().chain(v.iter()).all(|value| value.is_finite())));
    // if all numbers are finite, the square of the largest speed is not, so the fastest particle is named
    let fastest = || (0..particles.len()).max_by(|a, b| speed(particles, *a).total_cmp(&speed(particles, *b)));
    let index = bad.or_else(fastest).unwrap_or_default();
    Failure::NotANumber { time, particle: particles.id.get(index).copied().unwrap_or_default() }
}
