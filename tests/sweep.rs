//! Sweeps (runs at several values of keys): interrupted and continued, with grids and replicas, refused, and with
//! points that stop early.

use crate::support::{BASE, diptych, words};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Output;

const STIFFNESS: &str = "soft.linear_spring_dashpot.stiffness";

/// Runs a sweep of the small case into a folder, with a simulated time of 50 ms.
fn sweep(folder: &Path, arguments: &[&str]) -> (i32, Output) {
    let short = ["--set", "run.duration=50 ms", "--set", "run.average_from=10 ms"];
    let output =
        diptych(&[&["sweep", BASE], &short[..], arguments].concat()).arg("--out").arg(folder).output().unwrap();
    (output.status.code().unwrap(), output)
}

/// Rows of `sweep.csv`, with the cells by the names of the columns.
fn rows(folder: &Path) -> Vec<BTreeMap<String, String>> {
    let mut table = csv::Reader::from_path(folder.join("sweep.csv")).unwrap();
    table.deserialize().map(|row| row.unwrap()).collect()
}

/// Stored results of single runs, by the hashes that identify the runs.
fn runs(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let Ok(files) = std::fs::read_dir(folder.join("checkpoint")) else { return BTreeMap::new() };
    let paths = files.map(|file| file.unwrap().path());
    let result = |path: PathBuf| {
        let name = path.file_name()?.to_string_lossy().strip_prefix("done-")?.to_owned();
        Some((name, std::fs::read(path).unwrap()))
    };
    paths.filter_map(result).collect()
}

fn summary(folder: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join("summary.json")).unwrap()).unwrap()
}

/// Rows without the columns that differ between two equal sweeps, such as the wall time.
fn lasting(folder: &Path) -> Vec<BTreeMap<String, String>> {
    let mut rows = rows(folder);
    rows.iter_mut().for_each(|row| row.retain(|column, _| column != "wall_seconds" && column != "cost_s_s"));
    rows
}

fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} = {:?}", row[column]))
}

