//! Particles beside a crowd, taken into it before they are pushed.

use super::Member;
use super::bounded::BoundedIslands;

/// Gap, relative to the distance of touch, below which a particle beside a crowd is taken into it. In a gas so few
/// particles are so near that this costs little. It avoids solving the crowd again for each particle that it pushes.
const BESIDE: f64 = 0.05;

/// Number of late members, beyond an eighth of those in cells, from which all members are sorted into cells again.
/// Members that became hot late are in no cells, and each search of the surroundings has to check all of them.
const MANY_LATE: usize = 64;

impl BoundedIslands<'_> {
    /// Takes into a crowd all particles beside its members, then those beside these, and so on. A new member may raise
    /// the reach of all, and then more particles are beside them. Members whose reach has grown search again, so that
    /// the result does not depend on the order of the searches.
    pub(super) fn take_in_beside(&mut self, which: usize) {
        loop {
            let before = self.list[which].hot.len();
            let mut next = 0;
            // new members stand behind the others, and search in their turn
            while let Some(&member) = self.list[which].hot.get(next) {
                next += 1;
                for place in self.find_beside(member) {
                    self.take_in(which, place);
                }
            }
            if self.list[which].hot.len() == before {
                break;
            }
            self.settle(which);
        }
        if self.members.len() - self.sorted.len() > MANY_LATE + self.sorted.len() / 8 {
            self.sort();
        }
    }

    /// Makes a particle, given by index, a member of a crowd.
    fn take_in(&mut self, which: usize, place: u32) {
        if self.search.label[place as usize].is_none() {
            let alone = self.cluster_of(place);
            self.unite(which, alone);
            let last = self.members.len() as u32 - 1;
            self.settle_member(last);
        }
    }

    /// Indices of the particles in no island that lie beside a member of a crowd and might be hit by it. None if the
    /// member has already searched with its present reach.
    fn find_beside(&mut self, member: u32) -> Vec<u32> {
        let Member { place, ball, took_in, .. } = self.members[member as usize];
        let mut beside = Vec::new();
        if took_in >= ball.reach {
            return beside;
        }
        self.members[member as usize].took_in = ball.reach;
        let search = &*self.search;
        search.levels.for_each_near(&ball.middle, ball.reach, |range, _| {
            let near = search.levels.places(range).iter().copied();
            beside.extend(near.filter(|&other| {
                search.label[other as usize].is_none()
                    && ball.meets(&search.flights[other as usize], self.domain)
                    && self.is_beside(place, other)
            }));
        });
        beside
    }

    /// True if two particles, given by index, are so near that contacts in progress would soon bring them together.
    fn is_beside(&self, one: u32, other: u32) -> bool {
        let [a, b] =
            [one, other].map(|place| (self.particles.position[place as usize], self.particles.radius[place as usize]));
        self.domain.separation(&a.0, &b.0).norm() < (1.0 + BESIDE) * (a.1 + b.1)
    }
}
