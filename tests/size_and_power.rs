//! Rates of wrong verdicts for pairs of equal runs of all kinds of scenes, and for invented averages with a known
//! difference.
//!
//! The following command prints the tables of docs/theory/statistics.md: `cargo test --release --test it -- --ignored
//! --nocapture size_and_power`.

use diptych::case::Case;
use diptych::outcome::Outcome;
use diptych::output::Basis;
use diptych::placement::initial_state;
use diptych::schedule::Schedule;
use diptych::statistics::{Answer, Batches, Comparison, ErrorLevels, Observable, Parity, compare};
use diptych::study::{execute, judge, pool};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::path::Path;

/// Scene whose runs are compared in pairs. `replicas` has the numbers of replicas (runs with different seeds) on each
/// side of a comparison.
struct Scene {
    name: &'static str,
    case: &'static str,
    sets: &'static [&'static str],
    replicas: &'static [usize],
}

const SCENES: [Scene; 6] = [
    Scene {
        name: "channel",
        case: "cases/channel-d.toml",
        sets: &[
            "domain.size=[\"4.2 mm\", \"40 mm\", \"6 mm\"]",
            "particles[0].volume_fraction=2.5e-3",
            "run.duration=3 s",
            "run.average_from=0.4 s",
            "statistics.slices=10",
        ],
        replicas: &[1],
    },
    Scene { name: "elastic gas", case: "tests/inputs/verdict/gas.toml", sets: &[], replicas: &[1] },
    Scene { name: "mixture", case: "tests/inputs/verdict/mixture.toml", sets: &[], replicas: &[1] },
    Scene {
        name: "cooling gas",
        case: "tests/inputs/verdict/gas.toml",
        sets: &["contact.restitution=0.9", "run.duration=40 ms"],
        replicas: &[3, 5, 8],
    },
    Scene {
        name: "settling bed",
        case: "tests/inputs/verdict/bed.toml",
        sets: &["run.average_from=0 s"],
        replicas: &[3, 5, 8],
    },
    Scene {
        name: "bed at rest",
        case: "tests/inputs/verdict/bed.toml",
        sets: &["run.duration=0.4 s", "run.average_from=0.3 s"],
        replicas: &[1, 3, 8],
    },
];

impl Scene {
    /// Outcome of a run with the given seed.
    fn run(&self, seed: u64) -> Outcome {
        let sets: Vec<String> = self.sets.iter().map(|set| (*set).to_owned()).collect();
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(self.case);
        let (mut experiment, _) = Case::read(&path, &sets).unwrap().experiment(None, Some(seed)).unwrap();
        experiment.name = format!("seed {seed}");
        execute(&experiment, initial_state(&experiment).unwrap(), &mut []).0
    }

    fn runs(&self, count: u64) -> Vec<Outcome> {
        (1..=count).into_par_iter().map(|seed| self.run(seed)).collect()
    }
}

/// Number of comparisons with each answer: equivalent, different or unresolved.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    different: usize,
    equivalent: usize,
    all: usize,
}

impl Tally {
    fn add(mut self, answer: Answer) -> Self {
        self.all += 1;
        self.different += usize::from(answer == Answer::Different);
        self.equivalent += usize::from(answer == Answer::Equivalent);
        self
    }

    fn of(answers: impl Iterator<Item = Answer>) -> Self {
        answers.fold(Self::default(), Self::add)
    }

    fn share(count: usize, all: usize) -> String {
        let share = count as f64 / all as f64;
        let error = (share.max(1.0 / all as f64) * (1.0 - share) / all as f64).sqrt();
        format!("{:.1} ± {:.1} %", 100.0 * share, 100.0 * error)
    }
}

/// Answers for pairs of equal systems, with `replicas` replicas on each side, drawn at random from the given runs.
/// Also returns how often each kind of comparison was made.
fn equal_pairs(runs: &[Outcome], replicas: usize, pairs: usize) -> (Tally, [usize; 4]) {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(replicas as u64);
    let mut order: Vec<usize> = Vec::new();
    let mut take = || {
        if order.len() < 2 * replicas {
            order = (0..runs.len()).collect();
            (1..order.len()).rev().for_each(|k| order.swap(k, random.random_range(0..=k)));
        }
        order.split_off(order.len() - 2 * replicas)
    };
    let places: Vec<Vec<usize>> = (0..pairs).map(|_| take()).collect();
    let judged: Vec<(Answer, Basis)> = places
        .par_iter()
        .map(|places| {
            let side = |places: &[usize]| {
                let all: Vec<Outcome> = places.iter().map(|place| runs[*place].clone()).collect();
                pool(all[0].clone(), all[1..].to_vec())
            };
            let (sides, others): (Vec<Outcome>, Vec<Vec<Outcome>>) = places.chunks(replicas).map(side).unzip();
            let verdict = judge(&sides, &others, 0.01).remove(0);
            (verdict.answer, verdict.basis)
        })
        .collect();
    let basis = |wanted: Basis| judged.iter().filter(|one| one.1 == wanted).count();
    let bases = [Basis::Averages, Basis::Curves, Basis::Paths, Basis::Nothing].map(basis);
    (Tally::of(judged.iter().map(|one| one.0)), bases)
}

