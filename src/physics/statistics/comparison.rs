//! Comparison of two runs in several observables. The possible answers are equivalent, different and unresolved. There
//! is one answer for each observable, and one for all observables together.

use super::batches::Prior;
use super::difference::{EQUIVALENCE_LEVEL, Folded, Observable, Tested};
use serde::Serialize;

/// [-] default probability that a difference in any observable is found although the two systems are equal.
pub const LEVEL: f64 = 0.01;

/// Accepted probabilities of the two wrong answers of a comparison, "different" and "equivalent".
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorLevels {
    /// [-] probability that a difference in any observable is found although the two systems are equal.
    pub difference: f64,
    /// [-] probability of the answer "equivalent" for two systems that differ at one position by the margin, the
    /// largest accepted difference.
    pub equivalence: f64,
}

impl ErrorLevels {
    /// Error levels (accepted probabilities of the wrong answers) of one test in a sequence of at most `looks` equally
    /// spaced interim tests. `look` is the number of the test, counted from 1. Each test gets a share of the total
    /// level by the spending function α t², where t is the share of the tests done and α the total level (Lan & DeMets
    /// 1983; Kim & DeMets 1987). The probability of any wrong answer in all tests is at most that of a single test,
    /// for any dependence between the tests.
    pub fn of_look(look: usize, looks: usize) -> Self {
        let spent = |look: usize| (look as f64 / looks.max(1) as f64).powi(2);
        let share = spent(look) - spent(look.saturating_sub(1));
        let whole = Self::default();
        Self { difference: share * whole.difference, equivalence: share * whole.equivalence }
    }
}

impl Default for ErrorLevels {
    /// Error levels of a single test: 1 % for the answer "different" and 5 % for "equivalent".
    fn default() -> Self {
        Self { difference: LEVEL, equivalence: EQUIVALENCE_LEVEL }
    }
}

/// Answer of a comparison of two runs, in the order from the most favourable to the least favourable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// The difference is shown to be smaller than the margin (the largest accepted difference) at every position, at
    /// the level of 5 % (two one-sided tests).
    Equivalent,
    /// The tests show neither equivalence nor a difference.
    Unresolved,
    /// A difference is found, at the level of 1 % for all observables together. The difference is not shown to be
    /// smaller than the margin, the largest accepted difference.
    Different,
}

impl Answer {
    /// Answer as a word for `summary.json`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Equivalent => "equivalent",
            Self::Unresolved => "unresolved",
            Self::Different => "different",
        }
    }
}

/// One observable of two runs, with the results of its tests and the answer.
#[derive(Clone, Debug, Serialize)]
pub struct Judged {
    /// Results of the tests of this observable.
    #[serde(flatten)]
    pub tested: Tested,
    /// True if a difference is found, at the level of 1 % for all observables together, or at a lower one with several
    /// interim tests (Holm 1979).
    pub detected: bool,
    /// Answer for this observable.
    pub answer: Answer,
    /// [-] smallest margin (largest accepted difference), divided by the scale of the observable, with which the answer
    /// would be "equivalent".
    pub reached: f64,
    /// [-] smallest margin (largest accepted difference), divided by the scale of the observable, with which the answer
    /// would be "equivalent" if the difference changed smoothly from slice to slice.
    pub reached_smooth: f64,
    /// [-] interval that contains the differences at all positions, divided by the scale of the observable. If both
    /// ends are smaller than the margin (the largest accepted difference) in magnitude, the observable is equivalent.
    pub interval: [f64; 2],
    /// True if a one-sided test shows that the difference exceeds the margin, the largest accepted difference. The
    /// test is done for the difference that a report names first ([`Tested::headline`]).
    pub beyond: bool,
    /// [-] smallest smooth difference, divided by the scale of the observable, that the tests would find in 80 % of
    /// cases.
    pub detectable: f64,
    /// [-] factor by which the run would have to be longer, so that equal systems would be shown to be equivalent in
    /// all observables in 80 % of cases.
    pub stretch: f64,
}

/// Comparison of two runs in several observables.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// Answer for all observables together: the least favourable of their answers. If some observable has no error
    /// bars, this answer is `Unresolved` or `Different`.
    pub answer: Answer,
    /// [-] largest difference that counts as equivalent, divided by the scale of each observable.
    pub margin: f64,
    /// Observables with error bars, each with its tests and its answer.
    pub judged: Vec<Judged>,
    /// Names of observables without error bars, which have no answer.
    pub unknown: Vec<String>,
}

