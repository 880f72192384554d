//! Keys of walls and of their shapes: tables `[[walls]]` of a case.

use super::{Axis, ElasticityFile, MotionFile, RestitutionFile, Three};
use crate::case::located::Located;
use crate::case::quantity::{Length, Ratio, SpecificEnergy, Speed, Spin};
use schemars::JsonSchema;
use serde::Deserialize;

/// Table `[[walls]]`: one wall.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallFile {
    /// A flat wall. The whole space behind the plane is solid.
    #[schemars(extend("x-one-of" = "shape", "x-required" = "or another shape"))]
    pub plane: Option<Located<PlaneFile>>,
    /// A solid ball, or a hollow one with the particles inside.
    #[schemars(extend("x-one-of" = "shape"))]
    pub sphere: Option<Located<SphereFile>>,
    /// A solid block with edges along the axes.
    #[schemars(extend("x-one-of" = "shape"))]
    pub cuboid: Option<Located<CuboidFile>>,
    /// A block with edges along the axes: solid, or hollow with the particles inside.
    #[serde(rename = "box")]
    #[schemars(extend("x-one-of" = "shape"))]
    pub room: Option<Located<BoxFile>>,
    /// A cylinder along an axis: solid, hollow with the particles inside (a can, or a pipe without ends), or a thin
    /// shell.
    #[schemars(extend("x-one-of" = "shape"))]
    pub cylinder: Option<Located<CylinderFile>>,
    /// A truncated cone along an axis: solid, hollow with the particles inside, or a thin shell (a hopper).
    #[schemars(extend("x-one-of" = "shape"))]
    pub cone: Option<Located<ConeFile>>,
    /// A surface of triangles from a file.
    #[schemars(extend("x-one-of" = "shape"))]
    pub mesh: Option<Located<MeshFile>>,
    /// Name of the wall in `[[contact.pairs]]`; several walls of one material may share a name.
    #[schemars(example = &"steel wall")]
    pub name: Option<Located<String>>,
    /// Restitution e, the ratio of the normal speeds after and before an impact. 1: elastic. 0: no rebound, only for
    /// the models hard and dsmc. A table makes the restitution depend on the normal speed of the impact.
    #[schemars(example = 0.97, extend("x-required" = "always", "x-range" = "0 ..= 1"))]
    pub restitution: Option<Located<RestitutionFile>>,
    /// Coefficient of sliding friction, μ.
    #[schemars(example = 0.1, extend("default" = 0, "x-range" = "0 ..= 100"))]
    pub friction: Option<Located<Ratio>>,
    /// Coefficient of rolling friction, μ_r, of the law in `[soft.rolling]`.
    #[schemars(example = 0.05, extend("x-default" = "that of `[soft.rolling]`", "x-range" = "0 ..= 10"))]
    pub rolling_friction: Option<Located<Ratio>>,
    /// Coefficient of twisting friction. The largest torque of `[soft.twisting]` is 2/3 of this coefficient, times the
    /// radius of the contact, times the normal force.
    #[schemars(example = 0.1, extend("x-default" = "`friction`", "x-range" = "0 ..= 100"))]
    pub twisting_friction: Option<Located<Ratio>>,
    /// Roughness of the wall. Without this table the wall is smooth.
    pub roughness: Option<Located<RoughnessFile>>,
    /// Temperature of a thermal wall, for the models hard and dsmc: the variance of a velocity component of the
    /// spheres that leave the wall, whatever their velocity before. The restitution must be 1, and the friction 0.
    #[schemars(example = &"0.1 m^2/s^2", extend("x-range" = "greater than 0, up to 1e6 m^2/s^2"))]
    pub temperature: Option<Located<SpecificEnergy>>,
    /// Velocity of the surface in its own plane, such as that of a conveyor belt; the shape stays at rest. Allowed for
    /// planes, pipes without ends, and meshes all of whose triangles are parallel to the velocity.
    #[schemars(extend("examples" = [["0 m/s", "0 m/s", "0.5 m/s"]], "default" = [0, 0, 0]))]
    #[schemars(extend("x-range" = "-1e5 ..= 1e5 m/s"))]
    pub velocity: Option<Three<Speed>>,
    /// Rotation of the surface along itself, such as that of a drum or a turntable; the shape stays at rest. Allowed
    /// for planes, spheres, cylinders and cones.
    pub rotation: Option<Located<WallRotationFile>>,
    /// Motion of the shape itself, for hard, soft and hybrid spheres. Without this table the shape stays at rest.
    pub motion: Option<Located<MotionFile>>,
    /// Elasticity of this wall, if it differs from that in `[soft.hertz]` or `[soft.kuwabara_kono]`.
    pub elasticity: Option<Located<ElasticityFile>>,
}

