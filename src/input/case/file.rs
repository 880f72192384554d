//! All keys that may be typed in a case, with their descriptions.
//!
//! Every key is optional in these types, so that one message can name all missing keys. A choice, such as that of a
//! drag law, is a table named after the law (`[drag.schiller_naumann]`), so that a misspelt law is an error at its
//! line.
//!
//! These types are the only list of keys. serde reads a case into them. schemars makes from them the reference of
//! `diptych keys`, the page `docs/keys.md` and the schema for editors. The comment of a field is the description of
//! its key. Attributes of the field contain an example and, where needed, the `default` (or `x-default` in words) and
//! these rules, which the reader of a case applies (`case/rules.rs`):
//! - `x-range`: the range of a number, in the words of the message about a number out of range;
//! - `x-required`: the condition under which the key is required. It is `always`, or `or` with the keys that can
//!   replace it. Other conditions are applied by the code that turns the case into an experiment;
//! - `x-one-of`: the name of a group of keys, of which a table may contain only one. A key from a later source
//!   replaces the key of its group from an earlier source.
//!
//! An example that is a list is given by `extend("examples" = [[…]])`, because the attribute `example` of schemars
//! cannot contain a list.

mod contact;
mod gas;
mod motion;
mod observe;
mod openings;
mod region;
mod restitution;
mod rotation;
mod shear;
mod sizes;
mod thermostat;
mod walls;

pub use contact::{ContactFile, PairFile};
pub use gas::{
    CouplingFile, DragFile, FluidFile, LangevinFile, ModulationFile, ProfileFile, SeenTurbulenceFile, TurbulenceFile,
};
pub use motion::{KnotFile, MotionFile, ServoFile, ShapeTurningFile, VibrationFile};
pub use observe::{
    ClustersFile, ContactNetworkFile, DiffusionFile, FieldsFile, FreeSurfaceFile, ObserveFile, PairDistributionFile,
    SeenGasFile, StructureFactorFile, VelocityDistributionFile, ViscosityFile,
};
pub use openings::{InletFile, OutletFile, OutletMeshFile, OutletSideFile};
pub use region::{BlockRegionFile, CylinderRegionFile, RegionFile};
pub use restitution::{RestitutionFile, RestitutionLawFile};
pub use rotation::{HistoryFile, ImpactRuleFile, RollingFile, TangentialFile, TwistingFile};
pub use shear::{OrbitFile, ShearFile};
pub use sizes::{ByFile, SizesFile};
pub use thermostat::ThermostatFile;
pub use walls::{BoxFile, ConeFile, CuboidFile, CylinderFile, MeshFile, PlaneFile, SphereFile, WallFile};

use super::against::AgainstFile;
use super::fluctuation::FluctuationFile;
use super::located::Located;
use super::quantity::{Acceleration, Density, Length, Pressure, Ratio, Speed, Spin, Stiffness, Time};
use super::time_or_word::{AverageFromFile, WindowFile};
use crate::experiment::{Integrator, Model, SoftStepping, TrajectoryFormat};
use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::IgnoredAny;

/// Vector in a case: components along x, y and z.
pub type Three<T> = Located<[Located<T>; 3]>;

