//! The global calendar: one event queue for all particles, which lasts from one time window to the next.
//!
//! For every particle the calendar stores the earliest two events. An event is a touch, or the exit from the particle's
//! shell (a ball in which its neighbour list is valid). The events of a particle are predicted again after the particle
//! has collided, or when the partner of its next event has collided meanwhile. A window is the time between two
//! exchanges of momentum with the gas; the end of a window changes no event. Each flight is stored with the time at
//! which it began, and this time may differ from particle to particle. So a collision moves only two particles and
//! tests their neighbours. The calendar counts times from an instant called *epoch*.
//!
//! The calendar stores a copy of the flights, in a falling frame, and writes positions and velocities to the particle
//! store at the end of each window. If velocities in the store have changed when the next window begins, for instance
//! by drag, all events are predicted again.
//!
//! Several threads can share the events if there are at least 20,000 particles, and if no drag or other kick changes
//! velocities between windows. They do so in rounds, short pieces of time ([`rounds`]).

mod approach;
mod bins;
mod cells;
mod curve;
mod division;
mod event_queue;
mod frame;
mod list_pool;
mod list_update;
mod load;
mod neighbour_lists;
mod next_events;
mod old_neighbours;
mod part;
mod prediction;
mod records;
mod renewal;
mod rounds;
mod search;
mod shells;
mod sliding;
mod territories;
mod undo;
mod view;
mod walls;

use super::collapse_detector::{LastCollision, Recent, recent};
use super::impulse::ParticleAccess;
use crate::clock::Clock;
use crate::engine::driver::Work;
use crate::engine::{Failure, Window};
use division::Division;
use event_queue::EventQueue;
use frame::FallingFrame;
use neighbour_lists::NeighbourLists;
use next_events::{FlightState, NextEvents};
use part::EventCounts;
use rounds::{PartState, Round};
use serde::{Deserialize, Serialize};
use shells::Shells;
use std::time::Duration;
use walls::WallContacts;

/// Makes a view of those data of a calendar (event queue of all particles) that no event changes ([`CalendarView`]). A
/// macro borrows single fields, so that the other data of the calendar can be changed at the same time.
macro_rules! view_of {
    ($calendar:expr, $scene:expr) => {
        $crate::engine::hard::global_calendar::view::CalendarView {
            scene: $scene,
            frame: $calendar.frame,
            limit: $calendar.limit,
            horizon: $calendar.horizon,
            epoch: $calendar.epoch,
            lists_valid_until: $calendar.lists_valid_until,
            shells: &$calendar.shells,
            walls: &$calendar.walls,
            ids: &$calendar.ids,
            far_images: $calendar.far_images,
            contact_time: $calendar.contact_time,
            slack: $calendar.slack,
            grace: $calendar.grace,
            clock: &$calendar.clock,
        }
    };
}
use view_of;

/// Makes one [`Part`] of all particles of a calendar (event queue), so that one thread can process all events.
macro_rules! whole_of {
    ($calendar:expr, $around:expr, $particles:expr, $log:expr, $span:expr) => {
        $crate::engine::hard::global_calendar::part::Part {
            around: $around,
            particles: $particles,
            first: 0,
            bodies: &mut $calendar.bodies,
            next_events: &mut $calendar.next_events,
            last_collisions: &mut $calendar.last_collisions,
            lists: &mut $calendar.lists,
            queue: &mut $calendar.queue,
            now: $calendar.now,
            span: $span,
            log: $log,
            counts: Default::default(),
            round: None,
        }
    };
}
use whole_of;

/// Number of collisions after which the log (impacts not yet counted) is added to the record of the run. A time window
/// may have millions of collisions. A log of this length stays in the processor's cache.
const KEPT: u64 = 1 << 8;

/// Appends an item to a list. A full list grows by an eighth, since the default growth would double its memory.
#[inline]
fn append<T>(list: &mut Vec<T>, item: T) {
    if list.len() == list.capacity() {
        list.reserve_exact(list.len() / 8 + 64);
    }
    list.push(item);
}

