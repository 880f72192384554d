//! Grid of cells that holds the centres of all shells. A shell is a ball around a particle. As long as the particle
//! stays in its shell, the neighbour list of the particle remains valid.

use crate::domain::Domain;
use nalgebra::Vector3;
use std::sync::atomic::{AtomicU32, Ordering};

/// [-] bound on the rounding error of lengths in single precision (such as coordinates and edges of the box), divided
/// by the longest edge of the box.
pub const ROUNDING: f64 = 1e-6;

/// Grid of cells with the centres of shells (balls in which neighbour lists are valid). Each cell has a linked list of
/// centres, so one centre can change its cell while all others stay where they are. Several threads may move centres at
/// the same time, if no two of them use the same cell ([`Territories`](super::territories::Territories)).
#[derive(Clone, Debug, Default)]
pub struct ShellGrid {
    count: [usize; 3],
    periodic: [bool; 3],
    /// [1/m] number of cells per length, along each axis.
    per_length: Vector3<f64>,
    /// [m] edges of a cell along the three axes.
    edge: [f32; 3],
    /// [m] edges of the box along the three axes (`period`), and half of them (`half`). A value of `half` is infinite
    /// along axes that are not periodic, so that no images are looked for there.
    period: [f32; 3],
    half: [f32; 3],
    /// [m] bound on the rounding error of distances, which are computed in single precision.
    rounding: f32,
    /// Start of the linked list of particles in each cell: the index of the first particle plus one, or 0 if the cell
    /// is empty.
    first: Vec<AtomicNumber>,
    /// Centre of the shell (ball in which the neighbour list is valid) of each particle, with its place in the linked
    /// list of its cell, by particle index.
    spots: Vec<CellEntry>,
}

/// Number that several threads may read and write. The number does not order other memory accesses. No such order is
/// needed, because no two threads use the same number at the same time.
#[derive(Debug, Default)]
struct AtomicNumber(AtomicU32);

impl AtomicNumber {
    #[inline(always)]
    fn get(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }

    #[inline(always)]
    fn set(&self, number: u32) {
        self.0.store(number, Ordering::Relaxed);
    }
}

impl Clone for AtomicNumber {
    fn clone(&self) -> Self {
        Self(AtomicU32::new(self.get()))
    }
}

/// Centre of a particle's shell (ball in which its neighbour list is valid), and link to the next centre in the same
/// cell.
#[derive(Clone, Debug, Default)]
struct CellEntry {
    /// [m] coordinates of the centre, as the bits of numbers in single precision.
    centre: [AtomicNumber; 3],
    /// Index of the particle with the next centre in the cell, plus one; 0 at the end of the list.
    next: AtomicNumber,
}

impl CellEntry {
    #[inline(always)]
    fn coordinate(&self, axis: usize) -> f32 {
        f32::from_bits(self.centre[axis].get())
    }

    #[inline]
    fn set_centre(&self, centre: [f32; 3]) {
        for (number, coordinate) in self.centre.iter().zip(centre) {
            number.set(coordinate.to_bits());
        }
    }
}

/// Rounds the coordinates of a point [m] to single precision.
pub fn rounded(x: &Vector3<f64>) -> [f32; 3] {
    [x.x as f32, x.y as f32, x.z as f32]
}

/// Converts the coordinates of a point [m] from single to double precision.
#[inline]
pub fn widened(x: &[f32; 3]) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| f64::from(x[axis]))
}

impl ShellGrid {
    /// Makes a grid without centres for the given number of particles. The edges of its cells are at least `edge` [m]
    /// long, unless the box itself is shorter.
    pub fn new(domain: &Domain, edge: f64, particles: usize) -> Self {
        // limits the number of cells by the number of particles, even in a nearly empty box
        let most = (particles as f64).cbrt().ceil() + 3.0;
        let longest = (domain.volume().cbrt() / most).max(edge);
        let count = std::array::from_fn(|axis| {
            let fitting = (domain.size[axis] / longest).clamp(1.0, 4096.0) as usize;
            // with two cells along a periodic axis, each would be a neighbour of the other on both sides
            if domain.joined()[axis] && fitting < 3 { 1 } else { fitting }
        });
        Self {
            count,
            periodic: domain.joined(),
            per_length: Vector3::from_fn(|axis, _| count[axis] as f64 / domain.size[axis]),
            edge: std::array::from_fn(|axis| (domain.size[axis] / count[axis] as f64) as f32),
            period: std::array::from_fn(|axis| domain.size[axis] as f32),
            half: std::array::from_fn(|axis| {
                if domain.joined()[axis] { 0.5 * domain.size[axis] as f32 } else { f32::INFINITY }
            }),
            rounding: (ROUNDING * domain.size.max()) as f32,
            first: vec![AtomicNumber::default(); count[0] * count[1] * count[2]],
            spots: vec![CellEntry::default(); particles],
        }
    }

