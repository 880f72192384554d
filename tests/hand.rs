//! Commands that need no file: built-in cases by name, a first case, keys, completions, manual pages.

use crate::support::words;
use diptych::case::built_in;
use std::path::Path;
use std::process::Output;

/// Runs the program in a folder without any file of the project.
fn away(folder: &Path, arguments: &[&str]) -> (i32, Output) {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_diptych"));
    let output = command.current_dir(folder).args(arguments).output().unwrap();
    (output.status.code().unwrap(), output)
}

#[test]
fn every_file_of_the_project_is_built_in() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = |path: &Path| std::fs::read_to_string(root.join(path)).unwrap();
    let (cases, sets) = (built_in::cases(), built_in::sets());
    for (kind, all) in [("cases", &cases), ("models", &sets)] {
        let mut files = 0;
        let mut folders = vec![root.join(kind)];
        while let Some(folder) = folders.pop() {
            for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
                files += usize::from(path.extension().is_some_and(|extension| extension == "toml"));
                folders.extend(path.is_dir().then_some(path));
            }
        }
        assert_eq!(files, all.len(), "{kind}");
        for one in all {
            assert_eq!(one.text, text(Path::new(&format!("{kind}/{}.toml", one.name))), "{}", one.name);
        }
    }
}

#[test]
fn cases_run_by_name_from_any_folder() {
    let place = tempfile::tempdir().unwrap();
    let (code, listed) = away(place.path(), &["cases"]);
    let listed = words(&listed.stdout);
    assert_eq!(code, 0);
    assert!(built_in::cases().iter().chain(&built_in::sets()).all(|one| listed.contains(&one.name)), "{listed}");
    assert!(listed.contains("do the contact models give the same particle statistics"), "{listed}");
    // a folder with the name of the case has no effect, nor do its sets of values
    std::fs::create_dir_all(place.path().join("quick")).unwrap();
    std::fs::create_dir_all(place.path().join("models/fluids")).unwrap();
    std::fs::write(place.path().join("models/fluids/air.toml"), "density = \"-1 kg/m^3\"").unwrap();
    let (code, output) = away(place.path(), &["check", "quick"]);
    let told = words(&output.stdout);
    assert!(code == 0 && told.starts_with("cases/quick.toml (built in): "), "{told}{}", words(&output.stderr));
    let short = ["run", "quick", "--set", "run.duration=5 ms", "--set", "run.average_from=0 s", "--quiet"];
    let (code, output) = away(place.path(), &short);
    assert_eq!(code, 0, "{}", words(&output.stderr));
    assert!(place.path().join("out/quick-run/report.html").exists());
    for (wrong, help) in
        [("cases/quick.toml", "`quick` without `.toml`"), ("quik", "`quick`"), ("x/y", "`diptych cases`")]
    {
        let (code, output) = away(place.path(), &["check", wrong]);
        assert!(code == 2 && words(&output.stderr).contains(help), "{}", words(&output.stderr));
    }
}

/// Two cases read a table in their folder. The table is found if such a case is called by name, or copied.
#[test]
fn cases_that_name_a_file_run_from_any_folder() {
    let place = tempfile::tempdir().unwrap();
    // a file with the name of the table has no effect
    std::fs::create_dir_all(place.path().join("cases/paper")).unwrap();
    std::fs::write(place.path().join("cases/paper/gas-dns.csv"), "mine").unwrap();
    for name in ["gas-d", "gas-f"] {
        let (code, output) = away(place.path(), &["check", &format!("paper/{name}")]);
        assert!(code == 0 && words(&output.stdout).contains("\"DNS\""), "{}", words(&output.stderr));
        let (code, output) = away(place.path(), &["init", &format!("paper/{name}")]);
        assert_eq!(code, 0, "{}", words(&output.stderr));
        let (code, output) = away(place.path(), &["check", &format!("{name}.toml")]);
        assert_eq!(code, 0, "{}", words(&output.stderr));
    }
    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/paper/gas-dns.csv");
    assert_eq!(std::fs::read(place.path().join("gas-dns.csv")).unwrap(), std::fs::read(table).unwrap());
    // an existing file with other contents does not change
    std::fs::remove_file(place.path().join("gas-d.toml")).unwrap();
    std::fs::write(place.path().join("gas-dns.csv"), "mine").unwrap();
    let (code, output) = away(place.path(), &["init", "paper/gas-d"]);
    assert!(code == 2 && words(&output.stderr).contains("gas-dns.csv"), "{}", words(&output.stderr));
    assert_eq!(std::fs::read_to_string(place.path().join("gas-dns.csv")).unwrap(), "mine");
    // a path that the user types is relative to the present folder
    let set = ["--set", "fluid.profile.table.file=no.csv"];
    let (code, output) = away(place.path(), &[&["check", "paper/gas-d"], &set[..]].concat());
    let told = words(&output.stderr);
    assert!(code == 2 && told.contains("there is no such file (no.csv)"), "{told}");
}

