//! Chart of a scene with many particles. Every method runs one stretch (piece of the simulated time of the case). The
//! averages of each method are compared with those of a reference, as far as statistical errors allow. The reference
//! has exact collision instants.

use super::methods::{MethodSweep, work};
use super::outlook::Outlook;
use super::stretch::{SAMPLES, STARTS, Stretch};
use crate::experiment::Experiment;
use crate::outcome::Outcome;
use crate::output::numbers::quantity;
use crate::output::{ChartFailure, ChartPoint, ChartQuantity, CostSpread, PointError};
use crate::particles::Particles;
use crate::runs::{StudyError, execute, start};
use crate::statistics::{Estimate, SliceColumn, U, VV};
use std::time::Instant;

/// Scene with many particles in which a chart compares methods, together with the outcomes of the reference method.
pub struct Crowd {
    /// Piece of the simulated time of the case that every method of the chart runs.
    pub stretch: Stretch,
    /// Particles with which every method starts. The first run of the reference method begins the stretch (piece of
    /// simulated time) with the same particles.
    start: Particles,
    /// Outcomes of the runs of the reference method (with which all methods are compared), one for each seed.
    references: Vec<Outcome>,
    /// Description of the reference method for the reader, such as "hard spheres at exact instants".
    pub method: &'static str,
}

/// Function that takes one average from the outcome of a run; `None` if the outcome does not contain this average.
type OutcomeColumn = fn(&Outcome) -> Option<Estimate>;

/// Averages over the whole scene in which methods can be compared. Each has a key, a name, a label of the axis of
/// errors, a unit, and a function that takes the average from an outcome.
const NUMBERS: [(&str, &str, &str, &str, OutcomeColumn); 2] = [
    ("collision_rate", "pair impacts per time", "|rate − reference|/reference", "1/s", |o| o.pair_rate),
    ("temperature", "granular temperature", "|T − reference|/reference", "m²/s²", |o| o.temperature),
];

/// Profiles across the height of the box in which methods can be compared. Each has a key, a name, a label of the axis
/// of errors, and a column of the table of averages over slices of the box.
const PROFILES: [(&str, &str, &str, SliceColumn); 2] = [
    ("velocity_profile", "profile of the streamwise velocity U", "L₂ norm of U − reference, over that of U", U),
    (
        "normal_stress_profile",
        "profile of the wall-normal stress ⟨v″v″⟩",
        "L₂ norm of ⟨v″v″⟩ − reference, over that of ⟨v″v″⟩",
        VV,
    ),
];

impl Crowd {
    /// Runs the reference method: first the simulated time before the stretch (piece of time that every method runs),
    /// then the stretch. The reference is hard spheres at exact collision instants. If their engine fails, soft spheres
    /// with local fourth-order steps at N_c = 50 steps per contact take its place.
    ///
    /// # Errors
    /// Returns an error if the particles cannot be placed, or if neither method for the reference runs to the end.
    pub fn new(stretch: Stretch, outlook: &mut Outlook) -> Result<Self, StudyError> {
        let mut why = String::new();
        for (way, method) in stretch.ways() {
            outlook.restart();
            match Self::references(&way, method, &stretch, outlook)? {
                Ok((start, references)) => return Ok(Self { stretch, start, references, method }),
                Err(failure) => why = format!("{why}\n{method}: {failure}"),
            }
        }
        Err(StudyError::Failed(format!("error: no reference: neither model runs through this scene{why}")))
    }

    /// Runs the reference method `way` with several seeds. Returns the particles with which the first run begins the
    /// stretch (piece of time that every method runs), and the outcomes of all runs. The inner error is the failure of
    /// the first run that stopped.
    fn references(
        way: &Experiment,
        method: &str,
        stretch: &Stretch,
        outlook: &mut Outlook,
    ) -> Result<Result<(Particles, Vec<Outcome>), crate::engine::Failure>, StudyError> {
        let (mut first, mut outcomes) = (None, Vec::new());
        let before = stretch.before;
        let whole = before + way.run.duration;
        for seed in 0..STARTS as u64 {
            let clock = Instant::now();
            outlook.begin(format!("reference {}/{STARTS}, {method}", seed + 1));
            let mut lead = way.clone();
            lead.run.seed = way.run.seed.wrapping_add(seed);
            let mut state = start(&lead)?;
            if before > 0.0 {
                lead.run.duration = before;
                lead.run.window = Some(stretch.window);
                lead.statistics.sample_interval = Some(before / SAMPLES);
                let (outcome, end) = execute(&lead, state, &mut [&mut outlook.watching(0.0, whole)]);
                if let Some(why) = outcome.failure {
                    return Ok(Err(why));
                }
                state = end;
            }
            // each run has its own seed, so that random heating or turbulence differs between the runs of the reference
            let mut seeded = way.clone();
            seeded.run.seed = way.run.seed.wrapping_add(seed);
            let (outcome, _) = execute(&seeded, state.clone(), &mut [&mut outlook.watching(before, whole)]);
            if let Some(why) = outcome.failure {
                return Ok(Err(why));
            }
            first.get_or_insert(state);
            outcomes.push(outcome);
            outlook.end(&quantity(clock.elapsed().as_secs_f64(), "s", 2));
        }
        Ok(Ok((first.unwrap_or_default(), outcomes)))
    }

