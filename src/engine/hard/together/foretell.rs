//! When does a particle touch somebody, and whom first?

use super::Together;
use super::agenda::Book;
use super::card::{Body, Next};
use super::cells::ROUNDING;
use crate::encounter::first_touch;
use crate::particles::CHUNK;
use crate::scene::Scene;
use crate::walls::Touch;
use nalgebra::Vector3;
use rayon::prelude::*;

/// What comes to a particle, and in how long [s].
#[derive(Clone, Copy)]
struct Event {
    wait: f64,
    next: Next,
    /// What of a wall is touched.
    place: u32,
}

/// The first two things that come to a particle.
#[derive(Clone, Copy)]
struct Events {
    first: Event,
    second: Event,
}

impl Events {
    /// Takes note of a further event, if it is one of the first two. Touches at the same time go by the ids of the partners.
    #[inline]
    fn offer(&mut self, event: Event, ids: &[u32]) {
        let before = |other: &Event| match (event.next, other.next) {
            (Next::Pair(j), Next::Pair(k)) if event.wait == other.wait => ids[j as usize] < ids[k as usize],
            _ => event.wait < other.wait,
        };
        if before(&self.first) {
            *self = Self { first: event, second: self.first };
        } else if before(&self.second) {
            self.second = event;
        }
    }
}

/// Neighbours that are looked at together.
const AT_ONCE: usize = 16;

/// How a neighbour comes nearer.
#[derive(Clone, Copy, Default)]
struct Approach {
    /// [m²/s] half the rate at which the square of the distance falls.
    closing: f64,
    /// [m²] square of the distance, less that of touch.
    gap: f64,
    /// [m²/s²] square of the relative speed.
    speed_square: f64,
}

/// An approach slower than this times the distance and the sum of the speeds is rounding, as in [`first_touch`].
const RESOLUTION: f64 = 4.0 * f64::EPSILON;

impl Together {
    /// Foretells what comes to one particle, which is at the present time.
    #[inline]
    pub(super) fn foretell(&mut self, place: u32, scene: &Scene) {
        let events = self.next_events(place, scene);
        self.foretold += u64::from(self.cards[place as usize].shell.count());
        self.note(place, events);
        self.file(place);
    }

    /// Files the event of a particle, if it is due before the horizon.
    #[inline]
    pub(super) fn file(&mut self, place: u32) {
        if self.cards[place as usize].time < self.horizon {
            self.agenda.file(place, Book { cards: &self.cards, ids: &self.ids });
        }
    }

    /// Foretells everything; all particles are at the present time.
    pub(super) fn foretell_all(&mut self, scene: &Scene) {
        let count = self.bodies.len();
        self.foretold += self.cards.iter().map(|card| u64::from(card.shell.count())).sum::<u64>();
        if count <= CHUNK {
            for place in 0..count as u32 {
                let events = self.next_events(place, scene);
                self.note(place, events);
            }
            return;
        }
        let this = &*self;
        let each = (0..count as u32).into_par_iter().with_min_len(CHUNK);
        let all: Vec<Events> = each.map(|place| this.next_events(place, scene)).collect();
        for (place, events) in all.into_iter().enumerate() {
            self.note(place as u32, events);
        }
    }

    #[inline]
    fn note(&mut self, place: u32, Events { first, second }: Events) {
        let detail = |event: &Event| match event.next {
            Next::Pair(j) => self.bodies[j as usize].hits,
            Next::Wall(_) | Next::Leave | Next::Look => event.place,
        };
        let details = (detail(&first), detail(&second));
        let card = &mut self.cards[place as usize];
        (card.time, card.then) = (self.now + first.wait, self.now + second.wait);
        (card.next, card.after) = (first.next, second.next);
        (card.detail, card.detail_after) = details;
    }

    /// The earliest two of leaving the shell, the horizon, and all touches; of one that is not a touch, nothing after it.
    #[inline]
    fn next_events(&self, place: u32, scene: &Scene) -> Events {
        let (body, shell) = (&self.bodies[place as usize], &self.cards[place as usize].shell);
        let leave = leave(body, &shell.centre(), self.shells.margin);
        let look = self.horizon.min(self.limit) - self.now;
        let (wait, next) = if leave < look { (leave, Next::Leave) } else { (look, Next::Look) };
        let last = Event { wait, next, place: 0 };
        let mut events = Events { first: last, second: last };
        let neighbours = self.shells.neighbours(shell);
        let (here, domain) = (&body.position, &scene.domain);
        if self.far_images != [false; 3] {
            self.all_images(body, neighbours, scene, &mut events);
        } else if shell.inside && self.shells.alike() {
            let square = (2.0 * self.shells.largest()).powi(2);
            self.touches(body, neighbours, |there, _| (here - there, square), &mut events);
        } else {
            let radius = self.shells.radius(body);
            let square = |other: &Body| (radius + self.shells.radius(other)).powi(2);
            let apart = |there: &_, other: &_| (domain.separation(here, there), square(other));
            self.touches(body, neighbours, apart, &mut events);
        }
        if shell.at_wall && last.wait < f64::INFINITY {
            self.at_walls(body, scene, &mut events);
        }
        events
    }

