//! The stretch of a scene with many particles: the piece of simulated time that every method of a chart runs. The
//! stretch is a part of the time over which the case averages.

use super::methods::{FINE_STEPS, MethodParameter, MethodSweep, Values};
use crate::experiment::{AverageFrom, Experiment, HardStepping, Integrator, SoftStepping, Spheres, TimeStep};
use crate::output::numbers::quantity;
use crate::runs::{StudyError, start};
use crate::schedule::Schedule;
use crate::statistics::FEWEST_BLOCKS;
use crate::study::calibration::{agitated, physics, timed};
use std::time::Instant;

/// Number of runs of the reference method, each with a different seed.
pub const STARTS: usize = 8;
/// Number of samples (instants of measurement) in a stretch (piece of simulated time that every method of a chart
/// runs). With so many samples, averages get standard errors.
pub const SAMPLES: f64 = 60.0;
/// Averaging time of the case divided by the length of a stretch (piece of simulated time that every method of a chart
/// runs). A chart has dozens of runs of this length, which take minutes if the case takes seconds.
const PARTS: f64 = 10.0;
/// Averaging time of the case divided by the length of a stretch (piece of simulated time that every method runs), with
/// the option `--quick`.
const QUICK_PARTS: f64 = 100.0;
/// [-] share of a run that is timed to estimate the wall time of the whole run.
const TRIAL: f64 = 0.02;

/// [-] relative tolerance of the search for the shortest duration. A duration that exceeds a number of three digits by
/// less than this is rounded down to it, not up.
const ROUNDING: f64 = 1e-9;
/// [-] longest duration tried in the search for the shortest duration with error bars, divided by the duration of the
/// case. The search needs trials of longer and longer durations, because windows (times between two exchanges with the
/// gas) grow with the duration.
const LONGEST: f64 = 1e6;

/// Piece of the simulated time of a case that every method of a chart runs.
pub struct Stretch {
    /// Experiment of the stretch (piece of simulated time), which all methods run from a common initial state.
    pub experiment: Experiment,
    /// [s] simulated time of the case before the stretch (piece of time that every method runs). The reference method
    /// runs this time once for each seed.
    pub before: f64,
    /// [s] length of a window, the time between two exchanges of momentum with the gas; at most as long as the stretch.
    pub window: f64,
}

impl Stretch {
    /// Values over which the parameters of the methods are swept; fewer and coarser values if `quick` is true.
    pub fn values(quick: bool) -> Values {
        let of = |long: &[f64], short: &[f64]| if quick { short.to_vec() } else { long.to_vec() };
        Values {
            steps_per_contact: of(&[2.5, 5.0, 7.5, 10.0, 20.0, 40.0], &[5.0, 10.0, 20.0]),
            stiffness: of(&[1e-5, 1e-3, 0.01, 0.1, 1.0, 10.0], &[1e-5, 0.01, 1.0]),
            theta: of(&[0.3, 0.1, 0.03, 0.01, 3e-3], &[0.3, 0.1, 0.03]),
            windows: of(&[32.0, 8.0, 2.0, 0.5], &[8.0, 1.0]),
        }
    }

    /// Piece of the averaging time of the case `base` that every method of the chart runs; a shorter piece if `quick`
    /// is true.
    ///
    /// # Errors
    /// Returns an error if the averaging time of the case is zero.
    pub fn of(base: &Experiment, quick: bool) -> Result<Self, StudyError> {
        let duration = base.run.duration;
        let before = match base.run.average_from {
            AverageFrom::Time(from) => from.min(duration),
            AverageFrom::Steady => 0.5 * duration,
        };
        let stretch = (duration - before) / if quick { QUICK_PARTS } else { PARTS };
        if stretch <= 0.0 {
            let what = "the case averages over no time, so there is nothing to chart";
            return Err(StudyError::Input(format!(
                "error: {what}\nhelp: give `run.duration` more than `run.average_from`"
            )));
        }
        let window = Schedule::new(base).window.min(stretch);
        let mut experiment = base.clone();
        experiment.run.duration = stretch;
        experiment.run.average_from = AverageFrom::Time(0.0);
        experiment.run.window = Some(window);
        experiment.statistics.sample_interval = Some((stretch / SAMPLES).max(window));
        Ok(Self { experiment, before, window })
    }

    /// Methods that may serve as the reference of the chart, each as an experiment with a description. The second one
    /// is used if the engine of the first one fails. There is no second one if the case has no contact law.
    pub fn ways(&self) -> Vec<(Experiment, &'static str)> {
        let mut hard = self.experiment.clone();
        hard.run.spheres = Spheres::Hard;
        hard.hard.stepping = HardStepping::Events;
        let mut ways = vec![(hard, "hard spheres at exact instants")];
        if let Some(law) = self.experiment.soft.law {
            let mut soft = self.experiment.clone();
            soft.run.spheres = Spheres::Soft(law);
            soft.soft.stepping = SoftStepping::Local;
            soft.soft.integrator = Integrator::VelocityVerlet;
            soft.soft.time_step = TimeStep::PerContact(FINE_STEPS);
            ways.push((soft, "soft spheres, local fourth-order steps, N_c = 50"));
        }
        ways
    }

