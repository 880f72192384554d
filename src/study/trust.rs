//! Sentences on the reliability of the results of a run, and on what limits it.

use crate::engine::dsmc::cells_and_path;
use crate::experiment::Model;
use crate::outcome::Outcome;
use crate::output::numbers;
use crate::predict::gas::{self, Component};
use crate::statistics::{Estimate, UU, VV, WW};
use crate::study::judge::not_steady;
use std::f64::consts::PI;

/// [-] smallest difference between the given restitution and the mean restitution of the simulated impacts that a note
/// reports. Restitution is given to two digits, and this difference is half of the last digit.
pub(super) const MISS: f64 = 0.005;

/// Sentence that sums up a run: particles, simulated time, wall time and impacts, or the failure.
pub fn verdict(outcome: &Outcome) -> String {
    let how = match &outcome.failure {
        Some(why) => format!("stopped after {} s: {why}", numbers::significant(outcome.simulated_seconds, 4)),
        None => format!(
            "{} particles for {} s in {} s of wall time; {} impacts between particles, {} on walls",
            outcome.particles,
            numbers::significant(outcome.simulated_seconds, 4),
            numbers::significant(outcome.timing.wall_seconds, 3),
            numbers::count(outcome.record.pairs.count),
            numbers::count(outcome.record.walls.count)
        ),
    };
    format!("\"{}\": {how}.", outcome.experiment.name)
}

/// [m²/s²] granular temperature T = <|v - U|²>/3 of all particles, whose velocities are v. It is computed from the
/// second moments about the mean velocity U of each slice of the box across y. `None` if nothing was measured.
pub fn granular_temperature(outcome: &Outcome) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0.0);
    for row in &outcome.profiles.slices {
        if let [Some(uu), Some(vv), Some(ww)] = [UU, VV, WW].map(|column| row.of(column)) {
            sum += (uu.value + vv.value + ww.value) / 3.0 * row.samples as f64;
            count += row.samples as f64;
        }
    }
    (count > 0.0).then(|| sum / count)
}

/// [-] softness: relative amount by which the effective diameter of soft spheres is smaller than their diameter. With
/// several species, the largest value among all pairs of species is returned. Hard spheres of the effective diameter
/// behave nearly like the soft ones (Barker and Henderson). A species whose temperature was not measured has that of
/// all particles. `None` if spheres collided in instants, as hard spheres do, or if no temperature or no impact
/// between particles was measured. `None` also for few bodies, which do not form a gas.
pub fn softness(outcome: &Outcome) -> Option<f64> {
    if outcome.record.pairs.count == 0 || !outcome.paths.points.is_empty() {
        return None;
    }
    let law = outcome.experiment.law().filter(|_| outcome.record.pairs.instants.count == 0)?;
    let (scene, of_all) = (&outcome.experiment.scene, granular_temperature(outcome)?);
    let temperature = |name: &str| {
        let measured = outcome.kinds.species.iter().find(|averages| averages.name == name);
        measured.and_then(|averages| averages.temperature).map_or(of_all, |temperature| temperature.value)
    };
    let kinds = scene.species.iter().zip(outcome.experiment.expected_counts());
    let temperatures: Vec<Option<f64>> =
        kinds.map(|(species, count)| (count > 0.0).then(|| temperature(&species.name))).collect();
    gas::softest(&law, scene, &temperatures).filter(|shrink| shrink.is_finite())
}

