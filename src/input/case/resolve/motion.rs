//! Reads and checks the motion of the shapes of walls.

use super::{Resolver, vector};
use crate::case::diagnostic::Diagnostic;
use crate::case::file::{CaseFile, KnotFile, MotionFile, ServoFile, ShapeTurningFile, VibrationFile};
use crate::case::located::Located;
use crate::domain::Domain;
use crate::experiment::{Experiment, Model};
use crate::walls::{MovingShape, PiecewisePath, PrescribedMotion, ServoMotion, ServoState, Turning, Wall};
use nalgebra::Vector3;

/// [-] largest difference of two lengths, divided by the size of the box, that counts as rounding. Two directions
/// count as parallel if the magnitude of the cosine of the angle between them differs from 1 by at most this number.
const ROUNDING: f64 = 1e-9;

impl Resolver {
    /// Adds to a wall the motion of its shape that the case gives. Without a motion the wall is returned unchanged.
    ///
    /// # Errors
    /// A motion that is out of range or moves nothing, or that the wall, the box or the model does not allow.
    pub(super) fn moving(
        &self,
        wall: Wall,
        motion: Option<&Located<MotionFile>>,
        domain: &Domain,
    ) -> Result<Wall, Diagnostic> {
        let Some(typed) = motion else { return Ok(wall) };
        if self.model == Model::Dsmc {
            let help = "use the hard, the soft or the hybrid model";
            return Err(self.refuse_motion(typed, "is not for collisions by chance").help(help));
        }
        let MotionFile { translation, vibration, path, turning, servo } = &typed.value;
        let motion = if let Some(typed) = translation {
            for component in &typed.value {
                self.in_range(component, "the velocity of a wall")?;
            }
            PrescribedMotion::Translation { velocity: vector(typed) }
        } else if let Some(vibration) = vibration {
            self.vibration(&vibration.value)?
        } else if let Some(path) = path {
            self.path(path)?
        } else if let Some(servo) = servo {
            self.servo(servo, &wall, domain)?
        } else {
            let turning = self.need(turning, "walls.motion.turning")?;
            self.turning(turning, &wall, domain)?
        };
        let endless = "turns a shape without ends, whose far points would have no largest speed";
        let moved = wall.moving(motion).ok_or_else(|| {
            self.refuse_motion(typed, endless).help("turn a body with bounds, or only the surface: `rotation`")
        })?;
        if moved.largest_speed() == 0.0 {
            return Err(self.refuse_motion(typed, "moves nothing").help("leave `motion` out for a wall at rest"));
        }
        Ok(moved)
    }

    fn vibration(&self, vibration: &VibrationFile) -> Result<PrescribedMotion, Diagnostic> {
        let amplitude = self.need(&vibration.amplitude, "vibration.amplitude")?;
        for component in &amplitude.value {
            self.in_range(component, "the largest displacement")?;
        }
        let frequency = self.need(&vibration.frequency, "vibration.frequency")?;
        let frequency = self.in_range(frequency, "the number of periods per second")?;
        let phase = match &vibration.phase {
            Some(phase) => self.in_range(phase, "an angle, such as \"90 deg\"")?,
            None => 0.0,
        };
        Ok(PrescribedMotion::Vibration { amplitude: vector(amplitude), frequency, phase })
    }

    fn path(&self, path: &Located<Vec<Located<KnotFile>>>) -> Result<PrescribedMotion, Diagnostic> {
        let mut knots: Vec<(f64, Vector3<f64>)> = Vec::new();
        for knot in &path.value {
            let typed = self.need(&knot.value.time, "path.time")?;
            let time = self.in_range(typed, "a time of the run")?;
            if let Some((before, _)) = knots.last().filter(|(before, _)| *before >= time) {
                let what = format!("is not later than the time before it, {before:e} s");
                return Err(self.refuse(typed, what).help("put the times in ascending order, each once"));
            }
            let displacement = self.need(&knot.value.displacement, "path.displacement")?;
            for component in &displacement.value {
                self.in_range(component, "the displacement from where the case puts the wall")?;
            }
            knots.push((time, vector(displacement)));
        }
        let few = || self.refuse(path, "has fewer than two times").help("give at least two, or leave `motion` out");
        let path = PiecewisePath::new(knots).filter(|_| path.value.len() > 1).ok_or_else(few)?;
        Ok(PrescribedMotion::Path(path.into()))
    }

    fn servo(&self, typed: &Located<ServoFile>, wall: &Wall, domain: &Domain) -> Result<PrescribedMotion, Diagnostic> {
        let ServoFile { pressure, largest_speed, damping, area } = &typed.value;
        let no = |what: &str, help: &str| Err(self.refuse_motion(typed, what).help(help));
        if !self.model.has_contacts() {
            return no("measures the force of contacts that last", "use the soft or the hybrid model");
        }
        let Some(plane) = wall.geometry.plane() else {
            return no("moves only planes", "give the wall the shape `plane`");
        };
        let normal = plane.normal;
        let area = match area {
            Some(area) => self.in_range(area, "the part of the plane within the walls around the particles")?,
            None => match (0..3).find(|axis| normal[*axis].abs() > 1.0 - ROUNDING) {
                Some(axis) => domain.size.product() / domain.size[axis],
                None => return no("needs an area, since the plane is inclined", "add `area` to the table"),
            },
        };
        let pressure = self.in_range(self.need(pressure, "servo.pressure")?, "the pressure of the particles")?;
        let fastest = self.need(largest_speed, "servo.largest_speed")?;
        let largest_speed = self.in_range(fastest, "the speed at which the plane approaches the particles")?;
        let damping = damping.as_ref().map(|damping| self.in_range(damping, "leave it out for the default"));
        let (damping, state) = (damping.transpose()?, ServoState::default());
        Ok(PrescribedMotion::Servo(ServoMotion { direction: normal, pressure, area, largest_speed, damping, state }))
    }

