//! States of particles before the events of a round, so that the round can be undone.

use super::next_events::{FlightState, NextEvents};
use crate::engine::hard::collapse_detector::LastCollision;

/// States of particles before each event of a round (piece of time in which several threads process events).
#[derive(Clone, Debug, Default)]
pub struct Undo {
    /// Index of each particle that took part in an event, with its flight and its next events before the event.
    states: Vec<(u32, FlightState, NextEvents)>,
    /// Index of each particle that collided, with its collision history before the collision.
    histories: Vec<(u32, LastCollision)>,
}

impl Undo {
    /// Stores the state of the particle at `index` before an event; `history` is its collision history before a
    /// collision.
    #[inline]
    pub fn push(&mut self, index: u32, body: &FlightState, events: &NextEvents, history: Option<&LastCollision>) {
        self.states.push((index, *body, *events));
        if let Some(history) = history {
            self.histories.push((index, *history));
        }
    }

    /// Forgets all stored states.
    pub fn clear(&mut self) {
        self.states.clear();
        self.histories.clear();
    }

    /// Restores the stored states, from the latest to the earliest, and forgets them. Appends the indices of these
    /// particles to `changed`. Neighbour lists are not changed in a round, so they stay as they are.
    pub fn restore(
        &mut self,
        bodies: &mut [FlightState],
        next_events: &mut [NextEvents],
        last_collisions: &mut [LastCollision],
        changed: &mut Vec<u32>,
    ) {
        changed.extend(self.states.iter().map(|(index, ..)| *index));
        for (index, body, events) in self.states.drain(..).rev() {
            (bodies[index as usize], next_events[index as usize]) = (body, events);
        }
        for (index, history) in self.histories.drain(..).rev() {
            last_collisions[index as usize] = history;
        }
    }
}