    /// Quantities in which the methods are compared. Each has a reference value, which is exact or a mean over the runs
    /// of the reference. Each also has a floor: the relative error that a run of the reference method has by chance.
    pub fn quantities(&self) -> Vec<ChartQuantity> {
        let mut quantities = Vec::new();
        let asked = self.stretch.experiment.scene.restitution_of_pairs();
        if let Some(asked) = asked.filter(|_| self.references.iter().all(|run| run.record.pairs.count > 0)) {
            quantities.push(ChartQuantity {
                key: "restitution",
                name: "realised restitution, mean over impacts of particles",
                axis: "|mean e − e₀|/e₀",
                reference: Estimate::exact(asked),
                unit: "",
                floor: 0.0,
            });
        }
        quantities.push(ChartQuantity {
            key: "energy",
            name: "energy ledger residual",
            axis: "|unexplained energy|/energy through the ledger",
            reference: Estimate::exact(0.0),
            unit: "",
            floor: 0.0,
        });
        for (key, name, axis, unit, pick) in NUMBERS {
            let values: Option<Vec<f64>> = self.references.iter().map(|run| Some(pick(run)?.value)).collect();
            let Some((mean, scatter)) = values.map(|values| spread(&values)) else { continue };
            if mean.value > 0.0 {
                let floor = scatter * (1.0 + 1.0 / STARTS as f64).sqrt() / mean.value;
                quantities.push(ChartQuantity { key, name, axis, reference: mean, unit, floor });
            }
        }
        for (key, name, axis, column) in PROFILES {
            let unit = column.unit;
            let mean = self.mean_profile(column);
            let size = norm(&mean);
            // in units of the variance, the mean squared distance of R runs from their own mean is (R-1)/R. For a
            // further run it is (R+1)/R, so `rms` is multiplied by the root of the ratio of these numbers
            let starts = STARTS as f64;
            let squares: f64 =
                self.references.iter().map(|run| norm(&differences(&profile(run, column), &mean)).powi(2)).sum();
            let rms = (squares / starts).sqrt();
            let floor = rms * ((starts + 1.0) / (starts - 1.0)).sqrt() / size;
            // a profile is left out if its scatter between runs is more than a third of its norm
            if size > 0.0 && floor < 1.0 / 3.0 {
                let slices = mean.iter().flatten().count().max(1) as f64;
                let error = rms / (starts - 1.0).sqrt() / slices.sqrt();
                let reference = Estimate::new(size / slices.sqrt(), error);
                quantities.push(ChartQuantity { key, name, axis, reference, unit, floor });
            }
        }
        quantities
    }

    /// Runs one method at the value `value` (SI unit) of its varied parameter. Returns the cost of the method, and its
    /// error in each quantity. `method` is the index of the method in the chart.
    pub fn point(
        &self,
        sweep: &MethodSweep,
        method: usize,
        value: f64,
        quantities: &[ChartQuantity],
        outlook: &mut Outlook,
    ) -> ChartPoint {
        let experiment = self.stretch.run_of(sweep, value);
        let whole = experiment.run.duration;
        let (outcome, _) = execute(&experiment, self.start.clone(), &mut [&mut outlook.watching(0.0, whole)]);
        let wall = outcome.timing.wall_seconds;
        let errors = match outcome.failure {
            Some(_) => Vec::new(),
            None => quantities.iter().map(|quantity| self.error(&outcome, quantity)).collect(),
        };
        ChartPoint {
            method,
            knob: value,
            samples: 1,
            wall: CostSpread { median: wall, lowest: wall, highest: wall },
            counters: outcome.counters,
            work: work(&outcome.counters),
            errors,
            failure: outcome.failure.map(ChartFailure::Engine),
        }
    }