/// True if the log (impacts not yet counted) must now be added to the record of the run. `collisions` is the number of
/// all collisions of the run so far. This number does not depend on the division of the work among threads, so neither
/// do the sums in the record.
fn is_full(collisions: u64) -> bool {
    collisions.is_multiple_of(KEPT)
}

/// The event queue of all particles, with copies of their flights, their neighbour lists and their collision histories.
/// Times are counted from the instant called epoch.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct GlobalCalendar {
    frame: FallingFrame,
    /// Present time [s], counted from the epoch, the zero of the event queue's time.
    now: f64,
    /// Time [s] since the epoch (zero of the event queue's time) at which a new epoch must begin. After this time,
    /// rounding errors of times would be too large, or the frame or walls would have moved too far.
    limit: f64,
    /// Time [s] since the epoch (zero of the event queue's time) up to which events are predicted and queued. It is the
    /// end of the window if drag changes velocities after every window, otherwise infinite.
    horizon: f64,
    /// Simulated time [s] at the epoch, the instant from which the event queue counts times. The places of moving walls
    /// and of the images of a sheared box follow from it.
    epoch: f64,
    bodies: Vec<FlightState>,
    next_events: Vec<NextEvents>,
    ids: Vec<u32>,
    /// Collision history of each particle, by particle index, by which inelastic collapse (infinitely many impacts in
    /// finite time) is detected.
    last_collisions: Vec<LastCollision>,
    shells: Shells,
    /// Neighbour lists of the particles, one item for each thread that processes events.
    lists: Vec<NeighbourLists>,
    /// Time [s] since the epoch (zero of the event queue's time) until which neighbour lists across the sheared sides
    /// of the box are valid, since images slide there; infinite without shear.
    lists_valid_until: f64,
    /// True for each periodic axis along which the box is so short that two particles may touch through an image other
    /// than the nearest one.
    far_images: [bool; 3],
    /// Number of collisions that had been processed when the particle store was last sorted.
    sorted_at: u64,
    /// Number of collisions that the event queue has processed so far.
    pub events: u64,
    /// Number of touch times computed so far, plus the number of computed distances between shells (balls in which
    /// neighbour lists are valid).
    pair_checks: u64,
    /// Number of times that the event queue of all particles, with all neighbour lists, was built so far.
    pub builds: u64,
    /// Wall-clock time that building the event queue and all neighbour lists has taken so far.
    pub building: Duration,
    /// Event queue of all particles. While several threads share the events, it holds only the events that concern
    /// particles of different threads.
    #[serde(skip)]
    queue: EventQueue,
    /// Parts, one for each thread: groups of particles with consecutive indices, and their events. Empty while one
    /// thread processes all events.
    #[serde(skip)]
    parts: Vec<PartState>,
    /// Data of those events in a round (piece of time in which several threads process events) whose particles belong
    /// to different threads.
    #[serde(skip)]
    border: Round,
    /// [m] distance inside the surface of a particle's shell (ball in which its neighbour list is valid) at which its
    /// exit from the shell is processed. The particle may then fly on by this distance during a round (piece of time in
    /// which several threads process events). Most new shells are made after the round.
    #[serde(skip)]
    slack: f64,
    /// [s] length of the time, after the exit of a particle from its shell (ball in which its neighbour list is valid),
    /// in which touches of the particle are still predicted. It is used while several threads share the events.
    #[serde(skip)]
    grace: f64,
    /// [m/s] speed that no particle may exceed in a round (piece of time in which several threads process events).
    #[serde(skip)]
    speed: f64,
    /// [s] length of a round (piece of time in which several threads process events).
    #[serde(skip)]
    round: f64,
    /// [s] time since the epoch (zero of the event queue's time) at which new shells (balls in which neighbour lists
    /// are valid) were last made between two rounds.
    #[serde(skip)]
    renewed_at: f64,
    /// Number of times that new shells (balls in which neighbour lists are valid) have been made between two rounds
    /// since the particles were divided among the threads.
    #[serde(skip)]
    renewals: u32,
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

