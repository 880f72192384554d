//! Hertz's law with the damping of Tsuji, Tanaka and Ishida.

use super::{Bodies, Law, Parameter, Spring, damping_ratio, reduced_overlap};
use crate::scene::Elasticity;
use std::f64::consts::PI;

/// Normal force f_n = k_H δ^(3/2) - c δ^(1/4) u_n of smooth elastic spheres (Hertz 1882, J. reine angew. Math. 92, 156;
/// Johnson 1985, Contact Mechanics, Eqs. 4.22 and 4.23) with the viscous part of Tsuji, Tanaka and Ishida (1992, Powder
/// Technol. 71, 239). δ is the overlap and u_n the normal velocity.
///
/// The elastic constant is k_H = 4/3 E sqrt(R), with the effective radius R and the effective modulus E: 1/E =
/// (1-ν_p²)/E_p + (1-ν_q²)/E_q. E_p and E_q are Young's moduli of the two bodies, ν_p and ν_q their Poisson's ratios.
///
/// In the plane of w = δ^(5/4) and the rate of δ, an impact follows the path of a linear oscillator with spring and
/// dashpot. With the effective mass M, the square of the oscillator's undamped frequency is ω_0² = 4 k_H/(5 M), and its
/// damping ratio is c/sqrt(5 M k_H) (Antypov and Elliott 2011, EPL 94, 50004). The constant c = ζ sqrt(5 M k_H), with
/// the damping ratio ζ of a linear dashpot, therefore gives exactly the required restitution at every speed, if the
/// contact ends at δ = 0. The force is slightly attractive at the end. The time t in the impact follows from dt = 4/5
/// w^(-1/5) ds, where s is the time of the oscillator.
///
/// The constants between two bodies are k_H [N/m^1.5] and c [N s/m^1.25]. Walls count as flat. The law is valid if δ is
/// small compared with the radius, and the impact is slow compared with the speed of sound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hertz {
    /// Elasticity of every body for which a case (input file) gives no elasticity.
    pub elasticity: Elasticity,
}

/// Number of quadrature points for the duration of an impact. The relative error of the duration is proportional to
/// N^(-2.4) for N points. It is 1e-8 for the number chosen here.
const POINTS: usize = 2000;

/// [1/s] undamped angular frequency ω_0 with which w = δ^(5/4) oscillates in an impact, where δ is the overlap. Time is
/// here the time s of a linear oscillator, which [`Hertz`] defines.
fn undamped(spring: &Spring) -> f64 {
    (0.8 * spring.stiffness / spring.effective_mass).sqrt() // 4/5, Antypov and Elliott
}

/// Points of an impact at a normal speed [m/s]: time [s], overlap δ [m] and rate of the overlap [m/s]. This rate equals
/// dw/ds for w = δ^(5/4) and the time s of the linear oscillator that [`Hertz`] describes. The points are the ends of
/// `POINTS` intervals of the oscillator's phase. Intervals are short at both ends of the impact, where time is a
/// singular function of the phase.
fn path(spring: &Spring, speed: f64) -> Vec<[f64; 3]> {
    let ratio = damping_ratio(spring.restitution);
    let damped = undamped(spring) * (1.0 - ratio * ratio).sqrt();
    let at = |x: f64| {
        let phase = PI * x * x * x * (10.0 - 15.0 * x + 6.0 * x * x); // smootherstep: its slope is zero at 0 and 1
        let envelope = speed * (-ratio * undamped(spring) * phase / damped).exp();
        let w = (envelope * phase.sin() / damped).max(0.0);
        (w, envelope * phase.cos() - ratio * undamped(spring) * w)
    };
    let mut points = vec![[0.0, 0.0, speed]];
    let mut time = 0.0;
    for k in 0..POINTS {
        let (end, middle) = ((k + 1) as f64 / POINTS as f64, (k as f64 + 0.5) / POINTS as f64);
        let slope = 30.0 * PI * (middle * (1.0 - middle)).powi(2); // slope of the phase as a function of x
        time += 0.8 * at(middle).0.powf(-0.2) * slope / damped / POINTS as f64;
        let (w, growth) = at(end);
        points.push([time, w.powf(0.8), growth]);
    }
    points
}

