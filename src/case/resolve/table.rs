//! Tables of numbers in CSV: starting positions, velocity profiles. Every error names the line of the table.

use super::Resolver;
use crate::case::de::{Located, suggestion};
use crate::case::diagnostic::Diagnostic;
use crate::case::quantity;
use crate::case::saved;
use crate::case::source::Origin;
use crate::legible::{of_cell, quote};
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// [byte] length of the longest text; keeps a device or a wrong file from filling the memory.
const LONGEST_TEXT: u64 = 1 << 28;

/// Reads a whole file.
///
/// # Errors
/// In words: it is not there, a folder, a pipe or a device, or too long.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, String> {
    let told = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".to_string(),
        _ => error.to_string(),
    };
    // checked before opening: to open a pipe without a writer would block
    let kind = std::fs::metadata(path).map_err(told)?.file_type();
    if kind.is_dir() {
        return Err("it is a folder, not a file".into());
    }
    if !kind.is_file() {
        return Err("it is a pipe or a device, not a regular file; save what it gives as a file".into());
    }
    let file = std::fs::File::open(path).map_err(told)?;
    let mut bytes = Vec::new();
    file.take(LONGEST_TEXT + 1).read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    if bytes.len() as u64 > LONGEST_TEXT {
        return Err(format!("it is longer than {} MiB", LONGEST_TEXT >> 20));
    }
    Ok(bytes)
}

/// True if links on the way to a file lead out of its folder. For a missing file it is false.
pub fn leads_out(file: &Path, folder: &Path) -> bool {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    match (file.canonicalize(), folder.canonicalize()) {
        (Ok(file), Ok(folder)) => !file.starts_with(folder),
        _ => false,
    }
}

/// Reads a whole text file; a byte order mark is dropped.
///
/// # Errors
/// In words: it is not there, a folder, too long, or not UTF-8.
pub fn read_text(path: &Path) -> Result<Arc<str>, String> {
    text_of(&read_bytes(path)?)
}

/// The text of a file; a byte order mark is dropped.
///
/// # Errors
/// In words: it is not UTF-8.
pub fn text_of(bytes: &[u8]) -> Result<Arc<str>, String> {
    match std::str::from_utf8(bytes) {
        Ok(text) => {
            let text = text.strip_prefix('\u{feff}').unwrap_or(text);
            // lines that end with CR alone are counted as messages count them
            Ok(if text.contains('\n') { text.into() } else { text.replace('\r', "\n").into() })
        }
        Err(error) => {
            let good = &bytes[..error.valid_up_to()];
            let line = 1 + good.iter().filter(|byte| **byte == b'\n').count();
            let byte = bytes.get(error.valid_up_to()).copied().unwrap_or(0);
            Err(format!("it is not UTF-8 text (byte 0x{byte:02x} in line {line}); save it as UTF-8"))
        }
    }
}

/// A table that has been read: its rows, and the column of each wanted name.
pub struct DataTable {
    /// True if the table is a state that a run has saved, with all its lines unchanged.
    pub saved: bool,
    /// True if another program, and not the user, has written the table.
    pub foreign: bool,
    /// Lines above the header, as keys and values.
    pub head: Vec<(String, String)>,
    /// Column of each wanted name, if the table has it.
    pub(super) columns: Vec<Option<usize>>,
    /// Unit of each wanted name, if the header gives one; else SI.
    pub(super) units: Vec<Option<String>>,
    pub(super) rows: Vec<(csv::StringRecord, Origin)>,
}

/// One row of a table.
#[derive(Clone, Copy)]
pub struct TableRow<'a> {
    table: &'a DataTable,
    record: &'a csv::StringRecord,
    /// Source position of the line.
    pub origin: &'a Origin,
}

impl DataTable {
    /// True if the table has the wanted column.
    pub fn has(&self, wanted: usize) -> bool {
        self.columns.get(wanted).is_some_and(Option::is_some)
    }

    /// The rows in the order of the file.
    pub fn rows(&self) -> impl Iterator<Item = TableRow<'_>> {
        self.rows.iter().map(|(record, origin)| TableRow { table: self, record, origin })
    }
}

impl<'a> TableRow<'a> {
    /// The text of a wanted column, if the table has it.
    pub fn text(&self, wanted: usize) -> Option<&'a str> {
        let column = (*self.table.columns.get(wanted)?)?;
        self.record.get(column).map(of_cell)
    }
}

/// The name of a column and, if it ends with a suitable one, its unit: `x_mm` is `x` in mm, `vx_mm_s` is `vx` in mm/s.
/// Wanted names that contain such an ending are kept whole and have no unit.
fn with_unit<'a>(column: &'a str, wanted: &[&str]) -> (&'a str, Option<String>) {
    let split = column.split_once('_').filter(|(name, _)| !wanted.contains(&column) && wanted.contains(name));
    let unit = |(name, unit): (&'a str, &str)| {
        let unit = unit.replace('_', "/");
        quantity::parse(&format!("1 {unit}"), dimension(name)).is_ok().then_some((name, Some(unit)))
    };
    split.and_then(unit).unwrap_or((column, None))
}

/// Powers of m, kg and s for a column of a start: velocities begin with v, the others are lengths.
fn dimension(column: &str) -> [i8; 3] {
    if column.starts_with('v') { [1, 0, -1] } else { [1, 0, 0] }
}

impl Resolver {
    /// Reads the table named by `name`. It has a header with the `required` columns and perhaps some `optional` ones,
    /// in any order. [`TableRow::text`] counts them in the order of these two lists.
    pub(super) fn table(
        &mut self,
        name: &Located<String>,
        required: &[&str],
        optional: &[&str],
    ) -> Result<DataTable, Diagnostic> {
        let (source, text) = self.read_named(name)?;
        self.csv_table(name, (source, &text), required, optional)
    }

