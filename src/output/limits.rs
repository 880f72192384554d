//! What the study of limits hands to the outputs: plain data, one [`Map`] per question.

use super::Provenance;
use super::panel::Panel;
use crate::engine::Failure;

/// One point: a run, or several of the same settings.
#[derive(Clone, Debug)]
pub struct MapPoint {
    /// The numbers in the order of the columns, each in the unit of its column; `None` where there is none.
    pub values: Vec<Option<f64>>,
    /// Why it stopped, if it did: of several runs the first that did.
    pub failure: Option<Failure>,
}

/// Where one method fails.
#[derive(Clone, Debug)]
pub struct Map {
    /// Name of its files, and of `--only`.
    pub name: &'static str,
    /// What is asked.
    pub title: String,
    /// What each point is.
    pub method: String,
    /// What is to be learnt, from the numbers.
    pub lesson: String,
    /// Names of the columns of the table, with the unit after an underscore; the heading of the case says what they are.
    pub columns: Vec<&'static str>,
    /// The points, in the order in which they are drawn.
    pub rows: Vec<MapPoint>,
    /// The picture.
    pub picture: Picture,
    /// The scene as a case that `diptych run` takes; every point changes something in it.
    pub case: &'static str,
}

/// How a map is drawn.
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
    /// Whether the axes are logarithmic.
    pub log: [bool; 2],
    /// The classes.
    pub classes: Vec<Class>,
    /// The cells.
    pub cells: Vec<Cell>,
    /// Lines of theory: a label, and points in the units of the axes.
    pub lines: Vec<(String, Vec<(f64, f64)>)>,
}

/// What the cells of one colour have in common.
#[derive(Clone, Debug)]
pub struct Class {
    /// Name of the class in the legend.
    pub label: String,
    /// How it is drawn.
    pub shade: Shade,
}

/// Degrees of what a cell says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shade {
    /// 0: nothing to be seen, up to 3: much. In blue.
    Level(u8),
    /// Stopped with a typed failure, or grew without bound. Crossed, in vermilion.
    Fails,
    /// Wrong, and nothing says so. Crossed, in black.
    Silent,
}

/// A rectangle.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Its left and right end, in the unit of the axis.
    pub x: (f64, f64),
    /// Its lower and upper end, in the unit of the axis.
    pub y: (f64, f64),
    /// Index of the class that colours it.
    pub class: usize,
}

/// Everything outputs need to know of a study of limits.
pub struct LimitsStudy<'a> {
    /// Where it comes from.
    pub provenance: &'a Provenance,
    /// The maps, in the order of the page.
    pub maps: &'a [Map],
    /// [s] wall-clock time of the runs behind each; two maps of the same runs have the same.
    pub wall_seconds: &'a [f64],
    /// Whether the grids are the coarse ones.
    pub quick: bool,
}

impl LimitsStudy<'_> {
    /// The command that runs one map again.
    pub fn command(&self, map: &Map) -> String {
        format!("diptych limits --only {}{}", map.name, if self.quick { " --quick" } else { "" })
    }
}

impl MapPoint {
    /// What came of it in one word: `ran`, or the type of the failure.
    pub fn outcome(&self) -> &'static str {
        self.failure.as_ref().map_or("ran", Failure::kind)
    }
}

impl Map {
    /// How many points ended in which way, in the order in which the ways come.
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
