//! Checks that placed particles are inside the domain and do not overlap walls or one another.

use super::Resolver;
use super::start::Placed;
use crate::case::diagnostic::Diagnostic;
use crate::domain::Domain;
use crate::engine::soft::overlap_limit;
use crate::experiment::Model;
use crate::scene::Scene;
use crate::walls::{NearWalls, Repeated};
use nalgebra::Vector3;
use rustc_hash::FxHashMap;
use std::ops::ControlFlow;

/// [-] largest overlap, divided by the smaller diameter, that counts as the rounding error of two touching bodies.
/// Positions written after a long run have this accuracy.
const ROUNDING: f64 = 1e-9;
/// Number of close pairs per particle after which the search for overlaps ends, if it has found an overlap of more
/// than half a diameter. Close particles are in one cell or in neighbouring cells, which are about one diameter wide.
/// Equal spheres without overlap fill at most 0.74 of these 27 cells. Each sphere then has fewer than 40 others in
/// these cells, so more pairs come from overlaps.
const ENOUGH: usize = 100;
/// [-] largest overlap, divided by the smaller diameter, with which the soft engine starts from positions given by the
/// user. The particles then start within a contact.
const SOFT_LIMIT: f64 = 0.01;

/// Rule by which overlaps in the initial state are accepted or refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Rule {
    /// The default rule: hard spheres may not overlap, while soft spheres may start in a contact.
    Events,
    /// Hard spheres of a saved state may overlap, because the stepped engine finds overlaps at the ends of steps.
    Steps,
    /// Overlapping particles are moved apart before the start, in any model.
    PushedApart,
}

/// Overlap of a placed particle with another particle or a wall, in the initial state.
struct InitialOverlap {
    i: usize,
    with: OverlappedBody,
    /// [-] overlap, divided by the smaller diameter of the two bodies, or at a wall by the diameter of the particle.
    ratio: f64,
    /// [-] largest value of `ratio` with which the model can start.
    limit: f64,
}

/// Body with which a placed particle overlaps.
enum OverlappedBody {
    /// Index of the other placed particle.
    Particle(usize),
    /// Index of the wall, and the distance [m] from the centre of the particle to the nearest point of the wall.
    Wall(usize, f64),
}

