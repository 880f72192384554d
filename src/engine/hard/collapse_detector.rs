//! Collision history of each particle, by which inelastic collapse is detected. In an inelastic collapse a particle has
//! infinitely many impacts in finite time.

use super::impulse::Collision;
use crate::encounter::Partner;
use crate::engine::Failure;
use crate::scene::Scene;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Number of successive impacts of one particle, each after an unresolvably short flight, that counts as an inelastic
/// collapse. A chain of n touching spheres transmits a blow in fewer than n²/2 collisions, so scenes without collapse
/// have fewer.
const COLLAPSE_STREAK: u8 = 200;

/// [-] length of a flight divided by the longest edge of the box, below which the flight is unresolvably short.
/// Coordinates are rounded to 2e-16 of the box at every collision. After a shorter flight, rounding determines which
/// body a sphere meets next.
const COLLAPSE_FLIGHT: f64 = 64.0 * f64::EPSILON;

/// Number of successive flights, each shorter than the one before, after which an unresolvably short flight is a
/// collapse (the end of a Zeno series: infinitely many impacts in finite time). The relative speeds of a collapsing
/// group fall below rounding within some dozen impacts. Then the group has no more impacts, so the limit
/// [`COLLAPSE_STREAK`] would not be reached. By chance, three flights become shorter in a row in one of six cases. A
/// chance flight is shorter than 10⁻¹⁴ of the box with a probability of about 10⁻¹⁴.
const ZENO_FLIGHTS: u8 = 3;

/// Number of impacts of one particle within one time window that counts as a collapse, however long the times between
/// the impacts. The limit does not apply with a contact time, since spheres at rest then collide about once per contact
/// time, without end.
const COLLAPSE_IMPACTS: u32 = 1_000_000;

/// Time of the last collision of a particle. The TC model (elastic collisions within a contact time) requires it in the
/// next time window.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Recent {
    /// Index of the particle in the particle store.
    pub place: u32,
    /// Simulated time [s] of the particle's last collision.
    pub time: f64,
}

/// Collision history of one particle.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct LastCollision {
    /// Number of impacts of the particle since the count was last set to 0.
    pub impacts: u32,
    /// Number of successive impacts after unresolvably short flights, counted across time windows; another impact
    /// resets it to 0.
    streak: u8,
    /// Number of successive impacts, each after a shorter flight than the one before, counted across time windows; at
    /// most 255.
    shrinking: u8,
    /// Length of the last flight [m]: time since the previous impact, times the speed of approach.
    flown: f64,
    /// Simulated time [s] of the particle's last collision.
    pub last: f64,
}

impl Default for LastCollision {
    fn default() -> Self {
        Self { impacts: 0, streak: 0, shrinking: 0, flown: f64::INFINITY, last: f64::NEG_INFINITY }
    }
}

impl LastCollision {
    /// Makes a history that contains only one collision, at simulated time `last` [s].
    pub fn at(last: f64) -> Self {
        Self { last, ..Self::default() }
    }

    /// Records a collision at simulated time `time` [s]. If the collision shows an inelastic collapse, returns the time
    /// [s] since the previous collision of the particle.
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

/// Speed [m/s] at which a particle slides along a curved wall. The particle hits the wall at ever smaller angles, so
/// impacts accumulate although no particle comes to rest. `None` for other collisions.
pub fn sliding(collision: &Collision, scene: &Scene) -> Option<f64> {
    /// [-] ratio of slip to speed of approach above which the particle slides.
    const FLAT: f64 = 1e3;
    let slip = collision.met.slip().norm();
    let is_curved = collision.couple.is_wall() && !collision.couple.is_flat(scene);
    (is_curved && slip > FLAT * collision.approach().abs()).then_some(slip)
}

/// Data that describe the inelastic collapse of a particle, for the error message.
#[derive(Clone, Copy, Debug)]
pub struct Collapsed {
    /// Number of impacts of the particle since the count was last set to 0.
    pub impacts: u32,
    /// Time [s] between the last two impacts.
    pub interval: f64,
    /// Contact time [s] of the TC model (elastic collisions within a contact time); `None` without this model.
    pub contact_time: Option<f64>,
    /// Speed [m/s] of sliding along a curved wall, if this is the reason for the many impacts.
    pub sliding: Option<f64>,
}

impl Collapsed {
    /// Makes the error at simulated time `time` [s] from the particle's id, its collision partner, and its position
    /// `place` [m].
    pub fn failure(&self, time: f64, (particle, partner): (u32, Partner), place: Vector3<f64>) -> Failure {
        let Self { impacts, interval, contact_time, sliding } = *self;
        let (impacts, [x, y, z]) = (u64::from(impacts), place.into());
        Failure::InelasticCollapse { time, particle, partner, impacts, interval, contact_time, sliding, x, y, z }
    }
}

/// Normal speed [m/s] away from the wall that is given to a particle at rest on the wall, in the TC model with the
/// contact time t_c. A particle is at rest if gravity, or the acceleration of a moving wall, presses it to the wall, and if it would rise by an unresolvably
/// small height. `None` for other particles, and without t_c.
///
/// Without t_c the particle would have infinitely many collisions in finite time. In reality a contact of finite
/// duration carries the weight during its contact time. Here the particle rebounds at a_n t_c/4, with a_n the
/// acceleration into the wall, and returns after t_c/2. This time is shorter than t_c, so the collision is always
/// elastic. The particle rises by a_n t_c²/32. The weight would compress a spring with this contact time (k = m
/// π²/t_c²) by a_n t_c²/π², about three times as far.
pub fn rests(collision: &Collision, scene: &Scene, contact_time: Option<f64>) -> Option<f64> {
    if !collision.couple.is_wall() {
        return None;
    }
    let approach = collision.approach();
    let weight = collision.wall.unwrap_or_default().pressing(&scene.gravity, &collision.met.normal);
    let speed = 0.25 * weight * contact_time?;
    let rise = 2.0 * weight * COLLAPSE_FLIGHT * scene.domain.size.max();
    (approach * approach <= rise && speed > approach).then_some(speed)
}

/// Particles that collided less than the contact time before `now` [s], each with the time of its last collision. Empty
/// without a contact time.
pub fn recent<'a>(
    met: impl Iterator<Item = &'a LastCollision>,
    contact_time: Option<f64>,
    now: f64,
) -> impl Iterator<Item = Recent> {
    let after = contact_time.map_or(f64::INFINITY, |time| now - time);
    let met = met.enumerate().filter(move |(_, met)| met.last > after);
    met.map(|(place, met)| Recent { place: place as u32, time: met.last })
}
