//! Time at which a flying sphere touches a surface of triangles. At a touch, the centre of the sphere reaches a plane
//! above a face, a cylinder about an edge, or a sphere about a corner.
//!
//! For each triangle, its face is tested together with the edges and corners in the bit mask [`Face::own`]. Edges at
//! which the surface is flat or concave need no test: faces are slightly enlarged there, so that no gap is left
//! between them.

use super::surface::{Face, Sides};
use super::tree::TriangleFeature;
use super::{Mesh, Nearest};
use crate::walls::{Flight, Touch, convex, first_touch};
use nalgebra::Vector3;

/// [-] width by which a triangle is enlarged at each edge, over the longest edge of the triangle.
pub(super) const COVER: f64 = 1e-10;
/// [-] overlap over the radius of the sphere. A smaller overlap is taken as a rounding error at a touch.
const TOUCHING: f64 = 1e-9;

/// Number of a surface feature: it encodes the index of a triangle, and its face, one of its edges or one of its
/// corners.
fn numbered(face: u32, feature: TriangleFeature) -> u32 {
    face * 8
        + match feature {
            TriangleFeature::Face => 0,
            TriangleFeature::Edge(edge) => 1 + edge as u32,
            TriangleFeature::Corner(corner) => 4 + corner as u32,
        }
}

impl Mesh {
    /// First touch of a sphere of `radius` [m] within the time `until` [s], with the number of the touched face, edge
    /// or corner; `None` without a touch.
    pub(super) fn sweep(&self, flight: &Flight, radius: f64, until: f64) -> Option<Touch> {
        let end = flight.position_at(until);
        // largest distance between the path of a falling sphere and the straight line between the ends of the path
        let sag = 0.125 * flight.gravity.norm() * until * until;
        let reach = (radius + sag) * (1.0 + TOUCHING);
        let way = (end - flight.position).norm();
        if self.clearance.least(&flight.position) > way + reach {
            return None;
        }
        let mut first: Option<Touch> = None;
        self.tree.for_each_along(&flight.position, &end, reach, |face| {
            let least = first.map_or(until, |touch| touch.time);
            self.touches(face, flight, radius, least, |time, feature| {
                let feature = numbered(face, feature);
                // the earlier of two touches; at equal times the touch with the lower number, so that runs are
                // repeatable
                if first.is_none_or(|touch| (time, feature) < (touch.time, touch.feature)) {
                    first = Some(Touch { time, feature });
                }
            });
        });
        first
    }

    /// Distance [m] and normal of `point` [m] relative to a face, edge or corner, given by its number as [`numbered`]
    /// computes it.
    pub(super) fn at(&self, number: u32, point: &Vector3<f64>) -> Nearest {
        let face = &self.surface.faces[number as usize / 8];
        let corner = |k: u32| self.surface.points[face.corners[k as usize % 3] as usize];
        let out = match number % 8 {
            0 => {
                let height = face.normal.dot(&(point - corner(0)));
                let side = if height < 0.0 && self.sides == Sides::Both { -1.0 } else { 1.0 };
                return Nearest { distance: side * height, normal: face.normal * side };
            }
            k @ 1..=3 => {
                let along = (corner(k) - corner(k - 1)).normalize();
                let out = point - corner(k - 1);
                out - along * out.dot(&along)
            }
            k => point - corner(k - 4),
        };
        let distance = out.norm();
        Nearest { distance, normal: if distance > 0.0 { out / distance } else { face.normal } }
    }

    /// Calls `visit` for each touch of a sphere and the triangle with the index `number` up to `until` [s]. The
    /// arguments of `visit` are the time [s], and the touched face, edge or corner.
    fn touches(
        &self,
        number: u32,
        flight: &Flight,
        radius: f64,
        until: f64,
        mut visit: impl FnMut(f64, TriangleFeature),
    ) {
        let face = &self.surface.faces[number as usize];
        let corners = self.surface.corners(number as usize);
        let front = on_face(&face.normal, (face, &corners), flight, radius, until);
        let back = (self.sides == Sides::Both).then(|| on_face(&-face.normal, (face, &corners), flight, radius, until));
        for time in [front, back.flatten()].into_iter().flatten() {
            visit(time, TriangleFeature::Face);
        }
        if face.own == 0 {
            return;
        }
        let falls = flight.gravity != Vector3::zeros();
        for k in 0..3 {
            if face.own & 1 << k != 0 {
                let ends = [corners[k], corners[(k + 1) % 3]];
                let time = if falls { on_bar(ends, flight, radius, until) } else { on_edge(ends, flight, radius) };
                if let Some((time, end)) = time.filter(|(time, _)| *time <= until) {
                    visit(time, end.map_or(TriangleFeature::Edge(k), |end| TriangleFeature::Corner((k + end) % 3)));
                }
            }
            // with gravity, the test of an edge includes its end points, so corners are not tested separately
            if !falls && face.own & 8 << k != 0 {
                let apart = flight.position - corners[k];
                let time = first_touch(&apart, &flight.velocity, radius, flight.velocity.norm());
                if let Some(time) = time.filter(|time| *time <= until) {
                    visit(time, TriangleFeature::Corner(k));
                }
            }
        }
    }
}

