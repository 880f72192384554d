//! Standard k-epsilon model with equilibrium wall functions (Launder and Spalding 1974). In wall units lengths are in
//! units of ν/u_τ and velocities in units of the friction velocity u_τ. U+ and y+ are the velocity and the distance
//! from the wall in these units.

use super::half_channel::{Equation, HalfChannel, SweepStep, WallCondition};
use super::k_epsilon::{C_1, C_2, C_MU, SIGMA_EPSILON, SIGMA_K};
use super::table::VelocityTable;

/// [-] von Kármán's constant κ. It is used together with E = 9.0 in U+ = ln(E y+)/κ, so that the constant of the
/// logarithmic law is B = ln(E)/κ = 5.36. `docs/theory/gas.md` lists other pairs of constants.
pub(super) const KAPPA: f64 = 0.41;
/// [-] constant E in U+ = ln(E y+)/κ on a smooth wall, used together with κ = 0.41.
const E: f64 = 9.0;
/// [-] distance y+ of the edge of the viscous sublayer in the two-layer law of the wall. The root of y+ = ln(E y+)/κ,
/// at which both layers have the same velocity, is 11.266; at this number the velocities differ by 0.3 %.
const SUBLAYER: f64 = 11.225_301;

/// [-] lowest bulk Reynolds number of the model. At lower values a half channel has no room for a logarithmic layer and
/// an outer layer of 5 cells.
pub(super) const LOWEST_REYNOLDS: f64 = 10_000.0;
/// [-] intended distance y+ of the first grid node from the wall, in the middle of the range in which the result does
/// not depend on this distance.
const FIRST_NODE: f64 = 30.0;
/// Largest number of cells. This number limits the grid for Re_τ > 3600: the first node is then above `FIRST_NODE`, but
/// within 1 % of the half height h from the wall.
const MOST_CELLS: usize = 60;

/// [-] weight of the newly computed turbulent kinetic energy and dissipation rate in the next iterate; the previous
/// values have the remaining weight.
const RELAXATION: f64 = 0.7;
/// Number of intervals between the edge of the viscous sublayer and the first grid node. The profile follows the
/// logarithmic law at their ends.
const LAW_POINTS: usize = 24;
/// Number of intervals into which points of the profile divide the distance between two neighbouring grid nodes.
const PARTS: usize = 8;

/// Number of cells over the half channel for a given friction Reynolds number.
pub(super) fn cells(reynolds_tau: f64) -> usize {
    ((reynolds_tau / (2.0 * FIRST_NODE)).round() as usize).clamp(4, MOST_CELLS)
}

/// Faces between cells of equal width, as distances from the wall over the half height h of the channel, from 0 to 1.
pub(super) fn faces(cells: usize) -> Vec<f64> {
    (0..=cells).map(|face| face as f64 / cells as f64).collect()
}

/// [-] velocity scale u* = C_μ^(1/4) k_P^(1/2) of the wall cell, where k_P is the turbulent kinetic energy in this
/// cell.
fn scale(channel: &HalfChannel) -> f64 {
    C_MU.powf(0.25) * channel.k[0].sqrt()
}

/// [-] production ν_t (dU/dy)² of turbulent kinetic energy in a cell, with the eddy viscosity ν_t and the mean
/// velocity U. In the wall cell it is τ_w²/(κ u* y), with the wall stress τ_w and the velocity scale u*. All in wall
/// units.
pub(super) fn production(channel: &HalfChannel, cell: usize) -> f64 {
    if cell == 0 {
        channel.wall_stress().powi(2) / (KAPPA * scale(channel) * channel.y[0])
    } else {
        channel.nu_t[cell] * channel.shear(cell).powi(2)
    }
}

/// Updates the flow of a gas without particles once: mean velocity U, turbulent kinetic energy k, dissipation rate ε
/// and eddy viscosity ν_t. Returns the largest relative change [-] of k and ε.
pub(super) fn sweep(channel: &mut HalfChannel) -> f64 {
    channel.integrate_momentum(law(channel, channel.y[0]));
    let none = vec![0.0; channel.k.len()];
    sweep_turbulence(channel, &SweepStep { relaxation: RELAXATION, rate: 0.0, damping: (&none, 0.0), produced: &[] })
}

