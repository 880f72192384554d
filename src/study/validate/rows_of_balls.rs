//! Validation row (comparison with a reference) of a row of touching balls that is hit at one end.

use super::check::{CheckResult, CheckScene, ValidationCheck, exact, run_to};
use crate::experiment::Model;
use crate::output::ValidationTier::ClosedForms;
use crate::runs::StudyError;

/// Comparison with a reference (row of the validation suite): velocities of the balls of Newton's cradle.
pub const CRADLE: ValidationCheck = ValidationCheck {
    name: "cradle",
    tier: ClosedForms,
    case: "cradle",
    scene: "One ball at 1 m/s hits four that touch, e = 1: velocities of all five afterwards, with linear springs and with hard spheres.",
    source: "Equations of five masses and linear springs that only push, solved independently to eight digits; hard spheres pass the impulse on, one collision after the other.",
    not_shown: "Which of the two a real cradle follows: its contacts are those of Hertz, and its first ball moves back less.",
    takes_minutes: false,
    measure: cradle,
};

/// [m/s] velocities of the five soft balls after the impact, the incoming ball first. They are reference values for
/// linear springs.
const SPRINGS: [f64; 5] = [-0.13227948, -0.07532917, -0.03101083, 0.29621775, 0.94240173];

fn cradle(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let mut numbers = Vec::new();
    // the method is of second order in ω_0 Δt = π/200 (angular frequency ω_0 of a contact, time step Δt). Its error is
    // 2.5e-4 of the speed for each contact that a ball has at the same time
    for (model, name, expected, tolerance) in
        [(Model::Soft, "springs", SPRINGS, 1e-3), (Model::Hard, "hard", [0.0, 0.0, 0.0, 0.0, 1.0], 1e-12)]
    {
        let mut simulation = scene.simulation(model, None, &[])?;
        run_to(&mut simulation, 3e-4, 3)?;
        for (k, expected) in expected.into_iter().enumerate() {
            let found = simulation.particles.velocity[k].x;
            numbers.push(exact(format!("v of ball {}, {name}", k + 1), "m/s", expected, found, tolerance));
        }
    }
    Ok(numbers.into())
}
