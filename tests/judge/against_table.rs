//! Variants of a case, compared with a table of values: `against = { table = "..." }`.

use super::{put, summary};
use crate::support::{case, diptych, temperature, words};
use diptych::experiment::Model;
use diptych::placement::initial_state;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Case of an elastic gas in a periodic box. Its temperature is that of the start, in every slice.
const GAS: &str = r#"
[domain]
size = ["10 mm", "10 mm", "10 mm"]
periodic = ["x", "y", "z"]
[[particles]]
name = "bead"
diameter = "0.5 mm"
density = "1000 kg/m^3"
count = 400
velocity_fluctuation = "0.1 m/s"
[contact]
restitution = 1.0
[run]
model = "hard"
duration = "8 s"
average_from = "0 s"
seed = 1
[statistics]
slices = 4
"#;

/// Runs `diptych compare` on the gas with one variant and a table. Returns the exit code, the output and the folder.
fn compared(place: &Path, against: &str, table: &str, margin: &str) -> (i32, String, PathBuf) {
    put(place, "points.csv", table);
    let text = format!("{GAS}[[compare]]\nname = \"gas\"\nagainst = {against}\n");
    let file = put(place, "case.toml", &text);
    let out = place.join("out");
    let arguments =
        ["compare", &file, "--exit-code", "--overwrite", "--margin", margin, "--out", &out.display().to_string()]
            .map(str::to_owned);
    let output = diptych(&arguments.iter().map(String::as_str).collect::<Vec<_>>()).output().unwrap();
    (output.status.code().unwrap(), words(&output.stdout) + &words(&output.stderr), out)
}

const TABLE: &str = "{ table = \"points.csv\" }";

#[test]
fn a_run_is_compared_with_the_values_of_a_table() {
    let place = TempDir::new().unwrap();
    let place = place.path();
    let experiment = case(GAS, Model::Hard, &[]).unwrap();
    let known = temperature(&initial_state(&experiment).unwrap());
    let table = |factor: f64, error: &str| {
        let value = factor * known;
        let profile: String = [1.0, 4.0, 9.0].iter().map(|y| format!("uu,{y},{value},{error}\n")).collect();
        format!("# made up\nquantity,y_mm,value,standard_error\ngranular_temperature,,{value},{error}\n{profile}")
    };
    let one_percent = format!("{}", 0.01 * known);
    let (code, said, folder) = compared(place, TABLE, &table(1.0, &one_percent), "10%");
    assert!(code == 0 && said.contains("\"gas\" against \"points.csv\": equivalent within 10 %"), "{code} {said}");
    let judged = summary(&folder)["comparisons"][0]["comparison"]["judged"].clone();
    let names: Vec<&str> = judged.as_array().unwrap().iter().map(|one| one["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["granular temperature", "uu"], "{judged}");
    // a table with values that are 30 % too high: (1 - 1.3)/1.3 = -23 % of the value
    let (code, said, _) = compared(place, TABLE, &table(1.3, &one_percent), "5%");
    assert!(code == 3 && said.contains("different by −23"), "{code} {said}");
    // without standard errors, nothing is found equivalent
    let (code, said, _) = compared(place, TABLE, &table(1.0, ""), "10%");
    assert!(code == 4 && said.contains("unresolved"), "{code} {said}");
}

#[test]
fn tables_that_cannot_be_a_reference_are_refused() {
    let place = TempDir::new().unwrap();
    let place = place.path();
    let head = "quantity,y_m,value,standard_error\n";
    for (against, rows, wanted) in [
        (
            TABLE,
            "granular_temprature,,1,\n",
            ["points.csv:2:", "`quantity` = \"granular_temprature\"", "granular_temperature"],
        ),
        (TABLE, "uu,0.02,1,\n", ["points.csv:2:", "outside the domain", "y_mm"]),
        (TABLE, "uu,,1,\n", ["points.csv:2:", "the row has no y", "y_m"]),
        (TABLE, "pair_impact_rate,0.001,1,\n", ["points.csv:2:", "over the whole scene", "leave the cell of y empty"]),
        (TABLE, "uu,0.001,1,-2\n", ["points.csv:2:", "is negative", "leave the cell empty"]),
        (TABLE, "uu,0.001,warm,\n", ["points.csv:2:", "`value` = \"warm\"", "plain SI numbers"]),
        (TABLE, "", ["case.toml:", "0 values", "1 to 1023"]),
        ("{ table = \"none.csv\" }", "", ["case.toml:", "none.csv", "no such file"]),
        ("{ tabel = \"points.csv\" }", "", ["case.toml:", "tabel", "table"]),
        ("7", "", ["case.toml:", "where a name, such as \"hard\"", "points.csv"]),
        ("\"other\"", "", ["case.toml:", "no variant is called \"other\"", "gas"]),
    ] {
        let (code, said, folder) = compared(place, against, &format!("{head}{rows}"), "5%");
        assert_eq!(code, 2, "{against} {rows}: {said}");
        assert!(wanted.iter().all(|part| said.contains(part)), "{wanted:?} in {said}");
        assert!(!folder.exists(), "{against} {rows} left a folder");
    }
}
