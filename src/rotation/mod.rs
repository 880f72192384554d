//! Rotation of spheres: the tangential law of contacts that last, and the rule of instantaneous impacts that belongs to
//! it.
//!
//! Conventions (docs/rotation.md):
//! - the normal n points from the other body to particle i;
//! - the slip is s = u_t - (l_i ω_i + l_j ω_j) × n, with the tangential relative velocity u_t of the centres and the
//!   lever arms l;
//! - the tangential force on particle i is -F, and the torque on either particle is l n × F.
//!
//! This module holds only parameters and formulas; the engines apply them.

mod impact;
mod rebound;
mod rolling;
mod slider;
mod tangential;

pub use impact::{ImpactKind, ImpactRule, ObliqueApproach};
pub use rebound::{ObliqueImpact, ReboundTable};
pub use rolling::{Resistance, ResistanceFriction, RollingBodies, RollingLaw, TwistingLaw};
pub use slider::{SpringDashpotSlider, SpringHistory, SpringRates, turned};
pub use tangential::{LinearTangential, NormalSpring, TangentialLaw};

use nalgebra::Vector3;
use serde::Serialize;

/// [-] moment of inertia of a solid sphere over m r² (any textbook of mechanics: 2/5).
pub const SOLID_SPHERE: f64 = 0.4;

/// [-] moment of inertia of a thin shell over m r² (any textbook of mechanics: 2/3), the largest that a sphere can
/// have.
pub const THIN_SHELL: f64 = 2.0 / 3.0;

/// Tangential behaviour of spheres that rotate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rotation {
    /// Law of contacts that last (soft and hybrid models).
    pub tangential: TangentialLaw,
    /// Rule of instantaneous impacts (hard and hybrid models).
    pub impact: ImpactRule,
    /// Rolling resistance of contacts that last.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rolling: Option<RollingLaw>,
    /// Twisting resistance of contacts that last.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub twisting: Option<TwistingLaw>,
}

impl Rotation {
    /// Rotation without rolling and twisting resistance.
    pub fn new(tangential: TangentialLaw, impact: ImpactRule) -> Self {
        Self { tangential, impact, rolling: None, twisting: None }
    }

    /// True if contacts that last resist rolling or twisting.
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

/// [kg] effective mass M_t of the slip of two bodies: 1/M_t = Σ (1/m)(1 + m r²/I), from mass m [kg], radius r [m] and
/// moment of inertia I [kg m²] of each. A wall has none. For two solid spheres M_t = (2/7) M.
pub fn tangential_mass(bodies: impl IntoIterator<Item = (f64, f64, f64)>) -> f64 {
    let mobility = |(mass, radius, inertia): (f64, f64, f64)| 1.0 / mass + radius * radius / inertia;
    1.0 / bodies.into_iter().map(mobility).sum::<f64>()
}

/// [m/s] slip of particle i against the other body, along the surface: s = u_t - w × n. `velocity` is u_i - u_j [m/s],
/// `normal` n points to particle i, and `surface` is w = l_i ω_i + l_j ω_j [m/s].
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
        // towards +x on a floor a ball of radius r turns by -v/r about z
        let surface = Vector3::new(0.0, 0.0, -1.0);
        assert!(slip(&velocity, &normal, &surface).norm() < 1e-15);
    }
}
