//! A uniform grid of cells, and items sorted into the cells by their positions.

use super::region::Region;
use crate::particles::CHUNK;
use crate::work_sharing;
use nalgebra::Vector3;
use std::ops::Range;

/// Grid of cells over a region. Cells are numbered along x first, then along y and z. The *cell order* lists the items
/// cell by cell: the items of cell c are at `start[c] .. start[c + 1]`.
#[derive(Clone, Debug, Default)]
pub struct CellGrid {
    region: Region,
    count: [usize; 3],
    periodic: [bool; 3],
    /// [1/m] number of cells per length along each axis.
    per_length: Vector3<f64>,
    start: Vec<u32>,
    /// For each item, the index of its cell, used while items are sorted. The list is stored in the grid so that its
    /// memory is used again.
    cell: Vec<u32>,
}

impl CellGrid {
    /// Numbers of cells along the axes of a region, for cells with edges of at least `edge` [m].
    fn fitting(region: &Region, edge: f64) -> [usize; 3] {
        std::array::from_fn(|axis| {
            // at most 4096 cells per axis, to limit the number of cells in a nearly empty box
            let fitting = (region.size()[axis] / edge).clamp(1.0, 4096.0) as usize;
            // with two cells along a periodic axis, each cell would be the neighbour of the other on both sides
            if region.periodic()[axis] && fitting < 3 { 1 } else { fitting }
        })
    }

    /// Divides a region into the given numbers of cells along the axes.
    fn divide(&mut self, region: &Region, count: [usize; 3]) {
        self.region = region.clone();
        self.periodic = region.periodic();
        self.count = count;
        self.per_length = Vector3::from_fn(|axis, _| self.count[axis] as f64 / region.size()[axis]);
    }

    /// Sorts items into cells with edges of at least `edge` [m]. All items must be inside the region. `position`
    /// returns the position [m] of an item. The indices of the items are written to `order` cell by cell (the cell
    /// order).
    pub fn sort<T: Sync>(
        &mut self,
        items: &[T],
        position: impl Fn(&T) -> Vector3<f64> + Sync,
        region: &Region,
        edge: f64,
        order: &mut Vec<u32>,
    ) {
        self.sort_among(items, position, region, Self::fitting(region, edge), order);
    }

    /// Sorts items into cells as [`sort`](Self::sort) does, with the given numbers of cells along the three axes.
    pub fn sort_among<T: Sync>(
        &mut self,
        items: &[T],
        position: impl Fn(&T) -> Vector3<f64> + Sync,
        region: &Region,
        count: [usize; 3],
        order: &mut Vec<u32>,
    ) {
        self.divide(region, count);
        let mut cell = std::mem::take(&mut self.cell);
        cell.resize(items.len(), 0);
        let spans: Vec<[u32; 2]> =
            work_sharing::map(cell.chunks_mut(CHUNK).zip(items.chunks(CHUNK)), |(cells, items)| {
                let mut span = [u32::MAX, 0];
                for (cell, item) in cells.iter_mut().zip(items) {
                    *cell = self.cell_of(&position(item)) as u32;
                    span = [span[0].min(*cell), span[1].max(*cell)];
                }
                span
            });
        let count = self.count.iter().product::<usize>();
        self.start.resize(count + 1, 0);
        order.resize(items.len(), 0);
        // Each thread sorts the items of some of the cells. It reads only the chunks that contain such items, which are
        // few if the items are nearly in cell order already.
        let shares = rayon::current_num_threads().min(items.len() / CHUNK).max(1);
        let width = count.div_ceil(shares);
        let chunks = |share: usize| {
            let [first, end] = [share * width, (share + 1) * width];
            let chunks = cell.chunks(CHUNK).zip(&spans).enumerate();
            chunks.filter(move |(_, (_, span))| (span[0] as usize) < end && first <= span[1] as usize)
        };
        let (starts, last) = self.start.split_at_mut(count);
        let counted: Vec<usize> = work_sharing::map(starts.chunks_mut(width).enumerate(), |(share, counts)| {
            let mut here = 0;
            counts.fill(0);
            for &c in chunks(share).flat_map(|(_, (cells, _))| cells) {
                if let Some(count) = counts.get_mut((c as usize).wrapping_sub(share * width)) {
                    *count += 1;
                    here += 1;
                }
            }
            here
        });
        let mut rest = order.as_mut_slice();
        let shares: Vec<&mut [u32]> = counted.iter().filter_map(|&here| rest.split_off_mut(..here)).collect();
        let firsts = counted.iter().scan(0, |before, &here| Some(std::mem::replace(before, *before + here)));
        let firsts: Vec<usize> = firsts.collect();
        work_sharing::for_each(starts.chunks_mut(width).zip(shares).enumerate(), |(share, (starts, order))| {
            let first = firsts[share];
            let mut before = first as u32;
            for count in starts.iter_mut() {
                before += *count;
                *count = before;
            }
            // the loop runs in reverse, so that the items of a cell stay in their order; afterwards `start[c]` is the
            // place of the first item of cell c
            for (chunk, (cells, _)) in chunks(share).rev() {
                for (k, &c) in cells.iter().enumerate().rev() {
                    if let Some(start) = starts.get_mut((c as usize).wrapping_sub(share * width)) {
                        *start -= 1;
                        order[*start as usize - first] = (chunk * CHUNK + k) as u32;
                    }
                }
            }
        });
        last[0] = items.len() as u32;
        self.cell = cell;
    }

