//! Drag apart from flight: the error of the splitting over the length of the window.

use super::Grid;
use super::scenes::{hard, length, simulation};
use crate::output::limits::{Column, Curve, Curves, Kind, Map, Picture, Row};
use crate::output::numbers::significant;
use crate::study::session::StudyError;

/// [s] the paper's small sphere falls for about its response time.
const DURATION: f64 = 0.2;

/// Windows of the reference: its error is (1/32)² of that of the finest point.
const REFERENCE: u64 = 16_384;

fn case() -> String {
    format!(
        "# A sphere thrown across a stream of gas\n[domain]\nsize = [\"0.2 m\", \"0.8 m\", \"4 m\"]\nperiodic = [\"x\", \"z\"]\n\
         [gravity]\nacceleration = [\"0 m/s^2\", \"-9.81 m/s^2\", \"0 m/s^2\"]\n\
         [fluid]\ndensity = \"1.205 kg/m^3\"\nkinematic_viscosity = \"1.515e-5 m^2/s\"\n[fluid.profile.uniform]\nvelocity = \"2 m/s\"\n\
         [drag.schiller_naumann]\n[[particles]]\ndiameter = \"406 um\"\ndensity = \"1038 kg/m^3\"\n\
         at = [{{ position = [\"0.1 m\", \"0.5 m\", \"0.1 m\"], velocity = [\"0 m/s\", \"1 m/s\", \"0 m/s\"] }}]\n{}{}",
        hard(),
        length(DURATION, 1)
    )
}

/// Error of place and velocity over the window.
pub fn splitting(grid: &Grid) -> Result<Map, StudyError> {
    let powers = if grid.quick { vec![0, 3, 6, 9] } else { (0..=9).collect::<Vec<u32>>() };
    let at = |windows: u64| {
        let mut simulation = simulation(&case())?;
        let failure = super::scenes::run(&mut simulation, windows, DURATION);
        Ok::<_, StudyError>((simulation.particles.position[0], simulation.particles.velocity[0], failure))
    };
    let reference = at(REFERENCE)?;
    let rows = grid.run("splitting", &powers, |&power| {
        let windows = 1 << power;
        let (place, velocity, failure) = at(windows)?;
        let (place, velocity) = ((place - reference.0).norm(), (velocity - reference.1).norm());
        Ok(Row { values: vec![DURATION / windows as f64, place, velocity], failure })
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
    let curve = |label: &str, k: usize, column: usize| Curve {
        label: label.into(),
        kind: Kind::Points(k),
        points: rows.iter().map(|row| [row.values[0], row.values[column], f64::NAN]).collect(),
    };
    let slope = rows.iter().map(|row| [row.values[0], last[2] * (row.values[0] / last[0]).powi(2), f64::NAN]).collect();
    Ok(Map {
        name: "splitting",
        title: "Either model: what does it cost to apply drag once per window?",
        method: "A sphere of 406 µm thrown across a stream of 2 m/s under gravity, Schiller and Naumann’s drag, after 0.2 s; against 16 384 windows.",
        lesson,
        columns: vec![
            Column { name: "window_s", meaning: "length of a window [s]" },
            Column { name: "place_error_m", meaning: "distance from the reference [m]" },
            Column { name: "velocity_error_m_s", meaning: "difference of the velocities [m/s]" },
        ],
        picture: Picture::Curves(Curves {
            x_label: "window  [s]".into(),
            y_label: "error  [m], [m/s]".into(),
            log: [true; 2],
            curves: vec![
                Curve { label: "second order".into(), kind: Kind::Theory, points: slope },
                curve("place", 0, 1),
                curve("velocity", 1, 2),
            ],
        }),
        rows,
        case: case(),
    })
}
