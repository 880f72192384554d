//! Contact laws of soft spheres: the force with which two touching bodies push each other apart.
//!
//! A law is one file here and one variant of [`ContactLaw`], or a type of the caller's behind [`ContactLaw::Other`].
//! Four answers are required: the constants between two bodies, the force, the stored energy, and the parameters. All
//! others follow by numerical integration ([`numerical`]); a law with closed forms gives these instead.
//!
//! Sign convention: the overlap δ [m] is positive while the bodies touch. Its rate is minus the normal velocity u_n
//! [m/s], which is negative while the bodies approach. A contact ends when δ = 0 (the paper's convention). So the
//! force pulls a little at the end, and the restitution is exactly the one asked for.

mod bodies;
mod contract;
pub mod friction;
mod hertz;
mod linear_spring_dashpot;
pub mod numerical;

pub use bodies::{Bodies, Spring};
pub use contract::BrokenContract;
pub use hertz::Hertz;
pub use linear_spring_dashpot::LinearSpringDashpot;

use crate::rotation::NormalSpring;
use crate::scene::Elasticity;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// A contact law for the normal force. Four answers are needed; the others follow from these.
///
/// Contracts, checked when a simulation is made ([`ContactLaw::check`]): the elastic force vanishes at touch, its work
/// up to an overlap is the stored energy there, some overlap stores the energy of every impact, and the viscous force
/// never drives the motion.
///
/// ```
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
    /// Constants of the law between two bodies; the elastic force is [`stiffness_ratio`](Bodies::stiffness_ratio) times
    /// that of the law.
    fn between(&self, bodies: &Bodies) -> Spring;

    /// [N] elastic and viscous parts of the normal force at overlap δ [m] and normal velocity u_n [m/s]. A step may try
    /// a small negative overlap at the end of a contact: the force goes on smoothly there, and pulls.
    fn force(&self, spring: &Spring, overlap: f64, normal_velocity: f64) -> (f64, f64);

    /// [J] energy stored at overlap δ [m]: the work of the elastic force since touch.
    fn stored_energy(&self, spring: &Spring, overlap: f64) -> f64;

    /// All numbers that tell two laws apart; the first is the elastic one that a user makes larger for a stiffer
    /// contact. Laws are compared, and stored runs are recognised, by these.
    fn parameters(&self) -> Vec<Parameter>;

    /// Name of the law in a sentence.
    fn title(&self) -> &'static str {
        self.parameters().first().map_or("contact law", |parameter| parameter.law)
    }

    /// [N/m^1.5] tangential stiffness of two elastic spheres that do not slip, over the root of the overlap; 0 of a law
    /// without elastic constants.
    fn shear_stiffness(&self, _bodies: &Bodies) -> f64 {
        0.0
    }

    /// [-] n, if the elastic force is about proportional to the overlap to the power n. Estimates of the stiffness that
    /// a run needs assume it.
    fn exponent(&self) -> f64 {
        1.0
    }

    /// [s] duration of an impact at normal speed `speed` > 0 [m/s]; infinite if it does not end.
    fn contact_time(&self, spring: &Spring, speed: f64) -> f64 {
        numerical::IntegratedImpact::new(self, spring, speed).map_or(f64::INFINITY, |impact| impact.duration())
    }

    /// [m] largest overlap of an impact at normal speed `speed` [m/s].
    fn greatest_overlap(&self, spring: &Spring, speed: f64) -> f64 {
        numerical::greatest_overlap(self, spring, speed)
    }

    /// [1/s] highest angular frequency sqrt(f'(δ)/M) that an impact at normal speed `speed` [m/s] reaches: a time
    /// step must be stable for it.
    fn frequency(&self, spring: &Spring, speed: f64) -> f64 {
        numerical::frequency(self, spring, speed)
    }

    /// [-] largest viscous constant at overlaps that impacts at normal speed `speed` [m/s] reach, over the critical one
    /// 2 M ω of the [`frequency`](Self::frequency) ω: a time step must be stable for both.
    fn damping_ratio(&self, spring: &Spring, speed: f64) -> f64 {
        numerical::damping_ratio(self, spring, speed)
    }

    /// [m] ∫ exp(-V(δ)/E) dδ over all overlaps, V the stored energy: spheres whose relative motion has the energy scale
    /// `energy` E [J] act on one another as if smaller by that much (Barker and Henderson 1967, J. Chem. Phys. 47,
    /// 4714).
    fn thermal_overlap(&self, spring: &Spring, energy: f64) -> f64 {
        numerical::thermal_overlap(self, spring, energy)
    }

    /// Overlap [m] and its rate [m/s] at a time [s] after the touch of an impact at normal speed `speed` [m/s], for
    /// every time up to its end.
    fn course(&self, spring: &Spring, speed: f64) -> Box<dyn Fn(f64) -> (f64, f64)> {
        let impact = numerical::IntegratedImpact::new(self, spring, speed);
        Box::new(move |time| impact.as_ref().map_or((f64::NAN, f64::NAN), |impact| impact.at(time)))
    }

    /// [m] overlap of a contact at rest that carries `force` [N].
    fn static_overlap(&self, spring: &Spring, force: f64) -> f64 {
        numerical::static_overlap(self, spring, force)
    }

    /// [J] by how much the stored energy falls below that of touch at the overlap where it is least; 0 of a law that
    /// does not attract.
    fn well_depth(&self, spring: &Spring) -> f64 {
        numerical::well_depth(self, spring)
    }

    /// [-] factor by which the law must be stiffer for impacts of equal energy to go only 1/`ratio` as deep. The
    /// energy at overlap δ is k δ^(n+1)/(n+1).
    fn stiffening(&self, ratio: f64) -> f64 {
        ratio.powf(self.exponent() + 1.0)
    }
}

