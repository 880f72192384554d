//! Scenes whose motion has a closed-form solution: a cooling gas, a fall in a gas, one bouncing sphere, and a row of
//! spheres that transmit an impulse. All solutions are for hard spheres. The motion of soft spheres is delayed by the
//! duration of their contacts.

use super::flow::terminal_slip;
use super::gas::{AgitationSpread, Component, gas};
use crate::experiment::{Experiment, Model};
use crate::fluid::Profile;
use crate::scene::{Kind, Scene, Surface};
use nalgebra::Vector3;

/// Smallest number of particles in a periodic box that are treated as a cooling gas.
const FEWEST: usize = 100;

/// Cooling gas of equal spheres. Inelastic collisions remove its energy, and nothing replaces the energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cooling {
    /// [m²/s²] granular temperature T of the gas at the start.
    temperature: f64,
    /// [1/s] number of collisions per particle and time at the start, by Enskog's theory.
    rate: f64,
    /// [1/s] number of collisions of all pairs per time at the start of the run.
    pair_rate: f64,
    /// [-] square of the restitution e of the collisions.
    square: f64,
}

/// True if only gravity and collisions change the velocities of particles, no particle comes in or leaves, and no wall
/// is rough. Otherwise the closed forms of this module do not hold.
fn is_undriven(scene: &Scene) -> bool {
    let driven = scene.is_kicked() || scene.is_heated() || scene.domain.shear.is_some();
    !(driven || scene.has_openings() || scene.has_rough_walls())
}

/// [s] contact time of the TC model of hard spheres, which makes collisions in quick succession elastic; `None` for
/// other engines, or if the case does not give this time.
fn contact_time(experiment: &Experiment) -> Option<f64> {
    experiment.hard.contact_time.filter(|_| experiment.model() == Model::Hard)
}

impl Cooling {
    /// Makes a cooling gas of `count` particles that start with the granular temperature `temperature` [m²/s²]. `None`
    /// unless the scene is a periodic box of many equal spheres with constant restitution below 1. Friction, rotation,
    /// drag, heating, shear, inlets, outlets, walls and a contact time (TC model) also give `None`. For direct
    /// simulation Monte Carlo without the Enskog factor, the collision rate is that of a dilute gas.
    pub fn of(experiment: &Experiment, count: usize, temperature: f64) -> Option<Self> {
        let scene = &experiment.scene;
        let [species] = scene.species.as_slice() else { return None };
        if scene.has_sizes() {
            return None;
        }
        let alone = is_undriven(scene) && scene.walls.is_empty() && scene.domain.periodic == [true; 3];
        let contact = scene.surface(0, Kind::Species(0));
        let smooth = scene.rotation.is_none() && contact.friction == 0.0;
        let smooth = smooth && contact.by_speed.is_none() && contact.restitution < 1.0;
        let smooth = smooth && contact_time(experiment).is_none();
        if !(alone && smooth && count >= FEWEST && temperature > 0.0) {
            return None;
        }
        let component = Component { count, diameter: species.diameter, variance: temperature };
        let at_start = gas(scene, &[component], &AgitationSpread::even());
        let square = contact.restitution * contact.restitution;
        let dilute = experiment.model() == Model::Dsmc && !experiment.dsmc.enskog;
        let factor = if dilute { at_start.contact_value } else { 1.0 };
        let [rate, pair_rate] = [at_start.collision_rate, at_start.pair_rate].map(|rate| rate / factor);
        Some(Self { temperature, rate, pair_rate, square })
    }

    /// [-] ratio T(t)/T(0) of the granular temperature at `time` t [s] to that at the start (Haff 1983, J. Fluid Mech.
    /// 134, 401). It is (1 + (1 - e²) Γ_0 t/6)^-2, with e the restitution and Γ_0 [1/s] the collision rate per particle
    /// at the start.
    fn left(&self, time: f64) -> f64 {
        (1.0 + (1.0 - self.square) * self.rate * time / 6.0).powi(-2)
    }

    /// [m²/s²] granular temperature of the cooling gas at `time` [s]. The formula is valid as long as the gas stays
    /// homogeneous.
    pub fn temperature(&self, time: f64) -> f64 {
        self.temperature * self.left(time)
    }

    /// [1/s] number of collisions of all pairs per time, at `time` [s]. The rate is proportional to the root of the
    /// granular temperature.
    pub fn pair_rate(&self, time: f64) -> f64 {
        self.pair_rate * self.left(time).sqrt()
    }
}

