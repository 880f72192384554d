//! Mean motion of all particles, and the test for a steady state.

use super::series::ShearStress;
use super::{Needs, Observer, plain_data};
use crate::experiment::{AverageFrom, Experiment};
use crate::simulation::Simulation;
use crate::statistics::{Batches, Estimate, Steadiness, SteadySeries, VelocitySpread, estimate, judge};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Means over all particles at every sample (instant of measurement). The test for a steady state uses these means.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Motion {
    /// Number of slices along y. Velocities in the granular temperature are relative to the mean velocity of their
    /// slice.
    slices: usize,
    /// [s] simulated times of the samples (instants of measurement).
    times: Vec<f64>,
    /// [m/s] mean velocity of all particles at every instant of measurement.
    velocity: Vec<Vector3<f64>>,
    /// [m²/s²] mean square of the velocity relative to the mean velocity of all particles, at every instant of
    /// measurement. It changes while the agitation or the velocity profile changes.
    agitation: Vec<f64>,
    /// [m²/s²] parts of the granular temperature along x, y and z at every instant of measurement; `None` where the
    /// particles are too few.
    temperature: Vec<Option<Vector3<f64>>>,
    /// Mean position [m] along x, y and z, and mean square of y [m²], at every instant of measurement.
    place: Vec<[f64; 4]>,
    /// Numbers of impacts between particles, and on walls, from the start to every instant of measurement.
    impacts: Vec<[u64; 2]>,
    /// Number of particles at every instant of measurement; empty in a scene without inlets and outlets.
    counts: Vec<f64>,
    /// Stress that opposes the shear of a sheared box, at every instant of measurement: its kinetic part [Pa], and the
    /// time integral of its contact part since the start [Pa s]. The list is empty without shear.
    stress: Vec<[f64; 2]>,
    /// True for each axis that is not periodic. Mean positions are tested only along such axes.
    bounded: [bool; 3],
    /// [m] edge lengths of the domain along x, y and z.
    size: Vector3<f64>,
    /// [m/s] rest speed: particles that are slower on average count as at rest
    /// ([`Scene::rest_speed`](crate::scene::Scene::rest_speed)).
    rest_speed: f64,
    /// [m] diameter of the smallest particles.
    diameter: f64,
}

/// Quantity that is tested for a steady state, with its values in SI units at every sample (instant of measurement).
pub struct Followed {
    /// Value at every instant of measurement.
    pub values: Vec<f64>,
    /// Scale of the quantity, in its unit. Regular changes below a thousandth of the scale do not count as a drift.
    pub scale: f64,
    /// Largest difference between the means of the two halves of the averaging period that does not count as a drift,
    /// in the unit of the quantity (see [`SteadySeries`]).
    pub step: f64,
}

impl Followed {
    fn series(&self) -> SteadySeries<'_> {
        SteadySeries { values: &self.values, scale: self.scale, step: self.step }
    }
}

/// [-] largest change of a mean position that counts as rest, in diameters of the smallest particles. Similarly, speeds
/// below a hundredth of sqrt(g d) count as rest, with gravity g and this diameter d.
const PLACE: f64 = 0.01;

impl Motion {
    /// Creates the measurement for the particles of an experiment, before the start of its run.
    pub fn new(experiment: &Experiment) -> Self {
        let domain = &experiment.scene.domain;
        Self {
            slices: experiment.statistics.slices,
            times: Vec::new(),
            velocity: Vec::new(),
            agitation: Vec::new(),
            temperature: Vec::new(),
            place: Vec::new(),
            impacts: Vec::new(),
            counts: Vec::new(),
            stress: Vec::new(),
            bounded: domain.periodic.map(|periodic| !periodic),
            size: domain.size,
            rest_speed: experiment.scene.rest_speed(),
            diameter: experiment.scene.smallest_diameter(),
        }
    }

    /// Start of averaging, which is given or detected, and the result of the test for a steady state from this start
    /// on. The test covers agitation, velocity, temperature, positions, number of particles and impact rates. `more`
    /// contains further quantities, measured by other observers at the same instants.
    pub fn steadiness(&self, asked: AverageFrom, more: Vec<Followed>) -> Steadiness {
        let from = match asked {
            AverageFrom::Time(from) => Some(from),
            AverageFrom::Steady => None,
        };
        let all: Vec<Followed> = self.series().into_iter().chain(more).collect();
        judge(&self.times, &all.iter().map(Followed::series).collect::<Vec<_>>(), from)
    }

