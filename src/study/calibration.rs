//! Measurements on which a plan (the prediction of `diptych plan`) depends: the agitation (random velocities) of the
//! particles, and the wall time of a window on this machine. A window is the time between two exchanges of momentum
//! with the gas.
//!
//! The agitation is measured in a short run of the case with shorter periodic sides of its box. Numbers of windows and
//! collisions set the length of this run, so this length is the same on every machine. Wall times are measured in a few
//! windows of the case at its full size; no recommendation depends on these times.

use super::trust::granular_temperature;
use crate::contact_law::ContactLaw;
use crate::engine::Failure;
use crate::experiment::{Amount, AverageFrom, Experiment, HardStepping, Model, SoftStepping, Spheres};
use crate::outcome::Outcome;
use crate::particles::Particles;
use crate::placement::initial_state;
use crate::predict::gas::{AgitationSpread, Slice};
use crate::predict::{Calibration, EngineChoice, PredictedCost};
use crate::record::Histogram;
use crate::runs::execute;
use crate::schedule::Schedule;
use crate::simulation::{Simulation, soft_step};
use crate::statistics::{Accumulator, Estimate, NUMBER_DENSITY, SliceRow, UU, VV, WW};
use crate::walls::Wall;
use nalgebra::Vector3;
use std::f64::consts::PI;
use std::time::Instant;

/// Approximate number of particles in the short run that measures the agitation (random velocities). So many particles
/// are enough to measure a velocity distribution.
const PARTICLES: f64 = 500.0;

/// Largest length of the short run that measures the agitation (random velocities). It is the number of particles times
/// the number of windows (times between two exchanges with the gas). The run takes some seconds.
const PARTICLE_WINDOWS: f64 = 4e6;

/// Largest number of collisions in the short run that measures the agitation (random velocities). The number is
/// estimated by kinetic theory from the initial velocities. The run takes some seconds.
const COLLISIONS: f64 = 5e5;

/// [-] smallest width of a periodic side of the box in the short run, divided by the largest particle diameter. Sides
/// are not shortened below this width.
const NARROWEST: f64 = 10.0;

/// Smallest number of impacts from which a distribution of impact speeds is computed. With this number, ten impacts are
/// faster than the 99 % quantile.
const IMPACTS: u64 = 1000;

/// [s] wall time after which the timing of one collision model ends.
const PATIENCE: f64 = 0.4;

/// Largest number of particle steps (time steps times particles) in the timed part of a window (time between two
/// exchanges with the gas). It applies if every time step moves all particles. The timing of such a part takes some
/// tenths of a second.
const STEPS: f64 = 2e7;

/// Agitation (random velocities) and impact speeds of the particles of a case. They are measured in a short run of the
/// case with shorter periodic sides of its box.
pub struct Physics {
    /// Results of the short run that measures the agitation: its length, its collision rates and their errors. The
    /// plan (prediction of `diptych plan`) is made from them.
    pub calibration: Calibration,
    /// [m²/s²] granular temperature of all particles.
    pub variance: f64,
    /// [m²/s²] granular temperature of each species.
    pub temperatures: Vec<f64>,
    /// Velocity variances at different heights between the walls and in different directions, each divided by the mean
    /// over all heights and directions.
    pub spread: AgitationSpread,
    /// [m/s] distribution of the normal speeds of collisions between particles. `None` after too few collisions, or if
    /// gas, heating or lossless impacts keep the temperature constant. With a constant temperature, kinetic theory
    /// gives the speeds.
    pub pair_speeds: Option<Histogram>,
    /// [m/s] distribution of the normal speeds of wall impacts; `None` after too few impacts.
    pub wall_speeds: Option<Histogram>,
}

/// True if the particles form a gas at the start: at least 100 particles, all at random positions, and some of them
/// with random velocities.
pub fn is_gas(experiment: &Experiment) -> bool {
    /// Smallest number of particles that count as a gas. With fewer particles, the collision rate has a relative
    /// statistical error 1/sqrt(N) of more than 10 %.
    const FEWEST: usize = 100;
    let random = |population: &crate::experiment::Population| matches!(population.amount, Amount::Count(_));
    experiment.start.iter().all(random)
        && experiment.start.iter().any(|population| population.mean_fluctuation() > 0.0)
        && experiment.count() >= FEWEST
}

/// [m²/s²] variance of a velocity component at the start, by species index; 0 for a species without random velocities.
pub fn start_variances(experiment: &Experiment) -> Vec<f64> {
    let mut variances = vec![0.0; experiment.scene.species.len()];
    for population in &experiment.start {
        variances[usize::from(population.species)] = population.mean_fluctuation().powi(2);
    }
    variances
}

