//! The part of the domain in which a random start places particles: the key `in` of `[[particles]]`.

use super::{Axis, Three};
use crate::case::located::Located;
use crate::case::quantity::Length;
use schemars::JsonSchema;
use serde::Deserialize;

/// Table `particles.in`: region of a random start, exactly one of `box`, `cylinder` and `inside`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RegionFile {
    /// A block with edges along the axes, in which the particles start.
    #[serde(rename = "box")]
    #[schemars(extend("x-one-of" = "region", "x-required" = "or `cylinder`, `inside`"))]
    pub block: Option<Located<BlockRegionFile>>,
    /// A cylinder along an axis, in which the particles start.
    #[schemars(extend("x-one-of" = "region"))]
    pub cylinder: Option<Located<CylinderRegionFile>>,
    /// The `name` of a wall that encloses the centres of the particles: a vessel, a shell with open ends, or an open
    /// mesh.
    #[schemars(example = &"hopper", extend("x-one-of" = "region"))]
    pub inside: Option<Located<String>>,
}

/// Block with edges along the axes, in which particles start, come in or leave.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BlockRegionFile {
    /// Centre of the block.
    #[schemars(extend("examples" = [["10 mm", "10 mm", "10 mm"]], "x-required" = "always"))]
    pub center: Option<Three<Length>>,
    /// Half the edge lengths of the block along x, y and z.
    #[schemars(extend("examples" = [["5 mm", "4 mm", "5 mm"]]))]
    #[schemars(extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub half_extents: Option<Three<Length>>,
}

/// Cylinder along an axis, in which particles start, come in or leave.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderRegionFile {
    /// Centre of the cylinder.
    #[schemars(extend("examples" = [["10 mm", "10 mm", "10 mm"]], "x-required" = "always"))]
    pub center: Option<Three<Length>>,
    /// Direction of the axis of the cylinder.
    #[schemars(example = &"z", extend("x-required" = "always"))]
    pub axis: Option<Located<Axis>>,
    /// Radius of the cylinder.
    #[schemars(example = &"8 mm", extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub radius: Option<Located<Length>>,
    /// Half the length of the cylinder.
    #[schemars(example = &"3 mm", extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub half_height: Option<Located<Length>>,
}
