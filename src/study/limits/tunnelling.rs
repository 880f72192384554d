//! Soft, too soft for the speed: deep overlaps, and spheres that pass through.

use super::Grid;
use super::cells::{cells, class, even, points, ratios};
use super::scenes::{DIAMETER, STIFFNESS, length, mass, run, simulation, soft};
use crate::contact_law::ContactLaw;
use crate::engine::Failure;
use crate::output::limits::{Cells, Column, Map, Picture, Row, Shade};
use crate::output::numbers::significant;
use crate::study::session::StudyError;

/// Thickness of the plate over the diameter.
const PLATE: f64 = 0.1;
/// [m] height of its middle.
const MIDDLE: f64 = 0.02;

fn pair_case(speed: f64, stiffness: f64, duration: f64) -> String {
    let half = 0.5 * speed;
    format!(
        "# Two spheres meet head-on\n[domain]\nsize = [\"10 mm\", \"2 mm\", \"2 mm\"]\n[[particles]]\ndiameter = \"406 um\"\ndensity = \"1038 kg/m^3\"\n\
         at = [\n  {{ position = [\"4.5 mm\", \"1 mm\", \"1 mm\"], velocity = [\"{half} m/s\", \"0 m/s\", \"0 m/s\"] }},\n  \
         {{ position = [\"5.5 mm\", \"1 mm\", \"1 mm\"], velocity = [\"-{half} m/s\", \"0 m/s\", \"0 m/s\"] }},\n]\n\
         [contact]\nrestitution = 1\n{}{}",
        soft(&ContactLaw::linear(stiffness), 20.0, "velocity_verlet"),
        length(duration, 1)
    )
}

/// The largest overlap of a pair over impact speed and stiffness.
pub fn pair(grid: &Grid) -> Result<Map, StudyError> {
    let count = if grid.quick { 13 } else { 25 };
    let (speed, stiffness) = (ratios(0.01, 100.0, count), ratios(0.01, 1e5, count));
    let reduced = 0.5 * mass();
    let duration = |speed: f64, stiffness: f64| {
        // from 0.594 mm apart to the touch, a contact, and as long again
        let contact = std::f64::consts::PI * (reduced / stiffness).sqrt();
        0.6e-3 / speed + 2.0 * contact
    };
    let rows = grid.run("tunnelling-pair", &points(&speed, &stiffness), |&(speed, stiffness)| {
        let duration = duration(speed, stiffness);
        let mut simulation = simulation(&pair_case(speed, stiffness, duration))?;
        let failure = run(&mut simulation, 1, duration);
        let overlap = match &failure {
            Some(Failure::OverlapTooLarge { ratio, .. }) => *ratio,
            _ => simulation.record.pairs.summary().largest_overlap,
        };
        let predicted = speed * (reduced / stiffness).sqrt() / DIAMETER;
        Ok(Row { values: vec![speed, stiffness, overlap, predicted], failure })
    })?;
    let level = |row: &Row| {
        if row.failure.is_some() { 3 } else { [0.01, 0.1].iter().filter(|end| row.values[2] > **end).count() }
    };
    let line = |ratio: f64| speed.iter().map(|u| (*u, reduced * (u / (ratio * DIAMETER)).powi(2))).collect::<Vec<_>>();
    let picture = Picture::Cells(Cells {
        x_label: "impact speed, u_n  [m/s]".into(),
        y_label: "stiffness, k_n  [N/m]".into(),
        log: [true; 2],
        classes: vec![
            class("δ/d below 0.01", Shade::Level(0)),
            class("to 0.1", Shade::Level(1)),
            class("to 0.5", Shade::Level(2)),
            class("stopped: OverlapTooLarge", Shade::Fails),
        ],
        cells: cells(&speed, &stiffness, [true; 2], |k| level(&rows[k])),
        lines: vec![("u√(M/k) = 0.5 d".into(), line(0.5)), ("u√(M/k) = 0.01 d".into(), line(0.01))],
    });
    let wrong = rows.iter().filter(|row| row.failure.is_some() != (row.values[3] > 0.5)).count();
    let lesson = format!(
        "The overlap is u√(M/k): for 1 % of a diameter at 1 m/s these spheres need k = {:.0} N/m. Beyond half a diameter a run stops with \
         OverlapTooLarge; {} of {} cells lie on the side of that line that the closed form says.",
        reduced * (1.0 / (0.01 * DIAMETER)).powi(2),
        rows.len() - wrong,
        rows.len()
    );
    Ok(Map {
        name: "tunnelling-pair",
        title: "Soft: which stiffness for which impact speed?",
        method: "Each cell: two elastic spheres of 406 µm head-on at 20 steps per contact.",
        lesson,
        columns: vec![
            Column { name: "impact_speed_m_s", meaning: "u_n [m/s]" },
            Column { name: "stiffness_n_m", meaning: "k_n [N/m]" },
            Column { name: "overlap", meaning: "largest seen over the diameter [-]" },
            Column { name: "predicted", meaning: "u sqrt(M/k)/d [-]" },
        ],
        rows,
        picture,
        case: pair_case(10.0, 1.0, duration(10.0, 1.0)),
    })
}

