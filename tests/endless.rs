//! Surfaces of triangles that continue through periodic sides: floors, corrugated walls, and pipes of one period.

use crate::support::{diptych, words};
use diptych::case::Case;
use diptych::outcome::Outcome;
use diptych::placement::initial_state;
use diptych::study::execute;
use diptych::{Particles, Vector3};
use std::fmt::Write;
use std::path::Path;

/// Length of a period [mm].
const PERIOD: f64 = 20.0;

type Triangle = [[f64; 3]; 3];

/// Triangles as STL in text form.
fn stl(triangles: &[Triangle]) -> String {
    let mut text = "solid made\n".to_owned();
    for triangle in triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in triangle {
            writeln!(text, "vertex {x:.6} {y:.6} {z:.6}").unwrap();
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid made\n"
}

/// Floor over the whole period in x and z [mm], made of 8 by 8 squares.
fn floor(height: impl Fn(f64, f64) -> f64) -> Vec<Triangle> {
    let at = |i: u32, k: u32| {
        let [x, z] = [i, k].map(|place| PERIOD * f64::from(place) / 8.0);
        [x, height(x, z), z]
    };
    let square = |i: u32, k: u32| {
        let [a, b, c, d] = [at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)];
        [[a, c, b], [a, d, c]]
    };
    (0..8).flat_map(|i| (0..8).flat_map(|k| square(i, k)).collect::<Vec<_>>()).collect()
}

/// Pipe of one period along z, with 24 flat sides, open at both ends [mm].
fn pipe(radius: f64) -> Vec<Triangle> {
    let at = |side: u32, z: f64| {
        let (sin, cos) = (f64::from(side % 24) * std::f64::consts::TAU / 24.0).sin_cos();
        [0.5 * PERIOD + radius * cos, 0.5 * PERIOD + radius * sin, z]
    };
    let side = |k: u32| {
        let [a, b, c, d] = [at(k, 0.0), at(k + 1, 0.0), at(k + 1, PERIOD), at(k, PERIOD)];
        [[a, b, c], [a, c, d]]
    };
    (0..24).flat_map(side).collect()
}

const WAVY: fn(f64, f64) -> f64 = |x, z| {
    let turn = std::f64::consts::TAU / PERIOD;
    3.0 + 0.8 * (2.0 * turn * x).sin() + 0.5 * (turn * z).cos()
};

/// Case of beads of 2 mm in a box of one period. `wall` is a key of a wall, and `rest` is further text of the case.
fn case(wall: &str, particles: &str, rest: &str) -> String {
    format!(
        "[domain]\nsize = [\"20 mm\", \"20 mm\", \"20 mm\"]\nperiodic = [\"x\", \"z\"]\n\
         [gravity]\nacceleration = [\"0 m/s^2\", \"-9.81 m/s^2\", \"0 m/s^2\"]\n\
         [[particles]]\ndiameter = \"2 mm\"\ndensity = \"2500 kg/m^3\"\n{particles}\n\
         [[walls]]\n{wall}\nrestitution = 0.5\nfriction = 0\n\
         [[walls]]\nplane = {{ point = [\"0 m\", \"20 mm\", \"0 m\"], normal = [0, -1, 0] }}\nrestitution = 0.5\n\
         [contact]\nrestitution = 0.5\nfriction = 0\n[soft.linear_spring_dashpot]\nstiffness = \"5 kN/m\"\n\
         [run]\nduration = \"0.1 s\"\n{rest}\n"
    )
}

const MESH: &str = "mesh = { file = \"made.stl\", unit = \"1 mm\" }";

/// Runs the case `text` with a file of the `triangles` in its folder.
fn run(triangles: &[Triangle], text: &str, sets: &[&str]) -> (Outcome, Particles) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("made.stl"), stl(triangles)).unwrap();
    let path = folder.path().join("case.toml");
    std::fs::write(&path, text).unwrap();
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let (experiment, _) = Case::read(&path, &sets).unwrap().experiment(None, None).unwrap();
    execute(&experiment, initial_state(&experiment).unwrap(), &mut [])
}

/// Bead at a position [mm] that moves at 0.5 m/s along x.
fn sliding(x: f64, y: f64) -> String {
    format!(
        "at = [{{ position = [\"{x} mm\", \"{y} mm\", \"10 mm\"], velocity = [\"0.5 m/s\", \"0 m/s\", \"0.2 m/s\"] }}]"
    )
}

#[test]
fn a_bead_feels_nothing_of_the_side_on_a_flat_floor() {
    let flat = floor(|_, _| 2.0);
    for model in ["soft", "hard", "hybrid"] {
        let model = format!("run.model={model}");
        // the bead falls by 0.1 mm and bounces to rest, or without end if it is elastic, while it slides through both
        // sides
        let text = case(MESH, &sliding(1.0, 3.1), "");
        let sets: &[&str] = if model.ends_with("hard") {
            &[&model, "contact.restitution=1", "walls[0].restitution=1"]
        } else {
            &[&model]
        };
        let (outcome, mesh) = run(&flat, &text, sets);
        assert!(outcome.failure.is_none(), "{model}: {:?}", outcome.failure);
        let plane =
            case("plane = { point = [\"0 m\", \"2 mm\", \"0 m\"], normal = [0, 1, 0] }", &sliding(1.0, 3.1), "");
        let (_, plane) = run(&flat, &plane, sets);
        let apart = |of: fn(&Particles) -> Vector3<f64>| (of(&mesh) - of(&plane)).norm();
        assert!(apart(|all| all.velocity[0]) < 1e-9, "{model}: {:?} {:?}", mesh.velocity, plane.velocity);
        assert!(apart(|all| all.position[0]) < 1e-10, "{model}: {:?} {:?}", mesh.position, plane.position);
        assert!((mesh.velocity[0].x - 0.5).abs() < 1e-12, "{model}");
    }
}

