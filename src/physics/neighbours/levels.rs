//! Cells for spheres of very different sizes: a separate grid for each range of sizes.
//!
//! In a single grid, a cell must be as large as the largest sphere. It may then contain many small spheres: a thousand
//! if these are ten times smaller. Spheres are therefore sorted by size into levels, each with its own grid. Pairs
//! within a level are found as in a single grid. For each sphere, smaller spheres are searched in the grids of their
//! levels. If all sizes are within a factor of two, there is one level. Ericson (2005, Real-Time Collision Detection,
//! section 7.2) calls this method a hierarchical grid.

use super::cells::CellGrid;
use super::region::Region;
use crate::particles::{CHUNK, Sample};
use crate::work_sharing;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::ops::Range;

/// Largest number of levels (ranges of sizes). The sizes in a level are within a factor of two, except in the last
/// level, which has all smaller sizes.
const MOST_LEVELS: usize = 12;

/// Level: spheres of similar size, sorted into cells. The *reach* of a sphere is its radius, or the radius of a ball
/// that contains its path. Two spheres form a pair if the distance of their centres is less than the sum of their
/// reaches and the skin.
#[derive(Clone, Debug, Default)]
struct SizeLevel {
    grid: CellGrid,
    /// Indices of the spheres of the level, cell by cell.
    order: Vec<u32>,
    /// Number of spheres in all levels (ranges of sizes) before this level, which have larger spheres.
    first: usize,
    /// [m] largest reach (radius, or radius of a ball around the path) of the spheres of the level.
    reach: f64,
}

/// All levels (grids for ranges of sizes), beginning with the largest sizes.
#[derive(Clone, Debug, Default)]
pub struct SizeLevels {
    levels: Vec<SizeLevel>,
}

/// Sizes of items (spheres, or balls that contain the paths of spheres), for sorting into levels (ranges of sizes) and
/// cells.
pub struct SortedSizes<'a> {
    /// [m] radius of each item. The radius determines to which level (range of sizes) the item belongs.
    pub radius: &'a [f64],
    /// [m] largest and smallest radius of all items.
    pub range: [f64; 2],
    /// [m] skin: gap between surfaces up to which pairs are searched.
    pub skin: f64,
    /// Sizes of the spheres in all processes that share a run, from which the sizes of cells are chosen. `None` if this
    /// process stores all spheres.
    pub of_all: Option<&'a SizesOfAll>,
}

/// Number and largest size of the spheres in each level (range of sizes), counted over all processes that share a run.
#[derive(Clone, Debug)]
pub struct SizesOfAll {
    /// [m] largest and smallest radius of the spheres in all processes.
    pub range: [f64; 2],
    /// Number of spheres in each level (range of sizes).
    pub count: [i64; MOST_LEVELS],
    /// [m] largest radius of the spheres in each level.
    pub largest: [f64; MOST_LEVELS],
}

impl SizesOfAll {
    /// Counts the spheres of this process in each level (range of sizes), from their radii `radius` [m]. `range` [m]
    /// contains the largest and the smallest radius in all processes.
    pub fn of(radius: &[f64], range: [f64; 2]) -> Self {
        let sizes = SortedSizes { radius, range, skin: 0.0, of_all: None };
        let mut all = Self { range, count: [0; MOST_LEVELS], largest: [0.0; MOST_LEVELS] };
        for &r in radius {
            let level = if is_wide(range) { sizes.level(r) } else { 0 };
            all.count[level] += 1;
            all.largest[level] = all.largest[level].max(r);
        }
        all
    }
}

impl<'a> SortedSizes<'a> {
    /// Sizes of items with the given radii [m], for a search of pairs with gaps of up to `skin` [m].
    pub fn new(radius: &'a [f64], skin: f64) -> Self {
        Self { radius, range: range(radius), skin, of_all: None }
    }

    /// Number of the level (range of sizes) to which the radius `radius` [m] belongs; level 0 has the largest radii.
    fn level(&self, radius: f64) -> usize {
        let mut least = 0.5 * self.range[0];
        let mut level = 0;
        while radius <= least && level + 1 < MOST_LEVELS {
            least *= 0.5;
            level += 1;
        }
        level
    }
}

/// [m] largest and smallest of the given radii; both are 0 for an empty list.
pub fn range(radius: &[f64]) -> [f64; 2] {
    let widen = |[most, least]: [f64; 2], [a, b]: [f64; 2]| [most.max(a), least.min(b)];
    let none = [0.0, f64::INFINITY];
    let of = |chunk: &[f64]| chunk.iter().fold(none, |all, &r| widen(all, [r, r]));
    let [most, least] = work_sharing::map(radius.chunks(CHUNK), of).into_iter().fold(none, widen);
    [most, least.min(most)]
}

/// True if radii between the largest radius `most` and the smallest `least` [m] belong to more than one level (range of
/// sizes).
pub fn is_wide([most, least]: [f64; 2]) -> bool {
    least <= 0.5 * most
}

