//! Hard in steps: what is missed and what is left over when collisions are looked for at the ends of steps.

use super::Grid;
use super::cells::{even, points};
use super::scenes::{collision_rate, gas, hard, length, mean, run, simulation};
use crate::engine::Failure;
use crate::output::limits::{Column, Curve, Curves, Kind, Map, Picture, Row};
use crate::output::numbers::{significant, with_error};
use crate::study::session::StudyError;
use std::f64::consts::PI;

/// [m/s] per component.
const SPEED: f64 = 0.5;
/// [-] volume fraction.
const FRACTION: f64 = 0.1;
/// Spheres.
const COUNT: usize = 1000;

/// `theta` 0: at exact instants.
fn case(theta: f64, seed: u64, duration: f64) -> String {
    let steps = if theta > 0.0 { format!("[hard]\nstepping = \"steps\"\ntheta = {theta}\n") } else { String::new() };
    let gas = gas(COUNT, FRACTION, SPEED, 1.0);
    format!("# An elastic gas without forces\n{gas}{steps}{}{}", hard(), length(duration, seed))
}

/// What a run came to.
struct Seen {
    /// Collisions that got an impulse.
    pairs: f64,
    /// Collisions that were over at the next look.
    missed: f64,
    /// [-] mean overlap found, over the diameter.
    overlap: f64,
    /// [-] that of which 99 % are less.
    deepest: f64,
    failure: Option<Failure>,
}

/// θ, and what the runs of each came to; the first is that at exact instants.
type Sweep = (Vec<f64>, Vec<Vec<Seen>>, f64);

fn sweep(grid: &Grid) -> Result<Sweep, StudyError> {
    let (theta, seeds, collisions) = if grid.quick {
        (vec![0.05, 0.1, 0.3, 1.0], 3, 20.0)
    } else {
        (vec![0.01, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0], 8, 60.0)
    };
    let seeds = even(1.0, f64::from(seeds), seeds as usize);
    let duration = collisions / collision_rate(FRACTION, SPEED * SPEED);
    let all: Vec<f64> = std::iter::once(0.0).chain(theta.iter().copied()).collect();
    let runs = grid.run("stepped", &points(&seeds, &all), |&(seed, theta)| {
        let mut simulation = simulation(&case(theta, seed as u64, duration))?;
        // one window: a step is a whole part of it, and would be shorter than θ asks for in a short one
        let failure = run(&mut simulation, 1, duration);
        let summary = simulation.record.pairs.summary();
        Ok(Seen {
            pairs: summary.count as f64,
            missed: simulation.counters().missed_collisions as f64,
            overlap: summary.mean_maximum_overlap,
            deepest: summary.p99_maximum_overlap,
            failure,
        })
    })?;
    let mut runs = runs.into_iter();
    let by_theta = (0..=theta.len()).map(|_| runs.by_ref().take(seeds.len()).collect()).collect();
    Ok((theta, by_theta, duration))
}

fn statistics(runs: &[Seen], of: impl Fn(&Seen) -> f64) -> (f64, f64) {
    mean(&runs.iter().map(of).collect::<Vec<_>>())
}

/// Missed collisions over θ, and the overlap left over, of the same runs.
pub fn missed_and_overlap(grid: &Grid) -> Result<[Map; 2], StudyError> {
    let sweep = sweep(grid)?;
    Ok([missed(&sweep), overlap(&sweep)])
}

