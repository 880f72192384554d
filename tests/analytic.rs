//! Impacts of two bodies, and of a sphere on a wall, against closed-form solutions. "Oracle A1" and so on are sections
//! of a catalogue of reference values that were computed independently.
//!
//! The tolerances allow for the truncation errors of the soft engine, with x = ω_0 Δt = π sqrt(1-ζ²)/N_c. Here ω_0 is
//! the undamped frequency of the contact, ζ its damping ratio, γ its damping, Δt the time step and N_c the number of
//! steps per contact. The schemes are of second order (x²). A contact that is detected at the end of a step misses up
//! to one step of the dashpot. The force of the dashpot jumps to 2 γ M u at first touch (2 ζ x of the impulse; M:
//! effective mass, u: speed).

use crate::support::*;
use diptych::engine::hard::impulse;
use diptych::experiment::Integrator;
use diptych::particles::Particles;
use diptych::scene::Species;
use diptych::simulation::Simulation;
use nalgebra::Vector3;

/// Simulation of a head-on pair at 1 m/s, after its contact of stiffness `k` [N/m]. The contact begins a fraction
/// `phase` (0, 1] of a step before the end of a step, and lasts `steps_per_contact` steps.
fn head_on_run(restitution: f64, steps_per_contact: f64, integrator: Integrator, phase: f64, k: f64) -> Simulation {
    let scene = empty([0.01, 0.01, 0.01], [false; 3], small(), surface(restitution, 0.0));
    let law = LinearSpring { stiffness: k };
    let m = 0.5 * scene.species[0].mass();
    let dt = law.contact_time(m, restitution) / steps_per_contact;
    let d = scene.species[0].diameter;
    let gap = dt * (1.0 + phase);
    let particles = placed(
        &scene,
        &[([0.005, 0.005, 0.005], [0.5, 0.0, 0.0]), ([0.005 + d + gap, 0.005, 0.005], [-0.5, 0.0, 0.0])],
    );
    let steps = (2.0 * steps_per_contact) as u64 + 4;
    run(&scene, particles, soft(k, dt * (1.0 + 1e-12), integrator), steps as f64 * dt, 1)
}

fn head_on(restitution: f64, steps_per_contact: f64, integrator: Integrator, phase: f64) -> f64 {
    let end = head_on_run(restitution, steps_per_contact, integrator, phase, 3000.0);
    end.particles.velocity[1].x - end.particles.velocity[0].x
}

#[test]
fn contact_time_overlap_and_restitution_of_a_pair() {
    // oracle A1: e, ω_0 T_c, δ_max ω_0/u_0; free space, 1 m/s, centres 1.5 d apart, N_c = 200
    for (e, contact_time, overlap) in [
        (1.0, std::f64::consts::PI, 1.000000000),
        (0.98, 3.141657612, 0.989990432),
        (0.94, 3.142201930, 0.969912093),
        (0.9, 3.143358910, 0.949750530),
        (0.8, 3.149507493, 0.898943455),
        (0.5, 3.217150512, 0.741810737),
        (0.1, 3.895061298, 0.502721970),
    ] {
        let scene = empty([0.01, 0.01, 0.01], [false; 3], small(), surface(e, 0.0));
        let law = LinearSpring { stiffness: 3000.0 };
        let (m, d) = (scene.species[0].mass(), scene.species[0].diameter);
        let w0 = law.angular_frequency(0.5 * m);
        let zeta = LinearSpring::damping_ratio(e);
        close("w0 Tc of the law", law.contact_time(0.5 * m, e) * w0, contact_time, 1e-9);
        for integrator in BOTH {
            let dt = law.contact_time(0.5 * m, e) / 200.0;
            let x = w0 * dt;
            let mut mean = 0.0;
            let mut last = None;
            for phase in 1..=20 {
                // centres 1.5 d apart, plus a fraction of a step, so that the contact begins anywhere within a step
                let apart = 1.5 * d + dt * f64::from(phase) / 20.0;
                let start =
                    [([0.005, 0.005, 0.005], [0.5, 0.0, 0.0]), ([0.005 + apart, 0.005, 0.005], [-0.5, 0.0, 0.0])];
                let end = run(&scene, placed(&scene, &start), soft(3000.0, dt, integrator), 0.5 * d + 400.0 * dt, 1);
                let seen = end.record.pairs.summary();
                assert_eq!(seen.count, 1);
                // a contact begins and ends at the ends of steps, with an error of up to one step in 200 each; the
                // dashpot force of the missed part is missing
                close("w0 Tc", seen.mean_duration.unwrap() * w0, contact_time, 0.01 * contact_time);
                let got = seen.mean_maximum_overlap.unwrap() * d * w0;
                close(&format!("overlap e={e} {integrator:?}"), got, overlap, overlap * (1e-4 + 2.0 * zeta * x));
                let got = end.particles.velocity[1].x - end.particles.velocity[0].x;
                close(&format!("restitution e={e} {integrator:?}"), got, e, 1e-5 + 2.0 * zeta * x);
                close("realised restitution as recorded", seen.mean_restitution.unwrap(), got, 1e-12);
                mean += got / 20.0;
                last = Some(end);
            }
            if e >= 0.5 {
                close("mean restitution as the oracle asks", mean, e, 2e-3 * e);
            }
            let Some(end) = last else { unreachable!() };
            assert!(end.particles.momentum().norm() <= 1e-14 * m, "momentum {}", end.particles.momentum().norm() / m);
        }
    }
}

