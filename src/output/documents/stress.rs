//! Parts of a report about stress, contacts per particle and volume fraction. A variant is one of the experiments of a
//! case.

use super::run::{measured, table};
use crate::experiment::Model;
use crate::outcome::Outcome;
use crate::output::OutputError;
use crate::output::csv::{CsvTable, number};
use crate::output::document::{Block, known};
use crate::output::numbers::{significant, with_error};
use crate::statistics::Estimate;
use serde_json::{Value, json};

/// Names of the components of a stress, in the order of [`Stress`](crate::observe::Stress).
const COMPONENTS: [&str; 6] = ["xx", "yy", "zz", "xy", "xz", "yz"];

/// Table of the stress, and of the contacts per particle. The kinetic part of the stress comes from the motion of the
/// particles, the contact part from the forces between them.
pub(super) fn blocks(outcomes: &[Outcome]) -> Vec<Block> {
    let head = "variant | kinetic xx, yy, zz [Pa] | contact xx, yy, zz [Pa] | pressure [Pa] | pressure over its kinetic part | contacts per particle | volume fraction of a slice, least to most";
    let cells = |outcome: &Outcome| {
        let stress = &outcome.stress;
        let three = |six: &[Option<Estimate>; 6]| {
            six[..3].iter().map(|part| significant(part.map(|part| part.value), 3)).collect::<Vec<_>>().join(", ")
        };
        let filled = stress.volume_fraction.iter().flatten().map(|slice| slice.value);
        let (least, most) = filled.fold((f64::INFINITY, 0.0f64), |(a, b), value| (a.min(value), b.max(value)));
        let cells = vec![
            three(&stress.kinetic),
            three(&stress.contact),
            with_error(stress.pressure),
            with_error(stress.compressibility),
            known(stress.coordination.is_some(), with_error(stress.coordination)),
            known(least <= most, format!("{} to {}", significant(least, 3), significant(most, 3))),
        ];
        (false, cells)
    };
    // pairs that collide by chance do not touch, so that no force acts between their centres
    let by_chance = outcomes.iter().filter(|outcome| outcome.experiment.model() == Model::Dsmc);
    let kinetic_only = by_chance.map(|outcome| {
        let name = &outcome.experiment.name;
        Block::Note(format!(
            "“{name}”: pairs collide by chance and do not touch; its pressure is the kinetic part only."
        ))
    });
    let blocks = [
        Block::heading("Stress"),
        table(head, outcomes, cells),
        Block::note(
            "Averages over the volume of the whole box. Kinetic: Σ m c c, with velocities about the mean of their slice. Contact: Σ r f, with the force f between two particles that touch (of hard \
             spheres the impulse over time) and r from centre to centre; walls count in the contacts per particle only. All components are in stress.csv, and the volume fraction of each slice is in summary.json.",
        ),
    ];
    blocks.into_iter().chain(kinetic_only).collect()
}

/// Stress, contacts per particle and volume fraction of an experiment for `summary.json`, in SI units.
pub(super) fn json(outcome: &Outcome) -> Value {
    let stress = &outcome.stress;
    let all = |list: &[Option<Estimate>]| list.iter().map(|part| measured(*part)).collect::<Vec<_>>();
    json!({
        "components": COMPONENTS,
        "kinetic": all(&stress.kinetic),
        "contact": all(&stress.contact),
        "pressure": measured(stress.pressure),
        "compressibility": measured(stress.compressibility),
        "contacts_per_particle": measured(stress.coordination),
        "volume_fraction_of_slices": all(&stress.volume_fraction),
    })
}

/// Contents of `stress.csv`: kinetic and contact part of each component of the stress [Pa], averaged over the volume
/// of the box and the averaging period, and the pressure. The kinetic part comes from the motion of the particles, the
/// contact part from the forces between them. Compression is positive. Columns with `_se` contain one standard error.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub(super) fn csv(outcomes: &[Outcome]) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    table.head("variant,component,kinetic_Pa,kinetic_se,contact_Pa,contact_se,total_Pa,total_se")?;
    for outcome in outcomes {
        let stress = &outcome.stress;
        let parts = stress.kinetic.iter().zip(&stress.contact).zip(&stress.total);
        let components = COMPONENTS.iter().zip(parts);
        let rows = components.map(|(name, ((kinetic, contact), total))| (*name, [*kinetic, *contact, *total]));
        for (name, parts) in rows.chain([("pressure", [None, None, stress.pressure])]) {
            let numbers = parts.iter().flat_map(|part| [part.map(|part| part.value), part.and_then(|part| part.error)]);
            let names = [outcome.experiment.name.clone(), name.to_owned()];
            table.row(names.into_iter().chain(numbers.map(number)))?;
        }
    }
    table.bytes()
}
