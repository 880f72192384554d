//! Event loop of an island (a group of particles that may meet): collisions in the order of their exact times. An
//! island is moved through a *part*, a piece of the time between two exchanges with the gas; times are counted from the
//! start of the part. A *slot* is the number of a candidate (pair, or particle and wall) in the neighbour list.

use super::calendar::Calendar;
use super::collapse_detector::{Collapsed, LastCollision, Recent, recent, rests, sliding};
use super::impulse::{Collision, CollisionMasses, ParticleAccess};
use crate::encounter::{Couple, FrameTime, Partner};
use crate::engine::islands::Bounds;
use crate::engine::{Failure, Window};
use crate::neighbours::NeighbourList;
use crate::particles::Particles;
use crate::record::Log;
use crate::scene::Scene;
use crate::walls::Touch;
use nalgebra::Vector3;

/// The straight flight of a particle after a collision. Positions and velocities are those in the frame that falls with
/// gravity from the start of the part (piece of the time between two exchanges with the gas).
#[derive(Clone, Copy, Debug)]
pub struct DeflectedFlight {
    /// Local index of the particle in its island.
    pub index: u32,
    /// [s] time of the collision with which the flight begins, since the start of the part (interval of time).
    pub time: f64,
    /// [m] position that the particle would have had at the start of the part (interval of time) if it had always moved
    /// on the line of this flight.
    pub origin: Vector3<f64>,
    /// [m/s] velocity of the particle after the collision.
    pub velocity: Vector3<f64>,
}

/// Interval of time, called part, through which an island is moved. A window is the time between two exchanges with the
/// gas, and a part is a piece of it.
#[derive(Clone, Copy)]
pub struct WindowPart {
    /// Rest of the window, from the start of this part on. The event loop counts times from this start.
    pub window: Window,
    /// [s] length of the part (interval of time).
    pub end: f64,
}

/// Event loop that moves the particles of an island from collision to collision. The events are the touches of the
/// candidates in the neighbour list: pairs, and particles with walls.
///
/// A stored position is not that of the present: it is the point where the particle would have been at the start of the
/// part (interval of time) on its present straight line. So `x(t) = origin + v t` for every particle, also after
/// collisions. No particle requires a separate time, and a collision changes only the data of its two partners.
#[derive(Clone, Default)]
pub struct EventLoop {
    /// Neighbour list with the candidates for collisions: pairs, and particles with walls. After a change of this list,
    /// [`adopt`](Self::adopt) must be called.
    pub list: NeighbourList,
    /// Number of collisions so far, in all islands that this event loop has moved.
    pub events: u64,
    /// Number of touch times computed so far, in all islands that this event loop has moved.
    pub pair_checks: u64,
    /// Queue of the coming touches, filled again for every island.
    calendar: Calendar,
    /// Start of the entries of each particle in `adjacent`: the slots (numbers in the neighbour list) of particle `i`
    /// are `adjacent[first[i] .. first[i + 1]]`.
    first: Vec<u32>,
    adjacent: Vec<u32>,
    /// Scratch memory while `adjacent` is filled: for each particle, the index of its next free entry.
    next: Vec<u32>,
    /// For each candidate of a particle and a wall, the number of the surface feature (such as a triangle of a mesh)
    /// that the particle will touch next.
    features: Vec<u32>,
    /// Flights that began with a collision in the island that was moved most recently, in the order of time.
    pub turned: Vec<DeflectedFlight>,
    /// Collision history of each particle of the island, by which inelastic collapse is detected.
    met: Vec<LastCollision>,
    /// Contact time t_c [s] of the TC model, in which a collision is elastic if either particle collided less than t_c
    /// before; `None` without this model.
    pub contact_time: Option<f64>,
}

impl EventLoop {
    /// Prepares the event loop for a new island of `particles` particles, whose neighbour list is already in `list`.
    /// `recently` contains the last collisions of some particles; the others have no collision history.
    pub fn adopt(&mut self, particles: usize, recently: &[Recent]) {
        self.met.clear();
        self.met.resize(particles, LastCollision::default());
        for recent in recently {
            self.met[recent.index as usize] = LastCollision::at(recent.time);
        }
        self.connect(particles);
    }

    /// Last collisions of those of the first `particles` particles that collided less than the contact time of the TC
    /// model before simulated time `now` [s]. Empty without this model, in which a collision is elastic soon after
    /// another one.
    pub fn recent(&self, particles: usize, now: f64) -> impl Iterator<Item = Recent> {
        recent(self.met.iter().take(particles), self.contact_time, now)
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
        self.next.clone_from(&self.first);
        let mut put = |particle: u32, slot: usize| {
            let next = &mut self.next[particle as usize];
            self.adjacent[*next as usize] = slot as u32;
            *next += 1;
        };
        for (slot, pair) in self.list.pairs.iter().enumerate() {
            put(pair.i, slot);
            put(pair.j, slot);
        }
        for (k, near) in self.list.walls.iter().enumerate() {
            put(near.particle, self.list.pairs.len() + k);
        }
    }

