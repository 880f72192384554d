//! Do two runs give the same profiles, within what their errors allow to say?

use super::errors::{Estimate, degrees_of_freedom, two_sided_tail};
use super::profiles::{ProfileTable, SliceRow};
use serde::Serialize;
use std::fmt;

/// Deviations beyond this many standard errors are counted.
const COUNTED: f64 = 3.0;
/// A comparison of identical systems says "differ" in one case out of this, and "doubtful" of a quantity in one of this.
const ONE_IN: f64 = 100.0;
/// What is compared: name, unit, and which estimate of a row.
const QUANTITIES: [(&str, &str); 10] = [
    ("number_density_ratio", ""),
    ("U", "m/s"),
    ("V", "m/s"),
    ("W", "m/s"),
    ("uu", "m²/s²"),
    ("vv", "m²/s²"),
    ("ww", "m²/s²"),
    ("uv", "m²/s²"),
    ("uw", "m²/s²"),
    ("vw", "m²/s²"),
];

/// The difference of one quantity in one slice, in the unit of the quantity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Name of the quantity, as in the columns of `profiles.csv`.
    pub quantity: &'static str,
    /// Number of the slice, from 0.
    pub slice: usize,
    /// [m] centre of the slice.
    pub y: f64,
    /// First minus second.
    pub difference: f64,
    /// Its standard error, from the errors of both (the runs are taken to be independent).
    pub error: f64,
    /// [-] difference / error, with its sign; infinite where values differ that show no scatter.
    pub standard_errors: f64,
}

/// How well two sets of values agree, from best to worst.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// No more deviation than chance explains.
    Agree,
    /// There are no error bars to judge by.
    Unknown,
    /// More deviation than chance gives in 1 % of cases, for a single quantity; one in ten quantities may look so.
    Doubtful,
    /// More than chance gives in 1 % of cases for all quantities together.
    Differ,
}

/// One quantity over all slices.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct QuantityComparison {
    /// Name of the quantity, as in the columns of `profiles.csv`.
    pub quantity: &'static str,
    /// Its unit, empty for none.
    pub unit: &'static str,
    /// All slices in which both runs have a value and an error.
    pub differences: Vec<Difference>,
    /// Slices beyond 3 standard errors.
    pub beyond: usize,
    /// [-] slices expected beyond 3 standard errors by chance (Student's t; the errors are estimates themselves).
    pub expected_beyond: f64,
    /// The largest deviation in standard errors, and where.
    pub largest: Option<Difference>,
    /// [-] sum over slices of |difference| over the sum of the scale: the value itself for number density and normal
    /// stresses, the rms velocity (mean included) for U, V, W, the root of both normal stresses for shear stresses.
    /// Contains the noise.
    pub mean_relative: f64,
    /// [-] the same of the signed difference: a common offset, in which noise averages out.
    pub offset: f64,
    /// [-] sum over slices of the squared deviation in standard errors. Neighbouring slices are correlated, so this does
    /// not follow a chi-square law; its expectation does not depend on that.
    pub chi_square: f64,
    /// [-] expectation of `chi_square` for equal systems.
    pub expected_chi_square: f64,
    /// The judgement.
    pub verdict: Verdict,
    /// The judgement in words.
    pub sentence: String,
}

/// Two runs compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Number density, U, V, W and the six second moments; empty if the tables do not have the same slices.
    pub quantities: Vec<QuantityComparison>,
    /// The worst of the judgements.
    pub verdict: Verdict,
    /// The judgement in words.
    pub sentence: String,
}

