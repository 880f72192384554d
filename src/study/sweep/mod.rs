//! `diptych sweep CASE`: the variants of a case at several values of its keys.
//!
//! Every run is known by the hash of its resolved case. Its result is a file of that name, written whole when the run
//! is done. So a sweep that is started again goes on with the missing runs. A run that several points have in common is
//! done once (hard spheres do not depend on a stiffness).

mod run;

use super::ranks::Ranks;
use super::replicas::replicas;
use super::run_list::ThreadBudget;
use super::session::{StudyError, make, place, provenance, read, warn};
use super::signals::Signals;
use super::terminal::{conclude, tell};
use crate::case::{Case, Checked, Diagnostic, SweepAxis, describe_variants, fingerprint};
use crate::checkpoint::checksum;
use crate::cli::Sweep;
use crate::experiment::{Experiment, Model};
use crate::output::numbers::counted;
use crate::output::sweep::{SweepRow, SweepRun, SweepStudy, point};
use crate::output::{Folder, OutputError, sweep_verdicts, write_sweep};
use run::{SweepJob, SweepResources, help_with, run_all};
use std::collections::HashSet;

/// The subfolder of the results of single runs.
const POINTS: &str = "points";

/// Most rows of a sweep: a reader would not look at more one by one.
const MOST: usize = 10_000;

/// Runs the missing runs of a sweep and writes its folder.
///
/// # Errors
/// Bad input before anything is computed; runs that stopped early after everything has been written.
pub fn sweep(args: &Sweep, ranks: &Ranks) -> Result<(), StudyError> {
    let (case, axes, mut plan) = ranks.agree(planned(args), |(_, _, plan)| plan.checksum())?;
    let share = ThreadBudget { threads: ranks.threads(args.effort.threads), in_turn: args.in_turn };
    let jobs = plan.jobs();
    if !ranks.is_lead() {
        return help_with(&jobs, share, ranks);
    }
    let path = place(&args.output, &args.case, "sweep");
    // existing runs of a sweep are kept, and the missing ones are run
    tell_what_is_ignored(&case, args.output.quiet)?;
    let folder = make(path.clone(), args.output.overwrite || path.join(POINTS).is_dir())?;
    warn(&plan.checked, args.output.quiet);
    ranks.announce(share.threads, args.output.quiet);
    if args.output.overwrite {
        forget(&folder)?;
    } else {
        plan.take_over(&folder);
    }
    let missing: Vec<usize> = (0..jobs.len()).filter(|job| !plan.has(&jobs[*job].identity)).collect();
    let wanted = jobs.len();
    let say = |line: String| {
        if !args.output.quiet {
            tell(line);
        }
    };
    let mut done = wanted - missing.len();
    if done > 0 {
        say(format!("{done} of {} are there from an earlier start", counted(wanted, "run")));
    }
    let provenance = provenance(&case, describe_variants(plan.checked.iter().map(|(experiment, _)| experiment)));
    let reference = plan.reference();
    let (mut rows, variants) = (plan.rows, plan.variants);
    let study = |rows: &[SweepRow]| -> Result<_, StudyError> {
        let study = SweepStudy { provenance: &provenance, axes: &axes, variants: &variants, reference, rows };
        Ok((write_sweep(&folder, &study)?, sweep_verdicts(&study)))
    };
    let effort = SweepResources { share, ranks, quiet: args.output.quiet };
    let signals = Signals::listen()?;
    run_all((&jobs, &missing), &effort, &signals, |job, run| {
        let mut bytes = serde_json::to_vec_pretty(&run).map_err(OutputError::from)?;
        bytes.push(b'\n');
        folder.write(&file(&run.identity), &bytes)?;
        done += 1;
        let how = run.failure.as_ref().map_or(String::new(), |why| format!(", stopped: {why}"));
        say(format!("{done} of {wanted} runs: {}, {:.1} s{how}", job.name, run.wall_seconds));
        give(&mut rows, &run);
        // results so far are written so that the user can look at them, and stay if the sweep is stopped
        if done < wanted {
            study(&rows)?;
        }
        Ok(())
    })?;
    if done < wanted {
        return Err(stopped(done, wanted));
    }
    let (report, sentences) = study(&rows)?;
    if !args.output.quiet {
        conclude(&sentences, "Report", &report);
    }
    failures(&rows, &variants, &axes)
}

