//! Two bodies that meet: a pair of particles, or a particle and a wall. This file contains their identity, their
//! relative position and velocity, and the time at which they touch. All engines and predictions use these functions,
//! so that most other code treats pairs and walls in the same way.
//!
//! The functions that are called for every pair are always inlined. In most calls the [`FrameTime`] and the type of
//! the second body (particle or wall) are known to the compiler, which can then remove half of the code of these
//! functions. Without inlining, their calls take a tenth of the computing time of case D of the paper (docs/paper.md)
//! with soft spheres.

mod wall_motion;

use crate::contact_law::Bodies;
use crate::particles::Particles;
use crate::rotation::tangential_mass;
use crate::scene::{Kind, Scene, Surface};
pub use crate::walls::{first_touch, may_touch};
pub use wall_motion::WallMotion;

use crate::walls::{Flight, Touch};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Collision partner of a particle, as it is named in results.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Partner {
    /// Another particle, given by its id.
    Particle(u32),
    /// A wall, given by its index among the walls of the case (input file).
    Wall(u32),
}

impl std::fmt::Display for Partner {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Particle(id) => write!(f, "particle {id}"),
            Self::Wall(index) => write!(f, "wall {index}"),
        }
    }
}

/// Second body of a couple (a particle and a body that it may touch): another particle or a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Other {
    /// Another particle, by its index in the particle store.
    Particle(u32),
    /// Wall, with the number of one of the contacts that a sphere can have with this wall.
    Wall(AtWall),
}

/// A wall of the scene, with the number of one of the contacts that a sphere can have with this wall. A sphere in a
/// corner of a box has several contacts with one wall, at different points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AtWall {
    /// Index of the wall among the walls of the scene.
    pub wall: u32,
    /// Number of the contact, one of the [`contacts`](crate::walls::Geometry::contacts) of the wall's shape.
    pub which: u32,
}

impl AtWall {
    /// First contact (number 0) of a sphere with the wall that has the index `wall` in the scene.
    pub fn first(wall: u32) -> Self {
        Self { wall, which: 0 }
    }
}

/// A particle, and a second body that the particle may touch: another particle or a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Couple {
    /// Index of the particle in the particle store.
    pub i: u32,
    /// Second body, which particle `i` may touch: another particle or a wall.
    pub other: Other,
}

/// Time at which the relative position and velocity of two bodies are computed. It is counted from the time to which
/// the positions in the particle store belong.
///
/// Engines move particles in a frame of reference that falls freely with gravity, in which gravity does not affect
/// pairs. A wall does not fall in this way, so the motion of a particle relative to a wall includes gravity. Two times
/// state how long the frame has fallen: `sunk` for positions and `fallen` for velocities. In the formulas, g is the
/// acceleration by gravity and t the time of fall.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameTime {
    /// [s] time from the instant of the particle store to the instant of the relative position and velocity. Particles
    /// fly straight meanwhile.
    pub ahead: f64,
    /// [s] time of free fall whose displacement g t²/2 must be added to positions relative to a wall. In this time the
    /// images in a sheared box have slid, and moving walls have moved, from their places in the scene.
    pub sunk: f64,
    /// [s] time of free fall whose velocity g t must be added to velocities relative to a wall.
    pub fallen: f64,
    /// [s] time by which the velocities of the store are earlier than its positions, as in half steps of Verlet's
    /// method. Velocities of moving walls are computed for this earlier time.
    pub lag: f64,
}

impl FrameTime {
    /// Creates a `FrameTime` at the time of the particle store. Positions in the store include the fall with gravity.
    /// Velocities in the store do not yet include g t, the change of velocity by a free fall of `time` [s].
    pub fn fallen(time: f64) -> Self {
        Self { fallen: time, ..Self::default() }
    }

    /// Creates a `FrameTime` at the time of the particle store. The velocities in the store lack the velocity g t of a
    /// free fall of `time` [s], and are `lag` [s] earlier than the positions.
    pub fn lagging(time: f64, lag: f64) -> Self {
        Self { fallen: time, lag, ..Self::default() }
    }

    /// Creates a `FrameTime` at the time of the particle store. A free fall of `time` [s] is missing in the store: its
    /// displacement g t²/2 in positions and its velocity g t in velocities.
    pub fn in_free_fall(time: f64) -> Self {
        Self { sunk: time, fallen: time, ..Self::default() }
    }

