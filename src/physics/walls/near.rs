//! Search for the walls of a scene that are near a point.

use super::mesh::Tree;
use super::{Nearest, Wall};
use nalgebra::Vector3;

/// Smallest number of boxes around walls for which a tree is used. With fewer boxes, every wall is tested for every
/// point.
const MANY: usize = 8;

/// Search structure for the walls of a scene: a tree of the boxes around the walls. Among hundreds of bodies, such as
/// the pins of a board, only a few near a point need to be tested.
#[derive(Clone, Default)]
pub struct NearWalls {
    /// Indices of the walls that are tested for every point: planes, vessels (walls around all particles) and walls
    /// that move. Without a tree these are all walls.
    always: Vec<u32>,
    /// Index of the wall to which each box of the tree belongs.
    boxed: Vec<u32>,
    tree: Option<Tree>,
}

impl NearWalls {
    /// Makes the search structure for the walls of a scene.
    pub fn of(walls: &[Wall]) -> Self {
        let numbered = || (0u32..).zip(walls);
        let mut boxes = Vec::new();
        let (mut always, mut boxed) = (Vec::new(), Vec::new());
        for (wall, shape) in numbered() {
            // a wall that moves is tested for every point, because its box is that of one instant
            let around = if shape.moving.is_some() { Vec::new() } else { shape.geometry.boxes() };
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

    /// Calls `visit` with the index of every wall whose surface may be within `reach` [m] of `point` [m]. Some farther
    /// walls are visited too, and a body with periodic images may be visited more than once.
    #[inline]
    pub fn for_each(&self, point: &Vector3<f64>, reach: f64, mut visit: impl FnMut(u32)) {
        self.always.iter().copied().for_each(&mut visit);
        if let Some(tree) = &self.tree {
            tree.for_each_near(point, reach, |number| visit(self.boxed[number as usize]));
        }
    }

    /// Replaces the content of `found` by the indices, in ascending order, of all walls whose surface may be within
    /// `reach` [m] of `point` [m]. The list may contain some farther walls.
    pub fn list(&self, point: &Vector3<f64>, reach: f64, found: &mut Vec<u32>) {
        found.clear();
        self.for_each(point, reach, |wall| found.push(wall));
        if !self.are_few() {
            found.sort_unstable();
            found.dedup();
        }
    }

    /// Calls `visit` with the index and the nearest point of every wall that a sphere touches or has passed through.
    /// Some farther walls are visited too. The sphere has its centre at `point` [m] and the radius `radius` [m].
    pub fn for_each_nearest(
        &self,
        walls: &[Wall],
        point: &Vector3<f64>,
        radius: f64,
        mut visit: impl FnMut(u32, Nearest),
    ) {
        let mut ask = |wall: u32| {
            let shape = &walls[wall as usize].geometry;
            // for a plane, the nearest point costs no more than the test
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

    /// True if the walls are few: there is no tree, and all walls are tested in the order of their indices.
    #[inline]
    pub fn are_few(&self) -> bool {
        self.tree.is_none()
    }

    /// Approximate number of walls tested for one point; a search in the tree counts as one test.
    pub fn asked(&self) -> usize {
        self.always.len() + usize::from(self.tree.is_some())
    }
}

impl std::fmt::Debug for NearWalls {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} walls, and {} boxes in a tree", self.always.len(), self.boxed.len())
    }
}
