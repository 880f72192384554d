//! Glass beads that fall into a funnel, which is read from an STL file.

use diptych::triangles::TriangleFile;
use diptych::{ContactLaw, Mesh, Plane, Wall, WallGeometry};
use diptych::{Domain, Experiment, Population, Scene, Simulation, Species, Spheres, Surface, Vector3};

/// Runs 100 soft beads with diameters of 3 mm that fall through the funnel, in a box of 60 x 60 x 130 mm.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut file = TriangleFile::read("cases/walls/hopper.stl")?.scaled(1e-3); // the file is in mm
    file.heap.iter_mut().flatten().for_each(|corner| *corner += Vector3::new(0.03, 0.03, 0.032));
    let (funnel, findings) = Mesh::new("funnel", &file.heap, None)?;
    println!("{} triangles, {} open edges", file.heap.len(), findings.open_edges);
    let (domain, surface) = (Domain::new(Vector3::new(0.06, 0.06, 0.13), [true, true, false]), Surface::new(0.8, 0.3));
    let floor = Plane { point: Vector3::zeros(), normal: Vector3::z() };
    let lid = Plane { point: Vector3::new(0.0, 0.0, 0.13), normal: -Vector3::z() };
    let shapes = [WallGeometry::Mesh(funnel.into()), WallGeometry::Plane(floor), WallGeometry::Plane(lid)];
    let walls = shapes.map(|shape| Wall::new(shape, surface)).into();
    let beads = vec![Species::new("glass", 3e-3, 2500.0)];
    let scene = Scene { gravity: -9.81 * Vector3::z(), walls, ..Scene::new(domain, surface, beads) };
    let soft = Spheres::Soft(ContactLaw::linear(2000.0)); // stiffness in N/m
    let mut simulation =
        Simulation::from_start(&Experiment::new(scene, vec![Population::random(0, 100, 0.0)], soft, 0.1))?;
    simulation.run_until(0.1)?;
    println!("at {:.1} s {} impacts at walls", simulation.time, simulation.record.walls.count);
    Ok(())
}
