//! Surfaces that continue through periodic sides: floors, corrugated walls, pipes of one period.
//!
//! A surface is endless along an axis if its open edges lie on two planes one period apart and match after a shift by
//! one period. Copies of the triangles near these planes, shifted by one period, continue the surface. Matching corners
//! get identical coordinates, so that no seam is left.

use nalgebra::Vector3;
use rustc_hash::{FxHashMap, FxHashSet};

/// List of triangles, each given by its corners [m].
type TriangleList = Vec<[Vector3<f64>; 3]>;
/// An edge of a triangle, given by its two corners [m].
type Edge = [Vector3<f64>; 2];

/// [-] distance over the period, below which two corners count as the same corner. A file in single precision has
/// errors of 6e-8 of the largest number.
const SAME: f64 = 1e-6;

/// Error: a surface reaches both periodic sides of an axis, but its open edges on the two sides do not match.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mismatch {
    /// Axis perpendicular to the sides: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// [m] largest distance of a corner on one side from the edges on the other side, after a shift by one period.
    pub step: f64,
}

/// A surface together with the copies of triangles that continue it beyond periodic sides.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Continued {
    /// Triangles, given by their corners [m]: those of the surface itself, followed by the copies.
    pub heap: TriangleList,
    /// True for each axis along which the surface continues without end.
    pub spans: [bool; 3],
    /// Number of open edges of the surface itself at which a copy of a triangle continues the surface.
    pub joined: usize,
}

/// Continues a surface through the periodic sides at which its open edges match. `periods` [m] gives the length of the
/// domain along each periodic axis. Copies of triangles extend beyond the sides by `margin` [m], but at most by one
/// period.
///
/// # Errors
/// If the open edges on two sides do not match.
pub fn continued(heap: &[[Vector3<f64>; 3]], periods: [Option<f64>; 3], margin: f64) -> Result<Continued, Mismatch> {
    let mut all = Continued { heap: heap.to_vec(), ..Continued::default() };
    for (axis, period) in periods.into_iter().enumerate() {
        let Some(period) = period else { continue };
        let Some(sides) = OpenEnds::of(&all.heap, axis, period) else { continue };
        let same = sides.matched()?;
        all.spans[axis] = true;
        continue_along(&mut all.heap, &sides, &same, margin.min(period));
    }
    let open: FxHashSet<_> = open_edges(&all.heap).iter().map(key).collect();
    all.joined = open_edges(&all.heap[..heap.len()]).iter().filter(|edge| !open.contains(&key(edge))).count();
    Ok(all)
}

/// Open edges at the two ends of a surface, on two planes one period apart.
struct OpenEnds {
    axis: usize,
    /// [m] length of the period of the box along the axis.
    period: f64,
    /// [m] coordinate of the lower plane along the axis; the upper plane is one period above.
    low: f64,
    /// Open edges on the lower plane and on the upper plane, each given by two corners [m].
    edges: [Vec<Edge>; 2],
}

/// Coordinates of a point [m] as bits, which serve as a key of a hash table: equal points have equal keys.
fn bits(point: &Vector3<f64>) -> [u64; 3] {
    // adding 0 turns -0 into 0, which is the same coordinate
    [point.x, point.y, point.z].map(|value| (value + 0.0).to_bits())
}

impl OpenEnds {
    /// Finds the open edges at the two ends of a surface along an axis. `None` if the length of the surface is not one
    /// period, or if one of its ends has no open edges.
    fn of(heap: &[[Vector3<f64>; 3]], axis: usize, period: f64) -> Option<Self> {
        let coordinates = || heap.iter().flatten().map(|corner| corner[axis]);
        let (low, high) =
            (coordinates().fold(f64::INFINITY, f64::min), coordinates().fold(f64::NEG_INFINITY, f64::max));
        let near = |a: f64, b: f64| (a - b).abs() <= SAME * period;
        if !near(high - low, period) {
            return None;
        }
        let open = open_edges(heap);
        let on = |plane: f64| {
            let lies = |edge: &&Edge| edge.iter().all(|corner| near(corner[axis], plane));
            open.iter().filter(lies).copied().collect::<Vec<_>>()
        };
        let edges = [on(low), on(high)];
        edges.iter().all(|edges| !edges.is_empty()).then_some(Self { axis, period, low, edges })
    }

