//! What may a soft time step do to the energy of a scene, and which step is too long for it?

use super::integrator::{Method, Scheme, realised_restitution, reduced_step, stability_limit};
use crate::engine::Failure;
use crate::engine::soft::LinearSpringDashpot;
use crate::experiment::{Experiment, Integrator, SoftStepping};
use crate::neighbours::NeighbourList;
use crate::particles::Particles;
use crate::record::Record;
use crate::scene::Scene;

/// [-] share of the energy that went through the ledger below which a growth is rounding: a million additions, each
/// rounded at 1e-16 of the sum.
const ROUNDING: f64 = 1e-10;

/// [-] N_c from which a contact counts as resolved: fewer are refused unless a case allows them.
const FEWEST_STEPS: f64 = 5.0;

/// One kind of contact that a scene can have.
struct Contact {
    /// Of two particles, or with that wall.
    wall: Option<usize>,
    /// [-] e.
    restitution: f64,
    /// [kg] M of the lightest: the stiffest contact.
    least_mass: f64,
    /// [kg] M of the heaviest.
    largest_mass: f64,
}

fn contacts(scene: &Scene, particles: usize) -> Vec<Contact> {
    let masses = || scene.species.iter().map(|species| species.mass());
    let (least, most) = (masses().fold(f64::INFINITY, f64::min), masses().fold(0.0, f64::max));
    let pair = Contact {
        wall: None,
        restitution: scene.contact.restitution,
        least_mass: 0.5 * least,
        largest_mass: 0.5 * most,
    };
    let walls = scene.walls.iter().enumerate().map(|(index, wall)| Contact {
        wall: Some(index),
        restitution: wall.surface.restitution,
        least_mass: least,
        largest_mass: most,
    });
    let count = if particles > 1 { 1 } else { 0 };
    let walls = walls.take(if particles > 0 { usize::MAX } else { 0 });
    std::iter::once(pair).take(count).chain(walls).collect()
}

/// The schemes that these settings may come to: where islands would grow too large, local stepping is uniform stepping.
fn schemes(experiment: &Experiment) -> Vec<Scheme> {
    let of = |stepping| Scheme::of(experiment.soft.integrator, stepping);
    match experiment.soft.stepping {
        SoftStepping::Auto | SoftStepping::Local => vec![of(SoftStepping::Uniform), of(SoftStepping::Local)],
        SoftStepping::Uniform => vec![of(SoftStepping::Uniform)],
    }
}

/// The failure of a time step [s] beyond the stability limit of its scheme, in the contact that is furthest beyond; `None`
/// if it is stable. Heun's method has no stable step at e = 1 and is kept to show it: its failure is one to warn of.
pub fn too_long(experiment: &Experiment, particles: usize, step: f64) -> Option<Failure> {
    let law = LinearSpringDashpot { stiffness: experiment.soft.stiffness? };
    let schemes = schemes(experiment);
    let excess = |contact: &Contact| {
        let reduced = law.angular_frequency(contact.least_mass) * step;
        let limits = schemes.iter().map(|scheme| stability_limit(scheme.method, contact.restitution));
        (reduced, limits.fold(f64::INFINITY, f64::min))
    };
    let contacts = contacts(&experiment.scene, particles);
    let all = contacts.iter().map(|contact| (contact.wall, excess(contact)));
    let (wall, (reduced, limit)) = all.max_by(|(_, a), (_, b)| (a.0 / a.1).total_cmp(&(b.0 / b.1)))?;
    let wall = wall.map(|wall| wall as u32);
    (step.is_finite() && reduced > limit).then_some(Failure::StepTooLong { time: 0.0, wall, step, reduced, limit })
}

/// How far the energy of a scene may grow by the scheme's own doing.
///
/// A contact that has ended gave back at most g of M u_n²/2 more than it took; contacts in progress at most g of all the
/// energy there is, and what they hold as elastic energy. What grows beyond their sum (and rounding), no isolated contact
/// explains. g, with x = ω_0 Δt:
///
/// * Verlet on the step grid conserves v_(n+½)² + ω_0² q_n q_(n+1), so one that enters and leaves a contact a fraction s and s' of a
///   step after the touch changes by (1 - s(1-s) x²)/(1 - s'(1-s') x²): g = 1/(1 - x²/4) - 1; damping only takes from it.
/// * Heun's method: e_max² - 1, the largest of the linear map over all phases of the touch, and over steps that fit N_c to N_c + 1
///   times: a window holds whole steps, which are a little shorter than the longest.
/// * Local stepping of fourth order: the same, which is nothing.
/// * A step beyond stability (Verlet), or of fewer than five in a contact (Heun), explains nothing.
#[derive(Clone, Debug)]
pub struct Bound {
    /// [-] g of pairs and walls, the largest, of contacts that are stepped where they are.
    local: f64,
    /// [-] the same once all particles have been stepped.
    uniform: f64,
    /// [kg] M/2 of the heaviest pair.
    pair: f64,
    /// [kg] M/2 of the heaviest particle at a wall.
    wall: f64,
    /// [J] kinetic and elastic energy at the start.
    start: f64,
    /// [J] the elastic part of it.
    elastic_at_start: f64,
    /// Settings that lower the step.
    remedy: String,
}

