//! Simulation shared by several processes. The lead process (number 0) runs the simulation as a single process would.
//! The other processes execute the orders of the lead on their particles. A window is the time between two exchanges
//! with the gas.

use super::Simulation;
use crate::communicator::Communicator;
use crate::engine::distributed::Distributed;
use crate::exact::values;
use crate::experiment::Experiment;
use crate::fluid::LoadedFlow;
use crate::particles::{Particles, Sample, fingerprint_of, for_each_slice};
use crate::record::Record;
use crate::stored::{StoreError, Stored};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Connection of a simulation to the other processes that share its run.
pub struct SharedSimulation {
    communicator: Arc<dyn Communicator>,
    /// One entry for each observer that exists in all processes. The entry is true if the other processes have
    /// received the data that the observer has collected in the lead process so far.
    informed: Vec<bool>,
}

/// Description of particles gathered from all processes, which replace the particles of the lead process (number 0)
/// for a while.
pub struct GatheredParticles {
    /// Step in the ids of the gathered particles: 1 for all particles, 2 for every second particle, and so on.
    every: u32,
    /// [m/s] root mean square of the velocities of all particles about their mean velocity. `None` if all particles are
    /// gathered.
    pub fluctuation_speed: Option<f64>,
}

/// Order from the lead process (number 0) to the other processes. The lead also does the ordered work itself, on its
/// own particles.
#[derive(Clone, Serialize, Deserialize)]
pub enum Order {
    /// Apply drag and heat for a duration [s], without motion (a kick). The second value is the number of the kick,
    /// which determines its random numbers.
    Kick(f64, u64),
    /// Advance the engine from the time of the first value [s] by a window, whose length [s] is the second value. If
    /// particles change the gas, the gas is sent too (otherwise `None`), since processes that had no particles have not
    /// computed it.
    Advance(f64, f64, Option<Box<LoadedFlow>>),
    /// Store the velocities and the state of the gas, before the velocities are changed for observers (measurements).
    Keep,
    /// Restore the velocities and the state of the gas that the order `Keep` has stored.
    TakeBack,
    /// Send particles to the lead process: every n-th particle by id, where n is the given number, and the particles
    /// in contact with one of them.
    Gather(u32),
    /// Check that the particles of the process are inside the domain, send its records to the lead, take part in the
    /// sum of the energies, and balance the numbers of particles.
    Check,
    /// Compute the checksum of the state of all processes.
    Fingerprint,
    /// Send the records of this process to the lead, and then the particles of each process in turn.
    Give,
    /// Call observers (measurements) for the particles of the process. The values are the time [s], the total momentum
    /// [kg m/s], and a list with the index of each observer and its stored data or `None`.
    ///
    /// Stored data are sent only at the first call of an observer. They are what the observer in the lead process has
    /// measured so far; the observers of the other processes continue from these data.
    See(f64, Vector3<f64>, Vec<(usize, Option<Stored>)>),
    /// End the work of the other processes, because the run is over.
    End,
}

impl SharedSimulation {
    fn tell(&self, order: &Order) {
        self.communicator.broadcast(postcard::to_stdvec(order).unwrap_or_default());
    }

    /// Waits for the next order of the lead process. An order that cannot be read ends the run.
    fn told(&self) -> Order {
        postcard::from_bytes(&self.communicator.broadcast(Vec::new())).unwrap_or(Order::End)
    }
}

impl Drop for SharedSimulation {
    /// Ends the work of the other processes, if this process is the lead.
    fn drop(&mut self) {
        if self.communicator.is_lead() {
            self.tell(&Order::End);
        }
    }
}