/// The case, its axes and the plan of its runs.
fn planned(args: &Sweep) -> Result<(Case, Vec<SweepAxis>, SweepPlan), StudyError> {
    let mut case = read(&args.case, &args.input)?;
    let axes = case.axes(&args.sweep)?;
    let plan = SweepPlan::new(&case, &axes, args)?;
    Ok((case, axes, plan))
}

/// Tells the user which requests of a case are ignored in a sweep.
fn tell_what_is_ignored(case: &Case, quiet: bool) -> Result<(), Diagnostic> {
    if case.trajectories()?.is_some() && !quiet {
        tell("warning: the runs of a sweep write no trajectories: `output.every` is for `run` and `compare`");
    }
    Ok(())
}

/// Error of a sweep that the user has stopped.
fn stopped(done: usize, wanted: usize) -> StudyError {
    StudyError::Stopped(format!(
        "the sweep was stopped: {done} of {} are done; the same command goes on with what is missing",
        counted(wanted, "run")
    ))
}

/// Error of a sweep if some of its runs stopped early.
fn failures(rows: &[SweepRow], variants: &[String], axes: &[SweepAxis]) -> Result<(), StudyError> {
    let failed = rows.iter().filter_map(|row| {
        let name = format!("\"{}\" at {}", variants[row.variant], point(axes, &row.at));
        Some(format!("error: {name} stopped: {}", row.failure()?))
    });
    let failed: Vec<String> = failed.collect();
    if failed.is_empty() { Ok(()) } else { Err(StudyError::Failed(failed.join("\n"))) }
}

/// The file of a run in the folder.
fn file(identity: &str) -> String {
    format!("{POINTS}/{identity}.json")
}

/// Removes the results of single runs of an earlier sweep: the files whose names are those of their runs.
fn forget(folder: &Folder) -> Result<(), StudyError> {
    let Ok(entries) = std::fs::read_dir(folder.path().join(POINTS)) else { return Ok(()) };
    for path in entries.flatten().map(|entry| entry.path()) {
        let ours = path.file_stem().is_some_and(|stem| stored(folder, &stem.to_string_lossy()).is_some());
        if ours {
            std::fs::remove_file(&path)
                .map_err(|why| StudyError::Input(format!("error: cannot remove {}: {why}", path.display())))?;
        }
    }
    Ok(())
}

/// Result of a run that an earlier start has left.
fn stored(folder: &Folder, identity: &str) -> Option<SweepRun> {
    let bytes = std::fs::read(folder.path().join(file(identity))).ok()?;
    let run: SweepRun = serde_json::from_slice(&bytes).ok()?;
    (run.identity == identity).then_some(run)
}

/// Gives the result of a run to every row that it belongs to. Averages are taken in the order of the replicas, in
/// whatever order they end.
fn give(rows: &mut [SweepRow], run: &SweepRun) {
    for row in rows {
        let times = row.identities.iter().filter(|identity| **identity == run.identity).count();
        row.runs.extend(std::iter::repeat_n(run, times).cloned());
        row.runs.sort_by_key(|run| row.identities.iter().position(|identity| *identity == run.identity));
    }
}

/// Plan of a sweep.
struct SweepPlan {
    variants: Vec<String>,
    rows: Vec<SweepRow>,
    /// The experiments of all rows and replicas, in the order of `rows`.
    experiments: Vec<Vec<Experiment>>,
    /// Variants of all points, with their warnings.
    checked: Vec<Checked>,
    /// Names of the runs, for messages, in the order of `rows`.
    names: Vec<String>,
}

impl SweepPlan {
    fn new(case: &Case, axes: &[SweepAxis], args: &Sweep) -> Result<Self, StudyError> {
        let points: usize = axes.iter().map(|axis| axis.typed.len()).product();
        let mut plan = Self {
            variants: Vec::new(),
            rows: Vec::new(),
            experiments: Vec::new(),
            checked: Vec::new(),
            names: Vec::new(),
        };
        for index in 0..points.min(MOST + 1) {
            let at = at(axes, index);
            let variants = case.point(axes, &at, args.effort.seed)?;
            if let Some(unknown) = args.only.iter().find(|name| variants.iter().all(|(one, _)| one.name != **name)) {
                let names: Vec<&str> = variants.iter().map(|(one, _)| one.name.as_str()).collect();
                return Err(StudyError::Input(format!(
                    "error: no variant is called \"{unknown}\"\nhelp: there are {}",
                    names.join(", ")
                )));
            }
            let wanted = |name: &str| args.only.is_empty() || args.only.iter().any(|only| only == name);
            for checked in variants.into_iter().filter(|(one, _)| wanted(&one.name)) {
                plan.add(axes, &at, checked, args.repeats.replicas)?;
            }
        }
        if plan.rows.len() > MOST {
            return Err(StudyError::Input(format!(
                "error: the sweep has more than {MOST} points\nhelp: give fewer values"
            )));
        }
        Ok(plan)
    }