    /// Frees the memory that is used while items are sorted. The sorted grid stays usable.
    pub fn shed(&mut self) {
        self.cell = Vec::new();
    }

    /// Makes a grid, and sorts positions inside a region into its cells as [`sort`](Self::sort) does. Returns the grid,
    /// and the indices of the positions in cell order.
    pub fn new(positions: &[Vector3<f64>], region: &Region, edge: f64) -> (Self, Vec<u32>) {
        let (mut grid, mut order) = (Self::default(), Vec::new());
        grid.sort(positions, |x| *x, region, edge, &mut order);
        (grid, order)
    }

    /// Index of the cell that contains the position `x` [m]. A position beyond a side that is not periodic belongs to
    /// the nearest cell, so that neighbours are still in neighbouring cells.
    #[inline]
    fn cell_of(&self, x: &Vector3<f64>) -> usize {
        let x = if self.region.is_all() { *x } else { self.region.local(x) };
        // the conversion goes through u32, because processors convert to u32 in one instruction, but not to usize
        let c: [usize; 3] =
            std::array::from_fn(|axis| ((x[axis] * self.per_length[axis]) as u32 as usize).min(self.count[axis] - 1));
        c[0] + self.count[0] * (c[1] + self.count[1] * c[2])
    }

    /// Calls `visit` with ranges of the cell order (the list of all items, cell by cell). Together the ranges contain
    /// all items within `radius` [m] of `x` [m], each item once. The flag passed to `visit` is true if periodic images
    /// of items in the range may be nearer than the items themselves.
    #[inline(always)]
    pub fn for_each_near(&self, x: &Vector3<f64>, radius: f64, mut visit: impl FnMut(Range<usize>, bool)) {
        let x = self.region.local(x);
        let [cells, rows, layers] = std::array::from_fn(|axis| self.span(axis, x[axis] - radius, x[axis] + radius));
        let [nx, ny, nz] = self.count.map(|n| n as isize);
        let all = [&cells, &rows, &layers].iter().any(|span| span.is_round);
        let (first, last) = (cells.first, cells.last);
        // a row of cells that leaves the box continues at the opposite side
        let runs = [(first + nx, last.min(-1) + nx), (first.max(0), last.min(nx - 1)), (first.max(nx) - nx, last - nx)];
        let used = usize::from(first >= 0)..2 + usize::from(last >= nx);
        for z in layers.first..=layers.last {
            let (layer, beyond) = turned(z, nz);
            for y in rows.first..=rows.last {
                let (row, aside) = turned(y, ny);
                let (base, across) = ((nx * (row + ny * layer)) as usize, all || beyond || aside);
                for k in used.clone() {
                    let (from, to) = runs[k];
                    if from <= to {
                        visit(self.indices(base + from as usize, base + to as usize), across || k != 1);
                    }
                }
            }
        }
    }

    /// Cells along the axis `axis` from the coordinate `from` [m] to the coordinate `to` [m].
    #[inline]
    fn span(&self, axis: usize, from: f64, to: f64) -> AxisCells {
        let n = self.count[axis] as isize;
        let [low, high] = [from, to].map(|x| below(x * self.per_length[axis]));
        if !self.periodic[axis] {
            AxisCells { first: low.clamp(0, n - 1), last: high.clamp(0, n - 1), is_round: false }
        } else if high - low + 1 >= n {
            AxisCells { first: 0, last: n - 1, is_round: true }
        } else {
            let first = if low < -n || low >= n { low.rem_euclid(n) } else { low };
            AxisCells { first, last: first + high - low, is_round: false }
        }
    }

