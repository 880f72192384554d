//! How does the gas push a sphere?
//!
//! Between two collisions drag is the only force that changes a particle's velocity relative to the gas. With the gas
//! velocity frozen for the length of one kick, the slip velocity keeps its direction and its magnitude obeys one
//! scalar equation, dw/dt = -w/τ(w), whose exact flow each law gives in closed form. A kick is therefore stable for any
//! length, and two half-kicks in a row are one whole kick.
//!
//! To add a law: one file with `impl DragLaw`, then a `mod` line, a variant of [`Drag`] and an arm of `law`.

mod kick;
mod schiller_naumann;
mod stokes;

pub use kick::Kick;
pub use schiller_naumann::SchillerNaumann;
pub use stokes::Stokes;

use serde::Serialize;

/// A sphere in a gas, as far as drag is concerned.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Sphere {
    /// [s] Stokes response time τ = ρ_p d² / (18 ρ_f ν).
    pub stokes_time: f64,
    /// [s/m] Reynolds number per slip speed, d/ν.
    pub reynolds_per_speed: f64,
}

/// A drag law for a sphere.
pub trait DragLaw: Sync {
    /// [-] ln of the ratio of slip speeds after and before `duration` [s] of drag alone, the gas velocity frozen: the exact
    /// flow of dw/dt = -w/τ(w) from slip speed `slip` >= 0 [m/s], hence -∫dt/τ; <= 0.
    ///
    /// The logarithm, because a kick needs 1 - ratio, which the ratio itself no longer holds to full precision.
    fn log_decay(&self, sphere: &Sphere, slip: f64, duration: f64) -> f64;

    /// [s] response time τ(w) = slip speed / deceleration at slip speed `slip` >= 0 [m/s].
    fn response_time(&self, sphere: &Sphere, slip: f64) -> f64;

    /// [s] relaxation time τ_l(w) = 1/(d(w/τ)/dw): how fast a small change of the slip speed about `slip` >= 0 [m/s] dies
    /// away; never longer than the response time.
    fn relaxation_time(&self, sphere: &Sphere, slip: f64) -> f64;

    /// [-] ratio of slip speeds after and before `duration` [s]; in [0, 1].
    fn decay(&self, sphere: &Sphere, slip: f64, duration: f64) -> f64 {
        self.log_decay(sphere, slip, duration).exp()
    }

    /// [-] change of the slip velocity in `duration` [s] per slip velocity, ratio - 1 to full precision; in [-1, 0].
    fn change(&self, sphere: &Sphere, slip: f64, duration: f64) -> f64 {
        self.log_decay(sphere, slip, duration).exp_m1()
    }
}

/// The laws a case can name.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Drag {
    /// Schiller and Naumann (1935), the paper's.
    SchillerNaumann(SchillerNaumann),
    /// Creeping flow: the analytic yardstick.
    Stokes(Stokes),
}

impl Drag {
    /// The law behind the name.
    #[inline]
    pub fn law(&self) -> &dyn DragLaw {
        match self {
            Self::SchillerNaumann(law) => law,
            Self::Stokes(law) => law,
        }
    }
}
