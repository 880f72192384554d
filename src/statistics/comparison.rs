//! Two runs compared: one of three answers for each observable, and for all of them together.

use super::batches::Prior;
use super::difference::{Folded, Observable, Tested};
use serde::Serialize;

/// [-] chance that any difference at all is found between two equal systems.
pub const LEVEL: f64 = 0.01;

/// What a comparison comes to, from best known to worst.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// Any difference is smaller than the margin, at 5 % (two one-sided tests).
    Equivalent,
    /// Neither is shown.
    Unresolved,
    /// There is a difference, at 1 % for all observables together, and it is not shown to be within the margin.
    Different,
}

impl Answer {
    /// The word that stands for it in `summary.json`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Equivalent => "equivalent",
            Self::Unresolved => "unresolved",
            Self::Different => "different",
        }
    }
}

/// One observable of two runs, judged.
#[derive(Clone, Debug, Serialize)]
pub struct Judged {
    /// The test.
    #[serde(flatten)]
    pub tested: Tested,
    /// Whether there is a difference, at 1 % for all observables together (Holm 1979).
    pub detected: bool,
    /// The answer for this observable.
    pub answer: Answer,
    /// [-] the smallest margin within which it is equivalent, over the scale.
    pub reached: f64,
    /// [-] the smallest smooth difference that is found in 80 % of cases, over the scale.
    pub detectable: f64,
    /// [-] how many times as long a run would show systems that are equal to be equivalent, in 80 % of cases.
    pub stretch: f64,
}

/// Two runs compared.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// The answer for all observables together: the worst of theirs, with "different" the worst.
    pub answer: Answer,
    /// [-] the margin asked for, over the scale of each observable.
    pub margin: f64,
    /// What could be judged.
    pub judged: Vec<Judged>,
    /// Names of what has no error bars, so that nothing can be said of it.
    pub unknown: Vec<&'static str>,
}

impl Comparison {
    /// Those with a difference, the clearest first.
    pub fn detected(&self) -> Vec<&Judged> {
        let mut found: Vec<&Judged> = self.judged.iter().filter(|one| one.detected).collect();
        found.sort_by(|a, b| a.tested.chance.total_cmp(&b.tested.chance));
        found
    }
}

/// Compares two runs in the same observables, given in the same order. `margin` [-]: over the scale of each.
pub fn compare(a: &[Observable], b: &[Observable], margin: f64) -> Comparison {
    let folded: Vec<Option<Folded>> = a.iter().zip(b).map(|(a, b)| Folded::new(a, b)).collect();
    let prior = Prior::of(&folded.iter().flatten().flat_map(Folded::correlations).collect::<Vec<_>>());
    let tested: Vec<Option<Tested>> = folded.iter().map(|one| one.as_ref()?.test(prior)).collect();
    let unknown: Vec<&'static str> =
        a.iter().zip(&tested).filter(|(_, tested)| tested.is_none()).map(|(a, _)| a.name).collect();
    let tested: Vec<Tested> = tested.into_iter().flatten().collect();
    let detected = holm(&tested.iter().map(|one| one.chance).collect::<Vec<_>>(), LEVEL);
    let level = LEVEL / tested.len().max(1) as f64;
    let judged: Vec<Judged> =
        tested.into_iter().zip(detected).map(|(tested, detected)| judge(tested, detected, margin, level)).collect();
    let tested_less = !unknown.is_empty();
    let worst = judged.iter().map(|one| one.answer).max();
    let answer = match worst {
        Some(Answer::Equivalent) if tested_less => Answer::Unresolved,
        Some(worst) => worst,
        None => Answer::Unresolved,
    };
    Comparison { answer, margin, judged, unknown }
}

fn judge(tested: Tested, detected: bool, margin: f64, level: f64) -> Judged {
    let over = |value: f64| if tested.scale > 0.0 { value / tested.scale } else { f64::INFINITY };
    // a place that was found to differ by itself must be within the margin as well: smooth shapes follow it in part only
    let at_a_place = detected && tested.local_chance.is_some_and(|chance| chance <= level);
    let bound = if at_a_place { tested.bound.max(tested.local_bound()) } else { tested.bound };
    let exact = bound == 0.0;
    let reached = if exact { 0.0 } else { over(bound) };
    let answer = if exact || reached < margin {
        Answer::Equivalent
    } else if detected {
        Answer::Different
    } else {
        Answer::Unresolved
    };
    let detectable = if exact { 0.0 } else { over(tested.detectable(level)) };
    let stretch = if exact { 0.0 } else { (over(tested.usual_bound) / margin).powi(2) };
    Judged { tested, detected, answer, reached, detectable, stretch }
}

/// Which of several tests find something, at a chance of `level` [-] for any false finding at all (Holm 1979): the smallest
/// chance must be below level/m, the next below level/(m - 1), and so on; the first that is not ends it.
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
