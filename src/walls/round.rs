//! Round walls about an axis of the domain: truncated cones, solid or as thin shells, and the inner sides of pipes and
//! cones.

use super::drawing::turned;
use super::{Drawing, Flight, Geometry, Nearest, Touch, convex, polynomial, shell};
use nalgebra::{Vector2, Vector3};
use serde::Serialize;

/// [-] over the radius: distance returned for a side that a sphere cannot touch, beyond the distance of a touch.
const OUT_OF_SIGHT: f64 = 1.25;

/// An axis along x, y or z, with which points are given by their distance from the axis and their coordinate along
/// it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RoundAxis {
    /// [m] a point of the axis.
    pub center: Vector3<f64>,
    /// Axis number 0, 1 or 2: x, y, z.
    pub axis: usize,
}

impl RoundAxis {
    /// [m] distance from the axis and coordinate along it.
    fn seen(&self, point: &Vector3<f64>) -> Vector2<f64> {
        let from = point - self.center;
        Vector2::new(self.across(&from).norm(), from[self.axis])
    }

    /// Component of a vector across the axis.
    pub(super) fn across(&self, vector: &Vector3<f64>) -> Vector3<f64> {
        let mut across = *vector;
        across[self.axis] = 0.0;
        across
    }

    /// Turns a direction of the half-plane through `point` [m] into one in space. On the axis itself any outward
    /// direction will do.
    fn in_space(&self, direction: &Vector2<f64>, point: &Vector3<f64>) -> Vector3<f64> {
        let any = Vector3::from_fn(|k, _| if k == (self.axis + 1) % 3 { 1.0 } else { 0.0 });
        let mut vector = self.across(&(point - self.center)).try_normalize(0.0).unwrap_or(any) * direction.x;
        vector[self.axis] = direction.y;
        vector
    }
}

/// The inner side of a pipe or cone without ends: particles are at radii below r + s z, with z along the axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tube {
    /// Axis of the tube.
    pub axle: RoundAxis,
    /// [m] radius r at the centre of the axis.
    pub radius: f64,
    /// [-] growth s of the radius along the axis; 0 for a pipe.
    pub slope: f64,
}

impl Geometry for Tube {
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let seen = self.axle.seen(point);
        let length = 1.0f64.hypot(self.slope);
        let distance = (self.radius + self.slope * seen.y - seen.x) / length;
        Nearest { distance, normal: self.axle.in_space(&(Vector2::new(-1.0, self.slope) / length), point) }
    }

    /// The centre moves at ρ(t) = |p + q t + α t²/2| and may come up to ρ = a + b t + c t²/2. The touch is the first
    /// root of a polynomial. It is of second degree where the flight is straight across the axis (for cones:
    /// altogether straight), otherwise of fourth degree. For a sphere that slides down a cone the bounces become ever
    /// smaller and slower. Conservative advancement would need more steps for them than it has.
    fn touch_time(&self, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
        let curved = if self.slope == 0.0 { self.axle.across(&flight.gravity) } else { flight.gravity };
        let from = flight.position - self.axle.center;
        let (p, q) = (self.axle.across(&from), self.axle.across(&flight.velocity));
        let (z, w) = (from[self.axle.axis], flight.velocity[self.axle.axis]);
        let a = self.radius + self.slope * z - radius * 1.0f64.hypot(self.slope);
        let b = self.slope * w;
        let speed = q.norm() + b.abs();
        let resolution = 4.0 * f64::EPSILON * (p.norm() + a.abs()) * speed;
        if curved != Vector3::zeros() {
            let (alpha, c) = (self.axle.across(&flight.gravity), self.slope * flight.gravity[self.axle.axis]);
            let way = [
                p.norm_squared() - a * a,
                2.0 * (p.dot(&q) - a * b),
                q.norm_squared() + p.dot(&alpha) - b * b - a * c,
                q.dot(&alpha) - b * c,
                0.25 * (alpha.norm_squared() - c * c),
            ];
            return polynomial::way_out(&way, 2.0 * resolution, until);
        }
        first_way_out(q.norm_squared() - b * b, p.dot(&q) - a * b, p.norm_squared() - a * a, resolution)
            .filter(|t| *t <= until)
    }
}

/// The side of a pipe or cone across the axis from the nearest point. A sphere as wide as the pipe touches both sides
/// at once. The two contacts together press it towards the axis in proportion to its distance from it; the nearest
/// point alone would throw it from side to side.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OppositeTube(pub Tube);

