//! Event queue of an island (a group of particles that may meet). It contains the next touch of each candidate of the
//! neighbour list: a pair, or a particle and a wall. The number of a candidate in the list is called its slot. A window
//! is the time between two exchanges of momentum with the gas.

use ordered_float::OrderedFloat;
use priority_queue::PriorityQueue;
use rustc_hash::FxBuildHasher;
use std::cmp::Reverse;

/// Time of a touch [s since the start of the time window], and the slot (number in the neighbour list) of the two
/// bodies. Of events at equal times, the one with the lower slot comes first, so that runs are reproducible.
type DueEvent = Reverse<(OrderedFloat<f64>, u32)>;

/// Event queue of an island (group of particles that may meet), with at most one event per slot (number of a
/// candidate). Outdated events are replaced at once.
#[derive(Clone, Default)]
pub struct Calendar {
    queue: PriorityQueue<u32, DueEvent, FxBuildHasher>,
}

impl Calendar {
    /// Removes all events from the queue.
    pub fn clear(&mut self) {
        self.queue.clear();
    }

    /// Sets the time of the next touch of the two bodies at `slot` to `time` [s since the start of the time window].
    /// `None` means that no touch occurs within the window.
    pub fn set(&mut self, slot: u32, time: Option<f64>) {
        match time {
            Some(time) => {
                self.queue.push(slot, Reverse((OrderedFloat(time), slot)));
            }
            None => {
                self.queue.remove(&slot);
            }
        }
    }

    /// Removes the earliest event, and returns its slot (number of a candidate) and its time [s since the start of the
    /// time window].
    pub fn pop(&mut self) -> Option<(u32, f64)> {
        self.queue.pop().map(|(slot, Reverse((time, _)))| (slot, time.0))
    }
}
