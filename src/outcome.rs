//! What one run of one variant gives: all that outputs need.

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
    /// What was run.
    pub experiment: Experiment,
    /// Why it stopped early, if it did.
    pub failure: Option<Failure>,
    /// Number of particles.
    pub particles: usize,
    /// FNV-1a hash of the initial state: equal for variants that start identically.
    pub initial_state_hash: u64,
    /// FNV-1a hash of the final state.
    pub final_state_hash: u64,
    /// [s] simulated time reached.
    pub simulated_seconds: f64,
    /// Windows done.
    pub windows: u64,
    /// [s] window h.
    pub window: f64,
    /// [s] time between samples.
    pub sample_interval: f64,
    /// [s] soft time step, or step of the stepped hard engine; `None`: collisions at exact instants.
    pub time_step: Option<f64>,
    /// Slice averages.
    pub profiles: ProfileTable,
    /// Of a mixture: averages of each species, and impacts of each pair of kinds.
    pub kinds: KindAverages,
    /// In a pipe: averages in rings about its axis.
    pub rings: RingAverages,
    /// Steady or not.
    pub steadiness: Steadiness,
    /// [-] share of the particles that stay in their layer along y while averages are taken, beyond those that do by chance: 1 of a bed
    /// at rest, 0 of a gas that mixes. `None` where there are too few layers or particles to tell.
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
    /// Realised restitution of pairs over the whole run; `None` without an impact, and without an error where too few intervals
    /// between samples saw one.
    pub pair_restitution: Option<Estimate>,
    /// The same at walls.
    pub wall_restitution: Option<Estimate>,
    /// [m²/s²] granular temperature over the averaging period: a third of the velocities' variance about the mean of each
    /// slice at the same instant.
    pub temperature: Option<Estimate>,
    /// The two rates and the temperature by blocks of time, and what replicas say of their errors.
    #[serde(skip)]
    pub averaged: Averaged,
    /// [J] what the ledger leaves unexplained over the whole run, and how far chance moves that.
    pub energy_residual: Estimate,
    /// [J] kinetic plus elastic energy at the start.
    pub energy_at_start: f64,
    /// [J] kinetic plus elastic energy at the end.
    pub energy_at_end: f64,
    /// Streamwise momentum balance over the averaging period.
    pub balance: Balance,
    /// Stress, contacts per particle and volume fraction over the averaging period.
    pub stress: Stress,
    /// All particles together over time.
    pub series: Series,
    /// The path of every particle, where there are few.
    pub paths: Paths,
    /// Work counts.
    pub counters: Counters,
    /// Wall-clock times.
    pub timing: Timing,
}

impl Outcome {
    /// The time integrators that contacts were stepped with; none for hard spheres and where nothing touched.
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

    /// Overlaps that a Maxwellian gas of this granular temperature would have, between particles or at walls; `None` for hard
    /// spheres, several kinds or sizes of spheres, several surfaces, or nothing averaged.
    pub fn kinetic_theory(&self, wall: bool) -> Option<Overlaps> {
        let experiment = &self.experiment;
        // instants have no overlap
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

/// Averages of single numbers by blocks of time; `None` where nothing was sampled.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Averaged {
    /// [1/s] pair collisions per time.
    pub pair_rate: Option<Batches>,
    /// [1/s] wall collisions per time.
    pub wall_rate: Option<Batches>,
    /// [m²/s²] granular temperature.
    pub temperature: Option<Batches>,
    /// What the scatter between replicas says; `None` of a single run.
    pub replicas: Option<Replicas>,
}

/// Several runs of one variant that differ in their seed, taken together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Replicas {
    /// How many runs.
    pub count: usize,
    /// [-] scatter of averages between the runs over the standard errors that each run tells of itself, root mean square over
    /// the mean velocity, the temperature and the rates: near 1 if these are right. `None` if none of them has errors.
    pub scatter_over_errors: Option<f64>,
}

/// Wall-clock times of one run [s].
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Timing {
    /// [s] everything between the initial state and the last sample.
    pub wall_seconds: f64,
    /// [s] in the engine.
    pub engine: f64,
    /// [s] of that, looking for who may meet whom.
    pub neighbours: f64,
    /// [s] of that, straight flight of all; 0 where it is not a part of its own.
    pub flight: f64,
    /// [s] in drag kicks.
    pub drag: f64,
    /// [s] in sampling.
    pub statistics: f64,
    /// Threads used.
    pub threads: usize,
}
