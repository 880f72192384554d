//! Trajectories: files for other programs contain all bits of the particles. If files cannot be written, the run stops.

use crate::support::{edge, empty, experiment, placed, plane, small, surface};
use diptych::engine::Failure;
use diptych::experiment::{Amount, Experiment, Model, SoftStepping, Trajectories, TrajectoryFormat};
use diptych::observe::{Observer, RunLoop};
use diptych::output::{Folder, Trajectory};
use diptych::particles::Particles;
use diptych::placement::initial_state;
use diptych::schedule::Schedule;
use diptych::simulation::Simulation;
use diptych::study::execute;
use diptych::walls::{Obstacle, PrescribedMotion, Wall, WallGeometry};
use nalgebra::Vector3;
use std::path::Path;
use std::process::Command;

const BOTH: Trajectories = Trajectories { every: 1e-4, format: TrajectoryFormat::Both };

/// State at one instant: particles in the order of ids, number of contacts and largest overlap of each particle, and
/// time.
struct Seen {
    time: f64,
    state: Particles,
    touching: Vec<(u16, f64)>,
}

/// Runs an experiment that writes trajectories into a folder. Returns the outcome, and the states at the times of the
/// frames.
fn watched(experiment: &Experiment, folder: &Folder, asked: Trajectories) -> (diptych::Outcome, Vec<Seen>) {
    struct Notes(f64, Vec<Seen>);
    impl diptych::observe::Observer for Notes {
        fn next(&self, now: f64, _: &diptych::schedule::Schedule) -> Option<f64> {
            Some(((now / self.0).round() + 1.0) * self.0)
        }

        fn see(&mut self, simulation: &Simulation) {
            let mut touching = vec![(0, 0.0_f64); simulation.particles.len()];
            for (couple, overlap) in simulation.contacts() {
                for place in couple.indices().into_iter().flatten() {
                    let (count, most) = &mut touching[simulation.particles.id[place as usize] as usize];
                    (*count, *most) = (*count + 1, most.max(overlap));
                }
            }
            self.1.push(Seen { time: simulation.time, state: simulation.state(), touching });
        }
    }
    let mut notes = Notes(asked.every, Vec::new());
    let outcome = std::thread::scope(|scope| {
        let mut trajectory = Trajectory::new(scope, folder, "some", asked);
        let start = initial_state(experiment).unwrap();
        let (outcome, _) = execute(experiment, start, &mut [&mut trajectory, &mut notes]);
        trajectory.written().unwrap();
        outcome
    });
    (outcome, notes.1)
}

/// Bytes of an array in a VTK file.
pub fn array<'a>(file: &'a [u8], name: &str) -> &'a [u8] {
    let mark = "<AppendedData encoding=\"raw\">\n_";
    // the text of the header reaches to the first byte that is no text, which is one of the data
    let text = file.utf8_chunks().next().unwrap().valid();
    let begin = text.find(mark).unwrap();
    let header = &text[..begin];
    let line =
        header.lines().find(|line| line.contains(&format!("Name=\"{name}\""))).unwrap_or_else(|| panic!("{name}"));
    let offset: usize = line.split("offset=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
    let data = &file[begin + mark.len() + offset..];
    let length = u64::from_le_bytes(data[..8].try_into().unwrap()) as usize;
    &data[8..8 + length]
}

pub fn numbers<const N: usize, T>(bytes: &[u8], read: fn([u8; N]) -> T) -> Vec<T> {
    bytes.chunks_exact(N).map(|chunk| read(chunk.try_into().unwrap())).collect()
}

fn flat(vectors: &[Vector3<f64>]) -> Vec<f64> {
    vectors.iter().flatten().copied().collect()
}

/// Experiment of a dense gas under gravity between walls, with contacts at most instants.
fn crowd(model: Model, stepping: SoftStepping) -> Experiment {
    let size = edge(60, 406e-6, 0.25);
    let mut scene = empty([size; 3], [true, false, true], small(), surface(0.9, 0.1));
    scene.gravity = Vector3::new(0.0, -9.81, 0.0);
    scene.walls = vec![
        plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.9, 0.0)),
        plane([0.0, size, 0.0], [0.0, -1.0, 0.0], surface(0.9, 0.0)),
    ];
    let mut crowd = experiment(scene, 60, [0.0; 3], 1.0, model, 3);
    crowd.soft.law = Some(diptych::contact_law::ContactLaw::linear(100.0));
    if model == Model::Soft {
        crowd.run.spheres = diptych::experiment::Spheres::Soft(diptych::contact_law::ContactLaw::linear(100.0));
    }
    crowd.soft.stepping = stepping;
    crowd.run.duration = 2.05e-3;
    crowd.run.window = Some(1e-5);
    crowd.statistics.sample_interval = Some(4e-4);
    crowd
}

