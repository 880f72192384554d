//! Hard spheres: collisions are instants.

mod calendar;
mod cost;
mod events;
mod impulse;
mod islands;
mod steps;

pub use impulse::{Collision, impulse};
pub use steps::SteppedHard;

use super::driver::{Driver, Solver, Work};
use super::islands::IslandCounters;
use super::motion::{accelerate, drift};
use super::{Counters, Failure, Spent, Window};
use crate::clock::Clock;
use crate::neighbours::along_walls;
use crate::particles::Particles;
use crate::scene::Scene;
use events::{EventLoop, Limit, Part, Recent};
use islands::HardIslands;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Event-driven hard spheres: within a window, collisions in the order of their exact instants.
///
/// Where few particles meet within a window each island has a small calendar of its own; where most do, one calendar
/// serves them all. Both give the same collisions.
pub type Hard = Driver<HardSolver>;

/// Solves islands by small calendars, and everyone by one calendar.
pub struct HardSolver {
    events: EventLoop,
    islands: HardIslands,
    /// Whether one calendar for all does everything.
    together_only: bool,
    /// Ids by place as the calendar for all last left them: whose history it keeps where.
    left: Vec<u32>,
    /// Whether islands have moved the particles since then, so that the calendar's history is out of date.
    outdated: bool,
}

/// What the solver keeps from one window to the next.
#[derive(Serialize, Deserialize)]
pub struct HardState {
    events: EventLoop,
    left: Vec<u32>,
    outdated: bool,
}

impl Default for Hard {
    fn default() -> Self {
        Self::new()
    }
}

impl Hard {
    /// An engine without settings: restitution and friction are the scene's.
    pub fn new() -> Self {
        Self::with(HardSolver {
            events: EventLoop::default(),
            islands: HardIslands::default(),
            together_only: false,
            left: Vec::new(),
            outdated: false,
        })
    }

    /// As `new`, but always with one calendar for all: the reference that islands are tested against.
    pub fn with_one_calendar() -> Self {
        let mut engine = Self::new();
        engine.solver.together_only = true;
        engine
    }

    /// With the TC model (Luding and McNamara 1998, Granular Matter 1, 113): a collision that comes sooner than
    /// `contact_time` [s] after the one before of either particle is elastic, so that spheres may come to rest on one
    /// another without colliding infinitely often. Friction acts as ever. `None`: every collision has its restitution.
    pub fn with_contact_time(mut self, contact_time: Option<f64>) -> Self {
        self.solver.events.contact_time = contact_time;
        self.solver.islands.contact_time = contact_time;
        self
    }
}

impl HardSolver {
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
    fn catch_up(&mut self, particles: &Particles, recent: &[Recent]) {
        if self.outdated {
            self.events.forget_but(particles.len(), recent);
        } else if self.left.len() == particles.len() && self.left != particles.id {
            self.events.follow(&self.left, &particles.id);
        }
        self.outdated = false;
    }

    /// One calendar for all, in as many parts as the neighbour list needs.
    fn together(&mut self, work: &mut Work<Recent>, window: Window) -> Result<(), Failure> {
        let Work { particles, scene, log, .. } = work;
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
            let part = Part { window: Window { start: window.start + done, duration: rest }, end: left };
            let (reached, result) = self.events.run(particles, scene, part, &limit, log);
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

impl Solver for HardSolver {
    type Islands = HardIslands;
    type State = HardState;

    fn islands(&self) -> &HardIslands {
        &self.islands
    }

    fn rival(&mut self, particles: &Particles, scene: &Scene, window: Window) -> Option<f64> {
        (!self.together_only).then(|| cost::rival(particles, scene, window))
    }

    fn disturb(&mut self, moved: bool) {
        self.events.list.invalidate();
        self.outdated |= moved;
    }

    fn everyone(&mut self, work: &mut Work<Recent>, window: Window) -> Result<(), Failure> {
        self.catch_up(work.particles, work.lasting);
        let result = self.together(work, window);
        work.lasting.clear();
        work.lasting.extend(self.events.recent(work.particles.len(), window.start + window.duration));
        self.left.clone_from(&work.particles.id);
        result
    }

    fn counters(&self, islands: &IslandCounters) -> Counters {
        Counters {
            events: self.events.events + islands.events,
            pair_checks: self.events.pair_checks + islands.pair_checks,
            neighbour_builds: self.events.list.builds() + islands.neighbour_builds,
            ..islands.of_all_engines()
        }
    }

    fn elastic_energy(&self) -> Option<f64> {
        Some(0.0)
    }

    fn use_clock(&mut self, clock: Clock) {
        self.events.list.clock = clock;
    }

    fn spent(&self, spent: Spent) -> Spent {
        spent.with_list(&self.events.list)
    }

    fn state(&self) -> HardState {
        HardState { events: self.events.clone(), left: self.left.clone(), outdated: self.outdated }
    }

    fn resume(&mut self, state: HardState) {
        let HardState { events, left, outdated } = state;
        self.events.resume(events);
        (self.left, self.outdated) = (left, outdated);
    }
}