/// [-] dashpot constant c = ζ sqrt(5 M k_H) in units of sqrt(M k_H), with the effective mass M and Hertz's constant
/// k_H. The damping ratio ζ, and so the result, depends only on the restitution.
fn unit_dashpot(restitution: f64) -> f64 {
    5.0f64.sqrt() * damping_ratio(restitution) // sqrt(5) ζ: Antypov and Elliott 2011
}

impl Hertz {
    /// Returns this law with an elastic force that is `factor` [-] times as large.
    pub fn stiffened(&self, factor: f64) -> Self {
        let youngs_modulus = factor * self.elasticity.youngs_modulus;
        Self { elasticity: Elasticity { youngs_modulus, ..self.elasticity } }
    }
}

impl Law for Hertz {
    fn between(&self, bodies: &Bodies) -> Spring {
        let compliance = |own: Option<Elasticity>| {
            let Elasticity { youngs_modulus, poissons_ratio } = own.unwrap_or(self.elasticity);
            (1.0 - poissons_ratio * poissons_ratio) / youngs_modulus
        };
        let modulus = 1.0 / (compliance(bodies.elasticity[0]) + compliance(bodies.elasticity[1]));
        let elastic = 4.0 / 3.0 * modulus * bodies.effective_radius.sqrt(); // Johnson 1985, Eq. 4.23
        let stiffness = elastic * bodies.stiffness_ratio;
        let Bodies { effective_mass, restitution, .. } = *bodies;
        let dashpot = unit_dashpot(restitution) * (effective_mass * stiffness).sqrt();
        Spring { effective_mass, restitution, stiffness, dashpot }
    }

    /// Returns the tangential stiffness over the square root of the overlap [N/m^1.5]: 8 G* sqrt(R) times the
    /// `stiffness_ratio` of the bodies, with the effective radius R. Here 1/G* = (2-ν_p)/G_p + (2-ν_q)/G_q, with
    /// Poisson's ratios ν and the shear moduli G = E/(2(1+ν)) of the two bodies (Mindlin 1949, J. Appl. Mech. 16, 259;
    /// Johnson 1985, Eq. 7.43).
    fn shear_stiffness(&self, bodies: &Bodies) -> f64 {
        let compliance = |own: Option<Elasticity>| {
            let Elasticity { youngs_modulus, poissons_ratio } = own.unwrap_or(self.elasticity);
            2.0 * (2.0 - poissons_ratio) * (1.0 + poissons_ratio) / youngs_modulus
        };
        let modulus = 1.0 / (compliance(bodies.elasticity[0]) + compliance(bodies.elasticity[1]));
        8.0 * modulus * bodies.effective_radius.sqrt() * bodies.stiffness_ratio
    }

    fn exponent(&self) -> f64 {
        1.5
    }

    #[inline]
    fn force(&self, spring: &Spring, overlap: f64, normal_velocity: f64) -> (f64, f64) {
        let root = overlap.abs().sqrt();
        (spring.stiffness * overlap * root, -spring.dashpot * root.sqrt() * normal_velocity)
    }

    /// Returns the energy 2/5 k_H δ^(5/2) [J] that the elastic force stores at the overlap δ, with Hertz's constant
    /// k_H.
    #[inline]
    fn stored_energy(&self, spring: &Spring, overlap: f64) -> f64 {
        0.4 * spring.stiffness * overlap * overlap * overlap.abs().sqrt()
    }

    /// Returns the duration [s] of an impact, proportional to u^(-1/5) with the normal speed u. Without damping it is
    /// 2.9433 δ_max/u, with the largest overlap δ_max (Johnson 1985, Eq. 11.24). It is infinite for the restitution 0.
    fn contact_time(&self, spring: &Spring, speed: f64) -> f64 {
        if damping_ratio(spring.restitution) >= 1.0 {
            return f64::INFINITY;
        }
        path(spring, speed)[POINTS][0]
    }

