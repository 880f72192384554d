//! One contact: who touches whom, how they stand to one another, what forces that makes, and what becomes of the energy.

use crate::contact_law::{Bodies, ContactLaw, Spring, friction_force};
use crate::engine::{Failure, Partner};
use crate::neighbours::NeighbourList;
use crate::particles::Particles;
use crate::record::{Impact, Log};
use crate::scene::{Scene, Surface};
use nalgebra::Vector3;

/// [-] overlap over the (smaller) diameter beyond which "the normal" no longer means anything: at a plane (`flat`) when the sphere is
/// wholly behind it, otherwise when centres of a pair are nearer than half the distance of touch, or a centre is within a body.
pub fn overlap_limit(flat: bool) -> f64 {
    if flat { 1.0 } else { 0.5 }
}

/// What is known of two touching bodies besides their motion.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// Place of a particle.
    pub i: u32,
    /// Place of the other particle, or index of the wall.
    pub other: u32,
    /// Which of the two.
    pub wall: bool,
    spring: Spring,
    /// [m] smaller diameter.
    diameter: f64,
}

/// A contact that has begun and not ended.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    /// Slot of the neighbour list.
    pub slot: u32,
    /// Who.
    pub touch: Touch,
    /// [m/s] of approach.
    pub normal_speed: f64,
    /// [m] when first seen.
    pub first_overlap: f64,
    /// [m] so far.
    pub maximum_overlap: f64,
    /// [m] now.
    pub overlap: f64,
    /// [m/s] at which that grows now.
    pub growth: f64,
    /// [m s] overlap integrated over time so far.
    pub overlap_time: f64,
    /// [s] simulated time at first sight.
    pub began: f64,
    /// Normal at the last look; zero before the first.
    pub normal: Vector3<f64>,
}

impl Contact {
    /// A contact seen for the first time at simulated time `began` [s].
    pub fn new(slot: u32, touch: Touch, began: f64) -> Self {
        let (slow, none, normal) = (0.0, 0.0, Vector3::zeros());
        Self {
            slot,
            touch,
            normal_speed: slow,
            first_overlap: none,
            maximum_overlap: none,
            overlap: none,
            growth: slow,
            overlap_time: none,
            began,
            normal,
        }
    }

    /// Refuses overlaps at which "the normal" no longer means anything: centres of a pair nearer than half the distance
    /// of touch, a centre within a solid body or already beyond its middle, or a sphere wholly behind a plane.
    pub fn check(&self, meeting: &Meeting, particles: &Particles, scene: &Scene, time: f64) -> Result<(), Failure> {
        let Touch { i, other, wall, diameter, .. } = self.touch;
        let flat = wall && scene.walls[other as usize].geometry.is_flat();
        let limit = overlap_limit(flat);
        let through = self.normal.dot(&meeting.normal) < 0.0;
        let ratio = meeting.overlap / diameter;
        if ratio <= limit && !through {
            return Ok(());
        }
        let partner = if wall { Partner::Wall(other) } else { Partner::Particle(particles.id[other as usize]) };
        let particle = particles.id[i as usize];
        // on its way through it has been deeper than what is seen now
        Err(Failure::OverlapTooLarge {
            time,
            particle,
            partner,
            ratio: if through { ratio.max(limit) } else { ratio },
            limit,
        })
    }

    /// The impact it was, now that it has ended with that rebound speed [m/s] at that time [s].
    pub fn impact(&self, rebound_speed: f64, now: f64) -> Impact {
        Impact {
            normal_speed: self.normal_speed,
            rebound_speed,
            duration: now - self.began,
            first_overlap: self.first_overlap / self.touch.diameter,
            maximum_overlap: self.maximum_overlap / self.touch.diameter,
            overlap_time: self.overlap_time / self.touch.diameter,
        }
    }
}

/// Relative motion of two bodies that are near.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// From the other body to particle i.
    pub normal: Vector3<f64>,
    /// [m] negative: a gap.
    pub overlap: f64,
    /// [m/s] positive: separating.
    pub normal_velocity: f64,
    /// [m/s] tangential part of the relative velocity.
    pub slip: Vector3<f64>,
}

/// What a contact does now.
#[derive(Clone, Copy, Debug)]
pub struct Force {
    /// [N] on particle i; the other gets the opposite.
    pub on_i: Vector3<f64>,
    /// [N] along the normal.
    pub normal: f64,
    /// [W] taken out by the dashpot, in the middle of the kick.
    pub restitution_power: f64,
    /// [W] taken out by friction, in the middle of the kick.
    pub friction_power: f64,
}

/// Powers [W] and force on the particles from walls [N].
#[derive(Clone, Copy, Debug, Default)]
pub struct Rates {
    pair_restitution: f64,
    pair_friction: f64,
    wall_restitution: f64,
    wall_friction: f64,
    wall_force: Vector3<f64>,
    wall_normal_force: f64,
}

impl Touch {
    /// The two bodies of a slot.
    pub fn of(slot: u32, list: &NeighbourList, particles: &Particles, scene: &Scene, law: &ContactLaw) -> Self {
        let slot = slot as usize;
        if let Some(pair) = list.pairs.get(slot) {
            let (i, j) = (pair.i as usize, pair.j as usize);
            let spring = law.between(&Bodies::pair(scene, particles, i, j));
            let diameter = 2.0 * particles.radius[i].min(particles.radius[j]);
            Self { i: pair.i, other: pair.j, wall: false, spring, diameter }
        } else {
            let near = list.walls[slot - list.pairs.len()];
            let i = near.particle as usize;
            let spring = law.between(&Bodies::at_wall(scene, particles, i, near.wall as usize));
            let diameter = 2.0 * particles.radius[i];
            Self { i: near.particle, other: near.wall, wall: true, spring, diameter }
        }
    }

