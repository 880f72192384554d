//! The logarithmic law of the wall over the whole channel, without a turbulence model.
//!
//! U⁺ = ln(y⁺)/κ + B holds between the wall region and the middle of a channel. Reichardt's formula (1951, ZAMM 31,
//! 208) joins it smoothly to U⁺ = y⁺ at the wall,
//!
//! ```text
//! U⁺ = ln(1 + κ y⁺)/κ + C (1 - exp(-y⁺/11) - y⁺/11 exp(-y⁺/3)),   C = B - ln(κ)/κ
//! ```
//!
//! Lengths in this formula are in units of ν/u_τ, velocities in units of u_τ. The formula is used from the wall to the
//! middle plane, and mirrored at this plane. In the middle, a real channel flow is some per cent faster (the wake) and
//! its profile is smooth, which the formula does not describe.

use serde::Serialize;

/// [-] distance y⁺ over which the first correction of Reichardt's formula near the wall decays, exp(-y⁺/11):
/// Reichardt's value.
const OUTER_FADE: f64 = 11.0;
/// [-] distance y⁺ over which the second correction of Reichardt's formula near the wall decays, y⁺/11 exp(-y⁺/3):
/// Reichardt's value.
const INNER_FADE: f64 = 3.0;

/// Constants κ and B of the logarithmic law U⁺ = ln(y⁺)/κ + B.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LogConstants {
    /// [-] von Kármán's constant κ.
    pub von_karman: f64,
    /// [-] additive constant B for a smooth wall.
    pub intercept: f64,
}

impl Default for LogConstants {
    /// Returns κ = 0.41 and B = 5.0: Coles and Hirst 1968 (Stanford conference).
    fn default() -> Self {
        Self { von_karman: 0.41, intercept: 5.0 }
    }
}

impl LogConstants {
    /// [-] constant C = B - ln(κ)/κ of Reichardt's formula.
    fn amplitude(self) -> f64 {
        self.intercept - self.von_karman.ln() / self.von_karman
    }

    /// [-] velocity U⁺ by Reichardt's formula at the distance y⁺ >= 0 from the wall.
    fn velocity(self, y: f64) -> f64 {
        let kappa = self.von_karman;
        let wall = 1.0 - (-y / OUTER_FADE).exp() - y / OUTER_FADE * (-y / INNER_FADE).exp();
        (kappa * y).ln_1p() / kappa + self.amplitude() * wall
    }

    /// [-] slope dU⁺/dy⁺ at the distance y⁺ >= 0 from the wall.
    fn slope(self, y: f64) -> f64 {
        let (outer, inner) = ((-y / OUTER_FADE).exp(), (-y / INNER_FADE).exp());
        1.0 / (1.0 + self.von_karman * y) + self.amplitude() / OUTER_FADE * (outer - inner + y / INNER_FADE * inner)
    }

    /// [-] integral ∫ U⁺ dy⁺ from the wall to y⁺ = `h`.
    fn flow(self, h: f64) -> f64 {
        let kappa = self.von_karman;
        let logarithm = ((1.0 + kappa * h) * (kappa * h).ln_1p() - kappa * h) / (kappa * kappa);
        let first = OUTER_FADE * (1.0 - (-h / OUTER_FADE).exp());
        let second = INNER_FADE * (INNER_FADE - (-h / INNER_FADE).exp() * (h + INNER_FADE)) / OUTER_FADE;
        logarithm + self.amplitude() * (h - first - second)
    }
}

/// Channel flow between walls at y = 0 and y = `height`, described by the logarithmic law of the wall.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LogLaw {
    /// The constants κ and B of the law.
    pub constants: LogConstants,
    /// [m] full width 2h of the channel.
    pub height: f64,
    /// [m²/s] kinematic viscosity ν.
    pub kinematic_viscosity: f64,
    /// [m/s] friction velocity u_τ at the walls.
    pub friction_velocity: f64,
    /// [m/s] mean velocity over the width of the channel.
    pub bulk_velocity: f64,
}

impl LogLaw {
    /// [-] bulk Reynolds number U_b 2h/ν below which a channel is not fully turbulent: lower end of the data of Dean
    /// 1978.
    pub const LOWEST_REYNOLDS: f64 = 6000.0;

