//! Inelastic collapse of hard spheres: infinitely many collisions in finite time. The maps show it on a line, at a
//! wall, in a gas, and in a bed at rest.

use super::picture::{MapAxis, curve, curves, even, plane, points};
use super::scenes::{collision_rate, fill, restitute, row, run, scatter, simulation, temperature};
use super::sweep::{KnownPoint, MapSweep, Points};
use crate::engine::Failure;
use crate::output::limits::{self, Shade};
use crate::output::numbers::significant;
use crate::output::panel::SeriesStyle;
use crate::runs::StudyError;
use std::f64::consts::PI;

/// [-] restitution tan²(π/4 (1 - 1/n)) below which a column of n equal spheres that meets a wall collides infinitely
/// often (Bernu and Mazighi 1990, J. Phys. A 23, 5745). A free line of N = 2n spheres has the same limit, since its
/// symmetric halves meet like a column and a wall.
fn threshold(n: f64) -> f64 {
    (PI / 4.0 * (1.0 - 1.0 / n)).tan().powi(2)
}

/// [s] simulated time of the inelastic collapse that stopped a run; `None` if the run ended in another way.
fn collapse(failure: &Option<Failure>) -> Option<f64> {
    match failure {
        Some(Failure::InelasticCollapse { time, .. }) => Some(*time),
        _ => None,
    }
}

/// Gaps [m] and velocities [m/s] of `count` spheres in a row at the start. If `wall` is true, all spheres approach a
/// wall at 1 m/s. Otherwise the velocities decrease evenly from 1 m/s for the first sphere to -1 m/s for the last. The
/// gaps are scattered; each value of `set` gives other gaps.
fn start(count: usize, set: usize, wall: bool) -> (Vec<f64>, Vec<f64>) {
    let middle = if wall { 0.0 } else { 9.0 * count as f64 };
    let gap = |k: usize| 0.5 + scatter(set, k) + if k == 0 { middle } else { 0.0 };
    let speed = |k: usize| if wall { -1.0 } else { 1.0 - 2.0 * k as f64 / (count as f64 - 1.0) };
    (0..count).map(|k| (gap(k), speed(k))).unzip()
}

/// Map of the share of initial states that lead to an inelastic collapse, as a function of the number of spheres and
/// the restitution. The spheres are on a line and approach one another or, if the case has a wall, approach the wall.
pub fn one_dimension(grid: &Points) -> Result<Vec<MapSweep>, StudyError> {
    let wall = !grid.base.scene.walls.is_empty();
    let counts = match (wall, grid.choose(true, false)) {
        (false, true) => vec![3.0, 4.0, 6.0, 10.0],
        (false, false) => vec![3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0],
        (true, true) => vec![2.0, 3.0, 5.0],
        (true, false) => vec![2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0],
    };
    let (what, size, longest) =
        if wall { ("Two spheres and a wall", 1.0, 6.0) } else { ("Three spheres on a line", 0.5, 4.0) };
    let theory = |n: f64| threshold(size * n);
    let (e, sets) = grid.choose((even(0.02, 0.98, 25), 8), (even(0.01, 0.99, 50), 24));
    let rows = grid.run(&points(&counts, &e), |&(count, e)| {
        let (mut failure, mut collapsed) = (None, 0);
        for set in 0..sets {
            let (gaps, velocities) = start(count as usize, set, wall);
            let mut simulation = simulation(&grid.with(|case| {
                row(case, 20.0 * count, &gaps, &velocities);
                restitute(case, e);
            }))?;
            let why = run(&mut simulation, 20, longest * count);
            collapsed += usize::from(collapse(&why).is_some());
            failure = failure.or(why);
        }
        Ok(KnownPoint { values: vec![count, e, collapsed as f64 / sets as f64, theory(count)], failure })
    })?;
    let level = |row: &KnownPoint| match row.values[2] {
        0.0 => 0,
        share if share < 1.0 => 1,
        _ => 2,
    };
    let first = rows.iter().filter(|row| row.values[0] == counts[0] && row.values[2] > 0.0).map(|row| row.values[1]);
    let lesson = format!(
        "{what} collapse up to e = {} here (theory: {}); the more there are, the nearer to 1 it gets. Each ends with InelasticCollapse, \
         its pair, place and time, after a finite number of collisions; hard.contact_time lets the run go on.",
        significant(first.fold(0.0, f64::max), 2),
        significant(theory(counts[0]), 4)
    );
    let line = even(counts[0], counts[counts.len() - 1], 200).into_iter().map(|n| (n, theory(n))).collect();
    let picture = plane(
        &MapAxis("number of spheres  [-]", &counts, false),
        &MapAxis("restitution, e  [-]", &e, false),
        &[("none collapses", Shade::Level(0)), ("some do", Shade::Level(2)), ("all: InelasticCollapse", Shade::Fails)],
        |k| level(&rows[k]),
        vec![("threshold", line)],
    );
    Ok(vec![MapSweep::new(rows, lesson, picture)])
}

