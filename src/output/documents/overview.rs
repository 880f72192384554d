//! Overview of a comparison of variants (experiments of a case): a table of answers, a picture of the differences with
//! the margin (largest accepted difference), and the cost.

use crate::output::document::{AnswerCell as Cell, Block, Matrix};
use crate::output::figures::{COST, IN_PER_CENT, in_per_cent, quantities, symbol};
use crate::output::numbers::{significant, with_error};
use crate::output::panel::Figure;
use crate::output::{Study, Verdict};
use crate::statistics::Judged;

/// Parts of the page of a comparison that are always visible; empty for a single run.
pub fn blocks(study: &Study, figures: &[Figure]) -> Vec<Block> {
    if study.comparisons.is_empty() {
        return Vec::new();
    }
    let mut blocks = vec![Block::Matrix(matrix(study))];
    for name in [IN_PER_CENT, COST] {
        blocks.extend(
            figures.iter().position(|figure| figure.name == name).map(|place| Block::Figures(place..place + 1)),
        );
    }
    blocks
}

/// Table of answers with one column per variant (experiment of a case) and one row per quantity. The head of each
/// column has the settings of its variant. The first row contains the answers for all quantities together. With more
/// than four columns of variants, rows and columns are exchanged.
fn matrix(study: &Study) -> Matrix {
    let judged = |name: &str| study.comparisons.iter().find(|verdict| verdict.variant == name);
    let heads = study.outcomes.iter().enumerate().map(|(place, outcome)| {
        let set = study.overrides.get(place).map_or("", String::as_str);
        let against = judged(&outcome.experiment.name).map(|verdict| against(study, &verdict.reference));
        let words = [Some(set.to_owned()).filter(|set| !set.is_empty()), against].into_iter().flatten();
        (outcome.experiment.name.clone(), words.collect::<Vec<_>>().join(", "))
    });
    // a variant without an answer serves only as the reference of other variants, and has no column
    let columns: Vec<_> = heads.zip(study.outcomes).filter(|((name, _), _)| judged(name).is_some()).collect();
    let verdicts: Vec<&Verdict> = columns.iter().filter_map(|((name, _), _)| judged(name)).collect();
    let together = verdicts.iter().map(|verdict| {
        let stopped = study.outcomes.iter().find(|o| o.failure.is_some() && o.experiment.name == verdict.variant);
        let words = stopped.map(|o| format!("stopped after {} s", significant(o.simulated_seconds, 3)));
        Cell { answer: Some(verdict.answer), words: words.unwrap_or_default() }
    });
    let mut rows = vec![("all together".to_owned(), together.collect())];
    for name in quantities(verdicts.iter().copied()) {
        rows.push((symbol(name), verdicts.iter().map(|verdict| cell(verdict, name)).collect()));
    }
    for name in observed_numbers(&verdicts) {
        rows.push((format!("{name} [observe]"), verdicts.iter().map(|verdict| observed_cell(verdict, name)).collect()));
    }
    let head =
        std::iter::once((String::new(), String::new())).chain(columns.into_iter().map(|(head, _)| head)).collect();
    turned(Matrix { head, rows })
}

/// Text with the name of the reference (another experiment of the case) and with its settings.
fn against(study: &Study, reference: &str) -> String {
    let place = study.outcomes.iter().position(|outcome| outcome.experiment.name == reference);
    let set = place.and_then(|place| study.overrides.get(place)).filter(|set| !set.is_empty());
    set.map_or_else(|| format!("against “{reference}”"), |set| format!("against “{reference}” ({set})"))
}

/// Exchanges rows and columns of a table that has more than five columns, which would be too wide for the page.
fn turned(matrix: Matrix) -> Matrix {
    if matrix.head.len() <= 5 {
        return matrix;
    }
    let names = matrix.rows.iter().map(|(name, _)| (name.clone(), String::new()));
    let head = std::iter::once((String::new(), String::new())).chain(names).collect();
    let row = |(place, (name, words)): (usize, &(String, String))| {
        let title = if words.is_empty() { name.clone() } else { format!("{name} ({words})") };
        (title, matrix.rows.iter().map(|(_, cells)| cells[place].clone()).collect())
    };
    let rows = matrix.head[1..].iter().enumerate().map(row).collect();
    Matrix { head, rows }
}

fn judged(verdict: &Verdict) -> &[Judged] {
    verdict.comparison.as_ref().map_or(&[], |comparison| &comparison.judged)
}

/// Symbols of the numbers that at least one experiment measures and compares because the case has a table `[observe]`,
/// in order of first appearance.
fn observed_numbers<'a>(verdicts: &[&'a Verdict]) -> Vec<&'a str> {
    let mut names: Vec<&str> = Vec::new();
    for one in verdicts.iter().flat_map(|verdict| &verdict.observed) {
        if !names.contains(&one.symbol.as_str()) {
            names.push(&one.symbol);
        }
    }
    names
}

/// Cell with the answer for a measured number, and with the difference in % of the reference or the reason why there is
/// no answer.
fn observed_cell(verdict: &Verdict, symbol: &str) -> Cell {
    let Some(one) = verdict.observed.iter().find(|one| one.symbol == symbol) else {
        return Cell { answer: None, words: "not compared".into() };
    };
    let words = one.percent.map_or_else(|| one.remark.to_owned(), |percent| format!("{} %", with_error(percent)));
    Cell { answer: one.answer, words }
}

/// Cell with the answer for one quantity. It also has the difference on which the answer is based, in % of the scale of
/// the quantity (the value by which its differences are divided).
fn cell(verdict: &Verdict, name: &str) -> Cell {
    let Some(one) = judged(verdict).iter().find(|one| one.tested.name == name) else {
        return Cell { answer: None, words: "not compared".into() };
    };
    let words = in_per_cent(one).map(|found| format!("{} %", with_error(found)));
    Cell { answer: Some(one.answer), words: words.unwrap_or_default() }
}
