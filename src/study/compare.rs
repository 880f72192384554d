//! `diptych compare`: the variants of a case, one after the other, each alone on the machine.

use super::checkpointer::Checkpointer;
use super::invocation::Invocation;
use super::judge::{Criteria, judge_at};
use super::kept_runs::{ResumableRun, help_with, mark, mark_of, starts};
use super::ranks::Ranks;
use super::replicas::{ReplicaContext, others, pool, progress, refuse_idle, run_others, shared};
use super::run_list::ThreadBudget;
use super::session::{Into, StudyError, failures, file_names, read, share_threads, simulate, trust, warn};
use super::terminal::conclude;
use super::trust::notes;
use crate::case::{Case, Checked, describe_variants};
use crate::checkpoint::RunIdentity;
use crate::cli::Compare;
use crate::experiment::{Amount, Experiment, Trajectories};
use crate::observe::Frames;
use crate::outcome::Outcome;
use crate::output::{Folder, Provenance, Study, TrustSheet, Verdict, overall, write_part, write_study};
use crate::statistics::{Answer, ErrorLevels};
use std::ops::Range;

/// Replicas between two looks of `--until-decided`: from three on curves have errors, and with four of each Student's t
/// has 6 degrees of freedom.
const PIECE: usize = 4;

/// Largest number of replicas of each variant for `--until-decided` without `--replicas`: sixteen looks.
const MOST: usize = 64;

/// Runs all variants of a case and writes one folder. Returns the answer of all comparisons together, `None` for a
/// single variant.
///
/// # Errors
/// Bad input before anything is computed; failures of engines after everything has been written.
pub fn compare(args: &Compare, ranks: &Ranks) -> Result<Option<Answer>, StudyError> {
    compare_on(args, &Invocation::First, ranks)
}

/// Begins or resumes a comparison; runs that are over are not run again.
pub(super) fn compare_on(args: &Compare, occasion: &Invocation, ranks: &Ranks) -> Result<Option<Answer>, StudyError> {
    let looks = Looks::of(args);
    let prepared = ranks.agree(prepare(args, looks, ranks), |prepared| mark(prepared.runs()))?;
    let share = ThreadBudget { threads: ranks.threads(args.effort.threads), in_turn: false };
    if !ranks.is_lead() {
        let place = occasion.place(&args.output, &args.case, "compare");
        let keeper = Checkpointer::of_helper(args.keep.checkpoint_every, occasion, &place)?;
        let PreparedComparison { firsts, others, trajectories, .. } = prepared;
        let lists = (firsts, others.iter().flatten().collect());
        return help_with(lists, trajectories.map(|asked| (place, asked)), &keeper, share, ranks).map(|()| None);
    }
    let PreparedComparison { case, variants, firsts, others, trajectories } = prepared;
    let folder = occasion.folder(&args.output, &args.case, "compare")?;
    ranks.announce(share.threads, args.output.quiet);
    warn(&variants, args.output.quiet);
    let runs = firsts.iter().map(|first| first.run.clone()).collect();
    let keeper = Checkpointer::new(args.keep.checkpoint_every, occasion, &folder, &case, runs)?;
    let experiments = || variants.iter().map(|(experiment, _)| experiment);
    let progress = progress(experiments().zip(others.iter().map(Vec::as_slice)), args.output.quiet);
    let mut table = ComparisonTable {
        args,
        looks,
        variants: &variants,
        provenance: occasion.provenance(&case, describe_variants(experiments())),
        parameters: experiments().map(|experiment| case.parameters(experiment)).collect(),
        overrides: case.overrides(),
        folder: &folder,
        ground: ReplicaContext { others: &others, progress: &progress, share, ranks, quiet: args.output.quiet },
        keeper,
        runs: Vec::new(),
        sheets: Vec::new(),
        frames: Vec::new(),
    };
    for first in firsts {
        table.run_first(first, trajectories)?;
        table.run_more(table.runs.len() - 1, 1)?;
        if table.runs.len() < variants.len() {
            table.write_part(1)?;
        }
    }
    let mut look = 1;
    while look < looks.count() && !table.judged(look).is_decided() {
        look += 1;
        (0..variants.len()).try_for_each(|variant| table.run_more(variant, look))?;
        table.write_part(look)?;
    }
    let judged = table.judged(look);
    table.write(&judged, true)?;
    table.keeper.done()?;
    failures(&judged.outcomes)?;
    Ok(overall(&judged.comparisons))
}

