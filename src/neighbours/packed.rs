//! Balls in the order of their cells, close together in memory and in single precision: most pairs are sorted out here, eight at a time.

#[cfg(target_arch = "x86_64")]
use super::lanes::eight::Eight;
use super::lanes::{Four, LANES, Lanes};
use super::levels::Levels;
use super::region::Region;
use crate::particles::CHUNK;
use nalgebra::Vector3;
use rayon::prelude::*;
use std::iter::once;
use std::ops::Range;

/// Of those that overlap, so many are picked at a time.
const AT_ONCE: usize = 4;

/// [m] middle and radius of a ball that is nowhere near.
const NOWHERE: [f32; 4] = [f32::MAX, f32::MAX, f32::MAX, 0.0];

/// A ball that is compared with others.
struct One<W> {
    /// Its place in the store.
    place: u32,
    /// [m] middle and radius, each as often as it is compared at a time.
    spot: [W; 4],
}

/// Pairs of those in a cell with one another and with those around it.
fn pairs(own: &Range<usize>, around: &[Range<usize>]) -> u64 {
    let (own, others) = (own.len() as u64, around.iter().map(|near| near.len() as u64).sum::<u64>());
    own * others + own * (own - 1) / 2
}

/// Which lanes have their bit set, in ascending order, for every set of bits.
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

/// So many are picked before they are looked at.
const ROOM: usize = 64;

/// Places of balls that may overlap one. Whether one does is not known before: to note four each time, and to go on after those only that do, costs
/// less than to ask and to guess wrong.
struct Picked {
    places: [u32; ROOM],
    count: usize,
}

impl Picked {
    /// Adds those of four places whose bits are set.
    #[inline(always)]
    fn add(&mut self, bits: usize, places: &[u32; AT_ONCE]) {
        let chosen = LANES_OF[bits].map(|lane| places[lane % AT_ONCE]);
        if let Some(room) = self.places.get_mut(self.count..self.count + AT_ONCE) {
            room.copy_from_slice(&chosen);
        }
        self.count += bits.count_ones() as usize;
    }

    /// Shows all, and begins anew.
    #[inline(always)]
    fn hand_over(&mut self, one: u32, visit: &mut impl FnMut(u32, &[u32])) {
        visit(one, self.places.get(..self.count).unwrap_or_default());
        self.count = 0;
    }
}

/// Balls that one is compared with: the first `count` of these.
#[derive(Clone, Copy)]
struct Candidates<'a> {
    spots: &'a [[f32; 4]],
    places: &'a [u32],
    count: usize,
}

/// So many are copied beside one another.
const TILE: usize = 128;

/// The balls of a cell and of those around it, copied beside one another: a row of cells holds few, and most lanes would be idle.
struct Tile {
    spots: [[f32; 4]; TILE + LANES],
    places: [u32; TILE + LANES],
    count: usize,
}

impl Default for Tile {
    fn default() -> Self {
        Self { spots: [NOWHERE; TILE + LANES], places: [0; TILE + LANES], count: 0 }
    }
}

impl Tile {
    /// Takes the balls of ranges of the order, one range after the other; false, and none, if there are too many.
    #[inline(always)]
    fn fill<R: Iterator<Item = Range<usize>>>(&mut self, packed: &Packed, ranges: impl Fn() -> R) -> bool {
        if ranges().map(|range| range.len()).sum::<usize>() > TILE {
            return false;
        }
        self.count = 0;
        for range in ranges() {
            // some at a time, and some more than there are: what comes next is written over them
            for from in range.clone().step_by(AT_ONCE) {
                let spots = packed.spots.get(from..).and_then(|spots| spots.first_chunk::<AT_ONCE>());
                let places = packed.places.get(from..).and_then(|places| places.first_chunk::<AT_ONCE>());
                let to = self.count..self.count + AT_ONCE;
                if let (Some(spots), Some(room)) = (spots, self.spots.get_mut(to.clone())) {
                    room.copy_from_slice(spots);
                }
                if let (Some(places), Some(room)) = (places, self.places.get_mut(to)) {
                    room.copy_from_slice(places);
                }
                self.count += (range.end - from).min(AT_ONCE);
            }
        }
        true
    }

