//! Sentences that express the answers of a comparison of two variants. A variant is one of the experiments of a case.

use crate::output::numbers::{counted, quantity, significant, with_error};
use crate::statistics::{Answer, Comparison, Deviation, Estimate, Judged, LARGEST_DRIFT, Steadiness};

/// Largest number of differences that a sentence names. The table of the report contains all differences.
const NAMED: usize = 3;

/// [-] largest factor by which a longer run or more replicas (runs with different seeds) are recommended. A larger
/// factor is not named, since such runs are impractical.
const ENDLESS: f64 = 1000.0;

/// Beginning of a sentence on the comparison of two variants (experiments of a case): their names in quotes.
pub fn pair(variant: &str, reference: &str) -> String {
    format!("\"{variant}\" against \"{reference}\":")
}

/// Text of a share [-] in per cent, with two significant digits.
pub fn percent(share: f64) -> String {
    format!("{} %", significant(100.0 * share, 2))
}

/// Predicate of a sentence whose subject is a run: the run is not steady, with the reason. `None` for a steady run.
pub fn not_steady(steadiness: &Steadiness) -> Option<String> {
    let why = match steadiness.drift {
        _ if steadiness.steady => return None,
        None => return Some("has too few samples to tell whether it is steady, and too few for error bars".into()),
        Some(f64::INFINITY) => "it changes all the time, without a steady state to average over".into(),
        Some(drift) if drift > LARGEST_DRIFT => {
            format!("the two halves of what is averaged differ by {} standard errors", significant(drift, 2))
        }
        Some(_) => "no steady start was found in its first half".into(),
    };
    Some(format!("is not steady ({why})"))
}

/// Text of a margin (largest accepted difference) [-] in per cent, without needless zeros, as a user would type it.
pub fn margin(share: f64) -> String {
    let digits = format!("{:.4}", 100.0 * share);
    format!("{} %", digits.trim_end_matches('0').trim_end_matches('.'))
}

/// Name of an average over slices of the box for use in a sentence, such as "the mean velocity U". The argument is the
/// name of its column, such as "U".
pub fn in_prose(name: &str) -> String {
    match name {
        "number_density_ratio" => "the number density".into(),
        "U" => "the mean velocity U".into(),
        "uu" | "vv" | "ww" => format!("the normal stress {name}"),
        "uv" => "the shear stress uv".into(),
        "mean_spin_x" => "mean spin about x".into(),
        "rotational_temperature" => "rotational temperature".into(),
        other => other.into(),
    }
}

/// Answer of a comparison of averages or curves, as a sentence without its subject. `across` is the unit of positions
/// or instants: m, s, or empty for single numbers. The function `needed` describes runs that would decide the
/// comparison; its argument is the factor by which the runs must be longer or more numerous.
pub fn answer(comparison: &Comparison, across: &str, needed: impl Fn(f64) -> String) -> String {
    match comparison.answer {
        Answer::Equivalent => equivalent(comparison, across),
        Answer::Different => different(&comparison.detected(), across, comparison.margin),
        Answer::Unresolved => unresolved(comparison, across, &needed),
    }
}

/// Phrase for a statement that holds everywhere: at all positions if `across` is "m", at all instants if it is "s".
/// Empty for single numbers.
fn anywhere(across: &str) -> &'static str {
    match across {
        "" => "",
        "s" => " at any instant compared",
        _ => " in any slice",
    }
}

fn equivalent(comparison: &Comparison, across: &str) -> String {
    let widest = comparison.judged.iter().max_by(|a, b| a.reached.total_cmp(&b.reached));
    let widest = widest.filter(|one| one.reached > 0.0).map_or("no difference at all".into(), |one| {
        let (reached, of) = (percent(one.reached), one.tested.scale_is);
        format!("no difference beyond {reached} of {of}{} (in {})", anywhere(across), in_prose(&one.tested.name))
    });
    let found = comparison.detected().first().map_or(String::new(), |one| {
        format!(" A difference is seen, of {}: it is within the margin.", size(one, across))
    });
    format!("equivalent within {}: {widest}.{found}", margin(comparison.margin))
}

