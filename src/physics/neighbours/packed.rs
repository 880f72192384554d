//! Fast test for possible overlaps of balls, each of which contains a sphere or its path. The balls are stored in cell
//! order and in single precision, and tested eight at a time. The test rejects most pairs, so that few pairs need an
//! exact test.

#[cfg(target_arch = "x86_64")]
use super::lanes::eight::Eight;
use super::lanes::{FourLanes, LANES, Lanes, Spots};
use super::levels::SizeLevels;
use super::region::Region;
use crate::particles::CHUNK;
use crate::work_sharing;
use nalgebra::Vector3;
use std::ops::Range;

/// Number of balls whose test results are stored at the same time.
const AT_ONCE: usize = 4;

/// A ball (which contains a sphere or its path), prepared for a test of overlap with several others at the same time.
struct PackedBall<W> {
    /// Index of the ball in the particle store.
    index: u32,
    /// [m] centre and radius, each repeated in all lanes (positions) of a vector register of the processor.
    spot: [W; 4],
}

/// For every mask of four bits: numbers of the lanes (positions in a vector register of the processor) whose bits are
/// set, in ascending order.
const LANES_OF: [[usize; AT_ONCE]; 1 << AT_ONCE] = {
    let mut all = [[0; AT_ONCE]; 1 << AT_ONCE];
    let mut bits = 0;
    while bits < all.len() {
        let (mut lane, mut count) = (0, 0);
        while lane < AT_ONCE {
            if bits >> lane & 1 == 1 {
                all[bits][count] = lane;
                count += 1;
            }
            lane += 1;
        }
        bits += 1;
    }
    all
};

/// Largest number of indices of overlapping balls that are collected before they are passed to the caller.
const ROOM: usize = 64;

/// Collection of the indices of balls that may overlap another ball. Indices are added without branches (conditional
/// jumps of the program). Four indices are stored at a time, and the count increases by the number of balls that may
/// overlap. This costs less than a branch that the processor often predicts wrongly.
struct Picked {
    indices: [u32; ROOM],
    count: usize,
}

impl Picked {
    /// Adds those of the four `indices` whose bits are set in the mask `bits`; the lowest bit belongs to the
    /// first index.
    #[inline(always)]
    fn add(&mut self, bits: usize, indices: &[u32; AT_ONCE]) {
        let chosen = LANES_OF[bits].map(|lane| indices[lane % AT_ONCE]);
        if let Some(room) = self.indices.get_mut(self.count..self.count + AT_ONCE) {
            room.copy_from_slice(&chosen);
        }
        self.count += bits.count_ones() as usize;
    }

    /// Passes all collected indices to `visit` as neighbours of the ball `one`, and empties the collection.
    #[inline(always)]
    fn hand_over(&mut self, one: u32, visit: &mut impl FnMut(u32, &[u32])) {
        visit(one, self.indices.get(..self.count).unwrap_or_default());
        self.count = 0;
    }
}

/// Eight consecutive numbers of a list from the index `first` on; `None` if fewer than eight are left.
#[inline(always)]
fn eight_of(numbers: &[f32], first: usize) -> Option<&[f32; LANES]> {
    numbers.get(first..)?.first_chunk()
}

/// [m] centre and radius of a ball in single precision. The centre is relative to the lowest corner of the region. The
/// radius is increased by `rounding` [m].
#[inline(always)]
fn spot_of((middle, radius): (Vector3<f64>, f64), region: &Region, rounding: f64) -> [f32; 4] {
    let middle = region.local(&middle);
    [middle.x as f32, middle.y as f32, middle.z as f32, (radius + rounding) as f32]
}

/// Balls (which contain spheres or their paths), sorted cell by cell and stored for fast tests of overlap.
#[derive(Default)]
pub struct PackedBalls {
    /// Indices of the balls in the particle store; the padding at the end has no meaning.
    indices: Vec<u32>,
    /// [m] centres along x, y, z, and radii, as four lists, from which eight consecutive numbers are loaded at a time.
    /// The padding at the end has no meaning.
    spots: [Vec<f32>; 4],
    /// [m] distance between periodic images along each axis; infinite along an axis on which the region is not
    /// periodic.
    period: [f32; 3],
    /// [m] increase of all radii, so that rounding of coordinates cannot hide an overlap.
    rounding: f64,
}

