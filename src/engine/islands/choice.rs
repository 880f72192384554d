//! Which part of a window to take: how long it is, and whether islands pay.

use crate::domain::Domain;
use crate::engine::population::PopulationSummary;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, SQRT_2};

/// Velocities of all particles in a few numbers.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub struct SpeedSummary {
    /// [m/s] the frame that they are seen from: the mean velocity along the walls.
    pub frame: Vector3<f64>,
    /// [m/s] root of their mean square.
    pub mean: f64,
    /// [m/s] the largest.
    pub largest: f64,
}

/// What the choice between islands and the other way is made of.
pub struct IslandCost<'a> {
    /// All particles.
    pub population: &'a PopulationSummary,
    /// How fast they are.
    pub speeds: SpeedSummary,
    /// [ns/s] what the other way costs per particle and time.
    pub fallback_cost: f64,
}

/// A part of a window.
pub struct WindowPiece<'a> {
    /// [s] from the beginning of the window: for so long its frame has fallen.
    pub elapsed: f64,
    /// [s] its length.
    pub part: f64,
    /// Pairs that the search is expected to look at.
    pub foreseen: u64,
    /// All particles.
    pub population: &'a PopulationSummary,
    /// How fast they are.
    pub speeds: SpeedSummary,
    /// Members beyond which an island is too large for a part of this length.
    pub most: usize,
}

impl WindowPiece<'_> {
    /// [m] the largest reach of any flight about its middle.
    pub fn flight(&self) -> f64 {
        self.population.largest + 0.5 * self.part * self.speeds.largest * (1.0 + 1e-9)
    }
}

/// What the choice of a part must know besides the particles.
pub struct PartLimits {
    /// [s] to the end of the window.
    pub left: f64,
    /// [ns/s] what the other way costs per particle and time.
    pub fallback_cost: f64,
    /// Contacts that are taken into crowds and out again in every part.
    pub held: usize,
    /// Whether the engine says where flights turn.
    pub traces: bool,
}

/// What a part costs, in ns on one core, and from where on it costs more. Measured once (docs/architecture.md, "Islands"); they choose, they do not time.
struct PartCosts {
    /// [ns] flight, cells, ranges of cells: per particle.
    search: f64,
    /// [ns] looking at one pair.
    pair: f64,
    /// [ns] making and solving an island, per hot particle.
    island: f64,
    /// [-] how far a hot particle reaches, in mean flights.
    reach: f64,
    /// [-] islands in reach of one another unite, and then reach further: where each has so many others in reach they run together.
    crowded: f64,
}

/// Islands that reach as far as their particles might fly (case D: islands of 20 at parts of 0.5 ms, of 200 at 0.7 ms).
const ANYWHERE: PartCosts = PartCosts { search: 90.0, pair: 1.2, island: 1400.0, reach: 1.5, crowded: 0.25 };

/// Islands that reach as far as their particles do fly (scene S1: 1.1 µs per hot particle at parts of 0.375 ms, 1.2 at 0.5 ms, 1.6 at 0.75 ms).
const TRACED: PartCosts = PartCosts { search: 80.0, pair: 1.2, island: 1000.0, reach: 0.5, crowded: 0.15 };

/// The part of a window that costs least.
#[derive(Clone, Copy)]
pub struct Cheapest {
    /// [s] its length.
    pub part: f64,
    /// [-] pairs that its search looks at, per particle, as expected.
    pub pairs: f64,
}

/// The part of what is left that costs least per time, or `None` where islands do not pay.
///
/// A longer part spreads the search of all particles over more time but looks at more pairs, and makes more islands.
pub fn cheapest_part(
    population: &PopulationSummary,
    domain: &Domain,
    speeds: &SpeedSummary,
    limits: &PartLimits,
) -> Option<Cheapest> {
    /// Taking a contact of a crowd along: its particles into the crowd and back, and their list.
    const HELD: f64 = 500.0;
    let PartLimits { left, fallback_cost, held, traces } = *limits;
    let weights = if traces { &TRACED } else { &ANYWHERE };
    let &PopulationSummary { density, largest, mean_radius: [mean, mean_square], ref census, .. } = population;
    let count = population.count as f64;
    let search = weights.search + HELD * held as f64 / count;
    let diameter = 2.0 * largest;
    // distances at which two touch, over the largest diameter: mean square of all pairs, and mean of a largest particle, whose islands run
    // together first
    let square = 0.5 * (mean_square + mean * mean) / (largest * largest);
    let of_largest = 0.5 * (1.0 + mean / largest);
    // hot: what a sphere of radius d sweeps at the mean relative speed, and at the walls
    let rate = density * PI * diameter * diameter * square * speeds.mean * SQRT_2;
    let periods = (0..3).filter(|axis| domain.periodic[*axis]).map(|axis| domain.size[axis]);
    let period = periods.fold(f64::INFINITY, f64::min);
    // two that approach each other from both sides must not meet a further image than the nearest, which is at most half a
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
        // few particles always fit into islands; a crowd must stay sparse
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
    // one collision costs less than the search for it: then everybody is busy, and one calendar or step serves all
    best.map(|(_, cheapest)| cheapest)
}
