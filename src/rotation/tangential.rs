//! Tangential laws of contacts that last.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Law of the tangential force of a contact that lasts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TangentialLaw {
    /// Coulomb's law without memory: μ |f_n| against the slip, but never more than stops it within a step.
    Coulomb,
    /// A linear spring beside a linear dashpot, together at most μ max(f_n, 0) (Cundall and Strack 1979, Géotechnique
    /// 29, 47).
    Linear(LinearTangential),
}

/// Constants of the linear tangential law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LinearTangential {
    /// Spring and dashpot in units of the normal ones.
    Ratios {
        /// [-] κ = k_t/k_n.
        stiffness: f64,
        /// [-] c_t/c_n.
        dashpot: f64,
    },
    /// [-] β_0, 0 < β_0 <= 1, of impacts that stick: spring and dashpot swing for half a period in the contact time
    /// (equal half periods; Deen et al. 2007, Chem. Eng. Sci. 62, 28).
    Restitution(f64),
}

/// Constants of a tangential law between two given bodies. A stiffness of 0 means Coulomb's law without memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TangentialSpring {
    /// [kg] effective mass M_t of the slip; 0 of spheres that do not rotate.
    pub mass: f64,
    /// [N/m] k_t.
    pub stiffness: f64,
    /// [N s/m] c_t.
    pub dashpot: f64,
}

/// Normal contact of two bodies as a tangential law needs it.
#[derive(Clone, Copy, Debug)]
pub struct NormalSpring {
    /// [N/m] k_n.
    pub stiffness: f64,
    /// [N s/m] c_n.
    pub dashpot: f64,
    /// [s] contact time T_c.
    pub contact_time: f64,
}

impl TangentialLaw {
    /// Constants between two bodies with an effective mass `mass` M_t [kg] of their slip.
    pub fn between(&self, normal: impl FnOnce() -> NormalSpring, mass: f64) -> TangentialSpring {
        match self {
            Self::Coulomb => TangentialSpring { mass, ..TangentialSpring::default() },
            Self::Linear(LinearTangential::Ratios { stiffness, dashpot }) => {
                let normal = normal();
                TangentialSpring { mass, stiffness: stiffness * normal.stiffness, dashpot: dashpot * normal.dashpot }
            }
            Self::Linear(LinearTangential::Restitution(restitution)) => {
                let (time, ln) = (normal().contact_time, restitution.ln());
                // γ = -ln β_0/T_c and k_t/M_t - γ² = (π/T_c)²
                let (stiffness, dashpot) = (mass * (PI * PI + ln * ln) / (time * time), -2.0 * mass * ln / time);
                TangentialSpring { mass, stiffness, dashpot }
            }
        }
    }

    /// True if contacts remember how far they have been sheared.
    pub fn has_memory(&self) -> bool {
        !matches!(self, Self::Coulomb)
    }
}

impl std::fmt::Display for TangentialLaw {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Coulomb => write!(f, "friction without memory"),
            Self::Linear(LinearTangential::Ratios { stiffness, dashpot }) => {
                write!(f, "a tangential spring of {stiffness} times the normal stiffness")?;
                if *dashpot > 0.0 { write!(f, " and a dashpot of {dashpot} times the normal one") } else { Ok(()) }
            }
            Self::Linear(LinearTangential::Restitution(restitution)) => {
                write!(f, "a tangential spring and dashpot for a tangential restitution of {restitution}")
            }
        }
    }
}

impl TangentialSpring {
    /// [N] largest tangential force, from the `friction` μ [-] and the normal force [N]: μ max(f_n, 0).
    #[inline(always)]
    pub fn limit(friction: f64, normal_force: f64) -> f64 {
        friction * normal_force.max(0.0)
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
        (limit - self.dashpot * along).max(0.0) / self.stiffness
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
        let spring = TangentialSpring { mass: 1.0, stiffness: 10.0, dashpot: 2.0 };
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
