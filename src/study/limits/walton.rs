//! Comparison of Walton's rule with impacts of soft spheres. The rule computes oblique impacts of hard spheres from
//! the restitution, the friction and the tangential restitution β_0. The tangential spring of the soft impacts has the
//! same β_0.

use super::picture::{MapAxis, even, plane, points};
use super::scenes::{run, simulation};
use super::sweep::{KnownPoint, MapSweep, Points};
use crate::contact_law::damping_ratio;
use crate::engine::Failure;
use crate::experiment::Amount;
use crate::output::limits::Shade;
use crate::output::numbers::significant;
use crate::rotation::{ImpactRule, LinearTangential, ObliqueApproach, TangentialLaw, slip};
use crate::runs::StudyError;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// [-] largest errors of Walton's rule in the first four classes, each of which has its own colour in the map. An error
/// is that of the tangential impulse, divided by the largest friction impulse.
const CLASSES: [f64; 4] = [0.002, 0.01, 0.05, 0.2];

/// [-] ratio M_t/M for a solid sphere: effective mass of the slip divided by that of the normal motion
/// (docs/rotation.md).
const SOLID: f64 = 2.0 / 7.0;

/// Tangential law with the tangential restitution `beta` (β_0) [-], for surfaces whose normal restitution is
/// `restitution` [-]. If the tangential law of the case is given by a β_0, `beta` replaces this β_0. Otherwise the
/// spring has no dashpot, and its stiffness ratio is κ = (2/7)(1 - ζ²)(arccos(-β_0)/π)², with the damping ratio ζ.
fn law(case: &TangentialLaw, restitution: f64, beta: f64) -> TangentialLaw {
    let ratio = damping_ratio(restitution);
    TangentialLaw::Linear(match case {
        TangentialLaw::Linear(LinearTangential::Restitution(_)) => LinearTangential::Restitution(beta),
        _ => {
            let stiffness = SOLID * (1.0 - ratio * ratio) * ((-beta).acos() / PI).powi(2);
            LinearTangential::Ratios { stiffness, dashpot: 0.0 }
        }
    })
}

/// Reduced slip s/(μ u_n) [-] of the surfaces after one impact with the tangential law `law`, with slip s, coefficient
/// of friction μ and normal speed u_n. `reduced` [-] is the reduced slip before the impact. The second part of the
/// result is the failure of the run if it stopped early, otherwise `None`.
fn rebound(grid: &Points, law: TangentialLaw, reduced: f64) -> Result<(f64, Option<Failure>), StudyError> {
    let mut unit = 0.0;
    let mut simulation = simulation(&grid.with(|case| {
        case.scene.rotation.iter_mut().for_each(|rotation| rotation.tangential = law);
        let friction = case.scene.walls[0].surface.friction;
        if let Amount::Placed(particles) = &mut case.start[0].amount {
            let normal_speed = -particles.velocity[0].y;
            unit = friction * normal_speed;
            particles.velocity[0] = Vector3::new(reduced * unit, -normal_speed, 0.0);
        }
    }))?;
    let failure = run(&mut simulation, 1, grid.base.run.duration);
    let particles = &simulation.particles;
    let surface = particles.spin_of(0) * particles.radius[0];
    Ok((slip(&particles.velocity[0], &Vector3::y(), &surface).x / unit, failure))
}

/// Map of the error of Walton's rule as a function of the slip before the impact and of β_0. The restitution and the
/// kind of tangential spring are those of the case.
pub fn walton(grid: &Points) -> Result<Vec<MapSweep>, StudyError> {
    let Some(rotation) = &grid.base.scene.rotation else {
        return Err(StudyError::Failed("error: the case of a map of oblique impacts has no rotation".into()));
    };
    let (case, restitution) = (&rotation.tangential, grid.base.scene.walls[0].surface.restitution);
    let damped = matches!(case, TangentialLaw::Linear(LinearTangential::Restitution(_)));
    let (slips, betas) = grid.choose(
        (even(0.1, 2.0, 20), vec![0.2, 0.44, 0.7, 0.9]),
        (even(0.05, 2.0, 40), even(if damped { 0.05 } else { 0.0 }, 1.0, if damped { 20 } else { 21 })),
    );
    let rows = grid.run(&points(&slips, &betas), |&(share, beta)| {
        let reduced = share * (1.0 + restitution) / (SOLID * (1.0 + beta));
        let (after, failure) = rebound(grid, law(case, restitution, beta), reduced)?;
        // masses are in units of M (effective mass of the normal motion), speeds in units of μ u_n (coefficient of
        // friction times normal speed)
        let approach = ObliqueApproach {
            friction: 1.0,
            restitution,
            normal_speed: 1.0,
            normal_impulse: 1.0 + restitution,
            slip: reduced,
            mass: SOLID,
            mass_ratio: SOLID,
        };
        let rule = ImpactRule::Walton { tangential_restitution: beta };
        let walton = reduced - rule.impulse(&approach) / SOLID;
        let error = (after - walton) * SOLID / (1.0 + restitution);
        Ok(KnownPoint { values: vec![share, beta, after, walton, error], failure })
    })?;
    let error = |row: &KnownPoint| row.values[4].abs();
    let picture = plane(
        &MapAxis("slip before over that at which Walton’s rule turns  [-]", &slips, false),
        &MapAxis("tangential restitution, β_0  [-]", &betas, false),
        &[
            ("off by up to 0.2 %", Shade::Level(0)),
            ("off by up to 1 %", Shade::Level(1)),
            ("off by up to 5 %", Shade::Level(2)),
            ("off by up to 20 %", Shade::Level(3)),
            ("off by more than 20 %", Shade::Fails),
        ],
        |k| CLASSES.iter().filter(|end| error(&rows[k]) > **end).count(),
        Vec::new(),
    );
    let largest = |beta: f64| {
        let error = rows.iter().filter(|row| row.values[1] == beta).map(error).fold(0.0, f64::max);
        significant(100.0 * error, 2)
    };
    let spring = if damped { "a spring with equal half periods" } else { "a spring without dashpot" };
    let lesson = format!(
        "At e = {restitution} {spring} is off Walton’s rule by at most {} % of the largest friction impulse for β_0 = {}, and by {} % for \
         β_0 = {}; the largest errors stand where the rule turns from sticking to sliding.",
        largest(betas[0]),
        betas[0],
        largest(betas[betas.len() / 2]),
        betas[betas.len() / 2]
    );
    Ok(vec![MapSweep::new(rows, lesson, picture)])
}
