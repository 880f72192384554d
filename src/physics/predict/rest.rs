//! Floors on which particles come to rest, and the time until then.

use super::flow::{bulk_velocity, terminal_slip};
use super::pull::is_pulled;
use crate::experiment::Experiment;
use crate::particles::Particles;
use crate::scene::{Inlet, Kind, Scene, Species, Surface};
use crate::walls::Plane;
use nalgebra::Vector3;
use serde::Serialize;

/// Largest number of particles for which all pairs of particles are examined at the start.
pub(super) const ALL_PAIRS: usize = 2000;

/// Floor on which particles gather under gravity, with the time until they are at rest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rest {
    /// [m/s²] acceleration of particles by weight and buoyancy towards the floor, perpendicular to it; the largest
    /// value of all species.
    pub gravity: f64,
    /// [m] longest distance that a particle falls, from the start or from an inlet, to the floor or to the particles
    /// that lie on the floor.
    pub height: f64,
    /// [m/s] largest speed with which a particle can reach the floor.
    pub speed: f64,
    /// [s] time from the start of the run to the end of the first fall.
    pub fall: f64,
    /// [s] time from the start to the end of all bounces; infinite if no impact loses energy. If the run starts without
    /// particles, it is the time for the first particles that come in.
    pub time: f64,
    /// [-] largest restitution below 1 of all contacts that may occur, at the impact speed `speed`; 0 if all contacts
    /// have restitution 1, so that no impact loses energy.
    pub restitution: f64,
    /// [N] force between the floor and one particle at rest, if the weight of all particles is divided equally among
    /// the particles on the floor.
    pub weight: f64,
    /// True if gravity pulls the particles along the floor more than friction can hold, so that they slide or roll on.
    pub slides: bool,
    /// True if the particles are lighter than the fluid, so that they rise, and the floor is above them.
    pub rises: bool,
}

/// Motion of the particles of one species towards the floor.
#[derive(Clone, Copy)]
struct Sinking {
    /// [m/s²] acceleration by weight and buoyancy towards the floor.
    gravity: f64,
    /// [m/s] speed towards the floor at which drag balances the weight, for a sphere of the mean volume, and for the
    /// largest sphere; infinite without drag.
    settling: [f64; 2],
}

/// Particles of one species that fall from the start or from one inlet.
struct Falling {
    species: usize,
    /// [m] longest fall.
    height: f64,
    /// [m/s] largest speed with which a particle can reach the floor.
    speed: f64,
    /// [s] time at which the fall begins.
    start: f64,
}

/// Finds the floor of a scene: the flat wall against which weight and buoyancy press a species most strongly. `None`
/// if there is no such wall, if no particle falls to it, if the gas lifts the particles, if a wall moves or is
/// thermal, or with a thermostat. `lift` [m/s] is the component of the gas velocity against gravity, minus the
/// terminal slip speed (the speed relative to the gas at which drag balances the weight).
///
/// The time until rest is that of a sphere dropped from the height h. Without drag, its fall and all bounces together
/// last (1+e)/(1-e) sqrt(2h/g) with the restitution e (a geometric series). If e depends on the speed, the bounces are
/// added one by one. Drag makes the fall longer, and limits its speed to that of settling. Two effects are neglected:
/// drag also shortens the bounces, and neighbours slow down a fall. A bed of N spheres needs less time than one
/// sphere.
pub fn rest(experiment: &Experiment, particles: &Particles, lift: Option<f64>) -> Option<Rest> {
    let scene = &experiment.scene;
    // walls that move or are thermal, and a thermostat, may throw the particles up again
    if lift.is_some_and(|lift| lift > 0.0) || scene.has_moving_walls() || scene.is_heated() {
        return None;
    }
    let expected = experiment.expected_counts();
    let present = || scene.species.iter().zip(&expected).filter(|(_, count)| **count > 0.0).map(|(species, _)| species);
    let into = |floor: &Plane| present().map(|one| scene.gravity_of(one).dot(&floor.normal)).fold(0.0, f64::min);
    let planes = (0u32..).zip(&scene.walls).filter_map(|(index, wall)| Some((wall.geometry.plane()?, index)));
    let floors = planes.map(|(plane, index)| (into(plane), plane, index)).filter(|(into, ..)| *into < 0.0);
    let (into, plane, floor) = floors.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let sinking: Vec<Option<Sinking>> = scene.species.iter().map(|one| sinking(scene, one, &plane.normal)).collect();
    let falling = falling_from_start(scene, particles, plane, &sinking);
    let coming: Vec<Falling> =
        scene.inlets.iter().filter_map(|inlet| falling_from(scene, inlet, plane, &sinking)).collect();
    let first = coming.iter().min_by(|a, b| a.start.total_cmp(&b.start)).filter(|_| falling.is_empty());
    // the pair of bodies with the least energy loss bounces longest
    let is_paired = expected.iter().sum::<f64>() > 1.0;
    let pairs = scene.meetings().filter(|_| is_paired).map(|(_, _, meeting)| meeting);
    let at_floor = (0..scene.species.len() as u16).map(|species| scene.meeting(species, Kind::Wall(floor)));
    let surfaces: Vec<Surface> = pairs.chain(at_floor).map(|meeting| meeting.surface).collect();
    let timed = falling.iter().chain(first);
    let times = timed.filter_map(|group| Some(times(group, sinking[group.species]?, &surfaces)));
    let [fall, time] = times.reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])])?;
    let largest = |of: fn(&Falling) -> f64| falling.iter().chain(&coming).map(of).fold(0.0, f64::max);
    let (height, speed) = (largest(|group| group.height), largest(|group| group.speed));
    let lossy = surfaces.iter().map(|surface| surface.restitution_at(speed)).filter(|e| *e < 1.0).fold(0.0, f64::max);
    Some(Rest {
        gravity: -into,
        height,
        speed,
        fall,
        time,
        restitution: lossy,
        weight: weight_on_floor(experiment, particles, plane, &sinking),
        slides: is_pulled(scene),
        rises: scene.gravity_alone().dot(&plane.normal) > 0.0,
    })
}

