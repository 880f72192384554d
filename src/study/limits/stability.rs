//! Stability of lasting contacts of soft spheres: a sphere held between two walls is slightly disturbed.
//!
//! Each of the two walls has half the stiffness and half the dashpot. Together they act as one lasting contact of
//! stiffness k_n and restitution e. No force presses the sphere against a single wall.

use super::picture::{MapAxis, even, plane, points};
use super::scenes::{DIAMETER, STIFFNESS, mass, restitute, run, simulation};
use super::sweep::{KnownPoint, MapSweep, Points};
use crate::contact_law::damping_ratio;
use crate::experiment::{Integrator, TimeStep};
use crate::output::limits::Shade;
use crate::output::numbers::significant;
use crate::predict::integrator::{Scheme, reduced_step, stability_limit};
use crate::runs::StudyError;
use std::f64::consts::PI;

/// [-] overlap of the sphere with each of the two walls, divided by the diameter of the sphere.
const SQUEEZE: f64 = 0.005;

/// [-] size of the initial disturbance, divided by the overlap of the sphere with each wall. If the disturbance grows
/// a hundredfold, the contacts open.
const DISTURBANCE: f64 = 0.01;

/// Number of time steps in the run of one point of the map. At ω_0 Δt = 0.1 (time step Δt, undamped angular frequency
/// ω_0 of the contact) and without damping, Heun's method increases the disturbance by 1.25e-5 per step, a factor of
/// 3.5 in all.
const STEPS: f64 = 1e5;

/// [-] ratio of the final to the initial disturbance above which a point of the map counts as unstable. Without
/// damping a stable point has the ratio 1; at the ratio 100 the contacts open.
const GROWS: f64 = 2.0;

/// [-] restitution that each of the two walls must have, so that both contacts together act as one contact of the
/// given `restitution` [-]. The damping ratio of one contact is that of both contacts together, divided by √2.
fn of_one(restitution: f64) -> f64 {
    let damping = damping_ratio(restitution) / 2.0f64.sqrt();
    (-PI * damping / (1.0 - damping * damping).sqrt()).exp()
}

/// Map of the growth of a disturbance as a function of time step and restitution. The integrator is that of the case.
pub fn stability(grid: &Points) -> Result<Vec<MapSweep>, StudyError> {
    let (x, e) = grid.choose((even(0.2, 3.0, 15), even(0.2, 1.0, 5)), (even(0.1, 3.0, 30), even(0.05, 1.0, 20)));
    let frequency = (STIFFNESS / mass()).sqrt();
    let soft = &grid.base.soft;
    let method = Scheme::of(soft.integrator, soft.stepping).method;
    let rows = grid.run(&points(&x, &e), |&(reduced, restitution)| {
        let step = reduced / frequency;
        let mut simulation = simulation(&grid.with(|case| {
            restitute(case, of_one(restitution));
            case.soft.time_step = TimeStep::Fixed(step);
        }))?;
        let mut failure = run(&mut simulation, 1, STEPS * step);
        // the amplitude is half the range of the positions during 64 steps, which is one period of the oscillation at
        // the shortest step
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for _ in 0..64 {
            // the run is continued even if a step failed because the energy grew
            failure = failure.or(run(&mut simulation, 1, step));
            let place = simulation.particles.position[0].y;
            (least, most) = (least.min(place), most.max(place));
        }
        let swing = 0.5 * (most - least);
        let first = DISTURBANCE * SQUEEZE * DIAMETER;
        let limit = stability_limit(method, damping_ratio(restitution));
        Ok(KnownPoint { values: vec![reduced, restitution, swing / first, limit], failure })
    })?;
    let grows = |row: &KnownPoint| row.failure.is_some() || row.values[2] > GROWS;
    let limit = |e: f64| stability_limit(method, damping_ratio(e));
    let theory = even(e[0] * 0.5, 1.0, 100).into_iter().map(|e| (limit(e), e)).collect();
    let picture = plane(
        &MapAxis("time step, ω₀Δt  [-]", &x, false),
        &MapAxis("restitution asked for, e  [-]", &e, false),
        &[("a disturbance stays or dies out", Shade::Level(0)), ("it grows", Shade::Fails)],
        |k| usize::from(grows(&rows[k])),
        vec![("limit from the step’s linear map", theory)],
    );
    let wrong = rows.iter().filter(|row| grows(row) != (row.values[0] > row.values[3])).count();
    let shown = |e: f64| significant(limit(e), 3);
    let rule = match soft.integrator {
        Integrator::VelocityVerlet => format!(
            "Verlet is stable up to ω₀Δt = 2(√(1+ζ²) − ζ): {} without damping, {} at e = 0.5, {} at e = 0.1; beyond, a run is refused (StepTooLong)",
            shown(1.0),
            shown(0.5),
            shown(0.1)
        ),
        Integrator::Rk2 => format!(
            "Heun’s method needs damping: without it every step grows, and at e = 0.9 all above ω₀Δt = {}, N_c = {}; a run is warned (StepTooLong)",
            shown(0.9),
            significant(reduced_step(0.9, 1.0) / limit(0.9), 2)
        ),
    };
    let lesson = format!(
        "{rule}. {} of {} cells fall on the side of the line that the linear map says.",
        rows.len() - wrong,
        rows.len()
    );
    Ok(vec![MapSweep::new(rows, lesson, picture)])
}
