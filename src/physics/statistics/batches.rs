//! Averages over a run and their covariance, computed from averages over blocks of time (method of batch means).
//! Replicas are runs with different seeds.
//!
//! Each block gives values of several averages at once. The covariance of the averages and their degrees of freedom are
//! computed from the scatter of the blocks and the correlation of neighbouring blocks.

use super::errors::{Estimate, FEWEST_BLOCKS, LARGEST_CORRELATION, block_size, inflation, mean};
use nalgebra::{DMatrix, DVector};

/// [-] largest ratio of the block lengths of two runs for which neighbouring blocks are assumed to have the same
/// correlation in both runs. The correlation is then measured in both runs together.
const SAME_LENGTH: f64 = 1.25;

/// Smallest number of independent runs from which a standard error is computed. With two runs, the tails of Student's
/// distribution are too wide for a useful error.
pub const FEWEST_RUNS: usize = 3;

/// Largest number of values with a stated standard error (see [`Batches::of_stated`]) whose errors are independent.
/// Each such value is represented by 1024 made-up runs, one more than this number. With so many runs, Student's
/// distribution is the normal distribution within 0.2 %.
pub const MOST_STATED: usize = 1023;

/// Several averages (components) over a run, or over the replicas of a run (runs with different seeds), with the
/// values in each block of time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Batches {
    /// Averages over the run or runs, one for each component, each in the unit of its component.
    pub values: Vec<f64>,
    /// Numbers of each component, one per block. Blocks are in the order of time, one replica after the other. For an
    /// average over samples, the number is the average over the block. For other quantities it is the jackknife
    /// pseudo-value: with n blocks, n times the average minus (n-1) times the average without this block. The mean of
    /// the pseudo-values equals the average up to terms of second order.
    pub blocks: Vec<Vec<f64>>,
    /// Number of successive blocks that belong to one run: all blocks, or the blocks of one replica (run with its own
    /// seed). Blocks of different runs are independent.
    pub per_run: usize,
    /// [s] start of the first block of each run.
    pub from: f64,
    /// [s] length of each block of time.
    pub length: f64,
    /// [s] time between samples (instants of measurement). The last sample of a block is one interval before its end.
    pub interval: f64,
}

impl Batches {
    /// Average and blocks of one quantity that is sampled every `interval` [s], first at the time `from` [s]. There are
    /// 20 to 39 blocks, or one for each sample if there are fewer than 40 samples. Samples at the beginning that do not
    /// fill a block are left out of the blocks, but not of the average. `None` without a sample, or if a sample is not
    /// finite.
    pub fn of_series(samples: &[f64], interval: f64, from: f64) -> Option<Self> {
        if samples.is_empty() || samples.iter().any(|sample| !sample.is_finite()) {
            return None;
        }
        let size = block_size(samples.len());
        let skipped = samples.len() % size;
        let blocks: Vec<f64> = samples[skipped..].chunks_exact(size).map(mean).collect();
        Some(Self {
            values: vec![mean(samples)],
            per_run: blocks.len(),
            blocks: vec![blocks],
            from: from + skipped as f64 * interval,
            length: size as f64 * interval,
            interval,
        })
    }

    /// Averages over independent runs, with one block per run. `values` has one list for each component: its values in
    /// all runs.
    pub fn of_runs(values: Vec<Vec<f64>>) -> Self {
        Self {
            values: values.iter().map(|runs| mean(runs)).collect(),
            blocks: values,
            per_run: 1,
            from: 0.0,
            length: 0.0,
            interval: 0.0,
        }
    }

    /// Average and blocks that represent a value with a stated standard error, both in the unit of the value. The
    /// blocks are made up so that their mean and its standard error are these numbers, as if from very many independent
    /// runs. `number` is an index of the value. Two values with different indices, both below [`MOST_STATED`], have
    /// independent errors.
    pub fn of_stated(value: f64, error: f64, number: usize) -> Self {
        let apart = error * (MOST_STATED as f64).sqrt();
        // Walsh functions: in each function, as many runs are above the value as below it, and any two functions are
        // orthogonal
        let is_above = |run: usize| (run & (1 + number % MOST_STATED)).count_ones().is_multiple_of(2);
        let blocks = (0..=MOST_STATED).map(|run| if is_above(run) { value + apart } else { value - apart }).collect();
        Self { values: vec![value], ..Self::of_runs(vec![blocks]) }
    }

