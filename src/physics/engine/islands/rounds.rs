//! Rounds in which islands (groups of particles that may meet) are solved. The rounds end when no member has met an
//! unexpected particle or exceeded its speed limit.

use super::batch::{Batch, GivenUp, IslandResult, Retry, Task, Workbench};
use super::cluster::IslandFinder;
use super::{BATCH, IslandCounters, Solve};
use crate::work_sharing;

/// Solves all islands (groups of particles that may meet), and solves those again in which a member met an unexpected
/// particle or exceeded its speed limit. An island that costs too much is solved again as a crowd (by uniform steps),
/// if the engine takes crowds. Returns the valid results with the counts of work; `None` if an island is too large or,
/// without crowds, costs too much, or if the engine fails in one. `mine` returns true for the index of a particle that
/// belongs to this process. An island is counted only if its leader (the member with the smallest id) belongs to this
/// process.
pub fn solve_all<S: Solve>(
    islands: &mut S::Finder<'_>,
    task: &Task<S>,
    mine: impl Fn(u32) -> bool,
) -> Option<(Vec<Batch<S::Carried>>, IslandCounters)> {
    let mut counts = IslandCounters::default();
    let mut batches: Vec<Batch<S::Carried>> = Vec::new();
    let mut todo = islands.unsolved();
    while !todo.is_empty() {
        let found = &*islands;
        let solve = |bench: &mut Workbench<S>, some: &[usize]| {
            let mut batch = Batch::of(found, some);
            for &which in some {
                let stopped = match bench.fill(task, found, which) {
                    Some((island, scratch)) => task.solver.solve(island, scratch, task.scene, task.window, task.part),
                    None => Err(GivenUp::Failed),
                };
                bench.record(&mut batch, found, which, stopped);
            }
            batch
        };
        let solved: Vec<Batch<S::Carried>> = work_sharing::map_with(todo.chunks(BATCH), Workbench::default, solve);
        let mut retries = Vec::new();
        for mut batch in solved {
            for (number, solved) in batch.solved.iter_mut().enumerate() {
                let which = solved.which;
                let counted = islands.leader(which).is_some_and(&mine);
                if counted {
                    counts.count(solved);
                }
                let retry = match std::mem::replace(&mut solved.stopped, Ok(Vec::new())) {
                    Ok(stops) if stops.is_empty() => {
                        islands.keep(which, IslandResult { batch: batches.len(), number, counts: counted });
                        islands.follow(which, solved.ways.clone(), &batch.trajectories);
                        continue;
                    }
                    Ok(stops) => Retry::Stops(stops),
                    Err(GivenUp::TooExpensive) if task.solver.takes_crowds() => Retry::Crowd,
                    // the caller then uses the classical algorithm, which stops at the time of the failure
                    Err(_) => return None,
                };
                counts.redone += u64::from(counted);
                retries.push((which, retry));
            }
            batches.push(batch);
        }
        counts.redone += islands.next_round(retries, &mine)?;
        todo = islands.unsolved();
    }
    Some((batches, counts))
}