#[test]
fn a_sweep_that_was_killed_goes_on_and_ends_the_same() {
    let place = tempfile::tempdir().unwrap();
    let (whole, cut) = (place.path().join("whole"), place.path().join("cut"));
    let values = format!("{STIFFNESS}=1 kN/m,2 kN/m,3000 N/m,5 kN/m,10 kN/m");
    let (code, output) = sweep(&whole, &["--sweep", &values]);
    assert_eq!(code, 0, "{}", words(&output.stderr));
    // five soft runs, and a single run of hard spheres, which do not depend on the stiffness
    assert_eq!(runs(&whole).len(), 6);
    let summary = summary(&whole);
    assert_eq!((summary["status"].as_str(), summary["points"].as_array().unwrap().len()), (Some("complete"), 10));

    let short = ["--set", "run.duration=50 ms", "--set", "run.average_from=10 ms"];
    let mut command = diptych(&[&["sweep", BASE, "--in-turn", "--quiet", "--sweep", &values], &short[..]].concat());
    let mut child = command.arg("--out").arg(&cut).spawn().unwrap();
    while runs(&cut).len() < 2 && child.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let before = runs(&cut);
    assert!((2..6).contains(&before.len()) && !cut.join("summary.json").exists(), "{} runs", before.len());
    let (code, output) = sweep(&cut, &["--sweep", &values]);
    let told = words(&output.stderr);
    assert_eq!(code, 0, "{told}");
    assert!(told.contains(&format!("{} of 6 runs are there from an earlier start", before.len())), "{told}");
    assert_eq!(told.lines().filter(|line| line.contains(" of 6 runs: ")).count(), 6 - before.len(), "{told}");
    // finished results are unchanged; everything except times equals the uninterrupted sweep
    let after = runs(&cut);
    assert!(before.iter().all(|(identity, run)| after[identity] == *run));
    assert_eq!(lasting(&cut), lasting(&whole));
    // a third start finds no run to be done
    let (code, output) = sweep(&cut, &["--sweep", &values]);
    let told = words(&output.stderr);
    assert!(code == 0 && told.contains("6 of 6 runs are there") && !told.contains(" of 6 runs: "), "{told}");
    // another value requires another run
    let (_, output) = sweep(&cut, &["--sweep", &format!("{values},20 kN/m"), "--only", "soft"]);
    assert_eq!(runs(&cut).len(), 7, "{}", words(&output.stderr));

    let found = rows(&whole);
    let of = |variant: &str| found.iter().filter(|row| row["variant"] == variant).collect::<Vec<_>>();
    assert_eq!(of("soft").iter().map(|row| number(row, STIFFNESS)).collect::<Vec<_>>(), [1e3, 2e3, 3e3, 5e3, 1e4]);
    assert!(of("hard").iter().all(|row| row["runs"] == of("hard")[0]["runs"]));
    // overlaps of stiffer spheres are smaller: proportional to k^(-1/2) for equal speeds; here the speeds change by
    // less than 20 %
    let overlaps: Vec<f64> = of("soft").iter().map(|row| number(row, "mean_overlap")).collect();
    let ratio = overlaps[0] / overlaps[4];
    assert!((0.8..1.25).contains(&(ratio / 10f64.sqrt())), "{overlaps:?}");
    for figure in ["pair-impacts-per-time", "granular-temperature", "mean-largest-overlap-of-pairs"] {
        let picture = std::fs::read_to_string(whole.join(format!("figures/sweep-{figure}.svg"))).unwrap();
        assert!(picture.contains("stiffness") && picture.contains("[N/m]"), "{figure}");
    }
    // the axis has the range of its data: the mean velocity changes little, so that the axis must not span decades
    let velocity = std::fs::read_to_string(whole.join("figures/sweep-mean-streamwise-velocity.svg")).unwrap();
    assert!(!velocity.contains(">100<"), "{velocity}");
    let page = std::fs::read_to_string(whole.join("report.html")).unwrap();
    assert!(page.contains("stiffness = 3000 N/m"));
    let scene = page.split("<ul class=\"scene\">").nth(1).unwrap().split("</ul>").next().unwrap();
    assert_eq!(scene.matches("collisions at the exact instants of touch").count(), 1, "{scene}");
    // fewer than eight blocks give no error
    assert!(page.contains("for want of error bars"), "{}", words(&output.stdout));
}

