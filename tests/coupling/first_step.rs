//! Flow of the gas before the first step.

use crate::support::close;
use diptych::fluid::{ChannelFlow, Coupling, HeldFlow, LoadedFlow, Modulation, TurbulenceModel};

/// Before the first step the pressure drop is that of the gas alone, or the one that is held. In a pipe the walls have
/// twice the area per volume that they have in a channel.
#[test]
fn before_the_first_step_the_pressure_drop_is_that_of_the_gas_alone() {
    let channel = ChannelFlow::solve(15.75, 0.04, 1.5e-5, TurbulenceModel::LaunderSharma).unwrap();
    let pipe = ChannelFlow::solve_pipe(15.75, 0.04, 1.5e-5, None).unwrap();
    for alone in [channel, pipe] {
        let gradient = |held| {
            let coupling = Coupling { slices: 7, held, modulation: Modulation::None };
            LoadedFlow::new(coupling, &alone, 1.2, 1.0).pressure_gradient()
        };
        let wanted = alone.pressure_gradient(1.2);
        close("of the gas alone", gradient(HeldFlow::FlowRate), wanted, 1e-12 * wanted);
        close("held", gradient(HeldFlow::PressureGradient(50.0)), 50.0, 1e-12);
    }
}