    /// Reads a table from a text that is already a source.
    pub(super) fn csv_table(
        &self,
        name: &Located<String>,
        (source, text): (usize, &str),
        required: &[&str],
        optional: &[&str],
    ) -> Result<DataTable, Diagnostic> {
        let first_line = Origin { source, span: 0..text.find('\n').unwrap_or(text.len()) };
        let saved = saved::verify(text).map_err(|message| {
            let help = "save the state again; if the change is meant, remove the first line and what it vouches for";
            self.sources.error(&first_line, message).help(help)
        })?;
        let expected = format!("the first line of such a table is `{}`", required.join(","));
        let mut reader =
            csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text.as_bytes());
        let header = reader
            .headers()
            .map_err(|error| self.sources.error(&first_line, format!("no table: {error}")).help(&expected))?
            .clone();
        let start = header.position().map_or(0, |position| position.byte() as usize);
        let first_line = self.row_origin(source, text, start);
        let wanted: Vec<&str> = required.iter().chain(optional).copied().collect();
        let names: Vec<(&str, Option<String>)> = header.iter().map(|column| with_unit(column, &wanted)).collect();
        if let Some((unknown, _)) = names.iter().find(|(column, _)| !wanted.contains(column)) {
            let message = format!("unknown column `{}` in the header of `{}`", quote(unknown), name.value);
            return Err(self.sources.error(&first_line, message).help(suggestion(unknown, &wanted, "columns")));
        }
        let place = |wanted: &str| names.iter().position(|(known, _)| *known == wanted);
        if let Some((_, (twice, _))) = names.iter().enumerate().find(|(at, (known, _))| place(known) != Some(*at)) {
            let message = format!("the header of `{}` names the column `{twice}` twice", name.value);
            return Err(self.sources.error(&first_line, message).help("keep one of them"));
        }
        let columns: Vec<Option<usize>> = wanted.iter().map(|column| place(column)).collect();
        let units = columns.iter().map(|column| names[(*column)?].1.clone()).collect();
        let missing: Vec<&str> = required.iter().copied().filter(|column| place(column).is_none()).collect();
        if !missing.is_empty() {
            let message = format!("the header of `{}` lacks {}", name.value, missing.join(", "));
            return Err(self.sources.error(&first_line, message).help(expected));
        }
        let rows = reader.into_records().map(|record| self.row(source, text, record)).collect::<Result<_, _>>()?;
        let head =
            if saved { saved::head(text).map(|(key, value)| (key.into(), value.into())).collect() } else { Vec::new() };
        Ok(DataTable { saved, foreign: false, head, columns, units, rows })
    }

    /// One line of numbers and its source position.
    fn row(
        &self,
        source: usize,
        text: &str,
        record: csv::Result<csv::StringRecord>,
    ) -> Result<(csv::StringRecord, Origin), Diagnostic> {
        let place = |position: Option<&csv::Position>| {
            self.row_origin(source, text, position.map_or(0, |position| position.byte() as usize))
        };
        let error = match record {
            Ok(record) => {
                let origin = place(record.position());
                return Ok((record, origin));
            }
            Err(error) => error,
        };
        let message = match error.kind() {
            csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                format!("the line has {len} fields where the header has {expected_len}")
            }
            _ => error.to_string(),
        };
        let help = "one value for each column of the header";
        Err(self.sources.error(&place(error.position()), message).help(help))
    }

    /// Source position of the line at or after byte `start`.
    fn row_origin(&self, source: usize, text: &str, start: usize) -> Origin {
        let rest = text.get(start..).unwrap_or("");
        let start = start + (rest.len() - rest.trim_start().len());
        let end = text.get(start..).and_then(|rest| rest.find('\n')).map_or(text.len(), |at| start + at);
        Origin { source, span: start..end.max(start) }
    }

    /// [SI] a number in a row.
    pub(super) fn number(&self, row: TableRow<'_>, wanted: usize, column: &str) -> Result<f64, Diagnostic> {
        let text = row.text(wanted).unwrap_or("");
        let number = match row.table.units.get(wanted).and_then(Option::as_deref) {
            // read together with its unit, the number is rounded as in a case
            Some(unit) if !text.is_empty() => quantity::parse(&format!("{text} {unit}"), dimension(column)).ok(),
            _ => text.parse::<f64>().ok(),
        };
        match number {
            Some(number) if number.is_finite() => Ok(number),
            _ => Err(self
                .sources
                .error(row.origin, format!("`{column}` = {:?} is not a finite number", quote(text)))
                .help("plain SI numbers, with a point as the decimal mark")),
        }
    }

    /// (y [m], U [m/s]) of a velocity profile, y increasing.
    pub(super) fn profile_table(&mut self, name: &Located<String>) -> Result<Vec<(f64, f64)>, Diagnostic> {
        let table = self.table(name, &["y_m", "U_m_s"], &[])?;
        let mut points: Vec<(f64, f64)> = Vec::new();
        for row in table.rows() {
            let point = (self.number(row, 0, "y_m")?, self.number(row, 1, "U_m_s")?);
            if points.last().is_some_and(|last| point.0 <= last.0) {
                let message = format!("`y_m` = {:e} does not increase from line to line", point.0);
                return Err(self.sources.error(row.origin, message).help("sort the table by distance from the wall"));
            }
            points.push(point);
        }
        if points.is_empty() {
            return Err(self.refuse(name, "has a header but no line of numbers").help("add at least two points"));
        }
        Ok(points)
    }
}
