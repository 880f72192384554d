//! Document of the validation suite, which compares results with closed forms, other codes and experiments.

use crate::output::document::{Block, Document, Table, TextRow, columns, text};
use crate::output::files::write_summary;
use crate::output::numbers::{UNKNOWN, quantity, significant, with_error};
use crate::output::{
    Folder, NotValidated, OutputError, ValidationNumber, ValidationRow, ValidationStudy, ValidationTier, figures,
    validation,
};
use crate::statistics::{Answer, Estimate};
use serde_json::{Value, json};
use std::path::PathBuf;

/// Writes all results of the suite: one table, the pictures of the rows (comparisons), one page, and finally the
/// summary. Returns the path of the page.
///
/// # Errors
/// An [`OutputError`]. Files written before the error remain, but there is no `summary.json`.
pub fn write_validation(folder: &Folder, study: &ValidationStudy, verdicts: &[String]) -> Result<PathBuf, OutputError> {
    let figures = figures::validation(study.rows);
    let mut body = vec![overview(study), Block::note(LEGEND), Block::Figures(0..usize::from(!study.rows.is_empty()))];
    for tier in ValidationTier::ALL {
        let rows: Vec<&ValidationRow> = study.rows.iter().filter(|row| row.tier == tier).collect();
        if !rows.is_empty() {
            body.push(Block::Heading(heading(tier).into()));
            rows.iter().for_each(|row| body.extend(study.section(row, &figures)));
        }
    }
    body.extend(not_validated(study));
    let document = Document {
        provenance: study.provenance,
        failures: Vec::new(),
        verdicts,
        answers: 1,
        front: Vec::new(),
        notes: &[],
        body,
        tail: Vec::new(),
        tables: vec![("validation.csv".into(), validation::table(study.rows)?)],
        figures,
    };
    let page = document.write_part(folder)?;
    let summary = json!({
        "title": study.provenance.title,
        "command": study.provenance.command,
        "status": if study.rows.iter().any(|row| row.failure.is_some()) { "failed" } else { "complete" },
        "version": env!("CARGO_PKG_VERSION"),
        "quick": study.quick,
        "verdict": study.answer().map(Answer::word),
        "rows": study.rows.iter().map(|row| study.json(row)).collect::<Vec<_>>(),
        "left_out": study.left_out,
        "not_validated": study.not_validated,
    });
    write_summary(folder, &summary)?;
    Ok(page)
}

/// Explanation of the answers, shown below the table with an overview of all rows.
const LEGEND: &str = "Agrees: a run without scatter that deviates by less than the stated tolerance. Equivalent: two one-sided tests at 5 % show a \
    difference below the stated margin. Different: Student's t test finds a difference (1 % for all rows together, Holm within a row), and it is not \
    shown to be within the margin. Unresolved: neither is shown. ±: one standard error, or the error of reading a picture.";

/// Heading of the part of the page about comparisons with one kind of reference.
fn heading(tier: ValidationTier) -> &'static str {
    match tier {
        ValidationTier::ClosedForms => "Closed forms",
        ValidationTier::OtherCodes => "Other codes and theories",
        ValidationTier::Experiments => "Experiments",
    }
}

/// Table of the rows (comparisons) of the suite for a terminal. From each row, the table contains the number that
/// deviates most.
pub fn validation_answers(study: &ValidationStudy) -> String {
    text(&[overview(study)])
}

/// Table with one row per comparison of the suite. Each row shows the number of this comparison that deviates most,
/// with its reference and the verdict.
fn overview(study: &ValidationStudy) -> Block {
    let row = |row: &ValidationRow| -> TextRow {
        let worst = row.worst();
        let of = |get: fn(&ValidationNumber) -> String| worst.map_or(UNKNOWN.to_owned(), get);
        let verdict = match (&row.failure, worst) {
            (None, Some(worst)) => worst.verdict(),
            (why, _) => format!("stopped: {}", why.as_deref().unwrap_or_default()),
        };
        let cells = vec![
            row.name.to_owned(),
            row.tier.name().to_owned(),
            row.numbers.len().to_string(),
            of(|one| one.name.clone()),
            of(|one| shown(one.reference, one.unit)),
            of(|one| shown(one.ours, one.unit)),
            verdict,
        ];
        (row.answer() == Answer::Different, cells)
    };
    Block::Table(Table {
        head: columns("row | reference is | numbers | largest deviation in | reference | ours | verdict"),
        rows: study.rows.iter().map(row).collect(),
        remarks: true,
    })
}

/// Text of a value with its unit and its standard error, or with six digits if the error is 0.
fn shown(found: Estimate, unit: &str) -> String {
    let value =
        if found.error.is_some_and(|error| error == 0.0) { significant(found.value, 6) } else { with_error(found) };
    format!("{value} {unit}").trim_end().to_owned()
}

/// Part of the page about comparisons that the suite does not make.
fn not_validated(study: &ValidationStudy) -> Vec<Block> {
    let mut blocks = vec![Block::heading("Not validated")];
    if !study.left_out.is_empty() {
        blocks.push(Block::Paragraph(format!(
            "Left out by --quick, since they take minutes: {}.",
            study.left_out.join(", ")
        )));
    }
    let row = |one: &NotValidated| (false, vec![one.name.into(), one.reference.into(), one.needs.into()]);
    let head = columns("comparison | reference | not validated: needs");
    let rows = study.not_validated.iter().map(row).collect();
    blocks.push(Block::Table(Table { head, rows, remarks: true }));
    blocks
}

impl ValidationStudy<'_> {
    /// Section of the page about one row (comparison) of the suite: its scene, source, numbers and picture.
    fn section(&self, row: &ValidationRow, figures: &[crate::output::panel::Figure]) -> Vec<Block> {
        let number = |one: &ValidationNumber| -> TextRow {
            let cells = vec![
                one.name.clone(),
                shown(one.reference, one.unit),
                shown(one.ours, one.unit),
                significant(one.share(), 2),
                one.verdict(),
            ];
            (one.answer == Answer::Different, cells)
        };
        let mut section = vec![
            Block::Section(row.name, row.name.to_owned()),
            Block::Paragraph(row.scene.to_owned()),
            Block::entries([
                ("reference", row.source.to_owned()),
                ("does not show", row.not_shown.to_owned()),
                ("verdict", row.word().to_owned()),
                ("case", row.case.to_owned()),
                ("wall time", quantity(row.wall_seconds, "s", 2)),
                ("again", self.command(row)),
            ]),
        ];
        section.extend(row.failure.as_ref().map(|why| Block::Note(format!("Stopped: {why}"))));
        section.push(Block::Table(Table {
            head: columns("number | reference | ours | difference over allowed | verdict"),
            rows: row.numbers.iter().map(number).collect(),
            remarks: true,
        }));
        section.extend(
            figures.iter().position(|figure| figure.name == row.name).map(|place| Block::Figures(place..place + 1)),
        );
        section
    }

    /// Entry of one row (comparison) of the suite in `summary.json`.
    fn json(&self, row: &ValidationRow) -> Value {
        json!({
            "name": row.name,
            "tier": row.tier,
            "scene": row.scene,
            "source": row.source,
            "not_shown": row.not_shown,
            "case": row.case,
            "verdict": row.answer().word(),
            "failure": row.failure,
            "wall_seconds": row.wall_seconds,
            "command": self.command(row),
            "numbers": row.numbers,
        })
    }
}
