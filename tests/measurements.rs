//! Measurements that a case asks for, against values of others: brute force, the ideal gas, the Percus-Yevick equation,
//! Carnahan and Starling, Maxwell, van Noije and Ernst.

use crate::support::{edge, empty, experiment, surface, unit};
use diptych::domain::Domain;
use diptych::experiment::{
    ClustersSettings, DiffusionSettings, Experiment, FieldsSettings, FreeSurfaceSettings, Model, ObserveSettings,
    PairDistributionSettings, StructureFactorSettings, VelocityDistributionSettings, ViscositySettings,
};
use diptych::observe::{
    Diffusion, Measurement, Observation, ObservedNumber, ObservedQuantity, PairDistribution, VelocityDistribution, run,
};
use diptych::particles::Particles;
use diptych::placement::initial_state;
use diptych::schedule::Schedule;
use diptych::simulation::Simulation;
use diptych::statistics::Estimate;
use diptych::{Vector3, contact_law::ContactLaw, experiment::Spheres};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal, UnitBall};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::PI;

/// Gas of `count` unit spheres in a cube with the volume fraction `phi`, at the granular temperature 1 m²/s².
pub fn gas(count: usize, phi: f64, restitution: f64, model: Model) -> Experiment {
    let scene = empty([edge(count, 1.0, phi); 3], [true; 3], unit(), surface(restitution, 0.0));
    let mut gas = experiment(scene, count, [0.0; 3], 1.0, model, 3);
    gas.statistics.slices = 1;
    if model == Model::Soft {
        // the duration of a contact is a hundredth of the mean free time at most
        let law = ContactLaw::linear(1e6);
        (gas.soft.law, gas.run.spheres) = (Some(law), Spheres::Soft(law));
    }
    gas
}

/// Result of a measurement of a whole run.
pub fn measured<M: Measurement>(
    experiment: &Experiment,
    from: f64,
    make: impl FnOnce(&Experiment, &Schedule) -> M,
) -> Observation {
    let schedule = Schedule::new(experiment);
    let mut measurement = make(experiment, &schedule);
    let mut simulation = Simulation::new(experiment, initial_state(experiment).unwrap());
    run(&mut simulation, &schedule, &mut [&mut measurement]).unwrap();
    measurement.result(experiment, from)
}

/// Result of a measurement of given states, all at time 0.
pub fn of_states<M: Measurement>(
    experiment: &Experiment,
    mut measurement: M,
    states: impl IntoIterator<Item = Particles>,
) -> Observation {
    for state in states {
        measurement.see(&Simulation::new(experiment, state));
    }
    measurement.result(experiment, 0.0)
}

pub fn curve<'a>(observed: &'a Observation, column: &str) -> &'a [Option<Estimate>] {
    &observed.curves.iter().find(|curve| curve.quantity.column == column).unwrap().values
}

pub fn number(observed: &Observation, column: &str) -> Estimate {
    observed.numbers.iter().find(|number| number.quantity.column == column).unwrap().value.unwrap()
}

/// Asserts that an estimate agrees with a value within four standard errors plus `more`. Of 16 000 comparisons one is
/// beyond four standard errors by chance.
#[track_caller]
pub fn agrees(what: &str, found: Estimate, value: f64, more: f64) {
    let error = found.error.unwrap();
    println!("{what}: {} ± {error}, should be {value}", found.value);
    assert!((found.value - value).abs() <= 4.0 * error + more, "{what}: {} ± {error}, should be {value}", found.value);
}

/// Points at random in the box, with random species of the scene.
pub fn points(experiment: &Experiment, count: usize, random: &mut Xoshiro256PlusPlus) -> Particles {
    let (size, species) = (experiment.scene.domain.size, experiment.scene.species.len() as u16);
    let mut particles = Particles::default();
    for k in 0..count {
        let place = Vector3::from_fn(|axis, _| size[axis] * random.random::<f64>());
        particles.push(place, Vector3::zeros(), 0.5, 1.0, k as u16 % species);
    }
    particles
}

