//! Low-Reynolds-number k-epsilon model (Launder and Sharma 1974), whose grid resolves the flow down to the wall. Its
//! equations are those of the turbulent kinetic energy k and of ε̃, a dissipation rate that is reduced so that it
//! vanishes at the wall. In wall units lengths are in units of ν/u_τ and velocities in units of the friction velocity
//! u_τ.

use super::half_channel::{Equation, HalfChannel, SweepStep, WallCondition};
use super::k_epsilon::{C_1, C_2, C_MU, SIGMA_EPSILON, SIGMA_K};

/// Number of cells over the half channel. Twice as many cells change u_τ by less than 0.1 %.
pub(super) const CELLS: usize = 240;
/// [-] distance y+ of the centre of the first cell from the wall, for `CELLS` cells.
const FIRST_NODE: f64 = 0.05;
/// [-] weight of the newly computed turbulent kinetic energy and dissipation rate in the next iterate; the previous
/// values have the remaining weight.
const RELAXATION: f64 = 0.7;

/// Faces between the cells of the grid, as distances from the wall over the half height h of the channel, from 0 to 1.
/// Each cell is wider than the one before by a constant factor. The width of the first cell is inversely proportional
/// to `cells`.
pub(super) fn faces(cells: usize, reynolds_tau: f64) -> Vec<f64> {
    let first = 2.0 * FIRST_NODE / reynolds_tau * CELLS as f64 / cells as f64;
    let sum = |growth: f64| (growth.powi(cells as i32) - 1.0) / (growth - 1.0);
    // bisection for the growth factor at which the widths add up to h; only about a dozen cells or fewer need above 2
    let (mut low, mut high) = (1.0 + 1e-9, 2.0);
    while first * sum(high) < 1.0 {
        high *= 2.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if first * sum(middle) < 1.0 { low = middle } else { high = middle }
    }
    let mut faces: Vec<f64> = (0..=cells).map(|face| first * (low.powi(face as i32) - 1.0) / (low - 1.0)).collect();
    faces[cells] = 1.0;
    faces
}

/// [-] production ν_t (dU/dy)² of turbulent kinetic energy in a cell, in wall units, with the eddy viscosity ν_t and
/// the mean velocity U.
pub(super) fn production(channel: &HalfChannel, cell: usize) -> f64 {
    channel.nu_t[cell] * channel.shear(cell).powi(2)
}

/// [-] difference D = 2 ν (d√k/dy)² between the dissipation rate ε and the reduced rate ε̃, in wall units, with the
/// turbulent kinetic energy k. With this difference ε̃ = 0 at the wall.
pub(super) fn wall_dissipation(channel: &HalfChannel, cell: usize) -> f64 {
    let slope = |face: usize| match face {
        0 => channel.k[0].sqrt() / channel.y[0],
        _ if face == channel.k.len() => 0.0,
        _ => (channel.k[face].sqrt() - channel.k[face - 1].sqrt()) / (channel.y[face] - channel.y[face - 1]),
    };
    slope(cell).powi(2) + slope(cell + 1).powi(2)
}

/// [-] source E = 2 ν ν_t (d²U/dy²)² of the reduced dissipation rate ε̃ in the buffer layer near the wall, in wall
/// units, with the eddy viscosity ν_t and the mean velocity U.
fn buffer_source(channel: &HalfChannel, cell: usize) -> f64 {
    let shear = |face: usize| match face {
        0 => channel.wall_stress(),
        _ if face == channel.k.len() => 0.0,
        _ => channel.stress_at_face(face) / (1.0 + channel.face_nu_t(face)),
    };
    let curvature = (shear(cell + 1) - shear(cell)) / (channel.face[cell + 1] - channel.face[cell]);
    2.0 * channel.nu_t[cell] * curvature * curvature
}

/// [-] turbulence Reynolds number Re_t = k²/(ν ε̃) in the cell number `cell`.
fn reynolds_t(channel: &HalfChannel, cell: usize) -> f64 {
    channel.k[cell].powi(2) / channel.epsilon[cell]
}

/// Updates the flow of a gas without particles once: mean velocity U, turbulent kinetic energy k, reduced dissipation
/// rate ε̃ and eddy viscosity ν_t. Returns the largest relative change [-] of k and ε̃.
pub(super) fn sweep(channel: &mut HalfChannel) -> f64 {
    // no slip at the wall: in wall units the stress at the wall is 1, so the velocity of the first cell equals its
    // distance from the wall
    channel.integrate_momentum(channel.y[0]);
    let none = vec![0.0; channel.k.len()];
    sweep_turbulence(channel, &SweepStep { relaxation: RELAXATION, rate: 0.0, damping: (&none, 0.0), produced: &[] })
}

