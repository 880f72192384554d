//! Rebound of an oblique impact of stiff spheres, as a function Φ of one number, the reduced slip.
//!
//! The units are the effective mass M, the normal speed u_n and the normal stiffness. In these units, the overlap δ(t)
//! and the normal force f are fixed functions for a given restitution. The reduced slip is σ = s/(μ u_n), with the slip
//! s (tangential velocity of the surfaces) and the friction μ. The shear ξ of the tangential spring has the unit of
//! length times μ. The tangential motion is ξ' = σ, (M_t/M) σ' = -F, F = k ξ + c σ with |F| at most max(f, 0). Here M_t
//! is the effective mass of the slip, F the tangential force over μ, k the tangential stiffness, and c the tangential
//! dashpot constant. These equations contain no μ, size or speed, so σ after the impact is a function Φ(σ_0) (Becker et
//! al. 2008, Phys. Rev. E 77, 011304, propose such a map).
//!
//! The linear law has δ = exp(-ζt) sin(ω_d t)/ω_d and ω_d = sqrt(1 - ζ²), with time in units of 1/ω_0. For Hertz's law,
//! w = δ^(5/4) follows this formula in a transformed time, in which w oscillates like a linear spring (Antypov and
//! Elliott 2011, EPL 94, 50004).

use super::{NormalSpring, SpringDashpotSlider, TangentialLaw};
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Number of steps of the classical Runge-Kutta method in one impact. The error of the slip is about 1e-8 (linear law)
/// and 1e-6 (Hertz's law).
const STEPS: u32 = 120;

/// Number of intervals in each of the two parts of a table of the function Φ (slip after an impact as a function of the
/// slip before). One part ends at a slip beyond which all impacts slide to their end; the other part covers larger
/// slips. The error of linear interpolation is 1e-6, and at most 1e-5 near the slips at which the sequence of sticking
/// and sliding changes.
const POINTS: usize = 4096;

/// Oblique impact of two bodies with a normal and a tangential law. The units are the effective mass M, the normal
/// speed u_n and the normal stiffness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObliqueImpact {
    /// [-] normal damping ratio ζ of the linear oscillator, 0 <= ζ < 1.
    pub damping_ratio: f64,
    /// [-] tangential stiffness k_t and dashpot c_t in units of M, u_n and the normal stiffness. For Mindlin's law the
    /// two constants are k_t/sqrt(δ) and c_t/δ^(1/4).
    pub tangential: SpringDashpotSlider,
    /// [-] effective mass M_t of the slip, divided by the effective mass M.
    pub mass: f64,
}

/// Quantities of an impact at one instant, from which the rates of slip and shear are computed. The units are those of
/// [`ObliqueImpact`].
#[derive(Clone, Copy, Debug)]
struct ImpactInstant {
    /// Largest tangential force over μ: max(f, 0), with the normal force f. `limit_rate` is its time derivative.
    limit: f64,
    limit_rate: f64,
    spring: SpringDashpotSlider,
    /// Relative rate δ'/δ of the overlap δ, which changes the spring; 0 for a linear law, whose spring is constant.
    rate: f64,
    /// Derivative of the time with respect to the integration variable; 1 for a linear law, which is integrated over
    /// time.
    pace: f64,
}

/// State of the tangential motion: the value `at` of the integration variable (time for linear laws), the slip
/// (positive in its initial direction), and the shear of the tangential spring.
#[derive(Clone, Copy, Debug)]
struct State {
    at: f64,
    slip: f64,
    shear: f64,
}

/// Phase of the tangential motion: the surfaces stick together or slide.
#[derive(Clone, Copy, PartialEq, Debug)]
enum SlipPhase {
    Stick,
    /// The surfaces slide. The number, 1 or -1, is the sign of the tangential force.
    Slide(f64),
}

impl ObliqueImpact {
    /// Impact with linear laws, from the normal damping ratio ζ, the stiffness ratio κ = k_t/k_n, the tangential
    /// dashpot constant c_t divided by M ω_0, and the mass ratio M_t/M [-]. Here M is the effective mass, M_t that of
    /// the slip, and ω_0 the undamped normal frequency.
    pub fn linear(damping_ratio: f64, stiffness: f64, dashpot: f64, mass: f64) -> Self {
        let tangential = SpringDashpotSlider { stiffness, dashpot, ..SpringDashpotSlider::without_memory(mass) };
        Self { damping_ratio, tangential, mass }
    }