/// A number that a law has, for tables and messages.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Parameter {
    /// Name of the law, and of its table in a case below `[soft]`.
    pub law: &'static str,
    /// Key in that table.
    pub key: &'static str,
    /// Name for use in a sentence.
    pub name: &'static str,
    /// Symbol of the parameter.
    pub symbol: &'static str,
    /// Value in SI units.
    pub value: f64,
    /// SI unit of the value.
    pub unit: &'static str,
}

impl Parameter {
    /// The key of a case with the tables that it stands in.
    pub fn path(&self) -> String {
        format!("soft.{}.{}", self.law, self.key)
    }
}

impl std::fmt::Display for Parameter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // moduli have too many digits to be read in full
        if self.value < 1e6 {
            write!(f, "{} {} {}", self.name, self.value, self.unit)
        } else {
            write!(f, "{} {:e} {}", self.name, self.value, self.unit)
        }
    }
}

/// The contact law of a soft scene, for pairs and walls.
///
/// ```
/// use diptych::contact_law::{Bodies, ContactLaw};
/// use diptych::{Species, Surface};
///
/// let glass = Species { name: "glass".into(), diameter: 1e-3, density: 2500.0, elasticity: None, sizes: None, inertia_factor: 0.4 };
/// let law = ContactLaw::linear(1000.0); // N/m
/// let spring = law.between(&Bodies::alike(&glass, &Surface { restitution: 1.0, friction: 0.0 }));
/// // without damping a contact of two spheres lasts π sqrt(M/k_n), M half the mass of one
/// let lasts = std::f64::consts::PI * (0.5 * glass.mass() / 1000.0).sqrt(); // s
/// assert!((law.contact_time(&spring, 0.1) / lasts - 1.0).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug)]
pub enum ContactLaw {
    /// A linear spring beside a linear dashpot.
    LinearSpringDashpot(LinearSpringDashpot),
    /// Hertz's law with a viscous part.
    Hertz(Hertz),
    /// A law of the caller's; a case cannot name it.
    Other(&'static dyn Law),
}

/// Evaluates an expression with the chosen law: the only code that lists all laws.
macro_rules! with_law {
    ($chosen:expr, $law:ident => $value:expr) => {
        match $chosen {
            $crate::contact_law::ContactLaw::LinearSpringDashpot($law) => $value,
            $crate::contact_law::ContactLaw::Hertz($law) => $value,
            $crate::contact_law::ContactLaw::Other($law) => {
                let $law: &dyn $crate::contact_law::Law = *$law;
                $value
            }
        }
    };
}

pub(crate) use with_law;

impl ContactLaw {
    /// A linear spring of stiffness k_n [N/m] beside a linear dashpot.
    pub const fn linear(stiffness: f64) -> Self {
        Self::LinearSpringDashpot(LinearSpringDashpot { stiffness })
    }

    /// A law of the caller's. It stays in memory to the end of the program, so that laws can be copied as the numbers
    /// that they mostly are.
    pub fn other(law: impl Law + 'static) -> Self {
        Self::Other(Box::leak(Box::new(law)))
    }

