//! The validation suite (comparisons with references): rows by name, tables that agree with each other, and changed
//! references.

use crate::support::*;
use diptych::output::{ValidationNumber, ValidationRow, ValidationRule};
use diptych::statistics::Answer;
use diptych::study::validate::{judge_numbers, names, not_validated, row};
use serde_json::Value;

/// Rows of the validation suite that take less than a second, from every kind of reference.
const FAST: [&str; 4] = ["dem02", "cradle", "chung-ooi-4", "kharaz"];

fn fast(name: &str) -> ValidationRow {
    row(name, true).unwrap_or_else(|| panic!("no row {name}")).unwrap()
}

#[test]
fn rows_say_where_their_reference_comes_from_and_what_they_do_not_show() {
    let all: Vec<&str> = names().collect();
    let mut once = all.clone();
    once.sort_unstable();
    once.dedup();
    assert_eq!(once.len(), all.len(), "two rows have one name: {all:?}");
    assert!(all.len() > 20 && not_validated().len() > 5);
    for name in FAST {
        let row = fast(name);
        assert!(row.scene.len() > 40 && row.source.len() > 40 && row.not_shown.len() > 30, "{name}");
        assert!(diptych::case::built_in::case(row.case).is_some(), "{name}: {}", row.case);
        assert!(row.failure.is_none() && !row.numbers.is_empty(), "{name}: {:?}", row.failure);
    }
}

#[test]
fn rows_with_closed_forms_agree() {
    for name in
        ["dem01", "dem02", "dem03", "dem04", "zeno", "cradle", "dropped-with-spin", "chung-ooi-3", "chung-ooi-7"]
    {
        let row = fast(name);
        for one in &row.numbers {
            assert_eq!(one.answer, Answer::Equivalent, "{name}, {}: {:?}, {:?}", one.name, one.ours, one.reference);
        }
        assert_eq!(row.word(), "agrees");
    }
}

/// If the reference of a validation number is moved away by three tolerances and five standard errors, the answer is
/// "different".
#[test]
fn a_changed_reference_is_different() {
    for name in FAST {
        let row = fast(name);
        for (k, right) in row.numbers.iter().enumerate().filter(|(_, one)| one.answer == Answer::Equivalent) {
            let mut numbers: Vec<ValidationNumber> = row.numbers.clone();
            let error = right.difference().error.unwrap_or(0.0);
            // a reference beyond the tolerance and beyond five standard errors, on the other side of the result
            let away = (right.reference.value - right.ours.value).signum();
            numbers[k].reference.value += away * (3.0 * right.allowed + 5.0 * error);
            judge_numbers(&mut numbers, names().count());
            assert_eq!(numbers[k].answer, Answer::Different, "{name}, {}", right.name);
        }
    }
}

#[test]
fn table_and_summary_contain_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let rows = ["dem02", "kharaz"];
    let mut arguments = vec!["validate", "--quick", "--out", out.to_str().unwrap()];
    rows.iter().for_each(|name| arguments.extend(["--only", name]));
    let done = diptych(&arguments).output().unwrap();
    assert!(done.status.success(), "{}", words(&done.stderr));
    let said = words(&done.stdout);
    assert!(rows.iter().all(|name| said.contains(name)), "{said}");
    let summary: Value = serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap();
    assert_eq!(summary["status"], "complete");
    let mut table = ::csv::Reader::from_path(out.join("validation.csv")).unwrap();
    let mut lines = table.records().map(Result::unwrap);
    for (entry, name) in summary["rows"].as_array().unwrap().iter().zip(rows) {
        assert_eq!(entry["name"], name);
        for number in entry["numbers"].as_array().unwrap() {
            let line = lines.next().unwrap();
            assert_eq!((&line[0], &line[2]), (name, number["name"].as_str().unwrap()));
            let cells = [(4, &number["reference"]), (6, &number["ours"])];
            for (column, estimate) in cells {
                assert_eq!(line[column].parse::<f64>().unwrap(), estimate["value"].as_f64().unwrap(), "{line:?}");
            }
            assert_eq!(&line[11], number["answer"].as_str().unwrap());
        }
    }
    assert!(lines.next().is_none());
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("does not show") && page.contains("Not validated"));
    let missing = summary["not_validated"].as_array().unwrap();
    assert_eq!(missing.len(), not_validated().len());
    // an existing folder is not overwritten
    let again = diptych(&arguments).output().unwrap();
    assert_eq!(again.status.code(), Some(2), "{}", words(&again.stderr));
}

#[test]
fn an_unknown_row_is_refused_with_the_nearest_name() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let done = diptych(&["validate", "--only", "dem2", "--out", out.to_str().unwrap()]).output().unwrap();
    assert_eq!(done.status.code(), Some(2));
    let said = words(&done.stderr);
    assert!(said.contains("there is no row `dem2`") && said.contains("did you mean `dem0"), "{said}");
    assert!(!out.exists(), "nothing is written");
}

#[test]
fn the_exit_code_tells_the_answer() {
    let folder = tempfile::tempdir().unwrap();
    let code = |name: &str| {
        let out = folder.path().join(name);
        let arguments = ["validate", "--exit-code", "--only", name, "--quiet", "--out", out.to_str().unwrap()];
        diptych(&arguments).output().unwrap().status.code()
    };
    assert_eq!(code("dem02"), Some(0));
    let expected = match fast("channel-gas").answer() {
        Answer::Equivalent => 0,
        Answer::Different => 3,
        Answer::Unresolved => 4,
    };
    assert_eq!(code("channel-gas"), Some(expected));
}

#[test]
fn exact_rows_have_no_errors_and_others_have() {
    for name in FAST {
        for one in &fast(name).numbers {
            let error = one.difference().error.unwrap_or(0.0);
            assert_eq!(one.rule == ValidationRule::Tolerance, error == 0.0, "{name}, {}", one.name);
        }
    }
}
