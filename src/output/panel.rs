//! What is to be seen in a picture, before it is drawn: panels of series of points.

use crate::legible;

/// A picture with its place in the folder and what it shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// File name without `.svg`.
    pub name: String,
    /// What is to be seen, in a sentence or two.
    pub caption: String,
    /// The picture.
    pub svg: String,
}

impl Figure {
    pub(super) fn new(name: impl Into<String>, caption: impl Into<String>, svg: String) -> Self {
        // names of variants and keys stand in it, and XML has no control characters
        Self { name: name.into(), caption: caption.into(), svg: legible::lines(&svg).into_owned() }
    }
}

/// How a series looks.
#[derive(Clone, Copy, Debug)]
pub enum SeriesStyle {
    /// A line with a band of one standard error, of the variant at that place.
    Line(usize),
    /// A thin line through all points (those of a staircase, say), of the variant at that place.
    Steps(usize),
    /// Separate points, of the variant at that place.
    Points(usize),
    /// Points joined by a thin line, each with its error, of the method at that place.
    Sweep(usize),
    /// Stars on the upper frame, wherever the points are: what the method at that place could not do.
    Failed(usize),
    /// Large dark diamonds: what wins.
    Winner,
    /// A broad pale line with a halo about each of its points.
    Front,
    /// A thin grey dashed line: what the variants are seen beside.
    Reference,
    /// A broad pale line under the others: what they should lie on.
    Exact,
}

/// A point of a series, in the units of the axes.
#[derive(Clone, Copy, Debug)]
pub struct SeriesPoint {
    /// Abscissa, in the unit of its axis.
    pub x: f64,
    /// Ordinate, in the unit of its axis.
    pub y: f64,
    /// One standard error of the ordinate, in its unit.
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
    /// In the order in which they are joined.
    pub points: Vec<SeriesPoint>,
}

impl PanelSeries {
    /// These points under this name.
    pub fn new(label: impl Into<String>, look: SeriesStyle, points: impl IntoIterator<Item = SeriesPoint>) -> Self {
        Self { label: label.into(), look, points: points.into_iter().collect() }
    }
}

/// One pair of axes. Points that are not finite (or not positive on a logarithmic axis) are left out; those below the
/// decades that a logarithmic axis shows stand on its lower end.
#[derive(Clone, Debug, Default)]
pub struct Panel {
    /// Above the axes; empty for none.
    pub title: String,
    /// Label of the horizontal axis, with its unit.
    pub x_label: String,
    /// Label of the vertical axis, with its unit.
    pub y_label: String,
    /// What is drawn, the lowest first.
    pub series: Vec<PanelSeries>,
    /// Horizontal lines, each with a label (may be empty).
    pub marks: Vec<(f64, &'static str)>,
    /// Ends of the x axis; `None`: where the points end.
    pub x_range: Option<(f64, f64)>,
    /// Ends of the y axis; `None`: a little beyond the points.
    pub y_range: Option<(f64, f64)>,
    /// Whether the horizontal axis is logarithmic.
    pub log_x: bool,
    /// Whether the vertical axis is logarithmic.
    pub log_y: bool,
    /// [units of the axis] lower end of a logarithmic y axis; `None`: six decades below the largest value.
    pub floor: Option<f64>,
}
