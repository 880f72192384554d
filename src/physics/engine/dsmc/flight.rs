//! Free flight of all particles for collisions by chance, with the impacts on walls at their exact times. A window is
//! the time between two exchanges with the gas.

use crate::encounter::{AtWall, Couple, FrameTime};
use crate::engine::hard::{Collision, LastCollision};
use crate::engine::{Failure, Window};
use crate::particles::{CHUNK, Motion, Particles};
use crate::record::Log;
use crate::scene::Scene;
use crate::walls::{Flight, Geometry, NearWalls, Plane, Touch, Wall, WallGeometry};
use crate::work_sharing;
use nalgebra::Vector3;

/// Number of particles that a thread moves as one piece of work, if they are far from walls.
const PART: usize = CHUNK / 4;

/// Number of particles near walls that a thread moves as one piece of work. A particle near walls takes as much
/// computing time as dozens of other particles.
const FEW: usize = 128;

/// Interval of time in which particles fly, within a window (time between two exchanges with the gas).
#[derive(Clone, Copy, Debug)]
pub struct FlightTime {
    /// The window to which the flight belongs.
    pub window: Window,
    /// [s] start of the flight, since the start of the window.
    pub start: f64,
    /// [s] length of the flight.
    pub duration: f64,
}

/// Walls of a scene, sorted into flat and other walls for the flight of particles.
pub struct FlightWalls {
    near: NearWalls,
    /// All flat walls of the scene.
    planes: Vec<Plane>,
    /// True if all walls of the scene are flat.
    are_flat: bool,
}

impl FlightWalls {
    /// Sorts the walls of a scene into flat walls and others.
    pub fn of(walls: &[Wall]) -> Self {
        let planes: Vec<Plane> = walls.iter().filter_map(|wall| wall.geometry.plane()).copied().collect();
        Self { near: NearWalls::of(walls), are_flat: planes.len() == walls.len(), planes }
    }

    /// True if a sphere may touch a wall while its centre flies from one point [m] to another. `reach` [m] is the
    /// radius plus the largest distance of the curved path from the straight line between the points.
    #[inline]
    fn may_be_touched(&self, scene: &Scene, [from, to]: [&Vector3<f64>; 2], reach: f64) -> bool {
        // the distance from a plane is least at an end of the line
        let touches = |plane: &Plane| plane.nearest(from).distance.min(plane.nearest(to).distance) < reach;
        self.planes.iter().any(touches) || (!self.are_flat && self.may_be_met(scene, [from, to], reach))
    }

    /// True if a wall is within `reach` [m] of the ball that has the line between the two points [m] as a diameter.
    fn may_be_met(&self, scene: &Scene, [from, to]: [&Vector3<f64>; 2], reach: f64) -> bool {
        let (middle, around) = ((from + to) * 0.5, reach + 0.5 * (to - from).norm());
        let mut found = false;
        self.near.for_each(&middle, around, |wall| {
            found = found || scene.walls[wall as usize].geometry.is_within(&middle, around);
        });
        found
    }
}

/// Result of the flight of one particle near walls: its index in the particle store, its position and velocity at the
/// end, and the failure that stopped the particle, or `None`.
type FlownParticle = (u32, Motion, Option<Failure>);

/// Moves all particles along their parabolas through an interval of time, with their impacts on walls. Returns the
/// number of impacts.
///
/// # Errors
/// A particle has infinitely many impacts on a wall, because it comes to rest there or slides along the wall. Or the
/// square of its speed is not a finite number. All other particles are then at the end of the flight.
pub fn fly(
    particles: &mut Particles,
    scene: &Scene,
    walls: &FlightWalls,
    time: FlightTime,
    log: &mut Log,
) -> Result<u64, Failure> {
    let near = fly_freely(particles, scene, walls, time.duration);
    let some = work_sharing::map_with(
        near.chunks(FEW),
        || (Particles::default(), Vec::new()),
        |(one, found), indices| {
            let mut log = Log::default();
            let fly = |&index: &u32| {
                one.clear();
                one.copy_from(particles, &[index]);
                let failure = fly_among_walls(one, scene, (&walls.near, found), time, &mut log).err();
                (index, one.motion(0), failure)
            };
            (indices.iter().map(fly).collect::<Vec<FlownParticle>>(), log)
        },
    );
    let (mut impacts, mut failed) = (0, None);
    for (flown, mut some) in some {
        for (index, mut motion, failure) in flown {
            motion.position = scene.domain.wrap(&motion.position);
            particles.set_motion(index as usize, &motion);
            failed = failed.or(failure);
        }
        impacts += some.impacts.len() as u64;
        log.impacts.append(&mut some.impacts);
        log.islands.push(some.ledger.to_array());
    }
    if scene.domain.shear.is_some() {
        log.ledger += particles.wrap(&scene.domain.at(time.window.start + time.start + time.duration));
    }
    failed.map_or(Ok(impacts), Err)
}