    /// Adds a variant at a point, once for each replica.
    fn add(&mut self, axes: &[SweepAxis], at: &[usize], checked: Checked, count: u16) -> Result<(), StudyError> {
        let experiment = &checked.0;
        let experiments = replicas(experiment, count)?;
        let variant = self.variants.iter().position(|name| *name == experiment.name).unwrap_or_else(|| {
            self.variants.push(experiment.name.clone());
            self.variants.len() - 1
        });
        let identities: Vec<String> = experiments
            .iter()
            .map(fingerprint)
            .collect::<Result<_, _>>()
            .map_err(|why| StudyError::Failed(format!("error: cannot describe the case: {why}")))?;
        self.names.push(format!("\"{}\" at {}", experiment.name, point(axes, at)));
        self.rows.push(SweepRow { at: at.to_vec(), variant, identities, runs: Vec::new() });
        self.experiments.push(experiments);
        self.checked.push(checked);
        Ok(())
    }

    /// A checksum of all runs in their order.
    fn checksum(&self) -> u32 {
        let identities: Vec<&str> = self.rows.iter().flat_map(|row| &row.identities).map(String::as_str).collect();
        checksum(identities.concat().as_bytes())
    }

    /// Reference variant with which the others are compared: the first hard one.
    fn reference(&self) -> Option<usize> {
        let mut rows = self.rows.iter().zip(&self.checked);
        rows.find(|(_, (experiment, _))| experiment.model() == Model::Hard).map(|(row, _)| row.variant)
    }

    /// Takes over the results that an earlier start has left in the folder.
    fn take_over(&mut self, folder: &Folder) {
        let mut known = HashSet::new();
        let identities: Vec<String> = self.rows.iter().flat_map(|row| row.identities.clone()).collect();
        for identity in identities {
            if known.insert(identity.clone())
                && let Some(run) = stored(folder, &identity)
            {
                give(&mut self.rows, &run);
            }
        }
    }

    /// True if the result of that run exists.
    fn has(&self, identity: &str) -> bool {
        self.rows.iter().flat_map(|row| &row.runs).any(|run| run.identity == identity)
    }

    /// The runs, each once.
    fn jobs(&self) -> Vec<SweepJob> {
        let (mut jobs, mut taken) = (Vec::new(), HashSet::new());
        for ((row, experiments), name) in self.rows.iter().zip(&self.experiments).zip(&self.names) {
            for (identity, experiment) in row.identities.iter().zip(experiments) {
                if taken.insert(identity) {
                    jobs.push(SweepJob {
                        identity: identity.clone(),
                        name: name.clone(),
                        experiment: experiment.clone(),
                    });
                }
            }
        }
        jobs
    }
}

/// Index of the value on each axis for the point of that index; the last axis changes fastest.
fn at(axes: &[SweepAxis], mut index: usize) -> Vec<usize> {
    let mut at: Vec<usize> = Vec::new();
    for axis in axes.iter().rev() {
        at.push(index % axis.typed.len());
        index /= axis.typed.len();
    }
    at.reverse();
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_a_row_stand_in_the_order_of_their_seeds() {
        let run = |identity: &str, wall_seconds| SweepRun {
            identity: identity.into(),
            measured: Default::default(),
            failure: None,
            wall_seconds,
            threads: 1,
        };
        let identities = ["seed 1", "seed 2", "seed 3"].map(String::from).to_vec();
        let mut rows = [SweepRow { at: vec![0], variant: 0, identities: identities.clone(), runs: Vec::new() }];
        // the last ends first
        for (seconds, identity) in [(1.0, "seed 3"), (2.0, "seed 1"), (3.0, "seed 2")] {
            give(&mut rows, &run(identity, seconds));
        }
        assert!(rows[0].runs.iter().map(|run| &run.identity).eq(&identities), "{:?}", rows[0].runs);
    }
}