/// Updates the turbulent kinetic energy k, the reduced dissipation rate ε̃ and the eddy viscosity ν_t once, by one
/// iteration or one time step. Returns the largest relative change [-] of k and ε̃.
pub(super) fn sweep_turbulence(channel: &mut HalfChannel, step: &SweepStep) -> f64 {
    let count = channel.k.len();
    let (damping, factor) = step.damping;
    let p: Vec<f64> = (0..count).map(|i| production(channel, i)).collect();
    let frequency: Vec<f64> = (0..count).map(|i| channel.epsilon[i] / channel.k[i]).collect();
    let sink: Vec<f64> = (0..count)
        .map(|i| frequency[i] + wall_dissipation(channel, i) / channel.k[i] + step.rate + damping[i])
        .collect();
    let source: Vec<f64> = (0..count).map(|i| p[i] + step.produced_in(i) + step.rate * channel.k[i]).collect();
    let mut k = channel.k.clone();
    let equation = Equation { prandtl: SIGMA_K, sink: &sink, source: &source, wall: WallCondition::Zero };
    let mut change = channel.solve(&equation, step.relaxation, &mut k);

    // factor f_2 = 1 - 0.3 exp(-Re_t²) of the sink of ε̃: Launder and Sharma 1974
    let destruction = |i: usize| C_2 * (1.0 - 0.3 * (-reynolds_t(channel, i).powi(2)).exp()) * frequency[i];
    let sink: Vec<f64> = (0..count).map(|i| destruction(i) + step.rate + factor * damping[i]).collect();
    let source: Vec<f64> = (0..count)
        .map(|i| C_1 * frequency[i] * p[i] + buffer_source(channel, i) + step.rate * channel.epsilon[i])
        .collect();
    let mut epsilon = channel.epsilon.clone();
    let equation = Equation { prandtl: SIGMA_EPSILON, sink: &sink, source: &source, wall: WallCondition::Zero };
    change = change.max(channel.solve(&equation, step.relaxation, &mut epsilon));

    channel.k = k;
    channel.epsilon = epsilon;
    renew_viscosity(channel, step.relaxation);
    change
}

/// Computes the eddy viscosity of every cell from the turbulent kinetic energy and its reduced dissipation rate. New
/// values have the weight `relaxation` [-], and previous values the remaining weight.
pub(super) fn renew_viscosity(channel: &mut HalfChannel, relaxation: f64) {
    for i in 0..channel.k.len() {
        let reynolds = reynolds_t(channel, i);
        // factor f_μ = exp(-3.4/(1 + Re_t/50)²) of the eddy viscosity: Launder and Sharma 1974
        let damping = (-3.4 / (1.0 + reynolds / 50.0).powi(2)).exp();
        let nu_t = C_MU * damping * reynolds;
        channel.nu_t[i] += relaxation * (nu_t - channel.nu_t[i]);
    }
}

/// Velocity profile U(y) in wall units as points (y, U): the wall, the cell centres and the centre plane.
pub(super) fn profile(channel: &HalfChannel) -> Vec<(f64, f64)> {
    let nodes = channel.y.iter().copied().zip(channel.u.iter().copied());
    [(0.0, 0.0)].into_iter().chain(nodes).chain([(channel.reynolds_tau, channel.centre_velocity())]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that the cells of every grid grow by one factor up to the centre plane, also if they are so few that this
    /// factor is above 2.
    #[test]
    fn cells_grow_by_one_factor() {
        for cells in [2, 4, 6, 8, 12, 240] {
            for reynolds_tau in [190.0, 2000.0, 20_000.0] {
                let faces = faces(cells, reynolds_tau);
                let widths: Vec<f64> = faces.windows(2).map(|pair| pair[1] - pair[0]).collect();
                assert_eq!((widths.len(), faces[0], faces[cells]), (cells, 0.0, 1.0));
                let first = 24.0 / (reynolds_tau * cells as f64);
                assert!((widths[0] / first - 1.0).abs() < 1e-9, "{cells} {reynolds_tau}: {}", widths[0]);
                let growth = widths[1] / widths[0];
                for pair in widths.windows(2) {
                    assert!((pair[1] / pair[0] / growth - 1.0).abs() < 1e-6, "{cells} {reynolds_tau}: {widths:?}");
                }
            }
        }
    }
}