impl PackedBalls {
    /// Stores the balls at `indices`, in this order. `ball` returns the centre and the radius [m] of the
    /// ball at an index.
    pub fn fill(&mut self, indices: &[u32], ball: impl Fn(usize) -> (Vector3<f64>, f64) + Sync, region: &Region) {
        // each thread fills a part of the lists, which is then in the cache of this thread
        for numbers in &mut self.spots {
            numbers.resize(indices.len() + LANES, 0.0);
        }
        self.indices.resize(indices.len() + LANES, 0);
        let periodic = region.periodic();
        self.period =
            std::array::from_fn(|axis| if periodic[axis] { region.size()[axis] as f32 } else { f32::INFINITY });
        // eight roundings to single precision: two for each of the three coordinates, and two for the difference from
        // a period
        let rounding = 8.0 * f64::from(f32::EPSILON) * region.size().amax();
        self.rounding = rounding;
        let [x, y, z, radii] = self.spots.each_mut().map(|numbers| numbers.chunks_mut(CHUNK));
        let chunks = x.zip(y).zip(z.zip(radii)).zip(self.indices.chunks_mut(CHUNK).zip(indices.chunks(CHUNK)));
        work_sharing::for_each(chunks, |(((x, y), (z, radii)), (own, indices))| {
            own[..indices.len()].copy_from_slice(indices);
            for (k, index) in indices.iter().enumerate() {
                [x[k], y[k], z[k], radii[k]] = spot_of(ball(*index as usize), region, rounding);
            }
        });
    }

    /// Prepares ball number `number` of the cell order for a test of overlap with several balls at the same time.
    #[inline(always)]
    fn one<L: Lanes>(&self, number: usize, lanes: L) -> PackedBall<L::Wide> {
        let [x, y, z, radii] = &self.spots;
        let spot = [x[number], y[number], z[number], radii[number]];
        PackedBall { index: self.indices[number], spot: spot.map(|number| lanes.splat(number)) }
    }

