//! Variants of a case that are run one after the other, each with its replicas (runs with different seeds): the list of
//! their runs, and their results. A variant is one of the experiments of a case.

use super::replicas::replicas;
use super::trust_sheet::trust_sheet;
use super::verify::verify_with_checkpoints;
use crate::case::{Case, Checked};
use crate::communicator::Communicator;
use crate::experiment::{Experiment, Trajectories};
use crate::observe::{Budgets, Frames, Observer};
use crate::outcome::Outcome;
use crate::output::numbers::counted;
use crate::output::{Folder, HalvedStep, Provenance, Study, TrustSheet, Verdict, figures, write_part, write_study};
use crate::particles::Particles;
use crate::placement::{Crowded, Start};
use crate::runs::{
    CommandSettings, Executor, Ranks, ResumableRun, StudyError, failures, mark_of_experiments, refuse_too_large, start,
};
use serde_json::Value;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

/// Variants of a case that a command runs, with the number of their runs.
pub struct Variants {
    /// Case from which the variants (experiments of a case) are made.
    pub case: Case,
    /// Experiment of each variant, with the warnings about it for the user.
    pub checked: Vec<Checked>,
    /// Number of runs of each variant (experiment of a case); the runs differ in their seeds.
    pub replicas: u16,
    /// Settings of the trajectories of the first run of each variant (experiment of a case); `None` if no trajectories
    /// are written.
    pub trajectories: Option<Trajectories>,
    /// True if a test with half the time step follows the first run of each variant (experiment of a case).
    pub verify: bool,
}

impl Variants {
    /// Experiments of all variants (experiments of a case), each with the seed of its first replica (run with one of
    /// several seeds).
    pub fn experiments(&self) -> impl Iterator<Item = &Experiment> + Clone {
        self.checked.iter().map(|(experiment, _)| experiment)
    }

    /// Returns an error if some of the processes that share a run would be idle: there are more processes than
    /// particles, and no replicas (runs with different seeds).
    ///
    /// # Errors
    /// The message of the error names the largest useful number of processes.
    pub fn refuse_idle(&self, ranks: &Ranks) -> Result<(), StudyError> {
        let (processes, particles) = (ranks.count(), self.fewest_particles());
        if self.replicas > 1 || processes <= particles {
            return Ok(());
        }
        Err(StudyError::Input(format!(
            "error: {processes} processes for {}: each needs particles of its own\n\
             help: start at most {particles} of them (`mpirun -n`)",
            counted(particles, "particle")
        )))
    }

    /// Number of particles of the variant (experiment of a case) with the fewest particles, at least 1. Particles that
    /// inlets are expected to bring are included.
    fn fewest_particles(&self) -> usize {
        self.experiments().map(|experiment| experiment.expected_count().max(1.0) as usize).min().unwrap_or(1)
    }

    /// Checksum of the experiments of all variants. All processes that share the runs compare it before they make
    /// initial states, to make sure that their variants are equal.
    pub fn mark(&self) -> u32 {
        mark_of_experiments(self.experiments())
    }

    /// Runs of all variants (experiments of a case), variant by variant. The first run of a variant is done alone, so
    /// that its wall time is meaningful. The replicas (runs with different seeds) of the variant follow.
    fn runs(&self, ranks: &Ranks) -> Result<Vec<ResumableRun>, StudyError> {
        let names = file_names(self.experiments().map(|experiment| experiment.name.as_str()));
        let mut runs = Vec::new();
        for ((experiment, name), first) in self.experiments().zip(names).zip(self.starts(ranks)?) {
            let trajectory = self.trajectories.map(|asked| (name, asked));
            runs.push(ResumableRun::new(experiment.clone(), first)?.lone(trajectory));
            for other in replicas(experiment, self.replicas)?.into_iter().skip(1) {
                let start = start(&other)?;
                runs.push(ResumableRun::new(other, start.into())?);
            }
        }
        Ok(runs)
    }

    /// Initial state of the first run of each variant (experiment of a case). If all processes share the runs, each
    /// process makes only its part of the particles.
    fn starts(&self, ranks: &Ranks) -> Result<Vec<Start>, StudyError> {
        if ranks.count() == 1 {
            self.experiments().try_for_each(refuse_too_large)?;
        }
        let made: Result<Vec<Start>, Crowded> = if ranks.count() == 1 || self.replicas > 1 {
            self.experiments().map(Start::whole).collect()
        } else {
            let part = |communicator: Arc<dyn Communicator>| {
                self.experiments().map(|experiment| Start::part(experiment, &*communicator)).collect()
            };
            ranks.together(part).0
        };
        made.map_err(|crowded| StudyError::Input(format!("error: {crowded}")))
    }
}

