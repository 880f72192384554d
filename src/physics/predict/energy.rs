//! Checks of the time steps of soft spheres: the longest stable step, and the largest growth of energy that errors of
//! the steps can cause. A window is the time between two exchanges with the gas.

use super::contact::fastest_impact;
use super::integrator::{Method, Scheme, realised_restitution, stability_limit};
use super::springs::side_springs;
use crate::contact_law::{Bodies, ContactLaw, Spring};
use crate::encounter::{Couple, FrameTime};
use crate::engine::Failure;
use crate::exact;
use crate::experiment::{Experiment, Integrator, SoftStepping};
use crate::neighbours::overlapping;
use crate::particles::{Particles, Sample};
use crate::record::Record;
use crate::scene::{Scene, Species};
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};
use std::sync::OnceLock;

/// [-] growth of energy that counts as rounding, divided by the sum of all energies in the ledger (energy balance). It
/// corresponds to a million additions, each rounded at 1e-16 of the sum.
const ROUNDING: f64 = 1e-10;

/// [-] number of rounded coordinates on which an overlap depends: three coordinates of each of two bodies.
const ROUNDED: f64 = 6.0;

/// [-] smallest number of steps per contact N_c with which a contact is resolved. Fewer steps are refused, unless a
/// case allows them.
const FEWEST_STEPS: f64 = 5.0;

/// Kind of contact of a scene: between two species, or between a species and a wall.
struct PossibleContact {
    /// Index of the wall in the scene; `None` for a contact of two particles.
    wall: Option<usize>,
    /// Properties of the two bodies on which a contact law depends.
    bodies: Bodies,
}

fn contacts(scene: &Scene, particles: usize) -> Vec<PossibleContact> {
    scene.at_extremes().iter().flat_map(|scene| contacts_of(scene, particles)).collect()
}

/// Lists all kinds of contact in a scene with `particles` particles, in which every species has one size.
fn contacts_of(scene: &Scene, particles: usize) -> Vec<PossibleContact> {
    let pairs = scene.meetings().filter(|_| particles > 1);
    let pairs = pairs.map(|(one, other, _)| PossibleContact { wall: None, bodies: Bodies::between(scene, one, other) });
    let walls = scene
        .meetings_at_walls()
        .filter(|_| particles > 0)
        .map(|(one, wall, _)| PossibleContact { wall: Some(wall as usize), bodies: Bodies::beside(scene, one, wall) });
    pairs.chain(walls).collect()
}

/// Integration schemes that a run with the settings of `experiment` may use. Local stepping (steps only for particles
/// in contact) is replaced by uniform stepping (steps for all particles) if groups of particles that may meet become
/// too large.
fn schemes(experiment: &Experiment) -> Vec<Scheme> {
    let of = |stepping| Scheme::of(experiment.soft.integrator, stepping);
    match experiment.soft.stepping {
        SoftStepping::Auto | SoftStepping::Local => vec![of(SoftStepping::Uniform), of(SoftStepping::Local)],
        SoftStepping::Uniform => vec![of(SoftStepping::Uniform)],
    }
}

/// Failure if the time step `step` [s] exceeds the stability limit of its integration scheme; it names the contact
/// that exceeds the limit most. `None` if the step is stable. With Heun's method, which has no stable step for elastic
/// contacts (restitution 1), callers only warn.
pub fn too_long(experiment: &Experiment, particles: usize, step: f64) -> Option<Failure> {
    let (law, schemes, speed) = (experiment.law()?, schemes(experiment), fastest_impact(experiment));
    // stability limits require a search, so the result is stored for each restitution
    let mut limits: FxHashMap<u64, f64> = FxHashMap::default();
    let mut limit_of = |damping: f64| {
        let of_schemes = || schemes.iter().map(|scheme| stability_limit(scheme.method, damping));
        *limits.entry(damping.to_bits()).or_insert_with(|| of_schemes().fold(f64::INFINITY, f64::min))
    };
    let larger = |a: &(f64, f64), b: &(f64, f64)| (a.0 / a.1).total_cmp(&(b.0 / b.1));
    // of the normal, tangential, rolling and twisting springs of a contact, the one nearest to its limit counts
    let mut excess = |bodies: &Bodies| {
        let spring = law.between(bodies);
        let normal = (law.frequency(&spring, speed), law.damping_ratio(&spring, speed));
        let sides = side_springs(experiment, &law, bodies).into_iter();
        let springs = std::iter::once(normal).chain(sides.map(|side| (side.frequency, side.damping_ratio)));
        springs.map(|(frequency, damping)| (frequency * step, limit_of(damping))).max_by(larger)
    };
    let contacts = contacts(&experiment.scene, particles);
    let all = contacts.iter().filter_map(|contact| Some((contact.wall, excess(&contact.bodies)?)));
    let (wall, (reduced, limit)) = all.max_by(|(_, a), (_, b)| larger(a, b))?;
    let wall = wall.map(|wall| wall as u32);
    let unstable = step.is_finite() && reduced > limit;
    let limit = Some(limit).filter(|limit| *limit > 0.0);
    unstable.then_some(Failure::StepTooLong { time: 0.0, wall, step, reduced, limit })
}

