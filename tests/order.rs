//! Sums over particles must not depend on the order of the particles in the store, in any bit.

use crate::support::{edge, empty, experiment, large, plane, small, surface};
use diptych::drag::{Drag, Kick, SchillerNaumann};
use diptych::engine::hard::SteppedHard;
use diptych::exact::values;
use diptych::experiment::{Amount, Experiment, Model, Population};
use diptych::fluid::{Fluid, Profile};
use diptych::observe::{
    EnergyBooks, Frames, ImpactSeries, Kinds, MomentumBooks, Motion, Observer, Paths, SecondMoments, Series, Stresses,
};
use diptych::particles::Particles;
use diptych::placement::initial_state;
use diptych::schedule::Schedule;
use diptych::simulation::{Simulation, kick};
use diptych::statistics::{Accumulator, VelocitySpread};
use diptych::{Domain, Vector3};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Experiment with particles of two sizes between a floor and a lid in a gas. There are so many particles that sums
/// over them are computed in several pieces.
fn channel() -> Experiment {
    let size = [edge(9500, small().diameter, 0.02); 3];
    let mut channel = experiment(
        empty(size, [true, false, true], small(), surface(0.8, 0.2)),
        9000,
        [0.0, 0.0, 3.0],
        0.5,
        Model::Soft,
        5,
    );
    let lid = plane([0.0, size[1], 0.0], [0.0, -1.0, 0.0], surface(0.5, 0.3));
    channel.scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.5, 0.3)), lid];
    channel.scene.domain = Domain::new(size.into(), [true, false, true]);
    let drag = Some(Drag::SchillerNaumann(SchillerNaumann));
    channel.scene.fluid = Some(Fluid::new(1.205, 1.515e-5, Profile::Uniform(10.0), drag));
    channel.scene.gravity = Vector3::new(0.1, -9.81, 0.0);
    channel.scene.species.push(large());
    channel.start.push(Population { species: 1, amount: Amount::Count(20), ..channel.start[0].clone() });
    channel
}

/// Copy of the particles in another order of the store.
fn shuffled(particles: &Particles, seed: u64) -> Particles {
    let mut order: Vec<u32> = (0..particles.len() as u32).collect();
    order.shuffle(&mut Xoshiro256PlusPlus::seed_from_u64(seed));
    let mut shuffled = particles.clone();
    shuffled.reorder(&order);
    assert!(shuffled.id != particles.id && shuffled.fingerprint() == particles.fingerprint());
    shuffled
}

/// Changes the velocity of each particle by another amount.
fn stir(simulation: &mut Simulation) {
    let Particles { velocity, id, .. } = &mut simulation.particles;
    for (velocity, id) in velocity.iter_mut().zip(id) {
        let phase = 0.7 * f64::from(*id);
        *velocity += 0.1 * Vector3::new(phase.sin(), phase.cos(), (3.0 * phase).sin());
    }
}

fn observers(experiment: &Experiment, schedule: &Schedule) -> Vec<(&'static str, Box<dyn Observer>)> {
    vec![
        ("profiles", Box::new(Accumulator::new(7, experiment.scene.domain.size.y))),
        ("motion", Box::new(Motion::new(experiment))),
        ("pairs", Box::new(ImpactSeries::of_pairs(experiment, schedule))),
        ("energy", Box::new(EnergyBooks::default())),
        ("momentum", Box::new(MomentumBooks::new(schedule))),
        ("series", Box::new(Series::new(experiment, schedule))),
        ("paths", Box::new(Paths::new(schedule))),
        ("frames", Box::new(Frames::new(experiment, 1))),
        ("kinds", Box::new(Kinds::new(experiment, schedule))),
        ("stress", Box::new(Stresses::new(experiment, schedule))),
        ("second moments", Box::new(SecondMoments::new(5, schedule))),
    ]
}

#[test]
fn observers_see_the_same_in_a_store_that_is_shuffled() {
    let channel = channel();
    let schedule = Schedule::new(&channel);
    let start = initial_state(&channel).unwrap();
    let see = |start: Particles| {
        let mut simulation = Simulation::new(&channel, start);
        let mut observers = observers(&channel, &schedule);
        for _ in 0..3 {
            observers.iter_mut().for_each(|(_, observer)| observer.see(&simulation));
            stir(&mut simulation);
        }
        observers.iter_mut().for_each(|(_, observer)| observer.end(&simulation));
        observers.into_iter().map(|(name, observer)| (name, observer.stored().unwrap())).collect::<Vec<_>>()
    };
    let in_order = see(start.clone());
    for seed in 1..4 {
        for ((name, seen), (_, then)) in see(shuffled(&start, seed)).iter().zip(&in_order) {
            assert!(seen == then, "{name}, shuffle {seed}");
        }
    }
}

#[test]
fn sums_over_particles_are_the_same_in_a_store_that_is_shuffled() {
    let channel = channel();
    let start = initial_state(&channel).unwrap();
    let fluid = channel.scene.fluid.as_ref().unwrap();
    let spheres: Vec<_> = channel.scene.species.iter().map(|species| fluid.sphere(species)).collect();
    let sums = |start: &Particles| {
        let drag = Kick::exact(&Drag::SchillerNaumann(SchillerNaumann), &spheres, 1e-4);
        let by_drag = values(&kick(&mut start.clone(), &fluid.profile, &drag));
        let step = SteppedHard::longest_step(0.05, start, &channel.scene, 1e-4);
        let spread = VelocitySpread::of(start, 7, channel.scene.domain.size.y);
        let simulation = Simulation::new(&channel, start.clone());
        let mut all = vec![start.kinetic_energy(), start.total_mass(), start.mean_square_speed(Vector3::z()), step];
        all.extend(by_drag.iter().chain(start.momentum().as_slice()).chain(start.mean_velocity().as_slice()));
        all.extend(start.mean_radii(1e-4));
        all.extend([spread.variance(), spread.temperature().unwrap(), simulation.energy()]);
        all.iter().map(|number| number.to_bits()).collect::<Vec<u64>>()
    };
    let in_order = sums(&start);
    for seed in 1..6 {
        assert_eq!(sums(&shuffled(&start, seed)), in_order, "shuffle {seed}");
    }
}
