//! Collision rate of soft spheres as a function of their softness: soft spheres behave like smaller hard spheres. The
//! softness is sqrt(m T/k)/d, with the mass m, the granular temperature T, the stiffness k and the diameter d.

use super::picture::{curve, curves, even, measured, points};
use super::scenes::{DIAMETER, collision_rate, mass, mean, run, simulation, soften, temperature};
use super::sweep::{KnownPoint, MapSweep, Points};
use crate::contact_law::ContactLaw;
use crate::engine::Failure;
use crate::experiment::{Experiment, Spheres};
use crate::output::numbers::{significant, with_error};
use crate::output::panel::SeriesStyle;
use crate::runs::StudyError;
use crate::statistics::Estimate;
use std::f64::consts::PI;

/// [m/s] standard deviation of each velocity component at the start.
const SPEED: f64 = 0.7;
/// [-] volume fraction of the particles.
const FRACTION: f64 = 0.1;
/// Number of instants in a run at which the temperature is measured.
const SAMPLES: u32 = 50;

/// [N/m] stiffness k of the contact springs for which the softness sqrt(m T/k)/d equals `softness` [-].
fn stiffness(softness: f64) -> f64 {
    mass() * (SPEED / (softness * DIAMETER)).powi(2)
}

/// [-] effective diameter of soft spheres divided by their diameter, d_eff/d = 1 - sqrt(π m T/(2k))/d (Barker and
/// Henderson 1967, for a linear spring). `softness` [-] is sqrt(m T/k)/d.
fn effective_diameter(softness: f64) -> f64 {
    1.0 - (PI / 2.0).sqrt() * softness
}

/// [-] collision rate of hard spheres of the effective diameter d_eff, divided by that of hard spheres of the full
/// diameter d. `softness` [-] is sqrt(m T/k)/d.
fn of_smaller_spheres(softness: f64) -> f64 {
    let smaller = effective_diameter(softness);
    collision_rate(FRACTION * smaller.powi(3), 1.0) / smaller / collision_rate(FRACTION, 1.0)
}

/// [-] rate at which soft spheres touch at the distance d, divided by the rate of hard spheres. `softness` [-] is
/// sqrt(mT/k)/d. This rate is proportional to the pair distribution at the distance d. It is taken as that of hard
/// spheres of diameter d_eff: g + g'(d-d_eff), with contact value g and slope g'. The slope -(9/2)φ(1+φ)/(1-φ)³/d_eff
/// is from Percus and Yevick's equation (Wertheim 1963), with the volume fraction φ of spheres of diameter d_eff.
fn touches(softness: f64) -> f64 {
    let contact = |fraction: f64| (1.0 - 0.5 * fraction) / (1.0 - fraction).powi(3);
    let smaller = effective_diameter(softness);
    let fraction = FRACTION * smaller.powi(3);
    let slope = -4.5 * fraction * (1.0 + fraction) / (1.0 - fraction).powi(3);
    (contact(fraction) + slope * (1.0 / smaller - 1.0)) / contact(FRACTION)
}

/// [1/m] collision rate of one sphere divided by the square root of the granular temperature, measured in a run of
/// `duration` [s]. The second part is the failure of the run if it stopped early, otherwise `None`.
fn rate(experiment: &Experiment, duration: f64) -> Result<(f64, Option<Failure>), StudyError> {
    let mut simulation = simulation(experiment)?;
    // the influence of the start decays during the first tenth of the time, which is not measured
    let mut failure = run(&mut simulation, 5, 0.1 * duration);
    let before = simulation.record.pairs.count;
    let mut roots = 0.0;
    for _ in 0..SAMPLES {
        let half = 0.45 * duration / f64::from(SAMPLES);
        failure = failure.or_else(|| run(&mut simulation, 1, half));
        roots += temperature(&simulation).sqrt() / f64::from(SAMPLES);
        failure = failure.or_else(|| run(&mut simulation, 1, half));
    }
    let collisions = 2.0 * (simulation.record.pairs.count - before) as f64 / simulation.particles.len() as f64;
    Ok((collisions / (0.9 * duration) / roots, failure))
}

/// Map of the collision rate of soft spheres, divided by that of hard spheres, as a function of the softness
/// sqrt(mT/k)/d.
pub fn softness(grid: &Points) -> Result<Vec<MapSweep>, StudyError> {
    let (softness, seeds, collisions) = grid.choose(
        (vec![0.01, 0.02, 0.05], 3, 30.0),
        (vec![0.003, 0.005, 0.0075, 0.01, 0.015, 0.02, 0.03, 0.05], 8, 100.0),
    );
    let seeds = even(1.0, f64::from(seeds), seeds as usize);
    let duration = collisions / collision_rate(FRACTION, SPEED * SPEED);
    // in this list, softness 0 stands for hard spheres
    let all: Vec<f64> = std::iter::once(0.0).chain(softness.iter().copied()).collect();
    let runs = grid.run(&points(&seeds, &all), |&(seed, softness)| {
        let experiment = grid.with(|case| {
            case.run.seed = seed as u64;
            if softness > 0.0 {
                soften(case, ContactLaw::linear(stiffness(softness)));
            } else {
                case.run.spheres = Spheres::Hard;
            }
        });
        rate(&experiment, duration)
    })?;
    let (hard, soft) = runs.split_at(seeds.len());
    let (reference, reference_error) = mean(hard, |run| run.0);
    let row = |(&softness, runs): (&f64, &[(f64, Option<Failure>)])| {
        let (value, error) = mean(runs, |run| run.0);
        let ratio = value / reference;
        let error = ratio * (error / value).hypot(reference_error / reference);
        let fraction = (1.0 - (PI / 2.0).sqrt() * softness).powi(3) - 1.0;
        let smaller = of_smaller_spheres(softness);
        let failure = runs.iter().find_map(|run| run.1.clone());
        KnownPoint { values: vec![softness, ratio, error, touches(softness), smaller, fraction], failure }
    };
    let rows: Vec<KnownPoint> = softness.iter().zip(soft.chunks(seeds.len())).map(row).collect();
    let lesson = rows.iter().find(|row| row.values[0] == 0.01).map_or(String::new(), |row| {
        format!(
            "At √(mT/k) = 0.01 d (about the paper’s) soft spheres fill {} % less volume than hard ones, and touch {} % less often (theory {} %): \
             they still touch at d, but crowd one another less. Hard spheres of the effective diameter, right for pressure, would collide {} % less often.",
            significant(-100.0 * row.values[5], 2),
            with_error(Estimate::new(100.0 * (1.0 - row.values[1]), 100.0 * row.values[2])),
            significant(100.0 * (1.0 - row.values[3]), 2),
            significant(100.0 * (1.0 - row.values[4]), 2)
        )
    });
    let rates = rows.iter().map(|row| [row.values[0], 100.0 * (row.values[1] - 1.0), 100.0 * row.values[2]]);
    let last = softness[softness.len() - 1];
    let theory = |label: &str, look: SeriesStyle, of: fn(f64) -> f64| {
        curve(label, look, even(0.0, last, 60).into_iter().map(|s| [s, 100.0 * (of(s) - 1.0)]))
    };
    let picture = curves(
        ["softness, √(mT/k)/d  [-]", "collision rate against hard  [%]"],
        [false; 2],
        vec![
            theory("touching at d among spheres of d_eff", SeriesStyle::Reference, touches),
            theory("hard spheres of d_eff", SeriesStyle::Line(1), of_smaller_spheres),
            measured("1000 spheres, φ = 0.1", 0, rates),
        ],
    );
    Ok(vec![MapSweep::new(rows, lesson, picture)])
}
