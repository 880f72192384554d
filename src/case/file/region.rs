//! The part of the domain that a random start fills.

use super::{Axis, Three};
use crate::case::de::Located;
use crate::case::quantity::Length;
use schemars::JsonSchema;
use serde::Deserialize;

/// `particles.in`: exactly one of `box`, `cylinder` and `inside`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RegionFile {
    /// A block with edges along the axes.
    #[serde(rename = "box")]
    pub block: Option<Located<BlockRegionFile>>,
    /// A cylinder along an axis.
    pub cylinder: Option<Located<CylinderRegionFile>>,
    /// The `name` of a wall that the centres are inside of: a vessel, a shell that is open at its ends, or a sheet of triangles.
    #[schemars(example = &"hopper")]
    pub inside: Option<Located<String>>,
}

/// A block that holds particles at the start.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BlockRegionFile {
    /// Its centre.
    #[schemars(extend("examples" = [["10 mm", "10 mm", "10 mm"]], "x-required" = "always"))]
    pub center: Option<Three<Length>>,
    /// Half its edges.
    #[schemars(extend("examples" = [["5 mm", "4 mm", "5 mm"]]))]
    #[schemars(extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub half_extents: Option<Three<Length>>,
}

/// A cylinder that holds particles at the start.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderRegionFile {
    /// Its centre.
    #[schemars(extend("examples" = [["10 mm", "10 mm", "10 mm"]], "x-required" = "always"))]
    pub center: Option<Three<Length>>,
    /// Its direction.
    #[schemars(example = &"z", extend("x-required" = "always"))]
    pub axis: Option<Located<Axis>>,
    /// Its radius.
    #[schemars(example = &"8 mm", extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub radius: Option<Located<Length>>,
    /// Half its length.
    #[schemars(example = &"3 mm", extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub half_height: Option<Located<Length>>,
}
