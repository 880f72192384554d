//! Hard spheres that move in time steps: collisions are searched at the end of each step. Some collisions are therefore
//! missed, and others are found after the spheres have overlapped. The step criterion θ is the distance by which a
//! typical pair of spheres approaches in one step, divided by the diameter.

use super::picture::{curve, curves, even, measured, points};
use super::scenes::{collision_rate, mean, run, simulation};
use super::sweep::{KnownPoint, MapSweep, Points};
use crate::engine::Failure;
use crate::experiment::HardStepping;
use crate::output::numbers::{significant, with_error};
use crate::output::panel::SeriesStyle;
use crate::runs::StudyError;
use crate::statistics::Estimate;
use std::f64::consts::PI;

/// [m/s] standard deviation of each velocity component of the particles at the start.
const SPEED: f64 = 0.5;
/// [-] volume fraction of the particles.
const FRACTION: f64 = 0.1;

/// Results of one run of hard spheres in time steps, whose collisions are found as overlaps at the end of a step.
struct SteppedRun {
    /// Number of collisions that were found and changed the velocities.
    pairs: f64,
    /// Number of missed collisions: the spheres overlapped and separated again before the next search for collisions.
    missed: f64,
    /// [-] mean overlap at which collisions were found, divided by the diameter. It is 0 if there was no collision.
    overlap: f64,
    /// [-] 99 % quantile of the overlap at which collisions were found, divided by the diameter.
    deepest: f64,
    failure: Option<Failure>,
}

/// Two maps from one set of runs: the share of missed collisions, and the overlap at which collisions are found, as
/// functions of the step criterion θ.
pub fn missed_and_overlap(grid: &Points) -> Result<Vec<MapSweep>, StudyError> {
    let (theta, seeds, collisions) = grid.choose(
        (vec![0.05, 0.1, 0.3, 1.0], 3, 20.0),
        (vec![0.01, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0], 8, 60.0),
    );
    let seeds = even(1.0, f64::from(seeds), seeds as usize);
    let duration = collisions / collision_rate(FRACTION, SPEED * SPEED);
    // in this list, a step criterion θ of 0 stands for exact collision instants
    let all: Vec<f64> = std::iter::once(0.0).chain(theta.iter().copied()).collect();
    let runs = grid.run(&points(&seeds, &all), |&(seed, theta)| {
        let mut simulation = simulation(&grid.with(|case| {
            case.run.seed = seed as u64;
            case.hard.stepping = if theta > 0.0 { HardStepping::Steps { theta } } else { HardStepping::Events };
        }))?;
        // a single window (piece of the run): a window has a whole number of steps, so a short window would force
        // shorter steps than the step criterion θ allows
        let failure = run(&mut simulation, 1, duration);
        let summary = simulation.record.pairs.summary();
        Ok(SteppedRun {
            pairs: summary.count as f64,
            missed: simulation.counters().missed_collisions as f64,
            overlap: summary.mean_maximum_overlap.unwrap_or(0.0),
            deepest: summary.p99_maximum_overlap.unwrap_or(0.0),
            failure,
        })
    })?;
    let (exact, stepped) = runs.split_at(seeds.len());
    let stepped: Vec<(f64, &[SteppedRun])> = theta.iter().copied().zip(stepped.chunks(seeds.len())).collect();
    Ok(vec![missed(exact, &stepped), overlap(&stepped)])
}

/// Rows of the table of a map, one for each value of the step criterion θ. The function `values` computes the numbers
/// of a row from θ and the runs with this θ.
fn rows(stepped: &[(f64, &[SteppedRun])], values: impl Fn(f64, &[SteppedRun]) -> Vec<f64>) -> Vec<KnownPoint> {
    let failure = |runs: &[SteppedRun]| runs.iter().find_map(|seen| seen.failure.clone());
    stepped.iter().map(|(theta, runs)| KnownPoint { values: values(*theta, runs), failure: failure(runs) }).collect()
}

fn missed(exact: &[SteppedRun], stepped: &[(f64, &[SteppedRun])]) -> MapSweep {
    let (exact, exact_error) = mean(exact, |seen| seen.pairs);
    let rows = rows(stepped, |theta, runs| {
        let missed = mean(runs, |seen| seen.missed / (seen.missed + seen.pairs));
        let pairs = mean(runs, |seen| seen.pairs);
        let ratio = pairs.0 / exact;
        let error = ratio * (pairs.1 / pairs.0).hypot(exact_error / exact);
        vec![theta, missed.0, missed.1, ratio - 1.0, error]
    });
    let lesson = rows.iter().find(|row| row.values[0] == 0.3).map_or(String::new(), |row| {
        format!(
            "At the literature’s θ = 0.3, {} % of the collisions are over before the next look and get no impulse; {} % \
             fewer impulses act than at exact instants.",
            with_error(Estimate::new(100.0 * row.values[1], 100.0 * row.values[2])),
            with_error(Estimate::new(-100.0 * row.values[3], 100.0 * row.values[4]))
        )
    });
    let share = |label: &str, k: usize, sign: f64| {
        let point = |r: &KnownPoint| [r.values[0], sign * 100.0 * r.values[1 + 2 * k], 100.0 * r.values[2 + 2 * k]];
        measured(label, k, rows.iter().map(point))
    };
    let picture = curves(
        ["θ  [-]", "share of the collisions  [%]"],
        [false; 2],
        vec![
            share("missed: separating at the next look", 0, 1.0),
            share("fewer impulses than at exact instants", 1, -1.0),
        ],
    );
    MapSweep::new(rows, lesson, picture)
}

fn overlap(stepped: &[(f64, &[SteppedRun])]) -> MapSweep {
    let rows = rows(stepped, |theta, runs| {
        let (overlap, error) = mean(runs, |seen| seen.overlap);
        let (deepest, _) = mean(runs, |seen| seen.deepest);
        // expected relative overlap π θ/4: half a time step Δt = θ d/u_r at the mean normal speed of impact sqrt(π T),
        // with u_r = sqrt(4T/π), granular temperature T and diameter d
        vec![theta, overlap, error, deepest, PI / 4.0 * theta]
    });
    let lesson = rows.iter().find(|row| row.values[0] == 0.3).map_or(String::new(), |row| {
        format!(
            "At θ = 0.3 a collision is found {} of a diameter too late on average, one in a hundred at {}; the impulse then points along a turned normal.",
            with_error(Estimate::new(row.values[1], row.values[2])),
            significant(row.values[3], 2)
        )
    });
    let depth = |column: usize| rows.iter().map(move |row| [row.values[0], row.values[column]]);
    let mean = rows.iter().map(|row| [row.values[0], row.values[1], row.values[2]]);
    let picture = curves(
        ["θ  [-]", "overlap over diameter  [-]"],
        [false; 2],
        vec![
            curve("half a step head-on, θ π/4", SeriesStyle::Reference, depth(4)),
            measured("mean", 0, mean),
            curve("99 %", SeriesStyle::Points(1), depth(3)),
        ],
    );
    MapSweep::new(rows, lesson, picture)
}
