//! Numerical heating of an elastic gas of soft spheres by the second-order Runge-Kutta method.

use super::picture::{curve, curves, even, measured, points};
use super::scenes::{collision_rate, mean, run, simulation};
use super::sweep::{KnownPoint, MapSweep, Points};
use crate::contact_law::ContactLaw;
use crate::engine::Failure;
use crate::experiment::TimeStep;
use crate::output::numbers::with_error;
use crate::output::panel::SeriesStyle;
use crate::predict::integrator::{Scheme, heating_per_collision, realised_restitution, unit_spring};
use crate::runs::StudyError;
use crate::statistics::Estimate;

/// [m/s] standard deviation of each velocity component at the start. It gives the granular temperature 0.49 m²/s², as
/// in case D of the paper (docs/paper.md).
const SPEED: f64 = 0.7;
/// [-] volume fraction of the particles. Pairs then collide often, and three particles at once seldom.
const FRACTION: f64 = 0.1;

/// Map of the relative change of the temperature of an elastic gas per collision of a particle, as a function of the
/// steps per contact N_c. The exact change is zero, so the computed change is an error of the integrator.
pub fn heating(grid: &Points) -> Result<Vec<MapSweep>, StudyError> {
    let (steps, seeds, collisions) = grid.choose(
        (vec![5.0, 7.735, 10.0, 15.0], 3, 20.0),
        (vec![5.0, 6.0, 7.0, 7.735, 9.0, 10.94, 13.0, 15.0, 20.0], 6, 40.0),
    );
    let seeds = even(1.0, f64::from(seeds), seeds as usize);
    let duration = collisions / collision_rate(FRACTION, SPEED * SPEED);
    let runs = grid.run(&points(&seeds, &steps), |&(seed, steps)| {
        let mut simulation = simulation(&grid.with(|case| {
            case.run.seed = seed as u64;
            case.soft.time_step = TimeStep::PerContact(steps);
        }))?;
        let start = simulation.energy();
        let failure = run(&mut simulation, 20, duration);
        let suffered = 2.0 * simulation.record.pairs.count as f64 / simulation.particles.len() as f64;
        Ok(((simulation.energy() / start).ln() / suffered, failure))
    })?;
    let scheme = Scheme::of(grid.base.soft.integrator, grid.base.soft.stepping);
    let predicted = |steps: f64| {
        let law = ContactLaw::linear(1.0);
        Some(heating_per_collision(&realised_restitution(scheme, &law, (&unit_spring(1.0), 1.0), steps)?))
    };
    let row = |(runs, &steps): (&[(f64, Option<Failure>)], &f64)| {
        let (value, error) = mean(runs, |run| run.0);
        let failure = runs.iter().find_map(|run| run.1.clone());
        Some(KnownPoint { values: vec![steps, value, error, predicted(steps)?], failure })
    };
    // an elastic contact of five steps or more always ends, so no row is left out
    let rows: Vec<KnownPoint> = runs.chunks(seeds.len()).zip(&steps).filter_map(row).collect();
    let percent = |row: &KnownPoint, k: usize| 100.0 * row.values[k];
    let paper = rows.iter().find(|row| row.values[0] == 7.735);
    let lesson = paper.map_or(String::new(), |row| {
        format!(
            "At N_c = 7.735, the paper’s step, an elastic gas gains {} % of its temperature per collision that a particle suffers \
             ({:.2} % from the linear map), so that it doubles in {:.0}; the gain falls with the third power of the step.",
            with_error(Estimate::new(percent(row, 1), percent(row, 2))),
            percent(row, 3),
            2.0f64.ln() / row.values[1]
        )
    });
    let theory = (0..=60).map(|k| steps[0] + (steps[steps.len() - 1] - steps[0]) * f64::from(k) / 60.0);
    let theory = theory.filter_map(|n| Some([n, 100.0 * predicted(n)?]));
    let heated = rows.iter().map(|row| [row.values[0], percent(row, 1), percent(row, 2)]);
    let picture = curves(
        ["steps per contact, N_c  [-]", "heating per collision  [%]"],
        [false, true],
        vec![
            curve("linear map, (⟨e²⟩ − 1)/3", SeriesStyle::Reference, theory),
            measured("1000 spheres, φ = 0.1", 0, heated),
        ],
    );
    Ok(vec![MapSweep::new(rows, lesson, picture)])
}
