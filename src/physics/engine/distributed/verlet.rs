//! Shared uniform steps: each process moves the particles of its block, a part of the box. Process 0 is the lead
//! process.
//!
//! When the neighbour list (the pairs that may touch soon) is built, a process borrows copies of the particles that
//! its own particles may touch before the list is built again. A contact across the border of two blocks is computed
//! in both processes. The two results agree in all bits, because the particles of each process are in the same order
//! as in the list of all particles.
//!
//! After every kick (change of velocities by forces) the processes exchange the largest speed, and tell each other if
//! one of them has failed. If forces acted on a particle that another process borrows, the owner then sends the new
//! velocity to that process.

use super::DistributedSolver;
use super::domains::Domains;
use super::ghost_exchange::GhostExchange;
use super::halo::{Halo, list_of_all, take_kicks, to_bytes};
use crate::communicator::Communicator;
use crate::engine::driver::Work;
use crate::engine::soft::{
    Alike, Contact, ContactSums, Contacts, ForceBuffer, SoftSolver, StepRecord, first_named, kick_all,
};
use crate::engine::{Failure, Window, not_a_number};
use crate::experiment::Integrator;
use crate::neighbours::NeighbourList;
use crate::neighbours::plan::ListSettings;
use crate::neighbours::region::Region;
use crate::particles::Particles;
use crate::record::{Log, Record};
use crate::scene::Scene;
use std::sync::Arc;

/// Data of a process for uniform time steps that several processes share.
#[derive(Default)]
pub struct SharedSteps {
    /// Own particles of this process and its copies of particles of other processes; `None` if processes do not share
    /// the steps.
    pub halo: Option<Halo>,
    /// Total number of entries in the neighbour lists of all processes (pairs, and particles with walls, that may
    /// touch soon), each counted once; `None` if the processes have not shared the building of a list.
    pub slots: Option<usize>,
    /// Neighbour list of all particles and forces that are not yet applied. They are stored only while the lead
    /// process (process 0) has copies of all particles; otherwise `None`.
    pub shown: Option<(NeighbourList, ForceBuffer)>,
}

impl SharedSteps {
    /// For each particle, true if this process owns it; `None` if this process owns all particles.
    pub fn mine(&self) -> Option<&[bool]> {
        self.halo.as_ref().map(|halo| halo.mine.as_slice())
    }
}

/// Exchange of data with other processes within the uniform time steps of one window, the time between two exchanges
/// with the gas.
pub struct OtherProcesses<'a> {
    /// Division of the run among the processes that share it.
    domains: &'a mut Domains<Contact>,
    /// Contacts in progress among the particles of this process.
    lasting: &'a mut Vec<Contact>,
    /// Velocities, and all other quantities that a kick (change of velocities by forces) changes, before the last
    /// kick. They serve to undo the kick.
    before: Particles,
    communicator: Arc<dyn Communicator>,
}

impl<'a> OtherProcesses<'a> {
    fn new(domains: &'a mut Domains<Contact>, lasting: &'a mut Vec<Contact>) -> Self {
        let communicator = domains.communicator();
        Self { domains, lasting, before: Particles::default(), communicator }
    }

    /// Sends the new velocities of own particles to the processes that have copies of them, unless a process has
    /// failed. Also shares the largest speed. `failure` is that of this process, if it failed. Returns the first
    /// failure of any process, or `None` if none has failed.
    fn tell(&self, solver: &mut SoftSolver, particles: &mut Particles, failure: Option<Failure>) -> Option<Failure> {
        let mut largest = [solver.speed.all, f64::from(u8::from(failure.is_some()))];
        self.communicator.largest(&mut largest);
        solver.speed.all = largest[0];
        if largest[1] > 0.0 {
            return self.first(failure);
        }
        let halo = solver.shared.halo.get_or_insert_default();
        halo.mark(&solver.pushes);
        let tell = |rank: usize| halo.lent.get(rank).map_or_else(Vec::new, |lent| halo.pack(lent, particles));
        let outgoing = (0..self.communicator.size()).map(tell).collect();
        for (bytes, borrowed) in self.communicator.exchange(outgoing).iter().zip(&halo.borrowed) {
            take_kicks(bytes, borrowed, particles);
        }
        halo.unmark(&solver.pushes);
        None
    }

    /// Collects the failures of all processes; `failure` is that of this process, if it failed. Returns the failure
    /// that comes first in the order of particle ids, or `None` if no process has failed.
    fn first(&self, failure: Option<Failure>) -> Option<Failure> {
        let all = self.communicator.exchange(vec![to_bytes(&failure); self.communicator.size()]);
        let all = all.iter().filter_map(|bytes| postcard::from_bytes::<Option<Failure>>(bytes).ok().flatten());
        all.fold(None, |first, failure| Some(first_named(first, failure)))
    }

