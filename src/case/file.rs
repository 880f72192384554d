//! Exactly what may be typed in a case.
//!
//! Everything is optional here, so that all keys that are missing can be named in one message; what a scene cannot do
//! without is decided where it is resolved. Choices are tables named after the law (`[drag.schiller_naumann]`), so that
//! a misspelt law is an error at its line.

use super::de::Located;
use super::quantity::{Acceleration, Density, KinematicViscosity, Length, Pressure, Ratio, Speed, Stiffness, Time};
use crate::drag::Drag;
use crate::experiment::{Integrator, Model, SoftStepping};
use serde::Deserialize;
use serde::de::IgnoredAny;

/// Components along x, y, z.
pub type Three<T> = Located<[Located<T>; 3]>;

/// A whole case.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CaseFile {
    /// Box and periodic axes.
    pub domain: Option<Located<DomainFile>>,
    /// Absent: none.
    pub gravity: Option<Located<GravityFile>>,
    /// Absent: no gas.
    pub fluid: Option<Located<FluidFile>>,
    /// Absent: the gas exerts no force.
    pub drag: Option<Located<Drag>>,
    /// Kinds of particles.
    pub particles: Option<Vec<Located<ParticlesFile>>>,
    /// Walls.
    pub walls: Option<Vec<Located<WallFile>>>,
    /// Particle against particle.
    pub contact: Option<Located<SurfaceFile>>,
    /// Settings of the soft engine.
    pub soft: Option<Located<SoftFile>>,
    /// Settings of the hard engine.
    pub hard: Option<Located<HardFile>>,
    /// Length, window, seed, model.
    pub run: Option<Located<RunFile>>,
    /// What is averaged.
    pub statistics: Option<Located<StatisticsFile>>,
    /// Variants that `compare` runs.
    pub compare: Option<Vec<Located<CompareFile>>>,
}

/// `[domain]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DomainFile {
    /// Edge lengths.
    pub size: Option<Three<Length>>,
    /// Periodic axes; absent: none.
    pub periodic: Option<Vec<Located<Axis>>>,
}

/// An axis by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// Spanwise.
    X,
    /// Wall-normal.
    Y,
    /// Streamwise.
    Z,
}

impl Axis {
    /// 0, 1 or 2.
    pub fn index(self) -> usize {
        self as usize
    }
}

/// `[gravity]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GravityFile {
    /// Components.
    pub acceleration: Option<Three<Acceleration>>,
}

/// `[fluid]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FluidFile {
    /// ρ_f.
    pub density: Option<Located<Density>>,
    /// ν.
    pub kinematic_viscosity: Option<Located<KinematicViscosity>>,
    /// u_z(y).
    pub profile: Option<Located<ProfileFile>>,
}

/// `[fluid.profile.*]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ProfileFile {
    /// The same velocity everywhere.
    Uniform {
        /// Along z.
        velocity: Option<Located<Speed>>,
    },
    /// A CSV table with the columns `y_m,U_m_s`.
    Table {
        /// Its name, relative to the file that names it.
        file: Option<Located<String>>,
    },
    /// Fully developed turbulent channel flow between y = 0 and y = L_y.
    KEpsilonChannel {
        /// With the bulk velocity and the full width.
        reynolds_number: Option<Located<Ratio>>,
        /// Which k-ε model; absent: wall functions.
        model: Option<Located<TurbulenceFile>>,
    },
}

/// A k-ε model by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TurbulenceFile {
    /// Standard k-ε with wall functions.
    WallFunctions,
    /// Launder and Sharma (1974), integrated to the wall.
    LaunderSharma,
}

/// `[[particles]]`: one kind.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParticlesFile {
    /// Its name; absent: `particles <index>`.
    pub name: Option<Located<String>>,
    /// d.
    pub diameter: Option<Located<Length>>,
    /// ρ_p.
    pub density: Option<Located<Density>>,
    /// How many, at random places.
    pub count: Option<Located<i64>>,
    /// How many, as the share of the whole domain's volume.
    pub volume_fraction: Option<Located<Ratio>>,
    /// Where, from a CSV table.
    pub file: Option<Located<String>>,
    /// Where, one by one.
    pub at: Option<Located<Vec<Located<PlacedFile>>>>,
    /// Mean of a random start.
    pub velocity_mean: Option<Three<Speed>>,
    /// Standard deviation of each component of a random start, met exactly by two particles and more.
    pub velocity_fluctuation: Option<Located<Speed>>,
    /// Of these particles, where they differ from what `[soft.hertz]` says.
    pub elasticity: Option<Located<ElasticityFile>>,
}

/// One particle of a list.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlacedFile {
    /// Centre.
    pub position: Option<Three<Length>>,
    /// Absent: at rest.
    pub velocity: Option<Three<Speed>>,
}

/// `[[walls]]`: one wall.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WallFile {
    /// A half-space.
    pub plane: Option<Located<PlaneFile>>,
    /// A solid ball.
    pub sphere: Option<Located<SphereFile>>,
    /// A solid block.
    pub cuboid: Option<Located<CuboidFile>>,
    /// A solid cylinder.
    pub cylinder: Option<Located<CylinderFile>>,
    /// e.
    pub restitution: Option<Located<Ratio>>,
    /// μ; absent: 0.
    pub friction: Option<Located<Ratio>>,
    /// Of this wall, where it differs from what `[soft.hertz]` says.
    pub elasticity: Option<Located<ElasticityFile>>,
}

/// A half-space.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneFile {
    /// A point of the surface.
    pub point: Option<Three<Length>>,
    /// Towards the particles, of any length.
    pub normal: Option<Three<Ratio>>,
}

/// A solid ball.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SphereFile {
    /// Centre.
    pub center: Option<Three<Length>>,
    /// Radius.
    pub radius: Option<Located<Length>>,
}

