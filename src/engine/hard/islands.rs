//! A small calendar for each island.

use super::events::{EventLoop, Limit};
use crate::engine::islands::{Island, Solve};
use crate::engine::{Failure, Window};
use crate::scene::Scene;
use nalgebra::Vector3;

/// Solves islands by events; nothing lasts.
pub struct HardIslands;

/// The limits of an island.
struct Within<'a>(&'a dyn Fn(usize, &Vector3<f64>) -> bool);

impl Limit for Within<'_> {
    fn allows(&self, place: usize, velocity: &Vector3<f64>) -> bool {
        (self.0)(place, velocity)
    }
}

impl Solve for HardIslands {
    type Carried = ();
    type Scratch = EventLoop;

    fn places(_carried: &()) -> [Option<u32>; 2] {
        [None, None]
    }

    fn moved(_carried: &(), _place_of: &dyn Fn(u32) -> u32) {}

    fn energy(&self, _carried: &()) -> f64 {
        0.0
    }

    fn solve(
        &self,
        island: &mut Island<()>,
        events: &mut EventLoop,
        scene: &Scene,
        window: Window,
        end: f64,
    ) -> Result<Option<usize>, Failure> {
        std::mem::swap(&mut events.list, &mut island.list);
        events.adopt(island.particles.len());
        let before = (events.events, events.pair_checks);
        let mut particles = std::mem::take(&mut island.particles);
        let mut log = std::mem::take(&mut island.log);
        let limit = Within(&|place, velocity| island.allows(place, velocity));
        let (_, result) = events.run(&mut particles, scene, window, end, &limit, &mut log);
        for (x, v) in particles.position.iter_mut().zip(&mut particles.velocity).take(island.hot) {
            *x += *v * end + scene.gravity * (0.5 * end * end);
            *v += scene.gravity * end;
        }
        island.particles = particles;
        island.log = log;
        island.events += events.events - before.0;
        island.pair_checks += events.pair_checks - before.1;
        result
    }
}