    /// Chooses the settings of the neighbour list, which are equal in all processes. The list will be used every
    /// `between_uses` [s]; `own` contains the particles of this process.
    fn agreed(&self, own: &Particles, scene: &Scene, between_uses: f64) -> ListSettings {
        let sizes = (self.domains.population.count, self.domains.population.mean_radius[0]);
        ListSettings::across_processes(own, sizes, scene, between_uses, &*self.communicator)
    }

    /// Builds the neighbour list again with the settings `plan`; each process lists the neighbours of its own
    /// particles. Particles that have left a block (region of the box) are first sent to the process that owns their
    /// new block.
    fn rebuild_by(&mut self, plan: &ListSettings, solver: &mut SoftSolver, particles: &mut Particles, scene: &Scene) {
        let (mut log, mut record) = (Log::default(), Record::default());
        let mut work = Work { particles, scene, lasting: &mut *self.lasting, log: &mut log, record: &mut record };
        if let Some(halo) = solver.shared.halo.take() {
            *work.lasting = solver.contacts.take(&solver.list);
            self.domains.keep_own(&solver.islands, &mut work, &halo.mine);
        }
        if self.domains.is_cut {
            self.domains.balance(work.particles, &scene.domain);
        } else {
            self.domains.cut(&solver.islands, &mut work);
        }
        work.particles.wrap(&scene.domain);
        let reach = 2.0 * plan.of_all.as_ref().map_or(0.0, |of_all| of_all.range[0]) + plan.skin;
        let (mut halo, names) = Halo::borrow(self.domains, &mut work, reach * (1.0 + 1e-9));
        let order = solver.list.build_by(&Region::from(&scene.domain), work.particles, scene, plan);
        let mut index_of = vec![0u32; order.len()];
        for (index, &from) in order.iter().enumerate() {
            index_of[from as usize] = index as u32;
        }
        halo.follow(&index_of, names);
        solver.list.keep_of(&halo.mine);
        solver.contacts.put(std::mem::take(work.lasting));
        solver.contacts.reorder(&index_of, std::iter::empty(), &solver.list);
        halo.built_at.clone_from(&work.particles.position);
        let pairs = solver.list.pairs.iter().filter(|pair| halo.mine[pair.i as usize]).count();
        let mut slots = [(pairs + solver.list.walls.len()) as i64];
        self.communicator.sum(&mut slots);
        solver.shared.slots = Some(slots[0] as usize);
        solver.shared.halo = Some(halo);
        // recomputed, since the stored particles have changed
        solver.alike = Alike::of(particles, scene, &solver.islands.law);
    }
}

/// Copies the own particles of this process, in the order of the neighbour list.
fn own_of(solver: &SoftSolver, particles: &Particles) -> Particles {
    let mut own = Particles::default();
    match &solver.shared.halo {
        Some(halo) => own.copy_from(particles, &halo.own),
        None => own.clone_from(particles),
    }
    own
}

impl GhostExchange for OtherProcesses<'_> {
    fn is_lead(&self) -> bool {
        self.communicator.is_lead()
    }

    fn largest(&self, values: &mut [f64]) {
        self.communicator.largest(values);
    }

    fn gather(&self, sums: &mut ContactSums) {
        sums.gather(|sums| self.communicator.total(sums));
    }

    fn agree(&self, result: Result<(), Failure>) -> Result<(), Failure> {
        self.first(result.err()).map_or(Ok(()), Err)
    }

    fn not_a_number(&self, solver: &SoftSolver, particles: &Particles, time: f64) -> Failure {
        let own = own_of(solver, particles);
        let wrong = (!own.largest_speed(solver.list.frame()).is_finite()).then(|| not_a_number(&own, time));
        self.first(wrong).unwrap_or_else(|| not_a_number(particles, time))
    }

    fn rebuild(
        &mut self,
        solver: &mut SoftSolver,
        particles: &mut Particles,
        scene: &Scene,
        [between_uses, due]: [f64; 2],
    ) {
        let plan = self.agreed(&own_of(solver, particles), scene, between_uses);
        let mut fastest = plan.largest_speed;
        // forces that remain from the last window are applied before particles move to other processes
        if due > 0.0 {
            fastest = fastest.max(kick_all(&solver.pushes, (particles, None), due, plan.frame));
        }
        solver.pushes.clear();
        self.rebuild_by(&plan, solver, particles, scene);
        solver.speed.all = fastest;
    }

    fn before_kick(&mut self, particles: &Particles) {
        particles.keep_kicked(&mut self.before);
    }

    fn after_kick(
        &mut self,
        solver: &mut SoftSolver,
        particles: &mut Particles,
        forces: Result<(), Failure>,
    ) -> Result<(), Failure> {
        let Some(failure) = self.tell(solver, particles, forces.err()) else { return Ok(()) };
        particles.take_back(&mut self.before);
        Err(failure)
    }
}

