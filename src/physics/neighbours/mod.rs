//! Neighbour lists: pairs of particles, and of particles and walls, that may touch soon.
//!
//! A [`NeighbourList`] contains all pairs of particles, and of particles and walls, whose gap is below a length called
//! skin. The list is complete until a particle has moved by half the skin relative to a common frame of reference.
//! After each step, the engine tells the list how far particles may have moved. The list then shows whether it must be
//! rebuilt.

mod across;
pub mod cells;
mod lanes;
pub mod levels;
pub mod packed;
pub mod plan;
pub mod region;
mod sieve;

use crate::clock::Clock;
use crate::encounter::{AtWall, Couple, Other};
use crate::particles::{CHUNK, Particles};
use crate::scene::Scene;
use crate::walls::NearWalls;
use crate::work_sharing;
use levels::{SizeLevels, SortedSizes};
use nalgebra::Vector3;
use packed::PackedBalls;
use plan::ListSettings;
use region::Region;
use serde::{Deserialize, Serialize};
use sieve::Sieve;
use std::ops::Range;
use std::time::Duration;

/// Number of rows of cells that one thread searches as one piece of work.
const ROWS: usize = 64;

/// Two particles that may touch, by their indices in the particle store.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    /// Index of the first particle in the particle store.
    pub i: u32,
    /// Index of the second particle in the particle store.
    pub j: u32,
}

impl Pair {
    /// [m] distance between the centres of the two particles at touch.
    #[inline(always)]
    pub fn reach(&self, particles: &Particles) -> f64 {
        particles.radius[self.i as usize] + particles.radius[self.j as usize]
    }

    /// True if the distance between the two centres is now below `reach` [m].
    #[inline(always)]
    fn is_within(&self, reach: f64, particles: &Particles, scene: &Scene) -> bool {
        let (a, b) = (&particles.position[self.i as usize], &particles.position[self.j as usize]);
        scene.domain.separation(a, b).norm_squared() < reach * reach
    }
}

/// A particle and a wall that may touch soon.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NearWall {
    /// Index of the particle in the particle store.
    pub particle: u32,
    /// Wall, and number of the contact that the particle may have with this wall.
    pub at: AtWall,
}

impl NearWall {
    /// [m] present gap between particle and wall. Some shapes of walls are searched only near the particle. If such a
    /// wall is farther away, the value is positive, but smaller than the gap.
    #[inline]
    pub fn gap(&self, particles: &Particles, scene: &Scene) -> f64 {
        let index = self.particle as usize;
        let (x, radius) = (&particles.position[index], particles.radius[index]);
        scene.walls[self.at.wall as usize].contact(self.at.which, x, radius, 0.0).distance - radius
    }
}

/// Neighbour list: candidates for contacts, which are pairs of particles, or particles with walls. A *slot* is the
/// number of a candidate. The pairs of particles have the first numbers, and the particles with walls the following
/// ones.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct NeighbourList {
    /// Pairs whose gap was below the skin (a length) when the list was built, grouped by the first particle `i`.
    pub pairs: Vec<Pair>,
    /// Particles and walls whose gap was below the skin (a length) when the list was built, sorted by wall.
    pub walls: Vec<NearWall>,
    /// Clock that measures the time spent on building lists.
    #[serde(skip)]
    pub clock: Clock,
    /// Ranges of `pairs` by first particle: the pairs of particle `i` are `pairs[first_pair[i] .. first_pair[i + 1]]`.
    first_pair: Vec<u32>,
    /// [m] distance between the centres of two particles that touch, if this distance is equal for all pairs;
    /// otherwise `None`. With a common distance, the code need not read radii.
    common_reach: Option<f64>,
    skin: f64,
    /// [-] number of times that the list can be used before it must be rebuilt, at the speeds that particles had when
    /// the list was built.
    uses: f64,
    travelled: f64,
    frame: Vector3<f64>,
    builds: u64,
    building: Duration,
}

impl NeighbourList {
    /// [m/s] velocity of the frame relative to which the list measures how far particles move. It is the mean velocity
    /// of the particles (in a sheared box, relative to the mean flow), without its components that change a gap to a
    /// wall.
    pub fn frame(&self) -> Vector3<f64> {
        self.frame
    }

