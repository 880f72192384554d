//! LAMMPS data files: the box, a section `Atoms` in style sphere or atomic, and `Velocities`.
//!
//! Format: LAMMPS documentation, command `read_data`, <https://docs.lammps.org/read_data.html>.

use super::{Cells, Lines, Read};
use crate::case::diagnostic::Diagnostic;
use crate::case::resolve::Resolver;
use nalgebra::Vector3;
use rustc_hash::FxHashMap;
use std::ops::Range;

/// Columns of a section `Atoms`, and where its lines are.
#[derive(Clone)]
struct Atoms {
    diameter: Option<usize>,
    place: usize,
    lines: Range<usize>,
}

/// What stands in a file besides the atoms themselves.
#[derive(Default)]
struct Outline<'a> {
    /// [m] corners of the box.
    low: Vector3<f64>,
    high: Vector3<f64>,
    boxed: bool,
    atoms: Option<Atoms>,
    velocities: FxHashMap<&'a str, [&'a str; 3]>,
}

impl Resolver {
    /// Reads a file.
    pub(super) fn lammps(&mut self, lines: &Lines) -> Result<Read, Diagnostic> {
        match lines.get(0).split_once("units = ").map(|(_, units)| units.trim()) {
            Some("si") => {}
            Some(other) => {
                let message = format!("the file is in the units \"{other}\" of LAMMPS");
                return Err(self.wrong(lines, 0, message, "write it with `units si`"));
            }
            None => self.warn_of_units(lines, 0, "LAMMPS writes `units = si` into the first line under `units si`"),
        }
        let outline = self.outline(lines)?;
        let Some(atoms) = &outline.atoms else {
            let help = "LAMMPS writes one with `write_data`";
            return Err(self.wrong(lines, 0, "the file has no section `Atoms`", help));
        };
        let mut rows = Vec::new();
        for number in atoms.lines.clone() {
            let cells = words(lines.get(number));
            if !cells.is_empty() {
                rows.push((self.atom(lines, number, &cells, (atoms, &outline))?, lines.origin(number)));
            }
        }
        Ok(Read { rows, edges: outline.boxed.then(|| outline.high - outline.low) })
    }

    /// Finds the box and the sections.
    fn outline<'a>(&self, lines: &Lines<'a>) -> Result<Outline<'a>, Diagnostic> {
        let mut found = Outline::default();
        let mut number = 1;
        while number < lines.count() {
            let line = words(lines.get(number));
            let mut next = number + 1;
            match line[..] {
                [from, to, low @ ("xlo" | "ylo" | "zlo"), _] => {
                    let axis = ["xlo", "ylo", "zlo"].iter().position(|name| *name == low).unwrap_or_default();
                    found.low[axis] = self.cell(lines, number, from, "the box")?;
                    found.high[axis] = self.cell(lines, number, to, "the box")?;
                    found.boxed = true;
                }
                [_, _, _, "xy", "xz", "yz"] => {
                    return Err(self.wrong(lines, number, "the box is tilted", "only rectangular boxes can be run"));
                }
                ["Atoms"] => {
                    let body = section(lines, next);
                    next = body.end;
                    found.atoms = Some(self.atoms(lines, number, body)?);
                }
                ["Velocities"] => {
                    let body = section(lines, next);
                    next = body.end;
                    for line in body.map(|number| words(lines.get(number))) {
                        if let [id, x, y, z, ..] = line[..] {
                            found.velocities.insert(id, [x, y, z]);
                        }
                    }
                }
                _ => {}
            }
            number = next;
        }
        Ok(found)
    }

    /// The columns of a section `Atoms`, by the style that its header names.
    fn atoms(&self, lines: &Lines, header: usize, body: Range<usize>) -> Result<Atoms, Diagnostic> {
        let help = "write `Atoms # sphere` or `Atoms # atomic`";
        match lines.get(header).split_once('#').map(|(_, style)| style.trim()) {
            Some("sphere") => Ok(Atoms { diameter: Some(2), place: 4, lines: body }),
            Some("atomic") => Ok(Atoms { diameter: None, place: 2, lines: body }),
            Some(other) => Err(self.wrong(lines, header, format!("atoms of style \"{other}\" cannot be read"), help)),
            None => Err(self.wrong(lines, header, "the section does not name its style", help)),
        }
    }

    /// Reads the line of an atom.
    fn atom(
        &self,
        lines: &Lines,
        number: usize,
        cells: &[&str],
        (atoms, outline): (&Atoms, &Outline),
    ) -> Result<Cells, Diagnostic> {
        let least = atoms.place + 3;
        if cells.len() < least {
            let message = format!("the line has {} values, at least {least} belong here", cells.len());
            let help = "sphere: id type diameter density x y z; atomic: id type x y z";
            return Err(self.wrong(lines, number, message, help));
        }
        let mut row = Cells::default();
        for axis in 0..3 {
            row[axis] = self.shifted(lines, number, cells[atoms.place + axis], outline.low[axis])?;
            row[3 + axis] = outline.velocities.get(cells[0]).map_or("0", |velocity| velocity[axis]).to_owned();
        }
        row[6] = atoms.diameter.map_or("", |diameter| cells[diameter]).to_owned();
        row[7] = self.kind(lines, number, cells[1])?;
        row[8] = cells[0].to_owned();
        Ok(row)
    }
}

/// The words of a line up to a comment.
fn words(line: &str) -> Vec<&str> {
    line.split('#').next().unwrap_or("").split_whitespace().collect()
}

/// The lines from `from` on, up to one that begins with a letter: the next section.
fn section(lines: &Lines, from: usize) -> Range<usize> {
    let begins = |line: &str| line.trim_start().starts_with(|c: char| c.is_ascii_alphabetic());
    let end = (from..lines.count()).find(|&number| begins(lines.get(number))).unwrap_or(lines.count());
    from.min(end)..end
}
