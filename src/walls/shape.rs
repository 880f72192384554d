//! Solid bodies inside the domain; the only file that names parry.

use super::{Flight, Geometry, Nearest};
use nalgebra::Vector3;

/// Placeholder.
#[derive(Clone, Debug)]
pub struct Obstacle {}

impl Geometry for Obstacle {
    fn nearest(&self, _point: &Vector3<f64>) -> Nearest {
        Nearest { distance: f64::INFINITY, normal: Vector3::y() }
    }

    fn touch_time(&self, _flight: &Flight, _radius: f64, _until: f64) -> Option<f64> {
        None
    }
}
