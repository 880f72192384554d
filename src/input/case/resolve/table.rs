//! Reads CSV tables of numbers, such as initial positions or velocity profiles. Every error refers to a line of the
//! table.

use super::Resolver;
use crate::case::de::suggestion;
use crate::case::diagnostic::Diagnostic;
use crate::case::located::Located;
use crate::case::quantity;
use crate::case::saved;
use crate::case::source::Origin;
use crate::legible::{of_cell, quote};
use crate::memory::{available, lack, size};
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// [byte] largest size of a file that is read without a check of the free memory. If the free memory is not known,
/// larger files are refused.
const SHORT: u64 = 1 << 28;

/// [byte] memory per byte of a table while it is read. It was 4.6 with 10⁷ particles of a saved state (2026-11-30), and
/// is rounded up because each row takes some memory besides its text.
const MEMORY_PER_BYTE: f64 = 8.0;

/// Reads a whole file into memory.
///
/// # Errors
/// A message in words: the file does not exist, is a folder, a pipe or a device, or is too long for the free memory.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, String> {
    let told = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".to_string(),
        _ => error.to_string(),
    };
    // this is checked before opening, because opening a pipe without a writer would wait forever
    let metadata = std::fs::metadata(path).map_err(told)?;
    let kind = metadata.file_type();
    if kind.is_dir() {
        return Err("it is a folder, not a file".into());
    }
    if !kind.is_file() {
        return Err("it is a pipe or a device, not a regular file; save what it gives as a file".into());
    }
    let longest = longest(metadata.len())?;
    let file = std::fs::File::open(path).map_err(told)?;
    let mut bytes = Vec::new();
    file.take(longest + 1).read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    if bytes.len() as u64 > longest {
        return Err(format!("it is longer than {}", size(longest as f64)));
    }
    Ok(bytes)
}

/// [byte] largest number of bytes that is read of a file of the size `length` [byte]. Without a limit, a wrong file
/// could fill the memory.
///
/// # Errors
/// A message in words: the memory for so long a file is not free.
fn longest(length: u64) -> Result<u64, String> {
    let need = MEMORY_PER_BYTE * length as f64;
    match (length > SHORT, lack(need)) {
        (true, Some(lack)) => Err(format!("it is {} long, and reading it takes {lack}", size(length as f64))),
        (true, None) if available().is_some() => Ok(length),
        _ => Ok(SHORT),
    }
}

/// True if symbolic links in the path of a file lead out of the `folder`. False if the file does not exist.
pub fn leads_out(file: &Path, folder: &Path) -> bool {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    match (file.canonicalize(), folder.canonicalize()) {
        (Ok(file), Ok(folder)) => !file.starts_with(folder),
        _ => false,
    }
}

/// Reads a whole text file, without its byte order mark.
///
/// # Errors
/// A message in words: the file does not exist, is a folder, is too long, or is not UTF-8.
pub fn read_text(path: &Path) -> Result<Arc<str>, String> {
    text_of(&read_bytes(path)?)
}

/// Text of a file from its bytes, without a byte order mark.
///
/// # Errors
/// A message in words: the bytes are not UTF-8.
pub fn text_of(bytes: &[u8]) -> Result<Arc<str>, String> {
    match std::str::from_utf8(bytes) {
        Ok(text) => {
            let text = text.strip_prefix('\u{feff}').unwrap_or(text);
            // in a text without LF, each CR ends a line: it becomes LF, so that line numbers in messages are correct
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

/// Table of numbers that has been read: its rows, and the column of each wanted name.
pub struct DataTable {
    /// True if the table is a state saved by a run, with all lines unchanged.
    pub saved: bool,
    /// True if the table was written by another program.
    pub foreign: bool,
    /// Lines `# key: value` above the header, as pairs of key and value.
    pub head: Vec<(String, String)>,
    /// Index of the column of each wanted name; `None` if the table has no such column.
    pub(super) columns: Vec<Option<usize>>,
    /// Unit of the column of each wanted name, if the header gives one; `None` means SI.
    pub(super) units: Vec<Option<String>>,
    pub(super) rows: Vec<(csv::StringRecord, Origin)>,
}

/// Points (y, U) and (y, k, ε) of a gas profile from a table, in SI: height y, velocity U, turbulent kinetic energy k
/// and its dissipation rate ε. The second list is empty if the table lacks k or ε.
type TabulatedGas = (Vec<(f64, f64)>, Vec<[f64; 3]>);

/// One row of a table.
#[derive(Clone, Copy)]
pub struct TableRow<'a> {
    table: &'a DataTable,
    record: &'a csv::StringRecord,
    /// Source position of the row.
    pub origin: &'a Origin,
}

impl DataTable {
    /// True if the table has the column whose name has the index `wanted` in the list of wanted names.
    pub fn has(&self, wanted: usize) -> bool {
        self.columns.get(wanted).is_some_and(Option::is_some)
    }

    /// Rows of the table, in the order of the file.
    pub fn rows(&self) -> impl Iterator<Item = TableRow<'_>> {
        self.rows.iter().map(|(record, origin)| TableRow { table: self, record, origin })
    }
}

impl<'a> TableRow<'a> {
    /// Text of this row in the column whose name has the index `wanted` in the list of wanted names. `None` if the
    /// table has no such column.
    pub fn text(&self, wanted: usize) -> Option<&'a str> {
        let column = (*self.table.columns.get(wanted)?)?;
        self.record.get(column).map(of_cell)
    }
}

