//! Pair distribution g(r) of the centres, and its value at contact.
//!
//! g_ab(r) is the number of pairs of the species a and b at the distance r, over the number in an ideal gas of the same
//! density: g = n(r, Δr) V/(P 4π/3 ((r + Δr)³ - r³)). n counts the pairs between r and r + Δr, P all pairs, and V is
//! the volume of the box (Allen and Tildesley, Computer Simulation of Liquids, 2nd edition 2017, section 2.6). Here P
//! is N(N-1)/2 and not N²/2, so that an ideal gas of any size has g = 1. The box must be periodic along all axes.

use super::measurements::{Measurement, Observation, ObservedCurve, ObservedNumber, ObservedQuantity};
use super::near_pairs::near_pairs;
use super::{Needs, Observer, plain_data};
use crate::experiment::{Experiment, Model, PairDistributionSettings};
use crate::kinetic_theory::contact_value;
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::{Estimate, estimate};
use nalgebra::SMatrix;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Largest number of samples (instants of measurement) that are used. In a run with more samples, only every n-th
/// sample is used.
const MOST_SAMPLES: u64 = 1000;
/// Number of bins of the distance, beginning at contact, from whose counts the value of g(r) at contact is
/// extrapolated.
const NEAR: usize = 12;
/// [-] width of a bin near contact, over the distance of the two centres at contact. A parabola over all bins near
/// contact (0.12 diameters) extrapolates g of a hard-sphere fluid to contact with an error of 0.2 % at a volume
/// fraction of 0.45, where g falls like exp(-5 r/d), with the diameter d.
const NEAR_WIDTH: f64 = 0.01;
/// [-] outer end of the last bin near contact: distance of the two centres over their distance at contact.
const FURTHEST: f64 = 1.0 + NEAR as f64 * NEAR_WIDTH;

/// Numbers of pairs of particles in bins of their distance at one instant, for each pair of species.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct PairSample {
    /// [s] simulated time at which the pairs are counted.
    time: f64,
    /// Number of pairs of particles in each bin of the distance, for each pair of species in the order of [`index`].
    bins: Vec<Vec<u64>>,
    /// Number of pairs of particles in each narrow bin near contact, for each pair of species in the order of
    /// [`index`].
    near: Vec<[u64; NEAR]>,
}

impl PairSample {
    fn empty(time: f64, pairs: usize, bins: usize) -> Self {
        Self { time, bins: vec![vec![0; bins]; pairs], near: vec![[0; NEAR]; pairs] }
    }

    fn add(&mut self, other: &Self) {
        let add = |own: &mut [u64], others: &[u64]| own.iter_mut().zip(others).for_each(|(own, other)| *own += other);
        self.bins.iter_mut().zip(&other.bins).for_each(|(own, other)| add(own, other));
        self.near.iter_mut().zip(&other.near).for_each(|(own, other)| add(own, other));
    }
}

/// Measurement of the pair distribution g(r) of the centres at samples (instants of measurement).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PairDistribution {
    /// [s] time between two instants at which the pairs are counted.
    interval: f64,
    /// [m] largest distance of two centres that is counted in the bins of the histogram.
    reach: f64,
    bins: usize,
    /// [m] distance of the centres at contact for each pair of species. `None` if diameters vary within a species, or
    /// if half the box is too small for the bins near contact.
    contact: Vec<Option<f64>>,
    samples: Vec<PairSample>,
}

/// Index of the pair of the species a and b in lists of pairs: (0, 0), (0, 1), (1, 1), (0, 2) and so on.
fn index(a: u16, b: u16) -> usize {
    let (low, high) = (usize::from(a.min(b)), usize::from(a.max(b)));
    high * (high + 1) / 2 + low
}

/// All pairs of indices of `count` species, in the order of [`index`].
fn species_pairs(count: usize) -> impl Iterator<Item = [usize; 2]> {
    (0..count).flat_map(|high| (0..=high).map(move |low| [low, high]))
}

/// [m³] volume of a spherical shell between two radii [m].
fn shell(inner: f64, outer: f64) -> f64 {
    4.0 / 3.0 * PI * (outer.powi(3) - inner.powi(3))
}

