//! Several processes that share one run. Each process moves the particles in its domain, a block of the box.
//!
//! Engines, islands and uniform steps are written as for a single process. Where processes must decide together or
//! exchange particles, the code of this module is called: `Processes` for islands, `GhostExchange` for uniform steps.
//! For a single process these calls do nothing. A process *owns* the particles in its block. It *borrows* copies of
//! particles of other processes (ghosts).

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
/// of its domain. Otherwise the lead process stores all particles.
///
/// While the run is cut, [`Engine::elastic_energy`] returns the energy of all processes, which must all call it.
pub trait Distributed: Engine {
    /// Shares the run with other processes, in which the engine is called with equal arguments.
    ///
    /// If `sample` is divided among the processes, each process must store the particles of its block, among [blocks of
    /// one size](crate::domain::blocks::Blocks::of_one_size). Otherwise the lead process stores all particles.
    /// Particles of other processes are then ignored until the run is first cut.
    fn share(&mut self, communicator: Arc<dyn Communicator>, sample: &Sample, scene: &Scene);

    /// True if the run is cut: each process stores only the particles of its domain.
    fn is_cut(&self) -> bool;

    /// Changes the domains from the next time window on, if one process owns many more particles than others. All
    /// processes must call this function, between two windows.
    fn balance(&mut self, particles: &Particles, scene: &Scene);

    /// Replaces the particles of the lead process by copies of particles of all processes: those with an id divisible
    /// by `every` (1: all), and those in contact with them. All processes must call this function, between two time
    /// windows.
    fn show(&mut self, particles: &mut Particles, scene: &Scene, every: u32);

    /// Restores the own particles of the lead process, which [`show`](Self::show) has replaced. The run then continues
    /// with them.
    fn hide(&mut self, particles: &mut Particles);

    /// True if each process can now store its carried state (such as contacts) by [`packed`](Self::packed). Otherwise
    /// all particles must first be copied to the lead process, which then stores the state.
    fn gives_parts(&self) -> bool;

    /// Packs the particles of this process and their carried state (such as contacts) into bytes for
    /// [`take_parts`](Self::take_parts), while the run is cut.
    fn packed(&self, particles: &Particles) -> Vec<u8>;

    /// Replaces all particles and carried state (such as contacts) by `count` parts of a stored run, which processes
    /// have packed by [`packed`](Self::packed). `next` returns the parts one by one to the lead process, or to the only
    /// process. All processes must call this function.
    fn take_parts(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        count: usize,
        next: &mut dyn FnMut(usize) -> Vec<u8>,
    );

    /// Contacts in progress between a particle of this process, given by index in the particle store, and a particle of
    /// another process. Each of the two processes returns the contact.
    fn touching_abroad(&self) -> Vec<(u32, Overlap)>;
}

/// A solver whose run several processes can share. By default processes share only the islands (groups of particles
/// that may meet), and the lead process alone moves all particles by the classical algorithm.
pub trait DistributedSolver: Solver {
    /// Limit of the cost of one island (group of particles that may meet) [ns/s], if it changes from window to window.
    /// All processes use the value of the lead process.
    fn allowance(&mut self) -> Option<&mut f64> {
        None
    }

    /// True if several processes can share the classical algorithm (all particles at once).
    fn shares_steps(&self) -> bool {
        false
    }

    /// Moves all particles through the window by the classical algorithm, which all processes of the run share.
    ///
    /// # Errors
    /// Errors of the classical algorithm, equal in all processes.
    fn everyone_together(
        &mut self,
        work: &mut Work<Lasting<Self>>,
        window: Window,
        _domains: &mut Domains<Lasting<Self>>,
    ) -> Result<(), Failure> {
        self.everyone(work, window)
    }

    /// True if the processes shared the last uniform steps, and will continue to share them.
    fn steps_together(&self) -> bool {
        false
    }

    /// Stores in the lead process, which has copies of all particles, the joint state with which the processes
    /// continue.
    fn show(&mut self, _work: &mut Work<Lasting<Self>>, _domains: &Domains<Lasting<Self>>) {}

    /// Removes the joint state from the lead process, before each process continues with its own particles.
    fn hide(&mut self) {}
}

/// Carried state (such as a contact) between a particle of this process and one of another process.
#[derive(Clone)]
pub struct CrossRankContact<C> {
    /// The carried state (such as contacts), which contains ids of particles instead of indices.
    pub carried: C,
    /// Index in the particle store of the particle of this process.
    pub own: u32,
    /// Overlap of the two bodies at the end of the last part of a time window; `None` if they are not in contact.
    pub overlap: Option<Overlap>,
}
