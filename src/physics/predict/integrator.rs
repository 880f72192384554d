//! Accuracy with which time steps of the soft engine resolve a contact.
//!
//! A time step maps the gap x of a contact (negative for an overlap) and its time derivative v to their values after
//! Δt. In the units of a contact law (mass and elastic constant 1, see [`unit_spring`]) this map depends only on the
//! restitution and the number of steps per contact N_c. Therefore the results of this file do not depend on the size of
//! the particles. They depend on the speed of impact only through N_c. The motion is along the normal only. In an
//! oblique impact the normal also turns during the contact, by about the overlap over the diameter.

use crate::contact_law::{ContactLaw, Spring, damping_ratio};
use crate::experiment::{Integrator, SoftStepping};
use std::f64::consts::PI;

/// Number of impacts over which results are averaged. The impacts differ in phase, which is the time between the first
/// touch and the time step before it.
const PHASES: usize = 200;

/// [-] time since the first touch, over the contact time, after which a contact counts as endless.
const ENDLESS: f64 = 20.0;

/// Method that advances a contact by one time step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Velocity Verlet with the dashpot at the half-step velocity.
    VelocityVerlet,
    /// Heun's second-order Runge-Kutta method. Both of its stages test for an overlap.
    Heun,
    /// The classical Runge-Kutta method of fourth order.
    FourthOrder,
}

/// Method of the time step, and accuracy with which the beginning and the end of a contact are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scheme {
    /// Numerical method of one time step.
    pub method: Method,
    /// True if contacts begin and end at their exact instants, as in local stepping (time steps only for particles in
    /// contact). False if they begin and end at the next time step, as in uniform stepping (time steps for all
    /// particles).
    pub exact_instants: bool,
}

impl Scheme {
    /// Returns the scheme that the soft engine uses with these settings. The setting `Auto` is treated as local
    /// stepping (time steps only for particles in contact), because `Auto` chooses local stepping unless the scene is
    /// crowded.
    pub fn of(integrator: Integrator, stepping: SoftStepping) -> Self {
        let exact_instants = stepping != SoftStepping::Uniform;
        let method = match (integrator, exact_instants) {
            (Integrator::Rk2, _) => Method::Heun,
            (Integrator::VelocityVerlet, false) => Method::VelocityVerlet,
            (Integrator::VelocityVerlet, true) => Method::FourthOrder,
        };
        Self { method, exact_instants }
    }
}

/// Restitution that results from time steps, if the restitution of the contact law is e. All values are ratios of
/// speeds [-].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Realised {
    /// [-] mean of the restitution over all phases (times from a step to the first touch after it).
    pub mean: f64,
    /// [-] smallest restitution over all phases (times from a step to the first touch after it).
    pub least: f64,
    /// [-] largest restitution over all phases (times from a step to the first touch after it).
    pub largest: f64,
    /// [-] mean square of the restitution over all phases (times from a step to the first touch after it). This mean
    /// determines the energy that a gas loses in collisions.
    pub mean_square: f64,
}

/// [-] reduced time step ω_0 Δt = π/(N_c sqrt(1 - ζ²)), with the damping ratio ζ (Eqs. 7 and 9 of the paper, see
/// `docs/paper.md`). Δt is 1/N_c of the contact time of a linear spring and dashpot with this restitution.
pub fn reduced_step(restitution: f64, steps_per_contact: f64) -> f64 {
    let ratio = damping_ratio(restitution);
    PI / (steps_per_contact * (1.0 - ratio * ratio).sqrt())
}

/// State of one contact, in units that fit the constants of its spring: x is the gap (negative for an overlap), and v
/// the time derivative of the gap.
#[derive(Clone, Copy, Debug, PartialEq)]
struct GapState {
    x: f64,
    v: f64,
}

/// Contact force that changes the gap between two bodies.
struct GapForce<'a> {
    law: &'a ContactLaw,
    spring: Spring,
    /// If true, the force is zero while the gap is positive. If false, the law also acts at a positive gap. Forces at
    /// a positive gap are needed to compute the stability of a free oscillation, and for contacts whose end is found
    /// within a step.
    one_sided: bool,
}

