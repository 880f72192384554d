//! Contact time (time after a collision in which further collisions are elastic) in a dense group of spheres. Impacts
//! that are in progress when the engine changes its way of stepping.

use crate::support::*;
use diptych::contact_law::ContactLaw;
use diptych::engine::Engine;
use diptych::engine::hard::Hard;
use diptych::engine::soft::Soft;
use diptych::experiment::{Integrator, SoftStepping};
use diptych::particles::Particles;
use diptych::scene::Scene;
use diptych::simulation::Simulation;
use nalgebra::Vector3;

/// Hard spheres of unit diameter and mass in a periodic cube, computed by the simplest method: after every collision
/// all pairs are tested again, and all spheres move. The cube is wide compared with the flights between collisions. A
/// collision is elastic if one of the spheres had a collision less than `contact_time` before.
struct BruteForce {
    scene: Scene,
    particles: Particles,
    last: Vec<f64>,
    contact_time: f64,
    restitution: f64,
    /// [J] `kept`: energy that the elastic collisions would have lost with the given restitution. `lost`: energy lost
    /// in the other collisions.
    kept: f64,
    lost: f64,
    collisions: u64,
}

impl BruteForce {
    /// Next colliding pair, and the time until the collision. Pairs that separate do not collide.
    fn next(&self) -> Option<(f64, usize, usize)> {
        let Particles { position: x, velocity: v, .. } = &self.particles;
        let pairs = (0..x.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        let times = pairs.filter_map(|(i, j)| {
            let (r, u) = (self.scene.domain.separation(&x[i], &x[j]), v[i] - v[j]);
            let (closing, gap) = (-r.dot(&u), r.norm_squared() - 1.0);
            let discriminant = closing * closing - u.norm_squared() * gap;
            (closing > 0.0 && discriminant >= 0.0).then(|| (gap.max(0.0) / (closing + discriminant.sqrt()), i, j))
        });
        times.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    fn run(&mut self, duration: f64) {
        let mut now = 0.0;
        loop {
            let next = self.next().filter(|(wait, ..)| now + wait < duration);
            let wait = next.map_or(duration - now, |(wait, ..)| wait);
            for (x, v) in self.particles.position.iter_mut().zip(&self.particles.velocity) {
                *x = self.scene.domain.wrap(&(*x + v * wait));
            }
            now += wait;
            let Some((_, i, j)) = next else { return };
            let n = self.scene.domain.separation(&self.particles.position[i], &self.particles.position[j]).normalize();
            let u = (self.particles.velocity[i] - self.particles.velocity[j]).dot(&n);
            let elastic = now - self.last[i].max(self.last[j]) < self.contact_time;
            let loss = 0.25 * u * u * (1.0 - self.restitution * self.restitution);
            *(if elastic { &mut self.kept } else { &mut self.lost }) += loss;
            let change = 0.5 * (1.0 + if elastic { 1.0 } else { self.restitution }) * u * n;
            self.particles.velocity[i] -= change;
            self.particles.velocity[j] += change;
            (self.last[i], self.last[j]) = (now, now);
            self.collisions += 1;
        }
    }
}

#[test]
fn the_contact_time_in_a_crowd_is_that_of_a_brute_force_reference() {
    // about half of the collisions are elastic because of the contact time
    let (count, phi, restitution, contact_time, duration) = (40, 0.3, 0.7, 0.04, 0.2);
    let scene = empty([edge(count, 1.0, phi); 3], [true; 3], unit(), surface(restitution, 0.0));
    for seed in 1..4 {
        let start = random(&scene, count, 1.0, seed);
        let mut reference = BruteForce {
            scene: scene.clone(),
            particles: start.clone(),
            last: vec![f64::NEG_INFINITY; count],
            contact_time,
            restitution,
            kept: 0.0,
            lost: 0.0,
            collisions: 0,
        };
        reference.run(duration);
        for engine in [Hard::new, Hard::with_one_calendar] {
            let end = run(&scene, start.clone(), Box::new(engine().with_contact_time(Some(contact_time))), duration, 4);
            let ledger = &end.record.ledger;
            println!(
                "seed {seed}: {} collisions, kept {}, lost {}",
                reference.collisions, reference.kept, reference.lost
            );
            assert_eq!(end.record.pairs.count, reference.collisions);
            assert!(reference.collisions > 20 && reference.kept > 0.2 * reference.lost);
            // rounding errors of 1e-16, amplified at each of up to a dozen collisions of a sphere by the mean free path
            // over the radius: by about ten thousand in all
            close("kept", ledger.contact_time_kept, reference.kept, 1e-9 * reference.kept);
            close("lost", ledger.dissipated(), reference.lost, 1e-9 * reference.lost);
            for (a, b) in end.particles.velocity.iter().zip(&reference.particles.velocity) {
                assert!((a - b).norm() < 1e-9, "{a} {b}");
            }
        }
    }
}

#[test]
fn a_crowd_that_is_handed_over_counts_every_impact() {
    // long windows, solved by islands, alternate with windows of a few steps, solved by uniform steps, between walls
    let (e, count, phi) = (0.9, 400, 0.1);
    let size = edge(count, 1.0, phi);
    let mut scene = empty([size; 3], [true, false, true], unit(), surface(e, 0.0));
    scene.walls = vec![
        plane([0.0; 3], [0.0, 1.0, 0.0], surface(e, 0.0)),
        plane([0.0, size, 0.0], [0.0, -1.0, 0.0], surface(e, 0.0)),
    ];
    let start = random(&scene, count, 1.0, 5);
    let law = LinearSpring { stiffness: 1e5 };
    let (contact, steps) = (law.contact_time(0.5, e), 100.0);
    let step = contact / steps;
    let engine: Box<dyn Engine> =
        Box::new(Soft::new(ContactLaw::linear(law.stiffness), Integrator::VelocityVerlet, step, SoftStepping::Auto));
    let mut simulation = Simulation::with_engine(scene, start, engine);
    let (mut by_islands, mut by_steps) = (0, 0);
    for k in 0..600 {
        let before = simulation.counters();
        simulation.run(1, if k % 3 == 0 { 2.0 * contact } else { 4.0 * step }).unwrap();
        let after = simulation.counters();
        by_islands += u64::from(after.islands > before.islands);
        by_steps += u64::from(after.uniform_steps > before.uniform_steps);
    }
    let (pairs, walls, ledger) = (&simulation.record.pairs, &simulation.record.walls, &simulation.record.ledger);
    println!("{by_islands} windows by islands, {by_steps} by steps, {} and {} impacts", pairs.count, walls.count);
    assert!(by_islands > 50 && by_steps > 50 && pairs.count > 500 && walls.count > 50);
    // dashpots dissipate the energy lost in the counted impacts, except for impacts in progress
    let in_progress = simulation.energy() - simulation.particles.kinetic_energy();
    for (impacts, mass, loss) in
        [(pairs, 0.5, ledger.pair_restitution_loss), (walls, 1.0, ledger.wall_restitution_loss)]
    {
        let counted = 0.5 * mass * (impacts.normal_speed.sum_of_squares() - impacts.rebound_squares());
        let realised = (impacts.rebound_squares() / impacts.normal_speed.sum_of_squares()).sqrt();
        println!("loss {loss}, counted {counted}, in progress {in_progress}, restitution {realised}");
        let x = law.angular_frequency(mass) * step;
        let late = x * x + 2.0 * law.damping(mass, e) * step;
        close("loss", loss, counted, late * counted + in_progress);
        close("restitution", realised, e, late * e);
    }
    // every impact began with an overlap of at most the motion in one step
    assert!(pairs.first_overlap.maximum <= pairs.normal_speed.maximum * step);
}

/// Two species of spheres in a stream of gas, initially at rest. The gas accelerates the small spheres sooner.
/// Collisions transfer their momentum to the large spheres, both with soft and with hard spheres.
#[test]
fn a_mixture_in_a_gas_shares_momentum() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/inputs/mixture-in-gas.toml"));
    let case = diptych::case::Case::from_text("mixture.toml".as_ref(), text.unwrap().into(), &[]).unwrap();
    let variants = case.variants(None).unwrap();
    let mut means: Vec<[f64; 2]> = Vec::new();
    for (mut experiment, _) in variants {
        for stepping in [SoftStepping::Uniform, SoftStepping::Local] {
            if experiment.law().is_none() && stepping == SoftStepping::Local {
                continue;
            }
            experiment.soft.stepping = stepping;
            let start = diptych::placement::initial_state(&experiment).unwrap();
            let momentum = start.momentum();
            let (energy, mass): (f64, f64) = (start.kinetic_energy(), start.mass.iter().sum());
            let mut simulation = Simulation::new(&experiment, start);
            simulation.run(100, 1e-4).unwrap();
            let ledger = &simulation.record.ledger;
            let gained = simulation.particles.momentum() - momentum;
            // a hundred drag kicks and about a thousand impacts, with a rounding error each
            let miss = (gained - ledger.drag_impulse).norm();
            assert!(miss < 1e-12 * gained.norm() + 1e-13 * mass, "momentum {miss:.1e} of {gained}");
            let residual = ledger.residual(energy, simulation.energy()).abs();
            let through = ledger.through(energy);
            let scheme = if experiment.law().is_some() { 0.02 * ledger.dissipated() } else { 1e-12 * through };
            assert!(residual < scheme, "{}: energy {residual:.1e} of {through:.1e}", experiment.name);
            assert!(simulation.record.pairs.count > 300, "{}", simulation.record.pairs.count);
            means.push([0, 1].map(|species| mean_along(&simulation.particles, species)));
            println!(
                "{} {stepping:?}: {:?}, {} impacts",
                experiment.name,
                means[means.len() - 1],
                simulation.record.pairs.count
            );
        }
    }
    // without collisions each species moves as if it were alone in the gas, at most 1 % slower than the gas
    let (experiment, _) = case.experiment(None, None).unwrap();
    let fluid = experiment.scene.fluid.as_ref().unwrap();
    let alone = [0, 1].map(|k| {
        let gas = fluid.profile.velocity(0.0);
        let sphere = fluid.sphere(&experiment.scene.species[k]);
        gas * (1.0 - fluid.drag.as_ref().unwrap().law().decay(&sphere, gas, 1e-2))
    });
    println!("alone: {alone:?}");
    for mean in &means {
        assert!(mean[0] < alone[0] && mean[1] > alone[1] && mean[0] > mean[1], "{mean:?} against {alone:?}");
        // The standard error of one run is the spread of velocities over the root of the number of large spheres. The
        // spread is less than a quarter of the difference between the species. The factor sqrt 2 is for two runs, the
        // factor 3 for three standard errors.
        for (a, b) in mean.iter().zip(&means[0]) {
            close("mean velocity", *a, *b, 3.0 * (2.0f64 / 60.0).sqrt() * 0.25 * (alone[0] - alone[1]));
        }
    }
}

/// [m/s] mean velocity along z of one species.
fn mean_along(particles: &Particles, species: u16) -> f64 {
    let of = particles.velocity.iter().zip(&particles.species).filter(|(_, one)| **one == species);
    let along: Vec<f64> = of.map(|(v, _): (&Vector3<f64>, _)| v.z).collect();
    along.iter().sum::<f64>() / along.len() as f64
}