#[test]
fn walls_of_each_frame_are_at_their_places_of_that_time() {
    let mut crowd = crowd(Model::Hard, SoftStepping::Auto);
    let amplitude = 1e-5;
    let motion =
        PrescribedMotion::Vibration { amplitude: Vector3::new(0.0, amplitude, 0.0), frequency: 900.0, phase: 0.0 };
    let size = crowd.scene.domain.size.y;
    // in the box throughout, so that it is drawn in every frame
    let plate = plane([0.0, 2.0 * amplitude, 0.0], [0.0, 1.0, 0.0], surface(0.9, 0.0));
    crowd.scene.walls[0] = plate.moving(motion).unwrap();
    let place = tempfile::tempdir().unwrap();
    let folder = Folder::create(place.path(), true).unwrap();
    let (_, seen) = watched(&crowd, &folder, Trajectories { format: TrajectoryFormat::Vtp, ..BOTH });
    let read = |name: &str| std::fs::read(place.path().join("trajectory").join(name)).unwrap();
    let index = String::from_utf8(read("some.pvd")).unwrap();
    assert!(!place.path().join("trajectory/some-walls.vtp").exists());
    let mut heights = Vec::new();
    for (number, Seen { time, .. }) in seen.iter().enumerate() {
        let name = format!("some/{number:06}-walls.vtp");
        assert!(index.contains(&format!("timestep=\"{time:?}\" part=\"1\" file=\"{name}\"")), "{name}");
        let corners = numbers(array(&read(&name), "Points"), f64::from_le_bytes);
        let height = amplitude * (2.0 + (2.0 * std::f64::consts::PI * 900.0 * time).sin());
        for corner in corners.chunks_exact(3) {
            // corners of the upper plane, which rests, or of the lower one; the tolerance is the rounding of a coordinate
            assert!(corner[1] == size || (corner[1] - height).abs() < 1e-15 * size, "{name}: {corner:?}, {height}");
        }
        heights.push(height);
    }
    let spread = heights.iter().fold(f64::NEG_INFINITY, |most, h| most.max(*h))
        - heights.iter().fold(f64::INFINITY, |least, h| least.min(*h));
    assert!(heights.len() == 21 && spread > amplitude, "the plate has moved by {spread} m");
}

#[test]
fn contacts_of_each_frame_are_those_of_that_instant() {
    let mut crowd = crowd(Model::Soft, SoftStepping::Uniform);
    crowd.observe.contact_network = true;
    let place = tempfile::tempdir().unwrap();
    let folder = Folder::create(place.path(), true).unwrap();
    struct Contacts(Vec<Vec<diptych::observe::ContactLine>>, diptych::contact_law::ContactLaw);
    impl Observer for Contacts {
        fn next(&self, now: f64, _: &Schedule) -> Option<f64> {
            Some(((now / 1e-4).round() + 1.0) * 1e-4)
        }

        fn see(&mut self, simulation: &Simulation) {
            self.0.push(diptych::observe::contact_lines(simulation, &self.1));
        }
    }
    let law = crowd.law().unwrap();
    let mut contacts = Contacts(Vec::new(), law);
    std::thread::scope(|scope| {
        let asked = Trajectories { format: TrajectoryFormat::Vtp, ..BOTH };
        let mut trajectory = Trajectory::new(scope, &folder, "some", asked).with_contacts(Some(law));
        execute(&crowd, initial_state(&crowd).unwrap(), &mut [&mut trajectory, &mut contacts]);
        trajectory.written().unwrap();
    });
    let index = std::fs::read_to_string(place.path().join("trajectory/some.pvd")).unwrap();
    assert!(contacts.0.len() == 21 && contacts.0.iter().any(|lines| lines.len() > 3));
    for (number, lines) in contacts.0.iter().enumerate() {
        let name = format!("some/{number:06}-contacts.vtp");
        assert!(index.contains(&format!("part=\"2\" file=\"{name}\"")), "{name}");
        let file = std::fs::read(place.path().join("trajectory").join(&name)).unwrap();
        let forces = numbers(array(&file, "force_N"), f64::from_le_bytes);
        let ids = numbers(array(&file, "id"), i32::from_le_bytes);
        assert_eq!(forces, lines.iter().map(|line| line.force).collect::<Vec<_>>(), "{name}");
        assert_eq!(ids, lines.iter().map(|line| line.id as i32).collect::<Vec<_>>(), "{name}");
    }
}