/// Failure if a contact law of the calling program violates the contract (conditions on every contact law) for two
/// bodies of the scene. `None` if the law fulfils the contract, or if it is a law of this program.
pub fn broken_contract(experiment: &Experiment, particles: usize) -> Option<Failure> {
    let law = experiment.law().filter(|law| matches!(law, ContactLaw::Other(_)))?;
    let (speed, contacts) = (fastest_impact(experiment), contacts(&experiment.scene, particles));
    let broken = contacts.iter().find_map(|contact| law.check(&law.between(&contact.bodies), speed).err())?;
    Some(Failure::BrokenContract { law: law.to_string(), broken })
}

/// Largest growth of energy that can be due to the error of a time-stepping scheme.
///
/// The limit is the sum of these terms:
///
/// * A contact that has ended has returned at most g M u_n²/2 more energy than it received, with the largest gain g
///   (see below), the effective mass M and the normal speed u_n. Contacts in progress have returned at most g times the
///   present energy, plus their elastic energy. If bodies attract each other, each contact may return g times the
///   depth of the minimum of its stored energy in addition.
/// * The normal of a mesh may jump by Δn under a sphere. The force, at most ω_0 M u_n with the frequency ω_0 of the
///   contact, then has a wrong direction for up to one step Δt. At the speed u its work is wrong by |Δn| ω_0 M u_n u
///   Δt. With u about u_n this is s M u_n²/2 with s = 2 |Δn| ω_0 Δt.
/// * An overlap is a difference of coordinates. Coordinates are rounded at ε L, with the relative rounding error ε and
///   the edge L of the box. In each step the work of the force f is wrong by ε L f. Over all steps this gives ε L/Δt
///   times the impulse of all contacts, ∫f dt.
/// * Rounding of the energy balance (ledger) itself.
///
/// A larger growth cannot be due to isolated contacts.
///
/// Here g = e_max² - 1 is the largest gain, with e_max the largest restitution in simulated impacts. The phase of the
/// steps at the instant of touch is varied. Step lengths are also varied, so that N_c to N_c + 1 steps fit into the
/// contact. The reason is that a window (time between two exchanges with the gas) contains a whole number of steps,
/// which are therefore a little shorter than the longest. In two cases no impacts are simulated:
///
/// * Verlet on the step grid conserves v_(n+½)² + ω_0² q_n q_(n+1) for the overlap q and its rate v. Let a contact
///   begin and end at the fractions a and b of a step. The conserved quantity then changes by the factor (1 - a(1-a)
///   x²)/(1 - b(1-b) x²) with x = ω_0 Δt. So g is 1/(1 - x²/4) - 1 for a linear spring; damping only reduces it.
/// * For a step beyond the stability limit (Verlet), or with fewer than five steps in a contact (Heun), g is taken as
///   0.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Bound {
    /// Largest relative energy gains g = e² - 1 of all contacts, with the restitution e that time steps give (see
    /// [`Bound`]). Stored states do not contain them.
    #[serde(skip)]
    gains: Gains,
    /// [-] largest relative energy error s of an impact at a wall whose normal jumps, such as a mesh (see [`Bound`]).
    seams: f64,
    /// [kg] half of the largest effective mass M of two particles.
    pair: f64,
    /// [kg] half of the largest effective mass M of a particle at a wall.
    wall: f64,
    /// [m/s] energy [J] that rounding of coordinates may add, over the impulse of all contacts [kg m/s]. Coordinates
    /// are rounded once per step.
    rounding: f64,
    /// [m] diameter of the smallest particles of the scene.
    smallest: f64,
    /// [J] kinetic, rotational and elastic energy of all particles at the start.
    start: f64,
    /// [J] elastic energy of all contacts at the start.
    elastic_at_start: f64,
    /// Text for the error message. It names settings that shorten the time step.
    remedy: String,
}

