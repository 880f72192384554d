//! Many numbers at a time.
//!
//! Of a block of numbers the leading bits are cut off on a grid so coarse that floating-point sums of them are exact, then the next ones:
//! the "error-free vector transformation" of S. M. Rump, T. Ogita and S. Oishi, "Accurate floating-point summation part I", SIAM J.
//! Sci. Comput. 31, 189 (2008), algorithm 3.2. A block then costs two numbers in the exact sum. Where bits are left over, as in blocks
//! whose numbers differ by more than ten orders of magnitude, its numbers are added one by one.

use super::ExactSum;
use rayon::prelude::*;
use std::array::from_fn;

/// Rows of a block.
pub const BLOCK: usize = 128;
/// [-] σ over the largest number of a block, rounded up to a power of two: at least `BLOCK` + 2.
const ROOM: f64 = 256.0;
/// [-] the second σ over the first: what the first leaves over is at most 2^-53 of it.
const NEXT: f64 = ROOM * f64::EPSILON / 2.0;
/// Largest numbers of a block between which nothing overflows and no bit falls below the smallest number.
const SAFE: std::ops::Range<f64> = 1e-250..1e290;
/// Numbers of one sum that are added side by side.
const LANES: usize = 8;
/// Particles below which a second thread is not worth it.
const CHUNK: usize = 8192;

/// Adds up K columns at the same time: of at most [`BLOCK`] rows each.
fn add_block<const K: usize>(sums: &mut [ExactSum; K], rows: &[[f64; K]]) {
    let mut largest = [0.0_f64; K];
    for row in rows {
        for k in 0..K {
            let size = row[k].abs();
            largest[k] = if size > largest[k] { size } else { largest[k] };
        }
    }
    let first: [f64; K] = from_fn(|k| power_above(largest[k]) * ROOM);
    let next: [f64; K] = from_fn(|k| first[k] * NEXT);
    let (mut high, mut low, mut left) = ([0.0; K], [0.0; K], [0_u64; K]);
    for row in rows {
        for k in 0..K {
            let leading = (first[k] + row[k]) - first[k];
            let rest = row[k] - leading;
            let second = (next[k] + rest) - next[k];
            high[k] += leading;
            low[k] += second;
            left[k] |= (rest - second).to_bits();
        }
    }
    for k in 0..K {
        if left[k] == 0 && (SAFE.contains(&largest[k]) || largest[k] == 0.0) {
            sums[k].add(high[k]);
            sums[k].add(low[k]);
        } else {
            rows.iter().for_each(|row| sums[k].add(row[k]));
        }
    }
}

/// A power of two above a number that is 0 or normal, and at most twice it.
#[inline]
fn power_above(x: f64) -> f64 {
    f64::from_bits((x.to_bits() & 0x7ff << 52) + (1 << 52))
}

/// Adds up K columns at the same time.
#[inline]
pub fn add_rows<const K: usize>(sums: &mut [ExactSum; K], rows: &[[f64; K]]) {
    rows.chunks(BLOCK).for_each(|block| add_block(sums, block));
}

/// Adds all numbers to one sum.
pub fn add_all(sum: &mut ExactSum, numbers: &[f64]) {
    let (rows, rest) = numbers.as_chunks::<LANES>();
    let mut lanes: [ExactSum; LANES] = from_fn(|_| ExactSum::default());
    add_rows(&mut lanes, rows);
    lanes.iter().for_each(|lane| sum.merge(lane));
    rest.iter().for_each(|&x| sum.add(x));
}

/// The value of each sum.
pub fn values<const K: usize>(sums: &[ExactSum; K]) -> [f64; K] {
    from_fn(|k| sums[k].value())
}

fn none<const K: usize>() -> [ExactSum; K] {
    from_fn(|_| ExactSum::default())
}

/// Sums of what `of` says of 0 .. `count`: the same for any order and any number of threads.
pub fn sums<const K: usize>(count: usize, of: impl Fn(usize) -> [f64; K] + Sync) -> [ExactSum; K] {
    let piece = |first: usize| {
        let (mut sums, mut rows) = (none(), [[0.0; K]; BLOCK]);
        let last = count.min(first + CHUNK);
        for start in (first..last).step_by(BLOCK) {
            let rows = &mut rows[..BLOCK.min(last - start)];
            for (k, row) in rows.iter_mut().enumerate() {
                *row = of(start + k);
            }
            add_block(&mut sums, rows);
        }
        sums
    };
    if count <= CHUNK {
        return piece(0);
    }
    let merge = |mut one: [ExactSum; K], other: [ExactSum; K]| {
        one.iter_mut().zip(&other).for_each(|(one, other)| one.merge(other));
        one
    };
    (0..count).into_par_iter().step_by(CHUNK).map(piece).reduce(none, merge)
}

/// The same for each of some groups; `of` says which one a row belongs to.
pub fn sums_in_groups<const K: usize>(
    groups: usize,
    count: usize,
    of: impl Fn(usize) -> (usize, [f64; K]) + Sync,
) -> Vec<[ExactSum; K]> {
    /// Rows that wait until they are worth a block.
    const WAITING: usize = 32;
    let piece = |first: usize, last: usize| {
        let mut sums: Vec<[ExactSum; K]> = (0..groups).map(|_| none()).collect();
        let mut waiting = vec![[[0.0; K]; WAITING]; groups];
        let mut counts = vec![0; groups];
        for k in first..last {
            let (group, row) = of(k);
            waiting[group][counts[group]] = row;
            counts[group] += 1;
            if counts[group] == WAITING {
                add_block(&mut sums[group], &waiting[group]);
                counts[group] = 0;
            }
        }
        for (group, sums) in sums.iter_mut().enumerate() {
            add_block(sums, &waiting[group][..counts[group]]);
        }
        sums
    };
    if count <= CHUNK {
        return piece(0, count);
    }
    // as few pieces as there is work for: each has all sums of its own
    let pieces = count.div_ceil(CHUNK).min(2 * rayon::current_num_threads());
    let start = |k: usize| count * k / pieces;
    let parts: Vec<_> = (0..pieces).into_par_iter().map(|k| piece(start(k), start(k + 1))).collect();
    let mut parts = parts.into_iter();
    let mut all = parts.next().unwrap_or_default();
    for part in parts {
        all.as_flattened_mut().iter_mut().zip(part.as_flattened()).for_each(|(all, part)| all.merge(part));
    }
    all
}
