//! Amounts that collisions add to the ledger (sums of energies and momenta of a run), in the order of time. The amounts
//! are stored for one round, a piece of time in which several threads process events.

use super::{append, is_full};
use crate::engine::hard::impulse::Collision;
use crate::record::{Ledger, Log, Record};
use nalgebra::Matrix3;
use std::cmp::Ordering;

/// Amounts that a collision adds to the ledger (sums of energies and momenta of the run).
#[derive(Clone, Debug)]
enum Amounts {
    /// Virial [J], loss by restitution [J] and loss by friction [J] of a collision of two particles.
    Pair(Matrix3<f64>, f64, f64),
    /// Amounts of any kind, as a ledger. This form is for collisions with a wall, and for collisions that the TC model
    /// makes elastic because one of the two bodies has collided shortly before.
    Any(Box<Ledger>),
}

/// A collision in a round (piece of time in which several threads process events).
#[derive(Clone, Debug)]
struct CollisionRecord {
    /// [s] time of the collision since the epoch (zero of the event queue's time).
    time: f64,
    /// Id of the particle in whose entry of the event queue the collision was stored.
    id: u32,
    amounts: Amounts,
}

/// Collisions of a part of the particles (those of one thread) in a round (piece of time shared by threads), in the
/// order of time.
#[derive(Clone, Debug, Default)]
pub struct Records {
    collisions: Vec<CollisionRecord>,
}

impl Records {
    /// Moves the amounts of one collision from the ledger of `log` (sums of energies and momenta) to this list. The
    /// impact itself stays in the log. The collision was the next event of the particle with the id `id`, at `time` [s]
    /// since the epoch (zero of the event queue's time).
    #[inline]
    pub fn take(&mut self, time: f64, id: u32, collision: &Collision, log: &mut Log) {
        let ledger = &mut log.ledger;
        // a collision that the TC model makes elastic also adds to the energy that this model keeps
        let amounts = if collision.couple.is_wall() || collision.elastic {
            Amounts::Any(Box::new(std::mem::take(ledger)))
        } else {
            let take = std::mem::take::<f64>;
            let losses = (take(&mut ledger.pair_restitution_loss), take(&mut ledger.pair_friction_loss));
            Amounts::Pair(std::mem::take(&mut ledger.pair_virial), losses.0, losses.1)
        };
        append(&mut self.collisions, CollisionRecord { time, id, amounts });
    }

    /// Forgets all collisions.
    pub fn clear(&mut self) {
        self.collisions.clear();
    }

    /// Adds the amounts of the collisions of all lists to the ledger of `log` (sums of energies and momenta). The
    /// amounts are added in the order of time, as if one thread had processed all collisions. If the log is full, it is
    /// added to the record of the run. `before` is the number of earlier collisions of the run.
    pub fn merge(lists: &[&Self], log: &mut Log, record: &mut Record, before: u64) {
        let mut collisions = before;
        let mut rest: Vec<&[CollisionRecord]> = lists.iter().map(|list| list.collisions.as_slice()).collect();
        let order = |a: &CollisionRecord, b: &CollisionRecord| a.time.total_cmp(&b.time).then(a.id.cmp(&b.id));
        loop {
            let heads = rest.iter().enumerate().filter_map(|(k, list)| list.first().map(|head| (k, head)));
            let Some((k, head)) = heads.min_by(|(_, a), (_, b)| order(a, b)) else { return };
            // all collisions of this list that come before the first collision of every other list
            let others = rest.iter().enumerate().filter(|(other, _)| *other != k);
            let next = others.filter_map(|(_, list)| list.first()).min_by(|a, b| order(a, b));
            let is_before = |one: &CollisionRecord| next.is_none_or(|next| order(one, next) == Ordering::Less);
            let count = rest[k].iter().take_while(|one| std::ptr::eq(*one, head) || is_before(one)).count();
            let (now, later) = rest[k].split_at(count);
            for one in now {
                one.amounts.add_to(&mut log.ledger);
                collisions += 1;
                if is_full(collisions) {
                    record.absorb(log);
                }
            }
            rest[k] = later;
        }
    }
}

impl Amounts {
    #[inline]
    fn add_to(&self, total: &mut Ledger) {
        match self {
            Self::Pair(virial, restitution_loss, friction_loss) => {
                total.pair_virial += virial;
                total.pair_restitution_loss += restitution_loss;
                total.pair_friction_loss += friction_loss;
            }
            Self::Any(ledger) => *total += **ledger,
        }
    }
}