    /// Number of blocks of each component.
    pub fn count(&self) -> usize {
        self.blocks.first().map_or(0, Vec::len)
    }

    /// Combines averages that have the same blocks of time into one set with all components. `None` if `parts` is
    /// empty, or if the numbers of blocks differ.
    pub fn join<'a>(parts: impl IntoIterator<Item = &'a Self>) -> Option<Self> {
        let mut parts = parts.into_iter();
        let mut whole = parts.next()?.clone();
        for part in parts {
            if part.count() != whole.count() || part.per_run != whole.per_run {
                return None;
            }
            whole.values.extend(&part.values);
            whole.blocks.extend(part.blocks.iter().cloned());
        }
        Some(whole)
    }

    /// Linear combinations of the components. Each row of `weights` has one weight [-] per component, and gives one new
    /// component.
    pub fn project(&self, weights: &[Vec<f64>]) -> Self {
        let dot = |row: &[f64], of: &dyn Fn(usize) -> f64| row.iter().enumerate().map(|(k, w)| w * of(k)).sum::<f64>();
        let values = weights.iter().map(|row| dot(row, &|k| self.values[k])).collect();
        let blocks = |row: &Vec<f64>| (0..self.count()).map(|b| dot(row, &|k| self.blocks[k][b])).collect();
        Self { values, blocks: weights.iter().map(blocks).collect(), ..*self }
    }

    /// Average of the first component, with its standard error. The error is unknown with too few blocks. `None`
    /// without a component.
    pub fn estimate(&self) -> Option<Estimate> {
        let (value, blocks) = (*self.values.first()?, self.blocks.first()?);
        if !self.tells_errors() {
            return Some(Estimate::without_error(value));
        }
        let first = Self { values: vec![value], blocks: vec![blocks.clone()], ..*self };
        let deviations = first.deviations();
        let guesses = guesses(&own_correlations(&first, &deviations), Correlation::Common);
        Some(Estimate::new(value, covariance(&first, &deviations, &guesses)[(0, 0)].sqrt()))
    }

    /// Averages over several replicas (runs with different seeds). With at least 8 runs, or if `by_runs` is true, each
    /// run is one block, and nothing is assumed about the correlation within a run. Otherwise the blocks of all runs
    /// are used, one run after the other. `by_runs` is for particles that do not mix within a run: only the scatter
    /// between runs then gives a valid error. `None` without a run.
    pub fn pool(runs: &[&Self], by_runs: bool) -> Option<Self> {
        let first = *runs.first()?;
        if runs.len() == 1 {
            return Some(first.clone());
        }
        let components = 0..first.values.len();
        let each: Vec<Vec<f64>> = components.clone().map(|k| runs.iter().map(|run| run.values[k]).collect()).collect();
        let values = each.iter().map(|values| mean(values)).collect();
        let shortest = runs.iter().map(|run| run.count()).min()?;
        if by_runs || runs.len() >= FEWEST_BLOCKS || shortest == 0 {
            return Some(Self {
                values,
                blocks: each,
                per_run: 1,
                from: first.from,
                length: first.length * shortest as f64,
                interval: first.interval,
            });
        }
        let blocks = |k: usize| runs.iter().flat_map(|run| run.blocks[k][run.count() - shortest..].to_vec()).collect();
        Some(Self { values, blocks: components.map(blocks).collect(), per_run: shortest, ..*first })
    }

    /// Weighted sum of averages of independent runs, block of time by block of time. `parts` has the averages of each
    /// run and their weight [-]. The scatter of the summed blocks is that of all runs together. `None` if `parts` is
    /// empty, or if the runs differ in the number or length of their blocks, or in the number of averages.
    pub fn sum(parts: &[(f64, &Self)]) -> Option<Self> {
        let (_, first) = parts.first()?;
        let alike = |one: &Self| {
            let lengths = (one.length - first.length).abs() <= 1e-9 * first.length;
            lengths && one.count() == first.count() && one.per_run == first.per_run
        };
        if !parts.iter().all(|(_, one)| alike(one) && one.values.len() == first.values.len()) {
            return None;
        }
        let add = |of: &dyn Fn(&Self) -> f64| parts.iter().map(|(weight, one)| weight * of(one)).sum::<f64>();
        let components = 0..first.values.len();
        let blocks = |k: usize| (0..first.count()).map(|block| add(&|one| one.blocks[k][block])).collect();
        Some(Self {
            values: components.clone().map(|k| add(&|one| one.values[k])).collect(),
            blocks: components.map(blocks).collect(),
            ..**first
        })
    }

    /// Averages up to the simulated time `time` [s]: blocks with a later sample are left out. If each run is one block,
    /// no block is left out.
    pub fn until(&self, time: f64) -> Self {
        if self.per_run <= 1 {
            return self.clone();
        }
        // sample times are sums of many steps, and their rounding errors must not exclude a block
        let blocks = (time + self.interval - self.from) / self.length * (1.0 + 1e-9);
        let last = blocks.floor().max(0.0) as usize;
        if last >= self.per_run {
            return self.clone();
        }
        let cut = |blocks: &Vec<f64>| -> Vec<f64> {
            blocks.chunks(self.per_run).flat_map(|run| run[..last.min(run.len())].to_vec()).collect()
        };
        let blocks: Vec<Vec<f64>> = self.blocks.iter().map(cut).collect();
        Self { values: blocks.iter().map(|blocks| mean(blocks)).collect(), blocks, per_run: last, ..*self }
    }

    /// True if there are enough blocks for a standard error: 8 blocks of time, or 3 runs of one block each.
    pub fn tells_errors(&self) -> bool {
        self.count() >= if self.per_run == 1 { FEWEST_RUNS } else { FEWEST_BLOCKS }
    }

    /// [s] length of time over which the averages are taken, summed over all replicas (runs with different seeds).
    pub fn span(&self) -> f64 {
        self.length * self.count() as f64
    }

    /// Deviation of each block from the mean of all blocks, in the unit of its component. The matrix has one row per
    /// block and one column per component.
    fn deviations(&self) -> DMatrix<f64> {
        let centres: Vec<f64> = self.blocks.iter().map(|blocks| mean(blocks)).collect();
        DMatrix::from_fn(self.count(), self.values.len(), |block, k| self.blocks[k][block] - centres[k])
    }

    /// [-] correlation of neighbouring blocks of the component with index `component`: mean product of their deviations
    /// divided by the mean square of the deviations.
    fn neighbours(&self, deviations: &DMatrix<f64>, component: usize) -> f64 {
        let column: Vec<f64> = deviations.column(component).iter().copied().collect();
        let square = column.iter().map(|d| d * d).sum::<f64>() / column.len() as f64;
        let products: Vec<f64> =
            column.chunks(self.per_run.max(1)).flat_map(|run| run.windows(2).map(|pair| pair[0] * pair[1])).collect();
        if square > 0.0 && !products.is_empty() { mean(&products) / square } else { 0.0 }
    }
}