fn missed((theta, runs, duration): &Sweep) -> Map {
    let (exact, exact_error) = statistics(&runs[0], |seen| seen.pairs);
    let rows: Vec<Row> = theta
        .iter()
        .zip(&runs[1..])
        .map(|(&theta, runs)| {
            let missed = statistics(runs, |seen| seen.missed / (seen.missed + seen.pairs));
            let pairs = statistics(runs, |seen| seen.pairs);
            let ratio = pairs.0 / exact;
            let error = ratio * (pairs.1 / pairs.0).hypot(exact_error / exact);
            let failure = runs.iter().find_map(|seen| seen.failure.clone());
            Row { values: vec![theta, missed.0, missed.1, ratio - 1.0, error], failure }
        })
        .collect();
    let lesson = rows.iter().find(|row| row.values[0] == 0.3).map_or(String::new(), |row| {
        format!(
            "At the literature’s θ = 0.3, {} % of the collisions are over before the next look and get no impulse; {} % \
             fewer impulses act than at exact instants.",
            with_error(100.0 * row.values[1], 100.0 * row.values[2]),
            with_error(-100.0 * row.values[3], 100.0 * row.values[4])
        )
    });
    let curve = |label: &str, k: usize, sign: f64| Curve {
        label: label.into(),
        kind: Kind::Points(k),
        points: rows
            .iter()
            .map(|r| [r.values[0], sign * 100.0 * r.values[1 + 2 * k], 100.0 * r.values[2 + 2 * k]])
            .collect(),
    };
    Map {
        name: "stepped-missed",
        title: "Hard in steps: how many collisions are missed?",
        method: "Each point: an elastic gas of 1000 spheres at φ = 0.1, Δt = θ d/u_r, mean over seeds. Missed: counted from the flights, pairs that \
                 met since the last look and are separating at this one.",
        lesson,
        columns: vec![
            Column { name: "theta", meaning: "θ [-]" },
            Column { name: "missed", meaning: "share of the collisions that are over at the next look [-]" },
            Column { name: "missed_se", meaning: "its standard error [-]" },
            Column { name: "rate_error", meaning: "collisions with an impulse, against exact instants [-]" },
            Column { name: "rate_error_se", meaning: "its standard error [-]" },
        ],
        picture: Picture::Curves(Curves {
            x_label: "θ  [-]".into(),
            y_label: "share of the collisions  [%]".into(),
            log: [false; 2],
            curves: vec![
                curve("missed: separating at the next look", 0, 1.0),
                curve("fewer impulses than at exact instants", 1, -1.0),
            ],
        }),
        rows,
        case: case(0.3, 1, *duration),
    }
}

fn overlap((theta, runs, duration): &Sweep) -> Map {
    let rows: Vec<Row> = theta
        .iter()
        .zip(&runs[1..])
        .map(|(&theta, runs)| {
            let (overlap, error) = statistics(runs, |seen| seen.overlap);
            let (deepest, _) = statistics(runs, |seen| seen.deepest);
            let failure = runs.iter().find_map(|seen| seen.failure.clone());
            // half a step at the mean normal speed of impacts sqrt(π T), with u_r = sqrt(4T/π)
            Row { values: vec![theta, overlap, error, deepest, PI / 4.0 * theta], failure }
        })
        .collect();
    let lesson = rows.iter().find(|row| row.values[0] == 0.3).map_or(String::new(), |row| {
        format!(
            "At θ = 0.3 a collision is found {} of a diameter too late on average, one in a hundred at {}; the impulse then points along a turned normal.",
            with_error(row.values[1], row.values[2]),
            significant(row.values[3], 2)
        )
    });
    let curve = |label: &str, kind: Kind, column: usize, error: Option<usize>| Curve {
        label: label.into(),
        kind,
        points: rows.iter().map(|r| [r.values[0], r.values[column], error.map_or(f64::NAN, |k| r.values[k])]).collect(),
    };
    Map {
        name: "stepped-overlap",
        title: "Hard in steps: how deep do spheres sink before they are turned?",
        method: "Each point: an elastic gas of 1000 spheres at φ = 0.1, Δt = θ d/u_r, mean over seeds. Line: head-on spheres found half a step late.",
        lesson,
        columns: vec![
            Column { name: "theta", meaning: "θ [-]" },
            Column { name: "overlap", meaning: "mean overlap found over the diameter [-]" },
            Column { name: "overlap_se", meaning: "its standard error [-]" },
            Column { name: "overlap_99", meaning: "99 % are less [-]" },
            Column { name: "estimate", meaning: "θ π/4: half a step head-on [-]" },
        ],
        picture: Picture::Curves(Curves {
            x_label: "θ  [-]".into(),
            y_label: "overlap over diameter  [-]".into(),
            log: [false; 2],
            curves: vec![
                curve("half a step head-on, θ π/4", Kind::Theory, 4, None),
                curve("mean", Kind::Points(0), 1, Some(2)),
                curve("99 %", Kind::Points(1), 3, None),
            ],
        }),
        rows,
        case: case(0.3, 1, *duration),
    }
}
