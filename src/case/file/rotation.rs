//! Tangential laws of soft contacts, and rules of the tangential impulse of hard ones.

use crate::case::de::Located;
use crate::case::quantity::Ratio;
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
    /// Friction without memory: friction times the normal force against the slip, but at most what stops it in a step.
    Coulomb {},
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
