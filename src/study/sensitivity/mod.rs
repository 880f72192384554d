//! `diptych sensitivity`: the factors that matter most, in one chart.
//!
//! Every factor is a run of the case with something changed, compared with the case as it is. All runs go on
//! concurrently; all shifts are judged together.

mod factors;
mod outlook;
mod plan;
mod weigh;
mod words;

use super::checkpointer::Checkpointer;
use super::invocation::Invocation;
use super::kept_runs::{ResumableRun, ResumableRuns, help_with};
use super::progress::{INTERVAL, Progress};
use super::ranks::Ranks;
use super::replicas::{pool, replicas};
use super::run_list::{ThreadBudget, beside};
use super::session::{StudyError, failures, read, share_threads, start, warn};
use super::terminal::{answer, conclude, tell};
use super::trust::notes;
use crate::case::describe;
use crate::checkpoint::checksum;
use crate::cli::Sensitivity;
use crate::outcome::Outcome;
use crate::output::sensitivity::{Factor, OmittedFactor, SensitivityRun, SensitivityStudy};
use crate::output::{Folder, Provenance, write_sensitivity, write_sensitivity_part};
use crate::statistics::Answer;
use plan::SensitivityPlan;
use std::path::PathBuf;
use std::sync::Mutex;
use std::time::Instant;

/// Runs a sensitivity study and writes one folder. Returns the answer of all factors together.
///
/// # Errors
/// Bad input before anything is computed; failures of engines after everything has been written.
pub fn sensitivity(args: &Sensitivity, ranks: &Ranks) -> Result<Option<Answer>, StudyError> {
    sensitivity_on(args, &Invocation::First, ranks)
}

/// Begins or resumes a sensitivity study; runs that are over are not run again.
pub(super) fn sensitivity_on(
    args: &Sensitivity,
    occasion: &Invocation,
    ranks: &Ranks,
) -> Result<Option<Answer>, StudyError> {
    let read = || {
        share_threads(&args.effort, ranks)?;
        read(&args.case, &args.input.with_duration(args.duration.as_ref()))
    };
    let case = ranks.agree(read(), |case| checksum(case.text.as_bytes()))?;
    let (plan, checked) = SensitivityPlan::new(&case, args)?;
    let share = ThreadBudget { threads: ranks.threads(args.effort.threads), in_turn: false };
    if args.plan {
        let said = ranks.is_lead().then(|| outlook::text(&plan, ranks.count() * share.threads));
        return said.transpose()?.map_or(Ok(()), |text| answer(&text)).map(|()| None);
    }
    let jobs = jobs(&plan)?;
    if !ranks.is_lead() {
        let place = occasion.place(&args.output, &args.case, "sensitivity");
        let keeper = Checkpointer::of_helper(args.keep.checkpoint_every, occasion, &place)?;
        return help_with((Vec::new(), jobs.iter().map(|job| &job.run).collect()), None, &keeper, share, ranks)
            .map(|()| None);
    }
    let folder = occasion.folder(&args.output, &args.case, "sensitivity")?;
    ranks.announce(share.threads, args.output.quiet);
    warn(std::slice::from_ref(&checked), args.output.quiet);
    let firsts = jobs.iter().filter(|job| job.number == 0).map(|job| job.run.run.clone());
    let mut keeper = Checkpointer::new(args.keep.checkpoint_every, occasion, &folder, &case, firsts.collect())?;
    if !args.output.quiet {
        tell(outlook::line(&plan, ranks.count() * share.threads)?);
    }
    let provenance = occasion.provenance(&case, describe(plan.reference()));
    let mut table = SensitivityTable {
        plan: &plan,
        margin: args.margin,
        provenance: &provenance,
        folder: &folder,
        outcomes: plan.runs.iter().map(|_| vec![None; usize::from(plan.replicas)]).collect(),
    };
    run_all(&jobs, (share, ranks), args.output.quiet, &keeper, &mut table)?;
    if table.outcomes.iter().flatten().any(Option::is_none) {
        keeper.stop();
        keeper.helped(table.write(false))?;
        return Err(keeper.words("sensitivity"));
    }
    let (report, sentences, overall) = keeper.helped(table.write(true))?;
    if !args.output.quiet {
        conclude(&sentences, "Report", &report);
    }
    keeper.done()?;
    failures(&table.pooled().into_iter().flatten().collect::<Vec<_>>())?;
    Ok(overall)
}