impl Geometry for OppositeTube {
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let Tube { axle, radius, slope } = self.0;
        let (seen, length) = (axle.seen(point), 1.0f64.hypot(slope));
        let distance = (radius + slope * seen.y + seen.x) / length;
        Nearest { distance, normal: axle.in_space(&(Vector2::new(1.0, slope) / length), point) }
    }

    /// Returns `None`: a sphere reaches the near side first, and this one at the same instant only on the axis.
    fn touch_time(&self, _flight: &Flight, _radius: f64, _until: f64) -> Option<f64> {
        None
    }
}

/// The inner side of a sphere.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bowl {
    /// [m]
    pub center: Vector3<f64>,
    /// [m]
    pub radius: f64,
}

impl Geometry for Bowl {
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let from = point - self.center;
        let distance = from.norm();
        // from the centre every direction is as short
        let normal = if distance > 0.0 { from / -distance } else { Vector3::y() };
        Nearest { distance: self.radius - distance, normal }
    }

    /// The centre moves at |p + q t + g t²/2| and may come up to the radius of the bowl less that of the sphere. The
    /// touch is the first root of a polynomial, of second degree on straight flights and of fourth on others.
    fn touch_time(&self, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
        let (p, q, g) = (flight.position - self.center, flight.velocity, flight.gravity);
        let reach = self.radius - radius;
        let resolution = 4.0 * f64::EPSILON * (p.norm() + reach.abs()) * q.norm();
        if g != Vector3::zeros() {
            let way = [
                p.norm_squared() - reach * reach,
                2.0 * p.dot(&q),
                q.norm_squared() + p.dot(&g),
                q.dot(&g),
                0.25 * g.norm_squared(),
            ];
            return polynomial::way_out(&way, 2.0 * resolution, until);
        }
        first_way_out(q.norm_squared(), p.dot(&q), p.norm_squared() - reach * reach, resolution).filter(|t| *t <= until)
    }
}

/// The point of a hollow sphere across the centre from the nearest one, as [`OppositeTube`] for a tube.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OppositeBowl(pub Bowl);

impl Geometry for OppositeBowl {
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let Nearest { distance, normal } = self.0.nearest(point);
        Nearest { distance: 2.0 * self.0.radius - distance, normal: -normal }
    }

    /// Returns `None`, as for [`OppositeTube`].
    fn touch_time(&self, _flight: &Flight, _radius: f64, _until: f64) -> Option<f64> {
        None
    }
}

/// [s] first t >= 0 at which a t² + 2 b t + c, negative while a centre is free, becomes positive. At a touch (c = 0
/// up to rounding) it is 0 if b is positive by more than its `resolution`. If b is negative by as much, it is the
/// time to cross to the other side. A sphere that slides along the wall touches as soon as its approach can be
/// resolved.
fn first_way_out(a: f64, b: f64, c: f64, resolution: f64) -> Option<f64> {
    if c >= 0.0 {
        return if b > resolution {
            Some(0.0)
        } else if a <= 0.0 {
            None
        } else if b < -resolution {
            Some(-2.0 * b / a)
        } else {
            Some((2.0 * resolution - b) / a)
        };
    }
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return None;
    }
    // the two roots in a form without cancellation
    let q = -(b + discriminant.sqrt().copysign(b));
    [q / a, c / q].into_iter().filter(|t| *t > 0.0 && t.is_finite()).reduce(f64::min)
}

/// A truncated cone, or a cylinder: a solid body, or a thin shell that is open at both ends and has particles on both
/// sides.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Frustum {
    /// Axis of the body; the centre is half-way between the ends.
    pub axle: RoundAxis,
    /// [m] radii at the lower and the upper end.
    pub radii: [f64; 2],
    /// [m] half the distance of the ends.
    pub half_height: f64,
    /// True if the body is solid.
    pub solid: bool,
}

impl Frustum {
    /// [m] outline in the half-plane, from the lower end of the axis to the upper; for a shell the side alone.
    pub fn outline(&self) -> Vec<Vector2<f64>> {
        let side = [Vector2::new(self.radii[0], -self.half_height), Vector2::new(self.radii[1], self.half_height)];
        if self.solid {
            vec![Vector2::new(0.0, -self.half_height), side[0], side[1], Vector2::new(0.0, self.half_height)]
        } else {
            side.to_vec()
        }
    }

    /// Outward normal of the side, in the half-plane.
    pub(super) fn out(&self) -> Vector2<f64> {
        let side = Vector2::new(self.radii[1] - self.radii[0], 2.0 * self.half_height);
        Vector2::new(side.y, -side.x) / side.norm()
    }

