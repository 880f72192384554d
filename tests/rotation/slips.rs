//! Slips in the record of impacts: tangential restitution, and fraction of the impacts in which the surfaces slide
//! from beginning to end.

use super::*;

/// Tangential restitution of one bounce in an engine, and true if the surfaces slide from beginning to end. `start` is
/// the angle of impact [°] and radius times spin over speed.
fn recorded(surfaces: &Surfaces, start: (f64, f64), engine: Box<dyn Engine>) -> (f64, bool) {
    let (scene, particles) = thrown(surfaces, surfaces.of_spring(), start);
    let mut simulation = Simulation::with_engine(scene, particles, engine);
    simulation.run(20, 1e-5).unwrap();
    let summary = simulation.record.walls.summary();
    (summary.tangential_restitution.unwrap(), summary.share_sliding.unwrap() == 1.0)
}

/// The slip is v_t - R ω (tangential velocity, radius, spin). The reference values of the spring determine the ratio
/// of the slips and the tangential impulse m |Δv_t|. If the surfaces slide all the time, this impulse is μ (1 + e) m
/// v_n.
#[test]
fn impacts_record_the_change_of_slip() {
    let mut sliding = 0;
    for (surfaces, angle, spin, [velocity, turn], _) in AT_WALL {
        let (sin, cos) = f64::to_radians(*angle).sin_cos();
        let (before, after) = (sin - spin, velocity - turn);
        let expected = -after / before;
        let at_limit = (sin - velocity).abs() / (surfaces.friction * (1.0 + surfaces.restitution) * cos);
        sliding += usize::from(at_limit > 0.999);
        let e = surfaces.restitution;
        let hybrid =
            Hybrid::new(ContactLaw::linear(STIFFNESS), Integrator::VelocityVerlet, contact_time(e) / 50.0, 2.0);
        let engines: [(&str, Box<dyn Engine>, f64); 5] = [
            ("hard", Box::new(Hard::new()), 1e-5),
            ("stepped hard", Box::new(SteppedHard::new(0.3)), 1e-5),
            ("hybrid", Box::new(hybrid), 1e-5),
            ("local", soft(e, 100.0, SoftStepping::Local), 1e-4),
            // error of first order, because the instant of the touch is known to one step
            ("uniform", soft(e, 400.0, SoftStepping::Uniform), 2e-2),
        ];
        for (name, engine, tolerance) in engines {
            let (found, slides) = recorded(surfaces, (*angle, *spin), engine);
            // the reference has nine decimals, for velocities over the approach velocity
            let apart = (found - expected).abs() * before.abs();
            assert!(apart < tolerance, "{name}, e {e}, {angle}°, {spin}: {found} and {expected}");
            assert_eq!(slides, at_limit > 0.999, "{name}, e {e}, {angle}°, {spin}: {at_limit}");
        }
    }
    assert!((5..AT_WALL.len() - 5).contains(&sliding), "{sliding}");
}

/// Impacts of spheres that do not rotate have no slips in their record.
#[test]
fn slips_are_recorded_where_spheres_rotate() {
    let (mut scene, mut particles) = thrown(&W3, W3.walton(), (30.0, 0.0));
    (scene.rotation, particles.spin, particles.inertia) = (None, None, None);
    let mut simulation = Simulation::with_engine(scene, particles, soft(0.8, 50.0, SoftStepping::Local));
    simulation.run(20, 1e-5).unwrap();
    let summary = simulation.record.walls.summary();
    assert_eq!((summary.count, summary.tangential_restitution, summary.share_sliding), (1, None, None));
}