/// Updates the turbulent kinetic energy k, the dissipation rate ε and the eddy viscosity ν_t once, by one iteration or
/// one time step. Returns the largest relative change [-] of k and ε.
pub(super) fn sweep_turbulence(channel: &mut HalfChannel, step: &SweepStep) -> f64 {
    let count = channel.k.len();
    let (damping, factor) = step.damping;
    let p: Vec<f64> = (0..count).map(|i| production(channel, i)).collect();
    let frequency: Vec<f64> = (0..count).map(|i| channel.epsilon[i] / channel.k[i]).collect();
    let sink: Vec<f64> = (0..count).map(|i| frequency[i] + step.rate + damping[i]).collect();
    let source: Vec<f64> = (0..count).map(|i| p[i] + step.produced_in(i) + step.rate * channel.k[i]).collect();
    let mut k = channel.k.clone();
    let equation = Equation { prandtl: SIGMA_K, sink: &sink, source: &source, wall: WallCondition::Insulated };
    let mut change = channel.solve(&equation, step.relaxation, &mut k);

    let sink: Vec<f64> = (0..count).map(|i| C_2 * frequency[i] + step.rate + factor * damping[i]).collect();
    let source: Vec<f64> = (0..count).map(|i| C_1 * frequency[i] * p[i] + step.rate * channel.epsilon[i]).collect();
    channel.k = k;
    // equilibrium of production and dissipation in the wall cell: ε = u*³/(κ y)
    let wall = WallCondition::FirstCell(scale(channel).powi(3) / (KAPPA * channel.y[0]));
    let mut epsilon = channel.epsilon.clone();
    let equation = Equation { prandtl: SIGMA_EPSILON, sink: &sink, source: &source, wall };
    change = change.max(channel.solve(&equation, step.relaxation, &mut epsilon));
    channel.epsilon = epsilon;

    renew_viscosity(channel);
    change
}

/// Computes the eddy viscosity of every cell from the turbulent kinetic energy and its dissipation rate.
pub(super) fn renew_viscosity(channel: &mut HalfChannel) {
    for i in 0..channel.k.len() {
        channel.nu_t[i] = C_MU * channel.k[i].powi(2) / channel.epsilon[i];
    }
}

/// [-] velocity U at the distance `y` from the wall, by the two-layer law of the wall, in wall units: τ_w y below the
/// edge of the viscous sublayer, and τ_w/(κ u*) ln(E u* y) above, with the wall stress τ_w and the velocity scale u*.
fn law(channel: &HalfChannel, y: f64) -> f64 {
    channel.wall_stress() * velocity_per_stress(channel, y)
}

/// Velocity U divided by the stress at the wall τ_w, at the distance `y` from the wall in wall units, by the two-layer
/// law of the wall.
pub(super) fn velocity_per_stress(channel: &HalfChannel, y: f64) -> f64 {
    let scale = scale(channel);
    if y * scale < SUBLAYER { y } else { (E * scale * y).ln() / (KAPPA * scale) }
}

/// Velocity profile U(y) as points (y, U) in wall units. Up to the first node the profile is the law of the wall. From
/// there to the centre plane it is a monotone cubic in ln y through the nodes. A cubic in y would not follow the
/// logarithm between the first two nodes.
///
/// # Errors
///
/// A velocity of the solution that is not finite.
pub(super) fn profile(channel: &HalfChannel) -> Result<Vec<(f64, f64)>, String> {
    let first = channel.y[0];
    let edge = (SUBLAYER / scale(channel)).min(0.9 * first);
    // the linear part of the law needs points only near its edge, where the logarithmic part begins
    let sublayer = [0.0, 0.5, 0.9, 1.0].map(|part| part * edge);
    let step = (first / edge).powf(1.0 / LAW_POINTS as f64);
    let logarithm = (1..LAW_POINTS).map(|i| edge * step.powi(i as i32));
    let mut profile: Vec<_> = sublayer.into_iter().chain(logarithm).map(|y| (y, law(channel, y))).collect();

    let mut y = channel.y.clone();
    y.push(channel.reynolds_tau);
    let centre = channel.centre_velocity();
    let nodes: Vec<_> = y.iter().zip(channel.u.iter().chain([&centre])).map(|(y, u)| (y.ln(), *u)).collect();
    // The slope dU/d(ln y) at the first node is that of the law of the wall, τ_w/(κ u*).
    let slope = channel.wall_stress() / (KAPPA * scale(channel));
    let table = VelocityTable::with_end_slopes(&nodes, [Some(slope), Some(0.0)])?;
    for (pair, nodes) in y.windows(2).zip(nodes.windows(2)) {
        profile.push((pair[0], nodes[0].1));
        profile.extend((1..PARTS).map(|part| {
            let y = pair[0] + (pair[1] - pair[0]) * part as f64 / PARTS as f64;
            (y, table.value(y.ln()))
        }));
    }
    profile.push((channel.reynolds_tau, centre));
    Ok(profile)
}