    /// [m] skin: gap between two bodies up to which they are listed.
    pub fn skin(&self) -> f64 {
        self.skin
    }

    /// [m] upper limit of the distance that any particle has moved, relative to the frame, since the list was built.
    pub fn travelled(&self) -> f64 {
        self.travelled
    }

    /// [m] skin s of an inner list, which contains only pairs with gaps below s; `None` if an inner list would save no
    /// time. The inner list contains the fraction s/skin of all pairs, and can be used n·s/skin times, where n (the
    /// field `uses`) is the number of uses of the whole list. During these uses all pairs are tested once, and those of
    /// the inner list at every use. The cost is lowest for s = skin/√n.
    pub fn inner_skin(&self) -> Option<f64> {
        // for fewer uses there is no gain; at most 400 are assumed, because speeds may increase
        (self.uses >= 8.0).then(|| self.skin / self.uses.min(400.0).sqrt())
    }

    /// Number of times that the list has been built.
    pub fn builds(&self) -> u64 {
        self.builds
    }

    /// Wall-clock time spent on building the list so far.
    pub fn building(&self) -> Duration {
        self.building
    }

    /// Number of candidates for contacts in the list: pairs of particles, and particles with walls.
    pub fn slots(&self) -> usize {
        self.pairs.len() + self.walls.len()
    }

    /// True if the list stays complete while every particle moves by up to `distance` [m] relative to the frame of the
    /// list.
    pub fn allows(&self, distance: f64) -> bool {
        self.builds > 0 && 2.0 * (self.travelled + distance) <= self.skin
    }

    /// [m] distance that every particle may still move relative to the frame of the list while the list stays complete.
    pub fn room(&self) -> f64 {
        if self.builds > 0 { 0.5 * self.skin - self.travelled } else { 0.0 }
    }

    /// Marks the list as outdated, after other code has moved or reordered particles. The list must be rebuilt before
    /// its next use.
    pub fn invalidate(&mut self) {
        self.travelled = f64::INFINITY;
    }

    /// Adds `distance` [m] to the distance that particles may have moved relative to the frame of the list.
    pub fn travel(&mut self, distance: f64) {
        self.travelled += distance;
    }

    /// Builds the list for the present positions. The skin (gap up to which pairs are listed) is that of lowest
    /// computing cost for a list that is used at intervals of `between_uses` [s] in simulated time. At the present
    /// speeds the list lasts for at least one use. Particles outside a periodic side are moved to their image inside
    /// the box, and all particles are sorted cell by cell. The returned list contains, for each new index, the
    /// previous index of the particle.
    pub fn build(&mut self, particles: &mut Particles, scene: &Scene, between_uses: f64) -> Vec<u32> {
        self.build_in(&Region::from(&scene.domain), particles, scene, between_uses)
    }

    /// Builds the list as [`build`](Self::build) does, for particles in a region of the box. Only this region is
    /// divided into cells.
    pub fn build_in(
        &mut self,
        region: &Region,
        particles: &mut Particles,
        scene: &Scene,
        between_uses: f64,
    ) -> Vec<u32> {
        let began = self.clock.now();
        let plan = ListSettings::of(particles, scene, between_uses);
        self.building += self.clock.now() - began;
        self.build_by(region, particles, scene, &plan)
    }

    /// Builds the list for the present positions, with settings that are the same in all processes of a run. If the
    /// cells cover the whole box, the pairs of this process are in the same order as in a list of all particles.
    pub fn build_by(
        &mut self,
        region: &Region,
        particles: &mut Particles,
        scene: &Scene,
        plan: &ListSettings,
    ) -> Vec<u32> {
        let began = self.clock.now();
        let skin = plan.skin;
        self.frame = plan.frame;
        particles.wrap(&scene.domain);
        let mut levels = SizeLevels::default();
        let sizes = match &plan.of_all {
            Some(of_all) => SortedSizes { radius: &particles.radius, range: of_all.range, skin, of_all: Some(of_all) },
            None => SortedSizes::new(&particles.radius, skin),
        };
        self.common_reach = (sizes.range[0] == sizes.range[1]).then(|| 2.0 * sizes.range[0]);
        levels.sort(&particles.position, &sizes, |x| *x, |index| particles.radius[index], region);
        levels.sort_cells(&particles.id);
        let order = levels.take_order();
        particles.reorder(&order);
        self.find_pairs(&levels, region, particles, scene, skin);
        self.find_pairs_across(&levels, region, (particles, scene), skin);
        self.find_walls(particles, scene, skin);
        self.skin = skin;
        self.uses = plan.uses;
        self.travelled = 0.0;
        self.builds += 1;
        self.building += self.clock.now() - began;
        order
    }

