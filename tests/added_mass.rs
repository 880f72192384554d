//! Added mass: accelerations, response times, moments of inertia, and the warning of a case that leaves added mass
//! out.

use crate::support::{case, close, diptych, words};
use diptych::experiment::Model;
use diptych::placement::initial_state;
use diptych::predict::flow::flows;
use diptych::simulation::Simulation;

/// Case of a light sphere and a heavy sphere, far apart, in water without drag.
const WATER: &str = r#"
[domain]
size = ["100 mm", "100 mm", "100 mm"]
periodic = ["x", "y", "z"]
[gravity]
acceleration = ["0 m/s^2", "0 m/s^2", "-10 m/s^2"]
[fluid]
density = "1000 kg/m^3"
kinematic_viscosity = "1e-6 m^2/s"
added_mass = true
[fluid.profile.uniform]
velocity = "0 m/s"
[[particles]]
name = "light"
diameter = "1 mm"
density = "100 kg/m^3"
at = [{ position = ["20 mm", "50 mm", "50 mm"] }]
[[particles]]
name = "heavy"
diameter = "1 mm"
density = "2500 kg/m^3"
at = [{ position = ["70 mm", "50 mm", "50 mm"] }]
[contact]
restitution = 0.9
rotation = true
friction = 0.1
[soft.linear_spring_dashpot]
stiffness = "1000 N/m"
[soft.tangential.linear]
tangential_restitution = 0.4
[run]
duration = "0.1 s"
window = "0.1 ms"
"#;

/// A bubble in an ideal fluid rises with the acceleration 2 g (gravity g). A sphere of density ρ_p in a fluid of
/// density ρ_f rises with g (ρ_f - ρ_p)/(ρ_p + ρ_f/2).
#[test]
fn spheres_rise_and_fall_with_their_added_mass() {
    for model in [Model::Soft, Model::Hard, Model::Hybrid] {
        let experiment = case(WATER, model, &[]).unwrap();
        let mut simulation = Simulation::new(&experiment, initial_state(&experiment).unwrap());
        simulation.run(1000, 1e-4).unwrap();
        let state = simulation.state();
        for (velocity, wanted) in state.velocity.iter().zip([10.0 * 900.0 / 600.0, -10.0 * 1500.0 / 3000.0]) {
            // a thousand windows add up to a velocity of 1 m/s, with one rounding each
            close("velocity", velocity.z, wanted * 0.1, 1000.0 * f64::EPSILON);
        }
        // the work on both spheres equals the kinetic energy, including that of the water
        let work = simulation.record.ledger.gravity_work;
        close("work", simulation.particles.kinetic_energy(), work, 1e-12 * work);
        // moments of inertia are those of the spheres alone
        let body = [100.0, 2500.0].map(|density| 0.4 * density * std::f64::consts::PI / 6.0 * 1e-9 * 0.25e-6);
        for (found, wanted) in state.inertia.as_ref().unwrap().iter().zip(body) {
            close("inertia", *found, wanted, 1e-14 * wanted);
        }
    }
    // without added mass, the light sphere would rise with 9 g
    let bare = case(WATER, Model::Hard, &["fluid.added_mass=false"]).unwrap();
    close("without", bare.scene.gravity_of(&bare.scene.species[0]).z, 90.0, 1e-12);
}

/// In Stokes drag a sphere of density ρ_p and diameter d approaches its terminal speed with the response time (ρ_p +
/// ρ_f/2) d²/(18 ρ_f ν), in a fluid of density ρ_f and kinematic viscosity ν. Added mass does not change the terminal
/// speed.
#[test]
fn drag_accelerates_the_added_mass_too() {
    let keys = ["drag.stokes={}", "fluid.kinematic_viscosity=1e-4", "run.duration=5 ms"];
    let (tau, settling) = (3000.0 * 1e-6 / (18.0 * 1000.0 * 1e-4), 1500.0 * 1e-6 * 10.0 / (18.0 * 1000.0 * 1e-4));
    for model in [Model::Soft, Model::Hard] {
        let experiment = case(WATER, model, &keys).unwrap();
        close("prediction", flows(&experiment.scene, &[1, 1])[1].terminal_slip, settling, 1e-6 * settling);
        let mut simulation = Simulation::new(&experiment, initial_state(&experiment).unwrap());
        simulation.run(100, 1e-5).unwrap();
        let wanted = -settling * (1.0 - (-1e-3_f64 / tau).exp());
        // splitting: (h/τ)²/24 of the velocity, with h = 10 µs and τ = 1.7 ms
        close("velocity", simulation.state().velocity[1].z, wanted, 2.0 * (1e-5_f64 / tau).powi(2) / 24.0 * settling);
    }
}

/// Masses and momenta of particles that a start file gives are those of the spheres, without added mass.
#[test]
fn files_give_masses_without_added_mass() {
    let folder = tempfile::tempdir().unwrap();
    let [light, heavy] = [100.0, 2500.0].map(|density| density * std::f64::consts::PI / 6.0 * 1e-9);
    let rows = [(20, light, "light"), (70, heavy, "heavy")]
        .map(|(x, mass, kind)| format!("{kind} 0.0{x} 0.05 0.05 {mass} {} 0 0\n", 2.0 * mass));
    let head = "2\nProperties=species:S:1:pos:R:3:masses:R:1:momenta:R:3 units=\"m s\"\n";
    std::fs::write(folder.path().join("start.xyz"), head.to_owned() + &rows.concat()).unwrap();
    let places = [
        "at = [{ position = [\"20 mm\", \"50 mm\", \"50 mm\"] }]",
        "at = [{ position = [\"70 mm\", \"50 mm\", \"50 mm\"] }]",
    ];
    let text = places.iter().fold(WATER.to_owned(), |text, place| text.replace(place, "file = \"start.xyz\""));
    let path = folder.path().join("case.toml");
    std::fs::write(&path, text).unwrap();
    let (experiment, _) = diptych::case::Case::read(&path, &[]).unwrap().experiment(Some(Model::Hard), None).unwrap();
    for velocity in &initial_state(&experiment).unwrap().velocity {
        close("velocity", velocity.x, 2.0, 1e-15);
    }
}

#[test]
fn added_mass_without_buoyancy_is_refused_and_its_absence_is_warned_of() {
    let why = case(WATER, Model::Hard, &["fluid.buoyancy=false"]).unwrap_err();
    assert!(why.contains("`fluid.added_mass`") && why.contains("needs buoyancy"), "{why}");
    let told = |sets: &[&str]| {
        let mut arguments = vec!["check", "cases/beads-in-air.toml", "--set", "fluid.buoyancy=true"];
        sets.iter().for_each(|set| arguments.extend(["--set", *set]));
        let output = diptych(&arguments).output().unwrap();
        words(&output.stdout) + &words(&output.stderr)
    };
    let water = "fluid.density=998.2";
    assert!(
        told(&[water]).contains("added mass is left out: in this fluid it is 20.0 % of the mass"),
        "{}",
        told(&[water])
    );
    assert!(!told(&[]).contains("added mass"), "air");
    assert!(!told(&[water, "fluid.added_mass=true"]).contains("left out"));
    assert!(!told(&[water, "fluid.added_mass=false"]).contains("left out"));
}
