//! The box of a scene: its size, its periodic sides and its shear.

pub mod blocks;
mod orbit;

pub use orbit::Orbit;

use nalgebra::Vector3;
use serde::Serialize;
use std::borrow::Cow;

/// Uniform shear of a periodic box (Lees and Edwards 1972, J. Phys. C 5, 1921). The mean flow along z is U_z = γ y,
/// with the shear rate γ. Periodic images of a particle above and below the box slide along z: the image one box height
/// L_y above has the velocity γ L_y relative to the particle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Shear {
    /// [1/s] shear rate γ = dU_z/dy.
    pub rate: f64,
    /// [m] displacement along z, at time 0, of the periodic image one box height above a particle.
    pub start: f64,
    /// Orbit of the box about a distant mass, which adds the forces of a rotating frame; `None` for a box at rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orbit: Option<Orbit>,
    /// [m] displacement along z of the periodic image one box height above a particle, at the instant of this box (the
    /// argument of [`Domain::at`]). The displacement is between minus and plus half the edge length along z.
    #[serde(skip)]
    offset: f64,
}

/// The periodic image of particle a that is nearest to particle b, in a sheared box.
#[derive(Clone, Copy, Debug)]
struct NearestImage {
    /// [m] vector from particle b to the image of particle a.
    apart: Vector3<f64>,
    /// [m/s] velocity along z of the image of particle a relative to particle a itself.
    velocity: f64,
}

/// A rectangular box with one corner at the origin, periodic along any of its axes.
///
/// Axes of a channel: x spanwise, y normal to the walls, z along the flow (section 2.1 of the paper that docs/paper.md
/// describes).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Domain {
    /// [m] edge lengths of the box along x, y, z.
    pub size: Vector3<f64>,
    /// True for each axis along which the box is periodic.
    pub periodic: [bool; 3],
    /// Shear, by which periodic images above and below the box slide along z; `None` if images do not slide.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shear: Option<Shear>,
    /// [m] half the edge length along periodic axes, infinity along the other axes. If two particles are farther apart
    /// along a periodic axis than this half edge, a periodic image of one particle is nearer.
    #[serde(skip)]
    pub(crate) half: Vector3<f64>,
    /// [m²] square of the shortest half edge length of a periodic axis. If the distance of two particles is below this
    /// half edge, no periodic image is nearer. Infinite without periodic axes.
    #[serde(skip)]
    direct: f64,
    /// [1/m] inverse edge length along periodic axes, 0 along the other axes.
    #[serde(skip)]
    pub(crate) per_size: Vector3<f64>,
}

impl Domain {
    /// Makes a box with the edge lengths `size` [m]. `periodic` is true for each axis along which the box is periodic.
    pub fn new(size: Vector3<f64>, periodic: [bool; 3]) -> Self {
        let half = Vector3::from_fn(|axis, _| if periodic[axis] { 0.5 * size[axis] } else { f64::INFINITY });
        let per_size = Vector3::from_fn(|axis, _| if periodic[axis] { 1.0 / size[axis] } else { 0.0 });
        Self { size, periodic, shear: None, half, direct: half.min().powi(2), per_size }
    }

    /// Makes the box sheared at the shear rate `rate` [1/s], with periodic images at their places of time 0: the image
    /// one box height above a particle is displaced by `start` [m] along z. The box must be periodic along y and z.
    pub fn sheared(self, rate: f64, start: f64) -> Self {
        Self { shear: Some(Shear { rate, start, orbit: None, offset: 0.0 }), ..self }.at(0.0).into_owned()
    }

    /// Puts a sheared box on an orbit about a distant mass. A box without shear is returned unchanged.
    pub fn on_orbit(self, orbit: Orbit) -> Self {
        Self { shear: self.shear.map(|shear| Shear { orbit: Some(orbit), ..shear }), ..self }
    }

    /// Orbit of the box about a distant mass; `None` for a box at rest.
    pub fn orbit(&self) -> Option<Orbit> {
        self.shear?.orbit
    }

    /// Returns a box with other edge lengths [m], and with the periodic axes and the shear of this box. In the new box,
    /// periodic images are at their places of time 0.
    pub fn resized(&self, size: Vector3<f64>) -> Self {
        let resized = Self::new(size, self.periodic);
        let Some(shear) = self.shear else { return resized };
        let sheared = resized.sheared(shear.rate, shear.start);
        match shear.orbit {
            Some(orbit) => sheared.on_orbit(orbit),
            None => sheared,
        }
    }

    /// Returns a copy of the box whose periodic images do not slide but stay at their present places. Code that needs
    /// positions but no velocities uses this copy.
    pub fn at_rest(&self) -> Self {
        let rest = |shear: Shear| Shear { rate: 0.0, start: shear.offset, ..shear };
        Self { shear: self.shear.map(rest), ..self.clone() }
    }

    /// [m] displacement along z of the periodic image one box height above a particle, at the instant of this box (the
    /// argument of [`at`](Self::at)); `None` without shear.
    pub fn offset(&self) -> Option<f64> {
        self.shear.map(|shear| shear.offset)
    }

