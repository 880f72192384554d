//! Which particles may touch one another, or a wall?
//!
//! A [`NeighbourList`] holds every pair of particles, and every particle and wall, whose gap is below a skin. It stays
//! complete until some particle has travelled half the skin relative to a common frame, and the list keeps the account
//! of that travel itself: an engine says how far its particles may move, the list says when it must be built anew.

pub mod cells;
mod lanes;
pub mod levels;
pub mod packed;
pub mod plan;
pub mod region;

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
use std::ops::Range;
use std::time::Duration;

/// Rows of cells per parallel task.
const ROWS: usize = 64;

/// Two particles that may touch, by place in the store.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    /// One particle.
    pub i: u32,
    /// The other.
    pub j: u32,
}

impl Pair {
    /// [m] distance of centres at which they touch.
    #[inline(always)]
    pub fn reach(&self, particles: &Particles) -> f64 {
        particles.radius[self.i as usize] + particles.radius[self.j as usize]
    }

    /// Whether the distance of centres is below `reach` [m] now.
    #[inline(always)]
    fn is_within(&self, reach: f64, particles: &Particles, scene: &Scene) -> bool {
        let (a, b) = (&particles.position[self.i as usize], &particles.position[self.j as usize]);
        scene.domain.separation(a, b).norm_squared() < reach * reach
    }
}

/// A particle and a wall that may touch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NearWall {
    /// Place of the particle.
    pub particle: u32,
    /// The wall, and which of its contacts.
    pub at: AtWall,
}

impl NearWall {
    /// [m] the gap between the two now, or less where the wall is too far away to be looked for.
    #[inline]
    pub fn gap(&self, particles: &Particles, scene: &Scene) -> f64 {
        let place = self.particle as usize;
        let (x, radius) = (&particles.position[place], particles.radius[place]);
        scene.walls[self.at.wall as usize].geometry.contact(self.at.which, x, radius).distance - radius
    }
}

/// Candidates for touching. A *slot* numbers them: pairs first, then walls.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct NeighbourList {
    /// Pairs with a gap below the skin, grouped by `i`.
    pub pairs: Vec<Pair>,
    /// Particles with a gap to a wall below the skin.
    pub walls: Vec<NearWall>,
    /// Times the building of lists.
    #[serde(skip)]
    pub clock: Clock,
    /// `pairs[first_pair[i] .. first_pair[i + 1]]` are the pairs whose `i` is that place.
    first_pair: Vec<u32>,
    /// [m] distance of centres at which two touch, where it is the same for all pairs: radii need not be read then.
    common_reach: Option<f64>,
    skin: f64,
    /// [-] how often the list can be used at the speeds at which it was built.
    uses: f64,
    travelled: f64,
    frame: Vector3<f64>,
    builds: u64,
    building: Duration,
}

impl NeighbourList {
    /// [m/s] the velocity that travel is measured against: the mean, less every part that nears a wall.
    pub fn frame(&self) -> Vector3<f64> {
        self.frame
    }

    /// [m] pairs are listed up to this gap.
    pub fn skin(&self) -> f64 {
        self.skin
    }

    /// [m] how far particles may have moved relative to the frame since the list was built.
    pub fn travelled(&self) -> f64 {
        self.travelled
    }

    /// [m] the gap below which pairs are worth a list of their own, made of this one; `None` if none is.
    ///
    /// Such a list holds s/skin of the pairs, s being its gap, and lasts for `uses`·s/skin uses: looking through all pairs once in that time
    /// and through its own at every use costs least at s = skin/sqrt(uses).
    pub fn inner_skin(&self) -> Option<f64> {
        // with fewer uses there is nothing to gain; speeds may grow, so the inner skin does not get as thin as it could
        (self.uses >= 8.0).then(|| self.skin / self.uses.min(400.0).sqrt())
    }

    /// Lists built so far.
    pub fn builds(&self) -> u64 {
        self.builds
    }

