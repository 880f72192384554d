//! Prediction of the next two events of a particle: touches, and the exit from its shell (the ball in which its
//! neighbour list is valid).

use super::GlobalCalendar;
#[cfg(target_arch = "x86_64")]
use super::approach::wide::Wide;
use super::approach::{FourNeighbours, ObservingParticle};
use super::cells::ROUNDING;
use super::event_queue::EventTable;
use super::next_events::{EventKind, FlightState};
use super::shells::Shell;
use crate::domain::Domain;
use crate::encounter::first_touch;
use crate::particles::CHUNK;
use crate::scene::Scene;
use crate::walls::Touch;
use nalgebra::Vector3;
use rayon::prelude::*;

/// A predicted event of a particle, with the time `wait` [s] from now until it happens.
#[derive(Clone, Copy)]
struct Event {
    wait: f64,
    next: EventKind,
    /// Number of the surface feature (such as a triangle) of a wall that is touched; 0 for other events.
    place: u32,
}

/// The earliest two events of a particle, among those that the prediction has found so far.
#[derive(Clone, Copy)]
struct Events {
    first: Event,
    second: Event,
}

impl Events {
    /// Adds an event if it is earlier than one of the two stored events. If touches with two particles have equal
    /// times, the touch with the particle of the lower id comes first. `ids` contains the id of each particle.
    #[inline]
    fn offer(&mut self, event: Event, ids: &[u32]) {
        let before = |other: &Event| match (event.next, other.next) {
            (EventKind::Pair(j), EventKind::Pair(k)) if event.wait == other.wait => ids[j as usize] < ids[k as usize],
            _ => event.wait < other.wait,
        };
        if before(&self.first) {
            *self = Self { first: event, second: self.first };
        } else if before(&self.second) {
            self.second = event;
        }
    }
}

/// Number of groups of four neighbours that are tested before times of touch are computed for the neighbours that come
/// near.
const AT_ONCE: usize = 4;

/// [-] smallest resolvable rate of approach, divided by the distance and by the sum of both speeds. A slower approach
/// is a rounding error, as in [`first_touch`].
const RESOLUTION: f64 = 4.0 * f64::EPSILON;

impl GlobalCalendar {
    /// Predicts the next two events of one particle and puts the first into the event queue. The flight of the particle
    /// must have been advanced to the present time.
    #[inline]
    pub(super) fn predict_events(&mut self, place: u32, scene: &Scene) {
        let events = self.next_events(place, scene);
        self.foretold += u64::from(self.next_events[place as usize].shell.count());
        self.note(place, events);
        self.file(place);
    }

    /// Puts the next event of a particle into the event queue. Events after the horizon, the time up to which events
    /// are predicted, are left out.
    #[inline]
    pub(super) fn file(&mut self, place: u32) {
        if self.next_events[place as usize].time < self.horizon {
            self.agenda.file(place, EventTable { next_events: &self.next_events, ids: &self.ids });
        }
    }

    /// Predicts the next two events of every particle, without filling the event queue. All flights must have been
    /// advanced to the present time.
    pub(super) fn foretell_all(&mut self, scene: &Scene) {
        let count = self.bodies.len();
        self.foretold += self.next_events.iter().map(|card| u64::from(card.shell.count())).sum::<u64>();
        if count <= CHUNK {
            for place in 0..count as u32 {
                let events = self.next_events(place, scene);
                self.note(place, events);
            }
            return;
        }
        // a few chunks of particles at a time, so that most events are stored only once in memory, in `next_events`
        let together = CHUNK * rayon::current_num_threads();
        for first in (0..count).step_by(together) {
            let (last, this) = (count.min(first + together), &*self);
            let each = (first as u32..last as u32).into_par_iter().with_min_len(CHUNK);
            let events: Vec<Events> = each.map(|place| this.next_events(place, scene)).collect();
            for (place, events) in (first as u32..).zip(events) {
                self.note(place, events);
            }
        }
    }

