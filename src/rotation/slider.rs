//! Spring, dashpot and slider of a contact: sliding, rolling and twisting alike.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Quantity that a contact remembers while its stiffness changes with the overlap. Only the first rule never creates
/// energy in a closed cycle of pressing and shearing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SpringHistory {
    /// The force while the contact is pressed, dF = k(δ) dξ. While the contact is unloaded, the force also falls in
    /// proportion to k (Elata and Berryman 1996, Mech. Mater. 24, 229; Thornton et al. 2013, Powder Technol. 233, 30).
    #[default]
    Rescaled,
    /// The force: dF = k(δ) dξ at all times.
    Force,
    /// The displacement: F = k(δ) ξ at all times.
    Displacement,
}

/// Constants of a spring beside a dashpot, with a slider that limits their force, between two given bodies. Stiffness 0
/// means friction without memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SpringDashpotSlider {
    /// [kg] effective mass of the relative motion that stretches the spring, M_t of a slip; 0 of spheres that do not
    /// rotate.
    pub mass: f64,
    /// [N/m] stiffness k at an overlap δ of 1 m.
    pub stiffness: f64,
    /// [N s/m] dashpot c at an overlap of 1 m.
    pub dashpot: f64,
    /// 2n, where k grows as δ^n and c as the root of k: 0 of constants that do not depend on the overlap.
    pub half_powers: u8,
    /// Quantity remembered while the stiffness changes.
    pub history: SpringHistory,
}

/// Rates [1/s] by which a changing overlap changes a spring without slip.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpringRates {
    /// -ξ'/ξ: shear given up so that the force keeps its value.
    pub forgotten: f64,
    /// F'/F of the force k ξ.
    pub force: f64,
    /// c'/c.
    pub dashpot: f64,
}

impl SpringDashpotSlider {
    /// [N] largest tangential force, from the `friction` μ [-] and the normal force [N]: μ max(f_n, 0).
    #[inline(always)]
    pub fn limit(friction: f64, normal_force: f64) -> f64 {
        friction * normal_force.max(0.0)
    }

    /// Friction without memory, for a relative motion of that effective mass [kg].
    pub fn without_memory(mass: f64) -> Self {
        Self { mass, ..Self::default() }
    }

    /// Constants at overlap δ [m].
    #[inline(always)]
    pub fn at(&self, overlap: f64) -> Self {
        if self.half_powers == 0 {
            return *self;
        }
        let factor = overlap.abs().sqrt().powi(i32::from(self.half_powers));
        Self { stiffness: self.stiffness * factor, dashpot: self.dashpot * factor.sqrt(), ..*self }
    }

    /// Factors a and b [-] of the new shear, a times the shear before the step plus b times the slip in the step. The
    /// overlap goes evenly from `before` to `after` [m]. If the law remembers the force F = k ξ, F keeps its value as k
    /// changes, and the slip adds to it with the mean stiffness of the step.
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
        // with r² = before/after the mean of k over k(after) is 2/(m+2) (1 + r + ... + r^(m+1))/(1 + r)
        let ratio = (before.max(0.0) / after).sqrt();
        let powers = i32::from(self.half_powers);
        let sum: f64 = (0..powers + 2).map(|power| ratio.powi(power)).sum();
        (ratio.powi(powers), 2.0 * sum / (f64::from(powers + 2) * (1.0 + ratio)))
    }

    /// Rates of the spring while the overlap changes at the relative rate `rate` δ'/δ [1/s].
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

    /// [J] energy of the spring stretched by `shear` ξ [m]: k_t ξ²/2.
    #[inline(always)]
    pub fn energy(&self, shear: &Vector3<f64>) -> f64 {
        0.5 * self.stiffness * shear.norm_squared()
    }

    /// [N] force F of spring and dashpot at shear ξ [m] and slip s [m/s]; on particle i acts -F.
    #[inline(always)]
    pub fn force(&self, shear: &Vector3<f64>, slip: &Vector3<f64>) -> Vector3<f64> {
        shear * self.stiffness + slip * self.dashpot
    }

    /// [m] length of the spring of a contact that slides along the unit vector e at a force limit [N], for a slip
    /// `along` s·e [m/s]: spring and dashpot together give the limit, and the spring is never stretched against the
    /// force (Luding 2008, Granular Matter 10, 235).
    #[inline(always)]
    pub fn sliding_length(&self, limit: f64, along: f64) -> f64 {
        let force = (limit - self.dashpot * along).max(0.0);
        if force > 0.0 { force / self.stiffness } else { 0.0 }
    }

    /// Force F [N] at the end of a step, limited, and the shear ξ [m] that is left in the spring.
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

/// The shear ξ [m] turned into the plane normal to `normal`, with its length kept, and about the normal by a small
/// `angle` [rad] of a step.
#[inline(always)]
pub fn turned(shear: &Vector3<f64>, normal: &Vector3<f64>, angle: f64) -> Vector3<f64> {
    let square = shear.norm_squared();
    if square == 0.0 {
        return *shear;
    }
    let along = shear.dot(normal);
    // 1/sqrt(1 - x) of the part x of its square that the shear loses
    let lost = along * along / square;
    let stretch = if lost < 1e-3 { 1.0 + lost * (0.5 + 0.375 * lost) } else { 1.0 / (1.0 - lost).max(1e-12).sqrt() };
    let flat = (shear - normal * along) * stretch;
    // the turn by 2 arctan(angle/2), which differs from the angle by its third power over twelve
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
        // the dashpot alone is beyond the limit: no stretch against the force is left
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
