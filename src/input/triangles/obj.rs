//! Reads Wavefront OBJ files: corners (`v`) and polygons (`f`). Normals, textures, materials, groups, points and lines
//! are ignored.
//!
//! Format: Wavefront, Advanced Visualizer Manual, appendix B1, "Object files".

use super::polygon::cut;
use super::words::{Word, Words};
use super::{Heap, MOST_TRIANGLES, TriangleFile, too_many, wrong};
use nalgebra::Vector3;
use std::ops::Range;

const FORMAT: &str = "OBJ file";
/// Names of statements of an OBJ file that do not affect the surface, and are ignored.
const LEFT_ASIDE: [&str; 20] = [
    "vt",
    "vn",
    "vp",
    "g",
    "o",
    "s",
    "mg",
    "mtllib",
    "usemtl",
    "usemap",
    "maplib",
    "l",
    "p",
    "lod",
    "bevel",
    "c_interp",
    "d_interp",
    "shadow_obj",
    "trace_obj",
    "vc",
];
/// [-] distance of a corner from the plane of its polygon, divided by the length of the polygon (largest distance of a
/// corner from its first corner), above which a warning is given.
const FLAT: f64 = 0.01;

/// Polygon of an OBJ file: the number of its line, and the range of its corners in the list of the corners of all
/// polygons (`Reading::named`).
struct Polygon {
    line: usize,
    corners: Range<usize>,
}

/// Contents of an OBJ file that have been read so far.
#[derive(Default)]
struct Reading {
    places: Vec<Vector3<f64>>,
    digits: usize,
    polygons: Vec<Polygon>,
    /// Corners of all polygons, one polygon after the other, as indices into `places`.
    named: Vec<usize>,
    /// First statement with an unknown name (and its line), and the number of all such statements; `None` if there are
    /// none.
    unknown: Option<(String, usize)>,
}

/// Reads the triangles of an OBJ file. Polygons are divided into triangles.
///
/// # Errors
/// A message in words, with the number of the line.
pub fn obj(bytes: &[u8]) -> Result<TriangleFile, String> {
    let mut reading = Reading::default();
    let mut words = Words::of(bytes);
    while let Some(first) = words.next() {
        if first.bytes.starts_with(b"#") {
            while words.next_in_line().is_some() {}
        } else {
            reading.statement(first, &statement(&mut words))?;
        }
    }
    if reading.polygons.is_empty() {
        return Err(format!("is no {FORMAT}: it has no faces (lines that begin with `f`)"));
    }
    let mut notes: Vec<String> = Vec::new();
    if let Some((first, count)) = &reading.unknown {
        notes.push(format!("{count} statements that make no triangles, left aside: the first is {first}"));
    }
    let heap = reading.triangles(&mut notes)?;
    Ok(TriangleFile::new(heap, reading.digits, notes))
}

/// Words of a statement after the first, up to a comment or the end of the line. A backslash at the end of a line
/// continues the statement on the next line.
fn statement<'a>(words: &mut Words<'a>) -> Vec<Word<'a>> {
    let mut rest = Vec::new();
    while let Some(mut word) = words.next_in_line() {
        if word.bytes.starts_with(b"#") {
            while words.next_in_line().is_some() {}
            break;
        }
        let goes_on = word.bytes.ends_with(b"\\") && words.clone().next_in_line().is_none();
        if goes_on {
            word.bytes = &word.bytes[..word.bytes.len() - 1];
        }
        if !word.bytes.is_empty() {
            rest.push(word);
        }
        if goes_on {
            words.next_line();
        }
    }
    rest
}

