//! Validation rows (comparisons with references) of balls that fall on a floor or are squeezed: MFIX DEM01, DEM02 and
//! DEM03, and the end of infinitely many bounces.

use super::check::{CheckResult, CheckScene, ValidationCheck, exact, run_to, stopped};
use crate::engine::Failure;
use crate::experiment::Model;
use crate::output::ValidationTier::ClosedForms;
use crate::output::panel::{Panel, PanelSeries, SeriesPoint, SeriesStyle};
use crate::runs::StudyError;
use crate::simulation::Simulation;

/// [m/s²] acceleration of gravity in the MFIX cases, as in their case files.
const GRAVITY: f64 = 9.80665;

/// [m] height of the apex of the flight of the ball, computed from its present height and velocity.
fn apex(simulation: &Simulation) -> f64 {
    let (x, v) = (simulation.particles.position[0], simulation.particles.velocity[0]);
    x.y + v.y * v.y / (2.0 * GRAVITY)
}

/// Comparison with a reference (row of the validation suite): a ball that bounces on a soft floor (test DEM01 of the
/// program MFIX).
pub const SOFT_FLOOR: ValidationCheck = ValidationCheck {
    name: "dem01",
    tier: ClosedForms,
    case: "validation/dem01",
    scene: "A ball of 0.2 m and 2600 kg/m³ falls from 0.5 m on a floor with 50 kN/m or 100 kN/m; soft spheres, 1000 local steps in a contact.",
    source: "Closed form of a damped oscillator with weight, evaluated independently to eight digits. Scene: truongd8593/mfix@472ea0c4, tests/dem/DEM01/mfix.dat.",
    not_shown: "Contacts of other laws, with other particles, or with friction. The softest floor of MFIX (10 kN/m) is left out: its overlap exceeds the radius.",
    takes_minutes: false,
    measure: soft_floor,
};

/// Stiffness [N/m] and restitution [-] of the floor, then the reference values of the largest overlap [m] and of the
/// height of the next apex [m].
const SOFT_FLOORS: [(f64, f64, f64, f64); 4] = [
    (5e4, 1.0, 0.04352938, 0.5),
    (5e4, 0.9, 0.04131345, 0.41907173),
    (5e4, 0.6, 0.03450570, 0.23085515),
    (1e5, 0.9, 0.02878026, 0.42055502),
];

fn soft_floor(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let mut numbers = Vec::new();
    for (stiffness, restitution, overlap, height) in SOFT_FLOORS {
        let sets = [
            format!("soft.linear_spring_dashpot.stiffness={stiffness} N/m"),
            format!("walls[0].restitution={restitution}"),
        ];
        let mut simulation = scene.simulation(Model::Soft, None, &sets)?;
        run_to(&mut simulation, 0.5, 1)?;
        let deepest = simulation.record.walls.summary().largest_overlap.map(|share| share * 0.2);
        let of = format!("{} kN/m, e = {restitution}", stiffness / 1e3);
        // the reference has eight digits, and the truncation error of local steps is far smaller than the tolerance
        let tolerance = |value: f64| 1e-5 * value;
        numbers.push(exact(format!("overlap, {of}"), "m", overlap, deepest.unwrap_or(f64::NAN), tolerance(overlap)));
        numbers.push(exact(format!("apex, {of}"), "m", height, apex(&simulation), tolerance(height)));
    }
    Ok(numbers.into())
}

/// Comparison with a reference (row of the validation suite): heights of the apexes of a bouncing hard ball (test
/// DEM02 of the program MFIX).
pub const APEXES: ValidationCheck = ValidationCheck {
    name: "dem02",
    tier: ClosedForms,
    case: "validation/dem01",
    scene: "The ball of dem01 as a hard sphere with e = 0.9: apexes after six bounces.",
    source: "Geometric series of flights: r + (h - r) e^(2k). Scene: truongd8593/mfix@472ea0c4, tests/dem/DEM02/mfix.dat.",
    not_shown: "The duration of a bounce, which hard spheres do not have.",
    takes_minutes: false,
    measure: apexes,
};

fn apexes(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let (radius, height, restitution) = (0.1, 0.5, 0.9_f64);
    let mut simulation = scene.simulation(Model::Hard, None, &["run.duration=3 s".to_owned()])?;
    let fall = (2.0 * (height - radius) / GRAVITY).sqrt();
    let (mut numbers, mut points) = (Vec::new(), vec![SeriesPoint::at(0.0, height)]);
    for part in 1..=10 {
        // fall until shortly before the first impact
        run_to(&mut simulation, 0.0999 * fall * f64::from(part), 1)?;
        points.push(SeriesPoint::at(simulation.time, simulation.particles.position[0].y));
    }
    let mut until = fall;
    for bounce in 1..=6 {
        // flight after this bounce, until shortly before its end
        let half = fall * restitution.powi(bounce);
        for part in 1..=20 {
            run_to(&mut simulation, until + half * f64::from(part) / 10.0 - if part == 20 { 1e-6 } else { 0.0 }, 1)?;
            points.push(SeriesPoint::at(simulation.time, simulation.particles.position[0].y));
        }
        let expected = radius + (height - radius) * restitution.powi(2 * bounce);
        // tolerance: rounding of some ten operations on lengths of 1 m
        numbers.push(exact(format!("apex {bounce}"), "m", expected, apex(&simulation), 1e-9));
        until += 2.0 * half;
    }
    // apex k is in the middle of the flight between impacts k and k + 1
    let peak = |k: i32| {
        let before: f64 = (1..k).map(|j| 2.0 * fall * restitution.powi(j)).sum();
        let time = if k == 0 { 0.0 } else { fall + before + fall * restitution.powi(k) };
        SeriesPoint::at(time, radius + (height - radius) * restitution.powi(2 * k))
    };
    let peaks = (0..=6).map(peak);
    let panel = Panel {
        x_label: "t  [s]".into(),
        y_label: "height of the centre  [m]".into(),
        series: vec![
            PanelSeries::new("hard sphere", SeriesStyle::Line(0), points),
            PanelSeries::new("apexes, closed form", SeriesStyle::Winner, peaks),
        ],
        ..Panel::default()
    };
    Ok(CheckResult {
        numbers,
        picture: Some(("Height of a bouncing hard ball, and the apexes of the closed form.", panel)),
    })
}