#[test]
#[ignore = "thousands of runs: cargo test --release --test it -- --ignored --nocapture size_and_power"]
fn size_and_power_of_equal_pairs() {
    for scene in SCENES {
        let runs = scene.runs(800);
        let steady = runs.iter().filter(|run| run.steadiness.steady).count();
        println!("{}: {steady} of 800 runs are steady", scene.name);
        for &replicas in scene.replicas {
            let (tally, bases) = equal_pairs(&runs, replicas, 400);
            println!(
                "| {} | {replicas} | {} | {} | {bases:?} |",
                scene.name,
                Tally::share(tally.different, tally.all),
                Tally::share(tally.equivalent, tally.all)
            );
            // 1 % of 400 is 4, with a standard deviation of 2
            assert!(tally.different <= 10, "{}: {tally:?}", scene.name);
        }
    }
}

/// Random series with variance 1. Its correlation falls by the factor e in `relaxation` samples.
fn noise(count: usize, relaxation: f64, random: &mut Xoshiro256PlusPlus) -> Vec<f64> {
    let rho = (-1.0 / relaxation).exp();
    let mut slow: f64 = StandardNormal.sample(random);
    let mut next = || {
        let kick: f64 = StandardNormal.sample(random);
        let later = rho * slow + (1.0 - rho * rho).sqrt() * kick;
        std::mem::replace(&mut slow, later)
    };
    (0..count).map(|_| next()).collect()
}

/// Difference of two systems as a function of a position from -1 to 1. The second argument is the number of positions.
type Shape = fn(f64, usize) -> f64;

const SHAPES: [(&str, Shape); 4] = [
    ("uniform", |_, _| 1.0),
    ("slope", |y, _| y.abs()),
    ("wall", |y, count| f64::from(u8::from(y.abs() > 1.0 - 1.5 / count as f64))),
    ("one slice", |y, count| f64::from(u8::from((y - 0.41).abs() < 0.99 / count as f64))),
];

/// Six profiles and two numbers of an invented run. The first profile is shifted by `size` times the function `shape`.
fn profiles(slices: usize, size: f64, shape: Shape, random: &mut Xoshiro256PlusPlus) -> Vec<Observable> {
    let y: Vec<f64> = (0..slices).map(|k| (2 * k + 1) as f64 / slices as f64 - 1.0).collect();
    let names = ["number_density_ratio", "U", "uu", "vv", "ww", "uv", "granular temperature", "pair impacts per time"];
    let mut one = |(place, name): (usize, &'static str)| {
        let common = noise(480, 4.8, random);
        let mut part = |y: f64| {
            let shift = if place == 0 { size * shape(y, slices) } else { 0.0 };
            let own = noise(480, 1.5, random);
            let samples: Vec<f64> =
                common.iter().zip(&own).map(|(common, own)| 10.0 + shift + 0.5 * common + own).collect();
            Batches::of_series(&samples, 1.0, 0.0)
        };
        let places = if place < 6 { y.clone() } else { Vec::new() };
        let parts = if place < 6 { y.iter().map(|y| part(*y)).collect() } else { vec![part(0.0)] };
        observable(name, places, parts)
    };
    names.into_iter().enumerate().map(&mut one).collect()
}

fn observable(name: &'static str, places: Vec<f64>, parts: Vec<Option<Batches>>) -> Observable {
    let parity = Parity::Neither;
    Observable { name: name.into(), unit: "", places, parity, fixed_mean: false, scale: 10.0, scale_is: "10", parts }
}

