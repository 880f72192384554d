//! Parts of a report about the balance of energy. A variant is one of the experiments of a case.

use crate::outcome::Outcome;
use crate::output::document::{Block, Table, TextRow};
use crate::output::numbers::{Prefix, percent, significant};
use serde_json::{Value, json};

/// [-] largest accepted magnitude of the unexplained energy, divided by the sum of all energies in the balance. A
/// larger one is highlighted. The error of the time integrator at 20 steps per contact is much smaller.
const SUSPECT_RESIDUAL: f64 = 1e-3;

/// Notes on the energy that the restitution would have removed from collisions in quick succession. A collision that
/// follows another one of the same particle within the contact time is elastic and therefore keeps this energy.
fn notes_on_contact_time(outcomes: &[Outcome], prefix: &Prefix) -> Vec<Block> {
    let note = |o: &Outcome| {
        let kept = o.record.ledger.contact_time_kept;
        let all = o.record.ledger.through(o.energy_at_start);
        Block::Note(format!(
            "“{}”: restitution would have taken another {} {}J ({}) from collisions that came within the contact \
             time of another and were elastic for it.",
            o.experiment.name,
            significant(kept * prefix.factor, 4),
            prefix.symbol,
            percent(kept, all)
        ))
    };
    outcomes.iter().filter(|o| o.record.ledger.contact_time_kept > 0.0).map(note).collect()
}