    /// Moves the particles from collision to collision through a part of a window. The loop stops early if a particle
    /// becomes faster than its speed limit in `bounds`, or if an inelastic collapse is detected. Returns the time
    /// reached [s since the start of the part, an interval of time], and the index of the particle that became too
    /// fast, or `None`. The error is an inelastic collapse.
    pub fn run(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        WindowPart { window, end }: WindowPart,
        bounds: &Bounds,
        log: &mut Log,
    ) -> (f64, Result<Option<usize>, Failure>) {
        self.turned.clear();
        self.predict_all(particles, scene, end);
        while let Some((slot, now)) = self.calendar.pop() {
            let couple = self.list.couple(slot as usize);
            let moment = FrameTime::ahead(now);
            let met = couple.strike(particles, scene, moment, self.feature(slot as usize));
            let wall = couple.wall_motion(&met, (particles, scene), moment);
            let elastic = self.in_contact(&couple, window.start + now);
            let image = couple.image_velocity(particles, scene, &met.velocity);
            let collision = Collision { couple, met, elastic, kinds: couple.kinds(particles), wall, image };
            let left = window.duration - now;
            let masses = CollisionMasses::of(&couple, particles);
            let (change_i, change_j) = match rests(&collision, scene, self.contact_time) {
                Some(speed) => (collision.hold_at_rest(speed, masses.mass, scene, left, log), Vector3::zeros()),
                None => collision.apply_impulse(&masses, &mut ParticleAccess::Exclusive(particles), scene, left, log),
            };
            self.events += 1;
            self.list.clock.tell(window.start + now);
            for (index, change) in couple.indices().into_iter().flatten().zip([change_i, change_j]) {
                particles.velocity[index as usize] += change;
                // the new flight passes through the present position, so its point at the start of the part changes
                particles.position[index as usize] -= change * now;
            }
            if let Err(failure) = self.watch(&collision, particles, scene, window, now) {
                return (now, Err(failure));
            }
            for index in couple.indices().into_iter().flatten() {
                let (origin, velocity) = (particles.position[index as usize], particles.velocity[index as usize]);
                self.turned.push(DeflectedFlight { index, time: now, origin, velocity });
                self.repredict(index as usize, particles, scene, now, end);
            }
            for index in couple.indices().into_iter().flatten().map(|index| index as usize) {
                if !bounds.allows(index, &particles.velocity[index]) {
                    return (now, Ok(Some(index)));
                }
            }
        }
        (end, Ok(None))
    }

    /// Number of the surface feature (such as a triangle of a mesh) that the particle at the slot `slot` will touch
    /// next. A slot is the number of a candidate in the neighbour list. 0 for a pair of particles.
    fn feature(&self, slot: usize) -> u32 {
        let near = slot.checked_sub(self.list.pairs.len());
        near.and_then(|near| self.features.get(near)).copied().unwrap_or_default()
    }

    /// Puts the next touch of the two bodies at `slot` (their number in the neighbour list) into the event queue. With
    /// `None` for `touch`, no touch is coming. The time of the touch is in s since the start of the part (interval of
    /// time).
    fn predict_events(&mut self, slot: usize, touch: Option<Touch>) {
        if let (Some(near), Some(touch)) = (slot.checked_sub(self.list.pairs.len()), touch) {
            self.features[near] = touch.feature;
        }
        self.calendar.set(slot as u32, touch.map(|touch| touch.time));
    }

    /// Next touch of the two bodies at a slot (number in the neighbour list) between the times `now` and `end`; `None`
    /// without a touch. All times are in s since the start of the part (interval of time).
    fn touch(&self, slot: usize, particles: &Particles, scene: &Scene, now: f64, end: f64) -> Option<Touch> {
        let couple = self.list.couple(slot);
        let touch = couple.touch(particles, scene, FrameTime::ahead(now), end - now);
        let touch = touch.map(|touch| Touch { time: now + touch.time, ..touch });
        touch.filter(|touch| couple.is_wall() || touch.time < end)
    }

    /// Fills the event queue with the first touch of every candidate in the neighbour list, up to the time `end` [s]
    /// since the start of the part (interval of time).
    fn predict_all(&mut self, particles: &Particles, scene: &Scene, end: f64) {
        self.calendar.clear();
        self.features.clear();
        self.features.resize(self.list.walls.len(), 0);
        let slots = self.list.slots();
        self.pair_checks += slots as u64;
        for slot in 0..slots {
            let touch = self.touch(slot, particles, scene, 0.0, end);
            if touch.is_some() {
                self.predict_events(slot, touch);
            }
        }
    }

    fn repredict(&mut self, i: usize, particles: &Particles, scene: &Scene, now: f64, end: f64) {
        for k in self.first[i]..self.first[i + 1] {
            let slot = self.adjacent[k as usize] as usize;
            let touch = self.touch(slot, particles, scene, now, end);
            self.pair_checks += 1;
            self.predict_events(slot, touch);
        }
    }

    /// True if the TC model makes a collision of these bodies at simulated time `time` [s] elastic: one of them
    /// collided less than the contact time before.
    fn in_contact(&self, couple: &Couple, time: f64) -> bool {
        let Some(contact_time) = self.contact_time else { return false };
        let last = |index: u32| self.met[index as usize].last;
        couple.indices().into_iter().flatten().any(|index| time - last(index) < contact_time)
    }

    /// Adds a collision at the time `now` [s since the start of the part, an interval of time] to the histories of both
    /// partners. Returns an error if the histories show an inelastic collapse.
    fn watch(
        &mut self,
        collision: &Collision,
        particles: &Particles,
        scene: &Scene,
        window: Window,
        now: f64,
    ) -> Result<(), Failure> {
        let time = window.start + now;
        let couple = collision.couple;
        for i in couple.indices().into_iter().flatten() {
            let partner = if i == couple.i {
                couple.partner(particles)
            } else {
                Partner::Particle(particles.id[couple.i as usize])
            };
            let i = i as usize;
            let met = &mut self.met[i];
            if let Some(interval) = met.note(collision, scene, time, self.contact_time) {
                let position = scene.domain.wrap(&FrameTime::ahead(now).flight(particles, scene, i).position);
                let (impacts, sliding) = (met.impacts, sliding(collision, scene));
                let collapsed = Collapsed { impacts, interval, contact_time: self.contact_time, sliding };
                return Err(collapsed.failure(time, (particles.id[i], partner), position));
            }
        }
        Ok(())
    }
}
