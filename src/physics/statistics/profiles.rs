//! Averages of velocity moments in slices of the box (section 2.2 of the paper, see `docs/paper.md`), with standard
//! errors. A sample is an instant at which measurements are taken.
//!
//! The velocity components are those of the paper: U, u streamwise (z); V, v wall-normal (y); W, w spanwise (x).

use super::batches::Batches;
use super::errors::{Estimate, FEWEST_BLOCKS, Removed, block_size, standard_error};
use super::profile_table::{ProfileTable, SliceRow};
use super::slice_columns::{SLICE_QUANTITIES, VELOCITY_QUANTITIES};
use super::spin_sums::{self, SPIN_QUANTITIES, SPIN_SUMS};
use crate::particles::Sample;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Number of sums over velocities per slice: the number of particles, then products of one, two and three velocity
/// components. For spheres that rotate, [`SPIN_SUMS`] sums over spins follow.
const SUMS: usize = VELOCITY_QUANTITIES;
/// Indices of the two velocity components in each second moment: 0 is u, 1 is v, 2 is w.
const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
/// Index in [`PAIRS`] of the second moment of the velocity components i and j.
const PAIR_OF: [[usize; 3]; 3] = [[0, 3, 4], [3, 1, 5], [4, 5, 2]];
/// Indices of the three velocity components in each third moment: 0 is u, 1 is v, 2 is w.
const TRIPLES: [[usize; 3]; 10] =
    [[0, 0, 0], [0, 0, 1], [0, 0, 2], [0, 1, 1], [0, 1, 2], [0, 2, 2], [1, 1, 1], [1, 1, 2], [1, 2, 2], [2, 2, 2]];
/// Largest number of blocks of time. At this number, blocks are merged two by two, so that memory stays bounded for any
/// length of the run.
const MOST_BLOCKS: usize = 512;

/// Sums of velocities and of their products over the particles of each slice, and over several successive samples
/// (instants of measurement).
#[derive(Clone, Debug, Serialize, Deserialize)]
struct SampleBlock {
    /// [s] time of the first sample (instant of measurement) in the block.
    start: f64,
    /// [s] time of the last sample (instant of measurement) in the block.
    end: f64,
    /// Number of samples (instants of measurement) in the block.
    samples: usize,
    /// Sums over the particles, `width` numbers for each slice, in SI units: velocities, relative to the reference
    /// velocity, and their products.
    sums: Vec<f64>,
}

impl SampleBlock {
    /// Adds the sums of a later block to this block.
    fn merge(&mut self, later: &SampleBlock) {
        self.end = later.end;
        self.samples += later.samples;
        add(&mut self.sums, &later.sums);
    }
}

/// Sums of all slices. `samples` is the number of particles, summed over all slices and samples (instants of
/// measurement). The density of a slice is computed from its share of this number.
struct Counted {
    sums: Vec<f64>,
    samples: f64,
}

/// Sums for each slice and each block of time, from which profiles and their standard errors are computed.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Accumulator {
    slices: usize,
    height: f64,
    /// [m/s] reference velocity (u, v, w), which is subtracted from velocities before they are multiplied. Without it,
    /// moments would be small differences of large numbers. `None` before the first call of [`Accumulator::sample`].
    reference: Option<Vector3<f64>>,
    /// Number of sums per slice: `SUMS`, or more for spheres that rotate.
    width: usize,
    /// Number of samples (instants of measurement) in a full block of time; the last block may have fewer.
    block_samples: usize,
    blocks: Vec<SampleBlock>,
}

impl Accumulator {
    /// Creates empty sums for `slices` slices of a box with the height `height` [m] along y. There is at least one
    /// slice.
    pub fn new(slices: usize, height: f64) -> Self {
        Self { slices: slices.max(1), height, reference: None, width: SUMS, block_samples: 1, blocks: Vec::new() }
    }

