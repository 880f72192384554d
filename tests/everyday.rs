//! Situations of many users: long names, folders in use or emptied, damaged files, large scenes, bad cases read by
//! programs.

use crate::support::{BASE, diptych, empty, experiment, plane, small, surface, words};
use diptych::case::Case;
use diptych::checkpoint::{Store, StoredCommand};
use diptych::experiment::{Experiment, Model};
use diptych::placement::{initial_state, initial_state_within};
use diptych::study::check_text;
use diptych::walls::{Geometry, Nearest, Wall, WallGeometry};
use nalgebra::Vector3;
use std::path::Path;
use std::process::Stdio;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

const TEXT: &str = include_str!("inputs/good/base.toml");

/// Longest waiting time for an event that must occur. It is long because the machine may be busy.
const PATIENCE: Duration = Duration::from_secs(60);

fn wait_for(what: impl Fn() -> bool) {
    let began = Instant::now();
    while !what() {
        assert!(began.elapsed() < PATIENCE, "it did not come");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn read(text: &str) -> Case {
    Case::from_text(Path::new("case.toml"), text.into(), &[]).unwrap()
}

#[test]
fn a_name_of_400_characters_is_no_obstacle() {
    let place = tempfile::tempdir().unwrap();
    let (case, out) = (place.path().join("case.toml"), place.path().join("o"));
    let names =
        ["x", "y"].map(|end| format!("[[compare]]\nname = \"{}{end}\"\nmodel = \"hard\"\n", "long ".repeat(80)));
    std::fs::write(&case, format!("{TEXT}\n{}", names.concat())).unwrap();
    let run = diptych(&["compare"])
        .arg(&case)
        .args(["--every", "1 ms", "--set", "run.duration=2 ms", "--out"])
        .arg(&out)
        .output();
    let output = run.unwrap();
    assert!(output.status.success(), "{}", words(&output.stderr));
    // two long names give two different files
    let indices = std::fs::read_dir(out.join("trajectory")).unwrap().flatten();
    assert_eq!(indices.filter(|entry| entry.path().extension().is_some_and(|end| end == "pvd")).count(), 2);
}

#[test]
fn a_folder_in_use_is_said_to_be_in_use() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("o");
    let long = ["run", BASE, "--set", "run.duration=1000 s", "--checkpoint-every", "0.05 s", "--quiet", "--out"];
    let mut first = diptych(&long).arg(&folder).stderr(Stdio::null()).spawn().unwrap();
    wait_for(|| folder.join("checkpoint/a").exists());
    let second = diptych(&["run", BASE, "--out"]).arg(&folder).output().unwrap();
    first.kill().unwrap();
    first.wait().unwrap();
    assert_eq!(second.status.code(), Some(2));
    assert!(words(&second.stderr).contains("another run is writing into"), "{}", words(&second.stderr));
    let third = diptych(&["run", BASE, "--out"]).arg(&folder).output().unwrap();
    assert!(words(&third.stderr).contains("was stopped before its end"), "{}", words(&third.stderr));
}

#[test]
fn frames_that_are_gone_are_told_and_not_listed() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("o");
    let run = ["run", BASE, "--every", "0.2 ms", "--quiet", "--set", "run.duration=0.3 s", "--out"];
    let running = diptych(&run).arg(&folder).stderr(Stdio::piped()).spawn().unwrap();
    let frame = |number: u32| folder.join(format!("trajectory/hard/{number:06}.vtp"));
    wait_for(|| frame(3).exists());
    (0..3).for_each(|number| std::fs::remove_file(frame(number)).unwrap());
    let output = running.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", words(&output.stderr));
    assert!(
        words(&output.stderr).contains("3 of 1501 frames of the trajectory were removed"),
        "{}",
        words(&output.stderr)
    );
    let index = std::fs::read_to_string(folder.join("trajectory/hard.pvd")).unwrap();
    assert!(!index.contains("000002.vtp") && index.contains("000003.vtp") && index.contains("001500.vtp"));
    assert!(folder.join("summary.json").exists());
}

#[test]
fn programs_read_what_is_wrong_with_a_case() {
    for (case, part) in
        [("tests/inputs/bad/01-negative-density.toml", "density"), ("no/such/case.toml", "cannot be read")]
    {
        let output = diptych(&["check", case, "--json"]).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(told["error"]["message"].as_str().unwrap().contains(part) && told["case"] == case, "{told}");
        assert!(told["error"]["help"].is_string() && words(&output.stderr).contains(part));
    }
}

#[test]
fn a_damaged_command_has_a_copy() {
    let place = tempfile::tempdir().unwrap();
    let store = Store::of(place.path());
    let command = StoredCommand {
        arguments: vec!["diptych".into(), "run".into()],
        folder: "/".into(),
        case: 1,
        runs: Vec::new(),
    };
    for damaged in ["command", "command-copy"] {
        store.begin(&command).unwrap();
        std::fs::write(place.path().join("checkpoint").join(damaged), "damaged").unwrap();
        assert_eq!(store.command().unwrap().arguments, command.arguments, "{damaged}");
    }
    std::fs::write(place.path().join("checkpoint/command"), "damaged").unwrap();
    assert!(store.command().is_err());
    store.remove().unwrap();
    assert!(!place.path().join("checkpoint").exists());
}

/// Case with `count` species of one particle each, of different sizes.
fn of_kinds(count: usize) -> String {
    let kind = |k: usize| {
        let size = 200.0 + 0.1 * k as f64;
        format!("[[particles]]\ndiameter = \"{size:.1} um\"\ndensity = \"1000 kg/m^3\"\ncount = 1\n")
    };
    TEXT.replace("count = 100", "count = 10") + &(0..count).map(kind).collect::<String>()
}

