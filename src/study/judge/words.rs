//! The answers of a comparison in words.

use crate::output::numbers::{counted, quantity, significant, with_error};
use crate::statistics::{Answer, Comparison, Deviation, Estimate, Judged, LARGEST_DRIFT, Steadiness};

/// Differences that are named after the clearest one; the table has them all.
const NAMED: usize = 3;

/// The names of two variants, quoted, as a sentence begins.
pub fn pair(variant: &str, reference: &str) -> String {
    format!("\"{variant}\" against \"{reference}\":")
}

/// A share in percent.
pub fn percent(share: f64) -> String {
    format!("{} %", significant(100.0 * share, 2))
}

/// What a sentence says of a run that is not called steady, after its name; nothing of one that is.
pub fn not_steady(steadiness: &Steadiness) -> Option<String> {
    let why = match steadiness.drift {
        _ if steadiness.steady => return None,
        None => return Some("has too few samples to tell whether it is steady, and too few for error bars".into()),
        Some(f64::INFINITY) => "it drifts, and has no scatter to compare the drift with".into(),
        Some(drift) if drift > LARGEST_DRIFT => {
            format!("the two halves of what is averaged differ by {} standard errors", significant(drift, 2))
        }
        Some(_) => "no steady start was found in its first half".into(),
    };
    Some(format!("is not steady ({why})"))
}

/// A margin in percent, as it would be typed.
pub fn margin(share: f64) -> String {
    let digits = format!("{:.4}", 100.0 * share);
    format!("{} %", digits.trim_end_matches('0').trim_end_matches('.'))
}

/// What a column of a table is called in a sentence.
pub fn in_prose(name: &str) -> String {
    match name {
        "number_density_ratio" => "the number density".into(),
        "U" => "the mean velocity U".into(),
        "uu" | "vv" | "ww" => format!("the normal stress {name}"),
        "uv" => "the shear stress uv".into(),
        other => other.into(),
    }
}

/// The answer of a comparison of averages or curves; `across`: the unit of the places, m or s. `needed`: what would decide,
/// for a run that is so many times as long.
pub fn answer(comparison: &Comparison, across: &str, needed: impl Fn(f64) -> String) -> String {
    let margin = margin(comparison.margin);
    let detected = comparison.detected();
    match comparison.answer {
        Answer::Equivalent => {
            let widest = comparison.judged.iter().max_by(|a, b| a.reached.total_cmp(&b.reached));
            let widest = widest.filter(|one| one.reached > 0.0).map_or("no difference at all".into(), |one| {
                format!("no difference beyond {} (in {})", percent(one.reached), in_prose(one.tested.name))
            });
            let found = detected.first().map_or(String::new(), |one| {
                format!(" A difference is seen, of {}: it is within the margin.", size(one, across))
            });
            format!("equivalent within {margin}: {widest}.{found}")
        }
        Answer::Different => different(&detected, across),
        Answer::Unresolved => unresolved(comparison, &needed),
    }
}

fn different(detected: &[&Judged], across: &str) -> String {
    let beyond: Vec<&&Judged> = detected.iter().filter(|one| one.answer == Answer::Different).collect();
    let Some((first, rest)) = beyond.split_first() else { return "different.".into() };
    let named: Vec<String> = rest.iter().take(NAMED - 1).map(|one| size(one, across)).collect();
    let more = rest.len().saturating_sub(named.len());
    let mut sentence = format!("different by {}", size(first, across));
    if !named.is_empty() {
        sentence += &format!("; also {}", named.join("; "));
    }
    if more > 0 {
        sentence += &format!("; and in {} more", counted(more, "observable"));
    }
    sentence + "."
}

/// A difference with its error, over the scale and where it is.
fn size(one: &Judged, across: &str) -> String {
    let name = in_prose(one.tested.name);
    let Some(Deviation { place, difference, error, .. }) = one.tested.headline() else { return name };
    let at = place.map_or(String::new(), |place| {
        let at = if across == "s" { "at t =" } else { "at y =" };
        format!(" {at} {}", quantity(place, across, 3))
    });
    let share = |value: f64| 100.0 * value / one.tested.scale;
    format!("{} % in {name}{at}", with_error(Estimate::new(share(difference), share(error))))
}

fn unresolved(comparison: &Comparison, needed: &impl Fn(f64) -> String) -> String {
    if comparison.judged.is_empty() {
        return "not resolved: nothing that could be compared has error bars.".into();
    }
    let open = comparison.judged.iter().filter(|one| one.answer == Answer::Unresolved);
    let worst = open.max_by(|a, b| a.stretch.total_cmp(&b.stretch));
    let Some(worst) = worst else {
        let names: Vec<String> = comparison.unknown.iter().map(|name| in_prose(name)).collect();
        return format!("not resolved: there are no error bars for {}.", names.join(", "));
    };
    // what these runs just fail to show needs more than a little
    let stretch = worst.stretch.max(2.0);
    let blindest = comparison.judged.iter().max_by(|a, b| a.detectable.total_cmp(&b.detectable)).unwrap_or(worst);
    format!(
        "not resolved: no difference is seen, and the smallest that these runs could see is {} (in {}). About {} would show whether they are equivalent within {}.",
        percent(blindest.detectable),
        in_prose(blindest.tested.name),
        needed(stretch),
        margin(comparison.margin)
    )
}
