//! Report as one HTML page, which needs no network and can be printed. All text is readable without scripts.
//!
//! The answer comes first and fits on one screen. The data follow in parts, each of which is hidden below its heading
//! until the reader opens it. The last part contains the data needed to reproduce the results. Text of the user, such
//! as names of variants, is escaped, and its control characters are made visible. A variant is one of the experiments
//! of a case.

use super::document::{AnswerCell, Block, Document, Matrix, Table};
use super::figures::file_name;
use super::panel::Figure;
use super::player;
use crate::engine::Failure;
use crate::legible;
use crate::statistics::Answer;
use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = include_str!("page/style.css");

/// Heading of the part of a page with the remarks and checks that show how reliable the results are.
pub(super) const TRUST: &str = "How far to trust this";

/// Heading of the part of a page with the data needed to reproduce the results.
const AGAIN: &str = "To get the same again";

/// Part of a page that is hidden below its heading until the reader opens it.
struct Fold<'a> {
    title: &'a str,
    inside: Vec<Markup>,
}

/// Text of the HTML page for a document.
pub(super) fn page(document: &Document) -> String {
    let Document { provenance, verdicts, front, body, figures, .. } = document;
    let title = if provenance.title.is_empty() { provenance.case_path.as_str() } else { &provenance.title };
    // blocks before the first heading are always visible
    let open = body.iter().position(|block| matches!(block, Block::Heading(_))).unwrap_or(body.len());
    let folds = folds(document, &body[open..]);
    let (answers, further) = verdicts.split_at(document.answers.min(verdicts.len()));
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
                main {
                    h1 { (title) }
                    @if let Some((first, rest)) = answers.split_first() {
                        p.verdict { (first) }
                        @if !rest.is_empty() { ul.answers { @for verdict in rest { li { (verdict) } } } }
                    }
                    (failed(&document.failures))
                    @for (label, text) in about(&provenance.case_text) { p.about { strong { (label) ": " } (text) } }
                    @if !front.is_empty() { div.front { @for block in front { (part(block, figures)) } } }
                    @if !further.is_empty() {
                        details.further { summary { "More findings" } ul { @for verdict in further { li { (verdict) } } } }
                    }
                    (contents(&folds, &document.tables))
                    @for block in &body[..open] { (part(block, figures)) }
                    @for fold in &folds { (folded(fold)) }
                }
                @if front.iter().chain(body).any(|block| matches!(block, Block::Player(_))) { (player::scripts()) }
            }
        }
    };
    legible::lines(&page.into_string()).into_owned()
}

