//! Functions that change a scene from point to point of a map, and quantities that are computed from its runs. The
//! paper is that of docs/paper.md.

use crate::contact_law::ContactLaw;
use crate::domain::Domain;
use crate::engine::Failure;
use crate::experiment::{Amount, Experiment, Spheres};
use crate::kinetic_theory::contact_value;
use crate::particles::Particles;
use crate::runs::{StudyError, start};
use crate::scene::{Species, Surface};
use crate::simulation::Simulation;
use nalgebra::Vector3;

/// [m] diameter of the small particle of the paper (docs/paper.md).
pub const DIAMETER: f64 = 406e-6;
/// [kg/m³] density of the small particle of the paper (docs/paper.md).
const DENSITY: f64 = 1038.0;
/// [N/m] stiffness k_n of the contacts of the paper (docs/paper.md).
pub const STIFFNESS: f64 = 3000.0;

/// [kg] mass of the small particle of the paper (docs/paper.md).
pub fn mass() -> f64 {
    Species::new("", DIAMETER, DENSITY).mass()
}

/// Simulation of an experiment, with the particles at their start.
pub fn simulation(experiment: &Experiment) -> Result<Simulation, StudyError> {
    Ok(Simulation::new(experiment, start(experiment)?))
}

/// Runs a simulation for `duration` [s] in `windows` equal windows (pieces of the run). Returns the failure if the run
/// stops early, otherwise `None`. A failure is a result for a map, and not an error.
pub fn run(simulation: &mut Simulation, windows: u64, duration: f64) -> Option<Failure> {
    simulation.run(windows, duration / windows as f64).err()
}

/// Changes the model of the experiment to soft spheres with the contact law `law`.
pub fn soften(experiment: &mut Experiment, law: ContactLaw) {
    experiment.soft.law = Some(law);
    experiment.run.spheres = Spheres::Soft(law);
}

/// Gives the particles of the case the positions [m] and velocities [m/s] in `list` at the start.
pub fn place(experiment: &mut Experiment, list: Vec<(Vector3<f64>, Vector3<f64>)>) {
    let species = experiment.start[0].species;
    let kind = &experiment.scene.species[usize::from(species)];
    let mut particles = Particles::default();
    for (position, velocity) in list {
        particles.push(position, velocity, 0.5 * kind.diameter, kind.mass(), species);
    }
    experiment.start[0].amount = Amount::Placed(particles);
}

/// Puts spheres of diameter 1 m and mass 1 kg in a row along x, in a box of `length` [m]. The first of the `gaps` [m]
/// lies between the side x = 0 of the box and the first sphere, the others between neighbouring spheres. `velocities`
/// [m/s] are those along x.
pub fn row(experiment: &mut Experiment, length: f64, gaps: &[f64], velocities: &[f64]) {
    let mut at = 0.0;
    let spheres = gaps.iter().zip(velocities).map(|(gap, velocity)| {
        let centre = at + gap + 0.5;
        at += gap + 1.0;
        (Vector3::new(centre, 2.0, 2.0), Vector3::new(*velocity, 0.0, 0.0))
    });
    let spheres = spheres.collect();
    place(experiment, spheres);
    let domain = &mut experiment.scene.domain;
    *domain = Domain::new(Vector3::new(length, domain.size.y, domain.size.z), domain.periodic);
}

/// Sets the `restitution` [-] of all contacts between spheres and of all contacts with walls.
pub fn restitute(experiment: &mut Experiment, restitution: f64) {
    let scene = &mut experiment.scene;
    let walls = scene.walls.iter_mut().map(|wall| &mut wall.surface);
    walls
        .chain([&mut scene.contact])
        .chain(scene.pairs.surfaces_mut())
        .for_each(|surface| *surface = Surface::new(restitution, surface.friction));
}

/// Fills a periodic cube with `count` small spheres of the paper (docs/paper.md), so that their volume fraction is
/// `fraction` [-].
pub fn fill(experiment: &mut Experiment, count: usize, fraction: f64) {
    let edge = (count as f64 * mass() / DENSITY / fraction).cbrt();
    experiment.scene.domain = Domain::new(Vector3::repeat(edge), [true; 3]);
    experiment.start[0].amount = Amount::Count(count);
}

/// [1/s] collision rate of one sphere of diameter d in a gas, by Enskog: 24 φ g sqrt(T/π)/d. `fraction` is the volume
/// fraction φ [-], `temperature` the granular temperature T [m²/s²]. The [`contact_value`] g is that of
/// Carnahan and Starling (1969).
pub fn collision_rate(fraction: f64, temperature: f64) -> f64 {
    24.0 * fraction * contact_value(1.0, 1.0, fraction, fraction) * (temperature / std::f64::consts::PI).sqrt()
        / DIAMETER
}

/// [m²/s²] granular temperature 2E/(3(N-1)m) of a gas of N spheres of equal mass m with kinetic energy E. The total
/// momentum is zero, which removes three degrees of freedom.
pub fn temperature(simulation: &Simulation) -> f64 {
    2.0 * simulation.particles.kinetic_energy() / (3.0 * (simulation.particles.len() as f64 - 1.0) * mass())
}

/// [m/s] velocity components along x of all spheres, in the order of their ids.
pub fn speeds(simulation: &Simulation) -> Vec<f64> {
    let mut particles = simulation.particles.clone();
    particles.sort_by_id();
    particles.velocity.iter().map(|v| v.x).collect()
}

/// [-] number with index `k` in a quasi-random sequence that fills the interval [0, 1) evenly. Each value of `set`
/// gives a different sequence.
pub fn scatter(set: usize, k: usize) -> f64 {
    // multiples of the inverse golden section, shifted by multiples of the inverse root of x³ = x + 1 (Roberts 2018)
    const GOLDEN: f64 = 0.618_033_988_749_895;
    const PLASTIC: f64 = 0.754_877_666_246_693;
    ((k + 1) as f64 * GOLDEN + (set + 1) as f64 * PLASTIC).fract()
}

/// Mean over several runs, and its standard error. The function `of` takes the number that is averaged from a run.
/// With one run the error is NaN.
pub fn mean<T>(runs: &[T], of: impl Fn(&T) -> f64) -> (f64, f64) {
    let n = runs.len() as f64;
    let mean = runs.iter().map(&of).sum::<f64>() / n;
    let variance = runs.iter().map(|run| (of(run) - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}
