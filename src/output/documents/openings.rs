//! Parts of a report about inlets and outlets. A variant is one of the experiments of a case.

use super::run::measured;
use crate::observe::{FlowAverages, FlowSample};
use crate::outcome::Outcome;
use crate::output::OutputError;
use crate::output::csv::{CsvTable, number};
use crate::output::document::Block;
use crate::output::numbers::{significant, with_error};
use serde_json::{Value, json};

/// Word for the opening to which a flow belongs: "inlet" or "outlet".
fn kind(flow: &FlowAverages) -> &'static str {
    if flow.is_inlet { "inlet" } else { "outlet" }
}

/// Flows through all inlets and outlets, each with the results of its run.
fn flows(outcomes: &[Outcome]) -> impl Iterator<Item = (&Outcome, &FlowAverages)> {
    outcomes.iter().flat_map(|outcome| outcome.flows.iter().map(move |flow| (outcome, flow)))
}

/// [m/s] mean speed of the particles that have passed the inlet or outlet; `None` if none has passed.
fn mean_speed(flow: &FlowAverages) -> Option<f64> {
    (flow.totals.count > 0).then(|| flow.totals.speed / flow.totals.count as f64)
}

/// Table of the flows through inlets and outlets. The list is empty if there are no inlets or outlets.
pub(super) fn blocks(outcomes: &[Outcome]) -> Vec<Block> {
    if flows(outcomes).next().is_none() {
        return Vec::new();
    }
    let row = |(outcome, flow): (&Outcome, &FlowAverages)| {
        let cells = vec![
            outcome.experiment.name.clone(),
            format!("{} ({})", flow.name, kind(flow)),
            with_error(flow.mass_rate),
            with_error(flow.rate),
            flow.totals.count.to_string(),
            significant(flow.totals.mass, 4),
            significant(mean_speed(flow), 4),
        ];
        (false, cells)
    };
    let head = "variant | opening | mass rate [kg/s] | particles per second [1/s] | particles in the whole run | their mass [kg] | their mean speed [m/s]";
    let mut blocks = vec![
        Block::heading("Inlets and outlets"),
        Block::table(head, flows(outcomes).map(row)),
        Block::note("Rates are averages over the averaging period. flow.csv has the sums over time."),
    ];
    blocks.extend(flows(outcomes).filter_map(blocked).map(Block::note));
    blocks
}

/// Sentence about an inlet at which particles waited for free space; `None` if no particle waited.
fn blocked((outcome, flow): (&Outcome, &FlowAverages)) -> Option<String> {
    let [now, most] = flow.waiting;
    (most > 0).then(|| {
        format!(
            "\"{}\": the inlet \"{}\" was blocked: up to {most} particles were due and found no place, and {now} still wait at the end. A larger region, a smaller rate or a faster velocity lets them in.",
            outcome.experiment.name, flow.name
        )
    })
}

/// Flows through the inlets and outlets of an experiment for `summary.json`, in SI units.
pub(super) fn json(outcome: &Outcome) -> Value {
    let flow = |flow: &FlowAverages| {
        json!({
            "name": flow.name,
            "kind": kind(flow),
            "mass_rate": measured(flow.mass_rate),
            "rate": measured(flow.rate),
            "totals": flow.totals,
            "mean_speed": mean_speed(flow),
            "waiting_at_the_end": flow.waiting[0],
            "waiting_at_most": flow.waiting[1],
        })
    };
    outcome.flows.iter().map(flow).collect()
}

/// Contents of `flow.csv`: for each inlet and outlet, sums over the particles that have passed since the start, at each
/// sample (instant of measurement). Mass rate and mean speed are averages over the time since the previous row. `None`
/// if there are no inlets or outlets.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub(super) fn csv(outcomes: &[Outcome]) -> Result<Option<Vec<u8>>, OutputError> {
    if flows(outcomes).next().is_none() {
        return Ok(None);
    }
    let mut table = CsvTable::new();
    table.head("variant,opening,kind,t_s,particles,mass_kg,mass_rate_kg_s,mean_speed_m_s")?;
    for (outcome, flow) in flows(outcomes) {
        let mut before = None;
        for sample in &flow.over_time {
            let since = before.map(|before: FlowSample| {
                let (now, then) = (&sample.totals, &before.totals);
                let passed = now.count - then.count;
                let rate = (now.mass - then.mass) / (sample.time - before.time);
                (rate, (passed > 0).then(|| (now.speed - then.speed) / passed as f64))
            });
            let names = [outcome.experiment.name.clone(), flow.name.clone(), kind(flow).to_owned()];
            let sums = [number(sample.time), sample.totals.count.to_string(), number(sample.totals.mass)];
            let rates = [number(since.map(|since| since.0)), number(since.and_then(|since| since.1))];
            table.row(names.into_iter().chain(sums).chain(rates))?;
            before = Some(*sample);
        }
    }
    table.bytes().map(Some)
}
