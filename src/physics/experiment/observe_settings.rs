//! Settings of the measurements that a case asks for.

use serde::Serialize;

/// Measurements that a case asks for in addition to the standard ones. A measurement that the case does not
/// ask for costs nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ObserveSettings {
    /// Settings of the pair distribution g(r); `None` if it is not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pair_distribution: Option<PairDistributionSettings>,
    /// Settings of the distribution of the velocities and its Sonine coefficients; `None` if it is not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity_distribution: Option<VelocityDistributionSettings>,
    /// Settings of the mean squared displacement and the autocorrelation of the velocities; `None` if they are not
    /// measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diffusion: Option<DiffusionSettings>,
    /// Settings of the static structure factor S(k); `None` if it is not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub structure_factor: Option<StructureFactorSettings>,
    /// True if the contact network of soft spheres is measured.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub contact_network: bool,
    /// Settings of the fields of density, velocity and stress on a grid; `None` if they are not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fields: Option<FieldsSettings>,
    /// True if the fluctuation of the gas velocity at the particles is measured.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub seen_gas: bool,
    /// Settings of the shear viscosity; `None` if it is not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub viscosity: Option<ViscositySettings>,
    /// Settings of the clusters of particles; `None` if they are not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clusters: Option<ClustersSettings>,
    /// Settings of the free surface of a layer; `None` if it is not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub free_surface: Option<FreeSurfaceSettings>,
}

impl ObserveSettings {
    /// Names of all measurements, as in the case. The files with curves of the measurements have these names.
    pub const NAMES: [&str; 10] = [
        "pair_distribution",
        "velocity_distribution",
        "diffusion",
        "structure_factor",
        "contact_network",
        "fields",
        "seen_gas",
        "viscosity",
        "clusters",
        "free_surface",
    ];

    /// True if the case asks for none of the measurements.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Names of the measurements that the case asks for, as they are written in the case (input file).
    pub fn names(&self) -> Vec<&'static str> {
        let asked = [
            self.pair_distribution.is_some(),
            self.velocity_distribution.is_some(),
            self.diffusion.is_some(),
            self.structure_factor.is_some(),
            self.contact_network,
            self.fields.is_some(),
            self.seen_gas,
            self.viscosity.is_some(),
            self.clusters.is_some(),
            self.free_surface.is_some(),
        ];
        Self::NAMES.into_iter().zip(asked).filter_map(|(name, asked)| asked.then_some(name)).collect()
    }
}

/// Settings of the measurement of the pair distribution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PairDistributionSettings {
    /// [m] largest distance between two centres that is counted, at most half the shortest edge of the box.
    pub reach: f64,
    /// Number of bins of equal width between the distances 0 and `reach`.
    pub bins: usize,
}

/// Settings of the measurement of the distribution of the velocities.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct VelocityDistributionSettings {
    /// [-] largest speed of the histogram in units of sqrt(2T), with the granular temperature T (mean square of one
    /// velocity component's fluctuation).
    pub largest_speed: f64,
    /// Number of bins of the histogram of velocities.
    pub bins: usize,
}

/// Settings of the measurement of diffusion: mean squared displacement and autocorrelation of the velocities.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DiffusionSettings {
    /// [s] longest time over which the displacement of a particle is followed.
    pub duration: f64,
}

/// Settings of the measurement of the static structure factor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StructureFactorSettings {
    /// [m] shortest wavelength 2π/k, which sets the largest wave number k.
    pub wavelength: f64,
    /// Number of bins of equal width between the wave number 0 and the largest wave number.
    pub bins: usize,
}

/// Settings of the fields of density, velocity and stress on a grid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FieldsSettings {
    /// [m] width of the Gaussian that spreads each particle over the fields: its standard deviation along each axis.
    pub width: f64,
    /// Numbers of cells of the grid along x, y and z.
    pub cells: [usize; 3],
}

/// Settings of the measurement of the shear viscosity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ViscositySettings {
    /// [s] longest time over which stresses of a gas in equilibrium are correlated; `None` in a sheared box.
    pub duration: Option<f64>,
}

/// Settings of the measurement of clusters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClustersSettings {
    /// [m] gap between the surfaces of two particles below which the two belong to one cluster.
    pub gap: f64,
}

/// Settings of the measurement of the free surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FreeSurfaceSettings {
    /// Vertical axis (0: x, 1: y, 2: z), and the sign of the upward direction along it (+1 or -1).
    pub up: (usize, f64),
    /// [m] approximate edge length of the columns into which the layer is divided; each column has one height.
    pub spacing: f64,
    /// [m] standard deviation of the Gaussian that smooths the heights; 0 for heights as they are.
    pub smoothing: f64,
}
