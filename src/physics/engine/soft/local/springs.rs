//! Relative motion that stretches the springs of a contact (slip, rolling and twisting), and the limits of their
//! forces.

use super::{InstantaneousRule, IslandRun};
use crate::contact_law::ContactLaw;
use crate::encounter::{Couple, Encounter};
use crate::engine::soft::contact::{TouchingPair, relative_gravity};
use crate::engine::soft::rolling::RollingMotion;
use crate::rotation::{Resistance, SpringDashpotSlider, SpringRates, slip};
use nalgebra::Vector3;

/// Kind of relative motion that stretches a spring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpringKind {
    /// Slip of the two surfaces at the contact.
    Slide,
    /// Rolling of the surfaces on one another.
    Roll,
    /// Rotation of one surface relative to the other about the normal.
    Twist,
}

impl SpringKind {
    /// All kinds of motion, in the order in which the springs of a contact are stored.
    pub const ALL: [Self; 3] = [Self::Slide, Self::Roll, Self::Twist];

    /// Component of `vector` that a spring of this kind can have: along `normal` for twisting, perpendicular to
    /// `normal` for sliding and rolling.
    pub fn in_space_of(self, vector: &Vector3<f64>, normal: &Vector3<f64>) -> Vector3<f64> {
        let along = normal * vector.dot(normal);
        if self == Self::Twist { along } else { vector - along }
    }
}