impl Simulation {
    /// Shares this simulation with other processes. While this saves time, each process moves the particles in its own
    /// block of the domain. The results of the lead process (number 0) are then, bit by bit, those of a run in one
    /// process. Each other process must make a simulation with the same scene and engine, whose particles are
    /// discarded. It must [`follow`](Self::follow) the lead until the simulation of the lead is dropped. `observers`
    /// is the number of observers that exist in all processes; they are the first observers of the lead.
    pub fn shared(mut self, communicator: Arc<dyn Communicator>, observers: usize) -> Self {
        let told = communicator.broadcast(postcard::to_stdvec(&self.totals).unwrap_or_default());
        self.totals = postcard::from_bytes(&told).unwrap_or(self.totals);
        if !communicator.is_lead() {
            // this also frees the memory of the particles
            self.particles = Particles::default();
        }
        if let Some(engine) = self.engine.distributed_mut() {
            engine.share(communicator.clone(), &Sample::from(&self.particles), &self.scene);
        }
        self.share = Some(SharedSimulation { communicator, informed: vec![false; observers] });
        self
    }

    /// Creates a simulation at time 0 in which each process has a part of the particles, which must not overlap at the
    /// start. The parts are those in [blocks of one size](crate::domain::blocks::Blocks::of_one_size). All processes
    /// must call this function, and must then call [`shared_in_parts`](Self::shared_in_parts).
    pub fn part(experiment: &Experiment, particles: Particles, communicator: &dyn Communicator) -> Self {
        Self::of(experiment, particles, Some(communicator))
    }

    /// Shares the simulation as [`shared`](Self::shared) does, after [`part`](Self::part). Each process continues with
    /// its own part of the particles.
    pub fn shared_in_parts(mut self, communicator: Arc<dyn Communicator>, observers: usize) -> Self {
        let sample = Sample::part(&self.particles, Some(&*communicator));
        if let Some(flow) = &mut self.through_flow {
            flow.agree(&*communicator);
        }
        if let Some(engine) = self.engine.distributed_mut() {
            engine.share(communicator.clone(), &sample, &self.scene);
        }
        if !self.engine.is_cut() {
            // this engine runs in the lead process alone, so all particles are gathered there
            let mut all = Particles::default();
            let mut append = |slice: &Particles| all.copy_from(slice, &(0..slice.len() as u32).collect::<Vec<u32>>());
            for_each_slice(&self.particles, Some(&*communicator), &mut append);
            self.particles = all;
        }
        self.share = Some(SharedSimulation { communicator, informed: vec![false; observers] });
        self
    }

    /// Executes the orders of the lead process (number 0) for the particles of this process until the simulation of
    /// the lead ends. `see` calls the observer at an index with the simulation. At the first call of an observer,
    /// `see` also gets the data that the copy of the observer in the lead has stored; at later calls `None`.
    pub fn follow(mut self, see: &mut dyn FnMut(&Self, usize, Option<&Stored>)) {
        let (mut kept, mut kept_gas) = (Particles::default(), None);
        while let Some(share) = &self.share {
            match share.told() {
                Order::Keep => {
                    self.particles.keep_kicked(&mut kept);
                    kept.eddies.clone_from(&self.particles.eddies);
                    kept_gas.clone_from(&self.loaded_flow);
                }
                Order::TakeBack => {
                    self.particles.take_back(&mut kept);
                    self.particles.eddies = kept.eddies.take();
                    self.take_gas(kept_gas.take());
                }
                Order::Kick(duration, number) => self.kick(duration, number),
                Order::Advance(time, window, gas) => {
                    self.time = time;
                    self.take_gas(gas);
                    // only the lead reports failures
                    let _ = self.advance(window);
                }
                Order::Gather(every) => self.gather(every),
                Order::Check => {
                    let _ = self.check();
                }
                Order::Give => self.give_parts(&mut |_| ()),
                Order::Fingerprint => drop(self.fingerprint()),
                Order::See(time, momentum, indices) => {
                    (self.time, self.totals.momentum) = (time, momentum);
                    indices.iter().for_each(|(index, kept)| see(&self, *index, kept.as_ref()));
                }
                Order::End => break,
            }
        }
    }

