//! Hard, inelastic collapse: infinitely many collisions in finite time, on a line, at a wall, in a gas, and of a bed at rest.

use super::Grid;
use super::cells::{cells, class, even, points};
use super::scenes::{DIAMETER, GRAVITY, collision_rate, gas, hard, length, row, run, scatter, simulation, temperature};
use crate::engine::Failure;
use crate::output::limits::{Cells, Column, Curve, Curves, Kind, Map, Picture, Row, Shade};
use crate::output::numbers::significant;
use crate::study::session::StudyError;
use std::f64::consts::PI;

/// [-] below which a column of n equal spheres that meets a wall collides infinitely often: tan²(π/4 (1 - 1/n)) (Bernu and
/// Mazighi 1990, J. Phys. A 23, 5745); a free line of N = 2n is its own mirror image.
fn threshold(n: f64) -> f64 {
    (PI / 4.0 * (1.0 - 1.0 / n)).tan().powi(2)
}

/// A line of `count` spheres that run together, with gaps and speeds of that set.
fn line_case(count: usize, restitution: f64, set: usize) -> String {
    let length_of_box = 20.0 * count as f64;
    let middle = 9.0 * count as f64;
    let gap = |k: usize| 0.5 + scatter(set, k) + if k == 0 { middle } else { 0.0 };
    // the outer ones meet at -1 and 1 m/s, the others in between
    let speed = |k: usize| 1.0 - 2.0 * k as f64 / (count as f64 - 1.0);
    let (gaps, speeds): (Vec<f64>, Vec<f64>) = (0..count).map(|k| (gap(k), speed(k))).unzip();
    let row = row(&gaps, &speeds, length_of_box, restitution, false);
    format!("# Equal spheres on a line run together\n{row}{}{}", hard(), length(4.0 * count as f64, 1))
}

/// A column of `count` spheres that meets a wall at 1 m/s.
fn wall_case(count: usize, restitution: f64, set: usize) -> String {
    let gaps: Vec<f64> = (0..count).map(|k| 0.5 + scatter(set, k)).collect();
    let row = row(&gaps, &vec![-1.0; count], 20.0 * count as f64, restitution, true);
    format!("# A column of equal spheres meets a wall\n{row}{}{}", hard(), length(6.0 * count as f64, 1))
}

/// Free lines.
pub fn line(grid: &Grid) -> Result<Map, StudyError> {
    let counts = if grid.quick { vec![3, 4, 6, 10] } else { vec![3, 4, 5, 6, 8, 10, 12, 16, 20] };
    one_dimension(
        grid,
        Setting { name: "collapse-line", counts, theory: |n| threshold(0.5 * n), case: line_case, wall: false },
    )
}

/// Columns at a wall.
pub fn wall(grid: &Grid) -> Result<Map, StudyError> {
    let counts = if grid.quick { vec![2, 3, 5] } else { vec![2, 3, 4, 5, 6, 8, 10] };
    one_dimension(grid, Setting { name: "collapse-wall", counts, theory: threshold, case: wall_case, wall: true })
}

/// One of the two.
struct Setting {
    name: &'static str,
    counts: Vec<usize>,
    /// [-] threshold of e for a number of spheres.
    theory: fn(f64) -> f64,
    case: fn(usize, f64, usize) -> String,
    wall: bool,
}

fn one_dimension(grid: &Grid, setting: Setting) -> Result<Map, StudyError> {
    let Setting { name, counts, theory, case, wall } = setting;
    let (e, sets) = if grid.quick { (even(0.02, 0.98, 25), 8) } else { (even(0.01, 0.99, 50), 24) };
    let numbers: Vec<f64> = counts.iter().map(|count| *count as f64).collect();
    let rows = grid.run(name, &points(&numbers, &e), |&(count, e)| {
        let (mut failure, mut collapsed) = (None, 0);
        for set in 0..sets {
            let mut simulation = simulation(&case(count as usize, e, set))?;
            let why = run(&mut simulation, 20, (if wall { 6.0 } else { 4.0 }) * count);
            if matches!(why, Some(Failure::InelasticCollapse { .. })) {
                collapsed += 1;
            }
            failure = failure.or(why);
        }
        Ok(Row { values: vec![count, e, collapsed as f64 / sets as f64, theory(count)], failure })
    })?;
    let level = |row: &Row| match row.values[2] {
        0.0 => 0,
        share if share < 1.0 => 1,
        _ => 2,
    };
    let first = rows.iter().filter(|row| row.values[0] == numbers[0] && row.values[2] > 0.0).map(|row| row.values[1]);
    let highest = first.fold(0.0, f64::max);
    let (what, least) = if wall { ("Two spheres and a wall", 2) } else { ("Three spheres on a line", 3) };
    let lesson = format!(
        "{what} collapse up to e = {} here (theory: {}); the more there are, the nearer to 1 it gets. Each ends with InelasticCollapse, \
         its pair, place and time, after a finite number of collisions; hard.contact_time lets the run go on.",
        significant(highest, 2),
        significant(theory(f64::from(least)), 4)
    );
    let last = numbers[numbers.len() - 1];
    Ok(Map {
        name,
        title: if wall {
            "Hard: which columns at a wall collide infinitely often?"
        } else {
            "Hard: which lines of spheres collide infinitely often?"
        },
        method: if wall {
            "Each cell: columns with different gaps meet a wall at 1 m/s. Line: Bernu and Mazighi 1990, tan²(π/4 (1 − 1/n)), 3 − 2√2 for two; \
             necessary, and for three not every start collapses below it."
        } else {
            "Each cell: lines with different gaps run together. Line: tan²(π/4 (1 − 2/N)), 7 − 4√3 for three; necessary, \
             and for more than three not every start collapses below it."
        },
        lesson,
        columns: vec![
            Column { name: "spheres", meaning: "number of spheres [-]" },
            Column { name: "restitution", meaning: "e [-]" },
            Column { name: "collapsed", meaning: "share of the starts that end with InelasticCollapse [-]" },
            Column { name: "threshold", meaning: "e below which they may [-]" },
        ],
        picture: Picture::Cells(Cells {
            x_label: "number of spheres  [-]".into(),
            y_label: "restitution, e  [-]".into(),
            log: [false; 2],
            classes: vec![
                class("none collapses", Shade::Level(0)),
                class("some do", Shade::Level(2)),
                class("all: InelasticCollapse", Shade::Fails),
            ],
            cells: cells(&numbers, &e, [false; 2], |k| level(&rows[k])),
            lines: vec![(
                "threshold".into(),
                even(numbers[0], last, 200).into_iter().map(|n| (n, theory(n))).collect(),
            )],
        }),
        rows,
        case: case(counts[0], if wall { 0.15 } else { 0.05 }, 0),
    })
}