    /// Table that contains, for each corner on the upper plane, the matching corner on the lower plane, if there is
    /// one. Every corner must lie on an edge of the other plane after a shift by one period; otherwise the result is an
    /// error.
    fn matched(&self) -> Result<FxHashMap<[u64; 3], Vector3<f64>>, Mismatch> {
        let shift = Vector3::from_fn(|k, _| if k == self.axis { self.period } else { 0.0 });
        let upper: Vec<Edge> = self.edges[1].iter().map(|edge| edge.map(|corner| corner - shift)).collect();
        let step = farthest(&self.edges[0], &upper).max(farthest(&upper, &self.edges[0]));
        if step > SAME * self.period {
            return Err(Mismatch { axis: self.axis, step });
        }
        let mut lower: Vec<Vector3<f64>> = self.edges[0].iter().flatten().copied().collect();
        let across = (self.axis + 1) % 3;
        lower.sort_unstable_by(|a, b| a[across].total_cmp(&b[across]));
        let mut same = FxHashMap::default();
        for corner in self.edges[1].iter().flatten() {
            let moved = corner - shift;
            let tolerance = SAME * self.period;
            let from = lower.partition_point(|other| other[across] < moved[across] - tolerance);
            let near = lower[from..].iter().take_while(|other| other[across] <= moved[across] + tolerance);
            let found = near.filter(|other| (*other - moved).norm() <= 2.0 * tolerance);
            if let Some(other) = found.min_by(|a, b| (*a - moved).norm().total_cmp(&(*b - moved).norm())) {
                same.insert(bits(corner), *other);
            }
        }
        Ok(same)
    }
}

/// Key of an edge, which does not depend on the order of its two corners. Both triangles of an edge have the same key.
fn key(edge: &Edge) -> [[u64; 3]; 2] {
    let mut key = edge.map(|corner| bits(&corner));
    key.sort_unstable();
    key
}

/// Edges that belong to only one triangle, each given by its corners [m].
fn open_edges(heap: &[[Vector3<f64>; 3]]) -> Vec<Edge> {
    let mut edges: FxHashMap<[[u64; 3]; 2], (usize, Edge)> = FxHashMap::default();
    for triangle in heap {
        for k in 0..3 {
            let edge = [triangle[k], triangle[(k + 1) % 3]];
            edges.entry(key(&edge)).or_insert((0, edge)).0 += 1;
        }
    }
    // the edges are sorted, so that their order does not depend on the hash table
    let mut open: Vec<_> = edges.into_iter().filter(|(_, (count, _))| *count == 1).collect();
    open.sort_unstable_by_key(|(key, _)| *key);
    open.into_iter().map(|(_, (_, edge))| edge).collect()
}