    /// Those behind the one with that number.
    #[inline(always)]
    fn after(&self, number: usize) -> Candidates<'_> {
        let (spots, places) = (self.spots.get(number + 1..), self.places.get(number + 1..));
        Candidates {
            spots: spots.unwrap_or_default(),
            places: places.unwrap_or_default(),
            count: self.count.saturating_sub(number + 1),
        }
    }
}

/// [m] a ball in single precision, its radius larger by `rounding` [m].
#[inline(always)]
fn spot_of((middle, radius): (Vector3<f64>, f64), region: &Region, rounding: f64) -> [f32; 4] {
    let middle = region.local(&middle);
    [middle.x as f32, middle.y as f32, middle.z as f32, (radius + rounding) as f32]
}

/// Balls by their numbers in the order of cells.
#[derive(Default)]
pub struct Packed {
    /// Places in the store; behind the last come some that mean nothing.
    places: Vec<u32>,
    /// [m] middles along x, y, z, and radii; behind the last come some that are nowhere near.
    spots: Vec<[f32; 4]>,
    /// [m] how far images are along each axis; infinite where there are none.
    period: [f32; 3],
    /// [m] by which radii are larger than they were, for coordinates are rounded.
    rounding: f64,
}

impl Packed {
    /// Takes balls in the order of `places`; `ball` gives the middle and the radius [m] of the one at a place.
    pub fn fill(&mut self, places: Vec<u32>, ball: impl Fn(usize) -> (Vector3<f64>, f64) + Sync, region: &Region) {
        self.spots.clear();
        self.spots.resize(places.len() + LANES, NOWHERE);
        self.places = places;
        let periodic = region.periodic();
        self.period =
            std::array::from_fn(|axis| if periodic[axis] { region.size()[axis] as f32 } else { f32::INFINITY });
        // coordinates and periods are rounded to single precision: 2 x 3 coordinates and a difference of periods
        let rounding = 8.0 * f64::from(f32::EPSILON) * region.size().amax();
        self.rounding = rounding;
        let chunks = self.spots.par_chunks_mut(CHUNK).zip(self.places.par_chunks(CHUNK));
        chunks.for_each(|(spots, places)| {
            for (spot, place) in spots.iter_mut().zip(places) {
                *spot = spot_of(ball(*place as usize), region, rounding);
            }
        });
        self.places.reserve_exact(LANES);
        self.places.resize(self.places.len() + LANES, 0);
    }

    /// The ball with that number.
    #[inline(always)]
    fn one<L: Lanes>(&self, number: usize, lanes: L) -> One<L::Wide> {
        One { place: self.places[number], spot: self.spots[number].map(|x| lanes.splat(x)) }
    }

    /// Calls `visit` with the places of those balls of a row of cells, by its level and number, and of some around each that may overlap it; each pair
    /// comes once, and all of one ball after those of another. `smaller` gives how far from its middle the ball at a place reaches for those of smaller
    /// levels, which are in cells by another reach than the radius of their ball [m]. `CROWDED`: it is not rare that one of four overlaps another; the same
    /// are found either way. Returns how many pairs were looked at.
    #[inline(always)]
    pub fn for_each_near<const CROWDED: bool>(
        &self,
        levels: &Levels,
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
        self.near_of_row::<CROWDED, _>(Four, levels, row, smaller, visit)
    }