impl Comparison {
    /// Observables in which the tests find a difference between the two runs, the most significant observable first.
    pub fn detected(&self) -> Vec<&Judged> {
        let mut found: Vec<&Judged> = self.judged.iter().filter(|one| one.detected).collect();
        found.sort_by(|a, b| a.tested.chance.total_cmp(&b.tested.chance));
        found
    }
}

/// Compares two runs in several observables, which have the same order in `a` and `b`. `margin` [-] is the largest
/// accepted difference, divided by the scale of each observable.
pub fn compare(a: &[Observable], b: &[Observable], margin: f64, levels: ErrorLevels) -> Comparison {
    let folded: Vec<Option<Folded>> = a.iter().zip(b).map(|(a, b)| Folded::new(a, b)).collect();
    let prior = Prior::of(&folded.iter().flatten().flat_map(Folded::correlations).collect::<Vec<_>>());
    let tested: Vec<Option<Tested>> = folded.iter().map(|one| one.as_ref()?.test(prior, levels.equivalence)).collect();
    let unknown: Vec<String> =
        a.iter().zip(&tested).filter(|(_, tested)| tested.is_none()).map(|(a, _)| a.name.to_string()).collect();
    let tested: Vec<Tested> = tested.into_iter().flatten().collect();
    let detected = holm(&tested.iter().map(|one| one.chance).collect::<Vec<_>>(), levels.difference);
    let asked = EquivalenceTest {
        margin,
        level: levels.difference / tested.len().max(1) as f64,
        equivalence: levels.equivalence,
        places: tested.iter().map(Tested::scattering).sum(),
    };
    let judged: Vec<Judged> =
        tested.into_iter().zip(detected).map(|(tested, detected)| asked.judge(tested, detected)).collect();
    let tested_less = !unknown.is_empty();
    let worst = judged.iter().map(|one| one.answer).max();
    let answer = match worst {
        Some(Answer::Equivalent) if tested_less => Answer::Unresolved,
        Some(worst) => worst,
        None => Answer::Unresolved,
    };
    Comparison { answer, margin, judged, unknown }
}

/// Margin of equivalence (largest accepted difference) and error levels, for the tests of one of several observables.
struct EquivalenceTest {
    margin: f64,
    /// [-] accepted probability of a false difference in the test of a single observable.
    level: f64,
    /// [-] accepted probability of a false result in each one-sided test for equivalence.
    equivalence: f64,
    /// Number of positions that must be shown to be equivalent, summed over all observables.
    places: usize,
}

impl EquivalenceTest {
    fn judge(&self, tested: Tested, detected: bool) -> Judged {
        let over = |value: f64| if tested.scale > 0.0 { value / tested.scale } else { f64::INFINITY };
        let exact = tested.bound == 0.0;
        let share = |value: f64| if exact { 0.0 } else { over(value) };
        let reached = share(tested.bound);
        let answer = if exact || reached < self.margin {
            Answer::Equivalent
        } else if detected {
            Answer::Different
        } else {
            Answer::Unresolved
        };
        let interval = tested.interval(self.equivalence).map(share);
        let beyond = tested
            .headline()
            .is_some_and(|one| one.difference.abs() - one.width(self.equivalence) > self.margin * tested.scale);
        let (reached_smooth, detectable) = (share(tested.smooth_bound), share(tested.detectable(self.level)));
        let stretch = (share(tested.width_needed(self.equivalence, self.places)) / self.margin).powi(2);
        Judged { tested, detected, answer, reached, reached_smooth, interval, beyond, detectable, stretch }
    }
}

/// Decides by Holm's procedure (1979) which of several tests are significant: true for a significant test. `chances`
/// [-] are the p-values of the tests (probabilities of such results if there is no difference). The probability of any
/// false result is `level` [-]. The smallest of m p-values must be at most level/m, the next at most level/(m - 1),
/// and so on. The procedure ends at the first p-value that is too large.
pub fn holm(chances: &[f64], level: f64) -> Vec<bool> {
    let mut order: Vec<usize> = (0..chances.len()).collect();
    order.sort_by(|&a, &b| chances[a].total_cmp(&chances[b]));
    let mut found = vec![false; chances.len()];
    for (rank, &place) in order.iter().enumerate() {
        if chances[place] * (chances.len() - rank) as f64 > level {
            break;
        }
        found[place] = true;
    }
    found
}
