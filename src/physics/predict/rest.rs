//! Particles at rest on a floor, and particles that touch more than one neighbour.

use crate::encounter::{FrameTime, Other};
use crate::neighbours::NeighbourList;
use crate::particles::Particles;
use crate::scene::{Kind, Scene, Surface};
use nalgebra::Vector3;
use serde::Serialize;

/// [-] gap between two neighbours at the start, over the overlap of an impact, below which the contacts of a sphere
/// with both neighbours overlap in time. The number follows from solutions of the three-sphere equations. Three spheres
/// in a row with gaps of twice u sqrt(m/k) agree with a sequence of two impacts to 1e-6. With half of these gaps they
/// differ by more than 1e-2.
const SEPARATE: f64 = 2.0;

/// Largest number of particles for which all pairs of particles are examined at the start.
const ALL_PAIRS: usize = 2000;

/// Floor on which particles gather under gravity, with the time until they are at rest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rest {
    /// [m/s²] component of gravity normal to the floor, towards it.
    pub gravity: f64,
    /// [m] longest fall of a particle from the start: down to the floor, or to the particles that lie on the floor.
    pub height: f64,
    /// [m/s] largest speed with which a particle can reach the floor.
    pub speed: f64,
    /// [s] time from the start to the end of all bounces; infinite if no impact loses energy.
    pub time: f64,
    /// [-] restitution, at the impact speed `speed`, of the contact with the smallest energy loss above zero; 0 if no
    /// impact loses energy.
    pub restitution: f64,
    /// [N] force between the floor and one particle at rest, if the weight of all particles is divided equally among
    /// the particles on the floor.
    pub weight: f64,
}

/// Finds the floor of a scene: the flat wall against which gravity presses most. `None` if there is no such wall, if
/// the gas lifts the particles, if a wall moves or is thermal, or with a thermostat. `lift` [m/s] is the component of the gas velocity against gravity,
/// minus the terminal slip speed.
///
/// The time until rest is that of a sphere dropped from the height h. Its fall and all bounces together last
/// (1+e)/(1-e) sqrt(2h/g) (a geometric series). If e depends on the speed, the bounces are added one by one. A bed of N
/// spheres needs less time than one sphere.
pub fn rest(scene: &Scene, particles: &Particles, lift: Option<f64>) -> Option<Rest> {
    // walls that move or are thermal, and a thermostat, may throw the particles up again
    let is_fed = scene.has_moving_walls() || scene.is_heated();
    if lift.is_some_and(|lift| lift > 0.0) || particles.is_empty() || is_fed {
        return None;
    }
    let planes = (0u32..).zip(&scene.walls).filter_map(|(index, wall)| Some((wall.geometry.plane()?, index)));
    let floors = planes.filter(|(plane, _)| scene.gravity.dot(&plane.normal) < 0.0);
    let (plane, floor) = floors.min_by(|a, b| {
        let into = |floor: &crate::walls::Plane| scene.gravity.dot(&floor.normal);
        into(a.0).total_cmp(&into(b.0))
    })?;
    let gravity = -scene.gravity.dot(&plane.normal);
    let places = || particles.position.iter().zip(&particles.velocity).zip(&particles.radius);
    let gap = |x: &Vector3<f64>, r: f64| ((x - plane.point).dot(&plane.normal) - r).max(0.0);
    let below = |x: &Vector3<f64>, r: f64| stacked(scene, particles, &plane.normal, x, r);
    let (mut height, mut speed) = (0.0f64, 0.0f64);
    for ((x, v), &r) in places() {
        // a distance below the rounding of positions does not count as a fall
        let fall = gap(x, r) - below(x, r);
        let fall = if fall > 1e-9 * r { fall } else { 0.0 };
        height = height.max(fall);
        speed = speed.max((v.dot(&plane.normal).powi(2) + 2.0 * gravity * fall).sqrt());
    }
    // the pair of bodies with the least energy loss bounces longest
    let pairs = scene.meetings().filter(|_| particles.len() > 1).map(|(_, _, meeting)| meeting);
    let at_floor = (0..scene.species.len() as u16).map(|species| scene.meeting(species, Kind::Wall(floor)));
    let surfaces: Vec<Surface> = pairs.chain(at_floor).map(|meeting| meeting.surface).collect();
    let at_speed = || surfaces.iter().map(|surface| (surface, surface.restitution_at(speed)));
    let lossy = at_speed().filter(|(_, e)| *e < 1.0).map(|(_, e)| e).fold(0.0, f64::max);
    let falls = at_speed().filter(|(_, e)| *e < 1.0).map(|(surface, _)| falls(surface, speed)).reduce(f64::max);
    let time = falls.unwrap_or(f64::INFINITY) * (speed / gravity);
    // number of particles on the floor: those whose gap is less than their radius or, if there are none, those that fit
    // on it
    let near = places().filter(|((x, _), r)| gap(x, **r) < **r).count();
    let area = (0..3).map(|k| scene.domain.size[k]).product::<f64>() / scene.domain.size.dot(&plane.normal.abs());
    let widest = particles.radius.iter().fold(0.0, |a: f64, &r| a.max(2.0 * r));
    let places_on_floor = (area / (widest * widest)).floor().max(1.0);
    let on_floor = if near > 0 { near as f64 } else { places_on_floor };
    let on_floor = on_floor.clamp(1.0, particles.len() as f64);
    let weight = particles.mass.iter().sum::<f64>() * gravity / on_floor;
    Some(Rest { gravity, height, speed, time, weight, restitution: lossy })
}