/// [m/s] settling velocity of a single sphere: the gas velocity plus the slip velocity (relative to the gas) at which
/// drag balances the weight. `None` without gravity or drag, for a gas velocity that depends on the position, or for
/// several species or sizes. Also `None` if the drag law depends on the volume fraction of the particles.
pub fn settling_velocity(scene: &Scene) -> Option<Vector3<f64>> {
    let fluid = scene.fluid.as_ref()?;
    let (drag, [species], Profile::Uniform(gas)) = (fluid.drag.as_ref()?, scene.species.as_slice(), &fluid.profile)
    else {
        return None;
    };
    if scene.has_sizes() || drag.law().cells().is_some() {
        return None;
    }
    let down = scene.gravity.try_normalize(0.0)?;
    Some(Vector3::z() * *gas + down * terminal_slip(drag, &fluid.sphere(species), scene.gravity.norm()))
}

/// Free flight of a sphere between two bounces.
#[derive(Clone, Copy, Debug, PartialEq)]
struct BounceFlight {
    /// [s] simulated time at which the flight begins.
    begin: f64,
    /// [m] height of the centre at the start of the flight, measured upwards.
    height: f64,
    /// [m/s] upward velocity at the start of the flight.
    velocity: f64,
}

/// Sphere that bounces from a floor, and from a ceiling if there is one, without drag. Both are perpendicular to
/// gravity.
#[derive(Clone, Debug, PartialEq)]
pub struct Bouncing {
    /// [m/s²] magnitude of the acceleration by gravity.
    gravity: f64,
    /// [-] unit vector upwards, opposite to gravity.
    up: Vector3<f64>,
    flights: Vec<BounceFlight>,
}

impl Bouncing {
    /// Computes the bounces of a sphere from a position [m] and a velocity [m/s] for the duration of the run. The list
    /// of flights ends before a flight shorter than 1e-5 of the run. It also ends before a flight shorter than the
    /// contact time of the TC model, in which the next bounce is elastic. `None` without gravity, with drag, heating,
    /// inlets, outlets, several species or sizes, or if a wall is not a smooth plane at rest and perpendicular to
    /// gravity.
    pub fn of(experiment: &Experiment, [position, velocity]: [Vector3<f64>; 2]) -> Option<Self> {
        /// [-] duration of the shortest flight that is computed, over the duration of the run. Shorter flights could
        /// not be distinguished in a picture.
        const SHORTEST: f64 = 1e-5;
        let (scene, duration) = (&experiment.scene, experiment.run.duration);
        let elastic = contact_time(experiment).unwrap_or(0.0);
        let other = scene.has_sizes() || !is_undriven(scene);
        let ([species], false) = (scene.species.as_slice(), other) else { return None };
        let (up, gravity, radius) = (-scene.gravity.try_normalize(0.0)?, scene.gravity.norm(), 0.5 * species.diameter);
        let smooth = Surface::new(1.0, 0.0);
        let (mut floor, mut ceiling) = ((f64::NEG_INFINITY, smooth), (f64::INFINITY, smooth));
        if scene.walls.iter().any(|wall| wall.surface_moves() || wall.roughness.is_some()) {
            return None;
        }
        for wall in &scene.walls {
            let plane = wall.geometry.plane()?;
            let (along, surface) = (plane.normal.dot(&up), wall.surface);
            let touch = plane.point.dot(&up) + along * radius;
            match along {
                along if along > 1.0 - 1e-9 && touch > floor.0 => floor = (touch, surface),
                along if along < 1e-9 - 1.0 && touch < ceiling.0 => ceiling = (touch, surface),
                along if along.abs() > 1.0 - 1e-9 => {}
                _ => return None,
            }
        }
        let mut now = BounceFlight { begin: 0.0, height: position.dot(&up), velocity: velocity.dot(&up) };
        let mut flights = vec![now];
        while now.begin < duration {
            let BounceFlight { height, velocity, .. } = now;
            let reaches = velocity * velocity - 2.0 * gravity * (ceiling.0 - height);
            let (time, (place, surface)) = if velocity > 0.0 && reaches >= 0.0 {
                ((velocity - reaches.sqrt()) / gravity, ceiling)
            } else {
                (
                    (velocity + (velocity * velocity + 2.0 * gravity * (height - floor.0)).max(0.0).sqrt()) / gravity,
                    floor,
                )
            };
            let after_bounce = flights.len() > 1;
            if !(time > SHORTEST * duration && time.is_finite()) || (after_bounce && time < elastic) {
                break;
            }
            let impact = velocity - gravity * time;
            let velocity = -surface.restitution_at(impact.abs()) * impact;
            now = BounceFlight { begin: now.begin + time, height: place, velocity };
            flights.push(now);
        }
        Some(Self { gravity, up, flights })
    }

