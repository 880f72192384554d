//! Choice between islands and uniform steps: where islands do not pay, some windows are uniform before the next trial.
//!
//! In a crowd islands are large, and each of their steps moves all of their particles and tests all of their gaps
//! several times. The work of islands in a window is compared with the work of uniform steps in the same time. Both are
//! counted, not timed, so the choice is the same on every machine. The weights are in ns on one core, from timings of a
//! dense gas and of a bed on one machine (782 spheres at a volume fraction of 0.5; 400 settling spheres). They hold to
//! within a factor of 2, which is enough to choose but not to predict run times.

use super::UNIFORM_COST;
use crate::engine::islands::IslandCounters;
use serde::{Deserialize, Serialize};

/// [ns] flight and cells of a search, per particle (the weight of `cheapest_part`).
const SEARCH: f64 = 90.0;

/// [ns] test of a pair in a search.
const CHECK: f64 = 1.2;

/// [ns] taking a particle into an island and back: half of the weight of its whole collision in `cheapest_part`.
const MEMBER: f64 = 700.0;

/// [ns] force of a contact in an island.
const FORCE: f64 = 45.0;

/// [ns] motion of a particle in a stage of an island's step, or test of a gap.
const UPDATE: f64 = 10.0;

/// [ns] test of a pair of the neighbour list in a uniform step.
const LISTED: f64 = 5.0;

/// [ns] force of a contact in a uniform step, with its records.
const CONTACT: f64 = 50.0;

/// Longest pause of islands, in windows. A trial that fails costs some five uniform windows, so less than a tenth of
/// the pause.
const LONGEST: u32 = 64;

/// [ns] cost of the steps of islands.
pub fn steps_cost(forces: u64, updates: u64) -> f64 {
    FORCE * forces as f64 + UPDATE * updates as f64
}

/// Work of uniform steps in a window, or in the part of it that islands did.
pub struct Rival {
    /// [-] number of steps times the number of stages per step.
    pub stages: f64,
    /// Number of particles.
    pub particles: usize,
    /// Number of slots of the neighbour list.
    pub slots: usize,
    /// [-] number of forces computed.
    pub forces: f64,
}

impl Rival {
    /// [ns] cost of the uniform steps.
    pub fn cost(&self) -> f64 {
        let everybody = UNIFORM_COST * self.particles as f64 + LISTED * self.slots as f64;
        self.stages * everybody + CONTACT * self.forces
    }
}

/// Pause of islands: the number of windows in which they are not tried.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Backoff {
    /// Windows of the last pause.
    stay: u32,
    /// Windows that are left of the pause.
    left: u32,
}

impl Backoff {
    /// True if islands are not tried in this window. The window then counts as part of the pause.
    pub fn waits(&mut self) -> bool {
        let waits = self.left > 0;
        self.left = self.left.saturating_sub(1);
        waits
    }

    /// Compares the cost of islands between two counts with that of uniform steps. If islands cost more, the next
    /// windows are uniform, twice as many as in the last pause. Otherwise the last pause counts half.
    pub fn judge(&mut self, before: &IslandCounters, after: &IslandCounters, fallback_cost: &Rival) {
        if after.neighbour_builds == before.neighbour_builds {
            // not tried
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
        // one cheap window does not undo what many have shown
        self.stay = if pays { self.stay / 2 } else { (2 * self.stay).clamp(1, LONGEST) };
        self.left = if pays { 0 } else { self.stay };
    }
}
