//! Validation rows (comparisons with references) of oblique impacts of a ball of 5 mm on a plate: MFIX DEM05, and the
//! measurements of Kharaz et al.

use super::check::{CheckResult, CheckScene, ValidationCheck, exact, read_off, run_to};
use crate::experiment::Model;
use crate::output::ValidationTier::{Experiments, OtherCodes};
use crate::output::panel::{Panel, PanelSeries, SeriesPoint, SeriesStyle};
use crate::runs::StudyError;

/// [m/s] speed of the ball before each impact.
const SPEED: f64 = 3.9;

/// Motion of a ball after an oblique impact on a plate.
pub(super) struct PlateRebound {
    /// [-] velocity along the plate after the impact, divided by that before the impact.
    pub(super) ratio: f64,
    /// [rad/s] spin after the impact, positive if the ball rolls forward along the plate.
    pub(super) spin: f64,
    /// [°] angle between the path of the centre after the impact and the normal of the plate.
    pub(super) angle: f64,
}

/// Motion of a soft ball after an impact; `angle` [°] is that between the velocity before the impact and the normal of
/// the plate. `sets` are changes of keys of the case.
pub(super) fn rebound(scene: &CheckScene, angle: f64, sets: &[String]) -> Result<PlateRebound, StudyError> {
    let (sin, cos) = angle.to_radians().sin_cos();
    let mut sets = sets.to_vec();
    sets.push(format!("particles[0].at[0].velocity[0]={} m/s", SPEED * sin));
    sets.push(format!("particles[0].at[0].velocity[1]={} m/s", -SPEED * cos));
    sets.extend(["soft.stepping=local".to_owned(), "soft.steps_per_contact=200".to_owned()]);
    let mut simulation = scene.simulation(Model::Soft, None, &sets)?;
    // time for a gap of 10 µm, and for a contact of 12 to 20 µs
    run_to(&mut simulation, 1e-5 / (SPEED * cos) + 3e-5, 1)?;
    let v = simulation.particles.velocity[0];
    Ok(PlateRebound {
        ratio: v.x / (SPEED * sin),
        spin: -simulation.particles.spin_of(0).z,
        angle: v.x.atan2(v.y).to_degrees(),
    })
}

/// Result of MFIX for one impact, as three numbers: the angle [°] between the velocity before the impact and the
/// normal, the velocity along the plate after the impact over that before [-], and the spin after the impact [rad/s].
/// The numbers are those of the columns "Part-Wall" in MFIX's files `POST_COEFF.dat` and `POST_OMEGA.dat`.
type StoredImpact = (f64, f64, f64);

const LINEAR: [StoredImpact; 6] = [
    (10.0, 0.6556, 231.9435),
    (15.0, 0.5971, 404.5505),
    (20.0, 0.5946, 538.0793),
    (30.0, 0.6813, 618.8437),
    (45.0, 0.8160, 505.7470),
    (60.0, 0.8938, 357.9511),
];

const HERTZIAN: [StoredImpact; 6] = [
    (10.0, 0.6903, 208.3846),
    (15.0, 0.6236, 377.6207),
    (20.0, 0.6150, 510.5268),
    (30.0, 0.6813, 618.3861),
    (45.0, 0.8160, 505.2858),
    (60.0, 0.8938, 357.6565),
];

/// Comparison with a reference (row of the validation suite): oblique impacts with linear springs, compared with
/// results of MFIX (DEM05).
pub const LINEAR_SPRINGS: ValidationCheck = ValidationCheck {
    name: "dem05-linear",
    tier: OtherCodes,
    case: "rotation/oblique",
    scene: "A ball of 5 mm hits a plate at 3.9 m/s with μ = 0.092, e = 1 and linear springs of 17.2 and 14.8 MN/m, at 10 to 60 degrees from the normal.",
    source: "Stored results of MFIX: truongd8593/mfix@2025a831, tests/dem/DEM05/AUTOTEST/POST_COEFF.dat and POST_OMEGA.dat, linear, columns Part-Wall.",
    not_shown: "Angles below 10 degrees, where MFIX's steps (a fiftieth of a contact) cost it up to 2.5 %.",
    takes_minutes: false,
    measure: |scene| stored(scene, &LINEAR, &[]),
};

/// Comparison with a reference (row of the validation suite): oblique impacts with springs of Hertz and Mindlin,
/// compared with results of MFIX (DEM05).
pub const HERTZ_MINDLIN: ValidationCheck = ValidationCheck {
    name: "dem05-hertz",
    tier: OtherCodes,
    case: "rotation/mindlin",
    scene: "The ball of dem05-linear with the laws of Hertz and Mindlin (380 GPa, 0.23 on 70 GPa, 0.25), e = 1; the spring remembers displacements.",
    source: "Stored results of MFIX: truongd8593/mfix@2025a831, tests/dem/DEM05/AUTOTEST/POST_COEFF.dat and POST_OMEGA.dat, Hertzian, columns Part-Wall.",
    not_shown: "Other histories of the spring, and angles below 10 degrees, where the lever arm decides (MFIX takes the radius less the overlap).",
    takes_minutes: false,
    measure: |scene| {
        let sets = [
            "walls[0].elasticity.youngs_modulus=70 GPa",
            "walls[0].elasticity.poissons_ratio=0.25",
            "walls[0].restitution=1",
            "contact.restitution=1",
            "soft.tangential.mindlin.history=displacement",
            // hard spheres of different materials need a separate impact rule, although this row does not run them
            "hard.friction.walton.tangential_restitution=0.3",
        ];
        stored(scene, &HERTZIAN, &sets.map(str::to_owned))
    },
};

