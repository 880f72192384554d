//! Budgets of the second moments of the velocities: the processes that create and remove the agitation of the
//! particles.
//!
//! The particles of a slice along y have the second moments R_ij = <v_i″ v_j″>, where ″ is the deviation from their
//! mean velocity U. In a steady flow that depends on y alone, every moment is constant. With n particles in the slice
//! and the wall-normal velocity v:
//!
//! ```text
//! 0 = - <v_i″v″> dU_j/dy - <v_j″v″> dU_i/dy      production by the gradient of the mean velocity
//!     - (1/n) d(n <v_i″v_j″v″>)/dy                transport by the fluctuations
//!     + <a_i″v_j″> + <a_j″v_i″>                   drag, a the acceleration by drag
//!     + impacts                                   between particles and on walls
//! ```
//!
//! All four terms are measured independently. The change by impacts is the change of the velocities in a window, minus
//! drag and gravity, so that the method is valid for any collision model. A window is the time between two exchanges of
//! momentum with the gas. The remainder of the budget is due to chance and to the width of the slices. The impact term
//! includes the momentum that impacts carry over the distance between two centres.

use super::Observer;
use crate::exact::Groups;
use crate::fluid::{Fluid, LocalFractions};
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::{Estimate, estimate};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Names of the four second moments, each with the indices of its two components in (u, v, w) = (streamwise,
/// wall-normal, spanwise).
pub const MOMENTS: [(&str, usize, usize); 4] = [("uu", 0, 0), ("vv", 1, 1), ("ww", 2, 2), ("uv", 0, 1)];
/// Number of equal parts of a run. The sums of each part are stored separately, so that the averaging period can begin
/// at the start of any part.
const PARTS: u64 = 200;
/// Largest number of blocks (pieces of the averaged time) from whose scatter the standard errors of the budgets are
/// computed. A budget is the list of the rates at which single processes, such as drag, change a second moment of the
/// velocities.
const BLOCKS: usize = 20;

/// Rates of change [m²/s³] of one second moment of the velocities by each physical process.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Terms<T> {
    /// [m²/s³] production of the moment by the gradient of the mean velocity along y.
    pub production: T,
    /// [m²/s³] transport of the moment from other slices along y by velocity fluctuations.
    pub transport: T,
    /// [m²/s³] rate of change of the moment by the drag of the gas.
    pub drag: T,
    /// [m²/s³] rate of change of the moment by impacts between particles and on walls.
    pub impacts: T,
    /// [m²/s³] sum of production, transport, drag and impacts. In a steady flow it is zero except for chance and the
    /// finite width of the slices.
    pub rest: T,
}

impl Terms<f64> {
    fn to_array(self) -> [f64; 5] {
        [self.production, self.transport, self.drag, self.impacts, self.rest]
    }
}

impl<T> From<[T; 5]> for Terms<T> {
    fn from([production, transport, drag, impacts, rest]: [T; 5]) -> Self {
        Self { production, transport, drag, impacts, rest }
    }
}

/// Budgets of the four second moments of a run: the rates at which single processes, such as drag, change each moment.
/// Arrays of four are in the order of [`MOMENTS`].
#[derive(Clone, Debug, Serialize)]
pub struct Budgets {
    /// Centre y [m] of each slice, and the rates of change of the four moments in this slice by each process.
    pub slices: Vec<(f64, [Terms<Estimate>; 4])>,
    /// Rates of change of the four moments by each process, averaged over all particles.
    pub whole: [Terms<Estimate>; 4],
    /// [m²/s³] rate of change of the sum of the moments uu + ww by friction at walls, averaged over all particles. It
    /// is contained in the impact terms of uu and ww.
    pub wall_friction: Estimate,
    /// [m²/s³] rate of change of the moment vv by the restitution of walls, averaged over all particles. It is
    /// contained in the impact term of vv.
    pub wall_restitution: Estimate,
    /// [s] simulated time at which the averaging period begins.
    pub from: f64,
}

