//! One gas of spheres, built in Rust, under both engines: how many collide, and how much of the energy is left.

use diptych::experiment::{Integrator, SoftStepping};
use diptych::{ContactLaw, Domain, Engine, Hard, Particles, Scene, Simulation, Soft, Species, Surface, Vector3};

/// A periodic box of 2 mm with spheres of 200 um.
fn scene() -> Scene {
    Scene::new(
        Domain::new(Vector3::repeat(2e-3), [true; 3]),
        Surface::new(0.9, 0.0),
        vec![Species::new("glass", 2e-4, 2500.0)],
    )
}

/// 125 glass spheres in a box.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = scene();
    let sphere = &scene.species[0];
    let mut particles = Particles::default();
    for k in 0..125 {
        let place = Vector3::new((k % 5) as f64, (k / 5 % 5) as f64, (k / 25) as f64) * 4e-4;
        let velocity = Vector3::new((7 * k % 11) as f64, (5 * k % 11) as f64, (3 * k % 11) as f64) * 0.02;
        particles.push(place, velocity, 0.5 * sphere.diameter, sphere.mass(), 0);
    }
    let soft = Soft::new(ContactLaw::linear(1000.0), Integrator::VelocityVerlet, 1e-7, SoftStepping::Auto);
    let engines: [(&str, Box<dyn Engine>); 2] = [("soft", Box::new(soft)), ("hard", Box::new(Hard::new()))];
    for (name, engine) in engines {
        let mut simulation = Simulation::with_engine(scene.clone(), particles.clone(), engine);
        let before = simulation.energy();
        simulation.run(100, 1e-4)?; // windows of 0.1 ms
        let (count, left) = (simulation.record.pairs.count, simulation.energy() / before);
        println!("{name}: {count} collisions, {left:.3} of the energy left");
    }
    Ok(())
}
