//! Growth of a crowd, an island so large that it is moved by uniform steps. Particles next to the crowd are added to
//! it, so that it need not be solved again when it pushes them.

use super::Member;
use super::bounded::BoundedIslands;

/// [-] limit of the gap between a member of a crowd (an island moved by uniform steps) and a particle that is added to
/// the crowd, divided by the distance of their centres at touch. In a gas few particles are so near, so adding them
/// costs little. Otherwise the crowd would be solved again for each particle that it pushes.
const BESIDE: f64 = 0.05;

/// Number that, with an eighth of the members in cells added, limits the number of late members. Late members were
/// added after the members were last sorted into cells, and every search must check all of them. If there are more, all
/// members are sorted again.
const MANY_LATE: usize = 64;

impl BoundedIslands<'_> {
    /// Adds to the crowd `which` (an island moved by uniform steps) all particles next to its members, then those next
    /// to the new members, and so on. A new member may raise the speed limits, and with them the distances that all
    /// members may reach. Then the surroundings of these members are searched again, so that the result does not
    /// depend on the order of the searches.
    pub(super) fn take_in_beside(&mut self, which: usize) {
        loop {
            let before = self.list[which].hot.len();
            let mut next = 0;
            // new members are appended to the list, so the loop visits them too
            while let Some(&member) = self.list[which].hot.get(next) {
                next += 1;
                for index in self.find_beside(member) {
                    self.take_in(which, index);
                }
            }
            if self.list[which].hot.len() == before {
                break;
            }
            self.update_reach(which);
        }
        if self.members.len() - self.sorted.len() > MANY_LATE + self.sorted.len() / 8 {
            self.sort();
        }
    }

    /// Makes the particle at `index` in the store a member of the crowd `which` (an island moved by uniform steps), if
    /// the particle is in no island.
    fn take_in(&mut self, which: usize, index: u32) {
        if self.search.label[index as usize].is_none() {
            let alone = self.cluster_of(index);
            self.unite(which, alone);
            let last = self.members.len() as u32 - 1;
            self.update_reach_of_member(last);
        }
    }

    /// Indices of the particles that are in no island and that a member of a crowd (an island moved by uniform steps)
    /// may touch: the ball of their straight flight overlaps the ball of all positions that the member can have. Empty
    /// if the surroundings of the member have already been searched with the present radius of its ball.
    fn find_beside(&mut self, member: u32) -> Vec<u32> {
        let Member { index, ball, took_in, .. } = self.members[member as usize];
        let mut beside = Vec::new();
        if took_in >= ball.reach {
            return beside;
        }
        self.members[member as usize].took_in = ball.reach;
        let search = &*self.search;
        self.domain.for_each_image(&ball.middle, ball.reach + search.levels.largest_reach(), |middle| {
            search.levels.for_each_near(&middle, ball.reach, |range, _| {
                let near = search.levels.indices(range).iter().copied();
                beside.extend(near.filter(|&other| {
                    search.label[other as usize].is_none()
                        && ball.meets(&search.flights[other as usize], self.domain)
                        && self.is_beside(index, other)
                }));
            });
        });
        beside
    }

    /// True if the gap between two particles, given by index, is less than [`BESIDE`] times the distance of their
    /// centres at touch. One of them may then soon be pushed against the other.
    fn is_beside(&self, one: u32, other: u32) -> bool {
        let [a, b] =
            [one, other].map(|index| (self.particles.position[index as usize], self.particles.radius[index as usize]));
        self.domain.separation(&a.0, &b.0).norm() < (1.0 + BESIDE) * (a.1 + b.1)
    }
}
