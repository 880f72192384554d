//! Cells in which pairs collide by chance: their number, the volume in which centres of particles can be, and local
//! volume fractions.

use super::DsmcSettings;
use crate::kinetic_theory::contact_value;
use crate::neighbours::cells::CellGrid;
use crate::neighbours::region::Region;
use crate::particles::Particles;
use crate::scene::Scene;
use crate::walls::NearWalls;
use crate::work_sharing;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// [-] longest edge of a cell, divided by the mean free path, if there are enough particles (Bird 1994, chapter 11).
const EDGE: f64 = 1.0 / 3.0;

/// Mean number of particles N in a cell whose edge h is a third of the mean free path λ (Bird 1994, chapter 11). After
/// a collision, the two particles collide with each other again before they leave the cell with a probability of about
/// h/(λ N). So cells with shorter edges may contain fewer particles at the same probability.
const PER_CELL: f64 = 20.0;

/// Smallest mean number of particles per cell that the program chooses; a cell with fewer than two has no pair.
const FEWEST: f64 = 2.0;

/// Number of cells between two walls at which no error of the mean flow was seen. In a pipe 1.6 mean free paths wide,
/// the granular temperature was 8 % too low with 5 cells, 1 % too low with 16, and right with 24
/// (docs/results/dsmc.md).
const ACROSS: f64 = 24.0;

/// Smallest mean number of particles in a block, a group of cells for which one volume fraction φ is computed. The
/// number N of particles in a block fluctuates. So the mean of N (N - 1) χ(φ), with the Enskog factor χ (collision rate
/// over that of a dilute gas), differs from its value at the mean N. The relative difference is (2 φ χ'/χ + φ² χ''/(2
/// χ))/N, where primes denote derivatives with respect to φ. With χ of Carnahan and Starling it is less than 0.01 up to
/// φ = 0.3.
const PER_BLOCK: f64 = 500.0;

/// [-] largest volume fraction at which the contact value (Enskog factor) is evaluated: no packing of equal spheres is
/// denser than 0.7405 (Kepler).
const DENSEST: f64 = 0.74;

/// Number of lattice points along each edge of a cell that a wall cuts. The open part of the cell is the fraction of
/// lattice points at which centres of particles can be. The error of this fraction is about a tenth.
const LATTICE: usize = 6;

/// Largest number of cells that the program chooses along an axis. This number limits the memory in a nearly empty box.
const MOST_CELLS: f64 = 1024.0;

/// Number of cells whose collisions a thread computes as one piece of work.
pub const PIECE: usize = 256;

/// Summary of the radii of all particles of a run, from which the sizes of cells follow.
#[derive(Clone, Copy, Debug)]
pub struct RadiusSummary {
    /// [m] smallest and largest radius of any particle.
    pub range: [f64; 2],
    /// [m] mean radius, and [m²] mean square of the radii.
    mean: [f64; 2],
    /// [m³] sum of the volumes of all particles.
    volume: f64,
    /// Number of particles of the run.
    count: usize,
}

impl RadiusSummary {
    /// Computes the summary of the radii of the given particles.
    pub fn of(particles: &Particles) -> Self {
        let radius = &particles.radius;
        let [mean, square, cube] = particles.mean_radii(1.0);
        Self {
            range: [radius.iter().fold(f64::INFINITY, |a, &r| a.min(r)), radius.iter().fold(0.0, |a, &r| a.max(r))],
            mean: [mean, square],
            volume: 4.0 / 3.0 * PI * cube * radius.len() as f64,
            count: radius.len(),
        }
    }

    /// Makes the summary of groups of equal particles, each given by the number of particles and their radius [m].
    pub fn among(groups: &[(usize, f64)]) -> Self {
        let count = groups.iter().map(|(number, _)| number).sum::<usize>();
        let mean = |power: i32| {
            let sum: f64 = groups.iter().map(|(number, radius)| *number as f64 * radius.powi(power)).sum();
            sum / count.max(1) as f64
        };
        let radii = || groups.iter().filter(|(number, _)| *number > 0).map(|(_, radius)| *radius);
        Self {
            range: [radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max)],
            mean: [mean(1), mean(2)],
            volume: 4.0 / 3.0 * PI * mean(3) * count as f64,
            count,
        }
    }

    /// True if the particles have different radii.
    pub fn are_mixed(&self) -> bool {
        self.range[0] < self.range[1]
    }

    /// [m] mean free path 1/(√2 n σ χ) of the particles if they fill a volume [m³] uniformly. n is the number density,
    /// and σ the mean cross-section of two particles. χ is the Enskog factor (collision rate over that of a dilute
    /// gas), or 1 if `enskog` is false. The path is infinite for a single particle.
    pub fn mean_free_path(&self, volume: f64, enskog: bool) -> f64 {
        let [mean, square] = self.mean;
        let filled = (self.volume / volume).min(DENSEST);
        // contact value of equal spheres, for which ξ_2 d = φ
        let factor = if enskog { contact_value(1.0, 1.0, filled, filled) } else { 1.0 };
        // the mean of (r_i + r_j)² is twice that of the squares plus twice the square of the mean
        let section = 2.0 * PI * (square + mean * mean);
        volume / (2.0_f64.sqrt() * self.count.saturating_sub(1) as f64 * section * factor)
    }
}

