//! Servo walls (which move to keep the pressure on them): equilibrium, relaxation and fast motion of one sphere
//! against other solutions. Also the ledger, a run that is stopped and continued, a pressed crowd, and messages.

use crate::support::*;
use diptych::Experiment;
use diptych::experiment::Model;
use diptych::placement::initial_state;
use diptych::predict::EngineChoice;
use diptych::schedule::{Schedule, impedance};
use diptych::simulation::Simulation;
use diptych::study::plan_of;
use std::f64::consts::PI;

/// One sphere of 1 mm on a floor, and a servo plate (which keeps a pressure) 20 µm above it. Spheres and walls have
/// one stiffness.
const ONE: &str = r#"
[domain]
size = ["2 mm", "4 mm", "2 mm"]
periodic = ["x", "z"]
[[particles]]
diameter = "1 mm"
density = "2500 kg/m^3"
at = [{ position = ["1 mm", "0.5 mm", "1 mm"] }]
[[walls]]
plane = { point = ["0 mm", "0 mm", "0 mm"], normal = [0, 1, 0] }
restitution = 0.5
[[walls]]
plane = { point = ["0 mm", "1.02 mm", "0 mm"], normal = [0, -1, 0] }
restitution = 0.5
motion.servo = { pressure = "1 kPa", largest_speed = "50 mm/s" }
[contact]
restitution = 0.5
[soft.linear_spring_dashpot]
stiffness = "1000 N/m"
[run]
duration = "20 ms"
"#;

fn started(text: &str, model: Model, sets: &[&str]) -> (Experiment, Simulation) {
    let experiment = case(text, model, sets).unwrap();
    let start = initial_state(&experiment).unwrap();
    let simulation = Simulation::new(&experiment, start);
    (experiment, simulation)
}

#[test]
fn a_sphere_between_floor_and_plate_comes_to_the_overlap_of_the_pressure() {
    for model in [Model::Soft, Model::Hybrid] {
        let (_, mut simulation) = started(ONE, model, &["soft.steps_per_contact=200"]);
        simulation.run_until(20e-3).unwrap();
        // the force p A = 4 mN makes an overlap of 4 µm at both contacts, after the gap of 20 µm
        let state = simulation.servo_states()[0];
        close("displacement", state.displacement, 20e-6 + 2.0 * 4e-6, 1e-9);
        close("pressure", state.pressure, 1e3, 1e-5);
        assert!(state.speed.abs() < 1e-9, "{state:?}");
        assert_eq!(simulation.contacts().len(), 2);
        // the work of the plate is in the springs or lost in dashpots
        let ledger = &simulation.record.ledger;
        let explained = ledger.wall_work - ledger.dissipated();
        let unexplained = (simulation.energy() - explained) / ledger.wall_work;
        // the loss is computed as if each contact were alone: an error of first order, 4 % at 20 steps per contact
        assert!(unexplained.abs() < 0.01, "{unexplained}");
        assert!(ledger.wall_work > 2.0 * 0.5 * 1e3 * (4e-6_f64).powi(2));
    }
}

