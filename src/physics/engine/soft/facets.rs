//! Rough walls in contacts that last: the velocity of a sphere is turned when the contact begins, and turned back when
//! it ends.
//!
//! An impact on a facet with the normal n' is an impact on the smooth wall, with the normal n, in a turned frame. Let R
//! be the rotation that turns n' to n. At first touch the velocity v of the sphere relative to the wall, and its spin,
//! are multiplied by R. The contact with the smooth wall then follows its law. At its end velocity and spin are
//! multiplied by the inverse of R. With any law of restitution and friction the result is that of an impact on the
//! facet, and a rotation does not change the energy. A sphere that stays on the wall, such as one that rests on a
//! floor, keeps the turn of its last impact and has a smooth wall from then on.

use super::SoftSolver;
use super::contact::ContactForce;
use super::contacts::{ContactSearch, EvaluationTime};
use crate::encounter::{AtWall, Couple, Encounter, Other};
use crate::particles::Particles;
use crate::scene::Scene;
use crate::walls::WallApproach;
use nalgebra::{Rotation3, Vector3};

/// [rad] rotation vector (axis times angle) that turns the normal of a randomly inclined facet of a rough wall to the
/// normal of the smooth wall. `met` is the encounter at first touch, and `id` the id of the particle. `None` if the
/// other body of `couple` is not a rough wall, or if the facet is not inclined.
pub(super) fn facet_turn(
    couple: &Couple,
    met: &Encounter,
    (particles, scene): (&Particles, &Scene),
    id: u32,
) -> Option<Vector3<f64>> {
    let Other::Wall(AtWall { wall, .. }) = couple.other else { return None };
    let roughness = scene.walls[wall as usize].roughness?;
    let surface = couple.surface(particles, scene);
    let (velocity, normal) = (met.velocity, met.normal);
    let facet = roughness.facet(&WallApproach { velocity, normal, id, wall }, |speed| surface.restitution_at(speed));
    let axis = facet.cross(&normal);
    let sine = axis.norm();
    (sine > 0.0).then(|| axis * (sine.atan2(facet.dot(&normal)) / sine))
}

/// Turns the velocity and the spin of the particle at index `i` by the rotation vector `turn` [rad]. The wall is at
/// rest; the velocity relative to the wall is the stored velocity plus `fallen` [m/s], the velocity that gravity has
/// added. Returns the impulse [kg m/s] that the wall gives to the particle.
pub(super) fn turn_motion(
    particles: &mut Particles,
    i: usize,
    turn: &Vector3<f64>,
    fallen: &Vector3<f64>,
) -> Vector3<f64> {
    let rotation = Rotation3::new(*turn);
    let velocity = particles.velocity[i] + fallen;
    let change = rotation * velocity - velocity;
    particles.velocity[i] += change;
    if let Some(spins) = &mut particles.spin {
        spins[i] = rotation * spins[i];
    }
    change * particles.mass[i]
}

impl SoftSolver {
    /// Turns the velocities of the particles whose contacts with rough walls begin at the present positions, before
    /// their forces are evaluated at the time `at`.
    pub(super) fn meet_facets(&mut self, particles: &mut Particles, scene: &Scene, at: EvaluationTime) {
        if !self.has_rough_walls {
            return;
        }
        let view = ContactSearch { list: &self.list, particles, scene, at, mine: None, alike: None };
        for slot in self.contacts.begun_at_rough_walls(view) {
            let couple = self.list.couple(slot as usize);
            let met = couple.meet(particles, scene, at.moment());
            let name = particles.id[couple.i as usize];
            // in a crowd (large island) numbers replace the ids in the store, and `self.ids` contains the ids
            let id = self.ids.get(name as usize).copied().unwrap_or(name);
            let Some(turn) = facet_turn(&couple, &met, (particles, scene), id) else { continue };
            self.contacts.meet_facet(slot, turn, &self.list);
            let impulse = turn_motion(particles, couple.i as usize, &turn, &(scene.gravity * at.fall));
            self.count_turn((&couple, &impulse), (particles, scene), at, at.elapsed - at.fall);
        }
    }

    /// Turns back the velocities of the particles whose contacts with rough walls ended in the evaluation at the time
    /// `at`, after its forces have changed the velocities.
    pub(super) fn leave_facets(&mut self, particles: &mut Particles, scene: &Scene, at: EvaluationTime) {
        if !self.has_rough_walls {
            return;
        }
        for (couple, turn) in self.contacts.left_facets(&self.list) {
            let impulse = turn_motion(particles, couple.i as usize, &-turn, &(scene.gravity * at.elapsed));
            self.count_turn((&couple, &impulse), (particles, scene), at, 0.0);
        }
    }

    /// Adds to the sums the impulse [kg m/s] that a rough wall gives to a particle, at the time `before` [s] earlier
    /// than `at`. Raises the limits of speeds to the new speed of the particle.
    fn count_turn(
        &mut self,
        (couple, impulse): (&Couple, &Vector3<f64>),
        (particles, scene): (&Particles, &Scene),
        at: EvaluationTime,
        before: f64,
    ) {
        let normal = couple.meet(particles, scene, at.moment()).normal;
        let (on_i, along) = (impulse / at.dt, impulse.dot(&normal) / at.dt);
        let force = ContactForce { on_i, normal: along, ..ContactForce::lost(0.0) };
        self.contacts.count_turn(couple, &force, (scene, at.remaining + before));
        let speed = (particles.velocity[couple.i as usize] - self.list.frame()).norm();
        let in_flow = |_| particles.largest_speed_in(self.list.frame(), &scene.domain);
        self.speed.rise(scene.domain.shear.map_or(speed, in_flow));
    }
}
