//! Flight and next events of one particle, as the calendar (the event queue of all particles) stores them. The epoch is
//! the instant from which the calendar counts times.

use super::shells::Shell;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Flight of one particle. The data that a test for touches reads of a neighbour are in one cache line.
#[repr(align(64))]
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct FlightState {
    /// Position [m] of the particle at the time `time`, in the falling frame of the calendar.
    pub position: Vector3<f64>,
    /// Velocity [m/s] of the particle in the falling frame of the calendar.
    pub velocity: Vector3<f64>,
    /// Time [s] at which the particle is at `position`, counted from the epoch (zero of the calendar's time).
    pub time: f64,
    /// Number of the particle's class in the list of all combinations of radius and mass.
    pub kind: u32,
    /// Number of the particle's collisions so far, modulo 2³².
    pub hits: u32,
}

impl FlightState {
    /// Moves the particle along its flight to the time `now` [s].
    #[inline]
    pub fn advance(&mut self, now: f64) {
        self.position += self.velocity * (now - self.time);
        self.time = now;
    }
}

/// Kind of an event of a particle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum EventKind {
    /// Touch of the particle with this index. The event is valid if that particle does not collide before.
    Pair(u32),
    /// Touch of the wall contact with this number; the contacts of all walls are numbered in the order of the scene.
    Wall(u32),
    /// The particle leaves its shell (the ball in which its neighbour list is valid), so its neighbours must be
    /// searched again.
    Leave,
    /// No event occurs within the time for which events were predicted, so events must be predicted again.
    Look,
}

/// The next two events of one particle and its shell (ball in which its neighbour list is valid), in a second cache
/// line.
#[repr(align(64))]
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct NextEvents {
    /// Time [s] of the next event since the epoch (zero of the calendar's time); infinite if there is none.
    pub time: f64,
    /// Time [s] of the second event since the epoch (zero of the calendar's time).
    pub then: f64,
    /// Kind of the next event.
    pub next: EventKind,
    /// The second event, which becomes the next if the partner of the first event has collided with another body.
    pub after: EventKind,
    /// Detail of the next event. For a pair it is the number of collisions of the partner when the event was predicted.
    /// For a wall it is the number of the surface feature that is touched.
    pub detail: u32,
    /// Detail of the second event, with the meaning of `detail`.
    pub detail_after: u32,
    /// Shell of the particle: the ball in which its neighbour list is valid.
    pub shell: Shell,
}

impl NextEvents {
    /// Makes an entry for a particle without predicted events.
    pub fn blank() -> Self {
        let (never, look) = (f64::INFINITY, EventKind::Look);
        Self { time: never, then: never, next: look, after: look, detail: 0, detail_after: 0, shell: Shell::default() }
    }

    /// True if a second event is stored. It is later than the next event, and can replace it.
    #[inline]
    pub fn has_more(&self) -> bool {
        self.then > self.time
    }

    /// Replaces the next event by the second one, after the next event was cancelled.
    #[inline]
    pub fn go_on(&mut self) {
        (self.time, self.next, self.detail) = (self.then, self.after, self.detail_after);
    }
}
