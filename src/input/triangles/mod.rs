//! Reads files of triangles: STL, as text or binary, and OBJ.

mod obj;
mod polygon;
mod stl;
mod weld;
mod words;

pub(crate) use words::digits;

use nalgebra::Vector3;
use std::path::Path;

/// Largest number of triangles of a mesh. While a wall is made from so many triangles, it may need 40 GB of memory.
const MOST_TRIANGLES: usize = 20_000_000;

/// Triangles, each given by its three corners: in units of the file or, after scaling, in m.
pub type Heap = Vec<[Vector3<f64>; 3]>;

/// Format of a file of triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TriangleFormat {
    /// STL, as text or binary.
    Stl,
    /// Wavefront OBJ.
    Obj,
}

impl TriangleFormat {
    /// Format by the end of the name of a file, `.stl` or `.obj` in small letters or capitals; `None` for other names.
    pub fn of(name: &str) -> Option<Self> {
        let lower = name.to_lowercase();
        let formats = [(".stl", Self::Stl), (".obj", Self::Obj)];
        formats.into_iter().find(|(end, _)| lower.ends_with(end)).map(|(_, format)| format)
    }

    /// Reads the contents of a file in this format.
    ///
    /// # Errors
    /// A message in words: the fault of the file, with its line or triangle.
    pub fn read(self, bytes: &[u8]) -> Result<TriangleFile, String> {
        match self {
            Self::Stl => stl::stl(bytes),
            Self::Obj => obj::obj(bytes),
        }
    }
}

/// Reason why a file of triangles was not read.
#[derive(Debug, thiserror::Error)]
pub enum TriangleError {
    /// The system could not read the file.
    #[error("{0}: {1}")]
    Unreadable(String, std::io::Error),
    /// The contents are not triangles: name of the file, and the reason in words.
    #[error("{0} {1}")]
    Faulty(String, String),
}

/// Triangles read from a file, with remarks about the file.
///
/// ```
/// # mod diptych { pub use {diptych_input::triangles, diptych_physics::*}; }
/// use diptych::triangles::TriangleFile;
/// use diptych::{Domain, Mesh, Scene, Species, Surface, Vector3, Wall, WallGeometry};
///
/// # std::env::set_current_dir("../..")?; // the folder of the repository
/// let file = TriangleFile::read("cases/walls/hopper.stl")?.scaled(1e-3); // millimetres
/// let (_, findings) = Mesh::new("hopper", &file.heap, None)?;
/// assert_eq!((file.heap.len(), findings.open_edges > 0), (192, true)); // a thin sheet
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct TriangleFile {
    /// Triangles, in the order of the file.
    pub heap: Heap,
    /// Number of corners that differed from others only by rounding, and were merged.
    pub welded: usize,
    /// Remarks in words about properties of the file that the user should know, such as polygons that are not flat.
    pub notes: Vec<String>,
}

impl TriangleFile {
    /// Reads an STL or OBJ file. The name of the file must end with `.stl` or `.obj`. Corners are in the unit of the
    /// file, which no file states; see [`scaled`](Self::scaled).
    ///
    /// # Errors
    /// The file cannot be read, or its contents are not triangles.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, TriangleError> {
        let name = path.as_ref().display().to_string();
        let Some(format) = TriangleFormat::of(&name) else {
            let why = "is neither an STL nor an OBJ file: its name ends with neither .stl nor .obj";
            return Err(TriangleError::Faulty(name, why.into()));
        };
        let bytes = std::fs::read(path).map_err(|why| TriangleError::Unreadable(name.clone(), why))?;
        format.read(&bytes).map_err(|why| TriangleError::Faulty(name, why))
    }

    /// Multiplies all coordinates by `unit` [m], the length of one unit of the file.
    pub fn scaled(mut self, unit: f64) -> Self {
        self.heap.iter_mut().flatten().for_each(|corner| *corner *= unit);
        self
    }

    /// Makes the result of reading a file. Corners that differ only by rounding are merged. The coordinates have at
    /// most `digits` [-] significant digits.
    fn new(mut heap: Heap, digits: usize, notes: Vec<String>) -> Self {
        let welded = weld::weld(&mut heap, digits);
        Self { heap, welded, notes }
    }
}

/// Message about a line of a file, counted from 1, that cannot be read in the given format.
fn wrong(format: &str, line: usize, what: impl std::fmt::Display) -> String {
    format!("is no {format} that can be read: line {line}: {what}")
}

fn too_many(given: usize) -> String {
    format!("has {given} triangles or more; allowed: up to {MOST_TRIANGLES}")
}
