//! Soft spheres whose stiffness is too low for their speed: deep overlaps, and passage through a thin plate.

use super::picture::{MapAxis, even, plane, points, ratios};
use super::scenes::{DIAMETER, STIFFNESS, mass, place, run, simulation, soften};
use super::sweep::{KnownPoint, MapSweep, Points};
use crate::contact_law::ContactLaw;
use crate::engine::Failure;
use crate::experiment::TimeStep;
use crate::output::limits::Shade;
use crate::output::numbers::significant;
use crate::runs::StudyError;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// [-] thickness of the plate, divided by the diameter of the sphere.
const PLATE: f64 = 0.1;
/// [m] height y of the middle plane of the plate.
const MIDDLE: f64 = 0.02;

/// Map of the largest overlap of two colliding spheres, as a function of impact speed and stiffness.
pub fn pair(grid: &Points) -> Result<Vec<MapSweep>, StudyError> {
    let count = grid.choose(13, 25);
    let (speed, stiffness) = (ratios(0.01, 100.0, count), ratios(0.01, 1e5, count));
    let reduced = 0.5 * mass();
    let rows = grid.run(&points(&speed, &stiffness), |&(speed, stiffness)| {
        // time from a gap of 0.594 mm to the first touch, then two contact times
        let duration = 0.6e-3 / speed + 2.0 * (PI * (reduced / stiffness).sqrt());
        let sphere = |x: f64, speed: f64| (Vector3::new(x, 1e-3, 1e-3), Vector3::new(speed, 0.0, 0.0));
        let mut simulation = simulation(&grid.with(|case| {
            place(case, vec![sphere(4.5e-3, 0.5 * speed), sphere(5.5e-3, -0.5 * speed)]);
            soften(case, ContactLaw::linear(stiffness));
        }))?;
        let failure = run(&mut simulation, 1, duration);
        let overlap = match &failure {
            Some(Failure::OverlapTooLarge { ratio, .. }) => *ratio,
            // the overlap is zero if the spheres have not touched
            _ => simulation.record.pairs.summary().largest_overlap.unwrap_or(0.0),
        };
        let predicted = speed * (reduced / stiffness).sqrt() / DIAMETER;
        Ok(KnownPoint { values: vec![speed, stiffness, overlap, predicted], failure })
    })?;
    let level = |row: &KnownPoint| {
        if row.failure.is_some() { 3 } else { [0.01, 0.1].iter().filter(|end| row.values[2] > **end).count() }
    };
    let line = |ratio: f64| speed.iter().map(|u| (*u, reduced * (u / (ratio * DIAMETER)).powi(2))).collect::<Vec<_>>();
    let picture = plane(
        &MapAxis("impact speed, u_n  [m/s]", &speed, true),
        &MapAxis("stiffness, k_n  [N/m]", &stiffness, true),
        &[
            ("δ/d below 0.01", Shade::Level(0)),
            ("to 0.1", Shade::Level(1)),
            ("to 0.5", Shade::Level(2)),
            ("stopped: OverlapTooLarge", Shade::Fails),
        ],
        |k| level(&rows[k]),
        vec![("u√(M/k) = 0.5 d", line(0.5)), ("u√(M/k) = 0.01 d", line(0.01))],
    );
    let wrong = rows.iter().filter(|row| row.failure.is_some() != (row.values[3] > 0.5)).count();
    let lesson = format!(
        "The overlap is u√(M/k): for 1 % of a diameter at 1 m/s these spheres need k = {:.0} N/m. Beyond half a diameter a run stops with \
         OverlapTooLarge; {} of {} cells lie on the side of that line that the closed form says.",
        reduced * (1.0 / (0.01 * DIAMETER)).powi(2),
        rows.len() - wrong,
        rows.len()
    );
    Ok(vec![MapSweep::new(rows, lesson, picture)])
}