/// Sums over the particles of a slice and over several windows (times between two exchanges with the gas). Velocities
/// (u, v, w) are relative to the `reference` of [`SecondMoments`].
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct MomentSums {
    count: f64,
    velocity: Vector3<f64>,
    /// [m²/s²] sums of the products v_i v_j of velocity components; i is the row.
    square: [[f64; 3]; 3],
    /// [m³/s³] sums of v_i v_j v for the four moments in [`MOMENTS`], with the wall-normal velocity v.
    carried: [f64; 4],
    acceleration: Vector3<f64>,
    /// [m²/s³] sums of a_i v_j + a_j v_i for the four moments in [`MOMENTS`], with the acceleration a by drag.
    drag: [f64; 4],
    jump: Vector3<f64>,
    /// [m²/s²] sums of the changes of v_i v_j by impacts, for the four moments in [`MOMENTS`].
    jumps: [f64; 4],
}

/// Length of the array that holds the sums of a slice. The last entry is unused and makes the length a multiple of
/// four.
const TERMS: usize = 32;

impl From<[f64; TERMS]> for MomentSums {
    /// Makes the sums from an array in the order of the function `row`.
    fn from(all: [f64; TERMS]) -> Self {
        let vector = |first: usize| Vector3::new(all[first], all[first + 1], all[first + 2]);
        let four = |first: usize| std::array::from_fn(|k| all[first + k]);
        Self {
            count: all[0],
            velocity: vector(1),
            acceleration: vector(4),
            jump: vector(7),
            square: std::array::from_fn(|i| std::array::from_fn(|j| all[10 + 3 * i + j])),
            carried: four(19),
            drag: four(23),
            jumps: four(27),
        }
    }
}

/// Contribution of one particle to the sums at the end of a window (time between two exchanges with the gas). Arguments
/// are the velocity [m/s] of the particle at this time, its acceleration by drag [m/s²], and its velocities [m/s]
/// before and after the impacts of the window. The velocity before the impacts already contains the change by gravity
/// in the window.
fn row([velocity, acceleration, before, after]: [&Vector3<f64>; 4]) -> [f64; TERMS] {
    let mut row = [1.0; TERMS];
    row[1..4].copy_from_slice(velocity.as_slice());
    row[4..7].copy_from_slice(acceleration.as_slice());
    row[7..10].copy_from_slice((after - before).as_slice());
    for i in 0..3 {
        (0..3).for_each(|j| row[10 + 3 * i + j] = velocity[i] * velocity[j]);
    }
    for (k, (_, i, j)) in MOMENTS.into_iter().enumerate() {
        row[19 + k] = velocity[i] * velocity[j] * velocity[1];
        row[23 + k] = acceleration[i] * velocity[j] + acceleration[j] * velocity[i];
        row[27 + k] = after[i] * after[j] - before[i] * before[j];
    }
    row
}

impl MomentSums {
    fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.velocity += other.velocity;
        self.acceleration += other.acceleration;
        self.jump += other.jump;
        for i in 0..3 {
            (0..3).for_each(|j| self.square[i][j] += other.square[i][j]);
        }
        for k in 0..4 {
            self.carried[k] += other.carried[k];
            self.drag[k] += other.drag[k];
            self.jumps[k] += other.jumps[k];
        }
    }

    fn mean(&self) -> Vector3<f64> {
        self.velocity / self.count
    }

    /// Second moment <v_i″ v_j″> [m²/s²] of the components i and j, with ″ the fluctuation about the mean of the slice.
    fn second(&self, i: usize, j: usize) -> f64 {
        let mean = self.mean();
        self.square[i][j] / self.count - mean[i] * mean[j]
    }

    /// Third moment <v_i″ v_j″ v″> [m³/s³] of velocity fluctuations, with the wall-normal fluctuation v″. i and j are
    /// the components of the moment with the index `moment`.
    fn third(&self, moment: usize) -> f64 {
        let (_, i, j) = MOMENTS[moment];
        let (m, raw) = (self.mean(), |a: usize, b: usize| self.square[a][b] / self.count);
        self.carried[moment] / self.count - m[i] * raw(j, 1) - m[j] * raw(i, 1) - m[1] * raw(i, j)
            + 2.0 * m[i] * m[j] * m[1]
    }

    /// Change of the moment <v_i″ v_j″> with the index `moment` by one process, per particle. `products` is the sum
    /// over the particles of the changes of v_i v_j by this process, and `single` that of the changes of the velocity
    /// vector. The part that comes from a change of the mean velocity is subtracted.
    fn about(&self, moment: usize, products: f64, single: &Vector3<f64>) -> f64 {
        let (_, i, j) = MOMENTS[moment];
        let mean = self.mean();
        (products - mean[i] * single[j] - mean[j] * single[i]) / self.count
    }
}

