//! Counts of the work done in islands (groups of particles that may meet).

use super::batch::Solved;
use crate::engine::Counters;
use serde::{Deserialize, Serialize};

/// Amounts of work done in islands (groups of particles that may meet) since the start of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct IslandCounters {
    /// Number of collisions (hard spheres), or of time steps of contacts (soft and hybrid spheres).
    pub events: u64,
    /// Number of collisions in the hybrid engine, which counts the time steps of its contacts in `events`.
    pub impulses: u64,
    /// Number of uniform steps of crowds, which are islands so large that they are moved by uniform steps.
    pub crowd_steps: u64,
    /// Number of contact forces computed in uniform steps of crowds, which are large islands.
    pub crowd_forces: u64,
    /// Number of times of touch and gaps computed in islands (groups of particles that may meet).
    pub pair_checks: u64,
    /// Number of pairs of particles, plus number of pairs of a particle and a wall, that were checked in searches for
    /// touches.
    pub searched: u64,
    /// Number of contact forces computed in all islands, those in uniform steps of crowds included.
    pub force_evaluations: u64,
    /// Measure of the work: one for each particle moved in each stage of the time integrator, plus one for each gap
    /// checked after a step. In crowds (islands moved by uniform steps) both count one half.
    pub updates: u64,
    /// Estimated number of pairs that searches for touching particles check. Unlike the actual number, it does not
    /// depend on the number of processes that share the run.
    pub foreseen: u64,
    /// Number of searches for touching particles, each with a new grid of cells.
    pub neighbour_builds: u64,
    /// Number of islands (groups of particles that may meet) with a valid result; each part (piece of a window) adds
    /// the number of its islands.
    pub islands: u64,
    /// Number of members of the islands (groups of particles that may meet) that `islands` counts.
    pub members: u64,
    /// Number of members of the largest island (group of particles that may meet) that was solved.
    pub largest: u64,
    /// Number of islands whose result was discarded, because a particle met an unexpected particle or exceeded its
    /// speed limit, or because the island cost too much and became a crowd (moved by uniform steps).
    pub redone: u64,
}

impl IslandCounters {
    /// Adds to these counts those counts of `other` that are sums over islands (groups of particles that may meet). The
    /// size of the largest island becomes the greater of both.
    pub fn add(&mut self, other: &Self) {
        let largest = self.largest.max(other.largest);
        for (own, other) in self.sums().into_iter().zip(other.clone().sums()) {
            *own += *other;
        }
        self.largest = largest;
    }

    /// Borrows all counts that are sums over islands (groups of particles that may meet). Each remaining count is
    /// either equal in all processes that share the run, or a maximum.
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

    /// Adds the work of solving one island (group of particles that may meet) once. The work counts also if the result
    /// is not valid.
    pub fn count(&mut self, solved: &Solved) {
        self.events += solved.events;
        self.impulses += solved.impulses;
        self.crowd_steps += solved.crowd_steps;
        self.crowd_forces += solved.crowd_forces;
        self.pair_checks += solved.pair_checks;
        self.force_evaluations += solved.force_evaluations;
        self.updates += solved.updates;
    }

    /// Returns those counts that have the same meaning in all engines.
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
