//! Walls made of triangles: nearest points, contacts with spheres and times of touch.
//!
//! A sphere can have a contact at each local minimum of the distance from its centre to the surface. The minimum lies
//! inside a triangle, on an edge or at a corner. If several minima lie in nearly the same direction from the centre,
//! only the nearest is a contact. This rule excludes seams between triangles and the far side of a thin plate. In a
//! corner the directions differ, so each minimum is a contact.

mod clearance;
mod nesting;
mod orientation;
mod periods;
mod surface;
mod sweep;
mod tree;

pub use nesting::Nested;
pub use periods::{Continued, Mismatch, continued};
pub use surface::{Fault, Findings, Sides};

use super::plane::is_along;
use super::{Drawing, Flight, Geometry, Nearest, Touch};
use clearance::Clearance;
use nalgebra::Vector3;
use rustc_hash::FxHasher;
use serde::{Serialize, Serializer};
use std::cell::Cell;
use std::fmt;
use std::hash::Hasher;
use surface::TriangleSurface;
pub(super) use tree::Tree;
use tree::{TriangleFeature, on_triangle};

/// [-] cosine of 20 degrees, the smallest angle between the directions of two contacts of one sphere. The value is a
/// choice of this program: the angles at seams of finely meshed round surfaces are smaller, those in corners of vessels
/// are larger.
const APART: f64 = 0.939_692_620_785_908_4;
/// [-] cosine of 10 degrees. If all normals of a surface lie within this angle of one direction, a sphere has only one
/// contact with the surface.
const HALF_APART: f64 = 0.984_807_753_012_208;
/// Largest number of contacts of one sphere with a mesh: three contacts hold a sphere at rest.
const MOST: u32 = 3;
/// [-] distance from the centre of a sphere within which contacts are searched, over the radius of the sphere. The
/// number exceeds 1, because the times at which a contact begins or ends require exact values of small positive gaps.
const REACH: f64 = 1.25;
/// [-] ratio of two lengths that counts as rounding: smaller lengths are treated as zero.
const ROUNDING: f64 = 1e-9;

/// A wall made of triangles.
#[derive(Clone)]
pub struct Mesh {
    name: String,
    sides: Sides,
    contacts: u32,
    surface: TriangleSurface,
    tree: Tree,
    clearance: Clearance,
    /// Number of triangles of the surface itself. They come first in the list, and the copies of triangles beyond
    /// periodic sides follow.
    own: usize,
    /// True for each axis along which the surface continues without end through periodic sides.
    spans: [bool; 3],
    /// [m] lowest and highest corner of the box around the triangles of the surface itself, without copies.
    bounds: [Vector3<f64>; 2],
}

/// Point of one triangle that is nearest to a given point.
#[derive(Clone, Copy)]
struct TrianglePoint {
    /// [m] distance between the given point and the point of the triangle, never negative.
    distance: f64,
    /// [-] unit vector from the point of the triangle to the given point.
    direction: Vector3<f64>,
    /// True if the surface is closed and the given point is behind the triangle, on the side without particles.
    behind: bool,
    face: u32,
    feature: TriangleFeature,
}

impl TrianglePoint {
    fn nearest(&self) -> Nearest {
        let sign = if self.behind { -1.0 } else { 1.0 };
        Nearest { distance: sign * self.distance, normal: self.direction * sign }
    }
}

impl Mesh {
    /// Makes a wall of triangles, given by their corners [m]; `name` is the name of the wall in results. With `None`
    /// for `sides`, a closed surface is a solid body, and an open surface is a thin sheet with particles on both
    /// sides. Also returns the defects of the triangles. Degenerate and duplicate triangles are removed, and wrongly
    /// facing triangles flipped. Edges with one triangle or with more than two remain, and so do edges whose triangles
    /// cannot face the same way.
    ///
    /// # Errors
    /// If the triangles do not form a wall of this type.
    pub fn new(name: &str, heap: &[[Vector3<f64>; 3]], sides: Option<Sides>) -> Result<(Self, Findings), Fault> {
        let (surface, sides, findings) = TriangleSurface::new(heap, sides)?;
        let all = || (0..surface.faces.len()).map(|face| surface.corners(face));
        let (tree, clearance) = (Tree::new(all()), Clearance::new(all()));
        let sum: Vector3<f64> = surface.faces.iter().map(|face| face.normal).sum();
        let flat = sum
            .try_normalize(0.0)
            .is_some_and(|mean| surface.faces.iter().all(|face| face.normal.dot(&mean) > HALF_APART));
        // a sphere between two parallel sheets has one contact with each, so a single contact requires a connected
        // surface
        let contacts = if flat && surface.is_one_part() { 1 } else { MOST };
        let (name, own, bounds) = (name.to_owned(), surface.faces.len(), clearance.bounds());
        let mut mesh = Self { name, sides, contacts, surface, tree, clearance, own, spans: [false; 3], bounds };
        let mut clearance = mesh.clearance.clone();
        clearance.find_free(sides != Sides::Inside, |point| mesh.nearest(point).distance > 0.0);
        mesh.clearance = clearance;
        Ok((mesh, findings))
    }

