//! `diptych judge`: compares the data of two sides with the tests of `compare`. The data of a side are files that any
//! program may have written. A margin is the largest difference that is accepted as equivalent.

mod frames;
mod pairs;
mod quantity;
mod settings;
mod side;
mod table;
mod thermo;

use super::judge::{answer_in_words, pair};
use crate::case::Sources;
use crate::cli::JudgeArguments;
use crate::output::numbers::significant;
use crate::output::{Basis, FilesQuantity, FilesStudy, Provenance, Verdict, overall, write_files_study};
use crate::runs::{StudyError, command_line, conclude, folder};
use crate::statistics::{Answer, ErrorLevels, Estimate, Observable, compare};
use pairs::compared_columns;
use quantity::{MeasuredQuantity, measure};
use settings::JudgeFile;
use side::{JudgeSide, SideData};
use std::path::{Path, PathBuf};

/// [-] margin of equivalence (largest accepted difference) that applies if neither the command line nor the settings
/// give one. The difference is divided by the scale of the quantity, such as the magnitude of its value on side B.
const MARGIN: f64 = 0.01;

/// Compares the data of two sides and writes the report to one folder. Returns one answer for all quantities together,
/// or `None` without a comparison.
///
/// # Errors
/// Returns an error for bad input, before anything is written, or for a file that cannot be written.
pub fn judge_files(args: &JudgeArguments) -> Result<Option<Answer>, StudyError> {
    let mut sources = Sources::default();
    let (file, text) = JudgeFile::read(args.settings.as_deref(), &mut sources)?;
    let place = args.settings.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
    let mut sides = [
        JudgeSide::read(args.a.as_deref(), &file.a, place, 'a', &mut sources)?,
        JudgeSide::read(args.b.as_deref(), &file.b, place, 'b', &mut sources)?,
    ];
    if sides[0].name == sides[1].name {
        sides.iter_mut().for_each(|side| side.name = side.paths.join(", "));
    }
    let margin = args.margin.or(file.margin.as_ref().map(|margin| margin.value.0)).unwrap_or(MARGIN);
    let (columns, mut notes) = compared_columns(&file, margin, &sides, &sources)?;
    let measured: Vec<MeasuredQuantity> =
        columns.iter().map(|one| measure(one, &sides, &sources)).collect::<Result<_, _>>()?;
    let names = [&sides[0], &sides[1]].map(|side| side.name.clone());
    let paths = [&sides[0], &sides[1]].map(|side| side.paths.join(", "));
    let comparisons = verdicts(&measured, &names);
    notes.extend(remarks(&measured, &sides));
    notes.extend(sides.iter().flat_map(JudgeSide::warnings));
    let folder = folder(&args.output, &first_file(&sides[0]), "judge")?;
    let sentences: Vec<String> = comparisons.iter().map(|one| one.sentence.clone()).collect();
    let quantities: Vec<FilesQuantity> = measured.into_iter().map(|one| one.summary).collect();
    let study = FilesStudy {
        provenance: &Provenance {
            title: format!("{} against {}", names[0], names[1]),
            case_path: args.settings.as_ref().map_or(String::new(), |path| path.display().to_string()),
            case_text: text,
            command: command_line(),
            scene: String::new(),
        },
        names: &names,
        paths: &paths,
        quantities: &quantities,
        verdicts: &sentences,
        comparisons: &comparisons,
        notes: &notes,
    };
    let report = write_files_study(&folder, &study)?;
    if !args.output.quiet {
        conclude(&sentences, "Report", &report);
    }
    Ok(overall(&comparisons))
}

/// Path of the first file of one side of the comparison, from which the name of the folder of results is made. If the
/// name of a variant (experiment of a case) follows after a colon, it is cut off.
fn first_file(side: &JudgeSide) -> PathBuf {
    let first = side.paths.first().map_or("", String::as_str);
    table::split_variant(first).0.into()
}

