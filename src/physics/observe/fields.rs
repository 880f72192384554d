//! Coarse-grained fields on a grid: density, velocity, and the kinetic and the contact stress (Goldhirsch 2010,
//! Granular Matter 12, 239, here as time averages).
//!
//! ```text
//! ρ(x) = <Σ m φ(x - x_i)>      ρV(x) = <Σ m v φ(x - x_i)>      kinetic stress(x) = <Σ m v v φ(x - x_i)> - ρ V V
//! contact stress(x) = <Σ_pairs r f ∫ φ(x - x_i + s r) ds>, s from 0 to 1, r = x_i - x_j, f: force of j on i
//! ```
//!
//! The particle at x_i has the mass m and the velocity v, and <...> is an average over time. φ is a Gaussian of the
//! width w, set to zero beyond the distance 4 w. Its values at the centres of the cells are divided by their sum.
//! Mass, momentum and Σ r f are then conserved exactly: the integral of each field over the box is the sum over the
//! particles. Beside a wall, no part of a particle is assigned to places outside the box. Compression is positive. The
//! force is the elastic part of the normal force. Hard spheres have no contact stress here.

use super::contact_network::{ContactLine, contact_lines};
use super::measurements::{Measurement, Observation, ObservedCurve, ObservedGrid, ObservedNumber, ObservedQuantity};
use super::{Needs, Observer};
use crate::contact_law::ContactLaw;
use crate::domain::Domain;
use crate::experiment::{Experiment, FieldsSettings};
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::{Estimate, estimate};
use crate::stored::{StoreError, Stored};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Largest number of samples (instants of measurement) that are used. In a run with more samples, only every n-th
/// sample is used.
const MOST_SAMPLES: u64 = 400;
/// Number of blocks of time into which the run is divided. The averaging period is known only after the run, so it is
/// made to begin at the start of a block.
const BLOCKS: f64 = 20.0;
/// [-] distance beyond which the Gaussian weight of a particle counts as zero, in widths of the Gaussian.
const REACH: f64 = 4.0;
/// [-] largest distance between neighbouring points along a contact at which the Gaussian is evaluated, in widths of
/// the Gaussian. The relative error of the midpoint rule is then a hundredth.
const STEP: f64 = 0.5;
/// Number of sums of a cell of the grid: mass, three of momentum, six of products of velocities, and six of products of
/// distance and force in contacts.
const SUMS: usize = 16;
/// Indices of the two axes of each component of a stress, in the order xx, yy, zz, xy, xz, yz.
const AXES: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]];

/// Sums of mass, momentum and stress in each cell of the grid over the instants of measurement in one block of time.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct FieldBlock {
    /// [s] simulated time of the first instant of measurement in the block.
    from: f64,
    /// Number of instants of measurement in the block.
    samples: u64,
    /// Sums of mass, momentum and stress of each cell. The index along x changes first from cell to cell, then that
    /// along y.
    sums: Vec<[f64; SUMS]>,
}

/// Measurement of density, velocity and stress in the cells of a grid, at several instants of a run.
#[derive(Clone, Debug)]
pub struct Fields {
    /// [s] time between two instants of measurement.
    interval: f64,
    /// [s] duration of a block of time, over which the fields are averaged.
    length: f64,
    /// [m] width w of the Gaussian that weights the particles.
    width: f64,
    cells: [usize; 3],
    law: Option<ContactLaw>,
    blocks: Vec<FieldBlock>,
}

/// Values of all coarse-grained fields in one cell of the grid.
struct CellFields {
    /// [kg/m³] mass of the particles per volume of the cell.
    density: f64,
    /// [m/s] momentum of the particles over their mass in the cell; 0 in an empty cell.
    velocity: Vector3<f64>,
    /// [Pa] components of the kinetic stress, positive for compression, in the order of [`AXES`].
    kinetic: [f64; 6],
    /// [Pa] components of the contact stress, positive for compression, in the order of [`AXES`].
    contact: [f64; 6],
}

impl CellFields {
    /// Computes the fields of a cell with the volume `volume` [m³]. `sums` holds the [`SUMS`] sums of mass, momentum
    /// and stress of the cell, averaged over time.
    fn of(sums: &[f64; SUMS], volume: f64) -> Self {
        let per_volume = sums.map(|sum| sum / volume);
        let density = per_volume[0];
        let momentum = Vector3::new(per_volume[1], per_volume[2], per_volume[3]);
        let velocity = if density > 0.0 { momentum / density } else { Vector3::zeros() };
        Self {
            density,
            velocity,
            kinetic: std::array::from_fn(|k| per_volume[4 + k] - density * velocity[AXES[k][0]] * velocity[AXES[k][1]]),
            contact: std::array::from_fn(|k| per_volume[10 + k]),
        }
    }
}

impl Fields {
    /// Creates the measurement for a run of `experiment`. `schedule` contains the instants of measurement.
    pub fn new(experiment: &Experiment, schedule: &Schedule, settings: FieldsSettings) -> Self {
        Self {
            interval: schedule.spacing(MOST_SAMPLES),
            length: experiment.run.duration / BLOCKS,
            width: settings.width,
            cells: settings.cells,
            law: experiment.law(),
            blocks: Vec::new(),
        }
    }