    /// Calls `visit` with the index of each ball of a row of cells, and the indices of balls that may overlap this
    /// ball. Each pair occurs once, but several calls in succession may belong to one ball. `row` contains the number
    /// of a level (range of sizes), and the number of a row in the grid of this level. `smaller` returns, for the index
    /// of a ball, the centre and the radius [m] with which it is searched for neighbours in levels for smaller sizes.
    /// `CROWDED` should be true if most tests of four balls find an overlap. This choice changes the speed but not the
    /// results. Returns the number of pairs tested.
    #[inline(always)]
    pub fn for_each_near<const CROWDED: bool>(
        &self,
        levels: &SizeLevels,
        row: (usize, usize),
        smaller: impl Fn(usize) -> (Vector3<f64>, f64),
        visit: impl FnMut(u32, &[u32]),
    ) -> u64 {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return simd.vectorize(
                #[inline(always)]
                || self.near_of_row::<CROWDED, _>(Eight(simd), levels, row, smaller, visit),
            );
        }
        self.near_of_row::<CROWDED, _>(FourLanes, levels, row, smaller, visit)
    }

    #[inline(always)]
    fn near_of_row<const CROWDED: bool, L: Lanes>(
        &self,
        lanes: L,
        levels: &SizeLevels,
        (level, row): (usize, usize),
        smaller: impl Fn(usize) -> (Vector3<f64>, f64),
        mut visit: impl FnMut(u32, &[u32]),
    ) -> u64 {
        let mut checks = 0;
        let (grid, _, first) = levels.level(level);
        let has_smaller = levels.has_smaller(level);
        let mut picked = Picked { indices: [0; ROOM], count: 0 };
        grid.for_each_cell(
            row,
            #[inline(always)]
            |own, around, across| {
                for number in own {
                    let one = self.one(first + number, lanes);
                    around.begin_at(number + 1);
                    for range in around.ranges() {
                        checks += range.len() as u64;
                        let range = first + range.start..first + range.end;
                        self.pick::<CROWDED, L>(lanes, &one, range, across, &mut picked, &mut visit);
                    }
                    if has_smaller {
                        let (middle, reach) = smaller(one.index as usize);
                        levels.for_each_smaller(
                            level,
                            &middle,
                            reach,
                            #[inline(always)]
                            |near, across| {
                                checks += near.len() as u64;
                                self.pick::<CROWDED, L>(lanes, &one, near, across, &mut picked, &mut visit);
                            },
                        );
                    }
                    if picked.count > 0 {
                        picked.hand_over(one.index, &mut visit);
                    }
                }
            },
        );
        checks
    }

    /// Calls `visit` with the indices of balls that may overlap a ball with the given centre and radius [m].
    #[inline(always)]
    pub fn for_each_beside(
        &self,
        (middle, radius): (Vector3<f64>, f64),
        levels: &SizeLevels,
        region: &Region,
        visit: impl FnMut(&[u32]),
    ) {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return simd.vectorize(
                #[inline(always)]
                || self.beside(Eight(simd), (middle, radius), levels, region, visit),
            );
        }
        self.beside(FourLanes, (middle, radius), levels, region, visit);
    }

    #[inline(always)]
    fn beside<L: Lanes>(
        &self,
        lanes: L,
        (middle, radius): (Vector3<f64>, f64),
        levels: &SizeLevels,
        region: &Region,
        mut visit: impl FnMut(&[u32]),
    ) {
        let spot = spot_of((middle, radius), region, self.rounding);
        let one = PackedBall { index: 0, spot: spot.map(|x| lanes.splat(x)) };
        let mut picked = Picked { indices: [0; ROOM], count: 0 };
        let mut visit = |_: u32, indices: &[u32]| visit(indices);
        levels.for_each_near(
            &middle,
            radius,
            #[inline(always)]
            |range, across| {
                self.pick::<false, L>(lanes, &one, range, across, &mut picked, &mut visit);
            },
        );
        picked.hand_over(one.index, &mut visit);
    }

    /// Centres and radii [m] of eight consecutive balls of the cell order, beginning with ball `number`; `None` if
    /// fewer than eight are left.
    #[inline(always)]
    fn eight(&self, number: usize) -> Option<Spots<'_>> {
        let [x, y, z, radii] = &self.spots;
        Some([eight_of(x, number)?, eight_of(y, number)?, eight_of(z, number)?, eight_of(radii, number)?])
    }

    /// Collects the balls of a range of the cell order that may overlap the ball `one`. Because of rounding, some of
    /// the collected balls have a small gap from this ball. `across` must be true if periodic images of the balls may
    /// be nearer than the balls themselves.
    #[inline(always)]
    fn pick<const CROWDED: bool, L: Lanes>(
        &self,
        lanes: L,
        one: &PackedBall<L::Wide>,
        mut others: Range<usize>,
        across: bool,
        picked: &mut Picked,
        visit: &mut impl FnMut(u32, &[u32]),
    ) {
        while others.start < others.end
            && let Some(spots) = self.eight(others.start)
        {
            let bits = if across {
                lanes.near::<true>(&one.spot, spots, others.len(), &self.period)
            } else {
                lanes.near::<false>(&one.spot, spots, others.len(), &self.period)
            };
            if CROWDED || bits != 0 {
                for half in 0..LANES / AT_ONCE {
                    let indices =
                        self.indices.get(others.start + half * AT_ONCE..).and_then(|indices| indices.first_chunk());
                    picked.add(bits >> (half * AT_ONCE) & 0b1111, indices.unwrap_or(&[0; AT_ONCE]));
                    if picked.count > ROOM - AT_ONCE {
                        picked.hand_over(one.index, visit);
                    }
                }
            }
            others.start += LANES.min(others.len());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::Domain;
    use crate::neighbours::levels::SortedSizes;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Makes random balls in a box. Returns the box, the centres and the radii.
    fn balls(count: usize, radii: Range<f64>) -> (Domain, Vec<Vector3<f64>>, Vec<f64>) {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(count as u64);
        let domain = Domain::new(Vector3::new(10.0, 8.0, 9.0), [true, false, true]);
        let middles = (0..count).map(|_| domain.size.map(|length| length * random.random_range(0.0..1.0))).collect();
        (domain, middles, (0..count).map(|_| random.random_range(radii.clone())).collect())
    }

    /// All pairs that a search finds, each with the smaller index first, in ascending order. `CROWDED` is passed on to
    /// [`for_each_near`](PackedBalls::for_each_near).
    fn found<const CROWDED: bool>(
        packed: &mut PackedBalls,
        domain: &Domain,
        middles: &[Vector3<f64>],
        radii: &[f64],
    ) -> Vec<(u32, u32)> {
        let mut levels = SizeLevels::default();
        let region = Region::from(domain);
        levels.sort(middles, &SortedSizes::new(radii, 0.0), |x| *x, |index| radii[index], &region);
        packed.fill(&levels.order(), |index| (middles[index], radii[index]), &region);
        let mut pairs = Vec::new();
        for row in levels.rows() {
            let smaller = |index: usize| (middles[index], radii[index]);
            packed.for_each_near::<CROWDED>(&levels, row, smaller, |i, others| {
                pairs.extend(others.iter().map(|&j| (i.min(j), i.max(j))));
            });
        }
        pairs.sort_unstable();
        pairs
    }

    #[test]
    fn every_pair_that_overlaps_is_found_once_and_none_that_is_clearly_apart() {
        // crowded and empty cells, one size and several sizes; the memory was used for other balls before
        let mut packed = PackedBalls::default();
        for (count, radii) in [(200, 0.3..0.31), (3000, 0.3..0.31), (3000, 0.05..0.6), (20, 1.0..1.3)] {
            let (domain, middles, radii) = balls(count, radii);
            let pairs = found::<true>(&mut packed, &domain, &middles, &radii);
            assert_eq!(pairs, found::<false>(&mut packed, &domain, &middles, &radii));
            assert!(pairs.windows(2).all(|two| two[0] < two[1]), "a pair is found twice");
            let gap = |i: u32, j: u32| {
                let (i, j) = (i as usize, j as usize);
                domain.separation(&middles[i], &middles[j]).norm() - (radii[i] + radii[j])
            };
            // coordinates are rounded to 2^-24 of the box, 16 times in total
            assert!(pairs.iter().all(|&(i, j)| gap(i, j) < 32.0 * 10.0 * f64::from(f32::EPSILON)));
            let indices = 0..count as u32;
            let overlap = indices.clone().flat_map(|i| (i + 1..count as u32).map(move |j| (i, j)));
            let overlapping: Vec<_> = overlap.filter(|&(i, j)| gap(i, j) < 0.0).collect();
            assert!(overlapping.len() > 3, "{count}: {} pairs", overlapping.len());
            let missed: Vec<_> = overlapping.iter().filter(|pair| pairs.binary_search(pair).is_err()).collect();
            assert!(missed.is_empty(), "{count}: {missed:?} of {overlapping:?}");
        }
    }

    #[test]
    fn what_a_ball_overlaps_is_found_beside_it() {
        let (domain, middles, radii) = balls(2000, 0.1..0.4);
        let (mut levels, mut packed) = (SizeLevels::default(), PackedBalls::default());
        let region = Region::from(&domain);
        levels.sort(&middles, &SortedSizes::new(&radii, 0.0), |x| *x, |index| radii[index], &region);
        packed.fill(&levels.order(), |index| (middles[index], radii[index]), &region);
        let (middle, radius) = (Vector3::new(9.8, 0.3, 0.2), 1.1);
        let mut beside = Vec::new();
        packed.for_each_beside((middle, radius), &levels, &region, |indices| beside.extend_from_slice(indices));
        let gap = |index: usize| domain.separation(&middles[index], &middle).norm() - (radii[index] + radius);
        let overlapping: Vec<_> = (0..2000).filter(|&index| gap(index as usize) < 0.0).collect();
        assert!(overlapping.len() > 5 && overlapping.iter().all(|index| beside.contains(index)));
        assert!(beside.iter().all(|&index| gap(index as usize) < 1e-4));
    }
}