#[test]
fn a_path_over_the_side_is_that_within_the_box() {
    // shifted by half a period, the wavy floor is the same along x
    let wavy = floor(WAVY);
    for model in ["run.model=soft", "run.model=hybrid"] {
        let at = |x: f64| {
            run(&wavy, &case(MESH, &sliding(x, 6.0), "[statistics]\nslices = 4"), &[model, "run.duration=30 ms"]).1
        };
        let (within, over) = (at(2.0), at(12.0));
        let apart = (within.position[0] - over.position[0]).map(|d| d - 0.01 * (d / 0.01).round());
        assert!(apart.norm() < 1e-8, "{model}: {:?} {:?}", within.position, over.position);
        assert!(
            (within.velocity[0] - over.velocity[0]).norm() < 1e-6,
            "{model}: {:?} {:?}",
            within.velocity,
            over.velocity
        );
    }
}

/// Roof with its valley at the periodic side. A bead in the valley lies on the flanks of two periods. Each flank is a
/// periodic image for the other one.
#[test]
fn a_bead_rests_in_a_valley_at_the_side() {
    let slope = 0.6;
    let roof = floor(|x, _| 2.0 + slope * (0.5 * PERIOD - (x - 0.5 * PERIOD).abs()));
    // each flank carries m g/(2 cos α) with 20 N/m; cos α = 1/sqrt(1 + slope²); lengths are in mm
    let lean = (1.0 + slope * slope).sqrt();
    let weight = 2500.0 * std::f64::consts::PI / 6.0 * 8e-9 * 9.81;
    let rests = 2.0 + lean - 0.5e3 * weight * lean * lean / 20.0;
    let place = |x: f64| format!("at = [{{ position = [\"{x} mm\", \"{} mm\", \"10 mm\"] }}]", 2.0 + lean);
    for model in ["run.model=soft", "run.model=hybrid"] {
        for x in [0.0, 19.9999, 0.0001] {
            let sets = [model, "soft.linear_spring_dashpot.stiffness=20 N/m", "run.duration=0.2 s"];
            let (outcome, all) = run(&roof, &case(MESH, &place(x), ""), &sets);
            assert!(outcome.failure.is_none(), "{model}: {:?}", outcome.failure);
            let at = all.position[0] * 1e3;
            let aside = at.x - PERIOD * (at.x / PERIOD).round();
            // on one flank alone, the bead would lie 3.5 µm deeper
            assert!(aside.abs() < 2e-4 && (at.y - rests).abs() < 2e-4, "{model} from {x} mm: {at:?}, not {rests}");
        }
    }
}

#[test]
fn beads_stay_above_a_floor_and_in_a_pipe_without_end() {
    let beads = "count = 100\nvelocity_fluctuation = \"0.2 m/s\"\nin = { box = { center = [\"10 mm\", \"12 mm\", \"10 mm\"], half_extents = [\"10 mm\", \"7 mm\", \"10 mm\"] } }";
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (outcome, all) = pool.install(|| run(&floor(WAVY), &case(MESH, beads, ""), &["run.model=soft"]));
        assert!(outcome.failure.is_none(), "{:?}", outcome.failure);
        for at in &all.position {
            let [x, z] = [at.x, at.z].map(|place| 1e3 * place.rem_euclid(0.02));
            assert!(1e3 * at.y > WAVY(x, z), "{at:?}");
        }
        let (again, _) = run(&floor(WAVY), &case(MESH, beads, ""), &["run.model=soft"]);
        assert_eq!(again.final_state_hash, outcome.final_state_hash);
    }
    let inside = "count = 60\nvelocity_mean = [\"0 m/s\", \"0 m/s\", \"1 m/s\"]\nvelocity_fluctuation = \"0.3 m/s\"\nin = { cylinder = { center = [\"10 mm\", \"10 mm\", \"10 mm\"], axis = \"z\", radius = \"5 mm\", half_height = \"10 mm\" } }";
    for model in ["run.model=soft", "run.model=hard"] {
        let sets = [model, "contact.restitution=0.9", "walls[0].restitution=0.9", "gravity.acceleration[1]=0 m/s^2"];
        let (outcome, all) = run(&pipe(7.0), &case(MESH, inside, ""), &sets);
        assert!(outcome.failure.is_none(), "{model}: {:?}", outcome.failure);
        let far = all.position.iter().map(|at| (at.x - 0.01).hypot(at.y - 0.01)).fold(0.0, f64::max);
        assert!(far < 6.0e-3 * 1.001 && outcome.record.walls.count > 50, "{model}: {far}");
    }
}

#[test]
fn edges_that_do_not_match_at_the_side_are_refused_with_the_step() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("made.stl"), stl(&floor(|x, _| 2.0 + 0.01 * x))).unwrap();
    let path = folder.path().join("case.toml");
    std::fs::write(&path, case(MESH, &sliding(1.0, 5.0), "model = \"soft\"")).unwrap();
    let output = diptych(&["check", path.to_str().unwrap()]).output().unwrap();
    let told = words(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("along x") && told.contains("the largest step is 2.0000e-4 m"), "{told}");
    assert!(!Path::new("out").join("case-check").exists());
}
