//! A body and its images across periodic sides.

use super::{Drawing, Flight, Geometry, Nearest, Touch, Turning, Wall, WallGeometry};
use crate::domain::Domain;
use nalgebra::Vector3;
use serde::Serialize;

/// Largest number of images, counted from the nearest image, that are tested on each side along an axis. A particle can
/// meet farther images only in a later window (time between two exchanges of momentum with the gas). After each window
/// the particle is moved back into the domain.
const FARTHEST: f64 = 2.0;

/// A body in a periodic domain together with its images. Particles may leave the domain during a window (the time
/// between two exchanges of momentum with the gas), and touch images outside. These particles are moved back into the
/// domain after the window.
#[derive(Clone, Debug, Serialize)]
pub struct Repeated {
    shape: WallGeometry,
    /// [m] lowest and highest corner of the box around the body.
    around: [Vector3<f64>; 2],
    /// [m] length of the domain along each periodic axis; `None` for other axes.
    periods: [Option<f64>; 3],
}

impl Repeated {
    /// Makes the shape of a body with its images. Returns the shape unchanged if the domain is not periodic, or if the
    /// shape has no bounds.
    pub fn of(shape: WallGeometry, domain: &Domain) -> WallGeometry {
        let Some(around) = shape.law().bounds().filter(|_| domain.periodic.contains(&true)) else { return shape };
        let periods = std::array::from_fn(|axis| domain.periodic[axis].then_some(domain.size[axis]));
        WallGeometry::Repeated(std::sync::Arc::new(Self { shape, around, periods }))
    }

    /// Copies of the walls; in the copies, all bodies have periodic images.
    pub fn all(walls: &[Wall], domain: &Domain) -> Vec<Wall> {
        walls.iter().map(|wall| wall.repeated(domain)).collect()
    }

    /// Shape of the body alone, without its periodic images.
    pub fn shape(&self) -> &WallGeometry {
        &self.shape
    }

    /// Number of the image of the body that is nearest to `coordinate` [m] along an axis. The body itself has the
    /// number 0, and the image with the number n is n periods away.
    fn image(&self, axis: usize, coordinate: f64) -> f64 {
        let center = 0.5 * (self.around[0][axis] + self.around[1][axis]);
        self.periods[axis].map_or(0.0, |period| ((coordinate - center) / period).round())
    }

    /// [m] `point` shifted by whole periods, so that the body itself is nearer to the shifted point than the images of
    /// the body.
    pub(super) fn near(&self, point: &Vector3<f64>) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| {
            point[axis] - self.periods[axis].map_or(0.0, |period| period * self.image(axis, point[axis]))
        })
    }

    /// [m] lowest and highest corner of a box around the body, and of boxes around its neighbouring images.
    pub fn boxes(&self) -> Vec<[Vector3<f64>; 2]> {
        let range = |axis: usize| if self.periods[axis].is_some() { -1..=1 } else { 0..=0 };
        let mut boxes = Vec::new();
        for x in range(0) {
            for y in range(1) {
                for z in range(2) {
                    let shift = self.shift([x, y, z].map(f64::from));
                    boxes.push(self.around.map(|corner| corner + shift));
                }
            }
        }
        boxes
    }

    /// [m] vector from the body to the image that has the numbers `image` along x, y, z.
    fn shift(&self, image: [f64; 3]) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| self.periods[axis].map_or(0.0, |period| period * image[axis]))
    }

    /// True if the condition `is_true` holds near any image of the body. For each image, `is_true` is called with
    /// `point` [m], shifted from this image to the body. The images tested are those nearest to any point within
    /// `reach` [m] of `point`, at most one image to each side along an axis.
    fn any_near(&self, point: &Vector3<f64>, reach: f64, is_true: impl Fn(&Vector3<f64>) -> bool) -> bool {
        let range = |axis: usize| {
            let here = self.image(axis, point[axis]);
            let end = |coordinate: f64| self.image(axis, coordinate).clamp(here - 1.0, here + 1.0) as i32;
            end(point[axis] - reach)..=end(point[axis] + reach)
        };
        for x in range(0) {
            for y in range(1) {
                for z in range(2) {
                    if is_true(&(point - self.shift([x, y, z].map(f64::from)))) {
                        return true;
                    }
                }
            }
        }
        false
    }

    /// Calls `visit` with the flight relative to each image of the body that the flight may approach until the time
    /// `until` [s].
    fn for_each_image(&self, flight: &Flight, until: f64, mut visit: impl FnMut(&Flight)) {
        let range = |axis: usize| {
            let first = self.image(axis, flight.position[axis]);
            let (v, g) = (flight.velocity[axis], flight.gravity[axis]);
            // along an axis the flight is farthest at its turning point or at its end
            let turn = if g != 0.0 { (-v / g).clamp(0.0, until) } else { 0.0 };
            let ends = [turn, until].map(|t| {
                // avoids the product of zero and infinity, which is NaN
                let part = |rate: f64, t: f64| if rate == 0.0 { 0.0 } else { rate * t };
                let way = part(v, t) + part(0.5 * g, t * t);
                if way.is_nan() { first } else { self.image(axis, flight.position[axis] + way) }
            });
            let reach = |end: f64| end.clamp(first - FARTHEST, first + FARTHEST);
            let [a, b] = ends.map(reach);
            (first.min(a).min(b) as i32)..=(first.max(a).max(b) as i32)
        };
        for x in range(0) {
            for y in range(1) {
                for z in range(2) {
                    let shift = self.shift([x, y, z].map(f64::from));
                    visit(&Flight { position: flight.position - shift, ..*flight });
                }
            }
        }
    }
}