    fn error(&self, outcome: &Outcome, quantity: &ChartQuantity) -> Option<PointError> {
        let single =
            |value: f64, error: f64, uncertainty: Option<f64>| PointError { value, error, uncertainty, range: None };
        let found = match quantity.key {
            "restitution" => {
                let (e, found) = (quantity.reference.value, outcome.pair_restitution?);
                let scale = if e > 0.0 { e } else { 1.0 };
                single(found.value, (found.value - e).abs() / scale, found.over(scale).error)
            }
            "energy" => {
                let found = outcome.energy_residual.over(outcome.record.ledger.through(outcome.energy_at_start));
                single(found.value, found.value.abs(), found.error)
            }
            key => {
                let number = NUMBERS.iter().find(|(known, ..)| *known == key).map(|(.., pick)| pick(outcome));
                if let Some(found) = number {
                    // the uncertainty is the larger of two numbers: the scatter between the runs of the reference, and
                    // the standard error of this run
                    let (found, share) = (found?, found?.over(quantity.reference.value));
                    let uncertainty = share.error.map_or(quantity.floor, |own| own.max(quantity.floor));
                    single(found.value, (share.value - 1.0).abs(), Some(uncertainty))
                } else {
                    let column = PROFILES.iter().find(|(known, ..)| *known == key).map(|(.., column)| *column)?;
                    let (mean, found) = (self.mean_profile(column), profile(outcome, column));
                    let slices = mean.iter().flatten().count().max(1) as f64;
                    let error = norm(&differences(&found, &mean)) / norm(&mean);
                    single(norm(&found) / slices.sqrt(), error, Some(quantity.floor))
                }
            }
        };
        found.error.is_finite().then_some(found)
    }

    /// Mean profile of the reference method. A profile is a column of the table of averages over slices of the box
    /// across y; it is averaged over all runs of the reference. There is one value per slice, in the unit of the
    /// column; `None` in a slice that is empty in at least one run.
    fn mean_profile(&self, column: SliceColumn) -> Vec<Option<f64>> {
        let mut sums: Vec<Option<f64>> = Vec::new();
        for run in &self.references {
            let values = profile(run, column);
            if sums.is_empty() {
                sums = values;
            } else {
                let both = sums.iter().zip(values).map(|(sum, value)| Some((*sum)? + value?));
                sums = both.collect();
            }
        }
        sums.iter().map(|sum| Some((*sum)? / self.references.len() as f64)).collect()
    }

    /// True if the runs of the reference, which have different seeds, end in different final states.
    pub fn is_random(&self) -> bool {
        self.references.iter().any(|run| run.final_state_hash != self.references[0].final_state_hash)
    }
}

/// Profile from one run: a column of the table of averages over slices of the box across y, in the unit of the column.
/// There is one value per slice; `None` in a slice in which no particle was measured.
fn profile(outcome: &Outcome, column: SliceColumn) -> Vec<Option<f64>> {
    outcome.profiles.slices.iter().map(|row| Some(row.of(column)?.value)).collect()
}

fn differences(values: &[Option<f64>], from: &[Option<f64>]) -> Vec<Option<f64>> {
    values.iter().zip(from).map(|(value, from)| Some((*value)? - (*from)?)).collect()
}

/// Root of the sum of squares of the values of a profile. Missing values (`None`) are left out.
fn norm(values: &[Option<f64>]) -> f64 {
    values.iter().flatten().map(|value| value * value).sum::<f64>().sqrt()
}

/// Mean of independent values with its standard error, and the standard deviation of one value.
fn spread(values: &[f64]) -> (Estimate, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let deviation = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0)).sqrt();
    (Estimate::new(mean, deviation / count.sqrt()), deviation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spread_of_samples_is_theirs() {
        let (mean, deviation) = spread(&[1.0, 2.0, 3.0, 6.0]);
        assert_eq!(mean.value, 3.0);
        assert!(
            (deviation - (14.0f64 / 3.0).sqrt()).abs() < 1e-15 && (mean.error.unwrap() - deviation / 2.0).abs() < 1e-15
        );
        assert_eq!(norm(&[Some(3.0), None, Some(4.0)]), 5.0);
    }
}
