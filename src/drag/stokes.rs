//! Creeping flow.

use super::{DragLaw, Sphere};
use serde::Serialize;

/// Stokes drag, C_D = 24/Re: τ does not depend on the slip. Valid for Re << 1; here as the analytic yardstick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Stokes;

impl DragLaw for Stokes {
    fn log_decay(&self, sphere: &Sphere, _slip: f64, duration: f64) -> f64 {
        -duration / sphere.stokes_time
    }

    fn response_time(&self, sphere: &Sphere, _slip: f64) -> f64 {
        sphere.stokes_time
    }

    fn relaxation_time(&self, sphere: &Sphere, _slip: f64) -> f64 {
        sphere.stokes_time
    }
}
