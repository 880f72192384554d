//! Rolling and twisting resistance of soft contacts: equal and opposite torques on two bodies, without a force on their
//! centres.
//!
//! R_eff is the effective radius, and the normal n points to particle i. The surfaces roll on one another with the
//! velocity v = R_eff (ω_i - ω_j) × n (Luding 2008, Granular Matter 10, 235). They twist with the velocity R_eff (ω_i -
//! ω_j)·n along n. A resistance f [N] against this motion gives a couple, the torque R_eff f. Hard impacts have no such
//! resistance, because an impact takes no time.

use super::slider::SpringDashpotSlider;
use super::tangential::NormalSpring;
use serde::{Deserialize, Serialize};

/// Law of rolling resistance, of the types A to C of Ai et al. (2011, Powder Technol. 206, 269). The torque of types A
/// and C is at most μ_r R_eff max(f_n, 0), with the normal force f_n. The torque of type B is proportional to R_eff
/// max(f_n, 0) and to the rolling speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RollingLaw {
    /// Type C: a spring and a dashpot whose force is limited. Spheres can rest on a slope.
    Spring {
        /// [-] coefficient μ_r of rolling friction.
        friction: f64,
        /// [-] stiffness of the rolling spring over k_n R_eff², with the normal stiffness k_n and the effective radius
        /// R_eff. `None`: 2.25 μ_r², with the rolling friction μ_r (Iwashita and Oda 1998, cited by Ai et al.).
        stiffness: Option<f64>,
        /// [-] dashpot constant as a fraction η_r of critical damping. The dashpot acts as long as the torque is below
        /// its limit.
        damping: f64,
    },
    /// Type A: a constant torque against the rolling motion, but at most the torque that stops this motion in one time
    /// step. Spheres cannot rest on a slope.
    Constant {
        /// [-] coefficient μ_r of rolling friction.
        friction: f64,
    },
    /// Type B: a torque proportional to the rolling speed (Zhou et al. 1999, Physica A 269, 536).
    Viscous {
        /// [s/m] torque divided by R_eff f_n and by the rolling speed [m/s].
        coefficient: f64,
    },
}

/// Twisting resistance: a spring of stiffness k_t a²/2 with the limit (2/3) μ a f_n (Marshall 2009, J. Comput. Phys.
/// 228, 1541). Here k_t is the tangential stiffness, μ the friction coefficient, f_n the normal force, and a =
/// sqrt(R_eff δ) the radius of the contact at the overlap δ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TwistingLaw {
    /// [-] dashpot constant as a fraction of critical damping. The dashpot acts as long as the torque is below its
    /// limit.
    pub damping: f64,
}

/// Coefficients of rolling and twisting friction of a surface. Each of them may be missing (`None`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ResistanceFriction {
    /// [-] coefficient μ_r of rolling friction; `None`: that of the law.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rolling: Option<f64>,
    /// [-] twisting friction, which replaces the sliding friction μ in the limit of twisting; `None`: μ itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub twisting: Option<f64>,
}

impl ResistanceFriction {
    /// True if the surface has neither a coefficient of rolling friction nor one of twisting friction.
    pub fn is_of_law(&self) -> bool {
        *self == Self::default()
    }

    /// Returns these coefficients of rolling and twisting friction. A missing coefficient is replaced by that of
    /// `usual`.
    pub fn or(self, usual: Self) -> Self {
        Self { rolling: self.rolling.or(usual.rolling), twisting: self.twisting.or(usual.twisting) }
    }
}

/// Resistance of a contact to rolling or twisting.
#[derive(Clone, Copy, Debug)]
pub struct Resistance {
    /// Spring [N/m] and dashpot [N s/m] against the rolling or twisting of the surfaces. The stiffness is 0 for a law
    /// without memory.
    pub spring: SpringDashpotSlider,
    /// [-] largest force of the resistance, divided by max(f_n, 0) with the normal force f_n.
    pub friction: f64,
    /// [s/m] for a viscous law, the force of the resistance divided by max(f_n, 0) and by the rolling speed, with the
    /// normal force f_n; otherwise 0.
    pub viscosity: f64,
}

/// Properties of the bodies in a contact from which its rolling and twisting resistance is computed.
#[derive(Clone, Copy, Debug)]
pub struct RollingBodies {
    /// [m] effective radius R_eff = 1/(1/r_i + 1/r_j); at a wall the radius of the sphere.
    pub radius: f64,
    /// [kg] effective mass of rolling or twisting by a torque: 1/(R_eff² (1/I_i + 1/I_j)), with the moments of inertia
    /// I.
    pub mass: f64,
    /// [kg m²] moment of inertia of bodies that roll about their contact point, I_r = 1/(1/(I_i + m_i r_i²) + 1/(I_j +
    /// m_j r_j²)). The bodies i and j have the moments of inertia I, the masses m and the radii r.
    pub rolling_inertia: f64,
}

