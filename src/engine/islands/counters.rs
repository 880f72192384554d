//! Counts of the work done in islands.

use super::batch::Solved;
use crate::engine::Counters;
use serde::{Deserialize, Serialize};

/// Counts of the work done in islands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct IslandCounters {
    /// Impulses (hard) or contact steps (soft).
    pub events: u64,
    /// Impulses (hybrid).
    pub impulses: u64,
    /// Uniform steps of islands that are too large for local stepping (hybrid).
    pub crowd_steps: u64,
    /// Contact forces computed in uniform steps of such islands.
    pub crowd_forces: u64,
    /// Touch times and gaps computed in islands.
    pub pair_checks: u64,
    /// Pairs and walls checked in searches.
    pub searched: u64,
    /// Contact forces computed.
    pub force_evaluations: u64,
    /// Particles moved by stages of steps, and gaps checked after steps.
    pub updates: u64,
    /// Pairs that searches were expected to check; independent of the number of processes that share the run.
    pub foreseen: u64,
    /// Cell grids built.
    pub neighbour_builds: u64,
    /// Islands solved.
    pub islands: u64,
    /// Particles in all islands solved.
    pub members: u64,
    /// Particles in the largest island.
    pub largest: u64,
    /// Islands solved again after they met something unexpected.
    pub redone: u64,
}

impl IslandCounters {
    /// Adds other counts.
    pub fn add(&mut self, other: &Self) {
        let largest = self.largest.max(other.largest);
        for (own, other) in self.sums().into_iter().zip(other.clone().sums()) {
            *own += *other;
        }
        self.largest = largest;
    }

    /// All counts that are sums.
    pub fn sums(&mut self) -> [&mut u64; 11] {
        let Self { events, impulses, crowd_steps, crowd_forces, pair_checks, searched, .. } = self;
        let Self { force_evaluations, updates, islands, members, redone, .. } = self;
        [
            events,
            impulses,
            crowd_steps,
            crowd_forces,
            pair_checks,
            searched,
            force_evaluations,
            updates,
            islands,
            members,
            redone,
        ]
    }

    /// Adds the cost of solving one island.
    pub fn count(&mut self, solved: &Solved) {
        self.events += solved.events;
        self.impulses += solved.impulses;
        self.crowd_steps += solved.crowd_steps;
        self.crowd_forces += solved.crowd_forces;
        self.pair_checks += solved.pair_checks;
        self.force_evaluations += solved.force_evaluations;
        self.updates += solved.updates;
    }

    /// Counts that have one meaning in all engines.
    pub fn of_all_engines(&self) -> Counters {
        Counters {
            islands: self.islands,
            island_members: self.members,
            largest_island: self.largest,
            islands_redone: self.redone,
            ..Counters::default()
        }
    }
}