impl Bound {
    /// Computes the largest energy growth for an experiment with the particles `start`, of which up to `count` touch.
    /// `step` [s] is the longest time step with which contacts are resolved. If no particles overlap, `start` may
    /// contain only the particles of one process. `None` without a contact law.
    pub fn new(experiment: &Experiment, (start, count): (&Sample, usize), step: f64) -> Option<Self> {
        let (law, speed) = (experiment.law()?, fastest_impact(experiment));
        let contacts = contacts(&experiment.scene, count);
        let heaviest = |wall: bool| {
            let of = contacts.iter().filter(|contact| contact.wall.is_some() == wall);
            of.map(|contact| 0.5 * contact.bodies.effective_mass).fold(0.0, f64::max)
        };
        let springs = contacts.iter().map(|contact| law.between(&contact.bodies)).collect();
        let schemes = [vec![Scheme::of(experiment.soft.integrator, SoftStepping::Local)], schemes(experiment)];
        // a sphere touches at most twelve spheres of its size
        let in_progress = 6.0 * count as f64;
        let contacts_of_law = Some((law, springs, [speed, step]));
        let gains = Gains { contacts: contacts_of_law, in_progress, schemes, largest: Default::default() };
        let seam = |contact: &PossibleContact| {
            let wall = contact.wall.map_or(0.0, |wall| experiment.scene.walls[wall].geometry.seam());
            2.0 * wall * law.frequency(&law.between(&contact.bodies), speed) * step
        };
        let seams = contacts.iter().map(seam).fold(0.0, f64::max);
        let elastic_at_start = elastic_energy(&law, &experiment.scene, start.particles);
        let start = start.kinetic_energy() + start.rotational_energy() + elastic_at_start;
        let smallest = experiment.scene.species.iter().map(Species::smallest).fold(f64::INFINITY, f64::min);
        let rounding = ROUNDED * f64::EPSILON * experiment.scene.domain.size.amax() / step;
        let remedy = remedy(experiment, &contacts, &law, step);
        Some(Self {
            gains,
            seams,
            pair: heaviest(false),
            wall: heaviest(true),
            rounding,
            smallest,
            start,
            elastic_at_start,
            remedy,
        })
    }

    /// Adds to this bound, which was read from a stored state, the data that are not stored. They are taken from
    /// `new`, the bound computed again for the same experiment. If `new` is `None`, nothing is added.
    pub fn completed(self, new: Option<Self>) -> Self {
        Self { gains: new.map_or(self.gains, |new| new.gains), ..self }
    }

    /// [J] elastic energy of the contacts that overlap at the start.
    pub fn elastic_at_start(&self) -> f64 {
        self.elastic_at_start
    }

    /// Checks that the energy has not grown by more than the bound. `energy` is kinetic, rotational and elastic energy
    /// together, and `elastic` its elastic part, both in J at the simulated time `time` [s]. `uniform` is true if time
    /// steps have moved all particles. An energy that is not a number passes this check, because other checks find it.
    ///
    /// # Errors
    /// Returns [`Failure::EnergyGrew`] if the energy has grown by more.
    pub fn check(&self, time: f64, uniform: bool, energy: f64, elastic: f64, record: &Record) -> Result<(), Failure> {
        let ledger = &record.ledger;
        let grown = energy - self.start - ledger.work();
        let at_walls = self.wall * record.walls.normal_speed.sum_of_squares();
        let ended = self.pair * record.pairs.normal_speed.sum_of_squares() + at_walls;
        let through = ledger.through(self.start) + ledger.dissipated();
        // the virial is the force times a distance of two radii
        let impulse = ledger.wall_normal_impulse + ledger.pair_virial.trace().abs() / self.smallest;
        let rounding = ROUNDING * through + self.rounding * impulse;
        let mut explained = self.seams * at_walls + self.elastic_at_start.abs() + elastic.abs() + rounding;
        if grown <= explained || grown.is_nan() {
            return Ok(());
        }
        // bodies that attract each other move faster in a contact than at its begin and end
        let impacts = (record.pairs.count + record.walls.count) as f64;
        let wells = self.gains.deepest_well() * (impacts + self.gains.in_progress);
        explained += self.gains.largest(uniform) * (ended + energy + wells);
        if grown <= explained {
            return Ok(());
        }
        Err(Failure::EnergyGrew { time, grown, explained, remedy: self.remedy.clone() })
    }
}