    /// Methods that can run the scene, each with the values of its parameter. Windows (times between two exchanges with
    /// the gas) are left out if they are so long that a run has too few of them for error bars. If `quick` is true,
    /// each parameter has fewer values.
    pub fn sweeps(&self, quick: bool) -> Vec<MethodSweep> {
        let window = Schedule::new(&self.experiment).window;
        let longest = window.max(self.experiment.run.duration / FEWEST_BLOCKS as f64);
        let mut sweeps = MethodSweep::all(&self.experiment, window, &Self::values(quick));
        for sweep in sweeps.iter_mut().filter(|sweep| sweep.knob == MethodParameter::Window) {
            sweep.values.retain(|&value| value <= longest);
        }
        sweeps
    }

    /// Experiment of one method at the value `value` (SI unit) of its swept parameter. The time between samples
    /// (instants of measurement) is at least one window (time between two exchanges with the gas).
    pub fn run_of(&self, sweep: &MethodSweep, value: f64) -> Experiment {
        let mut experiment = sweep.experiment(&self.experiment, value);
        if let (Some(window), Some(interval)) = (experiment.run.window, experiment.statistics.sample_interval) {
            experiment.statistics.sample_interval = Some(interval.max(window));
        }
        experiment
    }

    /// [s] expected wall time of every run, from a trial of each: first the runs of the reference, then the points of
    /// all methods. In a surrounding gas, the trial starts with the velocity fluctuations that the gas causes.
    ///
    /// # Errors
    /// Returns an error if the particles cannot be placed.
    pub fn expected(&self, base: &Experiment, sweeps: &[MethodSweep]) -> Result<Vec<f64>, StudyError> {
        let driven = base.scene.fluid.is_some().then(|| physics(base)).flatten();
        let moved = driven.map_or_else(|| base.clone(), |found| agitated(base, &found.temperatures));
        let clock = Instant::now();
        let particles = start(&moved)?;
        let placing = clock.elapsed().as_secs_f64();
        let trial = |experiment: &Experiment| timed(experiment, &particles, TRIAL);
        let ways = self.ways();
        // as in the chart, the second method is used if the first fails
        let mut trials = ways.into_iter().map(|(mut way, _)| {
            way.run.duration = STARTS as f64 * (self.before + way.run.duration);
            trial(&way)
        });
        let references = trials.find(|trial| trial.failure.is_none()).map_or(0.0, |trial| trial.seconds);
        let mut expected = vec![placing + references / STARTS as f64; STARTS];
        for sweep in sweeps {
            expected.extend(sweep.values.iter().map(|&value| trial(&self.run_of(sweep, value)).seconds));
        }
        Ok(expected)
    }

    /// Message for the reader if a stretch (piece of time that every method runs) has too few samples (instants of
    /// measurement) for error bars. It names the shortest `run.duration` of the case `base` with enough samples. `None`
    /// if there are enough samples.
    pub fn shortfall(&self, base: &Experiment, quick: bool) -> Option<String> {
        let samples = Schedule::new(&self.experiment).samples;
        if samples >= FEWEST_BLOCKS as u64 {
            return None;
        }
        let alone = shortest(base, quick).map(|duration| format!("--set run.duration=\"{duration} s\""));
        let remedy = alone.or_else(|| {
            // unless the case gives `run.window`, windows grow with the duration; with a fixed window, a longer run
            // has more windows
            let window = rounded(self.window * (1.0 + ROUNDING), f64::floor);
            let mut fixed = base.clone();
            fixed.run.window = Some(window);
            let duration = shortest(&fixed, quick)?;
            Some(format!("--set run.duration=\"{duration} s\" --set run.window=\"{window} s\""))
        });
        let without = quick && Self::of(base, false).is_ok_and(|long| long.has_error_bars());
        let remedies: Vec<String> = remedy.into_iter().chain(without.then(|| "no --quick".to_owned())).collect();
        Some(format!(
            "Too short for error bars of restitution and energy: every run is {}, {samples} samples, and they take {FEWEST_BLOCKS}. \
             The shortest that will do: {}.",
            quantity(self.experiment.run.duration, "s", 3),
            remedies.join("; or ")
        ))
    }

    fn has_error_bars(&self) -> bool {
        Schedule::new(&self.experiment).samples >= FEWEST_BLOCKS as u64
    }
}

/// [s] shortest duration of a case, to three digits, with which the runs of its chart have error bars. `None` if there
/// is no such duration.
fn shortest(base: &Experiment, quick: bool) -> Option<f64> {
    let enough = |duration: f64| {
        let mut longer = base.clone();
        longer.run.duration = duration;
        Stretch::of(&longer, quick).is_ok_and(|stretch| stretch.has_error_bars())
    };
    let (mut short, mut long) = (base.run.duration, 2.0 * base.run.duration);
    while !enough(long) {
        (short, long) = (long, 2.0 * long);
        if long > LONGEST * base.run.duration {
            return None;
        }
    }
    while long > short * (1.0 + 0.1 * ROUNDING) {
        let middle = (short * long).sqrt();
        if enough(middle) { long = middle } else { short = middle }
    }
    let mut duration = rounded(long * (1.0 - ROUNDING), f64::ceil);
    // a run has whole windows, so a slightly longer duration may have one window less
    for _ in 0..100 {
        if enough(duration) {
            return Some(duration);
        }
        duration = rounded(duration * 1.002, f64::ceil);
    }
    None
}

/// Value rounded to three significant digits. The function `how` rounds to a whole number, such as `f64::ceil`.
fn rounded(value: f64, how: fn(f64) -> f64) -> f64 {
    let unit = 10f64.powi(value.log10().floor() as i32 - 2);
    // converted through text, because a product with a power of ten may differ from the nearest number in the last bit
    format!("{:.2e}", how(value / unit) * unit).parse().unwrap_or(value)
}