/// Measures the agitation (random velocities) and the impact speeds in a short run of the case with shorter periodic
/// sides of its box. `None` if the particles do not form a gas, or if the smaller box cannot be filled.
pub fn physics(experiment: &Experiment) -> Option<Physics> {
    if !is_gas(experiment) {
        return None;
    }
    let small = smaller(experiment);
    let start = initial_state(&small).ok()?;
    let drawn = variance_of(&start);
    let (outcome, end) = execute(&small, start, &mut []);
    let found = granular_temperature(&outcome).filter(|found| found.is_finite() && *found > 0.0).unwrap_or(drawn);
    // if nothing drives the particles (no gas, shear, heating or moving wall), collisions leave a share of the
    // temperature in the short run; this share of the temperature of the start is expected
    let variance =
        if is_driven(experiment) { found } else { found / drawn * variance_of(&initial_state(experiment).ok()?) };
    let count = outcome.particles.max(1) as f64;
    let size = small.scene.domain.size;
    let rate = |rate: Option<Estimate>, sides: f64| {
        let rate = rate.map(|rate| rate.times(sides).over(count));
        [rate.map(|rate| rate.value), rate.and_then(|rate| rate.error)]
    };
    let calibration = Calibration {
        particles: outcome.particles,
        simulated: outcome.simulated_seconds,
        steady: outcome.steadiness.steady || conserves(experiment),
        collision_rate: rate(outcome.pair_rate, 2.0),
        wall_rate: rate(outcome.wall_rate, 1.0),
        temperature_error: temperature_error(&outcome),
        averaged: outcome.profiles.until - outcome.profiles.from,
        size: [size.x, size.y, size.z],
        failure: outcome.failure.as_ref().map(ToString::to_string),
    };
    let relative = end.relative_to_flow(&small.scene.domain);
    let temperatures = by_species(&relative, variance, experiment.scene.species.len());
    // with a surrounding gas and walls, the velocity variances are measured in slices across y; otherwise they are
    // assumed to be equal everywhere
    let walled = experiment.scene.fluid.is_some() && !experiment.scene.walls.is_empty();
    let spread = if walled { AgitationSpread::of(&slices(&outcome)) } else { AgitationSpread::even() };
    let enough = |speeds: &Histogram| (speeds.total >= IMPACTS).then(|| speeds.clone());
    let changing = experiment.scene.fluid.is_none() && !experiment.scene.is_heated() && !conserves(experiment);
    let pair_speeds = enough(&outcome.record.pairs.normal_speed).filter(|_| changing);
    let wall_speeds = enough(&outcome.record.walls.normal_speed);
    Some(Physics { calibration, variance, temperatures, spread, pair_speeds, wall_speeds })
}

/// Slices of the box between two flat walls: each with its share of the particles, its share of the height, and the
/// variances of the three velocity components. The share of the height counts only heights that the centres of
/// particles can have: those at least half the largest diameter away from both walls.
fn slices(outcome: &Outcome) -> Vec<Slice> {
    let scene = &outcome.experiment.scene;
    let height = scene.domain.size.y;
    let radius = 0.5 * scene.largest_diameter();
    let width = height / outcome.profiles.slices.len().max(1) as f64;
    let one = |row: &SliceRow| {
        let (low, high) = ((row.y - 0.5 * width).max(radius), (row.y + 0.5 * width).min(height - radius));
        // streamwise, wall-normal and spanwise components are along z, y, x
        let variance = |column| Some(row.of(column)?.value.max(0.0));
        Some(Slice {
            particles: row.of(NUMBER_DENSITY)?.value * width / height,
            room: (high - low).max(0.0) / (height - 2.0 * radius),
            variance: [variance(WW)?, variance(VV)?, variance(UU)?],
        })
    };
    outcome.profiles.slices.iter().filter_map(one).collect()
}

/// [m²/s²] granular temperature: variance of the velocities about their mean, averaged over the three components.
pub fn variance_of(particles: &Particles) -> f64 {
    let count = particles.len().max(1) as f64;
    let mean = particles.velocity.iter().sum::<Vector3<f64>>() / count;
    particles.velocity.iter().map(|v| (v - mean).norm_squared()).sum::<f64>() / (3.0 * count)
}

/// True if a gas, a shear of the box, a thermostat, thermal walls, or walls whose surface or shape moves drive the
/// particles.
fn is_driven(experiment: &Experiment) -> bool {
    let scene = &experiment.scene;
    let moves = scene.walls.iter().any(Wall::surface_moves);
    scene.fluid.is_some() || scene.domain.shear.is_some() || scene.is_heated() || moves
}

