//! Keys of contacts: table `[contact]`, and `[[contact.pairs]]` for pairs with contact properties of their own.

use super::RestitutionFile;
use crate::case::located::Located;
use crate::case::quantity::{Length, Ratio, Speed, Stiffness, Time};
use schemars::JsonSchema;
use serde::Deserialize;

/// Table `[contact]`: restitution and friction.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactFile {
    /// Restitution e, the ratio of the normal speeds after and before an impact. 1: elastic. 0: no rebound, only for
    /// the models hard and dsmc. A table makes the restitution depend on the normal speed of the impact.
    #[schemars(example = 0.97)]
    #[schemars(extend("x-required" = "where two particles can meet", "x-range" = "0 ..= 1"))]
    pub restitution: Option<Located<RestitutionFile>>,
    /// Coefficient of sliding friction, μ.
    #[schemars(example = 0.1, extend("default" = 0, "x-range" = "0 ..= 100"))]
    pub friction: Option<Located<Ratio>>,
    /// True: spheres rotate. False: they do not rotate. Without this key they rotate if the case has a tangential law,
    /// rolling or twisting resistance, or an impact rule.
    #[schemars(example = true, extend("x-default" = "true with `[soft.tangential]` or `[hard.friction]`"))]
    pub rotation: Option<Located<bool>>,
    /// Two kinds of particles, or a kind of particles and a wall, with contact properties that differ from `[contact]`
    /// or the wall.
    pub pairs: Option<Vec<Located<PairFile>>>,
}

/// Table `[[contact.pairs]]`: contacts between two kinds of particles, or between particles and a wall.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairFile {
    /// Names of the two partners: `name` of two `[[particles]]`, or `name` of one `[[particles]]` and of one
    /// `[[walls]]`. One name given twice means contacts within that kind of particles.
    #[schemars(extend("examples" = [["glass", "steel"]], "x-required" = "always"))]
    pub between: Option<Located<[Located<String>; 2]>>,
    /// Restitution e, the ratio of the normal speeds after and before an impact; a number or a law.
    #[schemars(example = 0.9, extend("x-default" = "that of `[contact]` or the wall", "x-range" = "0 ..= 1"))]
    pub restitution: Option<Located<RestitutionFile>>,
    /// Coefficient of sliding friction, μ.
    #[schemars(example = 0.1, extend("x-default" = "that of `[contact]` or the wall", "x-range" = "0 ..= 100"))]
    pub friction: Option<Located<Ratio>>,
    /// Coefficient of rolling friction, μ_r, of the law in `[soft.rolling]`.
    #[schemars(example = 0.05, extend("x-default" = "that of the wall or of `[soft.rolling]`", "x-range" = "0 ..= 10"))]
    pub rolling_friction: Option<Located<Ratio>>,
    /// Coefficient of twisting friction. The largest torque of `[soft.twisting]` is 2/3 of this coefficient, times the
    /// radius of the contact, times the normal force.
    #[schemars(example = 0.1, extend("x-default" = "that of the wall, or `friction`", "x-range" = "0 ..= 100"))]
    pub twisting_friction: Option<Located<Ratio>>,
    /// Stiffness k_n of the spring between the two bodies; `contact_time` or `overlap` can be given instead. The key
    /// has an effect only with `[soft.linear_spring_dashpot]`: with Hertz's law the stiffness of a pair follows from
    /// the `elasticity` of each body.
    #[schemars(example = &"5000 N/m", extend("x-range" = "1e-9 ..= 1e20 N/m"))]
    #[schemars(extend("x-default" = "that of `[soft.linear_spring_dashpot]`"))]
    pub stiffness: Option<Located<Stiffness>>,
    /// Desired duration of a contact, T_c. The stiffness of each contact follows from this duration, the restitution
    /// and the masses of the two bodies.
    #[schemars(example = &"1e-5 s", extend("x-range" = "greater than 0 s"))]
    pub contact_time: Option<Located<Time>>,
    /// Desired largest overlap in an impact at the speed `impact_speed`. The stiffness of each contact follows from
    /// this overlap, the restitution and the masses of the two bodies.
    #[schemars(example = &"2 um", extend("x-range" = "greater than 0 m"))]
    pub overlap: Option<Located<Length>>,
    /// Normal speed of the impact that `overlap` refers to; required with `overlap`.
    #[schemars(example = &"0.5 m/s", extend("x-range" = "greater than 0 m/s"))]
    pub impact_speed: Option<Located<Speed>>,
}
