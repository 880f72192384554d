//! Division of the particles into parts with consecutive indices, whose events several threads process.

use std::ops::Range;

/// Division of the particles into parts, one for each thread. In the particle store, particles that are near in space
/// have near indices, so each part fills a region of the box.
#[derive(Clone, Debug, Default)]
pub struct Division {
    /// Index of the first particle of each part, followed by the number of all particles; empty if there is only one
    /// part.
    bounds: Vec<u32>,
}

impl Division {
    /// Divides `count` particles into `parts` parts, one for each thread. The parts differ in size by at most one
    /// particle.
    pub fn new(count: usize, parts: usize) -> Self {
        let bounds = if parts > 1 { (0..=parts).map(|k| (k * count / parts) as u32).collect() } else { Vec::new() };
        Self { bounds }
    }

    /// Number of parts into which the particles are divided, one for each thread.
    pub fn count(&self) -> usize {
        self.bounds.len().saturating_sub(1).max(1)
    }

    /// Number of the part (particles of one thread) to which the particle at `index` belongs.
    #[inline]
    pub fn number(&self, index: u32) -> usize {
        self.bounds
            .get(1..self.bounds.len().max(2) - 1)
            .map_or(0, |inner| inner.partition_point(|first| *first <= index))
    }

    /// Indices of the particles of the part (particles of one thread) to which the particle at `index` belongs; all
    /// indices if there is only one part.
    #[inline]
    pub fn of(&self, index: u32) -> Range<u32> {
        if self.bounds.is_empty() {
            return 0..u32::MAX;
        }
        let part = self.number(index);
        self.bounds[part]..self.bounds[part + 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_particle_belongs_to_one_part() {
        for (count, parts) in [(10, 1), (10, 2), (10, 3), (7, 7)] {
            let division = Division::new(count, parts);
            assert_eq!(division.count(), parts);
            let numbers: Vec<usize> = (0..count as u32).map(|index| division.number(index)).collect();
            assert!(numbers.is_sorted() && numbers[0] == 0 && numbers[count - 1] == parts - 1, "{numbers:?}");
            assert!((0..count as u32).all(|index| division.of(index).contains(&index)));
        }
        assert_eq!(Division::new(10, 3).of(4), 3..6);
    }
}
