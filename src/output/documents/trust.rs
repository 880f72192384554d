//! Parts of a document about the trust sheets. A trust sheet contains checks of the results of a run. A variant is one
//! of the experiments of a case.

use crate::output::document::{Block, Table};
use crate::output::numbers::{UNKNOWN, quantity, significant, with_error};
use crate::output::{Expected, Halved, HalvedStep, Judgement, TrustCheck, TrustSheet, Verification};
use crate::statistics::Estimate;

/// Number of standard errors. A change by a halved time step that is larger is highlighted.
const SUSPECT: f64 = 3.0;

/// Trust sheets (checks of the results) of all variants (experiments of a case) as parts of a page. A table has one
/// column per variant.
pub(super) fn blocks(sheets: &[TrustSheet]) -> Vec<Block> {
    if sheets.is_empty() {
        return Vec::new();
    }
    let mut blocks = vec![checks(sheets)];
    for sheet in sheets {
        match &sheet.halved_step {
            HalvedStep::Verified(verification) => {
                blocks.push(Block::Subheading(sheet.variant.clone()));
                blocks.extend(halved(verification));
            }
            HalvedStep::Unknown(_) => {}
        }
    }
    let unknown = sheets.iter().filter_map(|sheet| match &sheet.halved_step {
        HalvedStep::Verified(_) => None,
        HalvedStep::Unknown(why) => Some(why),
    });
    // each reason is written only once, because several variants may have the same reason
    let mut told: Vec<&String> = Vec::new();
    for why in unknown {
        if !told.contains(&why) {
            told.push(why);
        }
    }
    blocks.extend(told.iter().map(|why| Block::Note(format!("Half the step: {why}."))));
    blocks.push(Block::note(
        "SE: standard error. ✓: as it should be, off by so many standard errors where that is known. Marked rows have what is not as it should be: “suspect”.",
    ));
    blocks
}

/// Text of a value with its unit and its standard error. An error of at most 1e-12 of the value is a rounding error,
/// and is left out.
fn value(found: impl Into<Option<Estimate>>, unit: &str) -> String {
    let Some(found) = found.into() else { return UNKNOWN.into() };
    let space = if unit.is_empty() { "" } else { " " };
    let text = if found.error.is_some_and(|error| error > 1e-12 * found.value.abs()) {
        with_error(found)
    } else if found.value.fract() == 0.0 && found.value.abs() < 1e6 {
        format!("{}", found.value)
    } else {
        significant(found.value, 4)
    };
    format!("{text}{space}{unit}")
}

/// Table of the checks, with one row per check and one column per variant (experiment of a case).
fn checks(sheets: &[TrustSheet]) -> Block {
    let mut names: Vec<&'static str> = Vec::new();
    for check in sheets.iter().flat_map(|sheet| &sheet.checks) {
        if !names.contains(&check.name) {
            names.push(check.name);
        }
    }
    let row = |name: &&'static str| {
        let of = |sheet: &TrustSheet| sheet.checks.iter().find(|check| check.name == *name).cloned();
        let found: Vec<Option<TrustCheck>> = sheets.iter().map(of).collect();
        let all = || found.iter().flatten();
        let expected = distinct(all().map(|check| expected(check.expected)));
        let cells = found.iter().map(|check| check.as_ref().map_or_else(|| UNKNOWN.to_owned(), cell));
        let remarks = distinct(all().map(|check| check.remark.clone()).filter(|remark| !remark.is_empty()));
        let suspect = all().any(|check| check.judgement == Judgement::Suspect);
        (suspect, [(*name).to_owned(), expected].into_iter().chain(cells).chain([remarks]).collect())
    };
    let variants = sheets.iter().map(|sheet| sheet.variant.clone());
    let head = ["found ± 1 SE".to_owned(), "should be".into()].into_iter().chain(variants).chain(["remark".into()]);
    Block::Table(Table { head: head.collect(), rows: names.iter().map(row).collect(), remarks: true })
}

/// Joins the distinct texts in order of first appearance, separated by semicolons.
fn distinct(texts: impl Iterator<Item = String>) -> String {
    let mut seen: Vec<String> = Vec::new();
    for text in texts {
        if !seen.contains(&text) {
            seen.push(text);
        }
    }
    seen.join("; ")
}

fn expected(expected: Expected) -> String {
    match expected {
        Expected::Equals(value) => significant(value, 4),
        Expected::AtMost(limit) => format!("≤ {}", significant(limit, 2)),
        Expected::Anything => UNKNOWN.into(),
    }
}

/// Text of a check: its value, its deviation from the expected value in standard errors, and a mark for a good or
/// suspect value.
fn cell(check: &TrustCheck) -> String {
    let off = check
        .in_errors()
        .filter(|off| *off != 0.0)
        .map_or(String::new(), |off| format!(" ({} SE)", significant(off, 2)));
    let value = value(check.found, check.unit);
    match check.judgement {
        Judgement::Good => format!("{value}{off} ✓"),
        Judgement::Suspect => format!("{value}{off} suspect"),
        Judgement::Stated | Judgement::Unknown => value,
    }
}

fn halved(verification: &Verification) -> [Block; 2] {
    let row = |one: &Halved| {
        let cells = vec![
            one.name.to_owned(),
            value(one.as_run, one.unit),
            value(one.halved, one.unit),
            value(one.change(), one.unit),
            significant(one.in_errors(), 2),
        ];
        (one.in_errors().is_some_and(|errors| errors.abs() > SUSPECT), cells)
    };
    let exact = "exact instants, no step".to_string();
    let step = verification.time_step.map_or(exact, |step| format!("step {}", quantity(step, "s", 3)));
    let head = "half the step and window | as run | halved | change | change in SE";
    let note = format!(
        "Two stretches of {} from the final state: as run ({step}, window {}), and at half of both. They cost {} times the \
         run. The change is judged as if the stretches were independent, which errs to the safe side at their start.",
        quantity(verification.stretch, "s", 3),
        quantity(verification.window, "s", 3),
        significant(verification.cost, 2)
    );
    [Block::table(head, verification.quantities.iter().map(row)), Block::Note(note)]
}
