//! Walls and their shapes.

use super::{Axis, ElasticityFile, Three};
use crate::case::de::Located;
use crate::case::quantity::{Length, Ratio, Speed};
use schemars::JsonSchema;
use serde::Deserialize;

/// `[[walls]]`: one wall.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallFile {
    /// A flat wall; everything behind it is solid.
    pub plane: Option<Located<PlaneFile>>,
    /// A solid ball, or a hollow one with the particles inside.
    pub sphere: Option<Located<SphereFile>>,
    /// A solid block with edges along the axes.
    pub cuboid: Option<Located<CuboidFile>>,
    /// A block with edges along the axes: solid, or hollow with the particles inside.
    #[serde(rename = "box")]
    pub room: Option<Located<BoxFile>>,
    /// A cylinder along an axis: solid, hollow with the particles inside (a can, or a pipe without ends), or a thin shell.
    pub cylinder: Option<Located<CylinderFile>>,
    /// A truncated cone along an axis: solid, hollow with the particles inside, or a thin shell (a hopper).
    pub cone: Option<Located<ConeFile>>,
    /// A surface of triangles from a file.
    pub mesh: Option<Located<MeshFile>>,
    /// Its name in `[[contact.pairs]]`; walls of one material may have one name.
    #[schemars(example = &"steel wall")]
    pub name: Option<Located<String>>,
    /// Ratio of the normal speeds after and before an impact, e: 1 elastic, 0 without rebound (hard spheres only).
    #[schemars(example = 0.97, extend("x-required" = "always", "x-range" = "0 ..= 1"))]
    pub restitution: Option<Located<Ratio>>,
    /// Coefficient of sliding friction, μ.
    #[schemars(example = 0.1, extend("default" = 0, "x-range" = "0 ..= 100"))]
    pub friction: Option<Located<Ratio>>,
    /// Velocity of its surface along itself, as of a belt or a sheared side: planes, pipes without ends, and meshes all of whose triangles
    /// it runs along. The shape stays where it is.
    #[schemars(extend("examples" = [["0 m/s", "0 m/s", "0.5 m/s"]], "default" = [0, 0, 0]))]
    pub velocity: Option<Three<Speed>>,
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

/// A ball.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereFile {
    /// Its centre.
    #[schemars(extend("examples" = [["10 mm", "10 mm", "10 mm"]], "x-required" = "always"))]
    pub center: Option<Three<Length>>,
    /// Its radius.
    #[schemars(example = &"2 mm", extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub radius: Option<Located<Length>>,
    /// Whether the particles are inside.
    #[schemars(example = true, extend("default" = false))]
    pub inside: Option<Located<bool>>,
}

/// A solid or hollow block along the axes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxFile {
    /// Its centre.
    #[schemars(extend("examples" = [["10 mm", "10 mm", "10 mm"]], "x-required" = "always"))]
    pub center: Option<Three<Length>>,
    /// Half its edges.
    #[schemars(extend("examples" = [["5 mm", "4 mm", "5 mm"]]))]
    #[schemars(extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub half_extents: Option<Three<Length>>,
    /// Whether the particles are inside.
    #[schemars(example = true, extend("default" = false))]
    pub inside: Option<Located<bool>>,
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

/// A cylinder along an axis.
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
    /// Half its length. With `inside = true` it may be left out: a pipe without ends.
    #[schemars(example = &"3 mm", extend("x-required" = "unless `inside`", "x-range" = "greater than 0 m"))]
    pub half_height: Option<Located<Length>>,
    /// Whether the particles are inside.
    #[schemars(example = true, extend("default" = false))]
    pub inside: Option<Located<bool>>,
    /// Whether it is a thin shell, open at both ends, with particles on both sides.
    #[schemars(example = true, extend("default" = false))]
    pub open: Option<Located<bool>>,
}

/// A truncated cone along an axis.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConeFile {
    /// Its centre, half-way between the ends.
    #[schemars(extend("examples" = [["10 mm", "10 mm", "10 mm"]], "x-required" = "always"))]
    pub center: Option<Three<Length>>,
    /// Its direction.
    #[schemars(example = &"z", extend("x-required" = "always"))]
    pub axis: Option<Located<Axis>>,
    /// Its radius at the end with the smaller coordinate.
    #[schemars(example = &"2 mm", extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub lower_radius: Option<Located<Length>>,
    /// Its radius at the end with the larger coordinate.
    #[schemars(example = &"6 mm", extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub upper_radius: Option<Located<Length>>,
    /// Half its length.
    #[schemars(example = &"4 mm", extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub half_height: Option<Located<Length>>,
    /// Whether the particles are inside, between closed ends.
    #[schemars(example = true, extend("default" = false))]
    pub inside: Option<Located<bool>>,
    /// Whether it is a thin shell, open at both ends, with particles on both sides: a hopper.
    #[schemars(example = true, extend("default" = false))]
    pub open: Option<Located<bool>>,
}

/// A surface of triangles.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshFile {
    /// Name of an STL or OBJ file, relative to the file that names it, in its folder or below.
    #[schemars(example = &"hopper.stl", extend("x-required" = "always"))]
    pub file: Option<Located<String>>,
    /// What a length of 1 in the file is, as these files do not say.
    #[schemars(example = &"1 mm", extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub unit: Option<Located<Length>>,
    /// All lengths are multiplied by it.
    #[schemars(example = 0.5, extend("default" = 1, "x-range" = "greater than 0"))]
    pub scale: Option<Located<Ratio>>,
    /// Where the origin of the file is put.
    #[schemars(extend("examples" = [["10 mm", "0 mm", "10 mm"]], "default" = [0, 0, 0]))]
    pub position: Option<Three<Length>>,
    /// The mesh is turned about this direction, of any length, through the origin of the file.
    #[schemars(extend("examples" = [[1, 0, 0]], "default" = [0, 0, 1]))]
    pub axis: Option<Three<Ratio>>,
    /// By this angle, counter-clockwise seen against the direction.
    #[schemars(example = &"90 deg", extend("default" = 0))]
    pub angle: Option<Located<Ratio>>,
    /// Whether the particles are inside a closed surface (true) or outside (false). Without it a closed surface is a solid body,
    /// and an open one a thin sheet with particles on both sides. Of a wall drawn with its thickness `true` keeps the cavities.
    #[schemars(example = true, extend("x-default" = "outside a closed surface, both sides of an open one"))]
    pub inside: Option<Located<bool>>,
}