    #[inline]
    fn note(&mut self, place: u32, Events { first, second }: Events) {
        let detail = |event: &Event| match event.next {
            EventKind::Pair(j) => self.bodies[j as usize].hits,
            EventKind::Wall(_) | EventKind::Leave | EventKind::Look => event.place,
        };
        let details = (detail(&first), detail(&second));
        let card = &mut self.next_events[place as usize];
        (card.time, card.then) = (self.now + first.wait, self.now + second.wait);
        (card.next, card.after) = (first.next, second.next);
        (card.detail, card.detail_after) = details;
    }

    /// Finds the earliest two events of a particle. The candidates are the exit from its shell (ball in which its
    /// neighbour list is valid), the end of prediction, and all touches. Only a touch has a second event; otherwise
    /// both events are equal.
    #[inline]
    fn next_events(&self, place: u32, scene: &Scene) -> Events {
        let (body, shell) = (&self.bodies[place as usize], &self.next_events[place as usize].shell);
        let leave = leave(body, &shell.centre(), self.shells.margin);
        let look = self.horizon.min(self.limit) - self.now;
        let (wait, next) = if leave < look { (leave, EventKind::Leave) } else { (look, EventKind::Look) };
        let last = Event { wait, next, place: 0 };
        let mut events = Events { first: last, second: last };
        if self.far_images == [false; 3] && (shell.inside || scene.domain.shear.is_none()) {
            self.touches(body, shell, &scene.domain, &mut events);
        } else {
            self.all_images(body, self.shells.neighbours(shell), scene, &mut events);
        }
        if shell.at_wall && last.wait < f64::INFINITY {
            self.at_walls(body, scene, &mut events);
        }
        events
    }

    /// Adds to `events` the coming touches of a particle with walls, if they are among the earliest two events.
    fn at_walls(&self, body: &FlightState, scene: &Scene, events: &mut Events) {
        let mut flight = self.frame.flight(&body.position, &body.velocity, self.now);
        flight.position = scene.domain.wrap(&flight.position);
        let (radius, until) = (self.shells.radius(body), events.second.wait);
        let mut ask = |k: u32| {
            let at = self.walls.contacts[k as usize];
            let (wall, span) =
                (&scene.walls[at.wall as usize], (self.ahead(&scene.walls[at.wall as usize]), events.second.wait));
            if let Some(Touch { time, place }) = wall.first_touch(at.which, &flight, radius, span) {
                events.offer(Event { wait: time, next: EventKind::Wall(k), place }, &self.ids);
            }
        };
        if self.walls.near.are_few() {
            (0..self.walls.contacts.len() as u32).for_each(ask);
            return;
        }
        let way = (flight.velocity.norm() + 0.5 * flight.gravity.norm() * until) * until;
        let reach = (radius + way) * (1.0 + ROUNDING);
        let mut near = Vec::new();
        self.walls.near.list(&flight.position, reach, &mut near);
        near.into_iter().flat_map(|wall| self.walls.of_wall(wall)).for_each(&mut ask);
    }

