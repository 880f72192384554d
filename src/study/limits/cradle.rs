//! Several contacts at once: rows that pass a blow on, and one sphere hit from both sides.

use super::Grid;
use super::cells::even;
use super::scenes::{hard, length, row, run, simulation, soft, speeds};
use crate::contact_law::ContactLaw;
use crate::output::limits::{Column, Curve, Curves, Kind, Map, Picture, Row};
use crate::output::numbers::significant;
use crate::study::session::StudyError;
use std::f64::consts::PI;

/// [N/m] contacts of spheres of 1 kg that last 2.2 ms.
const STIFFNESS: f64 = 1e6;
/// Restitutions of the cradle.
const RESTITUTIONS: [f64; 2] = [1.0, 0.94];

fn model(is_soft: bool) -> String {
    if is_soft { soft(&ContactLaw::linear(STIFFNESS), 200.0, "velocity_verlet") } else { hard() }
}

fn cradle_case(count: usize, restitution: f64, is_soft: bool) -> String {
    let mut gaps = vec![0.0; count];
    gaps[0] = 4.0;
    gaps[1] = 1e-3;
    let mut velocities = vec![0.0; count];
    velocities[0] = 1.0;
    let row = row(&gaps, &velocities, 30.0, restitution, false);
    format!("# A sphere hits a row of touching ones\n{row}{}{}", model(is_soft), length(0.1, 1))
}

/// The last sphere of a row of touching ones that the first hits.
pub fn cradle(grid: &Grid) -> Result<Map, StudyError> {
    let last = if grid.quick { 5 } else { 8 };
    let points: Vec<(usize, f64)> = RESTITUTIONS.iter().flat_map(|e| (2..=last).map(|n| (n, *e))).collect();
    let rows = grid.run("cradle", &points, |&(count, e)| {
        let of = |is_soft: bool| {
            let mut simulation = simulation(&cradle_case(count, e, is_soft))?;
            let failure = run(&mut simulation, 1, 0.1);
            let speeds = speeds(&simulation);
            Ok::<_, StudyError>((speeds[0], speeds[count - 1], simulation.energy() / 0.5, failure))
        };
        let (soft, hard) = (of(true)?, of(false)?);
        let values = vec![count as f64, e, soft.1, hard.1, soft.0, hard.0, soft.2, hard.2];
        Ok(Row { values, failure: soft.3.or(hard.3) })
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
    let curve = |k: usize, e: f64, column: usize, name: &str| Curve {
        label: format!("{name}, e = {e}"),
        kind: Kind::Line(k),
        points: rows.iter().filter(|r| r.values[1] == e).map(|r| [r.values[0], r.values[column], f64::NAN]).collect(),
    };
    Ok(Map {
        name: "cradle",
        title: "Several contacts at once: what comes out of a row of touching spheres?",
        method: "A sphere at 1 m/s hits a row of touching spheres at rest. Soft: 200 steps per contact.",
        lesson,
        columns: vec![
            Column { name: "spheres", meaning: "in all [-]" },
            Column { name: "restitution", meaning: "e [-]" },
            Column { name: "last_soft_m_s", meaning: "velocity of the last, soft [m/s]" },
            Column { name: "last_hard_m_s", meaning: "the same, hard [m/s]" },
            Column { name: "first_soft_m_s", meaning: "velocity of the first, soft [m/s]" },
            Column { name: "first_hard_m_s", meaning: "the same, hard [m/s]" },
            Column { name: "energy_soft", meaning: "energy left, soft [-]" },
            Column { name: "energy_hard", meaning: "the same, hard [-]" },
        ],
        picture: Picture::Curves(Curves {
            x_label: "spheres in all  [-]".into(),
            y_label: "velocity of the last  [m/s]".into(),
            log: [false; 2],
            curves: vec![
                curve(0, 1.0, 2, "soft"),
                curve(1, 1.0, 3, "hard"),
                curve(2, 0.94, 2, "soft"),
                curve(3, 0.94, 3, "hard"),
            ],
        }),
        rows,
        case: cradle_case(3, 1.0, true),
    })
}

/// A sphere at rest that is hit from both sides, the right one `late` [s] after the left one.
fn simultaneous_case(late: f64, is_soft: bool) -> String {
    let row = row(&[4.0, 1.0, 1.0 + late], &[1.0, 0.0, -1.0], 30.0, 0.9, false);
    format!("# A sphere is hit from both sides\n{row}{}{}", model(is_soft), length(3.0, 1))
}

/// The middle one of three, hit from both sides at nearly the same time.
pub fn simultaneous(grid: &Grid) -> Result<Map, StudyError> {
    let contact = PI * (0.5 / STIFFNESS).sqrt();
    let late = even(-2.0, 2.0, if grid.quick { 17 } else { 81 });
    let rows = grid.run("simultaneous", &late, |&late| {
        let of = |is_soft: bool| {
            let mut simulation = simulation(&simultaneous_case(late * contact, is_soft))?;
            let failure = run(&mut simulation, 1, 3.0);
            Ok::<_, StudyError>((speeds(&simulation)[1], failure))
        };
        let (soft, hard) = (of(true)?, of(false)?);
        Ok(Row { values: vec![late, soft.0, hard.0], failure: soft.1.or(hard.1) })
    })?;
    let hard_speed = rows.iter().map(|row| row.values[2].abs()).fold(0.0, f64::max);
    let soft_speed = rows.iter().map(|row| row.values[1].abs()).fold(0.0, f64::max);
    let apart =
        rows.iter().filter(|row| (row.values[1] - row.values[2]).abs() > 0.1 * hard_speed).map(|row| row.values[0]);
    let apart = apart.map(f64::abs).fold(0.0, f64::max);
    let lesson = format!(
        "Hard spheres only know who came first: the middle one leaves with {} m/s to one side or the other, however near the two hits are, \
         and at the same instant the order of the particles decides. Soft ones share the blow: up to {} m/s, and as hard ones only when the \
         hits are more than {} contact times apart.",
        significant(hard_speed, 2),
        significant(soft_speed, 2),
        significant(apart, 2)
    );
    let curve = |label: &str, k: usize| Curve {
        label: label.into(),
        kind: Kind::Points(k),
        points: rows.iter().map(|row| [row.values[0], 1e3 * row.values[1 + k], f64::NAN]).collect(),
    };
    Ok(Map {
        name: "simultaneous",
        title: "Several contacts at once: one sphere hit from both sides",
        method: "Three equal spheres on a line with e = 0.9, the outer ones at 1 m/s; velocity of the middle one in the end, over how much later the right \
                 one hits than the left.",
        lesson,
        columns: vec![
            Column { name: "late", meaning: "second hit after the first, over the contact time [-]" },
            Column { name: "middle_soft_m_s", meaning: "velocity of the middle one, soft [m/s]" },
            Column { name: "middle_hard_m_s", meaning: "the same, hard [m/s]" },
        ],
        picture: Picture::Curves(Curves {
            x_label: "right after left, over the contact time  [-]".into(),
            y_label: "velocity of the middle one  [mm/s]".into(),
            log: [false; 2],
            curves: vec![curve("soft", 0), curve("hard", 1)],
        }),
        rows,
        case: simultaneous_case(0.0, false),
    })
}
