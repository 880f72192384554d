//! `diptych sweep CASE`: runs the variants of a case at several values of its keys. A variant is one of the experiments
//! of a case, a point is one value for each of these keys, and replicas are runs with different seeds.
//!
//! The hash of the resolved case (with all its values filled in) identifies a run. The result of a run is stored under
//! this hash, and remains when the sweep has ended. If a sweep is started again, also with other values, only the
//! missing runs are done. A run that belongs to several points is done once, such as that of hard spheres at all values
//! of a stiffness.

use super::replicas::{FROZEN, replicas};
use crate::case::{Case, Checked, SweepAxis, describe_variants, fingerprint};
use crate::checkpoint::Store;
use crate::cli::{Cli, Command, Sweep};
use crate::experiment::Model;
use crate::outcome::Outcome;
use crate::output::numbers::counted;
use crate::output::sweep::{OBSERVABLES, SweepRow, SweepRun, SweepStudy, point};
use crate::output::{sweep_verdicts, write_sweep};
use crate::runs::{
    CommandOrigin, CommandSettings, Executor, Ranks, ResumableRun, RunResult, StudyError, mark, read, tell,
};
use crate::statistics::Estimate;
use clap::Parser;
use std::collections::HashSet;
use std::path::Path;

/// Largest number of rows in the table of a sweep. A sweep with more rows is refused, since its table would be too
/// long to read.
const MOST: usize = 10_000;

/// Begins or resumes a sweep, and writes its results to a folder. Runs that are complete are not repeated.
///
/// # Errors
/// Returns an error for bad input, before anything is computed, or for runs that stopped early, after everything has
/// been written.
pub fn sweep(args: &Sweep, origin: CommandOrigin, ranks: &Ranks) -> Result<(), StudyError> {
    let mut settings = CommandSettings {
        in_turn: args.in_turn,
        keeps_results: true,
        ..CommandSettings::new(origin, "sweep", &args.case, &args.output, &args.effort)
    };
    if !settings.overwrite && is_begun(&settings.folder) {
        settings.goes_on();
    }
    let (case, axes, plan) = ranks.agree(planned(args), |(.., plan)| mark(&plan.runs))?;
    let SweepPlan { variants, mut rows, checked, runs, names, reference, has_trajectories, .. } = plan;
    if has_trajectories && ranks.is_lead() && !settings.quiet {
        tell("warning: the runs of a sweep write no trajectories: `output.every` is for `run` and `compare`");
    }
    let Some(executor) = Executor::begin::<SweepRun>(&settings, &case, &checked, Ok(runs), ranks)? else {
        return Ok(());
    };
    let (mut missing, wanted) = (Vec::new(), executor.runs.len());
    for index in 0..wanted {
        match executor.stored(index) {
            Some(run) => give(&mut rows, &run),
            None => missing.push(index),
        }
    }
    let mut done = wanted - missing.len();
    if done > 0 {
        executor.say(format!("{done} of {} are there from an earlier start", counted(wanted, "run")));
    }
    let provenance = settings.provenance(&case, describe_variants(checked.iter().map(|(experiment, _)| experiment)));
    let study = |rows: &[SweepRow]| -> Result<_, StudyError> {
        let study = SweepStudy { provenance: &provenance, axes: &axes, variants: &variants, reference, rows };
        Ok((write_sweep(&executor.folder, &study)?, sweep_verdicts(&study)))
    };
    executor.concurrently(&missing, |index, run: SweepRun| {
        done += 1;
        let how = run.failure.as_ref().map_or(String::new(), |why| format!(", stopped: {why}"));
        executor.say(format!("{done} of {wanted} runs: {}, {:.1} s{how}", names[index], run.wall_seconds));
        give(&mut rows, &run);
        // results so far are written, so that the user can read them and they remain if the sweep is stopped
        if done < wanted {
            study(&rows)?;
        }
        Ok(())
    })?;
    if done < wanted {
        return Err(stopped(done, wanted));
    }
    let (report, sentences) = study(&rows)?;
    executor.conclude(&sentences, &report);
    failures(&rows, &variants, &axes)
}

/// True if a folder contains the stored command of an earlier sweep.
fn is_begun(folder: &Path) -> bool {
    let command = Store::of(folder).command().ok().and_then(|command| Cli::try_parse_from(command.arguments).ok());
    command.is_some_and(|cli| matches!(cli.command, Command::Sweep(_)))
}

/// Reads the case of a sweep, and plans the runs. Each axis of the sweep is a key with its values.
fn planned(args: &Sweep) -> Result<(Case, Vec<SweepAxis>, SweepPlan), StudyError> {
    let mut case = read(&args.case, &args.input)?;
    let axes = case.axes(&args.sweep)?;
    let plan = SweepPlan { has_trajectories: case.trajectories()?.is_some(), ..SweepPlan::new(&case, &axes, args)? };
    Ok((case, axes, plan))
}

impl RunResult for SweepRun {
    /// Values measured in a run that has ended. If the run could not begin because of wrong input, such as a scene
    /// that is too crowded, the result contains this error instead.
    fn of(run: &ResumableRun, outcome: Result<Outcome, StudyError>) -> Result<Self, StudyError> {
        let mut result = Self { identity: run.identity.name.clone(), ..Self::default() };
        let outcome = match outcome {
            Err(StudyError::Input(why)) => {
                result.failure = Some(why.trim_start_matches("error: ").to_owned());
                return Ok(result);
            }
            outcome => outcome?,
        };
        result.wall_seconds = outcome.timing.wall_seconds;
        result.failure = outcome.failure.as_ref().map(ToString::to_string);
        if result.failure.is_none() {
            // a standard error from the scatter within one run is valid only if the run is steady and its particles
            // mix; otherwise a run with another seed may differ by more
            let tells = outcome.steadiness.steady && outcome.places_kept.is_none_or(|kept| kept <= FROZEN);
            let measured = OBSERVABLES.iter().filter_map(|one| {
                let found = (one.of)(&outcome)?;
                let found = if one.is_average && !tells { Estimate::without_error(found.value) } else { found };
                Some((one.key.to_owned(), found))
            });
            result.measured = measured.collect();
        }
        Ok(result)
    }