    /// Creates a `FrameTime` that is `time` [s] later than the particle store. The frame of reference begins to fall
    /// freely at the time of the store.
    pub fn ahead(time: f64) -> Self {
        Self { ahead: time, sunk: time, fallen: time, lag: 0.0 }
    }

    /// [m] centre of the particle at `index` after a straight flight of `ahead` [s] from its position in the
    /// particle store. Gravity is left out.
    #[inline(always)]
    fn position(&self, particles: &Particles, index: usize) -> Vector3<f64> {
        let x = particles.position[index];
        if self.ahead == 0.0 { x } else { x + particles.velocity[index] * self.ahead }
    }

    /// Position [m], velocity [m/s] and acceleration [m/s²] of the particle at `index` relative to a wall at
    /// rest, with the effect of gravity.
    #[inline(always)]
    pub fn flight(&self, particles: &Particles, scene: &Scene, index: usize) -> Flight {
        let fall = scene.gravity * (0.5 * self.sunk * self.sunk);
        Flight {
            position: self.position(particles, index) + fall,
            velocity: particles.velocity[index] + scene.gravity * self.fallen,
            gravity: scene.gravity,
        }
    }
}

/// Relative position and velocity of two bodies: particle `i` and another particle or a wall.
#[derive(Clone, Copy, Debug, Default)]
pub struct Encounter {
    /// [-] unit normal from the second body (particle or wall) to the first particle `i` of the couple.
    pub normal: Vector3<f64>,
    /// [m] distance between the surfaces of the two bodies; negative if they overlap.
    pub gap: f64,
    /// [m/s] velocity of particle `i` relative to the other body, at the contact point.
    pub velocity: Vector3<f64>,
    /// [m/s] component of `velocity` along the normal; positive if the bodies separate.
    pub normal_velocity: f64,
}

impl Encounter {
    /// [m] overlap of the two bodies; negative if there is a gap.
    #[inline]
    pub fn overlap(&self) -> f64 {
        -self.gap
    }

    /// [m/s] tangential part of the relative velocity, perpendicular to the normal.
    #[inline]
    pub fn slip(&self) -> Vector3<f64> {
        self.velocity - self.normal * self.normal_velocity
    }
}

impl Couple {
    /// A couple of two particles, by their indices in the particle store.
    pub fn pair(i: u32, j: u32) -> Self {
        Self { i, other: Other::Particle(j) }
    }

    /// A couple of a particle, by its index in the particle store, and a wall. `at` also contains the number of one of
    /// the contacts that a sphere can have with the wall.
    pub fn at_wall(i: u32, at: AtWall) -> Self {
        Self { i, other: Other::Wall(at) }
    }

    /// True if the other body of the couple is a wall.
    pub fn is_wall(&self) -> bool {
        matches!(self.other, Other::Wall(_))
    }

    /// True if the other body is a wall with a constant normal, such as a plane. A contact without friction then
    /// changes only the coordinate of the particle along the normal.
    pub fn is_flat(&self, scene: &Scene) -> bool {
        match self.other {
            Other::Particle(_) => false,
            Other::Wall(at) => scene.walls[at.wall as usize].geometry.is_flat_at(at.which),
        }
    }

    /// True if the second body is a wall, and the couple is not the first contact (number 0) that the sphere can have
    /// with this wall.
    #[inline]
    pub fn is_further(&self) -> bool {
        matches!(self.other, Other::Wall(at) if at.which > 0)
    }

    /// True if both couples are contacts of one particle with one wall, and this contact is never nearer than the
    /// contact `other`. The answer is false for walls that do not number their contacts by distance, the nearest first.
    pub fn is_beyond(&self, other: &Self, scene: &Scene) -> bool {
        let (Other::Wall(at), Other::Wall(before)) = (self.other, other.other) else { return false };
        let same = self.i == other.i && at.wall == before.wall && at.which > before.which;
        same && scene.walls[at.wall as usize].geometry.law().is_nearest_first()
    }

    /// Index, in the particle store, of the second particle of a pair; `None` if the other body is a wall.
    pub fn j(&self) -> Option<u32> {
        match self.other {
            Other::Particle(j) => Some(j),
            Other::Wall(_) => None,
        }
    }