/// Number and size of the spheres in each level (range of sizes), from which the cost of a search is estimated.
#[derive(Clone, Serialize, Deserialize)]
pub struct Census {
    /// Number of spheres [-] and largest diameter [m] in each level (range of sizes) that contains spheres.
    levels: Vec<(f64, f64)>,
    /// [m³] volume of the box.
    volume: f64,
}

impl Census {
    /// Counts the spheres of all processes in each level (range of sizes). `sample` contains the particles of this
    /// process. `range` [m] contains the largest and the smallest radius, and `volume` is the volume [m³] of the box.
    /// `None` if all spheres belong to one level.
    pub fn of(sample: &Sample, range: [f64; 2], volume: f64) -> Option<Self> {
        if !is_wide(range) {
            return None;
        }
        let radius = &sample.particles.radius;
        let sizes = SortedSizes { radius, range, skin: 0.0, of_all: None };
        let (mut counts, mut diameters) = ([0.0; MOST_LEVELS], [0.0f64; MOST_LEVELS]);
        for &r in radius {
            let level = sizes.level(r);
            counts[level] += 1.0;
            diameters[level] = diameters[level].max(2.0 * r);
        }
        let diameters = sample.largest(diameters);
        let counts = sample.added(counts);
        let levels = counts.into_iter().zip(diameters).filter(|(count, _)| *count > 0.0).collect();
        Some(Self { levels, volume })
    }

    /// [-] number of pairs per sphere that a search tests, if the reach (radius of the ball that contains the path of
    /// a sphere) exceeds the radius of every sphere by half of `wider` [m]. Each sphere is tested with the spheres of
    /// its level in the 27 cells around it, and with smaller spheres near it; each pair is counted once.
    pub fn looked_at(&self, wider: f64) -> f64 {
        let all: f64 = self.levels.iter().map(|(count, _)| count).sum();
        let mut pairs = 0.0;
        for (k, (count, diameter)) in self.levels.iter().enumerate() {
            pairs += count * 13.5 * (count / self.volume * (diameter + wider).powi(3)).max(0.5);
            for (smaller, small) in &self.levels[k + 1..] {
                let side = diameter + 2.0 * small + 3.0 * wider;
                pairs += count * smaller / self.volume * side.powi(3);
            }
        }
        pairs / all
    }
}

