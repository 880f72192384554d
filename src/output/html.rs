//! The report: one HTML page that opens offline, needs no script, and prints.
//!
//! The answer comes first, then what it rests on, then what is needed to get it again. All text from outside is escaped.

use super::document::{Block, Document, Table};
use super::panel::Figure;
use crate::engine::Failure;
use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = include_str!("page/style.css");

/// The page of a document.
pub(super) fn page(document: &Document) -> String {
    let Document { provenance, verdicts, notes, figures, .. } = document;
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
                (failed(&document.failures))
                @for block in &document.body { (part(block, figures)) }
                @if !notes.is_empty() {
                    h2 { "How far to trust this" }
                    ul { @for note in *notes { li { (note) } } }
                }
                h2 { "To get the same again" }
                (part(&Block::entries(origin), figures))
                @for block in &document.tail { (part(block, figures)) }
                @if !provenance.case_text.is_empty() {
                    (source("The case file as it was read", &provenance.case_text))
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

fn part(block: &Block, figures: &[Figure]) -> Markup {
    match block {
        Block::Heading(text) => html! { h2 { (text) } },
        Block::Subheading(text) => html! { h3 { (text) } },
        Block::Section(name, text) => html! { h2 id=(name) { (text) } },
        Block::Contents(sections) => {
            html! { ol { @for (name, text) in sections { li { a href={ "#" (name) } { (text) } } } } }
        }
        Block::Paragraph(text) => html! { p { (text) } },
        Block::Label(text) => html! { p { strong { (text) } } },
        Block::Verdict(text) => html! { p.verdict { (text) } },
        Block::Note(text) => html! { p.note { (text) } },
        Block::List(items) => html! { ul { @for item in items { li { (item) } } } },
        Block::Entries(entries) => html! {
            dl { @for (term, text) in entries { @if !text.is_empty() { dt { (term) } dd { (text) } } } }
        },
        Block::Table(given) => table(given),
        Block::Figures(places) => html! {
            div.figures {
                @for figure in &figures[places.clone()] {
                    figure { (PreEscaped(&figure.svg)) figcaption { (figure.caption) } }
                }
            }
        },
        Block::Source(title, text) => source(title, text),
    }
}

fn source(title: &str, text: &str) -> Markup {
    html! { details { summary { (title) } pre { (text) } } }
}

fn table(Table { head, rows, remarks }: &Table) -> Markup {
    let words = |k: usize| *remarks && k + 1 == head.len();
    html! {
        div.wide {
            table {
                thead {
                    tr {
                        @for (k, cell) in head.iter().enumerate() {
                            @if words(k) { th.text scope="col" { (cell) } } @else { th scope="col" { (cell) } }
                        }
                    }
                }
                tbody {
                    @for (marked, cells) in rows {
                        tr.mark[*marked] {
                            @for (k, cell) in cells.iter().enumerate() {
                                @if k == 0 {
                                    th scope="row" { (cell) }
                                } @else if words(k) {
                                    td.words { (cell) }
                                } @else {
                                    td { (cell) }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}
