//! Free surface of a layer, seen from above: the waviness of its height, the wavelength and the symmetry of a pattern.
//!
//! The box is divided into columns. The height of a column is that of the highest point of any sphere whose centre is
//! in the column. Empty columns have the median height. A Gaussian smooths the heights. They are then multiplied by a
//! Hann window along both axes (weights that fall to zero at the ends) and Fourier transformed. The result is the power
//! P of each wave vector f, with the wavelength λ = 1/|f|. Let L be the longer horizontal edge of the box. Wave vectors
//! for which |f| L is near the same whole number n form a shell. The shell with the largest power among those with n >
//! 1 gives the wavelength λ = L/n. The symmetry of this shell is Q_m = |Σ P exp(i m θ)|/Σ P, with the directions θ of
//! the wave vectors. The sums are over all wave vectors for which |f| differs by at most 0.75/L from n/L. A perfect
//! pattern of stripes has Q_2 = Q_4 = Q_6 = 1, squares have Q_4 = 1 and Q_2 = 0, hexagons Q_6 = 1 and Q_2 = Q_4 = 0.
//! These are the metrics of harness/METRICS.md in the repository cbizon/granular_benchmark, where C. Bizon compares
//! codes with the patterns of Bizon et al. (1998, Phys. Rev. Lett. 80, 57).

use super::measurements::{Measurement, Observation, ObservedCurve, ObservedGrid, ObservedNumber, ObservedQuantity};
use super::{Needs, Observer, plain_data};
use crate::experiment::{Experiment, FreeSurfaceSettings};
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::estimate;
use nalgebra::Complex;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Largest number of samples (instants of measurement) that are used. In a run with more samples, only every n-th
/// sample is used.
const MOST_SAMPLES: u64 = 2000;
/// Distance at which the Gaussian that smooths the heights is cut off, in standard deviations.
const CUT: f64 = 4.0;
/// Numbers m of the symmetries Q_m: Q_m measures the m-fold symmetry of the directions of the waves in the pattern.
const ORDERS: [i32; 3] = [2, 4, 6];
/// Largest difference between |f| L of a wave vector f and the number n of the shell with the largest power, up to
/// which the wave vector counts for the symmetry. L is the longer horizontal edge of the box; the shell has |f| L near
/// n.
const HALF_WIDTH: f64 = 0.75;

/// Pattern of the free surface of a layer at one instant.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct SurfaceSample {
    /// [s] simulated time at which the surface is measured.
    time: f64,
    /// [m] standard deviation of the smoothed heights of the surface.
    contrast: f64,
    /// [m²] contribution of each shell to the variance of the height, for n = 0, 1 and so on. The shell n contains the
    /// waves of wavelengths near L/n, with the longer horizontal edge L of the box.
    power: Vec<f64>,
    /// Number n > 1 of the shell with the largest power. The waves of the shell n have wavelengths near L/n, with the
    /// longer horizontal edge L of the box. The number is 0 if the surface is flat.
    strongest: usize,
    /// Symmetries Q_2, Q_4 and Q_6 (1: perfect) of the directions of the waves in the shell with the largest power.
    symmetry: [f64; 3],
}

/// Heights [m] of all columns, row by row: the index along the first horizontal axis changes first.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct HeightMap {
    contrast: f64,
    heights: Vec<f64>,
}

/// Measurement of the height of the free surface at several instants of a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FreeSurface {
    /// [s] time between two instants at which the surface is measured.
    interval: f64,
    /// [s] half of the duration of the run. From this time on, the map with the largest contrast is kept.
    half: f64,
    /// Vertical axis (0: x, 1: y, 2: z), and the sign of the upward direction along it (+1 or -1).
    up: (usize, f64),
    /// The two horizontal axes (0: x, 1: y, 2: z), along which the layer is divided into columns.
    level: [usize; 2],
    /// Numbers of columns along the two horizontal axes. A column has one height.
    columns: [usize; 2],
    /// [m] edges of the box along the horizontal axes.
    edges: [f64; 2],
    /// True for each horizontal axis along which the box is periodic.
    periodic: [bool; 2],
    /// [m] standard deviation of the smoothing Gaussian.
    smoothing: f64,
    samples: Vec<SurfaceSample>,
    /// Map of the heights with the largest contrast (standard deviation of the smoothed heights) in the second half of
    /// the run; `None` before the first map of this half.
    map: Option<HeightMap>,
}

