//! The linear spring-dashpot: how long a contact lasts, and how much it dissipates (the paper's section 3.3).

use crate::scene::Scene;
use std::f64::consts::PI;

/// Normal contact law f_n = k_n δ - 2 γ_n M u_n (Eq. 3, with the sign of the spring put right), between the instants at
/// which the overlap δ leaves and reaches zero.
///
/// The dashpot pulls a little at the end of a contact; the contact ends at δ = 0, so that the restitution of an isolated
/// impact is exactly the nominal one. The effective mass is M = m_p m_q / (m_p + m_q) for a pair and M = m_p for a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearSpringDashpot {
    /// [N/m] normal stiffness k_n > 0.
    pub stiffness: f64,
}

impl LinearSpringDashpot {
    /// [-] damping ratio γ_n/ω_0 = -ln e / sqrt(π² + ln² e) for a restitution `e` in (0, 1] (Eq. 7): 0 for e = 1,
    /// towards 1 for e -> 0.
    pub fn damping_ratio(e: f64) -> f64 {
        let log = e.ln();
        -log / PI.hypot(log)
    }

    /// [1/s] undamped frequency ω_0 = sqrt(k_n/M) for the effective mass M [kg].
    pub fn frequency(&self, effective_mass: f64) -> f64 {
        (self.stiffness / effective_mass).sqrt()
    }

    /// [1/s] damping γ_n for the effective mass M [kg] and the restitution `e` in (0, 1].
    pub fn damping(&self, effective_mass: f64, e: f64) -> f64 {
        Self::damping_ratio(e) * self.frequency(effective_mass)
    }

    /// [s] contact time T_c = π / sqrt(ω_0² - γ_n²) (Eq. 7) for the effective mass M [kg] and the restitution `e` in (0, 1].
    pub fn contact_time(&self, effective_mass: f64, e: f64) -> f64 {
        let ratio = Self::damping_ratio(e);
        PI / (self.frequency(effective_mass) * (1.0 - ratio * ratio).sqrt())
    }
}

/// The shortest contacts a scene can have [s]: the time step must resolve them. Masses differ, so pairs and walls do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactTimes {
    /// [s] between two particles of the lightest kind; `None` if there are no two.
    pub pair: Option<f64>,
    /// [s] of the lightest kind at any wall; `None` without walls or particles.
    pub wall: Option<f64>,
}

impl ContactTimes {
    /// Contact times of a scene with that many particles and the stiffness k_n [N/m].
    pub fn shortest(scene: &Scene, stiffness: f64, particles: usize) -> Self {
        let law = LinearSpringDashpot { stiffness };
        let lightest = scene.species.iter().map(|species| species.mass()).min_by(f64::total_cmp);
        let lightest = lightest.filter(|_| particles > 0);
        Self {
            pair: lightest
                .filter(|_| particles > 1)
                .map(|mass| law.contact_time(0.5 * mass, scene.contact.restitution)),
            wall: lightest.and_then(|mass| {
                let times = scene.walls.iter().map(|wall| law.contact_time(mass, wall.surface.restitution));
                times.min_by(f64::total_cmp)
            }),
        }
    }

    /// [s] the shorter of the two.
    pub fn governing(&self) -> Option<f64> {
        self.pair.into_iter().chain(self.wall).min_by(f64::total_cmp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Oracle A1: damping ratio and reduced contact time ω_0 T_c.
    #[test]
    fn reduced_contact_times() {
        let law = LinearSpringDashpot { stiffness: 1.0 };
        for (e, ratio, time) in [
            (1.0, 0.0, PI),
            (0.94, 0.019691734, 3.142201930),
            (0.5, 0.215453762, 3.217150512),
            (0.1, 0.591155034, 3.895061298),
        ] {
            assert!((LinearSpringDashpot::damping_ratio(e) - ratio).abs() < 1e-9);
            assert!((law.contact_time(1.0, e) - time).abs() < 1e-9);
        }
    }

    /// Oracle A1: polystyrene of 406 µm at 3000 N/m, pair and wall.
    #[test]
    fn paper_sized_contact_times() {
        let law = LinearSpringDashpot { stiffness: 3000.0 };
        let mass = 3.6372577e-8;
        assert!((law.contact_time(mass / 2.0, 1.0) / 7.73502e-6 - 1.0).abs() < 1e-5);
        assert!((law.contact_time(mass, 1.0) / 1.09390e-5 - 1.0).abs() < 1e-5);
    }
}