    /// Returns a copy of the list without pairs and walls. The copy contains only the data that are the same in all
    /// processes of a run.
    pub fn without_pairs(&self) -> Self {
        let (clock, first_pair) = (self.clock.clone(), Vec::new());
        Self { pairs: Vec::new(), walls: Vec::new(), clock, first_pair, ..*self }
    }

    /// Builds the list again. `particles` must be at the positions for which the list was last built. The stored
    /// distance that particles have moved since then does not change. Returns the previous index of each particle.
    pub fn build_again(&mut self, particles: &mut Particles, scene: &Scene) -> Vec<u32> {
        let (travelled, builds) = (self.travelled, self.builds);
        let plan =
            ListSettings { frame: self.frame, largest_speed: 0.0, skin: self.skin, uses: self.uses, of_all: None };
        let order = self.build_by(&Region::from(&scene.domain), particles, scene, &plan);
        (self.travelled, self.builds) = (travelled, builds);
        order
    }

    fn find_pairs(&mut self, levels: &SizeLevels, region: &Region, particles: &Particles, scene: &Scene, skin: f64) {
        let mut packed = PackedBalls::default();
        // the particles are sorted into cell order already
        let indices: Vec<u32> = (0..particles.len() as u32).collect();
        packed.fill(&indices, |i| (particles.position[i], particles.radius[i] + 0.5 * skin), region);
        drop(indices);
        let find = |rows: &[(usize, usize)]| {
            let (mut pairs, mut sieve) = (Vec::new(), Sieve::new(Pair { i: 0, j: 0 }));
            let mut look = |i, others: &[u32]| {
                for &j in others {
                    let pair = Pair { i, j };
                    let near = pair.is_within(pair.reach(particles) + skin, particles, scene);
                    sieve.offer(pair, near, &mut pairs);
                }
            };
            for &row in rows {
                let smaller = |i| (particles.position[i], particles.radius[i] + skin);
                packed.for_each_near::<true>(levels, row, smaller, &mut look);
            }
            sieve.empty(&mut pairs);
            pairs.shrink_to_fit();
            pairs
        };
        // groups of rows are processed one after the other, so that only the pairs of one group are in memory twice
        self.pairs.clear();
        for rows in levels.rows().chunks(4 * ROWS * rayon::current_num_threads()) {
            let parts: Vec<Vec<Pair>> = work_sharing::map(rows.chunks(ROWS), find);
            let all = self.pairs.len() + parts.iter().map(Vec::len).sum::<usize>();
            if all > self.pairs.capacity() {
                self.pairs.reserve_exact(all + all / 16 - self.pairs.len());
            }
            parts.iter().for_each(|part| self.pairs.extend_from_slice(part));
        }
        self.note_first_pairs(particles.len());
    }

    /// Removes every candidate (pair, or particle and wall) that contains no chosen particle. `chosen` has one entry
    /// for each particle, by index: true if the particle is chosen.
    pub fn keep_of(&mut self, chosen: &[bool]) {
        let is_chosen = |index: u32| chosen[index as usize];
        self.pairs.retain(|pair| is_chosen(pair.i) || is_chosen(pair.j));
        self.walls.retain(|near| is_chosen(near.particle));
        self.note_first_pairs(chosen.len());
    }

    fn note_first_pairs(&mut self, count: usize) {
        self.first_pair.clear();
        self.first_pair.resize(count + 1, 0);
        for pair in &self.pairs {
            self.first_pair[pair.i as usize + 1] += 1;
        }
        for i in 1..self.first_pair.len() {
            self.first_pair[i] += self.first_pair[i - 1];
        }
    }

