//! Motion of a wall at a contact.

use crate::walls::Wall;
use nalgebra::Vector3;

/// Motion of the surface of a wall at a contact.
#[derive(Clone, Copy, Debug, Default)]
pub struct WallMotion {
    /// [m/s] velocity at the contact point.
    pub velocity: Vector3<f64>,
    /// [rad/s] angular velocity.
    pub spin: Vector3<f64>,
    /// [m/s] part of `velocity` with which the shape itself moves; zero if only the surface moves along itself.
    pub carried: Vector3<f64>,
    /// [m/s²] rate at which `velocity` changes at one place; zero for a steady rotation.
    pub acceleration: Vector3<f64>,
    /// [m/s²] centripetal acceleration of the shape at the contact point, if the shape turns.
    pub centripetal: Vector3<f64>,
}

impl WallMotion {
    /// Motion of the surface of a wall at `point` [m], `ahead` [s] of the instant of the wall.
    pub fn of(wall: &Wall, point: &Vector3<f64>, ahead: f64) -> Self {
        let (velocity, spin) = (wall.surface_velocity(point, ahead), wall.spin().unwrap_or_default());
        let Some(moving) = &wall.moving else { return Self { velocity, spin, ..Self::default() } };
        let (motion, time) = (moving.motion(), moving.time() + ahead);
        let carried = motion.velocity(point, time);
        let centripetal = motion.spin().map_or_else(Vector3::zeros, |spin| spin.cross(&carried));
        Self { velocity, spin, carried, acceleration: motion.acceleration(time), centripetal }
    }

    /// [m/s²] acceleration that presses a particle at rest on the wall to it, along the unit vector `normal`. It is
    /// negative if the particle leaves the wall. `gravity` [m/s²] is that of the particle.
    pub fn pressing(&self, gravity: &Vector3<f64>, normal: &Vector3<f64>) -> f64 {
        (self.acceleration + self.centripetal - gravity).dot(normal)
    }

    /// The motion `time` [s] later, at constant acceleration.
    #[inline(always)]
    pub fn later(self, time: f64) -> Self {
        Self { velocity: self.velocity + self.acceleration * time, ..self }
    }

    /// [W] power of the moving wall on the particle, by a force [N] and a torque `couple` [N m] on the particle.
    #[inline(always)]
    pub fn power(&self, force: &Vector3<f64>, couple: Option<&Vector3<f64>>) -> f64 {
        force.dot(&self.velocity) + couple.map_or(0.0, |couple| couple.dot(&self.spin))
    }
}
