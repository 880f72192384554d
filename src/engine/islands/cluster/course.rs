//! Islands of an engine that reports velocity changes: encounters are found from the trajectories, after islands are
//! solved.
//!
//! Each island is solved as if it were alone. Its trajectories may then meet those of another island, or of a particle
//! that was to fly straight. In that case they form one island, which is solved again. In the end particles meet only
//! within islands. The trajectories are then those of the whole system, because an initial state has only one solution.
//! Earlier attempts leave no trace, so the order in which islands are united does not matter.

use super::{BATCH, Clusters, Member};
use crate::engine::islands::search::BoundingSphere;
use crate::neighbours::levels::SizeLevels;
use crate::neighbours::packed::PackedBalls;
use crate::neighbours::region::Region;
use crate::work_sharing;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Tolerance, relative to the paths of both particles: trajectories that miss a touch by less count as touching,
/// because of rounding.
const NEARLY: f64 = 1e-9;

/// A velocity change that ends a straight piece of flight.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct VelocityChange {
    /// Time of the change [s] since the start of the part.
    pub time: f64,
    /// Position [m] at the start of the part, extrapolated back along the new flight.
    pub origin: Vector3<f64>,
    /// New velocity [m/s], relative to the frame of the search.
    pub velocity: Vector3<f64>,
}

/// Trajectory of a particle through the part.
#[derive(Clone, Copy)]
pub struct ParticleTrajectory<'a> {
    /// Index of the particle in the store.
    pub place: u32,
    /// Velocity changes in the order of time; `None` if they are unknown and the particle may be anywhere in its ball.
    pub turns: Option<&'a [VelocityChange]>,
}

/// Trajectory of a hot particle as it was solved.
#[derive(Clone)]
pub struct PiecewiseTrajectory {
    /// Range of the velocity changes, in the list that came with the trajectory, in the order of time.
    pub turns: Range<usize>,
    /// The ball that holds the trajectory from the first velocity change on.
    pub ball: BoundingSphere,
    /// Reach [m] about the middle of the straight flight that holds the whole trajectory.
    pub around: f64,
}

/// A straight piece of a trajectory.
struct Segment {
    /// Beginning and end [s].
    span: [f64; 2],
    /// Position [m] at the start of the part, extrapolated along this piece.
    origin: Vector3<f64>,
    /// Velocity [m/s] relative to the frame of the search.
    velocity: Vector3<f64>,
}

/// Balls, in cells, that hold the flights of some hot particles from their first velocity change on.
#[derive(Default)]
pub struct DeflectedFlights {
    /// Numbers of these members.
    members: Vec<u32>,
    levels: SizeLevels,
    packed: PackedBalls,
}

impl DeflectedFlights {
    /// Sorts the balls of the members `some` of all, which are in `region`, into cells.
    fn sort(&mut self, some: Vec<u32>, all: &[Member], region: &Region) {
        let ball = |k: usize| all[some[k] as usize].ball;
        self.levels.sort_alike(&some, |&k| all[k as usize].ball.middle, |k| ball(k).reach, region);
        self.packed.fill(&self.levels.order(), |k| (ball(k).middle, ball(k).reach), region);
        self.members = some;
    }

    /// Calls `visit` with the numbers of the members whose balls overlap the given one; a few others only nearly do.
    fn for_each_beside(&self, ball: &BoundingSphere, region: &Region, mut visit: impl FnMut(u32)) {
        if self.members.is_empty() {
            return;
        }
        self.packed.for_each_beside((ball.middle, ball.reach), &self.levels, region, |numbers| {
            numbers.iter().for_each(|&k| visit(self.members[k as usize]));
        });
    }
}

