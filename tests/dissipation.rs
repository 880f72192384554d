//! Restitution below one: cooling, inelastic collapse, coming to rest, and impulses passed on through touching spheres.

use crate::support::*;
use diptych::engine::Failure;
use diptych::experiment::{Amount, Integrator, Model, SoftStepping, TimeStep};
use diptych::particles::Particles;
use diptych::placement::initial_state;
use diptych::scene::Scene;
use diptych::simulation::Simulation;
use nalgebra::Vector3;

/// Unit spheres on a line, which move like points in one dimension. Differences of `points` [m] are the gaps between
/// their surfaces, and `speeds` [m/s] are their velocities.
fn line(restitution: f64, points: &[f64], speeds: &[f64]) -> (Scene, Particles) {
    let scene = empty([64.0; 3], [false; 3], unit(), surface(restitution, 0.0));
    let list: Vec<_> = points
        .iter()
        .zip(speeds)
        .enumerate()
        .map(|(k, (x, v))| ([16.0 + x + k as f64, 32.0, 32.0], [*v, 0.0, 0.0]))
        .collect();
    let particles = placed(&scene, &list);
    (scene, particles)
}

fn speeds(simulation: &Simulation) -> Vec<f64> {
    simulation.particles.velocity.iter().map(|v| v.x).collect()
}

#[test]
fn three_particles_on_a_line() {
    // oracle E2: e, number of collisions, time of the last, final velocities
    for (e, count, last, want) in [
        (1.0, 3, 1.5, [-1.0, 0.0, 1.0]),
        (0.9, 3, 1.498687664, [-0.854875, 0.002375, 0.8525]),
        (0.5, 3, 1.461538462, [-0.359375, 0.046875, 0.3125]),
        (0.2, 4, 1.588235294, [-0.056, 0.0144, 0.0416]),
        (0.1, 6, 1.487383535, [-7.971875e-4, -1.53140625e-4, 9.50328125e-4]),
        (0.08, 11, 1.908326262, [-1.29718e-6, -1.09799e-6, 2.39517e-6]),
    ] {
        let start = || line(e, &[0.0, 1.0, 2.5], &[1.0, 0.0, -1.0]);
        for windows in [1, 7] {
            let (scene, particles) = start();
            let end = run(&scene, particles, hard(), 3.0, windows);
            assert_eq!(end.record.pairs.count, count, "e = {e}");
            for (got, want) in speeds(&end).iter().zip(want) {
                // tolerance: the printed digits, which are nine decimals or six significant digits
                close(&format!("e = {e}"), *got, want, 1e-9f64.max(1e-10 * want.abs()).min(1e-5 * want.abs() + 1e-14));
            }
        }
        // the last collision is at the printed instant, to 1e-8; near the collapse, rounding errors grow more
        for (time, done) in [(last - 1e-8, count - 1), (last + 1e-8, count)] {
            let (scene, particles) = start();
            assert_eq!(run(&scene, particles, hard(), time, 1).record.pairs.count, done, "e = {e} at {time}");
        }
    }
}

#[test]
fn collapse_of_three_particles_ends() {
    // oracle E2: for e < 7 - 4 sqrt 3 there are infinitely many collisions before 1.35714 or 1.38254. The relative
    // velocities fall below rounding within a few dozen collisions. The three spheres then move on as one cluster,
    // which is the limit of the sequence
    for (e, limit) in [(0.05, 1.35714), (0.07, 1.38254)] {
        let (scene, particles) = line(e, &[0.0, 1.0, 2.5], &[1.0, 0.0, -1.0]);
        let before = run(&scene, particles.clone(), hard(), limit - 0.05, 1);
        let (end, result) = try_run(&scene, particles, hard(), 3.0, 30);
        println!("e = {e}: {result:?} after {} collisions", end.record.pairs.count);
        match result {
            Ok(()) => {
                let v = speeds(&end);
                assert!(v.iter().all(|v| v.abs() < 1e-12), "{v:?} are not a cluster at rest");
            }
            Err(Failure::InelasticCollapse { time, .. }) => close("instant", time, limit, 1e-4),
            Err(other) => panic!("{other}"),
        }
        assert!(end.record.pairs.count > before.record.pairs.count);
        assert!(end.record.pairs.count < 1000);
        assert!(smallest_gap(&scene, &end.particles) > -1e-12);
        close("momentum", end.particles.momentum().x, 0.0, 1e-14);
    }
}

