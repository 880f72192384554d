//! Motion of the surface of a wall at the point where a particle touches the wall.

use crate::walls::Wall;
use nalgebra::Vector3;

/// Motion of the surface of a wall at a contact point. The surface moves if the wall itself moves, and also if it
/// slides along itself, as a conveyor belt does.
#[derive(Clone, Copy, Debug, Default)]
pub struct WallMotion {
    /// [m/s] velocity of the surface at the contact point.
    pub velocity: Vector3<f64>,
    /// [rad/s] angular velocity of the surface of the wall; zero if the surface does not turn.
    pub spin: Vector3<f64>,
    /// [m/s] part of `velocity` that comes from a motion of the wall's shape. It is zero for a conveyor belt, whose
    /// surface moves but whose shape is at rest.
    pub carried: Vector3<f64>,
    /// [m/s²] rate at which `velocity` changes at a fixed point of space; zero for a steady rotation.
    pub acceleration: Vector3<f64>,
    /// [m/s²] centripetal acceleration of the shape at the contact point; zero if the shape does not turn.
    pub centripetal: Vector3<f64>,
}

impl WallMotion {
    /// Motion of the surface of a wall at `point` [m]. It is computed for the time `ahead` [s] after the time for which
    /// the scene stores the place of the wall.
    pub fn of(wall: &Wall, point: &Vector3<f64>, ahead: f64) -> Self {
        let (velocity, spin) = (wall.surface_velocity(point, ahead), wall.spin().unwrap_or_default());
        let Some(moving) = &wall.moving else { return Self { velocity, spin, ..Self::default() } };
        let (motion, time) = (moving.motion(), moving.time() + ahead);
        let carried = motion.velocity(point, time);
        let centripetal = motion.spin().map_or_else(Vector3::zeros, |spin| spin.cross(&carried));
        Self { velocity, spin, carried, acceleration: motion.acceleration(time), centripetal }
    }

    /// [m/s²] acceleration with which the wall pushes a particle that rests on it, in the direction of the normal.
    /// Negative values mean that the particle leaves the wall. `normal` is the unit vector from the wall to the
    /// particle, and `gravity` [m/s²] the acceleration of the particle by gravity.
    pub fn pressing(&self, gravity: &Vector3<f64>, normal: &Vector3<f64>) -> f64 {
        (self.acceleration + self.centripetal - gravity).dot(normal)
    }

    /// Returns the motion of the surface `time` [s] later. Only the velocity changes, at the constant `acceleration`.
    #[inline(always)]
    pub fn later(self, time: f64) -> Self {
        Self { velocity: self.velocity + self.acceleration * time, ..self }
    }

    /// [W] power that the wall gives to the particle. `force` [N] and `couple` [N m] are the force and the torque of
    /// the wall on the particle. `couple` is `None` if there is no torque.
    #[inline(always)]
    pub fn power(&self, force: &Vector3<f64>, couple: Option<&Vector3<f64>>) -> f64 {
        force.dot(&self.velocity) + couple.map_or(0.0, |couple| couple.dot(&self.spin))
    }
}
