//! What one calendar for all costs, in the measure of the islands: the two are weighed by counts.

use crate::engine::Window;
use crate::neighbours::along_walls;
use crate::neighbours::levels::Census;
use crate::particles::Particles;
use crate::scene::Scene;
use std::f64::consts::{PI, SQRT_2};

/// [ns] foretelling one touch and putting it in the calendar. Measured once, on one quiet core, among 1000 spheres of two sizes:
/// 55 ns with the builds of the list, which are counted apart here.
const TOUCH: f64 = 40.0;

/// [ns] building the neighbour list, per particle: cells, order and walls. As the islands' search, which does the same.
const BUILD: f64 = 90.0;

/// [ns] looking at one pair while the list is built: as in the islands' search, but in double precision.
const PAIR: f64 = 3.0;

/// [-] volume fraction from which on the calendar that lasts costs less than islands. Of 10⁴ elastic spheres in a periodic box it
/// made, beside islands on one thread, 0.8 times as many collisions a second at 0.05, 1.1 at 0.1, 1.7 at 0.2, 2.3 at 0.3; islands
/// gain by more threads, and the calendar does not.
const DENSE: f64 = 0.2;

/// [ns/s] what the islands of this window must cost less than, per particle and simulated time; `None`: they are not tried.
///
/// Without drag the calendar lasts from window to window and is taken where it is dense. Where drag kicks every window it foretells
/// everything in each. Of mixtures the cost is weighed: in those the islands of the largest spheres run together first. Spheres of
/// one size do not need it: in the cases of this project islands cost from seven tenths (dense gas, volume fraction 0.3) to
/// a hundredth of one calendar that is made anew.
pub fn rival(particles: &Particles, scene: &Scene, window: Window) -> Option<f64> {
    if lasts(scene) && filled(particles, scene) > DENSE {
        return None;
    }
    let mixed = particles.radius.windows(2).any(|pair| pair[0] != pair[1]);
    Some(if mixed { one_calendar(particles, scene, window) } else { f64::INFINITY })
}

/// Whether a calendar outlasts its window: drag kicks everyone at the end of each.
pub fn lasts(scene: &Scene) -> bool {
    scene.fluid.as_ref().is_none_or(|fluid| fluid.drag.is_none())
}

/// [-] volume fraction of the box.
fn filled(particles: &Particles, scene: &Scene) -> f64 {
    let [.., cube] = particles.mean_radii(1.0);
    cube * particles.len() as f64 * 4.0 / 3.0 * PI / scene.domain.volume()
}

/// [ns/s] what one calendar for all costs per particle and simulated time.
///
/// Every touch on the list is foretold at the start of a window, and those of both partners after a collision; the list is
/// built whenever the fastest particle has gone half its skin. Of all skins the cheapest counts.
fn one_calendar(particles: &Particles, scene: &Scene, window: Window) -> f64 {
    let count = particles.len().max(1) as f64;
    let density = count / scene.domain.volume();
    let frame = along_walls(scene, particles.mean_velocity());
    let square = particles.mean_square_speed(frame);
    let fastest = particles.largest_speed(frame);
    let [mean, mean_square, _] = particles.mean_radii(1.0);
    // [m²] mean square of the distance at which two touch
    let reach_square = 2.0 * (mean_square + mean * mean);
    let rate = density * PI * reach_square * square.sqrt() * SQRT_2;
    let largest = 2.0 * particles.radius.iter().fold(0.0, |a: f64, &r| a.max(r));
    let census = Census::of(&particles.radius, scene.domain.volume());
    let mut best = f64::INFINITY;
    let mut uses = 1.0;
    while uses < 1e3 {
        let between = uses * window.duration;
        let skin = 2.0 * fastest * between;
        let listed = density * 2.0 / 3.0 * PI * ((reach_square.sqrt() + skin).powi(3) - 0.8 * reach_square.powf(1.5));
        let in_one_grid = || 13.5 * (density * (largest + skin).powi(3)).max(0.5);
        let looked_at = census.as_ref().map_or_else(in_one_grid, |census| census.looked_at(skin));
        let touches = TOUCH * listed * (1.0 / window.duration + 2.0 * rate);
        best = best.min(touches + (BUILD + PAIR * looked_at) / between);
        uses *= 1.25;
    }
    best
}
