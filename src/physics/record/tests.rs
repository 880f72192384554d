use super::*;
use crate::scene::Kind;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Made-up impacts of two species and a wall, with speeds over six orders of magnitude, and the ledger of each impact.
fn happened(count: usize) -> Vec<(Between, Impact, Ledger)> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    let others = [Kind::Species(0), Kind::Species(1), Kind::Wall(0)];
    let one = |k: usize| {
        let normal_speed = 10.0_f64.powf(random.random_range(-5.0..1.0));
        let rebound_speed = random.random::<f64>() * normal_speed;
        let overlap = 1e-3 * normal_speed;
        let left_out = (k.is_multiple_of(5)).then_some(LeftOut { duration: 3e-5 * rebound_speed, overlap });
        let impact = Impact {
            normal_speed,
            rebound_speed,
            duration: if k.is_multiple_of(2) { 1e-5 } else { 0.0 },
            first_overlap: 0.1 * overlap,
            maximum_overlap: overlap,
            overlap_time: 1e-5 * overlap,
            left_out,
            slip: k
                .is_multiple_of(3)
                .then(|| SlipChange::new([normal_speed, -rebound_speed], rebound_speed, normal_speed)),
        };
        let loss = normal_speed * normal_speed - rebound_speed * rebound_speed;
        let ledger =
            Ledger { pair_restitution_loss: loss, drag_work: random.random::<f64>() - 0.5, ..Ledger::default() };
        (Between::of(1, others[k % 3]), impact, ledger)
    };
    (0..count).map(one).collect()
}

/// Makes the record of the given impacts, added in logs of `per_log` impacts.
fn record(happened: &[(Between, Impact, Ledger)], per_log: usize) -> Record {
    let mut record = Record::default();
    for some in happened.chunks(per_log) {
        let impacts = some.iter().map(|(between, impact, _)| (*between, *impact)).collect();
        let islands = some[1..].iter().map(|(.., ledger)| ledger.to_array()).collect();
        record.absorb(&mut Log { impacts, ledger: some[0].2, islands });
    }
    record
}

#[test]
fn a_record_does_not_depend_on_the_order_of_impacts_nor_on_who_counted_them() {
    // so many impacts that a log of all impacts is divided among threads
    let mut all = happened(9000);
    let whole = record(&all, 100);
    assert_eq!((whole.pairs.count, whole.walls.count, whole.pairs.instants.count), (6000, 3000, 1200));
    for (seed, per_log) in [(1, 1), (2, 7), (3, 9000)] {
        all.shuffle(&mut Xoshiro256PlusPlus::seed_from_u64(seed));
        assert!(record(&all, per_log) == whole, "{per_log} at a time");
        let mut merged = Record::default();
        for part in all.chunks(800).rev() {
            merged.merge(&record(part, per_log));
        }
        assert!(merged == whole, "merged, {per_log} at a time");
        assert_eq!(merged.kinds.totals(), whole.kinds.totals());
        assert_eq!(*merged.ledger, *whole.ledger);
    }
    // the impacts since the end of the first half equal those of a record of the second half alone, except for the
    // width of bins
    let half = record(&all[..4500], 100);
    let late = record(&all[4500..], 100).pairs;
    let since = whole.pairs.since(&half.pairs);
    assert_eq!(
        (since.count, since.rebound_squares(), since.normal_speed.sum(), since.instants.duration()),
        (late.count, late.rebound_squares(), late.normal_speed.sum(), late.instants.duration())
    );
}

#[test]
fn bins_are_as_wide_as_the_largest_value_needs() {
    for values in
        [vec![1.0, 3.0, 511.0], vec![2.0_f64.powi(9).next_down(), 1e-9], vec![0.0, 512.0], vec![5e-324, 1e-310]]
    {
        let (mut up, mut down) = (Histogram::default(), Histogram::default());
        values.iter().for_each(|&value| up.add(value));
        values.iter().rev().for_each(|&value| down.add(value));
        assert!(up == down, "{values:?}");
        let width = if up.maximum < 1e-300 {
            f64::MIN_POSITIVE
        } else if up.maximum < 512.0 {
            1.0
        } else {
            2.0
        };
        assert_eq!(up.width, width, "{values:?}");
    }
}