/// Number of replicas of each variant between two looks, and their largest number.
#[derive(Clone, Copy, Debug)]
struct Looks {
    /// Replicas between two looks.
    piece: usize,
    /// Replicas at most.
    most: usize,
}

impl Looks {
    fn of(args: &Compare) -> Self {
        let asked = usize::from(args.repeats.replicas);
        match (args.until_decided, asked) {
            (true, 1) => Self { piece: PIECE, most: MOST },
            (true, _) => Self { piece: PIECE.min(asked), most: asked },
            (false, _) => Self { piece: asked, most: asked },
        }
    }

    fn count(self) -> usize {
        self.most.div_ceil(self.piece)
    }

    /// Replicas of each variant that there are at a look.
    fn replicas(self, look: usize) -> usize {
        (look * self.piece).min(self.most)
    }

    /// Indices, among the replicas besides the first, of those run between the previous look and this one.
    fn range(self, look: usize) -> Range<usize> {
        self.replicas(look - 1).max(1) - 1..self.replicas(look) - 1
    }
}

/// All results so far, and the folder to which they are written.
struct ComparisonTable<'a> {
    args: &'a Compare,
    looks: Looks,
    variants: &'a [Checked],
    provenance: Provenance,
    parameters: Vec<serde_json::Value>,
    overrides: Vec<String>,
    folder: &'a Folder,
    ground: ReplicaContext<'a>,
    keeper: Checkpointer,
    /// All replicas of each variant.
    runs: Vec<Vec<Outcome>>,
    sheets: Vec<TrustSheet>,
    frames: Vec<Frames>,
}

/// Outcomes and verdicts of the runs so far.
struct ComparedRuns {
    outcomes: Vec<Outcome>,
    comparisons: Vec<Verdict>,
    /// A sentence on the number of looks; `None` for a single one.
    looks: Option<String>,
}

impl ComparedRuns {
    /// True if more replicas would change nothing: every answer is given, or all replicas of a variant stopped.
    fn is_decided(&self) -> bool {
        let stopped = self.outcomes.iter().any(|one| one.failure.is_some());
        stopped || self.comparisons.iter().all(|one| one.answer != Answer::Unresolved)
    }

    /// All answers first, then further notes.
    fn sentences(&self) -> Vec<String> {
        let answers = self.comparisons.iter().map(|comparison| comparison.sentence.clone());
        let further = self.comparisons.iter().flat_map(|comparison| comparison.further.clone());
        answers.chain(self.looks.clone()).chain(further).collect()
    }
}

impl ComparisonTable<'_> {
    /// Runs the next variant for the first time.
    fn run_first(&mut self, first: ResumableRun, trajectories: Option<Trajectories>) -> Result<(), StudyError> {
        let (variant, variants, verify) = (self.runs.len(), self.variants, self.args.verify);
        let experiment = &variants[variant].0;
        self.keeper.expects(verify || self.looks.most > 1 || variant + 1 < variants.len());
        let mut seen = Frames::new(experiment, variants.len());
        let names = file_names(variants.iter().map(|(experiment, _)| experiment.name.as_str()));
        let shared = shared(variant, &self.ground, verify);
        let into = Into { folder: self.folder, name: &names[variant], trajectories, others: vec![&mut seen], shared };
        let watch = self.ground.progress.watch(variant * self.looks.most);
        let (outcome, end) = simulate(experiment, first.start, watch, into, &mut self.keeper)?;
        self.frames.push(seen);
        self.keeper.expects(false);
        self.sheets.push(trust(&outcome, &end, verify, self.ground.quiet, &mut self.keeper)?);
        self.runs.push(vec![outcome]);
        Ok(())
    }

    /// Runs the replicas of a variant that belong to a look. If the user stops it, the results so far are written.
    fn run_more(&mut self, variant: usize, look: usize) -> Result<(), StudyError> {
        let more = run_others(variant, self.looks.range(look), &self.ground, &mut self.keeper)?;
        self.runs[variant].extend(more);
        if self.keeper.is_stopped() {
            self.write_part(look)?;
            return Err(self.keeper.words(&self.variants[variant].0.name));
        }
        Ok(())
    }

    fn judged(&self, look: usize) -> ComparedRuns {
        let pooled = self.runs.iter().map(|runs| pool(runs[0].clone(), runs[1..].to_vec()));
        let (outcomes, others): (Vec<Outcome>, Vec<Vec<Outcome>>) = pooled.unzip();
        let (all, count) = (self.looks.count(), self.looks.replicas(look));
        let levels = ErrorLevels::of_look(look, all);
        let comparisons = judge_at(&outcomes, &others, Criteria { margin: self.args.margin, levels });
        let looks = (all > 1).then(|| {
            let most = self.looks.most;
            format!("Judged with {count} of at most {most} replicas of each, at look {look} of {all}: the chances of wrong answers hold for all looks together.")
        });
        ComparedRuns { outcomes, comparisons, looks }
    }

    /// Writes the results after every variant and every look: a long comparison that is stopped keeps what is done.
    fn write_part(&mut self, look: usize) -> Result<(), StudyError> {
        let judged = self.judged(look);
        self.write(&judged, false)
    }

    fn write(&mut self, judged: &ComparedRuns, whole: bool) -> Result<(), StudyError> {
        let verdicts = judged.sentences();
        let yet_to_run = &self.variants[self.runs.len()..];
        let mut notes = notes(&judged.outcomes);
        notes.extend(yet_to_run.iter().map(|(experiment, _)| format!("\"{}\" has not been run yet.", experiment.name)));
        let study = Study {
            provenance: &self.provenance,
            outcomes: &judged.outcomes,
            parameters: &self.parameters,
            verdicts: &verdicts,
            comparisons: &judged.comparisons,
            overrides: &self.overrides,
            notes: &notes,
            trust: &self.sheets,
            frames: &self.frames,
        };
        if !whole {
            self.keeper.helped(write_part(self.folder, &study))?;
            return Ok(());
        }
        let report = self.keeper.helped(write_study(self.folder, &study))?;
        if !self.ground.quiet {
            conclude(&verdicts, "Report", &report);
        }
        Ok(())
    }
}