    /// Numbers, along the three axes, of the cell that contains a point [m]. A point beyond a side that is not periodic
    /// belongs to the nearest cell, so that neighbours remain in neighbouring cells.
    fn coordinates(&self, x: &Vector3<f64>) -> [usize; 3] {
        std::array::from_fn(|axis| ((x[axis] * self.per_length[axis]) as usize).min(self.count[axis] - 1))
    }

    /// Number of cells of the grid.
    pub fn cells(&self) -> usize {
        self.first.len()
    }

    /// Number of the cell that contains the point `centre` [m], the centre of a shell.
    #[inline]
    pub fn cell(&self, centre: &[f32; 3]) -> usize {
        let c = self.coordinates(&widened(centre));
        c[0] + self.count[0] * (c[1] + self.count[1] * c[2])
    }

    /// Adds the particle at `index` to the grid. `centre` [m] is the centre of its shell, the ball in which its
    /// neighbour list is valid.
    pub fn put(&self, index: u32, centre: [f32; 3]) {
        let (first, spot) = (&self.first[self.cell(&centre)], &self.spots[index as usize]);
        spot.set_centre(centre);
        spot.next.set(first.get());
        first.set(index + 1);
    }

    /// Moves the centre of the shell (ball in which the neighbour list is valid) of the particle at `index` from the
    /// point `old` [m] to the point `new` [m].
    pub fn change(&self, index: u32, old: [f32; 3], new: [f32; 3]) {
        let (from, to) = (self.cell(&old), self.cell(&new));
        if from == to {
            self.spots[index as usize].set_centre(new);
            return;
        }
        let mut link = &self.first[from];
        while link.get() != index + 1 {
            link = &self.spots[link.get() as usize - 1].next;
        }
        link.set(self.spots[index as usize].next.get());
        self.put(index, new);
    }

    /// Numbers of the cell `cell` and of its neighbouring cells. These are all the cells that [`near`](Self::near)
    /// searches around a point in `cell`.
    pub fn around(&self, cell: usize) -> impl Iterator<Item = usize> {
        let [nx, ny, _] = self.count;
        let at = [cell % nx, cell / nx % ny, cell / (nx * ny)];
        let [(xs, cx), (ys, cy), (zs, cz)] = std::array::from_fn(|axis| self.beside(axis, at[axis], 0.0));
        let columns = (0..cz).flat_map(move |k| (0..cy).map(move |j| ys[j].0 + ny * zs[k].0));
        columns.flat_map(move |column| (0..cx).map(move |i| xs[i].0 + nx * column))
    }

    /// Numbers, along one axis, of the cell `at` and its neighbours, and the count of these numbers (one to three).
    /// With each number comes the smallest distance [m], along the axis, from a given point in the cell `at` to the
    /// cell with this number. `from_side` [m] is the distance of the point from the lower side of the cell `at`.
    fn beside(&self, axis: usize, at: usize, from_side: f32) -> ([(usize, f32); 3], usize) {
        let n = self.count[axis];
        if n == 1 {
            return ([(0, 0.0); 3], 1);
        }
        let mut list = ([(at, 0.0); 3], 1);
        let mut put = |c: usize, distance: f32| {
            list.0[list.1] = (c, distance.max(0.0));
            list.1 += 1;
        };
        match at {
            0 if self.periodic[axis] => put(n - 1, from_side),
            0 => {}
            _ => put(at - 1, from_side),
        }
        let beyond = self.edge[axis] - from_side;
        match at + 1 {
            next if next < n => put(next, beyond),
            _ if self.periodic[axis] => put(0, beyond),
            _ => {}
        }
        list
    }

