//! Motion against the springs of a contact: slip, rolling and twisting, and the limits of their forces.

use super::{InstantaneousRule, IslandRun};
use crate::contact_law::ContactLaw;
use crate::encounter::Encounter;
use crate::engine::soft::contact::TouchingPair;
use crate::engine::soft::rolling::RollingMotion;
use crate::rotation::{Resistance, SpringDashpotSlider, SpringRates, slip};
use nalgebra::Vector3;

/// Relative motion that stretches a spring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpringKind {
    /// The surfaces slip.
    Slide,
    /// They roll on one another.
    Roll,
    /// They turn against one another about the normal.
    Twist,
}

impl SpringKind {
    /// All kinds, in the order of a contact's springs.
    pub const ALL: [Self; 3] = [Self::Slide, Self::Roll, Self::Twist];

    /// The part of a vector that such a spring can have: along the normal if the contact twists, else normal to it.
    pub fn in_space_of(self, vector: &Vector3<f64>, normal: &Vector3<f64>) -> Vector3<f64> {
        let along = normal * vector.dot(normal);
        if self == Self::Twist { along } else { vector - along }
    }
}

/// A vector normal to `from`, carried along to the plane normal to `to` by the shortest turn; that of a twist stays
/// along the normal.
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
    /// [m/s]
    slip: Vector3<f64>,
    /// [-] lever arms over radii.
    pub arm: f64,
    /// [N]
    pub elastic: f64,
    /// [N]
    pub viscous: f64,
    /// Rolling and twisting, where contacts resist these.
    pub rolling: Option<RollingMotion>,
}

/// Motion against one spring of a contact.
#[derive(Clone, Copy, Debug)]
pub struct SpringMotion {
    /// Kind of the motion.
    pub kind: SpringKind,
    /// [m/s] relative velocity that stretches the spring.
    pub velocity: Vector3<f64>,
    /// Constants at the present overlap.
    pub constants: SpringDashpotSlider,
    /// [-] growth of the shear per way; less than 1 at the touch of a spring that stiffens.
    pub grown: f64,
    /// Rates by which the overlap changes the spring.
    pub rates: SpringRates,
    /// [-] limit over the normal force.
    friction: f64,
    /// [N] largest force.
    pub limit: f64,
    /// True at the very touch.
    pub at_touch: bool,
    /// Resistance to rolling or twisting.
    pub resistance: Option<Resistance>,
}

/// [-] overlap over the diameter at which a contact has only just begun.
const TOUCHING: f64 = 1e-9;

/// [-] time over the step after which force and limit of a contact that begins are compared.
const SOON: f64 = 1e-4;

impl ContactMotion {
    /// Motion of two touching bodies now; with rolling and twisting if the contact `resists` these.
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

    /// [m] effective radius by which rolling resistance turns the bodies.
    pub fn rolling_radius(&self) -> f64 {
        self.rolling.as_ref().map_or(0.0, |rolling| rolling.bodies.radius)
    }

    /// Motion against the spring of that kind.
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
    /// True if the contact, which begins without force, slides at once. Spring and limit are compared shortly after the
    /// touch; `step` [s] is the time step.
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

    /// True if the spring remembers: it has a stiffness, and a limit above zero.
    pub fn remembers(&self) -> bool {
        let stiff = match &self.resistance {
            Some(resistance) => resistance.spring.stiffness > 0.0,
            None => self.constants.stiffness > 0.0 || (self.at_touch && self.constants.half_powers > 0),
        };
        stiff && self.friction > 0.0
    }

    /// [N/s] rate of the limit, from the rate of the normal velocity [m/s²].
    pub fn limit_rate(
        &self,
        law: &ContactLaw,
        touch: &TouchingPair,
        met: &Encounter,
        (acceleration, dt): (f64, f64),
    ) -> f64 {
        // a difference over so little time is exact enough to find an instant by
        let time = SOON * dt;
        let force = |overlap: f64, velocity: f64| {
            let (elastic, viscous) = law.force(&touch.spring, overlap, velocity);
            // the limit of twisting is in proportion to the radius of the contact
            let factor = if self.kind == SpringKind::Twist { (overlap / met.overlap()).abs().sqrt() } else { 1.0 };
            factor * (elastic + viscous)
        };
        let later = force(met.overlap() - met.normal_velocity * time, met.normal_velocity + acceleration * time);
        self.friction * (later - force(met.overlap(), met.normal_velocity)) / time
    }
}