/// A whole case, as it is typed.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CaseFile {
    /// The box that contains the scene: x is spanwise, y wall-normal, z streamwise. One corner is at the origin; the
    /// box extends along positive x, y and z.
    #[schemars(extend("x-required" = "always"))]
    pub domain: Option<Located<DomainFile>>,
    /// Acceleration by gravity. Without this table there is no gravity.
    pub gravity: Option<Located<GravityFile>>,
    /// The gas. Its flow is prescribed, and the particles do not change it (one-way coupling) unless the case has the
    /// table `[fluid.coupling]`. Without this table there is no gas.
    pub fluid: Option<Located<FluidFile>>,
    /// The drag law. Without this table the gas exerts no drag.
    pub drag: Option<Located<DragFile>>,
    /// Heating of the particles from outside. Without this table the particles are not heated.
    pub thermostat: Option<Located<ThermostatFile>>,
    /// One kind of particles. Exactly one of `count`, `volume_fraction`, `file` and `at` determines the number of
    /// particles.
    #[schemars(extend("x-required" = "always"))]
    pub particles: Option<Vec<Located<ParticlesFile>>>,
    /// One wall, of exactly one shape.
    pub walls: Option<Vec<Located<WallFile>>>,
    /// One place where particles leave. Without such a table all particles stay.
    pub outlets: Option<Vec<Located<OutletFile>>>,
    /// One place where particles come in. Without such a table no particles come in.
    pub inlets: Option<Vec<Located<InletFile>>>,
    /// Restitution and friction of contacts between particles.
    #[schemars(extend("x-required" = "where two particles can meet"))]
    pub contact: Option<Located<ContactFile>>,
    /// Settings of the soft engine, in which contacts are springs and dashpots.
    #[schemars(extend("x-required" = "by the soft and the hybrid model"))]
    pub soft: Option<Located<SoftFile>>,
    /// Settings of the hard engine, in which collisions are instantaneous.
    pub hard: Option<Located<HardFile>>,
    /// Settings of the hybrid engine, in which a touch is an instantaneous collision or a soft contact. The hybrid
    /// engine also uses the settings of `[soft]`.
    pub hybrid: Option<Located<HybridFile>>,
    /// Settings of collisions by chance (direct simulation Monte Carlo).
    pub dsmc: Option<Located<DsmcFile>>,
    /// Duration, window (time between two drag kicks), seed and model of a run.
    #[schemars(extend("x-required" = "always"))]
    pub run: Option<Located<RunFile>>,
    /// Settings of the averages: number of slices, and time between samples (instants of measurement).
    pub statistics: Option<Located<StatisticsFile>>,
    /// Measurements in addition to the standard ones. Without this table only the standard ones are made.
    pub observe: Option<Located<ObserveFile>>,
    /// Settings of the trajectory files, which are written in addition to the results of every variant. Without this
    /// table no trajectories are written.
    pub output: Option<Located<OutputFile>>,
    /// One variant (the case with one collision model and some settings) that `compare` runs. Without any such table
    /// `compare` runs a soft and a hard variant.
    pub compare: Option<Vec<Located<CompareFile>>>,
    /// One key that `sweep` varies; several such tables make a grid. All other commands ignore this table.
    pub sweep: Option<Vec<Located<SweepFile>>>,
}

/// Table `[domain]`: the box.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DomainFile {
    /// Edge lengths of the box along x, y and z.
    #[schemars(extend("examples" = [["120 mm", "40 mm", "64 mm"]]))]
    #[schemars(extend("x-required" = "always", "x-range" = "1e-6 m ..= 1e4 m"))]
    pub size: Option<Three<Length>>,
    /// Axes along which the box is periodic.
    #[schemars(extend("examples" = [["x", "z"]], "default" = []))]
    pub periodic: Option<Vec<Located<Axis>>>,
    /// Uniform shear of the box. The periodic images above and below the box slide along z.
    pub shear: Option<Located<ShearFile>>,
}

/// Axis of space, given by its name: x, y or z.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// Spanwise axis.
    X,
    /// Wall-normal axis.
    Y,
    /// Streamwise axis.
    Z,
}

impl Axis {
    /// Index of the axis in vectors: 0 for x, 1 for y, 2 for z.
    pub fn index(self) -> usize {
        self as usize
    }
}

/// Table `[gravity]`: acceleration by gravity.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GravityFile {
    // the range ends at a hundred times the acceleration in the fastest centrifuges
    /// Acceleration by gravity: its components along x, y and z.
    #[schemars(extend("examples" = [["0 m/s^2", "-9.81 m/s^2", "0 m/s^2"]]))]
    #[schemars(extend("x-required" = "always", "x-range" = "-1e9 ..= 1e9 m/s^2"))]
    pub acceleration: Option<Three<Acceleration>>,
}

