//! The linear spring-dashpot law.

use crate::scene::{Scene, Surface};
use std::f64::consts::PI;

/// Normal force on p along n (from q to p): f_n = k_n δ - 2 γ_n M u_n, with overlap δ and u_n = (u_p - u_q)·n.
///
/// The paper's Eq. 3 with the sign of the spring put right. The contact ends when δ = 0, so the force pulls a little
/// at the end and the realised restitution is exactly e_n. Valid while δ is small against the radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearSpringDashpot {
    /// [N/m] normal stiffness k_n.
    pub stiffness: f64,
}

impl LinearSpringDashpot {
    /// [-] damping ratio ζ = γ_n/ω_0 = -ln e / sqrt(π² + ln² e) (the paper, below Eq. 6); 1 for e = 0.
    pub fn damping_ratio(restitution: f64) -> f64 {
        if restitution <= 0.0 {
            return 1.0;
        }
        let ln = restitution.ln();
        -ln / (PI * PI + ln * ln).sqrt()
    }

    /// [1/s] undamped angular frequency ω_0 = sqrt(k_n/M), effective mass M [kg] (a wall's partner: its own mass).
    pub fn angular_frequency(&self, effective_mass: f64) -> f64 {
        (self.stiffness / effective_mass).sqrt()
    }

    /// [1/s] normal damping γ_n.
    pub fn damping(&self, effective_mass: f64, restitution: f64) -> f64 {
        Self::damping_ratio(restitution) * self.angular_frequency(effective_mass)
    }

    /// [s] contact time T_c = π / sqrt(ω_0² - γ_n²) (Eq. 7); infinite for e = 0.
    pub fn contact_time(&self, effective_mass: f64, restitution: f64) -> f64 {
        let ratio = Self::damping_ratio(restitution);
        PI / (self.angular_frequency(effective_mass) * (1.0 - ratio * ratio).sqrt())
    }

    /// [J] energy stored in the spring at overlap δ [m], k_n δ²/2.
    pub fn elastic_energy(&self, overlap: f64) -> f64 {
        0.5 * self.stiffness * overlap * overlap
    }

    /// [N] spring and dashpot parts of the normal force at overlap δ [m] and u_n [m/s] (negative: approaching).
    #[inline]
    pub fn normal_force(&self, overlap: f64, normal_velocity: f64, effective_mass: f64, damping: f64) -> (f64, f64) {
        (self.stiffness * overlap, -2.0 * damping * effective_mass * normal_velocity)
    }
}

/// [N] magnitude of the Coulomb force against a slip of `slip` >= 0 [m/s] (the paper's rule, without rotation):
/// μ|f_n|, but never more than would stop the slip within `time_step` [s].
#[inline]
pub fn friction_force(surface: &Surface, normal_force: f64, slip: f64, effective_mass: f64, time_step: f64) -> f64 {
    (surface.friction * normal_force.abs()).min(effective_mass * slip / time_step)
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
