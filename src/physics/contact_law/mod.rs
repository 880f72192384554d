//! Contact laws of soft spheres. A contact law gives the force with which two touching bodies push each other apart.
//!
//! Each law of this library has one file in this folder and one variant of [`ContactLaw`]. A program that uses this
//! library can add its own type as [`ContactLaw::Other`]. A law must define four functions: the constants between two
//! bodies, the force, the stored energy, and the parameters. All other quantities are computed by numerical
//! integration ([`numerical`]), unless the law has closed forms.
//!
//! Sign convention: the overlap δ [m] is positive while the bodies touch. Its rate is minus the normal velocity u_n
//! [m/s], which is negative while the bodies approach. A contact ends when δ = 0, the convention of the paper that
//! docs/paper.md describes. The force is therefore slightly attractive at the end, and the restitution is exactly the
//! required one.

mod bodies;
mod contract;
pub mod friction;
mod hertz;
mod kuwabara_kono;
mod linear_spring_dashpot;
pub mod numerical;

pub use bodies::{Bodies, Spring};
pub use contract::BrokenContract;
pub use hertz::Hertz;
pub use kuwabara_kono::KuwabaraKono;
pub use linear_spring_dashpot::LinearSpringDashpot;

use crate::rotation::NormalSpring;
use crate::scene::Elasticity;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Contact law for the normal force. A law must define the four functions without a body; all other functions can be
/// computed from these four.
///
/// A law must satisfy four contracts (conditions). For a law of the calling program they are checked when a simulation
/// is made ([`ContactLaw::check`]). The elastic force is zero at touch. The stored energy at an overlap is the work of
/// the elastic force from touch to this overlap. For every impact there is an overlap at which the stored energy equals
/// the kinetic energy, so that the motion stops. The viscous force never accelerates the motion.
///
/// ```
/// # extern crate diptych_physics as diptych;
/// use diptych::contact_law::{Bodies, ContactLaw, Law, Parameter, Spring};
///
/// /// An elastic force that grows with the square of the overlap.
/// #[derive(Debug)]
/// struct Square {
///     /// [N/m²]
///     stiffness: f64,
/// }
///
/// impl Law for Square {
///     fn between(&self, bodies: &Bodies) -> Spring {
///         let Bodies { effective_mass, restitution, stiffness_ratio, .. } = *bodies;
///         Spring { effective_mass, restitution, stiffness: self.stiffness * stiffness_ratio, dashpot: 0.0 }
///     }
///
///     fn force(&self, spring: &Spring, overlap: f64, _normal_velocity: f64) -> (f64, f64) {
///         (spring.stiffness * overlap * overlap.abs(), 0.0)
///     }
///
///     fn stored_energy(&self, spring: &Spring, overlap: f64) -> f64 {
///         spring.stiffness * overlap.abs().powi(3) / 3.0
///     }
///
///     fn parameters(&self) -> Vec<Parameter> {
///         vec![Parameter { law: "square", key: "stiffness", name: "stiffness", symbol: "k_s", value: self.stiffness, unit: "N/m^2" }]
///     }
/// }
///
/// let law = ContactLaw::other(Square { stiffness: 1e9 });
/// let spring = Spring { effective_mass: 1e-6, restitution: 1.0, stiffness: 1e9, dashpot: 0.0 };
/// // the kinetic energy of 1 m/s is stored at the largest overlap
/// let deepest = (1.5 * 1e-6 / 1e9_f64).cbrt();
/// assert!((law.greatest_overlap(&spring, 1.0) / deepest - 1.0).abs() < 1e-6);
/// ```
pub trait Law: std::fmt::Debug + Send + Sync {
    /// Constants of the law between two bodies. The elastic force between the bodies is that of the law, multiplied by
    /// [`stiffness_ratio`](Bodies::stiffness_ratio).
    fn between(&self, bodies: &Bodies) -> Spring;

    /// [N] elastic and viscous parts of the normal force at the overlap δ [m] and the normal velocity u_n [m/s]. A
    /// step at the end of a contact may use a small negative overlap, so the function must be continuous at δ = 0. The
    /// elastic force at a negative overlap is attractive.
    fn force(&self, spring: &Spring, overlap: f64, normal_velocity: f64) -> (f64, f64);

    /// [J] energy stored at overlap δ [m]: the work of the elastic force since touch.
    fn stored_energy(&self, spring: &Spring, overlap: f64) -> f64;

    /// All numbers in which two laws of one type can differ. The program compares laws, and recognises stored runs, by
    /// these numbers. The first number is the elastic constant that a user increases for a stiffer contact.
    fn parameters(&self) -> Vec<Parameter>;

