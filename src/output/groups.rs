//! Groups of variants: the reference of each variant, and the variants that share a panel.

use crate::experiment::Model;
use crate::outcome::Outcome;

/// Number of variants that one panel can tell apart: there are as many dashes and markers.
pub(super) const TOLD_APART: usize = 6;

/// For each variant the index of its reference: the variant named by `against`. A variant is its own reference if
/// another names it. All others are compared with the first hard one, else with the first.
pub fn references(outcomes: &[Outcome]) -> Vec<usize> {
    let rest = outcomes.iter().position(|outcome| outcome.experiment.model() == Model::Hard).unwrap_or(0);
    // a variant whose reference has not been run yet stands alone
    let against = |(place, outcome): (usize, &Outcome)| {
        let name = outcome.experiment.against.as_ref()?;
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

/// Variants drawn in one panel.
pub(super) struct PanelGroup<'a> {
    /// Common beginning of their names; empty for the only group.
    pub title: String,
    /// Rest of each name, and the outcome.
    pub members: Vec<(String, &'a Outcome)>,
}

/// All variants in one group if a panel can tell them apart, else a group for each reference.
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

/// Splits "case B, soft" and "case B, hard" into "case B" and "soft", "hard". `None` if the names do not have one
/// beginning up to a comma.
fn split(names: &[String]) -> Option<(String, Vec<String>)> {
    let (title, _) = names.first()?.split_once(", ")?;
    let rest = names.iter().map(|name| Some(name.strip_prefix(title)?.strip_prefix(", ")?.to_owned()));
    Some((title.to_owned(), rest.collect::<Option<Vec<_>>>()?))
}
