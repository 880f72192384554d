//! Hard spheres: engines in which collisions are instantaneous. An island is a group of particles that may meet within
//! a window, the time between two exchanges with the gas.

mod calendar;
mod collapse_detector;
mod cost;
mod global_calendar;
mod impact_rule;
mod impulse;
mod islands;
mod steps;

pub(super) use collapse_detector::LastCollision;
pub use impulse::{Collision, ParticleAccess, impulse};
pub use steps::SteppedHard;

use super::distributed::DistributedSolver;
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

/// Event-driven hard spheres: collisions are processed in the order of their exact times.
///
/// A window is the time between two exchanges of momentum with the gas. If islands (groups of particles that may meet)
/// take less computing time in a window, each island has a separate small event queue. Otherwise one event queue serves
/// all particles. Both methods give the same collisions.
pub type Hard = Driver<HardSolver>;

/// Method by which the engine moves the particles through each window, the time between two exchanges with the gas.
#[derive(Clone, Copy, PartialEq)]
enum WindowMethod {
    /// In each window, islands (groups of particles that may meet) or one event queue of all particles, whichever has
    /// the lower estimated cost.
    Cheaper,
    /// Islands (groups of particles that may meet, each with an event queue of its own) whenever this is possible.
    Islands,
    /// One event queue for all particles in every window.
    OneCalendar,
}

/// Solver of the event-driven engine. It moves islands (groups of particles that may meet) by small event queues, and
/// all particles at once by one event queue that is kept from window to window.
pub struct HardSolver {
    calendar: GlobalCalendar,
    islands: HardIslands,
    way: WindowMethod,
    memory: Memory,
}

/// Data on earlier windows (times between two exchanges with the gas). With these data the engine decides when to try
/// islands (groups of particles that may meet) again, and when to rebuild the event queue of all particles.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
struct Memory {
    /// True if the event queue of all particles is outdated: since its last use, islands (groups of particles that may
    /// meet) have moved or sorted the particles, or a trial of islands has failed.
    outdated: bool,
    /// Length, in windows, of the pause after a failed trial of islands (groups of particles that may meet); islands
    /// are not tried during the pause. Each failed trial doubles this length, from one up to [`LONGEST_STAY`], and each
    /// successful trial halves it.
    stay: u32,
    /// Number of windows that remain until islands (groups of particles that may meet) are tried again.
    left: u32,
}

/// Largest number of windows in a row in which islands (groups of particles that may meet) are not tried. A failed
/// trial of islands is costly: the neighbour lists and the events of all particles must be computed again.
const LONGEST_STAY: u32 = 64;

/// State of the engine between two windows (times between two exchanges with the gas), as stored in a snapshot of a
/// run.
#[derive(Serialize, Deserialize)]
pub struct HardState {
    calendar: GlobalCalendar,
    memory: Memory,
}

impl Default for Hard {
    fn default() -> Self {
        Self::new()
    }
}

impl Hard {
    /// Makes an engine that chooses between islands (groups of particles that may meet) and one event queue by their
    /// cost. Restitution and friction are those of the scene.
    pub fn new() -> Self {
        Self::with(HardSolver {
            calendar: GlobalCalendar::default(),
            islands: HardIslands::default(),
            way: WindowMethod::Cheaper,
            memory: Memory::default(),
        })
    }

    /// Makes an engine that always uses one event queue for all particles. Tests compare the results of islands (groups
    /// of particles that may meet) with those of this engine.
    pub fn with_one_calendar() -> Self {
        let mut engine = Self::new();
        engine.solver.way = WindowMethod::OneCalendar;
        engine
    }

    /// Makes an engine that uses islands (groups of particles that may meet) whenever possible.
    pub fn with_islands() -> Self {
        let mut engine = Self::new();
        engine.solver.way = WindowMethod::Islands;
        engine
    }

    /// Sets the contact time of the TC model (Luding and McNamara 1998, Granular Matter 1, 113). In this model a
    /// collision is elastic if either particle collided less than `contact_time` [s] before. So spheres may rest on
    /// each other without infinitely many collisions. Friction acts as usual. With `None` every collision has the
    /// restitution of its surfaces.
    pub fn with_contact_time(mut self, contact_time: Option<f64>) -> Self {
        self.solver.calendar.contact_time = contact_time;
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

    /// Does nothing. At the start of a window, the event queue of all particles compares the ids of its particles with
    /// those in the particle store. If the ids differ, the queue is made anew, and keeps the collision histories.
    fn repopulate(&mut self) {}

    /// Does nothing, because the list of recent collisions, `lasting`, is already complete. It is written at the end of
    /// each window in which all particles are moved at once.
    fn hand_over(&mut self, _lasting: &mut Vec<Recent>) {}

    fn for_each_kept(&self, _visit: &mut dyn FnMut(Recent)) {}

    fn advance_all(&mut self, work: &mut Work<Recent>, window: Window) -> Result<(), Failure> {
        let result = self.calendar.run(work, window, std::mem::take(&mut self.memory.outdated));
        work.lasting.clear();
        work.lasting.extend(self.calendar.recent(window.start + window.duration));
        result
    }

    fn counters(&self, islands: &IslandCounters) -> Counters {
        Counters {
            events: self.calendar.events + islands.events,
            pair_checks: self.calendar.pair_checks() + islands.pair_checks + islands.searched,
            neighbour_builds: self.calendar.builds + islands.neighbour_builds,
            ..islands.of_all_engines()
        }
    }

    fn forget(&mut self) {
        self.calendar.forget();
    }

    fn elastic_energy(&self) -> Option<f64> {
        Some(0.0)
    }

    fn use_clock(&mut self, clock: Clock) {
        self.calendar.clock = clock;
    }

    fn spent(&self, spent: EngineTimes) -> EngineTimes {
        EngineTimes { neighbours: spent.neighbours + self.calendar.building, ..spent }
    }

    fn state(&self) -> HardState {
        HardState { calendar: self.calendar.state(), memory: self.memory }
    }

    fn resume(&mut self, state: HardState) {
        self.calendar.resume(state.calendar);
        self.memory = state.memory;
    }
}

impl DistributedSolver for HardSolver {}
