//! Validation rows (comparisons with references) of flows: beads that run out of a vessel, and the mean profile of a
//! turbulent gas.

use super::check::{CheckResult, CheckScene, ValidationCheck, averaged, exact, stopped};
use crate::experiment::Model;
use crate::fluid::{Profile, TurbulenceModel};
use crate::output::ValidationTier::{Experiments, OtherCodes};
use crate::output::figures::CHANNEL_DNS;
use crate::output::panel::{Panel, PanelSeries, SeriesPoint, SeriesStyle};
use crate::runs::StudyError;
use crate::statistics::Estimate;

/// Comparison with a reference (row of the validation suite): mass flow of beads through a hole in the bottom of a
/// vessel.
pub const BEVERLOO: ValidationCheck = ValidationCheck {
    name: "beverloo",
    tier: Experiments,
    case: "walls/discharge",
    scene: "3000 glass beads of 2 mm run through a hole of 12 mm in a flat bottom and start anew above; soft spheres that rotate, μ = 0.3.",
    source: "Beverloo, Leniger and van de Velde (1961, Chem. Eng. Sci. 15, 260): C ρ_b sqrt(g) (D - k d)^2.5 with C = 0.58, k = 1.4, ρ_b = 1500 kg/m³. The constants are those usually given for spheres; the paper itself was not read.",
    not_shown: "Holes above six diameters. The law is a fit: its constants differ by some 10 % between materials, which is the margin here.",
    takes_minutes: true,
    measure: beverloo,
};

fn beverloo(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let expected = 0.58 * 0.6 * 2500.0 * 9.81_f64.sqrt() * (12e-3_f64 - 1.4 * 2e-3).powf(2.5);
    let sets =
        ["soft.tangential.linear.stiffness_ratio=0.2857142857", "soft.tangential.linear.dashpot_ratio=0.2857142857"];
    let mut simulation = scene.simulation(Model::Soft, None, &sets.map(str::to_owned))?;
    simulation.run(50, 6e-3).map_err(stopped)?;
    // mass flow in eight intervals of 0.1 s: mean downward momentum divided by the height of the box, 0.12 m
    let mut parts = Vec::new();
    for _ in 0..8 {
        let mut sum = 0.0;
        for _ in 0..20 {
            simulation.run(1, 5e-3).map_err(stopped)?;
            sum -= simulation.particles.momentum().z / 0.12;
        }
        parts.push(1e3 * sum / 20.0);
    }
    Ok(vec![averaged("mass per time", "g/s", Estimate::exact(1e3 * expected), parts, 100.0 * expected)].into())
}

/// Comparison with a reference (row of the validation suite): mean velocity of a turbulent channel flow without
/// particles.
pub const CHANNEL_GAS: ValidationCheck = ValidationCheck {
    name: "channel-gas",
    tier: OtherCodes,
    case: "paper/gas-d",
    scene: "Mean velocity of the gas in a channel at Re_τ = 1000, in wall units, by the k-ε model of Launder and Sharma that drives particles here.",
    source: "Direct numerical simulation of Lee and Moser (2015, J. Fluid Mech. 774, 395) at Re_τ = 1000.5, as in cases/paper/gas-dns.csv of this repository, which names its source. The paper itself was not read.",
    not_shown: "Turbulence as such: a k-ε model is known to miss the profile by some per cent, and particles see its mean velocity only.",
    takes_minutes: false,
    measure: channel_gas,
};

fn channel_gas(_: &CheckScene) -> Result<CheckResult, StudyError> {
    // bulk velocity U_b [m/s], height 2h [m] and viscosity ν [m²/s] of the channel of the paper (docs/paper.md)
    let (bulk, height, viscosity) = (15.9075, 0.04, 1.515e-5);
    let profile = Profile::k_epsilon_channel(bulk, height, viscosity, TurbulenceModel::LaunderSharma)
        .map_err(StudyError::Failed)?;
    let Some(flow) = profile.channel_flow() else { return Err(StudyError::Failed("error: no channel".into())) };
    let friction = flow.friction_velocity;
    let at = |plus: f64| profile.velocity(plus * viscosity / friction) / friction;
    // tolerance 5 %, the expected error of models of this kind
    let numbers: Vec<_> =
        CHANNEL_DNS.iter().map(|(plus, u)| exact(format!("U+ at y+ = {plus}"), "", *u, at(*plus), 0.05 * u)).collect();
    let line = (0..=100).map(|k| 2.0 * 500f64.powf(f64::from(k) / 100.0)).map(|plus| SeriesPoint::at(plus, at(plus)));
    let panel = Panel {
        x_label: "y+  [-]".into(),
        y_label: "U+  [-]".into(),
        log_x: true,
        series: vec![
            PanelSeries::new("Launder-Sharma", SeriesStyle::Line(0), line),
            PanelSeries::new(
                "direct simulation",
                SeriesStyle::Winner,
                CHANNEL_DNS.map(|(plus, u)| SeriesPoint::at(plus, u)),
            ),
        ],
        ..Panel::default()
    };
    Ok(CheckResult { numbers, picture: Some(("Mean velocity of the gas in a channel, in wall units.", panel)) })
}
