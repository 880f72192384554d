//! Neighbour lists of sheared boxes: pairs across the sheared sides, and the motion of the mean flow.

use super::levels::SizeLevels;
use super::packed::PackedBalls;
use super::region::Region;
use super::{NeighbourList, Pair};
use crate::domain::Domain;
use crate::particles::Particles;
use crate::scene::Scene;

impl NeighbourList {
    /// [m/s] speed at which the mean flow of a sheared box may move each of two listed particles towards the other. It
    /// is half the shear rate times the largest distance between the centres of a listed pair. The caller adds this
    /// speed to the largest speed of particles relative to the frame of the list. The result is 0 without shear.
    pub fn strain(&self, particles: &Particles, domain: &Domain) -> f64 {
        if domain.shear.is_none() {
            return 0.0;
        }
        let largest = particles.radius.iter().fold(0.0, |most: f64, &radius| most.max(radius));
        0.5 * domain.strain_rate() * (2.0 * largest + self.skin)
    }

    /// Adds the pairs across the sheared sides of the box. For this purpose, images of the lowest particles above the
    /// upper side are compared with the particles below that side.
    pub(super) fn find_pairs_across(
        &mut self,
        levels: &SizeLevels,
        region: &Region,
        (particles, scene): (&Particles, &Scene),
        skin: f64,
    ) {
        if scene.domain.shear.is_none() {
            return;
        }
        let (mut packed, known) = (PackedBalls::default(), self.pairs.len());
        let indices: Vec<u32> = (0..particles.len() as u32).collect();
        let ball = |i: usize| (particles.position[i], particles.radius[i] + 0.5 * skin);
        packed.fill(&indices, ball, region);
        for i in 0..particles.len() {
            // the levels know radii without the skin, so the whole skin belongs to this particle
            let (position, reach) = (particles.position[i], particles.radius[i] + skin);
            let search_radius = reach + levels.largest_reach();
            if position.y >= search_radius {
                continue;
            }
            scene.domain.for_each_across(&position, search_radius, |image| {
                packed.for_each_beside((image, reach), levels, region, |others| {
                    let pairs = others.iter().map(|&j| Pair { i: i as u32, j });
                    // the search within the box finds pairs that are nearer there than across the sides
                    let height = |j: u32| particles.position[j as usize].y;
                    let is_across = |pair: &Pair| (position.y - height(pair.j)).abs() > 0.5 * scene.domain.size.y;
                    let is_near = |pair: &Pair| pair.is_within(pair.reach(particles) + skin, particles, scene);
                    let near = |pair: &Pair| is_across(pair) && is_near(pair);
                    self.pairs.extend(pairs.filter(near));
                });
            });
        }
        if self.pairs.len() > known {
            self.pairs.sort_by_key(|pair| pair.i);
            self.note_first_pairs(particles.len());
        }
    }
}