impl FreeSurface {
    /// Creates the measurement for a run of `experiment`. `schedule` contains the instants of measurement.
    pub fn new(experiment: &Experiment, schedule: &Schedule, settings: FreeSurfaceSettings) -> Self {
        let domain = &experiment.scene.domain;
        let up = settings.up;
        let level = [0, 1, 2].into_iter().filter(|axis| *axis != up.0).collect::<Vec<_>>();
        let level = [level[0], level[1]];
        let edges = level.map(|axis| domain.size[axis]);
        Self {
            interval: schedule.spacing(MOST_SAMPLES),
            half: 0.5 * experiment.run.duration,
            up,
            level,
            columns: edges.map(|edge| (edge / settings.spacing).round().max(1.0) as usize),
            edges,
            periodic: level.map(|axis| domain.periodic[axis]),
            smoothing: settings.smoothing,
            samples: Vec::new(),
            map: None,
        }
    }

    /// Heights [m] of all columns at the present instant, without smoothing. `None` without a particle.
    fn heights(&self, simulation: &Simulation) -> Option<Vec<f64>> {
        let ([across, along], (axis, sign)) = (self.columns, self.up);
        let domain = &simulation.scene().domain;
        let mut heights = vec![f64::NEG_INFINITY; across * along];
        for (position, radius) in simulation.particles.position.iter().zip(&simulation.particles.radius) {
            let inside = domain.wrap(position);
            let column = |k: usize| {
                let place = inside[self.level[k]] / self.edges[k] * self.columns[k] as f64;
                (place.max(0.0) as usize).min(self.columns[k] - 1)
            };
            let highest = &mut heights[column(1) * across + column(0)];
            *highest = highest.max(sign * position[axis] + radius);
        }
        let mut occupied: Vec<f64> = heights.iter().copied().filter(|height| height.is_finite()).collect();
        occupied.sort_unstable_by(f64::total_cmp);
        let median = *occupied.get(occupied.len() / 2)?;
        heights.iter_mut().filter(|height| !height.is_finite()).for_each(|height| *height = median);
        Some(heights)
    }

    /// Smooths the heights by a Gaussian along both axes. Across periodic sides the heights continue at the opposite
    /// side; beyond other sides they are mirrored.
    fn smooth(&self, mut heights: Vec<f64>) -> Vec<f64> {
        let [across, along] = self.columns;
        for (axis, (step, lines)) in [(1, along), (across, across)].into_iter().enumerate() {
            let (count, width) = (self.columns[axis], self.smoothing / self.edges[axis] * self.columns[axis] as f64);
            let reach = (CUT * width).ceil() as i64;
            let weights: Vec<f64> = (-reach..=reach).map(|k| (-0.5 * (k as f64 / width).powi(2)).exp()).collect();
            let sum: f64 = weights.iter().sum();
            if width <= 0.0 {
                continue;
            }
            for line in 0..lines {
                let first = if axis == 0 { line * across } else { line };
                let row: Vec<f64> = (0..count).map(|k| heights[first + k * step]).collect();
                for k in 0..count {
                    let near = (-reach..=reach).zip(&weights);
                    let of = |shift: i64| row[folded(k as i64 + shift, count, self.periodic[axis])];
                    heights[first + k * step] = near.map(|(shift, weight)| weight * of(shift)).sum::<f64>() / sum;
                }
            }
        }
        heights
    }