/// Assumption about the correlation of neighbouring blocks of time, which may differ from component to component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Correlation {
    /// Each component has its own correlation. It is estimated from the measured value and from the distribution over
    /// all components.
    Each(Prior),
    /// All components have one common correlation, the mean of the measured values.
    Common,
}

/// Distribution of a correlation over many components (averages): its mean and its true variance. The correlation is
/// that between neighbouring blocks of time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Prior {
    /// [-] mean of the correlations over all components.
    mean: f64,
    /// [-] variance of the true correlation from component to component: the variance of the measured correlations
    /// minus the part due to chance.
    between: f64,
}

impl Prior {
    /// Distribution computed from several correlations. Each entry of `measured` has a measured correlation [-] and its
    /// variance due to chance [-].
    pub fn of(measured: &[(f64, f64)]) -> Self {
        let count = measured.len() as f64;
        if count < 2.0 {
            // with a single component the variance between components is unknown; a large value hardly changes the
            // measured correlation and its variance
            return Self { mean: measured.first().map_or(0.0, |one| one.0), between: 1.0 };
        }
        let centre = measured.iter().map(|one| one.0).sum::<f64>() / count;
        let spread = measured.iter().map(|one| (one.0 - centre).powi(2)).sum::<f64>() / (count - 1.0);
        let chance = measured.iter().map(|one| one.1).sum::<f64>() / count;
        Self { mean: centre, between: (spread - chance).max(0.0) }
    }

