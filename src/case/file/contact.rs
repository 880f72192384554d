//! How particles meet each other, and which pairs meet otherwise.

use crate::case::de::Located;
use crate::case::quantity::{Length, Ratio, Speed, Stiffness, Time};
use schemars::JsonSchema;
use serde::Deserialize;

/// `[contact]`: restitution and friction.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactFile {
    /// Ratio of the normal speeds after and before an impact, e: 1 elastic, 0 without rebound (hard spheres only).
    #[schemars(example = 0.97)]
    #[schemars(extend("x-required" = "where two particles can meet", "x-range" = "0 ..= 1"))]
    pub restitution: Option<Located<Ratio>>,
    /// Coefficient of sliding friction, μ.
    #[schemars(example = 0.1, extend("default" = 0, "x-range" = "0 ..= 100"))]
    pub friction: Option<Located<Ratio>>,
    /// Two kinds of particles, or a kind of particles and a wall, that meet otherwise than `[contact]` or the wall says.
    pub pairs: Option<Vec<Located<PairFile>>>,
}

/// `[[contact.pairs]]`: how two kinds meet.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairFile {
    /// The names of the two: `name` of `[[particles]]` twice, or that and `name` of `[[walls]]`. The same name twice is a kind of
    /// particles with itself.
    #[schemars(extend("examples" = [["glass", "steel"]], "x-required" = "always"))]
    pub between: Option<Located<[Located<String>; 2]>>,
    /// Ratio of the normal speeds after and before an impact, e.
    #[schemars(example = 0.9, extend("x-default" = "that of `[contact]` or the wall", "x-range" = "0 ..= 1"))]
    pub restitution: Option<Located<Ratio>>,
    /// Coefficient of sliding friction, μ.
    #[schemars(example = 0.1, extend("x-default" = "that of `[contact]` or the wall", "x-range" = "0 ..= 100"))]
    pub friction: Option<Located<Ratio>>,
    /// Stiffness of the spring between the two, k_n; or give `contact_time` or `overlap`. Only `[soft.linear_spring_dashpot]` has springs: Hertz's
    /// law makes the stiffness of a pair from the `elasticity` of each.
    #[schemars(example = &"5000 N/m", extend("x-range" = "1e-9 ..= 1e20 N/m"))]
    #[schemars(extend("x-default" = "that of `[soft.linear_spring_dashpot]`"))]
    pub stiffness: Option<Located<Stiffness>>,
    /// How long a contact of the two is to last, T_c: the stiffness follows, of every two particles from their own masses.
    #[schemars(example = &"1e-5 s", extend("x-range" = "greater than 0 s"))]
    pub contact_time: Option<Located<Time>>,
    /// How deep an impact at `impact_speed` is to go: the stiffness follows, of every two particles from their own masses.
    #[schemars(example = &"2 um", extend("x-range" = "greater than 0 m"))]
    pub overlap: Option<Located<Length>>,
    /// Normal speed of impact for which `overlap` is meant, which cannot do without.
    #[schemars(example = &"0.5 m/s", extend("x-range" = "greater than 0 m/s"))]
    pub impact_speed: Option<Located<Speed>>,
}
