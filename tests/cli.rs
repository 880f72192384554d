//! The program on the command line: exit codes, messages, files, and its output with `--quiet`.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// Case of a sphere dropped 2 mm above a floor that halves its speed at each impact. The infinite series of bounces
/// ends before 0.1 s.
const BOUNCING: &str = r#"# A bouncing ball
[domain]
size = ["4 mm", "4 mm", "4 mm"]
periodic = ["x", "z"]
[gravity]
acceleration = ["0 m/s^2", "-9.81 m/s^2", "0 m/s^2"]
[[particles]]
use = "particles/polystyrene-406um"
at = [{ position = ["2 mm", "2.2 mm", "2 mm"], velocity = ["0 m/s", "0 m/s", "0 m/s"] }]
[[walls]]
plane = { point = ["0 m", "0 m", "0 m"], normal = [0, 1, 0] }
restitution = 0.5
friction = 0.0
[[walls]]
plane = { point = ["0 m", "4 mm", "0 m"], normal = [0, -1, 0] }
restitution = 0.5
friction = 0.0
[contact]
restitution = 0.5
friction = 0.0
[run]
model = "hard"
duration = "0.2 s"
[statistics]
slices = 4
"#;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Runs the program in the root folder of the crate.
fn diptych(arguments: &[&str]) -> Output {
    let output = Command::new(env!("CARGO_BIN_EXE_diptych")).current_dir(root()).args(arguments).output().unwrap();
    assert!(!words(&output.stderr).contains("panicked"), "{arguments:?}\n{}", words(&output.stderr));
    output
}

/// Runs a command with its arguments and a folder for its results.
fn into(folder: &Path, arguments: &[&str]) -> Output {
    let folder = folder.to_str().unwrap();
    diptych(&[arguments, &["--out", folder]].concat())
}

fn words(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn place() -> (TempDir, PathBuf) {
    let temporary = tempfile::tempdir().unwrap();
    let path = temporary.path().join("results");
    (temporary, path)
}

fn summary(folder: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join("summary.json")).unwrap()).unwrap()
}

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

const CASE: &str = "tests/inputs/good/base.toml";

#[test]
fn bad_input_leaves_nothing_behind() {
    let (_keep, folder) = place();
    for arguments in [
        &["run", "tests/inputs/bad/01-negative-density.toml"][..],
        &["compare", "tests/inputs/bad/20-unknown-key.toml"],
        &["run", "no/such/case.toml"],
        &["run", CASE, "--set", "run.duratoin=1 s"],
        &["run", CASE, "--model", "firm"],
        &["run", CASE, "--threads", "0"],
        &["impact", CASE],
        &["impact", "impact", "--set", "run.duration=0 s"],
        &["fluid", "cases/impact.toml"],
    ] {
        let output = into(&folder, arguments);
        assert_eq!(code(&output), 2, "{arguments:?}");
        assert!(!output.stderr.is_empty() && output.stdout.is_empty(), "{arguments:?}");
        assert!(!folder.exists(), "{arguments:?} made a folder");
    }
    let output = into(&folder, &["run", CASE, "--set", "run.duratoin=1 s"]);
    assert!(words(&output.stderr).contains("duration"), "no suggestion in {}", words(&output.stderr));
    let output = diptych(&["check", "tests/inputs/bad/01-negative-density.toml"]);
    assert_eq!(code(&output), 2);
    assert!(words(&output.stderr).contains("01-negative-density.toml:"));
}

