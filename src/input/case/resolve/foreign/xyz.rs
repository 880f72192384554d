//! Reads extended XYZ: the number of particles, a line of `key=value` pairs, and a line per particle, repeated for
//! every instant.

use super::columns::Layout;
use super::{Cells, ForeignInstant, ForeignReader, ForeignStart, Lines};
use crate::case::diagnostic::Diagnostic;
use crate::legible::quote;
use nalgebra::Vector3;

const HELP: &str = "an extended XYZ file begins with the number of particles, then a line such as \
    `Lattice=\"0.1 0 0 0 0.1 0 0 0 0.1\" Properties=pos:R:3:velo:R:3`";

/// Data in the second line of an instant: the box and the columns.
struct Header {
    /// [m] lower corner of the box.
    origin: [f64; 3],
    /// [m] edges of the box; `None` if the line does not give the box.
    edges: Option<Vector3<f64>>,
    /// [m] displacement along z of the upper side of the box; 0 for a rectangular box.
    tilt: f64,
    /// Names of the axes along which the box is periodic, separated by blanks; `None` if the line does not give them.
    periodic: Option<String>,
    /// [s] time of the instant; `None` if the line does not give it.
    time: Option<f64>,
    /// Number of the time step; `None` if the line does not give it.
    step: Option<f64>,
    layout: Layout,
}

