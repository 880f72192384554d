//! Sharing of a run among processes, for all engines that consist of a solver and the common `Driver`. The lead
//! process is process 0. An island is a group of particles that may meet within a window, the time between two
//! exchanges with the gas.

use super::packing::packed_part;
use super::{Distributed, DistributedSolver};
use crate::communicator::Communicator;
use crate::engine::driver::{Driver, Lasting, Work};
use crate::engine::islands::SpeedSummary;
use crate::engine::population::PopulationSummary;
use crate::engine::{Failure, Overlap, Window};
use crate::particles::{Particles, Sample};
use crate::record::{Log, Record};
use crate::scene::Scene;
use std::sync::Arc;

impl<S: DistributedSolver> Driver<S> {
    /// Returns, in all processes, two values of the lead process: the cost [ns/s] of the classical algorithm (all
    /// particles at once, per particle and simulated time), and the summary of the speeds of the particles. The cost
    /// is `None` if islands (groups of particles that may meet) are not to be tried. The arguments are the values of
    /// this process. If the solver limits the cost of an island, it also adopts the limit of the lead process.
    pub(in crate::engine) fn of_lead(
        &mut self,
        fallback_cost: Option<f64>,
        speeds: SpeedSummary,
    ) -> (Option<f64>, SpeedSummary) {
        let Some(domains) = self.islands.processes.domains() else { return (fallback_cost, speeds) };
        let own = self.solver.allowance();
        let (fallback_cost, allowed, speeds) = domains.of_lead((fallback_cost, own.as_deref().copied(), speeds));
        if let (Some(own), Some(allowed)) = (own, allowed) {
            *own = allowed;
        }
        (fallback_cost, speeds)
    }

    /// Moves all particles through the window (time between two exchanges with the gas) by the classical algorithm,
    /// which moves all particles at once. If sharing pays, the processes move the particles together. Otherwise the
    /// lead process (process 0) receives all particles and moves them.
    pub(in crate::engine) fn by_all(&mut self, work: &mut Work<Lasting<S>>, window: Window) -> Result<(), Failure> {
        if let Some(domains) = self.islands.processes.domains() {
            if domains.is_worth_it() && self.solver.shares_steps(work.scene) {
                self.solver.hand_over(work.lasting);
                return self.solver.everyone_together(work, window, domains);
            }
            if domains.is_cut {
                self.solver.hand_over(work.lasting);
                domains.assemble(self.solver.islands(), work, &mut self.islands.members);
            }
            if !domains.is_lead() {
                return Ok(());
            }
        }
        self.solver.advance_all(work, window)
    }

    /// Calls `change` with this engine and its data, in the form in which the data are used during a window (time
    /// between two exchanges with the gas). Impacts and energies that `change` records are discarded.
    fn between_windows(
        &mut self,
        (particles, scene): (&mut Particles, &Scene),
        change: impl FnOnce(&mut Self, &mut Work<Lasting<S>>),
    ) {
        let mut lasting = std::mem::take(&mut self.lasting);
        let (log, record) = (&mut Log::default(), &mut Record::default());
        change(self, &mut Work { particles, scene, lasting: &mut lasting, log, record });
        self.lasting = lasting;
    }
}

impl<S: DistributedSolver> Distributed for Driver<S> {
    fn share(&mut self, communicator: Arc<dyn Communicator>, sample: &Sample, scene: &Scene) {
        let population = PopulationSummary::of(sample, scene);
        self.islands.processes.share(communicator, population, sample.is_part().then_some(&scene.domain));
    }

    fn is_cut(&self) -> bool {
        self.islands.processes.is_cut() && !self.islands.processes.is_shown()
    }

    fn balance(&mut self, particles: &Particles, scene: &Scene) {
        if self.is_cut() {
            self.islands.processes.domains().into_iter().for_each(|domains| domains.balance(particles, &scene.domain));
        }
    }

    fn gather(&mut self, particles: &mut Particles, scene: &Scene, every: u32) {
        if !self.is_cut() {
            return;
        }
        self.between_windows((particles, scene), |engine, work| {
            let together = engine.solver.has_uniform_steps();
            let Some(domains) = engine.islands.processes.domains() else { return };
            domains.gather(engine.solver.islands(), work, &mut engine.islands.members, every);
            if together && every <= 1 {
                engine.solver.gather(work, domains);
            }
        });
    }

    fn scatter(&mut self, particles: &mut Particles) {
        let members = &mut self.islands.members;
        if let Some(domains) = self.islands.processes.domains()
            && domains.scatter(particles, &mut self.lasting, members)
        {
            self.solver.scatter();
        }
    }

    fn gives_parts(&self) -> bool {
        // if processes share the steps, the neighbour list is stored once for all particles
        self.is_cut() && !self.solver.has_uniform_steps()
    }

    fn packed(&self, particles: &Particles) -> Vec<u8> {
        packed_part::<S::Islands>(particles, &self.lasting, self.islands.processes.abroad())
    }

    fn take_parts(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        count: usize,
        next: &mut dyn FnMut(usize) -> Vec<u8>,
    ) {
        self.between_windows((particles, scene), |engine, work| {
            engine.islands.processes.take_parts(engine.solver.islands(), work, count, next);
        });
    }

    fn touching_abroad(&self) -> Vec<(u32, Overlap)> {
        let abroad = if self.is_cut() { self.islands.processes.abroad() } else { &[] };
        let contacts = abroad.iter().filter_map(|abroad| Some((abroad.own, abroad.overlap?)));
        contacts.filter(|(_, overlap)| overlap.depth > 0.0).collect()
    }
}