/// Results of the variants (experiments of a case) so far, and the executor that does their runs.
pub struct VariantResults<'a> {
    variants: &'a Variants,
    executor: Executor<'a>,
    provenance: Provenance,
    parameters: Vec<Value>,
    /// Outcomes of all complete replicas (runs with different seeds) of each variant (experiment of a case).
    pub runs: Vec<Vec<Outcome>>,
    sheets: Vec<TrustSheet>,
    frames: Vec<Frames>,
}

/// Results of the variants (experiments of a case) in the form in which they are written to a report.
#[derive(Default)]
pub struct VariantFindings {
    /// Outcome of each variant (experiment of a case), averaged over its replicas (runs with different seeds).
    pub outcomes: Vec<Outcome>,
    /// Comparisons of the variants (experiments of a case) with their references, each with an answer.
    pub comparisons: Vec<Verdict>,
    /// Sentences of the report: first the answers of the comparisons, then further sentences.
    pub verdicts: Vec<String>,
    /// Settings by which the variants (experiments of a case) differ from one another, as typed in the case.
    pub overrides: Vec<String>,
    /// Sentences on the limits of the reliability of the results.
    pub notes: Vec<String>,
    /// Budgets of a single run: rates at which single processes, such as drag, change the second moments of velocity.
    /// `None` unless the user asks for budgets.
    pub budgets: Option<Budgets>,
}

impl<'a> VariantResults<'a> {
    /// Prepares the runs of the variants (experiments of a case); `scene` is a description of their scene. In a helper
    /// process (any process but the first), the call does runs for the first process until the command ends, and then
    /// returns `None`.
    ///
    /// # Errors
    /// Returns an error if the scene is too crowded to start, and the errors of [`Executor::begin`].
    pub fn begin(
        variants: &'a Variants,
        settings: &CommandSettings,
        scene: String,
        ranks: &'a Ranks,
    ) -> Result<Option<Self>, StudyError> {
        let (case, checked) = (&variants.case, &variants.checked);
        let executor = Executor::begin::<Outcome>(settings, case, checked, variants.runs(ranks), ranks)?;
        Ok(executor.map(|executor| Self {
            variants,
            executor,
            provenance: settings.provenance(case, scene),
            parameters: variants.experiments().map(|experiment| case.parameters(experiment)).collect(),
            runs: Vec::new(),
            sheets: Vec::new(),
            frames: Vec::new(),
        }))
    }

    /// Folder to which the results of the command are written.
    pub fn folder(&self) -> Rc<Folder> {
        Rc::clone(&self.executor.folder)
    }

    /// Does the first run of the next variant (experiment of a case), with `observers` (measurements during the run)
    /// in addition to the standard ones. Returns the final state of the run, which [`check`](Self::check) needs.
    ///
    /// # Errors
    /// Returns an error if the run cannot begin, if its state cannot be stored, or if the stored state belongs to
    /// another run.
    pub fn run_first(&mut self, observers: Vec<&mut dyn Observer>) -> Result<Particles, StudyError> {
        let Variants { checked, replicas, verify, .. } = self.variants;
        let variant = self.runs.len();
        let mut frames = Frames::new(&checked[variant].0, checked.len());
        let observers = observers.into_iter().map(|observer| observer as &mut dyn Observer);
        let observers = observers.chain([&mut frames as &mut dyn Observer]).collect();
        self.executor.checkpointer.set_more(*verify || *replicas > 1 || variant + 1 < checked.len());
        let (outcome, end) = self.executor.alone(variant * usize::from(*replicas), observers, *verify)?;
        self.executor.checkpointer.set_more(false);
        self.frames.push(frames);
        self.runs.push(vec![outcome]);
        Ok(end)
    }