/// Splits the name of a column into name and unit if it ends with a unit of the right dimension: `x_mm` is `x` in mm,
/// `vx_mm_s` is `vx` in mm/s. A name that is itself among the `wanted` names is not split. The unit is `None` if the
/// name is not split.
fn with_unit<'a>(column: &'a str, wanted: &[&str]) -> (&'a str, Option<String>) {
    let split = column.split_once('_').filter(|(name, _)| !wanted.contains(&column) && wanted.contains(name));
    let unit = |(name, unit): (&'a str, &str)| {
        let unit = unit.replace('_', "/");
        quantity::parse(&format!("1 {unit}"), dimension(name)?).is_ok().then_some((name, Some(unit)))
    };
    split.and_then(unit).unwrap_or((column, None))
}

/// Exponents of m, kg and s in the dimension of a column: a velocity, a spin (angular velocity) or a length. `None` if
/// the column has other dimensions, or if its dimension depends on the row, like that of the column `value`.
fn dimension(column: &str) -> Option<[i8; 3]> {
    match column {
        "vx" | "vy" | "vz" => Some([1, 0, -1]),
        "wx" | "wy" | "wz" => Some([0, 0, -1]),
        "x" | "y" | "z" | "diameter" | "radius" => Some([1, 0, 0]),
        _ => None,
    }
}

impl Resolver {
    /// Reads the table in the file `name`. Its header must contain the `required` columns and may contain `optional`
    /// columns, in any order. [`TableRow::text`] takes an index into the list of both, the required columns first.
    pub(super) fn table(
        &mut self,
        name: &Located<String>,
        required: &[&str],
        optional: &[&str],
    ) -> Result<DataTable, Diagnostic> {
        let (source, text) = self.read_named(name)?;
        self.csv_table(name, (source, &text), required, optional)
    }

    /// Reads a table from a text whose source index is known.
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

    /// Row of the table, made from one line, with its source position.
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

    /// Source position of the first line with text at or after byte `start`.
    fn row_origin(&self, source: usize, text: &str, start: usize) -> Origin {
        let rest = text.get(start..).unwrap_or("");
        let start = start + (rest.len() - rest.trim_start().len());
        let end = text.get(start..).and_then(|rest| rest.find('\n')).map_or(text.len(), |at| start + at);
        Origin { source, span: start..end.max(start) }
    }

    /// [SI] number of a row in the column of the wanted name with the index `wanted`. `column` is the name in messages.
    pub(super) fn number(&self, row: TableRow<'_>, wanted: usize, column: &str) -> Result<f64, Diagnostic> {
        let text = row.text(wanted).unwrap_or("");
        let number = match row.table.units.get(wanted).and_then(Option::as_deref) {
            // the number is parsed together with its unit, so that it is rounded as in a case
            Some(unit) if !text.is_empty() => {
                dimension(column).and_then(|of| quantity::parse(&format!("{text} {unit}"), of).ok())
            }
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

    /// Points (y [m], U [m/s]) of a velocity profile, with increasing y. If the table has columns of the turbulent
    /// kinetic energy k [m²/s²] and of its dissipation rate ε [m²/s³], also points (y, k, ε).
    pub(super) fn profile_table(&mut self, name: &Located<String>) -> Result<TabulatedGas, Diagnostic> {
        const TURBULENCE: [&str; 2] = ["k_m2_s2", "epsilon_m2_s3"];
        let table = self.table(name, &["y_m", "U_m_s"], &TURBULENCE)?;
        let (mut points, mut turbulence): TabulatedGas = Default::default();
        for row in table.rows() {
            let point = (self.number(row, 0, "y_m")?, self.number(row, 1, "U_m_s")?);
            if points.last().is_some_and(|last| point.0 <= last.0) {
                let message = format!("`y_m` = {:e} does not increase from line to line", point.0);
                return Err(self.sources.error(row.origin, message).help("sort the table by distance from the wall"));
            }
            points.push(point);
            if table.has(2) && table.has(3) {
                let [k, epsilon] = [self.number(row, 2, TURBULENCE[0])?, self.number(row, 3, TURBULENCE[1])?];
                if k < 0.0 || epsilon <= 0.0 {
                    let message = format!("`k_m2_s2` = {k:e} and `epsilon_m2_s3` = {epsilon:e} are not possible");
                    let help = "allowed: k from 0 on, ε greater than 0; at a smooth wall k is 0 and ε is not";
                    return Err(self.sources.error(row.origin, message).help(help));
                }
                turbulence.push([point.0, k, epsilon]);
            }
        }
        if points.is_empty() {
            return Err(self.refuse(name, "has a header but no line of numbers").help("add at least two points"));
        }
        Ok((points, turbulence))
    }
}
