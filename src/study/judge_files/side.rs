//! One side of a comparison of files: series over time of several replicas (runs with different seeds), or a table of
//! single values (points).

use super::settings::SideFile;
use super::table::NumberTable;
use crate::case::{Diagnostic, Sources};
use crate::legible::quote;
use crate::output::numbers::significant;
use std::ops::Range;
use std::path::Path;

/// Known names of the column of times, the preferred names first.
const TIMES: [&str; 9] = ["t_s", "time_s", "time", "Time", "t", "Step", "TimeStep", "step", "frame"];

/// Names of columns of times that count time steps, or number the instants of a file.
const STEPS: [&str; 4] = ["Step", "TimeStep", "step", "frame"];

/// Columns of a table of single values that are not part of the label of a value.
const POINT: [&str; 2] = ["value", "standard_error"];

/// [-] largest deviation of a time from equal spacing, divided by the spacing, in a series that can be averaged.
const SPACING: f64 = 1e-3;

/// One side of a comparison of files, with its data.
pub struct JudgeSide {
    /// Name of the side (A or B of the comparison) in sentences.
    pub name: String,
    /// Paths of all files of the side (A or B of the comparison), as the user typed them.
    pub paths: Vec<String>,
    /// Data from the files of the side: series over time, or a table of single values.
    pub data: SideData,
}

/// Data of one side (A or B) of a comparison: series over time, or a table of values without times.
pub enum SideData {
    /// Series over time, with one table for each replica (run with its own seed).
    Series(SeriesFiles),
    /// Table of single values, each with a label and a standard error.
    Points(Vec<MeasuredPoint>),
}

/// Series over time of one side (A or B) of a comparison, from all its replicas (runs with different seeds).
pub struct SeriesFiles {
    /// Tables of the replicas (runs with different seeds), one per file.
    pub replicas: Vec<TimedTable>,
    /// True if the times of this side can be compared with those of the other side. This holds if a unit of time is
    /// given, or if the column of times does not count time steps.
    pub unit_known: bool,
    /// Start of averaging, in seconds or, if `unit_known` is false, in the unit of the column of times. `None` if the
    /// start is not given; the test for steadiness then finds it.
    pub from: Option<f64>,
}

/// Table of one file whose times increase from row to row.
pub struct TimedTable {
    /// Table of numbers with the columns of the file.
    pub table: NumberTable,
    /// Index of the column of times in `table`.
    pub time: usize,
    /// Times of the rows, in seconds or, if no unit is given, in the unit of their column.
    pub times: Vec<f64>,
    /// Index of the row of the table for each entry of `times`. Rows that repeat the time of the previous row are left
    /// out.
    pub rows: Vec<usize>,
}

/// One row of a table of single values: a value, its standard error and its label.
pub struct MeasuredPoint {
    /// Label of the value: all cells of its row except the value and the standard error.
    pub label: String,
    /// Measured value, in the unit of its column.
    pub value: f64,
    /// Standard error of the value, in the unit of the value; `None` if the table gives no standard error.
    pub error: Option<f64>,
}

