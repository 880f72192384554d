//! Validation rows (comparisons with references) of gases of elastic spheres at equilibrium: collision rate and
//! pressure, mixtures, and an atmosphere under gravity. T is the granular temperature and d the diameter of a sphere.

use super::check::{CheckResult, CheckScene, ValidationCheck, averaged, run_to, stopped};
use crate::experiment::Model;
use crate::output::ValidationTier::{ClosedForms, OtherCodes};
use crate::particles::Particles;
use crate::predict::gas::{AgitationSpread, Component, gas};
use crate::runs::StudyError;
use crate::simulation::Simulation;
use crate::statistics::Estimate;
use std::f64::consts::PI;

/// [m²/s²] granular temperature 2E/(3(N-1)m) of N equal spheres of mass m. E is their kinetic energy relative to the
/// centre of mass.
pub(super) fn temperature(particles: &Particles) -> f64 {
    let mass = particles.total_mass();
    // kinetic energy of the motion of the centre of mass
    let together = 0.5 * particles.momentum().norm_squared() / mass;
    2.0 * (particles.kinetic_energy() - together) / (3.0 * mass * (1.0 - 1.0 / particles.len() as f64))
}

/// Runs a gas of hard spheres of `diameter` [m] until every sphere has collided `collisions` times on average, and
/// returns the simulated time [s]. `rate` [-] is the collision rate of a sphere in units of sqrt(T)/d. During one
/// window (piece of the run) a sphere flies about a third of the way to its neighbours.
fn collide(simulation: &mut Simulation, diameter: f64, rate: f64, collisions: f64) -> Result<f64, StudyError> {
    let speed = temperature(&simulation.particles).sqrt();
    let time = collisions * diameter / (rate * speed);
    let spacing = (simulation.scene().domain.volume() / simulation.count() as f64).cbrt();
    let windows = (time * speed / (0.3 * spacing)).ceil();
    run_to(simulation, simulation.time + time, windows as u64)?;
    Ok(time)
}

/// Comparison with a reference (row of the validation suite): collision rate and pressure of a gas of hard spheres.
pub const HARD_GAS: ValidationCheck = ValidationCheck {
    name: "hard-gas",
    tier: OtherCodes,
    case: "validation/gas",
    scene: "1000 elastic hard spheres at equilibrium in a periodic cube, φ = 0.01, 0.1, 0.3, 0.45 (0.1 and 0.3 with --quick): collisions per sphere and time, and pressure beyond that of an ideal gas.",
    source: "Kolafa, Labik and Malijevsky (2004, Phys. Chem. Chem. Phys. 6, 2335), fit to molecular dynamics; Enskog's rate with its contact value, evaluated independently. Each is reduced by 1/N for N spheres. The paper's abstract was read, its coefficients come from public sources.",
    not_shown: "Freezing (φ above 0.494), and transport: viscosity, diffusion, conductivity.",
    takes_minutes: false,
    measure: hard_gas,
};

/// Reference values for a gas of hard spheres: volume fraction [-], collision rate of a sphere in units of sqrt(T)/d
/// [-] (granular temperature T, diameter d), and compressibility factor [-].
const KOLAFA: [(f64, f64, f64); 4] =
    [(0.01, 0.138854, 1.041019), (0.1, 1.765845, 1.521647), (0.3, 10.101194, 3.983983), (0.45, 28.449080, 9.404114)];

