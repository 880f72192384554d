//! `summary.json`: everything that is one number per variant. SI units; `null` stands for what is not known.

use super::{
    Bounce, BounceValues, ChartMethod, ChartPoint, ChartQuantity, ChartSlope, ChartStudy, ImpactStudy, OutputError,
    Provenance, Study, TrustSheet, cost,
};
use crate::engine::{Counters, Failure};
use crate::experiment::Model;
use crate::outcome::{Outcome, Timing};
use crate::record::{Ledger, Summary as Impacts};
use crate::statistics::{Estimate, Steadiness};
use serde::Serialize;
use serde_json::Value;

/// The summary of a run or comparison.
///
/// # Errors
/// [`OutputError::Json`] if it cannot be encoded.
pub fn study(study: &Study) -> Result<Vec<u8>, OutputError> {
    let parameters = study.parameters.iter().map(Some).chain(std::iter::repeat(None));
    let variants = study.outcomes.iter().zip(parameters).map(|(outcome, given)| Variant::new(outcome, given)).collect();
    let differences = study.differences.iter().map(DifferenceRow::new).collect();
    let status = status(study.outcomes.iter().any(|outcome| outcome.failure.is_some()));
    let seed = study.outcomes.first().map(|outcome| outcome.experiment.run.seed);
    let body = StudyBody { seed, variants, differences, trust: study.trust };
    encode(&Document::new(study.provenance, status, study.verdicts, study.notes, body))
}

/// The summary of an impact study.
///
/// # Errors
/// [`OutputError::Json`] if it cannot be encoded.
pub fn impact(study: &ImpactStudy) -> Result<Vec<u8>, OutputError> {
    let status = status(study.bounces.iter().any(|bounce| bounce.failure.is_some()));
    let body = ImpactBody {
        requested_restitution: study.requested_restitution,
        diameter: study.diameter,
        impact_speed: study.impact_speed,
        variants: study.bounces.iter().map(BounceRow::new).collect(),
    };
    encode(&Document::new(study.provenance, status, study.verdicts, study.notes, body))
}

/// The summary of a chart.
///
/// # Errors
/// [`OutputError::Json`] if it cannot be encoded.
pub fn chart(study: &ChartStudy) -> Result<Vec<u8>, OutputError> {
    let body = ChartBody {
        reference: study.reference,
        setting: study.setting,
        methods: study.methods,
        quantities: study.quantities,
        points: study.points,
        slopes: study.slopes,
    };
    // a method that fails is a result of a chart
    encode(&Document::new(study.provenance, status(false), study.verdicts, study.notes, body))
}

#[derive(Serialize)]
struct ChartBody<'a> {
    reference: &'a str,
    setting: &'a str,
    methods: &'a [ChartMethod],
    quantities: &'a [ChartQuantity],
    points: &'a [ChartPoint],
    slopes: &'a [ChartSlope],
}

fn encode(document: &impl Serialize) -> Result<Vec<u8>, OutputError> {
    let mut bytes = serde_json::to_vec_pretty(document)?;
    bytes.push(b'\n');
    Ok(bytes)
}

fn status(failed: bool) -> &'static str {
    if failed { "failed" } else { "complete" }
}

/// [-] what the ledger leaves unexplained over the energy that went through it: at the start, by drag and by gravity.
pub(super) fn relative_residual(outcome: &Outcome) -> f64 {
    let ledger = &outcome.record.ledger;
    let through = ledger.through(outcome.energy_at_start);
    let residual = ledger.residual(outcome.energy_at_start, outcome.energy_at_end);
    if through > 0.0 { residual / through } else { f64::NAN }
}

/// [1/s] particles times windows per wall-clock second.
pub(super) fn particle_windows_per_second(outcome: &Outcome) -> f64 {
    if outcome.timing.wall_seconds > 0.0 {
        outcome.particles as f64 * outcome.windows as f64 / outcome.timing.wall_seconds
    } else {
        f64::NAN
    }
}

#[derive(Serialize)]
struct Document<'a, Body> {
    title: &'a str,
    case: &'a str,
    command: &'a str,
    status: &'static str,
    versions: Versions,
    verdicts: &'a [String],
    notes: &'a [String],
    #[serde(flatten)]
    body: Body,
}

