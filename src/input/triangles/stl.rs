//! Reads STL files, as text or binary. Normals in the file are ignored, because the corners determine them.
//!
//! Format: M. Burns, Automated Fabrication (1993), section 6.5. Text files of real programs deviate from this format.
//! They contain several solids, missing names, any encoding, leading blanks, capitals, any line ends, or no `endsolid`.
//! A file is binary if its length fits the number of triangles in its head, even if it begins like a text file.

use super::words::Words;
use super::{Heap, MOST_TRIANGLES, TriangleFile, too_many, wrong};
use nalgebra::Vector3;

/// [byte] length of the head of a binary file; the number of triangles is at its end. `TRIANGLE` is the length of one
/// triangle.
const HEAD: usize = 84;
const TRIANGLE: usize = 50;
/// Number of significant decimal digits that distinguish all numbers in single precision.
const SINGLE: usize = 9;
const TEXT: &str = "text STL file";

/// Reads the triangles of an STL file, text or binary.
///
/// # Errors
/// A message in words: the recognized format, and the faulty line or triangle.
pub fn stl(bytes: &[u8]) -> Result<TriangleFile, String> {
    let announced = bytes.get(HEAD - 4..HEAD).and_then(|count| count.try_into().ok()).map(u32::from_le_bytes);
    let length = |count: u32| HEAD as u64 + u64::from(count) * TRIANGLE as u64;
    match announced {
        Some(count) if bytes.len() as u64 == length(count) => binary(bytes, count),
        _ if begins_as_text(bytes) => text(bytes),
        Some(count) if has_nul(bytes) => binary(bytes, count),
        _ => Err("is no STL file: a text one begins with `solid`, a binary one has a head of 84 bytes".into()),
    }
}

/// True if a file begins with a word of the text format and has no zero byte in its head. The head of a binary file has
/// a zero byte if it announces fewer than 2^24 triangles.
fn begins_as_text(bytes: &[u8]) -> bool {
    let first = Words::of(bytes).next();
    first.is_some_and(|word| word.is("solid") || word.is("facet")) && !has_nul(bytes)
}

/// True if the first `HEAD` bytes (the length of the head of a binary file) contain a zero byte.
fn has_nul(bytes: &[u8]) -> bool {
    bytes[..bytes.len().min(HEAD)].contains(&0)
}

/// Reads a binary STL file whose head announces `count` triangles.
fn binary(bytes: &[u8], count: u32) -> Result<TriangleFile, String> {
    let (body, count) = (&bytes[HEAD..], count as usize);
    let (there, rest) = (body.len() / TRIANGLE, body.len() % TRIANGLE);
    if there != count {
        let what = format!("its head announces {count} triangles, {there} are there");
        let and = if rest > 0 { format!(" and {rest} bytes of one more") } else { String::new() };
        return Err(format!("is no binary STL file that can be read: {what}{and}"));
    }
    if count > MOST_TRIANGLES {
        return Err(too_many(count));
    }
    let mut heap = Heap::with_capacity(count);
    for (number, triangle) in body.chunks_exact(TRIANGLE).enumerate() {
        let single = |k: usize| {
            let at = 12 + 4 * k;
            let four = [triangle[at], triangle[at + 1], triangle[at + 2], triangle[at + 3]];
            f64::from(f32::from_le_bytes(four))
        };
        let corners: [Vector3<f64>; 3] =
            std::array::from_fn(|corner| Vector3::from_fn(|axis, _| single(3 * corner + axis)));
        if !corners.iter().flatten().all(|value| value.is_finite()) {
            let what = format!("triangle {} has a corner that is not a finite number", number + 1);
            return Err(format!("is no binary STL file that can be read: {what}"));
        }
        heap.push(corners);
    }
    let left = (rest > 0).then(|| format!("{rest} bytes after the last of its {count} triangles, left aside"));
    Ok(TriangleFile::new(heap, SINGLE, left.into_iter().collect()))
}

/// Reads an STL file in the text format.
fn text(bytes: &[u8]) -> Result<TriangleFile, String> {
    let mut words = Words::of(bytes);
    let (mut heap, mut digits) = (Heap::new(), 0);
    while let Some(word) = words.next() {
        if word.is("solid") || word.is("endsolid") {
            skip_name(&mut words);
        } else if word.is("facet") {
            let number = heap.len() + 1;
            heap.push(facet(&mut words, (word.line, number), &mut digits)?);
            if heap.len() > MOST_TRIANGLES {
                return Err(too_many(heap.len()));
            }
        } else {
            let what = format!("{} where `facet`, `solid` or `endsolid` belongs", word.shown());
            return Err(wrong(TEXT, word.line, what));
        }
    }
    Ok(TriangleFile::new(heap, digits, Vec::new()))
}

/// Skips the name of a solid, up to the end of the line or a facet in the same line.
fn skip_name(words: &mut Words) {
    loop {
        let before = words.clone();
        let Some(word) = words.next_in_line() else { return };
        let begins =
            |first: &str, second: &str| word.is(first) && words.clone().next().is_some_and(|next| next.is(second));
        if begins("facet", "normal") {
            *words = before;
            return;
        }
    }
}

/// Corners of a facet (triangle) whose first word `facet` has been read. `line` is the line of that word, and `number`
/// the number of the triangle. `digits` is raised to the largest number of significant digits read.
fn facet(words: &mut Words, (line, number): (usize, usize), digits: &mut usize) -> Result<[Vector3<f64>; 3], String> {
    let ended = || wrong(TEXT, line, format!("the file ends in triangle {number}, in the facet that begins here"));
    // the normal is ignored, so that its words may be anything or absent
    if !words.by_ref().take(5).any(|word| word.is("outer")) {
        let none = || wrong(TEXT, line, format!("no `outer loop` in the facet of triangle {number}"));
        return Err(words.next().map_or_else(ended, |_| none()));
    }
    let expect = |words: &mut Words, wanted: &str| {
        let word = words.next().ok_or_else(ended)?;
        let why = || wrong(TEXT, word.line, format!("{} where `{wanted}` belongs, in triangle {number}", word.shown()));
        if word.is(wanted) { Ok(()) } else { Err(why()) }
    };
    expect(words, "loop")?;
    let mut corners = [Vector3::zeros(); 3];
    for corner in &mut corners {
        expect(words, "vertex")?;
        for axis in 0..3 {
            let word = words.next().ok_or_else(ended)?;
            let (value, count) =
                word.number().map_err(|why| wrong(TEXT, word.line, format!("{why}, in triangle {number}")))?;
            corner[axis] = value;
            *digits = count.max(*digits);
        }
    }
    expect(words, "endloop")?;
    expect(words, "endfacet")?;
    Ok(corners)
}
