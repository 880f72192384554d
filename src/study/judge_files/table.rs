//! Reads tables of numbers that any program wrote: CSV, thermo output (the tables in the log) of LAMMPS, output of its
//! command `fix ave/time`, and averages over the particles of a trajectory. A variant is one of the experiments of a
//! case.

use crate::case::located::Located;
use crate::case::{Diagnostic, Origin, Sources, nearest, read_text};
use crate::legible::quote;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

/// Name of the file in a folder of results that contains averages over all particles at each sample (instant of
/// measurement).
const SERIES: &str = "series.csv";

/// Largest number of names of columns or variants (experiments of a case) that a message lists.
const LISTED: usize = 30;

/// Table of numbers from a file, with the place of each row in the file for messages.
pub struct NumberTable {
    /// Path of the file, as shown in messages.
    pub name: String,
    /// Names of the columns of the table, in the order of the file.
    pub columns: Vec<String>,
    /// True if the program LAMMPS wrote the file.
    pub is_lammps: bool,
    /// Index of the text of the file in the list of sources.
    pub(super) source: usize,
    /// Warnings for the user about the contents of the file.
    pub warnings: Vec<Diagnostic>,
    /// Numbers of each column, in the order of the rows. NaN stands for a cell without a finite number.
    numbers: Vec<Vec<f64>>,
    /// Texts of the cells without a finite number. The key has the index of the row, then the index of the column.
    texts: BTreeMap<(usize, usize), String>,
    /// Range of bytes of each row of the table in the text of the file.
    lines: Vec<Range<usize>>,
}

impl NumberTable {
    /// Reads a table from a file, or from `series.csv` of a folder of results. `argument` is a path or has the form
    /// `FOLDER:VARIANT`. `slices` is the number of slices along y in which the particles of a trajectory are averaged.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read or is no table, or if `slices` is given for a file without
    /// particles.
    pub fn read(argument: &str, slices: Option<&Located<u32>>, sources: &mut Sources) -> Result<Self, Diagnostic> {
        let (place, variant) = split_variant(argument);
        let path = if Path::new(place).is_dir() { Path::new(place).join(SERIES) } else { Path::new(place).to_owned() };
        let text = read_text(&path).map_err(|why| {
            Diagnostic::about(path.display().to_string(), format!("cannot read `{}`: {why}", path.display())).help(
                "a side is a CSV file, output of LAMMPS, a trajectory, or a folder of results; several files are separated by commas",
            )
        })?;
        let source = sources.add_file(&path, text.clone());
        let mut table = Self {
            name: argument.to_owned(),
            columns: Vec::new(),
            is_lammps: false,
            source,
            warnings: Vec::new(),
            numbers: Vec::new(),
            texts: BTreeMap::new(),
            lines: Vec::new(),
        };
        let lines = lines_of(&text);
        let is_trajectory = table.trajectory(&text, slices.map(|slices| slices.value as usize), sources)?;
        if let Some(slices) = slices.filter(|_| !is_trajectory) {
            let message =
                format!("`{}`: `{argument}` contains no particles that could be averaged in slices", slices.path);
            return Err(sources
                .error(&slices.origin, message)
                .help("leave it out; dumps and extended XYZ contain particles"));
        }
        table.is_lammps =
            !is_trajectory && (table.thermo(&text, &lines, sources)? || table.averages(&text, &lines, sources)?);
        if !is_trajectory && !table.is_lammps {
            table.csv(&text, sources)?;
        }
        if table.lines.is_empty() {
            let message = format!("`{argument}` has no row of numbers");
            return Err(Diagnostic::about(&table.name, message).help("a table has a header and rows of numbers"));
        }
        table.of_variant(variant)
    }

