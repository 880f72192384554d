//! Impacts in each interval between two samples (instants of measurement), and impacts of the averaging period.

use super::{Needs, Observer, plain_data};
use crate::experiment::{AverageFrom, Experiment};
use crate::record::{Impacts, Record};
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::{Batches, Estimate, FEWEST_BLOCKS, estimate};
use serde::{Deserialize, Serialize};

/// Number of equal parts of a run. If the start of averaging is to be detected after the run
/// ([`judge`](crate::statistics::judge)), it will be in the first half of the run. The sums of the impacts are then
/// stored at the ends of the parts in this half, since averaging may begin near any of them.
const MARKS: u64 = 40;

/// Number of impacts and sums of their squared speeds, from the start of the run to one sample (instant of
/// measurement).
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct ImpactSample {
    count: u64,
    /// [m²/s²] sum of the squares of the normal speeds before the impacts.
    approach: f64,
    /// [m²/s²] sum of the squares of the normal speeds after the impacts.
    rebound: f64,
}

impl ImpactSample {
    fn of(impacts: &Impacts) -> Self {
        let (approach, rebound) = (impacts.normal_speed.sum_of_squares(), impacts.rebound_squares());
        Self { count: impacts.count, approach, rebound }
    }

    fn since(&self, before: &Self) -> Self {
        Self {
            count: self.count - before.count,
            approach: self.approach - before.approach,
            rebound: self.rebound - before.rebound,
        }
    }
}

/// Number of impacts and sums of their squared speeds, from the start to every sample (instant of measurement). The
/// impacts are either those between particles or those on walls.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ImpactSeries {
    on_walls: bool,
    average_from: AverageFrom,
    /// [s] duration of the whole run.
    duration: f64,
    schedule: Schedule,
    samples: Vec<ImpactSample>,
    /// Times [s] at which averaging begins or, if its start is detected, may begin. Each time has the statistics of
    /// all impacts from the start to this time.
    marks: Vec<(f64, Impacts)>,
}

impl ImpactSeries {
    /// Creates the measurement of the impacts between particles, before the start of the run.
    pub fn of_pairs(experiment: &Experiment, schedule: &Schedule) -> Self {
        Self {
            on_walls: false,
            average_from: experiment.run.average_from,
            duration: experiment.run.duration,
            schedule: *schedule,
            samples: Vec::new(),
            marks: Vec::new(),
        }
    }

    /// Creates the measurement of the impacts on walls, before the start of the run.
    pub fn of_walls(experiment: &Experiment, schedule: &Schedule) -> Self {
        Self { on_walls: true, ..Self::of_pairs(experiment, schedule) }
    }

    fn of<'a>(&self, record: &'a Record) -> &'a Impacts {
        if self.on_walls { &record.walls } else { &record.pairs }
    }

    /// True if averaging may begin at the present instant of measurement, `time` [s]. The statistics of the impacts
    /// until then must be stored in this case.
    fn begins(&self, time: f64) -> bool {
        match self.average_from {
            // 1e-9 allows for the rounding of a sum of windows
            AverageFrom::Time(from) => self.marks.is_empty() && time >= from * (1.0 - 1e-9),
            AverageFrom::Steady => {
                let apart = (self.schedule.samples / MARKS).max(1);
                (self.samples.len() as u64).is_multiple_of(apart) && time <= 0.5 * self.duration
            }
        }
    }

    /// Number of impacts and sums of their squared speeds, in each interval between two instants of measurement.
    fn intervals(&self) -> impl Iterator<Item = ImpactSample> {
        self.samples.windows(2).map(|pair| pair[1].since(&pair[0]))
    }

    /// Impacts of the averaging period. It begins at the first time at or after `from` [s] at which the statistics of
    /// the impacts were stored. If all these times are earlier than `from`, the last one is used. If there are none,
    /// no impacts are returned.
    pub fn since(&self, from: f64, record: &Record) -> Impacts {
        let begun = self.marks.iter().find(|(time, _)| *time >= from * (1.0 - 1e-9)).or(self.marks.last());
        begun.map_or_else(Impacts::default, |(_, before)| self.of(record).since(before))
    }

    /// [1/s] mean impact rate from the sample (instant of measurement) with the index `first` to the end; `None` if
    /// this sample is the last one.
    pub fn rate(&self, first: usize) -> Option<Estimate> {
        estimate(&self.rates(first))
    }

    /// [1/s] impact rate in each interval between two successive samples (instants of measurement), from the sample
    /// with the index `first` to the end.
    fn rates(&self, first: usize) -> Vec<f64> {
        let interval = self.schedule.interval();
        self.intervals().skip(first).map(|totals| totals.count as f64 / interval).collect()
    }

    /// Impact rate [1/s] in blocks of time from the sample (instant of measurement) with the index `first` on, whose
    /// time is `from` [s]. `None` if this sample is the last one. The time of each rate is the end of its interval.
    pub fn batches(&self, first: usize, from: f64) -> Option<Batches> {
        let interval = self.schedule.interval();
        Batches::of_series(&self.rates(first), interval, from + interval)
    }

    /// [-] realised restitution e: square root of the ratio of normal energies after and before the impacts, both
    /// summed over all impacts. The standard error follows from the scatter, between intervals of time, of Σ u'² - e²
    /// Σ u². Here u and u' are the normal speeds before and after an impact. `None` without an impact.
    pub fn restitution(&self) -> Option<Estimate> {
        let intervals: Vec<ImpactSample> = self.intervals().collect();
        let before: f64 = intervals.iter().map(|totals| totals.approach).sum();
        if before <= 0.0 {
            return None;
        }
        let square = intervals.iter().map(|totals| totals.rebound).sum::<f64>() / before;
        let value = square.sqrt();
        let busy = intervals.iter().filter(|totals| totals.approach > 0.0).count();
        if busy < FEWEST_BLOCKS {
            return Some(Estimate::without_error(value));
        }
        let beyond: Vec<f64> = intervals.iter().map(|totals| totals.rebound - square * totals.approach).collect();
        // error of e from the error of e²: δ(e²) = 2 e δe
        let error = estimate(&beyond).and_then(|mean| mean.error);
        let error = error.map(|error| error * intervals.len() as f64 / before / (2.0 * value));
        Some(Estimate { value, error })
    }
}

impl Observer for ImpactSeries {
    fn needs(&self) -> Needs {
        Needs::Sums
    }

    fn see(&mut self, simulation: &Simulation) {
        if self.begins(simulation.time) {
            self.marks.push((simulation.time, self.of(&simulation.record).clone()));
        }
        self.samples.push(ImpactSample::of(self.of(&simulation.record)));
    }

    plain_data!();
}