#[test]
fn simultaneous_touches_on_a_line_are_reproducible() {
    // oracle E2, simultaneous touches: either order of the collisions is right, but it must be the same in every run
    for (e, want) in [(1.0, [-1.0, 0.0, 1.0]), (0.9, [-0.854875, 0.002375, 0.8525])] {
        let go = || {
            let (scene, particles) = line(e, &[0.0, 1.0, 2.0], &[1.0, 0.0, -1.0]);
            speeds(&run(&scene, particles, hard(), 3.0, 4))
        };
        let got = go();
        assert_eq!(got, go());
        let mirror: Vec<f64> = want.iter().rev().map(|v| -v).collect();
        let off = |want: &[f64]| got.iter().zip(want).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off(&want) < 1e-14 || off(&mirror) < 1e-14, "{got:?}");
    }
}

/// A small sphere of the paper (docs/paper.md) with its surface `height` [m] above a floor.
fn bouncing(restitution: f64, height: f64) -> (Scene, Particles) {
    let mut scene = empty([0.1; 3], [false; 3], small(), surface(1.0, 0.0));
    scene.gravity = Vector3::new(0.0, -9.81, 0.0);
    scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], surface(restitution, 0.0))];
    let particles = placed(&scene, &[([0.05, height + 0.5 * small().diameter, 0.05], [0.0; 3])]);
    (scene, particles)
}

#[test]
fn bouncing_to_rest() {
    // oracle E3: total time (1+e)/(1-e) sqrt(2h/g), and number of impacts before flights become shorter than 1e-6 s
    for (e, total, count) in [(0.94_f64, 2.06464777, 191), (0.9, 1.21324663, 112), (0.5, 0.19156526, 17)] {
        let fall = (2.0f64 * 0.02 / 9.81).sqrt();
        // a time in the middle of the flight after this number of impacts
        let flights: f64 = (1..count).map(|k| 2.0 * fall * e.powi(k)).sum();
        let until = fall + flights + fall * e.powi(count);
        let (scene, ball) = bouncing(e, 0.02);
        let end = run(&scene, ball.clone(), hard(), until, 10);
        assert_eq!(end.record.walls.count, count as u64, "e = {e}");
        let next = 2.0 * fall * e.powi(count);
        assert!(next < 1e-6 && next / e > 1e-6, "the oracle's count is that of flights above 1e-6 s");
        let (end, result) = try_run(&scene, ball, hard(), 1.5 * total, 3000);
        let Err(Failure::InelasticCollapse { time, y, .. }) = result else { panic!("e = {e}: {result:?}") };
        println!("e = {e}: {time}, oracle {total}, {} bounces", end.record.walls.count);
        // flights become so short (1e-9 to 1e-8 s) that rounding errors of 1e-17 m decide their durations; there are
        // about 200 such flights
        close("comes to rest", time, total, 1e-5);
        close("on the floor", y, 0.5 * small().diameter, 1e-13);
        assert!(end.record.walls.count < 1000);
    }
}

