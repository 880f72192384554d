//! Figure of the shifts of the observables by each factor (changed input of the case), in units of the margin of
//! equivalence (largest accepted difference).

use super::rows::{Dot, RowsFigure, rows};
use crate::output::panel::Figure;
use crate::output::sensitivity::{Factor, SensitivityStudy, Shift};
use crate::statistics::{Answer, slice_column};

/// Figure with one row per factor (changed input of the case); the most important factor is at the top. The list is
/// empty without factors.
pub fn sensitivity(study: &SensitivityStudy) -> Vec<Figure> {
    if study.factors.is_empty() {
        return Vec::new();
    }
    let names = study.observables();
    let dot = |shift: &Shift| Dot {
        series: names.iter().position(|name| *name == shift.observable).unwrap_or(0),
        value: shift.share().abs() / study.margin,
        error: shift.share_error().map(|error| error / study.margin),
        sure: shift.answer != Answer::Unresolved,
    };
    let row = |factor: &Factor| {
        let name = if factor.stopped.is_some() { format!("{} (stopped)", factor.name) } else { factor.name.clone() };
        (name, factor.shifts.iter().map(dot).collect())
    };
    let picture = rows(&RowsFigure {
        x_label: "shift over the margin, without its sign".to_owned(),
        series: names.iter().map(|name| symbol(name)).collect(),
        rows: study.factors.iter().map(row).collect(),
        mark: 1.0,
    });
    let caption = "Shift of each observable by each factor, in margins (dashed line: the margin), the factor that matters most on top. Bars: one standard error; they end at the left frame where zero lies \
                   within. Pale: unresolved. Points on the left frame: no shift that could be drawn. Signs stand in the table below.";
    vec![Figure::new("sensitivity", caption, picture)]
}

/// Symbol of an observable for the legend, or a short name for an observable without a symbol.
fn symbol(name: &str) -> String {
    match name {
        "granular temperature" => "T".into(),
        "number density at the wall" => "n at the wall".into(),
        "pair impacts per time" => "pair impacts".into(),
        "wall impacts per time" => "wall impacts".into(),
        "mean velocity along z" => "velocity along z".into(),
        "height of the centre of mass" => "height".into(),
        other => slice_column(other).map_or(other, |column| column.symbol).into(),
    }
}
