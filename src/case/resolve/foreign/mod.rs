//! Starts that other programs wrote: extended XYZ (OVITO, ASE) and LAMMPS data files, read into the table that a CSV would be.

mod lammps;
mod xyz;

use super::Resolver;
use super::table::Table;
use crate::case::diagnostic::Diagnostic;
use crate::case::source::Origin;
use csv::StringRecord;
use nalgebra::Vector3;

/// The columns of a start, in the order in which such a file is read into them.
pub(super) const COLUMNS: [&str; 9] = ["x", "y", "z", "vx", "vy", "vz", "diameter", "species", "id"];

/// A file of another program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Foreign {
    /// Extended XYZ.
    Xyz,
    /// A LAMMPS data file.
    Lammps,
}

impl Foreign {
    /// By the end of its name; `None`: a CSV table.
    pub(super) fn of(name: &str) -> Option<Self> {
        match name.rsplit('.').next().map(str::to_ascii_lowercase).as_deref() {
            Some("xyz" | "extxyz") => Some(Self::Xyz),
            Some("data" | "lmp" | "lammps") => Some(Self::Lammps),
            _ => None,
        }
    }
}

/// A text by its lines, with the places of these for messages.
struct Lines<'a> {
    source: usize,
    lines: Vec<(usize, &'a str)>,
}

impl<'a> Lines<'a> {
    fn of(source: usize, text: &'a str) -> Self {
        let start = |line: &str| line.as_ptr() as usize - text.as_ptr() as usize;
        Self { source, lines: text.lines().map(|line| (start(line), line)).collect() }
    }

    fn count(&self) -> usize {
        self.lines.len()
    }

    /// A line, counted from 0; empty after the last.
    fn get(&self, number: usize) -> &'a str {
        self.lines.get(number).map_or("", |(_, line)| line)
    }

    fn origin(&self, number: usize) -> Origin {
        let (start, line) = self.lines.get(number).or(self.lines.last()).copied().unwrap_or((0, ""));
        Origin { source: self.source, span: start..start + line.len() }
    }
}

/// What is read of a particle: the texts of [`COLUMNS`], empty for what the file does not say.
type Cells = [String; 9];

/// The rows of a file and what it says of its box.
struct Read {
    rows: Vec<(Cells, Origin)>,
    /// [m] edges of the box.
    edges: Option<Vector3<f64>>,
}

impl Resolver {
    /// Reads a start of another program, whose kinds of particles count from 1 in the order of the case.
    pub(super) fn foreign_table(&mut self, format: Foreign, source: usize, text: &str) -> Result<Table, Diagnostic> {
        let lines = Lines::of(source, text);
        let read = match format {
            Foreign::Xyz => self.xyz(&lines)?,
            Foreign::Lammps => self.lammps(&lines)?,
        };
        let known = |column: usize| read.rows.iter().any(|(cells, _)| !cells[column].is_empty());
        let columns = (0..COLUMNS.len()).map(|column| known(column).then_some(column)).collect();
        let head = read.edges.map(|edges| ("box_m".to_owned(), format!("{:?} {:?} {:?}", edges.x, edges.y, edges.z)));
        let rows = read.rows.into_iter().map(|(cells, origin)| (StringRecord::from(cells.to_vec()), origin)).collect();
        Ok(Table { saved: false, head: head.into_iter().collect(), columns, units: vec![None; COLUMNS.len()], rows })
    }

    /// An error about a line.
    fn wrong(&self, lines: &Lines, number: usize, message: impl Into<String>, help: &str) -> Diagnostic {
        self.sources.error(&lines.origin(number), message).help(help)
    }

    /// A number in a line.
    fn cell<T: std::str::FromStr>(
        &self,
        lines: &Lines,
        number: usize,
        text: &str,
        what: &str,
    ) -> Result<T, Diagnostic> {
        let error = || self.wrong(lines, number, format!("{what} = {text:?} is not a number"), "plain SI numbers");
        text.parse().map_err(|_| error())
    }

    /// A coordinate [m] less `origin` [m]; as it stands where that is 0.
    fn shifted(&self, lines: &Lines, number: usize, text: &str, origin: f64) -> Result<String, Diagnostic> {
        if origin == 0.0 {
            return Ok(text.to_owned());
        }
        Ok(format!("{:?}", self.cell::<f64>(lines, number, text, "a coordinate")? - origin))
    }

    /// The index in the case of a kind that counts from 1, as text; empty where the case has one kind only.
    fn kind(&self, lines: &Lines, number: usize, text: &str) -> Result<String, Diagnostic> {
        if !self.several {
            return Ok(String::new());
        }
        let kind: usize = self.cell(lines, number, text, "the type")?;
        let help = "types count from 1, in the order of [[particles]] in the case";
        let index = kind.checked_sub(1).ok_or_else(|| self.wrong(lines, number, "the type is 0", help))?;
        Ok(index.to_string())
    }

    /// Says that a file does not say its units.
    fn warn_of_units(&mut self, lines: &Lines, number: usize, help: &str) {
        self.warn(&lines.origin(number), "the file does not say its units: they are taken as m and m/s", help);
    }
}
