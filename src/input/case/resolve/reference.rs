//! Reads the reference of a variant: the name of another variant, or a table of values with standard errors. A variant
//! is the case with one collision model and some settings.

use super::Resolver;
use super::table::TableRow;
use crate::case::against::AgainstFile;
use crate::case::de::suggestion;
use crate::case::diagnostic::Diagnostic;
use crate::case::located::Located;
use crate::experiment::{Reference, ReferencePoint, ReferenceTable};
use crate::legible::quote;
use crate::scene::Scene;
use crate::statistics::{MOST_STATED, SLICE_COLUMNS};

/// Quantities of a reference table that are averages over the whole scene, so that they have no position y.
const OF_THE_SCENE: [&str; 3] = ["granular_temperature", "pair_impact_rate", "wall_impact_rate"];

// indices of the columns of a table, the required ones first
const QUANTITY: usize = 0;
const VALUE: usize = 1;
const ERROR: usize = 2;
const Y: usize = 3;

impl Resolver {
    /// Reads the reference of a variant: another variant, or a table of values.
    ///
    /// # Errors
    /// The table cannot be read, or contains an unknown quantity, a place outside the domain or a negative error.
    pub(super) fn reference(&mut self, against: &AgainstFile, scene: &Scene) -> Result<Reference, Diagnostic> {
        match against {
            AgainstFile::Variant(name) => Ok(Reference::Variant(name.clone())),
            AgainstFile::Table(file) => Ok(Reference::Table(self.reference_table(file, scene.domain.size.y)?)),
        }
    }

    fn reference_table(&mut self, file: &Located<String>, height: f64) -> Result<ReferenceTable, Diagnostic> {
        let table = self.table(file, &["quantity", "value", "standard_error"], &["y"])?;
        let points: Vec<ReferencePoint> =
            table.rows().map(|row| self.reference_point(row, height)).collect::<Result<_, _>>()?;
        if points.is_empty() || points.len() > MOST_STATED {
            let message = format!("names a table with {} values", points.len());
            return Err(self.refuse(file, message).help(format!("a table has 1 to {MOST_STATED} values")));
        }
        Ok(ReferenceTable { name: file.value.clone(), points })
    }

    fn reference_point(&self, row: TableRow, height: f64) -> Result<ReferencePoint, Diagnostic> {
        let wrong = |message: String, help: String| self.sources.error(row.origin, message).help(help);
        let quantity = row.text(QUANTITY).unwrap_or_default();
        let is_of_slices = SLICE_COLUMNS.iter().any(|column| column.name == quantity);
        if !is_of_slices && !OF_THE_SCENE.contains(&quantity) {
            let known: Vec<&str> = SLICE_COLUMNS.iter().map(|column| column.name).chain(OF_THE_SCENE).collect();
            let message = format!("`quantity` = \"{}\" is not known", quote(quantity));
            return Err(wrong(message, suggestion(quantity, &known, "quantities")));
        }
        let given = |wanted: usize| row.text(wanted).is_some_and(|text| !text.is_empty());
        let y = given(Y).then(|| self.number(row, Y, "y")).transpose()?;
        let standard_error = given(ERROR).then(|| self.number(row, ERROR, "standard_error")).transpose()?;
        if let Some(negative) = standard_error.filter(|error| *error < 0.0) {
            let help = "leave the cell empty if the error is not known".to_owned();
            return Err(wrong(format!("`standard_error` = {negative} is negative"), help));
        }
        match y {
            Some(y) if !is_of_slices => {
                let message = format!("{quantity} has a place, y = {y} m, but is an average over the whole scene");
                return Err(wrong(message, "leave the cell of y empty".into()));
            }
            Some(y) if !(0.0..=height).contains(&y) => {
                let help =
                    format!("the domain reaches from 0 m to {height} m; SI units, or a unit in the header (`y_mm`)");
                return Err(wrong(format!("y = {y} m is outside the domain"), help));
            }
            None if is_of_slices => {
                let message = format!("{quantity} is an average over a slice, and the row has no y");
                return Err(wrong(message, "add a column `y_m` with the distance from the lower side".into()));
            }
            _ => {}
        }
        Ok(ReferencePoint {
            quantity: quantity.to_owned(),
            y,
            value: self.number(row, VALUE, "value")?,
            standard_error,
        })
    }
}
