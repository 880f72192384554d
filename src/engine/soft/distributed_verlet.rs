//! Uniform steps of a run that is cut into domains: each process moves the particles of its block.
//!
//! When the neighbour list is built, a process borrows ghost particles: those that its own particles may touch as long
//! as the list lasts. Forces of contacts across a border are computed by both processes. They agree in all bits,
//! because parts of the list keep the order of the list of all particles.
//!
//! After every kick all processes agree on the largest speed and on whether anything failed. Then the new velocities of
//! lent particles that were pushed are sent to the borrowers.

use super::block::first_named;
use super::contact::Alike;
use super::contacts::{EvaluationTime, StepRecord};
use super::ghost_exchange::GhostExchange;
use super::halo::{Halo, take_kicks, to_bytes};
use super::pushes::kick_all;
use super::{Contact, SoftSolver};
use crate::communicator::Communicator;
use crate::engine::driver::{CrossRankContact, Work};
use crate::engine::islands::Domains;
use crate::engine::{Failure, Window, not_a_number};
use crate::neighbours::plan::ListSettings;
use crate::neighbours::region::Region;
use crate::particles::Particles;
use crate::record::{Log, Record};
use crate::scene::Scene;
use std::sync::Arc;

/// Ghost exchange with the other processes.
pub struct OtherProcesses<'a> {
    /// Assignment of blocks to processes.
    pub domains: &'a mut Domains,
    /// Contacts among the particles of this process.
    pub lasting: &'a mut Vec<Contact>,
    /// Contacts between a particle of this process and one of another process.
    pub abroad: &'a mut Vec<CrossRankContact<Contact>>,
    /// State before the last kick, of all data that a kick changes.
    before: Particles,
    communicator: Arc<dyn Communicator>,
}

impl<'a> OtherProcesses<'a> {
    fn new(
        domains: &'a mut Domains,
        lasting: &'a mut Vec<Contact>,
        abroad: &'a mut Vec<CrossRankContact<Contact>>,
    ) -> Self {
        let communicator = domains.communicator();
        Self { domains, lasting, abroad, before: Particles::default(), communicator }
    }

    /// Sends the new velocities of lent particles to the borrowers, or reports a failure. Returns the first failure of
    /// any process.
    fn tell(&self, solver: &mut SoftSolver, particles: &mut Particles, failure: Option<Failure>) -> Option<Failure> {
        let mut largest = [solver.speed.all, f64::from(u8::from(failure.is_some()))];
        self.communicator.largest(&mut largest);
        solver.speed.all = largest[0];
        if largest[1] > 0.0 {
            return self.first(failure);
        }
        let halo = solver.halo.get_or_insert_default();
        halo.mark(&solver.pushes);
        let tell = |rank: usize| halo.lent.get(rank).map_or_else(Vec::new, |lent| halo.pack(lent, particles));
        let outgoing = (0..self.communicator.size()).map(tell).collect();
        for (bytes, borrowed) in self.communicator.exchange(outgoing).iter().zip(&halo.borrowed) {
            take_kicks(bytes, borrowed, particles);
        }
        halo.unmark(&solver.pushes);
        None
    }

    /// First failure of any process, in the order of ids.
    fn first(&self, failure: Option<Failure>) -> Option<Failure> {
        let all = self.communicator.exchange(vec![to_bytes(&failure); self.communicator.size()]);
        let all = all.iter().filter_map(|bytes| postcard::from_bytes::<Option<Failure>>(bytes).ok().flatten());
        all.fold(None, |first, failure| Some(first_named(first, failure)))
    }

