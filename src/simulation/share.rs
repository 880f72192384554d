//! A simulation that several processes share: the lead runs it as if it were alone, the others do what it tells them.

use super::Simulation;
use crate::communicator::Communicator;
use crate::exact::values;
use crate::experiment::Experiment;
use crate::particles::{Particles, Sample, fingerprint_of, for_each_slice};
use crate::record::Record;
use crate::stored::{StoreError, Stored};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A run that processes share.
pub struct SharedSimulation {
    communicator: Arc<dyn Communicator>,
    /// Whether the observers of the others know what those of the lead kept before: of so many of the first observers, which everybody has.
    informed: Vec<bool>,
}

/// What the lead sees in place of its own particles.
pub struct GatheredParticles {
    /// Every so manieth particle by id.
    every: u32,
    /// [m/s] root mean square of the velocities of all about their mean, if it does not see all.
    pub agitation: Option<f64>,
}

/// What the lead of a run tells the other processes to do.
#[derive(Clone, Serialize, Deserialize)]
pub enum Order {
    /// Drag alone for so long [s].
    Kick(f64),
    /// The engine, from a time on and for a window [s].
    Advance(f64, f64),
    /// Keep the velocities, for a look at them with a kick.
    Keep,
    /// Go on with the velocities that were kept.
    TakeBack,
    /// Show the lead every so manieth particle by id.
    Show(u32),
    /// Whether all is well with the own particles.
    Check,
    /// The checksum of the state.
    Fingerprint,
    /// Give the lead all that has been counted, and then the parts, one after the other.
    Give,
    /// Let the observers at these places see the own part of the particles, at a time [s] and with the momentum [kg m/s] of all particles.
    ///
    /// Whoever sees for the first time goes on from what the lead's observer has kept.
    See(f64, Vector3<f64>, Vec<(usize, Option<Stored>)>),
    /// The run is over.
    End,
}

impl SharedSimulation {
    fn tell(&self, order: &Order) {
        self.communicator.broadcast(postcard::to_stdvec(order).unwrap_or_default());
    }

    /// What the lead tells.
    fn told(&self) -> Order {
        postcard::from_bytes(&self.communicator.broadcast(Vec::new())).unwrap_or(Order::End)
    }
}

impl Drop for SharedSimulation {
    /// Lets those go who follow.
    fn drop(&mut self) {
        if self.communicator.is_lead() {
            self.tell(&Order::End);
        }
    }
}

impl Simulation {
    /// The same, shared with other processes: while it pays, each moves the particles of a domain of its own.
    /// The lead goes on as if it were alone, and gets the same bits; the others, who have a simulation of the same scene and engine, [`follow`](Self::follow)
    /// until it drops the simulation: what they have of the particles does not matter. The first so many `observers` of the lead are those of everybody.
    pub fn shared(mut self, communicator: Arc<dyn Communicator>, observers: usize) -> Self {
        let told = communicator.broadcast(postcard::to_stdvec(&self.totals).unwrap_or_default());
        self.totals = postcard::from_bytes(&told).unwrap_or(self.totals);
        if !communicator.is_lead() {
            // its room is given back too
            self.particles = Particles::default();
        }
        self.engine.share(communicator.clone(), &Sample::from(&self.particles), &self.scene);
        self.share = Some(SharedSimulation { communicator, informed: vec![false; observers] });
        self
    }

    /// A simulation at time 0 of particles of which each process has those of its block among
    /// [blocks of one size](crate::domain::blocks::Blocks::of_one_size), and nothing overlaps. All processes must call it, and then share the simulation.
    pub fn part(experiment: &Experiment, particles: Particles, communicator: &dyn Communicator) -> Self {
        Self::of(experiment, particles, Some(communicator))
    }

