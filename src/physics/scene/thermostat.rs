//! Thermostats: heating of the particles from outside, which replaces the energy that collisions dissipate. It acts at
//! the ends of windows, the times between two kicks (changes of the velocities) by drag or heat.

use serde::Serialize;

/// Heating of all particles, in addition to gravity and gas. It changes velocities alone, at the ends of windows
/// (times between two exchanges with the gas), and keeps the total momentum. Velocities c are relative to the mean
/// velocity of all particles and, in a sheared box, to the mean flow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Thermostat {
    /// Random accelerations, white in time and independent for each particle (Williams and MacKintosh 1996, Phys. Rev.
    /// E 54, R9). Within a time h each component of the velocity changes by a Gaussian number of variance `heating` h.
    Stochastic {
        /// [m²/s³] growth rate of the granular temperature without collisions, ξ² of van Noije and Ernst (1998,
        /// Granular Matter 1, 57).
        heating: f64,
    },
    /// The force m c times `rate` on each particle, with its mass m and its velocity c relative to the mean velocity.
    /// Velocities c grow exponentially (Montanero and Santos 2000, Granular Matter 2, 53). A gas heated in this way
    /// has the velocity distribution of a cooling gas.
    Gaussian {
        /// [1/s] growth rate of the velocities relative to the mean velocity; half the growth rate of the granular
        /// temperature.
        rate: f64,
    },
}

impl Thermostat {
    /// [m²/s²] granular temperature T that a gas without losses reaches after `time` [s] from the temperature
    /// `at_start` [m²/s²].
    pub fn temperature_after(&self, at_start: f64, time: f64) -> f64 {
        match self {
            Self::Stochastic { heating } => at_start + heating * time,
            Self::Gaussian { rate } => at_start * (2.0 * rate * time).exp(),
        }
    }

    /// [m²/s²] granular temperature T at which heating balances the losses of collisions, by which T decreases at the
    /// rate `cooling` T^(3/2). It is infinite if `cooling` [1/m] is 0.
    pub fn steady_temperature(&self, cooling: f64) -> f64 {
        match self {
            // heating = cooling T^(3/2)
            Self::Stochastic { heating } => (heating / cooling).powf(2.0 / 3.0),
            // 2 rate T = cooling T^(3/2)
            Self::Gaussian { rate } => (2.0 * rate / cooling).powi(2),
        }
    }
}
