//! Species with a distribution of diameters.

use crate::support::*;
use diptych::contact_law::Bodies;
use diptych::experiment::Model;
use diptych::placement::initial_state;
use diptych::scene::{Fraction, SizeDistribution, Species};
use diptych::simulation::Simulation;

/// Case of a gas of one species in a periodic box.
const GAS: &str = r#"
[domain]
size = ["4 mm", "4 mm", "4 mm"]
periodic = ["x", "y", "z"]

[[particles]]
name = "sand"
density = "2500 kg/m^3"
count = 200
velocity_fluctuation = "0.5 m/s"
sizes = { log_normal = { median = "0.2 mm", geometric_deviation = 1.5, from = "0.1 mm", to = "0.6 mm" } }

[contact]
restitution = 1.0

[soft.linear_spring_dashpot]
stiffness = "20 kN/m"

[run]
model = "hard"
duration = "4 ms"
"#;

fn log_normal() -> SizeDistribution {
    SizeDistribution::LogNormal { median: 4e-4, geometric_deviation: 1.6, from: 1.5e-4, to: 1.2e-3 }
}

/// Mean of the diameter to the power k, by Simpson's rule over the logarithm of the diameter, which is normally
/// distributed between two limits.
fn by_quadrature(k: i32) -> f64 {
    const STRIPS: usize = 2000;
    let (low, high, width) = (1.5e-4_f64.ln(), 1.2e-3_f64.ln(), 1.6_f64.ln());
    let (mut sum, mut norm) = (0.0, 0.0);
    for i in 0..=STRIPS {
        let weight = if i == 0 || i == STRIPS { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
        let x = low + (high - low) * i as f64 / STRIPS as f64;
        let density = weight * (-0.5 * ((x - 4e-4_f64.ln()) / width).powi(2)).exp();
        norm += density;
        sum += density * (f64::from(k) * x).exp();
    }
    sum / norm
}

#[test]
fn moments_are_those_of_the_closed_forms() {
    let uniform = SizeDistribution::Uniform { from: 1e-4, to: 5e-4 };
    let (one, two) = (Fraction { diameter: 1e-4, share: 0.75 }, Fraction { diameter: 3e-4, share: 0.25 });
    let table = SizeDistribution::Table(vec![one, two]);
    for k in 1..=6 {
        close("log-normal", log_normal().mean_power(k) / by_quadrature(k), 1.0, 1e-9);
        let n = f64::from(k + 1);
        let exact = (5e-4_f64.powf(n) - 1e-4_f64.powf(n)) / (n * 4e-4);
        close("uniform", uniform.mean_power(k) / exact, 1.0, 1e-12);
        let exact = 0.75 * 1e-4_f64.powi(k) + 0.25 * 3e-4_f64.powi(k);
        close("table", table.mean_power(k) / exact, 1.0, 1e-12);
    }
}

/// With many spheres the moments are those of the distribution, for every seed. With few spheres they are as close as
/// possible.
#[test]
fn starts_have_the_distribution_asked_for() {
    let of = |sizes: &str, count: usize, seed: u64| {
        let text = GAS.replace(
            r#"sizes = { log_normal = { median = "0.2 mm", geometric_deviation = 1.5, from = "0.1 mm", to = "0.6 mm" } }"#,
            sizes,
        );
        assert_ne!(text, GAS);
        let count = format!("particles[0].count={count}");
        let seed = format!("run.seed={seed}");
        let size = "domain.size=[\"40 mm\", \"40 mm\", \"40 mm\"]";
        let experiment = case(&text, Model::Hard, &[&count, &seed, size]).unwrap();
        let start = initial_state(&experiment).unwrap();
        (experiment, start)
    };
    let log = r#"sizes.log_normal = { median = "0.4 mm", geometric_deviation = 1.6, from = "0.15 mm", to = "1.2 mm" }"#;
    let flat = r#"sizes.uniform = { from = "0.1 mm", to = "0.5 mm" }"#;
    let table = r#"sizes.table = { diameters = ["0.3 mm", "0.1 mm"], fractions = [2.0, 6.0] }"#;
    let sieves = r#"sizes.table = { diameters = ["0.3 mm", "0.1 mm"], fractions = [9, 1], by = "volume" }"#;
    for (sizes, count, tolerance) in
        [(log, 4000, 1e-3), (flat, 4000, 1e-3), (table, 4000, 1e-3), (sieves, 4000, 1e-3), (log, 40, 0.1)]
    {
        for seed in [1, 2] {
            let (experiment, start) = of(sizes, count, seed);
            let species = &experiment.scene.species[0];
            let sizes = species.sizes.as_ref().unwrap();
            for k in 1..=4 {
                let mean = start.radius.iter().map(|r| (2.0 * r).powi(k)).sum::<f64>() / count as f64;
                close("moment", mean / sizes.mean_power(k), 1.0, f64::from(k) * tolerance);
            }
            close("mean mass", start.mass.iter().sum::<f64>() / count as f64 / species.mass(), 1.0, 3.0 * tolerance);
            let inside = |d: f64| d >= sizes.smallest() * (1.0 - 1e-12) && d <= sizes.largest() * (1.0 + 1e-12);
            assert!(start.radius.iter().all(|r| inside(2.0 * r)));
            // large spheres are found throughout the store, not only at its beginning
            let half = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
            let (first, last) = start.radius.split_at(count / 2);
            close("order", half(first) / half(last), 1.0, 6.0 / (count as f64).sqrt());
        }
        let (one, other) = (of(sizes, count, 1).1, of(sizes, count, 2).1);
        assert_eq!(one.fingerprint(), of(sizes, count, 1).1.fingerprint());
        assert!(sizes.contains("table") || one.radius != other.radius);
    }
    // nine tenths of the volume are in spheres three times as large; the ratio of numbers is nine to twenty-seven
    let (_, start) = of(sieves, 4000, 1);
    assert_eq!(start.radius.iter().filter(|r| **r > 1e-4).count(), 1000);
}

const WAYS: [(Model, &str); 6] = [
    (Model::Hard, "hard.stepping=events"),
    (Model::Soft, "soft.stepping=uniform"),
    (Model::Soft, "soft.stepping=local"),
    (Model::Soft, "soft.stepping=auto"),
    (Model::Hybrid, "soft.stepping=auto"),
    (Model::Dsmc, "soft.stepping=auto"),
];

/// Runs a dilute gas (with islands) and a dense gas (with one event queue, or uniform steps).
#[test]
fn every_engine_keeps_energy_and_momentum() {
    for (density, sizes) in [("dilute", "4 mm"), ("dense", "2.05 mm")] {
        for (model, stepping) in WAYS {
            let size = format!("domain.size=[\"{sizes}\", \"{sizes}\", \"{sizes}\"]");
            let experiment = case(GAS, model, &[stepping, &size]).unwrap();
            let start = initial_state(&experiment).unwrap();
            let (energy, momentum) = (start.kinetic_energy(), start.momentum());
            let scale: f64 = start.velocity.iter().zip(&start.mass).map(|(v, m)| m * v.norm()).sum();
            let mut simulation = Simulation::new(&experiment, start);
            simulation.run(8, 2.5e-4).unwrap();
            assert!(simulation.record.pairs.count > 100, "{density} {stepping}: {}", simulation.record.pairs.count);
            let tolerance = if model.has_contacts() { 3e-3 } else { 1e-11 };
            close("energy", simulation.energy() / energy, 1.0, tolerance);
            let drift = (simulation.particles.momentum() - momentum).norm() / scale;
            assert!(drift < 1e-12, "{density} {model:?} {stepping}: {drift:e}");
        }
    }
}

/// Three spheres of different sizes in a row collide three times. The velocities in all engines are those of the
/// textbook formula.
#[test]
fn three_sizes_meet_alike_in_every_engine() {
    let text = GAS.replace(
        "count = 200\nvelocity_fluctuation = \"0.5 m/s\"\n",
        r#"at = [
    { position = ["1 mm", "2 mm", "2 mm"], velocity = ["1 m/s", "0 m/s", "0 m/s"], diameter = "0.5 mm" },
    { position = ["1.6 mm", "2 mm", "2 mm"], diameter = "0.4 mm" },
    { position = ["2.4 mm", "2 mm", "2 mm"], diameter = "0.6 mm" },
]
"#,
    );
    let text =
        text.replace("[\"x\", \"y\", \"z\"]", "[\"y\", \"z\"]").replace("restitution = 1.0", "restitution = 0.8");
    let m = [125.0, 64.0, 216.0];
    let hit = |v: &mut [f64; 3], a: usize, b: usize| {
        let (j, u) = (1.8 * m[a] * m[b] / (m[a] + m[b]), v[a] - v[b]);
        v[a] -= j * u / m[a];
        v[b] += j * u / m[b];
    };
    let mut want = [1.0, 0.0, 0.0];
    hit(&mut want, 0, 1);
    hit(&mut want, 1, 2);
    hit(&mut want, 0, 1);
    // the last engine is left out, because its particles collide by chance
    for (model, stepping) in WAYS.into_iter().filter(|(model, _)| *model != Model::Dsmc) {
        let experiment = case(&text, model, &[stepping, "soft.linear_spring_dashpot.stiffness=1 MN/m"]).unwrap();
        let start = initial_state(&experiment).unwrap();
        close("mass", start.mass[0] / start.mass[1], 125.0 / 64.0, 1e-9);
        let mut simulation = Simulation::new(&experiment, start);
        simulation.run(5, 2e-4).unwrap();
        assert_eq!(simulation.record.pairs.count, 3, "{stepping}");
        let mut after = simulation.particles.clone();
        after.sort_by_id();
        let tolerance = if model == Model::Soft { 1e-3 } else { 1e-9 };
        for (v, want) in after.velocity.iter().zip(want) {
            close(stepping, v.x, want, tolerance);
        }
    }
}

