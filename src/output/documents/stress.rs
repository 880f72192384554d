//! Parts of a report about stress, contacts per particle and volume fraction.

use super::run::{measured, table};
use crate::experiment::Model;
use crate::outcome::Outcome;
use crate::output::document::{Block, known};
use crate::output::numbers::{significant, with_error};
use crate::statistics::Estimate;
use serde_json::{Value, json};

/// Table of the stress with its kinetic and contact parts, and of the contacts per particle.
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
             spheres the impulse over time) and r from centre to centre; walls count in the contacts per particle only. All components and the volume fraction of each slice are in summary.json.",
        ),
    ];
    blocks.into_iter().chain(kinetic_only).collect()
}

/// Stress of a variant for `summary.json`, in SI units.
pub(super) fn json(outcome: &Outcome) -> Value {
    let stress = &outcome.stress;
    let all = |list: &[Option<Estimate>]| list.iter().map(|part| measured(*part)).collect::<Vec<_>>();
    json!({
        "components": ["xx", "yy", "zz", "xy", "xz", "yz"],
        "kinetic": all(&stress.kinetic),
        "contact": all(&stress.contact),
        "pressure": measured(stress.pressure),
        "compressibility": measured(stress.compressibility),
        "contacts_per_particle": measured(stress.coordination),
        "volume_fraction_of_slices": all(&stress.volume_fraction),
    })
}