    /// Impact with restitution e, 0 < e <= 1, and mass ratio `mass` M_t/M [-], for a tangential law with memory.
    /// `shear` [-] is Mindlin's tangential stiffness over Hertz's elastic constant; linear laws ignore it.
    pub fn of_law(law: &TangentialLaw, restitution: f64, mass: f64, shear: f64) -> Self {
        let ln = restitution.ln();
        let damping_ratio = -ln / (PI * PI + ln * ln).sqrt();
        let smooth = Self::linear(damping_ratio, 0.0, 0.0, mass);
        let mut normal = NormalSpring::linear(1.0, 2.0 * damping_ratio, smooth.duration());
        if let TangentialLaw::Mindlin { .. } = law {
            normal = NormalSpring { dashpot: hertz_dashpot(damping_ratio), shear_stiffness: shear, ..normal };
        }
        Self { tangential: law.between(|| normal, mass), ..smooth }
    }

    fn is_hertzian(&self) -> bool {
        self.tangential.half_powers > 0
    }

    fn damped(&self) -> f64 {
        (1.0 - self.damping_ratio * self.damping_ratio).sqrt()
    }

    /// [1/ω_0] contact time of the linear oscillator with the undamped angular frequency ω_0: π/sqrt(1 - ζ²).
    pub fn duration(&self) -> f64 {
        PI / self.damped()
    }

    /// Three values of the integration variable that no step may cross, because the equations change there. The first
    /// value, for Hertz's law, is at the largest overlap (phase arccos ζ). From there on, Mindlin's law may lower the
    /// tangential force together with the stiffness ([`SpringHistory::Rescaled`]). For linear laws the first value
    /// equals the second. The second value is at the phase 2 arccos ζ. From there on, damping makes the normal force
    /// attractive, so the limit of friction is 0. The third value is the end of the contact.
    fn stops(&self) -> [f64; 3] {
        let phase = self.damping_ratio.acos();
        if self.is_hertzian() {
            [self.share_of(phase), self.share_of(2.0 * phase), 1.0]
        } else {
            let pulls = 2.0 * phase / self.damped();
            [pulls, pulls, self.duration()]
        }
    }

