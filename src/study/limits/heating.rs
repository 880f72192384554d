//! Soft, heating of an elastic gas by second-order Runge-Kutta.

use super::Grid;
use super::cells::{even, points};
use super::scenes::{STIFFNESS, collision_rate, gas, length, mean, run, simulation, soft};
use crate::contact_law::ContactLaw;
use crate::experiment::{Integrator, SoftStepping};
use crate::output::limits::{Column, Curve, Curves, Kind, Map, Picture, Row};
use crate::output::numbers::with_error;
use crate::predict::integrator::{Scheme, heating_per_collision, realised_restitution};
use crate::study::session::StudyError;

/// [m/s] per component at the start: T = 0.49 m²/s², that of the paper's case D.
const SPEED: f64 = 0.7;
/// [-] volume fraction: pairs meet often, and seldom three at once.
const FRACTION: f64 = 0.1;
/// Spheres.
const COUNT: usize = 1000;

fn case(steps: f64, seed: u64, duration: f64) -> String {
    let gas = gas(COUNT, FRACTION, SPEED, 1.0);
    format!(
        "# An elastic gas without forces\n{gas}{}{}",
        soft(&ContactLaw::linear(STIFFNESS), steps, "rk2"),
        length(duration, seed)
    )
}

/// Relative change of the temperature per collision that a particle suffers, over N_c.
pub fn heating(grid: &Grid) -> Result<Map, StudyError> {
    let (steps, seeds, collisions) = if grid.quick {
        (vec![5.0, 7.735, 10.0, 15.0], 3, 20.0)
    } else {
        (vec![5.0, 6.0, 7.0, 7.735, 9.0, 10.94, 13.0, 15.0, 20.0], 6, 40.0)
    };
    let seeds: Vec<f64> = even(1.0, f64::from(seeds), seeds as usize);
    let duration = collisions / collision_rate(FRACTION, SPEED * SPEED);
    let runs = grid.run("heating", &points(&seeds, &steps), |&(seed, steps)| {
        let mut simulation = simulation(&case(steps, seed as u64, duration))?;
        let start = simulation.energy();
        let failure = run(&mut simulation, 20, duration);
        let suffered = 2.0 * simulation.record.pairs.count as f64 / COUNT as f64;
        Ok(((simulation.energy() / start).ln() / suffered, failure))
    })?;
    let scheme = Scheme::of(Integrator::Rk2, SoftStepping::Uniform);
    let predicted = |steps: f64| {
        let law = ContactLaw::linear(1.0);
        let realised = realised_restitution(scheme, &law, 1.0, steps);
        realised.map_or(f64::NAN, |realised| heating_per_collision(&realised))
    };
    let rows: Vec<Row> = runs
        .chunks(seeds.len())
        .zip(&steps)
        .map(|(runs, &steps)| {
            let values: Vec<f64> = runs.iter().map(|run| run.0).collect();
            let (value, error) = mean(&values);
            let failure = runs.iter().find_map(|run| run.1.clone());
            Row { values: vec![steps, value, error, predicted(steps)], failure }
        })
        .collect();
    let percent = |row: &Row, k: usize| 100.0 * row.values[k];
    let paper = rows.iter().find(|row| row.values[0] == 7.735);
    let lesson = paper.map_or(String::new(), |row| {
        format!(
            "At N_c = 7.735, the paper’s step, an elastic gas gains {} % of its temperature per collision that a particle suffers \
             ({:.2} % from the linear map), so that it doubles in {:.0}; the gain falls with the fourth power of the step.",
            with_error(percent(row, 1), percent(row, 2)),
            percent(row, 3),
            2.0f64.ln() / row.values[1]
        )
    });
    let curve = |label: &str, kind: Kind, points: Vec<[f64; 3]>| Curve { label: label.into(), kind, points };
    let theory = (0..=60).map(|k| steps[0] + (steps[steps.len() - 1] - steps[0]) * f64::from(k) / 60.0);
    let curves = vec![
        curve("linear map, (⟨e²⟩ − 1)/3", Kind::Theory, theory.map(|n| [n, 100.0 * predicted(n), f64::NAN]).collect()),
        curve(
            "1000 spheres, φ = 0.1",
            Kind::Points(0),
            rows.iter().map(|row| [row.values[0], percent(row, 1), percent(row, 2)]).collect(),
        ),
    ];
    Ok(Map {
        name: "heating",
        title: "Soft, second-order Runge-Kutta: how fast does an elastic gas heat?",
        method: "Each point: an elastic gas of 1000 spheres of 406 µm at T = 0.49 m²/s², uniform stepping, mean over seeds; \
                 the error, one standard error between seeds, is smaller than the marks.",
        lesson,
        columns: vec![
            Column { name: "steps_per_contact", meaning: "N_c [-]" },
            Column { name: "heating", meaning: "relative change of T per collision suffered [-]" },
            Column { name: "heating_se", meaning: "its standard error [-]" },
            Column { name: "predicted", meaning: "by the linear map [-]" },
        ],
        rows,
        picture: Picture::Curves(Curves {
            x_label: "steps per contact, N_c  [-]".into(),
            y_label: "heating per collision  [%]".into(),
            log: [false, true],
            curves,
        }),
        case: case(7.735, 1, duration),
    })
}
