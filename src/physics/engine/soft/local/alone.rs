//! Isolated contact of two bodies without friction, described by one coordinate.
//!
//! Two spheres without friction conserve their angular momentum about each other, and a sphere at a plane conserves its
//! velocity along the plane. The only unknown is the distance q of the two centres, or of the centre from the plane.
//! For the linear law with stiffness k_n and damping γ_n, q'' = l²/q³ + (k_n δ - 2 γ_n M q')/M + g_n, where δ is the
//! overlap and M the effective mass. For pairs, l = q u_t is the specific angular momentum, with the tangential
//! velocity u_t, and g_n is 0. For walls, l is 0 and g_n is gravity along the normal. The Runge-Kutta steps are the
//! same as for several contacts, at a tenth of the cost.

use super::{RungeKuttaStage, crossing};
use crate::contact_law::{ContactLaw, Law, with_law};
use crate::engine::soft::contact::TouchingPair;
use crate::engine::soft::rates::{AlongNormal, Rates};
use nalgebra::Vector3;

/// [-] accuracy of a touch: largest remaining gap or overlap, divided by the diameter. The rounding error of positions
/// is not much smaller.
pub const TOUCH: f64 = 1e-11;

/// Largest number of iterations for one touch; each iteration adds several correct digits.
pub const TRIALS: usize = 6;

/// Distance of two bodies, its rate of change, and the angle by which the normal has turned.
#[derive(Clone, Copy, Debug)]
pub struct OrbitState {
    /// [m] distance between the centres, or from the wall to the centre.
    pub distance: f64,
    /// [m/s] rate of change of the distance; positive: separating.
    pub rate: f64,
    /// [rad] angle by which the normal has turned since the start.
    pub angle: f64,
}

/// Constants of an isolated contact: its two bodies touch no other body.
#[derive(Clone, Copy, Debug)]
pub struct IsolatedContact<'a> {
    /// Contact law of the two bodies.
    pub law: &'a ContactLaw,
    /// The two bodies and their contact constants.
    pub touch: TouchingPair,
    /// [m] distance of the centres at touch; at a wall the radius.
    pub reach: f64,
    /// [m²/s] specific angular momentum: distance of the centres times their tangential relative velocity; 0 at a
    /// wall.
    pub spin: f64,
    /// [m/s²] component of gravity along the normal; 0 for a pair.
    pub gravity: f64,
    /// [-] unit normal from the other body to particle i, at the start.
    pub normal: Vector3<f64>,
    /// Stages of the Runge-Kutta method by which the contact is integrated.
    pub stages: &'a [RungeKuttaStage],
}

impl IsolatedContact<'_> {
    /// Makes one step of `dt` [s], and adds its forces and powers to `sums`.
    #[inline(always)]
    fn step(&self, from: &OrbitState, dt: f64, sums: &mut AlongNormal) -> OrbitState {
        // the type of the law is looked up once per step, not at every stage
        with_law!(self.law, law => self.step_by(law, from, dt, sums))
    }

    /// Makes the step of [`step`](Self::step) for a contact law whose type is known when the code is compiled.
    #[inline(always)]
    fn step_by(&self, law: &(impl Law + ?Sized), from: &OrbitState, dt: f64, sums: &mut AlongNormal) -> OrbitState {
        let (mut moved, mut kicked, mut turned) = (0.0, 0.0, 0.0);
        let (mut now, mut acceleration) = (*from, 0.0);
        for stage in self.stages {
            let h = stage.at * dt;
            if stage.at > 0.0 {
                now.distance = from.distance + now.rate * h;
                now.rate = from.rate + acceleration * h;
            }
            let (elastic, viscous) = law.force(&self.touch.spring, self.reach - now.distance, now.rate);
            let (force, turn) = (elastic + viscous, self.spin / now.distance);
            acceleration = force / self.touch.spring.effective_mass + turn * turn / now.distance + self.gravity;
            sums.restitution_power -= stage.weight * (viscous * now.rate);
            sums.force += stage.weight * force;
            sums.force_moment += stage.moment * force;
            sums.virial += stage.weight * (force * now.distance);
            moved += now.rate * stage.weight;
            kicked += acceleration * stage.weight;
            turned += self.spin / (now.distance * now.distance) * stage.weight;
        }
        OrbitState {
            distance: from.distance + moved * dt,
            rate: from.rate + kicked * dt,
            angle: from.angle + turned * dt,
        }
    }

    /// Makes one step of up to `dt` [s], which ends early if the contact ends. Returns the new state, the time taken
    /// [s], and the powers and forces of the contact as means over that time.
    pub fn advance(&self, from: &OrbitState, dt: f64) -> (OrbitState, f64, Rates) {
        let rates = |sums: &AlongNormal| Rates::along(&self.touch.couple, &self.normal, sums);
        let mut sums = AlongNormal::default();
        let full = self.step(from, dt, &mut sums);
        if full.distance <= self.reach {
            return (full, dt, rates(&sums));
        }
        let gap = |state: &OrbitState| state.distance - self.reach;
        let (mut low, mut high) = (0.0, 1.0);
        let mut fraction = crossing((gap(from), from.rate), (gap(&full), full.rate), dt);
        let (mut state, mut taken) = (full, dt);
        for _ in 0..TRIALS {
            sums = AlongNormal::default();
            taken = fraction * dt;
            state = self.step(from, taken, &mut sums);
            let open = gap(&state);
            if open.abs() <= TOUCH * self.touch.diameter {
                break;
            }
            // Newton's method, restricted to the interval between an overlap and an open gap
            if open > 0.0 {
                high = fraction
            } else {
                low = fraction
            }
            let newton = fraction - open / (state.rate * dt);
            fraction = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        }
        (state, taken, rates(&sums))
    }
}