    /// Calls `visit` once for each cell, with the part of `order` that belongs to the cell. `order` must contain the
    /// items in cell order (cell by cell).
    pub fn for_each_cell_of<T: Send>(&self, mut order: &mut [T], visit: impl Fn(&mut [T]) + Sync) {
        let cells: Vec<u32> = self.start.windows(2).map(|ends| ends[1] - ends[0]).collect();
        let piece = |cells: &'_ [u32]| order.split_off_mut(..cells.iter().sum::<u32>() as usize).unwrap_or_default();
        let pieces: Vec<&mut [T]> = cells.chunks(CHUNK).map(piece).collect();
        work_sharing::for_each(pieces.into_iter().zip(cells.chunks(CHUNK)), |(mut piece, cells)| {
            let some = |&count: &u32| piece.split_off_mut(..count as usize).unwrap_or_default();
            cells.iter().map(some).for_each(&visit);
        });
    }

    /// Range of the items of the cell number `cell` in the cell order, the list of all items, cell by cell.
    #[inline]
    pub fn items_of(&self, cell: usize) -> Range<usize> {
        self.indices(cell, cell)
    }

    /// Number of rows in the grid; the cells of a row have equal y and z.
    pub fn rows(&self) -> usize {
        self.count[1] * self.count[2]
    }

    /// Calls `visit(own, around, across)` for every non-empty cell of a row of cells along x. `own` is the range of
    /// the cell's items in the cell order (the list of all items, cell by cell). `around` contains the ranges of
    /// possible neighbours; the first begins at the end of `own`. If all rows are visited, each pair of neighbouring
    /// cells occurs once. `across` is true if the periodic image of a neighbour may be nearer than the neighbour
    /// itself.
    #[inline(always)]
    pub fn for_each_cell(&self, row: usize, mut visit: impl FnMut(Range<usize>, &mut Around, bool)) {
        let [nx, ny, _] = self.count;
        let (cy, cz) = (row % ny, row / ny);
        // only half of the neighbouring rows are visited; their pairs with the other half are found when that half is
        // visited
        let ahead = [(1isize, 0isize), (-1, 1), (0, 1), (1, 1)]
            .map(|(dy, dz)| Some(nx * (self.shifted(1, cy, dy)? + ny * self.shifted(2, cz, dz)?)));
        let base = nx * row;
        let turns = self.periodic[0] && nx > 1;
        let at_side = self.is_at_side(1, cy) || self.is_at_side(2, cz);
        for cx in 0..nx {
            let own = self.indices(base + cx, base + cx);
            if own.is_empty() {
                continue;
            }
            let (first, last) = (cx.saturating_sub(1), (cx + 1).min(nx - 1));
            let mut around = Around { first: [0; RANGES], end: [0; RANGES], count: 0 };
            around.add(own.end..self.start[base + last + 1] as usize);
            if turns && cx + 1 == nx {
                around.add(self.indices(base, base));
            }
            for &other in ahead.iter().flatten() {
                around.add(self.indices(other + first, other + last));
                if turns && cx == 0 {
                    around.add(self.indices(other + nx - 1, other + nx - 1));
                }
                if turns && cx + 1 == nx {
                    around.add(self.indices(other, other));
                }
            }
            visit(own, &mut around, at_side || self.is_at_side(0, cx));
        }
    }

    /// True if the cells with the number `at` along an axis are next to a periodic side.
    fn is_at_side(&self, axis: usize, at: usize) -> bool {
        self.periodic[axis] && (at == 0 || at + 1 == self.count[axis])
    }

    /// Number, along `axis`, of the cell `step` cells after the cell `from`. `None` beyond a side that is not periodic,
    /// or if the axis has only one cell.
    fn shifted(&self, axis: usize, from: usize, step: isize) -> Option<usize> {
        if step == 0 {
            return Some(from);
        }
        let n = self.count[axis] as isize;
        let to = from as isize + step;
        if (0..n).contains(&to) {
            Some(to as usize)
        } else if self.periodic[axis] && n > 1 {
            Some(to.rem_euclid(n) as usize)
        } else {
            None
        }
    }

