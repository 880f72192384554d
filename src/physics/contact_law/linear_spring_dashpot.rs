//! The linear spring-dashpot law: elastic force proportional to the overlap, viscous force proportional to its rate.

use super::{Bodies, Law, Parameter, Spring, damping_ratio, reduced_overlap};
use std::f64::consts::PI;

/// Normal force on particle p along the unit normal n (from body q to p): f_n = k_n δ - 2 γ_n M u_n. Here δ is the
/// overlap, M the effective mass, and u_n = (u_p - u_q)·n the normal velocity.
///
/// This is Eq. 3 of the paper that docs/paper.md describes, with the sign of the spring corrected. The contact ends
/// when δ = 0, so the force is slightly attractive at the end, and the restitution is exactly the required one. The law
/// is valid if δ is small compared with the radius.
///
/// The constants between two bodies are the stiffness k_n [N/m] and the dashpot 2 γ_n M [N s/m]. Here γ_n = ζ ω_0,
/// with the damping ratio ζ and the undamped angular frequency ω_0 = sqrt(k_n/M) (below Eq. 6 of that paper).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearSpringDashpot {
    /// [N/m] normal stiffness k_n of the linear spring.
    pub stiffness: f64,
}

/// [1/s] angular frequency ω_0 = sqrt(k_n/M) of the spring and the effective mass M, without damping.
fn undamped(spring: &Spring) -> f64 {
    (spring.stiffness / spring.effective_mass).sqrt()
}

impl LinearSpringDashpot {
    /// Returns this law with a stiffness that is `factor` [-] times as large.
    pub fn stiffened(&self, factor: f64) -> Self {
        Self { stiffness: factor * self.stiffness }
    }
}

impl Law for LinearSpringDashpot {
    fn between(&self, bodies: &Bodies) -> Spring {
        let Bodies { effective_mass, restitution, .. } = *bodies;
        let stiffness = self.stiffness * bodies.stiffness_ratio;
        let damping = damping_ratio(restitution) * (stiffness / effective_mass).sqrt();
        Spring { effective_mass, restitution, stiffness, dashpot: 2.0 * damping * effective_mass }
    }

    #[inline]
    fn force(&self, spring: &Spring, overlap: f64, normal_velocity: f64) -> (f64, f64) {
        (spring.stiffness * overlap, -spring.dashpot * normal_velocity)
    }

    #[inline]
    fn stored_energy(&self, spring: &Spring, overlap: f64) -> f64 {
        0.5 * spring.stiffness * overlap * overlap
    }

    /// Returns the contact time T_c = π / sqrt(ω_0² - γ_n²) [s] (Eq. 7 of the paper in docs/paper.md), with the
    /// undamped angular frequency ω_0 and the damping γ_n. It does not depend on the speed, and is infinite for the
    /// restitution 0.
    fn contact_time(&self, spring: &Spring, _speed: f64) -> f64 {
        let ratio = damping_ratio(spring.restitution);
        PI / (undamped(spring) * (1.0 - ratio * ratio).sqrt())
    }

    /// Returns the largest overlap [m] of an impact at the normal speed `speed` [m/s], by Eq. 10 of the paper in
    /// docs/paper.md.
    fn greatest_overlap(&self, spring: &Spring, speed: f64) -> f64 {
        reduced_overlap(spring.restitution) * speed * (spring.effective_mass / spring.stiffness).sqrt()
    }

    fn frequency(&self, spring: &Spring, _speed: f64) -> f64 {
        undamped(spring)
    }

    fn damping_ratio(&self, spring: &Spring, _speed: f64) -> f64 {
        damping_ratio(spring.restitution)
    }

    /// Returns sqrt(π E/(2 k_n)) [m], the length by which the diameter seems smaller in collisions with the energy
    /// scale E = `energy` [J]. k_n is the stiffness.
    fn thermal_overlap(&self, spring: &Spring, energy: f64) -> f64 {
        (PI * energy / (2.0 * spring.stiffness)).sqrt()
    }

    /// Returns the overlap [m] and its rate [m/s] as functions of the time [s] since touch, by Eq. 6 of the paper in
    /// docs/paper.md.
    fn course(&self, spring: &Spring, speed: f64) -> Box<dyn Fn(f64) -> (f64, f64)> {
        let ratio = damping_ratio(spring.restitution);
        let damping = ratio * undamped(spring);
        let damped = undamped(spring) * (1.0 - ratio * ratio).sqrt();
        Box::new(move |time| {
            let envelope = speed * (-damping * time).exp();
            let overlap = envelope / damped * (damped * time).sin();
            (overlap, envelope * (damped * time).cos() - damping * overlap)
        })
    }

    #[inline]
    fn well_depth(&self, _spring: &Spring) -> f64 {
        0.0
    }

    fn static_overlap(&self, spring: &Spring, force: f64) -> f64 {
        force / spring.stiffness
    }

    fn title(&self) -> &'static str {
        "linear spring-dashpot"
    }

    fn parameters(&self) -> Vec<Parameter> {
        let (law, key) = ("linear_spring_dashpot", "stiffness");
        vec![Parameter { law, key, name: "stiffness", symbol: "k_n", value: self.stiffness, unit: "N/m" }]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spring(stiffness: f64, effective_mass: f64, restitution: f64) -> (LinearSpringDashpot, Spring) {
        let law = LinearSpringDashpot { stiffness };
        (
            law,
            law.between(&Bodies {
                effective_mass,
                effective_radius: 1.0,
                restitution,
                by_speed: None,
                elasticity: [None; 2],
                stiffness_ratio: 1.0,
            }),
        )
    }

    /// Checks the damping ratio and the reduced contact time ω_0 T_c against independently computed values.
    #[test]
    fn reduced_contact_times() {
        for (e, ratio, time) in [
            (1.0, 0.0, PI),
            (0.94, 0.019691734, 3.142201930),
            (0.5, 0.215453762, 3.217150512),
            (0.1, 0.591155034, 3.895061298),
        ] {
            assert!((damping_ratio(e) - ratio).abs() < 1e-9);
            let (law, spring) = spring(1.0, 1.0, e);
            assert!((law.contact_time(&spring, 1.0) - time).abs() < 1e-9);
        }
    }

    /// Checks contact times of polystyrene spheres with a diameter of 406 µm and a stiffness of 3000 N/m, for a pair
    /// and a wall, against independently computed values.
    #[test]
    fn paper_sized_contact_times() {
        let mass = 3.6372577e-8;
        for (mass, time) in [(mass / 2.0, 7.73502e-6), (mass, 1.09390e-5)] {
            let (law, spring) = spring(3000.0, mass, 1.0);
            assert!((law.contact_time(&spring, 1.0) / time - 1.0).abs() < 1e-5);
        }
    }

    /// Checks the largest overlap against the closed form of the damped oscillator, evaluated separately to ten digits.
    #[test]
    fn largest_overlap_is_eq_10() {
        for (e, depth) in [(1.0, 1.0), (0.94, 0.969912093), (0.9, 0.949750530), (0.5, 0.741810737), (0.1, 0.502721970)]
        {
            let (law, spring) = spring(1.0, 1.0, e);
            assert!((law.greatest_overlap(&spring, 1.0) - depth).abs() < 1e-9, "{e}");
        }
        assert!((reduced_overlap(1e-200) - reduced_overlap(0.0)).abs() < 1e-2);
    }
}