/// Table `[walls.roughness]`: a rough wall. Each impact meets a facet of the wall with a random inclination
/// (Sommerfeld and Huber 1999).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RoughnessFile {
    /// Standard deviation of the inclination of the facets, Δγ, in each of two directions along the wall. 0 is smooth.
    #[schemars(example = &"5 deg", extend("x-required" = "always", "x-range" = "0 ..= 0.6"))]
    pub deviation: Option<Located<Ratio>>,
}

/// Table `[walls.rotation]`: rotation of the surface of a wall along itself, such as that of a drum; the shape stays
/// at rest.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallRotationFile {
    /// Angular velocity of the rotation, counter-clockwise if the axis points towards the viewer.
    #[schemars(example = &"10 rad/s", extend("x-required" = "always", "x-range" = "-1e7 ..= 1e7 rad/s"))]
    pub rate: Option<Located<Spin>>,
    /// Direction of the axis of rotation: a vector of any length. A plane turns about its normal through its `point`; a
    /// cylinder or cone turns about its own axis; a sphere turns about any axis through its centre.
    #[schemars(extend("examples" = [[0, 0, 1]], "x-default" = "that of the shape; a sphere has none"))]
    pub axis: Option<Three<Ratio>>,
}

/// Flat wall in front of a solid half-space.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneFile {
    /// A point on the plane.
    #[schemars(extend("examples" = [["0 m", "40 mm", "0 m"]], "x-required" = "always"))]
    pub point: Option<Three<Length>>,
    /// Vector from the surface towards the particles, of any length.
    #[schemars(extend("examples" = [[0, -1, 0]], "x-required" = "always"))]
    pub normal: Option<Three<Ratio>>,
}

/// Wall in the shape of a sphere: solid, or hollow with the particles inside.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereFile {
    /// Centre of the sphere.
    #[schemars(extend("examples" = [["10 mm", "10 mm", "10 mm"]], "x-required" = "always"))]
    pub center: Option<Three<Length>>,
    /// Radius of the sphere.
    #[schemars(example = &"2 mm", extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub radius: Option<Located<Length>>,
    /// True: the particles are inside the sphere. False: they are outside.
    #[schemars(example = true, extend("default" = false))]
    pub inside: Option<Located<bool>>,
}

/// Wall in the shape of a block with edges along the axes: solid or hollow.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxFile {
    /// Centre of the block.
    #[schemars(extend("examples" = [["10 mm", "10 mm", "10 mm"]], "x-required" = "always"))]
    pub center: Option<Three<Length>>,
    /// Half the edge lengths of the block along x, y and z.
    #[schemars(extend("examples" = [["5 mm", "4 mm", "5 mm"]]))]
    #[schemars(extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub half_extents: Option<Three<Length>>,
    /// True: the particles are inside the block. False: they are outside.
    #[schemars(example = true, extend("default" = false))]
    pub inside: Option<Located<bool>>,
}

/// Wall in the shape of a solid block with edges along the axes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CuboidFile {
    /// Centre of the block.
    #[schemars(extend("examples" = [["10 mm", "10 mm", "10 mm"]], "x-required" = "always"))]
    pub center: Option<Three<Length>>,
    /// Half the edge lengths of the block along x, y and z.
    #[schemars(extend("examples" = [["2 mm", "1 mm", "2 mm"]]))]
    #[schemars(extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub half_extents: Option<Three<Length>>,
}

