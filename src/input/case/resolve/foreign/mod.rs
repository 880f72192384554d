//! Reads initial states written by other programs: extended XYZ (OVITO, ASE), and data files and dumps of LAMMPS and
//! LIGGGHTS. The result is a table with the columns of a CSV file.

mod columns;
mod dump;
mod frames;
mod lammps;
mod xyz;

use super::Resolver;
use super::table::DataTable;
use crate::case::diagnostic::Diagnostic;
use crate::case::source::{Origin, Sources};
use crate::domain::Domain;
use crate::legible::quote;
use crate::scene::Scene;
pub use frames::{FramesAndWarnings, ParticleFrame, particle_frames};

use columns::SPECIES;
use csv::StringRecord;
use nalgebra::Vector3;

/// Properties of a particle in an initial state. Files of all formats are read into columns in this order.
pub(super) const COLUMNS: [&str; 18] = [
    "x", "y", "z", "vx", "vy", "vz", "diameter", "species", "id", "wx", "wy", "wz", "radius", "density", "mass", "px",
    "py", "pz",
];
/// Number of columns, counted from the first of [`COLUMNS`], that a CSV table may have.
pub(super) const OF_CSV: usize = 12;
/// Index of the column with the ids of particles.
const ID: usize = 8;
/// Number of lines, from the first of a file, that are searched for a line such as `100 atoms`. By such a line a
/// LAMMPS data file is recognized.
const HEAD_OF_DATA: usize = 40;

/// Format of a file from another program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Foreign {
    /// Extended XYZ, as written by OVITO and ASE.
    Xyz,
    /// Data file of LAMMPS.
    Lammps,
    /// Text dump of LAMMPS or LIGGGHTS.
    Dump,
}

impl Foreign {
    /// Recognizes, from the first lines of a file, a format that can contain the particles of several instants. `None`
    /// if the file has no such format.
    fn of_frames(text: &str) -> Option<Self> {
        let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
        let first = lines.next().unwrap_or("");
        if first.starts_with("ITEM:") {
            return Some(Self::Dump);
        }
        if first.parse::<u64>().is_ok() && lines.next().is_some_and(|second| second.contains('=')) {
            return Some(Self::Xyz);
        }
        None
    }

    /// Recognizes the format from the content of a file or, failing that, from its name. `None` means a CSV table.
    pub(super) fn of(name: &str, text: &str) -> Option<Self> {
        if let Some(format) = Self::of_frames(text) {
            return Some(format);
        }
        let counts = |line: &str| {
            line.split_whitespace().nth(1) == Some("atoms")
                && line.split_whitespace().next().is_some_and(|count| count.parse::<u64>().is_ok())
        };
        if text.lines().take(HEAD_OF_DATA).any(counts) {
            return Some(Self::Lammps);
        }
        let file = name.rsplit(['/', '\\']).next().unwrap_or(name).to_ascii_lowercase();
        match (file.rsplit('.').next(), file.split('.').next()) {
            (Some("xyz" | "extxyz"), _) => Some(Self::Xyz),
            (Some("data" | "lmp" | "lammps"), _) | (_, Some("data")) => Some(Self::Lammps),
            (Some("dump" | "lammpstrj"), _) | (_, Some("dump")) => Some(Self::Dump),
            _ => None,
        }
    }
}

/// Text split into lines, with the position of each line for messages.
struct Lines<'a> {
    source: usize,
    lines: Vec<(usize, &'a str)>,
}

impl<'a> Lines<'a> {
    fn of(source: usize, text: &'a str) -> Self {
        let start = |line: &str| line.as_ptr() as usize - text.as_ptr() as usize;
        Self { source, lines: text.lines().map(|line| (start(line), line)).collect() }
    }

    fn count(&self) -> usize {
        self.lines.len()
    }

    /// Line with index `number`, counted from 0; empty beyond the last line.
    fn get(&self, number: usize) -> &'a str {
        self.lines.get(number).map_or("", |(_, line)| line)
    }

    fn origin(&self, number: usize) -> Origin {
        let (start, line) = self.lines.get(number).or(self.lines.last()).copied().unwrap_or((0, ""));
        Origin { source: self.source, span: start..start + line.len() }
    }
}

/// Texts of the [`COLUMNS`] for one particle. Texts of columns that the file lacks are empty.
type Cells = [String; COLUMNS.len()];

/// Particles in a file of another program, and the box that the file gives.
struct ForeignStart {
    rows: Vec<(Cells, Origin)>,
    /// [m] edges of the box; `None` if the file does not give the box.
    edges: Option<Vector3<f64>>,
    /// [m] displacement along z of the upper side of a tilted box, and the line that gives it; `None` for a rectangular
    /// box.
    tilt: Option<(f64, Origin)>,
    /// Names of the axes along which the box is periodic, separated by blanks; `None` if the file does not give them.
    periodic: Option<String>,
    /// True if species are given by numbers, counted from 1 in the order of the case, instead of names.
    counted: bool,
}

