//! Keys of friction: tangential laws of soft contacts, rolling and twisting resistance, and rules of the tangential
//! impulse of hard impacts.

use crate::case::located::Located;
use crate::case::quantity::{Ratio, Slowness};
use schemars::JsonSchema;
use serde::Deserialize;

/// Tables `[soft.tangential.*]`: choice of a tangential law (law of friction in soft contacts).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum TangentialFile {
    /// Linear spring and dashpot along the surface; the contact stores the elongation of the spring. The force of
    /// spring and dashpot together is at most the coefficient of friction times the normal force. Give
    /// `stiffness_ratio`, or the `tangential_restitution` of impacts without sliding.
    Linear {
        /// Ratio of the tangential stiffness to the normal one, κ = k_t/k_n.
        #[schemars(example = 0.2857)]
        #[schemars(extend("x-required" = "or `tangential_restitution`", "x-one-of" = "spring"))]
        #[schemars(extend("x-range" = "greater than 0, up to 10"))]
        stiffness_ratio: Option<Located<Ratio>>,
        /// Ratio of the tangential dashpot to the normal one, c_t/c_n.
        #[schemars(example = 0.5, extend("default" = 0, "x-range" = "0 ..= 10"))]
        dashpot_ratio: Option<Located<Ratio>>,
        /// Ratio β_0 of the slip speed after an impact without sliding to that before. The tangential spring and
        /// dashpot are chosen so that they swing for half a period during the contact.
        #[schemars(example = 0.44, extend("x-range" = "greater than 0, up to 1", "x-one-of" = "spring"))]
        tangential_restitution: Option<Located<Ratio>>,
    },
    /// Mindlin's tangential stiffness of elastic spheres, 8 G* sqrt(R δ), with the effective shear modulus G*, the
    /// effective radius R and the overlap δ. The contact stores the quantity `history`. This law requires
    /// `[soft.hertz]` or `[soft.kuwabara_kono]`.
    Mindlin {
        /// Quantity that a contact stores while its stiffness changes. Only the choice "rescaled" guarantees that a
        /// contact never creates energy.
        #[schemars(example = &"force", extend("default" = "rescaled"))]
        history: Option<Located<HistoryFile>>,
        /// Ratio of the tangential dashpot to the normal one, c_t/c_n. Both dashpots grow with the fourth root of the
        /// overlap.
        #[schemars(example = 0.5, extend("default" = 0, "x-range" = "0 ..= 10"))]
        dashpot_ratio: Option<Located<Ratio>>,
    },
    /// Friction without a spring, for which a contact stores nothing. The force acts against the slip and is the
    /// coefficient of friction times the normal force. It is at most the force that stops the slip within one step.
    Coulomb {},
}

/// Quantity that a contact with Mindlin's law stores.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HistoryFile {
    /// The tangential force. While the overlap decreases, the force also decreases in proportion to the radius of the
    /// contact.
    Rescaled,
    /// The tangential force. It does not change with the overlap.
    Force,
    /// The tangential displacement of the two surfaces. The force is this displacement times the present stiffness.
    Displacement,
}

/// Tables `[soft.rolling.*]`: choice of a law of rolling resistance.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RollingFile {
    /// Rolling spring and dashpot with a limit (type C of Ai et al. 2011). Spheres can rest on a slope.
    Spring {
        /// Coefficient of rolling friction, μ_r. The largest torque is μ_r R_eff f_n, with effective radius R_eff and
        /// normal force f_n.
        #[schemars(example = 0.05, extend("x-required" = "always", "x-range" = "greater than 0, up to 10"))]
        friction: Option<Located<Ratio>>,
        /// Ratio of the stiffness of the rolling spring to k_n R_eff², with the normal stiffness k_n and the effective
        /// radius R_eff.
        #[schemars(example = 0.01, extend("x-default" = "2.25 μ_r²", "x-range" = "greater than 0, up to 10"))]
        stiffness_ratio: Option<Located<Ratio>>,
        /// Damping ratio of the rolling spring while its torque is below the limit; 1 is critical damping.
        #[schemars(example = 0.1, extend("default" = 0.3, "x-range" = "0 ..= 10"))]
        damping_ratio: Option<Located<Ratio>>,
    },
    /// Constant torque against the rolling (type A of Ai et al. 2011). Spheres cannot rest on a slope.
    Constant {
        /// Coefficient of rolling friction, μ_r. The torque is μ_r R_eff f_n, with effective radius R_eff and normal
        /// force f_n.
        #[schemars(example = 0.05, extend("x-required" = "always", "x-range" = "greater than 0, up to 10"))]
        friction: Option<Located<Ratio>>,
    },
    /// Torque in proportion to the rolling speed (type B of Ai et al. 2011). Spheres on a slope creep.
    Viscous {
        /// Coefficient c of the torque c v R_eff f_n, with rolling speed v, effective radius R_eff and normal force
        /// f_n.
        #[schemars(example = &"0.1 s/m", extend("x-required" = "always", "x-range" = "greater than 0 s/m"))]
        coefficient: Option<Located<Slowness>>,
    },
}

/// Table `[soft.twisting]`: law of twisting resistance.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TwistingFile {
    /// Damping ratio of the twisting spring; 1 is critical damping. The torque is at most (2/3) μ a f_n, with the
    /// coefficient μ of twisting friction, the radius a of the contact and the normal force f_n.
    #[schemars(example = 0.3, extend("default" = 0, "x-range" = "0 ..= 10"))]
    pub damping_ratio: Option<Located<Ratio>>,
}

/// Tables `[hard.friction.*]`: choice of a rule of the tangential impulse (change of momentum along the surface in a
/// hard impact).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ImpactRuleFile {
    /// Walton's rule: an impact changes the slip s to -β_0 s, unless friction is too small for this change. With too
    /// little friction the surfaces slide throughout the impact.
    Walton {
        /// Coefficient β_0 of an impact without sliding, which changes the slip s to -β_0 s. -1: smooth spheres, whose
        /// slip does not change. 0: the slip stops. 1: the slip is reversed.
        #[schemars(example = 0.44, extend("x-required" = "always", "x-range" = "-1 ..= 1"))]
        tangential_restitution: Option<Located<Ratio>>,
    },
    /// Rule computed from the tangential spring of the case: the impulse is that of stiff soft spheres with this
    /// spring, at every angle of impact. It is the default if the case has such a spring.
    OfSpring {},
    /// Walton's rule with β_0 = 0: an impact stops the slip, or the surfaces slide throughout the impact if friction is
    /// too small.
    Coulomb {},
}
