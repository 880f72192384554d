//! Decay of the anisotropy of the agitation (differences between the velocity variances of the three directions) as a
//! function of the stiffness. Soft spheres deflect one another less than hard spheres, so their anisotropy decays more
//! slowly.

use super::picture::{curve, curves, even, measured, points};
use super::scenes::{DIAMETER, collision_rate, fill, mass, mean, run, simulation, soften};
use super::sweep::{KnownPoint, MapSweep, Points};
use crate::contact_law::ContactLaw;
use crate::engine::Failure;
use crate::experiment::{Experiment, Spheres};
use crate::output::numbers::{significant, with_error};
use crate::output::panel::SeriesStyle;
use crate::particles::Particles;
use crate::predict::collision_integral::viscosity_integral;
use crate::runs::StudyError;
use crate::statistics::Estimate;
use std::f64::consts::{FRAC_2_PI, PI};

/// [-] volume fraction of the particles, as in case D of the paper (docs/paper.md).
const FRACTION: f64 = 0.01;
/// Number of collisions per particle before the first measurement of the anisotropy. By then, as many soft contacts
/// end as begin in a given time.
const BEFORE: f64 = 0.1;
/// Number of collisions per particle between the two measurements of the anisotropy. During this time the anisotropy
/// falls by a third. A longer time would increase the scatter, since later collisions of soft and hard spheres differ
/// by chance.
const DURING: f64 = 0.5;

/// [m²/s²] anisotropy T_z - (T_x + T_y)/2 of all particles. T_x, T_y and T_z are the variances of the velocity
/// components about their means.
fn anisotropy(particles: &Particles) -> f64 {
    let count = particles.len() as f64;
    let mean = particles.velocity.iter().sum::<nalgebra::Vector3<f64>>() / count;
    let squares = particles.velocity.iter().map(|v| (v - mean).component_mul(&(v - mean)));
    let variance = squares.sum::<nalgebra::Vector3<f64>>() / count;
    variance.z - 0.5 * (variance.x + variance.y)
}

/// [m²/s²] granular temperature of the particles at the start.
fn start_temperature(experiment: &Experiment) -> f64 {
    experiment.start[0].mean_fluctuation().powi(2)
}

/// [1/s] rate -d(ln A)/dt at which the anisotropy A of the velocities decays in a run. The second part is the failure
/// of the run if it stopped early, otherwise `None`.
fn rate(experiment: &Experiment) -> Result<(f64, Option<Failure>), StudyError> {
    /// Number of windows (equal pieces of a run) per mean time between two collisions of a particle. With so many
    /// windows, few particles collide twice within a window.
    const WINDOWS: f64 = 40.0;
    let time = 1.0 / collision_rate(FRACTION, start_temperature(experiment));
    let mut simulation = simulation(experiment)?;
    let failure = run(&mut simulation, (WINDOWS * BEFORE) as u64, BEFORE * time);
    let before = anisotropy(&simulation.particles);
    let failure = failure.or_else(|| run(&mut simulation, (WINDOWS * DURING) as u64, DURING * time));
    Ok(((before / anisotropy(&simulation.particles)).ln() / (DURING * time), failure))
}

/// Map of the decay rate of the anisotropy of soft spheres, divided by that of hard spheres, as a function of the
/// overlap number κ_n. For spheres of mass m, diameter d and stiffness k at the granular temperature T, this number is
/// sqrt(2/π) sqrt(mT/k)/d.
pub fn anisotropy_decay(grid: &Points) -> Result<Vec<MapSweep>, StudyError> {
    let (kappas, count, seeds) =
        grid.choose((vec![0.05], 10_000, 6), (vec![0.003, 0.009, 0.02, 0.035, 0.05], 20_000, 48));
    let seeds = even(1.0, f64::from(seeds), seeds as usize);
    // overlap number κ_n = sqrt(2/π) sqrt(m T/k)/d
    let softness = |kappa: f64| kappa / FRAC_2_PI.sqrt();
    let temperature = start_temperature(&grid.base);
    let stiffness = |kappa: f64| mass() * temperature / (softness(kappa) * DIAMETER).powi(2);
    // in this list, an overlap number κ_n of 0 stands for hard spheres
    let all: Vec<f64> = std::iter::once(0.0).chain(kappas.iter().copied()).collect();
    let runs = grid.run(&points(&seeds, &all), |&(seed, kappa)| {
        let experiment = grid.with(|case| {
            case.run.seed = seed as u64;
            fill(case, count, FRACTION);
            if kappa > 0.0 {
                soften(case, ContactLaw::linear(stiffness(kappa)));
            } else {
                case.run.spheres = Spheres::Hard;
            }
        });
        rate(&experiment)
    })?;
    let (hard, soft) = runs.split_at(seeds.len());
    let row = |(&kappa, runs): (&f64, &[(f64, Option<Failure>)])| {
        // all runs with the same seed have the same start and nearly the same first collisions, so a large part of the
        // scatter cancels in the ratio
        let ratios: Vec<f64> = runs.iter().zip(hard).map(|(soft, hard)| soft.0 / hard.0).collect();
        let (ratio, error) = mean(&ratios, |ratio| *ratio);
        let s = softness(kappa);
        let failure = runs.iter().find_map(|run| run.1.clone());
        KnownPoint { values: vec![kappa, s, ratio, error, viscosity_integral(s), 1.0 - (2.0 * PI).sqrt() * s], failure }
    };
    let rows: Vec<KnownPoint> = kappas.iter().zip(soft.chunks(seeds.len())).map(row).collect();
    let rates = rows.iter().map(|row| [row.values[0], 100.0 * (row.values[2] - 1.0), 100.0 * row.values[3]]);
    let theory = |label: &str, look: SeriesStyle, of: &dyn Fn(f64) -> f64| {
        let at = even(0.0, kappas[kappas.len() - 1], 30).into_iter();
        curve(label, look, at.map(|kappa| [kappa, 100.0 * (of(softness(kappa)) - 1.0)]))
    };
    let picture = curves(
        ["κ_n = u_r/d √(M/k)  [-]", "rate of evening out against hard  [%]"],
        [false; 2],
        vec![
            theory("collision integral Ω⁽²·²⁾ of the spring", SeriesStyle::Reference, &viscosity_integral),
            theory("cross-section of d_eff", SeriesStyle::Line(1), &|s| 1.0 - (2.0 * PI).sqrt() * s),
            measured(format!("{count} spheres, φ = 0.01"), 0, rates),
        ],
    );
    let lesson = lesson(&rows);
    Ok(vec![MapSweep::new(rows, lesson, picture)])
}

fn lesson(rows: &[KnownPoint]) -> String {
    let Some(last) = rows.last() else { return String::new() };
    let percent = |value: f64| significant(100.0 * (1.0 - value), 3);
    format!(
        "At κ_n = {} collisions of soft spheres even out different agitations {} % more slowly than those of hard ones; the collision \
         integral of the spring says {} %, the cross-section of the effective diameter {} %. A flow that feeds one direction keeps \
         more agitation there.",
        last.values[0],
        with_error(Estimate::new(100.0 * (1.0 - last.values[2]), 100.0 * last.values[3])),
        percent(last.values[4]),
        percent(last.values[5])
    )
}
