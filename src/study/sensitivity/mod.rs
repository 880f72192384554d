//! `diptych sensitivity`: shows in one chart which factors matter most.
//!
//! A factor is a change of the case. Its run is compared with the run of the unchanged case. All runs are done
//! concurrently, and all shifts of observables are judged together.

mod factors;
mod outlook;
mod plan;
mod rotating;
mod weigh;
mod words;

use super::replicas::{pool, replicas};
use super::trust::notes;
use crate::case::describe;
use crate::checkpoint::checksum;
use crate::cli::Sensitivity;
use crate::outcome::Outcome;
use crate::output::sensitivity::{Factor, OmittedFactor, SensitivityRun, SensitivityStudy};
use crate::output::{Folder, OutputError, Provenance, write_sensitivity, write_sensitivity_part};
use crate::runs::{
    CommandOrigin, CommandSettings, Executor, INTERVAL, Ranks, ResumableRun, StudyError, answer, failures, read,
    share_threads, start, tell,
};
use crate::statistics::Answer;
use plan::SensitivityPlan;
use std::path::PathBuf;
use std::time::Instant;

/// Runs a sensitivity study and writes one folder. Returns the answer for all factors together.
///
/// # Errors
/// Bad input, before anything is computed; failures of engines, after everything has been written.
pub fn sensitivity(args: &Sensitivity, ranks: &Ranks) -> Result<Option<Answer>, StudyError> {
    sensitivity_on(args, CommandOrigin::Typed, ranks)
}

/// Begins or resumes a sensitivity study; runs that are over are not run again.
pub(super) fn sensitivity_on(
    args: &Sensitivity,
    origin: CommandOrigin,
    ranks: &Ranks,
) -> Result<Option<Answer>, StudyError> {
    let settings = CommandSettings {
        checkpoint_every: args.keep.checkpoint_every,
        ..CommandSettings::new(origin, "sensitivity", &args.case, &args.output, &args.effort)
    };
    let read = || {
        share_threads(&args.effort, ranks)?;
        read(&args.case, &args.input.with_duration(args.duration.as_ref()))
    };
    let case = ranks.agree(read(), |case| checksum(case.text.as_bytes()))?;
    let (plan, checked) = SensitivityPlan::new(&case, args)?;
    let threads = ranks.count() * ranks.threads(settings.threads);
    if args.plan {
        let said = ranks.is_lead().then(|| outlook::text(&plan, threads));
        return said.transpose()?.map_or(Ok(()), |text| answer(&text)).map(|()| None);
    }
    let Some(mut executor) = Executor::begin::<Outcome>(&settings, &case, &[checked], runs(&plan), ranks)? else {
        return Ok(None);
    };
    if !settings.quiet {
        tell(outlook::line(&plan, threads)?);
    }
    let mut table = SensitivityTable {
        plan: &plan,
        margin: args.margin,
        provenance: settings.provenance(&case, describe(plan.reference())),
        outcomes: plan.runs.iter().map(|_| vec![None; usize::from(plan.replicas)]).collect(),
    };
    run_all(&executor, &mut table)?;
    if !table.is_whole() {
        executor.checkpointer.stop();
        executor.checkpointer.with_remedy(table.write(&executor.folder))?;
        return Err(executor.checkpointer.stop_error("sensitivity"));
    }
    let (report, sentences, overall) = executor.checkpointer.with_remedy(table.write(&executor.folder))?;
    executor.finish(&sentences, &report)?;
    failures(&table.pooled().into_iter().flatten().collect::<Vec<_>>())?;
    Ok(overall)
}

/// All runs of the plan, each with all its replicas.
fn runs(plan: &SensitivityPlan) -> Result<Vec<ResumableRun>, StudyError> {
    let mut runs = Vec::new();
    for planned in &plan.runs {
        for experiment in replicas(&planned.experiment, plan.replicas)? {
            let start = start(&experiment)?;
            runs.push(ResumableRun::new(experiment, start.into())?);
        }
    }
    Ok(runs)
}

/// Does all runs concurrently. If the user stops the command, unfinished runs are stored and left out.
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

/// Outcomes of all runs that are complete.
struct SensitivityTable<'a> {
    plan: &'a SensitivityPlan<'a>,
    margin: f64,
    provenance: Provenance,
    /// Outcomes by run and replica; `None` for an incomplete run.
    outcomes: Vec<Vec<Option<Outcome>>>,
}

impl SensitivityTable<'_> {
    /// True if all runs are complete.
    fn is_whole(&self) -> bool {
        self.outcomes.iter().flatten().all(Option::is_some)
    }

    /// Pooled replicas of each run; `None` for a run of which a replica is incomplete.
    fn pooled(&self) -> Vec<Option<Outcome>> {
        let one = |runs: &Vec<Option<Outcome>>| {
            let runs: Vec<Outcome> = runs.iter().cloned().collect::<Option<_>>()?;
            let (first, others) = runs.split_first()?;
            Some(pool(first.clone(), others.to_vec()).0)
        };
        self.outcomes.iter().map(one).collect()
    }

    /// Writes the results so far, and the summary if all runs are complete. Returns the page, the sentences and the
    /// answer.
    fn write(&self, folder: &Folder) -> Result<(PathBuf, Vec<String>, Option<Answer>), OutputError> {
        let pooled = self.pooled();
        let (factors, waiting) = weigh::factors(self.plan, &pooled, &self.outcomes, self.margin);
        let sentences = words::sentences(&factors, &waiting, self.margin);
        let over: Vec<Outcome> = pooled.into_iter().flatten().collect();
        // notes run by run, because the runs may have different starts on purpose
        let notes: Vec<String> = over.iter().flat_map(|one| notes(std::slice::from_ref(one))).collect();
        let left_out: &[OmittedFactor] = &self.plan.left_out;
        let runs = self.runs();
        let study = SensitivityStudy {
            provenance: &self.provenance,
            margin: self.margin,
            factors: &factors,
            left_out,
            waiting: &waiting,
            runs: &runs,
            sentences: &sentences,
            notes: &notes,
        };
        let write = if self.is_whole() { write_sensitivity } else { write_sensitivity_part };
        let page = write(folder, &study)?;
        let overall = factors.iter().map(|factor: &Factor| factor.answer).max();
        Ok((page, sentences, overall))
    }

    fn runs(&self) -> Vec<SensitivityRun> {
        let one = |(planned, runs): (&plan::PlannedRun, &Vec<Option<Outcome>>)| {
            let over: Vec<&Outcome> = runs.iter().flatten().collect();
            let first = over.first()?;
            Some(SensitivityRun {
                name: planned.experiment.name.clone(),
                set: planned.set.clone(),
                model: planned.experiment.model(),
                replicas: over.len(),
                steady: 2 * over.iter().filter(|run| run.steadiness.steady).count() > over.len(),
                simulated_seconds: first.simulated_seconds,
                wall_seconds: over.iter().map(|run| run.timing.wall_seconds).sum(),
                failure: over.iter().find_map(|run| run.failure.as_ref()).map(ToString::to_string),
            })
        };
        self.plan.runs.iter().zip(&self.outcomes).filter_map(one).collect()
    }
}
