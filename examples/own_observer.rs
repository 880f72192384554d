//! An observer (measurement during a run) that the user defines. It records the kinetic energy of a cooling gas at
//! every sample (instant of measurement).

use diptych::observe::{Observer, run};
use diptych::schedule::Schedule;
use diptych::{Domain, Experiment, Population, Scene, Simulation, Species, Spheres, Surface, Vector3};

/// Time [s] and kinetic energy [J] at each sample (instant of measurement).
#[derive(Default)]
struct Cooling(Vec<(f64, f64)>);

impl Observer for Cooling {
    fn see(&mut self, simulation: &Simulation) {
        self.0.push((simulation.time, simulation.particles.kinetic_energy()));
    }
}

/// Runs 125 glass spheres that lose a fifth of their normal speed at every collision.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let domain = Domain::new(Vector3::repeat(2e-3), [true; 3]);
    let scene = Scene::new(domain, Surface::new(0.8, 0.0), vec![Species::new("glass", 2e-4, 2500.0)]);
    let experiment = Experiment::new(scene, vec![Population::random(0, 125, 0.1)], Spheres::Hard, 5e-3);
    let mut cooling = Cooling::default();
    run(&mut Simulation::from_start(&experiment)?, &Schedule::new(&experiment), &mut [&mut cooling])?;
    cooling.0.iter().step_by(20).for_each(|(time, energy)| println!("{time:.4} s: {energy:.3e} J"));
    Ok(())
}
