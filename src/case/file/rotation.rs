//! Tangential laws of soft contacts, and rules of the tangential impulse of hard ones.

use crate::case::de::Located;
use crate::case::quantity::{Ratio, Slowness};
use schemars::JsonSchema;
use serde::Deserialize;

/// `[soft.tangential.*]`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum TangentialFile {
    /// Linear spring and dashpot with memory, together at most friction times the normal force. Give `stiffness_ratio`,
    /// or the `tangential_restitution` of impacts without sliding.
    Linear {
        /// Tangential stiffness over the normal one, κ = k_t/k_n.
        #[schemars(example = 0.2857)]
        #[schemars(extend("x-required" = "or `tangential_restitution`", "x-one-of" = "spring"))]
        #[schemars(extend("x-range" = "greater than 0, up to 10"))]
        stiffness_ratio: Option<Located<Ratio>>,
        /// Tangential dashpot over the normal one, c_t/c_n.
        #[schemars(example = 0.5, extend("default" = 0, "x-range" = "0 ..= 10"))]
        dashpot_ratio: Option<Located<Ratio>>,
        /// Ratio β_0 of the slip after and before an impact without sliding. Spring and dashpot then swing for half a period
        /// in the contact time.
        #[schemars(example = 0.44, extend("x-range" = "greater than 0, up to 1", "x-one-of" = "spring"))]
        tangential_restitution: Option<Located<Ratio>>,
    },
    /// Mindlin's stiffness of elastic spheres, 8 G* sqrt(R δ), with memory. It needs `[soft.hertz]`.
    Mindlin {
        /// Quantity that a contact remembers while its stiffness changes. Only "rescaled" never creates energy.
        #[schemars(example = &"force", extend("default" = "rescaled"))]
        history: Option<Located<HistoryFile>>,
        /// Tangential dashpot over the normal one, c_t/c_n; both grow with the fourth root of the overlap.
        #[schemars(example = 0.5, extend("default" = 0, "x-range" = "0 ..= 10"))]
        dashpot_ratio: Option<Located<Ratio>>,
    },
    /// Friction without memory: friction times the normal force against the slip, but at most what stops it in a step.
    Coulomb {},
}

/// Quantity that a contact with Mindlin's law remembers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HistoryFile {
    /// The force; while the contact is unloaded, the force also falls in proportion to the radius of the contact.
    Rescaled,
    /// The force.
    Force,
    /// The displacement.
    Displacement,
}

/// `[soft.rolling.*]`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RollingFile {
    /// Rolling spring and dashpot with a limit (type C of Ai et al. 2011): spheres can rest on a slope.
    Spring {
        /// Coefficient of rolling friction, μ_r. The largest torque is μ_r R_eff times the normal force.
        #[schemars(example = 0.05, extend("x-required" = "always", "x-range" = "greater than 0, up to 10"))]
        friction: Option<Located<Ratio>>,
        /// Stiffness of the rolling spring over k_n R_eff².
        #[schemars(example = 0.01, extend("x-default" = "2.25 μ_r²", "x-range" = "greater than 0, up to 10"))]
        stiffness_ratio: Option<Located<Ratio>>,
        /// Share of critical damping below the limit.
        #[schemars(example = 0.1, extend("default" = 0.3, "x-range" = "0 ..= 10"))]
        damping_ratio: Option<Located<Ratio>>,
    },
    /// Constant torque against the rolling (type A of Ai et al. 2011): spheres cannot rest on a slope.
    Constant {
        /// Coefficient of rolling friction, μ_r. The torque is μ_r R_eff times the normal force.
        #[schemars(example = 0.05, extend("x-required" = "always", "x-range" = "greater than 0, up to 10"))]
        friction: Option<Located<Ratio>>,
    },
    /// Torque in proportion to the rolling speed (type B of Ai et al. 2011): spheres on a slope creep.
    Viscous {
        /// Torque over R_eff times the normal force, and over the rolling speed.
        #[schemars(example = &"0.1 s/m", extend("x-required" = "always", "x-range" = "greater than 0 s/m"))]
        coefficient: Option<Located<Slowness>>,
    },
}

/// `[soft.twisting]`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TwistingFile {
    /// Share of critical damping below the limit (2/3) μ a f_n, where a is the radius of the contact.
    #[schemars(example = 0.3, extend("default" = 0, "x-range" = "0 ..= 10"))]
    pub damping_ratio: Option<Located<Ratio>>,
}

/// `[hard.friction.*]`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ImpactRuleFile {
    /// Walton's rule: an impact reverses the slip by the factor β_0, or slides.
    Walton {
        /// Ratio β_0 of the slip after and before an impact without sliding: -1 smooth, 0 the slip stops, 1 it reverses.
        #[schemars(example = 0.44, extend("x-required" = "always", "x-range" = "-1 ..= 1"))]
        tangential_restitution: Option<Located<Ratio>>,
    },
    /// Rule of stiff soft spheres with the law `[soft.tangential.linear]`, at every angle. The default with that law.
    OfSpring {},
    /// An impact stops the slip, or slides: Walton's rule with β_0 = 0.
    Coulomb {},
}
