//! Collision history of each particle, by which inelastic collapse is detected. In an inelastic collapse a particle has
//! infinitely many impacts in finite time. An island is a group of particles that may meet within a window, the time
//! between two exchanges with the gas.

use super::impulse::Collision;
use crate::encounter::Partner;
use crate::engine::Failure;
use crate::scene::Scene;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Number of successive impacts of one particle, each after an unresolvably short flight, that counts as an inelastic
/// collapse. For comparison, a chain of n touching spheres transmits a blow in fewer than n²/2 collisions (200 for 20
/// spheres). So scenes without collapse have fewer such impacts in succession.
const COLLAPSE_STREAK: u8 = 200;

/// [-] length of a flight divided by the longest edge of the box, below which the flight is unresolvably short.
/// Coordinates are rounded to 2e-16 of the box at every collision. After a flight below the limit, rounding determines
/// which body a sphere meets next.
const COLLAPSE_FLIGHT: f64 = 64.0 * f64::EPSILON;

/// Number of successive flights of a particle, each shorter than the one before, that precede an inelastic collapse. If
/// an unresolvably short flight follows, and the collision at its end loses energy, the particle has collapsed. A
/// collapsing group has only some dozen more impacts after such a flight, because its relative speeds then fall below
/// rounding. So the limit [`COLLAPSE_STREAK`] would not be reached. By chance, three flights in a row are each shorter
/// than the one before in one of 24 cases. A chance flight is shorter than 10⁻¹⁴ of the box with a probability of about
/// 10⁻¹⁴.
const ZENO_FLIGHTS: u8 = 3;

/// Number of impacts of one particle within one window, the time between two exchanges with the gas, that counts as an
/// inelastic collapse. The limit does not apply in the TC model, in which a collision is elastic if the particle
/// collided less than a contact time before. Spheres at rest then collide about once per contact time, without end.
const COLLAPSE_IMPACTS: u32 = 1_000_000;

/// Last collision of one particle, stored from one window (time between two exchanges with the gas) to the next. It is
/// needed in the TC model, in which a collision is elastic if the particle collided less than a contact time before.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Recent {
    /// Index of the particle in the particle store.
    pub index: u32,
    /// [s] simulated time of the particle's last collision.
    pub time: f64,
}

/// Collision history of one particle.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct LastCollision {
    /// Number of impacts of the particle since the last reset to 0. The number is reset at the start of each window
    /// (time between two exchanges with the gas). Islands (groups of particles that may meet) and collisions by chance
    /// (DSMC) also reset the number within a window.
    pub impacts: u32,
    /// Number of successive impacts, each after a flight too short to be resolved; an impact after a longer flight sets
    /// the number to 0. The event queue of all particles keeps it from window to window. In an island (group of
    /// particles solved separately) it begins at 0.
    streak: u8,
    /// Number of successive resolvable flights of the particle, each shorter than the one before; at most 255. A longer
    /// flight, or one too short to be resolved, sets the number to 0. In an island (group of particles solved
    /// separately) it begins at 0.
    shrinking: u8,
    /// [m] time between the last two impacts of the particle, times the speed of approach at the last impact. This
    /// product measures the length of the flight relative to the body that was hit.
    flown: f64,
    /// [s] simulated time of the particle's last collision; minus infinity before its first collision.
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

    /// Adds a collision at simulated time `time` [s] to the history of the particle. Returns the time [s] since the
    /// particle's previous collision if the collisions show an inelastic collapse, otherwise `None`. `contact_time` [s]
    /// is the contact time of the TC model, in which a collision is elastic if the particle collided less than this
    /// time before; `None` without this model.
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

/// Speed [m/s] at which a particle slides along a curved wall, hitting the wall at ever smaller angles. Impacts then
/// accumulate although no particle comes to rest. `None` if the particle does not slide, or if the other body is a flat
/// wall or a particle.
pub fn sliding(collision: &Collision, scene: &Scene) -> Option<f64> {
    /// [-] ratio of tangential speed to speed of approach above which a particle slides along a curved wall.
    const FLAT: f64 = 1e3;
    let slip = collision.met.slip().norm();
    let is_curved = collision.couple.is_wall() && !collision.couple.is_flat(scene);
    (is_curved && slip > FLAT * collision.approach().abs()).then_some(slip)
}

/// Numbers that describe the inelastic collapse of a particle (infinitely many impacts in finite time), for the error
/// message.
#[derive(Clone, Copy, Debug)]
pub struct Collapsed {
    /// Number of impacts of the particle in this window (time between two exchanges with the gas). Impacts in islands
    /// (groups of particles solved separately) earlier in the window are not counted.
    pub impacts: u32,
    /// [s] time between the last two impacts of the particle.
    pub interval: f64,
    /// Contact time [s] of the TC model, in which a collision is elastic if the particle collided less than this time
    /// before; `None` without this model.
    pub contact_time: Option<f64>,
    /// Speed [m/s] of sliding along a curved wall, if this is the reason for the many impacts; otherwise `None`.
    pub sliding: Option<f64>,
}