/// A solid block along the axes.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CuboidFile {
    /// Centre.
    pub center: Option<Three<Length>>,
    /// Half the edges.
    pub half_extents: Option<Three<Length>>,
}

/// A solid cylinder along an axis.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CylinderFile {
    /// Centre.
    pub center: Option<Three<Length>>,
    /// Direction.
    pub axis: Option<Located<Axis>>,
    /// Radius.
    pub radius: Option<Located<Length>>,
    /// Half the length.
    pub half_height: Option<Located<Length>>,
}

/// Restitution and friction.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceFile {
    /// e.
    pub restitution: Option<Located<Ratio>>,
    /// μ; absent: 0.
    pub friction: Option<Located<Ratio>>,
}

/// `[soft]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SoftFile {
    /// A contact law: linear.
    pub linear_spring_dashpot: Option<Located<SpringFile>>,
    /// A contact law: of elastic spheres.
    pub hertz: Option<Located<ElasticityFile>>,
    /// N_c; absent: 20.
    pub steps_per_contact: Option<Located<Ratio>>,
    /// Δt.
    pub time_step: Option<Located<Time>>,
    /// Lets a step run that is longer than a fifth of a contact.
    pub allow_large_step: Option<Located<bool>>,
    /// Lets a step run that is beyond the scheme's stability.
    pub allow_unstable: Option<Located<bool>>,
    /// Which particles are stepped; absent: auto.
    pub stepping: Option<Located<SoftStepping>>,
    /// Absent: velocity_verlet.
    pub integrator: Option<Located<Integrator>>,
}

/// `[soft.linear_spring_dashpot]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpringFile {
    /// k_n.
    pub stiffness: Option<Located<Stiffness>>,
}

/// `[soft.hertz]`; a kind of particles or a wall may have its own.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ElasticityFile {
    /// E.
    pub youngs_modulus: Option<Located<Pressure>>,
    /// ν; absent: 0.3.
    pub poissons_ratio: Option<Located<Ratio>>,
}

/// `[hard]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HardFile {
    /// Absent: events.
    pub stepping: Option<Located<HardSteppingFile>>,
    /// θ of the stepped engine; absent: 0.3.
    pub theta: Option<Located<Ratio>>,
    /// t_c of the TC model; absent: every collision has its restitution.
    pub contact_time: Option<Located<Time>>,
}

/// How the hard engine finds collisions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum HardSteppingFile {
    /// At the instants of touch.
    Events,
    /// At the ends of steps.
    Steps,
}

/// `[run]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunFile {
    /// `--model` overrides it.
    pub model: Option<Located<Model>>,
    /// Simulated time.
    pub duration: Option<Located<Time>>,
    /// Absent: 0.
    pub average_from: Option<Located<AverageFromFile>>,
    /// Absent: auto.
    pub window: Option<Located<WindowFile>>,
    /// Absent: 1.
    pub seed: Option<Located<i64>>,
    /// Runs with more windows or steps than anybody would wait for, too. Absent: false.
    pub allow_long: Option<Located<bool>>,
}

/// A time, or `"steady"`.
#[derive(Clone, Copy, Debug)]
pub enum AverageFromFile {
    /// At that time [s].
    Time(f64),
    /// Found by the run.
    Steady,
}

/// A time, or `"auto"`.
#[derive(Clone, Copy, Debug)]
pub enum WindowFile {
    /// That long [s].
    Time(f64),
    /// Chosen from the scene.
    Auto,
}

/// Reads a time or one fixed word.
fn time_or_word<'de, D: serde::Deserializer<'de>>(
    deserializer: D,
    word: &'static str,
) -> Result<Option<f64>, D::Error> {
    struct Either(&'static str);
    impl serde::de::Visitor<'_> for Either {
        type Value = Option<f64>;

        fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
            write!(f, "a time, such as \"2 s\", or \"{}\"", self.0)
        }

        fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<Option<f64>, E> {
            if value.is_finite() {
                return Ok(Some(value));
            }
            let (mark, word) = (super::de::HELP_MARK, self.0);
            Err(E::custom(format_args!("is not a finite number{mark}write a time, such as \"2 s\", or \"{word}\"")))
        }

        fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<Option<f64>, E> {
            Ok(Some(value as f64))
        }

        fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Option<f64>, E> {
            if text == self.0 {
                return Ok(None);
            }
            super::quantity::parse(text, [0, 0, 1]).map(Some).map_err(|error| {
                let help = error.help.unwrap_or_default();
                E::custom(format_args!("{}{}{help}, or \"{}\"", error.message, super::de::HELP_MARK, self.0))
            })
        }
    }
    deserializer.deserialize_any(Either(word))
}

impl<'de> Deserialize<'de> for AverageFromFile {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(time_or_word(deserializer, "steady")?.map_or(Self::Steady, Self::Time))
    }
}

impl<'de> Deserialize<'de> for WindowFile {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(time_or_word(deserializer, "auto")?.map_or(Self::Auto, Self::Time))
    }
}

/// `[statistics]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StatisticsFile {
    /// Slices normal to y; absent: 40.
    pub slices: Option<Located<i64>>,
    /// Absent: chosen from the scene.
    pub sample_interval: Option<Located<Time>>,
}

/// `[[compare]]`: one variant.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CompareFile {
    /// Absent: the model's name.
    pub name: Option<Located<String>>,
    /// Absent: `run.model`.
    pub model: Option<Located<Model>>,
    /// Name of the variant it is compared with; absent: the first hard one, else the first.
    pub against: Option<Located<String>>,
    /// Keys that differ; taken from the tree, where they keep their places.
    pub set: Option<Located<IgnoredAny>>,
}
