//! Surfaces: restitution and friction of impacts.

use crate::restitution::RestitutionBySpeed;
use serde::Serialize;

/// Restitution and friction of an impact of two surfaces, which all engines use.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Surface {
    /// [-] normal restitution e, 0 ..= 1: ratio of normal speeds after and before an isolated impact. If `by_speed` is
    /// given, impacts follow `by_speed` instead, and predictions use this value of e at one usual speed.
    pub restitution: f64,
    /// [-] coefficient of Coulomb friction μ, >= 0.
    pub friction: f64,
    /// Restitution as a function of the normal speed; `None` if the restitution is constant.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_speed: Option<RestitutionBySpeed>,
}

impl Surface {
    /// A surface with constant restitution e [-] and friction μ [-].
    pub const fn new(restitution: f64, friction: f64) -> Self {
        Self { restitution, friction, by_speed: None }
    }

    /// [-] restitution of an impact at the normal speed `speed` [m/s] of approach.
    #[inline]
    pub fn restitution_at(&self, speed: f64) -> f64 {
        self.by_speed.map_or(self.restitution, |law| law.at(speed))
    }

    /// Returns this surface with a constant restitution: the restitution of an impact at the normal speed `speed`
    /// [m/s].
    #[inline]
    pub fn at_speed(&self, speed: f64) -> Self {
        Self::new(self.restitution_at(speed), self.friction)
    }

    /// True if the restitution is above 0 for impacts at all speeds.
    pub fn always_rebounds(&self) -> bool {
        self.by_speed.map_or(self.restitution > 0.0, |law| law.always_rebounds())
    }

    /// Sets the restitution that predictions use to the restitution at the normal speed `speed` [m/s]. A restitution
    /// that does not depend on the speed stays unchanged.
    pub fn represent(&mut self, speed: f64) {
        self.restitution = self.restitution_at(speed);
    }
}