/// Particles of one instant in a file of another program.
struct ForeignInstant {
    start: ForeignStart,
    /// [s] time of the instant; `None` if the file does not give it.
    time: Option<f64>,
    /// Number of the time step; `None` if the file does not give it.
    step: Option<f64>,
    /// Index in the file of the first line of the instant.
    first: usize,
}

/// Reader of the files of other programs, which collects warnings.
struct ForeignReader<'a> {
    /// Texts of all files, for messages.
    sources: &'a Sources,
    warnings: Vec<Diagnostic>,
}

impl Resolver {
    /// Reads an initial state of another program from `text`; `source` is the index of this text in the list of
    /// sources. The kinds of particles in the file are replaced by the species of `scene`. A tilted box is refused
    /// unless it is the sheared box of `scene`.
    pub(super) fn foreign_table(
        &mut self,
        format: Foreign,
        (source, text): (usize, &str),
        scene: &Scene,
    ) -> Result<DataTable, Diagnostic> {
        let mut reader = ForeignReader { sources: &self.sources, warnings: Vec::new() };
        let kinds: Vec<&str> = scene.species.iter().map(|kind| kind.name.as_str()).collect();
        let read = reader.start(format, &Lines::of(source, text), &kinds)?;
        reader.check_tilt(&read, &scene.domain)?;
        for warning in reader.warnings {
            // if several species name the same file, it is read once for each of them, but one warning is enough
            if !self.warnings.contains(&warning) {
                self.warnings.push(warning);
            }
        }
        let known = |column: usize| read.rows.iter().any(|(cells, _)| !cells[column].is_empty());
        let columns = (0..COLUMNS.len()).map(|column| known(column).then_some(column)).collect();
        let edges = read.edges.map(|edges| ("box_m".to_owned(), format!("{:?} {:?} {:?}", edges.x, edges.y, edges.z)));
        let tilt = read.tilt.map(|(tilt, _)| ("image_offset_m".to_owned(), format!("{tilt:?}")));
        let periodic = read.periodic.map(|axes| ("periodic".to_owned(), axes));
        let head = edges.into_iter().chain(periodic).chain(tilt).collect();
        let rows = read.rows.into_iter().map(|(cells, origin)| (StringRecord::from(cells.to_vec()), origin)).collect();
        Ok(DataTable { saved: false, foreign: true, head, columns, units: vec![None; COLUMNS.len()], rows })
    }
}

