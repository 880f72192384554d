//! Invented results, which no engine has computed, for tests of documents.

use diptych::domain::Domain;
use diptych::engine::{Counters, Failure, Partner};
use diptych::experiment::*;
use diptych::fluid::{Fluid, Profile};
use diptych::observe::{Balance, Paths, Series, Stress};
use diptych::outcome::{Averaged, Outcome, Timing};
use diptych::output::*;
use diptych::particles::Particles;
use diptych::record::{Impact, Ledger, Record};
use diptych::scene::{Scene, Species, Surface};
use diptych::statistics::{
    Batches, ErrorLevels, Estimate, Observable, Parity, ProfileTable, SLICE_QUANTITIES, SliceRow, Steadiness, compare,
};
use diptych::walls::{Plane, Wall, WallGeometry};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;

fn scene() -> Scene {
    let surface = Surface::new(0.94, 0.325);
    let wall = |y: f64, up: f64| {
        Wall::new(
            WallGeometry::Plane(Plane { point: Vector3::new(0.0, y, 0.0), normal: Vector3::new(0.0, up, 0.0) }),
            surface,
        )
    };
    Scene {
        gravity: Vector3::new(0.0, 0.0, -9.81),
        fluid: Some(Fluid::new(1.205, 1.515e-5, Profile::Uniform(15.9), None)),
        walls: vec![wall(0.0, 1.0), wall(0.04, -1.0)],
        ..Scene::new(
            Domain::new(Vector3::new(0.12, 0.04, 0.064), [true, false, true]),
            Surface::new(1.0, 0.0),
            vec![Species::new("polystyrene, 406 um", 406e-6, 1038.0)],
        )
    }
}

fn experiment(name: &str, model: Model) -> Experiment {
    let base = crate::support::experiment(scene(), 0, [0.0; 3], 0.0, model, 1);
    let run = RunSettings { duration: 5.0, average_from: AverageFrom::Time(2.0), ..base.run.clone() };
    let statistics = StatisticsSettings { slices: 40, sample_interval: None };
    Experiment { name: name.into(), run, statistics, ..base }
}

