//! Solid bodies inside the domain; the only file that names parry.

use super::{Flight, Geometry, Nearest};
use nalgebra::Vector3;

/// Placeholder.
#[derive(Clone, Debug)]
pub struct Obstacle {}

impl Obstacle {
    /// A solid ball: centre [m], radius [m].
    pub fn sphere(_center: Vector3<f64>, _radius: f64) -> Self {
        Self {}
    }

    /// A solid block along the axes: centre [m], half its edges [m].
    pub fn cuboid(_center: Vector3<f64>, _half_extents: Vector3<f64>) -> Self {
        Self {}
    }

    /// A solid cylinder along axis 0, 1 or 2: centre [m], radius [m], half its length [m].
    pub fn cylinder(_center: Vector3<f64>, _axis: usize, _radius: f64, _half_height: f64) -> Self {
        Self {}
    }
}

impl Geometry for Obstacle {
    fn nearest(&self, _point: &Vector3<f64>) -> Nearest {
        Nearest { distance: f64::INFINITY, normal: Vector3::y() }
    }

    fn touch_time(&self, _flight: &Flight, _radius: f64, _until: f64) -> Option<f64> {
        None
    }
}