impl JudgeSide {
    /// Reads all files of one side (A or B) of a comparison. `argument` is the list of the files in the command,
    /// separated by commas. If it is `None`, the table `file` of `judge.toml` names the files, relative to `folder`.
    /// `key` is the letter of the side, for messages.
    ///
    /// # Errors
    /// Returns an error if a file cannot be read, if it has no column of times, or if its times do not increase.
    pub fn read(
        argument: Option<&str>,
        file: &SideFile,
        folder: &Path,
        key: char,
        sources: &mut Sources,
    ) -> Result<Self, Diagnostic> {
        let listed = file.files.iter().flatten().map(|one| folder.join(&one.value).display().to_string());
        let names: Vec<String> = match argument {
            Some(argument) => argument.split(',').filter(|name| !name.is_empty()).map(str::to_owned).collect(),
            None => listed.collect(),
        };
        if names.is_empty() {
            let message = format!("the side {} has no file", key.to_uppercase());
            let help =
                format!("name it on the command line, or as `files = [...]` in the table `[{key}]` of --settings");
            return Err(Diagnostic::about("diptych judge", message).help(help));
        }
        let tables: Vec<NumberTable> = names
            .iter()
            .map(|name| NumberTable::read(name, file.slices.as_ref(), sources))
            .collect::<Result<_, _>>()?;
        let name = file.name.clone().unwrap_or_else(|| {
            let first =
                Path::new(&names[0]).file_name().map_or(names[0].as_str().into(), |name| name.to_string_lossy());
            if names.len() == 1 { first.into_owned() } else { format!("{first} and {} more", names.len() - 1) }
        });
        let is_points = |table: &NumberTable| table.column("value").is_some() && table.column_of_times(file).is_none();
        let data = if let Some(table) = tables.iter().find(|table| is_points(table)) {
            if tables.len() > 1 {
                let message = format!("`{}` is a table of points, among other files", table.name);
                return Err(Diagnostic::about(&table.name, message)
                    .help("one table of points makes a side; several files are replicas of a series"));
            }
            SideData::Points(points(table, sources)?)
        } else {
            SideData::Series(SeriesFiles::of(tables, file, sources)?)
        };
        Ok(Self { name, paths: names, data })
    }

    /// Warnings for the user about the files of the side (A or B of the comparison).
    pub fn warnings(&self) -> Vec<String> {
        let SideData::Series(series) = &self.data else { return Vec::new() };
        let of = |one: &TimedTable| {
            one.table
                .warnings
                .iter()
                .map(|warning| format!("`{}`: {}.", one.table.name, warning.message))
                .collect::<Vec<_>>()
        };
        series.replicas.iter().flat_map(of).collect()
    }
}

impl NumberTable {
    /// Index of the column of times: the column that the settings name, else the first column with a known name. `None`
    /// if there is no such column.
    fn column_of_times(&self, file: &SideFile) -> Option<usize> {
        match &file.time {
            Some(name) => self.column(&name.value),
            None => TIMES.iter().find_map(|name| self.column(name)),
        }
    }
}

impl SeriesFiles {
    fn of(tables: Vec<NumberTable>, file: &SideFile, sources: &Sources) -> Result<Self, Diagnostic> {
        let factor = file.time_factor(sources)?;
        let mut is_step = false;
        let mut replicas = Vec::new();
        for table in tables {
            let Some(time) = table.column_of_times(file) else {
                return Err(match &file.time {
                    Some(name) => {
                        let message = format!("`{}` has no column `{}`", table.name, quote(&name.value));
                        sources.error(&name.origin, message).help(table.suggestion(&name.value))
                    }
                    None => Diagnostic::about(&table.name, format!("`{}` has no column of times", table.name)).help(
                        format!(
                            "name it by `time = \"...\"` in --settings, or give a table of points a column `value`; {}",
                            table.suggestion("time")
                        ),
                    ),
                });
            };
            is_step |= STEPS.contains(&table.columns[time].as_str());
            replicas.push(TimedTable::of(table, time, factor.unwrap_or(1.0), sources)?);
        }
        let from = file.from.as_ref().map(|from| from.value * factor.unwrap_or(1.0));
        if let (Some(from), Some(given)) = (from, &file.from) {
            let too_late = |one: &&TimedTable| one.times.last().is_none_or(|last| *last < from);
            if let Some(short) = replicas.iter().find(too_late) {
                let message =
                    format!("`{}` = {} is after the last time of `{}`", given.path, given.value, short.table.name);
                return Err(sources.error(&given.origin, message).help("`from` has the unit of the column of times"));
            }
        }
        Ok(Self { replicas, unit_known: factor.is_some() || !is_step, from })
    }
}