    /// If processes share the run, copies every `every`-th particle by id, and the particles in contact with one of
    /// them, to the lead process (number 0). With `every` = 1, all particles and all records are gathered. Before the
    /// next window the copies are replaced by the particles of the lead process itself.
    pub fn gather(&mut self, every: u32) {
        if self.share.is_none() || self.shown.as_ref().is_some_and(|shown| [1, every].contains(&shown.every)) {
            return;
        }
        self.scatter();
        self.order(&Order::Gather(every));
        let fluctuation_speed =
            if every > 1 && self.engine.is_cut() { Some(self.sample().fluctuation_speed()) } else { None };
        if let Some(engine) = self.engine.distributed_mut() {
            engine.gather(&mut self.particles, &self.scene, every);
        }
        if every <= 1 {
            self.collect_records();
        }
        if !self.is_follower() {
            self.shown = Some(GatheredParticles { every, fluctuation_speed });
        }
    }

    /// True if the observer at an index exists in all processes that share the run.
    pub(crate) fn is_seen_by_all(&self, index: usize) -> bool {
        self.share.as_ref().is_none_or(|share| index < share.informed.len())
    }

    /// Makes the other processes call the observers at `indices`, each for its own particles. The lead must
    /// call this method before its own observers. `kept` returns the stored data of the observer at an index.
    pub(crate) fn see_parts(&mut self, indices: &[usize], kept: impl Fn(usize) -> Stored) {
        if self.shown.as_ref().is_some_and(|shown| shown.every > 1) {
            self.scatter();
        }
        if self.engine.is_cut() && !indices.is_empty() {
            let mut told = Vec::new();
            if let Some(share) = &mut self.share {
                let mut news =
                    |index: usize| (!std::mem::replace(&mut share.informed[index], true)).then(|| kept(index));
                told = indices.iter().map(|&index| (index, news(index))).collect();
            }
            self.order(&Order::See(self.time, self.totals.momentum, told));
        }
    }

    /// [m/s] root mean square of the velocities of all particles about their mean velocity. If processes share the run,
    /// the particles must have been gathered in this process ([`gather`](Self::gather)).
    pub fn fluctuation_speed(&self) -> f64 {
        let known = self.shown.as_ref().and_then(|shown| shown.fluctuation_speed);
        known.unwrap_or_else(|| Sample::from(&self.particles).fluctuation_speed())
    }

    /// Undoes [`gather`](Self::gather): replaces the particles gathered from all processes by the particles that this
    /// process moves.
    pub(super) fn scatter(&mut self) {
        self.shown = None;
        if let Some(engine) = self.engine.distributed_mut() {
            engine.scatter(&mut self.particles);
        }
    }

    /// Adds the records (impacts, energies and momenta) of all processes to those of the lead process (number 0). The
    /// records of the other processes are empty afterwards.
    pub(super) fn collect_records(&mut self) {
        let Some(share) = &self.share else { return };
        let own = if self.is_follower() { std::mem::take(&mut self.record) } else { Record::default() };
        for bytes in share.communicator.collect(postcard::to_stdvec(&own).unwrap_or_default()) {
            if let Ok(record) = postcard::from_bytes::<Record>(&bytes) {
                self.record.merge(&record);
            }
        }
    }

    /// Number of parts into which the state is divided between processes. It is 0 if this process has the whole state,
    /// or if the processes cannot store parts; the lead process must then store the whole state.
    pub fn parts_of_state(&mut self) -> usize {
        if self.shown.as_ref().is_some_and(|shown| shown.every > 1) {
            self.scatter();
        }
        let gives_parts = self.engine.distributed().is_some_and(Distributed::gives_parts);
        self.parts().filter(|_| gives_parts).map_or(0, Communicator::size)
    }

