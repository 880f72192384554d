//! Table of a sheared box.

use super::Located;
use crate::case::quantity::{Length, Spin};
use schemars::JsonSchema;
use serde::Deserialize;

/// Table `[domain.shear]`: uniform shear of a box without walls that is periodic along x, y and z. The mean flow is
/// along z and grows along y. Images of the particles across y slide along z. Random starts get the mean flow in
/// addition to their velocities.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShearFile {
    /// Shear rate γ of the mean flow U_z = γ y.
    #[schemars(example = &"20 1/s", extend("x-required" = "always", "x-range" = "-1e9 ..= 1e9 1/s"))]
    pub rate: Option<Located<Spin>>,
    /// Displacement along z, at the start, of the periodic image one box height above each particle. A saved state
    /// contains it.
    #[schemars(example = &"1.5 mm", extend("default" = "0 m", "x-range" = "-1e4 ..= 1e4 m"))]
    pub offset: Option<Located<Length>>,
}
