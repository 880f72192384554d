//! Local volume fraction of particles, in a grid of equal cells.
//!
//! The volume of a sphere is divided among cells. Along each axis, the share of a cell is the part of the sphere
//! between the two planes that bound the cell. A cell gets the product of its shares along the three axes. All
//! products add up to one. The division is exact if planes of only one axis cut the sphere. The volume fraction at a
//! particle is the mean over the cells that the particle overlaps, weighted with these products. So the volume
//! fraction at a particle changes continuously as particles move.
//!
//! Volumes are added as integers, so that sums do not depend on the order of the particles, on threads or on processes.

use crate::communicator::Communicator;
use crate::domain::Domain;
use crate::particles::{CHUNK, Particles};
use crate::work_sharing;
use nalgebra::Vector3;

/// Number of integer units in the volume of a cell. A sum of particle volumes up to 128 cell volumes fits into 64
/// bits. A particle with 1e-9 of the volume of a cell has 7e7 units, so its volume has seven digits.
const UNIT: f64 = (1_u64 << 56) as f64;

/// Volume fractions of particles in all cells of the box.
#[derive(Clone, Debug)]
pub struct LocalFractions {
    cells: [usize; 3],
    periodic: [bool; 3],
    /// [m] edge lengths of one cell along x, y and z.
    edges: Vector3<f64>,
    /// [-] volume fraction in each cell; the index along x varies fastest.
    values: Vec<f64>,
}

/// The two neighbouring cells between which a sphere is divided along one axis, each with its index along the axis and
/// its share [-] of the sphere's volume.
type Portions = [(usize, f64); 2];

impl LocalFractions {
    /// Computes the volume fractions of particles in a grid of equal cells. `cells` contains the numbers of cells
    /// along x, y and z. With a communicator, each process passes its own particles, and all processes receive the
    /// fractions due to all particles. A cell must be at least as wide as a sphere.
    pub fn of(
        particles: &Particles,
        domain: &Domain,
        cells: [u32; 3],
        communicator: Option<&dyn Communicator>,
    ) -> Self {
        let cells = cells.map(|count| count.max(1) as usize);
        let edges = Vector3::from_fn(|axis, _| domain.size[axis] / cells[axis] as f64);
        let mut fractions = Self { cells, periodic: domain.periodic, edges, values: Vec::new() };
        let volume = edges.product();
        let count = cells.iter().product();
        let positions = particles.position.chunks(CHUNK).zip(particles.radius.chunks(CHUNK));
        let pieces = work_sharing::map(positions, |(positions, radii)| {
            let mut sums = vec![0_i64; count];
            for (place, &radius) in positions.iter().zip(radii) {
                let share = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3) / volume * UNIT;
                fractions.for_each_cell(place, radius, |cell, weight| sums[cell] += (share * weight).round() as i64);
            }
            sums
        });
        let mut sums = vec![0_i64; count];
        for piece in pieces {
            sums.iter_mut().zip(piece).for_each(|(sum, more)| *sum += more);
        }
        if let Some(communicator) = communicator {
            communicator.sum(&mut sums);
        }
        fractions.values = sums.into_iter().map(|sum| sum as f64 / UNIT).collect();
        fractions
    }

    /// [-] volume fraction of all particles around a sphere with the centre `place` [m] and the radius `radius` [m]:
    /// the mean over the cells that contain parts of this sphere, weighted by these parts.
    pub fn at(&self, place: &Vector3<f64>, radius: f64) -> f64 {
        let mut fraction = 0.0;
        self.for_each_cell(place, radius, |cell, weight| fraction += weight * self.values[cell]);
        fraction
    }

    /// Calls `visit` for each cell among which a sphere is divided, with the index of the cell and the share [-] of the
    /// sphere's volume in it. `place` [m] is the centre of the sphere.
    #[inline]
    fn for_each_cell(&self, place: &Vector3<f64>, radius: f64, mut visit: impl FnMut(usize, f64)) {
        let [x, y, z] = [0, 1, 2].map(|axis| self.portions(axis, place[axis], radius));
        for (k, z) in z.into_iter().filter(|(_, share)| *share > 0.0) {
            for (j, y) in y.into_iter().filter(|(_, share)| *share > 0.0) {
                for (i, x) in x.into_iter().filter(|(_, share)| *share > 0.0) {
                    visit(i + self.cells[0] * (j + self.cells[1] * k), x * y * z);
                }
            }
        }
    }

    /// The two cells between which a sphere is divided along an axis (0 to 2), each with its share [-] of the sphere's
    /// volume. `x` [m] is the coordinate of the centre along this axis.
    #[inline]
    fn portions(&self, axis: usize, x: f64, radius: f64) -> Portions {
        let edge = self.edges[axis];
        let lower = ((x - radius) / edge).floor();
        // height of the spherical cap beyond the next plane
        let beyond = (x + radius - (lower + 1.0) * edge).clamp(0.0, 2.0 * radius);
        let cap = beyond * beyond * (3.0 * radius - beyond) / (4.0 * radius.powi(3));
        let index = |cell: f64| {
            let count = self.cells[axis] as f64;
            let cell = if self.periodic[axis] { cell.rem_euclid(count) } else { cell.clamp(0.0, count - 1.0) };
            (cell as usize).min(self.cells[axis] - 1)
        };
        [(index(lower), 1.0 - cap), (index(lower + 1.0), cap)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spheres(places: &[([f64; 3], f64)]) -> Particles {
        let mut particles = Particles::default();
        for (place, radius) in places {
            particles.push((*place).into(), Vector3::zeros(), *radius, 1.0, 0);
        }
        particles
    }

    #[test]
    fn a_sphere_is_divided_by_planes_and_across_periods() {
        let domain = Domain::new(Vector3::new(4.0, 2.0, 3.0), [true, false, true]);
        // a quarter of a diameter beyond the plane x = 2: the cap of height r/2 has 5/32 of the volume
        let one = spheres(&[([1.75, 1.0, 1.5], 0.5)]);
        let volume = std::f64::consts::PI / 6.0;
        let fractions = LocalFractions::of(&one, &domain, [2, 1, 1], None);
        for (value, share) in fractions.values.iter().zip([27.0 / 32.0, 5.0 / 32.0]) {
            assert!((value - share * volume / 12.0).abs() < 1e-15, "{value}");
        }
        let around = fractions.at(&one.position[0], 0.5);
        assert!((around - (27.0_f64.powi(2) + 25.0) / 1024.0 * volume / 12.0).abs() < 1e-15);
        // across the period along x and z, and in contact with a wall: no volume is lost
        let edge = spheres(&[([3.9, 0.5, 2.9], 0.5), ([-0.2, 1.5, 0.1], 0.5)]);
        for cells in [[1, 1, 1], [4, 2, 3], [2, 1, 3]] {
            let fractions = LocalFractions::of(&edge, &domain, cells, None);
            let mean = fractions.values.iter().sum::<f64>() / fractions.values.len() as f64;
            assert!((mean - 2.0 * volume / 24.0).abs() < 1e-15, "{cells:?}: {mean}");
        }
    }
}