impl<'a, Body> Document<'a, Body> {
    fn new(
        provenance: &'a Provenance,
        status: &'static str,
        verdicts: &'a [String],
        notes: &'a [String],
        body: Body,
    ) -> Self {
        let Provenance { title, case_path: case, command, .. } = provenance;
        Self { title, case, command, status, versions: Versions::here(), verdicts, notes, body }
    }
}

#[derive(Serialize)]
struct Versions {
    diptych: &'static str,
    os: &'static str,
    arch: &'static str,
}

impl Versions {
    fn here() -> Self {
        Self { diptych: env!("CARGO_PKG_VERSION"), os: std::env::consts::OS, arch: std::env::consts::ARCH }
    }
}

#[derive(Serialize)]
struct StudyBody<'a> {
    seed: Option<u64>,
    variants: Vec<Variant<'a>>,
    differences: Vec<DifferenceRow<'a>>,
    trust: &'a [TrustSheet],
}

#[derive(Serialize)]
struct Measured {
    value: f64,
    standard_error: f64,
}

impl From<Estimate> for Measured {
    fn from(Estimate { value, error }: Estimate) -> Self {
        Self { value, standard_error: error }
    }
}

#[derive(Serialize)]
struct Variant<'a> {
    name: &'a str,
    model: Model,
    status: &'static str,
    failure: Option<&'a Failure>,
    failure_message: Option<String>,
    particles: usize,
    pair_impacts: u64,
    wall_impacts: u64,
    windows: u64,
    window: f64,
    time_step: f64,
    sample_interval: f64,
    counters: Counters,
    /// Those that ran.
    integrators: Vec<&'static str>,
    wall_seconds: f64,
    simulated_seconds: f64,
    wall_seconds_per_simulated_second: f64,
    particle_windows_per_second: f64,
    timing: Timing,
    energy: Energy,
    granular_temperature: Measured,
    restitution: Restitution,
    impacts: PairsAndWalls<Impacts>,
    impacts_per_second: PairsAndWalls<Measured>,
    momentum_balance: Balance,
    averaging: Averaging,
    initial_state_hash: String,
    final_state_hash: String,
    parameters: Option<&'a Value>,
}

#[derive(Serialize)]
struct PairsAndWalls<T> {
    pairs: T,
    walls: T,
}

#[derive(Serialize)]
struct Energy {
    at_start: f64,
    at_end: f64,
    #[serde(flatten)]
    ledger: Ledger,
    dissipated: f64,
    residual: f64,
    residual_relative: f64,
}

#[derive(Serialize)]
struct Restitution {
    requested_pairs: f64,
    requested_walls: Vec<f64>,
    pairs: f64,
    pairs_standard_error: f64,
    walls: f64,
    walls_standard_error: f64,
}

/// The realised restitution; of no impacts it is not known.
fn realised(impacts: &Impacts) -> f64 {
    if impacts.count > 0 { impacts.mean_restitution } else { f64::NAN }
}

#[derive(Serialize)]
struct Balance {
    drag: Measured,
    weight: f64,
    wall: Measured,
    residual: Measured,
}

#[derive(Serialize)]
struct Averaging {
    from: f64,
    until: f64,
    blocks: usize,
    steadiness: Steadiness,
}

