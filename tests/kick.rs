//! The drag kick (change of velocity by drag in a window) from a table, compared with the drag law.

use crate::support::{hard, large, run, small, surface};
use diptych::domain::Domain;
use diptych::drag::{Drag, DragLaw, Kick, SchillerNaumann, Sphere, Stokes};
use diptych::fluid::{Fluid, Profile};
use diptych::particles::Particles;
use diptych::scene::Scene;
use diptych::simulation::kick;
use nalgebra::Vector3;

const LAW: Drag = Drag::SchillerNaumann(SchillerNaumann);
const DURATIONS: [f64; 6] = [1e-6, 1.3e-5, 1e-4, 7e-4, 3e-3, 1e-2];
/// Accuracy of the table, relative to the change of velocity.
const ACCURACY: f64 = 1e-9;

fn gas(profile: Profile) -> Fluid {
    Fluid::new(1.205, 1.515e-5, profile, Some(LAW))
}

/// The paper's two spheres in its gas.
fn spheres() -> [Sphere; 2] {
    [small(), large()].map(|species| gas(Profile::Uniform(0.0)).sphere(&species))
}

fn logarithmic(low: f64, high: f64, count: usize) -> impl Iterator<Item = f64> {
    (0..=count).map(move |i| low * (high / low).powf(i as f64 / count as f64))
}

/// Numbers in [0, 1) without a visible pattern: fractional parts of multiples of the golden ratio.
fn scattered(i: usize) -> f64 {
    (i as f64 * 0.618_033_988_749_895).fract()
}

/// Particles of both species in a channel, with slip speeds from almost zero to that of the free stream.
fn cloud(count: usize, profile: &Profile) -> Particles {
    let mut particles = Particles::default();
    for i in 0..count {
        let x = Vector3::new(0.0, 0.03 * scattered(i), 0.0);
        let slip = 10_f64.powf(8.0 * scattered(7 * i) - 7.0);
        let v = Vector3::new(0.3 * slip, -0.2 * slip, profile.velocity(x.y) + slip);
        let species = (i % 2) as u16;
        particles.push(x, v, 1e-4, 1e-8 * (1.0 + scattered(3 * i)), species);
    }
    particles
}

#[test]
fn table_is_the_law() {
    let mut largest: f64 = 0.0;
    for law in &[LAW, Drag::Stokes(Stokes)] {
        for duration in DURATIONS {
            let table = Kick::tabulated(law, &spheres(), duration);
            for (species, sphere) in (0..).zip(&spheres()) {
                // slip speeds in every decade, and on both sides of Re = 1000 at relative distances from one rounding
                // error to a tenth
                let switch = 1000.0 / sphere.reynolds_per_speed;
                let near = logarithmic(1e-16, 0.1, 2000).flat_map(|d| [switch * (1.0 - d), switch * (1.0 + d)]);
                for slip in logarithmic(1e-12, 50.0, 60_000).chain(near).chain([0.0, 65.0, 1e6]) {
                    let square = slip * slip;
                    let change = table.change(species, square);
                    // compared at the slip speed given to the table: at the jump of the law, the last digit of the
                    // square decides on the formula
                    let exact = law.law().change(sphere, square.sqrt(), duration);
                    let error = (change / exact - 1.0).abs();
                    assert!(error < ACCURACY, "{law:?} {species}, {slip} m/s, {duration} s: off by {error:e}");
                    let ratio = law.law().decay(sphere, slip, duration);
                    // the plain formula, to the precision of its digits; its square root loses one digit, and the jump
                    // of 0.4 % is left out
                    let plain = ((1.0 + change) / ratio - 1.0).abs();
                    let digits = 4e-16 + ACCURACY * (1.0 - ratio) / ratio;
                    let jump = (slip / switch - 1.0).abs() < 1e-15;
                    assert!(plain <= digits || jump, "{law:?} {species}, {slip} m/s, {duration} s: {plain:e}");
                    largest = largest.max(error);
                }
            }
        }
    }
    println!("largest error of the change {largest:.1e}");
    assert!(largest > 0.0, "nothing was read from a table");
}

#[test]
fn two_tabulated_kicks_are_one() {
    for duration in DURATIONS {
        let [half, whole] = [0.5, 1.0].map(|part| Kick::tabulated(&LAW, &spheres(), part * duration));
        for species in [0, 1] {
            for slip in logarithmic(1e-9, 50.0, 20_000) {
                let first = half.change(species, slip * slip);
                let rest = slip * (1.0 + first);
                let both = first + (1.0 + first) * half.change(species, rest * rest);
                let once = whole.change(species, slip * slip);
                // at the jump of the law, the last digit of a slip speed decides on the formula
                let switch = 1000.0 / spheres()[species as usize].reynolds_per_speed;
                let error = (both / once - 1.0).abs();
                let jumps = (slip / switch - 1.0).abs() < 1e-14 || (rest / switch - 1.0).abs() < 1e-14;
                assert!(error < 2.0 * ACCURACY || jumps, "{species}, {slip} m/s, {duration} s: off by {error:e}");
            }
        }
    }
}

