//! The event loop: collisions in the order of their exact instants.

use super::calendar::Calendar;
use super::impulse::{Collision, Other};
use crate::engine::{Failure, Partner, Window};
use crate::neighbours::NeighbourList;
use crate::particles::{CHUNK, Particles};
use crate::record::Log;
use crate::scene::Scene;
use crate::walls::Flight;
use crate::engine::motion::first_touch;
use nalgebra::Vector3;
use rayon::prelude::*;

/// Impacts of one particle in a row that the clock cannot tell apart before this is called a collapse. A chain of n
/// touching spheres passes a blow on in fewer than n²/2 collisions, so scenes that are not collapsing stay below.
const COLLAPSE_STREAK: u32 = 200;

/// Impacts of one particle within one window before this is called a collapse, however far apart in time.
const COLLAPSE_IMPACTS: u32 = 1_000_000;

/// How fast particles may become before the candidates at hand are no longer all there are [m/s], relative to a frame.
pub trait Limit {
    /// Whether the particle at `place` may go on with that velocity [m/s] from `now` [s] on.
    fn allows(&self, place: usize, velocity: &Vector3<f64>, now: f64) -> bool;
}

/// Events among the candidates of a neighbour list, over any store.
///
/// Positions are kept as the origin each straight flight would have had at the start of the window, so x(t) = origin +
/// v t for every particle, whatever it has met: no particle needs a clock, and the rest of the store is not touched.
#[derive(Clone, Default)]
pub struct EventLoop {
    /// The candidates. After changing them, call [`adopt`](Self::adopt).
    pub list: NeighbourList,
    /// Impulses applied so far.
    pub events: u64,
    /// Touch times computed so far.
    pub pair_checks: u64,
    calendar: Calendar,
    /// Slots of each particle: `adjacent[first[i] .. first[i + 1]]`.
    first: Vec<u32>,
    adjacent: Vec<u32>,
    met: Vec<Met>,
    /// Particles whose `met` is not zero.
    met_any: Vec<u32>,
}

/// Impacts of one particle in this window: how many, how many of the last came at once, and when the last was.
#[derive(Clone, Copy, Debug, Default)]
struct Met {
    impacts: u32,
    streak: u32,
    last: f64,
}

impl EventLoop {
    /// Takes note of new candidates among `particles` particles.
    pub fn adopt(&mut self, particles: usize) {
        self.first.clear();
        self.first.resize(particles + 1, 0);
        let pairs = self.list.pairs.iter().flat_map(|pair| [pair.i, pair.j]);
        for particle in pairs.chain(self.list.walls.iter().map(|near| near.particle)) {
            self.first[particle as usize + 1] += 1;
        }
        for i in 0..particles {
            self.first[i + 1] += self.first[i];
        }
        self.adjacent.clear();
        self.adjacent.resize(self.first[particles] as usize, 0);
        let mut next = self.first.clone();
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
        self.met.clear();
        self.met.resize(particles, Met::default());
        self.met_any.clear();
    }

    /// Runs all events in [0, end) [s], or until one made a particle faster than `limit` allows. Returns the time reached,
    /// and the place of the particle that stopped it. `window` is for messages.
    pub fn run(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        window: Window,
        end: f64,
        limit: &impl Limit,
        log: &mut Log,
    ) -> Result<(f64, Option<usize>), Failure> {
        for i in self.met_any.drain(..) {
            self.met[i as usize] = Met::default();
        }
        self.predict_all(particles, scene, end);
        while let Some((slot, now)) = self.calendar.pop() {
            let collision = self.collision(slot as usize, particles, scene, now);
            let (change_i, change_j) = collision.resolve(particles, scene, end - now, log);
            self.events += 1;
            // the new flight through the present place starts from another origin
            particles.position[collision.i] -= change_i * now;
            self.repredict(collision.i, particles, scene, now, end);
            if let Other::Particle(j) = collision.other {
                particles.position[j] -= change_j * now;
                self.repredict(j, particles, scene, now, end);
            }
            self.watch(&collision, particles, scene, window, now)?;
            let j = if let Other::Particle(j) = collision.other { Some(j) } else { None };
            for place in [Some(collision.i), j].into_iter().flatten() {
                if !limit.allows(place, &particles.velocity[place], now) {
                    return Ok((now, Some(place)));
                }
            }
        }
        Ok((end, None))
    }

