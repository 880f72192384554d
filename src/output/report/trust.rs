//! The trust sheets: a table per variant.

use super::{note, table};
use crate::output::numbers::{UNKNOWN, quantity, significant, with_error};
use crate::output::{Check, Expected, HalvedStep, Judgement, TrustSheet, Verification};
use crate::statistics::Estimate;
use maud::{Markup, html};

/// Changes beyond this many standard errors are marked.
const SUSPECT: f64 = 3.0;

/// All sheets.
pub(super) fn sheets(sheets: &[TrustSheet]) -> Markup {
    html! {
        @if !sheets.is_empty() {
            h2 { "Trust sheet" }
            @for sheet in sheets {
                h3 { (sheet.variant) }
                (checks(&sheet.checks))
                @match &sheet.halved_step {
                    HalvedStep::Verified(verification) => (halved(verification)),
                    HalvedStep::Unknown(why) => (note(&format!("Half the step: {why}."))),
                }
            }
            (note("SE: standard error. Marked rows are not what they should be."))
        }
    }
}

/// A value with its error where there is one that is more than rounding.
fn value(found: Estimate, unit: &str) -> String {
    let space = if unit.is_empty() || !found.value.is_finite() { "" } else { " " };
    let text = if found.error > 1e-12 * found.value.abs() {
        with_error(found.value, found.error)
    } else if found.value.fract() == 0.0 && found.value.abs() < 1e6 {
        format!("{}", found.value)
    } else {
        significant(found.value, 4)
    };
    format!("{text}{space}{unit}")
}

fn checks(checks: &[Check]) -> Markup {
    let expected = |check: &Check| match check.expected {
        Expected::Equals(value) => significant(value, 4),
        Expected::AtMost(limit) => format!("≤ {}", significant(limit, 2)),
        Expected::Anything => UNKNOWN.into(),
    };
    let judgement = |check: &Check| match check.judgement {
        Judgement::Good => "yes",
        Judgement::Suspect => "no",
        Judgement::Stated | Judgement::Unknown => UNKNOWN,
    };
    html! {
        div.wide {
            table {
                thead {
                    tr {
                        @for cell in ["", "found ± 1 SE", "should be", "off by, in SE", "is it"] {
                            th scope="col" { (cell) }
                        }
                        th.text scope="col" { "remark" }
                    }
                }
                tbody {
                    @for check in checks {
                        tr.mark[check.judgement == Judgement::Suspect] {
                            th scope="row" { (check.name) }
                            td { (value(check.found, check.unit)) }
                            td { (expected(check)) }
                            td { (significant(check.in_errors(), 2)) }
                            td { (judgement(check)) }
                            td.words { (check.remark) }
                        }
                    }
                }
            }
        }
    }
}

fn halved(verification: &Verification) -> Markup {
    let row = |one: &crate::output::Halved| {
        let cells = vec![
            one.name.to_owned(),
            value(one.as_run, one.unit),
            value(one.halved, one.unit),
            value(one.change(), one.unit),
            significant(one.in_errors(), 2),
        ];
        (one.in_errors().abs() > SUSPECT, cells)
    };
    let rows: Vec<_> = verification.quantities.iter().map(row).collect();
    let exact = "exact instants, no step".to_string();
    let step = verification.time_step.map_or(exact, |step| format!("step {}", quantity(step, "s", 3)));
    html! {
        (table(&["half the step and window", "as run", "halved", "change", "change in SE"], &rows))
        (note(&format!(
            "Two stretches of {} from the final state: as run ({step}, window {}), and at half of both. They cost {} times the \
             run. The change is judged as if the stretches were independent, which errs to the safe side at their start.",
            quantity(verification.stretch, "s", 3),
            quantity(verification.window, "s", 3),
            significant(verification.cost, 2)
        )))
    }
}