#[test]
fn overlap_history_follows_the_damped_oscillator() {
    // oracle A1: δ(t) = u_0/W exp(-ζ ω_0 t) sin(W t)
    for (e, integrator) in [1.0, 0.94, 0.5].into_iter().flat_map(|e| BOTH.map(|i| (e, i))) {
        let scene = empty([0.01, 0.01, 0.01], [false; 3], small(), surface(e, 0.0));
        let law = LinearSpring { stiffness: 3000.0 };
        let (m, d) = (scene.species[0].mass(), scene.species[0].diameter);
        let (w0, zeta) = (law.angular_frequency(0.5 * m), LinearSpring::damping_ratio(e));
        let w = w0 * (1.0 - zeta * zeta).sqrt();
        let dt = law.contact_time(0.5 * m, e) / 200.0;
        // the touch is at the end of a step, so that the error is that of the scheme alone
        let gap = 3.0 * dt;
        let start = [([0.005, 0.005, 0.005], [0.5, 0.0, 0.0]), ([0.005 + d + gap, 0.005, 0.005], [-0.5, 0.0, 0.0])];
        let mut simulation =
            Simulation::with_engine(scene.clone(), placed(&scene, &start), soft(3000.0, dt * (1.0 + 1e-9), integrator));
        let (mut worst, mut deepest): (f64, f64) = (0.0, 0.0);
        for step in 1..=203 {
            simulation.run(1, dt).unwrap();
            let t = (f64::from(step) - 3.0) * dt;
            if t > 0.0 {
                let x = &simulation.particles.position;
                let overlap = d - (x[1] - x[0]).norm();
                let want = (-zeta * w0 * t).exp() * (w * t).sin() / w;
                worst = worst.max((overlap - want).abs() * w0);
                deepest = deepest.max(overlap * w0);
            }
        }
        let x = w0 * dt;
        println!("{integrator:?} e={e}: worst error {worst:.2e} of u0/w0");
        // rounding decides whether the step of first touch belongs to the contact; the error is that of one step of the
        // dashpot
        assert!(worst < x * x + 2.0 * zeta * x, "{integrator:?} e={e}: {worst}");
        assert!(deepest > 0.5);
    }
}

#[test]
fn contact_times_of_the_papers_particles() {
    // oracle A1, paper-sized
    let law = |stiffness| LinearSpring { stiffness };
    let (s, l) = (small().mass(), large().mass());
    close("w0 of S", law(3000.0).angular_frequency(0.5 * s), 4.06152e5, 1.0);
    close("S pair", law(3000.0).contact_time(0.5 * s, 1.0), 7.73502e-6, 1e-11);
    close("S wall", law(3000.0).contact_time(s, 1.0), 1.09390e-5, 1e-10);
    close("L pair", law(5000.0).contact_time(0.5 * l, 1.0), 4.24254e-5, 1e-10);
    close("L wall", law(5000.0).contact_time(l, 1.0), 5.99986e-5, 1e-10);
}