/// Ctrl-C ends a sweep at the end of the present windows (pieces of its runs). Finished runs remain, and a new start
/// of the command continues the sweep.
#[cfg(unix)]
#[test]
fn a_sweep_that_is_stopped_says_so_and_goes_on() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("stopped");
    let values = format!("{STIFFNESS}=1 kN/m,2 kN/m,3 kN/m");
    let arguments = ["--sweep", &values, "--in-turn", "--only", "soft"];
    // a run so long that the second run is still in progress shortly after the report on the first one
    let long = ["--set", "run.duration=60 s", "--set", "run.average_from=1 s"];
    let mut command = diptych(&[&["sweep", BASE], &long[..], &arguments].concat());
    let child = command.arg("--out").arg(&folder).stderr(std::process::Stdio::piped()).spawn().unwrap();
    while !folder.join("report.html").exists() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    std::thread::sleep(std::time::Duration::from_millis(150));
    assert!(std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let told = words(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{told}");
    let done = runs(&folder);
    assert!(told.contains(&format!("the sweep was stopped: {} of 3 runs are done", done.len())), "{told}");
    assert!(done.len() < 3 && !folder.join("summary.json").exists() && folder.join("report.html").exists());
    // both ways to continue use the finished runs, and the stored state of the run in progress
    assert!(std::fs::read_dir(folder.join("checkpoint")).unwrap().flatten().any(|file| {
        let name = file.file_name().to_string_lossy().into_owned();
        name.starts_with("a-") || name.starts_with("b-")
    }));
    let other = place.path().join("other");
    assert!(std::process::Command::new("cp").arg("-r").args([&folder, &other]).status().unwrap().success());
    let output = diptych(&[&["sweep", BASE], &long[..], &arguments].concat()).arg("--out").arg(&folder).output();
    let resumed = diptych(&["resume"]).arg(&other).output();
    for (folder, output) in [(&folder, output), (&other, resumed)] {
        let told = words(&output.unwrap().stderr);
        assert!(told.contains(&format!("{} of 3 runs are there from an earlier start", done.len())), "{told}");
        let after = runs(folder);
        assert!(after.len() == 3 && done.iter().all(|(identity, run)| after[identity] == *run));
    }
    let whole = place.path().join("whole");
    diptych(&[&["sweep", BASE], &long[..], &arguments].concat()).arg("--out").arg(&whole).output().unwrap();
    assert!(lasting(&folder) == lasting(&whole) && lasting(&other) == lasting(&whole));
}

#[test]
fn a_grid_with_replicas_has_their_means_and_errors() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("grid");
    let arguments = ["--sweep", "contact.restitution=0.8,0.9", "--sweep", "hard.contact_time=1 us,2 us"];
    let (code, output) = sweep(&folder, &[&arguments[..], &["--replicas", "3", "--only", "hard"]].concat());
    assert_eq!(code, 0, "{}", words(&output.stderr));
    let (rows, runs) = (rows(&folder), summary(&folder)["runs"].clone());
    assert_eq!((rows.len(), runs.as_object().unwrap().len(), self::runs(&folder).len()), (4, 12, 12));
    for row in &rows {
        let values: Vec<f64> = row["runs"]
            .split(' ')
            .map(|identity| runs[identity]["measured"]["temperature_m2_s2"]["value"].as_f64().unwrap())
            .collect();
        assert_eq!((values.len(), row["replicas"].as_str()), (3, "3"));
        let mean = values.iter().sum::<f64>() / 3.0;
        let error = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 6.0).sqrt();
        assert!(error > 0.0 && values[0] != values[1], "{values:?}");
        // equal to the printed digits, except for rounding
        assert!((number(row, "temperature_m2_s2") / mean - 1.0).abs() < 1e-12, "{row:?}");
        assert!((number(row, "temperature_m2_s2_se") / error - 1.0).abs() < 1e-9, "{row:?}");
    }
    let points: Vec<_> =
        rows.iter().map(|row| (number(row, "contact.restitution"), number(row, "hard.contact_time"))).collect();
    assert_eq!(points, [(0.8, 1e-6), (0.8, 2e-6), (0.9, 1e-6), (0.9, 2e-6)]);
    // the first replica equals the run without replicas
    let alone = place.path().join("alone");
    sweep(&alone, &[&arguments[..], &["--only", "hard"]].concat());
    for identity in self::runs(&alone).keys() {
        assert!(runs[identity].is_object());
    }
}

#[test]
fn a_case_names_its_own_sweep_and_the_command_line_wins() {
    let place = tempfile::tempdir().unwrap();
    let case = place.path().join("case.toml");
    let base = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(BASE)).unwrap();
    let own = "[[sweep]]\nkey = \"contact.restitution\"\nvalues = [0.8, 0.9]\n[[sweep]]\nkey = \"soft.integrator\"\nvalues = [\"rk2\"]\n";
    std::fs::write(&case, base + own).unwrap();
    let case = case.to_str().unwrap();
    let run = |name: &str, more: &[&str]| {
        let folder = place.path().join(name);
        let short = ["sweep", case, "--quiet", "--set", "run.duration=5 ms", "--set", "run.average_from=0 s"];
        let output = diptych(&[&short[..], more].concat()).arg("--out").arg(&folder).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", words(&output.stderr));
        assert!(output.stdout.is_empty() && output.stderr.is_empty());
        rows(&folder)
    };
    let rows = run("own", &[]);
    assert_eq!(rows.len(), 4);
    assert!(rows.iter().all(|row| row["soft.integrator"] == "rk2"));
    let rows = run("other", &["--sweep", "contact.restitution=0.7", "--only", "soft"]);
    assert_eq!(rows.iter().map(|row| row["contact.restitution"].as_str()).collect::<Vec<_>>(), ["0.7"]);
    // the output of `check` contains the sweep, and tests its values; other commands ignore it
    let output = diptych(&["check", case]).output().unwrap();
    let told = words(&output.stdout);
    assert!(output.status.code() == Some(0) && told.contains("`sweep` would run these at 2 points:\n"), "{told}");
    assert!(told.contains("\n  contact.restitution = 0.8, 0.9\n  soft.integrator = rk2\n"), "{told}");
    let text = std::fs::read_to_string(case).unwrap().replace("[0.8, 0.9]", "[0.8, 1.9]");
    std::fs::write(case, text).unwrap();
    let output = diptych(&["check", case]).output().unwrap();
    let told = words(&output.stderr);
    assert!(output.status.code() == Some(2) && told.contains("allowed: 0 ..= 1"), "{told}");
}

