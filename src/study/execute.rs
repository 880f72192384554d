//! Running one variant from its initial state to its outcome.

use crate::clock::Clock;
use crate::engine::Failure;
use crate::experiment::{AverageFrom, Experiment, Model, SoftStepping};
use crate::outcome::{Balance, Outcome, Timing};
use crate::particles::Particles;
use crate::record::{Impacts, Ledger, Record};
use crate::schedule::Schedule;
use crate::simulation::{Simulation, soft_step};
use crate::statistics::{Accumulator, Estimate, FEWEST_BLOCKS, estimate, granular_temperature, judge};
use std::time::Instant;

/// How far a run has come.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// Name of the variant.
    pub name: &'a str,
    /// [s] simulated so far.
    pub time: f64,
    /// [s] to be simulated.
    pub duration: f64,
}

/// Quantities of the whole domain at the samples, and what was added up between them.
#[derive(Default)]
struct Series {
    times: Vec<f64>,
    /// [m/s] mean streamwise velocity.
    velocity: Vec<f64>,
    /// [m²/s²] mean square of the velocity about that mean: drifts as long as the agitation or the profile does.
    agitation: Vec<f64>,
    drag: Vec<f64>,
    wall: Vec<f64>,
    pairs: Vec<f64>,
    walls: Vec<f64>,
    /// [m²/s²] granular temperature.
    temperature: Vec<f64>,
    /// [J] what the ledger leaves unexplained.
    residual: Vec<f64>,
    pair_squares: Vec<Squares>,
    wall_squares: Vec<Squares>,
}

/// Squared normal speeds of the impacts of an interval, summed [m²/s²].
#[derive(Clone, Copy)]
struct Squares {
    approach: f64,
    rebound: f64,
}

impl Squares {
    fn of(impacts: &Impacts) -> Self {
        Self { approach: impacts.normal_speed.sum_of_squares, rebound: impacts.rebound_squares }
    }

    fn since(self, before: Self) -> Self {
        Self { approach: self.approach - before.approach, rebound: self.rebound - before.rebound }
    }
}

/// What had happened by then, kept where averaging begins or may turn out to have begun.
struct Marks {
    /// [samples] between two marks; 0: one, at the time asked for.
    every: u64,
    /// [s] the last that may be the start.
    until: f64,
    /// Time [s], impacts between particles, impacts on walls.
    taken: Vec<(f64, Impacts, Impacts)>,
}

impl Marks {
    /// A start that is found is found to a fortieth of the run, in its first half (see [`judge`]).
    fn new(experiment: &Experiment, samples: u64) -> Self {
        let (every, until) = match experiment.run.average_from {
            AverageFrom::Time(from) => (0, from),
            AverageFrom::Steady => ((samples / 40).max(1), 0.5 * experiment.run.duration),
        };
        Self { every, until, taken: Vec::new() }
    }

    fn look(&mut self, sample: u64, simulation: &Simulation) {
        let time = simulation.time;
        let due = match self.every {
            0 => self.taken.is_empty() && time >= self.until * (1.0 - 1e-9), // rounding of a sum of windows
            every => sample.is_multiple_of(every) && time <= self.until,
        };
        if due {
            self.taken.push((time, simulation.record.pairs.clone(), simulation.record.walls.clone()));
        }
    }

    /// Impacts between particles and on walls since averaging began at `from` [s], or at the first mark after it.
    fn since(&self, from: f64, record: &Record) -> (Impacts, Impacts) {
        let begun = self.taken.iter().find(|(time, ..)| *time >= from * (1.0 - 1e-9)).or(self.taken.last());
        match begun {
            Some((_, pairs, walls)) => (record.pairs.since(pairs), record.walls.since(walls)),
            None => Default::default(),
        }
    }
}

/// Runs a variant from `start` to its end or its failure, which is part of the outcome; `progress` is called after every
/// sample. Gives the outcome and the final state in the order of ids.
pub fn execute(
    experiment: &Experiment,
    start: Particles,
    progress: &mut (dyn FnMut(Progress) + Send),
) -> (Outcome, Particles) {
    // from inside the pool: every parallel loop called from outside would put this thread to sleep and wake it again
    rayon::scope(|_| simulate(experiment, start, progress))
}

