//! Kicks of drag and heat, which change the velocities of all particles and leave their positions as they are. The
//! ledger holds the sums of work, losses and impulses since the start.

use super::Simulation;
use super::share::Order;
use super::turbulence::{self, TurbulentKick};
use crate::drag::Kick;
use crate::exact::{self, BLOCK, ExactSum};
use crate::fluid::{LocalFractions, Profile};
use crate::particles::{CHUNK, Particles};
use crate::record::Ledger;
use crate::scene::Species;
use crate::work_sharing;
use nalgebra::Vector3;

/// Smallest number of particles for which the drag law is tabulated. With inlets or outlets, the law is tabulated for
/// any number. Making the table takes as long as several dozen kicks (changes of velocities by drag) of this number of
/// particles, and a run makes hundreds of kicks.
const TABULATE: usize = 1000;

impl Simulation {
    pub(super) fn is_dragged(&self) -> bool {
        self.scene.fluid.as_ref().is_some_and(|fluid| fluid.drag.is_some())
    }

    /// Applies drag and a thermostat to all particles for `duration` [s], without any motion (a kick). The random
    /// numbers of the kick follow from its `number`.
    pub(super) fn kick(&mut self, duration: f64, number: u64) {
        let (dragged, heated) = (self.is_dragged(), self.scene.thermostat.is_some());
        if (dragged || heated) && self.engine.is_cut() {
            self.order(&Order::Kick(duration, number));
        }
        // with drag, half of the heat is given before it and half after it, so that the splitting is of second order
        let share = if dragged { 0.5 } else { 1.0 };
        self.heat(share * duration, 2 * number);
        if dragged {
            self.drag(duration, number);
            self.heat(share * duration, 2 * number + 1);
        }
    }

    /// Applies drag alone to all particles for `duration` [s]. The random numbers of turbulence follow from `number`,
    /// the number of the kick.
    fn drag(&mut self, duration: f64, number: u64) {
        let Some(fluid) = &self.scene.fluid else { return };
        let Some(law) = &fluid.drag else { return };
        let began = self.clock.now();
        let index = self.kicks.iter().position(|kick| kick.duration() == duration).unwrap_or_else(|| {
            self.kicks.truncate(1);
            // a population that changes may cross the limit, and a resumed run must have the same kicks
            let is_small = self.totals.count < TABULATE && !self.scene.has_openings();
            let make = if is_small { Kick::exact } else { Kick::tabulated };
            let kick = make(law, &self.spheres, duration);
            let spread = |species: &Species| species.sizes.is_some().then_some(species.diameter);
            let kick = if self.scene.has_sizes() {
                kick.with_sizes(self.scene.species.iter().map(spread).collect())
            } else {
                kick
            };
            self.kicks.insert(0, kick);
            0
        });
        let fractions = law.law().cells().map(|cells| self.fractions(cells));
        let kick = &self.kicks[index];
        let before = self.slice_sums(Some((kick, fractions.as_ref())));
        let sums = match &fluid.turbulence {
            None => kick_among(&mut self.particles, &fluid.profile, kick, fractions.as_ref()),
            Some(turbulence) => {
                turbulence::draw_first_eddies(&mut self.particles, (fluid, turbulence), self.seed);
                let (profile, fractions) = (&fluid.profile, fractions.as_ref());
                let seed_and_number = (self.seed, number);
                TurbulentKick { profile, turbulence, kick, fractions, seed_and_number }.apply(&mut self.particles)
            }
        };
        self.advance_gas(before, duration);
        self.book_kick(sums, |drag_impulse, drag_work| Ledger { drag_impulse, drag_work, ..Ledger::default() });
        self.spent.drag += self.clock.now() - began;
    }

    /// Local volume fractions of the particles of all processes, with `cells` cells along x, y and z.
    pub(super) fn fractions(&self, cells: [u32; 3]) -> LocalFractions {
        LocalFractions::of(&self.particles, &self.scene.domain, cells, self.parts())
    }

    /// Adds the impulse and the work of a kick (change of velocities at fixed positions) to the ledger of energies and
    /// impulses, and the impulse to the total momentum. `sums` contains the impulse [kg m/s] along x, y and z and the
    /// work [J] for the particles of this process. `entry` makes the entry of the ledger from the totals over all
    /// processes.
    pub(super) fn book_kick(&mut self, mut sums: [ExactSum; 4], entry: fn(Vector3<f64>, f64) -> Ledger) {
        self.sample().total(&mut sums.each_mut());
        if self.is_follower() {
            return;
        }
        let [x, y, z, work] = exact::values(&sums);
        let impulse = Vector3::new(x, y, z);
        self.record.ledger += entry(impulse, work);
        self.totals.momentum += impulse;
    }
}