#[test]
fn sweeps_that_cannot_be_run_are_refused_before_anything_is_written() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("none");
    for (arguments, told) in [
        (&[][..], "nothing to sweep"),
        (&["--sweep", "contact.restitution"], "is not key=value"),
        (&["--sweep", "contact.restitution=0.9,"], "empty value"),
        (&["--sweep", "contact.restitution=0.9,1.9"], "allowed: 0 ..= 1"),
        (&["--sweep", "contact.restituton=0.9"], "did you mean `restitution`?"),
        (&["--sweep", "run.seed=1", "--sweep", "run.seed=2"], "two --sweep name `run.seed`"),
        (&["--sweep", "run.seed=1,2", "--only", "soft", "--only", "firm"], "no variant is called \"firm\""),
        (&["--sweep", "run.seed=1,2", "--replicas", "0"], "replicas"),
    ] {
        let (code, output) = sweep(&folder, arguments);
        let words = words(&output.stderr);
        assert!(code == 2 && words.contains(told), "{arguments:?}: {words}");
        assert!(!folder.exists(), "{arguments:?} made a folder");
    }
    let placed = ["sweep", "impact", "--sweep", "contact.restitution=0.8,0.9", "--replicas", "2"];
    let output = diptych(&placed).arg("--out").arg(&folder).output().unwrap();
    assert!(output.status.code() == Some(2) && words(&output.stderr).contains("would be the same run"));
    assert!(!folder.exists());
    // results of another command do not prevent the sweep
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("summary.json"), "{}").unwrap();
    let (code, output) = sweep(&folder, &["--sweep", "run.seed=1"]);
    assert!(code == 2 && words(&output.stderr).contains("--overwrite"), "{}", words(&output.stderr));
}

#[test]
fn points_that_stop_early_are_results() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("weak");
    let values = format!("{STIFFNESS}=1e-3 N/m,3 kN/m");
    let arguments = ["--sweep", &values, "--set", "contact.restitution=1", "--set", "run.duration=1 s"];
    let (code, output) = sweep(&folder, &arguments);
    let told = words(&output.stderr);
    assert!(code == 1 && told.contains("\"soft\" at stiffness = 1e-3 N/m stopped: "), "{told}");
    let rows = rows(&folder);
    let status: Vec<_> = rows.iter().map(|row| (row["variant"].as_str(), row["status"].as_str())).collect();
    assert_eq!(status, [("soft", "failed"), ("hard", "complete"), ("soft", "complete"), ("hard", "complete")]);
    assert!(rows[0]["pair_impacts_1_s"].is_empty() && number(&rows[2], "pair_impacts_1_s") > 0.0);
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(page.contains("Runs that stopped early"));
    // the soft gas loses energy in its time steps, so that its averages have no errors of a steady run
    let sentence = "“soft” against “hard”, realised restitution of pairs: within 3 standard errors at 0 of 1 point;";
    assert!(page.contains(sentence) && words(&output.stdout).contains(sentence), "{}", words(&output.stdout));
    // the run would stop again, so that it is not repeated
    let (code, output) = sweep(&folder, &arguments);
    assert!(code == 1 && words(&output.stderr).contains("3 of 3 runs are there"), "{}", words(&output.stderr));
}
