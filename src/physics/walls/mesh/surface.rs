//! Surface made from a list of triangles. Corners with the same coordinates are merged, and bad triangles are counted
//! and removed. Neighbouring triangles are found and made to face the same way.

use super::nesting::{Nested, face_particles};
use super::orientation::face_alike;
use nalgebra::Vector3;
use rustc_hash::{FxHashMap, FxHashSet};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// [-] height of a triangle divided by its longest edge. A triangle with a smaller ratio counts as degenerate, because
/// rounding in the computation would determine its normal. Corners from a file in single precision have a larger
/// relative rounding of 6e-8, which this limit does not cover.
const THINNEST: f64 = 1e-9;
/// [-] largest depth at which the common edge of two triangles counts as flat, over the longest edge of both. It is the
/// depth, below the plane of the first triangle, of the corner that only the second triangle has. At larger depths a
/// sphere can touch the common edge without touching a face, so the edge is tested for touch. Flatter edges need no
/// test, because triangles are enlarged by [`COVER`](super::sweep::COVER).
const SHARP: f64 = 1e-12;

/// Side of the surface on which the particles are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sides {
    /// Particles are outside a closed surface: a solid body.
    Outside,
    /// Particles are inside a closed surface: a container.
    Inside,
    /// Particles are on both sides of a thin sheet, which may be open.
    Both,
}

/// Defects found in a list of triangles. Triangles are numbered from 1, in the order of the file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Findings {
    /// Number of triangles in the list that was given.
    pub given: usize,
    /// Triangles without area, which are removed: how many they are, and the number of the first.
    pub degenerate: (usize, usize),
    /// Triangles with the same corners as an earlier triangle, which are removed: how many they are, and the number of
    /// the first.
    pub duplicate: (usize, usize),
    /// Triangles that faced the opposite way to their neighbours, and are flipped: how many they are, and the number of
    /// the first.
    pub turned: (usize, usize),
    /// True if a closed part (connected group of triangles) that should face outwards faced inwards, and was flipped.
    /// A part should face outwards if it lies inside an even number of other parts, or inside none.
    pub inside_out: bool,
    /// Closed parts of the surface that lie inside other parts.
    pub nested: Nested,
    /// Number of edges that belong to only one triangle. The surface is open at these edges.
    pub open_edges: usize,
    /// Number of edges at which more than two triangles meet.
    pub crowded_edges: usize,
    /// Number of edges whose triangles cannot be made to face the same way.
    pub twisted_edges: usize,
}

impl Findings {
    /// True if the surface is closed, so that it has an inside and an outside.
    pub fn is_closed(&self) -> bool {
        self.open_edges + self.crowded_edges + self.twisted_edges == 0
    }
}

/// Reason why triangles do not form a wall.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// A coordinate of a corner is not a finite number.
    #[error("{count} of its {given} triangles have corners that are not finite numbers, the first is triangle {first}")]
    NotFinite {
        /// Number of triangles with a coordinate that is not a finite number.
        count: usize,
        /// Number of triangles in the list.
        given: usize,
        /// Number of the first triangle with a coordinate that is not a finite number, counted from 1.
        first: usize,
    },
    /// All triangles are degenerate, so there is no surface.
    #[error("it has no triangles with an area ({given} were given)")]
    Empty {
        /// Number of triangles in the list.
        given: usize,
    },
    /// The surface is not closed, so it has no inside, but the case (input file) requires an inside.
    #[error(
        "it is not watertight, so it has no inside and no outside: {} of its edges belong to one triangle only, {} to more than two, and \
         at {} the triangles cannot face the same way", .0.open_edges, .0.crowded_edges, .0.twisted_edges
    )]
    NotClosed(Findings),
}

