//! Events of a part of the particles. A part consists of the particles that one thread treats, or of all particles. Its
//! particles have consecutive indices. Times are counted from the epoch, the zero of the event queue's time. The
//! calendar is the event queue of all particles.

use super::event_queue::{EventQueue, EventTable};
use super::neighbour_lists::{NeighbourLists, lists_of};
use super::next_events::{EventKind, FlightState, NextEvents};
use super::prediction::Flights;
use super::rounds::Round;
use super::view::CalendarView;
use super::{CalendarWindow, is_full};
use crate::encounter::{Couple, Encounter, Other, Partner, WallMotion};
use crate::engine::Failure;
use crate::engine::hard::collapse_detector::{Collapsed, LastCollision, rests, sliding};
use crate::engine::hard::impulse::{Collision, CollisionMasses, ParticleAccess};
use crate::record::{Log, Record};
use nalgebra::Vector3;
use prefetch_index::prefetch_index;

/// Numbers of collisions, and of pairs that were tested to predict them.
#[derive(Clone, Copy, Debug, Default)]
pub struct EventCounts {
    /// Number of collisions.
    pub collisions: u64,
    /// Number of computed times of touch, and of distances between shells (balls in which neighbour lists are valid).
    pub pair_checks: u64,
}

/// A part of the particles, with consecutive indices, whose events one thread processes in the order of time.
pub struct Part<'a> {
    /// Data of the calendar (event queue of all particles) that no event changes.
    pub around: &'a CalendarView<'a>,
    /// The particle store, with the species of all particles.
    pub particles: ParticleAccess<'a>,
    /// Index, in the particle store, of the first particle of this part.
    pub first: u32,
    /// Straight flights of the particles of this part.
    pub bodies: &'a mut [FlightState],
    /// Next two events of each particle of this part.
    pub next_events: &'a mut [NextEvents],
    /// Collision history of each particle of this part.
    pub last_collisions: &'a mut [LastCollision],
    /// Neighbour lists of the particles: one item for this part, or one item for each part if this is the part of all
    /// particles.
    pub lists: &'a mut [NeighbourLists],
    /// Event queue of the particles of this part.
    pub queue: &'a mut EventQueue,
    /// [s] present time since the epoch (zero of the event queue's time).
    pub now: f64,
    /// The present window. With it, times since the epoch (zero of the event queue's time) are converted to simulated
    /// times.
    pub span: CalendarWindow,
    /// Log of the collisions.
    pub log: &'a mut Log,
    /// Numbers of collisions and of tested pairs since this part of the particles was set up.
    pub counts: EventCounts,
    /// The present round, a piece of time in which several threads process events; `None` if only one thread does.
    pub round: Option<&'a mut Round>,
}