    /// [N] as [`Law::force`]; asked in every time step, so it is answered without a virtual call.
    #[inline]
    pub fn force(&self, spring: &Spring, overlap: f64, normal_velocity: f64) -> (f64, f64) {
        with_law!(self, law => law.force(spring, overlap, normal_velocity))
    }

    /// [J] as [`Law::stored_energy`], without a virtual call.
    #[inline]
    pub fn stored_energy(&self, spring: &Spring, overlap: f64) -> f64 {
        with_law!(self, law => law.stored_energy(spring, overlap))
    }

    /// [J] energy that a contact at overlap δ [m] may give back to the motion at most; >= 0.
    #[inline]
    pub fn available_energy(&self, spring: &Spring, overlap: f64) -> f64 {
        with_law!(self, law => law.stored_energy(spring, overlap) + law.well_depth(spring))
    }

    /// This law, `factor` [-] times as stiff: the elastic force at every overlap is so much larger.
    pub fn stiffened(&self, factor: f64) -> Self {
        match self {
            Self::LinearSpringDashpot(law) => Self::LinearSpringDashpot(law.stiffened(factor)),
            Self::Hertz(law) => Self::Hertz(law.stiffened(factor)),
            Self::Other(law) => Self::other(Stiffened { law: *law, factor }),
        }
    }

    /// The elastic parameter that a user chooses. A law without parameters has the factor by which it was made stiffer.
    pub fn parameter(&self) -> Parameter {
        let none = Parameter { law: self.title(), key: "", name: "stiffness", symbol: "k", value: 1.0, unit: "" };
        self.parameters().first().copied().unwrap_or(none)
    }

    /// Normal contact of two bodies as a tangential law needs it.
    pub fn normal_spring(&self, bodies: &Bodies, spring: &Spring) -> NormalSpring {
        let Spring { stiffness, dashpot, .. } = *spring;
        let contact_time = if self.is_linear() { self.contact_time(spring, 1.0) } else { f64::INFINITY };
        let (exponent, shear_stiffness) = (self.exponent(), self.shear_stiffness(bodies));
        let half_powers = (2.0 * (exponent - 1.0)).round().max(0.0) as u8;
        NormalSpring { stiffness, dashpot, contact_time, tangent: exponent * stiffness, half_powers, shear_stiffness }
    }

    /// [-] Mindlin's tangential stiffness over the elastic constant of Hertz's law, between two bodies with these
    /// elasticities; 0 of other laws.
    pub fn shear_ratio(&self, elasticity: [Option<Elasticity>; 2]) -> f64 {
        let (effective_mass, effective_radius, restitution, stiffness_ratio) = (1.0, 1.0, 1.0, 1.0);
        let bodies = Bodies { effective_mass, effective_radius, restitution, elasticity, stiffness_ratio };
        self.shear_stiffness(&bodies) / self.between(&bodies).stiffness
    }

    /// True if the elastic force is proportional to the overlap and the viscous one to its rate: closed forms for such
    /// contacts hold.
    pub fn is_linear(&self) -> bool {
        matches!(self, Self::LinearSpringDashpot(_))
    }
}

impl PartialEq for ContactLaw {
    /// Laws with equal parameters are one law.
    fn eq(&self, other: &Self) -> bool {
        self.title() == other.title() && self.parameters() == other.parameters()
    }
}

impl Serialize for ContactLaw {
    /// Serializes the law as its table of the case.
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
            Self::Other(law) => *law,
        }
    }
}

/// A law of the caller's with another stiffness.
#[derive(Debug)]
struct Stiffened {
    law: &'static dyn Law,
    /// [-]
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

    /// Those of the law, the first times the factor.
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
}

/// [-] damping ratio ζ = -ln e / sqrt(π² + ln² e) of a linear spring and dashpot with restitution e (the paper, below
/// Eq. 6); 1 for e = 0.
pub fn damping_ratio(restitution: f64) -> f64 {
    if restitution <= 0.0 {
        return 1.0;
    }
    let ln = restitution.ln();
    -ln / (PI * PI + ln * ln).sqrt()
}

/// [-] largest overlap of an impact on a linear spring and dashpot, in units of u/ω_0 (the paper's Eq. 10):
/// exp(-ζ arccos ζ / sqrt(1 - ζ²)).
pub fn reduced_overlap(restitution: f64) -> f64 {
    let ratio = damping_ratio(restitution);
    if ratio >= 1.0 {
        return (-1.0f64).exp(); // the limit ζ -> 1: critical damping
    }
    (-ratio * ratio.acos() / (1.0 - ratio * ratio).sqrt()).exp()
}