    /// Makes a channel flow with a given friction velocity [m/s], from which the bulk velocity is computed. `height`
    /// [m] is the full width of the channel, and the kinematic viscosity is in m²/s.
    ///
    /// # Errors
    /// A number that is not positive, or a bulk Reynolds number below 6000.
    pub fn with_friction_velocity(
        friction_velocity: f64,
        height: f64,
        kinematic_viscosity: f64,
        constants: LogConstants,
    ) -> Result<Self, String> {
        for (name, value) in [
            ("friction velocity", friction_velocity),
            ("height", height),
            ("kinematic viscosity", kinematic_viscosity),
            ("von Kármán constant", constants.von_karman),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(format!("the {name} must be positive, it is {value}"));
            }
        }
        if !constants.intercept.is_finite() {
            return Err(format!("the intercept must be a number, it is {}", constants.intercept));
        }
        let half = 0.5 * height * friction_velocity / kinematic_viscosity;
        let bulk_velocity = friction_velocity * constants.flow(half) / half;
        let reynolds = bulk_velocity * height / kinematic_viscosity;
        if reynolds < Self::LOWEST_REYNOLDS {
            return Err(format!(
                "a turbulent channel has a bulk Reynolds number U_b L_y/ν of {} or more, this one {reynolds:.0}",
                Self::LOWEST_REYNOLDS
            ));
        }
        Ok(Self { constants, height, kinematic_viscosity, friction_velocity, bulk_velocity })
    }

    /// Makes a channel flow with a given bulk velocity [m/s], from which the friction velocity is computed. `height`
    /// [m] is the full width of the channel, and the kinematic viscosity is in m²/s.
    ///
    /// # Errors
    /// Errors of [`LogLaw::with_friction_velocity`].
    pub fn with_bulk_velocity(
        bulk_velocity: f64,
        height: f64,
        kinematic_viscosity: f64,
        constants: LogConstants,
    ) -> Result<Self, String> {
        // the bulk velocity increases with u_τ: bisection between 0 and the bulk velocity, which is an upper limit of
        // u_τ
        let (mut low, mut high) = (0.0, bulk_velocity);
        let wanted = 0.5 * bulk_velocity * height / kinematic_viscosity;
        // 60 halvings reach the rounding error
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if constants.flow(0.5 * height * middle / kinematic_viscosity) < wanted {
                low = middle;
            } else {
                high = middle;
            }
        }
        Self::with_friction_velocity(0.5 * (low + high), height, kinematic_viscosity, constants)
    }

    /// [m/s] velocity at the distance `y` [m] from the wall y = 0; zero at both walls and outside the channel.
    #[inline]
    pub fn velocity(&self, y: f64) -> f64 {
        let nearest = y.min(self.height - y).max(0.0);
        let scale = self.friction_velocity / self.kinematic_viscosity;
        self.friction_velocity * self.constants.velocity(nearest * scale)
    }

    /// [1/s] slope of the velocity at the distance `y` [m] from the wall y = 0; zero outside the channel.
    pub fn slope(&self, y: f64) -> f64 {
        if !(0.0..=self.height).contains(&y) {
            return 0.0;
        }
        let (nearest, sign) = if 2.0 * y > self.height { (self.height - y, -1.0) } else { (y, 1.0) };
        let scale = self.friction_velocity / self.kinematic_viscosity;
        sign * self.friction_velocity * scale * self.constants.slope(nearest * scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAPER: (f64, f64) = (0.04, 1.515e-5);

    fn law(friction_velocity: f64) -> LogLaw {
        LogLaw::with_friction_velocity(friction_velocity, PAPER.0, PAPER.1, LogConstants::default()).unwrap()
    }

    /// Compares the integral of the velocity in closed form with the midpoint rule on 200 000 intervals.
    #[test]
    fn the_flow_is_the_integral_of_the_velocity() {
        let constants = LogConstants::default();
        for h in [1.0, 30.0, 1056.0] {
            let count = 200_000;
            let step = h / f64::from(count);
            let sum: f64 = (0..count).map(|k| constants.velocity((f64::from(k) + 0.5) * step) * step).sum();
            assert!((constants.flow(h) / sum - 1.0).abs() < 1e-8, "{h}: {} {sum}", constants.flow(h));
        }
    }

    /// Compares Reichardt's formula for U⁺(y⁺) with its two limits. Near the wall U⁺ = y⁺ - 0.017 y⁺². Far from the
    /// wall U⁺ exceeds the logarithmic law by 1/(κ² y⁺), which is 0.006 at y⁺ = 1000.
    #[test]
    fn both_limits() {
        let constants = LogConstants::default();
        assert!((constants.velocity(1e-4) / 1e-4 - 1.0).abs() < 1e-4);
        for y in [300.0, 1000.0] {
            let log = f64::ln(y) / 0.41 + 5.0;
            assert!((constants.velocity(y) - log - 1.0 / (0.41 * 0.41 * y)).abs() < 1e-4, "{y}");
        }
    }

    #[test]
    fn either_velocity_gives_the_other() {
        let law = law(0.80);
        let again = LogLaw::with_bulk_velocity(law.bulk_velocity, PAPER.0, PAPER.1, law.constants).unwrap();
        assert!((again.friction_velocity / 0.80 - 1.0).abs() < 1e-12);
        // symmetric except for rounding of height - y; zero at both walls and outside the channel
        assert!((law.velocity(0.013) / law.velocity(0.04 - 0.013) - 1.0).abs() < 1e-12);
        assert_eq!([law.velocity(0.0), law.velocity(0.04), law.velocity(-1.0)], [0.0; 3]);
    }

    #[test]
    fn bad_numbers_are_refused() {
        let of = |u, constants| LogLaw::with_friction_velocity(u, PAPER.0, PAPER.1, constants);
        assert!(of(0.0, LogConstants::default()).is_err());
        assert!(of(0.05, LogConstants::default()).unwrap_err().contains("6000"));
        assert!(of(0.8, LogConstants { von_karman: -0.4, intercept: 5.0 }).is_err());
        assert!(of(0.8, LogConstants { von_karman: 0.41, intercept: f64::NAN }).is_err());
    }
}
