//! Drag of a sphere at finite Reynolds number, by the correlation that the paper (`docs/paper.md`) uses. The Reynolds
//! number is Re = w d/ν, with the slip speed w, the diameter d and the kinematic viscosity ν.

use super::{DragLaw, Sphere};

/// [-] exponent p of the drag coefficient C_D = 24/Re (1 + 0.15 Re^p), with the Reynolds number Re: Schiller and
/// Naumann 1935, to which Eq. 2 of the paper (`docs/paper.md`) refers.
const EXPONENT: f64 = 0.687;
/// [-] factor 0.15 of the drag coefficient C_D = 24/Re (1 + 0.15 Re^0.687), with the Reynolds number Re: Schiller and
/// Naumann 1935, to which Eq. 2 of the paper (`docs/paper.md`) refers.
const FACTOR: f64 = 0.15;
/// [-] Reynolds number Re up to which C_D = 24/Re (1 + 0.15 Re^0.687) is valid: Schiller and Naumann 1935.
const SWITCH: f64 = 1000.0;
/// [-] constant drag coefficient C_D at Reynolds numbers above `SWITCH` (Newton's regime), as usual with the law of
/// Schiller and Naumann: docs/theory/gas.md.
const PLATEAU: f64 = 0.44;
/// [-] product C_D Re of drag coefficient and Reynolds number in Stokes drag.
const STOKES: f64 = 24.0;

/// [-] slip Reynolds number above which a warning is given: ten times the largest number at which the formula of
/// Schiller and Naumann is valid.
const FAR: f64 = 10.0 * SWITCH;

/// Drag law of Schiller and Naumann (1935): C_D = 24/Re (1 + 0.15 Re^0.687) up to Re = 1000, and C_D = 0.44 above. Eq.
/// 2 of the paper (`docs/paper.md`) refers to this correlation; the constants are those of the literature. Re is the
/// Reynolds number, C_D the drag coefficient.
///
/// At Re = 1000 C_D jumps by 0.4 % (from 0.4383 to 0.44). The law is valid for a single rigid sphere in steady motion
/// at Re < 2e5. It neglects neighbours, lift, added mass and history force.
///
/// Drag alone decreases the slip speed w as follows, with s = 0.15 Re^p, p = 0.687 and the Stokes response time τ_S.
/// Up to Re = 1000, dw/dt = -(1 + s) w/τ_S. This Bernoulli equation is linear in w^-p. Above Re = 1000, dw/dt = -C_D
/// Re/24 w/τ_S with C_D = 0.44. This equation is linear in 1/w. Both equations have closed solutions. If the sphere
/// starts above Re = 1000 and ends below, the two solutions are used one after the other.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SchillerNaumann;

impl SchillerNaumann {
    /// [-] logarithm of the ratio w/w0 of the slip speeds after and before the time t = `duration` [s], for Re <= 1000.
    /// The ratio is w/w0 = [1 + (1 + s) (e^a - 1)]^(-1/p) with a = p t/τ_S, p = 0.687 and s = 0.15 Re^p at w0. The
    /// logarithm is computed as -t/τ_S - ln[1 + s (1 - e^-a)]/p. This form does not overflow for long times, and is
    /// precise for short times.
    fn log_decay_below(stokes_time: f64, reynolds: f64, duration: f64) -> f64 {
        let time = duration / stokes_time;
        let correction = FACTOR * reynolds.powf(EXPONENT);
        -time - (-correction * (-EXPONENT * time).exp_m1()).ln_1p() / EXPONENT
    }
}

impl DragLaw for SchillerNaumann {
    fn name(&self) -> &'static str {
        "schiller_naumann"
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    fn title(&self) -> String {
        "drag by Schiller and Naumann".into()
    }

    fn far(&self) -> Option<(f64, &'static str)> {
        let why = "the formula of Schiller and Naumann ends at 1000; its constant 0.44 beyond is right to some 13 % up to 2e5 \
                   and several times too large from 4e5 on (Clift, Grace & Weber 1978)";
        Some((FAR, why))
    }

    fn log_decay(&self, sphere: &Sphere, slip: f64, duration: f64) -> f64 {
        let reynolds = sphere.reynolds_per_speed * slip;
        if reynolds <= SWITCH {
            return Self::log_decay_below(sphere.stokes_time, reynolds, duration);
        }
        // Above Re = 1000, d(1/Re)/dt is constant: Re is divided by 1 + growth.
        let rate = PLATEAU * reynolds / (STOKES * sphere.stokes_time);
        let growth = rate * duration;
        let to_switch = (reynolds - SWITCH) / SWITCH;
        if growth <= to_switch {
            -growth.ln_1p()
        } else {
            let rest = duration - to_switch / rate;
            Self::log_decay_below(sphere.stokes_time, SWITCH, rest) - to_switch.ln_1p()
        }
    }

    fn response_time(&self, sphere: &Sphere, slip: f64) -> f64 {
        let reynolds = sphere.reynolds_per_speed * slip;
        let correction =
            if reynolds <= SWITCH { 1.0 + FACTOR * reynolds.powf(EXPONENT) } else { PLATEAU * reynolds / STOKES };
        sphere.stokes_time / correction
    }

