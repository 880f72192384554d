//! Processes that share a run, with the operations that islands (groups of particles that may meet) require. The lead
//! process is process 0. By default the run has a single process, and the operations do nothing. Islands are found in
//! parts (pieces) of a window, the time between two exchanges with the gas.

use super::CrossRankContact;
use super::agreement::PartDecision;
use super::domains::{Domains, LocalParticles};
use super::packing::{add_received_contacts, take_aboard};
use crate::communicator::Communicator;
use crate::domain::Domain;
use crate::engine::driver::Work;
use crate::engine::islands::{IslandCounters, IslandFinder, Solve, in_order};
use crate::engine::population::PopulationSummary;
use crate::exact::ExactSum;
use crate::neighbours::region::Region;
use crate::particles::Particles;
use nalgebra::Vector3;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::Arc;

/// Processes that share a run; by default a single process, which stores all particles.
pub struct Processes<C> {
    domains: Option<Domains<C>>,
}

impl<C> Default for Processes<C> {
    fn default() -> Self {
        Self { domains: None }
    }
}

impl<C: Copy + Serialize + DeserializeOwned> Processes<C> {
    /// Shares the run among processes. `population` summarises the sizes of all particles. There are two cases:
    ///
    /// * Each process already stores the particles of its block (region of the box). `cut` is then the box, which is
    ///   cut into these blocks.
    /// * The lead process (process 0) still stores all particles; `cut` is then `None`. The processes get their
    ///   particles later, when the program next tries to move particles in islands (groups that may meet).
    pub fn share(&mut self, communicator: Arc<dyn Communicator>, population: PopulationSummary, cut: Option<&Domain>) {
        let domains = self.domains.insert(Domains::new(communicator, population));
        cut.into_iter().for_each(|domain| domains.begin_cut(domain));
    }

    /// Division of the run among processes; `None` for a single process.
    pub fn domains(&mut self) -> Option<&mut Domains<C>> {
        self.domains.as_mut()
    }

    /// Division of the run among processes while each process stores only the particles of its block (region of the
    /// box); otherwise `None`.
    fn cut_domains(&self) -> Option<&Domains<C>> {
        self.domains.as_ref().filter(|domains| domains.is_cut)
    }

    /// True if each process stores only the particles of its block (region of the box).
    pub fn is_cut(&self) -> bool {
        self.cut_domains().is_some()
    }

    /// True if this process is the lead process (process 0), and its store contains copies of particles of all
    /// processes in place of its own.
    pub fn is_shown(&self) -> bool {
        self.domains.as_ref().is_some_and(|domains| domains.gathered.is_some())
    }

    /// True if this process is the lead process (process 0) or the only process.
    pub fn is_lead(&self) -> bool {
        self.domains.as_ref().is_none_or(Domains::is_lead)
    }

    /// Contacts in progress between a particle of this process and one of another process.
    pub fn abroad(&self) -> &[CrossRankContact<C>] {
        self.domains.as_ref().map_or(&[], |domains| &domains.abroad)
    }

    /// Summary of the sizes of all particles of the run; `None` for a single process.
    pub fn population(&self) -> Option<Arc<PopulationSummary>> {
        self.domains.as_ref().map(|domains| domains.population.clone())
    }

    /// Replaces each sum by its total over all processes, if each process stores only its own particles; otherwise does
    /// nothing.
    pub fn total(&self, sums: &mut [&mut ExactSum]) {
        self.domains.iter().for_each(|domains| domains.total(sums));
    }

    /// Replaces each value by the largest value of all processes, if each process stores only its own particles;
    /// otherwise does nothing.
    pub fn largest(&self, values: &mut [f64]) {
        self.domains.iter().for_each(|domains| domains.largest(values));
    }

    /// Completes the sum of the energies [J] of contacts. Before the call, `sum` contains the energies of the contacts
    /// among own particles; afterwards it contains those of all contacts in all processes. `energy` returns the energy
    /// of a contact. Does nothing if one process stores all particles.
    pub fn add_energy(&self, sum: &mut ExactSum, energy: impl Fn(&C) -> f64) {
        if let Some(domains) = self.cut_domains().filter(|_| !self.is_shown()) {
            // each of the two processes adds half of the energy, since both store the contact
            domains.abroad.iter().for_each(|abroad| sum.add(0.5 * energy(&abroad.carried)));
            domains.total(&mut [sum]);
        }
    }

    /// Number of contacts in progress in all processes that share the run. `own` is the number of contacts among the
    /// particles of this process. All processes must call this function.
    pub fn held(&self, own: usize) -> usize {
        let Some(domains) = &self.domains else { return own };
        // before the particles are divided, the lead process (process 0) has all contacts
        let own = if domains.is_cut || domains.is_lead() { own } else { 0 };
        // a contact with a particle of another process is counted twice, once by each process
        let mut twice = [(2 * own + domains.abroad.len()) as i64];
        domains.count(&mut twice);
        (twice[0] / 2) as usize
    }

