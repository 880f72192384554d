//! Averages of each species in a mixture, and impacts of each pair of kinds. A kind is a species or a wall.

use super::motion::Followed;
use super::{Needs, Observer, plain_data};
use crate::experiment::Experiment;
use crate::particles::{Particles, Sample};
use crate::record::{Between, ByKinds, MeetingTotals};
use crate::scene::{Kind, Scene};
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::{Accumulator, Batches, Estimate, ProfileTable, VelocitySpread, estimate};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Means over the particles of one species, with one value per sample (instant of measurement).
#[derive(Clone, Debug, Serialize, Deserialize)]
struct OfSpecies {
    species: u16,
    /// Number of particles of the species at every instant of measurement. It changes only with inlets or outlets.
    count: Vec<f64>,
    profiles: Accumulator,
    /// [m/s] mean streamwise velocity of the species at every instant of measurement.
    velocity: Vec<f64>,
    /// [m²/s²] granular temperature of the species at every instant of measurement; `None` where the particles are too
    /// few.
    temperature: Vec<Option<f64>>,
    /// [J] mean kinetic energy of the random motion per degree of freedom of a particle, at every instant of
    /// measurement; `None` where the particles are too few. The list is empty if all particles of the species have the
    /// same mass.
    energy: Vec<Option<f64>>,
}

/// Measurements of a scene with several species, at every sample (instant of measurement): means over each species, and
/// impacts of each pair of kinds (species or walls). With one species nothing is stored, because its means are those
/// over all particles.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Kinds {
    slices: usize,
    /// [s] time between two samples (instants of measurement).
    interval: f64,
    species: Vec<OfSpecies>,
    impacts: Vec<ByKinds>,
    /// [s] times of all samples (instants of measurement).
    times: Vec<f64>,
}

/// Averages of one species over the averaging period. An average is `None` without measurements in this period.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpeciesAverages {
    /// Name of the species of particles.
    pub name: String,
    /// Number of particles of the species, as a mean over the instants of measurement; 0 without measurements.
    pub count: usize,
    /// [1/m³] mean number of particles of the species per volume of the box.
    pub number_density: f64,
    /// [m/s] mean streamwise velocity of the species.
    pub velocity: Option<Estimate>,
    /// [m²/s²] granular temperature of the species. Velocities are relative to the mean velocity of the species in the
    /// same slice along y at the same instant.
    pub temperature: Option<Estimate>,
    /// [J] mean kinetic energy of the random motion per degree of freedom of a particle: m T/2, with its mass m and the
    /// granular temperature T. If masses differ within the species, it is the mean of m (v - U)²/2 per degree of
    /// freedom, with the mean velocity U in the slice along y that contains the particle.
    pub random_energy: Option<Estimate>,
    /// Time averages in slices along y, over the particles of this species alone.
    #[serde(skip)]
    pub profiles: ProfileTable,
    /// Averages over blocks of time, in this order: mean velocity [m/s], granular temperature [m²/s²], and rate of
    /// impacts with particles [1/s].
    #[serde(skip)]
    pub batches: [Option<Batches>; 3],
}

/// Impacts between two kinds (species or walls) over the averaging period. A mean is `None` without measurements or
/// impacts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeetingAverages {
    /// Names of the two kinds: first a species, then a second species or a wall, such as `wall 0`, with its index in
    /// the case.
    pub between: [String; 2],
    /// Number of impacts between the two kinds that ended in the averaging period.
    pub count: u64,
    /// [1/s] rate of the impacts between the two kinds.
    pub rate: Option<Estimate>,
    /// [m/s] mean normal speed of approach in the impacts between the two kinds.
    pub normal_speed: Option<f64>,
    /// [-] restitution that the case prescribes for these impacts. If it depends on the speed, it is the value at the
    /// mean speed of approach.
    pub restitution_asked: f64,
    /// [-] realised restitution of the impacts between the two kinds: square root of the ratio of the normal energies
    /// after and before the impacts, both summed over the impacts.
    pub restitution: Option<f64>,
}

