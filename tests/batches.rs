//! Averages over blocks of time, and comparisons of such averages in cases with a known answer.

use diptych::statistics::{Answer, Batches, Comparison, ErrorLevels, Observable, Parity, compare};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Number of slices of a profile.
const SLICES: usize = 20;

/// Number of samples of a series. Blocks are made from these samples.
const SAMPLES: usize = 480;
const BLOCKS: usize = 20;

fn normal(random: &mut Xoshiro256PlusPlus) -> f64 {
    StandardNormal.sample(random)
}

/// Random numbers that are independent, with the given mean and a variance of 1.
fn white(mean: f64, random: &mut Xoshiro256PlusPlus) -> Vec<f64> {
    (0..SAMPLES).map(|_| mean + normal(random)).collect()
}

fn profile(name: &'static str, parity: Parity, parts: Vec<Option<Batches>>) -> Observable {
    let places = (0..parts.len()).map(|k| (2 * k + 1) as f64 / parts.len() as f64 - 1.0).collect();
    Observable { name: name.into(), unit: "", places, parity, fixed_mean: false, scale: 10.0, scale_is: "10", parts }
}

/// Profile whose slices are independent. The values of a slice have the mean 10 plus the `shift` of the slice, and the
/// variance 1. The mean of a slice over the run has the standard error 0.046.
fn shifted(shift: impl Fn(usize) -> f64, random: &mut Xoshiro256PlusPlus) -> Observable {
    let part = |slice: usize| Batches::of_series(&white(10.0 + shift(slice), random), 1.0, 0.0);
    let parts = (0..SLICES).map(part).collect();
    profile("U", Parity::Even, parts)
}

/// Compares a profile with shifted slices with a profile without shift. `margin` [-] is the largest difference that
/// counts as equivalent.
fn against(shift: impl Fn(usize) -> f64, margin: f64, seed: u64) -> Comparison {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let a = shifted(shift, &mut random);
    compare(&[a], &[shifted(|_| 0.0, &mut random)], margin, ErrorLevels::default())
}

#[test]
fn blocks_are_means_in_the_order_of_time_and_end_where_they_are_cut() {
    // 43 samples: blocks of two, one sample left out at the beginning
    let samples: Vec<f64> = (0..43).map(f64::from).collect();
    let batches = Batches::of_series(&samples, 0.5, 3.0).unwrap();
    assert_eq!((batches.count(), batches.per_run, batches.from, batches.length), (21, 21, 3.5, 1.0));
    assert_eq!((batches.values[0], batches.blocks[0][0], batches.blocks[0][20]), (21.0, 1.5, 41.5));
    // the last samples of blocks are at 4 s, 5 s, ...: five blocks are complete at 8.6 s, and all blocks at 24 s, the
    // time of the last sample
    let cut = batches.until(8.6);
    assert_eq!(batches.until(24.0), batches);
    assert_eq!(batches.until(9.0).count(), 6);
    assert_eq!((cut.count(), cut.per_run, cut.values[0]), (5, 5, (1.5 + 3.5 + 5.5 + 7.5 + 9.5) / 5.0));
    assert!(!cut.tells_errors() && batches.tells_errors());
    assert_eq!(batches.until(1e3), batches);
    assert!(Batches::of_series(&[1.0, f64::NAN], 1.0, 0.0).is_none() && Batches::of_series(&[], 1.0, 0.0).is_none());
}

#[test]
fn slices_that_fluctuate_together_do_not_make_their_mean_surer() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    let common = Batches::of_series(&white(0.0, &mut random), 1.0, 0.0).unwrap();
    let own: Vec<Batches> =
        (0..SLICES).map(|_| Batches::of_series(&white(0.0, &mut random), 1.0, 0.0).unwrap()).collect();
    let mean = [vec![1.0 / SLICES as f64; SLICES]];
    let error = |parts: &[Batches]| Batches::join(parts).unwrap().project(&mean).estimate().unwrap().error.unwrap();
    let one = common.estimate().unwrap().error.unwrap();
    assert!((error(&vec![common; SLICES]) / one - 1.0).abs() < 1e-12, "the same twenty times is as sure as once");
    // for independent slices the error of the mean is smaller by sqrt(20) = 4.5; each error is known to about 15 %
    let ratio = one / error(&own);
    assert!((3.0..6.5).contains(&ratio), "{ratio}");
}