/// [m/s] per component at the start of a cooling gas.
const SPEED: f64 = 0.5;

fn gas_case(count: usize, fraction: f64, restitution: f64, duration: f64) -> String {
    let gas = gas(count, fraction, SPEED, restitution);
    format!("# A gas that cools by its collisions\n{gas}{}{}", hard(), length(duration, 1))
}

/// Cooling gases in three dimensions.
pub fn cooling(grid: &Grid) -> Result<Map, StudyError> {
    let (e, fraction, count, collisions) = if grid.quick {
        (even(0.1, 0.9, 5), vec![0.05, 0.2, 0.4], 200, 30.0)
    } else {
        (even(0.05, 0.95, 19), vec![0.02, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4], 500, 200.0)
    };
    let rows = grid.run("collapse-gas", &points(&fraction, &e), |&(fraction, e)| {
        let mut simulation = simulation(&gas_case(count, fraction, e, 1.0))?;
        let mut failure = None;
        let suffered = |pairs: u64| 2.0 * pairs as f64 / count as f64;
        while failure.is_none() && suffered(simulation.record.pairs.count) < collisions {
            // a fifth of a collision per particle at the temperature of the moment
            let window = 0.2 / collision_rate(fraction, temperature(&simulation));
            failure = run(&mut simulation, 1, window);
        }
        Ok(Row { values: vec![fraction, e, suffered(simulation.record.pairs.count)], failure })
    })?;
    let collapsed = |row: &Row| matches!(row.failure, Some(Failure::InelasticCollapse { .. }));
    let highest = rows.iter().filter(|row| collapsed(row)).map(|row| row.values[1]).fold(0.0, f64::max);
    let soonest = rows.iter().filter(|row| collapsed(row)).map(|row| row.values[2]).fold(f64::INFINITY, f64::min);
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
    Ok(Map {
        name: "collapse-gas",
        title: "Hard: which cooling gases collapse?",
        method: "Each cell: a gas of equal spheres without forces until each has collided so many times on average (quick: 200 spheres, 30 times; \
                 full: 500 spheres, 200 times). Line: three spheres on a line, 7 − 4√3.",
        lesson,
        columns: vec![
            Column { name: "volume_fraction", meaning: "φ [-]" },
            Column { name: "restitution", meaning: "e [-]" },
            Column { name: "collisions", meaning: "suffered per sphere until the end [-]" },
        ],
        picture: Picture::Cells(Cells {
            x_label: "volume fraction, φ  [-]".into(),
            y_label: "restitution, e  [-]".into(),
            log: [false; 2],
            classes: vec![class("goes on", Shade::Level(0)), class("InelasticCollapse", Shade::Fails)],
            cells: cells(&fraction, &e, [false; 2], |k| usize::from(collapsed(&rows[k]))),
            lines: vec![(
                "three on a line".into(),
                even(0.0, 0.5, 101).into_iter().map(|phi| (phi, threshold(1.5))).collect(),
            )],
        }),
        rows,
        case: gas_case(count, 0.2, 0.1, 0.1),
    })
}