    /// Cells along an axis among which the mass of a particle at the coordinate `x` [m] is divided: index of each cell,
    /// and its share [-]. The shares add up to one.
    fn shares(&self, domain: &Domain, axis: usize, x: f64) -> Vec<(usize, f64)> {
        let (count, size) = (self.cells[axis], domain.size[axis] / self.cells[axis] as f64);
        let own = x / size - 0.5;
        let reach = REACH * self.width / size;
        let (first, last) = ((own - reach).ceil() as i64, (own + reach).floor() as i64);
        let (first, last) = (first.min(own.round() as i64), last.max(own.round() as i64));
        let inside = |cell: i64| match domain.periodic[axis] {
            true => Some(cell.rem_euclid(count as i64) as usize),
            false => usize::try_from(cell).ok().filter(|cell| *cell < count),
        };
        // exponents are relative to that of the nearest cell, since a narrow Gaussian would be rounded to zero at all
        // centres
        let exponent = |cell: i64| 0.5 * ((cell as f64 - own) * size / self.width).powi(2);
        let nearest = exponent((own.round() as i64).clamp(first, last));
        let mut shares: Vec<(usize, f64)> =
            (first..=last).filter_map(|cell| Some((inside(cell)?, (nearest - exponent(cell)).exp()))).collect();
        if shares.is_empty() {
            shares.push((if own > 0.0 { count - 1 } else { 0 }, 1.0));
        }
        let all: f64 = shares.iter().map(|(_, share)| share).sum();
        shares.iter_mut().for_each(|(_, share)| *share /= all);
        shares
    }

    /// Divides the numbers of `row`, such as mass and momentum, of a point at `place` [m] among the cells around it.
    /// In each cell, the numbers times the share [-] of the cell are added to the sums from the index `first` on.
    fn spread(&self, sums: &mut [[f64; SUMS]], domain: &Domain, place: &Vector3<f64>, first: usize, row: &[f64]) {
        let place = domain.wrap(place);
        let [x, y, z] = [0, 1, 2].map(|axis| self.shares(domain, axis, place[axis]));
        for (k, of_z) in &z {
            for (j, of_y) in &y {
                for (i, of_x) in &x {
                    let share = of_x * of_y * of_z;
                    let cell = &mut sums[i + self.cells[0] * (j + self.cells[1] * k)];
                    cell[first..].iter_mut().zip(row).for_each(|(sum, value)| *sum += share * value);
                }
            }
        }
    }

    /// Adds a contact between two particles to the contact stress of the cells along the line between the centres.
    fn spread_contact(&self, sums: &mut [[f64; SUMS]], domain: &Domain, line: &ContactLine) {
        let r = line.from - line.to;
        let force = line.normal * line.force;
        let points = (r.norm() / (STEP * self.width)).ceil().max(1.0);
        let row = AXES.map(|[i, j]| 0.5 * (r[i] * force[j] + r[j] * force[i]) / points);
        for point in 0..points as usize {
            self.spread(sums, domain, &(line.from - r * ((point as f64 + 0.5) / points)), 10, &row);
        }
    }

    /// Blocks of time that begin at `from` [s] or later. If all blocks begin earlier, only the last block is returned.
    fn used(&self, from: f64) -> &[FieldBlock] {
        let first = self.blocks.iter().position(|block| block.from >= from * (1.0 - 1e-9));
        &self.blocks[first.unwrap_or(self.blocks.len().saturating_sub(1))..]
    }
}

/// Sums of mass, momentum and stress of each cell, averaged over all instants of measurement in several blocks of
/// time.
fn mean(blocks: &[FieldBlock]) -> Vec<[f64; SUMS]> {
    let samples = blocks.iter().map(|block| block.samples).sum::<u64>().max(1) as f64;
    let count = blocks.first().map_or(0, |block| block.sums.len());
    let of = |cell: usize, k: usize| blocks.iter().map(|block| block.sums[cell][k]).sum::<f64>() / samples;
    (0..count).map(|cell| std::array::from_fn(|k| of(cell, k))).collect()
}

/// Sums of mass, momentum and stress, averaged over the cells of each layer between two planes perpendicular to y.
/// `cells` holds the numbers of cells along x, y and z.
fn layers(sums: &[[f64; SUMS]], cells: [usize; 3]) -> Vec<[f64; SUMS]> {
    let mut layers = vec![[0.0; SUMS]; cells[1]];
    for (cell, sums) in sums.iter().enumerate() {
        let own = &mut layers[cell / cells[0] % cells[1]];
        own.iter_mut().zip(sums).for_each(|(layer, sum)| *layer += sum / (cells[0] * cells[2]) as f64);
    }
    layers
}