/// Crowding of the particles around a pair, from which the contact value (Enskog factor) of the pair follows.
#[derive(Clone, Copy, Debug, Default)]
pub struct Crowding {
    /// [-] volume fraction φ of the particles around the pair.
    pub fraction: f64,
    /// [1/m] ξ_2 = π/6 Σ n_i d_i², where n_i is the number density of particles with diameter d_i.
    pub second_moment: f64,
}

impl Crowding {
    /// [-] contact value of the pair distribution (Enskog factor) of two spheres with the radii `one` and `other` [m].
    #[inline]
    pub fn contact_value(&self, [one, other]: [f64; 2]) -> f64 {
        contact_value(2.0 * one, 2.0 * other, self.fraction, self.second_moment)
    }
}

/// Cells that divide the region in which centres of particles can be, with the particles in each cell.
#[derive(Debug)]
pub struct CollisionCells {
    grid: CellGrid,
    region: Region,
    /// Number of cells along each of the three axes.
    pub count: [usize; 3],
    /// Indices of all particles in the particle store, cell by cell. Within a cell they are in the order of the store.
    pub order: Vec<u32>,
    /// [m³] part of each cell's volume in which centres of the smallest particles can be.
    pub open: Vec<f64>,
    /// Number of blocks (groups of cells) along each axis. One volume fraction is computed for each block.
    blocks: [usize; 3],
    /// [-] volume open to whole spheres divided by the smaller volume open to their centres.
    shell: f64,
}

impl CollisionCells {
    /// Makes empty cells for particles of the sizes `sizes`. The numbers of cells along the axes are those in the
    /// settings, or are chosen from the scene and the sizes.
    pub fn new(scene: &Scene, sizes: &RadiusSummary, settings: &DsmcSettings) -> Self {
        let [low, high] = corners(scene, 0.0);
        // the radius is limited, so that a box narrower than its particles keeps some width
        let radius = sizes.range[0].min(0.25 * (high - low).min());
        let inner = corners(scene, radius);
        let region = Region::around(&scene.domain, inner, 0.0);
        let count = settings.cells.unwrap_or_else(|| numbers(scene, &region, sizes, settings.enskog));
        Self {
            grid: CellGrid::default(),
            order: Vec::new(),
            open: open_volumes(scene, [inner[0], region.size()], count, radius),
            blocks: blocks(&region, count, sizes.count),
            shell: (high - low).product() / region.volume(),
            region,
            count,
        }
    }

    /// [m] edges of a cell along the three axes.
    pub fn edges(&self) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| self.region.size()[axis] / self.count[axis] as f64)
    }

    /// Sorts the particles into the cells by their positions.
    pub fn sort(&mut self, particles: &Particles) {
        self.grid.sort_among(&particles.position, |x| *x, &self.region, self.count, &mut self.order);
    }

    /// Indices, in the particle store, of the particles in the cell number `cell`.
    #[inline]
    pub fn members(&self, cell: usize) -> &[u32] {
        &self.order[self.grid.items_of(cell)]
    }

    /// Computes the crowding (local volume fraction and second moment of the diameters) in each block of cells, in the
    /// order of the blocks. [`block_of`](Self::block_of) returns the number of a cell's block.
    pub fn crowding(&self, particles: &Particles, sizes: &RadiusSummary) -> Vec<Crowding> {
        let cells = self.open.len();
        let pieces = (0..cells.div_ceil(PIECE)).map(|piece| piece * PIECE..cells.min((piece + 1) * PIECE));
        // Σ r² and Σ r³ of each cell
        let of_cell = |cell: usize| {
            let members = self.members(cell);
            if sizes.are_mixed() {
                let radii = members.iter().map(|&index| particles.radius[index as usize]);
                radii.fold([0.0, 0.0], |[two, three], r| [two + r * r, three + r * r * r])
            } else {
                let r = sizes.range[1];
                [r * r, r * r * r].map(|power| members.len() as f64 * power)
            }
        };
        let sums =
            work_sharing::map(pieces.collect::<Vec<_>>().into_iter(), |piece| piece.map(of_cell).collect::<Vec<_>>());
        let mut of_blocks = vec![[0.0; 3]; self.blocks.iter().product()];
        for (cell, [two, three]) in sums.into_iter().flatten().enumerate() {
            let block = &mut of_blocks[self.block_of(cell)];
            *block = [block[0] + two, block[1] + three, block[2] + self.open[cell]];
        }
        let crowding = |[two, three, open]: [f64; 3]| {
            let volume = open * self.shell;
            // n d³ π/6 = 4π/3 n r³, n d² π/6 = 2π/3 n r²
            let fraction = (4.0 / 3.0 * PI * three / volume).min(DENSEST);
            Crowding { fraction, second_moment: 2.0 / 3.0 * PI * two / volume }
        };
        of_blocks.into_iter().map(crowding).collect()
    }

    /// Number of the block (group of cells) to which the cell number `cell` belongs.
    pub fn block_of(&self, cell: usize) -> usize {
        let [nx, ny, _] = self.count;
        let steps = [cell % nx, cell / nx % ny, cell / (nx * ny)];
        let [x, y, z] = std::array::from_fn(|axis| steps[axis] * self.blocks[axis] / self.count[axis]);
        x + self.blocks[0] * (y + self.blocks[1] * z)
    }
}

