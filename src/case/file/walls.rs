//! Walls and their shapes.

use super::{Axis, ElasticityFile, Three};
use crate::case::de::Located;
use crate::case::quantity::{Length, Ratio};
use schemars::JsonSchema;
use serde::Deserialize;

/// `[[walls]]`: one wall.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallFile {
    /// A flat wall; everything behind it is solid.
    pub plane: Option<Located<PlaneFile>>,
    /// A solid ball.
    pub sphere: Option<Located<SphereFile>>,
    /// A solid block with edges along the axes.
    pub cuboid: Option<Located<CuboidFile>>,
    /// A solid cylinder along an axis.
    pub cylinder: Option<Located<CylinderFile>>,
    /// Ratio of the normal speeds after and before an impact, e: 1 elastic, 0 without rebound (hard spheres only).
    #[schemars(example = 0.97, extend("x-required" = "always", "x-range" = "0 ..= 1"))]
    pub restitution: Option<Located<Ratio>>,
    /// Coefficient of sliding friction, μ.
    #[schemars(example = 0.1, extend("default" = 0, "x-range" = "0 ..= 100"))]
    pub friction: Option<Located<Ratio>>,
    /// Elasticity of this wall, where it differs from what `[soft.hertz]` says.
    pub elasticity: Option<Located<ElasticityFile>>,
}

/// A half-space.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneFile {
    /// A point of the surface.
    #[schemars(extend("examples" = [["0 m", "40 mm", "0 m"]], "x-required" = "always"))]
    pub point: Option<Three<Length>>,
    /// Direction towards the particles, of any length.
    #[schemars(extend("examples" = [[0, -1, 0]], "x-required" = "always"))]
    pub normal: Option<Three<Ratio>>,
}

/// A solid ball.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereFile {
    /// Its centre.
    #[schemars(extend("examples" = [["10 mm", "10 mm", "10 mm"]], "x-required" = "always"))]
    pub center: Option<Three<Length>>,
    /// Its radius.
    #[schemars(example = &"2 mm", extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub radius: Option<Located<Length>>,
}

/// A solid block along the axes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CuboidFile {
    /// Its centre.
    #[schemars(extend("examples" = [["10 mm", "10 mm", "10 mm"]], "x-required" = "always"))]
    pub center: Option<Three<Length>>,
    /// Half its edges.
    #[schemars(extend("examples" = [["2 mm", "1 mm", "2 mm"]]))]
    #[schemars(extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub half_extents: Option<Three<Length>>,
}

/// A solid cylinder along an axis.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderFile {
    /// Its centre.
    #[schemars(extend("examples" = [["10 mm", "10 mm", "10 mm"]], "x-required" = "always"))]
    pub center: Option<Three<Length>>,
    /// Its direction.
    #[schemars(example = &"x", extend("x-required" = "always"))]
    pub axis: Option<Located<Axis>>,
    /// Its radius.
    #[schemars(example = &"2 mm", extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub radius: Option<Located<Length>>,
    /// Half its length.
    #[schemars(example = &"3 mm", extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub half_height: Option<Located<Length>>,
}
