//! A drag law that the user defines, by Clift and Gauvin (1970): drag coefficient C_D = 24/Re (1 + 0.15 Re^0.687) +
//! 0.42/(1 + 42500 Re^-1.16), with the Reynolds number Re of the particle.

use diptych::drag::{Drag, DragLaw, Sphere};
use diptych::{Domain, Experiment, Fluid, Population, Profile, Scene, Simulation, Species, Spheres, Surface, Vector3};

#[derive(Debug)]
struct CliftGauvin;

impl DragLaw for CliftGauvin {
    fn name(&self) -> &'static str {
        "clift_gauvin"
    }
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }
    fn response_time(&self, sphere: &Sphere, slip: f64) -> f64 {
        let re = (sphere.reynolds_per_speed * slip).max(1e-9);
        sphere.stokes_time / (1.0 + 0.15 * re.powf(0.687) + 0.42 / 24.0 * re / (1.0 + 42_500.0 * re.powf(-1.16)))
    }
}

/// Runs one sphere that starts at rest in a uniform wind of 15 m/s.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let drag = Drag::Other(std::sync::Arc::new(CliftGauvin));
    let air = Fluid::new(1.205, 1.515e-5, Profile::Uniform(15.0), Some(drag)); // density kg/m^3, viscosity m^2/s
    let (domain, contact) = (Domain::new(Vector3::repeat(0.1), [true; 3]), Surface::new(1.0, 0.0));
    let beads = Species::new("polystyrene", 1.5e-3, 1032.0);
    let scene = Scene { fluid: Some(air), ..Scene::new(domain, contact, vec![beads]) };
    let experiment = Experiment::new(scene, vec![Population::random(0, 1, 0.0)], Spheres::Hard, 0.5);
    let mut simulation = Simulation::from_start(&experiment)?;
    for time in [0.1, 0.2, 0.3, 0.4, 0.5] {
        simulation.run_until(time)?;
        println!("{time:.1} s: {:.4} m/s in air of 15 m/s", simulation.particles.velocity[0].z);
    }
    Ok(())
}
