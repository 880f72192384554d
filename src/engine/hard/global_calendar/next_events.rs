//! What a particle's flight needs, and what comes to it next.

use super::shells::Shell;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// The flight of one particle: all that its neighbours ask for, in one line of the cache.
#[repr(align(64))]
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct FlightState {
    /// [m] position at its own time, in the frame of the calendar.
    pub position: Vector3<f64>,
    /// [m/s] velocity in that frame.
    pub velocity: Vector3<f64>,
    /// [s] its own time, since the epoch.
    pub time: f64,
    /// Which of the radii it has.
    pub kind: u32,
    /// How often it has collided, modulo 2³².
    pub hits: u32,
}

impl FlightState {
    /// Brings it to `now` [s].
    #[inline]
    pub fn advance(&mut self, now: f64) {
        self.position += self.velocity * (now - self.time);
        self.time = now;
    }
}

/// What comes to a particle next.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum EventKind {
    /// It touches the particle at a place, if that has not collided before.
    Pair(u32),
    /// It touches one of the contacts of all walls, counted in the order of the scene.
    Wall(u32),
    /// It leaves its shell: who is near must be found anew.
    Leave,
    /// Nothing as far as was looked: look again.
    Look,
}

/// The next two events of one particle and its shell, in another line.
#[repr(align(64))]
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct NextEvents {
    /// [s] when its event is due, since the epoch; infinite: never.
    pub time: f64,
    /// [s] when the one after that is due.
    pub then: f64,
    /// The event.
    pub next: EventKind,
    /// The one after that, if the partner of the first has collided with somebody else.
    pub after: EventKind,
    /// Of a pair: how often the partner had collided when the event was foretold. Of a wall: which part of it is touched.
    pub detail: u32,
    /// The same of the event after that.
    pub detail_after: u32,
    /// Its shell.
    pub shell: Shell,
}

impl NextEvents {
    /// Nothing foretold.
    pub fn blank() -> Self {
        let (never, look) = (f64::INFINITY, EventKind::Look);
        Self { time: never, then: never, next: look, after: look, detail: 0, detail_after: 0, shell: Shell::default() }
    }

    /// Whether there is a later event to go on to.
    #[inline]
    pub fn has_more(&self) -> bool {
        self.then > self.time
    }

    /// Goes on to the event after the first, which will not come about.
    #[inline]
    pub fn go_on(&mut self) {
        (self.time, self.next, self.detail) = (self.then, self.after, self.detail_after);
    }
}
