//! The pictures of the study of limits.

use super::Figure;
use super::cells::cells;
use super::chart::{self, Look, Panel, Point, Series};
use crate::output::limits::{Curves, Kind, Map, Picture};

/// The picture of a map.
pub fn limits(map: &Map) -> Figure {
    let svg = match &map.picture {
        Picture::Cells(plane) => cells(plane),
        Picture::Curves(axes) => curves(axes),
    };
    Figure::new(map.name, &map.method, svg)
}

fn curves(axes: &Curves) -> String {
    let series = axes.curves.iter().map(|curve| Series {
        label: curve.label.clone(),
        look: match curve.kind {
            Kind::Points(place) => Look::Points(place),
            Kind::Line(place) => Look::Line(place),
            Kind::Theory => Look::Reference,
        },
        points: curve.points.iter().map(|&[x, y, error]| Point { x, y, error }).collect(),
    });
    chart::single(&Panel {
        x_range: x_range(axes),
        x_label: axes.x_label.clone(),
        y_label: axes.y_label.clone(),
        series: series.collect(),
        log_x: axes.log[0],
        log_y: axes.log[1],
        ..Panel::default()
    })
}

/// The ends of the horizontal axis: the marks at its ends need room.
fn x_range(axes: &Curves) -> Option<(f64, f64)> {
    let marks =
        axes.curves.iter().filter(|curve| matches!(curve.kind, Kind::Points(_))).flat_map(|curve| &curve.points);
    let (low, high) = marks.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p[0]), high.max(p[0])));
    if low >= high {
        return None;
    }
    // a fortieth of the axis, about the width of a mark
    const ROOM: f64 = 0.025;
    Some(if axes.log[0] {
        let room = (high / low).powf(ROOM);
        (low / room, high * room)
    } else {
        let room = ROOM * (high - low);
        (if low >= 0.0 { (low - room).max(0.0) } else { low - room }, high + room)
    })
}
