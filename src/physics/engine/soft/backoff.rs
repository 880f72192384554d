//! Choice between islands (groups of particles that may meet) and uniform steps of all particles. After a window (time
//! between two exchanges with the gas) in which islands cost more than uniform steps, islands are not tried for some
//! windows.
//!
//! In a dense scene islands are large, and each of their steps moves all of their particles and tests all of their gaps
//! several times. The costs of islands and of uniform steps are estimated from counts of operations. Counts, unlike
//! measured times, lead to the same choice on every machine. The weights of the counts are in ns on one core, measured
//! on one machine with a dense gas and a bed (782 spheres at a volume fraction of 0.5; 400 settling spheres). They are
//! right within a factor of 2, which is enough for the choice but not for a prediction of run times.

use super::UNIFORM_COST;
use crate::engine::islands::IslandCounters;
use crate::experiment::Integrator;
use serde::{Deserialize, Serialize};

/// [ns] cost per particle of one search for touches on straight flights. The search computes the flight of the
/// particle, and sorts the particle into a cell. The function `cheapest_part`, which chooses the time for which islands
/// (groups of particles that may meet) are solved, uses the same value.
const SEARCH: f64 = 90.0;

/// [ns] cost of testing one pair of particles for a touch.
const CHECK: f64 = 1.2;

/// [ns] cost of copying a particle into an island (group of particles that may meet) and back. The function
/// `cheapest_part` uses twice this value, because it includes the cost of solving the island.
const MEMBER: f64 = 700.0;

/// [ns] cost of one contact force in an island (group of particles that may meet).
const FORCE: f64 = 45.0;

/// [ns] cost of moving one particle of an island (group of particles that may meet) by one Runge-Kutta stage, or of
/// testing one gap in the island.
const UPDATE: f64 = 10.0;

/// [ns] cost of testing one slot (candidate) of the neighbour list in a uniform step.
const LISTED: f64 = 5.0;

/// [ns] cost of one contact force in a uniform step, including the update of the stored data of the contact.
const CONTACT: f64 = 50.0;

/// Longest pause in which islands (groups of particles that may meet) are not tried, as a number of windows (times
/// between two exchanges with the gas). A failed trial of islands costs about as much as uniform steps in five windows.
/// This is less than a tenth of the longest pause.
const LONGEST: u32 = 64;

/// [ns] cost of local time steps, which move only islands (groups of particles that may meet). `forces` is the number
/// of contact forces. `updates` is the number of particles moved, summed over all stages of the steps, plus the number
/// of gaps tested.
pub fn steps_cost(forces: u64, updates: u64) -> f64 {
    FORCE * forces as f64 + UPDATE * updates as f64
}

/// Work that uniform steps (of all particles) would need for the simulated time that islands (groups of particles that
/// may meet) have covered. The cost of the islands is compared with the cost of this work.
pub struct UniformStepWork {
    /// [-] number of uniform steps times the number of force evaluations per step.
    pub stages: f64,
    /// Number of particles that uniform steps would move.
    pub particles: usize,
    /// Number of slots (candidates for contacts) of the neighbour list that each uniform step would test.
    pub slots: usize,
    /// [-] number of contact forces that the uniform steps would compute.
    pub forces: f64,
}

impl UniformStepWork {
    /// [ns] cost of the uniform steps on one core.
    pub fn cost(&self) -> f64 {
        let all_particles = UNIFORM_COST * self.particles as f64 + LISTED * self.slots as f64;
        self.stages * all_particles + CONTACT * self.forces
    }
}

/// Pause in which islands (groups of particles that may meet) are not tried, as a number of windows (times between two
/// exchanges with the gas).
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Backoff {
    /// Length of the last pause, as a number of windows (times between two exchanges with the gas). It is halved after
    /// each window in which islands cost no more than uniform steps.
    stay: u32,
    /// Number of windows (times between two exchanges with the gas) until the present pause ends.
    left: u32,
}

impl Backoff {
    /// Returns true during a pause, in which islands are not tried. During a pause, each call shortens the rest of the
    /// pause by one window.
    pub fn waits(&mut self) -> bool {
        let waits = self.left > 0;
        self.left = self.left.saturating_sub(1);
        waits
    }

    /// Compares the cost of islands between the counts `before` and `after` with the cost `fallback_cost` of uniform
    /// steps. If islands cost more, a pause begins that is twice as long as the previous pause, up to `LONGEST`.
    /// Otherwise the stored length of the previous pause is halved. Does nothing if islands were not tried between
    /// `before` and `after`.
    pub fn judge(&mut self, before: &IslandCounters, after: &IslandCounters, fallback_cost: &UniformStepWork) {
        if after.neighbour_builds == before.neighbour_builds {
            // islands were not tried in this window
            return;
        }
        let since = |count: fn(&IslandCounters) -> u64| (count(after) - count(before)) as f64;
        let islands = SEARCH * fallback_cost.particles as f64 * since(|c| c.neighbour_builds)
            + CHECK * (since(|c| c.pair_checks) + since(|c| c.foreseen))
            + MEMBER * since(|c| c.members)
            + CONTACT * since(|c| c.crowd_forces)
            + steps_cost(
                (after.force_evaluations - before.force_evaluations) - (after.crowd_forces - before.crowd_forces),
                after.updates - before.updates,
            );
        let pays = islands <= fallback_cost.cost();
        // one cheap window only halves the pause, because earlier windows have shown that islands cost more
        self.stay = if pays { self.stay / 2 } else { (2 * self.stay).clamp(1, LONGEST) };
        self.left = if pays { 0 } else { self.stay };
    }
}

/// [-] number of force evaluations in a uniform step of the integrator.
pub fn stages(integrator: Integrator) -> f64 {
    match integrator {
        Integrator::VelocityVerlet => 1.0,
        Integrator::Rk2 => 2.0,
    }
}