    /// Integration variable, from 0 to 1, at which the normal oscillation of an impact with Hertz's law has the phase
    /// `phase` [rad].
    fn share_of(&self, phase: f64) -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if PI * crowded(middle).0 < phase { low = middle } else { high = middle }
        }
        high
    }

    fn instant(&self, at: f64) -> ImpactInstant {
        if self.is_hertzian() { self.hertzian(at) } else { self.linear_instant(at) }
    }

    fn linear_instant(&self, time: f64) -> ImpactInstant {
        let (ratio, damped) = (self.damping_ratio, self.damped());
        let (sin, cos) = (damped * time).sin_cos();
        let envelope = (-ratio * time).exp();
        let overlap = envelope * sin / damped;
        let rate = envelope * cos - ratio * overlap;
        // equation of motion: δ'' = -δ - 2ζ δ'
        let force = overlap + 2.0 * ratio * rate;
        let (limit, limit_rate) = if force > 0.0 { (force, rate - 2.0 * ratio * force) } else { (0.0, 0.0) };
        ImpactInstant { limit, limit_rate, spring: self.tangential, rate: 0.0, pace: 1.0 }
    }

    /// Quantities of an impact with Hertz's law at one instant, in units of the effective mass M, the normal speed u_n
    /// and Hertz's constant k_H. `share` is the integration variable, from 0 to 1. Equal steps of this variable are
    /// short in time at both ends of the contact.
    fn hertzian(&self, share: f64) -> ImpactInstant {
        let (ratio, frequency) = (self.damping_ratio, 0.8f64.sqrt()); // ω_0² = 4 k_H/(5 M), Antypov and Elliott
        let damped = frequency * self.damped();
        let (phase, slope) = crowded(share);
        let (sin, cos) = (PI * phase).sin_cos();
        let envelope = (-ratio * frequency * PI * phase / damped).exp();
        let w = (envelope * sin / damped).max(0.0);
        let rate = envelope * cos - ratio * frequency * w;
        if w <= 0.0 {
            let spring = self.tangential.at(0.0);
            return ImpactInstant { limit: 0.0, limit_rate: 0.0, spring, rate: 0.0, pace: 0.0 };
        }
        let overlap = w.powf(0.8);
        let (root, dashpot) = (overlap.sqrt(), hertz_dashpot(ratio));
        let force = overlap * root + dashpot * root.sqrt() * rate;
        // equation of motion: δ'' = -f
        let viscous = dashpot * root.sqrt() * (0.25 * rate * rate / overlap - force);
        let pulls = force <= 0.0;
        let (limit, limit_rate) = if pulls { (0.0, 0.0) } else { (force, 1.5 * root * rate + viscous) };
        let pace = 0.8 * w.powf(-0.2) * PI * slope / damped;
        ImpactInstant { limit, limit_rate, spring: self.tangential.at(overlap), rate: rate / overlap, pace }
    }

    fn step(&self, phase: SlipPhase, from: &State, dx: f64) -> State {
        let rate = |at: f64, slip: f64, shear: f64| {
            let ImpactInstant { limit, spring, rate, pace, .. } = self.instant(at);
            let force = match phase {
                SlipPhase::Stick => spring.stiffness * shear + spring.dashpot * slip,
                SlipPhase::Slide(sign) => sign * limit,
            };
            (-force / self.mass * pace, (slip - self.tangential.rates(rate).forgotten * shear) * pace)
        };
        let State { at, slip, shear } = *from;
        let (a1, b1) = rate(at, slip, shear);
        let (a2, b2) = rate(at + 0.5 * dx, slip + 0.5 * dx * a1, shear + 0.5 * dx * b1);
        let (a3, b3) = rate(at + 0.5 * dx, slip + 0.5 * dx * a2, shear + 0.5 * dx * b2);
        let (a4, b4) = rate(at + dx, slip + dx * a3, shear + dx * b3);
        let at = at + dx;
        let slip = slip + dx / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        let shear = match phase {
            SlipPhase::Stick => shear + dx / 6.0 * (b1 + 2.0 * b2 + 2.0 * b3 + b4),
            SlipPhase::Slide(sign) => {
                let ImpactInstant { limit, spring, .. } = self.instant(at);
                sign * spring.sliding_length(limit, slip * sign)
            }
        };
        State { at, slip, shear }
    }

    /// Number that is positive as long as the phase `phase` (sticking or sliding) lasts, and 0 when the next phase
    /// begins. For sticking it is the limit of the tangential force minus this force. For sliding it is the rate at
    /// which the force of a sticking contact would grow beyond the limit.
    fn goes_on(&self, phase: SlipPhase, state: &State) -> f64 {
        let ImpactInstant { limit, limit_rate, spring, rate, .. } = self.instant(state.at);
        match phase {
            SlipPhase::Stick => limit - (spring.stiffness * state.shear + spring.dashpot * state.slip).abs(),
            // the dashpot alone reaches the limit, so the spring is not stretched
            SlipPhase::Slide(sign) if limit <= spring.dashpot * state.slip * sign => f64::INFINITY,
            SlipPhase::Slide(sign) => {
                // rate of the force of a sticking contact, minus the rate of the limit
                let changes = self.tangential.rates(rate);
                let of_spring = spring.stiffness * (state.slip + changes.force * state.shear);
                let of_dashpot = spring.dashpot * (changes.dashpot * state.slip - sign * limit / self.mass);
                (of_spring + of_dashpot) * sign - limit_rate
            }
        }
    }

    /// Phase that follows a state whose tangential force is at the limit: sliding, if the force of a sticking contact
    /// would exceed the limit.
    fn next_phase(&self, state: &State) -> SlipPhase {
        let spring = self.instant(state.at).spring;
        let force = spring.stiffness * state.shear + spring.dashpot * state.slip;
        let sign = if force == 0.0 { 1.0 } else { force.signum() };
        if self.goes_on(SlipPhase::Slide(sign), state) > 0.0 { SlipPhase::Slide(sign) } else { SlipPhase::Stick }
    }

    /// First phase of an impact, whose initial slip is that of `state`.
    fn first_phase(&self, state: &State) -> SlipPhase {
        if !self.is_hertzian() {
            let on_limit = self.instant(0.0).limit <= self.tangential.dashpot * state.slip;
            return if on_limit { self.next_phase(state) } else { SlipPhase::Stick };
        }
        // at a small overlap δ = t, dashpot forces grow with t^(1/4) and spring forces with t^(3/2)
        let dashpots = self.tangential.dashpot * state.slip - hertz_dashpot(self.damping_ratio);
        let springs = self.tangential.stiffness * self.tangential.growth(0.0, 1.0).1 * state.slip - 1.0;
        let beyond = if dashpots == 0.0 { springs } else { dashpots };
        if beyond > 0.0 { SlipPhase::Slide(1.0) } else { SlipPhase::Stick }
    }

    /// [-] reduced slip Φ(σ_0) after the impact. `slip` is the reduced slip σ_0 >= 0 [-] before the impact.
    pub fn rebound(&self, slip: f64) -> f64 {
        let mut state = State { at: 0.0, slip, shear: 0.0 };
        let mut phase = self.first_phase(&state);
        let stops = self.stops();
        let dx = stops[2] / f64::from(STEPS);
        while let Some(stop) = stops.iter().find(|stop| state.at < *stop * (1.0 - 1e-12)) {
            let step = dx.min(stop - state.at);
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
            // the step ends a little after the change of phase, so that time always advances
            state = self.step(phase, &state, high.max(1e-9) * step);
            phase = match phase {
                SlipPhase::Stick => {
                    let spring = self.instant(state.at).spring;
                    SlipPhase::Slide((spring.stiffness * state.shear + spring.dashpot * state.slip).signum())
                }
                SlipPhase::Slide(_) => SlipPhase::Stick,
            };
        }
        state.slip
    }
}

