//! A contact law that the user defines: an elastic force that grows with the square of the overlap.

use diptych::contact_law::{Bodies, Law, Parameter, Spring};
use diptych::{ContactLaw, Domain, Experiment, Population, Scene, Simulation, Species, Spheres, Surface, Vector3};

#[derive(Debug)]
struct Square(f64); // stiffness in N/m^2

impl Law for Square {
    fn between(&self, bodies: &Bodies) -> Spring {
        let Bodies { effective_mass, restitution, stiffness_ratio, .. } = *bodies;
        Spring { effective_mass, restitution, stiffness: self.0 * stiffness_ratio, dashpot: 0.0 }
    }
    fn force(&self, spring: &Spring, overlap: f64, _normal_velocity: f64) -> (f64, f64) {
        (spring.stiffness * overlap * overlap.abs(), 0.0)
    }
    fn stored_energy(&self, spring: &Spring, overlap: f64) -> f64 {
        spring.stiffness * overlap.abs().powi(3) / 3.0
    }
    fn parameters(&self) -> Vec<Parameter> {
        let (law, key, name, symbol, unit) = ("square", "stiffness", "stiffness", "k_s", "N/m^2");
        vec![Parameter { law, key, name, symbol, value: self.0, unit }]
    }
}

/// Runs 125 elastic spheres in a periodic box with edges of 2 mm.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (domain, contact) = (Domain::new(Vector3::repeat(2e-3), [true; 3]), Surface::new(1.0, 0.0));
    let scene = Scene::new(domain, contact, vec![Species::new("glass", 2e-4, 2500.0)]);
    let soft = Spheres::Soft(ContactLaw::other(Square(1e8)));
    let mut simulation =
        Simulation::from_start(&Experiment::new(scene, vec![Population::random(0, 125, 0.1)], soft, 0.01))?;
    simulation.run_until(0.01)?;
    println!("{} contacts, {:.3e} J", simulation.record.pairs.count, simulation.energy());
    Ok(())
}