/// Comparison with a reference (row of the validation suite): two balls that are squeezed between floor and ceiling
/// (test DEM03 of the program MFIX).
pub const SQUEEZED: ValidationCheck = ValidationCheck {
    name: "dem03",
    tier: ClosedForms,
    case: "validation/dem03",
    scene: "Balls of 1 mm with 20,000 and 10,000 kg/m³ are squeezed between two walls 1.8 mm apart, with 1 kN/m in all three contacts.",
    source: "Equations of two masses, three springs and three dashpots, solved independently to ten digits. Scene: truongd8593/mfix@2025a831, tests/dem/DEM03/mfix.dat.",
    not_shown: "Contacts that begin or end, and motion across the line of centres.",
    takes_minutes: false,
    measure: squeezed,
};

/// Restitution [-] and time [s], then the reference values of height y [m] and velocity v [m/s], first of the lower
/// ball, then of the upper ball.
const SQUEEZES: [(f64, f64, [f64; 4]); 5] = [
    (1.0, 1e-4, [4.3267464587e-4, -0.233122618, 1.3813857854e-3, 0.350795400]),
    (1.0, 5e-4, [4.3623748029e-4, 0.230577292, 1.3791393490e-3, -0.403903856]),
    (1.0, 1e-3, [4.2712799164e-4, -0.0259470187, 1.3835531579e-3, 0.391852092]),
    (0.7, 1e-4, [4.3533699077e-4, -0.181620386, 1.3756917685e-3, 0.250746732]),
    (0.7, 1e-3, [4.3260457240e-4, 0.0216720591, 1.3665695217e-3, 0.0344590064]),
];

fn squeezed(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let mut numbers = Vec::new();
    for (restitution, time, expected) in SQUEEZES {
        let keys = ["contact.restitution", "walls[0].restitution", "walls[1].restitution"];
        let mut sets: Vec<String> = keys.iter().map(|key| format!("{key}={restitution}")).collect();
        sets.push("soft.steps_per_contact=2000".to_owned());
        let mut simulation = scene.simulation(Model::Soft, None, &sets)?;
        run_to(&mut simulation, time, 1)?;
        let (x, v) = (&simulation.particles.position, &simulation.particles.velocity);
        let found = [x[0].y, v[0].y, x[1].y, v[1].y];
        let names = ["y of the lower ball", "v of the lower ball", "y of the upper ball", "v of the upper ball"];
        for (k, name) in names.into_iter().enumerate() {
            // displacements are up to 0.1 mm and speeds up to 0.4 m/s; the first step Δt with a dashpot has a relative
            // error of 2 ζ ω_0 Δt (damping ratio ζ, undamped angular frequency ω_0)
            let (unit, scale) = if k % 2 == 0 { ("m", 1e-4) } else { ("m/s", 0.4) };
            let what = format!("{name}, e = {restitution}, {} ms", time * 1e3);
            numbers.push(exact(what, unit, expected[k], found[k], 3e-4 * scale));
        }
    }
    Ok(numbers.into())
}

/// Comparison with a reference (row of the validation suite): instant at which infinitely many bounces of a hard
/// sphere end.
pub const ZENO: ValidationCheck = ValidationCheck {
    name: "zeno",
    tier: ClosedForms,
    case: "bouncing-sphere",
    scene: "A hard sphere of 406 µm falls 20 mm and bounces until it rests; the instant at which the run reports that the bounces end.",
    source: "Sum of the flights: (1 + e)/(1 - e) sqrt(2h/g), with g = 9.81 m/s².",
    not_shown: "What happens afterwards: hard spheres without a contact time stop there.",
    takes_minutes: false,
    measure: zeno,
};

fn zeno(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let mut numbers = Vec::new();
    for restitution in [0.94_f64, 0.9, 0.5] {
        let expected = (1.0 + restitution) / (1.0 - restitution) * (2.0 * 0.02 / 9.81_f64).sqrt();
        let sets = [format!("walls[0].restitution={restitution}"), "run.duration=4 s".to_owned()];
        let mut simulation = scene.simulation(Model::Hard, None, &sets)?;
        let ended = match simulation.run(3000, 1e-3) {
            Err(Failure::InelasticCollapse { time, .. }) => time,
            Err(why) => return Err(stopped(why)),
            Ok(()) => f64::NAN,
        };
        // in double precision, flights shorter than about 1e-8 s are not resolved; the tolerance allows for many of
        // these flights
        numbers.push(exact(format!("rest, e = {restitution}"), "s", expected, ended, 1e-5));
    }
    Ok(numbers.into())
}
