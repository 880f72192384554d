//! Event queue of an island: next touch among the slots of the neighbour list.

use ordered_float::OrderedFloat;
use priority_queue::PriorityQueue;
use rustc_hash::FxBuildHasher;
use std::cmp::Reverse;

/// Time of a touch [s since the start of the window] and its slot; the slot decides between equal times, so that runs
/// are reproducible.
type DueEvent = Reverse<(OrderedFloat<f64>, u32)>;

/// Event queue with at most one event per slot, which is always up to date.
#[derive(Clone, Default)]
pub struct Calendar {
    queue: PriorityQueue<u32, DueEvent, FxBuildHasher>,
}

impl Calendar {
    /// Removes all events.
    pub fn clear(&mut self) {
        self.queue.clear();
    }

    /// Sets the next touch of slot `slot` to `time` [s]; `None` if there is none within the window.
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

    /// Removes the next event, and returns its slot and time.
    pub fn pop(&mut self) -> Option<(u32, f64)> {
        self.queue.pop().map(|(slot, Reverse((time, _)))| (slot, time.0))
    }
}
