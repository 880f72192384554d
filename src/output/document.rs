//! Content of the report of a study, independent of the format: sentences, tables and pictures in the order of a page,
//! and the numbers of its summary. [`html`](super::html) makes a page of it, [`text`] lines for a terminal.

use super::Provenance;
use super::numbers::UNKNOWN;
use super::panel::Figure;
use super::player::Player;
use crate::engine::Failure;
use crate::statistics::Answer;
use std::fmt::Write;
use std::ops::Range;

/// A row of a table: whether it is marked, and its cells, the first of which names it.
pub(super) type TextRow = (bool, Vec<String>);

/// A table whose first column names the rows.
#[derive(Clone, Debug)]
pub(super) struct Table {
    pub head: Vec<String>,
    pub rows: Vec<TextRow>,
    /// True if the last column holds sentences.
    pub remarks: bool,
}

/// A table of answers: quantities in rows, variants in columns.
#[derive(Clone, Debug)]
pub(super) struct Matrix {
    /// Name of each column, and a remark about it.
    pub head: Vec<(String, String)>,
    /// Name of each row, and its answers.
    pub rows: Vec<(String, Vec<AnswerCell>)>,
}

/// One answer of a matrix.
#[derive(Clone, Debug, Default)]
pub(super) struct AnswerCell {
    /// The answer in a word; `None` if there is none.
    pub answer: Option<Answer>,
    /// Number behind the answer, or the text shown in place of an answer.
    pub words: String,
}

/// A part of a document.
#[derive(Clone, Debug)]
pub(super) enum Block {
    Heading(String),
    Subheading(String),
    /// A heading that a link leads to, with the name of the link.
    Section(&'static str, String),
    /// Links to sections: name and heading of each.
    Contents(Vec<(&'static str, String)>),
    Paragraph(String),
    /// A label in bold letters for the blocks below it.
    Label(String),
    /// The sentence that answers the question of a part of the document.
    Verdict(String),
    Note(String),
    List(Vec<String>),
    /// Terms and their values; terms without a value are left out.
    Entries(Vec<(String, String)>),
    Table(Table),
    /// Answers in a compact table.
    Matrix(Matrix),
    /// An animation of particles.
    Player(Box<Player>),
    /// Pictures of the document, by index.
    Figures(Range<usize>),
    /// A text file under a heading, folded until the user opens it.
    Source(String, String),
}

impl Block {
    pub fn heading(text: &str) -> Self {
        Self::Heading(text.into())
    }

    pub fn note(text: impl Into<String>) -> Self {
        Self::Note(text.into())
    }

    /// `head`: the names of the columns with ` | ` in between.
    pub fn table(head: &str, rows: impl IntoIterator<Item = TextRow>) -> Self {
        Self::Table(Table { head: columns(head), rows: rows.into_iter().collect(), remarks: false })
    }

    pub fn entries<const N: usize>(entries: [(&str, String); N]) -> Self {
        Self::Entries(entries.map(|(term, text)| (term.to_owned(), text)).into())
    }
}

/// The names of columns that stand in a text with ` | ` in between.
pub(super) fn columns(head: &str) -> Vec<String> {
    head.split(" | ").map(String::from).collect()
}

/// The text if the value is known, else the sign for an unknown value.
pub(super) fn known(is_known: bool, text: String) -> String {
    if is_known { text } else { UNKNOWN.into() }
}

/// All results of a study that are written.
pub(super) struct Document<'a> {
    pub provenance: &'a Provenance,
    /// Variants that stopped early, by name.
    pub failures: Vec<(&'a str, &'a Failure)>,
    /// The answer in sentences, the shortest first.
    pub verdicts: &'a [String],
    /// Number of `verdicts` at the head of the page; the others are folded.
    pub answers: usize,
    /// The part that is visible without unfolding.
    pub front: Vec<Block>,
    /// Limits of the reliability of the numbers, a sentence each.
    pub notes: &'a [String],
    pub body: Vec<Block>,
    /// Further data needed to reproduce the results.
    pub tail: Vec<Block>,
    /// Tables of numbers: name of the file, and its text.
    pub tables: Vec<(String, Vec<u8>)>,
    pub figures: Vec<Figure>,
}

/// Outcome of a run, in one word.
pub(super) fn status(failed: bool) -> &'static str {
    if failed { "failed" } else { "complete" }
}

/// Parts of a document as lines for a terminal, which has no links and no pictures.
pub(super) fn text(blocks: &[Block]) -> String {
    let mut text = String::new();
    for block in blocks {
        let _ = match block {
            Block::Heading(title) | Block::Subheading(title) | Block::Section(_, title) => writeln!(text, "\n{title}"),
            Block::Paragraph(words) | Block::Label(words) | Block::Verdict(words) => writeln!(text, "{words}\n"),
            Block::Note(words) => writeln!(text, "  {words}"),
            Block::List(items) => items.iter().try_for_each(|item| writeln!(text, "  - {item}")),
            Block::Entries(entries) => {
                let rows: Vec<_> = entries.iter().map(|(term, words)| [term.as_str(), words]).collect();
                write!(text, "{}", aligned(&rows))
            }
            Block::Table(table) => {
                let rows = std::iter::once(&table.head).chain(table.rows.iter().map(|(_, cells)| cells));
                write!(
                    text,
                    "{}",
                    aligned(&rows.map(|row| row.iter().map(String::as_str).collect()).collect::<Vec<Vec<_>>>())
                )
            }
            Block::Source(title, source) => writeln!(text, "\n{title}\n{source}"),
            Block::Contents(_) | Block::Figures(_) | Block::Matrix(_) | Block::Player(_) => Ok(()),
        };
    }
    text
}

/// Columns as wide as their longest cell, two spaces apart.
fn aligned<'a>(rows: &[impl AsRef<[&'a str]>]) -> String {
    let mut widths: Vec<usize> = Vec::new();
    for row in rows.iter().map(AsRef::as_ref) {
        widths.resize(widths.len().max(row.len()), 0);
        widths.iter_mut().zip(row).for_each(|(width, cell)| *width = (*width).max(cell.chars().count()));
    }
    let line = |row: &[&str]| {
        let cells =
            row.iter().zip(&widths).map(|(cell, width)| format!("{cell}{}", " ".repeat(width - cell.chars().count())));
        format!("  {}\n", cells.collect::<Vec<_>>().join("  ").trim_end())
    };
    rows.iter().map(|row| line(row.as_ref())).collect()
}