impl Reading {
    /// Reads one statement of the file. `first` is its first word, and `rest` are the other words.
    fn statement(&mut self, first: Word, rest: &[Word]) -> Result<(), String> {
        if first.is("v") {
            let [x, y, z, ..] = rest else {
                return Err(wrong(
                    FORMAT,
                    first.line,
                    format!("a corner has three coordinates, {} are there", rest.len()),
                ));
            };
            let mut place = Vector3::zeros();
            for (axis, word) in [x, y, z].into_iter().enumerate() {
                let (value, digits) = word.number().map_err(|why| wrong(FORMAT, word.line, why))?;
                place[axis] = value;
                self.digits = digits.max(self.digits);
            }
            self.places.push(place);
        } else if first.is("f") || first.is("fo") {
            let mut corners: Vec<usize> = rest.iter().map(|word| self.corner(word)).collect::<Result<_, _>>()?;
            if corners.len() < 3 {
                let what = format!("a face has three corners or more, {} are there", corners.len());
                return Err(wrong(FORMAT, first.line, what));
            }
            // corners repeated one after the other count once
            corners.dedup();
            while corners.len() > 3 && corners.first() == corners.last() {
                corners.pop();
            }
            let begin = self.named.len();
            self.named.append(&mut corners);
            self.polygons.push(Polygon { line: first.line, corners: begin..self.named.len() });
            if self.polygons.len() > MOST_TRIANGLES {
                return Err(too_many(self.polygons.len()));
            }
        } else if !LEFT_ASIDE.iter().any(|known| first.is(known)) {
            let (_, count) =
                self.unknown.get_or_insert_with(|| (format!("{} in line {}", first.shown(), first.line), 0));
            *count += 1;
        }
        Ok(())
    }

    /// Index of the corner to which a word of a face refers. A positive number is counted from the first corner of the
    /// file, a negative one backwards from the last corner read.
    fn corner(&self, word: &Word) -> Result<usize, String> {
        let text = std::str::from_utf8(word.bytes).unwrap_or("");
        let number = text.split('/').next().and_then(|number| number.parse::<i64>().ok());
        let known = self.places.len() as i64;
        match number {
            Some(number) if number > 0 => Ok((number - 1) as usize),
            Some(number) if number < 0 && number >= -known => Ok((known + number) as usize),
            Some(number) if number < 0 => {
                Err(wrong(FORMAT, word.line, format!("corner {number} is not there: {known} corners stand before")))
            }
            _ => {
                Err(wrong(FORMAT, word.line, format!("{} is no corner of a face: corners count from 1", word.shown())))
            }
        }
    }

    /// Divides all polygons into triangles. Adds a remark to `notes` if polygons are not flat.
    fn triangles(&self, notes: &mut Vec<String>) -> Result<Heap, String> {
        let mut heap = Heap::new();
        let (mut bent, mut farthest) = (Vec::new(), 0.0f64);
        for polygon in &self.polygons {
            let place = |corner: &usize| {
                let none = || {
                    let what =
                        format!("corner {} is not there: the file has {}", corner.saturating_add(1), self.places.len());
                    wrong(FORMAT, polygon.line, what)
                };
                self.places.get(*corner).copied().ok_or_else(none)
            };
            let mut corners: Vec<Vector3<f64>> =
                self.named[polygon.corners.clone()].iter().map(place).collect::<Result<_, _>>()?;
            if corners.len() < 3 {
                // this gives a triangle without area, which is reported and ignored later
                corners.resize(3, corners[0]);
            }
            let cut = cut(&corners).map_err(|why| wrong(FORMAT, polygon.line, why))?;
            heap.extend(cut.triangles.iter().map(|triangle| triangle.map(|corner| corners[corner])));
            if cut.off > FLAT {
                bent.push(polygon.line);
                farthest = farthest.max(cut.off);
            }
            if heap.len() > MOST_TRIANGLES {
                return Err(too_many(heap.len()));
            }
        }
        if let Some(first) = bent.first() {
            let percent = 100.0 * farthest;
            notes.push(format!(
                "{} polygons that are not flat, by up to {percent:.1} % of their length, the first in line {first}: cut into triangles in one \
                 of the ways there are",
                bent.len()
            ));
        }
        Ok(heap)
    }
}