/// Drag on each sphere depends on its own diameter: a sphere in a mixture falls like a sphere of its size alone.
#[test]
fn drag_knows_every_diameter() {
    let gas = r#"
[gravity]
acceleration = ["0 m/s^2", "0 m/s^2", "-9.81 m/s^2"]

[fluid]
density = "1.2 kg/m^3"
kinematic_viscosity = "1.5e-5 m^2/s"
[fluid.profile.uniform]
velocity = "0.3 m/s"

[drag.schiller_naumann]
"#;
    let text = format!("{GAS}{gas}");
    let sets = ["domain.size=[\"80 mm\", \"80 mm\", \"80 mm\"]", "run.window=0.1 ms"];
    let many = case(&text, Model::Hard, &sets).unwrap();
    let start = initial_state(&many).unwrap();
    let mut simulation = Simulation::new(&many, start.clone());
    simulation.run(20, 1e-4).unwrap();
    assert_eq!(simulation.record.pairs.count, 0, "they should not meet");
    let mut together = simulation.particles.clone();
    together.sort_by_id();
    for id in [0, 57, 123, 199] {
        let species = &many.scene.species[0];
        let mut alone = many.clone();
        alone.scene.species = vec![species.of_one_size(2.0 * start.radius[id])];
        let mut one = diptych::Particles::default();
        one.push(start.position[id], start.velocity[id], start.radius[id], start.mass[id], 0);
        let mut simulation = Simulation::new(&alone, one);
        simulation.run(20, 1e-4).unwrap();
        let apart = (simulation.particles.velocity[0] - together.velocity[id]).norm();
        assert!(apart < 1e-12 * start.velocity[id].norm(), "{id}: {apart:e}");
        let slowed = (together.velocity[id] - start.velocity[id]).norm();
        assert!(slowed > 1e-3, "drag and gravity did nothing");
    }
}

