//! Results of a sensitivity study: the outcomes of its runs, and the files that are made of them. Replicas are runs
//! with different seeds.

use super::plan::{PlannedRun, SensitivityPlan};
use super::{Question, needs, weigh, words};
use crate::outcome::Outcome;
use crate::output::sensitivity::{Factor, OmittedFactor, SensitivityRun, SensitivityStudy};
use crate::output::{Folder, OutputError, Provenance, write_sensitivity, write_sensitivity_part};
use crate::statistics::Answer;
use crate::study::replicas::pool;
use crate::study::trust::notes;
use std::path::PathBuf;

/// Results of a sensitivity study so far: the outcomes of all runs that are complete.
pub struct SensitivityTable<'a> {
    /// Plan of the study, with its runs and factors (changes of the case).
    pub plan: SensitivityPlan<'a>,
    /// Question that the study answers. The sentences of the report depend on it.
    pub question: Question,
    /// [-] margin of equivalence: largest accepted difference, divided by the scale of each observable.
    pub margin: f64,
    /// Title, case and command of the study, for the report.
    pub provenance: Provenance,
    /// Outcomes of all replicas (runs with different seeds): the first index is that of the run in the plan, the second
    /// that of the replica. `None` for a replica that is not complete.
    pub outcomes: Vec<Vec<Option<Outcome>>>,
}

impl SensitivityTable<'_> {
    /// True if all runs of the study are complete, each with all its replicas (runs with different seeds).
    pub fn is_whole(&self) -> bool {
        self.outcomes.iter().flatten().all(Option::is_some)
    }

    /// Outcome of each run, averaged over its replicas (runs with different seeds). `None` if one of the replicas is
    /// not complete.
    pub fn pooled(&self) -> Vec<Option<Outcome>> {
        let one = |runs: &Vec<Option<Outcome>>| {
            let runs: Vec<Outcome> = runs.iter().cloned().collect::<Option<_>>()?;
            let (first, others) = runs.split_first()?;
            Some(pool(first.clone(), others.to_vec()).0)
        };
        self.outcomes.iter().map(one).collect()
    }

    /// Writes the results so far, and the summary if all runs are complete. Returns the path of the page, the
    /// sentences of the conclusion, and one answer for all factors (changes of the case) together; `None` without a
    /// factor.
    pub fn write(&self, folder: &Folder) -> Result<(PathBuf, Vec<String>, Option<Answer>), OutputError> {
        let pooled = self.pooled();
        let (factors, waiting) = weigh::factors(&self.plan, &pooled, &self.outcomes, self.margin);
        let runs = self.runs();
        let sentences = match self.question {
            Question::Sensitivity => words::sentences(&factors, &waiting, self.margin),
            Question::Needs => needs::sentences(&self.plan, &factors, &runs, self.margin),
        };
        let over: Vec<Outcome> = pooled.into_iter().flatten().collect();
        // notes are made for each run separately; a common note would say that the runs do not start from the same
        // state, which may be on purpose
        let notes: Vec<String> = over.iter().flat_map(|one| notes(std::slice::from_ref(one))).collect();
        let left_out: &[OmittedFactor] = &self.plan.left_out;
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

    /// Rows of the table of runs, one for each run of the plan with at least one complete replica (run with one seed).
    pub fn runs(&self) -> Vec<SensitivityRun> {
        let one = |(planned, runs): (&PlannedRun, &Vec<Option<Outcome>>)| {
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