    /// Computes the waves and the symmetry of the pattern of smoothed heights [m] at the time `time` [s].
    fn pattern(&self, time: f64, heights: &[f64]) -> SurfaceSample {
        let ([across, along], total) = (self.columns, heights.len() as f64);
        let mean = heights.iter().sum::<f64>() / total;
        let contrast = (heights.iter().map(|height| (height - mean).powi(2)).sum::<f64>() / total).sqrt();
        let [hann, other] = self.columns.map(hann_window);
        let weight = total * hann.iter().map(|w| w * w).sum::<f64>() * other.iter().map(|w| w * w).sum::<f64>();
        // the transform of real numbers at -f is the conjugate of that at f, so one half of the plane is enough
        let rows: Vec<Vec<Complex<f64>>> = heights
            .chunks(across)
            .zip(&other)
            .map(|(row, w)| {
                let row: Vec<f64> = row.iter().zip(&hann).map(|(height, v)| (height - mean) * v * w).collect();
                (0..=across / 2).map(|n| transform(n as i64, &row)).collect()
            })
            .collect();
        // with an even number of columns, the shortest wave and its conjugate are the same number of the transform
        let share = |k: usize, count: usize| if 2 * k == count { 0.5 } else { 1.0 };
        let longest = self.edges[0].max(self.edges[1]);
        let shells = shells(self.edges, self.columns);
        let half = (along / 2) as i64;
        let mut waves = Vec::new();
        for n in 0..=across / 2 {
            let column: Vec<Complex<f64>> = rows.iter().map(|row| row[n]).collect();
            let from = if n == 0 { 1 } else { -half };
            for m in from..=half {
                let counted = 2.0 * share(n, across) * share(m.unsigned_abs() as usize, along);
                let power = counted * transform(m, &column).norm_sqr() / weight;
                let f = [n as f64 / self.edges[0] * longest, m as f64 / self.edges[1] * longest];
                waves.push((f[0].hypot(f[1]), f[1].atan2(f[0]), power));
            }
        }
        let mut power = vec![0.0; shells + 1];
        for (f, _, own) in &waves {
            if let Some(shell) = power.get_mut(f.round() as usize) {
                *shell += own;
            }
        }
        let strongest = (2..power.len()).max_by(|a, b| power[*a].total_cmp(&power[*b])).unwrap_or(0);
        let strongest = if power.get(strongest).is_some_and(|power| *power > 0.0) { strongest } else { 0 };
        let near = |wave: &&(f64, f64, f64)| (wave.0 - strongest as f64).abs() <= HALF_WIDTH;
        let all: f64 = waves.iter().filter(near).map(|wave| wave.2).sum();
        let symmetry = ORDERS.map(|m| {
            let turned = |wave: &(f64, f64, f64)| Complex::from_polar(wave.2, f64::from(m) * wave.1);
            waves.iter().filter(near).map(turned).sum::<Complex<f64>>().norm() / all
        });
        SurfaceSample { time, contrast, power, strongest, symmetry }
    }
}

/// Index of the column at `place`, which may be beyond the ends of a row of `count` columns. A periodic row is repeated
/// beyond its ends; any other row is mirrored there.
fn folded(place: i64, count: usize, is_periodic: bool) -> usize {
    let count = count as i64;
    if is_periodic {
        return place.rem_euclid(count) as usize;
    }
    // mirrors at both ends repeat after two rows
    let place = place.rem_euclid(2 * count);
    place.min(2 * count - 1 - place) as usize
}

/// Largest number n of a shell. The shell n contains the waves of wavelengths near L/n, with the longer edge L of the
/// two `edges` [m]. The shortest wave has a length of two columns.
fn shells(edges: [f64; 2], columns: [usize; 2]) -> usize {
    let spacing = (edges[0] / columns[0] as f64).max(edges[1] / columns[1] as f64);
    // a part of 1e-9 is added, since the quotient of equal numbers is rounded
    (0.5 * edges[0].max(edges[1]) / spacing * (1.0 + 1e-9)).floor() as usize
}

/// Weights of a Hann window at `count` points; the weights at both ends are zero.
fn hann_window(count: usize) -> Vec<f64> {
    let ends = (count as f64 - 1.0).max(1.0);
    (0..count).map(|k| 0.5 - 0.5 * (TAU * k as f64 / ends).cos()).collect()
}

/// Discrete Fourier transform of a row at the index n: the sum Σ h_k exp(-2π i n k/N) over the N entries h_k.
fn transform<T: Copy + Into<Complex<f64>>>(n: i64, row: &[T]) -> Complex<f64> {
    let count = row.len() as i64;
    let phase = |k: i64| -2.0 * PI * ((n * k).rem_euclid(count)) as f64 / count as f64;
    row.iter().zip(0..).map(|(value, k)| (*value).into() * Complex::cis(phase(k))).sum()
}

/// Time [s] of the first of the `samples`, and mean time [s] between two of them, some of which may have been left out.
/// `alone` has the two times for less than two samples.
fn clock(samples: &[&SurfaceSample], alone: [f64; 2]) -> [f64; 2] {
    match samples {
        [first, .., last] => [first.time, (last.time - first.time) / (samples.len() as f64 - 1.0)],
        [only] => [only.time, alone[1]],
        [] => alone,
    }
}