/// A prescribed contact time holds for every pair of particles. The time step resolves the contact of the smallest
/// possible spheres.
#[test]
fn contacts_of_all_sizes_last_as_long_as_asked_for() {
    let pair = "[[contact.pairs]]\nbetween = [\"sand\", \"sand\"]\ncontact_time = \"2e-6 s\"\n";
    let text = GAS.replace("[soft.linear", &format!("{pair}\n[soft.linear"));
    let experiment = case(&text, Model::Soft, &[]).unwrap();
    let start = initial_state(&experiment).unwrap();
    let law = experiment.law().unwrap();
    for (i, j) in [(0, 1), (5, 60), (170, 3)] {
        let spring = law.between(&Bodies::pair(&experiment.scene, &start, i, j));
        close("contact time", law.contact_time(&spring, 0.1) / 2e-6, 1.0, 1e-9);
    }
    close("step", diptych::simulation::soft_step(&experiment, 200) / (2e-6 / 20.0), 1.0, 1e-9);
    // without a prescribed contact time, the shortest contact is that of two spheres of the smallest diameter
    let plain = case(GAS, Model::Soft, &[]).unwrap();
    let mass = 0.5 * plain.scene.species[0].of_one_size(1e-4).mass();
    let shortest = std::f64::consts::PI * (mass / 2e4).sqrt();
    close("step", diptych::simulation::soft_step(&plain, 200) / (shortest / 20.0), 1.0, 1e-9);
}

