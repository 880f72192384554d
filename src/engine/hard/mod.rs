//! Hard spheres: collisions are instants.

mod calendar;
mod impulse;
mod steps;

pub use impulse::{Collision, Other, impulse};
pub use steps::SteppedHard;

use super::motion::{accelerate, drift};
use super::{Counters, Engine, Failure, Partner, Window};
use crate::neighbours::{NeighbourList, along_walls};
use crate::particles::{CHUNK, Particles};
use crate::record::Record;
use crate::scene::Scene;
use crate::walls::Flight;
use calendar::Calendar;
use nalgebra::Vector3;
use rayon::prelude::*;

/// Impacts of one particle in a row, each after a flight too short to be told from none, before this is called a
/// collapse. A chain of n touching spheres passes a blow on in fewer than n²/2 collisions, so scenes that are not
/// collapsing stay below.
const COLLAPSE_STREAK: u32 = 200;

/// A flight is too short to be told from none if it is below this fraction of the box: coordinates are rounded to
/// 2e-16 of it at every collision, so what a sphere meets next after less is decided by rounding.
const COLLAPSE_FLIGHT: f64 = 64.0 * f64::EPSILON;

/// Impacts of one particle within one window before this is called a collapse, however far apart in time.
const COLLAPSE_IMPACTS: u32 = 1_000_000;

/// Event-driven hard spheres: within a window, collisions in the order of their exact instants.
///
/// Positions are kept as the origin each straight flight would have had at the start of the window, so x(t) = origin +
/// v t for every particle, whatever it has met: no particle needs a clock, and the rest of the store is not touched.
#[derive(Default)]
pub struct Hard {
    list: NeighbourList,
    calendar: Calendar,
    /// Slots of each particle: `adjacent[first[i] .. first[i + 1]]`.
    first: Vec<u32>,
    adjacent: Vec<u32>,
    /// What has come to each particle.
    met: Vec<Met>,
    /// Particles that have met something in this window.
    met_any: Vec<u32>,
    /// Axes along which the box is so short that a pair may touch through another than the nearest image.
    has_far_images: [bool; 3],
    counters: Counters,
}

#[derive(Clone, Copy, Debug)]
struct Met {
    /// Impacts in this window.
    impacts: u32,
    /// Impacts in a row after flights too short to be told from none, across windows.
    streak: u32,
    /// [s] simulated time of the last.
    last: f64,
}

impl Default for Met {
    fn default() -> Self {
        Self { impacts: 0, streak: 0, last: f64::NEG_INFINITY }
    }
}

impl Hard {
    /// An engine without settings: restitution and friction are the scene's.
    pub fn new() -> Self {
        Self::default()
    }

    fn rebuild(&mut self, particles: &mut Particles, scene: &Scene, between_uses: f64) {
        let order = self.list.build(particles, scene, between_uses);
        let n = particles.len();
        self.first = vec![0; n + 1];
        let pairs = self.list.pairs.iter().flat_map(|pair| [pair.i, pair.j]);
        for particle in pairs.chain(self.list.walls.iter().map(|near| near.particle)) {
            self.first[particle as usize + 1] += 1;
        }
        for i in 0..n {
            self.first[i + 1] += self.first[i];
        }
        let mut next = self.first.clone();
        self.adjacent = vec![0; self.first[n] as usize];
        let mut put = |particle: u32, slot: usize| {
            self.adjacent[next[particle as usize] as usize] = slot as u32;
            next[particle as usize] += 1;
        };
        for (slot, pair) in self.list.pairs.iter().enumerate() {
            put(pair.i, slot);
            put(pair.j, slot);
        }
        for (k, near) in self.list.walls.iter().enumerate() {
            put(near.particle, self.list.pairs.len() + k);
        }
        self.met.resize(n, Met::default());
        self.met = order.iter().map(|&from| self.met[from as usize]).collect();
        self.met_any = (0..n as u32).filter(|&place| self.met[place as usize].impacts > 0).collect();
        let reach = 2.0 * particles.radius.iter().fold(0.0, |a: f64, &r| a.max(r));
        self.has_far_images = std::array::from_fn(|axis| {
            scene.domain.periodic[axis] && 0.5 * scene.domain.size[axis] - reach < self.list.skin()
        });
        self.counters.neighbour_builds = self.list.builds();
    }

    /// [s since the start of the window] when a slot touches, at `now` or later and before `end`.
    fn touch_time(&self, slot: usize, particles: &Particles, scene: &Scene, now: f64, end: f64) -> Option<f64> {
        if let Some(pair) = self.list.pairs.get(slot) {
            let (apart, velocity) = relative(particles, scene, pair.i as usize, pair.j as usize, now);
            // an approach slower than rounding of the velocities is none
            let speeds = particles.velocity[pair.i as usize].norm() + particles.velocity[pair.j as usize].norm();
            let resolution = 4.0 * f64::EPSILON * speeds;
            let touch = |apart: &Vector3<f64>| touch_time(apart, &velocity, pair.reach, resolution);
            let mut time = touch(&apart);
            if self.has_far_images != [false; 3] {
                let images = far_images(&apart, &scene.domain.size, self.has_far_images);
                time = images.filter_map(|image| touch(&image)).chain(time).reduce(f64::min);
            }
            time.map(|t| now + t).filter(|t| *t < end)
        } else {
            let near = self.list.walls[slot - self.list.pairs.len()];
            let i = near.particle as usize;
            let flight = flight(particles, scene, i, now);
            let radius = particles.radius[i];
            let wall = scene.walls[near.wall as usize].geometry.law();
            wall.touch_time(&flight, radius, end - now).map(|t| now + t)
        }
    }

