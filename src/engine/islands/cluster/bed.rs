//! What lies beside a crowd is taken into it before it is pushed.

use super::{Clusters, Member};

/// [-] gap over the distance of touch below which a particle beside a crowd is taken into it: so few are so near in a gas that it costs
/// little, and it spares doing a crowd again for each that it pushes.
const BESIDE: f64 = 0.05;

/// Members that became hot late stand in no cells, and whoever looks around asks each of them: when they are more than this and an eighth of
/// those in cells, all are sorted into cells again.
const MANY_LATE: usize = 64;

impl Clusters<'_> {
    /// Takes into a crowd what lies beside its members, what lies beside that, and so on. Who joins may make all of them faster, and then
    /// more is beside them: members whose reach has grown look again, so that it does not matter who looked first.
    pub(super) fn take_in_beside(&mut self, which: usize) {
        loop {
            let before = self.clusters[which].hot.len();
            let mut next = 0;
            // those who join stand behind the others, and look in their turn
            while let Some(&member) = self.clusters[which].hot.get(next) {
                next += 1;
                for place in self.find_beside(member) {
                    self.take_in(which, place);
                }
            }
            if self.clusters[which].hot.len() == before {
                break;
            }
            self.settle(which);
        }
        if self.members.len() - self.sorted.len() > MANY_LATE + self.sorted.len() / 8 {
            self.sort();
        }
    }

    /// Makes a particle, by place, a member of a crowd.
    fn take_in(&mut self, which: usize, place: u32) {
        if self.search.label[place as usize].is_none() {
            let alone = self.cluster_of(place);
            self.unite(which, alone);
            self.settle_member(self.members.len() as u32 - 1);
        }
    }

    /// Particles in no island, by place, that a member of a crowd might hit and that lie beside it; none if it has looked already.
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

    /// Whether two particles, by place, are so near that contacts which last would soon bring them together.
    fn is_beside(&self, one: u32, other: u32) -> bool {
        let [a, b] =
            [one, other].map(|place| (self.particles.position[place as usize], self.particles.radius[place as usize]));
        self.domain.separation(&a.0, &b.0).norm() < (1.0 + BESIDE) * (a.1 + b.1)
    }
}
