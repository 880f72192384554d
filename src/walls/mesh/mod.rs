//! Walls of triangles: their nearest points, their contacts with a sphere, and the instants of touch.
//!
//! A sphere has one contact at each point where the surface is nearer to its centre than all around: inside a
//! triangle, on an edge or at a corner. Points in nearly the same direction from the centre are one contact, the
//! nearest. So a seam between triangles is no contact, and neither is the far side of a thin plate. In a corner the
//! directions differ, and there is a contact for each.

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

/// [-] cosine of 20 degrees, the angle from which two directions are two contacts. A rule of this program: seams of a
/// round surface are flatter in fine meshes, and corners of vessels are sharper.
const APART: f64 = 0.939_692_620_785_908_4;
/// [-] cosine of 10 degrees: a mesh whose normals are all so near to one direction has one contact only.
const HALF_APART: f64 = 0.984_807_753_012_208;
/// Largest number of contacts of one sphere: it rests on three points.
const MOST: u32 = 3;
/// [-] distance from the centre within which contacts are searched, over the radius. Gaps near zero must be exact, so
/// that the instant at which a contact begins or ends can be found.
const REACH: f64 = 1.25;
/// [-] of the distance: a shorter step of the centre towards a neighbour is rounding.
const ROUNDING: f64 = 1e-9;

/// A surface of triangles.
#[derive(Clone)]
pub struct Mesh {
    name: String,
    sides: Sides,
    contacts: u32,
    surface: TriangleSurface,
    tree: Tree,
    clearance: Clearance,
    /// Number of triangles of the surface itself; those after them continue it beyond periodic sides.
    own: usize,
    /// Axes along which the surface is endless.
    spans: [bool; 3],
    /// [m] corners of the box around the triangles of the surface itself.
    bounds: [Vector3<f64>; 2],
}

/// The nearest point of one triangle, seen from a point.
#[derive(Clone, Copy)]
struct TrianglePoint {
    /// [m] distance, never negative.
    distance: f64,
    /// [-] unit vector from the surface to the point.
    direction: Vector3<f64>,
    /// True if the point is behind a closed surface.
    behind: bool,
    face: u32,
    place: TriangleFeature,
}

impl TrianglePoint {
    fn nearest(&self) -> Nearest {
        let sign = if self.behind { -1.0 } else { 1.0 };
        Nearest { distance: sign * self.distance, normal: self.direction * sign }
    }
}

impl Mesh {
    /// A wall of triangles, given by their corners [m]; `name` is its name in results. Without `sides` a closed
    /// surface is a solid body, and an open one a thin sheet with particles on both sides. Also returns the defects
    /// of the triangles that were found and corrected.
    ///
    /// # Errors
    /// If the triangles make no such wall.
    pub fn new(name: &str, heap: &[[Vector3<f64>; 3]], sides: Option<Sides>) -> Result<(Self, Findings), Fault> {
        let (surface, sides, findings) = TriangleSurface::new(heap, sides)?;
        let all = || (0..surface.faces.len()).map(|face| surface.corners(face));
        let (tree, clearance) = (Tree::new(all()), Clearance::new(all()));
        let sum: Vector3<f64> = surface.faces.iter().map(|face| face.normal).sum();
        let flat = sum
            .try_normalize(0.0)
            .is_some_and(|mean| surface.faces.iter().all(|face| face.normal.dot(&mean) > HALF_APART));
        // a sphere between two sheets has a contact on either side
        let contacts = if flat && surface.is_one_part() { 1 } else { MOST };
        let (name, own, bounds) = (name.to_owned(), surface.faces.len(), clearance.bounds());
        let mut mesh = Self { name, sides, contacts, surface, tree, clearance, own, spans: [false; 3], bounds };
        let mut clearance = mesh.clearance.clone();
        clearance.find_free(sides != Sides::Inside, |point| mesh.nearest(point).distance > 0.0);
        mesh.clearance = clearance;
        Ok((mesh, findings))
    }

    /// A sheet that continues through periodic sides, with the copies that continue it there; otherwise as
    /// [`new`](Self::new). The findings are those of the surface itself.
    ///
    /// # Errors
    /// If the triangles make no such wall.
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

    /// Axes along which the surface is endless, through periodic sides.
    pub fn spans(&self) -> [bool; 3] {
        self.spans
    }

    /// Sides of the surface on which particles are.
    pub fn sides(&self) -> Sides {
        self.sides
    }

    /// [m] corners of the smallest box around the surface.
    pub fn bounds(&self) -> [Vector3<f64>; 2] {
        self.bounds
    }

    /// [m³] volume inside a closed surface: six times the volume of a tetrahedron is the triple product of its edges.
    pub fn volume(&self) -> f64 {
        let [from, _] = self.bounds();
        let corners = self.corners().map(|corners| corners.map(|corner| corner - from));
        corners.map(|[a, b, c]| a.dot(&b.cross(&c))).sum::<f64>().abs() / 6.0
    }

