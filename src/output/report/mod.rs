//! The report: one HTML page that opens offline, needs no script, and prints.
//!
//! The answer comes first, then what it rests on, then what is needed to get it again. All text from outside is escaped.

mod chart;
mod impact;
mod limits;
mod tables;
mod trust;

pub use chart::chart;
pub use impact::impact;
pub use limits::limits;

use super::figures::Figure;
use super::{Provenance, Study};
use crate::engine::Failure;
use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = include_str!("style.css");

/// The page of a run or comparison.
pub fn study(study: &Study, figures: &[Figure]) -> String {
    let outcomes = study.outcomes;
    let failures: Vec<_> =
        outcomes.iter().filter_map(|o| Some((o.experiment.name.as_str(), o.failure.as_ref()?))).collect();
    let threads = outcomes.iter().map(|o| o.timing.threads.to_string());
    let seeds = outcomes.iter().map(|o| o.experiment.run.seed.to_string());
    let reproduction = [
        ("seed", distinct(seeds)),
        ("threads", distinct(threads)),
        ("initial state", distinct(outcomes.iter().map(|o| format!("{:016x}", o.initial_state_hash)))),
    ];
    let body = html! {
        (failed(&failures))
        h2 { "Cost and counts" }
        (tables::cost(outcomes))
        @if !study.differences.is_empty() {
            h2 { "Differences" }
            (tables::differences(study.differences))
        }
        h2 { "Pictures" }
        (pictures(figures))
        h2 { "Impacts" }
        (tables::impacts(outcomes))
        h2 { "Energy ledger" }
        (tables::energy(outcomes))
        @if outcomes.iter().any(|o| o.balance.drag.value != 0.0 || o.balance.weight != 0.0 || o.balance.wall.value != 0.0) {
            h2 { "Streamwise momentum" }
            (tables::momentum(outcomes))
        }
        h2 { "Averaging" }
        (tables::averaging(outcomes))
        (trust::sheets(study.trust))
    };
    let tail = html! {
        (dictionary(&reproduction))
        (tables::hashes(outcomes))
    };
    page(study.provenance, study.verdicts, study.notes, &body, &tail)
}

/// The frame both pages share.
fn page(provenance: &Provenance, verdicts: &[String], notes: &[String], body: &Markup, tail: &Markup) -> String {
    let title = if provenance.title.is_empty() { provenance.case_path.as_str() } else { &provenance.title };
    let version = concat!("diptych ", env!("CARGO_PKG_VERSION"));
    let system = format!("{} on {} {}", version, std::env::consts::OS, std::env::consts::ARCH);
    let origin = [("case", provenance.case_path.clone()), ("command", provenance.command.clone()), ("version", system)];
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (title) }
                @if let Some((first, rest)) = verdicts.split_first() {
                    p.verdict { (first) }
                    @if !rest.is_empty() { ul { @for verdict in rest { li { (verdict) } } } }
                }
                @if !provenance.scene.is_empty() { ul.scene { @for line in provenance.scene.lines() { li { (line) } } } }
                (body)
                @if !notes.is_empty() {
                    h2 { "How far to trust this" }
                    ul { @for note in notes { li { (note) } } }
                }
                h2 { "To get the same again" }
                (dictionary(&origin))
                (tail)
                @if !provenance.case_text.is_empty() {
                    details {
                        summary { "The case file as it was read" }
                        pre { (provenance.case_text) }
                    }
                }
            }
        }
    };
    page.into_string()
}

/// What stopped early, and why, with the typed failure as it stands in `summary.json`.
fn failed(failures: &[(&str, &Failure)]) -> Markup {
    html! {
        @if !failures.is_empty() {
            div.failure role="alert" {
                @for (name, failure) in failures {
                    p { strong { (name) " stopped early: " } (failure) }
                    p.note { code { (serde_json::to_string(failure).unwrap_or_else(|error| error.to_string())) } }
                }
                p { "What these variants had gathered until then is shown below." }
            }
        }
    }
}

fn pictures(figures: &[Figure]) -> Markup {
    html! {
        div.figures {
            @for figure in figures {
                figure {
                    (PreEscaped(&figure.svg))
                    figcaption { (figure.caption) }
                }
            }
        }
    }
}

fn dictionary(entries: &[(&str, String)]) -> Markup {
    html! {
        dl {
            @for (term, text) in entries {
                @if !text.is_empty() { dt { (term) } dd { (text) } }
            }
        }
    }
}

/// The different texts, in order, separated by commas: one if all are equal.
fn distinct(texts: impl Iterator<Item = String>) -> String {
    let mut seen: Vec<String> = Vec::new();
    for text in texts {
        if !seen.contains(&text) {
            seen.push(text);
        }
    }
    seen.join(", ")
}

/// A table whose first column names the row. Rows with `true` are marked.
fn table(head: &[&str], rows: &[(bool, Vec<String>)]) -> Markup {
    html! {
        div.wide {
            table {
                thead { tr { @for cell in head { th scope="col" { (cell) } } } }
                tbody {
                    @for (marked, cells) in rows {
                        tr.mark[*marked] {
                            @for (k, cell) in cells.iter().enumerate() {
                                @if k == 0 { th scope="row" { (cell) } } @else { td { (cell) } }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn note(text: &str) -> Markup {
    html! { p.note { (text) } }
}
