//! Do particles that were placed by hand fit: inside the domain, clear of walls and of one another?

use super::Resolver;
use super::start::Placed;
use crate::case::diagnostic::Diagnostic;
use crate::domain::Domain;
use crate::experiment::Model;
use crate::scene::Scene;
use rustc_hash::FxHashMap;
use std::ops::ControlFlow;

/// [-] overlap over diameter that is rounding of a touch: positions written after a long run are that exact.
const ROUNDING: f64 = 1e-9;
/// Pairs per particle after which a start that cannot be is not looked at any further. Equal spheres that do not overlap
/// have less than 40 others in their cell and the next ones (27 cells of one diameter, filled to 0.74).
const ENOUGH: usize = 100;
/// [-] overlap over diameter up to which the soft engine starts, as within a contact.
const SOFT_LIMIT: f64 = 0.01;

impl Resolver {
    /// Checks every placed particle; positions are inside the box along periodic axes.
    pub(super) fn check_placed(&mut self, placed: &[Placed], scene: &Scene) -> Result<(), Diagnostic> {
        for particle in placed {
            self.check_inside(particle, scene)?;
        }
        let mut deepest: Option<(f64, usize, usize)> = None;
        let mut looked_at = 0;
        let _ = for_near_pairs(placed, &scene.domain, |i, j| {
            let (a, b) = (&placed[i], &placed[j]);
            let distance = scene.domain.separation(&a.position, &b.position).norm();
            let ratio = (a.radius + b.radius - distance) / (2.0 * a.radius.min(b.radius));
            looked_at += 1;
            if ratio > ROUNDING && deepest.is_none_or(|(deepest, ..)| ratio > deepest) {
                deepest = Some((ratio, i, j));
            }
            // spheres heaped up in one place are as many pairs as their square: one bad pair of them is enough
            let enough = looked_at > ENOUGH * placed.len() && deepest.is_some_and(|(deepest, ..)| deepest > 0.5);
            if enough { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        let Some((ratio, i, j)) = deepest else { return Ok(()) };
        let (a, b) = (&placed[i], &placed[j]);
        let gap = -ratio * 2.0 * a.radius.min(b.radius);
        let message = format!("{} and {} overlap: gap {gap:.3e} m, {ratio:.3e} of a diameter", a.label, b.label);
        self.refuse_overlap(b, ratio, message, "hard spheres start apart or touching")
    }

    /// Inside the domain, and clear of every wall.
    fn check_inside(&mut self, particle: &Placed, scene: &Scene) -> Result<(), Diagnostic> {
        let Placed { position, radius, label, .. } = particle;
        if !scene.domain.contains(position) {
            let size = scene.domain.size;
            let message = format!(
                "the centre of {label} is outside the domain, at ({:.6e}, {:.6e}, {:.6e}) m; allowed: 0 ..= ({:.6e}, {:.6e}, {:.6e}) m",
                position.x, position.y, position.z, size.x, size.y, size.z
            );
            return Err(self.sources.error(&particle.origin, message).help("move it, or make `domain.size` larger"));
        }
        for (index, wall) in scene.walls.iter().enumerate() {
            let distance = wall.geometry.law().nearest(position).distance;
            let ratio = (radius - distance) / (2.0 * radius);
            if ratio > ROUNDING {
                let message = format!(
                    "the centre of {label} is {distance:.6e} m from walls[{index}]; allowed: at least its radius, {radius:.6e} m"
                );
                self.refuse_overlap(particle, ratio, message, "move it away from the wall; touching is allowed")?;
            }
        }
        Ok(())
    }

    fn refuse_overlap(&mut self, at: &Placed, ratio: f64, message: String, help: &str) -> Result<(), Diagnostic> {
        if self.model == Model::Soft && ratio <= SOFT_LIMIT {
            self.warn(&at.origin, message, "the soft model starts within a contact: its spring holds energy");
            return Ok(());
        }
        let help = match self.model {
            Model::Soft => format!("{help}; the soft model starts with overlaps up to {SOFT_LIMIT} of a diameter"),
            Model::Hard => help.to_string(),
        };
        Err(self.sources.error(&at.origin, message).help(help))
    }
}

/// Calls `visit` once for every pair whose centres may be within one largest diameter, through a grid of such cells, until
/// it breaks off.
fn for_near_pairs(
    placed: &[Placed],
    domain: &Domain,
    mut visit: impl FnMut(usize, usize) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let largest = placed.iter().map(|particle| 2.0 * particle.radius).fold(0.0, f64::max);
    if largest <= 0.0 {
        return ControlFlow::Continue(());
    }
    // at least one diameter per cell; more cells than that would not help
    let cells: [i64; 3] = std::array::from_fn(|axis| ((domain.size[axis] / largest).floor() as i64).clamp(1, 4096));
    let cell = |particle: &Placed| -> [i64; 3] {
        std::array::from_fn(|axis| {
            let index = (particle.position[axis] / domain.size[axis] * cells[axis] as f64).floor() as i64;
            index.clamp(0, cells[axis] - 1)
        })
    };
    let mut grid: FxHashMap<[i64; 3], Vec<usize>> = FxHashMap::default();
    for (i, particle) in placed.iter().enumerate() {
        let home = cell(particle);
        let mut near: Vec<[i64; 3]> = Vec::with_capacity(27);
        for shift in 0..27 {
            let shift = [shift % 3 - 1, shift / 3 % 3 - 1, shift / 9 - 1];
            near.push(std::array::from_fn(|axis| {
                let index = home[axis] + shift[axis];
                if domain.periodic[axis] { index.rem_euclid(cells[axis]) } else { index }
            }));
        }
        // with fewer than three cells along a periodic axis, two shifts lead to the same cell
        near.sort_unstable();
        near.dedup();
        for key in near {
            for &j in grid.get(&key).into_iter().flatten() {
                visit(j, i)?;
            }
        }
        grid.entry(home).or_default().push(i);
    }
    ControlFlow::Continue(())
}
