//! Extended XYZ: a count, a line of `key=value`, a line per particle; the same again for the next instant.

use super::{Cells, Lines, Read};
use crate::case::diagnostic::Diagnostic;
use crate::case::resolve::Resolver;
use nalgebra::Vector3;

const HELP: &str = "an extended XYZ file begins with the number of particles, then a line such as \
    `Lattice=\"0.1 0 0 0 0.1 0 0 0 0.1\" Properties=pos:R:3:velo:R:3`";

/// What the second line of an instant says.
struct Header {
    /// [m] corner of the box.
    origin: [f64; 3],
    /// [m] edges of the box.
    edges: Option<Vector3<f64>>,
    places: Properties,
}

impl Resolver {
    /// Reads the last instant of a file.
    pub(super) fn xyz(&mut self, lines: &Lines) -> Result<Read, Diagnostic> {
        let (first, count) = self.last_instant(lines)?;
        let header = self.header(lines, first + 1)?;
        let row = |number: usize| self.particle(lines, number, &header).map(|cells| (cells, lines.origin(number)));
        let rows = (first + 2..first + 2 + count).map(row).collect::<Result<_, Diagnostic>>()?;
        Ok(Read { rows, edges: header.edges })
    }

    /// Where the last instant begins, and how many particles it has.
    fn last_instant(&mut self, lines: &Lines) -> Result<(usize, usize), Diagnostic> {
        let (mut first, mut instants) = (0, 1);
        loop {
            let count = self.cell(lines, first, lines.get(first).trim(), "the number of particles");
            let count: usize = count.map_err(|error| error.help(HELP))?;
            let end = first.saturating_add(2).saturating_add(count);
            if end > lines.count() {
                let there = lines.count().saturating_sub(first + 2);
                let message = format!("{count} particles are announced, {there} lines follow");
                return Err(self.wrong(lines, first, message, "the file was cut short?"));
            }
            if (end..lines.count()).all(|number| lines.get(number).trim().is_empty()) {
                if instants > 1 {
                    let message = format!("the file holds {instants} instants, the last is taken");
                    self.warn(&lines.origin(first), message, "save one instant, if another is meant");
                }
                return Ok((first, count));
            }
            (first, instants) = (end, instants + 1);
        }
    }

    /// Reads the line of `key=value`.
    fn header(&mut self, lines: &Lines, number: usize) -> Result<Header, Diagnostic> {
        let keys = keys(lines.get(number));
        let key = |name: &str| keys.iter().find(|(key, _)| key.eq_ignore_ascii_case(name)).map(|(_, value)| *value);
        if key("units").is_none() {
            self.warn_of_units(lines, number, "add `units=\"m s\"` to this line once all numbers are in m and m/s");
        }
        let numbers = |name: &str| -> Result<Option<Vec<f64>>, Diagnostic> {
            let cells = key(name).map(|text| text.split_whitespace().map(|cell| self.cell(lines, number, cell, name)));
            cells.map(Iterator::collect).transpose()
        };
        let corner = numbers("Origin")?.and_then(|corner| <[f64; 3]>::try_from(corner).ok());
        let edges = match numbers("Lattice")?.as_deref() {
            None => None,
            Some([x, a, b, c, y, d, e, f, z]) if [a, b, c, d, e, f].iter().all(|off| **off == 0.0) => {
                Some(Vector3::new(*x, *y, *z))
            }
            Some(_) => {
                let message = "the box (`Lattice`) is not rectangular along x, y, z";
                return Err(self.wrong(lines, number, message, "only such boxes can be run"));
            }
        };
        let places = properties(key("Properties").unwrap_or("species:S:1:pos:R:3"));
        let unreadable = || self.wrong(lines, number, "`Properties` cannot be read or has no `pos:R:3`", HELP);
        Ok(Header { origin: corner.unwrap_or_default(), edges, places: places.ok_or_else(unreadable)? })
    }

    /// Reads the line of a particle.
    fn particle(&self, lines: &Lines, number: usize, header: &Header) -> Result<Cells, Diagnostic> {
        let places = &header.places;
        let cells: Vec<&str> = lines.get(number).split_whitespace().collect();
        if cells.len() < places.width {
            let message = format!("the line has {} values where `Properties` has {}", cells.len(), places.width);
            return Err(self.wrong(lines, number, message, "one line for each particle"));
        }
        let at = |column: Option<usize>| column.and_then(|column| cells.get(column)).map_or("", |cell| *cell);
        let mut row = Cells::default();
        for axis in 0..3 {
            row[axis] = self.shifted(lines, number, at(Some(places.position + axis)), header.origin[axis])?;
            row[3 + axis] = at(places.velocity.map(|velocity| velocity + axis)).to_owned();
        }
        if places.radius.is_some() {
            row[6] = format!("{:?}", 2.0 * self.cell::<f64>(lines, number, at(places.radius), "radius")?);
        }
        row[7] = match places.kind {
            Some(kind) => self.kind(lines, number, at(Some(kind)))?,
            None if self.several => at(places.species).to_owned(),
            None => String::new(),
        };
        row[8] = at(places.id).to_owned();
        Ok(row)
    }
}

/// `key=value` pairs of a line; values with blanks stand in quotes.
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

/// Where the properties of a particle stand in its line.
#[derive(Clone, Copy, Debug, Default)]
struct Properties {
    position: usize,
    velocity: Option<usize>,
    radius: Option<usize>,
    id: Option<usize>,
    kind: Option<usize>,
    species: Option<usize>,
    width: usize,
}

/// `name:type:columns` for each property; `None` if that is not what stands there, or there is no position.
fn properties(text: &str) -> Option<Properties> {
    /// Columns of one property; no program writes as many.
    const MOST: usize = 1000;
    let parts: Vec<&str> = text.split(':').collect();
    let (mut found, mut position) = (Properties::default(), None);
    for triple in parts.chunks(3) {
        let [name, _, columns] = triple else { return None };
        let columns = columns.parse::<usize>().ok().filter(|columns| *columns <= MOST)?;
        let at = Some(found.width);
        match (name.to_ascii_lowercase().as_str(), columns) {
            ("pos" | "position", 3) => position = at,
            ("velo" | "vel" | "velocity" | "velocities", 3) => found.velocity = at,
            ("radius", 1) => found.radius = at,
            ("id", 1) => found.id = at,
            ("type", 1) => found.kind = at,
            ("species", 1) => found.species = at,
            _ => {}
        }
        found.width += columns;
    }
    position.map(|position| Properties { position, ..found })
}
