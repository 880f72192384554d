//! Figure of the differences between the two sides of a comparison of files, in units of the margin (largest accepted
//! difference).

use super::rows::{Dot, RowsFigure, rows};
use crate::output::Verdict;
use crate::output::panel::Figure;
use crate::statistics::{Answer, Judged};

/// Figure with one row per compared quantity, as a list of one entry. The list is empty if nothing was compared.
pub fn files_study(comparisons: &[Verdict]) -> Vec<Figure> {
    let judged = comparisons.iter().flat_map(|verdict| {
        let all = verdict.comparison.iter().flat_map(|comparison| &comparison.judged);
        all.map(|one| (one, verdict.margin))
    });
    let dot = |one: &Judged, margin: f64| {
        let found = one.tested.headline()?;
        let scale = one.tested.scale * margin;
        Some(Dot {
            series: 0,
            value: found.difference.abs() / scale,
            error: Some(found.error / scale),
            sure: one.answer != Answer::Unresolved,
        })
    };
    let row = |(one, margin): (&Judged, f64)| (one.tested.name.to_string(), dot(one, margin).into_iter().collect());
    let all: Vec<(String, Vec<Dot>)> = judged.map(row).collect();
    if all.is_empty() {
        return Vec::new();
    }
    let picture = rows(&RowsFigure {
        x_label: "difference over the margin, without its sign".to_owned(),
        series: vec!["A − B".to_owned()],
        rows: all,
        mark: 1.0,
    });
    let caption = "Difference of each quantity, in margins (dashed line: the margin). Bars: one standard error; they end at the left frame where zero lies within. \
                   Pale: unresolved. Points on the left frame: no difference that could be drawn.";
    vec![Figure::new("differences", caption, picture)]
}
