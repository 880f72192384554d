//! Spheres dropped on a floor and squeezed between walls, against closed-form solutions (oracle C, section C of the
//! catalogue of reference values).

use crate::support::*;
use diptych::engine::Failure;
use diptych::experiment::Integrator;
use diptych::particles::Particles;
use diptych::scene::{Scene, Species};
use diptych::simulation::Simulation;
use nalgebra::Vector3;

/// Scene and particles of oracle C (section C of the catalogue of reference values): a ball above a floor, at rest with
/// its centre at `height` [m].
fn dropped(species: Species, restitution: f64, height: f64) -> (Scene, Particles) {
    let edge = 4.0 * height;
    let mut scene = empty([edge; 3], [false; 3], species, surface(1.0, 0.0));
    scene.gravity = Vector3::new(0.0, -9.80665, 0.0);
    scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], surface(restitution, 0.0))];
    let particles = placed(&scene, &[([0.5 * edge, height, 0.5 * edge], [0.0; 3])]);
    (scene, particles)
}

fn mfix_ball() -> Species {
    Species::new("ball", 0.2, 2600.0)
}

/// Height of the apex of the present flight [m].
fn apex(simulation: &Simulation) -> f64 {
    let (x, v) = (simulation.particles.position[0], simulation.particles.velocity[0]);
    x.y + v.y * v.y / (2.0 * 9.80665)
}

#[test]
fn ball_dropped_on_a_soft_floor() {
    // oracle C1: k, e, end of contact, speed at this end, largest overlap, apex. The step divides the time of the fall,
    // so that the contact begins at the end of a step
    let fall: f64 = 0.2856173962;
    for (k, e, end, speed, overlap, height) in [
        (1e4, 1.0, 0.39688654, 2.80094984, 0.10373022, 0.5),
        (1e4, 0.9, 0.39743489, 2.47544321, 0.09837602, 0.41243182),
        (1e4, 0.8, 0.39826399, 2.14914067, 0.09296947, 0.33549355),
        (1e4, 0.6, 0.40134586, 1.49173618, 0.08195062, 0.21345754),
        (5e4, 1.0, 0.33350687, 2.80094984, 0.04352938, 0.5),
        (5e4, 0.9, 0.33362360, 2.50160938, 0.04131345, 0.41907173),
        (5e4, 0.6, 0.33467116, 1.60203036, 0.03450570, 0.23085515),
    ] {
        for integrator in BOTH {
            let dt = fall / 40_000.0;
            let (scene, ball) = dropped(mfix_ball(), e, 0.5);
            let law = LinearSpring { stiffness: k };
            let x = law.angular_frequency(ball.mass[0]) * dt;
            let dashpot = 2.0 * LinearSpring::damping_ratio(e) * x;
            let done = run(&scene, ball, soft(k, dt * (1.0 + 1e-9), integrator), (0.45 / dt).round() * dt, 1);
            let seen = done.record.walls.summary();
            let what = format!("{integrator:?} k={k} e={e}");
            assert_eq!(seen.count, 1, "{what}");
            close(&format!("{what} contact"), seen.mean_duration.unwrap(), end - fall, 2.0 * dt);
            let rebound = seen.mean_restitution.unwrap() * seen.mean_normal_speed.unwrap();
            close(&format!("{what} speed"), rebound, speed, speed * dashpot + 2.0 * 9.81 * dt + 1e-6);
            let deepest = seen.largest_overlap.unwrap() * 0.2;
            close(&format!("{what} overlap"), deepest, overlap, overlap * (dashpot + 1e-6));
            close(&format!("{what} apex"), apex(&done), height, height * (2.0 * dashpot + 1e-6));
        }
    }
    let (scene, ball) = dropped(mfix_ball(), 0.9, 0.5);
    let done = run(&scene, ball, soft(1e5, 1e-5, Integrator::VelocityVerlet), 0.5, 7);
    close("y(0.5 s)", done.particles.position[0].y, 0.39303747, 1e-4);
}

