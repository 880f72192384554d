//! Validation rows (comparisons with references) of gases that cool by inelastic collisions, of smooth and of rough
//! spheres.

use super::check::{CheckResult, CheckScene, ValidationCheck, averaged, run_to, stopped};
use super::gases::temperature;
use crate::experiment::Model;
use crate::kinetic_theory::contact_value;
use crate::output::ValidationTier::OtherCodes;
use crate::output::panel::{Panel, PanelSeries, SeriesPoint, SeriesStyle};
use crate::runs::StudyError;
use crate::simulation::Simulation;
use crate::statistics::Estimate;
use std::f64::consts::PI;

/// [1/s] collision rate of one sphere in a gas, by Enskog's theory: 24 φ g sqrt(T/π)/d (1 - 1/N) for N spheres of
/// diameter d at the volume fraction φ. The contact value g is that of Carnahan and Starling (1969). `temperature`
/// [m²/s²] is the granular temperature T.
pub fn enskog(simulation: &Simulation, temperature: f64) -> f64 {
    let (count, diameter) = (simulation.count() as f64, 2.0 * simulation.mean_radius());
    let fraction = count * PI / 6.0 * diameter.powi(3) / simulation.scene().domain.volume();
    let contact = contact_value(1.0, 1.0, fraction, fraction);
    24.0 * fraction * contact * (temperature / PI).sqrt() / diameter * (1.0 - 1.0 / count)
}

/// [-] temperature ratio T(t)/T(0) at `time` [s], by Haff's law. `rate` [1/s] is the collision rate of a sphere at the
/// start.
fn haff(restitution: f64, rate: f64, time: f64) -> f64 {
    (1.0 + (1.0 - restitution * restitution) * rate * time / 6.0).powi(-2)
}

/// Runs a cooling gas, and returns its temperature divided by the initial one [-] at each of the `times` [s]. Each
/// entry has the measured ratio, then that of Haff's law.
fn cool(simulation: &mut Simulation, restitution: f64, times: &[f64]) -> Result<Vec<[f64; 2]>, StudyError> {
    let start = temperature(&simulation.particles);
    let rate = enskog(simulation, start);
    let one = |&time: &f64| {
        let windows = (2.0 * rate * (time - simulation.time)).ceil().max(1.0);
        run_to(simulation, time, windows as u64)?;
        Ok([temperature(&simulation.particles) / start, haff(restitution, rate, time)])
    };
    times.iter().map(one).collect()
}

/// Comparison with a reference (row of the validation suite): temperature of a cooling gas, compared with Haff's law.
pub const HAFF: ValidationCheck = ValidationCheck {
    name: "haff",
    tier: OtherCodes,
    case: "cooling-gas",
    scene: "2000 hard spheres of 406 µm, φ = 0.05, e = 0.9, cool from T = 1 m²/s²: T over that at the start after 5, 10 and 20 ms.",
    source: "Haff (1983, J. Fluid Mech. 134, 401) with Enskog's rate and the contact value of Carnahan and Starling (1969): T_0 (1 + (1 - e²) Γ_0 t/6)^-2. These papers were not read.",
    not_shown: "Clusters: the box is smaller than they are. The law takes velocities as Gaussian, which costs 0.5 % at 20 ms.",
    takes_minutes: false,
    measure: cooling,
};

fn cooling(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let times = [5e-3, 10e-3, 20e-3];
    let runs = scene.replicas(scene.choose(8, 32), |seed| {
        let mut simulation = scene.simulation(Model::Hard, Some(seed), &[])?;
        cool(&mut simulation, 0.9, &times)
    })?;
    let number = |(k, time): (usize, &f64)| {
        let reference = runs[0][k][1];
        let name = format!("T/T_0 at {} ms", 1e3 * time);
        averaged(name, "", Estimate::exact(reference), runs.iter().map(|run| run[k][0]), 0.02 * reference)
    };
    Ok(times.iter().enumerate().map(number).collect::<Vec<_>>().into())
}

/// Comparison with a reference (row of the validation suite): cooling gas of the benchmark of MFIX-Exa.
pub const MFIX_EXA: ValidationCheck = ValidationCheck {
    name: "mfix-exa-cooling",
    tier: OtherCodes,
    case: "validation/mfix-exa-cooling",
    scene: "The granular part of MFIX-Exa's benchmark: 5005 spheres of 100 µm, φ = 0.01, e = 0.8, T_0 = 0.1 m²/s²; hard spheres, and soft ones with its stiffness of 10 N/m.",
    source: "Haff's law with Enskog's rate, as in the row haff. Scene: rporcu/Microphysics@1b0a34c0, benchmarks/01-HCS/Size0001/mfix.dat, and @1af04d25, benchmarks/01-HCS/par-gen.f90.",
    not_shown: "MFIX-Exa itself, whose results are not stored there, and the drag of its gas. A difference of the soft row is one of its stiffness.",
    takes_minutes: false,
    measure: mfix_exa,
};