    #[inline(always)]
    fn near_of_row<const CROWDED: bool, L: Lanes>(
        &self,
        lanes: L,
        levels: &Levels,
        (level, row): (usize, usize),
        smaller: impl Fn(usize) -> (Vector3<f64>, f64),
        mut visit: impl FnMut(u32, &[u32]),
    ) -> u64 {
        let mut checks = 0;
        let (grid, _, first) = levels.level(level);
        let has_smaller = levels.has_smaller(level);
        let mut picked = Picked { places: [0; ROOM], count: 0 };
        let mut tile = Tile::default();
        grid.for_each_cell(
            row,
            #[inline(always)]
            |own, around, across| {
                checks += pairs(&own, around);
                let of_order = |range: &Range<usize>| first + range.start..first + range.end;
                // what is beside a cell in its row comes next in the order
                let (beside, ahead) =
                    around.split_first().map_or((0..0, around), |(beside, ahead)| (of_order(beside), ahead));
                let own = of_order(&own);
                let ranges = || once(own.start..beside.end).chain(ahead.iter().map(of_order));
                let fits = tile.fill(self, ranges);
                for number in own.clone() {
                    let one = self.one(number, lanes);
                    let mut pick = |candidates: Candidates| {
                        self.pick::<CROWDED, L>(lanes, &one, candidates, across, &mut picked, &mut visit);
                    };
                    if fits {
                        pick(tile.after(number - own.start));
                    } else {
                        let ranges = once(number + 1..beside.end).chain(ahead.iter().map(of_order));
                        ranges.for_each(|range| pick(self.candidates(range)));
                    }
                    if has_smaller {
                        let (middle, reach) = smaller(one.place as usize);
                        levels.for_each_smaller(
                            level,
                            &middle,
                            reach,
                            #[inline(always)]
                            |near, across| {
                                checks += near.len() as u64;
                                let near = self.candidates(near);
                                self.pick::<CROWDED, L>(lanes, &one, near, across, &mut picked, &mut visit);
                            },
                        );
                    }
                    picked.hand_over(one.place, &mut visit);
                }
            },
        );
        checks
    }

    /// Calls `visit` with the places of balls that may overlap another one, of which middle and radius are given [m].
    #[inline(always)]
    pub fn for_each_beside(
        &self,
        (middle, radius): (Vector3<f64>, f64),
        levels: &Levels,
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
        self.beside(Four, (middle, radius), levels, region, visit);
    }

    #[inline(always)]
    fn beside<L: Lanes>(
        &self,
        lanes: L,
        (middle, radius): (Vector3<f64>, f64),
        levels: &Levels,
        region: &Region,
        mut visit: impl FnMut(&[u32]),
    ) {
        let spot = spot_of((middle, radius), region, self.rounding);
        let one = One { place: 0, spot: spot.map(|x| lanes.splat(x)) };
        let mut picked = Picked { places: [0; ROOM], count: 0 };
        let mut visit = |_: u32, places: &[u32]| visit(places);
        levels.for_each_near(
            &middle,
            radius,
            #[inline(always)]
            |range, across| {
                let range = self.candidates(range);
                self.pick::<false, L>(lanes, &one, range, across, &mut picked, &mut visit);
            },
        );
        picked.hand_over(one.place, &mut visit);
    }

