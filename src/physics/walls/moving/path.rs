//! Displacement of a wall that is linear in time between given instants.

use nalgebra::Vector3;
use serde::Serialize;

/// Displacement of a wall at given instants, linear between them. Before the first and after the last instant the wall
/// is at rest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PiecewisePath {
    /// Instants [s] in ascending order, each with the displacement [m] of the wall at this instant.
    knots: Vec<(f64, Vector3<f64>)>,
}

impl PiecewisePath {
    /// Makes a path from its instants [s] and displacements [m]. `None` if the list is empty, a number is not finite,
    /// or the instants do not strictly ascend.
    pub fn new(knots: Vec<(f64, Vector3<f64>)>) -> Option<Self> {
        let finite = knots.iter().all(|(time, position)| time.is_finite() && position.iter().all(|x| x.is_finite()));
        let ascends = knots.windows(2).all(|two| two[0].0 < two[1].0);
        (!knots.is_empty() && finite && ascends).then_some(Self { knots })
    }

    /// Number of knots (given instants of the path) that are not later than `time` [s].
    fn passed(&self, time: f64) -> usize {
        self.knots.partition_point(|(knot, _)| *knot <= time)
    }

    /// [m] displacement of the wall at the time `time` [s].
    pub fn displacement(&self, time: f64) -> Vector3<f64> {
        let next = self.passed(time);
        let at = |knot: usize| self.knots[knot.min(self.knots.len() - 1)];
        let ((from, here), (to, there)) = (at(next.saturating_sub(1)), at(next));
        if next == 0 || to <= from { here } else { here + (there - here) * ((time - from) / (to - from)) }
    }

    /// [m/s] velocity at `time` [s]. At a knot (a given instant) it is the velocity after the knot.
    pub fn velocity(&self, time: f64) -> Vector3<f64> {
        match self.passed(time) {
            0 => Vector3::zeros(),
            next => self.knots.get(next).map_or_else(Vector3::zeros, |to| slope(&self.knots[next - 1], to)),
        }
    }

    /// [s] first knot (given instant of the path) after `time` [s]; infinite after the last knot.
    pub fn next_knot(&self, time: f64) -> f64 {
        self.knots.get(self.passed(time)).map_or(f64::INFINITY, |(knot, _)| *knot)
    }

    /// [m/s] largest speed of the wall on the path.
    pub fn largest_speed(&self) -> f64 {
        self.knots.windows(2).map(|two| slope(&two[0], &two[1]).norm()).fold(0.0, f64::max)
    }

    /// [m] least and largest component of the displacement along the unit vector `direction`, over all times.
    pub fn range_along(&self, direction: &Vector3<f64>) -> [f64; 2] {
        let along = self.knots.iter().map(|(_, position)| position.dot(direction));
        along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    }

    /// [m] upper limit of the distance between two points of the path: the diagonal of the box around all
    /// displacements.
    pub fn largest_excursion(&self) -> f64 {
        let positions = || self.knots.iter().map(|(_, position)| *position);
        let low = positions().fold(Vector3::repeat(f64::INFINITY), |a, b| a.inf(&b));
        let high = positions().fold(Vector3::repeat(f64::NEG_INFINITY), |a, b| a.sup(&b));
        (high - low).norm()
    }
}

/// [m/s] velocity between two knots (given instants, each with a displacement).
fn slope((from, here): &(f64, Vector3<f64>), (to, there): &(f64, Vector3<f64>)) -> Vector3<f64> {
    (there - here) / (to - from)
}
