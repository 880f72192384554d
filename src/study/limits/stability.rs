//! Soft, stability of lasting contacts: a sphere held between two walls, slightly disturbed.
//!
//! Two walls hold it, each with half the stiffness and half the dashpot: together they are one contact of stiffness k_n
//! and restitution e that lasts, without a force that would press the sphere against a single one.

use super::Grid;
use super::cells::{cells, class, even, points};
use super::scenes::{DIAMETER, STIFFNESS, mass, run, simulation};
use crate::contact_law::damping_ratio;
use crate::experiment::{Integrator, SoftStepping};
use crate::output::limits::{Cells, Column, Map, Picture, Row, Shade};
use crate::output::numbers::significant;
use crate::predict::integrator::{Scheme, reduced_step, stability_limit};
use crate::study::session::StudyError;
use std::f64::consts::PI;

/// [-] overlap with each wall over the diameter.
const SQUEEZE: f64 = 0.005;

/// [-] the disturbance over that overlap: the contacts last until it has grown a hundredfold.
const DISTURBANCE: f64 = 0.01;

/// Time steps of a point: Heun's growth at ω_0 Δt = 0.1 without damping, 1.25e-5 a step, makes 3.5 of it.
const STEPS: f64 = 1e5;

/// A swing that has grown by more than this grows: far from 1, which it keeps without damping, and from the hundred at which
/// contacts open.
const GROWS: f64 = 2.0;

/// Velocity Verlet.
pub fn verlet(grid: &Grid) -> Result<Map, StudyError> {
    let title = "Soft, velocity Verlet: which time step keeps a lasting contact stable?";
    stability(grid, "stability-verlet", title, Integrator::VelocityVerlet)
}

/// Heun's method.
pub fn heun(grid: &Grid) -> Result<Map, StudyError> {
    let title = "Soft, second-order Runge-Kutta (the paper’s): which time step keeps a lasting contact stable?";
    stability(grid, "stability-heun", title, Integrator::Rk2)
}

fn case(restitution: f64, step: f64, integrator: &str) -> String {
    // the damping ratio of two such walls is √2 times that of one
    let damping = damping_ratio(restitution) / 2.0f64.sqrt();
    let of_one = (-PI * damping / (1.0 - damping * damping).sqrt()).exp();
    let (floor, squeeze) = (0.001, SQUEEZE * DIAMETER);
    let (ceiling, height) = (floor + DIAMETER - 2.0 * squeeze, floor + 0.5 * DIAMETER - (1.0 - DISTURBANCE) * squeeze);
    format!(
        "# A sphere held between two walls that share its contact, slightly disturbed\n\
         [domain]\nsize = [\"2 mm\", \"4 mm\", \"2 mm\"]\nperiodic = [\"x\", \"z\"]\n\
         [[particles]]\ndiameter = \"406 um\"\ndensity = \"1038 kg/m^3\"\n\
         at = [{{ position = [\"1 mm\", \"{height} m\", \"1 mm\"], velocity = [\"0 m/s\", \"0 m/s\", \"0 m/s\"] }}]\n\
         [[walls]]\nplane = {{ point = [\"0 m\", \"{floor} m\", \"0 m\"], normal = [0, 1, 0] }}\nrestitution = {of_one}\n\
         [[walls]]\nplane = {{ point = [\"0 m\", \"{ceiling} m\", \"0 m\"], normal = [0, -1, 0] }}\nrestitution = {of_one}\n\
         [soft.linear_spring_dashpot]\nstiffness = \"{} N/m\"\n[soft]\ntime_step = \"{step} s\"\nstepping = \"uniform\"\n\
         integrator = \"{integrator}\"\nallow_unstable = true\n[run]\nmodel = \"soft\"\nduration = \"{} s\"\n",
        0.5 * STIFFNESS,
        STEPS * step
    )
}