    /// Appends to `found` the indices of all particles whose shell (ball in which the neighbour list is valid) may have
    /// its centre within `reach` [m] of `centre`. Unlike [`near`](Self::near), the search looks at all cells within
    /// `reach`, which may exceed the edge of a cell. For large particles, the grid of small particles is searched in
    /// this way. Returns the number of centres checked.
    pub fn near_by_far(&self, centre: &Vector3<f64>, reach: f64, found: &mut Vec<u32>) -> u64 {
        let here = rounded(centre);
        let reach = reach as f32 + self.rounding;
        let farthest = f64::from(reach + self.rounding);
        let ranges: [(i64, i64); 3] = std::array::from_fn(|axis| {
            let n = self.count[axis] as i64;
            let cell = |x: f64| (x * self.per_length[axis]).floor() as i64;
            let (low, high) = (cell(centre[axis] - farthest), cell(centre[axis] + farthest));
            match self.periodic[axis] {
                true if high - low + 1 < n => (low, high),
                true => (0, n - 1),
                false => (low.clamp(0, n - 1), high.clamp(0, n - 1)),
            }
        });
        let mut checks = 0;
        let along = |axis: usize| {
            let n = self.count[axis] as i64;
            (ranges[axis].0..=ranges[axis].1).map(move |c| c.rem_euclid(n) as usize)
        };
        for z in along(2) {
            for y in along(1) {
                for x in along(0) {
                    checks += self.within(x + self.count[0] * (y + self.count[1] * z), here, reach * reach, found);
                }
            }
        }
        checks
    }

    /// Appends to `found` the indices of all particles whose shell (ball in which the neighbour list is valid) may have
    /// its centre within `reach` [m] of `centre`. `reach` must not exceed the edge of a cell, since only neighbouring
    /// cells are searched. Returns the number of centres checked.
    pub fn near(&self, centre: &Vector3<f64>, reach: f64, found: &mut Vec<u32>) -> u64 {
        let at = self.coordinates(centre);
        let here = rounded(centre);
        let [(xs, nx), (ys, ny), (zs, nz)] =
            std::array::from_fn(|axis| self.beside(axis, at[axis], here[axis] - at[axis] as f32 * self.edge[axis]));
        let reach = reach as f32 + self.rounding;
        let square = reach * reach;
        // centres are assigned to cells by rounded positions, and the sides of cells are rounded too, so the limit is
        // increased
        let farthest = (reach + self.rounding) * (reach + self.rounding);
        let mut checks = 0;
        for &(z, z_apart) in &zs[..nz] {
            for &(y, y_apart) in &ys[..ny] {
                for &(x, x_apart) in &xs[..nx] {
                    if x_apart * x_apart + y_apart * y_apart + z_apart * z_apart > farthest {
                        continue;
                    }
                    checks += self.within(x + self.count[0] * (y + self.count[1] * z), here, square, found);
                }
            }
        }
        checks
    }

    /// Appends to `found` the indices of particles in the cell number `cell`: those whose shell (ball in which the
    /// neighbour list is valid) has its centre at most √`square` [m] from `here` [m]. Returns the number of centres in
    /// the cell. Every index is written at the end of `found`; if its centre is too far, the next index overwrites it.
    /// This avoids a branch, which the processor would often mispredict, since about half of the indices are kept.
    #[inline]
    fn within(&self, cell: usize, here: [f32; 3], square: f32, found: &mut Vec<u32>) -> u64 {
        let (mut end, mut checks, mut link) = (found.len(), 0, self.first[cell].get());
        while link != 0 {
            let index = link - 1;
            let spot = &self.spots[index as usize];
            let apart = |axis: usize| {
                let d = (spot.coordinate(axis) - here[axis]).abs();
                if d > self.half[axis] { self.period[axis] - d } else { d }
            };
            let [dx, dy, dz] = [apart(0), apart(1), apart(2)];
            found.truncate(end);
            found.push(index);
            end += usize::from(dx * dx + dy * dy + dz * dz <= square);
            checks += 1;
            link = spot.next.get();
        }
        found.truncate(end);
        checks
    }
}
