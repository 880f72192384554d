//! The global calendar: one event queue for all particles, which lasts from one time window to the next.
//!
//! For every particle the calendar stores the earliest two events. An event is a touch, or the exit from the particle's
//! shell (a ball in which its neighbour list is valid). The events of a particle are predicted again after its
//! collision, or when the partner of its next event has collided meanwhile. A window is the time between two exchanges
//! of momentum with the gas; its end changes no event. Each flight is stored with a separate time, so a collision moves
//! only two particles and tests their neighbours. Times are counted from an instant called *epoch*.
//!
//! The calendar stores a copy of the flights, in a falling frame, and writes positions and velocities to the particle
//! store at the end of each window. If velocities in the store have changed when the next window begins, for instance
//! by drag, all events are predicted again.

mod approach;
mod bins;
mod cells;
mod curve;
mod event_queue;
mod frame;
mod list_pool;
mod load;
mod next_events;
mod prediction;
mod shells;
mod sliding;
mod walls;

use super::collapse_detector::{Collapsed, LastCollision, Recent, recent, rests, sliding};
use super::impulse::{Collision, CollisionMasses};
use crate::clock::Clock;
use crate::encounter::{Couple, Encounter, Other, Partner, WallMotion};
use crate::engine::driver::Work;
use crate::engine::{Failure, Window};
use crate::scene::Scene;
use event_queue::{EventQueue, EventTable};
use frame::FallingFrame;
use nalgebra::Vector3;
use next_events::{EventKind, FlightState, NextEvents};
use prefetch_index::prefetch_index;
use serde::{Deserialize, Serialize};
use shells::Shells;
use std::time::Duration;
use walls::WallContacts;

/// Number of impacts after which the log of impacts is added to the record. A time window may have millions of impacts.
/// A log of this length stays in the processor's cache.
const KEPT_IMPACTS: usize = 1 << 8;

/// The event queue of all particles, with copies of their flights, their neighbour lists and their collision histories.
/// Times are counted from the instant called epoch.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct GlobalCalendar {
    frame: FallingFrame,
    /// Present time [s], counted from the epoch, the zero of the calendar's time.
    now: f64,
    /// Time [s] since the epoch (zero of the calendar's time) at which a new epoch must begin, before rounding errors
    /// of times grow too large, and before the frame or walls have moved too far.
    limit: f64,
    /// Time [s] since the epoch (zero of the calendar's time) up to which events are predicted and queued. It is the
    /// end of the window if drag changes velocities after every window, otherwise infinite.
    horizon: f64,
    /// Simulated time [s] at the epoch, the instant from which the calendar counts times. The places of moving walls
    /// and of the images of a sheared box follow from it.
    epoch: f64,
    bodies: Vec<FlightState>,
    next_events: Vec<NextEvents>,
    ids: Vec<u32>,
    /// Collision history of each particle, by particle index, by which inelastic collapse (infinitely many impacts in
    /// finite time) is detected.
    last_collisions: Vec<LastCollision>,
    shells: Shells,
    /// Time [s] since the epoch (zero of the calendar's time) until which neighbour lists across the sheared sides of
    /// the box are valid, since images slide there; infinite without shear.
    lists_valid_until: f64,
    /// True for each periodic axis along which the box is so short that a pair may touch through an image other than
    /// the nearest one.
    far_images: [bool; 3],
    /// Number of shells (balls in which neighbour lists are valid) that had been made when the particle store was last
    /// sorted.
    sorted_at: u64,
    /// Number of collisions that the event queue has processed so far.
    pub events: u64,
    /// Number of times of touch computed so far.
    touch_times: u64,
    /// Number of times that the event queue of all particles, with all neighbour lists, was built so far.
    pub builds: u64,
    /// Wall-clock time that building the event queue and all neighbour lists has taken so far.
    pub building: Duration,
    #[serde(skip)]
    queue: EventQueue,
    #[serde(skip)]
    walls: WallContacts,
    /// True if the data that snapshots of a run do not contain (event queue, cells, walls) have been computed.
    #[serde(skip)]
    ready: bool,
    /// Contact time t_c [s] of the TC model, in which a collision is elastic if either particle collided less than t_c
    /// before; `None` without this model.
    #[serde(skip)]
    pub contact_time: Option<f64>,
    /// Clock that measures the wall-clock time of building the event queue, and receives the progress of the run.
    #[serde(skip)]
    pub clock: Clock,
}