#[test]
fn replicas_are_averaged_and_from_eight_on_each_is_a_block() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(2);
    let runs: Vec<Batches> =
        (0..8).map(|k| Batches::of_series(&white(f64::from(k), &mut random), 1.0, 0.0).unwrap()).collect();
    let pool = |count: usize| Batches::pool(&runs[..count].iter().collect::<Vec<_>>(), false).unwrap();
    let mean = |count: usize| runs[..count].iter().map(|run| run.values[0]).sum::<f64>() / count as f64;
    let (few, many) = (pool(3), pool(8));
    assert_eq!((few.count(), few.per_run), (3 * BLOCKS, BLOCKS));
    assert_eq!((many.count(), many.per_run), (8, 1));
    assert!((few.values[0] - mean(3)).abs() < 1e-12 && (many.values[0] - mean(8)).abs() < 1e-12);
    // means of 0 to 7 have the standard deviation 2.45, and the mean of eight runs has the error sqrt(6)/sqrt(8) = 0.87
    let error = many.estimate().unwrap().error.unwrap();
    assert!((0.8..0.95).contains(&error), "{error}");
}

#[test]
fn a_difference_within_the_margin_is_found_and_equivalent() {
    // 0.3 is nine standard errors of the mean over the channel; the margin of 6 % of 10 is 0.6
    for seed in 0..20 {
        let comparison = against(|_| 0.3, 0.06, seed);
        let one = &comparison.judged[0];
        assert!(one.detected && one.answer == Answer::Equivalent && comparison.answer == Answer::Equivalent, "{one:?}");
        assert!((0.03..0.06).contains(&one.reached), "{}", one.reached);
        // but a margin of 2 % shows this difference
        assert_eq!(against(|_| 0.3, 0.02, seed).answer, Answer::Different);
    }
}

#[test]
fn a_difference_at_the_walls_alone_must_be_within_the_margin_there() {
    // three polynomials reproduce about nine tenths of a step in the outermost slices: their sum is within 1.95, the
    // value of the slice is not
    for seed in 0..20 {
        let wall = |slice: usize| if slice == 0 || slice == SLICES - 1 { 2.0 } else { 0.0 };
        let comparison = against(wall, 0.195, seed);
        let one = &comparison.judged[0];
        let smooth = one.tested.smooth_bound;
        assert!(smooth < 1.95 && (0.2..0.225).contains(&one.reached), "{smooth} {}", one.reached);
        assert_eq!(one.answer, Answer::Different, "{:?}", one.tested.largest);
        assert!(one.tested.largest.unwrap().place.unwrap().abs() > 0.9);
        assert_eq!(against(wall, 0.25, seed).answer, Answer::Equivalent);
    }
}

#[test]
fn what_has_no_errors_keeps_the_answer_open() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    let [a, b] = [0, 1].map(|_| shifted(|_| 0.0, &mut random));
    let blind = |seed: u64| {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        // seven samples are too few for a standard error
        let part = || Batches::of_series(&[normal(&mut random); 7], 1.0, 0.0);
        profile("uu", Parity::Even, std::iter::repeat_with(part).take(SLICES).collect())
    };
    let alone = compare(std::slice::from_ref(&a), std::slice::from_ref(&b), 0.1, ErrorLevels::default());
    assert_eq!((alone.answer, alone.unknown.len()), (Answer::Equivalent, 0));
    let both = compare(&[a, blind(4)], &[b, blind(5)], 0.1, ErrorLevels::default());
    assert_eq!((both.answer, both.unknown.as_slice()), (Answer::Unresolved, ["uu".to_owned()].as_slice()));
    assert_eq!(compare(&[], &[], 0.1, ErrorLevels::default()).answer, Answer::Unresolved);
}