/// Distances of all pairs of two species, found by testing all images.
fn distances(domain: &Domain, particles: &Particles, [a, b]: [u16; 2]) -> Vec<f64> {
    let (size, offset) = (domain.size, domain.offset().unwrap_or(0.0));
    let mut all = Vec::new();
    for i in 0..particles.len() {
        for j in 0..i {
            let kinds = [particles.species[i], particles.species[j]];
            if kinds != [a, b] && kinds != [b, a] {
                continue;
            }
            let d = particles.position[i] - particles.position[j];
            let image = |x: i32, y: i32, z: i32| {
                let (x, y, z) = (f64::from(x), f64::from(y), f64::from(z));
                (d + Vector3::new(x * size.x, y * size.y, z * size.z + y * offset)).norm()
            };
            let images = (-1..=1).flat_map(|x| (-1..=1).flat_map(move |y| (-2..=2).map(move |z| (x, y, z))));
            all.push(images.map(|(x, y, z)| image(x, y, z)).fold(f64::INFINITY, f64::min));
        }
    }
    all
}

#[test]
fn pairs_are_those_of_all_images() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
    for shear in [None, Some(3.7), Some(-2.2)] {
        let mut gas = gas(120, 0.1, 1.0, Model::Hard);
        let domain = Domain::new(Vector3::new(8.0, 10.0, 9.0), [true; 3]);
        gas.scene.domain = shear.map_or(domain.clone(), |offset| domain.sheared(1.0, offset));
        let other = diptych::scene::Species { name: "other".into(), ..unit() };
        gas.scene.species.push(other);
        gas.start.push(diptych::experiment::Population { species: 1, ..gas.start[0].clone() });
        for population in &mut gas.start {
            population.amount = diptych::experiment::Amount::Count(60);
        }
        let settings = PairDistributionSettings { reach: 4.0, bins: 20 };
        let schedule = Schedule::new(&gas);
        let state = points(&gas, 120, &mut random);
        let found = of_states(&gas, PairDistribution::new(&gas, &schedule, settings), [state.clone()]);
        for (column, kinds, pairs) in
            [("g unit-unit", [0, 0], 1770.0), ("g unit-other", [0, 1], 3600.0), ("g other-other", [1, 1], 1770.0)]
        {
            let distances = distances(&gas.scene.domain, &state, kinds);
            for (bin, value) in curve(&found, column).iter().enumerate() {
                let (inner, outer) = (0.2 * bin as f64, 0.2 * (bin + 1) as f64);
                let count = distances.iter().filter(|d| (inner..outer).contains(*d)).count() as f64;
                let ideal = pairs * 4.0 / 3.0 * PI * (outer.powi(3) - inner.powi(3)) / 720.0;
                let value = value.unwrap().value;
                // rounding: counts are whole numbers
                assert!((value * ideal - count).abs() < 1e-6, "{shear:?}, {column}, bin {bin}: {value} {count}");
            }
        }
    }
}

#[test]
fn an_ideal_gas_has_no_structure() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(6);
    let gas = gas(100, 0.1, 1.0, Model::Hard);
    let settings = PairDistributionSettings { reach: 0.5 * gas.scene.domain.size.x, bins: 10 };
    let measurement = PairDistribution::new(&gas, &Schedule::new(&gas), settings);
    let states = (0..400).map(|_| points(&gas, 100, &mut random)).collect::<Vec<_>>();
    let found = of_states(&gas, measurement, states);
    for (bin, value) in curve(&found, "g").iter().enumerate() {
        agrees(&format!("g in bin {bin}"), value.unwrap(), 1.0, 0.0);
    }
    agrees("g at contact", number(&found, "contact_value"), 1.0, 0.0);
}

