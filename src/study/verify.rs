//! Option `--verify`: measures the change of the results if time step and window (time between two exchanges with the
//! gas) are halved.

use crate::experiment::{AverageFrom, Experiment, HardStepping, TimeStep};
use crate::outcome::Outcome;
use crate::output::{Halved, HalvedStep, Verification};
use crate::particles::Particles;
use crate::runs::{Checkpointer, Progress, ResumableRun, StudyError, execute, execute_with_checkpoints};
use crate::schedule::Schedule;
use crate::statistics::Estimate;
use std::convert::Infallible;

/// Length of the run divided by that of each of the two parts of the test. The first part has the settings of the run.
/// The second part has half the step, and costs at most twice as much. The whole test thus takes up to three
/// fifteenths of the cost of the run.
const PARTS: f64 = 15.0;

/// Number of samples (instants of measurement) in each part of the test. With so many samples, averages over intervals
/// of time give a standard error.
const SAMPLES: f64 = 48.0;

/// Continues a run from its final state for a fifteenth of its length: once with its settings, and once with half the
/// time step and half the window (time between two exchanges with the gas). `end` has the final state in the order of
/// ids. Contacts in progress begin anew in both continuations. Progress is shown unless `quiet` is true.
pub fn verify(outcome: &Outcome, end: &Particles, quiet: bool) -> HalvedStep {
    let run = |experiment: &Experiment| {
        let progress = Progress::new([experiment], quiet);
        Ok::<_, Infallible>(execute(experiment, end.clone(), &mut [&mut progress.watch(0)]).0)
    };
    let Ok(halved) = halve(outcome, run);
    halved
}

/// Tests a run like [`verify`]. In addition, the checkpointer stores the state of the test, and may stop it.
///
/// # Errors
/// Returns an error if the stored state belongs to another run.
pub(super) fn verify_with_checkpoints(
    outcome: &Outcome,
    end: &Particles,
    quiet: bool,
    checkpointer: &mut Checkpointer,
) -> Result<HalvedStep, StudyError> {
    halve(outcome, |experiment| {
        let progress = Progress::new([experiment], quiet);
        let run = ResumableRun::new(experiment.clone(), end.clone().into())?;
        Ok(execute_with_checkpoints(&run, &mut [&mut progress.watch(0)], checkpointer, None)?.0)
    })
}

/// Continues the run twice, with its settings and with half the time step, and compares the results. The function
/// `run` does one of these runs.
fn halve<E>(outcome: &Outcome, mut run: impl FnMut(&Experiment) -> Result<Outcome, E>) -> Result<HalvedStep, E> {
    if let Some(why) = &outcome.failure {
        return Ok(HalvedStep::Unknown(format!("the run itself stopped early: {why}")));
    }
    let stretch = outcome.simulated_seconds / PARTS;
    if stretch <= 0.0 || outcome.particles == 0 {
        return Ok(HalvedStep::Unknown("nothing was simulated".into()));
    }
    let mut runs = Vec::new();
    for halved in [false, true] {
        let experiment = stretched(outcome, stretch, halved);
        let stretched = run(&experiment)?;
        if let Some(why) = stretched.failure {
            let which = if halved { "at half the step" } else { "as set" };
            return Ok(HalvedStep::Unknown(format!("the stretch {which} stopped early: {why}")));
        }
        runs.push(stretched);
    }
    let quantities = quantities(&runs[0]).into_iter().zip(quantities(&runs[1]));
    let quantities = quantities.filter_map(|((name, unit, as_run), (_, _, halved))| {
        Some(Halved { name, unit, as_run: as_run?, halved: halved? })
    });
    Ok(HalvedStep::Verified(Verification {
        stretch,
        cost: runs.iter().map(|run| run.timing.wall_seconds).sum::<f64>() / outcome.timing.wall_seconds,
        window: runs[0].window,
        time_step: runs[0].time_step,
        quantities: quantities.collect(),
    }))
}

/// Experiment that continues the run for `stretch` [s]. If `halved` is true, time step and window (time between two
/// exchanges with the gas) are half as long.
fn stretched(outcome: &Outcome, stretch: f64, halved: bool) -> Experiment {
    let mut experiment = outcome.experiment.clone();
    let factor = if halved { 0.5 } else { 1.0 };
    // the windows have the length that they have at the end of the run, where the test begins
    let window = Schedule::new(&outcome.experiment).longest().min(stretch);
    experiment.run.duration = stretch;
    experiment.run.average_from = AverageFrom::Time(0.0);
    experiment.run.window = Some(factor * window);
    experiment.statistics.sample_interval = Some((stretch / SAMPLES).max(window));
    experiment.soft.time_step = match experiment.soft.time_step {
        TimeStep::PerContact(steps) => TimeStep::PerContact(steps / factor),
        TimeStep::Fixed(step) => TimeStep::Fixed(step * factor),
    };
    experiment.hard.stepping = match experiment.hard.stepping {
        HardStepping::Events => HardStepping::Events,
        HardStepping::Steps { theta } => HardStepping::Steps { theta: theta * factor },
    };
    let how = if halved { "half the step" } else { "verify" };
    experiment.name = format!("{}, {how}", outcome.experiment.name);
    experiment
}

/// Quantities that are compared between the run with the given time step and the run with half the step. Each has a
/// name, a unit and a value, `None` if unknown.
fn quantities(run: &Outcome) -> [(&'static str, &'static str, Option<Estimate>); 5] {
    let through = run.record.ledger.through(run.energy_at_start);
    let residual = (through > 0.0).then(|| run.energy_residual.over(through));
    [
        ("restitution, pairs", "", run.pair_restitution),
        ("restitution, walls", "", run.wall_restitution),
        ("energy unexplained, of what went through", "", residual),
        ("pair impacts per time", "1/s", run.pair_rate),
        ("granular temperature", "m²/s²", run.temperature),
    ]
}
