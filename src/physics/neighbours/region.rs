//! Region of the box that is sorted into cells: the whole box, or a block of the box if processes share a run.

use crate::domain::Domain;
use nalgebra::Vector3;

/// A block of the box whose particles are sorted into cells; it may be the whole box.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Region {
    /// [m] lowest corner of the block, relative to the lowest corner of the box.
    low: Vector3<f64>,
    /// [m] edge lengths of the block.
    size: Vector3<f64>,
    /// [m] edge of the box along each periodic axis that the block does not fill; `None` along the other axes.
    period: [Option<f64>; 3],
    /// True for each periodic axis along which the block fills the box.
    periodic: [bool; 3],
    /// True if the block is the whole box, so that no coordinates need shifting.
    is_all: bool,
}

impl From<&Domain> for Region {
    /// Makes a region that is the whole box.
    fn from(domain: &Domain) -> Self {
        Self { low: Vector3::zeros(), size: domain.size, period: [None; 3], periodic: domain.joined(), is_all: true }
    }
}

impl Region {
    /// Makes the region of all points within `width` [m] of a block inside the box, which is given by its corners `low`
    /// and `high` [m].
    pub fn around(domain: &Domain, [low, high]: [Vector3<f64>; 2], width: f64) -> Self {
        let mut region = Self::from(domain);
        for axis in 0..3 {
            let (from, to) = (low[axis] - width, high[axis] + width);
            if domain.periodic[axis] {
                if to - from < domain.size[axis] {
                    (region.low[axis], region.size[axis]) = (from, to - from);
                    region.period[axis] = Some(domain.size[axis]);
                    region.periodic[axis] = false;
                    region.is_all = false;
                }
            } else {
                let (from, to) = (from.max(0.0), to.min(domain.size[axis]));
                region.is_all &= (from, to) == (0.0, domain.size[axis]);
                (region.low[axis], region.size[axis]) = (from, to - from);
            }
        }
        region
    }

    /// [m] edge lengths of the block.
    pub fn size(&self) -> Vector3<f64> {
        self.size
    }

    /// [m³] volume of the block.
    pub fn volume(&self) -> f64 {
        self.size.product()
    }

    /// True for each axis along which the block is periodic: a particle that leaves the block on one side enters it on
    /// the opposite side.
    pub fn periodic(&self) -> [bool; 3] {
        self.periodic
    }

    /// [m] vector from the lowest corner of the block to a particle at `x` [m], or to its periodic image nearest to the
    /// block.
    #[inline]
    pub fn local(&self, x: &Vector3<f64>) -> Vector3<f64> {
        let mut local = x - self.low;
        for axis in 0..3 {
            if let Some(period) = self.period[axis] {
                let beside = 0.5 * (period - self.size[axis]);
                if local[axis] < -beside {
                    local[axis] += period;
                } else if local[axis] > self.size[axis] + beside {
                    local[axis] -= period;
                }
            }
        }
        local
    }

    /// True if the block is the whole box.
    pub fn is_all(&self) -> bool {
        self.is_all
    }

    /// [m] distance of the position `x` [m] from the nearest side of the block beyond which the box continues. The
    /// distance is infinite if the block is the whole box, and negative if `x` is outside the block.
    pub fn depth(&self, x: &Vector3<f64>, domain: &Domain) -> f64 {
        let local = self.local(x);
        (0..3).fold(f64::INFINITY, |least, axis| {
            let open = |side: f64| self.period[axis].is_some() || (side > 0.0 && side < domain.size[axis]);
            let below = if open(self.low[axis]) { local[axis] } else { f64::INFINITY };
            let above =
                if open(self.low[axis] + self.size[axis]) { self.size[axis] - local[axis] } else { f64::INFINITY };
            least.min(below).min(above)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_at_a_periodic_side_sees_both_sides_of_it() {
        let domain = Domain::new(Vector3::new(10.0, 4.0, 6.0), [true, false, true]);
        let block = [Vector3::zeros(), Vector3::new(5.0, 2.0, 6.0)];
        let region = Region::around(&domain, block, 1.0);
        assert_eq!((region.size(), region.periodic()), (Vector3::new(7.0, 3.0, 6.0), [false, false, true]));
        assert_eq!(region.local(&Vector3::new(9.5, 1.0, 5.0)), Vector3::new(0.5, 1.0, 5.0));
        assert_eq!(region.local(&Vector3::new(5.5, 1.0, 0.5)), Vector3::new(6.5, 1.0, 0.5));
        // positions beyond each side in turn, up to half of the rest of the box
        assert_eq!(region.local(&Vector3::new(8.9, 1.0, 0.5)).x.round(), 0.0);
        assert_eq!(region.depth(&Vector3::new(9.5, 1.0, 5.0), &domain), 0.5);
        // at the wall at y = 0 the box ends, so it does not count as a side
        assert_eq!(region.depth(&Vector3::new(2.5, 0.1, 0.0), &domain), 2.9);
        assert_eq!(region.depth(&Vector3::new(2.5, 2.9, 0.0), &domain), 3.0 - 2.9);
        let all = Region::around(&domain, block, 3.0);
        assert_eq!((all.size(), all.periodic()), (domain.size, [true, false, true]));
        assert_eq!(all.depth(&Vector3::new(2.5, 0.1, 0.0), &domain), f64::INFINITY);
        assert_eq!(Region::from(&domain).local(&Vector3::new(9.0, 1.0, 1.0)), Vector3::new(9.0, 1.0, 1.0));
    }
}
