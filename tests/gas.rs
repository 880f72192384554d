//! Many spheres at equilibrium, against the equation of state and kinetic theory (oracle D), and conserved quantities.

use crate::support::*;
use diptych::engine::Engine;
use diptych::experiment::Integrator;
use diptych::particles::Particles;
use diptych::scene::Scene;
use diptych::simulation::Simulation;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Unit spheres in a periodic cube with the volume fraction `phi`, at the granular temperature 1 m²/s².
fn cube(count: usize, phi: f64, seed: u64) -> (Scene, Particles) {
    let scene = empty([edge(count, 1.0, phi); 3], [true; 3], unit(), surface(1.0, 0.0));
    let mut particles = random(&scene, count, 1.0, seed);
    let scale = 1.0 / temperature(&particles).sqrt();
    particles.velocity.iter_mut().for_each(|v| *v *= scale);
    (scene, particles)
}

/// Mean of the values and its standard error.
fn mean(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

/// Collision rate per particle, compressibility factor minus 1 from the virial of the collisions, and kinetic
/// temperature, each with its standard error from ten blocks of time. Each particle has `equilibrate` collisions
/// before the measurement and `measure` collisions during it.
fn rates(
    scene: &Scene,
    particles: Particles,
    engine: Box<dyn Engine>,
    expected: f64,
    equilibrate: f64,
    measure: f64,
) -> [(f64, f64); 3] {
    let n = particles.len() as f64;
    let mut simulation = Simulation::with_engine(scene.clone(), particles, engine);
    // windows in which a sphere covers a large part of the distance to its neighbours
    let longest = 0.3 * (scene.domain.volume() / n).cbrt();
    let windows = |time: f64| (time / longest).ceil();
    let time = equilibrate / expected;
    simulation.run(windows(time) as u64, time / windows(time)).unwrap();
    let (mut rate, mut pressure, mut kinetic) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..10 {
        let before = (simulation.record.pairs.count, simulation.record.pairs.normal_speed.sum());
        let time = 0.1 * measure / expected;
        simulation.run(windows(time) as u64, time / windows(time)).unwrap();
        let impacts = &simulation.record.pairs;
        rate.push(2.0 * (impacts.count - before.0) as f64 / (n * time));
        // Z - 1 = sum of d J/(3 N T t), with J = m u_n for equal elastic spheres and m = d = T = 1
        pressure.push((impacts.normal_speed.sum() - before.1) / (3.0 * (n - 1.0) * time));
        kinetic.push(temperature(&simulation.particles));
    }
    [mean(&rate), mean(&pressure), mean(&kinetic)]
}

#[test]
fn collision_rate_and_pressure_of_hard_spheres() {
    // oracle D1 (Kolafa, Labik & Malijevsky): Γ σ/sqrt(T) and Z. The tolerance is 3 standard errors + 0.5 %. N
    // particles have the fraction (N-1)/N of the pair density
    for (phi, rate, z) in [
        (0.01, 0.138854, 1.041019),
        (0.05, 0.770069, 1.227485),
        (0.1, 1.765845, 1.521647),
        (0.3, 10.101194, 3.983983),
        (0.45, 28.449080, 9.404114),
    ] {
        let (scene, particles) = cube(1000, phi, 11);
        let [(got, error), (virial, virial_error), _] = rates(&scene, particles, hard(), rate, 60.0, 150.0);
        println!(
            "phi {phi}: rate {got:.5} +- {error:.5}, oracle {rate}; Z-1 {virial:.5} +- {virial_error:.5}, oracle {:.5}",
            z - 1.0
        );
        close(&format!("collision rate at {phi}"), got, rate * 0.999, 3.0 * error + 0.005 * rate);
        close(&format!("Z - 1 at {phi}"), virial, (z - 1.0) * 0.999, 3.0 * virial_error + 0.005 * (z - 1.0));
        assert!(error < 0.01 * rate, "too noisy to tell anything");
    }
}

/// Collision rate of a particle at the granular temperature 1 m²/s² by Carnahan and Starling. Spheres of diameter `d`
/// replace unit spheres that have the volume fraction `phi`.
fn rate_of(phi: f64, d: f64) -> f64 {
    let phi = phi * d.powi(3);
    let contact = (1.0 - 0.5 * phi) / (1.0 - phi).powi(3);
    24.0 * phi * contact / (PI.sqrt() * d)
}

#[test]
fn soft_spheres_collide_as_smaller_ones() {
    // oracle D5: d_eff = σ - sqrt(π m T/(2k)) (Barker & Henderson), here 0.963 σ: at phi = 0.3 there are about 16 %
    // fewer impacts than for hard spheres. Springs store some of the energy (every sixth sphere is in contact), so that
    // T is the measured kinetic temperature. The tolerance is 3 standard errors + 2 % for a theory of first order
    let (phi, s) = (0.3, 0.03);
    let k = 1.0 / (s * s);
    let dt = PI * (0.5f64 / k).sqrt() / 20.0;
    let (scene, particles) = cube(1000, phi, 5);
    let engine = soft(k, dt, Integrator::VelocityVerlet);
    let [(got, error), _, (t, _)] = rates(&scene, particles, engine, 8.0, 30.0, 60.0);
    let hard_rate = rate_of(phi, 1.0) * t.sqrt();
    let want = rate_of(phi, 1.0 - (0.5 * PI * t).sqrt() * s) * t.sqrt();
    println!("T {t:.4}: soft rate {got:.4} +- {error:.4}, effective diameter {want:.4}, hard {hard_rate:.4}");
    assert!((0.85..0.99).contains(&t), "{t}");
    assert!(got < 0.9 * hard_rate);
    close("soft rate", got, want, 3.0 * error + 0.02 * want);
}

#[test]
fn slit_pressure_and_profile() {
    // oracle D2: 12 x 12 x 12, N = 400; P = n_b Z T = 0.4262(14) also on the walls, contact density the same, wall hits
    // n_b Z sqrt(T/2π), profile in bins of 0.05 centred at y - 1/2 = 0.025, 0.125, ...
    const PROFILE: [f64; 15] = [
        0.4004, 0.3637, 0.3312, 0.3005, 0.2750, 0.2564, 0.2412, 0.2323, 0.2270, 0.2317, 0.2408, 0.2456, 0.2508, 0.2488,
        0.2467,
    ];
    let mut scene = empty([12.0; 3], [true, false, true], unit(), surface(1.0, 0.0));
    let wall = surface(1.0, 0.0);
    scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], wall), plane([0.0, 12.0, 0.0], [0.0, -1.0, 0.0], wall)];
    let mut particles = random(&scene, 400, 1.0, 9);
    let scale = (1200.0 / (2.0 * particles.kinetic_energy())).sqrt();
    particles.velocity.iter_mut().for_each(|v| *v *= scale);
    let mut simulation = Simulation::with_engine(scene, particles, hard());
    simulation.run(20, 1.0).unwrap();
    let (samples, window) = (8000u32, 0.25);
    let mut bins = [0u64; 120];
    let mut central = 0u64;
    let (mut pressure, mut hits) = (Vec::new(), Vec::new());
    for _ in 0..20 {
        let before = (simulation.record.ledger.wall_normal_impulse, simulation.record.walls.count);
        for _ in 0..samples / 20 {
            simulation.run(1, window).unwrap();
            for x in &simulation.particles.position {
                let y = x.y.min(12.0 - x.y) - 0.5;
                bins[((y / 0.05) as usize).min(119)] += 1;
                central += u64::from((x.y - 6.0).abs() < 2.0);
            }
        }
        let area_time = 2.0 * 144.0 * window * f64::from(samples / 20);
        pressure.push((simulation.record.ledger.wall_normal_impulse - before.0) / area_time);
        hits.push((simulation.record.walls.count - before.1) as f64 / area_time);
    }
    let ((p, p_error), (hits, hits_error)) = (mean(&pressure), mean(&hits));
    let per_bin = 1.0 / (f64::from(samples) * 2.0 * 144.0 * 0.05);
    let bulk = central as f64 / (f64::from(samples) * 144.0 * 4.0);
    println!("P {p:.4} +- {p_error:.4}, hits {hits:.4} +- {hits_error:.4}, central phi {:.5}", bulk * PI / 6.0);
    close("wall pressure", p, 0.4262, 3.0 * p_error.hypot(0.0014));
    assert!(p_error < 0.01 * p);
    // an exact relation of two measurements in one run: hits = P sqrt(1/(2π T)), with T from E (3N degrees of freedom
    // with walls)
    close("wall hits", hits, p / (2.0 * PI).sqrt(), 3.0 * hits_error + 3.0 * p_error / (2.0 * PI).sqrt());
    close("central volume fraction", bulk * PI / 6.0, 0.12886, 0.01 * 0.12886);
    let mut off = 0.0;
    for (k, want) in PROFILE.iter().enumerate() {
        let got = bins[2 * k] as f64 * per_bin;
        off += (got / want - 1.0).powi(2) / 15.0;
        // two standard errors of 1 % in the reference, and as much in this run
        close(&format!("density {k}"), got, *want, 0.05 * want);
    }
    println!("profile off by {:.2} % rms", 100.0 * off.sqrt());
    assert!(off.sqrt() < 0.02);
    // contact theorem: the density at touch is P/T; a quadratic extrapolation of the first three bins to 0
    let [a, b, c] = [0, 1, 2].map(|k| bins[k] as f64 * per_bin);
    close("contact density", 1.875 * a - 1.25 * b + 0.375 * c, p, 0.05 * p);
}