impl ForeignReader<'_> {
    /// Reads the particles of the last instant in a file.
    pub(super) fn xyz(&mut self, lines: &Lines) -> Result<ForeignStart, Diagnostic> {
        let instants = self.xyz_instants(lines)?;
        let Some(&(first, count)) = instants.last() else {
            return Err(self.wrong(lines, 0, "the file is empty", HELP));
        };
        if instants.len() > 1 {
            let message = format!("the file holds {} instants, the last is taken", instants.len());
            self.warn(&lines.origin(first), message, "save one instant, if another is meant");
        }
        Ok(self.xyz_instant(lines, (first, count))?.start)
    }

    /// Index of the first line of each instant, and number of particles of this instant.
    pub(super) fn xyz_instants(&self, lines: &Lines) -> Result<Vec<(usize, usize)>, Diagnostic> {
        let (mut first, mut instants) = (0, Vec::new());
        loop {
            let count = self.cell(lines, first, lines.get(first).trim(), "the number of particles");
            let count: usize = count.map_err(|error| error.help(HELP))?;
            let end = first.saturating_add(2).saturating_add(count);
            if end > lines.count() {
                let there = lines.count().saturating_sub(first + 2);
                let message = format!("{count} particles are announced, {there} lines follow");
                return Err(self.wrong(lines, first, message, "the file was cut short?"));
            }
            instants.push((first, count));
            if (end..lines.count()).all(|number| lines.get(number).trim().is_empty()) {
                return Ok(instants);
            }
            first = end;
        }
    }

    /// Reads the particles of one instant.
    pub(super) fn xyz_instant(
        &mut self,
        lines: &Lines,
        (first, count): (usize, usize),
    ) -> Result<ForeignInstant, Diagnostic> {
        let header = self.header(lines, first + 1)?;
        let row = |number: usize| self.particle(lines, number, &header).map(|cells| (cells, lines.origin(number)));
        let rows = (first + 2..first + 2 + count).map(row).collect::<Result<_, Diagnostic>>()?;
        let tilt = (header.tilt != 0.0).then(|| (header.tilt, lines.origin(first + 1)));
        let counted = header.layout.counted;
        let start = ForeignStart { rows, edges: header.edges, tilt, periodic: header.periodic, counted };
        Ok(ForeignInstant { start, time: header.time, step: header.step, first })
    }

    /// Reads the line of `key=value` pairs, which describes an instant.
    fn header(&mut self, lines: &Lines, number: usize) -> Result<Header, Diagnostic> {
        let keys = keys(lines.get(number));
        let key = |name: &str| keys.iter().find(|(key, _)| key.eq_ignore_ascii_case(name)).map(|(_, value)| *value);
        match key("units") {
            None => {
                self.warn_of_units(lines, number, "add `units=\"m s\"` to this line once all numbers are in m and m/s");
            }
            Some("m s") => {}
            Some(units) => {
                let message = format!("the file is in the units \"{}\"", quote(units));
                return Err(self.wrong(
                    lines,
                    number,
                    message,
                    "convert the numbers to m and m/s, and write units=\"m s\"",
                ));
            }
        }
        let numbers = |name: &str| -> Result<Option<Vec<f64>>, Diagnostic> {
            let cells = key(name).map(|text| text.split_whitespace().map(|cell| self.cell(lines, number, cell, name)));
            cells.map(Iterator::collect).transpose()
        };
        let corner = numbers("Origin")?.map(<[f64; 3]>::try_from).transpose().map_err(|corner| {
            let message = format!("`Origin` has {} numbers", corner.len());
            self.wrong(lines, number, message, "give the three coordinates of the lowest corner of the box")
        })?;
        let (edges, tilt) = match numbers("Lattice")?.as_deref() {
            None => (None, 0.0),
            Some([x, a, b, c, y, tilt, d, e, z]) if [a, b, c, d, e].iter().all(|off| **off == 0.0) => {
                (Some(Vector3::new(*x, *y, *z)), *tilt)
            }
            Some(_) => return Err(self.tilted(&lines.origin(number), "its edges are not along x, y, z")),
        };
        let of_axis = |letters: &str| {
            let axes = letters
                .split_whitespace()
                .zip(["x", "y", "z"])
                .filter(|(letter, _)| letter.starts_with(['T', 't', '1']));
            axes.map(|(_, axis)| axis).collect::<Vec<_>>().join(" ")
        };
        let periodic = key("pbc").map(of_axis);
        let mut layout = self.layout(lines, number, key("Properties").unwrap_or("species:S:1:pos:R:3"))?;
        self.check_layout(lines, number, &mut layout)?;
        let number_of = |name: &str| -> Result<Option<f64>, Diagnostic> {
            key(name).map(|text| self.cell(lines, number, text, name)).transpose()
        };
        let (time, step) = (number_of("Time")?, number_of("Timestep")?);
        Ok(Header { origin: corner.unwrap_or_default(), edges, tilt, periodic, time, step, layout })
    }

    /// Layout of the lines of particles, from the entry `Properties`: `name:type:columns` for each property.
    fn layout(&self, lines: &Lines, number: usize, properties: &str) -> Result<Layout, Diagnostic> {
        /// Largest number of columns of one property; programs write far fewer.
        const MOST: usize = 1000;
        let parts: Vec<&str> = properties.split(':').collect();
        let mut layout = Layout::default();
        for triple in parts.chunks(3) {
            let columns =
                triple.get(2).and_then(|columns| columns.parse().ok()).filter(|columns| (1..=MOST).contains(columns));
            let (Some(columns), [name, ..]) = (columns, triple) else {
                return Err(self.wrong(lines, number, "`Properties` cannot be read", HELP));
            };
            layout.push(name, columns).map_err(|why| self.wrong(lines, number, why, "leave one of them out"))?;
        }
        if layout.at[0].is_none() {
            return Err(self.wrong(lines, number, "`Properties` has no `pos:R:3`", HELP));
        }
        Ok(layout)
    }

    /// Reads the values of one particle, as texts in the order of `COLUMNS`, from the line with the index `number`.
    /// Positions are shifted so that the lowest corner of the box is at 0.
    fn particle(&self, lines: &Lines, number: usize, header: &Header) -> Result<Cells, Diagnostic> {
        let words = self.words_of(lines, number, &header.layout)?;
        let mut row: Cells = std::array::from_fn(|column| header.layout.text(&words, column).to_owned());
        for (place, origin) in row.iter_mut().zip(header.origin) {
            *place = self.shifted(lines, number, place, origin)?;
        }
        Ok(row)
    }
}

/// `key=value` pairs of a line. Values that contain blanks are in quotes.
fn keys(line: &str) -> Vec<(&str, &str)> {
    let mut found = Vec::new();
    let mut rest = line;
    while let Some((key, after)) = rest.split_once('=') {
        let key = key.split_whitespace().last().unwrap_or("");
        let (value, left) = match after.strip_prefix('"') {
            Some(quoted) => quoted.split_once('"').unwrap_or((quoted, "")),
            None => after.split_once(char::is_whitespace).unwrap_or((after, "")),
        };
        found.push((key, value));
        rest = left;
    }
    found
}
