//! Keys of the gas, its flow and its drag.

use crate::case::located::Located;
use crate::case::quantity::{
    Density, DissipationRate, KinematicViscosity, Length, PressureGradient, Ratio, SpecificEnergy, Speed,
};
use schemars::JsonSchema;
use serde::Deserialize;

/// Table `[fluid]`: the gas and its flow.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FluidFile {
    /// Density of the gas, ρ_f.
    #[schemars(example = &"1.205 kg/m^3")]
    #[schemars(extend("x-required" = "always", "x-range" = "1e-4 ..= 3e4 kg/m^3"))]
    pub density: Option<Located<Density>>,
    /// Kinematic viscosity of the gas, ν.
    #[schemars(example = &"1.515e-5 m^2/s")]
    #[schemars(extend("x-required" = "always", "x-range" = "1e-8 ..= 1e-2 m^2/s"))]
    pub kinematic_viscosity: Option<Located<KinematicViscosity>>,
    /// False: leaves out buoyancy, the force -ρ_f V g of the gas of density ρ_f on a particle of volume V (g:
    /// gravity). Without gravity the key has no effect.
    #[schemars(example = false, extend("default" = true))]
    pub buoyancy: Option<Located<bool>>,
    /// True: adds the added mass ρ_f V/2, the inertia of the gas of density ρ_f that a particle of volume V
    /// accelerates. Masses, momenta and energies in results then include the added mass.
    #[schemars(example = true, extend("default" = false))]
    pub added_mass: Option<Located<bool>>,
    /// Turbulence that particles see in addition to the mean velocity of the gas. Without this table they see the mean
    /// velocity alone.
    pub turbulence: Option<Located<SeenTurbulenceFile>>,
    /// Lift of the gas on the particles. Without this table there is no lift.
    pub lift: Option<Located<LiftFile>>,
    /// Two-way coupling: the gas loses the momentum that it gives to the particles. Without this table the particles do
    /// not change the gas.
    pub coupling: Option<Located<CouplingFile>>,
    /// Velocity of the gas along z, usually as a function of y. Give exactly one table within this table.
    #[schemars(extend("x-required" = "always"))]
    pub profile: Option<Located<ProfileFile>>,
}

/// Table `[fluid.turbulence]`: turbulence that particles see, as fluctuations of the gas velocity along their paths.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SeenTurbulenceFile {
    /// Turbulent kinetic energy, k, in a gas whose velocity is equal everywhere (`uniform`) and does not give k.
    #[schemars(example = &"0.5 m^2/s^2", extend("x-range" = "greater than 0, up to 1e6 m^2/s^2"))]
    pub kinetic_energy: Option<Located<SpecificEnergy>>,
    /// Dissipation rate ε of the turbulent kinetic energy, in a gas whose velocity is equal everywhere (`uniform`).
    #[schemars(example = &"10 m^2/s^3", extend("x-range" = "greater than 0, up to 1e12 m^2/s^3"))]
    pub dissipation_rate: Option<Located<DissipationRate>>,
    /// Langevin equation for the gas velocity along the path of each particle.
    #[schemars(extend("x-required" = "or `eddy`", "x-one-of" = "law"))]
    pub langevin: Option<Located<LangevinFile>>,
    /// Discrete random walk (Gosman and Ioannides 1983): each particle sees eddies of constant velocity, one after the
    /// other. The model has no drift term, so light particles gather where the turbulence is weak. Prefer `langevin`.
    #[schemars(extend("x-one-of" = "law"))]
    pub eddy: Option<Located<LangevinFile>>,
}

/// Tables `[fluid.turbulence.langevin]` and `[fluid.turbulence.eddy]`: constants of the law. For `langevin`, T_L is
/// the time during which the gas velocity along a path stays correlated. For `eddy` it is the mean lifetime of an eddy
/// without slip.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LangevinFile {
    /// Kolmogorov constant C_0, which sets the time T_L = (k/ε)/(1/2 + 3/4 C_0) from the turbulent kinetic energy k
    /// and its dissipation rate ε.
    #[schemars(example = 5, extend("default" = 2.1, "x-range" = "0 ..= 20"))]
    pub kolmogorov_constant: Option<Located<Ratio>>,
    /// Ratio β = T_L/T_E of two integral times (times of correlation) of the gas velocity: T_L along the path of the
    /// gas, and T_E at a point that moves with the mean flow. A particle that slips through eddies sees each of them
    /// for a shorter time; with 0 this effect is left out.
    #[schemars(example = 0.8, extend("x-default" = "0.671, so that β² = 0.45", "x-range" = "0 ..= 10"))]
    pub time_scale_ratio: Option<Located<Ratio>>,
}

