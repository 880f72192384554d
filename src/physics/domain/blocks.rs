//! The box cut into blocks, one for each process that shares a run.

use super::Domain;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Borders of the blocks into which the box is cut, one block for each process that shares a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Blocks {
    /// [m] ends of the blocks along each axis, without the end of the last block, which is the side of the box.
    ends: [Vec<f64>; 3],
}

impl Blocks {
    /// Cuts the box into one block per process, for particles at `positions` [m]. The cutting planes perpendicular to
    /// each axis divide the box into slices with nearly equal numbers of particles. If the box has periodic axes, only
    /// these axes are cut; otherwise all axes may be cut. The axis along which the blocks are longest is cut first.
    pub fn of(positions: &[Vector3<f64>], processes: usize, domain: &Domain) -> Self {
        let blocks = along_axes(processes, domain);
        let ends = std::array::from_fn(|axis| {
            let mut along: Vec<f64> = positions.iter().map(|x| x[axis]).collect();
            let end = |block: usize| {
                let place = block * along.len() / blocks[axis];
                if along.is_empty() { 0.0 } else { *along.select_nth_unstable_by(place, f64::total_cmp).1 }
            };
            (1..blocks[axis]).map(end).collect()
        });
        Self { ends }
    }

    /// Cuts the box into one block per process, all of equal size.
    pub fn of_one_size(processes: usize, domain: &Domain) -> Self {
        let blocks = along_axes(processes, domain);
        let end = |axis: usize, block: usize| domain.size[axis] * block as f64 / blocks[axis] as f64;
        Self { ends: std::array::from_fn(|axis| (1..blocks[axis]).map(|block| end(axis, block)).collect()) }
    }

    /// Number of the process whose block contains the position `x` [m], which lies in the box.
    pub fn owner(&self, x: &Vector3<f64>) -> usize {
        let along = |axis: usize| self.ends[axis].partition_point(|end| *end <= x[axis]);
        self.number([along(0), along(1), along(2)])
    }

    /// [m] lowest and highest corner of the block that belongs to a process.
    pub fn corners(&self, process: usize, domain: &Domain) -> [Vector3<f64>; 2] {
        let (across, along) = (self.count(0), self.count(1));
        let block = [process % across, process / across % along, process / across / along];
        [0, 1].map(|side| Vector3::from_fn(|axis, _| self.span(axis, block[axis], domain)[side]))
    }

    /// True if the position `x` [m] is farther than `width` [m] from every block except the one that contains it. `low`
    /// and `high` [m] are the corners of the block that contains `x`.
    pub fn is_deep(&self, x: &Vector3<f64>, [low, high]: &[Vector3<f64>; 2], width: f64) -> bool {
        let deep = |axis: usize| x[axis] - low[axis] > width && high[axis] - x[axis] > width;
        (0..3).all(|axis| self.ends[axis].is_empty() || deep(axis))
    }

    /// Calls `visit` with the number of every process whose block is within `width` [m] of the position `x` [m] in the
    /// box, along each axis.
    pub fn for_each_within(&self, x: &Vector3<f64>, width: f64, domain: &Domain, mut visit: impl FnMut(usize)) {
        let near: [Vec<usize>; 3] = std::array::from_fn(|axis| {
            let is_near = |block: &usize| {
                let [low, high] = self.span(axis, *block, domain);
                let apart = |x: f64| (low - x).max(x - high);
                let images =
                    if domain.periodic[axis] { [0.0, domain.size[axis], -domain.size[axis]] } else { [0.0; 3] };
                images.iter().map(|image| apart(x[axis] + image)).fold(f64::INFINITY, f64::min) <= width
            };
            (0..self.count(axis)).filter(is_near).collect()
        });
        for &k in &near[2] {
            for &j in &near[1] {
                near[0].iter().for_each(|&i| visit(self.number([i, j, k])));
            }
        }
    }

