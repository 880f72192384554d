//! Time at which a sphere touches a thin round shell.
//!
//! Spheres slide along a shell in ever smaller and slower bounces, with flights nearly along the shell. Conservative
//! advancement makes steps as long as the gap, so it would need too many steps for such flights. If `STEPS` steps do
//! not suffice, the time of touch is found as the root of a polynomial.

use super::{Flight, Frustum, Geometry, Nearest, advancement, polynomial};
use nalgebra::{Vector2, Vector3};

/// Number of steps of conservative advancement (steps in which the sphere certainly touches nothing). This method is
/// tried first, because it is faster for flights that are not along the shell.
const STEPS: usize = 100;
/// [-] largest gap or overlap, at a root of the polynomials, that counts as a touch. It is divided by the radius of the
/// sphere plus the distance of its centre from the centre of the shell.
const NEAR: f64 = 1e-9;

/// [s] time of touch as [`Geometry::touch_time`] defines it, for a thin shell. `None` without a touch until `until`
/// [s].
pub(super) fn touch_time(shell: &Frustum, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
    advancement::within(shell, flight, radius, (until, STEPS))
        .unwrap_or_else(|| first_root(shell, flight, radius, until))
}

/// [s] first root of the polynomials at which the sphere touches the shell; `None` if there is none.
fn first_root(shell: &Frustum, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
    let course = FlightAcrossShell::new(shell, flight);
    let length = course.from.norm() + radius;
    let mut roots: Vec<f64> =
        [-radius, radius].into_iter().flat_map(|aside| course.side(shell, aside, until)).collect();
    let ends = [(shell.radii[0], -shell.half_height), (shell.radii[1], shell.half_height)];
    roots.extend(ends.into_iter().flat_map(|end| course.rim(end, radius, until)));
    roots.sort_unstable_by(f64::total_cmp);
    roots.into_iter().find_map(|root| {
        let Nearest { distance, normal } = shell.nearest(&flight.position_at(root));
        let velocity = flight.velocity_at(root);
        let (gap, rate) = (distance - radius, velocity.dot(&normal));
        // excludes spheres that move away, and roots beyond the rims, where the polynomial has roots but the shell has
        // ended
        if gap.abs() > NEAR * length || rate > NEAR * velocity.norm() {
            return None;
        }
        // the polynomial of a rim has degree eight; one Newton step removes the rounding error of its root
        let step = if rate < -NEAR * velocity.norm() { gap / rate } else { 0.0 };
        let better = (root - step).clamp(0.0, until);
        let closer = (shell.nearest(&flight.position_at(better)).distance - radius).abs() < gap.abs();
        Some(if closer { better } else { root })
    })
}

/// Flight of a sphere's centre relative to a thin round shell, described by the distance from the axis of the shell
/// and the coordinate along the axis, as polynomials in time.
struct FlightAcrossShell {
    from: Vector3<f64>,
    /// [m², m²/s, ...] coefficients of the squared distance from the axis as a polynomial in time.
    out: [f64; 5],
    /// [m, m/s, ...] coefficients of the coordinate along the axis as a polynomial in time.
    along: [f64; 3],
    /// [m/s] speed of the centre at the beginning of the flight.
    speed: f64,
}

impl FlightAcrossShell {
    fn new(shell: &Frustum, flight: &Flight) -> Self {
        let axle = &shell.axle;
        let from = flight.position - axle.center;
        let [p, q, g] = [from, flight.velocity, flight.gravity].map(|vector| axle.across(&vector));
        let out = [p.norm_squared(), 2.0 * p.dot(&q), q.norm_squared() + p.dot(&g), q.dot(&g), 0.25 * g.norm_squared()];
        let along = [from[axle.axis], flight.velocity[axle.axis], 0.5 * flight.gravity[axle.axis]];
        Self { from, out, along, speed: flight.velocity.norm() }
    }

    /// [s] times at which the centre reaches the side of the shell, shifted outwards by `aside` [m] (inwards if
    /// negative). At these times the distance ρ from the axis falls or rises to (c + aside - n_z z)/n_ρ. Here c is the
    /// distance of the side from the centre of the shell, n its outward normal, and z the coordinate along the axis.
    fn side(&self, shell: &Frustum, aside: f64, until: f64) -> Vec<f64> {
        let out: Vector2<f64> = shell.out();
        let offset = shell.outline().last().map_or(0.0, |end| end.dot(&out)) + aside;
        let [z, w, a] = self.along;
        let may = [(offset - out.y * z) / out.x, -out.y * w / out.x, -out.y * a / out.x];
        let sign = if aside < 0.0 { 1.0 } else { -1.0 };
        let mut way = self.out.to_vec();
        times(&may, &may).iter().zip(&mut way).for_each(|(square, way)| *way -= square);
        way.iter_mut().for_each(|way| *way *= sign);
        let size = self.out[0].sqrt() + may[0].abs();
        self.rises(&way, size, until)
    }

    /// [s] times at which the distance of the centre from a rim falls to r = `radius` [m]. The rim is a circle about
    /// the axis, given by its radius R [m] and its coordinate along the axis [m]. Let ρ be the distance of the centre
    /// from the axis, z that from the plane of the rim, and d² = ρ² + z². At a touch 4 R² ρ² rises to (d² + R² - r²)².
    /// For R = 0 the rim is a point.
    fn rim(&self, (rim, at): (f64, f64), radius: f64, until: f64) -> Vec<f64> {
        let along = [self.along[0] - at, self.along[1], self.along[2]];
        let mut apart = self.out.to_vec();
        times(&along, &along).iter().zip(&mut apart).for_each(|(square, apart)| *apart += square);
        if rim == 0.0 {
            apart[0] -= radius * radius;
            let way: Vec<f64> = apart.iter().map(|c| -c).collect();
            return self.rises(&way, self.out[0].sqrt() + along[0].abs(), until);
        }
        apart[0] += rim * rim - radius * radius;
        let mut way: Vec<f64> = times(&apart, &apart).iter().map(|c| -c).collect();
        self.out.iter().zip(&mut way).for_each(|(out, way)| *way += 4.0 * rim * rim * out);
        // division by 4 R² gives the polynomial the unit of a squared length, as in `side`
        way.iter_mut().for_each(|way| *way /= 4.0 * rim * rim);
        self.rises(&way, rim + self.out[0].sqrt() + along[0].abs(), until)
    }

    /// [s] all times up to `until` [s] at which a polynomial in time rises to zero. The values of the polynomial are
    /// squared lengths of the order of `size`² [m²]. The polynomial may be zero at time 0, up to positive rounding
    /// errors. Time 0 is then a result if the polynomial rises there, and later times are found as if the polynomial
    /// fell from zero at time 0.
    fn rises(&self, way: &[f64], size: f64, until: f64) -> Vec<f64> {
        let mut way = way.to_vec();
        let resolution = 16.0 * f64::EPSILON * size * self.speed;
        let mut found = Vec::new();
        if way[0].abs() <= NEAR * size * size && way[0] >= 0.0 {
            if way[1] > resolution {
                found.push(0.0);
            }
            way[0] = 0.0;
            way[1] = way[1].min(-resolution);
        }
        found.extend(polynomial::rises(&way, until));
        found
    }
}

/// Product of two polynomials, given by their coefficients.
fn times(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; a.len() + b.len() - 1];
    for (i, a) in a.iter().enumerate() {
        b.iter().enumerate().for_each(|(k, b)| product[i + k] += a * b);
    }
    product
}
