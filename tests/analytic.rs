//! Closed forms for two bodies and for a sphere and a wall.

use crate::support::*;
use diptych::engine::soft::LinearSpringDashpot;
use diptych::experiment::Integrator;

/// A head-on pair at 1 m/s, gap phase in (0, 1] of a step before contact; returns the realised restitution.
fn head_on(restitution: f64, steps_per_contact: f64, integrator: Integrator, phase: f64) -> f64 {
    let scene = empty([0.01, 0.01, 0.01], [false; 3], small(), surface(restitution, 0.0));
    let law = LinearSpringDashpot { stiffness: 3000.0 };
    let m = 0.5 * scene.species[0].mass();
    let dt = law.contact_time(m, restitution) / steps_per_contact;
    let d = scene.species[0].diameter;
    let gap = dt * (1.0 + phase);
    let particles = placed(
        &scene,
        &[([0.005, 0.005, 0.005], [0.5, 0.0, 0.0]), ([0.005 + d + gap, 0.005, 0.005], [-0.5, 0.0, 0.0])],
    );
    let steps = (2.0 * steps_per_contact) as u64 + 4;
    let end = run(&scene, particles, soft(3000.0, dt * (1.0 + 1e-12), integrator), steps as f64 * dt, 1);
    end.particles.velocity[1].x - end.particles.velocity[0].x
}

#[test]
fn realised_restitution_against_steps_per_contact() {
    // oracle A4
    for (integrator, e, nc, mean, tolerance) in [
        (Integrator::VelocityVerlet, 1.0, 5.0, 1.0001, 0.01),
        (Integrator::VelocityVerlet, 1.0, 10.0, 1.00000, 0.002),
        (Integrator::VelocityVerlet, 0.94, 10.0, 0.94009, 0.002),
        (Integrator::VelocityVerlet, 0.5, 10.0, 0.4909, 0.002),
        (Integrator::VelocityVerlet, 0.5, 50.0, 0.4976, 0.002),
        (Integrator::VelocityVerlet, 0.1, 15.0, 0.0734, 0.01),
        (Integrator::Rk2, 1.0, 5.0, 1.0776, 0.01),
        (Integrator::Rk2, 1.0, 10.0, 1.01089, 0.002),
        (Integrator::Rk2, 0.94, 10.0, 0.94857, 0.002),
        (Integrator::Rk2, 0.5, 15.0, 0.4972, 0.002),
        (Integrator::Rk2, 1.0, 7.735, 1.0230, 0.002),
    ] {
        let values: Vec<f64> = (1..=200).map(|k| head_on(e, nc, integrator, k as f64 / 200.0)).collect();
        let got = values.iter().sum::<f64>() / 200.0;
        println!("{integrator:?} {e} {nc}: {got} want {mean}");
        assert!((got - mean).abs() < tolerance, "{integrator:?} e={e} N_c={nc}: {got}, oracle {mean}");
    }
}