impl GapForce<'_> {
    fn acceleration(&self, x: f64, v: f64) -> f64 {
        if self.one_sided && x >= 0.0 {
            return 0.0;
        }
        let (elastic, viscous) = self.law.force(&self.spring, -x, v);
        (elastic + viscous) / self.spring.effective_mass
    }

    /// Gap and its time derivative after a time step of length `dt`. `from` is the state before the step.
    fn step(&self, method: Method, from: GapState, dt: f64) -> GapState {
        let GapState { x, v } = from;
        match method {
            // velocities belong to half steps, and two half-kicks make one kick
            Method::VelocityVerlet => {
                let x = x + v * dt;
                GapState { x, v: v + self.acceleration(x, v) * dt }
            }
            Method::Heun => {
                let first = self.acceleration(x, v);
                let (ahead, faster) = (x + v * dt, v + first * dt);
                let second = self.acceleration(ahead, faster);
                GapState { x: x + 0.5 * (v + faster) * dt, v: v + 0.5 * (first + second) * dt }
            }
            Method::FourthOrder => {
                let rate = |x: f64, v: f64| (v, self.acceleration(x, v));
                let (x1, v1) = rate(x, v);
                let (x2, v2) = rate(x + 0.5 * dt * x1, v + 0.5 * dt * v1);
                let (x3, v3) = rate(x + 0.5 * dt * x2, v + 0.5 * dt * v2);
                let (x4, v4) = rate(x + dt * x3, v + dt * v3);
                // Kutta's weights 1/6, 1/3, 1/3, 1/6
                GapState {
                    x: x + dt / 6.0 * (x1 + 2.0 * x2 + 2.0 * x3 + x4),
                    v: v + dt / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4),
                }
            }
        }
    }
}

/// [-] spectral radius of the map of one time step, for a linear oscillator with the damping ratio ζ = `damping`.
/// `step` is the time step Δt times the undamped angular frequency ω_0 [-]. If the radius exceeds 1, the amplitude of
/// oscillations grows.
pub fn growth(method: Method, damping: f64, step: f64) -> f64 {
    let law = ContactLaw::linear(1.0);
    let spring = Spring { effective_mass: 1.0, restitution: 0.0, stiffness: 1.0, dashpot: 2.0 * damping };
    let spring = GapForce { law: &law, spring, one_sided: false };
    // columns of the 2 x 2 matrix of the map
    let a = spring.step(method, GapState { x: 1.0, v: 0.0 }, step);
    let b = spring.step(method, GapState { x: 0.0, v: 1.0 }, step);
    let half_trace = 0.5 * (a.x + b.v);
    let determinant = a.x * b.v - b.x * a.v;
    let discriminant = half_trace * half_trace - determinant;
    if discriminant < 0.0 { determinant.sqrt() } else { half_trace.abs() + discriminant.sqrt() }
}

/// [-] stability limit: largest ω_0 Δt for which no oscillation with the damping ratio ζ = `damping` grows. It is 0 if
/// there is no such step above 0.01.
///
/// For velocity Verlet it is 2 (sqrt(1+ζ²) - ζ). For Heun's method it is the root θ = ω_0 Δt of θ³/4 - ζ θ² + 2 ζ² θ -
/// 2 ζ. Without damping Heun's method has no stable step, because each step increases the amplitude by the fraction
/// θ⁴/8.
pub fn stability_limit(method: Method, damping: f64) -> f64 {
    /// [-] bound on the rounding error of the spectral radius. It is far below the gain of Heun's method at the
    /// smallest step (1.25e-9).
    const ROUNDING: f64 = 1e-12;
    const SMALLEST: f64 = 0.01;
    let grows = |step: f64| growth(method, damping, step) > 1.0 + ROUNDING;
    if damping.is_nan() || grows(SMALLEST) {
        return 0.0;
    }
    let (mut low, mut high) = (SMALLEST, 2.0 * SMALLEST);
    while !grows(high) {
        (low, high) = (high, high + SMALLEST);
    }
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if grows(middle) { high = middle } else { low = middle }
    }
    low
}

