//! Rebound of an oblique impact of stiff spheres under the linear laws: one function of one number.
//!
//! In units of the undamped frequency ω_0, the effective mass M and the normal speed u_n the overlap is δ(t) = exp(-ζt)
//! sin(ω_d t)/ω_d, and the normal force f = δ + 2ζ δ'. The slip is σ = s/(μ u_n), and the shear ξ stands in units of
//! μ u_n/ω_0. The tangential motion is ξ' = σ, (M_t/M) σ' = -F, F = κ ξ + c σ, at most max(f, 0). It knows neither μ
//! nor sizes nor speeds: σ' = Φ(σ_0) (Becker et al. 2008, Phys. Rev. E 77, 011304, propose such a map).

use super::{NormalSpring, TangentialLaw, TangentialSpring};
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Steps of the classical Runge-Kutta method in an impact: an error of some 1e-8.
const STEPS: u32 = 120;

/// Points of a table up to the slip beyond which all impacts slide to their end, and as many beyond: linear
/// interpolation errs by 1e-6, and near the slips at which phases change by 1e-5 at most.
const POINTS: usize = 4096;

/// An oblique impact of two bodies under the linear normal and tangential laws, in units of ω_0, M and u_n.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObliqueImpact {
    /// [-] normal damping ratio ζ, 0 <= ζ < 1.
    pub damping_ratio: f64,
    /// [-] κ = k_t/k_n.
    pub stiffness: f64,
    /// [-] c_t/(M ω_0).
    pub dashpot: f64,
    /// [-] M_t/M.
    pub mass: f64,
}

/// State of an impact: time, slip against the first slip's direction, shear.
#[derive(Clone, Copy, Debug)]
struct State {
    time: f64,
    slip: f64,
    shear: f64,
}

/// Way in which the surfaces move on one another.
#[derive(Clone, Copy, PartialEq, Debug)]
enum SlipPhase {
    Stick,
    /// With the sign of the force.
    Slide(f64),
}

impl ObliqueImpact {
    /// Impact of surfaces with restitution e, 0 < e <= 1, of bodies with that M_t/M [-], under a tangential law that
    /// remembers.
    pub fn of_law(law: &TangentialLaw, restitution: f64, mass: f64) -> Self {
        let ln = restitution.ln();
        let damping_ratio = -ln / (PI * PI + ln * ln).sqrt();
        let smooth = Self { damping_ratio, stiffness: 0.0, dashpot: 0.0, mass };
        let normal = NormalSpring { stiffness: 1.0, dashpot: 2.0 * damping_ratio, contact_time: smooth.duration() };
        let TangentialSpring { stiffness, dashpot, .. } = law.between(|| normal, mass);
        Self { stiffness, dashpot, ..smooth }
    }

    fn damped(&self) -> f64 {
        (1.0 - self.damping_ratio * self.damping_ratio).sqrt()
    }

    /// [1/ω_0] contact time.
    pub fn duration(&self) -> f64 {
        PI / self.damped()
    }

    /// Largest tangential force max(f, 0), and its rate.
    fn limit(&self, time: f64) -> (f64, f64) {
        let (ratio, damped) = (self.damping_ratio, self.damped());
        let (sin, cos) = (damped * time).sin_cos();
        let envelope = (-ratio * time).exp();
        let overlap = envelope * sin / damped;
        let rate = envelope * cos - ratio * overlap;
        // δ'' = -δ - 2ζ δ'
        let force = overlap + 2.0 * ratio * rate;
        if force > 0.0 { (force, rate - 2.0 * ratio * force) } else { (0.0, 0.0) }
    }

    fn step(&self, phase: SlipPhase, from: &State, dt: f64) -> State {
        let force = |time: f64, slip: f64, shear: f64| match phase {
            SlipPhase::Stick => self.stiffness * shear + self.dashpot * slip,
            SlipPhase::Slide(sign) => sign * self.limit(time).0,
        };
        let rate = |time: f64, slip: f64, shear: f64| (-force(time, slip, shear) / self.mass, slip);
        let State { time, slip, shear } = *from;
        let (a1, b1) = rate(time, slip, shear);
        let (a2, b2) = rate(time + 0.5 * dt, slip + 0.5 * dt * a1, shear + 0.5 * dt * b1);
        let (a3, b3) = rate(time + 0.5 * dt, slip + 0.5 * dt * a2, shear + 0.5 * dt * b2);
        let (a4, b4) = rate(time + dt, slip + dt * a3, shear + dt * b3);
        let time = time + dt;
        let slip = slip + dt / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        let shear = match phase {
            SlipPhase::Stick => shear + dt / 6.0 * (b1 + 2.0 * b2 + 2.0 * b3 + b4),
            SlipPhase::Slide(sign) => {
                sign * (self.limit(time).0 - self.dashpot * slip * sign).max(0.0) / self.stiffness
            }
        };
        State { time, slip, shear }
    }