    fn find_walls(&mut self, particles: &Particles, scene: &Scene, skin: f64) {
        self.walls.clear();
        let near_walls = NearWalls::of(&scene.walls);
        for (particle, (x, &r)) in (0u32..).zip(particles.position.iter().zip(&particles.radius)) {
            near_walls.for_each(x, r + skin, |wall| {
                let shape = &scene.walls[wall as usize].geometry;
                if shape.is_within(x, r + skin) {
                    let near = (0..shape.contacts()).filter(|which| shape.may_touch(*which, x, r, skin));
                    self.walls.extend(near.map(|which| NearWall { particle, at: AtWall { wall, which } }));
                }
            });
        }
        let index = |near: &NearWall| (near.at.wall, near.particle, near.at.which);
        self.walls.sort_unstable_by_key(index);
        self.walls.dedup_by_key(|near| index(near));
    }

    /// The two bodies of the candidate (pair, or particle and wall) with the number `slot` in the list.
    #[inline]
    pub fn couple(&self, slot: usize) -> Couple {
        match self.pairs.get(slot) {
            Some(pair) => Couple::pair(pair.i, pair.j),
            None => {
                let near = self.walls[slot - self.pairs.len()];
                Couple::at_wall(near.particle, near.at)
            }
        }
    }

    /// Slot (number of the candidate) of these two bodies, in either order; `None` if the list does not contain them.
    pub fn slot(&self, couple: &Couple) -> Option<usize> {
        match couple.other {
            Other::Particle(j) => self.pair_slot(couple.i, j),
            Other::Wall(at) => self.wall_slot(couple.i, at),
        }
    }

    fn pair_slot(&self, i: u32, j: u32) -> Option<usize> {
        let among = |a: u32, b: u32| {
            let range = self.first_pair[a as usize] as usize..self.first_pair[a as usize + 1] as usize;
            self.pairs[range.clone()].iter().position(|pair| pair.j == b).map(|k| range.start + k)
        };
        among(i, j).or_else(|| among(j, i))
    }

    fn wall_slot(&self, particle: u32, at: AtWall) -> Option<usize> {
        self.walls
            .binary_search_by_key(&(at.wall, particle, at.which), |near| (near.at.wall, near.particle, near.at.which))
            .ok()
            .map(|k| self.pairs.len() + k)
    }

    /// Replaces the content of `slots` by the numbers of all candidates (pairs of particles, or particles with walls)
    /// that overlap at present, in ascending order.
    pub fn overlapping(&self, particles: &Particles, scene: &Scene, slots: &mut Vec<u32>) {
        slots.clear();
        let all = self.slots();
        if all <= 2 * CHUNK {
            self.overlapping_within(0..all, particles, scene, slots);
            return;
        }
        let parts: Vec<Vec<u32>> = work_sharing::map(0..all.div_ceil(CHUNK), |chunk| {
            let mut found = Vec::new();
            self.overlapping_within(chunk * CHUNK..all.min((chunk + 1) * CHUNK), particles, scene, &mut found);
            found
        });
        slots.extend(parts.iter().flatten());
    }

    /// Appends to `slots` the numbers in `range` of the candidates (pairs of particles, or particles with walls) that
    /// overlap at present, in ascending order.
    pub fn overlapping_within(&self, range: Range<usize>, particles: &Particles, scene: &Scene, slots: &mut Vec<u32>) {
        let end = range.end;
        let walls = range.start.max(self.pairs.len());
        self.pairs_within(range, 0.0, (particles, scene), slots);
        self.walls_within(walls..end, particles, scene, slots);
    }

    /// Appends to `slots` the numbers in `range` of those pairs whose present gap is below `gap` [m], in ascending
    /// order.
    pub fn pairs_within(
        &self,
        range: Range<usize>,
        gap: f64,
        (particles, scene): (&Particles, &Scene),
        slots: &mut Vec<u32>,
    ) {
        let end = range.end.min(self.pairs.len());
        let first = range.start.min(end);
        let some = (first as u32..).zip(&self.pairs[first..end]);
        match self.common_reach {
            Some(reach) => within(some, |_| reach + gap, (particles, scene), slots),
            None => within(some, |pair| pair.reach(particles) + gap, (particles, scene), slots),
        }
    }

