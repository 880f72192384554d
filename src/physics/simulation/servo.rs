//! Servo walls, which move to keep the pressure on them: at the end of each window (time between two exchanges with the
//! gas) the force of the particles on a wall is measured, and the wall gets a new speed.

use super::Simulation;
use crate::contact_law::ContactLaw;
use crate::encounter::{FrameTime, Other};
use crate::exact::ExactSum;
use crate::experiment::Experiment;
use crate::schedule::impedance;
use crate::walls::ServoState;

/// Data that the control of servo walls needs besides the motion of these walls.
pub(super) struct ServoControl {
    /// Contact law, which gives the forces of particles on the walls.
    law: ContactLaw,
    /// [Pa s/m] damping of the servo walls whose damping the case (input file) does not give.
    damping: f64,
}

impl ServoControl {
    /// Makes the data for an experiment; `None` if it has no servo wall, or a model without lasting contacts.
    pub(super) fn new(experiment: &Experiment) -> Option<Box<Self>> {
        let law = experiment.law().filter(|_| experiment.scene.has_servo_walls())?;
        Some(Box::new(Self { law, damping: impedance(experiment) }))
    }
}

impl Simulation {
    /// Measures the force of the particles on each servo wall at the present time, and sets the speed of the wall for
    /// the next window (time between two exchanges with the gas).
    pub(super) fn steer_servo_walls(&mut self) {
        let Some(control) = &self.servo else { return };
        let mut forces: Vec<ExactSum> = self.scene.walls.iter().map(|_| ExactSum::default()).collect();
        let (particles, scene) = (&self.particles, &self.scene);
        self.engine.for_each_touching(&mut |couple| {
            let Other::Wall(at) = couple.other else { return };
            let wall = at.wall as usize;
            if scene.walls[wall].servo().is_none() {
                return;
            }
            let met = couple.meet(particles, scene, FrameTime::default());
            if met.overlap() > 0.0 {
                let spring = control.law.between(&couple.bodies(particles, scene));
                let (elastic, viscous) = control.law.force(&spring, met.overlap(), met.normal_velocity);
                forces[wall].add(elastic + viscous);
            }
        });
        for (wall, force) in self.scene.walls.iter_mut().zip(&forces) {
            if let Some(servo) = wall.servo_mut() {
                servo.steer(force.value(), self.time, control.damping);
            }
        }
    }

    /// States of all servo walls, in the order of the walls.
    pub fn servo_states(&self) -> Vec<ServoState> {
        self.scene.walls.iter().filter_map(|wall| wall.servo()).map(|servo| servo.state).collect()
    }

    /// Sets the states of all servo walls, as [`servo_states`](Self::servo_states) returned them.
    pub(super) fn set_servo_states(&mut self, states: &[ServoState]) {
        let servos = self.scene.walls.iter_mut().filter_map(|wall| wall.servo_mut());
        servos.zip(states).for_each(|(servo, state)| servo.state = *state);
    }
}