#[test]
fn a_hard_sphere_without_restitution_cannot_rest() {
    // e = 0: the first touch ends the bounces. With gravity the run stops with a failure; without gravity the sphere
    // slides along the wall
    let (mut scene, ball) = bouncing(0.0, 0.02);
    let (end, result) = try_run(&scene, ball.clone(), hard(), 0.1, 10);
    let Err(Failure::InelasticCollapse { time, .. }) = result else { panic!("{result:?}") };
    close("at the first touch", time, (2.0f64 * 0.02 / 9.81).sqrt(), 1e-9);
    assert!(end.record.walls.count < 1000);
    scene.gravity = Vector3::zeros();
    let mut ball = ball;
    ball.velocity[0] = Vector3::new(0.1, -1.0, 0.2);
    let end = run(&scene, ball, hard(), 0.1, 10);
    assert_eq!(end.record.walls.count, 1);
    assert!((end.particles.velocity[0] - Vector3::new(0.1, 0.0, 0.2)).norm() < 1e-16);
    close("stays on the wall", end.particles.position[0].y, 0.5 * small().diameter, 1e-16);
}

#[test]
fn a_sphere_resting_on_a_slope_is_reported_however_short_the_window() {
    // a tangential speed much larger than that of the bounces, and friction, must not hide the collapse
    let slope = Vector3::new(0.1f64.sin(), 0.1f64.cos(), 0.0);
    let mut scene = empty([0.1; 3], [false; 3], small(), surface(1.0, 0.0));
    scene.gravity = Vector3::new(0.0, -9.81, 0.0);
    scene.walls = vec![plane([0.0, 0.05, 0.0], slope.into(), surface(0.5, 0.1))];
    let x = Vector3::new(0.02, 0.05, 0.05);
    let on = x - slope * (x - Vector3::new(0.0, 0.05, 0.0)).dot(&slope) + slope * (0.5 * small().diameter + 1e-5);
    for window in [1e-2, 1e-5, 1e-7] {
        let ball = placed(&scene, &[(on.into(), [0.3, 0.0, 0.2])]);
        let (end, result) = try_run(&scene, ball, hard(), 0.02, (0.02f64 / window).round() as u64);
        assert!(matches!(result, Err(Failure::InelasticCollapse { .. })), "window {window}: {result:?}");
        assert!(end.record.walls.count < 2000, "{}", end.record.walls.count);
    }
}

#[test]
fn newtons_cradle_hard() {
    // oracle E4: touching spheres, one of which is hit at speed 1; the impulses follow one another
    let cases: [(&[f64], f64, &[f64], u64, f64); 7] = [
        (&[1.0, 0.0, 0.0], 1.0, &[0.0, 0.0, 1.0], 2, 1e-15),
        (&[1.0, 0.0, 0.0], 0.94, &[0.029127, 0.029973, 0.940900], 3, 1e-14),
        (&[1.0, 0.0, 0.0], 0.5, &[0.203125, 0.234375, 0.562500], 3, 1e-14),
        (&[1.0, 0.0, 0.0, 0.0, 0.0], 1.0, &[0.0, 0.0, 0.0, 0.0, 1.0], 4, 1e-15),
        (&[1.0, 0.0, 0.0, 0.0, 0.0], 0.94, &[0.02752973, 0.02828084, 0.02905222, 0.02984441, 0.88529281], 10, 6e-9),
        (&[1.0, 1.0, 0.0], 1.0, &[0.0, 1.0, 1.0], 2, 1e-15),
        (&[1.0, 0.0], 0.5, &[0.25, 0.75], 1, 1e-15),
    ];
    for (start, e, want, count, tolerance) in cases {
        let (scene, particles) = line(e, &vec![0.0; start.len()], start);
        let end = run(&scene, particles, hard(), 1.0, 2);
        for (got, want) in speeds(&end).iter().zip(want) {
            close(&format!("{start:?} e = {e}"), *got, *want, tolerance);
        }
        assert_eq!(end.record.pairs.count, count, "{start:?} e = {e}: events");
    }
}