    /// As [`shared`](Self::shared), of a simulation of which each process has a [`part`](Self::part): all go on with theirs.
    pub fn shared_in_parts(mut self, communicator: Arc<dyn Communicator>, observers: usize) -> Self {
        let sample = Sample::part(&self.particles, Some(&*communicator));
        self.engine.share(communicator.clone(), &sample, &self.scene);
        if !self.engine.is_cut() {
            // an engine that leaves all to the lead
            let mut all = Particles::default();
            let mut append = |slice: &Particles| all.copy_from(slice, &(0..slice.len() as u32).collect::<Vec<u32>>());
            for_each_slice(&self.particles, Some(&*communicator), &mut append);
            self.particles = all;
        }
        self.share = Some(SharedSimulation { communicator, informed: vec![false; observers] });
        self
    }

    /// Does what the lead does, for the particles of this process, until the lead is done. `see` shows it to the observer at a place,
    /// which, the first time, goes on from what the lead's has kept.
    pub fn follow(mut self, see: &mut dyn FnMut(&Self, usize, Option<&Stored>)) {
        let mut kept = Particles::default();
        while let Some(share) = &self.share {
            match share.told() {
                Order::Keep => self.particles.keep_kicked(&mut kept),
                Order::TakeBack => self.particles.take_back(&mut kept),
                Order::Kick(duration) => self.kick(duration),
                Order::Advance(time, window) => {
                    self.time = time;
                    // the lead says what went wrong
                    let _ = self.advance(window);
                }
                Order::Show(every) => self.show(every),
                Order::Check => {
                    let _ = self.check();
                }
                Order::Give => self.give_parts(&mut |_| ()),
                Order::Fingerprint => drop(self.fingerprint()),
                Order::See(time, momentum, places) => {
                    (self.time, self.totals.momentum) = (time, momentum);
                    places.iter().for_each(|(place, kept)| see(&self, *place, kept.as_ref()));
                }
                Order::End => break,
            }
        }
    }

    /// Shows the lead every so manieth particle by id (1: all, and then all that has been counted, too) and those in contact with them, if processes
    /// share the run. The next window puts an end to it.
    pub fn show(&mut self, every: u32) {
        if self.share.is_none() || self.shown.as_ref().is_some_and(|shown| [1, every].contains(&shown.every)) {
            return;
        }
        self.hide();
        self.order(&Order::Show(every));
        let agitation = if every > 1 && self.engine.is_cut() { Some(self.sample().agitation()) } else { None };
        self.engine.show(&mut self.particles, &self.scene, every);
        if every <= 1 {
            self.collect_records();
        }
        if !self.is_follower() {
            self.shown = Some(GatheredParticles { every, agitation });
        }
    }

    /// Whether the observer at a place is one of everybody.
    pub(crate) fn is_seen_by_all(&self, place: usize) -> bool {
        self.share.as_ref().is_none_or(|share| place < share.informed.len())
    }

    /// Lets everybody show the parts of the particles to the observers at those places; the lead, who calls this, then does so, too. `kept` is what
    /// an observer keeps.
    pub(crate) fn show_parts(&mut self, places: &[usize], kept: impl Fn(usize) -> Stored) {
        if self.shown.as_ref().is_some_and(|shown| shown.every > 1) {
            self.hide();
        }
        if self.engine.is_cut() && !places.is_empty() {
            let mut told = Vec::new();
            if let Some(share) = &mut self.share {
                let mut news =
                    |place: usize| (!std::mem::replace(&mut share.informed[place], true)).then(|| kept(place));
                told = places.iter().map(|&place| (place, news(place))).collect();
            }
            self.order(&Order::See(self.time, self.totals.momentum, told));
        }
    }

    /// [m/s] root mean square of the velocities of all particles about their mean.
    pub fn agitation(&self) -> f64 {
        let known = self.shown.as_ref().and_then(|shown| shown.agitation);
        known.unwrap_or_else(|| Sample::from(&self.particles).agitation())
    }

    /// Goes on with the particles of this process.
    pub(super) fn hide(&mut self) {
        self.shown = None;
        self.engine.hide(&mut self.particles);
    }

    /// Gives the lead all that has been counted.
    pub(super) fn collect_records(&mut self) {
        let Some(share) = &self.share else { return };
        let own = if self.is_follower() { std::mem::take(&mut self.record) } else { Record::default() };
        for bytes in share.communicator.collect(postcard::to_stdvec(&own).unwrap_or_default()) {
            if let Ok(record) = postcard::from_bytes::<Record>(&bytes) {
                self.record.merge(&record);
            }
        }
    }

