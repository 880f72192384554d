//! A uniform grid of cells, and the particles sorted into it.

use crate::domain::Domain;
use crate::particles::Particles;
use nalgebra::Vector3;
use std::ops::Range;

/// Cells over the domain, x fastest; `start[c] .. start[c + 1]` are the places of the particles of cell `c`, once the
/// store is in cell order.
#[derive(Clone, Debug, Default)]
pub struct CellGrid {
    count: [usize; 3],
    periodic: [bool; 3],
    start: Vec<u32>,
}

impl CellGrid {
    /// Wraps all positions into the box and puts the store in cell order; cells have edges of at least `edge` [m].
    /// Returns the new order: the particle now at place `k` stood at `order[k]`.
    pub fn sort(particles: &mut Particles, domain: &Domain, edge: f64) -> (Self, Vec<u32>) {
        let count: [usize; 3] = std::array::from_fn(|axis| {
            // the cap keeps the grid smaller than the store, however empty the box
            let fitting = (domain.size[axis] / edge).clamp(1.0, 4096.0) as usize;
            // with two periodic cells each would be the other's neighbour twice
            if domain.periodic[axis] && fitting < 3 { 1 } else { fitting }
        });
        let per_length = Vector3::from_fn(|axis, _| count[axis] as f64 / domain.size[axis]);
        let cell_of = |x: &Vector3<f64>| {
            // outside an open side the nearest cell takes it: clamping never parts neighbours
            let c: [usize; 3] =
                std::array::from_fn(|axis| ((x[axis] * per_length[axis]) as usize).min(count[axis] - 1));
            c[0] + count[0] * (c[1] + count[1] * c[2])
        };
        let mut start = vec![0u32; count[0] * count[1] * count[2] + 1];
        let cell: Vec<u32> = particles
            .position
            .iter_mut()
            .map(|x| {
                *x = domain.wrap(x);
                let c = cell_of(x);
                start[c + 1] += 1;
                c as u32
            })
            .collect();
        for c in 1..start.len() {
            start[c] += start[c - 1];
        }
        let mut next = start.clone();
        let mut order = vec![0u32; particles.len()];
        for (place, &c) in cell.iter().enumerate() {
            order[next[c as usize] as usize] = place as u32;
            next[c as usize] += 1;
        }
        particles.reorder(&order);
        (Self { count, periodic: domain.periodic, start }, order)
    }

    /// Rows of cells along x.
    pub fn rows(&self) -> usize {
        self.count[1] * self.count[2]
    }

    /// Calls `visit(i, others)` for every particle of a row with the ranges of places that may hold a neighbour, so that
    /// over all rows each pair of neighbouring cells is seen once.
    pub fn for_each_in_row(&self, row: usize, mut visit: impl FnMut(usize, Range<usize>)) {
        let [nx, ny, _] = self.count;
        let (cy, cz) = (row % ny, row / ny);
        // half of the rows around: the other half sees this one
        let mut ahead = [0usize; 4];
        let mut rows_ahead = 0;
        for (dy, dz) in [(1, 0), (-1, 1), (0, 1), (1, 1)] {
            if let (Some(y), Some(z)) = (self.shifted(1, cy, dy), self.shifted(2, cz, dz)) {
                ahead[rows_ahead] = nx * (y + ny * z);
                rows_ahead += 1;
            }
        }
        let base = nx * row;
        for cx in 0..nx {
            let own = self.places(base + cx, base + cx);
            if own.is_empty() {
                continue;
            }
            let last = (cx + 1).min(nx - 1);
            let first = cx.saturating_sub(1);
            let wraps = self.periodic[0] && nx > 1;
            for i in own {
                visit(i, i + 1..self.start[base + last + 1] as usize);
                if wraps && cx + 1 == nx {
                    visit(i, self.places(base, base));
                }
                for &other in &ahead[..rows_ahead] {
                    visit(i, self.places(other + first, other + last));
                    if wraps && cx == 0 {
                        visit(i, self.places(other + nx - 1, other + nx - 1));
                    }
                    if wraps && cx + 1 == nx {
                        visit(i, self.places(other, other));
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