    /// Wall-clock time spent on them.
    pub fn building(&self) -> Duration {
        self.building
    }

    /// Candidates: pairs and walls.
    pub fn slots(&self) -> usize {
        self.pairs.len() + self.walls.len()
    }

    /// Whether the list stays complete if every particle moves up to `distance` [m] more relative to the frame.
    pub fn allows(&self, distance: f64) -> bool {
        self.builds > 0 && 2.0 * (self.travelled + distance) <= self.skin
    }

    /// [m] how far every particle may still move relative to the frame before the list is no longer complete.
    pub fn room(&self) -> f64 {
        if self.builds > 0 { 0.5 * self.skin - self.travelled } else { 0.0 }
    }

    /// Somebody else has moved or reordered the particles: the list must be built before it is used again.
    pub fn invalidate(&mut self) {
        self.travelled = f64::INFINITY;
    }

    /// Notes that particles may have moved up to `distance` [m] relative to the frame.
    pub fn travel(&mut self, distance: f64) {
        self.travelled += distance;
    }

    /// Builds the list for the present positions, with the skin that costs least when the list is used every
    /// `between_uses` [s]; it then lasts for at least one use at the present speeds. The store is put in cell order: the
    /// particle now at place `k` stood at `order[k]` of the returned order.
    pub fn build(&mut self, particles: &mut Particles, scene: &Scene, between_uses: f64) -> Vec<u32> {
        self.build_in(&Region::from(&scene.domain), particles, scene, between_uses)
    }

    /// The same of particles that are all in one region of the box, with cells there alone.
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

