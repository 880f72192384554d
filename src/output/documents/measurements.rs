//! Parts of a report about the measurements that a case requests, and their tables of numbers. A variant is one of the
//! experiments of a case.

use super::run::{distinct, measured};
use crate::observe::{Observation, ObservedCurve, ObservedGrid, ObservedNumber};
use crate::outcome::Outcome;
use crate::output::OutputError;
use crate::output::csv::{CsvTable, number};
use crate::output::document::Block;
use crate::output::figures;
use crate::output::files::VTK;
use crate::output::numbers::{significant, with_error};
use crate::output::trajectory::{Vtp, contact_file};
use crate::statistics::Estimate;
use serde_json::{Value, json};

/// Name of the file with the single numbers that all measurements give.
const NUMBERS: &str = "observables.csv";

/// Table of the numbers of all measurements with their theories, followed by pictures. `pictures` returns the parts of
/// the document with the figures of a given name. The list is empty if the case requests no measurement.
pub(super) fn blocks(outcomes: &[Outcome], pictures: impl Fn(&str) -> Vec<Block>) -> Vec<Block> {
    let row = |(outcome, observed): (&Outcome, &Observation)| {
        let name = outcome.experiment.name.clone();
        let rows = observed.numbers.iter().map(move |number| {
            let unit = number.quantity.unit;
            let symbol = &number.quantity.symbol;
            let quantity = if unit.is_empty() { symbol.clone() } else { format!("{symbol} [{unit}]") };
            let (theory, source) = match number.theory {
                Some((source, value)) => (significant(value, 4), source.to_owned()),
                None => (String::new(), String::new()),
            };
            // an error that is only a rounding error, such as that for a bed at rest, counts as 0
            let is_rounding = |value: &Estimate| value.error.is_some_and(|error| error < 1e-12 * value.value.abs());
            let value =
                number.value.map(|value| if is_rounding(&value) { Estimate::exact(value.value) } else { value });
            (false, vec![name.clone(), quantity, with_error(value), theory, in_errors(number), source])
        });
        rows.collect::<Vec<_>>()
    };
    let names: Vec<&str> = names(outcomes).collect();
    if names.is_empty() {
        return Vec::new();
    }
    let files: Vec<&str> = names.iter().copied().filter(|name| has_curves(outcomes, name)).collect();
    let curves = if files.is_empty() {
        String::new()
    } else {
        format!("; the curves are in {}", distinct(files.iter().map(|name| format!("{name}.csv"))))
    };
    let head = "variant | quantity | measured | theory | difference in SE | source";
    let mut blocks = vec![
        Block::heading("Measurements that the case asks for"),
        Block::table(head, all(outcomes).flat_map(row)),
        Block::note(format!(
            "Averages over the averaging period, ± one standard error. {NUMBERS} has these numbers{curves}."
        )),
    ];
    let remarks = all(outcomes).filter_map(|(outcome, observed)| {
        let name = &outcome.experiment.name;
        Some(Block::note(format!("“{name}”, {}: {}", observed.title.to_lowercase(), observed.remark?)))
    });
    blocks.extend(remarks);
    blocks.extend(names.into_iter().flat_map(|name| pictures(&figures::of_measurement(name))));
    blocks
}

/// Text of the difference between a measured number and its theory, in standard errors of the number. Empty if there is
/// no theory or no standard error.
fn in_errors(number: &ObservedNumber) -> String {
    let exact = number.theory.map(|(_, value)| Estimate::exact(value));
    let difference = number.value.zip(exact).and_then(|(value, exact)| value.less(exact).in_errors());
    difference.map_or_else(String::new, |errors| significant(errors, 2))
}

/// Results of all measurements in all runs, each with the results of its run.
fn all(outcomes: &[Outcome]) -> impl Iterator<Item = (&Outcome, &Observation)> {
    outcomes.iter().flat_map(|outcome| outcome.observations.iter().map(move |observed| (outcome, observed)))
}

/// Names of the measurements in all runs, without repetition.
fn names(outcomes: &[Outcome]) -> impl Iterator<Item = &'static str> {
    let mut names: Vec<&'static str> = Vec::new();
    for (_, observed) in all(outcomes) {
        if !names.contains(&observed.name) {
            names.push(observed.name);
        }
    }
    names.into_iter()
}

/// True if the measurement with the name `name` gives curves in at least one run, and not only single numbers.
fn has_curves(outcomes: &[Outcome], name: &str) -> bool {
    all(outcomes).any(|(_, observed)| observed.name == name && !observed.curves.is_empty())
}

/// Single numbers that each measurement of a run gives, for `summary.json`, in SI units.
pub(super) fn json(outcome: &Outcome) -> Value {
    let numbers = |observed: &Observation| {
        let each = observed.numbers.iter().map(|number| {
            let mut value = measured(number.value);
            if let Some((source, exact)) = number.theory {
                value["theory"] = json!({ "value": exact, "source": source });
            }
            (number.quantity.column.clone(), value)
        });
        let mut values: Value = each.collect();
        if let Some(remark) = observed.remark {
            values["remark"] = remark.into();
        }
        (observed.name.to_owned(), values)
    };
    outcome.observations.iter().map(numbers).collect()
}

