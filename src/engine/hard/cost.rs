//! Estimated cost of one event queue for all particles, in the units of the islands, so that the two can be compared.

use crate::engine::Window;
use crate::engine::islands::SpeedSummary;
use crate::engine::population::PopulationSummary;
use crate::scene::Scene;
use std::f64::consts::{PI, SQRT_2};

/// [ns] predicting one touch and inserting it into the queue. Measured once, on one quiet core, with 1000 spheres of
/// two sizes: 55 ns including the builds of the neighbour list, which are counted apart here.
const TOUCH: f64 = 40.0;

/// [ns] building the neighbour list, per particle: cells, order and walls. Equal to that of the islands' search, which
/// does equal work.
const BUILD: f64 = 90.0;

/// [ns] checking one pair while the list is built: like the islands' search, but in double precision.
const PAIR: f64 = 3.0;

/// Volume fraction from which on the persistent event queue costs less than islands. Measured with 10⁴ elastic spheres
/// in a periodic box, in collisions per second relative to islands on one thread: 0.8 times as many at 0.05, 1.1 at
/// 0.1, 1.7 at 0.2, 2.3 at 0.3. Islands gain by more threads, the queue does not.
const DENSE: f64 = 0.2;

/// Largest cost of islands in this window, per particle and simulated time [ns/s]; `None`: islands are not tried.
///
/// Without drag the event queue persists from window to window, and is taken for dense systems. Drag kicks in every
/// window, so that all events are predicted again in each. For mixtures the costs are compared, because the islands of
/// the largest spheres run together first. Spheres of one size do not need this. In the cases of this project islands
/// cost from seven tenths (dense gas, volume fraction 0.3) to a hundredth of an event queue that is rebuilt.
pub fn fallback_cost(
    population: &PopulationSummary,
    speeds: &SpeedSummary,
    scene: &Scene,
    window: Window,
) -> Option<f64> {
    if lasts(scene) && population.filled > DENSE {
        return None;
    }
    Some(if population.mixed { one_calendar(population, speeds, window) } else { f64::INFINITY })
}

/// True if an event queue outlasts its window. It does not with drag, which kicks all particles at the end of each
/// window.
pub fn lasts(scene: &Scene) -> bool {
    scene.fluid.as_ref().is_none_or(|fluid| fluid.drag.is_none())
}

/// Cost of one event queue for all, per particle and simulated time [ns/s].
///
/// Every touch on the neighbour list is predicted at the start of a window, and those of both partners after a
/// collision. The list is rebuilt whenever the fastest particle has moved half the skin. The cheapest of all skins
/// counts.
fn one_calendar(population: &PopulationSummary, speeds: &SpeedSummary, window: Window) -> f64 {
    let &PopulationSummary { density, mean_radius: [mean, mean_square], largest, ref census, .. } = population;
    // [m²] mean square of the distance at which two particles touch
    let reach_square = 2.0 * (mean_square + mean * mean);
    let rate = density * PI * reach_square * speeds.mean * SQRT_2;
    let largest = 2.0 * largest;
    let mut best = f64::INFINITY;
    let mut uses = 1.0;
    while uses < 1e3 {
        let between = uses * window.duration;
        let skin = 2.0 * speeds.largest * between;
        let listed = density * 2.0 / 3.0 * PI * ((reach_square.sqrt() + skin).powi(3) - 0.8 * reach_square.powf(1.5));
        let in_one_grid = || 13.5 * (density * (largest + skin).powi(3)).max(0.5);
        let looked_at = census.as_ref().map_or_else(in_one_grid, |census| census.looked_at(skin));
        let touches = TOUCH * listed * (1.0 / window.duration + 2.0 * rate);
        best = best.min(touches + (BUILD + PAIR * looked_at) / between);
        uses *= 1.25;
    }
    best
}