/// [-] dashpot constant of Hertz's law at a damping ratio ζ, in units of the effective mass M and Hertz's constant k_H
/// (Antypov and Elliott 2011).
fn hertz_dashpot(damping_ratio: f64) -> f64 {
    5.0f64.sqrt() * damping_ratio
}

/// Value and slope of the polynomial "smootherstep" at `share`, from 0 to 1. It rises from 0 to 1, and its slope is 0
/// at both ends.
fn crowded(share: f64) -> (f64, f64) {
    let at = share * share * share * (10.0 - 15.0 * share + 6.0 * share * share);
    (at, 30.0 * (share * (1.0 - share)).powi(2))
}

/// Table of the function Φ of an [`ObliqueImpact`]: reduced slip after an impact as a function of the reduced slip
/// before. The table is computed at the first use, because soft runs do not need it.
#[derive(Clone, Debug)]
pub struct ReboundTable {
    /// [-] normal restitution of the surfaces to which the table belongs.
    restitution: f64,
    impact: ObliqueImpact,
    points: OnceLock<ReboundPoints>,
}

/// Points of a table of Φ(σ_0), the reduced slip after an impact as a function of the reduced slip before.
#[derive(Clone, Debug)]
struct ReboundPoints {
    /// [-] largest reduced slip σ_0 covered by `near`. Larger slips are covered by `far`.
    most: f64,
    /// [-] Φ(σ_0) at equal intervals of σ_0 from 0 to `most`.
    near: Vec<f64>,
    /// [-] σ_0 - Φ(σ_0) at equal intervals of 1/σ_0 from 0 to 1/`most`.
    far: Vec<f64>,
}

/// Linear interpolation between points at equal distances. `place` >= 0 is the position in units of this distance,
/// counted from the first point.
#[inline]
fn interpolate(points: &[f64], place: f64) -> f64 {
    let k = (place as usize).min(points.len() - 2);
    points[k] + (points[k + 1] - points[k]) * (place - k as f64)
}

impl ReboundPoints {
    fn of(impact: &ObliqueImpact) -> Self {
        // an impact that slides to its end reduces the slip by ∫ max(f, 0) dt/(M_t/M) <= 2 (M/M_t)
        let most = 4.0 / impact.mass;
        let near = (0..=POINTS).map(|k| impact.rebound(most * k as f64 / POINTS as f64)).collect();
        let taken = |slip: f64| slip - impact.rebound(slip);
        // a huge slip stands for the limit 1/σ_0 -> 0
        let far = (0..=POINTS).map(|k| taken(most * POINTS as f64 / (k as f64).max(1e-3))).collect();
        Self { most, near, far }
    }
}

impl PartialEq for ReboundTable {
    /// True if the restitutions and the impacts of two tables are equal, because they determine all values of a table.
    fn eq(&self, other: &Self) -> bool {
        (self.restitution, self.impact) == (other.restitution, other.impact)
    }
}