    /// Reads the rows of a file that the command `fix ave/time` of LAMMPS wrote, with one row of scalars per time.
    /// Returns false if the text is no such file.
    fn averages(&mut self, text: &str, lines: &[Range<usize>], sources: &Sources) -> Result<bool, Diagnostic> {
        let is_header = |line: &&Range<usize>| text[(*line).clone()].trim_start().starts_with("# TimeStep");
        let Some(header) = lines.iter().find(is_header) else { return Ok(false) };
        self.head(words(text[header.clone()].trim_start().trim_start_matches('#')).map(str::to_owned).collect());
        if self.columns.iter().any(|column| column == "Number-of-rows") {
            let origin = Origin { source: self.source, span: header.clone() };
            let message = format!("`{}` has several rows for each time (mode vector)", self.name);
            return Err(sources.error(&origin, message).help("write the wanted entries as scalars, such as `c_1[3]`"));
        }
        for line in lines {
            let row = &text[line.clone()];
            if !row.trim().is_empty() && !row.trim_start().starts_with('#') {
                self.row(&words(row).map(str::to_owned).collect::<Vec<_>>(), line.clone(), sources)?;
            }
        }
        Ok(true)
    }

    /// Reads the rows of a CSV table. The separator of cells is a comma or, if the header has no comma, a semicolon or
    /// a tab.
    fn csv(&mut self, text: &str, sources: &Sources) -> Result<(), Diagnostic> {
        let header = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#')).unwrap_or("");
        let separator = [',', ';', '\t'].into_iter().find(|c| header.contains(*c)).unwrap_or(',');
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(separator as u8)
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(text.as_bytes());
        let start = text.find(header).unwrap_or(0);
        let whole = Origin { source: self.source, span: start..start + header.len() };
        let no_table = |why: csv::Error| {
            sources
                .error(&whole, format!("`{}` is no table: {why}", self.name))
                .help("a table has a header and rows of numbers")
        };
        let head = reader.headers().map_err(no_table)?.iter().map(str::to_owned).collect::<Vec<_>>();
        let is_number = |cell: &String| cell.parse::<f64>().is_ok();
        if head.iter().all(|cell| cell.is_empty()) || head.iter().any(is_number) {
            let message = format!("`{}` has no header with the names of its columns", self.name);
            return Err(sources.error(&whole, message).help("write one as the first line, such as `t_s,T_m2_s2`"));
        }
        let records: Vec<csv::StringRecord> = reader.records().collect::<Result<_, _>>().map_err(no_table)?;
        self.head(head);
        for record in records {
            let start = record.position().map_or(0, |position| position.byte() as usize);
            let rest = text.get(start..).unwrap_or("");
            let start = start + (rest.len() - rest.trim_start_matches(['\n', '\r']).len());
            let end = text.get(start..).and_then(|rest| rest.find('\n')).map_or(text.len(), |at| start + at);
            self.row(&record.iter().map(str::to_owned).collect::<Vec<_>>(), start..end, sources)?;
        }
        Ok(())
    }

    pub(super) fn head(&mut self, columns: Vec<String>) {
        self.numbers = vec![Vec::new(); columns.len()];
        self.columns = columns;
    }

    pub(super) fn row(&mut self, cells: &[String], line: Range<usize>, sources: &Sources) -> Result<(), Diagnostic> {
        if cells.len() != self.columns.len() {
            let (found, wanted) = (cells.len(), self.columns.len());
            let message = format!("the line has {found} fields where the header has {wanted}");
            let origin = Origin { source: self.source, span: line };
            return Err(sources.error(&origin, message).help("one value for each column of the header"));
        }
        for (column, cell) in cells.iter().enumerate() {
            let number = cell.parse::<f64>().ok().filter(|number| number.is_finite());
            if number.is_none() {
                self.texts.insert((self.lines.len(), column), cell.clone());
            }
            self.numbers[column].push(number.unwrap_or(f64::NAN));
        }
        self.lines.push(line);
        Ok(())
    }