#[test]
fn hard_spheres_conserve_momentum_and_energy() {
    // oracle D3: over 1e6 events, momentum is conserved to 1e-13 of sum |m v|, and energy to 1e-12
    let (scene, particles) = cube(1000, 0.3, 3);
    let energy = particles.kinetic_energy();
    let momentum = particles.momentum();
    let scale: f64 = particles.velocity.iter().zip(&particles.mass).map(|(v, m)| m * v.norm()).sum();
    let mut simulation = Simulation::with_engine(scene, particles, hard());
    while simulation.record.pairs.count < 1_000_000 {
        simulation.run(10, 0.3).unwrap();
    }
    let off = (simulation.particles.momentum() - momentum).norm() / scale;
    let heat = (simulation.particles.kinetic_energy() / energy - 1.0).abs();
    println!("momentum {off:.1e}, energy {heat:.1e} after {} events", simulation.record.pairs.count);
    assert!(off < 1e-13 && heat < 1e-12);
}

#[test]
fn same_bits_on_any_number_of_threads() {
    // oracle D4, with enough particles for the parallel code (lists, sorting, moving, scanning)
    let mut scene = empty([46.0, 40.0, 46.0], [true, false, true], unit(), surface(0.95, 0.1));
    scene.gravity = Vector3::new(0.0, 0.0, -0.5);
    scene.walls = vec![
        plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.9, 0.1)),
        plane([0.0, 40.0, 0.0], [0.0, -1.0, 0.0], surface(0.9, 0.1)),
    ];
    let start = random(&scene, 24_000, 1.0, 8);
    let k = 1e4;
    let dt = PI * (0.5f64 / k).sqrt() / 20.0;
    let engines: [(&str, fn(f64, f64) -> Box<dyn Engine>, f64); 4] = [
        ("hard", |_, _| hard(), 0.6),
        ("stepped", |_, _| stepped(0.05), 0.6),
        ("verlet", |k, dt| soft(k, dt, Integrator::VelocityVerlet), 0.2),
        ("rk2", |k, dt| soft(k, dt, Integrator::Rk2), 0.1),
    ];
    for (name, engine, duration) in engines {
        let go = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let end = run(&scene, start.clone(), engine(k, dt), duration, 3);
                assert!(end.record.pairs.count > 1000, "{name}");
                let bits = |v: &Vector3<f64>| [v.x.to_bits(), v.y.to_bits(), v.z.to_bits()];
                let state: Vec<_> = end.particles.position.iter().chain(&end.particles.velocity).map(bits).collect();
                (state, *end.record.ledger, end.record.pairs.normal_speed.sum().to_bits(), end.counters())
            })
        };
        let once = go(2);
        for threads in [2, 1, 3] {
            assert!(once == go(threads), "{name} on {threads} threads differs");
        }
    }
}

