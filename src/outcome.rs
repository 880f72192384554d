//! The result of one run of one variant: all data that outputs need.

use crate::engine::{Counters, Failure};
use crate::experiment::{Experiment, Integrator, Model};
use crate::observe::{Balance, KindAverages, Paths, RingAverages, Series, Stress};
use crate::predict::contact::{ImpactSpeeds, contacts};
use crate::predict::overlaps::Overlaps;
use crate::record::{Impacts, Record};
use crate::statistics::{Batches, Estimate, ProfileTable, Steadiness};
use serde::Serialize;

/// The result of running one variant, whole or cut short by a failure.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// The experiment that was run.
    pub experiment: Experiment,
    /// Reason why the run stopped early, if it did.
    pub failure: Option<Failure>,
    /// Number of particles.
    pub particles: usize,
    /// FNV-1a hash of the initial state: equal for variants that start identically.
    pub initial_state_hash: u64,
    /// FNV-1a hash of the final state.
    pub final_state_hash: u64,
    /// [s] simulated time reached.
    pub simulated_seconds: f64,
    /// Number of windows done.
    pub windows: u64,
    /// [s] window h.
    pub window: f64,
    /// [s] time between samples.
    pub sample_interval: f64,
    /// [s] soft time step, or step of the stepped hard engine; `None`: collisions at exact instants.
    pub time_step: Option<f64>,
    /// Slice averages.
    pub profiles: ProfileTable,
    /// Averages of each species, and impacts of each pair of kinds, for a mixture.
    pub kinds: KindAverages,
    /// Averages in rings about the axis, for a pipe.
    pub rings: RingAverages,
    /// Result of the test for a steady state.
    pub steadiness: Steadiness,
    /// [-] share of the particles that stay in their layer along y while averages are taken, beyond the share that
    /// does so by chance. It is 1 for a bed at rest and 0 for a gas that mixes. `None` where there are too few layers
    /// or particles to tell.
    pub places_kept: Option<f64>,
    /// Impacts and ledger, whole run.
    pub record: Record,
    /// Impacts between particles that ended in the averaging period.
    pub pairs: Impacts,
    /// Impacts on walls that ended in the averaging period.
    pub walls: Impacts,
    /// [1/s] pair collisions per time over the averaging period.
    pub pair_rate: Option<Estimate>,
    /// [1/s] wall collisions per time over the averaging period.
    pub wall_rate: Option<Estimate>,
    /// Realised restitution of pairs over the whole run. `None` without an impact; without an error where too few
    /// intervals between samples had an impact.
    pub pair_restitution: Option<Estimate>,
    /// Realised restitution at walls over the whole run, as for pairs.
    pub wall_restitution: Option<Estimate>,
    /// [m²/s²] granular temperature over the averaging period: a third of the variance of the velocities about the
    /// mean of each slice at one instant.
    pub temperature: Option<Estimate>,
    /// The two rates and the temperature by blocks of time, and their errors from replicas.
    #[serde(skip)]
    pub averaged: Averaged,
    /// [J] residual of the ledger over the whole run, with the size of its random fluctuations.
    pub energy_residual: Estimate,
    /// [J] kinetic plus elastic energy at the start.
    pub energy_at_start: f64,
    /// [J] kinetic plus elastic energy at the end.
    pub energy_at_end: f64,
    /// Streamwise momentum balance over the averaging period.
    pub balance: Balance,
    /// Stress, contacts per particle and volume fraction over the averaging period.
    pub stress: Stress,
    /// Averages over all particles as functions of time.
    pub series: Series,
    /// Path of every particle, if there are few.
    pub paths: Paths,
    /// Work counts of the engine.
    pub counters: Counters,
    /// Wall-clock times.
    pub timing: Timing,
}

impl Outcome {
    /// Time integrators used for contacts; empty for hard spheres and where nothing touched.
    pub fn integrators(&self) -> Vec<&'static str> {
        if !self.experiment.model().has_contacts() || self.counters.steps == 0 {
            return Vec::new();
        }
        if self.experiment.soft.integrator == Integrator::Rk2 {
            return vec!["second-order Runge-Kutta"];
        }
        let uniform = (self.counters.uniform_steps > 0).then_some("velocity Verlet for all particles");
        let local = self.counters.steps > self.counters.uniform_steps;
        uniform.into_iter().chain(local.then_some("fourth-order Runge-Kutta for those in contact")).collect()
    }

    /// Overlaps that a Maxwellian gas of this granular temperature would have, between particles or at walls. `None`
    /// for hard spheres, several species or sizes of spheres, several surfaces, or without averages.
    pub fn kinetic_theory(&self, wall: bool) -> Option<Overlaps> {
        let experiment = &self.experiment;
        // instantaneous collisions have no overlap
        let law = experiment.law().filter(|_| experiment.model() == Model::Soft)?;
        let temperature = self.temperature?.value;
        let pair = |_, _| ImpactSpeeds::isotropic(2.0 * temperature);
        let kinds = contacts(&experiment.scene, &[self.particles], pair, |_| ImpactSpeeds::isotropic(temperature));
        let mut kinds = kinds.iter().filter(|kind| kind.wall == wall);
        match (kinds.next(), kinds.next(), experiment.scene.species.len()) {
            (Some(kind), None, 1) if !experiment.scene.has_sizes() => Overlaps::of(kind, &law, self.time_step?),
            _ => None,
        }
    }
}

/// Averages of single numbers by blocks of time; `None` where there were no samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Averaged {
    /// [1/s] pair collisions per time.
    pub pair_rate: Option<Batches>,
    /// [1/s] wall collisions per time.
    pub wall_rate: Option<Batches>,
    /// [m²/s²] granular temperature.
    pub temperature: Option<Batches>,
    /// Errors from the scatter between replicas; `None` for a single run.
    pub replicas: Option<Replicas>,
}

/// Several runs of one variant that differ in their seed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Replicas {
    /// Number of runs.
    pub count: usize,
    /// [-] scatter of averages between the runs over the standard errors computed within each run: root mean square
    /// over the mean velocity, the temperature and the rates. It is near 1 if the errors are right. `None` if none of
    /// the averages has errors.
    pub scatter_over_errors: Option<f64>,
}

/// Wall-clock times of one run [s].
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Timing {
    /// [s] total time between the initial state and the last sample.
    pub wall_seconds: f64,
    /// [s] in the engine.
    pub engine: f64,
    /// [s] time of the engine for neighbour search.
    pub neighbours: f64,
    /// [s] time of the engine for straight flight of all particles; 0 where this is not timed separately.
    pub flight: f64,
    /// [s] in drag kicks.
    pub drag: f64,
    /// [s] in sampling.
    pub statistics: f64,
    /// Number of threads.
    pub threads: usize,
}