/// True if the oscillation of a sphere between two walls grows. The sphere is squeezed, so that it always touches both
/// walls. `x` [-] is the undamped angular frequency of both contacts together times the time step.
fn grows(restitution: f64, integrator: Integrator, x: f64) -> bool {
    // two springs and two dashpots act: ω_0² and γ double, so ζ is sqrt 2 times that of one wall
    let zeta = LinearSpring::damping_ratio(restitution) / 2.0f64.sqrt();
    let wall = surface((-std::f64::consts::PI * zeta / (1.0 - zeta * zeta).sqrt()).exp(), 0.0);
    let mut scene = empty([4.0, 0.6, 4.0], [false; 3], unit(), surface(1.0, 0.0));
    scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], wall), plane([0.0, 0.6, 0.0], [0.0, -1.0, 0.0], wall)];
    let start = placed(&scene, &[([2.0, 0.3 + 1e-7, 2.0], [0.0; 3])]);
    let dt = x / (2.0 / start.mass[0]).sqrt();
    let mut simulation = Simulation::with_engine(scene, start, soft(1.0, dt * (1.0 + 1e-9), integrator));
    // largest speeds in the first and in the last 40 steps
    let mut speeds = [0.0f64; 2];
    for k in 0..40_000 {
        if simulation.run(1, dt).is_err() {
            return true;
        }
        if !(40..39_960).contains(&k) {
            let speed = &mut speeds[usize::from(k >= 40)];
            *speed = speed.max(simulation.particles.velocity[0].y.abs());
        }
    }
    speeds[1] > 2.0 * speeds[0]
}

#[test]
fn stability_limits_of_the_schemes() {
    // oracle A3: the largest stable ω_0 Δt; 40000 steps distinguish growth from decay within 1 % of the limit
    use Integrator::{Rk2, VelocityVerlet};
    for (integrator, e, limit) in [
        (VelocityVerlet, 1.0, 2.0),
        (VelocityVerlet, 0.94, 1.961),
        (VelocityVerlet, 0.5, 1.615),
        (VelocityVerlet, 0.1, 1.141),
        (Rk2, 0.94, 0.566),
        (Rk2, 0.5, 1.437),
        (Rk2, 0.1, 2.104),
    ] {
        assert!(!grows(e, integrator, 0.99 * limit), "{integrator:?} e={e} grows below its limit {limit}");
        assert!(grows(e, integrator, 1.01 * limit), "{integrator:?} e={e} is stable above its limit {limit}");
    }
    // RK2 without damping grows at any step: |R|² = 1 + x⁴/4
    assert!(grows(1.0, Rk2, 0.22));
    assert!(!grows(1.0, VelocityVerlet, 0.22));
}

