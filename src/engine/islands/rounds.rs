//! Rounds in which islands are solved, until none has met an unexpected particle or speed.

use super::batch::{Batch, GivenUp, IslandResult, Retry, Task, Workbench};
use super::cluster::Clusters;
use super::{BATCH, IslandCounters, Solve};
use crate::work_sharing;

/// Solves all islands, and those again that met something unexpected. Returns `None` if one grows too large or the
/// engine fails in one. The counts cover the islands whose leading particle is chosen by `mine`.
pub fn solve_all<S: Solve>(
    clusters: &mut Clusters,
    task: &Task<S>,
    mine: impl Fn(u32) -> bool,
) -> Option<(Vec<Batch<S::Carried>>, IslandCounters)> {
    let mut counts = IslandCounters::default();
    let mut batches: Vec<Batch<S::Carried>> = Vec::new();
    let mut todo = clusters.unsolved();
    while !todo.is_empty() {
        let islands = &*clusters;
        let solve = |bench: &mut Workbench<S>, which: &[usize]| bench.solve(task, islands, which);
        let solved: Vec<Batch<S::Carried>> = work_sharing::map_with(todo.chunks(BATCH), Workbench::default, solve);
        let mut retries = Vec::new();
        for mut batch in solved {
            for (number, solved) in batch.solved.iter_mut().enumerate() {
                let which = solved.which;
                let counted = clusters.leader(which).is_some_and(&mine);
                if counted {
                    counts.count(solved);
                }
                let lesson = match std::mem::replace(&mut solved.stopped, Ok(Vec::new())) {
                    Ok(stops) if stops.is_empty() => {
                        clusters.keep(which, IslandResult { batch: batches.len(), number, counts: counted });
                        clusters.follow(which, &batch.ways[solved.ways.clone()], &batch.turns);
                        continue;
                    }
                    Ok(stops) => Retry::Stops(stops),
                    Err(GivenUp::TooExpensive) if task.solver.takes_crowds() => Retry::Crowd,
                    // left to the classical algorithm, which stops at the instant of the failure
                    Err(_) => return None,
                };
                counts.redone += u64::from(counted);
                retries.push((which, lesson));
            }
            batches.push(batch);
        }
        if !clusters.apply_retries(retries) {
            return None;
        }
        counts.redone += clusters.meet(&mine)?;
        todo = clusters.unsolved();
    }
    Some((batches, counts))
}
