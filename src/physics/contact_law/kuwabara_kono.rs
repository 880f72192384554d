//! Law of viscoelastic spheres: Hertz's law with the damping of Kuwabara and Kono.

use super::{Bodies, Hertz, Law, Parameter, Spring};
use crate::restitution::{RestitutionBySpeed, ViscoelasticImpact, viscoelastic_impact};
use crate::scene::Elasticity;

/// Normal force f_n = k δ^(3/2) - c sqrt(δ) u_n of viscoelastic spheres, with c = 3/2 A k and a time A [s] of the
/// material (Kuwabara and Kono 1987, Jpn. J. Appl. Phys. 26, 1230; Brilliantov, Spahn, Hertzsch and Pöschel 1996, Phys.
/// Rev. E 53, 5382). The constant k [N/m^1.5] is that of [`Hertz`]. δ is the overlap and u_n the normal velocity.
///
/// The restitution depends on the speed u: it is a function of the damping number β = (c/k) (k/M)^(2/5) u^(1/5), with
/// the effective mass M. The constant c follows from the restitution of the surfaces. In a case (input file), this
/// restitution must be [`RestitutionBySpeed::Viscoelastic`] or 1. Then c does not depend on the speed, and impacts at
/// every speed have the restitution of hard spheres with the same surfaces. A program that uses this library can also
/// give a constant restitution, or a restitution that is another function of the speed. Impacts at 1 m/s then have the
/// restitution `Bodies::restitution`.
///
/// The contact ends when δ = 0, so the force is slightly attractive at the end. The law is valid while δ is small
/// compared with the radius, and while the impact is slow compared with the speed of sound and with the relaxation of
/// the material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KuwabaraKono {
    /// Elasticity of every body for which a case (input file) gives no elasticity.
    pub elasticity: Elasticity,
}

/// [-] damping number β = (c/k) (k/M)^(2/5) u^(1/5) of an impact at the normal speed u = `speed` [m/s]. k and c are the
/// constants of the law, and M is the effective mass.
fn damping(spring: &Spring, speed: f64) -> f64 {
    let Spring { effective_mass, stiffness, dashpot, .. } = *spring;
    dashpot / stiffness * (stiffness / effective_mass).powf(0.4) * speed.powf(0.2)
}

/// [m] largest overlap of an undamped impact at the normal speed u = `speed` [m/s], (5 M u²/(4 k))^(2/5) with the
/// effective mass M and Hertz's constant k (Johnson 1985, Eq. 11.23).
fn undamped_depth(spring: &Spring, speed: f64) -> f64 {
    (1.25 * spring.effective_mass * speed * speed / spring.stiffness).powf(0.4)
}

impl KuwabaraKono {
    /// Returns this law with an elastic force that is `factor` [-] times as large.
    pub fn stiffened(&self, factor: f64) -> Self {
        Self { elasticity: self.hertz().stiffened(factor).elasticity }
    }

    fn hertz(&self) -> Hertz {
        Hertz { elasticity: self.elasticity }
    }
}

impl Law for KuwabaraKono {
    fn between(&self, bodies: &Bodies) -> Spring {
        let elastic = self.hertz().between(&bodies.elastic());
        let unit = match bodies.by_speed {
            Some(RestitutionBySpeed::Viscoelastic { damping, .. }) => damping,
            _ => match RestitutionBySpeed::viscoelastic(bodies.restitution, 1.0) {
                RestitutionBySpeed::Viscoelastic { damping, .. } => damping,
                RestitutionBySpeed::Bridges { .. } | RestitutionBySpeed::Power { .. } => 0.0,
            },
        };
        let Spring { effective_mass, stiffness, .. } = elastic;
        let dashpot = unit * stiffness * (effective_mass / stiffness).powf(0.4);
        Spring { restitution: bodies.restitution, dashpot, ..elastic }
    }

    fn shear_stiffness(&self, bodies: &Bodies) -> f64 {
        self.hertz().shear_stiffness(bodies)
    }

    fn exponent(&self) -> f64 {
        1.5
    }

    #[inline]
    fn force(&self, spring: &Spring, overlap: f64, normal_velocity: f64) -> (f64, f64) {
        let root = overlap.abs().sqrt();
        (spring.stiffness * overlap * root, -spring.dashpot * root * normal_velocity)
    }

    #[inline]
    fn stored_energy(&self, spring: &Spring, overlap: f64) -> f64 {
        self.hertz().stored_energy(spring, overlap)
    }

