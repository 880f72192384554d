//! How do spheres answer a touch?
//!
//! An [`Engine`] moves every particle through one window under gravity and impacts. It knows nothing of drag (the
//! simulation kicks before and after), of sampling, or of the other engine.

pub mod driver;
pub mod hard;
pub mod hybrid;
mod islands;
mod motion;
mod population;
pub mod soft;

pub use crate::encounter::Partner;

use crate::clock::Clock;
use crate::communicator::Communicator;
use crate::contact_law::BrokenContract;
use crate::encounter::Couple;
use crate::neighbours::NeighbourList;
use crate::particles::{Particles, Sample};
use crate::record::Record;
use crate::scene::Scene;
use crate::stored::{StoreError, Stored};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Duration;

/// A stretch of time to be moved through.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// [s] simulated time at its start.
    pub start: f64,
    /// [s] length h.
    pub duration: f64,
}

/// A collision model.
///
/// ```
/// use diptych::engine::{Engine, Window};
/// # use diptych::{Domain, Hard, Particles, Record, Scene, Species, Surface, Vector3};
/// # let scene = Scene {
/// #     domain: Domain::new(Vector3::repeat(10.0), [true; 3]),
/// #     gravity: Vector3::new(0.0, -9.81, 0.0),
/// #     fluid: None,
/// #     walls: Vec::new(),
/// #     contact: Surface { restitution: 1.0, friction: 0.0 },
/// #     pairs: Default::default(),
/// #     species: vec![Species { name: "sphere".into(), diameter: 1.0, density: 1.0, elasticity: None, sizes: None }],
/// # };
/// # let mut particles = Particles::default();
/// # particles.push(Vector3::repeat(5.0), Vector3::zeros(), 0.5, 1.0, 0);
/// let (mut engine, mut record) = (Hard::new(), Record::default());
/// engine.advance(&mut particles, &scene, Window { start: 0.0, duration: 0.1 }, &mut record)?;
/// assert!((particles.velocity[0].y + 0.981).abs() < 1e-12); // m/s: it fell for 0.1 s and met nothing
/// # Ok::<(), diptych::Failure>(())
/// ```
pub trait Engine {
    /// Moves every particle through the window: gravity and impacts, nothing else. What happened is told to `record`.
    ///
    /// # Errors
    /// A [`Failure`] with numbers; the store then holds the state at which it was seen, at [`Failure::time`].
    fn advance(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        window: Window,
        record: &mut Record,
    ) -> Result<(), Failure>;

    /// Shares the run with other processes, whose engines are called in the same way: while it pays, each then has the particles of a domain
    /// of its own, and the lead has all of them otherwise. An engine that cannot leaves all of the work to the lead. The particles are those of the blocks
    /// of each process among [blocks of one size](crate::domain::blocks::Blocks::of_one_size) if others have a part of the sample; otherwise the
    /// lead has all, and only what it has matters until they are first cut into domains.
    fn share(&mut self, _communicator: Arc<dyn Communicator>, _sample: &Sample, _scene: &Scene) {}

    /// Whether each process has the particles of a domain of its own, and nothing else.
    fn is_cut(&self) -> bool {
        false
    }

    /// Cuts the run anew, from the next window on, if a process has many more of the particles than others; all processes must call it, between two windows.
    fn balance(&mut self, _particles: &Particles, _scene: &Scene) {}

    /// Shows the lead copies of every so manieth particle by id (1: all) and of those in contact with them, in place of its own; all processes must call it, between two
    /// windows.
    fn show(&mut self, _particles: &mut Particles, _scene: &Scene, _every: u32) {}

    /// Whether all that lasts can be [`packed`](Self::packed) in parts now; otherwise the lead has to be shown all particles for it.
    fn gives_parts(&self) -> bool {
        self.is_cut()
    }

    /// While the run is cut: the particles of this process and what lasts of them as bytes, for [`take_parts`](Self::take_parts).
    fn packed(&self, _particles: &Particles) -> Vec<u8> {
        Vec::new()
    }

    /// Takes the place of all particles and of what lasts: so many parts that processes have [`packed`](Self::packed), of which `next` gives one after the
    /// other to the lead, or to whoever is alone. All processes must call it.
    fn take_parts(
        &mut self,
        _particles: &mut Particles,
        _scene: &Scene,
        _count: usize,
        _next: &mut dyn FnMut(usize) -> Vec<u8>,
    ) {
    }

    /// Gives the lead its own particles back, to go on with.
    fn hide(&mut self, _particles: &mut Particles) {}

    /// The run is over: gives back memory that nothing but a further window would need, which then begins anew. Counts and times stay.
    fn forget(&mut self) {}

    /// What has been done so far: the same on every machine.
    fn counters(&self) -> Counters;

