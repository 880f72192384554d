//! Weight of the particles: its work and impulse, and the differences in acceleration of species with buoyancy. A
//! window is the time between two exchanges with the gas. The ledger holds the sums of work, losses and impulses since
//! the start.

use super::Simulation;
use crate::exact::{self, BLOCK, ExactSum};
use crate::particles::{CHUNK, Particles};
use crate::record::Ledger;
use crate::work_sharing;
use nalgebra::Vector3;

impl Simulation {
    /// [N] weight of all particles in all processes minus their buoyancy. If particles come and go, or species differ
    /// in buoyancy, it is the mean over the time since the start.
    pub fn weight(&self) -> Vector3<f64> {
        if self.has_constant_weight() || self.time == 0.0 {
            return self.total_mass() * self.scene.gravity;
        }
        // the impulse of a constant force is proportional to the time
        self.record.ledger.gravity_impulse / self.time
    }

    /// True if the weight of all particles minus their buoyancy does not change during the run.
    pub fn has_constant_weight(&self) -> bool {
        self.scene.differences_in_gravity().is_empty() && !self.scene.has_openings()
    }

    /// Adds the work and the impulse of gravity in a window of `window` [s] to the ledger (sums of work and losses).
    /// `reached` [s] is the time from the start of the window to a failure, or the whole window. `by_walls` [kg m/s]
    /// is the momentum that walls have given to the particles in this time.
    pub(super) fn book_gravity(&mut self, by_walls: Vector3<f64>, [window, reached]: [f64; 2]) {
        let g = self.scene.gravity;
        // The work of gravity is computed from the momentum of all particles. Momentum exchanged between particles
        // cancels; momentum from walls counts as if it were given at the end of the window.
        let work =
            g.dot(&self.totals.momentum) * reached + 0.5 * self.totals.mass * g.norm_squared() * reached * reached;
        let weight = g * (self.totals.mass * reached);
        self.record.ledger += Ledger {
            gravity_work: work - g.dot(&by_walls) * (window - reached),
            gravity_impulse: weight,
            ..Ledger::default()
        };
        self.totals.momentum += weight + by_walls;
    }

    /// Accelerates each particle for `duration` [s] by the acceleration of its species minus that of the densest
    /// species. Both are the accelerations by weight and buoyancy. The engine itself applies the acceleration of the
    /// densest species to all particles.
    pub(super) fn add_differences_in_gravity(&mut self, duration: f64) {
        let differences = self.scene.differences_in_gravity();
        if differences.is_empty() {
            return;
        }
        let began = self.clock.now();
        let changes: Vec<Vector3<f64>> = differences.iter().map(|difference| difference * duration).collect();
        let species = std::mem::take(&mut self.particles.species);
        let sums = accelerate(&mut self.particles, |index, _| changes[usize::from(species[index])]);
        self.particles.species = species;
        self.book_kick(sums, |gravity_impulse, gravity_work| Ledger {
            gravity_impulse,
            gravity_work,
            ..Ledger::default()
        });
        self.spent.drag += self.clock.now() - began;
    }
}

/// Adds to the velocity of each particle a change [m/s], which `change` returns for its index and its velocity [m/s].
/// Returns sums over all particles: the impulse [kg m/s] along x, y and z, and the work [J].
pub(super) fn accelerate(
    particles: &mut Particles,
    change: impl Fn(usize, &Vector3<f64>) -> Vector3<f64> + Sync,
) -> [ExactSum; 4] {
    let Particles { velocity, mass, .. } = particles;
    let chunks = velocity.chunks_mut(CHUNK).zip(mass.chunks(CHUNK)).enumerate();
    let each = |(chunk, (velocity, mass)): (usize, (&mut [Vector3<f64>], &[f64]))| {
        let (mut sums, mut rows) = (exact::none(), [[0.0; 4]; BLOCK]);
        let blocks = velocity.chunks_mut(BLOCK).zip(mass.chunks(BLOCK));
        for (first, (velocity, mass)) in (chunk * CHUNK..).step_by(BLOCK).zip(blocks) {
            let rows = &mut rows[..velocity.len()];
            for (index, ((v, m), row)) in (first..).zip(velocity.iter_mut().zip(mass).zip(&mut *rows)) {
                let change = change(index, v);
                *row = [change.x * m, change.y * m, change.z * m, m * change.dot(&(*v + 0.5 * change))];
                *v += change;
            }
            exact::add_rows(sums.each_mut(), rows);
        }
        sums
    };
    work_sharing::map(chunks, each).into_iter().fold(exact::none(), exact::merged)
}
