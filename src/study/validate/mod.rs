//! `diptych validate`: comparisons with closed forms, with published numbers of other codes and theories, and with
//! experiments.
//!
//! A row of the suite is a `ValidationCheck`: a description with the source of the reference, and a function that runs
//! the scene of a built-in case. Each file of this folder has the rows of one topic. The list `CHECKS` contains all
//! rows.

mod answers;
mod bounces;
mod check;
mod chung_ooi;
mod contact_time;
mod cooling;
mod fall;
mod flows;
mod gases;
mod missing;
mod oblique;
mod rows_of_balls;
mod sliding;

use crate::case::nearest;
use crate::cli::Validate;
use crate::output::{
    Folder, NotValidated, Provenance, ValidationNumber, ValidationRow, ValidationStudy, validation_answers,
    write_validation,
};
use crate::runs::{StudyError, command_line, conclude, use_threads};
use crate::statistics::Answer;
use crate::study::points::run_points;
use check::{CheckScene, ValidationCheck};
use std::path::PathBuf;
use std::time::Instant;

pub use answers::judge_numbers;

/// All rows of the validation suite. The report sorts them by tier (kind of reference), and keeps this order within a
/// tier.
const CHECKS: &[&ValidationCheck] = &[
    &bounces::SOFT_FLOOR,
    &bounces::APEXES,
    &bounces::SQUEEZED,
    &sliding::SLIDE_TO_ROLL,
    &bounces::ZENO,
    &rows_of_balls::CRADLE,
    &sliding::DROPPED_WITH_SPIN,
    &chung_ooi::RESTITUTION,
    &chung_ooi::OPPOSITE_SPINS,
    &gases::ATMOSPHERE,
    &oblique::LINEAR_SPRINGS,
    &oblique::HERTZ_MINDLIN,
    &fall::TERMINAL,
    &chung_ooi::HEAD_ON,
    &chung_ooi::ON_PLANE,
    &chung_ooi::OBLIQUE,
    &chung_ooi::FINITE_ELEMENTS,
    &chung_ooi::SPINNING,
    &gases::HARD_GAS,
    &gases::MIXTURE,
    &cooling::HAFF,
    &contact_time::CONTACT_TIME,
    &cooling::SONINE,
    &cooling::MFIX_EXA,
    &cooling::ROUGH,
    &flows::CHANNEL_GAS,
    &oblique::MEASURED,
    &flows::BEVERLOO,
];

/// Names of all rows of the validation suite.
pub fn names() -> impl Iterator<Item = &'static str> {
    CHECKS.iter().map(|check| check.name)
}

/// Comparisons that the validation suite does not make, each with the reason.
pub fn not_validated() -> &'static [NotValidated] {
    missing::MISSING
}

/// Runs the row (comparison of the suite) with the name `name` and judges its results; `None` if there is no such row.
/// If `quick` is true, the row has fewer and shorter runs.
///
/// # Errors
/// Returns an error if the scene cannot be made. This would be a fault of the program.
pub fn row(name: &str, quick: bool) -> Option<Result<ValidationRow, StudyError>> {
    CHECKS.iter().find(|check| check.name == name).map(|check| measured(check, quick))
}

/// Runs one row and judges its results. If an engine stops, the row has the reason and no results. If `quick` is true,
/// the row has fewer and shorter runs.
fn measured(check: &ValidationCheck, quick: bool) -> Result<ValidationRow, StudyError> {
    let began = Instant::now();
    let result = (check.measure)(&CheckScene::new(check.case, quick)?);
    let (mut numbers, mut picture, mut failure): (Vec<ValidationNumber>, _, _) = (Vec::new(), None, None);
    match result {
        Ok(result) => (numbers, picture) = (result.numbers, result.picture),
        Err(StudyError::Failed(why) | StudyError::Input(why)) => {
            failure = Some(why.trim_start_matches("error: ").into())
        }
        Err(stopped) => return Err(stopped),
    }
    judge_numbers(&mut numbers, CHECKS.len());
    Ok(ValidationRow {
        name: check.name,
        tier: check.tier,
        scene: check.scene,
        source: check.source,
        not_shown: check.not_shown,
        case: check.case,
        numbers,
        picture,
        failure,
        wall_seconds: began.elapsed().as_secs_f64(),
    })
}