/// Four curves over time at twenty instants, from `replicas` invented replicas. The first curve is shifted by `size`
/// times the function `shape`.
fn curves(replicas: usize, size: f64, shape: Shape, random: &mut Xoshiro256PlusPlus) -> Vec<Observable> {
    let y: Vec<f64> = (0..20).map(|k| (2 * k + 1) as f64 / 20.0 - 1.0).collect();
    let mut one = |(place, name): (usize, &'static str)| {
        let runs: Vec<Vec<f64>> = (0..replicas).map(|_| noise(20, 3.0, random)).collect();
        let at = |k: usize| {
            let shift = if place == 0 { size * shape(y[k], 20) } else { 0.0 };
            Some(Batches::of_runs(vec![runs.iter().map(|run| 10.0 + shift + 0.3 * run[k]).collect()]))
        };
        observable(name, y.clone(), (0..20).map(at).collect())
    };
    ["granular temperature", "energy", "T along y", "impacts"].into_iter().enumerate().map(&mut one).collect()
}

/// Compares `pairs` pairs of invented runs, of which one is shifted in its first observable. Counts the answers for
/// this observable alone.
fn shifted(pairs: u64, margin: f64, run: impl Fn(bool, &mut Xoshiro256PlusPlus) -> Vec<Observable> + Sync) -> Tally {
    let one = |pair: u64| -> Comparison {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(pair);
        let (a, b) = (run(true, &mut random), run(false, &mut random));
        compare(&a, &b, margin, ErrorLevels::default())
    };
    let answers: Vec<Answer> = (0..pairs).into_par_iter().map(|pair| one(pair).judged[0].answer).collect();
    Tally::of(answers.into_iter())
}

/// True if at most 5 % of the pairs are called equivalent, within three standard errors. This is required if the true
/// difference equals the margin (largest accepted difference).
fn is_rare(tally: Tally) -> bool {
    let all = tally.all as f64;
    tally.equivalent as f64 <= 0.05 * all + 3.0 * (0.05 * 0.95 * all).sqrt()
}

/// Counts the answers if replicas (runs) are added in groups of four, up to 32, until a test after a group gives an
/// answer. Also returns the mean number of replicas.
fn until_decided(pairs: u64, margin: f64, size: f64, shape: Shape) -> (Tally, f64) {
    let one = |pair: u64| -> (Answer, usize) {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(pair);
        let shifted = curves(32, 10.0 * margin * size, shape, &mut random);
        let other = curves(32, 0.0, shape, &mut random);
        let first = |all: &[Observable], count: usize| -> Vec<Observable> {
            let cut = |part: &Option<Batches>| Some(Batches::of_runs(vec![part.as_ref()?.blocks[0][..count].to_vec()]));
            all.iter().map(|one| Observable { parts: one.parts.iter().map(cut).collect(), ..one.clone() }).collect()
        };
        let looks = (1..=8).map(|look| {
            let [a, b] = [&shifted, &other].map(|all| first(all, 4 * look));
            (compare(&a[..1], &b[..1], margin, ErrorLevels::of_look(look, 8)).answer, 4 * look)
        });
        let looks: Vec<(Answer, usize)> = looks.collect();
        *looks.iter().find(|(answer, _)| *answer != Answer::Unresolved).unwrap_or(&looks[7])
    };
    let all: Vec<(Answer, usize)> = (0..pairs).into_par_iter().map(one).collect();
    let replicas = all.iter().map(|one| one.1).sum::<usize>() as f64 / all.len() as f64;
    (Tally::of(all.iter().map(|one| one.0)), replicas)
}

fn sequential(pairs: u64, sizes: &[f64]) {
    for (name, shape) in [SHAPES[0], SHAPES[3]] {
        for &size in sizes {
            let (tally, replicas) = until_decided(pairs, 0.06, size, shape);
            println!(
                "| until decided, {} | {size} | {} | {} | {replicas:.1} replicas |",
                if name == "uniform" { name } else { "one instant" },
                Tally::share(tally.different, tally.all),
                Tally::share(tally.equivalent, tally.all)
            );
            assert!(size != 1.0 || is_rare(tally), "{name}: {tally:?}");
            assert!(size != 0.0 || tally.different as f64 <= 0.01 * pairs as f64 + 3.0 * (0.01 * pairs as f64).sqrt());
        }
    }
}

fn table(pairs: u64, sizes: &[f64]) {
    let show = |what: &str, size: f64, tally: Tally| {
        println!(
            "| {what} | {size} | {} | {} |",
            Tally::share(tally.different, tally.all),
            Tally::share(tally.equivalent, tally.all)
        );
        assert!(size != 1.0 || is_rare(tally), "{what}: {tally:?}");
    };
    for slices in [15, 40] {
        for (name, shape) in SHAPES {
            for &size in sizes {
                // the standard error in a slice is about 0.1, twice that of the difference of means
                let margin = 0.08;
                let run = |is_shifted: bool, random: &mut Xoshiro256PlusPlus| {
                    profiles(slices, if is_shifted { 10.0 * margin * size } else { 0.0 }, shape, random)
                };
                show(&format!("{name}, {slices} slices"), size, shifted(pairs, margin, run));
            }
        }
    }
    for (replicas, margin) in [(3, 0.3), (5, 0.12), (8, 0.08)] {
        for (name, shape) in [SHAPES[0], SHAPES[3]] {
            for &size in sizes {
                let run = |is_shifted: bool, random: &mut Xoshiro256PlusPlus| {
                    curves(replicas, if is_shifted { 10.0 * margin * size } else { 0.0 }, shape, random)
                };
                let name = if name == "uniform" { name } else { "one instant" };
                show(&format!("{name}, {replicas} replicas"), size, shifted(pairs, margin, run));
            }
        }
    }
}

