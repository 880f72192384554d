//! Number of runs and wall time of a sensitivity study, estimated before the study begins.

use super::plan::SensitivityPlan;
use crate::experiment::Model;
use crate::output::numbers::{counted, quantity};
use crate::runs::{StudyError, span, start};
use crate::study::calibration::timed;
use std::fmt::Write;

/// [-] largest share of a run that is simulated on trial, to estimate the wall time of the run. With many collisions,
/// the trial takes seconds.
const TRIED: f64 = 0.02;

/// Line for the user with the number of runs of the plan and their approximate wall time on `threads` threads.
///
/// # Errors
/// Returns an error if the scene is too crowded to start.
pub fn line(plan: &SensitivityPlan, threads: usize) -> Result<String, StudyError> {
    let runs = plan.runs.len() * usize::from(plan.replicas);
    let replicas = match plan.replicas {
        1 => String::new(),
        replicas => format!(" ({} of each)", counted(usize::from(replicas), "replica")),
    };
    let threads = threads.min(runs).max(1);
    let time = time(plan)? * f64::from(plan.replicas) / threads as f64;
    Ok(format!(
        "{}, {}{replicas} of {}, {} at once: about {}",
        counted(plan.factors.len(), "factor"),
        counted(runs, "run"),
        quantity(plan.reference().run.duration, "s", 3),
        threads,
        span(time)
    ))
}

/// [s] wall time of all runs of the plan on one thread, with one replica (run with one seed) of each. It is estimated
/// from one trial for each collision model that occurs in the plan.
fn time(plan: &SensitivityPlan) -> Result<f64, StudyError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.map_err(|why| StudyError::Input(format!("error: cannot start a thread: {why}")))?;
    let mut times = 0.0;
    for model in [Model::Hard, Model::Soft, Model::Hybrid, Model::Dsmc] {
        let of = || plan.runs.iter().filter(|one| one.experiment.model() == model);
        let Some(first) = of().next() else { continue };
        let start = start(&first.experiment)?;
        let tried = pool.install(|| timed(&first.experiment, &start, TRIED));
        // a trial that fails counts with the wall time until its failure, so the estimate is then too low
        times += of().count() as f64 * tried.seconds;
    }
    Ok(times)
}

/// Text for the user: the factors (changes of the case) with their sizes, the factors that are left out, and the text
/// of [`line`].
///
/// # Errors
/// Returns the errors of [`line`].
pub fn text(plan: &SensitivityPlan, threads: usize) -> Result<String, StudyError> {
    let mut text = String::new();
    let width = plan.factors.iter().map(|factor| factor.name.chars().count()).max().unwrap_or(0);
    for factor in &plan.factors {
        let _ = writeln!(text, "{:width$}  {}  ({})", factor.name, factor.change, factor.why);
    }
    let left_out = plan.left_out.iter().filter(|one| one.why != super::plan::NOT_ASKED);
    for one in left_out {
        let _ = writeln!(text, "left out: {}, as {}", one.name, one.why);
    }
    let _ = writeln!(text, "{}", line(plan, threads)?);
    Ok(text)
}