/// Pair distribution g of hard spheres of unit diameter by the Percus-Yevick equation, at the distances r = 1 + k/200.
/// Perram's method (1975, Mol. Phys. 30, 1505) integrates r h(r) = 2πn ∫_0^1 (r - t) h(|r - t|) Q(t) dt for r > 1.
/// Here h = g - 1, n is the number density, and Q Baxter's factor.
fn percus_yevick(phi: f64, points: usize) -> Vec<f64> {
    const PER_DIAMETER: usize = 200;
    let step = 1.0 / PER_DIAMETER as f64;
    let (a, b) = ((1.0 + 2.0 * phi) / (1.0 - phi).powi(2), -1.5 * phi / (1.0 - phi).powi(2));
    let q: Vec<f64> =
        (0..=PER_DIAMETER).map(|j| j as f64 * step).map(|t| 0.5 * a * (t * t - 1.0) + b * (t - 1.0)).collect();
    let factor = 2.0 * PI * (6.0 * phi / PI) * step;
    // H = r h(r), which is -r within the core
    let mut h: Vec<f64> = Vec::new();
    for i in 0..points {
        let (mut sum, split) = (0.0, i.min(PER_DIAMETER));
        for j in 1..=split {
            sum += h[i - j] * q[j] * if j == split { 0.5 } else { 1.0 };
        }
        for (j, weight) in q.iter().enumerate().skip(split) {
            let ends = j == split || j == PER_DIAMETER;
            let inside = -(1.0 + (i as f64 - j as f64) * step);
            sum += if i < PER_DIAMETER { inside * weight * if ends { 0.5 } else { 1.0 } } else { 0.0 };
        }
        // the term of t = 0 contains the unknown itself, with half a weight unless the range outside the core is empty
        let own = if split > 0 { 0.5 * factor * q[0] } else { 0.0 };
        h.push(factor * sum / (1.0 - own));
    }
    h.iter().enumerate().map(|(i, h)| 1.0 + h / (1.0 + i as f64 * step)).collect()
}

#[test]
fn the_pair_distribution_is_that_of_hard_spheres() {
    for (model, phi, duration, near) in [
        (Model::Hard, 0.1, 60.0, 0.01),
        (Model::Hard, 0.3, 20.0, 0.04),
        (Model::Hard, 0.45, 8.0, 0.15),
        (Model::Soft, 0.1, 12.0, 0.02),
        (Model::Soft, 0.3, 4.0, 0.05),
    ] {
        let mut gas = gas(1000, phi, 1.0, model);
        gas.run.duration = duration;
        gas.statistics.sample_interval = Some(duration / 200.0);
        let settings = PairDistributionSettings { reach: 4.0, bins: 80 };
        let found = measured(&gas, 0.1 * duration, |gas, schedule| PairDistribution::new(gas, schedule, settings));
        // the fluctuations of 1000 spheres, whose number is constant, lower g by S(0)/N
        let exact = (1.0 - 0.5 * phi) / (1.0 - phi).powi(3);
        // soft spheres of k = 1e6 N/m are smaller by the mean overlap, sqrt(π m T/2k)/d = 0.13 %, which changes φ by
        // 0.4 %; extrapolation and equation of state are right to 0.3 %
        let more = if model == Model::Soft { 0.02 } else { 0.005 };
        agrees(&format!("{model:?} φ = {phi}: g at contact"), number(&found, "contact_value"), exact, more * exact);
        let theory = percus_yevick(phi, 601);
        // the theory itself has this value at contact
        let contact = (1.0 + 0.5 * phi) / (1.0 - phi).powi(2);
        assert!((theory[0] - contact).abs() < 2e-3 * contact, "{} {contact}", theory[0]);
        let mut largest = 0.0_f64;
        for (r, value) in found.places.iter().zip(curve(&found, "g")) {
            let value = value.unwrap();
            if *r < 1.0 {
                let inside = if model == Model::Soft && *r > 0.95 { 0.1 } else { 0.0 };
                assert!(value.value <= inside, "{model:?}, {phi}: {value:?} at {r}");
            } else {
                // average of the theory over the bin, by Simpson's rule
                let at = |r: f64| theory[((r - 1.0) * 200.0).round() as usize];
                let exact = (at(r - 0.025) + 4.0 * at(*r) + at(r + 0.025)) / 6.0;
                largest = largest.max((value.value - exact).abs() - 4.0 * value.error.unwrap());
                // Percus-Yevick differs from simulations most near contact (Hansen and McDonald, figure 4.2)
                let allowed = if *r < 1.2 { near + contact * 0.06 * (phi / 0.3).powi(2) } else { near };
                agrees(&format!("{model:?} φ = {phi}: g({r})"), value, exact, allowed);
            }
        }
        println!("{model:?} φ = {phi}: largest difference from Percus-Yevick beyond four errors {largest}");
    }
}

