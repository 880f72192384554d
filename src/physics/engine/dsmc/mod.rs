//! Collisions by chance: direct simulation Monte Carlo (DSMC). Particles fly and meet walls as hard spheres do, and
//! collide with particles of their cell that are chosen at random, at the rate of kinetic theory. A window is the time
//! between two exchanges with the gas.
//!
//! docs/design/dsmc.md explains the scheme, its sources and its limits. Pairs that collide do not touch. Therefore
//! collisions transport no momentum over a distance, and they do not conserve angular momentum.

mod cells;
mod collide;
mod flight;

use super::{Counters, Engine, EngineTimes, Failure, Window, not_a_number};
use crate::clock::Clock;
use crate::noise::{Noise, NoiseUse};
use crate::particles::Particles;
use crate::record::{Log, Record};
use crate::scene::Scene;
use crate::stored::{StoreError, Stored};
use crate::work_sharing;
use cells::{CollisionCells, PIECE, RadiusSummary};
use collide::{CellCollisions, CellMemory, CellState, collide};
use flight::{FlightTime, FlightWalls, fly};
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

pub use crate::experiment::DsmcSettings;

/// Engine in which particles of a cell collide by chance.
///
/// The cells follow from the sizes of the particles and from the scene. They are made anew when the population changes.
pub struct Dsmc {
    settings: DsmcSettings,
    seed: u64,
    state: DsmcState,
    setup: Option<DsmcSetup>,
    times: EngineTimes,
    clock: Clock,
}

/// State of the engine that a snapshot of a run contains.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
struct DsmcState {
    counters: Counters,
    /// [1/s] mean collision rate of a particle, expected at the velocities before the last collisions. If the radii
    /// differ, `rate` is an upper limit. `None` before the first step.
    rate: Option<f64>,
    /// [s] simulated time for which the particles have flown so far, minus that for which collisions have been
    /// computed; negative if the collisions are ahead of the flight.
    owed: f64,
}

/// [m] edges of the cells of a run along the three axes, and mean free path [m] of the particles. Each of the `groups`
/// is a number of particles and their radius [m].
pub fn cells_and_path(scene: &Scene, settings: &DsmcSettings, groups: &[(usize, f64)]) -> (Vector3<f64>, f64) {
    let sizes = RadiusSummary::among(groups);
    let cells = CollisionCells::new(scene, &sizes, settings);
    (cells.edges(), sizes.mean_free_path(scene.room(), settings.enskog))
}

/// Largest number of windows (times between two exchanges with the gas) that share one collision step. The collision
/// rate is known only from the last step, and may change much in more windows.
const MOST_WINDOWS: f64 = 16.0;

/// Data of the engine that follow from the scene and from the sizes of the particles; made at the first window.
struct DsmcSetup {
    sizes: RadiusSummary,
    cells: CollisionCells,
    walls: FlightWalls,
}

impl Dsmc {
    /// Makes an engine whose random collisions follow from the seed `seed`.
    pub fn new(settings: DsmcSettings, seed: u64) -> Self {
        let (times, clock) = (EngineTimes::default(), Clock::default());
        Self { settings, seed, state: DsmcState::default(), setup: None, times, clock }
    }

    /// Makes pairs collide for a time of `duration` [s], and computes the expected collision rate; with 0 s no pair
    /// collides. Does nothing before the cells have been made.
    fn collide(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        duration: f64,
        log: &mut Log,
    ) -> Result<(), NotFinite> {
        let Some(DsmcSetup { sizes, cells, .. }) = &mut self.setup else { return Ok(()) };
        self.clock.time(&mut self.times.neighbours, || cells.sort(particles));
        let crowding = self.settings.enskog.then(|| cells.crowding(particles, sizes));
        let (step, count) = (self.state.counters.steps, cells.open.len());
        let radius = (!sizes.are_mixed()).then_some(sizes.range[1]);
        let in_piece = |(memory, noise): &mut (CellMemory, Noise), piece: usize| {
            let mut collided = CellCollisions::default();
            for cell in piece * PIECE..count.min((piece + 1) * PIECE) {
                let crowding = crowding.as_ref().map(|blocks| blocks[cells.block_of(cell)]);
                let (members, open) = (cells.members(cell), cells.open[cell]);
                let state = CellState { particles, scene, members, open, crowding, radius };
                collide(&state, duration, noise.of(cell as u32), memory, &mut collided);
            }
            // the spheres of a pair do not touch, so a collision transports no momentum over a distance
            collided.log.ledger.pair_virial = Matrix3::zeros();
            collided
        };
        let own = || (CellMemory::default(), Noise::new(self.seed, NoiseUse::Collisions, step));
        let pieces = work_sharing::map_with(0..count.div_ceil(PIECE), own, in_piece);
        let mut rate = 0.0;
        for mut piece in pieces {
            if piece.broken {
                return Err(NotFinite);
            }
            rate += piece.rate;
            self.state.counters.pair_checks += piece.drawn;
            self.state.counters.events += piece.log.impacts.len() as u64;
            for (index, velocity, spin) in piece.changed {
                particles.velocity[index as usize] = velocity;
                if let Some(spins) = &mut particles.spin {
                    spins[index as usize] = spin;
                }
            }
            log.impacts.append(&mut piece.log.impacts);
            log.islands.push(piece.log.ledger.to_array());
        }
        self.state.rate = Some(rate / particles.len().max(1) as f64);
        self.state.counters.neighbour_builds += 1;
        Ok(())
    }