/// Map of gases that cool by inelastic collisions in three dimensions: number of collisions per sphere until an
/// inelastic collapse (or until the run ends without one), as a function of the volume fraction and the restitution.
pub fn cooling(grid: &Points) -> Result<Vec<MapSweep>, StudyError> {
    let (e, fraction, count, collisions) = grid.choose(
        (even(0.1, 0.9, 5), vec![0.05, 0.2, 0.4], 200, 30.0),
        (even(0.05, 0.95, 19), vec![0.02, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4], 500, 200.0),
    );
    let rows = grid.run(&points(&fraction, &e), |&(fraction, e)| {
        let mut simulation = simulation(&grid.with(|case| {
            fill(case, count, fraction);
            restitute(case, e);
        }))?;
        let mut failure = None;
        let suffered = |pairs: u64| 2.0 * pairs as f64 / count as f64;
        while failure.is_none() && suffered(simulation.record.pairs.count) < collisions {
            // time of a fifth of a collision per particle, at the present temperature
            let window = 0.2 / collision_rate(fraction, temperature(&simulation));
            failure = run(&mut simulation, 1, window);
        }
        Ok(KnownPoint { values: vec![fraction, e, suffered(simulation.record.pairs.count)], failure })
    })?;
    let collapsed = || rows.iter().filter(|row| collapse(&row.failure).is_some());
    let highest = collapsed().map(|row| row.values[1]).fold(0.0, f64::max);
    let soonest = collapsed().map(|row| row.values[2]).fold(f64::INFINITY, f64::min);
    let lesson = if highest > 0.0 {
        format!(
            "In space a cooling gas collapses only at low restitution: up to e = {} here, the first after {} collisions per sphere. Spheres \
             of everyday materials (e above 0.5) do not collapse as a gas; they do when gravity lets them rest.",
            significant(highest, 2),
            significant(soonest, 2)
        )
    } else {
        format!("No gas collapsed within {collisions} collisions per sphere; lines and beds do.")
    };
    let three = even(0.0, 0.5, 101).into_iter().map(|phi| (phi, threshold(1.5))).collect();
    let picture = plane(
        &MapAxis("volume fraction, φ  [-]", &fraction, false),
        &MapAxis("restitution, e  [-]", &e, false),
        &[("goes on", Shade::Level(0)), ("InelasticCollapse", Shade::Fails)],
        |k| usize::from(collapse(&rows[k].failure).is_some()),
        vec![("three on a line", three)],
    );
    Ok(vec![MapSweep::new(rows, lesson, picture)])
}

/// [s] width of the bins of time in which the collisions of a bed are counted, a sixtieth of the time in which the bed
/// comes to rest.
const BIN: f64 = 2e-3;
/// Number of bins of time in which the collisions of a bed are counted.
const BINS: usize = 75;