    /// [m] signed distances from the lower end, the side and the upper end, with the outward normals: the largest is
    /// the depth of a point inside.
    fn depths(&self, seen: &Vector2<f64>) -> [(f64, Vector2<f64>); 3] {
        let out = self.out();
        [
            (-self.half_height - seen.y, -Vector2::y()),
            ((seen - Vector2::new(self.radii[0], -self.half_height)).dot(&out), out),
            (seen.y - self.half_height, Vector2::y()),
        ]
    }

    /// The nearest point of the outline to a point, seen in the half-plane of the near side (`out` = 1) or of the
    /// opposite one (-1). In the opposite half-plane the distance from the axis is negative.
    fn nearest_of_side(&self, seen: &Vector2<f64>, out: f64, point: &Vector3<f64>) -> Nearest {
        let outline = self.outline();
        let ways = outline.windows(2).map(|ends| {
            let along = ends[1] - ends[0];
            let share = if along == Vector2::zeros() {
                0.0
            } else {
                ((seen - ends[0]).dot(&along) / along.norm_squared()).clamp(0.0, 1.0)
            };
            seen - (ends[0] + along * share)
        });
        let way = ways.reduce(|a, b| if b.norm_squared() < a.norm_squared() { b } else { a }).unwrap_or(*seen);
        let distance = way.norm();
        // on the surface itself: outwards for a body, inwards for a shell
        let rest = if self.solid { self.out() } else { -self.out() };
        let normal = if distance > 0.0 { way / distance } else { rest };
        Nearest { distance, normal: self.axle.in_space(&Vector2::new(out * normal.x, normal.y), point) }
    }
}

impl Geometry for Frustum {
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let seen = self.axle.seen(point);
        let deepest = self.depths(&seen).into_iter().reduce(|a, b| if b.0 > a.0 { b } else { a });
        if let Some((distance, out)) = deepest.filter(|(distance, _)| self.solid && *distance <= 0.0) {
            return Nearest { distance, normal: self.axle.in_space(&out, point) };
        }
        self.nearest_of_side(&seen, 1.0, point)
    }

    /// Two for a shell: the near side and the one across the axis.
    fn contacts(&self) -> u32 {
        if self.solid { 1 } else { 2 }
    }

    /// The side across the axis counts for a sphere within the shell or above its rim; outside, the near side covers
    /// it.
    fn contact(&self, which: u32, point: &Vector3<f64>, radius: f64) -> Nearest {
        let near = self.nearest(point);
        if which == 0 {
            return near;
        }
        let seen = self.axle.seen(point);
        let is_outside = self.axle.across(&(point - self.axle.center)).dot(&near.normal) > 0.0;
        if is_outside {
            return Nearest { distance: near.distance.max(OUT_OF_SIGHT * radius), normal: Vector3::zeros() };
        }
        self.nearest_of_side(&Vector2::new(-seen.x, seen.y), -1.0, point)
    }

    fn first_touch(&self, which: u32, flight: &Flight, radius: f64, until: f64) -> Option<Touch> {
        if which == 0 { self.touch_time(flight, radius, until).map(Touch::at) } else { None }
    }

    /// Uses the near side for both: the other may come into reach anywhere above the rim.
    fn may_touch(&self, _which: u32, point: &Vector3<f64>, radius: f64, skin: f64) -> bool {
        self.nearest(point).distance - radius < skin
    }

    fn is_thin(&self) -> bool {
        !self.solid
    }

    fn touch_time(&self, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
        if self.solid {
            convex::touch_time(|x| self.nearest(x), flight, radius, until)
        } else {
            shell::touch_time(self, flight, radius, until)
        }
    }

    fn is_nearest_first(&self) -> bool {
        true
    }

    fn bounds(&self) -> Option<[Vector3<f64>; 2]> {
        let radius = self.radii[0].max(self.radii[1]);
        let half = Vector3::from_fn(|k, _| if k == self.axle.axis { self.half_height } else { radius });
        Some([self.axle.center - half, self.axle.center + half])
    }

    fn has_inside(&self) -> bool {
        !self.solid
    }

    fn encloses(&self, point: &Vector3<f64>) -> bool {
        !self.solid && self.surrounds(point)
    }

    fn in_words(&self) -> String {
        if self.solid { "solid body".into() } else { "thin round shell, open at both ends".into() }
    }

    fn drawing(&self, _size: &Vector3<f64>) -> Drawing {
        turned(&self.axle, &self.outline())
    }
}
