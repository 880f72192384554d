//! Figures of the study of limits, which shows where a method fails.

use super::cells::cells;
use super::chart;
use crate::output::limits::{Map, Picture};
use crate::output::panel::{Figure, Panel, SeriesStyle};

/// Figure of one map, which shows for which settings a method fails, with coloured cells or with curves.
pub fn limits(map: &Map) -> Figure {
    let svg = match &map.picture {
        Picture::Cells(plane) => cells(plane),
        Picture::Curves(panel) => chart::single(&Panel { x_range: x_range(panel), ..panel.clone() }),
    };
    Figure::new(map.name, &map.method, svg)
}

/// Ends of the horizontal axis of a panel, with space for the markers at both ends. `None` without markers, or if all
/// markers have the same position.
pub(super) fn x_range(panel: &Panel) -> Option<(f64, f64)> {
    let marks =
        panel.series.iter().filter(|series| matches!(series.look, SeriesStyle::Points(_) | SeriesStyle::Sweep(_)));
    let marks = marks.flat_map(|series| &series.points).map(|point| point.x);
    let (low, high) = marks.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    if low >= high {
        return None;
    }
    // room at each end, as a fraction of the axis; it is about the width of a marker
    const ROOM: f64 = 0.025;
    Some(if panel.log_x {
        let room = (high / low).powf(ROOM);
        (low / room, high * room)
    } else {
        let room = ROOM * (high - low);
        (if low >= 0.0 { (low - room).max(0.0) } else { low - room }, high + room)
    })
}