/// Table `[[particles]]`: one kind of particles.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParticlesFile {
    /// Name of this kind of particles in messages and results.
    #[schemars(example = &"glass 2 mm", extend("x-default" = "`particles 0`, `particles 1`, …"))]
    pub name: Option<Located<String>>,
    /// Diameter of the particles, d.
    #[schemars(example = &"406 um", extend("x-required" = "or `sizes`", "x-range" = "1e-7 m ..= 1 m"))]
    #[schemars(extend("x-one-of" = "size"))]
    pub diameter: Option<Located<Length>>,
    /// Distribution of the diameters, in place of one `diameter` for all particles.
    #[schemars(extend("x-one-of" = "size"))]
    pub sizes: Option<Located<SizesFile>>,
    /// Density of the material of the particles, ρ_p.
    #[schemars(example = &"1038 kg/m^3", extend("x-required" = "always", "x-range" = "0.1 ..= 3e4 kg/m^3"))]
    pub density: Option<Located<Density>>,
    /// Number of particles, at random positions without overlap.
    #[schemars(example = 100, extend("x-range" = "0 ..= 50000000"))]
    #[schemars(extend("x-required" = "or `volume_fraction`, `file`, `at`", "x-one-of" = "amount"))]
    pub count: Option<Located<i64>>,
    /// Fraction of a volume that the particles fill, at random positions without overlap. The volume is the whole box,
    /// or the `box` or `cylinder` of `in`.
    #[schemars(example = 0.014, extend("x-range" = "0 ..= 0.64", "x-one-of" = "amount"))]
    pub volume_fraction: Option<Located<Ratio>>,
    /// Part of the domain for the random positions, in place of the whole domain: exactly one of `box`, `cylinder` and
    /// `inside`.
    #[serde(rename = "in")]
    pub region: Option<Located<RegionFile>>,
    /// Name of a file with the positions, relative to the folder of the file that contains this key. Formats: the
    /// `state.csv` of a run; a CSV table with the columns `x,y,z`; extended XYZ; a data file or text dump of LAMMPS or
    /// LIGGGHTS in SI. A CSV table may also have `vx,vy,vz,diameter,species,id`. Its columns are in SI, or in a unit
    /// given as in `x_mm`. The format is recognized from the content or the name of the file.
    #[schemars(example = &"state.csv", extend("x-one-of" = "amount"))]
    pub file: Option<Located<String>>,
    /// List of particles, each with its position.
    #[schemars(extend("x-one-of" = "amount"))]
    pub at: Option<Located<Vec<Located<PlacedFile>>>>,
    /// Mean velocity of the particles at a random start. The mean of the drawn velocities is exactly this value.
    #[schemars(extend("examples" = [["0 m/s", "0 m/s", "9.5 m/s"]]))]
    #[schemars(extend("default" = ["0 m/s", "0 m/s", "0 m/s"], "x-range" = "-1e5 ..= 1e5 m/s"))]
    pub velocity_mean: Option<Three<Speed>>,
    /// Standard deviation of each velocity component of a random start: one value for all components, or a list of
    /// three along x, y and z. With two or more particles the drawn velocities have exactly this deviation.
    #[schemars(example = &"0.5 m/s", extend("default" = "0 m/s", "x-range" = "0 ..= 1e5 m/s"))]
    pub velocity_fluctuation: Option<Located<FluctuationFile>>,
    // a user may type two thirds as 0.667
    /// Ratio of the moment of inertia about the centre to m r², with mass m and radius r: 0.4 for a solid sphere, 2/3
    /// for a thin shell.
    #[schemars(example = 0.667, extend("default" = 0.4, "x-range" = "greater than 0, up to 0.667"))]
    pub inertia_factor: Option<Located<Ratio>>,
    // at the end of the range the surface of a sphere of 1 µm radius moves at 1000 m/s
    /// Mean spin (angular velocity) of the particles at a random start.
    #[schemars(extend("examples" = [["0 rad/s", "100 rad/s", "0 rad/s"]]))]
    #[schemars(extend("default" = ["0 rad/s", "0 rad/s", "0 rad/s"], "x-range" = "-1e9 ..= 1e9 rad/s"))]
    pub spin_mean: Option<Three<Spin>>,
    /// Standard deviation of each component of the spin (angular velocity) of a random start. With two or more
    /// particles the drawn spins have exactly this deviation.
    #[schemars(example = &"500 rad/s", extend("default" = "0 rad/s", "x-range" = "0 ..= 1e9 rad/s"))]
    pub spin_fluctuation: Option<Located<Spin>>,
    /// Elasticity of these particles, if it differs from that in `[soft.hertz]` or `[soft.kuwabara_kono]`.
    pub elasticity: Option<Located<ElasticityFile>>,
}