#[test]
#[ignore = "minutes of made-up runs: cargo test --release --test it -- --ignored --nocapture size_and_power"]
fn size_and_power_of_known_differences() {
    table(400, &[0.0, 0.5, 1.0, 1.3, 2.0]);
    sequential(400, &[0.0, 0.5, 1.0, 1.3, 2.0]);
}

#[test]
fn equivalence_at_the_margin_is_rare_wherever_the_difference_is() {
    table(100, &[1.0]);
    sequential(100, &[0.0, 1.0]);
}

/// Recommendation of an unresolved comparison: a longer run, or a larger number of replicas (runs with different
/// seeds).
enum Advice {
    Longer,
    Replicas(usize),
}

/// Number of unresolved pairs among 15, and number of these that are decided if the recommendation is followed. Also
/// returns the mean factor by which duration or number of replicas grows.
fn advised(scene: &Scene, advice: &Advice, margin: f64) -> (usize, usize, f64) {
    let experiment = |seed: u64| {
        let sets: Vec<String> = scene.sets.iter().map(|set| (*set).to_owned()).collect();
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(scene.case);
        let (mut experiment, _) = Case::read(&path, &sets).unwrap().experiment(None, Some(seed)).unwrap();
        experiment.name = format!("seed {seed}");
        experiment
    };
    let compared = |seed: u64, replicas: u64, stretch: f64| {
        let side = |first: u64| {
            let run = |seed: u64| {
                let mut experiment = experiment(seed);
                if stretch > 1.0 {
                    experiment.statistics.sample_interval = Some(Schedule::new(&experiment).interval());
                    experiment.run.duration *= stretch;
                }
                execute(&experiment, initial_state(&experiment).unwrap(), &mut []).0
            };
            let all: Vec<Outcome> = (first..first + replicas).into_par_iter().map(run).collect();
            pool(all[0].clone(), all[1..].to_vec())
        };
        let (sides, others): (Vec<Outcome>, Vec<Vec<Outcome>>) =
            [side(seed), side(seed + replicas)].into_iter().unzip();
        judge(&sides, &others, margin).remove(0)
    };
    let (mut open, mut resolved, mut much) = (0, 0, 0.0);
    for pair in 0..15 {
        let first = compared(10_000 * pair, if let Advice::Replicas(count) = advice { *count as u64 } else { 1 }, 1.0);
        let stretch = first.comparison.iter().flat_map(|all| &all.judged).map(|one| one.stretch).fold(0.0, f64::max);
        if first.answer != Answer::Unresolved || first.comparison.is_none() {
            continue;
        }
        open += 1;
        let stretch = stretch.max(2.0);
        let (replicas, longer) = match advice {
            Advice::Longer => (1, stretch),
            Advice::Replicas(count) => ((stretch * *count as f64).ceil() as u64, 1.0),
        };
        much += stretch;
        let then = compared(10_000 * pair + 5000, replicas, longer);
        resolved += usize::from(then.answer != Answer::Unresolved);
    }
    (open, resolved, much / f64::from(open.max(1) as u32))
}

#[test]
#[ignore = "some minutes of runs: cargo test --release --test it -- --ignored --nocapture advice_is_true"]
fn advice_is_true() {
    let asked = [
        (0, Advice::Longer, 0.2),
        (1, Advice::Longer, 0.05),
        (3, Advice::Replicas(3), 0.1),
        (2, Advice::Replicas(1), 0.1),
    ];
    for (place, advice, margin) in asked {
        let scene = &SCENES[place];
        let (open, resolved, much) = advised(scene, &advice, margin);
        let by = if matches!(advice, Advice::Longer) { "longer runs" } else { "replicas" };
        println!("| {} | {by}, {much:.0} times as much | {resolved} of {open} |", scene.name);
        assert!(10 * resolved >= 7 * open, "{}: {resolved} of {open}", scene.name);
    }
}