impl<'a> Variant<'a> {
    fn new(outcome: &'a Outcome, parameters: Option<&'a Value>) -> Self {
        let (experiment, record) = (&outcome.experiment, &outcome.record);
        let impacts = PairsAndWalls { pairs: outcome.pairs.summary(), walls: outcome.walls.summary() };
        Self {
            name: &experiment.name,
            model: experiment.model(),
            status: status(outcome.failure.is_some()),
            failure: outcome.failure.as_ref(),
            failure_message: outcome.failure.as_ref().map(ToString::to_string),
            particles: outcome.particles,
            pair_impacts: record.pairs.count,
            wall_impacts: record.walls.count,
            windows: outcome.windows,
            window: outcome.window,
            // the summary has always had 0 here for events
            time_step: outcome.time_step.unwrap_or(0.0),
            sample_interval: outcome.sample_interval,
            counters: outcome.counters,
            integrators: outcome.integrators(),
            wall_seconds: outcome.timing.wall_seconds,
            simulated_seconds: outcome.simulated_seconds,
            wall_seconds_per_simulated_second: cost(outcome),
            particle_windows_per_second: particle_windows_per_second(outcome),
            timing: outcome.timing,
            energy: Energy {
                at_start: outcome.energy_at_start,
                at_end: outcome.energy_at_end,
                ledger: record.ledger,
                dissipated: record.ledger.dissipated(),
                residual: record.ledger.residual(outcome.energy_at_start, outcome.energy_at_end),
                residual_relative: relative_residual(outcome),
            },
            granular_temperature: outcome.temperature.into(),
            restitution: Restitution {
                requested_pairs: experiment.scene.contact.restitution,
                requested_walls: experiment.scene.walls.iter().map(|wall| wall.surface.restitution).collect(),
                pairs: realised(&impacts.pairs),
                pairs_standard_error: outcome.pair_restitution.error,
                walls: realised(&impacts.walls),
                walls_standard_error: outcome.wall_restitution.error,
            },
            impacts,
            impacts_per_second: PairsAndWalls { pairs: outcome.pair_rate.into(), walls: outcome.wall_rate.into() },
            momentum_balance: Balance {
                drag: outcome.balance.drag.into(),
                weight: outcome.balance.weight,
                wall: outcome.balance.wall.into(),
                residual: outcome.balance.residual.into(),
            },
            averaging: Averaging {
                from: outcome.profiles.from,
                until: outcome.profiles.until,
                blocks: outcome.profiles.blocks,
                steadiness: outcome.steadiness,
            },
            // As text: JSON readers keep 53 bits of a number.
            initial_state_hash: format!("{:016x}", outcome.initial_state_hash),
            final_state_hash: format!("{:016x}", outcome.final_state_hash),
            parameters,
        }
    }
}

#[derive(Serialize)]
struct DifferenceRow<'a> {
    quantity: &'a str,
    unit: &'a str,
    variant: &'a str,
    reference: &'a str,
    largest: Measured,
    largest_in_standard_errors: f64,
    y: f64,
    rms_in_standard_errors: f64,
    slices: usize,
    slices_beyond_three_standard_errors: usize,
    expected_by_chance: f64,
}

impl<'a> DifferenceRow<'a> {
    fn new(difference: &'a super::Difference) -> Self {
        Self {
            quantity: &difference.quantity,
            unit: &difference.unit,
            variant: &difference.variant,
            reference: &difference.reference,
            largest: difference.largest.into(),
            largest_in_standard_errors: difference.in_errors(),
            y: difference.y,
            rms_in_standard_errors: difference.rms_in_errors,
            slices: difference.slices,
            slices_beyond_three_standard_errors: difference.beyond_three,
            expected_by_chance: difference.expected_beyond_three,
        }
    }
}

#[derive(Serialize)]
struct ImpactBody<'a> {
    requested_restitution: f64,
    diameter: f64,
    impact_speed: f64,
    variants: Vec<BounceRow<'a>>,
}

#[derive(Serialize)]
struct BounceRow<'a> {
    name: &'a str,
    model: Model,
    status: &'static str,
    failure: Option<&'a Failure>,
    failure_message: Option<String>,
    #[serde(flatten)]
    values: BounceValues,
    analytic: Option<BounceValues>,
    time_step: f64,
    steps_or_events: u64,
    wall_seconds: f64,
    parameters: &'a Value,
}

impl<'a> BounceRow<'a> {
    fn new(bounce: &'a Bounce) -> Self {
        Self {
            name: &bounce.name,
            model: bounce.model,
            status: status(bounce.failure.is_some()),
            failure: bounce.failure.as_ref(),
            failure_message: bounce.failure.as_ref().map(ToString::to_string),
            values: bounce.values,
            analytic: bounce.analytic.as_ref().map(|analytic| analytic.values),
            time_step: bounce.time_step,
            steps_or_events: bounce.work,
            wall_seconds: bounce.wall_seconds,
            parameters: &bounce.parameters,
        }
    }
}
