//! The event loop: collisions in the order of their exact instants.

use super::calendar::Calendar;
use super::impulse::Collision;
use crate::encounter::{Couple, Moment, Partner, first_touch, relative};
use crate::engine::{Failure, Window};
use crate::neighbours::NeighbourList;
use crate::particles::{CHUNK, Particles};
use crate::record::Log;
use crate::scene::Scene;
use crate::walls::Touch;
use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Impacts of one particle in a row, each after a flight too short to be told from none, before this is called a
/// collapse. A chain of n touching spheres passes a blow on in fewer than n²/2 collisions, so scenes that are not
/// collapsing stay below.
const COLLAPSE_STREAK: u32 = 200;

/// A flight is too short to be told from none if it is below this fraction of the box: coordinates are rounded to
/// 2e-16 of it at every collision, so what a sphere meets next after less is decided by rounding.
const COLLAPSE_FLIGHT: f64 = 64.0 * f64::EPSILON;

/// Flights of one particle, each shorter than the one before, after which one too short to be told from none is the end of
/// a Zeno series. The relative speeds of a group that collapses fall below rounding within some dozen impacts, and then
/// nothing meets any more: the streak above would not be reached. Three flights in a row fall by chance in one of six
/// times, and then to 10⁻¹⁴ of the box with about that probability.
const ZENO_FLIGHTS: u32 = 3;

/// Impacts of one particle within one window before this is called a collapse, however far apart in time. Not with a
/// contact time: spheres at rest then collide about once in it, for ever.
const COLLAPSE_IMPACTS: u32 = 1_000_000;

/// How fast particles may become before the candidates at hand are no longer all there are [m/s], relative to a frame.
pub trait Limit {
    /// Whether the particle at `place` may go on with that velocity [m/s].
    fn allows(&self, place: usize, velocity: &Vector3<f64>) -> bool;
}

/// The beginning of a window, up to which its events are run.
#[derive(Clone, Copy)]
pub struct Part {
    /// The whole window.
    pub window: Window,
    /// [s] length of the part.
    pub end: f64,
}

/// Events among the candidates of a neighbour list, over any store.
///
/// Positions are kept as the origin each straight flight would have had at the start of the window, so x(t) = origin +
/// v t for every particle, whatever it has met: no particle needs a clock, and the rest of the store is not touched.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct EventLoop {
    /// The candidates. After changing them, call [`adopt`](Self::adopt).
    pub list: NeighbourList,
    /// Impulses applied so far.
    pub events: u64,
    /// Touch times computed so far.
    pub pair_checks: u64,
    /// Filled anew in every window.
    #[serde(skip)]
    calendar: Calendar,
    /// Slots of each particle: `adjacent[first[i] .. first[i + 1]]`.
    #[serde(skip)]
    first: Vec<u32>,
    #[serde(skip)]
    adjacent: Vec<u32>,
    /// What of its wall each slot of a wall touches next.
    #[serde(skip)]
    places: Vec<u32>,
    /// What has come to each particle.
    met: Vec<Met>,
    /// Axes along which the box is so short that a pair may touch through another than the nearest image.
    pub far_images: [bool; 3],
    /// [s] t_c of the TC model: a collision sooner than this after another of either particle is elastic.
    #[serde(skip)]
    pub contact_time: Option<f64>,
}

/// When a particle last collided, by place: what the TC model must know from one window to the next.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Recent {
    /// Place in the store.
    pub place: u32,
    /// [s] simulated time.
    pub time: f64,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Met {
    /// Impacts since the count was last cleared.
    impacts: u32,
    /// Impacts in a row after flights too short to be told from none, across windows.
    streak: u32,
    /// Impacts in a row, each after a shorter flight than the one before, across windows.
    shrinking: u32,
    /// [m] the last flight: time since the impact before, times the speed of approach.
    flown: f64,
    /// [s] simulated time of the last.
    last: f64,
}

impl Default for Met {
    fn default() -> Self {
        Self { impacts: 0, streak: 0, shrinking: 0, flown: f64::INFINITY, last: f64::NEG_INFINITY }
    }
}

impl EventLoop {
    /// Goes on from where another with the same settings was between two windows.
    pub fn resume(&mut self, other: Self) {
        let clock = self.list.clock.clone();
        *self = Self { contact_time: self.contact_time, ..other };
        self.list.clock = clock;
        self.connect(self.met.len());
    }

    /// Takes note of new candidates among `particles` particles that have met nothing yet.
    pub fn adopt(&mut self, particles: usize) {
        self.met.clear();
        self.met.resize(particles, Met::default());
        self.connect(particles);
    }

    /// Takes note of new candidates in a store that has been put in a new order: `order[k]` is where `k` stood.
    pub fn adopt_reordered(&mut self, order: &[u32]) {
        self.met.resize(order.len(), Met::default());
        self.met = order.iter().map(|&from| self.met[from as usize]).collect();
        self.connect(order.len());
    }

