//! Prediction of the next two events of a particle: touches, and the exit from its shell (the ball in which its
//! neighbour list is valid). The time of a touch depends only on the flights of the two bodies, not on the instant of
//! the prediction.

#[cfg(target_arch = "x86_64")]
use super::approach::wide::Wide;
use super::approach::{FourNeighbours, ObservingParticle};
use super::cells::ROUNDING;
use super::neighbour_lists::NeighbourLists;
use super::next_events::{EventKind, FlightState, NextEvents};
use super::shells::Shell;
use super::view::CalendarView;
use crate::encounter::first_touch;
use crate::walls::Touch;
use nalgebra::Vector3;

/// A predicted event of a particle.
#[derive(Clone, Copy)]
struct Event {
    /// [s] time of the event since the epoch (zero of the event queue's time).
    time: f64,
    kind: EventKind,
    /// Number of the surface feature (such as a triangle) of a wall that is touched; 0 for other events.
    feature: u32,
}

/// The earliest two events of a particle, among those that the prediction has found so far.
#[derive(Clone, Copy)]
pub struct Events {
    first: Event,
    second: Event,
}

impl Events {
    /// Adds an event if it is earlier than one of the two stored events. If touches with two particles have equal
    /// times, the touch with the particle of the lower id comes first. `ids` contains the id of each particle.
    #[inline]
    fn offer(&mut self, event: Event, ids: &[u32]) {
        let before = |other: &Event| match (event.kind, other.kind) {
            (EventKind::Pair(j), EventKind::Pair(k)) if event.time == other.time => ids[j as usize] < ids[k as usize],
            _ => event.time < other.time,
        };
        if before(&self.first) {
            *self = Self { first: event, second: self.first };
        } else if before(&self.second) {
            self.second = event;
        }
    }
}

/// Number of groups of four neighbours that are tested at once. After the test, times of touch are computed for those
/// neighbours of the groups that may touch soon enough.
const AT_ONCE: usize = 4;

/// [-] smallest resolvable speed of approach, divided by the sum of the speeds of both particles. A slower approach is
/// treated as a rounding error and not as an approach, as in [`first_touch`].
const RESOLUTION: f64 = 4.0 * f64::EPSILON;

/// Flights of particles with consecutive indices, and all other data that a prediction of their events reads.
#[derive(Clone, Copy)]
pub struct Flights<'a> {
    /// Data of the calendar (event queue of all particles) that no event changes.
    pub around: &'a CalendarView<'a>,
    /// Index of the first particle of these flights in the particle store.
    pub first: u32,
    /// Flights of the particles from the index `first` on. Predictions leave out neighbours without a flight in this
    /// list.
    pub bodies: &'a [FlightState],
    /// [s] present time since the epoch (zero of the event queue's time).
    pub now: f64,
    /// True if no flight begins later than `now`.
    pub in_order: bool,
}

