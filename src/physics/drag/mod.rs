//! Drag: force of the gas on a sphere along the slip velocity.
//!
//! A kick changes the velocities by the drag that acts during a given time, while the positions stay constant. In a
//! kick the gas velocity is taken as constant, and drag alone changes the slip velocity (the velocity relative to the
//! gas). The slip velocity then keeps its direction. Its magnitude w [m/s] obeys the scalar equation dw/dt = -w/τ(w),
//! with the response time τ [s]. The exact solution is stable for kicks of any length, and two successive kicks of half
//! the time equal one kick of the whole time. A law may have the solution in closed form; otherwise the equation is
//! integrated numerically to 1e-12.
//!
//! To add a law, write one file with `impl DragLaw`. Then add a `mod` line, a variant of [`Drag`] and an arm of `law`.

mod flow;
mod kick;
mod schiller_naumann;
mod stokes;
mod suspension;

pub use kick::Kick;
pub use schiller_naumann::SchillerNaumann;
pub use stokes::Stokes;
pub use suspension::{SuspensionDrag, SuspensionLaw};

use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Properties of a sphere in a gas on which drag depends.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Sphere {
    /// [s] Stokes response time τ_S = ρ_p d² / (18 ρ_f ν), with the diameter d. ρ_p is the density of the particle (its
    /// added mass included), and ρ_f and ν are density and kinematic viscosity of the gas.
    pub stokes_time: f64,
    /// [s/m] Reynolds number divided by slip speed: d/ν.
    pub reynolds_per_speed: f64,
    /// [-] volume fraction of particles around the sphere; 0 for a single sphere.
    pub fraction: f64,
}

impl Sphere {
    /// Returns a sphere of the same material in the same gas, with a diameter `ratio` [-] times as large. The Stokes
    /// response time grows with the square of the diameter, the Reynolds number with the diameter.
    #[inline]
    pub fn scaled(&self, ratio: f64) -> Self {
        Self {
            stokes_time: self.stokes_time * ratio * ratio,
            reynolds_per_speed: self.reynolds_per_speed * ratio,
            ..*self
        }
    }

    /// Returns the sphere with the volume fraction `fraction` [-] of particles around it.
    #[inline]
    pub fn among(&self, fraction: f64) -> Self {
        Self { fraction, ..*self }
    }
}

/// A drag law for a sphere. An implementation must define name, parameters and response time. By default all other
/// quantities are computed from the response time.
///
/// ```
/// # extern crate diptych_physics as diptych;
/// use diptych::drag::{DragLaw, Sphere, Stokes};
///
/// /// Twice the drag of creeping flow.
/// #[derive(Debug)]
/// struct Twice;
///
/// impl DragLaw for Twice {
///     fn name(&self) -> &'static str {
///         "twice_stokes"
///     }
///
///     fn parameters(&self) -> Vec<(&'static str, f64)> {
///         Vec::new()
///     }
///
///     fn response_time(&self, sphere: &Sphere, _slip: f64) -> f64 {
///         0.5 * sphere.stokes_time
///     }
/// }
///
/// let sphere = Sphere { stokes_time: 0.5, reynolds_per_speed: 27.0, fraction: 0.0 };
/// let left = Twice.decay(&sphere, 3.0, 0.1); // of a slip of 3 m/s, after 0.1 s
/// assert!((left - Stokes.decay(&sphere, 3.0, 0.2)).abs() < 1e-12);
/// ```
pub trait DragLaw: std::fmt::Debug + Send + Sync {
    /// Name of the drag law in cases (input files) and in results.
    fn name(&self) -> &'static str;

