//! Collision integral of soft spheres, which measures how effectively collisions change the directions of the
//! particles' velocities.
//!
//! Collisions make the agitation in the three directions equal, at the rate p/η of a gas with the pressure p and the
//! viscosity η. In Chapman and Enskog's theory of a dilute gas this rate is proportional to the collision integral
//! Ω^(2,2) of the force between two particles (Chapman and Cowling 1970, section 9.33; Hirschfelder, Curtiss and Bird
//! 1954, section 8.2),
//!
//! ```text
//! Ω^(2,2) ∝ ∫ γ⁷ exp(-γ²) Q(γ) dγ,   Q = 2π ∫ sin²χ b db,
//! ```
//!
//! where χ is the angle by which two particles with the impact parameter b and the reduced relative speed γ deflect
//! each other. All results of this file are relative to hard spheres, for which Q = 2π d²/3. The contact is a linear
//! spring without damping. Distances r and b are in units of the diameter.

use std::f64::consts::{PI, SQRT_2};

/// Number of intervals of Simpson's rule along the path of two spheres in contact, from their smallest distance to the
/// end of the contact. Few intervals are enough, since the integrand varies only by a factor of two.
const PATH: usize = 16;
/// Number of intervals of Simpson's rule over the impact parameter. The finest detail is due to grazing contacts, whose
/// impact parameter differs from the diameter by less than an overlap.
const ANGLES: usize = 256;
/// Number of intervals of Simpson's rule over the reduced speed, from 0 to `FASTEST`.
const SPEEDS: usize = 64;
/// [-] largest reduced speed γ of the quadrature. The part of ∫ γ⁷ exp(-γ²) dγ at higher speeds is less than 1e-12.
const FASTEST: f64 = 6.5;

/// Integrates a function from 0 to `end` by Simpson's rule with an even number of intervals.
fn simpson(end: f64, intervals: usize, of: impl Fn(f64) -> f64) -> f64 {
    let step = end / intervals as f64;
    let weight = |k: usize| match k {
        0 => 1.0,
        k if k == intervals => 1.0,
        k if k % 2 == 1 => 4.0,
        _ => 2.0,
    };
    (0..=intervals).map(|k| weight(k) * of(k as f64 * step)).sum::<f64>() * step / 3.0
}

/// [rad] angle χ by which an impact turns the relative velocity of two soft spheres: π for a head-on impact, 0 for a
/// miss.
///
/// `impact` is the impact parameter b, and `depth` the largest overlap a = u sqrt(M/k)/d of a head-on impact at the
/// same speed u, with the effective mass M and the stiffness k. Both are divided by the diameter d [-]. The angle is χ
/// = π - 2 asin b - 2 φ, where φ is half the angle by which the spheres turn about each other during contact,
///
/// ```text
/// φ = ∫ b dr/(r² sqrt(1 - b²/r² - (1-r)²/a²))   from the turning point to r = 1.
/// ```
///
/// The result is valid for a < 1. In a deeper impact the centres of the spheres would pass through each other.
pub fn deflection(impact: f64, depth: f64) -> f64 {
    if impact >= 1.0 {
        return 0.0;
    }
    // the turning point is r = 1 - a w, where (1 - a w)² (1 - w²) = b² decreases with w
    let (mut low, mut high) = (0.0, 1.0);
    // 60 halvings reach the rounding error
    for _ in 0..60 {
        let w: f64 = 0.5 * (low + high);
        if (1.0 - depth * w).powi(2) * (1.0 - w * w) > impact * impact { low = w } else { high = w }
    }
    let w = 0.5 * (low + high);
    let turn = 1.0 - depth * w;
    // the substitution r = turn + (1 - turn) t² removes the root at the turning point from the integrand
    let path = |t: f64| {
        let left = 1.0 - t * t;
        let r = 1.0 - depth * w * left;
        let under = depth * (r + turn) + w * (r * left + turn) * (r + turn - 1.0);
        2.0 * impact * depth * w.sqrt() / (r * under.sqrt())
    };
    PI - 2.0 * impact.asin() - 2.0 * simpson(1.0, PATH, path)
}

/// [-] effective cross-section Q of soft spheres at one speed, over that of hard spheres: 3 ∫ sin²χ b db, with the
/// angle χ of [`deflection`] and the impact parameter b in diameters. `depth` is the largest overlap of a head-on
/// impact at this speed, over the diameter [-].
fn turned(depth: f64) -> f64 {
    // the substitution b = sin θ resolves grazing impacts
    let of = |theta: f64| {
        let (impact, cosine) = theta.sin_cos();
        deflection(impact, depth).sin().powi(2) * impact * cosine
    };
    3.0 * simpson(0.5 * PI, ANGLES, of)
}

