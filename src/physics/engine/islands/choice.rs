//! Choice of the next part of a window: its length, and whether it pays to solve islands (groups of particles that may
//! meet) in this part. The alternative is the classical algorithm, which moves all particles at once. Costs are
//! computing times. A window is the time between two exchanges of momentum with the gas.

use crate::domain::Domain;
use crate::engine::population::PopulationSummary;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, SQRT_2};
use std::sync::Arc;

/// Typical and largest speed of all particles, for estimates of costs.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub struct SpeedSummary {
    /// [m/s] velocity of the frame in which speeds are measured: the mean velocity of all particles along the walls.
    pub frame: Vector3<f64>,
    /// [m/s] root of the mean square speed of all particles relative to the moving frame with the velocity `frame`.
    pub mean: f64,
    /// [m/s] largest speed of any particle relative to the moving frame with the velocity `frame`.
    pub largest: f64,
}

/// Data for the choice between islands (groups of particles that may meet) and the classical algorithm. That algorithm
/// moves all particles together, in uniform steps or by one event queue.
pub struct IslandCost {
    /// Summary of the sizes of all particles.
    pub population: Arc<PopulationSummary>,
    /// Summary of the velocities of all particles.
    pub speeds: SpeedSummary,
    /// [ns/s] cost of the classical algorithm (all particles at once), per particle and simulated time.
    pub fallback_cost: f64,
}

/// A part, a piece of a window (time between two exchanges with the gas) for which islands (groups of particles that
/// may meet) are found and solved.
pub struct WindowPiece<'a> {
    /// [s] time from the start of the window to the start of the part (interval of time).
    pub elapsed: f64,
    /// [s] length of the part (piece of a window).
    pub part: f64,
    /// Estimated number of pairs that the search for touching particles will check in this part (interval of time).
    pub foreseen: u64,
    /// Summary of the sizes of all particles.
    pub population: &'a PopulationSummary,
    /// Speeds of all particles at the start of the part (interval of time).
    pub speeds: SpeedSummary,
    /// Largest number of members that an island (group of particles that may meet) may have; if an island has more, a
    /// shorter part (interval of time) is tried.
    pub most: usize,
}

impl WindowPiece<'_> {
    /// Upper limit [m] of the distance of any point of a particle from the middle of its straight flight in this part
    /// (interval of time).
    pub fn flight(&self) -> f64 {
        self.population.largest + 0.5 * self.part * self.speeds.largest * (1.0 + 1e-9)
    }
}

/// Data for the choice of the length of a part, a piece of the time between two exchanges with the gas.
pub struct PartLimits {
    /// [s] time from the start of the part (interval of time) to the end of the window, which the part cannot exceed.
    pub left: f64,
    /// [ns/s] cost of the classical algorithm (all particles at once), per particle and simulated time. Islands must be
    /// cheaper.
    pub fallback_cost: f64,
    /// Number of contacts in progress. In every part (interval of time) their particles are copied into a crowd (an
    /// island moved by uniform steps) and back.
    pub held: usize,
    /// Measured costs of finding and solving islands (groups of particles that may meet), by which the length of the
    /// part (interval of time) is chosen.
    pub costs: PartCosts,
}

/// Costs of finding and solving islands (groups of particles that may meet) in ns on one core, and the density above
/// which islands unite. They were measured once (docs/design/islands.md), and serve only for the choice of a method,
/// not for a prediction of run times.
pub struct PartCosts {
    /// [ns] cost per particle of moving it straight and sorting it into cells.
    search: f64,
    /// [ns] cost of checking one pair of particles for a touch.
    pair: f64,
    /// [ns] cost of making and solving islands, per hot particle (member of an island).
    island: f64,
    /// [-] distance within which a hot particle (member of an island) may meet other hot particles, divided by the mean
    /// length of a flight in the part (interval of time).
    reach: f64,
    /// [-] number of other hot particles (members of islands) within reach of a hot particle, above which nearly all
    /// islands unite. Islands within reach of each other unite, and the united island reaches farther.
    crowded: f64,
}

/// Costs of islands (groups of particles that may meet) that are found by bounds on the flights of their members
/// ([`BoundedIslands`](super::BoundedIslands)). In a gas of particles in a channel (case D of docs/paper.md), islands
/// have up to 20 particles for parts (intervals of time) of 0.5 ms, and up to 200 for parts of 0.7 ms.
pub const BOUNDED: PartCosts = PartCosts { search: 90.0, pair: 1.2, island: 1400.0, reach: 1.5, crowded: 0.25 };

