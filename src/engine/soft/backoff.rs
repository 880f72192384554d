//! When do islands not pay, and how long does uniform stepping then go on before they are tried again?
//!
//! In a crowd islands are large, and each step of theirs moves all of their particles and looks at all of their gaps several times.
//! What they did in a window is weighed against what uniform steps would have done in the same time, both by counts, so that the
//! choice is the same on every machine. Weights are in ns on one core, from the timings of a dense gas and of a bed on one machine
//! (782 spheres at a volume fraction of 0.5; 400 settling spheres), to within a factor of 2: they choose, they do not time.

use super::UNIFORM_COST;
use crate::engine::islands::IslandCounters;
use serde::{Deserialize, Serialize};

/// Flight and cells of a search, per particle (the weight of `cheapest_part`).
const SEARCH: f64 = 90.0;

/// A pair looked at in a search.
const CHECK: f64 = 1.2;

/// Taking a particle into an island and back, half of what `cheapest_part` counts for its whole collision.
const MEMBER: f64 = 700.0;

/// Force of a contact in an island.
const FORCE: f64 = 45.0;

/// A particle moved by a stage of an island's step, or a gap looked at.
const UPDATE: f64 = 10.0;

/// A pair of the neighbour list looked at in a uniform step.
const LISTED: f64 = 5.0;

/// Force of a contact in a uniform step, with its records.
const CONTACT: f64 = 50.0;

/// Longest stay away from islands, in windows: a trial that fails costs some five uniform windows, so fewer than a tenth.
const LONGEST: u32 = 64;

/// [ns] what the steps of islands cost.
pub fn steps_cost(forces: u64, updates: u64) -> f64 {
    FORCE * forces as f64 + UPDATE * updates as f64
}

/// What uniform steps would come to in a window, or in the part of it that islands did.
pub struct Rival {
    /// [-] steps, or stages of them.
    pub stages: f64,
    /// Particles.
    pub particles: usize,
    /// Slots of the neighbour list.
    pub slots: usize,
    /// [-] forces computed.
    pub forces: f64,
}

impl Rival {
    /// [ns] what they would cost.
    pub fn cost(&self) -> f64 {
        let everybody = UNIFORM_COST * self.particles as f64 + LISTED * self.slots as f64;
        self.stages * everybody + CONTACT * self.forces
    }
}

/// For how many windows islands are left alone.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Backoff {
    /// Windows of the last stay away.
    stay: u32,
    /// Windows still to go.
    left: u32,
}

impl Backoff {
    /// Whether islands are left alone in this window, which then counts as gone.
    pub fn waits(&mut self) -> bool {
        let waits = self.left > 0;
        self.left = self.left.saturating_sub(1);
        waits
    }

    /// Judges what islands did between two counts: where they cost more than the rival, the next windows are uniform, twice as
    /// many as after the trial before.
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
