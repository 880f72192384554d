//! Collision history of each particle: time of the last collision, and signs that its impacts pile up to a collapse.

use super::impulse::Collision;
use crate::encounter::Partner;
use crate::engine::Failure;
use crate::scene::Scene;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Number of successive impacts of one particle, each after an unresolvably short flight, from which this is called a
/// collapse. A chain of n touching spheres passes a blow on in fewer than n²/2 collisions, so scenes that do not
/// collapse stay below.
const COLLAPSE_STREAK: u8 = 200;

/// Length of a flight, relative to the box, below which it is unresolvably short. Coordinates are rounded to 2e-16 of
/// the box at every collision, so after a shorter flight rounding decides which body a sphere meets next.
const COLLAPSE_FLIGHT: f64 = 64.0 * f64::EPSILON;

/// Number of successive flights, each shorter than the one before, after which an unresolvably short one ends a Zeno
/// series. The relative speeds of a collapsing group fall below rounding within some dozen impacts. Then nothing meets
/// any more, and the streak above would not be reached. Three flights become shorter in a row by chance once in six
/// times, and then fall to 10⁻¹⁴ of the box with about that probability.
const ZENO_FLIGHTS: u8 = 3;

/// Number of impacts of one particle within one window from which this is called a collapse, however far apart in time.
/// Not with a contact time: spheres at rest then collide about once per contact time, without end.
const COLLAPSE_IMPACTS: u32 = 1_000_000;

/// Time of the last collision of a particle, as the TC model needs it from one window to the next.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Recent {
    /// Index in the store.
    pub place: u32,
    /// Simulated time [s] of the collision.
    pub time: f64,
}

/// Collision history of one particle.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct LastCollision {
    /// Impacts since the count was last cleared.
    pub impacts: u32,
    /// Successive impacts after unresolvably short flights, across windows.
    streak: u8,
    /// Successive impacts, each after a shorter flight than the one before, across windows; at most 255.
    shrinking: u8,
    /// Length of the last flight [m]: time since the impact before, times the speed of approach.
    flown: f64,
    /// Simulated time [s] of the last collision.
    pub last: f64,
}

impl Default for LastCollision {
    fn default() -> Self {
        Self { impacts: 0, streak: 0, shrinking: 0, flown: f64::INFINITY, last: f64::NEG_INFINITY }
    }
}

impl LastCollision {
    /// A history with nothing but a collision at simulated time `last` [s].
    pub fn at(last: f64) -> Self {
        Self { last, ..Self::default() }
    }

    /// Records a collision at simulated `time` [s]. Returns the time [s] since the previous one if it shows a collapse.
    pub fn note(&mut self, collision: &Collision, scene: &Scene, time: f64, contact_time: Option<f64>) -> Option<f64> {
        let interval = time - self.last;
        let flown = collision.approach().abs() * interval;
        let unresolved = flown <= COLLAPSE_FLIGHT * scene.domain.size.max();
        let zeno = unresolved && self.shrinking >= ZENO_FLIGHTS && collision.loses(scene);
        self.impacts += 1;
        self.streak = if unresolved { self.streak.saturating_add(1) } else { 0 };
        self.shrinking = if !unresolved && flown < self.flown { self.shrinking.saturating_add(1) } else { 0 };
        self.flown = flown;
        self.last = time;
        let endless = self.impacts >= COLLAPSE_IMPACTS && contact_time.is_none();
        (zeno || self.streak >= COLLAPSE_STREAK || endless).then_some(interval)
    }
}

/// Speed [m/s] of sliding along a curved wall that a particle hits at ever smaller angles. Such impacts pile up without
/// anything coming to rest. `None` for other collisions.
pub fn sliding(collision: &Collision, scene: &Scene) -> Option<f64> {
    /// [-] ratio of slip to speed of approach from which the particle slides.
    const FLAT: f64 = 1e3;
    let slip = collision.met.slip().norm();
    let is_curved = collision.couple.is_wall() && !collision.couple.is_flat(scene);
    (is_curved && slip > FLAT * collision.approach().abs()).then_some(slip)
}

/// Data that show how the impacts of a particle pile up.
#[derive(Clone, Copy, Debug)]
pub struct Collapsed {
    /// Impacts of the particle since the count was last cleared.
    pub impacts: u32,
    /// Time [s] between the last two impacts.
    pub interval: f64,
    /// Contact time [s] of the TC model.
    pub contact_time: Option<f64>,
    /// Speed [m/s] of sliding along a curved wall, if that is why the impacts pile up.
    pub sliding: Option<f64>,
}

impl Collapsed {
    /// Failure at simulated `time` [s], with the id of the particle, its collision partner, and its position [m].
    pub fn failure(&self, time: f64, (particle, partner): (u32, Partner), place: Vector3<f64>) -> Failure {
        let Self { impacts, interval, contact_time, sliding } = *self;
        let (impacts, [x, y, z]) = (u64::from(impacts), place.into());
        Failure::InelasticCollapse { time, particle, partner, impacts, interval, contact_time, sliding, x, y, z }
    }
}

/// Normal speed [m/s] away from the wall of a particle that merely rests on it, with a contact time t_c. Gravity
/// presses the particle to the wall, and it would rise by less than can be resolved. `None` if it does not rest.
///
/// Without t_c it would collide infinitely often at once. A contact of finite duration carries the weight during its
/// contact time. Here the particle rebounds at a_n t_c/4, with a_n the acceleration into the wall, and comes back after
/// t_c/2. That is sooner than t_c, hence always elastic. It rises by a_n t_c²/32. This is a third of a_n t_c²/π², the
/// compression under the weight of a spring with that contact time (k = m π²/t_c²).
pub fn rests(collision: &Collision, scene: &Scene, contact_time: Option<f64>) -> Option<f64> {
    if !collision.couple.is_wall() {
        return None;
    }
    let approach = collision.approach();
    let weight = -scene.gravity.dot(&collision.met.normal);
    let speed = 0.25 * weight * contact_time?;
    let rise = 2.0 * weight * COLLAPSE_FLIGHT * scene.domain.size.max();
    (approach * approach <= rise && speed > approach).then_some(speed)
}

/// Recent collisions: particles that have collided less than the contact time before `now` [s]; none without a contact
/// time.
pub fn recent<'a>(
    met: impl Iterator<Item = &'a LastCollision>,
    contact_time: Option<f64>,
    now: f64,
) -> impl Iterator<Item = Recent> {
    let after = contact_time.map_or(f64::INFINITY, |time| now - time);
    let met = met.enumerate().filter(move |(_, met)| met.last > after);
    met.map(|(place, met)| Recent { place: place as u32, time: met.last })
}
