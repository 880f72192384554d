//! Results of the study of limits, which shows where a method fails, as plain data for the outputs. There is one
//! [`Map`] per question.

use super::Provenance;
use super::panel::Panel;
use crate::engine::Failure;

/// Point of a map (table of the settings for which a method fails): settings with which one run or several runs were
/// made.
#[derive(Clone, Debug)]
pub struct MapPoint {
    /// Values of the point in the order of the columns of the map, each in the unit of its column; `None` for a missing
    /// number.
    pub values: Vec<Option<f64>>,
    /// Failure of the first run at this point of the map that stopped early; `None` if all runs reached their end.
    pub failure: Option<Failure>,
}

/// Map (table with a picture) that shows for which settings a method fails.
#[derive(Clone, Debug)]
pub struct Map {
    /// Name of the map in file names and in the option `--only`.
    pub name: &'static str,
    /// Question that the map answers, as the heading of its section.
    pub title: String,
    /// Description, in words, of the runs at each point of the map.
    pub method: String,
    /// Conclusion that is drawn from the map, in sentences.
    pub lesson: String,
    /// Names of the columns in the table, with the unit after an underscore. The comment at the beginning of `case`
    /// explains the columns.
    pub columns: Vec<&'static str>,
    /// Points of the map of failures, in the order in which they are drawn.
    pub rows: Vec<MapPoint>,
    /// Picture of the map: coloured cells or curves.
    pub picture: Picture,
    /// Text of a case that `diptych run` can read. For each point (row) of the map, some keys of this case were
    /// changed.
    pub case: &'static str,
}

/// Kind of picture of a map.
#[derive(Clone, Debug)]
pub enum Picture {
    /// Coloured cells, one per point of the map. The colour shows the class of the result, such as "failed".
    Cells(RegimeMap),
    /// Points and lines in one panel with a pair of axes.
    Curves(Panel),
}

/// Map of coloured cells in a plane of two settings, with lines that theory predicts. The colour of a cell shows the
/// class of the result with these settings, such as "failed".
#[derive(Clone, Debug)]
pub struct RegimeMap {
    /// Label of the horizontal axis.
    pub x_label: String,
    /// Label of the vertical axis.
    pub y_label: String,
    /// True if the axis is logarithmic: first for the horizontal axis, then for the vertical axis.
    pub log: [bool; 2],
    /// Classes of results, such as "failed", each with the colour of its cells.
    pub classes: Vec<Class>,
    /// Cells of the map, one per point.
    pub cells: Vec<Cell>,
    /// Lines that theory predicts, each as a label and its points in the units of the axes.
    pub lines: Vec<(String, Vec<(f64, f64)>)>,
}

/// Class of results of a map, such as "failed". All cells of a class have the same colour.
#[derive(Clone, Debug)]
pub struct Class {
    /// Name of the class of results in the legend.
    pub label: String,
    /// Meaning of the class of results, which determines its colour.
    pub shade: Shade,
}

/// Meaning of a class of results in a map, which determines the colour of its cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shade {
    /// Size of an effect, from 0 (not visible) to 3 (large); shades of blue.
    Level(u8),
    /// Runs that stopped with a failure, grew without bound or have large errors; orange with crosses.
    Fails,
    /// Runs with wrong results but no error message; dark grey with crosses.
    Silent,
}

/// Rectangular cell of a map.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Left and right end of the cell, in the unit of the axis.
    pub x: (f64, f64),
    /// Lower and upper end of the cell, in the unit of the axis.
    pub y: (f64, f64),
    /// Index, in [`RegimeMap::classes`], of the class of the result that the cell shows.
    pub class: usize,
}

/// All results of a study of limits.
pub struct LimitsStudy<'a> {
    /// Origin of the results: case, command and title.
    pub provenance: &'a Provenance,
    /// Maps of the study in the order of the page.
    pub maps: &'a [Map],
    /// [s] wall-clock time of the runs of each map. Two maps made from the same runs have the same time.
    pub wall_seconds: &'a [f64],
    /// True if the study used coarse grids, with fewer points per map, because of the option `--quick`.
    pub quick: bool,
}

impl LimitsStudy<'_> {
    /// Command that repeats the runs of one map.
    pub fn command(&self, map: &Map) -> String {
        format!("diptych limits --only {}{}", map.name, if self.quick { " --quick" } else { "" })
    }
}

impl MapPoint {
    /// Outcome of the point of the map in one word: `ran`, or the kind of the failure.
    pub fn outcome(&self) -> &'static str {
        self.failure.as_ref().map_or("ran", Failure::kind)
    }
}

impl Map {
    /// Each outcome (`ran` or a kind of failure) with the number of points of the map that have it, in order of first
    /// appearance.
    pub fn outcomes(&self) -> Vec<(&'static str, u64)> {
        let mut outcomes: Vec<(&str, u64)> = Vec::new();
        for name in self.rows.iter().map(MapPoint::outcome) {
            match outcomes.iter_mut().find(|(known, _)| *known == name) {
                Some((_, number)) => *number += 1,
                None => outcomes.push((name, 1)),
            }
        }
        outcomes
    }
}