    /// [J] energy stored in contacts now (soft: springs); 0 where contacts do not last. While the run is cut, that of all processes, which must all ask.
    fn elastic_energy(&self) -> f64;

    /// Shows who is in contact now, by place in the store (soft: contacts in progress, as last looked at); nobody where contacts do
    /// not last.
    fn for_each_touching(&self, visit: &mut dyn FnMut(Couple));

    /// Contacts in progress between a particle of this process, at that place in the store, and one of another: each of the two has it.
    fn touching_abroad(&self) -> Vec<(u32, Overlap)> {
        Vec::new()
    }

    /// Places of the particles that islands moved last; `None` where all were moved at once by the classical algorithm.
    fn in_islands(&self) -> Option<&[u32]>;

    /// Lends the engine a clock for [`spent`](Self::spent), to be told within long windows where the engine is; without one it
    /// measures no time.
    fn use_clock(&mut self, clock: Clock);

    /// Time so far, by the clock lent, of the parts that are common to engines; the rest is contacts and collisions.
    fn spent(&self) -> EngineTimes;

    /// What lasts from one window to the next: all that an engine with the same settings needs to go on with the same bits. Between
    /// windows only.
    ///
    /// # Errors
    /// What lasts cannot be stored.
    fn stored(&self) -> Result<Stored, StoreError>;

    /// Goes on from what an engine with the same settings has stored.
    ///
    /// # Errors
    /// The bytes are not of such an engine; it is then as it was.
    fn restore(&mut self, stored: &Stored) -> Result<(), StoreError>;
}

/// How far two particles overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// [m] depth δ.
    pub depth: f64,
    /// [m] the smaller of the two diameters.
    pub diameter: f64,
}

/// Wall-clock time by part of an engine's work.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct EngineTimes {
    /// Looking for who may meet whom.
    pub neighbours: Duration,
    /// Straight flight of all, where it is a part of its own.
    pub flight: Duration,
}

impl EngineTimes {
    /// The same with what a neighbour list took.
    fn with_list(self, list: &NeighbourList) -> Self {
        Self { neighbours: self.neighbours + list.building(), ..self }
    }
}

/// Work done, in counts that do not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Counters {
    /// Time steps of all particles (soft uniform, stepped hard) or of islands in contact (soft local).
    pub steps: u64,
    /// Those of them that were steps of all particles (soft): local stepping comes to them where too many touch.
    pub uniform_steps: u64,
    /// Pairs and wall candidates whose gap or touch time was computed (soft uniform: those in the list, though most are known to be too far apart).
    pub pair_checks: u64,
    /// Contact forces computed (soft).
    pub force_evaluations: u64,
    /// Impulses applied (hard).
    pub events: u64,
    /// Collisions whose spheres were separating again at the next look (stepped hard): no impulse.
    pub missed_collisions: u64,
    /// Neighbour lists and cell grids built.
    pub neighbour_builds: u64,
    /// Islands solved.
    pub islands: u64,
    /// Particles in them, summed.
    pub island_members: u64,
    /// Particles of the largest.
    pub largest_island: u64,
    /// Islands done again because something in them met what was not expected.
    pub islands_redone: u64,
}