/// One triangle of a surface, with data on the neighbouring triangles.
#[derive(Clone, Debug)]
pub struct Face {
    /// Indices of the corners, counter-clockwise seen from the particles.
    pub corners: [u32; 3],
    /// [-] unit normal towards the particles. The normal of a sheet points to one of its two sides.
    pub normal: Vector3<f64>,
    /// [-] unit vector for each edge, in the plane of the triangle, perpendicular to the edge and pointing inwards.
    pub inward: [Vector3<f64>; 3],
    /// Ranges of indices in [`TriangleSurface::ways`], one for each edge. The unit vectors in a range point from the
    /// edge into the neighbouring triangles.
    pub beyond: [Range<u32>; 3],
    /// [-] pseudo-normal of each edge: the sum of the normals of the triangles that meet at the edge.
    pub at_edge: [Vector3<f64>; 3],
    /// Bit mask of the edges (bits 0 to 2) and corners (bits 3 to 5) that are tested for touch together with this
    /// triangle. A sphere can touch each of them without touching a face. Each edge or corner is tested with one
    /// triangle only.
    pub own: u8,
    /// [m] length of the longest edge of the triangle.
    pub longest: f64,
}

/// A surface of triangles, each with data on its neighbours.
#[derive(Clone, Debug)]
pub struct TriangleSurface {
    /// [m] corner points of the triangles.
    pub points: Vec<Vector3<f64>>,
    /// Triangles of the surface, with data on their neighbours.
    pub faces: Vec<Face>,
    /// [-] unit vectors perpendicular to edges. The vectors of an edge point into the triangles beyond the edge, in the
    /// planes of these triangles.
    pub ways: Vec<Vector3<f64>>,
    /// [-] pseudo-normal of each point: the sum of the normals of the triangles that meet at the point, weighted by
    /// their angles.
    pub at_point: Vec<Vector3<f64>>,
    /// Ranges of indices in `beside`: the neighbouring points of point p are `beside[from_point[p] .. from_point[p +
    /// 1]]`.
    pub from_point: Vec<u32>,
    /// Neighbouring points of all points, one group after another: those of point p are at the range that
    /// [`from_point`](Self::from_point) gives.
    pub beside: Vec<u32>,
}

/// Triangles, each given by three point indices and the number of the triangle in the file.
pub(super) type Numbered = Vec<([u32; 3], usize)>;

/// Table of the triangles at each edge. The key is the two point indices of the edge in ascending order. The value
/// lists the index of each triangle with the number of the edge in that triangle.
pub(super) type Edges = FxHashMap<[u32; 2], Vec<(u32, usize)>>;

impl TriangleSurface {
    /// Makes a surface of triangles, given by their corners [m]. With `None` for `sides`, a closed surface is a solid
    /// body, and an open surface is a thin sheet. Also returns the side of the particles and the defects that were
    /// found.
    ///
    /// # Errors
    /// If the triangles do not form a surface, or if `sides` requires an inside and the surface has none.
    pub fn new(heap: &[[Vector3<f64>; 3]], sides: Option<Sides>) -> Result<(Self, Sides, Findings), Fault> {
        let mut findings = Findings { given: heap.len(), ..Findings::default() };
        refuse_not_finite(heap)?;
        let (points, mut triangles) = weld(heap, &mut findings);
        if triangles.is_empty() {
            return Err(Fault::Empty { given: heap.len() });
        }
        let edges = edges(&triangles);
        findings.open_edges = edges.values().filter(|there| there.len() == 1).count();
        findings.crowded_edges = edges.values().filter(|there| there.len() > 2).count();
        face_alike(&mut triangles, &edges, &mut findings);
        let sides = match sides {
            Some(Sides::Both) => Sides::Both,
            Some(_) if !findings.is_closed() => return Err(Fault::NotClosed(findings)),
            Some(sides) => sides,
            None if findings.is_closed() => Sides::Outside,
            None => Sides::Both,
        };
        if sides != Sides::Both {
            face_particles(&points, &mut triangles, &edges, sides, &mut findings);
        }
        let corners: Vec<[u32; 3]> = triangles.into_iter().map(|(corners, _)| corners).collect();
        Ok((Self::connect(points, &corners, sides), sides, findings))
    }