    fn to_bytes(&self) -> Option<Vec<u8>> {
        postcard::to_stdvec(self).ok()
    }

    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        postcard::from_bytes(bytes).ok()
    }

    fn is_complete(&self) -> bool {
        self.failure.is_none()
    }
}

/// Error of a sweep that the user has stopped after `done` of the `wanted` runs.
fn stopped(done: usize, wanted: usize) -> StudyError {
    StudyError::Stopped(format!(
        "the sweep was stopped: {done} of {} are done; the same command goes on with what is missing",
        counted(wanted, "run")
    ))
}

/// Returns an error if at least one run of the sweep stopped early. The error names these runs with their failures.
fn failures(rows: &[SweepRow], variants: &[String], axes: &[SweepAxis]) -> Result<(), StudyError> {
    let failed = rows.iter().filter_map(|row| {
        let name = format!("\"{}\" at {}", variants[row.variant], point(axes, &row.at));
        Some(format!("error: {name} stopped: {}", row.failure()?))
    });
    let failed: Vec<String> = failed.collect();
    if failed.is_empty() { Ok(()) } else { Err(StudyError::Failed(failed.join("\n"))) }
}

/// Adds the result of a run to every row of the table that needs this run. The results of a row are in the order of its
/// replicas (runs with different seeds), because the rounding of an average depends on the order of its terms.
fn give(rows: &mut [SweepRow], run: &SweepRun) {
    for row in rows {
        let times = row.identities.iter().filter(|identity| **identity == run.identity).count();
        row.runs.extend(std::iter::repeat_n(run, times).cloned());
        row.runs.sort_by_key(|run| row.identities.iter().position(|identity| *identity == run.identity));
    }
}

/// Rows of the table of a sweep, and the runs that these rows need.
#[derive(Default)]
struct SweepPlan {
    variants: Vec<String>,
    rows: Vec<SweepRow>,
    /// Experiments of all variants at all points (values of the keys), each with its warnings.
    checked: Vec<Checked>,
    /// Runs of the sweep, without duplicates.
    runs: Vec<ResumableRun>,
    /// Names of the runs in messages, in the order of `runs`.
    names: Vec<String>,
    /// Hashes of the resolved cases (with all values filled in) of all runs. Runs with equal hashes are equal, and are
    /// done once.
    known: HashSet<String>,
    /// Index of the first variant (experiment of the case) with hard spheres, with which the other variants are
    /// compared. `None` if no variant has hard spheres.
    reference: Option<usize>,
    /// True if the case requests trajectories. A sweep does not write them.
    has_trajectories: bool,
}

impl SweepPlan {
    fn new(case: &Case, axes: &[SweepAxis], args: &Sweep) -> Result<Self, StudyError> {
        let points = axes.iter().fold(1, |points: usize, axis| points.saturating_mul(axis.typed.len()));
        let mut plan = Self::default();
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
                "error: the sweep has more than {MOST} rows, one for each point and variant\nhelp: give fewer values"
            )));
        }
        Ok(plan)
    }

    /// Adds a variant (experiment of the case) at a point of the sweep, with one run for each of `count` replicas
    /// (runs with different seeds). `at` gives the point: the index of the value of each key.
    fn add(&mut self, axes: &[SweepAxis], at: &[usize], checked: Checked, count: u16) -> Result<(), StudyError> {
        let experiment = &checked.0;
        let variant = self.variants.iter().position(|name| *name == experiment.name).unwrap_or_else(|| {
            self.variants.push(experiment.name.clone());
            self.variants.len() - 1
        });
        if experiment.model() == Model::Hard {
            self.reference.get_or_insert(variant);
        }
        let mut identities = Vec::new();
        for replica in replicas(experiment, count)? {
            let identity = fingerprint(&replica)
                .map_err(|why| StudyError::Failed(format!("error: cannot describe the case: {why}")))?;
            if self.known.insert(identity.clone()) {
                self.names.push(format!("\"{}\" at {}", experiment.name, point(axes, at)));
                self.runs.push(ResumableRun::known_by(&identity, replica));
            }
            identities.push(identity);
        }
        self.rows.push(SweepRow { at: at.to_vec(), variant, identities, runs: Vec::new() });
        self.checked.push(checked);
        Ok(())
    }
}

/// Indices of the values on all axes (keys with several values) for the point with the number `index`, counted from 0.
/// From point to point, the value of the last axis changes fastest.
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
        let run =
            |identity: &str, wall_seconds| SweepRun { identity: identity.into(), wall_seconds, ..SweepRun::default() };
        let identities = ["seed 1", "seed 2", "seed 3"].map(String::from).to_vec();
        let mut rows = [SweepRow { at: vec![0], variant: 0, identities: identities.clone(), runs: Vec::new() }];
        // the replica with the last seed ends first
        for (seconds, identity) in [(1.0, "seed 3"), (2.0, "seed 1"), (3.0, "seed 2")] {
            give(&mut rows, &run(identity, seconds));
        }
        assert!(rows[0].runs.iter().map(|run| &run.identity).eq(&identities), "{:?}", rows[0].runs);
    }
}