impl PairDistribution {
    /// Creates the measurement for a run of `experiment`. `schedule` contains the instants of measurement.
    pub fn new(experiment: &Experiment, schedule: &Schedule, settings: PairDistributionSettings) -> Self {
        let species = &experiment.scene.species;
        let contact = |[a, b]: [usize; 2]| {
            let is_one_size = species[a].sizes.is_none() && species[b].sizes.is_none();
            let contact = 0.5 * (species[a].diameter + species[b].diameter);
            // the bins beyond contact must be within half a period, as all distances are
            (is_one_size && FURTHEST * contact <= 0.5 * experiment.scene.domain.size.min()).then_some(contact)
        };
        Self {
            interval: schedule.spacing(MOST_SAMPLES),
            reach: settings.reach,
            bins: settings.bins,
            contact: species_pairs(species.len()).map(contact).collect(),
            samples: Vec::new(),
        }
    }

    /// Pair distribution g [-] in each bin of the distance, averaged over `samples` (instants of measurement); `None`
    /// if they are empty. `counts` returns the number of pairs in a bin at one instant. `share` [m³] is the volume of
    /// the box divided by the number of all pairs.
    fn curve(
        &self,
        samples: &[&PairSample],
        share: f64,
        counts: impl Fn(&PairSample, usize) -> u64,
    ) -> Vec<Option<Estimate>> {
        let width = self.reach / self.bins as f64;
        let bin = |k: usize| {
            let per_count = share / shell(k as f64 * width, (k + 1) as f64 * width);
            let series: Vec<f64> = samples.iter().map(|sample| counts(sample, k) as f64 * per_count).collect();
            estimate(&series)
        };
        (0..self.bins).map(bin).collect()
    }

    /// Pair distribution g [-] extrapolated to contact, where the centres have the distance `contact` [m]. `pair` is
    /// the index of the pair of species. `share` [m³] is the volume of the box divided by the number of pairs of these
    /// species. There is one value for each of the `samples`. `None` if the extrapolation has no unique solution.
    fn at_contact(&self, samples: &[&PairSample], pair: usize, contact: f64, share: f64) -> Option<Vec<f64>> {
        let weights = weights_at_contact()?;
        let edge = |k: usize| contact * (1.0 + k as f64 * NEAR_WIDTH);
        let per_count: Vec<f64> = (0..NEAR).map(|k| weights[k] * share / shell(edge(k), edge(k + 1))).collect();
        let value = |sample: &&PairSample| {
            sample.near[pair].iter().zip(&per_count).map(|(count, factor)| *count as f64 * factor).sum()
        };
        Some(samples.iter().map(value).collect())
    }
}

/// Weights of the values of g in the bins near contact. The weighted sum is the value at contact of a parabola fitted
/// by least squares. `None` if the fit has no unique solution, which happens for fewer than three bins.
fn weights_at_contact() -> Option<[f64; NEAR]> {
    let powers = SMatrix::<f64, NEAR, 3>::from_fn(|bin, power| (bin as f64 + 0.5).powi(power as i32));
    let fit = (powers.transpose() * powers).try_inverse()? * powers.transpose();
    Some(std::array::from_fn(|bin| fit[(0, bin)]))
}

