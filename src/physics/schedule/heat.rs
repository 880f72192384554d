//! Lengths of windows in gases that a thermostat heats. A window is the time between two kicks of drag or heat.

use super::{SPLITTING, motion};
use crate::experiment::Experiment;
use crate::kinetic_theory::contact_value;
use std::f64::consts::PI;

/// [s] longest window of a scene with a thermostat, which heats the particles between two windows; infinite without a
/// thermostat. The heat of a window (time between two exchanges with the gas) of length h comes up to h/2 too early or
/// too late. With the collision rate r, this splitting of heat and collisions causes a relative error of at most (r
/// h)²/24 (trapezoidal rule). The window is so short that this error is at most [`SPLITTING`].
pub fn longest_for_thermostat(experiment: &Experiment) -> f64 {
    heated_rate(experiment).map_or(f64::INFINITY, |rate| (24.0 * SPLITTING).sqrt() / rate)
}

/// [1/s] upper limit of the collision rate of a particle in a scene with a thermostat; `None` without a thermostat. The
/// granular temperature is at most the larger of two values: that of the start, and that at which the least inelastic
/// impacts balance the heat. It is also at most the temperature that heat without losses gives within the run. Inlets
/// count with the number of particles that they are [expected](Experiment::expected_counts) to bring.
pub(super) fn heated_rate(experiment: &Experiment) -> Option<f64> {
    let scene = &experiment.scene;
    let thermostat = scene.thermostat?;
    let (room, diameter) = (scene.room(), scene.largest_diameter());
    let counts = experiment.expected_counts();
    let kinds = || scene.species.iter().zip(&counts);
    let fraction = kinds().map(|(species, count)| count * species.volume()).sum::<f64>() / room;
    let squares = kinds().map(|(species, count)| count * species.diameter.powi(2)).sum::<f64>() / room;
    let contact_value = contact_value(diameter, diameter, fraction, PI / 6.0 * squares);
    // Chapman & Cowling 1970, 5.21, as in `DragScales::at`, over the root of T
    let over_root = 4.0 * counts.iter().sum::<f64>() / room * diameter.powi(2) * PI.sqrt() * contact_value;
    let at_start = experiment.start.iter().map(|population| motion(population).1.powi(2)).fold(0.0, f64::max);
    let surfaces = scene.surfaces(experiment.most_that_touch(experiment.count()));
    let losses = surfaces.into_iter().map(|surface| 1.0 - surface.restitution.powi(2));
    let least = losses.fold(1.0, f64::min);
    // on average, a collision takes the share (1 - e²)/3 of T from each of its two particles, see `predict::transient`
    let steady = thermostat.steady_temperature(over_root * least / 3.0);
    let unhindered = thermostat.temperature_after(at_start, experiment.run.duration);
    Some(over_root * at_start.max(steady.min(unhindered)).sqrt())
}
