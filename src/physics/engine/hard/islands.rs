//! Solver of islands of hard spheres, with a small event queue for each island. An island is a group of particles that
//! may meet within a part (piece) of the time between two exchanges with the gas.

use super::collapse_detector::Recent;
use super::events::{EventLoop, WindowPart};
use crate::encounter::Couple;
use crate::engine::Window;
use crate::engine::islands::{GivenUp, Island, Solve, TracedIslands};
use crate::scene::Scene;

/// Solver that moves the hard spheres of one island (group of particles that may meet) from collision to collision
/// through a part (interval of time). It carries only the times of recent collisions to the next part, for the TC
/// model, in which a collision is elastic soon after another one.
#[derive(Default)]
pub struct HardIslands {
    /// Contact time t_c [s] of the TC model, in which a collision is elastic soon after another one; `None` without
    /// this model.
    pub contact_time: Option<f64>,
}

impl Solve for HardIslands {
    type Finder<'a> = TracedIslands<'a>;
    type Carried = Recent;
    type Scratch = EventLoop;

    fn indices(recent: &Recent) -> [Option<u32>; 2] {
        [Some(recent.index), None]
    }

    fn moved(recent: &Recent, index_of: &dyn Fn(u32) -> u32) -> Recent {
        Recent { index: index_of(recent.index), ..*recent }
    }

    fn energy(&self, _recent: &Recent) -> f64 {
        0.0
    }

    fn touching(&self, _recent: &Recent) -> Option<Couple> {
        None
    }

    fn solve(
        &self,
        island: &mut Island<Recent>,
        events: &mut EventLoop,
        scene: &Scene,
        window: Window,
        end: f64,
    ) -> Result<Option<usize>, GivenUp> {
        std::mem::swap(&mut events.list.pairs, &mut island.list.pairs);
        std::mem::swap(&mut events.list.walls, &mut island.list.walls);
        events.contact_time = self.contact_time;
        events.adopt(island.particles.len(), &island.carried);
        let before = (events.events, events.pair_checks);
        let (particles, log, bounds) = island.open();
        let (_, result) = events.run(particles, scene, WindowPart { window, end }, &bounds, log);
        for turned in &events.turned {
            island.turn(turned.index, turned.time, turned.origin, turned.velocity);
        }
        let particles = &mut island.particles;
        for (x, v) in particles.position.iter_mut().zip(&mut particles.velocity).take(island.hot) {
            *x += *v * end + scene.gravity * (0.5 * end * end);
            *v += scene.gravity * end;
        }
        island.carried.clear();
        island.carried.extend(events.recent(island.hot, window.start + end));
        island.events += events.events - before.0;
        island.pair_checks += events.pair_checks - before.1;
        Ok(result?)
    }
}