impl Resolver {
    /// Checks every placed particle, and returns the number of overlaps beyond rounding. Positions must be inside the
    /// box along periodic axes.
    pub(super) fn check_placed(&mut self, placed: &[Placed], scene: &Scene, rule: Rule) -> Result<usize, Diagnostic> {
        let mut worst: Option<InitialOverlap> = None;
        let mut count = 0;
        let mut found = |overlap: InitialOverlap| {
            if overlap.ratio > ROUNDING {
                count += 1;
                let rank = |overlap: &InitialOverlap| (overlap.ratio > overlap.limit, overlap.ratio);
                if worst.as_ref().is_none_or(|worst| rank(&overlap) > rank(worst)) {
                    worst = Some(overlap);
                }
            }
        };
        let walls = Repeated::all(&scene.walls, &scene.domain);
        let near_walls = NearWalls::of(&walls);
        for (i, particle) in placed.iter().enumerate() {
            self.check_inside(particle, scene)?;
            near_walls.for_each_nearest(&walls, &particle.position, particle.radius, |wall, nearest| {
                let (index, distance) = (wall as usize, nearest.distance);
                let ratio = (particle.radius - distance) / (2.0 * particle.radius);
                let limit = self.deepest([particle; 2], rule, walls[index].geometry.is_flat());
                found(InitialOverlap { i, with: OverlappedBody::Wall(index, distance), ratio, limit });
            });
        }
        let (mut looked_at, mut deepest) = (0, 0.0f64);
        // the model dsmc lets pairs collide by chance, and they may overlap: only overlaps with walls are checked
        let paired = if self.model == Model::Dsmc && rule != Rule::PushedApart { &[] } else { placed };
        let _ = for_near_pairs(paired, &scene.domain, |j, i| {
            let (a, b) = (&placed[i], &placed[j]);
            let distance = scene.domain.separation(&a.position, &b.position).norm();
            let ratio = (a.radius + b.radius - distance) / (2.0 * a.radius.min(b.radius));
            let limit = self.deepest([a, b], rule, false);
            found(InitialOverlap { i, with: OverlappedBody::Particle(j), ratio, limit });
            looked_at += 1;
            deepest = deepest.max(ratio);
            // n spheres at one position make about n² pairs, so the check ends after many pairs if a large overlap has
            // been found
            let enough = looked_at > ENOUGH * placed.len() && deepest > 0.5;
            if enough { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        if let Some(worst) = worst {
            self.judge_overlap(&worst, (count, rule), placed)?;
        }
        Ok(count)
    }

    /// Checks that the centre of a particle is inside the domain.
    fn check_inside(&self, particle: &Placed, scene: &Scene) -> Result<(), Diagnostic> {
        let Placed { position, label, .. } = particle;
        if scene.domain.contains(position) {
            return Ok(());
        }
        let size = scene.domain.size;
        let message = format!(
            "the centre of {label} is outside the domain, at ({:.6e}, {:.6e}, {:.6e}) m; allowed: 0 ..= ({:.6e}, {:.6e}, {:.6e}) m",
            position.x, position.y, position.z, size.x, size.y, size.z
        );
        Err(self.sources.error(&particle.origin, message).help("move it, or make `domain.size` larger"))
    }

    /// [-] largest overlap, divided by the smaller diameter, with which the model can start. `of` contains two
    /// particles, or one particle twice if it touches a wall; `flat` is true for a flat wall. Soft and hybrid spheres
    /// from a saved state or a file of another program may overlap as during a run, those placed by the user at most
    /// by `SOFT_LIMIT`. Hard spheres and spheres that collide by chance may overlap only in a saved state.
    /// Event-driven hard spheres may not overlap at all, unless they are moved apart before the start.
    fn deepest(&self, of: [&Placed; 2], rule: Rule, flat: bool) -> f64 {
        let saved = of.iter().all(|placed| placed.saved);
        let settled = of.iter().all(|placed| placed.saved || placed.foreign);
        match self.model {
            _ if rule == Rule::PushedApart => overlap_limit(false),
            Model::Hard if rule == Rule::Events => 0.0,
            Model::Hard | Model::Dsmc if saved => overlap_limit(flat),
            Model::Hard | Model::Dsmc => 0.0,
            Model::Soft | Model::Hybrid if saved => overlap_limit(flat),
            Model::Soft | Model::Hybrid if settled => overlap_limit(false),
            Model::Soft | Model::Hybrid => SOFT_LIMIT,
        }
    }

    /// Refuses the start because of its largest overlap, or only warns if the model can start with it. `count` is the
    /// number of overlaps.
    fn judge_overlap(
        &mut self,
        worst: &InitialOverlap,
        (count, rule): (usize, Rule),
        placed: &[Placed],
    ) -> Result<(), Diagnostic> {
        let at = &placed[worst.i];
        let ratio = worst.ratio;
        let (mut message, help) = match worst.with {
            OverlappedBody::Particle(j) => {
                let other = &placed[j];
                let gap = -ratio * 2.0 * at.radius.min(other.radius);
                let unequal = at.radius != other.radius;
                let diameter = if unequal { "the smaller diameter" } else { "a diameter" };
                let (a, b) = (&other.label, &at.label);
                let message = format!("{a} and {b} overlap: gap {gap:.3e} m, {ratio:.3e} of {diameter}");
                (message, "hard spheres start apart or touching")
            }
            OverlappedBody::Wall(index, distance) => {
                let message = format!(
                    "the centre of {} is {distance:.6e} m from walls[{index}]; allowed: at least its radius, {:.6e} m",
                    at.label, at.radius
                );
                (message, "move it away from the wall; touching is allowed")
            }
        };
        if count > 1 {
            message += &format!("; the worst of {count} overlaps");
        }
        if ratio <= worst.limit {
            let help = match self.model {
                _ if rule == Rule::PushedApart => "they are pushed apart before the start",
                Model::Soft | Model::Hybrid => "the soft model starts within a contact: its spring holds energy",
                Model::Hard | Model::Dsmc => "the model starts with overlaps that a run has left",
            };
            self.warn(&at.origin, message, help);
            return Ok(());
        }
        let deepest = overlap_limit(false);
        let relax = if ratio <= deepest { "; `--relax` pushes such particles apart" } else { "" };
        let help = match self.model {
            Model::Soft | Model::Hybrid => format!(
                "{help}; the soft model starts with overlaps up to {SOFT_LIMIT} of a diameter, and up to {deepest} from the state that a run has \
                 saved and from XYZ and LAMMPS files{relax}"
            ),
            Model::Hard | Model::Dsmc if at.saved => {
                format!("{help}; run this state with the model that has saved it{relax}")
            }
            Model::Hard | Model::Dsmc => format!("{help}{relax}"),
        };
        Err(self.sources.error(&at.origin, message).help(help))
    }
}

/// Calls `visit` once for every pair whose centres may be within one largest diameter. A grid of cells of at least this
/// size yields the pairs. The loop ends early if `visit` returns `Break`.
fn for_near_pairs(
    placed: &[Placed],
    domain: &Domain,
    mut visit: impl FnMut(usize, usize) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let largest = placed.iter().map(|particle| 2.0 * particle.radius).fold(0.0, f64::max);
    if largest <= 0.0 {
        return ControlFlow::Continue(());
    }
    // a cell is at least one largest diameter wide; more than 4096 cells per axis would not help
    let cells: [i64; 3] = std::array::from_fn(|axis| ((domain.size[axis] / largest).floor() as i64).clamp(1, 4096));
    let cell = |position: &Vector3<f64>| -> [i64; 3] {
        std::array::from_fn(|axis| (position[axis] / domain.size[axis] * cells[axis] as f64).floor() as i64)
    };
    let joined = domain.joined();
    let mut grid: FxHashMap<[i64; 3], Vec<usize>> = FxHashMap::default();
    for (i, particle) in placed.iter().enumerate() {
        let mut near: Vec<[i64; 3]> = Vec::with_capacity(27);
        // images across sheared sides are displaced along z, so they have other neighbours than the particle
        domain.for_each_image(&particle.position, largest, |image| {
            let home = cell(&image);
            for shift in 0..27 {
                let shift = [shift % 3 - 1, shift / 3 % 3 - 1, shift / 9 - 1];
                near.push(std::array::from_fn(|axis| {
                    let index = home[axis] + shift[axis];
                    if joined[axis] { index.rem_euclid(cells[axis]) } else { index }
                }));
            }
        });
        // with fewer than three cells along a periodic axis, two shifts lead to the same cell
        near.sort_unstable();
        near.dedup();
        for key in near {
            for &j in grid.get(&key).into_iter().flatten() {
                visit(j, i)?;
            }
        }
        let home = cell(&particle.position);
        let inside = std::array::from_fn(|axis| home[axis].clamp(0, cells[axis] - 1));
        grid.entry(inside).or_default().push(i);
    }
    ControlFlow::Continue(())
}
