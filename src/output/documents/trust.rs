//! The trust sheets as parts of a document.

use crate::output::document::{Block, Table, columns};
use crate::output::numbers::{UNKNOWN, quantity, significant, with_error};
use crate::output::{Check, Expected, Halved, HalvedStep, Judgement, TrustSheet, Verification};
use crate::statistics::Estimate;

/// Changes beyond this many standard errors are marked.
const SUSPECT: f64 = 3.0;

/// All sheets as parts of a page.
pub(super) fn blocks(sheets: &[TrustSheet]) -> Vec<Block> {
    if sheets.is_empty() {
        return Vec::new();
    }
    let mut blocks = vec![Block::heading("Trust sheet")];
    for sheet in sheets {
        blocks.extend([Block::Subheading(sheet.variant.clone()), checks(&sheet.checks)]);
        match &sheet.halved_step {
            HalvedStep::Verified(verification) => blocks.extend(halved(verification)),
            HalvedStep::Unknown(why) => blocks.push(Block::Note(format!("Half the step: {why}."))),
        }
    }
    blocks.push(Block::note("SE: standard error. Marked rows are not what they should be."));
    blocks
}

/// A value with its error where there is one that is more than rounding.
fn value(found: impl Into<Option<Estimate>>, unit: &str) -> String {
    let Some(found) = found.into() else { return format!("{UNKNOWN}{unit}") };
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

fn checks(checks: &[Check]) -> Block {
    let row = |check: &Check| {
        let expected = match check.expected {
            Expected::Equals(value) => significant(value, 4),
            Expected::AtMost(limit) => format!("≤ {}", significant(limit, 2)),
            Expected::Anything => UNKNOWN.into(),
        };
        let judgement = match check.judgement {
            Judgement::Good => "yes",
            Judgement::Suspect => "no",
            Judgement::Stated | Judgement::Unknown => UNKNOWN,
        };
        let cells = vec![
            check.name.into(),
            value(check.found, check.unit),
            expected,
            significant(check.in_errors(), 2),
            judgement.into(),
            check.remark.clone(),
        ];
        (check.judgement == Judgement::Suspect, cells)
    };
    let head = columns(" | found ± 1 SE | should be | off by, in SE | is it | remark");
    Block::Table(Table { head, rows: checks.iter().map(row).collect(), remarks: true })
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