fn simulate(
    experiment: &Experiment,
    start: Particles,
    progress: &mut (dyn FnMut(Progress) + Send),
) -> (Outcome, Particles) {
    let initial_state_hash = hash(&start);
    let particles = start.len();
    let schedule = Schedule::new(experiment);
    let mut simulation = Simulation::new(experiment, start).with_clock(Clock::wall());
    let energy_at_start = simulation.energy();
    let mut accumulator = Accumulator::new(experiment.statistics.slices, experiment.scene.domain.size.y);
    let mut series = Series::default();
    let began = Instant::now();
    let mut sampling = 0.0;
    let mut failure: Option<Failure> = None;
    let mut marks = Marks::new(experiment, schedule.samples);
    for sample in 0..=schedule.samples {
        if sample > 0 {
            let before = simulation.record.ledger;
            let counts = (simulation.record.pairs.count, simulation.record.walls.count);
            let squares = (Squares::of(&simulation.record.pairs), Squares::of(&simulation.record.walls));
            let energy = simulation.energy();
            if let Err(why) = simulation.run(schedule.windows_per_sample, schedule.window) {
                failure = Some(why);
                break;
            }
            let interval = schedule.windows_per_sample as f64 * schedule.window;
            let after = &simulation.record;
            series.drag.push((after.ledger.drag_impulse.z - before.drag_impulse.z) / interval);
            series.wall.push((after.ledger.wall_impulse.z - before.wall_impulse.z) / interval);
            series.pairs.push((after.pairs.count - counts.0) as f64 / interval);
            series.walls.push((after.walls.count - counts.1) as f64 / interval);
            series.pair_squares.push(Squares::of(&after.pairs).since(squares.0));
            series.wall_squares.push(Squares::of(&after.walls).since(squares.1));
            let unexplained = |ledger: &Ledger, energy: f64| ledger.residual(energy_at_start, energy);
            series.residual.push(unexplained(&after.ledger, simulation.energy()) - unexplained(&before, energy));
        }
        let clock = Instant::now();
        accumulator.sample(simulation.time, &simulation.particles);
        series.observe(&simulation, experiment);
        marks.look(sample, &simulation);
        sampling += clock.elapsed().as_secs_f64();
        progress(Progress { name: &experiment.name, time: simulation.time, duration: experiment.run.duration });
    }
    let wall_seconds = began.elapsed().as_secs_f64();
    let asked = match experiment.run.average_from {
        AverageFrom::Time(from) => Some(from),
        AverageFrom::Steady => None,
    };
    let steadiness = judge(&series.times, &[series.velocity.clone(), series.agitation.clone()], asked);
    // interval k ends at sample k + 1: the first that lies wholly in the averaging period
    let first = series.times.iter().position(|t| *t >= steadiness.from).unwrap_or(series.times.len());
    let averaged = |values: &[f64]| estimate(values.get(first..).unwrap_or_default());
    let balance = balance(&series, first, experiment, &simulation);
    let (pairs, walls) = marks.since(steadiness.from, &simulation.record);
    let (counters, parts) = (simulation.counters(), simulation.engine_spent());
    let outcome = Outcome {
        experiment: experiment.clone(),
        failure,
        particles,
        initial_state_hash,
        final_state_hash: 0,
        simulated_seconds: simulation.time,
        windows: simulation.windows,
        window: schedule.window,
        sample_interval: schedule.window * schedule.windows_per_sample as f64,
        time_step: time_step(experiment, particles, &simulation, schedule.window),
        profiles: accumulator.table(steadiness.from),
        steadiness,
        pair_rate: averaged(&series.pairs),
        wall_rate: averaged(&series.walls),
        pair_restitution: restitution(&series.pair_squares, simulation.record.pairs.count),
        wall_restitution: restitution(&series.wall_squares, simulation.record.walls.count),
        temperature: estimate(series.temperature.get(first..).unwrap_or_default()),
        energy_residual: Estimate {
            value: simulation.record.ledger.residual(energy_at_start, simulation.energy()),
            error: estimate(&series.residual).error * series.residual.len() as f64,
        },
        energy_at_start,
        energy_at_end: simulation.energy(),
        balance,
        counters,
        timing: Timing {
            wall_seconds,
            engine: simulation.spent.engine.as_secs_f64(),
            neighbours: parts.neighbours.as_secs_f64(),
            flight: parts.flight.as_secs_f64(),
            drag: simulation.spent.drag.as_secs_f64(),
            statistics: sampling,
            threads: rayon::current_num_threads(),
        },
        record: simulation.record,
        pairs,
        walls,
    };
    let mut end = simulation.particles;
    for position in &mut end.position {
        *position = experiment.scene.domain.wrap(position);
    }
    end.sort_by_id();
    (Outcome { final_state_hash: hash(&end), ..outcome }, end)
}

