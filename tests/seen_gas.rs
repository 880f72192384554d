//! The gas that particles see, as a measurement.

use crate::support::{case, close, experiment};
use crate::turbulence::{BEAD, homogeneous};
use diptych::experiment::Model;
use diptych::observe::{Measurement, Observer, SeenGas};
use diptych::placement::initial_state;
use diptych::schedule::Schedule;
use diptych::simulation::Simulation;

/// The measurement `[observe.seen_gas]` of one state is the plain mean over the particles of each slice. In
/// homogeneous turbulence the gas that particles see has the variance of the gas. Its covariance with the particle
/// velocity is the share given by Tchen, within four standard errors.
#[test]
fn the_gas_that_particles_see_is_measured() {
    let count = 6000;
    let mut asked = experiment(homogeneous(1.0, 0.0, 0.0), count, [0.0; 3], 0.5_f64.sqrt(), Model::Hard, 3);
    asked.statistics.slices = 2;
    let mut simulation = Simulation::new(&asked, initial_state(&asked).unwrap());
    simulation.run(100, 0.05).unwrap();
    simulation.end();
    let mut measurement = SeenGas::new(&asked, &Schedule::new(&asked));
    measurement.see(&simulation);
    let found = measurement.result(&asked, 0.0);
    let state = simulation.state();
    let eddies = state.eddies.as_ref().unwrap();
    for slice in 0..2 {
        let own: Vec<usize> = (0..count).filter(|&i| (state.position[i].y >= 500.0) == (slice == 1)).collect();
        let mean = |of: &dyn Fn(usize) -> f64| own.iter().map(|&i| of(i)).sum::<f64>() / own.len() as f64;
        let wanted = [
            mean(&|i| eddies[i].z),
            mean(&|i| eddies[i].y),
            mean(&|i| eddies[i].z.powi(2)),
            mean(&|i| eddies[i].y.powi(2)),
            mean(&|i| eddies[i].x.powi(2)),
            1.0,
            mean(&|i| eddies[i].dot(&state.velocity[i]) / 3.0),
        ];
        assert_eq!(found.curves.len(), wanted.len());
        for (curve, wanted) in found.curves.iter().zip(wanted) {
            // rounding of sums of some thousand numbers
            close(&curve.quantity.column, curve.values[slice].unwrap().value, wanted, 1e-11);
        }
        let error = 4.0 * (2.0 / own.len() as f64).sqrt();
        close("variance seen", found.curves[2].values[slice].unwrap().value, 1.0, error);
        close("covariance", found.curves[6].values[slice].unwrap().value, 0.5, error);
    }
    let table = BEAD.replace("[run]", "[observe.seen_gas]\n[run]");
    assert!(case(&table, Model::Hard, &[]).unwrap().observe.seen_gas);
    let (first, rest) = table.split_once("[fluid.turbulence]").unwrap();
    let (_, last) = rest.split_once("[fluid.turbulence.langevin]\n").unwrap();
    let told = case(&format!("{first}{last}"), Model::Hard, &[]).unwrap_err();
    assert!(told.contains("needs a gas whose fluctuations particles see"), "{told}");
}