    /// Range, in the cell order (the list of all items, cell by cell), of the items of the cells `first ..= last` of a
    /// row.
    fn indices(&self, first: usize, last: usize) -> Range<usize> {
        self.start[first] as usize..self.start[last + 1] as usize
    }
}

/// Largest number of ranges of items around a cell: one in its own row, four in other rows, and five more beyond a
/// periodic side.
const RANGES: usize = 10;

/// Ranges of the cell order (the list of all items, cell by cell) that contain the possible neighbours of an item.
pub struct Around {
    first: [usize; RANGES],
    end: [usize; RANGES],
    count: usize,
}

impl Around {
    #[inline(always)]
    fn add(&mut self, range: Range<usize>) {
        (self.first[self.count], self.end[self.count]) = (range.start, range.end);
        self.count += 1;
    }

    /// Lets the first range begin at the index `first`, directly after the current item of the cell. The search then
    /// finds each pair within a cell once.
    #[inline(always)]
    pub fn begin_at(&mut self, first: usize) {
        self.first[0] = first;
    }

    /// All ranges of the cell order (the list of all items, cell by cell) that contain possible neighbours.
    #[inline(always)]
    pub fn ranges(&self) -> impl Iterator<Item = Range<usize>> {
        self.first.iter().zip(&self.end).take(self.count).map(|(&first, &end)| first..end)
    }
}

/// Cells between two coordinates on an axis, given by their numbers along this axis.
struct AxisCells {
    /// Numbers of the first and the last cell. Cells beyond a periodic side have numbers below 0 or above the largest
    /// number.
    first: isize,
    last: isize,
    /// True if all cells along a periodic axis are between the two coordinates.
    is_round: bool,
}

/// Largest integer that is at most `x`. This code is faster than `f64::floor`, which is a function call on processors
/// without SSE4.1.
#[inline]
fn below(x: f64) -> isize {
    let whole = x as isize;
    whole - isize::from(whole as f64 > x)
}

/// Number of the cell that is the periodic image of the cell `cell`, among the `n` cells along a periodic axis. The
/// cell `cell` is at most one period outside the box. The flag is true if `cell` is outside the box.
#[inline]
fn turned(cell: isize, n: isize) -> (isize, bool) {
    if cell < 0 {
        (cell + n, true)
    } else if cell >= n {
        (cell - n, true)
    } else {
        (cell, false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::Domain;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn items_stand_in_the_order_of_cells_and_of_their_places_whoever_sorts_them() {
        let domain = Domain::new(Vector3::new(10.0, 8.0, 9.0), [true, false, true]);
        let region = Region::from(&domain);
        let mut random = Xoshiro256PlusPlus::seed_from_u64(2);
        let mut anywhere = || domain.size.map(|length| length * random.random_range(0.0..1.0));
        let mut items: Vec<Vector3<f64>> = (0..5 * CHUNK + 17).map(|_| anywhere()).collect();
        // the items are first in random order, then in cell order except for two items in opposite halves of the grid
        for _ in 0..2 {
            let sort = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                // reuses the grid for other cells
                let (mut grid, mut order) = CellGrid::new(&items[..100], &region, 1.0);
                pool.install(|| grid.sort(&items, |x| *x, &region, 0.5, &mut order));
                (grid, order)
            };
            let (grid, order) = sort(1);
            let mut want: Vec<u32> = (0..items.len() as u32).collect();
            want.sort_by_key(|&index| grid.cell_of(&items[index as usize]));
            assert_eq!(order, want);
            for threads in [2, 3, 8] {
                let (other, again) = sort(threads);
                assert!(again == order && other.start == grid.start, "{threads} threads");
            }
            let (mut cells, mut found) = (order.clone(), std::sync::Mutex::new(0));
            grid.for_each_cell_of(&mut cells, |indices| {
                let cell = |index: &u32| grid.cell_of(&items[*index as usize]);
                assert!(indices.windows(2).all(|two| cell(&two[0]) == cell(&two[1])));
                *found.lock().unwrap() += indices.len();
            });
            assert_eq!(*found.get_mut().unwrap(), items.len());
            items = order.iter().map(|&index| items[index as usize]).collect();
            let half = (grid.start.len() - 1).div_ceil(2);
            items.swap(10, grid.start[half] as usize);
            items.swap(4 * CHUNK, grid.start[half] as usize - 1);
        }
    }
}
