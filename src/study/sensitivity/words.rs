//! Conclusions of a sensitivity study, as sentences. The margin is the largest shift that is accepted as equivalent.

use crate::output::numbers::{percent, quantity, significant, with_error};
use crate::output::sensitivity::{Factor, Shift};
use crate::statistics::{Answer, Estimate};
use crate::study::judge::{in_prose, margin_in_words};

/// Name of the factor that changes only the seed. Its shifts show the effect of chance.
const CHANCE: &str = "seed";

/// Sentences on the factor (change of the case) with the largest effect, the other factors beyond the margin (largest
/// accepted shift), the factors below the margin, the unresolved factors, and the effect of chance. `waiting` has the
/// names of factors whose runs are not complete.
pub fn sentences(factors: &[Factor], waiting: &[String], margin: f64) -> Vec<String> {
    let of = |answer: Answer| -> Vec<&Factor> {
        factors
            .iter()
            .filter(|factor| factor.stopped.is_none() && factor.answer == answer && factor.name != CHANCE)
            .collect()
    };
    let [different, equivalent, unresolved] = [Answer::Different, Answer::Equivalent, Answer::Unresolved].map(of);
    let within = margin_in_words(margin);
    let mut sentences = Vec::new();
    match different.split_first() {
        Some((first, rest)) => {
            sentences.push(format!(
                "What matters most is {} ({}): it shifts {}.",
                first.title,
                first.change,
                first.headline().map_or(String::new(), |shift| headline(shift, margin))
            ));
            if !rest.is_empty() {
                sentences.push(format!("Beyond the margin of {within} as well: {}.", list(rest, &|shift| size(shift))));
            }
        }
        None if equivalent.is_empty() => {
            sentences
                .push(format!("Everything is unresolved at a margin of {within}: longer runs or replicas are needed."));
        }
        None if unresolved.is_empty() => {
            sentences.push(format!("Nothing matters: no factor shifts anything beyond the margin of {within}."));
        }
        None => sentences.push(format!("Nothing is found to matter beyond the margin of {within}.")),
    }
    if !equivalent.is_empty() {
        sentences.push(format!("Below the margin: {}.", list(&equivalent, &|shift| size(shift))));
    }
    sentences.extend(open(&unresolved, &within));
    sentences.extend(factors.iter().find(|factor| factor.name == CHANCE).and_then(chance));
    let stopped = factors.iter().filter_map(|factor| {
        Some(format!("{} ({}) says nothing: {}.", capital(&factor.title), factor.change, factor.stopped.as_ref()?))
    });
    sentences.extend(stopped);
    if !waiting.is_empty() {
        sentences.push(format!("Not run yet: {}.", waiting.join(", ")));
    }
    sentences
}

/// Text of a shift, with its standard error and as a multiple of the margin (largest accepted shift). The shift is in
/// per cent of the scale of the observable (value by which its differences are divided).
fn headline(shift: &Shift, margin: f64) -> String {
    let times = significant(shift.share().abs() / margin, 2);
    format!("{} by {}, {times} times the margin of {}", where_(shift), share(shift), margin_in_words(margin))
}

/// Name of the observable of a shift, with an article, and the simulated time of the shift if it has one.
fn where_(shift: &Shift) -> String {
    let at = shift.time.map_or(String::new(), |time| format!(" at t = {}", quantity(time, "s", 3)));
    let name = in_prose(&shift.observable);
    // names of single numbers have no article of their own
    if name.starts_with("the ") { name + &at } else { format!("the {name}{at}") }
}

/// [-] largest shift that is attributed to rounding, divided by the scale of its observable.
const ROUNDING: f64 = 1e-9;

/// Text of a shift with its standard error, both in per cent of the scale of the observable; "nothing" if both are
/// below the rounding error.
fn share(shift: &Shift) -> String {
    if shift.share().abs() < ROUNDING && shift.share_error().is_none_or(|error| error < ROUNDING) {
        return "nothing".into();
    }
    let share = Estimate { value: 100.0 * shift.share(), error: shift.share_error().map(|error| 100.0 * error) };
    format!("{} % of {}", with_error(share), shift.scale_is)
}

fn size(shift: &Shift) -> String {
    format!("{} in {}", share(shift), where_(shift))
}

/// Text of the most important shift of a factor, in brackets; empty if the factor has no shift.
pub(super) fn in_size(factor: &Factor) -> String {
    factor.headline().map_or(String::new(), |shift| format!(" ({})", size(shift)))
}

/// List of the titles of factors (changes of the case), each with the text that the function `say` makes of its most
/// important shift.
fn list(factors: &[&Factor], say: &dyn Fn(&Shift) -> String) -> String {
    let one = |factor: &&Factor| {
        let said = factor.headline().map_or(String::new(), |shift| format!(" ({})", say(shift)));
        format!("{}{said}", factor.title)
    };
    factors.iter().map(one).collect::<Vec<_>>().join(", ")
}

pub(super) fn open(factors: &[&Factor], within: &str) -> Option<String> {
    if factors.is_empty() {
        return None;
    }
    let one = |factor: &&Factor| {
        let open = factor.shifts.iter().filter(|shift| shift.answer == Answer::Unresolved);
        let widest = open.filter_map(|shift| Some((shift, shift.reached?))).max_by(|a, b| a.1.total_cmp(&b.1));
        let said = match (factor.remarks.first(), widest) {
            (Some(why), _) => format!(" ({why})"),
            (None, Some((shift, reached))) => {
                format!(" (up to {} of {} in {})", percent(reached, 1.0), shift.scale_is, where_(shift))
            }
            (None, None) => String::new(),
        };
        format!("{}{said}", factor.title)
    };
    // a remark that holds for all factors is written once
    let same = factors[0].remarks.first().filter(|why| factors.iter().all(|other| other.remarks.first() == Some(why)));
    if let Some(why) = same {
        let names: Vec<&str> = factors.iter().map(|factor| factor.title.as_str()).collect();
        return Some(format!("Unresolved: {}: {why}.", names.join(", ")));
    }
    let stretch = factors.iter().flat_map(|factor| &factor.shifts).filter(|shift| shift.answer == Answer::Unresolved);
    let stretch = stretch.filter_map(|shift| shift.stretch).reduce(f64::max).filter(|stretch| stretch.is_finite());
    let advice = stretch.map_or(String::new(), |stretch| {
        let times = significant(stretch.max(2.0).ceil(), 2);
        format!(" About {times} times as long runs or as many replicas would show whether they are below {within}.")
    });
    Some(format!("Unresolved: {}.{advice}", factors.iter().map(one).collect::<Vec<_>>().join(", ")))
}

/// Sentence on the largest shift by another seed, which is the effect of chance. `None` if the factor has no shifts.
pub(super) fn chance(factor: &Factor) -> Option<String> {
    let widest = factor.shifts.iter().max_by(|a, b| a.share().abs().total_cmp(&b.share().abs()))?;
    Some(format!("Another seed alone shifts up to {}: that much is noise.", size(widest)))
}

pub(super) fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}