#[test]
fn frames_hold_the_bits_of_the_state() {
    for (model, stepping) in
        [(Model::Soft, SoftStepping::Uniform), (Model::Soft, SoftStepping::Local), (Model::Hard, SoftStepping::Auto)]
    {
        let crowd = crowd(model, stepping);
        let place = tempfile::tempdir().unwrap();
        let folder = Folder::create(place.path(), true).unwrap();
        let (_, seen) = watched(&crowd, &folder, BOTH);
        // 21 frames at multiples of 0.1 ms; the trajectory also has a frame at the end, which its index lists
        assert_eq!(seen.len(), 21);
        let read = |name: &str| std::fs::read(place.path().join("trajectory").join(name)).unwrap();
        let index = String::from_utf8(read("some.pvd")).unwrap();
        let times: Vec<f64> =
            index.split("timestep=\"").skip(1).map(|rest| rest.split('"').next().unwrap().parse().unwrap()).collect();
        // each frame has an entry for the particles and an entry for the walls
        assert_eq!(times.len(), 2 * 22);
        let mut contacts = 0;
        for (number, seen) in seen.iter().enumerate() {
            let file = read(&format!("some/{number:06}.vtp"));
            assert_eq!(times[2 * number], seen.time);
            let f64s = |name: &str| numbers(array(&file, name), f64::from_le_bytes);
            assert_eq!((f64s("Points"), f64s("velocity")), (flat(&seen.state.position), flat(&seen.state.velocity)));
            assert_eq!(
                (f64s("radius"), numbers(array(&file, "id"), u32::from_le_bytes)),
                (seen.state.radius.clone(), seen.state.id.clone())
            );
            let counts = numbers(array(&file, "contacts"), u16::from_le_bytes);
            let touching: Vec<(u16, f64)> = counts.into_iter().zip(f64s("overlap")).collect();
            assert_eq!(touching, seen.touching, "{model:?} {stepping:?} at {} s", seen.time);
            contacts += touching.iter().map(|(count, _)| usize::from(*count)).sum::<usize>();
            let solvers = array(&file, "solver");
            let expected = |solver: &u8| match (model, stepping) {
                (Model::Soft, SoftStepping::Uniform) if seen.time > 0.0 => *solver == 2,
                _ => *solver <= 2,
            };
            assert!(solvers.len() == 60 && solvers.iter().all(expected), "{solvers:?}");
            check_xyz(&String::from_utf8(read(&format!("some/{number:06}.xyz"))).unwrap(), seen, &crowd);
        }
        assert!((model == Model::Soft) == (contacts > 100), "{contacts}");
    }
}

fn check_xyz(text: &str, seen: &Seen, crowd: &Experiment) {
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("60"));
    let comment = lines.next().unwrap();
    let edge = crowd.scene.domain.size.x;
    assert!(comment.contains(&format!("Lattice=\"{edge:?} 0 0 0 {edge:?} 0 0 0 {edge:?}\"")), "{comment}");
    assert!(comment.contains(&format!("Time={:?} pbc=\"T F T\"", seen.time)), "{comment}");
    for (place, line) in lines.enumerate() {
        let cells: Vec<f64> = line.split_whitespace().map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(
            (&cells[..3], &cells[3..6]),
            (seen.state.position[place].as_slice(), seen.state.velocity[place].as_slice())
        );
        let (count, overlap) = seen.touching[place];
        assert_eq!(cells[6..10], [seen.state.radius[place], place as f64, 1.0, overlap]);
        assert_eq!(cells[10], f64::from(count));
    }
}