impl ReboundTable {
    /// Makes a table of Φ for an impact of surfaces with the given restitution [-].
    pub fn new(restitution: f64, impact: ObliqueImpact) -> Self {
        Self { restitution, impact, points: OnceLock::new() }
    }

    /// [-] measure of the difference between the restitution and mass ratio M_t/M of this table and the wanted ones. Of
    /// several tables, the one with the smallest measure is used.
    #[inline]
    pub fn distance(&self, restitution: f64, mass: f64) -> f64 {
        2.0 * (self.restitution - restitution).abs() + (self.impact.mass - mass).abs()
    }

    /// [-] reduced slip Φ(σ_0) after an impact. `slip` is the reduced slip σ_0 >= 0 [-] before the impact.
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

    /// Tangential velocity v_t'/V after the impact of a sphere of speed V at a wall. The pair is the angle [°] between
    /// velocity and normal, and the spin R ω_0/V, both before the impact. If `table` is true, the rebound is taken from
    /// a [`ReboundTable`], otherwise it is computed directly.
    fn rebound(impact: ObliqueImpact, restitution: f64, friction: f64, (angle, spin): (f64, f64), table: bool) -> f64 {
        let (sin, cos) = f64::to_radians(angle).sin_cos();
        let (slip, unit) = (sin - spin, friction * cos);
        let after = match table {
            true => ReboundTable::new(restitution, impact).rebound(slip.abs() / unit),
            false => impact.rebound(slip.abs() / unit),
        };
        // M_t (s - s') is the momentum that the motion along the wall loses
        sin - MASS * (slip - slip.signum() * unit * after)
    }

    fn impact(restitution: f64, stiffness: f64, dashpot: f64) -> ObliqueImpact {
        let ln = f64::ln(restitution);
        ObliqueImpact::linear(-ln / (PI * PI + ln * ln).sqrt(), stiffness, dashpot, MASS)
    }

    /// Compares rebounds with independently computed reference values. The tangential force is at most μ max(f_n, 0).
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

    /// Compares small slips with the closed form: an impact without sliding has the tangential restitution β_0 =
    /// -cos(ω_t T_c). Here ω_t is the angular frequency of the tangential spring, and T_c the contact time.
    #[test]
    fn small_slips_rebound_by_the_closed_form_where_nothing_slides() {
        // as the limit falls to zero, the contact slides at the end unless the spring is unstretched then: κ = 2/7 at e
        // = 1
        let still = impact(1.0, 2.0 / 7.0, 0.0);
        assert!((still.rebound(1.0) + 1.0).abs() < 1e-9);
        let smooth = impact(1.0, 1e-12, 0.0);
        assert!((smooth.rebound(1.0) - 1.0).abs() < 1e-9);
    }

    /// Compares the reduced slip s'/(μ u_n) after an impact with independently computed reference values for the three
    /// histories of the spring. The restitution is 1 and Poisson's ratio 0.3 (test 5 of Chung and Ooi 2011).
    #[test]
    fn rebounds_of_hertz_and_mindlin_are_those_of_the_reference() {
        // steel on a rigid plane, ν 0.3: k_t/k_H = 6 G*/E*
        let shear = 6.0 * (1.0 - 0.3 * 0.3) / (2.0 * (2.0 - 0.3) * (1.0 + 0.3));
        use super::super::SpringHistory::{Displacement, Force, Rescaled};
        for (slip, expected) in [
            (1.0 / 15.0, [0.063652, 0.060511, 0.034561]),
            (0.4, [0.381062, 0.307550, 0.202643]),
            (1.0, [0.666837, 0.503488, 0.414983]),
            (2.0, [-0.276258, -0.175621, -0.190808]),
            (3.0, [-1.001273, -1.042982, -0.988650]),
            (5.0, [-1.435637, -1.635750, -1.435637]),
            (6.0, [-0.981406, -1.0, -0.981406]),
            (8.0, [1.0, 1.0, 1.0]),
        ] {
            for (history, expected) in [Displacement, Force, Rescaled].into_iter().zip(expected) {
                let impact = ObliqueImpact::of_law(&TangentialLaw::Mindlin { history, dashpot: 0.0 }, 1.0, MASS, shear);
                let found = impact.rebound(slip);
                assert!((found - expected).abs() < 2e-5 * slip.max(1.0), "{history:?}, {slip}: {found} for {expected}");
            }
        }
    }
}