    /// Name of the law, for use in a sentence.
    fn title(&self) -> &'static str {
        self.parameters().first().map_or("contact law", |parameter| parameter.law)
    }

    /// [N/m^1.5] tangential stiffness of two elastic spheres without sliding, divided by the square root of the
    /// overlap. 0 for a law without elastic constants.
    fn shear_stiffness(&self, _bodies: &Bodies) -> f64 {
        0.0
    }

    /// [-] exponent n of the elastic force, which is roughly proportional to δ^n. Estimates of the stiffness that a run
    /// needs use this exponent.
    fn exponent(&self) -> f64 {
        1.0
    }

    /// [s] duration of an impact at normal speed `speed` > 0 [m/s]; infinite if the impact does not end.
    fn contact_time(&self, spring: &Spring, speed: f64) -> f64 {
        numerical::IntegratedImpact::new(self, spring, speed).map_or(f64::INFINITY, |impact| impact.duration())
    }

    /// [m] largest overlap of an impact at normal speed `speed` [m/s].
    fn greatest_overlap(&self, spring: &Spring, speed: f64) -> f64 {
        numerical::greatest_overlap(self, spring, speed)
    }

    /// [1/s] highest angular frequency sqrt(f'(δ)/M) during an impact at normal speed `speed` [m/s]. Here f' is the
    /// slope of the elastic force at the overlap δ, and M the effective mass. The time step must be stable for this
    /// frequency.
    fn frequency(&self, spring: &Spring, speed: f64) -> f64 {
        numerical::frequency(self, spring, speed)
    }

    /// [-] largest viscous constant (viscous force over normal velocity) during impacts at normal speed `speed` [m/s],
    /// over the critical constant 2 M ω, with the effective mass M and ω = [`frequency`](Self::frequency). The time
    /// step must be stable for both the frequency and the damping.
    fn damping_ratio(&self, spring: &Spring, speed: f64) -> f64 {
        numerical::damping_ratio(self, spring, speed)
    }

    /// [m] ∫ exp(-V(δ)/E) dδ over all overlaps δ, with the stored energy V and the energy scale E = `energy` [J] of the
    /// relative motion. Soft spheres with this energy collide like hard spheres whose diameter is smaller by this
    /// length (Barker and Henderson 1967, J. Chem. Phys. 47, 4714).
    fn thermal_overlap(&self, spring: &Spring, energy: f64) -> f64 {
        numerical::thermal_overlap(self, spring, energy)
    }

    /// Returns a function of the time [s] since touch, for an impact at normal speed `speed` [m/s]. The function
    /// returns the overlap [m] and the rate of the overlap [m/s], up to the end of the impact.
    fn course(&self, spring: &Spring, speed: f64) -> Box<dyn Fn(f64) -> (f64, f64)> {
        let impact = numerical::IntegratedImpact::new(self, spring, speed);
        Box::new(move |time| impact.as_ref().map_or((f64::NAN, f64::NAN), |impact| impact.at(time)))
    }

    /// [m] overlap of a contact at rest with the normal force `force` [N].
    fn static_overlap(&self, spring: &Spring, force: f64) -> f64 {
        numerical::static_overlap(self, spring, force)
    }

    /// [J] depth of the minimum of the stored energy, as a function of the overlap, below the energy at touch; 0 for a
    /// law without attraction.
    fn well_depth(&self, spring: &Spring) -> f64 {
        numerical::well_depth(self, spring)
    }

    /// [-] factor by which the elastic force must grow so that impacts of equal energy have 1/`ratio` times the
    /// overlap. The energy stored at the overlap δ is assumed to be k δ^(n+1)/(n+1), with constants k and n.
    fn stiffening(&self, ratio: f64) -> f64 {
        ratio.powf(self.exponent() + 1.0)
    }
}

/// A parameter of a contact law, for tables and messages.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Parameter {
    /// Name of the law, and of its table below `[soft]` in a case (input file).
    pub law: &'static str,
    /// Key of the parameter in the table of the law.
    pub key: &'static str,
    /// Name of the parameter for use in a sentence.
    pub name: &'static str,
    /// Symbol of the parameter in formulas.
    pub symbol: &'static str,
    /// Value of the parameter in SI units: the unit is `unit`.
    pub value: f64,
    /// SI unit of the value.
    pub unit: &'static str,
}

impl Parameter {
    /// Key of the parameter in a case, with the names of its tables.
    pub fn path(&self) -> String {
        format!("soft.{}.{}", self.law, self.key)
    }
}

impl std::fmt::Display for Parameter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // large values, such as moduli, are written with an exponent, because they have many digits
        if self.value < 1e6 {
            write!(f, "{} {} {}", self.name, self.value, self.unit)
        } else {
            write!(f, "{} {:e} {}", self.name, self.value, self.unit)
        }
    }
}