#[test]
fn energy_of_a_ball_in_a_deep_contact_is_booked_at_the_order_of_local_steps() {
    // Half of a contact has passed. Gravity does work on the momentum received from the floor, which grows within each
    // step. With friction, the step is that of all contacts of an island, without friction that of a single contact.
    for friction in [0.0, 0.3] {
        for steps in [50.0, 100.0, 1000.0] {
            let (mut scene, ball) = dropped(mfix_ball(), 1.0, 0.5);
            scene.walls[0].surface.friction = friction;
            let time = LinearSpring { stiffness: 5e4 }.contact_time(ball.mass[0], 1.0);
            let done = run(&scene, ball, local(5e4, time / steps, Integrator::VelocityVerlet), 0.31, 1);
            assert!(done.elastic_energy() > 0.3 * done.energy(), "the contact is deep");
            let residual = done.record.ledger.residual(0.0, done.energy()) / done.energy();
            // with the phase x of a step, a step of the classical Runge-Kutta method takes x^6/72 of the energy of an
            // oscillator; up to 0.6 of a contact has passed, and each of the four stages rounds by 1e-15
            let x = std::f64::consts::PI / steps;
            let bound = 0.6 * steps * (x.powi(6) / 72.0 + 4e-15);
            assert!(residual.abs() < bound, "{friction} {steps} {residual:e} {bound:e}");
        }
    }
}

#[test]
fn paper_sized_ball_dropped_on_a_floor() {
    // oracle C1: S from 20 mm, k = 3000 N/m, about 400 steps per contact
    let fall = 0.06386599136;
    for (e, end, speed, overlap) in [
        (1.0, 0.0638769307, 0.6263114241, 2.18092345e-6),
        (0.94, 0.06387693284, 0.5887301293, 2.115303e-6),
        (0.5, 0.06387719398, 0.3131336538, 1.617825e-6),
    ] {
        let d = small().diameter;
        let (scene, ball) = dropped(small(), e, 0.02 + 0.5 * d);
        let dt = fall / 2_400_000.0;
        let dashpot = 2.0 * LinearSpring::damping_ratio(e) * (3000.0 / ball.mass[0]).sqrt() * dt;
        let done = run(&scene, ball, soft(3000.0, dt * (1.0 + 1e-9), Integrator::VelocityVerlet), 0.0639, 1);
        let seen = done.record.walls.summary();
        close("contact", seen.mean_duration.unwrap(), end - fall, 2.0 * dt);
        let rebound = seen.mean_restitution.unwrap() * seen.mean_normal_speed.unwrap();
        close("speed", rebound, speed, speed * (1e-5 + 2.0 * dashpot));
        close("overlap", seen.largest_overlap.unwrap() * d, overlap, overlap * (1e-5 + dashpot));
    }
}

#[test]
fn bounces_of_a_hard_ball() {
    // oracle C2: apexes and instants of impact for e = 0.9, to 1e-9
    let heights = [0.5, 0.424, 0.36244, 0.3125764, 0.27218688, 0.23947138, 0.21297181];
    let impacts = [0.28561740, 0.79972871, 1.26242889, 1.67885906, 2.05364620, 2.39095464];
    for windows in [1, 13] {
        let (scene, ball) = dropped(mfix_ball(), 0.9, 0.5);
        let mut simulation = Simulation::with_engine(scene, ball, hard());
        let mut time = 0.0;
        for (k, impact) in impacts.iter().enumerate() {
            let (x, v) = (simulation.particles.position[0].y, simulation.particles.velocity[0].y);
            let next = time + (v + (v * v + 2.0 * 9.80665 * (x - 0.1)).sqrt()) / 9.80665;
            close("instant of the next impact", next, *impact, 6e-9);
            close("apex", apex(&simulation), 0.1 + 0.4 * 0.81f64.powi(k as i32), 1e-9);
            close("apex as printed", apex(&simulation), heights[k], 6e-9);
            let until = impact + 0.05;
            simulation.run(windows, (until - time) / windows as f64).unwrap();
            assert_eq!(simulation.record.walls.count, k as u64 + 1);
            time = until;
        }
    }
}

