//! Spring, dashpot and slider of a contact, used for sliding, rolling and twisting.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Quantity that a contact stores of its tangential spring, whose stiffness changes with the overlap: the force, or the
/// shear. Only [`Rescaled`](Self::Rescaled) creates no energy in any closed cycle of pressing and shearing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SpringHistory {
    /// The force F while the overlap grows: dF = k(δ) dξ, with the stiffness k, overlap δ and shear ξ. While the
    /// overlap decreases, F also decreases in proportion to k (Elata and Berryman 1996, Mech. Mater. 24, 229; Thornton
    /// et al. 2013, Powder Technol. 233, 30).
    #[default]
    Rescaled,
    /// The force F at all times: dF = k(δ) dξ, with the stiffness k, overlap δ and shear ξ.
    Force,
    /// The displacement (shear) ξ at all times: F = k(δ) ξ, with the force F, stiffness k and overlap δ.
    Displacement,
}

/// Constants of a spring parallel to a dashpot, with a slider that limits their total force, between two given bodies.
/// These constants describe friction with memory, or friction without memory if the stiffness is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SpringDashpotSlider {
    /// [kg] effective mass of the relative motion that stretches the spring; M_t for a slip, 0 for spheres that do not
    /// rotate.
    pub mass: f64,
    /// [N/m] stiffness k of the spring at an overlap δ of 1 m.
    pub stiffness: f64,
    /// [N s/m] constant c of the dashpot at an overlap of 1 m.
    pub dashpot: f64,
    /// [-] 2n, if the stiffness k is proportional to δ^n, with the overlap δ, and the dashpot constant c to δ^(n/2). It
    /// is 0 if k and c do not depend on the overlap.
    pub half_powers: u8,
    /// Quantity that the contact stores of its spring while the stiffness changes: force or shear.
    pub history: SpringHistory,
}

/// Relative rates [1/s] at which a changing overlap changes the spring and the dashpot of a contact while its surfaces
/// do not slip.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpringRates {
    /// [1/s] -ξ'/ξ: relative rate at which the shear ξ decreases so that the force stays constant. The prime denotes
    /// the rate of change.
    pub forgotten: f64,
    /// [1/s] F'/F: relative rate of change of the force F = k ξ of the spring, with the stiffness k and the shear ξ.
    /// The prime denotes the rate of change.
    pub force: f64,
    /// [1/s] c'/c: relative rate of change (denoted by the prime) of the dashpot constant c.
    pub dashpot: f64,
}

impl SpringDashpotSlider {
    /// [N] largest tangential force μ max(f_n, 0) of a contact, from the friction coefficient μ [-] and the normal
    /// force f_n [N].
    #[inline(always)]
    pub fn limit(friction: f64, normal_force: f64) -> f64 {
        friction * normal_force.max(0.0)
    }

    /// Constants of friction without memory. `mass` [kg] is the effective mass of the relative motion of the surfaces.
    pub fn without_memory(mass: f64) -> Self {
        Self { mass, ..Self::default() }
    }

    /// Returns the constants with the stiffness and the dashpot that the spring has at the overlap `overlap` [m].
    #[inline(always)]
    pub fn at(&self, overlap: f64) -> Self {
        if self.half_powers == 0 {
            return *self;
        }
        let factor = overlap.abs().sqrt().powi(i32::from(self.half_powers));
        Self { stiffness: self.stiffness * factor, dashpot: self.dashpot * factor.sqrt(), ..*self }
    }

    /// Factors a and b [-] that give the shear after a step: a times the shear before the step, plus b times the
    /// distance slipped in the step. In the step the overlap changes evenly from `before` to `after` [m]. If the
    /// contact stores the force F = k ξ (stiffness times shear), F stays constant as k changes. The distance slipped
    /// then adds to F with the mean stiffness of the step.
    #[inline(always)]
    pub fn growth(&self, before: f64, after: f64) -> (f64, f64) {
        let keeps_force = match self.history {
            SpringHistory::Displacement => false,
            SpringHistory::Force => true,
            SpringHistory::Rescaled => after > before,
        };
        if self.half_powers == 0 || !keeps_force || after <= 0.0 {
            return (1.0, 1.0);
        }
        // with r² = before/after and m = `half_powers`, the mean of k over k(after) is 2/(m+2) (1 + r + ... +
        // r^(m+1))/(1 + r)
        let ratio = (before.max(0.0) / after).sqrt();
        let powers = i32::from(self.half_powers);
        let sum: f64 = (0..powers + 2).map(|power| ratio.powi(power)).sum();
        (ratio.powi(powers), 2.0 * sum / (f64::from(powers + 2) * (1.0 + ratio)))
    }

    /// Relative rates [1/s] of the spring and the dashpot, while the overlap δ changes at the relative rate `rate` =
    /// δ'/δ [1/s].
    #[inline(always)]
    pub fn rates(&self, rate: f64) -> SpringRates {
        if self.half_powers == 0 {
            return SpringRates::default();
        }
        let stiffness = 0.5 * f64::from(self.half_powers) * rate;
        let forgotten = match self.history {
            SpringHistory::Displacement => 0.0,
            SpringHistory::Force => stiffness,
            SpringHistory::Rescaled => stiffness.max(0.0),
        };
        SpringRates { forgotten, force: stiffness - forgotten, dashpot: 0.5 * stiffness }
    }

