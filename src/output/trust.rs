//! Trust sheets, one [`TrustSheet`] per variant: their data, and their tables. `summary.json` holds them whole.

use super::document::{Block, Table, columns};
use super::numbers::{UNKNOWN, quantity, significant, with_error};
use crate::statistics::Estimate;
use serde::Serialize;

/// What a number should be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Expected {
    /// This value.
    Equals(f64),
    /// This value at most, in magnitude.
    AtMost(f64),
    /// Nothing is expected: it is there to be read.
    Anything,
}

/// Whether a number is what it should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Judgement {
    /// It is.
    Good,
    /// It is not.
    Suspect,
    /// Nothing is expected of it.
    Stated,
    /// There is no such number; the remark says why.
    Unknown,
}

/// One number of a trust sheet beside what it should be.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// What it is.
    pub name: &'static str,
    /// Its unit, empty for none.
    pub unit: &'static str,
    /// The number and its standard error; NaN where not known.
    #[serde(flatten)]
    pub found: Estimate,
    /// What it should be.
    pub expected: Expected,
    /// Whether it is.
    pub judgement: Judgement,
    /// Why the number is missing, or what the limit rests on.
    pub remark: String,
}

impl Check {
    /// [-] found less expected, in standard errors; NaN without an error or a value to expect.
    pub fn in_errors(&self) -> f64 {
        match self.expected {
            // a relative difference of 1e-12 is rounding, whatever the scatter
            Expected::Equals(value) if (self.found.value - value).abs() <= 1e-12 * value.abs() => 0.0,
            Expected::Equals(value) if self.found.error > 0.0 => (self.found.value - value) / self.found.error,
            _ => f64::NAN,
        }
    }
}

/// One quantity at the step and window of the run, and at half of both.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Halved {
    /// What it is.
    pub name: &'static str,
    /// Its unit, empty for none.
    pub unit: &'static str,
    /// As the variant is set.
    pub as_run: Estimate,
    /// At half the step and half the window.
    pub halved: Estimate,
}

impl Halved {
    /// Halved less as run, and the standard error of that, as if both stretches were independent.
    pub fn change(&self) -> Estimate {
        Estimate { value: self.halved.value - self.as_run.value, error: self.halved.error.hypot(self.as_run.error) }
    }

    /// [-] the change in its standard errors; NaN without an error.
    pub fn in_errors(&self) -> f64 {
        let change = self.change();
        // what has no unit is a share of one; less than that is rounding
        let scale = if self.unit.is_empty() { 1.0 } else { self.as_run.value.abs() };
        if change.value.abs() <= 1e-12 * scale {
            0.0
        } else if change.error > 0.0 {
            change.value / change.error
        } else {
            f64::NAN
        }
    }
}

/// A short stretch from the final state, run twice: as the variant is set, and at half the step and half the window.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verification {
    /// [s] simulated time of each of the two stretches.
    pub stretch: f64,
    /// [-] wall-clock time of both over that of the run.
    pub cost: f64,
    /// [s] window of the run; the second stretch has half of it.
    pub window: f64,
    /// [s] step of the run, 0 for events; the second stretch has half of it.
    pub time_step: f64,
    /// The quantities compared; those that neither stretch could give are left out.
    pub quantities: Vec<Halved>,
}

/// Whether the halved step was looked at.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum HalvedStep {
    /// It was.
    Verified(Verification),
    /// It was not, and why.
    Unknown(String),
}

/// How far the numbers of one variant can be trusted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrustSheet {
    /// Name of the variant.
    pub variant: String,
    /// The numbers.
    pub checks: Vec<Check>,
    /// What halving the step changes.
    pub halved_step: HalvedStep,
}

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
        (one.in_errors().abs() > SUSPECT, cells)
    };
    let step = if verification.time_step > 0.0 {
        format!("step {}", quantity(verification.time_step, "s", 3))
    } else {
        "exact instants, no step".into()
    };
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