    /// Best estimate of a correlation, and the variance of this estimate, both [-]. `measured` is the measured
    /// correlation, and `chance` its variance due to chance. The measured value is moved towards the mean of all
    /// components (James and Stein), but by at most one standard error. A component with a high correlation thus keeps
    /// a high one (Efron and Morris 1972).
    fn guess(&self, measured: f64, chance: f64) -> (f64, f64) {
        let weight = self.between / (self.between + chance);
        let width = chance.sqrt();
        let guess = (self.mean + weight * (measured - self.mean)).clamp(measured - width, measured + width);
        (guess.clamp(0.0, LARGEST_CORRELATION), weight * chance)
    }
}

/// Difference of two independent sets of averages, with its covariance and its degrees of freedom.
#[derive(Clone, Debug)]
pub struct Contrast {
    /// Averages of the first set minus averages of the second set, each in the unit of its component.
    pub difference: DVector<f64>,
    /// Covariance matrices of the averages, one for each of the two sets.
    covariances: [DMatrix<f64>; 2],
    /// [-] degrees of freedom of the variance of each set, if the correlation of its blocks were known exactly.
    freedoms: [f64; 2],
    /// [-] inverse of the degrees of freedom that the uncertainty of the correlation alone would give. It is added to
    /// the inverse degrees of freedom of both sets.
    unsure: f64,
}

impl Contrast {
    /// Difference of the averages of `a` minus those of `b`; `None` if one of the sets has too few blocks for an error,
    /// or if the sets differ in the number of components.
    pub fn new(a: &Batches, b: &Batches, correlation: Correlation) -> Option<Self> {
        if !a.tells_errors() || !b.tells_errors() || a.values.len() != b.values.len() {
            return None;
        }
        let runs = [a, b];
        let deviations = runs.map(Batches::deviations);
        let correlations = correlations(runs, &deviations);
        let mut covariances = [DMatrix::zeros(0, 0), DMatrix::zeros(0, 0)];
        let (mut freedoms, mut unsure) = ([0.0; 2], 0.0_f64);
        for (place, run) in runs.into_iter().enumerate() {
            let count = run.count() as f64;
            let guesses: Vec<(f64, f64)> = guesses(&correlations[place], correlation);
            covariances[place] = covariance(run, &deviations[place], &guesses);
            let square = guesses.iter().map(|guess| guess.0 * guess.0).fold(0.0, f64::max);
            // degrees of freedom for which the variance of independent blocks would be as uncertain as that of this
            // exponentially correlated series
            freedoms[place] = (count - 1.0) * (1.0 - square) / (1.0 + square);
            // the inflation (1 + ρ)/(1 - ρ) of a variance by the correlation ρ has the relative variance 4 var(ρ)/(1 -
            // ρ²)²
            let relative = guesses.iter().map(|&(rho, variance)| 2.0 * variance / (1.0 - rho * rho).powi(2));
            unsure = unsure.max(relative.fold(0.0, f64::max));
        }
        let difference = DVector::from_fn(a.values.len(), |k, _| a.values[k] - b.values[k]);
        Some(Self { difference, covariances, freedoms, unsure })
    }

    /// Covariance matrix of the difference: the sum of the covariance matrices of both sets. It has one row and one
    /// column per component.
    pub fn covariance(&self) -> DMatrix<f64> {
        &self.covariances[0] + &self.covariances[1]
    }

