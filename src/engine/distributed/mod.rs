//! Several processes that share one run: each moves the particles of a domain of its own.
//!
//! Engines, islands and uniform steps are written as if a process were alone. They call what is here where processes
//! have to agree or to exchange particles: `Processes` for islands, `GhostExchange` for uniform steps. For a single
//! process neither does anything.

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

/// An engine whose run several processes can share. As long as it pays, each process has the particles of a domain of
/// its own. Otherwise the lead process has all.
///
/// While the run is cut, [`Engine::elastic_energy`] is the energy of all processes, which must all call it.
pub trait Distributed: Engine {
    /// Shares the run with other processes, whose engines are called in the same way.
    ///
    /// If other processes have a part of the sample, each process has the particles of its block, among
    /// [blocks of one size](crate::domain::blocks::Blocks::of_one_size). Otherwise the lead process has all particles,
    /// and only these matter until they are first cut into domains.
    fn share(&mut self, communicator: Arc<dyn Communicator>, sample: &Sample, scene: &Scene);

    /// True if each process has only the particles of a domain of its own.
    fn is_cut(&self) -> bool;

    /// Cuts the run into new domains, from the next window on, if a process has many more particles than others. All
    /// processes must call it, between two windows.
    fn balance(&mut self, particles: &Particles, scene: &Scene);

    /// Shows the lead process, in place of its own particles, copies of those with an id divisible by `every` (1: all)
    /// and of those in contact with them. All processes must call it, between two windows.
    fn show(&mut self, particles: &mut Particles, scene: &Scene, every: u32);

    /// Gives the lead process its own particles back, to continue with.
    fn hide(&mut self, particles: &mut Particles);

    /// True if the state carried between windows can be [`packed`](Self::packed) in parts now. Otherwise the lead
    /// process has to be shown all particles for it.
    fn gives_parts(&self) -> bool;

    /// Packs the particles of this process and their carried state into bytes for [`take_parts`](Self::take_parts),
    /// while the run is cut.
    fn packed(&self, particles: &Particles) -> Vec<u8>;

    /// Replaces all particles and carried state by `count` parts that processes have [`packed`](Self::packed). `next`
    /// gives the lead process, or the only process, one part after the other. All processes must call it.
    fn take_parts(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        count: usize,
        next: &mut dyn FnMut(usize) -> Vec<u8>,
    );

    /// Contacts in progress between a particle of this process, given by index in the store, and one of another
    /// process. Each of the two processes has them.
    fn touching_abroad(&self) -> Vec<(u32, Overlap)>;
}

/// A solver whose run several processes can share. By default they share the islands, and all particles are moved at
/// once by the lead process alone.
pub trait DistributedSolver: Solver {
    /// Largest cost of one island [ns/s], if it changes from window to window; the value of the lead process holds in
    /// all processes.
    fn allowance(&mut self) -> Option<&mut f64> {
        None
    }

    /// True if several processes can share the classical algorithm.
    fn shares_steps(&self) -> bool {
        false
    }

    /// Moves all particles through the window by the classical algorithm, shared by all processes of the run.
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

    /// True if processes have taken the last steps together, and continue with them.
    fn steps_together(&self) -> bool {
        false
    }

    /// Gives the lead process, which has been shown all particles, the state that the processes continue with.
    fn show(&mut self, _work: &mut Work<Lasting<Self>>, _domains: &Domains<Lasting<Self>>) {}

    /// Ends the showing of all particles: each process continues with its own.
    fn hide(&mut self) {}
}

/// State carried between a particle of this process and one of another process.
#[derive(Clone)]
pub struct CrossRankContact<C> {
    /// The carried state, in which ids stand for the particles.
    pub carried: C,
    /// Index of the particle of this process.
    pub own: u32,
    /// Overlap of the two particles at the end of the last part of a window; `None` if they are not in contact.
    pub overlap: Option<Overlap>,
}