    /// Moves all particles through an interval of time, with their impacts on walls.
    fn fly(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        time: FlightTime,
        log: &mut Log,
    ) -> Result<(), Failure> {
        let Some(DsmcSetup { walls, .. }) = &self.setup else { return Ok(()) };
        let impacts = self.clock.time(&mut self.times.flight, || fly(particles, scene, walls, time, log))?;
        self.state.counters.events += impacts;
        Ok(())
    }

    /// [s] longest step between collisions: a fraction, which the settings give, of the mean time between two
    /// collisions of a particle.
    fn longest_step(&mut self, particles: &mut Particles, scene: &Scene) -> Result<f64, NotFinite> {
        if self.state.rate.is_none() {
            self.collide(particles, scene, 0.0, &mut Log::default())?;
        }
        let longest = self.settings.step / self.state.rate.unwrap_or_default();
        if longest.is_nan() { Err(NotFinite) } else { Ok(longest) }
    }

    /// Moves the particles through a window (time between two exchanges with the gas). If the longest step between
    /// collisions is shorter than two windows, the window is divided into one or more steps. Otherwise several windows
    /// share one collision step.
    fn run(&mut self, particles: &mut Particles, scene: &Scene, window: Window, log: &mut Log) -> Result<(), Failure> {
        let h = window.duration;
        let longest = self.longest_step(particles, scene);
        let Ok(longest) = longest else { return Err(not_a_number(particles, window.start)) };
        let windows = (longest / h).min(MOST_WINDOWS).floor();
        if windows < 2.0 {
            let steps = (h / longest - 1e-9).ceil().max(1.0);
            return self.steps(particles, scene, window, steps as u64, log);
        }
        self.fly(particles, scene, FlightTime { window, start: 0.0, duration: h }, log)?;
        self.state.owed += h;
        // collisions take place in the middle of their step; the term 1e-9 allows for rounding of sums of windows
        if self.state.owed >= (0.5 - 1e-9) * windows * h {
            self.collide_after(particles, scene, windows * h, (window, h), log)?;
        }
        Ok(())
    }

    /// Moves the particles through a window (time between two exchanges with the gas) in `steps` equal steps. Each step
    /// consists of half a flight, the collisions, and another half of a flight.
    fn steps(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        window: Window,
        steps: u64,
        log: &mut Log,
    ) -> Result<(), Failure> {
        let step = window.duration / steps as f64;
        let mut flown = 0.0;
        for k in 0..=steps {
            // the second half of a flight and the first half of the next are one flight
            let to = if k < steps { (k as f64 + 0.5) * step } else { window.duration };
            self.fly(particles, scene, FlightTime { window, start: flown, duration: to - flown }, log)?;
            flown = to;
            self.clock.tell(window.start + flown);
            if k < steps {
                self.state.owed += step;
                self.collide_after(particles, scene, self.state.owed, (window, flown), log)?;
            }
        }
        Ok(())
    }

    /// Makes pairs collide for a time of `duration` [s] after the particles have flown for `flown` [s] of the window.
    /// Does nothing if `duration` is not positive.
    fn collide_after(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        duration: f64,
        (window, flown): (Window, f64),
        log: &mut Log,
    ) -> Result<(), Failure> {
        if duration <= 0.0 {
            return Ok(());
        }
        self.state.owed -= duration;
        self.state.counters.steps += 1;
        let collided = self.collide(particles, scene, duration, log);
        collided.map_err(|NotFinite| not_a_number(particles, window.start + flown))
    }
}

/// Error of the collisions: a velocity is not a number, or too large to compute with.
struct NotFinite;

impl Engine for Dsmc {
    fn advance(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        window: Window,
        record: &mut Record,
    ) -> Result<(), Failure> {
        // the particles of a cell are numbered by id, so that results do not depend on the order of the store
        if !particles.id.is_sorted() {
            particles.sort_by_id();
        }
        if self.setup.is_none() {
            let sizes = RadiusSummary::of(particles);
            let cells = CollisionCells::new(scene, &sizes, &self.settings);
            self.setup = Some(DsmcSetup { sizes, cells, walls: FlightWalls::of(&scene.walls) });
        }
        let mut log = Log::default();
        let result = self.run(particles, scene, window, &mut log);
        record.absorb(&mut log);
        result
    }

    fn forget(&mut self) {
        self.setup = None;
    }

    fn work_done(&self) -> (Counters, EngineTimes) {
        (self.state.counters, self.times)
    }

    fn use_clock(&mut self, clock: Clock) {
        self.clock = clock;
    }

    fn stored(&self) -> Result<Stored, StoreError> {
        Stored::of(&(&self.state, &self.times))
    }

    fn restore(&mut self, stored: &Stored) -> Result<(), StoreError> {
        let (state, times): (DsmcState, EngineTimes) = stored.read()?;
        (self.state, self.times) = (state, times);
        Ok(())
    }

    /// Discards the cells, which follow from the sizes and the number of the particles. They are made anew in the next
    /// window.
    fn repopulate(&mut self, _index_of: &[Option<u32>]) -> f64 {
        self.setup = None;
        0.0
    }
}