fn hard_gas(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let mut numbers = Vec::new();
    let (seeds, collisions, gases) = scene.choose((6, 120.0, &KOLAFA[1..3]), (16, 300.0, &KOLAFA[..]));
    let count = 1000.0;
    for &(fraction, rate, compressibility) in gases {
        let edge = (count * PI / 6.0 / fraction).cbrt();
        let sets: Vec<String> = (0..3).map(|axis| format!("domain.size[{axis}]={edge} m")).collect();
        let runs = scene.replicas(seeds, |seed| {
            let mut simulation = scene.simulation(Model::Hard, Some(seed), &sets)?;
            collide(&mut simulation, 1.0, rate, 50.0)?;
            let before = (simulation.record.pairs.count, simulation.record.pairs.normal_speed.sum());
            let time = collide(&mut simulation, 1.0, rate, collisions)?;
            let (pairs, temperature) = (&simulation.record.pairs, temperature(&simulation.particles));
            let found = 2.0 * (pairs.count - before.0) as f64 / (count * time * temperature.sqrt());
            // the pressure beyond that of an ideal gas follows from the virial, the sum of d J over all impacts, with
            // the diameter d = 1 m and the impulse J = m u_n (mass m = 1 kg, normal relative speed u_n)
            let virial = (pairs.normal_speed.sum() - before.1) / (3.0 * (count - 1.0) * time * temperature);
            Ok([found, virial])
        })?;
        let pairs = 1.0 - 1.0 / count;
        let expected = [rate * pairs, (compressibility - 1.0) * pairs];
        for (k, name) in ["Γ d/sqrt(T)", "Z - 1"].into_iter().enumerate() {
            let reference = Estimate::exact(expected[k]);
            let name = format!("{name}, φ = {fraction}");
            numbers.push(averaged(name, "", reference, runs.iter().map(|run| run[k]), 0.015 * expected[k]));
        }
    }
    Ok(numbers.into())
}

/// Comparison with a reference (row of the validation suite): collision rate of a mixture of two sizes.
pub const MIXTURE: ValidationCheck = ValidationCheck {
    name: "mixture",
    tier: OtherCodes,
    case: "mixtures/ten-to-one",
    scene: "Hard spheres of 0.4 and 1.2 mm, ten to one in number, φ = 0.2, elastic and in equilibrium: collisions of all pairs per time.",
    source: "Kinetic theory with the contact values of Boublík (1970, J. Chem. Phys. 53, 471) and Mansoori, Carnahan, Starling and Leland (1971, J. Chem. Phys. 54, 1523), as in src/physics/predict/gas.rs. These papers were not read.",
    not_shown: "The rates of each kind of pair: those of large ones exceed this theory by 1.7 % (docs/validation.md, Collision rates in mixtures).",
    takes_minutes: false,
    measure: mixture,
};

fn mixture(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    // volume of 1000 small and 100 large spheres, at φ = 0.2
    let volume = PI / 6.0 * (1000.0 * 0.4e-3_f64.powi(3) + 100.0 * 1.2e-3_f64.powi(3));
    let edge = (volume / 0.2).cbrt();
    let mut sets: Vec<String> = (0..3).map(|axis| format!("domain.size[{axis}]={edge} m")).collect();
    sets.extend(["particles[1].diameter=1.2 mm".to_owned(), "run.duration=1 s".to_owned()]);
    // both sizes have equal mean energies: a large sphere has 27 times the mass of a small one, so the small spheres
    // are √27 times as fast
    sets.push(format!("particles[1].velocity_fluctuation={} m/s", 0.5 / 27.0_f64.sqrt()));
    let share = |diameter: f64, count: f64| PI / 6.0 * diameter.powi(3) * count / edge.powi(3) * (1.0 + 1e-9);
    sets.push(format!("particles[0].volume_fraction={}", share(0.4e-3, 1000.0)));
    sets.push(format!("particles[1].volume_fraction={}", share(1.2e-3, 100.0)));
    let (seeds, time) = scene.choose((6, 0.05), (16, 0.2));
    let ratios = scene.replicas(seeds, |seed| {
        let mut simulation = scene.simulation(Model::Hard, Some(seed), &sets)?;
        run_to(&mut simulation, 0.02, 200)?;
        let before = simulation.record.pairs.count;
        run_to(&mut simulation, 0.02 + time, (1e4 * time) as u64)?;
        let particles = &simulation.particles;
        // mean energy per direction; the conserved momentum removes three degrees of freedom
        let energy = 2.0 * particles.kinetic_energy() / (3.0 * (particles.len() as f64 - 1.0));
        let component = |species: u16| {
            let members: Vec<usize> = (0..particles.len()).filter(|&i| particles.species[i] == species).collect();
            let first = members.first().copied().unwrap_or_default();
            Component {
                count: members.len(),
                diameter: 2.0 * particles.radius[first],
                variance: energy / particles.mass[first],
            }
        };
        let theory = gas(simulation.scene(), &[component(0), component(1)], &AgitationSpread::even());
        Ok((simulation.record.pairs.count - before) as f64 / time / theory.pair_rate)
    })?;
    Ok(vec![averaged("rate over that of theory", "", Estimate::exact(1.0), ratios, 0.01)].into())
}

