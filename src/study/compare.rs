//! `diptych compare`: the variants of a case, one after the other, each alone on the machine.

use super::beside::Share;
use super::judge::judge;
use super::keeper::Keeper;
use super::kept_runs::{KeptRun, help_with, mark, mark_of, starts};
use super::occasion::Occasion;
use super::ranks::Ranks;
use super::replicas::{Ground, others, pool, progress, refuse_idle, run_others, shared};
use super::session::{Into, StudyError, failures, file_names, read, share_threads, simulate, trust, warn};
use super::terminal::conclude;
use super::trust::notes;
use crate::case::{Case, Checked, describe_variants};
use crate::checkpoint::Run;
use crate::cli::Compare;
use crate::experiment::{Experiment, Trajectories};
use crate::observe::Frames;
use crate::outcome::Outcome;
use crate::output::{Study, TrustSheet, Verdict, overall, write_part, write_study};
use crate::statistics::Answer;

/// Runs all variants of a case and writes one folder. The answer is that of all comparisons together; `None` of a single variant.
///
/// # Errors
/// Bad input before anything is computed; failures of engines after everything has been written.
pub fn compare(args: &Compare, ranks: &Ranks) -> Result<Option<Answer>, StudyError> {
    compare_on(args, &Occasion::First, ranks)
}

/// The same, begun or gone on with: runs that are over are not run again.
pub(super) fn compare_on(args: &Compare, occasion: &Occasion, ranks: &Ranks) -> Result<Option<Answer>, StudyError> {
    let prepared = ranks.agree(prepare(args, ranks), |prepared| mark(prepared.runs()))?;
    let share = Share { threads: ranks.threads(args.effort.threads), in_turn: false };
    if !ranks.is_lead() {
        let place = occasion.place(&args.output, &args.case, "compare");
        let keeper = Keeper::of_helper(args.keep.checkpoint_every, occasion, &place)?;
        let Prepared { firsts, others, trajectories, .. } = prepared;
        let lists = (firsts, others.iter().flatten().collect());
        return help_with(lists, trajectories.map(|asked| (place, asked)), &keeper, share, ranks).map(|()| None);
    }
    let Prepared { case, variants, firsts, others, trajectories } = prepared;
    let folder = occasion.folder(&args.output, &args.case, "compare")?;
    ranks.announce(share.threads, args.output.quiet);
    warn(&variants, args.output.quiet);
    let parameters: Vec<_> = variants.iter().map(|(experiment, _)| case.parameters(experiment)).collect();
    let runs = firsts.iter().map(|first| first.run.clone()).collect();
    let mut keeper = Keeper::new(args.keep.checkpoint_every, occasion, &folder, &case, runs)?;
    let provenance = occasion.provenance(&case, describe_variants(variants.iter().map(|(experiment, _)| experiment)));
    let overrides = case.overrides();
    let (mut outcomes, mut sheets): (Vec<Outcome>, Vec<TrustSheet>) = (Vec::new(), Vec::new());
    let (mut replicas, mut comparisons): (Vec<Vec<Outcome>>, Vec<Verdict>) = (Vec::new(), Vec::new());
    let mut frames: Vec<Frames> = Vec::new();
    let experiments = variants.iter().map(|(experiment, _)| experiment);
    let progress = progress(experiments.zip(others.iter().map(Vec::as_slice)), args.output.quiet);
    let ground = Ground { others: &others, progress: &progress, share, ranks, quiet: args.output.quiet };
    let runs_of_each = 1 + others.first().map_or(0, Vec::len);
    let names = file_names(variants.iter().map(|(experiment, _)| experiment.name.as_str()));
    for (k, ((experiment, _), first)) in variants.iter().zip(firsts).enumerate() {
        keeper.expects(args.verify || runs_of_each > 1 || outcomes.len() + 1 < variants.len());
        let mut seen = Frames::new(experiment, variants.len());
        let shared = shared(k, &ground, args.verify);
        let into = Into { folder: &folder, name: &names[k], trajectories, others: vec![&mut seen], shared };
        let (outcome, end) = simulate(experiment, first.start, progress.watch(k * runs_of_each), into, &mut keeper)?;
        frames.push(seen);
        keeper.expects(false);
        sheets.push(trust(&outcome, &end, args.verify, args.output.quiet, &mut keeper)?);
        replicas.push(run_others(k, &ground, &mut keeper)?);
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

/// What is to be run.
struct Prepared {
    case: Case,
    variants: Vec<Checked>,
    /// The first run of each variant.
    firsts: Vec<KeptRun>,
    /// Its replicas.
    others: Vec<Vec<KeptRun>>,
    trajectories: Option<Trajectories>,
}

impl Prepared {
    fn runs(&self) -> impl Iterator<Item = &Run> {
        self.firsts.iter().chain(self.others.iter().flatten()).map(|one| &one.run)
    }
}

fn prepare(args: &Compare, ranks: &Ranks) -> Result<Prepared, StudyError> {
    let asked =
        ranks.agree(ask(args, ranks), |(_, variants, _)| mark_of(variants.iter().map(|(experiment, _)| experiment)))?;
    let (case, variants, trajectories) = asked;
    let experiments: Vec<&Experiment> = variants.iter().map(|(experiment, _)| experiment).collect();
    let starts = starts(&experiments, args.repeats.replicas, ranks)?;
    let firsts = experiments.iter().zip(starts).map(|(experiment, start)| KeptRun::new((*experiment).clone(), start));
    let firsts = firsts.collect::<Result<_, _>>()?;
    let all = experiments.iter().map(|experiment| others(experiment, args.repeats.replicas));
    let others = all.collect::<Result<_, _>>()?;
    Ok(Prepared { case, variants, firsts, others, trajectories })
}

/// The case, its variants, and the trajectories that are asked for.
type Asked = (Case, Vec<Checked>, Option<Trajectories>);

fn ask(args: &Compare, ranks: &Ranks) -> Result<Asked, StudyError> {
    let case = read(&args.case, &args.input.with_every(args.every.as_ref()))?;
    let variants = case.variants(args.effort.seed)?;
    share_threads(&args.effort, ranks)?;
    for (experiment, _) in &variants {
        refuse_idle(experiment, args.repeats.replicas, ranks)?;
    }
    let trajectories = case.trajectories()?;
    Ok((case, variants, trajectories))
}

/// All answers first, then what else there is to say.
fn sentences(comparisons: &[Verdict]) -> Vec<String> {
    let answers = comparisons.iter().map(|comparison| comparison.sentence.clone());
    answers.chain(comparisons.iter().flat_map(|comparison| comparison.further.clone())).collect()
}