#[test]
fn realised_restitution_against_steps_per_contact() {
    // oracle A4: mean, smallest and largest over 200 phases of first touch
    use Integrator::{Rk2, VelocityVerlet};
    let rows: &[(Integrator, f64, f64, f64, Option<(f64, f64)>)] = &[
        (VelocityVerlet, 1.0, 5.0, 1.0001, Some((0.984, 1.016))),
        (VelocityVerlet, 1.0, 10.0, 1.00000, Some((0.9980, 1.0020))),
        (VelocityVerlet, 1.0, 15.0, 1.00000, Some((0.9994, 1.0006))),
        (VelocityVerlet, 1.0, 50.0, 1.00000, None),
        (VelocityVerlet, 0.94, 5.0, 0.9410, Some((0.918, 0.982))),
        (VelocityVerlet, 0.94, 10.0, 0.94009, Some((0.936, 0.954))),
        (VelocityVerlet, 0.94, 15.0, 0.94000, None),
        (VelocityVerlet, 0.94, 50.0, 0.93998, None),
        (VelocityVerlet, 0.5, 5.0, 0.4926, Some((0.387, 0.607))),
        (VelocityVerlet, 0.5, 10.0, 0.4909, Some((0.454, 0.542))),
        (VelocityVerlet, 0.5, 15.0, 0.4930, None),
        (VelocityVerlet, 0.5, 50.0, 0.4976, None),
        (VelocityVerlet, 0.1, 10.0, 0.0596, None),
        (VelocityVerlet, 0.1, 15.0, 0.0734, None),
        (VelocityVerlet, 0.1, 50.0, 0.0919, None),
        (Rk2, 1.0, 5.0, 1.0776, Some((1.0470, 1.1129))),
        (Rk2, 1.0, 7.735, 1.0230, None),
        (Rk2, 1.0, 10.0, 1.01089, Some((1.0052, 1.0168))),
        (Rk2, 1.0, 15.0, 1.00335, Some((1.0015, 1.0053))),
        (Rk2, 1.0, 50.0, 1.00010, Some((1.0000, 1.0002))),
        (Rk2, 0.94, 5.0, 1.0078, Some((0.9718, 1.0643))),
        (Rk2, 0.94, 10.0, 0.94857, Some((0.9414, 0.9646))),
        (Rk2, 0.94, 15.0, 0.94237, Some((0.9397, 0.9513))),
        (Rk2, 0.94, 50.0, 0.94001, Some((0.9399, 0.9423))),
        (Rk2, 0.5, 5.0, 0.5146, Some((0.434, 0.653))),
        (Rk2, 0.5, 10.0, 0.4962, Some((0.479, 0.560))),
        (Rk2, 0.5, 15.0, 0.4972, Some((0.490, 0.541))),
        (Rk2, 0.5, 50.0, 0.49957, Some((0.499, 0.513))),
        (Rk2, 0.1, 5.0, 0.087, Some((0.045, 0.146))),
        (Rk2, 0.1, 10.0, 0.091, Some((0.066, 0.138))),
        (Rk2, 0.1, 15.0, 0.0955, Some((0.079, 0.108))),
        (Rk2, 0.1, 50.0, 0.0996, Some((0.095, 0.104))),
    ];
    let mut wrong = Vec::new();
    for &(integrator, e, nc, mean, range) in rows {
        let values: Vec<f64> = (1..=200).map(|k| head_on(e, nc, integrator, f64::from(k) / 200.0)).collect();
        let got = values.iter().sum::<f64>() / 200.0;
        let (low, high) = values.iter().fold((f64::INFINITY, 0.0f64), |(l, h), &v| (l.min(v), h.max(v)));
        let row = format!("{integrator:?} e={e} N_c={nc}: {got:.5} [{low:.4}, {high:.4}], oracle {mean} {range:?}");
        println!("{row}");
        let tolerance = if nc < 10.0 || e < 0.2 { 0.01 } else { 0.002 };
        let slack = if e < 0.2 { 0.01 } else { 0.002 };
        let inside = range.is_none_or(|(a, b)| a - slack <= low && high <= b + slack);
        if (got - mean).abs() > tolerance || !inside {
            wrong.push(row);
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn first_seen_overlap_is_uniform_and_knows_no_stiffness() {
    // oracle A5: δ_0 = u s, s uniform on (0, Δt]: mean u Δt/2, largest u Δt
    let d = small().diameter;
    let m = 0.5 * small().mass();
    let mut means = Vec::new();
    for (k, nc) in [(3000.0, 40.0), (300.0, 40.0 * 10.0f64.sqrt())] {
        let dt = LinearSpring { stiffness: k }.contact_time(m, 1.0) / nc;
        let overlaps: Vec<f64> = (1..=100)
            .map(|i| head_on_run(1.0, nc, Integrator::VelocityVerlet, f64::from(i) / 100.0, k))
            // the overlap is the motion in the part of the step after the touch
            .map(|end| end.record.pairs.summary().mean_first_overlap.unwrap() * d / dt)
            .collect();
        let mean = overlaps.iter().sum::<f64>() / 100.0;
        assert!(overlaps.iter().all(|o| (0.0..=1.0 + 1e-9).contains(o)));
        close("mean in u dt", mean, 0.5, 0.011);
        means.push(mean);
    }
    close("mean for a tenth of the stiffness", means[0], means[1], 0.011);
}

#[test]
fn normal_restitution_is_the_one_asked_for() {
    // oracle B1: e' = e for pairs and walls; exactly for hard spheres, e = 0 included
    let d = small().diameter;
    for e in [1.0, 0.98, 0.94, 0.9, 0.8, 0.5, 0.1, 0.0] {
        let mut scene = empty([0.01, 0.01, 0.01], [false; 3], small(), surface(e, 0.0));
        let pair = [([0.004, 0.005, 0.005], [10.0, 0.0, 0.0]), ([0.005, 0.005, 0.005], [-10.0, 0.0, 0.0])];
        for engine in [hard(), stepped(0.3)] {
            let end = run(&scene, placed(&scene, &pair), engine, 1e-4, 3);
            assert_eq!(end.record.pairs.count, 1, "e = {e}");
            close("pair", end.particles.velocity[1].x, 10.0 * e, 1e-14);
            close("momentum", end.particles.velocity[0].x + end.particles.velocity[1].x, 0.0, 1e-14);
        }
        scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], surface(e, 0.0))];
        let ball = [([0.005, 0.5 * d + 1e-4, 0.005], [0.0, -0.2, 0.0])];
        for engine in [hard(), stepped(0.3)] {
            let end = run(&scene, placed(&scene, &ball), engine, 1e-3, 40);
            assert_eq!(end.record.walls.count, 1, "e = {e}");
            close("wall", end.particles.velocity[0].y, 0.2 * e, 1e-15);
        }
        if e > 0.0 {
            let law = LinearSpring { stiffness: 3000.0 };
            let dt = law.contact_time(small().mass(), e) / 400.0;
            let end = run(&scene, placed(&scene, &ball), soft(3000.0, dt, Integrator::VelocityVerlet), 1e-3, 1);
            let (zeta, x) = (LinearSpring::damping_ratio(e), std::f64::consts::PI / 400.0);
            close("soft wall", end.particles.velocity[0].y, 0.2 * e, 0.2 * (x * x + 2.0 * zeta * x));
            if e == 1.0 {
                // peak force u_0 sqrt(k M)
                let force = 3000.0 * end.record.walls.summary().largest_overlap.unwrap() * d;
                let want = 0.2 * (3000.0 * small().mass()).sqrt();
                close("peak force", force, want, 1e-4 * want);
            }
        }
    }
}