impl Collapsed {
    /// Makes the error that stops the run at simulated time `time` [s]. `particle` is the id of the collapsing
    /// particle, `partner` the body that it hit last, and `position` [m] its position.
    pub fn failure(&self, time: f64, (particle, partner): (u32, Partner), position: Vector3<f64>) -> Failure {
        let Self { impacts, interval, contact_time, sliding } = *self;
        let (impacts, [x, y, z]) = (u64::from(impacts), position.into());
        Failure::InelasticCollapse { time, particle, partner, impacts, interval, contact_time, sliding, x, y, z }
    }
}

/// Normal speed [m/s] away from the wall that the TC model gives to a particle at rest on a wall. In this model a
/// collision is elastic if the particle collided less than the contact time t_c before. `None` if the particle does not
/// rest, if the other body is no wall, or without t_c. A particle rests if gravity, or the acceleration of a moving
/// wall, presses it to the wall, and if its speed of approach is very small. With this speed of approach, the particle
/// would rise from the wall by an unresolvably small height. No particle rests on a thermal wall, whose rebounds do not
/// depend on the speed of approach.
///
/// Without t_c the particle would have infinitely many collisions in finite time. In reality a contact of finite
/// duration carries the weight during its contact time. Here the particle rebounds at a_n t_c/4, with a_n the
/// acceleration into the wall, and returns after t_c/2. This time is shorter than t_c, so the collision is always
/// elastic. The particle rises by a_n t_c²/32. The weight would compress a spring with this contact time (k = m
/// π²/t_c²) by a_n t_c²/π², about three times as far.
pub fn rests(collision: &Collision, scene: &Scene, contact_time: Option<f64>) -> Option<f64> {
    if !collision.couple.is_wall() || collision.is_thermal(scene) {
        return None;
    }
    let approach = collision.approach();
    let weight = collision.wall.unwrap_or_default().pressing(&scene.gravity, &collision.met.normal);
    let speed = 0.25 * weight * contact_time?;
    let rise = 2.0 * weight * COLLAPSE_FLIGHT * scene.domain.size.max();
    (approach * approach <= rise && speed > approach).then_some(speed)
}

/// Selects from the collision histories `met`, one per particle in the order of their indices, the particles that
/// collided less than the contact time before simulated time `now` [s]. In the TC model, their next collision may be
/// elastic for this reason. Each is returned with the time of its last collision. The result is empty without a contact
/// time.
pub fn recent<'a>(
    met: impl Iterator<Item = &'a LastCollision>,
    contact_time: Option<f64>,
    now: f64,
) -> impl Iterator<Item = Recent> {
    let after = contact_time.map_or(f64::INFINITY, |time| now - time);
    let met = met.enumerate().filter(move |(_, met)| met.last > after);
    met.map(|(index, met)| Recent { index: index as u32, time: met.last })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::Domain;
    use crate::encounter::{AtWall, Couple, Encounter};
    use crate::scene::{Kind, Surface};
    use crate::walls::{Plane, ThermalWall, Wall, WallGeometry};

    /// Checks a sphere that approaches a floor at 1 nm/s. With a contact time t_c the sphere rests on an ordinary
    /// floor, and leaves the floor at the speed g t_c/4. On a thermal floor the sphere does not rest.
    #[test]
    fn no_particle_rests_on_a_thermal_wall() {
        let lossy = Surface::new(0.5, 0.0);
        let plane = Plane { point: Vector3::zeros(), normal: Vector3::y() };
        let mut scene = Scene {
            walls: vec![Wall::new(WallGeometry::Plane(plane), lossy)],
            gravity: Vector3::y() * -9.81,
            ..Scene::new(Domain::new(Vector3::from_element(0.1), [true, false, true]), lossy, Vec::new())
        };
        let velocity = Vector3::y() * -1e-9;
        let met = Encounter { normal: Vector3::y(), gap: 0.0, velocity, normal_velocity: -1e-9 };
        let (couple, kinds) = (Couple::at_wall(0, AtWall::first(0)), (0, Kind::Wall(0)));
        let collision = Collision { couple, met, elastic: false, kinds, wall: None, image: 0.0 };
        assert_eq!(rests(&collision, &scene, Some(1e-4)), Some(0.25 * 9.81 * 1e-4));
        assert!(collision.loses(&scene));
        scene.walls[0].thermal = Some(ThermalWall { temperature: 1.0, seed: 1 });
        assert_eq!(rests(&collision, &scene, Some(1e-4)), None);
        assert!(!collision.loses(&scene));
    }
}