/// Compares two tables slice by slice.
///
/// A quantity differs if its largest deviation, or its root mean square deviation, has less than a 1 % chance in equal
/// systems with ten quantities looked at (largest: the slices count as that many independent trials, which errs to the
/// safe side as they are correlated; root mean square: as if all slices were one, the same). It is doubtful at 1 % for
/// this quantity alone, or when more slices lie beyond 3 standard errors than independent slices would in 1 % of cases.
pub fn compare(a: &ProfileTable, b: &ProfileTable) -> Comparison {
    let close = |p: &SliceRow, q: &SliceRow| (p.y - q.y).abs() <= 1e-9 * p.y.abs().max(q.y.abs());
    if a.slices.len() != b.slices.len() || !a.slices.iter().zip(&b.slices).all(|(p, q)| close(p, q)) {
        let sentence = "The profiles have different slices and cannot be compared.".to_owned();
        return Comparison { quantities: Vec::new(), verdict: Verdict::Unknown, sentence };
    }
    let quantities: Vec<_> = (0..QUANTITIES.len()).map(|which| quantity(which, a, b)).collect();
    let verdict = quantities.iter().map(|q| q.verdict).max().unwrap_or(Verdict::Unknown);
    let worst: Vec<&str> = quantities.iter().filter(|q| q.verdict == verdict).map(|q| in_prose(q.quantity)).collect();
    let names = worst.join(", ");
    let sentence = match verdict {
        Verdict::Agree => "All profiles agree within the stated error bars.".to_owned(),
        Verdict::Unknown => format!("No judgement: there are no error bars for {names}."),
        Verdict::Doubtful => format!(
            "The profiles agree within the stated error bars, with doubt about {names}; a longer run would tell (one in \
             ten comparisons of equal systems looks so)."
        ),
        Verdict::Differ => format!("The profiles differ beyond the stated error bars in {names}."),
    };
    let sentence = sentence + &counted(&quantities);
    Comparison { quantities, verdict, sentence }
}

/// How many slices lie far apart, and how many of them chance explains; empty without error bars.
fn counted(quantities: &[QuantityComparison]) -> String {
    let (mut slices, mut beyond, mut expected) = (0, 0, 0.0);
    for quantity in quantities {
        slices += quantity.differences.len();
        beyond += quantity.beyond;
        expected += quantity.expected_beyond;
    }
    if slices == 0 {
        return String::new();
    }
    format!(
        " {beyond} of {slices} slices are more than 3 standard errors apart; chance makes {expected:.1} of them so."
    )
}

/// The estimate of a quantity in a row.
fn pick(which: usize, row: &SliceRow) -> Option<Estimate> {
    match which {
        0 => row.number_density_ratio,
        1..=3 => row.mean[which - 1],
        _ => row.second[which - 4],
    }
}

/// The size that a difference of a quantity is set against.
fn scale(which: usize, row: &SliceRow) -> Option<f64> {
    let second = |k: usize| row.second[k].map(|found| found.value);
    Some(match which {
        1..=3 => (row.mean[which - 1]?.value.powi(2) + second(which - 1)?).sqrt(),
        7 => (second(0)? * second(1)?).sqrt(),
        8 => (second(0)? * second(2)?).sqrt(),
        9 => (second(1)? * second(2)?).sqrt(),
        _ => pick(which, row)?.value.abs(),
    })
}

fn quantity(which: usize, a: &ProfileTable, b: &ProfileTable) -> QuantityComparison {
    let (name, unit) = QUANTITIES[which];
    let (nu_a, nu_b) = (degrees_of_freedom(a.blocks), degrees_of_freedom(b.blocks));
    let mut differences = Vec::new();
    let (mut absolute, mut signed, mut scales) = (0.0, 0.0, 0.0);
    let (mut beyond, mut expected_beyond, mut chi_square, mut expected_chi_square) = (0, 0.0, 0.0, 0.0);
    let mut largest: Option<(Difference, f64)> = None;
    let mut least_freedom = f64::INFINITY;
    for (slice, (p, q)) in a.slices.iter().zip(&b.slices).enumerate() {
        let (Some(x), Some(y)) = (pick(which, p), pick(which, q)) else { continue };
        let (Some(scale_p), Some(scale_q)) = (scale(which, p), scale(which, q)) else { continue };
        let (Some(x_error), Some(y_error)) = (x.error, y.error) else { continue };
        let error = x_error.hypot(y_error);
        let difference = x.value - y.value;
        let standard_errors = if difference.abs() <= 1e-12 * x.value.abs().max(y.value.abs()) {
            0.0 // rounding, even where there is no scatter at all
        } else {
            difference / error
        };
        // Welch and Satterthwaite: how well the sum of both variances is known
        let freedom = if error > 0.0 {
            let (s, t) = ((x_error / error).powi(4) / nu_a, (y_error / error).powi(4) / nu_b);
            1.0 / (s + t)
        } else {
            nu_a + nu_b
        };
        let one = Difference { quantity: name, slice, y: p.y, difference, error, standard_errors };
        if largest.is_none_or(|(l, _)| standard_errors.abs() > l.standard_errors.abs()) {
            largest = Some((one, freedom));
        }
        least_freedom = least_freedom.min(freedom);
        beyond += usize::from(standard_errors.abs() > COUNTED);
        expected_beyond += two_sided_tail(COUNTED, freedom);
        chi_square += standard_errors * standard_errors;
        expected_chi_square += if freedom > 2.0 { freedom / (freedom - 2.0) } else { f64::INFINITY };
        absolute += difference.abs();
        signed += difference;
        scales += 0.5 * (scale_p + scale_q);
        differences.push(one);
    }
    let ratio = |sum: f64| if sum == 0.0 { 0.0 } else { sum / scales };
    let mut found = QuantityComparison {
        quantity: name,
        unit,
        beyond,
        expected_beyond,
        largest: largest.map(|(l, _)| l),
        mean_relative: ratio(absolute),
        offset: ratio(signed),
        chi_square,
        expected_chi_square,
        verdict: Verdict::Unknown,
        sentence: String::new(),
        differences,
    };
    if let Some((top, freedom)) = largest {
        let count = found.differences.len() as f64;
        let by_largest = (count * two_sided_tail(top.standard_errors, freedom)).min(1.0);
        let by_square = two_sided_tail((chi_square / count).sqrt(), least_freedom);
        let chance = by_largest.min(by_square);
        found.verdict = if chance * QUANTITIES.len() as f64 * ONE_IN < 1.0 {
            Verdict::Differ
        } else if chance * ONE_IN < 1.0
            || at_least(beyond, found.differences.len(), expected_beyond / count) * ONE_IN < 1.0
        {
            Verdict::Doubtful
        } else {
            Verdict::Agree
        };
    }
    found.sentence = sentence(&found, unit);
    found
}

