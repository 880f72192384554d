//! Wall contacts of a scene, numbered for the calendar (the event queue of all particles).

use super::GlobalCalendar;
use crate::encounter::AtWall;
use crate::scene::Scene;
use crate::walls::{NearWalls, Wall};
use std::ops::Range;

/// All contacts that a sphere may have with the walls of a scene, in the order of the walls, and a search for walls
/// near a point. A wall may have several contacts with a sphere, such as one for each side of a box.
#[derive(Clone, Debug, Default)]
pub struct WallContacts {
    /// The contacts; events refer to them by their number in this list.
    pub contacts: Vec<AtWall>,
    /// Range of contact numbers of each wall. The contacts of all walls are numbered one after the other.
    of: Vec<Range<u32>>,
    /// Search structure for the walls near a position.
    pub near: NearWalls,
}

impl WallContacts {
    /// Lists the contacts with the walls of a scene.
    pub fn of(scene: &Scene) -> Self {
        let (mut contacts, mut of) = (Vec::new(), Vec::new());
        for (wall, shape) in (0u32..).zip(&scene.walls) {
            let first = contacts.len() as u32;
            contacts.extend((0..shape.geometry.contacts()).map(|which| AtWall { wall, which }));
            of.push(first..contacts.len() as u32);
        }
        Self { contacts, of, near: NearWalls::of(&scene.walls) }
    }

    /// Range of contact numbers that belong to a wall.
    pub fn of_wall(&self, wall: u32) -> Range<u32> {
        self.of[wall as usize].clone()
    }
}

impl GlobalCalendar {
    /// Time [s] from the instant of a wall to the present; 0 for a wall that does not move.
    #[inline]
    pub(super) fn ahead(&self, wall: &Wall) -> f64 {
        wall.moving.as_ref().map_or(0.0, |moving| self.epoch + self.now - moving.time())
    }

    /// Largest distance [m] by which a wall moves from the place of its instant until the end of the epoch (time from one
    /// zero of the calendar's time to the next).
    pub(super) fn travel(&self, wall: &Wall) -> f64 {
        wall.moving.as_ref().map_or(0.0, |moving| moving.travel(self.epoch + self.limit - moving.time()))
    }
}