    /// Positive while the phase goes on: the distance to the limit, or the rate of sliding.
    fn goes_on(&self, phase: SlipPhase, state: &State) -> f64 {
        let (limit, rate) = self.limit(state.time);
        match phase {
            SlipPhase::Stick => limit - (self.stiffness * state.shear + self.dashpot * state.slip).abs(),
            // the dashpot alone is at the limit: the spring is not stretched
            SlipPhase::Slide(sign) if limit <= self.dashpot * state.slip * sign => f64::INFINITY,
            SlipPhase::Slide(sign) => {
                // rate of the force if it stuck, over that of the limit
                self.stiffness * state.slip * sign - self.dashpot * limit / self.mass - rate
            }
        }
    }

    /// SlipPhase that a state on the limit is about to take.
    fn next_phase(&self, state: &State) -> SlipPhase {
        let force = self.stiffness * state.shear + self.dashpot * state.slip;
        let sign = if force == 0.0 { 1.0 } else { force.signum() };
        if self.goes_on(SlipPhase::Slide(sign), state) > 0.0 { SlipPhase::Slide(sign) } else { SlipPhase::Stick }
    }

    /// Reduced slip Φ(σ_0) [-] after the impact, from that before it, `slip` σ_0 >= 0 [-].
    pub fn rebound(&self, slip: f64) -> f64 {
        let mut state = State { time: 0.0, slip, shear: 0.0 };
        let on_limit = self.limit(0.0).0 <= self.dashpot * slip;
        let mut phase = if on_limit { self.next_phase(&state) } else { SlipPhase::Stick };
        let (end, dt) = (self.duration(), self.duration() / f64::from(STEPS));
        // f = 0 where ω_d t = 2 arccos ζ: from there on damping pulls, and the limit is 0
        let pulls = 2.0 * self.damping_ratio.acos() / self.damped();
        while state.time < end * (1.0 - 1e-12) {
            let stop = if state.time < pulls * (1.0 - 1e-12) { pulls } else { end };
            let step = dt.min(stop - state.time);
            let next = self.step(phase, &state, step);
            if self.goes_on(phase, &next) >= 0.0 {
                state = next;
                continue;
            }
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                let there = self.step(phase, &state, middle * step);
                if self.goes_on(phase, &there) >= 0.0 { low = middle } else { high = middle }
            }
            // a little beyond, so that time goes on
            state = self.step(phase, &state, high.max(1e-9) * step);
            phase = match phase {
                SlipPhase::Stick => {
                    SlipPhase::Slide((self.stiffness * state.shear + self.dashpot * state.slip).signum())
                }
                SlipPhase::Slide(_) => SlipPhase::Stick,
            };
        }
        state.slip
    }
}

/// Φ of an [`ObliqueImpact`], tabulated when it is first asked for: soft runs never ask.
#[derive(Clone, Debug)]
pub struct ReboundTable {
    /// [-] restitution of the surfaces.
    restitution: f64,
    impact: ObliqueImpact,
    points: OnceLock<ReboundPoints>,
}

/// Points of a table.
#[derive(Clone, Debug)]
struct ReboundPoints {
    /// [-] slip up to which `near` holds.
    most: f64,
    /// Φ at equal distances of σ_0 from 0 to `most`.
    near: Vec<f64>,
    /// σ_0 - Φ at equal distances of 1/σ_0 from 0 to 1/`most`.
    far: Vec<f64>,
}

/// Linear interpolation at a place >= 0 counted in points.
#[inline]
fn interpolate(points: &[f64], place: f64) -> f64 {
    let k = (place as usize).min(points.len() - 2);
    points[k] + (points[k + 1] - points[k]) * (place - k as f64)
}

impl ReboundPoints {
    fn of(impact: &ObliqueImpact) -> Self {
        // an impact that slides throughout takes ∫ max(f, 0) dt/(M_t/M) <= 2 (M/M_t) from the slip
        let most = 4.0 / impact.mass;
        let near = (0..=POINTS).map(|k| impact.rebound(most * k as f64 / POINTS as f64)).collect();
        let taken = |slip: f64| slip - impact.rebound(slip);
        // the limit 1/σ_0 -> 0 by a slip that is huge
        let far = (0..=POINTS).map(|k| taken(most * POINTS as f64 / (k as f64).max(1e-3))).collect();
        Self { most, near, far }
    }
}

impl PartialEq for ReboundTable {
    /// Tables of equal impacts are one table.
    fn eq(&self, other: &Self) -> bool {
        (self.restitution, self.impact) == (other.restitution, other.impact)
    }
}

impl ReboundTable {
    /// Table of Φ for surfaces with that restitution [-].
    pub fn new(restitution: f64, impact: ObliqueImpact) -> Self {
        Self { restitution, impact, points: OnceLock::new() }
    }