/// Motion of the particles of `species` towards a floor with the unit normal `up`. `None` if gravity does not press
/// the particles onto the floor, or if the gas carries them away from the floor.
fn sinking(scene: &Scene, species: &Species, up: &Vector3<f64>) -> Option<Sinking> {
    let weight = scene.gravity_of(species);
    let gravity = -weight.dot(up);
    if gravity <= 0.0 {
        return None;
    }
    let Some((fluid, drag)) = scene.fluid.as_ref().and_then(|fluid| Some((fluid, fluid.drag.as_ref()?))) else {
        return Some(Sinking { gravity, settling: [f64::INFINITY; 2] });
    };
    // the gas flows along z
    let away = if up.z == 0.0 { 0.0 } else { up.z * bulk_velocity(fluid, scene.domain.size.y) };
    let settling = [species.diameter, species.largest()].map(|diameter| {
        let sphere = fluid.sphere(&species.of_one_size(diameter));
        terminal_slip(drag, &sphere, weight.norm()) * gravity / weight.norm() - away
    });
    (settling[0] > 0.0).then_some(Sinking { gravity, settling })
}

/// For each species, the fall of its initial particles to the floor `plane`; species without particles that fall are
/// left out. `sinking` is the motion of each species towards the floor.
fn falling_from_start(
    scene: &Scene,
    particles: &Particles,
    plane: &Plane,
    sinking: &[Option<Sinking>],
) -> Vec<Falling> {
    let mut groups: Vec<Option<Falling>> = scene.species.iter().map(|_| None).collect();
    let places = particles.position.iter().zip(&particles.velocity).zip(&particles.radius);
    for (((x, v), &r), &species) in places.zip(&particles.species) {
        let species = usize::from(species);
        let Some(sinking) = sinking[species] else { continue };
        // a distance below the rounding of positions does not count as a fall
        let fall = gap(plane, x, r) - stacked(scene, particles, &plane.normal, x, r);
        let fall = if fall > 1e-9 * r { fall } else { 0.0 };
        let group = groups[species].get_or_insert(Falling { species, height: 0.0, speed: 0.0, start: 0.0 });
        group.height = group.height.max(fall);
        group.speed = group.speed.max(sinking.speed(v.dot(&plane.normal), fall));
    }
    groups.into_iter().flatten().collect()
}

/// Particles that fall from an inlet to the floor `plane`, at the mean velocity of the inlet. `None` if they do not
/// sink to this floor.
fn falling_from(scene: &Scene, inlet: &Inlet, plane: &Plane, sinking: &[Option<Sinking>]) -> Option<Falling> {
    let species = usize::from(inlet.species);
    let sinking = sinking[species]?;
    let [low, high] = inlet.region.corners();
    let highest = low.zip_zip_map(&high, &plane.normal, |low, high, up| if up > 0.0 { high } else { low });
    // the region contains the whole sphere
    let height = gap(plane, &highest, scene.species[species].diameter);
    let speed = sinking.speed(inlet.velocity_mean.dot(&plane.normal), height);
    Some(Falling { species, height, speed, start: inlet.start })
}

/// [m] distance between a floor and a sphere with the centre `x` [m] and the radius `r` [m]; 0 if they touch.
fn gap(plane: &Plane, x: &Vector3<f64>, r: f64) -> f64 {
    ((x - plane.point).dot(&plane.normal) - r).max(0.0)
}

