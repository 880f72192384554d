//! Wall contacts of a scene, numbered for the calendar (the event queue of all particles). The epoch is the instant
//! from which the calendar counts times.

use super::cells::ROUNDING;
use super::next_events::FlightState;
use super::view::CalendarView;
use crate::encounter::AtWall;
use crate::neighbours::along_walls;
use crate::scene::Scene;
use crate::walls::{NearWalls, Wall};
use nalgebra::Vector3;
use std::ops::Range;

/// All contacts that a sphere may have with the walls of a scene, in the order of the walls, and a search for walls
/// near a point. A wall may have several contacts with a sphere, such as one for each side of a box.
#[derive(Clone, Debug, Default)]
pub struct WallContacts {
    /// The contacts; a predicted touch of a wall refers to its contact by the number in this list.
    pub contacts: Vec<AtWall>,
    /// For each wall, by its number in the scene, the range of its contacts in `contacts`.
    of: Vec<Range<u32>>,
    /// Search structure for the walls near a point.
    pub near: NearWalls,
}

impl WallContacts {
    /// Lists all contacts that a sphere may have with the walls of a scene.
    pub fn of(scene: &Scene) -> Self {
        let (mut contacts, mut of) = (Vec::new(), Vec::new());
        for (wall, shape) in (0u32..).zip(&scene.walls) {
            let first = contacts.len() as u32;
            contacts.extend((0..shape.geometry.contacts()).map(|which| AtWall { wall, which }));
            of.push(first..contacts.len() as u32);
        }
        Self { contacts, of, near: NearWalls::of(&scene.walls) }
    }

    /// Range, in `contacts`, of the contacts with the wall that has the index `wall` in the scene.
    pub fn of_wall(&self, wall: u32) -> Range<u32> {
        self.of[wall as usize].clone()
    }
}

impl CalendarView<'_> {
    /// Upper limit [m] of the distance by which a wall moves away from its place in the scene until the next epoch, the
    /// instant from which the event queue counts times anew. It is 0 for a wall that does not move.
    fn travel(&self, wall: &Wall) -> f64 {
        wall.moving.as_ref().map_or(0.0, |moving| moving.travel(self.epoch + self.limit - moving.time()))
    }

    /// True if the particle with the flight `body` may touch a wall before it leaves its shell, or before the next
    /// epoch (new zero of the event queue's time). The shell, the ball in which its neighbour list is valid, is here
    /// the ball about its position at `now` [s] since the present epoch.
    pub fn at_wall(&self, body: &FlightState, now: f64) -> bool {
        let scene = self.scene;
        if scene.walls.is_empty() {
            return false;
        }
        let flight = self.frame.flight(&body.position_at(now), &body.velocity, now);
        // distance by which the frame moves and falls towards walls within the epoch
        let drift = across(scene, self.frame.velocity).norm() * self.limit;
        let fall = drift + 0.5 * across(scene, scene.gravity).norm() * self.limit * self.limit;
        let reach = self.shells.radius(body) + self.shells.margin + fall + ROUNDING * scene.domain.size.max();
        let position = scene.domain.wrap(&flight.position);
        let mut found = false;
        self.walls.near.for_each(&position, reach, |wall| {
            let wall = &scene.walls[wall as usize];
            found = found || wall.geometry.is_within(&position, reach + self.travel(wall));
        });
        found
    }
}

/// Component towards the walls of `vector`, a velocity or acceleration common to all particles. The component is zero
/// if the vector is parallel to all walls, or without walls. If a wall is not a plane, the component is the whole
/// vector.
pub fn across(scene: &Scene, vector: Vector3<f64>) -> Vector3<f64> {
    vector - along_walls(scene, vector)
}
