//! Clusters (groups of particles connected by small gaps): states made by hand, random points against the closed forms
//! of an ideal gas, and messages.

use crate::measurements::{agrees, curve, gas, number, of_states, points};
use crate::support::{case, placed};
use diptych::Vector3;
use diptych::domain::Domain;
use diptych::experiment::{ClustersSettings, Experiment, Model};
use diptych::observe::{Observation, ParticleClusters};
use diptych::particles::Particles;
use diptych::schedule::Schedule;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::PI;

fn clusters(experiment: &Experiment, gap: f64, states: impl IntoIterator<Item = Particles>) -> Observation {
    let measurement = ParticleClusters::new(&Schedule::new(experiment), ClustersSettings { gap });
    of_states(experiment, measurement, states)
}

/// Shares of the particles in clusters of 1, 2 and so on particles. Then the number of clusters, the size of the
/// largest one, and the mean size of a cluster and of the cluster of a particle.
fn parts(found: &Observation) -> (Vec<f64>, [f64; 4]) {
    let shares = curve(found, "share").iter().map(|share| share.unwrap().value).collect();
    let numbers = ["clusters", "largest", "mean_size", "mean_size_of_a_particle"];
    (shares, numbers.map(|name| number(found, name).value))
}

/// Periodic cube with edges of 10 m and spheres of diameter 1 m: a row of three across a side, a pair with a gap of
/// 0.146 m, and a single sphere.
fn by_hand() -> (Experiment, Particles) {
    let mut gas = gas(6, 0.01, 1.0, Model::Hard);
    gas.scene.domain = Domain::new(Vector3::repeat(10.0), [true; 3]);
    let at = |x: f64, y: f64, z: f64| ([x, y, z], [0.0; 3]);
    let list = [
        at(9.4, 5.0, 5.0),
        at(0.45, 5.0, 5.0),
        at(1.4, 5.0, 5.45),
        at(5.0, 5.0, 9.9),
        at(5.0, 6.0, 0.46),
        at(5.0, 2.0, 5.0),
    ];
    let state = placed(&gas.scene, &list);
    (gas, state)
}

#[test]
fn groups_are_connected_by_gaps_below_the_given_one() {
    let (gas, state) = by_hand();
    // gaps: 0.05 and 0.0512 in the row, sqrt(1 + 0.56²) - 1 = 0.146 of the pair
    for (gap, shares, numbers) in [
        (0.04, [1.0, 0.0, 0.0], [6.0, 1.0, 1.0, 1.0]),
        (0.0505, [4.0 / 6.0, 2.0 / 6.0, 0.0], [5.0, 2.0, 1.2, 8.0 / 6.0]),
        (0.06, [0.5, 0.0, 0.5], [4.0, 3.0, 1.5, 2.0]),
        (0.15, [1.0 / 6.0, 2.0 / 6.0, 0.5], [3.0, 3.0, 2.0, 14.0 / 6.0]),
    ] {
        let (found, all) = parts(&clusters(&gas, gap, [state.clone()]));
        for (found, exact) in found.iter().zip(shares).chain(all.iter().zip(numbers)) {
            assert!((found - exact).abs() < 1e-14, "{gap}: {found} {exact}");
        }
        assert_eq!(found.iter().sum::<f64>(), 1.0);
    }
    // a wide sphere, 3 below one of the row, has the gap 3 - 0.5 - 2.46 = 0.04 to it, and none as small to others
    let (mut wide, mut gas) = (state, gas);
    (wide.radius[5], wide.position[5]) = (2.46, Vector3::new(0.45, 2.0, 5.0));
    gas.scene.species[0].diameter = 4.92;
    let (_, [count, largest, ..]) = parts(&clusters(&gas, 0.041, [wide]));
    assert_eq!([count, largest], [5.0, 2.0]);
}

/// Random spheres of ten sizes, from 0.1 to 1 m in diameter. The number of clusters agrees with a test of all pairs,
/// in which each sphere meets the nearest image of the other.
#[test]
fn spheres_of_very_different_sizes_connect() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
    const COUNT: usize = 400;
    let mut gas = gas(COUNT, 0.1, 1.0, Model::Hard);
    let mut state = points(&gas, COUNT, &mut random);
    gas.scene.domain = Domain::new(Vector3::repeat(6.0), [true; 3]);
    for place in 0..COUNT {
        state.position[place] = gas.scene.domain.wrap(&state.position[place]);
        state.radius[place] = 0.05 * (1 + place % 10) as f64;
    }
    let mut group: Vec<usize> = (0..COUNT).collect();
    for one in 0..COUNT {
        for other in 0..one {
            let apart = gas.scene.domain.separation(&state.position[one], &state.position[other]).norm();
            if apart < state.radius[one] + state.radius[other] + 0.02 {
                let (from, to) = (group[one], group[other]);
                group.iter_mut().filter(|of| **of == from).for_each(|of| *of = to);
            }
        }
    }
    group.sort_unstable();
    group.dedup();
    assert!(group.len() > 50 && group.len() < COUNT - 50, "{}", group.len());
    let (_, [count, ..]) = parts(&clusters(&gas, 0.02, [state]));
    assert_eq!(count, group.len() as f64);
}

