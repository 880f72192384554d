//! A uniform grid of cells, and positions sorted into it.

use crate::domain::Domain;
use crate::particles::CHUNK;
use nalgebra::Vector3;
use rayon::prelude::*;
use std::ops::Range;

/// Cells over the domain, x fastest; `start[c] .. start[c + 1]` is the range of the cell order that belongs to cell `c`.
#[derive(Clone, Debug, Default)]
pub struct CellGrid {
    count: [usize; 3],
    periodic: [bool; 3],
    /// [1/m] cells per length.
    per_length: Vector3<f64>,
    start: Vec<u32>,
}

impl CellGrid {
    /// Sorts positions inside the box into cells with edges of at least `edge` [m]. Returns the grid and the places in
    /// cell order.
    pub fn new(positions: &[Vector3<f64>], domain: &Domain, edge: f64) -> (Self, Vec<u32>) {
        let count: [usize; 3] = std::array::from_fn(|axis| {
            // the cap keeps the grid smaller than the store, however empty the box
            let fitting = (domain.size[axis] / edge).clamp(1.0, 4096.0) as usize;
            // with two periodic cells each would be the other's neighbour twice
            if domain.periodic[axis] && fitting < 3 { 1 } else { fitting }
        });
        let per_length = Vector3::from_fn(|axis, _| count[axis] as f64 / domain.size[axis]);
        let mut grid = Self { count, periodic: domain.periodic, per_length, start: Vec::new() };
        let mut cell = vec![0u32; positions.len()];
        let cells = cell.par_chunks_mut(CHUNK).zip(positions.par_chunks(CHUNK));
        cells.for_each(|(cells, positions)| {
            for (cell, x) in cells.iter_mut().zip(positions) {
                *cell = grid.cell_of(x) as u32;
            }
        });
        let mut start = vec![0u32; count[0] * count[1] * count[2] + 1];
        for &c in &cell {
            start[c as usize + 1] += 1;
        }
        for c in 1..start.len() {
            start[c] += start[c - 1];
        }
        let mut next = start.clone();
        let mut order = vec![0u32; positions.len()];
        for (place, &c) in cell.iter().enumerate() {
            order[next[c as usize] as usize] = place as u32;
            next[c as usize] += 1;
        }
        grid.start = start;
        (grid, order)
    }

    /// Outside an open side the nearest cell takes a position: clamping never parts neighbours.
    #[inline]
    fn cell_of(&self, x: &Vector3<f64>) -> usize {
        let c: [usize; 3] =
            std::array::from_fn(|axis| ((x[axis] * self.per_length[axis]) as usize).min(self.count[axis] - 1));
        c[0] + self.count[0] * (c[1] + self.count[1] * c[2])
    }

    /// Calls `visit` with ranges (of the cell order) that together hold all within `radius` [m] of `x`, each once.
    pub fn for_each_near(&self, x: &Vector3<f64>, radius: f64, mut visit: impl FnMut(Range<usize>)) {
        let span: [(isize, isize); 3] = std::array::from_fn(|axis| {
            let n = self.count[axis] as isize;
            let low = ((x[axis] - radius) * self.per_length[axis]).floor() as isize;
            let high = ((x[axis] + radius) * self.per_length[axis]).floor() as isize;
            if !self.periodic[axis] {
                (low.clamp(0, n - 1), high.clamp(0, n - 1))
            } else if high - low + 1 >= n {
                (0, n - 1)
            } else {
                (low, high)
            }
        });
        let [nx, ny, nz] = self.count.map(|n| n as isize);
        for z in span[2].0..=span[2].1 {
            for y in span[1].0..=span[1].1 {
                let base = (nx * (y.rem_euclid(ny) + ny * z.rem_euclid(nz))) as usize;
                let (low, high) = span[0];
                // a run of cells that leaves the box comes back at the other side
                for (from, to) in [(low, high.min(-1)), (low.max(0), high.min(nx - 1)), (low.max(nx), high)] {
                    if from <= to {
                        let (from, to) = (from.rem_euclid(nx) as usize, to.rem_euclid(nx) as usize);
                        visit(self.places(base + from, base + to));
                    }
                }
            }
        }
    }

    /// Rows of cells along x.
    pub fn rows(&self) -> usize {
        self.count[1] * self.count[2]
    }

    /// Calls `visit(k, others, wraps)` for every position of a row, in cell order, with the ranges that may hold a
    /// neighbour, so that over all rows each pair of neighbouring cells is seen once. Without `wraps` the nearest images of
    /// the two are the positions themselves.
    pub fn for_each_in_row(&self, row: usize, mut visit: impl FnMut(usize, Range<usize>, bool)) {
        let [nx, ny, nz] = self.count;
        let (cy, cz) = (row % ny, row / ny);
        // along an axis of one periodic cell everything is its own neighbour's image
        let single = (0..3).any(|axis| self.periodic[axis] && self.count[axis] == 1);
        // half of the rows around: the other half sees this one
        let mut ahead = [(0usize, false); 4];
        let mut rows_ahead = 0;
        for (dy, dz) in [(1isize, 0isize), (-1, 1), (0, 1), (1, 1)] {
            if let (Some(y), Some(z)) = (self.shifted(1, cy, dy), self.shifted(2, cz, dz)) {
                let wraps = y.abs_diff(cy) > 1 || z.abs_diff(cz) > 1;
                ahead[rows_ahead] = (nx * (y + ny * z), wraps || single);
                rows_ahead += 1;
            }
        }
        debug_assert!(row < ny * nz);
        let base = nx * row;
        for cx in 0..nx {
            let own = self.places(base + cx, base + cx);
            if own.is_empty() {
                continue;
            }
            let last = (cx + 1).min(nx - 1);
            let first = cx.saturating_sub(1);
            let around = self.periodic[0] && nx > 1;
            for k in own {
                visit(k, k + 1..self.start[base + last + 1] as usize, single);
                if around && cx + 1 == nx {
                    visit(k, self.places(base, base), true);
                }
                for &(other, wraps) in &ahead[..rows_ahead] {
                    visit(k, self.places(other + first, other + last), wraps);
                    if around && cx == 0 {
                        visit(k, self.places(other + nx - 1, other + nx - 1), true);
                    }
                    if around && cx + 1 == nx {
                        visit(k, self.places(other, other), true);
                    }
                }
            }
        }
    }

    /// The coordinate `step` cells on along `axis`, if there is a cell other than the one it starts from.
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

    /// Places of the particles of cells `first ..= last` of one row.
    fn places(&self, first: usize, last: usize) -> Range<usize> {
        self.start[first] as usize..self.start[last + 1] as usize
    }
}