/// [-] duration of the first fall and all bounces of a sphere, over the time of this fall. The sphere first meets the
/// surface at `speed` [m/s]. The ratio is (1+e)/(1-e) for a constant restitution e. Otherwise it is 1 + 2 Σ u_k/u_0,
/// with the speed u_0 of the first impact and the speeds u_k of the rebounds. The sum ends at slow rebounds. The ratio
/// is infinite if rebounds never become slow, because slow impacts are elastic.
fn falls(surface: &Surface, speed: f64) -> f64 {
    /// [-] speed of a rebound over the speed of the first impact, below which bounces are neglected.
    const SLOW: f64 = 1e-6;
    /// Largest number of bounces that are added one by one.
    const MOST: u32 = 100_000;
    if surface.by_speed.is_none() {
        return (1.0 + surface.restitution) / (1.0 - surface.restitution);
    }
    let (mut now, mut sum) = (speed, 1.0);
    for _ in 0..MOST {
        now *= surface.restitution_at(now);
        sum += 2.0 * now / speed;
        if now <= SLOW * speed {
            return sum;
        }
    }
    f64::INFINITY
}

/// [m] part of the height of a sphere above the floor that is occupied by spheres between it and the floor: the sum of
/// their diameters. `x` [m] is the centre and `radius` [m] the radius of the sphere, and `up` the unit normal of the
/// floor. The result is 0 for scenes with many particles.
fn stacked(scene: &Scene, particles: &Particles, up: &Vector3<f64>, x: &Vector3<f64>, radius: f64) -> f64 {
    if particles.len() > ALL_PAIRS {
        return 0.0;
    }
    let under = particles.position.iter().zip(&particles.radius).filter(|(y, r)| {
        let apart = scene.domain.separation(x, y);
        let rise = apart.dot(up);
        rise > 0.0 && (apart - up * rise).norm() < radius + **r
    });
    under.map(|(_, r)| 2.0 * r).sum()
}

impl Rest {
    /// Number of bounces, within `duration` [s], of the sphere that falls farthest. The flight after bounce k lasts 2
    /// e^k times as long as the first fall, with the restitution e.
    pub fn bounces(&self, duration: f64) -> f64 {
        let (e, fall) = (self.restitution, self.speed / self.gravity);
        if fall <= 0.0 || duration <= fall {
            return 0.0;
        }
        let left = 1.0 - (duration / fall - 1.0) * (1.0 - e) / (2.0 * e);
        // after the end of the series, the bounces are counted whose speed is above a millionth of the first speed
        1.0 + (left.max(1e-6).ln() / e.ln()).floor()
    }
}

