//! Parts of a report about a gas on which the particles act (two-way coupling). A variant is one of the experiments of
//! a case.

use super::run::{measured, table};
use crate::observe::GasFlow;
use crate::outcome::Outcome;
use crate::output::OutputError;
use crate::output::csv::{CsvTable, number};
use crate::output::document::Block;
use crate::output::numbers::{significant, with_error};
use serde_json::{Value, json};

/// Table of the gas flow with and without particles. The list is empty if the particles do not change the gas flow in
/// any experiment.
pub(super) fn blocks(outcomes: &[Outcome]) -> Vec<Block> {
    if outcomes.iter().all(|outcome| outcome.gas.is_none()) {
        return Vec::new();
    }
    let head = "variant | pressure drop [Pa/m] | of the gas alone [Pa/m] | flow rate over the cross-section [m/s] | friction velocity [m/s] | k in the middle over that of the gas alone | momentum of the gas that is unexplained";
    let cells = |outcome: &Outcome| {
        let cells = match &outcome.gas {
            None => {
                vec!["frozen gas".into(), String::new(), String::new(), String::new(), String::new(), String::new()]
            }
            Some(gas) => vec![
                with_error(gas.pressure_gradient),
                significant(Some(gas.pressure_gradient_alone), 4),
                with_error(gas.bulk_velocity),
                with_error(gas.friction_velocity),
                significant(remaining_turbulence(gas), 3),
                significant(Some(gas.balance.unexplained_share()), 2),
            ],
        };
        (false, cells)
    };
    let mut blocks = vec![
        Block::heading("Gas that feels the particles"),
        table(head, outcomes, cells),
        Block::note(
            "Two-way coupling in one dimension: the mean force on the particles of each slice is taken from the gas. The pressure drop is without its hydrostatic part; it carries friction at the \
             walls and the force on the particles. The last column is the sum of gains and losses against the change, over the largest of them. gas.csv has velocity, k and ε across the flow.",
        ),
    ];
    blocks.extend(outcomes.iter().filter_map(beyond_the_model).map(Block::note));
    blocks
}

/// Sentence about an experiment whose mean gas flow is outside the range of the turbulence model. `None` if the flow is
/// within this range, or if the particles do not change the gas flow.
fn beyond_the_model(outcome: &Outcome) -> Option<String> {
    let (gas, fluid) = (outcome.gas.as_ref()?, outcome.experiment.scene.fluid.as_ref()?);
    let flow = fluid.profile.channel_flow()?;
    let (bulk, friction) = (gas.bulk_velocity?.value, gas.friction_velocity?.value);
    let (reynolds, lowest) = (bulk * flow.height / flow.kinematic_viscosity, flow.model.lowest_reynolds());
    (reynolds < lowest || friction < 0.0).then(|| {
        format!(
            "\"{}\": the gas has left the range of its turbulence model ({}). Its Reynolds number is {} (the model needs at least {}) and its friction velocity {} m/s. A larger pressure gradient, or a constant flow rate, keeps it in the range.",
            outcome.experiment.name,
            flow.model,
            significant(Some(reynolds), 3),
            significant(Some(lowest), 3),
            significant(Some(friction), 3),
        )
    })
}

/// [-] turbulent kinetic energy in the middle of the flow with particles, divided by that of the flow without
/// particles. `None` if one of the flows has no grid points.
fn remaining_turbulence(gas: &GasFlow) -> Option<f64> {
    Some(gas.mean.last()?.k / gas.alone.last()?.k)
}

/// Gas flow of an experiment for `summary.json`, in SI units; null if the particles do not change the flow.
pub(super) fn json(outcome: &Outcome) -> Value {
    let Some(gas) = &outcome.gas else { return Value::Null };
    json!({
        "pressure_gradient": measured(gas.pressure_gradient),
        "pressure_gradient_alone": gas.pressure_gradient_alone,
        "bulk_velocity": measured(gas.bulk_velocity),
        "friction_velocity": measured(gas.friction_velocity),
        "turbulent_kinetic_energy_in_the_middle_over_that_alone": remaining_turbulence(gas),
        "momentum": gas.balance,
        "unexplained_momentum_over_the_largest_part": gas.balance.unexplained_share(),
    })
}

/// Contents of `gas.csv`: the gas without particles, and the time average of the gas with particles, at the grid points
/// from the wall to the middle. `None` if the particles do not change the gas flow in any experiment.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub(super) fn csv(outcomes: &[Outcome]) -> Result<Option<Vec<u8>>, OutputError> {
    if outcomes.iter().all(|outcome| outcome.gas.is_none()) {
        return Ok(None);
    }
    let mut table = CsvTable::new();
    let head = "variant,y_m,U_alone_m_s,U_m_s,k_alone_m2_s2,k_m2_s2,epsilon_alone_m2_s3,epsilon_m2_s3,nu_t_alone_m2_s,nu_t_m2_s";
    table.head(head)?;
    for (outcome, gas) in outcomes.iter().filter_map(|outcome| Some((outcome, outcome.gas.as_ref()?))) {
        for (alone, mean) in gas.alone.iter().zip(&gas.mean) {
            let pairs = [[alone.u, mean.u], [alone.k, mean.k], [alone.epsilon, mean.epsilon], [alone.nu_t, mean.nu_t]];
            let numbers = std::iter::once(mean.y).chain(pairs.into_iter().flatten()).map(|value| number(Some(value)));
            table.row(std::iter::once(outcome.experiment.name.clone()).chain(numbers))?;
        }
    }
    table.bytes().map(Some)
}
