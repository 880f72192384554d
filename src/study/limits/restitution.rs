//! Soft, realised restitution of a head-on pair whose touch falls anywhere within a step.

use super::Grid;
use super::cells::{cells, class, even, points};
use super::scenes::{DIAMETER, STIFFNESS, length, mass, run, simulation, soft};
use crate::contact_law::{Bodies, ContactLaw, Hertz};
use crate::experiment::{Integrator, SoftStepping};
use crate::output::limits::{Cells, Column, Map, Picture, Row, Shade};
use crate::output::numbers::significant;
use crate::predict::integrator::{Scheme, realised_restitution};
use crate::scene::Elasticity;
use crate::study::session::StudyError;

/// Ends of the classes of |realised - asked|: nothing, a digit, a fluctuation of one percent, of five.
const CLASSES: [f64; 4] = [0.001, 0.005, 0.02, 0.05];

/// Spheres whose contacts last about as long at 1 m/s as those of the linear law here (cases/hertz.toml).
const HERTZ: ContactLaw =
    ContactLaw::Hertz(Hertz { elasticity: Elasticity { youngs_modulus: 2.8e8, poissons_ratio: 0.34 } });

/// Velocity Verlet.
pub fn verlet(grid: &Grid) -> Result<Map, StudyError> {
    let title = "Soft, velocity Verlet: which restitution comes out of how many steps?";
    restitution(grid, "restitution-verlet", title, Integrator::VelocityVerlet, &ContactLaw::linear(STIFFNESS))
}

/// Hertzian contacts under velocity Verlet.
pub fn hertz(grid: &Grid) -> Result<Map, StudyError> {
    let title = "Soft, Hertzian contacts under velocity Verlet: which restitution comes out of how many steps?";
    restitution(grid, "restitution-hertz", title, Integrator::VelocityVerlet, &HERTZ)
}

/// Heun's method.
pub fn heun(grid: &Grid) -> Result<Map, StudyError> {
    let title = "Soft, second-order Runge-Kutta (the paper’s): which restitution comes out of how many steps?";
    restitution(grid, "restitution-heun", title, Integrator::Rk2, &ContactLaw::linear(STIFFNESS))
}

/// Two spheres that approach at 1 m/s and touch `gap` [m] later.
fn case(restitution: f64, gap: f64, duration: f64, method: &str) -> String {
    let right = 0.001 + DIAMETER + gap;
    format!(
        "# Two spheres meet head-on\n[domain]\nsize = [\"3 mm\", \"2 mm\", \"2 mm\"]\n[[particles]]\ndiameter = \"406 um\"\ndensity = \"1038 kg/m^3\"\n\
         at = [\n  {{ position = [\"1 mm\", \"1 mm\", \"1 mm\"], velocity = [\"0.5 m/s\", \"0 m/s\", \"0 m/s\"] }},\n  \
         {{ position = [\"{right} m\", \"1 mm\", \"1 mm\"], velocity = [\"-0.5 m/s\", \"0 m/s\", \"0 m/s\"] }},\n]\n\
         [contact]\nrestitution = {restitution}\n{method}{}",
        length(duration, 1)
    )
}

fn restitution(
    grid: &Grid,
    name: &'static str,
    title: &'static str,
    integrator: Integrator,
    law: &ContactLaw,
) -> Result<Map, StudyError> {
    let (steps, e, phases) = if grid.quick {
        (vec![5.0, 7.735, 10.0, 15.0, 20.0, 50.0], vec![0.1, 0.5, 0.8, 0.94, 1.0], 20)
    } else {
        (vec![5.0, 6.0, 7.735, 10.0, 12.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0], even(0.1, 1.0, 19), 100)
    };
    let word = match integrator {
        Integrator::VelocityVerlet => "velocity_verlet",
        Integrator::Rk2 => "rk2",
    };
    let scheme = Scheme::of(integrator, SoftStepping::Uniform);
    let bodies = |restitution| Bodies {
        effective_mass: 0.5 * mass(),
        effective_radius: 0.25 * DIAMETER,
        restitution,
        elasticity: [None; 2],
    };
    let step = |e: f64, steps: f64| law.contact_time(&law.between(&bodies(e)), 1.0) / steps;
    let rows = grid.run(name, &points(&steps, &e), |&(steps, e)| {
        let step = step(e, steps);
        let duration = (2.0 * steps).ceil() * step + 4.0 * step;
        let mut failure = None;
        let (mut sum, mut least, mut largest) = (0.0, f64::INFINITY, 0.0f64);
        for phase in 0..phases {
            let gap = step * (1.0 + (f64::from(phase) + 0.5) / f64::from(phases));
            let mut simulation = simulation(&case(e, gap, duration, &soft(law, steps, word)))?;
            failure = failure.or(run(&mut simulation, 1, duration));
            let speeds = super::scenes::speeds(&simulation);
            let realised = speeds[1] - speeds[0];
            sum += realised / f64::from(phases);
            (least, largest) = (least.min(realised), largest.max(realised));
        }
        let predicted = realised_restitution(scheme, law, e, steps);
        let predicted = predicted.map_or(f64::NAN, |realised| realised.mean);
        Ok(Row { values: vec![steps, e, sum, least, largest, predicted], failure })
    })?;
    let miss = |row: &Row| row.values[2] - row.values[1];
    let level = |row: &Row| CLASSES.iter().filter(|end| miss(row).abs() > **end).count();
    let shades = [Shade::Level(0), Shade::Level(1), Shade::Level(2), Shade::Level(3), Shade::Fails];
    let labels = ["up to 0.001", "up to 0.005", "up to 0.02", "up to 0.05", "more than 0.05"];
    let picture = Picture::Cells(Cells {
        x_label: "steps per contact, N_c  [-]".into(),
        y_label: "restitution asked for, e  [-]".into(),
        log: [true, false],
        classes: labels.iter().zip(shades).map(|(label, shade)| class(format!("off by {label}"), shade)).collect(),
        cells: cells(&steps, &e, [true, false], |k| level(&rows[k])),
        lines: Vec::new(),
    });
    let furthest = rows.iter().map(|row| (row.values[2] - row.values[5]).abs()).fold(0.0, f64::max);
    let gain = rows.iter().filter(|row| row.values[1] == 1.0 && row.values[0] == 7.735).map(miss).sum::<f64>();
    let lesson = format!(
        "At N_c = 7.735 (the paper’s pairs) an elastic pair rebounds with e = {} on average; below e ≈ 0.2 even 50 steps leave an error, \
         since a dashpot that is noticed late misses its first, hardest blow. Runs and the map of one step agree within {}.",
        significant(1.0 + gain, 5),
        significant(furthest, 1)
    );
    Ok(Map {
        name,
        title,
        method: "Each cell: the mean over touches at equally spaced phases of a step, pairs of 406 µm spheres at 1 m/s, contacts found at \
                 step ends (uniform stepping). Local stepping, which finds the exact instants, has no such error.",
        lesson,
        columns: vec![
            Column { name: "steps_per_contact", meaning: "N_c [-]" },
            Column { name: "restitution", meaning: "e asked for [-]" },
            Column { name: "mean", meaning: "realised, mean over phases [-]" },
            Column { name: "least", meaning: "the least [-]" },
            Column { name: "largest", meaning: "the largest [-]" },
            Column { name: "predicted", meaning: "mean by the map of one step [-]" },
        ],
        rows,
        picture,
        case: case(1.0, 1.5 * step(1.0, 7.735), 24.0 * step(1.0, 7.735), &soft(law, 7.735, word)),
    })
}