#[test]
fn change_keeps_its_digits_in_short_kicks() {
    // 1 - ratio tends to t/τ(w), and the next term is of the order (t/τ)²; computed from the ratio, only 5 digits would
    // remain
    for sphere in spheres() {
        for slip in [0.0, 1e-3, 1.0, 9.0, 20.0] {
            let expected = -1e-12 / LAW.law().response_time(&sphere, slip);
            let change = SchillerNaumann.change(&sphere, slip, 1e-12);
            assert!((change / expected - 1.0).abs() < 1e-10, "{slip} m/s: {change} against {expected}");
        }
    }
}

#[test]
fn particles_are_kicked_as_by_the_law() {
    let points: Vec<_> = (0..40).map(|i| f64::from(i) / 39.0).map(|s| (0.03 * s * s, 60.0 * s * (1.0 - s))).collect();
    let profile = Profile::table(&points).unwrap();
    for duration in DURATIONS {
        // 20 011 particles fill more than two chunks, and leave the last chunk and the last block partly empty
        let start = cloud(20_011, &profile);
        let (mut fast, mut exact) = (start.clone(), start.clone());
        let by_table = kick(&mut fast, &profile, &Kick::tabulated(&LAW, &spheres(), duration));
        let by_law = kick(&mut exact, &profile, &Kick::exact(&LAW, &spheres(), duration));
        let (mut sum, mut energy, mut turnover) = (Vector3::zeros(), 0.0, 0.0);
        for i in 0..start.len() {
            let u = Vector3::new(0.0, 0.0, profile.velocity(start.position[i].y));
            let slip = start.velocity[i] - u;
            let plain = u + slip * LAW.law().decay(&spheres()[i % 2], slip.norm(), duration);
            let change = (plain - start.velocity[i]).norm();
            // a velocity near 16 m/s has a rounding error of 2e-15 m/s
            for velocity in [fast.velocity[i], exact.velocity[i]] {
                let error = (velocity - plain).norm();
                assert!(error <= ACCURACY * change + 1e-14, "particle {i}: {error:e} of {change:e} m/s");
            }
            let m = start.mass[i];
            sum += m * (plain - start.velocity[i]);
            energy += 0.5 * m * (plain.norm_squared() - start.velocity[i].norm_squared());
            turnover += 0.5 * m * (plain.norm_squared() + start.velocity[i].norm_squared());
        }
        for sums in [by_table, by_law] {
            let [x, y, z, work] = diptych::exact::values(&sums);
            let impulse = Vector3::new(x, y, z);
            assert!((impulse - sum).norm() < 1e-9 * sum.norm(), "impulse {impulse:?} against {sum:?}");
            assert!((work - energy).abs() < 1e-9 * energy.abs() + 1e-14 * turnover, "work {work} against {energy}");
        }
    }
}

#[test]
fn simulation_follows_the_exact_flow() {
    // One particle per column of a lattice, all along z in a uniform gas, so that no particles meet. Then 50 windows
    // equal one exact kick. The 1225 particles are enough for a table to be used.
    let side = 35;
    let scene = Scene {
        fluid: Some(gas(Profile::Uniform(8.0))),
        ..Scene::new(Domain::new(Vector3::new(0.1, 0.1, 0.1), [true; 3]), surface(1.0, 0.0), vec![small(), large()])
    };
    let mut particles = Particles::default();
    for i in 0..side * side {
        let species = &scene.species[i % 2];
        let x = Vector3::new((i % side) as f64 + 0.5, (i / side) as f64 + 0.5, 17.5) * (0.1 / side as f64);
        let v = Vector3::new(0.0, 0.0, 30.0 * scattered(i) - 10.0);
        particles.push(x, v, 0.5 * species.diameter, species.mass(), (i % 2) as u16);
    }
    let start = particles.clone();
    let end = run(&scene, particles, hard(), 0.05, 50);
    assert_eq!((end.record.ledger.drag_impulse.x, end.record.ledger.drag_impulse.y), (0.0, 0.0));
    for i in 0..start.len() {
        let slip = start.velocity[i].z - 8.0;
        let exact = slip * LAW.law().change(&spheres()[i % 2], slip.abs(), 0.05);
        let change = end.particles.velocity[i].z - start.velocity[i].z;
        assert!((change - exact).abs() <= 1e-9 * exact.abs() + 1e-13, "particle {i}: {change} against {exact} m/s");
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let profile = Profile::table(&[(0.0, 0.0), (0.01, 12.0), (0.03, 0.0)]).unwrap();
    let table = Kick::tabulated(&LAW, &spheres(), 1e-4);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut particles = cloud(50_021, &profile);
        let sums: Vec<_> = (0..5).map(|_| pool.install(|| kick(&mut particles, &profile, &table))).collect();
        (particles, sums)
    };
    let one = with(1);
    assert!(one.1[0][3].value() != 0.0);
    for threads in [2, 3] {
        assert!(with(threads) == one, "{threads} threads");
    }
}
