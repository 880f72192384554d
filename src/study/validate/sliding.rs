//! Validation rows (comparisons with references) of balls that slide, roll and spin: MFIX DEM04, and a ball that is
//! dropped with spin.

use super::check::{CheckResult, CheckScene, ValidationCheck, exact, run_to};
use crate::experiment::Model;
use crate::output::ValidationTier::ClosedForms;
use crate::output::panel::{Panel, PanelSeries, SeriesPoint, SeriesStyle};
use crate::runs::StudyError;
use crate::simulation::Simulation;

/// [m/s] velocity of the first ball along x, and its radius times spin R ω, which is positive if the ball rolls along
/// +x. `radius` [m] is R.
fn rolling(simulation: &Simulation, radius: f64) -> [f64; 2] {
    [simulation.particles.velocity[0].x, -simulation.particles.spin_of(0).z * radius]
}

/// Comparison with a reference (row of the validation suite): a ball that slides along a floor until it rolls (test
/// DEM04 of the program MFIX).
pub const SLIDE_TO_ROLL: ValidationCheck = ValidationCheck {
    name: "dem04",
    tier: ClosedForms,
    case: "rotation/slide-to-roll",
    scene: "A ball of 1 mm slides at 0.1 m/s along a floor with μ = 0.2, 0.5 or 1 until it rolls; soft spheres at their static overlap.",
    source: "v = u_0 - μ g t until t_s = 2 u_0/(7 μ g), then 5 u_0/7 (g = 9.81 m/s²). Scene: truongd8593/mfix@472ea0c4, tests/dem/DEM04/mfix.dat.",
    not_shown: "Rolling resistance, rough floors, and hard spheres, which cannot lie on a floor.",
    takes_minutes: false,
    measure: slide_to_roll,
};

fn slide_to_roll(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let (speed, radius, gravity) = (0.1, 5e-4, 9.81);
    // overlap m g/k at rest, with which the ball does not oscillate: mass m = 5.2360e-6 kg, gravity g, stiffness k =
    // 10 kN/m
    let sunk = 4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius * 1e4 * gravity / 1e4;
    let (mut numbers, mut series) = (Vec::new(), Vec::new());
    for (place, friction) in [0.2, 0.5, 1.0].into_iter().enumerate() {
        let ends = 2.0 * speed / (7.0 * friction * gravity);
        let sets = [
            format!("particles[0].at[0].position[1]={} m", radius - sunk),
            format!("walls[0].friction={friction}"),
            "soft.steps_per_contact=50".to_owned(),
        ];
        let mut simulation = scene.simulation(Model::Soft, None, &sets)?;
        let mut points = vec![SeriesPoint::at(0.0, speed)];
        let mut halfway = f64::NAN;
        for part in 1..=40 {
            run_to(&mut simulation, ends * f64::from(part) / 20.0, 1)?;
            points.push(SeriesPoint::at(1e3 * simulation.time, rolling(&simulation, radius)[0]));
            if part == 10 {
                halfway = rolling(&simulation, radius)[0];
            }
        }
        let [velocity, surface] = rolling(&simulation, radius);
        // when sliding ends, the tangential spring is still stretched, so the ball oscillates until the dashpot has
        // damped the oscillation. Its amplitude μ g sqrt(m/(3.5 k_t)) is 1e-4 of the speed here (coefficient of
        // friction μ, gravity g, mass m, stiffness k_t of the spring)
        let tolerance = 1e-4 * speed;
        numbers.push(exact(format!("v at t_s/2, μ = {friction}"), "m/s", 6.0 / 7.0 * speed, halfway, tolerance));
        numbers.push(exact(format!("v at 2 t_s, μ = {friction}"), "m/s", 5.0 / 7.0 * speed, velocity, tolerance));
        numbers.push(exact(format!("R ω at 2 t_s, μ = {friction}"), "m/s", 5.0 / 7.0 * speed, surface, tolerance));
        series.push(PanelSeries::new(format!("μ = {friction}"), SeriesStyle::Line(place), points));
    }
    let panel = Panel {
        x_label: "t  [ms]".into(),
        y_label: "velocity of the centre  [m/s]".into(),
        series,
        marks: vec![(5.0 / 7.0 * speed, "5 u₀/7")],
        ..Panel::default()
    };
    Ok(CheckResult { numbers, picture: Some(("A ball slides until it rolls.", panel)) })
}

/// Comparison with a reference (row of the validation suite): a ball that is dropped on a floor with spin.
pub const DROPPED_WITH_SPIN: ValidationCheck = ValidationCheck {
    name: "dropped-with-spin",
    tier: ClosedForms,
    case: "rotation/dropped-with-spin",
    scene: "A ball with R ω = 2 m/s falls on a floor with e = 0.8, μ = 0.25, β_0 = 0.44; after three bounces of a hard ball, and at the end of a soft one.",
    source: "Walton's rule (1993; not read, the rule is that of docs/rotation.md), bounce by bounce; m R v + I ω is conserved, so that v ends at (5 v_0 + 2 R ω_0)/7 = 4/7 m/s.",
    not_shown: "Friction that depends on speed, and contacts of other bodies at once.",
    takes_minutes: false,
    measure: dropped_with_spin,
};

/// [m/s] reference values after each of three bounces of the hard ball: velocity along the floor, and radius times spin
/// R ω.
const BOUNCES: [[f64; 2]; 3] = [[0.45, 0.875], [0.624857143, 0.437857143], [0.54792, 0.6302]];

fn dropped_with_spin(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let (radius, gravity, restitution) = (0.01, 9.81, 0.8_f64);
    // this height gives the ball a speed of 1 m/s at the floor
    let sets = [format!("particles[0].at[0].position[1]={} m", radius + 0.5 / gravity)];
    let mut simulation = scene.simulation(Model::Hard, None, &sets)?;
    let mut numbers = Vec::new();
    let mut touch = 1.0 / gravity;
    for (k, expected) in BOUNCES.into_iter().enumerate() {
        let flight = 2.0 * restitution.powi(k as i32 + 1) / gravity;
        run_to(&mut simulation, touch + 0.5 * flight, 1)?;
        touch += flight;
        let found = rolling(&simulation, radius);
        for (name, (expected, found)) in ["v", "R ω"].into_iter().zip(expected.into_iter().zip(found)) {
            // tolerance: the reference has nine decimals
            numbers.push(exact(format!("{name} after bounce {}, hard", k + 1), "m/s", expected, found, 1e-9));
        }
    }
    let mut simulation = scene.simulation(Model::Soft, None, &sets)?;
    run_to(&mut simulation, 2.0, 200)?;
    for (name, found) in ["v", "R ω"].into_iter().zip(rolling(&simulation, radius)) {
        // the lever arm is the radius even while the ball overlaps the floor, so m R v + I ω is conserved (mass m,
        // radius R, velocity v, moment of inertia I, spin ω)
        numbers.push(exact(format!("{name} at the end, soft"), "m/s", 4.0 / 7.0, found, 1e-4));
    }
    Ok(numbers.into())
}