    /// Rebuilds the list of all particles, each process its part, by a `known` plan or for uses `between_uses` [s]
    /// apart. Particles that have left a block go to the process of their new block.
    fn rebuild_by(
        &mut self,
        solver: &mut SoftSolver,
        particles: &mut Particles,
        scene: &Scene,
        (known, between_uses): (Option<ListSettings>, f64),
    ) {
        let (mut log, mut record) = (Log::default(), Record::default());
        let (lasting, abroad) = (&mut *self.lasting, &mut *self.abroad);
        let mut work = Work { particles, scene, lasting, abroad, log: &mut log, record: &mut record };
        if let Some(halo) = solver.halo.take() {
            *work.lasting = solver.contacts.take(&solver.list);
            self.domains.keep_own(&solver.islands, &mut work, &halo.mine);
        }
        let plan = known.unwrap_or_else(|| agreed(self.domains, work.particles, scene, between_uses));
        if self.domains.is_cut {
            self.domains.balance(work.particles, &scene.domain);
        } else {
            self.domains.cut(&solver.islands, &mut work);
        }
        work.particles.wrap(&scene.domain);
        let reach = 2.0 * plan.everyone.as_ref().map_or(0.0, |everyone| everyone.range[0]) + plan.skin;
        let (mut halo, names) = Halo::borrow(self.domains, &mut work, reach * (1.0 + 1e-9));
        let order = solver.list.build_by(&Region::from(&scene.domain), work.particles, scene, &plan);
        let mut place_of = vec![0u32; order.len()];
        for (place, &from) in order.iter().enumerate() {
            place_of[from as usize] = place as u32;
        }
        halo.follow(&place_of, names);
        solver.list.keep_of(&halo.mine);
        solver.contacts.put(std::mem::take(work.lasting));
        solver.contacts.reorder(&place_of, std::iter::empty(), &solver.list);
        halo.built_at.clone_from(&work.particles.position);
        let pairs = solver.list.pairs.iter().filter(|pair| halo.mine[pair.i as usize]).count();
        let mut slots = [(pairs + solver.list.walls.len()) as i64];
        self.communicator.sum(&mut slots);
        solver.slots_of_all = Some(slots[0] as usize);
        solver.speed.all = plan.largest_speed;
        solver.halo = Some(halo);
        // the process sees other particles than before
        solver.alike = Alike::of(particles, scene, &solver.islands.law);
    }
}

/// Settings of the list of all particles, agreed by all processes, for uses that are `between_uses` [s] apart.
fn agreed(domains: &Domains, own: &Particles, scene: &Scene, between_uses: f64) -> ListSettings {
    let sizes = (domains.population.count, domains.population.mean_radius[0]);
    ListSettings::together(own, sizes, scene, between_uses, &*domains.communicator())
}

impl GhostExchange for OtherProcesses<'_> {
    fn begin(
        &mut self,
        solver: &mut SoftSolver,
        particles: &mut Particles,
        scene: &Scene,
        (window, dt): (Window, f64),
    ) -> Result<(), Failure> {
        let mut own = Particles::default();
        match &solver.halo {
            Some(halo) => own.copy_from(particles, &halo.own),
            None => own.clone_from(particles),
        }
        let least = own.radius.iter().fold(f64::INFINITY, |a: f64, &r| a.min(r));
        let mut largest = [own.largest_speed(solver.list.frame()), -least];
        self.communicator.largest(&mut largest);
        solver.speed.all = largest[0];
        solver.smallest = SoftSolver::has_thin_walls(scene).then_some(-largest[1]);
        if !solver.speed.all.is_finite() {
            let wrong = (!own.largest_speed(solver.list.frame()).is_finite()).then(|| not_a_number(&own, window.start));
            return Err(self.first(wrong).unwrap_or_else(|| not_a_number(particles, window.start)));
        }
        if !solver.list.allows(2.0 * solver.speed.all * dt) {
            let plan = agreed(self.domains, &own, scene, 2.0 * dt);
            let mut speed = super::Fastest { all: plan.largest_speed, ..solver.speed };
            // the half-kick that is due from the last window comes before particles change process
            if solver.has_forces {
                speed.rise(kick_all(&solver.pushes, (particles, None), 0.5 * dt, plan.frame));
            }
            solver.pushes.clear();
            self.rebuild_by(solver, particles, scene, (Some(plan), 2.0 * dt));
            solver.speed.all = speed.all;
        }
        Ok(())
    }

    fn rebuild(&mut self, solver: &mut SoftSolver, particles: &mut Particles, scene: &Scene, between_uses: f64) {
        self.rebuild_by(solver, particles, scene, (None, between_uses));
    }

    fn agree(&mut self, result: Result<(), Failure>) -> Result<(), Failure> {
        self.first(result.err()).map_or(Ok(()), Err)
    }

    fn forces(
        &mut self,
        solver: &mut SoftSolver,
        particles: &Particles,
        scene: &Scene,
        at: EvaluationTime,
        book: &mut StepRecord,
    ) -> Result<(), Failure> {
        let found = solver.evaluate(particles, scene, at, book);
        self.agree(found)?;
        solver.contacts.count(at, Some(&*self.communicator));
        solver.leave_own_pushes();
        Ok(())
    }

    fn kick(&mut self, solver: &mut SoftSolver, particles: &mut Particles, dt: f64) {
        solver.kick(particles, dt);
        self.tell(solver, particles, None);
    }

    fn step(
        &mut self,
        solver: &mut SoftSolver,
        particles: &mut Particles,
        scene: &Scene,
        at: EvaluationTime,
        book: &mut StepRecord,
    ) -> Result<(), Failure> {
        let found = solver.evaluate(particles, scene, at, book);
        let is_well = found.is_ok();
        particles.keep_kicked(&mut self.before);
        if is_well {
            solver.leave_own_pushes();
            solver.kick(particles, at.weight * at.dt);
        }
        if let Some(failure) = self.tell(solver, particles, found.err()) {
            particles.take_back(&mut self.before);
            return Err(failure);
        }
        solver.contacts.count(at, Some(&*self.communicator));
        Ok(())
    }

    fn communicator(&self) -> Option<&dyn Communicator> {
        Some(&*self.communicator)
    }
}