/// True if no gas, gravity, shear, heating or wall whose shape moves acts on the particles, and all impacts are
/// elastic and frictionless. The kinetic energy then stays constant from the start.
fn conserves(experiment: &Experiment) -> bool {
    let scene = &experiment.scene;
    let surfaces = scene.surfaces(2);
    let mut lossless = surfaces.iter().map(|surface| surface.restitution == 1.0 && surface.friction == 0.0);
    let is_left_alone = !is_driven(experiment) && scene.gravity.norm() == 0.0;
    is_left_alone && lossless.all(|lossless| lossless)
}

/// Copy of the case with shorter periodic sides of its box, so with fewer particles at equal number density. The
/// spheres are hard, and the duration is so short that the run takes some seconds.
fn smaller(experiment: &Experiment) -> Experiment {
    let mut small = experiment.clone();
    let count: usize = experiment.count();
    let domain = &mut small.scene.domain;
    let axes = domain.periodic.iter().filter(|periodic| **periodic).count();
    let diameter = experiment.scene.largest_diameter();
    // a box that contains a body or an opening is not shortened, since the body or opening would then be at another
    // position in the box
    let flat = experiment.scene.walls.iter().all(|wall| wall.geometry.is_flat());
    let open = experiment.scene.has_openings();
    if axes > 0 && flat && !open && count as f64 > PARTICLES {
        let factor = (PARTICLES / count as f64).powf(1.0 / axes as f64);
        let size = Vector3::from_fn(|axis, _| {
            let side = domain.size[axis];
            if domain.periodic[axis] { (side * factor).max(NARROWEST * diameter).min(side) } else { side }
        });
        *domain = domain.resized(size);
    }
    let share = small.scene.domain.volume() / experiment.scene.domain.volume();
    let mut left = 0.0;
    let mut collisions = 0.0;
    for population in &mut small.start {
        let n = (population.amount.count() as f64 * share).round().max(1.0);
        population.amount = Amount::Count(n as usize);
        left += n;
        let density = n / small.scene.domain.volume();
        // kinetic theory: the collision rate per volume is 2 n² d² sqrt(π T), with number density n, diameter d and
        // granular temperature T
        collisions += n * 2.0 * density * diameter * diameter * PI.sqrt() * population.mean_fluctuation();
    }
    let window = Schedule::new(experiment).window;
    let affordable = (PARTICLE_WINDOWS / left * window).min(COLLISIONS / collisions);
    small.run.spheres = Spheres::Hard;
    small.hard.stepping = HardStepping::Events;
    small.run.window = Some(window);
    small.run.duration = experiment.run.duration.min(affordable);
    small.statistics.sample_interval = None;
    // gas and shear lead to a steady state, whose agitation is not that of the start
    let is_stirred = experiment.scene.fluid.is_some() || experiment.scene.domain.shear.is_some();
    small.run.average_from = if is_stirred { AverageFrom::Steady } else { AverageFrom::Time(0.0) };
    small
}

/// [m²/s²] granular temperature of each species, by species index. `variance` [m²/s²] is the mean of these temperatures
/// over all particles. The ratios of the temperatures are taken from the particles `end`.
fn by_species(end: &Particles, variance: f64, species: usize) -> Vec<f64> {
    let mean = end.velocity.iter().sum::<Vector3<f64>>() / end.len().max(1) as f64;
    let mut sums = vec![(0.0, 0.0); species];
    let mut all = 0.0;
    for (velocity, &which) in end.velocity.iter().zip(&end.species) {
        let square = (velocity - mean).norm_squared();
        let (sum, count) = &mut sums[usize::from(which)];
        *sum += square;
        *count += 1.0;
        all += square / end.len() as f64;
    }
    let share = |&(sum, count): &(f64, f64)| if count > 0.0 && all > 0.0 { sum / count / all } else { 0.0 };
    sums.iter().map(|sums| variance * share(sums)).collect()
}

/// [-] standard error of the granular temperature in a slice of the box across y, divided by the temperature. The
/// result is the median over all slices. `None` if no slice has a standard error.
fn temperature_error(outcome: &Outcome) -> Option<f64> {
    let relative = |row: &SliceRow| {
        let parts: Vec<Estimate> = [UU, VV, WW].into_iter().map(|column| row.of(column)).collect::<Option<_>>()?;
        let errors: Vec<f64> = parts.iter().map(|part| part.error).collect::<Option<_>>()?;
        let error = errors.iter().map(|error| error * error).sum::<f64>().sqrt();
        Some(error / parts.iter().map(|part| part.value).sum::<f64>())
    };
    let errors = outcome.profiles.slices.iter().filter_map(relative);
    let mut errors: Vec<f64> = errors.filter(|error| error.is_finite() && *error > 0.0).collect();
    errors.sort_by(f64::total_cmp);
    errors.get(errors.len() / 2).copied()
}