    /// Names and values [SI] of all parameters of the drag law; empty if there are none. Name and parameters are used
    /// to compare laws and to recognise stored runs. Two laws of one name that differ must therefore differ in a
    /// parameter in this list.
    fn parameters(&self) -> Vec<(&'static str, f64)>;

    /// [s] response time τ(w) > 0 of a sphere: slip speed divided by deceleration, at the slip speed w = `slip` >= 0
    /// [m/s].
    fn response_time(&self, sphere: &Sphere, slip: f64) -> f64;

    /// Title of the drag law for use in a sentence.
    fn title(&self) -> String {
        format!("drag law {}", self.name())
    }

    /// Numbers of cells along x, y and z in which the volume fraction of the particles is computed. `None` if the law
    /// does not depend on this fraction.
    fn cells(&self) -> Option<[u32; 3]> {
        None
    }

    /// [-] slip Reynolds number above which a warning is given, and the text of the warning. At larger numbers the law
    /// is far outside the range to which it was fitted. `None` if no such number is known.
    fn far(&self) -> Option<(f64, &'static str)> {
        None
    }

    /// [-] natural logarithm of the slip speed after `duration` [s] of drag alone over the slip speed w = `slip` >= 0
    /// [m/s] before; at most 0. The gas velocity is constant. The logarithm is -∫dt/τ, from the exact solution of
    /// dw/dt = -w/τ(w).
    ///
    /// A kick (change of the velocities by drag in a given time) needs the ratio of the two speeds minus 1, which is
    /// more precise if it is computed from the logarithm. A law with a closed form overrides this method. By default
    /// the equation is integrated to a relative error of 1e-12.
    fn log_decay(&self, sphere: &Sphere, slip: f64, duration: f64) -> f64 {
        flow::integrate(&|log| -1.0 / self.response_time(sphere, slip * log.exp()), duration)
    }

    /// [s] relaxation time τ_l(w) = 1/(d(w/τ)/dw) of a small change of the slip speed, at the slip speed w = `slip` >=
    /// 0 [m/s], with the response time τ. The default method uses central differences of fourth order, from slip
    /// speeds that differ from w by at most a thousandth. It is accurate to 1e-10 where the law is smooth.
    fn relaxation_time(&self, sphere: &Sphere, slip: f64) -> f64 {
        if slip == 0.0 {
            return self.response_time(sphere, slip);
        }
        let deceleration = |w: f64| w / self.response_time(sphere, w);
        let slope = |step: f64| (deceleration(slip + step) - deceleration(slip - step)) / (2.0 * step);
        // Richardson's extrapolation of two central differences
        3.0 / (4.0 * slope(5e-4 * slip) - slope(1e-3 * slip))
    }

    /// [-] slip speed after `duration` [s] of drag alone, divided by the slip speed `slip` [m/s] before; in [0, 1].
    fn decay(&self, sphere: &Sphere, slip: f64, duration: f64) -> f64 {
        self.log_decay(sphere, slip, duration).exp()
    }

    /// [-] change of the slip velocity in `duration` [s] of drag alone, divided by the slip velocity before; in [-1,
    /// 0]. `slip` [m/s] is the slip speed before. A small change is computed without loss of precision.
    fn change(&self, sphere: &Sphere, slip: f64, duration: f64) -> f64 {
        self.log_decay(sphere, slip, duration).exp_m1()
    }
}

/// Drag law of a gas, either of a type that a case can contain or defined by the calling program.
#[derive(Clone, Debug)]
pub enum Drag {
    /// The law of Schiller and Naumann (1935), which the paper (`docs/paper.md`) uses.
    SchillerNaumann(SchillerNaumann),
    /// Stokes drag of creeping flow, whose solution is known in closed form.
    Stokes(Stokes),
    /// A law for a sphere among other spheres, whose drag increases with their volume fraction.
    Suspension(SuspensionDrag),
    /// A law that the calling program defines; a case cannot contain it.
    Other(Arc<dyn DragLaw>),
}

impl Drag {
    /// Returns the drag law of this variant.
    #[inline]
    pub fn law(&self) -> &dyn DragLaw {
        match self {
            Self::SchillerNaumann(law) => law,
            Self::Stokes(law) => law,
            Self::Suspension(law) => law,
            Self::Other(law) => law.as_ref(),
        }
    }
}

impl PartialEq for Drag {
    /// True if two laws have the same name and the same parameters.
    fn eq(&self, other: &Self) -> bool {
        let (one, other) = (self.law(), other.law());
        one.name() == other.name() && one.parameters() == other.parameters()
    }
}

impl Serialize for Drag {
    /// Serializes a drag law as its name. A law with parameters is serialized as a table of its parameters under its
    /// name, as in a case (input file).
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (name, parameters) = (self.law().name(), self.law().parameters());
        if parameters.is_empty() {
            return serializer.serialize_str(name);
        }
        BTreeMap::from([(name, parameters.into_iter().collect::<BTreeMap<_, _>>())]).serialize(serializer)
    }
}
