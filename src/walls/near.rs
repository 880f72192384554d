//! Search for the walls near a point.

use super::mesh::Tree;
use super::{Nearest, Wall};
use nalgebra::Vector3;

/// Number of boxes from which a tree of boxes is used; with fewer, each wall is tested in turn.
const MANY: usize = 8;

/// The walls of a scene in a tree of the boxes around them: hundreds of bodies, such as the pins of a board, are then
/// not tested one by one.
#[derive(Clone, Default)]
pub struct NearWalls {
    /// Walls that are always tested: planes, vessels, and all walls where there are few.
    always: Vec<u32>,
    /// Walls of the boxes in the tree, in the order of the boxes.
    boxed: Vec<u32>,
    tree: Option<Tree>,
}

impl NearWalls {
    /// A search structure for the walls of a scene.
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

    /// Calls `visit` with every wall whose surface may be within `reach` [m] of a point [m], and with some others;
    /// possibly more than once with a body that has images.
    #[inline]
    pub fn for_each(&self, point: &Vector3<f64>, reach: f64, mut visit: impl FnMut(u32)) {
        self.always.iter().copied().for_each(&mut visit);
        if let Some(tree) = &self.tree {
            tree.for_each_near(point, reach, |number| visit(self.boxed[number as usize]));
        }
    }

    /// Puts into `found` the walls whose surface may be within `reach` [m] of a point [m], and some others, in
    /// ascending order.
    pub fn list(&self, point: &Vector3<f64>, reach: f64, found: &mut Vec<u32>) {
        found.clear();
        self.for_each(point, reach, |wall| found.push(wall));
        if !self.are_few() {
            found.sort_unstable();
            found.dedup();
        }
    }

    /// Calls `visit` with the nearest point of every one of the `walls` that a sphere of `radius` [m] about `point`
    /// [m] may touch or lie behind, and of some others.
    pub fn for_each_nearest(
        &self,
        walls: &[Wall],
        point: &Vector3<f64>,
        radius: f64,
        mut visit: impl FnMut(u32, Nearest),
    ) {
        let mut ask = |wall: u32| {
            let shape = &walls[wall as usize].geometry;
            // for a plane the nearest point is as quick as the test
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

    /// True if all walls are always tested, in their order.
    #[inline]
    pub fn are_few(&self) -> bool {
        self.tree.is_none()
    }

    /// Approximate number of tests for one point.
    pub fn asked(&self) -> usize {
        self.always.len() + usize::from(self.tree.is_some())
    }
}

impl std::fmt::Debug for NearWalls {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} walls, and {} boxes in a tree", self.always.len(), self.boxed.len())
    }
}
