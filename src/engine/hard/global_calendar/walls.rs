//! The walls of a scene as the calendar asks them.

use crate::encounter::AtWall;
use crate::scene::Scene;
use crate::walls::NearWalls;
use std::ops::Range;

/// All contacts that the walls of a scene may have with a sphere, in the order of the walls, and which walls are near a place.
#[derive(Clone, Debug, Default)]
pub struct WallContacts {
    /// The contacts: events number them.
    pub contacts: Vec<AtWall>,
    /// Those of each wall.
    of: Vec<Range<u32>>,
    /// Which of the walls are near.
    pub near: NearWalls,
}

impl WallContacts {
    /// Of the walls of a scene.
    pub fn of(scene: &Scene) -> Self {
        let (mut contacts, mut of) = (Vec::new(), Vec::new());
        for (wall, shape) in (0u32..).zip(&scene.walls) {
            let first = contacts.len() as u32;
            contacts.extend((0..shape.geometry.contacts()).map(|which| AtWall { wall, which }));
            of.push(first..contacts.len() as u32);
        }
        Self { contacts, of, near: NearWalls::of(&scene.walls) }
    }

    /// The contacts of a wall, by number.
    pub fn of_wall(&self, wall: u32) -> Range<u32> {
        self.of[wall as usize].clone()
    }
}
