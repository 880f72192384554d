//! Pairs of particles whose centres are near each other, for measurements of the structure.

use crate::domain::Domain;
use crate::neighbours::cells::CellGrid;
use crate::neighbours::region::Region;
use crate::particles::Particles;
use crate::work_sharing;
use nalgebra::Vector3;

/// Number of particles in one piece of work, whose pairs one thread visits.
const PIECE: usize = 512;

/// Calls `visit` once for each pair of particles whose centres are less than `reach` [m] apart. It gets the value of
/// the part, the indices of the two particles, and the vector [m] from the first particle to the nearest image of the
/// second. Along periodic axes, `reach` is at most half the edge of the box. The pairs are divided into parts, which do
/// not depend on the number of threads. The value of each part begins as that of `none`. The values of all parts are
/// returned in order.
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