    /// Makes a sheet that continues through periodic sides, together with the copies of its triangles beyond these
    /// sides. For a surface that does not continue, the result is that of [`new`](Self::new). The second result
    /// contains the defects of the surface itself, without its copies.
    ///
    /// # Errors
    /// If the triangles do not form a wall of this type.
    pub fn without_end(
        name: &str,
        heap: &[[Vector3<f64>; 3]],
        sides: Option<Sides>,
        continued: &Continued,
    ) -> Result<(Self, Findings), Fault> {
        let (single, mut findings) = Self::new(name, heap, sides)?;
        if !continued.spans.contains(&true) {
            return Ok((single, findings));
        }
        let (own, spans, bounds) = (single.surface.faces.len(), continued.spans, single.bounds);
        findings.open_edges -= continued.joined.min(findings.open_edges);
        let (whole, _) = Self::new(name, &continued.heap, Some(single.sides))?;
        Ok((Self { own, spans, bounds, ..whole }, findings))
    }

    /// True for the axes along which the surface continues without end, through periodic sides.
    pub fn spans(&self) -> [bool; 3] {
        self.spans
    }

    /// Side of the surface on which the particles are: outside, inside or both.
    pub fn sides(&self) -> Sides {
        self.sides
    }

    /// [m] lowest and highest corner of the smallest box around the surface.
    pub fn bounds(&self) -> [Vector3<f64>; 2] {
        self.bounds
    }

    /// [m³] volume inside a closed surface. It is the sum over the triangles of one sixth of the triple product of the
    /// three corner vectors.
    pub fn volume(&self) -> f64 {
        let [from, _] = self.bounds();
        let corners = self.corners().map(|corners| corners.map(|corner| corner - from));
        corners.map(|[a, b, c]| a.dot(&b.cross(&c))).sum::<f64>().abs() / 6.0
    }

