//! Results of the study of limits, as plain data for the outputs: one [`Map`] per question.

use super::Provenance;
use super::panel::Panel;
use crate::engine::Failure;

/// One point: a run, or several with equal settings.
#[derive(Clone, Debug)]
pub struct MapPoint {
    /// Numbers in the order of the columns, each in the unit of its column; `None` for a missing number.
    pub values: Vec<Option<f64>>,
    /// Reason of an early stop, if there was one: that of the first run that stopped.
    pub failure: Option<Failure>,
}

/// Map of the settings at which one method fails.
#[derive(Clone, Debug)]
pub struct Map {
    /// Name of the files of the map, and its name for `--only`.
    pub name: &'static str,
    /// The question.
    pub title: String,
    /// Description of each point.
    pub method: String,
    /// Conclusion from the numbers.
    pub lesson: String,
    /// Names of the columns of the table, with the unit after an underscore; the heading of the case explains them.
    pub columns: Vec<&'static str>,
    /// The points, in the order in which they are drawn.
    pub rows: Vec<MapPoint>,
    /// The picture.
    pub picture: Picture,
    /// The scene as a case for `diptych run`; every point changes some of its keys.
    pub case: &'static str,
}

/// Kind of picture of a map.
#[derive(Clone, Debug)]
pub enum Picture {
    /// Coloured cells.
    Cells(RegimeMap),
    /// Points and lines.
    Curves(Panel),
}

/// A plane of cells, each of a class, and lines of theory on it.
#[derive(Clone, Debug)]
pub struct RegimeMap {
    /// Label of the horizontal axis.
    pub x_label: String,
    /// Label of the vertical axis.
    pub y_label: String,
    /// True for axes that are logarithmic.
    pub log: [bool; 2],
    /// The classes.
    pub classes: Vec<Class>,
    /// The cells.
    pub cells: Vec<Cell>,
    /// Lines of theory: a label, and points in the units of the axes.
    pub lines: Vec<(String, Vec<(f64, f64)>)>,
}

/// Class of cells that share one colour.
#[derive(Clone, Debug)]
pub struct Class {
    /// Name of the class in the legend.
    pub label: String,
    /// Colour of the class.
    pub shade: Shade,
}

/// Colours of cells by their meaning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shade {
    /// Size of the effect, from 0 (not visible) to 3 (large). In blue.
    Level(u8),
    /// Stopped with a typed failure, or grew without bound. Crossed, in vermilion.
    Fails,
    /// Wrong without any message. Crossed, in black.
    Silent,
}

/// A rectangular cell.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Left and right end, in the unit of the axis.
    pub x: (f64, f64),
    /// Lower and upper end, in the unit of the axis.
    pub y: (f64, f64),
    /// Index of the class that colours it.
    pub class: usize,
}

/// All data of a study of limits that outputs need.
pub struct LimitsStudy<'a> {
    /// Origin of the results.
    pub provenance: &'a Provenance,
    /// The maps, in the order of the page.
    pub maps: &'a [Map],
    /// [s] wall-clock time of the runs of each map; two maps from one set of runs have equal times.
    pub wall_seconds: &'a [f64],
    /// True if the grids are the coarse ones.
    pub quick: bool,
}

impl LimitsStudy<'_> {
    /// The command that runs one map again.
    pub fn command(&self, map: &Map) -> String {
        format!("diptych limits --only {}{}", map.name, if self.quick { " --quick" } else { "" })
    }
}

impl MapPoint {
    /// Outcome of the point in one word: `ran`, or the type of the failure.
    pub fn outcome(&self) -> &'static str {
        self.failure.as_ref().map_or("ran", Failure::kind)
    }
}

impl Map {
    /// Number of points for each outcome, in the order of first appearance.
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
