//! Lift of spheres by shear and by spin, and the torque of the gas, against independently evaluated formulas.

use crate::support::{case, close, shared};
use diptych::engine::distributed::Distributed;
use diptych::engine::hard::Hard;
use diptych::experiment::{Experiment, Model};
use diptych::placement::initial_state;
use diptych::simulation::Simulation;
use nalgebra::Vector3;

/// Case of a sphere of 1 mm and 1000 kg/m³ without drag, in a gas with the uniform shear 100 1/s or at rest.
const SCENE: &str = r#"
[domain]
size = ["100 mm", "100 mm", "100 mm"]
periodic = ["x", "z"]
[fluid]
density = "1.2 kg/m^3"
kinematic_viscosity = "1.5e-5 m^2/s"
buoyancy = false
[fluid.lift]
shear = true
spin = true
[fluid.profile.table]
file = "inputs/shear.csv"
[[particles]]
name = "bead"
diameter = "1 mm"
density = "1000 kg/m^3"
at = [{ position = ["50 mm", "50 mm", "50 mm"] }]
[[walls]]
plane = { point = ["0 m", "0 m", "0 m"], normal = [0, 1, 0] }
restitution = 0.9
[[walls]]
plane = { point = ["0 m", "100 mm", "0 m"], normal = [0, -1, 0] }
restitution = 0.9
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

/// [kg] mass of the sphere.
const MASS: f64 = 1000.0 * std::f64::consts::PI / 6.0 * 1e-9;

/// Gas velocity [m/s] at the sphere: 100 1/s times 50 mm.
const GAS: f64 = 5.0;

fn scene(model: Model, sets: &[&str]) -> Experiment {
    case(SCENE, model, sets).unwrap()
}

/// Simulation after `windows` windows of `window` [s], from a velocity [m/s] and a spin [rad/s] of the sphere.
fn after(experiment: &Experiment, velocity: [f64; 3], spin: [f64; 3], (windows, window): (u64, f64)) -> Simulation {
    let mut start = initial_state(experiment).unwrap();
    start.velocity[0] = velocity.into();
    start.spin = Some(vec![spin.into()]);
    let mut simulation = Simulation::new(experiment, start);
    simulation.run(windows, window).unwrap();
    simulation
}

const MODELS: [Model; 3] = [Model::Soft, Model::Hard, Model::Hybrid];

/// Shear lift [N] at slips w of 0.3 m/s and 1 m/s (Re = 20 and 67): 1.615 ρ ν d w √Re_G times Mei's factor. Here ρ and
/// ν are density and kinematic viscosity of the gas, d the diameter, and Re_G the Reynolds number of the shear.
#[test]
fn sheared_gas_pushes_a_sphere_that_leads_towards_slower_gas() {
    for (slip, force) in [(0.3, 5.681594588646967e-9), (1.0, 7.180754215763133e-9)] {
        for model in MODELS {
            // spheres that rotate with the gas have no other lift; the sphere is faster than the gas by the slip
            let experiment = scene(model, &["fluid.lift.spin=false"]);
            let end = after(&experiment, [0.0, 0.0, GAS + slip], [50.0, 0.0, 0.0], (1, 1e-6));
            // the rotation of the velocity is exact; the position of the sphere, and with it the slip, changes by 1e-12
            // in this time
            let found = end.particles.velocity[0].y * MASS / 1e-6;
            close("force", found, -force, 3e-4 * force); // SAFFMAN has five digits: 4.1126 π/8 = 1.61501
        }
    }
}

/// Spin lift [N] on a sphere that spins at 200 rad/s about x, by a formula in the form of a drag law.
#[test]
fn a_spinning_sphere_turns_to_the_side() {
    for (slip, force) in [(0.3, 2.5285055516971527e-8), (1.0, 1.4507770255692546e-7)] {
        for model in MODELS {
            let experiment = scene(model, &["fluid.lift.shear=false", "fluid.profile={ uniform = { velocity = 0 } }"]);
            let end = after(&experiment, [0.0, 0.0, slip], [200.0, 0.0, 0.0], (1, 1e-6));
            // spin × velocity = x × z = -y; within half a kick, the spin falls by 1e-6 of its value
            let found = end.particles.velocity[0].y * MASS / 1e-6;
            close("force", found, -force, 1e-5 * force);
            close("speed", end.particles.velocity[0].norm(), slip, 1e-15);
        }
    }
}

