//! Mixtures: spheres of very different sizes.

use crate::support::*;
use diptych::case::Case;
use diptych::experiment::{Experiment, Model};
use diptych::neighbours::NeighbourList;
use diptych::placement::initial_state;
use std::path::Path;
use std::sync::Arc;

fn case(text: &str, model: Model, sets: &[&str]) -> Result<Experiment, String> {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).collect();
    let path = Path::new("tests/mixture.toml");
    let case = Case::from_text(path, Arc::from(text), &sets).map_err(|why| why.to_string())?;
    case.experiment(Some(model), None).map(|(experiment, _)| experiment).map_err(|why| why.to_string())
}

/// A periodic box in which spheres of one and of a tenth of the size fill 0.15 each.
const TEN_TO_ONE: &str = r#"
[domain]
size = ["12 mm", "10 mm", "9 mm"]
periodic = ["x", "y", "z"]

[[particles]]
name = "small"
diameter = "0.4 mm"
density = "1000 kg/m^3"
volume_fraction = 0.15
velocity_fluctuation = "0.5 m/s"

[[particles]]
name = "large"
diameter = "4 mm"
density = "1000 kg/m^3"
volume_fraction = 0.15

[contact]
restitution = 1.0

[run]
model = "hard"
duration = "1 ms"
"#;

/// Small spheres within large ones, and large ones that come last, are what a start must cope with: before each size had its own cells and the
/// smaller sphere gave way, this took minutes.
#[test]
fn ten_to_one_starts_without_overlap() {
    for share in ["0.15", "0.08"] {
        // pushed apart, and inserted
        let sets = [format!("particles[0].volume_fraction={share}"), format!("particles[1].volume_fraction={share}")];
        let experiment = case(TEN_TO_ONE, Model::Hard, &[&sets[0], &sets[1]]).unwrap();
        let start = initial_state(&experiment).unwrap();
        assert!(smallest_gap(&experiment.scene, &start) > 0.0, "{share}");
        // whoever starts keeps its kind
        let large = start.radius.iter().zip(&start.species).filter(|(r, species)| (**r == 2e-3) != (**species == 1));
        assert_eq!(large.count(), 0);
    }
}

/// Every pair nearer than the skin is listed once, whatever the sizes; periodic sides and open ones.
#[test]
fn lists_of_very_different_sizes_hold_every_pair_once() {
    for (periodic, seed) in [([true; 3], 1), ([false, true, false], 2)] {
        let species = small();
        let scene = empty([6e-3, 5e-3, 7e-3], periodic, species, surface(1.0, 0.0));
        let mut particles = random(&scene, 400, 0.1, seed);
        // radii from 1 to 60, every size in between: seven levels
        for (k, r) in particles.radius.iter_mut().enumerate() {
            *r = 1e-3 * 60f64.powf(-(k as f64 / 399.0).sqrt());
        }
        let mut list = NeighbourList::default();
        list.build(&mut particles, &scene, 1e-3);
        let near = |i: usize, j: usize| {
            let apart = scene.domain.separation(&particles.position[i], &particles.position[j]).norm();
            apart < particles.radius[i] + particles.radius[j] + list.skin()
        };
        let (mut want, count) = (Vec::new(), particles.len());
        for i in 0..count {
            want.extend((i + 1..count).filter(|&j| near(i, j)).map(|j| (i as u32, j as u32)));
        }
        let mut found: Vec<(u32, u32)> = list.pairs.iter().map(|p| (p.i.min(p.j), p.i.max(p.j))).collect();
        assert!(list.pairs.is_sorted_by_key(|pair| pair.i), "grouped by the first");
        found.sort_unstable();
        assert!(want.len() > 1000);
        assert_eq!(found, want);
    }
}
