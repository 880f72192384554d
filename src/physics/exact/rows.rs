//! Exact sums of many numbers at a time.
//!
//! The method is the "error-free vector transformation" of S. M. Rump, T. Ogita and S. Oishi, "Accurate floating-point
//! summation part I", SIAM J. Sci. Comput. 31, 189 (2008), algorithm 3.2. Adding a large number σ to a number and
//! subtracting σ again cuts off the lower bits of the number. The remaining leading bits of all numbers of a block are
//! multiples of one power of two, so their floating-point sum is exact. A second, smaller σ yields the next bits. Then
//! only two numbers per block are added to the exact sum. If bits remain, as in blocks whose numbers differ by more
//! than ten orders of magnitude, the numbers are added one by one.

use super::ExactSum;
use crate::work_sharing;
use std::array::from_fn;

/// Largest number of rows that are added together as a block. A row contains one number for each of several sums.
pub const BLOCK: usize = 128;
/// [-] first σ divided by the smallest power of two above all numbers of a block. σ is a large number that cuts off the
/// lower bits of other numbers. The ratio must be at least `BLOCK` + 2.
const ROOM: f64 = 256.0;
/// [-] second σ divided by the first σ. Each σ is a large number that cuts off the lower bits of other numbers. The
/// first σ leaves remainders of at most 2^-53 times this σ.
const NEXT: f64 = ROOM * f64::EPSILON / 2.0;
/// Range for the largest magnitude of the numbers in a block. Within this range nothing overflows and no bit is lost by
/// underflow.
const SAFE: std::ops::Range<f64> = 1e-250..1e290;
/// Number of partial sums into which the sum of a list is split, because a processor can add to several sums at the
/// same time.
const LANES: usize = 4;
/// Number of terms in one piece of work of a thread. With fewer terms, a second thread costs more time than it saves.
const CHUNK: usize = 8192;

/// Two partial sums of each of the K columns of a block of rows. `high` is the sum of the leading bits of the numbers,
/// `low` that of the next bits.
struct Parts<const K: usize> {
    high: [f64; K],
    low: [f64; K],
    /// For each column, the bits of all rows that are not contained in the two partial sums, combined by bitwise OR.
    /// The bits of a column are 0, apart from the sign bit of a zero, if its partial sums are exact.
    left: [u64; K],
    /// Largest magnitude of the numbers in each column of the block.
    largest: [f64; K],
}

/// Computes the entries of `parts` (partial sums, remaining bits and largest magnitudes) for T columns, the first of
/// which has the index `at`. T must be so small that the sums fit into the registers of a processor.
#[inline(always)]
fn columns<const T: usize, const K: usize>(rows: &[[f64; K]], at: usize, parts: &mut Parts<K>) {
    let of = |row: &[f64; K]| -> [f64; T] { from_fn(|k| row[at + k]) };
    let mut largest = [0.0_f64; T];
    for row in rows {
        let row = of(row);
        for k in 0..T {
            let size = row[k].abs();
            largest[k] = if size > largest[k] { size } else { largest[k] };
        }
    }
    let first: [f64; T] = from_fn(|k| power_above(largest[k]) * ROOM);
    let next: [f64; T] = from_fn(|k| first[k] * NEXT);
    let (mut high, mut low, mut left) = ([0.0; T], [0.0; T], [0_u64; T]);
    for row in rows {
        let row = of(row);
        for k in 0..T {
            let leading = (first[k] + row[k]) - first[k];
            let rest = row[k] - leading;
            let second = (next[k] + rest) - next[k];
            high[k] += leading;
            low[k] += second;
            left[k] |= (rest - second).to_bits();
        }
    }
    parts.high[at..at + T].copy_from_slice(&high);
    parts.low[at..at + T].copy_from_slice(&low);
    parts.left[at..at + T].copy_from_slice(&left);
    parts.largest[at..at + T].copy_from_slice(&largest);
}

#[inline(always)]
fn parts<const K: usize>(rows: &[[f64; K]]) -> Parts<K> {
    let mut parts = Parts { high: [0.0; K], low: [0.0; K], left: [0; K], largest: [0.0; K] };
    let mut at = 0;
    // each addition waits for the previous one of its column, so twelve columns at a time are needed to use a processor
    // fully
    while at + 12 <= K {
        columns::<12, K>(rows, at, &mut parts);
        at += 12;
    }
    while at + 4 <= K {
        columns::<4, K>(rows, at, &mut parts);
        at += 4;
    }
    if at + 2 <= K {
        columns::<2, K>(rows, at, &mut parts);
        at += 2;
    }
    if at < K {
        columns::<1, K>(rows, at, &mut parts);
    }
    parts
}