/// Sums over the particles of each slice in one of the equal parts into which a run is divided.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct MomentBlock {
    /// [s] simulated time at which this part of the run begins.
    start: f64,
    windows: u64,
    slices: Vec<MomentSums>,
    /// Energy lost to friction at walls [J], energy lost to restitution at walls [J], and streamwise momentum given by
    /// walls to the particles [kg m/s], in this part of the run.
    walls: [f64; 3],
}

/// Observer that sums the terms of the budgets: the rates at which single processes change the second moments of the
/// velocities. It is called at the end of every window, the time between two exchanges with the gas.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SecondMoments {
    slices: usize,
    schedule: Schedule,
    mass: f64,
    height: f64,
    /// [m/s] velocity (u, v, w) that is subtracted from all velocities: the mean velocity of the particles at the
    /// first call of the observer.
    reference: Vector3<f64>,
    /// [m/s] velocities (u, v, w) of the particles, relative to `reference`, at the start of the next window (time
    /// between two exchanges with the gas). They are indexed by the ids of the particles.
    given: Vec<Vector3<f64>>,
    walls: [f64; 3],
    parts: Vec<MomentBlock>,
}

/// Components (u, v, w) (streamwise, wall-normal, spanwise) of a vector with the components x, y, z.
fn components(vector: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(vector.z, vector.y, vector.x)
}

/// [m/s²] acceleration of a sphere by the drag of the mean gas flow, at the position `place` [m] and the velocity
/// `velocity` [m/s].
fn drag(fluid: &Fluid, sphere: &crate::drag::Sphere, place: &Vector3<f64>, velocity: &Vector3<f64>) -> Vector3<f64> {
    let Some(law) = &fluid.drag else { return Vector3::zeros() };
    let slip = Vector3::new(0.0, 0.0, fluid.profile.velocity_at(place)) - velocity;
    slip / law.law().response_time(sphere, slip.norm())
}

impl SecondMoments {
    /// Creates an observer with the given number of slices along y (at least one), before the start of a run.
    pub fn new(slices: usize, schedule: &Schedule) -> Self {
        Self {
            slices: slices.max(1),
            schedule: *schedule,
            mass: 0.0,
            height: 0.0,
            reference: Vector3::zeros(),
            given: Vec::new(),
            walls: [0.0; 3],
            parts: Vec::new(),
        }
    }

    /// Budgets (rates at which single processes change the second moments), averaged over those of the equal parts of
    /// the run that begin at `from` [s] or later. `None` if there are no such parts, or if a slice contained no
    /// particle.
    pub fn budgets(&self, from: f64) -> Option<Budgets> {
        let used: Vec<&MomentBlock> = self.parts.iter().filter(|part| part.start >= from * (1.0 - 1e-9)).collect();
        let from = used.first()?.start;
        let size = used.len().div_ceil(BLOCKS);
        let whole = self.terms(&used)?;
        let blocks: Vec<Derived> = used.chunks(size).filter_map(|parts| self.terms(parts)).collect();
        let of = |pick: &dyn Fn(&Derived) -> f64| Estimate {
            value: pick(&whole),
            error: estimate(&blocks.iter().map(pick).collect::<Vec<f64>>()).and_then(|estimate| estimate.error),
        };
        let terms = |pick: &dyn Fn(&Derived) -> Terms<f64>| {
            Terms::from(std::array::from_fn(|term| of(&|derived| pick(derived).to_array()[term])))
        };
        let rows = (0..self.slices).map(|slice| {
            let y = (slice as f64 + 0.5) * self.height / self.slices as f64;
            (y, std::array::from_fn(|k| terms(&|derived| derived.slices[slice][k])))
        });
        Some(Budgets {
            slices: rows.collect(),
            whole: std::array::from_fn(|k| terms(&|derived| derived.whole[k])),
            wall_friction: of(&|derived| derived.friction),
            wall_restitution: of(&|derived| derived.restitution),
            from,
        })
    }