/// Copy of the experiment with the collision model and the time stepping of `choice`. Soft and hybrid spheres get the
/// contact law `law` or, if `law` is `None`, that of the case. The result is `None` if they need a contact law and
/// neither gives one. It is also `None` if the scene has walls that the model cannot have. These are servo walls (which
/// move to keep the pressure on them) for hard spheres, all moving walls for collisions by chance (DSMC), and thermal
/// walls for soft and hybrid spheres.
pub fn with_choice(experiment: &Experiment, choice: EngineChoice, law: Option<ContactLaw>) -> Option<Experiment> {
    let scene = &experiment.scene;
    let is_refused = match choice {
        EngineChoice::Hard => scene.has_servo_walls(),
        EngineChoice::Dsmc => scene.has_moving_walls(),
        EngineChoice::SoftLocal | EngineChoice::SoftUniform | EngineChoice::Hybrid => scene.has_thermal_walls(),
    };
    if is_refused {
        return None;
    }
    let mut chosen = experiment.clone();
    chosen.soft.law = law.or(experiment.soft.law);
    match choice {
        EngineChoice::Hard => {
            chosen.run.spheres = Spheres::Hard;
            chosen.hard.stepping = HardStepping::Events;
        }
        EngineChoice::Dsmc => chosen.run.spheres = Spheres::Dsmc,
        EngineChoice::Hybrid => chosen.run.spheres = Spheres::Hybrid(chosen.soft.law?),
        EngineChoice::SoftLocal | EngineChoice::SoftUniform => {
            chosen.run.spheres = Spheres::Soft(chosen.soft.law?);
            chosen.soft.stepping =
                if choice == EngineChoice::SoftLocal { SoftStepping::Local } else { SoftStepping::Uniform };
        }
    }
    Some(chosen)
}

/// Result of timing some windows (times between two exchanges with the gas) of a run, with the wall time of the whole
/// run extrapolated from these windows.
pub struct Timed {
    /// [s] extrapolated wall time of the whole run; if the run failed, wall time until the failure.
    pub seconds: f64,
    /// Number of timed windows (times between two exchanges with the gas), counting a window that was timed in part.
    pub windows: u64,
    /// [byte] memory of this process at the end of the timed part of the run; `None` if the system does not report it.
    pub memory: Option<f64>,
    /// Reason why the engine stopped during the timed part of the run; `None` if it did not stop.
    pub failure: Option<Failure>,
}

/// Predicted wall time and memory of each collision model. Each prediction comes from the timing of some windows (times
/// between two exchanges with the gas), which begin with the particles `start`. Soft and hybrid spheres have the
/// contact law `law`. Models that cannot run the scene are left out.
pub fn costs(experiment: &Experiment, start: &Particles, law: Option<ContactLaw>) -> Vec<PredictedCost> {
    EngineChoice::ALL
        .into_iter()
        .filter_map(|choice| {
            let timed = timed(&with_choice(experiment, choice, law)?, start, 1.0);
            Some(PredictedCost {
                model: choice,
                wall_seconds: Some(timed.seconds).filter(|wall| timed.failure.is_none() && wall.is_finite()),
                windows_timed: timed.windows,
                memory: timed.memory.map(|bytes| bytes - start.len() as f64 * BYTES + REPORT),
                failure: timed.failure.map(|why| why.to_string()),
            })
        })
        .collect()
}

