//! What lies beside a crowd is taken into it before it is pushed.

use super::Clusters;

/// [-] gap over the distance of touch below which a particle beside a crowd is taken into it: so few are so near in a gas that it costs
/// little, and it spares doing a crowd again for each that it pushes.
const BESIDE: f64 = 0.05;

impl Clusters<'_> {
    /// Whether two particles, by place, are so near that contacts which last would soon bring them together.
    pub(super) fn is_beside(&self, one: u32, other: u32) -> bool {
        let [a, b] =
            [one, other].map(|place| (self.particles.position[place as usize], self.particles.radius[place as usize]));
        self.domain.separation(&a.0, &b.0).norm() < (1.0 + BESIDE) * (a.1 + b.1)
    }
}