/// A spin of 2000 rad/s (rotational Reynolds number 133) decays to the spin of the gas, through both ranges of the law
/// of torque. The expected values were integrated by another program. The ledger contains the energy given to the gas.
#[test]
fn the_gas_takes_the_spin() {
    for windows in [1, 400] {
        let experiment = scene(Model::Hard, &["fluid.profile={ uniform = { velocity = 0 } }"]);
        for (time, wanted) in [(0.5, 1011.0108177872851), (2.0, 189.7843651704322)] {
            let end = after(&experiment, [0.0; 3], [0.0, 2000.0, 0.0], (windows, time / windows as f64));
            close("spin", end.particles.spin_of(0).y, wanted, 1e-7 * wanted);
            let start = 0.5 * 0.4 * MASS * 0.25e-6 * 2000.0_f64.powi(2);
            let left = end.particles.rotational_energy();
            close("work", end.record.ledger.drag_work, left - start, 1e-10 * start);
        }
    }
    // in sheared gas, a sphere approaches a spin of half the vorticity, here along x, at the rate of creeping flow
    let end = after(&scene(Model::Soft, &[]), [0.0, 0.0, GAS], [0.0; 3], (100, 0.05));
    let rate = std::f64::consts::PI * 1.2 * 1.5e-5 * 1e-9 / (0.4 * MASS * 0.25e-6);
    close("spin of the gas", end.particles.spin_of(0).x, 50.0 * (1.0 - (-5.0 * rate).exp()), 1e-9);
}

/// With halved windows, the error of the path is a quarter: the splitting is of second order.
#[test]
fn lift_is_of_second_order_in_the_window() {
    let experiment = scene(Model::Hard, &["drag.stokes={}"]);
    let place = |windows: u64| {
        after(&experiment, [0.1, 0.05, GAS + 1.0], [300.0, -100.0, 50.0], (windows, 0.05 / windows as f64))
            .state()
            .position[0]
    };
    let exact = place(2560);
    let errors = [20, 40, 80].map(|windows| (place(windows) - exact).norm());
    for pair in errors.windows(2) {
        let ratio = pair[0] / pair[1];
        assert!((3.6..4.4).contains(&ratio), "{errors:?}");
    }
}

/// A bead that a smooth elastic wall reflects moves as the mirror image of a bead that flies on, with lift and drag in
/// an eddy: the wall reflects the eddy, too. The spin along the normal is that of the mirror image.
#[test]
fn a_reflected_bead_sees_the_reflected_eddy() {
    let eddy =
        "fluid.turbulence={ kinetic_energy = \"0.375 m^2/s^2\", dissipation_rate = \"1e-4 m^2/s^3\", eddy = {} }";
    let gas = ["fluid.profile={ uniform = { velocity = 0 } }", "fluid.lift.shear=false", "drag.stokes={}", eddy];
    let velocity = |wall: &str| {
        let wall = format!("walls[0].plane.point[1]={wall}");
        let sets = [&gas[..], &["walls[0].restitution=1", "walls[0].friction=0", &wall]].concat();
        // 0.2 mm in the window; the gap to the near wall is 0.1 mm
        after(&scene(Model::Hard, &sets), [0.3, -2.0, 0.1], [0.0, 2000.0, 0.0], (1, 1e-4)).particles.velocity[0]
    };
    let (through, back) = (velocity("0 mm"), velocity("49.4 mm"));
    assert!(through.y < 0.0 && back.y > 0.0);
    close("reflected", (back - Vector3::new(through.x, -through.y, through.z)).norm(), 0.0, 1e-14);
}

/// A dense gas of spinning beads has equal bits for any number of threads and processes, and its ledger (balance of
/// energy and momentum) closes.
#[test]
fn lift_gives_the_same_bits_on_threads_and_processes_and_closes_the_ledger() {
    let experiment = scene(
        Model::Hard,
        &[
            "particles[0]={ name = 'bead', diameter = '1 mm', density = '1000 kg/m^3', count = 9000, velocity_fluctuation = '1 m/s', spin_fluctuation = '100 rad/s' }",
            "drag.schiller_naumann={}",
        ],
    );
    let start = initial_state(&experiment).unwrap();
    let of = (experiment.scene.clone(), start.clone());
    let engine = || Box::new(Hard::new()) as Box<dyn Distributed>;
    let on = |size| {
        shared(size, &of, &engine, (1e-3, 10), |end| {
            (end.fingerprint(), end.record.ledger.to_array(), end.energy(), end.mean_velocity() * end.total_mass())
        })
    };
    let alone = on(1);
    assert_eq!(on(3), alone);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(|| on(1)), alone, "{threads} threads");
    }
    let mut simulation = Simulation::new(&experiment, start.clone());
    simulation.run(10, 1e-4).unwrap();
    let before = start.kinetic_energy() + start.rotational_energy();
    let residual = simulation.record.ledger.residual(before, simulation.energy());
    assert!(residual.abs() < 1e-12 * before, "{residual:e} of {before:e}");
    let given: Vector3<f64> = simulation.record.ledger.drag_impulse + simulation.record.ledger.wall_impulse;
    let gained = simulation.particles.momentum() - start.momentum();
    assert!((gained - given).norm() < 1e-12 * given.norm(), "{gained:?} {given:?}");
}

#[test]
fn lift_by_spin_needs_spheres_that_rotate() {
    let sets = ["contact.rotation=false", "soft.tangential={ coulomb = {} }"];
    let why = case(SCENE, Model::Hard, &sets).map(|_| ()).unwrap_err();
    assert!(why.contains("`fluid.lift.spin`") && why.contains("needs spheres that rotate"), "{why}");
}
