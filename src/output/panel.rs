//! Content of pictures before they are drawn: panels with series of points. A variant is one of the experiments of a
//! case.

use crate::legible;

/// Picture of a document, with its file name and its caption.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Name of the picture's file, without `.svg`.
    pub name: String,
    /// Caption of one or two sentences.
    pub caption: String,
    /// SVG text of the picture.
    pub svg: String,
}

impl Figure {
    pub(super) fn new(name: impl Into<String>, caption: impl Into<String>, svg: String) -> Self {
        // names of variants and keys may contain control characters, which XML does not allow
        Self { name: name.into(), caption: caption.into(), svg: legible::lines(&svg).into_owned() }
    }
}

/// Style in which a series is drawn.
#[derive(Clone, Copy, Debug)]
pub enum SeriesStyle {
    /// Line with a band of one standard error, in the colour of the variant (experiment of a case) with this index.
    Line(usize),
    /// Thin line through all points, such as the outline of a histogram. It has the colour of the variant (experiment
    /// of a case) with this index.
    Steps(usize),
    /// Separate points, in the colour of the variant (experiment of a case) with this index.
    Points(usize),
    /// Points with error bars, joined by a thin line, in the colour with this index. The index is that of a method in a
    /// work-precision chart, or of a curve of a sweep.
    Sweep(usize),
    /// Stars on the upper frame, which mark failed runs. The index is that of the method, or of the curve of a sweep,
    /// to which the runs belong.
    Failed(usize),
    /// Large dark diamonds, which mark the cheapest method whose error is small enough.
    Winner,
    /// Broad pale line with a disc around each point, which marks the Pareto front: points that no other point beats in
    /// both cost and error.
    Front,
    /// Thin grey dashed line, for a reference with which other curves are compared.
    Reference,
    /// Broad pale line beneath the other lines, for an exact solution.
    Exact,
}

/// Point of a series, in the units of the axes.
#[derive(Clone, Copy, Debug)]
pub struct SeriesPoint {
    /// Position of the point on the horizontal axis, in the unit of this axis.
    pub x: f64,
    /// Position of the point on the vertical axis, in the unit of this axis.
    pub y: f64,
    /// One standard error of `y`, in the unit of the vertical axis; `None` if no error is drawn.
    pub error: Option<f64>,
}

impl SeriesPoint {
    /// Makes a point of a series at the position (x, y), without an error.
    pub fn at(x: f64, y: f64) -> Self {
        Self { x, y, error: None }
    }
}

/// Series of points with a common name and style.
#[derive(Clone, Debug)]
pub struct PanelSeries {
    /// Name of the series in the legend.
    pub label: String,
    /// Style in which the series is drawn: line, markers and colour.
    pub look: SeriesStyle,
    /// Points of the series, in the order in which a line joins them.
    pub points: Vec<SeriesPoint>,
}

impl PanelSeries {
    /// Creates a series of points with a label and a style.
    pub fn new(label: impl Into<String>, look: SeriesStyle, points: impl IntoIterator<Item = SeriesPoint>) -> Self {
        Self { label: label.into(), look, points: points.into_iter().collect() }
    }
}

/// Panel of a picture: one pair of axes with its series. Points that are not finite are not drawn. Values that are not
/// positive are not drawn on a logarithmic axis. Points below the range of a logarithmic vertical axis are drawn at its
/// lower end.
#[derive(Clone, Debug, Default)]
pub struct Panel {
    /// Title above the axes; empty if there is none.
    pub title: String,
    /// Label of the horizontal axis, with its unit.
    pub x_label: String,
    /// Label of the vertical axis, with its unit.
    pub y_label: String,
    /// Series of the panel; later ones cover earlier ones.
    pub series: Vec<PanelSeries>,
    /// Horizontal lines across the panel, each with its position on the vertical axis and a label, which may be empty.
    pub marks: Vec<(f64, &'static str)>,
    /// Lower and upper end of the horizontal axis. `None` means the smallest and the largest value of the points, or
    /// the whole powers of ten around them on a logarithmic axis.
    pub x_range: Option<(f64, f64)>,
    /// Lower and upper end of the vertical axis. `None` means ends that include all points, error bars and horizontal
    /// lines.
    pub y_range: Option<(f64, f64)>,
    /// True if the horizontal axis is logarithmic.
    pub log_x: bool,
    /// True if the vertical axis is logarithmic.
    pub log_y: bool,
    /// [units of the axis] lower end of a logarithmic vertical axis. `None` means an end six decades (powers of ten)
    /// below the largest value.
    pub floor: Option<f64>,
}