    /// Adds up the records (impacts, energies and momenta) of all processes for a [`snapshot`](Self::snapshot). Then
    /// calls `take` with each part of the state in turn, so that only one part is in memory.
    pub fn give_parts(&mut self, take: &mut dyn FnMut(Vec<u8>)) {
        self.order(&Order::Give);
        self.collect_records();
        let (Some(communicator), Some(engine)) = (self.parts(), self.engine.distributed()) else { return };
        for rank in 0..communicator.size() {
            let own = if rank == communicator.rank() { engine.packed(&self.particles) } else { Vec::new() };
            for part in communicator.collect(own).into_iter().skip(rank).take(1) {
                take(part);
            }
        }
    }

    /// Continues from the `count` parts of a stored state, in the lead process (number 0). `next` returns the part
    /// with the number that it gets. At the same time the other processes must call [`take_dealt`](Self::take_dealt)
    /// to receive their parts.
    ///
    /// # Errors
    /// The parts do not contain all particles.
    pub fn take_parts(&mut self, count: usize, next: &mut dyn FnMut(usize) -> Vec<u8>) -> Result<(), StoreError> {
        if let Some(share) = &self.share {
            share.communicator.broadcast(postcard::to_stdvec(&(count as u64, self.engine.stored()?))?);
        }
        self.replace_by_parts(count, next);
        if self.sample().count() == self.totals.count { Ok(()) } else { Err(StoreError::misfit()) }
    }

    fn replace_by_parts(&mut self, count: usize, next: &mut dyn FnMut(usize) -> Vec<u8>) {
        if let Some(engine) = self.engine.distributed_mut() {
            engine.take_parts(&mut self.particles, &self.scene, count, next);
        }
    }

    /// Receives from the lead the part of a stored state that belongs to this process.
    ///
    /// # Errors
    /// The data from the lead do not fit the engine.
    pub fn take_dealt(&mut self) -> Result<(), StoreError> {
        let Some(share) = &self.share else { return Ok(()) };
        let (count, engine): (u64, Stored) = postcard::from_bytes(&share.communicator.broadcast(Vec::new()))?;
        self.engine.restore(&engine)?;
        self.replace_by_parts(count as usize, &mut |_| Vec::new());
        self.sample().count();
        Ok(())
    }

    /// Checksum of the [`state`](Self::state) of the particles of all processes, as [`Particles::fingerprint`] computes
    /// it. Stored positions are shifted by whole periods into the box.
    pub fn fingerprint(&mut self) -> u64 {
        if self.shown.as_ref().is_some_and(|shown| shown.every > 1) {
            self.scatter();
        }
        if !self.engine.is_cut() {
            self.particles.wrap(&self.scene.domain);
            return self.particles.fingerprint();
        }
        self.order(&Order::Fingerprint);
        self.particles.wrap(&self.scene.domain);
        fingerprint_of(&self.particles, self.parts())
    }

    /// Sample of the particles, from which sums over the particles of all processes are computed. If each process has a
    /// part of the particles, all processes must request the same sums.
    pub fn sample(&self) -> Sample<'_> {
        Sample::part(&self.particles, self.parts())
    }

    /// Connection to the other processes, if each process has a part of the particles; otherwise `None`.
    pub fn parts(&self) -> Option<&dyn Communicator> {
        self.share.as_ref().filter(|_| self.engine.is_cut()).map(|share| &*share.communicator)
    }

    /// Sends an order to the other processes, if this process is the lead (number 0).
    pub(super) fn order(&self, order: &Order) {
        if let Some(share) = self.share.as_ref().filter(|share| share.communicator.is_lead()) {
            share.tell(order);
        }
    }

    /// [kg m/s] momentum that walls have given to the particles of all processes since the start.
    pub(super) fn given_by_walls(&self) -> Vector3<f64> {
        let Some(share) = &self.share else { return self.record.ledger.by_walls() };
        let mut sums = self.record.ledger.given_by_walls();
        share.communicator.total(&mut sums.each_mut());
        values(&sums).into()
    }

    /// True if this process executes the orders of the lead.
    pub(super) fn is_follower(&self) -> bool {
        self.share.as_ref().is_some_and(|share| !share.communicator.is_lead())
    }
}
