//! What has come to each particle: when it last collided, and whether its impacts pile up to a collapse.

use super::impulse::Collision;
use crate::encounter::Partner;
use crate::engine::Failure;
use crate::scene::Scene;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Impacts of one particle in a row, each after a flight too short to be told from none, before this is called a
/// collapse. A chain of n touching spheres passes a blow on in fewer than n²/2 collisions, so scenes that are not
/// collapsing stay below.
const COLLAPSE_STREAK: u8 = 200;

/// A flight is too short to be told from none if it is below this fraction of the box: coordinates are rounded to
/// 2e-16 of it at every collision, so what a sphere meets next after less is decided by rounding.
const COLLAPSE_FLIGHT: f64 = 64.0 * f64::EPSILON;

/// Flights of one particle, each shorter than the one before, after which one too short to be told from none is the end of
/// a Zeno series. The relative speeds of a group that collapses fall below rounding within some dozen impacts, and then
/// nothing meets any more: the streak above would not be reached. Three flights in a row fall by chance in one of six
/// times, and then to 10⁻¹⁴ of the box with about that probability.
const ZENO_FLIGHTS: u8 = 3;

/// Impacts of one particle within one window before this is called a collapse, however far apart in time. Not with a
/// contact time: spheres at rest then collide about once in it, for ever.
const COLLAPSE_IMPACTS: u32 = 1_000_000;

/// When a particle last collided, by place: what the TC model must know from one window to the next.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Recent {
    /// Place in the store.
    pub place: u32,
    /// [s] simulated time.
    pub time: f64,
}

/// What has come to one particle.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct LastCollision {
    /// Impacts since the count was last cleared.
    pub impacts: u32,
    /// Impacts in a row after flights too short to be told from none, across windows.
    streak: u8,
    /// Impacts in a row, each after a shorter flight than the one before, across windows; or 255, if there are more.
    shrinking: u8,
    /// [m] the last flight: time since the impact before, times the speed of approach.
    flown: f64,
    /// [s] simulated time of the last.
    pub last: f64,
}

impl Default for LastCollision {
    fn default() -> Self {
        Self { impacts: 0, streak: 0, shrinking: 0, flown: f64::INFINITY, last: f64::NEG_INFINITY }
    }
}

impl LastCollision {
    /// Nothing but that it collided at that simulated time [s].
    pub fn at(last: f64) -> Self {
        Self { last, ..Self::default() }
    }

    /// Notes a collision at simulated `time` [s]. Returns the time since the one before [s] if it shows a collapse.
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

/// [m/s] the speed at which a particle slides along a curved wall that it hits ever more flatly: such impacts pile up without anything coming to rest. `None` of
/// other collisions.
pub fn sliding(collision: &Collision, scene: &Scene) -> Option<f64> {
    /// [-] slip over the speed of approach from which it slides.
    const FLAT: f64 = 1e3;
    let slip = collision.met.slip().norm();
    let is_curved = collision.couple.is_wall() && !collision.couple.is_flat(scene);
    (is_curved && slip > FLAT * collision.approach().abs()).then_some(slip)
}

/// What shows that the impacts of a particle pile up.
#[derive(Clone, Copy, Debug)]
pub struct Collapsed {
    /// Its impacts since the count was last cleared.
    pub impacts: u32,
    /// [s] between the last two.
    pub interval: f64,
    /// [s] that contacts last in the TC model.
    pub contact_time: Option<f64>,
    /// [m/s] at which it slides along a curved wall, if that is why its impacts pile up.
    pub sliding: Option<f64>,
}

impl Collapsed {
    /// The failure at simulated `time` [s]: of which particle, by id, on what, and where [m].
    pub fn failure(&self, time: f64, (particle, partner): (u32, Partner), place: Vector3<f64>) -> Failure {
        let Self { impacts, interval, contact_time, sliding } = *self;
        let (impacts, [x, y, z]) = (u64::from(impacts), place.into());
        Failure::InelasticCollapse { time, particle, partner, impacts, interval, contact_time, sliding, x, y, z }
    }
}

/// Whether a particle merely rests on a wall while there is a contact time t_c: gravity presses it there, and it would rise by
/// less than what can be told from nothing. Then gives its normal speed away from the wall [m/s].
///
/// Without t_c it would collide infinitely often at once. A contact that lasts carries the weight for its time; here the
/// particle rebounds at a_n t_c/4, with a_n the acceleration into the wall, and comes back after t_c/2: sooner than t_c,
/// hence always elastically. It rises by a_n t_c²/32, a third of what a spring with that time of contact gives way under
/// the weight, a_n t_c²/π² (k = m π²/t_c²).
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

/// Who, by place, has collided less than the contact time before `now` [s]; nobody without one.
pub fn recent<'a>(
    met: impl Iterator<Item = &'a LastCollision>,
    contact_time: Option<f64>,
    now: f64,
) -> impl Iterator<Item = Recent> {
    let after = contact_time.map_or(f64::INFINITY, |time| now - time);
    let met = met.enumerate().filter(move |(_, met)| met.last > after);
    met.map(|(place, met)| Recent { place: place as u32, time: met.last })
}
