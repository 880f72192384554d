//! Islands of an engine that says where flights turn: who meets whom is asked of the ways that all have gone, once islands are solved.
//!
//! Each island is solved as if there were nobody else. Where the way of a particle then comes to that of another island, or of one that was to fly
//! straight, they are one island, which is solved anew. In the end nobody meets anybody but in the islands, and then all have gone where they go together: from a start
//! there is only one way on. What an island went through before that does not matter, so it does not matter either in which order islands are united.

use super::{BATCH, Clusters, Member};
use crate::engine::islands::search::BoundingSphere;
use crate::neighbours::levels::SizeLevels;
use crate::neighbours::packed::PackedBalls;
use crate::neighbours::region::Region;
use crate::work_sharing;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// [-] of the way of both: ways that pass at less than this from a touch are taken for touching, for they are rounded.
const NEARLY: f64 = 1e-9;

/// Where a flight turns.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct VelocityChange {
    /// [s] when, since the start of the part.
    pub time: f64,
    /// [m] where the flight from then on would have been at the start of the part.
    pub origin: Vector3<f64>,
    /// [m/s] its velocity, relative to the frame of the search.
    pub velocity: Vector3<f64>,
}

/// The way of a particle through the part.
#[derive(Clone, Copy)]
pub struct ParticleTrajectory<'a> {
    /// Its place in the store.
    pub place: u32,
    /// Where it turns, in the order of time; `None`: that is not known, and it may be anywhere in its ball.
    pub turns: Option<&'a [VelocityChange]>,
}

/// The way of a hot particle as it was solved.
#[derive(Clone)]
pub struct PiecewiseTrajectory {
    /// Where it turns, among the turns that came with it, in the order of time.
    pub turns: Range<usize>,
    /// The ball that holds it from the first turn on.
    pub ball: BoundingSphere,
    /// [m] reach about the middle of the straight flight that holds all of it.
    pub around: f64,
}

/// A straight piece of a way.
struct Segment {
    /// [s] its beginning and its end.
    span: [f64; 2],
    /// [m] where it would have been at the start of the part.
    origin: Vector3<f64>,
    /// [m/s] relative to the frame of the search.
    velocity: Vector3<f64>,
}

/// The balls that hold the flights of some hot particles from their first turn on, in cells.
#[derive(Default)]
pub struct DeflectedFlights {
    /// Numbers of those members.
    members: Vec<u32>,
    levels: SizeLevels,
    packed: PackedBalls,
}

impl DeflectedFlights {
    /// Sorts the balls of `some` of all members, that are in `region`.
    fn sort(&mut self, some: Vec<u32>, all: &[Member], region: &Region) {
        let ball = |k: usize| all[some[k] as usize].ball;
        self.levels.sort_alike(&some, |&k| all[k as usize].ball.middle, |k| ball(k).reach, region);
        self.packed.fill(&self.levels.order(), |k| (ball(k).middle, ball(k).reach), region);
        self.members = some;
    }

    /// Calls `visit` with the numbers of the members whose ball overlaps another one, and of some that it only nearly does.
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
    /// The way of a member.
    pub(super) fn course(&self, member: &Member) -> ParticleTrajectory<'_> {
        ParticleTrajectory { place: member.place, turns: member.turns.clone().map(|turns| &self.turns[turns]) }
    }

    /// The way of a hot particle, by place, that turns as said; `first` is the number of the first turn.
    pub fn way(&self, place: u32, turns: &[VelocityChange], first: usize) -> PiecewiseTrajectory {
        let flight = self.search.flights[place as usize];
        let turned = first..first + turns.len();
        let Some(begin) = turns.first().map(|turn| turn.origin + turn.velocity * turn.time) else {
            return PiecewiseTrajectory { turns: turned, ball: flight, around: flight.reach };
        };
        // a ball about the middle between the beginning and the end holds all, if it holds every turn
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

    /// Takes note of where the members of an island have flown.
    pub fn follow(&mut self, which: usize, ways: &[PiecewiseTrajectory], turns: &[VelocityChange]) {
        for (number, way) in ways.iter().enumerate() {
            let first = self.turns.len();
            self.turns.extend_from_slice(&turns[way.turns.clone()]);
            let member = &mut self.members[self.clusters[which].hot[number] as usize];
            (member.ball, member.around, member.turns) = (way.ball, way.around, Some(first..self.turns.len()));
        }
    }

    /// Unites islands whose ways meet, and takes in whom they hit: those are to be solved anew. Returns how many have been solved in vain, of those that one of the
    /// particles chosen by `mine` leads; `None` if one grows too large.
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

    /// Sorts the balls of all members into cells, and again those of islands that have been solved anew since.
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

    /// Calls `visit` with the members whose ball overlaps another one, some of them twice, and with some of which it only nearly does.
    pub(super) fn for_each_turned_beside(&self, ball: &BoundingSphere, mut visit: impl FnMut(&Member)) {
        for turned in &self.turned {
            turned.for_each_beside(ball, &self.search.region, |member| visit(&self.members[member as usize]));
        }
    }

    /// Who, by place, comes to the ways of the members of an island; `None` if one goes too far.
    fn met_by(&self, which: usize) -> Option<Vec<u32>> {
        let mut met = Vec::new();
        // as long as nobody has been solved anew, whose turned flight comes to a straight one finds it
        let all_look = self.search.region.is_all() && self.turned[1].members.is_empty();
        for &member in &self.clusters[which].hot {
            let member = &self.members[member as usize];
            // beyond half a period the nearest image is not the only one to meet
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

    /// Whether two may touch on their ways, at least one of them after a turn.
    pub(super) fn may_touch(&self, one: &ParticleTrajectory, other: &ParticleTrajectory) -> bool {
        let (Some(turns), Some(others)) = (one.turns, other.turns) else { return true };
        let reach = self.particles.radius[one.place as usize] + self.particles.radius[other.place as usize];
        (0..=turns.len()).any(|number| {
            let leg = self.leg(one.place, turns, number);
            // touches on straight flights are known
            let first = usize::from(number == 0);
            (first..=others.len()).any(|number| self.pass(&leg, &self.leg(other.place, others, number), reach))
        })
    }

    /// A piece of a way, the first being the straight flight before the first turn.
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

    /// Whether two come as near as `reach` [m] while both are on these pieces of their ways.
    fn pass(&self, one: &Segment, other: &Segment, reach: f64) -> bool {
        let (from, to) = (one.span[0].max(other.span[0]), one.span[1].min(other.span[1]));
        if from > to {
            return false;
        }
        let at = |leg: &Segment| leg.origin + leg.velocity * from;
        let (apart, relative) = (self.domain.separation(&at(one), &at(other)), one.velocity - other.velocity);
        let nearest = -apart.dot(&relative) / relative.norm_squared();
        // with equal velocities they stay as far apart as they are
        let nearest = if nearest.is_finite() { nearest.clamp(0.0, to - from) } else { 0.0 };
        let way = (one.velocity.norm() + other.velocity.norm()) * self.part;
        let reach = (reach + way * NEARLY) * (1.0 + NEARLY);
        (apart + relative * nearest).norm_squared() < reach * reach
    }
}