#[test]
fn a_run_leaves_what_is_promised_and_is_not_overwritten() {
    let (_keep, folder) = place();
    let output = into(&folder, &["run", CASE, "--save-state"]);
    assert_eq!(code(&output), 0, "{}", words(&output.stderr));
    // the output is piped: one line of progress per interval, and this run is shorter than an interval
    let told = words(&output.stderr);
    let progress: Vec<&str> = told.lines().filter(|line| line.contains("simulated")).collect();
    assert_eq!(progress.len(), 1, "{told}");
    assert!(progress[0].contains("100 %") && !told.contains('\r') && !told.contains('\u{1b}'), "{told}");
    assert!(words(&output.stdout).contains("report.html"));
    let profiles = read(&folder, "profiles.csv");
    let header = profiles.lines().next().unwrap();
    assert!(header.starts_with("variant,slice,y_m,number_density_ratio,U,V,W,uu,vv,ww,uv,uw,vw,uuu,"), "{header}");
    assert!(header.ends_with("www_se,samples"), "{header}");
    assert_eq!(profiles.lines().count(), 11);
    let state = read(&folder, "state.csv");
    assert!(state.starts_with("# diptych state: 100 particles, checksum "), "{state}");
    let (about, table): (Vec<&str>, Vec<&str>) = state.lines().partition(|line| line.starts_with('#'));
    for key in ["version: ", "case: ", "time_s: ", "units: m, m/s", "box_m: ", "periodic: "] {
        assert!(about.iter().any(|line| line.starts_with(&format!("# {key}"))), "{key} {about:?}");
    }
    assert_eq!((table[0], table.len()), ("id,x,y,z,vx,vy,vz,diameter,species", 101));
    assert!(read(&folder, "impacts.csv").starts_with("variant,"));
    let page = read(&folder, "report.html");
    assert!(page.starts_with("<!DOCTYPE html>") && page.contains("<svg") && !page.contains("src="));
    for figure in ["number-density", "streamwise-velocity", "second-moments", "impact-speed"] {
        assert!(read(&folder, &format!("figures/{figure}.svg")).contains("</svg>"), "{figure}");
    }
    let summary = summary(&folder);
    for key in ["case", "command", "status", "versions", "seed", "variants"] {
        assert!(!summary[key].is_null(), "{key}");
    }
    let variant = &summary["variants"][0];
    for key in [
        "model",
        "parameters",
        "pair_impacts",
        "wall_impacts",
        "windows",
        "counters",
        "wall_seconds",
        "simulated_seconds",
        "particle_windows_per_second",
        "energy",
        "restitution",
        "final_state_hash",
    ] {
        assert!(!variant[key].is_null(), "{key}");
    }
    assert_eq!(variant["status"], "complete");

    let before = read(&folder, "report.html");
    let again = into(&folder, &["run", CASE]);
    assert_eq!(code(&again), 2);
    assert!(words(&again.stderr).contains("--overwrite"), "{}", words(&again.stderr));
    assert_eq!(read(&folder, "report.html"), before);
    let again = into(&folder, &["run", CASE, "--overwrite"]);
    assert_eq!(code(&again), 0);
    assert!(!folder.join("state.csv").exists(), "a table of the run before stayed behind");
}

#[test]
fn a_saved_state_starts_another_run() {
    let (_keep, folder) = place();
    assert_eq!(code(&into(&folder, &["run", CASE, "--save-state", "--quiet"])), 0);
    let hash = summary(&folder)["variants"][0]["final_state_hash"].clone();
    let case = folder.join("next.toml");
    let base = std::fs::read_to_string(root().join(CASE)).unwrap();
    let random =
        "count = 100\nvelocity_mean = [\"0 m/s\", \"0 m/s\", \"12 m/s\"]\nvelocity_fluctuation = \"0.5 m/s\"\n";
    assert!(base.contains(random));
    std::fs::write(&case, base.replace(random, "file = \"state.csv\"\n")).unwrap();
    let next = folder.join("next");
    let output = into(&next, &["run", case.to_str().unwrap(), "--quiet"]);
    assert_eq!(code(&output), 0, "{}", words(&output.stderr));
    assert_eq!(summary(&next)["variants"][0]["initial_state_hash"], hash, "17 digits give back every bit");
}

/// Budgets (rates at which drag, impacts and so on change the second moments of velocity) are written together with
/// the report. Each moment has a row for each slice of the box, and a row for all particles. The terms of a row add up
/// to its remainder.
#[test]
fn budgets_are_written_on_request() {
    let (_guard, folder) = place();
    let short = ["--model", "hard", "--set", "run.duration=0.1 s", "--set", "run.average_from=0.05 s", "--budgets"];
    let output = into(&folder, &[&["run", "cases/quick.toml"], &short[..]].concat());
    assert_eq!(code(&output), 0, "{}", words(&output.stderr));
    assert!(words(&output.stdout).contains("uu per second, mean over all particles"), "{}", words(&output.stdout));
    assert!(read(&folder, "figures/budgets.svg").contains("production"));
    assert!(read(&folder, "report.html").contains("Budgets of the second moments"));
    let table = read(&folder, "budgets.csv");
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let rows: Vec<Vec<String>> = reader.records().map(|row| row.unwrap().iter().map(String::from).collect()).collect();
    assert_eq!(rows.len(), 4 * (15 + 1));
    for row in &rows {
        let terms: Vec<f64> = row[3..8].iter().map(|cell| cell.parse().unwrap()).collect();
        let rest: f64 = terms[..4].iter().sum();
        assert!((rest - terms[4]).abs() < 1e-9 * terms.iter().map(|term| term.abs()).sum::<f64>(), "{row:?}");
    }
    let without = ["run", "cases/quick.toml", "--model", "hard", "--overwrite", "--set", "run.duration=1 ms"];
    let output = into(&folder, &[&without[..], &["--set", "run.average_from=0 s"]].concat());
    assert_eq!(code(&output), 0, "{}", words(&output.stderr));
    assert!(!folder.join("budgets.csv").exists(), "budgets of the earlier run remain");
}