    /// Fills the calendar for the window [0, end).
    fn predict_all(&mut self, particles: &Particles, scene: &Scene, end: f64) {
        self.calendar.clear();
        self.counters.pair_checks += self.list.slots() as u64;
        let this = &*self;
        let scan = |range: std::ops::Range<usize>| {
            range
                .filter_map(|slot| this.touch_time(slot, particles, scene, 0.0, end).map(|t| (slot as u32, t)))
                .collect::<Vec<_>>()
        };
        let slots = self.list.slots();
        let parts: Vec<Vec<(u32, f64)>> = if slots <= 2 * CHUNK {
            vec![scan(0..slots)]
        } else {
            let chunks = slots.div_ceil(CHUNK);
            (0..chunks).into_par_iter().map(|c| scan(c * CHUNK..((c + 1) * CHUNK).min(slots))).collect()
        };
        for (slot, time) in parts.into_iter().flatten() {
            self.calendar.set(slot, Some(time));
        }
    }

    /// Runs events until `end` [s], until a collision made a particle faster than the list allows for, or until one
    /// shows a collapse. Returns the time reached.
    fn run_events(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        window: Window,
        end: f64,
        record: &mut Record,
    ) -> (f64, Result<(), Failure>) {
        let frame = self.list.frame();
        let fall = (scene.gravity - along_walls(scene, scene.gravity)).norm() * end;
        while let Some((slot, now)) = self.calendar.pop() {
            let collision = self.collision(slot as usize, particles, scene, now);
            let (change_i, change_j) = collision.resolve(particles, scene, window.duration - now, record);
            self.counters.events += 1;
            // the new flight through the present place starts from another origin
            particles.position[collision.i] -= change_i * now;
            if let Other::Particle(j) = collision.other {
                particles.position[j] -= change_j * now;
            }
            if let Err(failure) = self.watch(&collision, particles, scene, window, now) {
                return (now, Err(failure));
            }
            self.repredict(collision.i, particles, scene, now, end);
            let mut speed = (particles.velocity[collision.i] - frame).norm();
            if let Other::Particle(j) = collision.other {
                self.repredict(j, particles, scene, now, end);
                speed = speed.max((particles.velocity[j] - frame).norm());
            }
            // all that has moved so far has moved within the bound; from here on this particle may not
            if !self.list.allows((speed + fall) * end) {
                return (now, Ok(()));
            }
        }
        (end, Ok(()))
    }

    fn collision(&self, slot: usize, particles: &Particles, scene: &Scene, now: f64) -> Collision {
        if let Some(pair) = self.list.pairs.get(slot) {
            let (i, j) = (pair.i as usize, pair.j as usize);
            let (apart, velocity) = relative(particles, scene, i, j, now);
            let distance = apart.norm();
            let normal = if distance > 0.0 { apart / distance } else { Vector3::y() };
            Collision { i, other: Other::Particle(j), normal, velocity, overlap: pair.reach - distance }
        } else {
            let near = self.list.walls[slot - self.list.pairs.len()];
            let i = near.particle as usize;
            let flight = flight(particles, scene, i, now);
            let nearest = scene.walls[near.wall as usize].geometry.law().nearest(&flight.position);
            Collision {
                i,
                other: Other::Wall(near.wall as usize),
                normal: nearest.normal,
                velocity: flight.velocity,
                overlap: particles.radius[i] - nearest.distance,
            }
        }
    }

    fn repredict(&mut self, i: usize, particles: &Particles, scene: &Scene, now: f64, end: f64) {
        for k in self.first[i]..self.first[i + 1] {
            let slot = self.adjacent[k as usize];
            let time = self.touch_time(slot as usize, particles, scene, now, end);
            self.counters.pair_checks += 1;
            self.calendar.set(slot, time);
        }
    }

