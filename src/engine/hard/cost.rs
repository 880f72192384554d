//! What one calendar for all costs, in the measure of the islands: the two are weighed by counts.

use crate::engine::Window;
use crate::engine::islands::SpeedSummary;
use crate::engine::population::PopulationSummary;
use crate::scene::Scene;
use std::f64::consts::{PI, SQRT_2};

/// [ns] foretelling one touch and putting it in the calendar. Measured once, on one quiet core, among 1000 spheres of two sizes:
/// 55 ns with the builds of the list, which are counted apart here.
const TOUCH: f64 = 40.0;

/// [ns] building the neighbour list, per particle: cells, order and walls. As the islands' search, which does the same.
const BUILD: f64 = 90.0;

/// [ns] looking at one pair while the list is built: as in the islands' search, but in double precision.
const PAIR: f64 = 3.0;

/// [-] volume fraction from which on the calendar that lasts costs less than islands. Of 10⁴ elastic spheres in a periodic box it
/// made, beside islands on one thread, 0.8 times as many collisions a second at 0.05, 1.1 at 0.1, 1.7 at 0.2, 2.3 at 0.3; islands
/// gain by more threads, and the calendar does not.
const DENSE: f64 = 0.2;

/// [ns/s] what the islands of this window must cost less than, per particle and simulated time; `None`: they are not tried.
///
/// Without drag the calendar lasts from window to window and is taken where it is dense. Where drag kicks every window it foretells
/// everything in each. Of mixtures the cost is weighed: in those the islands of the largest spheres run together first. Spheres of
/// one size do not need it: in the cases of this project islands cost from seven tenths (dense gas, volume fraction 0.3) to
/// a hundredth of one calendar that is made anew.
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

/// Whether a calendar outlasts its window: drag kicks everyone at the end of each.
pub fn lasts(scene: &Scene) -> bool {
    scene.fluid.as_ref().is_none_or(|fluid| fluid.drag.is_none())
}

/// [ns/s] what one calendar for all costs per particle and simulated time.
///
/// Every touch on the list is foretold at the start of a window, and those of both partners after a collision; the list is
/// built whenever the fastest particle has gone half its skin. Of all skins the cheapest counts.
fn one_calendar(population: &PopulationSummary, speeds: &SpeedSummary, window: Window) -> f64 {
    let &PopulationSummary { density, mean_radius: [mean, mean_square], largest, ref census, .. } = population;
    // [m²] mean square of the distance at which two touch
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