/// Question of a case and the expected result, each with its label, from the comment at the top of the case file.
fn about(case_text: &str) -> Vec<(&'static str, String)> {
    const LABELS: [&str; 3] = ["Question", "Source", "What should come out"];
    let mut parts: Vec<(&'static str, String)> = Vec::new();
    for line in case_text.lines().map_while(|line| line.strip_prefix('#')).map(str::trim) {
        let labelled = LABELS.into_iter().find_map(|label| Some((label, line.strip_prefix(label)?.strip_prefix(':')?)));
        match (labelled, parts.last_mut()) {
            (Some((label, text)), _) => parts.push((label, text.trim().to_owned())),
            (None, Some((_, text))) => *text += &format!(" {line}"),
            (None, None) => {}
        }
    }
    parts.retain(|(label, _)| *label != "Source");
    parts
}

/// Makes all parts of the page that have a heading and are hidden until the reader opens them, in the order of the
/// page.
fn folds<'a>(document: &'a Document, body: &'a [Block]) -> Vec<Fold<'a>> {
    let Document { provenance, notes, figures, .. } = document;
    let mut folds = Vec::new();
    if !provenance.scene.is_empty() {
        let scene = html! { ul.scene { @for line in provenance.scene.lines() { li { (line) } } } };
        folds.push(Fold { title: "Scene", inside: vec![scene] });
    }
    for block in body {
        match (block, folds.last_mut()) {
            (Block::Heading(title), _) => folds.push(Fold { title, inside: Vec::new() }),
            (_, Some(fold)) => fold.inside.push(part(block, figures)),
            (_, None) => {}
        }
    }
    if !notes.is_empty() {
        let list = html! { ul { @for note in *notes { li { (note) } } } };
        match folds.iter_mut().find(|fold| fold.title == TRUST) {
            Some(fold) => fold.inside.insert(0, list),
            None => folds.push(Fold { title: TRUST, inside: vec![list] }),
        }
    }
    folds.push(Fold { title: AGAIN, inside: again(document) });
    folds
}

/// Data needed to reproduce the results: case, command, version and case file.
fn again(document: &Document) -> Vec<Markup> {
    let Document { provenance, figures, tail, .. } = document;
    let version = concat!("diptych ", env!("CARGO_PKG_VERSION"));
    let system = format!("{} on {} {}", version, std::env::consts::OS, std::env::consts::ARCH);
    let origin = [("case", provenance.case_path.clone()), ("command", provenance.command.clone()), ("version", system)];
    let mut inside = vec![part(&Block::entries(origin), figures)];
    inside.extend(tail.iter().map(|block| part(block, figures)));
    if !provenance.case_text.is_empty() {
        inside.push(source("The case file as it was read", &provenance.case_text));
    }
    inside
}

/// Largest number of tables whose files a page links to at its top. A run with all its measurements has fewer tables.
/// In a study with more tables, the sections of the page name the files.
const MOST_LINKS: usize = 24;

/// Links to the parts of the page, and to the files with tables of numbers.
fn contents(folds: &[Fold], tables: &[(String, Vec<u8>)]) -> Markup {
    html! {
        nav aria-label="Contents" {
            p {
                "Below: "
                @for (k, fold) in folds.iter().enumerate() {
                    @if k > 0 { " · " }
                    a href={ "#" (file_name(fold.title)) } { (fold.title) }
                }
            }
            @if (1..=MOST_LINKS).contains(&tables.len()) {
                p {
                    "Numbers: "
                    @for (k, (name, _)) in tables.iter().enumerate() {
                        @if k > 0 { " · " }
                        a href=(name) { (name) }
                    }
                }
            }
        }
    }
}

/// HTML of a part of the page, which the reader opens by its heading. The target of links is inside the part, because
/// a browser opens a hidden part if a link leads into it.
fn folded(fold: &Fold) -> Markup {
    html! {
        details.part {
            summary { h2 { (fold.title) } }
            div id=(file_name(fold.title)) { @for inside in &fold.inside { (inside) } }
        }
    }
}

/// List of the variants (experiments of a case) that stopped early, each with its failure.
fn failed(failures: &[(&str, &Failure)]) -> Markup {
    html! {
        @if !failures.is_empty() {
            div.failure role="alert" {
                @for (name, failure) in failures {
                    p { strong { (name) " stopped early: " } (failure) }
                }
                p { "Everything measured until then is shown below." }
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
        Block::Matrix(given) => matrix(given),
        Block::Player(player) => player.markup(),
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
    html! { details { summary { (title) } pre tabindex="0" { (text) } } }
}

fn matrix(Matrix { head, rows }: &Matrix) -> Markup {
    let class = |answer: Option<Answer>| answer.map_or("", Answer::word);
    let cell = |AnswerCell { answer, words }: &AnswerCell| {
        html! {
            td class=(class(*answer)) {
                @if let Some(answer) = answer { b { (answer.word()) } " " }
                (words)
            }
        }
    };
    html! {
        div.wide tabindex="0" role="region" aria-label="Answers at a glance" {
            table.matrix {
                thead {
                    tr {
                        @for (name, words) in head { th scope="col" { (name) @if !words.is_empty() { small { (words) } } } }
                    }
                }
                tbody { @for (name, cells) in rows { tr { th scope="row" { (name) } @for one in cells { (cell(one)) } } } }
            }
        }
    }
}

fn table(Table { head, rows, remarks }: &Table) -> Markup {
    let words = |k: usize| *remarks && k + 1 == head.len();
    html! {
        div.wide tabindex="0" {
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