/// Oblique impacts on a wall: tangential and normal speed before the impact, restitution, friction, then the
/// tangential speed after it, of hard and of soft spheres. The soft value includes the attractive dashpot force at the
/// end of a contact.
const OBLIQUE: [(f64, f64, f64, f64, f64, f64); 7] = [
    (1.0, 1.0, 1.0, 0.325, 0.350000, 0.350000),
    (1.0, 1.0, 0.94, 0.325, 0.369500, 0.369026),
    (2.0, 0.5, 0.94, 0.325, 1.684750, 1.684513),
    (0.3, 1.0, 0.94, 0.325, 0.0, 0.0),
    (1.0, 1.0, 0.5, 0.325, 0.512500, 0.479816),
    (1.0, 1.0, 0.1, 0.325, 0.642500, 0.543226),
    (3.0, 1.0, 0.8, 0.5, 2.100000, 2.091901),
];

fn oblique_wall(e: f64, mu: f64, vt: f64, vn: f64, engine: Box<dyn diptych::engine::Engine>) -> Simulation {
    let mut scene = empty([0.01, 0.01, 0.01], [false; 3], small(), surface(1.0, 0.0));
    scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], surface(e, mu))];
    let ball = [([0.005, 0.5 * small().diameter + 1e-5, 0.005], [0.6 * vt, -vn, 0.8 * vt])];
    run(&scene, placed(&scene, &ball), engine, 2e-4, 2)
}

#[test]
fn friction_without_rotation_at_a_wall() {
    // oracle B4
    for (vt, vn, e, mu, want_hard, want_soft) in OBLIQUE {
        let end = oblique_wall(e, mu, vt, vn, hard());
        let v = end.particles.velocity[0];
        close("hard, along x", v.x, 0.6 * want_hard, 1e-14);
        close("hard, along z", v.z, 0.8 * want_hard, 1e-14);
        close("hard, normal", v.y, e * vn, 1e-14);
        let law = LinearSpring { stiffness: 3000.0 };
        let m = small().mass();
        let dt = law.contact_time(m, e) / 400.0;
        let (zeta, x) = (LinearSpring::damping_ratio(e), law.angular_frequency(m) * dt);
        for integrator in BOTH {
            let end = oblique_wall(e, mu, vt, vn, soft(3000.0, dt, integrator));
            let v = end.particles.velocity[0];
            let got = 0.6 * v.x + 0.8 * v.z;
            println!("{integrator:?} vt={vt} e={e}: {got:.6}, oracle {want_soft}");
            // friction is proportional to the normal impulse, which lacks up to a step of the dashpot
            let tolerance = mu * vn * (x * x + 2.0 * zeta * x);
            close("soft", got, want_soft, if want_soft == 0.0 { mu * vn * x } else { tolerance });
            close("soft, across the slip", 0.8 * v.x - 0.6 * v.z, 0.0, 1e-13);
            assert!(got > -1e-15, "the slip must not turn round: {got}");
        }
    }
}