/// Applies drag alone to all particles, in a gas with the given profile. Returns sums over all particles: the impulse
/// [kg m/s] of drag along x, y and z, and the work [J] of drag.
pub fn kick(particles: &mut Particles, profile: &Profile, kick: &Kick) -> [ExactSum; 4] {
    kick_among(particles, profile, kick, None)
}

/// Applies drag alone to all particles, as [`kick`] does. With `fractions`, the drag depends on the local volume
/// fractions of the particles; with `None` it does not.
pub(super) fn kick_among(
    particles: &mut Particles,
    profile: &Profile,
    kick: &Kick,
    fractions: Option<&LocalFractions>,
) -> [ExactSum; 4] {
    let Particles { position, velocity, mass, species, radius, .. } = particles;
    if velocity.len() <= CHUNK {
        return kick_chunk(velocity, (position, (mass, (species, radius))), (profile, fractions), kick);
    }
    let others = position.chunks(CHUNK).zip(mass.chunks(CHUNK).zip(species.chunks(CHUNK).zip(radius.chunks(CHUNK))));
    let each = |(velocity, others)| kick_chunk(velocity, others, (profile, fractions), kick);
    work_sharing::map(velocity.chunks_mut(CHUNK).zip(others), each).into_iter().fold(exact::none(), exact::merged)
}

/// Positions [m], masses [kg], species and radii [m] of one chunk of particles (successive particles that one thread
/// treats).
type Dragged<'a> = (&'a [Vector3<f64>], (&'a [f64], (&'a [u16], &'a [f64])));

/// Applies drag alone to one chunk (successive particles that one thread treats), as [`kick`] does. The chunk is
/// divided into short blocks, and each block is treated in three loops, so that the processor computes several
/// particles at once.
fn kick_chunk(
    velocity: &mut [Vector3<f64>],
    (position, (mass, (species, radius))): Dragged,
    (profile, fractions): (&Profile, Option<&LocalFractions>),
    kick: &Kick,
) -> [ExactSum; 4] {
    let slip = |v: &Vector3<f64>, gas: f64| Vector3::new(v.x, v.y, v.z - gas);
    let (mut gas, mut ratio) = ([0.0; BLOCK], [0.0; BLOCK]);
    let (mut sums, mut rows) = (exact::none(), [[0.0; 4]; BLOCK]);
    let asks_sizes = kick.asks_sizes();
    let kinds = species.chunks(BLOCK).zip(radius.chunks(BLOCK));
    let others = position.chunks(BLOCK).zip(mass.chunks(BLOCK).zip(kinds));
    for (velocity, (position, (mass, (species, radius)))) in velocity.chunks_mut(BLOCK).zip(others) {
        for (gas, x) in gas.iter_mut().zip(position) {
            *gas = profile.velocity_at(x);
        }
        if let Some(fractions) = fractions {
            let kinds = position.iter().zip(species.iter().zip(radius));
            for (((ratio, gas), v), (x, (species, radius))) in ratio.iter_mut().zip(gas).zip(&*velocity).zip(kinds) {
                let fraction = fractions.at(x, *radius);
                *ratio = kick.change_among(*species, *radius, fraction, slip(v, gas).norm_squared());
            }
        } else if asks_sizes {
            let kinds = species.iter().zip(radius);
            for (((ratio, gas), v), (species, radius)) in ratio.iter_mut().zip(gas).zip(&*velocity).zip(kinds) {
                *ratio = kick.change_of(*species, *radius, slip(v, gas).norm_squared());
            }
        } else {
            for (((ratio, gas), v), species) in ratio.iter_mut().zip(gas).zip(&*velocity).zip(species) {
                *ratio = kick.change(*species, slip(v, gas).norm_squared());
            }
        }
        let rows = &mut rows[..velocity.len()];
        for ((((v, m), gas), ratio), row) in velocity.iter_mut().zip(mass).zip(gas).zip(ratio).zip(&mut *rows) {
            let change = slip(v, gas) * ratio;
            let work = m * change.dot(&(*v + 0.5 * change));
            *row = [change.x * m, change.y * m, change.z * m, work];
            *v += change;
        }
        exact::add_rows(sums.each_mut(), rows);
    }
    sums
}
