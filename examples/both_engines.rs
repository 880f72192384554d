//! Runs one gas of spheres with soft and with hard collisions, and prints the number of collisions and the remaining
//! share of the energy.

use diptych::{ContactLaw, Domain, Experiment, Population, Scene, Simulation, Species, Spheres, Surface, Vector3};

/// Runs 125 glass spheres with diameters of 200 um in a periodic box with edges of 2 mm, once soft and once hard.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let domain = Domain::new(Vector3::repeat(2e-3), [true; 3]);
    let scene = Scene::new(domain, Surface::new(0.9, 0.0), vec![Species::new("glass", 2e-4, 2500.0)]);
    let start = vec![Population::random(0, 125, 0.1)]; // 0.1 m/s: standard deviation along each axis
    for spheres in [Spheres::Soft(ContactLaw::linear(1000.0)), Spheres::Hard] {
        let experiment = Experiment::new(scene.clone(), start.clone(), spheres, 0.01); // duration in s
        let mut simulation = Simulation::from_start(&experiment)?;
        let before = simulation.energy();
        simulation.run_until(0.01)?;
        let (count, left) = (simulation.record.pairs.count, simulation.energy() / before);
        println!("{}: {count} collisions, {left:.3} of the energy left", experiment.name);
    }
    Ok(())
}