    /// Number of blocks along the axis `axis` (0, 1, 2 for x, y, z).
    fn count(&self, axis: usize) -> usize {
        self.ends[axis].len() + 1
    }

    fn number(&self, [i, j, k]: [usize; 3]) -> usize {
        i + self.count(0) * (j + self.count(1) * k)
    }

    /// [m] coordinates along an axis of the beginning and the end of the block that is number `block` along this axis.
    fn span(&self, axis: usize, block: usize, domain: &Domain) -> [f64; 2] {
        let before = block.checked_sub(1).and_then(|before| self.ends[axis].get(before));
        [before.copied().unwrap_or(0.0), self.ends[axis].get(block).copied().unwrap_or(domain.size[axis])]
    }
}

/// Number of blocks along each of the three axes; their product is the number of processes.
fn along_axes(processes: usize, domain: &Domain) -> [usize; 3] {
    let mut blocks = [1usize; 3];
    let any = domain.periodic.iter().any(|periodic| *periodic);
    let axes: Vec<usize> = (0..3).filter(|axis| domain.periodic[*axis] || !any).collect();
    for factor in factors(processes) {
        let piece = |axis: &usize| domain.size[*axis] / blocks[*axis] as f64;
        if let Some(&axis) = axes.iter().max_by(|a, b| piece(a).total_cmp(&piece(b))) {
            blocks[axis] *= factor;
        }
    }
    blocks
}

/// Prime factors of a number, the largest first.
fn factors(number: usize) -> Vec<usize> {
    let (mut left, mut factors, mut factor) = (number, Vec::new(), 2);
    while left > 1 {
        while left.is_multiple_of(factor) {
            factors.push(factor);
            left /= factor;
        }
        factor += 1;
    }
    factors.reverse();
    factors
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_has_one_owner_and_blocks_are_equally_full() {
        let domain = Domain::new(Vector3::new(4.0, 9.0, 8.0), [true, false, true]);
        // in this test positions are denser towards the low end of z
        let places: Vec<Vector3<f64>> = (0..600)
            .map(|k| Vector3::new(f64::from(k % 40) / 10.0, 3.0, 8.0 * (f64::from(k) / 600.0).powi(2)))
            .collect();
        let blocks = Blocks::of(&places, 6, &domain);
        let mut counts = [0; 6];
        places.iter().for_each(|x| counts[blocks.owner(x)] += 1);
        assert!(counts.iter().all(|count| (85..=115).contains(count)), "{counts:?}");
        for x in &places {
            let owner = blocks.owner(x);
            let corners = blocks.corners(owner, &domain);
            assert!((0..3).all(|axis| corners[0][axis] <= x[axis] && x[axis] <= corners[1][axis]), "{x}");
            let mut near = Vec::new();
            blocks.for_each_within(x, 0.3, &domain, |process| near.push(process));
            assert!(near.contains(&owner));
            assert_eq!(blocks.is_deep(x, &corners, 0.3), near.len() == 1, "{x} {near:?} {corners:?}");
        }
        let mut across_the_side = Vec::new();
        blocks.for_each_within(&Vector3::new(0.1, 3.0, 7.9), 0.2, &domain, |process| across_the_side.push(process));
        let other = blocks.owner(&Vector3::new(0.1, 3.0, 0.05));
        assert!(across_the_side.contains(&other), "{across_the_side:?} {other}");
        assert_eq!(Blocks::of(&[], 1, &domain).owner(&places[0]), 0);
        // six processes: 3 blocks along z, the longest periodic axis, and 2 along x
        let same = Blocks::of_one_size(6, &domain);
        let corners = same.corners(5, &domain);
        assert_eq!(corners[1], domain.size);
        assert!((corners[1] - corners[0] - Vector3::new(2.0, 9.0, 8.0 / 3.0)).norm() < 1e-12, "{corners:?}");
        assert_eq!(factors(60), [5, 3, 2, 2]);
    }
}
