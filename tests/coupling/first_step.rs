//! Pressure drop of the gas before the first step of a run with two-way coupling, and steadiness of the gas without
//! particles.

use crate::support::close;
use diptych::fluid::{ChannelFlow, Coupling, HeldFlow, LoadedFlow, Modulation, SliceSums, TurbulenceModel};

/// Before the first step the pressure drop is that of the gas alone or, if the case prescribes a pressure gradient,
/// the prescribed one. In a pipe the walls have twice the area per volume that they have in a channel.
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

/// The slices in which particles are summed may have borders in common with the cells of the gas, up to rounding. For
/// any number of slices, the gas without particles stays as it is.
#[test]
fn any_number_of_slices_fits_the_cells_of_the_gas() {
    let alone = ChannelFlow::solve(15.75, 0.04, 1.5e-5, TurbulenceModel::WallFunctions).unwrap();
    let wanted = alone.pressure_gradient(1.2);
    for slices in 1..400 {
        let coupling = Coupling { slices, held: HeldFlow::FlowRate, modulation: Modulation::None };
        let mut loaded = LoadedFlow::new(coupling, &alone, 1.2, 1.0);
        loaded.advance(1e-3, &vec![SliceSums::default(); slices]);
        // the gas alone is steady, up to the error of the iteration that found it
        close(&format!("{slices} slices"), loaded.pressure_gradient(), wanted, 1e-6 * wanted);
    }
}
