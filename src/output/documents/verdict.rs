//! Part of a page with the answers of a comparison: which variants are equivalent or different, and by how much. A
//! variant is one of the experiments of a case.

use crate::output::OutputError;
use crate::output::csv::{CsvTable, number};
use crate::output::document::{Block, known};
use crate::output::figures::symbol;
use crate::output::numbers::{percent, quantity, significant, with_error};
use crate::output::{Basis, ObservedDifference, Study, Verdict};
use crate::statistics::{Answer, Deviation, Estimate, Judged};

/// Answers for each compared pair of variants (experiments of a case), with the numbers on which the answers are based.
/// The list is empty for a single run.
pub fn blocks(study: &Study) -> Vec<Block> {
    if study.comparisons.is_empty() {
        return Vec::new();
    }
    let mut blocks = vec![answers(study)];
    study.comparisons.iter().for_each(|verdict| blocks.extend(of_pair(verdict)));
    blocks.push(legend());
    blocks
}

/// Note that explains the columns of the tables made by [`of_pair`].
pub fn legend() -> Block {
    Block::note(
        "SE: standard error. Clearest: the slice or instant that deviates most in its standard error. Chance: of as large a difference between equal systems, \
         for this observable alone; marked rows have a difference at 1 % for all observables together (Holm). Equivalent within: the margin that two one-sided tests at 5 % allow \
         in every slice or at every instant; smooth, within: the same for a difference that is a sum of a few smooth shapes. Would be seen from: the smallest uniform difference that is found in 80 % of cases.",
    )
}

/// Parts of the page with the numbers on which the answer for one pair of variants (experiments of a case) is based.
pub fn of_pair(verdict: &Verdict) -> Vec<Block> {
    let title = format!("“{}” − “{}”", verdict.variant, verdict.reference);
    let mut blocks = vec![Block::Label(title), Block::note(verdict.reason.clone())];
    if let Some(comparison) = &verdict.comparison {
        let place = if verdict.basis == Basis::Curves { ("at t", "s") } else { ("at y", "m") };
        let head = format!(
            "observable | scale | answer | mean ± 1 SE [% of scale] | clearest ± 1 SE [% of scale] | {} | chance | equivalent within | smooth, within | would be seen from",
            place.0
        );
        blocks.push(Block::table(&head, comparison.judged.iter().map(|one| (one.detected, row(one, place.1)))));
    }
    if !verdict.observed.is_empty() {
        let head = "measured under [observe] | answer | difference ± 1 SE | in % of the reference | chance | equivalent within | remark";
        blocks.push(Block::table(head, verdict.observed.iter().map(observed_row)));
        blocks.push(Block::note(
            "Measured numbers have the same tests and the same margin, and a level of 1 % of their own. They are no part of the answer for all together.",
        ));
    }
    blocks
}

fn observed_row(one: &ObservedDifference) -> (bool, Vec<String>) {
    let unit = if one.unit.is_empty() { String::new() } else { format!(" [{}]", one.unit) };
    let cells = vec![
        format!("{}{unit}", one.symbol),
        one.word().to_owned(),
        with_error(one.difference),
        with_error(one.percent),
        significant(one.chance, 2),
        one.reached.map_or_else(String::new, |reached| percent(reached, 1.0)),
        one.remark.to_owned(),
    ];
    (one.answer == Some(Answer::Different), cells)
}

/// Contents of `observed-differences.csv`: differences of measured numbers in the unit of each number and in per cent
/// of the reference, with standard errors. `None` if no such numbers were compared.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub(super) fn observed_csv(study: &Study) -> Result<Option<Vec<u8>>, OutputError> {
    if study.comparisons.iter().all(|verdict| verdict.observed.is_empty()) {
        return Ok(None);
    }
    let mut table = CsvTable::new();
    table.head(
        "variant,reference,measurement,quantity,unit,difference,difference_se,difference_percent,difference_percent_se,\
         chance,equivalent_within,answer,remark",
    )?;
    for verdict in study.comparisons {
        for one in &verdict.observed {
            let names = [&verdict.variant, &verdict.reference, one.measurement, &one.quantity, one.unit];
            let values = [
                Some(one.difference.value),
                one.difference.error,
                one.percent.map(|percent| percent.value),
                one.percent.and_then(|percent| percent.error),
                one.chance,
                one.reached,
            ];
            let words = [one.word(), one.remark].map(str::to_owned);
            table.row(names.map(str::to_owned).into_iter().chain(values.map(number)).chain(words))?;
        }
    }
    table.bytes().map(Some)
}

/// Table with one row per variant (experiment of a case): its settings, its reference and its answer.
fn answers(study: &Study) -> Block {
    let row = |(place, outcome): (usize, &crate::outcome::Outcome)| {
        let name = &outcome.experiment.name;
        let judged: Option<&Verdict> = study.comparisons.iter().find(|verdict| verdict.variant == *name);
        let set = study.overrides.get(place).cloned().unwrap_or_default();
        let cell = |text: Option<String>| known(text.is_some(), text.unwrap_or_default());
        let cells = vec![
            name.clone(),
            known(!set.is_empty(), set),
            cell(judged.map(|verdict| verdict.reference.clone())),
            cell(judged.map(|verdict| verdict.answer.word().to_owned())),
        ];
        (outcome.failure.is_some(), cells)
    };
    Block::table("variant | sets | against | verdict", study.outcomes.iter().enumerate().map(row))
}

fn row(one: &Judged, across: &str) -> Vec<String> {
    let tested = &one.tested;
    let over = |deviation: Deviation| {
        with_error(Estimate::new(deviation.difference, deviation.error).times(100.0 / tested.scale))
    };
    let deviation = |found: Option<Deviation>| found.map_or_else(|| known(false, String::new()), over);
    let scale = format!("{} {}", significant(tested.scale, 3), tested.unit);
    let scale = format!("{}: {}", tested.scale_is, scale.trim_end());
    vec![
        symbol(&tested.name),
        scale,
        one.answer.word().into(),
        deviation(tested.mean),
        deviation(tested.largest),
        quantity(tested.largest.and_then(|largest| largest.place), across, 3),
        significant(tested.chance, 2),
        percent(one.reached, 1.0),
        percent(one.reached_smooth, 1.0),
        percent(one.detectable, 1.0),
    ]
}