    /// Returns the largest overlap [m] of an impact, which grows with the normal speed u as u^(4/5).
    fn greatest_overlap(&self, spring: &Spring, speed: f64) -> f64 {
        (reduced_overlap(spring.restitution) * speed / undamped(spring)).powf(0.8)
    }

    /// Returns the angular frequency sqrt(3/2 k_H sqrt(δ)/M) [1/s] at the largest overlap δ of an impact without
    /// damping, with Hertz's constant k_H and the effective mass M. Damped impacts have lower frequencies.
    fn frequency(&self, spring: &Spring, speed: f64) -> f64 {
        let deepest = (speed / undamped(spring)).powf(0.8);
        (1.5 * spring.stiffness * deepest.sqrt() / spring.effective_mass).sqrt()
    }

    /// Returns the ratio [-] of the viscous constant c δ^(1/4) to the critical one, 2 sqrt(M · 3/2 k_H δ^(1/2)). Here c
    /// is the constant of the dashpot, k_H Hertz's constant and M the effective mass. The ratio does not depend on the
    /// overlap δ.
    fn damping_ratio(&self, spring: &Spring, _speed: f64) -> f64 {
        unit_dashpot(spring.restitution) / (2.0 * 1.5f64.sqrt())
    }

    /// Returns Γ(7/5) (5 E/(2 k_H))^(2/5) [m] = ∫ exp(-V(δ)/E) dδ, with the stored energy V at the overlap δ and E =
    /// `energy` [J]. Hard spheres that collide like these spheres have a diameter that is smaller by this length. k_H
    /// is Hertz's constant, and Γ(7/5) a value of the gamma function.
    fn thermal_overlap(&self, spring: &Spring, energy: f64) -> f64 {
        libm::tgamma(1.4) * (2.5 * energy / spring.stiffness).powf(0.4)
    }

    fn course(&self, spring: &Spring, speed: f64) -> Box<dyn Fn(f64) -> (f64, f64)> {
        let points = path(spring, speed);
        Box::new(move |time| {
            let after = points.partition_point(|point| point[0] < time).clamp(1, POINTS);
            let ([t0, x0, v0], [t1, x1, v1]) = (points[after - 1], points[after]);
            let part = ((time - t0) / (t1 - t0)).clamp(0.0, 1.0);
            (x0 + part * (x1 - x0), v0 + part * (v1 - v0))
        })
    }

    #[inline]
    fn well_depth(&self, _spring: &Spring) -> f64 {
        0.0
    }

    fn static_overlap(&self, spring: &Spring, force: f64) -> f64 {
        (force.max(0.0) / spring.stiffness).powf(1.0 / self.exponent())
    }