    /// Replaces the increase of each count since `before` by the sum of the increases in all processes. Replaces the
    /// size of the largest island (group of particles that may meet) by the largest in any process.
    pub fn share_counts(&self, counters: &mut IslandCounters, before: &IslandCounters) {
        let Some(domains) = self.cut_domains() else { return };
        let mut past = *before;
        let mut since: Vec<i64> =
            counters.sums().into_iter().zip(past.sums()).map(|(now, before)| (*now - *before) as i64).collect();
        domains.count(&mut since);
        for ((now, before), since) in counters.sums().into_iter().zip(past.sums()).zip(since) {
            *now = *before + since as u64;
        }
        let mut largest = [counters.largest as f64];
        domains.largest(&mut largest);
        counters.largest = largest[0] as u64;
    }

    /// Region of the box that contains the particles of this process; for a single process, this is the whole box.
    pub fn region(&self, domain: &Domain) -> Region {
        self.domains.as_ref().map_or_else(|| Region::from(domain), |domains| domains.region(domain))
    }

    /// Adapts stored indices to a new order of the particle store: the particle that was at index `p` is now at
    /// `index_of[p]`.
    pub fn reorder(&mut self, index_of: &[u32]) {
        for abroad in self.domains.iter_mut().flat_map(|domains| &mut domains.abroad) {
            abroad.own = index_of[abroad.own as usize];
        }
    }

    /// Distributes the particles from the lead process (process 0) to the processes that own their blocks (regions of
    /// the box), if the lead process still stores all particles.
    pub fn cut<S: Solve<Carried = C>>(&mut self, solver: &S, work: &mut Work<C>) {
        if let Some(domains) = self.domains.as_mut().filter(|domains| !domains.is_cut) {
            domains.cut(solver, work);
        }
    }

    /// Moves all particles from all processes to the lead process (process 0). `members` lists the particles that were
    /// in islands (groups of particles that may meet) in the last part (interval of time) of a window; the function
    /// adapts their indices.
    pub fn assemble<S: Solve<Carried = C>>(&mut self, solver: &S, work: &mut Work<C>, members: &mut Vec<u32>) {
        if let Some(domains) = self.domains.as_mut().filter(|domains| domains.is_cut) {
            domains.assemble(solver, work, members);
        }
    }

    /// Replaces all particles and contacts in progress by those of a stored run, which consists of `count` packed parts
    /// (shares of its particles). In the lead process (process 0), `next` returns the part with a given number. Each
    /// process keeps the particles in its block (region of the box), among blocks of equal size; a single process keeps
    /// all particles.
    pub fn take_parts<S: Solve<Carried = C>>(
        &mut self,
        solver: &S,
        work: &mut Work<C>,
        count: usize,
        next: &mut dyn FnMut(usize) -> Vec<u8>,
    ) {
        *work.particles = Particles::default();
        work.lasting.clear();
        let domain = &work.scene.domain;
        self.domains.iter_mut().for_each(|domains| domains.begin_cut(domain));
        let mut lasting = Vec::new();
        for number in 0..count {
            let part = if self.is_lead() { next(number) } else { Vec::new() };
            let own = self.domains.as_ref().map_or_else(|| part.clone(), |domains| domains.deal::<S>(&part, domain));
            lasting.extend(take_aboard::<C>(&own, work.particles).into_iter().flatten());
        }
        let abroad = add_received_contacts::<S>(lasting, work);
        if let Some(domains) = &mut self.domains {
            domains.abroad = abroad;
        }
        in_order(solver, work);
    }

    /// Copies from other processes the particles that may belong to islands (groups of particles that may meet) of own
    /// particles. A flight is the straight motion during `part` [s], in a frame with the velocity `frame` [m/s].
    /// `flight` [m] is the largest distance of any point of a particle from the middle of its flight.
    pub fn borrow<S: Solve<Carried = C>>(
        &mut self,
        work: &mut Work<C>,
        (frame, part): (Vector3<f64>, f64),
        flight: f64,
    ) -> LocalParticles<C> {
        match &mut self.domains {
            Some(domains) => domains.trade::<S>(work, (frame, part), flight),
            None => LocalParticles::all(&work.scene.domain),
        }
    }

    /// Returns the joint decision of all processes about a part, a piece of the time between two exchanges with the
    /// gas, that they have tried. `failed` is true if, in this process, an island (group of particles that may meet) is
    /// too large or the engine failed.
    pub fn decide<'a>(
        &mut self,
        islands: &impl IslandFinder<'a>,
        view: &LocalParticles<C>,
        failed: bool,
    ) -> PartDecision {
        match &mut self.domains {
            Some(domains) => domains.decide(islands, view, failed),
            None if failed || !islands.reach().fits(islands.half_period()) => PartDecision::Failed,
            None => PartDecision::Done,
        }
    }

    /// Removes the copies of particles of other processes, and the contacts of such copies, after a part (piece of the
    /// time between two exchanges with the gas) with valid results. `members` lists the members of islands (groups of
    /// particles that may meet); the function adapts their indices and deletes the removed copies from the list.
    pub fn keep<S: Solve<Carried = C>>(
        &mut self,
        solver: &S,
        work: &mut Work<C>,
        view: &LocalParticles<C>,
        members: &mut Vec<u32>,
    ) {
        self.domains.iter_mut().for_each(|domains| domains.keep(solver, work, view, members));
    }

    /// Removes the copies of particles of other processes after a part (piece of the time between two exchanges with
    /// the gas) whose results are not valid. Restores the store and the contacts from before the copies were made.
    pub fn give_back(&mut self, work: &mut Work<C>, view: LocalParticles<C>) {
        if let Some(domains) = &mut self.domains {
            domains.give_back(work, view);
        }
    }
}