/// A report names the smallest difference that it would find, and a sufficient duration of the run. In 80 % of cases,
/// this difference is found, and this duration is sufficient.
#[test]
fn what_could_be_seen_and_what_would_do_is_said_rightly() {
    let pairs = 200;
    let usual = |seed: u64| against(|_| 0.0, 0.01, seed).judged[0].clone();
    let equal: Vec<_> = (0..pairs).map(usual).collect();
    // two runs that are longer by the factor `stretch` have errors smaller by sqrt(stretch); a margin larger by this
    // factor is equivalent
    let enough = (0..pairs).filter(|&seed| {
        let one = &equal[seed as usize];
        against(|_| 0.0, 0.01 * one.stretch.sqrt(), seed).answer == Answer::Equivalent
    });
    let enough = enough.count();
    let seen = equal.iter().map(|one| one.detectable * 10.0).sum::<f64>() / equal.len() as f64;
    let found = (0..pairs).filter(|&seed| against(|_| seen, 0.01, seed).judged[0].detected).count();
    println!("{enough} of {pairs} are equivalent as foretold; a shift of {seen:.3} is found in {found}");
    // 80 % of 200 is 160, with a standard deviation of 6; the recommendation is for the position with the largest
    // error, so that the duration is sufficient more often
    assert!((150..=196).contains(&enough), "{enough}");
    assert!((140..=185).contains(&found), "{found}");
}

/// Compares a probability with a value found by hand or by another program, to the printed digits of the value.
#[track_caller]
fn same_chance(found: f64, expected: f64) {
    assert!((found / expected - 1.0).abs() < 1e-9, "{found:e} {expected:e}");
}

#[test]
fn independent_runs_are_tested_as_the_textbooks_say() {
    let runs = |columns: [&[f64]; 3]| -> Vec<Option<Batches>> {
        columns.map(|column| Some(Batches::of_runs(vec![column.to_vec()]))).into()
    };
    let a = profile(
        "U",
        Parity::Neither,
        runs([
            &[10.2, 9.4, 10.9, 10.1, 9.8, 10.6, 9.9, 10.4, 9.6],
            &[11.1, 10.6, 11.9, 10.7, 11.3, 11.6, 10.4, 11.5, 10.9],
            &[9.7, 9.9, 10.8, 9.2, 10.3, 10.1, 9.6, 10.6, 10.0],
        ]),
    );
    let b = profile(
        "U",
        Parity::Neither,
        runs([
            &[10.1, 9.7, 10.8, 9.9, 10.3, 10.5, 9.5, 10.0, 10.2, 9.6],
            &[10.2, 10.0, 10.9, 9.8, 10.7, 10.3, 9.9, 10.6, 10.1, 10.3],
            &[9.9, 10.4, 10.9, 9.8, 10.2, 10.8, 9.7, 10.5, 10.0, 9.5],
        ]),
    );
    let found = compare(&[a], &[b], 0.01, ErrorLevels::default()).judged.remove(0).tested;
    // Welch's t of the mean and of the middle position, and Hotelling's T² of the three positions with the degrees of
    // freedom of Yao (1965), computed with scipy 1.16 (ttest_ind, cov, f.sf)
    same_chance(found.mean.unwrap().chance(), 0.217_170_278_009_472_48);
    assert!((found.mean.unwrap().freedom - 15.665_942_542_828_102).abs() < 1e-9);
    assert_eq!(found.largest.unwrap().place, Some(0.0));
    same_chance(found.local_chance.unwrap(), 0.003_088_583_362_171_550_3);
    same_chance(found.smooth_chance, 5.311_850_085_136_161_4e-5);
    // three tests were made, so that their combined probability is larger
    same_chance(found.chance, 1.593_555_025_540_848_4e-4);
}

/// Values with stated standard errors are independent: the variance of the sum of two of them is the sum of their
/// variances.
#[test]
fn stated_values_have_their_errors_and_are_independent() {
    for (one, other) in [(0, 1), (1, 2), (5, 1022)] {
        let (a, b) = (Batches::of_stated(3.0, 0.3, one), Batches::of_stated(-1.0, 0.4, other));
        let estimate = a.estimate().unwrap();
        // the standard deviation of 1024 made-up runs gives the given error, except for rounding
        assert!((estimate.value - 3.0).abs() < 1e-12 && (estimate.error.unwrap() - 0.3).abs() < 1e-9, "{estimate:?}");
        let sum = Batches::join([&a, &b]).unwrap().project(&[vec![1.0, 1.0]]).estimate().unwrap();
        assert!((sum.value - 2.0).abs() < 1e-12 && (sum.error.unwrap() - 0.5).abs() < 1e-9, "{sum:?}");
    }
}