/// Curve over time of a quantity of one kind (species or wall) or of a pair of kinds, for the whole run.
#[derive(Clone, Debug, PartialEq)]
pub struct KindCurve {
    /// Name of the quantity that the curve shows, for reports.
    pub name: String,
    /// Unit of the quantity; empty if it has none.
    pub unit: &'static str,
    /// True if the quantity is a sum over particles, such as a number of impacts; false if it is a mean.
    pub sum: bool,
    /// Points of the curve: time [s] and value at every instant of measurement.
    pub points: Vec<(f64, f64)>,
}

impl KindCurve {
    /// Value of the curve at the time `time` [s], by linear interpolation; `None` before the first and after the last
    /// point.
    pub fn at(&self, time: f64) -> Option<f64> {
        let rounding = 1e-9 * time.abs();
        let place = self.points.partition_point(|point| point.0 < time - rounding);
        let (after, value) = *self.points.get(place)?;
        if after <= time + rounding {
            return Some(value);
        }
        let (before, first) = *self.points.get(place.checked_sub(1)?)?;
        Some(first + (value - first) * (time - before) / (after - before))
    }
}

/// Averages of each species and of each pair of kinds (species or walls) in a mixture. All lists are empty for a single
/// species.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct KindAverages {
    /// Averages of each species that has particles at the start of the run or comes in through an inlet.
    pub species: Vec<SpeciesAverages>,
    /// Averages of the impacts of each pair of kinds that had impacts.
    pub meetings: Vec<MeetingAverages>,
    /// Curves over the whole run: granular temperature of each species, and number of its impacts since the start.
    #[serde(skip)]
    pub curves: Vec<KindCurve>,
}

/// Joins the averages over blocks of time of several replicas (runs with different seeds); `None` if some run has no
/// such averages. If `by_runs` is true, each run is one block, as in [`Batches::pool`].
fn pool<'a>(runs: impl Iterator<Item = &'a Option<Batches>>, by_runs: bool) -> Option<Batches> {
    let all: Option<Vec<&Batches>> = runs.map(Option::as_ref).collect();
    Batches::pool(&all?, by_runs)
}

/// Weighted mean of `values`, each with its weight; `near` if there are no weights. The result is exactly `near` if
/// all values are equal to `near`.
fn weighted_mean(near: f64, values: impl Iterator<Item = (f64, f64)>) -> f64 {
    let add = |(sum, all): (f64, f64), (value, weight): (f64, f64)| (sum + weight * (value - near), all + weight);
    let (sum, all) = values.fold((0.0, 0.0), add);
    if all > 0.0 { near + sum / all } else { near }
}

/// Average over several replicas (runs with different seeds), given the average of each run. If `by_runs` is true, the
/// error follows from the scatter between the runs; otherwise from the errors of the runs.
fn mean_of_runs(runs: impl Iterator<Item = Option<Estimate>>, by_runs: bool) -> Option<Estimate> {
    if !by_runs {
        return Estimate::mean_of(runs);
    }
    let values: Option<Vec<f64>> = runs.map(|run| Some(run?.value)).collect();
    Batches::of_runs(vec![values?]).estimate()
}