/// Answers for all quantities. Quantities with the same margin (largest accepted difference) and the same kind of data
/// (averages or curves) form a group with one answer. Each group gets a share of the accepted probability of a false
/// difference, in proportion to its number of quantities. So the probability of any false difference is that of a
/// single test.
fn verdicts(measured: &[MeasuredQuantity], names: &[String; 2]) -> Vec<Verdict> {
    let key = |one: &MeasuredQuantity| (one.summary.basis, one.summary.margin);
    let mut keys: Vec<(Basis, f64)> = Vec::new();
    for one in measured {
        if !keys.contains(&key(one)) {
            keys.push(key(one));
        }
    }
    let one = |wanted: (Basis, f64)| {
        let group: Vec<&MeasuredQuantity> = measured.iter().filter(|one| key(one) == wanted).collect();
        verdict(&group, names, group.len() as f64 / measured.len() as f64)
    };
    keys.into_iter().map(one).collect()
}

/// Answer for a group of quantities with the same margin (largest accepted difference) and the same kind of data
/// (averages or curves). `share` [-] is the number of quantities in the group divided by that of all quantities.
fn verdict(group: &[&MeasuredQuantity], names: &[String; 2], share: f64) -> Verdict {
    let (basis, margin) = (group[0].summary.basis, group[0].summary.margin);
    let observables = [0, 1].map(|k| -> Vec<Observable> {
        group.iter().filter_map(|one| one.observables.as_ref().map(|both| both[k].clone())).collect()
    });
    let quantities: Vec<&str> = group.iter().map(|one| one.summary.name.as_str()).collect();
    let levels = ErrorLevels { difference: share * ErrorLevels::default().difference, ..ErrorLevels::default() };
    let (across, reason) = match basis {
        Basis::Averages => ("", "Both sides are steady while they are averaged, or are stated: averages are compared."),
        Basis::Curves => ("s", "Curves over time are compared, with errors from the scatter between files."),
        Basis::Paths | Basis::Nothing => ("", "Nothing could be compared."),
    };
    let comparison = (basis != Basis::Nothing).then(|| compare(&observables[0], &observables[1], margin, levels));
    let needed = |stretch: f64| match basis {
        Basis::Curves => format!("{} times as many files of each", significant(stretch, 2)),
        _ => format!("{} times as much of each", significant(stretch, 2)),
    };
    let sentence = match &comparison {
        Some(comparison) => answer_in_words(comparison, across, needed),
        None => format!("unresolved: {} ({}).", group[0].remark, quantities.join(", ")),
    };
    Verdict {
        variant: names[0].clone(),
        reference: names[1].clone(),
        answer: comparison.as_ref().map_or(Answer::Unresolved, |comparison| comparison.answer),
        basis,
        sentence: format!("{} {sentence}", pair(&names[0], &names[1])),
        reason: reason.into(),
        margin,
        comparison,
        observed: Vec::new(),
        further: Vec::new(),
    }
}

/// Remarks for the reader of a comparison of two files. Remarks name quantities without a standard error, and
/// quantities whose reference value is zero within its error, so that differences cannot be divided by it. The remark
/// of a single quantity says, for instance, why curves are compared instead of averages, or why nothing can be
/// compared.
fn remarks(measured: &[MeasuredQuantity], sides: &[JudgeSide; 2]) -> Vec<String> {
    let mut remarks = Vec::new();
    for (k, side) in sides.iter().enumerate() {
        let lacking = measured.iter().filter(|one| one.summary.sides[k].mean.is_some_and(|mean| mean.error.is_none()));
        let lacking: Vec<&str> = lacking.map(|one| one.summary.name.as_str()).collect();
        if !lacking.is_empty() {
            let why = match &side.data {
                SideData::Points(_) => "states no standard error",
                SideData::Series(_) => "has too few samples for a standard error",
            };
            let names = lacking.join(", ");
            remarks.push(format!("\"{}\" {why} of {names}: without one nothing is shown equivalent.", side.name));
        }
    }
    for one in measured {
        let [_, reference] = &one.summary.sides;
        let unscaled = one.observables.as_ref().is_some_and(|both| both[1].scale_is == "its value");
        if unscaled && reference.mean.is_some_and(Estimate::is_zero_within_error) {
            remarks.push(format!("{}: the reference is zero within its error, so that its value is no scale; give `scale` in --settings.", one.summary.name));
        }
        if !one.remark.is_empty() {
            remarks.push(format!("{}: {}.", one.summary.name, one.remark));
        }
    }
    remarks
}