    /// Computes the budgets (rates at which single processes change the second moments) from the sums of several parts
    /// of the run; `None` if a slice contained no particle.
    fn terms(&self, parts: &[&MomentBlock]) -> Option<Derived> {
        let mut sums = vec![MomentSums::default(); self.slices];
        let (mut windows, mut walls) = (0, [0.0; 3]);
        for part in parts {
            sums.iter_mut().zip(&part.slices).for_each(|(sum, more)| sum.merge(more));
            walls.iter_mut().zip(part.walls).for_each(|(sum, more)| *sum += more);
            windows += part.windows;
        }
        if sums.iter().any(|sum| sum.count == 0.0) {
            return None;
        }
        let width = self.height / self.slices as f64;
        let slices: Vec<[Terms<f64>; 4]> = (0..self.slices).map(|slice| self.slice(&sums, slice, width)).collect();
        let total: f64 = sums.iter().map(|sum| sum.count).sum();
        let whole = std::array::from_fn(|k| {
            let term = |t: usize| {
                sums.iter().zip(&slices).map(|(sum, terms)| sum.count * terms[k].to_array()[t]).sum::<f64>() / total
            };
            Terms::from(std::array::from_fn(term))
        });
        let time = windows as f64 * self.schedule.window;
        let [friction, restitution, impulse] = walls;
        // friction at walls acts on particles that move at the mean velocity of the two slices at the walls
        let ends = 0.5 * (sums[0].mean().x + sums[self.slices - 1].mean().x) + self.reference.x;
        let per = 2.0 / (self.mass * time);
        Some(Derived { slices, whole, friction: -per * (friction + ends * impulse), restitution: -per * restitution })
    }

    fn slice(&self, sums: &[MomentSums], slice: usize, width: f64) -> [Terms<f64>; 4] {
        let here = &sums[slice];
        let gradient = gradient(sums, slice) / width;
        std::array::from_fn(|k| {
            let (_, i, j) = MOMENTS[k];
            let production = -here.second(i, 1) * gradient[j] - here.second(j, 1) * gradient[i];
            // the face at a wall has no transport, because no particle crosses the wall
            let face = |below: usize| {
                let carried = |sum: &MomentSums| sum.count * sum.third(k);
                0.5 * (carried(&sums[below]) + carried(&sums[below + 1]))
            };
            let top = if slice + 1 < self.slices { face(slice) } else { 0.0 };
            let bottom = if slice > 0 { face(slice - 1) } else { 0.0 };
            let transport = (bottom - top) / (here.count * width);
            let drag = here.about(k, here.drag[k], &here.acceleration);
            let impacts = here.about(k, here.jumps[k], &here.jump) / self.schedule.window;
            Terms { production, transport, drag, impacts, rest: production + transport + drag + impacts }
        })
    }

    /// Sums of the part of the run in which a window (time between two exchanges with the gas) ends at `time` [s]. A
    /// new part begins if the latest part is complete.
    fn part(&mut self, time: f64) -> &mut MomentBlock {
        let length = (self.schedule.length() as f64 / PARTS as f64).max(1.0) * self.schedule.window;
        let begins = |part: &MomentBlock| time - part.start > length * (1.0 + 1e-9);
        if self.parts.last().is_none_or(begins) {
            let start = time - self.schedule.window;
            let slices = vec![MomentSums::default(); self.slices];
            self.parts.push(MomentBlock { start, windows: 0, slices, walls: [0.0; 3] });
        }
        let last = self.parts.len() - 1;
        &mut self.parts[last]
    }
}

/// Budgets computed from the sums of some parts of the run: the rates [m²/s³] at which single processes change the
/// second moments.
struct Derived {
    slices: Vec<[Terms<f64>; 4]>,
    whole: [Terms<f64>; 4],
    friction: f64,
    restitution: f64,
}