impl Clusters<'_> {
    /// Trajectory of a member.
    pub fn course(&self, member: &Member) -> ParticleTrajectory<'_> {
        ParticleTrajectory { place: member.place, turns: member.turns.clone().map(|turns| &self.turns[turns]) }
    }

    /// Trajectory of a hot particle, given by index, with these velocity changes; `first` is the number of the first
    /// one.
    pub fn way(&self, place: u32, turns: &[VelocityChange], first: usize) -> PiecewiseTrajectory {
        let flight = self.search.flights[place as usize];
        let turned = first..first + turns.len();
        let Some(begin) = turns.first().map(|turn| turn.origin + turn.velocity * turn.time) else {
            return PiecewiseTrajectory { turns: turned, ball: flight, around: flight.reach };
        };
        // a ball about the middle between the beginning and the end holds the path if it holds every velocity change
        let corner = |turn: &VelocityChange| turn.origin + turn.velocity * turn.time;
        let end = turns.last().map_or(begin, |turn| turn.origin + turn.velocity * self.part);
        let middle = (begin + end) * 0.5;
        let corners = turns.iter().map(corner).chain([end]);
        let half = corners.map(|corner| (corner - middle).norm()).fold(0.0, f64::max);
        let reach = self.particles.radius[place as usize] + half * (1.0 + NEARLY);
        let ball = BoundingSphere { middle: self.domain.wrap(&middle), reach };
        let apart = self.domain.separation(&ball.middle, &flight.middle).norm();
        PiecewiseTrajectory { turns: turned, ball, around: flight.reach.max(reach + apart * (1.0 + NEARLY)) }
    }

    /// Stores the trajectories of the members of an island.
    pub fn follow(&mut self, which: usize, ways: &[PiecewiseTrajectory], turns: &[VelocityChange]) {
        for (number, way) in ways.iter().enumerate() {
            let first = self.turns.len();
            self.turns.extend_from_slice(&turns[way.turns.clone()]);
            let member = &mut self.members[self.clusters[which].hot[number] as usize];
            (member.ball, member.around, member.turns) = (way.ball, way.around, Some(first..self.turns.len()));
        }
    }

    /// Unites islands whose trajectories meet, and takes in the particles that they hit; these islands are to be solved
    /// again. Returns the number of islands solved in vain, among those whose leading particle is chosen by `mine`.
    /// Returns `None` if an island grows too large.
    pub fn meet(&mut self, mine: impl Fn(u32) -> bool) -> Option<u64> {
        if !self.traces {
            return Some(0);
        }
        let is_new = |which: &usize| {
            let cluster = &self.clusters[*which];
            cluster.alive && cluster.solved.is_some() && cluster.seen != Some(cluster.version)
        };
        let new: Vec<usize> = (0..self.clusters.len()).filter(is_new).collect();
        self.lay_out(&new);
        let this = &*self;
        let look = |some: &[usize]| some.iter().map(|&which| this.met_by(which)).collect::<Vec<_>>();
        let met = work_sharing::map(new.chunks(BATCH), look).into_iter().flatten();
        let (mut changed, mut in_vain) = (Vec::new(), 0);
        for (which, met) in new.iter().copied().zip(met) {
            let met = met?;
            if met.is_empty() {
                self.clusters[which].seen = Some(self.clusters[which].version);
            } else {
                in_vain += u64::from(self.leader(which).is_some_and(&mine));
                changed.push((self.clusters[which].hot[0] as usize, met));
            }
        }
        for (member, met) in &changed {
            for &place in met {
                let other = self.cluster_of(place);
                self.unite(self.members[*member].cluster as usize, other);
            }
        }
        let mut changed: Vec<usize> =
            changed.iter().map(|(member, _)| self.members[*member].cluster as usize).collect();
        changed.sort_unstable();
        changed.dedup();
        changed.iter().for_each(|&which| self.settle(which));
        changed.iter().all(|&which| !self.clusters[which].is_crowd()).then_some(in_vain)
    }

    /// Sorts the balls of all members into cells the first time; later only those of islands that were solved again
    /// since.
    fn lay_out(&mut self, new: &[usize]) {
        let region = &self.search.region;
        self.widest = self.members.iter().map(|member| member.around).fold(0.0, f64::max);
        let [all, anew] = &mut self.turned;
        if all.members.is_empty() {
            all.sort((0..self.members.len() as u32).collect(), &self.members, region);
            return;
        }
        let mut members = std::mem::take(&mut anew.members);
        members.extend(new.iter().flat_map(|&which| &self.clusters[which].hot));
        members.sort_unstable();
        members.dedup();
        anew.sort(members, &self.members, region);
    }

    /// Calls `visit` with the members whose balls overlap the given one. Some members come twice, and some only nearly
    /// overlap.
    pub fn for_each_turned_beside(&self, ball: &BoundingSphere, mut visit: impl FnMut(&Member)) {
        for turned in &self.turned {
            turned.for_each_beside(ball, &self.search.region, |member| visit(&self.members[member as usize]));
        }
    }

    /// Indices of the particles that meet the trajectories of an island; `None` if one of its members reaches too far.
    fn met_by(&self, which: usize) -> Option<Vec<u32>> {
        let mut met = Vec::new();
        // until an island is solved again, a deflected flight that meets a straight one finds it, so one direction is
        // enough
        let all_look = self.search.region.is_all() && self.turned[1].members.is_empty();
        for &member in &self.clusters[which].hot {
            let member = &self.members[member as usize];
            // beyond half a period, images other than the nearest may be met
            if member.around + self.widest.max(self.search.levels.largest_reach()) > self.half_period {
                return None;
            }
            let course = self.course(member);
            let touches =
                |other: &Member| other.cluster != which as u32 && self.may_touch(&course, &self.course(other));
            let mut note = |other: &Member| met.extend(touches(other).then_some(other.place));
            self.for_each_turned_beside(&member.ball, &mut note);
            if !all_look {
                self.for_each_turned_beside(&member.flight, &mut note);
            }
            self.search.for_each_beside(&member.ball, self.domain, |place| {
                let straight = ParticleTrajectory { place, turns: Some(&[]) };
                let meets = match self.search.label[place as usize] {
                    Some(label) => touches(&self.members[label.member()]),
                    None => self.may_touch(&course, &straight),
                };
                met.extend(meets.then_some(place));
            });
        }
        Some(met)
    }

    /// True if two particles may touch on their trajectories, at least one of them after a velocity change.
    pub fn may_touch(&self, one: &ParticleTrajectory, other: &ParticleTrajectory) -> bool {
        let (Some(turns), Some(others)) = (one.turns, other.turns) else { return true };
        let reach = self.particles.radius[one.place as usize] + self.particles.radius[other.place as usize];
        (0..=turns.len()).any(|number| {
            let leg = self.leg(one.place, turns, number);
            // touches on straight flights are known
            let first = usize::from(number == 0);
            (first..=others.len()).any(|number| self.pass(&leg, &self.leg(other.place, others, number), reach))
        })
    }

    /// Piece of a trajectory by number; the first is the straight flight before the first velocity change.
    fn leg(&self, place: u32, turns: &[VelocityChange], number: usize) -> Segment {
        let end = turns.get(number).map_or(self.part, |turn| turn.time);
        match number.checked_sub(1).and_then(|before| turns.get(before)) {
            Some(turn) => Segment { span: [turn.time, end], origin: turn.origin, velocity: turn.velocity },
            None => {
                let place = place as usize;
                let velocity = self.particles.velocity[place] - self.frame;
                Segment { span: [0.0, end], origin: self.particles.position[place], velocity }
            }
        }
    }

    /// True if two particles come as near as `reach` [m] while both are on these pieces of their trajectories.
    fn pass(&self, one: &Segment, other: &Segment, reach: f64) -> bool {
        let (from, to) = (one.span[0].max(other.span[0]), one.span[1].min(other.span[1]));
        if from > to {
            return false;
        }
        let at = |leg: &Segment| leg.origin + leg.velocity * from;
        let (apart, relative) = (self.domain.separation(&at(one), &at(other)), one.velocity - other.velocity);
        let nearest = -apart.dot(&relative) / relative.norm_squared();
        // with equal velocities the distance is constant
        let nearest = if nearest.is_finite() { nearest.clamp(0.0, to - from) } else { 0.0 };
        let way = (one.velocity.norm() + other.velocity.norm()) * self.part;
        let reach = (reach + way * NEARLY) * (1.0 + NEARLY);
        (apart + relative * nearest).norm_squared() < reach * reach
    }
}