    /// Somebody else has put the particles in another order: the one with id `before[k]` stood at place `k`, now `now[k]` does.
    /// Ids are 0 .. N.
    pub fn follow(&mut self, before: &[u32], now: &[u32]) {
        self.met.resize(before.len(), Met::default());
        let mut by_id = vec![Met::default(); before.len()];
        for (met, &id) in self.met.iter().zip(before) {
            by_id[id as usize] = *met;
        }
        for (met, &id) in self.met.iter_mut().zip(now) {
            *met = by_id[id as usize];
        }
    }

    /// Somebody else has moved the particles meanwhile: all that is known of `particles` of them is who collided `recently`.
    pub fn forget_but(&mut self, particles: usize, recently: &[Recent]) {
        self.met.clear();
        self.met.resize(particles, Met::default());
        for recent in recently {
            self.met[recent.place as usize].last = recent.time;
        }
    }

    /// Who of the first `particles` has collided less than the contact time before `now` [s]; nobody without one.
    pub fn recent(&self, particles: usize, now: f64) -> impl Iterator<Item = Recent> {
        let after = self.contact_time.map_or(f64::INFINITY, |time| now - time);
        let met = self.met.iter().take(particles).enumerate();
        met.filter(move |(_, met)| met.last > after).map(|(place, met)| Recent { place: place as u32, time: met.last })
    }

    /// Starts the count of impacts per window anew.
    pub fn clear_counts(&mut self) {
        for met in &mut self.met {
            met.impacts = 0;
        }
    }

    fn connect(&mut self, particles: usize) {
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
    }

    /// Runs all events of a part of a window, until one made a particle faster than `limit` allows, or until one shows a
    /// collapse. Returns the time reached, and the place of the particle that stopped it.
    pub fn run(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        Part { window, end }: Part,
        limit: &impl Limit,
        log: &mut Log,
    ) -> (f64, Result<Option<usize>, Failure>) {
        self.predict_all(particles, scene, end);
        while let Some((slot, now)) = self.calendar.pop() {
            let couple = self.list.couple(slot as usize);
            let met = couple.strike(particles, scene, Moment::ahead(now), self.place(slot as usize));
            let collision = Collision { couple, met, elastic: self.in_contact(&couple, window.start + now) };
            let (change_i, change_j) = match self.rests(&collision, scene) {
                Some(speed) => collision.lift(speed, particles, scene, window.duration - now, log),
                None => collision.resolve(particles, scene, window.duration - now, log),
            };
            self.events += 1;
            self.list.clock.tell(window.start + now);
            // the new flight through the present place starts from another origin
            particles.position[couple.i as usize] -= change_i * now;
            if let Some(j) = couple.j() {
                particles.position[j as usize] -= change_j * now;
            }
            if let Err(failure) = self.watch(&collision, particles, scene, window, now) {
                return (now, Err(failure));
            }
            for place in couple.places().into_iter().flatten() {
                self.repredict(place as usize, particles, scene, now, end);
            }
            for place in couple.places().into_iter().flatten().map(|place| place as usize) {
                if !limit.allows(place, &particles.velocity[place]) {
                    return (now, Ok(Some(place)));
                }
            }
        }
        (end, Ok(None))
    }

    /// What of a wall the next touch of a slot is with.
    fn place(&self, slot: usize) -> u32 {
        let near = slot.checked_sub(self.list.pairs.len());
        near.and_then(|near| self.places.get(near)).copied().unwrap_or_default()
    }

    /// Notes the next touch of a slot, [s since the start of the window].
    fn foresee(&mut self, slot: usize, touch: Option<Touch>) {
        if let (Some(near), Some(touch)) = (slot.checked_sub(self.list.pairs.len()), touch) {
            self.places[near] = touch.place;
        }
        self.calendar.set(slot as u32, touch.map(|touch| touch.time));
    }

    /// When a slot touches [s since the start of the window], at `now` or later and before `end`, and what.
    fn touch(&self, slot: usize, particles: &Particles, scene: &Scene, now: f64, end: f64) -> Option<Touch> {
        let (couple, moment) = (self.list.couple(slot), Moment::ahead(now));
        let touch = couple.touch(particles, scene, moment, end - now);
        let mut time = touch.map(|touch| touch.time);
        if let Some(j) = couple.j().filter(|_| self.far_images != [false; 3]) {
            let (i, j) = (couple.i as usize, j as usize);
            let (apart, velocity) = relative(particles, scene, [i, j], moment);
            let reach = particles.radius[i] + particles.radius[j];
            let speeds = particles.velocity[i].norm() + particles.velocity[j].norm();
            let images = far_images(&apart, &scene.domain.size, self.far_images);
            time =
                images.filter_map(|image| first_touch(&image, &velocity, reach, speeds)).chain(time).reduce(f64::min);
        }
        let place = touch.map_or(0, |touch| touch.place);
        time.map(|t| Touch { time: now + t, place }).filter(|touch| couple.is_wall() || touch.time < end)
    }