    fn relaxation_time(&self, sphere: &Sphere, slip: f64) -> f64 {
        let reynolds = sphere.reynolds_per_speed * slip;
        // the deceleration is (w + 0.15 Re^p w)/τ_S up to Re = 1000, and proportional to w² above
        let slope = if reynolds <= SWITCH {
            1.0 + (1.0 + EXPONENT) * FACTOR * reynolds.powf(EXPONENT)
        } else {
            2.0 * PLATEAU * reynolds / STOKES
        };
        sphere.stokes_time / slope
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: SchillerNaumann = SchillerNaumann;

    /// The paper's spheres (`docs/paper.md`) of 1.5 mm diameter in air, for which Re = 1000 at a slip speed of 10.1
    /// m/s.
    const LARGE: Sphere = Sphere { stokes_time: 7.066_266_793, reynolds_per_speed: 1.5e-3 / 1.515e-5, fraction: 0.0 };

    /// Slip speed w [m/s] after `duration` [s] of drag alone, from the slip speed `slip` [m/s]. The equation dw/dt =
    /// -w/τ(w), with the response time τ, is integrated by the classical fourth-order Runge-Kutta method.
    fn integrate(slip: f64, duration: f64, steps: usize) -> f64 {
        let rate = |w: f64| -w / LAW.response_time(&LARGE, w);
        let h = duration / steps as f64;
        (0..steps).fold(slip, |w, _| {
            let a = rate(w);
            let b = rate(w + 0.5 * h * a);
            let c = rate(w + 0.5 * h * b);
            let d = rate(w + h * c);
            w + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        })
    }

    #[test]
    fn two_kicks_are_one_kick() {
        // A sphere at 18 m/s starts above Re = 1000; it crosses Re = 1000 after, at or before the times used here.
        for slip in [0.0, 1e-6, 0.3, 10.0, 10.1, 12.0, 18.0, 400.0] {
            for (first, second) in [(1e-6, 1e-6), (1e-4, 0.3), (0.5, 0.5), (3.0, 0.01), (20.0, 40.0)] {
                let half = LAW.decay(&LARGE, slip, first);
                let product = half * LAW.decay(&LARGE, slip * half, second);
                let whole = LAW.decay(&LARGE, slip, first + second);
                assert!((product / whole - 1.0).abs() < 1e-13, "slip {slip}, {first} + {second}: {product} {whole}");
            }
        }
    }

    #[test]
    fn flow_solves_the_equation() {
        // Each case stays on one side of Re = 1000: Runge-Kutta is of fourth order only where the law is smooth.
        for (slip, duration) in [(0.01, 2.0), (2.0, 1.0), (10.0, 3.0), (18.0, 0.1), (40.0, 0.05)] {
            let exact = slip * LAW.decay(&LARGE, slip, duration);
            let numeric = integrate(slip, duration, 4000);
            assert!((exact / numeric - 1.0).abs() < 1e-12, "slip {slip}: {exact} {numeric}");
        }
    }

    #[test]
    fn relaxation_time_is_the_slope_of_the_deceleration() {
        let deceleration = |w: f64| w / LAW.response_time(&LARGE, w);
        for slip in [0.01, 1.0, 5.56, 10.0, 10.2, 40.0] {
            let step = 1e-5 * slip;
            let slope = (deceleration(slip + step) - deceleration(slip - step)) / (2.0 * step);
            // error of central differences: rounding 1e-16/1e-5, curvature (1e-5)²
            assert!((LAW.relaxation_time(&LARGE, slip) * slope - 1.0).abs() < 1e-9, "slip {slip}");
        }
    }

    #[test]
    fn flow_crosses_the_switch() {
        let exact = 18.0 * LAW.decay(&LARGE, 18.0, 2.0);
        assert!(exact * LARGE.reynolds_per_speed < SWITCH, "the test must cross");
        // One step contains a jump of 0.4 % in the force: its contribution to the error is 0.004 h w/τ.
        let numeric = integrate(18.0, 2.0, 200_000);
        assert!((exact / numeric - 1.0).abs() < 1e-7, "{exact} {numeric}");
    }

    #[test]
    fn small_slip_is_stokes_drag() {
        for slip in [0.0, f64::MIN_POSITIVE, 5e-324, 1e-30] {
            let stokes = (-0.7 / LARGE.stokes_time).exp();
            assert!((LAW.decay(&LARGE, slip, 0.7) / stokes - 1.0).abs() < 1e-15, "slip {slip}");
            assert!((LAW.response_time(&LARGE, slip) / LARGE.stokes_time - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn ratio_stays_between_zero_and_one() {
        for slip in [0.0, 1e-300, 1e-3, 10.0, 11.0, 1e6, 1e300] {
            assert_eq!(LAW.decay(&LARGE, slip, 0.0), 1.0);
            for duration in [1e-300, 1e-9, 1.0, 1e3, 1e6, 1e300] {
                let ratio = LAW.decay(&LARGE, slip, duration);
                assert!((0.0..=1.0).contains(&ratio), "slip {slip}, duration {duration}: {ratio}");
            }
        }
    }

    #[test]
    fn switch_is_where_the_law_says() {
        let slip = SWITCH / LARGE.reynolds_per_speed;
        let below = LAW.response_time(&LARGE, slip * (1.0 - 1e-12));
        let above = LAW.response_time(&LARGE, slip * (1.0 + 1e-12));
        // the force jumps by the factor 0.44 / 0.438288
        assert!((below / above - 0.44 / 0.438_288).abs() < 1e-5, "{}", below / above);
    }
}