/// One particle in the list `at` of a kind of particles.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlacedFile {
    /// Position of the centre of this particle.
    #[schemars(extend("examples" = [["2 mm", "2 mm", "1.8 mm"]], "x-required" = "always"))]
    pub position: Option<Three<Length>>,
    /// Diameter of this particle, needed if its kind of particles has a size distribution (`sizes`).
    #[schemars(example = &"350 um", extend("x-required" = "with `sizes`"))]
    pub diameter: Option<Located<Length>>,
    /// Velocity of this particle.
    #[schemars(extend("examples" = [["0 m/s", "0 m/s", "0.5 m/s"]]))]
    #[schemars(extend("default" = ["0 m/s", "0 m/s", "0 m/s"], "x-range" = "-1e5 ..= 1e5 m/s"))]
    pub velocity: Option<Three<Speed>>,
    /// Spin (angular velocity) of this particle. It rotates about the direction of the vector by the right-hand rule.
    #[schemars(extend("examples" = [["0 rad/s", "0 rad/s", "-400 rad/s"]]))]
    #[schemars(extend("default" = ["0 rad/s", "0 rad/s", "0 rad/s"], "x-range" = "-1e9 ..= 1e9 rad/s"))]
    pub spin: Option<Three<Spin>>,
}

/// Table `[soft]`: settings of the soft engine, in which contacts are springs and dashpots.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SoftFile {
    /// Contact law: linear spring and dashpot. The soft and the hybrid model require one contact law.
    #[schemars(extend("x-one-of" = "contact law"))]
    pub linear_spring_dashpot: Option<Located<SpringFile>>,
    /// Contact law: Hertz's law of elastic spheres, with a dashpot. The soft and the hybrid model require one contact
    /// law.
    #[schemars(extend("x-one-of" = "contact law"))]
    pub hertz: Option<Located<ElasticityFile>>,
    /// Contact law: Hertz's law with the damping of viscoelastic spheres by Kuwabara and Kono (1987). Every surface has
    /// the restitution `{ viscoelastic = ... }` or 1.
    #[schemars(extend("x-one-of" = "contact law"))]
    pub kuwabara_kono: Option<Located<ElasticityFile>>,
    /// Number of time steps in the shortest contact, N_c. Fewer than 5 are refused without `allow_large_step`. The key
    /// `time_step` can be given instead.
    #[schemars(example = 50, extend("default" = 20, "x-range" = "greater than 0, up to 1e6", "x-one-of" = "step"))]
    pub steps_per_contact: Option<Located<Ratio>>,
    /// Time step of soft contacts, Δt. The key `steps_per_contact` can be given instead.
    #[schemars(example = &"4e-7 s", extend("x-range" = "greater than 0 s", "x-one-of" = "step"))]
    pub time_step: Option<Located<Time>>,
    /// True: allows a time step longer than a fifth of a contact.
    #[schemars(example = true, extend("default" = false))]
    pub allow_large_step: Option<Located<bool>>,
    /// True: allows a time step beyond the stability limit of the integrator. Energy then grows without bound.
    #[schemars(example = true, extend("default" = false))]
    pub allow_unstable: Option<Located<bool>>,
    /// Choice of the particles that are moved by time steps: all, or only those in contact.
    #[schemars(example = &"local", extend("default" = "auto"))]
    pub stepping: Option<Located<SoftStepping>>,
    /// Time integrator of the soft engine.
    #[schemars(example = &"rk2", extend("default" = "velocity_verlet"))]
    pub integrator: Option<Located<Integrator>>,
    /// Tangential law of spheres that rotate: exactly one table within this table. With such a table spheres rotate.
    pub tangential: Option<Located<TangentialFile>>,
    /// Rolling resistance of contacts that last: exactly one table within this table. With such a table spheres
    /// rotate.
    pub rolling: Option<Located<RollingFile>>,
    /// Twisting resistance of contacts that last. This table requires a tangential spring.
    pub twisting: Option<Located<TwistingFile>>,
}

/// Table `[soft.linear_spring_dashpot]`: constants of the linear contact law.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringFile {
    /// Stiffness of the spring, k_n. `diptych plan` reports how stiff it has to be.
    #[schemars(example = &"3000 N/m", extend("x-required" = "always", "x-range" = "1e-9 ..= 1e20 N/m"))]
    pub stiffness: Option<Located<Stiffness>>,
}

