//! States of particles before the collisions of a round, so that the round can be undone. A round is a piece of time in
//! which several threads process events.

use super::append;
use super::next_events::FlightState;
use crate::engine::hard::collapse_detector::LastCollision;

/// States of particles before each collision of a round (piece of time in which several threads process events). The
/// indices of other particles, whose events must be predicted again if the round is undone, are stored as well.
#[derive(Clone, Debug, Default)]
pub struct Undo {
    /// Flight of each particle that collided, before the collision.
    flights: Vec<FlightState>,
    /// Index of each particle that collided, with its collision history before the collision.
    histories: Vec<(u32, LastCollision)>,
    /// Index of each particle that had an event other than a collision.
    others: Vec<u32>,
}

impl Undo {
    /// Stores the state of the particle at `index` before a collision.
    #[inline]
    pub fn push(&mut self, index: u32, body: &FlightState, history: &LastCollision) {
        append(&mut self.flights, *body);
        append(&mut self.histories, (index, *history));
    }

    /// Notes that the particle at `index` has an event that changes neither its flight nor its collision history.
    #[inline]
    pub fn note(&mut self, index: u32) {
        append(&mut self.others, index);
    }

    /// Forgets all stored states.
    pub fn clear(&mut self) {
        self.flights.clear();
        self.histories.clear();
        self.others.clear();
    }

    /// Restores the stored states, from the latest to the earliest, and forgets them. Appends to `changed` the indices
    /// of all particles that had events. Shells (balls in which neighbour lists are valid) stay as they are.
    pub fn restore(
        &mut self,
        bodies: &mut [FlightState],
        last_collisions: &mut [LastCollision],
        changed: &mut Vec<u32>,
    ) {
        changed.append(&mut self.others);
        let states = self.histories.drain(..).zip(self.flights.drain(..));
        for ((index, history), flight) in states.rev() {
            (bodies[index as usize], last_collisions[index as usize]) = (flight, history);
            changed.push(index);
        }
    }
}