#[test]
fn bounces_of_a_stiff_soft_ball() {
    // oracle C2: k = 5e6 N/m within 1 %
    let (scene, ball) = dropped(mfix_ball(), 0.9, 0.5);
    let mut simulation = Simulation::with_engine(scene, ball, soft(5e6, 5e-6, Integrator::VelocityVerlet));
    let mut time = 0.0;
    for (k, until) in [0.4, 0.9, 1.35, 1.75].into_iter().enumerate() {
        simulation.run(1, until - time).unwrap();
        time = until;
        let want = 0.1 + 0.4 * 0.81f64.powi(k as i32 + 1);
        println!("apex {}: {}", k + 1, apex(&simulation));
        close("apex", apex(&simulation), want, 0.01 * want);
    }
}

#[test]
fn a_hard_ball_that_comes_to_rest_is_reported() {
    // oracle C2: the infinite series of bounces ends at 5.426730529 s, for any window and without a hang
    for window in [1.0, 0.1, 1e-3, 1e-4] {
        let (scene, ball) = dropped(mfix_ball(), 0.9, 0.5);
        let windows = (6.0f64 / window).round() as u64;
        let (simulation, result) = try_run(&scene, ball, hard(), 6.0, windows);
        match result {
            Err(Failure::InelasticCollapse { time, y, .. }) => {
                println!("window {window}: {time} s, {} bounces", simulation.record.walls.count);
                // times and positions resolve 1e-16: flights shorter than about 1e-8 s cannot be distinguished
                close("end", time, 5.426730529, 1e-5);
                close("place", y, 0.1, 1e-12);
                // the particle store contains the state at that instant
                close("stored place", simulation.particles.position[0].y, 0.1, 1e-12);
                assert!(simulation.record.walls.count < 2000, "{}", simulation.record.walls.count);
            }
            other => panic!("window {window}: {other:?}"),
        }
    }
}

#[test]
fn two_stacked_particles_squeezed_between_walls() {
    // oracle C3: all contacts exist at the start; (y1, v1, y2, v2)
    let build = |e: f64| {
        let species = [20000.0, 10000.0].map(|density| Species::new("C3", 1e-3, density));
        let mut scene = empty([0.01, 0.0018, 0.01], [false; 3], species[0].clone(), surface(e, 0.0));
        scene.species = species.to_vec();
        scene.gravity = Vector3::new(0.0, -9.80665, 0.0);
        scene.walls = vec![
            plane([0.0; 3], [0.0, 1.0, 0.0], surface(e, 0.0)),
            plane([0.0, 0.0018, 0.0], [0.0, -1.0, 0.0], surface(e, 0.0)),
        ];
        let mut particles = Particles::default();
        for (k, y) in [0.45e-3, 1.35e-3].into_iter().enumerate() {
            particles.push(Vector3::new(0.005, y, 0.005), Vector3::zeros(), 0.5e-3, species[k].mass(), k as u16);
        }
        (scene, particles)
    };
    for (e, time, want) in [
        (1.0, 1e-4, [4.3267464587e-4, -0.233122618, 1.3813857854e-3, 0.350795400]),
        (1.0, 5e-4, [4.3623748029e-4, 0.230577292, 1.3791393490e-3, -0.403903856]),
        (1.0, 1e-3, [4.2712799164e-4, -0.0259470187, 1.3835531579e-3, 0.391852092]),
        (0.7, 1e-4, [4.3533699077e-4, -0.181620386, 1.3756917685e-3, 0.250746732]),
        (0.7, 1e-3, [4.3260457240e-4, 0.0216720591, 1.3665695217e-3, 0.0344590064]),
    ] {
        for integrator in BOTH {
            let (scene, particles) = build(e);
            // about 5000 steps per contact: x² = 4e-7, and the impulse of the dashpot in one step is 1e-4
            let end = run(&scene, particles, soft(1000.0, 5e-8, integrator), time, 1);
            let (x, v) = (&end.particles.position, &end.particles.velocity);
            let got = [x[0].y, v[0].y, x[1].y, v[1].y];
            println!("{integrator:?} e={e} t={time}: {got:?}");
            for k in 0..4 {
                // displacements are up to 1e-4 m, speeds 0.4 m/s
                let scale = if k % 2 == 0 { 1e-4 } else { 0.4 };
                close(&format!("{integrator:?} e={e} t={time}"), got[k], want[k], 3e-4 * scale);
            }
        }
    }
    let (scene, particles) = build(0.7);
    let end = run(&scene, particles, soft(1000.0, 1e-6, Integrator::VelocityVerlet), 0.05, 50);
    let x = &end.particles.position;
    close("floor overlap at rest", 0.5e-3 - x[0].y, 6.675224583e-5, 1e-12);
    close("middle", 1e-3 - (x[1].y - x[0].y), 6.664955083e-5, 1e-12);
    close("ceiling", x[1].y - 1.3e-3, 6.659820333e-5, 1e-12);
}

