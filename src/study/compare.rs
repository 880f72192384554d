//! `diptych compare`: the variants of a case, one after the other, each alone on the machine.

use super::keeper::{Keeper, runs};
use super::occasion::Occasion;
use super::session::{
    Into, StudyError, failures, file_names, progress, read, simulate, start, trust, use_threads, warn,
};
use super::terminal::conclude;
use super::trust::{notes, softness};
use crate::case::describe_variants;
use crate::cli::Compare;
use crate::outcome::Outcome;
use crate::output::{Difference, Study, TrustSheet, cost, numbers, references, write_part, write_study};
use crate::particles::Particles;
use crate::statistics::{Comparison, Estimate, compare as compare_profiles};

/// Two-sided tail of the normal distribution beyond 3 standard deviations, erfc(3/√2).
const NORMAL_BEYOND_THREE: f64 = 0.0027;

/// [s] wall time below which a ratio of two says little of the methods: what is done once, such as the first search of
/// neighbours and the start of threads, takes milliseconds.
const TELLING: f64 = 0.1;

/// Runs all variants of a case and writes one folder.
///
/// # Errors
/// Bad input before anything is computed; failures of engines after everything has been written.
pub fn compare(args: &Compare) -> Result<(), StudyError> {
    compare_on(args, &Occasion::First)
}