/// [m] largest distance of any corner of `edges` from the edge of `others` that is nearest to this corner.
fn farthest(edges: &[Edge], others: &[Edge]) -> f64 {
    let corners: FxHashSet<[u64; 3]> = others.iter().flatten().map(bits).collect();
    let alone = edges.iter().flatten().filter(|corner| !corners.contains(&bits(corner)));
    let distance = |corner: &Vector3<f64>| {
        let to = |[from, to]: &Edge| {
            let along = to - from;
            let share = ((corner - from).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
            (corner - (from + share * along)).norm()
        };
        others.iter().map(to).fold(f64::INFINITY, f64::min)
    };
    alone.map(distance).fold(0.0, f64::max)
}

/// Adds copies, shifted by one period, of the triangles within `margin` [m] of the two planes at the ends of the
/// surface. A corner on the upper plane gets the coordinates of the matching corner on the lower plane, plus exactly
/// one period.
fn continue_along(heap: &mut TriangleList, sides: &OpenEnds, same: &FxHashMap<[u64; 3], Vector3<f64>>, margin: f64) {
    let (axis, period) = (sides.axis, sides.period);
    let shifted = |corner: &Vector3<f64>| {
        let mut moved = *corner;
        moved[axis] += period;
        moved
    };
    let lower = |corner: &Vector3<f64>| same.get(&bits(corner)).copied();
    let own = heap.len();
    let (mut above, mut below) = (Vec::new(), Vec::new());
    for triangle in &heap[..own] {
        let coordinates = triangle.map(|corner| corner[axis] - sides.low);
        // an upper corner with a matching lower corner gets exactly the coordinates of the lower corner
        let down = |corner: &Vector3<f64>| {
            lower(corner).unwrap_or_else(|| {
                let mut moved = *corner;
                moved[axis] -= period;
                moved
            })
        };
        if coordinates.iter().any(|x| *x <= margin) {
            above.push(triangle.map(|corner| shifted(&corner)));
        }
        if coordinates.iter().any(|x| *x >= period - margin) {
            below.push(triangle.map(|corner| down(&corner)));
        }
    }
    for corner in heap.iter_mut().flatten() {
        if let Some(other) = lower(corner) {
            *corner = shifted(&other);
        }
    }
    heap.extend(above);
    heap.extend(below);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes a floor of 4 by 4 squares, each of two triangles, over 8 by 6 m; `height` returns the height [m] at a
    /// corner.
    fn floor(height: impl Fn(f64, f64) -> f64) -> TriangleList {
        let at = |i: u32, k: u32| {
            let (x, z) = (2.0 * f64::from(i), 1.5 * f64::from(k));
            Vector3::new(x, height(x, z), z)
        };
        let square = |i: u32, k: u32| {
            let [a, b, c, d] = [at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)];
            [[a, c, b], [a, d, c]]
        };
        (0..4).flat_map(|i| (0..4).flat_map(move |k| square(i, k))).collect()
    }

    #[test]
    fn a_floor_that_matches_is_continued_without_a_seam() {
        let bumpy = |x: f64, z: f64| 0.3 * (x * std::f64::consts::TAU / 8.0).sin() + 0.1 * (z % 6.0);
        let heap = floor(|x, z| bumpy(x % 8.0, z));
        let found = continued(&heap, [Some(8.0), None, Some(6.0)], 2.0).unwrap();
        assert_eq!(found.spans, [true, false, true]);
        // the remaining open edges lie on the rim of the continued floor
        let [low, high] = [Vector3::new(-2.0, 0.0, -3.0), Vector3::new(10.0, 0.0, 9.0)];
        let around =
            |corner: &Vector3<f64>| [0, 2].iter().any(|&k| corner[k] <= low[k] + 1e-9 || corner[k] >= high[k] - 1e-9);
        let open = open_edges(&found.heap);
        assert!(!open.is_empty() && open.iter().flatten().all(around), "{open:?}");
        assert!(found.heap.len() > heap.len());
        assert_eq!(found.joined, 16);
    }

    #[test]
    fn a_step_is_measured_and_other_surfaces_are_left_alone() {
        let tilted = floor(|x, _| 0.01 * x);
        let step = continued(&tilted, [Some(8.0), None, None], 2.0).unwrap_err();
        assert!(step.axis == 0 && (step.step - 0.08).abs() < 1e-12, "{step:?}");
        let found = continued(&tilted, [None, None, Some(6.0)], 2.0).unwrap();
        assert_eq!(found.spans, [false, false, true]);
        // this surface is shorter than the period
        let found = continued(&tilted, [Some(9.0), None, None], 2.0).unwrap();
        assert_eq!((found.spans, found.heap.len()), ([false; 3], tilted.len()));
    }
}
