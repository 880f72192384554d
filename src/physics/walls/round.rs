//! Walls of revolution about an axis parallel to x, y or z: truncated cones, which are solid or thin shells, and the
//! inner sides of pipes, cones and spheres.

use super::drawing::turned;
use super::{Drawing, Flight, Geometry, Nearest, Touch, Turning, convex, polynomial, shell};
use nalgebra::{Vector2, Vector3};
use serde::Serialize;

/// [-] distance of a wall's side, over the radius of the sphere, that is returned at least if the sphere cannot touch
/// this side. The number exceeds 1, so that there is no contact.
const OUT_OF_SIGHT: f64 = 1.25;

/// Axis of a round wall, parallel to x, y or z. Points are described in a half-plane bounded by this axis. Their
/// coordinates there are the distance from the axis and the coordinate along the axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RoundAxis {
    /// [m] a point of the axis.
    pub center: Vector3<f64>,
    /// Direction of the axis: 0, 1, 2 for x, y, z.
    pub axis: usize,
}

impl RoundAxis {
    /// [m] coordinates of a point in the half-plane that contains the point and is bounded by the axis: distance from
    /// the axis, and coordinate along the axis.
    fn seen(&self, point: &Vector3<f64>) -> Vector2<f64> {
        let from = point - self.center;
        Vector2::new(self.across(&from).norm(), from[self.axis])
    }

    /// Component of `vector` perpendicular to the axis of the wall.
    pub(super) fn across(&self, vector: &Vector3<f64>) -> Vector3<f64> {
        let mut across = *vector;
        across[self.axis] = 0.0;
        across
    }

    /// Converts a direction in the half-plane (outwards from the axis, along the axis) into a direction in space at
    /// `point` [m]. For a point on the axis, any direction outwards is correct.
    fn in_space(&self, direction: &Vector2<f64>, point: &Vector3<f64>) -> Vector3<f64> {
        let any = Vector3::from_fn(|k, _| if k == (self.axis + 1) % 3 { 1.0 } else { 0.0 });
        let mut vector = self.across(&(point - self.center)).try_normalize(0.0).unwrap_or(any) * direction.x;
        vector[self.axis] = direction.y;
        vector
    }
}

/// The inner side of an endless pipe or cone. Particles are at distances below r + s z from the axis. Here z is the
/// coordinate along the axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tube {
    /// Axis of the pipe or cone.
    pub axle: RoundAxis,
    /// [m] radius r at z = 0, the position of the axis point `center`.
    pub radius: f64,
    /// [-] slope s: growth of the radius per length along the axis; 0 for a pipe.
    pub slope: f64,
}

impl Geometry for Tube {
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let seen = self.axle.seen(point);
        let length = 1.0f64.hypot(self.slope);
        let distance = (self.radius + self.slope * seen.y - seen.x) / length;
        Nearest { distance, normal: self.axle.in_space(&(Vector2::new(-1.0, self.slope) / length), point) }
    }

    /// Computes the time of touch [s] as the first root of a polynomial; `None` without a touch. Let ρ(t) = |p + q t +
    /// α t²/2| be the distance of the sphere's centre from the axis. Here p, q and α are the components of position,
    /// velocity and gravity perpendicular to the axis. The sphere touches the wall when ρ = a + b t + c t²/2. This is
    /// the radius of the wall beside the centre minus sqrt(1 + s²) times the radius of the sphere, with the slope s of
    /// the wall. For a straight flight (for pipes: straight in the plane perpendicular to the axis) the degree is two,
    /// otherwise four. Conservative advancement (steps in which the sphere certainly touches nothing) would need too
    /// many steps for a sphere that slides down a cone in ever smaller bounces.
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

/// The side of a pipe or cone opposite to the nearest point. A sphere as wide as the pipe touches both sides at once.
/// Both contacts together push the sphere towards the axis, in proportion to the distance of its centre from the axis.
/// A contact at the nearest point alone would throw the sphere from side to side.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OppositeTube(pub Tube);

impl Geometry for OppositeTube {
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let Tube { axle, radius, slope } = self.0;
        let (seen, length) = (axle.seen(point), 1.0f64.hypot(slope));
        let distance = (radius + slope * seen.y + seen.x) / length;
        Nearest { distance, normal: axle.in_space(&(Vector2::new(1.0, slope) / length), point) }
    }

    /// Returns `None`: the sphere first touches the pipe or cone at the nearest point, so `Tube::touch_time` already
    /// gives the time. Only a sphere with its centre on the axis touches both sides at the same time.
    fn touch_time(&self, _flight: &Flight, _radius: f64, _until: f64) -> Option<f64> {
        None
    }
}

/// The inner side of a hollow sphere, with particles inside.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bowl {
    /// [m] centre of the sphere.
    pub center: Vector3<f64>,
    /// [m] radius of the sphere.
    pub radius: f64,
}