    /// In how many parts the state is: 0 if this process has all of it.
    pub fn parts_of_state(&mut self) -> usize {
        if self.shown.as_ref().is_some_and(|shown| shown.every > 1) {
            self.hide();
        }
        self.parts().filter(|_| self.engine.gives_parts()).map_or(0, Communicator::size)
    }

    /// Collects all that has been counted for a [`snapshot`](Self::snapshot), and hands its parts to `take`, one after the other: each in turn is here.
    pub fn give_parts(&mut self, take: &mut dyn FnMut(Vec<u8>)) {
        self.order(&Order::Give);
        self.collect_records();
        let Some(communicator) = self.parts() else { return };
        for rank in 0..communicator.size() {
            let own = if rank == communicator.rank() { self.engine.packed(&self.particles) } else { Vec::new() };
            for part in communicator.collect(own).into_iter().skip(rank).take(1) {
                take(part);
            }
        }
    }

    /// Goes on from the parts of a state: `count` of them, of which `next` gives that with a number; those who share the run
    /// [`take_dealt`](Self::take_dealt) theirs meanwhile.
    ///
    /// # Errors
    /// They are not all particles.
    pub fn take_parts(&mut self, count: usize, next: &mut dyn FnMut(usize) -> Vec<u8>) -> Result<(), StoreError> {
        if let Some(share) = &self.share {
            share.communicator.broadcast(postcard::to_stdvec(&(count as u64, self.engine.stored()?))?);
        }
        self.engine.take_parts(&mut self.particles, &self.scene, count, next);
        if self.sample().count() == self.totals.count { Ok(()) } else { Err(StoreError::misfit()) }
    }

    /// Gets its part of a state from the lead.
    ///
    /// # Errors
    /// What the lead tells is not of such an engine.
    pub fn take_dealt(&mut self) -> Result<(), StoreError> {
        let Some(share) = &self.share else { return Ok(()) };
        let (count, engine): (u64, Stored) = postcard::from_bytes(&share.communicator.broadcast(Vec::new()))?;
        self.engine.restore(&engine)?;
        self.engine.take_parts(&mut self.particles, &self.scene, count as usize, &mut |_| Vec::new());
        self.sample().count();
        Ok(())
    }

    /// The checksum of the [`state`](Self::state), of the particles of all processes: [`Particles::fingerprint`] of all of them.
    pub fn fingerprint(&mut self) -> u64 {
        if self.shown.as_ref().is_some_and(|shown| shown.every > 1) {
            self.hide();
        }
        if !self.engine.is_cut() {
            self.particles.wrap(&self.scene.domain);
            return self.particles.fingerprint();
        }
        self.order(&Order::Fingerprint);
        self.particles.wrap(&self.scene.domain);
        fingerprint_of(&self.particles, self.parts())
    }

    /// Its particles, of which others have a part while each process has a domain of its own: then all processes must ask for the same sums.
    pub fn sample(&self) -> Sample<'_> {
        Sample::part(&self.particles, self.parts())
    }

    /// The processes, while each has a part of the particles.
    pub(crate) fn parts(&self) -> Option<&dyn Communicator> {
        self.share.as_ref().filter(|_| self.engine.is_cut()).map(|share| &*share.communicator)
    }

    /// Tells the processes that follow what this one, the lead, does next.
    pub(super) fn order(&self, order: &Order) {
        if let Some(share) = self.share.as_ref().filter(|share| share.communicator.is_lead()) {
            share.tell(order);
        }
    }

    /// [kg m/s] what walls have given to all particles since the start.
    pub(super) fn given_by_walls(&self) -> Vector3<f64> {
        let Some(share) = &self.share else { return self.record.ledger.by_walls() };
        let mut sums = self.record.ledger.given_by_walls();
        share.communicator.total(&mut sums.each_mut());
        values(&sums).into()
    }

    /// Whether this process does what another tells.
    pub(super) fn is_follower(&self) -> bool {
        self.share.as_ref().is_some_and(|share| !share.communicator.is_lead())
    }
}