    /// [s since the start of the window] when a slot touches, at `now` or later and before `end`.
    fn touch_time(&self, slot: usize, particles: &Particles, scene: &Scene, now: f64, end: f64) -> Option<f64> {
        if let Some(pair) = self.list.pairs.get(slot) {
            pair_touch_time(particles, scene, pair.i as usize, pair.j as usize, pair.reach, now, end)
        } else {
            let near = self.list.walls[slot - self.list.pairs.len()];
            let i = near.particle as usize;
            let flight = flight(particles, scene, i, now);
            let wall = scene.walls[near.wall as usize].geometry.law();
            wall.touch_time(&flight, particles.radius[i], end - now).map(|t| now + t)
        }
    }

    /// Fills the calendar for the window [0, end).
    fn predict_all(&mut self, particles: &Particles, scene: &Scene, end: f64) {
        self.calendar.clear();
        let slots = self.list.slots();
        self.pair_checks += slots as u64;
        if slots <= 2 * CHUNK {
            for slot in 0..slots {
                let time = self.touch_time(slot, particles, scene, 0.0, end);
                if time.is_some() {
                    self.calendar.set(slot as u32, time);
                }
            }
            return;
        }
        let this = &*self;
        let scan = |chunk: usize| {
            (chunk * CHUNK..((chunk + 1) * CHUNK).min(slots))
                .filter_map(|slot| this.touch_time(slot, particles, scene, 0.0, end).map(|t| (slot as u32, t)))
                .collect::<Vec<_>>()
        };
        let parts: Vec<Vec<(u32, f64)>> = (0..slots.div_ceil(CHUNK)).into_par_iter().map(scan).collect();
        for (slot, time) in parts.into_iter().flatten() {
            self.calendar.set(slot, Some(time));
        }
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
            self.pair_checks += 1;
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
        // times closer than this are one to a clock that counts from the start of the window
        let resolution = 64.0 * f64::EPSILON * window.duration;
        let (i, id) = (collision.i, |place: usize| particles.id[place]);
        let partners = match collision.other {
            Other::Particle(j) => [(i, Some(Partner::Particle(id(j)))), (j, Some(Partner::Particle(id(i))))],
            Other::Wall(wall) => [(i, Some(Partner::Wall(wall as u32))), (i, None)],
        };
        for (i, partner) in partners {
            let Some(partner) = partner else { continue };
            let met = &mut self.met[i];
            if met.impacts == 0 {
                self.met_any.push(i as u32);
            }
            let interval = now - met.last;
            met.impacts += 1;
            met.streak = if met.impacts > 1 && interval <= resolution { met.streak + 1 } else { 0 };
            met.last = now;
            if met.streak >= COLLAPSE_STREAK || met.impacts >= COLLAPSE_IMPACTS {
                let place = scene.domain.wrap(&flight(particles, scene, i, now).position);
                return Err(Failure::InelasticCollapse {
                    time: window.start + now,
                    particle: id(i),
                    partner,
                    impacts: u64::from(met.impacts),
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
    let apart = scene.domain.separation(&(a + particles.velocity[i] * now), &(b + particles.velocity[j] * now));
    (apart, velocity)
}

/// When two particles touch, at `now` or later and before `end`.
fn pair_touch_time(
    particles: &Particles,
    scene: &Scene,
    i: usize,
    j: usize,
    reach: f64,
    now: f64,
    end: f64,
) -> Option<f64> {
    let (apart, velocity) = relative(particles, scene, i, j, now);
    let rounding = particles.velocity[i].norm() + particles.velocity[j].norm();
    let t = now + first_touch(&apart, &velocity, reach, rounding)?;
    (t < end).then_some(t)
}