/// Why an engine could not go on. Times are simulated times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum Failure {
    /// A soft contact is deeper than the limit: stiffness too low for this speed.
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
        /// [s] when.
        time: f64,
        /// Id.
        particle: u32,
        /// The particle or wall that it overlaps.
        partner: Partner,
        /// [-] overlap over the (smaller) diameter.
        ratio: f64,
        /// [-] the limit it passed.
        limit: f64,
        /// [-] way of the centre within the step over the diameter, where it passed through the surface of a wall between two looks.
        way: Option<f64>,
    },
    /// The soft time step is beyond the scheme's stability: any contact that lasts would swing ever wider.
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
        /// [s] when.
        time: f64,
        /// The wall whose contact is meant; `None`: that of two particles of the lightest kind.
        wall: Option<u32>,
        /// [s] time step Δt.
        step: f64,
        /// [-] ω_0 Δt.
        reduced: f64,
        /// [-] the largest that is stable at the restitution of that contact; `None`: none is.
        limit: Option<f64>,
    },
    /// A contact law of the caller's breaks a contract that engines rely on.
    #[error("at t = 0 s the contact law cannot be used ({law}): {broken}")]
    BrokenContract {
        /// The law in words.
        law: String,
        /// The contract.
        broken: BrokenContract,
    },
    /// Kinetic and elastic energy grew by more than drag and gravity put in and the time integrator may add.
    #[error(
        "at t = {time} s the energy has grown by {grown:.3e} J beyond what drag and gravity put in; the time integrator explains {explained:.3e} J: lower the time step ({remedy})",
        time = nine(time)
    )]
    EnergyGrew {
        /// [s] when.
        time: f64,
        /// [J] growth beyond the work of drag and gravity.
        grown: f64,
        /// [J] the part of it that the scheme explains.
        explained: f64,
        /// Settings that lower the step of this case.
        remedy: String,
    },
    /// Impacts pile up (a Zeno series, or coming to rest): each comes sooner after the one before, at last sooner than the
    /// clock can tell.
    #[error(
        "inelastic collapse at t = {time} s: particle {particle}, which now meets {partner}, met others {impacts} times within one window, the last time after {interval:.1e} s, at ({x:.6e}, {y:.6e}, {z:.6e}) m; {}: {}, or use the hybrid or the soft model",
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
        /// [s] when.
        time: f64,
        /// Id.
        particle: u32,
        /// The particle or wall that it keeps meeting.
        partner: Partner,
        /// Impacts of that particle within the window.
        impacts: u64,
        /// [s] between the last two.
        interval: f64,
        /// [s] t_c of the TC model, if it was asked for.
        contact_time: Option<f64>,
        /// [m/s] at which it slides along a curved wall, if that is why its impacts pile up.
        sliding: Option<f64>,
        /// [m] where, x.
        x: f64,
        /// [m] where, y.
        y: f64,
        /// [m] where, z.
        z: f64,
    },
    /// A particle left the domain through a side that is not periodic.
    #[error("at t = {time} s particle {particle} is outside the domain, at ({x:.6e}, {y:.6e}, {z:.6e}) m", time = nine(time))]
    Escaped {
        /// [s] when.
        time: f64,
        /// Id.
        particle: u32,
        /// [m] where, x.
        x: f64,
        /// [m] where, y.
        y: f64,
        /// [m] where, z.
        z: f64,
    },
    /// The run was told to stop; nothing is wrong with it.
    #[error("at t = {time} s it was stopped from outside (Ctrl-C or a signal to end); this is a part of the run", time = nine(time))]
    Stopped {
        /// [s] when.
        time: f64,
    },
    /// What a run writes on its way could not be written.
    #[error("at t = {time} s the run was stopped: {why}", time = nine(time))]
    Unwritten {
        /// [s] when.
        time: f64,
        /// What could not be written, where, and what the system says.
        why: String,
    },
    /// A position or velocity is no longer a number, or its square is not.
    #[error(
        "at t = {time} s the position or velocity of particle {particle} is not a number, or too large to compute with",
        time = nine(time)
    )]
    NotANumber {
        /// [s] when.
        time: f64,
        /// Id.
        particle: u32,
    },
}

/// [s] a time for messages, without the digits that adding up windows leaves at its end.
fn nine(time: &f64) -> f64 {
    format!("{time:.8e}").parse().unwrap_or(*time)
}

impl Failure {
    /// Its type as one word, as it stands in tables and JSON.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::OverlapTooLarge { .. } => "overlap_too_large",
            Self::StepTooLong { .. } => "step_too_long",
            Self::BrokenContract { .. } => "broken_contract",
            Self::EnergyGrew { .. } => "energy_grew",
            Self::InelasticCollapse { .. } => "inelastic_collapse",
            Self::Escaped { .. } => "escaped",
            Self::NotANumber { .. } => "not_a_number",
            Self::Stopped { .. } => "stopped",
            Self::Unwritten { .. } => "unwritten",
        }
    }

    /// [s] simulated time at which it was seen.
    pub fn time(&self) -> f64 {
        match self {
            // seen when the simulation is made
            Self::BrokenContract { .. } => 0.0,
            Self::OverlapTooLarge { time, .. }
            | Self::StepTooLong { time, .. }
            | Self::EnergyGrew { time, .. }
            | Self::InelasticCollapse { time, .. }
            | Self::Escaped { time, .. }
            | Self::Stopped { time }
            | Self::Unwritten { time, .. }
            | Self::NotANumber { time, .. } => *time,
        }
    }
}

/// [m/s] the largest component of a velocity, which can be squared or not.
fn speed(particles: &Particles, place: usize) -> f64 {
    particles.velocity.get(place).map_or(0.0, |velocity| velocity.amax())
}

/// The failure for the first particle, in the store's order, whose position or velocity is not a number, or else for the
/// fastest.
fn not_a_number(particles: &Particles, time: f64) -> Failure {
    let bad = particles
        .position
        .iter()
        .zip(&particles.velocity)
        .position(|(x, v)| !(x.iter().chain(v.iter()).all(|value| value.is_finite())));
    // where all are numbers the square of a speed is not: that of the fastest
    let fastest = || (0..particles.len()).max_by(|a, b| speed(particles, *a).total_cmp(&speed(particles, *b)));
    let place = bad.or_else(fastest).unwrap_or_default();
    Failure::NotANumber { time, particle: particles.id.get(place).copied().unwrap_or_default() }
}
