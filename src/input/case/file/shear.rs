//! Keys of a sheared box: table `[domain.shear]` of a case.

use super::Located;
use crate::case::quantity::{Length, Spin};
use schemars::JsonSchema;
use serde::Deserialize;

/// Table `[domain.shear]`: uniform shear of a box without walls that is periodic along x, y and z. The mean flow is
/// along z and grows along y. Images of the particles across y slide along z. Particles with random velocities at the
/// start get the velocity of the mean flow in addition.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShearFile {
    /// Shear rate γ of the mean flow U_z = γ y.
    #[schemars(example = &"20 1/s", extend("x-required" = "always", "x-range" = "-1e9 ..= 1e9 1/s"))]
    pub rate: Option<Located<Spin>>,
    /// Displacement along z, at the start, of the periodic image one box height above each particle. A saved state
    /// contains this displacement.
    #[schemars(example = &"1.5 mm", extend("default" = "0 m", "x-range" = "-1e4 ..= 1e4 m"))]
    pub offset: Option<Located<Length>>,
    /// Orbit of the box about a distant mass, with the Coriolis force and the tides of a shearing sheet.
    pub orbit: Option<Located<OrbitFile>>,
}

/// Table `[domain.shear.orbit]`: motion of the box on a circular orbit about a distant mass, as in planetary rings. The
/// box rotates about x, y points away from the mass, and z along the orbit. Without this table the frame is at rest.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OrbitFile {
    /// Angular velocity Ω of the orbit about x. Around a point mass the shear rate is -3/2 Ω.
    #[schemars(example = &"1.3e-4 1/s", extend("x-required" = "always", "x-range" = "-1e9 ..= 1e9 1/s"))]
    pub rate: Option<Located<Spin>>,
    /// Frequency ν of oscillations along x about the middle of the box.
    #[schemars(example = &"0 1/s", extend("x-default" = "|Ω|, as around a point mass", "x-range" = "0 ..= 1e9 1/s"))]
    pub vertical_frequency: Option<Located<Spin>>,
}
