//! A simulation that several processes share: the lead runs it as if it were alone, the others do what it tells them.

use super::Simulation;
use crate::communicator::Communicator;
use crate::exact::{ExactSum, values};
use crate::particles::Particles;
use crate::record::Record;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A run that processes share.
pub struct Share {
    communicator: Arc<dyn Communicator>,
}

/// What the lead of a run tells the other processes to do.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub enum Order {
    /// Drag alone for so long [s].
    Kick(f64),
    /// The engine, from a time on and for a window [s].
    Advance(f64, f64),
    /// Give the lead all particles.
    Assemble,
    /// The run is over.
    End,
}

impl Share {
    /// Adds up over all processes.
    pub fn total(&self, sums: &mut [ExactSum]) {
        let mut words: Vec<i64> = sums.iter_mut().flat_map(|sum| *sum.words()).collect();
        self.communicator.sum(&mut words);
        let mut rest = words.as_slice();
        for sum in sums {
            let own = sum.words();
            let (first, others) = rest.split_at(own.len());
            own.copy_from_slice(first);
            rest = others;
        }
    }

    fn tell(&self, order: Order) {
        self.communicator.broadcast(postcard::to_stdvec(&order).unwrap_or_default());
    }

    /// What the lead tells.
    fn told(&self) -> Order {
        postcard::from_bytes(&self.communicator.broadcast(Vec::new())).unwrap_or(Order::End)
    }
}

impl Drop for Share {
    /// Lets those go who follow.
    fn drop(&mut self) {
        if self.communicator.is_lead() {
            self.tell(Order::End);
        }
    }
}

impl Simulation {
    /// The same, shared with other processes that have been given the same: while it pays, each moves the particles of a domain of its own.
    /// The lead goes on as if it were alone, and gets the same bits; the others [`follow`](Self::follow) until it drops the
    /// simulation.
    pub fn shared(mut self, communicator: Arc<dyn Communicator>) -> Self {
        self.engine.share(communicator.clone(), &self.particles, &self.scene);
        if !communicator.is_lead() {
            // its room is given back too
            self.particles = Particles::default();
        }
        self.share = Some(Share { communicator });
        self
    }

    /// Does what the lead does, for the particles of this process, until the lead is done.
    pub fn follow(mut self) {
        while let Some(share) = &self.share {
            match share.told() {
                Order::Kick(duration) => self.kick(duration),
                Order::Advance(time, window) => {
                    self.time = time;
                    // the lead says what went wrong
                    let _ = self.advance(window);
                }
                Order::Assemble => self.assemble(),
                Order::End => break,
            }
        }
    }

    /// Gives the lead all particles, and all that has been counted, if processes share the run.
    pub fn assemble(&mut self) {
        self.order(Order::Assemble);
        let Some(share) = &self.share else { return };
        self.engine.assemble(&mut self.particles, &self.scene);
        let own = if self.is_follower() { std::mem::take(&mut self.record) } else { Record::default() };
        for bytes in share.communicator.collect(postcard::to_stdvec(&own).unwrap_or_default()) {
            if let Ok(record) = postcard::from_bytes::<Record>(&bytes) {
                self.record.merge(&record);
            }
        }
    }

    /// Tells the processes that follow what this one, the lead, does next.
    pub(super) fn order(&self, order: Order) {
        if let Some(share) = self.share.as_ref().filter(|share| share.communicator.is_lead()) {
            share.tell(order);
        }
    }

    /// [kg m/s] what walls have given to all particles since the start.
    pub(super) fn given_by_walls(&self) -> Vector3<f64> {
        let Some(share) = &self.share else { return self.record.ledger.by_walls() };
        let mut sums = self.record.ledger.given_by_walls();
        share.total(&mut sums);
        values(&sums).into()
    }

    /// Whether this process does what another tells.
    pub(super) fn is_follower(&self) -> bool {
        self.share.as_ref().is_some_and(|share| !share.communicator.is_lead())
    }
}