/// Computes the partial sums of all columns of a block together. `rows` is iterated twice: first for the largest
/// numbers, then for the sums.
#[inline(always)]
fn all_columns<const K: usize>(rows: impl Iterator<Item = [f64; K]> + Clone) -> Parts<K> {
    let mut largest = [0.0_f64; K];
    for row in rows.clone() {
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
    Parts { high, low, left, largest }
}

/// Calls `make`, compiled for wide vector instructions (x86-64-v3) if the processor has them. The results are equal
/// with and without these instructions.
#[inline(always)]
fn at_once<R>(make: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return simd.vectorize(make);
    }
    make()
}

/// Adds the rows of one block, at most [`BLOCK`], to the sums of their K columns.
fn add_block<const K: usize>(sums: [&mut ExactSum; K], rows: &[[f64; K]]) {
    add_parts(
        sums,
        at_once(
            #[inline(always)]
            || parts(rows),
        ),
        rows.iter().copied(),
    );
}

/// Adds the partial sums of a block to the exact sums of its K columns. If the partial sums of a column are not exact,
/// adds every row of this column instead.
fn add_parts<const K: usize>(sums: [&mut ExactSum; K], parts: Parts<K>, rows: impl Iterator<Item = [f64; K]> + Clone) {
    let Parts { high, low, left, largest } = parts;
    for (k, sum) in sums.into_iter().enumerate() {
        if left[k] << 1 == 0 && (SAFE.contains(&largest[k]) || largest[k] == 0.0) {
            sum.add(high[k]);
            sum.add(low[k]);
        } else {
            rows.clone().for_each(|row| sum.add(row[k]));
        }
    }
}

/// Smallest power of two that is larger than `x`, a normal positive number. For `x` = 0 it is the smallest normal
/// number.
#[inline]
fn power_above(x: f64) -> f64 {
    f64::from_bits((x.to_bits() & 0x7ff << 52) + (1 << 52))
}

/// Adds rows to the exact sums of their K columns.
#[inline]
pub fn add_rows<const K: usize>(mut sums: [&mut ExactSum; K], rows: &[[f64; K]]) {
    rows.chunks(BLOCK).for_each(|block| add_block(sums.each_mut().map(|sum| &mut **sum), block));
}

/// Moves all rows from `rows`, which has at most [`BLOCK`] of them, to the end of `few`. If two rows can represent the
/// exact sums of all columns, these two rows are appended to `few` instead of the rows themselves.
pub fn condense<const K: usize>(rows: &mut Vec<[f64; K]>, few: &mut Vec<[f64; K]>) {
    if rows.len() > 2 {
        let Parts { high, low, left, largest } = at_once(
            #[inline(always)]
            || parts(rows),
        );
        let holds = |k: usize| left[k] << 1 == 0 && (SAFE.contains(&largest[k]) || largest[k] == 0.0);
        if (0..K).all(holds) {
            few.extend([high, low]);
            rows.clear();
        }
    }
    few.append(rows);
}

/// Adds all numbers of a list to one exact sum.
pub fn add_all(sum: &mut ExactSum, numbers: &[f64]) {
    let (rows, rest) = numbers.as_chunks::<LANES>();
    let mut lanes: [ExactSum; LANES] = from_fn(|_| ExactSum::default());
    add_rows(lanes.each_mut(), rows);
    lanes.iter().for_each(|lane| sum.merge(lane));
    rest.iter().for_each(|&x| sum.add(x));
}

/// Returns the values of K exact sums, each rounded to the nearest `f64`.
pub fn values<const K: usize>(sums: &[ExactSum; K]) -> [f64; K] {
    from_fn(|k| sums[k].value())
}

/// Makes K empty sums.
pub fn none<const K: usize>() -> [ExactSum; K] {
    from_fn(|_| ExactSum::default())
}