#[test]
fn stepped_spheres_that_fall_alone_or_side_by_side_have_a_step_limit() {
    // Only the floor moves relative to the mean velocity. The sphere overlaps the floor by at most its motion in a
    // step, v Δt <= θ d sqrt(3π/4), and the error of the apex is at most as large.
    let (theta, e, height, d) = (0.01, 0.9, 0.5, 0.2);
    let (scene, alone) = dropped(mfix_ball(), e, height);
    let row = [0.5, 1.0, 1.5].map(|x| ([x, height, 1.0], [0.0; 3]));
    let late = theta * d * (0.75 * std::f64::consts::PI).sqrt();
    for particles in [alone, placed(&scene, &row)] {
        for windows in [1, 5, 200] {
            let (done, result) = try_run(&scene, particles.clone(), stepped(theta), 0.45, windows);
            assert_eq!(result, Ok(()), "{windows} windows");
            assert_eq!(done.record.walls.count, particles.len() as u64);
            let floor = 0.5 * d;
            close("apex", apex(&done), floor + e * e * (height - floor), late);
            assert!(
                done.record.walls.summary().largest_overlap.unwrap() <= late / d,
                "{:?}",
                done.record.walls.summary()
            );
        }
    }
    // without gravity, a sphere thrown straight at the floor
    let (mut scene, mut thrown) = dropped(mfix_ball(), e, height);
    scene.gravity = Vector3::zeros();
    thrown.velocity[0] = Vector3::new(0.0, -10.0, 0.0);
    let done = run(&scene, thrown, stepped(theta), 0.1, 1);
    close("speed", done.particles.velocity[0].y, 9.0, 1e-12);
    assert!(done.record.walls.summary().largest_overlap.unwrap() <= late / d);
}

#[test]
fn books_of_a_run_that_stops_end_where_it_stops() {
    // an infinite series of bounces ends within a window, and the overlap with a soft floor becomes too large
    let (scene, ball) = dropped(mfix_ball(), 0.5, 0.5);
    for windows in [1, 7, 300] {
        let (done, result) = try_run(&scene, ball.clone(), hard(), 2.0, windows);
        let Err(why @ Failure::InelasticCollapse { .. }) = result else { panic!("{result:?}") };
        // the sphere falls for t_0, then bounces for 2 t_0 e/(1-e)
        let fall = (2.0f64 * 0.4 / 9.80665).sqrt();
        close("time", done.time, 3.0 * fall, 1e-6);
        assert_eq!(done.time, why.time());
        let ledger = &done.record.ledger;
        close("work of gravity", ledger.gravity_work, ball.mass[0] * 9.80665 * 0.4, 1e-12);
        assert!(ledger.residual(0.0, done.energy()).abs() < 1e-12 * ledger.gravity_work, "{ledger:?}");
        // the impulse of the wall balances that of the weight, because the sphere hardly moves at the end
        close("impulse of gravity", ledger.gravity_impulse.y, -ledger.wall_impulse.y, 1e-6 * ball.mass[0]);
    }
    let dt = 1e-4;
    let (done, result) = try_run(&scene, ball.clone(), soft(100.0, dt, Integrator::VelocityVerlet), 2.0, 1);
    let Err(why @ Failure::OverlapTooLarge { .. }) = result else { panic!("{result:?}") };
    assert_eq!(done.time, why.time());
    let fallen = 0.5 - done.particles.position[0].y;
    // the ledger is computed from the momentum, without the contact force of the last step
    let force = 100.0 * 0.2 * dt * 9.80665 * done.time;
    close("work of gravity", done.record.ledger.gravity_work, ball.mass[0] * 9.80665 * fallen, 2.0 * force);
}

