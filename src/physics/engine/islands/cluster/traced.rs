//! Islands (groups of particles that may meet) that are found by the trajectories of their members. They are used for
//! engines that report every velocity change. Islands are solved in rounds. After each round the trajectories show
//! which islands meet.
//!
//! Each island is first solved as if it were alone. Its trajectories may then meet those of another island, or a
//! particle that was expected to fly straight. In that case both form one island, which is solved again. In the end
//! particles meet only within islands. The trajectories are then those of the whole system, because an initial state
//! has only one solution. Earlier solutions do not affect the result, so the order in which islands are united does not
//! matter.

use super::trajectories::{MemberTrajectories, ParticleTrajectory, PiecewiseTrajectory, Segment, VelocityChange};
use super::{BATCH, Clusters, IslandFinder, IslandLimits, Member};
use crate::domain::Domain;
use crate::engine::islands::batch::Retry;
use crate::engine::islands::choice::{PartCosts, TRACED};
use crate::engine::islands::island::Island;
use crate::engine::islands::search::{BoundingSphere, FirstTouch};
use crate::neighbours::Pair;
use crate::neighbours::levels::SizeLevels;
use crate::neighbours::packed::PackedBalls;
use crate::neighbours::region::Region;
use crate::work_sharing;
use std::ops::{Deref, DerefMut, Range};

/// [-] allowance for rounding: a gap below this fraction of the summed lengths of both paths counts as a touch.
const NEARLY: f64 = 1e-9;

/// Balls sorted into cells. Each ball contains the path of one member of an island (group of particles that may meet),
/// from the member's first velocity change on.
#[derive(Default)]
pub struct DeflectedFlights {
    /// For each ball, the number of its particle among the members of all islands (groups of particles that may meet).
    members: Vec<u32>,
    levels: SizeLevels,
    packed: PackedBalls,
}

impl DeflectedFlights {
    /// Sorts into cells the balls of the members with the numbers `some` in the list `all`. The middles of the balls
    /// must be in `region`.
    fn sort(&mut self, some: Vec<u32>, all: &[Member], region: &Region) {
        let ball = |k: usize| all[some[k] as usize].ball;
        self.levels.sort_alike(&some, |&k| all[k as usize].ball.middle, |k| ball(k).reach, region);
        self.packed.fill(&self.levels.order(), |k| (ball(k).middle, ball(k).reach), region);
        self.members = some;
    }

    /// Calls `visit` with the numbers of the members whose balls overlap `ball`, and of a few whose balls nearly do.
    fn for_each_beside(&self, ball: &BoundingSphere, (domain, region): (&Domain, &Region), mut visit: impl FnMut(u32)) {
        if self.members.is_empty() {
            return;
        }
        domain.for_each_image(&ball.middle, ball.reach + self.levels.largest_reach(), |middle| {
            self.packed.for_each_beside((middle, ball.reach), &self.levels, region, |numbers| {
                numbers.iter().for_each(|&k| visit(self.members[k as usize]));
            });
        });
    }
}

/// Method that solves islands (groups of particles that may meet) first: the trajectories of solved islands show which
/// islands meet. Islands that meet are united and solved again.
pub struct TracedIslands<'a> {
    clusters: Clusters<'a>,
    /// Velocity changes of the members of all solved islands (groups of particles that may meet). Those of one member
    /// follow one another in the order of time.
    turns: Vec<VelocityChange>,
    /// Balls that contain paths after the first velocity change, sorted into cells. The first entry is for all members.
    /// The second is for members whose islands have been solved more than once.
    deflected: [DeflectedFlights; 2],
}

impl<'a> Deref for TracedIslands<'a> {
    type Target = Clusters<'a>;

    fn deref(&self) -> &Clusters<'a> {
        &self.clusters
    }
}

impl<'a> DerefMut for TracedIslands<'a> {
    fn deref_mut(&mut self) -> &mut Clusters<'a> {
        &mut self.clusters
    }
}

