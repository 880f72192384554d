//! Several processes that share one run. Each process moves the particles in its domain, a block of the box. The lead
//! process is process 0. A window is the time between two exchanges with the gas.
//!
//! Engines, islands (groups of particles that may meet) and uniform steps (all particles move by one Δt) are written
//! as for a single process. If processes must decide together or exchange particles, they call the code of this
//! module: `Processes` for islands, `GhostExchange` for uniform steps. For a single process these calls do nothing. A
//! process *owns* the particles in its block. It *borrows* copies of particles of other processes (ghosts).

mod agreement;
mod domains;
mod driver;
mod gathering;
mod ghost_exchange;
mod ghost_islands;
mod halo;
mod packing;
mod processes;
mod staying;
mod verlet;

pub(in crate::engine) use agreement::PartDecision;
pub(in crate::engine) use domains::Domains;
pub(in crate::engine) use ghost_exchange::{GhostExchange, SingleProcess};
pub(in crate::engine) use processes::Processes;
pub(in crate::engine) use verlet::SharedSteps;

use super::driver::{Lasting, Solver, Work};
use super::{Engine, Failure, Overlap, Window};
use crate::communicator::Communicator;
use crate::particles::{Particles, Sample};
use crate::scene::Scene;
use std::sync::Arc;

/// An engine whose run several processes can share. If sharing pays, the run is *cut*: each process owns the particles
/// in its block of the box. Otherwise the lead process (process 0) stores all particles.
///
/// While the run is cut, [`Engine::elastic_energy`] returns the energy of all processes; all processes must call this
/// function.
pub trait Distributed: Engine {
    /// Shares the run with other processes, which must call the engine in the same way.
    ///
    /// If `sample` is divided among the processes, each process must store the particles of its block, among [blocks
    /// of one size](crate::domain::blocks::Blocks::of_one_size). Otherwise the lead process stores all particles.
    /// Particles in the stores of other processes are then ignored until the run is first cut. After that, each
    /// process stores only its own particles.
    fn share(&mut self, communicator: Arc<dyn Communicator>, sample: &Sample, scene: &Scene);

    /// True if each process stores only the particles in its block of the box; false if the lead process (process 0)
    /// stores all particles.
    fn is_cut(&self) -> bool;

    /// Moves the borders of the domains if one process owns many more particles than others. All processes must call
    /// this function, between two windows (times between two exchanges with the gas).
    fn balance(&mut self, particles: &Particles, scene: &Scene);

    /// Replaces the particles of the lead process (process 0) by copies of particles of all processes: those with an
    /// id divisible by `every` (with 1, all particles), and those in contact with them. [`scatter`](Self::scatter)
    /// undoes this. All processes must call this function, between two windows.
    fn gather(&mut self, particles: &mut Particles, scene: &Scene, every: u32);

    /// Restores the own particles of the lead process (process 0), which [`gather`](Self::gather) has replaced by
    /// copies. Does nothing if `gather` was not called before.
    fn scatter(&mut self, particles: &mut Particles);

    /// True if each process can store its own share of the state of the run by [`packed`](Self::packed). If false, all
    /// particles must first be copied to the lead process (process 0), which then stores the state.
    fn gives_parts(&self) -> bool;

    /// Packs the particles of this process and their contacts in progress into bytes, for storing.
    /// [`take_parts`](Self::take_parts) reads these bytes. The function is used while each process stores only its own
    /// particles.
    fn packed(&self, particles: &Particles) -> Vec<u8>;

    /// Replaces all particles and contacts in progress by those of a stored run, which consists of `count` parts
    /// (shares of its particles), packed by [`packed`](Self::packed). In the lead process (process 0), and in a run
    /// with a single process, `next` returns the part with a given number. All processes must call this function.
    fn take_parts(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        count: usize,
        next: &mut dyn FnMut(usize) -> Vec<u8>,
    );

    /// Contacts in progress between a particle of this process and one of another process: the index of the particle of
    /// this process, and the overlap. Both processes return the contact. Contacts without overlap, or whose overlap is
    /// not yet known, are left out.
    fn touching_abroad(&self) -> Vec<(u32, Overlap)>;
}

/// A solver whose run several processes can share. By default processes share only the islands (groups of particles
/// that may meet). The lead process (process 0) alone moves all particles at once by the classical algorithm (uniform
/// steps, or one event queue).
pub trait DistributedSolver: Solver {
    /// Limit of the cost (computing time per simulated time) [ns/s] of a single island (group of particles that may
    /// meet). `None` if the solver does not adapt this limit after each window, the time between two exchanges with
    /// the gas. All processes adopt the value of the lead process (process 0).
    fn allowance(&mut self) -> Option<&mut f64> {
        None
    }

    /// True if several processes can share the classical algorithm, which moves all particles of a scene at once.
    fn shares_steps(&self, _scene: &Scene) -> bool {
        false
    }

    /// Moves all particles at once through the window, the time between two exchanges with the gas, by the classical
    /// algorithm. All processes of the run share the work.
    ///
    /// # Errors
    /// The classical algorithm fails. All processes return the same error.
    fn everyone_together(
        &mut self,
        work: &mut Work<Lasting<Self>>,
        window: Window,
        _domains: &mut Domains<Lasting<Self>>,
    ) -> Result<(), Failure> {
        self.advance_all(work, window)
    }

    /// True if the processes shared the last uniform time steps and still have the data with which they can continue
    /// these steps.
    fn has_uniform_steps(&self) -> bool {
        false
    }

    /// Stores in the lead process (process 0) the joint neighbour list and the joint forces of all processes. They
    /// become part of a stored run. Before the call, copies of all particles must be in the lead process.
    fn gather(&mut self, _work: &mut Work<Lasting<Self>>, _domains: &Domains<Lasting<Self>>) {}

    /// Removes the joint data that [`gather`](Self::gather) has stored in the lead process (process 0).
    fn scatter(&mut self) {}
}

/// A contact in progress between a particle of this process and one of another process.
#[derive(Clone)]
pub struct CrossRankContact<C> {
    /// The contact, with ids of particles instead of indices, since this process need not store the other particle.
    pub carried: C,
    /// Index, in the store of this process, of the particle that this process owns.
    pub own: u32,
    /// Overlap of the two bodies at the end of the last interval of motion; the overlap is negative if the bodies are
    /// apart. `None` if another process has sent the contact since then, so that the overlap is not yet known.
    pub overlap: Option<Overlap>,
}