    /// [m] three corners of each triangle.
    pub(super) fn corners(&self) -> impl Iterator<Item = [Vector3<f64>; 3]> + '_ {
        (0..self.surface.faces.len()).map(|face| self.surface.corners(face))
    }

    /// Unit normal of each triangle, towards the particles.
    pub fn normals(&self) -> impl Iterator<Item = &Vector3<f64>> {
        self.surface.faces.iter().map(|face| &face.normal)
    }

    /// Corner points [m], and the indices of the three corners of each triangle of the surface itself.
    pub fn triangles(&self) -> (&[Vector3<f64>], impl ExactSizeIterator<Item = [u32; 3]> + '_) {
        (&self.surface.points, self.surface.faces[..self.own].iter().map(|face| face.corners))
    }

    /// Point of the triangle with the index `number` that is nearest to `point` [m].
    fn spot(&self, number: u32, point: &Vector3<f64>) -> TrianglePoint {
        let face = &self.surface.faces[number as usize];
        let corners = self.surface.corners(number as usize);
        let (nearest, feature) = on_triangle(&corners, point);
        let (away, out) = match feature {
            TriangleFeature::Face => {
                // the height is computed from the plane of the triangle, so that all triangles of a flat floor give
                // exactly the same height
                let height = face.normal.dot(&(point - corners[0]));
                (height.abs(), if height < 0.0 { -face.normal } else { face.normal })
            }
            TriangleFeature::Edge(_) | TriangleFeature::Corner(_) => {
                let out = point - nearest;
                let away = out.norm();
                (away, if away > 0.0 { out / away } else { face.normal })
            }
        };
        let outwards = match feature {
            TriangleFeature::Face => &face.normal,
            TriangleFeature::Edge(edge) => &face.at_edge[edge],
            TriangleFeature::Corner(corner) => &self.surface.at_point[face.corners[corner] as usize],
        };
        let behind = self.sides != Sides::Both && out.dot(outwards) < 0.0;
        TrianglePoint { distance: away, direction: out, behind, face: number, feature }
    }

    /// True if the distance from the sphere's centre has a local minimum at `spot`: all neighbouring points of the
    /// surface are farther from the centre.
    fn is_least(&self, spot: &TrianglePoint) -> bool {
        let (surface, face) = (&self.surface, &self.surface.faces[spot.face as usize]);
        match spot.feature {
            TriangleFeature::Face => true,
            TriangleFeature::Edge(edge) => {
                let beyond = face.beyond[edge].start as usize..face.beyond[edge].end as usize;
                surface.ways[beyond].iter().all(|way| way.dot(&spot.direction) <= ROUNDING)
            }
            TriangleFeature::Corner(corner) => {
                let here = face.corners[corner] as usize;
                let beside = surface.from_point[here] as usize..surface.from_point[here + 1] as usize;
                let way = |other: &u32| surface.points[*other as usize] - surface.points[here];
                surface.beside[beside].iter().map(way).all(|way| way.dot(&spot.direction) <= ROUNDING * way.norm())
            }
        }
    }

    /// Point of the surface nearest to `point` [m], if its distance is at most `reach` [m]; otherwise `None`. If
    /// several triangles are equally near, the triangle with the lowest index is used.
    fn first(&self, point: &Vector3<f64>, reach: f64) -> Option<TrianglePoint> {
        let first: Cell<Option<TrianglePoint>> = Cell::new(None);
        let least = || first.get().map_or(reach, |first| first.distance);
        // no point of a triangle is nearer than the plane of the triangle
        let plane = |face: u32| {
            let corner = self.surface.corners(face as usize)[0];
            self.surface.faces[face as usize].normal.dot(&(point - corner)).abs()
        };
        self.tree.closest(point, reach * (1.0 + ROUNDING), |face| {
            if plane(face) <= least() * (1.0 + ROUNDING) {
                let spot = self.spot(face, point);
                if spot.distance <= least() {
                    let earlier = first.get().filter(|first| first.distance == spot.distance && first.face < spot.face);
                    first.set(Some(earlier.unwrap_or(spot)));
                }
            }
            // rounding is added to the limit, so that triangles at the same distance are tested too
            least() * (1.0 + ROUNDING)
        });
        first.get()
    }

    /// True if all triangles within `reach` [m] of `point` [m] have nearly equal normals, so that a sphere has at most
    /// one contact there. For a sheet with particles on both sides the result is always false. The point of a closed
    /// surface nearest to `point` may also lie on an edge or corner. The direction from there to `point` is then
    /// between the normals of the adjacent triangles, and the test includes these triangles.
    fn is_smooth(&self, point: &Vector3<f64>, reach: f64) -> bool {
        let mut normals = self.tree.within(point, reach).map(|face| &self.surface.faces[face as usize].normal);
        let first = normals.next();
        self.sides != Sides::Both && first.is_none_or(|first| normals.all(|normal| normal.dot(first) > HALF_APART))
    }

    /// All contacts of a sphere with the mesh, the nearest first. The centre of the sphere is at `point` [m], and
    /// contacts farther than `reach` [m] from it are left out.
    fn all(&self, point: &Vector3<f64>, reach: f64) -> Vec<TrianglePoint> {
        let spots = self.tree.within(point, reach).map(|face| self.spot(face, point));
        let mut spots: Vec<TrianglePoint> =
            spots.filter(|spot| spot.distance <= reach && self.is_least(spot)).collect();
        spots.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.face.cmp(&b.face)));
        let mut kept: Vec<TrianglePoint> = Vec::new();
        for spot in spots {
            // a point seen from behind lies on the far side of a plate, unless it is the nearest point: then the
            // sphere's centre has passed through the surface
            let other_side = spot.behind && !kept.is_empty();
            if !other_side && kept.iter().all(|other| other.direction.dot(&spot.direction) <= APART) {
                kept.push(spot);
            }
        }
        kept
    }
}