/// Parts of the page about the energy balance of each variant (experiment of a case).
pub(super) fn blocks(outcomes: &[Outcome]) -> Vec<Block> {
    let largest = outcomes
        .iter()
        .flat_map(|o| [o.energy_at_start, o.energy_at_end, o.record.ledger.drag_work, o.record.ledger.gravity_work])
        .filter(|energy| energy.is_finite())
        .fold(0.0, |a: f64, b| a.max(b.abs()));
    let prefix = Prefix::of(largest);
    let joule = |energy: f64| significant(energy * prefix.factor, 4);
    let through = |o: &Outcome| o.record.ledger.through(o.energy_at_start);
    // each variant has a column, with the terms of its balance one below the other
    let row = |name: &str, cell: &dyn Fn(&Outcome) -> String| -> TextRow {
        (false, std::iter::once(name.into()).chain(outcomes.iter().map(cell)).collect())
    };
    let plain = |name: &str, of: fn(&Outcome) -> f64| row(name, &|o| joule(of(o)));
    let work = |name: &str, of: fn(&Outcome) -> f64| {
        row(name, &|o| format!("{} ({})", joule(of(o)), percent(of(o), through(o))))
    };
    // a loss that is only a rounding error of impulses is shown as 0, because none of its digits has a meaning
    let loss = |name: &str, of: fn(&Outcome) -> f64| {
        row(name, &|o| {
            let rounding = (of(o) / through(o)).abs() < 1e-12;
            if rounding { "0".into() } else { format!("{} ({})", joule(-of(o)), percent(-of(o), through(o))) }
        })
    };
    let suspect = outcomes.iter().filter_map(relative_residual).any(|residual| residual.abs() > SUSPECT_RESIDUAL);
    let mut rows = vec![
        plain("at the start", |o| o.energy_at_start),
        work("drag", |o| o.record.ledger.drag_work),
        work("gravity", |o| o.record.ledger.gravity_work),
    ];
    let any = |of: fn(&Outcome) -> bool| outcomes.iter().any(of);
    rows.extend(any(|o| o.record.ledger.wall_work != 0.0).then(|| work("moving walls", |o| o.record.ledger.wall_work)));
    rows.extend(
        any(|o| o.experiment.scene.domain.shear.is_some()).then(|| work("shear", |o| o.record.ledger.shear_work)),
    );
    let heated = any(|o| o.experiment.scene.is_heated());
    rows.extend(heated.then(|| work("thermostat and thermal walls", |o| o.record.ledger.thermostat_work)));
    let flows = any(|o| o.experiment.scene.has_openings());
    rows.extend(flows.then(|| work("inflow less outflow", |o| o.record.ledger.flow_energy)));
    rows.extend([
        loss("restitution between particles", |o| o.record.ledger.pair_restitution_loss),
        loss("friction between particles", |o| o.record.ledger.pair_friction_loss),
        loss("restitution at walls", |o| o.record.ledger.wall_restitution_loss),
        loss("friction at walls", |o| o.record.ledger.wall_friction_loss),
    ]);
    if any(|o| o.experiment.scene.rotation.is_some()) {
        type Part = (&'static str, fn(&Outcome) -> f64);
        let parts: [Part; 6] = [
            ("… of this friction: sliding", |o| o.record.ledger.sliding_loss()),
            ("… tangential restitution (dashpot)", |o| o.record.ledger.friction.tangential_restitution),
            ("… springs at separation", |o| o.record.ledger.friction.separation),
            ("… rescaled springs", |o| o.record.ledger.friction.rescaling),
            ("… rolling resistance", |o| o.record.ledger.friction.rolling),
            ("… twisting resistance", |o| o.record.ledger.friction.twisting),
        ];
        let of_scene = parts.iter().filter(|(_, of)| outcomes.iter().any(|o| of(o) != 0.0));
        rows.extend(of_scene.map(|(name, of)| loss(name, *of)));
    }
    rows.extend([
        plain("at the end", |o| o.energy_at_end),
        (suspect, work("unexplained", |o| o.record.ledger.residual(o.energy_at_start, o.energy_at_end)).1),
    ]);
    let head = std::iter::once(format!("energy [{}J]", prefix.symbol));
    let head = head.chain(outcomes.iter().map(|o| o.experiment.name.clone())).collect();
    let mut blocks = vec![Block::Table(Table { head, rows, remarks: false })];
    blocks.extend(notes_on_contact_time(outcomes, &prefix));
    blocks.push(Block::note(
        "Kinetic and elastic energy; in brackets the share of what went through the ledger (start + |drag| + |gravity| + |moving walls| + |shear| + |thermostat| + |inflow less outflow|). \
         Unexplained: rounding for hard spheres, also the integrator’s own gain or loss for soft ones; marked above 0.1 %.",
    ));
    blocks
}

/// [-] unexplained energy, divided by the sum of the initial energy and the magnitudes of the other terms: work of
/// drag, gravity, moving walls, shear and thermostat, and inflow less outflow. `None` if this sum is 0.
fn relative_residual(outcome: &Outcome) -> Option<f64> {
    let ledger = &outcome.record.ledger;
    let through = ledger.through(outcome.energy_at_start);
    let residual = ledger.residual(outcome.energy_at_start, outcome.energy_at_end);
    (through > 0.0).then(|| residual / through)
}

/// Energies of an experiment for `summary.json`: at the start, at the end, and the terms of the energy balance. Terms
/// of features that the scene lacks, such as shear, are left out.
pub(super) fn json(outcome: &Outcome) -> Value {
    let ledger = &outcome.record.ledger;
    let mut energies = json!({ "at_start": outcome.energy_at_start, "at_end": outcome.energy_at_end });
    if let (Value::Object(energies), Value::Object(ledger)) = (&mut energies, json!(**ledger)) {
        energies.extend(ledger);
    }
    if let Value::Object(energies) = &mut energies
        && outcome.experiment.scene.rotation.is_none()
    {
        energies.remove("friction");
    } else {
        energies["friction"]["sliding"] = ledger.sliding_loss().into();
    }
    if let Value::Object(energies) = &mut energies
        && outcome.experiment.scene.domain.shear.is_none()
    {
        energies.retain(|key, _| !key.starts_with("shear_"));
    }
    if let Value::Object(energies) = &mut energies
        && !outcome.experiment.scene.is_heated()
    {
        energies.retain(|key, _| !key.starts_with("thermostat_"));
    }
    if let Value::Object(energies) = &mut energies
        && !outcome.experiment.scene.has_openings()
    {
        energies.retain(|key, _| !key.starts_with("flow_"));
    }
    energies["dissipated"] = ledger.dissipated().into();
    energies["residual"] = ledger.residual(outcome.energy_at_start, outcome.energy_at_end).into();
    energies["residual_relative"] = relative_residual(outcome).into();
    energies
}