impl KindAverages {
    /// Averages over several replicas (runs with different seeds), with the impacts of all of them. If `by_runs` is
    /// true, all errors follow from the scatter between the runs. Otherwise the errors of `profiles` and `batches` follow
    /// from the blocks of all runs, as in [`Batches::pool`], and all other errors from the errors of the runs. Curves
    /// over time are those of the first run.
    pub fn pool(runs: &[&Self], by_runs: bool) -> Self {
        let Some((first, others)) = runs.split_first() else { return Self::default() };
        let species = first.species.iter().enumerate().map(|(place, own)| {
            let each = || runs.iter().filter_map(|run| run.species.get(place));
            let mean = |of: fn(&SpeciesAverages) -> f64| weighted_mean(of(own), each().map(|one| (of(one), 1.0)));
            SpeciesAverages {
                // inlets and outlets make the numbers of particles differ between the runs
                count: mean(|one| one.count as f64).round() as usize,
                number_density: mean(|one| one.number_density),
                velocity: mean_of_runs(each().map(|one| one.velocity), by_runs),
                temperature: mean_of_runs(each().map(|one| one.temperature), by_runs),
                random_energy: mean_of_runs(each().map(|one| one.random_energy), by_runs),
                profiles: ProfileTable::pool(&each().map(|one| &one.profiles).collect::<Vec<_>>(), by_runs),
                batches: [0, 1, 2].map(|which| pool(each().map(|one| &one.batches[which]), by_runs)),
                ..own.clone()
            }
        });
        let mut meetings: Vec<MeetingAverages> = Vec::new();
        // in a run without impacts of a pair of kinds, the number of these impacts counts as zero
        let known = |one: &MeetingAverages, other: &MeetingAverages| one.between == other.between;
        let every = first.meetings.iter().chain(others.iter().flat_map(|run| &run.meetings));
        for met in every {
            if meetings.iter().any(|other| known(met, other)) {
                continue;
            }
            let of_runs: Vec<Option<&MeetingAverages>> =
                runs.iter().map(|run| run.meetings.iter().find(|other| known(met, other))).collect();
            meetings.push(MeetingAverages::pool(met, &of_runs, by_runs));
        }
        Self { species: species.collect(), meetings, curves: first.curves.clone() }
    }
}

impl MeetingAverages {
    /// Impacts of one pair of kinds (species or walls) in several runs together. `first` supplies the names and the
    /// prescribed restitution. An entry of `runs` is `None` if the pair had no impact in that run.
    fn pool(first: &Self, runs: &[Option<&Self>], by_runs: bool) -> Self {
        let met = || runs.iter().flatten();
        let count: u64 = met().map(|one| one.count).sum();
        let weighted = |of: fn(&Self) -> Option<f64>| {
            let known = || met().filter_map(|one| Some((of(one)?, one.count as f64)));
            let all: f64 = known().map(|(_, count)| count).sum();
            (all > 0.0).then(|| known().map(|(value, count)| value * count).sum::<f64>() / all)
        };
        let never = first.rate.map(|_| Estimate { value: 0.0, error: None });
        Self {
            count,
            rate: mean_of_runs(runs.iter().map(|run| run.map_or(never, |one| one.rate)), by_runs),
            normal_speed: weighted(|one| one.normal_speed),
            restitution_asked: weighted_mean(
                first.restitution_asked,
                met().map(|one| (one.restitution_asked, one.count as f64)),
            ),
            // mean of the ratios of energies after and before, weighted by the numbers of impacts; impacts of one pair
            // of kinds have similar energies
            restitution: weighted(|one| one.restitution.map(|e| e * e)).map(f64::sqrt),
            ..first.clone()
        }
    }
}

impl Kinds {
    /// Creates the measurements for an experiment, before the start of its run.
    pub fn new(experiment: &Experiment, schedule: &Schedule) -> Self {
        let (slices, height) = (experiment.statistics.slices, experiment.scene.domain.size.y);
        let of = |(species, _): (usize, usize)| OfSpecies {
            species: species as u16,
            count: Vec::new(),
            profiles: Accumulator::new(slices, height),
            velocity: Vec::new(),
            temperature: Vec::new(),
            energy: Vec::new(),
        };
        let comes_in =
            |species: usize| experiment.scene.inlets.iter().any(|inlet| usize::from(inlet.species) == species);
        let species = experiment.counts().into_iter().enumerate();
        let present = species.filter(|(species, count)| *count > 0 || comes_in(*species));
        let species: Vec<OfSpecies> = present.map(of).collect();
        let species = if species.len() > 1 { species } else { Vec::new() };
        Self { slices, interval: schedule.interval(), species, impacts: Vec::new(), times: Vec::new() }
    }

