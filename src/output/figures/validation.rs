//! Figures of the validation suite: the largest deviation in each row, and the pictures of single rows. A row is a
//! comparison with one reference.

use super::chart;
use super::limits::x_range;
use super::rows::{Dot, RowsFigure, rows};
use crate::output::panel::{Figure, Panel};
use crate::output::{ValidationRow, ValidationTier};
use crate::statistics::Answer;

/// Figure with the largest deviation in each row (comparison) of the suite, followed by the pictures of single rows.
/// The list is empty if there are no rows.
pub fn validation(all: &[ValidationRow]) -> Vec<Figure> {
    if all.is_empty() {
        return Vec::new();
    }
    let kind = |tier| ValidationTier::ALL.iter().position(|one| *one == tier).unwrap_or_default();
    let dot = |row: &ValidationRow| {
        let worst = row.worst()?;
        let error = worst.difference().error.map(|error| error / worst.allowed);
        Some(Dot { series: kind(row.tier), value: worst.share(), error, sure: row.answer() != Answer::Unresolved })
    };
    let picture = rows(&RowsFigure {
        x_label: "largest difference over what is allowed".to_owned(),
        series: ValidationTier::ALL.iter().map(|tier| tier.name().to_owned()).collect(),
        rows: all.iter().map(|row| (row.name.to_owned(), dot(row).into_iter().collect())).collect(),
        mark: 1.0,
    });
    let caption = "Largest difference of each row from its reference, over the tolerance or margin (dashed line). Bars: one standard error. Pale: unresolved. \
                   Points on the left frame: below a hundredth.";
    let single = |row: &ValidationRow| {
        let (caption, panel) = row.picture.as_ref()?;
        let svg = chart::single(&Panel { x_range: panel.x_range.or(x_range(panel)), ..panel.clone() });
        Some(Figure::new(row.name, *caption, svg))
    };
    let mut figures = vec![Figure::new("validation", caption, picture)];
    figures.extend(all.iter().filter_map(single));
    figures
}
