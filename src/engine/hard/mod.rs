//! Hard spheres: collisions are instants.

mod calendar;
mod collapse_detector;
mod cost;
mod events;
mod global_calendar;
mod impulse;
mod islands;
mod steps;

pub use impulse::{Collision, impulse};
pub use steps::SteppedHard;

use super::driver::{Driver, Solver, Trial, Work};
use super::islands::{IslandCounters, SpeedSummary};
use super::population::PopulationSummary;
use super::{Counters, EngineTimes, Failure, Window};
use crate::clock::Clock;
use crate::scene::Scene;
use collapse_detector::Recent;
use global_calendar::GlobalCalendar;
use islands::HardIslands;
use serde::{Deserialize, Serialize};

/// Event-driven hard spheres: within a window, collisions in the order of their exact instants.
///
/// Where few particles meet within a window each island has a small calendar of its own; where most do, one calendar
/// serves them all. Both give the same collisions.
pub type Hard = Driver<HardSolver>;

/// Which way windows are moved.
#[derive(Clone, Copy, PartialEq)]
enum WindowMethod {
    /// The one that costs less.
    Cheaper,
    /// Islands wherever they can be.
    Islands,
    /// One calendar for all.
    OneCalendar,
}

/// Solves islands by small calendars, and everyone by one calendar.
pub struct HardSolver {
    together: GlobalCalendar,
    islands: HardIslands,
    way: WindowMethod,
    memory: Memory,
}

/// What the choice between islands and calendar remembers.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
struct Memory {
    /// Whether islands have moved the particles, or have tried to, since the calendar last did, so that what it knows of them is out of date.
    outdated: bool,
    /// Windows that the calendar that lasts has to itself after islands ran together: one, then two, four, up to [`LONGEST_STAY`].
    stay: u32,
    /// How many of them are left.
    left: u32,
}

/// Longest stay away from islands, in windows: a trial that fails costs the calendar its lists and events, which are made anew.
const LONGEST_STAY: u32 = 64;

/// What the solver keeps from one window to the next.
#[derive(Serialize, Deserialize)]
pub struct HardState {
    together: GlobalCalendar,
    memory: Memory,
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
            together: GlobalCalendar::default(),
            islands: HardIslands::default(),
            way: WindowMethod::Cheaper,
            memory: Memory::default(),
        })
    }

    /// As `new`, but always with one calendar for all: the reference that islands are tested against.
    pub fn with_one_calendar() -> Self {
        let mut engine = Self::new();
        engine.solver.way = WindowMethod::OneCalendar;
        engine
    }

    /// As `new`, but with islands wherever they can be.
    pub fn with_islands() -> Self {
        let mut engine = Self::new();
        engine.solver.way = WindowMethod::Islands;
        engine
    }

    /// With the TC model (Luding and McNamara 1998, Granular Matter 1, 113): a collision that comes sooner than
    /// `contact_time` [s] after the one before of either particle is elastic, so that spheres may come to rest on one
    /// another without colliding infinitely often. Friction acts as ever. `None`: every collision has its restitution.
    pub fn with_contact_time(mut self, contact_time: Option<f64>) -> Self {
        self.solver.together.contact_time = contact_time;
        self.solver.islands.contact_time = contact_time;
        self
    }
}

impl Solver for HardSolver {
    type Islands = HardIslands;
    type State = HardState;

    fn islands(&self) -> &HardIslands {
        &self.islands
    }

    fn fallback_cost(
        &mut self,
        population: &PopulationSummary,
        speeds: &SpeedSummary,
        scene: &Scene,
        window: Window,
    ) -> Option<f64> {
        match self.way {
            WindowMethod::Cheaper if self.memory.left > 0 => {
                self.memory.left -= 1;
                None
            }
            WindowMethod::Cheaper => cost::fallback_cost(population, speeds, scene, window),
            WindowMethod::Islands => Some(f64::INFINITY),
            WindowMethod::OneCalendar => None,
        }
    }

    fn judge(&mut self, _population: &PopulationSummary, scene: &Scene, trial: &Trial) {
        let done = trial.done;
        if cost::lasts(scene) {
            let stay = self.memory.stay;
            self.memory.stay = if done > 0.0 { stay / 2 } else { (2 * stay).clamp(1, LONGEST_STAY) };
            self.memory.left = if done > 0.0 { 0 } else { self.memory.stay };
        }
    }

    fn disturb(&mut self) {
        self.memory.outdated = true;
    }

    /// Nothing is kept: recent collisions are told at the end of each window.
    fn hand_over(&mut self, _lasting: &mut Vec<Recent>) {}

    fn for_each_kept(&self, _visit: &mut dyn FnMut(Recent)) {}

    fn everyone(&mut self, work: &mut Work<Recent>, window: Window) -> Result<(), Failure> {
        let result = self.together.run(work, window, std::mem::take(&mut self.memory.outdated));
        work.lasting.clear();
        work.lasting.extend(self.together.recent(window.start + window.duration));
        result
    }

    fn counters(&self, islands: &IslandCounters) -> Counters {
        Counters {
            events: self.together.events + islands.events,
            pair_checks: self.together.pair_checks() + islands.pair_checks + islands.searched,
            neighbour_builds: self.together.builds + islands.neighbour_builds,
            ..islands.of_all_engines()
        }
    }

    fn forget(&mut self) {
        self.together.forget();
    }

    fn elastic_energy(&self) -> Option<f64> {
        Some(0.0)
    }

    fn use_clock(&mut self, clock: Clock) {
        self.together.clock = clock;
    }

    fn spent(&self, spent: EngineTimes) -> EngineTimes {
        EngineTimes { neighbours: spent.neighbours + self.together.building, ..spent }
    }

    fn state(&self) -> HardState {
        HardState { together: self.together.state(), memory: self.memory }
    }

    fn resume(&mut self, state: HardState) {
        self.together.resume(state.together);
        self.memory = state.memory;
    }
}