impl Measurement for PairDistribution {
    fn result(&self, experiment: &Experiment, from: f64) -> Observation {
        let scene = &experiment.scene;
        let samples: Vec<&PairSample> = self.samples.iter().filter(|sample| sample.time >= from).collect();
        let (counts, volume, species) = (experiment.counts(), scene.domain.volume(), &scene.species);
        let fraction: f64 = counts.iter().zip(species).map(|(n, of)| *n as f64 * of.volume()).sum::<f64>() / volume;
        let squares = counts.iter().zip(species).map(|(n, of)| *n as f64 * of.diameter * of.diameter);
        let second = PI / 6.0 * squares.sum::<f64>() / volume;
        let width = self.reach / self.bins as f64;
        let (mut curves, mut numbers) = (Vec::new(), Vec::new());
        let clock = [samples.first().map_or(from, |sample| sample.time), self.interval];
        let quantity = |kind: &str, symbol: &str, [a, b]: [usize; 2]| {
            let names = format!("{}-{}", species[a].name, species[b].name);
            if species.len() == 1 {
                ObservedQuantity::new(kind, symbol, "")
            } else {
                ObservedQuantity::new(format!("{kind} {names}"), format!("{symbol} {names}"), "")
            }
        };
        let mut push = |quantity: ObservedQuantity, values: Vec<Option<Estimate>>| {
            curves.push(ObservedCurve { quantity, values, theory: None, is_logarithmic: false });
        };
        if species.len() > 1 {
            let all = counts.iter().sum::<usize>() as f64;
            let together = |sample: &PairSample, bin: usize| sample.bins.iter().map(|of| of[bin]).sum();
            push(
                ObservedQuantity::new("g", "g(r) of all", ""),
                self.curve(&samples, 2.0 * volume / (all * (all - 1.0)), together),
            );
        }
        for (pair, [a, b]) in species_pairs(species.len()).enumerate() {
            let (n, m) = (counts[a] as f64, counts[b] as f64);
            let share = if a == b { 2.0 * volume / (n * (n - 1.0)) } else { volume / (n * m) };
            push(quantity("g", "g(r)", [a, b]), self.curve(&samples, share, |sample, bin| sample.bins[pair][bin]));
            let Some(contact) = self.contact[pair] else { continue };
            let exact = contact_value(species[a].diameter, species[b].diameter, fraction, second);
            let source =
                if species.len() == 1 { "Carnahan and Starling 1969" } else { "Boublik 1970, Mansoori et al. 1971" };
            let series = self.at_contact(&samples, pair, contact, share).unwrap_or_default();
            let quantity = quantity("contact_value", "g at contact", [a, b]);
            // spheres that collide by chance do not exclude each other
            let theory = (!scene.has_sizes() && experiment.model() != Model::Dsmc).then_some((source, exact));
            numbers.push(ObservedNumber::of_series(quantity, &series, clock, theory));
        }
        Observation {
            name: "pair_distribution",
            title: "Pair distribution",
            axis: ObservedQuantity::new("r_m", "r", "m"),
            places: (0..self.bins).map(|bin| (bin as f64 + 0.5) * width).collect(),
            curves,
            numbers,
            ..Observation::default()
        }
    }
}

impl Observer for PairDistribution {
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        Some(now + self.interval)
    }

    fn needs_velocities(&self) -> bool {
        false
    }

    fn needs(&self) -> Needs {
        Needs::Every(1)
    }

    fn see(&mut self, simulation: &Simulation) {
        let (particles, domain) = (&simulation.particles, &simulation.scene().domain);
        let per_width = self.bins as f64 / self.reach;
        let time = simulation.time;
        let empty = || PairSample::empty(time, self.contact.len(), self.bins);
        // bins beyond contact may be outside the reach of the histogram
        let reach = self.contact.iter().flatten().fold(self.reach, |reach, contact| reach.max(FURTHEST * contact));
        let parts = near_pairs(particles, domain, reach, empty, |found, [one, other], apart| {
            let (pair, distance) = (index(particles.species[one], particles.species[other]), apart.norm());
            if let Some(count) = found.bins[pair].get_mut((distance * per_width) as usize) {
                *count += 1;
            }
            if let Some(contact) = self.contact[pair] {
                let beyond = (distance / contact - 1.0) / NEAR_WIDTH;
                if beyond >= 0.0
                    && let Some(count) = found.near[pair].get_mut(beyond as usize)
                {
                    *count += 1;
                }
            }
        });
        let mut sample = empty();
        parts.iter().for_each(|part| sample.add(part));
        self.samples.push(sample);
    }

    plain_data!();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_extrapolated_exactly() {
        let weights = weights_at_contact().unwrap();
        let value = |x: f64| 5.0 - 0.4 * x + 0.02 * x * x;
        let found: f64 = weights.iter().enumerate().map(|(bin, weight)| weight * value(bin as f64 + 0.5)).sum();
        // rounding of twelve terms, whose weights are below 1
        assert!((found - 5.0).abs() < 1e-11, "{found}");
    }

    #[test]
    fn pairs_of_species_have_indices_in_order() {
        let listed: Vec<[usize; 2]> = species_pairs(3).collect();
        assert_eq!(listed, [[0, 0], [0, 1], [1, 1], [0, 2], [1, 2], [2, 2]]);
        for (place, [a, b]) in listed.into_iter().enumerate() {
            assert_eq!((index(a as u16, b as u16), index(b as u16, a as u16)), (place, place));
        }
    }
}
