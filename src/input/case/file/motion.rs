//! Keys of a wall whose shape moves: table `[walls.motion]` of a case.

use super::Three;
use crate::case::located::Located;
use crate::case::quantity::{Area, Length, Pressure, PressurePerSpeed, Ratio, Speed, Spin, Time};
use schemars::JsonSchema;
use serde::Deserialize;

/// Table `[walls.motion]`: motion of the shape of a wall, given in advance or by a servo control. The shape that the
/// case gives is the shape without displacement.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotionFile {
    /// Constant velocity of the shape. At time 0 the shape is where the case puts it.
    #[schemars(extend("examples" = [["0 m/s", "-2 mm/s", "0 m/s"]], "x-range" = "-1e5 ..= 1e5 m/s"))]
    #[schemars(extend("x-one-of" = "motion", "x-required" = "or `vibration`, `path`, `turning`, `servo`"))]
    pub translation: Option<Three<Speed>>,
    /// Harmonic vibration of the shape.
    #[schemars(extend("x-one-of" = "motion"))]
    pub vibration: Option<Located<VibrationFile>>,
    /// Displacements at two or more given times, with constant velocity between them. Before the first and after the
    /// last time the shape is at rest.
    #[schemars(extend("x-one-of" = "motion"))]
    pub path: Option<Located<Vec<Located<KnotFile>>>>,
    /// Rotation of the shape about an axis, such as that of a mixer or of a drum with lifters. At time 0 the shape is
    /// where the case puts it.
    #[schemars(extend("x-one-of" = "motion"))]
    pub turning: Option<Located<ShapeTurningFile>>,
    /// Motion of a plane along its normal, so that particles press on it with a given pressure. Only for soft and
    /// hybrid spheres.
    #[schemars(extend("x-one-of" = "motion"))]
    pub servo: Option<Located<ServoFile>>,
}

/// Table `[walls.motion.servo]`: a plane that moves along its normal at the speed V = (p - p_m)/c. Here p is the
/// wanted pressure, p_m the measured pressure of the particles on the plane, and c the damping.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ServoFile {
    /// Wanted pressure p of the particles on the plane.
    #[schemars(example = &"1 kPa", extend("x-required" = "always", "x-range" = "greater than 0, up to 1e12 Pa"))]
    pub pressure: Option<Located<Pressure>>,
    /// Largest speed of the plane. A plane without contacts moves at p/c (wanted pressure over damping), if this is
    /// less.
    #[schemars(example = &"50 mm/s", extend("x-required" = "always", "x-range" = "greater than 0, up to 1e5 m/s"))]
    pub largest_speed: Option<Located<Speed>>,
    /// Damping c of the plane: its speed is the missing pressure over c.
    #[schemars(example = &"500 Pa s/m", extend("x-range" = "greater than 0, up to 1e15 Pa s/m"))]
    #[schemars(extend("x-default" = "π m/(t_c d²) with the mass, the diameter and the contact time of a sphere"))]
    pub damping: Option<Located<PressurePerSpeed>>,
    /// Area of the plane on which particles can press.
    #[schemars(example = &"4 cm^2", extend("x-range" = "greater than 0, up to 1e8 m^2"))]
    #[schemars(extend("x-default" = "the cross-section of the domain, if the plane is parallel to a side"))]
    pub area: Option<Located<Area>>,
}

/// Table `[walls.motion.vibration]`: displacement A sin(2π f t + φ) at the time t, with amplitude A, frequency f and
/// phase φ.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VibrationFile {
    /// Amplitude A, the largest displacement, as a vector in the direction of the vibration.
    #[schemars(extend("examples" = [["0 mm", "2 mm", "0 mm"]], "x-required" = "always", "x-range" = "-1e4 ..= 1e4 m"))]
    pub amplitude: Option<Three<Length>>,
    /// Frequency f of the vibration: number of periods per time.
    #[schemars(example = &"20 Hz", extend("x-required" = "always", "x-range" = "greater than 0, up to 1e7 Hz"))]
    pub frequency: Option<Located<Spin>>,
    /// Phase φ of the vibration, the angle of the sine at time 0.
    #[schemars(example = &"90 deg", extend("default" = 0, "x-range" = "-1e3 ..= 1e3"))]
    pub phase: Option<Located<Ratio>>,
}

/// One entry of `walls.motion.path`: a time, and the displacement of the shape at this time.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KnotFile {
    /// Time of this displacement, later than the time of the entry before.
    #[schemars(example = &"0.5 s", extend("x-required" = "always", "x-range" = "-1e9 ..= 1e9 s"))]
    pub time: Option<Located<Time>>,
    /// Displacement of the shape at this time, relative to where the case puts the shape.
    #[schemars(extend("examples" = [["0 mm", "-4 mm", "0 mm"]], "x-required" = "always", "x-range" = "-1e4 ..= 1e4 m"))]
    pub displacement: Option<Three<Length>>,
}

/// Table `[walls.motion.turning]`: rotation of the shape of a wall.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShapeTurningFile {
    /// Angular velocity of the rotation, counter-clockwise if the axis points towards the viewer.
    #[schemars(example = &"3 rad/s", extend("x-required" = "always", "x-range" = "-1e7 ..= 1e7 rad/s"))]
    pub rate: Option<Located<Spin>>,
    /// Direction of the axis of rotation: a vector of any length.
    #[schemars(extend("examples" = [[0, 0, 1]], "x-required" = "always"))]
    pub axis: Option<Three<Ratio>>,
    /// A point on the axis of rotation.
    #[schemars(extend("examples" = [["10 mm", "10 mm", "0 mm"]], "x-required" = "always"))]
    pub center: Option<Three<Length>>,
}