/// Turns a vector, perpendicular to the unit normal `from`, by the shortest rotation from `from` to the unit normal
/// `to`. The vector of a twisting spring stays along the normal.
#[inline(always)]
pub fn carried(kind: SpringKind, vector: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> Vector3<f64> {
    if kind == SpringKind::Twist {
        return to * vector.dot(from);
    }
    let cosine = 1.0 + from.dot(to);
    if cosine > 0.0 { vector - (from + to) * (vector.dot(to) / cosine) } else { *vector }
}

/// Relative motion and normal force of a contact between bodies that rotate.
pub struct ContactMotion {
    /// [m/s] slip velocity of the two surfaces at the contact.
    slip: Vector3<f64>,
    /// [-] lever arm of the tangential force about the centre of a sphere, divided by the radius of the sphere.
    pub arm: f64,
    /// [N] elastic part of the normal force of the contact.
    pub elastic: f64,
    /// [N] part of the normal force that the dashpot causes.
    pub viscous: f64,
    /// Rolling and twisting motion; `None` if the contact does not resist this motion.
    pub rolling: Option<RollingMotion>,
}

/// Motion that stretches one spring of a contact, and the properties of this spring.
#[derive(Clone, Copy, Debug)]
pub struct SpringMotion {
    /// Kind of motion that stretches the spring.
    pub kind: SpringKind,
    /// [m/s] relative velocity that stretches the spring.
    pub velocity: Vector3<f64>,
    /// Constants of the spring at the present overlap.
    pub constants: SpringDashpotSlider,
    /// [-] increase of the shear per distance that the surfaces move relative to each other. It is below 1 at first
    /// touch if the stiffness grows with the overlap.
    pub grown: f64,
    /// [1/s] relative rates at which the changing overlap changes the shear, the force and the dashpot of the spring.
    pub rates: SpringRates,
    /// [-] largest force of the spring divided by the normal force.
    friction: f64,
    /// [N] largest force of the spring. Friction sets this limit: at the limit the surfaces slide.
    pub limit: f64,
    /// True if the overlap is at most `TOUCHING` diameters, so that the contact counts as just begun.
    pub at_touch: bool,
    /// Resistance to rolling or twisting; `None` for the spring of slip.
    pub resistance: Option<Resistance>,
}

/// [-] overlap, divided by the diameter, up to which a contact counts as one that has just begun.
const TOUCHING: f64 = 1e-9;

/// [-] short time as a fraction of a time step. The force of a beginning contact and its limit are compared after this
/// time, and rates of change are computed as finite differences over it.
const SOON: f64 = 1e-4;

impl ContactMotion {
    /// Present motion of the surfaces of two touching bodies. Rolling and twisting are included if `resists` is true.
    #[inline(always)]
    pub fn of(
        run: &IslandRun<'_, impl InstantaneousRule>,
        touch: &TouchingPair,
        met: &Encounter,
        resists: bool,
    ) -> Self {
        let (surface, arm) = touch.couple.surface_velocity(run.particles, touch.reach, met.gap);
        let (elastic, viscous) = run.engine.law.force(&touch.spring, met.overlap(), met.normal_velocity);
        let rotation = run.scene.rotation.as_ref().filter(|rotation| resists && rotation.resists());
        let rolling = rotation.map(|rotation| {
            let (law, couple) = (&run.engine.law, &touch.couple);
            RollingMotion::of(couple, &touch.constants, (law, rotation), met, (run.particles, run.scene))
        });
        Self { slip: slip(&met.velocity, &met.normal, &surface), arm, elastic, viscous, rolling }
    }

    /// [m] effective radius R_eff, the lever arm of rolling and twisting resistance; 0 without resistance.
    pub fn rolling_radius(&self) -> f64 {
        self.rolling.as_ref().map_or(0.0, |rolling| rolling.bodies.radius)
    }

    /// Motion that stretches the spring of the kind `kind`.
    #[inline(always)]
    pub fn spring(&self, kind: SpringKind, touch: &TouchingPair, met: &Encounter) -> SpringMotion {
        let none = (SpringDashpotSlider::default(), 0.0);
        let of = |resistance: Option<Resistance>| resistance.map_or(none, |some| (some.spring, some.friction));
        let (velocity, (constants, friction), resistance) = match (kind, &self.rolling) {
            (SpringKind::Slide, _) => (self.slip, (touch.tangential, touch.friction), None),
            (SpringKind::Roll, Some(motion)) => (motion.rolling, of(motion.against_rolling), motion.against_rolling),
            (SpringKind::Twist, Some(motion)) => {
                (met.normal * motion.twisting, of(motion.against_twisting), motion.against_twisting)
            }
            (_, None) => (Vector3::zeros(), none, None),
        };
        let limit = SpringDashpotSlider::limit(friction, self.elastic + self.viscous);
        let at_touch = met.overlap() <= TOUCHING * touch.diameter;
        let (grown, rates) = match (constants.half_powers, at_touch) {
            (0, _) => (1.0, SpringRates::default()),
            (_, true) => (constants.growth(0.0, 1.0).1, SpringRates::default()),
            (_, false) => (1.0, constants.rates(-met.normal_velocity / met.overlap())),
        };
        let constants = constants.at(met.overlap());
        SpringMotion { kind, velocity, constants, grown, rates, friction, limit, at_touch, resistance }
    }
}

impl SpringMotion {
    /// True if the spring of a contact that begins without force slides at once. The force of the spring and its limit
    /// are compared shortly after the touch; `step` [s] is the time step.
    pub fn slides_from_touch(&self, law: &ContactLaw, touch: &TouchingPair, met: &Encounter, step: f64) -> bool {
        let time = SOON * step;
        let overlap = -met.normal_velocity * time;
        let (elastic, viscous) = law.force(&touch.spring, overlap, met.normal_velocity);
        let stiffness = match &self.resistance {
            Some(resistance) => resistance.spring.at(overlap).stiffness,
            None => touch.tangential.at(overlap).stiffness,
        };
        stiffness * self.grown * self.velocity.norm() * time > self.friction * (elastic + viscous)
    }

    /// True if the spring has a memory. Its friction coefficient must then be above 0, and its stiffness must be above
    /// 0 now or as soon as the overlap grows.
    pub fn remembers(&self) -> bool {
        let stiff = match &self.resistance {
            Some(resistance) => resistance.spring.stiffness > 0.0,
            None => self.constants.stiffness > 0.0 || (self.at_touch && self.constants.half_powers > 0),
        };
        stiff && self.friction > 0.0
    }

    /// [N/s] rate of change of the largest force of the spring. `acceleration` [m/s²] is the rate of change of the
    /// normal velocity, and `dt` [s] the time step.
    pub fn limit_rate(
        &self,
        law: &ContactLaw,
        touch: &TouchingPair,
        met: &Encounter,
        (acceleration, dt): (f64, f64),
    ) -> f64 {
        // a finite difference over this short time is accurate enough to find when sliding ends
        let time = SOON * dt;
        let force = |overlap: f64, velocity: f64| {
            let (elastic, viscous) = law.force(&touch.spring, overlap, velocity);
            // the limit of twisting is proportional to the radius of the contact area
            let factor = if self.kind == SpringKind::Twist { (overlap / met.overlap()).abs().sqrt() } else { 1.0 };
            factor * (elastic + viscous)
        };
        let later = force(met.overlap() - met.normal_velocity * time, met.normal_velocity + acceleration * time);
        self.friction * (later - force(met.overlap(), met.normal_velocity)) / time
    }
}

impl<I: InstantaneousRule> IslandRun<'_, I> {
    /// [m/s²] acceleration of a particle by gravity relative to a wall, at the present time.
    pub(super) fn fall_onto(&self, couple: &Couple, met: &Encounter) -> Vector3<f64> {
        relative_gravity(couple, met, (self.particles, self.scene), self.moment())
    }
}