    /// Adds the present state of all particles to the sums, at the simulated time `time` [s]. Successive times must be
    /// equally spaced.
    ///
    /// The result depends neither on the order of the particles nor on the number of threads. A particle whose centre
    /// is outside the box counts in the nearest slice.
    pub fn sample<'a>(&mut self, time: f64, sample: impl Into<Sample<'a>>) {
        let sample = sample.into();
        let reference = *self.reference.get_or_insert_with(|| reference(sample));
        let sums = self.sum(sample, reference);
        self.width = sums.len() / self.slices;
        match self.blocks.last_mut() {
            Some(block) if block.samples < self.block_samples => {
                block.merge(&SampleBlock { start: time, end: time, samples: 1, sums });
            }
            _ => {
                if self.blocks.len() == MOST_BLOCKS {
                    self.halve();
                }
                self.blocks.push(SampleBlock { start: time, end: time, samples: 1, sums });
            }
        }
    }

    /// Merges each pair of successive blocks to one block. All blocks must be full, and their number even.
    fn halve(&mut self) {
        let mut merged = Vec::with_capacity(MOST_BLOCKS);
        let mut blocks = std::mem::take(&mut self.blocks).into_iter();
        while let Some(mut block) = blocks.next() {
            if let Some(later) = blocks.next() {
                block.merge(&later);
            }
            merged.push(block);
        }
        self.blocks = merged;
        self.block_samples *= 2;
    }

    /// Sums over the particles at one instant, one slice after the other. Velocities are relative to the velocity
    /// `reference` [m/s].
    fn sum(&self, sample: Sample, reference: Vector3<f64>) -> Vec<f64> {
        let particles = sample.particles;
        let scale = self.slices as f64 / self.height;
        // the cast turns negative numbers into 0
        let slice_of = |place: usize| ((particles.position[place].y * scale) as usize).min(self.slices - 1);
        let sums = sample.sums_in_groups(self.slices, |place| {
            let u = components(&particles.velocity[place]) - reference;
            let mut row = [1.0; SUMS];
            row[1..4].copy_from_slice(u.as_slice());
            for (k, (i, j)) in PAIRS.into_iter().enumerate() {
                row[4 + k] = u[i] * u[j];
            }
            for (k, [i, j, l]) in TRIPLES.into_iter().enumerate() {
                row[10 + k] = row[4 + PAIR_OF[i][j]] * u[l];
            }
            (slice_of(place), row)
        });
        match spin_sums::sums(sample, self.slices, slice_of) {
            None => sums.into_flattened(),
            Some(spins) => sums.iter().zip(&spins).flat_map(|(row, spins)| [&row[..], &spins[..]].concat()).collect(),
        }
    }

    /// Averages over the samples (instants of measurement) at the time `from` [s] and later; only whole blocks of time
    /// are used.
    ///
    /// Averages are computed from the sums over all these samples. The standard error of an average comes from the
    /// jackknife, since the moments are not linear in the sums. The samples are divided into n equal blocks of time:
    /// 20 to 39, or fewer in a short run. The average is also computed n times, each time without one block. The
    /// pseudo-value of a block is n times the average minus (n-1) times the average without this block. The standard
    /// error is that of the mean of the pseudo-values, with the correlation of blocks.
    pub fn table(&self, from: f64) -> ProfileTable {
        let full = self.blocks.iter().take_while(|b| b.samples == self.block_samples).count();
        // sample times are sums of many steps, and their rounding errors must not exclude a sample
        let first = self.blocks[..full].partition_point(|b| b.start < from - 1e-9 * from.abs());
        let size = block_size(full - first);
        let used = &self.blocks[first + (full - first) % size..full];
        let groups: Vec<Vec<f64>> = used
            .chunks_exact(size)
            .map(|blocks| {
                let mut sums = vec![0.0; self.slices * self.width];
                for block in blocks {
                    add(&mut sums, &block.sums);
                }
                sums
            })
            .collect();
        let mut total = vec![0.0; self.slices * self.width];
        for group in &groups {
            add(&mut total, group);
        }
        let counted = |sums: Vec<f64>| Counted { samples: sums.iter().step_by(self.width).sum(), sums };
        let groups: Vec<Counted> = groups.into_iter().map(counted).collect();
        let total = counted(total);
        let from = used.first().map_or(from, |b| b.start);
        let until = used.last().map_or(from, |b| b.end);
        let samples: usize = used.iter().map(|b| b.samples).sum();
        let interval = (until - from) / samples.saturating_sub(1).max(1) as f64;
        let frame = Batches {
            per_run: groups.len(),
            from,
            length: interval * (size * self.block_samples) as f64,
            interval,
            ..Batches::default()
        };
        let rows = (0..self.slices).map(|slice| self.row(slice, &total, &groups, &frame));
        let (slices, batches) = rows.unzip();
        ProfileTable { slices, blocks: groups.len(), from, until, batches }
    }

    /// Averages in the slice with index `slice`, from the sums `total` over the averaging period. The second result
    /// has the pseudo-values of each average, from which its standard error follows (see [`table`](Self::table)). They
    /// are `None` if the average or its error is unknown. `groups` are the sums over each block of time, and `frame`
    /// has the times of blocks.
    fn row(
        &self,
        slice: usize,
        total: &Counted,
        groups: &[Counted],
        frame: &Batches,
    ) -> (SliceRow, Vec<Option<Batches>>) {
        let here = slice * self.width..(slice + 1) * self.width;
        let reference = self.reference.unwrap_or_default();
        let (sums, all) = (&total.sums[here.clone()], total.samples);
        let values = derive(sums, all / self.slices as f64, reference);
        let count = groups.len() as f64;
        let without: Vec<[Option<f64>; SLICE_QUANTITIES]> = if groups.len() < FEWEST_BLOCKS {
            Vec::new()
        } else {
            groups
                .iter()
                .map(|group| {
                    let rest: Vec<f64> = sums.iter().zip(&group.sums[here.clone()]).map(|(t, g)| t - g).collect();
                    derive(&rest, (all - group.samples) / self.slices as f64, reference)
                })
                .collect()
        };
        let pseudo = |k: usize| {
            let value = values[k]?;
            // if only one block contains particles in this slice, no value exists without that block, so there is no
            // standard error
            let blocks = without.iter().map(|without| Some(count * value - (count - 1.0) * without[k]?));
            let blocks = blocks.collect::<Option<Vec<f64>>>().filter(|blocks| !blocks.is_empty())?;
            Some(Batches { values: vec![value], blocks: vec![blocks], ..frame.clone() })
        };
        let batches: Vec<Option<Batches>> = (0..SLICE_QUANTITIES).map(pseudo).collect();
        let estimate = |k: usize| {
            let error = batches[k].as_ref().and_then(|batches| standard_error(&batches.blocks[0], Removed::Mean));
            Some(Estimate { value: values[k]?, error })
        };
        let y = (slice as f64 + 0.5) * self.height / self.slices as f64;
        (SliceRow { y, estimates: std::array::from_fn(estimate), samples: sums[0] as u64 }, batches)
    }
}

