//! Rotation of spheres: tangential laws of soft contacts, and rules for the tangential impulse of hard impacts.
//!
//! Conventions (docs/rotation.md):
//! * The normal n points from the other body to particle i.
//! * The slip is s = u_t - (l_i ω_i + l_j ω_j) × n, with the lever arms l (from the centres to the contact point) and
//!   the spins ω. u_t is the tangential part of the relative velocity of the centres.
//! * The tangential force on particle i is -F, and the torque on each particle is l n × F.
//!
//! This module has only parameters and formulas. The engines apply them.

mod impact;
mod partial_slip;
mod rebound;
mod rolling;
mod slider;
mod tangential;

pub use impact::{ImpactKind, ImpactRule, ObliqueApproach};
pub use partial_slip::PartialSlip;
pub use rebound::{ObliqueImpact, ReboundTable};
pub use rolling::{Resistance, ResistanceFriction, RollingBodies, RollingLaw, TwistingLaw};
pub use slider::{SpringDashpotSlider, SpringHistory, SpringRates, turned};
pub use tangential::{LinearTangential, NormalSpring, TangentialLaw};

use nalgebra::Vector3;
use serde::Serialize;

/// [-] moment of inertia of a solid sphere divided by m r², with mass m and radius r (any textbook of mechanics: 2/5).
pub const SOLID_SPHERE: f64 = 0.4;

/// [-] moment of inertia of a thin shell divided by m r², with mass m and radius r (any textbook of mechanics: 2/3). It
/// is the largest value that a sphere can have.
pub const THIN_SHELL: f64 = 2.0 / 3.0;

/// Laws of spheres that rotate: tangential force, tangential impulse, and resistance to rolling and twisting.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rotation {
    /// Law of the tangential force in soft contacts (soft and hybrid models).
    pub tangential: TangentialLaw,
    /// Rule of the tangential impulse in instantaneous impacts. Such impacts occur in hard and hybrid models, and in
    /// DSMC (direct simulation Monte Carlo, which draws collisions at random).
    pub impact: ImpactRule,
    /// Law of rolling resistance in soft contacts; `None`: no rolling resistance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rolling: Option<RollingLaw>,
    /// Law of twisting resistance in soft contacts; `None`: no twisting resistance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub twisting: Option<TwistingLaw>,
}

impl Rotation {
    /// Makes the laws of rotation without rolling and twisting resistance.
    pub fn new(tangential: TangentialLaw, impact: ImpactRule) -> Self {
        Self { tangential, impact, rolling: None, twisting: None }
    }

    /// True if soft contacts resist rolling or twisting.
    pub fn resists(&self) -> bool {
        self.rolling.is_some() || self.twisting.is_some()
    }
}

impl std::fmt::Display for Rotation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "soft contacts with {}, hard impacts {}", self.tangential, self.impact)?;
        self.rolling.iter().try_for_each(|rolling| write!(f, ", {rolling}"))?;
        self.twisting.iter().try_for_each(|_| write!(f, ", a twisting spring"))
    }
}

/// [kg] effective mass M_t of the slip of two bodies: 1/M_t = Σ (1/m)(1 + m r²/I). Each body is given by its mass m
/// [kg], radius r [m] and moment of inertia I [kg m²]. A wall adds nothing to the sum. For two solid spheres M_t =
/// (2/7) M, with their effective mass M.
pub fn tangential_mass(bodies: impl IntoIterator<Item = (f64, f64, f64)>) -> f64 {
    let mobility = |(mass, radius, inertia): (f64, f64, f64)| 1.0 / mass + radius * radius / inertia;
    1.0 / bodies.into_iter().map(mobility).sum::<f64>()
}

/// [m/s] slip of particle i relative to the other body, along the surface: s = u_t - w × n. `velocity` is u_i - u_j
/// [m/s], and u_t is its tangential part. `normal` n points to particle i. `surface` is w = l_i ω_i + l_j ω_j [m/s],
/// with lever arms l [m] and spins ω [rad/s].
#[inline(always)]
pub fn slip(velocity: &Vector3<f64>, normal: &Vector3<f64>, surface: &Vector3<f64>) -> Vector3<f64> {
    velocity - normal * velocity.dot(normal) - surface.cross(normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solid_spheres_have_two_sevenths_of_the_effective_mass() {
        let solid = |mass: f64, radius: f64| (mass, radius, SOLID_SPHERE * mass * radius * radius);
        let effective = 1.0 / (1.0 / 3.0 + 1.0 / 0.7);
        assert!((tangential_mass([solid(3.0, 0.1), solid(0.7, 0.4)]) / effective - 2.0 / 7.0).abs() < 1e-15);
        assert!((tangential_mass([solid(3.0, 0.1)]) / 3.0 - 2.0 / 7.0).abs() < 1e-15);
    }

    #[test]
    fn a_ball_that_rolls_on_a_floor_does_not_slip() {
        let (normal, velocity) = (Vector3::y(), Vector3::x());
        // a ball of radius r that rolls towards +x on a floor has the spin -v/r about z
        let surface = Vector3::new(0.0, 0.0, -1.0);
        assert!(slip(&velocity, &normal, &surface).norm() < 1e-15);
    }
}
