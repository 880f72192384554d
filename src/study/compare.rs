//! `diptych compare`: runs the variants of a case one after the other. A variant is one of the experiments of a case,
//! and its replicas are runs with different seeds. The first run of each variant is alone on the machine; further
//! replicas run concurrently.

use super::judge::{Criteria, judge_at};
use super::replicas::pool;
use super::trust::notes;
use super::variants::{VariantFindings, VariantResults, Variants};
use crate::case::{Checked, describe_variants};
use crate::cli::Compare;
use crate::experiment::Amount;
use crate::outcome::Outcome;
use crate::output::overall;
use crate::runs::{CommandOrigin, CommandSettings, Ranks, StudyError, read, share_threads};
use crate::statistics::{Answer, ErrorLevels};
use std::ops::Range;

/// Number of further replicas (runs with different seeds) of each variant (experiment of a case) from one interim test
/// of `--until-decided` to the next. Four replicas of each of two variants give Student's t 6 degrees of freedom.
const PIECE: usize = 4;

/// Largest number of replicas (runs with different seeds) of each variant (experiment of a case) with
/// `--until-decided` but without `--replicas`: sixteen tests of 4 further replicas each.
const MOST: usize = 64;

/// Begins or resumes the runs of all variants (experiments) of a case, and writes their results to one folder. Runs
/// that are complete are not repeated. Returns one answer for all comparisons of the variants; `None` if there is a
/// single variant, or if this is a helper process of a command with several processes.
///
/// # Errors
/// Returns an error for bad input, before anything is computed, or for failures of engines, after everything has been
/// written.
pub fn compare(args: &Compare, origin: CommandOrigin, ranks: &Ranks) -> Result<Option<Answer>, StudyError> {
    let settings = CommandSettings {
        checkpoint_every: args.keep.checkpoint_every,
        ..CommandSettings::new(origin, "compare", &args.case, &args.output, &args.effort)
    };
    let looks = Looks::of(args);
    let variants = ranks.agree(variants(args, looks, ranks), Variants::mark)?;
    let (scene, count) = (describe_variants(variants.experiments()), variants.checked.len());
    let Some(results) = VariantResults::begin(&variants, &settings, scene, ranks)? else { return Ok(None) };
    let mut comparison = VariantComparison { variants: &variants, looks, margin: args.margin, results };
    for variant in 0..count {
        let end = comparison.results.run_first(Vec::new())?;
        comparison.results.check(end)?;
        comparison.run_replicas(variant, 1)?;
        if variant + 1 < count {
            comparison.write_part(1)?;
        }
    }
    let mut look = 1;
    while look < looks.count() && !is_decided(&comparison.judged(look)) {
        look += 1;
        (0..count).try_for_each(|variant| comparison.run_replicas(variant, look))?;
        comparison.write_part(look)?;
    }
    let judged = comparison.judged(look);
    let report = comparison.results.write(&judged, true)?;
    comparison.results.finish(&judged, &judged.verdicts, &report)?;
    Ok(overall(&judged.comparisons))
}

/// Numbers of replicas (runs with different seeds) after which a comparison is tested. Each test is called a "look" at
/// the results so far. All tests but the last are interim tests, after which more replicas may follow.
#[derive(Clone, Copy, Debug)]
struct Looks {
    /// Number of further replicas (runs with different seeds) of each variant (experiment of a case) from one test to
    /// the next.
    piece: usize,
    /// Largest number of replicas (runs with different seeds) of each variant (experiment of a case), reached at the
    /// last test.
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

    /// Number of replicas (runs with different seeds) of each variant (experiment of a case) that are complete at the
    /// test with number `look`, counted from 1.
    fn replicas(self, look: usize) -> usize {
        (look * self.piece).min(self.most)
    }

    /// Indices of the replicas (runs with different seeds) of each variant (experiment of a case) that are added for
    /// the test with number `look`, counted from 1. Index 0 is left out: it is the first run of the variant, which is
    /// done earlier.
    fn range(self, look: usize) -> Range<usize> {
        self.replicas(look - 1).max(1)..self.replicas(look)
    }
}