/// [s] time at which a sphere touches the face of a triangle from the side of the normal; `None` if the sphere does not
/// touch the face until `until` [s].
fn on_face(
    normal: &Vector3<f64>,
    (face, corners): (&Face, &[Vector3<f64>; 3]),
    flight: &Flight,
    radius: f64,
    until: f64,
) -> Option<f64> {
    let height = normal.dot(&(flight.position - corners[0]));
    let gap = height - radius;
    let speed = flight.velocity.dot(normal);
    let fall = flight.gravity.dot(normal);
    if gap > 0.0 && speed >= 0.0 && fall >= 0.0 {
        return None;
    }
    let covers = |time: f64| (time <= until && is_above(face, corners, &flight.position_at(time))).then_some(time);
    // an approach slower than the rounding of the velocity is ignored
    let approaches = speed < -4.0 * f64::EPSILON * flight.velocity.norm();
    if gap <= 0.0 && height > 0.0 && approaches && covers(0.0).is_some() {
        return Some(0.0);
    }
    let touches = gap.abs() <= TOUCHING * radius;
    let (gap, speed) = if gap <= 0.0 && touches { (0.0, speed.max(0.0)) } else { (gap, speed) };
    covers(way_down(gap, speed, fall)?)
}

/// [s] first time t > 0 at which the distance `gap` + `speed` t + `fall` t²/2 falls from positive to negative values;
/// `None` if it never does. The arguments are in m, m/s and m/s².
fn way_down(gap: f64, speed: f64, fall: f64) -> Option<f64> {
    let discriminant = speed * speed - 2.0 * fall * gap;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    if speed < 0.0 && gap > 0.0 {
        // the nearer root, in a form without cancellation
        Some(2.0 * gap / (root - speed))
    } else if fall < 0.0 && speed + root >= 0.0 {
        Some((speed + root) / -fall)
    } else {
        None
    }
}

/// True if the projection of a point [m] onto the plane of a triangle lies inside the slightly enlarged triangle.
fn is_above(face: &Face, corners: &[Vector3<f64>; 3], point: &Vector3<f64>) -> bool {
    let least = -COVER * face.longest;
    face.inward.iter().zip(corners).all(|(inward, corner)| inward.dot(&(point - corner)) >= least)
}

/// [s] time at which a sphere in straight flight touches the edge between two points [m]; `None` if it does not.
/// Touches of the end points are not found. The second value is always `None`; it exists because [`on_bar`] returns a
/// pair.
fn on_edge([from, to]: [Vector3<f64>; 2], flight: &Flight, radius: f64) -> Option<(f64, Option<usize>)> {
    let length = (to - from).norm();
    let along = (to - from) / length;
    let apart = flight.position - from;
    let (at, pace) = (apart.dot(&along), flight.velocity.dot(&along));
    let (across, velocity) = (apart - along * at, flight.velocity - along * pace);
    let time = first_touch(&across, &velocity, radius, flight.velocity.norm())?;
    let position = at + pace * time;
    (0.0..=length).contains(&position).then_some((time, None))
}

/// [s] time at which a sphere in flight with gravity touches the edge between two points [m] of a convex part of the
/// surface. The end points are included. If the sphere touches an end point, the number of this point (0 or 1) is also
/// returned. `None` without a touch until `until` [s].
fn on_bar(ends: [Vector3<f64>; 2], flight: &Flight, radius: f64, until: f64) -> Option<(f64, Option<usize>)> {
    let along = ends[1] - ends[0];
    let share = |point: &Vector3<f64>| ((point - ends[0]).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
    let nearest = |point: &Vector3<f64>| {
        let share = share(point);
        let out = if share == 1.0 { point - ends[1] } else { point - (ends[0] + along * share) };
        let distance = out.norm();
        Nearest { distance, normal: if distance > 0.0 { out / distance } else { Vector3::y() } }
    };
    let time = convex::touch_time(nearest, flight, radius, until)?;
    let share = share(&flight.position_at(time));
    let end = if share == 0.0 { Some(0) } else { (share == 1.0).then_some(1) };
    Some((time, end))
}
