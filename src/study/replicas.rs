//! `--replicas`: runs one variant with several seeds, and averages the results to one outcome. A variant is one of the
//! experiments of a case.

use crate::experiment::{Amount, Experiment};
use crate::observe::{KindAverages, Observation};
use crate::outcome::{Averaged, Outcome, Replicas};
use crate::runs::StudyError;
use crate::statistics::{Batches, Estimate, FEWEST_RUNS, ProfileTable, U};

/// Experiments of all replicas (runs with different seeds) of a variant (experiment of a case). The first has the seed
/// of the case, and each further one the next larger seed.
///
/// # Errors
/// Returns an error if all particles start at given positions, since the replicas would then be equal.
pub fn replicas(experiment: &Experiment, count: u16) -> Result<Vec<Experiment>, StudyError> {
    if count > 1 && experiment.start.iter().all(|population| matches!(population.amount, Amount::Placed(_))) {
        return Err(StudyError::Input(format!(
            "error: --replicas {count}: all particles of \"{}\" start at given places, so that all replicas would be the same run\n\
             help: leave out --replicas, or let particles start at random (`count` or `volume_fraction`)",
            experiment.name
        )));
    }
    let one = |number: u16| {
        let mut replica = experiment.clone();
        replica.run.seed = experiment.run.seed.wrapping_add(u64::from(number));
        replica
    };
    Ok((0..count).map(one).collect())
}

/// Pools the replicas (runs with different seeds) of a variant (experiment of a case) into one outcome. Returns this
/// outcome, and the separate outcomes of the replicas after the first one. Profiles, temperature, rates, averages of
/// species and measurements are averages over the replicas. The outcome is steady if more than half of the replicas
/// are steady. Other results, such as times and energy balances, are those of the first replica that has not failed.
/// Failed replicas are left out unless all have failed. If any replica has failed, the outcome contains the failure
/// of the first of these.
pub fn pool(first: Outcome, others: Vec<Outcome>) -> (Outcome, Vec<Outcome>) {
    let failure = std::iter::once(&first).chain(&others).find_map(|run| run.failure.clone());
    let (mut rest, failed): (Vec<Outcome>, Vec<Outcome>) = others.into_iter().partition(|run| run.failure.is_none());
    if first.failure.is_some() && rest.is_empty() {
        return (first, failed);
    }
    let first = if first.failure.is_some() { rest.remove(0) } else { first };
    let mut outcome = merge(&first, &rest);
    outcome.failure = failure;
    (outcome, rest)
}

/// [-] largest share of particles that may stay in their layer (slice of the height y) during averaging. With a larger
/// share, averages of one run are not valid for other runs. The share has an uncertainty of about 0.05.
pub const FROZEN: f64 = 0.2;

fn merge(first: &Outcome, others: &[Outcome]) -> Outcome {
    if others.is_empty() {
        return first.clone();
    }
    let all: Vec<&Outcome> = std::iter::once(first).chain(others).collect();
    let kept = all.iter().filter_map(|run| run.places_kept);
    let places_kept = kept.reduce(f64::max);
    // if particles do not mix, the errors of averages follow only from the scatter between runs
    let by_runs = places_kept.is_some_and(|kept| kept > FROZEN) && all.len() >= FEWEST_RUNS;
    let pooled = |of: fn(&Averaged) -> &Option<Batches>| {
        let runs: Option<Vec<&Batches>> = all.iter().map(|run| of(&run.averaged).as_ref()).collect();
        Batches::pool(&runs?, by_runs)
    };
    let averaged = Averaged {
        pair_rate: pooled(|averaged| &averaged.pair_rate),
        wall_rate: pooled(|averaged| &averaged.wall_rate),
        temperature: pooled(|averaged| &averaged.temperature),
        shear_stress: pooled(|averaged| &averaged.shear_stress),
        replicas: Some(Replicas { count: all.len(), scatter_over_errors: scatter_over_errors(&all) }),
    };
    let profiles = ProfileTable::pool(&all.iter().map(|run| &run.profiles).collect::<Vec<_>>(), by_runs);
    let steady = all.iter().filter(|run| run.steadiness.steady).count();
    let estimate = |batches: &Option<Batches>| batches.as_ref().and_then(Batches::estimate);
    let mut outcome = first.clone();
    outcome.pair_rate = estimate(&averaged.pair_rate);
    outcome.wall_rate = estimate(&averaged.wall_rate);
    outcome.temperature = estimate(&averaged.temperature);
    // one steady run in twenty appears unsteady by chance
    outcome.steadiness.steady = 2 * steady > all.len();
    outcome.places_kept = places_kept;
    outcome.profiles = profiles;
    outcome.kinds = KindAverages::pool(&all.iter().map(|run| &run.kinds).collect::<Vec<_>>(), by_runs);
    outcome.rings.profiles =
        ProfileTable::pool(&all.iter().map(|run| &run.rings.profiles).collect::<Vec<_>>(), by_runs);
    outcome.observations =
        Observation::pool(&all.iter().map(|run| run.observations.as_slice()).collect::<Vec<_>>(), by_runs);
    outcome.averaged = averaged;
    outcome
}

/// [-] standard deviation of an average from run to run, divided by the standard error that is estimated within each
/// run. The result is the root mean square of this ratio over the bulk velocity, the temperature and the impact rates,
/// as far as they are known. `None` if none of these is known.
fn scatter_over_errors(runs: &[&Outcome]) -> Option<f64> {
    let of = |run: &Outcome| -> [Option<Estimate>; 4] {
        let count = run.profiles.slices.len() as f64;
        let slices: Option<Vec<&Batches>> =
            (0..run.profiles.slices.len()).map(|slice| run.profiles.batches(slice, U)).collect();
        let joined = slices.and_then(Batches::join);
        let bulk = joined.map(|slices| slices.project(&[vec![1.0 / count; slices.values.len()]]));
        [bulk.as_ref().and_then(Batches::estimate), run.temperature, run.pair_rate, run.wall_rate]
    };
    let all: Vec<_> = runs.iter().map(|run| of(run)).collect();
    let ratio = |which: usize| {
        let known: Option<Vec<(f64, f64)>> =
            all.iter().map(|one| one[which].and_then(|found| Some((found.value, found.error?)))).collect();
        let known = known?;
        let count = known.len() as f64;
        let centre = known.iter().map(|one| one.0).sum::<f64>() / count;
        let between = known.iter().map(|one| (one.0 - centre).powi(2)).sum::<f64>() / (count - 1.0);
        let within = known.iter().map(|one| one.1 * one.1).sum::<f64>() / count;
        // differences by rounding do not count as scatter
        (within.sqrt() > 1e-12 * centre.abs()).then(|| between / within)
    };
    let ratios: Vec<f64> = (0..4).filter_map(ratio).collect();
    (!ratios.is_empty()).then(|| (ratios.iter().sum::<f64>() / ratios.len() as f64).sqrt())
}
