//! Stokes drag of creeping flow.

use super::{DragLaw, Sphere};

/// Stokes drag, with the drag coefficient C_D = 24/Re. Its response time τ does not depend on the slip speed, the speed
/// relative to the gas. The law is valid for Re << 1. In this program it is an analytic reference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stokes;

impl DragLaw for Stokes {
    fn name(&self) -> &'static str {
        "stokes"
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    fn title(&self) -> String {
        "Stokes drag".into()
    }

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
