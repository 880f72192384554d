//! Fully developed turbulent channel flow by the k-epsilon model: the velocity profile for a given bulk velocity.
//!
//! In a steady, fully developed channel of half width h, the pressure gradient alone determines the total shear stress
//! over the density, (ν + ν_t) dU/dy = u_τ² (1 - y/h). Here U is the mean velocity, u_τ the friction velocity, and ν_t
//! the eddy viscosity. The momentum equation is therefore integrated directly. Only the turbulent kinetic energy k and
//! its dissipation rate ε are iterated. All equations are solved in wall units (lengths in ν/u_τ, velocities in u_τ),
//! on a finite-volume grid of a half channel. The friction Reynolds number is adjusted until the flow has the required
//! bulk velocity.

use super::half_channel::{HalfChannel, SweepStep};
use super::table::VelocityTable;
use super::{launder_sharma, wall_functions};
use serde::{Deserialize, Serialize};

/// [-] constant C_μ in the eddy viscosity ν_t = C_μ k²/ε: Launder and Spalding 1974.
pub(super) const C_MU: f64 = 0.09;
/// [-] constant C_1 of the production of the dissipation rate ε: Launder and Spalding 1974.
pub(super) const C_1: f64 = 1.44;
/// [-] constant C_2 of the destruction of the dissipation rate ε: Launder and Spalding 1974.
pub(super) const C_2: f64 = 1.92;
/// [-] turbulent Prandtl number σ_k of the turbulent kinetic energy k: Launder and Spalding 1974.
pub(super) const SIGMA_K: f64 = 1.0;
/// [-] turbulent Prandtl number σ_ε of the dissipation rate ε: Launder and Spalding 1974.
pub(super) const SIGMA_EPSILON: f64 = 1.3;

/// [-] bulk Reynolds number U_b 2h/ν below which a channel is not fully turbulent: lower end of Dean's data (1978).
const TURBULENT: f64 = 6000.0;
/// [-] relative accuracy with which the required bulk velocity is reached, far below the error of 1e-4 that is stated
/// in reports.
const BULK_TOLERANCE: f64 = 1e-10;
/// [-] largest relative change of k and ε in a sweep (one update of both in all cells), below which the iteration ends.
const SWEEP_TOLERANCE: f64 = 1e-11;
/// Largest number of sweeps, each of which updates k and ε in all cells once. Most flows need some hundreds of sweeps.
const SWEEPS: usize = 20_000;
/// Largest number of corrections of the friction Reynolds number. Most flows need about ten corrections.
const CORRECTIONS: usize = 60;
/// [-] exponent of Re_τ ~ Re^0.875 in Dean's correlation (1978), with which Re_τ is corrected for the required bulk
/// velocity.
const DEAN_EXPONENT: f64 = 0.875;

/// Cross-section of the gas flow: channel or pipe.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Section {
    /// Gas between two parallel walls.
    Channel,
    /// Gas within a round pipe.
    Pipe,
}

/// Turbulence model, which determines how the flow near the wall is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TurbulenceModel {
    /// Standard k-ε model with equilibrium wall functions (Launder and Spalding 1974), which the paper
    /// (`docs/paper.md`) uses. The first grid node lies in the logarithmic layer. Between the wall and this node, the
    /// law of the wall replaces the equations. The model requires Re >= 10 000.
    WallFunctions,
    /// Low-Reynolds-number k-ε model (Launder and Sharma 1974), resolved down to the wall. The model requires Re >=
    /// 6000.
    LaunderSharma,
}

impl TurbulenceModel {
    /// Updates the turbulence of a flow (k, ε and the eddy viscosity) once, by one step in time or one iteration of
    /// the steady equations. Returns the largest relative change [-] of k and ε.
    pub(super) fn sweep_turbulence(self, channel: &mut HalfChannel, step: &SweepStep) -> f64 {
        match self {
            Self::WallFunctions => wall_functions::sweep_turbulence(channel, step),
            Self::LaunderSharma => launder_sharma::sweep_turbulence(channel, step),
        }
    }

    /// Computes the eddy viscosity of every cell from the turbulent kinetic energy and its dissipation rate.
    pub(super) fn renew_viscosity(self, channel: &mut HalfChannel) {
        match self {
            Self::WallFunctions => wall_functions::renew_viscosity(channel),
            Self::LaunderSharma => launder_sharma::renew_viscosity(channel, 1.0),
        }
    }