    fn title(&self) -> &'static str {
        "Hertz"
    }

    fn parameters(&self) -> Vec<Parameter> {
        let Elasticity { youngs_modulus, poissons_ratio } = self.elasticity;
        let of = |key, name, symbol, value, unit| Parameter { law: "hertz", key, name, symbol, value, unit };
        vec![
            of("youngs_modulus", "Young's modulus", "E", youngs_modulus, "Pa"),
            of("poissons_ratio", "Poisson's ratio", "ν", poissons_ratio, "-"),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glass(restitution: f64) -> (Hertz, Spring) {
        // two glass beads with a diameter of 2 mm; the effective mass is half the mass of one bead
        let law = Hertz { elasticity: Elasticity { youngs_modulus: 70e9, poissons_ratio: 0.22 } };
        let bodies = Bodies {
            effective_mass: 5.2e-6,
            effective_radius: 0.5e-3,
            restitution,
            by_speed: None,
            elasticity: [None; 2],
            stiffness_ratio: 1.0,
        };
        (law, law.between(&bodies))
    }

    /// Compares the largest overlap δ_max and the duration T_c with the textbook (Johnson 1985, Eqs. 11.23 and 11.24):
    /// δ_max = (15 M u²/(16 sqrt(R) E))^(2/5), T_c = 2.87 (M²/(R E² u))^(1/5). M, R and E are the effective mass,
    /// radius and modulus, and u is the speed.
    #[test]
    fn elastic_impacts_are_those_of_the_textbook() {
        let (law, spring) = glass(1.0);
        let modulus = 70e9 / (2.0 * (1.0 - 0.22 * 0.22));
        for speed in [0.01, 1.0] {
            let deepest = (15.0 * 5.2e-6 * speed * speed / (16.0 * 0.5e-3f64.sqrt() * modulus)).powf(0.4);
            assert!((law.greatest_overlap(&spring, speed) / deepest - 1.0).abs() < 1e-12);
            let time = (5.2e-6 * 5.2e-6 / (0.5e-3 * modulus * modulus * speed)).powf(0.2);
            // 2.868265... is 2.94327 (15/16)^(2/5), with 2.94327 from Gamma functions
            assert!((law.contact_time(&spring, speed) / time - 2.868_27).abs() < 2e-4);
        }
    }

    /// Compares restitution, duration and largest overlap with an accurate Runge-Kutta solution of the equation of
    /// motion, at several speeds.
    #[test]
    fn damped_impacts_are_those_of_the_equation_of_motion() {
        for (restitution, speed) in [(1.0, 0.3), (0.9, 0.01), (0.5, 1.0), (0.1, 1.0)] {
            let (law, spring) = glass(restitution);
            let (time, step) = (law.contact_time(&spring, speed), law.contact_time(&spring, speed) / 20_000.0);
            let rate = |[x, v]: [f64; 2]| {
                let (elastic, viscous) = law.force(&spring, x, -v);
                [v, -(elastic + viscous) / spring.effective_mass]
            };
            let (mut state, mut deepest, mut elapsed) = ([0.0, speed], 0.0f64, 0.0);
            while state[0] >= 0.0 {
                let along = |k: [f64; 2], h: f64| [state[0] + h * k[0], state[1] + h * k[1]];
                let k1 = rate(state);
                let k2 = rate(along(k1, 0.5 * step));
                let k3 = rate(along(k2, 0.5 * step));
                let k4 = rate(along(k3, step));
                state = [0, 1].map(|i| state[i] + step / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
                deepest = deepest.max(state[0]);
                elapsed += step;
            }
            // the end lies within a step; at touch the slope of the force is infinite, which reduces the order of the
            // method
            let rebound = -state[1] / speed;
            assert!((rebound - restitution).abs() < 2e-4, "{restitution}: {rebound}");
            assert!((elapsed / time - 1.0).abs() < 2e-4, "{restitution}: {}", elapsed / time);
            assert!((deepest / law.greatest_overlap(&spring, speed) - 1.0).abs() < 1e-5);
            let (overlap, _) = law.course(&spring, speed)(0.4 * time);
            assert!(overlap > 0.0 && overlap <= deepest * (1.0 + 1e-6));
        }
    }

    /// Compares two closed forms with quadratures: the stored energy with the work of the elastic force, and the
    /// thermal overlap with its integral.
    #[test]
    fn stored_energy_is_the_work_of_the_force() {
        let (law, spring) = glass(0.9);
        let (depth, count) = (1e-6, 100_000);
        let step = depth / f64::from(count);
        let work: f64 = (0..count).map(|k| law.force(&spring, (f64::from(k) + 0.5) * step, 0.0).0 * step).sum();
        assert!((work / law.stored_energy(&spring, depth) - 1.0).abs() < 1e-8);
        let energy = law.stored_energy(&spring, 1e-7);
        let weight = |k: i32| (-law.stored_energy(&spring, (f64::from(k) + 0.5) * step) / energy).exp() * step;
        let found: f64 = (0..count).map(weight).sum();
        assert!((found / law.thermal_overlap(&spring, energy) - 1.0).abs() < 1e-8, "{found}");
    }
}