#[test]
fn newtons_cradle_soft() {
    // oracle E4: all spheres are in contact at once, so that the impulse is not passed on completely; N_c = 200,
    // tolerance 1e-3
    let cases: [(&[f64], f64, f64, &[f64]); 8] = [
        (&[1.0, 0.0, 0.0], 1.0, 0.0, &[-0.13026170, 0.15022957, 0.98003213]),
        (&[1.0, 0.0, 0.0], 0.94, 0.0, &[-0.11112162, 0.17505818, 0.93606343]),
        (&[1.0, 0.0, 0.0], 0.5, 0.0, &[0.03116016, 0.30914007, 0.65969977]),
        (&[1.0, 0.0, 0.0, 0.0, 0.0], 1.0, 0.0, &[-0.13227948, -0.07532917, -0.03101083, 0.29621775, 0.94240173]),
        (&[1.0, 0.0, 0.0, 0.0, 0.0], 0.94, 0.0, &[-0.11423129, -0.06172975, -0.0131386, 0.30852543, 0.8805742]),
        (&[1.0, 1.0, 0.0], 1.0, 0.0, &[0.01996787, 0.84977043, 1.1302617]),
        (&[1.0, 0.0, 0.0], 1.0, 0.5, &[-0.007162, 0.007214, 0.999948]),
        (&[1.0, 0.0, 0.0], 1.0, 2.0, &[0.0, 0.0, 1.0]),
    ];
    let k: f64 = 1e6;
    let dt = std::f64::consts::PI * (0.5 / k).sqrt() / 200.0;
    for integrator in [Integrator::VelocityVerlet, Integrator::Rk2] {
        for (start, e, gap, want) in cases {
            // gaps are in units of u_0 sqrt(m/k)
            let gap = gap / k.sqrt();
            let points: Vec<f64> = (0..start.len()).map(|i| i as f64 * gap).collect();
            let (scene, particles) = line(e, &points, start);
            let end = run(&scene, particles, soft(k, dt, integrator), 6000.0 * dt, 1);
            for (got, want) in speeds(&end).iter().zip(want) {
                close(&format!("{integrator:?} {start:?} e = {e} gap {gap}"), *got, *want, 1e-3);
            }
        }
    }
}

/// A gas of 1000 unit spheres at the volume fraction 0.05 and the granular temperature 1 m²/s².
fn gas(restitution: f64, seed: u64) -> (Scene, Particles) {
    let edge = edge(1000, 1.0, 0.05);
    let scene = empty([edge; 3], [true; 3], unit(), surface(restitution, 0.0));
    let particles = random(&scene, 1000, 1.0, seed);
    (scene, particles)
}

/// Values of ln(T/T0) [-] at the instants at which the number of collisions per particle reaches each of `taus`. T is
/// the granular temperature, and T0 its value at the start.
fn cooling(mut simulation: Simulation, taus: &[f64]) -> Vec<f64> {
    let start = temperature(&simulation.particles);
    taus.iter()
        .map(|tau| {
            let mut before = (0.0, 0.0);
            loop {
                let ln = (temperature(&simulation.particles) / start).ln();
                let now = simulation.record.pairs.count as f64 * 2.0 / 1000.0;
                if now >= *tau {
                    return before.1 + (ln - before.1) * (tau - before.0) / (now - before.0);
                }
                before = (now, ln);
                // duration of a tenth of a collision per particle
                simulation.run(1, 0.1 / 0.77 * (-0.5 * ln).exp()).unwrap();
            }
        })
        .collect()
}

#[test]
fn homogeneous_cooling() {
    // oracle E1: ln(T/T0) at 10, 20, 30 collisions per particle within 3 % (an independent event-driven code, N =
    // 1000). At 50 collisions, Haff's law gives -(1 - e²) 50/3; at 30 the code is 1 % below this law
    for (e, want) in [(0.9, [-0.6227, -1.2514, -1.8808, -3.1667]), (0.8, [-1.1889, -2.3673, -3.5597, -6.0])] {
        let mut mean = [0.0; 4];
        for seed in 1..=4 {
            let (scene, particles) = gas(e, seed);
            let ln = cooling(Simulation::with_engine(scene, particles, hard()), &[10.0, 20.0, 30.0, 50.0]);
            mean.iter_mut().zip(ln).for_each(|(mean, ln)| *mean += ln / 4.0);
        }
        println!("hard e = {e}: {mean:?}, oracle {want:?}");
        for (got, want) in mean.iter().zip(want) {
            close("ln T/T0", *got, want, 0.03 * want.abs());
        }
    }
}