impl SoftSolver {
    /// Keeps the pushes on particles of this process; the other processes apply all others.
    fn leave_own_pushes(&mut self) {
        if let Some(halo) = &self.halo {
            self.pushes.iter_mut().for_each(|pushes| pushes.leave(&halo.mine));
        }
    }

    /// Moves all particles through the window, shared by all processes.
    pub(super) fn uniform_together(
        &mut self,
        work: &mut Work<Contact>,
        window: Window,
        domains: &mut Domains,
    ) -> Result<(), Failure> {
        self.ran_last = true;
        work.record.count(&mut work.log.impacts);
        if !domains.is_cut {
            self.start_together(work, domains);
        }
        let mut seen = match &mut self.halo {
            Some(halo) if domains.is_cut => halo.look(work.particles, domains),
            _ => std::mem::take(work.particles),
        };
        let before = self.counters;
        let mut others = OtherProcesses::new(domains, work.lasting, work.abroad);
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
        match &mut self.halo {
            Some(halo) if domains.is_cut => {
                let contacts = self.contacts.take(&self.list);
                halo.leave(&seen, &contacts, &self.islands, work);
                self.contacts.put(contacts);
                halo.seen = seen;
            }
            _ => {
                *work.particles = seen;
                *work.lasting = if self.halo.take().is_some() { self.contacts.take(&self.list) } else { Vec::new() };
            }
        }
        result
    }

    /// Starts shared steps when the lead has all particles.
    ///
    /// The particles are distributed over the processes now, unless the lead has a list in use. Then they are
    /// distributed when the list is next built, and until then the other processes have no particles.
    fn start_together(&mut self, work: &mut Work<Contact>, domains: &mut Domains) {
        let is_in_use = self.has_forces || self.list.allows(0.0);
        let known = (is_in_use && domains.is_lead()).then(|| (self.list.without_pairs(), self.has_forces));
        match domains.of_lead(known) {
            Some((list, has_forces)) => {
                self.has_forces = has_forces;
                if !domains.is_lead() {
                    let clock = std::mem::replace(&mut self.list, list).clock;
                    self.list.clock = clock;
                    self.pushes.clear();
                    self.contacts = super::Contacts::new(self.islands.law);
                    work.particles.clear();
                    work.lasting.clear();
                }
                self.contacts.put(std::mem::take(work.lasting));
                self.halo = Some(Halo::of_all(work.particles.len()));
            }
            None => {
                self.list.invalidate();
                self.pushes.clear();
                self.has_forces = false;
                domains.cut(&self.islands, work);
                self.halo = None;
            }
        }
    }

    /// Gives the lead, which has been shown all particles, the list of all particles and the forces due to them. The
    /// lead stores both with a run.
    pub(super) fn show_all(&mut self, work: &mut Work<Contact>, domains: &Domains) {
        let Some(halo) = &self.halo else { return };
        let parts = domains.communicator().collect(halo.packed(&self.pushes));
        if domains.is_lead() {
            self.shown = Some(super::halo::list_of_all(&parts, &self.list, work));
        }
    }
}