/// Largest relative energy gains g = e² - 1 of all contacts of a scene, with the restitution e that time steps give
/// (see [`Bound`]). They are computed when they are first needed, because this takes milliseconds, and runs that lose
/// energy do not need them.
#[derive(Clone, Debug, Default)]
struct Gains {
    /// Contact law, constants of all kinds of contacts, largest normal speed [m/s] of impacts, and longest time step
    /// [s]. `None` in a bound that was read from a stored state, which contains no gains.
    contacts: Option<(ContactLaw, Vec<Spring>, [f64; 2])>,
    /// Number of contacts that may be in progress at one time.
    in_progress: f64,
    /// Integration schemes of local stepping (time steps move only particles in contact), and of uniform stepping (time
    /// steps move all particles).
    schemes: [Vec<Scheme>; 2],
    /// [-] largest relative energy gains of all contacts: first in local stepping (time steps move only particles in
    /// contact), then in uniform stepping (time steps move all particles).
    largest: [OnceLock<f64>; 2],
}

impl Gains {
    /// [J] largest depth of the minimum of the energy that a contact stores; 0 if no bodies attract each other.
    fn deepest_well(&self) -> f64 {
        let contacts = self.contacts.iter();
        let depths = contacts.flat_map(|(law, springs, _)| springs.iter().map(|spring| law.well_depth(spring)));
        depths.fold(0.0, f64::max)
    }

    /// [-] largest relative energy gain of any contact: in uniform stepping (time steps move all particles) if
    /// `uniform` is true, otherwise in local stepping (time steps move only particles in contact).
    fn largest(&self, uniform: bool) -> f64 {
        let stepping = usize::from(uniform);
        let of = |scheme: &Scheme| {
            let contacts = self.contacts.iter();
            let gains =
                contacts.flat_map(|(law, springs, at)| springs.iter().map(|spring| gain(*scheme, law, spring, *at)));
            gains.fold(0.0, f64::max)
        };
        *self.largest[stepping].get_or_init(|| self.schemes[stepping].iter().map(of).fold(0.0, f64::max))
    }
}

/// Text for an error message. It names settings that at least halve the time step `step` [s], and an integrator that
/// does not increase the energy.
fn remedy(experiment: &Experiment, contacts: &[PossibleContact], law: &ContactLaw, step: f64) -> String {
    let speed = fastest_impact(experiment);
    let times = contacts.iter().map(|contact| law.contact_time(&law.between(&contact.bodies), speed));
    let steps = times.fold(f64::INFINITY, f64::min) / step;
    // 20 is the default number of steps per contact
    let more = f64::ceil(2.0 * steps).max(20.0);
    match experiment.soft.integrator {
        Integrator::VelocityVerlet => format!("soft.steps_per_contact = {more}"),
        Integrator::Rk2 => format!("soft.steps_per_contact = {more}, soft.integrator = \"velocity_verlet\""),
    }
}

/// [-] largest relative energy gain g = e² - 1 of an integration scheme (see [`Bound`]), with the largest restitution
/// e in impacts at the normal speed `speed` [m/s] with the time step `step` [s]. It is 0 for steps that do not resolve
/// the contact.
fn gain(scheme: Scheme, law: &ContactLaw, spring: &Spring, [speed, step]: [f64; 2]) -> f64 {
    /// Number of intervals into which the range from N_c to N_c + 1 steps per contact is divided.
    const LENGTHS: u32 = 8;
    /// Largest number of steps per contact N_c that is simulated. Shorter steps would gain less energy, and take long
    /// to simulate.
    const FINEST: f64 = 500.0;
    let steps = law.contact_time(spring, speed) / step;
    let reduced = law.frequency(spring, speed) * step;
    let resolved = match scheme.method {
        // exactly the fewest steps count as resolved, even if rounding has reduced their number
        Method::Heun => steps >= FEWEST_STEPS * (1.0 - 1e-9),
        Method::VelocityVerlet | Method::FourthOrder => {
            reduced <= stability_limit(scheme.method, law.damping_ratio(spring, speed))
        }
    };
    if !resolved {
        return 0.0;
    }
    if scheme.method == Method::VelocityVerlet && law.is_linear() {
        return 1.0 / (1.0 - 0.25 * reduced * reduced) - 1.0;
    }
    let lengths = (0..=LENGTHS).map(|k| steps.min(FINEST) + f64::from(k) / f64::from(LENGTHS));
    let realised = lengths.filter_map(|steps| realised_restitution(scheme, law, (spring, speed), steps));
    realised.map(|realised| realised.largest * realised.largest - 1.0).fold(0.0, f64::max)
}

/// [J] elastic energy stored in all overlaps of the particles with each other and with walls.
fn elastic_energy(law: &ContactLaw, scene: &Scene, particles: &Particles) -> f64 {
    let energy = |couple: Couple| {
        let overlap = couple.meet(particles, scene, FrameTime::default()).overlap();
        law.stored_energy(&law.between(&couple.bodies(particles, scene)), overlap)
    };
    let couples = overlapping(particles, scene);
    exact::sum(&couples, |couple| energy(*couple)).value()
}