fn different(detected: &[&Judged], across: &str, limit: f64) -> String {
    let mut different: Vec<&&Judged> = detected.iter().filter(|one| one.answer == Answer::Different).collect();
    // differences that are certainly greater than the margin come first, even if others are more significant
    different.sort_by_key(|one| !one.beyond);
    let Some((first, rest)) = different.split_first() else { return "different.".into() };
    let named: Vec<String> = rest.iter().take(NAMED - 1).map(|one| size(one, across)).collect();
    let more = rest.len().saturating_sub(named.len());
    let where_it_lies = if first.beyond { "beyond" } else { "perhaps within" };
    let mut sentence = format!("different by {}, {where_it_lies} the margin of {}", size(first, across), margin(limit));
    if !named.is_empty() {
        sentence += &format!("; also {}", named.join("; "));
    }
    if more > 0 {
        sentence += &format!("; and in {} more", counted(more, "observable"));
    }
    sentence + "."
}

/// Text of a difference, with its standard error and its position or instant. The difference is in per cent of the
/// value by which differences of this observable are divided. `across` is the unit of the position or instant: m, s, or
/// empty.
fn size(one: &Judged, across: &str) -> String {
    let name = in_prose(&one.tested.name);
    let Some(Deviation { place, difference, error, .. }) = one.tested.headline() else { return name };
    let at = place.map_or(String::new(), |place| {
        let at = if across == "s" { "at t =" } else { "at y =" };
        format!(" {at} {}", quantity(place, across, 3))
    });
    let at = if place.is_none() && across == "s" && one.tested.largest.is_some() {
        " in the mean over time".into()
    } else {
        at
    };
    let share = |value: f64| 100.0 * value / one.tested.scale;
    let of = one.tested.scale_is;
    format!("{} % of {of} in {name}{at}", with_error(Estimate::new(share(difference), share(error))))
}

fn unresolved(comparison: &Comparison, across: &str, needed: &impl Fn(f64) -> String) -> String {
    if comparison.judged.is_empty() {
        return "unresolved: nothing that could be compared has error bars.".into();
    }
    let open = || comparison.judged.iter().filter(|one| one.answer == Answer::Unresolved);
    let Some(worst) = open().max_by(|a, b| a.stretch.total_cmp(&b.stretch)) else {
        let names: Vec<String> = comparison.unknown.iter().map(|name| in_prose(name)).collect();
        return format!("unresolved: there are no error bars for {}.", names.join(", "));
    };
    let limit = margin(comparison.margin);
    // with this factor every observable would be shown equivalent. The factor is at least 2, even if the present runs
    // nearly suffice
    let stretch = comparison.judged.iter().map(|one| one.stretch).fold(2.0, f64::max);
    let advice = if stretch > ENDLESS {
        format!(
            "More than a thousand times as much would be needed to show them equivalent within {limit}; see --margin."
        )
    } else {
        format!("If they are equal, about {} would show them equivalent within {limit}.", needed(stretch))
    };
    let smooth = comparison.judged.iter().map(|one| one.reached_smooth).fold(0.0, f64::max);
    let smooth = if smooth < comparison.margin && !across.is_empty() {
        format!(" Differences that are smooth or uniform are below {} {}.", percent(smooth), "of each scale")
    } else {
        String::new()
    };
    let widest = open().max_by(|a, b| a.reached.total_cmp(&b.reached)).unwrap_or(worst);
    let blindest = comparison.judged.iter().max_by(|a, b| a.detectable.total_cmp(&b.detectable)).unwrap_or(worst);
    format!(
        "unresolved, neither equal within {limit} nor different: no difference is seen beyond the margin, and the smallest uniform difference that these runs could have shown is {} of {} (in {}); one of up to {} of {} may be left{} (in {}).{smooth} {advice}",
        percent(blindest.detectable),
        blindest.tested.scale_is,
        in_prose(&blindest.tested.name),
        percent(widest.reached),
        widest.tested.scale_is,
        anywhere(across),
        in_prose(&widest.tested.name),
    )
}