/// Adds two sets of K sums, sum by sum, and returns the result.
pub fn merged<const K: usize>(mut one: [ExactSum; K], other: [ExactSum; K]) -> [ExactSum; K] {
    one.iter_mut().zip(&other).for_each(|(one, other)| one.merge(other));
    one
}

/// Exact sums of rows of K numbers, column by column, computed on all threads. `of(k)` returns row k, for k from 0 to
/// `count` - 1.
pub fn sums<const K: usize>(count: usize, of: impl Fn(usize) -> [f64; K] + Sync) -> [ExactSum; K] {
    let piece = |first: usize| {
        let (mut sums, mut rows) = (none(), [[0.0; K]; BLOCK]);
        let last = count.min(first + CHUNK);
        for start in (first..last).step_by(BLOCK) {
            let rows = &mut rows[..BLOCK.min(last - start)];
            for (k, row) in rows.iter_mut().enumerate() {
                *row = of(start + k);
            }
            add_block(sums.each_mut(), rows);
        }
        sums
    };
    if count <= CHUNK {
        return piece(0);
    }
    work_sharing::map((0..count).step_by(CHUNK), piece).into_iter().fold(none(), merged)
}

/// Exact sum of the numbers that `of` returns for the items.
pub fn sum<T: Sync>(items: &[T], of: impl Fn(&T) -> f64 + Sync) -> ExactSum {
    sum_and_largest(items, of).0
}

/// Exact sum of the numbers that `of` returns for the items, and the largest of these numbers. The largest number is at
/// least 0, and infinite if a number is NaN.
pub fn sum_and_largest<T: Sync>(items: &[T], of: impl Fn(&T) -> f64 + Sync) -> (ExactSum, f64) {
    let piece = |items: &[T]| {
        let (mut sums, mut numbers) = (none::<LANES>(), [0.0; BLOCK * LANES]);
        let (mut most, mut rounded) = ([0.0f64; LANES], [0.0; LANES]);
        for items in items.chunks(BLOCK * LANES) {
            for (number, item) in numbers.iter_mut().zip(items) {
                *number = of(item);
            }
            let (rows, rest) = numbers[..items.len()].as_chunks::<LANES>();
            add_block(sums.each_mut(), rows);
            rest.iter().for_each(|&x| sums[0].add(x));
            let mut last = [0.0; LANES];
            last[..rest.len()].copy_from_slice(rest);
            for row in rows.iter().chain([&last]) {
                // a comparison with NaN is false, but the sum of numbers with a NaN is NaN and shows it
                most = from_fn(|k| if row[k] > most[k] { row[k] } else { most[k] });
                rounded = from_fn(|k| rounded[k] + row[k]);
            }
        }
        let most = if rounded.iter().any(|sum: &f64| sum.is_nan()) {
            f64::INFINITY
        } else {
            most.into_iter().fold(0.0, f64::max)
        };
        (sums, most)
    };
    let both = |(sums, most), (others, other): ([ExactSum; LANES], f64)| (merged(sums, others), other.max(most));
    let (lanes, most) = if items.len() <= CHUNK {
        piece(items)
    } else {
        work_sharing::map(items.chunks(CHUNK), piece).into_iter().fold((none(), 0.0), both)
    };
    let mut all = ExactSum::default();
    lanes.iter().for_each(|lane| all.merge(lane));
    (all, most)
}

/// Sums of the K numbers that `of` computes from each group of N consecutive items. If fewer than N items remain at
/// the end of the work of one thread, they are followed by `T::default()` in their group. For these default items `of`
/// must return zeros.
pub fn side_by_side<T: Copy + Default + Sync, const N: usize, const K: usize>(
    items: &[T],
    of: impl Fn(&[T; N]) -> [f64; K] + Sync,
) -> [ExactSum; K] {
    let piece = |items: &[T]| {
        let mut sums = none();
        for items in items.chunks(BLOCK * N) {
            let (rows, rest) = items.as_chunks::<N>();
            add_parts(
                sums.each_mut(),
                at_once(
                    #[inline(always)]
                    || all_columns(rows.iter().map(&of)),
                ),
                rows.iter().map(&of),
            );
            if !rest.is_empty() {
                let mut last = [T::default(); N];
                last[..rest.len()].copy_from_slice(rest);
                sums.iter_mut().zip(of(&last)).for_each(|(sum, x)| sum.add(x));
            }
        }
        sums
    };
    if items.len() <= CHUNK {
        piece(items)
    } else {
        work_sharing::map(items.chunks(CHUNK), piece).into_iter().fold(none(), merged)
    }
}