impl Bound {
    /// The bound of an experiment that starts like this; `step` [s] is the longest that contacts are resolved with.
    pub fn new(experiment: &Experiment, start: &Particles, step: f64) -> Option<Self> {
        let law = LinearSpringDashpot { stiffness: experiment.soft.stiffness? };
        let contacts = contacts(&experiment.scene, start.len());
        let largest = |scheme: Scheme| {
            let reduced = |contact: &Contact| law.angular_frequency(contact.least_mass) * step;
            let gains = contacts.iter().map(|contact| gain(scheme, contact.restitution, reduced(contact)));
            gains.fold(0.0, f64::max)
        };
        let heaviest = |wall: bool| {
            let of = contacts.iter().filter(|contact| contact.wall.is_some() == wall);
            of.map(|contact| 0.5 * contact.largest_mass).fold(0.0, f64::max)
        };
        let local = largest(Scheme::of(experiment.soft.integrator, SoftStepping::Local));
        let uniform = schemes(experiment).into_iter().map(largest).fold(0.0, f64::max);
        let elastic_at_start = elastic_energy(&law, &experiment.scene, start);
        let start = start.kinetic_energy() + elastic_at_start;
        let remedy = remedy(experiment, &contacts, &law, step);
        Some(Self { local, uniform, pair: heaviest(false), wall: heaviest(true), start, elastic_at_start, remedy })
    }

    /// The failure of an energy that has grown beyond the bound: kinetic and elastic energy, and the elastic part of it [J],
    /// at simulated `time` [s]; `uniform` says whether all particles have been stepped. An energy that is not a number is
    /// left to others.
    ///
    /// # Errors
    /// [`Failure::EnergyGrew`].
    pub fn check(&self, time: f64, uniform: bool, energy: f64, elastic: f64, record: &Record) -> Result<(), Failure> {
        let ledger = &record.ledger;
        let grown = energy - self.start - ledger.drag_work - ledger.gravity_work;
        let ended =
            self.pair * record.pairs.normal_speed.sum_of_squares + self.wall * record.walls.normal_speed.sum_of_squares;
        let through = self.start + ledger.drag_work.abs() + ledger.gravity_work.abs() + ledger.dissipated();
        let gain = if uniform { self.uniform } else { self.local };
        let explained = gain * (ended + energy) + self.elastic_at_start + elastic + ROUNDING * through;
        if grown <= explained || grown.is_nan() {
            return Ok(());
        }
        Err(Failure::EnergyGrew { time, grown, explained, remedy: self.remedy.clone() })
    }
}

/// Settings with which the step is half as long or shorter, and the integrator one that does not heat.
fn remedy(experiment: &Experiment, contacts: &[Contact], law: &LinearSpringDashpot, step: f64) -> String {
    let times = contacts.iter().map(|contact| law.contact_time(contact.least_mass, contact.restitution));
    let steps = times.fold(f64::INFINITY, f64::min) / step;
    // 20 is the number of steps that a case without one gets
    let more = (2.0 * steps).ceil().max(20.0);
    match experiment.soft.integrator {
        Integrator::VelocityVerlet => format!("soft.steps_per_contact = {more}"),
        Integrator::Rk2 => format!("soft.steps_per_contact = {more}, soft.integrator = \"velocity_verlet\""),
    }
}

/// [-] g of a scheme at a restitution and ω_0 Δt: see [`Bound`].
fn gain(scheme: Scheme, restitution: f64, reduced: f64) -> f64 {
    /// Steps between N_c and N_c + 1 that are looked at.
    const LENGTHS: u32 = 8;
    let most = match scheme.method {
        // a step of exactly so many is still one, however it was rounded
        Method::Heun => reduced_step(restitution, FEWEST_STEPS) * (1.0 + 1e-9),
        Method::VelocityVerlet | Method::FourthOrder => stability_limit(scheme.method, restitution),
    };
    if reduced > most {
        return 0.0;
    }
    if scheme.method == Method::VelocityVerlet {
        return 1.0 / (1.0 - 0.25 * reduced * reduced) - 1.0;
    }
    let steps = reduced_step(restitution, 1.0) / reduced;
    let lengths = (0..=LENGTHS).map(|k| reduced_step(restitution, steps + f64::from(k) / f64::from(LENGTHS)));
    let largest = lengths.filter_map(|step| Some(realised_restitution(scheme, restitution, step)?.largest));
    largest.map(|largest| largest * largest - 1.0).fold(0.0, f64::max)
}

/// [J] energy that overlaps hold.
fn elastic_energy(law: &LinearSpringDashpot, scene: &Scene, particles: &Particles) -> f64 {
    let mut particles = particles.clone();
    let mut list = NeighbourList::default();
    list.build(&mut particles, scene, 0.0);
    let mut slots = Vec::new();
    list.overlapping(&particles, scene, &mut slots);
    let energy = |&slot: &u32| {
        let overlap = match list.pairs.get(slot as usize) {
            Some(pair) => {
                let (a, b) = (&particles.position[pair.i as usize], &particles.position[pair.j as usize]);
                pair.reach - scene.domain.separation(a, b).norm()
            }
            None => {
                let near = list.walls[slot as usize - list.pairs.len()];
                let i = near.particle as usize;
                particles.radius[i] - scene.walls[near.wall as usize].geometry.nearest(&particles.position[i]).distance
            }
        };
        law.elastic_energy(overlap)
    };
    slots.iter().map(energy).sum()
}