#[test]
fn homogeneous_cooling_of_soft_spheres() {
    // oracle E1: the values of hard spheres within 3 % at N_c = 50, with sqrt(mT/k) = 0.004 d (effective diameter
    // within 0.5 %). A single start varies by 2 %, so that the mean over four starts is used, as for hard spheres
    let k: f64 = 1.0 / (0.004 * 0.004);
    let dt = std::f64::consts::PI * (0.5 / k).sqrt() / 50.0;
    let ln = (1..=4).map(|seed| {
        let (scene, particles) = gas(0.9, seed);
        let simulation = Simulation::with_engine(scene, particles, soft(k, dt, Integrator::VelocityVerlet));
        cooling(simulation, &[10.0])[0]
    });
    let ln: Vec<f64> = ln.collect();
    println!("soft: {ln:?}");
    close("ln T/T0", ln.iter().sum::<f64>() / 4.0, -0.6227, 0.03 * 0.6227);
}

#[test]
fn homogeneous_cooling_of_soft_spheres_for_long() {
    // oracle E1 up to 50 collisions per particle, as for hard spheres; only particles in contact are stepped, at N_c =
    // 50
    let k: f64 = 1.0 / (0.004 * 0.004);
    let dt = std::f64::consts::PI * (0.5 / k).sqrt() / 50.0;
    for (e, want) in [(0.9, [-0.6227, -1.2514, -1.8808, -3.1667]), (0.8, [-1.1889, -2.3673, -3.5597, -6.0])] {
        let mut mean = [0.0; 4];
        for seed in 1..=4 {
            let (scene, particles) = gas(e, seed);
            let simulation = Simulation::with_engine(scene, particles, local(k, dt, Integrator::VelocityVerlet));
            let ln = cooling(simulation, &[10.0, 20.0, 30.0, 50.0]);
            mean.iter_mut().zip(ln).for_each(|(mean, ln)| *mean += ln / 4.0);
        }
        println!("soft e = {e}: {mean:?}, oracle {want:?}");
        for (got, want) in mean.iter().zip(want) {
            close("ln T/T0", *got, want, 0.03 * want.abs());
        }
    }
}

#[test]
fn ledger_explains_the_energy() {
    // Gravity, walls, friction, restitution, periodic sides. The energy residual is rounding for hard spheres. For
    // Verlet's method it is proportional to Δt². With an eighth of the step, 1/64 of it would remain if the runs were
    // not chaotic and contacts were not detected at the ends of steps
    let build = |e: f64, mu: f64| {
        let mut scene = empty([8.0, 6.0, 8.0], [true, false, true], unit(), surface(e, mu));
        scene.gravity = Vector3::new(0.3, -0.5, 0.2);
        scene.walls = vec![
            plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.9, 0.2)),
            plane([0.0, 6.0, 0.0], [0.0, -1.0, 0.0], surface(0.95, 0.1)),
        ];
        let particles = random(&scene, 100, 1.0, 3);
        (scene, particles)
    };
    let residual = |engine, windows: u64| {
        let (scene, particles) = build(0.9, 0.15);
        let start = particles.kinetic_energy();
        let momentum = particles.momentum();
        let end = run(&scene, particles, engine, 6.0, windows);
        let ledger = &end.record.ledger;
        assert!(end.record.pairs.count > 300 && end.record.walls.count > 100);
        for loss in [
            ledger.pair_restitution_loss,
            ledger.pair_friction_loss,
            ledger.wall_restitution_loss,
            ledger.wall_friction_loss,
        ] {
            assert!(loss > 0.01 * start, "{ledger:?}");
        }
        let drift = end.particles.momentum() - momentum - ledger.gravity_impulse - ledger.wall_impulse;
        (ledger.residual(start, end.energy()) / start, drift.norm())
    };
    for windows in [1, 60] {
        let (energy, momentum) = residual(hard(), windows);
        println!("hard, {windows} windows: energy {energy:.1e}, momentum {momentum:.1e}");
        assert!(energy.abs() < 1e-12, "hard: {energy}");
        assert!(momentum < 1e-11, "hard: {momentum}");
    }
    let verlet = |nc: f64| {
        let dt = std::f64::consts::PI * (0.5f64 / 1e4).sqrt() / nc;
        residual(soft(1e4, dt, Integrator::VelocityVerlet), 60).0
    };
    let residuals = [20.0, 40.0, 80.0, 160.0].map(verlet);
    println!("Verlet: {residuals:?}");
    assert!(residuals[0].abs() < 0.02, "{residuals:?}");
    assert!(residuals[3].abs() < residuals[0].abs() / 16.0, "{residuals:?}");
}

