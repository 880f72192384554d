//! Gases of rough spheres: temperatures of translation and rotation against direct simulation Monte Carlo (section RF
//! of the catalogue of reference values), and reversed motion.

use super::*;
use diptych::experiment::{SoftSettings, Spheres, TimeStep};
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

/// Gas of the reference: restitution, tangential restitution, friction, ratio T_r/T (rotational over granular
/// temperature) at the start, and T and T_r at times τ. The time τ is the number of collisions per sphere.
struct Cooling {
    restitution: f64,
    tangential_restitution: f64,
    friction: f64,
    rotates: f64,
    /// Time τ [collisions per sphere], then granular temperature T and rotational temperature T_r, both divided by the
    /// initial T. The reference computed them by direct simulation Monte Carlo.
    expected: &'static [(f64, [f64; 2])],
}

const NO_LIMIT: f64 = 1e9;

const GASES: [Cooling; 5] = [
    Cooling {
        restitution: 0.9,
        tangential_restitution: 0.4,
        friction: NO_LIMIT,
        rotates: 1.0,
        expected: &[(1.0, [0.86357, 0.81901]), (5.0, [0.45934, 0.38795]), (20.0, [0.03661, 0.02898])],
    },
    Cooling {
        restitution: 0.95,
        tangential_restitution: -0.5,
        friction: NO_LIMIT,
        rotates: 1.0,
        expected: &[(1.0, [0.90068, 0.83565]), (5.0, [0.58655, 0.41390]), (20.0, [0.10864, 0.03715])],
    },
    Cooling {
        restitution: 0.97,
        tangential_restitution: 0.44,
        friction: 0.092,
        rotates: 1.0,
        expected: &[(1.0, [0.94174, 0.90436]), (5.0, [0.73439, 0.60273]), (20.0, [0.26167, 0.12941])],
    },
    Cooling {
        restitution: 0.9,
        tangential_restitution: 0.4,
        friction: 0.3,
        rotates: 1.0,
        expected: &[(1.0, [0.87081, 0.83065]), (5.0, [0.48900, 0.40292]), (20.0, [0.04778, 0.03193])],
    },
    // elastic and perfectly rough spheres: equipartition
    Cooling {
        restitution: 1.0,
        tangential_restitution: 1.0,
        friction: NO_LIMIT,
        rotates: 0.0,
        expected: &[(1.0, [0.78772, 0.21217]), (5.0, [0.53429, 0.46571]), (20.0, [0.50125, 0.49875])],
    },
];

/// `SPHERES` is the number of spheres of a run, `STARTS` the number of starts over which the mean is taken.
const SPHERES: usize = 2000;
const STARTS: u64 = 8;

/// Vector of three independent normal numbers with variance 1.
fn normal(random: &mut Xoshiro256PlusPlus) -> Vector3<f64> {
    Vector3::from_fn(|_, _| random.sample(StandardNormal))
}

impl Cooling {
    /// Granular temperature T and rotational temperature T_r at each time τ (collisions per sphere) by direct
    /// simulation Monte Carlo (Bird 1994, Molecular Gas Dynamics). The spheres have unit mass and radius. Random pairs
    /// have a random normal, are accepted in proportion to their normal speed, and collide by Walton's rule. For
    /// smooth spheres (β_0 = -1, e = 0.9), T at τ = 20 is 0.2830 ± 0.0002; Haff's law with the Sonine coefficient
    /// -0.0146 gives 0.2831.
    fn dsmc(&self, count: usize, seed: u64) -> Vec<[f64; 2]> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let inertia: f64 = 0.4;
        let temperature = |vectors: &[Vector3<f64>]| {
            vectors.iter().map(Vector3::norm_squared).sum::<f64>() / (3 * vectors.len()) as f64
        };
        // exactly T = 1 and the wanted T_r at the start, so that the random start adds no error
        let mut start = |wanted: f64| {
            let drawn: Vec<_> = (0..count).map(|_| normal(&mut random)).collect();
            let scale = (wanted / temperature(&drawn)).sqrt();
            drawn.into_iter().map(|vector| vector * scale).collect::<Vec<Vector3<f64>>>()
        };
        let (mut velocity, mut spin) = (start(1.0), start(self.rotates / inertia));
        let (mut collisions, mut fastest) = (0, 0.0);
        let mut result = Vec::new();
        for (tau, _) in self.expected {
            while (collisions as f64) < 0.5 * tau * count as f64 {
                if collisions % (count / 4) == 0 {
                    // in a gas at T, relative speeds are below 7.8 sqrt(T), except for a fraction of 1e-6
                    fastest = 7.8 * temperature(&velocity).sqrt();
                }
                let [p, q] = [0, 1].map(|_| random.random_range(0..count));
                let direction = normal(&mut random).normalize();
                let relative = velocity[p] - velocity[q];
                let approach = -relative.dot(&direction);
                if p == q || approach <= random.random::<f64>() * fastest {
                    continue;
                }
                let slip = relative + direction * approach - (spin[p] + spin[q]).cross(&direction);
                // the effective mass is 1/2, that of the slip is (2/7)/2
                let along = (1.0 + self.restitution) * 0.5 * approach;
                let sticks = 1.0 / 7.0 * (1.0 + self.tangential_restitution);
                let friction = slip * sticks.min(self.friction * along / slip.norm());
                let impulse = direction * along - friction;
                velocity[p] += impulse;
                velocity[q] -= impulse;
                let turn = direction.cross(&friction) / inertia;
                spin[p] += turn;
                spin[q] += turn;
                collisions += 1;
            }
            result.push([temperature(&velocity), inertia * temperature(&spin)]);
        }
        result
    }
}