fn stored(scene: &CheckScene, expected: &[StoredImpact], sets: &[String]) -> Result<CheckResult, StudyError> {
    let mut numbers = Vec::new();
    let mut found = Vec::new();
    for (angle, ratio, spin) in expected {
        let left = rebound(scene, *angle, sets)?;
        // the lever arm of MFIX is smaller than the radius by the overlap (0.7 %), and its step is a fiftieth of a
        // contact; together these differences are up to 2 %
        numbers.push(exact(format!("v_t'/v_t at {angle}°"), "", *ratio, left.ratio, 0.02 * ratio));
        numbers.push(exact(format!("spin at {angle}°"), "rad/s", *spin, left.spin, 0.02 * spin));
        found.push(SeriesPoint::at(*angle, left.ratio));
    }
    let expected = expected.iter().map(|(angle, ratio, _)| SeriesPoint::at(*angle, *ratio));
    let panel = Panel {
        x_label: "angle from the normal  [°]".into(),
        y_label: "v_t'/v_t  [-]".into(),
        series: vec![
            PanelSeries::new("this program", SeriesStyle::Sweep(0), found),
            PanelSeries::new("MFIX", SeriesStyle::Winner, expected),
        ],
        ..Panel::default()
    };
    Ok(CheckResult {
        numbers,
        picture: Some(("Velocity along the plate after an oblique impact, over that before.", panel)),
    })
}

/// Comparison with a reference (row of the validation suite): measured rebounds of balls of aluminium oxide from
/// glass.
pub const MEASURED: ValidationCheck = ValidationCheck {
    name: "kharaz",
    tier: Experiments,
    case: "rotation/mindlin",
    scene: "A ball of aluminium oxide (5 mm, 380 GPa) hits thick glass (70 GPa) at 3.9 m/s; e = 0.98 and μ = 0.092; Hertz and Mindlin.",
    source: "Kharaz, Gorham and Salman (2001, Powder Technol. 120, 281) as digitised in truongd8593/mfix@2025a831, tests/dem/DEM05/AUTOTEST/POST_ALPHA.dat, POST_COEFF.dat, POST_OMEGA.dat, column Experiment. The paper itself was not read.",
    not_shown: "The scatter of the measurement: the file gives none, and a reading error of 1 % of the largest value is assumed. e and μ are fitted to these data by their authors.",
    takes_minutes: false,
    measure: measured,
};

/// Angle [°] between the velocity before the impact and the normal, and measured ratio of the velocities along the
/// plate after and before the impact [-]. `SPINS` has measured spins [rad/s] instead, and `ANGLES` the angles [°]
/// between the velocity after the impact and the normal.
const RATIOS: [(f64, f64); 6] =
    [(9.6304, 0.6728), (20.0845, 0.5964), (30.2218, 0.6883), (39.3031, 0.7719), (49.5459, 0.8469), (59.8416, 0.9019)];
const SPINS: [(f64, f64); 6] = [
    (10.9840, 264.5493),
    (21.1931, 577.0096),
    (31.0947, 612.6481),
    (39.0283, 595.4843),
    (50.2214, 452.9444),
    (60.2460, 381.3185),
];
const ANGLES: [(f64, f64); 6] = [
    (9.9429, 6.6917),
    (20.5594, 12.3645),
    (30.3767, 21.7809),
    (39.6233, 32.5455),
    (49.7831, 45.1051),
    (60.0571, 57.3652),
];

/// Measured quantity: name, unit, points (angle of impact and value), and the function that returns the quantity for a
/// simulated rebound.
type MeasuredKind = (&'static str, &'static str, &'static [(f64, f64)], fn(&PlateRebound) -> f64);

fn measured(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let sets = [
        "walls[0].elasticity.youngs_modulus=70 GPa",
        "walls[0].elasticity.poissons_ratio=0.25",
        "hard.friction.walton.tangential_restitution=0.3",
    ]
    .map(str::to_owned);
    let (mut numbers, mut found) = (Vec::new(), Vec::new());
    let kinds: [MeasuredKind; 3] = [
        ("v_t'/v_t", "", &RATIOS, |left| left.ratio),
        ("spin", "rad/s", &SPINS, |left| left.spin),
        ("rebound angle", "°", &ANGLES, |left| left.angle),
    ];
    for (name, unit, points, of) in kinds {
        let largest = points.iter().map(|point| point.1).fold(0.0, f64::max);
        for (angle, value) in points {
            let ours = of(&rebound(scene, *angle, &sets)?);
            let expected = (*value, 0.01 * largest);
            numbers.push(read_off(format!("{name} at {angle}°"), unit, expected, ours, 0.05 * largest));
            if name == "spin" {
                found.push(SeriesPoint::at(*angle, ours));
            }
        }
    }
    let points = SPINS.iter().map(|(angle, spin)| SeriesPoint { x: *angle, y: *spin, error: Some(6.0) });
    let panel = Panel {
        x_label: "angle from the normal  [°]".into(),
        y_label: "spin after the impact  [rad/s]".into(),
        series: vec![
            PanelSeries::new("this program", SeriesStyle::Sweep(0), found),
            PanelSeries::new("measured, Kharaz et al. 2001", SeriesStyle::Points(1), points),
        ],
        ..Panel::default()
    };
    Ok(CheckResult {
        numbers,
        picture: Some(("Spin of a ball after an oblique impact. Bars: the assumed error of reading.", panel)),
    })
}
