//! Cases with walls that move: values, messages, warnings, and runs in each model.

use super::*;
use diptych::experiment::{Model, Spheres};

const CASE: &str = r#"
[domain]
size = ["10 mm", "20 mm", "10 mm"]
periodic = ["x", "z"]
[gravity]
acceleration = ["0 m/s^2", "-9.81 m/s^2", "0 m/s^2"]
[[particles]]
diameter = "1 mm"
density = "2500 kg/m^3"
count = 20
[[walls]]
plane = { point = ["0 m", "2 mm", "0 m"], normal = [0, 1, 0] }
restitution = 0.9
motion.vibration = { amplitude = [0, "1 mm", 0], frequency = "20 Hz", phase = "90 deg" }
[[walls]]
plane = { point = ["0 m", "20 mm", "0 m"], normal = [0, -1, 0] }
restitution = 0.9
[contact]
restitution = 0.9
[soft.linear_spring_dashpot]
stiffness = "3000 N/m"
[run]
duration = "0.1 s"
"#;

/// Line of [`CASE`] that gives the motion of the plate.
const MOTION: &str = r#"motion.vibration = { amplitude = [0, "1 mm", 0], frequency = "20 Hz", phase = "90 deg" }"#;

#[test]
fn the_case_gives_the_motion_and_refuses_what_cannot_be() {
    let read = |sets: &[&str]| case(CASE, Model::Hard, sets);
    let shaken = read(&[]).unwrap();
    // at time 0 and the phase of 90 degrees the plate is at its highest place
    let plate = &shaken.scene.walls[0];
    assert!((plate.geometry.plane().unwrap().point.y - 3e-3).abs() < 1e-18);
    assert!((plate.largest_speed() - TAU * 20.0 * 1e-3).abs() < 1e-15);
    let moved = |motion: &str| CASE.replace(MOTION, &format!("motion = {motion}"));
    let refused = |motion: &str, sets: &[&str]| case(&moved(motion), Model::Hard, sets).unwrap_err();
    for (motion, words) in [
        (r#"{ vibration = { amplitude = [0, 0, 0], frequency = "20 Hz" } }"#, "moves nothing"),
        (r#"{ vibration = { amplitude = [0, "1 mm", 0], frequency = "0 Hz" } }"#, "out of range"),
        (r#"{ vibration = { amplitude = [0, "1 mm", 0] } }"#, "frequency"),
        (r#"{ translation = [0, 0, 0] }"#, "moves nothing"),
        (r#"{ translation = [0, "1 mm", 0] }"#, "a velocity belongs here"),
        (r#"{ path = [{ time = "0 s", displacement = [0, 0, 0] }] }"#, "fewer than two times"),
        (
            r#"{ path = [{ time = "1 s", displacement = [0, 0, 0] }, { time = "1 s", displacement = [0, 1, 0] }] }"#,
            "not later than the time before it",
        ),
        (r#"{ turning = { rate = "1 rad/s", axis = [0, 1, 0], center = [0, 0, 0] } }"#, "periodic images"),
        ("{ }", "vibration"),
    ] {
        let why = refused(motion, &[]);
        assert!(why.contains(words), "{motion}: {why}");
    }
    let both = r#"{ translation = [0, "1 mm/s", 0], vibration = { amplitude = [0, "1 mm", 0], frequency = "1 Hz" } }"#;
    assert!(refused(both, &[]).contains("translation"));
    let endless = r#"{ turning = { rate = "1 rad/s", axis = [0, 0, 1], center = [0, 0, 0] } }"#;
    assert!(refused(endless, &["domain.periodic=[]"]).contains("without ends"));
    let pipe = r#"{ turning = { rate = "1 rad/s", axis = [0, 0, 1], center = ["5 mm", "5 mm", 0] } }"#;
    let text = moved(pipe).replace(
        "plane = ",
        r#"cylinder = { center = ["5 mm", "5 mm", 0], axis = "z", radius = "5 mm", inside = true } #"#,
    );
    assert!(case(&text, Model::Hard, &["domain.periodic=[\"z\"]"]).unwrap_err().contains("without ends"));
    assert!(case(CASE, Model::Dsmc, &[]).unwrap_err().contains("not for collisions by chance"));
    let rough = read(&[r#"walls[0].roughness.deviation="5 deg""#]).unwrap_err();
    assert!(rough.contains("does not move"), "{rough}");
}

#[test]
fn a_wall_that_leaves_the_box_or_crushes_spheres_is_told() {
    let warnings = |motion: &str, other: &[String]| {
        let text = CASE.replace(MOTION, motion);
        let case = diptych::case::Case::from_text("tests/case.toml".as_ref(), text.into(), other).unwrap();
        let (_, warnings) = case.experiment(Some(Model::Hard), None).unwrap();
        warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    };
    let none = warnings(MOTION, &[]);
    assert!(!none.contains("out of the box") && !none.contains("does not fit"), "{none}");
    let low = warnings(&MOTION.replace("1 mm", "2.1 mm"), &[]);
    assert!(low.contains("out of the box, to y = -1.0000e-4 m"), "{low}");
    let near = warnings(r#"motion = { translation = [0, "0.175 m/s", 0] }"#, &[]);
    assert!(near.contains("5.0000e-4 m from walls[1]"), "{near}");
    // two walls with one motion keep their distance; with other phases they may meet
    let wide = MOTION.replace("1 mm", "9 mm");
    let (_, motion) = wide.split_once(" = ").unwrap();
    let both = warnings(&wide, &[format!("walls[1].motion.vibration={motion}")]);
    assert!(!both.contains("does not fit"), "{both}");
    let apart = warnings(&wide, &[format!("walls[1].motion.vibration={}", motion.replace("90", "91"))]);
    assert!(apart.contains("does not fit"), "{apart}");
}

#[test]
fn a_case_runs_in_each_model() {
    let sets = ["walls[0].friction=0.2", "run.duration=\"20 ms\"", "particles[0].velocity_fluctuation=\"0.1 m/s\""];
    for model in [Model::Hard, Model::Soft, Model::Hybrid] {
        let experiment = case(CASE, model, &sets).unwrap();
        assert!(matches!(
            (model, &experiment.run.spheres),
            (Model::Hard, Spheres::Hard) | (Model::Soft, Spheres::Soft(_)) | (Model::Hybrid, Spheres::Hybrid(_))
        ));
        let start = diptych::placement::initial_state(&experiment).unwrap();
        // the start keeps off the plate where it is at time 0
        assert!(start.position.iter().all(|x| x.y > 3.5e-3 - 1e-12));
        let mut simulation = Simulation::new(&experiment, start);
        simulation.run(50, 1e-3).unwrap();
        assert!(simulation.record.walls.count > 5, "{model:?}");
    }
}