    /// The constants of the contact law between the two.
    pub fn spring(&self) -> &Spring {
        &self.spring
    }

    /// [kg] effective mass M.
    pub fn effective_mass(&self) -> f64 {
        self.spring.effective_mass
    }

    /// [m] of the smaller body.
    pub fn diameter(&self) -> f64 {
        self.diameter
    }

    /// Whether these are the two bodies of a slot.
    pub fn is(&self, slot: usize, list: &NeighbourList) -> bool {
        match list.pairs.get(slot) {
            Some(pair) => {
                !self.wall && ((pair.i, pair.j) == (self.i, self.other) || (pair.j, pair.i) == (self.i, self.other))
            }
            None => {
                let near = list.walls[slot - list.pairs.len()];
                self.wall && (near.particle, near.wall) == (self.i, self.other)
            }
        }
    }

    /// The force of the contact. `time_step` [s] is how long friction acts, `to_middle` [s] from these velocities to where
    /// powers are taken.
    #[inline]
    pub fn force(&self, law: &ContactLaw, meeting: &Meeting, scene: &Scene, time_step: f64, to_middle: f64) -> Force {
        let m = self.effective_mass();
        let (spring, dashpot) = law.force(&self.spring, meeting.overlap, meeting.normal_velocity);
        let normal = spring + dashpot;
        let mut on_i = meeting.normal * normal;
        let mut friction_power = 0.0;
        let surface = self.surface(scene);
        if surface.friction > 0.0 {
            let slip = meeting.slip.norm();
            let friction = friction_force(surface, normal, slip, m, time_step);
            if friction > 0.0 {
                on_i -= meeting.slip * (friction / slip);
                friction_power = friction * (slip - to_middle * friction / m);
            }
        }
        let restitution_power = -dashpot * (meeting.normal_velocity + to_middle * normal / m);
        Force { on_i, normal, restitution_power, friction_power }
    }

    /// What the two meet with.
    pub fn surface<'s>(&self, scene: &'s Scene) -> &'s Surface {
        if self.wall { &scene.walls[self.other as usize].surface } else { &scene.contact }
    }

    /// How the two bodies stand to one another; `fallen` [m/s] is what gravity has added to the velocities.
    #[inline]
    pub fn meeting(&self, particles: &Particles, scene: &Scene, fallen: Vector3<f64>) -> Meeting {
        self.meeting_shifted(particles, scene, Vector3::zeros(), fallen)
    }

    /// The same where gravity has also moved the particles, by `shift` [m]: a wall does not fall with them.
    #[inline]
    pub fn meeting_shifted(
        &self,
        particles: &Particles,
        scene: &Scene,
        shift: Vector3<f64>,
        fallen: Vector3<f64>,
    ) -> Meeting {
        let i = self.i as usize;
        let (x, r) = (&particles.position[i], particles.radius[i]);
        let (normal, gap, velocity) = if self.wall {
            let nearest = scene.walls[self.other as usize].geometry.nearest(&(x + shift));
            (nearest.normal, nearest.distance - r, particles.velocity[i] + fallen)
        } else {
            let j = self.other as usize;
            let apart = scene.domain.separation(x, &particles.position[j]);
            let distance = apart.norm();
            // centres that coincide have no normal; the overlap check refuses them
            let normal = if distance > 0.0 { apart / distance } else { Vector3::y() };
            (normal, distance - (r + particles.radius[j]), particles.velocity[i] - particles.velocity[j])
        };
        let normal_velocity = velocity.dot(&normal);
        Meeting { normal, overlap: -gap, normal_velocity, slip: velocity - normal * normal_velocity }
    }
}

impl Rates {
    /// Adds a contact with a weight [-].
    #[inline]
    pub fn count(&mut self, touch: &Touch, force: &Force, weight: f64) {
        if touch.wall {
            self.wall_restitution += weight * force.restitution_power;
            self.wall_friction += weight * force.friction_power;
            self.wall_force += force.on_i * weight;
            self.wall_normal_force += weight * force.normal;
        } else {
            self.pair_restitution += weight * force.restitution_power;
            self.pair_friction += weight * force.friction_power;
        }
    }

    /// Books these powers and forces for `time` [s], `remaining` [s] before the end of the window.
    pub fn add(&self, time: f64, remaining: f64, scene: &Scene, log: &mut Log) {
        let ledger = &mut log.ledger;
        ledger.pair_restitution_loss += self.pair_restitution * time;
        ledger.pair_friction_loss += self.pair_friction * time;
        ledger.wall_restitution_loss += self.wall_restitution * time;
        ledger.wall_friction_loss += self.wall_friction * time;
        let impulse = self.wall_force * time;
        ledger.wall_impulse += impulse;
        ledger.wall_normal_impulse += self.wall_normal_force * time;
        // what walls add to the momentum, gravity works on for the rest of the window
        ledger.gravity_work += scene.gravity.dot(&impulse) * remaining;
    }
}