    /// Computes data of triangles, edges and corners, from which contacts are found: normals, neighbours, and edges to
    /// be tested.
    fn connect(points: Vec<Vector3<f64>>, corners: &[[u32; 3]], sides: Sides) -> Self {
        let mut faces: Vec<Face> = corners.iter().map(|corners| plain(&points, *corners)).collect();
        let numbered: Numbered = corners.iter().map(|corners| (*corners, 0)).collect();
        let edges = edges(&numbered);
        let (mut ways, mut sharp_points) = (Vec::new(), FxHashSet::default());
        for face in 0..faces.len() {
            for edge in 0..3 {
                let key = key(&faces[face].corners, edge);
                let there = &edges[&key];
                let first = ways.len() as u32;
                let others = || there.iter().filter(|(other, _)| *other as usize != face);
                ways.extend(others().map(|&(other, of)| faces[other as usize].inward[of]));
                faces[face].beyond[edge] = first..ways.len() as u32;
                faces[face].at_edge[edge] = there.iter().map(|&(other, _)| faces[other as usize].normal).sum();
                let own = is_sharp(&points, &faces, there, sides);
                if own {
                    sharp_points.extend(key);
                }
                if own && there.iter().all(|(other, _)| *other as usize >= face) {
                    faces[face].own |= 1 << edge;
                }
            }
        }
        for face in &mut faces {
            for corner in 0..3 {
                if sharp_points.remove(&face.corners[corner]) {
                    face.own |= 8 << corner;
                }
            }
        }
        let (at_point, from_point, beside) = around_points(&points, &faces);
        Self { points, faces, ways, at_point, from_point, beside }
    }

    /// True if the surface is connected: edges lead from each point to all others.
    pub fn is_one_part(&self) -> bool {
        let mut seen = vec![false; self.points.len()];
        let mut waiting = vec![0];
        while let Some(point) = waiting.pop() {
            if std::mem::replace(&mut seen[point], true) {
                continue;
            }
            let beside = self.from_point[point] as usize..self.from_point[point + 1] as usize;
            waiting.extend(self.beside[beside].iter().map(|other| *other as usize));
        }
        seen.into_iter().all(|seen| seen)
    }

    /// [m] corners of the triangle with the index `face`.
    #[inline]
    pub fn corners(&self, face: usize) -> [Vector3<f64>; 3] {
        self.faces[face].corners.map(|corner| self.points[corner as usize])
    }
}

fn refuse_not_finite(heap: &[[Vector3<f64>; 3]]) -> Result<(), Fault> {
    let bad = |triangle: &[Vector3<f64>; 3]| !triangle.iter().flatten().all(|value| value.is_finite());
    let mut numbers = heap.iter().enumerate().filter(|(_, triangle)| bad(triangle)).map(|(k, _)| k + 1);
    match numbers.next() {
        None => Ok(()),
        Some(first) => Err(Fault::NotFinite { count: 1 + numbers.count(), given: heap.len(), first }),
    }
}

/// Adds one to the count of a defect, the first number of `found`. If it is the first such defect, stores the number
/// `number` of its triangle as the second number.
pub(super) fn count(found: &mut (usize, usize), number: usize) {
    *found = (found.0 + 1, if found.0 == 0 { number } else { found.1 });
}