/// A window (time between two exchanges with the gas), with its end in simulated time and in the time of the calendar,
/// which is counted from the epoch.
#[derive(Clone, Copy)]
struct CalendarWindow {
    window: Window,
    /// [s] end of the window, counted from the epoch (zero of the calendar's time).
    end: f64,
}

impl CalendarWindow {
    /// Time [s] from `now` [s] since the epoch (zero of the calendar's time) to the end of the window.
    fn left(&self, now: f64) -> f64 {
        self.end - now
    }

    /// Simulated time [s] at `now` [s] since the epoch (zero of the calendar's time).
    fn time(&self, now: f64) -> f64 {
        self.window.start + (self.window.duration - self.left(now))
    }
}

impl GlobalCalendar {
    /// Moves all particles through a window, the time between two exchanges with the gas. `outdated` must be true if
    /// islands have moved particles since the last call; collision histories are then taken from `work.lasting`, which
    /// contains recent collisions only.
    ///
    /// # Errors
    /// Inelastic collapse, or velocities that are not finite numbers; the store then contains the state at the time of
    /// the error.
    pub fn run(&mut self, work: &mut Work<Recent>, window: Window, outdated: bool) -> Result<(), Failure> {
        self.begin(work, window, outdated)?;
        for met in &mut self.last_collisions {
            met.impacts = 0;
        }
        let mut span = CalendarWindow { window, end: self.now + window.duration };
        let result = self.events(work, &mut span);
        self.write(work.particles, work.scene);
        result
    }

    fn events(&mut self, work: &mut Work<Recent>, span: &mut CalendarWindow) -> Result<(), Failure> {
        loop {
            let stop = span.end.min(self.limit).min(self.lists_valid_until).max(self.now);
            while let Some(index) = self.queue.next(EventTable { next_events: &self.next_events, ids: &self.ids }, stop)
            {
                self.fetch_ahead();
                self.now = self.next_events[index as usize].time.max(self.now);
                self.event(index, work, span)?;
                self.clock.tell(span.time(self.now));
                if work.log.impacts.len() >= KEPT_IMPACTS {
                    work.record.absorb(work.log);
                }
            }
            self.now = stop;
            if stop >= self.lists_valid_until {
                self.next_interval(work);
            }
            if stop >= span.end {
                return Ok(());
            }
            if stop < self.limit {
                continue;
            }
            let left = span.left(self.now);
            self.new_epoch(work, span.time(self.now))?;
            span.end = self.now + left;
        }
    }

    /// Prefetches the data of the next events into the processor's cache. Data are fetched in stages, one event apart:
    /// first a particle, then its partner and its neighbour list, then the neighbours.
    fn fetch_ahead(&self) {
        let upcoming = |after| self.queue.upcoming(after).map(|index| &self.next_events[index as usize]);
        if let Some(index) = self.queue.upcoming(3) {
            self.fetch(index);
        }
        if let Some(events) = upcoming(2) {
            self.shells.fetch_list(&events.shell);
            if let EventKind::Pair(j) = events.kind {
                self.fetch(j);
            }
        }
        if let Some(events) = upcoming(1) {
            self.fetch_near(events);
            if let EventKind::Pair(j) = events.kind {
                self.shells.fetch_list(&self.next_events[j as usize].shell);
            }
        }
        if let Some(NextEvents { kind: EventKind::Pair(j), .. }) = upcoming(0) {
            self.fetch_near(&self.next_events[*j as usize]);
        }
    }

    #[inline]
    fn fetch(&self, index: u32) {
        prefetch_index(&self.next_events, index as usize);
        prefetch_index(&self.bodies, index as usize);
        prefetch_index(&self.last_collisions, index as usize);
    }

    #[inline]
    fn fetch_near(&self, events: &NextEvents) {
        self.shells.neighbours(&events.shell).iter().for_each(|&k| prefetch_index(&self.bodies, k as usize));
    }