/// Table `[fluid.lift]`: forces of the gas at right angles to the slip (velocity of a particle relative to the gas).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LiftFile {
    /// True: lift in sheared gas, after Saffman (1965) and Mei (1992).
    #[schemars(example = true, extend("default" = false))]
    pub shear: Option<Located<bool>>,
    /// True: lift by spin (Magnus force) after Oesterlé and Bui Dinh (1998), and the torque of the gas on the spin.
    /// Spheres must rotate.
    #[schemars(example = true, extend("default" = false))]
    pub spin: Option<Located<bool>>,
}

/// Table `[fluid.coupling]`: two-way coupling in a k-ε channel or pipe.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CouplingFile {
    /// Number of equal slices from the wall to the centre plane, or to the axis of a pipe, in which the force on the
    /// particles is summed.
    #[schemars(example = 20, extend("default" = 20, "x-range" = "1 ..= 1000"))]
    pub slices: Option<Located<i64>>,
    /// Pressure drop of the gas per length, which is kept constant. It is positive if it drives the gas along +z, and
    /// contains no hydrostatic part. Without this key the flow rate is kept constant.
    #[schemars(example = &"40 Pa/m", extend("x-range" = "-1e6 ..= 1e6 Pa/m"))]
    pub pressure_gradient: Option<Located<PressureGradient>>,
    /// Model of the effect of the particles on the turbulence of the gas. The changed mean velocity acts on the
    /// turbulence in every case.
    #[schemars(example = &"none", extend("default" = "simonin"))]
    pub modulation: Option<Located<ModulationFile>>,
}

/// Name of a model of turbulence modulation, the effect of the particles on the turbulence of the gas.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ModulationFile {
    /// No effect on the turbulence beyond that of the mean velocity.
    None,
    /// Damping of k (turbulent kinetic energy) and ε (its dissipation rate) by the slip between the fluctuations of
    /// the particles and of the gas, after Simonin (1996).
    Simonin,
    /// Production of k (turbulent kinetic energy) by the mean slip, and a length of dissipation limited by the
    /// distance between particles, after Crowe (2000).
    Crowe,
}

/// Tables `[drag.*]`: choice of a drag law.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum DragFile {
    /// Drag law of Schiller and Naumann (1935), which the reference paper (`docs/paper.md`) uses.
    SchillerNaumann {},
    /// Stokes drag of creeping flow, whose solution is known in closed form.
    Stokes {},
    /// Drag in suspensions by Wen and Yu (1966).
    WenYu {
        /// Numbers of equal cells along x, y and z in which the local volume fraction of the particles is computed. A
        /// cell is at least as wide as a particle.
        #[schemars(extend("examples" = [[1, 20, 1]], "x-required" = "always", "x-range" = "1 ..= 10000"))]
        cells: Option<Located<[Located<i64>; 3]>>,
    },
    /// Drag in suspensions by Gidaspow (1994). It is the law of Ergun if the gas fills less than 0.8 of the volume,
    /// else that of Wen and Yu.
    Gidaspow {
        /// Numbers of equal cells along x, y and z in which the local volume fraction of the particles is computed. A
        /// cell is at least as wide as a particle.
        #[schemars(extend("examples" = [[1, 20, 1]], "x-required" = "always", "x-range" = "1 ..= 10000"))]
        cells: Option<Located<[Located<i64>; 3]>>,
    },
    /// Drag in suspensions by Beetstra, van der Hoef and Kuipers (2007).
    Beetstra {
        /// Numbers of equal cells along x, y and z in which the local volume fraction of the particles is computed. A
        /// cell is at least as wide as a particle.
        #[schemars(extend("examples" = [[1, 20, 1]], "x-required" = "always", "x-range" = "1 ..= 10000"))]
        cells: Option<Located<[Located<i64>; 3]>>,
    },
    /// Drag in suspensions by Tenneti, Garg and Subramaniam (2011).
    Tenneti {
        /// Numbers of equal cells along x, y and z in which the local volume fraction of the particles is computed. A
        /// cell is at least as wide as a particle.
        #[schemars(extend("examples" = [[1, 20, 1]], "x-required" = "always", "x-range" = "1 ..= 10000"))]
        cells: Option<Located<[Located<i64>; 3]>>,
    },
    /// Drag in suspensions by Di Felice (1994).
    DiFelice {
        /// Numbers of equal cells along x, y and z in which the local volume fraction of the particles is computed. A
        /// cell is at least as wide as a particle.
        #[schemars(extend("examples" = [[1, 20, 1]], "x-required" = "always", "x-range" = "1 ..= 10000"))]
        cells: Option<Located<[Located<i64>; 3]>>,
    },
}