/// Columns of spheres above a floor.
fn bed_case(contact_time: Option<f64>, duration: f64) -> String {
    let d = DIAMETER;
    let mut list = String::new();
    for i in 0..5 {
        for j in 0..4 {
            let (x, y) = (0.002 + 1.5 * d * f64::from(i), 0.001 + d * (0.5 + 2.0 * f64::from(j)));
            list += &format!(
                "  {{ position = [\"{x} m\", \"{y} m\", \"5 mm\"], velocity = [\"0 m/s\", \"0 m/s\", \"0 m/s\"] }},\n"
            );
        }
    }
    let contact_time = contact_time.map_or(String::new(), |time| format!("[hard]\ncontact_time = \"{time} s\"\n"));
    format!(
        "# Columns of spheres fall on a floor and come to rest\n[domain]\nsize = [\"10 mm\", \"10 mm\", \"10 mm\"]\nperiodic = [\"x\", \"z\"]\n\
         [gravity]\nacceleration = [\"0 m/s^2\", \"-{GRAVITY} m/s^2\", \"0 m/s^2\"]\n\
         [[particles]]\ndiameter = \"406 um\"\ndensity = \"1038 kg/m^3\"\nat = [\n{list}]\n\
         [[walls]]\nplane = {{ point = [\"0 m\", \"0 m\", \"0 m\"], normal = [0, 1, 0] }}\nrestitution = 0.8\n\
         [contact]\nrestitution = 0.8\n{contact_time}{}{}",
        hard(),
        length(duration, 1)
    )
}

/// Collisions per time of a bed that comes to rest, without and with the TC model.
pub fn rest(grid: &Grid) -> Result<Map, StudyError> {
    /// [s] bins: a sixtieth of the time in which the bed comes to rest.
    const BIN: f64 = 2e-3;
    const BINS: usize = 75;
    let times: &[f64] = if grid.quick { &[1e-3, 1e-4] } else { &[1e-3, 1e-4, 1e-5, 1e-6] };
    let variants: Vec<Option<f64>> = std::iter::once(None).chain(times.iter().copied().map(Some)).collect();
    let runs = grid.run("rest", &variants, |&contact_time| {
        let mut simulation = simulation(&bed_case(contact_time, BIN * BINS as f64))?;
        let start = simulation.energy();
        let (mut rows, mut before) = (Vec::new(), 0);
        for _ in 0..BINS {
            let (began, failure) = (simulation.time, run(&mut simulation, 1, BIN));
            // a failure cuts its bin short
            let spent = match &failure {
                Some(Failure::InelasticCollapse { time, .. }) => time - began,
                _ => BIN,
            };
            let events = simulation.record.pairs.count + simulation.record.walls.count;
            let rate = (events - before) as f64 / spent / simulation.particles.len() as f64;
            before = events;
            let ledger = &simulation.record.ledger;
            let kept = ledger.contact_time_kept / (start + ledger.gravity_work);
            let ended = failure.is_some();
            rows.push(Row { values: vec![contact_time.unwrap_or(0.0), began + 0.5 * spent, rate, kept], failure });
            if ended {
                break;
            }
        }
        Ok(rows)
    })?;
    let bare = &runs[0];
    let collapse = bare.iter().find_map(|row| match row.failure {
        Some(Failure::InelasticCollapse { time, .. }) => Some(time),
        _ => None,
    });
    let late = |rows: &Vec<Row>| rows.last().map_or(f64::NAN, |row| row.values[2]);
    let plateaus: Vec<String> = variants[1..]
        .iter()
        .zip(&runs[1..])
        .map(|(time, rows)| {
            format!("{} per sphere and second for t_c = {:.0e} s", significant(late(rows), 2), time.unwrap_or_default())
        })
        .collect();
    let lesson = format!(
        "Without a contact time the rate diverges and the run stops with InelasticCollapse at t = {} s. With one it ends on a plateau, {}: \
         a bed at rest costs about one collision per sphere, neighbour and t_c, for ever. Soft spheres rest for nothing.",
        collapse.map_or("–".into(), |time| significant(time, 3)),
        plateaus.join(", ")
    );
    let curves = variants.iter().zip(&runs).enumerate().map(|(k, (time, rows))| Curve {
        label: time.map_or("no contact time".into(), |time| format!("t_c = {} µs", significant(1e6 * time, 2))),
        kind: Kind::Line(k),
        points: rows.iter().map(|row| [1e3 * row.values[1], row.values[2], f64::NAN]).collect(),
    });
    Ok(Map {
        name: "rest",
        title: "Hard: what does a bed that comes to rest cost?",
        method: "Twenty spheres of 406 µm with e = 0.8 fall 1 mm on a floor in columns of four; collisions per sphere and time.",
        lesson,
        columns: vec![
            Column { name: "contact_time_s", meaning: "t_c of the TC model, 0: none [s]" },
            Column { name: "t_s", meaning: "middle of the bin [s]" },
            Column { name: "rate_1_s", meaning: "collisions per sphere and time [1/s]" },
            Column { name: "kept", meaning: "energy that restitution would have taken, over all there was [-]" },
        ],
        picture: Picture::Curves(Curves {
            x_label: "t  [ms]".into(),
            y_label: "collisions per sphere  [1/s]".into(),
            log: [false, true],
            curves: curves.collect(),
        }),
        rows: runs.into_iter().flatten().collect(),
        case: bed_case(Some(1e-4), BIN * BINS as f64),
    })
}