impl RollingBodies {
    /// Makes the properties from mass [kg], radius [m] and moment of inertia [kg m²] of each particle; a wall is left
    /// out.
    pub fn of(bodies: impl Iterator<Item = (f64, f64, f64)> + Clone) -> Self {
        let sum = |of: &dyn Fn((f64, f64, f64)) -> f64| bodies.clone().map(of).sum::<f64>();
        let radius = 1.0 / sum(&|(_, radius, _)| 1.0 / radius);
        let mass = 1.0 / (radius * radius * sum(&|(_, _, inertia)| 1.0 / inertia));
        let rolling_inertia = 1.0 / sum(&|(mass, radius, inertia)| 1.0 / (inertia + mass * radius * radius));
        Self { radius, mass, rolling_inertia }
    }
}

/// Constants of a spring and a dashpot. The spring has the stiffness `stiffness` [N/m] at an overlap of 1 m. The
/// stiffness is proportional to the overlap to the power `half_powers`/2. The dashpot has the fraction `damping` [-] of
/// the critical damping of the mass `own_mass` [kg]. `mass` [kg] is the effective mass of the motion.
fn damped(stiffness: f64, half_powers: u8, damping: f64, mass: f64, own_mass: f64) -> SpringDashpotSlider {
    let dashpot = 2.0 * damping * (stiffness * own_mass).sqrt();
    SpringDashpotSlider { stiffness, dashpot, half_powers, ..SpringDashpotSlider::without_memory(mass) }
}

impl RollingLaw {
    /// Rolling resistance between two bodies. `normal` holds the constants of the normal contact of these bodies.
    pub fn between(&self, normal: &NormalSpring, bodies: &RollingBodies) -> Resistance {
        let without = SpringDashpotSlider::without_memory(bodies.mass);
        match *self {
            Self::Spring { friction, stiffness, damping } => {
                let ratio = stiffness.unwrap_or(2.25 * friction * friction);
                let own_mass = bodies.rolling_inertia / (bodies.radius * bodies.radius);
                let spring = damped(ratio * normal.tangent, normal.half_powers, damping, bodies.mass, own_mass);
                Resistance { spring, friction, viscosity: 0.0 }
            }
            Self::Constant { friction } => Resistance { spring: without, friction, viscosity: 0.0 },
            Self::Viscous { coefficient } => Resistance { spring: without, friction: 0.0, viscosity: coefficient },
        }
    }

    /// Returns this law with the rolling friction `other` [-], or unchanged if `other` is `None`. A viscous law does
    /// not change.
    pub fn with_friction(self, other: Option<f64>) -> Self {
        let Some(friction) = other else { return self };
        match self {
            Self::Spring { stiffness, damping, .. } => Self::Spring { friction, stiffness, damping },
            Self::Constant { .. } => Self::Constant { friction },
            Self::Viscous { coefficient } => Self::Viscous { coefficient },
        }
    }

    /// [-] coefficient μ_r of rolling friction; `None` for a viscous law.
    pub fn friction(&self) -> Option<f64> {
        match self {
            Self::Spring { friction, .. } | Self::Constant { friction } => Some(*friction),
            Self::Viscous { .. } => None,
        }
    }
}

impl TwistingLaw {
    /// Twisting resistance between two bodies, from their tangential spring and their coefficient of twisting friction
    /// [-]. The spring of the result has its constants for an overlap of 1 m; the limit `friction` is that for
    /// `overlap` [m].
    pub fn between(
        &self,
        tangential: &SpringDashpotSlider,
        friction: f64,
        overlap: f64,
        bodies: &RollingBodies,
    ) -> Resistance {
        // k_t a²/2 divided by R_eff², with a² = R_eff δ
        let stiffness = 0.5 * tangential.stiffness / bodies.radius;
        let own_mass = bodies.mass;
        let spring = damped(stiffness, tangential.half_powers + 2, self.damping, bodies.mass, own_mass);
        let contact_radius = (bodies.radius * overlap.max(0.0)).sqrt();
        Resistance { spring, friction: 2.0 / 3.0 * friction * contact_radius / bodies.radius, viscosity: 0.0 }
    }
}

impl std::fmt::Display for RollingLaw {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Spring { friction, .. } => write!(f, "a rolling spring with rolling friction {friction}"),
            Self::Constant { friction } => write!(f, "a constant rolling torque with rolling friction {friction}"),
            Self::Viscous { coefficient } => write!(f, "viscous rolling resistance of {coefficient} s/m"),
        }
    }
}
