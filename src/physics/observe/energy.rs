//! Energy balance of a run: the change of energy minus the work and the losses in the ledger. The ledger (`Ledger`)
//! contains the sums of all work and losses since the start. A sample is an instant at which measurements are taken.

use super::{Needs, Observer, plain_data};
use crate::simulation::Simulation;
use crate::statistics::{Estimate, estimate};
use serde::{Deserialize, Serialize};

/// Energy of all particles at the start and the end of a run, and the unexplained energy at every sample (instant of
/// measurement). The unexplained energy is the change of energy minus the work and losses in the ledger, which holds
/// the sums of all work and losses.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct EnergyBooks {
    /// [J] kinetic, rotational and elastic energy of all particles at the start of the run.
    pub at_start: f64,
    /// [J] kinetic, rotational and elastic energy of all particles at the end of the run.
    pub at_end: f64,
    /// [J] unexplained energy at the end: change of energy since the start minus the work and losses in the ledger.
    unexplained: f64,
    /// [s] simulated time of the latest sample (instant of measurement).
    seen: f64,
    /// [J] unexplained energy at every sample (instant of measurement): change of energy since the start minus work
    /// and losses.
    samples: Vec<f64>,
}

impl EnergyBooks {
    /// [J] unexplained energy of the whole run: change of energy minus work and losses. Its standard error follows
    /// from the scatter of the changes of the unexplained energy between successive samples (instants of measurement).
    pub fn residual(&self) -> Estimate {
        let steps: Vec<f64> = self.samples.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let error = estimate(&steps).and_then(|step| step.error);
        Estimate { value: self.unexplained, error: error.map(|error| error * steps.len() as f64) }
    }
}

impl Observer for EnergyBooks {
    fn needs(&self) -> Needs {
        Needs::Sums
    }

    fn see(&mut self, simulation: &Simulation) {
        let energy = simulation.energy();
        if self.samples.is_empty() {
            self.at_start = energy;
        }
        let unexplained = simulation.record.ledger.residual(self.at_start, energy);
        self.samples.push(unexplained);
        (self.seen, self.at_end, self.unexplained) = (simulation.time, energy, unexplained);
    }

    fn end(&mut self, simulation: &Simulation) {
        if self.samples.is_empty() || self.seen != simulation.time {
            self.at_end = simulation.energy();
            self.unexplained = simulation.record.ledger.residual(self.at_start, self.at_end);
        }
    }

    plain_data!();
}