#[test]
fn a_first_case_is_written_once() {
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("beads-in-air.toml");
    assert_eq!(away(place.path(), &["init", "beads-in-air"]).0, 0);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), built_in::case("beads-in-air").unwrap().text);
    std::fs::write(&file, "mine").unwrap();
    let (code, output) = away(place.path(), &["init", "beads-in-air"]);
    assert!(code == 2 && words(&output.stderr).contains("--out"), "{}", words(&output.stderr));
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "mine");
    assert_eq!(away(place.path(), &["init", "beads-in-air", "--out", "other.toml"]).0, 0);
    assert_eq!(std::fs::read_dir(place.path()).unwrap().count(), 2, "nothing else is left");
    let (code, output) = away(place.path(), &["check", "other.toml"]);
    assert!(code == 0 && words(&output.stdout).contains("No warnings."), "{}", words(&output.stdout));
    let (code, output) = away(place.path(), &["init", "beads-in-ear"]);
    assert!(code == 2 && words(&output.stderr).contains("`beads-in-air`"), "{}", words(&output.stderr));
    let (code, output) = away(place.path(), &["init", "quick", "--out", "no/such/folder.toml"]);
    assert!(code == 2 && words(&output.stderr).contains("cannot write"), "{}", words(&output.stderr));
}

#[test]
fn keys_completions_and_pages_are_printed() {
    let place = tempfile::tempdir().unwrap();
    let said = |arguments: &[&str]| {
        let (code, output) = away(place.path(), arguments);
        assert_eq!(code, 0, "{arguments:?}: {}", words(&output.stderr));
        words(&output.stdout)
    };
    let hertz = said(&["keys", "soft.hertz"]);
    assert!(hertz.contains("youngs_modulus = \"70 GPa\"") && !hertz.contains("steps_per_contact"), "{hertz}");
    assert!(said(&["keys", "[[walls]]"]).contains("[walls.cylinder]"));
    let (code, output) = away(place.path(), &["keys", "sotf"]);
    assert!(code == 2 && words(&output.stderr).contains("did you mean `soft`?"), "{}", words(&output.stderr));
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = said(&["completions", shell]);
        assert!(script.contains("compare") && script.contains("save-state"), "{shell}");
    }
    let page = said(&["man"]);
    assert!(page.contains(".TH diptych 1") && page.contains("diptych\\-compare"), "{page}");
    assert!(said(&["man", "run"]).contains("\\-\\-save\\-state"));
    assert_eq!(away(place.path(), &["man", "walk"]).0, 2);
}

/// Output of `check --json` for a case, as JSON.
fn checked(folder: &Path, arguments: &[&str]) -> serde_json::Value {
    let (code, output) = away(folder, &[&["check", "--json"], arguments].concat());
    assert_eq!(code, 0, "{}", words(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn a_check_tells_of_runs_that_would_stop_and_speaks_json() {
    let place = tempfile::tempdir().unwrap();
    let stops = |found: &serde_json::Value, why: &str| {
        let warnings = found["warnings"].as_array().unwrap().iter();
        let told =
            warnings.map(|warning| warning["message"].as_str().unwrap().to_owned()).collect::<Vec<_>>().join("\n");
        let expected = "the hard model is not expected to come to the end of this run";
        assert_eq!(told.contains(expected), !why.is_empty(), "{told}");
        assert!(told.contains(why), "{told}");
    };
    // beads come to rest after (1 + e)/(1 - e) = 66 times the first fall; a shorter run does not stop
    stops(&checked(place.path(), &["beads-in-air", "--set", "run.duration=60 s"]), "come to rest after about");
    let found = checked(place.path(), &["beads-in-air"]);
    stops(&found, "");
    // hard spheres with a contact time may rest
    let held = ["beads-in-air", "--set", "run.duration=60 s", "--set", "hard.contact_time=10 us"];
    stops(&checked(place.path(), &held), "");
    stops(&checked(place.path(), &["column"]), "lie at rest from the start");
    assert_eq!(
        (found["case"].as_str(), found["run"]["model"].as_str()),
        (Some("cases/beads-in-air.toml (built in)"), Some("hard"))
    );
    let soft = &found["variants"][0];
    // π/(ω sqrt(1 - ζ²)) for two glass beads of 2 mm with e = 0.97: ω² = k/(m/2), and ζ = -ln e/π within a thousandth
    let mass = std::f64::consts::PI / 6.0 * 8e-9 * 2500.0;
    let contact = std::f64::consts::PI / (20e3 / (0.5 * mass)).sqrt();
    assert!((soft["pair_contact"].as_f64().unwrap() / contact - 1.0).abs() < 1e-4, "{soft}");
    assert!((soft["time_step"].as_f64().unwrap() / (contact / 20.0) - 1.0).abs() < 1e-4, "{soft}");
    assert!(found["variants"][1]["time_step"].is_null() && found["warnings"].as_array().unwrap().is_empty());
    assert!(found["scene"][0].as_str().unwrap().starts_with("Box: 30 mm x 40 mm x 30 mm"));
}