/// Difference of the mean velocity [m/s] along y over the thickness of a slice: the gradient times this thickness. It
/// is a central difference, and a one-sided difference of second order at the walls; 0 for fewer than three slices.
fn gradient(sums: &[MomentSums], slice: usize) -> Vector3<f64> {
    let (last, mean) = (sums.len() - 1, |k: usize| sums[k].mean());
    match slice {
        _ if last < 2 => Vector3::zeros(),
        0 => -1.5 * mean(0) + 2.0 * mean(1) - 0.5 * mean(2),
        k if k == last => 1.5 * mean(k) - 2.0 * mean(k - 1) + 0.5 * mean(k - 2),
        k => 0.5 * (mean(k + 1) - mean(k - 1)),
    }
}

impl Observer for SecondMoments {
    fn next(&self, now: f64, schedule: &Schedule) -> Option<f64> {
        Some(now + schedule.window)
    }

    fn see(&mut self, simulation: &Simulation) {
        let (particles, scene) = (&simulation.particles, simulation.scene());
        let first = self.given.is_empty();
        if first {
            self.mass = particles.total_mass();
            self.height = scene.domain.size.y;
            self.reference = components(&(particles.momentum() / self.mass));
            self.given = vec![Vector3::zeros(); particles.len()];
        }
        let half = 0.5 * self.schedule.window;
        let fall = |species| components(&scene.gravity_of(species)) * self.schedule.window;
        let falls: Vec<_> = scene.species.iter().map(fall).collect();
        let spheres: Vec<_> = match &scene.fluid {
            Some(fluid) => scene.species.iter().map(|species| fluid.sphere(species)).collect(),
            None => Vec::new(),
        };
        let cells = scene.fluid.as_ref().and_then(|fluid| fluid.drag.as_ref()?.law().cells());
        let fractions = cells.map(|cells| LocalFractions::of(particles, &scene.domain, cells, None));
        let ledger = &simulation.record.ledger;
        let walls = [ledger.wall_friction_loss, ledger.wall_restitution_loss, ledger.wall_impulse.z];
        let (count, height, reference) = (self.slices, self.height, self.reference);
        let mut given = std::mem::take(&mut self.given);
        let mut slices = Groups::new(count);
        for (place, velocity) in particles.velocity.iter().enumerate() {
            let y = particles.position[place].y;
            let species = usize::from(particles.species[place]);
            let size = 2.0 * particles.radius[place] / scene.species[species].diameter;
            let fraction =
                |fractions: &LocalFractions| fractions.at(&particles.position[place], particles.radius[place]);
            let fraction = fractions.as_ref().map_or(0.0, fraction);
            let sphere = |own: &crate::drag::Sphere| match scene.species[species].sizes {
                Some(_) => own.scaled(size).among(fraction),
                None => own.among(fraction),
            };
            let push = scene
                .fluid
                .as_ref()
                .map(|fluid| drag(fluid, &sphere(&spheres[species]), &particles.position[place], velocity));
            let push = components(&push.unwrap_or_default());
            let velocity = components(velocity) - reference;
            // The drag of half a window is added for the velocity at the start of the next window, and subtracted for
            // the velocity after the impacts of this window. The error is of the order of the splitting error of the
            // time step
            let before =
                std::mem::replace(&mut given[particles.id[place] as usize], velocity + push * half) + falls[species];
            let slice = ((y / height * count as f64) as usize).min(count - 1);
            slices.add(slice, row([&velocity, &push, &before, &(velocity - push * half)]));
        }
        let slices = slices.values();
        self.given = given;
        let since: [f64; 3] = std::array::from_fn(|k| walls[k] - self.walls[k]);
        self.walls = walls;
        if first {
            return;
        }
        let part = self.part(simulation.time);
        part.windows += 1;
        part.slices.iter_mut().zip(slices).for_each(|(sum, more)| sum.merge(&more.into()));
        part.walls.iter_mut().zip(since).for_each(|(sum, more)| *sum += more);
    }
}
