//! Which of many walls are near a place.

use super::mesh::Tree;
use super::{Nearest, Wall};
use nalgebra::Vector3;

/// Bodies from which on a tree of boxes is asked; below, each is asked in turn.
const MANY: usize = 8;

/// The walls of a scene in a tree of the boxes around them: hundreds of bodies, such as the pins of a board, are not asked one by one whether they are near.
#[derive(Clone, Default)]
pub struct NearWalls {
    /// Walls that are asked always: planes, vessels, and all where there are few.
    always: Vec<u32>,
    /// The others, in the order of their boxes.
    boxed: Vec<u32>,
    tree: Option<Tree>,
}

impl NearWalls {
    /// Of the walls of a scene.
    pub fn of(walls: &[Wall]) -> Self {
        let numbered = || (0u32..).zip(walls);
        let mut boxes = Vec::new();
        let (mut always, mut boxed) = (Vec::new(), Vec::new());
        for (wall, shape) in numbered() {
            let around = shape.geometry.boxes();
            if around.is_empty() {
                always.push(wall);
            }
            boxed.extend(around.iter().map(|_| wall));
            boxes.extend(around);
        }
        if boxes.len() < MANY {
            return Self { always: numbered().map(|(wall, _)| wall).collect(), boxed: Vec::new(), tree: None };
        }
        Self { always, boxed, tree: Some(Tree::of_boxes(boxes.into_iter())) }
    }

    /// Calls `visit` with every wall whose surface may be within `reach` [m] of a point [m], and with others; of a body with images perhaps more than once.
    #[inline]
    pub fn for_each(&self, point: &Vector3<f64>, reach: f64, mut visit: impl FnMut(u32)) {
        self.always.iter().copied().for_each(&mut visit);
        if let Some(tree) = &self.tree {
            tree.for_each_near(point, reach, |number| visit(self.boxed[number as usize]));
        }
    }

    /// Puts into `found` the walls whose surface may be within `reach` [m] of a point [m], and others, in ascending order.
    pub fn list(&self, point: &Vector3<f64>, reach: f64, found: &mut Vec<u32>) {
        found.clear();
        self.for_each(point, reach, |wall| found.push(wall));
        if !self.are_few() {
            found.sort_unstable();
            found.dedup();
        }
    }

    /// Calls `visit` with the nearest point of every one of the `walls` that a sphere of `radius` [m] about `point` [m] may touch or lie behind, and of
    /// others.
    pub fn for_each_nearest(
        &self,
        walls: &[Wall],
        point: &Vector3<f64>,
        radius: f64,
        mut visit: impl FnMut(u32, Nearest),
    ) {
        let mut ask = |wall: u32| {
            let shape = &walls[wall as usize].geometry;
            // of a plane to know is as quick as to ask
            if shape.is_flat() || !shape.law().is_clear(point, radius) {
                visit(wall, shape.nearest(point));
            }
        };
        if self.are_few() {
            self.always.iter().copied().for_each(ask);
            return;
        }
        let mut found = Vec::new();
        self.list(point, radius, &mut found);
        found.into_iter().for_each(&mut ask);
    }

    /// Whether all walls are asked, in their order.
    #[inline]
    pub fn are_few(&self) -> bool {
        self.tree.is_none()
    }

    /// How many walls are asked, about, for one place.
    pub fn asked(&self) -> usize {
        self.always.len() + usize::from(self.tree.is_some())
    }
}

impl std::fmt::Debug for NearWalls {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} walls, and {} boxes in a tree", self.always.len(), self.boxed.len())
    }
}