    /// [s] times of the bounces from the floor and the ceiling, in the order in which they occur.
    pub fn bounces(&self) -> impl Iterator<Item = f64> {
        self.flights.iter().skip(1).map(|flight| flight.begin)
    }

    /// Position [m] and velocity [m/s] of the sphere at `time` [s], as vectors parallel to gravity. `None` after the
    /// last bounce that was computed.
    pub fn at(&self, time: f64) -> Option<[Vector3<f64>; 2]> {
        let next = self.flights.partition_point(|flight| flight.begin <= time);
        let flight = self.flights[..next].last()?;
        let t = time - flight.begin;
        if next == self.flights.len() && next > 1 {
            return None;
        }
        let height = flight.height + flight.velocity * t - 0.5 * self.gravity * t * t;
        Some([self.up * height, self.up * (flight.velocity - self.gravity * t)])
    }
}

/// Equal elastic spheres in a row that collide head on. In a collision two spheres exchange their velocities. Each
/// straight flight therefore continues through the row, from sphere to sphere (Jepsen 1965, J. Math. Phys. 6, 405).
/// Touching spheres transmit an impulse in an instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// [-] unit vector along the row of spheres.
    along: Vector3<f64>,
    /// [m] diameter of the equal spheres.
    diameter: f64,
    /// Place of each sphere in the order along the row, by the index of the sphere; 0 for the first in the row.
    rank: Vec<usize>,
    /// Straight flights along the row, in the order along the row: coordinate [m] at the start and velocity [m/s] of
    /// each flight. From the coordinate, one diameter is subtracted for each sphere that comes before, as if spheres
    /// were points.
    free: Vec<[f64; 2]>,
}

impl Chain {
    /// Makes a row of spheres from their positions [m] and velocities [m/s]. `None` unless the spheres are equal and
    /// elastic, lie in a straight row, move along it, and no other force acts on them.
    pub fn of(scene: &Scene, start: &[[Vector3<f64>; 2]]) -> Option<Self> {
        let ([species], [_, _, ..]) = (scene.species.as_slice(), start) else { return None };
        let alone = is_undriven(scene) && scene.walls.is_empty() && scene.gravity.norm() == 0.0;
        let smooth = scene.rotation.is_none() || scene.surface(0, Kind::Species(0)).friction == 0.0;
        if !(alone && smooth && scene.restitution_of_pairs() == Some(1.0)) {
            return None;
        }
        let along = (start[1][0] - start[0][0]).try_normalize(0.0)?;
        // 1e-9 allows for the rounding of positions that were typed in other units than m
        let off = |vector: &Vector3<f64>, size: f64| (vector - along * vector.dot(&along)).norm() > 1e-9 * size;
        let straight = start.iter().all(|[x, v]| !off(&(x - start[0][0]), species.diameter) && !off(v, v.norm()));
        if !straight || (0..3).any(|axis| scene.domain.periodic[axis] && along[axis] != 0.0) {
            return None;
        }
        let mut order: Vec<usize> = (0..start.len()).collect();
        order.sort_by(|a, b| start[*a][0].dot(&along).total_cmp(&start[*b][0].dot(&along)));
        let diameter = species.diameter;
        let (mut rank, mut free) = (vec![0; start.len()], Vec::new());
        for (place, sphere) in order.into_iter().enumerate() {
            rank[sphere] = place;
            let [x, v] = start[sphere];
            free.push([x.dot(&along) - place as f64 * diameter, v.dot(&along)]);
        }
        Some(Self { along, diameter, rank, free })
    }

    /// Position [m] and velocity [m/s] of the sphere with the index `sphere` at `time` [s], as vectors parallel to the
    /// row. `None` if there is no such sphere.
    pub fn at(&self, sphere: usize, time: f64) -> Option<[Vector3<f64>; 2]> {
        let rank = *self.rank.get(sphere)?;
        let mut now: Vec<[f64; 2]> = self.free.iter().map(|[x, v]| [x + v * time, *v]).collect();
        now.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let [x, v] = now[rank];
        Some([self.along * (x + rank as f64 * self.diameter), self.along * v])
    }
}
