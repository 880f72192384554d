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
    kind: EventKind,
    /// Number of the surface feature (such as a triangle) of a wall that is touched; 0 for other events.
    feature: u32,
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
        let before = |other: &Event| match (event.kind, other.kind) {
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

/// [-] smallest resolvable speed of approach, divided by the sum of the speeds of both particles. A slower approach is
/// a rounding error, as in [`first_touch`].
const RESOLUTION: f64 = 4.0 * f64::EPSILON;

impl GlobalCalendar {
    /// Predicts the next two events of one particle and puts the first into the event queue. The flight of the particle
    /// must have been advanced to the present time.
    #[inline]
    pub(super) fn predict_events(&mut self, index: u32, scene: &Scene) {
        let events = self.next_events(index, scene);
        self.touch_times += u64::from(self.next_events[index as usize].shell.count());
        self.store_events(index, events);
        self.enqueue(index);
    }

    /// Puts the next event of a particle into the event queue. Events after the horizon, the time up to which events
    /// are predicted, are left out.
    #[inline]
    pub(super) fn enqueue(&mut self, index: u32) {
        if self.next_events[index as usize].time < self.horizon {
            self.queue.insert(index, EventTable { next_events: &self.next_events, ids: &self.ids });
        }
    }

    /// Predicts the next two events of every particle, without filling the event queue. All flights must have been
    /// advanced to the present time.
    pub(super) fn foretell_all(&mut self, scene: &Scene) {
        let count = self.bodies.len();
        self.touch_times += self.next_events.iter().map(|events| u64::from(events.shell.count())).sum::<u64>();
        if count <= CHUNK {
            for index in 0..count as u32 {
                let events = self.next_events(index, scene);
                self.store_events(index, events);
            }
            return;
        }
        // a few chunks of particles at a time, so that most events are stored only once in memory, in `next_events`
        let batch = CHUNK * rayon::current_num_threads();
        for first in (0..count).step_by(batch) {
            let (last, this) = (count.min(first + batch), &*self);
            let each = (first as u32..last as u32).into_par_iter().with_min_len(CHUNK);
            let events: Vec<Events> = each.map(|index| this.next_events(index, scene)).collect();
            for (index, events) in (first as u32..).zip(events) {
                self.store_events(index, events);
            }
        }
    }

    #[inline]
    fn store_events(&mut self, index: u32, Events { first, second }: Events) {
        let detail = |event: &Event| match event.kind {
            EventKind::Pair(j) => self.bodies[j as usize].collision_count,
            EventKind::Wall(_) | EventKind::LeaveShell | EventKind::Predict => event.feature,
        };
        let details = (detail(&first), detail(&second));
        let events = &mut self.next_events[index as usize];
        (events.time, events.second_time) = (self.now + first.wait, self.now + second.wait);
        (events.kind, events.second_kind) = (first.kind, second.kind);
        (events.detail, events.second_detail) = details;
    }

    /// Finds the earliest two events of a particle. The candidates are the exit from its shell (ball in which its
    /// neighbour list is valid), the end of prediction, and all touches. If no touch is the first event, both events
    /// are the same.
    #[inline]
    fn next_events(&self, index: u32, scene: &Scene) -> Events {
        let (body, shell) = (&self.bodies[index as usize], &self.next_events[index as usize].shell);
        let leave = leave(body, &shell.centre(), self.shells.margin);
        let end = self.horizon.min(self.limit) - self.now;
        let (wait, kind) = if leave < end { (leave, EventKind::LeaveShell) } else { (end, EventKind::Predict) };
        let last = Event { wait, kind, feature: 0 };
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
            if let Some(Touch { time, feature }) = wall.first_touch(at.which, &flight, radius, span) {
                events.offer(Event { wait: time, kind: EventKind::Wall(k), feature }, &self.ids);
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

    /// Adds to `events` the coming touches of a particle with its neighbours. The function `test` tests four neighbours
    /// at a time and marks those that may touch soon enough; only for these a time of touch is computed. Marking needs
    /// no branches, of which the processor would mispredict every second one.
    #[inline(always)]
    fn touches_by(
        &self,
        body: &FlightState,
        shell: &Shell,
        test: impl Fn(&[&FlightState; 4], &[f64; 4]) -> (FourNeighbours, u32),
        events: &mut Events,
    ) {
        let radius = self.shells.radius(body);
        let (alike, largest_square) = (self.shells.alike(), (2.0 * self.shells.largest()).powi(2));
        for indices in self.shells.in_fours(shell).chunks(AT_ONCE) {
            let (mut seen, mut coming) = ([FourNeighbours::default(); AT_ONCE], 0);
            for (k, (four, indices)) in seen.iter_mut().zip(indices).enumerate() {
                let [a, b, c, d] = *indices;
                let others = [self.body(a), self.body(b), self.body(c), self.body(d)];
                let touch = if alike {
                    [largest_square; 4]
                } else {
                    others.map(|other| (radius + self.shells.radius(other)).powi(2))
                };
                let come;
                (*four, come) = test(&others, &touch);
                coming |= come << (4 * k);
            }
            while coming != 0 {
                let bit = coming.trailing_zeros() as usize;
                coming &= coming - 1;
                self.touch(body, &seen[bit / 4], (bit % 4, indices[bit / 4][bit % 4]), events);
            }
        }
    }

    #[inline(always)]
    fn body(&self, index: u32) -> &FlightState {
        &self.bodies[index as usize]
    }

    /// Adds to `events` the touch of a particle with one approaching neighbour. `k` is the number of the neighbour in
    /// the group `four`, and `index` its particle index.
    #[inline(always)]
    fn touch(&self, body: &FlightState, four: &FourNeighbours, (k, index): (usize, u32), events: &mut Events) {
        let (closing, gap, discriminant) = (four.closing[k], four.gap[k], four.discriminant[k]);
        let wait = if gap <= 0.0 { 0.0 } else { gap / (closing + discriminant.sqrt()) };
        if wait > events.second.wait {
            return;
        }
        let other = &self.bodies[index as usize];
        let reach = self.shells.radius(body) + self.shells.radius(other);
        // at least the square of the sum of both speeds
        let speeds_square = 2.0 * (body.velocity.norm_squared() + other.velocity.norm_squared());
        if closing * closing > RESOLUTION * RESOLUTION * (gap + reach * reach) * speeds_square {
            events.offer(Event { wait, kind: EventKind::Pair(index), feature: 0 }, &self.ids);
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
                events.offer(Event { wait, kind: EventKind::Pair(j), feature: 0 }, &self.ids);
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
    // this form of the root does not subtract nearly equal numbers, which would lose digits
    let root = (along * along + square * room).sqrt();
    if along > 0.0 { room / (along + root) } else { (root - along) / square }
}