/// [-] collision integral Ω^(2,2) of soft spheres over that of hard spheres. It is proportional to the rate at which
/// collisions make the agitation of different directions equal. It is 1 for infinitely stiff spheres, and 1 - π
/// sqrt(2π)/4 s to first order in the softness s.
///
/// `softness` is s = sqrt(m T/k)/d [-], with the granular temperature T; the overlap number is κ_n = sqrt(2/π) s.
/// Barker and Henderson's diameter d_eff reduces the cross-section of hard spheres by the fraction 2 (1 - d_eff/d) =
/// sqrt(2π) s. To first order, Ω^(2,2) decreases by π/4 times this fraction. The result is valid for a dilute gas and s
/// up to 0.15. At larger s, spheres with the reduced speed γ = 4.7 would pass through each other's centre.
pub fn viscosity_integral(softness: f64) -> f64 {
    // the integral ∫ γ⁷ exp(-γ²) dγ from 0 to infinity is Γ(4)/2
    const NORM: f64 = 3.0;
    let of = |gamma: f64| gamma.powi(7) * (-gamma * gamma).exp() * turned((SQRT_2 * softness * gamma).min(1.0));
    simpson(FASTEST, SPEEDS, of) / NORM
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks hard spheres, whose overlap is 0: the angle of deflection is χ = π - 2 asin b with the impact parameter
    /// b, and the collision integral is 1, with the error of the three quadratures (1e-6).
    #[test]
    fn without_softness_spheres_are_hard() {
        for impact in [0.0, 0.3, 0.9, 0.999] {
            assert!((deflection(impact, 0.0) - (PI - 2.0 * f64::asin(impact))).abs() < 1e-12);
        }
        assert_eq!(deflection(1.0, 0.01), 0.0);
        assert!((viscosity_integral(0.0) - 1.0).abs() < 1e-6, "{}", viscosity_integral(0.0));
    }

    /// Checks that a head-on impact is reflected at any stiffness. In an oblique impact with the impact parameter b,
    /// the spheres turn about each other during the contact. It lasts for π d a/u, with the diameter d, the overlap a
    /// in diameters and the speed u. To first order the angle of this turn is π a b, as follows from the integral.
    #[test]
    fn contacts_that_last_turn_less() {
        assert!((deflection(0.0, 0.2) - PI).abs() < 1e-12);
        for impact in [0.2, 0.5, 0.8] {
            let [one, half] = [2e-3, 1e-3].map(|a| (PI - 2.0 * f64::asin(impact) - deflection(impact, a)) / a);
            // Richardson's extrapolation; the remainder is of second order in a
            assert!((2.0 * half - one - PI * impact).abs() < 2e-4, "{impact}: {half}");
        }
    }

    /// Compares the deflection with the path of two spheres on a spring, computed by time steps independently of the
    /// quadrature (Störmer and Verlet, 2000 steps per contact).
    #[test]
    fn the_angle_is_that_of_a_path() {
        for (impact, depth) in [(0.3f64, 0.05f64), (0.7, 0.2), (0.95, 0.1)] {
            // units: u = 1, M = 1, k = 1/a²; the path begins at the instant of touch
            let (mut x, mut y) = (-(1.0 - impact * impact).sqrt(), impact);
            let (mut vx, mut vy) = (1.0, 0.0);
            let step = PI * depth / 2000.0;
            loop {
                (x, y) = (x + 0.5 * step * vx, y + 0.5 * step * vy);
                let r = f64::hypot(x, y);
                if r > 1.0 && x * vx + y * vy > 0.0 {
                    break;
                }
                let pull = (1.0 - r).max(0.0) / (depth * depth * r) * step;
                (vx, vy) = (vx + pull * x, vy + pull * y);
                (x, y) = (x + 0.5 * step * vx, y + 0.5 * step * vy);
            }
            let angle = vy.atan2(vx);
            assert!((angle - deflection(impact, depth)).abs() < 2e-3, "{impact} {depth}: {angle}");
        }
    }

    /// Checks the decrease 1 - Ω^(2,2) of the collision integral, which is π sqrt(2π)/4 s to first order in the
    /// softness s (docs/theory/softness.md). Two values of s, one half of the other, remove the second order.
    #[test]
    fn first_order_in_the_softness() {
        let lost = |s: f64| (viscosity_integral(0.0) - viscosity_integral(s)) / s;
        let first = 2.0 * lost(1e-3) - lost(2e-3);
        assert!((first / (PI * (2.0 * PI).sqrt() / 4.0) - 1.0).abs() < 2e-3, "{first}");
    }
}