    /// Indices of the particles of the couple in the particle store: two for a pair, one and `None` for a wall.
    pub fn indices(&self) -> [Option<u32>; 2] {
        [Some(self.i), self.j()]
    }

    /// Returns this couple with the new indices of its particles, after the particle store was reordered. `index_of`
    /// returns the new index of the particle with a given old index.
    pub fn moved(self, index_of: impl Fn(u32) -> u32) -> Self {
        let other = match self.other {
            Other::Particle(j) => Other::Particle(index_of(j)),
            wall @ Other::Wall(_) => wall,
        };
        Self { i: index_of(self.i), other }
    }

    /// True if `self` and `couple` consist of the same two bodies, in either order.
    pub fn is(&self, couple: &Self) -> bool {
        self == couple || couple.j().is_some_and(|j| *self == Self::pair(j, couple.i))
    }

    /// Surface properties (restitution and friction) for an impact between the two bodies of the couple.
    #[inline]
    pub fn surface<'s>(&self, particles: &Particles, scene: &'s Scene) -> &'s Surface {
        let (species, other) = self.kinds(particles);
        scene.surface(species, other)
    }

    /// Index of the species of particle `i`, and kind of the second body (a species or a wall, with its index).
    #[inline]
    pub fn kinds(&self, particles: &Particles) -> (u16, Kind) {
        let other = match self.other {
            Other::Particle(j) => Kind::Species(particles.species[j as usize]),
            Other::Wall(at) => Kind::Wall(at.wall),
        };
        (particles.species[self.i as usize], other)
    }

    /// Motion of the wall's surface at the contact point; `None` for a pair of particles. `met` is the relative
    /// position of particle and wall at the time `moment`. A force [N] of the wall on the particle has the power [W]
    /// force times velocity of the surface. An impulse [N s] of the wall gives the particle the energy [J] impulse
    /// times velocity of the surface.
    #[inline(always)]
    pub fn wall_motion(
        &self,
        met: &Encounter,
        (particles, scene): (&Particles, &Scene),
        moment: FrameTime,
    ) -> Option<WallMotion> {
        let Other::Wall(at) = self.other else { return None };
        let wall = &scene.walls[at.wall as usize];
        if wall.turning.is_none() && wall.moving.is_none() {
            return Some(WallMotion { velocity: wall.velocity, ..WallMotion::default() });
        }
        let i = self.i as usize;
        let position = moment.flight(particles, scene, i).position;
        let at_contact = position - met.normal * (particles.radius[i] + met.gap);
        Some(WallMotion::of(wall, &at_contact, moment.sunk - moment.lag))
    }

    /// [m/s] velocity along z of the periodic image of particle j that particle i meets, relative to particle j itself.
    /// It is 0 unless a sheared side of the box is between i and j. `velocity` [m/s] is that of i relative to the
    /// image.
    #[inline]
    pub fn image_velocity(&self, particles: &Particles, scene: &Scene, velocity: &Vector3<f64>) -> f64 {
        match self.other {
            Other::Particle(j) if scene.domain.shear.is_some() => {
                let own = particles.velocity[self.i as usize].z - particles.velocity[j as usize].z;
                scene.domain.whole_slides(own - velocity.z)
            }
            Other::Particle(_) | Other::Wall(_) => 0.0,
        }
    }

    /// Masses, sizes and materials of the two bodies, from which a contact law computes its constants.
    pub fn bodies(&self, particles: &Particles, scene: &Scene) -> Bodies {
        match self.other {
            Other::Particle(j) => Bodies::pair(scene, particles, self.i as usize, j as usize),
            Other::Wall(at) => Bodies::at_wall(scene, particles, self.i as usize, at.wall as usize),
        }
    }

    /// [kg] effective mass M of the two bodies; at a wall the mass of the particle.
    #[inline]
    pub fn effective_mass(&self, particles: &Particles) -> f64 {
        let mass = particles.mass[self.i as usize];
        self.j().map_or(mass, |j| 1.0 / (1.0 / mass + 1.0 / particles.mass[j as usize]))
    }

    /// [kg] effective mass M_t of the slip of two rotating bodies ([`tangential_mass`]); 0 if the particles have no
    /// moments of inertia.
    pub fn tangential_mass(&self, particles: &Particles) -> f64 {
        let Some(inertia) = &particles.inertia else { return 0.0 };
        let of = |index: u32| {
            let index = index as usize;
            (particles.mass[index], particles.radius[index], inertia[index])
        };
        tangential_mass(self.indices().into_iter().flatten().map(of))
    }

    /// [m/s] sum w = l_i ω_i + l_j ω_j over the two bodies, with the spins ω and the lever arms l. The spins contribute
    /// -w × n to the slip, with the normal n. The second result is the ratio [-] of lever arm to radius. The lever arms
    /// of a pair add up to the distance of the centres: `reach` [m], the sum of the radii, plus `gap` [m], the distance
    /// of the surfaces. With these arms a contact conserves energy and angular momentum. At a wall the lever arm is the
    /// radius. For particles without spins the results are 0 and 1.
    #[inline(always)]
    pub fn surface_velocity(&self, particles: &Particles, reach: f64, gap: f64) -> (Vector3<f64>, f64) {
        let (radii, spins) = (&particles.radius, particles.spins());
        let of = |index: u32| spins[index as usize] * radii[index as usize];
        match self.other {
            _ if spins.is_empty() => (Vector3::zeros(), 1.0),
            Other::Particle(j) => {
                let arm = 1.0 + gap / reach;
                ((of(self.i) + of(j)) * arm, arm)
            }
            Other::Wall(_) => (of(self.i), 1.0),
        }
    }

    /// [rad/s] component along `normal` of the mean of the two spins; 0 for particles without spins. The spin of a wall
    /// is zero unless the wall turns.
    #[inline(always)]
    pub fn twist(&self, particles: &Particles, scene: &Scene, normal: &Vector3<f64>) -> f64 {
        let spins = particles.spins();
        match self.other {
            _ if spins.is_empty() => 0.0,
            Other::Particle(j) => 0.5 * (spins[self.i as usize] + spins[j as usize]).dot(normal),
            Other::Wall(at) => match scene.walls[at.wall as usize].spin() {
                None => 0.5 * spins[self.i as usize].dot(normal),
                Some(spin) => 0.5 * (spins[self.i as usize] + spin).dot(normal),
            },
        }
    }

    /// [rad/s] spin of particle i minus the spin of the other body; zero for particles without spins. The spin of a
    /// wall is zero unless the wall turns.
    #[inline(always)]
    pub fn relative_spin(&self, particles: &Particles, scene: &Scene) -> Vector3<f64> {
        let spins = particles.spins();
        match self.other {
            _ if spins.is_empty() => Vector3::zeros(),
            Other::Particle(j) => spins[self.i as usize] - spins[j as usize],
            Other::Wall(at) => match scene.walls[at.wall as usize].spin() {
                None => spins[self.i as usize],
                Some(spin) => spins[self.i as usize] - spin,
            },
        }
    }

    /// [m] smaller diameter of the two bodies, by which relative overlaps are divided; at a wall the diameter of the
    /// particle.
    pub fn diameter(&self, particles: &Particles) -> f64 {
        let radius = particles.radius[self.i as usize];
        2.0 * self.j().map_or(radius, |j| radius.min(particles.radius[j as usize]))
    }

    /// Second body of the couple, as results name it: a particle by its id, or a wall by its index.
    pub fn partner(&self, particles: &Particles) -> Partner {
        match self.other {
            Other::Particle(j) => Partner::Particle(particles.id[j as usize]),
            Other::Wall(at) => Partner::Wall(at.wall),
        }
    }

    /// Relative position and velocity of the two bodies at the instant `moment` of a predicted touch. For a wall,
    /// `feature` is the number of the surface feature (such as a triangle) that is touched; for a pair it is not used.
    #[inline(always)]
    pub fn strike(&self, particles: &Particles, scene: &Scene, moment: FrameTime, feature: u32) -> Encounter {
        let Other::Wall(at) = self.other else { return self.meet(particles, scene, moment) };
        let i = self.i as usize;
        let (flight, radius) = (moment.flight(particles, scene, i), particles.radius[i]);
        let wall = &scene.walls[at.wall as usize];
        let nearest = wall.struck([at.which, feature], &flight.position, radius, moment.sunk);
        let touched = flight.position - nearest.normal * nearest.distance;
        let surface = wall.surface_velocity(&touched, moment.sunk - moment.lag);
        let (normal, velocity) = (nearest.normal, flight.velocity - surface);
        Encounter { normal, gap: nearest.distance - radius, velocity, normal_velocity: velocity.dot(&normal) }
    }

    /// Relative position and velocity of the two bodies at the time `moment`.
    #[inline(always)]
    pub fn meet(&self, particles: &Particles, scene: &Scene, moment: FrameTime) -> Encounter {
        self.meet_at(self.reach(particles), particles, scene, moment)
    }

    /// [m] distance between the centres of the two particles at touch; at a wall the radius of the particle.
    #[inline(always)]
    pub fn reach(&self, particles: &Particles) -> f64 {
        let radius = particles.radius[self.i as usize];
        self.j().map_or(radius, |j| radius + particles.radius[j as usize])
    }

    /// Relative position and velocity of two bodies at the time `moment`. `reach` [m] is the distance of the centres at
    /// touch, as [`reach`](Self::reach) returns it.
    #[inline(always)]
    pub fn meet_at(&self, reach: f64, particles: &Particles, scene: &Scene, moment: FrameTime) -> Encounter {
        let i = self.i as usize;
        let (normal, gap, velocity) = match self.other {
            Other::Particle(j) => {
                let (apart, velocity) = relative(particles, scene, [i, j as usize], moment);
                let distance = apart.norm();
                // centres that coincide have no normal; the check of overlaps stops a run with such particles
                let normal = if distance > 0.0 { apart / distance } else { Vector3::y() };
                (normal, distance - reach, velocity)
            }
            Other::Wall(at) => {
                let flight = moment.flight(particles, scene, i);
                let wall = &scene.walls[at.wall as usize];
                let nearest = wall.contact(at.which, &flight.position, reach, moment.sunk);
                let touched = flight.position - nearest.normal * nearest.distance;
                let surface = wall.surface_velocity(&touched, moment.sunk - moment.lag);
                (nearest.normal, nearest.distance - reach, flight.velocity - surface)
            }
        };
        Encounter { normal, gap, velocity, normal_velocity: velocity.dot(&normal) }
    }

    /// [s] time from `moment` until the two bodies, moving freely, touch; `None` without a touch. A touch more than
    /// `until` [s] after `moment` may be missed.
    #[inline(always)]
    pub fn touch_time(&self, particles: &Particles, scene: &Scene, moment: FrameTime, until: f64) -> Option<f64> {
        self.touch(particles, scene, moment, until).map(|touch| touch.time)
    }

    /// First touch of the two bodies, moving freely after `moment`: its time [s] from `moment`, and the number of the
    /// surface feature (such as a triangle) that is touched. `None` without a touch. A touch more than `until` [s]
    /// after `moment` may be missed.
    #[inline(always)]
    pub fn touch(&self, particles: &Particles, scene: &Scene, moment: FrameTime, until: f64) -> Option<Touch> {
        let i = self.i as usize;
        match self.other {
            Other::Particle(j) => {
                let j = j as usize;
                let (apart, velocity) = relative(particles, scene, [i, j], moment);
                let reach = particles.radius[i] + particles.radius[j];
                let speeds = particles.velocity[i].norm() + particles.velocity[j].norm();
                first_touch(&apart, &velocity, reach, speeds).map(Touch::at)
            }
            Other::Wall(at) => {
                let flight = moment.flight(particles, scene, i);
                let wall = &scene.walls[at.wall as usize];
                wall.first_touch(at.which, &flight, particles.radius[i], (moment.sunk, until))
            }
        }
    }
}

/// False if two particles, given by their indices, cannot touch on straight flights from their present positions; true
/// if they may touch.
#[inline(always)]
pub fn may_meet(particles: &Particles, scene: &Scene, [i, j]: [usize; 2]) -> bool {
    let (apart, velocity) = relative(particles, scene, [i, j], FrameTime::default());
    may_touch(&apart, &velocity, particles.radius[i] + particles.radius[j])
}

/// Vector [m] from the second of two particles to the nearest periodic image of the first, and velocity [m/s] of this
/// image relative to the second particle, at the time `moment`.
#[inline(always)]
pub fn relative(
    particles: &Particles,
    scene: &Scene,
    [i, j]: [usize; 2],
    moment: FrameTime,
) -> (Vector3<f64>, Vector3<f64>) {
    let velocity = particles.velocity[i] - particles.velocity[j];
    scene.domain.relative(&moment.position(particles, i), &moment.position(particles, j), velocity, moment.sunk)
}
