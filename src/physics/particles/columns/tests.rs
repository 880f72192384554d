//! Tests that each operation of a particle store includes every column.

use super::*;
use crate::particles::values::AsNumbers;
use nalgebra::Vector3;

columns! {
    /// Moving state of a rod.
    pub struct RodMotion;

    /// Moving state of several rods.
    pub struct RodChunk;

    /// A store of test particles (rods) with an optional column.
    #[derive(Clone, Debug, Default, PartialEq)]
    pub struct Rods {
        pub position: Vec<Vector3<f64>> => ["x", "y", "z"] as moving,
        /// [m] length of each rod.
        pub length: Vec<f64>,
        pub spin: Option<Vec<Vector3<f64>>> => ["wx", "wy", "wz"] as moving by kicks,
    }
}

fn three(spinning: bool) -> Rods {
    let mut rods = Rods { spin: spinning.then(Vec::new), ..Rods::default() };
    for k in 0..3 {
        rods.grow();
        rods.length[k] = k as f64;
        let numbers = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0].map(|n| n + 10.0 * k as f64);
        rods.set_state(k, &numbers);
    }
    rods
}

#[test]
fn every_operation_reaches_every_column() {
    let mut rods = three(true);
    assert_eq!(rods.state_names(), ["x", "y", "z", "wx", "wy", "wz"]);
    rods.reorder(&[2, 0, 1]);
    assert_eq!(rods.length, [2.0, 0.0, 1.0]);
    assert_eq!(rods.state_numbers(0), [21.0, 22.0, 23.0, 24.0, 25.0, 26.0]);
    let mut copy = Rods { spin: Some(Vec::new()), ..Rods::default() };
    copy.copy_from(&rods, &[1, 1]);
    assert_eq!(copy.state_numbers(1), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!((copy.length.len(), copy.spin.as_ref().map(Vec::len)), (2, Some(2)));
    assert!(copy.is_whole(2) && !copy.is_whole(3));
    let mut sent = Rods::default();
    let packed = |rods: &Rods, indices: &[u32]| {
        let mut bytes = Vec::new();
        rods.pack(indices, &mut bytes);
        bytes
    };
    let bytes = packed(&copy, &[0, 1]);
    assert_eq!((sent.unpack(&bytes), &sent), (Some(()), &copy));
    assert_eq!(sent.clone().unpack(&bytes[1..]), None);
    assert_eq!(sent.clone().unpack(&bytes[..bytes.len() - 1]), None);
    assert_eq!((sent.unpack(&packed(&rods, &[2])), sent.length.as_slice()), (Some(()), &[0.0, 0.0, 1.0][..]));
    assert_eq!(sent.state_numbers(2), rods.state_numbers(2));
    sent.relocate(&[(2, 0)]);
    assert_eq!((sent.length.as_slice(), sent.state_numbers(0)), (&[1.0, 0.0, 1.0][..], rods.state_numbers(2)));
    let room = |rods: &Rods| {
        let spin = rods.spin.as_ref().map_or(0, Vec::capacity);
        [rods.position.capacity(), rods.length.capacity(), spin]
    };
    sent.reserve(100);
    assert!(room(&sent).iter().all(|room| *room >= 103) && sent.is_whole(3));
    sent.shrink();
    assert!(room(&sent).iter().all(|room| *room < 103) && sent.length == [1.0, 0.0, 1.0]);
    let mut first = copy.clone();
    first.truncate(1);
    assert!(first.is_whole(1));
    copy.spin = Some(Vec::new());
    assert!(!copy.is_whole(2), "a column too short");
    copy.clear();
    assert_eq!((copy.position.len(), copy.length.len(), copy.spin), (0, 0, Some(Vec::new())));
}

/// Checks that every operation on values that change with time includes an optional column marked `as moving`.
#[test]
fn what_moves_is_taken_put_sent_kept_and_checked_whole() {
    let (mut rods, numbers) = (three(true), |rods: &Rods, k| {
        let mut numbers = Vec::new();
        rods.for_each_moving_number(k, &mut |number| numbers.push(number));
        numbers
    });
    assert_eq!(numbers(&rods, 1), [11.0, 12.0, 13.0, 14.0, 15.0, 16.0]);
    let second = rods.motion(1);
    assert_eq!(second.spin, Vector3::new(14.0, 15.0, 16.0));
    rods.set_motion(2, &second);
    assert_eq!((rods.motion(2), rods.length[2]), (second, 2.0));
    let (mut all, mut kicked) = (Vec::new(), Vec::new());
    rods.pack_motion(2, &mut all);
    rods.pack_kicked(2, &mut kicked);
    assert_eq!((all.len(), kicked.len()), (48, 24));
    let before = rods.clone();
    let mut chunks = rods.motion_chunks(2);
    chunks[1].set(0, &RodMotion::default());
    assert_eq!((chunks.len(), rods.motion(1), rods.motion(2)), (2, second, RodMotion::default()));
    rods.clone_from(&before);
    assert_eq!(rods.unpack_motion(0, &all), Some(&[][..]));
    assert_eq!(rods.motion(0), second);
    assert_eq!(rods.unpack_kicked(0, &kicked[1..]), None);
    rods = before.clone();
    rods.unpack_kicked(0, &kicked).unwrap();
    assert_eq!((rods.motion(0).position, rods.motion(0).spin), (before.motion(0).position, second.spin));
    let mut kept = Rods::default();
    rods.keep_kicked(&mut kept);
    rods.spin.iter_mut().flatten().for_each(|spin| *spin *= 2.0);
    rods.take_back(&mut kept);
    assert_eq!((rods.motion(0).spin, rods.motion(2)), (second.spin, before.motion(2)));
}

#[test]
fn a_store_takes_over_columns_that_it_lacks() {
    let (mut still, turning) = (three(false), three(true));
    still.copy_from(&turning, &[2]);
    assert!(still.is_whole(4));
    assert_eq!((still.motion(0).spin, still.motion(3)), (Vector3::zeros(), turning.motion(2)));
    let mut other = three(true);
    other.copy_from(&three(false), &[0]);
    assert!(other.is_whole(4) && other.motion(3).spin == Vector3::zeros());
}

#[test]
fn a_column_that_is_not_needed_is_not_there() {
    let mut rods = three(false);
    assert_eq!(rods.state_names(), ["x", "y", "z"]);
    rods.reorder(&[1, 2, 0]);
    assert_eq!(rods.state_numbers(2), [1.0, 2.0, 3.0]);
    let mut copy = Rods::default();
    copy.copy_from(&rods, &[0, 2]);
    rods.clear();
    assert_eq!((rods.spin, copy.spin, copy.length), (None, None, vec![1.0, 0.0]));
}
