//! Scenes that change with time, since walls move or a periodic box is sheared: the scene at a given instant.

use super::Scene;
use crate::walls::Wall;
use std::borrow::Cow;

impl Scene {
    /// Returns the scene at the simulated time `time` [s]: moving walls, and periodic images of a sheared box, are at
    /// their places at this time. A scene without moving walls and shear is returned itself, not as a copy.
    pub fn at(&self, time: f64) -> Cow<'_, Self> {
        if !self.changes() {
            return Cow::Borrowed(self);
        }
        let mut scene = self.clone();
        scene.move_to(time);
        Cow::Owned(scene)
    }

    /// Moves the walls that move, and the periodic images of a sheared box, to their places at the simulated time
    /// `time` [s].
    pub fn move_to(&mut self, time: f64) {
        if let Cow::Owned(domain) = self.domain.at(time) {
            self.domain = domain;
        }
        self.walls.iter_mut().for_each(|wall| wall.move_to(time));
    }

    /// True if the scene changes with time: the box is sheared, or a wall moves.
    pub fn changes(&self) -> bool {
        self.domain.shear.is_some() || self.has_moving_walls()
    }

    /// True if the shape of any wall moves.
    pub fn has_moving_walls(&self) -> bool {
        self.walls.iter().any(|wall| wall.moving.is_some())
    }

    /// True if the gas is turbulent, so that fluctuations of its velocity act on the particles.
    pub fn has_turbulence(&self) -> bool {
        self.fluid.as_ref().is_some_and(|fluid| fluid.turbulence.is_some())
    }

    /// True if any wall has a temperature, so that impacts on it give new velocities.
    pub fn has_thermal_walls(&self) -> bool {
        self.walls.iter().any(|wall| wall.thermal.is_some())
    }

    /// True if any wall is rough.
    pub fn has_rough_walls(&self) -> bool {
        self.walls.iter().any(|wall| wall.roughness.is_some())
    }

    /// [m/s] largest speed of any point of a wall whose shape moves; 0 without such walls.
    pub fn wall_speed(&self) -> f64 {
        self.walls.iter().map(Wall::largest_speed).fold(0.0, f64::max)
    }

    /// True if a wall moves so that particles press on it with a given pressure.
    pub fn has_servo_walls(&self) -> bool {
        self.walls.iter().any(|wall| wall.servo().is_some())
    }
}

/// Scene for code that asks for the scene at a sequence of instants. A scene that changes is copied once, and the copy
/// is changed for each instant. A scene that does not change is not copied.
pub enum SceneInTime<'a> {
    /// A scene that does not change.
    Fixed(&'a Scene),
    /// Copy of a scene that changes. Moving walls and periodic images are at their places at the latest requested
    /// instant.
    Changing(Box<Scene>),
}

impl<'a> SceneInTime<'a> {
    /// Prepares a scene for requests at several instants. A scene that changes with time is copied.
    pub fn of(scene: &'a Scene) -> Self {
        if scene.changes() { Self::Changing(Box::new(scene.clone())) } else { Self::Fixed(scene) }
    }

    /// Returns the scene at the simulated time `time` [s].
    #[inline]
    pub fn at(&mut self, time: f64) -> &Scene {
        match self {
            Self::Fixed(scene) => scene,
            Self::Changing(scene) => {
                scene.move_to(time);
                scene
            }
        }
    }
}