fn mfix_exa(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let times = [5e-3, 50e-3];
    let mut numbers = Vec::new();
    for (model, name, seeds) in
        [(Model::Hard, "hard", scene.choose(5, 16)), (Model::Soft, "soft, 10 N/m", scene.choose(12, 24))]
    {
        let runs = scene.replicas(seeds, |seed| {
            let mut simulation = scene.simulation(model, Some(seed), &[])?;
            cool(&mut simulation, 0.8, &times)
        })?;
        for (k, time) in times.iter().enumerate() {
            let reference = runs[0][k][1];
            let name = format!("T/T_0 at {} ms, {name}", 1e3 * time);
            let found = runs.iter().map(|run| run[k][0]);
            numbers.push(averaged(name, "", Estimate::exact(reference), found, 0.02 * reference));
        }
    }
    Ok(numbers.into())
}

/// Comparison with a reference (row of the validation suite): first Sonine coefficient a_2 of the velocity
/// distribution of a cooling gas.
pub const SONINE: ValidationCheck = ValidationCheck {
    name: "sonine",
    tier: OtherCodes,
    case: "cooling-gas",
    scene: "4000 hard spheres cool at φ = 0.01 with e = 0.9, 0.8, 0.7, 0.5 (0.8 and 0.5 with --quick): a_2 = (3/5) <v⁴>/<v²>² - 1, from 5 to 25 collisions per sphere.",
    source: "van Noije and Ernst (1998, Granular Matter 1, 57): a_2 = 16 (1 - e)(1 - 2e²)/(81 - 17e + 30e²(1 - e)). The formula is quoted from memory and gives the values known for it, -0.0146, -0.0126, 0.0013, 0.0525.",
    not_shown: "Higher coefficients and the tail. The theory is linear in a_2.",
    takes_minutes: false,
    measure: sonine,
};

/// [-] Sonine coefficient a_2 of a cooling gas by van Noije and Ernst. `e` [-] is the restitution.
fn linear_theory(e: f64) -> f64 {
    16.0 * (1.0 - e) * (1.0 - 2.0 * e * e) / (81.0 - 17.0 * e + 30.0 * e * e * (1.0 - e))
}

fn sonine(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let edge = (4000.0 * PI / 6.0 / 0.01_f64).cbrt() * 406e-6;
    let mut base: Vec<String> = (0..3).map(|axis| format!("domain.size[{axis}]={edge} m")).collect();
    base.push("particles[0].volume_fraction=0.01".to_owned());
    let (mut numbers, mut points) = (Vec::new(), Vec::new());
    for &e in scene.choose(&[0.8, 0.5][..], &[0.9, 0.8, 0.7, 0.5]) {
        let mut sets = base.clone();
        sets.push(format!("contact.restitution={e}"));
        let runs = scene.replicas(scene.choose(12, 48), |seed| {
            let mut simulation = scene.simulation(Model::Hard, Some(seed), &sets)?;
            excess(&mut simulation)
        })?;
        let number = averaged(format!("a_2, e = {e}"), "", Estimate::exact(linear_theory(e)), runs, 0.006);
        points.push(SeriesPoint { x: e, y: number.ours.value, error: number.ours.error });
        numbers.push(number);
    }
    let line = (0..=60).map(|k| 0.4 + f64::from(k) / 100.0).map(|e| SeriesPoint::at(e, linear_theory(e)));
    let panel = Panel {
        x_label: "restitution, e  [-]".into(),
        y_label: "a₂  [-]".into(),
        series: vec![
            PanelSeries::new("van Noije and Ernst 1998", SeriesStyle::Exact, line),
            PanelSeries::new("this program", SeriesStyle::Points(0), points),
        ],
        ..Panel::default()
    };
    Ok(CheckResult {
        numbers,
        picture: Some(("First Sonine coefficient of a cooling gas. Bars: one standard error.", panel)),
    })
}

/// [-] mean of the Sonine coefficient a_2 over 20 samples. About one collision per sphere precedes each sample, and the
/// first five collisions per sphere are not sampled.
fn excess(simulation: &mut Simulation) -> Result<f64, StudyError> {
    let (mut sum, mut samples) = (0.0, 0.0);
    for step in 0..25 {
        let window = 1.0 / enskog(simulation, temperature(&simulation.particles));
        simulation.run(2, 0.5 * window).map_err(stopped)?;
        if step >= 5 {
            let particles = &simulation.particles;
            let mean = particles.mean_velocity();
            let squares = particles.velocity.iter().map(|v| (v - mean).norm_squared());
            let (second, fourth) = squares.fold((0.0, 0.0), |(a, b), v| (a + v, b + v * v));
            sum += 0.6 * fourth * particles.len() as f64 / (second * second) - 1.0;
            samples += 1.0;
        }
    }
    Ok(sum / samples)
}

