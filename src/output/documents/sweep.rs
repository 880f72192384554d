//! Document of a sweep, which runs the variants of a case (its experiments) with several values of its keys. A point is
//! one value for each of these keys.

use crate::output::document::{Block, Document};
use crate::output::files::write_summary;
use crate::output::numbers::{UNKNOWN, counted, percent, significant, with_error};
use crate::output::sweep::{OBSERVABLES, SweepRow, SweepStudy};
use crate::output::{Folder, OutputError, csv, figures};
use crate::statistics::Estimate;
use serde_json::json;
use std::path::PathBuf;

/// Number of standard errors of a difference. If the difference of two values is larger, the values count as different.
const FAR: f64 = 3.0;

/// Writes the table, the pictures and the page of a sweep. Writes the summary too if all runs are finished. Returns the
/// path of the page.
///
/// # Errors
/// An [`OutputError`]. Files written before the error remain.
pub fn write_sweep(folder: &Folder, study: &SweepStudy) -> Result<PathBuf, OutputError> {
    let verdicts = verdicts(study);
    let document = document(study, &verdicts)?;
    let page = document.write_part(folder)?;
    if study.rows.iter().all(|row| row.runs.len() == row.identities.len()) {
        let failed = study.rows.iter().any(|row| row.failure().is_some());
        let rows = study.rows.iter().map(|row| {
            json!({
                "point": study.axes.iter().zip(&row.at).map(|(axis, &at)| (axis.key.clone(), axis.typed[at].clone().into()))
                    .collect::<serde_json::Map<_, _>>(),
                "variant": study.variants[row.variant],
                "status": row.status(),
                "failure": row.failure(),
                "runs": row.identities,
            })
        });
        let runs = study.rows.iter().flat_map(|row| &row.runs);
        let runs: serde_json::Map<_, _> = runs.map(|run| (run.identity.clone(), json!(run))).collect();
        let summary = json!({
            "title": study.provenance.title,
            "case": study.provenance.case_path,
            "command": study.provenance.command,
            "status": crate::output::document::status(failed),
            "version": env!("CARGO_PKG_VERSION"),
            "verdicts": verdicts,
            "points": rows.collect::<Vec<_>>(),
            "runs": runs,
        });
        write_summary(folder, &summary)?;
    }
    Ok(page)
}

/// Answers of a sweep in sentences: missing and failed runs, and differences between variants (experiments of a case).
pub fn sweep_verdicts(study: &SweepStudy) -> Vec<String> {
    verdicts(study)
}

fn document<'a>(study: &'a SweepStudy, verdicts: &'a [String]) -> Result<Document<'a>, OutputError> {
    let figures = figures::sweep(study);
    let known: Vec<_> =
        OBSERVABLES.iter().filter(|one| study.rows.iter().any(|row| row.measured(one.key).is_some())).collect();
    let head = ["variant", "point", "status"].into_iter().chain(known.iter().map(|one| one.axis)).collect::<Vec<_>>();
    let row = |row: &SweepRow| {
        let numbers = known.iter().map(|one| with_error(row.measured(one.key)));
        let names = [study.variants[row.variant].clone(), study.point(&row.at), row.status().to_owned()];
        (row.failure().is_some(), names.into_iter().chain(numbers).collect())
    };
    let mut body = vec![
        Block::Section("pictures", "Pictures".into()),
        Block::Figures(0..figures.len()),
        Block::heading("Points"),
        Block::table(&head.join(" | "), study.rows.iter().map(row)),
    ];
    let failures = study.rows.iter().filter_map(|row| {
        Some(format!("“{}” at {}: {}", study.variants[row.variant], study.point(&row.at), row.failure()?))
    });
    let failures: Vec<String> = failures.collect();
    if !failures.is_empty() {
        body.extend([Block::heading("Runs that stopped early"), Block::List(failures)]);
    }
    Ok(Document {
        provenance: study.provenance,
        failures: Vec::new(),
        verdicts,
        answers: usize::MAX,
        front: Vec::new(),
        notes: &[],
        body,
        tail: Vec::new(),
        tables: vec![("sweep.csv".to_owned(), csv::sweep(study)?)],
        figures,
    })
}

/// Sentences about missing and failed runs, and about the points (values of the swept keys) at which each variant
/// (experiment of a case) differs from the reference.
fn verdicts(study: &SweepStudy) -> Vec<String> {
    let waiting = study.rows.iter().filter(|row| row.status() == "not run yet").count();
    let failed = study.rows.iter().filter(|row| row.failure().is_some()).count();
    let mut sentences = Vec::new();
    if waiting > 0 {
        sentences.push(format!("{} of {} have not been run yet.", waiting, counted(study.rows.len(), "row")));
    }
    if failed > 0 {
        sentences.push(format!("{} of {} stopped early.", failed, counted(study.rows.len(), "row")));
    }
    let Some(reference) = study.reference else { return sentences };
    let told = sentences.len();
    for variant in (0..study.variants.len()).filter(|variant| *variant != reference) {
        sentences.extend(OBSERVABLES.iter().filter_map(|one| compared(study, variant, reference, one.key, one.name)));
    }
    if study.variants.len() > 1 && waiting == 0 && sentences.len() == told {
        let remedy =
            "longer runs have them if they are steady and mix, and so have several replicas of each (--replicas)";
        sentences.push(format!("Nothing is compared, for want of error bars: {remedy}."));
    }
    sentences
}

/// Sentence that compares a variant (experiment of a case) with the reference in one observable at all points of the
/// sweep. `None` if there is no point at which both have values with errors.
fn compared(study: &SweepStudy, variant: usize, reference: usize, key: &str, name: &str) -> Option<String> {
    let (mut points, mut near) = (0, 0);
    let mut farthest: Option<(f64, &SweepRow, Estimate, Estimate)> = None;
    for row in study.rows.iter().filter(|row| row.variant == variant) {
        let beside = study.rows.iter().find(|other| other.variant == reference && other.at == row.at);
        let (Some(a), Some(b)) = (row.measured(key), beside.and_then(|row| row.measured(key))) else { continue };
        let (Some(error), Some(other)) = (a.error, b.error) else { continue };
        let error = error.hypot(other);
        if error <= 0.0 {
            continue;
        }
        let (difference, far) = (a.value - b.value, (a.value - b.value).abs() / error);
        points += 1;
        near += usize::from(far <= FAR);
        if farthest.as_ref().is_none_or(|(most, ..)| far > *most) {
            farthest = Some((far, row, Estimate::new(difference, error), Estimate::new(b.value, other)));
        }
    }
    let (far, row, difference, base) = farthest?;
    // the difference is not given as a fraction of the reference if the reference is 0 within its error, such as a mean
    // velocity without gas flow
    let apart = if base.error.is_some_and(|error| base.value.abs() <= FAR * error) {
        format!(
            "{} standard errors, where “{}” is 0 within three of its own",
            significant(far, 2),
            study.variants[reference]
        )
    } else {
        let share = |part: f64| percent(part, base.value.abs());
        let name = &study.variants[reference];
        format!("{} ± {} of that of “{name}”", share(difference.value), difference.error.map_or(UNKNOWN.into(), share))
    };
    Some(format!(
        "“{}” against “{}”, {name}: within 3 standard errors at {near} of {}; farthest apart at {}, by {apart}.",
        study.variants[variant],
        study.variants[reference],
        counted(points, "point"),
        study.point(&row.at),
    ))
}
