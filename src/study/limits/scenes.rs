//! The scenes of the maps, as cases: what a map runs, a reader can run again.

use crate::case::Case;
use crate::contact_law::ContactLaw;
use crate::engine::Failure;
use crate::experiment::Experiment;
use crate::scene::Species;
use crate::simulation::Simulation;
use crate::study::session::{StudyError, start};
use std::path::Path;
use std::sync::Arc;

/// [m] the paper's small particle.
pub const DIAMETER: f64 = 406e-6;
/// [kg/m³] of the same.
const DENSITY: f64 = 1038.0;
/// [N/m] the paper's.
pub const STIFFNESS: f64 = 3000.0;
/// [m/s²] gravity.
pub const GRAVITY: f64 = 9.81;

/// [kg] mass of the paper's small particle.
pub fn mass() -> f64 {
    Species { name: String::new(), diameter: DIAMETER, density: DENSITY, elasticity: None }.mass()
}

/// The experiment of a case.
pub fn experiment(text: &str) -> Result<Experiment, StudyError> {
    Ok(Case::from_text(Path::new("limits.toml"), Arc::from(text), &[])?.experiment(None, None)?.0)
}

/// A case at its start.
pub fn simulation(text: &str) -> Result<Simulation, StudyError> {
    let experiment = experiment(text)?;
    let particles = start(&experiment)?;
    Ok(Simulation::new(&experiment, particles))
}

/// Runs a simulation; its failure is a result.
pub fn run(simulation: &mut Simulation, windows: u64, duration: f64) -> Option<Failure> {
    simulation.run(windows, duration / windows as f64).err()
}

/// Soft spheres stepped all at once: contact law, N_c and integrator.
pub fn soft(law: &ContactLaw, steps_per_contact: f64, integrator: &str) -> String {
    let (name, values) = law.table();
    let values: String = values.into_iter().map(|(key, value)| format!("{key} = {value}\n")).collect();
    format!(
        "[soft.{name}]\n{values}[soft]\nsteps_per_contact = {steps_per_contact}\n\
         stepping = \"uniform\"\nintegrator = \"{integrator}\"\nallow_unstable = true\n[run]\nmodel = \"soft\"\n"
    )
}

/// Hard spheres at exact instants.
pub fn hard() -> String {
    "[run]\nmodel = \"hard\"\n".into()
}

/// The end of a case: its length [s] and its seed.
pub fn length(duration: f64, seed: u64) -> String {
    format!("duration = \"{duration} s\"\nseed = {seed}\n")
}

/// `count` small spheres at random places in a periodic cube at volume fraction φ, with `speed` [m/s] per component.
pub fn gas(count: usize, fraction: f64, speed: f64, restitution: f64) -> String {
    let edge = (count as f64 * mass() / DENSITY / fraction).cbrt();
    format!(
        "[domain]\nsize = [\"{edge} m\", \"{edge} m\", \"{edge} m\"]\nperiodic = [\"x\", \"y\", \"z\"]\n\
         [[particles]]\ndiameter = \"406 um\"\ndensity = \"1038 kg/m^3\"\ncount = {count}\nvelocity_fluctuation = \"{speed} m/s\"\n\
         [contact]\nrestitution = {restitution}\n"
    )
}

/// [1/s] collisions that a sphere of a gas of volume fraction φ suffers at temperature T [m²/s²]: Enskog's
/// 24 φ g sqrt(T/π)/d with Carnahan and Starling's (1969) g = (1 - φ/2)/(1 - φ)³.
pub fn collision_rate(fraction: f64, temperature: f64) -> f64 {
    let g = (1.0 - 0.5 * fraction) / (1.0 - fraction).powi(3);
    24.0 * fraction * g * (temperature / std::f64::consts::PI).sqrt() / DIAMETER
}

/// [m²/s²] temperature of a gas of equal spheres without mean motion, whose momentum is not counted: 2E/(3(N-1)m).
pub fn temperature(simulation: &Simulation) -> f64 {
    2.0 * simulation.particles.kinetic_energy() / (3.0 * (simulation.particles.len() as f64 - 1.0) * mass())
}

/// Spheres of 1 m and 1 kg in a row along x: their gaps [m], the first from the wall at 0 or from an edge, and velocities [m/s].
pub fn row(gaps: &[f64], velocities: &[f64], length: f64, restitution: f64, wall: bool) -> String {
    let mut at = 0.0;
    let mut list = String::new();
    for (gap, velocity) in gaps.iter().zip(velocities) {
        let place = at + gap + 0.5;
        at += gap + 1.0;
        list += &format!(
            "  {{ position = [\"{place} m\", \"2 m\", \"2 m\"], velocity = [\"{velocity} m/s\", \"0 m/s\", \"0 m/s\"] }},\n"
        );
    }
    let wall = if wall {
        format!(
            "[[walls]]\nplane = {{ point = [\"0 m\", \"0 m\", \"0 m\"], normal = [1, 0, 0] }}\nrestitution = {restitution}\n"
        )
    } else {
        String::new()
    };
    format!(
        "[domain]\nsize = [\"{length} m\", \"4 m\", \"4 m\"]\nperiodic = [\"y\", \"z\"]\n\
         [[particles]]\ndiameter = \"1 m\"\n# 1 kg: 6/π\ndensity = \"{} kg/m^3\"\nat = [\n{list}]\n\
         {wall}[contact]\nrestitution = {restitution}\n",
        6.0 / std::f64::consts::PI
    )
}

/// [m/s] velocities along x, in the order of the row.
pub fn speeds(simulation: &Simulation) -> Vec<f64> {
    let mut particles = simulation.particles.clone();
    particles.sort_by_id();
    particles.velocity.iter().map(|v| v.x).collect()
}

/// Equally scattered numbers in [0, 1) without chance: multiples of the golden section, shifted by the set's number.
pub fn scatter(set: usize, k: usize) -> f64 {
    // 1/φ, and the root of x³ = x + 1 for the sets (Roberts 2018)
    const GOLDEN: f64 = 0.618_033_988_749_895;
    const PLASTIC: f64 = 0.754_877_666_246_693;
    ((k + 1) as f64 * GOLDEN + (set + 1) as f64 * PLASTIC).fract()
}

/// Mean and its standard error; of one value the error is NaN.
pub fn mean(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}
