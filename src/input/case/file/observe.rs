//! Keys of the measurements in addition to the standard ones: tables `[observe.*]` of a case.

use super::{Located, Three};
use crate::case::quantity::{Length, Ratio, Time};
use schemars::JsonSchema;
use serde::Deserialize;

/// Table `[observe]`: measurements in addition to the standard ones. Each measurement is a table in this table, and
/// may be empty if none of its keys is required. Results are in the report, in a CSV file with the name of the table,
/// and in `observables.csv`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObserveFile {
    /// Pair distribution g(r), of all particles and of each pair of species, and its value at contact.
    pub pair_distribution: Option<Located<PairDistributionFile>>,
    /// Distribution of the velocities, and its coefficients a₂ and a₃ in Sonine polynomials.
    pub velocity_distribution: Option<Located<VelocityDistributionFile>>,
    /// Mean squared displacement, autocorrelation of the velocities, and the coefficient of self-diffusion.
    pub diffusion: Option<Located<DiffusionFile>>,
    /// Static structure factor S(k).
    pub structure_factor: Option<Located<StructureFactorFile>>,
    /// Contact network of soft spheres: contacts per particle, fabric tensor, and a file of the contacts at the end.
    pub contact_network: Option<Located<ContactNetworkFile>>,
    /// Density, velocity and stress on a grid, with a file for ParaView.
    pub fields: Option<Located<FieldsFile>>,
    /// Gas velocity that the particles see, in slices, for a gas with `[fluid.turbulence]`.
    pub seen_gas: Option<Located<SeenGasFile>>,
    /// Shear viscosity, of a gas in equilibrium or of a sheared box.
    pub viscosity: Option<Located<ViscosityFile>>,
    /// Clusters: groups of particles that are connected by small gaps.
    pub clusters: Option<Located<ClustersFile>>,
    /// Free surface of a layer under gravity: waviness, wavelength and symmetry of a pattern.
    pub free_surface: Option<Located<FreeSurfaceFile>>,
}

/// Table `[observe.pair_distribution]`: pair distribution g(r), in a box that is periodic along x, y and z.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairDistributionFile {
    /// Largest distance of two centres that is counted, at most half the shortest edge of the box. The computing time
    /// of a sample (instant of measurement) grows with the third power of this distance.
    #[schemars(example = &"2 mm", extend("x-required" = "always", "x-range" = "1e-9 ..= 1e4 m"))]
    pub reach: Option<Located<Length>>,
    /// Number of bins of the distance of two centres, between 0 and `reach`.
    #[schemars(example = 200, extend("default" = 100, "x-range" = "1 ..= 10000"))]
    pub bins: Option<Located<i64>>,
}

/// Table `[observe.velocity_distribution]`: distribution of the velocities relative to the mean velocity of their
/// slice, in units of sqrt(2T) with the granular temperature T.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VelocityDistributionFile {
    /// Largest speed of the histogram in units of sqrt(2T), with the granular temperature T [m²/s²].
    #[schemars(example = 6, extend("default" = 4, "x-range" = "0.1 ..= 100"))]
    pub largest_speed: Option<Located<Ratio>>,
    /// Number of bins of the histogram of the velocities.
    #[schemars(example = 100, extend("default" = 40, "x-range" = "1 ..= 10000"))]
    pub bins: Option<Located<i64>>,
}

/// Table `[observe.diffusion]`: motion of the particles during intervals of the length `duration`, which follow each
/// other without overlap.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DiffusionFile {
    /// Longest time over which the motion is followed: at least ten times `statistics.sample_interval`. Standard
    /// errors need an averaging period of at least eight times this `duration`.
    #[schemars(example = &"5 ms", extend("x-required" = "always", "x-range" = "greater than 0 s"))]
    pub duration: Option<Located<Time>>,
}

/// Table `[observe.structure_factor]`: structure factor for the wave vectors that fit into a box that is periodic along
/// x, y and z.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StructureFactorFile {
    /// Shortest wavelength 2π/k, at least a hundredth of the longest edge of the box. It sets the largest wave number
    /// k.
    #[schemars(example = &"0.2 mm", extend("x-required" = "always", "x-range" = "1e-9 ..= 1e4 m"))]
    pub wavelength: Option<Located<Length>>,
    /// Number of bins of the wave number k, between 0 and the largest wave number.
    #[schemars(example = 80, extend("default" = 50, "x-range" = "1 ..= 10000"))]
    pub bins: Option<Located<i64>>,
}

/// Table `[observe.contact_network]`: contacts of soft and hybrid spheres; it has no keys.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactNetworkFile {}

/// Table `[observe.fields]`: density, velocity and stress on a grid of cells that fill the box. Particles are spread by
/// a Gaussian.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FieldsFile {
    /// Width of the Gaussian that spreads each particle over the grid: its standard deviation along each axis.
    #[schemars(example = &"0.4 mm", extend("x-required" = "always", "x-range" = "1e-9 ..= 1e4 m"))]
    pub width: Option<Located<Length>>,
    /// Numbers of cells along x, y and z, together at most 50000.
    #[schemars(extend("examples" = [[10, 20, 10]], "x-required" = "always"))]
    pub cells: Option<Three<i64>>,
}

/// Table `[observe.seen_gas]`: mean and mean square of the fluctuation of the gas velocity that particles see, in the
/// slices of `profiles.csv`; it has no keys.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SeenGasFile {}

/// Table `[observe.viscosity]`: viscosity of a sheared box by its stress, or of a gas of elastic, smooth spheres in a
/// periodic box by the correlation of its stresses.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ViscosityFile {
    /// Longest time over which stresses are correlated: at least ten times `statistics.sample_interval`, and about
    /// twenty mean free times. The key is required unless the box is sheared.
    #[schemars(example = &"1 ms", extend("x-default" = "none, for sheared boxes", "x-range" = "greater than 0 s"))]
    pub duration: Option<Located<Time>>,
}

/// Table `[observe.clusters]`: number, sizes and size distribution of groups of particles that are connected by small
/// gaps.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ClustersFile {
    /// Gap between the surfaces of two particles below which they are connected. The sum of the gap and the largest
    /// diameter may be at most half the shortest periodic edge of the box.
    #[schemars(example = &"20 um", extend("x-required" = "always", "x-range" = "0 ..= 1e4 m"))]
    pub gap: Option<Located<Length>>,
}

/// Table `[observe.free_surface]`: height of the highest sphere in each column of a layer under gravity, seen from
/// above. Wavelength and symmetry are averaged over those samples (instants) whose contrast, the standard deviation of
/// the smoothed heights, is at least the mean contrast.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FreeSurfaceFile {
    /// Edge length of the columns in which the height of the layer is measured, about a diameter: a tenth to a
    /// five-hundredth of each horizontal edge of the box.
    #[schemars(example = &"1 mm", extend("x-required" = "always", "x-range" = "1e-9 ..= 1e4 m"))]
    pub spacing: Option<Located<Length>>,
    /// Standard deviation of the Gaussian that smooths the heights of the layer.
    #[schemars(example = &"2 mm", extend("x-default" = "2 spacings", "x-range" = "0 ..= 1e4 m"))]
    pub smoothing: Option<Located<Length>>,
}
