//! Servo walls: planes that move along their normal, so that particles press on them with a given pressure.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Motion of a plane on which particles shall press with a given pressure. The speed of the plane along its normal is V
/// = (p - p_m)/c, with the target pressure p, the measured pressure p_m, and the damping c (da Cruz et al. 2005, Phys.
/// Rev. E 72, 021309, eq. 2). Its magnitude is limited to `largest_speed`. The speed is constant between two
/// measurements.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ServoMotion {
    /// [-] unit normal of the plane, which points to the particles.
    pub direction: Vector3<f64>,
    /// [Pa] target pressure p of the particles on the plane.
    pub pressure: f64,
    /// [m²] area of the plane on which particles can press.
    pub area: f64,
    /// [m/s] largest speed of the plane.
    pub largest_speed: f64,
    /// [Pa s/m] damping c. With `None`, c is the acoustic impedance of the particles
    /// ([`impedance`](crate::schedule::impedance)).
    pub damping: Option<f64>,
    /// State of the plane at the most recent measurement.
    #[serde(skip)]
    pub state: ServoState,
}

/// State of a servo wall at its most recent measurement of the pressure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ServoState {
    /// [s] simulated time of the measurement.
    pub time: f64,
    /// [m] displacement of the plane along its normal since the start; positive towards the particles.
    pub displacement: f64,
    /// [m/s] speed of the plane along its normal from this measurement on; positive towards the particles.
    pub speed: f64,
    /// [Pa] measured pressure p_m of the particles on the plane.
    pub pressure: f64,
}

impl ServoMotion {
    /// [m] displacement of the plane along its normal at `time` [s], which is not earlier than the most recent
    /// measurement.
    pub fn displacement(&self, time: f64) -> f64 {
        self.state.displacement + self.state.speed * (time - self.state.time)
    }

    /// Sets the speed of the plane, at most `largest_speed`, from the force [N] with which the particles press on it at
    /// `time` [s]. Stores this measurement in `state`. The argument `damping` [Pa s/m] is used if the field `damping`
    /// is `None`.
    pub fn steer(&mut self, force: f64, time: f64, damping: f64) {
        let pressure = force / self.area;
        let speed = (self.pressure - pressure) / self.damping.unwrap_or(damping);
        let speed = speed.clamp(-self.largest_speed, self.largest_speed);
        self.state = ServoState { time, displacement: self.displacement(time), speed, pressure };
    }
}