/// True if spheres overlap each other or a wall by more than the rounding of positions.
pub fn overlapping(scene: &Scene, particles: &Particles) -> bool {
    /// [-] largest overlap that counts as rounding of typed positions, divided by the diameter.
    const ROUNDING: f64 = 1e-9;
    let mut list = NeighbourList::default();
    let mut sorted = particles.clone();
    list.build(&mut sorted, scene, 0.0);
    let mut slots = Vec::new();
    list.overlapping(&sorted, scene, &mut slots);
    slots.iter().any(|&slot| {
        let couple = list.couple(slot as usize);
        couple.meet(&sorted, scene, FrameTime::default()).overlap() > ROUNDING * couple.diameter(&sorted)
    })
}

/// Number of particles that lie on a wall or on another particle. The gap below such a particle is less than a
/// thousandth of its diameter. Neither body may be faster than after a fall through this gap. `given` contains, for
/// each id, true if the case gives the position. Particles at random positions are not counted, because they may be
/// this close by chance.
pub fn lying(scene: &Scene, particles: &Particles, given: &[bool]) -> usize {
    /// [-] largest gap below a particle that counts as lying, over its diameter. Overlaps of glass beads of 1 mm at 10
    /// kN/m are 1e-6 of a diameter under their weight, and 1e-3 under a thousand layers.
    const NEAR: f64 = 1e-3;
    let mut list = NeighbourList::default();
    let mut sorted = particles.clone();
    list.build(&mut sorted, scene, 0.0);
    let near = |i: usize| 2.0 * NEAR * sorted.radius[i];
    let given = |i: usize| given.get(sorted.id[i] as usize).is_some_and(|given| *given);
    let slow = |i: usize| given(i) && sorted.velocity[i].norm_squared() <= 2.0 * scene.gravity.norm() * near(i);
    let mut lies = vec![false; sorted.len()];
    for couple in (0..list.slots()).map(|slot| list.couple(slot)) {
        let met = couple.meet(&sorted, scene, FrameTime::default());
        let i = Some(couple.i as usize);
        let other = match couple.other {
            Other::Particle(j) => Some(j as usize),
            Other::Wall(_) => None,
        };
        let all_slow = i.into_iter().chain(other).all(slow);
        let close = i.into_iter().chain(other).any(|i| met.overlap() > -near(i));
        let held = -scene.gravity.dot(&met.normal);
        if all_slow && close && held != 0.0 {
            // the upper particle of a pair lies on the lower one
            let upper = if held > 0.0 { i } else { other };
            upper.into_iter().for_each(|i| lies[i] = true);
        }
    }
    lies.into_iter().filter(|lies| *lies).count()
}

/// True if some particle at the start has two neighbours (or a neighbour and a wall) so close that an impact has
/// contacts with both at the same time. `overlap` [m] is the overlap of such an impact. Hard spheres would transmit the
/// impulse in successive collisions. The test is for starts with given positions, since particles at random positions
/// are farther apart. More than 2000 particles are not tested, and the result is then false.
pub fn in_a_row(scene: &Scene, particles: &Particles, overlap: f64) -> bool {
    let count = particles.len();
    if count > ALL_PAIRS {
        return false;
    }
    let near = SEPARATE * overlap.max(1e-9 * particles.radius.iter().fold(0.0, |a: f64, &r| a.max(r)));
    (0..count).any(|i| {
        let (x, r) = (&particles.position[i], particles.radius[i]);
        let beside = (0..count).filter(|&j| {
            let apart = scene.domain.separation(x, &particles.position[j]).norm();
            j != i && apart - r - particles.radius[j] < near
        });
        let walls = scene.walls.iter().filter(|wall| wall.geometry.nearest(x).distance - r < near);
        beside.count() + walls.count() > 1
    })
}