/// Contact law of all pairs of particles and of all walls in a scene of soft or hybrid spheres.
///
/// ```
/// # extern crate diptych_physics as diptych;
/// use diptych::contact_law::{Bodies, ContactLaw};
/// use diptych::{Species, Surface};
///
/// let glass = Species::new("glass", 1e-3, 2500.0);
/// let law = ContactLaw::linear(1000.0); // N/m
/// let spring = law.between(&Bodies::alike(&glass, &Surface::new(1.0, 0.0)));
/// // without damping a contact of two spheres lasts π sqrt(M/k_n), with M half the mass of one sphere
/// let lasts = std::f64::consts::PI * (0.5 * glass.mass() / 1000.0).sqrt(); // s
/// assert!((law.contact_time(&spring, 0.1) / lasts - 1.0).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug)]
pub enum ContactLaw {
    /// Linear spring parallel to a linear dashpot.
    LinearSpringDashpot(LinearSpringDashpot),
    /// Hertz's law for elastic spheres, with a viscous force.
    Hertz(Hertz),
    /// Hertz's law for viscoelastic spheres, with the damping of Kuwabara and Kono.
    KuwabaraKono(KuwabaraKono),
    /// A law of the calling program, which a case cannot contain.
    Other(&'static dyn Law),
}

/// Evaluates an expression with the chosen contact law. For the laws of this library, the type is fixed when the
/// program is compiled, so that no virtual call is needed.
macro_rules! with_law {
    ($chosen:expr, $law:ident => $value:expr) => {
        match $chosen {
            $crate::contact_law::ContactLaw::LinearSpringDashpot($law) => $value,
            $crate::contact_law::ContactLaw::Hertz($law) => $value,
            $crate::contact_law::ContactLaw::KuwabaraKono($law) => $value,
            $crate::contact_law::ContactLaw::Other($law) => {
                let $law: &dyn $crate::contact_law::Law = *$law;
                $value
            }
        }
    };
}

pub(crate) use with_law;

impl ContactLaw {
    /// Makes the law of a linear spring with the stiffness k_n [N/m] parallel to a linear dashpot.
    pub const fn linear(stiffness: f64) -> Self {
        Self::LinearSpringDashpot(LinearSpringDashpot { stiffness })
    }

    /// Makes a law from a type of the calling program. The law stays in memory until the program ends, so a copy of
    /// this value is only a reference.
    pub fn other(law: impl Law + 'static) -> Self {
        Self::Other(Box::leak(Box::new(law)))
    }

    /// Returns the elastic and the viscous force [N], as [`Law::force`] defines them. For laws of this library a
    /// virtual call is avoided, because every time step calls this method.
    #[inline]
    pub fn force(&self, spring: &Spring, overlap: f64, normal_velocity: f64) -> (f64, f64) {
        with_law!(self, law => law.force(spring, overlap, normal_velocity))
    }

    /// Returns the stored energy [J], as [`Law::stored_energy`] defines it. For laws of this library a virtual call is
    /// avoided.
    #[inline]
    pub fn stored_energy(&self, spring: &Spring, overlap: f64) -> f64 {
        with_law!(self, law => law.stored_energy(spring, overlap))
    }

    /// [J] largest energy that a contact at the overlap `overlap` [m] can give back as kinetic energy: its stored
    /// energy, counted from the minimum of the stored energy.
    #[inline]
    pub fn available_energy(&self, spring: &Spring, overlap: f64) -> f64 {
        with_law!(self, law => law.stored_energy(spring, overlap) + law.well_depth(spring))
    }

    /// Returns this law with an elastic force that is `factor` [-] times as large at every overlap.
    pub fn stiffened(&self, factor: f64) -> Self {
        match self {
            Self::LinearSpringDashpot(law) => Self::LinearSpringDashpot(law.stiffened(factor)),
            Self::Hertz(law) => Self::Hertz(law.stiffened(factor)),
            Self::KuwabaraKono(law) => Self::KuwabaraKono(law.stiffened(factor)),
            Self::Other(law) => Self::other(Stiffened { law: *law, factor }),
        }
    }

    /// First parameter of the law, which is the elastic constant that a user sets. For a law without parameters,
    /// returns a parameter with the value 1.
    pub fn parameter(&self) -> Parameter {
        let none = Parameter { law: self.title(), key: "", name: "stiffness", symbol: "k", value: 1.0, unit: "" };
        self.parameters().first().copied().unwrap_or(none)
    }

    /// Constants of the normal contact of two bodies, from which a tangential law computes the constants of its spring.
    pub fn normal_spring(&self, bodies: &Bodies, spring: &Spring) -> NormalSpring {
        let Spring { stiffness, dashpot, .. } = *spring;
        let contact_time = if self.is_linear() { self.contact_time(spring, 1.0) } else { f64::INFINITY };
        let (exponent, shear_stiffness) = (self.exponent(), self.shear_stiffness(bodies));
        let half_powers = (2.0 * (exponent - 1.0)).round().max(0.0) as u8;
        NormalSpring { stiffness, dashpot, contact_time, tangent: exponent * stiffness, half_powers, shear_stiffness }
    }

