//! Flight data and next events of a particle.

use super::shells::Shell;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Flight of one particle: all data that its neighbours need, in one cache line.
#[repr(align(64))]
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct FlightState {
    /// Position [m] at the particle's own time, in the frame of the calendar.
    pub position: Vector3<f64>,
    /// Velocity [m/s] in the frame of the calendar.
    pub velocity: Vector3<f64>,
    /// The particle's own time [s] since the epoch.
    pub time: f64,
    /// Index of its radius and mass among the kinds.
    pub kind: u32,
    /// Number of collisions so far, modulo 2³².
    pub hits: u32,
}

impl FlightState {
    /// Moves the particle to time `now` [s].
    #[inline]
    pub fn advance(&mut self, now: f64) {
        self.position += self.velocity * (now - self.time);
        self.time = now;
    }
}

/// Kind of event.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum EventKind {
    /// Touch of the particle with this index, valid if that has not collided before.
    Pair(u32),
    /// Touch of a wall contact; contacts of all walls are counted in the order of the scene.
    Wall(u32),
    /// Leaving the shell: the neighbours must be found again.
    Leave,
    /// No event within the time predicted so far: predict again.
    Look,
}

/// The next two events of one particle and its shell, in a second cache line.
#[repr(align(64))]
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct NextEvents {
    /// Time [s] of the next event since the epoch; infinite: never.
    pub time: f64,
    /// Time [s] of the second event.
    pub then: f64,
    /// The next event.
    pub next: EventKind,
    /// The second event, which becomes next if the partner of the first has collided elsewhere.
    pub after: EventKind,
    /// Detail of the next event. For a pair: number of collisions of the partner at prediction. For a wall: the part
    /// touched.
    pub detail: u32,
    /// Detail of the second event, like `detail`.
    pub detail_after: u32,
    /// Shell of the particle.
    pub shell: Shell,
}

impl NextEvents {
    /// A particle without predicted events.
    pub fn blank() -> Self {
        let (never, look) = (f64::INFINITY, EventKind::Look);
        Self { time: never, then: never, next: look, after: look, detail: 0, detail_after: 0, shell: Shell::default() }
    }

    /// True if there is a later event to continue with.
    #[inline]
    pub fn has_more(&self) -> bool {
        self.then > self.time
    }

    /// Replaces the next event, which will not happen, by the second one.
    #[inline]
    pub fn go_on(&mut self) {
        (self.time, self.next, self.detail) = (self.then, self.after, self.detail_after);
    }
}