impl SoftSolver {
    /// Moves all particles through the window (time between two exchanges with the gas) in uniform time steps that all
    /// processes share.
    fn uniform_together(
        &mut self,
        work: &mut Work<Contact>,
        window: Window,
        domains: &mut Domains<Contact>,
    ) -> Result<(), Failure> {
        // contacts are put into new blocks (ranges of entries of the neighbour list). A new block first tests all of
        // its entries, so `look_anew` need not be called.
        self.ran_last = true;
        work.record.count(&mut work.log.impacts);
        if !domains.is_cut {
            self.start_together(work, domains);
        }
        let mut seen = match &mut self.shared.halo {
            Some(halo) if domains.is_cut => halo.synchronised_view(work.particles, domains),
            _ => std::mem::take(work.particles),
        };
        let before = self.counters;
        let mut others = OtherProcesses::new(domains, work.lasting);
        let mut book = StepRecord { log: work.log, record: Some(work.record) };
        let result = self.uniform(&mut seen, work.scene, window, &mut book, &mut others);
        let mut counts = [
            self.counters.pair_checks - before.pair_checks,
            self.counters.force_evaluations - before.force_evaluations,
        ]
        .map(|count| count as i64);
        domains.count(&mut counts);
        self.counters.pair_checks = before.pair_checks + counts[0] as u64;
        self.counters.force_evaluations = before.force_evaluations + counts[1] as u64;
        match &mut self.shared.halo {
            Some(halo) if domains.is_cut => {
                let contacts = self.contacts.take(&self.list);
                domains.abroad = halo.leave(&seen, &contacts, &self.islands, work);
                self.contacts.put(contacts);
                halo.seen = seen;
            }
            _ => {
                *work.particles = seen;
                *work.lasting =
                    if self.shared.halo.take().is_some() { self.contacts.take(&self.list) } else { Vec::new() };
            }
        }
        result
    }

    /// Begins uniform time steps that all processes share, at a time when the lead process (process 0) stores all
    /// particles.
    ///
    /// If the lead process has a neighbour list in use, the particles are distributed when the list is next built.
    /// Until then the other processes store no particles. Without such a list, the particles are distributed at once.
    fn start_together(&mut self, work: &mut Work<Contact>, domains: &mut Domains<Contact>) {
        let is_in_use = self.has_forces || self.list.allows(0.0);
        let known = (is_in_use && domains.is_lead()).then(|| (self.list.without_pairs(), self.has_forces));
        match domains.of_lead(known) {
            Some((list, has_forces)) => {
                self.has_forces = has_forces;
                if !domains.is_lead() {
                    let clock = std::mem::replace(&mut self.list, list).clock;
                    self.list.clock = clock;
                    self.pushes.clear();
                    self.contacts = Contacts::new(self.islands.law);
                    work.particles.clear();
                    work.lasting.clear();
                }
                self.contacts.put(std::mem::take(work.lasting));
                self.shared.halo = Some(Halo::of_all(work.particles.len()));
            }
            None => {
                self.list.invalidate();
                self.pushes.clear();
                self.has_forces = false;
                domains.cut(&self.islands, work);
                self.shared.halo = None;
            }
        }
    }

    /// Makes, in the lead process (process 0), the joint neighbour list and the joint list of forces that are not yet
    /// applied, for a stored run. Before the call, the lead process must have copies of all particles.
    fn show_all(&mut self, work: &mut Work<Contact>, domains: &Domains<Contact>) {
        let Some(halo) = &self.shared.halo else { return };
        let parts = domains.communicator().collect(halo.packed(&self.pushes));
        if domains.is_lead() {
            self.shared.shown = Some(list_of_all(&parts, &self.list, work));
        }
    }
}

impl DistributedSolver for SoftSolver {
    fn allowance(&mut self) -> Option<&mut f64> {
        Some(&mut self.islands.allowance.each)
    }

    /// True if several processes can share uniform steps. The result is false for Heun's method and for rough walls,
    /// because velocities then change also at times when the processes do not exchange new velocities.
    fn shares_steps(&self, scene: &Scene) -> bool {
        self.integrator == Integrator::VelocityVerlet && !scene.has_rough_walls()
    }

    fn everyone_together(
        &mut self,
        work: &mut Work<Contact>,
        window: Window,
        domains: &mut Domains<Contact>,
    ) -> Result<(), Failure> {
        self.uniform_together(work, window, domains)
    }

    fn has_uniform_steps(&self) -> bool {
        self.shared.halo.is_some()
    }

    fn gather(&mut self, work: &mut Work<Contact>, domains: &Domains<Contact>) {
        self.show_all(work, domains);
    }

    fn scatter(&mut self) {
        self.shared.shown = None;
    }
}