impl ForeignReader<'_> {
    /// Reads an initial state. Its particles are in the order of ids, and have the names of their species. `kinds` are
    /// the names of the species in the case.
    fn start(&mut self, format: Foreign, lines: &Lines, kinds: &[&str]) -> Result<ForeignStart, Diagnostic> {
        let mut read = match format {
            Foreign::Xyz => self.xyz(lines)?,
            Foreign::Lammps => self.lammps(lines)?,
            Foreign::Dump => self.dump(lines)?,
        };
        self.name_kinds(&mut read, kinds)?;
        self.sort_by_ids(&mut read)?;
        Ok(read)
    }

    /// Refuses a tilted box unless it is the sheared box of the case, whose images slide along z.
    fn check_tilt(&self, read: &ForeignStart, domain: &Domain) -> Result<(), Diagnostic> {
        let Some((_, origin)) = &read.tilt else { return Ok(()) };
        let is_own = |edges: Vector3<f64>| {
            edges.iter().zip(&domain.size).all(|(edge, own)| (edge - own).abs() <= f64::from(f32::EPSILON) * own)
        };
        match (domain.shear, read.edges.is_some_and(is_own)) {
            (None, _) => Err(self.tilted(origin, "it is tilted along z, and the case has no [domain.shear]")),
            (Some(_), false) => {
                Err(self.tilted(origin, "it is tilted along z, and is not the sheared box of the case"))
            }
            (Some(_), true) => Ok(()),
        }
    }

    /// Creates the error about a box that is not rectangular.
    fn tilted(&self, origin: &Origin, why: &str) -> Diagnostic {
        let message = format!("the box (`Lattice`) is not rectangular along x, y, z: {why}");
        self.sources.error(origin, message).help(
            "only rectangular boxes can be run, and the sheared box of the case (`domain.size`) with any tilt along z",
        )
    }

    /// Replaces the type number in each row by the name of the species. If the case has one species, the cell becomes
    /// empty, which means this species; rows with different types are then an error.
    fn name_kinds(&self, read: &mut ForeignStart, kinds: &[&str]) -> Result<(), Diagnostic> {
        let what = if read.counted { "type" } else { "species" };
        let first = read.rows.first().map(|(cells, _)| cells[SPECIES].clone()).unwrap_or_default();
        for (cells, origin) in &mut read.rows {
            let of = std::mem::take(&mut cells[SPECIES]);
            if kinds.len() < 2 {
                if of != first {
                    let message =
                        format!("{what} {of} beside {what} {first}, where the case has one kind of particles");
                    let help =
                        "name the file under a [[particles]] of its own for each kind, in the order of the types";
                    return Err(self.sources.error(origin, message).help(help));
                }
            } else if read.counted {
                let number = of.parse::<usize>().ok();
                let name = number.and_then(|number| kinds.get(number.wrapping_sub(1)));
                let message = match number {
                    Some(number) => format!("the type is {number}, the case has {} kinds of particles", kinds.len()),
                    None => format!("the type = {of:?} is not a whole number"),
                };
                let help = "types count from 1, in the order of [[particles]] in the case";
                cells[SPECIES] = (*name.ok_or_else(|| self.sources.error(origin, message).help(help))?).to_owned();
            } else {
                cells[SPECIES] = of;
            }
        }
        Ok(())
    }

    /// Sorts rows by their ids, unless a row has no id. Warns if the ids are not 0, 1, 2 …, because the particles then
    /// have other numbers in results.
    fn sort_by_ids(&mut self, read: &mut ForeignStart) -> Result<(), Diagnostic> {
        let mut numbered = Vec::with_capacity(read.rows.len());
        for (place, (cells, origin)) in read.rows.iter().enumerate() {
            if cells[ID].is_empty() {
                return Ok(());
            }
            let why = || format!("`id` = {:?} is not a whole number", cells[ID]);
            let id: u64 =
                cells[ID].parse().map_err(|_| self.sources.error(origin, why()).help("ids are 0, 1, 2 ..."))?;
            numbered.push((id, place));
        }
        numbered.sort_unstable();
        if let Some(pair) = numbered.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            let message = format!("`id` = {} stands in two lines", pair[1].0);
            return Err(self
                .sources
                .error(&read.rows[pair[1].1].1, message)
                .help("each particle has an id of its own"));
        }
        if let (Some(first), Some(last)) = (numbered.first(), numbered.last())
            && (first.0, last.0) != (0, numbered.len() as u64 - 1)
        {
            let message = format!("the ids of the file, {} to {}, are counted anew", first.0, last.0);
            let origin = read.rows[first.1].1.clone();
            self.warn(
                &origin,
                message,
                "results count 0, 1, 2 ... in the order of these ids, one kind after the other",
            );
        }
        let mut rows: Vec<Option<(Cells, Origin)>> = std::mem::take(&mut read.rows).into_iter().map(Some).collect();
        read.rows = numbered.into_iter().filter_map(|(_, place)| rows[place].take()).collect();
        Ok(())
    }

    /// Adds a warning, unless there is already one with the same words. Without this check each instant of a file would
    /// add the warning again.
    fn warn(&mut self, origin: &Origin, message: impl Into<String>, help: impl Into<String>) {
        let warning = self.sources.warning(origin, message).help(help);
        if self.warnings.iter().all(|known| known.message != warning.message) {
            self.warnings.push(warning);
        }
    }

    /// Creates an error about a line of the file.
    fn wrong(&self, lines: &Lines, number: usize, message: impl Into<String>, help: &str) -> Diagnostic {
        self.sources.error(&lines.origin(number), message).help(help)
    }

    /// Parses the number `text`, which was found in the line with the index `number`. `what` is the name of the number
    /// in the error message.
    fn cell<T: std::str::FromStr>(
        &self,
        lines: &Lines,
        number: usize,
        text: &str,
        what: &str,
    ) -> Result<T, Diagnostic> {
        let error =
            || self.wrong(lines, number, format!("{what} = {:?} is not a number", quote(text)), "plain SI numbers");
        text.parse().map_err(|_| error())
    }

    /// Text of a coordinate [m] relative to `origin` [m]; the text is unchanged if `origin` is 0.
    fn shifted(&self, lines: &Lines, number: usize, text: &str, origin: f64) -> Result<String, Diagnostic> {
        if origin == 0.0 {
            return Ok(text.to_owned());
        }
        Ok(format!("{:?}", self.cell::<f64>(lines, number, text, "a coordinate")? - origin))
    }

    /// Warns that a file does not contain its units.
    fn warn_of_units(&mut self, lines: &Lines, number: usize, help: &str) {
        self.warn(&lines.origin(number), "the file does not say its units: they are taken as m and m/s", help);
    }
}
