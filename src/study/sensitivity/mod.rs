//! `diptych sensitivity` shows in one chart which factors have the largest effect; `diptych needs` finds the models
//! (such as friction, rotation or lift) that a scene needs.
//!
//! A factor is a change of the case. The run with this change is compared with the run of the unchanged case; the
//! difference of an observable is its shift. Runs are done concurrently, and all shifts are judged together.

mod factors;
mod needs;
mod outlook;
mod plan;
mod rotating;
mod switches;
mod table;
mod weigh;
mod words;

use super::replicas::replicas;
use crate::case::{Case, Checked, describe};
use crate::checkpoint::checksum;
use crate::cli::Sensitivity;
use crate::outcome::Outcome;
use crate::runs::{
    CommandOrigin, CommandSettings, Executor, INTERVAL, Ranks, ResumableRun, StudyError, answer, failures, read,
    share_threads, start, tell,
};
use crate::statistics::Answer;
use plan::SensitivityPlan;
use std::time::Instant;
use table::SensitivityTable;

/// Question that a study answers by changing a case by one factor at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// Search for the factors with the largest effect on the case as it is.
    Sensitivity,
    /// Search for the models that can be left out without changing the results of the case. The study begins with all
    /// models that the scene can have.
    Needs,
}

impl Question {
    /// Name of the command that answers the question.
    fn command(self) -> &'static str {
        match self {
            Self::Sensitivity => "sensitivity",
            Self::Needs => "needs",
        }
    }

    fn plan<'a>(self, case: &'a Case, args: &Sensitivity) -> Result<(SensitivityPlan<'a>, Checked), StudyError> {
        match self {
            Self::Sensitivity => SensitivityPlan::new(case, args),
            Self::Needs => SensitivityPlan::richest(case, args),
        }
    }
}

/// Begins or resumes a study that answers `question`, and writes its results to one folder. Runs that are complete are
/// not repeated. Returns one answer for all factors (changes of the case) together. `None` without a factor, if only
/// the plan is printed, or in a helper process (any process but the first).
///
/// # Errors
/// Returns an error for bad input, before anything is computed, or for failures of engines, after everything has been
/// written.
pub fn sensitivity(
    args: &Sensitivity,
    question: Question,
    origin: CommandOrigin,
    ranks: &Ranks,
) -> Result<Option<Answer>, StudyError> {
    let settings = CommandSettings {
        checkpoint_every: args.runs.keep.checkpoint_every,
        ..CommandSettings::new(origin, question.command(), &args.case, &args.runs.output, &args.runs.effort)
    };
    let read = || {
        share_threads(&args.runs.effort, ranks)?;
        read(&args.case, &args.runs.input.with_duration(args.runs.duration.as_ref()))
    };
    let case = ranks.agree(read(), |case| checksum(case.text.as_bytes()))?;
    let (plan, checked) = question.plan(&case, args)?;
    let threads = ranks.count() * ranks.threads(settings.threads);
    if args.runs.plan {
        let said = ranks.is_lead().then(|| outlook::text(&plan, threads));
        return said.transpose()?.map_or(Ok(()), |text| answer(&text)).map(|()| None);
    }
    let Some(mut executor) = Executor::begin::<Outcome>(&settings, &case, &[checked], runs(&plan, 0), ranks)? else {
        return Ok(None);
    };
    if !settings.quiet {
        tell(outlook::line(&plan, threads)?);
    }
    let mut table = SensitivityTable {
        question,
        margin: args.runs.margin,
        provenance: settings.provenance(&case, describe(plan.reference())),
        outcomes: plan.runs.iter().map(|_| vec![None; usize::from(plan.replicas)]).collect(),
        plan,
    };
    run_all(&executor, &mut table)?;
    if question == Question::Needs && table.is_whole() {
        needs::confirm(&mut executor, &mut table)?;
    }
    if !table.is_whole() {
        executor.checkpointer.stop();
        executor.checkpointer.with_remedy(table.write(&executor.folder))?;
        return Err(executor.checkpointer.stop_error(question.command()));
    }
    let (report, sentences, overall) = executor.checkpointer.with_remedy(table.write(&executor.folder))?;
    executor.finish(&sentences, &report)?;
    let outcomes: Vec<Outcome> = table.pooled().into_iter().flatten().collect();
    // in `diptych needs`, a run may stop because a model was left out. This is an answer (the model is needed) and no
    // error, so only a failure of the first run is an error
    let of_needs = if question == Question::Needs { 1 } else { outcomes.len() };
    failures(&outcomes[..of_needs.min(outcomes.len())])?;
    Ok(overall)
}

/// Runs of the plan from the index `first` on, each with all its replicas (runs with different seeds).
fn runs(plan: &SensitivityPlan, first: usize) -> Result<Vec<ResumableRun>, StudyError> {
    let mut runs = Vec::new();
    for planned in &plan.runs[first..] {
        for experiment in replicas(&planned.experiment, plan.replicas)? {
            let start = start(&experiment)?;
            runs.push(ResumableRun::new(experiment, start.into())?);
        }
    }
    Ok(runs)
}

/// Does all runs of the plan concurrently. From time to time (every [`INTERVAL`]), the results so far are written. If
/// the user stops the command, the states of incomplete runs are stored, and these runs give no results.
fn run_all(executor: &Executor, table: &mut SensitivityTable) -> Result<(), StudyError> {
    let replicas = usize::from(table.plan.replicas);
    let all: Vec<usize> = (0..replicas * table.plan.runs.len()).collect();
    let mut written = Instant::now();
    executor.concurrently(&all, |index, outcome| {
        table.outcomes[index / replicas][index % replicas] = Some(outcome);
        // results so far are written, so that the user can read them during the study
        if written.elapsed() >= INTERVAL && !table.is_whole() {
            executor.checkpointer.with_remedy(table.write(&executor.folder))?;
            written = Instant::now();
        }
        Ok(())
    })
}
