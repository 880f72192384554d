//! Tangential laws of soft contacts.

use super::slider::{SpringDashpotSlider, SpringHistory};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Law of the tangential force of a soft contact. μ is the friction coefficient, and f_n the normal force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TangentialLaw {
    /// Coulomb's law without memory: a force μ |f_n| against the slip, at most the force that stops the slip within a
    /// step.
    Coulomb,
    /// A linear spring parallel to a linear dashpot, whose total force is at most μ max(f_n, 0) (Cundall and Strack
    /// 1979, Géotechnique 29, 47).
    Linear(LinearTangential),
    /// Mindlin's law for two elastic spheres with Hertz's normal law (Mindlin 1949, J. Appl. Mech. 16, 259). The
    /// stiffness is 8 G* a, with the effective shear modulus G* and the radius a = sqrt(R δ) of the contact area. R is
    /// the effective radius and δ the overlap. The total force of this spring and a dashpot is at most μ max(f_n, 0),
    /// with the friction μ and the normal force f_n.
    Mindlin {
        /// Quantity that the contact stores of its spring while the stiffness changes: force or shear.
        history: SpringHistory,
        /// [-] ratio c_t/c_n of the tangential to the normal dashpot constant. Both constants are proportional to
        /// δ^(1/4), with the overlap δ.
        dashpot: f64,
    },
}

/// Constants of the linear tangential law, given relative to the normal law or by a restitution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LinearTangential {
    /// Tangential spring and dashpot, given as multiples of the normal spring and dashpot.
    Ratios {
        /// [-] ratio of the tangential to the normal stiffness, κ = k_t/k_n.
        stiffness: f64,
        /// [-] ratio of the tangential to the normal dashpot constant, c_t/c_n.
        dashpot: f64,
    },
    /// [-] tangential restitution β_0 of impacts that stick, 0 < β_0 <= 1. Spring and dashpot make half an oscillation
    /// in the contact time (rule of equal half periods; Deen et al. 2007, Chem. Eng. Sci. 62, 28).
    Restitution(f64),
}

/// Constants of the normal contact of two bodies, from which a tangential law derives its own constants.
#[derive(Clone, Copy, Debug)]
pub struct NormalSpring {
    /// [N/m] stiffness k_n of the normal spring; for Hertz's law the constant k_H [N/m^1.5].
    pub stiffness: f64,
    /// [N s/m] dashpot constant c_n of the normal contact; for Hertz's law in N s/m^1.25, for Kuwabara and Kono's law
    /// in N s/m^1.5.
    pub dashpot: f64,
    /// [s] contact time T_c of a linear law; infinite for other laws, whose contact time depends on the speed.
    pub contact_time: f64,
    /// [N/m] slope of the elastic normal force as a function of the overlap, at an overlap of 1 m.
    pub tangent: f64,
    /// [-] number p if the slope `tangent` is proportional to δ^(p/2), with the overlap δ; 0 for a linear law.
    pub half_powers: u8,
    /// [N/m^1.5] Mindlin's tangential stiffness over the square root of the overlap, 8 G* sqrt(R), with the effective
    /// shear modulus G* and the effective radius R; 0 for other laws.
    pub shear_stiffness: f64,
}

impl NormalSpring {
    /// Makes the constants of a linear spring [N/m] and dashpot [N s/m] between two bodies, with the contact time
    /// `contact_time` [s].
    pub fn linear(stiffness: f64, dashpot: f64, contact_time: f64) -> Self {
        Self { stiffness, dashpot, contact_time, tangent: stiffness, half_powers: 0, shear_stiffness: 0.0 }
    }
}

impl TangentialLaw {
    /// Constants of the tangential spring and dashpot between two bodies. `normal` returns the constants of their
    /// normal contact, and `mass` is the effective mass M_t [kg] of the slip of these bodies.
    pub fn between(&self, normal: impl FnOnce() -> NormalSpring, mass: f64) -> SpringDashpotSlider {
        match self {
            Self::Coulomb => SpringDashpotSlider::without_memory(mass),
            Self::Linear(LinearTangential::Ratios { stiffness, dashpot }) => {
                let normal = normal();
                let (stiffness, dashpot) = (stiffness * normal.stiffness, dashpot * normal.dashpot);
                SpringDashpotSlider { stiffness, dashpot, ..SpringDashpotSlider::without_memory(mass) }
            }
            Self::Linear(LinearTangential::Restitution(restitution)) => {
                let (time, ln) = (normal().contact_time, restitution.ln());
                // γ = -ln β_0/T_c and k_t/M_t - γ² = (π/T_c)²
                let (stiffness, dashpot) = (mass * (PI * PI + ln * ln) / (time * time), -2.0 * mass * ln / time);
                SpringDashpotSlider { stiffness, dashpot, ..SpringDashpotSlider::without_memory(mass) }
            }
            Self::Mindlin { history, dashpot } => {
                let normal = normal();
                let (stiffness, dashpot) = (normal.shear_stiffness, dashpot * normal.dashpot);
                SpringDashpotSlider { mass, stiffness, dashpot, half_powers: 1, history: *history }
            }
        }
    }

    /// True if contacts store the shear of a tangential spring from one time step to the next.
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
            Self::Mindlin { history, dashpot } => {
                let remembers = match history {
                    SpringHistory::Rescaled => "remembers the force and rescales it while it is unloaded",
                    SpringHistory::Force => "remembers the force",
                    SpringHistory::Displacement => "remembers the displacement",
                };
                write!(f, "Mindlin's tangential law, which {remembers}")?;
                if *dashpot > 0.0 { write!(f, ", and a dashpot of {dashpot} times the normal one") } else { Ok(()) }
            }
        }
    }
}