/// Files of the measurements, each as its name and contents: a table with the curves of each measurement, and a table
/// with the single numbers of all measurements. Contacts and fields on grids have files for ParaView.
///
/// # Errors
/// [`OutputError::Csv`] if a row cannot be encoded.
pub(super) fn tables(outcomes: &[Outcome]) -> Result<Vec<(String, Vec<u8>)>, OutputError> {
    let mut tables = Vec::new();
    for name in names(outcomes).filter(|name| has_curves(outcomes, name)) {
        let of_name: Vec<_> = all(outcomes).filter(|(_, observed)| observed.name == name).collect();
        tables.push((format!("{name}.csv"), curves(&of_name)?));
    }
    for (outcome, observed) in all(outcomes) {
        let (variant, time) = (figures::file_name(&outcome.experiment.name), outcome.simulated_seconds);
        let name = format!("{VTK}/{}-{variant}", observed.name);
        if !observed.lines.is_empty() {
            tables.push((format!("{name}.vtp"), contact_file(time, &observed.lines)));
        }
        tables.extend(observed.grid.as_ref().map(|grid| (format!("{name}.vti"), grid_file(time, grid))));
    }
    if names(outcomes).next().is_some() {
        tables.push((NUMBERS.to_owned(), numbers(outcomes)?));
    }
    Ok(tables)
}

/// Contents of the file with the curves of one measurement, with one row per variant (experiment of a case) and place
/// (abscissa of the curves). Variants may have different curves; cells of a curve that a variant lacks are empty.
fn curves(results: &[(&Outcome, &Observation)]) -> Result<Vec<u8>, OutputError> {
    let mut columns: Vec<(&str, bool)> = Vec::new();
    for curve in results.iter().flat_map(|(_, observed)| &observed.curves) {
        match columns.iter_mut().find(|(column, _)| *column == curve.quantity.column) {
            Some((_, has_theory)) => *has_theory |= curve.theory.is_some(),
            None => columns.push((&curve.quantity.column, curve.theory.is_some())),
        }
    }
    let head = columns.iter().flat_map(|(column, has_theory)| {
        let theory = has_theory.then(|| format!("{column}_theory"));
        [(*column).to_owned(), format!("{column}_se")].into_iter().chain(theory)
    });
    let axis = results.first().map_or("", |(_, observed)| &observed.axis.column);
    let mut table = CsvTable::new();
    table.row(["variant".to_owned(), axis.to_owned()].into_iter().chain(head))?;
    for (outcome, observed) in results {
        for (place, at) in observed.places.iter().enumerate() {
            let cells = columns.iter().flat_map(|(column, has_theory)| {
                let curve = observed.curves.iter().find(|curve| curve.quantity.column == *column);
                let value = curve.and_then(|curve| curve.values[place]);
                let theory = |curve: &ObservedCurve| curve.theory.as_ref().map(|(_, values)| values[place]);
                let known = [value.map(|value| value.value), value.and_then(|value| value.error)];
                known.into_iter().chain(has_theory.then(|| curve.and_then(theory)))
            });
            let cells = cells.map(number).collect::<Vec<_>>();
            table.row([outcome.experiment.name.clone(), number(*at)].into_iter().chain(cells))?;
        }
    }
    table.bytes()
}

/// Contents of `observables.csv`: the single numbers that all measurements give, with their theories.
fn numbers(outcomes: &[Outcome]) -> Result<Vec<u8>, OutputError> {
    let mut table = CsvTable::new();
    table.head("variant,measurement,quantity,unit,value,value_se,theory,source")?;
    for (outcome, observed) in all(outcomes) {
        for found in &observed.numbers {
            let names = [&outcome.experiment.name, observed.name, &found.quantity.column, found.quantity.unit];
            let values = [
                found.value.map(|value| value.value),
                found.value.and_then(|value| value.error),
                found.theory.map(|(_, value)| value),
            ];
            let source = found.theory.map_or("", |(source, _)| source).to_owned();
            table.row(names.map(str::to_owned).into_iter().chain(values.map(number)).chain([source]))?;
        }
    }
    table.bytes()
}

/// File for ParaView with time averages in the cells of a grid. `time` [s] is the end of the run.
fn grid_file(time: f64, grid: &ObservedGrid) -> Vec<u8> {
    Vtp::of_grid(time, grid.cells, grid.spacing.into(), |file| {
        for (name, components, values) in &grid.fields {
            match components {
                1 => file.array(name, values.iter().map(|value| [*value])),
                3 => file.array(name, values.as_chunks::<3>().0.iter().copied()),
                // ParaView expects a symmetric tensor in the order xx, yy, zz, xy, yz, xz
                _ => {
                    let cells = values.as_chunks::<6>().0.iter();
                    file.array(name, cells.map(|[xx, yy, zz, xy, xz, yz]| [*xx, *yy, *zz, *xy, *yz, *xz]));
                }
            }
        }
    })
}
