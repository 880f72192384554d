use super::*;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Sum of numbers by another method, as a reference: partial sums whose bits do not overlap (J. R. Shewchuk, Discrete
/// Comput. Geom. 18, 305 (1997), "grow expansion"), rounded as in Python's `math.fsum`.
fn reference(numbers: &[f64]) -> f64 {
    let mut partials: Vec<f64> = Vec::new();
    for &number in numbers {
        let mut x = number;
        let mut kept = Vec::new();
        for &partial in &partials {
            let (large, small) = if x.abs() < partial.abs() { (partial, x) } else { (x, partial) };
            let sum = large + small;
            let rest = small - (sum - large);
            if rest != 0.0 {
                kept.push(rest);
            }
            x = sum;
        }
        kept.push(x);
        partials = kept;
    }
    let mut sum = partials.pop().unwrap_or(0.0);
    while let Some(next) = partials.pop() {
        let before = sum;
        sum += next;
        let rest = next - (sum - before);
        if rest != 0.0 {
            // exactly half-way between two numbers: the sign of the lower partial sums decides
            if let Some(below) = partials.last()
                && below.signum() == rest.signum()
            {
                let twice = 2.0 * rest;
                if twice == sum + twice - sum {
                    sum += twice;
                }
            }
            break;
        }
    }
    sum
}

fn one_by_one(numbers: &[f64]) -> ExactSum {
    let mut sum = ExactSum::default();
    numbers.iter().for_each(|&x| sum.add(x));
    sum
}

/// Random numbers with magnitudes from 2^low to 2^high and random signs.
fn numbers(count: usize, low: i32, high: i32, random: &mut Xoshiro256PlusPlus) -> Vec<f64> {
    let one = |_| {
        let mantissa = 1.0 + random.random::<f64>();
        let half = random.random_range(low..high) as f64 / 2.0;
        let sign = if random.random::<bool>() { 1.0 } else { -1.0 };
        // the power is multiplied in two steps, because 2^-1074 is not a normal number
        sign * mantissa * half.floor().exp2() * half.ceil().exp2()
    };
    (0..count).map(one).collect()
}

#[test]
fn sums_are_exact_whatever_the_order_and_the_way() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    for (low, high) in [(-2, 2), (-30, 30), (-80, 10), (-1080, -1000), (-1074, 960), (900, 1005)] {
        for count in [1, 2, 3, 7, 100, 5000] {
            let mut all = numbers(count, low, high, &mut random);
            // with a probability of one half, copies with the opposite sign cancel most terms
            if random.random::<bool>() {
                all.extend(all.clone().iter().rev().skip(1).map(|x| -x));
            }
            let want = reference(&all);
            let sum = one_by_one(&all);
            assert_eq!(sum.value().to_bits(), want.to_bits(), "2^{low} to 2^{high}, {count}: {} {want}", sum.value());
            all.shuffle(&mut random);
            let mut together = ExactSum::default();
            add_all(&mut together, &all);
            assert!(together == sum && together.value() == want, "2^{low} to 2^{high}, {count}");
            assert_eq!(super::sum(&all, |x| *x).value(), want);
            let lanes = side_by_side(&all, |[a, b, c]: &[f64; 3]| [*a, *b, *c]);
            assert_eq!(
                merged(none(), lanes)
                    .into_iter()
                    .reduce(|mut a, b| {
                        a.merge(&b);
                        a
                    })
                    .unwrap()
                    .value(),
                want
            );
            let of = |k: usize| [all[k], 2.0 * all[k], 1.0];
            let [once, twice, number] = values(&sums(all.len(), of));
            assert_eq!((once, number), (want, all.len() as f64));
            assert_eq!(twice, if want.abs() < 1e308 { 2.0 * want } else { twice });
            let groups = sums_in_groups(3, all.len(), |k| (k % 3, of(k))).values();
            for (group, sums) in groups.iter().enumerate() {
                let own: Vec<f64> = all.iter().skip(group).step_by(3).copied().collect();
                assert_eq!(*sums, [reference(&own), sums[1], own.len() as f64]);
            }
        }
    }
}

#[test]
fn ties_go_to_even_and_what_lies_far_below_breaks_them() {
    let tiny = f64::from_bits(1);
    let half = f64::EPSILON / 2.0;
    for (numbers, want) in [
        (vec![1.0, half], 1.0),
        (vec![1.0, half, tiny], 1.0 + f64::EPSILON),
        (vec![1.0, half, -tiny], 1.0),
        (vec![1.0 + f64::EPSILON, half], 1.0 + 2.0 * f64::EPSILON),
        (vec![1.0 + f64::EPSILON, half, -tiny], 1.0 + f64::EPSILON),
        (vec![-1.0, -half, -tiny], -1.0 - f64::EPSILON),
        (vec![tiny; 3], 3.0 * tiny),
        (vec![f64::MIN_POSITIVE, -tiny], f64::MIN_POSITIVE - tiny),
        (vec![f64::MAX, f64::MAX, -f64::MAX], f64::MAX),
        (vec![f64::MAX, f64::MAX], f64::INFINITY),
        (vec![f64::MAX, 2.0_f64.powi(970)], f64::INFINITY),
        (vec![f64::MAX, 2.0_f64.powi(970), -tiny], f64::MAX),
        (vec![-f64::MAX; 3000], f64::NEG_INFINITY),
        (vec![0.0, -0.0], 0.0),
        (vec![], 0.0),
    ] {
        assert_eq!(one_by_one(&numbers).value(), want, "{:?}", &numbers[..numbers.len().min(4)]);
    }
}