/// Velocity components (u, v, w) of a velocity that is given along x, y and z.
fn components(velocity: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(velocity.z, velocity.y, velocity.x)
}

/// Mean velocity (u, v, w) of the particles [m/s], which later sums subtract from velocities. Any finite velocity would
/// be valid; the mean keeps the sums small.
fn reference(sample: Sample) -> Vector3<f64> {
    let mean = components(&sample.mean_velocity());
    if mean.iter().all(|c| c.is_finite()) { mean } else { Vector3::zeros() }
}

/// Adds each number of `sums` to the number of `total` with the same index.
fn add(total: &mut [f64], sums: &[f64]) {
    for (t, s) in total.iter_mut().zip(sums) {
        *t += s;
    }
}

/// Averages in one slice from its sums, in SI units: density ratio, mean velocities, central second and third moments,
/// and averages of spins. `average` is the mean number of particles per slice, and `reference` [m/s] the velocity that
/// was subtracted. The density is `None` if all slices are empty. Other averages are `None` if this slice is empty.
fn derive(sums: &[f64], average: f64, reference: Vector3<f64>) -> [Option<f64>; SLICE_QUANTITIES] {
    let count = sums[0];
    let mut values = [None; SLICE_QUANTITIES];
    if average > 0.0 {
        values[0] = Some(count / average);
    }
    if count <= 0.0 {
        return values;
    }
    let mean: [f64; 3] = std::array::from_fn(|i| sums[1 + i] / count);
    for i in 0..3 {
        values[1 + i] = Some(mean[i] + reference[i]);
    }
    let raw = |i: usize, j: usize| sums[4 + PAIR_OF[i][j]] / count;
    for (k, (i, j)) in PAIRS.into_iter().enumerate() {
        values[4 + k] = Some(raw(i, j) - mean[i] * mean[j]);
    }
    for (k, [i, j, l]) in TRIPLES.into_iter().enumerate() {
        values[10 + k] = Some(
            sums[10 + k] / count - mean[i] * raw(j, l) - mean[j] * raw(i, l) - mean[l] * raw(i, j)
                + 2.0 * mean[i] * mean[j] * mean[l],
        );
    }
    let spins = (sums.len() == SUMS + SPIN_SUMS).then(|| spin_sums::derive(&sums[SUMS..])).flatten();
    let spins: [Option<f64>; SPIN_QUANTITIES] = spins.map_or([None; SPIN_QUANTITIES], |spins| spins.map(Some));
    values[SUMS..].copy_from_slice(&spins);
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{NUMBER_DENSITY, ROTATIONAL_TEMPERATURE, SLICE_COLUMNS, SliceColumn, U, UU, slice_columns};

    const UUU: SliceColumn = SLICE_COLUMNS[10];
    use crate::particles::Particles;
    use rand::{RngExt, SeedableRng};
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn random(seed: u64) -> Xoshiro256PlusPlus {
        Xoshiro256PlusPlus::seed_from_u64(seed)
    }

    /// Spheres at random heights below `height`, with velocities of a skew distribution: u - `offset` is an exponential
    /// variable.
    fn cloud(count: usize, height: f64, offset: f64, random: &mut Xoshiro256PlusPlus) -> Particles {
        let mut particles = Particles::default();
        for _ in 0..count {
            let y = random.random::<f64>() * height;
            let (a, b): (f64, f64) = (StandardNormal.sample(random), StandardNormal.sample(random));
            let u = offset - random.random::<f64>().ln();
            particles.push(Vector3::new(0.0, y, 0.0), Vector3::new(b, a + 0.5 * u, u), 1e-4, 1e-9, 0);
        }
        particles
    }

    #[test]
    fn moments_are_those_of_the_definition() {
        let mut random = random(1);
        let mut accumulator = Accumulator::new(3, 0.3);
        let mut all: [Vec<Vector3<f64>>; 3] = Default::default();
        for step in 0..10 {
            // with an offset of 1000 m/s third moments would lose all but 6 digits if no reference velocity were
            // subtracted
            let particles = cloud(100, 0.3, 1000.0 + 0.1 * f64::from(step), &mut random);
            accumulator.sample(f64::from(step), &particles);
            for (x, v) in particles.position.iter().zip(&particles.velocity) {
                all[(x.y / 0.1) as usize].push(components(v));
            }
        }
        let table = accumulator.table(0.0);
        for (row, values) in table.slices.iter().zip(&all) {
            let n = values.len() as f64;
            let mean = values.iter().sum::<Vector3<f64>>() / n;
            assert_eq!(row.samples, values.len() as u64);
            assert!((row.of(NUMBER_DENSITY).unwrap().value - n / 1000.0 * 3.0).abs() < 1e-12);
            for i in 0..3 {
                assert!((row.estimates[1 + i].unwrap().value - mean[i]).abs() < 1e-10);
            }
            for (k, (i, j)) in PAIRS.into_iter().enumerate() {
                let exact = values.iter().map(|v| (v - mean)[i] * (v - mean)[j]).sum::<f64>() / n;
                assert!(
                    (row.estimates[4 + k].unwrap().value - exact).abs() < 1e-9,
                    "{k}: {} {exact}",
                    row.estimates[4 + k].unwrap().value
                );
            }
            for (k, [i, j, l]) in TRIPLES.into_iter().enumerate() {
                let d = |v: &Vector3<f64>| v - mean;
                let exact = values.iter().map(|v| d(v)[i] * d(v)[j] * d(v)[l]).sum::<f64>() / n;
                assert!(
                    (row.estimates[10 + k].unwrap().value - exact).abs() < 1e-9,
                    "{k}: {} {exact}",
                    row.estimates[10 + k].unwrap().value
                );
            }
        }
        assert!((table.slices[1].y - 0.15).abs() < 1e-15);
    }

    #[test]
    fn spins_of_unequal_spheres_have_the_moments_of_the_definition() {
        let mut random = random(5);
        let mut accumulator = Accumulator::new(2, 1.0);
        let mut all: [Vec<(f64, f64, Vector3<f64>)>; 2] = Default::default();
        for step in 0..8 {
            let mut particles = cloud(50, 1.0, 0.0, &mut random);
            for k in 0..particles.len() {
                particles.mass[k] *= 1.0 + random.random::<f64>();
            }
            particles.let_rotate(&[0.4]);
            for k in 0..particles.len() {
                let spin = Vector3::from_fn(|_, _| 100.0 + 30.0 * random.random::<f64>());
                particles.spin.as_mut().unwrap()[k] = spin;
                let own = (particles.mass[k], particles.inertia.as_ref().unwrap()[k], spin);
                all[usize::from(particles.position[k].y >= 0.5)].push(own);
            }
            accumulator.sample(f64::from(step), &particles);
        }
        for (row, spheres) in accumulator.table(0.0).slices.iter().zip(&all) {
            let mass: f64 = spheres.iter().map(|one| one.0).sum();
            let inertia: f64 = spheres.iter().map(|one| one.1).sum();
            let spin = spheres.iter().map(|one| one.2 * one.1).sum::<Vector3<f64>>() / inertia;
            let part = |axis: usize| spheres.iter().map(|one| one.1 * (one.2 - spin)[axis].powi(2)).sum::<f64>() / mass;
            let parts = [part(0), part(1), part(2)];
            let exact = [spin.x, spin.y, spin.z, parts.iter().sum::<f64>() / 3.0, parts[0], parts[1], parts[2]];
            for (column, exact) in slice_columns(true)[SUMS..].iter().zip(exact) {
                let found = row.of(*column).unwrap();
                assert!((found.value / exact - 1.0).abs() < 1e-12, "{}: {found:?} {exact}", column.name);
                assert!(found.error.unwrap() > 0.0);
            }
        }
        let mut smooth = Accumulator::new(2, 1.0);
        smooth.sample(0.0, &cloud(50, 1.0, 0.0, &mut random));
        assert!(smooth.table(0.0).slices[0].of(ROTATIONAL_TEMPERATURE).is_none());
    }

    #[test]
    fn averaging_starts_where_asked_and_long_runs_stay_small() {
        let mut accumulator = Accumulator::new(1, 1.0);
        let mut particles = cloud(1, 1.0, 0.0, &mut random(2));
        for step in 0..5000_u32 {
            particles.velocity[0] = Vector3::new(0.0, 0.0, if step < 2500 { 5.0 } else { 1.0 });
            accumulator.sample(f64::from(step) * 0.1, &particles);
        }
        assert!(accumulator.blocks.len() <= MOST_BLOCKS);
        let late = accumulator.table(250.0);
        assert!(late.from >= 250.0 && late.from < 260.0 + 12.5, "{}", late.from);
        assert!(late.until > 497.0 && (20..40).contains(&late.blocks));
        assert_eq!(late.slices[0].of(U).unwrap().value, 1.0);
        let whole = accumulator.table(0.0);
        assert!((whole.slices[0].of(U).unwrap().value - 3.0).abs() < 0.1);
        let none = accumulator.table(1e6);
        assert!(none.blocks == 0 && none.slices[0].of(U).is_none() && none.slices[0].samples == 0);
    }

    #[test]
    fn empty_slices_and_odd_input_do_not_panic() {
        let mut accumulator = Accumulator::new(4, 1.0);
        assert_eq!(accumulator.table(0.0).slices.len(), 4);
        accumulator.sample(0.0, &Particles::default());
        assert_eq!(accumulator.table(0.0).slices[0].of(NUMBER_DENSITY), None);
        let mut particles = Particles::default();
        for y in [-0.1, 0.0, 1.0, 1.1] {
            particles.push(Vector3::new(0.0, y, 0.0), Vector3::zeros(), 1e-3, 1e-9, 0);
        }
        let mut accumulator = Accumulator::new(4, 1.0);
        accumulator.sample(0.0, &particles);
        let table = accumulator.table(0.0);
        let density: Vec<f64> = table.slices.iter().map(|s| s.of(NUMBER_DENSITY).unwrap().value).collect();
        assert_eq!(density, [2.0, 0.0, 0.0, 2.0]);
        assert!(table.slices[1].of(U).is_none() && table.slices[0].of(U).unwrap().error.is_none());
    }

    #[test]
    fn bits_do_not_depend_on_the_number_of_threads() {
        let particles = cloud(50_000, 0.04, 12.0, &mut random(3));
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.ok().map(|pool| {
                pool.install(|| {
                    let mut accumulator = Accumulator::new(40, 0.04);
                    accumulator.sample(0.0, &particles);
                    accumulator.blocks[0].sums.iter().map(|s| s.to_bits()).collect::<Vec<_>>()
                })
            })
        };
        let one = run(1);
        assert!(one.is_some());
        assert_eq!(one, run(2));
        assert_eq!(one, run(3));
    }

    /// Tests that the standard errors agree with the scatter of averages over many runs. The velocities have a common
    /// slow fluctuation.
    #[test]
    fn errors_match_the_scatter_of_repeated_runs() {
        let mut random = random(4);
        let (runs, rho) = (400, (-1.0_f64 / 20.0).exp());
        let mut values = [const { Vec::new() }; 4];
        let mut errors = [0.0; 4];
        for _ in 0..runs {
            let mut accumulator = Accumulator::new(2, 1.0);
            let mut slow: f64 = StandardNormal.sample(&mut random);
            for step in 0..300 {
                let mut particles = cloud(20, 1.0, 0.0, &mut random);
                for v in &mut particles.velocity {
                    v.z += 0.5 * slow;
                }
                accumulator.sample(f64::from(step), &particles);
                let kick: f64 = StandardNormal.sample(&mut random);
                slow = rho * slow + (1.0 - rho * rho).sqrt() * kick;
            }
            let row = &accumulator.table(0.0).slices[0];
            for (k, e) in [NUMBER_DENSITY, U, UU, UUU].map(|column| row.of(column)).iter().enumerate() {
                let found = e.unwrap();
                values[k].push(found.value);
                errors[k] += found.error.unwrap() / f64::from(runs);
            }
        }
        for (k, name) in ["number density", "U", "uu", "uuu"].into_iter().enumerate() {
            let mean = values[k].iter().sum::<f64>() / f64::from(runs);
            let scatter = (values[k].iter().map(|v| (v - mean).powi(2)).sum::<f64>() / f64::from(runs - 1)).sqrt();
            let ratio = errors[k] / scatter;
            println!("{name}: estimated error {ratio:.3} of the scatter of {runs} runs");
            assert!((0.88..=1.25).contains(&ratio), "{name}: {ratio}");
        }
    }
}