/// Mean of several runs and its relative standard error, for the two temperatures (granular, rotational) at each time.
fn mean(runs: &[Vec<[f64; 2]>]) -> Vec<[(f64, f64); 2]> {
    let count = runs.len() as f64;
    let of = |k: usize, which: usize| {
        let values = runs.iter().map(|run| run[k][which]);
        let mean = values.clone().sum::<f64>() / count;
        let variance = values.map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
        (mean, (variance / count).sqrt() / mean)
    };
    (0..runs[0].len()).map(|k| [of(k, 0), of(k, 1)]).collect()
}

impl Cooling {
    /// Granular and rotational temperature in a run with the seed `seed` at each time τ (collisions per sphere) up to
    /// `until`, divided by the initial mean energy per degree of freedom.
    fn temperatures(&self, model: Model, until: f64, seed: u64) -> Vec<[f64; 2]> {
        let tangential_restitution = self.tangential_restitution;
        let tangential = TangentialLaw::Linear(LinearTangential::Restitution(tangential_restitution));
        let rotation = Rotation::new(tangential, ImpactRule::Walton { tangential_restitution });
        let mut gas = rough_gas(model, rotation, (self.restitution, self.friction), 0.01, SPHERES);
        gas.start[0].spin_fluctuation *= self.rotates;
        gas.run.seed = 100 + seed;
        gas.soft = SoftSettings {
            law: Some(ContactLaw::linear(1e5)),
            time_step: TimeStep::PerContact(50.0),
            stepping: SoftStepping::Local,
            ..gas.soft
        };
        gas.run.spheres = match model {
            Model::Soft => Spheres::Soft(ContactLaw::linear(1e5)),
            Model::Dsmc => Spheres::Dsmc,
            Model::Hard | Model::Hybrid => Spheres::Hard,
        };
        let mut simulation = Simulation::new(&gas, initial_state(&gas).unwrap());
        let temperatures = |simulation: &Simulation| {
            let particles = &simulation.particles;
            let mass = particles.total_mass();
            // the motion of the centre of mass does not cool, and is left out
            let together = 0.5 * particles.momentum().norm_squared() / mass;
            [particles.kinetic_energy() - together, particles.rotational_energy()].map(|e| 2.0 * e / (3.0 * mass))
        };
        let start = temperatures(&simulation);
        let unit = (start[0] + start[1]) / (1.0 + self.rotates);
        // collisions per sphere and temperatures, at the beginning and at the end of the last window
        let mut last = (0.0, start);
        let mut next = last;
        let reached = self.expected.iter().filter(|(tau, _)| *tau <= until).map(|(tau, _)| {
            while next.0 < *tau {
                // duration of a fifth of a mean free time, 1/(12/sqrt(π) φ g(d) sqrt(T)/d)
                simulation.run(1, 0.2 * 1e-3 / (0.0694 * next.1[0].sqrt())).unwrap();
                last = next;
                next = (2.0 * simulation.record.pairs.count as f64 / SPHERES as f64, temperatures(&simulation));
            }
            let share = (tau - last.0) / (next.0 - last.0);
            [0, 1].map(|k| (last.1[k] + share * (next.1[k] - last.1[k])) / unit)
        });
        reached.collect()
    }