/// Results of a comparison so far, with the tests planned for it and the margin (largest accepted difference) by which
/// results are judged.
struct VariantComparison<'a> {
    variants: &'a Variants,
    looks: Looks,
    /// [-] margin of equivalence: largest relative difference of two results that count as equal in the answers.
    margin: f64,
    results: VariantResults<'a>,
}

impl VariantComparison<'_> {
    /// Runs the replicas (runs with different seeds) of a variant (experiment of a case) that the test with number
    /// `look` requires. If the user stops the command, the results so far are written, and an error that says so is
    /// returned.
    fn run_replicas(&mut self, variant: usize, look: usize) -> Result<(), StudyError> {
        if self.results.run_replicas(variant, self.looks.range(look))? {
            return Ok(());
        }
        self.write_part(look)?;
        Err(self.results.stopped(variant))
    }

    /// Writes the results so far, judged with the error levels (probabilities of wrong answers) of the test with
    /// number `look`. This is done after every variant (experiment of a case) and every test, so that results remain
    /// if the command is stopped.
    fn write_part(&self, look: usize) -> Result<(), StudyError> {
        self.results.write(&self.judged(look), false).map(drop)
    }

    /// Judges the results so far with the error levels (probabilities of wrong answers) of the test with number
    /// `look`. The findings contain the answers of the comparisons first, then further sentences.
    fn judged(&self, look: usize) -> VariantFindings {
        let pooled = self.results.runs.iter().map(|runs| pool(runs[0].clone(), runs[1..].to_vec()));
        let (outcomes, others): (Vec<Outcome>, Vec<Vec<Outcome>>) = pooled.unzip();
        let (all, count) = (self.looks.count(), self.looks.replicas(look));
        let levels = ErrorLevels::of_look(look, all);
        let comparisons = judge_at(&outcomes, &others, Criteria { margin: self.margin, levels });
        let looks = (all > 1).then(|| {
            let most = self.looks.most;
            format!("Judged with {count} of at most {most} replicas of each, at look {look} of {all}: the chances of wrong answers hold for all looks together.")
        });
        let answers = comparisons.iter().map(|comparison| comparison.sentence.clone());
        let further = comparisons.iter().flat_map(|comparison| comparison.further.clone());
        let yet_to_run = self.variants.experiments().skip(outcomes.len());
        let yet_to_run = yet_to_run.map(|experiment| format!("\"{}\" has not been run yet.", experiment.name));
        VariantFindings {
            verdicts: answers.chain(looks).chain(further).collect(),
            overrides: self.variants.case.overrides(),
            notes: notes(&outcomes).into_iter().chain(yet_to_run).collect(),
            outcomes,
            comparisons,
            ..VariantFindings::default()
        }
    }
}

/// True if the comparison can end: no comparison of two variants (experiments of a case) is unresolved, or a replica
/// (run with another seed) of some variant stopped early.
fn is_decided(findings: &VariantFindings) -> bool {
    let stopped = findings.outcomes.iter().any(|one| one.failure.is_some());
    stopped || findings.comparisons.iter().all(|one| one.answer != Answer::Unresolved)
}

fn variants(args: &Compare, looks: Looks, ranks: &Ranks) -> Result<Variants, StudyError> {
    let case = read(&args.case, &args.input.with_every(args.every.as_ref()))?;
    let checked = case.variants(args.effort.seed)?;
    share_threads(&args.effort, ranks)?;
    let placed = |(experiment, _): &&Checked| {
        experiment.start.iter().all(|population| matches!(population.amount, Amount::Placed(_)))
    };
    if let (true, Some((placed, _))) = (args.until_decided, checked.iter().find(placed)) {
        return Err(StudyError::Input(format!(
            "error: --until-decided: all particles of \"{}\" start at given places, so that all replicas would be the same run\n\
             help: leave it out, or let particles start at random (`count` or `volume_fraction`)",
            placed.name
        )));
    }
    let trajectories = case.trajectories()?;
    let replicas = u16::try_from(looks.most).unwrap_or(u16::MAX);
    let variants = Variants { case, checked, replicas, trajectories, verify: args.verify };
    variants.refuse_idle(ranks)?;
    Ok(variants)
}
