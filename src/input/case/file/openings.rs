//! Keys of inlets and outlets (places where particles come in and leave): tables `[[inlets]]` and `[[outlets]]` of a
//! case.

use super::{BlockRegionFile, CylinderRegionFile, PlaneFile, Three};
use crate::case::located::Located;
use crate::case::quantity::{Length, MassRate, Ratio, Spin, Time};
use schemars::JsonSchema;
use serde::Deserialize;

/// Side of the box, such as `-y`: the axis, with the sign of the direction out of the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
pub enum OutletSideFile {
    /// Side of the box at x = 0.
    #[serde(rename = "-x")]
    LowerX,
    /// Side of the box at the largest x.
    #[serde(rename = "+x")]
    UpperX,
    /// Side of the box at y = 0.
    #[serde(rename = "-y")]
    LowerY,
    /// Side of the box at the largest y.
    #[serde(rename = "+y")]
    UpperY,
    /// Side of the box at z = 0.
    #[serde(rename = "-z")]
    LowerZ,
    /// Side of the box at the largest z.
    #[serde(rename = "+z")]
    UpperZ,
}

/// Table `[[outlets]]`: a place where particles leave, of exactly one shape. A particle leaves at the end of the first
/// window (time between two drag kicks) at which its centre is there.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutletFile {
    /// Name of the outlet in results.
    #[schemars(example = &"floor", extend("x-default" = "`outlet 0`, `outlet 1`, …"))]
    pub name: Option<Located<String>>,
    /// Outlet behind a side of the box, which particles cross. The box must not be periodic along the axis of this
    /// side.
    #[schemars(example = &"-y", extend("x-one-of" = "shape", "x-required" = "or `plane`, `box`, `cylinder`, `mesh`"))]
    pub side: Option<Located<OutletSideFile>>,
    /// Outlet behind a plane, whose normal points to the particles that stay.
    #[schemars(extend("x-one-of" = "shape"))]
    pub plane: Option<Located<PlaneFile>>,
    /// Outlet in the shape of a block with edges along the axes. Particles that fly through the block within one
    /// window (time between two drag kicks) do not leave.
    #[serde(rename = "box")]
    #[schemars(extend("x-one-of" = "shape"))]
    pub block: Option<Located<BlockRegionFile>>,
    /// Outlet in the shape of a cylinder along an axis. Particles that fly through the cylinder within one window
    /// (time between two drag kicks) do not leave.
    #[schemars(extend("x-one-of" = "shape"))]
    pub cylinder: Option<Located<CylinderRegionFile>>,
    /// Outlet inside a closed surface of triangles from a file. Particles in cavities of the surface, and those that
    /// fly through it within one window (time between two drag kicks), do not leave.
    #[schemars(extend("x-one-of" = "shape"))]
    pub mesh: Option<Located<OutletMeshFile>>,
}

/// Closed surface of triangles from a file, in which particles leave. It must not reach beyond periodic sides of the
/// box.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutletMeshFile {
    /// Name of an STL or OBJ file, relative to the folder of the file that contains this key. The file must be in that
    /// folder or below.
    #[schemars(example = &"catcher.stl", extend("x-required" = "always"))]
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
}

/// Table `[[inlets]]`: a place where particles come in, at random positions without overlap. Their sizes, velocities
/// and spins are those of a table `[[particles]]`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InletFile {
    /// Name of the inlet in results.
    #[schemars(example = &"feed", extend("x-default" = "`inlet 0`, `inlet 1`, …"))]
    pub name: Option<Located<String>>,
    /// The `name` of the particles that come in. A kind with `count = 0` comes in only here.
    #[schemars(example = &"glass 2 mm", extend("x-required" = "always"))]
    pub particles: Option<Located<String>>,
    /// A block in which new particles are placed. It contains each of them wholly.
    #[serde(rename = "box")]
    #[schemars(extend("x-one-of" = "region", "x-required" = "or `cylinder`"))]
    pub block: Option<Located<BlockRegionFile>>,
    /// A cylinder along an axis, in which new particles are placed. It contains each of them wholly.
    #[schemars(extend("x-one-of" = "region"))]
    pub cylinder: Option<Located<CylinderRegionFile>>,
    /// Number of particles that come in per time, at equal intervals.
    #[schemars(example = &"2000 1/s", extend("x-one-of" = "rate", "x-required" = "or `mass_rate`"))]
    #[schemars(extend("x-range" = "greater than 0, up to 1e9 1/s"))]
    pub rate: Option<Located<Spin>>,
    /// Mass of the particles that come in per time. With `sizes`, the rate in particles follows from the mean mass.
    #[schemars(example = &"20 g/s", extend("x-one-of" = "rate", "x-range" = "greater than 0, up to 1e6 kg/s"))]
    pub mass_rate: Option<Located<MassRate>>,
    /// Time at which the inlet opens.
    #[schemars(example = &"0.5 s", extend("default" = "0 s", "x-range" = "0 ..= 1e9 s"))]
    pub start: Option<Located<Time>>,
    /// Time at which the inlet closes, after `start`.
    #[schemars(example = &"2 s", extend("x-default" = "stays open", "x-range" = "greater than 0 s"))]
    pub end: Option<Located<Time>>,
}