#[test]
fn hard_spheres_with_a_contact_time_start_at_rest_on_one_another() {
    let (contact_time, g, d) = (1e-5, 9.80665, 0.2);
    for (count, e) in [(1, 0.5), (3, 0.0), (3, 1.0), (10, 0.5)] {
        let (mut scene, _) = dropped(mfix_ball(), e, 1.0);
        scene.contact.restitution = e;
        let list: Vec<_> = (0..count).map(|k| ([2.0, (0.5 + k as f64) * d, 2.0], [0.0; 3])).collect();
        let start = placed(&scene, &list);
        for windows in [1, 300] {
            let engine = Box::new(diptych::engine::hard::Hard::new().with_contact_time(Some(contact_time)));
            let (done, result) = try_run(&scene, start.clone(), engine, 3e-3, windows);
            assert_eq!(result, Ok(()), "{count} spheres, e = {e}, {windows} windows");
            let ledger = &done.record.ledger;
            // each sphere keeps moving by the rise of a sphere that leaves the wall at g t_c/4, times the number of
            // such speeds that may add up
            let rise = g * contact_time * contact_time / 32.0;
            for (x, y) in done.particles.position.iter().zip(&start.position) {
                assert!(x.y - y.y > -1e-13 && x.y - y.y < 20.0 * count as f64 * rise, "{:e} {rise:e}", x.y - y.y);
            }
            // the impulse of the floor carries the weight, except for the momentum that the spheres may have
            let weight = start.mass.iter().sum::<f64>() * g * 3e-3;
            close("impulse", ledger.wall_impulse.y, weight, 0.05 * weight);
            // momenta have the rounding error of the weight's impulse; energies have this error times the speed
            let rounding = weight * g * contact_time * 1e-9;
            assert!(ledger.residual(0.0, done.energy()).abs() < rounding, "{ledger:?}");
        }
    }
}

#[test]
fn the_cure_of_a_collapse_is_not_the_one_already_taken() {
    let (scene, ball) = dropped(mfix_ball(), 0.5, 0.5);
    let engine = Box::new(diptych::engine::hard::Hard::new().with_contact_time(Some(1e-12)));
    let (_, result) = try_run(&scene, ball.clone(), engine, 2.0, 1);
    let message = result.unwrap_err().to_string();
    assert!(message.contains("hard.contact_time = 1e-12 s is too short here, make it longer"), "{message}");
    let message = try_run(&scene, ball, hard(), 2.0, 1).1.unwrap_err().to_string();
    assert!(message.contains("hard.contact_time = \"1e-6 s\" or more"), "{message}");
}

/// A soft sphere without friction lies on the floor while another one falls on it. The floor holds the first sphere
/// against gravity, so the second one comes nearer than by its speed alone. The velocity after the impact does not
/// depend on the window (piece of the run) of the impact, which ends 1 or 3 ms later.
#[test]
fn a_sphere_at_rest_is_hit_at_the_exact_time() {
    let (mut scene, _) = dropped(Species::new("bead", 1e-3, 2500.0), 0.9, 30e-3);
    scene.contact.restitution = 0.9;
    let weight = scene.species[0].mass() * 9.80665;
    let lies = 0.5e-3 - weight / 1500.0;
    let start = placed(&scene, &[([60e-3, lies, 60e-3], [0.0; 3]), ([60.05e-3, 30e-3, 60e-3], [0.0; 3])]);
    let sideways = [77e-3, 79e-3].map(|duration| {
        let done = run(&scene, start.clone(), local(1500.0, 2e-6, Integrator::VelocityVerlet), duration, 1);
        assert_eq!(done.record.pairs.summary().count, 1);
        done.particles.velocity[1].x
    });
    close("sideways", sideways[0], sideways[1], 1e-6 * sideways[1].abs());
}