#[test]
fn images_that_slide_connect() {
    let (mut gas, _) = by_hand();
    // the image of the upper sphere is displaced by 3.7 along z
    gas.scene.domain = gas.scene.domain.sheared(1.0, 3.7);
    let pair = |z: f64| placed(&gas.scene, &[([5.0, 0.5, 5.0], [0.0; 3]), ([5.0, 9.5, z], [0.0; 3])]);
    for (z, count) in [(8.7, 1.0), (5.0, 2.0), (1.3, 2.0)] {
        let (_, [found, ..]) = parts(&clusters(&gas, 0.01, [pair(z)]));
        assert_eq!(found, count, "{z}");
    }
}

/// The distribution of cluster sizes ends at 50 particles. A larger cluster counts in its last entry.
#[test]
fn large_groups_are_in_the_last_size() {
    let mut gas = gas(60, 0.01, 1.0, Model::Hard);
    gas.scene.domain = Domain::new(Vector3::new(100.0, 10.0, 10.0), [true; 3]);
    let row: Vec<_> = (0..60).map(|k| ([1.0 + 1.01 * f64::from(k), 5.0, 5.0], [0.0; 3])).collect();
    let (shares, numbers) = parts(&clusters(&gas, 0.02, [placed(&gas.scene, &row)]));
    assert_eq!((shares.len(), shares[49]), (50, 1.0));
    assert_eq!(numbers, [1.0, 60.0, 60.0, 60.0]);
}

/// [m³] volume of the union of two balls of radius r at the distance x < 2 r.
fn union(r: f64, x: f64) -> f64 {
    2.0 * 4.0 / 3.0 * PI * r.powi(3) - PI * (2.0 * r - x).powi(2) * (x * x + 4.0 * x * r) / (12.0 * x)
}

/// Random points: a point is alone if the other N - 1 points are outside the ball around it. It is in a pair if the
/// other N - 2 points are outside the balls around both.
#[test]
fn random_points_are_alone_or_in_pairs_as_in_an_ideal_gas() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(12);
    const COUNT: usize = 300;
    let gas = gas(COUNT, 0.1, 1.0, Model::Hard);
    let (volume, reach) = (gas.scene.domain.volume(), 1.1);
    let states: Vec<Particles> = (0..300).map(|_| points(&gas, COUNT, &mut random)).collect();
    let found = clusters(&gas, reach - 1.0, states);
    let others = COUNT as f64 - 1.0;
    let alone = (1.0 - 4.0 / 3.0 * PI * reach.powi(3) / volume).powf(others);
    // ∫ (N - 1)/V (1 - V_union/V)^(N-2) 4π x² dx by the midpoint rule, whose error is 1e-6
    let step = reach / 1000.0;
    let pair = |k: i32| {
        let x = (f64::from(k) + 0.5) * step;
        4.0 * PI * x * x * step * others / volume * (1.0 - union(reach, x) / volume).powf(others - 1.0)
    };
    let paired: f64 = (0..1000).map(pair).sum();
    assert!(alone > 0.2 && paired > 0.1, "{alone} {paired}");
    agrees("alone", curve(&found, "share")[0].unwrap(), alone, 0.0);
    agrees("in pairs", curve(&found, "share")[1].unwrap(), paired, 0.0);
    assert!(curve(&found, "share")[0].unwrap().error.unwrap() < 0.01);
}

/// Balls of diameter d around random points of number density n percolate at n π d³/6 = 0.3419 (Lorenz and Ziff 2001,
/// J. Chem. Phys. 114, 3659). At lower densities, the largest cluster has a small share of the points; at higher
/// densities, it has most of them.
#[test]
fn the_largest_cluster_grows_at_the_percolation_of_balls() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(13);
    const COUNT: usize = 8000;
    let gas = gas(COUNT, 0.1, 1.0, Model::Hard);
    let share = |filled: f64, random: &mut Xoshiro256PlusPlus| {
        let reach = (6.0 * filled / PI * gas.scene.domain.volume() / COUNT as f64).cbrt();
        let states: Vec<Particles> = (0..8).map(|_| points(&gas, COUNT, random)).collect();
        number(&clusters(&gas, reach - 1.0, states), "largest").value / COUNT as f64
    };
    // at the threshold the largest cluster is a share L^(-β/ν) = L^(-0.48) of some tenths in a box of 20 distances; the
    // width of the transition is L^(-1/ν) = L^(-1.14), 4 % of the threshold
    let (below, above) = (share(0.80 * 0.3419, &mut random), share(1.20 * 0.3419, &mut random));
    assert!(below < 0.1 && above > 0.5, "{below} {above}");
}

const CASE: &str = "[domain]\nsize = [\"10 mm\", \"10 mm\", \"10 mm\"]\nperiodic = [\"x\"]\n[[particles]]\ndiameter = \"1 mm\"\n\
                    density = \"2500 kg/m^3\"\ncount = 10\n[contact]\nrestitution = 1.0\n[run]\nduration = \"1 s\"\n\
                    [observe.clusters]\n";

#[test]
fn cases_ask_for_clusters() {
    let with = |gap: &str| case(&format!("{CASE}{gap}"), Model::Hard, &[]);
    assert_eq!(with("gap = \"50 um\"").unwrap().observe.clusters, Some(ClustersSettings { gap: 50e-6 }));
    for (gap, words) in
        [("", "observe.clusters.gap"), ("gap = \"4.1 mm\"", "4.0000e-3 m"), ("gap = \"-1 um\"", "0 ..= 1e4 m")]
    {
        let why = with(gap).unwrap_err();
        assert!(why.contains(words), "{why}");
    }
}