    /// Processes the next event of the particle at `index`: a collision or a new shell. An event is void if its partner
    /// has collided meanwhile; if a second event is stored, it then replaces the void one in the queue. Otherwise the
    /// next events of all particles that took part are predicted.
    fn event(&mut self, index: u32, work: &mut Work<Recent>, span: &CalendarWindow) -> Result<(), Failure> {
        let scene = work.scene;
        let NextEvents { kind, detail, .. } = self.next_events[index as usize];
        match kind {
            EventKind::Pair(j) if self.bodies[j as usize].collision_count == detail => {
                self.collide(Couple::pair(index, j), 0, work, span)?;
                self.predict_events(index, scene);
                self.predict_events(j, scene);
                return Ok(());
            }
            EventKind::Wall(k) => {
                let at = self.walls.contacts[k as usize];
                self.collide(Couple::at_wall(index, at), detail, work, span)?;
            }
            EventKind::LeaveShell => self.make_shell(index, work),
            EventKind::Pair(_) if self.next_events[index as usize].has_second() => {
                self.next_events[index as usize].take_second();
                self.enqueue(index);
                return Ok(());
            }
            EventKind::Pair(_) | EventKind::Predict => self.bodies[index as usize].advance(self.now),
        }
        self.predict_events(index, scene);
        Ok(())
    }

    /// Position and velocity of particle `couple.i` relative to the other body at the present time, to which both
    /// flights must have been advanced. For a wall, `struck` is the number of the surface feature (such as a triangle)
    /// that is touched.
    fn meet(&self, couple: &Couple, struck: u32, scene: &Scene) -> Encounter {
        let body = &self.bodies[couple.i as usize];
        let radius = self.shells.radius(body);
        let (normal, gap, velocity) = match couple.other {
            Other::Particle(j) => {
                let other = &self.bodies[j as usize];
                let velocity = body.velocity - other.velocity;
                let (apart, velocity) = self.domain(scene).relative(&body.position, &other.position, velocity, 0.0);
                let distance = apart.norm();
                let normal = if distance > 0.0 { apart / distance } else { Vector3::y() };
                (normal, distance - (radius + self.shells.radius(other)), velocity)
            }
            Other::Wall(at) => {
                let flight = self.frame.flight(&body.position, &body.velocity, self.now);
                let wall = &scene.walls[at.wall as usize];
                let position = scene.domain.wrap(&flight.position);
                let ahead = self.ahead(wall);
                let nearest = wall.struck([at.which, struck], &position, radius, ahead);
                let surface = wall.surface_velocity(&(position - nearest.normal * nearest.distance), ahead);
                (nearest.normal, nearest.distance - radius, flight.velocity - surface)
            }
        };
        Encounter { normal, gap, velocity, normal_velocity: velocity.dot(&normal) }
    }

    /// Motion of the wall's surface at the point of contact at the present time: velocity, spin and accelerations.
    /// `None` for a pair of particles.
    fn wall_motion(&self, couple: &Couple, met: &Encounter, scene: &Scene) -> Option<WallMotion> {
        let Other::Wall(at) = couple.other else { return None };
        let (wall, body) = (&scene.walls[at.wall as usize], &self.bodies[couple.i as usize]);
        let flight = self.frame.flight(&body.position, &body.velocity, self.now);
        let depth = self.shells.radius(body) + met.gap;
        let touched = scene.domain.wrap(&flight.position) - met.normal * depth;
        Some(WallMotion::of(wall, &touched, self.ahead(wall)))
    }

    fn collide(
        &mut self,
        couple: Couple,
        struck: u32,
        work: &mut Work<Recent>,
        span: &CalendarWindow,
    ) -> Result<(), Failure> {
        let (scene, time) = (work.scene, span.time(self.now));
        for index in couple.indices().into_iter().flatten() {
            self.bodies[index as usize].advance(self.now);
        }
        let met = self.meet(&couple, struck, scene);
        let kinds = couple.kinds(work.particles);
        let wall = self.wall_motion(&couple, &met, scene);
        let image = self.image_velocity(&couple, &met, scene);
        let collision = Collision { couple, met, elastic: self.in_contact(&couple, time), kinds, wall, image };
        let weights = self.weights(&couple);
        let left = span.left(self.now);
        let (change_i, change_j) = match rests(&collision, scene, self.contact_time) {
            Some(speed) => (collision.hold_at_rest(speed, weights.mass, scene, left, work.log), Vector3::zeros()),
            None => collision.apply_impulse(&weights, work.particles, scene, left, work.log),
        };
        self.events += 1;
        for (index, change) in couple.indices().into_iter().flatten().zip([change_i, change_j]) {
            let body = &mut self.bodies[index as usize];
            body.velocity += change;
            body.collision_count = body.collision_count.wrapping_add(1);
        }
        self.watch(&collision, scene, time)
    }