/// Number of rows that are collected for each group before they are added as one block.
const WAITING: usize = 32;

/// Exact sums of the K columns of rows of numbers, computed for each of several groups of rows, such as slices of the
/// box. A group without rows takes hardly any memory.
pub struct Groups<const K: usize>(Vec<Option<Box<GroupSums<K>>>>);

/// Exact sums of one group of rows, and the rows of the group that are not yet added to the sums.
struct GroupSums<const K: usize> {
    sums: [ExactSum; K],
    waiting: [[f64; K]; WAITING],
    count: usize,
}

impl<const K: usize> GroupSums<K> {
    /// Makes the sums of a group without rows. Most calls of [`Groups::add`] find sums that exist already, so the
    /// compiler keeps this function out of their code.
    #[cold]
    fn boxed() -> Box<Self> {
        Box::new(Self { sums: none(), waiting: [[0.0; K]; WAITING], count: 0 })
    }

    #[inline]
    fn add(&mut self, row: [f64; K]) {
        self.waiting[self.count] = row;
        self.count += 1;
        if self.count == WAITING {
            self.take_in();
        }
    }

    /// Adds the rows that are waiting to the sums of the group.
    #[inline(never)]
    fn take_in(&mut self) {
        add_block(self.sums.each_mut(), &self.waiting[..self.count]);
        self.count = 0;
    }
}

impl<const K: usize> Groups<K> {
    /// Makes exact sums for `groups` groups without rows.
    pub fn new(groups: usize) -> Self {
        Self((0..groups).map(|_| None).collect())
    }

    /// Adds a row to the sums of the group with the index `group`.
    #[inline]
    pub fn add(&mut self, group: usize, row: [f64; K]) {
        self.0[group].get_or_insert_with(GroupSums::boxed).add(row);
    }

    /// Adds the sums of each group in `others` to the sums of the group with the same index.
    fn merge(&mut self, others: Self) {
        for (own, other) in self.0.iter_mut().zip(others.0) {
            let Some(mut other) = other else { continue };
            match own {
                Some(own) => {
                    other.take_in();
                    own.sums.iter_mut().zip(&other.sums).for_each(|(sum, other)| sum.merge(other));
                }
                None => *own = Some(other),
            }
        }
    }

    /// Exact sums of all groups as one list: the K sums of group 0, then those of group 1, and so on.
    pub fn each_mut(&mut self) -> Vec<&mut ExactSum> {
        let groups = self.0.iter_mut().map(|group| group.get_or_insert_with(GroupSums::boxed));
        groups
            .flat_map(|group| {
                group.take_in();
                &mut group.sums
            })
            .collect()
    }

    /// For each group, the values of its K sums, each rounded to the nearest `f64`; 0 for a group without rows.
    pub fn values(self) -> Vec<[f64; K]> {
        let of = |group: Option<Box<GroupSums<K>>>| {
            group.map_or([0.0; K], |mut group| {
                group.take_in();
                values(&group.sums)
            })
        };
        self.0.into_iter().map(of).collect()
    }
}

/// Computes exact sums of rows in groups, on all threads. There are `groups` groups. For each index below `count`, `of`
/// returns the number of a group and a row to be added to that group.
pub fn sums_in_groups<const K: usize>(
    groups: usize,
    count: usize,
    of: impl Fn(usize) -> (usize, [f64; K]) + Sync,
) -> Groups<K> {
    let piece = |first: usize, last: usize| {
        let mut sums = Groups::new(groups);
        for k in first..last {
            let (group, row) = of(k);
            sums.add(group, row);
        }
        sums
    };
    // few pieces of work, since each piece has separate sums of all groups
    let pieces = count.div_ceil(CHUNK).clamp(1, 2 * rayon::current_num_threads());
    let start = |k: usize| count * k / pieces;
    let parts: Vec<_> = work_sharing::map(0..pieces, |k| piece(start(k), start(k + 1)));
    let mut parts = parts.into_iter();
    let mut all = parts.next().unwrap_or_else(|| Groups::new(groups));
    parts.for_each(|part| all.merge(part));
    all
}