/// Point of the map of spheres that hit a thin plate. `reduced` [-] is their speed divided by d ω_0 (diameter times
/// undamped angular frequency), `steps` the number of steps per contact. The `phases` spheres, one per run, reach the
/// plate at equally spaced instants within a step. The point also has the share of runs that stopped because the
/// overlap was too large, and the share of spheres that passed through the plate without a failure.
fn through_plate(grid: &Points, reduced: f64, steps: f64, phases: i32) -> Result<KnownPoint, StudyError> {
    let frequency = (STIFFNESS / mass()).sqrt();
    let speed = reduced * DIAMETER * frequency;
    let step = PI / frequency / steps;
    let (mut failure, mut passed, mut stopped) = (None, 0, 0);
    for phase in 0..phases {
        let height =
            0.5 * (1.0 + PLATE) * DIAMETER + speed * step * (1.0 + (f64::from(phase) + 0.5) / f64::from(phases));
        let mut simulation = simulation(&grid.with(|case| {
            place(case, vec![(Vector3::new(2e-3, MIDDLE + height, 2e-3), Vector3::new(0.0, -speed, 0.0))]);
            case.soft.time_step = TimeStep::PerContact(steps);
        }))?;
        // time of two steps to the plate, two further steps, and one and a half contact times
        let duration = step * (4.0 + (1.5 * steps).ceil());
        let mut why = run(&mut simulation, 1, 4.0 * step);
        let below = simulation.particles.position[0].y < MIDDLE && simulation.particles.velocity[0].y < 0.0;
        if !below && why.is_none() {
            why = run(&mut simulation, 1, duration - 4.0 * step);
        }
        match why {
            Some(why @ Failure::OverlapTooLarge { .. }) => {
                stopped += 1;
                failure = failure.or(Some(why));
            }
            _ if below => passed += 1,
            _ => {}
        }
    }
    let share = |count: i32| f64::from(count) / f64::from(phases);
    Ok(KnownPoint { values: vec![reduced, steps, share(stopped), share(passed)], failure })
}

/// Map of the passage of a soft sphere through a thin plate, as a function of its speed and of the steps per contact
/// N_c.
pub fn plate(grid: &Points) -> Result<Vec<MapSweep>, StudyError> {
    let (speed, steps, phases) = grid.choose(
        (even(0.2, 4.0, 20), vec![2.0, 3.0, 4.0, 5.0, 7.0, 10.0], 8),
        (even(0.1, 6.0, 60), vec![1.6, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 15.0], 24),
    );
    let rows = grid.run(&points(&speed, &steps), |&(reduced, steps)| through_plate(grid, reduced, steps, phases))?;
    let level = |row: &KnownPoint| match (row.values[2] > 0.0, row.values[3] > 0.0) {
        (_, true) => 2,
        (true, false) => 1,
        (false, false) => 0,
    };
    let jump = even(steps[0] * 0.8, steps[steps.len() - 1] * 1.1, 60).into_iter();
    let jump = jump.map(|steps| (0.5 * (1.0 + PLATE) * steps / PI, steps)).collect();
    let picture = plane(
        &MapAxis("impact speed over d ω₀  [-]", &speed, false),
        &MapAxis("steps per contact, N_c  [-]", &steps, true),
        &[
            ("turned back", Shade::Level(0)),
            ("stopped: OverlapTooLarge", Shade::Fails),
            ("some pass unseen", Shade::Silent),
        ],
        |k| level(&rows[k]),
        vec![("a step carries the centre past the middle", jump)],
    );
    let slowest = |fewest: f64| {
        let passed = rows.iter().filter(|row| row.values[3] > 0.0 && row.values[1] >= fewest);
        passed.map(|row| row.values[0]).fold(f64::INFINITY, f64::min)
    };
    let (seen, resolved) = (slowest(0.0), slowest(5.0));
    let unseen = match (seen.is_finite(), resolved.is_finite()) {
        (false, _) => "On this map nothing passes unseen".to_owned(),
        (true, false) => {
            format!("It passes unseen from u = {} d ω₀ on, but with 5 steps or more never here", significant(seen, 2))
        }
        (true, true) => format!(
            "It passes unseen from u = {} d ω₀ on, with 5 steps or more from {} on",
            significant(seen, 2),
            significant(resolved, 2)
        ),
    };
    let lesson = format!(
        "A sphere whose centre gets into a body, or to its other side, is stopped with OverlapTooLarge: that happens above u = d ω₀/2. {unseen}: \
         there one step carries its centre from outside to beyond the plate’s middle, at speeds that the overlap has long forbidden."
    );
    Ok(vec![MapSweep::new(rows, lesson, picture)])
}
