//! Pairs of particles whose centres are near each other, for measurements of the structure.

use crate::domain::Domain;
use crate::neighbours::cells::CellGrid;
use crate::neighbours::region::Region;
use crate::particles::Particles;
use crate::work_sharing;
use nalgebra::Vector3;

/// Number of particles in one group, whose pairs one thread visits.
const PIECE: usize = 512;

/// Calls `visit` once for each pair of particles whose centres are less than `reach` [m] apart. Along periodic axes,
/// `reach` is at most half the edge of the box. The pairs are divided into groups, which do not depend on the number of
/// threads. Each group has a value, which `none` makes and `visit` changes; the values of all groups are returned in
/// order. The arguments of `visit` are the value of the group, the indices of the two particles, and a vector [m]. The
/// vector leads from the first particle to the nearest image of the second.
pub(super) fn near_pairs<A: Send>(
    particles: &Particles,
    domain: &Domain,
    reach: f64,
    none: impl Fn() -> A + Sync,
    visit: impl Fn(&mut A, [usize; 2], Vector3<f64>) + Sync,
) -> Vec<A> {
    // images across sheared sides are visited one by one, so that here these sides are not periodic
    let joined = Domain::new(domain.size, domain.joined());
    let positions: Vec<Vector3<f64>> = particles.position.iter().map(|x| domain.wrap(x)).collect();
    let (grid, order) = CellGrid::new(&positions, &Region::from(domain), reach);
    work_sharing::map((0..positions.len()).step_by(PIECE), |first| {
        let mut found = none();
        for one in first..positions.len().min(first + PIECE) {
            domain.for_each_image(&positions[one], reach, |image| {
                grid.for_each_near(&image, reach, |range, _| {
                    for &other in &order[range] {
                        let other = other as usize;
                        if other > one {
                            let apart = joined.separation(&positions[other], &image);
                            if apart.norm_squared() < reach * reach {
                                visit(&mut found, [one, other], apart);
                            }
                        }
                    }
                });
            });
        }
        found
    })
}