/// The same, begun or gone on with: variants that are over are not run again.
pub(super) fn compare_on(args: &Compare, occasion: &Occasion) -> Result<(), StudyError> {
    let case = read(&args.case, &args.input.with_every(args.every.as_ref()))?;
    let variants = case.variants(args.effort.seed)?;
    use_threads(&args.effort)?;
    let starts = variants.iter().map(|(experiment, _)| start(experiment)).collect::<Result<Vec<_>, _>>()?;
    let trajectories = case.trajectories()?;
    let folder = occasion.folder(&args.output, &args.case, "compare")?;
    warn(&variants, args.output.quiet);
    let parameters: Vec<_> = variants.iter().map(|(experiment, _)| case.parameters(experiment)).collect();
    let hashes = starts.iter().map(Particles::fingerprint);
    let runs = runs(variants.iter().map(|(experiment, _)| experiment).zip(hashes))?;
    let mut keeper = Keeper::new(args.keep.checkpoint_every, occasion, &folder, &case, runs)?;
    let provenance = occasion.provenance(&case, describe_variants(variants.iter().map(|(experiment, _)| experiment)));
    let (mut outcomes, mut sheets): (Vec<Outcome>, Vec<TrustSheet>) = (Vec::new(), Vec::new());
    let progress = progress(&variants, args.output.quiet);
    let names = file_names(variants.iter().map(|(experiment, _)| experiment.name.as_str()));
    for (k, ((experiment, _), start)) in variants.iter().zip(starts).enumerate() {
        keeper.expect(args.verify || outcomes.len() + 1 < variants.len());
        let into = Into { folder: &folder, name: &names[k], trajectories, others: Vec::new() };
        let (outcome, end) = simulate(experiment, start, progress.watch(k), into, &mut keeper)?;
        keeper.expect(false);
        sheets.push(trust(&outcome, &end, args.verify, args.output.quiet, &mut keeper)?);
        outcomes.push(outcome);
        // written after every variant: whoever stops a long comparison keeps what is done
        let (verdicts, differences) = judge(&outcomes);
        let yet_to_run = &variants[outcomes.len()..];
        let mut notes = notes(&outcomes);
        notes.extend(yet_to_run.iter().map(|(experiment, _)| format!("\"{}\" has not been run yet.", experiment.name)));
        let study = Study {
            provenance: &provenance,
            outcomes: &outcomes,
            parameters: &parameters,
            verdicts: &verdicts,
            differences: &differences,
            notes: &notes,
            trust: &sheets,
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
    failures(&outcomes)
}

/// Every variant against its reference: the answers in sentences, and the numbers behind them.
fn judge(outcomes: &[Outcome]) -> (Vec<String>, Vec<Difference>) {
    let mut verdicts = Vec::new();
    let mut differences = Vec::new();
    for (place, reference) in references(outcomes).into_iter().enumerate().filter(|(place, other)| place != other) {
        let (outcome, against) = (&outcomes[place], &outcomes[reference]);
        let names = (&outcome.experiment.name, &against.experiment.name);
        if let Some(stopped) = [outcome, against].into_iter().find(|one| one.failure.is_some()) {
            verdicts.push(format!(
                "\"{}\" against \"{}\": not compared, \"{}\" stopped early.",
                names.0, names.1, stopped.experiment.name
            ));
            continue;
        }
        let comparison = compare_profiles(&outcome.profiles, &against.profiles);
        verdicts.push(format!("\"{}\" against \"{}\": {}", names.0, names.1, comparison.sentence));
        differences.extend(rows(&comparison, outcome, against));
        if let Some(rate) = rate(outcome, against) {
            verdicts.extend(rate_sentence(&rate, outcome, against));
            differences.push(rate);
        }
        let ratio = cost(outcome).zip(cost(against)).map(|(cost, against)| cost / against);
        if outcome.timing.wall_seconds.min(against.timing.wall_seconds) < TELLING {
            verdicts.push(format!(
                "\"{}\" against \"{}\": too short a run to compare costs; `diptych chart` measures them.",
                names.0, names.1
            ));
        } else if let Some(ratio) = ratio {
            verdicts.push(format!(
                "\"{}\" took {} times the wall time of \"{}\" (one run each, one after the other, {}).",
                names.0,
                numbers::significant(ratio, 2),
                names.1,
                numbers::counted(outcome.timing.threads, "thread")
            ));
        }
    }
    (verdicts, differences)
}

fn rows(comparison: &Comparison, outcome: &Outcome, against: &Outcome) -> Vec<Difference> {
    let row = |quantity: &crate::statistics::QuantityComparison| {
        let largest = quantity.largest?;
        let slices = quantity.differences.len();
        Some(Difference {
            quantity: quantity.quantity.to_owned(),
            unit: quantity.unit.to_owned(),
            variant: outcome.experiment.name.clone(),
            reference: against.experiment.name.clone(),
            largest: Estimate::new(largest.difference, largest.error),
            y: Some(largest.y),
            rms_in_errors: Some((quantity.chi_square / slices.max(1) as f64).sqrt()),
            slices,
            beyond_three: quantity.beyond,
            expected_beyond_three: quantity.expected_beyond,
        })
    };
    comparison.quantities.iter().filter_map(row).collect()
}

fn rate(outcome: &Outcome, against: &Outcome) -> Option<Difference> {
    let largest = outcome.pair_rate?.less(against.pair_rate?);
    let in_errors = largest.in_errors().map(f64::abs);
    Some(Difference {
        quantity: "pair impacts per time".into(),
        unit: "1/s".into(),
        variant: outcome.experiment.name.clone(),
        reference: against.experiment.name.clone(),
        largest,
        y: None,
        rms_in_errors: in_errors,
        slices: 1,
        beyond_three: usize::from(in_errors.is_some_and(|errors| errors > 3.0)),
        expected_beyond_three: NORMAL_BEYOND_THREE,
    })
}

/// The collision rate in words, with what finite stiffness explains of a difference.
fn rate_sentence(rate: &Difference, outcome: &Outcome, against: &Outcome) -> Option<String> {
    let base = against.pair_rate.map(|rate| rate.value).filter(|base| *base > 0.0)?;
    let (error, in_errors) = (rate.largest.error?, rate.largest.in_errors()?);
    let percent = |value: f64| format!("{} %", numbers::significant(100.0 * value, 2));
    let mut sentence = format!(
        "\"{}\" against \"{}\": pair impacts per time differ by {} ± {} ({} standard errors).",
        outcome.experiment.name,
        against.experiment.name,
        percent(rate.largest.value / base),
        percent(error / base),
        numbers::significant(in_errors, 2)
    );
    if let Some(shrink) = softness(outcome) {
        sentence += &format!(
            " At this stiffness and agitation soft spheres press and crowd as if smaller by {}, but touch at their full diameter: in a dilute gas as often as hard ones.",
            percent(shrink)
        );
    }
    Some(sentence)
}