/// State of `count` particles along the y axis, whose velocities the function `velocity` draws.
fn moving(experiment: &Experiment, count: usize, mut velocity: impl FnMut() -> Vector3<f64>) -> Particles {
    let size = experiment.scene.domain.size;
    let mut particles = Particles::default();
    for k in 0..count {
        let y = (k as f64 + 0.5) / count as f64 * size.y;
        particles.push(Vector3::new(0.0, y, 0.0), velocity(), 0.5, 1.0, 0);
    }
    particles
}

const SETTINGS: VelocityDistributionSettings = VelocityDistributionSettings { largest_speed: 4.0, bins: 40 };

#[test]
fn few_maxwellian_particles_are_maxwellian() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
    for (count, slices) in [(32, 1), (96, 3)] {
        let mut gas = gas(count, 0.1, 1.0, Model::Hard);
        gas.statistics.slices = slices;
        let mut draw = || Vector3::from_fn(|_, _| 2.5 * random.sample::<f64, _>(StandardNormal)) + Vector3::y() * 7.0;
        let states: Vec<Particles> = (0..3000).map(|_| moving(&gas, count, &mut draw)).collect();
        let measurement = VelocityDistribution::new(&gas, &Schedule::new(&gas), SETTINGS);
        let found = of_states(&gas, measurement, states);
        // without the correction for few particles a₂ would be -2/96 with an error of 0.0024
        agrees(&format!("a2 of {count}"), number(&found, "a2"), 0.0, 0.0);
        agrees(&format!("a3 of {count}"), number(&found, "a3"), 0.0, 0.0);
    }
}

#[test]
fn the_histogram_is_that_of_maxwell() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(8);
    let gas = gas(20_000, 0.1, 1.0, Model::Hard);
    let mut draw = || Vector3::from_fn(|_, _| random.sample(StandardNormal));
    let states: Vec<Particles> = (0..20).map(|_| moving(&gas, 20_000, &mut draw)).collect();
    let found = of_states(&gas, VelocityDistribution::new(&gas, &Schedule::new(&gas), SETTINGS), states);
    for of in &found.curves {
        let (_, theory) = of.theory.as_ref().unwrap();
        let mut sum = 0.0;
        for ((value, exact), c) in of.values.iter().zip(theory).zip(&found.places) {
            let Some(value) = value else { continue };
            sum += 0.1 * value.value;
            // the value at the middle of a bin of width 0.1 differs from the mean over the bin by (0.1)²/24 of the second
            // derivative, which is at most 5 for both; counts below ten have skew distributions
            if exact * 0.1 * 4e5 > 10.0 {
                agrees(&format!("{} at {c}", of.quantity.column), *value, *exact, 2.1e-3);
            }
        }
        // of a Maxwellian gas one particle in a million is faster than c = 4
        assert!((sum - 1.0).abs() < 1e-5, "{sum}");
    }
}

/// Velocities v at random in a ball of radius 1: <v²> = 3/5, <v⁴> = 3/7 and <v⁶> = 1/3. So the Sonine coefficients are
/// a₂ = -2/7 and a₃ = 1/7 - 25/63.
#[test]
fn coefficients_of_a_ball_of_velocities() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(9);
    let mut gas = gas(40_000, 0.1, 1.0, Model::Hard);
    gas.statistics.slices = 2;
    let mut draw = || Vector3::from(UnitBall.sample(&mut random)) * 3.0;
    let states: Vec<Particles> = (0..16).map(|_| moving(&gas, 40_000, &mut draw)).collect();
    let found = of_states(&gas, VelocityDistribution::new(&gas, &Schedule::new(&gas), SETTINGS), states);
    agrees("a2", number(&found, "a2"), -2.0 / 7.0, 0.0);
    agrees("a3", number(&found, "a3"), 1.0 / 7.0 - 25.0 / 63.0, 0.0);
}

