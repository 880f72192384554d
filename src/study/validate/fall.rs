//! Validation row (comparison with a reference) of a small ball that falls in a gas (MFIX DEM06).

use super::check::{CheckResult, CheckScene, ValidationCheck, exact, run_to};
use crate::experiment::Model;
use crate::output::ValidationTier::OtherCodes;
use crate::output::panel::{Panel, PanelSeries, SeriesPoint, SeriesStyle};
use crate::runs::StudyError;

/// Comparison with a reference (row of the validation suite): velocity of a falling ball up to its terminal velocity
/// (test DEM06 of the program MFIX).
pub const TERMINAL: ValidationCheck = ValidationCheck {
    name: "dem06",
    tier: OtherCodes,
    case: "validation/dem06",
    scene: "A ball of 100 µm and 2000 kg/m³ starts at rest in gas that rises at 0.4 m/s; velocity against the gas over time.",
    source: "Stored results of MFIX: truongd8593/mfix@a30f35cf, tests/dem/DEM06/AUTOTEST/POST_TMP.dat, first table, column TMP (slip velocity).",
    not_shown: "Buoyancy: MFIX has it, and here gravity is reduced by the same share of the weight. Also no lift, walls, or two-way coupling.",
    takes_minutes: false,
    measure: terminal,
};

/// Time [s] and slip velocity between ball and gas [m/s], as stored by MFIX.
const STORED: [(f64, f64); 7] = [
    (0.01, 0.41254878),
    (0.02, 0.42238411),
    (0.05, 0.44078841),
    (0.10, 0.45263152),
    (0.15, 0.45603511),
    (0.25, 0.45728970),
    (0.35, 0.45739253),
];

fn terminal(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let mut simulation = scene.simulation(Model::Hard, None, &["run.window=0.1 ms".to_owned()])?;
    let (mut numbers, mut points) = (Vec::new(), vec![SeriesPoint::at(0.0, 0.4)]);
    let slip = |velocity: f64| 0.4 - velocity;
    for (time, stored) in STORED {
        let windows = ((time - simulation.time) / 1e-4).round() as u64;
        run_to(&mut simulation, time, windows)?;
        let found = slip(simulation.particles.velocity[0].z);
        points.push(SeriesPoint::at(simulation.time, found));
        // the tolerance allows for errors of MFIX: 4e-6 m/s from the exact solution of its equations at 10 ms, and a
        // gas velocity that is 4e-7 m/s too high
        numbers.push(exact(format!("slip at {time} s"), "m/s", stored, found, 1e-5));
    }
    let stored = STORED.map(|(time, slip)| SeriesPoint::at(time, slip));
    let panel = Panel {
        x_label: "t  [s]".into(),
        y_label: "slip velocity  [m/s]".into(),
        series: vec![
            PanelSeries::new("this program", SeriesStyle::Line(0), points),
            PanelSeries::new("MFIX", SeriesStyle::Winner, stored),
        ],
        ..Panel::default()
    };
    Ok(CheckResult { numbers, picture: Some(("Slip velocity of a ball that starts at rest in rising gas.", panel)) })
}
