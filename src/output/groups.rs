//! Groups of variants: the reference of each variant, and the variants that share a panel of a picture. A variant is
//! one of the experiments of a case.

use crate::experiment::{Model, Reference};
use crate::outcome::Outcome;

/// Largest number of variants (experiments of a case) that readers can distinguish in one panel. It equals the number
/// of dash patterns of lines and the number of markers of points.
pub(super) const TOLD_APART: usize = 6;

/// Index of the reference of each variant (experiment of a case). The reference is the variant that the key `against`
/// names, if this key is given. A variant without this key is its own reference if another variant names it. A variant
/// that is compared with a table is its own reference too. All other variants have the first variant with hard spheres
/// as reference, or the first variant if none has hard spheres.
pub fn references(outcomes: &[Outcome]) -> Vec<usize> {
    let rest = outcomes.iter().position(|outcome| outcome.experiment.model() == Model::Hard).unwrap_or(0);
    // a variant whose reference has not been run is its own reference
    let against = |(place, outcome): (usize, &Outcome)| {
        let Reference::Variant(name) = outcome.experiment.against.as_ref()? else { return Some(place) };
        Some(outcomes.iter().position(|other| other.experiment.name == *name).unwrap_or(place))
    };
    let named: Vec<Option<usize>> = outcomes.iter().enumerate().map(against).collect();
    let of = |place: usize| match named[place] {
        Some(other) => other,
        None if named.contains(&Some(place)) => place,
        None => rest,
    };
    (0..outcomes.len()).map(of).collect()
}

/// Variants (experiments of a case) that are drawn together in one panel of a picture.
pub(super) struct PanelGroup<'a> {
    /// Common beginning of the names of the experiments in the group, or the name of their reference. Empty if there is
    /// only one group.
    pub title: String,
    /// For each variant (experiment of a case): the part of its name that is not in `title`, and its results.
    pub members: Vec<(String, &'a Outcome)>,
}

/// Returns one group of all variants (experiments of a case) if there are at most [`TOLD_APART`] variants, or if all
/// have the same reference. Otherwise returns one group for each reference.
pub(super) fn groups(outcomes: &[Outcome]) -> Vec<PanelGroup<'_>> {
    let name = |outcome: &Outcome| outcome.experiment.name.clone();
    let references = references(outcomes);
    let mut heads: Vec<usize> = Vec::new();
    for &head in &references {
        if !heads.contains(&head) {
            heads.push(head);
        }
    }
    if outcomes.len() <= TOLD_APART || heads.len() == 1 {
        return vec![PanelGroup { title: String::new(), members: outcomes.iter().map(|o| (name(o), o)).collect() }];
    }
    let group = |head: &usize| {
        let members: Vec<&Outcome> =
            outcomes.iter().zip(&references).filter(|(_, of)| *of == head).map(|(outcome, _)| outcome).collect();
        let names: Vec<String> = members.iter().map(|outcome| name(outcome)).collect();
        let (title, rest) = split(&names).unwrap_or_else(|| (name(&outcomes[*head]), names));
        PanelGroup { title, members: rest.into_iter().zip(members).collect() }
    };
    heads.iter().map(group).collect()
}

/// Distinct values among the values of several variants (experiments of a case), each with a text. `of` gives the name
/// and the value of each variant. The text is empty if all variants have this value; otherwise it names the variants
/// that have it. Variants without a value are left out.
pub(super) fn distinct<'a, T: PartialEq>(of: impl Iterator<Item = (&'a str, Option<T>)>) -> Vec<(T, String)> {
    let mut found: Vec<(T, Vec<&str>)> = Vec::new();
    let mut all = 0;
    for (name, value) in of {
        all += 1;
        let Some(value) = value else { continue };
        match found.iter_mut().find(|(known, _)| *known == value) {
            Some((_, names)) => names.push(name),
            None => found.push((value, vec![name])),
        }
    }
    let named = |names: Vec<&str>| if names.len() == all { String::new() } else { format!(", {}", names.join("; ")) };
    found.into_iter().map(|(value, names)| (value, named(names))).collect()
}

/// Splits the names of variants (experiments of a case) at their first comma: "case B, soft" and "case B, hard" give
/// "case B", and the list "soft", "hard". `None` if the parts before the comma differ, or if a name has no comma.
fn split(names: &[String]) -> Option<(String, Vec<String>)> {
    let (title, _) = names.first()?.split_once(", ")?;
    let rest = names.iter().map(|name| Some(name.strip_prefix(title)?.strip_prefix(", ")?.to_owned()));
    Some((title.to_owned(), rest.collect::<Option<Vec<_>>>()?))
}