/// Merges corners of triangles that have the same coordinates. Returns the points, and the triangles: three point
/// indices, and the number of the triangle in the file. Degenerate and duplicate triangles are left out and counted.
fn weld(heap: &[[Vector3<f64>; 3]], findings: &mut Findings) -> (Vec<Vector3<f64>>, Numbered) {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    let mut known: FxHashMap<[u64; 3], u32> = FxHashMap::default();
    let mut seen = FxHashSet::default();
    for (k, triangle) in heap.iter().enumerate() {
        let [a, b, c] = triangle;
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        if (b - a).cross(&(c - a)).norm() <= THINNEST * longest * longest {
            count(&mut findings.degenerate, k + 1);
            continue;
        }
        let corners = triangle.map(|point| {
            // adding 0 turns -0 into 0, which is the same coordinate
            let bits = [point.x, point.y, point.z].map(|value| (value + 0.0).to_bits());
            *known.entry(bits).or_insert_with(|| {
                points.push(point);
                points.len() as u32 - 1
            })
        });
        let mut sorted = corners;
        sorted.sort_unstable();
        if seen.insert(sorted) {
            triangles.push((corners, k + 1));
        } else {
            count(&mut findings.duplicate, k + 1);
        }
    }
    (points, triangles)
}

/// Indices of the two end points of edge number `edge` (0 to 2) of a triangle, in ascending order.
fn key(corners: &[u32; 3], edge: usize) -> [u32; 2] {
    let (a, b) = (corners[edge], corners[(edge + 1) % 3]);
    [a.min(b), a.max(b)]
}

fn edges(triangles: &[([u32; 3], usize)]) -> Edges {
    let mut edges = Edges::default();
    for (k, (corners, _)) in triangles.iter().enumerate() {
        for edge in 0..3 {
            edges.entry(key(corners, edge)).or_default().push((k as u32, edge));
        }
    }
    edges
}

/// Makes the data of one triangle. The data on its neighbours stay empty for now.
fn plain(points: &[Vector3<f64>], corners: [u32; 3]) -> Face {
    let at = corners.map(|corner| points[corner as usize]);
    let normal = (at[1] - at[0]).cross(&(at[2] - at[0])).normalize();
    let along = |edge: usize| at[(edge + 1) % 3] - at[edge];
    Face {
        corners,
        normal,
        inward: std::array::from_fn(|edge| normal.cross(&along(edge)).normalize()),
        beyond: [0..0, 0..0, 0..0],
        at_edge: [normal; 3],
        own: 0,
        longest: (0..3).map(|edge| along(edge).norm()).fold(0.0, f64::max),
    }
}

/// True if a sphere can touch an edge without touching the face of one of its triangles. `there` lists these triangles.
/// False for an edge at which the surface is flat, or concave as seen from the particles.
fn is_sharp(points: &[Vector3<f64>], faces: &[Face], there: &[(u32, usize)], sides: Sides) -> bool {
    let [(a, of_a), (b, of_b)] = there[..] else { return true };
    let (face, other) = (&faces[a as usize], &faces[b as usize]);
    let from = points[face.corners[of_a] as usize];
    let height = face.normal.dot(&(points[other.corners[(of_b + 2) % 3] as usize] - from));
    let least = SHARP * face.longest.max(other.longest);
    match sides {
        Sides::Both => height.abs() > least,
        Sides::Inside | Sides::Outside => height < -least,
    }
}

/// Computes the pseudo-normals of all points, and the lists of neighbouring points as [`TriangleSurface`] stores them.
fn around_points(points: &[Vector3<f64>], faces: &[Face]) -> (Vec<Vector3<f64>>, Vec<u32>, Vec<u32>) {
    let mut normals = vec![Vector3::zeros(); points.len()];
    let mut beside: Vec<Vec<u32>> = vec![Vec::new(); points.len()];
    for face in faces {
        for corner in 0..3 {
            let [here, next, last] = [0, 1, 2].map(|k| face.corners[(corner + k) % 3]);
            let to = |other: u32| points[other as usize] - points[here as usize];
            normals[here as usize] += face.normal * to(next).angle(&to(last));
            beside[here as usize].extend([next, last]);
        }
    }
    let (mut from, mut list) = (vec![0], Vec::new());
    for mut others in beside {
        others.sort_unstable();
        others.dedup();
        list.extend(others);
        from.push(list.len() as u32);
    }
    (normals, from, list)
}