#[test]
fn what_is_not_finite_comes_out_as_of_a_plain_sum() {
    let (inf, nan) = (f64::INFINITY, f64::NAN);
    for special in [vec![inf], vec![-inf, -inf], vec![inf, -inf], vec![nan], vec![nan, inf]] {
        let plain = 1.0 + special.iter().sum::<f64>();
        let all: Vec<f64> = special.iter().copied().chain(vec![1.0; 40]).collect();
        let mut sum = ExactSum::default();
        add_all(&mut sum, &all);
        let stored = crate::stored::Stored::of(&sum).unwrap().read::<ExactSum>().unwrap();
        let mut copied = ExactSum::default();
        *copied.words() = *sum.words();
        for sum in [&sum, &one_by_one(&all), &stored, &copied] {
            assert!(sum.value() == plain || sum.value().is_nan() && plain.is_nan(), "{special:?}: {}", sum.value());
        }
        assert!(stored == sum);
    }
}

#[test]
fn words_of_parts_add_up_to_those_of_the_whole() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(2);
    let all = numbers(4000, -60, 60, &mut random);
    let whole = one_by_one(&all);
    let mut parts: Vec<ExactSum> = all.chunks(37).map(one_by_one).collect();
    let mut merged = ExactSum::default();
    parts.iter().for_each(|part| merged.merge(part));
    let mut words = [0_i64; WORDS];
    for part in &mut parts {
        words.iter_mut().zip(part.words()).for_each(|(sum, word)| *sum += *word);
    }
    let mut added = ExactSum::default();
    *added.words() = words;
    // adds as many sums as a machine may have processes
    let mut one = one_by_one(&[-1.5, 1e-300]);
    let mut many = ExactSum::default();
    let own = *one.words();
    many.words().iter_mut().zip(own).for_each(|(sum, word)| *sum = word << 20);
    many.add(0.5);
    assert_eq!(many.value(), reference(&[-1.5 * 1_048_576.0, 1e-300 * 1_048_576.0, 0.5]));
    assert!(merged == whole && added == whole && added.value() == whole.value());
    added.add(1.0);
    assert_eq!(added.value(), reference(&all.iter().copied().chain([1.0]).collect::<Vec<f64>>()));
    // a sum minus the sum of its first terms is the sum of the later terms
    let before = one_by_one(&all[..1234]);
    assert!(whole.less(&before) == one_by_one(&all[1234..]) && whole.less(&whole).value() == 0.0);
}

#[test]
fn a_sum_is_stored_in_a_few_bytes_and_goes_on() {
    let numbers: Vec<f64> = (0..5000).map(|k| -1e-9 * f64::from(k)).collect();
    let mut sum = one_by_one(&numbers);
    let stored = crate::stored::Stored::of(&sum).unwrap();
    let mut turned = ExactSum::default();
    add_all(&mut turned, &numbers.iter().rev().copied().collect::<Vec<f64>>());
    assert_eq!(crate::stored::Stored::of(&turned).unwrap(), stored);
    assert!(stored.as_bytes().len() < 30, "{}", stored.as_bytes().len());
    let mut read: ExactSum = stored.read().unwrap();
    assert!(read == sum);
    [&mut sum, &mut read].into_iter().for_each(|sum| (0..3000).for_each(|k| sum.add(f64::from(k))));
    assert!(read == sum && read.value() == sum.value());
    assert_eq!(crate::stored::Stored::of(&ExactSum::default()).unwrap().as_bytes().len(), 1);
    assert!(crate::stored::Stored::of(&vec![(70_u8, 1_i64)]).unwrap().read::<ExactSum>().is_err());
}

#[test]
fn zeros_of_either_sign_are_condensed() {
    // values as in contacts that lose no energy
    let mut rows: Vec<[f64; 3]> =
        (0..32).map(|k| [0.1 * f64::from(k), -0.0, if k % 2 == 0 { 0.0 } else { -0.0 }]).collect();
    let numbers: Vec<f64> = rows.iter().map(|row| row[0]).collect();
    let mut few = Vec::new();
    condense(&mut rows, &mut few);
    assert_eq!((rows.len(), few.len()), (0, 2));
    let mut sums = none::<3>();
    add_rows(sums.each_mut(), &few);
    assert_eq!(values(&sums), [one_by_one(&numbers).value(), 0.0, 0.0]);
}

#[test]
fn the_largest_of_numbers_is_found_beside_their_sum() {
    // numbers of terms at the ends of blocks and of lanes, and in more than one chunk
    for count in [0usize, 1, 3, 4, 511, 513, 20_001] {
        let numbers: Vec<f64> = (0..count).map(|k| (0.754_877_7 * k as f64).fract()).collect();
        let largest = numbers.iter().copied().fold(0.0, f64::max);
        for shift in [0, 1, count / 2, count.saturating_sub(1)] {
            let mut numbers = numbers.clone();
            numbers.rotate_left(shift.min(count));
            let (all, most) = sum_and_largest(&numbers, |x| *x);
            assert_eq!((all.value(), most), (sum(&numbers, |x| *x).value(), largest), "{count} {shift}");
            if let Some(last) = numbers.last_mut() {
                *last = 2.0;
                assert_eq!(sum_and_largest(&numbers, |x| *x).1, 2.0);
            }
            if let Some(first) = numbers.first_mut() {
                *first = f64::NAN;
                assert_eq!(sum_and_largest(&numbers, |x| *x).1, f64::INFINITY);
            }
        }
    }
}