    /// Velocity U of the first cell divided by the stress τ_w at the wall, in wall units. The stress at the wall is
    /// then the velocity of the cell divided by this ratio.
    pub(super) fn first_velocity_per_stress(self, channel: &HalfChannel) -> f64 {
        match self {
            Self::WallFunctions => wall_functions::velocity_per_stress(channel, channel.y[0]),
            Self::LaunderSharma => channel.y[0],
        }
    }

    /// True if the equations of the turbulence are solved down to the wall, where the kinetic energy k is 0.
    pub(super) fn reaches_the_wall(self) -> bool {
        match self {
            Self::WallFunctions => false,
            Self::LaunderSharma => true,
        }
    }

    /// [-] lowest bulk Reynolds number U_b L_y/ν at which the model applies, where L_y is the width of the channel.
    pub fn lowest_reynolds(self) -> f64 {
        match self {
            Self::WallFunctions => wall_functions::LOWEST_REYNOLDS,
            Self::LaunderSharma => TURBULENT,
        }
    }
}

impl std::fmt::Display for TurbulenceModel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::WallFunctions => "k-epsilon with wall functions",
            Self::LaunderSharma => "k-epsilon after Launder and Sharma",
        })
    }
}

/// State of the gas at one distance from the nearer wall (the centre of one grid cell).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GridNode {
    /// [m] distance y from the wall.
    pub y: f64,
    /// [m/s] mean streamwise velocity U at the distance y.
    pub u: f64,
    /// [m²/s²] turbulent kinetic energy k at the distance y.
    pub k: f64,
    /// [m²/s³] dissipation rate ε of the turbulent kinetic energy k. For the Launder-Sharma model it is the full rate,
    /// ε̃ + 2ν (d√k/dy)².
    pub epsilon: f64,
    /// [m²/s] eddy viscosity ν_t at the distance y.
    pub nu_t: f64,
}

/// One half of a symmetric channel flow, from the wall to the centre plane, or of a pipe flow, from the wall to the
/// axis. For a pipe, the width of the channel means the diameter, and the half width h the radius.
#[derive(Clone, Debug, Serialize)]
pub struct ChannelFlow {
    /// Cross-section of the flow: channel or pipe.
    pub section: Section,
    /// Turbulence model with which the flow was solved.
    pub model: TurbulenceModel,
    /// [m] full width 2h of the channel, or diameter of the pipe.
    pub height: f64,
    /// [m²/s] kinematic viscosity ν.
    pub kinematic_viscosity: f64,
    /// [m/s] bulk velocity: mean over the cross-section, including the flow between the wall and the first grid node.
    pub bulk_velocity: f64,
    /// [m/s] velocity on the centre plane, or on the axis of a pipe.
    pub centre_velocity: f64,
    /// [m/s] friction velocity u_τ = sqrt(τ_w/ρ), with the shear stress τ_w at the wall and the density ρ of the gas.
    pub friction_velocity: f64,
    /// [-] friction Reynolds number Re_τ = u_τ h/ν.
    pub reynolds_tau: f64,
    /// State of the gas at the cell centres, from the wall to the centre plane.
    pub nodes: Vec<GridNode>,
    /// Velocity profile U(y) from the wall (0, 0) to the centre plane, as points (y [m], U [m/s]) that include the
    /// nodes. With wall functions it also has points of the law of the wall below the first node, and interpolated
    /// points between nodes.
    pub profile: Vec<(f64, f64)>,
    /// Number of sweeps (updates of k and ε in all cells) for all corrections of Re_τ together.
    pub iterations: usize,
    /// [-] largest relative change of k and ε in the last sweep (update of both in all cells).
    pub residual: f64,
    /// [u_τ³] terms of the balance of turbulent kinetic energy k, integrated over the half channel.
    pub k_budget: KBudget,
    /// Flow in wall units, on the grid of the solver.
    #[serde(skip)]
    half: HalfChannel,
}

/// Balance of turbulent kinetic energy k, integrated over the half channel, in units of u_τ³. Production equals
/// dissipation plus wall flux.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct KBudget {
    /// [-] production of turbulent kinetic energy: ∫ ν_t (dU/dy)² dy over the half channel, with the eddy viscosity
    /// ν_t and the mean velocity U.
    pub production: f64,
    /// [-] dissipation of turbulent kinetic energy: ∫ ε dy over the half channel, with the full dissipation rate ε.
    pub dissipation: f64,
    /// [-] ν dk/dy at the wall: the flux of turbulent kinetic energy k into the wall; 0 with wall functions.
    pub wall_flux: f64,
}