#[test]
fn ledger_of_an_elastic_gas_is_the_heating_of_rk2() {
    // nothing dissipates, so that the residual is E - E0 except for rounding, and is positive for RK2
    let (scene, particles) = gas(1.0, 2);
    let k: f64 = 1e4;
    let dt = std::f64::consts::PI * (0.5 / k).sqrt() / 8.0;
    let start = particles.kinetic_energy();
    let end = run(&scene, particles, soft(k, dt, Integrator::Rk2), 4.0, 10);
    let gain = end.energy() - start;
    assert!(gain > 0.02 * start, "RK2 heats: {}", gain / start);
    close("residual", end.record.ledger.residual(start, end.energy()), gain, 1e-12 * start);
}

/// Two spheres, and a sphere on a floor, start at rest with overlaps. The springs contain all energy.
#[test]
fn ledger_counts_the_elastic_energy_of_the_start() {
    const STEPS: f64 = 200.0;
    for restitution in [1.0, 0.8] {
        for stepping in [SoftStepping::Uniform, SoftStepping::Local, SoftStepping::Auto] {
            let mut scene = empty([8.0; 3], [true, false, true], unit(), surface(restitution, 0.0));
            scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], surface(restitution, 0.0))];
            let list = [[2.0, 4.0, 2.0], [2.995, 4.0, 2.0], [6.0, 0.497, 2.0]].map(|place| (place, [0.0; 3]));
            let mut start = experiment(scene, 0, [0.0; 3], 0.0, Model::Soft, 1);
            start.start[0].amount = Amount::Placed(placed(&start.scene, &list));
            start.soft.stepping = stepping;
            start.soft.time_step = TimeStep::PerContact(STEPS);
            let k = start.soft.law.unwrap().parameter().value;
            let mut simulation = Simulation::new(&start, initial_state(&start).unwrap());
            let before = simulation.energy();
            // k δ²/2 for each overlap; the coordinates are a few metres
            close("elastic energy", before, 0.5 * k * (0.005f64.powi(2) + 0.003f64.powi(2)), 1e-12 * k);
            simulation.run(5, 0.05).unwrap();
            let now = simulation.energy();
            assert!(simulation.particles.kinetic_energy() > 0.5 * before, "the springs have let go");
            let residual = simulation.record.ledger.residual(before, now) / before;
            println!("{restitution} {stepping:?}: {residual:.1e}");
            // in an elastic contact, velocity Verlet may gain (ω_0 Δt)²/4; the loss by the dashpot has an error of the
            // same order
            let order = (std::f64::consts::PI / STEPS).powi(2);
            assert!(residual.abs() < order, "{restitution}, {stepping:?}: {residual}");
        }
    }
}