    /// [J] energy k ξ²/2 of the spring with the shear ξ [m] and the stiffness k.
    #[inline(always)]
    pub fn energy(&self, shear: &Vector3<f64>) -> f64 {
        0.5 * self.stiffness * shear.norm_squared()
    }

    /// [N] force F = k ξ + c s of spring and dashpot, with the stiffness k, the shear ξ [m], the dashpot constant c and
    /// the slip s [m/s]. The force on particle i is -F.
    #[inline(always)]
    pub fn force(&self, shear: &Vector3<f64>, slip: &Vector3<f64>) -> Vector3<f64> {
        shear * self.stiffness + slip * self.dashpot
    }

    /// [m] length of the spring of a contact that slides. `limit` [N] is the largest total force. `along` [m/s] is the
    /// component of the slip along the direction of sliding. At this length, the forces of spring and dashpot add up to
    /// the limit. The spring does not pull against the direction of sliding (Luding 2008, Granular Matter 10, 235).
    #[inline(always)]
    pub fn sliding_length(&self, limit: f64, along: f64) -> f64 {
        let force = (limit - self.dashpot * along).max(0.0);
        if force > 0.0 { force / self.stiffness } else { 0.0 }
    }

    /// Force F [N] of spring and dashpot at the end of a step, at most `limit` [N], and the shear [m] of the spring
    /// after the limit is applied. `shear` [m] is the shear before, and `slip` [m/s] the slip.
    #[inline(always)]
    pub fn limited(&self, shear: Vector3<f64>, slip: &Vector3<f64>, limit: f64) -> (Vector3<f64>, Vector3<f64>) {
        let force = self.force(&shear, slip);
        let square = force.norm_squared();
        if square <= limit * limit {
            return (force, shear);
        }
        let along = force / square.sqrt();
        (along * limit, along * self.sliding_length(limit, slip.dot(&along)))
    }
}

/// [m] shear of a spring after the normal of its contact has turned. The shear is first turned into the plane
/// perpendicular to `normal`, with its length unchanged. It is then turned about the normal by the small `angle` [rad]
/// by which the contact turns in a step.
#[inline(always)]
pub fn turned(shear: &Vector3<f64>, normal: &Vector3<f64>, angle: f64) -> Vector3<f64> {
    let square = shear.norm_squared();
    if square == 0.0 {
        return *shear;
    }
    let along = shear.dot(normal);
    // factor 1/sqrt(1 - x), where x is the share of the squared length that the shear loses by the projection
    let lost = along * along / square;
    let stretch = if lost < 1e-3 { 1.0 + lost * (0.5 + 0.375 * lost) } else { 1.0 / (1.0 - lost).max(1e-12).sqrt() };
    let flat = (shear - normal * along) * stretch;
    // the turn is by 2 arctan(angle/2), which differs from the angle by a twelfth of its third power
    let half = 0.5 * angle;
    let per_turn = 1.0 / (1.0 + half * half);
    (flat * (1.0 - half * half) + normal.cross(&flat) * (2.0 * half)) * per_turn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spring_beyond_its_limit_slides_and_gives_the_limit() {
        let spring = SpringDashpotSlider { mass: 1.0, stiffness: 10.0, dashpot: 2.0, ..SpringDashpotSlider::default() };
        let (shear, slip) = (Vector3::new(0.3, 0.0, 0.4), Vector3::new(0.6, 0.0, 0.8));
        let (force, left) = spring.limited(shear, &slip, 4.0);
        assert!((force.norm() - 4.0).abs() < 1e-14);
        assert!((spring.force(&left, &slip) - force).norm() < 1e-14);
        // the dashpot alone exceeds the limit, so no stretch against the force remains
        let (force, left) = spring.limited(shear, &slip, 1.0);
        assert!((force.norm() - 1.0).abs() < 1e-14 && left == Vector3::zeros());
        assert_eq!(spring.limited(shear, &slip, 100.0), (spring.force(&shear, &slip), shear));
    }

    #[test]
    fn a_turned_spring_keeps_its_length() {
        let (shear, normal) = (Vector3::new(1.0, 0.2, 0.0), Vector3::y());
        let about = turned(&shear, &normal, 2.0);
        assert!((about.norm() - shear.norm()).abs() < 1e-15 && about.dot(&normal).abs() < 1e-15);
        assert!((about.normalize() - Vector3::new(0.0, 0.0, -1.0)).norm() < 1e-15, "right-handed about the normal");
        let small = turned(&Vector3::new(1.0, 1e-3, 0.0), &normal, 1e-3);
        assert!((small.norm_squared() - 1.0 - 1e-6).abs() < 1e-14 && (small.z + 1e-3).abs() < 1e-9);
    }
}
