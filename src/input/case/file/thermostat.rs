//! Keys of thermostats, which heat the particles from outside: tables `[thermostat.*]` of a case.

use super::Located;
use crate::case::quantity::{DissipationRate, Spin};
use schemars::JsonSchema;
use serde::Deserialize;

/// Tables `[thermostat.*]`: choice of a thermostat, which heats all particles from outside. It keeps the total momentum
/// and does not act on spins.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ThermostatFile {
    /// Random accelerations, uncorrelated in time (white noise) and independent for each particle (Williams and
    /// MacKintosh 1996).
    Stochastic {
        /// Growth rate of the granular temperature without collisions: the variance that each velocity component gains
        /// per time.
        #[schemars(example = &"10 m^2/s^3", extend("x-required" = "always"))]
        #[schemars(extend("x-range" = "greater than 0, up to 1e12 m^2/s^3"))]
        heating: Option<Located<DissipationRate>>,
    },
    /// Velocities relative to the mean velocity grow exponentially (Montanero and Santos 2000).
    Gaussian {
        /// Growth rate of the velocities relative to the mean velocity, half that of the granular temperature.
        #[schemars(example = &"5 1/s", extend("x-required" = "always", "x-range" = "greater than 0, up to 1e9 1/s"))]
        rate: Option<Located<Spin>>,
    },
}