impl<'a> Flights<'a> {
    /// Flight of the particle at `index`; `None` if these flights do not include this particle.
    #[inline(always)]
    pub fn get(&self, index: u32) -> Option<&'a FlightState> {
        self.bodies.get(index.wrapping_sub(self.first) as usize)
    }

    /// Tests whether a particle with the flight `body` and the particle `j` may have touched after the time `start`
    /// [s], but before the later of their present flights began. A prediction from the present flights would miss such
    /// a touch. Returns the start [s] of the later flight, or `None` if such a touch is impossible. `speed` [m/s] is an
    /// upper limit of all speeds. Times are counted from the epoch (zero of the event queue's time).
    #[inline]
    pub fn may_have_touched(&self, body: &FlightState, j: u32, start: f64, speed: f64) -> Option<f64> {
        let other = self.get(j)?;
        let later = Some(body.time.max(other.time)).filter(|later| *later > start)?;
        let apart = body.position_at(later) - other.position_at(later);
        let square = self.around.scene.domain.nearest_image(&apart).norm_squared();
        let shells = self.around.shells;
        let reach = shells.radius(body) + shells.radius(other) + 2.0 * speed * (later - start);
        (square <= reach * reach).then_some(later)
    }

    /// Predicts the next two events of the particle with the flight `body`, and writes them into its entry `events`.
    /// `lists` are the neighbour lists of its part, the particles of one thread.
    #[inline]
    pub fn predict_into(&self, body: &FlightState, events: &mut NextEvents, lists: &NeighbourLists) {
        let Events { first, second } = self.next_events(body, &events.shell, lists);
        let detail = |event: &Event| match event.kind {
            EventKind::Pair(j) => self.get(j).map_or(0, |other| other.collision_count),
            EventKind::Wall(_) | EventKind::LeaveShell | EventKind::Predict => event.feature,
        };
        (events.time, events.second_time) = (first.time, second.time);
        (events.kind, events.second_kind) = (first.kind, second.kind);
        (events.detail, events.second_detail) = (detail(&first), detail(&second));
    }

    /// Finds the earliest two events of a particle. The candidates are all touches, the exit from its shell (ball in
    /// which its neighbour list is valid), and the end of prediction (time up to which events are predicted). If no
    /// other event comes before the end of prediction, both events are this end.
    #[inline]
    fn next_events(&self, body: &FlightState, shell: &Shell, lists: &NeighbourLists) -> Events {
        let around = self.around;
        let leave = self.now + self.leave(body, &shell.centre());
        let end = around.horizon.min(around.limit);
        let never = |time: f64| Event { time, kind: EventKind::Predict, feature: 0 };
        let mut events = if leave < end {
            let leave = Event { time: leave, kind: EventKind::LeaveShell, feature: 0 };
            Events { first: leave, second: if around.slack > 0.0 { never(leave.time + around.grace) } else { leave } }
        } else {
            Events { first: never(end), second: never(end) }
        };
        let domain = &around.scene.domain;
        if around.far_images == [false; 3] && !around.shells.is_at_sheared_side(shell, domain) {
            self.touches(body, shell, lists.in_fours(shell), &mut events);
        } else {
            self.all_images(body, lists.neighbours(shell), &mut events);
        }
        if shell.at_wall && events.first.time < f64::INFINITY {
            self.at_walls(body, &mut events);
        }
        events
    }

    /// Adds to `events` the coming touches of a particle with walls, if they are among the earliest two events.
    fn at_walls(&self, body: &FlightState, events: &mut Events) {
        let around = self.around;
        let (scene, walls) = (around.scene, around.walls);
        // places of moving walls are those of the present window
        let start = if scene.has_moving_walls() { self.now } else { body.time };
        let mut flight = around.frame.flight(&body.position_at(start), &body.velocity, start);
        flight.position = scene.domain.wrap(&flight.position);
        let radius = around.shells.radius(body);
        let until = events.second.time - start;
        let mut ask = |k: u32| {
            let at = walls.contacts[k as usize];
            let wall = &scene.walls[at.wall as usize];
            let span = (around.ahead(wall, start), events.second.time - start);
            if let Some(Touch { time, feature }) = wall.first_touch(at.which, &flight, radius, span) {
                events.offer(Event { time: start + time, kind: EventKind::Wall(k), feature }, around.ids);
            }
        };
        if walls.near.are_few() {
            (0..walls.contacts.len() as u32).for_each(ask);
            return;
        }
        let way = (flight.velocity.norm() + 0.5 * flight.gravity.norm() * until) * until;
        let reach = (radius + way) * (1.0 + ROUNDING);
        let mut near = Vec::new();
        walls.near.list(&flight.position, reach, &mut near);
        near.into_iter().flat_map(|wall| walls.of_wall(wall)).for_each(&mut ask);
    }

    /// Adds to `events` the coming touches of a particle with the nearest images of its neighbours. If the processor
    /// has vector instructions for four numbers, the function uses them.
    #[inline]
    fn touches(&self, body: &FlightState, shell: &Shell, neighbours: &[[u32; 4]], events: &mut Events) {
        let domain = &self.around.scene.domain;
        // in a sheared box, new shells shift particles by whole periods
        let (until, now, across) = (events.second.time, self.now, shell.across || domain.shear.is_some());
        let is_latest = self.in_order && body.time == now;
        let view = ObservingParticle { flight: body, until, now, is_latest, across, domain };
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            simd.vectorize(
                #[inline(always)]
                || {
                    let wide = Wide::new(simd, &view);
                    self.touches_by(
                        body,
                        neighbours,
                        #[inline(always)]
                        |others, touch| wide.at_once(others, touch),
                        events,
                    );
                },
            );
            return;
        }
        self.touches_by(body, neighbours, |others, touch| view.one_by_one(others, touch), events);
    }

    /// Adds to `events` the coming touches of a particle with its neighbours. The function `test` takes four neighbours
    /// and the squared distances [m²] of the centres at touch. It marks the neighbours that may touch soon enough; only
    /// for these, times of touch are computed. The marks are computed without branches, because the processor would
    /// mispredict every second branch.
    #[inline(always)]
    fn touches_by(
        &self,
        body: &FlightState,
        neighbours: &[[u32; 4]],
        test: impl Fn(&[&FlightState; 4], &[f64; 4]) -> (FourNeighbours, u32),
        events: &mut Events,
    ) {
        let shells = self.around.shells;
        let radius = shells.radius(body);
        let (alike, largest_square) = (shells.alike(), (2.0 * shells.largest()).powi(2));
        // the particle itself stands for neighbours that are left out: it does not touch itself
        let flight = |index: u32| self.get(index).unwrap_or(body);
        for indices in neighbours.chunks(AT_ONCE) {
            let (mut seen, mut coming) = ([FourNeighbours::default(); AT_ONCE], 0);
            for (k, (four, indices)) in seen.iter_mut().zip(indices).enumerate() {
                let [a, b, c, d] = *indices;
                let others = [flight(a), flight(b), flight(c), flight(d)];
                let touch = if alike {
                    [largest_square; 4]
                } else {
                    others.map(|other| (radius + shells.radius(other)).powi(2))
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

    /// Adds to `events` the touch of a particle with one approaching neighbour. `k` is the number (0 to 3) of the
    /// neighbour in the group `four`, and `index` its particle index.
    #[inline(always)]
    fn touch(&self, body: &FlightState, four: &FourNeighbours, (k, index): (usize, u32), events: &mut Events) {
        let (closing, gap, discriminant) = (four.closing[k], four.gap[k], four.discriminant[k]);
        let wait = if gap <= 0.0 { 0.0 } else { gap / (closing + discriminant.sqrt()) };
        let time = four.start[k] + wait;
        let Some(other) = self.get(index).filter(|_| time <= events.second.time) else { return };
        let shells = self.around.shells;
        let reach = shells.radius(body) + shells.radius(other);
        // at least the square of the sum of both speeds
        let speeds_square = 2.0 * (body.velocity.norm_squared() + other.velocity.norm_squared());
        if closing * closing > RESOLUTION * RESOLUTION * (gap + reach * reach) * speeds_square {
            events.offer(Event { time, kind: EventKind::Pair(index), feature: 0 }, self.around.ids);
        }
    }

    /// Adds to `events` the coming touches of a particle with all images of its neighbours. All images are needed near
    /// sheared sides, and in a box so short that images other than the nearest may touch. The times of touch are
    /// computed from the present positions.
    fn all_images(&self, body: &FlightState, neighbours: &[u32], events: &mut Events) {
        let around = self.around;
        let size = &around.scene.domain.size;
        for &j in neighbours {
            let Some(other) = self.get(j) else { continue };
            let (here, there) = (body.position_at(self.now), other.position_at(self.now));
            let (apart, velocity) = around.relative(&here, &there, body.velocity - other.velocity, self.now);
            let reach = around.shells.radius(body) + around.shells.radius(other);
            let speeds = body.velocity.norm() + other.velocity.norm();
            let far = around.far_images;
            let images = (0..8usize).filter(|image| (0..3).all(|axis| image >> axis & 1 == 0 || far[axis]));
            let touch = images.filter_map(|image| {
                let apart = Vector3::from_fn(|axis, _| {
                    apart[axis] - if image >> axis & 1 == 1 { size[axis].copysign(apart[axis]) } else { 0.0 }
                });
                first_touch(&apart, &velocity, reach, speeds)
            });
            if let Some(wait) = touch.reduce(f64::min) {
                events.offer(Event { time: self.now + wait, kind: EventKind::Pair(j), feature: 0 }, around.ids);
            }
        }
    }

    /// Time [s] from now until a particle leaves its shell (ball in which its neighbour list is valid) with the centre
    /// `centre` [m]. While several threads share the events, the exit is taken at the distance `slack` [m] inside the
    /// surface of the shell. The time is infinite if the particle does not move in the falling frame.
    fn leave(&self, body: &FlightState, centre: &Vector3<f64>) -> f64 {
        let (margin, domain) = (self.around.shells.margin - self.around.slack, &self.around.scene.domain);
        let from = domain.nearest_image(&(body.position_at(self.now) - centre));
        let (along, square) = (from.dot(&body.velocity), body.velocity.norm_squared());
        if square == 0.0 {
            return f64::INFINITY;
        }
        let room = (margin * margin - from.norm_squared()).max(0.0);
        // this form of the root does not subtract nearly equal numbers, which would lose digits
        let root = (along * along + square * room).sqrt();
        if along > 0.0 { room / (along + root) } else { (root - along) / square }
    }
}
