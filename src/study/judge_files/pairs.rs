//! Pairs of columns that are compared: those that the settings name, or all columns of equal names.

use super::settings::{JudgeFile, JudgedAs, QuantityFile};
use super::side::{JudgeSide, MeasuredPoint, SideData};
use crate::case::de::Located;
use crate::case::{Diagnostic, Sources, nearest};
use crate::legible::quote;

/// Quantity that is compared, with its columns on both sides.
pub struct ComparedColumns {
    /// Name of the quantity in sentences.
    pub name: String,
    /// Names of the columns on side A and side B or, in a table of points, labels of the points.
    pub columns: [String; 2],
    /// Factors by which the values of both columns are multiplied to get the unit of the comparison.
    pub factors: [f64; 2],
    /// SI unit of the comparison; empty if no unit is given.
    pub unit: String,
    /// Kind of comparison, averages or curves. `None`: averages if both sides are steady, else curves.
    pub compare: Option<JudgedAs>,
    /// [-] margin within which differences count as equivalent, relative to the scale of the quantity.
    pub margin: f64,
    /// Size to which differences are relative, in the unit of the comparison; `None` for the magnitude of the value of
    /// side B.
    pub scale: Option<f64>,
}

/// Pairs of columns of a comparison, and notes about columns that are left out.
///
/// # Errors
/// A column that the settings name does not exist, units do not agree, or the sides have no column in common.
pub fn compared_columns(
    file: &JudgeFile,
    margin: f64,
    sides: &[JudgeSide; 2],
    sources: &Sources,
) -> Result<(Vec<ComparedColumns>, Vec<String>), Diagnostic> {
    if file.quantities.is_empty() {
        return equal_names(margin, sides);
    }
    let mut all: Vec<ComparedColumns> = Vec::new();
    for one in &file.quantities {
        let columns = named(one, margin, sides, sources)?;
        if all.iter().any(|other| other.name == columns.name) {
            let message = format!("`{}`: there are two quantities \"{}\"", one.path, quote(&columns.name));
            return Err(sources.error(&one.origin, message).help("give each its own `name`"));
        }
        all.push(columns);
    }
    Ok((all, Vec::new()))
}

/// Quantity that a table `[[quantities]]` of the settings names. `margin` [-] applies if the table gives none.
fn named(
    one: &Located<QuantityFile>,
    margin: f64,
    sides: &[JudgeSide; 2],
    sources: &Sources,
) -> Result<ComparedColumns, Diagnostic> {
    let quantity = &one.value;
    let (factors, unit) = quantity.units(one, sources)?;
    for (side, column) in sides.iter().zip([&quantity.a, &quantity.b]) {
        if let Some((file, help)) = lacking(side, &column.value) {
            let message = format!("`{}`: {file} has no column or point `{}`", column.path, quote(&column.value));
            return Err(sources.error(&column.origin, message).help(help));
        }
    }
    Ok(ComparedColumns {
        name: quantity.name.clone().unwrap_or_else(|| quantity.b.value.clone()),
        columns: [&quantity.a, &quantity.b].map(|column| column.value.clone()),
        factors,
        unit,
        compare: quantity.compare,
        margin: quantity.margin.as_ref().map_or(margin, |margin| margin.value.0),
        scale: quantity.scale.as_ref().map(|scale| scale.value),
    })
}

/// First file of a side that has no column (or point) of this name, with the names that the file has instead; `None` if
/// every file has the name.
fn lacking(side: &JudgeSide, name: &str) -> Option<(String, String)> {
    match &side.data {
        SideData::Series(series) => {
            let lacking = series.replicas.iter().find(|one| one.table.column(name).is_none())?;
            Some((format!("`{}`", lacking.table.name), lacking.table.suggestion(name)))
        }
        SideData::Points(points) => {
            if points.iter().any(|point| point.label == name) {
                return None;
            }
            let labels: Vec<&str> = points.iter().map(|point| point.label.as_str()).take(30).collect();
            let all = format!("its points: {}", labels.join(", "));
            let help = nearest(name, &labels).map_or(all.clone(), |known| format!("did you mean `{known}`? ({all})"));
            Some((format!("`{}`", side.name), help))
        }
    }
}

/// Quantities made of columns or points that have equal names on both sides, except times; and notes. A column with
/// cells that are no numbers is left out with a note.
fn equal_names(margin: f64, sides: &[JudgeSide; 2]) -> Result<(Vec<ComparedColumns>, Vec<String>), Diagnostic> {
    let (first, left_out) = names(&sides[0]);
    let (second, more) = names(&sides[1]);
    let common: Vec<&String> = first.iter().filter(|name| second.contains(name)).collect();
    if common.is_empty() {
        let message = format!("`{}` and `{}` have no column of numbers with one name", sides[0].name, sides[1].name);
        let [first, second] = [first, second].map(|names| names.join(", "));
        let help = format!("name pairs of columns in --settings judge.toml; A has: {first}; B has: {second}");
        return Err(Diagnostic::about(&sides[1].name, message).help(help));
    }
    let one = |name: &String| ComparedColumns {
        name: name.clone(),
        columns: [name.clone(), name.clone()],
        factors: [1.0; 2],
        unit: String::new(),
        compare: None,
        margin,
        scale: None,
    };
    let mut left_out: Vec<String> = left_out.into_iter().chain(more).collect();
    left_out.sort();
    left_out.dedup();
    let notes = (!left_out.is_empty())
        .then(|| format!("Columns with cells that are no numbers are left out: {}.", left_out.join(", ")));
    Ok((common.into_iter().map(one).collect(), notes.into_iter().collect()))
}

/// Names of a side: first those of all columns of numbers, or labels of points, then those of the columns that are left
/// out.
fn names(side: &JudgeSide) -> (Vec<String>, Vec<String>) {
    match &side.data {
        SideData::Points(points) => {
            (points.iter().map(|point: &MeasuredPoint| point.label.clone()).collect(), Vec::new())
        }
        SideData::Series(series) => {
            let Some(first) = series.replicas.first() else { return (Vec::new(), Vec::new()) };
            const COUNTS: [&str; 4] = ["variant", "Step", "TimeStep", "step"];
            let in_all = |name: &&String| series.replicas.iter().all(|one| one.table.column(name).is_some());
            let columns = first.table.columns.iter().enumerate();
            let wanted =
                columns.filter(|(k, name)| *k != first.time && !COUNTS.contains(&name.as_str())).map(|(_, name)| name);
            let numeric = |name: &&String| {
                series
                    .replicas
                    .iter()
                    .all(|one| one.table.column(name).is_some_and(|column| one.table.is_numeric(column)))
            };
            let (kept, others): (Vec<&String>, Vec<&String>) = wanted.filter(in_all).partition(numeric);
            (kept.into_iter().cloned().collect(), others.into_iter().cloned().collect())
        }
    }
}