    /// Distance [-] of the table from one for surfaces with that restitution and bodies with that M_t/M.
    #[inline]
    pub fn distance(&self, restitution: f64, mass: f64) -> f64 {
        2.0 * (self.restitution - restitution).abs() + (self.impact.mass - mass).abs()
    }

    /// Reduced slip Φ(σ_0) [-] after an impact.
    #[inline]
    pub fn rebound(&self, slip: f64) -> f64 {
        let ReboundPoints { most, near, far } = self.points.get_or_init(|| ReboundPoints::of(&self.impact));
        if slip <= *most {
            interpolate(near, slip / most * POINTS as f64)
        } else {
            slip - interpolate(far, most / slip * POINTS as f64)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MASS: f64 = 2.0 / 7.0;

    /// A sphere at a wall, in units of its speed: W1 to W4 of the reference values, (angle [°], R ω_0/V, v_t'/V).
    fn rebound(impact: ObliqueImpact, restitution: f64, friction: f64, (angle, spin): (f64, f64), table: bool) -> f64 {
        let (sin, cos) = f64::to_radians(angle).sin_cos();
        let (slip, unit) = (sin - spin, friction * cos);
        let after = match table {
            true => ReboundTable::new(restitution, impact).rebound(slip.abs() / unit),
            false => impact.rebound(slip.abs() / unit),
        };
        // M_t (s - s') is what the motion along the wall has lost
        sin - MASS * (slip - slip.signum() * unit * after)
    }

    fn impact(restitution: f64, stiffness: f64, dashpot: f64) -> ObliqueImpact {
        let ln = f64::ln(restitution);
        ObliqueImpact { damping_ratio: -ln / (PI * PI + ln * ln).sqrt(), stiffness, dashpot, mass: MASS }
    }

    /// Reference values computed independently (RA), with the limit μ max(f_n, 0).
    #[test]
    fn rebounds_are_those_of_the_reference() {
        let w1 = (impact(1.0, 0.8604651163, 0.0), 1.0, 0.092);
        let w2 = (impact(0.9, 2.0 / 7.0, 0.0), 0.9, 0.3);
        let w3 = (impact(0.8, 0.3036939499, 0.1489540016), 0.8, 0.25);
        let w4 = (impact(0.9, 2.0 / 7.0, 0.01915339949), 0.9, 0.3);
        for ((impact, e, mu), angle, spin, expected) in [
            (w1, 2.0, 0.0, 0.030541524),
            (w1, 10.0, 0.0, 0.113186073),
            (w1, 20.0, 0.0, 0.202859623),
            (w1, 30.0, 0.0, 0.340651326),
            (w1, 80.0, 0.0, 0.952856488),
            (w2, 2.0, 0.0, 0.014979006),
            (w2, 40.0, 0.0, 0.278501561),
            (w2, 50.0, 0.0, 0.402045013),
            (w2, 80.0, 0.0, 0.885749310),
            (w2, 20.0, -1.0, -0.192471297),
            (w2, 50.0, 1.5, 1.129021987),
            (w3, 5.0, 0.0, 0.050532645),
            (w3, 30.0, 0.0, 0.290908042),
            (w3, 50.0, 0.0, 0.475488481),
            (w3, 80.0, 0.0, 0.906314464),
            (w4, 20.0, 0.0, 0.156154078),
            (w4, 46.0, 0.0, 0.328424642),
            (w4, 60.0, 0.0, 0.580721493),
        ] {
            let found = rebound(impact, e, mu, (angle, spin), false);
            assert!((found - expected).abs() < 2e-8, "e {e}, {angle}°, {spin}: {found} for {expected}");
        }
    }

    #[test]
    fn a_table_holds_the_function() {
        for impact in [impact(1.0, 0.86, 0.0), impact(0.8, 0.3036939499, 0.1489540016), impact(0.6, 0.9, 0.0)] {
            let table = ReboundTable::new(0.5, impact);
            let worst =
                (1..400).map(|k| 0.083 * f64::from(k)).map(|slip| (table.rebound(slip) - impact.rebound(slip)).abs());
            let worst = worst.fold(0.0, f64::max);
            assert!(worst < 1e-5, "{impact:?}: {worst:.1e}");
        }
    }

    /// Section 4 of the reference: without sliding β_0 = -cos(ω_t T_c).
    #[test]
    fn small_slips_rebound_by_the_closed_form_where_nothing_slides() {
        // a limit that falls to zero slides at the end unless the spring is at rest then: κ = 2/7 at e = 1
        let still = impact(1.0, 2.0 / 7.0, 0.0);
        assert!((still.rebound(1.0) + 1.0).abs() < 1e-9);
        let smooth = impact(1.0, 1e-12, 0.0);
        assert!((smooth.rebound(1.0) - 1.0).abs() < 1e-9);
    }
}