impl Geometry for Bowl {
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let from = point - self.center;
        let distance = from.norm();
        // at the centre, the distance to the surface is equal in all directions
        let normal = if distance > 0.0 { from / -distance } else { Vector3::y() };
        Nearest { distance: self.radius - distance, normal }
    }

    /// Computes the time of touch [s] as the first root of a polynomial; `None` without a touch. The centre of the
    /// particle is at the distance |p + q t + g t²/2| from the centre of the hollow sphere. Here p is the position
    /// relative to the centre of the hollow sphere, q the velocity, and g gravity. At a touch this distance is the
    /// radius of the hollow sphere minus that of the particle. The degree is two without gravity, and four with
    /// gravity.
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

/// The point of a hollow sphere opposite to the nearest point. It is a second contact, because a particle as wide as
/// the hollow sphere touches both points at once.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OppositeBowl(pub Bowl);

impl Geometry for OppositeBowl {
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        let Nearest { distance, normal } = self.0.nearest(point);
        Nearest { distance: 2.0 * self.0.radius - distance, normal: -normal }
    }

    /// Returns `None`: a particle inside first touches the hollow sphere at the nearest point, so `Bowl::touch_time`
    /// already gives the time. The point opposite to the nearest one is never touched earlier.
    fn touch_time(&self, _flight: &Flight, _radius: f64, _until: f64) -> Option<f64> {
        None
    }
}

/// [s] first time t >= 0 at which a sphere inside a round wall touches the wall: when a t² + 2 b t + c becomes
/// positive. `None` if there is no touch. With c >= 0 the sphere touches already. The time is then 0 if the sphere
/// moves into the wall (b > `resolution`). If the sphere moves away (b < -`resolution`), the time is that of the touch
/// on the other side. Otherwise the sphere slides along the wall, and the time is that at which a t + b reaches 2
/// `resolution`.
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
    // both roots in a form without cancellation
    let q = -(b + discriminant.sqrt().copysign(b));
    [q / a, c / q].into_iter().filter(|t| *t > 0.0 && t.is_finite()).reduce(f64::min)
}

/// A truncated cone or a cylinder. It is a solid body, or a thin shell that is open at both ends and has particles on
/// both sides.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Frustum {
    /// Axis of the body; its centre is half-way between the two ends.
    pub axle: RoundAxis,
    /// [m] radii at the lower and at the upper end.
    pub radii: [f64; 2],
    /// [m] half the distance between the ends.
    pub half_height: f64,
    /// True for a solid body; false for a thin shell that is open at both ends.
    pub solid: bool,
}

impl Frustum {
    /// [m] points of the outline, by distance from the axis and coordinate along the axis. For a solid body the outline
    /// leads from the lower end of the axis to the upper end. For a shell it is the side alone.
    pub fn outline(&self) -> Vec<Vector2<f64>> {
        let side = [Vector2::new(self.radii[0], -self.half_height), Vector2::new(self.radii[1], self.half_height)];
        if self.solid {
            vec![Vector2::new(0.0, -self.half_height), side[0], side[1], Vector2::new(0.0, self.half_height)]
        } else {
            side.to_vec()
        }
    }

    /// [-] outward unit normal of the side, by its components away from the axis and along the axis.
    pub(super) fn out(&self) -> Vector2<f64> {
        let side = Vector2::new(self.radii[1] - self.radii[0], 2.0 * self.half_height);
        Vector2::new(side.y, -side.x) / side.norm()
    }

    /// [m] signed distances of the point `seen` from the lower end, the side and the upper end, each with the outward
    /// normal. `seen` is given by distance from the axis and coordinate along the axis. Inside the body all three
    /// distances are negative, and the largest belongs to the nearest surface.
    fn depths(&self, seen: &Vector2<f64>) -> [(f64, Vector2<f64>); 3] {
        let out = self.out();
        [
            (-self.half_height - seen.y, -Vector2::y()),
            ((seen - Vector2::new(self.radii[0], -self.half_height)).dot(&out), out),
            (seen.y - self.half_height, Vector2::y()),
        ]
    }

    /// Point of the outline that is nearest to `point` [m]. `seen` [m] contains the distance of `point` from the axis
    /// and its coordinate along the axis. With `out` = 1 the point of the outline is on the same side of the axis as
    /// `point`. With `out` = -1 it is on the opposite side; the caller gives the distance in `seen` a negative sign.
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
        // normal for a point on the surface: outwards for a body, inwards for a shell
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

    /// Returns 1 for a solid body, and 2 for a shell: contacts on the near side and on the opposite side.
    fn contacts(&self) -> u32 {
        if self.solid { 1 } else { 2 }
    }

    /// Returns the nearest point of the near side (`which` = 0) or of the opposite side of a shell. The opposite side
    /// counts for a sphere inside the shell or above its rim. A sphere outside the shell cannot touch the opposite
    /// side: the distance is then at least `OUT_OF_SIGHT` radii, and the normal zero.
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

    /// Returns true if the sphere may touch the near side of the wall. The result is the same for contact 1, the
    /// opposite side of a shell, which a sphere above the rim may touch anywhere.
    fn may_touch(&self, _which: u32, point: &Vector3<f64>, radius: f64, skin: f64) -> bool {
        self.nearest(point).distance - radius < skin
    }

    fn turns(&self, turning: &Turning) -> bool {
        turning.is_axis(&self.axle.center, self.axle.axis)
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