impl<'a> IslandFinder<'a> for TracedIslands<'a> {
    const COSTS: PartCosts = TRACED;
    const KEEPS_SHORTER: bool = false;

    fn new(clusters: Clusters<'a>, _limits: IslandLimits) -> Self {
        Self { clusters, turns: Vec::new(), deflected: Default::default() }
    }

    fn into_clusters(self) -> Clusters<'a> {
        self.clusters
    }

    fn gather(&mut self, touches: &[FirstTouch], carried: &[[Option<u32>; 2]], energy: Vec<f64>) -> bool {
        self.begin(touches, carried, energy, false);
        true
    }

    /// Appends all pairs of a member with later particles of its island (group of particles that may meet): before the
    /// island is solved, any of them may meet.
    fn list_pairs(&self, (a, _): (usize, &Member), (indices, _): (&[u32], usize), pairs: &mut Vec<Pair>) {
        pairs.extend((a + 1..indices.len()).map(|b| Pair { i: a as u32, j: b as u32 }));
    }

    fn trajectories(members: usize) -> MemberTrajectories {
        MemberTrajectories { ways: Vec::with_capacity(members), turns: Vec::with_capacity(2 * members) }
    }

    fn trace<C>(&self, island: &mut Island<C>, trajectories: &mut MemberTrajectories) {
        let MemberTrajectories { ways, turns } = trajectories;
        // a stable sort, so that the velocity changes of one particle stay in the order of time
        island.turns.sort_by_key(|(local, _)| *local);
        let mut rest = island.turns.as_slice();
        for local in 0..island.hot as u32 {
            let (own, others) = rest.split_at(rest.partition_point(|(of, _)| *of <= local));
            let first = turns.len();
            turns.extend(own.iter().map(|(_, turn)| *turn));
            ways.push(self.way(island.indices[local as usize], &turns[first..], first));
            rest = others;
        }
    }

    fn follow(
        &mut self,
        which: usize,
        ways: Range<usize>,
        MemberTrajectories { ways: all, turns }: &MemberTrajectories,
    ) {
        for (number, way) in all[ways].iter().enumerate() {
            let first = self.turns.len();
            self.turns.extend_from_slice(&turns[way.turns.clone()]);
            let known = Some(first..self.turns.len());
            let member = self.list[which].hot[number] as usize;
            let member = &mut self.members[member];
            (member.ball, member.around, member.turns) = (way.ball, way.around, known);
        }
    }

    fn next_round(&mut self, retries: Vec<(usize, Retry)>, mine: impl Fn(u32) -> bool) -> Option<u64> {
        self.apply_retries(retries);
        self.unite_meeting(mine)
    }

    fn velocity_changes(&self, member: &Member) -> Option<&[VelocityChange]> {
        self.trajectory(member).turns
    }

    fn may_meet(&self, member: &Member, index: u32, turns: Option<&[VelocityChange]>) -> bool {
        self.may_touch(&self.trajectory(member), &ParticleTrajectory { index, turns })
    }

    fn for_each_beside(&self, ball: &BoundingSphere, _widest: f64, visit: &mut dyn FnMut(&Member)) {
        self.for_each_deflected_beside(ball, &mut *visit);
        self.search.for_each_beside(ball, self.domain, |index| {
            if let Some(label) = self.search.label[index as usize] {
                visit(&self.members[label.member()]);
            }
        });
    }
}