    /// Adds to `events` the coming touches of a particle with the nearest images of its neighbours. The processor's
    /// vector instructions are used if it has them.
    #[inline]
    fn touches(&self, body: &FlightState, shell: &Shell, domain: &Domain, events: &mut Events) {
        let view = ObservingParticle {
            here: body.position,
            velocity: body.velocity,
            now: self.now,
            inside: shell.inside,
            domain,
        };
        // the factor allows for rounding, so that touches at equal times are all found
        let soon = 2.0 * events.second.wait * (1.0 + 1e-9);
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            simd.vectorize(
                #[inline(always)]
                || {
                    let wide = Wide::new(simd, &view, soon);
                    self.touches_by(
                        body,
                        shell,
                        #[inline(always)]
                        |others, touch| wide.at_once(others, touch),
                        events,
                    );
                },
            );
            return;
        }
        self.touches_by(body, shell, |others, touch| view.one_by_one(others, touch, soon), events);
    }

    /// Adds to `events` the coming touches of a particle with its neighbours. The function `look` tests four neighbours
    /// at a time and marks those that may touch soon enough; only for these a time of touch is computed. Marking needs
    /// no branches, of which the processor would mispredict every second one.
    #[inline(always)]
    fn touches_by(
        &self,
        body: &FlightState,
        shell: &Shell,
        look: impl Fn(&[&FlightState; 4], &[f64; 4]) -> (FourNeighbours, u32),
        events: &mut Events,
    ) {
        let radius = self.shells.radius(body);
        let (alike, largest_square) = (self.shells.alike(), (2.0 * self.shells.largest()).powi(2));
        for places in self.shells.in_fours(shell).chunks(AT_ONCE) {
            let (mut seen, mut coming) = ([FourNeighbours::default(); AT_ONCE], 0);
            for (k, (four, places)) in seen.iter_mut().zip(places).enumerate() {
                let [a, b, c, d] = *places;
                let others = [self.body(a), self.body(b), self.body(c), self.body(d)];
                let touch = if alike {
                    [largest_square; 4]
                } else {
                    others.map(|other| (radius + self.shells.radius(other)).powi(2))
                };
                let come;
                (*four, come) = look(&others, &touch);
                coming |= come << (4 * k);
            }
            while coming != 0 {
                let bit = coming.trailing_zeros() as usize;
                coming &= coming - 1;
                self.touch(body, &seen[bit / 4], (bit % 4, places[bit / 4][bit % 4]), events);
            }
        }
    }

    #[inline(always)]
    fn body(&self, place: u32) -> &FlightState {
        &self.bodies[place as usize]
    }

    /// Adds to `events` the touch of a particle with one approaching neighbour. `k` is the number of the neighbour in
    /// the group `four`, and `place` its particle index.
    #[inline(always)]
    fn touch(&self, body: &FlightState, four: &FourNeighbours, (k, place): (usize, u32), events: &mut Events) {
        let (closing, gap, discriminant) = (four.closing[k], four.gap[k], four.discriminant[k]);
        let wait = if gap <= 0.0 { 0.0 } else { gap / (closing + discriminant.sqrt()) };
        if wait > events.second.wait {
            return;
        }
        let other = &self.bodies[place as usize];
        let reach = self.shells.radius(body) + self.shells.radius(other);
        // at least the square of the sum of both speeds
        let speeds_square = 2.0 * (body.velocity.norm_squared() + other.velocity.norm_squared());
        if closing * closing > RESOLUTION * RESOLUTION * (gap + reach * reach) * speeds_square {
            events.offer(Event { wait, next: EventKind::Pair(place), place: 0 }, &self.ids);
        }
    }

    /// Adds to `events` the coming touches of a particle with all images of its neighbours. This is needed near sheared
    /// sides, and in a box so short that images other than the nearest may touch.
    fn all_images(&self, body: &FlightState, neighbours: &[u32], scene: &Scene, events: &mut Events) {
        let (size, domain) = (&scene.domain.size, self.domain(scene));
        for &j in neighbours {
            let other = &self.bodies[j as usize];
            let there = other.position + other.velocity * (self.now - other.time);
            let (apart, velocity) = domain.relative(&body.position, &there, body.velocity - other.velocity, 0.0);
            let reach = self.shells.radius(body) + self.shells.radius(other);
            let speeds = body.velocity.norm() + other.velocity.norm();
            let images = (0..8usize).filter(|image| (0..3).all(|axis| image >> axis & 1 == 0 || self.far_images[axis]));
            let touch = images.filter_map(|image| {
                let apart = Vector3::from_fn(|axis, _| {
                    apart[axis] - if image >> axis & 1 == 1 { size[axis].copysign(apart[axis]) } else { 0.0 }
                });
                first_touch(&apart, &velocity, reach, speeds)
            });
            if let Some(wait) = touch.reduce(f64::min) {
                events.offer(Event { wait, next: EventKind::Pair(j), place: 0 }, &self.ids);
            }
        }
    }
}

/// Time [s] until a particle is `margin` [m] away from the centre [m] of its shell (ball in which its neighbour list is
/// valid). It is infinite if the particle does not move in the falling frame.
fn leave(body: &FlightState, centre: &Vector3<f64>, margin: f64) -> f64 {
    let from = body.position - centre;
    let (along, square) = (from.dot(&body.velocity), body.velocity.norm_squared());
    if square == 0.0 {
        return f64::INFINITY;
    }
    let room = (margin * margin - from.norm_squared()).max(0.0);
    // root in a form without cancellation
    let root = (along * along + square * room).sqrt();
    if along > 0.0 { room / (along + root) } else { (root - along) / square }
}