/// Sentences on effects that limit the reliability of each outcome, such as that a run is not steady.
pub fn notes(outcomes: &[Outcome]) -> Vec<String> {
    let mut notes = Vec::new();
    for outcome in outcomes {
        let name = &outcome.experiment.name;
        let mut note = |text: String| notes.push(format!("\"{name}\": {text}"));
        if let Some(predicate) = not_steady(&outcome.steadiness) {
            note(format!("this run {predicate}."));
        }
        if let Some(replicas) = outcome.averaged.replicas {
            note(format!(
                "profiles, temperature and impact rates are averages over {} replicas{}; all else is that of the first.",
                replicas.count,
                replicas.scatter_over_errors.map_or(String::new(), |ratio| format!(
                    ", between which averages scatter {} times as much as the errors within runs say",
                    numbers::significant(ratio, 2)
                ))
            ));
        }
        restitution(outcome, &mut note);
        cells_in_shear(outcome, &mut note);
        let balance = &outcome.balance;
        if let Some(unclosed) = balance.residual.and_then(Estimate::in_errors)
            && unclosed.abs() > 3.0
        {
            note(format!(
                "the streamwise momentum balance does not close: {} standard errors are left.",
                numbers::significant(unclosed, 2)
            ));
        }
        if let Some(shrink) = softness(outcome)
            && shrink > 0.005
        {
            note(format!(
                "at this stiffness spheres act on one another as if smaller by {} %: hard spheres of the full diameter crowd one another a little more.",
                numbers::significant(100.0 * shrink, 2)
            ));
        }
    }
    if outcomes.len() > 1 && outcomes.iter().any(|o| o.initial_state_hash != outcomes[0].initial_state_hash) {
        notes.push("The variants do not start from the same state: they ask for different particles.".into());
    }
    notes
}

/// End of a sentence on simulated impacts whose restitution differs from the given one, if spheres touch several
/// others at once.
const SEVERAL: &str = ", since spheres touch several others at once and share their energy with them";

/// True if the particles had, on average, more than one contact each at some instant of measurement.
pub(super) fn meets_several(outcome: &Outcome) -> bool {
    outcome.series.rows.iter().any(|row| row.coordination > 1.0)
}

/// Adds a note if the mean restitution of the impacts of an outcome differs from the given restitution by more than
/// 0.005.
fn restitution(outcome: &Outcome, note: &mut impl FnMut(String)) {
    let scene = &outcome.experiment.scene;
    if let Some(asked) = scene.restitution_of_pairs()
        && let Some(pairs) = outcome.record.pairs.summary().mean_restitution
        && (pairs - asked).abs() > MISS
    {
        let several = if meets_several(outcome) { SEVERAL } else { "" };
        note(format!(
            "pairs rebound with a restitution of {pairs:.4} on average where {asked} was asked for{several}."
        ));
    }
    // a thermal wall gives a new speed, whatever the restitution is
    if let Some(asked) = scene.restitution_at_walls().filter(|_| !scene.has_thermal_walls())
        && let Some(walls) = outcome.record.walls.summary().mean_restitution
        && (walls - asked).abs() > MISS
    {
        note(format!("wall impacts rebound with a restitution of {walls:.4} on average where {asked} was asked for."));
    }
}

/// Adds a note if the cells in which colliding pairs are drawn at random (model `dsmc`) are too thick across a sheared
/// box. The thickness must not exceed √T/γ (granular temperature T, shear rate γ) or the mean free path.
fn cells_in_shear(outcome: &Outcome, note: &mut impl FnMut(String)) {
    let experiment = &outcome.experiment;
    let scene = &experiment.scene;
    let (Some(shear), Some(temperature), Model::Dsmc) = (&scene.domain.shear, outcome.temperature, experiment.model())
    else {
        return;
    };
    let kinds = scene.species.iter().zip(experiment.counts());
    let components = kinds.flat_map(|(species, count)| Component::of(species, count, temperature.value));
    let groups: Vec<(usize, f64)> = components.map(|one| (one.count, 0.5 * one.diameter)).collect();
    let (edges, path) = cells_and_path(scene, &experiment.dsmc, &groups);
    let flow = temperature.value.sqrt() / shear.rate.abs();
    let length = |length: f64| numbers::quantity(length, "m", 3);
    let cells = format!("its cells are {} thick across the shear", length(edges.y));
    let help = "thinner cells: dsmc.cells";
    if edges.y > flow {
        let why = "differences of the mean flow within a cell count as agitation";
        note(format!("{cells}, and √T/γ is {}: {why} ({help}).", length(flow)));
    } else if edges.y > path {
        // at the thickness L of a cell the viscosity is too large by the factor 1 + 16 L²/(45 π λ²), with the mean free
        // path λ: Alexander, Garcia and Alder 1998, Phys. Fluids 10, 1540
        let excess = 16.0 / (45.0 * PI) * (edges.y / path).powi(2);
        let high = format!("the viscosity is too high by about {}", numbers::percent(excess, 1.0));
        note(format!("{cells}, and the mean free path is {}: {high} ({help}).", length(path)));
    }
}
