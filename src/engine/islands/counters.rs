//! Counts of the work done in islands.

use super::batch::Solved;
use crate::engine::Counters;
use crate::engine::distributed::Domains;
use serde::de::DeserializeOwned;
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

    /// All counts that are sums, of which each process counts its own contribution.
    fn sums(&mut self) -> [&mut u64; 11] {
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

    /// Sums the counts of all processes since `before`.
    pub fn add_up<C: Copy + Serialize + DeserializeOwned>(&mut self, before: &Self, domains: &Domains<C>) {
        let mut past = *before;
        let mut since: Vec<i64> =
            self.sums().into_iter().zip(past.sums()).map(|(now, before)| (*now - *before) as i64).collect();
        domains.count(&mut since);
        for ((now, before), since) in self.sums().into_iter().zip(past.sums()).zip(since) {
            *now = *before + since as u64;
        }
        let mut largest = [self.largest as f64];
        domains.largest(&mut largest);
        self.largest = largest[0] as u64;
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
