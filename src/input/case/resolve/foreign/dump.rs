//! Reads text dumps of LAMMPS and LIGGGHTS. A dump consists of items, each of which begins with a line `ITEM:`. The
//! items are repeated for every instant.
//!
//! Format: LAMMPS documentation, command `dump`, <https://docs.lammps.org/dump.html>.

use super::columns::Layout;
use super::{Cells, ForeignInstant, ForeignReader, ForeignStart, Lines};
use crate::case::diagnostic::Diagnostic;
use nalgebra::Vector3;

const HELP: &str = "a dump of atoms in text has the items TIMESTEP, NUMBER OF ATOMS, BOX BOUNDS and ATOMS";

/// Items of one instant in a text dump of LAMMPS or LIGGGHTS, such as the time, the box and the lines of the atoms.
#[derive(Clone, Default)]
pub(super) struct DumpFrame {
    /// Index in the file of the first line of the instant.
    pub first: usize,
    /// [s] time of the instant; `None` if the dump does not give it.
    time: Option<f64>,
    /// Number of the time step; `None` if the dump does not give it.
    step: Option<f64>,
    /// Number of atoms that the dump states, and index of the line that states it; `None` if no line does.
    count: Option<(usize, usize)>,
    /// [m] lower and upper corner of the box; `None` if the dump does not give the box.
    bounds: Option<[Vector3<f64>; 2]>,
    /// Names of the axes along which the box is periodic, separated by blanks.
    periodic: String,
    /// Index of the line with the names of the columns; the lines of the atoms follow. `None` if the instant has no
    /// atoms.
    atoms: Option<usize>,
}

/// Returns the instant to which the line with the index `number` belongs: the latest one in the list. If the file does
/// not begin with a time step, an instant without a time step is added first.
fn instant_of(instants: &mut Vec<DumpFrame>, number: usize) -> &mut DumpFrame {
    if instants.is_empty() {
        instants.push(DumpFrame { first: number, ..DumpFrame::default() });
    }
    let last = instants.len() - 1;
    &mut instants[last]
}

