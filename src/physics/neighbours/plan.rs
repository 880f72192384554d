//! Settings for building a neighbour list: its frame and its skin. If several processes share a run, the settings also
//! contain the sizes of all particles.

use super::along_walls;
use super::levels::{SizesOfAll, range};
use crate::communicator::Communicator;
use crate::exact;
use crate::particles::Particles;
use crate::scene::Scene;
use nalgebra::Vector3;

/// Settings of a neighbour list, which are equal in all processes that share a run.
#[derive(Clone, Debug)]
pub struct ListSettings {
    /// [m/s] velocity of the frame relative to which the list measures how far particles move.
    pub frame: Vector3<f64>,
    /// [m/s] largest speed of any particle relative to the frame and, in a sheared box, to the mean flow.
    pub largest_speed: f64,
    /// [m] skin: gap up to which pairs are listed.
    pub skin: f64,
    /// [-] number of times that the list can be used before it must be rebuilt, at the present speeds of the particles.
    pub uses: f64,
    /// Sizes of the particles in all processes that share a run; `None` if this process stores all particles.
    pub of_all: Option<SizesOfAll>,
}

impl ListSettings {
    /// Chooses settings for the present velocities. The skin (gap up to which pairs are listed) is that of lowest
    /// computing cost for a list that is used at intervals of `between_uses` [s] in simulated time. At the present
    /// speeds the list lasts for at least one use.
    pub fn of(particles: &Particles, scene: &Scene, between_uses: f64) -> Self {
        let relative = particles.relative_to_flow(&scene.domain);
        let frame = along_walls(scene, relative.mean_velocity());
        let sizes = (particles.len(), particles.mean_radii(1.0)[0]);
        Self::new((frame, relative.largest_speed(frame)), sizes, scene, between_uses)
    }

    /// Chooses settings as [`of`](Self::of) does, for a run that several processes share. `particles` are those of
    /// this process. All processes together have `count` particles with the mean radius `mean_radius` [m].
    pub fn across_processes(
        particles: &Particles,
        (count, mean_radius): (usize, f64),
        scene: &Scene,
        between_uses: f64,
        communicator: &dyn Communicator,
    ) -> Self {
        let mut sums = particles.velocity_sums();
        communicator.total(&mut sums.each_mut());
        let frame = along_walls(scene, Vector3::from(exact::values(&sums)) / count.max(1) as f64);
        let [most, least] = range(&particles.radius);
        // a process without particles must not affect the smallest radius
        let least = if particles.is_empty() { f64::INFINITY } else { least };
        let mut largest = [particles.largest_speed(frame), most, -least];
        communicator.largest(&mut largest);
        let mut of_all = SizesOfAll::of(&particles.radius, [largest[1], -largest[2]]);
        communicator.sum(&mut of_all.count);
        communicator.largest(&mut of_all.largest);
        let plan = Self::new((frame, largest[0]), (count, mean_radius), scene, between_uses);
        Self { of_all: Some(of_all), ..plan }
    }

    fn new((frame, largest_speed): (Vector3<f64>, f64), sizes: (usize, f64), scene: &Scene, between_uses: f64) -> Self {
        let fall = scene.gravity - along_walls(scene, scene.gravity);
        // the mean flow of a sheared box moves two particles, some diameters apart, towards each other
        let strain = scene.domain.strain_rate() * 2.0 * sizes.1;
        let speed = largest_speed + fall.norm() * between_uses + strain + scene.wall_speed();
        let skin = cheapest_skin(sizes, scene, speed * between_uses);
        Self { frame, largest_speed, skin, uses: skin / (2.0 * speed * between_uses), of_all: None }
    }
}

/// [m] skin (gap up to which pairs are listed) of lowest computing cost. With a larger skin, a list is built less
/// often, but it contains more pairs.
///
/// There are `count` particles with the mean radius `mean_radius` [m]. `travel` [m] is the distance that particles may
/// move relative to the frame between two uses of the list. Costs are counted per particle and use, in units of the
/// test of one pair. The costs were measured once and are constants, so that results do not depend on the machine.
fn cheapest_skin((count, mean_radius): (usize, f64), scene: &Scene, travel: f64) -> f64 {
    /// [-] cost of building a list, per particle, over the cost of testing one pair (docs/design/neighbours.md,
    /// "Skin").
    const BUILD: f64 = 60.0;
    let (domain, count) = (&scene.domain, count.max(1) as f64);
    let diameter = 2.0 * mean_radius;
    let density = count / domain.volume();
    let pairs =
        |skin: f64| density * 2.0 / 3.0 * std::f64::consts::PI * ((diameter + skin).powi(3) - 0.8 * diameter.powi(3));
    let mut best = (f64::INFINITY, 2.0 * travel);
    let mut uses = 1.0;
    while uses < 1e5 {
        let skin = 2.0 * uses * travel;
        let cost = BUILD / uses + pairs(skin);
        if cost < best.0 {
            best = (cost, skin);
        }
        uses *= 1.25;
    }
    // Positions are wrapped when the list is built. If two particles then move apart by more than half a period, their
    // coordinates may differ by more than 1.5 periods, and `separation` no longer finds the nearest image.
    let periods = (0..3).filter(|axis| domain.periodic[*axis]).map(|axis| domain.size[axis]);
    let mut longest = periods.fold(f64::INFINITY, f64::min) * 0.5;
    if domain.shear.is_some() {
        // otherwise a particle could be listed twice with another one, within the box and across the sheared sides
        longest = longest.min(0.5 * domain.size.y - scene.largest_diameter());
    }
    let skin = best.1.min(longest).max(2.0 * travel);
    // with a skin of zero, the list of spheres at rest would be rebuilt at every use. The last factor allows for
    // rounding of the distances moved.
    skin.max(1e-3 * diameter) * (1.0 + 1e-9)
}
