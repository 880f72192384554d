//! Flight and next events of one particle, as the calendar (the event queue of all particles) stores them. Times are
//! counted from the instant called epoch.

use super::shells::Shell;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Straight flight of one particle. All data that the prediction of touches reads of a neighbour fit into one cache
/// line.
#[repr(align(64))]
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct FlightState {
    /// [m] position of the particle at the time `time`, in the frame that falls with gravity. It may be outside the
    /// box.
    pub position: Vector3<f64>,
    /// [m/s] velocity of the particle in the frame that falls with gravity.
    pub velocity: Vector3<f64>,
    /// [s] time since the epoch (zero of the event queue's time) at which the particle is at `position`. The flight
    /// begins at this time, for instance with a collision.
    pub time: f64,
    /// Number of the particle's combination of radius and mass in `Shells::kinds`.
    pub kind: u32,
    /// Number of the particle's collisions so far, modulo 2³². A change of this number shows that events predicted with
    /// this particle are void.
    pub collision_count: u32,
}

impl FlightState {
    /// Position [m] of the particle on its flight at the time `now` [s] since the epoch (zero of the event queue's
    /// time).
    #[inline]
    pub fn position_at(&self, now: f64) -> Vector3<f64> {
        self.position + self.velocity * (now - self.time)
    }

    /// Moves the particle along its flight to the time `now` [s] since the epoch (zero of the event queue's time).
    #[inline]
    pub fn advance(&mut self, now: f64) {
        self.position += self.velocity * (now - self.time);
        self.time = now;
    }
}

/// Kind of an event of a particle, in its list of next events.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum EventKind {
    /// Touch with the particle that has this index. The event is void if that particle collides before.
    Pair(u32),
    /// Touch at the wall contact with this number. A wall may have several contacts, such as one for each side of a
    /// box. The contacts of all walls are numbered in the order of the scene.
    Wall(u32),
    /// The particle leaves its shell (the ball in which its neighbour list is valid), so it needs a new list.
    LeaveShell,
    /// No event happens up to the time at which prediction ends; at this time, events must be predicted again.
    Predict,
}

/// The next two events of one particle, and its shell (ball in which its neighbour list is valid), in one cache line.
/// Times are counted from the epoch (zero of the event queue's time).
#[repr(align(64))]
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct NextEvents {
    /// [s] time of the next event since the epoch (zero of time); infinite if there is none.
    pub time: f64,
    /// [s] time of the second event since the epoch (zero of time). If no second event is stored, this time is not
    /// later than `time`.
    pub second_time: f64,
    /// Kind of the next event of the particle.
    pub kind: EventKind,
    /// Kind of the second event. It becomes the next event if the first is void, because its partner has collided with
    /// another body.
    pub second_kind: EventKind,
    /// Detail of the next event. For a pair it is the partner's number of collisions when the event was predicted. For
    /// a wall it is the number of the surface feature (such as a triangle) that is touched.
    pub detail: u32,
    /// Detail of the second event: the partner's number of collisions, or the number of the surface feature (such as a
    /// triangle) of the wall.
    pub second_detail: u32,
    /// Shell of the particle, the ball in which its neighbour list is valid.
    pub shell: Shell,
}

impl NextEvents {
    /// Makes the entry of a particle for which no events have been predicted yet.
    pub fn blank() -> Self {
        let (never, predict) = (f64::INFINITY, EventKind::Predict);
        Self {
            time: never,
            second_time: never,
            kind: predict,
            second_kind: predict,
            detail: 0,
            second_detail: 0,
            shell: Shell::default(),
        }
    }

    /// True if a second event is stored. The second event replaces the next event if the partner of the next event has
    /// collided before.
    #[inline]
    pub fn has_second(&self) -> bool {
        self.second_time > self.time
    }

    /// Puts a touch with the particle that has the index `partner` before the next event, which becomes the second
    /// event. `time` [s] since the epoch (zero of time) is the time of the touch, and `detail` the partner's number of
    /// collisions so far.
    pub fn put_first(&mut self, time: f64, partner: u32, detail: u32) {
        (self.second_time, self.second_kind, self.second_detail) = (self.time, self.kind, self.detail);
        (self.time, self.kind, self.detail) = (time, EventKind::Pair(partner), detail);
    }

    /// Replaces the next event by the second one, after the partner of the next event has collided with another body.
    #[inline]
    pub fn take_second(&mut self) {
        (self.time, self.kind, self.detail) = (self.second_time, self.second_kind, self.second_detail);
    }
}

/// Particles with consecutive indices: their flights, and their next events with their shells (balls in which neighbour
/// lists are valid).
#[derive(Clone, Copy)]
pub struct ParticleRange<'a> {
    /// Index, in the particle store, of the first particle of the range.
    pub first: u32,
    /// Flights of the particles.
    pub bodies: &'a [FlightState],
    /// Next events of the particles.
    pub next_events: &'a [NextEvents],
}

impl<'a> ParticleRange<'a> {
    /// Flight of the particle at `index`.
    #[inline(always)]
    pub fn body(&self, index: u32) -> &'a FlightState {
        &self.bodies[(index - self.first) as usize]
    }

    /// Shell of the particle at `index`, the ball in which its neighbour list is valid.
    #[inline(always)]
    pub fn shell(&self, index: u32) -> &'a Shell {
        &self.next_events[(index - self.first) as usize].shell
    }
}