    fn turning(
        &self,
        typed: &Located<ShapeTurningFile>,
        wall: &Wall,
        domain: &Domain,
    ) -> Result<PrescribedMotion, Diagnostic> {
        let rate = self.need(&typed.value.rate, "turning.rate")?;
        let rate = self.in_range(rate, "the angular velocity of a wall")?;
        let axis = self.need(&typed.value.axis, "turning.axis")?;
        let Some(axis) = vector(axis).try_normalize(0.0) else {
            return Err(self.refuse(axis, "has no direction").help("the axis is a vector such as [0, 0, 1]"));
        };
        let center = vector(self.need(&typed.value.center, "turning.center")?);
        let no = |what: &str, help: &str| Err(self.refuse_motion(typed, what).help(help));
        if wall.turning.is_some() || wall.velocity != Vector3::zeros() {
            return no("does not go with a surface that moves along itself", "leave out `velocity` and `rotation`");
        }
        if (0..3).any(|k| domain.periodic[k] && axis[k].abs() < 1.0 - ROUNDING) {
            let help = "make the domain periodic along the axis only, or along no axis";
            return no("turns a body away from its periodic images", help);
        }
        Ok(PrescribedMotion::Turning(Turning { center, spin: axis * rate }))
    }

    fn refuse_motion<T>(&self, typed: &Located<T>, what: &str) -> Diagnostic {
        self.sources.error(&typed.origin, format!("`{}` {what}", typed.path))
    }

    /// Warns about planes and vessels (hollow walls with particles inside) that leave the box during the run, and
    /// about planes between which particles no longer fit.
    pub(super) fn check_motion(&mut self, file: &CaseFile, experiment: &Experiment) {
        let duration = experiment.run.duration;
        let (walls, domain) = (&experiment.scene.walls, &experiment.scene.domain);
        let largest = experiment.scene.largest_diameter();
        let typed = file.walls.iter().flatten().map(|wall| wall.value.motion.as_ref());
        for ((index, wall), typed) in walls.iter().enumerate().zip(typed) {
            let (Some(moving), Some(typed)) = (&wall.moving, typed) else { continue };
            if let Some((name, place)) = leaves(moving, domain, duration) {
                let message = format!("`{}` takes the wall out of the box, to {name} = {place:.4e} m", typed.path);
                let help = "particles that follow it would leave the box: move the wall or make `domain.size` larger";
                self.warn(&typed.origin, message, help);
            }
            for (other, room) in
                walls.iter().enumerate().filter_map(|(k, other)| Some((k, room(wall, other, duration)?)))
            {
                // if both walls move, only the warning for the first one is given
                let told = other < index && walls[other].moving.is_some();
                if room < largest && !told {
                    let message = format!(
                        "`{}` may bring the wall to {room:.4e} m from walls[{other}], where a sphere of {largest:.4e} m does not fit",
                        typed.path
                    );
                    self.warn(&typed.origin, message, "a sphere between them is crushed: move the walls apart");
                }
            }
        }
    }
}

/// Axis and coordinate [m] at which a moving plane or vessel (hollow wall with particles inside) gets out of the box
/// within `duration` [s]; `None` if it stays in the box.
fn leaves(moving: &MovingShape, domain: &Domain, duration: f64) -> Option<(&'static str, f64)> {
    let corners = moving.shape().law().room_corners()?;
    (0..3).filter(|axis| !domain.periodic[*axis]).find_map(|axis| {
        let [low, high] = moving.motion().range_along(&Vector3::ith(axis, 1.0), duration)?;
        let slack = ROUNDING * domain.size[axis];
        let (lowest, highest) = (corners[0][axis] + low, corners[1][axis] + high);
        let name = ["x", "y", "z"][axis];
        if lowest.is_finite() && lowest < -slack {
            return Some((name, lowest));
        }
        (highest.is_finite() && highest > domain.size[axis] + slack).then_some((name, highest))
    })
}

/// [m] smallest distance between a moving plane wall and an opposite plane wall within the first `duration` [s]; `None`
/// for other walls.
fn room(wall: &Wall, other: &Wall, duration: f64) -> Option<f64> {
    let moving = wall.moving.as_ref()?;
    let still = |wall: &Wall| {
        wall.moving.as_ref().map_or_else(|| wall.geometry.plane().copied(), |moving| moving.shape().plane().copied())
    };
    let (plane, opposite) = (still(wall)?, still(other)?);
    if plane.normal.dot(&opposite.normal) > ROUNDING - 1.0 {
        return None;
    }
    let apart = (opposite.point - plane.point).dot(&plane.normal);
    let Some(partner) = &other.moving else {
        return Some(apart - moving.motion().range_along(&plane.normal, duration)?[1]);
    };
    if partner.motion() == moving.motion() {
        return Some(apart);
    }
    let [_, high] = moving.motion().range_along(&plane.normal, duration)?;
    let [low, _] = partner.motion().range_along(&plane.normal, duration)?;
    Some(apart - high + low)
}
