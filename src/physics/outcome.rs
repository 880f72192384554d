//! Result of one run: all data that output files and figures need. A case (an input file) describes one or more
//! experiments, its variants. Replicas are runs of one variant with different seeds.

use crate::engine::{Counters, Failure};
use crate::experiment::{Experiment, Integrator, Model};
use crate::observe::{Balance, FlowAverages, GasFlow, KindAverages, Observation, Paths, RingAverages, Series, Stress};
use crate::predict::contact::{ImpactSpeeds, contacts};
use crate::predict::overlaps::Overlaps;
use crate::record::{Impacts, Record};
use crate::statistics::{Batches, Estimate, ProfileTable, Steadiness};
use serde::Serialize;

/// Result of one run of a variant (one of the experiments in a case). A failure may have ended the run early.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// The experiment that was run.
    pub experiment: Experiment,
    /// Reason why the run stopped early; `None` for a complete run.
    pub failure: Option<Failure>,
    /// Number of particles at the end of the run.
    pub particles: usize,
    /// Hash (FNV-1a) of the initial state. Two runs that start from the same particles have the same hash.
    pub initial_state_hash: u64,
    /// Hash (FNV-1a) of the final state.
    pub final_state_hash: u64,
    /// [s] simulated time that the run reached.
    pub simulated_seconds: f64,
    /// Number of completed windows. A window is the time between two exchanges of momentum with the gas.
    pub windows: u64,
    /// [s] length h of a window, the time between two exchanges with the gas; if windows grow, the length of the first.
    pub window: f64,
    /// [s] time between two samples (instants of measurement) of the statistics.
    pub sample_interval: f64,
    /// [s] time step of soft contacts, of stepped hard spheres or of collisions by chance (DSMC); `None` if collisions
    /// are found at exact instants.
    pub time_step: Option<f64>,
    /// Averages over time in slices, the layers of the box between two heights y.
    pub profiles: ProfileTable,
    /// For mixtures: averages of each species, and of the impacts between two species or between a species and a wall.
    pub kinds: KindAverages,
    /// Averages in rings about the axis, for flow in a pipe.
    pub rings: RingAverages,
    /// Result of the test for a steady state, with the time from which averages are taken.
    pub steadiness: Steadiness,
    /// [-] share of the particles that are in the same layer (slice of the height y) at the start and at the end of the
    /// averaging period, beyond the share expected by chance. It is 1 for a bed at rest and 0 for a gas that mixes.
    /// `None` if there are too few layers or particles.
    pub places_kept: Option<f64>,
    /// Impacts of the whole run, and its ledger: the account of all gains and losses of energy and momentum.
    pub record: Record,
    /// Impacts between particles that ended in the averaging period. The instant from which impacts are counted is
    /// stated at [`ImpactSeries::since`](crate::observe::ImpactSeries::since).
    pub pairs: Impacts,
    /// Impacts on walls that ended in the averaging period, counted from the same instant as those between particles.
    pub walls: Impacts,
    /// [1/s] number of collisions between particles per time, over the averaging period; `None` without measurements.
    pub pair_rate: Option<Estimate>,
    /// [1/s] number of collisions with walls per time, over the averaging period; `None` without measurements.
    pub wall_rate: Option<Estimate>,
    /// [-] restitution of impacts between particles, measured over the whole run; `None` without an impact. The
    /// estimate has no standard error if too few intervals between samples (instants of measurement) had an impact.
    pub pair_restitution: Option<Estimate>,
    /// [-] restitution of impacts at walls, measured over the whole run; `None` without an impact at a wall. The
    /// estimate has no standard error if too few intervals between samples (instants of measurement) had such an impact.
    pub wall_restitution: Option<Estimate>,
    /// [m²/s²] granular temperature over the averaging period: a third of the variance of the velocities about the mean
    /// of each slice at the same instant. `None` without samples.
    pub temperature: Option<Estimate>,
    /// Collision rates, temperature and shear stress averaged in blocks of time, from which errors are computed.
    #[serde(skip)]
    pub averaged: Averaged,
    /// [J] residual of the energy balance of the whole run: the change of energy that the work and the losses in the
    /// ledger do not explain. Its standard error follows from its changes between successive samples (instants of
    /// measurement).
    pub energy_residual: Estimate,
    /// [J] kinetic, rotational and elastic energy at the start.
    pub energy_at_start: f64,
    /// [J] kinetic, rotational and elastic energy at the end.
    pub energy_at_end: f64,
    /// Balance of the momentum of the particles along z over the averaging period.
    pub balance: Balance,
    /// Stress, contacts per particle and volume fraction over the averaging period.
    pub stress: Stress,
    /// Averages of the gas over the averaging period with two-way coupling; `None` if particles do not change the gas.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gas: Option<GasFlow>,
    /// Flow of particles through each outlet and inlet; empty in a scene without outlets and inlets.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub flows: Vec<FlowAverages>,
    /// Results of the measurements that the case asks for.
    #[serde(skip)]
    pub observations: Vec<Observation>,
    /// Averages over all particles as functions of time.
    pub series: Series,
    /// Path of every particle; empty for more than [`MOST_FOLLOWED`](crate::schedule::MOST_FOLLOWED) particles and for
    /// scenes with inlets or outlets.
    pub paths: Paths,
    /// Counts of the work done by the engine, such as time steps.
    pub counters: Counters,
    /// Wall-clock times of the parts of the run.
    pub timing: Timing,
}