impl Geometry for Mesh {
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let closest = self.tree.closest(point, f64::MAX, |face| self.spot(face, point).distance);
        // a mesh has at least one triangle, so this value is never returned
        let none = Nearest { distance: f64::INFINITY, normal: Vector3::y() };
        closest.map_or(none, |(face, _)| self.spot(face, point).nearest())
    }

    fn touch_time(&self, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
        self.sweep(flight, radius, until).map(|touch| touch.time)
    }

    fn contacts(&self) -> u32 {
        self.contacts
    }

    /// [-] largest jump |n - n'| of the normal of a contact from one triangle to the next, for any mesh. If the normals
    /// n and n' differ more, the triangles form two contacts: |n - n'|² = 2 - 2 n·n'.
    fn seam(&self) -> f64 {
        (2.0 - 2.0 * APART).sqrt()
    }

    /// Returns the nearest point of contact number `which` to the centre `point` [m] of a sphere. If there is no such
    /// contact within `REACH` radii, the distance is `REACH` radii and the normal is zero.
    fn contact(&self, which: u32, point: &Vector3<f64>, radius: f64) -> Nearest {
        let reach = REACH * radius;
        let found = if self.clearance.least(point) > reach {
            None
        } else if which == 0 {
            self.first(point, reach)
        } else if self.is_smooth(point, reach) {
            None
        } else {
            self.all(point, reach).get(which as usize).copied()
        };
        found.map_or(Nearest { distance: reach, normal: Vector3::zeros() }, |spot| spot.nearest())
    }

    /// Returns the first touch with any part of the surface if `which` is 0, and `None` for the other contact numbers.
    /// So each touch is found once.
    fn first_touch(&self, which: u32, flight: &Flight, radius: f64, until: f64) -> Option<Touch> {
        if which == 0 { self.sweep(flight, radius, until) } else { None }
    }

    fn struck(&self, _which: u32, feature: u32, point: &Vector3<f64>, _radius: f64) -> Nearest {
        self.at(feature, point)
    }

    fn may_touch(&self, _which: u32, _point: &Vector3<f64>, _radius: f64, _skin: f64) -> bool {
        true
    }

    fn is_thin(&self) -> bool {
        true
    }

    fn is_clear(&self, point: &Vector3<f64>, distance: f64) -> bool {
        self.clearance.is_free(point) && self.clearance.least(point) > distance
    }

    fn is_within(&self, point: &Vector3<f64>, distance: f64) -> bool {
        self.clearance.least(point) <= distance && self.tree.is_near(point, distance)
    }

    fn is_nearest_first(&self) -> bool {
        true
    }

    fn slides(&self, velocity: &Vector3<f64>) -> bool {
        self.normals().all(|normal| is_along(velocity, normal))
    }

    fn bounds(&self) -> Option<[Vector3<f64>; 2]> {
        (self.sides != Sides::Inside).then_some(self.bounds)
    }

    fn extent(&self) -> Option<[Vector3<f64>; 2]> {
        Some(self.bounds)
    }

    fn room_corners(&self) -> Option<[Vector3<f64>; 2]> {
        (self.sides == Sides::Inside).then_some(self.bounds)
    }

    fn holds_along(&self, _axis: usize) -> bool {
        self.sides == Sides::Inside
    }

    fn vessel_volume(&self, _size: &Vector3<f64>) -> Option<f64> {
        (self.sides == Sides::Inside).then(|| self.volume())
    }

    fn has_inside(&self) -> bool {
        self.sides != Sides::Outside
    }

    fn encloses(&self, point: &Vector3<f64>) -> bool {
        self.has_inside() && self.surrounds(point)
    }

    fn in_words(&self) -> String {
        let side = match self.sides {
            Sides::Outside => "solid body",
            Sides::Inside => "vessel with the particles inside",
            Sides::Both => "thin sheet",
        };
        let through = ["x", "y", "z"].into_iter().zip(self.spans()).filter(|(_, spans)| *spans);
        let through: Vec<&str> = through.map(|(name, _)| name).collect();
        let without_end = match through.is_empty() {
            true => String::new(),
            false => format!(", without end along {}", through.join(" and ")),
        };
        format!("{side} of {} triangles{without_end}", self.surface.faces.len())
    }

    fn drawing(&self, _size: &Vector3<f64>) -> Drawing {
        let (points, triangles) = self.triangles();
        (points.to_vec(), triangles.collect())
    }
}

impl fmt::Debug for Mesh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([low, high], count) = (self.bounds(), self.surface.faces.len());
        write!(f, "mesh {} of {count} triangles, {:?}, from {low:?} to {high:?}", self.name, self.sides)
    }
}

/// Writes data that identify the mesh (name, sides, number of triangles, checksum), for comparisons of scenes. A mesh
/// cannot be restored from these data.
impl Serialize for Mesh {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut hasher = FxHasher::default();
        for face in 0..self.surface.faces.len() {
            self.surface.corners(face).iter().flatten().for_each(|value| hasher.write_u64(value.to_bits()));
        }
        (&self.name, self.sides, self.surface.faces.len(), hasher.finish()).serialize(serializer)
    }
}
