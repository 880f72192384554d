//! Half-kicks for observers, which the run takes back.

use super::{CHANNEL, begin};
use crate::support::case;
use diptych::experiment::Model;
use diptych::schedule::Schedule;

/// A half-kick for observers in which the gas is no longer finite is taken back, with the refusal of the next window.
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
