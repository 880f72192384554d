//! Estimate of the cost (computing time) of moving all particles by one event queue. The engine compares this estimate
//! with the cost of islands, groups of particles that may meet and that are computed separately. A window is the time
//! between two exchanges with the gas.

use crate::engine::Window;
use crate::engine::islands::SpeedSummary;
use crate::engine::population::PopulationSummary;
use crate::scene::Scene;
use std::f64::consts::{PI, SQRT_2};

/// [ns] cost of predicting one touch and inserting it into the event queue. A measurement on one quiet core with 1000
/// spheres of two sizes gave 55 ns, including the building of the neighbour list, whose cost is counted separately.
const TOUCH: f64 = 40.0;

/// [ns] cost per particle of building the neighbour list: sorting into cells, and looking for walls. The search for
/// touching particles, by which islands (groups of particles that may meet) are found, also has this cost.
const BUILD: f64 = 90.0;

/// [ns] cost of comparing the positions of one pair of particles, in double precision, while the neighbour list is
/// built.
const PAIR: f64 = 3.0;

/// [-] volume fraction above which one event queue of all particles, kept from window to window, costs less than
/// islands, groups of particles that are computed separately. With 10⁴ elastic spheres in a periodic box on one thread,
/// the queue did 0.8 times as many collisions per second as islands at a volume fraction of 0.05. The ratios were 1.1
/// at 0.1, 1.7 at 0.2, and 2.3 at 0.3. Islands become faster with more threads, the queue does not.
const DENSE: f64 = 0.2;

/// Largest cost [ns/s], per particle and simulated time, at which islands (groups of particles that may meet) are used
/// in this window, the time between two exchanges with the gas. With `None` the event queue of all particles is used
/// without trying islands.
///
/// Without drag the event queue remains valid from window to window, so the queue is used for dense systems. Drag
/// changes velocities in every window, so all events would have to be predicted again. For particles of several sizes,
/// the costs of islands and of the queue are compared. The reason is that islands of the largest spheres are the first
/// to unite into large islands, which are costly. For spheres of one size the limit is infinite. In the cases of this
/// project, islands cost 1 % to 70 % as much as a queue that is rebuilt in every window (70 %: dense gas, volume
/// fraction 0.3).
pub fn fallback_cost(
    population: &PopulationSummary,
    speeds: &SpeedSummary,
    scene: &Scene,
    window: Window,
) -> Option<f64> {
    if lasts(scene) && population.crowded > DENSE {
        return None;
    }
    Some(if population.mixed { one_calendar(population, speeds, window) } else { f64::INFINITY })
}

/// True if the predicted events of the event queue of all particles stay valid from one window to the next. They do not
/// stay valid if velocities also change between windows, for instance by drag ([`Scene::is_kicked`]).
pub fn lasts(scene: &Scene) -> bool {
    !scene.is_kicked()
}

/// Lowest cost [ns/s], per particle and simulated time, of moving all particles by one event queue that is predicted
/// anew in every window.
///
/// At the start of a window the touches of all listed pairs are predicted. After a collision, all touches of its two
/// partners are predicted again. Pairs are listed if their gap is smaller than a length called skin. The list is
/// rebuilt whenever the fastest particle has moved half the skin. The function tries many skins and returns the lowest
/// cost.
fn one_calendar(population: &PopulationSummary, speeds: &SpeedSummary, window: Window) -> f64 {
    let &PopulationSummary { density, mean_radius: [mean, mean_square], largest, ref census, .. } = population;
    // [m²] mean square of the distance between centres at which two particles touch
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