/// Costs of islands (groups of particles that may meet) that are found by the trajectories of their members
/// ([`TracedIslands`](super::TracedIslands)). In scene S1 (docs/results/speed.md), a hot particle (member of an
/// island) costs 1.1 µs for parts (intervals of time) of 0.375 ms, 1.2 µs for 0.5 ms, and 1.6 µs for 0.75 ms.
pub const TRACED: PartCosts = PartCosts { search: 80.0, pair: 1.2, island: 1000.0, reach: 0.5, crowded: 0.15 };

/// [-] largest shear of a sheared box in one part (interval of time): relative displacement of two particles by the
/// mean flow, divided by their distance along y. The balls that contain flights are enlarged by about this fraction,
/// which must therefore be small.
const STRAINED: f64 = 0.1;

/// [-] factor by which the largest allowed length of parts (intervals of time) is multiplied in a sheared box, since
/// the balls that contain flights are enlarged there by up to a fifth.
const STRAINED_ROOM: f64 = 0.8;

/// Length of a part (piece of the time between two exchanges with the gas) that has the lowest cost per simulated time.
#[derive(Clone, Copy)]
pub struct Cheapest {
    /// [s] length of the part (interval of time).
    pub part: f64,
    /// [-] expected number of pairs per particle that the search for touching particles checks.
    pub pairs: f64,
}

/// Chooses the length of the next part (a piece of the rest of the window) that has the lowest cost per simulated
/// time. `None` if at every length islands (groups of particles that may meet) cost more than the classical algorithm,
/// which moves all particles at once, or nearly all islands would unite. Also `None` if the largest particle is as
/// wide as half a period of the box.
///
/// In a longer part, one search for touching particles serves for more time, but it checks more pairs and finds more
/// islands.
pub fn cheapest_part(
    population: &PopulationSummary,
    domain: &Domain,
    speeds: &SpeedSummary,
    limits: &PartLimits,
) -> Option<Cheapest> {
    /// [ns] cost per contact in a crowd (an island moved by uniform steps): copying its particles into the crowd and
    /// back, and building their neighbour list.
    const HELD: f64 = 500.0;
    let PartLimits { left, fallback_cost, held, costs: weights } = limits;
    let (left, fallback_cost, held) = (*left, *fallback_cost, *held);
    let &PopulationSummary { density, largest, mean_radius: [mean, mean_square], ref census, .. } = population;
    let count = population.count as f64;
    let search = weights.search + HELD * held as f64 / count;
    let diameter = 2.0 * largest;
    // mean square of the distance between two centres at touch, over all pairs, divided by the largest diameter
    // squared; and mean of this distance over the partners of a largest particle, divided by the largest diameter.
    // Islands of the largest particles are the first to unite.
    let square = 0.5 * (mean_square + mean * mean) / (largest * largest);
    let of_largest = 0.5 * (1.0 + mean / largest);
    // rate at which a particle becomes hot (touches another): density times cross-section times mean relative speed;
    // touches of walls are not counted
    let rate = density * PI * diameter * diameter * square * speeds.mean * SQRT_2;
    let periods = (0..3).filter(|axis| domain.periodic[*axis]).map(|axis| domain.size[axis]);
    let period = periods.fold(f64::INFINITY, f64::min);
    // [s] longest part in which two particles can meet only as nearest images. Two particles half a period apart, which
    // approach each other at twice the largest speed, do not touch within this time.
    let room = (0.5 * period - diameter) / (2.0 * speeds.largest);
    let room = if domain.shear.is_some() { STRAINED_ROOM * room.min(STRAINED / domain.strain_rate()) } else { room };
    if room <= 0.0 {
        return None;
    }
    let mut best: Option<(f64, Cheapest)> = None;
    let mut pieces = (left / room).ceil().max(1.0);
    for _ in 0..40 {
        let part = left / pieces;
        let edge = diameter + speeds.largest * part;
        let hot = rate * part;
        // up to eight particles form only small islands; more particles are solved in islands only if they are dilute
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
    // no length was found if islands cost more than the classical algorithm at every length, or if nearly all islands
    // would unite
    best.map(|(_, cheapest)| cheapest)
}
