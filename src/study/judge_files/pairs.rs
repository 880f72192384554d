//! Pairs of columns that are compared: those that the settings name, or all columns with the same name on both sides.

use super::settings::{JudgeFile, JudgedAs, QuantityFile};
use super::side::{JudgeSide, MeasuredPoint, SideData};
use crate::case::located::Located;
use crate::case::{Diagnostic, Sources, nearest};
use crate::legible::quote;

/// Quantity that is compared, with its columns in the data of both sides, A and B.
pub struct ComparedColumns {
    /// Name of the quantity in sentences.
    pub name: String,
    /// Names of the columns on side A and on side B. In a table of single values, labels of values take the place of
    /// these names.
    pub columns: [String; 2],
    /// Factors by which the values of the columns of A and B are multiplied, to convert them to the unit of the
    /// comparison.
    pub factors: [f64; 2],
    /// SI unit in which the values are compared; empty if the settings give no unit.
    pub unit: String,
    /// Kind of comparison that the settings ask for. `None` means averages if both sides are steady, else curves.
    pub compare: Option<JudgedAs>,
    /// [-] largest difference that counts as equivalent, divided by the scale of the quantity.
    pub margin: f64,
    /// Scale by which differences are divided, in the unit of the comparison. `None` stands for the magnitude of the
    /// value of side B.
    pub scale: Option<f64>,
}

/// Pairs of columns that are compared, and notes for the reader on columns that are left out.
///
/// # Errors
/// Returns an error if a column that the settings name does not exist, if units do not agree, or if no column has the
/// same name on both sides.
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

/// Quantity that a table `[[quantities]]` of the settings describes. `margin` [-] is the largest difference accepted as
/// equivalent, if the table gives none.
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

/// First file of a side that has no column or point called `name`, with a text that lists the names in the file. `None`
/// if every file has a column or point of this name.
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

/// Quantities that are compared if the settings name none: columns or points with the same name on both sides. Also
/// returns notes for the reader. Times, numbers of time steps and names of variants (experiments of a case) are left
/// out. A column with cells that are not numbers is left out, and a note says so.
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

/// Names of columns or points of a side, as two lists. The first list has the columns of numbers, or the labels of
/// points. The second list has the columns that are left out because some cells are not numbers.
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