    /// Fills the calendar for the window [0, end).
    fn predict_all(&mut self, particles: &Particles, scene: &Scene, end: f64) {
        self.calendar.clear();
        self.places.clear();
        self.places.resize(self.list.walls.len(), 0);
        let slots = self.list.slots();
        self.pair_checks += slots as u64;
        if slots <= 2 * CHUNK {
            for slot in 0..slots {
                let touch = self.touch(slot, particles, scene, 0.0, end);
                if touch.is_some() {
                    self.foresee(slot, touch);
                }
            }
            return;
        }
        let this = &*self;
        let scan = |chunk: usize| {
            (chunk * CHUNK..((chunk + 1) * CHUNK).min(slots))
                .filter_map(|slot| this.touch(slot, particles, scene, 0.0, end).map(|touch| (slot as u32, touch)))
                .collect::<Vec<_>>()
        };
        let parts: Vec<Vec<(u32, Touch)>> = (0..slots.div_ceil(CHUNK)).into_par_iter().map(scan).collect();
        for (slot, touch) in parts.into_iter().flatten() {
            self.foresee(slot as usize, Some(touch));
        }
    }

    fn repredict(&mut self, i: usize, particles: &Particles, scene: &Scene, now: f64, end: f64) {
        for k in self.first[i]..self.first[i + 1] {
            let slot = self.adjacent[k as usize] as usize;
            let touch = self.touch(slot, particles, scene, now, end);
            self.pair_checks += 1;
            self.foresee(slot, touch);
        }
    }

    /// Whether a particle merely rests on a wall while there is a contact time t_c: gravity presses it there, and it would rise by
    /// less than what can be told from nothing. Then gives its normal speed away from the wall [m/s].
    ///
    /// Without t_c it would collide infinitely often at once. A contact that lasts carries the weight for its time; here the
    /// particle rebounds at a_n t_c/4, with a_n the acceleration into the wall, and comes back after t_c/2: sooner than t_c,
    /// hence always elastically. It rises by a_n t_c²/32, a third of what a spring with that time of contact gives way under
    /// the weight, a_n t_c²/π² (k = m π²/t_c²).
    fn rests(&self, collision: &Collision, scene: &Scene) -> Option<f64> {
        if !collision.couple.is_wall() {
            return None;
        }
        let approach = collision.approach();
        let weight = -scene.gravity.dot(&collision.met.normal);
        let speed = 0.25 * weight * self.contact_time?;
        let rise = 2.0 * weight * COLLAPSE_FLIGHT * scene.domain.size.max();
        (approach * approach <= rise && speed > approach).then_some(speed)
    }

    /// Whether one of the partners has collided less than the contact time ago, at simulated `time` [s].
    fn in_contact(&self, couple: &Couple, time: f64) -> bool {
        let Some(contact_time) = self.contact_time else { return false };
        let last = |place: u32| self.met[place as usize].last;
        couple.places().into_iter().flatten().any(|place| time - last(place) < contact_time)
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
        let speed = collision.approach().abs();
        let resolution = COLLAPSE_FLIGHT * scene.domain.size.max();
        let time = window.start + now;
        let couple = collision.couple;
        for i in couple.places().into_iter().flatten() {
            let partner = if i == couple.i {
                couple.partner(particles)
            } else {
                Partner::Particle(particles.id[couple.i as usize])
            };
            let i = i as usize;
            let met = &mut self.met[i];
            let interval = time - met.last;
            let flown = speed * interval;
            let unresolved = flown <= resolution;
            let zeno = unresolved && met.shrinking >= ZENO_FLIGHTS && collision.loses(scene);
            met.impacts += 1;
            met.streak = if unresolved { met.streak + 1 } else { 0 };
            met.shrinking = if !unresolved && flown < met.flown { met.shrinking + 1 } else { 0 };
            met.flown = flown;
            met.last = time;
            let endless = met.impacts >= COLLAPSE_IMPACTS && self.contact_time.is_none();
            if zeno || met.streak >= COLLAPSE_STREAK || endless {
                let place = scene.domain.wrap(&Moment::ahead(now).flight(particles, scene, i).position);
                return Err(Failure::InelasticCollapse {
                    time,
                    particle: particles.id[i],
                    partner,
                    impacts: u64::from(met.impacts),
                    interval,
                    contact_time: self.contact_time,
                    x: place.x,
                    y: place.y,
                    z: place.z,
                });
            }
        }
        Ok(())
    }
}

/// Separations [m] by way of the other side of the box, along any of the axes marked.
fn far_images(apart: &Vector3<f64>, size: &Vector3<f64>, axes: [bool; 3]) -> impl Iterator<Item = Vector3<f64>> {
    (1..8usize).filter(move |image| (0..3).all(|axis| image >> axis & 1 == 0 || axes[axis])).map(move |image| {
        Vector3::from_fn(|axis, _| {
            apart[axis] - if image >> axis & 1 == 1 { size[axis].copysign(apart[axis]) } else { 0.0 }
        })
    })
}