/// [s] the step that contacts were resolved with, or that collisions were looked for at; 0 for events.
fn time_step(experiment: &Experiment, particles: usize, simulation: &Simulation, window: f64) -> f64 {
    let steps = simulation.counters().steps;
    match (experiment.model(), experiment.soft.stepping) {
        (Model::Soft, SoftStepping::Uniform) | (Model::Hard, _) if steps > 0 => simulation.time / steps as f64,
        (Model::Soft, _) => soft_step(experiment, particles).min(window),
        (Model::Hard, _) => 0.0,
    }
}

impl Series {
    fn observe(&mut self, simulation: &Simulation, experiment: &Experiment) {
        let velocities = &simulation.particles.velocity;
        let count = velocities.len().max(1) as f64;
        let mean = velocities.iter().sum::<nalgebra::Vector3<f64>>() / count;
        self.times.push(simulation.time);
        self.velocity.push(mean.z);
        self.agitation.push(velocities.iter().map(|v| (v - mean).norm_squared()).sum::<f64>() / count);
        let (slices, height) = (experiment.statistics.slices, experiment.scene.domain.size.y);
        self.temperature.push(granular_temperature(&simulation.particles, slices, height));
    }
}

/// Realised restitution, the root of the normal energy after over before summed over all impacts, and the standard error
/// of that ratio: the scatter over the intervals of what each returns beyond its share, rebound² - e² approach².
fn restitution(intervals: &[Squares], impacts: u64) -> Estimate {
    let sum = |of: fn(&Squares) -> f64| intervals.iter().map(of).sum::<f64>();
    let before = sum(|squares| squares.approach);
    if impacts == 0 || before <= 0.0 {
        return Estimate { value: f64::NAN, error: f64::NAN };
    }
    let square = sum(|squares| squares.rebound) / before;
    let value = square.sqrt();
    let busy = intervals.iter().filter(|squares| squares.approach > 0.0).count();
    if busy < FEWEST_BLOCKS {
        return Estimate { value, error: f64::NAN };
    }
    let beyond: Vec<f64> = intervals.iter().map(|squares| squares.rebound - square * squares.approach).collect();
    // δ(e²) = 2 e δe
    let error = estimate(&beyond).error * intervals.len() as f64 / before / (2.0 * value);
    Estimate { value, error }
}

/// Streamwise forces averaged from sample `first` on.
fn balance(series: &Series, first: usize, experiment: &Experiment, simulation: &Simulation) -> Balance {
    let weight = simulation.particles.mass.iter().sum::<f64>() * experiment.scene.gravity.z;
    let drag = series.drag.get(first..).unwrap_or_default();
    let wall = series.wall.get(first..).unwrap_or_default();
    let sum: Vec<f64> = drag.iter().zip(wall).map(|(d, w)| d + w).collect();
    let sum = estimate(&sum);
    Balance {
        drag: estimate(drag),
        weight,
        wall: estimate(wall),
        residual: Estimate { value: sum.value + weight, error: sum.error },
    }
}

/// FNV-1a over the bits of positions and velocities, in the order of ids.
fn hash(particles: &Particles) -> u64 {
    let mut order: Vec<usize> = (0..particles.len()).collect();
    order.sort_unstable_by_key(|&place| particles.id[place]);
    let mut hash: u64 = 0xcbf2_9ce4_8422_2325; // offset basis, Fowler, Noll & Vo
    for place in order {
        for value in particles.position[place].iter().chain(particles.velocity[place].iter()) {
            for byte in value.to_bits().to_le_bytes() {
                hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3); // prime, Fowler, Noll & Vo
            }
        }
    }
    hash
}
