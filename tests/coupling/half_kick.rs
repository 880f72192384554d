//! Half-kicks (changes of velocity by drag in half a window) that are made for an observer, and taken back before the
//! run continues.

use super::{CHANNEL, begin};
use crate::support::case;
use diptych::experiment::Model;
use diptych::schedule::Schedule;

/// A half-kick for an observer makes the velocity of the gas infinite or NaN. The run takes this half-kick back and
/// continues without a failure.
#[test]
fn a_gas_that_only_an_observer_saw_fail_goes_on() {
    let experiment = case(&CHANNEL.replace("schiller_naumann", "stokes"), Model::Hard, &[]).unwrap();
    let window = Schedule::new(&experiment).window;
    let mut simulation = begin(&experiment);
    simulation
        .run_while(2, window, &mut |simulation, _| {
            simulation.with_synchronised_velocities(f64::NAN, |_| ());
            true
        })
        .unwrap();
}