    /// Table that has only the rows of the variant (experiment of a case) `wanted`, if a column of the table names
    /// variants. If `wanted` is `None`, all rows must belong to the same variant.
    fn of_variant(self, wanted: Option<&str>) -> Result<Self, Diagnostic> {
        let Some(column) = self.columns.iter().position(|name| name == "variant") else {
            return match wanted {
                None => Ok(self),
                Some(name) => {
                    let message = format!("`{}` has no column `variant` to find \"{}\" in", self.name, quote(name));
                    Err(Diagnostic::about(&self.name, message).help("leave out the colon and what follows"))
                }
            };
        };
        let mut names: Vec<String> = Vec::new();
        for row in 0..self.len() {
            let name = self.text(row, column);
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let known = || format!("its variants: {}", list(&names));
        let name = match wanted {
            None if names.len() == 1 => return Ok(self),
            None => {
                let message = format!("`{}` contains {} variants", self.name, names.len());
                let file = self.name.clone();
                return Err(Diagnostic::about(&file, message).help(format!("choose one: `{file}:NAME`; {}", known())));
            }
            Some(name) if names.iter().any(|known| known == name) => name.to_owned(),
            Some(name) => {
                let message = format!("`{}`: there is no variant \"{}\"", self.name, quote(name));
                return Err(Diagnostic::about(&self.name, message).help(known()));
            }
        };
        let kept: Vec<usize> = (0..self.len()).filter(|row| self.text(*row, column) == name).collect();
        let texts = kept.iter().enumerate().flat_map(|(new, old)| {
            self.texts.range((*old, 0)..(*old + 1, 0)).map(move |((_, column), text)| ((new, *column), text.clone()))
        });
        Ok(Self {
            texts: texts.collect(),
            numbers: self.numbers.iter().map(|column| kept.iter().map(|row| column[*row]).collect()).collect(),
            lines: kept.iter().map(|row| self.lines[*row].clone()).collect(),
            ..self
        })
    }

    /// Number of rows of the table.
    pub fn len(&self) -> usize {
        self.lines.len()
    }

    /// Place of the row with index `row` in its file, for messages.
    pub fn origin(&self, row: usize) -> Origin {
        Origin { source: self.source, span: self.lines[row].clone() }
    }

    /// Index of the column with the name `name`; `None` if there is no such column.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|known| known == name)
    }

    /// Help text for a column name that does not exist: a similar name, and the names of all columns.
    pub fn suggestion(&self, name: &str) -> String {
        let all = format!("its columns: {}", list(&self.columns));
        nearest(name, &self.columns).map_or(all.clone(), |known| format!("did you mean `{known}`? ({all})"))
    }

    /// Text of a cell. If the cell has no finite number, this is the text in the file. A number may have other digits
    /// than in the file.
    pub fn text(&self, row: usize, column: usize) -> String {
        self.texts.get(&(row, column)).cloned().unwrap_or_else(|| format!("{}", self.numbers[column][row]))
    }

    /// True if every cell of the column with index `column` is a finite number.
    pub fn is_numeric(&self, column: usize) -> bool {
        self.numbers[column].iter().all(|number| number.is_finite())
    }

    /// Number in the cell at `row` and `column`, in the unit of the column.
    ///
    /// # Errors
    /// Returns an error if the cell contains no finite number.
    pub fn number(&self, row: usize, column: usize, sources: &Sources) -> Result<f64, Diagnostic> {
        let number = self.numbers[column][row];
        if number.is_finite() {
            return Ok(number);
        }
        let (name, text) = (&self.columns[column], self.text(row, column));
        let message = format!("`{}` = {:?} is not a finite number", quote(name), quote(&text));
        let help = "numbers have a point as the decimal mark; leave out rows and columns without numbers";
        Err(sources.error(&self.origin(row), message).help(help))
    }
}

/// Splits an argument of the form `FOLDER:VARIANT` into a path and the name of a variant (experiment of a case). An
/// argument that is the path of an existing file, even with a colon, is not split.
pub fn split_variant(argument: &str) -> (&str, Option<&str>) {
    let is_folder = |(folder, _): &(&str, &str)| !Path::new(argument).exists() && Path::new(folder).exists();
    argument.rsplit_once(':').filter(is_folder).map_or((argument, None), |(folder, variant)| (folder, Some(variant)))
}

/// Names in backquotes, separated by commas; at most the first 30 names.
fn list(names: &[String]) -> String {
    let mut text = names.iter().take(LISTED).map(|name| format!("`{}`", quote(name))).collect::<Vec<_>>().join(", ");
    if names.len() > LISTED {
        text += ", …";
    }
    text
}

pub(super) fn words(line: &str) -> impl Iterator<Item = &str> {
    line.split_whitespace()
}

/// Range of bytes of each line of a text, without the end of the line.
fn lines_of(text: &str) -> Vec<Range<usize>> {
    let mut start = 0;
    let mut lines = Vec::new();
    for line in text.split_inclusive('\n') {
        lines.push(start..start + line.trim_end_matches(['\n', '\r']).len());
        start += line.len();
    }
    lines
}
