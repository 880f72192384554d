//! `diptych compare`: the variants of a case, one after the other, each alone on the machine.

use super::judge::judge;
use super::keeper::{Keeper, runs};
use super::occasion::Occasion;
use super::replicas::{others, pool, progress, run_others};
use super::session::{Into, StudyError, failures, file_names, read, simulate, start, trust, use_threads, warn};
use super::terminal::conclude;
use super::trust::notes;
use crate::case::describe_variants;
use crate::cli::Compare;
use crate::observe::Frames;
use crate::outcome::Outcome;
use crate::output::{Study, TrustSheet, Verdict, overall, write_part, write_study};
use crate::statistics::Answer;

/// Runs all variants of a case and writes one folder. The answer is that of all comparisons together; `None` of a single variant.
///
/// # Errors
/// Bad input before anything is computed; failures of engines after everything has been written.
pub fn compare(args: &Compare) -> Result<Option<Answer>, StudyError> {
    compare_on(args, &Occasion::First)
}

/// The same, begun or gone on with: runs that are over are not run again.
pub(super) fn compare_on(args: &Compare, occasion: &Occasion) -> Result<Option<Answer>, StudyError> {
    let case = read(&args.case, &args.input.with_every(args.every.as_ref()))?;
    let variants = case.variants(args.effort.seed)?;
    use_threads(&args.effort)?;
    let prepare = |experiment| Ok::<_, StudyError>((start(experiment)?, others(experiment, args.repeats.replicas)?));
    let starts = variants.iter().map(|(experiment, _)| prepare(experiment)).collect::<Result<Vec<_>, _>>()?;
    let trajectories = case.trajectories()?;
    let folder = occasion.folder(&args.output, &args.case, "compare")?;
    warn(&variants, args.output.quiet);
    let parameters: Vec<_> = variants.iter().map(|(experiment, _)| case.parameters(experiment)).collect();
    let hashes = starts.iter().map(|(start, _)| start.fingerprint());
    let runs = runs(variants.iter().map(|(experiment, _)| experiment).zip(hashes))?;
    let mut keeper = Keeper::new(args.keep.checkpoint_every, occasion, &folder, &case, runs)?;
    let provenance = occasion.provenance(&case, describe_variants(variants.iter().map(|(experiment, _)| experiment)));
    let overrides = case.overrides();
    let (mut outcomes, mut sheets): (Vec<Outcome>, Vec<TrustSheet>) = (Vec::new(), Vec::new());
    let (mut replicas, mut comparisons): (Vec<Vec<Outcome>>, Vec<Verdict>) = (Vec::new(), Vec::new());
    let mut frames: Vec<Frames> = Vec::new();
    let experiments = variants.iter().map(|(experiment, _)| experiment);
    let progress = progress(experiments.zip(starts.iter().map(|(_, others)| others.as_slice())), args.output.quiet);
    let runs_of_each = 1 + starts.first().map_or(0, |(_, others)| others.len());
    let names = file_names(variants.iter().map(|(experiment, _)| experiment.name.as_str()));
    for (k, ((experiment, _), (start, others))) in variants.iter().zip(starts).enumerate() {
        keeper.expect(args.verify || !others.is_empty() || outcomes.len() + 1 < variants.len());
        let mut seen = Frames::new(experiment, variants.len());
        let into = Into { folder: &folder, name: &names[k], trajectories, others: vec![&mut seen] };
        let (outcome, end) = simulate(experiment, start, progress.watch(k * runs_of_each), into, &mut keeper)?;
        frames.push(seen);
        keeper.expect(false);
        sheets.push(trust(&outcome, &end, args.verify, args.output.quiet, &mut keeper)?);
        replicas.push(run_others(others, (&progress, k * runs_of_each + 1), args.output.quiet, &mut keeper)?);
        outcomes.push(pool(outcome, replicas.last().map_or(&[], Vec::as_slice)));
        // written after every variant: whoever stops a long comparison keeps what is done
        comparisons = judge(&outcomes, &replicas, args.margin);
        let verdicts = sentences(&comparisons);
        let yet_to_run = &variants[outcomes.len()..];
        let mut notes = notes(&outcomes);
        notes.extend(yet_to_run.iter().map(|(experiment, _)| format!("\"{}\" has not been run yet.", experiment.name)));
        let study = Study {
            provenance: &provenance,
            outcomes: &outcomes,
            parameters: &parameters,
            verdicts: &verdicts,
            comparisons: &comparisons,
            overrides: &overrides,
            notes: &notes,
            trust: &sheets,
            frames: &frames,
        };
        if keeper.is_stopped() {
            keeper.helped(write_part(&folder, &study))?;
            return Err(keeper.words(&experiment.name));
        }
        if !yet_to_run.is_empty() {
            keeper.helped(write_part(&folder, &study))?;
            continue;
        }
        let report = keeper.helped(write_study(&folder, &study))?;
        if !args.output.quiet {
            conclude(&verdicts, "Report", &report);
        }
    }
    keeper.done()?;
    failures(&outcomes)?;
    Ok(overall(&comparisons))
}

/// All answers first, then what else there is to say.
fn sentences(comparisons: &[Verdict]) -> Vec<String> {
    let answers = comparisons.iter().map(|comparison| comparison.sentence.clone());
    answers.chain(comparisons.iter().flat_map(|comparison| comparison.further.clone())).collect()
}
