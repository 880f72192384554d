//! Memory that a run takes, at most, known before any of it is taken.

use crate::experiment::Experiment;
use crate::schedule::Schedule;

/// [byte] per particle: the bound of `tests/memory.rs` for dense scenes of either model.
const PARTICLE: f64 = 350.0;

/// [byte] per slice and block of time: twenty sums, and as much again while averages are made of them (`statistics/profiles.rs`).
const SLICE: f64 = 2.0 * 20.0 * 8.0;

/// Blocks of time at most, however many samples there are (`statistics/profiles.rs`).
const MOST_BLOCKS: f64 = 512.0;

/// Memory that a run takes [byte].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Need {
    /// [byte] of particles, their neighbours and contacts.
    pub particles: f64,
    /// [byte] of averages in slices.
    pub slices: f64,
}

impl Need {
    /// The memory that an experiment takes.
    pub fn of(experiment: &Experiment) -> Self {
        let kinds = experiment.scene.species.len();
        // a mixture has averages of each kind beside those of all
        let tables = if kinds > 1 { 1 + kinds } else { 1 } as f64;
        let samples = Schedule::new(experiment).samples as f64 + 1.0;
        let slices = experiment.statistics.slices as f64;
        Self {
            particles: PARTICLE * experiment.count() as f64,
            slices: SLICE * slices * samples.min(MOST_BLOCKS) * tables,
        }
    }

    /// [byte] of all.
    pub fn total(&self) -> f64 {
        self.particles + self.slices
    }
}