/// Comparison with a reference (row of the validation suite): heights and temperatures of spheres under gravity (an
/// atmosphere).
pub const ATMOSPHERE: ValidationCheck = ValidationCheck {
    name: "barometer",
    tier: ClosedForms,
    case: "validation/barometer",
    scene: "500 elastic hard spheres of 1 mm under gravity on a floor, φ = 0.004 there: mean height and its square, and temperatures below and above that height.",
    source: "Barometric law with the pressure of the second virial coefficient: heights h above touch have <h> = T/g (1 + 4 <φ>) and <h²> = 2 <h>² (1 - 2 <φ>); T is uniform.",
    not_shown: "Dense or dissipative layers, which are neither isothermal nor exponential.",
    takes_minutes: false,
    measure: atmosphere,
};

/// Sums over all particles and all samples (instants of measurement) of a run, from which the profile of the atmosphere
/// is computed.
#[derive(Default)]
struct Heights {
    samples: f64,
    height: f64,
    square: f64,
    /// Number of spheres [-] and sum of their squared velocities along y [m²/s²], first below the height T/g (granular
    /// temperature T, gravity g), then above it.
    halves: [[f64; 2]; 2],
    /// [m²/s²] sum of the squared speeds of all spheres.
    speeds: f64,
}

impl Heights {
    fn add(&mut self, particles: &Particles, gravity: f64) {
        let scale = temperature(particles) / gravity;
        for (x, v) in particles.position.iter().zip(&particles.velocity) {
            let height = x.y - particles.radius[0];
            self.samples += 1.0;
            self.height += height;
            self.square += height * height;
            self.speeds += v.norm_squared();
            let half = &mut self.halves[usize::from(height > scale)];
            half[0] += 1.0;
            half[1] += v.y * v.y;
        }
    }
}

fn atmosphere(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let gravity = 9.81;
    let (seeds, time) = scene.choose((8, 4.0), (24, 16.0));
    let runs = scene.replicas(seeds, |seed| {
        let mut simulation = scene.simulation(Model::Hard, Some(seed), &["run.duration=30 s".to_owned()])?;
        run_to(&mut simulation, 2.0, 400)?;
        let mut heights = Heights::default();
        let samples = (time / 0.02) as u64;
        for _ in 0..samples {
            simulation.run(1, 0.02).map_err(stopped)?;
            heights.add(&simulation.particles, gravity);
        }
        // each sphere counts with three degrees of freedom; that momentum along x and z is conserved changes the
        // temperature by 0.13 % only
        let temperature = heights.speeds / (3.0 * heights.samples);
        let mean = heights.height / heights.samples;
        let volume = simulation.count() as f64 * PI / 6.0 * 1e-9;
        // local volume fraction, averaged over the spheres: half of that at the floor
        let fraction = 0.5 * volume / (72e-3 * 72e-3 * mean);
        let [below, above] = heights.halves.map(|[count, square]| square / count);
        Ok([
            mean * gravity / (temperature * (1.0 + 4.0 * fraction)),
            heights.square / heights.samples / (2.0 * mean * mean * (1.0 - 2.0 * fraction)),
            above / below,
        ])
    })?;
    let names = ["<h> g/(T (1 + 4 <φ>))", "<h²>/(2 <h>² (1 - 2 <φ>))", "T_yy above over below T/g"];
    let number =
        |(k, name): (usize, &str)| averaged(name, "", Estimate::exact(1.0), runs.iter().map(|run| run[k]), 0.02);
    Ok(names.into_iter().enumerate().map(number).collect::<Vec<_>>().into())
}
