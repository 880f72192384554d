//! Comparison of two runs. The result is one of three answers for each observable, and one answer for all observables
//! together.

use super::batches::Prior;
use super::difference::{EQUIVALENCE_LEVEL, Folded, Observable, Tested};
use serde::Serialize;

/// [-] probability that a difference in any observable is found although the two systems are equal.
pub const LEVEL: f64 = 0.01;

/// Probabilities of the two wrong answers, "different" and "equivalent".
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorLevels {
    /// [-] probability that a difference in any observable is found although the two systems are equal.
    pub difference: f64,
    /// [-] probability that two systems are called equivalent although they differ at one position by the margin, the
    /// largest accepted difference.
    pub equivalence: f64,
}

impl ErrorLevels {
    /// Levels of the interim test with number `look` (from 1) in a sequence of at most `looks` equally spaced tests.
    /// Each test gets a share of the total level by the spending function α t², where t is the share of the tests done
    /// (Lan & DeMets 1983; Kim & DeMets 1987). The probability of any wrong answer in all tests is at most that of a
    /// single test, for any dependence between the tests.
    pub fn of_look(look: usize, looks: usize) -> Self {
        let spent = |look: usize| (look as f64 / looks.max(1) as f64).powi(2);
        let share = spent(look) - spent(look.saturating_sub(1));
        let whole = Self::default();
        Self { difference: share * whole.difference, equivalence: share * whole.equivalence }
    }
}

impl Default for ErrorLevels {
    /// Levels of a single test: 1 % and 5 %.
    fn default() -> Self {
        Self { difference: LEVEL, equivalence: EQUIVALENCE_LEVEL }
    }
}

/// Answer of a comparison, from the most favourable to the least favourable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// At every position the difference is shown to be smaller than the margin (the largest accepted difference), at
    /// the level of 5 % (two one-sided tests).
    Equivalent,
    /// Neither equivalence nor a difference is shown by the tests.
    Unresolved,
    /// A difference is found, at the level of 1 % for all observables together. It is not shown to be within the
    /// margin, the largest accepted difference.
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

/// One observable of two runs, with the results of its tests and the answer that follows from them.
#[derive(Clone, Debug, Serialize)]
pub struct Judged {
    /// Results of the tests of this observable.
    #[serde(flatten)]
    pub tested: Tested,
    /// True if a difference is found, at the level of 1 % for all observables together (Holm 1979).
    pub detected: bool,
    /// Answer for this observable: equivalent, unresolved or different.
    pub answer: Answer,
    /// [-] smallest margin (accepted difference), over the scale of the observable, with which the answer would be
    /// "equivalent".
    pub reached: f64,
    /// [-] smallest margin (accepted difference), over the scale of the observable, with which the answer would be
    /// "equivalent" if the difference is smooth across the profile.
    pub reached_smooth: f64,
    /// [-] interval, over the scale of the observable, that contains the differences at all positions. If both its ends
    /// are within the margin, the largest accepted difference, the observable is equivalent.
    pub interval: [f64; 2],
    /// True if a one-sided test shows that the difference named first by a report exceeds the margin, the largest
    /// accepted difference.
    pub beyond: bool,
    /// [-] smallest smooth difference, relative to the scale, that would be found in 80 % of cases.
    pub detectable: f64,
    /// [-] factor by which the run would have to be longer to show equal systems equivalent in all observables in 80 %
    /// of cases.
    pub stretch: f64,
}

/// Comparison of two runs in several observables.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// Answer for all observables together: the worst of their answers, where "different" is the worst.
    pub answer: Answer,
    /// [-] requested margin: largest difference that is accepted, over the scale of each observable.
    pub margin: f64,
    /// Observables with error bars, each with its answer.
    pub judged: Vec<Judged>,
    /// Names of observables without error bars, for which there is no answer.
    pub unknown: Vec<String>,
}

impl Comparison {
    /// Observables in which the tests find a difference between the two runs, the most significant first.
    pub fn detected(&self) -> Vec<&Judged> {
        let mut found: Vec<&Judged> = self.judged.iter().filter(|one| one.detected).collect();
        found.sort_by(|a, b| a.tested.chance.total_cmp(&b.tested.chance));
        found
    }
}

/// Compares two runs in a list of observables, which has the same order for both runs. `margin` [-] is the largest
/// accepted difference, over the scale of each observable.
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

/// Margin and error levels with which each of several observables is tested for equivalence.
struct EquivalenceTest {
    margin: f64,
    /// [-] level of the test for a difference in one observable.
    level: f64,
    /// [-] level of each one-sided test of equivalence.
    equivalence: f64,
    /// Number of positions, over all observables, that have to be shown equivalent.
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

/// Significance of several tests with the probabilities `chances` [-], by Holm's procedure (1979): true for each
/// significant one. The probability of any false result is `level` [-]. The smallest of m probabilities must be below
/// level/m, the next one below level/(m - 1), and so on. The procedure ends at the first probability that is too large.
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
