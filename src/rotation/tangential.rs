//! Tangential laws of contacts that last.

use super::slider::{SpringDashpotSlider, SpringHistory};
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
    /// Mindlin's stiffness 8 G* a of two elastic spheres, which grows with the radius a = sqrt(R δ) of the contact, beside
    /// a dashpot, together at most μ max(f_n, 0) (Mindlin 1949, J. Appl. Mech. 16, 259). It belongs to Hertz's law.
    Mindlin {
        /// Quantity that the contact remembers while its stiffness changes.
        history: SpringHistory,
        /// [-] c_t/c_n, both proportional to δ^(1/4).
        dashpot: f64,
    },
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

/// Normal contact of two bodies as a tangential law needs it.
#[derive(Clone, Copy, Debug)]
pub struct NormalSpring {
    /// [N/m] k_n.
    pub stiffness: f64,
    /// [N s/m] c_n.
    pub dashpot: f64,
    /// [s] contact time T_c of a linear law; infinite for others, whose time depends on the speed.
    pub contact_time: f64,
    /// [N/m] slope of the elastic force at an overlap of 1 m, and twice the power of the overlap by which it grows.
    pub tangent: f64,
    /// See `tangent`; 0 of a linear law.
    pub half_powers: u8,
    /// [N/m^1.5] Mindlin's tangential stiffness over the root of the overlap, 8 G* sqrt(R); 0 of a law that has none.
    pub shear_stiffness: f64,
}

impl NormalSpring {
    /// Linear spring [N/m] and dashpot [N s/m] of two bodies whose impacts last `contact_time` [s].
    pub fn linear(stiffness: f64, dashpot: f64, contact_time: f64) -> Self {
        Self { stiffness, dashpot, contact_time, tangent: stiffness, half_powers: 0, shear_stiffness: 0.0 }
    }
}

impl TangentialLaw {
    /// Constants between two bodies with an effective mass `mass` M_t [kg] of their slip.
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
