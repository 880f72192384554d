//! Checks that the sentences of reports and summaries are true of the runs.

use crate::made_up;
use crate::support::{BASE, diptych, words};
use diptych::experiment::Model;
use diptych::study::judge;
use std::path::Path;

/// Runs the program, which must succeed. Returns its output.
fn said(arguments: &[&str], folder: &Path) -> String {
    let output = diptych(arguments).arg("--out").arg(folder).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", words(&output.stderr));
    words(&output.stdout)
}

fn page(folder: &Path) -> String {
    std::fs::read_to_string(folder.join("report.html")).unwrap()
}

/// Path of a new case that consists of the small case and the text `variants`.
fn with_variants(place: &Path, variants: &str) -> String {
    let base = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(BASE)).unwrap();
    let path = place.join("variants.toml");
    std::fs::write(&path, base + variants).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn a_scene_follows_its_variants_and_the_command_line() {
    let place = tempfile::tempdir().unwrap();
    let variants = r#"
[[compare]]
name = "first"
model = "hard"
[[compare]]
name = "second"
model = "hard"
set = { "contact.restitution" = 0.75, "run.duration" = "50 ms" }
"#;
    let case = with_variants(place.path(), variants);
    let folder = place.path().join("results");
    said(&["compare", &case, "--quiet", "--set", "particles[0].diameter=300 um"], &folder);
    let page = page(&folder);
    let line = |name: &str| {
        let begin = page.find(&format!("<li>&quot;{name}&quot;: ")).unwrap();
        page[begin..].split("</li>").next().unwrap()
    };
    assert!(line("first").contains("restitution 0.9,") && line("first").contains("Run: 100 ms"), "{}", line("first"));
    assert!(
        line("second").contains("restitution 0.75,") && line("second").contains("Run: 50 ms"),
        "{}",
        line("second")
    );
    // properties of all variants are written once, and properties of one variant are not attributed to all
    assert_eq!(page.matches("<li>Box: ").count(), 1);
    assert_eq!(page.matches("<li>Together they fill").count() + page.matches("<li>Run: ").count(), 0);
    // the title describes the file and its change
    assert!(page.contains("<title>A small channel: the other inputs differ from it by a line or two. [with particles[0].diameter=300 um]</title>"));
}

#[test]
fn names_of_columns_stay_in_the_tables() {
    let place = tempfile::tempdir().unwrap();
    // the run is too short for error bars, so that the largest difference is named
    let told = said(&["compare", BASE, "--set", "run.duration=1 ms", "--set", "run.average_from=0 s"], place.path());
    assert!(told.contains("granular temperature") && !told.contains("number_density_ratio"), "{told}");
}

/// The times are invented, so that the test of sentences on costs does not depend on the speed of the machine.
#[test]
fn runs_of_a_blink_say_nothing_of_cost() {
    let said = |seconds: f64| {
        let of = |name, model, seed| {
            let mut outcome = made_up::outcome(name, model, seed);
            outcome.timing.wall_seconds = seconds;
            outcome
        };
        let outcomes = [of("soft", Model::Soft, 1), of("hard", Model::Hard, 2)];
        judge(&outcomes, &[Vec::new(), Vec::new()], 0.01).remove(0).further.join("\n")
    };
    assert!(said(0.05).contains("too short a run to compare costs"), "{}", said(0.05));
    assert!(said(5.0).contains("\"soft\" took 1.0 times the wall time of \"hard\""), "{}", said(5.0));
}

#[test]
fn one_is_not_said_in_the_plural() {
    let plan = diptych(&["plan", BASE, "--threads", "1"]).output().unwrap();
    assert!(words(&plan.stdout).contains("on this machine, 1 thread, at"), "{}", words(&plan.stdout));
    let check = diptych(&["check", BASE]).output().unwrap();
    assert!(words(&check.stdout).contains("would run 2 variants:"), "{}", words(&check.stdout));
}

#[test]
fn rounding_is_no_overlap() {
    let place = tempfile::tempdir().unwrap();
    said(&["run", BASE, "--model", "hard", "--quiet"], place.path());
    let page = page(place.path());
    let table = page.split("Between particles").nth(1).unwrap().split("e realised:").next().unwrap();
    assert!(table.contains("<td>0.9") && !table.contains("10⁻¹"), "{table}");
}

#[test]
fn one_impact_says_nothing_of_cost() {
    let place = tempfile::tempdir().unwrap();
    said(&["impact", "--quiet"], place.path());
    let page = page(place.path());
    assert!(page.contains("steps or events") && !page.contains("over cheapest") && !page.contains("wall time</th>"));
}

#[test]
fn the_gas_names_its_pictures() {
    let place = tempfile::tempdir().unwrap();
    let told = said(&["fluid", "cases/channel-d.toml"], place.path());
    let mut pictures = 0;
    for entry in std::fs::read_dir(place.path().join("figures")).unwrap().flatten() {
        assert!(told.contains(entry.path().to_str().unwrap()), "{told}");
        pictures += 1;
    }
    assert!(pictures > 1);
}

/// A body that fills the box leaves no room for even a few particles.
#[test]
fn a_box_without_room_is_not_blamed_on_the_particles() {
    let place = tempfile::tempdir().unwrap();
    let body = r#"
[[walls]]
cuboid = { center = ["6 mm", "2 mm", "3 mm"], half_extents = ["5.9 mm", "1.9 mm", "2.9 mm"] }
restitution = 0.9
"#;
    let case = with_variants(place.path(), body);
    let sets = ["--set", "particles[0].count=2", "--set", "domain.periodic=[]"];
    let output = diptych(&["run", &case]).args(sets).arg("--out").arg(place.path()).output().unwrap();
    let told = words(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("bodies in the box") && told.contains("2.520e-3"), "{told}");
}

/// Every point of the path of an impact is stored and written, so a path with too many points is refused.
#[test]
fn a_path_of_too_many_points_is_refused() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("results");
    let output = diptych(&["impact", "--set", "soft.time_step=1e-13", "--out"]).arg(&folder).output().unwrap();
    let told = words(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("time steps, each a point of its path") && !folder.exists(), "{told}");
}

#[test]
fn a_calendar_for_all_is_called_serial_and_islands_are_not() {
    let place = tempfile::tempdir().unwrap();
    let case = format!("{}/cases/dense-gas.toml", env!("CARGO_MANIFEST_DIR"));
    for (fraction, is_serial) in [("0.3", true), ("0.01", false)] {
        let folder = place.path().join(fraction);
        let fraction = format!("particles[0].volume_fraction={fraction}");
        let times = ["--set", "run.duration=2 ms", "--set", "run.average_from=0 s", "--set", &fraction];
        let run = ["run", &case, "--model", "hard", "--quiet"];
        said(&[&run[..], &times].concat(), &folder);
        assert_eq!(page(&folder).contains("One calendar took one event after the other"), is_serial, "{fraction}");
    }
}