impl Measurement for Fields {
    fn result(&self, experiment: &Experiment, from: f64) -> Observation {
        let domain = &experiment.scene.domain;
        let blocks = self.used(from);
        let spacing = Vector3::from_fn(|axis, _| domain.size[axis] / self.cells[axis] as f64);
        let volume = spacing.product();
        let all = mean(blocks);
        let by_block: Vec<Vec<[f64; SUMS]>> =
            blocks.iter().map(|block| layers(&mean(std::slice::from_ref(block)), self.cells)).collect();
        let curve = |column: &str, symbol: &str, unit: &'static str, of: fn(&CellFields) -> f64| {
            let value = |layer: usize| -> Option<Estimate> {
                let series = by_block.iter().map(|layers| of(&CellFields::of(layers.get(layer)?, volume)).into());
                estimate(&series.collect::<Option<Vec<f64>>>()?)
            };
            ObservedCurve {
                quantity: ObservedQuantity::new(column, symbol, unit),
                values: (0..self.cells[1]).map(value).collect(),
                theory: None,
                is_logarithmic: false,
            }
        };
        let mass: f64 = all.iter().map(|sums| sums[0]).sum();
        let sum_of = |counts: &[usize]| -> f64 {
            counts.iter().zip(&experiment.scene.species).map(|(n, of)| *n as f64 * of.mass()).sum()
        };
        let is_known = !experiment.scene.has_sizes() && !experiment.scene.has_openings();
        let exact = is_known.then(|| ("sum over the particles", sum_of(&experiment.counts())));
        let fields: Vec<CellFields> = all.iter().map(|sums| CellFields::of(sums, volume)).collect();
        let six = |of: fn(&CellFields) -> [f64; 6]| fields.iter().flat_map(of).collect::<Vec<_>>();
        Observation {
            name: "fields",
            title: "Coarse-grained fields",
            axis: ObservedQuantity::new("y_m", "y", "m"),
            places: (0..self.cells[1]).map(|layer| (layer as f64 + 0.5) * spacing.y).collect(),
            curves: vec![
                curve("density_kg_m3", "density", "kg/m³", |of| of.density),
                curve("velocity_z_m_s", "velocity along z", "m/s", |of| of.velocity.z),
                curve("kinetic_yy_Pa", "kinetic stress yy", "Pa", |of| of.kinetic[1]),
                curve("contact_yy_Pa", "contact stress yy", "Pa", |of| of.contact[1]),
            ],
            numbers: vec![ObservedNumber {
                quantity: ObservedQuantity::new("mass_kg", "mass of all cells", "kg"),
                value: (!all.is_empty()).then(|| Estimate::exact(mass)),
                theory: exact,
                batches: None,
            }],
            grid: (!fields.is_empty()).then(|| ObservedGrid {
                cells: self.cells,
                spacing,
                fields: vec![
                    ("density_kg_m3", 1, fields.iter().map(|of| of.density).collect()),
                    ("velocity_m_s", 3, fields.iter().flat_map(|of| <[f64; 3]>::from(of.velocity)).collect()),
                    ("kinetic_stress_Pa", 6, six(|of| of.kinetic)),
                    ("contact_stress_Pa", 6, six(|of| of.contact)),
                ],
            }),
            ..Observation::default()
        }
    }
}

impl Observer for Fields {
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        Some(now + self.interval)
    }

    fn needs(&self) -> Needs {
        Needs::Every(1)
    }

    fn see(&mut self, simulation: &Simulation) {
        let (particles, domain) = (&simulation.particles, &simulation.scene().domain);
        let is_over = |block: &FieldBlock| simulation.time >= (block.from + self.length) * (1.0 - 1e-9);
        let mut block = match self.blocks.pop() {
            Some(block) if !is_over(&block) => block,
            full => {
                self.blocks.extend(full);
                let sums = vec![[0.0; SUMS]; self.cells.iter().product()];
                FieldBlock { from: simulation.time, samples: 0, sums }
            }
        };
        // in the order of ids, since the rounding of the plain sums of a cell depends on the order
        let mut by_id: Vec<u32> = (0..particles.len() as u32).collect();
        by_id.sort_unstable_by_key(|place| particles.id[*place as usize]);
        for place in by_id.into_iter().map(|place| place as usize) {
            let (m, v) = (particles.mass[place], particles.velocity[place]);
            let products = AXES.map(|[i, j]| m * v[i] * v[j]);
            let row = [m, m * v.x, m * v.y, m * v.z];
            self.spread(&mut block.sums, domain, &particles.position[place], 0, &[row.as_slice(), &products].concat());
        }
        let lines = self.law.map_or_else(Vec::new, |law| contact_lines(simulation, &law));
        for line in lines.iter().filter(|line| line.other.is_some()) {
            self.spread_contact(&mut block.sums, domain, line);
        }
        block.samples += 1;
        self.blocks.push(block);
    }

    fn stored(&self) -> Result<Stored, StoreError> {
        Stored::of(&self.blocks)
    }

    fn restore(&mut self, stored: &Stored) -> Result<(), StoreError> {
        self.blocks = stored.read()?;
        Ok(())
    }
}