/// [m] lowest and highest corner of the room for particles: the part of the box that lies inside all vessels (walls
/// around all particles) and all planes perpendicular to an axis. The corners are moved inwards from these walls by the
/// distance `inwards` [m].
fn corners(scene: &Scene, inwards: f64) -> [Vector3<f64>; 2] {
    let inwards = Vector3::repeat(inwards);
    let rooms = scene.walls.iter().filter_map(|wall| wall.geometry.law().room_corners());
    rooms.fold([Vector3::zeros(), scene.domain.size], |[low, high], [from, to]| {
        [low.sup(&(from + inwards)), high.inf(&(to - inwards))]
    })
}

/// Numbers of cells along the three axes, for cells small compared with the mean free path that still contain enough
/// particles (docs/design/dsmc.md). If `enskog` is true, the mean free path is that of a dense gas with Enskog's
/// collision rate, otherwise that of a dilute gas.
fn numbers(scene: &Scene, region: &Region, sizes: &RadiusSummary, enskog: bool) -> [usize; 3] {
    let (size, periodic) = (region.size(), scene.domain.periodic);
    if sizes.count < 2 {
        return [1; 3];
    }
    let walled = periodic.iter().filter(|periodic| !**periodic).count() as i32;
    let third = EDGE * sizes.mean_free_path(region.volume(), enskog);
    let narrowest = (0..3).filter(|&axis| !periodic[axis]).map(|axis| size[axis]).fold(f64::INFINITY, f64::min);
    // flows vary from wall to wall, also where the mean free path is longer than the distance of the walls, so this
    // distance limits the edges too
    let thin = third.min((narrowest / ACROSS).max(2.0 * sizes.range[1]));
    let per_cell = if walled < 3 { (PER_CELL * thin / third).max(FEWEST) } else { PER_CELL };
    let wanted = per_cell * region.volume() / sizes.count as f64;
    let cube = wanted.cbrt();
    let mut edges = Vector3::repeat(cube);
    if cube > thin && walled > 0 && walled < 3 {
        let long = (wanted / thin.powi(walled)).powf(1.0 / f64::from(3 - walled));
        let along: f64 = (0..3).filter(|&axis| periodic[axis]).map(|axis| long.min(size[axis])).product();
        // a box that is short along its periodic axes has thicker cells
        let across = thin.max((wanted / along).powf(1.0 / f64::from(walled)));
        edges = Vector3::from_fn(|axis, _| if periodic[axis] { long } else { across });
    }
    std::array::from_fn(|axis| (size[axis] / edges[axis]).round().clamp(1.0, MOST_CELLS) as usize)
}

/// Numbers of blocks (groups of cells with one volume fraction) along the three axes. Blocks are enlarged along their
/// shortest edge until the mean number of particles in a block is large enough.
fn blocks(region: &Region, count: [usize; 3], particles: usize) -> [usize; 3] {
    let mut blocks = count;
    let edge = |blocks: &[usize; 3], axis: usize| region.size()[axis] / blocks[axis] as f64;
    while blocks.iter().product::<usize>() as f64 * PER_BLOCK > particles as f64 {
        let divided = (0..3).filter(|&axis| blocks[axis] > 1);
        let shortest = divided.min_by(|&a, &b| edge(&blocks, a).total_cmp(&edge(&blocks, b)));
        let Some(axis) = shortest else { break };
        blocks[axis] -= 1;
    }
    blocks
}

