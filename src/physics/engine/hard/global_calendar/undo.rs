//! States of particles before the events of a round, so that the round can be undone. A round is a piece of time in
//! which several threads process events.

use super::append;
use super::next_events::{FlightState, NextEvents};
use crate::engine::hard::collapse_detector::LastCollision;

/// States of particles before each event of a round (piece of time in which several threads process events).
#[derive(Clone, Debug, Default)]
pub struct Undo {
    /// Index of each particle that took part in an event.
    indices: Vec<u32>,
    /// Next events of each of these particles before the event.
    events: Vec<NextEvents>,
    /// Flight of each of these particles before the event.
    flights: Vec<FlightState>,
    /// Index of each particle that collided, with its collision history before the collision.
    histories: Vec<(u32, LastCollision)>,
}

impl Undo {
    /// Stores the state of the particle at `index` before an event. `history` is its collision history before a
    /// collision; `None` before other events.
    #[inline]
    pub fn push(&mut self, index: u32, body: &FlightState, events: &NextEvents, history: Option<&LastCollision>) {
        append(&mut self.indices, index);
        append(&mut self.events, *events);
        append(&mut self.flights, *body);
        if let Some(history) = history {
            append(&mut self.histories, (index, *history));
        }
    }

    /// Forgets all stored states.
    pub fn clear(&mut self) {
        self.indices.clear();
        self.events.clear();
        self.flights.clear();
        self.histories.clear();
    }

    /// Restores the stored states, from the latest to the earliest, and forgets them. Appends the indices of the
    /// restored particles to `changed`. Neighbour lists are not changed in a round, so they stay as they are.
    pub fn restore(
        &mut self,
        bodies: &mut [FlightState],
        next_events: &mut [NextEvents],
        last_collisions: &mut [LastCollision],
        changed: &mut Vec<u32>,
    ) {
        changed.extend(&self.indices);
        let states = self.events.drain(..).zip(self.flights.drain(..));
        for (index, (events, flight)) in self.indices.drain(..).zip(states).rev() {
            (bodies[index as usize], next_events[index as usize]) = (flight, events);
        }
        for (index, history) in self.histories.drain(..).rev() {
            last_collisions[index as usize] = history;
        }
    }
}