impl ChannelFlow {
    /// Solves the flow with `bulk_velocity` [m/s] through a channel of width `height` [m] with kinematic viscosity
    /// `kinematic_viscosity` [m²/s], on the model's default grid.
    ///
    /// # Errors
    ///
    /// An argument that is not positive and finite, a Reynolds number too low for the model, or no convergence (with
    /// the residual).
    pub fn solve(
        bulk_velocity: f64,
        height: f64,
        kinematic_viscosity: f64,
        model: TurbulenceModel,
    ) -> Result<Self, String> {
        let cells = match model {
            TurbulenceModel::WallFunctions => {
                wall_functions::cells(estimate(bulk_velocity * height / kinematic_viscosity))
            }
            TurbulenceModel::LaunderSharma => launder_sharma::CELLS,
        };
        Self::solve_with_cells(bulk_velocity, height, kinematic_viscosity, model, cells)
    }

    /// Solves the flow as [`ChannelFlow::solve`] does, with a given number of cells over the half channel. It is used
    /// to measure the error of the grid.
    ///
    /// # Errors
    ///
    /// Errors of [`ChannelFlow::solve`], or fewer than 4 cells.
    pub fn solve_with_cells(
        bulk_velocity: f64,
        height: f64,
        kinematic_viscosity: f64,
        model: TurbulenceModel,
        cells: usize,
    ) -> Result<Self, String> {
        Self::through(Section::Channel, [bulk_velocity, height, kinematic_viscosity], model, cells)
    }

    /// Solves the flow with `bulk_velocity` [m/s] through a pipe of `diameter` [m] with kinematic viscosity
    /// `kinematic_viscosity` [m²/s]. The model is that of Launder and Sharma, on `cells` cells along the radius. If
    /// `cells` is `None`, the number is the model's default.
    ///
    /// # Errors
    ///
    /// Errors of [`ChannelFlow::solve_with_cells`].
    pub fn solve_pipe(
        bulk_velocity: f64,
        diameter: f64,
        kinematic_viscosity: f64,
        cells: Option<usize>,
    ) -> Result<Self, String> {
        let cells = cells.unwrap_or(launder_sharma::CELLS);
        let flow = [bulk_velocity, diameter, kinematic_viscosity];
        Self::through(Section::Pipe, flow, TurbulenceModel::LaunderSharma, cells)
    }

    fn through(
        section: Section,
        [bulk_velocity, height, kinematic_viscosity]: [f64; 3],
        model: TurbulenceModel,
        cells: usize,
    ) -> Result<Self, String> {
        let reynolds = bulk_reynolds(bulk_velocity, height, kinematic_viscosity, model)?;
        if cells < 4 {
            return Err(format!("k-epsilon channel: {cells} cells are too few, use 4 or more"));
        }
        let target = 0.5 * reynolds; // U_b h/ν
        let reynolds_tau = estimate(reynolds);
        let faces = match model {
            TurbulenceModel::WallFunctions => wall_functions::faces(cells),
            TurbulenceModel::LaunderSharma => launder_sharma::faces(cells, reynolds_tau),
        };
        let mut channel = HalfChannel::new(section, &faces, reynolds_tau);
        let mut iterations = 0;
        for _ in 0..CORRECTIONS {
            let residual = converge(&mut channel, model, &mut iterations)?;
            let profile = profile(&channel, model)?;
            let table = half_table(&profile)?;
            let carried = match section {
                Section::Channel => table.integral(), // U_b h/ν is the integral in wall units
                Section::Pipe => 2.0 * table.integral_towards(channel.reynolds_tau), // U_b = 2 ∫ U r dr/R²
            };
            let excess = carried / target;
            if (excess - 1.0).abs() < BULK_TOLERANCE {
                let bulk_velocity = carried * kinematic_viscosity / (0.5 * height);
                let flow = Self::of(&channel, model, [height, kinematic_viscosity, bulk_velocity])?;
                return Ok(Self { iterations, residual, ..flow });
            }
            channel.stretch(channel.reynolds_tau * excess.powf(-DEAN_EXPONENT));
        }
        Err(format!("k-epsilon channel: no friction velocity for {bulk_velocity} m/s in {CORRECTIONS} corrections"))
    }