/// Budgets attribute every unexplained change of velocity to impacts. They are refused in scenes with turbulence,
/// lift, heating or shear, whose effects would count as impacts.
#[test]
fn budgets_of_other_forces_are_refused() {
    let lift = ["--set", "fluid.lift={ shear = true }"];
    for (case, sets, why) in [
        ("turbulence/homogeneous", &[][..], "the mean gas flow alone"),
        ("driven/heated-gas", &[], "not heated"),
        ("shear/simple-shear", &[], "not sheared"),
        ("quick", &lift, "without lift"),
    ] {
        let (_keep, folder) = place();
        let output = into(&folder, &[&["run", case, "--model", "hard", "--budgets"], sets].concat());
        let told = words(&output.stderr);
        assert_eq!(code(&output), 2, "{case}: {told}");
        assert!(told.contains("--budgets needs") && told.contains(why) && !folder.exists(), "{case}: {told}");
    }
}

#[test]
fn comparing_writes_every_variant() {
    let (_keep, folder) = place();
    let output = into(&folder, &["compare", CASE]);
    assert_eq!(code(&output), 0, "{}", words(&output.stderr));
    assert!(words(&output.stdout).starts_with("\"soft\" against \"hard\": "), "{}", words(&output.stdout));
    let profiles = read(&folder, "profiles.csv");
    for name in ["soft", "hard"] {
        assert_eq!(profiles.lines().filter(|line| line.starts_with(&format!("{name},"))).count(), 10);
    }
    let summary = summary(&folder);
    let starts: Vec<_> = summary["variants"].as_array().unwrap().iter().map(|v| &v["initial_state_hash"]).collect();
    assert!(starts.len() == 2 && starts[0] == starts[1]);
    // a very short run gives no information about cost
    for figure in ["differences", "number-density", "overlap"] {
        assert!(folder.join(format!("figures/{figure}.svg")).exists(), "{figure}");
    }
}

/// Checks a run that stopped: exit code 1, the failure in the message and in the summary, and readable files.
fn stopped(folder: &Path, output: &Output, failure: &str, says: &str) {
    let told = words(&output.stderr);
    assert_eq!(code(output), 1, "{told}");
    assert!(told.contains("stopped") && told.contains(says), "{told}");
    let variant = &summary(folder)["variants"][0];
    assert_ne!(variant["status"], "complete");
    assert!(variant["failure"][failure].is_object(), "{}", variant["failure"]);
    assert!(read(folder, "report.html").contains("stopped early"));
    assert!(read(folder, "profiles.csv").lines().count() > 1);
}

#[test]
fn a_failure_on_the_way_is_a_result() {
    let (_keep, folder) = place();
    let weak = ["--set", "soft.linear_spring_dashpot.stiffness=1e-3 N/m", "--set", "contact.restitution=1"];
    let output = into(&folder, &[&["run", CASE, "--model", "soft", "--set", "run.duration=1 s"], &weak[..]].concat());
    stopped(&folder, &output, "overlap_too_large", "raise soft stiffness");

    let (_keep, folder) = place();
    let case = folder.with_file_name("bouncing.toml");
    std::fs::write(&case, BOUNCING).unwrap();
    let output = into(&folder, &["run", case.to_str().unwrap()]);
    stopped(&folder, &output, "inelastic_collapse", "inelastic collapse");
    // the run stops at the end of the infinite series of bounces: (1+e)/(1-e) sqrt(2h/g), h = 2.2 mm - 0.203 mm
    let time = summary(&folder)["variants"][0]["failure"]["inelastic_collapse"]["time"].as_f64().unwrap();
    let end = 3.0 * (2.0 * 1.997e-3 / 9.81_f64).sqrt();
    assert!((time / end - 1.0).abs() < 1e-6, "{time} {end}");

    // docs/limits.md: at the θ of the literature, a step carries a sphere through the wall
    let (_keep, folder) = place();
    let stepped = ["--set", "hard.stepping=steps", "--set", "hard.theta=0.3"];
    let short = ["--set", "run.duration=1 s", "--set", "run.average_from=0.5 s"];
    let output = into(&folder, &[&["run", "cases/quick.toml"], &stepped[..], &short[..]].concat());
    stopped(&folder, &output, "escaped", "outside the domain");
}

#[test]
fn quiet_is_silent() {
    let (_keep, folder) = place();
    for arguments in [&["run", CASE][..], &["compare", CASE], &["impact"], &["fluid", CASE]] {
        let folder = folder.join(arguments[0]);
        let output = into(&folder, &[arguments, &["--quiet"]].concat());
        assert_eq!(code(&output), 0, "{arguments:?}");
        assert!(output.stdout.is_empty() && output.stderr.is_empty(), "{arguments:?}: {}", words(&output.stderr));
        assert!(folder.join("summary.json").exists(), "{arguments:?}");
    }
}

