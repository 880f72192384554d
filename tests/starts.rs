//! What a case may start from and for how long it may run: states that a run has saved, tables of the user's, lengths.

use diptych::case::{Case, saved};
use diptych::experiment::{Experiment, Model};
use std::path::Path;

const HEADER: &str = "x,y,z,vx,vy,vz,diameter,species\n";

/// The small channel of the inputs without gas, with two kinds of spheres from the table `text`; the experiment and its warnings.
fn read(text: &str, sets: &[&str], model: Model) -> Result<(Experiment, String), String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("start.csv"), text).unwrap();
    let case = "
        domain = { size = [0.012, 0.004, 0.006], periodic = [\"x\", \"z\"] }
        particles = [
            { name = \"a\", diameter = 4e-4, density = 1000, file = \"start.csv\" },
            { name = \"b\", diameter = 2e-4, density = 1000, file = \"start.csv\" },
        ]
        walls = [{ plane = { point = [0, 0, 0], normal = [0, 1, 0] }, restitution = 0.9, friction = 0 }]
        contact = { restitution = 0.9, friction = 0 }
        soft = { linear_spring_dashpot = { stiffness = 3000 } }
        run = { model = \"hard\", duration = 0.1 }";
    let case: String = case.lines().map(|line| line.trim().to_owned() + "\n").collect();
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let path = folder.path().join("case.toml");
    std::fs::write(&path, case).unwrap();
    let read = Case::read(&path, &sets).and_then(|case| case.experiment(Some(model), None));
    let told = |warnings: Vec<diptych::case::Diagnostic>| warnings.iter().map(|w| w.to_string() + "\n").collect();
    read.map(|(experiment, warnings)| (experiment, told(warnings))).map_err(|error| error.to_string())
}

#[track_caller]
fn refused(text: &str, sets: &[&str], model: Model, parts: &[&str]) {
    let Err(message) = read(text, sets, model) else { panic!("{sets:?} was accepted under {model:?}:\n{text}") };
    for part in parts {
        assert!(message.contains(part), "no {part:?} in\n{message}");
    }
}

/// Two spheres of 0.4 mm a tenth of a diameter within one another, and one half as deep in the floor.
fn deep() -> String {
    let rows = "2e-3,1e-3,1e-3,0,0,0,4e-4,a\n2.36e-3,1e-3,1e-3,0,0,0,4e-4,a\n5e-3,1.8e-4,3e-3,0,0,0,4e-4,a\n";
    format!("{HEADER}{rows}")
}

#[test]
fn a_saved_state_starts_with_its_overlaps() {
    let state = saved::sign(&deep(), 3);
    let steps = "hard.stepping=\"steps\"";
    for (sets, model) in [(&[][..], Model::Soft), (&[steps], Model::Hard)] {
        let (experiment, told) = read(&state, sets, model).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(experiment.start[0].amount.count(), 3);
        assert!(told.contains("1.000e-1 of a diameter") && told.contains("worst of 2"), "{told}");
    }
    refused(&state, &[], Model::Hard, &["particle 0", "particle 1", "1.000e-1 of a diameter", "worst of 2 overlaps"]);
    // the same places from the user's own hand are a slip
    refused(&deep(), &[], Model::Soft, &["up to 0.01 of a diameter"]);
    refused(&deep(), &[steps], Model::Hard, &["1.000e-1 of a diameter"]);
    // beyond the depth at which a run stops nothing starts
    let deeper = deep().replace("2.36e-3", "2.1e-3");
    refused(&saved::sign(&deeper, 3), &[], Model::Soft, &["7.500e-1 of a diameter"]);
}

#[test]
fn a_damaged_state_is_refused() {
    let state = saved::sign(&deep(), 3);
    let cut = state.trim_end().rfind('\n').unwrap();
    refused(&state[..=cut], &[], Model::Soft, &["start.csv:1", "holds 2 particles", "says 3", "save the state again"]);
    refused(&state.replace("2.36e-3", "2.37e-3"), &[], Model::Soft, &["start.csv:1", "checksum"]);
    refused(&state.replace(" particles, ", " "), &[], Model::Soft, &["start.csv:1", "damaged"]);
    refused(&state[..=state.find('\n').unwrap()], &[], Model::Soft, &["holds 0 particles"]);
    // line ends of another system are no damage
    read(&state.replace('\n', "\r\n"), &[], Model::Soft).unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn a_table_without_lines_or_with_a_column_twice_does_not_pass() {
    let (experiment, told) = read(HEADER, &[], Model::Hard).unwrap();
    assert_eq!(experiment.start[0].amount.count(), 0);
    assert!(told.contains("no line of numbers"), "{told}");
    let twice = "x,y,z,vx,vy,vz,vx\n1e-3,1e-3,1e-3,0,0,0,1\n";
    refused(twice, &[], Model::Hard, &["start.csv:1", "`vx` twice"]);
}

#[test]
fn velocities_are_limited_however_they_are_given() {
    let fast = format!("{HEADER}1e-3,1e-3,1e-3,0,1e100,0,4e-4,a\n");
    refused(&fast, &[], Model::Hard, &["start.csv:2", "`vy` = 1e100 m/s", "1e5"]);
    let base = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/inputs/good/base.toml");
    let text = std::fs::read_to_string(base).unwrap();
    let (begin, rest) = text.split_once("count = 100").unwrap();
    let (_, end) = rest.split_once("velocity_fluctuation = \"0.5 m/s\"").unwrap();
    let case = format!("{begin}at = [{{ position = [1e-3, 1e-3, 1e-3], velocity = [0, -1e100, 0] }}]{end}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("case.toml");
    std::fs::write(&path, case).unwrap();
    let error = Case::read(&path, &[]).and_then(|case| case.experiment(None, None)).unwrap_err().to_string();
    assert!(error.contains("velocity[1]") && error.contains("1e5 m/s") && error.contains("case.toml:21"), "{error}");
}

#[test]
fn overlaps_of_unequal_pairs_name_their_diameter() {
    // radii of 0.2 and 0.1 mm, 0.29 mm apart: a twentieth of 0.2 mm
    let table = format!("{HEADER}2e-3,1e-3,1e-3,0,0,0,4e-4,a\n2.29e-3,1e-3,1e-3,0,0,0,2e-4,b\n");
    refused(&table, &[], Model::Hard, &["5.000e-2 of the smaller diameter"]);
    let failure = diptych::engine::Failure::OverlapTooLarge {
        time: 0.0,
        particle: 0,
        partner: diptych::engine::Partner::Particle(1),
        ratio: 0.6,
        limit: 0.5,
    };
    assert!(failure.to_string().contains("0.600 of the smaller diameter"), "{failure}");
}
