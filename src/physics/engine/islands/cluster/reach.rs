//! Speed limits of the particles of an island (a group of particles that may meet), and the largest distances that
//! these particles may reach. Speeds are relative to the moving frame, whose velocity is the mean velocity of all
//! particles along the walls.

use super::{BATCH, Cluster, Clusters, Member};
use crate::domain::Domain;
use crate::engine::islands::search::BoundingSphere;
use crate::particles::Particles;
use crate::work_sharing;
use nalgebra::Vector3;

/// [-] factor by which speeds may exceed the limit of energy conservation before an island (group of particles that
/// may meet) is solved again. It allows for a small gain of energy in contacts with finite time steps.
const MARGIN: f64 = 1.05;

/// Largest distances [m] that particles may reach in a part, a piece of the time between two exchanges with the gas.
/// The straight flight of a particle is its path in the part if the particle hits nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reach {
    /// [m] largest distance of any point of a particle from the middle of the straight flight of this particle.
    pub flight: f64,
    /// [m] largest distance that a member of an island (group of particles that may meet) may reach from the middle of
    /// its straight flight.
    pub around: f64,
    /// [m] largest radius of any ball of a member of an island (group of particles that may meet). Each member has a
    /// ball: the region in which it stays from the first touch in its island to the end of the part.
    pub ball: f64,
}

impl Reach {
    /// Distance [m] around an island (group of particles that may meet) within which a process must store all
    /// particles to solve the island. The process then knows all particles that may meet the island, and finds out
    /// which of them touch something on their straight flights.
    pub fn search_radius(&self) -> f64 {
        self.around.max(self.flight) + 2.0 * self.flight
    }

    /// True if two particles can meet only as nearest images. Other images are farther away than half the period of the
    /// box, `half_period` [m].
    pub fn fits(&self, half_period: f64) -> bool {
        self.ball + self.around.max(self.flight) <= half_period
    }
}