    /// Converts a flow from wall units to SI units, given the width of the channel [m], the kinematic viscosity [m²/s]
    /// and the bulk velocity [m/s].
    pub(super) fn of(
        channel: &HalfChannel,
        model: TurbulenceModel,
        [height, kinematic_viscosity, bulk_velocity]: [f64; 3],
    ) -> Result<Self, String> {
        let unit_velocity = channel.reynolds_tau * kinematic_viscosity / (0.5 * height);
        let wall_unit = kinematic_viscosity / unit_velocity;
        let friction = channel.wall_stress().abs().sqrt();
        let profile = profile(channel, model)?;
        Ok(Self {
            section: channel.section,
            model,
            height,
            kinematic_viscosity,
            bulk_velocity,
            centre_velocity: channel.centre_velocity() * unit_velocity,
            friction_velocity: friction * unit_velocity,
            reynolds_tau: friction * channel.reynolds_tau,
            nodes: channel.nodes(model, wall_unit, unit_velocity),
            profile: profile.into_iter().map(|(y, u)| (y * wall_unit, u * unit_velocity)).collect(),
            iterations: 0,
            residual: 0.0,
            k_budget: channel.k_budget(model),
            half: channel.clone(),
        })
    }

    /// Flow in wall units, on the grid of the solver.
    pub(super) fn half_channel(&self) -> &HalfChannel {
        &self.half
    }

    /// [Pa/m] pressure drop per length that keeps the gas alone steady, in a gas of this density [kg/m³].
    pub fn pressure_gradient(&self, density: f64) -> f64 {
        let walls_over_width = match self.section {
            Section::Channel => 2.0,
            Section::Pipe => 4.0,
        };
        walls_over_width * density * self.friction_velocity.powi(2) / self.height
    }

    /// Velocity U(y) for y from 0 to h, as a monotone cubic through the profile with zero slope on the centre plane.
    ///
    /// # Errors
    ///
    /// A solved flow gives no error. If `profile` was altered, the errors are those of [`VelocityTable::new`].
    pub fn half_table(&self) -> Result<VelocityTable, String> {
        half_table(&self.profile)
    }
}

/// [-] bulk Reynolds number U_b L_y/ν, with the bulk velocity U_b and the full width L_y of the channel, if it is high
/// enough for the model.
///
/// # Errors
/// A number that is not positive, or a Reynolds number that is too low for the model.
fn bulk_reynolds(velocity: f64, height: f64, kinematic_viscosity: f64, model: TurbulenceModel) -> Result<f64, String> {
    for (name, value) in [("bulk velocity", velocity), ("height", height), ("kinematic viscosity", kinematic_viscosity)]
    {
        if !(value.is_finite() && value > 0.0) {
            return Err(format!("k-epsilon channel: the {name} must be positive, it is {value}"));
        }
    }
    let (reynolds, lowest) = (velocity * height / kinematic_viscosity, model.lowest_reynolds());
    if !(reynolds.is_finite() && reynolds >= lowest) {
        return Err(format!(
            "k-epsilon channel: {model:?} needs a bulk Reynolds number of {lowest} or more, it is {reynolds:.6}"
        ));
    }
    Ok(reynolds)
}

/// Velocity profile U(y) from the wall to the centre, as points (y, U) in wall units.
///
/// # Errors
/// A velocity of the solution that is not finite.
fn profile(channel: &HalfChannel, model: TurbulenceModel) -> Result<Vec<(f64, f64)>, String> {
    match model {
        TurbulenceModel::WallFunctions => wall_functions::profile(channel),
        TurbulenceModel::LaunderSharma => Ok(launder_sharma::profile(channel)),
    }
}

fn half_table(profile: &[(f64, f64)]) -> Result<VelocityTable, String> {
    VelocityTable::with_end_slopes(profile, [None, Some(0.0)])
}

/// Repeats sweeps (updates of k and ε in all cells) until a sweep changes both by less than `SWEEP_TOLERANCE`. Adds
/// the number of sweeps to `iterations`, and returns the last relative change [-]. Returns an error if `SWEEPS` sweeps
/// do not suffice, or if a change is not finite.
fn converge(channel: &mut HalfChannel, model: TurbulenceModel, iterations: &mut usize) -> Result<f64, String> {
    let mut change = f64::INFINITY;
    for _ in 0..SWEEPS {
        change = match model {
            TurbulenceModel::WallFunctions => wall_functions::sweep(channel),
            TurbulenceModel::LaunderSharma => launder_sharma::sweep(channel),
        };
        *iterations += 1;
        if change < SWEEP_TOLERANCE {
            return Ok(change);
        }
        if !change.is_finite() {
            break;
        }
    }
    Err(format!("k-epsilon channel: {model:?} did not converge, the last relative change is {change:.3e}"))
}

/// [-] first estimate of Re_τ from the bulk Reynolds number, by the friction coefficient C_f = 0.073 Re^(-1/4) (Dean
/// 1978).
fn estimate(reynolds: f64) -> f64 {
    0.5 * reynolds * (0.5 * 0.073 * reynolds.powf(-0.25)).sqrt()
}