    /// Makes the trust sheet (checks of reliability) of the variant (experiment of a case) that was run most recently;
    /// `end` is the final state of its first run. The test with half the time step is done first if the user has asked
    /// for it (`--verify`).
    ///
    /// # Errors
    /// Returns an error if the stored state of the test with half the time step belongs to another run.
    pub fn check(&mut self, end: Particles) -> Result<(), StudyError> {
        let Some(outcome) = self.runs.last().and_then(|runs| runs.first()) else { return Ok(()) };
        let halved = if self.variants.verify {
            verify_with_checkpoints(outcome, &end, self.executor.quiet, &mut self.executor.checkpointer)?
        } else {
            HalvedStep::Unknown("not asked for: --verify does it, for about a fifth of the time of the run".into())
        };
        self.sheets.push(trust_sheet(outcome, halved));
        Ok(())
    }

    /// Does the replicas (runs with different seeds) of a variant (experiment of a case) with the indices `range`,
    /// several at once; index 0 is its first run. Returns false if the user has stopped the command. Replicas that are
    /// not complete are then left out.
    ///
    /// # Errors
    /// Returns an error if a replica cannot begin, if its stored state belongs to another run, or if no thread can be
    /// started.
    pub fn run_replicas(&mut self, variant: usize, range: Range<usize>) -> Result<bool, StudyError> {
        if !range.is_empty() && !self.executor.checkpointer.is_stopped() {
            let name = &self.variants.checked[variant].0.name;
            self.executor.say(format!("{name}: {} more of it, from the next seeds", counted(range.len(), "replica")));
            let before = variant * usize::from(self.variants.replicas) + range.start;
            let mut over: Vec<Option<Outcome>> = vec![None; range.len()];
            self.executor.concurrently(&(before..before + range.len()).collect::<Vec<_>>(), |index, outcome| {
                over[index - before] = Some(outcome);
                Ok(())
            })?;
            if over.iter().any(Option::is_none) {
                self.executor.checkpointer.stop();
            }
            self.runs[variant].extend(over.into_iter().flatten());
        }
        Ok(!self.executor.checkpointer.is_stopped())
    }

    /// Error of a command that the user has stopped during the runs of a variant (experiment of a case).
    pub fn stopped(&self, variant: usize) -> StudyError {
        self.executor.checkpointer.stop_error(&self.variants.checked[variant].0.name)
    }

    /// Writes a report on the results so far, with a summary if `whole` is true. Returns the path of the report.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub fn write(&self, findings: &VariantFindings, whole: bool) -> Result<PathBuf, StudyError> {
        let study = Study {
            provenance: &self.provenance,
            outcomes: &findings.outcomes,
            parameters: &self.parameters,
            verdicts: &findings.verdicts,
            comparisons: &findings.comparisons,
            overrides: &findings.overrides,
            notes: &findings.notes,
            trust: &self.sheets,
            frames: &self.frames,
            budgets: findings.budgets.as_ref(),
        };
        let write = if whole { write_study } else { write_part };
        self.executor.checkpointer.with_remedy(write(&self.executor.folder, &study))
    }

    /// Ends the command after all results have been written, and prints `sentences` and the path of the report.
    ///
    /// # Errors
    /// Returns an error if the run of a variant (experiment of a case) failed, or if a stored state cannot be removed.
    pub fn finish(self, findings: &VariantFindings, sentences: &[String], report: &Path) -> Result<(), StudyError> {
        self.executor.finish(sentences, report)?;
        failures(&findings.outcomes)
    }
}

/// Names of files for the variants (experiments of a case): the names of the variants in characters that any system
/// accepts. No two of them are equal.
fn file_names<'a>(variants: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for variant in variants {
        let mut name = figures::file_name(variant);
        while name.is_empty() || names.contains(&name) {
            name = format!("{name}variant-{}", names.len());
        }
        names.push(name);
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_are_different() {
        let names = file_names(["variant-1", "//", "soft", "soft", "softvariant-3"].into_iter());
        let different: std::collections::BTreeSet<&String> = names.iter().collect();
        assert_eq!(different.len(), names.len(), "{names:?}");
    }

    /// Checks that particles that come in later count as work: a chute starts empty, and its inlet brings some hundred
    /// particles, so several processes are not refused.
    #[test]
    fn particles_that_come_in_count_as_work() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/driven/chute.toml");
        let case = Case::read(&path, &[]).unwrap();
        let checked = vec![case.experiment(None, None).unwrap()];
        assert_eq!(checked[0].0.count(), 0);
        let variants = Variants { case, checked, replicas: 1, trajectories: None, verify: false };
        assert!(variants.fewest_particles() > 50, "{}", variants.fewest_particles());
    }
}
