//! Event queue of an island (a group of particles that may meet). The queue holds at most one coming touch of each
//! candidate in the island's neighbour list. A candidate is a pair, or a particle and a wall; the number of a candidate
//! in the list is called its slot. Times are counted from the start of the *part*, a piece of the time between two
//! exchanges with the gas.

use ordered_float::OrderedFloat;
use priority_queue::PriorityQueue;
use rustc_hash::FxBuildHasher;
use std::cmp::Reverse;

/// Key by which the event queue is sorted: the time of a touch [s since the start of the part, an interval of time],
/// then the slot (number of the candidate pair or wall). `Reverse` makes the earliest event come first. If times are
/// equal, the event with the lower slot comes first, so that runs are reproducible.
type DueEvent = Reverse<(OrderedFloat<f64>, u32)>;

/// Event queue of an island (group of particles that may meet). It contains at most one coming touch for each slot. A
/// slot is the number of a candidate (pair, or particle and wall) in the neighbour list. A new touch at a slot replaces
/// the old one.
#[derive(Clone, Default)]
pub struct Calendar {
    queue: PriorityQueue<u32, DueEvent, FxBuildHasher>,
}

impl Calendar {
    /// Removes all coming touches from the event queue.
    pub fn clear(&mut self) {
        self.queue.clear();
    }

    /// Sets the time `time` of the next touch of the two bodies with the number `slot` in the neighbour list. The time
    /// is in s since the start of the part (interval of time). With `None`, no touch is coming, and an earlier entry of
    /// the slot is removed.
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

    /// Removes the earliest touch from the queue. Returns its slot, the number of the two bodies in the neighbour list,
    /// and its time [s since the start of the part, an interval of time]; `None` if the queue is empty.
    pub fn pop(&mut self) -> Option<(u32, f64)> {
        self.queue.pop().map(|(slot, Reverse((time, _)))| (slot, time.0))
    }
}
