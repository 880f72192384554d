//! Flights in the order of their cells, close together in memory and in single precision: most pairs are sorted out here, four at a time.

use super::search::Spot;
use crate::neighbours::region::Region;
use crate::particles::CHUNK;
use rayon::prelude::*;
use std::ops::Range;
use wide::f32x4;

/// Flights that are compared with one at a time.
const LANES: usize = 4;

/// [m] middle and reach of a flight that is nowhere near.
const NOWHERE: [f32; 4] = [f32::MAX, f32::MAX, f32::MAX, 0.0];

/// A flight that is compared with others.
pub struct One {
    /// Its place in the store.
    pub place: u32,
    /// [m] middle and reach, each as often as it is compared at a time.
    spot: [f32x4; 4],
}

/// Flights by their numbers in the order of cells.
#[derive(Default)]
pub struct Packed {
    /// Places in the store.
    places: Vec<u32>,
    /// [m] middles along x, y, z, and reaches; behind the last come some that are nowhere near.
    spots: Vec<[f32; 4]>,
    /// [m] how far images are along each axis; infinite where there are none.
    period: [f32; 3],
}

impl Packed {
    /// Takes flights in the order of `places`.
    pub fn fill(&mut self, places: Vec<u32>, flights: &[Spot], region: &Region) {
        self.places = places;
        let periodic = region.periodic();
        self.period =
            std::array::from_fn(|axis| if periodic[axis] { region.size()[axis] as f32 } else { f32::INFINITY });
        // coordinates and periods are rounded to single precision: 2 x 3 coordinates and a difference of periods
        let rounding = 8.0 * f64::from(f32::EPSILON) * region.size().amax();
        self.spots.clear();
        self.spots.resize(self.places.len() + LANES, NOWHERE);
        let chunks = self.spots.par_chunks_mut(CHUNK).zip(self.places.par_chunks(CHUNK));
        chunks.for_each(|(spots, places)| {
            for (spot, place) in spots.iter_mut().zip(places) {
                let Spot { middle, reach } = &flights[*place as usize];
                let middle = region.local(middle);
                *spot = [middle.x as f32, middle.y as f32, middle.z as f32, (reach + rounding) as f32];
            }
        });
    }

    /// The flight with that number.
    #[inline(always)]
    pub fn one(&self, number: usize) -> One {
        One { place: self.places[number], spot: self.spots[number].map(f32x4::splat) }
    }

    /// Calls `visit` with the place of a flight and that of each of the others that it may come within reach of. `across`: it may be the
    /// image of another.
    #[inline(always)]
    pub fn for_each_near(&self, one: &One, others: Range<usize>, across: bool, visit: &mut impl FnMut(u32, u32)) {
        let groups = others.start..others.start + others.len().next_multiple_of(LANES);
        let groups = self.spots.get(groups).unwrap_or_default().as_chunks().0;
        let mut first = others.start;
        for spots in groups {
            let mut near = if across { self.near::<true>(one, spots) } else { self.near::<false>(one, spots) };
            while near != 0 {
                let other = first + near.trailing_zeros() as usize;
                if other < others.end {
                    visit(one.place, self.places[other]);
                }
                near &= near - 1;
            }
            first += LANES;
        }
    }

    /// Which of some flights are within reach of one: a bit each.
    #[inline(always)]
    fn near<const ACROSS: bool>(&self, one: &One, others: &[[f32; 4]; LANES]) -> u32 {
        let [x, y, z, reach] = f32x4::transpose(others.map(f32x4::from));
        let mut square = f32x4::ZERO;
        for (axis, there) in [x, y, z].into_iter().enumerate() {
            let mut apart = there - one.spot[axis];
            if ACROSS {
                apart = apart.abs();
                apart = apart.fast_min((f32x4::splat(self.period[axis]) - apart).abs());
            }
            square += apart * apart;
        }
        let reach = one.spot[3] + reach;
        square.simd_lt(reach * reach).to_bitmask()
    }
}
