//! Choice of the next part of a window: its length, and whether islands pay.

use crate::domain::Domain;
use crate::engine::population::PopulationSummary;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, SQRT_2};
use std::sync::Arc;

/// Summary of the velocities of all particles in a few numbers.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub struct SpeedSummary {
    /// Frame of reference [m/s] of the speeds: the mean velocity along the walls.
    pub frame: Vector3<f64>,
    /// Root of the mean square speed [m/s].
    pub mean: f64,
    /// Largest speed [m/s].
    pub largest: f64,
}

/// Data for the choice between islands and the classical algorithm.
pub struct IslandCost {
    /// Summary of all particles.
    pub population: Arc<PopulationSummary>,
    /// Summary of their velocities.
    pub speeds: SpeedSummary,
    /// Cost of the classical algorithm per particle and simulated time [ns/s].
    pub fallback_cost: f64,
}

/// A part of a window.
pub struct WindowPiece<'a> {
    /// Time [s] from the beginning of the window, during which its frame has fallen.
    pub elapsed: f64,
    /// Length of the part [s].
    pub part: f64,
    /// Number of pairs that the search is expected to check.
    pub foreseen: u64,
    /// Summary of all particles.
    pub population: &'a PopulationSummary,
    /// Summary of their velocities.
    pub speeds: SpeedSummary,
    /// Number of members beyond which an island is too large for a part of this length.
    pub most: usize,
}

impl WindowPiece<'_> {
    /// Largest reach [m] of any flight about its middle.
    pub fn flight(&self) -> f64 {
        self.population.largest + 0.5 * self.part * self.speeds.largest * (1.0 + 1e-9)
    }
}

/// Data for the choice of a part, besides the particles.
pub struct PartLimits {
    /// Time [s] to the end of the window.
    pub left: f64,
    /// Cost of the classical algorithm per particle and simulated time [ns/s].
    pub fallback_cost: f64,
    /// Number of contacts that are taken into crowds and out again in every part.
    pub held: usize,
    /// Costs of islands.
    pub costs: PartCosts,
}

/// Costs of a part, in ns on one core, and the density limit for islands. They were measured once
/// (docs/design/islands.md). They only serve to choose, not to predict the run time.
pub struct PartCosts {
    /// [ns] flight, cells and ranges of cells, per particle.
    search: f64,
    /// [ns] check of one pair.
    pair: f64,
    /// [ns] making and solving an island, per hot particle.
    island: f64,
    /// [-] reach of a hot particle, in mean flights.
    reach: f64,
    /// [-] number of other hot particles in reach above which nearly all islands unite: islands in reach of one another
    /// unite, and the united island reaches further.
    crowded: f64,
}

/// Costs of islands that reach as far as their particles might fly. Case D: islands of 20 at parts of 0.5 ms, of 200 at
/// 0.7 ms.
pub const BOUNDED: PartCosts = PartCosts { search: 90.0, pair: 1.2, island: 1400.0, reach: 1.5, crowded: 0.25 };

/// Costs of islands that reach as far as their particles do fly. Scene S1: 1.1 µs per hot particle at parts of 0.375
/// ms, 1.2 at 0.5 ms, 1.6 at 0.75 ms.
pub const TRACED: PartCosts = PartCosts { search: 80.0, pair: 1.2, island: 1000.0, reach: 0.5, crowded: 0.15 };

/// The part of a window that costs least.
#[derive(Clone, Copy)]
pub struct Cheapest {
    /// Length of the part [s].
    pub part: f64,
    /// Expected number of pairs [-] that the search checks, per particle.
    pub pairs: f64,
}

/// Returns the part of the remaining window that costs least per simulated time, or `None` if islands do not pay.
///
/// A longer part spreads the search over more time, but checks more pairs and makes more islands.
pub fn cheapest_part(
    population: &PopulationSummary,
    domain: &Domain,
    speeds: &SpeedSummary,
    limits: &PartLimits,
) -> Option<Cheapest> {
    /// [ns] cost per contact of a crowd: copying its particles into the crowd and back, and their neighbour list.
    const HELD: f64 = 500.0;
    let PartLimits { left, fallback_cost, held, costs: weights } = limits;
    let (left, fallback_cost, held) = (*left, *fallback_cost, *held);
    let &PopulationSummary { density, largest, mean_radius: [mean, mean_square], ref census, .. } = population;
    let count = population.count as f64;
    let search = weights.search + HELD * held as f64 / count;
    let diameter = 2.0 * largest;
    // distances at which two particles touch, over the largest diameter: mean square of all pairs, and mean for a
    // largest particle; islands of the largest run together first
    let square = 0.5 * (mean_square + mean * mean) / (largest * largest);
    let of_largest = 0.5 * (1.0 + mean / largest);
    // rate at which a particle becomes hot: density times the cross-section times the mean relative speed; touches of
    // walls are left out
    let rate = density * PI * diameter * diameter * square * speeds.mean * SQRT_2;
    let periods = (0..3).filter(|axis| domain.periodic[*axis]).map(|axis| domain.size[axis]);
    let period = periods.fold(f64::INFINITY, f64::min);
    // two particles that approach each other from both sides must meet only the nearest image, which is at most half a
    // period away
    let room = (0.5 * period - diameter) / (2.0 * speeds.largest);
    if room <= 0.0 {
        return None;
    }
    let mut best: Option<(f64, Cheapest)> = None;
    let mut pieces = (left / room).ceil().max(1.0);
    for _ in 0..40 {
        let part = left / pieces;
        let edge = diameter + speeds.largest * part;
        let hot = rate * part;
        // few particles always fit into islands; many must be sparse
        let reach = diameter * of_largest + weights.reach * speeds.mean * part;
        let others = if count > 8.0 { density * hot * 4.0 / 3.0 * PI * reach.powi(3) } else { 0.0 };
        if others < weights.crowded {
            let in_one_grid = || 13.5 * density * edge.powi(3).max(0.5 / density);
            let pairs = census.as_ref().map_or_else(in_one_grid, |census| census.looked_at(speeds.largest * part));
            let islands = weights.island * hot / (1.0 - others / weights.crowded);
            let cost = (search + weights.pair * pairs + islands) / part;
            if cost < fallback_cost && best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, Cheapest { part, pairs }));
            }
        }
        pieces = (pieces * 1.3).ceil();
    }
    // if a collision costs less than the search for it, nearly all particles collide, and one event queue or time step
    // for all is cheaper
    best.map(|(_, cheapest)| cheapest)
}
