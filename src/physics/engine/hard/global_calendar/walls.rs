//! Wall contacts of a scene, numbered for the calendar (the event queue of all particles). The epoch is the instant
//! from which the calendar counts times.

use super::GlobalCalendar;
use crate::encounter::AtWall;
use crate::scene::Scene;
use crate::walls::{NearWalls, Wall};
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

impl GlobalCalendar {
    /// Upper limit [m] of the distance by which a wall moves away from its place in the scene until the next epoch, the
    /// instant from which the calendar then counts times. It is 0 for a wall that does not move.
    pub(super) fn travel(&self, wall: &Wall) -> f64 {
        wall.moving.as_ref().map_or(0.0, |moving| moving.travel(self.epoch + self.limit - moving.time()))
    }
}