#[test]
fn overlaps_in_a_gas() {
    // oracle D6: T of the paper's case D, small spheres, k = 3000 N/m, dt = 1e-6 s, phi = 0.05. Largest overlaps over
    // the diameter have a Rayleigh distribution. Overlaps at detection have the mean sqrt(π T) dt/2. The tolerance is 3
    // % for means of > 2e4 impacts
    let (t, k, dt) = (0.4902f64, 3000.0, 1e-6);
    let d = small().diameter;
    let scene = empty([edge(2000, d, 0.05); 3], [true; 3], small(), surface(1.0, 0.0));
    let particles = random(&scene, 2000, t.sqrt(), 21);
    let end = run(&scene, particles, soft(k, dt, Integrator::VelocityVerlet), 0.017, 4);
    let impacts = &end.record.pairs;
    assert!(impacts.count > 20_000, "{}", impacts.count);
    let deepest = &impacts.maximum_overlap;
    println!(
        "{} impacts: mean {:.6}, median {:.6}, 90 % {:.6}, 99 % {:.6}, first {:.6}",
        impacts.count,
        deepest.mean().unwrap(),
        deepest.quantile(0.5).unwrap(),
        deepest.quantile(0.9).unwrap(),
        deepest.quantile(0.99).unwrap(),
        impacts.first_overlap.mean().unwrap()
    );
    close("mean", deepest.mean().unwrap(), 0.007525, 0.03 * 0.007525);
    close("median", deepest.quantile(0.5).unwrap(), 0.007070, 0.03 * 0.007070);
    close("90 %", deepest.quantile(0.9).unwrap(), 0.012885, 0.03 * 0.012885);
    close("99 %", deepest.quantile(0.99).unwrap(), 0.018223, 0.04 * 0.018223);
    close("first seen", impacts.first_overlap.mean().unwrap(), 0.001528, 0.03 * 0.001528);
    close("mean speed", impacts.normal_speed.mean().unwrap(), (PI * t).sqrt(), 0.03 * (PI * t).sqrt());
    // the number of impacts is that of kinetic theory for the effective diameter
    let smaller = 1.0 - (0.5 * PI * t * small().mass() / k).sqrt() / d;
    let rate = rate_of(0.05, smaller) * t.sqrt() / d;
    let got = 2.0 * impacts.count as f64 / 2000.0 / 0.017;
    println!("rate {got:.0}, theory {rate:.0}");
    close("rate", got, rate, 0.03 * rate);
}

