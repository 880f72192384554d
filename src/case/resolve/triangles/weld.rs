//! Merges corners that differ only by the rounding of the file that they were read from.

use super::Heap;
use nalgebra::Vector3;
use rustc_hash::{FxHashMap, FxHashSet};

/// [-] possible error of a corner, in roundings of single precision of the largest coordinate: programs reach it by a
/// few operations.
const ROUNDINGS: f64 = 4.0;
/// Smallest number of significant digits that programs write of single precision (`%g`); numbers with fewer digits are
/// exact.
const FEWEST: usize = 6;
/// [-] factor on the allowed distance of two corners: their difference is rounded too.
const SLACK: f64 = 1.01;
/// [-] edge of the cells of the neighbour search, over the allowed distance: for most points one cell is enough.
const CELL: f64 = 8.0;

/// Replaces each corner by an earlier one if the file cannot tell them apart; returns the number of merged corners.
///
/// The coordinates have at most `digits` [-] significant digits. Distances are those of the file, before the part is
/// scaled and moved.
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
        // 0 and -0 are one position
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

/// Distance up to which two corners are merged, along each axis, in the unit of the file.
fn apart(heap: &Heap, digits: usize) -> f64 {
    let largest = heap.iter().flatten().map(|corner| corner.amax()).fold(0.0, f64::max);
    if largest == 0.0 {
        return 0.0;
    }
    let single = ROUNDINGS * f64::from(f32::EPSILON) * largest;
    // the last digit of the largest coordinate
    let last = 10f64.powi(largest.log10().floor() as i32 - digits as i32 + 1);
    let written = if digits < FEWEST { 0.0 } else { last };
    SLACK * single.max(written)
}