/// Runs of a comparison, prepared.
struct PreparedComparison {
    case: Case,
    variants: Vec<Checked>,
    /// The first run of each variant.
    firsts: Vec<ResumableRun>,
    /// Replicas of each variant besides its first run.
    others: Vec<Vec<ResumableRun>>,
    trajectories: Option<Trajectories>,
}

impl PreparedComparison {
    fn runs(&self) -> impl Iterator<Item = &RunIdentity> {
        self.firsts.iter().chain(self.others.iter().flatten()).map(|one| &one.run)
    }
}

fn prepare(args: &Compare, looks: Looks, ranks: &Ranks) -> Result<PreparedComparison, StudyError> {
    let replicas = u16::try_from(looks.most).unwrap_or(u16::MAX);
    let asked = ranks.agree(ask(args, replicas, ranks), |(_, variants, _)| {
        mark_of(variants.iter().map(|(experiment, _)| experiment))
    })?;
    let (case, variants, trajectories) = asked;
    let experiments: Vec<&Experiment> = variants.iter().map(|(experiment, _)| experiment).collect();
    let starts = starts(&experiments, replicas, ranks)?;
    let firsts =
        experiments.iter().zip(starts).map(|(experiment, start)| ResumableRun::new((*experiment).clone(), start));
    let firsts = firsts.collect::<Result<_, _>>()?;
    let all = experiments.iter().map(|experiment| others(experiment, replicas));
    let others = all.collect::<Result<_, _>>()?;
    Ok(PreparedComparison { case, variants, firsts, others, trajectories })
}

/// The case, its variants, and the trajectories that are asked for.
type ReadCase = (Case, Vec<Checked>, Option<Trajectories>);

fn ask(args: &Compare, replicas: u16, ranks: &Ranks) -> Result<ReadCase, StudyError> {
    let case = read(&args.case, &args.input.with_every(args.every.as_ref()))?;
    let variants = case.variants(args.effort.seed)?;
    share_threads(&args.effort, ranks)?;
    for (experiment, _) in &variants {
        refuse_idle(experiment, replicas, ranks)?;
    }
    let placed = |(experiment, _): &&Checked| {
        experiment.start.iter().all(|population| matches!(population.amount, Amount::Placed(_)))
    };
    if let (true, Some((placed, _))) = (args.until_decided, variants.iter().find(placed)) {
        return Err(StudyError::Input(format!(
            "error: --until-decided: all particles of \"{}\" start at given places, so that all replicas would be the same run\n\
             help: leave it out, or let particles start at random (`count` or `volume_fraction`)",
            placed.name
        )));
    }
    let trajectories = case.trajectories()?;
    Ok((case, variants, trajectories))
}
