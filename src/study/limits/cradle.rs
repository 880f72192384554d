//! Several contacts at once: rows of spheres that pass on an impulse, and one sphere that is hit from both sides.

use super::picture::{curve, curves, even};
use super::scenes::{restitute, row, run, simulation, speeds};
use super::sweep::{KnownPoint, MapSweep, Points};
use crate::experiment::{Experiment, Spheres};
use crate::output::numbers::significant;
use crate::output::panel::SeriesStyle;
use crate::runs::StudyError;
use crate::simulation::Simulation;
use std::f64::consts::PI;

/// [N/m] stiffness k_n of the soft spheres. A contact of two spheres of 1 kg then lasts 2.2 ms.
const STIFFNESS: f64 = 1e6;
/// [-] restitutions with which the row of touching spheres is simulated.
const RESTITUTIONS: [f64; 2] = [1.0, 0.94];
/// [m] length of the box along the row of spheres.
const LENGTH: f64 = 30.0;

/// Two simulations of the case after the function `change` has changed it: first with soft spheres, then with hard
/// spheres.
fn both(grid: &Points, change: impl Fn(&mut Experiment)) -> Result<[Simulation; 2], StudyError> {
    let soft = grid.with(&change);
    let hard = grid.with(|case| {
        change(case);
        case.run.spheres = Spheres::Hard;
    });
    Ok([simulation(&soft)?, simulation(&hard)?])
}

/// Map of the velocity of the last sphere in a row of touching spheres after another sphere has hit the row, as a
/// function of the number of spheres.
pub fn cradle(grid: &Points) -> Result<Vec<MapSweep>, StudyError> {
    let points: Vec<(usize, f64)> =
        RESTITUTIONS.iter().flat_map(|e| (2..=grid.choose(5, 8)).map(|n| (n, *e))).collect();
    let rows = grid.run(&points, |&(count, e)| {
        let (mut gaps, mut velocities) = (vec![0.0; count], vec![0.0; count]);
        (gaps[0], gaps[1], velocities[0]) = (4.0, 1e-3, 1.0);
        let models = both(grid, |case| {
            row(case, LENGTH, &gaps, &velocities);
            restitute(case, e);
        })?;
        let [soft, hard] = models.map(|mut simulation| {
            let failure = run(&mut simulation, 1, 0.1);
            let speeds = speeds(&simulation);
            (speeds[0], speeds[count - 1], simulation.energy() / 0.5, failure)
        });
        let values = vec![count as f64, e, soft.1, hard.1, soft.0, hard.0, soft.2, hard.2];
        Ok(KnownPoint { values, failure: soft.3.or(hard.3) })
    })?;
    let three = rows.iter().find(|row| row.values[0] == 3.0 && row.values[1] == 1.0);
    let lesson = three.map_or(String::new(), |row| {
        format!(
            "Of three elastic spheres the last leaves with {} when soft and {} when hard, and the first recoils with {}: springs share the blow \
             while all touch, hard spheres pass it on one by one. Neither is wrong; only touching spheres differ.",
            significant(row.values[2], 4),
            significant(row.values[3], 4),
            significant(row.values[4], 4)
        )
    });
    let last = |k: usize, e: f64, column: usize, name: &str| {
        let of = rows.iter().filter(|row| row.values[1] == e);
        curve(format!("{name}, e = {e}"), SeriesStyle::Line(k), of.map(|row| [row.values[0], row.values[column]]))
    };
    let picture = curves(
        ["spheres in all  [-]", "velocity of the last  [m/s]"],
        [false; 2],
        vec![last(0, 1.0, 2, "soft"), last(1, 1.0, 3, "hard"), last(2, 0.94, 2, "soft"), last(3, 0.94, 3, "hard")],
    );
    Ok(vec![MapSweep::new(rows, lesson, picture)])
}

/// Map of the velocity of the middle one of three spheres, which is hit from both sides, as a function of the delay
/// between the hits. The delay is the time from the hit from the left to the hit from the right, divided by the contact
/// time [-]. It is negative if the hit from the right comes first.
pub fn simultaneous(grid: &Points) -> Result<Vec<MapSweep>, StudyError> {
    let contact = PI * (0.5 / STIFFNESS).sqrt();
    let late = even(-2.0, 2.0, grid.choose(17, 81));
    let rows = grid.run(&late, |&late| {
        let models = both(grid, |case| row(case, LENGTH, &[4.0, 1.0, 1.0 + late * contact], &[1.0, 0.0, -1.0]))?;
        let [soft, hard] = models.map(|mut simulation| {
            let failure = run(&mut simulation, 1, 3.0);
            (speeds(&simulation)[1], failure)
        });
        Ok(KnownPoint { values: vec![late, soft.0, hard.0], failure: soft.1.or(hard.1) })
    })?;
    let fastest = |column: usize| rows.iter().map(|row| row.values[column].abs()).fold(0.0, f64::max);
    let (soft_speed, hard_speed) = (fastest(1), fastest(2));
    let apart = rows.iter().filter(|row| (row.values[1] - row.values[2]).abs() > 0.1 * hard_speed);
    let apart = apart.map(|row| row.values[0].abs()).fold(0.0, f64::max);
    let lesson = format!(
        "Hard spheres only know who came first: the middle one leaves with {} m/s to one side or the other, however near the two hits are, \
         and at the same instant the order of the particles decides. Soft ones share the blow: up to {} m/s, and as hard ones only when the \
         hits are more than {} contact times apart.",
        significant(hard_speed, 2),
        significant(soft_speed, 2),
        significant(apart, 2)
    );
    let middle = |label: &str, k: usize| {
        curve(label, SeriesStyle::Points(k), rows.iter().map(move |row| [row.values[0], 1e3 * row.values[1 + k]]))
    };
    let picture = curves(
        ["right after left, over the contact time  [-]", "velocity of the middle one  [mm/s]"],
        [false; 2],
        vec![middle("soft", 0), middle("hard", 1)],
    );
    Ok(vec![MapSweep::new(rows, lesson, picture)])
}