#[test]
fn friction_acts_on_the_relative_slip_of_a_pair() {
    // oracle B4 for a pair: M u replaces m v, so that relative velocities change equally
    for (vt, vn, e, mu, want, _) in OBLIQUE {
        let scene = empty([0.01, 0.01, 0.01], [false; 3], small(), surface(e, mu));
        let d = small().diameter;
        let drift = Vector3::new(0.0, 0.7, -0.3);
        let velocity = |s: f64| (drift + Vector3::new(-s * 0.5 * vn, 0.0, s * 0.5 * vt)).into();
        // positions for which the line of centres at touch is the x axis
        let tau = 1e-5;
        let start = [
            ([0.005 + d + 0.5 * vn * tau, 0.005, 0.005 - 0.5 * vt * tau], velocity(1.0)),
            ([0.005 - 0.5 * vn * tau, 0.005, 0.005 + 0.5 * vt * tau], velocity(-1.0)),
        ];
        let end = run(&scene, placed(&scene, &start), hard(), 2.0 * tau, 1);
        let u = end.particles.velocity[0] - end.particles.velocity[1];
        close("tangential", u.z, want, 1e-11);
        close("normal", u.x, e * vn, 1e-11);
        let mean = 0.5 * (end.particles.velocity[0] + end.particles.velocity[1]);
        assert!((mean - drift).norm() < 1e-15);
    }
}

#[test]
fn no_slip_no_friction() {
    // oracle B4: v_t = 0 exactly must not lead to 0/0
    for (engine, tolerance) in [
        (hard(), 1e-15),
        (soft(3000.0, 1e-8, Integrator::VelocityVerlet), 1e-2),
        (soft(3000.0, 1e-8, Integrator::Rk2), 1e-2),
    ] {
        let v = oblique_wall(0.9, 0.5, 0.0, 1.0, engine).particles.velocity[0];
        assert_eq!((v.x, v.z), (0.0, 0.0));
        close("normal", v.y, 0.9, tolerance);
    }
}

#[test]
fn oblique_impact_of_two_sizes_without_rotation() {
    // oracle B6, "rotation off": 0.2 mm of 1038 kg/m3 against 0.75 mm (radii) of 1032 kg/m3
    let sizes = [Species::new("1", 0.4e-3, 1038.0), Species::new("2", 1.5e-3, 1032.0)];
    let mut scene = empty([0.01, 0.01, 0.01], [false; 3], sizes[0].clone(), surface(0.94, 0.325));
    scene.species = sizes.to_vec();
    let n = Vector3::new(2.0, -1.0, 2.0) / 3.0;
    let (v1, v2) = (Vector3::new(-1.0, 0.5, 0.2), Vector3::new(0.3, -0.2, 0.1));
    let want =
        [Vector3::new(0.680239712, -0.370295095, 1.035333025), Vector3::new(0.267952431, -0.183400677, 0.084067516)];
    let centre = Vector3::new(0.005, 0.005, 0.005);
    let tau = 2e-5;
    let mut particles = Particles::default();
    particles.push(centre + n * 0.95e-3 - v1 * tau, v1, 0.2e-3, sizes[0].mass(), 0);
    particles.push(centre - v2 * tau, v2, 0.75e-3, sizes[1].mass(), 1);
    let end = run(&scene, particles, hard(), 2.0 * tau, 1);
    for (got, want) in end.particles.velocity.iter().zip(&want) {
        // the reference values have nine decimals
        assert!((got - want).norm() < 2e-9, "{got} {want}");
    }
    // the collision rule itself, without an engine
    let m = 1.0 / (1.0 / sizes[0].mass() + 1.0 / sizes[1].mass());
    let j = impulse(&scene.contact, m, &(v1 - v2), &n);
    assert!((v1 + j / sizes[0].mass() - want[0]).norm() < 1e-9);
}