/// Restitution that time steps give in one isolated impact of two bodies under the law, at a normal speed [m/s], with
/// `steps` steps per contact N_c. `None` if the contact does not end, because the step is unstable or the restitution
/// is 0.
///
/// In uniform steps the first touch may occur at any time within a step, so 200 equally spaced phases are computed.
/// With exact instants all phases give the same result.
pub fn realised_restitution(
    scheme: Scheme,
    law: &ContactLaw,
    (spring, speed): (&Spring, f64),
    steps: f64,
) -> Option<Realised> {
    let contact = law.contact_time(spring, speed);
    let step = contact / steps;
    if !contact.is_finite() || step.is_nan() || step <= 0.0 {
        return None;
    }
    let force = GapForce { law, spring: *spring, one_sided: !scheme.exact_instants };
    let longest = (ENDLESS * (contact / step + 1.0)).ceil() as u64;
    if scheme.exact_instants {
        let e = with_exact_instants(&force, speed, scheme.method, step, longest)?;
        return Some(Realised { mean: e, least: e, largest: e, mean_square: e * e });
    }
    let mut realised = Realised { mean: 0.0, least: f64::INFINITY, largest: 0.0, mean_square: 0.0 };
    for phase in 0..PHASES {
        let before = (phase as f64 + 0.5) / PHASES as f64;
        let e = on_the_grid(&force, speed, scheme.method, (step, before), longest)?;
        realised.mean += e / PHASES as f64;
        realised.mean_square += e * e / PHASES as f64;
        realised.least = realised.least.min(e);
        realised.largest = realised.largest.max(e);
    }
    Some(realised)
}

/// [-] rebound speed over approach speed in uniform steps of `step` [s]. The spheres approach at `speed` [m/s]. At the
/// last step before the touch, their gap is the fraction `before` of the distance that they cover in a step. `None` if
/// the contact lasts longer than `longest` steps.
fn on_the_grid(force: &GapForce, speed: f64, method: Method, (step, before): (f64, f64), longest: u64) -> Option<f64> {
    let mut state = GapState { x: before * (speed * step), v: -speed };
    for _ in 0..longest {
        state = force.step(method, state, step);
        if state.x >= 0.0 && state.v > 0.0 {
            return Some(state.v / speed);
        }
    }
    None
}

/// [-] rebound speed over approach speed, if contacts begin and end at exact instants. The contact begins at the first
/// touch, at `speed` [m/s], and ends when the overlap is zero again. `None` if the contact lasts longer than `longest`
/// steps of `step` [s].
fn with_exact_instants(force: &GapForce, speed: f64, method: Method, step: f64, longest: u64) -> Option<f64> {
    let mut state = GapState { x: 0.0, v: -speed };
    for _ in 0..longest {
        let next = force.step(method, state, step);
        if next.x > 0.0 && next.v > 0.0 {
            // the last step ends where the gap is zero
            let (mut low, mut high) = (0.0, step);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if force.step(method, state, middle).x > 0.0 { high = middle } else { low = middle }
            }
            return Some(force.step(method, state, high).v / speed);
        }
        state = next;
    }
    None
}

/// [-] relative change of the granular temperature of a homogeneous gas per collision of a particle: (<e²> - 1)/3, with
/// the mean square <e²> of the restitution that results from time steps. If the change is positive, the time steps heat
/// the gas.
///
/// A collision removes the energy (1 - e²)/4 m u_n², and the mean of u_n² over collisions is 4T (Maxwellian). The loss
/// is divided between two particles of mean energy 3mT/2. The law is linear, so e does not depend on the speed. In
/// oblique impacts the normal velocity counts.
pub fn heating_per_collision(realised: &Realised) -> f64 {
    (realised.mean_square - 1.0) / 3.0
}