impl SizeLevels {
    /// Sorts items inside a region into levels (ranges of sizes) and cells. `position` returns the position [m] of an
    /// item. `reach` returns, for the index of an item, its radius or the radius [m] of a ball that contains its path.
    pub fn sort<T: Sync>(
        &mut self,
        items: &[T],
        sizes: &SortedSizes,
        position: impl Fn(&T) -> Vector3<f64> + Sync,
        reach: impl Fn(usize) -> f64 + Sync,
        region: &Region,
    ) {
        let edge = |reach: f64, count: usize| {
            // empty cells cost computing time too, so cells are made large enough to contain about one particle each
            let spacing = (region.volume() / count.max(1) as f64).cbrt();
            (2.0 * reach + sizes.skin).max(0.8 * spacing)
        };
        let of_all = |level: usize| sizes.of_all.map(|all| (all.largest[level], all.count[level] as usize));
        if !is_wide(sizes.range) {
            self.levels.resize(1, SizeLevel::default());
            let level = &mut self.levels[0];
            let of = |first: usize| (first..items.len().min(first + CHUNK)).map(&reach).fold(0.0, f64::max);
            let here = || {
                let reaches = work_sharing::map((0..items.len()).step_by(CHUNK), of);
                (reaches.into_iter().fold(0.0, f64::max), items.len())
            };
            let (reach, count) = of_all(0).unwrap_or_else(here);
            (level.reach, level.first) = (reach, 0);
            level.grid.sort(items, position, region, edge(reach, count), &mut level.order);
            return;
        }
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); MOST_LEVELS];
        for (index, &radius) in (0u32..).zip(sizes.radius) {
            members[sizes.level(radius)].push(index);
        }
        let members: Vec<_> = members.into_iter().enumerate().filter(|(_, level)| !level.is_empty()).collect();
        self.levels.resize(members.len(), SizeLevel::default());
        let mut first = 0;
        for (level, (number, members)) in self.levels.iter_mut().zip(&members) {
            let item = |index: &u32| &items[*index as usize];
            let here = || (members.iter().map(|index| reach(*index as usize)).fold(0.0, f64::max), members.len());
            let (reach, count) = of_all(*number).unwrap_or_else(here);
            (level.reach, level.first) = (reach, first);
            first += members.len();
            let edge = edge(reach, count);
            level.grid.sort(members, |index| position(item(index)), region, edge, &mut level.order);
            level.order.iter_mut().for_each(|k| *k = members[*k as usize]);
        }
    }

    /// Sorts items of all sizes inside a region into a single level (range of sizes). `position` and `reach` are
    /// functions as in [`sort`](Self::sort).
    pub fn sort_alike<T: Sync>(
        &mut self,
        items: &[T],
        position: impl Fn(&T) -> Vector3<f64> + Sync,
        reach: impl Fn(usize) -> f64 + Sync,
        region: &Region,
    ) {
        let sizes = SortedSizes { radius: &[], range: [0.0, f64::INFINITY], skin: 0.0, of_all: None };
        self.sort(items, &sizes, position, reach, region);
    }

    /// Sorts the items of each cell by the numbers in `key`, which contains one number for each item, by index. The
    /// order of the items in a cell then does not depend on the order in which the items are stored.
    pub fn sort_cells(&mut self, key: &[u32]) {
        for level in &mut self.levels {
            let SizeLevel { grid, order, .. } = level;
            grid.for_each_cell_of(order, |indices| indices.sort_unstable_by_key(|&index| key[index as usize]));
        }
    }

    /// [m] largest reach (radius, or radius of a ball that contains the path) of all spheres.
    pub fn largest_reach(&self) -> f64 {
        self.levels.iter().map(|level| level.reach).fold(0.0, f64::max)
    }

    /// Indices of all items, level by level (a level is a range of sizes) and cell by cell.
    pub fn order(&self) -> Cow<'_, [u32]> {
        match self.levels.as_slice() {
            [one] => Cow::Borrowed(&one.order),
            all => all.iter().flat_map(|level| level.order.iter().copied()).collect(),
        }
    }

    /// Removes and returns the list of indices that [`order`](Self::order) gives. The grids of cells remain. The memory
    /// that was used only for sorting is freed.
    pub fn take_order(&mut self) -> Vec<u32> {
        self.levels.iter_mut().for_each(|level| level.grid.shed());
        match self.levels.as_mut_slice() {
            [one] => std::mem::take(&mut one.order),
            all => all.iter_mut().flat_map(|level| std::mem::take(&mut level.order)).collect(),
        }
    }

    /// Indices of the items at the positions `range` of the list [`order`](Self::order) of all items (level by level,
    /// cell by cell). The range must lie within one level.
    #[inline]
    pub fn indices(&self, range: Range<usize>) -> &[u32] {
        let of = |level: &SizeLevel| level.first <= range.start && range.start < level.first + level.order.len();
        let level = self.levels.iter().find(|level| of(level));
        level.map_or(&[], |level| &level.order[range.start - level.first..range.end - level.first])
    }

    /// Rows of cells of all levels (ranges of sizes). Each row is given by the number of its level, and its number in
    /// this level.
    pub fn rows(&self) -> Vec<(usize, usize)> {
        let rows =
            |(k, level): (usize, &SizeLevel)| (0..level.grid.rows()).map(move |row| (k, row)).collect::<Vec<_>>();
        self.levels.iter().enumerate().flat_map(rows).collect()
    }

    /// Grid of the level (range of sizes) number `level`, indices of its items cell by cell, and number of items in all
    /// levels before it.
    pub fn level(&self, level: usize) -> (&CellGrid, &[u32], usize) {
        let SizeLevel { grid, order, first, .. } = &self.levels[level];
        (grid, order, *first)
    }

    /// True if the level (range of sizes) with the number `level` is followed by levels with smaller spheres.
    #[inline]
    pub fn has_smaller(&self, level: usize) -> bool {
        level + 1 < self.levels.len()
    }

    /// Calls `visit` with ranges of the list of all items (level by level, cell by cell). Together these ranges
    /// contain all items in the levels after `level` (those for smaller spheres) that an item at `x` [m] may touch.
    /// `reach` [m] is the radius of this item plus the skin, the gap up to which pairs are searched. The flag passed
    /// to `visit` is true if periodic images of items in the range may be nearer than the items themselves.
    #[inline(always)]
    pub fn for_each_smaller(&self, level: usize, x: &Vector3<f64>, reach: f64, visit: impl FnMut(Range<usize>, bool)) {
        near(&self.levels[level + 1..], x, reach, visit);
    }

    /// Calls `visit` with ranges of the list of all items (level by level, cell by cell), which together contain all
    /// items that an item at `x` [m] may touch. The arguments are those of
    /// [`for_each_smaller`](Self::for_each_smaller).
    #[inline(always)]
    pub fn for_each_near(&self, x: &Vector3<f64>, reach: f64, visit: impl FnMut(Range<usize>, bool)) {
        near(&self.levels, x, reach, visit);
    }
}

#[inline(always)]
fn near(levels: &[SizeLevel], x: &Vector3<f64>, reach: f64, mut visit: impl FnMut(Range<usize>, bool)) {
    for level in levels {
        level.grid.for_each_near(
            x,
            reach + level.reach,
            #[inline(always)]
            |range, across| {
                if !range.is_empty() {
                    visit(range.start + level.first..range.end + level.first, across);
                }
            },
        );
    }
}