    /// Averages from the sample (instant of measurement) with the index `first`, at the time `from` [s], to the end of
    /// the run.
    pub fn averages(&self, scene: &Scene, first: usize, from: f64) -> KindAverages {
        let species = self.species.iter().map(|of| {
            let rate = Batches::of_series(&self.rates(of.species, first), self.interval, from + self.interval);
            of.averages(scene, (first, from, self.interval), rate)
        });
        let species = species.collect();
        let meetings = match (self.impacts.get(first), self.impacts.last()) {
            (Some(_), Some(last)) => last.met().map(|between| self.meeting(scene, between, first)).collect(),
            _ => Vec::new(),
        };
        KindAverages { species, meetings, curves: self.curves(scene) }
    }

    /// [1/s] rate of all impacts of a species with particles, in each interval between two samples (instants of
    /// measurement). The first interval begins at the sample with the index `first`.
    fn rates(&self, species: u16, first: usize) -> Vec<f64> {
        let counts = self.impacts.iter().skip(first).map(|sample| {
            let own = sample.met().filter(|between| takes_part(species, *between));
            own.map(|between| sample.of(between).count).sum::<u64>()
        });
        let counts: Vec<u64> = counts.collect();
        counts.windows(2).map(|pair| (pair[1] - pair[0]) as f64 / self.interval).collect()
    }

    /// Mean velocity [m/s] and granular temperature [m²/s²] of each species at every sample (instant of measurement),
    /// for the test for a steady state. The scale of the temperature, with which changes are compared, is its largest
    /// value. The scale of the velocity is the square root of this value.
    pub fn series(&self, scene: &Scene) -> Vec<Followed> {
        let speed = scene.rest_speed();
        let of = |of: &OfSpecies| {
            let temperatures: Option<Vec<f64>> = of.temperature.iter().copied().collect();
            let largest = temperatures.iter().flatten().copied().fold(0.0, f64::max);
            let velocity = Followed { values: of.velocity.clone(), scale: largest.sqrt(), step: speed };
            let temperature = |values| Followed { values, scale: largest, step: speed * speed };
            [Some(velocity), temperatures.map(temperature)]
        };
        self.species.iter().flat_map(of).flatten().collect()
    }

    fn curves(&self, scene: &Scene) -> Vec<KindCurve> {
        let of = |of: &OfSpecies| {
            let values: Option<Vec<f64>> = of.temperature.iter().copied().collect();
            let points = self.times.iter().copied().zip(values?).collect();
            let name = format!("granular temperature of {}", scene.species[usize::from(of.species)].name);
            Some(KindCurve { name, unit: "m²/s²", sum: false, points })
        };
        let met = self.impacts.last().map(|last| last.met().collect::<Vec<_>>()).unwrap_or_default();
        let impacts = |of: &OfSpecies| {
            let own: Vec<Between> = met.iter().copied().filter(|between| takes_part(of.species, *between)).collect();
            let count = |sample: &ByKinds| own.iter().map(|between| sample.of(*between).count as f64).sum();
            let name = format!("impacts of {} so far", scene.species[usize::from(of.species)].name);
            let points = self.times.iter().copied().zip(self.impacts.iter().map(count)).collect();
            KindCurve { name, unit: "", sum: true, points }
        };
        self.species.iter().filter_map(of).chain(self.species.iter().map(impacts)).collect()
    }

    fn meeting(&self, scene: &Scene, between: Between, first: usize) -> MeetingAverages {
        let samples: Vec<MeetingTotals> = self.impacts.iter().skip(first).map(|sample| sample.of(between)).collect();
        let intervals: Vec<MeetingTotals> = samples.windows(2).map(|pair| pair[1].since(&pair[0])).collect();
        let rates: Vec<f64> = intervals.iter().map(|totals| totals.count as f64 / self.interval).collect();
        let all = match samples.as_slice() {
            [before, .., after] => after.since(before),
            _ => MeetingTotals::default(),
        };
        let normal_speed = (all.count > 0).then(|| all.speed / all.count as f64);
        let surface = scene.surface(between.species, between.other);
        MeetingAverages {
            between: names(scene, between),
            count: all.count,
            rate: estimate(&rates),
            normal_speed,
            restitution_asked: normal_speed.map_or(surface.restitution, |speed| surface.restitution_at(speed)),
            restitution: (all.approach > 0.0).then(|| (all.rebound / all.approach).sqrt()),
        }
    }
}