/// Linear spring and dashpot with a given restitution [-], in units in which mass and stiffness are 1. In these units
/// all linear impacts with the same restitution are identical.
pub fn unit_spring(restitution: f64) -> Spring {
    let dashpot = 2.0 * damping_ratio(restitution);
    Spring { effective_mass: 1.0, restitution, stiffness: 1.0, dashpot }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINEAR: ContactLaw = ContactLaw::linear(1.0);
    const ON_GRID_VERLET: Scheme = Scheme { method: Method::VelocityVerlet, exact_instants: false };
    const ON_GRID_HEUN: Scheme = Scheme { method: Method::Heun, exact_instants: false };
    const LOCAL: Scheme = Scheme { method: Method::FourthOrder, exact_instants: true };

    fn of(scheme: Scheme, e: f64, steps: f64) -> Realised {
        realised_restitution(scheme, &LINEAR, (&unit_spring(e), 1.0), steps).expect("the contact ends")
    }

    /// Compares the stability limits with amplification factors of the methods for the eigenvalues λ = -ζ ± i
    /// sqrt(1-ζ²) of a damped oscillator, computed independently to three digits.
    #[test]
    fn stability_limits() {
        for (method, e, limit) in [
            (Method::Heun, 1.0, 0.0),
            (Method::Heun, 0.94, 0.566),
            (Method::Heun, 0.5, 1.437),
            (Method::Heun, 0.1, 2.104),
            (Method::VelocityVerlet, 1.0, 2.0),
            (Method::VelocityVerlet, 0.94, 1.961),
            (Method::VelocityVerlet, 0.5, 1.615),
            (Method::VelocityVerlet, 0.1, 1.141),
            (Method::FourthOrder, 1.0, 2.828),
            (Method::FourthOrder, 0.94, 2.866),
            (Method::FourthOrder, 0.5, 2.929),
            (Method::FourthOrder, 0.1, 2.625),
        ] {
            let found = stability_limit(method, damping_ratio(e));
            assert!((found - limit).abs() < 6e-4, "{method:?} e = {e}: {found} against {limit}");
        }
    }

    #[test]
    fn verlets_limit_is_its_closed_form() {
        for e in [1.0, 0.8, 0.3, 0.05] {
            let z = damping_ratio(e);
            let closed = 2.0 * ((1.0 + z * z).sqrt() - z);
            // without damping, the tolerance of the spectral radius shifts the limit by its square root
            assert!((stability_limit(Method::VelocityVerlet, z) - closed).abs() < 2e-6, "{e}");
        }
    }

    /// Checks the growth by Heun's method. The amplitude of an undamped spring grows by the factor (1 + θ⁴/4)^½ per
    /// step, with θ = ω_0 Δt. After half a period the growth is this factor to the power π/θ.
    #[test]
    fn growth_of_heun_without_damping() {
        let step = PI / 7.7;
        assert!((growth(Method::Heun, 0.0, step).powf(7.7) - 1.02694).abs() < 1e-5);
    }

    /// Compares restitutions with a table that was computed independently: its rows "Heun" and "Verlet (half)", for
    /// steps of T_c/5 to T_c/50. Each row has the mean, the least and the largest value over 200 phases. The tolerance
    /// is 0.002 for N_c >= 10. It is 0.01 for smaller N_c, because the phases differ, and for extremes that are known
    /// to few digits.
    #[test]
    fn realised_restitution_on_the_grid() {
        for (scheme, e, steps, mean, least, largest) in [
            (ON_GRID_HEUN, 1.0, 5.0, 1.0776, 1.0470, 1.1129),
            (ON_GRID_HEUN, 1.0, 10.0, 1.01089, 1.0052, 1.0168),
            (ON_GRID_HEUN, 1.0, 15.0, 1.00335, 1.0015, 1.0053),
            (ON_GRID_HEUN, 1.0, 50.0, 1.00010, 1.0000, 1.0002),
            (ON_GRID_HEUN, 0.94, 5.0, 1.0078, 0.9718, 1.0643),
            (ON_GRID_HEUN, 0.94, 10.0, 0.94857, 0.9414, 0.9646),
            (ON_GRID_HEUN, 0.94, 15.0, 0.94237, 0.9397, 0.9513),
            (ON_GRID_HEUN, 0.5, 10.0, 0.4962, 0.479, 0.560),
            (ON_GRID_HEUN, 0.5, 50.0, 0.49957, 0.499, 0.513),
            (ON_GRID_VERLET, 1.0, 5.0, 1.0001, 0.984, 1.016),
            (ON_GRID_VERLET, 1.0, 10.0, 1.0, 0.998, 1.002),
            (ON_GRID_VERLET, 0.94, 5.0, 0.9410, 0.918, 0.982),
            (ON_GRID_VERLET, 0.94, 10.0, 0.94009, 0.936, 0.954),
            (ON_GRID_VERLET, 0.94, 50.0, 0.93998, 0.9399, 0.9423),
            (ON_GRID_VERLET, 0.5, 10.0, 0.4909, 0.454, 0.542),
            (ON_GRID_VERLET, 0.5, 15.0, 0.4930, 0.47, 0.54),
        ] {
            let found = of(scheme, e, steps);
            let tolerance = if steps >= 10.0 { 0.002 } else { 0.01 };
            assert!(
                (found.mean - mean).abs() < tolerance,
                "{scheme:?} e = {e}, Nc = {steps}: {found:?} against {mean}"
            );
            assert!(
                found.least > least - tolerance && found.largest < largest + tolerance,
                "{scheme:?} {e} {steps}: {found:?}"
            );
        }
        // strongly damped contacts, in which the force is zero while the gap is positive
        assert!((of(ON_GRID_HEUN, 0.1, 10.0).mean - 0.091).abs() < 0.01);
        assert!((of(ON_GRID_VERLET, 0.1, 10.0).mean - 0.0596).abs() < 0.01);
    }

    /// Compares changes of energy with those of linear maps that were computed independently. For restitution e = 1
    /// the compared number is the energy gained per contact with Heun's method, at the steps per contact of the
    /// channel cases. For e < 1 it is the energy lost over the loss by the exact restitution.
    #[test]
    fn heating() {
        for (steps, gain) in [(7.735, 0.0465), (10.94, 0.0169)] {
            let found = of(ON_GRID_HEUN, 1.0, steps);
            assert!((found.mean_square - 1.0 - gain).abs() < 2e-4, "{steps}: {found:?}");
            assert!((heating_per_collision(&found) - gain / 3.0).abs() < 1e-4);
        }
        for (e, steps, share) in [(0.9, 10.0, 0.932), (0.95, 10.0, 0.824), (0.94, 10.94, 0.894), (0.94, 7.735, 0.689)] {
            let found = of(ON_GRID_HEUN, e, steps);
            assert!(((1.0 - found.mean_square) / (1.0 - e * e) - share).abs() < 0.004, "{e} {steps}: {found:?}");
        }
        assert!(heating_per_collision(&of(ON_GRID_VERLET, 1.0, 7.735)).abs() < 5e-4);
    }

    /// Checks the order of the error with exact instants. The error is of fourth order in the step, as the integrator
    /// is, and of fifth order without damping. Without damping, a step with θ = ω_0 Δt reduces the amplitude by the
    /// fraction θ⁶/144, and a contact has π/θ steps.
    #[test]
    fn local_stepping_converges_with_its_order() {
        let miss = |e: f64, steps: f64| (of(LOCAL, e, steps).mean - e).abs();
        for (e, ratio) in [(1.0, 32.0), (0.5, 16.0)] {
            let found = miss(e, 20.0) / miss(e, 40.0);
            // the tolerance allows for the next order in the step
            assert!((found / ratio - 1.0).abs() < 0.15, "{e}: {found}");
        }
        assert!((miss(1.0, 20.0) / ((PI / 20.0).powi(5) * PI / 144.0) - 1.0).abs() < 0.02);
        assert!([1.0, 0.94, 0.5].iter().all(|&e| miss(e, 20.0) < 1e-5));
    }

    #[test]
    fn a_step_beyond_stability_has_no_restitution() {
        assert_eq!(realised_restitution(ON_GRID_VERLET, &LINEAR, (&unit_spring(0.0), 1.0), 10.0), None);
        assert_eq!(realised_restitution(LOCAL, &LINEAR, (&unit_spring(0.9), 1.0), f64::NAN), None);
        assert_eq!(realised_restitution(LOCAL, &LINEAR, (&unit_spring(0.9), 1.0), 0.0), None);
    }
}