    /// Velocity [m/s] along z of the periodic image that particle `couple.i` hits, relative to the other particle
    /// itself. It is 0 unless the two meet across a sheared side of the box.
    fn image_velocity(&self, couple: &Couple, met: &Encounter, scene: &Scene) -> f64 {
        let Some(j) = couple.j() else { return 0.0 };
        let own = self.bodies[couple.i as usize].velocity.z - self.bodies[j as usize].velocity.z;
        scene.domain.whole_slides(own - met.velocity.z)
    }

    fn weights(&self, couple: &Couple) -> CollisionMasses {
        let (i, j) = (&self.bodies[couple.i as usize], couple.j().map(|j| &self.bodies[j as usize]));
        let radius = self.shells.radius(i);
        CollisionMasses {
            mass: self.shells.mass(i),
            other: j.map(|j| self.shells.mass(j)),
            reach: radius + j.map_or(0.0, |j| self.shells.radius(j)),
            diameter: 2.0 * j.map_or(radius, |j| radius.min(self.shells.radius(j))),
        }
    }

    /// True if the TC model makes a collision of these bodies at simulated time `time` [s] elastic: one of them
    /// collided less than the contact time before.
    fn in_contact(&self, couple: &Couple, time: f64) -> bool {
        let Some(contact_time) = self.contact_time else { return false };
        couple.indices().into_iter().flatten().any(|i| time - self.last_collisions[i as usize].last < contact_time)
    }

    /// Adds a collision at simulated time `time` [s] to the histories of both partners. Returns an error if the
    /// histories show an inelastic collapse (infinitely many impacts in finite time).
    fn watch(&mut self, collision: &Collision, scene: &Scene, time: f64) -> Result<(), Failure> {
        let couple = collision.couple;
        for i in couple.indices().into_iter().flatten() {
            let met = &mut self.last_collisions[i as usize];
            let Some(interval) = met.note(collision, scene, time, self.contact_time) else { continue };
            let (impacts, particle) = (met.impacts, self.ids[i as usize]);
            let sliding = sliding(collision, scene);
            let collapsed = Collapsed { impacts, interval, contact_time: self.contact_time, sliding };
            let partner = match couple.other {
                Other::Wall(at) => Partner::Wall(at.wall),
                Other::Particle(j) => Partner::Particle(self.ids[if i == couple.i { j } else { couple.i } as usize]),
            };
            let body = &self.bodies[i as usize];
            let position = scene.domain.wrap(&self.frame.flight(&body.position, &body.velocity, self.now).position);
            return Err(collapsed.failure(time, (particle, partner), position));
        }
        Ok(())
    }

    /// Last collisions of all particles that collided less than the contact time of the TC model (in which their next
    /// collision is elastic) before simulated time `time` [s]. Empty without a contact time.
    pub fn recent(&self, time: f64) -> impl Iterator<Item = Recent> {
        recent(self.last_collisions.iter(), self.contact_time, time)
    }

    /// Number of touch times and of distances between shells computed so far, as a measure of work.
    pub fn pair_checks(&self) -> u64 {
        self.touch_times + self.shells.checks
    }

    /// Copy of this event queue of all particles for a snapshot of the run. It does not depend on the order in which
    /// the lists were built.
    pub fn state(&self) -> Self {
        let (shells, next_events) = self.shells.tidy(&self.next_events);
        Self { shells, next_events, queue: EventQueue::default(), ..self.clone() }
    }

    /// Continues from a state that [`state`](Self::state) has returned. The clock and the contact time of this event
    /// queue stay as they are.
    pub fn resume(&mut self, state: Self) {
        let (clock, contact_time) = (self.clock.clone(), self.contact_time);
        *self = Self { clock, contact_time, ..state };
    }
}
