//! The event calendar: which slot of the neighbour list touches next.

use ordered_float::OrderedFloat;
use priority_queue::PriorityQueue;
use rustc_hash::FxBuildHasher;
use std::cmp::Reverse;

/// When a slot touches [s since the start of the window]; equal times go by slot, so that runs repeat.
type DueEvent = Reverse<(OrderedFloat<f64>, u32)>;

/// At most one event per slot, never a stale one.
#[derive(Clone, Default)]
pub struct Calendar {
    queue: PriorityQueue<u32, DueEvent, FxBuildHasher>,
}

impl Calendar {
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.queue.clear();
    }

    /// Slot `slot` touches at `time` [s], or not within the window.
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

    /// Takes out the next event: its slot and time.
    pub fn pop(&mut self) -> Option<(u32, f64)> {
        self.queue.pop().map(|(slot, Reverse((time, _)))| (slot, time.0))
    }
}
