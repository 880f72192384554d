//! Merges corners of triangles that differ only because the numbers in a file are rounded.

use super::Heap;
use nalgebra::Vector3;
use rustc_hash::{FxHashMap, FxHashSet};

/// [-] possible error of a coordinate, divided by the rounding error of the largest coordinate in single precision.
/// The error comes from a few arithmetic operations of the program that wrote the file.
const ROUNDINGS: f64 = 4.0;
/// Smallest number of significant digits with which programs write single precision (six, by the format `%g` of C).
/// Numbers with fewer digits are taken as exact.
const FEWEST: usize = 6;
/// [-] factor on the largest distance of merged corners, because the computed distance is rounded too.
const SLACK: f64 = 1.01;
/// [-] edge length of the cells of the neighbour search, divided by the largest distance of merged corners. With cells
/// of this size, only one cell must be searched for most points.
const CELL: f64 = 8.0;

/// Replaces each corner by an earlier corner that differs only by rounding, and returns the number of replaced
/// positions. Corners of several triangles at one position count once.
///
/// The coordinates are those of the file, before scaling and translation, and have at most `digits` [-] significant
/// digits.
pub fn weld(heap: &mut Heap, digits: usize) -> usize {
    let within = apart(heap, digits);
    if within <= 0.0 {
        return 0;
    }
    let mut grid: FxHashMap<[i64; 3], Vec<Vector3<f64>>> = FxHashMap::default();
    let mut known: FxHashMap<[u64; 3], Vector3<f64>> = FxHashMap::default();
    let cell = |value: f64| (value / (CELL * within)).floor() as i64;
    let mut welded = FxHashSet::default();
    for corner in heap.iter_mut().flatten() {
        // adding 0 turns -0 into 0, which is the same position
        let bits = [corner.x, corner.y, corner.z].map(|value| (value + 0.0).to_bits());
        if let Some(place) = known.get(&bits) {
            *corner = *place;
            continue;
        }
        let (low, high) = (corner.map(|value| cell(value - within)), corner.map(|value| cell(value + within)));
        let cells =
            (low.x..=high.x).flat_map(|x| (low.y..=high.y).flat_map(move |y| (low.z..=high.z).map(move |z| [x, y, z])));
        let near = |other: &&Vector3<f64>| (*other - *corner).amax() <= within;
        let earlier = cells.filter_map(|cell| grid.get(&cell)).flatten().find(near).copied();
        match earlier {
            Some(place) => {
                welded.insert(bits);
                *corner = place;
            }
            None => grid.entry([corner.x, corner.y, corner.z].map(cell)).or_default().push(*corner),
        }
        known.insert(bits, *corner);
    }
    welded.len()
}

/// Largest distance along each axis, in units of the file, between two corners that are merged.
fn apart(heap: &Heap, digits: usize) -> f64 {
    let largest = heap.iter().flatten().map(|corner| corner.amax()).fold(0.0, f64::max);
    if largest == 0.0 {
        return 0.0;
    }
    let single = ROUNDINGS * f64::from(f32::EPSILON) * largest;
    // unit of the last digit of the largest coordinate
    let last = 10f64.powi(largest.log10().floor() as i32 - digits as i32 + 1);
    let written = if digits < FEWEST { 0.0 } else { last };
    SLACK * single.max(written)
}