impl TracedIslands<'_> {
    /// Trajectory of a member of an island (group of particles that may meet) in this part, a piece of the time
    /// between two exchanges with the gas.
    fn trajectory(&self, member: &Member) -> ParticleTrajectory<'_> {
        ParticleTrajectory { index: member.index, turns: member.turns.clone().map(|turns| &self.turns[turns]) }
    }

    /// Makes the trajectory of a member, given by its index in the store, from its velocity changes `turns`. `first` is
    /// the place of the first of these changes in the list of the changes of all trajectories.
    fn way(&self, index: u32, turns: &[VelocityChange], first: usize) -> PiecewiseTrajectory {
        let flight = self.search.flights[index as usize];
        let turned = first..first + turns.len();
        let Some(begin) = turns.first().map(|turn| turn.origin + turn.velocity * turn.time) else {
            return PiecewiseTrajectory { turns: turned, ball: flight, around: flight.reach };
        };
        // a ball about the middle between the first change and the end contains the path, if it contains the positions
        // at all velocity changes and at the end
        let corner = |turn: &VelocityChange| turn.origin + turn.velocity * turn.time;
        let end = turns.last().map_or(begin, |turn| turn.origin + turn.velocity * self.part);
        let middle = (begin + end) * 0.5;
        let corners = turns.iter().map(corner).chain([end]);
        let half = corners.map(|corner| (corner - middle).norm()).fold(0.0, f64::max);
        let reach = self.particles.radius[index as usize] + half * (1.0 + NEARLY);
        let way = (middle - self.particles.position[index as usize]).norm() + reach;
        let ball = BoundingSphere { middle: self.domain.wrap(&middle), reach }.strained(self.domain, self.part, way);
        let apart = self.domain.separation(&ball.middle, &flight.middle).norm();
        PiecewiseTrajectory { turns: turned, around: flight.reach.max(ball.reach + apart * (1.0 + NEARLY)), ball }
    }

    /// Unites solved islands (groups of particles that may meet) with the islands and single particles that their
    /// trajectories meet; the united islands must be solved again. Returns the number of results that became invalid;
    /// `None` if an island is too large or reaches too far. `mine` returns true for the index of a particle that
    /// belongs to this process. An island is counted only if its leader (the member with the smallest id) belongs to
    /// this process.
    fn unite_meeting(&mut self, mine: impl Fn(u32) -> bool) -> Option<u64> {
        let is_new = |which: &usize| {
            let cluster = &self.list[*which];
            cluster.alive && cluster.solved.is_some() && cluster.seen != Some(cluster.version)
        };
        let new: Vec<usize> = (0..self.list.len()).filter(is_new).collect();
        self.lay_out(&new);
        let this = &*self;
        let look = |some: &[usize]| some.iter().map(|&which| this.met_by(which)).collect::<Vec<_>>();
        let met = work_sharing::map(new.chunks(BATCH), look).into_iter().flatten();
        let (mut changed, mut in_vain) = (Vec::new(), 0);
        for (which, met) in new.iter().copied().zip(met) {
            let met = met?;
            if met.is_empty() {
                self.list[which].seen = Some(self.list[which].version);
            } else {
                in_vain += u64::from(self.leader(which).is_some_and(&mine));
                changed.push((self.list[which].hot[0] as usize, met));
            }
        }
        for (member, met) in &changed {
            for &index in met {
                let other = self.cluster_of(index);
                let which = self.members[*member].cluster as usize;
                self.unite(which, other);
            }
        }
        let mut changed: Vec<usize> =
            changed.iter().map(|(member, _)| self.members[*member].cluster as usize).collect();
        changed.sort_unstable();
        changed.dedup();
        changed.iter().for_each(|&which| self.update_reach(which));
        changed.iter().all(|&which| !self.list[which].is_crowd()).then_some(in_vain)
    }

    /// Sorts into cells the balls that contain paths after a velocity change. After all islands (groups of particles
    /// that may meet) have been solved for the first time, these are the balls of all members. Later, when islands
    /// have been solved again, the balls of the islands in `new` are added to a second list of balls.
    fn lay_out(&mut self, new: &[usize]) {
        let Clusters { search, members: known, list, widest, .. } = &mut self.clusters;
        let region = &search.region;
        *widest = known.iter().map(|member| member.around).fold(0.0, f64::max);
        let [all, anew] = &mut self.deflected;
        if all.members.is_empty() {
            all.sort((0..known.len() as u32).collect(), known, region);
            return;
        }
        let mut members = std::mem::take(&mut anew.members);
        members.extend(new.iter().flat_map(|&which| &list[which].hot));
        members.sort_unstable();
        members.dedup();
        anew.sort(members, known, region);
    }

    /// Calls `visit` with the members whose path after the first velocity change lies in a ball that overlaps `ball`.
    /// A member may be visited twice. Some members whose balls only nearly overlap `ball` are visited too.
    fn for_each_deflected_beside(&self, ball: &BoundingSphere, mut visit: impl FnMut(&Member)) {
        for turned in &self.deflected {
            let space = (self.domain, &self.search.region);
            turned.for_each_beside(ball, space, |member| visit(&self.members[member as usize]));
        }
    }

    /// Indices (in the particle store) of the particles outside the island `which` (group of particles that may meet)
    /// that members of the island may meet on their trajectories. An index may occur several times. `None` if a member
    /// could meet a periodic image of a particle other than the nearest image.
    fn met_by(&self, which: usize) -> Option<Vec<u32>> {
        let mut met = Vec::new();
        // in the first round the surroundings of every island are searched. A search around a path after a velocity
        // change finds the straight flights that meet this path, so no search around straight flights is needed.
        let all_look = self.search.region.is_all() && self.deflected[1].members.is_empty();
        for &member in &self.list[which].hot {
            let member = &self.members[member as usize];
            // beyond half a period, an image other than the nearest could be hit
            if member.around + self.widest.max(self.search.levels.largest_reach()) > self.half_period {
                return None;
            }
            let own = self.trajectory(member);
            let touches =
                |other: &Member| other.cluster != which as u32 && self.may_touch(&own, &self.trajectory(other));
            let mut note = |other: &Member| met.extend(touches(other).then_some(other.index));
            self.for_each_deflected_beside(&member.ball, &mut note);
            if !all_look {
                self.for_each_deflected_beside(&member.flight, &mut note);
            }
            self.search.for_each_beside(&member.ball, self.domain, |index| {
                let straight = ParticleTrajectory { index, turns: Some(&[]) };
                let meets = match self.search.label[index as usize] {
                    Some(label) => touches(&self.members[label.member()]),
                    None => self.may_touch(&own, &straight),
                };
                met.extend(meets.then_some(index));
            });
        }
        Some(met)
    }

    /// True if two particles may touch on their trajectories after a velocity change of at least one of them. Touches
    /// of two straight flights are not considered, because they are already known. Also true if a trajectory is
    /// unknown.
    fn may_touch(&self, one: &ParticleTrajectory, other: &ParticleTrajectory) -> bool {
        let (Some(turns), Some(others)) = (one.turns, other.turns) else { return true };
        let reach = self.particles.radius[one.index as usize] + self.particles.radius[other.index as usize];
        (0..=turns.len()).any(|number| {
            let leg = self.leg(one.index, turns, number);
            // touches before the first velocity change of both particles are already known
            let first = usize::from(number == 0);
            (first..=others.len()).any(|number| self.pass(&leg, &self.leg(other.index, others, number), reach))
        })
    }

    /// Straight piece number `number` of the trajectory of the particle at `index`. Piece 0 is the flight before
    /// the first of the velocity changes `turns`, and piece k the flight after change k.
    fn leg(&self, index: u32, turns: &[VelocityChange], number: usize) -> Segment {
        let end = turns.get(number).map_or(self.part, |turn| turn.time);
        match number.checked_sub(1).and_then(|before| turns.get(before)) {
            Some(turn) => {
                let flow = self.domain.mean_flow(&self.particles.position[index as usize]);
                Segment { span: [turn.time, end], origin: turn.origin, velocity: turn.velocity + flow }
            }
            None => {
                let index = index as usize;
                let velocity = self.particles.velocity[index] - self.frame;
                Segment { span: [0.0, end], origin: self.particles.position[index], velocity }
            }
        }
    }

    /// True if the centres of two particles come within `reach` [m] of each other while both are on the straight pieces
    /// `one` and `other` of their trajectories.
    fn pass(&self, one: &Segment, other: &Segment, reach: f64) -> bool {
        let (from, to) = (one.span[0].max(other.span[0]), one.span[1].min(other.span[1]));
        if from > to {
            return false;
        }
        let at = |leg: &Segment| leg.origin + leg.velocity * from;
        let (apart, relative) = self.domain.relative(&at(one), &at(other), one.velocity - other.velocity, from);
        let nearest = -apart.dot(&relative) / relative.norm_squared();
        // at equal velocities the distance is constant, and the quotient is not finite
        let nearest = if nearest.is_finite() { nearest.clamp(0.0, to - from) } else { 0.0 };
        let way = (one.velocity.norm() + other.velocity.norm()) * self.part;
        let reach = (reach + way * NEARLY) * (1.0 + NEARLY);
        (apart + relative * nearest).norm_squared() < reach * reach
    }
}