/// Invented outcome of a channel, with noise as large as its standard errors.
pub fn outcome(name: &str, model: Model, seed: u64) -> Outcome {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let slices = 40;
    let row = |k: usize, random: &mut Xoshiro256PlusPlus| {
        let y = 0.04 * (k as f64 + 0.5) / slices as f64;
        let s = (2.0 * y / 0.04 - 1.0).powi(2);
        let mut noisy = |value: f64, error: f64| {
            let z: f64 = random.sample(StandardNormal);
            Some(Estimate::new(value + error * z, error))
        };
        let mut estimates = [None; SLICE_QUANTITIES];
        // number density, U, V, W, uu, vv, ww, uv, uw, vw, and third moments
        estimates[..10].copy_from_slice(&[
            noisy(0.9 + 0.35 * s * s, 0.012),
            noisy(12.0 - 1.6 * s, 0.05),
            noisy(0.0, 0.004),
            noisy(0.0, 0.004),
            noisy(0.5 + 0.6 * s, 0.02),
            noisy(0.12, 0.004),
            noisy(0.13, 0.004),
            noisy(-0.05 * (2.0 * y / 0.04 - 1.0), 0.004),
            noisy(0.0, 0.004),
            noisy(0.0, 0.003),
        ]);
        estimates[10..].iter_mut().for_each(|third| *third = noisy(0.0, 0.002));
        SliceRow { y, estimates, samples: 2000 + k as u64 }
    };
    let mut profile: Vec<SliceRow> = (0..slices).map(|k| row(k, &mut random)).collect();
    profile[3].estimates[10] = None;
    let mut record = Record::default();
    let soft = model == Model::Soft;
    for _ in 0..20_000 {
        let speed = 0.4 * random.random::<f64>().ln().abs().sqrt();
        let overlap = if soft { 0.05 * speed } else { 0.0 };
        let first = overlap * random.random::<f64>() * 0.1;
        let duration = if soft { 1.1e-5 } else { 0.0 };
        let rebound = speed * if soft { 1.0 + 1e-4 * random.random::<f64>() } else { 1.0 };
        record.pairs.add(&Impact {
            overlap_time: 0.64 * overlap * duration,
            normal_speed: speed,
            rebound_speed: rebound,
            duration,
            first_overlap: first,
            maximum_overlap: overlap,
            left_out: None,
            slip: None,
        });
        record.walls.add(&Impact {
            overlap_time: 0.51 * overlap * duration,
            normal_speed: 0.8 * speed,
            rebound_speed: 0.94 * 0.8 * speed,
            duration,
            first_overlap: first,
            maximum_overlap: 0.8 * overlap,
            left_out: None,
            slip: None,
        });
    }
    record.ledger += Ledger {
        drag_work: 0.0123,
        gravity_work: -0.0081,
        wall_restitution_loss: 0.0009,
        wall_friction_loss: 0.0004,
        ..Ledger::default()
    };
    Outcome {
        gas: None,
        flows: Vec::new(),
        observations: Vec::new(),
        stress: Stress::default(),
        pairs: record.pairs.clone(),
        walls: record.walls.clone(),
        experiment: experiment(name, model),
        failure: None,
        particles: 87_668,
        initial_state_hash: 0xdead_beef_0123_4567,
        final_state_hash: seed.wrapping_mul(0x9e37_79b9_7f4a_7c15),
        simulated_seconds: 5.0,
        windows: 50_000,
        window: 1e-4,
        sample_interval: 1e-3,
        time_step: soft.then_some(7.5e-7),
        kinds: Default::default(),
        rings: Default::default(),
        profiles: ProfileTable { slices: profile, blocks: 20, from: 2.0, until: 5.0, batches: Vec::new() },
        places_kept: None,
        steadiness: Steadiness { from: 2.0, steady: true, drift: Some(1.4) },
        record,
        pair_rate: Some(Estimate::new(1.234e6, 2.1e3)),
        pair_restitution: Some(Estimate::new(if soft { 1.00005 } else { 1.0 }, 1e-6)),
        wall_restitution: Some(Estimate::new(0.94, 1e-6)),
        averaged: Averaged::default(),
        temperature: Some(Estimate::new(0.25, 0.003)),
        energy_residual: Estimate::new(if soft { 1e-5 } else { 0.0 }, 1e-7),
        wall_rate: Some(Estimate::new(3.21e5, 900.0)),
        energy_at_start: 0.2200,
        energy_at_end: 0.2229 + if soft { 1e-5 } else { 0.0 },
        series: Series::default(),
        paths: Paths::default(),
        balance: Balance {
            drag: Some(Estimate::new(0.0325, 0.0002)),
            weight: -0.0313,
            wall: Some(Estimate::new(-0.0011, 0.0001)),
            flow: Some(Estimate::without_error(0.0)),
            residual: Some(Estimate::new(0.0001, 0.0002)),
        },
        counters: if soft {
            Counters {
                steps: 6_666_667,
                pair_checks: 512_000_000_123,
                force_evaluations: 9_000_000,
                ..Counters::default()
            }
        } else {
            Counters { events: 6_123_456, pair_checks: 812_000_123, neighbour_builds: 3_000, ..Counters::default() }
        },
        timing: Timing {
            wall_seconds: if soft { 412.0 } else { 31.0 },
            engine: if soft { 398.0 } else { 24.0 },
            neighbours: if soft { 60.0 } else { 11.0 },
            flight: if soft { 0.0 } else { 1.5 },
            drag: 4.0,
            statistics: 2.0,
            threads: 2,
        },
    }
}

/// Three variants. The last variant has failed and still has results; its name needs escaping.
pub fn outcomes() -> Vec<Outcome> {
    let mut failed = outcome("soft, k < 300 N/m & \"$x$\"", Model::Soft, 3);
    failed.failure = Some(Failure::OverlapTooLarge {
        time: 3.25,
        particle: 17,
        partner: Partner::Particle(4711),
        ratio: 0.31,
        limit: 0.3,
        way: None,
    });
    failed.simulated_seconds = 3.25;
    failed.steadiness.steady = false;
    vec![outcome("hard", Model::Hard, 1), outcome("soft, k = 3000 N/m", Model::Soft, 2), failed]
}

