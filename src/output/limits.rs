//! The study of limits: its data, one [`Map`] per question, and its document.

use super::document::{Block, Document, write_summary};
use super::numbers::{count, quantity};
use super::{Folder, OutputError, Provenance, csv, figures};
use crate::engine::Failure;
use serde_json::json;
use std::path::PathBuf;

/// The subfolder of the tables.
pub const MAPS: &str = "maps";

/// One point: a run, or several of the same settings.
#[derive(Clone, Debug)]
pub struct Row {
    /// The numbers in the order of the columns, each in the unit of its column; NaN where there is none.
    pub values: Vec<f64>,
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
    pub rows: Vec<Row>,
    /// The picture.
    pub picture: Picture,
    /// The scene as a case that `diptych run` takes; every point changes something in it.
    pub case: &'static str,
}

/// How a map is drawn.
#[derive(Clone, Debug)]
pub enum Picture {
    /// Coloured cells.
    Cells(Cells),
    /// Points and lines.
    Curves(Curves),
}

/// A plane of cells, each of a class, and lines of theory on it.
#[derive(Clone, Debug)]
pub struct Cells {
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
    /// In the legend.
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
    /// Which class.
    pub class: usize,
}

/// Curves over one quantity.
#[derive(Clone, Debug)]
pub struct Curves {
    /// Label of the horizontal axis.
    pub x_label: String,
    /// Label of the vertical axis.
    pub y_label: String,
    /// Whether the axes are logarithmic.
    pub log: [bool; 2],
    /// The curves.
    pub curves: Vec<Curve>,
}

/// Points under one name: abscissa, ordinate, and one standard error of it (NaN: none), in the units of the axes.
#[derive(Clone, Debug)]
pub struct Curve {
    /// In the legend.
    pub label: String,
    /// How it is drawn.
    pub kind: Kind,
    /// The points.
    pub points: Vec<[f64; 3]>,
}

/// What a curve is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Measured, points with bars.
    Points(usize),
    /// Measured, a line.
    Line(usize),
    /// Theory.
    Theory,
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

/// The name of a failure as it stands in tables; `ran` without one.
pub fn outcome(failure: Option<&Failure>) -> String {
    let Some(failure) = failure else { return "ran".into() };
    match serde_json::to_value(failure) {
        Ok(serde_json::Value::Object(object)) => object.keys().next().cloned().unwrap_or_default(),
        _ => "failed".into(),
    }
}

/// Writes everything a study of limits leaves behind: a table and a picture per map, one page, the summary last. Returns
/// the path of the page.
///
/// # Errors
/// An [`OutputError`]; the files written before it stay, without a `summary.json`.
pub fn write_limits(folder: &Folder, study: &LimitsStudy) -> Result<PathBuf, OutputError> {
    let mut body = vec![Block::Contents(study.maps.iter().map(|map| (map.name, map.title.clone())).collect())];
    let (mut tables, mut maps) = (Vec::new(), Vec::new());
    for (place, (map, &seconds)) in study.maps.iter().zip(study.wall_seconds).enumerate() {
        body.extend(study.section(place, map, seconds));
        tables.push((format!("{MAPS}/{}.csv", map.name), csv::limits(map)?));
        let outcomes: serde_json::Map<_, _> =
            map.outcomes().into_iter().map(|(name, number)| (name, number.into())).collect();
        maps.push(json!({
            "name": map.name,
            "title": map.title,
            "lesson": map.lesson,
            "points": map.rows.len(),
            "outcomes": outcomes,
            "wall_seconds": seconds,
            "command": study.command(map),
        }));
    }
    let document = Document {
        provenance: study.provenance,
        failures: Vec::new(),
        verdicts: &["Every method fails somewhere; each map shows where, by running it there.".to_owned()],
        notes: &[],
        body,
        tail: Vec::new(),
        tables,
        figures: study.maps.iter().map(figures::limits).collect(),
    };
    let page = document.write_part(folder)?;
    let summary = json!({
        "title": study.provenance.title,
        "command": study.provenance.command,
        "status": "complete",
        "version": env!("CARGO_PKG_VERSION"),
        "quick": study.quick,
        "maps": maps,
    });
    write_summary(folder, &summary)?;
    Ok(page)
}

impl Map {
    /// How many points ended in which way, in the order in which the ways come.
    fn outcomes(&self) -> Vec<(String, u64)> {
        let mut outcomes: Vec<(String, u64)> = Vec::new();
        for row in &self.rows {
            let name = outcome(row.failure.as_ref());
            match outcomes.iter_mut().find(|(known, _)| *known == name) {
                Some((_, number)) => *number += 1,
                None => outcomes.push((name, 1)),
            }
        }
        outcomes
    }
}

impl LimitsStudy<'_> {
    /// What the page says of one map, whose picture stands at that place.
    fn section(&self, place: usize, map: &Map, seconds: f64) -> Vec<Block> {
        let outcomes: Vec<String> =
            map.outcomes().iter().map(|(name, number)| format!("{} {name}", count(*number))).collect();
        let first = map.rows.iter().find_map(|row| row.failure.as_ref());
        let mut section = vec![
            Block::Section(map.name, map.title.clone()),
            Block::Verdict(map.lesson.clone()),
            Block::Figures(place..place + 1),
            Block::entries([
                ("points", outcomes.join(", ")),
                ("numbers", format!("{MAPS}/{}.csv", map.name)),
                ("wall time", quantity(seconds, "s", 2)),
                ("again", self.command(map)),
            ]),
        ];
        section.extend(first.map(|failure| Block::Note(format!("The first failure: {failure}."))));
        section.push(Block::Source("One point as a case for diptych run".into(), map.case.into()));
        section
    }
}
