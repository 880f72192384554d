//! A drag law of one's own: Clift and Gauvin (1970), for which no closed form of the flow is known.

use diptych::drag::{Drag, DragLaw, Sphere};
use diptych::{Domain, Fluid, Hard, Particles, Profile, Scene, Simulation, Species, Surface, Vector3};
use std::sync::Arc;

#[derive(Debug)]
struct CliftGauvin;

impl DragLaw for CliftGauvin {
    fn name(&self) -> &'static str {
        "clift_gauvin"
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    /// C_D = 24/Re (1 + 0.15 Re^0.687) + 0.42/(1 + 42500 Re^-1.16), up to Re = 3e5.
    fn response_time(&self, sphere: &Sphere, slip: f64) -> f64 {
        let re = (sphere.reynolds_per_speed * slip).max(1e-9);
        sphere.stokes_time / (1.0 + 0.15 * re.powf(0.687) + 0.42 / 24.0 * re / (1.0 + 42_500.0 * re.powf(-1.16)))
    }
}

/// One sphere from rest in a uniform wind.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sphere = Species::new("polystyrene", 1.5e-3, 1032.0);
    let (profile, drag) = (Profile::Uniform(15.0), Some(Drag::Other(Arc::new(CliftGauvin))));
    let air = Fluid::new(1.205, 1.515e-5, profile, drag);
    let domain = Domain::new(Vector3::repeat(0.1), [true; 3]);
    let (contact, walls) = (Surface::new(1.0, 0.0), Vec::new());
    let mut particles = Particles::default();
    particles.push(Vector3::repeat(0.05), Vector3::zeros(), 0.5 * sphere.diameter, sphere.mass(), 0);
    let scene = Scene { fluid: Some(air), walls, ..Scene::new(domain, contact, vec![sphere]) };
    let mut simulation = Simulation::with_engine(scene, particles, Box::new(Hard::new()));
    for _ in 0..5 {
        simulation.run(20, 5e-3)?; // windows of 5 ms
        println!("{:.1} s: {:.4} m/s in air of 15 m/s", simulation.time, simulation.particles.velocity[0].z);
    }
    Ok(())
}