/// Frames tell how each particle was solved: particles that meet are in an island (group of particles that may meet),
/// other particles fly straight.
#[test]
fn the_solver_of_each_particle_is_told() {
    let scene = empty([0.01; 3], [true; 3], small(), surface(1.0, 0.0));
    let mut three = experiment(scene.clone(), 0, [0.0; 3], 0.0, Model::Hard, 1);
    let particles =
        [([1e-3, 5e-3, 5e-3], [1.0, 0.0, 0.0]), ([1.6e-3, 5e-3, 5e-3], [0.0; 3]), ([8e-3, 8e-3, 8e-3], [0.0; 3])];
    three.start[0].amount = Amount::Placed(placed(&scene, &particles));
    three.run.duration = 4e-4;
    three.run.window = Some(4e-4);
    let place = tempfile::tempdir().unwrap();
    let folder = Folder::create(place.path(), true).unwrap();
    let (outcome, _) = watched(&three, &folder, Trajectories { every: 4e-4, ..BOTH });
    let file = std::fs::read(place.path().join("trajectory/some/000001.vtp")).unwrap();
    assert_eq!(outcome.record.pairs.count, 1);
    // two islands or one event queue, according to the counters of the engine
    let expected = if outcome.counters.islands > 0 { [1, 1, 0] } else { [2, 2, 2] };
    assert_eq!(array(&file, "solver"), expected);
    assert!(outcome.counters.islands > 0);
}

#[test]
fn walls_are_surfaces_within_the_box() {
    let mut crowd = crowd(Model::Hard, SoftStepping::Auto);
    let size = crowd.scene.domain.size;
    let middle = size / 2.0;
    crowd.scene.walls.push(plane([0.0; 3], [0.6, 0.8, 0.0], surface(0.9, 0.0)));
    crowd.scene.walls.push(plane((3.0 * size).into(), [0.0, -1.0, 0.0], surface(0.9, 0.0)));
    crowd
        .scene
        .walls
        .push(Wall::new(WallGeometry::Obstacle(Obstacle::cylinder(middle, 0, 1e-4, 3e-4)), surface(0.9, 0.0)));
    crowd.start[0].amount = Amount::Count(0);
    crowd.run.duration = 0.0;
    let place = tempfile::tempdir().unwrap();
    let folder = Folder::create(place.path(), true).unwrap();
    watched(&crowd, &folder, BOTH);
    let file = std::fs::read(place.path().join("trajectory/some-walls.vtp")).unwrap();
    let points = numbers(array(&file, "Points"), f64::from_le_bytes);
    let corners: Vec<Vector3<f64>> = points.chunks(3).map(Vector3::from_column_slice).collect();
    let ends = numbers(array(&file, "offsets"), i32::from_le_bytes);
    let walls = numbers(array(&file, "wall"), u32::from_le_bytes);
    assert_eq!(walls.len(), ends.len());
    // floor and lid are whole; the slope touches only a corner of the box, and has no surface; nothing outside the box
    // is drawn
    assert_eq!((ends[0], ends[1], &walls[..3]), (4, 8, &[0, 1, 4][..]));
    let area = |corners: &[Vector3<f64>]| {
        (1..corners.len() - 1)
            .map(|k| (corners[k] - corners[0]).cross(&(corners[k + 1] - corners[0])))
            .sum::<Vector3<f64>>()
            .norm()
            / 2.0
    };
    assert!((area(&corners[..4]) / (size.x * size.z) - 1.0).abs() < 1e-12);
    assert!(corners[4..8].iter().all(|corner| corner.y == size.y));
    let body = &corners[8..];
    // points of the surface are at the radius about x, or on the ends
    assert!(body.len() > 100);
    for corner in body {
        let from = corner - middle;
        let radius = from.y.hypot(from.z);
        assert!(
            from.x.abs() < 3e-4 + 1e-12
                && radius < 1e-4 + 1e-12
                && ((radius - 1e-4).abs() < 1e-9 || (from.x.abs() - 3e-4).abs() < 1e-9)
        );
    }
}

/// Case of a few spheres for the command line.
const CASE: &str = r#"
[domain]
size = ["4 mm", "4 mm", "4 mm"]
periodic = ["x", "y", "z"]
[[particles]]
use = "particles/polystyrene-406um"
count = 20
velocity_mean = ["0 m/s", "0 m/s", "0 m/s"]
velocity_fluctuation = "1 m/s"
[contact]
restitution = 0.9
friction = 0.0
[soft.linear_spring_dashpot]
stiffness = "3000 N/m"
[run]
model = "hard"
duration = "10 ms"
"#;