#[test]
fn the_same_bits_for_one_and_two_threads() {
    for (model, stepping) in WAYS {
        let experiment = case(GAS, model, &[stepping, "contact.restitution=0.9", "contact.friction=0.1"]).unwrap();
        let of = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut simulation = Simulation::new(&experiment, initial_state(&experiment).unwrap());
                simulation.run(4, 2.5e-4).unwrap();
                simulation.particles.fingerprint()
            })
        };
        assert_eq!(of(1), of(2), "{model:?} {stepping}");
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let sizes =
        r#"sizes = { log_normal = { median = "0.2 mm", geometric_deviation = 1.5, from = "0.1 mm", to = "0.6 mm" } }"#;
    let with = |other: &str| case(&GAS.replace(sizes, other), Model::Hard, &[]).map(|_| ()).unwrap_err();
    for (typed, words) in [
        ("", "sizes"),
        (
            "diameter = \"1 mm\"\nsizes.uniform = { from = \"0.1 mm\", to = \"0.2 mm\" }",
            "`diameter` and `sizes`, which exclude each other",
        ),
        ("sizes.uniform = { from = \"0.2 mm\", to = \"0.2 mm\" }", "is not less than"),
        ("sizes.uniform = { to = \"0.2 mm\" }", "sizes.uniform.from"),
        ("sizes.uniform = { from = \"0.2 mm\", to = \"2 m\" }", "1e-7 m ..= 1 m"),
        (
            "sizes.log_normal = { median = \"0.2 mm\", geometric_deviation = 1.0, from = \"0.1 mm\", to = \"0.3 mm\" }",
            "greater than 1",
        ),
        (
            "sizes.log_normal = { median = \"0.2 mm\", geometric_deviation = 1.1, from = \"0.5 mm\", to = \"0.6 mm\" }",
            "of the distribution",
        ),
        ("sizes.table = { diameters = [\"0.1 mm\"], fractions = [0.1, 0.2] }", "2 shares for 1 diameters"),
        ("sizes.table = { diameters = [\"0.1 mm\"], fractions = [-0.1] }", "greater than 0"),
        ("sizes.gamma = { from = \"0.1 mm\" }", "gamma"),
    ] {
        let said = with(typed);
        assert!(said.contains(words), "{typed}: {said}");
    }
    let at = GAS.replace("count = 200\n", "at = [{ position = [\"1 mm\", \"1 mm\", \"1 mm\"] }]\n");
    assert!(case(&at, Model::Hard, &[]).unwrap_err().contains("diameter` is missing"));
    let at = at.replace("\"1 mm\"] }", "\"1 mm\"], diameter = \"0.7 mm\" }");
    assert!(case(&at, Model::Hard, &[]).unwrap_err().contains("the ends of `sizes`"));
    let at = at.replace(sizes, "diameter = \"0.7 mm\"");
    assert!(case(&at, Model::Hard, &[]).unwrap_err().contains("all of \"sand\" have the same"));
}

/// The key `sizes` of the case, a distribution of diameters, overrides the single diameter in a set of values.
#[test]
fn sizes_override_the_diameter_of_a_model() {
    let text = GAS.replace("density = \"2500 kg/m^3\"\n", "use = \"particles/polystyrene-406um\"\n");
    let experiment = case(&text, Model::Hard, &[]).unwrap();
    let species: &Species = &experiment.scene.species[0];
    assert_eq!((species.smallest(), species.largest(), species.density), (1e-4, 6e-4, 1038.0));
    // the option that is typed last has priority
    let one = case(&text, Model::Hard, &["particles[0].diameter=0.3 mm"]).unwrap();
    assert_eq!((&one.scene.species[0].sizes, one.scene.species[0].diameter), (&None, 3e-4));
    let flat =
        case(&text, Model::Hard, &["particles[0].sizes.uniform.from=0.1 mm", "particles[0].sizes.uniform.to=0.2 mm"]);
    assert_eq!(flat.unwrap().scene.species[0].largest(), 2e-4);
}