#[test]
fn energy_of_an_elastic_gas_after_fifty_collisions() {
    // oracle A4b: N = 1000, phi = 0.1, S, k = 3000 N/m, T = 0.49, dt = 1e-6 s
    let (t, k, dt) = (0.49f64, 3000.0, 1e-6);
    let d = small().diameter;
    let scene = empty([edge(1000, d, 0.1); 3], [true; 3], small(), surface(1.0, 0.0));
    let start = random(&scene, 1000, t.sqrt(), 4);
    let energy = start.kinetic_energy();
    let after = |engine| {
        let mut simulation = Simulation::with_engine(scene.clone(), start.clone(), engine);
        while simulation.record.pairs.count < 25_000 {
            simulation.run(1, 2e-4).unwrap();
        }
        simulation
    };
    close("hard", after(hard()).energy() / energy, 1.0, 1e-10);
    let steps = LinearSpring { stiffness: k }.contact_time(0.5 * small().mass(), 1.0) / dt;
    for integrator in BOTH {
        let simulation = after(soft(k, dt, integrator));
        let gained = (simulation.energy() - energy) / energy;
        let (gain, tolerance) = gain_of_a_gas(&simulation, integrator, steps);
        println!("{integrator:?}: gained {gained:.4}, linear map {:.4} +- {:.4}", gain / energy, tolerance / energy);
        close(&format!("{integrator:?}"), gained, gain / energy, tolerance / energy);
    }
}

#[test]
fn stepped_hard_spheres_approach_the_event_rate() {
    // hard spheres in time steps miss grazing collisions: there are fewer impacts at large theta, and the event rate is
    // approached as theta goes to 0
    let (phi, rate) = (0.1, 1.765845);
    let at = |theta: f64| {
        let (scene, particles) = cube(1000, phi, 13);
        rates(&scene, particles, stepped(theta), rate, 5.0, 20.0)[0]
    };
    let (coarse, fine) = (at(0.3), at(0.01));
    println!("theta 0.3: {coarse:?}, 0.01: {fine:?}, events {rate}");
    assert!(coarse.0 < 0.99 * rate - 3.0 * coarse.1, "{coarse:?}");
    close("theta = 0.01", fine.0, rate, 3.0 * fine.1 + 0.015 * rate);
}
