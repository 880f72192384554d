//! Error that comes from computing drag and straight flight one after the other (splitting), as a function of the
//! window, the time between two kicks (sudden changes of velocity) by the drag.

use super::picture::{curve, curves};
use super::scenes::{run, simulation};
use super::sweep::{KnownPoint, MapSweep, Points};
use crate::output::numbers::significant;
use crate::output::panel::SeriesStyle;
use crate::runs::StudyError;

/// Number of windows (times between two kicks of drag) in the reference run, 32 times that of the finest point of the
/// map. The method is of second order, so the error of the reference is (1/32)² of the error of this point.
const REFERENCE: u64 = 16_384;

/// Map of the errors of position and velocity at the end of a run, as a function of the window, the time between two
/// kicks of drag.
pub fn splitting(grid: &Points) -> Result<Vec<MapSweep>, StudyError> {
    let powers: Vec<u32> = grid.choose(vec![0, 3, 6, 9], (0..=9).collect());
    // [s] about the response time of the small sphere to drag, in the paper of docs/paper.md
    let duration = grid.base.run.duration;
    let at = |windows: u64| {
        let mut simulation = simulation(&grid.base)?;
        let failure = run(&mut simulation, windows, duration);
        Ok::<_, StudyError>((simulation.particles.position[0], simulation.particles.velocity[0], failure))
    };
    let reference = at(REFERENCE)?;
    let rows = grid.run(&powers, |&power| {
        let windows = 1 << power;
        let (place, velocity, failure) = at(windows)?;
        let (place, velocity) = ((place - reference.0).norm(), (velocity - reference.1).norm());
        Ok(KnownPoint { values: vec![duration / windows as f64, place, velocity], failure })
    })?;
    let (first, last) = (&rows[rows.len() / 2].values, &rows[rows.len() - 1].values);
    let order = (first[2] / last[2]).ln() / (first[0] / last[0]).ln();
    let millisecond = last[2] * (1e-3 / last[0]).powi(2);
    let lesson = format!(
        "Drag is applied in half-kicks around each window: second order (slope {} from the lower half of the points). For this sphere (Stokes time \
         0.52 s) windows of 1 ms cost {} m/s.",
        significant(order, 3),
        significant(millisecond, 2)
    );
    let of = |column: usize| rows.iter().map(move |row| [row.values[0], row.values[column]]);
    let slope = rows.iter().map(|row| [row.values[0], last[2] * (row.values[0] / last[0]).powi(2)]);
    let picture = curves(
        ["window  [s]", "error  [m], [m/s]"],
        [true; 2],
        vec![
            curve("second order", SeriesStyle::Reference, slope),
            curve("place", SeriesStyle::Points(0), of(1)),
            curve("velocity", SeriesStyle::Points(1), of(2)),
        ],
    );
    Ok(vec![MapSweep::new(rows, lesson, picture)])
}