    /// Compares the means over the starts with our Monte Carlo simulation (`dsmc`) up to a time τ [collisions per
    /// sphere], and this simulation with the reference. The reference is ahead of our Monte Carlo simulation by about
    /// 1 % of τ, so that its gases are colder by 2 % at τ = 20. Eight runs of this program with 20,000 spheres agree
    /// with our simulation within 0.3 % (docs/rotation.md).
    fn compare(&self, model: Model, until: f64) {
        let monte_carlo: Vec<_> = (0..4).into_par_iter().map(|seed| self.dsmc(16_000, seed)).collect();
        let starts: Vec<_> = (0..STARTS).into_par_iter().map(|seed| self.temperatures(model, until, seed)).collect();
        for (k, (found, dsmc)) in mean(&starts).into_iter().zip(mean(&monte_carlo)).enumerate() {
            let (tau, expected) = self.expected[k];
            for which in 0..2 {
                let ((value, error), (reference, of_reference)) = (found[which], dsmc[which]);
                let off = value / reference - 1.0;
                let Self { restitution, tangential_restitution, friction, .. } = self;
                let words = format!(
                    "{model:?}, e {restitution}, β_0 {tangential_restitution}, μ {friction}, τ {tau}: {} {value:.5} ± {:.2} %, DSMC \
                     {reference:.5} ± {:.2} % ({:+.2} %)",
                    ["T", "T_r"][which],
                    100.0 * error,
                    100.0 * of_reference,
                    100.0 * off
                );
                println!("{words}");
                assert!((reference / expected[which] - 1.0).abs() < 0.025, "{words}, {expected:?}");
                // more than three standard errors, plus 0.5 % for finite numbers of spheres and correlations of
                // velocities
                let error = error.hypot(of_reference);
                assert!(error < 0.02 && off.abs() < 3.5 * error + 5e-3, "{words}");
            }
        }
    }
}

#[test]
fn hard_rough_gases_cool_as_the_reference() {
    GASES.iter().for_each(|gas| gas.compare(Model::Hard, 20.0));
}

#[test]
fn rough_gases_that_collide_by_chance_cool_as_the_reference() {
    GASES.iter().for_each(|gas| gas.compare(Model::Dsmc, 20.0));
}

#[test]
fn soft_rough_gases_cool_as_the_reference() {
    // gases with a limit of friction, or elastic ones. Without a limit, the attractive dashpot force at the end of an
    // impact leaves a stretched spring, and Walton's β_0 is not that of the spring (docs/rotation.md)
    GASES
        .iter()
        .filter(|gas| gas.friction < NO_LIMIT || gas.restitution == 1.0)
        .for_each(|gas| gas.compare(Model::Soft, 5.0));
}

/// Elastic spheres that are perfectly smooth (β_0 = -1) or rough (β_0 = 1) return to their start when all velocities
/// and spins are reversed. Errors grow about tenfold per collision of a sphere, and each sphere has about three
/// collisions.
#[test]
fn elastic_rough_spheres_go_back() {
    for tangential_restitution in [-1.0, 1.0] {
        let rule = ImpactRule::Walton { tangential_restitution };
        let gas = rough_gas(Model::Hard, Rotation::new(TangentialLaw::Coulomb, rule), (1.0, NO_LIMIT), 0.05, 200);
        for engine in [hard as fn() -> Box<dyn Engine>, islands] {
            let start = initial_state(&gas).unwrap();
            let mut simulation = Simulation::with_engine(gas.scene.clone(), start.clone(), engine());
            simulation.run(10, 4e-4).unwrap();
            let forward = simulation.record.pairs.count;
            assert!((200..1000).contains(&forward), "{forward}");
            let mut back = simulation.state();
            back.velocity.iter_mut().for_each(|v| *v = -*v);
            back.spin.as_mut().unwrap().iter_mut().for_each(|w| *w = -*w);
            let mut simulation = Simulation::with_engine(gas.scene.clone(), back, engine());
            simulation.run(10, 4e-4).unwrap();
            assert_eq!(simulation.record.pairs.count, forward);
            let particles = simulation.state();
            for k in 0..start.len() {
                let apart = gas.scene.domain.separation(
                    &gas.scene.domain.wrap(&start.position[k]),
                    &gas.scene.domain.wrap(&particles.position[k]),
                );
                let speeds = (particles.velocity[k] + start.velocity[k]).norm();
                let spins = (particles.spin_of(k) + start.spin_of(k)).norm() * 0.5e-3;
                assert!(
                    apart.norm() < 1e-11 && speeds < 1e-8 && spins < 1e-8,
                    "β_0 {tangential_restitution}: {k} misses its start by {:.1e} m, {speeds:.1e} and {spins:.1e} m/s",
                    apart.norm()
                );
            }
        }
    }
}