    /// [m] corners of the triangles.
    pub(super) fn corners(&self) -> impl Iterator<Item = [Vector3<f64>; 3]> + '_ {
        (0..self.surface.faces.len()).map(|face| self.surface.corners(face))
    }

    /// Unit normals of the triangles.
    pub fn normals(&self) -> impl Iterator<Item = &Vector3<f64>> {
        self.surface.faces.iter().map(|face| &face.normal)
    }

    /// Points [m], and three point indices for each triangle of the surface itself.
    pub fn triangles(&self) -> (&[Vector3<f64>], impl ExactSizeIterator<Item = [u32; 3]> + '_) {
        (&self.surface.points, self.surface.faces[..self.own].iter().map(|face| face.corners))
    }

    /// The nearest point of a triangle.
    fn spot(&self, number: u32, point: &Vector3<f64>) -> TrianglePoint {
        let face = &self.surface.faces[number as usize];
        let corners = self.surface.corners(number as usize);
        let (nearest, place) = on_triangle(&corners, point);
        let (away, out) = match place {
            TriangleFeature::Face => {
                // along the normal, as for a plane: a whole floor of triangles then gives identical bits
                let height = face.normal.dot(&(point - corners[0]));
                (height.abs(), if height < 0.0 { -face.normal } else { face.normal })
            }
            TriangleFeature::Edge(_) | TriangleFeature::Corner(_) => {
                let out = point - nearest;
                let away = out.norm();
                (away, if away > 0.0 { out / away } else { face.normal })
            }
        };
        let outwards = match place {
            TriangleFeature::Face => &face.normal,
            TriangleFeature::Edge(edge) => &face.at_edge[edge],
            TriangleFeature::Corner(corner) => &self.surface.at_point[face.corners[corner] as usize],
        };
        let behind = self.sides != Sides::Both && out.dot(outwards) < 0.0;
        TrianglePoint { distance: away, direction: out, behind, face: number, place }
    }

    /// True if the point is a local minimum of the distance: all of the surface next to it is further from the centre of
    /// the sphere.
    fn is_least(&self, spot: &TrianglePoint) -> bool {
        let (surface, face) = (&self.surface, &self.surface.faces[spot.face as usize]);
        match spot.place {
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

    /// The nearest point of the surface within `reach` [m]; of equally near ones, that on the first triangle.
    fn first(&self, point: &Vector3<f64>, reach: f64) -> Option<TrianglePoint> {
        let first: Cell<Option<TrianglePoint>> = Cell::new(None);
        let least = || first.get().map_or(reach, |first| first.distance);
        // no point of a triangle is nearer than its plane
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
            // so that equally near triangles are tested too
            least() * (1.0 + ROUNDING)
        });
        first.get()
    }

    /// True if all of the surface within `reach` [m] faces nearly one way, so that there is at most one contact.
    /// Around an edge or a corner of a closed surface that is the nearest point, directions lie between the normals
    /// of the triangles that meet there, all of which are within reach.
    fn is_smooth(&self, point: &Vector3<f64>, reach: f64) -> bool {
        let mut normals = self.tree.within(point, reach).map(|face| &self.surface.faces[face as usize].normal);
        let first = normals.next();
        self.sides != Sides::Both && first.is_none_or(|first| normals.all(|normal| normal.dot(first) > HALF_APART))
    }

    /// Contacts within `reach` [m], from the nearest on.
    fn all(&self, point: &Vector3<f64>, reach: f64) -> Vec<TrianglePoint> {
        let spots = self.tree.within(point, reach).map(|face| self.spot(face, point));
        let mut spots: Vec<TrianglePoint> =
            spots.filter(|spot| spot.distance <= reach && self.is_least(spot)).collect();
        spots.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.face.cmp(&b.face)));
        let mut kept: Vec<TrianglePoint> = Vec::new();
        for spot in spots {
            // seen from behind it is the other side of a plate, except for the surface that the point itself has
            // passed
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
        // there is at least one triangle
        let none = Nearest { distance: f64::INFINITY, normal: Vector3::y() };
        closest.map_or(none, |(face, _)| self.spot(face, point).nearest())
    }

    fn touch_time(&self, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
        self.sweep(flight, radius, until).map(|touch| touch.time)
    }

    fn contacts(&self) -> u32 {
        self.contacts
    }

    /// Largest jump of the normal between two triangles that are one contact: |n - n'|² = 2 - 2 n·n'.
    fn seam(&self) -> f64 {
        (2.0 - 2.0 * APART).sqrt()
    }

    /// Beyond `REACH` radii there is no contact: the distance is then set to `REACH` radii, and the normal to zero.
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

    /// The first contact is the touch with any part of the surface.
    fn first_touch(&self, which: u32, flight: &Flight, radius: f64, until: f64) -> Option<Touch> {
        if which == 0 { self.sweep(flight, radius, until) } else { None }
    }

    fn struck(&self, _which: u32, place: u32, point: &Vector3<f64>, _radius: f64) -> Nearest {
        self.at(place, point)
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

/// Identification of the mesh: written where scenes are compared, and never read back.
impl Serialize for Mesh {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut hasher = FxHasher::default();
        for face in 0..self.surface.faces.len() {
            self.surface.corners(face).iter().flatten().for_each(|value| hasher.write_u64(value.to_bits()));
        }
        (&self.name, self.sides, self.surface.faces.len(), hasher.finish()).serialize(serializer)
    }
}