    /// Counts the impacts of both partners and recognises inelastic collapse.
    fn watch(
        &mut self,
        collision: &Collision,
        particles: &Particles,
        scene: &Scene,
        window: Window,
        now: f64,
    ) -> Result<(), Failure> {
        let speed = collision.velocity.dot(&collision.normal).abs();
        let resolution = COLLAPSE_FLIGHT * scene.domain.size.max();
        let others = match collision.other {
            Other::Particle(j) => [Some(collision.i), Some(j)],
            Other::Wall(_) => [Some(collision.i), None],
        };
        for i in others.into_iter().flatten() {
            let met = &mut self.met[i];
            if met.impacts == 0 {
                self.met_any.push(i as u32);
            }
            let interval = window.start + now - met.last;
            met.impacts += 1;
            met.streak = if speed * interval <= resolution { met.streak + 1 } else { 0 };
            met.last = window.start + now;
            if met.streak >= COLLAPSE_STREAK || met.impacts >= COLLAPSE_IMPACTS {
                let place = scene.domain.wrap(&flight(particles, scene, i, now).position);
                let partner = match collision.other {
                    Other::Particle(j) if i == j => Partner::Particle(particles.id[collision.i]),
                    Other::Particle(j) => Partner::Particle(particles.id[j]),
                    Other::Wall(wall) => Partner::Wall(wall as u32),
                };
                return Err(Failure::InelasticCollapse {
                    time: window.start + now,
                    particle: particles.id[i],
                    partner,
                    impacts: met.impacts as u64,
                    interval,
                    x: place.x,
                    y: place.y,
                    z: place.z,
                });
            }
        }
        Ok(())
    }
}

/// Motion of particle `i` from `now` on, in the frame at rest.
fn flight(particles: &Particles, scene: &Scene, i: usize, now: f64) -> Flight {
    Flight {
        position: particles.position[i] + particles.velocity[i] * now + scene.gravity * (0.5 * now * now),
        velocity: particles.velocity[i] + scene.gravity * now,
        gravity: scene.gravity,
    }
}

/// Separation (from j to i) and relative velocity of two particles at `now`.
fn relative(particles: &Particles, scene: &Scene, i: usize, j: usize, now: f64) -> (Vector3<f64>, Vector3<f64>) {
    let velocity = particles.velocity[i] - particles.velocity[j];
    let (a, b) = (&particles.position[i], &particles.position[j]);
    let apart = if now == 0.0 {
        scene.domain.separation(a, b)
    } else {
        scene.domain.separation(&(a + particles.velocity[i] * now), &(b + particles.velocity[j] * now))
    };
    (apart, velocity)
}

/// [s] until spheres at separation r and relative velocity u touch: the smaller root of |r + u t| = reach. Those that
/// overlap (by rounding) and approach faster than `resolution` [m/s] touch now; those that separate do not touch again
/// before something turns them.
fn touch_time(apart: &Vector3<f64>, velocity: &Vector3<f64>, reach: f64, resolution: f64) -> Option<f64> {
    let closing = -apart.dot(velocity);
    if closing <= resolution * apart.norm() {
        return None;
    }
    let gap_square = apart.norm_squared() - reach * reach;
    if gap_square <= 0.0 {
        return Some(0.0);
    }
    let discriminant = closing * closing - velocity.norm_squared() * gap_square;
    (discriminant >= 0.0).then(|| gap_square / (closing + discriminant.sqrt()))
}

/// Separations [m] by way of the other side of the box, along any of the axes marked.
fn far_images(apart: &Vector3<f64>, size: &Vector3<f64>, axes: [bool; 3]) -> impl Iterator<Item = Vector3<f64>> {
    (1..8usize).filter(move |image| (0..3).all(|axis| image >> axis & 1 == 0 || axes[axis])).map(move |image| {
        Vector3::from_fn(|axis, _| {
            apart[axis] - if image >> axis & 1 == 1 { size[axis].copysign(apart[axis]) } else { 0.0 }
        })
    })
}

impl Engine for Hard {
    fn advance(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        window: Window,
        record: &mut Record,
    ) -> Result<(), Failure> {
        let fall = scene.gravity - along_walls(scene, scene.gravity);
        let mut done = 0.0;
        let periods = (0..3).filter(|axis| scene.domain.periodic[*axis]).map(|axis| scene.domain.size[axis]);
        let period = periods.fold(f64::INFINITY, f64::min);
        for i in self.met_any.drain(..) {
            self.met[i as usize].impacts = 0;
        }
        while done < window.duration {
            let rest = window.duration - done;
            let speed = |list: &NeighbourList, p: &Particles| p.largest_speed(list.frame()) + fall.norm() * rest;
            // within a part no pair moves more than half a period: the nearest image and the next are all it can meet
            let part = |speed: f64| if speed > 0.0 { rest.min(0.25 * period / speed) } else { rest };
            let mut fastest = speed(&self.list, particles);
            if !fastest.is_finite() {
                return Err(super::not_a_number(particles, window.start + done));
            }
            if !self.list.allows(fastest * part(fastest)) {
                self.rebuild(particles, scene, part(fastest));
                fastest = speed(&self.list, particles);
            }
            let left = part(fastest);
            self.predict_all(particles, scene, left);
            let stretch = Window { start: window.start + done, duration: rest };
            let (reached, result) = self.run_events(particles, scene, stretch, left, record);
            drift(particles, reached, scene.gravity * (0.5 * reached * reached));
            accelerate(particles, scene.gravity * reached);
            self.list.travel(fastest * left);
            result?;
            done = if reached < rest { done + reached } else { window.duration };
        }
        Ok(())
    }

    fn counters(&self) -> Counters {
        self.counters
    }

    fn elastic_energy(&self) -> f64 {
        0.0
    }
}
