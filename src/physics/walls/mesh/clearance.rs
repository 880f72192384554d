//! Coarse grid around a mesh, which gives lower limits of the distance to the surface. For most particles the limit
//! alone shows that they do not touch the mesh.

use nalgebra::Vector3;
use std::collections::VecDeque;

/// Number of cells along the longest edge of the box around the mesh.
const CELLS: f64 = 64.0;

/// Grid of cells around a mesh. For each cell it contains the distance, in numbers of cells, from the nearest occupied
/// cell. A cell is occupied if the bounding box of a triangle overlaps it.
#[derive(Clone)]
pub struct Clearance {
    /// [m] lowest corner (`low`) and highest corner (`high`) of the box around the mesh.
    low: Vector3<f64>,
    high: Vector3<f64>,
    /// [m] edge length of the cubic cells of the grid.
    cell: f64,
    count: [usize; 3],
    away: Vec<u8>,
    /// True for each cell in which particles may be everywhere. False for each cell that a triangle may overlap, and
    /// for cells on the other side of the surface.
    is_free: Vec<bool>,
    /// True if particles may be in the space outside the box around the mesh.
    is_free_beyond: bool,
}

impl Clearance {
    /// Makes the grid around triangles, which are given by their corners [m].
    pub fn new(triangles: impl Iterator<Item = [Vector3<f64>; 3]> + Clone) -> Self {
        let corners = || triangles.clone().flatten();
        let low = corners().reduce(|a, b| a.inf(&b)).unwrap_or_default();
        let high = corners().reduce(|a, b| a.sup(&b)).unwrap_or_default();
        let cell = ((high - low).max() / CELLS).max(f64::MIN_POSITIVE);
        let count = std::array::from_fn(|axis| (((high - low)[axis] / cell).ceil() as usize).max(1));
        let cells = count[0] * count[1] * count[2];
        let (away, is_free) = (vec![u8::MAX; cells], vec![false; cells]);
        let mut grid = Self { low, high, cell, count, away, is_free, is_free_beyond: false };
        let mut queue = VecDeque::new();
        for triangle in triangles {
            let [a, b, c] = triangle;
            let (from, to) = (grid.cell_of(&a.inf(&b).inf(&c)), grid.cell_of(&a.sup(&b).sup(&c)));
            grid.for_each(from, to, |grid, cell, at| {
                if grid.away[at] != 0 {
                    grid.away[at] = 0;
                    queue.push_back(cell);
                }
            });
        }
        grid.spread(queue);
        grid
    }

    /// Computes the distances of all cells from the nearest occupied cell, in numbers of cells. The search goes
    /// outwards from the occupied cells, with which `queue` begins.
    fn spread(&mut self, mut queue: VecDeque<[usize; 3]>) {
        while let Some(cell) = queue.pop_front() {
            let next = self.away[self.index(cell)].saturating_add(1);
            let from = cell.map(|c| c.saturating_sub(1));
            let to = std::array::from_fn(|axis| (cell[axis] + 1).min(self.count[axis] - 1));
            self.for_each(from, to, |grid, near, at| {
                if grid.away[at] > next {
                    grid.away[at] = next;
                    queue.push_back(near);
                }
            });
        }
    }

    /// Finds the cells in which particles may be. `is_free` must return true for a point [m] where particles may be.
    /// The function is called with one point for each connected group of cells without triangles, so never with a
    /// point on the surface. `beyond` is true if particles may be outside the box around the mesh.
    pub fn find_free(&mut self, beyond: bool, is_free: impl Fn(&Vector3<f64>) -> bool) {
        self.is_free_beyond = beyond;
        let mut seen: Vec<bool> = self.away.iter().map(|away| *away == 0).collect();
        let mut connected = Vec::new();
        for at in 0..seen.len() {
            if seen[at] {
                continue;
            }
            let middle = Vector3::from(self.coordinates(at).map(|c| c as f64 + 0.5));
            let free = is_free(&(self.low + middle * self.cell));
            seen[at] = true;
            connected.push(at);
            while let Some(at) = connected.pop() {
                self.is_free[at] = free;
                for next in self.beside(at) {
                    if !std::mem::replace(&mut seen[next], true) {
                        connected.push(next);
                    }
                }
            }
        }
    }

    fn for_each(&mut self, from: [usize; 3], to: [usize; 3], mut visit: impl FnMut(&mut Self, [usize; 3], usize)) {
        for z in from[2]..=to[2] {
            for y in from[1]..=to[1] {
                for x in from[0]..=to[0] {
                    let cell = [x, y, z];
                    let at = self.index(cell);
                    visit(self, cell, at);
                }
            }
        }
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.count[1] + y) * self.count[0] + x
    }

    /// Indices of the grid cells that share a face with the cell at the index `at`.
    fn beside(&self, at: usize) -> impl Iterator<Item = usize> {
        let mut step = 1;
        let sides = self.coordinates(at).into_iter().zip(self.count).map(move |(c, count)| {
            let (below, above) = ((c > 0).then(|| at - step), (c + 1 < count).then(|| at + step));
            step *= count;
            below.into_iter().chain(above)
        });
        sides.flatten()
    }

    fn coordinates(&self, index: usize) -> [usize; 3] {
        let [nx, ny, _] = self.count;
        [index % nx, index / nx % ny, index / (nx * ny)]
    }

    /// Indices along x, y, z of the grid cell that contains `point` [m]; for a point outside the grid, those of the
    /// nearest cell.
    fn cell_of(&self, point: &Vector3<f64>) -> [usize; 3] {
        // a negative coordinate is converted to index 0
        std::array::from_fn(|axis| (((point[axis] - self.low[axis]) / self.cell) as usize).min(self.count[axis] - 1))
    }

    /// [m] lower limit of the distance from `point` [m] to the surface of the mesh.
    #[inline]
    pub fn least(&self, point: &Vector3<f64>) -> f64 {
        let outside = (self.low - point).sup(&(point - self.high)).max();
        if outside > 0.0 {
            return outside;
        }
        // in the worst case, the point and the surface lie on those sides of their cells that face each other
        let away = f64::from(self.away[self.index(self.cell_of(point))]);
        (away - 1.0 - 1e-9).max(0.0) * self.cell
    }

    /// True if particles may be at `point` [m]. Near the surface the result is always false, because the grid is too
    /// coarse to decide.
    pub fn is_free(&self, point: &Vector3<f64>) -> bool {
        if (self.low - point).sup(&(point - self.high)).max() > 0.0 {
            return self.is_free_beyond;
        }
        self.is_free[self.index(self.cell_of(point))]
    }

    /// [m] lowest and highest corner of the box around the mesh.
    pub fn bounds(&self) -> [Vector3<f64>; 2] {
        [self.low, self.high]
    }
}