fn stability(grid: &Grid, name: &'static str, title: &'static str, integrator: Integrator) -> Result<Map, StudyError> {
    let (x, e) =
        if grid.quick { (even(0.2, 3.0, 15), even(0.2, 1.0, 5)) } else { (even(0.1, 3.0, 30), even(0.05, 1.0, 20)) };
    let word = match integrator {
        Integrator::VelocityVerlet => "velocity_verlet",
        Integrator::Rk2 => "rk2",
    };
    let frequency = (STIFFNESS / mass()).sqrt();
    let method = Scheme::of(integrator, SoftStepping::Uniform).method;
    let rows = grid.run(name, &points(&x, &e), |&(reduced, restitution)| {
        let step = reduced / frequency;
        let mut simulation = simulation(&case(restitution, step, word))?;
        let mut failure = run(&mut simulation, 1, STEPS * step);
        // half the range of its places, over a period at the shortest step
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for _ in 0..64 {
            // an energy that grew does not stop the motion
            failure = failure.or(run(&mut simulation, 1, step));
            let place = simulation.particles.position[0].y;
            (least, most) = (least.min(place), most.max(place));
        }
        let swing = 0.5 * (most - least);
        let first = DISTURBANCE * SQUEEZE * DIAMETER;
        let limit = stability_limit(method, damping_ratio(restitution));
        Ok(Row { values: vec![reduced, restitution, swing / first, limit], failure })
    })?;
    let grows = |row: &Row| row.failure.is_some() || row.values[2] > GROWS;
    let wrong = rows.iter().filter(|row| grows(row) != (row.values[0] > row.values[3])).count();
    let picture = Picture::Cells(Cells {
        x_label: "time step, ω₀Δt  [-]".into(),
        y_label: "restitution asked for, e  [-]".into(),
        log: [false; 2],
        classes: vec![class("a disturbance stays or dies out", Shade::Level(0)), class("it grows", Shade::Fails)],
        cells: cells(&x, &e, [false; 2], |k| usize::from(grows(&rows[k]))),
        lines: vec![(
            "limit from the step’s linear map".into(),
            even(e[0] * 0.5, 1.0, 100).into_iter().map(|e| (stability_limit(method, damping_ratio(e)), e)).collect(),
        )],
    });
    let limit = |e: f64| significant(stability_limit(method, damping_ratio(e)), 3);
    let rule = match integrator {
        Integrator::VelocityVerlet => format!(
            "Verlet is stable up to ω₀Δt = 2(√(1+ζ²) − ζ): {} without damping, {} at e = 0.5, {} at e = 0.1; beyond, a run is refused (StepTooLong)",
            limit(1.0),
            limit(0.5),
            limit(0.1)
        ),
        Integrator::Rk2 => format!(
            "Heun’s method needs damping: without it every step grows, and at e = 0.9 all above ω₀Δt = {}, N_c = {}; a run is warned (StepTooLong)",
            limit(0.9),
            significant(reduced_step(0.9, 1.0) / stability_limit(method, damping_ratio(0.9)), 2)
        ),
    };
    let lesson = format!(
        "{rule}. {} of {} cells fall on the side of the line that the linear map says.",
        rows.len() - wrong,
        rows.len()
    );
    Ok(Map {
        name,
        title,
        method: "Each cell: 100 000 steps of a sphere held between two walls that share one contact’s stiffness and dashpot, disturbed by 1 % of its \
                 overlap; grown if it swings more than twice as far in the end. Contacts that open stop the growth; contacts that share a \
                 sphere add their stiffness.",
        lesson,
        columns: vec![
            Column { name: "reduced_step", meaning: "ω₀Δt [-]" },
            Column { name: "restitution", meaning: "e asked for [-]" },
            Column { name: "growth", meaning: "swing at the end over the disturbance [-]" },
            Column { name: "limit", meaning: "largest stable ω₀Δt by the linear map [-]" },
        ],
        rows,
        picture,
        case: case(0.5, 1.7 / frequency, word),
    })
}