/// [m³] part of each cell's volume in which the centre of a sphere of `radius` [m] can be. The cells divide a box,
/// given by its lowest corner `low` and its edges `size` [m], into `count` parts along each axis.
fn open_volumes(scene: &Scene, [low, size]: [Vector3<f64>; 2], count: [usize; 3], radius: f64) -> Vec<f64> {
    let cells = count.iter().product::<usize>();
    let edges = Vector3::from_fn(|axis, _| size[axis] / count[axis] as f64);
    // flat walls perpendicular to an axis already limit the box of cells
    let cuts = |wall: &&crate::walls::Wall| !wall.geometry.is_flat() || wall.geometry.law().room_corners().is_none();
    if scene.walls.iter().filter(cuts).count() == 0 {
        return vec![edges.product(); cells];
    }
    let near = NearWalls::of(&scene.walls);
    let share = |cell: usize| {
        let steps = [cell % count[0], cell / count[0] % count[1], cell / (count[0] * count[1])];
        let corner = low + Vector3::from_fn(|axis, _| steps[axis] as f64 * edges[axis]);
        let (middle, reach) = (corner + edges * 0.5, radius + 0.5 * edges.norm());
        let mut walls = Vec::new();
        near.list(&middle, reach, &mut walls);
        walls.retain(|&wall| scene.walls[wall as usize].geometry.is_within(&middle, reach));
        if walls.is_empty() {
            return 1.0;
        }
        let is_open = |k: &usize| {
            let at = [k % LATTICE, k / LATTICE % LATTICE, k / (LATTICE * LATTICE)];
            let point = corner + Vector3::from_fn(|axis, _| (at[axis] as f64 + 0.5) / LATTICE as f64 * edges[axis]);
            walls.iter().all(|&wall| scene.walls[wall as usize].geometry.nearest(&point).distance >= radius)
        };
        let points = LATTICE.pow(3);
        // the volume must not be 0, since a particle may be in a corner without lattice points
        ((0..points).filter(is_open).count() as f64).max(0.5) / points as f64
    };
    let pieces: Vec<_> = (0..cells.div_ceil(PIECE)).map(|k| k * PIECE..cells.min((k + 1) * PIECE)).collect();
    let shares = work_sharing::map(pieces.into_iter(), |piece| piece.map(share).collect::<Vec<_>>());
    shares.into_iter().flatten().map(|share| share * edges.product()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::Domain;
    use crate::scene::Surface;
    use nalgebra::Vector3;

    /// Numbers of cells in a slit of `height` [m], 10 m long and wide, with 10,000 spheres of a diameter of 0.1 m.
    fn in_a_slit(height: f64) -> [usize; 3] {
        let domain = Domain::new(Vector3::new(10.0, height, 10.0), [true, false, true]);
        let scene = Scene::new(domain, Surface::new(1.0, 0.0), Vec::new());
        let mut particles = Particles::default();
        (0..10_000).for_each(|_| particles.push(Vector3::zeros(), Vector3::zeros(), 0.05, 1.0, 0));
        let region = Region::around(&scene.domain, [Vector3::zeros(), scene.domain.size], 0.0);
        numbers(&scene, &region, &RadiusSummary::of(&particles), false)
    }

    /// The mean free path of N spheres of diameter d in the volume V is V/(√2 N π d²): 2.25 m at a height of 10 m, and
    /// 4.5 m at 20 m. With a third of this path as the edge, there would be 13 cells between the walls in both cases.
    /// With 24 cells between the walls, a cell holds 20 particles times 13/24, the ratio of its edge to a third of this
    /// path.
    #[test]
    fn at_least_24_cells_lie_between_two_walls() {
        for height in [10.0, 20.0] {
            let [x, y, z] = in_a_slit(height);
            let in_a_cell = 1e4 / (x * y * z) as f64;
            assert!(y == 24 && x == z, "{height}: {x}, {y}, {z}");
            // the numbers of cells are rounded, each by less than 5 %
            assert!((in_a_cell / (20.0 * 13.3 / 24.0) - 1.0).abs() < 0.15, "{height}: {in_a_cell}");
        }
    }

    #[test]
    fn the_mean_free_path_has_the_factor_of_carnahan_and_starling() {
        let mut particles = Particles::default();
        (0..1000).for_each(|_| particles.push(Vector3::zeros(), Vector3::zeros(), 0.5, 1.0, 0));
        let (phi, volume) = (0.1, 1000.0 * PI / 6.0 / 0.1);
        let paths = [true, false].map(|enskog| RadiusSummary::of(&particles).mean_free_path(volume, enskog));
        // the tolerance allows for rounding
        assert!((paths[1] / paths[0] - (1.0 - 0.5 * phi) / (1.0_f64 - phi).powi(3)).abs() < 1e-12, "{paths:?}");
    }
}