#[test]
fn the_pressure_relaxes_in_the_time_of_damping_over_stiffness() {
    // a plate that touches the sphere without a gap, so damped that the sphere is always in equilibrium: the two springs
    // of k in a row have k/2, and the time is A c/(k/2) = 4 ms
    let close_by = ONE.replace("1.02 mm", "1 mm");
    let sets = [r#"walls[1].motion.servo.damping="500 kPa s/m""#, r#"walls[1].motion.servo.area="4 mm^2""#];
    let (_, mut simulation) = started(&close_by, Model::Soft, &sets);
    simulation.run_until(4e-3).unwrap();
    let reached = simulation.servo_states()[0].pressure / 1e3;
    // the inertia of the sphere delays it by some of its contact time, 0.1 ms of 4 ms
    close("pressure", reached, 1.0 - (-1.0_f64).exp(), 0.02);
}

/// Distances [m] of a plate that presses a sphere of `mass` [kg] on a floor, at the ends of windows (pieces) of
/// `window` [s]. Both bodies are integrated independently of the library, in small steps. Both contacts are a spring
/// of 1000 N/m with the dashpot of the restitution 0.5.
fn pressed_sphere(mass: f64, damping: f64, window: f64, windows: usize) -> Vec<f64> {
    const STEPS: u32 = 200;
    let (stiffness, area) = (1e3, 4e-6);
    let log = 0.5_f64.ln();
    let dashpot = -2.0 * log * (stiffness * mass).sqrt() / PI.hypot(log);
    let force = |overlap: f64, rate: f64| if overlap > 0.0 { stiffness * overlap + dashpot * rate } else { 0.0 };
    // the sphere has sunk by x into the floor; the plate has come down by y, and begins 20 µm above the sphere
    let (mut x, mut speed, mut y, mut plate) = (0.0, 0.0, 0.0, 0.0_f64);
    let mut places = Vec::new();
    for _ in 0..windows {
        let step = window / f64::from(STEPS);
        for _ in 0..STEPS {
            let push = |x: f64, v: f64, y: f64| (force(y - 20e-6 - x, plate - v) - force(x, v)) / mass;
            // the midpoint rule: its error is far below that of the windows
            let (half_x, half_v) = (x + 0.5 * step * speed, speed + 0.5 * step * push(x, speed, y));
            let middle = push(half_x, half_v, y + 0.5 * step * plate);
            (x, speed, y) = (x + step * half_v, speed + step * middle, y + step * plate);
        }
        let pressure = force(y - 20e-6 - x, plate - speed) / area;
        plate = ((1e3 - pressure) / damping).clamp(-50e-3, 50e-3);
        places.push(y);
    }
    places
}

#[test]
fn a_plate_that_comes_down_fast_moves_as_an_independent_solution_says() {
    let (experiment, mut simulation) = started(ONE, Model::Soft, &["soft.steps_per_contact=200"]);
    let window = Schedule::new(&experiment).window;
    let mass = 2500.0 * PI / 6.0 * 1e-9;
    // the touch is after 0.4 ms, and the contact time 0.1 ms: all of the first swings, in which dashpots give a third of the force
    let count = (1e-3 / window) as usize;
    let expected = pressed_sphere(mass, impedance(&experiment), window, count);
    for (k, expected) in expected.iter().enumerate() {
        simulation.run(1, window).unwrap();
        let reached = simulation.servo_states()[0].displacement;
        assert!((reached - expected).abs() < 2e-9, "window {k}: {reached:e} and {expected:e}");
    }
}

#[test]
fn a_sphere_thrown_at_the_plate_presses_on_it_in_both_models() {
    // a single impact far from the floor: hybrid spheres replace it by an impulse at other walls, which presses at no instant
    let thrown = ONE
        .replace(
            "position = [\"1 mm\", \"0.5 mm\", \"1 mm\"]",
            "velocity = [\"0 m/s\", \"0.1 m/s\", \"0 m/s\"], position = [\"1 mm\", \"1.5 mm\", \"1 mm\"]",
        )
        .replace("\"1.02 mm\"", "\"2.02 mm\"")
        .replace("largest_speed = \"50 mm/s\"", "largest_speed = \"1 um/s\"");
    let [soft, hybrid] = [Model::Soft, Model::Hybrid].map(|model| {
        let (_, mut simulation) = started(&thrown, model, &["soft.steps_per_contact=200"]);
        // one long window from 0.2 ms before the touch to the middle of the contact, which lasts 0.12 ms
        simulation.run(1, 0.25e-3).unwrap();
        simulation.servo_states()[0].pressure
    });
    // the largest elastic pressure is of the order of u sqrt(k m)/A = 0.9 kPa
    assert!((300.0..1500.0).contains(&soft), "{soft}");
    close("pressure, hybrid over soft", hybrid / soft, 1.0, 1e-6);
}

#[test]
fn damping_and_windows_follow_from_the_contact_time() {
    let (experiment, _) = started(ONE, Model::Soft, &[]);
    // a linear spring with a dashpot turns at ω = sqrt(k/m) π/sqrt(π² + ln² e), so that t_c = π/ω
    let mass = 2500.0 * PI / 6.0 * 1e-9;
    let frequency = (1e3 / mass).sqrt() * PI / PI.hypot(0.5_f64.ln());
    close("impedance over m ω/d²", impedance(&experiment) / (mass * frequency / 1e-6), 1.0, 1e-6);
    // a window is a tenth of a contact, h ω = π/10, less what makes the run a whole number of windows
    let share = |sets: &[&str]| Schedule::new(&started(ONE, Model::Soft, sets).0).window * frequency;
    let most = PI / 10.0;
    assert!((0.94 * most..=most).contains(&share(&[])), "{}", share(&[]));
    // with less damping it corrects a third of the pressure, h K/(c d²) = 1/3
    let tenth = format!("walls[1].motion.servo.damping=\"{} Pa s/m\"", 0.1 * impedance(&experiment));
    assert!((0.03..=0.1 / 3.0).contains(&share(&[&tenth])), "{}", share(&[&tenth]));
    // no window is longer than a tenth of a contact, however large the damping is, nor because the case asks for it
    let heavy = share(&[r#"walls[1].motion.servo.damping="1 MPa s/m""#]);
    assert!((0.94 * most..=most).contains(&heavy), "{heavy}");
    assert!(share(&[r#"run.window="1 ms""#]) <= most);
}

/// Dense group of 200 spheres between a floor and a servo plate (which moves to keep its pressure), periodic along x
/// and z.
const CROWD: &str = r#"
[domain]
size = ["5 mm", "16 mm", "5 mm"]
periodic = ["x", "z"]
[[particles]]
diameter = "1 mm"
density = "2500 kg/m^3"
count = 200
velocity_fluctuation = "10 mm/s"
[[walls]]
plane = { point = ["0 mm", "0 mm", "0 mm"], normal = [0, 1, 0] }
restitution = 0.5
[[walls]]
plane = { point = ["0 mm", "14 mm", "0 mm"], normal = [0, -1, 0] }
restitution = 0.5
motion.servo = { pressure = "1 kPa", largest_speed = "100 mm/s" }
[contact]
restitution = 0.5
friction = 0.3
[soft.linear_spring_dashpot]
stiffness = "500 N/m"
[run]
duration = "400 ms"
"#;

#[test]
fn a_pressed_crowd_carries_the_pressure_of_the_plate_to_the_floor() {
    let (experiment, mut simulation) = started(CROWD, Model::Soft, &[]);
    simulation.run_until(380e-3).unwrap();
    let before = simulation.record.ledger.clone();
    simulation.run_until(400e-3).unwrap();
    let state = simulation.servo_states()[0];
    // the plate has come down on a packing between loose and close random packing
    let volume = 25e-6 * (14e-3 - state.displacement);
    let fraction = 200.0 * PI / 6.0 * 1e-9 / volume;
    assert!((0.55..0.64).contains(&fraction), "{fraction}");
    // the plate still follows a creep of the packing: what misses of the pressure is the damping times the speed
    close("missing pressure", 1e3 - state.pressure, impedance(&experiment) * state.speed, 1e-9);
    assert!((900.0..1000.0).contains(&state.pressure), "{state:?}");
    // the packing hardly moves, so that floor and plate carry the same pressure
    let ledger = &simulation.record.ledger;
    let pressed = (ledger.wall_normal_impulse - before.wall_normal_impulse) / (2.0 * 25e-6 * 20e-3);
    close("mean pressure on floor and plate", pressed / state.pressure, 1.0, 0.02);
    let net = (ledger.wall_impulse - before.wall_impulse).y / (25e-6 * 20e-3);
    assert!(net.abs() < 0.02 * state.pressure, "{net}");
}

#[test]
fn a_stopped_run_goes_on_with_the_same_bits() {
    let bits = |simulation: &Simulation| {
        let place = |x: &diptych::Vector3<f64>| [x.x, x.y, x.z].map(f64::to_bits);
        let state = simulation.servo_states()[0];
        (simulation.particles.position.iter().map(place).collect::<Vec<_>>(), state.displacement.to_bits())
    };
    for model in [Model::Soft, Model::Hybrid] {
        let (experiment, mut whole) = started(CROWD, model, &["run.duration=\"60 ms\""]);
        let window = Schedule::new(&experiment).window;
        whole.run((50e-3 / window) as u64, window).unwrap();
        let snapshot = whole.snapshot().unwrap();
        whole.run(500, window).unwrap();
        let mut parts = Simulation::restore(&experiment, snapshot).unwrap();
        parts.run(500, window).unwrap();
        assert_eq!(bits(&whole), bits(&parts), "{model:?}");
        assert!(whole.servo_states()[0].displacement > 1e-3);
    }
}

#[test]
fn a_plan_leaves_out_models_without_lasting_contacts() {
    let (experiment, _) = started(CROWD, Model::Soft, &["run.duration=\"2 ms\""]);
    let planned = plan_of(&experiment, 0.01, true).unwrap();
    let refused = &planned.recommendation.refused;
    assert!(refused.iter().any(|why| why.contains("hard spheres: a servo wall measures")), "{refused:?}");
    let timed: Vec<EngineChoice> = planned.plan.costs.iter().map(|cost| cost.model).collect();
    assert_eq!(timed, [EngineChoice::SoftLocal, EngineChoice::SoftUniform, EngineChoice::Hybrid]);
    assert!(timed.contains(&planned.recommendation.engine.unwrap()));
}

#[test]
fn what_a_servo_wall_cannot_be_is_refused() {
    let refused = |text: &str, model| case(text, model, &[]).unwrap_err();
    for model in [Model::Hard, Model::Dsmc] {
        let why = refused(ONE, model);
        assert!(why.contains("soft or the hybrid"), "{why}");
    }
    let servo = "motion.servo = { pressure = \"1 kPa\", largest_speed = \"50 mm/s\" }";
    for (from, to, words) in [
        (servo, "motion.servo = { pressure = \"1 kPa\" }", "largest_speed"),
        (servo, "motion.servo = { pressure = \"0 Pa\", largest_speed = \"50 mm/s\" }", "out of range"),
        (servo, "motion.servo = { pressure = \"1 mm\", largest_speed = \"50 mm/s\" }", "a pressure"),
        (
            "plane = { point = [\"0 mm\", \"1.02 mm\", \"0 mm\"], normal = [0, -1, 0] }",
            "sphere = { center = [\"1 mm\", \"2.02 mm\", \"1 mm\"], radius = \"0.5 mm\" }",
            "moves only planes",
        ),
    ] {
        let why = refused(&ONE.replace(from, to), Model::Soft);
        assert!(why.contains(words), "{words}: {why}");
    }
    let inclined = ONE.replace("normal = [0, -1, 0]", "normal = [0, -1, 0.1]").replace("[\"x\", \"z\"]", "[]");
    assert!(refused(&inclined, Model::Soft).contains("needs an area"));
}