/// Elastic constants of a material: table `[soft.hertz]`, `[soft.kuwabara_kono]`, or the `elasticity` of a kind of
/// particles or of a wall.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ElasticityFile {
    /// Young's modulus, E. `diptych plan` reports how stiff the material has to be.
    #[schemars(example = &"70 GPa", extend("x-required" = "always", "x-range" = "greater than 0 Pa"))]
    pub youngs_modulus: Option<Located<Pressure>>,
    /// Poisson's ratio, ν.
    #[schemars(example = 0.2, extend("default" = 0.3, "x-range" = "more than -1, up to 0.5"))]
    pub poissons_ratio: Option<Located<Ratio>>,
}

/// Table `[hard]`: settings of the hard engine, in which collisions are instantaneous.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HardFile {
    /// Method by which the hard engine finds collisions.
    #[schemars(example = &"steps", extend("default" = "events"))]
    pub stepping: Option<Located<HardSteppingFile>>,
    /// Parameter θ of `stepping = "steps"`: a step is shorter than θ d/u_r. Here d is the smallest diameter, and u_r
    /// the mean magnitude of one component of the relative velocity.
    #[schemars(example = 0.1, extend("default" = 0.3, "x-range" = "greater than 0, up to 1"))]
    pub theta: Option<Located<Ratio>>,
    /// Contact time t_c of the TC model: a collision is elastic if either particle has collided less than t_c before.
    #[schemars(example = &"1e-6 s", extend("x-default" = "every collision has its restitution"))]
    #[schemars(extend("x-range" = "greater than 0 s"))]
    pub contact_time: Option<Located<Time>>,
    /// Rule of the tangential impulse of spheres that rotate: exactly one table within this table. With such a table
    /// spheres rotate.
    pub friction: Option<Located<ImpactRuleFile>>,
}

/// Table `[hybrid]`: settings of the hybrid engine, in which a touch is an instantaneous collision or a soft contact.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HybridFile {
    /// Clearance, as a number of contact times (durations of a soft contact). A collision is instantaneous if no other
    /// particle can reach the two particles within this many contact times. At a wall, gravity must also not bring the
    /// sphere back within that time. Any other touch is a soft contact.
    #[schemars(example = 10, extend("default" = 2, "x-range" = "1 ..= 1e6"))]
    pub clearance: Option<Located<Ratio>>,
}

/// Table `[dsmc]`: settings of collisions by chance (direct simulation Monte Carlo).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DsmcFile {
    /// True: the collision rate has the Enskog factor, the contact value of the pair distribution at the local volume
    /// fraction. False: the rate is that of a dilute gas.
    #[schemars(example = false, extend("default" = true))]
    pub enskog: Option<Located<bool>>,
    /// Numbers of cells along x, y and z, in which pairs are drawn. A cell is at least as wide as the largest particle.
    /// Between flat walls, the cells divide only the region that particle centres can reach.
    #[schemars(extend("examples" = [[20, 30, 10]], "x-range" = "1 ..= 10000"))]
    #[schemars(extend("x-default" = "chosen from the mean free path and the number of particles"))]
    pub cells: Option<Located<[Located<i64>; 3]>>,
    /// Longest time step, in mean free times (mean time between two collisions of a particle).
    #[schemars(example = 0.1, extend("default" = 0.2, "x-range" = "greater than 0, up to 1"))]
    pub step: Option<Located<Ratio>>,
}

/// Method by which the hard engine finds collisions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum HardSteppingFile {
    /// Event-driven: collisions happen at the exact instants of touch.
    Events,
    /// Time-stepped: collisions are found as overlaps at the ends of steps.
    Steps,
}