    /// [-] ratio of Mindlin's tangential stiffness to the elastic constant of Hertz's law, for two bodies with these
    /// elasticities. 0 for laws without elastic constants.
    pub fn shear_ratio(&self, elasticity: [Option<Elasticity>; 2]) -> f64 {
        let (effective_mass, effective_radius, restitution, stiffness_ratio) = (1.0, 1.0, 1.0, 1.0);
        let by_speed = None;
        let bodies = Bodies { effective_mass, effective_radius, restitution, by_speed, elasticity, stiffness_ratio };
        self.shear_stiffness(&bodies) / self.between(&bodies).stiffness
    }

    /// True for the linear spring-dashpot law of this library, for which closed forms of linear contacts are valid.
    /// False for all other laws, also for linear laws of the calling program.
    pub fn is_linear(&self) -> bool {
        matches!(self, Self::LinearSpringDashpot(_))
    }
}

impl PartialEq for ContactLaw {
    /// True if two laws have the same name and the same parameters.
    fn eq(&self, other: &Self) -> bool {
        self.title() == other.title() && self.parameters() == other.parameters()
    }
}

impl Serialize for ContactLaw {
    /// Serializes the law as the table that describes it in a case.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let parameters = self.parameters();
        let values: BTreeMap<_, _> = parameters.iter().map(|parameter| (parameter.key, parameter.value)).collect();
        BTreeMap::from([(self.parameter().law, values)]).serialize(serializer)
    }
}

impl std::fmt::Display for ContactLaw {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}, {}", self.title(), self.parameter())
    }
}

impl std::ops::Deref for ContactLaw {
    type Target = dyn Law;

    fn deref(&self) -> &(dyn Law + 'static) {
        match self {
            Self::LinearSpringDashpot(law) => law,
            Self::Hertz(law) => law,
            Self::KuwabaraKono(law) => law,
            Self::Other(law) => *law,
        }
    }
}

/// A law of the calling program, with its elastic force multiplied by a factor.
#[derive(Debug)]
struct Stiffened {
    law: &'static dyn Law,
    /// [-] ratio of the elastic force to that of `law`.
    factor: f64,
}

impl Law for Stiffened {
    fn between(&self, bodies: &Bodies) -> Spring {
        self.law.between(&Bodies { stiffness_ratio: bodies.stiffness_ratio * self.factor, ..*bodies })
    }

    fn force(&self, spring: &Spring, overlap: f64, normal_velocity: f64) -> (f64, f64) {
        self.law.force(spring, overlap, normal_velocity)
    }

    fn stored_energy(&self, spring: &Spring, overlap: f64) -> f64 {
        self.law.stored_energy(spring, overlap)
    }

    /// Parameters of the unchanged law, with the first of them, the elastic constant, multiplied by `factor`.
    fn parameters(&self) -> Vec<Parameter> {
        let mut parameters = self.law.parameters();
        parameters.iter_mut().take(1).for_each(|first| first.value *= self.factor);
        parameters
    }

    fn title(&self) -> &'static str {
        self.law.title()
    }

    fn exponent(&self) -> f64 {
        self.law.exponent()
    }

    fn shear_stiffness(&self, bodies: &Bodies) -> f64 {
        self.law.shear_stiffness(&Bodies { stiffness_ratio: bodies.stiffness_ratio * self.factor, ..*bodies })
    }
}

/// [-] damping ratio ζ = -ln e / sqrt(π² + ln² e) of a linear spring and dashpot with the restitution e (below Eq. 6
/// of the paper in docs/paper.md). It is 1 for e = 0.
pub fn damping_ratio(restitution: f64) -> f64 {
    if restitution <= 0.0 {
        return 1.0;
    }
    let ln = restitution.ln();
    -ln / (PI * PI + ln * ln).sqrt()
}

/// [-] largest overlap of an impact at the normal speed u on a linear spring and dashpot, divided by u/ω_0, with the
/// undamped angular frequency ω_0. With the damping ratio ζ it is exp(-ζ arccos ζ / sqrt(1 - ζ²)) (Eq. 10 of the paper
/// in docs/paper.md).
pub fn reduced_overlap(restitution: f64) -> f64 {
    let ratio = damping_ratio(restitution);
    if ratio >= 1.0 {
        return (-1.0f64).exp(); // the limit for ζ -> 1, which is critical damping
    }
    (-ratio * ratio.acos() / (1.0 - ratio * ratio).sqrt()).exp()
}