impl Measurement for FreeSurface {
    fn result(&self, _experiment: &Experiment, from: f64) -> Observation {
        let samples: Vec<&SurfaceSample> = self.samples.iter().filter(|sample| sample.time >= from).collect();
        let all =
            |of: &dyn Fn(&SurfaceSample) -> f64| estimate(&samples.iter().map(|sample| of(sample)).collect::<Vec<_>>());
        let contrast = all(&|sample| sample.contrast);
        // a layer that oscillates is flat at some phases of the oscillation, at which no pattern is visible
        let is_visible = |sample: &&&SurfaceSample| {
            sample.strongest > 0 && contrast.is_some_and(|mean| sample.contrast >= mean.value)
        };
        let visible: Vec<&SurfaceSample> = samples.iter().filter(is_visible).copied().collect();
        let longest = self.edges[0].max(self.edges[1]);
        let number = |(column, symbol, unit): (&str, &str, &'static str),
                      samples: &[&SurfaceSample],
                      of: &dyn Fn(&SurfaceSample) -> f64| {
            let series: Vec<f64> = samples.iter().map(|sample| of(sample)).collect();
            ObservedNumber::of_series(
                ObservedQuantity::new(column, symbol, unit),
                &series,
                clock(samples, [from, self.interval]),
                None,
            )
        };
        let shells = shells(self.edges, self.columns);
        let mut numbers = vec![
            number(("contrast", "contrast of the surface", "m"), &samples, &|sample| sample.contrast),
            number(("wavelength", "wavelength of the surface", "m"), &visible, &|sample| {
                longest / sample.strongest as f64
            }),
        ];
        numbers.extend(ORDERS.iter().enumerate().map(|(k, m)| {
            number((&format!("Q{m}"), &format!("symmetry Q_{m}"), ""), &visible, &|sample| sample.symmetry[k])
        }));
        let spacing = [0, 1].map(|k| self.edges[k] / self.columns[k] as f64);
        Observation {
            name: "free_surface",
            title: "Free surface",
            axis: ObservedQuantity::new("inverse_wavelength_1_m", "1/λ", "1/m"),
            places: (0..=shells).map(|n| n as f64 / longest).collect(),
            curves: vec![ObservedCurve {
                quantity: ObservedQuantity::new("variance_m2", "variance of the height by wavelength", "m²"),
                values: (0..=shells).map(|n| all(&|sample| sample.power[n])).collect(),
                theory: None,
                is_logarithmic: false,
            }],
            numbers,
            grid: self.map.as_ref().map(|map| {
                let (mut cells, mut edges) = ([1; 3], [spacing[0].min(spacing[1]); 3]);
                for k in 0..2 {
                    (cells[self.level[k]], edges[self.level[k]]) = (self.columns[k], spacing[k]);
                }
                ObservedGrid { cells, spacing: edges.into(), fields: vec![("height_m", 1, map.heights.clone())] }
            }),
            ..Observation::default()
        }
    }
}

impl Observer for FreeSurface {
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        Some(now + self.interval)
    }

    fn needs_velocities(&self) -> bool {
        false
    }

    fn needs(&self) -> Needs {
        Needs::Every(1)
    }

    fn see(&mut self, simulation: &Simulation) {
        let Some(heights) = self.heights(simulation) else { return };
        let heights = self.smooth(heights);
        let sample = self.pattern(simulation.time, &heights);
        let contrast = sample.contrast;
        self.samples.push(sample);
        if simulation.time >= self.half && self.map.as_ref().is_none_or(|map| contrast > map.contrast) {
            self.map = Some(HeightMap { contrast, heights });
        }
    }

    plain_data!();
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples that are left out lengthen the blocks of time of the others.
    #[test]
    fn every_second_sample_has_twice_the_interval() {
        let sample = |time| SurfaceSample { time, contrast: 0.0, power: Vec::new(), strongest: 0, symmetry: [0.0; 3] };
        let all: Vec<SurfaceSample> = (0..9).map(|k| sample(f64::from(k))).collect();
        let odd: Vec<&SurfaceSample> = all.iter().skip(1).step_by(2).collect();
        assert_eq!(clock(&all.iter().collect::<Vec<_>>(), [0.5, 3.0]), [0.0, 1.0]);
        assert_eq!(clock(&odd, [0.5, 3.0]), [1.0, 2.0]);
        assert_eq!([clock(&odd[..1], [0.5, 3.0]), clock(&[], [0.5, 3.0])], [[1.0, 3.0], [0.5, 3.0]]);
    }
}