impl TimedTable {
    fn of(table: NumberTable, time: usize, factor: f64, sources: &Sources) -> Result<Self, Diagnostic> {
        let (mut times, mut rows) = (Vec::<f64>::new(), Vec::new());
        for row in 0..table.len() {
            let now = table.number(row, time, sources)? * factor;
            match times.last() {
                // LAMMPS repeats the last row of a run as the first row of the next run
                Some(last) if now == *last => continue,
                Some(last) if now < *last => {
                    let (name, before) = (&table.columns[time], last / factor);
                    let message = format!("`{name}` = {} comes after {before}: times must increase", now / factor);
                    let help = "keep one run of the file, or name another column of times by `time = \"...\"`, such as `Time` of LAMMPS";
                    return Err(sources.error(&table.origin(row), message).help(help));
                }
                _ => {}
            }
            times.push(now);
            rows.push(row);
        }
        Ok(Self { table, time, times, rows })
    }

    /// Values of a column at all times, in the unit of the column. `column` is the index of the column.
    ///
    /// # Errors
    /// Returns an error if a cell contains no finite number.
    pub fn values(&self, column: usize, sources: &Sources) -> Result<Vec<f64>, Diagnostic> {
        self.rows.iter().map(|row| self.table.number(*row, column, sources)).collect()
    }

    /// Time between two rows, in the unit of `times`, and the range of indices of the times from `from` on (all times
    /// if `from` is `None`). With fewer than two such times the first result is 1. A last row that does not fit the
    /// spacing is left out, since some programs write a further row at the end of a run.
    ///
    /// # Errors
    /// Returns an error if the times are not equally spaced. Averages over time would then need weights.
    pub fn spacing(&self, from: Option<f64>, sources: &Sources) -> Result<(f64, Range<usize>), Diagnostic> {
        let count = self.times.len();
        let start = from.map_or(0, |from| self.times.partition_point(|time| *time < from - 1e-9 * from.abs()));
        let [first, second, ..] = self.times[start..] else { return Ok((1.0, start..count)) };
        let interval = second - first;
        let off = |row: usize| {
            // times are often written with six digits, so the spacing has a small error; the error of a predicted time
            // grows from row to row
            let steps = (row - start) as f64;
            (self.times[row] - first - steps * interval).abs() > SPACING * interval * (1.0 + 1e-3 * steps)
        };
        match (start..count).find(|row| off(*row)) {
            None => Ok((interval, start..count)),
            Some(last) if last + 1 == count && last > start + 2 => Ok((interval, start..count - 1)),
            Some(row) => {
                let message = format!(
                    "`{}` = {} does not follow the spacing {} of the rows before",
                    self.table.columns[self.time],
                    self.table.text(self.rows[row], self.time),
                    significant(interval, 6)
                );
                let help = "averages need samples at equal times; begin later by `from`, or compare curves by `compare = \"curve\"`";
                Err(sources.error(&self.table.origin(self.rows[row]), message).help(help))
            }
        }
    }
}

/// Values of a table, each with standard error and label. The label of a row consists of all its cells except the value
/// and the standard error.
fn points(table: &NumberTable, sources: &Sources) -> Result<Vec<MeasuredPoint>, Diagnostic> {
    let (value, error) = (table.column("value").unwrap_or_default(), table.column("standard_error"));
    let labels: Vec<usize> =
        (0..table.columns.len()).filter(|k| !POINT.contains(&table.columns[*k].as_str())).collect();
    let mut points: Vec<MeasuredPoint> = Vec::new();
    for row in 0..table.len() {
        let cells: Vec<String> = labels.iter().map(|column| table.text(row, *column)).collect();
        let error = match error {
            Some(column) if !table.text(row, column).is_empty() => Some(table.number(row, column, sources)?),
            _ => None,
        };
        if let Some(negative) = error.filter(|error| *error < 0.0) {
            let message = format!("`standard_error` = {negative} is negative");
            return Err(sources
                .error(&table.origin(row), message)
                .help("a standard error is 0 (exact) or greater; leave the cell empty if it is unknown"));
        }
        let point = MeasuredPoint { label: cells.join(" "), value: table.number(row, value, sources)?, error };
        if points.iter().any(|other| other.label == point.label) {
            let message = format!("the point \"{}\" occurs twice", quote(&point.label));
            return Err(sources
                .error(&table.origin(row), message)
                .help("each point needs its own label in the columns beside `value` and `standard_error`"));
        }
        points.push(point);
    }
    Ok(points)
}