impl Geometry for Repeated {
    fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        self.shape.law().nearest(&self.near(point))
    }

    fn touch_time(&self, flight: &Flight, radius: f64, until: f64) -> Option<f64> {
        let mut first: Option<f64> = None;
        self.for_each_image(flight, until, |flight| {
            let time = self.shape.law().touch_time(flight, radius, first.unwrap_or(until));
            first = first.into_iter().chain(time).reduce(f64::min);
        });
        first
    }

    fn contacts(&self) -> u32 {
        self.shape.law().contacts()
    }

    fn contact(&self, which: u32, point: &Vector3<f64>, radius: f64) -> Nearest {
        self.shape.law().contact(which, &self.near(point), radius)
    }

    fn is_flat_at(&self, which: u32) -> bool {
        self.shape.law().is_flat_at(which)
    }

    fn seam(&self) -> f64 {
        self.shape.law().seam()
    }

    fn first_touch(&self, which: u32, flight: &Flight, radius: f64, until: f64) -> Option<Touch> {
        let mut first: Option<Touch> = None;
        self.for_each_image(flight, until, |flight| {
            let limit = first.map_or(until, |touch| touch.time);
            let touch = self.shape.law().first_touch(which, flight, radius, limit);
            let earlier = |touch: &Touch| first.is_none_or(|first| touch.time < first.time);
            first = touch.filter(earlier).or(first);
        });
        first
    }

    fn struck(&self, which: u32, feature: u32, point: &Vector3<f64>, radius: f64) -> Nearest {
        self.shape.law().struck(which, feature, &self.near(point), radius)
    }

    fn may_touch(&self, which: u32, point: &Vector3<f64>, radius: f64, skin: f64) -> bool {
        self.any_near(point, radius + skin, |point| self.shape.law().may_touch(which, point, radius, skin))
    }

    fn is_thin(&self) -> bool {
        self.shape.law().is_thin()
    }

    fn is_within(&self, point: &Vector3<f64>, distance: f64) -> bool {
        self.any_near(point, distance, |point| self.shape.law().is_within(point, distance))
    }

    fn is_clear(&self, point: &Vector3<f64>, distance: f64) -> bool {
        !self.any_near(point, distance, |point| !self.shape.law().is_clear(point, distance))
    }

    fn is_nearest_first(&self) -> bool {
        self.shape.law().is_nearest_first()
    }

    fn slides(&self, velocity: &Vector3<f64>) -> bool {
        self.shape.law().slides(velocity)
    }

    fn turns(&self, turning: &Turning) -> bool {
        self.shape.law().turns(turning)
    }

    fn bounds(&self) -> Option<[Vector3<f64>; 2]> {
        self.shape.law().bounds()
    }

    fn extent(&self) -> Option<[Vector3<f64>; 2]> {
        self.shape.law().extent()
    }

    fn room_corners(&self) -> Option<[Vector3<f64>; 2]> {
        self.shape.law().room_corners()
    }

    fn holds_along(&self, axis: usize) -> bool {
        self.shape.law().holds_along(axis)
    }

    fn vessel_volume(&self, size: &Vector3<f64>) -> Option<f64> {
        self.shape.law().vessel_volume(size)
    }

    fn has_inside(&self) -> bool {
        self.shape.law().has_inside()
    }

    fn encloses(&self, point: &Vector3<f64>) -> bool {
        self.shape.law().encloses(&self.near(point))
    }

    fn in_words(&self) -> String {
        self.shape.law().in_words()
    }

    fn drawing(&self, size: &Vector3<f64>) -> Drawing {
        self.shape.law().drawing(size)
    }
}
