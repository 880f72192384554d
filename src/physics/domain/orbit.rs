//! Circular orbit of a sheared box: the box rotates about x, and tides act on its particles.

use nalgebra::Vector3;
use serde::Serialize;

/// Orbit of a sheared box about a distant mass, in Hill's approximation (Wisdom and Tremaine 1988, Astron. J. 95, 925).
///
/// The box rotates about x at the rate Ω. The axis y points away from the mass, and z along the orbit. In the rotating
/// frame, the Coriolis force and the tide along y accelerate a particle: dv_y/dt = 2 Ω (v_z - γ y) and dv_z/dt = -2 Ω
/// v_y. So the mean flow γ y with the shear rate γ is itself a free motion. The vertical acceleration is dv_x/dt = -ν²
/// (x - L_x/2), with the frequency ν of vertical oscillations and the edge length L_x along x.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Orbit {
    /// [rad/s] angular velocity Ω of the orbit about x. Around a point mass the shear rate is γ = -3/2 Ω.
    pub rate: f64,
    /// [rad/s] frequency ν of free oscillations along x about the middle of the box. Around a point mass it is the
    /// angular velocity Ω of the orbit.
    pub vertical_frequency: f64,
}

impl Orbit {
    /// [1/s²] square κ² = 2 Ω (2 Ω + γ) of the frequency of free oscillations in the plane of the orbit, in a box with
    /// the shear rate γ `shear` [1/s]. If it is negative, free motion is unstable (Rayleigh's criterion).
    pub fn square_of_epicyclic_frequency(&self, shear: f64) -> f64 {
        2.0 * self.rate * (2.0 * self.rate + shear)
    }

    /// [rad/s] fastest rate at which the forces of the orbit change velocities: the larger of 2 |Ω| and ν.
    pub fn fastest(&self) -> f64 {
        (2.0 * self.rate).abs().max(self.vertical_frequency)
    }

    /// [m/s] change of the velocity of a particle in `duration` [s] by the forces of the orbit, at a constant place.
    /// `height` [m] is the distance x - L_x/2 from the middle of the box, and `velocity` [m/s] the velocity relative to
    /// the mean flow. The change is the exact solution for a constant place: velocities turn in the plane of the orbit.
    pub fn kick(&self, height: f64, velocity: &Vector3<f64>, duration: f64) -> Vector3<f64> {
        let (sin, cos) = (2.0 * self.rate * duration).sin_cos();
        let less = 1.0 - cos;
        Vector3::new(
            -self.vertical_frequency.powi(2) * height * duration,
            velocity.z * sin - velocity.y * less,
            -velocity.y * sin - velocity.z * less,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A kick turns velocities in the plane of the orbit and keeps their magnitude.
    #[test]
    fn a_kick_turns_velocities() {
        let orbit = Orbit { rate: 0.5, vertical_frequency: 0.0 };
        let velocity = Vector3::new(1.0, 2.0, 3.0);
        let after = velocity + orbit.kick(7.0, &velocity, std::f64::consts::FRAC_PI_2);
        assert!((after - Vector3::new(1.0, 3.0, -2.0)).norm() < 1e-15, "{after}");
    }

    /// Around a point mass, the angular velocity of the orbit and the frequencies of both oscillations are equal.
    #[test]
    fn orbits_about_a_point_mass_are_closed() {
        let orbit = Orbit { rate: 2.0, vertical_frequency: 2.0 };
        assert_eq!(orbit.square_of_epicyclic_frequency(-3.0), 4.0);
        assert!(orbit.square_of_epicyclic_frequency(-5.0) < 0.0);
    }
}