    /// All quantities that are tested for a steady state, at every instant of measurement: agitation; velocity,
    /// temperature and position along each axis; number of particles; impact rates.
    fn series(&self) -> Vec<Followed> {
        // if momentum is conserved, the mean velocity changes only by rounding errors, which are small compared with
        // the agitation
        let agitation = self.agitation.iter().copied().fold(0.0, f64::max);
        let (speed, diameter) = (self.rest_speed, self.diameter);
        let followed = |values, scale, step| Followed { values, scale, step };
        let mut all = vec![followed(self.agitation.clone(), agitation, speed * speed)];
        for axis in 0..3 {
            all.push(followed(self.velocity.iter().map(|v| v[axis]).collect(), agitation.sqrt(), speed));
            let parts: Option<Vec<f64>> = self.temperature.iter().map(|parts| Some((*parts)?[axis])).collect();
            all.extend(parts.map(|parts| followed(parts, agitation, speed * speed)));
            let places = || self.place.iter().map(|place| place[axis]).collect();
            all.extend(self.bounded[axis].then(|| followed(places(), self.size[axis], PLACE * diameter)));
        }
        let squares = || self.place.iter().map(|place| place[3]).collect();
        let square = self.size.y * self.size.y;
        all.extend(self.bounded[1].then(|| followed(squares(), square, PLACE * diameter * self.size.y)));
        // a population that still grows or shrinks is not steady; a single particle makes no difference
        let most = self.counts.iter().copied().fold(0.0, f64::max);
        all.extend((most > 0.0).then(|| followed(self.counts.clone(), most, 1.0)));
        // particles at rest, slower on average than the rest speed, have no impact rates to be tested
        let rests = self.agitation.last().is_none_or(|last| *last < speed * speed);
        for which in 0..if rests { 0 } else { 2 } {
            let rates: Vec<f64> =
                self.impacts.windows(2).map(|pair| (pair[1][which] - pair[0][which]) as f64).collect();
            let most = rates.iter().copied().fold(0.0, f64::max);
            all.push(followed(rates, most, 0.0));
        }
        all
    }

    /// Index of the first sample (instant of measurement) at `from` [s] or later. If all samples are earlier, the
    /// number of samples.
    pub fn first(&self, from: f64) -> usize {
        self.times.iter().position(|time| *time >= from).unwrap_or(self.times.len())
    }

    /// [m²/s²] granular temperature, averaged from the sample (instant of measurement) with the index `first` to the
    /// end. `None` if the temperature is unknown at one of these samples.
    pub fn temperature(&self, first: usize) -> Option<Estimate> {
        estimate(&self.temperatures(first)?)
    }

    fn temperatures(&self, first: usize) -> Option<Vec<f64>> {
        self.temperature.iter().skip(first).map(|parts| parts.map(|parts| parts.sum() / 3.0)).collect()
    }

    /// Stress [Pa] that opposes the shear of a sheared box, averaged over blocks of time from the sample (instant of
    /// measurement) with the index `first` on. `None` without shear. The kinetic part of an interval between two
    /// samples is the mean of the values at its ends.
    pub fn stress_batches(&self, first: usize) -> Option<Batches> {
        let interval = self.times.get(1)? - self.times.first()?;
        let total = |pair: &[[f64; 2]]| 0.5 * (pair[0][0] + pair[1][0]) + (pair[1][1] - pair[0][1]) / interval;
        let totals: Vec<f64> = self.stress.get(first..)?.windows(2).map(total).collect();
        Batches::of_series(&totals, interval, *self.times.get(first)? + interval)
    }

    /// Granular temperature [m²/s²], averaged over blocks of time from the sample (instant of measurement) with the
    /// index `first` on. `None` if the temperature is unknown at one of these samples.
    pub fn batches(&self, first: usize) -> Option<Batches> {
        let interval = self.times.get(1)? - self.times.first()?;
        Batches::of_series(&self.temperatures(first)?, interval, *self.times.get(first)?)
    }
}

impl Observer for Motion {
    fn needs(&self) -> Needs {
        Needs::Sums
    }

    fn see(&mut self, simulation: &Simulation) {
        let (mean, height) = (simulation.mean_velocity(), simulation.scene().domain.size.y);
        let relative = simulation.relative_to_flow();
        let sample = simulation.sample().with(&relative);
        let spread = VelocitySpread::about(mean, sample, self.slices, height);
        let [x, y, z, square] = sample.sums(|place| {
            let at = sample.particles.position[place];
            [at.x, at.y, at.z, at.y * at.y]
        });
        if simulation.scene().has_openings() {
            self.counts.push(simulation.count() as f64);
        }
        let count = simulation.count().max(1) as f64;
        self.times.push(simulation.time);
        self.velocity.push(spread.mean());
        self.agitation.push(spread.variance());
        self.temperature.push(spread.components());
        self.place.push([x, y, z, square].map(|sum| sum / count));
        self.impacts.push([simulation.record.pairs.count, simulation.record.walls.count]);
        let domain = &simulation.scene().domain;
        if let (Some(shear), Some(stress)) = (domain.shear, ShearStress::of(simulation, None)) {
            let against = -shear.rate.signum();
            self.stress.push([against * stress.kinetic, against * stress.virial / domain.volume()]);
        }
    }

    plain_data!();
}