/// Names of two kinds: first a species, then a second species or a wall, such as `wall 0`, with its index in the case.
fn names(scene: &Scene, between: Between) -> [String; 2] {
    let other = match between.other {
        Kind::Species(other) => scene.species[usize::from(other)].name.clone(),
        Kind::Wall(wall) => format!("wall {wall}"),
    };
    [scene.species[usize::from(between.species)].name.clone(), other]
}

/// True if impacts of the pair `between` are impacts of the species `species` with another particle. False for impacts
/// with walls.
fn takes_part(species: u16, between: Between) -> bool {
    match between.other {
        Kind::Species(other) => species == between.species || species == other,
        Kind::Wall(_) => false,
    }
}

impl OfSpecies {
    /// Averages of the species from the sample (instant of measurement) with the index `first` to the end. The time of
    /// this sample is `from` [s], and samples are `interval` [s] apart. `rate` is the rate of impacts with particles
    /// [1/s] in blocks of time.
    fn averages(
        &self,
        scene: &Scene,
        (first, from, interval): (usize, f64, f64),
        rate: Option<Batches>,
    ) -> SpeciesAverages {
        let species = &scene.species[usize::from(self.species)];
        let temperatures: Option<Vec<f64>> = self.temperature.iter().skip(first).copied().collect();
        let velocities = self.velocity.get(first..).unwrap_or_default();
        let of_series = |series: Option<&[f64]>| Batches::of_series(series?, interval, from);
        let batches = [of_series(Some(velocities)), of_series(temperatures.as_deref()), rate];
        let temperature = temperatures.as_ref().and_then(|temperatures| estimate(temperatures));
        let half = 0.5 * species.mass();
        let counts = self.count.get(first..).unwrap_or_default();
        let count = counts.iter().sum::<f64>() / counts.len().max(1) as f64;
        let energies: Option<Vec<f64>> = self.energy.iter().skip(first).copied().collect();
        let of_sizes = energies.filter(|energies| !energies.is_empty()).and_then(|energies| estimate(&energies));
        let of_one_size = |t: Estimate| Estimate { value: half * t.value, error: t.error.map(|error| half * error) };
        SpeciesAverages {
            name: species.name.clone(),
            count: count.round() as usize,
            number_density: count / scene.domain.volume(),
            velocity: estimate(velocities),
            batches,
            temperature,
            random_energy: match species.sizes {
                Some(_) => of_sizes,
                None => temperature.map(of_one_size),
            },
            profiles: self.profiles.table(from),
        }
    }
}

/// Copy of the positions, velocities and masses of the particles of one species, in the order of `particles`.
fn only(particles: &Particles, species: u16) -> Particles {
    let mut own = Particles::default();
    for (place, _) in particles.species.iter().enumerate().filter(|(_, own)| **own == species) {
        own.position.push(particles.position[place]);
        own.velocity.push(particles.velocity[place]);
        own.mass.push(particles.mass[place]);
    }
    own
}

/// [J] mean of m (v - U)²/2 per degree of freedom over the particles at one instant. U is the mean velocity of the
/// particles in the same slice along y. There are `slices` slices, which together have the thickness `height` [m]. The
/// mean velocity takes one degree of freedom from each slice. `None` if every slice contains at most one particle.
fn energy(sample: Sample, slices: usize, height: f64) -> Option<f64> {
    let own = sample.particles;
    let slice = |x: &Vector3<f64>| ((x.y / height * slices as f64).max(0.0) as usize).min(slices.max(1) - 1);
    let sums = sample.sums_in_groups(slices.max(1), |place| {
        let v = own.velocity[place];
        (slice(&own.position[place]), [1.0, v.x, v.y, v.z])
    });
    let visited = sums.iter().filter(|[count, ..]| *count > 0.0).count() as f64;
    let freedom = sums.iter().map(|[count, ..]| count).sum::<f64>() - visited;
    let [all] = sample.sums(|place| {
        let [count, x, y, z] = sums[slice(&own.position[place])];
        [0.5 * own.mass[place] * (own.velocity[place] - Vector3::new(x, y, z) / count).norm_squared()]
    });
    (freedom > 0.0).then(|| all / (3.0 * freedom))
}