    /// Returns the box with periodic images at their places of the simulated time `time` [s]. Without shear, the box
    /// itself is returned, not a copy.
    pub fn at(&self, time: f64) -> Cow<'_, Self> {
        self.slid_to(|shear| shear.start + self.sliding() * time)
    }

    fn slid_to(&self, offset: impl Fn(&Shear) -> f64) -> Cow<'_, Self> {
        let Some(shear) = &self.shear else { return Cow::Borrowed(self) };
        let (offset, period) = (offset(shear), self.size.z);
        let offset = offset - period * (offset / period).round();
        Cow::Owned(Self { shear: Some(Shear { offset, ..*shear }), ..self.clone() })
    }

    /// [m/s] velocity γ L_y along z of the periodic image one box height L_y above a particle, relative to the
    /// particle, with the shear rate γ; 0 without shear.
    pub fn sliding(&self) -> f64 {
        self.shear.map_or(0.0, |shear| shear.rate * self.size.y)
    }

    /// [m/s] multiple n γ L_y nearest to `velocity` [m/s], with a whole number n, the shear rate γ and the box height
    /// L_y; 0 without shear. The velocities of periodic images of one particle in a sheared box differ by multiples of
    /// γ L_y.
    pub fn whole_slides(&self, velocity: f64) -> f64 {
        let sliding = self.sliding();
        if sliding == 0.0 { 0.0 } else { sliding * (velocity / sliding).round() }
    }

    /// [1/s] magnitude |γ| of the shear rate of the box; 0 without shear.
    pub fn strain_rate(&self) -> f64 {
        self.shear.map_or(0.0, |shear| shear.rate.abs())
    }

    /// [m/s] mean flow of the shear at a position [m]; zero without shear. The velocity minus this flow is the same for
    /// all periodic images of a particle.
    #[inline]
    pub fn mean_flow(&self, position: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(0.0, 0.0, self.shear.map_or(0.0, |shear| shear.rate * position.y))
    }

    /// True for each axis along which a grid of cells continues from one side of the box to the opposite side. It is
    /// false for sides that are not periodic, and for sheared sides, whose images are displaced along z.
    pub fn joined(&self) -> [bool; 3] {
        let [x, y, z] = self.periodic;
        [x, y && self.shear.is_none(), z]
    }

    /// Calls `visit` with each periodic image [m] of `position` across the upper or the lower sheared side, if the
    /// image is nearer to the box than `reach` [m]. Along z the images are wrapped into the box. Without shear, `visit`
    /// is not called.
    #[inline]
    pub fn for_each_across(&self, position: &Vector3<f64>, reach: f64, mut visit: impl FnMut(Vector3<f64>)) {
        if self.shear.is_none() {
            return;
        }
        let height = self.size.y;
        if position.y < reach {
            visit(self.image(position, 1.0));
        }
        if position.y > height - reach {
            visit(self.image(position, -1.0));
        }
    }

    /// Calls `visit` with `position` [m] itself, and then with its periodic images beyond the sheared sides. Images
    /// farther from the box than `reach` [m] are left out ([`for_each_across`](Self::for_each_across)).
    #[inline]
    pub fn for_each_image(&self, position: &Vector3<f64>, reach: f64, mut visit: impl FnMut(Vector3<f64>)) {
        visit(*position);
        self.for_each_across(position, reach, visit);
    }

    /// [m] periodic image of `position` in a sheared box, `periods` box heights above `position`. The coordinate z of
    /// the image is wrapped into the box.
    fn image(&self, position: &Vector3<f64>, periods: f64) -> Vector3<f64> {
        let offset = self.shear.map_or(0.0, |shear| shear.offset);
        let z = position.z + periods * offset;
        let inside = z - self.size.z * (z / self.size.z).floor();
        let z = if inside < self.size.z { inside } else { 0.0 };
        Vector3::new(position.x, position.y + periods * self.size.y, z)
    }

    /// [m³] volume of the box.
    pub fn volume(&self) -> f64 {
        self.size.x * self.size.y * self.size.z
    }

    /// [m] vector from `b` to the nearest periodic image of `a`. Along a periodic axis, the two coordinates may differ
    /// by at most 1.5 edge lengths of the box. This holds for all particles between two calls of [`Domain::wrap`].
    #[inline(always)]
    pub fn separation(&self, a: &Vector3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
        let mut d = a - b;
        // most pairs are near: this comparison then replaces the comparisons along the three axes
        if d.norm_squared() < self.direct {
            return d;
        }
        if let Some(shear) = &self.shear {
            return self.nearest(&d, shear, 0.0).apart;
        }
        for axis in 0..3 {
            if d[axis] > self.half[axis] {
                d[axis] -= self.size[axis];
            } else if d[axis] < -self.half[axis] {
                d[axis] += self.size[axis];
            }
        }
        d
    }

    /// True only if the particle itself, and not a periodic image of it, is the nearest to a second particle. `apart`
    /// [m] is the vector between the two particles. The result may be false although no image is nearer.
    #[inline]
    pub fn is_direct(&self, apart: &Vector3<f64>) -> bool {
        apart.norm_squared() < self.direct
    }

    /// Vector [m] `apart` between two particles, shifted by whole periods to the vector between the nearest images.
    /// Unlike in [`separation`](Self::separation), the particles may be many periods apart. The result is not valid
    /// across sheared sides, whose images slide.
    #[inline]
    pub fn nearest_image(&self, apart: &Vector3<f64>) -> Vector3<f64> {
        if self.is_direct(apart) {
            return *apart;
        }
        Vector3::from_fn(|axis, _| {
            apart[axis] - self.size[axis] * (apart[axis] * self.per_size[axis]).round_ties_even()
        })
    }

    /// Vector [m] from `b` to the nearest periodic image of `a`, and velocity [m/s] of this image relative to `b`. In a
    /// sheared box the image above or below moves with another velocity than `a`. `velocity` [m/s] is the velocity of
    /// `a` itself relative to `b`. `elapsed` [s] is the time since the instant of this box, the argument of
    /// [`at`](Self::at).
    #[inline(always)]
    pub fn relative(
        &self,
        a: &Vector3<f64>,
        b: &Vector3<f64>,
        velocity: Vector3<f64>,
        elapsed: f64,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let Some(shear) = &self.shear else { return (self.separation(a, b), velocity) };
        let d = a - b;
        if d.norm_squared() < self.direct {
            return (d, velocity);
        }
        let image = self.nearest(&d, shear, elapsed);
        (image.apart, Vector3::new(velocity.x, velocity.y, velocity.z + image.velocity))
    }

    /// Nearest periodic image of a particle in a sheared box. `d` [m] is the position of the particle minus that of the
    /// other particle. `elapsed` [s] is the time of these positions, counted from the instant of this box (the argument
    /// of [`at`](Self::at)).
    fn nearest(&self, d: &Vector3<f64>, shear: &Shear, elapsed: f64) -> NearestImage {
        let sliding = shear.rate * self.size.y;
        let above = -(d.y / self.size.y).round();
        let z = d.z + above * (shear.offset + sliding * elapsed);
        let near = |x: f64, axis: usize| {
            if self.periodic[axis] { x - self.size[axis] * (x / self.size[axis]).round() } else { x }
        };
        let apart = Vector3::new(near(d.x, 0), d.y + above * self.size.y, near(z, 2));
        NearestImage { apart, velocity: above * sliding }
    }

    /// Replaces a position [m] outside the box and its velocity [m/s] by those of the image inside the box. Returns the
    /// change [m/s] of the velocity along z, which is 0 unless the position is beyond a sheared side.
    #[inline]
    pub fn wrap_motion(&self, position: &mut Vector3<f64>, velocity: &mut Vector3<f64>) -> f64 {
        let periods = self.sheared_periods(position);
        let change = periods * self.sliding();
        if change != 0.0 {
            velocity.z += change;
        }
        *position = self.wrap_by(position, periods);
        change
    }

    /// [m] periodic image of `position` that lies inside the box along all periodic axes.
    #[inline]
    pub fn wrap(&self, position: &Vector3<f64>) -> Vector3<f64> {
        self.wrap_by(position, self.sheared_periods(position))
    }

    /// Number of box heights L_y by which a position must move along y to be in a sheared box, positive upwards; 0
    /// without shear.
    #[inline]
    fn sheared_periods(&self, position: &Vector3<f64>) -> f64 {
        let (y, height) = (position.y, self.size.y);
        if self.shear.is_none() || (0.0..height).contains(&y) {
            return 0.0;
        }
        let periods = -(y / height).floor();
        // just below the lower side, y + L_y rounds to L_y: such a position stays at that side
        if y + periods * height < height { periods } else { 0.0 }
    }

    /// [m] image of a position inside the box along all periodic axes. `periods` is the number of box heights, positive
    /// upwards, by which the position moves along y in a sheared box.
    #[inline]
    fn wrap_by(&self, position: &Vector3<f64>, periods: f64) -> Vector3<f64> {
        let position = if periods == 0.0 { *position } else { self.image(position, periods) };
        Vector3::from_fn(|axis, _| {
            let (x, l) = (position[axis], self.size[axis]);
            if !self.periodic[axis] || (0.0..l).contains(&x) {
                return x;
            }
            let wrapped = x - l * (x / l).floor();
            // the result is checked, because x + l rounds to l for x slightly below zero
            if wrapped < l { wrapped } else { 0.0 }
        })
    }

    /// True if `position` [m] is within the box along every axis that is not periodic.
    #[inline]
    pub fn contains(&self, position: &Vector3<f64>) -> bool {
        (0..3).all(|axis| self.periodic[axis] || (0.0..=self.size[axis]).contains(&position[axis]))
    }
}
