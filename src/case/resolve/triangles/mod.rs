//! Reads files of triangles: STL, as text or binary, and OBJ.

mod obj;
mod polygon;
mod stl;
mod weld;
mod words;

pub(super) use obj::obj;
pub(super) use stl::stl;
pub(super) use words::digits;

use nalgebra::Vector3;

/// Largest number of triangles of a mesh; this number takes about 15 GB of memory.
const MOST_TRIANGLES: usize = 20_000_000;

/// Triangles given by their corners, in units of the file.
pub(super) type Heap = Vec<[Vector3<f64>; 3]>;

/// Triangles read from a file, with remarks about the file.
#[derive(Debug, Default)]
pub(super) struct TriangleFile {
    /// Triangles, in the order of the file.
    pub heap: Heap,
    /// Number of corners that differed from others only by rounding, and were merged.
    pub welded: usize,
    /// Remarks about other properties of the file, in words.
    pub notes: Vec<String>,
}

impl TriangleFile {
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