#[test]
fn what_check_does_is_bounded() {
    // there are 45,451 pairs of species, of which each variant lists 20
    let text = check_text(&read(&of_kinds(300))).unwrap();
    assert!(
        text.contains("of many kinds of contact the 20 shortest") && text.lines().count() < 1200,
        "{}",
        text.lines().count()
    );
    let error = check_text(&read(&of_kinds(1000))).unwrap_err().to_string();
    assert!(error.contains("1001 kinds of particles make 501501 pairs of kinds; allowed: up to 1000"), "{error}");
    let wall = "[[walls]]\nsphere = { center = [1e-3, 1e-3, 1e-3], radius = 1e-5 }\nrestitution = 0.9\n";
    let error = check_text(&read(&(TEXT.to_owned() + &wall.repeat(100_000)))).unwrap_err().to_string();
    assert!(error.contains("there are more than 100000 walls"), "{error}");
}

/// Wall that counts the computations of its distance. It fills the whole box, so that no start exists.
#[derive(Debug, Default)]
struct NoRoom(AtomicU64);

impl Geometry for NoRoom {
    fn nearest(&self, _: &Vector3<f64>) -> Nearest {
        self.0.fetch_add(1, Ordering::Relaxed);
        Nearest { distance: -1.0, normal: Vector3::y() }
    }
}

/// Beads between a floor and a lid at the distance `height` [m], in a box ten times as high.
fn between_planes(count: usize, height: f64, gravity: f64) -> Experiment {
    let mut scene = empty([4e-3, 10.0 * height, 4e-3], [true, false, true], small(), surface(0.9, 0.0));
    scene.gravity.y = -gravity;
    scene.walls = vec![
        plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.9, 0.0)),
        plane([0.0, height, 0.0], [0.0, -1.0, 0.0], surface(0.9, 0.0)),
    ];
    experiment(scene, count, [0.0; 3], 0.1, Model::Hard, 1)
}

/// A dense start does not depend on gravity. A neighbour list that allowed for a fall in each step of the relaxation
/// would contain all pairs.
#[test]
fn a_dense_start_knows_no_gravity() {
    // φ = 0.58
    let height = 700.0 * small().volume() / (0.58 * 4e-3 * 4e-3);
    let [still, falling] = [0.0, 9.81].map(|g| initial_state(&between_planes(700, height, g)).unwrap());
    assert_eq!(still.position, falling.position);
}

#[test]
fn more_spheres_than_any_arrangement_holds_are_refused_before_they_are_tried() {
    let height = |fraction: f64| 700.0 * small().volume() / (fraction * 4e-3 * 4e-3);
    let told = |fraction: f64| initial_state_within(&between_planes(700, height(fraction), 9.81), 20_000).unwrap_err();
    let overfull = told(0.75);
    assert!(!overfull.given_up && overfull.most == Some(std::f64::consts::PI / 18f64.sqrt()), "{overfull}");
    assert!(overfull.to_string().contains("no arrangement of such spheres more than 7.405e-1"), "{overfull}");
    // the existence of a random start below this fraction is unknown: it is tried with the given effort
    assert!(told(0.70).given_up);
}

/// The effort of a placement limits the number of distance computations of a wall, plus a few per particle. The test
/// counts computations, so that it does not depend on the machine.
#[test]
fn a_start_that_is_not_found_is_given_up_after_its_effort() {
    let mut experiment = read(TEXT).experiment(None, None).unwrap().0;
    let floor = plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.9, 0.0));
    let counter = Arc::new(NoRoom::default());
    let wall = Wall { geometry: WallGeometry::Other(counter.clone()), ..floor };
    let particles = experiment.count() as u64;
    assert!(initial_state_within(&experiment, 1_000_000).is_ok());
    // if a small effort is sufficient, the start is that of the full effort
    assert_eq!(
        initial_state_within(&experiment, 1_000_000).unwrap().fingerprint(),
        initial_state(&experiment).unwrap().fingerprint()
    );
    experiment.scene.walls.push(wall);
    for effort in [1000, 100_000] {
        let before = counter.0.load(Ordering::Relaxed);
        assert!(initial_state_within(&experiment, effort).is_err());
        let asked = counter.0.load(Ordering::Relaxed) - before;
        // the free volume is measured once, at 8192 points
        assert!(asked < 10 * (effort + particles) + 8192, "{asked}");
    }
}

#[test]
fn check_says_that_no_start_was_found() {
    // φ = 0.70 is between random packings and the densest packing
    let lid = |height: &str| {
        TEXT.replace("point = [\"0 m\", \"4 mm\", \"0 m\"]", &format!("point = [\"0 m\", \"{height}\", \"0 m\"]"))
    };
    let told = check_text(&read(&lid("2 mm").replace("count = 100", "count = 2876"))).unwrap();
    assert!(told.contains("no random start was found with the effort that `check` makes"), "{told}");
    // without any room, `check` refuses the case as `run` does
    let text = lid("1e-15 mm").replace("count = 100", "count = 20000");
    let why = check_text(&read(&text.replace("diameter = \"406 um\"", "diameter = \"10 um\""))).unwrap_err();
    assert!(why.to_string().contains("there is no random start: the particles fill 1.454e11"), "{why}");
}

/// A file that is larger than the free memory is not read, and its size is in the message. The file is sparse: it has
/// a length of 4 TiB, but takes no room on the disk.
#[test]
#[cfg(target_os = "linux")]
fn a_file_longer_than_the_free_memory_is_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("huge.toml");
    std::fs::File::create(&path).unwrap().set_len(1 << 42).unwrap();
    let why = Case::read(&path, &[]).map(|_| ()).unwrap_err().to_string();
    assert!(why.contains("4398.0 GB long") && why.contains("are free for this process"), "{why}");
}