/// Wall in the shape of a cylinder along an axis: solid, hollow, or a thin shell.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderFile {
    /// Centre of the cylinder.
    #[schemars(extend("examples" = [["10 mm", "10 mm", "10 mm"]], "x-required" = "always"))]
    pub center: Option<Three<Length>>,
    /// Direction of the axis of the cylinder.
    #[schemars(example = &"x", extend("x-required" = "always"))]
    pub axis: Option<Located<Axis>>,
    /// Radius of the cylinder.
    #[schemars(example = &"2 mm", extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub radius: Option<Located<Length>>,
    /// Half the length of the cylinder. With `inside = true` it may be left out: then the wall is a pipe without ends.
    #[schemars(example = &"3 mm", extend("x-required" = "unless `inside`", "x-range" = "greater than 0 m"))]
    pub half_height: Option<Located<Length>>,
    /// True: the particles are inside the cylinder.
    #[schemars(example = true, extend("default" = false))]
    pub inside: Option<Located<bool>>,
    /// True: the wall is a thin shell, open at both ends, with particles on both sides.
    #[schemars(example = true, extend("default" = false))]
    pub open: Option<Located<bool>>,
}

/// Wall in the shape of a truncated cone along an axis: solid, hollow, or a thin shell.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConeFile {
    /// Centre of the cone, half-way between the ends.
    #[schemars(extend("examples" = [["10 mm", "10 mm", "10 mm"]], "x-required" = "always"))]
    pub center: Option<Three<Length>>,
    /// Direction of the axis of the cone.
    #[schemars(example = &"z", extend("x-required" = "always"))]
    pub axis: Option<Located<Axis>>,
    /// Radius of the cone at its end with the smaller coordinate along the axis.
    #[schemars(example = &"2 mm", extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub lower_radius: Option<Located<Length>>,
    /// Radius of the cone at its end with the larger coordinate along the axis.
    #[schemars(example = &"6 mm", extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub upper_radius: Option<Located<Length>>,
    /// Half the length of the cone.
    #[schemars(example = &"4 mm", extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub half_height: Option<Located<Length>>,
    /// True: the particles are inside the cone, between closed ends.
    #[schemars(example = true, extend("default" = false))]
    pub inside: Option<Located<bool>>,
    /// True: the wall is a thin shell, open at both ends, with particles on both sides: a hopper.
    #[schemars(example = true, extend("default" = false))]
    pub open: Option<Located<bool>>,
}

/// A wall whose surface consists of triangles from a file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshFile {
    /// Name of an STL or OBJ file, relative to the folder of the file that contains this key. The file must be in that
    /// folder or below.
    #[schemars(example = &"hopper.stl", extend("x-required" = "always"))]
    pub file: Option<Located<String>>,
    /// Length of one unit of the file, which STL and OBJ files do not state.
    #[schemars(example = &"1 mm", extend("x-required" = "always", "x-range" = "greater than 0 m"))]
    pub unit: Option<Located<Length>>,
    /// Factor by which all lengths of the file are multiplied, in addition to `unit`.
    #[schemars(example = 0.5, extend("default" = 1, "x-range" = "greater than 0"))]
    pub scale: Option<Located<Ratio>>,
    /// Position, in the box, of the origin of the coordinates in the file.
    #[schemars(extend("examples" = [["10 mm", "0 mm", "10 mm"]], "default" = [0, 0, 0]))]
    pub position: Option<Three<Length>>,
    /// Axis about which the surface is rotated, through the origin of the coordinates in the file: a vector of any
    /// length.
    #[schemars(extend("examples" = [[1, 0, 0]], "default" = [0, 0, 1]))]
    pub axis: Option<Three<Ratio>>,
    /// Angle by which the surface is rotated, counter-clockwise if the axis points towards the viewer.
    #[schemars(example = &"90 deg", extend("default" = 0))]
    pub angle: Option<Located<Ratio>>,
    /// True: the particles are inside a closed surface. False: they are outside. Without this key a closed surface is a
    /// solid body, and an open surface is a thin sheet with particles on both sides. If the mesh includes the thickness
    /// of the wall, `true` means that the particles are in its cavities.
    #[schemars(example = true, extend("x-default" = "outside a closed surface, both sides of an open one"))]
    pub inside: Option<Located<bool>>,
}