impl Sinking {
    /// [m/s] largest speed with which a particle can reach the floor after a fall by `fall` [m], if it starts with the
    /// velocity component `normal` [m/s] normal to the floor.
    fn speed(&self, normal: f64, fall: f64) -> f64 {
        let free = (normal.powi(2) + 2.0 * self.gravity * fall).sqrt();
        free.min(self.settling[1].max(normal.abs()))
    }

    /// [s] upper limit of the time of a fall from rest by `height` [m].
    ///
    /// With the settling speed w the acceleration is at least g (1 - v/w) at the speed v, since drag grows at least as
    /// fast as v. So the fall lasts at most as long as with linear drag. With linear drag the distance after the time t
    /// is w (t - τ (1 - exp(-t/τ))), with τ = w/g.
    fn time(&self, height: f64) -> f64 {
        let (free, settling) = ((2.0 * height / self.gravity).sqrt(), self.settling[0]);
        if settling.is_infinite() || height == 0.0 {
            return free;
        }
        let response = settling / self.gravity;
        let (mut low, mut high) = (free, height / settling + response);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            // expm1 keeps the small difference of a fall that is short compared with the response time
            let passed = settling * (middle + response * (-middle / response).exp_m1());
            if passed < height { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}

/// [s] times from the start of the run to the end of the fall of a group of particles, and to the end of their bounces
/// on the surfaces `surfaces`. The second time is infinite if no impact loses energy.
fn times(group: &Falling, sinking: Sinking, surfaces: &[Surface]) -> [f64; 2] {
    let (speed, flight) = (group.speed, group.speed / sinking.gravity);
    let fall = group.start + flight.max(sinking.time(group.height));
    if speed == 0.0 {
        return [fall; 2];
    }
    let lossy = surfaces.iter().filter(|surface| surface.restitution_at(speed) < 1.0);
    let longest = lossy.map(|surface| falls(surface, speed)).reduce(f64::max);
    [fall, fall + (longest.unwrap_or(f64::INFINITY) - 1.0) * flight]
}

/// [N] weight of all particles that sink to the floor `plane`, divided by the number of particles on the floor.
/// Particles that inlets are expected to bring are included.
fn weight_on_floor(experiment: &Experiment, particles: &Particles, plane: &Plane, sinking: &[Option<Sinking>]) -> f64 {
    let scene = &experiment.scene;
    let gravity = |species: usize| sinking[species].map_or(0.0, |sinking| sinking.gravity);
    let of_start = particles.mass.iter().zip(&particles.species).map(|(m, &species)| m * gravity(usize::from(species)));
    let coming = experiment.expected_counts().into_iter().zip(experiment.counts()).map(|(all, now)| all - now as f64);
    let to_come = coming.zip(&scene.species).enumerate().map(|(k, (count, one))| count * one.mass() * gravity(k));
    // number of particles on the floor: those whose gap is less than their radius or, if there are none, those that fit
    // on it
    let places = particles.position.iter().zip(&particles.radius);
    let near = places.filter(|(x, r)| gap(plane, x, **r) < **r).count();
    let area = (0..3).map(|k| scene.domain.size[k]).product::<f64>() / scene.domain.size.dot(&plane.normal.abs());
    let places_on_floor = (area / scene.largest_diameter().powi(2)).floor();
    let on_floor = if near > 0 { near as f64 } else { places_on_floor };
    let on_floor = on_floor.min(experiment.expected_count()).max(1.0);
    (of_start.sum::<f64>() + to_come.sum::<f64>()) / on_floor
}

/// [-] duration of the first fall and all bounces of a sphere, over the time of this fall. The sphere first meets the
/// surface at `speed` [m/s]. The ratio is (1+e)/(1-e) for a constant restitution e. For a restitution that depends on
/// the speed, it is 1 + 2 Σ u_k/u_0, with the speed u_0 of the first impact and the speeds u_k of the rebounds. The
/// sum ends at slow rebounds. The ratio is infinite if rebounds never become slow, because slow impacts are elastic.
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

/// [m] sum of the diameters of the spheres between a sphere and the floor. A sphere cannot fall through this part of
/// its height. `x` [m] is the centre and `radius` [m] the radius of the sphere, and `up` the unit normal of the floor.
/// The result is 0 for scenes with many particles.
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
    /// e^k times as long as a fall without drag to the speed of the first impact, with the restitution e. If no impact
    /// loses energy, e is 1.
    pub fn bounces(&self, duration: f64) -> f64 {
        let (e, flight) = (self.restitution, self.speed / self.gravity);
        if flight <= 0.0 || duration <= self.fall {
            return 0.0;
        }
        if e == 0.0 && self.time.is_infinite() {
            return 1.0 + (0.5 * (duration - self.fall) / flight).floor();
        }
        let left = 1.0 - (duration - self.fall) / flight * (1.0 - e) / (2.0 * e);
        // after the end of the series, the bounces are counted whose speed is above a millionth of the first speed
        1.0 + (left.max(1e-6).ln() / e.ln()).floor()
    }
}
