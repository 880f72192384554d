//! Data that the events of all particles read: the scene, the frame of reference of the event queue, shells (balls in
//! which neighbour lists are valid) and walls.

use super::frame::FallingFrame;
use super::next_events::FlightState;
use super::shells::Shells;
use super::walls::WallContacts;
use crate::clock::Clock;
use crate::domain::Domain;
use crate::scene::Scene;
use crate::walls::{Flight, Wall};
use nalgebra::Vector3;
use std::borrow::Cow;

/// Data of the calendar (the event queue of all particles) that no event changes. There is one exception: events move
/// centres of shells (balls in which neighbour lists are valid) from cell to cell.
#[derive(Clone, Copy)]
pub struct CalendarView<'a> {
    /// The scene of the window.
    pub scene: &'a Scene,
    /// The frame that falls with gravity, in which flights are straight.
    pub frame: FallingFrame,
    /// [s] time since the epoch (zero of the event queue's time) at which a new epoch must begin.
    pub limit: f64,
    /// [s] time since the epoch (zero of the event queue's time) up to which events are predicted.
    pub horizon: f64,
    /// [s] simulated time at the epoch, the instant from which the event queue counts times.
    pub epoch: f64,
    /// [s] time since the epoch (zero of the event queue's time) until which neighbour lists across sheared sides are
    /// valid; infinite without shear.
    pub lists_valid_until: f64,
    /// Shells (balls in which neighbour lists are valid) of all particles.
    pub shells: &'a Shells,
    /// All contacts that a sphere may have with the walls of the scene.
    pub walls: &'a WallContacts,
    /// Id of each particle, by particle index.
    pub ids: &'a [u32],
    /// True for each periodic axis along which two particles may touch through images other than the nearest.
    pub far_images: [bool; 3],
    /// Contact time [s] of the TC model, in which a collision is elastic if the particle collided less than this time
    /// before; `None` without this model.
    pub contact_time: Option<f64>,
    /// [m] distance inside the surface of a particle's shell (ball in which its neighbour list is valid) at which its
    /// exit from the shell is processed. It is 0 unless several threads share the events. These threads make most new
    /// shells only at the end of a round (piece of time), and until then a particle may fly on by this distance.
    pub slack: f64,
    /// [s] length of the time, after the exit of a particle from its shell (ball in which its neighbour list is valid),
    /// in which touches of the particle are still predicted; used if `slack` is above 0.
    pub grace: f64,
    /// Clock that receives the progress of the run.
    pub clock: &'a Clock,
}

impl<'a> CalendarView<'a> {
    /// Time [s] that has passed since the moving wall `wall` was at its place in the scene; 0 for a wall that does not
    /// move. The present time is `now` [s] since the epoch (zero of the event queue's time).
    #[inline]
    pub fn ahead(&self, wall: &Wall, now: f64) -> f64 {
        wall.moving.as_ref().map_or(0.0, |moving| self.epoch + now - moving.time())
    }

    /// The box with the images across its sheared sides at their places at `now` [s] since the epoch (zero of the event
    /// queue's time); without shear, the box itself.
    #[inline]
    pub fn domain(&self, now: f64) -> Cow<'a, Domain> {
        self.scene.domain.at(self.epoch + now)
    }

    /// Vector [m] from `b` to the nearest periodic image of `a`, and velocity [m/s] of this image relative to `b`. The
    /// time is `now` [s] since the epoch (zero of the event queue's time). `velocity` [m/s] is the velocity of `a`
    /// itself relative to `b`; the velocity of the image differs from this velocity only across sheared sides.
    #[inline]
    pub fn relative(
        &self,
        a: &Vector3<f64>,
        b: &Vector3<f64>,
        velocity: Vector3<f64>,
        now: f64,
    ) -> (Vector3<f64>, Vector3<f64>) {
        if self.scene.domain.shear.is_none() {
            return (self.scene.domain.nearest_image(&(a - b)), velocity);
        }
        self.domain(now).relative(a, b, velocity, 0.0)
    }

    /// Position [m] of the particle with the flight `body`, in the frame that falls with gravity, shifted by whole
    /// periods into the box. The time is `now` [s] since the epoch (zero of the event queue's time).
    #[inline]
    pub fn centre(&self, body: &FlightState, now: f64) -> Vector3<f64> {
        self.scene.domain.wrap(&body.position_at(now))
    }

    /// Flight of a body relative to the scene. The body has `position` [m] and `velocity` [m/s] in the frame that falls
    /// with gravity at `now` [s] since the epoch (zero of the event queue's time).
    pub fn flight(&self, position: &Vector3<f64>, velocity: &Vector3<f64>, now: f64) -> Flight {
        self.frame.flight(position, velocity, now)
    }
}