    /// All touches with walls.
    fn at_walls(&self, body: &Body, scene: &Scene, events: &mut Events) {
        let mut flight = self.frame.flight(&body.position, &body.velocity, self.now);
        flight.position = scene.domain.wrap(&flight.position);
        let (radius, until) = (self.shells.radius(body), events.second.wait);
        let mut ask = |k: u32| {
            let at = self.walls.contacts[k as usize];
            let (shape, until) = (&scene.walls[at.wall as usize].geometry, events.second.wait);
            if let Some(Touch { time, place }) = shape.first_touch(at.which, &flight, radius, until) {
                events.offer(Event { wait: time, next: Next::Wall(k), place }, &self.ids);
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

    /// All touches with neighbours: `apart` gives the way [m] from one that is at a place, by one image alone, and the square of
    /// the distance [m²] at which they touch. How fast and from where each comes is worked out
    /// first, for a number of them: no answer there decides what is read next, so the processor waits for all of them at once.
    #[inline]
    fn touches(
        &self,
        body: &Body,
        neighbours: &[u32],
        apart: impl Fn(&Vector3<f64>, &Body) -> (Vector3<f64>, f64),
        events: &mut Events,
    ) {
        let mut approaches = [Approach::default(); AT_ONCE];
        for neighbours in neighbours.chunks(AT_ONCE) {
            for (approach, &j) in approaches.iter_mut().zip(neighbours) {
                let other = &self.bodies[j as usize];
                let (apart, touch_square) = apart(&(other.position + other.velocity * (self.now - other.time)), other);
                let velocity = body.velocity - other.velocity;
                *approach = Approach {
                    closing: -apart.dot(&velocity),
                    gap: apart.norm_squared() - touch_square,
                    speed_square: velocity.norm_squared(),
                };
            }
            for (approach, &j) in approaches.iter().zip(neighbours) {
                // the touch comes no sooner than after gap/(2 closing); the factor is for rounding, so that ties do not depend on the order
                let Approach { closing, gap, speed_square } = *approach;
                if closing <= 0.0 || gap > 2.0 * closing * events.second.wait * (1.0 + 1e-9) {
                    continue;
                }
                let discriminant = closing * closing - speed_square * gap;
                if discriminant < 0.0 {
                    continue;
                }
                let wait = if gap <= 0.0 { 0.0 } else { gap / (closing + discriminant.sqrt()) };
                let other = &self.bodies[j as usize];
                let reach = self.shells.radius(body) + self.shells.radius(other);
                // no less than the square of the sum of the speeds
                let speeds_square = 2.0 * (body.velocity.norm_squared() + other.velocity.norm_squared());
                if closing * closing > RESOLUTION * RESOLUTION * (gap + reach * reach) * speeds_square {
                    events.offer(Event { wait, next: Next::Pair(j), place: 0 }, &self.ids);
                }
            }
        }
    }

    /// The same where a pair may touch by way of the other side of the box.
    fn all_images(&self, body: &Body, neighbours: &[u32], scene: &Scene, events: &mut Events) {
        let size = &scene.domain.size;
        for &j in neighbours {
            let other = &self.bodies[j as usize];
            let there = other.position + other.velocity * (self.now - other.time);
            let apart = scene.domain.separation(&body.position, &there);
            let velocity = body.velocity - other.velocity;
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
                events.offer(Event { wait, next: Next::Pair(j), place: 0 }, &self.ids);
            }
        }
    }
}

/// [s] until a particle is `margin` [m] away from the centre of its shell; infinite if it does not move.
fn leave(body: &Body, centre: &Vector3<f64>, margin: f64) -> f64 {
    let from = body.position - centre;
    let (along, square) = (from.dot(&body.velocity), body.velocity.norm_squared());
    if square == 0.0 {
        return f64::INFINITY;
    }
    let room = (margin * margin - from.norm_squared()).max(0.0);
    // the form that does not cancel
    let root = (along * along + square * room).sqrt();
    if along > 0.0 { room / (along + root) } else { (root - along) / square }
}