    /// Standard error of the component of the difference with index `component`, in the unit of the component.
    pub fn error(&self, component: usize) -> f64 {
        self.covariances.iter().map(|covariance| covariance[(component, component)]).sum::<f64>().sqrt()
    }

    /// Standard error of a linear combination of the components of the difference. `direction` has the factor of each
    /// component.
    pub fn error_along(&self, direction: &DVector<f64>) -> f64 {
        (direction.transpose() * self.covariance() * direction)[0].max(0.0).sqrt()
    }

    /// [-] degrees of freedom of the estimated variance of a linear combination of the components (Welch and
    /// Satterthwaite; Yao 1965 for several components). `direction` has the factor of each component.
    pub fn freedom(&self, direction: &DVector<f64>) -> f64 {
        let parts: Vec<f64> =
            self.covariances.iter().map(|covariance| (direction.transpose() * covariance * direction)[0]).collect();
        let whole: f64 = parts.iter().sum();
        let both = parts.iter().zip(self.freedoms).map(|(part, freedom)| (part / whole).powi(2) / freedom).sum::<f64>();
        let inverse = both + self.unsure;
        if inverse.is_finite() { (1.0 / inverse).max(1.0) } else { self.freedoms.iter().sum() }
    }

    /// [-] degrees of freedom of the estimated variance of one component of the difference, for Student's t test.
    pub fn freedom_of(&self, component: usize) -> f64 {
        let mut direction = DVector::zeros(self.difference.len());
        direction[component] = 1.0;
        self.freedom(&direction)
    }
}

/// Measured correlations [-] between neighbouring blocks of time, for all components of two runs. Each has its
/// variance due to chance [-]. They are the input of [`Prior::of`]. The list is empty if a run has too few blocks for
/// an error, or if each run is one block.
pub fn measured(a: &Batches, b: &Batches) -> Vec<(f64, f64)> {
    let runs = [a, b];
    if !runs.iter().all(|run| run.tells_errors()) {
        return Vec::new();
    }
    let [first, second] = correlations(runs, &runs.map(Batches::deviations));
    // if the block lengths of the two runs are within a factor of `SAME_LENGTH`, their correlations were measured in
    // both runs together
    let both = if first == second { first } else { first.into_iter().chain(second).collect() };
    both.into_iter().filter(|one| one.1 > 0.0).collect()
}

/// Estimated correlation [-] of neighbouring blocks of each component, and the variance [-] of this estimate.
/// `measured` has the measured correlation and its variance due to chance for each component.
fn guesses(measured: &[(f64, f64)], correlation: Correlation) -> Vec<(f64, f64)> {
    match correlation {
        Correlation::Each(prior) => measured.iter().map(|&(rho, chance)| prior.guess(rho, chance)).collect(),
        Correlation::Common => {
            let count = measured.len().max(1) as f64;
            let [rho, chance] = [0, 1].map(|k| measured.iter().map(|one| [one.0, one.1][k]).sum::<f64>() / count);
            // neighbouring slices fluctuate together, so four slices count as one independent slice
            vec![(rho.clamp(0.0, LARGEST_CORRELATION), chance / (count / 4.0).max(1.0)); measured.len()]
        }
    }
}

/// Covariance matrix of the averages of a run, computed from the scatter of its blocks. `guesses` has, for each
/// component, the correlation [-] of neighbouring blocks and its variance [-].
fn covariance(run: &Batches, deviations: &DMatrix<f64>, guesses: &[(f64, f64)]) -> DMatrix<f64> {
    let count = run.count() as f64;
    // factor: variance of the mean, times the number of blocks, divided by the variance of a block. The mean follows
    // slow fluctuations, so the scatter about the mean is smaller than the variance by the factor 1 - factor/count
    let widths = guesses.iter().map(|&(rho, _)| {
        let factor = inflation(rho, run.per_run);
        (factor / (1.0 - factor / count).max(0.05)).sqrt()
    });
    let widths = DVector::from_iterator(guesses.len(), widths);
    let scatter = deviations.transpose() * deviations / (count * count);
    scatter.component_mul(&(&widths * widths.transpose()))
}

