//! `diptych compare`: the variants of a case, one after the other, each alone on the machine.

use super::session::{StudyError, failures, folder, provenance, read, simulate, start, trust, use_threads, warn};
use super::terminal::conclude;
use super::trust::{notes, softness};
use crate::case::describe_variants;
use crate::cli::Compare;
use crate::outcome::Outcome;
use crate::output::{Difference, Study, TrustSheet, cost, numbers, references, write_part, write_study};
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
    let case = read(&args.case, &args.input)?;
    let variants = case.variants(args.effort.seed)?;
    use_threads(&args.effort)?;
    let starts = variants.iter().map(|(experiment, _)| start(experiment)).collect::<Result<Vec<_>, _>>()?;
    let folder = folder(&args.output, &args.case, "compare")?;
    warn(&variants, args.output.quiet);
    let parameters: Vec<_> = variants.iter().map(|(experiment, _)| case.parameters(experiment)).collect();
    let provenance = provenance(&case, describe_variants(variants.iter().map(|(experiment, _)| experiment)));
    let (mut outcomes, mut sheets): (Vec<Outcome>, Vec<TrustSheet>) = (Vec::new(), Vec::new());
    for ((experiment, _), start) in variants.iter().zip(starts) {
        let (outcome, end) = simulate(experiment, start, args.output.quiet, None);
        sheets.push(trust(&outcome, &end, args.verify, args.output.quiet));
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
        if !yet_to_run.is_empty() {
            write_part(&folder, &study)?;
            continue;
        }
        let report = write_study(&folder, &study)?;
        if !args.output.quiet {
            conclude(&verdicts, "Report", &report);
        }
    }
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
        let rate = rate(outcome, against);
        if let Some(sentence) = rate_sentence(&rate, outcome, against) {
            verdicts.push(sentence);
        }
        differences.push(rate);
        let ratio = cost(outcome) / cost(against);
        if outcome.timing.wall_seconds.min(against.timing.wall_seconds) < TELLING {
            verdicts.push(format!(
                "\"{}\" against \"{}\": too short a run to compare costs; `diptych chart` measures them.",
                names.0, names.1
            ));
        } else if ratio.is_finite() {
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
            largest: Estimate { value: largest.difference, error: largest.error },
            y: largest.y,
            rms_in_errors: (quantity.chi_square / slices.max(1) as f64).sqrt(),
            slices,
            beyond_three: quantity.beyond,
            expected_beyond_three: quantity.expected_beyond,
        })
    };
    comparison.quantities.iter().filter_map(row).collect()
}

fn rate(outcome: &Outcome, against: &Outcome) -> Difference {
    let (a, b) = (outcome.pair_rate, against.pair_rate);
    let largest = Estimate { value: a.value - b.value, error: a.error.hypot(b.error) };
    let in_errors = largest.value / largest.error;
    Difference {
        quantity: "pair impacts per time".into(),
        unit: "1/s".into(),
        variant: outcome.experiment.name.clone(),
        reference: against.experiment.name.clone(),
        largest,
        y: f64::NAN,
        rms_in_errors: in_errors.abs(),
        slices: 1,
        beyond_three: usize::from(in_errors.abs() > 3.0),
        expected_beyond_three: NORMAL_BEYOND_THREE,
    }
}

/// The collision rate in words, with what finite stiffness explains of a difference.
fn rate_sentence(rate: &Difference, outcome: &Outcome, against: &Outcome) -> Option<String> {
    let base = against.pair_rate.value;
    if !(base > 0.0 && rate.largest.error > 0.0) {
        return None;
    }
    let percent = |value: f64| format!("{} %", numbers::significant(100.0 * value, 2));
    let mut sentence = format!(
        "\"{}\" against \"{}\": pair impacts per time differ by {} ± {} ({} standard errors).",
        outcome.experiment.name,
        against.experiment.name,
        percent(rate.largest.value / base),
        percent(rate.largest.error / base),
        numbers::significant(rate.in_errors(), 2)
    );
    if let Some(shrink) = softness(outcome) {
        sentence += &format!(
            " At this stiffness and agitation soft spheres press and crowd as if smaller by {}, but touch at their full diameter: in a dilute gas as often as hard ones.",
            percent(shrink)
        );
    }
    Some(sentence)
}
