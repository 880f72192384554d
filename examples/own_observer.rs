//! An observer of one's own: the kinetic energy of a cooling gas every tenth of a millisecond, whatever the windows are.

use diptych::observe::{Observer, run};
use diptych::schedule::Schedule;
use diptych::{Domain, Hard, Particles, Scene, Simulation, Species, Surface, Vector3};

/// Time [s] and kinetic energy [J], as a table would hold them.
#[derive(Default)]
struct Cooling(Vec<(f64, f64)>);

impl Observer for Cooling {
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        Some(now + 1e-4)
    }

    fn see(&mut self, simulation: &Simulation) {
        self.0.push((simulation.time, simulation.particles.kinetic_energy()));
    }
}

/// 125 glass spheres that lose a fifth of their normal speed at every collision.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let glass = Species::new("glass", 2e-4, 2500.0);
    let mut particles = Particles::default();
    for k in 0..125 {
        let place = Vector3::new((k % 5) as f64, (k / 5 % 5) as f64, (k / 25) as f64) * 4e-4;
        let velocity = Vector3::new((7 * k % 11) as f64, (5 * k % 11) as f64, (3 * k % 11) as f64) * 0.02;
        particles.push(place, velocity, 0.5 * glass.diameter, glass.mass(), 0);
    }
    let (domain, contact) = (Domain::new(Vector3::repeat(2e-3), [true; 3]), Surface::new(0.8, 0.0));
    let scene = Scene::new(domain, contact, vec![glass]);
    let mut simulation = Simulation::with_engine(scene, particles, Box::new(Hard::new()));
    let mut cooling = Cooling::default();
    run(&mut simulation, &Schedule::even(5e-5, 1, 100), &mut [&mut cooling])?;
    cooling.0.iter().step_by(10).for_each(|(time, energy)| println!("{time:.4} s: {energy:.3e} J"));
    Ok(())
}