    /// Appends to `slots` those numbers of the list `some` whose two particles overlap at present, in the order of
    /// `some`. All numbers in `some` must belong to pairs of particles.
    pub fn overlapping_of(&self, some: &[u32], particles: &Particles, scene: &Scene, slots: &mut Vec<u32>) {
        let some = some.iter().map(|&slot| (slot, &self.pairs[slot as usize]));
        match self.common_reach {
            Some(reach) => within(some, |_| reach, (particles, scene), slots),
            None => within(some, |pair| pair.reach(particles), (particles, scene), slots),
        }
    }

    /// Appends to `slots` the numbers in `range` of candidates in which a particle and a wall overlap, in ascending
    /// order.
    pub fn walls_within(&self, range: Range<usize>, particles: &Particles, scene: &Scene, slots: &mut Vec<u32>) {
        let pairs = self.pairs.len();
        let mut apart: Option<Couple> = None;
        for slot in range.start.max(pairs)..range.end {
            let near = self.walls[slot - pairs];
            let couple = Couple::at_wall(near.particle, near.at);
            if apart.is_some_and(|nearer| couple.is_beyond(&nearer, scene)) {
                continue;
            }
            if near.gap(particles, scene) < 0.0 {
                slots.push(slot as u32);
            } else {
                apart = Some(couple);
            }
        }
    }
}

/// Appends to `slots` the numbers of those pairs in `some` whose centres are nearer to each other than the distance
/// [m] that `reach` returns.
#[inline(always)]
fn within<'a>(
    some: impl Iterator<Item = (u32, &'a Pair)>,
    reach: impl Fn(&Pair) -> f64,
    (particles, scene): (&Particles, &Scene),
    slots: &mut Vec<u32>,
) {
    let mut sieve = Sieve::new(0);
    for (slot, pair) in some {
        sieve.offer(slot, pair.is_within(reach(pair), particles, scene), slots);
    }
    sieve.empty(slots);
}

/// All pairs of bodies that overlap: two particles, or a particle and a wall. Particles are given by their index in
/// `particles`.
pub fn overlapping(particles: &Particles, scene: &Scene) -> Vec<Couple> {
    let (mut sorted, mut list, mut slots) = (particles.clone(), NeighbourList::default(), Vec::new());
    let order = list.build(&mut sorted, scene, 0.0);
    list.overlapping(&sorted, scene, &mut slots);
    slots.iter().map(|&slot| list.couple(slot as usize).moved(|index| order[index as usize])).collect()
}

/// All pairs of particles with a gap below `gap` [m], by their indices in `particles`. Along periodic axes, the largest
/// diameter and the gap together must be at most half the edge of the box.
pub fn pairs_with_gap(particles: &Particles, scene: &Scene, gap: f64) -> Vec<[usize; 2]> {
    let (mut sorted, mut list) = (particles.clone(), NeighbourList::default());
    let plan = ListSettings { frame: Vector3::zeros(), largest_speed: 0.0, skin: gap, uses: 1.0, of_all: None };
    let order = list.build_by(&Region::from(&scene.domain), &mut sorted, scene, &plan);
    list.pairs.iter().map(|pair| [pair.i, pair.j].map(|index| order[index as usize] as usize)).collect()
}

/// Component of a vector (velocity or acceleration of all particles) that is parallel to all walls, so that it changes
/// no gap to a wall. The result is zero if some wall is not a plane.
pub fn along_walls(scene: &Scene, vector: Vector3<f64>) -> Vector3<f64> {
    let mut normals: Vec<Vector3<f64>> = Vec::new();
    let mut rest = vector;
    for wall in &scene.walls {
        let Some(plane) = wall.geometry.plane() else { return Vector3::zeros() };
        // Gram-Schmidt orthogonalisation: part of this normal that is perpendicular to the previous normals
        let new = normals.iter().fold(plane.normal, |n, m| n - m * n.dot(m));
        if new.norm() > 1e-9 {
            let new = new.normalize();
            rest -= new * rest.dot(&new);
            normals.push(new);
        }
    }
    rest
}
