//! Content of the report of a study, independent of the format: sentences, tables, pictures, and numbers for the file
//! `summary.json`. The module [`html`](super::html) makes a page from the content. [`text`] makes lines for a terminal
//! from it. A variant is one of the experiments of a case.

use super::Provenance;
use super::numbers::UNKNOWN;
use super::panel::Figure;
use super::player::Player;
use crate::engine::Failure;
use crate::statistics::Answer;
use std::collections::BTreeSet;
use std::fmt::Write;
use std::ops::Range;

/// Row of a table: a flag that is true for a highlighted row, and the cells. The first cell is the name of the row.
pub(super) type TextRow = (bool, Vec<String>);

/// Table of text cells whose first column contains the names of the rows.
#[derive(Clone, Debug)]
pub(super) struct Table {
    pub head: Vec<String>,
    pub rows: Vec<TextRow>,
    /// True if the last column of the table contains sentences, which may extend over several lines.
    pub remarks: bool,
}

/// Table of the answers of a comparison, with quantities in rows and variants (experiments of a case) in columns.
#[derive(Clone, Debug)]
pub(super) struct Matrix {
    /// Names of the columns, each with a remark that is shown below it.
    pub head: Vec<(String, String)>,
    /// Names of the rows, each with one answer per column.
    pub rows: Vec<(String, Vec<AnswerCell>)>,
}

/// Cell of a [`Matrix`]: one answer with the number on which it is based.
#[derive(Clone, Debug, Default)]
pub(super) struct AnswerCell {
    /// Answer (equivalent, different or unresolved); `None` if there is no answer.
    pub answer: Option<Answer>,
    /// Number on which the answer is based, or the text shown instead of an answer.
    pub words: String,
}

/// Part of a document, such as a heading, a paragraph, a table or a picture.
#[derive(Clone, Debug)]
pub(super) enum Block {
    Heading(String),
    Subheading(String),
    /// Heading with a target for links. The first field is the name used in links, the second the text.
    Section(&'static str, String),
    /// Links to sections: name and heading of each section.
    Contents(Vec<(&'static str, String)>),
    Paragraph(String),
    /// Label in bold letters above the parts of the document that follow.
    Label(String),
    /// Sentence with the answer to the question of a part of the document.
    Verdict(String),
    Note(String),
    List(Vec<String>),
    /// List of terms, each with its value as text. The page leaves out terms with an empty value.
    Entries(Vec<(String, String)>),
    Table(Table),
    /// Table of answers, with quantities in rows and variants (experiments of a case) in columns.
    Matrix(Matrix),
    /// Animation of the recorded motion of particles.
    Player(Box<Player>),
    /// Pictures of the document, given by the range of their indices in [`Document::figures`].
    Figures(Range<usize>),
    /// Heading and text of a file, hidden until the reader opens it.
    Source(String, String),
}

impl Block {
    pub fn heading(text: &str) -> Self {
        Self::Heading(text.into())
    }

    pub fn note(text: impl Into<String>) -> Self {
        Self::Note(text.into())
    }

    /// Creates a table from its rows. `head` contains the names of the columns, separated by ` | `.
    pub fn table(head: &str, rows: impl IntoIterator<Item = TextRow>) -> Self {
        Self::Table(Table { head: columns(head), rows: rows.into_iter().collect(), remarks: false })
    }

    pub fn entries<const N: usize>(entries: [(&str, String); N]) -> Self {
        Self::Entries(entries.map(|(term, text)| (term.to_owned(), text)).into())
    }
}

/// Splits the head of a table into the names of its columns, which are separated by ` | `.
pub(super) fn columns(head: &str) -> Vec<String> {
    head.split(" | ").map(String::from).collect()
}

/// Returns `text` if `is_known` is true (the value in the text is known), otherwise the sign for an unknown value.
pub(super) fn known(is_known: bool, text: String) -> String {
    if is_known { text } else { UNKNOWN.into() }
}

/// Document of a study: all its results in the form in which the writers of files use them.
pub(super) struct Document<'a> {
    pub provenance: &'a Provenance,
    /// Variants (experiments of a case) that stopped early, each as its name and its failure.
    pub failures: Vec<(&'a str, &'a Failure)>,
    /// Answers of the study in sentences: first the main answers, then further answers.
    pub verdicts: &'a [String],
    /// Number of `verdicts` that are shown at the top of the page. The other verdicts are hidden until the reader opens
    /// them.
    pub answers: usize,
    /// Parts of the page that are always visible, above the parts that a reader opens.
    pub front: Vec<Block>,
    /// Remarks on how far the numbers are reliable, one sentence each.
    pub notes: &'a [String],
    pub body: Vec<Block>,
    /// Last parts of the page: further data that are needed to reproduce the results.
    pub tail: Vec<Block>,
    /// Tables of numbers, each as the name of its file and the text of the file.
    pub tables: Vec<(String, Vec<u8>)>,
    pub figures: Vec<Figure>,
}

impl Document<'_> {
    /// Adds numbers to the names of files that are equal. The names of two variants (experiments of a case) may differ
    /// only in characters that file names leave out.
    pub fn with_distinct_names(mut self) -> Self {
        number_equal(self.tables.iter_mut().map(|(name, _)| name));
        number_equal(self.figures.iter_mut().map(|figure| &mut figure.name));
        self
    }
}

/// Makes names different: to each name that an earlier one equals, a hyphen and a number are added before the extension.
fn number_equal<'a>(names: impl Iterator<Item = &'a mut String>) {
    let mut taken = BTreeSet::new();
    for name in names {
        let end = name.rfind('.').unwrap_or(name.len());
        let (stem, extension) = name.split_at(end);
        let numbered = (2..).map(|number| format!("{stem}-{number}{extension}"));
        let free = std::iter::once(name.clone()).chain(numbered).find(|name| taken.insert(name.clone()));
        *name = free.unwrap_or_default();
    }
}

/// Status of a run in one word for `summary.json`: "failed" if the run stopped early, otherwise "complete".
pub(super) fn status(failed: bool) -> &'static str {
    if failed { "failed" } else { "complete" }
}

/// Text of parts of a document for a terminal, without links, pictures, animations and tables of answers.
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

/// Text of a table with one line per row. Columns are as wide as their longest cell, and two spaces apart.
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

#[cfg(test)]
mod tests {
    use super::number_equal;

    #[test]
    fn equal_names_of_files_get_numbers() {
        let mut names = ["vtk/grid-x-1.vti", "vtk/grid-x-1.vti", "vtk/grid-x-1-2.vti", "map", "map"].map(String::from);
        number_equal(names.iter_mut());
        assert_eq!(names, ["vtk/grid-x-1.vti", "vtk/grid-x-1-2.vti", "vtk/grid-x-1-2-2.vti", "map", "map-2"]);
    }
}