impl Part<'_> {
    /// Place, in the lists of this part such as `bodies`, of the particle that has the index `index` in the particle
    /// store. The place is beyond the end of the lists if the particle belongs to another part.
    #[inline(always)]
    pub fn place(&self, index: u32) -> usize {
        index.wrapping_sub(self.first) as usize
    }

    #[inline(always)]
    fn body(&self, index: u32) -> &FlightState {
        &self.bodies[self.place(index)]
    }

    /// Neighbour lists of the part (particles of one thread) to which the particle at `index` belongs.
    #[inline(always)]
    fn lists_of(&self, index: u32) -> &NeighbourLists {
        lists_of(self.lists, &self.around.shells.parts, index)
    }

    /// Removes the earliest event from the queue, and makes its time the present time. Returns the index of the
    /// particle that has this event; `None` if no event is earlier than `before` [s] since the epoch (zero of the event
    /// queue's time).
    #[inline]
    pub fn next(&mut self, before: f64) -> Option<u32> {
        let table = EventTable { first: self.first, next_events: self.next_events, ids: self.around.ids };
        let index = self.queue.next(table, before)?;
        self.fetch_ahead();
        self.now = self.next_events[self.place(index)].time.max(self.now);
        Some(index)
    }

    /// Processes the events before the time `stop` [s] since the epoch (zero of the event queue's time), and then
    /// returns `None`. Returns early with the index of a particle that leaves its shell (ball in which its neighbour
    /// list is valid) and therefore needs a new one. `before` is the number of collisions of the run so far.
    pub fn run(&mut self, stop: f64, record: &mut Record, before: u64) -> Result<Option<u32>, Failure> {
        while let Some(index) = self.next(stop) {
            let collisions = self.counts.collisions;
            let leaves = self.event(index)?;
            self.around.clock.tell(self.span.time(self.now));
            if self.counts.collisions > collisions && is_full(before + self.counts.collisions) {
                record.absorb(self.log);
            }
            if leaves {
                return Ok(Some(index));
            }
        }
        self.now = stop;
        Ok(None)
    }

    /// Prefetches the data of the next events into the processor's cache. The data of an event are fetched in stages,
    /// one stage per processed event: first the particle, then its partner and its neighbour list, then the neighbours.
    fn fetch_ahead(&self) {
        if let Some(index) = self.queue.upcoming(3) {
            self.fetch(index);
        }
        if let Some(index) = self.queue.upcoming(2) {
            let events = &self.next_events[self.place(index)];
            self.lists_of(index).fetch_list(&events.shell);
            if let EventKind::Pair(j) = events.kind {
                self.fetch(j);
            }
        }
        if let Some(index) = self.queue.upcoming(1) {
            let events = &self.next_events[self.place(index)];
            self.fetch_near(index, events);
            if let EventKind::Pair(j) = events.kind
                && let Some(other) = self.next_events.get(self.place(j))
            {
                self.lists_of(j).fetch_list(&other.shell);
            }
        }
        if let Some(index) = self.queue.upcoming(0)
            && let EventKind::Pair(j) = self.next_events[self.place(index)].kind
            && let Some(other) = self.next_events.get(self.place(j))
        {
            self.fetch_near(j, other);
        }
    }

    #[inline]
    fn fetch(&self, index: u32) {
        let place = self.place(index);
        prefetch_index(&*self.next_events, place);
        prefetch_index(&*self.bodies, place);
        prefetch_index(&*self.last_collisions, place);
    }

    #[inline]
    fn fetch_near(&self, index: u32, events: &NextEvents) {
        let near = self.lists_of(index).neighbours(&events.shell);
        near.iter().for_each(|&k| prefetch_index(&*self.bodies, self.place(k)));
    }

    /// Processes the next event of the particle at `index`. Returns true, without a prediction, if the particle leaves
    /// its shell (ball in which its neighbour list is valid) and needs a new shell at once. If the partner of a touch
    /// has collided meanwhile, the event is void. The stored second event then becomes the next event, if there is one.
    /// The second event also becomes the next event after an exit from a shell during a round (piece of time shared by
    /// threads), if the particle must wait for its new shell. In all other cases, the next events of the particles that
    /// took part are predicted.
    #[inline]
    pub fn event(&mut self, index: u32) -> Result<bool, Failure> {
        let place = self.place(index);
        let NextEvents { kind, detail, .. } = self.next_events[place];
        match kind {
            EventKind::Pair(j) if self.body(j).collision_count == detail => {
                self.collide(Couple::pair(index, j), 0)?;
                self.predict_events(index);
                self.predict_events(j);
                return Ok(false);
            }
            EventKind::Wall(k) => {
                let at = self.around.walls.contacts[k as usize];
                self.collide(Couple::at_wall(index, at), detail)?;
            }
            EventKind::LeaveShell => {
                let renews = self.round.as_ref().is_some_and(|round| !round.is_border) && self.may_renew(index);
                let Some(round) = &mut self.round else { return Ok(true) };
                round.undo.note(index);
                if renews {
                    self.renew_shell(index);
                    return Ok(false);
                }
                round.leaving.push(index);
                if self.take_second(index) {
                    return Ok(false);
                }
            }
            EventKind::Pair(_) | EventKind::Predict => {
                if let Some(round) = &mut self.round {
                    round.undo.note(index);
                    // the partner has collided, but perhaps later than the time of this touch
                    let partner = if let EventKind::Pair(j) = kind { j } else { index };
                    round.note_order(self.bodies[(partner - self.first) as usize].time, self.now);
                }
                if matches!(kind, EventKind::Pair(_)) && self.take_second(index) {
                    return Ok(false);
                }
                if self.around.scene.domain.shear.is_some() {
                    // images slide, so the time of a touch is computed from the present places
                    self.bodies[place].advance(self.now);
                }
            }
        }
        self.predict_events(index);
        Ok(false)
    }

    /// Replaces the next event of the particle at `index` by its stored second event. Returns false if no second event
    /// is stored.
    #[inline]
    fn take_second(&mut self, index: u32) -> bool {
        let events = &mut self.next_events[(index - self.first) as usize];
        let has_second = events.has_second();
        if has_second {
            events.take_second();
            self.enqueue(index);
        }
        has_second
    }

    /// Processes the next event of the particle at `index` in a round (piece of time in which several threads process
    /// events). Returns false if the round must be undone.
    #[inline]
    pub fn event_in_round(&mut self, index: u32) -> bool {
        let result = self.event(index);
        let counts = std::mem::take(&mut self.counts);
        let Some(round) = &mut self.round else { return false };
        round.must_be_repeated |= result.is_err();
        round.counts.collisions += counts.collisions;
        round.counts.pair_checks += counts.pair_checks;
        !round.has_failed()
    }

    /// Predicts the next two events of one particle and puts the first into the event queue.
    #[inline]
    pub fn predict_events(&mut self, index: u32) {
        let place = self.place(index);
        let in_order = self.round.as_ref().is_none_or(|round| !round.is_border);
        let flights = Flights { around: self.around, first: self.first, bodies: self.bodies, now: self.now, in_order };
        let lists = lists_of(self.lists, &self.around.shells.parts, index);
        flights.predict_into(&self.bodies[place], &mut self.next_events[place], lists);
        let shell = &self.next_events[place].shell;
        self.counts.pair_checks += u64::from(shell.count());
        if let Some(round) = &mut self.round {
            if round.is_border {
                let neighbours = lists.neighbours(shell).iter();
                let (body, now, speed) = (&self.bodies[place], self.now, round.speed);
                let is_later = |j: &&u32| flights.get(**j).is_some_and(|other| other.time > now);
                let early = neighbours.filter(is_later).filter_map(|&j| flights.may_have_touched(body, j, now, speed));
                round.early = early.fold(round.early, f64::min);
                if matches!(self.next_events[place].kind, EventKind::Pair(_)) {
                    round.predicted.push(index);
                }
            } else if shell.at_border {
                round.predicted.push(index);
            }
        }
        self.enqueue(index);
    }

    /// Puts the next event of a particle into the event queue. Events at or after the horizon, the time up to which
    /// events are predicted, are left out.
    #[inline]
    pub fn enqueue(&mut self, index: u32) {
        if self.next_events[self.place(index)].time < self.around.horizon {
            let table = EventTable { first: self.first, next_events: self.next_events, ids: self.around.ids };
            self.queue.insert(index, table);
        }
    }

    /// Position and velocity of particle `couple.i` relative to the other body at the present time. The flights of both
    /// must have been advanced to this time. For a wall, `struck` is the number of the surface feature (such as a
    /// triangle) that is touched.
    fn meet(&self, couple: &Couple, struck: u32) -> Encounter {
        let around = self.around;
        let body = self.body(couple.i);
        let radius = around.shells.radius(body);
        let (normal, gap, velocity) = match couple.other {
            Other::Particle(j) => {
                let other = self.body(j);
                let velocity = body.velocity - other.velocity;
                let (apart, velocity) = around.relative(&body.position, &other.position, velocity, self.now);
                let distance = apart.norm();
                let normal = if distance > 0.0 { apart / distance } else { Vector3::y() };
                (normal, distance - (radius + around.shells.radius(other)), velocity)
            }
            Other::Wall(at) => {
                let flight = around.flight(&body.position, &body.velocity, self.now);
                let wall = &around.scene.walls[at.wall as usize];
                let position = around.scene.domain.wrap(&flight.position);
                let ahead = around.ahead(wall, self.now);
                let nearest = wall.struck([at.which, struck], &position, radius, ahead);
                let surface = wall.surface_velocity(&(position - nearest.normal * nearest.distance), ahead);
                (nearest.normal, nearest.distance - radius, flight.velocity - surface)
            }
        };
        Encounter { normal, gap, velocity, normal_velocity: velocity.dot(&normal) }
    }

    /// Motion of the wall's surface at the point of contact at the present time: velocity, spin and accelerations.
    /// `None` for a pair of particles.
    fn wall_motion(&self, couple: &Couple, met: &Encounter) -> Option<WallMotion> {
        let Other::Wall(at) = couple.other else { return None };
        let around = self.around;
        let (wall, body) = (&around.scene.walls[at.wall as usize], self.body(couple.i));
        let flight = around.flight(&body.position, &body.velocity, self.now);
        let depth = around.shells.radius(body) + met.gap;
        let touched = around.scene.domain.wrap(&flight.position) - met.normal * depth;
        Some(WallMotion::of(wall, &touched, around.ahead(wall, self.now)))
    }

    fn collide(&mut self, couple: Couple, struck: u32) -> Result<(), Failure> {
        let (scene, time, contact_time) = (self.around.scene, self.span.time(self.now), self.around.contact_time);
        for index in couple.indices().into_iter().flatten() {
            let place = self.place(index);
            if let Some(round) = &mut self.round {
                round.undo.push(index, &self.bodies[place], &self.last_collisions[place]);
                round.note_order(self.bodies[place].time, self.now);
            }
            self.bodies[place].advance(self.now);
        }
        let met = self.meet(&couple, struck);
        let kinds = couple.kinds(&self.particles);
        let wall = self.wall_motion(&couple, &met);
        let image = self.image_velocity(&couple, &met);
        let collision = Collision { couple, met, elastic: self.in_contact(&couple, time), kinds, wall, image };
        let weights = self.weights(&couple);
        let left = self.span.left(self.now);
        let (change_i, change_j) = match rests(&collision, scene, contact_time) {
            Some(speed) => (collision.hold_at_rest(speed, weights.mass, scene, left, self.log), Vector3::zeros()),
            None => collision.apply_impulse(&weights, &mut self.particles, scene, left, self.log),
        };
        self.counts.collisions += 1;
        for (index, change) in couple.indices().into_iter().flatten().zip([change_i, change_j]) {
            let place = self.place(index);
            let body = &mut self.bodies[place];
            body.velocity += change;
            body.collision_count = body.collision_count.wrapping_add(1);
            if let Some(round) = &mut self.round {
                let square = body.velocity.norm_squared();
                round.must_be_repeated |= square > round.speed * round.speed || square.is_nan();
            }
        }
        if let Some(round) = &mut self.round {
            round.records.take(self.now, self.around.ids[couple.i as usize], &collision, self.log);
        }
        self.watch(&collision, time)
    }

    /// Velocity [m/s] along z of the periodic image of the other particle that particle `couple.i` hits, relative to
    /// the other particle itself. It is 0 unless the two meet across a sheared side of the box.
    fn image_velocity(&self, couple: &Couple, met: &Encounter) -> f64 {
        let domain = &self.around.scene.domain;
        let Some(j) = couple.j().filter(|_| domain.shear.is_some()) else { return 0.0 };
        let own = self.body(couple.i).velocity.z - self.body(j).velocity.z;
        domain.whole_slides(own - met.velocity.z)
    }

    fn weights(&self, couple: &Couple) -> CollisionMasses {
        let shells = self.around.shells;
        let (i, j) = (self.body(couple.i), couple.j().map(|j| self.body(j)));
        let radius = shells.radius(i);
        CollisionMasses {
            mass: shells.mass(i),
            other: j.map(|j| shells.mass(j)),
            reach: radius + j.map_or(0.0, |j| shells.radius(j)),
            diameter: 2.0 * j.map_or(radius, |j| radius.min(shells.radius(j))),
        }
    }

    /// True if the TC model makes a collision of these bodies at simulated time `time` [s] elastic. It does so if one
    /// of them last collided less than the contact time before.
    fn in_contact(&self, couple: &Couple, time: f64) -> bool {
        let Some(contact_time) = self.around.contact_time else { return false };
        let last = |index: u32| self.last_collisions[self.place(index)].last;
        couple.indices().into_iter().flatten().any(|index| time - last(index) < contact_time)
    }

    /// Adds a collision at simulated time `time` [s] to the histories of both partners. Returns an error if the
    /// histories show an inelastic collapse (infinitely many impacts in finite time).
    fn watch(&mut self, collision: &Collision, time: f64) -> Result<(), Failure> {
        let (couple, around) = (collision.couple, self.around);
        for i in couple.indices().into_iter().flatten() {
            let place = self.place(i);
            let met = &mut self.last_collisions[place];
            let Some(interval) = met.note(collision, around.scene, time, around.contact_time) else { continue };
            let (impacts, particle) = (met.impacts, around.ids[i as usize]);
            let sliding = sliding(collision, around.scene);
            let collapsed = Collapsed { impacts, interval, contact_time: around.contact_time, sliding };
            let partner = match couple.other {
                Other::Wall(at) => Partner::Wall(at.wall),
                Other::Particle(j) => Partner::Particle(around.ids[if i == couple.i { j } else { couple.i } as usize]),
            };
            let body = &self.bodies[place];
            let flight = around.flight(&body.position, &body.velocity, self.now);
            let position = around.scene.domain.wrap(&flight.position);
            return Err(collapsed.failure(time, (particle, partner), position));
        }
        Ok(())
    }
}
