//! Document of a sensitivity study, which changes one factor of a case at a time.

use crate::output::document::{Block, Document, Table, known};
use crate::output::numbers::{percent, quantity, significant, with_error};
use crate::output::sensitivity::{Factor, SensitivityStudy, Shift};
use crate::output::{Basis, Folder, OutputError, csv, figures};
use crate::statistics::{Answer, Estimate};
use serde_json::json;
use std::path::PathBuf;

/// Writes all results of a sensitivity study, and returns the path of the page.
///
/// # Errors
/// An [`OutputError`]. Files written before the error remain, but there is no `summary.json`.
pub fn write_sensitivity(folder: &Folder, study: &SensitivityStudy) -> Result<PathBuf, OutputError> {
    let numbers = json!({
        "margin": study.margin,
        "verdict": study.factors.iter().map(|factor| factor.answer).max().map(Answer::word),
        "factors": study.factors,
        "left_out": study.left_out,
        "runs": study.runs,
    });
    document(study)?.write(folder, numbers)
}

/// Writes the present results of an unfinished study: all files except `summary.json`. Returns the path of the page.
///
/// # Errors
/// Errors of [`write_sensitivity`].
pub fn write_sensitivity_part(folder: &Folder, study: &SensitivityStudy) -> Result<PathBuf, OutputError> {
    document(study)?.write_part(folder)
}

fn document<'a>(study: &'a SensitivityStudy<'a>) -> Result<Document<'a>, OutputError> {
    let figures = figures::sensitivity(study);
    let mut body = vec![Block::Figures(0..figures.len()), Block::heading("Factors"), factors(study)];
    body.extend(basis(study).map(Block::note));
    if let Some(all) = shifts(study) {
        body.extend([Block::heading("All shifts"), all]);
        body.push(Block::note(
            "Shift: with the factor less without it, ± one standard error (SE), in % of the scale of the observable (sensitivity.csv has the scales and units). \
             Marked rows hold something beyond the margin; of all shifts together none is found by chance alone in 99 of 100 studies (Holm).",
        ));
    }
    body.push(Block::heading("Sizes, and where they are from"));
    let sizes = study
        .factors
        .iter()
        .map(|factor| (false, vec![factor.name.clone(), factor.change.clone(), factor.why.clone()]));
    body.push(remarks("factor | change | why by so much", sizes));
    if !study.left_out.is_empty() {
        let left_out = study.left_out.iter().map(|one| (false, vec![one.name.clone(), one.why.clone()]));
        body.extend([Block::heading("Left out"), remarks("factor | why", left_out)]);
    }
    body.extend([Block::heading("Runs"), runs(study)]);
    let failed = study.runs.iter().filter_map(|run| Some(format!("“{}”: {}", run.name, run.failure.as_ref()?)));
    let failed: Vec<String> = failed.collect();
    if !failed.is_empty() {
        body.extend([Block::heading("Runs that stopped early"), Block::List(failed)]);
    }
    Ok(Document {
        provenance: study.provenance,
        failures: Vec::new(),
        verdicts: study.sentences,
        answers: usize::MAX,
        front: Vec::new(),
        notes: study.notes,
        body,
        tail: Vec::new(),
        tables: vec![("sensitivity.csv".to_owned(), csv::sensitivity(study)?)],
        figures,
    })
}

/// Table whose last column contains sentences.
fn remarks(head: &str, rows: impl Iterator<Item = (bool, Vec<String>)>) -> Block {
    let Block::Table(table) = Block::table(head, rows) else { return Block::note("") };
    Block::Table(Table { remarks: true, ..table })
}

/// Table of the changed factors (inputs of the case) and their effects; the most important factor is first.
fn factors(study: &SensitivityStudy) -> Block {
    let row = |factor: &Factor| {
        let shift = factor.headline();
        let answer = if factor.stopped.is_some() { "stopped early" } else { factor.answer.word() };
        let cells = vec![
            factor.name.clone(),
            factor.change.clone(),
            answer.to_owned(),
            shift.map_or_else(|| known(false, String::new()), share),
            shift.map_or_else(
                || known(false, String::new()),
                |shift| significant(shift.share().abs() / study.margin, 2),
            ),
            shift.map_or_else(|| known(false, String::new()), |shift| shift.observable.to_owned()),
            quantity(shift.and_then(|shift| shift.time), "s", 3),
            factor.runs[1].join(", "),
        ];
        (factor.answer == Answer::Different, cells)
    };
    let head = "factor | change | verdict | largest shift ± 1 SE [% of scale] | in margins | of | at t | against";
    Block::table(head, study.factors.iter().map(row))
}

fn share(shift: &Shift) -> String {
    with_error(Estimate { value: 100.0 * shift.share(), error: shift.share_error().map(|error| 100.0 * error) })
}

/// Note on the kind of results (averages, curves or paths) by which runs are compared; `None` if there are no results.
fn basis(study: &SensitivityStudy) -> Option<&'static str> {
    match study.factors.iter().find_map(|factor| factor.basis)? {
        Basis::Averages => Some(
            "The case is steady: shifts are of averages over time and over the channel, of the shear stress with the sign of its side, of the number density next to the walls. \
             Rates are those of as many particles as the case has.",
        ),
        Basis::Curves => Some(
            "The case is not steady: shifts are of curves over time, of their mean or at the instant where they are clearest, in % of the largest value of the case as it is. \
             Errors are from the scatter between replicas.",
        ),
        Basis::Paths => Some(
            "There are few particles: shifts are the largest of any particle at the last instant at which nothing touches and paths can be foretold; velocities over the largest speed, \
             places over that speed times the time.",
        ),
        Basis::Nothing => None,
    }
}

/// Table of the shifts (changes of observables by a changed factor), with one row per factor and one column per
/// observable; `None` without shifts.
fn shifts(study: &SensitivityStudy) -> Option<Block> {
    let names = study.observables();
    if names.is_empty() {
        return None;
    }
    let row = |factor: &Factor| {
        let cell = |name: &&str| {
            let shift = factor.shifts.iter().find(|shift| shift.observable == *name);
            shift.map_or_else(|| known(false, String::new()), share)
        };
        let cells = std::iter::once(factor.name.clone()).chain(names.iter().map(cell)).collect();
        (factor.answer == Answer::Different, cells)
    };
    Some(Block::table(&format!("factor | {}", names.join(" | ")), study.factors.iter().map(row)))
}

/// Table of all runs of the study, with their settings and wall-clock times.
fn runs(study: &SensitivityStudy) -> Block {
    let all: f64 = study.runs.iter().map(|run| run.wall_seconds).sum();
    let row = |run: &crate::output::sensitivity::SensitivityRun| {
        let cells = vec![
            run.name.clone(),
            known(!run.set.is_empty(), run.set.clone()),
            crate::case::name_of(run.model).to_owned(),
            run.replicas.to_string(),
            if run.steady { "yes" } else { "no" }.to_owned(),
            quantity(run.simulated_seconds, "s", 3),
            format!("{} ({})", quantity(run.wall_seconds, "s", 3), percent(run.wall_seconds, all)),
        ];
        (run.failure.is_some(), cells)
    };
    Block::table("run | sets | model | replicas | steady | simulated | wall time", study.runs.iter().map(row))
}