/// Collision rate of a bed of spheres in one bin of time, and energy saved by the TC model (a collision is elastic if
/// it follows another one within a contact time).
struct CollapseInterval {
    /// [s] simulated time at the middle of the bin.
    at: f64,
    /// [1/s] number of collisions per sphere and time in the bin.
    rate: f64,
    /// [-] energy that is not lost, because the TC model makes collisions in quick succession elastic. The energy is
    /// summed from the start to the end of the bin, and divided by the initial energy plus the work of gravity.
    kept: f64,
    failure: Option<Failure>,
}

/// Runs a bed of spheres that comes to rest, and returns one entry for each bin of time; a failure ends the list.
/// `contact_time` [s] is that of the TC model: a collision within this time after another one is elastic. Without it,
/// there is no TC model.
fn bed(grid: &Points, contact_time: Option<f64>) -> Result<Vec<CollapseInterval>, StudyError> {
    let mut simulation = simulation(&grid.with(|case| case.hard.contact_time = contact_time))?;
    let start = simulation.energy();
    let (mut rows, mut before) = (Vec::new(), 0);
    for _ in 0..BINS {
        let (began, failure) = (simulation.time, run(&mut simulation, 1, BIN));
        // after a collapse the bin ends at the collapse, so it is shorter
        let spent = collapse(&failure).map_or(BIN, |time| time - began);
        let events = simulation.record.pairs.count + simulation.record.walls.count;
        let rate = (events - before) as f64 / spent / simulation.particles.len() as f64;
        before = events;
        let ledger = &simulation.record.ledger;
        let kept = ledger.contact_time_kept / (start + ledger.gravity_work);
        let ended = failure.is_some();
        rows.push(CollapseInterval { at: began + 0.5 * spent, rate, kept, failure });
        if ended {
            break;
        }
    }
    Ok(rows)
}

/// Map of the collision rate of a bed that comes to rest, without and with the TC model (elastic collisions in quick
/// succession).
pub fn rest(grid: &Points) -> Result<Vec<MapSweep>, StudyError> {
    let times = grid.choose(&[1e-3, 1e-4][..], &[1e-3, 1e-4, 1e-5, 1e-6]);
    let variants: Vec<Option<f64>> = std::iter::once(None).chain(times.iter().copied().map(Some)).collect();
    let runs = grid.run(&variants, |&contact_time| bed(grid, contact_time))?;
    let end = runs[0].iter().find_map(|bin| collapse(&bin.failure));
    let plateau = |(time, bins): (&f64, &Vec<CollapseInterval>)| {
        let late = significant(bins.last().map(|bin| bin.rate), 2);
        format!("{late} per sphere and second for t_c = {time:.0e} s")
    };
    let plateaus: Vec<String> = times.iter().zip(&runs[1..]).map(plateau).collect();
    let lesson = format!(
        "Without a contact time the rate diverges and the run stops with InelasticCollapse at t = {} s. With one it ends on a plateau, {}: \
         a bed at rest costs about one collision per sphere, neighbour and t_c, for ever. Soft spheres rest for nothing.",
        significant(end, 3),
        plateaus.join(", ")
    );
    let rates = variants.iter().zip(&runs).enumerate().map(|(k, (time, bins))| {
        let label = time.map_or("no contact time".into(), |time| format!("t_c = {} µs", significant(1e6 * time, 2)));
        curve(label, SeriesStyle::Line(k), bins.iter().map(|bin| [1e3 * bin.at, bin.rate]))
    });
    let picture = curves(["t  [ms]", "collisions per sphere  [1/s]"], [false, true], rates.collect());
    let row = |time: Option<f64>, bin: CollapseInterval| {
        let values = vec![time, Some(bin.at), Some(bin.rate), Some(bin.kept)];
        limits::MapPoint { values, failure: bin.failure }
    };
    let rows = variants.into_iter().zip(runs).flat_map(|(time, bins)| bins.into_iter().map(move |bin| row(time, bin)));
    Ok(vec![MapSweep { rows: rows.collect(), lesson, picture }])
}