#[test]
fn a_cooling_gas_has_the_coefficient_of_van_noije_and_ernst() {
    for (model, restitution, seeds) in [(Model::Hard, 0.8, 8), (Model::Dsmc, 0.8, 4), (Model::Dsmc, 0.5, 2)] {
        let runs: Vec<[Observation; 1]> = (0..seeds)
            .map(|seed| {
                // at first a sphere collides 4 √π n d² χ √T = 0.77 times a second, and later more seldom by Haff's law: 17
                // times in 40 s if e = 0.8. The box of 44 diameters is too small for vortices, which grow in boxes above 56
                // (Brito and Ernst 1998, Europhys. Lett. 43, 497). Collisions by chance in one cell cannot make any.
                let mut gas = gas(8000, 0.05, restitution, model);
                gas.run.seed = seed;
                gas.dsmc.cells = Some([1, 1, 1]);
                gas.run.duration = 40.0;
                gas.statistics.sample_interval = Some(0.5);
                [measured(&gas, 10.0, |gas, schedule| VelocityDistribution::new(gas, schedule, SETTINGS))]
            })
            .collect();
        let pooled = Observation::pool(&runs.iter().map(|run| run.as_slice()).collect::<Vec<_>>(), false);
        let (found, e) = (&pooled[0], restitution);
        let exact = 16.0 * (1.0 - e) * (1.0 - 2.0 * e * e) / (81.0 - 17.0 * e + 30.0 * e * e * (1.0 - e));
        assert_eq!(found.numbers[0].theory.unwrap().1, exact);
        // the theory is linear in a₂; next to a₂² its error is some 5 % for these e
        agrees(&format!("{model:?}, e = {e}: a2"), number(found, "a2"), exact, 0.05 * exact.abs());
    }
}

/// A measurement changes no bit of a run.
#[test]
fn measurements_change_nothing() {
    let mut gas = gas(100, 0.2, 0.9, Model::Hard);
    gas.run.duration = 1.0;
    let end = |gas: &Experiment| {
        let start = initial_state(gas).unwrap();
        let (outcome, end) = diptych::runs::execute(gas, start, &mut []);
        (outcome.observations, end.fingerprint(), outcome.series)
    };
    let (none, without, series) = end(&gas);
    assert!(none.is_empty() && series.rows.iter().all(|row| row.sonine.is_none()));
    gas.observe = ObserveSettings {
        seen_gas: false,
        pair_distribution: Some(PairDistributionSettings { reach: 2.0, bins: 10 }),
        velocity_distribution: Some(SETTINGS),
        diffusion: Some(DiffusionSettings { duration: 0.1 }),
        structure_factor: Some(StructureFactorSettings { wavelength: 1.0, bins: 5 }),
        contact_network: true,
        fields: Some(FieldsSettings { width: 1.0, cells: [2, 3, 4] }),
        viscosity: Some(ViscositySettings { duration: Some(0.1) }),
        clusters: Some(ClustersSettings { gap: 0.1 }),
        free_surface: Some(FreeSurfaceSettings { up: (1, 1.0), spacing: 0.5, smoothing: 0.0 }),
    };
    let (some, with, series) = end(&gas);
    assert_eq!(without, with);
    assert_eq!(some.iter().map(|observed| observed.name).collect::<Vec<_>>(), gas.observe.names());
    assert!(series.rows.iter().all(|row| row.sonine.is_some()));
}

/// N spheres in free flight through a periodic box. Their mean square displacement in the time t is t² <|v - v̄|²>
/// N/(N - 1), however often they leave the box (velocities v with the mean v̄).
#[test]
fn displacements_are_unwrapped() {
    let mut gas = gas(3, 0.001, 1.0, Model::Hard);
    let edge = 10.0;
    gas.scene.domain = Domain::new(Vector3::repeat(edge), [true; 3]);
    // three lanes, so that nobody meets; an edge is crossed every 2.5 s
    let lanes =
        [([1.0, 1.0, 1.0], 4.0), ([4.0, 4.0, 4.0], -3.0), ([7.0, 7.0, 9.0], 2.0)].map(|(x, v)| (x, [0.0, 0.0, v]));
    gas.start[0].amount = diptych::experiment::Amount::Placed(crate::support::placed(&gas.scene, &lanes));
    (gas.run.duration, gas.statistics.sample_interval) = (100.0, Some(0.5));
    let settings = DiffusionSettings { duration: 10.0 };
    let found = measured(&gas, 0.0, |gas, schedule| Diffusion::new(gas, schedule, settings));
    let variance = (9.0_f64 + 16.0 + 1.0) / 2.0;
    for (k, t) in found.places.iter().enumerate() {
        let (moved, correlation) =
            (curve(&found, "displacement_m2")[k].unwrap(), curve(&found, "correlation_m2_s2")[k].unwrap());
        // rounding of twenty displacements of a box of 10 m
        assert!((moved.value - variance * t * t).abs() < 1e-10 * (1.0 + t * t) * variance, "{t}: {moved:?}");
        assert!((correlation.value - variance / 3.0).abs() < 1e-12 * variance, "{t}: {correlation:?}");
    }
    // at 4 m/s a sample every 2.5 s would lose a whole edge
    gas.statistics.sample_interval = Some(1.0);
    let found = measured(&gas, 0.0, |gas, schedule| Diffusion::new(gas, schedule, settings));
    assert!(found.remark.is_some() && found.numbers.iter().all(|number| number.value.is_none()));
}