fn diptych(folder: &Path, arguments: &[&str]) -> (i32, String) {
    std::fs::write(folder.join("case.toml"), CASE).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_diptych")).current_dir(folder).args(arguments).output().unwrap();
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn a_comparison_writes_the_same_times_for_every_variant() {
    let place = tempfile::tempdir().unwrap();
    let (code, told) = diptych(place.path(), &["compare", "case.toml", "--every", "1 ms", "--out", "out", "--quiet"]);
    assert_eq!((code, told.as_str()), (0, ""));
    let times = |name: &str| -> Vec<String> {
        let text = std::fs::read_to_string(place.path().join("out/trajectory").join(name)).unwrap();
        text.split("timestep=\"").skip(1).map(|rest| rest.split('"').next().unwrap().to_owned()).collect()
    };
    assert_eq!((times("soft.pvd"), times("soft.pvd").len()), (times("hard.pvd"), 11));
    // results are replaced by a run without trajectories: frames of the earlier run are removed, and files of the user
    // remain
    let own = place.path().join("out/trajectory/hard/own.vtp");
    std::fs::write(&own, "of the user").unwrap();
    assert_eq!(diptych(place.path(), &["run", "case.toml", "--out", "out", "--overwrite", "--quiet"]).0, 0);
    assert!(!place.path().join("out/trajectory/soft.pvd").exists() && own.exists());
    assert!(!place.path().join("out/trajectory/soft").exists(), "an empty folder is left");
    assert!(!place.path().join("out/trajectory/hard/000000.vtp").exists());
}

#[test]
fn a_trajectory_that_cannot_be_written_stops_the_run_with_a_message() {
    let place = tempfile::tempdir().unwrap();
    // a file has the name of the folder for frames, so that no frame can be written
    std::fs::create_dir_all(place.path().join("out/trajectory")).unwrap();
    std::fs::write(place.path().join("out/trajectory/soft"), "in the way").unwrap();
    let (code, told) =
        diptych(place.path(), &["compare", "case.toml", "--set", "output.every=1 ms", "--out", "out", "--quiet"]);
    assert!(code == 1 && told.contains("\"soft\" stopped: at t = ") && told.contains("cannot write"), "{code} {told}");
    assert!(told.contains("trajectory/soft/00000"), "{told}");
    let page = std::fs::read_to_string(place.path().join("out/report.html")).unwrap();
    assert!(page.contains("stopped early"));
    assert_eq!(std::fs::read_to_string(place.path().join("out/trajectory/soft")).unwrap(), "in the way");
    // the comparison can be completed when frames can be written again
    assert!(told.contains("once it can be written, `diptych resume"), "{told}");
    assert!(!place.path().join("out/summary.json").exists());
    std::fs::remove_file(place.path().join("out/trajectory/soft")).unwrap();
    let (code, told) = diptych(place.path(), &["resume", "out", "--quiet"]);
    assert_eq!((code, told.as_str()), (0, ""));
    for variant in ["soft", "hard"] {
        assert!(place.path().join(format!("out/trajectory/{variant}/000010.vtp")).exists(), "{variant}");
    }
    let failure = Failure::Unwritten { time: 0.5, why: "cannot write x: full".into() };
    assert_eq!(
        (failure.time(), failure.to_string().as_str()),
        (0.5, "at t = 0.5 s the run was stopped: cannot write x: full")
    );
}

/// The disk has room for only some of the frames. The run ends with a message, and the frames on the disk are complete
/// and listed. When there is room again, the resumed run gives the files of an uninterrupted run.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "needs a name space with a disk of its own: unshare must be allowed; cargo test --test it trajectory::a_disk_that -- --ignored"]
fn a_disk_that_is_full_leaves_whole_frames() {
    let place = tempfile::tempdir().unwrap();
    let short = ["--every", "0.1 ms", "--set", "output.format=both", "--checkpoint-every", "1 ms", "--quiet"];
    let run = ["run", "case.toml", "--set", "particles[0].count=200"];
    assert_eq!(diptych(place.path(), &[&run[..], &short, &["--out", "whole"]].concat()), (0, String::new()));
    let quoted: Vec<String> = run.iter().chain(&short).map(|argument| format!("'{argument}'")).collect();
    let script = format!(
        "mkdir disk && mount -t tmpfs -o size=1m none disk; '{program}' {} --out disk/r; echo code $?; cp -r disk/r full; \
         mount -o remount,size=50m disk && '{program}' resume disk/r; echo code $?; cp -r disk/r resumed",
        quoted.join(" "),
        program = env!("CARGO_BIN_EXE_diptych"),
    );
    let output = Command::new("unshare")
        .args(["--user", "--map-root-user", "--mount", "sh", "-c", &script])
        .current_dir(place.path())
        .output()
        .unwrap();
    let (said, told) =
        (String::from_utf8_lossy(&output.stdout).into_owned(), String::from_utf8_lossy(&output.stderr).into_owned());
    assert!(said.contains("code 1\n") && said.ends_with("code 0\n"), "{said}{told}");
    assert!(told.contains("No space left on device") && told.contains("once it can be written"), "{told}");
    let read =
        |folder: &str, name: &str| std::fs::read(place.path().join(folder).join("trajectory").join(name)).unwrap();
    let frames = |folder: &str| {
        let files = std::fs::read_dir(place.path().join(folder).join("trajectory/hard")).unwrap();
        let mut names: Vec<_> = files.map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    };
    let (full, whole) = (frames("full"), frames("whole"));
    assert!(full.len() > 4 && full.len() < whole.len() && whole.len() == 202, "{} of {}", full.len(), whole.len());
    let index = String::from_utf8(read("full", "hard.pvd")).unwrap();
    for name in full.iter().filter(|name| name.ends_with("vtp")) {
        assert!(read("full", &format!("hard/{name}")) == read("whole", &format!("hard/{name}")), "{name}");
    }
    // the index lists only existing files
    assert!(index.split("file=\"hard/").skip(1).all(|rest| full.contains(&rest[..10].to_owned())), "{index}");
    assert_eq!(frames("resumed"), whole);
    for name in whole.iter().map(|name| format!("hard/{name}")).chain(["hard.pvd".to_owned()]) {
        assert!(read("resumed", &name) == read("whole", &name), "{name}");
    }
}

#[test]
fn what_is_asked_for_is_checked() {
    let place = tempfile::tempdir().unwrap();
    for (set, parts) in [
        ("output.every=0 s", ["`output.every` = 0 s", "greater than 0 s"]),
        ("output.every=1 mm", ["output.every", "time"]),
        ("output.formats=\"vtp\"", ["formats", "format"]),
        ("output.format=\"png\"", ["png", "vtp"]),
    ] {
        let (code, told) = diptych(place.path(), &["run", "case.toml", "--set", set, "--out", "out"]);
        assert!(code == 2 && parts.iter().all(|part| told.contains(part)), "{set}: {code} {told}");
        assert!(!place.path().join("out").exists());
    }
    let (code, told) = diptych(place.path(), &["run", "case.toml", "--set", "output.format=xyz", "--out", "out"]);
    assert!(code == 0 && told.contains("is not used"), "{told}");
}

/// A run that is stopped, stored and resumed writes the files of an uninterrupted run.
#[test]
fn a_run_that_goes_on_goes_on_with_its_frames() {
    let crowd = crowd(Model::Soft, SoftStepping::Local);
    let schedule = Schedule::new(&crowd);
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    watched(&crowd, &Folder::create(whole.path(), true).unwrap(), BOTH);
    let folder = Folder::create(parts.path(), true).unwrap();
    let mut left = 0;
    let pause = std::thread::scope(|scope| {
        let mut trajectory = Trajectory::new(scope, &folder, "some", BOTH);
        let mut simulation = Simulation::new(&crowd, initial_state(&crowd).unwrap());
        let mut course = RunLoop::new(&schedule, 1);
        let mut leave = || {
            left += 1;
            left == 97
        };
        assert!(!course.run(&mut simulation, &mut [&mut trajectory], &mut leave).unwrap());
        let pause = course.store(&simulation, &[&mut trajectory]).unwrap();
        // all frames up to the stored state are written, even if the program ends at this point
        assert!(parts.path().join("trajectory/some/000009.vtp").exists());
        pause
    });
    std::thread::scope(|scope| {
        let mut trajectory = Trajectory::new(scope, &folder, "some", BOTH);
        let (mut simulation, mut course) = pause.resume(&crowd, &mut [&mut trajectory]).unwrap();
        assert!(course.run(&mut simulation, &mut [&mut trajectory], &mut || false).unwrap());
        trajectory.end(&simulation);
        trajectory.written().unwrap();
    });
    let read = |folder: &Path, name: &str| std::fs::read(folder.join("trajectory").join(name)).unwrap();
    let frames = (0..22).flat_map(|number| [format!("some/{number:06}.vtp"), format!("some/{number:06}.xyz")]);
    for name in frames.chain(["some.pvd".to_owned(), "some-walls.vtp".to_owned()]) {
        assert!(read(whole.path(), &name) == read(parts.path(), &name), "{name}");
    }
}
