//! Are the windows that the schedule chooses short enough for what it promises?

use crate::support::{empty, experiment, large, placed, small, surface};
use diptych::drag::{Drag, SchillerNaumann};
use diptych::experiment::{Amount, Experiment, Model};
use diptych::fluid::{Fluid, Profile};
use diptych::placement::initial_state;
use diptych::scene::{Scene, Species};
use diptych::schedule::{SPLITTING_ALONE, Schedule};
use diptych::simulation::Simulation;
use nalgebra::Vector3;

/// A tall box of still air with gravity downwards, open along z.
fn still_air(species: Species) -> Scene {
    let mut scene = empty([2.0, 2.0, 300.0], [true, true, false], species, surface(1.0, 0.0));
    scene.gravity = Vector3::new(0.0, 0.0, -9.81);
    scene.fluid = Some(Fluid {
        density: 1.205,
        kinematic_viscosity: 1.515e-5,
        profile: Profile::Uniform(0.0),
        drag: Some(Drag::SchillerNaumann(SchillerNaumann)),
    });
    scene
}

/// A sphere that starts in the middle of the box with `velocity` [m/s] and is followed for `duration` [s].
fn thrown(species: Species, velocity: [f64; 3], duration: f64) -> Experiment {
    let mut experiment = experiment(still_air(species), 1, [0.0; 3], 0.0, Model::Hard, 1);
    experiment.start[0].amount = Amount::Placed(placed(&experiment.scene, &[([1.0, 1.0, 250.0], velocity)]));
    experiment.run.duration = duration;
    experiment
}

/// [m/s] velocity at the end with the windows of the schedule, each cut into `parts`.
fn velocity(experiment: &Experiment, parts: u64) -> Vector3<f64> {
    let schedule = Schedule::new(experiment);
    let mut simulation = Simulation::new(experiment, initial_state(experiment).unwrap());
    let windows = parts * schedule.samples * schedule.windows_per_sample;
    simulation.run(windows, schedule.window / parts as f64).unwrap();
    simulation.particles.velocity[0]
}

/// Terminal Reynolds numbers of 45, 297, 551 and 1730, at the beginning of the fall, on its way and at its end. Windows a twentieth
/// as long are off by a four-hundredth, so that they serve as the reference. The coefficient jumps by 0.4 % at Re = 1000, which the
/// largest sphere passes: for half a window at most the wrong one acts, on a deceleration below g.
#[test]
fn windows_for_a_fall_from_rest() {
    let sphere = |diameter: f64| Species { diameter, ..large() };
    for species in [small(), sphere(1.08e-3), large(), sphere(3e-3)] {
        for duration in [0.01, 0.05, 0.2, 0.6, 4.0] {
            let fall = thrown(species.clone(), [0.0; 3], duration);
            let (coarse, fine) = (velocity(&fall, 1), velocity(&fall, 20));
            let error = (coarse - fine).norm() / fine.norm();
            let what = format!("{} m, {duration} s: off by {error:e}", species.diameter);
            let jump = if fine.norm() > 1000.0 * 1.515e-5 / species.diameter { 0.002 } else { 0.0 };
            let crossing = jump * 9.81 * Schedule::new(&fall).window / fine.norm();
            assert!(error < SPLITTING_ALONE + crossing, "{what}");
            // nor needlessly short: a tenth of the promise, or a third of the longest window
            assert!(error > 0.1 * SPLITTING_ALONE, "{what}: the window is too short");
        }
    }
}

/// A throw across the gas is as fast as its components together, and falls meanwhile.
#[test]
fn windows_for_a_throw_across() {
    for duration in [0.05, 1.0] {
        let throw = thrown(small(), [20.0, 0.0, 0.0], duration);
        let (coarse, fine) = (velocity(&throw, 1), velocity(&throw, 20));
        let error = (coarse - fine).norm() / fine.norm();
        assert!(error < SPLITTING_ALONE, "{duration} s: off by {error:e}");
    }
}

/// Many spheres that start at rest get no longer windows than one, collisions ask for shorter ones.
#[test]
fn windows_for_beads_at_rest() {
    let alone = Schedule::new(&thrown(large(), [0.0; 3], 0.5)).window;
    let mut beads = experiment(still_air(large()), 1000, [0.0; 3], 0.0, Model::Soft, 1);
    beads.run.duration = 0.5;
    assert_eq!(Schedule::new(&beads).window, alone, "collisions are rare in 1200 m³");
    beads.scene.domain.size = Vector3::new(0.02, 0.02, 0.02);
    let crowded = Schedule::new(&beads).window;
    assert!(crowded < 0.7 * alone, "{crowded} s in a crowd, {alone} s alone");
}