/// Probability of `hits` or more in `trials` independent trials.
fn at_least(hits: usize, trials: usize, chance: f64) -> f64 {
    let (mut term, mut below) = ((1.0 - chance).powi(trials as i32), 0.0);
    for k in 0..hits {
        below += term;
        term *= (trials - k) as f64 / (k + 1) as f64 * chance / (1.0 - chance);
    }
    (1.0 - below).clamp(0.0, 1.0)
}

/// A column of `profiles.csv` as a sentence names it.
fn in_prose(quantity: &str) -> &str {
    if quantity == QUANTITIES[0].0 { "the number density" } else { quantity }
}

fn sentence(found: &QuantityComparison, unit: &str) -> String {
    let Some(top) = found.largest else {
        return format!("{}: no judgement, there are no error bars.", in_prose(found.quantity));
    };
    let opening = match found.verdict {
        Verdict::Agree | Verdict::Unknown => "agrees within the stated error bars",
        Verdict::Doubtful => "is doubtful: deviates more than chance would in 1 % of cases",
        Verdict::Differ => "differs beyond the stated error bars",
    };
    let space = if unit.is_empty() { "" } else { " " };
    format!(
        "{} {opening}: {} of {} slices beyond 3 standard errors ({:.1} expected by chance), the largest deviation {} \
         standard errors ({:+.2e}{space}{unit}) at y = {:.4} m, {:+.2} % on the whole.",
        found.quantity,
        found.beyond,
        found.differences.len(),
        found.expected_beyond,
        Short(top.standard_errors),
        top.difference,
        top.y,
        100.0 * found.offset,
    )
}

