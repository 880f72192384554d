//! Event queue of an island (a group of particles that may meet). It contains the next touch of each slot of the
//! neighbour list: of a pair, or of a particle and a wall.

use ordered_float::OrderedFloat;
use priority_queue::PriorityQueue;
use rustc_hash::FxBuildHasher;
use std::cmp::Reverse;

/// Time of a touch [s since the start of the window] and its slot. At equal times the slot decides the order, so that
/// runs are reproducible.
type DueEvent = Reverse<(OrderedFloat<f64>, u32)>;

/// Event queue with at most one event per slot; each event is up to date.
#[derive(Clone, Default)]
pub struct Calendar {
    queue: PriorityQueue<u32, DueEvent, FxBuildHasher>,
}

impl Calendar {
    /// Removes all events from the queue.
    pub fn clear(&mut self) {
        self.queue.clear();
    }

    /// Sets the next touch of slot `slot` to `time` [s]; `None` if the slot has no touch within the window.
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

    /// Removes the earliest event, and returns its slot and time.
    pub fn pop(&mut self) -> Option<(u32, f64)> {
        self.queue.pop().map(|(slot, Reverse((time, _)))| (slot, time.0))
    }
}