#[test]
fn diffusion_is_that_of_hard_spheres() {
    for (model, phi, longest, blocks) in [
        (Model::Hard, 0.1, 8.0, 40.0),
        (Model::Hard, 0.2, 4.0, 40.0),
        (Model::Hard, 0.3, 2.4, 40.0),
        (Model::Dsmc, 0.05, 12.0, 40.0),
    ] {
        let mut gas = gas(1000, phi, 1.0, model);
        gas.run.duration = longest * blocks;
        gas.statistics.sample_interval = Some(longest / 80.0);
        let settings = DiffusionSettings { duration: longest };
        let found = measured(&gas, longest, |gas, schedule| Diffusion::new(gas, schedule, settings));
        let density = 6.0 * phi / PI;
        let contact = (1.0 - 0.5 * phi) / (1.0 - phi).powi(3);
        let dilute = 3.0 / (8.0 * density * PI.sqrt());
        let (_, enskog) = found.numbers[0].theory.unwrap();
        // T of a finite number of spheres is that of the start, 1 m²/s²
        assert!((enskog - dilute / contact).abs() < 0.01 * enskog, "{enskog} {}", dilute / contact);
        let (einstein, green_kubo) = (number(&found, "D_einstein_m2_s"), number(&found, "D_green_kubo_m2_s"));
        println!("D over Enskog's: {} and {}", einstein.value / enskog, green_kubo.value / enskog);
        if model == Model::Dsmc {
            // pairs by chance have no memory: D is that of Boltzmann's equation, 1.019 of the first approximation (Chapman and
            // Cowling); the splitting of flight and collisions in steps of 0.2 mean free times changes it by less than 1 %
            agrees("dsmc, Einstein", einstein, 1.019 * enskog, 0.01 * enskog);
            agrees("dsmc, Green-Kubo", green_kubo, 1.019 * enskog, 0.01 * enskog);
        } else {
            // fit to molecular dynamics (Speedy 1987, Mol. Phys. 62, 509); correlations beyond the longest time, and those
            // of a box of 12 to 17 diameters, are missing: 2/(3n) (4π(D + ν)t)^(-3/2) beyond t is up to 3 % of D
            let n = density;
            let exact = dilute * (1.0 - n / 1.09) * (1.0 + n * n * (0.4 - 0.83 * n * n));
            agrees(&format!("hard, φ = {phi}, Einstein"), einstein, exact * 0.985, 0.02 * exact);
            agrees(&format!("hard, φ = {phi}, Green-Kubo"), green_kubo, exact * 0.985, 0.02 * exact);
        }
    }
}

#[test]
fn replicas_are_pooled_by_their_errors_or_by_their_scatter() {
    let run = |value: f64| {
        let quantity = ObservedQuantity::new("number", "n", "");
        let number = ObservedNumber { quantity, value: Some(Estimate::new(value, 0.1)), theory: None, batches: None };
        [Observation { name: "made up", numbers: vec![number], ..Observation::default() }]
    };
    let runs = [run(1.0), run(2.0), run(6.0)];
    let runs: Vec<&[Observation]> = runs.iter().map(|run| run.as_slice()).collect();
    // the mean of 1, 2 and 6 is 3, and their variance is 7
    for (by_runs, error) in [(false, 0.1 / 3.0_f64.sqrt()), (true, (7.0_f64 / 3.0).sqrt())] {
        let found = Observation::pool(&runs, by_runs)[0].numbers[0].value.unwrap();
        assert!((found.value - 3.0).abs() < 1e-12 && (found.error.unwrap() - error).abs() < 1e-12, "{found:?}");
    }
}
