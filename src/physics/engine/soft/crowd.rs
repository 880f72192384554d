//! Crowd: an island (group of particles that may meet) that is too large for local stepping. Its particles are moved
//! by uniform steps, as if no particles outside the island existed. A window is the time between two exchanges with
//! the gas.

use super::backoff::{UniformStepWork, stages};
use super::contacts::StepRecord;
use super::{Contact, Soft, SoftSolver};
use crate::contact_law::ContactLaw;
use crate::engine::distributed::SingleProcess;
use crate::engine::driver::Solver;
use crate::engine::islands::Island;
use crate::engine::{Failure, Window};
use crate::experiment::{Integrator, SoftStepping};
use crate::scene::Scene;

/// Settings of the uniform steps by which a crowd (large island) is moved.
#[derive(Clone, Copy, Debug)]
pub struct Steps {
    /// Contact law of the steps.
    pub law: ContactLaw,
    /// Integrator of the steps.
    pub integrator: Integrator,
    /// [s] longest step; steps may be a little shorter, so that a whole number of steps fits into the interval.
    pub longest: f64,
}

impl Steps {
    /// [ns/s] estimated cost of uniform steps in a bed, per particle and simulated time. A particle in a bed has about
    /// six neighbours and four contacts, each of which is shared by two particles.
    pub fn cost_in_a_bed(&self) -> f64 {
        let stages = stages(self.integrator) / self.longest;
        UniformStepWork { stages, particles: 1, slots: 3, forces: 2.0 * stages }.cost()
    }
}

/// Moves a crowd (a large island) by uniform steps for `end` [s] from the beginning of the window. Returns `None` if
/// the result is valid: no member exceeds its speed limit and no other particle is hit. Otherwise the island must be
/// solved again. The function then returns the local index of one particle that is too fast or was hit, and stores the
/// other such indices in [`Island::also`]. The index 0 then stands for all members that are too fast.
///
/// # Errors
/// Returns the failure of the uniform steps.
pub fn solve(
    island: &mut Island<Contact>,
    steps: Steps,
    scene: &Scene,
    window: Window,
    end: f64,
) -> Result<Option<usize>, Failure> {
    let mut solver = Soft::new(steps.law, steps.integrator, steps.longest, SoftStepping::Uniform).solver;
    solver.contacts.put(std::mem::take(&mut island.carried));
    let mut particles = std::mem::take(&mut island.particles);
    let before: Vec<_> = particles.velocity.iter().map(|velocity| velocity + scene.gravity * end).collect();
    // the list reorders the particles; until their order is restored, their old indices replace their ids
    solver.ids = std::mem::replace(&mut particles.id, (0..before.len() as u32).collect());
    let mut log = std::mem::take(&mut island.log);
    let pushed = log.ledger.wall_impulse;
    let part = Window { start: window.start, duration: end };
    let result = solver.uniform(
        &mut particles,
        scene,
        part,
        &mut StepRecord { log: &mut log, record: None },
        &mut SingleProcess,
    );
    // until the end of the window gravity does work on the momentum that walls have added
    log.ledger.gravity_work += scene.gravity.dot(&(log.ledger.wall_impulse - pushed)) * (window.duration - end);
    let contacts = solver.contacts.take(&solver.list);
    let moved = |contact: Contact| {
        let couple = contact.touch.couple.moved(|index| particles.id[index as usize]);
        Contact { touch: super::TouchingPair { couple, ..contact.touch }, ..contact }
    };
    island.carried.extend(contacts.into_iter().map(moved));
    particles.sort_by_id();
    particles.id = std::mem::take(&mut solver.ids);
    island.log = log;
    count(island, &solver);
    // particles that are not members, but whose velocities contacts have changed, must become members of the island
    island.also = (island.hot..before.len()).filter(|&k| particles.velocity[k] != before[k]).collect();
    island.particles = particles;
    result?;
    let fastest = solver.speed.pushed + island.apart_from(&solver.list.frame());
    // in a sheared box, `pushed` is relative to the mean flow at the present positions, but the speed limits are
    // relative to the mean flow at the initial positions
    let fastest = fastest * (1.0 + scene.domain.strain_rate() * end);
    if fastest > island.least_limit() {
        island.fastest = fastest;
        island.also.insert(0, 0);
    }
    Ok(island.also.pop())
}

/// Adds the work of the uniform steps to the counters of the island, in which a particle or gap of a local time step
/// counts 1.
fn count(island: &mut Island<Contact>, solver: &SoftSolver) {
    let counters = solver.counters(&Default::default());
    island.crowd_steps += counters.steps;
    island.crowd_forces += counters.force_evaluations;
    island.force_evaluations += counters.force_evaluations;
    // in a uniform step, a particle or a gap costs half as much as in a local step (`backoff`)
    island.updates += (counters.steps * island.particles.len() as u64 + counters.pair_checks) / 2;
}