/// A number of standard errors, signed, to one digit.
struct Short(f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_infinite() { write!(f, "infinitely many") } else { write!(f, "{:+.1}", self.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    const SLICES: usize = 40;

    /// A table of 24 blocks, each value with an error of 0.01, itself known as well as 8 degrees of freedom allow.
    fn table(random: &mut Xoshiro256PlusPlus) -> ProfileTable {
        let mut normal = || -> f64 { StandardNormal.sample(random) };
        let mut estimate = |value: f64| {
            let spread = (0..8).map(|_| normal().powi(2)).sum::<f64>() / 8.0;
            Some(Estimate { value: value + 0.01 * normal(), error: Some(0.01 * spread.sqrt()) })
        };
        let slices = (0..SLICES).map(|k| SliceRow {
            y: (k as f64 + 0.5) * 1e-3,
            number_density_ratio: estimate(1.0),
            mean: [12.0, 0.0, 0.0].map(&mut estimate),
            second: [1.0, 0.2, 0.2, -0.1, 0.0, 0.0].map(&mut estimate),
            ..SliceRow::default()
        });
        ProfileTable { slices: slices.collect(), blocks: 24, from: 1.0, until: 5.0 }
    }

    #[test]
    fn equal_systems_agree() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(8);
        let (mut differ, mut doubtful, mut beyond, mut expected, mut ratio) = (0, 0, 0, 0.0, 0.0);
        for _ in 0..500 {
            let found = compare(&table(&mut random), &table(&mut random));
            differ += u32::from(found.verdict == Verdict::Differ);
            doubtful += u32::from(found.verdict == Verdict::Doubtful);
            for q in &found.quantities {
                assert_eq!(q.differences.len(), SLICES);
                beyond += q.beyond;
                expected += q.expected_beyond;
                ratio += q.chi_square / q.expected_chi_square / 5000.0;
            }
        }
        println!(
            "{differ} differ, {doubtful} doubtful of 500; {beyond} slices beyond 3, {expected:.0} expected; {ratio:.3}"
        );
        assert!(differ <= 12, "1 % of 500 should be wrong at most: {differ}");
        assert!(doubtful <= 125, "{doubtful}");
        assert!((0.7..1.3).contains(&(beyond as f64 / expected)), "{beyond} {expected}");
        assert!((0.9..1.1).contains(&ratio), "{ratio}");
    }

    #[test]
    fn a_difference_in_one_slice_or_in_all_is_found() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(9);
        let (mut local, mut common) = (0, 0);
        for _ in 0..100 {
            let a = table(&mut random);
            let mut b = table(&mut random);
            b.slices[7].mean[0].as_mut().unwrap().value += 0.2;
            let found = compare(&a, &b);
            let u = &found.quantities[1];
            let at = u.largest.map(|l| (l.slice, l.difference < 0.0));
            local += u32::from(found.verdict == Verdict::Differ && at == Some((7, true)));
            let mut b = table(&mut random);
            b.slices.iter_mut().for_each(|s| s.second[1].as_mut().unwrap().value *= 1.4);
            let found = compare(&a, &b);
            let vv = &found.quantities[5];
            common += u32::from(vv.verdict == Verdict::Differ && (-0.40..-0.27).contains(&vv.offset));
            assert!(found.sentence.contains("vv"), "{}", found.sentence);
        }
        println!("local {local}, common {common} of 100");
        assert!(local >= 90 && common >= 95, "{local} {common}");
    }

    #[test]
    fn what_cannot_be_judged_is_said() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(10);
        let a = table(&mut random);
        let same = compare(&a, &a);
        assert!(same.verdict == Verdict::Agree && same.quantities.iter().all(|q| q.chi_square == 0.0));
        let words = "All profiles agree within the stated error bars. 0 of 400 slices are more than 3 standard errors apart; chance";
        assert!(same.sentence.starts_with(words), "{}", same.sentence);
        let mut blind = a.clone();
        blind.slices.iter_mut().for_each(|s| s.mean[0].as_mut().unwrap().error = None);
        let found = compare(&a, &blind);
        assert_eq!((found.verdict, found.quantities[1].verdict), (Verdict::Unknown, Verdict::Unknown));
        assert!(found.sentence.contains("error bars for U"), "{}", found.sentence);
        let mut other = a.clone();
        other.slices.pop();
        assert!(compare(&a, &other).quantities.is_empty());
        // a slice that one run leaves empty is skipped, not taken for a difference
        let mut empty = a.clone();
        empty.slices[0].mean = [None; 3];
        let found = compare(&a, &empty);
        assert_eq!((found.verdict, found.quantities[1].differences.len()), (Verdict::Agree, SLICES - 1));
        // values without scatter that differ all the same
        let mut still = a.clone();
        let mut moved = a.clone();
        still.slices[3].mean[2] = Some(Estimate::exact(0.0));
        moved.slices[3].mean[2] = Some(Estimate::exact(1.0));
        let found = compare(&still, &moved);
        assert_eq!(found.verdict, Verdict::Differ);
        assert!(found.quantities[3].sentence.contains("infinitely many"), "{}", found.quantities[3].sentence);
        let none = compare(&ProfileTable::default(), &ProfileTable::default());
        assert_eq!(none.verdict, Verdict::Unknown);
    }
}
