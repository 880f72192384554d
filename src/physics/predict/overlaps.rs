//! Distribution of the overlaps of contacts in a Maxwellian gas.
//!
//! Impacts have normal speeds u with the density u/s² exp(-u²/(2s²)). Here s² is 2T between equal spheres and T at a
//! wall, with the granular temperature T. The largest overlap of an impact is proportional to a power of its speed. For
//! a linear spring it is proportional to the speed itself (Eq. 10 of the paper, see `docs/paper.md`), so overlaps have
//! a Rayleigh distribution as the speeds have. If an engine tests for contacts only every Δt, it first detects a
//! contact at a random phase of its steps. The overlap is then u times a time that is uniformly distributed between 0
//! and Δt, for every contact law.

use super::contact::{ContactKind, ImpactSpeeds};
use crate::contact_law::ContactLaw;
use libm::erfc;
use serde::Serialize;
use std::f64::consts::{PI, SQRT_2};

/// Distribution of the overlaps of one kind of contact, divided by the diameter [-].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Overlaps {
    /// [-] largest overlap of an impact at the normal speed s, over the diameter. s² is the variance of the relative
    /// normal velocity.
    maximum: f64,
    /// [-] distance covered in one time step at the normal speed s, over the diameter.
    first: f64,
    /// [-] exponent p in the relation speed ∝ overlap^p for the largest overlap. It is (n+1)/2 for an elastic force ∝
    /// overlap^n.
    power: f64,
    /// [-] overlap number κ_n = u_r/(ω_0 d) by Eq. 9 of the paper (`docs/paper.md`), with the undamped angular
    /// frequency ω_0 of the contact, the diameter d, and the mean relative speed u_r = s sqrt(2/π).
    pub kappa: f64,
}

impl Overlaps {
    /// Computes the distribution of overlaps of one kind of contact under a contact law. An engine tests for contacts
    /// every `time_step` [s]. `None` unless the speeds are those of a Maxwellian gas with the same agitation
    /// everywhere and in all directions.
    pub fn of(contact: &ContactKind, law: &ContactLaw, time_step: f64) -> Option<Self> {
        let ImpactSpeeds::Gas { variance, parts } = &contact.speeds else { return None };
        let even = parts.iter().all(|[_, s]| *s == 1.0);
        let s = variance.sqrt();
        (even && s > 0.0).then(|| Self {
            maximum: contact.largest_overlap(law, s) / contact.diameter,
            first: s * time_step / contact.diameter,
            power: 0.5 * (law.exponent() + 1.0),
            kappa: contact.kappa(law),
        })
    }

    /// [-] probability density, at the value `x` [-], of the largest overlap of an impact over the diameter.
    pub fn maximum_density(&self, x: f64) -> f64 {
        let z = x / self.maximum;
        let speed = z.powf(self.power);
        self.power * z.powf(self.power - 1.0) * speed / self.maximum * (-0.5 * speed * speed).exp()
    }

    /// [-] fraction of the impacts whose largest overlap, divided by the diameter, is below `x` [-].
    pub fn maximum_share(&self, x: f64) -> f64 {
        -(-0.5 * (x / self.maximum).powf(2.0 * self.power)).exp_m1()
    }

    /// [-] probability density, at the value `x` [-], of the overlap over the diameter when an engine first detects the
    /// contact.
    pub fn first_density(&self, x: f64) -> f64 {
        (0.5 * PI).sqrt() / self.first * erfc(x / (SQRT_2 * self.first))
    }

    /// [-] fraction of the impacts for which the overlap over the diameter is below `x` [-] when an engine first
    /// detects the contact.
    pub fn first_share(&self, x: f64) -> f64 {
        let z = x / (SQRT_2 * self.first);
        PI.sqrt() * z * erfc(z) - (-z * z).exp_m1()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact_law::Bodies;

    /// Overlaps in case D of the paper (406 µm, 1038 kg/m³, u_r = 0.79 m/s, T = π/4 u_r²) with the stiffness
    /// `stiffness` [N/m].
    fn case_d(stiffness: f64) -> Overlaps {
        let (d, temperature) = (406e-6_f64, 0.25 * PI * 0.79 * 0.79);
        let mass = 1038.0 * PI / 6.0 * d.powi(3);
        let contact = ContactKind {
            name: "pair".into(),
            wall: false,
            bodies: Bodies {
                effective_mass: 0.5 * mass,
                effective_radius: 0.25 * d,
                restitution: 1.0,
                by_speed: None,
                elasticity: [None; 2],
                stiffness_ratio: 1.0,
            },
            diameter: d,
            speeds: ImpactSpeeds::isotropic(2.0 * temperature),
        };
        Overlaps::of(&contact, &ContactLaw::linear(stiffness), 1e-6).expect("a gas")
    }

    /// Mean of a distribution up to the value `until`, computed as the integral ∫ (1 - F) dx. F(x) is the fraction
    /// below x.
    fn mean(share: impl Fn(f64) -> f64, until: f64) -> f64 {
        let h = until / 20_000.0;
        (0..20_000).map(|k| h * (1.0 - share((f64::from(k) + 0.5) * h))).sum()
    }

    #[test]
    fn overlaps_of_case_d_are_those_of_kinetic_theory() {
        // values from a quadrature for a uniform gas, computed independently and rounded to the last digit given
        for (stiffness, average, deep, share) in [(300.0, 0.023798, 0.05, 0.0312), (3000.0, 0.007525, 0.01, 0.2499)] {
            let overlaps = case_d(stiffness);
            let found = mean(|x| overlaps.maximum_share(x), 10.0 * average);
            assert!((found / average - 1.0).abs() < 1e-4, "{found}");
            assert!((1.0 - overlaps.maximum_share(deep) - share).abs() < 6e-5);
            assert!((found / overlaps.kappa - 0.5 * PI).abs() < 1e-5);
        }
        for stiffness in [300.0, 30_000.0] {
            let overlaps = case_d(stiffness);
            let first = mean(|x| overlaps.first_share(x), 0.03);
            assert!((first - 0.001528).abs() < 1e-6, "{first}");
        }
    }

    #[test]
    fn densities_are_the_slopes_of_the_shares() {
        let overlaps = case_d(3000.0);
        for x in [1e-4, 1e-3, 3e-3, 0.01, 0.02] {
            let slope = |share: &dyn Fn(f64) -> f64| (share(x + 1e-7) - share(x - 1e-7)) / 2e-7;
            let largest = slope(&|x| overlaps.maximum_share(x)) - overlaps.maximum_density(x);
            let first = slope(&|x| overlaps.first_share(x)) - overlaps.first_density(x);
            // tolerance: rounding of the fraction over the step of the difference, 1e-16/1e-7, for densities of the
            // order of 100
            assert!(largest.abs() < 1e-6 && first.abs() < 1e-4, "{largest} {first}");
        }
    }
}