/// Moves all particles that cannot touch a wall within `duration` [s] to the end of this time. Returns the indices of
/// the other particles, which have not moved. Particles whose squared speed is not finite are among them.
fn fly_freely(particles: &mut Particles, scene: &Scene, walls: &FlightWalls, duration: f64) -> Vec<u32> {
    let fall = scene.gravity * duration;
    let sag = 0.125 * scene.gravity.norm() * duration * duration;
    let Particles { position, velocity, radius, .. } = particles;
    let parts = position.chunks_mut(PART).zip(velocity.chunks_mut(PART)).zip(radius.chunks(PART)).enumerate();
    let near = work_sharing::map(parts, |(part, ((positions, velocities), radii))| {
        let mut near = Vec::new();
        for (k, (x, v)) in positions.iter_mut().zip(velocities).enumerate() {
            let end = *x + (*v + 0.5 * fall) * duration;
            if !v.norm_squared().is_finite() || walls.may_be_touched(scene, [x, &end], radii[k] + sag) {
                near.push((part * PART + k) as u32);
            } else {
                // across a sheared side the velocity changes too
                *x = if scene.domain.shear.is_none() { scene.domain.wrap(&end) } else { end };
                *v += fall;
            }
        }
        near
    });
    near.concat()
}

/// Moves a particle through an interval of time, with all its impacts on walls. The particle is the only one in the
/// particle store `one`. `found` is scratch memory for the numbers of near walls. Returns an error if the particle
/// comes to rest on a wall, or if the square of its speed is not a finite number.
fn fly_among_walls(
    one: &mut Particles,
    scene: &Scene,
    (walls, found): (&NearWalls, &mut Vec<u32>),
    time: FlightTime,
    log: &mut Log,
) -> Result<(), Failure> {
    let (mut flown, mut history) = (0.0, LastCollision::default());
    loop {
        let left = time.duration - flown;
        let flight = Flight { position: one.position[0], velocity: one.velocity[0], gravity: scene.gravity };
        // at an infinite speed the pieces of the flight would be endlessly many
        if !flight.velocity.norm_squared().is_finite() {
            return Err(Failure::NotANumber { time: time.window.start + time.start + flown, particle: one.id[0] });
        }
        let rest = left.min(longest_piece(scene, &flight, left));
        let reach = one.radius[0] + (flight.velocity.norm() + 0.5 * scene.gravity.norm() * rest) * rest;
        walls.list(&flight.position, reach, found);
        let next = first_touch(one, scene, found, rest);
        let until = next.map_or(rest, |(_, touch)| touch.time.min(rest));
        one.position[0] = flight.position_at(until);
        one.velocity[0] = flight.velocity_at(until);
        flown += until;
        let Some((couple, touch)) = next else {
            if rest == left {
                return Ok(());
            }
            one.position[0] = scene.domain.wrap(&one.position[0]);
            continue;
        };
        let now = time.start + flown;
        let here = FrameTime::default();
        let met = couple.strike(one, scene, here, touch.feature);
        let wall = couple.wall_motion(&met, (one, scene), here);
        let collision = Collision { couple, met, elastic: false, kinds: couple.kinds(one), wall, image: 0.0 };
        collision.resolve(one, scene, time.window.duration - now, log);
        if let Some(interval) = history.note(&collision, scene, time.window.start + now, None) {
            let [x, y, z] = scene.domain.wrap(&one.position[0]).into();
            return Err(Failure::RestOnWall {
                time: time.window.start + time.start + time.duration,
                particle: one.id[0],
                partner: couple.partner(one),
                impacts: history.impacts,
                interval,
                x,
                y,
                z,
            });
        }
    }
}

/// [s] longest time for which a particle may fly before near walls are searched again, if `left` [s] of its flight
/// remain. In this time the particle moves by at most one period of the box. So all periodic images of walls that it
/// may reach are tested. The result is infinite if no wall has images, and in a sheared box.
fn longest_piece(scene: &Scene, flight: &Flight, left: f64) -> f64 {
    let domain = &scene.domain;
    let has_images = scene.walls.iter().any(|wall| matches!(wall.geometry, WallGeometry::Repeated(_)));
    if !has_images || domain.shear.is_some() {
        return f64::INFINITY;
    }
    let periods = (0..3).filter(|axis| domain.periodic[*axis]).map(|axis| domain.size[axis]);
    periods.fold(f64::INFINITY, f64::min) / (flight.velocity.norm() + flight.gravity.norm() * left)
}

/// First touch of the single particle in the particle store `one` with one of the given walls within `until` [s] from
/// now; `None` without a touch.
fn first_touch(one: &Particles, scene: &Scene, walls: &[u32], until: f64) -> Option<(Couple, Touch)> {
    let contacts = walls.iter().flat_map(|&wall| {
        (0..scene.walls[wall as usize].geometry.contacts()).map(move |which| Couple::at_wall(0, AtWall { wall, which }))
    });
    let touches = contacts.filter_map(|couple| {
        Some((couple, couple.touch(one, scene, FrameTime::default(), until)?)).filter(|(_, touch)| touch.time <= until)
    });
    touches.reduce(|first, next| if next.1.time < first.1.time { next } else { first })
}