/// Rows (comparisons of the suite) that the arguments select, and the names of the rows that `--quick` leaves out.
fn wanted(args: &Validate) -> Result<(Vec<&'static ValidationCheck>, Vec<&'static str>), StudyError> {
    let known: Vec<&str> = names().collect();
    if let Some(unknown) = args.only.iter().find(|name| !known.contains(&name.as_str())) {
        let guess = nearest(unknown, &known).map(|name| format!("did you mean `{name}`? ")).unwrap_or_default();
        return Err(StudyError::Input(format!(
            "error: there is no row `{unknown}`\nhelp: {guess}the rows are {}",
            known.join(", ")
        )));
    }
    let asked = |name: &str| args.only.iter().any(|only| only == name);
    // a row that the user names runs even if it takes minutes
    let left_out = |check: &ValidationCheck| args.quick && check.takes_minutes && !asked(check.name);
    let all = CHECKS.iter().copied().filter(|check| args.only.is_empty() || asked(check.name));
    let (left_out, mut rows): (Vec<_>, Vec<_>) = all.partition(|check| left_out(check));
    rows.sort_by_key(|check| check.tier);
    Ok((rows, left_out.iter().map(|check| check.name).collect()))
}

/// Runs the validation suite and writes its results to one folder. Returns one answer for all rows together, or `None`
/// without a row.
///
/// # Errors
/// Returns an error for bad input, before anything is computed, or later for a file that cannot be written or a run
/// that stopped early.
pub fn validate(args: &Validate) -> Result<Option<Answer>, StudyError> {
    let (checks, left_out) = wanted(args)?;
    use_threads(args.threads.map(usize::from))?;
    let path = args.output.out.clone().unwrap_or_else(|| PathBuf::from("out/validation"));
    let folder =
        Folder::create(path, args.output.overwrite).map_err(|error| StudyError::Input(format!("error: {error}")))?;
    let rows = run_points("validation", args.output.quiet, &checks, |check| measured(check, args.quick))?;
    let provenance = Provenance {
        title: "Validation".into(),
        command: command_line(),
        case_path: "built in; each row names its case".into(),
        ..Provenance::default()
    };
    let study = ValidationStudy {
        provenance: &provenance,
        rows: &rows,
        left_out: &left_out,
        not_validated: not_validated(),
        quick: args.quick,
    };
    let verdict = sentence(&study);
    let report = write_validation(&folder, &study, std::slice::from_ref(&verdict))?;
    if !args.output.quiet {
        conclude(&[validation_answers(&study), verdict], "Report", &report);
    }
    let failed: Vec<String> = rows
        .iter()
        .filter_map(|row| Some(format!("error: \"{}\" stopped: {}", row.name, row.failure.as_ref()?)))
        .collect();
    if failed.is_empty() { Ok(study.answer()) } else { Err(StudyError::Failed(failed.join("\n"))) }
}

/// Sentence with the number of rows (comparisons) that agree with their references, and the names of the different and
/// of the unresolved rows.
fn sentence(study: &ValidationStudy) -> String {
    let of = |answer: Answer| -> Vec<&str> {
        study.rows.iter().filter(|row| row.answer() == answer).map(|row| row.name).collect()
    };
    let favourable = of(Answer::Equivalent).len();
    let mut sentence = format!("{favourable} of {} rows agree with their references", study.rows.len());
    for (answer, words) in [(Answer::Different, "different"), (Answer::Unresolved, "unresolved")] {
        let names = of(answer);
        if !names.is_empty() {
            sentence += &format!("; {words}: {}", names.join(", "));
        }
    }
    sentence + &format!(". {} further comparisons are not validated.", study.not_validated.len())
}