    /// Builds the list for the present positions by a plan that parts of it, of other processes, go by as well. Pairs and the order of the store are those
    /// of the list of all, of what there is here, if the cells are those of the whole box.
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
        let sizes = match &plan.everyone {
            Some(everyone) => {
                SortedSizes { radius: &particles.radius, range: everyone.range, skin, everyone: Some(everyone) }
            }
            None => SortedSizes::new(&particles.radius, skin),
        };
        self.common_reach = (sizes.range[0] == sizes.range[1]).then(|| 2.0 * sizes.range[0]);
        levels.sort(&particles.position, &sizes, |x| *x, |place| particles.radius[place], region);
        levels.sort_cells(&particles.id);
        let order = levels.take_order();
        particles.reorder(&order);
        self.find_pairs(&levels, region, particles, scene, skin);
        self.find_walls(particles, scene, skin);
        self.skin = skin;
        self.uses = plan.uses;
        self.travelled = 0.0;
        self.builds += 1;
        self.building += self.clock.now() - began;
        order
    }

    /// The same without pairs and walls: what all parts of it have in common.
    pub fn without_pairs(&self) -> Self {
        let (clock, first_pair) = (self.clock.clone(), Vec::new());
        Self { pairs: Vec::new(), walls: Vec::new(), clock, first_pair, ..*self }
    }

    /// Builds it once more of the positions that it was built of, as far as particles have travelled since.
    pub fn build_again(&mut self, particles: &mut Particles, scene: &Scene) -> Vec<u32> {
        let (travelled, builds) = (self.travelled, self.builds);
        let plan =
            ListSettings { frame: self.frame, largest_speed: 0.0, skin: self.skin, uses: self.uses, everyone: None };
        let order = self.build_by(&Region::from(&scene.domain), particles, scene, &plan);
        (self.travelled, self.builds) = (travelled, builds);
        order
    }

    fn find_pairs(&mut self, levels: &SizeLevels, region: &Region, particles: &Particles, scene: &Scene, skin: f64) {
        let mut packed = PackedBalls::default();
        // the store is in the order of the cells by now
        let places: Vec<u32> = (0..particles.len() as u32).collect();
        packed.fill(&places, |i| (particles.position[i], particles.radius[i] + 0.5 * skin), region);
        drop(places);
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
        // some rows after others, so that most pairs are in memory once only
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

    /// Leaves out all pairs and walls of which no particle is one of those.
    pub fn keep_of(&mut self, chosen: &[bool]) {
        let is_chosen = |place: u32| chosen[place as usize];
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
        let place = |near: &NearWall| (near.at.wall, near.particle, near.at.which);
        self.walls.sort_unstable_by_key(place);
        self.walls.dedup_by_key(|near| place(near));
    }

    /// Who may touch whom at a slot: the pairs come first, then the walls.
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

    /// The slot of two bodies, in either order; `None` if they are too far apart to be listed.
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

    /// Slots whose surfaces overlap now, in ascending order.
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

    /// Appends those of some slots whose surfaces overlap now, in ascending order.
    pub fn overlapping_within(&self, range: Range<usize>, particles: &Particles, scene: &Scene, slots: &mut Vec<u32>) {
        let end = range.end;
        let walls = range.start.max(self.pairs.len());
        self.pairs_within(range, 0.0, (particles, scene), slots);
        self.walls_within(walls..end, particles, scene, slots);
    }

    /// Appends those of some slots that are pairs with a gap below `gap` [m], in ascending order.
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

    /// Appends those of some slots of pairs that overlap now, in the same order.
    pub fn overlapping_of(&self, some: &[u32], particles: &Particles, scene: &Scene, slots: &mut Vec<u32>) {
        let some = some.iter().map(|&slot| (slot, &self.pairs[slot as usize]));
        match self.common_reach {
            Some(reach) => within(some, |_| reach, (particles, scene), slots),
            None => within(some, |pair| pair.reach(particles), (particles, scene), slots),
        }
    }

    /// Appends those of some slots that are walls which overlap with their particle now, in ascending order.
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

/// Picks some of many in their order. Whether one is wanted is not known before: to note each, and to go on after those only that are,
/// costs less than to ask and to guess wrong.
struct Sieve<T> {
    held: [T; 64],
    count: usize,
}

impl<T: Copy> Sieve<T> {
    /// Nothing so far; `any` is whatever may stand at places that are not in use.
    fn new(any: T) -> Self {
        Self { held: [any; 64], count: 0 }
    }

    /// Looks at the next one.
    #[inline(always)]
    fn offer(&mut self, item: T, wanted: bool, picked: &mut Vec<T>) {
        self.held[self.count] = item;
        self.count += usize::from(wanted);
        if self.count == self.held.len() {
            self.empty(picked);
        }
    }

    /// Hands over what has been picked so far.
    fn empty(&mut self, picked: &mut Vec<T>) {
        picked.extend_from_slice(&self.held[..self.count]);
        self.count = 0;
    }
}

/// Appends the slots of those pairs whose centres are nearer than `reach` says [m].
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

/// Who overlaps, by place in a store whose order stays as it is.
pub fn overlapping(particles: &Particles, scene: &Scene) -> Vec<Couple> {
    let (mut sorted, mut list, mut slots) = (particles.clone(), NeighbourList::default(), Vec::new());
    let order = list.build(&mut sorted, scene, 0.0);
    list.overlapping(&sorted, scene, &mut slots);
    slots.iter().map(|&slot| list.couple(slot as usize).moved(|place| order[place as usize])).collect()
}

/// The part of a common velocity (or acceleration) that changes no gap to any wall: along all planes; none beside a body.
pub fn along_walls(scene: &Scene, vector: Vector3<f64>) -> Vector3<f64> {
    let mut normals: Vec<Vector3<f64>> = Vec::new();
    let mut rest = vector;
    for wall in &scene.walls {
        let Some(plane) = wall.geometry.plane() else { return Vector3::zeros() };
        // Gram-Schmidt: what of this normal is not yet taken out
        let new = normals.iter().fold(plane.normal, |n, m| n - m * n.dot(m));
        if new.norm() > 1e-9 {
            let new = new.normalize();
            rest -= new * rest.dot(&new);
            normals.push(new);
        }
    }
    rest
}
