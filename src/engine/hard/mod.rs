//! Hard spheres: collisions are instants.

mod calendar;
mod cost;
mod events;
mod impulse;
mod islands;
mod steps;

pub use impulse::{Collision, Other, impulse};
pub use steps::SteppedHard;

use super::islands::Islands;
use super::motion::{accelerate, drift};
use super::{Counters, Engine, Failure, Spent, Window};
use crate::clock::Clock;
use crate::neighbours::along_walls;
use crate::particles::Particles;
use crate::record::{Log, Record};
use crate::scene::Scene;
use events::{EventLoop, Limit};
use islands::HardIslands;
use nalgebra::Vector3;

/// Event-driven hard spheres: within a window, collisions in the order of their exact instants.
///
/// Where few particles meet within a window each island has a small calendar of its own; where most do, one calendar
/// serves them all. Both give the same collisions.
pub struct Hard {
    events: EventLoop,
    islands: Islands<HardIslands>,
    /// Whether one calendar for all does everything.
    together_only: bool,
    /// Ids by place as the calendar for all last left them: whose history it keeps where.
    left: Vec<u32>,
    /// Whether islands have moved the particles since then, so that the calendar's history is out of date.
    outdated: bool,
    log: Log,
    counters: Counters,
}

impl Default for Hard {
    fn default() -> Self {
        Self::new()
    }
}

impl Hard {
    /// An engine without settings: restitution and friction are the scene's.
    pub fn new() -> Self {
        Self {
            events: EventLoop::default(),
            islands: Islands::new(HardIslands::default()),
            together_only: false,
            left: Vec::new(),
            outdated: false,
            log: Log::default(),
            counters: Counters::default(),
        }
    }

    /// As `new`, but always with one calendar for all: the reference that islands are tested against.
    pub fn with_one_calendar() -> Self {
        Self { together_only: true, ..Self::new() }
    }

    /// With the TC model (Luding and McNamara 1998, Granular Matter 1, 113): a collision that comes sooner than
    /// `contact_time` [s] after the one before of either particle is elastic, so that spheres may come to rest on one
    /// another without colliding infinitely often. Friction acts as ever. `None`: every collision has its restitution.
    pub fn with_contact_time(mut self, contact_time: Option<f64>) -> Self {
        self.events.contact_time = contact_time;
        self.islands.solver.contact_time = contact_time;
        self
    }

    fn rebuild(&mut self, particles: &mut Particles, scene: &Scene, between_uses: f64) {
        let order = self.events.list.build(particles, scene, between_uses);
        self.events.adopt_reordered(&order);
        let reach = 2.0 * particles.radius.iter().fold(0.0, |a: f64, &r| a.max(r));
        self.events.far_images = std::array::from_fn(|axis| {
            scene.domain.periodic[axis] && 0.5 * scene.domain.size[axis] - reach < self.events.list.skin()
        });
    }

    /// Brings what the calendar for all knows of earlier collisions up to date with what the islands have done since it last ran.
    /// Particles that they have moved keep the instant of their last collision if it still matters. Particles that they have
    /// only put in another order, before they gave up, keep all of their history: the signs of a collapse as well.
    fn catch_up(&mut self, particles: &Particles) {
        if self.outdated {
            self.events.forget_but(particles.len(), &self.islands.carried);
        } else if self.left.len() == particles.len() && self.left != particles.id {
            self.events.follow(&self.left, &particles.id);
        }
        self.outdated = false;
    }

    /// One calendar for all, in as many parts as the neighbour list needs.
    fn together(&mut self, particles: &mut Particles, scene: &Scene, window: Window) -> Result<(), Failure> {
        let fall = (scene.gravity - along_walls(scene, scene.gravity)).norm();
        let periods = (0..3).filter(|axis| scene.domain.periodic[*axis]).map(|axis| scene.domain.size[axis]);
        let period = periods.fold(f64::INFINITY, f64::min);
        let mut done = 0.0;
        self.events.clear_counts();
        while done < window.duration {
            let rest = window.duration - done;
            let speed = |events: &EventLoop, p: &Particles| p.largest_speed(events.list.frame()) + fall * rest;
            // within a part no pair moves more than half a period: the nearest image and the next are all it can meet
            let part = |speed: f64| if speed > 0.0 { rest.min(0.25 * period / speed) } else { rest };
            let mut fastest = speed(&self.events, particles);
            if !fastest.is_finite() {
                return Err(super::not_a_number(particles, window.start + done));
            }
            if !self.events.list.allows(fastest * part(fastest)) {
                self.rebuild(particles, scene, part(fastest));
                fastest = speed(&self.events, particles);
            }
            let left = part(fastest);
            let list = &self.events.list;
            // all that has moved so far has moved within the bound; what is faster from here on may not
            let limit = Skin { frame: list.frame(), speed: list.room() / left - fall * left };
            let stretch = Window { start: window.start + done, duration: rest };
            let (reached, result) = self.events.run(particles, scene, stretch, left, &limit, &mut self.log);
            drift(particles, reached, scene.gravity * (0.5 * reached * reached));
            accelerate(particles, scene.gravity * reached);
            self.events.list.travel(fastest * left);
            result?;
            done = if reached < rest { done + reached } else { window.duration };
        }
        Ok(())
    }
}

/// What the skin of the neighbour list leaves room for.
struct Skin {
    frame: Vector3<f64>,
    /// [m/s] relative to the frame.
    speed: f64,
}

impl Limit for Skin {
    fn allows(&self, _place: usize, velocity: &Vector3<f64>) -> bool {
        (velocity - self.frame).norm() <= self.speed
    }
}

impl Engine for Hard {
    fn advance(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        window: Window,
        record: &mut Record,
    ) -> Result<(), Failure> {
        let searches = self.islands.counters().neighbour_builds;
        let rival = if self.together_only { 0.0 } else { cost::rival(particles, scene, window) };
        let moved = self.islands.advance(particles, scene, window, rival, &mut self.log);
        if self.islands.counters().neighbour_builds != searches {
            // the islands have moved the particles under the list, or put them in another order even if they then gave up
            self.events.list.invalidate();
        }
        let result = moved.and_then(|done| {
            self.outdated |= done > 0.0;
            if done >= window.duration {
                return Ok(());
            }
            self.catch_up(particles);
            let rest = Window { start: window.start + done, duration: window.duration - done };
            let result = self.together(particles, scene, rest);
            self.islands.carried.clear();
            self.islands.carried.extend(self.events.recent(particles.len(), window.start + window.duration));
            self.left.clone_from(&particles.id);
            result
        });
        record.absorb(&mut self.log);
        let islands = self.islands.counters();
        self.counters.islands = islands.islands;
        self.counters.island_members = islands.members;
        self.counters.largest_island = islands.largest;
        self.counters.islands_redone = islands.redone;
        self.counters.events = self.events.events + islands.events;
        self.counters.pair_checks = self.events.pair_checks + islands.pair_checks;
        self.counters.neighbour_builds = self.events.list.builds() + islands.neighbour_builds;
        result
    }

    fn counters(&self) -> Counters {
        self.counters
    }

    fn elastic_energy(&self) -> f64 {
        0.0
    }

    fn use_clock(&mut self, clock: Clock) {
        self.islands.clock = clock;
        self.events.list.clock = clock;
    }

    fn spent(&self) -> Spent {
        self.islands.spent.with_list(&self.events.list)
    }
}