/// Measured correlation [-] between neighbouring blocks of each component of one run, with its variance [-] due to
/// chance.
fn own_correlations(run: &Batches, deviations: &DMatrix<f64>) -> Vec<(f64, f64)> {
    let count = run.count() as f64;
    let one = |component: usize| {
        if run.per_run <= 1 {
            return (0.0, 0.0);
        }
        // the measured value of a correlation ρ is too low by (1 + 3 ρ)/count, because the mean is computed from the
        // same blocks (Marriott and Pope 1954)
        let raw = run.neighbours(deviations, component);
        // the corrected value of a few blocks may lie outside of -1 to 1
        let rho = ((raw + 1.0 / count) / (1.0 - 3.0 / count)).clamp(-LARGEST_CORRELATION, LARGEST_CORRELATION);
        (rho, (1.0 - rho * rho) / count)
    };
    (0..run.values.len()).map(one).collect()
}

/// Measured correlations between neighbouring blocks in each of two runs. Each component has the correlation [-] and
/// its variance [-] due to chance. If the block lengths of the runs are within a factor of `SAME_LENGTH`, both runs get
/// the averages over the two runs.
fn correlations(runs: [&Batches; 2], deviations: &[DMatrix<f64>; 2]) -> [Vec<(f64, f64)>; 2] {
    let ratio = runs[0].length / runs[1].length;
    let alike = (1.0 / SAME_LENGTH..SAME_LENGTH).contains(&ratio) && runs.iter().all(|run| run.per_run > 1);
    let own = [0, 1].map(|place| own_correlations(runs[place], &deviations[place]));
    if !alike {
        return own;
    }
    let [first, second] = &own;
    let counts = runs.map(|run| run.count() as f64);
    let share = counts[0] / (counts[0] + counts[1]);
    let both = first.iter().zip(second).map(|(p, q)| {
        let rho = share * p.0 + (1.0 - share) * q.0;
        (rho, (1.0 - rho * rho) / (counts[0] + counts[1]))
    });
    let both: Vec<(f64, f64)> = both.collect();
    [both.clone(), both]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn values_that_alternate_give_a_finite_error() {
        for count in [8, 20, 39] {
            let alternating: Vec<f64> = (0..count).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
            let one = Batches::of_series(&alternating, 1.0, 0.0).unwrap();
            let prior = Prior::of(&measured(&one, &one));
            let contrast = Contrast::new(&one, &one, Correlation::Each(prior)).unwrap();
            // as for independent values, since no error is made smaller by a negative correlation
            let independent = (2.0 / count as f64).sqrt();
            assert!((contrast.error(0) / independent - 1.0).abs() < 0.1, "{count}: {}", contrast.error(0));
            assert!(contrast.freedom_of(0).is_finite());
        }
    }

    #[test]
    fn correlations_of_short_series_are_right_on_average() {
        const TRIALS: usize = 4000;
        const RHO: f64 = 0.4;
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut one = || {
            let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
            let mut value = normal();
            let next = |_| {
                value = RHO * value + (1.0 - RHO * RHO).sqrt() * normal();
                value
            };
            let series = Batches::of_series(&(0..20).map(next).collect::<Vec<f64>>(), 1.0, 0.0)?;
            Some(own_correlations(&series, &series.deviations())[0])
        };
        let found: Vec<(f64, f64)> = (0..TRIALS).filter_map(|_| one()).collect();
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| found.iter().map(of).sum::<f64>() / TRIALS as f64;
        let rho = mean(&|one| one.0);
        let scatter = mean(&|one| (one.0 - rho).powi(2));
        // the correction is of first order in 1/20 (20 blocks), so errors of second order remain, a few times 1/400;
        // without the correction the value would be 0.29
        let error = (scatter / TRIALS as f64).sqrt();
        assert!((rho - RHO).abs() < 3.0 * error + 4.0 / 400.0, "{rho} +- {error}");
    }
}
