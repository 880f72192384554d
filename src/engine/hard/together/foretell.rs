//! When does a particle touch somebody, and whom first?

use super::Together;
use super::card::{Body, Next};
use crate::encounter::{AtWall, first_touch};
use crate::particles::CHUNK;
use crate::scene::Scene;
use crate::walls::Touch;
use nalgebra::Vector3;
use rayon::prelude::*;

/// What comes to a particle next, and in how long [s].
#[derive(Clone, Copy)]
struct Event {
    wait: f64,
    next: Next,
    /// What of a wall is touched.
    place: u32,
}

impl Event {
    /// One for which nothing else counts.
    fn new(wait: f64, next: Next) -> Self {
        Self { wait, next, place: 0 }
    }
}

/// All contacts that the walls of a scene may have with a sphere.
pub(super) fn at_walls(scene: &Scene) -> impl Iterator<Item = AtWall> {
    let walls = scene.walls.iter().enumerate();
    walls.flat_map(|(wall, shape)| (0..shape.geometry.contacts()).map(move |which| AtWall { wall: wall as u32, which }))
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
        let event = self.next_event(place, scene);
        self.foretold += u64::from(self.cards[place as usize].shell.count());
        self.note(place, event);
        let card = &self.cards[place as usize];
        if card.time < self.horizon {
            self.agenda.file(place, card);
        }
    }

    /// Foretells everything; all particles are at the present time.
    pub(super) fn foretell_all(&mut self, scene: &Scene) {
        let count = self.bodies.len();
        self.foretold += self.cards.iter().map(|card| u64::from(card.shell.count())).sum::<u64>();
        if count <= CHUNK {
            for place in 0..count as u32 {
                let event = self.next_event(place, scene);
                self.note(place, event);
            }
            return;
        }
        let this = &*self;
        let each = (0..count as u32).into_par_iter().with_min_len(CHUNK);
        let all: Vec<Event> = each.map(|place| this.next_event(place, scene)).collect();
        for (place, event) in all.into_iter().enumerate() {
            self.note(place as u32, event);
        }
    }

    fn note(&mut self, place: u32, event: Event) {
        let detail = match event.next {
            Next::Pair(j) => self.bodies[j as usize].hits,
            Next::Wall(_) | Next::Leave | Next::Look => event.place,
        };
        let card = &mut self.cards[place as usize];
        (card.time, card.next, card.detail) = (self.now + event.wait, event.next, detail);
    }

    /// The earliest of leaving the shell, the horizon, and all touches.
    fn next_event(&self, place: u32, scene: &Scene) -> Event {
        let (body, shell) = (&self.bodies[place as usize], &self.cards[place as usize].shell);
        let leave = leave(body, &shell.centre, self.shells.margin);
        let look = self.horizon.min(self.limit) - self.now;
        let mut event = if leave < look { Event::new(leave, Next::Leave) } else { Event::new(look, Next::Look) };
        let neighbours = self.shells.neighbours(shell);
        if self.far_images == [false; 3] {
            self.nearest_images(body, neighbours, scene, &mut event);
        } else {
            self.all_images(body, neighbours, scene, &mut event);
        }
        if shell.at_wall && event.wait < f64::INFINITY {
            let mut flight = self.frame.flight(&body.position, &body.velocity, self.now);
            flight.position = scene.domain.wrap(&flight.position);
            for (k, at) in at_walls(scene).enumerate() {
                let shape = &scene.walls[at.wall as usize].geometry;
                let touch = shape.first_touch(at.which, &flight, self.shells.radius(body), event.wait);
                if let Some(Touch { time, place }) = touch.filter(|touch| touch.time < event.wait) {
                    event = Event { wait: time, next: Next::Wall(k as u32), place };
                }
            }
        }
        event
    }

    /// All touches through the nearest images. How fast and from where each neighbour comes is worked out first, for a number of them: no
    /// answer there decides what is read next, so the processor waits for all of them at once.
    #[inline]
    fn nearest_images(&self, body: &Body, neighbours: &[u32], scene: &Scene, event: &mut Event) {
        let radius = self.shells.radius(body);
        let mut approaches = [Approach::default(); AT_ONCE];
        for neighbours in neighbours.chunks(AT_ONCE) {
            for (approach, &j) in approaches.iter_mut().zip(neighbours) {
                let other = &self.bodies[j as usize];
                let there = other.position + other.velocity * (self.now - other.time);
                let apart = scene.domain.separation(&body.position, &there);
                let velocity = body.velocity - other.velocity;
                let reach = radius + self.shells.radius(other);
                let square = apart.norm_squared();
                *approach = Approach {
                    closing: -apart.dot(&velocity),
                    gap: square - reach * reach,
                    speed_square: velocity.norm_squared(),
                };
            }
            for (approach, &j) in approaches.iter().zip(neighbours) {
                // the touch comes no sooner than after gap/(2 closing); the factor is for rounding, so that ties do not depend on the order
                let Approach { closing, gap, speed_square } = *approach;
                if closing <= 0.0 || gap > 2.0 * closing * event.wait * (1.0 + 1e-9) {
                    continue;
                }
                let discriminant = closing * closing - speed_square * gap;
                if discriminant < 0.0 {
                    continue;
                }
                let wait = if gap <= 0.0 { 0.0 } else { gap / (closing + discriminant.sqrt()) };
                if wait <= event.wait && self.comes_before(wait, j, event) {
                    let other = &self.bodies[j as usize];
                    let reach = radius + self.shells.radius(other);
                    let speeds = body.velocity.norm() + other.velocity.norm();
                    if closing > RESOLUTION * (gap + reach * reach).sqrt() * speeds {
                        *event = Event::new(wait, Next::Pair(j));
                    }
                }
            }
        }
    }

    /// Whether a touch with `j` in `wait` [s] comes before an event: at the same time, that of the lower id.
    fn comes_before(&self, wait: f64, j: u32, event: &Event) -> bool {
        match event.next {
            Next::Pair(k) if wait == event.wait => self.cards[j as usize].id < self.cards[k as usize].id,
            _ => wait < event.wait,
        }
    }

    /// The same where a pair may touch by way of the other side of the box.
    fn all_images(&self, body: &Body, neighbours: &[u32], scene: &Scene, event: &mut Event) {
        let size = &scene.domain.size;
        for &j in neighbours {
            let other = &self.bodies[j as usize];
            let there = other.position + other.velocity * (self.now - other.time);
            let apart = scene.domain.separation(&body.position, &there);
            let velocity = body.velocity - other.velocity;
            let reach = self.shells.radius(body) + self.shells.radius(other);
            let speeds = body.velocity.norm() + other.velocity.norm();
            for image in 0..8usize {
                if (0..3).any(|axis| image >> axis & 1 == 1 && !self.far_images[axis]) {
                    continue;
                }
                let apart = Vector3::from_fn(|axis, _| {
                    apart[axis] - if image >> axis & 1 == 1 { size[axis].copysign(apart[axis]) } else { 0.0 }
                });
                if let Some(wait) = first_touch(&apart, &velocity, reach, speeds)
                    && self.comes_before(wait, j, event)
                {
                    *event = Event::new(wait, Next::Pair(j));
                }
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