pub fn provenance() -> Provenance {
    Provenance {
        title: "Does the stiffness change the profiles of case D?".into(),
        case_path: "cases/channel-d.toml".into(),
        case_text: "# Question\n[domain]\nsize = [\"120 mm\", \"40 mm\", \"64 mm\"] # <b>\n".into(),
        command: "diptych compare cases/channel-d.toml".into(),
        scene: "87,668 spheres of 406 µm in a vertical channel of 120 × 40 × 64 mm, carried by air at a bulk Reynolds \
                number of 42000; frictional inelastic walls."
            .into(),
    }
}

/// Comparison of "soft, k = 3000 N/m" with "hard". U differs by 0.3 m/s, and the impact rate does not differ
/// significantly.
pub fn comparisons() -> Vec<Verdict> {
    let series = |value: f64| {
        let samples: Vec<f64> = (0..200).map(|k| value * (1.0 + 0.01 * f64::from(k * k % 17 - 8) / 8.0)).collect();
        Batches::of_series(&samples, 0.01, 2.0)
    };
    let observables = |shift: f64| {
        let profile = |slices: u32, value: f64| (0..slices).map(|_| series(value)).collect();
        let of = |name: &'static str, unit, places: Vec<f64>, parts: Vec<Option<Batches>>, scale| Observable {
            name: name.into(),
            unit,
            places,
            parity: Parity::Even,
            fixed_mean: false,
            scale,
            scale_is: "its value",
            parts,
        };
        let y = (0..8).map(|k| (f64::from(k) + 0.5) * 5e-3).collect();
        vec![
            of("U", "m/s", y, profile(8, 12.0 + shift), 12.0),
            of("pair impacts per time", "1/s", Vec::new(), profile(1, 1.2e6), 1.2e6),
        ]
    };
    let comparison = compare(&observables(0.3), &observables(0.0), 0.01, ErrorLevels::default());
    vec![Verdict {
        variant: "soft, k = 3000 N/m".into(),
        reference: "hard".into(),
        answer: comparison.answer,
        basis: Basis::Averages,
        sentence: "\"soft, k = 3000 N/m\" against \"hard\": different by 2.5 % in U.".into(),
        reason: "Both are steady.".into(),
        margin: 0.01,
        comparison: Some(comparison),
        observed: Vec::new(),
        further: Vec::new(),
    }]
}

pub fn with_study(outcomes: &[Outcome], put: impl FnOnce(&Study)) {
    let (provenance, comparisons) = (provenance(), comparisons());
    let parameters = vec![serde_json::json!({"soft": {"stiffness": 3000.0}}); outcomes.len()];
    let verdicts = [
        "Soft (k = 3000 N/m) and hard spheres agree within 2.3 standard errors; hard is 13 times cheaper.".to_string(),
        "At k = 300 N/m the soft model fails.".to_string(),
    ];
    let unasked = HalvedStep::Unknown("not asked for".into());
    let sheets: Vec<TrustSheet> = outcomes.iter().map(|o| diptych::study::trust_sheet(o, unasked.clone())).collect();
    let study = Study {
        provenance: &provenance,
        outcomes,
        parameters: &parameters,
        verdicts: &verdicts,
        comparisons: &comparisons,
        overrides: &[String::new(), "soft.steps_per_contact = 50".into()],
        notes: &["One run per variant: errors come from 20 blocks of time.".to_string()],
        trust: &sheets,
        frames: &[],
        budgets: None,
    };
    put(&study);
}

pub fn write(folder: &Folder, outcomes: &[Outcome]) {
    let mut particles = Particles::default();
    particles.push(Vector3::new(0.1 + 0.2, 0.01, -0.001), Vector3::new(1.0 / 3.0, -0.0, 12.0), 203e-6, 3.6e-8, 0);
    particles.push(Vector3::new(0.05, 0.02, 0.03), Vector3::zeros(), 203e-6, 3.6e-8, 0);
    particles.reorder(&[1, 0]);
    if let Some(first) = outcomes.first() {
        folder
            .write(
                "state.csv",
                &csv::state(&particles, &first.experiment.scene, &[("time_s", "5.0".to_owned())]).unwrap(),
            )
            .unwrap();
    }
    with_study(outcomes, |study| drop(write_study(folder, study).unwrap()));
}