impl Observer for Kinds {
    fn needs(&self) -> Needs {
        Needs::Sums
    }

    fn see(&mut self, simulation: &Simulation) {
        if self.species.is_empty() {
            return;
        }
        self.times.push(simulation.time);
        let relative = simulation.relative_to_flow();
        for of in &mut self.species {
            let own = only(&relative, of.species);
            let own = simulation.sample().with(&own);
            of.profiles.sample(simulation.time, own);
            let height = simulation.scene().domain.size.y;
            let spread = VelocitySpread::about(simulation.mean_velocity(), own, self.slices, height);
            of.count.push(spread.count());
            of.velocity.push(spread.mean().z);
            of.temperature.push(spread.temperature());
            if simulation.scene().species[usize::from(of.species)].sizes.is_some() {
                of.energy.push(energy(own, self.slices, height));
            }
        }
        self.impacts.push(simulation.record.kinds.totals());
    }

    plain_data!();
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Impacts of two kinds with this number of impacts and this prescribed restitution.
    fn met(count: u64, restitution_asked: f64) -> MeetingAverages {
        let between = ["a", "b"].map(String::from);
        MeetingAverages { between, count, rate: None, normal_speed: None, restitution_asked, restitution: None }
    }

    /// If runs are pooled, a prescribed restitution is averaged with the numbers of impacts as weights. It stays
    /// exactly as it is if it is equal in all runs.
    #[test]
    fn prescribed_restitutions_are_pooled() {
        let runs = [met(67, 0.8), met(75, 0.8), met(3, 0.8)];
        assert_eq!(
            MeetingAverages::pool(&runs[0], &[Some(&runs[0]), Some(&runs[1]), Some(&runs[2])], false).restitution_asked,
            0.8
        );
        let runs = [met(1, 0.5), met(3, 0.7)];
        let pooled = MeetingAverages::pool(&runs[0], &[Some(&runs[0]), None, Some(&runs[1])], false).restitution_asked;
        assert!((pooled - 0.65).abs() < 1e-15, "{pooled}");
        assert_eq!(weighted_mean(0.3, std::iter::empty()), 0.3);
    }

    /// If particles do not mix, standard errors come from the scatter between the runs. The values 1, 2 and 3 have the
    /// standard deviation 1, and their mean the error 1/sqrt(3).
    #[test]
    fn errors_come_from_the_runs_on_demand() {
        let run = |value: f64| MeetingAverages { rate: Some(Estimate::new(value, 1e-6)), ..met(1, 0.9) };
        let runs = [run(1.0), run(2.0), run(3.0)];
        let pooled = |by_runs: bool| {
            MeetingAverages::pool(&runs[0], &runs.iter().map(Some).collect::<Vec<_>>(), by_runs).rate.unwrap()
        };
        assert!((pooled(true).value - 2.0).abs() < 1e-15 && pooled(false).error.unwrap() < 1e-6);
        assert!((pooled(true).error.unwrap() - 3.0_f64.sqrt().recip()).abs() < 1e-12);
    }

    #[test]
    fn a_restitution_of_zero_is_a_known_value() {
        let run = |restitution: Option<f64>| MeetingAverages { restitution, ..met(2, 0.0) };
        let pooled = |one: Option<f64>, other: Option<f64>| {
            let runs = [run(one), run(other)];
            MeetingAverages::pool(&runs[0], &[Some(&runs[0]), Some(&runs[1])], false).restitution
        };
        assert_eq!((pooled(Some(0.0), Some(0.0)), pooled(None, None)), (Some(0.0), None));
        assert_eq!(pooled(Some(0.5), None), Some(0.5));
    }
}