/// Times some windows (times between two exchanges with the gas) of a run that begins with the particles `start`, and
/// extrapolates to the whole run. The timing ends after the share `most` [-] of the run, or after the wall time
/// `PATIENCE`, whichever comes first. Other programs on the machine slow the timing down as they would slow down the
/// run. A run without windows takes no time.
pub fn timed(experiment: &Experiment, start: &Particles, most: f64) -> Timed {
    let schedule = Schedule::new(experiment);
    let windows = schedule.windows_per_sample as f64 * schedule.samples as f64;
    if windows == 0.0 || schedule.window == 0.0 {
        return Timed { seconds: 0.0, windows: 0, memory: resident(), failure: None };
    }
    let mut simulation = Simulation::new(experiment, start.clone());
    let parts = match (experiment.model(), experiment.soft.stepping) {
        // with uniform steps all parts of a window cost equally much, so it is enough to time a part of the window
        (Model::Soft, SoftStepping::Uniform) => {
            let steps = (schedule.window / soft_step(experiment, start.len())).max(1.0);
            (steps * start.len() as f64 / STEPS).ceil().clamp(1.0, steps)
        }
        (Model::Soft, SoftStepping::Local | SoftStepping::Auto) | (Model::Hard | Model::Hybrid | Model::Dsmc, _) => {
            (schedule.window / short_enough(experiment, start, schedule.window)).ceil()
        }
    };
    let part = schedule.window / parts;
    let total = windows * parts;
    let most = (most * total).max(3.0).min(total).ceil();
    let clock = Instant::now();
    let (mut timed, mut batch, mut seconds) = (0.0, 1.0_f64, 0.0);
    // the first window is not counted if more windows follow, because it also creates lists and tables
    let mut first = (0.0, 0.0);
    let mut failure = None;
    while timed < most && seconds < PATIENCE {
        let windows = batch.min(most - timed);
        if let Err(why) = simulation.run(windows as u64, part) {
            failure = Some(why);
            break;
        }
        timed += windows;
        seconds = clock.elapsed().as_secs_f64();
        if first.0 == 0.0 {
            first = (timed, seconds);
        }
        batch *= 2.0;
    }
    let rest = if timed < total && timed > first.0 { (timed - first.0, seconds - first.1) } else { (timed, seconds) };
    let sampling = sampling(experiment, &simulation.particles);
    let whole = rest.1 / rest.0 * total + sampling * schedule.samples as f64;
    Timed {
        seconds: if failure.is_some() { clock.elapsed().as_secs_f64() } else { whole },
        windows: (timed / parts).ceil() as u64,
        memory: resident(),
        failure,
    }
}

/// [s] length of a part of a window (time between two exchanges with the gas) that takes little wall time to compute.
/// Such a part is timed, because a long window may contain any number of impacts. The length is found by trials. The
/// first trial simulates ten times the time in which the fastest particle moves by the largest diameter. Each further
/// trial is twice as long, until a trial fails or takes too much wall time. The result is at most `window` [s].
fn short_enough(experiment: &Experiment, start: &Particles, window: f64) -> f64 {
    let diameter = 2.0 * start.radius.iter().copied().fold(0.0, f64::max);
    let speed = start.largest_speed(Vector3::zeros()) + (experiment.scene.gravity.norm() * diameter).sqrt();
    let mut part = 10.0 * diameter / speed;
    if part.is_nan() || part >= window {
        return window;
    }
    let clock = Instant::now();
    let mut trial = Simulation::new(experiment, start.clone());
    while part < window {
        if trial.run(1, part).is_err() || clock.elapsed().as_secs_f64() > 0.1 * PATIENCE {
            return part;
        }
        part *= 2.0;
    }
    window
}

/// [byte] memory for the figures and the page of one variant (experiment of a case). They are made after the run, so
/// the timing does not include them. The value was measured on the built-in cases.
const REPORT: f64 = 0.5e6;

/// [byte] memory of the data of one particle: position, velocity, radius, mass, species, id.
const BYTES: f64 = 8.0 * 8.0 + 2.0 + 4.0;

/// [s] wall time of one sample (instant of measurement) of the statistics. At a sample, the velocities of all
/// particles are added to the averages over slices of the box across y.
fn sampling(experiment: &Experiment, particles: &Particles) -> f64 {
    let mut accumulator = Accumulator::new(experiment.statistics.slices, experiment.scene.domain.size.y);
    let clock = Instant::now();
    accumulator.sample(0.0, particles);
    clock.elapsed().as_secs_f64()
}

/// [byte] memory that this process uses now, from the line VmRSS of /proc/self/status on Linux. `None` on a system
/// without this file.
fn resident() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kibibytes: f64 = line.split_whitespace().next()?.parse().ok()?;
    Some(1024.0 * kibibytes)
}

/// Copy of the experiment in which all windows (times between two exchanges with the gas) have equal length. If the
/// case has a surrounding gas, each species starts with random velocities of the granular temperature `temperatures`
/// [m²/s²], listed by species index.
pub fn agitated(experiment: &Experiment, temperatures: &[f64]) -> Experiment {
    let mut moved = experiment.clone();
    for population in moved.start.iter_mut().filter(|_| experiment.scene.fluid.is_some()) {
        if let Some(variance) = temperatures.get(usize::from(population.species)) {
            population.velocity_fluctuation = nalgebra::Vector3::repeat(variance.sqrt());
        }
    }
    moved.run.window = Some(Schedule::new(experiment).window);
    moved
}
