//! Corners that differ only by the rounding of the file that they were read from are made one.

use super::Heap;
use nalgebra::Vector3;
use rustc_hash::{FxHashMap, FxHashSet};

/// [-] roundings of single precision, of the largest coordinate, by which a corner may be off: programs come to it by a few operations.
const ROUNDINGS: f64 = 4.0;
/// Least significant digits that programs write of single precision (`%g`); fewer than these were meant as they stand.
const FEWEST: usize = 6;
/// [-] of what two corners may be apart: their difference is rounded too.
const SLACK: f64 = 1.01;
/// [-] edge of the cells in which a near corner is looked for, over that distance: most points then ask one cell only.
const CELL: f64 = 8.0;

/// Puts corners that are as near to an earlier one as the file can tell in its place; gives how many.
///
/// The coordinates have at most so many significant `digits`. Distances are those of the file, before the part is scaled and moved.
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
        // 0 and -0 are the same place
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

/// Distance that corners may be apart along each axis, in the unit of the file, and still be the same.
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