impl Outcome {
    /// Mean number of particles over the time of the run. It is the number at every instant if the scene has neither
    /// inlets nor outlets.
    pub fn mean_count(&self) -> f64 {
        let points = self.series.rows.iter().filter_map(|row| Some([row.time, row.particles? as f64]));
        let points: Vec<[f64; 2]> = points.collect();
        let pieces = points.windows(2).map(|two| [two[1][0] - two[0][0], 0.5 * (two[0][1] + two[1][1])]);
        let [time, sum] = pieces.fold([0.0; 2], |[time, sum], [piece, mean]| [time + piece, sum + piece * mean]);
        if time > 0.0 { sum / time } else { self.particles as f64 }
    }

    /// Names of the time integrators used for contacts; empty for models without lasting contacts and for runs without
    /// a contact.
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

    /// Predicted overlaps of a Maxwellian gas with the granular temperature of this run: at walls if `wall` is true,
    /// else between particles. `None` for models other than soft spheres, for several species, sizes or surfaces, and
    /// for a run without averages.
    pub fn kinetic_theory(&self, wall: bool) -> Option<Overlaps> {
        let experiment = &self.experiment;
        // the prediction is for soft spheres alone: instantaneous collisions have no overlap
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

/// Averages of some quantities, each with its values in blocks of time, from which the standard error follows. A field
/// is `None` without samples (instants of measurement).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Averaged {
    /// [1/s] number of collisions between particles per time.
    pub pair_rate: Option<Batches>,
    /// [1/s] number of collisions with walls per time.
    pub wall_rate: Option<Batches>,
    /// [m²/s²] granular temperature.
    pub temperature: Option<Batches>,
    /// [Pa] stress that opposes the shear of a sheared box, kinetic plus contact part; `None` without shear.
    pub shear_stress: Option<Batches>,
    /// Number of replicas (runs with different seeds), and a check of the standard errors by the scatter between
    /// replicas. `None` for a single run.
    pub replicas: Option<Replicas>,
}

/// Several runs of one variant (one of the experiments in a case) that differ only in their seed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Replicas {
    /// Number of replicas (runs with different seeds).
    pub count: usize,
    /// [-] scatter of an average between the replicas, divided by its standard error computed within one run. The
    /// number is the root mean square of this ratio over the mean velocity, the temperature and the collision rates.
    /// It is near 1 if the standard errors are right. `None` if no average has an error.
    pub scatter_over_errors: Option<f64>,
}

/// Wall-clock times of one run.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Timing {
    /// [s] total wall-clock time between the initial state and the last sample (instant of measurement).
    pub wall_seconds: f64,
    /// [s] wall-clock time spent in the engine.
    pub engine: f64,
    /// [s] part of the engine's time that was spent on neighbour search.
    pub neighbours: f64,
    /// [s] part of the engine's time that was spent on straight flight of all particles; 0 if it is not timed
    /// separately.
    pub flight: f64,
    /// [s] wall-clock time spent on changes of velocity between windows (times between two exchanges with the gas),
    /// such as those by drag, lift, heat and buoyancy.
    pub drag: f64,
    /// [s] wall-clock time spent on measurements.
    pub statistics: f64,
    /// Number of threads that the run used.
    pub threads: usize,
}
