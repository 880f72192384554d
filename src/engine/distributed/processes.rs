//! Processes that share a run, seen from islands: by default a single one, for which nothing here does anything.

use super::CrossRankContact;
use super::agreement::PartDecision;
use super::domains::{Domains, LocalParticles};
use super::packing::{settle, take_aboard};
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

/// Processes that share a run; by default a single one, which has all particles.
pub struct Processes<C> {
    domains: Option<Domains<C>>,
}

impl<C> Default for Processes<C> {
    fn default() -> Self {
        Self { domains: None }
    }
}

impl<C: Copy + Serialize + DeserializeOwned> Processes<C> {
    /// Shares the run among processes. If each has the particles of its block already, `cut` is the box; otherwise the
    /// box is cut into domains when islands are next tried.
    pub fn share(&mut self, communicator: Arc<dyn Communicator>, population: PopulationSummary, cut: Option<&Domain>) {
        let domains = self.domains.insert(Domains::new(communicator, population));
        cut.into_iter().for_each(|domain| domains.begin_cut(domain));
    }

    /// Domain decomposition of the run; `None` for a single process.
    pub fn domains(&mut self) -> Option<&mut Domains<C>> {
        self.domains.as_mut()
    }

    /// Domain decomposition of the run, if each process has only the particles of its domain.
    fn cut_domains(&self) -> Option<&Domains<C>> {
        self.domains.as_ref().filter(|domains| domains.is_cut)
    }

    /// True if the store holds the particles of one domain only.
    pub fn is_cut(&self) -> bool {
        self.cut_domains().is_some()
    }

    /// True if this process, the lead, is shown the particles of others in place of its own.
    pub fn is_shown(&self) -> bool {
        self.domains.as_ref().is_some_and(|domains| domains.gathered.is_some())
    }

    /// True if this process is the lead, or the only one.
    pub fn is_lead(&self) -> bool {
        self.domains.as_ref().is_none_or(Domains::is_lead)
    }

    /// State carried between a particle of this process and one of another process.
    pub fn abroad(&self) -> &[CrossRankContact<C>] {
        self.domains.as_ref().map_or(&[], |domains| &domains.abroad)
    }

    /// Summary of all particles of the run, if other processes may have some of them.
    pub fn population(&self) -> Option<Arc<PopulationSummary>> {
        self.domains.as_ref().map(|domains| domains.population.clone())
    }

    /// Sums over all processes.
    pub fn total(&self, sums: &mut [&mut ExactSum]) {
        self.domains.iter().for_each(|domains| domains.total(sums));
    }

    /// Largest values of all processes.
    pub fn largest(&self, values: &mut [f64]) {
        self.domains.iter().for_each(|domains| domains.largest(values));
    }

    /// Adds the `energy` [J] of the state carried between processes, and sums over all processes.
    pub fn add_energy(&self, sum: &mut ExactSum, energy: impl Fn(&C) -> f64) {
        if let Some(domains) = self.cut_domains().filter(|_| !self.is_shown()) {
            // two processes have it
            domains.abroad.iter().for_each(|abroad| sum.add(0.5 * energy(&abroad.carried)));
            domains.total(&mut [sum]);
        }
    }

    /// Number of contacts in progress in all processes, of which this one has `own` among its own particles.
    pub fn held(&self, own: usize) -> usize {
        let Some(domains) = self.cut_domains() else { return own };
        // a contact with a particle of another process is known to both processes
        let mut twice = [(2 * own + domains.abroad.len()) as i64];
        domains.count(&mut twice);
        (twice[0] / 2) as usize
    }

    /// Sums the counts of all processes since `before`.
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

    /// Region with the particles of this process.
    pub fn region(&self, domain: &Domain) -> Region {
        self.domains.as_ref().map_or_else(|| Region::from(domain), |domains| domains.region(domain))
    }

    /// Follows a reordered store: the particle once at index `p` is now at `place_of[p]`.
    pub fn reorder(&mut self, place_of: &[u32]) {
        for abroad in self.domains.iter_mut().flat_map(|domains| &mut domains.abroad) {
            abroad.own = place_of[abroad.own as usize];
        }
    }

    /// Gives each process the particles of its domain, unless it has them already.
    pub fn cut<S: Solve<Carried = C>>(&mut self, solver: &S, work: &mut Work<C>) {
        if let Some(domains) = self.domains.as_mut().filter(|domains| !domains.is_cut) {
            domains.cut(solver, work);
        }
    }

    /// Gives all particles to the lead process.
    pub fn assemble<S: Solve<Carried = C>>(&mut self, solver: &S, work: &mut Work<C>, members: &mut Vec<u32>) {
        if let Some(domains) = self.domains.as_mut().filter(|domains| domains.is_cut) {
            domains.assemble(solver, work, members);
        }
    }

    /// Replaces all particles and all carried state by `count` parts that processes have packed; `next` gives the lead
    /// process one part after the other. Each process keeps the particles in its block, among blocks of equal size. A
    /// single process keeps all.
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
        let abroad = settle::<S>(lasting, work);
        if let Some(domains) = &mut self.domains {
            domains.abroad = abroad;
        }
        in_order(solver, work);
    }

    /// Borrows the particles of other processes that may take part in islands of own particles. A flight takes `part`
    /// [s] and is seen from `frame` [m/s]; `flight` [m] is the largest reach of a flight.
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

    /// Joint decision of all processes about a part that they have tried; this one has `failed` if islands grow too
    /// large or the engine fails.
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

    /// Keeps only the own particles and their carried state after a part that is done. The indices in `members` are
    /// updated.
    pub fn keep<S: Solve<Carried = C>>(
        &mut self,
        solver: &S,
        work: &mut Work<C>,
        view: &LocalParticles<C>,
        members: &mut Vec<u32>,
    ) {
        self.domains.iter_mut().for_each(|domains| domains.keep(solver, work, view, members));
    }

    /// Returns borrowed particles: the store is as it was before.
    pub fn give_back(&mut self, work: &mut Work<C>, view: LocalParticles<C>) {
        if let Some(domains) = &mut self.domains {
            domains.give_back(work, view);
        }
    }
}