#[test]
fn impact_shows_the_contact() {
    let (_keep, folder) = place();
    let output = into(&folder, &["impact"]);
    assert_eq!(code(&output), 0, "{}", words(&output.stderr));
    let path = read(&folder, "impact.csv");
    assert_eq!(path.lines().next().unwrap(), "variant,t_s,gap_m,normal_velocity_m_s");
    // the overlap of soft spheres rises from zero to 0.58 % of the diameter at 3000 N/m (closed form, Eq. 10), and
    // falls again
    let deepest = |name: &str| {
        let mut rows = csv::Reader::from_reader(path.as_bytes());
        let gaps = rows.records().map(Result::unwrap).filter(|row| &row[0] == name);
        gaps.map(|row| row[2].parse::<f64>().unwrap()).fold(f64::INFINITY, f64::min)
    };
    assert!((deepest("soft, k = 3000 N/m") / -2.338e-6 - 1.0).abs() < 1e-3);
    assert!(deepest("hard").abs() < 1e-15);
    assert!(folder.join("figures/overlap-in-time.svg").exists() && folder.join("report.html").exists());
}

#[test]
fn fluid_and_check_speak() {
    let (_keep, folder) = place();
    let output = into(&folder, &["fluid", "cases/channel-d.toml"]);
    assert_eq!(code(&output), 0);
    assert!(words(&output.stdout).contains("Bulk velocity 15.9075 m/s"), "{}", words(&output.stdout));
    assert!(read(&folder, "profile.csv").starts_with("y_m,U_m_s,"));
    assert!(folder.join("figures/wall-units.svg").exists());
    let output = diptych(&["check", "cases/quick.toml"]);
    assert_eq!(code(&output), 0);
    let told = words(&output.stdout);
    for part in ["2433 of \"polystyrene 1.5 mm\"", "pair contact 4.2425e-5 s, N_c = 20.00", "\"stepped hard\", hard"] {
        assert!(told.contains(part), "no {part:?} in\n{told}");
    }
}

/// Sets of values and the case of `diptych impact` are built into the program, because an installed program is started
/// in folders without `cases/` and `models/`.
#[test]
fn sets_and_the_case_of_impact_are_built_in() {
    let elsewhere = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_diptych"));
        command.current_dir(elsewhere.path()).args(arguments).output().unwrap()
    };
    let output = run(&["impact", "--quiet"]);
    assert_eq!(code(&output), 0, "{}", words(&output.stderr));
    assert!(elsewhere.path().join("out/impact-impact/summary.json").exists());
    std::fs::write(elsewhere.path().join("bouncing.toml"), BOUNCING).unwrap();
    let check = ["check", "bouncing.toml", "--set", "soft.linear_spring_dashpot.stiffness=3000"];
    let output = run(&check);
    assert!(code(&output) == 0 && words(&output.stdout).contains("406"), "{}", words(&output.stderr));
    // a set with the name of a built-in set, in the folder of the case, replaces the built-in set
    let folder = elsewhere.path().join("models/particles");
    std::fs::create_dir_all(&folder).unwrap();
    let own = "name = \"own\"\ndiameter = \"300 um\"\ndensity = \"1000 kg/m^3\"\nsource = \"none\"\n";
    std::fs::write(folder.join("polystyrene-406um.toml"), own).unwrap();
    let output = run(&check);
    assert!(code(&output) == 0 && words(&output.stdout).contains("\"own\""), "{}", words(&output.stdout));
    // the message about an unknown name lists the known names
    let output = run(&["check", "bouncing.toml", "--set", "contact.use=contacts/elastic-smoth"]);
    assert!(
        code(&output) == 2 && words(&output.stderr).contains("contacts/elastic-smooth"),
        "{}",
        words(&output.stderr)
    );
}

/// The message about an impossible time, such as a negative one, names the key of this time.
#[test]
fn times_out_of_range_are_said_of_their_own_key() {
    let place = tempfile::tempdir().unwrap();
    for (option, time, said) in [
        ("--every", "-1 ms", "`output.every` = -1 ms is out of range"),
        ("--set", "statistics.sample_interval=1e-300 s", "--> --set statistics.sample_interval=1e-300 s"),
        ("--set", "output.every=1e-300 s", "--> --set output.every=1e-300 s"),
    ] {
        let folder = place.path().join("none");
        let output = into(&folder, &["run", "tests/inputs/good/base.toml", option, time]);
        let told = words(&output.stderr);
        assert_eq!(code(&output), 2, "{told}");
        assert!(told.contains(said) && !folder.exists(), "{told}");
    }
}