/// The two largest of the four values a, b, c and d, the largest first. Requires a ≥ b and c ≥ d.
pub(super) fn two_largest([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    if a >= c { [a, b.max(c)] } else { [c, d.max(a)] }
}

/// Kinetic energy [J] and speed [m/s] of a particle, given by index, relative to a frame with the velocity `frame`
/// [m/s]. Friction may turn rotation into translation. Therefore the energy includes that of rotation, and the speed
/// includes that of the rotating surface.
pub(super) fn motion(particles: &Particles, frame: Vector3<f64>, index: u32) -> (f64, f64) {
    let square = (particles.velocity[index as usize] - frame).norm_squared();
    let index = index as usize;
    let (energy, speed) = (0.5 * particles.mass[index] * square, square.sqrt());
    match (&particles.spin, &particles.inertia) {
        (Some(spins), Some(inertia)) => {
            let spin = spins[index].norm_squared();
            (energy + 0.5 * inertia[index] * spin, speed + particles.radius[index] * spin.sqrt())
        }
        _ => (energy, speed),
    }
}

impl Clusters<'_> {
    /// Speed limit [m/s] of a member of an island (group of particles that may meet), relative to the moving frame:
    /// the lesser of two bounds. One bound follows from the two largest energies in the island, the other from the two
    /// largest speeds. Two particles alone never exceed either bound. Among more particles a speed may exceed both
    /// bounds; the island is then solved again with a higher limit.
    ///
    /// The two most energetic particles may give all their energy to one particle, which gives the first bound. For
    /// the second, let the two fastest have the speeds s₁ ≥ s₂. Their centre of mass is not faster than s₁, and
    /// relative to it each particle moves at s₁ + s₂ or less. So neither leaves faster than 2 s₁ + s₂. An energy E
    /// that a contact gives back adds at most √(2E/m) to the speed of a particle of mass m. For light particles among
    /// heavy ones, the second bound is the lesser one.
    ///
    /// The contacts of a crowd (a large island moved by uniform steps) together store far more energy than any of its
    /// particles ever receives. Therefore the bounds of a crowd contain only twice the largest energy of one contact,
    /// and all of its particles have equal limits.
    pub(super) fn limit(&self, cluster: &Cluster, index: u32) -> f64 {
        let crowd = cluster.is_crowd();
        let stored = if crowd { 2.0 * cluster.deepest } else { cluster.stored };
        let mass = if crowd { self.lightest } else { self.particles.mass[index as usize] };
        let of_energy = (2.0 * (cluster.energies[0] + cluster.energies[1] + stored) / mass).sqrt();
        let of_momentum = 2.0 * cluster.speeds[0] + cluster.speeds[1] + (2.0 * stored / mass).sqrt();
        (of_energy.min(of_momentum) * MARGIN).max(cluster.floor) + self.fall
    }

    /// Computes, for all islands (groups of particles that may meet), the distances that their members may reach. First
    /// the data of each island follow from its members, then the data of each member from its island. In both steps the
    /// threads work in parallel.
    pub(super) fn settle_all(&mut self) {
        let mut clusters = std::mem::take(&mut self.list);
        work_sharing::for_each(clusters.chunks_mut(BATCH), |some| {
            some.iter_mut().for_each(|cluster| self.put_in_order(cluster))
        });
        self.list = clusters;
        let mut members = std::mem::take(&mut self.members);
        let reach = |some: &mut [Member]| some.iter_mut().map(|member| self.reach_out(member)).fold(0.0, f64::max);
        let reaches = work_sharing::map(members.chunks_mut(BATCH), reach);
        self.widest = reaches.into_iter().fold(self.widest, f64::max);
        self.members = members;
    }

    /// Computes the distances that the members of the island `which` (group of particles that may meet) may reach,
    /// after the island has changed.
    pub(super) fn update_reach(&mut self, which: usize) {
        let mut clusters = std::mem::take(&mut self.list);
        self.put_in_order(&mut clusters[which]);
        self.list = clusters;
        for number in 0..self.list[which].hot.len() {
            self.update_reach_of_member(self.list[which].hot[number]);
        }
    }

    /// Computes the distance that the member with the number `member` may reach, after its island (group of particles
    /// that may meet) has changed.
    pub(super) fn update_reach_of_member(&mut self, member: u32) {
        let mut members = std::mem::take(&mut self.members);
        self.widest = self.widest.max(self.reach_out(&mut members[member as usize]));
        self.members = members;
    }

    /// Sorts the members of an island (group of particles that may meet) by id and its contacts by number, and
    /// computes its largest energies and speeds. The order does not depend on that of the particle store, nor on the
    /// order in which islands were united.
    fn put_in_order(&self, cluster: &mut Cluster) {
        cluster.hot.sort_unstable_by_key(|&member| self.particles.id[self.members[member as usize].index as usize]);
        cluster.carried.sort_unstable();
        (cluster.energies, cluster.speeds) = ([0.0; 2], [0.0; 2]);
        for &member in &cluster.hot {
            let index = self.members[member as usize].index;
            let (energy, speed) = motion(self.particles, self.frame_of(index as usize), index);
            cluster.energies = two_largest(cluster.energies, [energy, 0.0]);
            cluster.speeds = two_largest(cluster.speeds, [speed, 0.0]);
        }
        let energies = || cluster.carried.iter().map(|&k| self.energy[k as usize]);
        (cluster.stored, cluster.deepest) = (energies().sum(), energies().fold(0.0, f64::max));
        cluster.settled = Some(cluster.version);
    }

    /// Computes the ball that contains a member of an island (group of particles that may meet) between the first
    /// touch in the island and the end of the part (interval of time). Returns the largest distance [m] of any point
    /// of the member from the middle of its straight flight.
    fn reach_out(&self, member: &mut Member) -> f64 {
        let (cluster, i) = (&self.list[member.cluster as usize], member.index as usize);
        member.flight = self.search.flights[i];
        member.turns = None;
        let first = cluster.first;
        let velocity = self.particles.velocity[i] - self.frame_of(i);
        let reach = self.particles.radius[i] + self.limit(cluster, member.index) * (self.part - first);
        let ball = BoundingSphere { middle: self.domain.wrap(&(self.particles.position[i] + velocity * first)), reach };
        let speed = velocity.norm();
        member.ball = ball.strained(self.domain, self.part, reach + speed * first);
        let aside = speed * (first - 0.5 * self.part).abs() * (1.0 + 1e-12);
        member.around = member.flight.reach.max(member.ball.reach + aside);
        member.around
    }

    /// Largest distances that any straight flight and any member of an island (group of particles that may meet) may
    /// reach.
    pub fn reach(&self) -> Reach {
        let ball = self.members.iter().map(|member| member.ball.reach).fold(0.0, f64::max);
        Reach { flight: self.search.levels.largest_reach(), around: self.widest, ball }
    }

    /// Smallest distance [m] between a place that a member of the island (group of particles that may meet) may reach
    /// and the border of the region whose particles this process stores. The distance is negative if a member may
    /// reach beyond this border, and infinite if the process stores all particles.
    pub(super) fn room(&self, which: usize) -> f64 {
        if self.search.region.is_all() {
            return f64::INFINITY;
        }
        let members = self.list[which].hot.iter().map(|&member| &self.members[member as usize]);
        let depth = |middle: &Vector3<f64>| self.search.region.depth(middle, self.domain);
        let room =
            |one: &Member| (depth(&one.ball.middle) - one.ball.reach).min(depth(&one.flight.middle) - one.around);
        members.map(room).fold(f64::INFINITY, f64::min)
    }

    /// Smallest distance [m] between an island (group of particles that may meet) and the border of the region whose
    /// particles this process stores. Only islands with a member for whose index `chosen` returns true are considered.
    /// Infinite if there are no such islands.
    pub fn least_room(&self, chosen: impl Fn(u32) -> bool) -> f64 {
        if self.search.region.is_all() {
            return f64::INFINITY;
        }
        let theirs = (0..self.list.len()).filter(|&which| self.has(which, &chosen));
        theirs.map(|which| self.room(which)).fold(f64::INFINITY, f64::min)
    }

    /// True if the island with the number `which` (group of particles that may meet) has not been united with another
    /// one, and has a member for whose index in the store `chosen` returns true.
    pub(in crate::engine) fn has(&self, which: usize, chosen: &impl Fn(u32) -> bool) -> bool {
        let Cluster { alive, hot, .. } = &self.list[which];
        *alive && hot.iter().any(|&member| chosen(self.members[member as usize].index))
    }

    /// Index in the store of the leader of an island (group of particles that may meet), its member with the smallest
    /// id; `None` if it has no members. The process that owns the leader counts the events of the island.
    pub fn leader(&self, which: usize) -> Option<u32> {
        self.list[which].hot.first().map(|&member| self.members[member as usize].index)
    }

    /// The periodic box of the scene at the start of the part (interval of time).
    pub fn domain(&self) -> &Domain {
        self.domain
    }

    /// Half the shortest period [m] of the box, beyond which images other than the nearest could be hit; infinite
    /// without periodic sides.
    pub fn half_period(&self) -> f64 {
        self.half_period
    }
}