/// A run to be done.
struct SensitivityJob {
    /// Index of the run in the plan.
    place: usize,
    /// Index of the replica.
    number: usize,
    run: ResumableRun,
}

/// All runs with all their replicas.
fn jobs(plan: &SensitivityPlan) -> Result<Vec<SensitivityJob>, StudyError> {
    let mut jobs = Vec::new();
    for place in 0..plan.runs.len() {
        for (number, experiment) in replicas(plan.run(place), plan.replicas)?.into_iter().enumerate() {
            let start = start(&experiment)?;
            jobs.push(SensitivityJob { place, number, run: ResumableRun::new(experiment, start.into())? });
        }
    }
    Ok(jobs)
}

/// Does all jobs concurrently. Where the user stops the command, unfinished jobs are stored and left out.
fn run_all(
    jobs: &[SensitivityJob],
    (share, ranks): (ThreadBudget, &Ranks),
    quiet: bool,
    keeper: &Checkpointer,
    table: &mut SensitivityTable,
) -> Result<(), StudyError> {
    let progress = Progress::new(jobs.iter().map(|job| &job.run.experiment), quiet);
    let places: Vec<usize> = (0..jobs.len()).collect();
    let list = jobs.iter().map(|job| &job.run).collect();
    let runs = ResumableRuns {
        shared: Mutex::default(),
        pieces: None,
        runs: list,
        watched: places.clone(),
        keeper,
        progress: &progress,
    };
    let mut written = Instant::now();
    beside(&runs, &places, (share, ranks), |k, result| {
        table.outcomes[jobs[k].place][jobs[k].number] = Some(result?);
        // the results so far are written so that the user can look at them
        if written.elapsed() >= INTERVAL && table.outcomes.iter().flatten().any(Option::is_none) {
            keeper.helped(table.write(false))?;
            written = Instant::now();
        }
        Ok(())
    })
}

/// Outcomes of all runs that are over, and the folder to which they are written.
struct SensitivityTable<'a> {
    plan: &'a SensitivityPlan<'a>,
    margin: f64,
    provenance: &'a Provenance,
    folder: &'a Folder,
    /// Outcomes by run and replica.
    outcomes: Vec<Vec<Option<Outcome>>>,
}

impl SensitivityTable<'_> {
    /// Pooled replicas of each run; `None` for a run that is not over.
    fn pooled(&self) -> Vec<Option<Outcome>> {
        let one = |runs: &Vec<Option<Outcome>>| {
            let runs: Vec<Outcome> = runs.iter().cloned().collect::<Option<_>>()?;
            let (first, others) = runs.split_first()?;
            Some(pool(first.clone(), others.to_vec()).0)
        };
        self.outcomes.iter().map(one).collect()
    }

    /// Writes the results so far; `whole`: all of them, with the summary. Returns the page, the sentences and the
    /// answer.
    fn write(&self, whole: bool) -> Result<(PathBuf, Vec<String>, Option<Answer>), crate::output::OutputError> {
        let pooled = self.pooled();
        let (factors, waiting) = weigh::factors(self.plan, &pooled, &self.outcomes, self.margin);
        let sentences = words::sentences(&factors, &waiting, self.margin);
        let over: Vec<Outcome> = pooled.into_iter().flatten().collect();
        // run by run: runs may differ in their start on purpose
        let notes: Vec<String> = over.iter().flat_map(|one| notes(std::slice::from_ref(one))).collect();
        let left_out: &[OmittedFactor] = &self.plan.left_out;
        let runs = self.runs();
        let study = SensitivityStudy {
            provenance: self.provenance,
            margin: self.margin,
            factors: &factors,
            left_out,
            waiting: &waiting,
            runs: &runs,
            sentences: &sentences,
            notes: &notes,
        };
        let page =
            if whole { write_sensitivity(self.folder, &study) } else { write_sensitivity_part(self.folder, &study) }?;
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