    /// The balls of a range of the order.
    #[inline(always)]
    fn candidates(&self, range: Range<usize>) -> Candidates<'_> {
        let (spots, places) = (self.spots.get(range.start..), self.places.get(range.start..));
        Candidates { spots: spots.unwrap_or_default(), places: places.unwrap_or_default(), count: range.len() }
    }

    /// Picks those of some balls that may overlap one; some of them only nearly do. `across`: it may be the image of another.
    #[inline(always)]
    fn pick<const CROWDED: bool, L: Lanes>(
        &self,
        lanes: L,
        one: &One<L::Wide>,
        others: Candidates,
        across: bool,
        picked: &mut Picked,
        visit: &mut impl FnMut(u32, &[u32]),
    ) {
        let (mut first, mut left) = (0, others.count);
        let spots = others.spots.get(..left.next_multiple_of(LANES)).unwrap_or_default();
        let period = self.period.map(|length| lanes.splat(length));
        for spots in spots.as_chunks().0 {
            let bits = if across {
                lanes.near::<true>(&one.spot, spots, left, &period)
            } else {
                lanes.near::<false>(&one.spot, spots, left, &period)
            };
            if CROWDED || bits != 0 {
                for half in 0..LANES / AT_ONCE {
                    let places = others.places.get(first + half * AT_ONCE..).and_then(|places| places.first_chunk());
                    picked.add(bits >> (half * AT_ONCE) & 0b1111, places.unwrap_or(&[0; AT_ONCE]));
                    if picked.count > ROOM - AT_ONCE {
                        picked.hand_over(one.place, visit);
                    }
                }
            }
            first += LANES;
            left = left.saturating_sub(LANES);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::Domain;
    use crate::neighbours::levels::Sizes;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Balls at random in a box, in cells.
    fn balls(count: usize, radii: Range<f64>) -> (Domain, Vec<Vector3<f64>>, Vec<f64>) {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(count as u64);
        let domain = Domain::new(Vector3::new(10.0, 8.0, 9.0), [true, false, true]);
        let middles = (0..count).map(|_| domain.size.map(|length| length * random.random_range(0.0..1.0))).collect();
        (domain, middles, (0..count).map(|_| random.random_range(radii.clone())).collect())
    }

    /// All pairs that are found, the smaller place first, in order.
    fn found<const CROWDED: bool>(domain: &Domain, middles: &[Vector3<f64>], radii: &[f64]) -> Vec<(u32, u32)> {
        let (mut levels, mut packed) = (Levels::default(), Packed::default());
        let region = Region::from(domain);
        levels.sort(middles, &Sizes::new(radii, 0.0), |x| *x, |place| radii[place], &region);
        packed.fill(levels.order(), |place| (middles[place], radii[place]), &region);
        let mut pairs = Vec::new();
        for row in levels.rows() {
            let smaller = |place: usize| (middles[place], radii[place]);
            packed.for_each_near::<CROWDED>(&levels, row, smaller, |i, others| {
                pairs.extend(others.iter().map(|&j| (i.min(j), i.max(j))));
            });
        }
        pairs.sort_unstable();
        pairs
    }

    #[test]
    fn every_pair_that_overlaps_is_found_once_and_none_that_is_clearly_apart() {
        // crowded and empty cells, one size and many
        for (count, radii) in [(200, 0.3..0.31), (3000, 0.3..0.31), (3000, 0.05..0.6), (20, 1.0..1.3)] {
            let (domain, middles, radii) = balls(count, radii);
            let pairs = found::<true>(&domain, &middles, &radii);
            assert_eq!(pairs, found::<false>(&domain, &middles, &radii));
            assert!(pairs.windows(2).all(|two| two[0] < two[1]), "a pair is found twice");
            let gap = |i: u32, j: u32| {
                let (i, j) = (i as usize, j as usize);
                domain.separation(&middles[i], &middles[j]).norm() - (radii[i] + radii[j])
            };
            // coordinates are rounded to 2^-24 of the box, 16 times in all
            assert!(pairs.iter().all(|&(i, j)| gap(i, j) < 32.0 * 10.0 * f64::from(f32::EPSILON)));
            let places = 0..count as u32;
            let overlap = places.clone().flat_map(|i| (i + 1..count as u32).map(move |j| (i, j)));
            let overlapping: Vec<_> = overlap.filter(|&(i, j)| gap(i, j) < 0.0).collect();
            assert!(overlapping.len() > 3, "{count}: {} pairs", overlapping.len());
            let missed: Vec<_> = overlapping.iter().filter(|pair| pairs.binary_search(pair).is_err()).collect();
            assert!(missed.is_empty(), "{count}: {missed:?} of {overlapping:?}");
        }
    }

    #[test]
    fn what_a_ball_overlaps_is_found_beside_it() {
        let (domain, middles, radii) = balls(2000, 0.1..0.4);
        let (mut levels, mut packed) = (Levels::default(), Packed::default());
        let region = Region::from(&domain);
        levels.sort(&middles, &Sizes::new(&radii, 0.0), |x| *x, |place| radii[place], &region);
        packed.fill(levels.order(), |place| (middles[place], radii[place]), &region);
        let (middle, radius) = (Vector3::new(9.8, 0.3, 0.2), 1.1);
        let mut beside = Vec::new();
        packed.for_each_beside((middle, radius), &levels, &region, |places| beside.extend_from_slice(places));
        let gap = |place: usize| domain.separation(&middles[place], &middle).norm() - (radii[place] + radius);
        let overlapping: Vec<_> = (0..2000).filter(|&place| gap(place as usize) < 0.0).collect();
        assert!(overlapping.len() > 5 && overlapping.iter().all(|place| beside.contains(place)));
        assert!(beside.iter().all(|&place| gap(place as usize) < 1e-4));
    }
}