/// Table `[run]`: settings of a run.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunFile {
    /// Collision model; `--model` overrides it. A case that is used only with `compare` may lack this key.
    #[schemars(example = &"hard", extend("x-required" = "by `run` without `--model`"))]
    pub model: Option<Located<Model>>,
    /// Simulated time. With 0 s only the initial state is written.
    #[schemars(example = &"2 s", extend("x-required" = "always", "x-range" = "0 ..= 1e9 s"))]
    pub duration: Option<Located<Time>>,
    /// Start of averaging. "steady": the run detects when the flow has become steady.
    #[schemars(example = &"1.5 s", extend("default" = "steady"))]
    pub average_from: Option<Located<AverageFromFile>>,
    /// Window: time between two kicks by which drag changes the velocities. "auto": chosen from the scene.
    #[schemars(example = &"0.2 ms", extend("default" = "auto"))]
    pub window: Option<Located<WindowFile>>,
    /// Seed of the random numbers of the start and of the run; `--seed` overrides it.
    #[schemars(example = 7, extend("default" = 1, "x-range" = "0 ..= 9223372036854775807"))]
    pub seed: Option<Located<i64>>,
    /// True: allows a run with very many windows (times between two drag kicks) or time steps, which would take
    /// extremely long.
    #[schemars(example = true, extend("default" = false))]
    pub allow_long: Option<Located<bool>>,
    /// True: placed particles that overlap other particles or walls are pushed apart before the start. Each overlap may
    /// be at most half a diameter. The option `--relax` does this too.
    #[schemars(example = true, extend("default" = false))]
    pub relax: Option<Located<bool>>,
}

/// Table `[statistics]`: settings of the averages.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StatisticsFile {
    /// Number of slices of equal thickness across y in which profiles are averaged.
    #[schemars(example = 15, extend("default" = 40, "x-range" = "1 ..= 100000"))]
    pub slices: Option<Located<i64>>,
    /// Time between two samples, the instants at which measurements are taken.
    #[schemars(example = &"1 ms", extend("x-default" = "chosen from the scene", "x-range" = "greater than 0 s"))]
    pub sample_interval: Option<Located<Time>>,
}

/// Table `[output]`: settings of the trajectory files.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutputFile {
    /// Time between two frames (states of all particles at one instant), counted from the start and equal in every
    /// variant. Windows (times between two drag kicks) also end at these times. This may change the last digits of
    /// results, unless windows end at these times anyway.
    #[schemars(example = &"1 ms", extend("x-default" = "none are written", "x-range" = "greater than 0 s"))]
    pub every: Option<Located<Time>>,
    /// File format of the trajectories.
    #[schemars(example = &"both", extend("default" = "vtp"))]
    pub format: Option<Located<TrajectoryFormat>>,
}

/// Table `[[compare]]`: one variant of the case.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompareFile {
    /// Name of the variant.
    #[schemars(example = &"soft, k = 500 N/m", extend("x-default" = "the name of the model"))]
    pub name: Option<Located<String>>,
    /// Collision model of the variant.
    #[schemars(example = &"soft", extend("x-default" = "`run.model`"))]
    pub model: Option<Located<Model>>,
    /// Reference of this variant: the name of another variant, or `{ table = "points.csv" }`. Such a table has the
    /// columns `quantity`, `value` and `standard_error`, and `y` for values at a distance from the lower side.
    /// Quantities are columns of `profiles.csv`, or `granular_temperature`, `pair_impact_rate` and `wall_impact_rate`
    /// without `y`.
    #[schemars(example = &"hard", extend("x-default" = "the first hard one, or else the first"))]
    pub against: Option<Located<AgainstFile>>,
    // the value is taken from the tree of the case, which contains the source positions
    /// Keys of the case that have other values in this variant, each with its full name and its value.
    #[schemars(with = "Option<std::collections::BTreeMap<String, serde_json::Value>>")]
    #[schemars(extend("examples" = [{ "contact.restitution": 0.9 }]))]
    pub set: Option<Located<IgnoredAny>>,
}

/// Table `[[sweep]]`: one key and its values.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepFile {
    /// Full path of the key that is varied.
    #[schemars(example = &"soft.linear_spring_dashpot.stiffness", extend("x-required" = "always"))]
    pub key: Option<Located<String>>,
    // the values are taken from the tree of the case, which contains the source positions
    /// Values of the key, in the order of the runs.
    #[schemars(with = "Vec<serde_json::Value>")]
    #[schemars(extend("examples" = [["300 N/m", "1 kN/m", "3 kN/m"]], "x-required" = "always"))]
    pub values: Option<Located<Vec<IgnoredAny>>>,
}