/// Tables `[fluid.profile.*]`: choice of a velocity profile of the gas.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ProfileFile {
    /// Velocity of the gas that is equal everywhere.
    Uniform {
        /// Velocity of the gas along z; 0 means a gas at rest.
        #[schemars(example = &"0 m/s")]
        #[schemars(extend("x-required" = "always", "x-range" = "-1e4 ..= 1e4 m/s"))]
        velocity: Option<Located<Speed>>,
    },
    /// Velocities of the gas from a table in a file.
    Table {
        /// Name of a CSV file with the columns `y_m,U_m_s`, relative to the folder of the file that contains this key.
        /// For `fluid.turbulence` it also has the columns `k_m2_s2` and `epsilon_m2_s3`.
        #[schemars(example = &"gas.csv", extend("x-required" = "always"))]
        file: Option<Located<String>>,
    },
    /// Fully developed turbulent channel flow between y = 0 and y = L_y (height of the box), from a k-ε model.
    KEpsilonChannel {
        /// Reynolds number U_b L_y/ν, with the bulk velocity U_b, the full width L_y and the kinematic viscosity ν.
        /// The given range is that of `wall_functions`; `launder_sharma` accepts values from 6000 on.
        #[schemars(example = 42000)]
        #[schemars(extend("x-required" = "always", "x-range" = "10000 ..= 1e8", "minimum" = 6000))]
        reynolds_number: Option<Located<Ratio>>,
        /// Name of the k-ε model of the channel flow.
        #[schemars(example = &"launder_sharma", extend("default" = "wall_functions"))]
        model: Option<Located<TurbulenceFile>>,
    },
    /// Fully developed turbulent flow along z through a round pipe, from the low-Reynolds-number k-ε model of Launder
    /// and Sharma. Outside the pipe the gas is at rest. The wall itself is a `[[walls]]` table with a `cylinder`.
    KEpsilonPipe {
        /// Reynolds number U_b D/ν, with the bulk velocity U_b, the diameter D and the kinematic viscosity ν.
        #[schemars(example = 42000)]
        #[schemars(extend("x-required" = "always", "x-range" = "6000 ..= 1e8"))]
        reynolds_number: Option<Located<Ratio>>,
        /// Diameter of the pipe, D.
        #[schemars(example = &"40 mm", extend("x-default" = "L_y", "x-range" = "greater than 0 m"))]
        diameter: Option<Located<Length>>,
        /// Coordinates x and y of the pipe axis.
        #[schemars(extend("examples" = [["20 mm", "20 mm"]], "x-default" = "the middle of the box"))]
        center: Option<Located<[Located<Length>; 2]>>,
    },
    /// The logarithmic law of the wall between y = 0 and y = L_y (height of the box). Give exactly one of
    /// `friction_velocity` and `reynolds_number`.
    LogLaw {
        /// Friction velocity u_τ = sqrt(τ_w/ρ_f), with the shear stress τ_w at the wall and the density ρ_f of the
        /// gas.
        #[schemars(example = &"0.80 m/s")]
        #[schemars(extend("x-required" = "or `reynolds_number`", "x-one-of" = "flow rate"))]
        #[schemars(extend("x-range" = "greater than 0, up to 1e3 m/s"))]
        friction_velocity: Option<Located<Speed>>,
        /// Reynolds number U_b L_y/ν, with the bulk velocity U_b, the full width L_y and the kinematic viscosity ν.
        /// The friction velocity follows from this number.
        #[schemars(example = 42000, extend("x-range" = "6000 ..= 1e8", "x-one-of" = "flow rate"))]
        reynolds_number: Option<Located<Ratio>>,
        /// Von Kármán's constant κ of the logarithmic law.
        #[schemars(example = 0.4, extend("default" = 0.41, "x-range" = "0.2 ..= 0.8"))]
        von_karman: Option<Located<Ratio>>,
        /// Additive constant B of the logarithmic law, in which the velocity is divided by the friction velocity u_τ.
        #[schemars(example = 5.2, extend("default" = 5.0, "x-range" = "-10 ..= 20"))]
        intercept: Option<Located<Ratio>>,
    },
}

/// Name of a k-ε model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TurbulenceFile {
    /// Standard k-ε model with wall functions.
    WallFunctions,
    /// Model of Launder and Sharma (1974) for low Reynolds numbers, integrated down to the wall.
    LaunderSharma,
}