/// A sphere falls on a plate from `height` [m] above its middle.
fn plate_case(speed: f64, steps: f64, height: f64, duration: f64) -> String {
    format!(
        "# A sphere and a thin plate\n[domain]\nsize = [\"4 mm\", \"40 mm\", \"4 mm\"]\n[[particles]]\ndiameter = \"406 um\"\ndensity = \"1038 kg/m^3\"\n\
         at = [{{ position = [\"2 mm\", \"{} m\", \"2 mm\"], velocity = [\"0 m/s\", \"-{speed} m/s\", \"0 m/s\"] }}]\n\
         [[walls]]\ncuboid = {{ center = [\"2 mm\", \"20 mm\", \"2 mm\"], half_extents = [\"2 mm\", \"{} m\", \"2 mm\"] }}\nrestitution = 1\n{}{}",
        MIDDLE + height,
        0.5 * PLATE * DIAMETER,
        soft(&ContactLaw::linear(STIFFNESS), steps, "velocity_verlet"),
        length(duration, 1)
    )
}

/// Whether a sphere gets through a thin plate, over its speed and the steps per contact.
pub fn plate(grid: &Grid) -> Result<Map, StudyError> {
    let (speed, steps, phases) = if grid.quick {
        (even(0.2, 4.0, 20), vec![2.0, 3.0, 4.0, 5.0, 7.0, 10.0], 8)
    } else {
        (even(0.1, 6.0, 60), vec![1.6, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 15.0], 24)
    };
    let frequency = (STIFFNESS / mass()).sqrt();
    let rows = grid.run("tunnelling-plate", &points(&speed, &steps), |&(reduced, steps)| {
        let speed = reduced * DIAMETER * frequency;
        let step = std::f64::consts::PI / frequency / steps;
        let (mut failure, mut passed, mut stopped) = (None, 0, 0);
        for phase in 0..phases {
            let height =
                0.5 * (1.0 + PLATE) * DIAMETER + speed * step * (1.0 + (f64::from(phase) + 0.5) / f64::from(phases));
            // two steps to the plate, two past it, and as long as a contact
            let duration = step * (4.0 + (1.5 * steps).ceil());
            let mut simulation = simulation(&plate_case(speed, steps, height, duration))?;
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
        Ok(Row { values: vec![reduced, steps, share(stopped), share(passed)], failure })
    })?;
    let level = |row: &Row| match (row.values[2] > 0.0, row.values[3] > 0.0) {
        (_, true) => 2,
        (true, false) => 1,
        (false, false) => 0,
    };
    let jump: Vec<(f64, f64)> = even(steps[0] * 0.8, steps[steps.len() - 1] * 1.1, 60)
        .into_iter()
        .map(|steps| (0.5 * (1.0 + PLATE) * steps / std::f64::consts::PI, steps))
        .collect();
    let seen = rows.iter().filter(|row| row.values[3] > 0.0).map(|row| row.values[0]).fold(f64::INFINITY, f64::min);
    let resolved = rows.iter().filter(|row| row.values[3] > 0.0 && row.values[1] >= 5.0).map(|row| row.values[0]);
    let resolved = resolved.fold(f64::INFINITY, f64::min);
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
    Ok(Map {
        name: "tunnelling-plate",
        title: "Soft: when does a sphere pass through a thin plate?",
        method: "Each cell: an elastic sphere of 406 µm against a plate a tenth of a diameter thick, from equally spaced phases of a step. \
                 Passed unseen: it is below the plate and nothing was recorded.",
        lesson,
        columns: vec![
            Column { name: "reduced_speed", meaning: "u/(d ω₀), the overlap of a contact over the diameter [-]" },
            Column { name: "steps_per_contact", meaning: "N_c [-]" },
            Column { name: "stopped", meaning: "share of the phases that stopped with OverlapTooLarge [-]" },
            Column { name: "passed", meaning: "share that passed unseen [-]" },
        ],
        picture: Picture::Cells(Cells {
            x_label: "impact speed over d ω₀  [-]".into(),
            y_label: "steps per contact, N_c  [-]".into(),
            log: [false, true],
            classes: vec![
                class("turned back", Shade::Level(0)),
                class("stopped: OverlapTooLarge", Shade::Fails),
                class("some pass unseen", Shade::Silent),
            ],
            cells: cells(&speed, &steps, [false, true], |k| level(&rows[k])),
            lines: vec![("a step carries the centre past the middle".into(), jump)],
        }),
        rows,
        case: plate_case(DIAMETER * frequency, 10.0, 0.4e-3, 1e-4),
    })
}
