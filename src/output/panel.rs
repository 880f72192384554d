//! Content of a picture before it is drawn: panels of series of points.

use crate::legible;

/// A picture with its name in the folder and its caption.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// File name without `.svg`.
    pub name: String,
    /// Caption: a sentence or two.
    pub caption: String,
    /// The picture.
    pub svg: String,
}

impl Figure {
    pub(super) fn new(name: impl Into<String>, caption: impl Into<String>, svg: String) -> Self {
        // the picture contains names of variants and keys, and XML has no control characters
        Self { name: name.into(), caption: caption.into(), svg: legible::lines(&svg).into_owned() }
    }
}

/// Style of a series.
#[derive(Clone, Copy, Debug)]
pub enum SeriesStyle {
    /// A line with a band of one standard error, for the variant with this index.
    Line(usize),
    /// A thin line through all points (such as a staircase), for the variant with this index.
    Steps(usize),
    /// Separate points, for the variant with this index.
    Points(usize),
    /// Points joined by a thin line, each with its error, for the method with this index.
    Sweep(usize),
    /// Stars on the upper frame, whatever the value of the points: failures of the method with this index.
    Failed(usize),
    /// Large dark diamonds: the winner.
    Winner,
    /// A broad pale line with a halo about each of its points: the Pareto front.
    Front,
    /// A thin grey dashed line: a reference for the variants.
    Reference,
    /// A broad pale line under the others: the exact solution.
    Exact,
}

/// A point of a series, in the units of the axes.
#[derive(Clone, Copy, Debug)]
pub struct SeriesPoint {
    /// Abscissa, in the unit of its axis.
    pub x: f64,
    /// Ordinate, in the unit of its axis.
    pub y: f64,
    /// One standard error of the ordinate, in the unit of the ordinate.
    pub error: Option<f64>,
}

impl SeriesPoint {
    /// A point without an error.
    pub fn at(x: f64, y: f64) -> Self {
        Self { x, y, error: None }
    }
}

/// Points under one name.
#[derive(Clone, Debug)]
pub struct PanelSeries {
    /// Name of the series in the legend.
    pub label: String,
    /// Style of the line and its markers.
    pub look: SeriesStyle,
    /// Points in the order in which they are joined.
    pub points: Vec<SeriesPoint>,
}

impl PanelSeries {
    /// A series of points with a label and a style.
    pub fn new(label: impl Into<String>, look: SeriesStyle, points: impl IntoIterator<Item = SeriesPoint>) -> Self {
        Self { label: label.into(), look, points: points.into_iter().collect() }
    }
}

/// One pair of axes. Points that are not finite (or not positive on a logarithmic axis) are left out. Points below the
/// decades of a logarithmic axis stand on its lower end.
#[derive(Clone, Debug, Default)]
pub struct Panel {
    /// Title above the axes; empty for none.
    pub title: String,
    /// Label of the horizontal axis, with its unit.
    pub x_label: String,
    /// Label of the vertical axis, with its unit.
    pub y_label: String,
    /// The series, the lowest first.
    pub series: Vec<PanelSeries>,
    /// Horizontal lines, each with a label (may be empty).
    pub marks: Vec<(f64, &'static str)>,
    /// Ends of the x axis; `None`: the outermost points.
    pub x_range: Option<(f64, f64)>,
    /// Ends of the y axis; `None`: a little beyond the points.
    pub y_range: Option<(f64, f64)>,
    /// True if the horizontal axis is logarithmic.
    pub log_x: bool,
    /// True if the vertical axis is logarithmic.
    pub log_y: bool,
    /// [units of the axis] lower end of a logarithmic y axis; `None`: six decades below the largest value.
    pub floor: Option<f64>,
}