impl ForeignReader<'_> {
    /// Reads the particles of the last instant in a dump.
    pub(super) fn dump(&mut self, lines: &Lines) -> Result<ForeignStart, Diagnostic> {
        let instants = self.dump_instants(lines)?;
        let Some(last) = instants.last() else { return Err(self.wrong(lines, 0, "the file is empty", HELP)) };
        if instants.len() > 1 {
            let message = format!("the file holds {} instants, the last is taken", instants.len());
            self.warn(&lines.origin(last.first), message, "save one instant, if another is meant");
        }
        Ok(self.dump_instant(lines, last)?.start)
    }

    /// Reads the particles of one instant of a dump. `instant` contains the items of this instant except the atoms, and
    /// the indices of their lines, as [`dump_instants`](Self::dump_instants) finds them.
    pub(super) fn dump_instant(&mut self, lines: &Lines, instant: &DumpFrame) -> Result<ForeignInstant, Diagnostic> {
        let (Some((count, _)), Some(header)) = (instant.count, instant.atoms) else {
            return Err(self.wrong(lines, instant.first, "this instant has no atoms", HELP));
        };
        let mut layout = Layout::default();
        for name in lines.get(header).split_whitespace().skip(2) {
            layout.push(name, 1).map_err(|why| self.wrong(lines, header, why, "leave one of them out"))?;
        }
        self.check_layout(lines, header, &mut layout)?;
        if (0..3).any(|axis| layout.is_scaled(axis)) && instant.bounds.is_none() {
            return Err(self.wrong(lines, header, "places are shares of a box that the file does not give", HELP));
        }
        let [low, high] = instant.bounds.unwrap_or_default();
        let row = |number: usize| -> Result<_, Diagnostic> {
            let words = self.words_of(lines, number, &layout)?;
            let mut row: Cells = std::array::from_fn(|column| layout.text(&words, column).to_owned());
            for axis in 0..3 {
                row[axis] = if layout.is_scaled(axis) {
                    format!(
                        "{:?}",
                        self.cell::<f64>(lines, number, &row[axis], "a coordinate")? * (high[axis] - low[axis])
                    )
                } else {
                    self.shifted(lines, number, &row[axis], low[axis])?
                };
            }
            Ok((row, lines.origin(number)))
        };
        let rows = (header + 1..header + 1 + count).map(row).collect::<Result<_, _>>()?;
        let edges = instant.bounds.map(|[low, high]| high - low);
        let periodic = instant.bounds.map(|_| instant.periodic.clone());
        let start = ForeignStart { rows, edges, tilt: None, periodic, counted: layout.counted };
        Ok(ForeignInstant { start, time: instant.time, step: instant.step, first: instant.first })
    }

    /// Reads the items of all instants, but not the lines of the atoms.
    pub(super) fn dump_instants(&mut self, lines: &Lines) -> Result<Vec<DumpFrame>, Diagnostic> {
        let (mut instants, mut time, mut units, mut number) = (Vec::<DumpFrame>::new(), None, false, 0);
        while number < lines.count() {
            let line = lines.get(number).trim();
            let item = line.strip_prefix("ITEM:").map(str::trim);
            let mut length = 2;
            match item {
                None if line.is_empty() => length = 1,
                None => {
                    let message = "this line belongs to no item, where `ITEM:` belongs";
                    return Err(self.wrong(
                        lines,
                        number,
                        message,
                        "has it more atoms than are announced? write it again",
                    ));
                }
                Some("TIMESTEP") => {
                    let step = self.cell(lines, number + 1, lines.get(number + 1).trim(), "the time step")?;
                    let (first, time) = (number, time.take());
                    instants.push(DumpFrame { first, step: Some(step), time, ..DumpFrame::default() });
                }
                // LAMMPS writes the time before the time step
                Some("TIME") => time = Some(self.cell(lines, number + 1, lines.get(number + 1).trim(), "the time")?),
                Some("UNITS") => {
                    units = true;
                    let named = lines.get(number + 1).trim();
                    if named != "si" {
                        let message = format!("the file is in the units \"{named}\" of LAMMPS");
                        return Err(self.wrong(lines, number + 1, message, "write it with `units si`"));
                    }
                }
                Some("NUMBER OF ATOMS") => {
                    let count = self.cell(lines, number + 1, lines.get(number + 1).trim(), "the number of atoms")?;
                    instant_of(&mut instants, number).count = Some((count, number + 1));
                }
                Some(item) if item.starts_with("BOX BOUNDS") => {
                    let (corners, periodic) = self.bounds(lines, number, item)?;
                    let instant = instant_of(&mut instants, number);
                    (instant.bounds, instant.periodic) = (Some(corners), periodic);
                    length = 4;
                }
                Some(item) if item.starts_with("ATOMS") => {
                    let instant = instant_of(&mut instants, number);
                    instant.atoms = Some(number);
                    length = 1 + self.atoms_of_dump(lines, number, instant.count)?;
                }
                Some(item) => {
                    let message = format!("the item `{item}` is not one of a dump of atoms");
                    return Err(self.wrong(lines, number, message, HELP));
                }
            }
            number += length;
        }
        if !units {
            self.warn_of_units(lines, 0, "LAMMPS writes them with `dump_modify units yes`");
        }
        Ok(instants)
    }

    /// Number of lines with atoms after the header. If this number is less than that given in the dump, the file was
    /// cut short, which is an error.
    fn atoms_of_dump(&self, lines: &Lines, header: usize, count: Option<(usize, usize)>) -> Result<usize, Diagnostic> {
        let Some((count, announced)) = count else {
            return Err(self.wrong(lines, header, "atoms without a number of them before", HELP));
        };
        let rest = (header + 1..lines.count()).take(count);
        let there = rest
            .take_while(|&number| !lines.get(number).starts_with("ITEM:") && !lines.get(number).trim().is_empty())
            .count();
        if there < count {
            let message = format!("{count} atoms are announced, {there} lines follow");
            return Err(self.wrong(lines, announced, message, "the file was cut short? write it again"));
        }
        Ok(count)
    }

    /// Lower and upper corner of the box [m], and the axes along which the box is periodic.
    fn bounds(&self, lines: &Lines, header: usize, item: &str) -> Result<([Vector3<f64>; 2], String), Diagnostic> {
        let words: Vec<&str> = item.split_whitespace().skip(2).collect();
        if words.contains(&"abc") {
            return Err(self.wrong(lines, header, "the box is tilted", "only rectangular boxes can be run"));
        }
        let sides = words.iter().filter(|word| !["xy", "xz", "yz"].contains(word));
        let periodic = sides.zip(["x", "y", "z"]).filter(|(side, _)| **side == "pp").map(|(_, axis)| axis);
        let periodic = periodic.collect::<Vec<_>>().join(" ");
        let [mut low, mut high] = [Vector3::<f64>::zeros(); 2];
        for axis in 0..3 {
            let number = header + 1 + axis;
            let words: Vec<&str> = lines.get(number).split_whitespace().collect();
            let (from, to, tilt) = match words[..] {
                [from, to] => (from, to, "0"),
                [from, to, tilt] => (from, to, tilt),
                _ => return Err(self.wrong(lines, number, "two bounds of the box belong here", HELP)),
            };
            if self.cell::<f64>(lines, number, tilt, "the tilt")? != 0.0 {
                return Err(self.wrong(lines, number, "the box is tilted", "only rectangular boxes can be run"));
            }
            low[axis] = self.cell(lines, number, from, "the box")?;
            high[axis] = self.cell(lines, number, to, "the box")?;
            if !(high[axis] - low[axis]).is_finite() || high[axis] <= low[axis] {
                let message = format!("the box ends at {to} and begins at {from}");
                return Err(self.wrong(lines, number, message, "the first bound is the lower one"));
            }
        }
        Ok(([low, high], periodic))
    }
}