    fn contact_time(&self, spring: &Spring, speed: f64) -> f64 {
        let Spring { effective_mass, stiffness, .. } = *spring;
        let unit = (effective_mass * effective_mass / (stiffness * stiffness * speed)).powf(0.2);
        let ViscoelasticImpact { duration, .. } = viscoelastic_impact(damping(spring, speed));
        duration * unit
    }

    fn greatest_overlap(&self, spring: &Spring, speed: f64) -> f64 {
        let unit = (spring.effective_mass * speed * speed / spring.stiffness).powf(0.4);
        let ViscoelasticImpact { depth, .. } = viscoelastic_impact(damping(spring, speed));
        depth * unit
    }

    fn frequency(&self, spring: &Spring, speed: f64) -> f64 {
        self.hertz().frequency(spring, speed)
    }

    /// Returns the ratio [-] of the viscous constant c sqrt(δ) to the critical one, 2 M ω, with the effective mass M
    /// and the angular frequency ω. Viscous constant and frequency are taken at the largest overlap δ of an impact
    /// without damping. Damped impacts have smaller overlaps.
    fn damping_ratio(&self, spring: &Spring, speed: f64) -> f64 {
        let viscous = spring.dashpot * undamped_depth(spring, speed).sqrt();
        viscous / (2.0 * spring.effective_mass * self.frequency(spring, speed))
    }

    fn thermal_overlap(&self, spring: &Spring, energy: f64) -> f64 {
        self.hertz().thermal_overlap(spring, energy)
    }

    #[inline]
    fn well_depth(&self, _spring: &Spring) -> f64 {
        0.0
    }

    fn static_overlap(&self, spring: &Spring, force: f64) -> f64 {
        self.hertz().static_overlap(spring, force)
    }

    fn title(&self) -> &'static str {
        "Kuwabara-Kono"
    }

    fn parameters(&self) -> Vec<Parameter> {
        let of_hertz = self.hertz().parameters().into_iter();
        of_hertz.map(|parameter| Parameter { law: "kuwabara_kono", ..parameter }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact_law::numerical::IntegratedImpact;

    /// Law, constants and restitution of glass beads with a diameter of 2 mm, whose restitution is 0.9 at 1 m/s.
    fn glass() -> (KuwabaraKono, Spring, RestitutionBySpeed) {
        let law = KuwabaraKono { elasticity: Elasticity { youngs_modulus: 70e9, poissons_ratio: 0.22 } };
        let of = RestitutionBySpeed::viscoelastic(0.9, 1.0);
        let bodies = Bodies {
            effective_mass: 5.2e-6,
            effective_radius: 0.5e-3,
            restitution: 0.9,
            by_speed: Some(of),
            elasticity: [None; 2],
            stiffness_ratio: 1.0,
        };
        (law, law.between(&bodies), of)
    }

    /// Compares restitution, duration and largest overlap with an integration in some 3000 time steps. The square root
    /// of the overlap in the force reduces the order of that integration to 3/2. Its error is some 3000^(-3/2) = 6e-6
    /// of the damping force, and ten times as much is allowed.
    #[test]
    fn impacts_are_those_of_the_equation_of_motion() {
        let (law, spring, of) = glass();
        for speed in [1e-4, 0.01, 1.0, 30.0] {
            let stepped = IntegratedImpact::new(&law, &spring, speed).unwrap();
            let near = |exact: f64, found: f64| (found / exact - 1.0).abs() < 6e-5;
            assert!(near(of.at(speed), stepped.rebound_speed() / speed), "{speed}");
            assert!(near(law.contact_time(&spring, speed), stepped.duration()), "{speed}");
            assert!(near(law.greatest_overlap(&spring, speed), stepped.greatest_overlap()), "{speed}");
        }
    }

    /// Compares the closed form of the damping ratio with the numerical one. Both take the viscous force at the largest
    /// overlap of an undamped impact.
    #[test]
    fn the_dashpot_is_stated_for_the_stability_of_steps() {
        let (law, spring, _) = glass();
        let exact = law.damping_ratio(&spring, 1.0);
        let numerical = crate::contact_law::numerical::damping_ratio(&law, &spring, 1.0);
        assert!((exact / numerical - 1.0).abs() < 1e-6, "{exact} and {numerical}");
    }

    #[test]
    fn a_constant_restitution_is_that_at_one_metre_per_second() {
        let (law, spring, _) = glass();
        let bodies = Bodies {
            effective_mass: 5.2e-6,
            effective_radius: 0.5e-3,
            restitution: 0.9,
            by_speed: None,
            elasticity: [None; 2],
            stiffness_ratio: 1.0,
        };
        assert_eq!(law.between(&bodies), spring);
        assert_eq!(law.between(&bodies.elastic()).dashpot, 0.0);
    }
}