/// Comparison with a reference (row of the validation suite): temperatures of a cooling gas of rough spheres.
pub const ROUGH: ValidationCheck = ValidationCheck {
    name: "rough-gas",
    tier: OtherCodes,
    case: "rotation/rough-gas",
    scene: "2000 rough hard spheres cool at φ = 0.01 with e = 0.9, β_0 = 0.4 and no limit of friction, from T_r = T: both temperatures after 1 and 5 collisions per sphere, and their ratio after 20.",
    source: "Direct simulation Monte Carlo with 16,000 and 5 × 40,000 spheres, computed independently for this project (docs/rotation.md, Tested against reference values).",
    not_shown: "Rebounds in gross sliding, and dense gases.",
    takes_minutes: false,
    measure: rough,
};

/// Reference values for a cooling gas of rough spheres (Monte Carlo): number of collisions per sphere, then granular
/// temperature T and rotational temperature T_r [-], each with its standard error. T and T_r are equal at the start,
/// and are divided by this value.
const MONTE_CARLO: [(f64, [(f64, f64); 2]); 2] =
    [(1.0, [(0.86357, 0.00093), (0.81901, 0.00040)]), (5.0, [(0.45934, 0.00064), (0.38795, 0.00048)])];

/// [-] reference value of the ratio T_r/T of rotational to translational temperature in the final state of a gas of
/// rough spheres, with its standard error.
const FINAL_RATIO: (f64, f64) = (0.7899, 0.0018);

fn rough(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let edge = (2000.0 * PI / 6.0 / 0.01_f64).cbrt() * 0.3e-3;
    let mut sets: Vec<String> = (0..3).map(|axis| format!("domain.size[{axis}]={edge} m")).collect();
    sets.extend(
        [
            "particles[0].volume_fraction=0.01",
            "contact.friction=100",
            "hard.friction.walton.tangential_restitution=0.4",
        ]
        .map(str::to_owned),
    );
    let runs = scene.replicas(scene.choose(12, 48), |seed| {
        let mut simulation = scene.simulation(Model::Hard, Some(seed), &sets)?;
        temperatures(&mut simulation)
    })?;
    let mut numbers = Vec::new();
    for (k, (tau, expected)) in MONTE_CARLO.into_iter().enumerate() {
        for (which, name) in ["T", "T_r"].into_iter().enumerate() {
            let (value, error) = expected[which];
            let found = runs.iter().map(|run| run[k][which]);
            let name = format!("{name} after {tau} collisions");
            numbers.push(averaged(name, "", Estimate::new(value, error), found, 0.02 * value));
        }
    }
    let ratios = runs.iter().map(|run| run[2][1] / run[2][0]);
    let (value, error) = FINAL_RATIO;
    numbers.push(averaged("T_r/T after 20 collisions", "", Estimate::new(value, error), ratios, 0.02 * value));
    Ok(numbers.into())
}

/// Measured granular temperature T and rotational temperature T_r [-], both divided by the mean of the initial T and
/// T_r. Each entry belongs to a number of collisions per sphere: first those of [`MONTE_CARLO`], then 20.
fn temperatures(simulation: &mut Simulation) -> Result<Vec<[f64; 2]>, StudyError> {
    let both = |simulation: &Simulation| {
        let particles = &simulation.particles;
        let turning = 2.0 * particles.rotational_energy() / (3.0 * particles.total_mass());
        [temperature(particles), turning]
    };
    let start = both(simulation);
    let unit = 0.5 * (start[0] + start[1]);
    let (mut last, mut next) = ((0.0, start), (0.0, start));
    let mut reached = Vec::new();
    for tau in MONTE_CARLO.iter().map(|row| row.0).chain([20.0]) {
        while next.0 < tau {
            let window = 0.1 / enskog(simulation, next.1[0]);
            simulation.run(1, window).map_err(stopped)?;
            last = next;
            next = (2.0 * simulation.record.pairs.count as f64 / simulation.count() as f64, both(simulation));
        }
        let share = (tau - last.0) / (next.0 - last.0);
        reached.push([0, 1].map(|k| (last.1[k] + share * (next.1[k] - last.1[k])) / unit));
    }
    Ok(reached)
}