/// A window (time between two exchanges with the gas), with its end in simulated time and in the time of the event
/// queue, which is counted from an instant called epoch.
#[derive(Clone, Copy)]
struct CalendarWindow {
    window: Window,
    /// [s] end of the window, counted from the epoch (zero of the event queue's time).
    end: f64,
}

impl CalendarWindow {
    /// Time [s] from the instant `now` to the end of the window; `now` [s] is counted from the epoch (zero of the event
    /// queue's time).
    fn left(&self, now: f64) -> f64 {
        self.end - now
    }

    /// Simulated time [s] at the instant `now` [s], which is counted from the epoch (zero of the event queue's time).
    fn time(&self, now: f64) -> f64 {
        self.window.start + (self.window.duration - self.left(now))
    }
}

impl GlobalCalendar {
    /// Moves all particles through a window, the time between two exchanges with the gas. `outdated` must be true if
    /// islands (groups of particles computed separately) have moved particles since the last call. Collision histories
    /// are then taken from `work.lasting`, which contains recent collisions only.
    ///
    /// # Errors
    /// Inelastic collapse, or velocities that are not finite numbers; `work.particles` then contains the state at the
    /// time of the error.
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
            if self.is_shared(work.scene) {
                self.rounds(work, *span, stop)?;
            } else {
                self.one_after_the_other(work, *span, stop)?;
            }
            if stop >= self.lists_valid_until {
                self.next_interval(work, *span);
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

    /// Processes by one thread all events up to the time `stop` [s] since the epoch (zero of the event queue's time).
    fn one_after_the_other(&mut self, work: &mut Work<Recent>, span: CalendarWindow, stop: f64) -> Result<(), Failure> {
        if !self.parts.is_empty() {
            self.fill_queue();
        }
        loop {
            let before = self.events;
            let around = view_of!(self, work.scene);
            let particles = ParticleAccess::Exclusive(work.particles);
            let mut part = whole_of!(self, &around, particles, work.log, span);
            let leaving = part.run(stop, work.record, before);
            let (now, counts) = (part.now, part.counts);
            self.now = now;
            self.count(counts);
            let Some(index) = leaving? else { return Ok(()) };
            self.renew_shell(index, work, span);
        }
    }

    fn count(&mut self, counts: EventCounts) {
        self.events += counts.collisions;
        self.pair_checks += counts.pair_checks;
    }

    /// Last collision of each particle that collided less than the contact time before simulated time `time` [s]. In
    /// the TC model, a collision so soon after another one is elastic. The list is empty without a contact time.
    pub fn recent(&self, time: f64) -> impl Iterator<Item = Recent> {
        recent(self.last_collisions.iter(), self.contact_time, time)
    }

    /// Number of touch times computed so far, plus the number of computed distances between shells (balls in which
    /// neighbour lists are valid). The sum is a measure of work.
    pub fn pair_checks(&self) -> u64 {
        self.pair_checks
    }

    /// Copy of this event queue of all particles for a snapshot of the run. The copy does not depend on the order in
    /// which neighbour lists were built.
    pub fn state(&self) -> Self {
        let (lists, next_events) = self.shells.copy_lists(&self.lists, &Division::default(), &self.next_events);
        let without = Self { queue: EventQueue::default(), parts: Vec::new(), ..self.clone() };
        Self { lists, next_events, ..without }
    }

    /// Continues from a state that [`state`](Self::state) has returned. The clock and the contact time of this event
    /// queue stay as they are.
    pub fn resume(&mut self, state: Self) {
        let (clock, contact_time) = (self.clock.clone(), self.contact_time);
        *self = Self { clock, contact_time, ..state };
    }
}
